//! How outputs change with an input at the present instant: the direct feedthrough, differentiated.
//!
//! Positions, velocities, the states of elements and contacts, the form of every contact and all other inputs are held. What is left is what
//! accelerations and forces do at once.
//!
//! - *A force or torque on a wheelset, elastic contact.* Accelerations are linear in it: its wrench is added to the loads that the evaluation has
//!   left, and the equations of motion are solved for loads to both sides, about as large as the weight. That is exact to rounding, and no contact
//!   is looked at again. (An output that is not linear in accelerations and the input itself would be off; there is none.)
//! - *All others*: friction, motion of the rails, inputs of force elements; every input where contact is a constraint, whose normal forces follow
//!   from a loop. The model is evaluated at values of the input to both sides (to one where its least value is near), and the differences are
//!   extrapolated to distance zero (Richardson). Of all that the extrapolation gives, each output takes what is nearest to its neighbours (Ridders,
//!   Advances in Engineering Software 4 (1982) 75-76): rounding and small corners of laws with strips choose their own distance. Where the slopes to
//!   both sides differ (a brake that slips at its bound), the value is their mean.
//!
//! The Jacobian of the implicit integrators is not used: methods of its kind keep their order with any, so that slopes of creep laws are good to
//! 1e-3 there, and the patch's change with its place is left out.

use super::feedthrough::whose;
use super::outputs::Output;
use super::{Simulation, SimulationError, Snapshot};
use crate::formulation::inputs::{RAIL_ROWS, TRAVEL_ROWS, WHEELSET_ROWS};
use crate::formulation::memory::ModelMemory;
use crate::formulation::{Evaluation, Model, WHEELSET_INPUTS};
use crate::mbs::body::Wrench;
use crate::units::Unit;

/// Distances from the input's value, and each as a part of the one before.
const LEVELS: usize = 6;
const NEXT: f64 = 0.25;
/// The first as a part of the input's size.
const FIRST: f64 = 0.05;
/// Neighbours that agree to this part end the extrapolation.
const ROUNDING: f64 = 1e-14;
/// Slopes to both sides that differ by more than this part, and by so many times their errors, are those of a corner.
const CORNER: f64 = 1e-4;
const SURE: f64 = 100.0;
/// Acceleration of a body under the load that is added, m/s2.
const LOADED: f64 = 10.0;

/// Scratch that is kept from call to call.
#[derive(Debug, Default)]
pub(super) struct Extrapolation {
    memory: ModelMemory,
    rows: Vec<Row>,
}

/// What is looked at of one output.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    /// Without the change, with it to the one side and to the other.
    here: f64,
    ahead: f64,
    behind: f64,
    to_both: Tableau,
    /// To each side alone.
    to_one: [Tableau; 2],
    slope: f64,
}

/// Differences that are extrapolated to distance zero.
#[derive(Clone, Copy, Debug, Default)]
struct Tableau {
    /// The last row.
    row: [f64; LEVELS],
    slope: f64,
    error: f64,
}

impl Tableau {
    /// Adds the difference at another distance; `ratio` is that of the errors that it leaves.
    fn extend(&mut self, level: usize, difference: f64, ratio: f64) {
        let mut next = [0.0; LEVELS];
        next[0] = difference;
        if level == 0 {
            (self.slope, self.error) = (difference, f64::INFINITY);
        }
        let mut power = 1.0;
        for j in 1..=level {
            power *= ratio;
            next[j] = next[j - 1] + (next[j - 1] - self.row[j - 1]) / (power - 1.0);
            let error = (next[j] - next[j - 1]).abs().max((next[j] - self.row[j - 1]).abs());
            if error < self.error {
                (self.slope, self.error) = (next[j], error);
            }
        }
        self.row = next;
    }
}

impl Row {
    /// Adds the differences at another distance.
    fn extend(&mut self, level: usize, distance: f64, one_sided: bool) {
        let Row { here, ahead, behind, to_both, to_one: [before, after], .. } = self;
        after.extend(level, (*ahead - *here) / distance, 1.0 / NEXT);
        if one_sided {
            self.slope = after.slope;
            return;
        }
        before.extend(level, (*here - *behind) / distance, 1.0 / NEXT);
        // To both sides odd powers of the distance cancel.
        to_both.extend(level, (*ahead - *behind) / (2.0 * distance), 1.0 / (NEXT * NEXT));
        let apart = (after.slope - before.slope).abs();
        let corner = apart > CORNER * (after.slope.abs() + before.slope.abs()) && apart > SURE * (after.error + before.error);
        self.slope = if corner { 0.5 * (after.slope + before.slope) } else { to_both.slope };
    }

    fn is_settled(&self, one_sided: bool) -> bool {
        let tableau = if one_sided { &self.to_one[1] } else { &self.to_both };
        tableau.error <= ROUNDING * tableau.slope.abs()
    }
}

/// Least size of a force element's input, SI: forces like a wheel's load, or else rounding of accelerations shows in what they change elsewhere.
fn least_size(unit: Unit) -> f64 {
    match unit {
        Unit::Newton | Unit::NewtonMetre => 1e4,
        _ => 1.0,
    }
}

/// Size of an input [SI], by which distances are measured, and its least value.
fn size(model: &Model, input: usize, value: f64) -> (f64, Option<f64>) {
    if let Some(mut place) = input.checked_sub(model.first_element_input()) {
        for force in &model.system.forces {
            match force.inputs().get(place) {
                Some(own) => return (value.abs().max(least_size(own.unit)), own.least),
                None => place -= force.inputs().len(),
            }
        }
        // Of a wanted speed and its rate, which are bounded soon.
        return (1.0, TRAVEL_ROWS.get(place).and_then(|row| row.least));
    }
    let (wheelset, number) = whose(model.wheelsets.len(), input);
    let row = match number.checked_sub(WHEELSET_INPUTS) {
        None => &WHEELSET_ROWS[number],
        Some(rail) => &RAIL_ROWS[rail % RAIL_ROWS.len()],
    };
    let load = model.wheelsets[wheelset].static_wheel_load;
    let size = match row.unit {
        // Of a wheel's load, and it at half a metre.
        Unit::Newton => load,
        Unit::NewtonMetre => 0.5 * load,
        // Of a penetration of 0.07 mm.
        Unit::Metre => 5e-5,
        // Of creepages that use the friction up, at 20 m/s.
        Unit::MetrePerSecond => 2e-2,
        // The slope of a rail; a factor of friction.
        _ if number >= WHEELSET_INPUTS => 1e-3,
        _ => 1.0,
    };
    (size, row.least)
}

impl Simulation {
    /// For every output the sum of its partial derivatives by inputs (places in the input vector), each times its `seed`; `depends` says which outputs
    /// depend on an input, the others keep what they have of it, nothing. The state is not touched.
    ///
    /// # Errors
    /// [`SimulationError`] when the model can't be evaluated here or nearby.
    pub fn directional_derivative(
        &mut self,
        seeds: &[(usize, f64)],
        outputs: &[&Output],
        depends: impl Fn(&Output, usize) -> bool,
        derivatives: &mut [f64],
    ) -> Result<(), SimulationError> {
        derivatives.fill(0.0);
        self.snapshot()?;
        let mut kept = std::mem::take(&mut self.extrapolation);
        kept.rows.resize(outputs.len(), Row::default());
        let mut done = Ok(());
        // Those that leave the evaluation as it is come first.
        for wanted in [true, false] {
            for (input, seed) in seeds.iter().filter(|(_, seed)| *seed != 0.0) {
                let load = self.load_by(*input);
                if load.is_some() != wanted {
                    continue;
                }
                if done.is_ok() {
                    done = match load {
                        Some(load) => self.load_to_both_sides(load, outputs, &mut kept.rows),
                        None => self.extrapolate(*input, outputs, &mut kept),
                    };
                }
                let reacts = outputs.iter().map(|output| depends(output, *input));
                for ((derivative, row), _) in derivatives.iter_mut().zip(&kept.rows).zip(reacts).filter(|(_, reacts)| *reacts) {
                    *derivative += seed * row.slope;
                }
            }
        }
        self.extrapolation = kept;
        done
    }

    /// The wheelset that this input loads, and its number there, where accelerations are linear in it.
    pub(super) fn load_by(&self, input: usize) -> Option<(usize, usize)> {
        let (wheelset, number) = whose(self.model.wheelsets.len(), input);
        let own = input < self.model.first_element_input() && number < WHEELSET_INPUTS;
        let loads = own && WHEELSET_ROWS[number].unit != Unit::One;
        (loads && !self.model.formulation.constrains()).then_some((wheelset, number))
    }

    /// Slopes by a force or torque on a wheelset under elastic contact. Leaves the snapshot as it was.
    fn load_to_both_sides(
        &mut self,
        (wheelset, number): (usize, usize),
        outputs: &[&Output],
        rows: &mut [Row],
    ) -> Result<(), SimulationError> {
        let body = self.model.wheelsets[wheelset].body;
        // A torque turns about as much as a force at a metre.
        let size = LOADED * self.model.system.bodies[body].mass;
        let mut own = [0.0; WHEELSET_INPUTS];
        own[number] = size;
        let load = self.model.input_wrench(&self.snapshot.workspace.system, body, &own);
        let before = self.snapshot.workspace.system.wrenches[body];
        let place = WHEELSET_INPUTS * wheelset + number;
        let set = self.snapshot.inputs[place];
        for side in [1.0, -1.0, 0.0] {
            let Snapshot { time, y, dy, workspace, inputs, .. } = &mut self.snapshot;
            // Powers are read with the input itself.
            inputs[place] = if side == 0.0 { set } else { set + size * side };
            let mut wrench = before;
            if side != 0.0 {
                wrench += Wrench { force: load.force * side, moment: load.moment * side };
            }
            workspace.system.wrenches[body] = wrench;
            self.model.accelerate(workspace, *time, y, dy)?;
            for (row, output) in rows.iter_mut().zip(outputs) {
                let value = output.value(&self.snapshot);
                match side {
                    1.0 => row.ahead = value,
                    -1.0 => row.slope = (row.ahead - value) / (2.0 * size),
                    _ => {}
                }
            }
        }
        Ok(())
    }

    /// Slopes by any input. The snapshot is another one afterwards.
    fn extrapolate(&mut self, input: usize, outputs: &[&Output], kept: &mut Extrapolation) -> Result<(), SimulationError> {
        self.snapshot()?;
        let value = self.snapshot.inputs[input];
        let (size, least) = size(&self.model, input, value);
        let one_sided = least.is_some_and(|least| value - FIRST * size < least);
        kept.memory.clone_from(&self.snapshot.memory);
        self.known = None;
        self.snapshot.workspace.rigid.balance.exact = true;
        let done = self.fill_tableau((input, value), size, one_sided, outputs, kept);
        self.snapshot.workspace.rigid.balance.exact = false;
        done
    }

    /// Differences at one distance after the other.
    fn fill_tableau(
        &mut self,
        (input, value): (usize, f64),
        size: f64,
        one_sided: bool,
        outputs: &[&Output],
        Extrapolation { memory, rows }: &mut Extrapolation,
    ) -> Result<(), SimulationError> {
        self.look_at((input, value), memory, outputs, |place, value| rows[place].here = value)?;
        let mut wanted = FIRST * size;
        for level in 0..LEVELS {
            // What is added in floating point.
            let distance = (value + wanted) - value;
            wanted *= NEXT;
            self.look_at((input, value + distance), memory, outputs, |place, value| rows[place].ahead = value)?;
            if !one_sided {
                self.look_at((input, value - distance), memory, outputs, |place, value| rows[place].behind = value)?;
            }
            rows.iter_mut().for_each(|row| row.extend(level, distance, one_sided));
            if level > 0 && rows.iter().all(|row| row.is_settled(one_sided)) {
                break;
            }
        }
        Ok(())
    }

    /// Evaluates the model in the snapshot's state with another value of an input, from this memory, and hands out what outputs show.
    fn look_at(
        &mut self,
        (input, value): (usize, f64),
        from: &ModelMemory,
        outputs: &[&Output],
        mut tell: impl FnMut(usize, f64),
    ) -> Result<(), SimulationError> {
        let Snapshot { time, y, dy, workspace, memory, inputs } = &mut self.snapshot;
        inputs[input] = value;
        memory.clone_from(from);
        self.model.derivative(workspace, Evaluation { t: *time, inputs, y, memory }, dy)?;
        outputs.iter().enumerate().for_each(|(place, output)| tell(place, output.value(&self.snapshot)));
        Ok(())
    }
}
