//! What a swing feels where slopes do not add up.
//!
//! Some creep laws have no derivative where creepage vanishes: their forces are homogeneous of the first degree, `f(a x) = a f(x)`, but not additive (Polach's stiffness depends on the
//! direction of the creepage). Slopes by one state after the other then are those of no motion. What a mode x with the eigenvalue l, swinging as `Re(x e^(i th))` with whatever small
//! amplitude, feels beside J is
//!
//! ```text
//! r(th) = f(Re(x e^(i th))) - J Re(x e^(i th)),      R = 1 / pi int r e^(-i th) dth,      l + w . R / (w . x)
//! ```
//!
//! with w the mode's left eigenvector: harmonic balance, to the first order in r. Equal vehicles have equal eigenvalues, whose vectors are any of a whole space, and may come out
//! parallel: a row of the inverse of all vectors' matrix is nothing then (three coaches without couplers hunted at -6e10 Hz). So w is found by inverse iteration from x itself,
//! `(J^T - l)^-1` on its conjugate: of all left vectors with that eigenvalue it is the one that has most of x. A law that is differentiable has r = 0, and what differences leave of it is
//! not counted.

use super::reduction::Reduction;
use super::slopes::Neighbourhood;
use super::{Dense, Mode};
use crate::formulation::EvaluationError;
use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef, c64};
use std::f64::consts::PI;

/// Directions over half a turn.
const TURNS: usize = 8;
/// Modes damped by more than this part are not looked at: nobody asks whether they grow.
const DAMPED: f64 = 0.1;
/// What counts, 1/s, in parts of the eigenvalue, and of what differences leave uncertain.
const LEAST: f64 = 1e-3;
const ROUNDING: f64 = 1e-4;
const CERTAIN: f64 = 10.0;
/// Of inverse iteration: how far beside the eigenvalue, in parts of it, and how often.
const APART: f64 = 1e-8;
const ITERATIONS: usize = 3;

/// Changes the eigenvalues of lightly damped modes by what slopes leave out; returns the largest change of a growth, 1/s, where any counts.
pub(super) fn add_what_slopes_leave_out(
    here: &mut Neighbourhood,
    (matrix, reduction): (&Dense, &Reduction),
    vectors: MatRef<c64>,
    modes: &mut [(usize, Mode)],
) -> Result<Option<f64>, EvaluationError> {
    let size = vectors.nrows();
    let mut largest: Option<f64> = None;
    for (k, mode) in modes.iter_mut().filter(|(_, mode)| mode.frequency > 0.0 && mode.damping < DAMPED) {
        let own: Vec<c64> = (0..size).map(|row| vectors[(row, *k)]).collect();
        let felt = beside(here, (matrix, reduction), &own)?;
        let value = c64::new(mode.growth, mode.angular_frequency);
        let left = left_of(matrix, value, &own);
        let through = |v: &[c64]| (0..size).map(|row| left[row] * v[row]).sum::<c64>();
        let change = through(&felt) / through(&own);
        let least = LEAST.max(ROUNDING * value.norm()).max(CERTAIN * mode.uncertainty);
        if !(change.norm() > least) {
            continue;
        }
        mode.put(value + change);
        largest = Some(largest.unwrap_or(0.0).max(change.re.abs()));
    }
    Ok(largest)
}

/// The left eigenvector of an eigenvalue that has most of a right one.
fn left_of(matrix: &Dense, value: c64, own: &[c64]) -> Vec<c64> {
    let beside = value + APART * value.norm();
    let shifted = Mat::from_fn(own.len(), own.len(), |i, j| c64::from(matrix[(j, i)]) - if i == j { beside } else { c64::from(0.0) });
    let factors = shifted.partial_piv_lu();
    let mut left = Mat::from_fn(own.len(), 1, |row, _| own[row].conj());
    for _ in 0..ITERATIONS {
        left = factors.solve(&left);
        let size = left.norm_l2();
        left = Mat::from_fn(own.len(), 1, |row, _| left[(row, 0)] / size);
    }
    (0..own.len()).map(|row| left[(row, 0)]).collect()
}

/// R of the free states' rates for a swing of them.
fn beside(here: &mut Neighbourhood, (matrix, reduction): (&Dense, &Reduction), swing: &[c64]) -> Result<Vec<c64>, EvaluationError> {
    let full = reduction.full(|row| swing[row]);
    // As large as a difference in the state that moves most.
    let length = full.iter().enumerate().map(|(i, part)| here.step(i) / part.norm()).fold(f64::INFINITY, f64::min);
    let size = swing.len();
    let mut sum = vec![c64::new(0.0, 0.0); size];
    for turn in 0..TURNS {
        let turned = c64::cis(PI * turn as f64 / TURNS as f64);
        let mut at = |sign: f64| {
            let y = here.y.iter().zip(&full).map(|(y, part)| y + sign * length * (part * turned).re).collect();
            here.rates(y).map(|(_, rates)| rates)
        };
        let (ahead, behind) = (at(1.0)?, at(-1.0)?);
        let slope: Vec<f64> = ahead.iter().zip(&behind).map(|(ahead, behind)| (ahead - behind) / (2.0 * length)).collect();
        let own = reduction.free(&slope);
        for (row, sum) in sum.iter_mut().enumerate() {
            let linear: f64 = (0..size).map(|column| matrix[(row, column)] * (swing[column] * turned).re).sum();
            // Both halves of the turn are alike.
            *sum += turned.conj() * ((own[row] - linear) * 2.0 / TURNS as f64);
        }
    }
    Ok(sum)
}
