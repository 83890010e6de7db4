//! Outputs that a controller of traction and brakes asks for: slip and adhesion of each wheelset (group `adhesion`, shown where a scene names it).
//!
//! With the spin w of the axle against the track [rad/s], the radius r of the tread circle and the speed v along the track:
//! slip `r w - v` [m/s], positive where the axle runs ahead (driving). A yawed or displaced wheelset rolls on other radii: 1 mm of radius at 40 m/s
//! shows as 0.09 m/s. Used adhesion is the force of both rails along the track over their vertical force, forward positive.

use super::Snapshot;
use super::feedthrough::{Depends, FRICTION_INPUTS, Feedthrough, Ties};
use super::outputs::{Needs, Output, on_track};
use crate::formulation::{Model, contact_index};
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
        let (body, radius) = (wheelset.body, wheelset.left.profile.at(0.0).value);
        let label = |id: u32, name: &str| ((index as u32 + 1) * 1000 + id, format!("{}.{name}", wheelset.name));
        let text = "slip: rolling speed of the tread circle less the speed along the track, positive when driving";
        let mut slip = Output::new(
            label(34, "slipSpeed"),
            ADHESION,
            Unit::MetrePerSecond,
            text,
            Feedthrough::none(),
            Box::new(move |s| slip_speed(s, body, radius)),
        );
        slip.needs = Needs::Motion;
        all.push(slip);
        let text = "used adhesion: force of the rails on both wheels along the track, forward positive, over their vertical force";
        let feedthrough = Feedthrough::of_wheelset(model, &ties, body, Depends::Contact(FRICTION_INPUTS));
        let used = move |s: &Snapshot| used_adhesion(s, index, body);
        all.push(Output::new(label(35, "usedAdhesion"), ADHESION, Unit::One, text, feedthrough, Box::new(used)));
    }
    all
}

fn slip_speed(s: &Snapshot, body: usize, radius: f64) -> f64 {
    let motion = &s.workspace.system.motions[body];
    let (spin, speed) =
        on_track(s, body).map_or((motion.pitch_rate, motion.speed), |(relative, _)| (relative.velocities[5], relative.velocities[0]));
    radius * spin - speed
}

fn used_adhesion(s: &Snapshot, wheelset: usize, body: usize) -> f64 {
    let force: Vector3<f64> = Side::BOTH.map(|side| s.workspace.wheel_force(contact_index(wheelset, side), body)).iter().sum();
    if force.z > UNLOADED { force.x / force.z } else { 0.0 }
}
