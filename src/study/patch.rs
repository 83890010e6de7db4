//! The contact patches of a wheelset at a lateral shift, yaw and load: half-space contact of the real surfaces, and beside it the ellipse that the
//! scene's laws make of the deepest place.
//!
//! The wheelset is set down as rigid (`contact_geometry`), then each wheel is lowered until its normal pressures carry the load; roll stays. It rolls
//! freely: at that pitch rate at which the creep forces of the real patches turn it neither faster nor slower (their whole moment about the axle, spin moments among it). The ellipses move alike.

use super::conicity::RollingPose;
use super::contact_geometry::{Attitude, NoStand, Stand, WheelsetOnTrack};
use super::ellipse_patch::{EllipsePatch, ellipse_patch};
use crate::contact::creepage::{ContactAxes, CreepForce};
use crate::contact::patch::{Motion, PatchSolution, Pressed, Settings, depth_under_load};
use crate::contact::profile_end::ProfileEnd;
use crate::geometry::Side;
use crate::geometry::surface::Wheel;
use crate::math::rotation::AxleFrame;
use crate::scene::spec::Scene;
use nalgebra::{Matrix3, Vector3};

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
    /// rad/s; `None`: rolling freely.
    pub pitch_rate: Option<f64>,
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
    pub ellipse: Option<EllipsePatch>,
    /// The end of a profile that it reaches.
    pub end: Option<ProfileEnd>,
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
    let (speed, friction) = (scene.vehicle.speed, scene.contact.friction);
    let mean = 0.5 * (stand.contacts[0].rolling_radius + stand.contacts[1].rolling_radius);
    let lower = |side| Lowered::new(scene, question, &wheelset, &stand, side, None);
    let lowered = [lower(Side::Left)?, lower(Side::Right)?];
    let axle = lowered[0].axle;
    let motion = |rate: f64| Motion { velocity: Vector3::new(speed, 0.0, 0.0), rotation: axle * rate, speed };
    let both = |rate: f64| [0, 1].map(|side| lowered[side].pressed.roll(&motion(rate), friction));
    // The moment about the axle that the creep forces brake it with, N m; it grows with the pitch rate. On a yawed wheel, which touches ahead of its axle, forces across have a part in it.
    let braking = |patches: &[PatchSolution; 2]| {
        let of = |side: usize| {
            let PatchSolution { centre, creep_force, creep_moment, .. } = &patches[side];
            -axle.dot(&((centre - lowered[side].centre).cross(creep_force) + creep_moment))
        };
        (of(0) + of(1)) * speed.signum()
    };
    let free = 1e-4 * friction * question.load * mean;
    let mut rate = question.pitch_rate.unwrap_or(speed / mean);
    let mut patches = both(rate);
    let (mut low, mut high) = (None::<(f64, f64)>, None::<(f64, f64)>);
    for _ in 0..ROUNDS {
        let turning = braking(&patches);
        if speed == 0.0 || question.pitch_rate.is_some() || turning.abs() <= free {
            break;
        }
        *(if turning > 0.0 { &mut high } else { &mut low }) = Some((rate, turning));
        rate = match (low, high) {
            (Some((a, at_a)), Some((b, at_b))) => a + (b - a) * (at_a / (at_a - at_b)).clamp(0.05, 0.95),
            (Some((a, _)), None) => a * (1.0 + STEP),
            (None, Some((b, _))) => b * (1.0 - STEP),
            (None, None) => break,
        };
        patches = both(rate);
    }
    let [left, right] = patches;
    let wheel =
        |lowered: &Lowered, solution: PatchSolution| lowered.patch(scene, question.load, &wheelset, &stand, &motion(rate), solution);
    Ok(Answer { pitch_rate: rate, wheels: [wheel(&lowered[0], left), wheel(&lowered[1], right)], stand })
}

/// Change of the pitch rate by which the free one is bracketed, and how often it is changed.
const STEP: f64 = 4e-4;
const ROUNDS: usize = 40;

/// A wheel that was set down as rigid and then lowered until it carries its load.
struct Lowered {
    side: Side,
    /// By how much, m.
    approach: f64,
    /// Of the wheelset, m, its frame and its axle.
    centre: Vector3<f64>,
    frame: Matrix3<f64>,
    axle: Vector3<f64>,
    pressed: Pressed,
    /// Of the mean normal.
    axes: ContactAxes,
    /// Coordinate u of the wheel at the load's centre, m, and the radius there, m.
    wheel: f64,
    rolling_radius: f64,
}

impl Lowered {
    /// `near`: an approach that may be about right, m.
    fn new(
        scene: &Scene,
        question: &Question,
        wheelset: &WheelsetOnTrack,
        stand: &Stand,
        side: Side,
        near: Option<f64>,
    ) -> Result<Lowered, NoPatch> {
        let frame = AxleFrame::new(question.attitude.yaw, stand.roll).axes;
        let axle = frame.column(1).into_owned();
        let high = Vector3::new(wheelset.station, stand.y, stand.height[side.index()]);
        let pair = wheelset.pair(side, &high, &frame);
        let found = depth_under_load(&pair, question.load, scene.contact.material, question.settings, near);
        let (approach, pressed) = found.ok_or(NoPatch::TooHeavy { side, load: question.load })?;
        let centre = high - Vector3::z() * approach;
        let patch = pressed.at_rest();
        let normal = patch.pressing.normalize();
        let profile = &wheelset.wheels[side.index()];
        let (wheel, rolling_radius) = foot(profile, &(patch.centre - centre), &normal, &axle);
        let axes = ContactAxes::new(normal, Vector3::x() - normal * normal.x);
        Ok(Lowered { side, approach, centre, frame, axle, pressed, axes, wheel, rolling_radius })
    }

    fn patch(
        &self,
        scene: &Scene,
        load: f64,
        wheelset: &WheelsetOnTrack,
        stand: &Stand,
        motion: &Motion,
        solution: PatchSolution,
    ) -> WheelPatch {
        let Lowered { side, approach, wheel, rolling_radius, axes, .. } = *self;
        let pair = wheelset.pair(side, &self.centre, &self.frame);
        let creep = CreepForce {
            longitudinal: solution.creep_force.dot(&axes.e1),
            lateral: solution.creep_force.dot(&axes.e2),
            spin_moment: solution.creep_moment.dot(&axes.normal),
        };
        let angle = (-side.sign() * axes.normal.y).atan2(axes.normal.z);
        let ellipse = ellipse_patch(scene, &pair, &stand.contacts[side.index()], Some(load), motion);
        let outward = self.axle * side.sign();
        let us = solution.cells.iter().map(|cell| outward.dot(&(cell.point - self.centre)) - pair.wheel.half_spacing);
        let on_wheel = us.fold([f64::INFINITY, f64::NEG_INFINITY], |[from, to], u| [from.min(u), to.max(u)]);
        let half_cell = 0.5 * solution.cell_size[1] * angle.cos().abs();
        let on_wheel = [on_wheel[0] - half_cell, on_wheel[1] + half_cell];
        let on_rail = self.pressed.on_rail();
        let end =
            on_rail.and_then(|on_rail| ProfileEnd::within((pair.wheel.profile.as_ref(), on_wheel), (pair.rail.profile.as_ref(), on_rail)));
        WheelPatch { side, approach, wheel, rolling_radius, angle, creep, ellipse, end, solution }
    }
}

/// Coordinate u [m] and radius [m] of the undeformed wheel below a place between the surfaces, `arm` from the wheelset's centre: what rolls is the wheel's own surface.
fn foot(wheel: &Wheel, arm: &Vector3<f64>, normal: &Vector3<f64>, axle: &Vector3<f64>) -> (f64, f64) {
    let (outward, mut below) = (axle * wheel.side.sign(), 0.0);
    let at = |below: f64| {
        let place = arm - normal * below;
        let axial = place.dot(&outward);
        let radial = place - outward * axial;
        (axial - wheel.half_spacing, radial.norm(), radial.normalize())
    };
    for _ in 0..FOOT_STEPS {
        let (u, rho, away) = at(below);
        let profile = wheel.profile.at(u);
        below -= (rho - profile.value) / (profile.d1 * normal.dot(&outward) - normal.dot(&away));
    }
    let u = at(below).0;
    (u, wheel.profile.at(u).value)
}

/// Newton's steps from half an overlap (0.1 mm) above the wheel's surface: 1e-12 m.
const FOOT_STEPS: usize = 5;

/// A wheelset on its rails that rolls on the centres of its loads instead of its deepest places; and by how much its wheels were lowered, m, which
/// may be a start (`near`) for a stand near by.
///
/// # Errors
/// [`NoPatch`].
pub fn elastic_pose(
    scene: &Scene,
    question: &Question,
    wheelset: &WheelsetOnTrack,
    stand: &Stand,
    near: Option<[f64; 2]>,
) -> Result<(RollingPose, [f64; 2]), NoPatch> {
    let lower = |side: Side| Lowered::new(scene, question, wheelset, stand, side, near.map(|near| near[side.index()]));
    let both = [lower(Side::Left)?, lower(Side::Right)?];
    let pose = RollingPose { y: stand.y, roll: stand.roll, radii: both.each_ref().map(|wheel| wheel.rolling_radius) };
    Ok((pose, both.map(|wheel| wheel.approach)))
}
