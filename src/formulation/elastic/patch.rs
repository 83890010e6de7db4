//! Elastic contact of a wheel whose patch is made of strips (`contact.patch = "strips"`, [`crate::contact::strips`]).
//!
//! The places of least distance only tell where the surfaces may overlap, and when a wheel touches or parts (events). What is pressed is
//! found from the strips there; each part of it is a contact at its load's centre, with the rolling radius, the contact angle and the creepages of
//! that centre. Damping knows the share w_k of a part (`strips::mixed`) as it knows that of a place (`points`).

use super::super::loading::{Contact, WheelAt};
use super::super::wheel_search::MOST_POINTS;
use super::super::{ContactFailure, ContactReport};
use crate::contact::normal::damping::damped_force;
use crate::contact::search::algebraic::{ContactLocation, SurfaceParameters};
use crate::contact::strips::{Creep, MOST, Near, Part, Parts, Pressed, RailStrips, Scratch, press, press_anywhere};
use crate::mbs::body::{BodyMotion, Wrench};
use nalgebra::Vector3;

/// Places of least distance by number of the contact.
pub(super) type Located = [Option<ContactLocation>; MOST_POINTS];

/// One wheel's strips and what they make.
pub(in crate::formulation) struct PressedWheel<'a> {
    wheel: &'a WheelAt<'a>,
    rail: &'a RailStrips,
    pub pressed: &'a [Pressed],
    pub parts: Parts,
}

/// What the parts of a wheel carry, in the order of the strips.
#[derive(Default)]
pub(in crate::formulation) struct Carried {
    pub reports: [ContactReport; MOST],
    creeps: [Creep; MOST],
    /// Sizes of the normal forces, N: the normal force of a report is the sum of pressures, which is more where a patch bends.
    forces: [f64; MOST],
}

/// Finds the patches of a wheel, loads them and adds their forces to the wheelset's wrench. Do the places tell of `all` that may overlap? Reports of
/// places that are not pressed tell where they are.
pub(super) fn press_wheel(
    wheel: &WheelAt,
    rail: &RailStrips,
    (located, all): (&Located, bool),
    scratch: &mut Scratch,
    wrench: &mut Wrench,
    (first, further): (&mut ContactReport, &mut [ContactReport]),
) -> Result<(), ContactFailure> {
    let (pair, material) = (wheel.pair(), wheel.model.laws.material);
    let near = located.iter().flatten().filter(|place| place.penetration > -ABOUT).map(|place| {
        let ContactLocation { parameters, penetration, .. } = *place;
        Near { eta: parameters.rail, lead: parameters.lead, overlap: penetration }
    });
    let pressed = match all {
        true => press(&pair, rail, near, material, scratch),
        false => press_anywhere(&pair, rail, material, scratch),
    };
    let points = 1 + further.len();
    let on = PressedWheel::new(wheel, rail, pressed);
    let mut carried = on.load()?;
    for (slot, report) in std::iter::once(&mut *first).chain(&mut *further).enumerate() {
        *report = match located.get(slot).and_then(Option::as_ref) {
            Some(found) => {
                let place = Contact { wheel, found, slot, share: 0.0 };
                // Strips look no deeper than that.
                if on.parts.is_empty() && found.penetration > 0.0 {
                    place.check_depth()?;
                }
                let mut report = place.report();
                report.creepage = Default::default();
                report
            }
            None => ContactReport::default(),
        };
    }
    let mut free = [true; MOST_POINTS];
    carried.add_to(wrench, &wheel.motion.position);
    for report in &mut carried.reports[..on.parts.len()] {
        // Each part has the number of the place that is nearest to it.
        let distance =
            |slot: &usize| located[*slot].as_ref().map_or(f64::INFINITY, |place| (place.parameters.rail - report.parameters.rail).abs());
        let Some(slot) = (0..points).filter(|slot| free[*slot]).min_by(|a, b| distance(a).total_cmp(&distance(b))) else { break };
        free[slot] = false;
        report.iterations = located[slot].as_ref().map_or(0, |place| place.iterations);
        *(if slot == 0 { &mut *first } else { &mut further[slot - 1] }) = *report;
    }
    Ok(())
}

/// Places that are further apart than this do not overlap beside it, m.
const ABOUT: f64 = 1e-6;

impl Carried {
    /// Completes the reports of the parts and adds their forces to the wheelset's wrench about its centre, which is there.
    pub fn add_to(&mut self, wrench: &mut Wrench, centre: &Vector3<f64>) {
        let carries = |all: &(&mut ContactReport, (&Creep, &f64))| all.0.normal_force > 0.0;
        let parts = self.reports.iter_mut().zip(self.creeps.iter().zip(&self.forces));
        for (report, (creep, force)) in parts.filter(carries) {
            report.force = report.axes.normal * *force + creep.force;
            let along = |axis: &Vector3<f64>| creep.force.dot(axis);
            (report.creep_force.longitudinal, report.creep_force.lateral) = (along(&report.axes.e1), along(&report.axes.e2));
            report.creep_force.spin_moment = creep.moment;
            report.friction_bound = Some(creep.bound);
            report.add_to(wrench, report.force, centre);
        }
    }
}

impl<'a> PressedWheel<'a> {
    pub fn new(wheel: &'a WheelAt<'a>, rail: &'a RailStrips, pressed: &'a [Pressed]) -> PressedWheel<'a> {
        PressedWheel { wheel, rail, pressed, parts: Parts::new(pressed, rail, wheel.model.points) }
    }

    /// What its strips from the first to the last part make as one.
    pub fn part(&self, first: usize, last: usize) -> Part {
        let wheel = self.wheel.wheelset.wheel(self.wheel.side);
        Part::new(self.parts.share(self.pressed, first, last), self.rail, wheel.profile.as_ref(), self.wheel.model.laws.material)
    }

    /// A contact of this wheel.
    fn at<'f>(&'f self, found: &'f ContactLocation, slot: usize, share: f64) -> Contact<'f> {
        Contact { wheel: self.wheel, found, slot, share }
    }

    /// Loads all parts.
    ///
    /// # Errors
    /// [`ContactFailure`] where the wheel is too deep in the rail.
    pub fn load(&self) -> Result<Carried, ContactFailure> {
        let shares = self.parts.shares(self.pressed);
        let mut alone: [Option<(Part, ContactLocation)>; MOST] = [None; MOST];
        // What friction is bounded by, and the sizes of the forces.
        let mut loads = [0.0; MOST];
        let Carried { reports: mut loaded, mut forces, .. } = Carried::default();
        for k in 0..self.parts.len() {
            let part = self.part(k, k);
            let found = location(&part, self.wheel.motion);
            let contact = self.at(&found, k, shares[k]);
            contact.check_depth()?;
            let report = &mut loaded[k];
            *report = contact.report();
            let whole = part.force / shares[k];
            report.stiffness = whole / (part.overlap * part.overlap.sqrt());
            (report.elastic_slope, report.patch) = (1.5 * whole / part.overlap, part.patch);
            (loads[k], forces[k], alone[k]) = (part.load, part.force, Some((part, found)));
        }
        let of = |first: usize, last: usize| match alone[first].filter(|_| first == last) {
            Some(known) => known,
            None => {
                let part = self.part(first, last);
                (part, location(&part, self.wheel.motion))
            }
        };
        let damping = self.wheel.model.laws.damping.as_ref();
        let damped = self.parts.mixed(&loads, &mut |first, last| {
            let (part, found) = of(first, last);
            let rate = if first == last { loaded[first].penetration_rate } else { self.at(&found, first, 1.0).report().penetration_rate };
            damped_force(damping, part.load, part.overlap, rate) - part.load
        });
        for (k, report) in loaded.iter_mut().enumerate().take(self.parts.len()) {
            // Shares of a force that damping has taken away add up to nothing but for rounding.
            let more = (1.0 + damped[k] / loads[k]).max(0.0);
            forces[k] *= more;
            loads[k] *= more;
            report.normal_force = loads[k];
        }
        let creeps = self.parts.mixed(&loads, &mut |first, last| {
            let (part, found) = of(first, last);
            let contact = self.at(&found, first, 1.0);
            let mut report = if first == last { loaded[first] } else { contact.report() };
            (report.patch, report.normal_force) = (part.patch, loads[first..=last].iter().sum());
            let uneven = self.wheel.uneven(self.parts.share(self.pressed, first, last), &part, &report.axes);
            contact.creep_as(&mut report, |law, rolling| uneven.force(law, rolling));
            creep_of(&report, self.wheel.friction_at(&report))
        });
        Ok(Carried { reports: loaded, creeps, forces })
    }
}

/// A part as a place where wheel and rail touch.
pub(in crate::formulation) fn location(part: &Part, motion: &BodyMotion) -> ContactLocation {
    let axes = &motion.frame.axes;
    let angle = part.arm.dot(&axes.column(0)).atan2(-part.arm.dot(&axes.column(2)));
    let [wheel, rail] = part.coordinates;
    ContactLocation {
        parameters: SurfaceParameters { wheel, angle, lead: part.lead, rail },
        wheel_point: motion.position + part.arm,
        normal: part.normal,
        forward: part.forward,
        penetration: part.overlap,
        wheel_profile: part.profiles[0],
        rail_profile: part.profiles[1],
        iterations: 0,
    }
}

fn creep_of(report: &ContactReport, friction: f64) -> Creep {
    let (axes, creep) = (&report.axes, &report.creep_force);
    Creep {
        force: axes.e1 * creep.longitudinal + axes.e2 * creep.lateral,
        moment: creep.spin_moment,
        bound: friction * report.normal_force,
    }
}

/// Rail coordinate of each part of a wheel's patch, m, and the highest pressure in it, Pa.
pub(in crate::formulation) fn highest_pressures(wheel: &WheelAt, rail: &RailStrips, scratch: &mut Scratch) -> Vec<(f64, f64)> {
    let pressed = press_anywhere(&wheel.pair(), rail, wheel.model.laws.material, scratch);
    let on = PressedWheel::new(wheel, rail, pressed);
    let of = |k: usize| (on.part(k, k).coordinates[1], on.parts.share(pressed, k, k).highest_pressure(wheel.model.laws.material));
    (0..on.parts.len()).map(of).collect()
}
