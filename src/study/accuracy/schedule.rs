//! Which runs fit into the time: what is cheap comes first, and predictions learn from what was measured.

use super::clock::Budget;
use super::run::{Setting, method};
use crate::solve;

/// Cost of a pilot run of a variant, CPU s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pilot {
    pub per_second: f64,
    pub per_evaluation: f64,
}

/// The tolerance of a pilot run, m.
pub(super) const PILOT_TOLERANCE: f64 = 1e-7;

/// Evaluations of the right-hand side per fixed step, guessed until one is measured.
const PER_STEP: f64 = 5.0;

/// What a factor in tolerance costs: an order of 4 has 1/4, an order of 3 1/3.
const TOLERANCE_POWER: f64 = 0.25;

/// What an adaptive implicit method costs at a tolerance [m], in pilot runs, guessed until one is measured (a vehicle 0.1, a
/// wheelset 0.2), and what a factor in tolerance costs it.
const IMPLICIT: (f64, f64) = (0.2, 1e-5);
const IMPLICIT_POWER: f64 = 1.0 / 3.0;

/// A point to be run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Item {
    pub variant: usize,
    pub setting: Setting,
}

/// Predictions of CPU time per simulated second.
pub(super) struct Schedule {
    pub pilots: Vec<Option<Pilot>>,
    measured: Vec<(Item, f64)>,
    /// Methods that use Jacobians.
    implicit: Vec<&'static str>,
    repeats: usize,
    /// Time that passes per CPU time: more than 1 where others use the machine too.
    pub slowness: f64,
}

impl Schedule {
    pub(super) fn new(pilots: Vec<Option<Pilot>>, repeats: usize, slowness: f64) -> Schedule {
        let implicit = solve::REGISTRY.iter().map(|entry| entry.name).filter(|name| method(name).is_ok_and(|method| method.linearises()));
        Schedule { pilots, measured: Vec::new(), implicit: implicit.collect(), repeats, slowness }
    }

    /// A run of `item` took `seconds` of CPU time per simulated second.
    pub(super) fn learn(&mut self, item: Item, seconds: f64) {
        self.measured.push((item, seconds));
    }

    /// CPU time per simulated second; `None` where nothing is known of the variant.
    pub(super) fn predict(&self, item: &Item) -> Option<f64> {
        let wanted = item.setting.value.ln();
        let same = |known: &&(Item, f64)| known.0.variant == item.variant && known.0.setting.integrator == item.setting.integrator;
        let far = |known: &(Item, f64)| (known.0.setting.value.ln() - wanted).abs();
        let nearest = self.measured.iter().filter(same).min_by(|a, b| far(a).total_cmp(&far(b)));
        let implicit = self.implicit.contains(&item.setting.integrator);
        let power = match (item.setting.fixed, implicit) {
            (true, _) => 1.0,
            (false, true) => IMPLICIT_POWER,
            (false, false) => TOLERANCE_POWER,
        };
        if let Some((known, seconds)) = nearest {
            return Some(seconds * (known.setting.value / item.setting.value).powf(power));
        }
        let pilot = self.pilots.get(item.variant).copied().flatten()?;
        Some(if item.setting.fixed {
            PER_STEP * pilot.per_evaluation / item.setting.value
        } else if implicit {
            IMPLICIT.0 * pilot.per_second * (IMPLICIT.1 / item.setting.value).powf(power)
        } else {
            pilot.per_second * (PILOT_TOLERANCE / item.setting.value).powf(power).max(1.0)
        })
    }

    /// Time for a point with its repetitions, s; see [`super::run::measure`].
    pub(super) fn duration(&self, item: &Item, stop: f64, patience: f64) -> Option<f64> {
        let once = self.predict(item)? * stop * self.slowness;
        Some(once * (patience / once).clamp(1.0, 1.0 + self.repeats as f64))
    }

    /// The cheapest of the points, and what it takes, s.
    pub(super) fn cheapest(&self, items: &[Item], stop: f64, patience: f64) -> Option<(usize, f64)> {
        let durations = items.iter().map(|item| self.duration(item, stop, patience).unwrap_or(f64::INFINITY)).enumerate();
        durations.min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Time for the repetitions of one of so many points, s.
pub(super) fn patience(budget: &Budget, points: usize) -> f64 {
    0.4 * budget.seconds / points.max(1) as f64
}
