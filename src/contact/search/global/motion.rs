//! How far the wheel may move before a search is asked again, and by how much feet move then.

/// Motion for which certificates are asked at most, m. Feet then move by less than the slack of the rail's bounds.
pub(super) const MOST_STEADY: f64 = 1e-3;
/// How far feet move at most, over the motion.
pub(super) const SWAY: f64 = 1.25;

/// The lesser and the greater of two numbers, neither NaN: quicker than `f64::min` and `f64::max`.
#[inline]
pub(super) fn less(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline]
pub(super) fn more(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
