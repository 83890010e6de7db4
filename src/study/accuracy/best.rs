//! What to choose: the cheapest point for an accuracy, and the points that no other one beats.

use super::errors::Quantity;
use super::study::Study;
use serde::Serialize;

/// The cheapest point for one or several accuracies.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Best {
    /// Accuracies, SI, largest first.
    pub levels: Vec<f64>,
    /// Index in [`Study::points`].
    pub point: usize,
    /// Its error is at most this, SI.
    pub error: f64,
}

/// A point's error, or what it is certainly better than, and its cost per simulated second.
fn known(study: &Study, point: usize, quantity: Quantity) -> Option<(f64, f64)> {
    let (measured, _) = Study::done(&study.points[point])?;
    study.standing(&study.points[point], quantity).bound().map(|(error, _)| (error, measured.median()))
}

/// The cheapest point of a model at each accuracy that it reaches; accuracies with the same point stand together.
pub fn best(study: &Study, model: usize, quantity: Quantity, levels: &[f64]) -> Vec<Best> {
    let mut found: Vec<Best> = Vec::new();
    for level in levels {
        let candidates = (0..study.points.len()).filter(|point| study.models[model].variants.contains(&study.points[*point].variant));
        let good = candidates.filter_map(|point| known(study, point, quantity).map(|(error, cost)| (point, error, cost)));
        let Some((point, error, _)) = good.filter(|(_, error, _)| error <= level).min_by(|a, b| a.2.total_cmp(&b.2)) else { continue };
        match found.last_mut() {
            Some(last) if last.point == point => last.levels.push(*level),
            _ => found.push(Best { levels: vec![*level], point, error }),
        }
    }
    found
}

/// Points out of `among` that no other one of them beats in both error and cost, the cheapest first.
pub fn front(study: &Study, among: &[usize], quantity: Quantity) -> Vec<usize> {
    let mut all: Vec<(usize, f64, f64)> =
        among.iter().filter_map(|point| known(study, *point, quantity).map(|(error, cost)| (*point, error, cost))).collect();
    all.sort_by(|a, b| a.2.total_cmp(&b.2).then(a.1.total_cmp(&b.1)));
    let mut least = f64::INFINITY;
    all.retain(|(_, error, _)| {
        let better = *error < least;
        least = least.min(*error);
        better
    });
    all.into_iter().map(|(point, ..)| point).collect()
}
