//! Floor 8: what is asked of a scene without simulating it.
//!
//! [`contact_geometry`] sets the wheelset on its rails at one lateral shift, [`sweep`] does so over a range of shifts, and
//! [`conicity`] makes equivalent conicities of the rolling-radius difference that comes out.

pub mod conicity;
pub mod contact_geometry;
pub mod sweep;
