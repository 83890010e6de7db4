//! Least and greatest numbers that make sense.

/// Smallest mass [kg] and inertia [kg m2] that a scene or a master may set.
pub const SMALLEST: f64 = 1e-6;
/// Smallest Young's modulus, Pa.
pub const SMALLEST_MODULUS: f64 = 1e6;
/// Largest number of output steps in a run.
pub const MOST_STEPS: f64 = 1e8;
/// Distance of rails, or of a wheelset's tread circles, beyond which another unit was meant, m: the widest gauge that ran was 3 m.
pub const WIDEST: f64 = 4.0;
