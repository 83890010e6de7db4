//! A wheelset's variables between state and constraints: coordinates first, then the surface parameters of both wheels.

use super::NORMAL;
use crate::contact::search::point_contact::{CONSTRAINTS, PARAMETERS};
use crate::formulation::memory::ModelMemory;
use crate::formulation::partition::{Jacobian, Rows, Variables};
use crate::formulation::{Model, contact_index};
use crate::geometry::Side;
use crate::mbs::body::{BodyMotion, COORDINATES};
use nalgebra::{Matrix3, Vector4};

/// One wheelset of a model at a state.
pub(super) struct OfWheelset<'a> {
    model: &'a Model,
    index: usize,
    /// Along which its x, y, z are counted; `None`: the world's.
    axes: Option<Matrix3<f64>>,
    /// Are its contacts elastic at present?
    pub elastic: [bool; 2],
}

/// Where the surface parameters of a side begin among a wheelset's variables.
fn first_parameter(side: Side) -> usize {
    COORDINATES + PARAMETERS * side.index()
}

impl<'a> OfWheelset<'a> {
    pub fn new(model: &'a Model, index: usize, y: &[f64], memory: &ModelMemory) -> Self {
        let axes = model.axes_beside(model.wheelsets[index].body, y, memory);
        OfWheelset { model, index, axes, elastic: Side::BOTH.map(|side| memory.wheels[contact_index(index, side)].mode.is_elastic()) }
    }

    fn body(&self) -> usize {
        self.model.wheelsets[self.index].body
    }

    /// Counts x, y, z along the axes, or in the world again (`back`).
    fn turn(&self, values: &mut Variables, back: bool) {
        let Some(axes) = &self.axes else { return };
        let linear = values.fixed_rows::<3>(0).into_owned();
        values.fixed_rows_mut::<3>(0).copy_from(&if back { axes * linear } else { axes.tr_mul(&linear) });
    }
}

/// A wheelset's variables and their rates from the state.
pub(super) fn gather(own: &OfWheelset, y: &[f64]) -> (Variables, Variables) {
    let (mut values, mut rates) = (Variables::zeros(), Variables::zeros());
    values.as_mut_slice()[..COORDINATES].copy_from_slice(&y[own.model.system.coordinates(own.body())]);
    rates.as_mut_slice()[..COORDINATES].copy_from_slice(&y[own.model.system.velocities(own.body())]);
    for side in Side::BOTH {
        let (first, states) = (first_parameter(side), &y[own.model.contact_states(contact_index(own.index, side))]);
        values.as_mut_slice()[first..first + PARAMETERS].copy_from_slice(&states[..PARAMETERS]);
        rates.as_mut_slice()[first..first + PARAMETERS].copy_from_slice(&states[PARAMETERS..]);
    }
    own.turn(&mut values, false);
    own.turn(&mut rates, false);
    (values, rates)
}

/// Puts a wheelset's variables and rates back into the state.
pub(super) fn scatter(own: &OfWheelset, mut values: Variables, mut rates: Variables, y: &mut [f64]) {
    own.turn(&mut values, true);
    own.turn(&mut rates, true);
    y[own.model.system.coordinates(own.body())].copy_from_slice(&values.as_slice()[..COORDINATES]);
    y[own.model.system.velocities(own.body())].copy_from_slice(&rates.as_slice()[..COORDINATES]);
    for side in Side::BOTH {
        let (first, states) = (first_parameter(side), &mut y[own.model.contact_states(contact_index(own.index, side))]);
        states[..PARAMETERS].copy_from_slice(&values.as_slice()[first..first + PARAMETERS]);
        states[PARAMETERS..].copy_from_slice(&rates.as_slice()[first..first + PARAMETERS]);
    }
}

/// Residual and Jacobian of a wheelset's ten constraints. A contact that is elastic at present has none: its surface parameters are
/// held (the place that they belonged to may be about to cease), and one coordinate that no contact determines (pitch or x).
pub(super) fn constraints(own: &OfWheelset, values: &Variables) -> (Rows, Jacobian) {
    let mut world = *values;
    own.turn(&mut world, true);
    let motion = BodyMotion::new(&world.as_slice()[..COORDINATES], &[0.0; COORDINATES]);
    let (mut residual, mut jacobian) = (Rows::zeros(), Jacobian::zeros());
    for (side, held) in [(Side::Left, COORDINATES - 1), (Side::Right, 0)] {
        let (row, column) = (CONSTRAINTS * side.index(), first_parameter(side));
        if own.elastic[side.index()] {
            let others = (0..CONSTRAINTS).filter(|i| *i != NORMAL);
            for (parameter, i) in others.enumerate() {
                jacobian[(row + i, column + parameter)] = 1.0;
            }
            jacobian[(row + NORMAL, held)] = 1.0;
            continue;
        }
        let wheel = own.model.wheel(contact_index(own.index, side));
        let found = wheel.pair(own.model, &motion).point_contact(&parameters(values, column));
        residual.fixed_rows_mut::<CONSTRAINTS>(row).copy_from(&found.residual);
        jacobian.fixed_view_mut::<CONSTRAINTS, PARAMETERS>(row, column).copy_from(&found.by_parameters);
        for i in 0..CONSTRAINTS {
            let mut coefficients = motion.coefficients(&found.by_velocity[i], &found.by_rotation[i]);
            if let Some(axes) = &own.axes {
                let linear = axes.tr_mul(&found.by_velocity[i]);
                coefficients.fixed_rows_mut::<3>(0).copy_from(&linear);
            }
            jacobian.fixed_view_mut::<1, COORDINATES>(row + i, 0).copy_from(&coefficients.transpose());
        }
    }
    (residual, jacobian)
}

fn parameters(values: &Variables, column: usize) -> Vector4<f64> {
    values.fixed_rows::<PARAMETERS>(column).into_owned()
}
