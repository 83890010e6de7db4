//! The branch of limit cycles that begins at the linear critical speed.

use super::vehicle::Vehicle;
use super::{Motion, Progress, Turning, Unmet, Value};
use crate::study::cycles::branch::{self, ACCURACY, End, Reach};
use crate::study::cycles::corrector::{correct, cycle};
use crate::study::cycles::slopes::Condition;
use crate::study::cycles::{Cycle, Flow, Missed, fold, largest};
use crate::study::modes::Mode;
use std::ops::Range;

/// Swings of the first motions, m: the branch is extended to none from them.
const SMALL: [f64; 3] = [0.5e-4, 1e-4, 2e-4];
/// Swings at which a branch ends, m.
const LEAST: f64 = 0.5e-4;
const MOST: f64 = 20e-3;
/// Steps along a branch, mm and units of speed.
const FIRST: f64 = 0.2;
const SHORTEST: f64 = 0.01;
const LONGEST: f64 = 1.0;
/// Motions of a branch at most.
const MOTIONS: usize = 150;
/// Turning points are found to this, m/s.
const FOLD: f64 = 0.01;

/// A branch, and what was found on it.
pub(super) struct Followed {
    pub begin: Option<Value>,
    pub branch: Vec<Motion>,
    pub end: String,
    pub motions: Vec<Motion>,
    pub missed: Vec<Unmet>,
    pub turnings: Vec<Turning>,
    /// Of the motion that swings most, and its swing, m.
    pub largest: Option<(Vec<f64>, f64)>,
}

impl Followed {
    pub fn none(reason: &str) -> Self {
        Followed {
            begin: None,
            branch: Vec::new(),
            end: reason.into(),
            motions: Vec::new(),
            missed: Vec::new(),
            turnings: Vec::new(),
            largest: None,
        }
    }
}

fn motion(cycle: &Cycle) -> Motion {
    let frequency = 1.0 / cycle.period;
    let largest = cycle.multipliers.first().copied().unwrap_or_default();
    Motion {
        speed: cycle.parameter,
        swings: cycle.swings.clone(),
        bound: None,
        frequency: Value { value: frequency, bound: ACCURACY * frequency },
        stable: cycle.is_stable(),
        multiplier: [largest.re, largest.im],
        unstable: cycle.unstable(),
    }
}

/// From the shape of hunting at the linear critical speed on, through a range of speeds.
pub(super) fn from_small(
    vehicle: &Vehicle,
    (speed, swinging): (f64, &Mode),
    range: Range<f64>,
    speeds: &[f64],
    progress: &dyn Progress,
) -> Followed {
    let first = match begin(vehicle, speed, swinging) {
        Ok(first) => first,
        Err(missed) => {
            return Followed::none(&format!(
                "no motion with a swing of {} mm was found at the linear critical speed: {missed}",
                1e3 * SMALL[2]
            ));
        }
    };
    let limit = begins_at(&first, speed);
    let reach = Reach { parameters: range, step: FIRST, shortest: SHORTEST, longest: LONGEST, swings: LEAST..MOST, most: MOTIONS };
    let [smallest, small, start] = first;
    let seen = |cycle: &Cycle| progress.motion(cycle.parameter, largest(&cycle.swings));
    let mut followed = branch::follow(vehicle, start, &reach, &seen);
    followed.cycles.splice(0..0, [smallest, small]);
    let cycles = &followed.cycles;
    let finer = vehicle.finer();
    let (motions, missed) = at_speeds(vehicle, &finer, cycles, speeds);
    let turnings = turnings(vehicle, &finer, cycles);
    let end = match followed.end {
        End::Range => "it leaves the range of the sweep".into(),
        End::Small => "its motions become too small to be told from none".into(),
        End::Large => format!("its motions swing by more than {} mm", 1e3 * MOST),
        End::TooLong => format!("{MOTIONS} motions were found on it"),
        End::Stopped(reason) => format!("it can't be followed further: {reason}"),
    };
    let swing = |cycle: &Cycle| largest(&cycle.swings);
    let largest = cycles.iter().max_by(|a, b| swing(a).total_cmp(&swing(b)));
    let largest = largest.map(|cycle| (cycle.place[..cycle.place.len() - 1].to_vec(), swing(cycle)));
    Followed { begin: Some(limit), branch: cycles.iter().map(motion).collect(), end, motions, missed, turnings, largest }
}

/// The three smallest motions.
fn begin(vehicle: &Vehicle, speed: f64, swinging: &Mode) -> Result<[Cycle; 3], Missed> {
    let one = |swing: f64| {
        let mut guess = vehicle.section.place(&swinging.shape, swing);
        let size = guess.iter().map(|part| part * part).sum::<f64>().sqrt();
        let mut direction: Vec<f64> = guess.iter().map(|part| part / size).collect();
        direction.push(0.0);
        guess.push(speed / vehicle.unit());
        let condition = Condition::across(direction.clone(), &guess);
        let found = correct(vehicle, &guess, &condition, None, ACCURACY)?;
        cycle(vehicle, &found, &direction)
    };
    Ok([one(SMALL[0])?, one(SMALL[1])?, one(SMALL[2])?])
}

/// Where the branch tends to as its motions become small: speed changes with the square of the swing. What the next two motions say instead is the bound.
fn begins_at([a, b, c]: &[Cycle; 3], speed: f64) -> Value {
    let square = |cycle: &Cycle| largest(&cycle.swings).powi(2);
    let extended = |a: &Cycle, b: &Cycle| a.parameter - square(a) * (b.parameter - a.parameter) / (square(b) - square(a));
    let value = extended(a, b);
    Value { value, bound: (extended(b, c) - value).abs() + ACCURACY * speed }
}

/// A motion with bounds: what a finer integration changes.
fn checked(finer: &Vehicle, cycle: &Cycle) -> Motion {
    let mut found = motion(cycle);
    if let Ok(again) = branch::again(finer, cycle) {
        let off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let rest = again.error / again.place.iter().map(|part| part * part).sum::<f64>().sqrt();
        let largest = largest(&found.swings);
        found.bound = Some(off(&again.turn.swings, &found.swings) + rest * largest);
        let frequency = 1.0 / again.turn.period;
        found.frequency = Value { value: frequency, bound: (frequency - found.frequency.value).abs() + rest * frequency };
        found.swings = again.turn.swings;
    }
    found
}

/// Motions at the speeds of a sweep, and where the branch passes one of them but none was met.
fn at_speeds(vehicle: &Vehicle, finer: &Vehicle, cycles: &[Cycle], speeds: &[f64]) -> (Vec<Motion>, Vec<Unmet>) {
    let (mut motions, mut missed) = (Vec::new(), Vec::new());
    for pair in cycles.windows(2) {
        let (from, to) = (pair[0].parameter.min(pair[1].parameter), pair[0].parameter.max(pair[1].parameter));
        for speed in speeds.iter().filter(|speed| (from..to).contains(speed)) {
            match branch::between(vehicle, &pair[0], &pair[1], *speed) {
                Ok(found) => motions.push(checked(finer, &found)),
                Err(_) => missed.push(Unmet { speed: *speed, swings: [0, 1].map(|k| largest(&pair[k].swings)) }),
            }
        }
    }
    motions.sort_by(|a, b| a.speed.total_cmp(&b.speed).then(a.swings[0].total_cmp(&b.swings[0])));
    missed.sort_by(|a, b| a.speed.total_cmp(&b.speed));
    (motions, missed)
}

/// Part of a swing by which turning points that are one may differ.
const ALIKE: f64 = 0.05;

/// Takes away pairs of neighbours that are no further apart than they are known: the branch may as well go straight on there.
fn told_apart(mut all: Vec<Turning>) -> Vec<Turning> {
    let swing = |turning: &Turning| largest(&turning.motion.swings);
    let one = |pair: &[Turning]| {
        let [a, b] = [&pair[0], &pair[1]];
        a.lowest != b.lowest
            && (a.speed.value - b.speed.value).abs() <= a.speed.bound + b.speed.bound
            && (swing(a) - swing(b)).abs() <= ALIKE * swing(a)
    };
    while let Some(at) = all.windows(2).position(one) {
        all.drain(at..at + 2);
    }
    all
}

fn turnings(vehicle: &Vehicle, finer: &Vehicle, cycles: &[Cycle]) -> Vec<Turning> {
    let mut found = Vec::new();
    for trio in cycles.windows(3).filter(|trio| fold::turns(trio)) {
        let Ok(turning) = fold::find(vehicle, trio, FOLD) else { continue };
        // A finer integration has its fold elsewhere: by how much, tells a motion with the same swing.
        let condition = Condition::across(turning.cycle.tangent.clone(), &turning.cycle.place);
        let speed = turning.cycle.parameter;
        let again = correct(finer, &turning.cycle.place, &condition, Some(&turning.cycle.slopes), 0.1 * ACCURACY);
        let unit = vehicle.unit();
        let (value, off) = again.map_or((speed, f64::INFINITY), |again| {
            let value = again.place[again.place.len() - 1] * unit;
            (value, (value - speed).abs() + again.error * unit)
        });
        found.push(Turning {
            speed: Value { value, bound: turning.bracket + off },
            motion: motion(&turning.cycle),
            lowest: turning.least,
            stable: trio[0].is_stable() || trio[2].is_stable(),
        });
    }
    told_apart(found)
}
