//! Elastic contact of a wheel whose patch is made of strips (`contact.patch = "strips"`, [`crate::contact::strips`]).
//!
//! The places of least distance only tell where the surfaces may overlap, and when a wheel touches or parts (events). What is pressed is
//! found from the strips there; each part of it is a contact at its load's centre, with the rolling radius, the contact angle and the creepages of
//! that centre. Damping knows the share w_k of a part (`strips::mixed`) as it knows that of a place (`points`).

use super::super::loading::{Contact, WheelAt};
use super::super::patch_loads::{Carried, Loaded, creep_of, location};
use super::super::wheel_search::MOST_POINTS;
use super::super::{ContactFailure, ContactReport};
use super::half_spaces;
use super::tabled::TabledWheel;
use crate::contact::normal::damping::damped_force;
use crate::contact::search::algebraic::ContactLocation;
use crate::contact::strips::{Cells, MOST, Near, Part, Parts, Pressed, RailStrips, Scratch, press, press_anywhere};
use crate::mbs::body::Wrench;

/// Places of least distance by number of the contact.
pub(super) type Located<'a> = [Option<&'a ContactLocation>; MOST_POINTS];

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

/// Finds the patches of a wheel, loads them and adds their forces to the wheelset's wrench. Reports of
/// places that are not pressed tell where they are.
pub(super) fn press_wheel(
    wheel: &WheelAt,
    rail: &RailStrips,
    (located, known): (&Located, Places),
    (scratch, loaded): (&mut Scratch, &mut Loaded),
    wrench: &mut Wrench,
    (first, further): (&mut ContactReport, &mut [ContactReport]),
) -> Result<(), ContactFailure> {
    let near = located.iter().flatten().filter(|place| place.penetration > -ABOUT).map(|place| {
        let ContactLocation { parameters, penetration, .. } = **place;
        Near { eta: parameters.rail, lead: parameters.lead, overlap: penetration }
    });
    let points = 1 + further.len();
    let flanks = located.iter().flatten().map(|place| (place.rail_profile.d1, place.penetration));
    match wheel.model.half_spaces {
        Some(settings) => half_spaces::load(wheel, settings, loaded)?,
        None => WheelPatch::find(wheel, rail, near, known, flanks, scratch).load(loaded)?,
    }
    loaded.add_to(wrench, &wheel.motion.position);
    let reports = loaded.shown.reports();
    let numbers = numbers(reports, located, points);
    for (slot, shown) in std::iter::once(first).chain(further).enumerate() {
        let part = numbers.iter().zip(reports).find(|(number, _)| **number == Some(slot)).map(|(_, report)| report);
        match (part, located.get(slot).copied().flatten()) {
            (Some(report), place) => {
                *shown = *report;
                shown.iterations = place.map_or(0, |place| place.iterations);
            }
            (None, Some(found)) => {
                let place = Contact { wheel, found, slot, share: 0.0 };
                // Strips look no deeper than that.
                if reports.is_empty() && found.penetration > 0.0 {
                    place.check_depth()?;
                }
                *shown = place.report();
                shown.creepage = Default::default();
            }
            (None, None) => *shown = ContactReport::default(),
        }
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
        let distance = |slot: &usize| located[*slot].map_or(f64::INFINITY, |place| (place.parameters.rail - parameters.rail).abs());
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

    /// Loads all parts: fills `loaded`.
    ///
    /// # Errors
    /// [`ContactFailure`] where the wheel is too deep in the rail.
    pub fn load(&self, loaded: &mut Loaded) -> Result<(), ContactFailure> {
        loaded.weight = None;
        match self {
            WheelPatch::Pressed(on) => on.load(&mut loaded.shown),
            WheelPatch::Tabled(on) => on.load(&mut loaded.shown),
            WheelPatch::Both(on, table) => {
                loaded.weight = Some(table.looked.weight);
                on.load(&mut loaded.shown)?;
                table.load(&mut loaded.tabled)
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
    pub fn load(&self, carried: &mut Carried) -> Result<(), ContactFailure> {
        let shares = self.parts.shares(self.pressed);
        let mut alone: [Option<(Part, ContactLocation)>; MOST] = [None; MOST];
        // What friction is bounded by, and the sizes of the forces.
        let mut loads = [0.0; MOST];
        let Carried { count, all: loaded, creeps: creeping, forces, couples } = carried;
        *count = self.parts.len();
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
        for (k, report) in loaded[..*count].iter_mut().enumerate() {
            // Shares of a force that damping has taken away add up to nothing but for rounding.
            let more = (1.0 + damped[k] / loads[k]).max(0.0);
            forces[k] *= more;
            couples[k] *= more;
            loads[k] *= more;
            report.normal_force = loads[k];
        }
        *creeping = self.parts.mixed(&loads, &mut |first, last| {
            let (part, found) = of(first, last);
            let contact = self.at(&found, first, 1.0);
            let mut report = if first == last { loaded[first] } else { contact.report() };
            (report.patch, report.normal_force) = (part.patch, loads[first..=last].iter().sum());
            let uneven = self.wheel.uneven(Cells::Strips(self.parts.share(self.pressed, first, last)), &part, &report.axes);
            contact.creep_as(&mut report, |law, rolling| uneven.force(law, rolling));
            creep_of(&report, self.wheel.friction_at(&report))
        });
        Ok(())
    }
}

/// Rail coordinate of each part of a wheel's patch, m, and the highest pressure in it, Pa.
pub(in crate::formulation) fn highest_pressures(wheel: &WheelAt, rail: &RailStrips, scratch: &mut Scratch) -> Vec<(f64, f64)> {
    let pressed = press_anywhere(&wheel.pair(), rail, wheel.model.laws.material, scratch);
    let on = PressedWheel::new(wheel, rail, pressed);
    let of = |k: usize| (on.part(k, k).coordinates[1], on.parts.share(pressed, k, k).highest_pressure(wheel.model.laws.material));
    (0..on.parts.len()).map(of).collect()
}
