//! Newton's method on the equations of steady running, and what is said where it fails.
//!
//! Each step is halved until the sum of squares of the accelerations falls. Differences are dear: a factorisation serves for as long as its steps
//! bring the state much nearer.
//!
//! Where no step helps (wheels must get over a place where contacts jump or the balance ceases to be) the bodies drift instead,
//! `x' = accelerations off the balance`, by implicit Euler's method with steps that grow while they go well, until Newton's method takes
//! hold again.

use super::BALANCED;
use super::search::{PITCH, Search, UNIT, Unknown};
use super::slopes::{Factors, Slopes};
use crate::formulation::EvaluationError;
use crate::mbs::body::COORDINATES;
use crate::scene::equilibrium::EquilibriumError;

/// Below this the iteration goes on with the differences that it has, and ends where they bring no more.
const NEAR: f64 = 1e-10;
/// Rest at which rounding is reached.
const EXACT: f64 = 1e-13;
const ITERATIONS: usize = 40;
/// The same where a shorter way is tried next.
const HASTY: usize = 10;
/// First length of a drift's step in parts of what moves a body by 1 m or rad per g of acceleration; most steps; furthest that one goes, m or rad;
/// by how much it may worsen the balance; what is left when Newton's method takes over.
const DRIFT: f64 = 1e-4;
const DRIFTS: usize = 80;
const FARTHEST: f64 = 3e-3;
const WORST: f64 = 10.0;
const SETTLED: f64 = 1e-5;
const HALVINGS: i32 = 25;
/// Restoring acceleration per displacement below which nothing holds a body, 1/s2 in parts of [`UNIT`].
const LOOSE: f64 = 1e-5;

impl Search<'_> {
    /// # Errors
    /// There is no balance, or it was not found from here.
    pub fn balance(&mut self) -> Result<(), EquilibriumError> {
        // Rigid contacts that jump do not let bodies drift on.
        let drifts = !self.model.formulation.constrains() && !self.hasty;
        let mut rest = self.newton().map_err(EquilibriumError::Evaluation)?;
        if drifts && !(largest(&rest).0 < self.tolerance) && self.drift(&rest).map_err(EquilibriumError::Evaluation)? {
            rest = self.newton().map_err(EquilibriumError::Evaluation)?;
        }
        if largest(&rest).0 < self.tolerance {
            return self.read();
        }
        Err(if self.hasty { self.unbalanced(&rest) } else { self.unsupported(&rest) })
    }

    /// Is what is left here within the tolerance?
    pub fn is_balanced(&mut self) -> bool {
        let none = vec![0.0; self.unknowns.len()];
        self.residual(&none, true).is_ok_and(|rest| largest(&rest).0 < self.tolerance)
    }

    /// What is read off the search is that of the balance, not of the last trial.
    fn read(&mut self) -> Result<(), EquilibriumError> {
        let none = vec![0.0; self.unknowns.len()];
        self.residual(&none, true).map(|_| ()).map_err(EquilibriumError::Evaluation)
    }

    /// Returns what is left.
    fn newton(&mut self) -> Result<Vec<f64>, EvaluationError> {
        let none = vec![0.0; self.unknowns.len()];
        let mut rest = self.residual(&none, true)?;
        let mut known: Option<Factors> = None;
        for _ in 0..if self.hasty { HASTY } else { ITERATIONS } {
            let before = largest(&rest).0;
            if before < EXACT || self.exhausted() {
                break;
            }
            let fresh = known.is_none();
            let Some(factors) = (match known.take() {
                Some(factors) => Some(factors),
                None => self.factors(&rest)?,
            }) else {
                break;
            };
            if let Some(found) = self.better(&factors.step(&self.square, &rest), &rest)? {
                rest = found;
            }
            let after = largest(&rest).0;
            let stalls = !(after < 0.5 * before);
            if stalls && (after < NEAR || fresh && (after < BALANCED || after == before)) {
                break;
            }
            known = (after < if before < NEAR { 0.5 } else { 0.1 } * before).then_some(factors);
        }
        Ok(rest)
    }

    /// Drifts toward a balance; returns whether Newton's method may go on from there.
    fn drift(&mut self, rest: &[f64]) -> Result<bool, EvaluationError> {
        let (rows, columns) = (rest.len(), self.unknowns.len());
        let mut rest = rest.to_vec();
        let mut shift = 1.0 / DRIFT;
        for _ in 0..DRIFTS {
            if largest(&rest).0 < SETTLED {
                return Ok(true);
            }
            if self.exhausted() {
                break;
            }
            let entries = self.differences(&rest, false)?;
            let mut moved = None;
            for _ in 0..HALVINGS {
                let slopes = Slopes { entries: &entries, rows, columns, square: &self.square };
                let step = slopes.damped(shift).map(|factors| factors.step(&self.square, &rest));
                if let Some(step) = step.filter(|step| largest(step).0 < FARTHEST)
                    && self.residual(&step, false).is_ok_and(|found| largest(&found).0 < WORST * largest(&rest).0)
                {
                    moved = Some(step);
                    break;
                }
                shift *= 4.0;
            }
            let Some(step) = moved else { return Ok(false) };
            rest = self.residual(&step, true)?;
            shift /= 3.0;
        }
        Ok(largest(&rest).0 < 1e2 * SETTLED)
    }

    fn factors(&mut self, rest: &[f64]) -> Result<Option<Factors>, EvaluationError> {
        let (rows, columns) = (rest.len(), self.unknowns.len());
        let entries = self.differences(rest, false)?;
        if let Some(square) = (Slopes { entries: &entries, rows, columns, square: &self.square }).square() {
            return Ok(Some(square));
        }
        let entries = self.differences(rest, true)?;
        Ok(Slopes { entries: &entries, rows, columns, square: &self.square }.whole().map(Factors::Whole))
    }

    /// Goes the step, shortened until it makes the sum of squares smaller; what is left there, `None` where no part of it helps.
    fn better(&mut self, step: &[f64], rest: &[f64]) -> Result<Option<Vec<f64>>, EvaluationError> {
        // Along a step onto the constraints the moves are small of second order: only accelerations are compared.
        let count = self.square.len();
        let sum = |rest: &[f64]| rest[..count].iter().map(|r| r * r).sum::<f64>();
        let before = self.configuration();
        for halvings in 0..HALVINGS {
            let change: Vec<f64> = step.iter().map(|step| 0.5f64.powi(halvings) * step).collect();
            // Without constraints a trial that is kept is what would be found there again.
            let found = self.residual(&change, !self.constrained).ok().filter(|found| sum(found) < sum(rest));
            match found {
                Some(_) if self.constrained => return self.residual(&change, true).map(Some),
                Some(found) => return Ok(Some(found)),
                None => self.put(&before),
            }
        }
        Ok(None)
    }

    /// Why there is no balance: the body that nothing holds, or the one that is off it most.
    fn unsupported(&mut self, rest: &[f64]) -> EquilibriumError {
        const MOTIONS: [&str; COORDINATES] = ["along x", "along y", "along z", "about z (yaw)", "about x (roll)", "about y (pitch)"];
        let (rows, columns) = (rest.len(), self.unknowns.len());
        let entries = self.differences(rest, true).unwrap_or_default();
        let slopes = Slopes { entries: &entries, rows, columns, square: &self.square }.whole();
        let name = |body: usize| self.model.system.bodies[body].name.clone();
        let coordinates = self.square.len();
        // How far each unknown takes part in motions that nothing resists, times how far its body is off balance there.
        let mut moved = vec![0.0; coordinates];
        if let Some(svd) = slopes.filter(|_| !entries.is_empty()) {
            for (column, unknown) in self.unknowns.iter().enumerate() {
                let place = match unknown {
                    Unknown::Coordinate { body, axis, .. } => COORDINATES * body + axis,
                    Unknown::Spin { body, .. } => COORDINATES * body + PITCH,
                    Unknown::Slowing => continue,
                };
                let loose = (0..svd.V().ncols()).filter(|k| svd.S().column_vector()[*k] < LOOSE);
                let part: f64 = loose.map(|k| svd.V()[(column, k)].powi(2)).sum();
                moved[place] = part * rest[place].abs();
            }
        }
        let (most, place) = largest(&moved);
        // A wheelset that rolls on its rails has its spin held by friction.
        let rolls = |body: usize| self.model.wheelsets.iter().any(|wheelset| wheelset.body == body);
        if most > BALANCED && place % COORDINATES == PITCH && rolls(place / COORDINATES) {
            return EquilibriumError::Lifted { wheelset: name(place / COORDINATES) };
        }
        if most > BALANCED {
            return EquilibriumError::Unsupported { body: name(place / COORDINATES), motion: MOTIONS[place % COORDINATES] };
        }
        self.unbalanced(rest)
    }

    /// The body that is off the balance most.
    fn unbalanced(&self, rest: &[f64]) -> EquilibriumError {
        let (worst, row) = largest(&rest[..self.square.len()]);
        EquilibriumError::Unbalanced { body: self.model.system.bodies[row / COORDINATES].name.clone(), acceleration: worst * UNIT }
    }
}

/// The largest absolute value and its place; what is not a number is larger than all.
fn largest(values: &[f64]) -> (f64, usize) {
    let pick = |found: (f64, usize), (place, value): (usize, &f64)| {
        if value.abs() > found.0 || value.is_nan() { (if value.is_nan() { f64::INFINITY } else { value.abs() }, place) } else { found }
    };
    values.iter().enumerate().fold((0.0, 0), pick)
}
