//! The waves of a line that is known at knots.

use crate::geometry::track::DeviationShape;
use crate::geometry::track::waves::{STEPS_IN_WAVE, Stretch};

/// What a cubic through five places of a part may be off in between for the part to count as one that such a step sees, m: a tenth of
/// what 1 % of a wheel load presses a wheel in (55 kN at 70 um: 0.5 um).
const SEEN: f64 = 5e-8;
/// Points between knots at which that is tried.
const TRIED: usize = 3;
/// Halvings of a series at most.
const DEPTH: usize = 24;

/// The waves of a function that is known at knots, `from` to `to` apart by `spacing(s)` [m] there: parts are halved until each is a smooth
/// piece that five evaluations tell of, or as short as two knots. Parts in which the function is zero are left out.
pub(super) fn resolved(shape: &dyn DeviationShape, from: f64, to: f64, spacing: impl Fn(f64) -> f64) -> Vec<Stretch> {
    const LONGEST: f64 = 64.0;
    let mut found = Vec::new();
    let count = ((to - from) / LONGEST).ceil().max(1.0);
    let length = (to - from) / count;
    // A measured line of the length of a network is cut into as many parts.
    let mut parts: Vec<(f64, f64, usize)> = (0..count as usize).rev().map(|i| (from + length * i as f64, length, 0)).collect();
    while let Some((begin, length, depth)) = parts.pop() {
        let fine = 2.0 * spacing(begin + 0.5 * length);
        if length <= fine || depth == DEPTH || smooth(shape, begin, length, fine) {
            if !plain(shape, begin, length) {
                // A smooth part is a fraction of a wave.
                found.push(Stretch { from: begin, to: begin + length, wave: STEPS_IN_WAVE * length.max(0.5 * fine) });
            }
        } else {
            parts.push((begin + 0.5 * length, 0.5 * length, depth + 1));
            parts.push((begin, 0.5 * length, depth + 1));
        }
    }
    found
}

/// Do five values tell what the function is in between?
fn smooth(shape: &dyn DeviationShape, begin: f64, length: f64, fine: f64) -> bool {
    const PLACES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
    let values = PLACES.map(|x| shape.at(begin + x * length)[0]);
    let between = ((2.0 * TRIED as f64 * length / fine).ceil() as usize).clamp(16, 4096);
    (0..between).all(|i| {
        let x = (i as f64 + 0.5) / between as f64;
        let guess: f64 = (0..PLACES.len())
            .map(|j| {
                let weight: f64 = (0..PLACES.len()).filter(|k| *k != j).map(|k| (x - PLACES[k]) / (PLACES[j] - PLACES[k])).product();
                weight * values[j]
            })
            .sum();
        (shape.at(begin + x * length)[0] - guess).abs() <= SEEN
    })
}

fn plain(shape: &dyn DeviationShape, begin: f64, length: f64) -> bool {
    const LOOKS: usize = 16;
    (0..=LOOKS).all(|i| shape.at(begin + length * i as f64 / LOOKS as f64) == [0.0; 4])
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
            let waves = Waves::new(resolved(&Dip, 0.0, 1000.0, |_| spacing));
            assert!((waves.reach(0.0, 1.0) - 499.0).abs() < 2.0, "{}", waves.reach(0.0, 1.0));
            let inside = waves.reach(499.5, 1.0);
            assert!((0.05..0.6).contains(&inside), "{inside}");
            assert_eq!(waves.reach(510.0, 1.0), f64::INFINITY);
        }
    }
}
