//! A located contact and its constraint row.

use crate::contact::search::algebraic::SurfaceParameters;
use crate::contact::search::kinematics::MovingContact;
use crate::formulation::loading::not_found;
use crate::formulation::memory::WheelMemory;
use crate::formulation::rigid_scratch::ConstraintRow;
use crate::formulation::step::WheelRef;
use crate::formulation::{ContactFailure, Model};
use crate::mbs::body::BodyMotion;
use crate::mbs::kkt::Coefficients;

/// The contact with the motion of its gap; `memory` holds the warm start.
#[inline]
pub(super) fn locate(
    model: &Model,
    wheel: WheelRef,
    motion: &BodyMotion,
    memory: &mut WheelMemory,
) -> Result<MovingContact, ContactFailure> {
    let pair = wheel.pair(model, motion);
    let carrier = motion.carrier();
    let mut found = pair.locate_moving(memory.start(), &carrier);
    // A constraint that is lost where others may take over must not jump to one of them.
    if model.searches[wheel.contact].is_none() || memory.mode.is_elastic() {
        found = found.or_else(|_| pair.locate_moving(&SurfaceParameters::default(), &carrier));
    }
    let found = found.map_err(|failure| not_found(model, motion, failure))?;
    memory.set_start(found.location.parameters);
    Ok(found)
}

/// H of Eq. 23 on the wheelset's coordinates.
#[inline]
pub(super) fn coefficients(motion: &BodyMotion, found: &MovingContact) -> Coefficients {
    let normal = found.location.normal;
    motion.coefficients(&normal, &found.arm.cross(&normal))
}

/// Rates of u and eta, m/s.
#[inline]
pub(super) fn rates(found: &MovingContact) -> [f64; 2] {
    [found.parameter_rates[0], found.parameter_rates[3]]
}

impl ConstraintRow {
    /// Of a contact that was located with its motion.
    #[inline]
    pub fn of(motion: &BodyMotion, found: &MovingContact) -> ConstraintRow {
        ConstraintRow { location: found.location, row: coefficients(motion, found), bias: found.gap_bias, rates: rates(found) }
    }
}
