//! How fast a mode swings and how it is damped, with all first-order states of its force elements (Maxwell dampers, air springs).
//!
//! A motion `shape e^(i w t)` asks for the forces `-(Q_q + i w Q_v + Q_s s)`, with the states `(i w - S) s = R_q + i w R_v` of each element, so that per modal mass m
//!
//! ```text
//! kappa = -shape . (Q_q shape + i w Q_v shape + Q_s s) / m,   w'^2 = Re kappa,   damping ratio = Im kappa / (2 Re kappa)
//! ```
//!
//! Dry friction is left out: stuck it is a spring, in sliding its damping depends on how far it slides.

use super::{COORDINATES, Carried, Mode, generalised};
use nalgebra::{Complex, DMatrix, DVector};

/// Displacement of a mode's largest coordinate, m or rad, and velocity, per s, for differences; the same of a state, in parts of its size.
const STEP: f64 = 1e-6;
const SPEED: f64 = 1e-4;

/// Rate [1/s] and damping ratio of a mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    pub rate: f64,
    pub damping: f64,
}

/// Changes of the generalised forces and of all states' rates.
struct Change {
    forces: DVector<f64>,
    rates: DVector<f64>,
}

impl Carried<'_> {
    /// Of all of `modes` that swing.
    pub fn swings(&mut self, modes: &[Mode]) -> Vec<Option<Swing>> {
        let begin = 2 * COORDINATES * self.system.bodies.len();
        let states: Vec<Change> = (begin..self.state.len())
            .map(|place| {
                let step = STEP * (1.0 + self.state[place].abs());
                self.difference(step, |state, step| state[place] += step)
            })
            .collect();
        modes.iter().map(|mode| self.swing(mode, &states)).collect()
    }

    /// Central difference of what a change by a step does, states of the elements held.
    fn difference(&mut self, step: f64, change: impl Fn(&mut [f64], f64)) -> Change {
        let kept = self.state.clone();
        let mut found = |step: f64| {
            change(&mut self.state, step);
            self.apply();
            self.state.copy_from_slice(&kept);
            (
                generalised(self.system, self.first, &self.workspace, &self.workspace.wrenches),
                DVector::from_column_slice(&self.workspace.force_rates),
            )
        };
        let ((forces, rates), (before, rates_before)) = (found(step), found(-step));
        Change { forces: (forces - before) / (2.0 * step), rates: (rates - rates_before) / (2.0 * step) }
    }

    fn swing(&mut self, mode: &Mode, states: &[Change]) -> Option<Swing> {
        if !(mode.value > 0.0) {
            return None;
        }
        let rate = mode.value.sqrt();
        let (first, velocities) = (COORDINATES * self.first, COORDINATES * (self.first + self.system.bodies.len()));
        let size = 1.0 / mode.shape.amax();
        let along = |begin: usize| {
            move |state: &mut [f64], step: f64| {
                state[begin..].iter_mut().zip(mode.shape.iter()).for_each(|(value, part)| *value += step * size * part);
            }
        };
        let (moved, moving) = (self.difference(STEP, along(first)), self.difference(SPEED, along(velocities)));
        let part = |forces: &DVector<f64>| mode.shape.dot(forces);
        let mut answer = Complex::new(part(&moved.forces), rate * part(&moving.forces)) / size;
        let begin = 2 * COORDINATES * self.system.bodies.len();
        for (element, force) in self.system.forces.iter().enumerate() {
            let own = self.system.states_of_force(element);
            if own.is_empty() || force.rub(&self.workspace.moving()).is_some() {
                continue;
            }
            let own = own.start - begin..own.end - begin;
            let driven =
                DVector::from_iterator(own.len(), own.clone().map(|i| Complex::new(moved.rates[i], rate * moving.rates[i]) / size));
            let matrix = DMatrix::from_fn(own.len(), own.len(), |i, j| {
                let lag = if i == j { Complex::new(0.0, rate) } else { Complex::default() };
                lag - states[own.start + j].rates[own.start + i]
            });
            let Some(found) = matrix.lu().solve(&driven) else { continue };
            answer += own.clone().zip(found.iter()).map(|(i, state)| *state * part(&states[i].forces)).sum::<Complex<f64>>();
        }
        let kappa = -answer / mode.shape.component_mul(&mode.shape).dot(&self.masses);
        (kappa.re > 0.0).then(|| Swing { rate: kappa.re.sqrt(), damping: kappa.im / (2.0 * kappa.re) })
    }
}
