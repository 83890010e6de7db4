//! Partial derivatives of outputs by inputs at the present communication point.

use super::{CallError, Instance, Phase};
use crate::fmi::variables::{Kind, Role};

impl Instance {
    /// fmi2GetDirectionalDerivative: for each of `unknowns` (real outputs) the sum over `knowns` (real inputs) of the partial derivative times the
    /// seed, everything else held.
    ///
    /// # Errors
    /// [`CallError`]; `derivatives` is then unchanged.
    pub fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        (knowns, seeds): (&[u32], &[f64]),
        derivatives: &mut [f64],
    ) -> Result<(), CallError> {
        self.require("a directional derivative", &[Phase::Initialization, Phase::Stepping, Phase::Event, Phase::Terminated])?;
        let mut places = Vec::with_capacity(unknowns.len());
        for reference in unknowns {
            let variable = self.lookup(*reference, Kind::Real)?;
            let Role::Output(output) = variable.role else { return Err(CallError::NotDerivable { name: variable.name.clone() }) };
            places.push(output);
        }
        let mut directions = Vec::with_capacity(knowns.len());
        for (reference, seed) in knowns.iter().zip(seeds) {
            let variable = self.lookup(*reference, Kind::Real)?;
            let name = variable.name.clone();
            let Role::Input(input) = variable.role else { return Err(CallError::NotDerivableBy { name }) };
            if !seed.is_finite() {
                return Err(CallError::Value { name, value: *seed, problem: "a seed must be a finite number".into() });
            }
            directions.push((input, *seed));
        }
        if places.is_empty() {
            return Ok(());
        }
        self.started()?;
        let (Some(simulation), table) = (&mut self.simulation, &self.table) else { return Ok(()) };
        let outputs: Vec<_> = places.iter().map(|output| &table.outputs[*output]).collect();
        let mut found = vec![0.0; outputs.len()];
        let depends = |output: &_, input| table.depends(output, input);
        simulation.directional_derivative(&directions, &outputs, depends, &mut found).map_err(CallError::Evaluation)?;
        if let Some(place) = found.iter().position(|value| !value.is_finite()) {
            return Err(CallError::NotFinite { name: outputs[place].name.clone(), time: simulation.time() });
        }
        derivatives.copy_from_slice(&found);
        Ok(())
    }

    /// fmi3GetAdjointDerivative: for each of `knowns` (real inputs) the sum over `unknowns` (real outputs) of the partial derivative times the seed.
    ///
    /// # Errors
    /// As of [`Instance::directional_derivative`].
    pub fn adjoint_derivative(
        &mut self,
        (unknowns, seeds): (&[u32], &[f64]),
        knowns: &[u32],
        derivatives: &mut [f64],
    ) -> Result<(), CallError> {
        if let Some((reference, seed)) = unknowns.iter().zip(seeds).find(|(_, seed)| !seed.is_finite()) {
            let name = self.lookup(*reference, Kind::Real)?.name.clone();
            return Err(CallError::Value { name, value: *seed, problem: "a seed must be a finite number".into() });
        }
        let (mut column, mut found) = (vec![0.0; unknowns.len()], Vec::with_capacity(knowns.len()));
        for known in knowns {
            self.directional_derivative(unknowns, (&[*known], &[1.0]), &mut column)?;
            found.push(column.iter().zip(seeds).map(|(by, seed)| by * seed).sum());
        }
        derivatives.copy_from_slice(&found);
        Ok(())
    }
}
