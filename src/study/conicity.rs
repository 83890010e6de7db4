//! Equivalent conicity: the slope of the cone that would run like these profiles.
//!
//! A free wheelset rolling without creep turns toward its smaller wheel (Klingel 1883). What must not slip sideways is its treads, which a roll
//! moves beside its centre: with the distance e of the tread circles, the nominal radius r0, the mean rolling radius r(y) and the roll at
//! which both wheels touch, over the distance x along the track,
//!
//! ```text
//! w' = yaw,   yaw' = -dr(y) / (e r0),   dr(y) = r_left - r_right,   dw = dy + r(y) d roll(y)
//! ```
//!
//! With the axle held level w = y, as in EN 15302. On the gauge corner the roll is no correction: there w runs several times as fast as y.
//!
//! A cone of slope gamma has dr = 2 gamma w and the wavelength L = 2 pi sqrt(e r0 / (2 gamma)).
//!
//! *EN 15302.* The same equation with the true dr has a periodic motion between y1 and y2 whose wavelength is compared with
//! that of the cone: `lambda = 2 pi^2 e r0 / L^2`, at the amplitude (y2 - y1) / 2. The first integral
//! `w'^2 / 2 = E(w) / (e r0)`, E(w) = integral of dr from w to w2, gives the wavelength as a quadrature; with
//! w = c + A sin phi
//!
//! ```text
//! L / sqrt(e r0) = 2 G,   G = integral over phi, -pi/2 .. pi/2, of A cos phi / sqrt(2 E),   lambda = pi^2 / (2 G^2)
//! ```
//!
//! so that e and r0 drop out of lambda. The ends satisfy E(w1) = 0: the middle c is zero when dr is odd.
//!
//! *Harmonic linearisation.* The first harmonic of dr over a sine about c, with a mean that must vanish:
//!
//! ```text
//! lambda = 1 / (2 pi A) integral_0^2pi dr(c + A sin phi) sin phi dphi,     integral_0^2pi dr(c + A sin phi) dphi = 0
//! ```
//!
//! *Nonlinearity parameter* (EN 15302:2021, 9.3; formula: O. Polach, Vehicle System Dynamics 48 (2010) S19-S36): the mean slope of lambda over the
//! amplitude around 3 mm, `NP = (lambda(4 mm) - lambda(2 mm)) / 2 mm`. Above zero lambda grows with the amplitude; below zero wheelsets run in limit
//! cycles of small amplitude already at low speed.
//!
//! All again over w. dr(w) and w(y) are taken as straight lines between given points: the harmonic integrals are then exact, the quadrature of G nearly so (four
//! Gauss points per line; the integrand is smooth up to both ends). A jump of dr is a line a nanometre long.

use crate::math::bracket::root;
use std::f64::consts::{FRAC_PI_2, PI};

/// Why there is no equivalent conicity at an amplitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoConicity {
    #[error("the motion leaves the range of lateral shifts")]
    BeyondRange,
    #[error("the rolling-radius difference does not turn the wheelset back")]
    NoWave,
}

/// An equivalent conicity and the lateral shift about which the wheelset swings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conicity {
    /// lambda, -.
    pub value: f64,
    /// c, m.
    pub centre: f64,
}

/// Wavelength [m] of a conicity above zero by Klingel's formula.
pub fn wavelength(conicity: f64, tread_circle_distance: f64, radius: f64) -> f64 {
    2.0 * PI * (tread_circle_distance * radius / (2.0 * conicity)).sqrt()
}

/// Rolling-radius difference over lateral shift: straight lines between points of growing y and w.
#[derive(Clone, Debug)]
pub struct RadiusDifference {
    /// w, dr, m.
    points: Vec<(f64, f64)>,
    /// y of each, m.
    shifts: Vec<f64>,
}

/// One pose of a wheelset that rests on its rails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollingPose {
    /// Lateral shift of the centre, left positive, m.
    pub y: f64,
    /// Left side up, rad.
    pub roll: f64,
    /// Rolling radii left and right, m.
    pub radii: [f64; 2],
}

/// A line from (y, dr) to (y, dr), inside the motion.
type Line = ((f64, f64), (f64, f64));

/// Nodes and weights of four Gauss points on -1 .. 1.
const GAUSS: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];

impl RadiusDifference {
    /// From (y, dr) [m] by growing y, of an axle that does not roll; points that do not grow are left out.
    pub fn new(points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let mut kept = RadiusDifference { points: Vec::new(), shifts: Vec::new() };
        points.into_iter().for_each(|(y, dr)| kept.push(y, y, dr));
        kept
    }

    /// From poses by growing y; those at which y or w do not grow are left out.
    pub fn of_poses(poses: impl IntoIterator<Item = RollingPose>) -> Self {
        let mut kept = RadiusDifference { points: Vec::new(), shifts: Vec::new() };
        let mut before: Option<(RollingPose, f64)> = None;
        for pose in poses {
            let radius = |pose: &RollingPose| 0.5 * (pose.radii[0] + pose.radii[1]);
            // w begins as y: only its differences count.
            let w =
                before.map_or(pose.y, |(last, w)| w + (pose.y - last.y) + 0.5 * (radius(&last) + radius(&pose)) * (pose.roll - last.roll));
            before = Some((pose, w));
            kept.push(pose.y, w, pose.radii[0] - pose.radii[1]);
        }
        kept
    }

    fn push(&mut self, y: f64, w: f64, dr: f64) {
        if self.points.last().is_none_or(|last| w > last.0) && self.shifts.last().is_none_or(|last| y > *last) {
            self.points.push((w, dr));
            self.shifts.push(y);
        }
    }

    /// Smallest and largest lateral shift, m.
    pub fn range(&self) -> (f64, f64) {
        let end = |shift: Option<&f64>| shift.copied().unwrap_or(f64::NAN);
        (end(self.shifts.first()), end(self.shifts.last()))
    }

    /// w at a lateral shift, m.
    fn way(&self, y: f64) -> f64 {
        let Some(last) = self.points.len().checked_sub(1).filter(|last| *last > 0) else { return f64::NAN };
        let after = self.shifts.partition_point(|shift| *shift < y).clamp(1, last);
        let ([a, b], [from, to]) = ([after - 1, after].map(|i| self.shifts[i]), [after - 1, after].map(|i| self.points[i].0));
        // To the bit where the axle is level.
        if a == from && b == to { y } else { from + (to - from) * (y - a) / (b - a) }
    }

    /// Middle and amplitude in w of the motion about the shift `c` with the amplitude `a` in y, m.
    fn wave(&self, c: f64, a: f64) -> (f64, f64) {
        let (low, high) = (self.way(c - a), self.way(c + a));
        // To the bit where the axle is level.
        if low == c - a && high == c + a { (c, a) } else { (0.5 * (low + high), 0.5 * (high - low)) }
    }

    /// dr at w [m], which is y where the axle is level; on the continued line beyond the ends.
    pub fn at(&self, w: f64) -> f64 {
        let Some(last) = self.points.len().checked_sub(1).filter(|last| *last > 0) else { return f64::NAN };
        let after = self.points.partition_point(|point| point.0 < w).clamp(1, last);
        let (a, b) = (self.points[after - 1], self.points[after]);
        a.1 + (b.1 - a.1) * (w - a.0) / (b.0 - a.0)
    }

    /// The lines between two places, by growing w.
    fn lines(&self, from: f64, to: f64) -> impl DoubleEndedIterator<Item = Line> + '_ {
        let first = self.points.partition_point(|point| point.0 <= from);
        let end = self.points.partition_point(|point| point.0 < to).max(first);
        let (start, stop) = ((from, self.at(from)), (to, self.at(to)));
        (first..=end).map(move |k| {
            let a = if k == first { start } else { self.points[k - 1] };
            let b = if k == end { stop } else { self.points[k] };
            (a, b)
        })
    }

    /// Where a mean that grows with the middle c [y, m] of the motion vanishes, nearest to c = 0.
    fn middle(&self, amplitude: f64, mean: impl Fn(f64) -> f64) -> Result<f64, NoConicity> {
        let (first, last) = self.range();
        let (low, high) = (first + amplitude, last - amplitude);
        let slack = 1e-9 * amplitude;
        if !(low <= high + slack && low <= slack && high >= -slack) {
            return Err(NoConicity::BeyondRange);
        }
        let here = mean(0.0);
        if here == 0.0 {
            return Ok(0.0);
        }
        // A positive mean means that the wheelset is driven to the right.
        let way = -here.signum();
        let end = if way > 0.0 { high } else { low };
        const STEPS: usize = 64;
        let (mut inside, mut value) = (0.0, here);
        for k in 1..=STEPS {
            let c = end * k as f64 / STEPS as f64;
            let next = mean(c);
            if next * here <= 0.0 {
                return Ok(root((inside, value), (c, next), 1e-13 * amplitude, mean));
            }
            (inside, value) = (c, next);
        }
        // Rounding of a motion that just fits.
        if here.abs() < 1e-12 * amplitude { Ok(0.0) } else { Err(NoConicity::BeyondRange) }
    }

    /// Mean and first harmonic of dr over w = c + A sin phi: `(integral dr dphi, integral dr sin phi dphi) / pi` over half a
    /// turn, m.
    fn harmonics(&self, c: f64, amplitude: f64) -> (f64, f64) {
        let (mut mean, mut first) = (0.0, 0.0);
        let (low, high) = (c - amplitude, c + amplitude);
        for (a, b) in self.lines(low, high) {
            // A cut of the length of rounding beside a point has no slope of its own, but near an end of the motion it has an angle.
            let width = b.0 - a.0;
            let slope = if width > 1e-12 * amplitude { (b.1 - a.1) / width } else { 0.0 };
            // dr = level + slope A sin phi.
            let level = a.1 - slope * (a.0 - c);
            // The ends exactly: beside them the arc sine makes 1e-8 of rounding.
            let angle = |y: f64| {
                let end = if y <= low { Some(-FRAC_PI_2) } else { (y >= high).then_some(FRAC_PI_2) };
                end.unwrap_or_else(|| ((y - c) / amplitude).clamp(-1.0, 1.0).asin())
            };
            let (from, to) = (angle(a.0), angle(b.0));
            let bend = slope * amplitude;
            mean += level * (to - from) - bend * (to.cos() - from.cos());
            first += -level * (to.cos() - from.cos()) + bend * (0.5 * (to - from) - 0.25 * ((2.0 * to).sin() - (2.0 * from).sin()));
        }
        (mean / PI, first / PI)
    }

    /// Equivalent conicity by harmonic linearisation at `amplitude` [m].
    ///
    /// # Errors
    /// [`NoConicity::BeyondRange`].
    pub fn harmonic(&self, amplitude: f64) -> Result<Conicity, NoConicity> {
        let harmonics = |c: f64| {
            let (middle, amplitude) = self.wave(c, amplitude);
            let (mean, first) = self.harmonics(middle, amplitude);
            // Half a turn is half of the full integral: lambda = (2 / (2 A)) (1 / pi) integral over half a turn.
            (mean, first / amplitude)
        };
        let centre = self.middle(amplitude, |c| harmonics(c).0)?;
        Ok(Conicity { value: harmonics(centre).1, centre })
    }

    /// Equivalent conicity by EN 15302 at `amplitude` [m], half of the motion from peak to peak.
    ///
    /// # Errors
    /// [`NoConicity`].
    pub fn en15302(&self, amplitude: f64) -> Result<Conicity, NoConicity> {
        let area = |c: f64| {
            let (middle, amplitude) = self.wave(c, amplitude);
            self.lines(middle - amplitude, middle + amplitude).map(|(a, b)| 0.5 * (a.1 + b.1) * (b.0 - a.0)).sum::<f64>()
        };
        let centre = self.middle(amplitude, area)?;
        let (c, amplitude) = self.wave(centre, amplitude);
        let (low, high) = (c - amplitude, c + amplitude);
        // From each end inward, so that E is a sum of small positive parts near it. E(w) = area from w to the upper end = minus
        // the area from the lower end to y.
        let upper = half_wave(self.lines(c, high).rev().map(|(a, b)| (b, a)), amplitude, 1.0)?;
        let lower = half_wave(self.lines(low, c), amplitude, -1.0)?;
        let g = upper + lower;
        Ok(Conicity { value: PI * PI / (2.0 * g * g), centre })
    }

    /// The nonlinearity parameter NP, 1/m.
    ///
    /// # Errors
    /// [`NoConicity`].
    pub fn nonlinearity(&self) -> Result<f64, NoConicity> {
        let [low, high] = NONLINEARITY;
        Ok((self.en15302(high)?.value - self.en15302(low)?.value) / (high - low))
    }
}

/// Amplitudes between which the nonlinearity parameter takes the slope of the conicity, m.
pub const NONLINEARITY: [f64; 2] = [2e-3, 4e-3];

/// The part of G between one end of the motion and its middle; lines come from that end inward.
fn half_wave(lines: impl Iterator<Item = Line>, amplitude: f64, side: f64) -> Result<f64, NoConicity> {
    let (mut sum, mut energy, mut gone) = (0.0, 0.0, 0.0);
    // Angle t from the end of the motion at a way from that end, way = A (1 - cos t) = 2 A sin^2(t / 2): no digits are lost there.
    let angle = |way: f64| 2.0 * (way / (2.0 * amplitude)).clamp(0.0, 0.5).sqrt().asin();
    for (outer, inner) in lines {
        let width = (outer.0 - inner.0).abs();
        if width == 0.0 {
            continue;
        }
        let (from, to) = (angle(gone), angle(gone + width));
        let half = 0.5 * (to - from);
        for (node, weight) in GAUSS {
            let t = 0.5 * (from + to) + half * node;
            let way = 2.0 * amplitude * (0.5 * t).sin().powi(2);
            let depth = (way - gone).clamp(0.0, width);
            let dr = outer.1 + (inner.1 - outer.1) * depth / width;
            let e = energy + side * 0.5 * (outer.1 + dr) * depth;
            if !(e > 0.0) {
                return Err(NoConicity::NoWave);
            }
            sum += half * weight * amplitude * t.sin() / (2.0 * e).sqrt();
        }
        energy += side * 0.5 * (outer.1 + inner.1) * width;
        gone += width;
    }
    Ok(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points at every `step` of -8 .. 8 mm.
    fn sampled(step: f64, dr: impl Fn(f64) -> f64) -> RadiusDifference {
        let count = (8e-3 / step).round() as i32;
        RadiusDifference::new((-count..=count).map(|k| step * f64::from(k)).map(|y| (y, dr(y))))
    }

    #[test]
    fn analytic_cone_about_any_middle() {
        for c in [0.0, 0.7e-3, -1.1e-3] {
            let cone = sampled(1e-4, |y| 2.0 * 0.1 * (y - c));
            for amplitude in [0.37e-3, 3e-3, 6.8e-3] {
                for found in [cone.en15302(amplitude).unwrap(), cone.harmonic(amplitude).unwrap()] {
                    assert!((found.value - 0.1).abs() < 1e-11 && (found.centre - c).abs() < 1e-13, "{c} {amplitude}: {found:?}");
                }
            }
        }
        assert_eq!(sampled(1e-4, |y| y).en15302(8.1e-3), Err(NoConicity::BeyondRange));
        assert_eq!(sampled(1e-4, |y| y - 6e-3).harmonic(3e-3), Err(NoConicity::BeyondRange));
    }

    #[test]
    fn analytic_cubic_difference() {
        // dr = k y^3: E = k (A^4 - y^4) / 4, so that G = 2 sqrt(2 / k) / A times the lemniscate integral 1.311028777146060 of
        // 1 / sqrt(1 - x^4), 0 .. 1. Harmonic: 3 k A^2 / 8.
        let k = 4e4;
        let cubic = sampled(1e-5, |y| k * y * y * y);
        for a in [1e-3f64, 3e-3, 8e-3] {
            let g = 2.0 * (2.0f64 / k).sqrt() / a * 1.311_028_777_146_06;
            let wanted = PI * PI / (2.0 * g * g);
            let (en, harmonic) = (cubic.en15302(a).unwrap().value, cubic.harmonic(a).unwrap().value);
            assert!((en / wanted - 1.0).abs() < 2e-4 * (1e-3 / a).powi(2), "{a}: {en} {wanted}");
            assert!((harmonic / (0.375 * k * a * a) - 1.0).abs() < 2e-4 * (1e-3 / a).powi(2), "{harmonic}");
        }
    }

    #[test]
    fn analytic_jump_at_the_middle() {
        // dr = d sign(y): G = 2 sqrt(2 A / d), lambda = pi^2 d / (16 A); harmonic 2 d / (pi A).
        let d = 0.5e-3;
        let jump = RadiusDifference::new([(-8e-3, -d), (-0.5e-9, -d), (0.5e-9, d), (8e-3, d)]);
        for a in [1e-3, 3e-3] {
            let (en, harmonic) = (jump.en15302(a).unwrap().value, jump.harmonic(a).unwrap().value);
            assert!((en - PI * PI * d / (16.0 * a)).abs() < 1e-4 * en, "{en}");
            assert!((harmonic - 2.0 * d / (PI * a)).abs() < 1e-9, "{harmonic}");
        }
    }

    #[test]
    fn analytic_unlike_cones() {
        // dr = 2 g1 y to the left, 2 g2 y to the right: half a wave of each, with g1 y1^2 = g2 y2^2 and y1 + y2 = 2 A.
        let (g1, g2) = (0.3f64, 0.05f64);
        let unlike = sampled(1e-4, |y| 2.0 * if y > 0.0 { g1 } else { g2 } * y);
        let amplitude = 2e-3;
        let y1 = 2.0 * amplitude / (1.0 + (g1 / g2).sqrt());
        let half = 0.5 * (1.0 / g1.sqrt() + 1.0 / g2.sqrt());
        let found = unlike.en15302(amplitude).unwrap();
        assert!((found.centre - (y1 - amplitude)).abs() < 1e-12 && (found.value - 1.0 / (half * half)).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn hard_a_difference_that_drives_away_has_no_wave() {
        // A cone upside down, and one with a hump in the middle that is higher than the ends.
        let away = sampled(1e-4, |y| -0.1 * y);
        assert_eq!(away.en15302(3e-3), Err(NoConicity::NoWave));
        assert!((away.harmonic(3e-3).unwrap().value + 0.05).abs() < 1e-12);
        let hump = sampled(1e-4, |y| if y.abs() > 2e-3 { 0.1 * (y - 2e-3 * y.signum()) } else { -0.1 * y });
        assert_eq!(hump.en15302(3e-3), Err(NoConicity::NoWave));
        assert!(hump.en15302(8e-3).is_ok());
    }
}
