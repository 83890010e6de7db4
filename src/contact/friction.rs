//! Coulomb friction that varies along the track and across the rail's head.
//!
//! ```text
//! mu = contact.friction  f(s)  g(alpha)  (factor of the FMU's input)
//! f(s)     = f_0 + sum (f_i - f_i-1) w((s - s_i) / L + 1/2)         s: distance of the contact along the track
//! g(alpha) = 1 + (gauge_face - 1) w((alpha - from) / (to - from))   tan alpha = slope of the rail's section at the contact
//! ```
//!
//! with the step w of [`smooth_step`] (three continuous derivatives), so that creep forces are as smooth as without. alpha is counted in the
//! un-inclined section and positive toward the gauge face; the field side counts as top. Factors, not coefficients, so that the parameter
//! `contact.friction` of an FMU scales all of it.
//!
//! A contact has one coefficient, that at its centre (the load's centre of a part of a patch of strips): a patch that lies across the edge of a
//! film of grease has its mean only in so far as the transition is wider than the patch.

use super::creepage::CreepForce;
use crate::geometry::Side;
use crate::geometry::profile::Profile;
use crate::geometry::track::waves::Stretch;
use crate::math::smooth_step::smooth_step;
use crate::settings::{Section, SettingsError};
use crate::units::Dimension;
use nalgebra::Vector3;

/// Largest factor.
const MOST: f64 = 10.0;
/// Shortest transition, m: a patch is that long, and has one coefficient.
const SHORTEST: f64 = 1e-2;
/// Narrowest transition across, rad.
const NARROWEST: f64 = 0.02;
/// Distances, m, within which a track may lie.
const FURTHEST: f64 = 1e7;

/// Friction along one rail or both.
#[derive(Clone, Debug, PartialEq)]
struct Along {
    /// Left, right.
    on: [bool; 2],
    /// Distance, m, and the factor from there on, at least two.
    steps: Vec<[f64; 2]>,
    /// L, m.
    transition: f64,
}

/// Friction across the head.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Across {
    gauge_face: f64,
    /// rad.
    from: f64,
    to: f64,
}

/// Factors of the friction coefficient by place.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionMap {
    along: Vec<Along>,
    across: Option<Across>,
}

/// A factor and its derivatives by distance, 1/m, and by the angle of the rail's surface, 1/rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionFactor {
    pub value: f64,
    pub by_distance: f64,
    pub by_angle: f64,
}

impl Along {
    /// The factor at `s` and its derivative.
    fn at(&self, s: f64) -> [f64; 2] {
        let begun = self.steps[1..].partition_point(|step| step[0] - 0.5 * self.transition <= s);
        if begun == 0 {
            return [self.steps[0][1], 0.0];
        }
        let ([at, factor], before) = (self.steps[begun], self.steps[begun - 1][1]);
        let [w, rate, ..] = smooth_step((s - at) / self.transition + 0.5);
        [before + (factor - before) * w, (factor - before) * rate / self.transition]
    }
}

impl Across {
    fn at(&self, angle: f64) -> [f64; 2] {
        let width = self.to - self.from;
        let [w, rate, ..] = smooth_step((angle - self.from) / width);
        [1.0 + (self.gauge_face - 1.0) * w, (self.gauge_face - 1.0) * rate / width]
    }
}

impl FrictionMap {
    /// At the distance `s` [m] where the rail's section has the `slope`.
    pub fn at(&self, side: Side, s: f64, slope: f64) -> FrictionFactor {
        let (mut value, mut by_distance) = (1.0, 0.0);
        for along in self.along.iter().filter(|along| along.on[side.index()]) {
            let [factor, rate] = along.at(s);
            (value, by_distance) = (value * factor, by_distance * factor + value * rate);
        }
        let [across, rate] = self.across.map_or([1.0, 0.0], |across| across.at(slope.atan()));
        FrictionFactor { value: value * across, by_distance: by_distance * across, by_angle: value * rate }
    }

    /// Where friction changes along a rail, so that no step passes a change unseen: a transition is half a wave.
    pub fn waves(&self, side: Side) -> impl Iterator<Item = Stretch> + '_ {
        self.along.iter().filter(move |along| along.on[side.index()]).flat_map(|along| {
            let stretch = |step: &[f64; 2]| Stretch {
                from: step[0] - 0.5 * along.transition,
                to: step[0] + 0.5 * along.transition,
                wave: along.transition,
            };
            along.steps.windows(2).filter(|pair| pair[0][1] != pair[1][1]).map(move |pair| stretch(&pair[1]))
        })
    }

    /// The map with its factors along the track, and with those across the head, or without; `None` where nothing is left.
    pub fn keeping(mut self, along: bool, across: bool) -> Option<Self> {
        if !along {
            self.along.clear();
        }
        self.across = self.across.filter(|_| across);
        (!self.along.is_empty() || self.across.is_some()).then_some(self)
    }

    /// The same map where distances are counted from `origin` [m] on.
    pub fn counted_from(mut self, origin: f64) -> Self {
        self.along.iter_mut().flat_map(|along| &mut along.steps).for_each(|step| step[0] -= origin);
        self
    }

    /// What `wheelrail plan` says: of friction along the track, and across the head.
    pub fn describe(&self) -> [Option<String>; 2] {
        let along = self.along.iter().map(|along| {
            let rail = match along.on {
                [true, true] => "both rails",
                [true, false] => "left rail",
                _ => "right rail",
            };
            let steps: Vec<String> = along.steps.iter().map(|[at, factor]| format!("{factor} from {at} m")).collect();
            format!("{rail}: factor {}, transitions of {} m", steps.join(", "), along.transition)
        });
        let along: Vec<String> = along.collect();
        let across = self.across.map(|Across { gauge_face, from, to }| {
            let [from, to] = [from, to].map(f64::to_degrees);
            format!("factor {gauge_face} on the gauge face, where the rail's surface is steeper than {to:.1} deg, 1 up to {from:.1} deg")
        });
        [(!along.is_empty()).then(|| along.join("; ")), across]
    }

    /// Reads `[[contact.friction_along]]` and `[contact.friction_across]` of `[contact]`; `None` where neither is there.
    ///
    /// # Errors
    /// [`SettingsError`] with file and line.
    pub fn parse(section: &Section, friction: f64) -> Result<Option<Self>, SettingsError> {
        let along: Vec<Along> = section.sections("friction_along")?.into_iter().map(read_along).collect::<Result<_, _>>()?;
        let across = section.optional_section("friction_across")?.map(read_across).transpose()?;
        for (key, given) in [("friction_along", !along.is_empty()), ("friction_across", across.is_some())] {
            if given && friction == 0.0 {
                return Err(section.error(key, "has factors of contact.friction, which is 0; expected contact.friction above 0"));
            }
        }
        Ok((!along.is_empty() || across.is_some()).then_some(FrictionMap { along, across }))
    }

    /// Refuses a gauge face that a rail doesn't have.
    ///
    /// # Errors
    /// [`SettingsError`] with file and line.
    pub fn check(&self, contact: &Section, rails: [&dyn Profile; 2]) -> Result<(), SettingsError> {
        let Some(Across { from, .. }) = self.across else { return Ok(()) };
        for (rail, side) in rails.into_iter().zip(Side::BOTH) {
            const LOOKS: i32 = 2000;
            let (first, _) = rail.range();
            let steepest = (0..=LOOKS).map(|k| rail.at(first * f64::from(k) / f64::from(LOOKS)).d1.atan()).fold(f64::MIN, f64::max);
            if !(steepest > from) {
                let (from, steepest) = (from.to_degrees(), steepest.to_degrees());
                let problem = format!(
                    "found {from:.1} deg, but the {} rail's profile has no surface toward the gauge face that is steeper than {steepest:.1} deg",
                    side.name()
                );
                return Err(contact.section("friction_across")?.error("from", problem));
            }
        }
        Ok(())
    }
}

fn factor(section: &Section, key: &str, found: f64) -> Result<f64, SettingsError> {
    if (0.0..=MOST).contains(&found) {
        return Ok(found);
    }
    Err(section.error(key, format!("found the factor {found:?}, expected 0 to {MOST} (of contact.friction)")))
}

fn read_along(section: Section) -> Result<Along, SettingsError> {
    let rail = section.word_or("rail", &["both", "left", "right"], "both")?;
    let steps = section.pairs("factors", Dimension::Length, Dimension::None)?;
    let transition = section.at_least("transition", Dimension::Length, SHORTEST)?;
    let wrong = |problem: String| Err(section.error("factors", problem));
    if steps.len() < 2 {
        return wrong(format!("found {} pairs, expected at least 2: one factor everywhere belongs into contact.friction", steps.len()));
    }
    for [at, found] in &steps {
        factor(&section, "factors", *found)?;
        if at.abs() > FURTHEST {
            return wrong(format!("found the distance {at:?} m, expected at most {FURTHEST:e} m"));
        }
    }
    if let Some(pair) = steps.windows(2).find(|pair| !(pair[1][0] - pair[0][0] >= transition)) {
        let [at, next] = [pair[0][0], pair[1][0]];
        return wrong(format!(
            "found {next:?} m after {at:?} m, expected distances that grow by the transition of {transition:?} m at least"
        ));
    }
    section.finish()?;
    Ok(Along { on: [rail != "right", rail != "left"], steps, transition })
}

fn read_across(section: Section) -> Result<Across, SettingsError> {
    let gauge_face = section.number("gauge_face", Dimension::None)?;
    let gauge_face = factor(&section, "gauge_face", gauge_face)?;
    let [from, to] = [section.number("from", Dimension::Angle)?, section.number("to", Dimension::Angle)?];
    const STEEPEST: f64 = 1.5;
    if !(from >= 0.0 && to <= STEEPEST && to - from >= NARROWEST) {
        let problem =
            format!("found {to:?} rad after from = {from:?} rad, expected 0 <= from, from + {NARROWEST} rad <= to <= {STEEPEST} rad");
        return Err(section.error("to", problem));
    }
    section.finish()?;
    Ok(Across { gauge_face, from, to })
}

/// dT/dmu of forces at mu and at `1 + change` times mu, N and N m.
pub fn by_friction(friction: f64, change: f64, here: &CreepForce, there: &CreepForce) -> Vector3<f64> {
    let per_step = 1.0 / (change * friction);
    let difference = |a: f64, b: f64| (b - a) * per_step;
    Vector3::new(
        difference(here.longitudinal, there.longitudinal),
        difference(here.lateral, there.lateral),
        difference(here.spin_moment, there.spin_moment),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> FrictionMap {
        let along = |on, steps: &[[f64; 2]]| Along { on, steps: steps.to_vec(), transition: 4.0 };
        FrictionMap {
            along: vec![along([true, true], &[[0.0, 1.0], [50.0, 0.4], [54.0, 1.2]]), along([true, false], &[[0.0, 0.5], [60.0, 1.0]])],
            across: Some(Across { gauge_face: 0.3, from: 0.4, to: 0.7 }),
        }
    }

    #[test]
    fn analytic_factors_hold_from_their_distance_on_and_multiply() {
        let map = map();
        let at = |side, s, angle: f64| map.at(side, s, angle.tan()).value;
        for (s, right, left) in [(-1e3, 1.0, 0.5), (47.9, 1.0, 0.5), (50.0, 0.7, 0.35), (52.0, 0.4, 0.2), (56.0, 1.2, 0.6), (1e4, 1.2, 1.2)]
        {
            assert!((at(Side::Right, s, 0.0) - right).abs() < 1e-15 && (at(Side::Left, s, -0.3) - left).abs() < 1e-15, "{s}");
            assert!((at(Side::Right, s, 0.7) - 0.3 * right).abs() < 1e-15 && (at(Side::Right, s, 0.55) - 0.65 * right).abs() < 1e-15);
        }
    }

    #[test]
    fn analytic_derivatives_match_differences() {
        let (map, h) = (map(), 1e-6);
        for s in [48.7, 50.0, 53.1, 58.5, 61.0] {
            for angle in [0.1f64, 0.45, 0.6, 0.9] {
                let found = map.at(Side::Left, s, angle.tan());
                let at = |s: f64, angle: f64| map.at(Side::Left, s, angle.tan()).value;
                let along = (at(s + h, angle) - at(s - h, angle)) / (2.0 * h);
                let across = (at(s, angle + h) - at(s, angle - h)) / (2.0 * h);
                assert!((found.by_distance - along).abs() < 1e-8 && (found.by_angle - across).abs() < 1e-8, "{s} {angle}: {found:?}");
            }
        }
        // Steps are told of the transitions, and of nothing else.
        let places: Vec<(f64, f64)> = map.waves(Side::Right).map(|stretch| (stretch.from, stretch.to)).collect();
        assert_eq!(places, [(48.0, 52.0), (52.0, 56.0)]);
    }
}
