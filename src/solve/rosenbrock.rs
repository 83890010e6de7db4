//! ROS34PW2: a Rosenbrock-W pair of order 3(2), L-stable, for systems whose contacts are stiff.
//!
//! Linearly implicit: with J close to df/dy at the step's begin and the step h, each of the four stages is one linear system with
//! the same matrix and no iteration,
//!
//!   k_i = h f(t + a_i h, y + sum_j<i alpha_ij k_j) + h J sum_j<=i gamma_ij k_j,    y1 = y + sum b_i k_i .
//!
//! The coefficients fulfil the order conditions of W-methods to order 3, so J may be anything (a part of df/dy, nothing at all) as
//! far as order goes: it serves stability. Time is one more state: what is known of df/dt comes in with a moving frame
//! (below), what is not is left zero. With J = df/dy the method is L-stable, R(z) -> 0, and stiffly accurate (the b are the last row
//! of alpha + gamma). The embedded weights are of order 2 with J arbitrary, and |R(infinity)| = 0.48: the difference of the two, the
//! estimate of the local error, needs no further filter in stiff components.
//!
//! MovingFrame out in u = Gamma k, which needs no product with J: (I - gamma h J) u_i = gamma h f(.., y + sum a_ij u_j) + sum c_ij u_j.
//!
//! Continuous output: y + sum b_i(theta) k_i with cubic b_i, which are the only ones that fulfil at each theta the conditions of order 2 for any
//! J and those of order 3 for J = df/dy. Its error is of order 3, like that of the steps' ends (locally 4 with the exact J). It is made of
//! the k alone: f itself at the ends of the step, as a Hermite polynomial would take it, is off by lambda times a stiff component's error, which
//! spoils it by h lambda / 8 times that error in the middle of the step (Kaps' problem, h lambda = 1e7: by 500 where the ends are off by 3e-4).
//!
//! Where the system knows a motion that the solution nearly follows, steps are made beside it ([`super::moving_frame`]).
//!
//! The Jacobian belongs to the begin of the step: a rejected step keeps it and only factorises anew.
//!
//! Source: J. Rang, L. Angermann, BIT 45 (2005) 761-787; all conditions are checked in the tests.

use super::adaptive::{self, StepPair};
use super::local_error::{END, LocalError, WORK};
use super::moving_frame::MovingFrame;
use super::stability::Explicit;
use super::{
    Implicit, IntegrationState, Integrator, Scratch, Setting, SettingKind, SolveError, StiffPart, Undefined, parse_setting, response,
};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "rosenbrock",
    summary: "adaptive Rosenbrock-W pair 3(2), L-stable: stiff contact does not limit the step; `tolerance` in m and rad per step",
    reference: "Rang, Angermann, BIT 45 (2005) 761-787",
    parse,
};

/// As for the explicit pairs, but no limit of stability makes loose tolerances useless.
pub(super) const TOLERANCES: (f64, f64) = (1e-15, 1e-3);

fn parse(section: &Section) -> Result<Arc<dyn Integrator>, SettingsError> {
    let tolerance = parse_setting(section, "tolerance", Dimension::Length, TOLERANCES)?;
    Ok(Arc::new(Rosenbrock { tolerance, part: StiffPart::All }))
}

/// The adaptive pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rosenbrock {
    /// Bound of the local error of each controlled component per step, m and rad.
    pub tolerance: f64,
    /// What is treated implicitly.
    pub part: StiffPart,
}

impl Integrator for Rosenbrock {
    fn setting(&self) -> Setting {
        Setting { kind: SettingKind::Tolerance, value: self.tolerance, range: TOLERANCES }
    }

    fn with_setting(&self, tolerance: f64) -> Arc<dyn Integrator> {
        Arc::new(Rosenbrock { tolerance, ..*self })
    }

    fn dense_vectors(&self) -> usize {
        DENSE.len() + 1
    }

    fn response_vectors(&self) -> usize {
        if self.part == StiffPart::All { response::VECTORS } else { 0 }
    }

    fn take_up(
        &self,
        dynamics: &mut dyn Implicit,
        state: &mut IntegrationState,
        scratch: &mut Scratch,
        time: f64,
        push: [&[f64]; 2],
    ) -> bool {
        self.respond(dynamics, state, scratch, (time, push)).unwrap_or(false)
    }

    fn linearises(&self) -> bool {
        true
    }

    fn step(&self, dynamics: &mut dyn Implicit, state: &mut IntegrationState, scratch: &mut Scratch) -> Result<(), SolveError> {
        adaptive::step(self, self.tolerance, dynamics, state, scratch)
    }
}

const STAGES: usize = 4;
type Row = [f64; STAGES];
type Table = [Row; STAGES];

const GAMMA: f64 = 0.435866521508459;
const ALPHAS: Table =
    [[0.0; STAGES], [0.871733043016918, 0.0, 0.0, 0.0], [0.8445706001536942, -0.11299064236484185, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
const GAMMAS: Table = [
    [GAMMA, 0.0, 0.0, 0.0],
    [-0.871733043016918, GAMMA, 0.0, 0.0],
    [-0.9033805701304408, 0.054180672388095326, GAMMA, 0.0],
    [0.24212380706095346, -1.2232505839045147, 0.5452602553351021, GAMMA],
];
const WEIGHTS: Row = [0.24212380706095346, -1.2232505839045147, 1.545260255335102, GAMMA];
const EMBEDDED: Row = [0.3781090314581937, -0.09604229221242318, 0.5, 0.2179332607542295];

/// Continuous output: weights of the k in theta, theta^2 and theta^3.
const DENSE: [Row; 3] = [
    [1.0564298455794094, 2.296429974281067, -1.307599564525375, -1.0452602553351014],
    [-1.38648826997596, -8.26261170027569, 7.250979895056067, 2.3981200751955827],
    [0.5721822314575029, 4.742931142090103, -4.398120075195585, -0.9169932983520208],
];

/// k = INVERSE u.
const INVERSE: Table = inverse(GAMMAS);
/// Arguments and solution in terms of u.
const A: Table = [in_u(ALPHAS[0]), in_u(ALPHAS[1]), in_u(ALPHAS[2]), in_u(ALPHAS[3])];
const M: Row = in_u(WEIGHTS);
const D: [Row; 3] = [in_u(DENSE[0]), in_u(DENSE[1]), in_u(DENSE[2])];
/// Rate of the continuous output at the end of the step, times h.
const AT_END: Row = in_u([
    DENSE[0][0] + 2.0 * DENSE[1][0] + 3.0 * DENSE[2][0],
    DENSE[0][1] + 2.0 * DENSE[1][1] + 3.0 * DENSE[2][1],
    DENSE[0][2] + 2.0 * DENSE[1][2] + 3.0 * DENSE[2][2],
    DENSE[0][3] + 2.0 * DENSE[1][3] + 3.0 * DENSE[2][3],
]);
/// Estimate of the local error.
const E: Row = in_u([WEIGHTS[0] - EMBEDDED[0], WEIGHTS[1] - EMBEDDED[1], WEIGHTS[2] - EMBEDDED[2], WEIGHTS[3] - EMBEDDED[3]]);
/// Times of the stages in steps.
const C: Row = [sum(ALPHAS[0]), sum(ALPHAS[1]), sum(ALPHAS[2]), sum(ALPHAS[3])];

/// Inverse of a lower triangular matrix.
const fn inverse(lower: Table) -> Table {
    let mut result = [[0.0; STAGES]; STAGES];
    let mut column = 0;
    while column < STAGES {
        let mut row = column;
        while row < STAGES {
            let mut value = if row == column { 1.0 } else { 0.0 };
            let mut inner = column;
            while inner < row {
                value -= lower[row][inner] * result[inner][column];
                inner += 1;
            }
            result[row][column] = value / lower[row][row];
            row += 1;
        }
        column += 1;
    }
    result
}

/// Weights of the u where those of the k are given.
const fn in_u(weights: Row) -> Row {
    let mut result = [0.0; STAGES];
    let mut column = 0;
    while column < STAGES {
        let mut row = column;
        while row < STAGES {
            result[column] += weights[row] * INVERSE[row][column];
            row += 1;
        }
        column += 1;
    }
    result
}

const fn sum(row: Row) -> f64 {
    row[0] + row[1] + row[2] + row[3]
}

impl StepPair for Rosenbrock {
    const ORDER: i32 = 3;
    const LAST_STAGE: Option<usize> = None;
    const CHECKED: bool = true;

    fn explicitly(&self) -> Explicit {
        if self.part == StiffPart::Contact { Explicit::Elements } else { Explicit::Nothing }
    }

    fn prepare(&self, dynamics: &mut dyn Implicit, state: &mut IntegrationState, _frame: &mut MovingFrame) -> Result<(), SolveError> {
        state.evaluate_with_cache(dynamics)?;
        state.linearise(dynamics, self.part)
    }

    fn attempt(
        &self,
        dynamics: &mut dyn Implicit,
        state: &mut IntegrationState,
        scratch: &mut Scratch,
        h: f64,
    ) -> Result<LocalError, Undefined> {
        state.statistics.factorisations += 1;
        dynamics.factorise(GAMMA * h)?;
        let Scratch { stages, frame, trial, looks, .. } = scratch;
        frame.begin(dynamics);
        for stage in 0..STAGES {
            let (done, rest) = stages.split_at_mut(stage);
            let u = &mut rest[0];
            if stage == 0 {
                u.copy_from_slice(&state.derivative);
            } else {
                frame.move_to(dynamics, C[stage] * h);
                for (i, value) in trial.iter_mut().enumerate() {
                    *value = state.y[i] + frame.shift[i] + combined(&A[stage], done, i);
                }
                state.statistics.evaluations += 1;
                dynamics.derivative(state.t + C[stage] * h, trial, u)?;
                looks.stage(dynamics, state.t + C[stage] * h);
            }
            let coupling = INVERSE[stage].map(|inverse| -GAMMA * inverse);
            for (i, value) in u.iter_mut().enumerate() {
                *value = GAMMA * h * (*value - frame.rate[i]) + combined(&coupling, done, i);
            }
            frame.solve(dynamics, u, GAMMA * h * h * sum(GAMMAS[stage]));
        }
        let (stages, rest) = stages.split_at_mut(STAGES);
        let error = &mut rest[WORK - STAGES];
        for (i, value) in trial.iter_mut().enumerate() {
            *value = state.y[i] + frame.shift[i] + combined(&M, stages, i);
            error[i] = if value.is_finite() { combined(&E, stages, i) } else { f64::INFINITY };
        }
        Ok(LocalError::of(dynamics, error))
    }

    /// How far f at the end is from the rate that the continuous output has there, over the step and through the step's own matrix:
    /// `gamma h (I - gamma h J)^-1 (f - y')`, what one more Newton step would change. In smooth motion it is small of the order h^4; a
    /// contact that began within the step, which no stage felt, shows in it with all its force.
    fn check(&self, dynamics: &mut dyn Implicit, scratch: &mut Scratch, h: f64) -> LocalError {
        let Scratch { stages, frame, .. } = scratch;
        let (stages, rest) = stages.split_at_mut(END);
        let (end, work) = rest.split_at_mut(1);
        for (i, value) in work[0].iter_mut().enumerate() {
            *value = GAMMA * (h * (end[0][i] - frame.rate[i]) - combined(&AT_END, &stages[..STAGES], i));
        }
        dynamics.solve_linear(&mut work[0]);
        LocalError::of(dynamics, &work[0])
    }

    fn write_dense(&self, state: &mut IntegrationState, scratch: &Scratch, _h: f64) {
        let (begin, powers) = state.dense.split_at_mut(state.y.len());
        begin.copy_from_slice(&state.y);
        for (weights, power) in D.iter().zip(powers.chunks_exact_mut(begin.len())) {
            for (i, coefficient) in power.iter_mut().enumerate() {
                *coefficient = combined(weights, &scratch.stages[..STAGES], i);
            }
        }
    }
}

/// Component i of a sum of stages.
fn combined(weights: &Row, stages: &[Vec<f64>], i: usize) -> f64 {
    weights.iter().zip(stages).map(|(weight, stage)| weight * stage[i]).sum()
}

mod respond;

#[cfg(test)]
mod tests;
