//! A wheel that stands somewhere on its rail.

use crate::contact::search::algebraic::Pair;
use crate::contact::search::global::WheelPose;

/// The pair as it stands, and what predictions count from.
pub(super) struct Stand<'a> {
    pub pair: Pair<'a>,
    pub pose: WheelPose,
    /// Of the wheel's tread, m.
    pub radius: f64,
}
