//! Half lengths of the strips of one wheel, before their loads are known.

use super::cut::{BESIDE, Bowl, Cut, bowls};
use super::pressed::Pressed;
use super::rail::RailStrips;
use crate::math::elementary::power;
use crate::math::smooth_step::cubic_step;

/// Strips within this distance make one patch whose proportions are taken together, m: their weights fall smoothly from 1 for a strip itself to 0 there, and
/// where the overlap has several humps to 0 where a gap parts them (`joined`).
const WINDOW: f64 = 12e-3;
/// Strips that are in contact over this part of their width are cut there; over less, by less: a patch that ends within the strip, and one that lies within it.
const CUT: (f64, f64) = (0.8, 0.4);
/// Half lengths are at least this, m: at the edge of a patch they go to nothing.
const SHORTEST: f64 = 1.5e-4;

/// Numbers that run along the strips, for the vector instructions of the compiler.
#[derive(Clone, Debug, Default)]
pub(super) struct Lengths {
    /// Places of the strips' middles, m.
    pub arcs: Vec<f64>,
    overlaps: Vec<f64>,
    /// 1/m.
    curvatures: Vec<f64>,
    /// Sums of the overlap and of its square over the section, m^2 and m^3.
    first: Vec<f64>,
    second: Vec<f64>,
    /// How far one strip and each of the others are of one patch.
    joints: Vec<f64>,
    /// The overlap over the width of each strip.
    bowls: Vec<Bowl>,
    bends: Vec<f64>,
    /// How far the patch covers each strip.
    pub covers: Vec<Cover>,
}

/// How far the patch covers a strip.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cover {
    /// Mean overlap over the strip's whole width, and over what of it is in contact, m; the same where nothing is.
    pub whole: f64,
    pub pressed: f64,
    /// How far it is cut to what is in contact, 0 to 1.
    pub cut: f64,
    /// Is the mean over the whole above the edge of the patch?
    pub above: bool,
}

impl Lengths {
    pub fn new(strips: usize) -> Lengths {
        let reals = || Vec::with_capacity(strips);
        Lengths {
            arcs: reals(),
            overlaps: reals(),
            curvatures: reals(),
            first: reals(),
            second: reals(),
            joints: reals(),
            bowls: Vec::with_capacity(strips),
            bends: reals(),
            covers: Vec::with_capacity(strips),
        }
    }

    /// Half lengths as in the Hertzian patch of the same proportions, and which strips carry load at first (`inside`).
    ///
    /// Strips end where the patch does: `width` and `offset` are those of what is above its edge ([`super::cut`]).
    ///
    /// There `A a^2 + B b^2 = delta`, and the strip at the edge still overlaps by `e delta` with `e = A a^2 / delta`, a function of A / B alone that is
    /// `1 / (1 + (A / B)^0.3)` to 0.013 from b/a = 1/20 to 20: `a_i^2 = 2 e (d_i - e delta) / ((1 - e) kappa_i)`. B and delta are those of the parabola
    /// with the same sums of d and d^2 over what is near; A is kappa / 2.
    ///
    /// What lies beyond a gap is another patch: with the proportions of a patch on the tread, 10 mm off and 50 um deep, strips of a flange that overlapped by
    /// 10 um counted as its edge. They were 0.15 mm long and carried a fifth of what half-spaces do, until 2 um more made them ten times as stiff: a tram's leading
    /// wheel swung between the two at 173 Hz.
    pub fn find(&mut self, rail: &RailStrips, pressed: &mut [Pressed], inside: &mut Vec<bool>) {
        let Lengths { arcs, overlaps, curvatures, first, second, joints, bowls: over, bends, covers } = self;
        let count = pressed.len();
        for (reals, of) in [
            (&mut *arcs, (|own, rail| rail.strip(own.number).arc) as fn(&Pressed, &RailStrips) -> f64),
            (overlaps, |own, _| own.strip.overlap),
            (curvatures, |own, _| own.strip.curvature),
        ] {
            reals.clear();
            reals.extend(pressed.iter().map(|own| of(own, rail)));
        }
        joints.resize(count, 1.0);
        for sum in [&mut *first, &mut *second] {
            sum.clear();
            sum.resize(count, 0.0);
        }
        bowls(rail, pressed, (arcs, overlaps), over, bends);
        let several = humps(overlaps) > 1;
        for k in 0..count {
            let whole = over[k].above(0.0);
            if !(whole.share > 0.0) {
                continue;
            }
            let width = 2.0 * over[k].half * whole.share;
            let (arc, area, moment) = (arcs[k], width * whole.mean, width * whole.square);
            let sums = first.iter_mut().zip(second.iter_mut()).zip(arcs.iter());
            if several {
                joined(overlaps, k, joints);
                for (((first, second), own), joint) in sums.zip(joints.iter()) {
                    let weight = near(own - arc) * joint;
                    *first += weight * area;
                    *second += weight * moment;
                }
            } else {
                for ((first, second), own) in sums {
                    let weight = near(own - arc);
                    *first += weight * area;
                    *second += weight * moment;
                }
            }
        }
        inside.clear();
        covers.clear();
        for (k, own) in pressed.iter_mut().enumerate() {
            // 5/4 of the ratio is delta, and 4/3 delta sqrt(delta / B) the first sum.
            let deepest = 1.25 * second[k] / first[k];
            let half_width = 0.75 * first[k] / deepest;
            let edge = 1.0 / (1.0 + power(0.5 * curvatures[k] * half_width * half_width / deepest, 0.3));
            let level = edge * deepest;
            let above = over[k].above(level);
            let touches = above.share > 0.0;
            let square = if touches { 2.0 * edge * above.mean / ((1.0 - edge) * curvatures[k]) } else { 0.0 };
            own.half_length = square.max(SHORTEST * SHORTEST).sqrt();
            // A strip that is hardly above the edge counts as a whole, so that it comes into contact without a jump.
            let part = cubic_step(above.share / most_uncut(&above, over[k].half));
            let mixed = |whole: f64, cut: f64| whole + part * (cut - whole);
            own.width = 2.0 * over[k].half * mixed(1.0, above.share);
            own.offset = part * above.offset;
            inside.push(touches);
            let whole = over[k].mean();
            // The level of a strip without overlaps near it is not a number.
            let pressed = if touches { level + above.mean } else { whole };
            // Not the mean over the whole: at the edge of a patch that is a gap.
            own.depth = own.strip.overlap.max(pressed);
            covers.push(Cover { whole, pressed, cut: part, above: whole > level });
        }
    }
}

/// Up to which part of its width a strip that is in contact over a part is cut by less: more where the patch goes on in the next strip than where it lies within this one.
fn most_uncut(above: &Cut, half: f64) -> f64 {
    let beside = half * (1.0 - above.share);
    let ends = if beside > 0.0 { (above.offset.abs() / beside).min(1.0) } else { 1.0 };
    CUT.1 + (CUT.0 - CUT.1) * ends
}

/// How often the overlap rises and falls along the strips.
fn humps(overlaps: &[f64]) -> usize {
    let (mut count, mut rising) = (0, false);
    for (before, after) in overlaps.iter().zip(&overlaps[1.min(overlaps.len())..]) {
        if after > before && !rising {
            (count, rising) = (count + 1, true);
        } else if after < before {
            (count, rising) = (count.max(1), false);
        }
    }
    count
}

/// How far one strip and each of the others are of one patch: the least overlap on the way between them in parts of the smaller one of the two, counted from
/// -[`BESIDE`] up, from where on strips may carry. Where nothing overlaps on the way they are of two; on one hump of the overlap it is 1.
fn joined(overlaps: &[f64], from: usize, joints: &mut [f64]) {
    let own = overlaps[from] + BESIDE;
    let mut go = |k: usize, least: &mut f64| {
        let there = overlaps[k] + BESIDE;
        *least = if there < *least { there } else { *least };
        let smaller = if there < own { there } else { own };
        joints[k] = if smaller > 0.0 && *least < smaller { least.max(0.0) / smaller } else { 1.0 };
    };
    let mut least = own;
    (0..=from).rev().for_each(|k| go(k, &mut least));
    least = own;
    (from..overlaps.len()).for_each(|k| go(k, &mut least));
}

/// Weight of what lies so far away, m.
#[inline(always)]
fn near(apart: f64) -> f64 {
    let part = apart * (1.0 / WINDOW);
    let left = 1.0 - part * part;
    let left = if left > 0.0 { left } else { 0.0 };
    left * left
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_strips_are_of_one_patch_as_far_as_the_overlap_between_them_goes() {
        let joints = |overlaps: &[f64], from: usize| {
            let mut joints = vec![1.0; overlaps.len()];
            joined(overlaps, from, &mut joints);
            joints
        };
        let one = [-1.0, 2.0, 5.0, 7.0, 7.0, 3.0, -2.0];
        assert!(humps(&one) == 1 && (0..7).all(|k| joints(&one, k) == [1.0; 7]));
        let parted = [1.0, 6.0, -0.1, 2.0, 3.0];
        assert!(humps(&parted) == 2 && joints(&parted, 4) == [0.0, 0.0, 1.0, 1.0, 1.0] && joints(&parted, 1) == [1.0, 1.0, 1.0, 0.0, 0.0]);
        // A valley joins continuously.
        let valley = joints(&[8.0, 1.5, 3.0], 2);
        assert!((valley[0] - 0.5).abs() < 1e-6 && valley[1..] == [1.0, 1.0], "{valley:?}");
        assert!(humps(&[]) == 0 && humps(&[3.0, 2.0]) == 1 && humps(&[2.0, 1.0, 2.0]) == 2);
    }
}
