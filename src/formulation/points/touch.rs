//! Contacts beside the first as they begin and end: events of the integration.
//!
//! The force is continuous there (zero penetration, zero force), its second derivative is not: steps end at the event so that
//! no step's polynomial reaches across. What is pressed is always decided by the penetration; the marks only tell on which side
//! of the event the last step ended.

use super::super::events::{ContactChange, ContactEvent};
use super::super::rigid::wheels;
use super::super::{Model, Workspace};
use super::Record;

/// Metres become numbers of the size of normal forces, with which they are compared: a contact's stiffness, N/m.
const SCALE: f64 = 1e9;
/// A change of side counts from here, m: rounding must not make it come back at once. The force there is below 1e-3 N.
const SURE: f64 = 1e-11;

/// The least margin over all contacts beside the first; `None` without any.
pub(in super::super) fn margin(model: &Model, memory: &[f64]) -> Option<f64> {
    let own = model.formulation.memory_per_contact();
    let mut least = None;
    for (contact, _) in model.searches.iter().enumerate().filter(|(_, search)| search.is_some()) {
        let range = model.contact_memory(contact);
        for (_, depth, pressed) in Record::others(&memory[range.start + own..range.end], model.points) {
            let margin = SCALE * (if pressed { depth } else { -depth } + SURE);
            least = Some(least.map_or(margin, |least: f64| least.min(margin)));
        }
    }
    least
}

/// Notes which contacts have begun or ended; returns whether any has.
pub(in super::super) fn switch(model: &Model, workspace: &mut Workspace, t: f64, memory: &mut [f64]) -> bool {
    let own = model.formulation.memory_per_contact();
    let mut changed = false;
    for (contact, wheelset, side) in wheels(model) {
        if model.searches[contact].is_none() {
            continue;
        }
        let range = model.contact_memory(contact);
        let mut record = Record::new(&mut memory[range.start + own..range.end], model.points);
        for slot in 1..model.points {
            let Some((depth, pressed)) = record.other(slot) else { continue };
            if SCALE * (if pressed { depth } else { -depth } + SURE) >= 0.0 {
                continue;
            }
            record.set_pressed(slot, !pressed);
            changed = true;
            let change = if pressed { ContactChange::Parted { contact: slot + 1 } } else { ContactChange::Touched { contact: slot + 1 } };
            workspace.events.push(ContactEvent { time: t, wheelset: wheelset.name.clone(), side, change });
        }
    }
    changed
}
