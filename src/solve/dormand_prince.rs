//! Dormand and Prince's explicit Runge-Kutta pair of order 5(4) with continuous output of order 4.
//!
//! The embedded estimate speaks for the ends of steps. Near the limit of stability a contact's vibration (w h = 2 to 3) is right there and off by
//! several per cent between them, so forces are also held against the last term of the continuous output, theta^2 (1 - theta)^2 r5, r5 / 16 in the
//! middle of the step: 10 % more steps, Q off by 3 % instead of 15 % of the static load after a strike.
//!
//! Source: J.R. Dormand, P.J. Prince, J. Comp. Appl. Math. 6 (1980) 19-26; continuous output and step-size
//! controller after Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, sections II.4-II.6.

use super::adaptive::{self, StepPair, TOLERANCES};
use super::local_error::{END, LocalError};
use super::stability::Explicit;
use super::{Implicit, IntegrationState, Integrator, Scratch, Setting, SettingKind, SolveError, Undefined, parse_setting};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "dormand_prince",
    summary: "adaptive explicit Runge-Kutta pair 5(4) with continuous output; `tolerance` in m and rad per step",
    reference: "Dormand, Prince, J. Comp. Appl. Math. 6 (1980) 19-26",
    parse,
};

fn parse(section: &Section) -> Result<Arc<dyn Integrator>, SettingsError> {
    let tolerance = parse_setting(section, "tolerance", Dimension::Length, TOLERANCES)?;
    Ok(Arc::new(DormandPrince { tolerance }))
}

/// The adaptive pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DormandPrince {
    /// Bound of the local error of each controlled component per step, m and rad.
    pub tolerance: f64,
}

/// Continuous output: powers 0 to 4 of theta.
const DENSE_VECTORS: usize = 5;

impl Integrator for DormandPrince {
    fn setting(&self) -> Setting {
        Setting { kind: SettingKind::Tolerance, value: self.tolerance, range: TOLERANCES }
    }

    fn with_setting(&self, tolerance: f64) -> Arc<dyn Integrator> {
        Arc::new(DormandPrince { tolerance })
    }

    fn dense_vectors(&self) -> usize {
        DENSE_VECTORS
    }

    fn step(&self, dynamics: &mut dyn Implicit, state: &mut IntegrationState, scratch: &mut Scratch) -> Result<(), SolveError> {
        adaptive::step(self, self.tolerance, dynamics, state, scratch)
    }
}

const STAGES: usize = 7;
const C: [f64; STAGES] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];
const A: [[f64; 6]; STAGES] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// Weights of order 5 minus those of order 4.
const E: [f64; STAGES] = [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];
/// Shampine's free interpolant in Hairer's form.
const D: [f64; STAGES] = [
    -12715105075.0 / 11282082432.0,
    0.0,
    87487479700.0 / 32700410799.0,
    -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0,
    -1453857185.0 / 822651844.0,
    69997945.0 / 29380423.0,
];

impl StepPair for DormandPrince {
    const ORDER: i32 = 5;
    const LAST_STAGE: Option<usize> = Some(END);

    fn explicitly(&self) -> Explicit {
        Explicit::All(&[1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 600.0])
    }

    fn attempt(
        &self,
        dynamics: &mut dyn Implicit,
        state: &mut IntegrationState,
        scratch: &mut Scratch,
        h: f64,
    ) -> Result<LocalError, Undefined> {
        let Scratch { stages, frame, trial, looks, .. } = scratch;
        stages[0].copy_from_slice(&state.derivative);
        frame.move_to(dynamics, 0.0);
        frame.take_rate_off(&mut stages[0]);
        for stage in 1..STAGES {
            let (done, rest) = stages.split_at_mut(stage);
            let weights: [f64; 6] = std::array::from_fn(|j| h * A[stage][j]);
            for (i, value) in trial.iter_mut().enumerate() {
                let mut sum = state.y[i];
                for (weight, k) in weights.iter().zip(done.iter()) {
                    sum += weight * k[i];
                }
                *value = sum;
            }
            if C[stage] != C[stage - 1] {
                frame.move_to(dynamics, C[stage] * h);
            }
            frame.add_shift(trial);
            let time = state.t + C[stage] * h;
            if stage == STAGES - 1 {
                dynamics.derivative_at_end(time, trial, &mut rest[END - stage])?;
                let (last, end) = rest.split_at_mut(END - stage);
                last[0].copy_from_slice(&end[0]);
            } else {
                dynamics.derivative(time, trial, &mut rest[0])?;
            }
            frame.take_rate_off(&mut rest[0]);
            state.statistics.evaluations += 1;
            looks.stage(dynamics, time);
        }
        // The second stage is in no weight: both errors take its place.
        let mut work = std::mem::take(&mut stages[1]);
        let combined = |weights: &[f64; STAGES], i: usize| (0..STAGES).filter(|j| *j != 1).map(|j| weights[j] * stages[j][i]).sum::<f64>();
        for (i, error) in work.iter_mut().enumerate() {
            *error = h * combined(&E, i);
        }
        let mut error = LocalError::of(dynamics, &work);
        for (i, between) in work.iter_mut().enumerate() {
            *between = h / 16.0 * combined(&D, i);
        }
        error.load = error.load.max(dynamics.load_error(&work));
        stages[1] = work;
        Ok(error)
    }

    /// Turns Hairer's nested form of the continuous output into powers of theta.
    fn write_dense(&self, state: &mut IntegrationState, scratch: &Scratch, h: f64) {
        let n = state.y.len();
        for i in 0..n {
            let k = |j: usize| scratch.stages[j][i];
            let begin = state.y[i];
            let difference = scratch.trial[i] - begin - scratch.frame.shift_of(i);
            let bend = h * k(0) - difference;
            let r4 = difference - h * k(6) - bend;
            let r5 = h * (0..STAGES).map(|j| D[j] * k(j)).sum::<f64>();
            // y = begin + th (difference + (1-th) (bend + th (r4 + (1-th) r5)))
            let coefficients = [begin, difference + bend, -bend + r4 + r5, -r4 - 2.0 * r5, r5];
            for (power, coefficient) in coefficients.into_iter().enumerate() {
                state.dense[power * n + i] = coefficient;
            }
        }
    }
}
