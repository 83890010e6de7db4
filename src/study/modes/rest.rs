//! A run that stays in a steady state which is not stable.
//!
//! On perfect track an unstable steady state lasts: what would grow has no beginning but rounding, and implicit steps of seconds, which nothing makes shorter, take that away. A user would
//! read "runs smoothly" above the critical speed. So where a run ends with wheelsets that don't move across their track, the modes about its last place and speed are found, and told where one grows.

use super::modes;
use crate::scene::spec::Scene;
use crate::scene::start::{self, Start};
use crate::sim::Simulation;

/// Velocities across the track below this are none, m/s: half a wave of 6 Hz is 25 nm then.
const RESTS: f64 = 1e-6;
/// Growth below this makes nothing of rounding within minutes, 1/s.
const GROWS: f64 = 0.02;
/// Slower vehicles than this stand, m/s.
const ROLLS: f64 = 0.5;
/// With more states the modes take longer than most runs (two coaches 0.4 s, three of them with 300 states 1.3 s).
const MOST_STATES: usize = 200;

/// What a user should know of a simulation that rests, now, in a state that is not stable.
pub fn unstable_rest(scene: &Scene, simulation: &mut Simulation) -> Option<String> {
    let origin = scene.vehicle.wheelsets.first()?.x;
    let begun = simulation.model().start_inputs();
    let snapshot = simulation.snapshot().ok()?;
    let workspace = &snapshot.workspace;
    let motions = &workspace.system.motions;
    let rests = (0..scene.vehicle.wheelsets.len()).all(|body| workspace.in_track(body, motions[body].velocity).y.abs() < RESTS);
    let first = motions.first()?;
    let (distance, speed) = workspace.system.stations.get(0).map_or((first.distance, first.speed), |at| (at.frame.distance, at.speed));
    // Modes are those of the vehicle with the inputs of its start.
    let driven = snapshot.inputs() != begun;
    if !rests || driven || snapshot.y.len() > MOST_STATES || speed.abs() < ROLLS {
        return None;
    }
    let mut there = scene.clone();
    there.vehicle.initial.values[0] = distance - origin;
    // What fades in has done so.
    there.track.start_fade = None;
    // Between rails that lie aside here and otherwise there modes are not those of any place, and in curves they are those of rails that lie aside nowhere.
    let aside = start::constant_displacements(&there)?;
    if !aside.is_empty() && matches!(start::start(&there), Start::Curve(_)) {
        return None;
    }
    let found = modes(&there, speed).ok().filter(|found| found.unbalanced < super::STEADY && !found.coasts)?;
    let mode = found.growing().filter(|mode| mode.growth > GROWS).max_by(|a, b| a.growth.total_cmp(&b.growth))?;
    let swings = if mode.frequency > 0.0 { format!(" at {:.2} Hz", mode.frequency) } else { String::new() };
    let place = match start::start(&there) {
        Start::Curve(node) if node.curvature != 0.0 => " in this curve",
        _ => "",
    };
    Some(format!(
        "steady running at {speed:.1} m/s{place} is not stable, and on perfect track nothing shows it: {}{swings} grows by {:.2} 1/s once anything sets it going (an irregularity, a \
         deviation, a wheelset's offset); see `wheelrail modes`",
        mode.name, mode.growth
    ))
}
