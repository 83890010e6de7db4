//! Integrals over a step: states on which no derivative depends, such as books of energy ([`Dynamics::integrals`]).
//!
//! A linearly implicit step finds its end from stages that lie beside the solution by what is stiff: stiff components are damped out of the end, but an integral
//! adds up what the stages say. With steps of 1 ms the forces of wheels in the stages lag, and a railcar through a transition booked 778 J too much of driving work
//! where slip took 806 J in all. So integrals are made again from the solution itself, by Lobatto's rule with four points (exact for polynomials of degree 5; two
//! evaluations within the step, and that at its end once more for what it leaves in the system):
//!
//! ```text
//! W1 = W0 + h / 12 (P(0) + 5 P(c) + 5 P(1 - c) + P(1)),   c = (1 - 1 / sqrt 5) / 2
//! ```
//!
//! P at the solution's continuous output. Within the step W is the cubic through both its ends with the rates there.

use super::dense;
use super::{Implicit, IntegrationState, Scratch, Undefined};

/// Place of the first inner point in a step; the second lies as far from its end.
const INNER: f64 = 0.276_393_202_250_021;
/// Stages that hold the rates at the begin, at the inner points and at the end; steps have no use for them.
const BEGIN: usize = 3;
const WITHIN: [usize; 2] = [4, 5];
const LAST: usize = 6;

/// Keeps the rates at the begin of a step that is about to be accepted; its continuous output has been written.
pub(super) fn keep_rates(dynamics: &dyn Implicit, state: &IntegrationState, scratch: &mut Scratch) {
    let integrals = dynamics.integrals();
    scratch.stages[BEGIN][integrals.clone()].copy_from_slice(&state.derivative[integrals]);
}

/// Makes the integrals over the last step, whose begin's rates are kept, from its continuous output. Where the system can't be evaluated within it they stay what
/// the method has made of them.
pub(super) fn integrate(dynamics: &mut dyn Implicit, state: &mut IntegrationState, scratch: &mut Scratch) {
    let integrals = dynamics.integrals();
    if integrals.is_empty() || !(state.t > state.t_begin) {
        return;
    }
    let done = rates(dynamics, state, scratch);
    dynamics.rollback();
    // What the evaluation at the end left in the system may be asked for.
    if state.derivative_known && dynamics.repeat(state.t, &state.y, &mut state.derivative).is_err() {
        state.forget();
    }
    if done.is_err() {
        return;
    }
    let h = state.t - state.t_begin;
    let IntegrationState { y, dense, .. } = state;
    let [begin, first, second, last] = [BEGIN, WITHIN[0], WITHIN[1], LAST].map(|stage| &scratch.stages[stage]);
    for i in integrals {
        let from = dense[i];
        y[i] = from + h / 12.0 * (begin[i] + last[i] + 5.0 * (first[i] + second[i]));
        dense::write_one(dense, (i, y.len()), [from, y[i]], [h * begin[i], h * last[i]]);
    }
}

/// Rates within the step and at its end.
fn rates(dynamics: &mut dyn Implicit, state: &mut IntegrationState, scratch: &mut Scratch) -> Result<(), Undefined> {
    let Scratch { stages, trial, .. } = scratch;
    for (stage, place) in WITHIN.into_iter().zip([INNER, 1.0 - INNER]) {
        let time = state.t_begin + place * (state.t - state.t_begin);
        state.interpolate(dynamics, time, trial);
        dynamics.rollback();
        state.statistics.evaluations += 1;
        dynamics.derivative(time, trial, &mut stages[stage])?;
    }
    if state.derivative_known {
        stages[LAST].copy_from_slice(&state.derivative);
        return Ok(());
    }
    dynamics.rollback();
    state.statistics.evaluations += 1;
    dynamics.derivative(state.t, &state.y, &mut stages[LAST])
}
