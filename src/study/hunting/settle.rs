//! What a run comes to: it dies, repeats itself, or does neither.
//!
//! Swings of turns are compared by windows of [`WINDOW`] of them. They repeat themselves where they differ within the last window by less than
//! [`ALIKE`] and what they would still change by, did each window's change go on as the last two did (Aitken), is less than that too.

use super::vehicle::Vehicle;
use crate::study::cycles::{Lost, Turn};
use serde::Serialize;
use std::ops::ControlFlow;

const WINDOW: usize = 8;
const ALIKE: f64 = 1e-3;
/// A swing below this part of the first is one that dies.
const DEAD: f64 = 0.02;
/// Turns after which a motion that does not repeat itself is told as what it is.
pub const MOST: usize = 240;

/// What became of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "outcome", rename_all = "snake_case")]
pub enum Outcome {
    /// The swing died.
    Dies,
    /// Turns are alike: half swings of the wheelsets, m, that of the leading one to `bound`, and turns per second.
    Repeats { swings: Vec<f64>, bound: f64, frequency: f64 },
    /// Swings of the leading wheelset still grow or fall after all turns, m.
    Changes { from: f64, to: f64 },
    /// They keep changing between two values, m.
    Irregular { least: f64, most: f64 },
    /// In words.
    Fails { reason: String },
}

/// A run from a place, and the place where it ended.
#[derive(Clone, Debug)]
pub struct Settled {
    pub outcome: Outcome,
    pub turns: usize,
    pub place: Vec<f64>,
}

/// Runs at a speed [m/s] from a place until it is clear what becomes of it.
pub fn settle(vehicle: &Vehicle, speed: f64, from: &[f64]) -> Settled {
    let mut turns: Vec<Turn> = Vec::new();
    let lead = vehicle.section.leading();
    let done = vehicle.run(speed, from, |turn| {
        turns.push(turn);
        let swings: Vec<f64> = turns.iter().map(|turn| turn.swings[lead]).collect();
        let over = swings[swings.len() - 1] < DEAD * swings[0] || repeats(&swings).is_some() || swings.len() >= MOST;
        if over { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let swings: Vec<f64> = turns.iter().map(|turn| turn.swings[lead]).collect();
    let outcome = match (done, turns.last(), repeats(&swings)) {
        (Err(Lost::NoReturn), _, _) | (Ok(()), None, _) => Outcome::Dies,
        (Err(Lost::Failed(reason)), _, _) => Outcome::Fails { reason },
        (Ok(()), Some(last), Some(bound)) => {
            let frequency = WINDOW as f64 / turns[turns.len() - WINDOW..].iter().map(|turn| turn.period).sum::<f64>();
            Outcome::Repeats { swings: last.swings.clone(), bound, frequency }
        }
        (Ok(()), Some(last), None) if last.swings[lead] < DEAD * swings[0] => Outcome::Dies,
        _ => unsettled(&swings),
    };
    Settled { outcome, turns: turns.len(), place: turns.pop().map_or_else(|| from.to_vec(), |turn| turn.to) }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn spread(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max) - values.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Of swings that repeat themselves, to what.
fn repeats(swings: &[f64]) -> Option<f64> {
    let first = swings.len().checked_sub(3 * WINDOW)?;
    let windows: Vec<&[f64]> = swings[first..].chunks(WINDOW).collect();
    let (old, new) = (mean(windows[1]) - mean(windows[0]), mean(windows[2]) - mean(windows[1]));
    let size = ALIKE * mean(windows[2]);
    let ratio = (new / old).abs();
    // Changes at the integration's error follow no law.
    let rest = if new.abs() < 0.02 * size {
        new.abs()
    } else if ratio < 1.0 {
        new.abs() * ratio / (1.0 - ratio)
    } else {
        return None;
    };
    let bound = spread(windows[2]) + rest;
    (bound < size).then_some(bound)
}

fn unsettled(swings: &[f64]) -> Outcome {
    let late = &swings[swings.len() / 2..];
    let (first, last) = late.split_at(late.len() / 2);
    let moved = mean(last) - mean(first);
    let wide = |values: &[f64]| spread(values) > 2.0 * moved.abs();
    if wide(first) && wide(last) {
        let least = late.iter().copied().fold(f64::INFINITY, f64::min);
        return Outcome::Irregular { least, most: least + spread(late) };
    }
    Outcome::Changes { from: late[0], to: late[late.len() - 1] }
}
