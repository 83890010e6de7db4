//! Implicit in the contacts, explicit in everything else: the Rosenbrock-W method with the Jacobian of normal contact and creep
//! forces alone.
//!
//! A W-method keeps its order whatever matrix stands for the Jacobian, so the split costs no order. It is stable in what the
//! Jacobian covers; what it leaves out (joints, force elements) must be slow against the step: its explicit limit is 2.0 / k
//! for a decay of rate k. The kinematics x' = v of all bodies is in its matrix, with which an undamped vibration grows whatever the step is, by
//! 0.0104 (w h)^4.2 of its amplitude; steps are bounded by what damping takes ([`super::stability`]).

use super::rosenbrock::{Rosenbrock, TOLERANCES};
use super::{Integrator, StiffPart, parse_setting};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "imex",
    summary: "as rosenbrock, but only contact and creep forces implicit, the rest explicit; `tolerance` in m and rad per step",
    reference: "Rang, Angermann, BIT 45 (2005) 761-787",
    parse,
};

fn parse(section: &Section) -> Result<Arc<dyn Integrator>, SettingsError> {
    let tolerance = parse_setting(section, "tolerance", Dimension::Length, TOLERANCES)?;
    Ok(Arc::new(Rosenbrock { tolerance, part: StiffPart::Contact }))
}
