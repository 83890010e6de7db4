//! What a body looks like, as far as a scene knows: the box of even density that has its mass and moments of inertia.

use crate::mbs::body::Body;
use crate::mbs::inertia::Inertia;

/// Least half edge, m: a body of no inertia is a point.
const LEAST: f64 = 0.1;

/// Half edges along x, y and z, m, of the box of even density with a body's mass and moments of inertia: of a box with the edges a, b, c, Ixx = m (b2 + c2) / 12 and so on. Moments
/// that no body of even density can have give what is nearest.
pub fn half_edges(body: &Body) -> [f64; 3] {
    let [xx, yy, zz] = match &body.inertia {
        Inertia::Revolution { transverse, axial } | Inertia::NotGyroscopic { transverse, axial } => [*transverse, *axial, *transverse],
        Inertia::General { principal, .. } => [principal.x, principal.y, principal.z],
    };
    let half = |moment: f64| if body.mass > 0.0 { (6.0 * moment.max(0.0) / body.mass).sqrt() / 2.0 } else { 0.0 };
    [yy + zz - xx, xx + zz - yy, xx + yy - zz].map(|moment| half(moment).max(LEAST))
}
