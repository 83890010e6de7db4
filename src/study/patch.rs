//! The contact patches of a wheelset at a lateral shift, yaw and load: half-space contact of the real surfaces, and beside it the ellipse that the
//! scene's laws make of the deepest place.
//!
//! The wheelset is set down as rigid (`contact_geometry`), then each wheel is lowered until its normal pressures carry the load; roll stays. It rolls
//! freely: at that pitch rate at which the creep forces of the real patches turn it neither faster nor slower. The ellipses move alike.

use super::conicity::RollingPose;
use super::contact_geometry::{Attitude, NoStand, Stand, Touch, WheelsetOnTrack};
use crate::contact::Patch;
use crate::contact::creep::RollingContact;
use crate::contact::creepage::{ContactAxes, CreepForce, in_rolling_direction};
use crate::contact::patch::{Motion, PatchSolution, Settings, depth_under_load, solve};
use crate::contact::search::algebraic::{Pair, SurfaceParameters};
use crate::geometry::Side;
use crate::math::rotation::AxleFrame;
use crate::scene::spec::Scene;
use nalgebra::Vector3;

/// What is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Question {
    /// Lateral shift, m, and attitude.
    pub y: f64,
    pub attitude: Attitude,
    /// Place along the track whose deviations count, m.
    pub station: Option<f64>,
    /// Vertical load of each wheel, N.
    pub load: f64,
    pub settings: Settings,
}

/// Why there is no answer.
#[derive(Clone, Debug, thiserror::Error)]
pub enum NoPatch {
    #[error(transparent)]
    Stand(#[from] NoStand),
    #[error("{} wheel: no depth within 5 mm carries {load} N", side.name())]
    TooHeavy { side: Side, load: f64 },
}

/// The ellipse at the deepest place.
#[derive(Clone, Copy, Debug)]
pub struct Ellipse {
    /// Penetration, m.
    pub penetration: f64,
    pub normal_force: f64,
    pub patch: Patch,
    pub touch: Touch,
    /// On the wheel, in the contact's axes.
    pub creep: CreepForce,
}

/// One wheel's patch.
#[derive(Clone, Debug)]
pub struct WheelPatch {
    pub side: Side,
    /// By how much the wheel was lowered from its rigid stand, m.
    pub approach: f64,
    pub solution: PatchSolution,
    /// Coordinate u of the wheel at the load's centre, m, rolling radius there, m, and contact angle of the mean normal, rad.
    pub wheel: f64,
    pub rolling_radius: f64,
    pub angle: f64,
    /// Tractions' force and moment in the axes of the mean normal.
    pub creep: CreepForce,
    /// `None` where the laws know none (conformal surfaces).
    pub ellipse: Option<Ellipse>,
}

/// Both wheels.
#[derive(Clone, Debug)]
pub struct Answer {
    pub stand: Stand,
    /// rad/s.
    pub pitch_rate: f64,
    pub wheels: [WheelPatch; 2],
}

/// Solves both patches.
///
/// # Errors
/// [`NoPatch`].
pub fn patches(scene: &Scene, question: &Question) -> Result<Answer, NoPatch> {
    let wheelset = WheelsetOnTrack::new(scene, question.attitude, question.station);
    let stand = wheelset.stand(question.y, wheelset.start())?;
    let speed = scene.vehicle.speed;
    let mean = 0.5 * (stand.contacts[0].rolling_radius + stand.contacts[1].rolling_radius);
    let [left, right] = Side::BOTH.map(|side| approach(scene, question, &wheelset, &stand, side));
    let approaches = [left?, right?];
    let both = |pitch_rate: f64| -> Result<[WheelPatch; 2], NoPatch> {
        let of = |side: Side| wheel_patch(scene, question, &wheelset, &stand, (side, approaches[side.index()], pitch_rate));
        Ok([of(Side::Left)?, of(Side::Right)?])
    };
    // What the creep forces drive the axle with grows with the pitch rate.
    let driving =
        |wheels: &[WheelPatch; 2]| wheels.iter().map(|wheel| wheel.creep.longitudinal * wheel.rolling_radius).sum::<f64>() * speed.signum();
    let free = 1e-4 * scene.contact.friction * question.load * mean;
    let mut rate = speed / mean;
    let mut wheels = both(rate)?;
    let (mut low, mut high) = (None::<(f64, f64)>, None::<(f64, f64)>);
    for _ in 0..ROUNDS {
        let turning = driving(&wheels);
        if speed == 0.0 || turning.abs() <= free {
            break;
        }
        *(if turning > 0.0 { &mut high } else { &mut low }) = Some((rate, turning));
        rate = match (low, high) {
            (Some((a, at_a)), Some((b, at_b))) => a + (b - a) * (at_a / (at_a - at_b)).clamp(0.05, 0.95),
            (Some((a, _)), None) => a * (1.0 + STEP),
            (None, Some((b, _))) => b * (1.0 - STEP),
            (None, None) => break,
        };
        wheels = both(rate)?;
    }
    Ok(Answer { stand, pitch_rate: rate, wheels })
}

/// Change of the pitch rate by which the free one is bracketed, and how often it is changed.
const STEP: f64 = 4e-4;
const ROUNDS: usize = 40;

/// By how much a wheel is lowered until it carries the load, m.
fn approach(scene: &Scene, question: &Question, wheelset: &WheelsetOnTrack, stand: &Stand, side: Side) -> Result<f64, NoPatch> {
    let frame = AxleFrame::new(question.attitude.yaw, stand.roll);
    let centre = Vector3::new(wheelset.station, stand.y, stand.height[side.index()]);
    let pair = wheelset.pair(side, &centre, &frame.axes);
    depth_under_load(&pair, question.load, scene.contact.material, question.settings).ok_or(NoPatch::TooHeavy { side, load: question.load })
}

/// A wheelset on its rails that rolls on the centres of its loads instead of its deepest places.
///
/// # Errors
/// [`NoPatch`].
pub fn elastic_pose(scene: &Scene, question: &Question, wheelset: &WheelsetOnTrack, stand: &Stand) -> Result<RollingPose, NoPatch> {
    let frame = AxleFrame::new(question.attitude.yaw, stand.roll);
    let axle = frame.axes.column(1).into_owned();
    let radius = |side: Side| -> Result<f64, NoPatch> {
        let lowered = stand.height[side.index()] - approach(scene, question, wheelset, stand, side)?;
        let centre = Vector3::new(wheelset.station, stand.y, lowered);
        let pair = wheelset.pair(side, &centre, &frame.axes);
        let solution = solve(&pair, scene.contact.material, 0.0, None, question.settings);
        let solution = solution.ok_or(NoPatch::TooHeavy { side, load: question.load })?;
        let wheel = &wheelset.wheels[side.index()];
        Ok(wheel.profile.at(side.sign() * (solution.centre - centre).dot(&axle) - wheel.half_spacing).value)
    };
    Ok(RollingPose { y: stand.y, roll: stand.roll, radii: [radius(Side::Left)?, radius(Side::Right)?] })
}

fn wheel_patch(
    scene: &Scene,
    question: &Question,
    wheelset: &WheelsetOnTrack,
    stand: &Stand,
    (side, approach, pitch_rate): (Side, f64, f64),
) -> Result<WheelPatch, NoPatch> {
    let frame = AxleFrame::new(question.attitude.yaw, stand.roll);
    let centre = Vector3::new(wheelset.station, question.y, stand.height[side.index()] - approach);
    let (wheel, pair) = (&wheelset.wheels[side.index()], wheelset.pair(side, &centre, &frame.axes));
    let (contact, speed) = (&scene.contact, scene.vehicle.speed);
    let axle = frame.axes.column(1).into_owned();
    let motion = Motion { velocity: Vector3::new(speed, 0.0, 0.0), rotation: axle * pitch_rate, speed };
    let solution = solve(&pair, contact.material, contact.friction, Some(&motion), question.settings);
    let solution = solution.ok_or(NoPatch::TooHeavy { side, load: question.load })?;
    let normal = solution.pressing.normalize();
    let forward = Vector3::x() - normal * normal.x;
    let axes = ContactAxes::new(normal, forward);
    let from = solution.centre - centre;
    let u = side.sign() * from.dot(&axle) - wheel.half_spacing;
    let creep = CreepForce {
        longitudinal: solution.creep_force.dot(&axes.e1),
        lateral: solution.creep_force.dot(&axes.e2),
        spin_moment: solution.creep_moment.dot(&normal),
    };
    Ok(WheelPatch {
        side,
        approach,
        wheel: u,
        rolling_radius: wheel.profile.at(u).value,
        angle: (-side.sign() * normal.y).atan2(normal.z),
        creep,
        ellipse: ellipse(scene, &pair, &stand.contacts[side.index()], question.load, &motion),
        solution,
    })
}

/// What the scene's laws make of the deepest place under the load.
fn ellipse(scene: &Scene, pair: &Pair, touch: &Touch, load: f64, motion: &Motion) -> Option<Ellipse> {
    let contact = &scene.contact;
    let start = SurfaceParameters { wheel: touch.wheel, angle: 0.0, lead: touch.lead, rail: touch.rail };
    let found = pair.locate(&start).ok()?;
    let force = load / found.normal.z;
    let law = (contact.normal)(contact.material);
    let (penetration, elastic) = law.contact_under(&found.shape(pair.wheel, pair.rail), force).ok()?;
    let axes = ContactAxes::new(found.normal, found.forward);
    let velocity = motion.velocity + motion.rotation.cross(&(found.wheel_point - pair.centre));
    let creepage = axes.slip(&velocity, &motion.rotation).creepage(motion.speed);
    let creep = (contact.creep)(contact.material);
    let creep = in_rolling_direction(motion.speed, creepage, |creepage| {
        creep.force(&RollingContact {
            patch: elastic.patch,
            normal_force: force,
            friction: contact.friction,
            creepage,
            speed: motion.speed.abs(),
        })
    });
    Some(Ellipse { penetration, normal_force: force, patch: elastic.patch, touch: *touch, creep })
}
