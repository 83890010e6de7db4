//! What all formulations share: loads from outside and the laws of contact at a point that was found.

use super::rail_motion::Climb;
use super::step::WheelRef;
use super::{ContactFailure, ContactReport, DRIVE_TORQUE, LEFT_FRICTION, Model, RIGHT_FRICTION, WHEELSET_INPUTS, Wheelset};
use crate::contact::Patch;
use crate::contact::creep::RollingContact;
use crate::contact::creepage::{ContactAxes, CreepForce, Creepage, in_rolling_direction};
use crate::contact::normal::damping::damped_force;
use crate::contact::normal::{ConformalContact, ContactShape, ElasticContact};
use crate::contact::search::algebraic::{ContactLocation, Pair};
use crate::contact::strips::{Cells, Part, Uneven};
use crate::contact::transient::{self, LoadedPatch, TransientContact};
use crate::geometry::Side;
use crate::math::newton::NewtonFailure;
use crate::mbs::body::{BodyMotion, Wrench};
use crate::mbs::system::SystemWorkspace;

/// Deeper than this, half-space elasticity has long ended: the initial position is wrong.
const DEEPEST: f64 = 5e-3;
/// Below this speed [m/s] steady creepage makes equations that are too stiff to be of use.
const SLOWEST: f64 = 0.05;

/// Torque about the axle and forces at the centre that a master applies.
#[inline]
pub(super) fn external_wrench(model: &Model, system: &SystemWorkspace, body: usize, inputs: &[f64]) -> Wrench {
    Wrench { force: model.input_force(system, body, inputs), moment: system.motions[body].axle() * inputs[DRIVE_TORQUE] }
}

impl Model {
    /// What a wheelset's own inputs load its body with, N and N m.
    pub fn input_wrench(&self, system: &SystemWorkspace, body: usize, inputs: &[f64; WHEELSET_INPUTS]) -> Wrench {
        external_wrench(self, system, body, inputs)
    }
}

/// One wheel at one instant.
#[derive(Clone, Copy)]
pub(super) struct WheelAt<'a> {
    pub model: &'a Model,
    pub wheelset: &'a Wheelset,
    pub side: Side,
    /// Index of the wheel's first contact.
    pub contact: usize,
    pub motion: &'a BodyMotion,
    /// What it meets of a bent rail (see `rail_motion`); nothing where rails do not move.
    pub climb: Climb,
    /// Factor of the friction coefficient.
    pub friction: f64,
    /// The whole state, of which the contact takes its tangential states.
    pub y: &'a [f64],
}

/// A contact whose place and motion are known.
pub(super) struct Contact<'a> {
    pub wheel: &'a WheelAt<'a>,
    pub found: &'a ContactLocation,
    /// Number of the contact on its wheel, from 0.
    pub slot: usize,
    /// Of its Hertzian force that it carries: 1, or less where it shares its patch with another (see `points`).
    pub share: f64,
}

impl WheelAt<'_> {
    /// Wheel and rail where they stand.
    #[inline]
    pub fn pair(&self) -> Pair<'_> {
        WheelRef { contact: self.contact, wheelset: self.wheelset, side: self.side }.pair(self.model, self.motion)
    }

    #[inline]
    pub fn speed(&self) -> f64 {
        self.wheelset.speed(self.motion)
    }

    /// mu at one of its contacts.
    #[inline]
    pub fn friction_at(&self, report: &ContactReport) -> f64 {
        // A polynomial input may pass below zero between communication points.
        self.model.friction_at(self.side, self.motion, report) * self.friction.max(0.0)
    }

    /// A part of its patch with what creep laws do not know of it.
    pub fn uneven<'p>(&self, cells: Cells<'p>, part: &'p Part, axes: &ContactAxes) -> Uneven<'p> {
        let BodyMotion { velocity, rotation, .. } = *self.motion;
        let velocity = velocity - self.climb.lead(&axes.normal);
        Uneven { cells, part, axes: axes.rolling(self.speed()), velocity, rotation, material: self.model.laws.material }
    }
}

impl Contact<'_> {
    /// Where a contact is that was reported.
    pub fn again(report: &ContactReport) -> ContactLocation {
        let ContactReport { parameters, wheel_point, axes, penetration, profiles: [wheel_profile, rail_profile], iterations, .. } = *report;
        let (normal, forward) = (axes.normal, axes.e1);
        ContactLocation { parameters, wheel_point, normal, forward, penetration, wheel_profile, rail_profile, iterations }
    }

    /// What the normal law may ask of the surfaces.
    #[inline]
    fn shape(&self) -> ContactShape<'_> {
        self.found.shape(self.wheel.wheelset.wheel(self.wheel.side), self.wheel.model.track.rail(self.wheel.side))
    }

    /// Place and kinematics, no load.
    #[inline]
    pub fn report(&self) -> ContactReport {
        let found = self.found;
        let axes = ContactAxes::new(found.normal, found.forward);
        let motion = self.wheel.motion;
        let velocity = motion.material_velocity(&found.wheel_point);
        let slip = axes.slip(&(velocity - self.wheel.climb.lead(&found.normal)), &motion.rotation);
        ContactReport {
            parameters: found.parameters,
            penetration: found.penetration,
            penetration_rate: -(velocity - self.wheel.climb.velocity).dot(&found.normal),
            axes,
            wheel_point: found.wheel_point,
            profiles: [found.wheel_profile, found.rail_profile],
            share: self.share,
            iterations: found.iterations,
            slip,
            creepage: if self.transient().is_some() { Creepage::default() } else { slip.creepage(self.wheel.speed()) },
            ..ContactReport::default()
        }
    }

    /// Elastic contact (Eq. 28): the penetration gives the normal force; adds the contact's wrench. Without penetration there
    /// is no force and no creepage.
    #[inline]
    pub fn elastic(&self, wrench: &mut Wrench) -> Result<ContactReport, ContactFailure> {
        let (mut report, found, model) = (self.report(), self.found, self.wheel.model);
        if !(found.penetration > 0.0 && self.share > 0.0) {
            report.creepage = Default::default();
            return Ok(report);
        }
        self.check_depth()?;
        let mut elastic = model.laws.normal.contact(&self.shape(), found.penetration)?;
        // A place that carries a share of a patch's force covers that share of its area.
        let narrower = self.share.sqrt();
        elastic.patch = Patch { a: narrower * elastic.patch.a, b: narrower * elastic.patch.b };
        self.load_whole(&mut report, &elastic);
        report.add_to(wrench, report.force, &self.wheel.motion.position);
        Ok(report)
    }

    /// Checks a contact that is pressed: its place and how deep it is.
    #[inline]
    pub fn check_depth(&self) -> Result<(), ContactFailure> {
        self.check_place()?;
        self.check_overlap()
    }

    /// Checks the overlap alone.
    #[inline]
    pub fn check_overlap(&self) -> Result<(), ContactFailure> {
        let penetration = self.found.penetration;
        if penetration > DEEPEST {
            return Err(ContactFailure::TooDeep { penetration, z: self.wheel.model.beside(self.wheel.motion).1 });
        }
        Ok(())
    }

    /// Normal force with damping and creep force in a report: of the share of this contact in an elastic force that is given whole, on the patch that
    /// it covers.
    #[inline]
    pub fn load_whole(&self, report: &mut ContactReport, elastic: &ElasticContact) {
        (report.stiffness, report.elastic_slope, report.patch) = (elastic.stiffness, elastic.slope, elastic.patch);
        let damping = self.wheel.model.laws.damping.as_ref();
        report.normal_force = self.share * damped_force(damping, elastic.force, self.found.penetration, report.penetration_rate);
        self.creep(report);
    }

    /// Penetration [m] under which the elastic force is `normal_force` > 0 [N].
    pub fn approach_under(&self, normal_force: f64) -> Result<f64, ConformalContact> {
        self.wheel.model.laws.normal.contact_under(&self.shape(), normal_force).map(|(approach, _)| approach)
    }

    /// Contact of rigid surfaces that press as elastic ones would under a penetration of `approach` [m]: fills patch and forces of the
    /// report; returns N and the wrench of the creep forces on the wheelset. (N itself belongs to the constraint.)
    #[inline]
    pub fn squeezed(&self, report: &mut ContactReport, approach: f64) -> Result<(f64, Wrench), ConformalContact> {
        let law = &self.wheel.model.laws.normal;
        let elastic = if approach > 0.0 { law.contact(&self.shape(), approach)? } else { ElasticContact::default() };
        Ok((elastic.force, self.pressed(report, &elastic)))
    }

    /// The same with patch and force given.
    #[inline]
    pub fn pressed(&self, report: &mut ContactReport, elastic: &ElasticContact) -> Wrench {
        (report.stiffness, report.patch, report.normal_force) = (elastic.stiffness, elastic.patch, elastic.force);
        report.elastic_slope = elastic.slope;
        self.creep(report);
        let mut wrench = Wrench::default();
        report.add_to(&mut wrench, report.force - report.axes.normal * elastic.force, &self.wheel.motion.position);
        wrench
    }

    /// d ln T / d ln N at constant creepages for a patch that grows like N^(1/3) and creep forces that saturate after Vermeulen and
    /// Johnson, `T = mu N (1 - x^3)`: 1 - x^2 / (1 + x + x^2), from 2/3 without to 1 with full sliding.
    #[inline]
    pub fn growth(&self, report: &ContactReport) -> f64 {
        let bound = self.wheel.friction_at(report) * report.normal_force;
        let used = report.creep_force.longitudinal.hypot(report.creep_force.lateral) / bound;
        // Without friction there is no force to grow.
        let x = if used < 1.0 { (1.0 - used).cbrt() } else { 0.0 };
        1.0 - x * x / (1.0 + x + x * x)
    }

    /// The transient model where it has a part in the forces.
    #[inline]
    fn transient(&self) -> Option<&TransientContact> {
        self.wheel.model.laws.transient.as_ref().filter(|transient| !transient.is_idle(self.wheel.speed()))
    }

    /// Creep forces from patch, normal force and creepage, and the total force.
    #[inline]
    pub fn creep(&self, report: &mut ContactReport) {
        self.creep_as(report, |law, _| *law);
    }

    /// The same with what `of` makes of the law's force for a contact that rolls ahead; not of transient contact.
    #[inline]
    pub fn creep_as(&self, report: &mut ContactReport, of: impl FnOnce(&CreepForce, &RollingContact) -> CreepForce) {
        let laws = &self.wheel.model.laws;
        let friction = self.wheel.friction_at(report);
        let (patch, normal_force, speed) = (report.patch, report.normal_force.max(0.0), self.wheel.speed());
        if let Some(transient) = self.transient() {
            let mut state = [0.0; transient::STATES];
            state.copy_from_slice(&self.wheel.y[self.wheel.model.deflection(self.wheel.contact, self.slot)]);
            let loaded = LoadedPatch { patch, normal_force, friction };
            let slip = report.slip.rolling(speed);
            let found = transient.evaluate(laws.creep.as_ref(), &loaded, &slip, &state);
            (report.creep_force, report.deflection_rates) = (found.force, found.rates);
            // Of the wheel's real slip: what the law is given ends at its bound.
            report.creepage = transient.creepage(&slip);
        } else {
            report.creep_force = in_rolling_direction(speed, report.creepage, |creepage| {
                let rolling = RollingContact { patch, normal_force, friction, creepage, speed: speed.abs() };
                of(&laws.creep.force(&rolling), &rolling)
            });
        }
        let (axes, creep) = (&report.axes, &report.creep_force);
        report.force = axes.normal * report.normal_force + axes.e1 * creep.longitudinal + axes.e2 * creep.lateral;
    }

    /// A loaded contact must lie on both profiles, and roll fast enough for the laws of creepage.
    #[inline]
    pub fn check_place(&self) -> Result<(), ContactFailure> {
        self.check_speed()?;
        let WheelAt { model, wheelset, side, motion, .. } = *self.wheel;
        let (wheel, rail) = (wheelset.wheel(side), model.track.rail(side));
        let places =
            [("wheel", self.found.parameters.wheel, wheel.profile.range()), ("rail", self.found.parameters.rail, rail.profile.range())];
        for (part, found, (first, last)) in places {
            if !(found >= first && found <= last) {
                return Err(ContactFailure::OffProfile { part, found, first, last, y: model.beside(motion).0 });
            }
        }
        Ok(())
    }

    /// A loaded contact must roll fast enough for the laws of creepage.
    #[inline]
    pub fn check_speed(&self) -> Result<(), ContactFailure> {
        let speed = self.wheel.speed();
        if !(speed.abs() >= SLOWEST) && self.wheel.model.laws.transient.is_none() {
            return Err(ContactFailure::TooSlow { speed });
        }
        Ok(())
    }
}

/// Factor of a wheel's friction coefficient.
pub(super) fn friction(inputs: &[f64], contact: usize, side: Side) -> f64 {
    let inputs = &inputs[contact / 2 * WHEELSET_INPUTS..];
    if side == Side::Left { inputs[LEFT_FRICTION] } else { inputs[RIGHT_FRICTION] }
}

pub(super) fn not_found(model: &Model, motion: &BodyMotion, failure: NewtonFailure) -> ContactFailure {
    ContactFailure::NotFound { iterations: failure.iterations, residual: failure.residual, y: model.beside(motion).0 }
}
