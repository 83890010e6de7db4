//! What track a scene's vehicle starts on: straight and level, one curve all the way under it, or a transition.
//!
//! A place is described by its constant continuation: curvature, cant and climb, which are read off the track frame. With its turn
//! omega (per length, in its own axes), climb g and cant f (see `geometry::track::frame`):
//!
//! ```text
//! psi' cos g = omega_y sin f + omega_z cos f
//! ```

use super::fade::Faded;
use super::spec::Scene;
use crate::geometry::Side;
use crate::geometry::track::centre_line::{CentreLine, Node};
use crate::geometry::track::waves::Stretch;
use crate::geometry::track::{Deviation, DeviationShape, Direction};
use std::sync::Arc;

/// The track at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// Straight and level.
    Straight,
    /// Constant curvature, superelevation and grade under the whole vehicle.
    Curve(Node),
    /// They change under the vehicle; at this distance [m] they are not what they are at its front.
    Transition { distance: f64 },
}

/// Less than this is nothing: 1000 km of radius, 0.1 mrad of cant, 0.01 per mille of grade.
const STRAIGHT: f64 = 1e-6;
const LEVEL: f64 = 1e-4;
const CLIMB: f64 = 1e-5;

/// A vehicle stands on the track this far in front of its foremost and behind its rearmost centre of mass, m.
const REACH: f64 = 1.0;

/// Looks at the track under the bodies of a scene's vehicle.
pub fn start(scene: &Scene) -> Start {
    let Some(line) = &scene.track.line else { return Start::Straight };
    let centres = centres(scene);
    let first = centres.first().map_or(Node::default(), |distance| continuation(line, *distance));
    let places = centres.iter().flat_map(|centre| [*centre, centre - REACH, centre + REACH]);
    if let Some(distance) = places.into_iter().find(|distance| !alike(&first, &continuation(line, *distance))) {
        return Start::Transition { distance };
    }
    if alike(&first, &Node::default()) { Start::Straight } else { Start::Curve(first) }
}

/// A lone wheelset starts on a transition as on straight level track: what is there may go without a word up to a radius of 10 km and 2 mrad of cant.
const SLIGHT: (f64, f64) = (1e-4, 2e-3);

/// That it does, where it matters.
pub(super) fn lone_on_a_transition(scene: &Scene) -> Option<String> {
    if !scene.vehicle.is_lone() {
        return None;
    }
    let Start::Transition { distance } = start(scene) else { return None };
    let here = continuation(scene.track.line.as_ref()?, origin(scene));
    let matters = here.curvature.abs() > SLIGHT.0 || here.superelevation.abs() > SLIGHT.1;
    matters.then(|| {
        format!(
            "the wheelset starts on a transition (curvature, cant or grade change at {distance:.1} m), where there is no steady state, and stands as on straight level track: its first metres run \
             in; start before the transition or behind it (vehicle.initial.distance)"
        )
    })
}

/// Distance of the design frame's origin, m.
pub fn origin(scene: &Scene) -> f64 {
    scene.vehicle.initial.values[0]
}

/// Distances of all bodies' centres, wheelsets first, m.
pub(super) fn centres(scene: &Scene) -> Vec<f64> {
    let origin = origin(scene);
    (0..scene.vehicle.body_count()).map(|body| origin + scene.vehicle.design_position(body).x).collect()
}

/// What displaces the rails, faded in where the scene asks for it.
pub fn deviations(scene: &Scene) -> Vec<Deviation> {
    let deviations = &scene.track.deviations;
    let Some(length) = scene.track.start_fade else { return deviations.clone() };
    let forward = scene.vehicle.speed >= 0.0;
    let front = |a: f64, b: f64| if forward { a.max(b) } else { a.min(b) };
    let foremost = centres(scene).into_iter().reduce(front).unwrap_or(0.0);
    let faded = |deviation: &Deviation| {
        let shape =
            Faded { shape: deviation.shape.clone(), from: foremost + REACH.copysign(if forward { 1.0 } else { -1.0 }), length, forward };
        Deviation { shape: Arc::new(shape), ..*deviation }
    };
    deviations.iter().map(faded).collect()
}

/// How rails are displaced under the wheels of a scene's vehicle at its start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displaced {
    /// Largest displacement, m, and slope, -, of a rail under a wheel.
    pub most: f64,
    pub steepest: f64,
}

/// A displacement that is the same everywhere, m.
#[derive(Debug)]
struct Constant(f64);

impl DeviationShape for Constant {
    fn at(&self, _: f64) -> [f64; 4] {
        [self.0, 0.0, 0.0, 0.0]
    }

    fn breaks(&self) -> Vec<f64> {
        Vec::new()
    }

    fn waves(&self) -> Vec<Stretch> {
        Vec::new()
    }

    fn describe(&self) -> String {
        format!("{} m", self.0)
    }
}

/// Displacements under wheelsets that differ by less than this are one, m, and slopes below this are none, -.
const ONE: f64 = 1e-6;
const FLAT: f64 = 1e-6;

/// Rails that lie everywhere as they do under all wheelsets of a vehicle at its start, as where the gauge is another one for good; nothing where they do not lie aside. `None`: they lie
/// otherwise under one wheelset than under another, or not along the track.
pub fn constant_displacements(scene: &Scene) -> Option<Vec<Deviation>> {
    let deviations = deviations(scene);
    let centres = &centres(scene)[..scene.vehicle.wheelsets.len()];
    let mut constant = Vec::new();
    let places: Vec<Sums> = centres.iter().map(|distance| sums(&deviations, *distance)).collect();
    let first = places.first()?;
    for (side, direction) in
        Side::BOTH.into_iter().flat_map(|side| [Direction::Lateral, Direction::Vertical].map(|direction| (side, direction)))
    {
        let of = |sums: &Sums| sums[side.index()][usize::from(direction == Direction::Vertical)];
        let aside = of(first)[0];
        let stays = |sums: &Sums| {
            let [value, slope, bend] = of(sums);
            (value - aside).abs() < ONE && slope.abs() < FLAT && bend.abs() < FLAT
        };
        if !places.iter().all(stays) {
            return None;
        }
        if aside != 0.0 {
            constant.push(Deviation { side, direction, shape: Arc::new(Constant(aside)) });
        }
    }
    Some(constant)
}

/// By rail, and lateral or vertical: displacement, m, slope and bend.
type Sums = [[[f64; 3]; 2]; 2];

/// What displaces the rails at a distance [m], all together.
fn sums(deviations: &[Deviation], distance: f64) -> Sums {
    let mut sums = Sums::default();
    for deviation in deviations {
        let sum = &mut sums[deviation.side.index()][usize::from(deviation.direction == Direction::Vertical)];
        sum.iter_mut().zip(deviation.shape.at(distance)).for_each(|(sum, part)| *sum += part);
    }
    sums
}

/// Are rails displaced, or do they rise or swing, under any wheel?
pub fn displaced(scene: &Scene) -> Option<Displaced> {
    let wheelsets = scene.vehicle.wheelsets.len();
    let deviations = deviations(scene);
    let mut found = Displaced { most: 0.0, steepest: 0.0 };
    for distance in &centres(scene)[..wheelsets] {
        for [value, slope, _] in sums(&deviations, *distance).into_iter().flatten() {
            found = Displaced { most: found.most.max(value.abs()), steepest: found.steepest.max(slope.abs()) };
        }
    }
    (found.most > 0.0 || found.steepest > 0.0).then_some(found)
}

fn alike(a: &Node, b: &Node) -> bool {
    (a.curvature - b.curvature).abs() <= STRAIGHT
        && (a.superelevation - b.superelevation).abs() <= LEVEL
        && (a.grade - b.grade).abs() <= CLIMB
}

/// Curvature, cant and climb at a distance [m], as a node at 0.
fn continuation(line: &CentreLine, distance: f64) -> Node {
    let frame = line.frame(distance);
    let (climb, level) = (frame.axes[(2, 0)], frame.axes[(2, 0)].asin().cos());
    let superelevation = (frame.axes[(2, 1)] / level).asin();
    let (sin, cos) = superelevation.sin_cos();
    let curvature = (frame.turn.y * sin + frame.turn.z * cos) / level;
    Node { distance: 0.0, curvature, superelevation, grade: climb.asin() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::track::centre_line::{Alignment, Pivot};
    use nalgebra::Vector3;

    /// What a node says is read off the line that was laid from it.
    #[test]
    fn analytic_continuation_of_a_constant_track_is_its_node() {
        let node = Node { distance: 0.0, curvature: -0.004, superelevation: 0.09, grade: 0.03 };
        let alignment = Alignment { nodes: vec![node], smoothing: 0.0, pivot: Pivot::Centre };
        let line = CentreLine::new(&alignment, Vector3::new(5.0, 2.0, 1.0), 0.7).unwrap();
        for distance in [-30.0, 0.0, 250.0] {
            let found = continuation(&line, distance);
            let off = [found.curvature - node.curvature, found.superelevation - node.superelevation, found.grade - node.grade];
            assert!(off.iter().all(|off| off.abs() < 1e-15), "{off:?}");
        }
    }
}
