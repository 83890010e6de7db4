//! ECF-N: elastic contact found among nodes of the profiles (section 4.2 of the paper).
//!
//! The wheel has six degrees of freedom relative to the rail. The rail's section in which a wheel is searched follows the wheel's
//! centre by Eq. 29, a first-order state per wheel; in the section, penetrating pairs of nodes form batches, and
//! the deepest pair of each is loaded as in ECF-A (Eq. 28). See `contact::search::nodal` for the rules that the paper leaves
//! open and the slips that are corrected.
//!
//! The contact lies between nodes, where the overlap is deepest, so that places, radii and forces are continuous but for what the parabola
//! through three nodes leaves (see `contact::search::nodal`): on S1002 and 60E1 up to 120 kN N jumps by 2e-4 of itself with nodes every 0.1 mm
//! (0.4 mm: 0.5 %), on cones not to be seen (tests/hard/nodes.rs, tests/equiv/formulations.rs). Where two places of one batch are nearly as deep
//! they share the force as ECF-A's do (`points::share`): the paper has one contact for each batch, which would jump from one to the other,
//! and N with it from one stiffness to the other (10 mm aside, 2 % of 68 kN). The paper has two batches at most; a wheel on two places of its tread
//! that touches with its flange too has three, and up to four are loaded here (with two, Y fell by 4 kN under 90 kN when the flange came).
//!
//! State per contact: s of the section, m. Of what is remembered only the numbers of the contacts are taken, so that their tangential states stay
//! theirs.

use super::patch::{Places, press_wheel};
use super::{finish, points};
use crate::contact::search::algebraic::ContactLocation;
use crate::contact::search::nodal::{MOST, NodalContacts, NodalSearch, arc_rate};
use crate::formulation::loading::{Contact, WheelAt, external_wrench};
use crate::formulation::memory::WheelMemory;
use crate::formulation::rail_motion::Climb;
use crate::formulation::step::Step;
use crate::formulation::wheel_search::MOST_POINTS;
use crate::formulation::{
    AssemblyError, Build, ContactFailure, ContactReport, Evaluation, EvaluationError, Formulation, LEFT_FRICTION, Model, Parse, Parts,
    RIGHT_FRICTION, WHEELSET_INPUTS, Wheelset, Workspace, contact_index,
};
use crate::geometry::Side;
use crate::geometry::track::Rail;
use crate::mbs::body::BodyMotion;
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use nalgebra::Vector3;
use std::sync::Arc;

pub(in crate::formulation) const ENTRY: Entry<Parse> = Entry {
    name: "ECF-N",
    summary: "elastic contact, points found among nodes of the profiles (`contact.node_spacing`), up to four per wheel",
    reference: "paper, section 4.2, Eq. 29",
    parse,
};

/// Spacing of the nodes where the scene names none, m.
const SPACING: f64 = 1e-4;

/// Reads `contact.node_spacing`.
pub(in crate::formulation) fn parse_spacing(section: &Section) -> Result<f64, SettingsError> {
    let spacing = section.number_or("node_spacing", Dimension::Length, SPACING)?;
    if (1e-6..=5e-3).contains(&spacing) {
        return Ok(spacing);
    }
    Err(section.error("node_spacing", format!("found {spacing:?} m, expected 1 um to 5 mm")))
}

fn parse(section: &Section) -> Result<Build, SettingsError> {
    let spacing = parse_spacing(section)?;
    Ok(Arc::new(move |parts: &Parts| {
        let both = parts.wheelsets.iter().flat_map(|wheelset| Side::BOTH.map(|side| (wheelset.wheel(side), parts.track.rail(side))));
        let searches = both.map(|(wheel, rail)| NodalSearch::new(wheel, rail, spacing)).collect::<Result<_, _>>();
        Ok(Box::new(EcfN { spacing, searches: searches.map_err(AssemblyError::Nodes)? }))
    }))
}

#[derive(Debug)]
struct EcfN {
    /// m.
    spacing: f64,
    /// Node tables of all wheels in the order of their contacts.
    searches: Vec<NodalSearch>,
}

impl Formulation for EcfN {
    fn describe(&self) -> String {
        format!("elastic, up to four points per wheel among nodes every {} mm (contact.node_spacing)", 1e3 * self.spacing)
    }

    fn states_per_contact(&self) -> usize {
        1
    }

    fn points_per_wheel(&self) -> usize {
        MOST
    }

    fn start(&self, step: &mut Step) -> Result<(), EvaluationError> {
        step.move_bodies();
        for wheel in step.model.wheels() {
            let motion = &step.workspace.system.motions[wheel.wheelset.body];
            let point = self.searches[wheel.contact].centre_point(&motion.position, &motion.frame.axes);
            step.y[step.model.contact_states(wheel.contact)].fill(foot(step.model.track.rail(wheel.side), &point, motion.distance));
        }
        Ok(())
    }

    fn derivative(&self, model: &Model, workspace: &mut Workspace, at: Evaluation, dy: &mut [f64]) -> Result<(), EvaluationError> {
        let Evaluation { t, inputs, y, memory } = at;
        model.apply_forces(y, memory, &mut workspace.system);
        model.feel_rails(workspace, y);
        for (index, wheelset) in model.wheelsets.iter().enumerate() {
            let own = &inputs[index * WHEELSET_INPUTS..(index + 1) * WHEELSET_INPUTS];
            let applied = external_wrench(model, &workspace.system, wheelset.body, own);
            workspace.system.wrenches[wheelset.body] += applied;
            for (side, friction) in [(Side::Left, own[LEFT_FRICTION]), (Side::Right, own[RIGHT_FRICTION])] {
                let (contact, turning) = (contact_index(index, side), wheelset.turning[side.index()]);
                let motion = &workspace.system.motions[turning];
                let state = model.contact_states(contact).start;
                let section = model.track.rail(side).section(y[state]);
                let search = &self.searches[contact];
                let centre = search.centre_point(&motion.position, &motion.frame.axes);
                dy[state] = arc_rate(&section, &centre, &motion.attachment_velocity(&centre));
                // The section follows the wheelset along the track, whatever its rail does across.
                let moved = model.against_rail((&workspace.system, &workspace.rails), (inputs, y), (wheelset.body, turning), contact);
                let (motion, climb) = moved.as_ref().map_or((motion, Climb::default()), |moved| (&moved.motion, moved.climb));
                let found = search.search(&motion.position, &motion.frame.axes, (motion.distance, y[state]), &section, model.points);
                workspace.work.search_iterations += (found.evaluated + BETWEEN * found.looked_at) as u64;
                let fail = |cause| EvaluationError::new(t, wheelset, side, cause);
                if found.contacts[0].is_none() {
                    return Err(fail(ContactFailure::OffRail { y: model.beside(motion).0 }));
                }
                for place in found.contacts.iter().flatten() {
                    self.check_ends(model, wheelset, side, place, motion).map_err(fail)?;
                }
                let (located, shares) = numbered(&found, &mut memory.wheels[contact]);
                let wheel = WheelAt { model, wheelset, side, contact, motion, climb, friction, y };
                let wrench = &mut workspace.system.wrenches[turning];
                let reports = model.reports(contact, &mut workspace.contacts, &mut workspace.further_contacts);
                if let Some(rails) = &model.strips {
                    press_wheel(
                        &wheel,
                        &rails[side.index()],
                        (&located.each_ref().map(Option::as_ref), Places::Some),
                        (&mut workspace.strips[contact], &mut workspace.loaded),
                        wrench,
                        reports,
                    )
                    .map_err(fail)?;
                } else {
                    for (slot, report) in std::iter::once(reports.0).chain(reports.1).enumerate() {
                        *report = match &located[slot] {
                            Some(found) => Contact { wheel: &wheel, found, slot, share: shares[slot] }.elastic(wrench).map_err(fail)?,
                            None => ContactReport::default(),
                        };
                    }
                }
                model.finish_wheel(workspace, moved.as_ref(), (contact, wheelset.body, turning));
            }
        }
        finish(model, workspace, t, y, dy)
    }
}

/// Pairs of nodes that cost as much as a place on the profiles.
const BETWEEN: usize = 4;
/// A contact that has moved by more than this between two evaluations is another one, m.
const NEAR: f64 = 5e-3;

/// The contacts by their numbers, and the share of its Hertzian force that each carries. Each keeps its number; where two have merged the deeper one's is kept.
fn numbered(found: &NodalContacts, memory: &mut WheelMemory) -> ([Option<ContactLocation>; MOST_POINTS], [f64; MOST_POINTS]) {
    let depths = found.contacts.map(|place| place.map_or(f64::NEG_INFINITY, |place| place.penetration));
    let count = found.contacts.iter().flatten().count();
    let mut row = [1.0; MOST];
    points::share_row(&depths[..count], &found.saddles[..count - 1], &mut row[..count]);
    let mut number: [Option<usize>; MOST] = [None; MOST];
    let mut known: [usize; MOST_POINTS] = std::array::from_fn(|slot| slot);
    known.sort_unstable_by(|a, b| memory.places[*b].penetration.total_cmp(&memory.places[*a].penetration).then(a.cmp(b)));
    for slot in known.into_iter().filter(|slot| memory.places[*slot].followed) {
        let was = memory.places[slot].parameters.wheel;
        let moved = |i: &usize| found.contacts[*i].map_or(f64::INFINITY, |place| (place.parameters.wheel - was).abs());
        let free = (0..count).filter(|i| number[*i].is_none() && moved(i) < NEAR);
        if let Some(i) = free.min_by(|a, b| moved(a).total_cmp(&moved(b))) {
            number[i] = Some(slot);
        }
    }
    let taken = |number: &[Option<usize>], slot: usize| number.contains(&Some(slot));
    let mut deep: [usize; MOST] = std::array::from_fn(|i| i);
    deep.sort_unstable_by(|a, b| depths[*b].total_cmp(&depths[*a]).then(a.cmp(b)));
    for i in deep.into_iter().filter(|i| *i < count) {
        if number[i].is_none() {
            number[i] = (0..MOST_POINTS).find(|slot| !taken(&number, *slot));
        }
    }
    if !taken(&number, 0) {
        // There is always a first.
        number[deep[0]] = Some(0);
    }
    let (mut located, mut shares) = ([None; MOST_POINTS], [1.0; MOST_POINTS]);
    for (i, slot) in number.iter().enumerate().filter_map(|(i, slot)| Some((i, (*slot)?))) {
        (located[slot], shares[slot]) = (found.contacts[i], row[i]);
    }
    for (place, located) in memory.places.iter_mut().zip(&located) {
        let known = |found: &ContactLocation| (found.parameters, found.penetration);
        place.followed = located.is_some();
        (place.parameters, place.penetration) = located.as_ref().map(known).unwrap_or_default();
    }
    (located, shares)
}

impl EcfN {
    /// A loaded contact at the last node of a profile lies beyond it.
    fn check_ends(
        &self,
        model: &Model,
        wheelset: &Wheelset,
        side: Side,
        found: &ContactLocation,
        motion: &BodyMotion,
    ) -> Result<(), ContactFailure> {
        let places = [
            ("wheel", found.parameters.wheel, wheelset.wheel(side).profile.range()),
            ("rail", found.parameters.rail, model.track.rail(side).profile.range()),
        ];
        for (part, place, (first, last)) in places {
            if found.penetration > 0.0 && !(place - first > self.spacing && last - place > self.spacing) {
                return Err(ContactFailure::OffProfile { part, found: place, first, last, y: model.beside(motion).0 });
            }
        }
        Ok(())
    }
}

/// The distance s at which the plane normal to the rail's space curve goes through `point`, near that of the wheelset.
fn foot(rail: &Rail, point: &Vector3<f64>, distance: f64) -> f64 {
    let mut s = if rail.line().is_some() { distance } else { point.x };
    for _ in 0..20 {
        let section = rail.section(s);
        let gap = point - section.origin;
        let step = gap.dot(&section.d1) / (section.d1.norm_squared() - gap.dot(&section.d2));
        s += step;
        if step.abs() < 1e-14 {
            break;
        }
    }
    s
}
