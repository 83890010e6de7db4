//! A periodic motion near a guess, by Newton's method with slopes that are kept while they serve.

use super::slopes::{Condition, Slopes};
use super::{Cycle, Flow, Lost, Missed, Turn, along, dot, norm};

/// Most turns of Newton's method.
const MOST: usize = 16;
/// Slopes are found anew where a correction is more than this part of the one before.
const SERVES: f64 = 0.3;
/// A correction is at most this part of the place's size.
const REACH: f64 = 0.25;
/// Corrections below this part of the place's size that no longer shrink are the integration's error.
const ROUGH: f64 = 4e-3;
/// Halvings of a correction beyond which there is no turn.
const HALVINGS: usize = 4;

/// A fixed point.
#[derive(Clone, Debug)]
pub struct Corrected {
    pub place: Vec<f64>,
    pub turn: Turn,
    pub slopes: Slopes,
    pub iterations: usize,
    /// By how much the next correction would move the place.
    pub error: f64,
}

/// What a place misses: of a turn, and of the condition.
fn missed(place: &[f64], turn: &Turn, condition: &Condition) -> (Vec<f64>, f64) {
    let size = place.len() - 1;
    (along(&turn.to, -1.0, &place[..size]), dot(&condition.direction, place) - condition.value)
}

fn turn(flow: &dyn Flow, place: &[f64]) -> Result<Turn, Lost> {
    let size = place.len() - 1;
    flow.turn(place[size] * flow.unit(), &place[..size])
}

/// The periodic motion near `guess` (with the parameter behind) that meets a condition, to `accuracy` of its size. `slopes` of a motion nearby save turns.
///
/// # Errors
/// [`Missed`].
pub fn correct(flow: &dyn Flow, guess: &[f64], condition: &Condition, slopes: Option<&Slopes>, accuracy: f64) -> Result<Corrected, Missed> {
    let size = guess.len() - 1;
    let mut place = guess.to_vec();
    let mut turned = turn(flow, &place)?;
    let mut kept = slopes.cloned();
    // Corrections since slopes were found, and the last one's length.
    let (mut used, mut before) = (0, f64::INFINITY);
    let mut fresh = slopes.is_none();
    for iterations in 1..=MOST {
        let (residual, gap) = missed(&place, &turned, condition);
        let slopes = match kept.take() {
            Some(slopes) => slopes,
            None => {
                (used, fresh, before) = (0, true, f64::INFINITY);
                Slopes::find(flow, &place, &turned, vec![residual.clone(), condition.direction.clone(), place.clone()])?
            }
        };
        let mut change = slopes.step(&residual, condition, gap).ok_or(Missed::Singular)?;
        let length = norm(&change);
        let size_of_place = norm(&place[..size]);
        // Corrections that no longer shrink are as small as the integration's error lets them be.
        let stuck = length > 0.5 * before;
        if stuck && length < ROUGH * size_of_place && fresh {
            return Ok(Corrected { place, turn: turned, slopes, iterations, error: length });
        }
        if stuck && used > 1 {
            continue;
        }
        shorten(&mut change, REACH * size_of_place);
        (place, turned) = step(flow, &place, &change)?;
        if norm(&place[..size]) < 0.1 * norm(&guess[..size]) {
            return Err(Missed::Vanished);
        }
        if length < accuracy * size_of_place {
            return Ok(Corrected { place, turn: turned, slopes, iterations, error: length });
        }
        kept = Some(slopes).filter(|_| length < SERVES * before || used < 1);
        (used, before) = (used + 1, length);
    }
    let residual = norm(&missed(&place, &turned, condition).0) / norm(&place[..size]);
    Err(Missed::NotConverged { residual })
}

/// A change of the place is no longer than `reach`, one of the parameter no more than a unit.
fn shorten(change: &mut [f64], reach: f64) {
    let size = change.len() - 1;
    let most = (norm(&change[..size]) / reach).max(change[size].abs());
    if most > 1.0 {
        change.iter_mut().for_each(|part| *part /= most);
    }
}

/// The place after a change, less of it where there is no turn.
fn step(flow: &dyn Flow, place: &[f64], change: &[f64]) -> Result<(Vec<f64>, Turn), Lost> {
    let mut part = 1.0;
    let mut last = None;
    for _ in 0..HALVINGS {
        let next = along(place, part, change);
        match turn(flow, &next) {
            Ok(turned) => return Ok((next, turned)),
            Err(lost) => last = Some(lost),
        }
        part *= 0.5;
    }
    Err(last.unwrap_or(Lost::NoReturn))
}

/// A fixed point with its multipliers and the direction of its branch, which has a positive part along `heading`.
///
/// # Errors
/// [`Missed`].
pub fn cycle(flow: &dyn Flow, found: &Corrected, heading: &[f64]) -> Result<Cycle, Missed> {
    let size = found.place.len() - 1;
    let seeds = vec![heading.to_vec(), found.place.clone(), scattered(size + 1)];
    let slopes = Slopes::find(flow, &found.place, &found.turn, seeds)?;
    Ok(Cycle {
        parameter: found.place[size] * flow.unit(),
        period: found.turn.period,
        swings: found.turn.swings.clone(),
        multipliers: slopes.multipliers(),
        tangent: slopes.tangent(heading).ok_or(Missed::Singular)?,
        place: found.place.clone(),
        slopes,
    })
}

/// A direction with parts along all others, also those that a symmetric motion does not excite: always the same.
fn scattered(size: usize) -> Vec<f64> {
    (0..size).map(|k| ((k as f64 + 1.0) * 2.399_963_229_728_653).sin()).collect()
}
