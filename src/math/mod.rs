//! Floor 0: mathematics that knows nothing of railways.

pub mod bracket;
pub mod elementary;
pub mod monotone_spline;
pub mod newton;
pub mod rotation;
pub mod smooth_step;
pub mod smoothing;
pub mod spline;
pub mod uniform_spline;
