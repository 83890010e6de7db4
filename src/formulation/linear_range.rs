//! Contact that is linear (`contact.patch = "linear"`): built for a model, and where in a run it does not hold; linear creep forces of other contact likewise.
//!
//! At the end of each step each wheel is laid beside what linear leaves out: how far it stands from the middle of its track against the way on which its rolling radius
//! changes as the strips' does (to [`PART`] of the change), and against the shift at which a flange carries; its creep force against mu N; and its load
//! against the one about which it is linear.

use super::assembly::rail_strips;
use super::elastic::linear::Middle;
use super::linear_contact::LinearContact;
use super::step::WheelRef;
use super::{AssemblyError, ContactReport, Model, Workspace, contact_index};
use crate::contact::patch::PatchLaw;
use crate::contact::strips::{Range, Section};
use crate::geometry::Side;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What the change of the rolling radius may be off, in parts of it.
pub const PART: f64 = 0.2;
/// Of mu N that a linear creep force may ask for: there it is 10 % too large (Vermeulen and Johnson: a linear force of tau mu N stands for
/// tau - tau^2/3 + tau^3/27).
const SATURATED: f64 = 0.3;
/// Loads in parts of the one about which contact is linear: the stiffness is then off by a fourth.
const LOADS: [f64; 2] = [0.5, 1.5];

/// What is left out.
const KINDS: usize = 4;

/// A wheel beyond a bound.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Beyond {
    kind: usize,
    contact: usize,
    /// s.
    since: f64,
    /// Worst value, in parts of the bound, and when, s.
    worst: (f64, f64),
    /// The bound, SI.
    bound: f64,
}

/// The bounds of a model's wheels, and which were passed.
#[derive(Clone, Debug, Default)]
pub(super) struct Ranges {
    /// By contact; none where creep forces alone are linear.
    ranges: Vec<Range>,
    contacts: usize,
    beyond: Vec<Beyond>,
}

impl Model {
    /// With linear contact where its scene asks for it.
    ///
    /// # Errors
    /// [`AssemblyError::NothingLinear`].
    pub(super) fn linear(mut self) -> Result<Model, AssemblyError> {
        if self.laws.patch != PatchLaw::Linear {
            return Ok(self);
        }
        let strips = rail_strips(&self.track, &self.wheelsets);
        let linear = self.alike_before(|model, wheel| {
            let found = LinearContact::new(model, wheel, &strips[wheel.side.index()]).map(Arc::new);
            found.ok_or_else(|| AssemblyError::NothingLinear {
                wheelset: wheel.wheelset.name.clone(),
                side: wheel.side.name(),
                load: wheel.wheelset.static_wheel_load,
            })
        })?;
        self.linear = linear;
        // Sides that are alike are so to the last digit, which what asks for symmetry wants.
        let rails = self.track.rail(Side::Left).profile.clone();
        if Arc::ptr_eq(&rails, &self.track.rail(Side::Right).profile) && strips[0] == strips[1] {
            for (index, wheelset) in self.wheelsets.iter().enumerate() {
                if Arc::ptr_eq(&wheelset.left.profile, &wheelset.right.profile) && wheelset.left.half_spacing == wheelset.right.half_spacing
                {
                    let [left, right] = Side::BOTH.map(|side| contact_index(index, side));
                    self.linear[right] = Arc::new(self.linear[left].mirrored());
                }
            }
        }
        Ok(self)
    }

    /// What linear contact is of a wheel, where it is.
    pub fn linear_contact(&self, contact: usize) -> Option<&LinearContact> {
        self.linear.get(contact).map(Arc::as_ref)
    }

    /// Something of each wheel, made once for all that are alike.
    fn alike_before<T: Clone, E>(&self, make: impl Fn(&Model, &WheelRef) -> Result<T, E>) -> Result<Vec<T>, E> {
        let mut made: Vec<(WheelRef, T)> = Vec::new();
        let alike = |a: &WheelRef, b: &WheelRef| {
            let [one, other] = [a, b].map(|wheel| wheel.wheelset.wheel(wheel.side));
            a.side == b.side
                && Arc::ptr_eq(&one.profile, &other.profile)
                && one.half_spacing == other.half_spacing
                && a.wheelset.static_wheel_load == b.wheelset.static_wheel_load
        };
        self.wheels()
            .map(|wheel| {
                if let Some((_, known)) = made.iter().find(|(other, _)| alike(other, &wheel)) {
                    return Ok(known.clone());
                }
                let new = make(self, &wheel)?;
                made.push((wheel, new.clone()));
                Ok(new)
            })
            .collect()
    }

    /// How far linear contact holds by wheel; empty where contact is not linear.
    pub fn linear_ranges(&self) -> Vec<Range> {
        if self.linear.is_empty() {
            return Vec::new();
        }
        let strips = rail_strips(&self.track, &self.wheelsets);
        let found = self.alike_before(|model, wheel| {
            let middle = Middle::new(model, wheel, &strips[wheel.side.index()]).ok_or(())?;
            Ok::<_, ()>(model.linear[wheel.contact].patch.range(&middle.of, PART))
        });
        found.unwrap_or_default()
    }
}

/// Creep force of a contact in parts of mu N (without the factor of a master's input).
fn saturation(model: &Model, workspace: &Workspace, wheel: &WheelRef, report: &ContactReport) -> f64 {
    let motion = &workspace.system.motions[wheel.wheelset.turning[wheel.side.index()]];
    let most = model.friction_at(wheel.side, motion, report) * report.normal_force;
    let used = report.creep_force.longitudinal.hypot(report.creep_force.lateral);
    if most > 0.0 { used / most } else { 0.0 }
}

/// How far a wheel stands toward its flange and from the middle of its track, and its load; each in parts of its bound, and the bound.
fn places_and_load(model: &Model, workspace: &Workspace, wheel: &WheelRef, range: &Range) -> [(f64, f64); 3] {
    let motion = &workspace.system.motions[wheel.wheelset.turning[wheel.side.index()]];
    let pair = wheel.pair(model, motion);
    let moved = model.linear[wheel.contact].patch.at(&pair, &Section::new(&pair), model.laws.material).moved.x;
    let way = usize::from(moved > 0.0);
    let load = workspace.contacts[wheel.contact].normal_force / wheel.wheelset.static_wheel_load;
    let off = if load > 1.0 { (load - 1.0) / (LOADS[1] - 1.0) } else { (1.0 - load) / (1.0 - LOADS[0]) };
    [
        range.flange[way].map_or((0.0, 0.0), |flange| (moved.abs() / flange, flange)),
        (moved.abs() / range.holds[way].max(f64::MIN_POSITIVE), range.holds[way]),
        (off, LOADS[usize::from(load > 1.0)]),
    ]
}

impl Ranges {
    /// Of a model; `None` where nothing of its contact is linear.
    pub fn of(model: &Model) -> Option<Ranges> {
        let ranges = model.linear_ranges();
        let any = !ranges.is_empty() || !model.laws.creep.is_bounded();
        any.then(|| Ranges { ranges, contacts: model.contacts(), beyond: Vec::new() })
    }

    /// Looks at the evaluation of a workspace at `t` [s].
    pub fn look(&mut self, model: &Model, workspace: &Workspace, t: f64) {
        for wheel in model.wheels() {
            let contact = wheel.contact;
            let saturated = workspace.reports(contact).map(|report| saturation(model, workspace, &wheel, report)).fold(0.0, f64::max);
            let mut bounds = [None, None, Some((saturated / SATURATED, SATURATED)), None];
            if let Some(range) = self.ranges.get(contact) {
                [bounds[0], bounds[1], bounds[3]] = places_and_load(model, workspace, &wheel, range).map(Some);
            }
            for (kind, (share, bound)) in bounds.into_iter().enumerate().filter_map(|(kind, found)| Some((kind, found?))) {
                if !(share > 1.0) {
                    continue;
                }
                match self.beyond.iter_mut().find(|known| known.kind == kind && known.contact == contact) {
                    Some(known) if share > known.worst.0 => known.worst = (share, t),
                    Some(_) => {}
                    None => self.beyond.push(Beyond { kind, contact, since: t, worst: (share, t), bound }),
                }
            }
        }
    }

    /// Forgets what came after `time` [s].
    pub fn take_back(&mut self, time: f64) {
        self.beyond.retain(|known| known.since <= time);
        for known in self.beyond.iter_mut().filter(|known| known.worst.1 > time) {
            known.worst = (1.0, known.since);
        }
    }

    /// Bounds that were passed.
    pub fn beyond(&self) -> &[Beyond] {
        &self.beyond
    }

    /// Goes on with what was found before. Returns false and changes nothing when that is not of these wheels.
    pub fn go_on(&mut self, beyond: Vec<Beyond>) -> bool {
        let known = beyond.iter().all(|one| one.kind < KINDS && one.contact < self.contacts);
        if known {
            self.beyond = beyond;
        }
        known
    }

    /// In words, the first wheel of each kind.
    pub fn notes(&self, named: impl Fn(usize) -> String) -> Vec<String> {
        let first = |kind: usize| {
            let of = || self.beyond.iter().filter(move |one| one.kind == kind);
            let first = of().min_by(|a, b| a.since.total_cmp(&b.since))?;
            let others = match of().count() {
                1 => String::new(),
                count => format!("; {count} wheels in all"),
            };
            Some((first, others))
        };
        let words = |kind: usize| -> Option<String> {
            let (Beyond { contact, since, worst: (share, when), bound, .. }, others) = first(kind)?;
            let (mm, wheel) = (1e3 * bound, named(*contact));
            let what = match kind {
                0 => format!(
                    "stands where its flange carries, {mm:.2} mm from the middle of its track, from {since:.4} s on: linear contact knows no flange, and lets it go on by {:.2} mm (at {when:.4} s)",
                    (share - 1.0) * mm
                ),
                1 => format!(
                    "is more than {mm:.2} mm from the middle of its track from {since:.4} s on, up to {:.2} mm (at {when:.4} s): there its rolling radius changes by {:.0} % more or less than linear contact says",
                    share * mm,
                    100.0 * PART
                ),
                2 => format!(
                    "asks for more than {:.0} % of mu N from {since:.4} s on, up to {:.0} % (at {when:.4} s): linear creep forces are not bounded, and more than 10 % too large",
                    100.0 * bound,
                    100.0 * bound * share
                ),
                _ => format!(
                    "carries {} {:.0} % of the load about which contact is linear, from {since:.4} s on (farthest at {when:.4} s): its stiffness and creep coefficients are those of another load",
                    if *bound > 1.0 { "more than" } else { "less than" },
                    100.0 * bound
                ),
            };
            let key = if self.ranges.is_empty() { "contact.creep.law = \"kalker_linear\"" } else { "contact.patch = \"linear\"" };
            Some(format!("{key}: {wheel} {what}{others}"))
        };
        (0..KINDS).filter_map(words).collect()
    }
}
