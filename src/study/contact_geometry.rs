//! A wheelset set down on its rails: rigid surfaces, known lateral shift and yaw.
//!
//! Unknown are the height z of the wheelset's centre and its roll. Each wheel touches where its signed distance to the rail is
//! least, d_left(z, roll) = d_right(z, roll) = 0. A motion of the wheelset changes the distance of a contact p with the
//! normal n (out of the rail) to first order by what the material point moves along n, for the place is stationary:
//!
//! ```text
//! dd/dz = n_z,    dd/droll = n . (a x (p - c)),    a = axis of roll (cos yaw, sin yaw, 0), c = centre
//! ```
//!
//! A wheel may have several minima of the distance (tread, flange root, flange). A step goes to the height and roll at which
//! one minimum of each wheel touches to first order and no other one enters its rail, the lowest of them (a wheelset could also be
//! lifted until a flange stands in place of the tread): so it does not matter which minimum is the least one on the way.
//!
//! A *level* axle has no roll; each wheel then has a height of its own at which it touches, as in EN 15302.
//!
//! Signs: y to the left, roll > 0 left side up, contact angle > 0 where the rail pushes the wheel toward the track's centre
//! (every flange), u and eta outward. Units m and rad.

use crate::contact::search::algebraic::Pair;
use crate::contact::search::global::{GlobalSearch, Minima, Minimum};
use crate::geometry::Side;
use crate::geometry::surface::Wheel;
use crate::geometry::track::{Rail, Track};
use crate::math::rotation::AxleFrame;
use crate::scene::spec::Scene;
use nalgebra::{Matrix3, Vector3};

/// Why a wheelset does not stand.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoStand {
    #[error("at y = {:.3} mm the {} wheel is beyond its rail", 1e3 * y, side.name())]
    Beyond { y: f64, side: Side },
    #[error("at y = {:.3} mm the {} wheel would touch beyond the end of a profile", 1e3 * y, side.name())]
    AtEdge { y: f64, side: Side },
    #[error("at y = {:.3} mm no height and roll were found at which both wheels touch", 1e3 * y)]
    NotFound { y: f64 },
}

/// One place where a wheel touches or nearly touches its rail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// u, m.
    pub wheel: f64,
    /// eta, m.
    pub rail: f64,
    /// Ahead of the wheelset's centre, m.
    pub lead: f64,
    /// R(u), m.
    pub rolling_radius: f64,
    /// Of the tangent plane against the track's plane, rad; positive where the rail pushes toward the track's centre.
    pub angle: f64,
    /// Of the surfaces, m; zero where they touch.
    pub distance: f64,
    /// Point of the wheel in the track frame, m.
    pub position: Vector3<f64>,
    /// Unit normal out of the rail.
    pub normal: Vector3<f64>,
    at_edge: bool,
}

/// A wheelset on its rails.
#[derive(Clone, Debug, PartialEq)]
pub struct Stand {
    /// Lateral shift of the centre, m.
    pub y: f64,
    /// Height of the centre, m, at which the left and the right wheel touch; equal unless the axle is held level.
    pub height: [f64; 2],
    /// rad.
    pub roll: f64,
    /// Where the left and the right wheel touch.
    pub contacts: [Touch; 2],
    /// Second places that are nearer than asked for.
    pub near: [Option<Touch>; 2],
}

impl Stand {
    /// Rolling radius left minus right, m.
    pub fn radius_difference(&self) -> f64 {
        self.contacts[0].rolling_radius - self.contacts[1].rolling_radius
    }
}

/// How the wheelset is held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attitude {
    /// rad.
    pub yaw: f64,
    /// Hold the axle level? Otherwise both wheels touch at once.
    pub level: bool,
    /// Second places are reported up to this distance, m.
    pub near: f64,
}

/// Wheels, rails and the search between them.
pub struct WheelsetOnTrack {
    pub wheels: [Wheel; 2],
    pub track: Track,
    /// Place along the track, m.
    pub station: f64,
    pub attitude: Attitude,
    searches: [GlobalSearch; 2],
}

/// Height and roll at which the search for a stand begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    pub height: [f64; 2],
    pub roll: f64,
}

impl From<&Stand> for Start {
    fn from(stand: &Stand) -> Self {
        Start { height: stand.height, roll: stand.roll }
    }
}

/// Minima are looked for within this distance, m (or that of second places); where there is none, farther away. One that is
/// missed shows at the next step, when it has entered its rail.
const REACH: f64 = 3e-4;
const FARTHEST: f64 = 0.16;
/// Steps of height [m] and roll [rad] that are taken for nothing.
const STEP: f64 = 1e-12;
const ITERATIONS: usize = 60;
/// Places that have entered their rail by more are not those of a wheelset that stands, m.
const ENTERED: f64 = 1e-9;
/// A place that enters its rail by less is free of it: rounding of a step, m.
const FREE: f64 = 1e-13;
/// On rounded or noisy points many places lie within nanometres of each other, and each step brings another one: after so many steps a stand to this is one, m.
const CROWDED: usize = 20;
const ROUNDED: f64 = 2e-7;
/// Longest steps of height [m] and roll [rad].
const LONGEST: (f64, f64) = (0.05, 0.02);

impl WheelsetOnTrack {
    /// The wheelset of a scene on its track: without deviations, or on the sections at the distance `station` [m].
    pub fn new(scene: &Scene, attitude: Attitude, station: Option<f64>) -> Self {
        let (spec, track) = (scene.vehicle.leading(), &scene.track);
        let wheel = |side: Side| {
            let profile = spec.profiles[side.index()].profile.clone();
            Wheel { side, profile, half_spacing: spec.half_tread_circle_distance }
        };
        let rail = |side: Side| {
            let profile = track.rails[side.index()].profile.clone();
            Rail::new(side, profile, track.half_rail_distance, track.inclination, &track.deviations)
        };
        let with_deviations = Track { left: rail(Side::Left), right: rail(Side::Right) };
        let track = if station.is_some() { with_deviations } else { with_deviations.ideal() };
        Self::from_parts(Side::BOTH.map(wheel), track, attitude, station.unwrap_or(0.0))
    }

    /// From wheels and rails; `station` [m] is where along the track the wheelset stands.
    pub fn from_parts(wheels: [Wheel; 2], track: Track, attitude: Attitude, station: f64) -> Self {
        let searches = Side::BOTH.map(|side| GlobalSearch::new(wheels[side.index()].profile.as_ref(), track.rail(side).profile.as_ref()));
        WheelsetOnTrack { wheels, track, station, attitude, searches }
    }

    /// One wheel and its rail, the wheelset's centre and axes being these.
    pub fn pair<'a>(&'a self, side: Side, centre: &'a Vector3<f64>, axes: &'a Matrix3<f64>) -> Pair<'a> {
        Pair { wheel: &self.wheels[side.index()], rail: self.track.rail(side), centre, axes, distance: self.station }
    }

    /// A height and roll to begin with: tread circles at the height of the rails' origins.
    pub fn start(&self) -> Start {
        let height = |side: Side| {
            let origin = self.track.rail(side).section(self.station).origin.z;
            origin + self.wheels[side.index()].profile.at(0.0).value
        };
        let height = Side::BOTH.map(height);
        let mean = 0.5 * (height[0] + height[1]);
        Start { height: if self.attitude.level { height } else { [mean; 2] }, roll: 0.0 }
    }

    /// Mean radius at the tread circles, m.
    pub fn nominal_radius(&self) -> f64 {
        0.5 * (self.wheels[0].profile.at(0.0).value + self.wheels[1].profile.at(0.0).value)
    }

    /// Distance of the tread circles, m.
    pub fn tread_circle_distance(&self) -> f64 {
        self.wheels[0].half_spacing + self.wheels[1].half_spacing
    }

    /// Sets the wheelset down at the lateral shift `y` [m].
    ///
    /// # Errors
    /// [`NoStand`].
    pub fn stand(&self, y: f64, start: Start) -> Result<Stand, NoStand> {
        let Start { mut height, mut roll } = start;
        let mut minima = Minima::default();
        for round in 0..ITERATIONS {
            let mut touches: [Vec<Touch>; 2] = Default::default();
            for side in Side::BOTH {
                touches[side.index()] = self.touches(side, y, height[side.index()], roll, &mut minima)?;
            }
            let (step, turn, chosen) = if self.attitude.level {
                let down = touches.each_ref().map(|places| lowest(places));
                (down.map(|(step, _)| step), 0.0, down.map(|(_, index)| index))
            } else {
                let centre = Vector3::new(self.station, y, height[0]);
                let (step, turn, chosen) = self.settle(&touches, &centre).ok_or(NoStand::NotFound { y })?;
                ([step; 2], turn, chosen)
            };
            if step.iter().all(|step| step.abs() < STEP) && turn.abs() < STEP {
                return self.finish((y, height, roll), &touches, chosen, ENTERED);
            }
            let touching = |side: Side| touches[side.index()][chosen[side.index()]].distance.abs() < ROUNDED;
            if round >= CROWDED && Side::BOTH.into_iter().all(touching) && touches.iter().flatten().all(|touch| touch.distance > -ROUNDED) {
                return self.finish((y, height, roll), &touches, chosen, ROUNDED);
            }
            let shorter = step.iter().map(|step| step.abs() / LONGEST.0).fold(turn.abs() / LONGEST.1, f64::max).max(1.0);
            height = [height[0] + step[0] / shorter, height[1] + step[1] / shorter];
            roll += turn / shorter;
        }
        Err(NoStand::NotFound { y })
    }

    fn finish(
        &self,
        (y, height, roll): (f64, [f64; 2], f64),
        touches: &[Vec<Touch>; 2],
        chosen: [usize; 2],
        entered: f64,
    ) -> Result<Stand, NoStand> {
        let contacts = [touches[0][chosen[0]], touches[1][chosen[1]]];
        // On a steep flank neither height nor roll brings a wheel out of its rail.
        if touches.iter().flatten().any(|touch| touch.distance < -entered) {
            return Err(NoStand::NotFound { y });
        }
        if let Some(side) = Side::BOTH.into_iter().find(|side| contacts[side.index()].at_edge) {
            return Err(NoStand::AtEdge { y, side });
        }
        let near = Side::BOTH.map(|side| {
            let others = touches[side.index()].iter().enumerate().filter(|(index, _)| *index != chosen[side.index()]);
            let nearest = others.map(|(_, touch)| *touch).min_by(|a, b| a.distance.total_cmp(&b.distance));
            nearest.filter(|touch| touch.distance < self.attitude.near)
        });
        Ok(Stand { y, height, roll, contacts, near })
    }

    /// Every place where a wheel comes near its rail, by growing u.
    fn touches(&self, side: Side, y: f64, height: f64, roll: f64, minima: &mut Minima) -> Result<Vec<Touch>, NoStand> {
        let frame = AxleFrame::new(self.attitude.yaw, roll);
        let centre = Vector3::new(self.station, y, height);
        let pair = self.pair(side, &centre, &frame.axes);
        let mut reach = REACH.max(self.attitude.near);
        while reach < FARTHEST {
            self.searches[side.index()].find(&pair, reach, minima);
            if !minima.is_empty() {
                return Ok(minima.iter().map(|minimum| touch(&pair, minimum)).collect());
            }
            reach *= 2.0;
        }
        Err(NoStand::Beyond { y, side })
    }

    /// The step of height and roll after which one place of each wheel touches and no other one has entered its rail.
    fn settle(&self, touches: &[Vec<Touch>; 2], centre: &Vector3<f64>) -> Option<(f64, f64, [usize; 2])> {
        let (sin, cos) = self.attitude.yaw.sin_cos();
        let axis = Vector3::new(cos, sin, 0.0);
        let lever = |touch: &Touch| touch.normal.dot(&axis.cross(&(touch.position - centre)));
        let rows =
            touches.each_ref().map(|places| places.iter().map(|touch| (touch.distance, touch.normal.z, lever(touch))).collect::<Vec<_>>());
        let mut best: Option<(f64, f64, f64, [usize; 2])> = None;
        for (i, left) in rows[0].iter().enumerate() {
            for (j, right) in rows[1].iter().enumerate() {
                let determinant = left.1 * right.2 - right.1 * left.2;
                let step = (right.0 * left.2 - left.0 * right.2) / determinant;
                let turn = (left.0 * right.1 - right.0 * left.1) / determinant;
                let entering = |row: &(f64, f64, f64)| row.0 + row.1 * step + row.2 * turn;
                let worst = rows.iter().flatten().map(entering).fold(f64::INFINITY, f64::min);
                // Of those that free all places the one that stands lowest; the two that touch are free but for rounding.
                let worst = if worst > -FREE { 0.0 } else { worst };
                let is_better = |best: (f64, f64, f64, [usize; 2])| worst > best.0 || (worst == best.0 && step < best.1);
                if worst.is_finite() && best.is_none_or(is_better) {
                    best = Some((worst, step, turn, [i, j]));
                }
            }
        }
        best.map(|(_, step, turn, chosen)| (step, turn, chosen))
    }
}

/// How far a level wheel must rise until all its places are free, and which place decides.
fn lowest(places: &[Touch]) -> (f64, usize) {
    let rise = |touch: &Touch| -touch.distance / touch.normal.z;
    let highest = places.iter().enumerate().max_by(|a, b| rise(a.1).total_cmp(&rise(b.1)));
    highest.map_or((0.0, 0), |(index, touch)| (rise(touch), index))
}

/// A minimum of the distance in words of the track. The normal is that of the wheel, which also serves at kinks.
fn touch(pair: &Pair, minimum: &Minimum) -> Touch {
    let place = minimum.parameters;
    let (point, profile) = pair.wheel.point(pair.centre, pair.axes, place.wheel, place.angle);
    let sign = pair.wheel.side.sign();
    let (sin, cos) = place.angle.sin_cos();
    let radial = pair.axes.column(0) * sin - pair.axes.column(2) * cos;
    let normal = (pair.axes.column(1) * (sign * minimum.slope) - radial) / minimum.slope.hypot(1.0);
    Touch {
        wheel: place.wheel,
        rail: place.rail,
        lead: place.lead,
        rolling_radius: profile.value,
        angle: (-sign * normal.y).atan2(normal.z),
        distance: minimum.distance,
        position: point.position,
        normal,
        at_edge: minimum.at_edge,
    }
}
