//! A wheel whose contact is linear (`contact.patch = "linear"`): the first order of the strips' patch ([`LinearPatch`]), and of its creep force ([`LinearContact`]).
//!
//! *Normal force* as in [`LinearPatch`], damping as everywhere. A wheel carries nothing where it is off its rail, and there is no friction bound: what a run makes of that is
//! told by [`super::super::linear_range`].

use super::super::linear_contact::{LinearContact, LinearCreep, vector};
use super::super::loading::{Contact, WheelAt};
use super::super::memory::WheelMemory;
use super::super::patch_loads::location;
use super::super::{ContactFailure, ContactReport, Model};
use crate::contact::creep::RollingContact;
use crate::contact::creepage::{ContactAxes, CreepForce, Creepage, in_rolling_direction};
use crate::contact::normal::damping::damped_force;
use crate::contact::search::algebraic::Pair;
use crate::contact::strips::{Cells, LinearPatch, Looked, RailStrips, Section, Standing, ToTabulate, Uneven};
use crate::formulation::step::WheelRef;
use crate::geometry::track::Rail;
use crate::mbs::body::{BodyMotion, Wrench};
use nalgebra::{Matrix3, Vector3};

/// Depths beside which a wheel that stands in the middle is looked for once more.
const AGAIN: usize = 3;

/// Where a wheel stands in the middle of the track under its load: for its patch, and its motion there at 1 m/s.
pub(in crate::formulation) struct Middle {
    pub of: ToTabulate,
    rail: Rail,
    centre: Vector3<f64>,
}

impl Middle {
    /// `None` where no place carries it.
    pub fn new(model: &Model, wheel: &WheelRef, strips: &RailStrips) -> Option<Middle> {
        let (side, rail) = (wheel.side, model.track.rail(wheel.side).undisturbed());
        let profile = wheel.wheelset.wheel(side).profile.clone();
        let of = ToTabulate { strips: strips.clone(), rail: rail.profile.clone(), wheel: profile.clone(), middle: (0.0, 0.0) };
        let mut middle = Middle { of, rail, centre: Vector3::z() * profile.at(0.0).value };
        for _ in 0..AGAIN {
            let motion = middle.motion(1.0);
            let pair = middle.pair(wheel, &motion);
            let standing = Standing::new(&pair, &Section::new(&pair));
            middle.of.middle = (standing.across, standing.lean);
            let height = LinearPatch::height(&middle.of, wheel.wheelset.static_wheel_load, model.laws.material)?;
            middle.centre.z += (height - standing.high) / standing.up.z;
        }
        Some(middle)
    }

    /// Rolling at 1 m/s on this radius, m.
    fn motion(&self, radius: f64) -> BodyMotion {
        let (place, rates) = ([0.0, 0.0, self.centre.z, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0, 0.0, radius.recip()]);
        BodyMotion::new(&place, &rates)
    }

    fn pair<'a>(&'a self, wheel: &'a WheelRef, motion: &'a BodyMotion) -> Pair<'a> {
        Pair {
            wheel: wheel.wheelset.wheel(wheel.side),
            rail: &self.rail,
            centre: &motion.position,
            axes: &motion.frame.axes,
            distance: 0.0,
        }
    }
}

impl LinearContact {
    /// Of a wheel of a model; `None` where nothing but a flange carries it in the middle of the track.
    pub(in crate::formulation) fn new(model: &Model, wheel: &WheelRef, strips: &RailStrips) -> Option<LinearContact> {
        let middle = Middle::new(model, wheel, strips)?;
        let patch = LinearPatch::new(&middle.of, wheel.wheelset.static_wheel_load, model.laws.material)?;
        let motion = middle.motion(patch.radius().0);
        let pair = middle.pair(wheel, &motion);
        let (spread, apart) = patch.spread(&pair, &Section::new(&pair), model.laws.material);
        let (here, slopes, creepage) = rolling(model, &motion, &spread[0]);
        let [inward, outward, lower, higher] = [1, 2, 3, 4].map(|k| force(model, &motion, &spread[k], &creepage));
        let creep = LinearCreep {
            normal_force: spread[0].part.load,
            slopes,
            rest: here - slopes * vector(&creepage),
            by_place: [(outward - inward) / apart[0], (higher - lower) / apart[1]],
        };
        Some(LinearContact { patch, creep })
    }

    /// Loads a wheel and adds its force to the wheelset's wrench.
    pub(in crate::formulation) fn load(
        &self,
        wheel: &WheelAt,
        memory: &mut WheelMemory,
        wrench: &mut Wrench,
        report: &mut ContactReport,
    ) -> Result<(), ContactFailure> {
        *report = self.loaded(wheel)?;
        memory.set_start(report.parameters);
        report.add_to(wrench, report.force, &wheel.motion.position);
        Ok(())
    }

    /// The contact under load.
    ///
    /// # Errors
    /// [`ContactFailure`] where the wheel is not on its rail, or does not roll.
    pub(in crate::formulation) fn loaded(&self, wheel: &WheelAt) -> Result<ContactReport, ContactFailure> {
        let laws = &wheel.model.laws;
        let pair = wheel.pair();
        let at = self.patch.at(&pair, &Section::new(&pair), laws.material);
        let found = location(&at.part, wheel.motion);
        let contact = Contact { wheel, found: &found, slot: 0, share: 1.0 };
        let mut report = contact.report();
        if !(at.pressed > 0.0) {
            report.creepage = Creepage::default();
            return Ok(report);
        }
        // Its place goes on beyond the profiles' ends, which the run tells long before.
        contact.check_speed()?;
        contact.check_overlap()?;
        let part = &at.part;
        report.stiffness = part.force / (part.overlap * part.overlap.sqrt());
        (report.elastic_slope, report.patch) = (1.5 * part.force / part.overlap, part.patch);
        report.normal_force = damped_force(laws.damping.as_ref(), part.force, part.overlap, report.penetration_rate);
        let speed = wheel.speed();
        report.creep_force = in_rolling_direction(speed, report.creepage, |creepage| {
            self.creep.force(&creepage, if speed < 0.0 { -1.0 } else { 1.0 }, report.normal_force, &at.moved)
        });
        let ContactAxes { normal, e1, e2 } = report.axes;
        report.force = normal * report.normal_force + e1 * report.creep_force.longitudinal + e2 * report.creep_force.lateral;
        Ok(report)
    }
}

/// A patch that rolls at 1 m/s.
fn contact<'a>(model: &Model, motion: &BodyMotion, looked: &'a Looked) -> (RollingContact, Uneven<'a>) {
    let part = &looked.part;
    let axes = ContactAxes::new(part.normal, part.forward);
    let slip = axes.slip(&(motion.velocity + motion.rotation.cross(&part.arm)), &motion.rotation);
    let rolling = RollingContact {
        patch: part.patch,
        normal_force: part.load,
        friction: model.laws.friction,
        creepage: slip.creepage(1.0),
        speed: 1.0,
    };
    let BodyMotion { velocity, rotation, .. } = *motion;
    (rolling, Uneven { cells: Cells::Fifths(&looked.fifths), part, axes, velocity, rotation, material: model.laws.material })
}

fn components(force: &CreepForce) -> Vector3<f64> {
    Vector3::new(force.longitudinal, force.lateral, force.spin_moment)
}

/// Its force, slopes, and creepages.
fn rolling(model: &Model, motion: &BodyMotion, looked: &Looked) -> (Vector3<f64>, Matrix3<f64>, Creepage) {
    let (rolling, uneven) = contact(model, motion, looked);
    let law = model.laws.creep.force(&rolling);
    let slopes = uneven.slopes(&law, &model.laws.creep.slopes(&rolling, &law), &rolling);
    (components(&uneven.force(&law, &rolling)), slopes.by_creepage, rolling.creepage)
}

/// Its force at given creepages.
fn force(model: &Model, motion: &BodyMotion, looked: &Looked, creepage: &Creepage) -> Vector3<f64> {
    let (rolling, uneven) = contact(model, motion, looked);
    let rolling = RollingContact { creepage: *creepage, ..rolling };
    components(&uneven.force(&model.laws.creep.force(&rolling), &rolling))
}
