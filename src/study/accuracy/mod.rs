//! What accuracy costs in time: formulations x integrators x tolerances (or steps) on one scene.
//!
//! Rules, the same for all:
//! - *Same problem, same outputs.* All runs start in the steady state of the same scene and are read on the same output times.
//! - *Reference.* Per model (rigid contact: ACCF and ECCF; each elastic formulation by itself, ECF-N per node spacing) two independent
//!   methods at the same tight tolerance. Their difference is the reference's *uncertainty*. An error below [`FACTOR`] times the
//!   uncertainty is no number that the study vouches for: such a point is only known to be better than that.
//! - *Errors*: the largest over the run, of lateral displacement, wheel load, normal force, Y/Q and accelerations (where forces jump with the state, what the other run has within one
//!   sample is none), and of the hunting wavelength; always the worst wheelset or wheel. Samples at which a wheel stands where the curvature of its rail jumps are left out.
//! - *Cost*: CPU time of one thread, runs one after the other and without outputs, median of repeated runs.
//! - *Models*: the distance between the references of two models is no error of either and is named on its own, where it is more than
//!   both references are uncertain by.
//! - *Budget*: what is predicted not to fit into the time that is left is not run, and the study says so. Which points are run depends
//!   on the machine; their errors do not, to the uncertainty of the reference, which is as tight as the budget allows.

mod best;
mod clock;
mod communication;
mod difference;
mod division;
mod errors;
mod making;
mod observation;
mod reference;
mod request;
mod run;
mod schedule;
mod study;
mod variant;

pub use best::{Best, best, front};
pub use clock::{Interrupted, cpu_time};
pub use communication::{COUPLING, Coupled, HOLDS};
pub use errors::{Distance, Errors, Quantity};
pub use making::study;
pub use observation::{Observation, is_smooth};
pub use reference::{Reference, Standing};
pub use request::Request;
pub use run::{Measured, Setting};
pub use study::{Apart, ModelDifference, Outcome, Point, StudiedModel, Study, StudyError};
pub use variant::Variant;

/// A point is drawn where its error is at least this many times the reference's uncertainty.
pub const FACTOR: f64 = 100.0;

#[cfg(test)]
mod tests;
