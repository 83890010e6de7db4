//! Contacts beside the first as they begin and end: events of the integration.
//!
//! The force is continuous there (zero penetration, zero force), its second derivative is not: steps end at the event so that
//! no step's polynomial reaches across. What is pressed is always decided by the penetration; the marks only tell on which side
//! of the event the last step ended.

use crate::formulation::events::ContactChange;
use crate::formulation::memory::PlaceMemory;
use crate::formulation::step::{Step, WheelRef};

/// A change of side counts from here, m: rounding must not make it come back at once. The force there is below 1e-3 N.
const SURE: f64 = 1e-11;

/// How far a contact beside the first is from its next event, m; infinity where it is not followed.
#[inline]
pub(in crate::formulation) fn event_value(place: &PlaceMemory) -> f64 {
    match place {
        PlaceMemory { followed: false, .. } => f64::INFINITY,
        PlaceMemory { pressed: true, penetration, .. } => penetration + SURE,
        PlaceMemory { penetration, .. } => SURE - penetration,
    }
}

/// A contact has begun or ended.
pub(in crate::formulation) fn switch(step: &mut Step, wheel: WheelRef, slot: usize) {
    let place = &mut step.memory.wheels[wheel.contact].places[slot];
    let contact = slot + 1;
    let change = if place.pressed { ContactChange::Parted { contact } } else { ContactChange::Touched { contact } };
    place.pressed = !place.pressed;
    step.note(wheel, change);
}
