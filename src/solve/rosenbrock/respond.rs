//! A step that is made takes up a change of f: the response by the same method with the same Jacobian ([`crate::solve::response`]).
//!
//! The stages of `d' = J d + g` need no product with J: what a stage r becomes by `(I - gamma h J) u = r` says that `gamma h J u = u - r`.

use super::{A, AT_END, C, D, E, GAMMA, GAMMAS, INVERSE, M, Rosenbrock, STAGES, combined, sum};
use crate::solve::local_error::{END, LocalError, WORK};
use crate::solve::response::{MOST, MOST_ERROR};
use crate::solve::{Implicit, IntegrationState, Scratch, Undefined};

/// Where in the rest of the step the size of a response is looked at.
const LOOKS: [f64; 3] = [0.25, 0.5, 1.0];

impl Rosenbrock {
    /// See [`crate::solve::Integrator::take_up`].
    pub(super) fn respond(
        &self,
        dynamics: &mut dyn Implicit,
        state: &mut IntegrationState,
        scratch: &mut Scratch,
        (time, push): (f64, [&[f64]; 2]),
    ) -> Result<bool, Undefined> {
        let (end, count) = (state.t, state.y.len());
        let h = end - time;
        dynamics.linearise_again(state.t_begin, &state.dense[..count], self.part)?;
        // Errors are judged where the step ends; where it was cut nobody has evaluated f yet.
        if !state.derivative_known {
            state.evaluate_begin(dynamics).map_err(|_| Undefined)?;
        } else if !dynamics.is_cached() {
            dynamics.repeat(end, &state.y, &mut scratch.stages[END])?;
        }
        state.statistics.factorisations += 1;
        dynamics.factorise(GAMMA * h)?;
        let error = self.find_stages(dynamics, scratch, h, push) + state.response.error;
        if !(error <= MOST_ERROR) {
            return Ok(false);
        }
        state.response.begin_at(time, end);
        for (weights, power) in D.iter().zip(state.response.rising()) {
            for (i, coefficient) in power.iter_mut().enumerate() {
                *coefficient += combined(weights, &scratch.stages[..STAGES], i);
            }
        }
        let size = &mut scratch.stages[WORK];
        let mut largest: f64 = 0.0;
        for theta in LOOKS {
            size.fill(0.0);
            state.response.add(if theta < 1.0 { time + theta * h } else { end }, end, size);
            largest = largest.max(self.driven(&LocalError::of(dynamics, size)));
        }
        if !(largest <= MOST) {
            return Ok(false);
        }
        state.response.error = error;
        state.statistics.taken_up += 1;
        Ok(true)
    }

    /// An error in parts of what is allowed where something drives the motion.
    fn driven(&self, error: &LocalError) -> f64 {
        LocalError { swing: 0.0, ..*error }.over(self.tolerance)
    }

    /// Finds the stages u of the response and returns its error, by the pair and by f at the end, as a step's is judged.
    fn find_stages(&self, dynamics: &mut dyn Implicit, scratch: &mut Scratch, h: f64, push: [&[f64]; 2]) -> f64 {
        let (stages, rest) = scratch.stages.split_at_mut(STAGES);
        let (turned, work) = rest.split_at_mut(WORK - STAGES);
        let work = &mut work[0];
        let slopes = GAMMAS.map(sum);
        for stage in 0..STAGES {
            let (done, own) = stages.split_at_mut(stage);
            let u = &mut own[0];
            let coupling = INVERSE[stage].map(|inverse| -GAMMA * inverse);
            for (i, value) in u.iter_mut().enumerate() {
                // With its slope in time.
                let pushed = push[0][i] + (C[stage] + slopes[stage]) * (push[1][i] - push[0][i]);
                *value = GAMMA * h * pushed + combined(&A[stage], &turned[..stage], i) + combined(&coupling, done, i);
            }
            // gamma h J u.
            turned[stage].copy_from_slice(u);
            dynamics.solve_linear(u);
            turned[stage].iter_mut().zip(u.iter()).for_each(|(own, u)| *own = u - *own);
        }
        for (i, value) in work.iter_mut().enumerate() {
            *value = combined(&E, stages, i);
        }
        let by_pair = self.driven(&LocalError::of(dynamics, work));
        for (i, value) in work.iter_mut().enumerate() {
            *value = GAMMA * h * push[1][i] + combined(&M, turned, i) - GAMMA * combined(&AT_END, stages, i);
        }
        dynamics.solve_linear(work);
        let by_end = self.driven(&LocalError::of(dynamics, work));
        by_pair.max(by_end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::test_systems::*;
    use crate::solve::{Integrator, StiffPart};
    use nalgebra::DMatrix;

    /// x'' + 0.4 x' + 4 x = 0.
    fn oscillator() -> Watched {
        Watched::new(
            |_, y, dy| (dy[0], dy[1]) = (y[1], -4.0 * y[0] - 0.4 * y[1]),
            |_, _| DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -4.0, -0.4]),
            1,
        )
    }

    /// Its answer x to a unit force, some time after that began.
    fn answer(after: f64) -> f64 {
        let (fading, turning) = (0.2, (4.0f64 - 0.04).sqrt());
        let (sin, cos) = (turning * after.max(0.0)).sin_cos();
        0.25 * (1.0 - (-fading * after.max(0.0)).exp() * (cos + fading / turning * sin))
    }

    /// Greatest error of x in the rest of a step of length h from rest, which takes up a force at 0.2 h and another one at 0.6 h.
    fn off(tolerance: f64, h: f64) -> Option<(f64, f64)> {
        let method = Rosenbrock { tolerance, part: StiffPart::All };
        let (mut system, mut state, mut scratch) = (oscillator(), method.start(0.0, &[0.0; 2]), Scratch::new(2, 0));
        state.next_step = h;
        assert_eq!(method.step(&mut system, &mut state, &mut scratch), Ok(()));
        let forces = [(0.2 * h, 1.0), (0.6 * h, -0.7)];
        for (time, force) in forces {
            if !method.take_up(&mut system, &mut state, &mut scratch, time, [&[0.0, force]; 2]) {
                return None;
            }
        }
        let error = |time: f64| {
            let mut y = [0.0; 2];
            state.interpolate(&system, time, &mut y);
            (y[0] - forces.iter().map(|(begin, force)| force * answer(time - begin)).sum::<f64>()).abs()
        };
        Some((error(h), (0..=8).map(|k| error(h * (0.6 + 0.05 * f64::from(k)))).fold(0.0, f64::max)))
    }

    #[test]
    fn order_of_a_response_is_that_of_the_steps() {
        let (ends, inside) = orders(|h| off(1e9, h).unwrap(), 0.1);
        println!("order of a step's error {ends:.2}, inside {inside:.2}");
        assert!(ends > 3.7 && inside > 3.7);
    }

    #[test]
    fn prop_what_is_too_large_is_not_taken_up() {
        // In a step of 0.1 s the forces give it 0.06 m/s, which counts as a position does here: half a tolerance. The error is far below.
        let largest = 1e-3 * (0..).map(f64::from).find(|k| off(1e-3 * k, 0.1).is_some()).unwrap();
        println!("taken up from a tolerance of {largest:.0e}");
        assert!((0.1..0.2).contains(&largest));
        let (error, _) = off(largest, 0.1).unwrap();
        assert!(error < 1e-4 * largest, "{error:e}");
    }

    #[test]
    fn prop_the_next_step_begins_where_the_response_has_come_to() {
        let method = Rosenbrock { tolerance: 1e9, part: StiffPart::All };
        let (mut system, mut state, mut scratch) = (oscillator(), method.start(0.0, &[0.1, 0.0]), Scratch::new(2, 0));
        state.next_step = 0.1;
        assert_eq!(method.step(&mut system, &mut state, &mut scratch), Ok(()));
        assert!(method.take_up(&mut system, &mut state, &mut scratch, 0.05, [&[0.0, 1.0], &[0.0, 2.0]]));
        let (mut end, mut before) = ([0.0; 2], [0.0; 2]);
        state.interpolate(&system, state.t, &mut end);
        // An input that jumps again, now by too much, restarts from the same solution.
        let mut other = state.clone();
        state.interpolate(&system, 0.08, &mut before);
        other.restart_at(0.08, |_, _| ());
        assert_eq!(other.y, before);
        let t = state.t;
        assert_eq!(state.begin(&mut system, &mut scratch), Ok(()));
        assert_eq!((state.t, &state.y[..]), (t, &end[..]));
        assert!(!state.has_taken_up() && end[1] > 0.0);
    }
}
