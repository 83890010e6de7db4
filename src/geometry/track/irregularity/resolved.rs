//! The waves of a line that is known at knots.

use crate::geometry::track::DeviationShape;
use crate::geometry::track::waves::{STEPS_IN_WAVE, Stretch};

/// What a cubic through five places of a part may be off in between for the part to count as one that such a step sees, m: a tenth of
/// what 1 % of a wheel load presses a wheel in (55 kN at 70 um: 0.5 um).
const SEEN: f64 = 5e-8;
/// Places between two knots at which that is tried, in parts of the way; a spline does nothing else there.
const TRIED: [f64; 3] = [1.0 / 6.0, 0.5, 5.0 / 6.0];
/// Places in a part at which it is tried at least: what ends a line is no spline's doing.
const LOOKS: usize = 16;
/// Halvings of a series at most.
const DEPTH: usize = 24;

/// The waves of a function between `from` and `to` [m] that is a cubic between `knots` (two or more, increasing, m): parts are halved until each is a smooth
/// piece that five evaluations tell of, or as short as twice the nearest two knots of it. Parts in which the function is zero are left out.
///
/// Knots may stand as unevenly as they like: with the distance at the middle of a part for all of it, a dip of 0.3 m between points 10 m apart was not seen.
pub(super) fn resolved(shape: &dyn DeviationShape, from: f64, to: f64, knots: &[f64]) -> Vec<Stretch> {
    const LONGEST: f64 = 64.0;
    let mut found = Vec::new();
    let count = ((to - from) / LONGEST).ceil().max(1.0);
    let length = (to - from) / count;
    // A measured line of the length of a network is cut into as many parts.
    let mut parts: Vec<(f64, f64, usize)> = (0..count as usize).rev().map(|i| (from + length * i as f64, length, 0)).collect();
    while let Some((begin, length, depth)) = parts.pop() {
        let own = around(knots, begin, begin + length);
        let nearest = own.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        if length <= 2.0 * nearest || depth == DEPTH || smooth(shape, (begin, length), own) {
            if !places((begin, length), own).all(|place| shape.at(place) == [0.0; 4]) {
                // A smooth part is a fraction of a wave.
                found.push(Stretch { from: begin, to: begin + length, wave: STEPS_IN_WAVE * length.max(nearest) });
            }
        } else {
            parts.push((begin + 0.5 * length, 0.5 * length, depth + 1));
            parts.push((begin, 0.5 * length, depth + 1));
        }
    }
    found
}

/// The knots between which a part lies, two or more.
fn around(knots: &[f64], begin: f64, end: f64) -> &[f64] {
    let behind = knots.partition_point(|knot| *knot < end).clamp(1, knots.len() - 1);
    let before = knots.partition_point(|knot| *knot <= begin).clamp(1, behind);
    &knots[before - 1..=behind]
}

/// Where a part is looked at: evenly, and between each two of its knots.
fn places((begin, length): (f64, f64), knots: &[f64]) -> impl Iterator<Item = f64> {
    let evenly = (0..=LOOKS).map(move |i| begin + length * i as f64 / LOOKS as f64);
    let between = knots.windows(2).flat_map(|pair| TRIED.map(|part| pair[0] + part * (pair[1] - pair[0])));
    evenly.chain(between.filter(move |place| (begin..=begin + length).contains(place)))
}

/// Do five values tell what the function is in between?
fn smooth(shape: &dyn DeviationShape, (begin, length): (f64, f64), knots: &[f64]) -> bool {
    const KNOWN: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
    let values = KNOWN.map(|x| shape.at(begin + x * length)[0]);
    places((begin, length), knots).all(|place| {
        let x = (place - begin) / length;
        let guess: f64 = (0..KNOWN.len())
            .map(|j| {
                let weight: f64 = (0..KNOWN.len()).filter(|k| *k != j).map(|k| (x - KNOWN[k]) / (KNOWN[j] - KNOWN[k])).product();
                weight * values[j]
            })
            .sum();
        (shape.at(place)[0] - guess).abs() <= SEEN
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::track::waves::Waves;

    #[derive(Debug)]
    struct Dip;

    impl DeviationShape for Dip {
        fn at(&self, s: f64) -> [f64; 4] {
            if (s - 500.0).abs() < 1.5 { [-0.015 * (1.0 - ((s - 500.0) / 1.5).powi(2)).powi(4), 1.0, 1.0, 1.0] } else { [0.0; 4] }
        }
        fn breaks(&self) -> Vec<f64> {
            Vec::new()
        }
        fn waves(&self) -> Vec<Stretch> {
            Vec::new()
        }
        fn describe(&self) -> String {
            String::new()
        }
    }

    #[test]
    fn prop_oversampling_makes_no_waves_and_a_dip_is_found() {
        for spacing in [0.25, 0.01] {
            let knots: Vec<f64> = (0..=(1000.0 / spacing) as usize).map(|i| spacing * i as f64).collect();
            let waves = Waves::new(resolved(&Dip, 0.0, 1000.0, &knots));
            assert!((waves.reach(0.0, 1.0) - 499.0).abs() < 2.0, "{}", waves.reach(0.0, 1.0));
            let inside = waves.reach(499.5, 1.0);
            assert!((0.05..0.6).contains(&inside), "{inside}");
            assert_eq!(waves.reach(510.0, 1.0), f64::INFINITY);
        }
    }

    /// Fine points over a dip of 3 m between points 10 or 64 m apart, wherever it lies.
    #[test]
    fn hard_a_dip_between_points_far_apart_is_found() {
        for (base, moved) in [10.0, 64.0].into_iter().flat_map(|base| [0.0, 0.3, 1.7, 3.3, 4.9, 31.0].map(|moved| (base, moved))) {
            let mut knots: Vec<f64> = (-20..20).map(|i| 500.0 + moved + base * f64::from(i)).collect();
            knots.extend((0..=60).map(|i| 498.5 + 0.05 * f64::from(i)));
            knots.sort_by(f64::total_cmp);
            knots.dedup_by(|a, b| (*a - *b).abs() < 1e-3);
            let waves = Waves::new(resolved(&Dip, 0.0, 1000.0, &knots));
            let reach = waves.reach(0.0, 1.0);
            assert!((reach - 499.0).abs() < 2.0 && (0.05..0.6).contains(&waves.reach(499.5, 1.0)), "{base} {moved}: {reach}");
        }
    }
}
