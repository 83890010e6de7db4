//! Wheels that are not round: by how much a wheel's radius differs around it.
//!
//! With the angle a that the wheel has turned (rolling forward positive; the place `at` = a is the lowest then) the radius at its lowest point is R + d(a):
//!
//! ```text
//! polygon:  d = depth / 2  cos(n a - phase)
//! flat:     d = -depth / 2  (1 + cos(2 pi x / length)),   x = R (a - at) within +- length / 2, else 0
//! ```
//!
//! A flat is one whose ends have been rolled round: the haversine of Newton and Clark (1979). All this grows from nothing over the first turn from where the
//! run begins, as a wheel that stands still knows nothing of the rest of it: `d S(|a| / 2 pi)`, S a smooth step with two continuous derivatives.
//!
//! A rail is not touched by the lowest point but by the one that stands out most, ahead by the angle f: the wheel's centre rides at
//!
//! ```text
//! R + D(a) = max over f of (R + d(a + f)) cos f      d'(a + f) cos f = (R + d(a + f)) sin f
//! D' = d' cos f,   D'' = d'' (1 + f') cos f - d' f' sin f,   D''' about d''' (1 + f')^3,   1 + f' about 1 / (1 - d'' / R)
//! ```
//!
//! as a round wheel does over a dip of the rail of that shape: at the bottom of a flat that bends by k the centre's path bends by k / (1 - R k). So the surface may not bend inward more than
//! `0.9 / R` (else a wheel stands on two places at once): a polygon has `depth n^2 / 2 < 0.9 R` and a flat `2 pi^2 depth R < 0.9 length^2`. The contact is taken for a point; patches of 12 mm
//! smooth waves below some 50 mm, which is left out.

use crate::settings::{Section, SettingsError};
use crate::units::Dimension;
use std::f64::consts::TAU;

/// Inward bend in parts of 1 / R that a wheel may have.
const MOST_BENT: f64 = 0.9;
/// Least steps in a wave of the surface.
const STEPS_IN_WAVE: f64 = 4.0;
/// Longest wave that steps are told of, rad: the first turn's growth, too.
const LONGEST: f64 = TAU;

/// Nearer than this to the edge of a flat a wheel has reached it, rad: its rate is known to a part of the way to go.
const AT_EDGE: f64 = 2e-5;
/// So far behind an edge steps end, rad: the next one begins with what is behind it.
const BEHIND: f64 = 1e-5;

/// One deviation from the circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// n; half of its depth [m]; phase [rad].
    Polygon { order: f64, amplitude: f64, phase: f64 },
    /// Its place and half its length as angles [rad]; half its depth [m].
    Flat { at: f64, half: f64, amplitude: f64 },
}

impl Shape {
    /// d and its first three derivatives by the angle, m/rad and so on.
    fn at(&self, angle: f64) -> [f64; 4] {
        match *self {
            Shape::Polygon { order: n, amplitude, phase } => {
                let (sin, cos) = (n * angle - phase).sin_cos();
                [amplitude * cos, -amplitude * n * sin, -amplitude * n * n * cos, amplitude * n * n * n * sin]
            }
            Shape::Flat { at, half, amplitude } => {
                let off = from(at, angle);
                if off.abs() >= half {
                    return [0.0; 4];
                }
                let wave = std::f64::consts::PI / half;
                let (sin, cos) = (wave * off).sin_cos();
                [-amplitude * (1.0 + cos), amplitude * wave * sin, amplitude * wave * wave * cos, -amplitude * wave * wave * wave * sin]
            }
        }
    }

    /// R k: how far it bends inward at most, in parts of what a wheel of the radius R [m] bends outward.
    fn bent(&self, radius: f64) -> f64 {
        match *self {
            Shape::Polygon { order, amplitude, .. } => amplitude * order * order / radius,
            Shape::Flat { half, amplitude, .. } => amplitude * (std::f64::consts::PI / half).powi(2) / radius,
        }
    }

    /// How far the wheel may turn in one step from `angle` in the direction of `sign`, rad; `sharp` is the width of the path's bends in parts of those of the wheel.
    fn reach(&self, angle: f64, sign: f64, sharp: f64) -> f64 {
        match *self {
            Shape::Polygon { order, .. } => sharp * TAU / order / STEPS_IN_WAVE,
            Shape::Flat { at, half, .. } => {
                let off = sign * from(at, angle);
                // The flat begins ahead at -half; behind it the next time is a turn away.
                let ahead = if off > half { TAU - half - off } else { (-half - off).max(0.0) };
                ahead + sharp * 2.0 * half / STEPS_IN_WAVE
            }
        }
    }
}

/// The angle from `at`, -pi to pi.
fn from(at: f64, angle: f64) -> f64 {
    let off = (angle - at).rem_euclid(TAU);
    if off > std::f64::consts::PI { off - TAU } else { off }
}

/// All of a wheel.
#[derive(Clone, Debug, PartialEq)]
pub struct OutOfRound {
    /// R, m.
    pub radius: f64,
    pub shapes: Vec<Shape>,
}

/// Steps to the point that stands out most, and where they end, rad.
const MOST_STEPS: usize = 40;
const LAST: f64 = 1e-15;
/// Farthest that it may lead, rad.
const FARTHEST: f64 = 1.0;

impl OutOfRound {
    /// D [m] and its first three derivatives by the angle, m/rad and so on, where the wheel has turned by `angle` [rad] since the run began.
    pub fn at(&self, angle: f64) -> [f64; 4] {
        // g(f) falls: Newton's method between what is known to lie on either side.
        let (mut low, mut high, mut lead) = (-FARTHEST, FARTHEST, 0.0_f64);
        for _ in 0..MOST_STEPS {
            let ([d, d1, d2, _], (sin, cos)) = (self.radius_at(angle + lead), lead.sin_cos());
            let g = d1 * cos - (self.radius + d) * sin;
            if g > 0.0 {
                low = lead;
            } else {
                high = lead;
            }
            let slope = d2 * cos - 2.0 * d1 * sin - (self.radius + d) * cos;
            let next = lead - g / slope;
            // Rounding may end it at a bound: that is no reason to go back to the middle.
            let next = if slope < 0.0 && (low..=high).contains(&next) { next } else { 0.5 * (low + high) };
            let step = next - lead;
            lead = next;
            if step.abs() < LAST {
                break;
            }
        }
        let ([d, d1, d2, d3], (sin, cos)) = (self.radius_at(angle + lead), lead.sin_cos());
        let by_angle = d2 * cos - d1 * sin;
        let leading = by_angle / ((self.radius + d) * cos + d1 * sin - by_angle);
        let turned = 1.0 + leading;
        [(self.radius + d) * cos - self.radius, d1 * cos, d2 * turned * cos - d1 * leading * sin, d3 * turned * turned * turned]
    }

    /// d and its derivatives likewise: what the radius of the place `angle` is more.
    pub fn radius_at(&self, angle: f64) -> [f64; 4] {
        let mut sum = [0.0; 4];
        for shape in &self.shapes {
            sum.iter_mut().zip(shape.at(angle)).for_each(|(sum, own)| *sum += own);
        }
        let x = angle.abs() / TAU;
        if x >= 1.0 {
            return sum;
        }
        let rate = angle.signum() / TAU;
        let grown = x * x * x * (10.0 - x * (15.0 - 6.0 * x));
        let growing = 30.0 * x * x * (1.0 - x) * (1.0 - x) * rate;
        let bending = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) * rate * rate;
        let last = 60.0 * (1.0 - x * (6.0 - 6.0 * x)) * rate * rate * rate;
        let [d, d1, d2, d3] = sum;
        [
            grown * d,
            grown * d1 + growing * d,
            grown * d2 + 2.0 * growing * d1 + bending * d,
            grown * d3 + 3.0 * (growing * d2 + bending * d1) + last * d,
        ]
    }

    /// How far the wheel may turn in one step in the direction of `rate`, rad.
    pub fn reach(&self, angle: f64, rate: f64) -> f64 {
        let sign = if rate < 0.0 { -1.0 } else { 1.0 };
        let bent: f64 = self.shapes.iter().map(|shape| shape.bent(self.radius)).fold(0.0, f64::max);
        let sharp = (1.0 - bent).max(1.0 - MOST_BENT);
        self.shapes.iter().map(|shape| shape.reach(angle, sign, sharp)).fold(LONGEST / STEPS_IN_WAVE, f64::min)
    }

    /// How far the wheel turns in the direction of `rate` until the next edge of a flat, where the second derivative jumps, lies just behind, rad.
    pub fn next_edge(&self, angle: f64, rate: f64) -> Option<f64> {
        let sign = if rate < 0.0 { -1.0 } else { 1.0 };
        let edges = self.shapes.iter().filter_map(|shape| match *shape {
            Shape::Flat { at, half, .. } => Some([at - half, at + half]),
            Shape::Polygon { .. } => None,
        });
        let ahead = |edge: f64| {
            let off = (sign * (edge - angle)).rem_euclid(TAU);
            BEHIND + if off > AT_EDGE { off } else { off + TAU }
        };
        edges.flatten().map(ahead).reduce(f64::min)
    }

    /// What it is, for `wheelrail plan`.
    pub fn describe(&self) -> String {
        let one = |shape: &Shape| match shape {
            Shape::Polygon { order, amplitude, .. } => format!("polygon of order {order}, {:.3} mm deep", 2e3 * amplitude),
            Shape::Flat { half, amplitude, .. } => {
                format!("flat over {:.1} degrees, {:.3} mm deep", 2.0 * half.to_degrees(), 2e3 * amplitude)
            }
        };
        self.shapes.iter().map(one).collect::<Vec<_>>().join(", ")
    }

    /// Reads `[[out_of_round]]` of a wheelset whose wheels have the radii `radii` [m]: left and right wheel.
    ///
    /// # Errors
    /// [`SettingsError`] with file and line.
    pub fn parse(wheelset: &Section, radii: [f64; 2]) -> Result<[Option<OutOfRound>; 2], SettingsError> {
        let mut read: [Vec<Shape>; 2] = Default::default();
        for section in wheelset.sections("out_of_round")? {
            let wheel = section.word_or("wheel", &["both", "left", "right"], "both")?;
            let kind = section.word("kind", &["polygon", "flat"])?;
            let (mut first, last) = match wheel {
                "left" => (0, 0),
                "right" => (1, 1),
                _ => (0, 1),
            };
            let depth = section.positive("depth", Dimension::Length)?;
            let single = match kind {
                "polygon" => polygon(&section, depth)?,
                _ => flat(&section, depth)?,
            };
            while first <= last {
                read[first].push(single.around(&section, radii[first])?);
                first += 1;
            }
            section.finish()?;
        }
        let [left, right] = read;
        Ok([(left, radii[0]), (right, radii[1])].map(|(shapes, radius)| (!shapes.is_empty()).then_some(OutOfRound { radius, shapes })))
    }
}

/// A deviation before the wheel's radius is known; lengths along the tread.
enum Along {
    Polygon { order: f64, depth: f64, phase: f64 },
    Flat { at: f64, length: f64, depth: f64 },
}

fn polygon(section: &Section, depth: f64) -> Result<Along, SettingsError> {
    let order = section.number("order", Dimension::None)?;
    if !(1.0..=200.0).contains(&order) || order.fract() != 0.0 {
        return Err(section.error("order", format!("found {order:?}, expected a whole number of waves around the wheel, 1 to 200")));
    }
    Ok(Along::Polygon { order, depth, phase: section.number_or("phase", Dimension::Angle, 0.0)? })
}

fn flat(section: &Section, depth: f64) -> Result<Along, SettingsError> {
    Ok(Along::Flat { at: section.number_or("at", Dimension::Angle, 0.0)?, length: section.positive("length", Dimension::Length)?, depth })
}

impl Along {
    fn around(&self, section: &Section, radius: f64) -> Result<Shape, SettingsError> {
        let too_deep = |most: f64, depth: f64| {
            let problem = format!(
                "found {depth:?} m, with which the wheel bends inward there and would stand on two places; expected at most {most:.2e} m"
            );
            Err(section.error("depth", problem))
        };
        match *self {
            Along::Polygon { order, depth, phase } => {
                let most = 2.0 * MOST_BENT * radius / (order * order);
                if depth > most { too_deep(most, depth) } else { Ok(Shape::Polygon { order, amplitude: 0.5 * depth, phase }) }
            }
            Along::Flat { at, length, depth } => {
                if length > std::f64::consts::PI * radius {
                    return Err(section.error("length", format!("found {length:?} m, more than half of the wheel's circumference")));
                }
                let most = MOST_BENT * length * length / (0.5 * TAU * TAU * radius);
                let half = 0.5 * length / radius;
                if depth > most { too_deep(most, depth) } else { Ok(Shape::Flat { at, half, amplitude: 0.5 * depth }) }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples() -> [Shape; 2] {
        [Shape::Polygon { order: 7.0, amplitude: 1e-4, phase: 0.4 }, Shape::Flat { at: 5.9, half: 0.12, amplitude: 2e-4 }]
    }

    #[test]
    fn analytic_derivatives_are_those_of_the_radius() {
        let wheel = OutOfRound { radius: 0.457, shapes: samples().to_vec() };
        for step in 0..4000 {
            // Not at the ends of the flat, where the second derivative jumps.
            let angle = -7.4963 + 0.01 * f64::from(step);
            let h = 1e-7;
            let slopes = |at: &dyn Fn(f64) -> [f64; 4], orders: usize| {
                let (ahead, behind, here) = (at(angle + h), at(angle - h), at(angle));
                for (order, scale) in [(0, 1.0), (1, 50.0), (2, 2500.0)].into_iter().take(orders) {
                    let slope = (ahead[order] - behind[order]) / (2.0 * h);
                    assert!((slope - here[order + 1]).abs() < 1e-8 * scale, "{order} at {angle}: {slope:e} {:e}", here[order + 1]);
                }
            };
            slopes(&|angle| wheel.radius_at(angle), 3);
            slopes(&|angle| wheel.at(angle), 2);
        }
        // Whole turns change nothing once the first one is over.
        let [there, later] = [13.0, 13.0 + 5.0 * TAU].map(|angle| wheel.at(angle));
        assert!((there[0] - later[0]).abs() < 1e-16 && (there[1] - later[1]).abs() < 1e-15);
        // The deepest place of the flat is the lowest point when the wheel has turned to it.
        assert_eq!(samples()[1].at(5.9 + TAU)[0], -4e-4);
    }

    /// The centre rides where the wheel's outline stands out most, and over a flat as a round wheel over a dip of that shape: sharper at the bottom by 1 / (1 - R k).
    #[test]
    fn analytic_the_centre_rides_on_the_outline() {
        let (radius, amplitude, half) = (0.457, 1e-4, 0.025 / 0.457);
        let wheel = OutOfRound { radius, shapes: vec![Shape::Flat { at: 9.0, half, amplitude }] };
        let bent = wheel.shapes[0].bent(radius);
        assert!((0.6..0.8).contains(&bent), "{bent}");
        for step in -60..=60 {
            let angle = 9.0 + 1e-3 * f64::from(step);
            let outline = |lead: f64| (radius + wheel.radius_at(angle + lead)[0]) * lead.cos() - radius;
            let dip = |lead: f64| wheel.radius_at(angle + lead)[0] - 0.5 * radius * lead * lead;
            let highest = |of: &dyn Fn(f64) -> f64| (-40_000..=40_000).map(|k| of(3e-6 * f64::from(k))).fold(f64::NEG_INFINITY, f64::max);
            let found = wheel.at(angle)[0];
            assert!((found - highest(&outline)).abs() < 1e-11, "{step}: {found:e}");
            assert!((found - highest(&dip)).abs() < 3e-8, "{step}: {found:e} {:e}", highest(&dip));
        }
        let ([there, slope, bend, _], own) = (wheel.at(9.0), wheel.radius_at(9.0)[2]);
        assert!((there + 2.0 * amplitude).abs() < 1e-15 && slope.abs() < 1e-15, "{there:e} {slope:e}");
        assert!((bend * (1.0 - bent) / own - 1.0).abs() < 2e-3, "{bend} {own} {bent}");
    }

    #[test]
    fn analytic_edges_of_flats_ahead() {
        let shapes = vec![Shape::Flat { at: 1.0, half: 0.1, amplitude: 1e-4 }, Shape::Flat { at: 6.2, half: 0.2, amplitude: 1e-4 }];
        let wheel = OutOfRound { radius: 0.46, shapes };
        for (angle, rate, wanted) in
            [(0.5, 3.0, 0.4), (0.9, 3.0, 0.2), (0.9 - 1e-6, 3.0, 0.2 + 1e-6), (0.5, -3.0, 0.5 - (6.4 - TAU)), (6.3 + 3.0 * TAU, 1.0, 0.1)]
        {
            let found = wheel.next_edge(angle, rate).unwrap();
            assert!((found - wanted - BEHIND).abs() < 1e-12, "{angle} {rate}: {found}");
        }
        assert!(OutOfRound { radius: 0.46, shapes: vec![] }.next_edge(0.0, 1.0).is_none());
    }

    #[test]
    fn prop_no_step_passes_a_flat() {
        let flat = samples()[1];
        for (sign, start) in [(1.0, 0.3), (-1.0, 40.0)] {
            let mut angle: f64 = start;
            let (mut deepest, mut inside) = (0f64, 0);
            for _ in 0..300 {
                let reach = flat.reach(angle, sign, 1.0);
                assert!(reach > 0.0);
                angle += sign * reach;
                deepest = deepest.min(flat.at(angle)[0]);
                inside += usize::from(flat.at(angle)[0] < 0.0);
            }
            assert!(deepest < -2e-4 && inside > 100, "{deepest:e} {inside}");
        }
    }
}
