//! Getting and setting variables of an instance.

use super::{CallError, Instance, Phase};
use crate::fmi::description::INPUT_DERIVATIVE_ORDER;
use crate::fmi::variables::{Kind, Role, Variable};
use crate::sim::outputs::needs;

/// Which variables were read last, and where they stand in the table: a host reads the same ones again and again.
#[derive(Default)]
pub(super) struct LastRead {
    references: Vec<u32>,
    places: Vec<usize>,
    /// Their values.
    found: Vec<f64>,
}

impl Instance {
    fn place(&self, reference: u32, kind: Kind) -> Result<usize, CallError> {
        let found = self.table.place(reference).filter(|place| self.table.at(*place).kind == kind);
        found.ok_or(CallError::UnknownReference { reference, kind })
    }

    pub(super) fn lookup(&self, reference: u32, kind: Kind) -> Result<&Variable, CallError> {
        match self.table.find(reference) {
            Some(variable) if variable.kind == kind => Ok(variable),
            _ => Err(CallError::UnknownReference { reference, kind }),
        }
    }

    /// fmi2GetReal.
    ///
    /// # Errors
    /// [`CallError`]; `values` is then unchanged.
    pub fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), CallError> {
        if references != self.last_read.references {
            // None, until all are known.
            self.last_read.references.clear();
            self.last_read.places.clear();
            for reference in references {
                match self.place(*reference, Kind::Real) {
                    Ok(place) => self.last_read.places.push(place),
                    Err(error) => {
                        self.last_read.places.clear();
                        return Err(error);
                    }
                }
            }
            self.last_read.references.extend_from_slice(references);
        }
        let outputs = self.last_read.places.iter().filter_map(|place| match self.table.at(*place).role {
            Role::Output(output) => Some(&self.table.outputs[output]),
            _ => None,
        });
        if let Some(needs) = needs(outputs) {
            self.started()?.snapshot_with(needs).map_err(CallError::Evaluation)?;
        }
        // Taken out while it is filled.
        let mut found = std::mem::take(&mut self.last_read.found);
        found.clear();
        let answer = self.read(&mut found);
        self.last_read.found = found;
        answer?;
        values.copy_from_slice(&self.last_read.found);
        Ok(())
    }

    /// The values of the variables that were asked for last; the simulation knows what their outputs need.
    fn read(&self, found: &mut Vec<f64>) -> Result<(), CallError> {
        for place in &self.last_read.places {
            let variable = self.table.at(*place);
            let value = match &variable.role {
                Role::Output(output) => match &self.simulation {
                    Some(simulation) => self.table.outputs[*output].value(simulation.last_snapshot()),
                    None => unreachable!("started above"),
                },
                Role::Input(input) => self.simulation.as_ref().map_or(self.inputs[*input][0], |simulation| simulation.input(*input)[0]),
                Role::RealParameter(parameter) => parameter.value(&self.scene),
                Role::Time => self.time(),
                Role::Counter(read) => self.simulation.as_ref().map_or(0, |simulation| read(simulation.state())) as f64,
                _ => return Err(CallError::UnknownReference { reference: variable.reference, kind: Kind::Real }),
            };
            if !value.is_finite() {
                return Err(CallError::NotFinite { name: variable.name.clone(), time: self.time() });
            }
            found.push(value);
        }
        Ok(())
    }

    /// fmi2GetInteger.
    ///
    /// # Errors
    /// [`CallError`] for an unknown reference.
    pub fn get_integer(&mut self, reference: u32) -> Result<i32, CallError> {
        match self.lookup(reference, Kind::Integer)?.role {
            Role::Counter(read) => {
                let count = self.simulation.as_ref().map_or(0, |simulation| read(simulation.state()));
                Ok(i32::try_from(count).unwrap_or(i32::MAX))
            }
            Role::Contacts(wheel) => self.contacts_of(wheel, reference),
            _ => Err(CallError::UnknownReference { reference, kind: Kind::Integer }),
        }
    }

    /// fmi2GetBoolean.
    ///
    /// # Errors
    /// [`CallError`] for an unknown reference.
    pub fn get_boolean(&self, reference: u32) -> Result<bool, CallError> {
        self.lookup(reference, Kind::Boolean)?;
        Ok(self.scene.vehicle.initial.from_equilibrium)
    }

    /// fmi2GetString.
    ///
    /// # Errors
    /// [`CallError`] for an unknown reference.
    pub fn get_string(&self, reference: u32) -> Result<&str, CallError> {
        self.lookup(reference, Kind::String)?;
        Ok(&self.scene.title)
    }

    fn not_settable(&self, variable: &Variable) -> CallError {
        CallError::NotSettable {
            name: variable.name.clone(),
            causality: variable.causality,
            variability: variable.variability,
            phase: self.phase,
        }
    }

    fn check_settable(&self, variable: &Variable) -> Result<(), CallError> {
        let allowed = match variable.role {
            Role::Input(_) => self.phase != Phase::Terminated,
            Role::RealParameter(_) | Role::FromEquilibrium => match self.phase {
                Phase::Instantiated | Phase::Initialization => true,
                Phase::Stepping | Phase::Event => variable.is_tunable(),
                Phase::Terminated => false,
            },
            _ => false,
        };
        if allowed { Ok(()) } else { Err(self.not_settable(variable)) }
    }

    pub(super) fn check_value(&self, variable: &Variable, value: f64) -> Result<(), CallError> {
        let problem = if let Err(problem) = variable.check(value) {
            problem
        } else if value == 0.0 && variable.name == "speed" && self.scene.vehicle.speed_imposed && !self.may_stop() {
            "creepages are relative to the travelling speed".to_string()
        } else {
            return Ok(());
        };
        Err(CallError::Value { name: variable.name.clone(), value, problem })
    }

    /// May the speed be 0? Low speed calls for its own model of contact, and steady running at the start for any speed.
    fn may_stop(&self) -> bool {
        self.has_begun() && self.table.speed_input.is_some() && self.scene.contact.transient.is_some()
    }

    /// fmi2SetReal. Setting an input ends its derivatives; setting a tunable parameter restarts the integration, as a jump of an input does. What misses a bound by a rounding is the bound.
    ///
    /// # Errors
    /// [`CallError`]; nothing is set then.
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Result<(), CallError> {
        for (reference, value) in references.iter().zip(values) {
            let variable = self.lookup(*reference, Kind::Real)?;
            self.check_settable(variable)?;
            self.check_value(variable, if matches!(variable.role, Role::Input(_)) { variable.rounded_in(*value) } else { *value })?;
        }
        self.set_parameters(references, values)?;
        for (reference, value) in references.iter().zip(values) {
            let variable = self.lookup(*reference, Kind::Real)?;
            if let Role::Input(input) = variable.role {
                let value = variable.rounded_in(*value);
                self.set_input(input, [value, 0.0, 0.0]);
            }
        }
        Ok(())
    }

    fn set_input(&mut self, input: usize, signal: [f64; 3]) {
        if !self.has_begun() && self.table.speed_input == Some(input) && self.inputs[input][0] != signal[0] {
            self.simulation = None;
        }
        if let Some(simulation) = &mut self.simulation {
            simulation.set_input(input, signal[0], signal[1], signal[2]);
        }
        // Kept for a simulation that is made anew when a parameter changes before initialization ends.
        self.inputs[input] = signal;
    }

    /// fmi2SetBoolean.
    ///
    /// # Errors
    /// [`CallError`].
    pub fn set_boolean(&mut self, references: &[u32], values: &[bool]) -> Result<(), CallError> {
        for reference in references {
            self.check_settable(self.lookup(*reference, Kind::Boolean)?)?;
        }
        if let Some(value) = values.last() {
            self.scene.vehicle.initial.from_equilibrium = *value;
            self.simulation = None;
        }
        Ok(())
    }

    /// fmi2SetInteger and fmi2SetString: no variable of these types can be set.
    ///
    /// # Errors
    /// [`CallError`], always unless `references` is empty.
    pub fn refuse_to_set(&self, references: &[u32], kind: Kind) -> Result<(), CallError> {
        match references.first() {
            Some(reference) => Err(self.not_settable(self.lookup(*reference, kind)?)),
            None => Ok(()),
        }
    }

    /// fmi2SetRealInputDerivatives: order 1 and 2, with respect to the present time. An input follows its polynomial
    /// until its value or a derivative is set again.
    ///
    /// # Errors
    /// [`CallError`]; nothing is set then.
    pub fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Result<(), CallError> {
        let mut changes: Vec<(usize, [f64; 3])> = Vec::new();
        for ((reference, order), value) in references.iter().zip(orders).zip(values) {
            let variable = self.lookup(*reference, Kind::Real)?;
            let name = variable.name.clone();
            let Role::Input(input) = variable.role else { return Err(CallError::NotAnInput { name }) };
            self.check_settable(variable)?;
            if !(1..=INPUT_DERIVATIVE_ORDER).contains(order) {
                return Err(CallError::Order { name, order: *order, largest: INPUT_DERIVATIVE_ORDER });
            }
            if !value.is_finite() {
                return Err(CallError::Value { name, value: *value, problem: "a derivative must be a finite number".into() });
            }
            let place = match changes.iter().position(|change| change.0 == input) {
                Some(place) => place,
                None => {
                    let present = self.simulation.as_ref().map_or(self.inputs[input], |simulation| simulation.input(input));
                    changes.push((input, present));
                    changes.len() - 1
                }
            };
            changes[place].1[*order as usize] = *value;
        }
        for (input, signal) in changes {
            self.set_input(input, signal);
        }
        Ok(())
    }
}
