//! Setting parameters, before a run and during it.

use super::{CallError, Instance};
use crate::fmi::variables::{Kind, Role, Variable};
use crate::sim::tuning::Tuning;
use crate::sim::vehicle_outputs::follow_constants;

impl Instance {
    /// The variables that are parameters, in table order.
    pub(super) fn parameters(&self) -> impl Iterator<Item = &Variable> {
        self.table.variables.iter().filter(|variable| variable.is_parameter())
    }

    /// Values of all parameters, in table order.
    pub(super) fn parameter_values(&self) -> Vec<f64> {
        let value = |variable: &Variable| match &variable.role {
            Role::RealParameter(parameter) => parameter.value(&self.scene),
            _ => f64::from(u8::from(self.scene.vehicle.initial.from_equilibrium)),
        };
        self.parameters().map(value).collect()
    }

    /// Sets those of the variables that are parameters. Values and phase have been checked.
    ///
    /// # Errors
    /// [`CallError::Value`] for a number that its part can't take beside its others; nothing is set then.
    pub(super) fn set_parameters(&mut self, references: &[u32], values: &[f64]) -> Result<(), CallError> {
        let mut before = Vec::new();
        let mut elements = None;
        for (reference, value) in references.iter().zip(values) {
            let Role::RealParameter(parameter) = self.lookup(*reference, Kind::Real)?.role else { continue };
            let old = parameter.value(&self.scene);
            if old.to_bits() == value.to_bits() {
                continue;
            }
            if elements.is_none() && parameter.is_of_force() {
                elements = Some(self.scene.vehicle.forces.clone());
            }
            before.push((parameter, old));
            parameter.assign(&mut self.scene, *value);
            if parameter.value(&self.scene) == *value {
                continue;
            }
            before.into_iter().rev().for_each(|(parameter, old)| parameter.assign(&mut self.scene, old));
            // An element's numbers hang together: what was refused may have changed others.
            if let Some(elements) = elements {
                self.scene.vehicle.forces = elements;
            }
            let name = self.lookup(*reference, Kind::Real)?.name.clone();
            return Err(CallError::Value { name, value: *value, problem: "it does not fit the other numbers of its part".into() });
        }
        if before.is_empty() {
            return Ok(());
        }
        if self.phase.is_running() {
            self.put_in_force(true);
        } else {
            self.simulation = None;
        }
        Ok(())
    }

    /// The parameters that are not what they were when the run began: place in table order and value.
    fn differences(&self) -> Vec<(u32, f64)> {
        if self.begun.is_empty() {
            return Vec::new();
        }
        let values = self.parameter_values();
        let changed = values.iter().zip(&self.begun).enumerate().filter(|(_, (now, begun))| now.to_bits() != begun.to_bits());
        changed.map(|(place, (now, _))| (place as u32, *now)).collect()
    }

    /// The simulation takes the scene's parameters before a state is put back that was made under them.
    pub(super) fn adopt_tuning(&mut self) {
        self.put_in_force(false);
    }

    /// The simulation goes on with the parameters of the scene as they now are.
    fn put_in_force(&mut self, restart: bool) {
        let before = std::mem::take(&mut self.tuned);
        self.tuned = self.differences();
        let parameters: Vec<&Variable> = self.parameters().collect();
        let of_elements = |tuned: &[(u32, f64)]| -> Vec<(usize, u32, f64)> {
            tuned.iter().filter_map(|(place, value)| parameters[*place as usize].constant_of_force(*value)).collect()
        };
        let constants = of_elements(&self.tuned);
        // Those that go back to what they were at the start change too.
        let changed: Vec<usize> = of_elements(&before).iter().chain(&constants).map(|(element, ..)| *element).collect();
        let integrator = self.effective_integrator();
        let tuning = Tuning { scene: &self.scene, integrator: &integrator, constants: &constants };
        let Some(simulation) = &mut self.simulation else { return };
        if restart {
            simulation.tune(&tuning);
        } else {
            simulation.adopt(&tuning);
        }
        // Outputs hold copies of elements.
        follow_constants(&mut self.table.outputs, &self.scene, simulation.model(), &changed);
    }
}
