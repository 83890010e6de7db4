//! Lift-off and landing of contacts that are constraints while they are loaded; begin and end of contacts beside the first.

use crate::geometry::Side;
use serde::{Deserialize, Serialize};

/// What happened to a contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum ContactChange {
    /// The constraint would have begun to pull; the contact is elastic from here.
    Lifted,
    /// The place that was constrained is about to cease (within 1 ms the distance of the surfaces has no minimum there any more), or
    /// has ceased where a curvature jumps; the wheel is elastic from here.
    Vanished,
    /// No bounded normal force is in balance with its creep forces: the place is about to cease, or a steep contact is locked by
    /// friction. Rigid bodies have no motion there; the wheel is elastic from here.
    Undecided,
    /// The contact has settled and is a constraint again.
    Landed {
        /// Penetration that the projection removed, m.
        penetration: f64,
        /// Rate of the penetration that it removed, m/s.
        rate: f64,
        /// By how much the energy of motion, height, springs and this contact changed, J. Raising the wheel out of its elastic rest
        /// costs more than the contact held: at rest it grows by 0.6 N delta.
        energy: f64,
    },
    /// A contact beside the first has begun, without a jump in force.
    Touched {
        /// Its number, from 2.
        contact: usize,
    },
    /// It has ended.
    Parted { contact: usize },
}

impl ContactChange {
    /// Does the contact change from constraint to elastic force or back? (The others belong to ordinary running.)
    pub fn changes_mode(&self) -> bool {
        !matches!(self, ContactChange::Touched { .. } | ContactChange::Parted { .. })
    }
}

/// A change of one contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactEvent {
    /// s.
    pub time: f64,
    pub wheelset: String,
    pub side: Side,
    pub change: ContactChange,
}

impl std::fmt::Display for ContactEvent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "t = {:.9} s, {}, {} wheel: ", self.time, self.wheelset, self.side.name())?;
        match self.change {
            ContactChange::Lifted => write!(f, "normal force fell to zero, the contact is elastic from here"),
            ContactChange::Vanished => write!(f, "the contact point ceases to exist under load, the wheel is elastic from here"),
            ContactChange::Undecided => {
                write!(f, "a rigid contact has no normal force in balance here, the wheel is elastic from here")
            }
            ContactChange::Touched { contact } => write!(f, "contact {contact} begins"),
            ContactChange::Parted { contact } => write!(f, "contact {contact} ends"),
            ContactChange::Landed { penetration, rate, energy } => write!(
                f,
                "the contact has settled and is a constraint again; {penetration:.3e} m of penetration and {rate:.3e} m/s removed, energy changed by {energy:+.3e} J"
            ),
        }
    }
}
