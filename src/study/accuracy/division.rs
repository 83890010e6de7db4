//! How the budget is divided: the span of all runs, and the models' references in turn.

use super::clock::Budget;
use super::run::Setting;
use super::schedule::{Item, Schedule, patience};
use super::study::StudiedModel;
use super::variant::Variant;
use crate::sim::recording::Times;

/// Until these shares of the budget pilots, references and points may take.
pub(super) const PILOTS: f64 = 0.1;
const REFERENCES: f64 = 0.45;
pub(super) const POINTS: f64 = 0.88;
/// Where no communication steps come after them.
pub(super) const POINTS_ALONE: f64 = 0.97;
/// The loosest reference of the first model is worth more than points without any.
const FIRST_REFERENCE: f64 = 0.6;
/// The plan for the cheapest model should fit into this share.
const FIRST_MODEL: f64 = 0.5;
/// What the references cost, in pilot runs.
const REFERENCE_RUNS: f64 = 10.0;

/// A span of which half of the cheapest variant's runs fit into the budget.
pub(super) fn shortened(full: Times, schedule: &Schedule, settings: &[Setting], budget: &Budget, notes: &mut Vec<String>) -> Times {
    let patience = patience(budget, settings.len() * schedule.pilots.len());
    let whole = |variant: usize| {
        let pilot = schedule.pilots[variant]?;
        let mut points: Vec<f64> =
            settings.iter().filter_map(|setting| schedule.duration(&Item { variant, setting: *setting }, full.stop, patience)).collect();
        points.sort_by(f64::total_cmp);
        // Half of the points tell more of the whole scene than all points of its beginning.
        let half: f64 = points.iter().take(points.len().div_ceil(2)).sum();
        Some(half + REFERENCE_RUNS * pilot.per_second * full.stop * schedule.slowness)
    };
    let cheapest = (0..schedule.pilots.len()).filter_map(whole).fold(f64::INFINITY, f64::min);
    let room = FIRST_MODEL * budget.seconds;
    if !(cheapest > room && cheapest.is_finite()) {
        return full;
    }
    // Whole output steps, a tenth of the scene at least.
    let rows = (full.stop * (room / cheapest).max(0.1) / full.step).ceil();
    let stop = (rows * full.step).min(full.stop);
    let words = format!(
        "the first {stop:.3} s of {} s, so that the budget of {} s has room (--stop and --budget change that)",
        full.stop, budget.seconds
    );
    notes.push(words);
    Times { stop, ..full }
}

/// The order in which models get their references, and the share of the budget until which each may take: the scene's own
/// formulation first, then what is cheap. Each may take half of what is left for references; a first, loose one may take more.
pub(super) fn turns(models: &[StudiedModel], variants: &[Variant], schedule: &Schedule, own: &str) -> Vec<(usize, [f64; 2])> {
    let expense = |index: &usize| {
        let of = &models[*index].variants;
        let cost = of.iter().filter_map(|variant| schedule.pilots[*variant]).map(|pilot| pilot.per_second);
        if of.iter().any(|variant| variants[*variant].formulation == own) { 0.0 } else { cost.fold(f64::INFINITY, f64::min) }
    };
    let mut order: Vec<usize> = (0..models.len()).collect();
    order.sort_by(|a, b| expense(a).total_cmp(&expense(b)));
    let part = |turn: usize| if turn + 1 == order.len() { 1.0 } else { 1.0 - 0.5f64.powi(turn as i32 + 1) };
    let first = |turn: usize| if turn == 0 { FIRST_REFERENCE } else { REFERENCES };
    (0..order.len()).map(|turn| (order[turn], [first(turn), PILOTS + (REFERENCES - PILOTS) * part(turn)])).collect()
}
