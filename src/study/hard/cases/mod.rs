//! The table of cases, one file per kind of hardness.

mod between_steps;
mod creep_modes;
mod extremes;
mod fixed_steps;
mod friction;
mod impacts;
mod profiles;
mod refusals;
mod seen_track;
mod verdicts;

use super::case::{Bound, Case, Method, Must};
use super::trace::Quantity;

/// Every case, in the order of the page.
pub fn all() -> Vec<Case> {
    [
        seen_track::CASES,
        between_steps::CASES,
        creep_modes::CASES,
        impacts::CASES,
        fixed_steps::CASES,
        verdicts::CASES,
        friction::CASES,
        extremes::CASES,
        profiles::CASES,
        refusals::CASES,
    ]
    .concat()
}

/// Adaptive methods at tolerances that people take.
const ADAPTIVE: &[Method] = &[
    Method::new("rosenbrock", "tolerance=1e-5"),
    Method::new("imex", "tolerance=1e-5"),
    Method::new("dormand_prince", "tolerance=1e-5"),
    Method::new("rk43", "tolerance=1e-5"),
];

/// All of them, fixed steps within what docs/scene.md calls right.
const EVERY: &[Method] = &[
    Method::new("rosenbrock", "tolerance=1e-5"),
    Method::new("imex", "tolerance=1e-5"),
    Method::new("dormand_prince", "tolerance=1e-5"),
    Method::new("rk43", "tolerance=1e-5"),
    Method::new("generalised_alpha", "step=1 ms"),
    Method::new("real_time", "step=1 ms"),
    Method::new("rk4", "step=0.1 ms"),
    Method::new("zhai", "step=0.05 ms"),
];

/// The reference steps as its error asks for; what checks it takes steps that nothing makes longer. They must agree to a quarter of the
/// bounds, for which these are short enough.
const TIGHT: [Method; 2] = [Method::new("dormand_prince", "tolerance=1e-9"), Method::new("rk4", "step=0.08 ms")];
/// Where flanges strike.
const TIGHT_STRIKES: [Method; 2] = [Method::new("dormand_prince", "tolerance=1e-10"), Method::new("rk4", "step=0.02 ms")];
/// For impacts.
const TIGHTER: [Method; 2] = [Method::new("dormand_prince", "tolerance=1e-11"), Method::new("rk4", "step=0.02 ms")];

const fn bound(quantity: Quantity, most: f64) -> Bound {
    Bound { quantity, most, shift: 0.0 }
}

/// Of a force that strikes and is over within milliseconds.
const fn strike(quantity: Quantity, most: f64) -> Bound {
    Bound { quantity, most, shift: 4e-4 }
}

/// Near to the reference in what users read.
const fn near(bounds: &'static [Bound]) -> Must {
    Must::Reference { methods: TIGHT, bounds }
}

/// The same where flanges strike.
const fn near_strikes(bounds: &'static [Bound]) -> Must {
    Must::Reference { methods: TIGHT_STRIKES, bounds }
}
