//! Elastic contact of a wheel whose patch is made of strips (`contact.patch = "strips"`, [`crate::contact::strips`]).
//!
//! The places of least distance only tell where the surfaces may overlap, and when a wheel touches or parts (events). What is pressed is
//! found from the strips there; each part of it is a contact at its load's centre, with the rolling radius, the contact angle and the creepages of
//! that centre. Damping knows the share w_k of a part (`strips::mixed`) as it knows that of a place (`points`).

use super::super::loading::{Contact, WheelAt};
use super::super::wheel_search::MOST_POINTS;
use super::super::{ContactFailure, ContactReport};
use super::carried::{Carried, creep_of, location};
use super::half_spaces;
use super::tabled::TabledWheel;
use crate::contact::normal::damping::damped_force;
use crate::contact::search::algebraic::ContactLocation;
use crate::contact::strips::{Cells, MOST, Near, Part, Parts, Pressed, RailStrips, Scratch, press, press_anywhere};
use crate::mbs::body::Wrench;
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

/// A wheel's patch.
#[allow(clippy::large_enum_variant)] // a box would allocate on the stepping path
pub(in crate::formulation) enum WheelPatch<'a> {
    Pressed(PressedWheel<'a>),
    Tabled(TabledWheel<'a>),
    /// On the border of the table: its weight is less than 1.
    Both(PressedWheel<'a>, TabledWheel<'a>),
}

/// What is known of where a wheel overlaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::formulation) enum Places {
    /// All that may.
    All,
    /// All; and the scratch may hold what was pressed in the same pose.
    AsPressed,
    /// Some.
    Some,
}

/// What a wheel's patch carries.
pub(in crate::formulation) struct Loaded {
    /// What is shown: of the strips where they are pressed, else of the table.
    pub shown: Carried,
    /// Of the table, with its weight, where both are asked.
    pub beside: Option<(f64, Carried)>,
}

/// Finds the patches of a wheel, loads them and adds their forces to the wheelset's wrench. Reports of
/// places that are not pressed tell where they are.
pub(super) fn press_wheel(
    wheel: &WheelAt,
    rail: &RailStrips,
    (located, known): (&Located, Places),
    scratch: &mut Scratch,
    wrench: &mut Wrench,
    (first, further): (&mut ContactReport, &mut [ContactReport]),
) -> Result<(), ContactFailure> {
    let near = located.iter().flatten().filter(|place| place.penetration > -ABOUT).map(|place| {
        let ContactLocation { parameters, penetration, .. } = *place;
        Near { eta: parameters.rail, lead: parameters.lead, overlap: penetration }
    });
    let points = 1 + further.len();
    let flanks = located.iter().flatten().map(|place| (place.rail_profile.d1, place.penetration));
    let mut loaded = match wheel.model.half_spaces {
        Some(settings) => Loaded { shown: half_spaces::load(wheel, settings)?, beside: None },
        None => WheelPatch::find(wheel, rail, near, known, flanks, scratch).load()?,
    };
    for (slot, report) in std::iter::once(&mut *first).chain(&mut *further).enumerate() {
        *report = match located.get(slot).and_then(Option::as_ref) {
            Some(found) => {
                let place = Contact { wheel, found, slot, share: 0.0 };
                // Strips look no deeper than that.
                if loaded.shown.count == 0 && found.penetration > 0.0 {
                    place.check_depth()?;
                }
                let mut report = place.report();
                report.creepage = Default::default();
                report
            }
            None => ContactReport::default(),
        };
    }
    loaded.add_to(wrench, &wheel.motion.position);
    let Carried { count, reports, .. } = &mut loaded.shown;
    let reports = &mut reports[..*count];
    let numbers = numbers(reports, located, points);
    for (report, slot) in reports.iter_mut().zip(numbers) {
        let Some(slot) = slot else { continue };
        report.iterations = located[slot].as_ref().map_or(0, |place| place.iterations);
        *(if slot == 0 { &mut *first } else { &mut further[slot - 1] }) = *report;
    }
    Ok(())
}

/// The number of each part, the most loaded first: the lowest of the places that lie in it, which keep theirs while they exist; else that of the nearest place
/// that is left. (The nearest one alone changed to and fro where two least distances lie in one patch.)
fn numbers(reports: &[ContactReport], located: &Located, points: usize) -> [Option<usize>; MOST] {
    let (mut numbers, mut free) = ([None; MOST], [true; MOST_POINTS]);
    for _ in reports {
        let left = (0..reports.len()).filter(|k| numbers[*k].is_none());
        let Some(k) = left.max_by(|a, b| reports[*a].normal_force.total_cmp(&reports[*b].normal_force)) else { break };
        let ContactReport { parameters, patch, .. } = &reports[k];
        let distance =
            |slot: &usize| located[*slot].as_ref().map_or(f64::INFINITY, |place| (place.parameters.rail - parameters.rail).abs());
        let untaken = (0..points).filter(|slot| free[*slot]);
        let within = untaken.clone().find(|slot| distance(slot) <= patch.b);
        let Some(slot) = within.or_else(|| untaken.min_by(|a, b| distance(a).total_cmp(&distance(b)))) else { break };
        (numbers[k], free[slot]) = (Some(slot), false);
    }
    numbers
}

/// Places that are further apart than this do not overlap beside it, m.
const ABOUT: f64 = 1e-6;

impl<'a> WheelPatch<'a> {
    /// From where a wheel may overlap, and slopes of the rail and penetrations of the places that are known.
    pub fn find(
        wheel: &'a WheelAt<'a>,
        rail: &'a RailStrips,
        near: impl Iterator<Item = Near>,
        looked: Places,
        flanks: impl Iterator<Item = (f64, f64)>,
        scratch: &'a mut Scratch,
    ) -> WheelPatch<'a> {
        let (pair, material) = (wheel.pair(), wheel.model.laws.material);
        let tabled = match TabledWheel::find(wheel, &pair, flanks) {
            Some(tabled) if tabled.looked.weight == 1.0 => return WheelPatch::Tabled(tabled),
            tabled => tabled,
        };
        let pressed = match looked {
            Places::AsPressed if scratch.is_of(&pair) => scratch.pressed(),
            Places::All if scratch.rails_stay && scratch.is_of(&pair) => scratch.pressed(),
            Places::AsPressed | Places::All => press(&pair, rail, near, material, scratch),
            Places::Some => press_anywhere(&pair, rail, material, scratch),
        };
        let pressed = PressedWheel::new(wheel, rail, pressed);
        match tabled {
            Some(tabled) => WheelPatch::Both(pressed, tabled),
            None => WheelPatch::Pressed(pressed),
        }
    }

    /// Loads all parts.
    ///
    /// # Errors
    /// [`ContactFailure`] where the wheel is too deep in the rail.
    pub fn load(&self) -> Result<Loaded, ContactFailure> {
        Ok(match self {
            WheelPatch::Pressed(on) => Loaded { shown: on.load()?, beside: None },
            WheelPatch::Tabled(on) => Loaded { shown: on.load()?, beside: None },
            WheelPatch::Both(on, table) => Loaded { shown: on.load()?, beside: Some((table.looked.weight, table.load()?)) },
        })
    }
}

impl Loaded {
    /// Completes the reports of the parts and adds their forces to the wheelset's wrench about its centre, which is there.
    pub fn add_to(&mut self, wrench: &mut Wrench, centre: &Vector3<f64>) {
        let (pressed, Some((weight, tabled))) = (&mut self.shown, &mut self.beside) else { return self.shown.add_to(wrench, centre) };
        let (mut of_strips, mut of_table) = (Wrench::default(), Wrench::default());
        pressed.add_to(&mut of_strips, centre);
        tabled.add_to(&mut of_table, centre);
        wrench.force += of_strips.force * (1.0 - *weight) + of_table.force * *weight;
        wrench.moment += of_strips.moment * (1.0 - *weight) + of_table.moment * *weight;
        // What is shown adds up to what acts.
        let load: f64 = pressed.reports.iter().map(|report| report.normal_force).sum();
        if load > 0.0 {
            let more = (of_table.force - of_strips.force) * *weight;
            let grown = 1.0 + *weight * (tabled.reports[0].normal_force / load - 1.0);
            for report in pressed.reports.iter_mut().filter(|report| report.normal_force > 0.0) {
                report.force += more * (report.normal_force / load);
                report.normal_force *= grown;
            }
            let acts = of_strips.moment * (1.0 - *weight) + of_table.moment * *weight;
            let mut shown = Wrench::default();
            pressed
                .reports
                .iter()
                .filter(|report| report.normal_force > 0.0)
                .for_each(|report| report.add_to(&mut shown, report.force, centre));
            if let Some(most) = pressed.reports.iter_mut().max_by(|a, b| a.normal_force.total_cmp(&b.normal_force)) {
                most.couple += acts - shown.moment;
            }
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
        let Carried { reports: mut loaded, mut forces, mut couples, .. } = Carried::default();
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
            (loads[k], forces[k], couples[k], alone[k]) = (part.load, part.force, part.couple, Some((part, found)));
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
            couples[k] *= more;
            loads[k] *= more;
            report.normal_force = loads[k];
        }
        let creeps = self.parts.mixed(&loads, &mut |first, last| {
            let (part, found) = of(first, last);
            let contact = self.at(&found, first, 1.0);
            let mut report = if first == last { loaded[first] } else { contact.report() };
            (report.patch, report.normal_force) = (part.patch, loads[first..=last].iter().sum());
            let uneven = self.wheel.uneven(Cells::Strips(self.parts.share(self.pressed, first, last)), &part, &report.axes);
            contact.creep_as(&mut report, |law, rolling| uneven.force(law, rolling));
            creep_of(&report, self.wheel.friction_at(&report))
        });
        Ok(Carried { count: self.parts.len(), reports: loaded, creeps, forces, couples })
    }
}

/// Rail coordinate of each part of a wheel's patch, m, and the highest pressure in it, Pa.
pub(in crate::formulation) fn highest_pressures(wheel: &WheelAt, rail: &RailStrips, scratch: &mut Scratch) -> Vec<(f64, f64)> {
    let pressed = press_anywhere(&wheel.pair(), rail, wheel.model.laws.material, scratch);
    let on = PressedWheel::new(wheel, rail, pressed);
    let of = |k: usize| (on.part(k, k).coordinates[1], on.parts.share(pressed, k, k).highest_pressure(wheel.model.laws.material));
    (0..on.parts.len()).map(of).collect()
}
