//! Loads of wheels, and a vehicle that stands askew on straight track: a body, a spring or a load that is not where it was meant to be.

use crate::geometry::track::centre_line::CentreLine;
use crate::scene::spec::Scene;
use crate::scene::start::origin;
use crate::scene::vehicle::graph::Graph;
use serde::Serialize;

/// Loads of one wheelset's wheels, N, square to the track.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WheelLoads {
    pub wheelset: String,
    pub left: f64,
    pub right: f64,
}

/// Wheels of one truck, and of one wheelset, carry loads whose quotient is below this: more than traction and torsion of a frame make of them.
const UNEVEN: f64 = 1.5;
/// Angle between the rails' plane and level [rad], and curvature [1/m], that are none.
const LEVEL: f64 = 1e-3;
const STRAIGHT: f64 = 1e-5;

/// Of the truck, or the wheelset that is in none, whose wheels differ most at the start, where that is on straight track without cant.
pub(super) fn note(scene: &Scene, wheels: &[WheelLoads]) -> Option<String> {
    let vehicle = &scene.vehicle;
    let straight = |line: &CentreLine| {
        vehicle.wheelsets.iter().all(|wheelset| {
            let frame = line.frame(origin(scene) + wheelset.x);
            frame.turn.norm() < STRAIGHT && frame.axes[(2, 1)].abs() < LEVEL
        })
    };
    if !scene.track.line.as_deref().is_none_or(straight) {
        return None;
    }
    let graph = Graph::of(vehicle);
    let extremes = |wheelsets: Vec<usize>| {
        let loads = wheelsets.iter().filter_map(|wheelset| wheels.get(*wheelset)).flat_map(sides);
        let order = |a: &(f64, String), b: &(f64, String)| a.0.total_cmp(&b.0);
        loads.clone().min_by(order).zip(loads.max_by(order))
    };
    let all = (0..wheels.len()).filter_map(|wheelset| extremes(graph.wheelsets_of_truck(wheelset)));
    let (least, most) = all.max_by(|a, b| (a.1.0 - a.0.0).total_cmp(&(b.1.0 - b.0.0)))?;
    (most.0 > UNEVEN * least.0).then(|| {
        format!(
            "{} carries {:.1} kN at the start, and {} of the same truck {:.1} kN, on straight track: are all bodies, springs and loads where they were meant to be (places inside a module \
             count from its own origin), on both sides? wheelrail plan --static shows heights and forces",
            most.1,
            1e-3 * most.0,
            least.1,
            1e-3 * least.0
        )
    })
}

fn sides(loads: &WheelLoads) -> [(f64, String); 2] {
    [(loads.left, "left"), (loads.right, "right")].map(|(load, side)| (load, format!("{}, {side} wheel", loads.wheelset)))
}
