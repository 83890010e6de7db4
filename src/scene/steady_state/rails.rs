//! Rails that are displaced where the vehicle starts: how it stands on them, and how it moves as one that came along.
//!
//! Every wheelset stands on the rails at its own distance, all bodies in static balance above them. The velocities are given. With a,
//! l, c and b the rails' mean lateral displacement (left positive), mean height, difference of heights (left less right) and distance
//! of a wheelset's contacts, ' along the track, and V the speed:
//!
//! ```text
//! wheelset:      z' = V l',  roll' = V c'/b,  accelerations V^2 l'', V^2 c''/b
//! other bodies:  z', pitch' and roll' of a straight line through their wheelsets' velocities, no acceleration
//! all bodies:    y' = V g,  yaw' = V g',  g(s) = (a(s + L/2) - a(s - L/2)) / L,  L = 10 m
//! ```
//!
//! A wheel must go up and down with its rail: without these velocities the contact's damper and spring would stop 1.8 t at t = 0; with the acceleration
//! the load holds what curved rails demand (Q - static = m V^2 l''/2). Vertical motion is at last corrected so that no pressed contact is
//! being compressed. Across the track nothing forces a wheelset to follow: it runs where its conicity takes it, over waves longer than L along
//! the rails and over shorter ones straight on; the yaw angle at which it does so without lateral creep is found with the balance. The line of a
//! body that is no wheelset goes through all wheelsets with the weights `1 / (1 m2 + d^2)`, d their distance from it: a frame goes with its own
//! two, a car with its trucks.
//!
//! *How it is found:* on elastic contacts, from the balance on ideal rails, by shares of the displacements (each from the line through the last two
//! balances); a formulation with constraints then finds its own balance from there. Where constraints leave bodies no choice only the part of
//! accelerations that they allow is compared. If there is no balance with V^2 l'' and V^2 c''/b it is looked for without them.
//!
//! *Where it is only near:* waves that a body on springs does not follow at speed are in its place and velocity, too. It then swings by some
//! 0.1 mm to millimetres about what a run that came from far behind has.

use super::Standing;
use crate::geometry::Side;
use crate::geometry::profile::Profile;
use crate::geometry::track::centre_line::CentreLine;
use crate::geometry::track::waves::Stretch;
use crate::geometry::track::{Deviation, DeviationShape, Rail, Track};
use crate::mbs::body::COORDINATES;
use crate::scene::spec::Scene;
use crate::scene::start;
use std::sync::Arc;

/// Length over which the lateral direction of the track is taken, m.
const DIRECTION: f64 = 10.0;
/// Square of the distance within which wheelsets count alike for a body, m2.
const NEAR: f64 = 1.0;

/// A motion relative to the pattern: of coordinates along the track frame's axes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ride {
    /// Per metre of travel: m/m, rad/m.
    pub slopes: [f64; COORDINATES],
    /// Per metre squared: what its acceleration has to be over V^2.
    pub bends: [f64; COORDINATES],
    /// Where it stands in first approximation, beside where it would on ideal track, m and rad.
    pub places: [f64; COORDINATES],
}

impl Ride {
    /// On rails displaced by that share.
    pub fn times(&self, share: f64) -> Ride {
        let part = |values: [f64; COORDINATES]| values.map(|value| share * value);
        Ride { slopes: part(self.slopes), bends: part(self.bends), places: part(self.places) }
    }
}

/// Displaced rails under a vehicle whose design frame's origin is at distance 0, and how its bodies ride on them.
#[derive(Clone, Debug)]
pub(super) struct Riding {
    /// Profiles of both rails, their distance from the centre line [m] and inclination [rad].
    profiles: [Arc<dyn Profile>; 2],
    half_distance: f64,
    inclination: f64,
    deviations: Vec<Deviation>,
    pub bodies: Vec<Ride>,
}

/// A deviation `share` times as large, and seen from `origin` [m].
#[derive(Debug)]
struct Seen {
    shape: Arc<dyn DeviationShape>,
    origin: f64,
    share: f64,
}

impl DeviationShape for Seen {
    fn at(&self, s: f64) -> [f64; 4] {
        self.shape.at(s + self.origin).map(|value| self.share * value)
    }

    fn breaks(&self) -> Vec<f64> {
        Vec::new()
    }

    /// No step is made on it.
    fn waves(&self) -> Vec<Stretch> {
        Vec::new()
    }

    fn describe(&self) -> String {
        format!("{} times: {}", self.share, self.shape.describe())
    }
}

/// What both rails do together at some distance: a, l and c with their derivatives.
struct Both {
    lateral: [f64; 4],
    level: [f64; 4],
    cross: [f64; 4],
}

fn both(track: &Track, s: f64) -> Both {
    let ([left_y, left_z], [right_y, right_z]) = (track.left.deviation(s), track.right.deviation(s));
    let mean = |a: [f64; 4], b: [f64; 4]| [0, 1, 2, 3].map(|i| 0.5 * (a[i] + b[i]));
    Both { lateral: mean(left_y, right_y), level: mean(left_z, right_z), cross: [0, 1, 2, 3].map(|i| left_z[i] - right_z[i]) }
}

impl Riding {
    /// `None` where all wheels of the scene's vehicle start on rails that are where they should be.
    pub fn new(scene: &Scene, standing: &Standing) -> Option<Riding> {
        start::displaced(scene)?;
        let origin = start::origin(scene);
        let seen = |deviation: Deviation| Deviation { shape: Arc::new(Seen { shape: deviation.shape, origin, share: 1.0 }), ..deviation };
        let deviations: Vec<Deviation> = start::deviations(scene).into_iter().map(seen).collect();
        let mut riding = Riding {
            profiles: scene.track.rails.each_ref().map(|rail| rail.profile.clone()),
            half_distance: scene.track.half_rail_distance,
            inclination: scene.track.inclination,
            deviations,
            bodies: Vec::new(),
        };
        let track = riding.track(None, 1.0);
        let base = 2.0 * scene.track.half_rail_distance;
        let direction = |s: f64| {
            let [ahead, behind] = [0.5, -0.5].map(|part| both(&track, s + part * DIRECTION).lateral);
            [0, 1].map(|i| (ahead[i] - behind[i]) / DIRECTION)
        };
        let wheelsets: Vec<(f64, Both)> =
            standing.positions[..standing.wheelsets].iter().map(|place| (place.x, both(&track, place.x))).collect();
        let bodies = standing.positions.iter().enumerate().map(|(body, place)| {
            let [heading, turning] = direction(place.x);
            let mut ride = match wheelsets.get(body) {
                Some((_, Both { lateral, level, cross })) => {
                    let of = |i: usize| [0.0, lateral[i], level[i], 0.0, cross[i] / base, 0.0];
                    Ride { places: of(0), slopes: of(1), bends: of(2) }
                }
                None => between(&wheelsets, place.x, base),
            };
            // Above the rails a roll takes a centre to the right.
            ride.places[1] -= place.z * ride.places[4];
            (ride.slopes[1], ride.slopes[3], ride.bends[1]) = (heading, turning, 0.0);
            ride.places[3] = heading;
            ride
        });
        riding.bodies = bodies.collect();
        Some(riding)
    }

    /// The same ride with static loads: as if rails were straight from here on.
    pub fn without_bends(&self) -> Riding {
        let mut level = self.clone();
        level.bodies.iter_mut().for_each(|ride| ride.bends = [0.0; COORDINATES]);
        level
    }

    /// The rails with that share of their displacements, along a centre line.
    pub fn track(&self, line: Option<Arc<CentreLine>>, share: f64) -> Track {
        let less = |deviation: &Deviation| Deviation {
            shape: Arc::new(Seen { shape: deviation.shape.clone(), origin: 0.0, share }),
            ..*deviation
        };
        let deviations: Vec<Deviation> = self.deviations.iter().map(less).collect();
        let [left, right] = Side::BOTH.map(|side| {
            let profile = self.profiles[side.index()].clone();
            Rail::new(side, profile, self.half_distance, self.inclination, &deviations).along(line.clone())
        });
        Track { left, right }
    }
}

/// A body at x [m] that goes with the wheelsets around it: a line through heights, means of the rest.
fn between(wheelsets: &[(f64, Both)], x: f64, base: f64) -> Ride {
    let weighed = wheelsets.iter().map(|(place, both)| {
        let ahead = place - x;
        (1.0 / (NEAR + ahead * ahead), ahead, both)
    });
    let mut sums = [0.0; 3];
    let mut heights = [[0.0; 2]; 2];
    let mut ride = Ride::default();
    for (weight, ahead, both) in weighed {
        sums = [sums[0] + weight, sums[1] + weight * ahead, sums[2] + weight * ahead * ahead];
        for (i, heights) in heights.iter_mut().enumerate() {
            *heights = [heights[0] + weight * both.level[i], heights[1] + weight * ahead * both.level[i]];
        }
        ride.places[1] += weight * both.lateral[0];
        ride.places[4] += weight * both.cross[0] / base;
        ride.slopes[4] += weight * both.cross[1] / base;
    }
    let total = sums[0];
    ride.places.iter_mut().chain(&mut ride.slopes).for_each(|value| *value /= total);
    // All wheelsets at one place make no line.
    let spread = total * sums[2] - sums[1] * sums[1];
    let line = |[mean, moment]: [f64; 2]| {
        let tilt = if spread > 1e-6 * total * total { (total * moment - sums[1] * mean) / spread } else { 0.0 };
        [(mean - tilt * sums[1]) / total, tilt]
    };
    let ([height, tilt], [climb, tilting]) = (line(heights[0]), line(heights[1]));
    (ride.places[2], ride.places[5]) = (height, -tilt);
    (ride.slopes[2], ride.slopes[5]) = (climb, -tilting);
    ride
}
