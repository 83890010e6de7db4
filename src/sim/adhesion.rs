//! Outputs that a controller of traction and brakes asks for: slip and adhesion of each wheelset and wheel (group `adhesion`, shown where a scene names it).
//!
//! With the spins w of the wheels about their axle in space [rad/s] (in vertical curves that is not `pitchRate`, which is against the track that turns), their radii r at the tread circle and the speed v of the axle's centre along the track:
//! slip `(r_left w_left + r_right w_right) / 2 - v` [m/s], positive where the axle runs ahead (driving). A yawed or displaced wheelset rolls on other radii: 1 mm of radius at 40 m/s
//! shows as 0.09 m/s. Used adhesion is the force of the rails along the track over their vertical force, forward positive; available adhesion is
//! what friction without slip would permit, the sum of mu N over the vertical force (mu of the scene, of the place on the rail, and of the input). A law whose friction falls with slip
//! reaches less, and what the lateral creep force uses is not subtracted.
//!
//! Numbers: of a wheelset 34 (`slipSpeed`), 35 (`usedAdhesion`), 42 (`availableAdhesion`); of a wheel 13 (`usedAdhesion`), 14 (`availableAdhesion`).

use super::Snapshot;
use super::feedthrough::{Depends, FRICTION_INPUTS, Feedthrough, Ties, of_wheel};
use super::outputs::{Needs, Output, on_track};
use crate::contact::friction::FrictionMap;
use crate::formulation::{LEFT_FRICTION, Model, WHEELSET_INPUTS, contact_index, factor_at};
use crate::geometry::Side;
use crate::scene::spec::ADHESION;
use crate::units::Unit;
use nalgebra::Vector3;

/// Vertical force below which there is no adhesion, N.
const UNLOADED: f64 = 1.0;

/// Slip and adhesion of every wheelset.
pub(super) fn adhesion_outputs(model: &Model) -> Vec<Output> {
    let ties = Ties::of(model);
    let mut all = Vec::new();
    for (index, wheelset) in model.wheelsets.iter().enumerate() {
        let body = wheelset.body;
        let wheels = Side::BOTH.map(|side| (wheelset.turning[side.index()], wheelset.wheel(side).profile.at(0.0).value));
        let label = |id: u32, name: &str| ((index as u32 + 1) * 1000 + id, format!("{}.{name}", wheelset.name));
        let text = "slip: rolling speed of the tread circle less the speed along the track, forward positive (driving forward or braking backward); the axle's, where wheels turn apart the mean of both";
        let mut slip = Output::new(
            label(34, "slipSpeed"),
            ADHESION,
            Unit::MetrePerSecond,
            text,
            Feedthrough::none(),
            Box::new(move |s| slip_speed(s, body, &wheels)),
        );
        slip.needs = Needs::Motion;
        all.push(slip);
        let mut add = |label, text, depends, read| {
            all.push(Output::new(label, ADHESION, Unit::One, text, Feedthrough::of_wheelset(model, &ties, body, depends), read));
        };
        let both = Depends::Contact(FRICTION_INPUTS);
        let text = "used adhesion: force of the rails on both wheels along the track, forward positive, over their vertical force";
        add(label(35, "usedAdhesion"), text, both, Box::new(move |s: &Snapshot| used_adhesion(s, &Side::BOTH, index, body)));
        let text = "available adhesion: friction without slip times normal force of both wheels over their vertical force";
        let friction = Friction::of(model);
        let read = Box::new(move |s: &Snapshot| friction.available(s, &Side::BOTH, index, body));
        add(label(42, "availableAdhesion"), text, both, read);
        for (side, base) in Side::BOTH.into_iter().zip([100, 200]) {
            let on = of_wheel(side).friction;
            let label = |id: u32, name: &str| label(base + id, &format!("{}.{name}", side.name()));
            let text = "used adhesion of the wheel: force of the rail along the track, forward positive, over Q; 0 below Q = 1 N";
            add(label(13, "usedAdhesion"), text, on, Box::new(move |s: &Snapshot| used_adhesion(s, &[side], index, body)));
            let text = "available adhesion of the wheel: friction without slip times normal force over Q; 0 below Q = 1 N";
            let friction = Friction::of(model);
            let read = Box::new(move |s: &Snapshot| friction.available(s, &[side], index, body));
            add(label(14, "availableAdhesion"), text, on, read);
        }
    }
    all
}

/// `wheels`: what turns on each side, and its radius, m.
fn slip_speed(s: &Snapshot, body: usize, wheels: &[(usize, f64); 2]) -> f64 {
    let motions = &s.workspace.system.motions;
    let motion = &motions[body];
    let speed = on_track(s, body).map_or(motion.speed, |(relative, _)| relative.velocities[0]);
    let rolling = wheels.map(|(turning, radius)| radius * motions[turning].rotation.dot(&motions[turning].axle()));
    0.5 * (rolling[0] + rolling[1]) - speed
}

/// Sum of the forces of the rails on these wheels of a wheelset in the track frame, N.
fn rails(s: &Snapshot, sides: &[Side], wheelset: usize, body: usize) -> Vector3<f64> {
    sides.iter().map(|side| s.workspace.wheel_force(contact_index(wheelset, *side), body)).sum()
}

fn used_adhesion(s: &Snapshot, sides: &[Side], wheelset: usize, body: usize) -> f64 {
    let force = rails(s, sides, wheelset, body);
    if force.z > UNLOADED { force.x / force.z } else { 0.0 }
}

/// What friction there is, without the factors of inputs.
struct Friction {
    coefficient: f64,
    map: Option<FrictionMap>,
}

impl Friction {
    fn of(model: &Model) -> Friction {
        Friction { coefficient: model.laws.friction, map: model.laws.friction_map.clone() }
    }

    fn available(&self, s: &Snapshot, sides: &[Side], wheelset: usize, body: usize) -> f64 {
        let vertical = rails(s, sides, wheelset, body).z;
        if vertical <= UNLOADED {
            return 0.0;
        }
        let motion = &s.workspace.system.motions[body];
        let of_side = |side: &Side| {
            // A polynomial input may pass below zero between communication points.
            let factor = s.inputs()[WHEELSET_INPUTS * wheelset + LEFT_FRICTION + side.index()].max(0.0);
            let reports = s.workspace.reports(contact_index(wheelset, *side)).filter(|report| report.normal_force > 0.0);
            let bound = reports.map(|report| {
                let here = || self.map.as_ref().map_or(1.0, |map| factor_at(map, *side, motion, report).value);
                report.friction_bound.unwrap_or_else(|| self.coefficient * here() * factor * report.normal_force)
            });
            bound.sum::<f64>()
        };
        sides.iter().map(of_side).sum::<f64>() / vertical
    }
}
