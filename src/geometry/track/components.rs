//! The four quantities of a track (alignment, longitudinal level, cross level, gauge) in what displaces its rails, however it was stated.
//!
//! Rails displaced by l (left) and r (right) in one direction have the mean m = (l + r) / 2 and the difference d = l - r: alignment and gauge
//! sideways, longitudinal level and cross level up and down. Without the mean the left rail keeps d / 2 and the right one -d / 2; without the
//! difference both keep m.

use super::irregularity::Quantity;
use super::waves::Stretch;
use super::{Deviation, DeviationShape, Direction};
use crate::geometry::Side;
use std::sync::Arc;

/// Mean and difference of a direction.
fn quantities(direction: Direction) -> [Quantity; 2] {
    match direction {
        Direction::Lateral => [Quantity::Alignment, Quantity::Gauge],
        Direction::Vertical => [Quantity::LongitudinalLevel, Quantity::CrossLevel],
    }
}

/// A sum of shapes with factors.
#[derive(Clone, Debug)]
struct Sum(Vec<(f64, Arc<dyn DeviationShape>)>);

impl DeviationShape for Sum {
    fn at(&self, s: f64) -> [f64; 4] {
        let mut sum = [0.0; 4];
        for (factor, shape) in &self.0 {
            for (sum, value) in sum.iter_mut().zip(shape.at(s)) {
                *sum += factor * value;
            }
        }
        sum
    }

    fn breaks(&self) -> Vec<f64> {
        self.0.iter().flat_map(|part| part.1.breaks()).collect()
    }

    fn waves(&self) -> Vec<Stretch> {
        self.0.iter().flat_map(|part| part.1.waves()).collect()
    }

    fn describe(&self) -> String {
        let parts: Vec<String> = self.0.iter().map(|(factor, shape)| format!("{factor} x ({})", shape.describe())).collect();
        parts.join(" + ")
    }
}

/// Readings by which two shapes are compared.
const READINGS: usize = 64;

/// Are both the same function of distance? They are where they are one, or have the same words and agree wherever they are read.
fn same(a: &Arc<dyn DeviationShape>, b: &Arc<dyn DeviationShape>) -> bool {
    if Arc::ptr_eq(a, b) {
        return true;
    }
    let within = |wave: Stretch| (0..READINGS).map(move |k| wave.from + (wave.to - wave.from) * (k as f64 + 0.5) / READINGS as f64);
    a.describe() == b.describe() && a.waves() == b.waves() && a.waves().into_iter().flat_map(within).all(|s| a.at(s) == b.at(s))
}

/// What is left of deviations without some of the four quantities. Nothing stays where both rails go alike and it is the mean that goes.
pub fn without(deviations: &[Deviation], left_out: &[Quantity]) -> Vec<Deviation> {
    let mut all = Vec::new();
    for direction in [Direction::Lateral, Direction::Vertical] {
        let own = || deviations.iter().filter(move |deviation| deviation.direction == direction);
        let [no_mean, no_difference] = quantities(direction).map(|quantity| left_out.contains(&quantity));
        match (no_mean, no_difference) {
            (false, false) => all.extend(own().cloned()),
            (true, true) => {}
            (no_mean, _) => {
                let of = |side: Side| own().filter(|one| one.side == side).map(|one| one.shape.clone()).collect::<Vec<_>>();
                all.extend(halved(direction, of(Side::Left), of(Side::Right), no_mean));
            }
        }
    }
    all
}

/// Deviations of one direction, of the left and the right rail, without their mean or without their difference.
fn halved(
    direction: Direction,
    left: Vec<Arc<dyn DeviationShape>>,
    mut right: Vec<Arc<dyn DeviationShape>>,
    no_mean: bool,
) -> Vec<Deviation> {
    let (mut common, mut parts) = (Vec::new(), Vec::new());
    for shape in left {
        match right.iter().position(|other| same(&shape, other)) {
            Some(place) => {
                right.remove(place);
                common.push(shape);
            }
            None => parts.push((0.5, shape)),
        }
    }
    let sign = if no_mean { -0.5 } else { 0.5 };
    parts.extend(right.into_iter().map(|shape| (sign, shape)));
    let both = |shape: Arc<dyn DeviationShape>| Side::BOTH.map(|side| Deviation { side, direction, shape: shape.clone() });
    match no_mean {
        false => {
            let mean: Option<Arc<dyn DeviationShape>> = if parts.is_empty() { None } else { Some(Arc::new(Sum(parts))) };
            common.into_iter().chain(mean).flat_map(both).collect()
        }
        true if parts.is_empty() => Vec::new(),
        true => {
            let turned = parts.iter().map(|(factor, shape)| (-factor, shape.clone())).collect();
            let of = |side, parts| Deviation { side, direction, shape: Arc::new(Sum(parts)) as Arc<dyn DeviationShape> };
            vec![of(Side::Left, parts), of(Side::Right, turned)]
        }
    }
}

/// Largest size of each of the four quantities [m] at the distances that are looked at.
pub fn largest(deviations: &[Deviation], distances: impl Iterator<Item = f64>) -> [f64; 4] {
    let mut largest = [0.0f64; 4];
    for s in distances {
        let mut sums = [[0.0; 2]; 2];
        for Deviation { side, direction, shape } in deviations {
            sums[*direction as usize][side.index()] += shape.at(s)[0];
        }
        for (direction, [left, right]) in [Direction::Lateral, Direction::Vertical].into_iter().zip(sums) {
            for (quantity, value) in quantities(direction).into_iter().zip([0.5 * (left + right), left - right]) {
                let most = &mut largest[quantity.index()];
                *most = most.max(value.abs());
            }
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug)]
    struct Line(f64);

    impl DeviationShape for Line {
        fn at(&self, s: f64) -> [f64; 4] {
            [self.0 * s, self.0, 0.0, 0.0]
        }

        fn breaks(&self) -> Vec<f64> {
            vec![self.0]
        }

        fn waves(&self) -> Vec<Stretch> {
            vec![Stretch { from: 0.0, to: 10.0, wave: 5.0 }]
        }

        fn describe(&self) -> String {
            format!("line {}", self.0)
        }
    }

    fn deviations(lateral: [&[f64]; 2], vertical: [&[f64]; 2]) -> Vec<Deviation> {
        let mut all = Vec::new();
        for (direction, sides) in [(Direction::Lateral, lateral), (Direction::Vertical, vertical)] {
            for (side, slopes) in Side::BOTH.into_iter().zip(sides) {
                all.extend(slopes.iter().map(|slope| Deviation { side, direction, shape: Arc::new(Line(*slope)) }));
            }
        }
        all
    }

    /// Lateral left and right, vertical left and right, at s = 2 m.
    fn at(deviations: &[Deviation]) -> [f64; 4] {
        let mut sums = [0.0; 4];
        for one in deviations {
            sums[2 * one.direction as usize + one.side.index()] += one.shape.at(2.0)[0];
        }
        sums
    }

    #[test]
    fn analytic_each_quantity_is_left_out_by_itself() {
        use Quantity::{Alignment, CrossLevel, Gauge, LongitudinalLevel};
        let all = deviations([&[1.0, 3.0], &[2.0]], [&[5.0], &[1.0, 1.5]]);
        // l = 8, r = 4 sideways: mean 6, difference 4; l = 10, r = 5 upward: mean 7.5, difference 5.
        assert_eq!(at(&all), [8.0, 4.0, 10.0, 5.0]);
        assert_eq!(at(&without(&all, &[Alignment])), [2.0, -2.0, 10.0, 5.0]);
        assert_eq!(at(&without(&all, &[Gauge])), [6.0, 6.0, 10.0, 5.0]);
        assert_eq!(at(&without(&all, &[LongitudinalLevel])), [8.0, 4.0, 2.5, -2.5]);
        assert_eq!(at(&without(&all, &[CrossLevel, Alignment, Gauge])), [0.0, 0.0, 7.5, 7.5]);
        assert_eq!(largest(&all, [0.0, -2.0, 1.0].into_iter()), [6.0, 7.5, 5.0, 4.0]);
    }

    #[test]
    fn prop_rails_that_go_alike_leave_no_object_behind() {
        let alike = deviations([&[1.0, 3.0], &[3.0, 1.0]], [&[], &[]]);
        assert!(without(&alike, &[Quantity::Alignment]).is_empty());
        let kept = without(&alike, &[Quantity::Gauge]);
        assert_eq!((kept.len(), at(&kept)), (4, [8.0, 8.0, 0.0, 0.0]));
        assert!(kept.iter().all(|one| one.shape.describe().starts_with("line")), "the shapes themselves, not sums of them");
        // One rail alone: half of it moves both, half of it is gauge.
        let one = deviations([&[], &[2.0]], [&[], &[]]);
        assert_eq!(at(&without(&one, &[Quantity::Alignment])), [-2.0, 2.0, 0.0, 0.0]);
        assert_eq!(at(&without(&one, &[Quantity::Gauge])), [2.0, 2.0, 0.0, 0.0]);
        assert_eq!(without(&one, &[Quantity::Gauge])[0].shape.breaks(), [2.0]);
    }
}
