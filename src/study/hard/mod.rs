//! Hard cases: what each makes hard, what must hold with its number, and what every formulation and integrator makes of it.
//!
//! A [`Case`] is a scene with changes, a span, methods and the numbers that must hold. [`judge`] runs it: references first (two
//! methods of different families, tight, whose distance must lie below the bounds that are asked of others), then every method, read on a
//! *dense* grid that no step knows of, so that what happens between the ends of steps counts too. Each run is audited whatever the
//! case ([`audit`]): energy, momentum, gaps of rigid contacts, sign of normal forces, bound of creep forces; and a state that is saved in
//! the middle must lead to the same bits. [`random`] draws scenes from the whole schema and judges them in the same way.

mod audit;
mod case;
mod cases;
mod finding;
mod given;
mod judge;
mod open;
pub mod random;
mod run;
mod trace;

pub use case::{Case, Method};
pub use cases::all;
pub use finding::{Finding, Unit};
pub use judge::{Judged, Outcome, judge};
