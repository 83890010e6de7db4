//! How much of one strip's width lies above a level of the overlap.
//!
//! Over its width w the overlap is a parabola `d(x) = d + s x + q x^2 / 2`, |x| <= w / 2, through the strip's middle and its neighbours'. Patches end within a strip, and
//! small ones lie within one or two: taken or left as a whole by their middles, strips of 0.35 mm gave a flange that began to touch (5 to 8 um deep, patch 0.4 mm
//! wide) a fourth of its force, and then a stiffness ten times that of half-spaces.

use super::pressed::Pressed;
use super::rail::RailStrips;
use crate::math::smooth_step::cubic_step;

/// A patch may lie between the middles of two strips that do not overlap there by so much, m: wide strips under a wheel that curves like a tread.
pub(super) const BESIDE: f64 = 1e-6;

/// Over one strip: d [m], s, q [1/m], and half the width, m.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bowl {
    pub middle: f64,
    pub slope: f64,
    pub bend: f64,
    pub half: f64,
}

/// The part of a strip above a level.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Cut {
    /// Of the strip's width, 0 to 1.
    pub share: f64,
    /// Its middle from that of the strip, m.
    pub offset: f64,
    /// Means of the overlap above the level and of its square over that part, m and m^2.
    pub mean: f64,
    pub square: f64,
}

impl Bowl {
    /// Mean over the whole width, m: `d + q w^2 / 24`.
    pub fn mean(&self) -> f64 {
        self.middle + self.bend * self.half * self.half / 6.0
    }

    /// What is above `level` [m]. Where the overlap bends upwards it is taken as straight, with the same mean.
    pub fn above(&self, level: f64) -> Cut {
        let Bowl { slope, bend, half, .. } = *self;
        let (here, bend) = if bend < 0.0 { (self.middle - level, bend) } else { (self.mean() - level, 0.0) };
        let at = |x: f64| here + x * (slope + 0.5 * bend * x);
        let [first, last] = if at(-half) >= 0.0 && at(half) >= 0.0 {
            [-half, half]
        } else {
            let square = slope * slope - 2.0 * bend * here;
            if !(square > 0.0) {
                return Cut::default();
            }
            // The root that loses no digits, and the other one by their product; without a bend it lies at infinity.
            let sum = -(slope + square.sqrt().copysign(slope));
            let far = if bend < 0.0 { sum / bend } else { f64::INFINITY.copysign(slope) };
            let near = 2.0 * here / sum;
            [near.min(far).max(-half), near.max(far).min(half)]
        };
        if !(last > first) {
            return Cut::default();
        }
        let (offset, reach) = (0.5 * (first + last), 0.5 * (last - first));
        let (value, slope, squared) = (at(offset), slope + bend * offset, reach * reach);
        let mean = value + bend * squared / 6.0;
        let square = value * value + squared / 3.0 * (slope * slope + value * bend) + bend * bend * squared * squared / 20.0;
        Cut { share: reach / half, offset, mean, square }
    }
}

/// The overlap over each strip.
///
/// In the middle of a patch it goes through both neighbours. Beyond the first strip whose overlap is below -[`BESIDE`] none is known, and at the edge of a patch (below a
/// third of the greater neighbour, the more the lower; all counted from -[`BESIDE`] up) it goes on as it bends over the neighbours, weighted by their overlap:
/// nothing jumps where strips come in or go out. Counted from 0, the half of a patch that lay beyond the border of a strip came in when the strip's middle touched,
/// and a load of 28 N became one of 40 N. `arcs` and `overlaps` are those of the strips, m.
pub(super) fn bowls(
    rail: &RailStrips,
    pressed: &[Pressed],
    (arcs, overlaps): (&[f64], &[f64]),
    bowls: &mut Vec<Bowl>,
    bends: &mut Vec<f64>,
) {
    let count = pressed.len();
    let (arc, overlap) = (|k: usize| arcs[k], |k: usize| overlaps[k]);
    let beside = |k: usize| {
        [k.checked_sub(1), Some(k + 1).filter(|other| *other < count)]
            .map(|other| other.filter(|other| pressed[*other].number.abs_diff(pressed[k].number) == 1))
    };
    bowls.clear();
    bends.clear();
    for (k, strip) in pressed.iter().enumerate() {
        let (middle, half) = (strip.strip.overlap, 0.5 * rail.strip(strip.number).width);
        let [Some(before), Some(after)] = beside(k) else {
            bowls.push(Bowl { middle, half, ..Bowl::default() });
            bends.push(0.0);
            continue;
        };
        let (back, ahead) = (arc(k) - arc(before), arc(after) - arc(k));
        let (down, up) = ((middle - overlap(before)) / back, (overlap(after) - middle) / ahead);
        let bend = 2.0 * (up - down) / (back + ahead);
        bowls.push(Bowl { middle, slope: (down * ahead + up * back) / (back + ahead), bend, half });
        bends.push(bend);
    }
    for (k, bowl) in bowls.iter_mut().enumerate() {
        let own = *bowl;
        let (near, reach) = (beside(k), |k: usize| overlap(k) + BESIDE);
        let greatest = near.iter().flatten().map(|other| reach(*other)).fold(0.0, f64::max);
        let part = match near {
            _ if !(reach(k) > 0.0) => 0.0,
            [Some(_), Some(_)] if !(greatest > 1.5 * reach(k)) => 1.0,
            [Some(_), Some(_)] => (2.0 * reach(k) / (greatest - reach(k))).min(1.0),
            _ => 0.0,
        };
        if part == 1.0 {
            continue;
        }
        let part = cubic_step(part);
        let (mut weight, mut slope, mut bend) = (0.0, 0.0, 0.0);
        for other in near.into_iter().flatten().filter(|other| reach(*other) > 0.0) {
            let (own_weight, way) = (reach(other), arc(other) - arc(k));
            weight += own_weight;
            slope += own_weight * ((overlap(other) - own.middle) / way - 0.5 * bends[other] * way);
            bend += own_weight * bends[other];
        }
        if weight > 0.0 {
            bowl.slope = slope / weight + part * (own.slope - slope / weight);
            bowl.bend = bend / weight + part * (own.bend - bend / weight);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_parts_above_a_level_have_the_means_of_their_parabola() {
        let mut worst: f64 = 0.0;
        for (middle, slope, bend) in
            [(5e-6, 0.0, -80.0), (1e-6, 0.02, -60.0), (-2e-6, 0.03, -70.0), (3e-6, -0.01, 0.0), (2e-6, -0.03, -1e-9), (4e-6, 0.01, 20.0)]
        {
            let bowl = Bowl { middle, slope, bend, half: 1.7e-4 };
            for level in [-1e-3, 0.0, 2e-6, 4.9e-6] {
                let cut = bowl.above(level);
                let n = 200_000;
                let (bend, middle) = if bend > 0.0 { (0.0, bowl.mean()) } else { (bend, middle) };
                let (mut sums, mut count) = ([0.0; 3], 0.0);
                for k in 0..n {
                    let x = bowl.half * ((2 * k + 1) as f64 / n as f64 - 1.0);
                    let value = middle + slope * x + 0.5 * bend * x * x - level;
                    if value > 0.0 {
                        sums = [sums[0] + x, sums[1] + value, sums[2] + value * value];
                        count += 1.0;
                    }
                }
                if count < 100.0 {
                    assert!(cut.share < 1e-3, "{cut:?}");
                    continue;
                }
                let off = [
                    cut.share / (count / n as f64) - 1.0,
                    (cut.offset - sums[0] / count) / bowl.half,
                    cut.mean / (sums[1] / count) - 1.0,
                    cut.square / (sums[2] / count) - 1.0,
                ];
                worst = off.iter().fold(worst, |worst, off| worst.max(off.abs()));
            }
        }
        println!("worst {worst:e}");
        assert!(worst < 2e-4, "{worst}");
        assert_eq!(Bowl { middle: -1e-6, slope: 0.0, bend: -50.0, half: 2e-4 }.above(0.0), Cut::default());
    }
}
