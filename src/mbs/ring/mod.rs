//! One rail on sleepers as modes of a ring: a Timoshenko beam on pads, sleepers and ballast that closes in itself after N bays.
//!
//! Deflection w (up) and turn psi of the sections, slope by shear `w' - psi`; at each sleeper, spacing L, a pad (k_p, c_p), a sleeper of mass m_s and ballast (k_b, c_b):
//!
//! ```text
//! rho A w''   = (kappa G A (w' - psi))' - sum_m delta(x - m L) f_m + F delta(x - x_F)       (' along the rail or in time)
//! rho I psi'' = (EI psi')' + kappa G A (w' - psi)
//! m_s z_m'' = f_m - k_b z_m - c_b z_m',   f_m = k_p (w - z_m) + c_p (w' - z_m')
//! ```
//!
//! The vehicle goes round: its distance counts modulo N L. That is right where waves have died out before they come round ([`Bay::least_decay`]), which is stated by receptances
//! against longer rings (docs/model.md). With the undamped modes phi_i (`waves`) of frequencies omega_i up to a highest one, `w = sum_i phi_i(x) q_i`, and forces F_c of wheels at x_c on the rail
//!
//! ```text
//! q'' = -omega^2 q - C q' + sum_c phi(x_c) F_c        C: dense within the few modes of a wave number, zero between them
//! ```
//!
//! The same phi takes the force and gives the displacement, so that energy is kept whatever was left out. *Damping:* that of pads and ballast is viscous; a rail's own
//! loss factor eta adds `eta omega_i` to C_ii in proportion to the energy that the mode stores in the rail.
//! *Modes above the highest frequency* give way where a force stands, mostly by shear; what they do there far below their own frequencies is that of one mass on a spring
//! ([`LeftOut`]), with a shape of its own along the bay. Zones beyond those that are kept (`waves`) add `1 / (pi kappa G A k)` at rest.

mod decay;
mod response;
mod shapes;
mod waves;

use shapes::Table;
use std::f64::consts::{PI, TAU};
use waves::{Family, Parity};

/// The least that its shape may be, in parts of its mean.
const LEAST_SHAPE: f64 = 1e-3;

/// Length of rail that a blow's waves take, m.
const PACKET: f64 = 1.5;

/// One bay of one rail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bay {
    /// EI, N m2, and kappa G A, N.
    pub bending: f64,
    pub shear: f64,
    /// rho A, kg/m, and rho I, kg m.
    pub mass: f64,
    pub rotary: f64,
    /// eta of the rail, -.
    pub loss: f64,
    /// L, m.
    pub spacing: f64,
    /// Per pad, N/m and N s/m.
    pub pad_stiffness: f64,
    pub pad_damping: f64,
    /// What of a sleeper swings with one rail, kg.
    pub sleeper_mass: f64,
    /// Under that, N/m and N s/m.
    pub ballast_stiffness: f64,
    pub ballast_damping: f64,
}

/// Modes that are coupled by C, one after the other.
#[derive(Clone, Copy, Debug)]
struct Block {
    first: usize,
    count: usize,
    /// Where its matrix begins.
    matrix: usize,
}

/// The modes of the ring.
#[derive(Debug)]
pub struct Ring {
    bay: Bay,
    bays: usize,
    /// omega^2 by mode, 1/s2.
    squares: Vec<f64>,
    blocks: Vec<Block>,
    /// C by block; cosines and sines of a wave share one.
    damping: Vec<f64>,
    families: Vec<Placed>,
    table: Table,
    /// Largest |phi| by mode, and the mean of sum phi^2 along the rail, 1/kg.
    largest: Vec<f64>,
    mobility: f64,
    left_out: LeftOut,
}

/// What modes above the highest frequency give way where a force stands: a spring, and the mass with which it answers as they do up to the second power of the frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeftOut {
    /// Sum of phi^2 / omega^2, mean along the rail, m/N.
    pub compliance: f64,
    /// The same by harmonics of a bay, in parts of that.
    along: [f64; waves::HARMONICS],
    /// 2 pi / L, rad/m.
    number: f64,
    /// Sum of phi^2 / omega^2 over that of phi^2 / omega^4, 1/s2.
    pub square: f64,
}

impl LeftOut {
    /// The shape, 1 on average, and its slope, 1/m, at a place [m]: the root of what gives way there over the mean of that.
    pub fn shape(&self, x: f64) -> [f64; 2] {
        let (mut value, mut slope) = (0.0, 0.0);
        for (n, part) in self.along.iter().enumerate() {
            let k = n as f64 * self.number;
            let (sin, cos) = (k * x).sin_cos();
            (value, slope) = (value + part * cos, slope - k * part * sin);
        }
        let root = value.max(0.0).sqrt().max(LEAST_SHAPE);
        [root, 0.5 * slope / root]
    }
}

/// A family and where its modes stand.
#[derive(Debug)]
struct Placed {
    family: Family,
    even: Option<usize>,
    odd: Option<usize>,
}

impl Ring {
    /// The modes of a ring of `bays`, an even number, up to a frequency [rad/s].
    pub fn new(bay: &Bay, bays: usize, highest: f64) -> Ring {
        let (mut squares, mut blocks, mut damping, mut families) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut above = ([0.0; waves::HARMONICS], 0.0);
        let mut put = |family: &Family, matrix: usize| {
            let (first, count) = (squares.len(), family.waves.len());
            squares.extend(family.waves.iter().map(|wave| wave.square));
            blocks.push(Block { first, count, matrix });
            first
        };
        for p in 0..=bays / 2 {
            let alone = p == 0 || 2 * p == bays;
            for parity in [Parity::Even, Parity::Odd] {
                if parity == Parity::Odd && !alone {
                    continue;
                }
                let family = waves::family(bay, bays, p, parity, highest);
                above.0.iter_mut().zip(family.above.0).for_each(|(sum, own)| *sum += own);
                above.1 += family.above.1;
                if family.waves.is_empty() {
                    continue;
                }
                let matrix = damping.len();
                damping.extend_from_slice(&family.damping);
                let even = (parity == Parity::Even).then(|| put(&family, matrix));
                let odd = (parity == Parity::Odd || !alone).then(|| put(&family, matrix));
                families.push(Placed { family, even, odd });
            }
        }
        let table = Table::new(bay.spacing, families.iter().map(|placed| &placed.family));
        let beyond = TAU * (f64::from(waves::ZONES) + 0.5) / bay.spacing;
        above.0[0] += 1.0 / (PI * bay.shear * beyond);
        let compliance = above.0[0];
        let left_out =
            LeftOut { compliance, along: above.0.map(|part| part / compliance), number: TAU / bay.spacing, square: compliance / above.1 };
        let largest = vec![0.0; squares.len()];
        let mut ring = Ring { bay: *bay, bays, blocks, damping, families, table, largest, mobility: 0.0, left_out, squares };
        ring.sample();
        ring
    }

    /// Finds how large the shapes are.
    fn sample(&mut self) {
        const SAMPLES: usize = 8;
        let (mut shape, mut slope) = (vec![0.0; self.modes()], vec![0.0; self.modes()]);
        let count = SAMPLES * self.bays;
        for index in 0..count {
            self.shapes(self.length() * (index as f64 + 0.5) / count as f64, &mut shape, &mut slope);
            self.mobility += shape.iter().map(|phi| phi * phi).sum::<f64>() / count as f64;
            self.largest.iter_mut().zip(&shape).for_each(|(largest, phi)| *largest = largest.max(phi.abs()));
        }
    }

    pub fn left_out(&self) -> LeftOut {
        self.left_out
    }

    pub fn bay(&self) -> &Bay {
        &self.bay
    }

    pub fn bays(&self) -> usize {
        self.bays
    }

    /// N L, m.
    pub fn length(&self) -> f64 {
        self.bays as f64 * self.bay.spacing
    }

    pub fn modes(&self) -> usize {
        self.squares.len()
    }

    /// Largest of a mode's shape, kg^-1/2.
    pub fn largest(&self, mode: usize) -> f64 {
        self.largest[mode]
    }

    /// How far a short wave displaces the rail, m, that has these modes: `sum phi^2 (q^2 + q'^2 / omega^2)` is the mean of its square along the ring, of which it takes [`PACKET`].
    pub fn wave(&self, q: &[f64], v: &[f64]) -> f64 {
        let own = |((largest, square), (q, v)): ((&f64, &f64), (&f64, &f64))| largest * largest * (q * q + v * v / square);
        let sum: f64 = self.largest.iter().zip(&self.squares).zip(q.iter().zip(v)).map(own).sum();
        (sum * self.length() / PACKET).sqrt()
    }

    /// The mass that a blow meets first: 1 over the mean of sum phi^2, kg.
    pub fn struck_mass(&self) -> f64 {
        1.0 / self.mobility
    }

    /// Rates of q and q' without forces.
    pub fn rates(&self, q: &[f64], v: &[f64], dq: &mut [f64], dv: &mut [f64]) {
        dq.copy_from_slice(v);
        for Block { first, count, matrix } in &self.blocks {
            for i in 0..*count {
                let row = &self.damping[matrix + i * count..matrix + (i + 1) * count];
                let drag: f64 = row.iter().zip(&v[*first..]).map(|(c, v)| c * v).sum();
                dv[first + i] = -self.squares[first + i] * q[first + i] - drag;
            }
        }
    }

    /// Stored and kinetic energy, J, and the power that becomes heat, W.
    pub fn energy(&self, q: &[f64], v: &[f64]) -> (f64, f64) {
        let stored = self.squares.iter().zip(q.iter().zip(v)).map(|(square, (q, v))| 0.5 * (square * q * q + v * v)).sum();
        let mut heat = 0.0;
        for Block { first, count, matrix } in &self.blocks {
            for i in 0..*count {
                let row = &self.damping[matrix + i * count..matrix + (i + 1) * count];
                heat += v[first + i] * row.iter().zip(&v[*first..]).map(|(c, v)| c * v).sum::<f64>();
            }
        }
        (stored, heat)
    }

    /// omega^2 by mode.
    pub(crate) fn squares(&self) -> &[f64] {
        &self.squares
    }

    /// Room for [`Ring::factorise`].
    pub(crate) fn factor_room(&self) -> usize {
        self.damping.len()
    }

    /// Cholesky factors of `1 + a C + a^2 omega^2` (positive definite for every a > 0), by block, with inverted diagonals.
    pub(crate) fn factorise(&self, a: f64, factors: &mut Vec<f64>) {
        factors.clear();
        factors.extend(self.damping.iter().map(|c| a * c));
        let mut done = 0;
        for Block { first, count, matrix } in self.blocks.iter().copied() {
            if matrix < done {
                continue;
            }
            done = matrix + count * count;
            let m = &mut factors[matrix..done];
            for i in 0..count {
                m[i * count + i] += 1.0 + a * a * self.squares[first + i];
            }
            for i in 0..count {
                for j in 0..i {
                    let known: f64 = (0..j).map(|k| m[i * count + k] * m[j * count + k]).sum();
                    m[i * count + j] = (m[i * count + j] - known) * m[j * count + j];
                }
                let known: f64 = (0..i).map(|k| m[i * count + k] * m[i * count + k]).sum();
                m[i * count + i] = 1.0 / (m[i * count + i] - known).sqrt();
            }
        }
    }

    /// Solves with these factors in place.
    pub(crate) fn solve(&self, factors: &[f64], x: &mut [f64]) {
        for Block { first, count, matrix } in self.blocks.iter().copied() {
            let (m, x) = (&factors[matrix..matrix + count * count], &mut x[first..first + count]);
            for i in 0..count {
                let known: f64 = (0..i).map(|k| m[i * count + k] * x[k]).sum();
                x[i] = (x[i] - known) * m[i * count + i];
            }
            for i in (0..count).rev() {
                let known: f64 = (i + 1..count).map(|k| m[k * count + i] * x[k]).sum();
                x[i] = (x[i] - known) * m[i * count + i];
            }
        }
    }
}

#[cfg(test)]
mod tests;
