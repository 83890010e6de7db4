//! Elastic contacts of one wheel: all places where it presses on its rail.
//!
//! Profiles that can touch at one place only (strictly convex against each other) are served by one Newton iteration. For all
//! others [`GlobalSearch`] finds every least distance between wheel and rail, from the pose alone: tread, flange root, flange. Each
//! is a contact with its own normal and creep forces, which begin at zero penetration and are continuous in the pose:
//!
//! *Contacts that share a patch.* Two least distances may merge while both are pressed, the ridge between them being pressed
//! too (nearly conformal profiles). With penetrations d1, d2, ridge r = max(0, penetration at the ridge) and heights above it
//! p = d - r, contact 1 carries the share
//!
//! ```text
//! s1 = 1 - (r / d1) p2 / (p1 + p2)
//! ```
//!
//! of its Hertzian force (`share`). Apart (r = 0) it is 1; where contact 2 merges with the ridge (p2 = 0) it is 1 for contact 1
//! and 0 for contact 2, which disappears without a jump; while both melt together (r -> d) the shares add up to 1, so that a
//! patch is not counted twice. The rule is ours: between these limits it is an interpolation. Only where both merge at the very
//! same pose (p1 = p2 = 0, a symmetric pair) the limit depends on the way.
//!
//! *Guard.* A search says by how much the wheel may move until another place can come near (`budget`); until then only the
//! known places are followed, each by its own Newton iteration, and so are the ridges between them that are pressed or may soon be.
//! Places far away (a flange) cost nothing. Where wheel and rail are nearly conformal the budget is next to nothing; such a part of the
//! wheel has one of its own, and is looked at alone when that is used up. Where the rail bends sideways sharply there is none: flanges touch far ahead, and are
//! looked for there at each evaluation.
//!
//! *Identity.* A contact keeps its number while it exists; a new one takes the lowest free number. Forces do not depend on it.
//! The search forgets nothing and waits for nothing: no hysteresis.

mod record;
mod share;
mod stand;
mod touch;

use super::super::loading::{Contact, WheelAt, not_found};
use super::super::memory::{Allowance, WheelMemory};
use super::super::patch_loads::Loaded;
use super::super::prediction::{after, pose_of};
use super::super::wheel_search::{FAR, MOST_POINTS, WheelSearch};
use super::super::{ContactFailure, ContactReport, Model, Workspace};
use super::patch::{Located, Places as Known, press_wheel};
use crate::contact::search::algebraic::{ContactLocation, Pair, SurfaceParameters};
use crate::contact::search::global::{MOST, Minima, Ridge, is_least};
use crate::contact::strips::Scratch;
use crate::mbs::body::Wrench;
use share::{Saddle, Saddles, share_out};
pub(in super::super) use share::{share_row, share_slopes};
use stand::Stand;
pub(in super::super) use touch::{event_value, switch};

/// Places that are further apart are not followed, m.
const REACH: f64 = 5e-4;
/// Contacts that are nearer to each other on the wheel are the same one, m.
const APART: f64 = 1e-7;
/// A place where wheel and rail are near each other.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Place {
    location: ContactLocation,
    /// Of its Hertzian force that the contact carries, 0 to 1.
    share: f64,
}

/// By number of the contact.
pub(in super::super) type Places = [Option<Place>; MOST_POINTS];

/// Locates a wheel's elastic contacts, loads them and adds their forces to the wheelset's wrench.
#[inline]
pub(in super::super) fn elastic_wheel(
    wheel: &WheelAt,
    memory: &mut WheelMemory,
    patch: (&mut Scratch, &mut Loaded),
    wrench: &mut Wrench,
    (first, further): (&mut ContactReport, &mut [ContactReport]),
) -> Result<(), ContactFailure> {
    if let Some(linear) = wheel.model.linear.get(wheel.contact) {
        return linear.load(wheel, memory, wrench, first);
    }
    let rail = wheel.model.strips.as_ref().map(|rails| &rails[wheel.side.index()]);
    let Some(search) = &wheel.model.searches[wheel.contact] else {
        let pair = wheel.pair();
        // A warm start that has gone stale (a jump of state) must not fail where a cold start succeeds.
        let found = pair
            .locate(memory.start())
            .or_else(|_| pair.locate(&SurfaceParameters::default()))
            .map_err(|failure| not_found(wheel.model, wheel.motion, failure))?;
        memory.set_start(found.parameters);
        if let Some(rail) = rail {
            let mut located = Located::default();
            located[0] = Some(&found);
            return press_wheel(wheel, rail, (&located, Known::All), patch, wrench, (first, further));
        }
        *first = Contact { wheel, found: &found, slot: 0, share: 1.0 }.elastic(wrench)?;
        return Ok(());
    };
    let mut places = Places::default();
    search.places(wheel, None, memory, &mut places)?;
    if let Some(rail) = rail {
        let located = places.each_ref().map(|place| place.as_ref().map(|place| &place.location));
        press_wheel(wheel, rail, (&located, Known::All), patch, wrench, (&mut *first, &mut *further))?;
        return search.check_tip(wheel, first, further);
    }
    for (slot, (place, report)) in places.iter().zip(std::iter::once(first).chain(further)).enumerate() {
        *report = search.load(wheel, slot, place.as_ref(), wrench)?;
    }
    Ok(())
}

/// Loads the elastic contacts of a wheel whose tread contact, at `tread`, is a constraint.
#[inline]
pub(in super::super) fn elastic_beside(
    wheel: &WheelAt,
    tread: &ContactLocation,
    memory: &mut WheelMemory,
    wrench: &mut Wrench,
    further: &mut [ContactReport],
) -> Result<(), ContactFailure> {
    let Some(search) = &wheel.model.searches[wheel.contact] else { return Ok(()) };
    let mut places = Places::default();
    search.places(wheel, Some(tread), memory, &mut places)?;
    for (slot, (place, report)) in (1..).zip(places[1..].iter().zip(further)) {
        *report = search.load(wheel, slot, place.as_ref(), wrench)?;
    }
    Ok(())
}

/// The place of a wheel's deepest contact when nothing is known of it: where a constraint may begin. `None` where there is but
/// one place.
pub(in super::super) fn deepest(model: &Model, contact: usize, pair: &Pair) -> Option<SurfaceParameters> {
    let search = &model.searches[contact].as_ref()?.search;
    let mut minima = Minima::default();
    search.find(pair, FAR, &mut minima);
    minima.deepest().map(|minimum| search.polish(pair, minimum).location.parameters)
}

/// Can the wheel have other places than one?
#[inline]
pub(in super::super) fn searched(model: &Model, contact: usize) -> bool {
    model.searches[contact].is_some()
}

/// Has a constrained contact run beyond the end of its least distance, onto a ridge?
#[inline]
pub(in super::super) fn vanished(model: &Model, contact: usize, pair: &Pair, found: &ContactLocation) -> bool {
    model.searches[contact].is_some() && !is_least(pair, found)
}

/// Makes the most pressed contact of a wheel its first, with its tangential states in `y`; the reports are those of the present
/// state.
pub(in super::super) fn promote(model: &Model, workspace: &Workspace, contact: usize, y: &mut [f64], memory: &mut WheelMemory) {
    if model.searches[contact].is_none() {
        return;
    }
    let first = &workspace.contacts[contact];
    let others = workspace.reports(contact).enumerate().skip(1);
    if let Some((slot, report)) = others.max_by(|a, b| a.1.normal_force.total_cmp(&b.1.normal_force))
        && report.normal_force > first.normal_force
    {
        memory.promote(slot);
        memory.places[slot].pressed = first.normal_force > 0.0;
        for (a, b) in model.deflection(contact, 0).zip(model.deflection(contact, slot)) {
            y.swap(a, b);
        }
    }
}

/// What places are asked for.
struct Asked<'a> {
    wheel: &'a WheelAt<'a>,
    /// Where the wheel's constraint is, if it has one.
    tread: Option<&'a ContactLocation>,
    stand: Stand<'a>,
}

impl WheelSearch {
    /// A wheel that is pressed on the tip of its flange has derailed.
    fn check_tip(&self, wheel: &WheelAt, first: &ContactReport, further: &[ContactReport]) -> Result<(), ContactFailure> {
        let on_tip = |report: &&ContactReport| report.normal_force > 0.0 && report.parameters.wheel < self.tip;
        match std::iter::once(first).chain(further).find(on_tip) {
            Some(_) => Err(derailed(wheel, "the tip of the flange stands on the rail")),
            None => Ok(()),
        }
    }

    #[inline]
    fn load(&self, wheel: &WheelAt, slot: usize, place: Option<&Place>, wrench: &mut Wrench) -> Result<ContactReport, ContactFailure> {
        let Some(Place { location, share }) = place else { return Ok(ContactReport::default()) };
        if location.penetration > 0.0 && location.parameters.wheel < self.tip {
            return Err(derailed(wheel, "the tip of the flange stands on the rail"));
        }
        Contact { wheel, found: location, slot, share: *share }.elastic(wrench)
    }

    /// All places near the rail by number of the contact. With a `tread` that is a constraint, number 0 is that and stays empty.
    fn places(
        &self,
        wheel: &WheelAt,
        tread: Option<&ContactLocation>,
        memory: &mut WheelMemory,
        places: &mut Places,
    ) -> Result<(), ContactFailure> {
        let pair = wheel.pair();
        let pose = self.search.standing(&pair);
        let asked = Asked { wheel, tread, stand: Stand { pair, pose, radius: self.search.radius() } };
        if !wheel.model.search_always
            && !asked.stand.pair.is_on_sharp_bend()
            && memory.needs_no_search(&self.search, &pose)
            && self.as_watched(&asked.stand, memory)
            && self.follow(&asked, memory, places).is_some()
        {
            return Ok(());
        }
        *places = Places::default();
        self.search(&asked, memory, places)
    }

    /// Is what must be watched as it was?
    #[inline]
    fn as_watched(&self, stand: &Stand, memory: &mut WheelMemory) -> bool {
        let Some(watch) = memory.due_watch(&self.search, &stand.pose) else { return true };
        let holds = self.search.watched(&stand.pair, watch, memory.start());
        if let Some(budget) = holds {
            memory.watched = Allowance { budget, from: stand.pose };
        }
        holds.is_some()
    }

    /// The known places, each from where it was; `None` where one of them is not found so.
    #[inline]
    fn follow(&self, asked: &Asked, memory: &mut WheelMemory, places: &mut Places) -> Option<()> {
        let Asked { wheel, tread, stand } = asked;
        let (pair, points, moved) = (&stand.pair, wheel.model.points, memory.moved(&stand.pose));
        for slot in usize::from(tread.is_some())..points {
            let Some(start) = memory.expected(slot, &moved) else { continue };
            let location = pair.locate(&start).ok()?;
            // Newton knows nothing of least distances: it may run to a ridge or to the place of another contact.
            let u = location.parameters.wheel;
            let taken = |known: f64| (known - u).abs() < APART;
            let known = places[..slot].iter().flatten().map(|place| place.location.parameters.wheel);
            if !is_least(pair, &location) || known.chain(tread.map(|tread| tread.parameters.wheel)).any(taken) {
                return None;
            }
            memory.keep_place(stand, slot, &location);
            places[slot] = Some(Place { location, share: 1.0 });
        }
        let mut saddles = Saddles::default();
        for (i, saddle) in saddles.iter_mut().enumerate().take(points - 1) {
            let Some(ridge) = memory.ridge(i, points) else { continue };
            let (between, start) = (ridge.between, after(ridge.parameters, &ridge.prediction, &moved));
            let found = Saddle::locate(stand, &start, between, places)?;
            memory.keep_ridge(i, &found);
            *saddle = Some(found);
        }
        memory.located = pose_of(&stand.pose);
        share_out(places, &saddles);
        Some(())
    }

    /// A search from nothing.
    fn search(&self, asked: &Asked, memory: &mut WheelMemory, places: &mut Places) -> Result<(), ContactFailure> {
        let Asked { wheel, tread, stand } = asked;
        let pair = &stand.pair;
        let mut minima = Minima::default();
        if pair.is_on_sharp_bend() {
            self.search.find_along(pair, REACH, &mut minima);
        } else {
            self.search.find(pair, REACH, &mut minima);
        }
        if minima.is_empty() {
            // In flight: the nearest place is what is shown.
            self.search.find(pair, FAR, &mut minima);
        }
        if minima.is_empty() {
            return Err(derailed(wheel, "the wheel has left the rail"));
        }
        let count = minima.len();
        let mut chosen = [true; MOST];
        if let Some(tread) = tread {
            // The minimum that the constraint is at.
            let distance = |i: &usize| (minima[*i].parameters.wheel - tread.parameters.wheel).abs();
            if let Some(own) = (0..count).min_by(|a, b| distance(a).total_cmp(&distance(b))) {
                chosen[own] = false;
            }
        }
        let free = wheel.model.points - usize::from(tread.is_some());
        let mut left = [false; MOST];
        while (0..count).filter(|i| chosen[*i]).count() > free {
            let shallowest = (0..count).filter(|i| chosen[*i]).max_by(|a, b| minima[*a].distance.total_cmp(&minima[*b].distance));
            if let Some(shallowest) = shallowest {
                (chosen[shallowest], left[shallowest]) = (false, true);
            }
        }
        let numbers = memory.assign(&minima, &chosen[..count], tread.is_some(), wheel.model.points);
        for (i, minimum) in minima.iter().enumerate().filter(|(i, _)| chosen[*i]) {
            let Some(slot) = numbers[i] else { continue };
            let location = self.search.polish(pair, minimum).location;
            memory.keep_place(stand, slot, &location);
            places[slot] = Some(Place { location, share: 1.0 });
        }
        let steady = minima.apart.min(minima.clearance);
        // One that found no number matters when it touches, or when it becomes deeper than one that has a number.
        let deepest_left =
            left.iter().take(count).enumerate().filter(|(_, left)| **left).map(|(i, _)| minima[i].distance).fold(f64::INFINITY, f64::min);
        let shallowest = (0..count).filter(|i| chosen[*i]).map(|i| minima[i].distance).fold(f64::MIN, f64::max);
        let steady = steady.min(deepest_left.max(0.5 * (deepest_left - shallowest))).max(0.0);
        let (saddles, steady) = ridges(stand, &minima, &numbers, places, steady);
        share_out(places, &saddles);
        memory.renew(&stand.pose, steady, (&minima.watch, minima.steady), &saddles);
        Ok(())
    }
}

/// Ridges between contacts that are pressed, or may be while the wheel moves by less than `steady` [m], and how long they can be
/// followed, m. Where a place without a number lies between two contacts, it is the highest ridge that parts them.
fn ridges(stand: &Stand, minima: &Minima, numbers: &[Option<usize>; MOST], places: &Places, steady: f64) -> (Saddles, f64) {
    let (mut saddles, mut lasts, mut count) = (Saddles::default(), steady, 0);
    let mut before: Option<(usize, usize)> = None;
    for (i, slot) in numbers.iter().enumerate().filter_map(|(i, number)| Some((i, (*number)?))) {
        let Some((first, other)) = before.replace((i, slot)) else { continue };
        let apart = minima[first..i].iter().any(|minimum| minimum.ridge_to_next.is_none());
        let by_height = |a: &Ridge, b: &Ridge| a.distance.total_cmp(&b.distance);
        let Some(highest) = minima[first..i].iter().filter_map(|minimum| minimum.ridge_to_next).max_by(by_height) else { continue };
        if apart || highest.distance > steady {
            continue;
        }
        for ridge in minima[first..i].iter().filter_map(|minimum| minimum.ridge_to_next).filter(|ridge| *ridge != highest) {
            lasts = lasts.min(0.5 * (highest.distance - ridge.distance));
        }
        let between = [other, slot];
        let found = Saddle::locate(stand, &highest.parameters, between, places);
        if found.is_none() {
            lasts = 0.0;
        }
        saddles[count] = found.or(Some(Saddle {
            between,
            parameters: highest.parameters,
            penetration: -highest.distance,
            prediction: Default::default(),
        }));
        count += 1;
    }
    (saddles, lasts)
}

fn derailed(wheel: &WheelAt, how: &'static str) -> ContactFailure {
    let (y, z) = wheel.model.beside(wheel.motion);
    ContactFailure::off_the_rail(how, y, z)
}
