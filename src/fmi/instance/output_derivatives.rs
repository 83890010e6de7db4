//! Derivatives of outputs by time, of order 1 and 2.
//!
//! Where another output of the FMU is the derivative, it is read. What is left of the order is found by differences along the solution, `y(h) = y + h y' + h^2 y'' / 2`
//! with `y'` the slope of the continuous output and `y'' = (f(y + k y') - f(y - k y')) / 2k`, inputs by their polynomials:
//!
//! ```text
//! order 1: (g(k) - g(-k)) / 2k,    order 2: (g(h) - 2 g(0) + g(-h)) / h^2
//! ```
//!
//! k = 1 us leaves out 1e-7 of the stiffest motion (the contact's 200 Hz), h = 20 us 5e-5. They are those of the smooth motion: at a jump (a joint of the track's curvature, a contact
//! that begins) none exist.

use super::{CallError, Instance};
use crate::fmi::description::OUTPUT_DERIVATIVE_ORDER;
use crate::fmi::variables::{Kind, Role};
use crate::sim::{Simulation, SimulationError};

/// How far the solution is followed for a first and for a second difference, s.
const FIRST: f64 = 1e-6;
const SECOND: f64 = 2e-5;

/// A derivative: of which output a difference is taken, and of which order.
type Asked = (usize, i32);

impl Instance {
    /// fmi2GetRealOutputDerivatives and fmi3GetOutputDerivatives.
    ///
    /// # Errors
    /// [`CallError`]; `values` is then unchanged.
    pub fn get_output_derivatives(&mut self, references: &[u32], orders: &[i32], values: &mut [f64]) -> Result<(), CallError> {
        let asked: Result<Vec<Asked>, CallError> = references.iter().zip(orders).map(|(own, order)| self.asked(*own, *order)).collect();
        let asked = asked?;
        if asked.is_empty() {
            return Ok(());
        }
        self.started()?;
        let (Some(simulation), table) = (&mut self.simulation, &self.table) else { return Ok(()) };
        let read = |simulation: &Simulation| -> Vec<f64> {
            asked.iter().map(|(output, _)| table.outputs[*output].value(simulation.seen())).collect()
        };
        let found = differences(simulation, &asked, read).map_err(CallError::Evaluation)?;
        values.iter_mut().zip(found).for_each(|(value, found)| *value = found);
        Ok(())
    }

    /// Goes from an output to those that are its derivatives, as far as there are any.
    fn asked(&self, reference: u32, order: i32) -> Result<Asked, CallError> {
        let mut variable = self.lookup(reference, Kind::Real)?;
        let name = || variable.name.clone();
        let Role::Output(mut output) = variable.role else { return Err(CallError::NotAnOutput { name: name() }) };
        if !(1..=OUTPUT_DERIVATIVE_ORDER).contains(&order) {
            return Err(CallError::Order { name: name(), order, largest: OUTPUT_DERIVATIVE_ORDER });
        }
        let mut left = order;
        while left > 0 {
            let Some(rate) = self.table.rate(variable) else { break };
            let Role::Output(next) = rate.role else { break };
            (variable, output, left) = (rate, next, left - 1);
        }
        Ok((output, left))
    }
}

fn differences(simulation: &mut Simulation, asked: &[Asked], read: impl Fn(&Simulation) -> Vec<f64>) -> Result<Vec<f64>, SimulationError> {
    let any = |order: i32| asked.iter().any(|(_, left)| *left == order);
    simulation.snapshot()?;
    let here = read(simulation);
    let mut found = here.clone();
    let mut rates = simulation.seen().dy.clone();
    let slope = if any(1) || any(2) { simulation.slope()? } else { Vec::new() };
    if any(1) || any(2) {
        simulation.displace(FIRST, &slope, None)?;
        let ahead = read(simulation);
        rates.copy_from_slice(&simulation.seen().dy);
        simulation.displace(-FIRST, &slope, None)?;
        let behind = read(simulation);
        rates.iter_mut().zip(&simulation.seen().dy).for_each(|(ahead, behind)| *ahead = (*ahead - behind) / (2.0 * FIRST));
        let each = found.iter_mut().zip(asked).zip(ahead.iter().zip(&behind));
        each.filter(|((_, asked), _)| asked.1 == 1).for_each(|((found, _), (ahead, behind))| *found = (ahead - behind) / (2.0 * FIRST));
    }
    if any(2) {
        simulation.displace(SECOND, &slope, Some(&rates))?;
        let ahead = read(simulation);
        simulation.displace(-SECOND, &slope, Some(&rates))?;
        let behind = read(simulation);
        let each = found.iter_mut().zip(asked).zip(here.iter().zip(ahead.iter().zip(&behind)));
        each.filter(|((_, asked), _)| asked.1 == 2)
            .for_each(|((found, _), (here, (ahead, behind)))| *found = ((ahead - here) - (here - behind)) / (SECOND * SECOND));
    }
    Ok(found)
}
