//! A family of periodic motions, followed by its arc length.
//!
//! From a motion u = (z, p) with the unit tangent t the next one is sought across the tangent, at a distance s (H. Keller's pseudo-arclength continuation):
//!
//! ```text
//! P(z, p) = z,    t . (u - u0) = s
//! ```
//!
//! Steps grow where Newton's method is quick and the branch is straight, and are halved where it fails.

use super::corrector::{Corrected, correct, cycle};
use super::slopes::{Condition, unit};
use super::{Cycle, Flow, Missed, along, dot, largest};
use std::ops::Range;

/// Corrections end below this part of a motion's size.
pub const ACCURACY: f64 = 1e-4;
/// Newton iterations that are few, and the cosine between two tangents of a branch that is straight.
const FEW: usize = 5;
const STRAIGHT: f64 = 0.95;
/// Below this cosine a step is taken back.
const BENT: f64 = 0.5;

/// How far a branch is followed.
#[derive(Clone, Debug)]
pub struct Reach {
    pub parameters: Range<f64>,
    /// The first step, the shortest and the longest.
    pub step: f64,
    pub shortest: f64,
    pub longest: f64,
    /// Largest and smallest swing of the first observed coordinate that swings most.
    pub swings: Range<f64>,
    pub most: usize,
}

/// Why a branch ends.
#[derive(Clone, Debug, PartialEq)]
pub enum End {
    /// Of the parameters.
    Range,
    /// Motions become too small or too large to be looked at.
    Small,
    Large,
    /// In words.
    Stopped(String),
    TooLong,
}

/// A branch as far as it was followed.
#[derive(Clone, Debug)]
pub struct Branch {
    pub cycles: Vec<Cycle>,
    pub end: End,
}

/// Follows a branch from a motion in the direction of its tangent; `seen` is called for each.
pub fn follow(flow: &dyn Flow, start: Cycle, reach: &Reach, seen: &dyn Fn(&Cycle)) -> Branch {
    let mut cycles = vec![start];
    let mut step = reach.step;
    let end = loop {
        if cycles.len() >= reach.most {
            break End::TooLong;
        }
        let last = &cycles[cycles.len() - 1];
        match next(flow, last, step) {
            Ok((found, iterations)) => {
                let cosine = dot(&found.tangent, &last.tangent);
                seen(&found);
                cycles.push(found);
                if iterations <= FEW && cosine > STRAIGHT {
                    step = (1.5 * step).min(reach.longest);
                } else if cosine < 0.5 * (1.0 + BENT) {
                    step = (0.5 * step).max(reach.shortest);
                }
            }
            Err(missed) => {
                step *= 0.5;
                if step < reach.shortest {
                    break End::Stopped(missed.to_string());
                }
                continue;
            }
        }
        let last = &cycles[cycles.len() - 1];
        let swing = largest(&last.swings);
        if !reach.parameters.contains(&last.parameter) {
            break End::Range;
        }
        if swing > reach.swings.end {
            break End::Large;
        }
        if swing < reach.swings.start {
            break End::Small;
        }
    };
    Branch { cycles, end }
}

fn next(flow: &dyn Flow, last: &Cycle, step: f64) -> Result<(Cycle, usize), Missed> {
    let guess = along(&last.place, step, &last.tangent);
    let condition = Condition::across(last.tangent.clone(), &guess);
    let found = correct(flow, &guess, &condition, Some(&last.slopes), ACCURACY)?;
    let found_cycle = cycle(flow, &found, &last.tangent)?;
    if dot(&found_cycle.tangent, &last.tangent) < BENT && step > 0.0 {
        return Err(Missed::NotConverged { residual: found.error });
    }
    Ok((found_cycle, found.iterations))
}

/// The motion between two neighbours of a branch at a value of the parameter between theirs.
///
/// # Errors
/// [`Missed`].
pub fn between(flow: &dyn Flow, a: &Cycle, b: &Cycle, parameter: f64) -> Result<Cycle, Missed> {
    let part = (parameter - a.parameter) / (b.parameter - a.parameter);
    let secant = along(&b.place, -1.0, &a.place);
    let guess = along(&a.place, part, &secant);
    let condition = Condition::parameter(guess.len(), parameter / flow.unit());
    let near = if part < 0.5 { a } else { b };
    let found = correct(flow, &guess, &condition, Some(&near.slopes), ACCURACY)?;
    cycle(flow, &found, &unit(&secant))
}

/// The same motion at its parameter as another flow (one that is integrated more exactly) has it.
///
/// # Errors
/// [`Missed`].
pub fn again(flow: &dyn Flow, known: &Cycle) -> Result<Corrected, Missed> {
    let condition = Condition::parameter(known.place.len(), known.parameter / flow.unit());
    correct(flow, &known.place, &condition, Some(&known.slopes), 0.1 * ACCURACY)
}
