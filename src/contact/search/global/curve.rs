//! A profile cut into short stretches with bounds on direction and curvature.
//!
//! The curve (x, y(x)) is cut at its kinks and at jumps of its curvature, and between them so that no stretch is longer
//! than `LONGEST` nor turns by more than `MOST_TURN`. A kink is a stretch of its own: two knots at the same place with the
//! directions before and behind it. Directions are angles `turn * atan(y')`, curvatures `turn * y'' / (1 + y'^2)^1.5`, with
//! `turn` +1 for a rail and -1 for a wheel, whose radius counts downward.
//!
//! Bounds are taken from nine samples in a stretch, widened by half the largest difference between neighbouring samples:
//! exact for curvatures that run monotone between samples, and wrong only for a feature shorter than an eighth of a stretch
//! (0.1 mm) that shows in none of the samples.

use crate::geometry::profile::{Profile, ProfilePoint};

/// Where a stretch begins or ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knot {
    pub x: f64,
    pub y: f64,
    pub slope: f64,
    /// rad.
    pub angle: f64,
    pub cos: f64,
    pub sin: f64,
}

/// What holds all over a stretch or several.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// Least and greatest direction, rad.
    pub angle: (f64, f64),
    /// Least and greatest curvature, 1/m.
    pub curvature: (f64, f64),
    /// Length of the curve, m.
    pub length: f64,
    /// Greatest |y'|.
    pub steepest: f64,
    /// Greatest `y (1 + y'^2)^1.5`, m, and integral of `y |y''| sqrt(1 + y'^2)`, m: how a yawed wheel's trace differs from
    /// its profile.
    pub swell: f64,
    pub swing: f64,
}

impl Bounds {
    pub const NONE: Bounds = Bounds {
        angle: (f64::INFINITY, f64::NEG_INFINITY),
        curvature: (f64::INFINITY, f64::NEG_INFINITY),
        length: 0.0,
        steepest: 0.0,
        swell: 0.0,
        swing: 0.0,
    };

    #[inline]
    pub fn merge(&self, other: &Bounds) -> Bounds {
        Bounds {
            angle: (self.angle.0.min(other.angle.0), self.angle.1.max(other.angle.1)),
            curvature: (self.curvature.0.min(other.curvature.0), self.curvature.1.max(other.curvature.1)),
            length: self.length + other.length,
            steepest: self.steepest.max(other.steepest),
            swell: self.swell.max(other.swell),
            swing: self.swing + other.swing,
        }
    }
}

/// Longest stretch, m.
const LONGEST: f64 = 1e-3;
/// Greatest turn of a stretch, rad.
const MOST_TURN: f64 = 0.04;
/// Spacing at which a profile is looked at for kinks and jumps, m.
const GRID: f64 = 5e-5;
/// Most samples of that kind.
const MOST_SAMPLES: f64 = 2e4;
/// Turn, rad, from which a change of direction within `SHARP` is a kink.
const KINK: f64 = 1e-6;
/// Length, m, to which kinks and jumps are enclosed.
const SHARP: f64 = 1e-10;
/// Curvature of a kink, 1/m.
pub(super) const SHARPEST: f64 = 1e9;

#[derive(Clone, Debug)]
pub(super) struct Curve {
    pub knots: Vec<Knot>,
    /// One less than knots.
    pub stretches: Vec<Bounds>,
}

fn angle(p: &ProfilePoint) -> f64 {
    p.d1.atan()
}

fn curvature(p: &ProfilePoint) -> f64 {
    let rise = 1.0 + p.d1 * p.d1;
    p.d2 / (rise * rise.sqrt())
}

/// A place of the profile: (x, y), direction and curvature.
#[derive(Clone, Copy)]
struct Sample {
    x: f64,
    y: f64,
    angle: f64,
    curvature: f64,
}

impl Sample {
    fn new(profile: &dyn Profile, x: f64) -> Self {
        let p = profile.at(x);
        Sample { x, y: p.value, angle: angle(&p), curvature: curvature(&p) }
    }
}

/// Turn between two places that their curvatures don't explain, rad, and the difference of the curvatures.
fn surprise(p: &Sample, q: &Sample) -> (f64, f64) {
    let (dx, dy) = (q.x - p.x, q.y - p.y);
    let expected = 0.5 * (p.curvature + q.curvature) * (dx * dx + dy * dy).sqrt();
    ((q.angle - p.angle - expected).abs(), (q.curvature - p.curvature).abs())
}

/// A place where the curve is cut; a kink needs both sides.
#[derive(Clone, Copy, Debug)]
struct Cut {
    before: f64,
    behind: f64,
    kink: bool,
}

/// The cut at a known joint.
fn around(profile: &dyn Profile, x: f64) -> Cut {
    let (before, behind) = (x - 0.5 * SHARP, x + 0.5 * SHARP);
    let kink = (angle(&profile.at(behind)) - angle(&profile.at(before))).abs() > KINK;
    Cut { before, behind, kink }
}

/// Encloses a kink or a jump of the curvature between `a` and `b`, if there is one.
fn cut(profile: &dyn Profile, mut a: Sample, mut b: Sample) -> Option<Cut> {
    let (turn, jump) = surprise(&a, &b);
    let level = 0.5 + 0.02 * a.curvature.abs();
    if turn < 2.0 * KINK && jump < level {
        return None;
    }
    while b.x - a.x > SHARP {
        let middle = Sample::new(profile, 0.5 * (a.x + b.x));
        let ((turn_left, jump_left), (turn_right, jump_right)) = (surprise(&a, &middle), surprise(&middle, &b));
        // A kink hides in the half that turns by surprise, a jump in the half whose curvature changes more.
        let left = if turn_left.max(turn_right) > KINK { turn_left >= turn_right } else { jump_left >= jump_right };
        if left { b = middle } else { a = middle }
    }
    let kink = (b.angle - a.angle).abs() > KINK;
    let jumps = (b.curvature - a.curvature).abs() > 0.5 * level;
    (kink || jumps).then_some(Cut { before: a.x, behind: b.x, kink })
}

/// The part of a profile's range, around 0 or its middle, in which it is finite and no steeper than `steepest`.
fn usable(profile: &dyn Profile, steepest: f64) -> (f64, f64) {
    let (first, last) = profile.range();
    let good = |x: f64| {
        let p = profile.at(x);
        p.value.is_finite() && p.d1.abs() <= steepest && p.d2.is_finite()
    };
    let centre = if first < 0.0 && last > 0.0 && good(0.0) { 0.0 } else { 0.5 * (first + last) };
    let step = GRID.max((last - first) / MOST_SAMPLES);
    let limit = |end: f64| {
        let steps = ((end - centre).abs() / step).ceil().max(1.0);
        let at = |i: f64| if i >= steps { end } else { centre + (end - centre) * i / steps };
        let mut i = 0.0;
        while i < steps && good(at(i + 1.0)) {
            i += 1.0;
        }
        if i == steps {
            return end;
        }
        let (mut inside, mut outside) = (at(i), at(i + 1.0));
        while (outside - inside).abs() > SHARP {
            let middle = 0.5 * (inside + outside);
            if good(middle) { inside = middle } else { outside = middle }
        }
        inside
    };
    (limit(first), limit(last))
}

impl Curve {
    pub fn new(profile: &dyn Profile, turn: f64, steepest: f64) -> Self {
        let (first, last) = usable(profile, steepest);
        // Jumps that the profile knows of first: they may lie closer than the grid.
        let mut known: Vec<f64> = profile.joints().into_iter().chain(profile.kinks()).filter(|x| *x > first && *x < last).collect();
        known.sort_by(f64::total_cmp);
        known.dedup();
        let mut cuts: Vec<Cut> = known.iter().map(|x| around(profile, *x)).collect();
        for ends in [first].iter().chain(&known).zip(known.iter().chain(&[last])) {
            let (from, to) = (ends.0 + 2.0 * SHARP, ends.1 - 2.0 * SHARP);
            let samples = ((to - from) / GRID).clamp(1.0, MOST_SAMPLES).ceil();
            let grid = |i: usize| Sample::new(profile, from + (to - from) * i as f64 / samples);
            let mut before = grid(0);
            cuts.extend((1..=samples as usize).filter_map(|i| {
                let here = grid(i);
                cut(profile, std::mem::replace(&mut before, here), here)
            }));
        }
        cuts.sort_by(|a, b| a.before.total_cmp(&b.before));
        let mut curve = Curve { knots: vec![knot(profile, first, turn)], stretches: vec![] };
        let mut from = first;
        for cut in &cuts {
            // Two cuts in one place would be one cut that a grid point happened to meet.
            if cut.before > from + 4.0 * SHARP {
                curve.smooth(profile, turn, from, cut.before);
            }
            if cut.kink {
                curve.kink(profile, turn, cut);
            }
            from = cut.behind;
        }
        if last > from {
            curve.smooth(profile, turn, from, last);
        }
        curve
    }

    /// Knots at which the curvature jumps, those of kinks among them.
    pub fn joints(&self) -> impl Iterator<Item = usize> {
        let jumps = |knot: &usize| {
            let [a, b] = [knot - 1, *knot].map(|stretch| self.stretches[stretch].curvature);
            a.1 < b.0 || b.1 < a.0
        };
        (1..self.stretches.len()).filter(jumps)
    }

    /// Appends stretches up to `to`, with even shares of length and turn.
    fn smooth(&mut self, profile: &dyn Profile, turn: f64, from: f64, to: f64) {
        let samples = ((to - from) / GRID).clamp(16.0, MOST_SAMPLES).ceil() as usize;
        let x = |i: usize| if i == samples { to } else { from + (to - from) * i as f64 / samples as f64 };
        let mut share = Vec::with_capacity(samples + 1);
        share.push(0.0);
        let place = |i: usize| {
            let p = profile.at(x(i));
            (x(i), p.value, angle(&p))
        };
        let mut previous = place(0);
        let mut total = 0.0;
        for i in 1..=samples {
            let here = place(i);
            let (dx, dy) = (here.0 - previous.0, here.1 - previous.1);
            total += (dx * dx + dy * dy).sqrt() / LONGEST + (here.2 - previous.2).abs() / MOST_TURN;
            share.push(total);
            previous = here;
        }
        let count = total.ceil().max(1.0) as usize;
        let (mut left, mut i) = (from, 0);
        for piece in 1..=count {
            let target = total * piece as f64 / count as f64;
            while i + 1 < samples && share[i + 1] < target {
                i += 1;
            }
            let part = ((target - share[i]) / (share[i + 1] - share[i])).clamp(0.0, 1.0);
            let right = if piece == count { to } else { x(i) + part * (x(i + 1) - x(i)) };
            if right > left {
                self.stretches.push(stretch(profile, turn, left, right));
                self.knots.push(knot(profile, right, turn));
            }
            left = right;
        }
    }

    fn kink(&mut self, profile: &dyn Profile, turn: f64, cut: &Cut) {
        let (a, b) = (profile.at(cut.before), profile.at(cut.behind));
        let bend = turn * (angle(&b) - angle(&a));
        let sharp = SHARPEST.copysign(bend);
        let (from, to) = (turn * angle(&a), turn * angle(&b));
        let steepest = a.d1.abs().max(b.d1.abs());
        let rise = (1.0 + steepest * steepest).sqrt();
        self.stretches.push(Bounds {
            angle: (from.min(to), from.max(to)),
            curvature: (sharp, sharp),
            length: 0.0,
            steepest,
            swell: a.value * rise.powi(3),
            swing: a.value * (b.d1 - a.d1).abs() * rise,
        });
        // Both knots stand at the same place.
        let place = self.knots.last().map_or(cut.before, |k| k.x);
        self.knots.push(Knot { x: place, ..knot(profile, cut.behind, turn) });
    }
}

fn knot(profile: &dyn Profile, x: f64, turn: f64) -> Knot {
    let p = profile.at(x);
    let angle = turn * angle(&p);
    let (sin, cos) = angle.sin_cos();
    Knot { x, y: p.value, slope: p.d1, angle, cos, sin }
}

fn stretch(profile: &dyn Profile, turn: f64, from: f64, to: f64) -> Bounds {
    const PARTS: usize = 8;
    // The ends may be the wrong side of a jump.
    let inset = (0.01 * (to - from)).min(SHARP);
    let points: [ProfilePoint; PARTS + 1] =
        std::array::from_fn(|i| profile.at((from + (to - from) * i as f64 / PARTS as f64).clamp(from + inset, to - inset)));
    let step = (to - from) / PARTS as f64;
    let mut bounds = Bounds::NONE;
    let mut change: f64 = 0.0;
    let mut previous: Option<ProfilePoint> = None;
    for p in points {
        let (a, c) = (turn * angle(&p), turn * curvature(&p));
        bounds.angle = (bounds.angle.0.min(a), bounds.angle.1.max(a));
        bounds.curvature = (bounds.curvature.0.min(c), bounds.curvature.1.max(c));
        let rise = (1.0 + p.d1 * p.d1).sqrt();
        bounds.steepest = bounds.steepest.max(p.d1.abs());
        bounds.swell = bounds.swell.max(p.value * rise.powi(3));
        bounds.swing = bounds.swing.max(p.value.abs() * p.d2.abs() * rise);
        if let Some(before) = previous {
            change = change.max((c - turn * curvature(&before)).abs());
            bounds.length += step.hypot(p.value - before.value);
        }
        previous = Some(p);
    }
    let margin = 0.5 * change + 1e-9;
    bounds.curvature = (bounds.curvature.0 - margin, bounds.curvature.1 + margin);
    // Directions run monotone unless the curvature changes its sign.
    if bounds.curvature.0 < 0.0 && bounds.curvature.1 > 0.0 {
        let most = bounds.curvature.1.max(-bounds.curvature.0) * bounds.length / PARTS as f64;
        bounds.angle = (bounds.angle.0 - most, bounds.angle.1 + most);
    }
    bounds.swing *= to - from;
    // Chords are shorter than the arc by a 24th of the squared turn.
    bounds.length *= 1.0 + 1e-4;
    bounds
}
