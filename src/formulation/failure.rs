//! What can go wrong in an evaluation, with the place where it did.

use super::wheelset::Wheelset;
use crate::contact::normal::ConformalContact;
use crate::geometry::Side;
use crate::mbs::tangent::SingularTangent;

/// Why the equations could not be evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("t = {time:.9} s, {wheelset}, {} wheel: {cause}", side.name())]
pub struct EvaluationError {
    /// s.
    pub time: f64,
    pub wheelset: String,
    pub side: Side,
    pub cause: ContactFailure,
}

impl EvaluationError {
    pub(super) fn new(time: f64, wheelset: &Wheelset, side: Side, cause: ContactFailure) -> Self {
        EvaluationError { time, wheelset: wheelset.name.clone(), side, cause }
    }
}

/// What went wrong at one contact.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ContactFailure {
    #[error(
        "the contact search found no solution ({iterations} iterations, residual {residual:.1e}, wheelset at y = {y:.4} m): {}",
        not_found(*residual)
    )]
    NotFound { iterations: usize, residual: f64, y: f64 },
    #[error(
        "contact at the {part} coordinate {found:.4} m, but its profile reaches only from {first:.4} m to {last:.4} m (wheelset at y = {y:.4} m)"
    )]
    OffProfile { part: &'static str, found: f64, first: f64, last: f64, y: f64 },
    #[error(
        "half-spaces: the pressures of the wheel did not settle (wheelset at y = {y:.4} m); expected contact.creep.grid = 32, or contact.patch = \"strips\""
    )]
    Unsettled { y: f64 },
    #[error("no node of the wheel stands over a node of the rail (wheelset at y = {y:.4} m): the wheelset has left the rails")]
    OffRail { y: f64 },
    #[error("derailed: {how} (wheelset at y = {y:.4} m, z = {z:.4} m)")]
    Derailed { how: &'static str, y: f64, z: f64 },
    #[error(
        "the wheelset has been thrown to y = {y:.1e} m, z = {z:.1e} m: what acts on it is beyond any vehicle's forces and torques; expected inputs in N and N m"
    )]
    Thrown { y: f64, z: f64 },
    #[error(
        "the travelling speed has fallen to {speed:.3} m/s, and steady creepages are relative to it; for low speed and standstill give the scene \
         a table [contact.transient]"
    )]
    TooSlow { speed: f64 },
    #[error("{0}")]
    Conformal(#[from] ConformalContact),
    #[error(
        "penetration of {penetration:.4} m is beyond elastic contact (wheelset at z = {z:.4} m): an initial position that is too low, a gauge too narrow for the flanges, dimensions or masses in another unit, an impact, or with a fixed step one that is too long (solver.step)"
    )]
    TooDeep { penetration: f64, z: f64 },
    #[error(
        "the normal force has come to {normal_force:.1e} N and the contact constraint would have to pull: the wheel lifts off; use an elastic \
         formulation (contact.formulation = \"ECF-A\") or contact.on_lift = \"elastic\""
    )]
    Tensile { normal_force: f64 },
    #[error(
        "normal force and creep forces do not settle ({iterations} iterations, rest {residual:.1e} N): the place of this rigid contact is about \
         to cease, or friction is too large for a contact this steep; contact.on_lift = \"elastic\" goes on with elastic forces"
    )]
    NotSettled { iterations: usize, residual: f64 },
    #[error(
        "the constraints of the contact are not independent: the surfaces touch along a line or are conformal here; an elastic formulation (contact.formulation = \"ECF-A\") goes on"
    )]
    Dependent,
    #[error("the constraints do not determine their forces (row {row}; wheelset at y = {y:.4} m)")]
    Singular { row: usize, y: f64 },
    #[error("{} ({iterations} iterations, gap {gap:.1e} m, wheelset at y = {y:.4} m)", not_closed(*gap))]
    NotClosed { iterations: usize, gap: f64, y: f64 },
    #[error(
        "the run is no longer symmetric: {what} is {value:.1e}, and effects.symmetry = \"half\" has nothing that would push the wheelset back; expected no input and no rail that \
         favours a side, or symmetry = \"none\""
    )]
    SymmetryLost { what: &'static str, value: f64 },
    #[error("{0}")]
    Stiff(#[from] SingularTangent),
}

impl ContactFailure {
    /// A wheel that is off its rail, or has been thrown farther than any derailment does.
    pub(super) fn off_the_rail(how: &'static str, y: f64, z: f64) -> Self {
        const FARTHEST: f64 = 100.0;
        if y.abs().max(z.abs()) <= FARTHEST { ContactFailure::Derailed { how, y, z } } else { ContactFailure::Thrown { y, z } }
    }
}

/// Why a scene is not symmetric.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Asymmetry {
    #[error("contact.formulation must be \"ECF-A\": the others have constraints or states of each contact")]
    Formulation,
    #[error("the track is curved or canted at {distance:.2} m; expected straight track (grades are welcome)")]
    Curve { distance: f64 },
    #[error("{0} does not go with it; expected a scene without, or symmetry = \"none\"")]
    Beside(&'static str),
    #[error("left and right wheel of {0} have different profiles or places")]
    Wheels(String),
    #[error("the rails' profiles differ")]
    RailProfiles,
    #[error("at {distance:.2} m the rails are no mirror images: {lateral:.2e} m across, {vertical:.2e} m up")]
    Rails { distance: f64, lateral: f64, vertical: f64 },
    #[error("{body} stands {y:.4} m beside the middle, and there is no body like it on the other side")]
    Alone { body: String, y: f64 },
    #[error("{body} begins with {coordinate} = {value:.2e}")]
    Start { body: String, coordinate: &'static str, value: f64 },
    #[error(
        "displaced symmetrically, {body} is accelerated along {coordinate} as its mirror image is not (by {share:.1e} of the largest acceleration): an element without its like on the \
         other side"
    )]
    Accelerations { body: String, coordinate: &'static str, share: f64 },
    #[error(
        "displaced symmetrically, the wheels of an axle are accelerated against each other (by {share:.1e} of the largest acceleration): a torque on one of them, or inertia that they \
         don't share evenly"
    )]
    Twist { share: f64 },
}

/// A residual (m and direction cosines) up to which a search that fails was near its place: where a place ceases, it goes to zero
/// with the way beyond.
const NEAR: f64 = 1e-3;
/// A gap, m, that nobody can measure: the constraints hold, and what fails is finding the next position.
const SHUT: f64 = 1e-10;

fn not_found(residual: f64) -> &'static str {
    if residual < NEAR {
        "the place that was followed has ceased, since wheel and rail part there or touch along a line; an elastic formulation \
         (or contact.on_lift = \"elastic\", where it is not set yet) goes on with the places that are left"
    } else {
        "the wheelset may have left the rails"
    }
}

fn not_closed(gap: f64) -> &'static str {
    if gap < SHUT {
        "the contacts are closed but no longer say where the wheelset goes: a place of rigid contact is about to cease; \
         contact.on_lift = \"elastic\" goes on with elastic forces"
    } else {
        "no position near this one satisfies the constraints"
    }
}
