//! The standing waves of one rail on a ring of equal bays.
//!
//! On a ring of N bays of length L a wave and its neighbours of other zones, `k_j = 2 pi (p + j N) / (N L)`, are coupled by the supports and by nothing else,
//! and cosines never with sines. With the amplitudes W_j of the deflection, P_j of the turn of the section and Z of the sleepers,
//!
//! ```text
//! w = sum_j W_j cos k_j x    psi = -sum_j P_j sin k_j x    z_m = Z cos k_0 m L            (even; odd: sine, cosine, sine)
//! kinetic    L sum_j a_j (rho A W_j'^2 + rho I P_j'^2) + s m_s Z'^2                       per bay, twice
//! stored     L sum_j a_j (EI k_j^2 P_j^2 + kappa G A (k_j W_j - P_j)^2) + s (k_p (sum_j W_j - Z)^2 + k_b Z^2)
//! ```
//!
//! a_j and s are means of the squares along the rail and over the sleepers: 1/2, but 1 for k = 0 and where all sleepers swing by the same (p = 0 and N / 2, even), and
//! s = 0 for the odd ones of those: the rail then swings between sleepers at rest (for p = N / 2 that is the pinned-pinned wave of length 2 L).

use super::Bay;
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// Harmonics of a bay, the mean among them, by which what is left out changes along the rail.
pub(super) const HARMONICS: usize = 4;
/// Zones on either side of the first.
pub(super) const ZONES: i32 = 12;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Parity {
    Even,
    Odd,
}

/// One undamped mode of modal mass 1 kg.
#[derive(Clone, Debug)]
pub(super) struct Wave {
    /// omega^2, 1/s2.
    pub square: f64,
    /// W_j, by wave number.
    pub amplitudes: Vec<f64>,
    /// Shortening of the pads, and Z, at a sleeper that swings most.
    pad: f64,
    sleeper: f64,
    /// Of its stored energy that is in the rail.
    in_rail: f64,
}

/// Modes that damping may couple.
#[derive(Clone, Debug)]
pub(super) struct Family {
    /// Wave number that all have in common, and all of them, rad/m.
    pub phase: f64,
    pub numbers: Vec<f64>,
    pub waves: Vec<Wave>,
    /// Damping matrix by rows, 1/s.
    pub damping: Vec<f64>,
    /// Of those above, even and odd ones: phi^2 / omega^2 as a sum of cosines of n 2 pi x / L, m/N, and the mean of phi^2 / omega^4, m s2/N.
    pub above: ([f64; HARMONICS], f64),
}

/// The modes of class `p` of a ring of `bays` whose frequencies are at most `highest` [rad/s].
pub(super) fn family(bay: &Bay, bays: usize, p: usize, parity: Parity, highest: f64) -> Family {
    let phase = TAU * p as f64 / (bays as f64 * bay.spacing);
    // Where a wave is its own mirror image, one of both directions says all.
    let alone = p == 0 || 2 * p == bays;
    let zones = if alone { 0..=ZONES } else { -ZONES..=ZONES };
    let numbers: Vec<f64> =
        zones.map(|j| phase + TAU * f64::from(j) / bay.spacing).filter(|k| *k != 0.0 || parity == Parity::Even).collect();
    let sleepers = match (alone, parity) {
        (true, Parity::Even) => 1.0,
        (true, Parity::Odd) => 0.0,
        (false, _) => 0.5,
    };
    let count = numbers.len();
    let (size, turn, sleeper) = (2 * count + 1, count, 2 * count);
    let mean = |k: f64| if k == 0.0 { 1.0 } else { 0.5 };
    let mut mass = vec![1.0; size];
    let mut stiffness = DMatrix::<f64>::zeros(size, size);
    for (j, k) in numbers.iter().enumerate() {
        let share = bay.spacing * mean(*k);
        (mass[j], mass[turn + j]) = (share * bay.mass, share * bay.rotary);
        stiffness[(j, j)] += share * bay.shear * k * k;
        stiffness[(j, turn + j)] -= share * bay.shear * k;
        stiffness[(turn + j, j)] -= share * bay.shear * k;
        stiffness[(turn + j, turn + j)] += share * (bay.bending * k * k + bay.shear);
    }
    mass[sleeper] = bay.sleeper_mass * if sleepers > 0.0 { sleepers } else { 1.0 };
    for i in (0..count).chain([sleeper]) {
        for j in (0..count).chain([sleeper]) {
            let sign = if (i == sleeper) == (j == sleeper) { 1.0 } else { -1.0 };
            stiffness[(i, j)] += sign * sleepers * bay.pad_stiffness;
        }
    }
    stiffness[(sleeper, sleeper)] += sleepers * bay.ballast_stiffness;
    let roots: Vec<f64> = mass.iter().map(|mass| mass.sqrt()).collect();
    let scaled = DMatrix::from_fn(size, size, |i, j| stiffness[(i, j)] / (roots[i] * roots[j]));
    let found = scaled.symmetric_eigen();
    let mut order: Vec<usize> = (0..size).collect();
    order.sort_by(|a, b| found.eigenvalues[*a].total_cmp(&found.eigenvalues[*b]));
    let whole = (bays as f64).sqrt();
    let mode = |index: usize| {
        let vector = found.eigenvectors.column(index);
        // Its sign is not the solver's affair.
        let largest = (0..count).fold(0, |best, i| if vector[i].abs() > vector[best].abs() * (1.0 + 1e-9) { i } else { best });
        let sign = if vector[largest] < 0.0 { -1.0 } else { 1.0 };
        let amplitudes: Vec<f64> = (0..count).map(|i| sign * vector[i] / (roots[i] * whole)).collect();
        let swing = if sleepers > 0.0 { sign * vector[sleeper] / (roots[sleeper] * whole) } else { 0.0 };
        let pad = amplitudes.iter().sum::<f64>() - swing;
        let square = found.eigenvalues[index];
        let supports = bays as f64 * sleepers * (bay.pad_stiffness * pad * pad + bay.ballast_stiffness * swing * swing);
        Wave { square, amplitudes, pad, sleeper: swing, in_rail: (1.0 - supports / square).clamp(0.0, 1.0) }
    };
    // A turn of all sections that bends nothing (k = 0) and a sleeper that nothing holds are no waves of the rail.
    let moves = |wave: &Wave| wave.square > 1.0 && wave.amplitudes.iter().any(|amplitude| amplitude.abs() * whole > 1e-9);
    let (waves, others): (Vec<Wave>, Vec<Wave>) =
        order.into_iter().map(mode).filter(moves).partition(|wave| wave.square <= highest * highest);
    let mut above = ([0.0; HARMONICS], 0.0);
    for wave in &others {
        let size = squared(&wave.amplitudes, &numbers, (bay.spacing, alone.then_some(parity)));
        above.0.iter_mut().zip(size).for_each(|(sum, size)| *sum += size / wave.square);
        above.1 += size[0] / (wave.square * wave.square);
    }
    let damping = waves.iter().enumerate().flat_map(|(i, own)| {
        waves.iter().enumerate().map(move |(j, other)| {
            let supports = bay.pad_damping * own.pad * other.pad + bay.ballast_damping * own.sleeper * other.sleeper;
            let rail = if i == j { bay.loss * own.in_rail * own.square.sqrt() } else { 0.0 };
            bays as f64 * sleepers * supports + rail
        })
    });
    Family { phase, damping: damping.collect(), numbers, waves, above }
}

/// phi^2 as a sum of cosines of n 2 pi x / L, with that of the other parity where the family has both: `cos a cos b = (cos(a - b) + cos(a + b)) / 2`, and for sines the sum counts less.
fn squared(amplitudes: &[f64], numbers: &[f64], (spacing, alone): (f64, Option<Parity>)) -> [f64; HARMONICS] {
    let mut sum = [0.0; HARMONICS];
    let mut add = |k: f64, value: f64| {
        let harmonic = (k * spacing / TAU).round().abs() as usize;
        if let Some(sum) = sum.get_mut(harmonic) {
            *sum += value;
        }
    };
    for (k, own) in numbers.iter().zip(amplitudes) {
        for (l, other) in numbers.iter().zip(amplitudes) {
            let product = own * other;
            match alone {
                None => add(k - l, product),
                Some(parity) => {
                    add(k - l, 0.5 * product);
                    add(k + l, if parity == Parity::Even { 0.5 * product } else { -0.5 * product });
                }
            }
        }
    }
    sum
}
