//! A wheelset's variables between state and constraints: coordinates first, then the surface parameters of both wheels.

use super::super::loading::pair;
use super::super::rigid::is_elastic;
use super::super::{Model, Wheelset, contact_index};
use super::NORMAL;
use super::partition::{Jacobian, Rows, Variables};
use crate::contact::search::point_contact::{CONSTRAINTS, PARAMETERS};
use crate::geometry::Side;
use crate::mbs::body::{BodyMotion, COORDINATES};
use nalgebra::{Matrix3, Vector4};

/// Axes along which a wheelset's x, y, z are counted; `None`: those of the world.
pub(super) type Axes = Option<Matrix3<f64>>;

/// Counts x, y, z along the axes, or in the world again (`back`).
fn turn(values: &mut Variables, axes: &Axes, back: bool) {
    let Some(axes) = axes else { return };
    let linear = values.fixed_rows::<3>(0).into_owned();
    values.fixed_rows_mut::<3>(0).copy_from(&if back { axes * linear } else { axes.tr_mul(&linear) });
}

/// A wheelset's variables and their rates from the state.
pub(super) fn gather(model: &Model, (index, wheelset): (usize, &Wheelset), axes: &Axes, y: &[f64]) -> (Variables, Variables) {
    let (mut values, mut rates) = (Variables::zeros(), Variables::zeros());
    values.as_mut_slice()[..COORDINATES].copy_from_slice(&y[model.system.coordinates(wheelset.body)]);
    rates.as_mut_slice()[..COORDINATES].copy_from_slice(&y[model.system.velocities(wheelset.body)]);
    for (side, offset) in [(Side::Left, COORDINATES), (Side::Right, COORDINATES + PARAMETERS)] {
        let states = &y[model.contact_states(contact_index(index, side))];
        values.as_mut_slice()[offset..offset + PARAMETERS].copy_from_slice(&states[..PARAMETERS]);
        rates.as_mut_slice()[offset..offset + PARAMETERS].copy_from_slice(&states[PARAMETERS..]);
    }
    turn(&mut values, axes, false);
    turn(&mut rates, axes, false);
    (values, rates)
}

/// Puts a wheelset's variables and rates back into the state.
pub(super) fn scatter(
    model: &Model,
    (index, wheelset): (usize, &Wheelset),
    axes: &Axes,
    mut values: Variables,
    mut rates: Variables,
    y: &mut [f64],
) {
    turn(&mut values, axes, true);
    turn(&mut rates, axes, true);
    y[model.system.coordinates(wheelset.body)].copy_from_slice(&values.as_slice()[..COORDINATES]);
    y[model.system.velocities(wheelset.body)].copy_from_slice(&rates.as_slice()[..COORDINATES]);
    for (side, offset) in [(Side::Left, COORDINATES), (Side::Right, COORDINATES + PARAMETERS)] {
        let states = &mut y[model.contact_states(contact_index(index, side))];
        states[..PARAMETERS].copy_from_slice(&values.as_slice()[offset..offset + PARAMETERS]);
        states[PARAMETERS..].copy_from_slice(&rates.as_slice()[offset..offset + PARAMETERS]);
    }
}

/// Residual and Jacobian of a wheelset's ten constraints. A contact that is elastic at present has none: its surface parameters are
/// held (the place that they belonged to may be about to cease), and one coordinate that no contact determines (pitch or x).
pub(super) fn constraints(
    model: &Model,
    (index, wheelset): (usize, &Wheelset),
    axes: &Axes,
    memory: &[f64],
    values: &Variables,
) -> (Rows, Jacobian) {
    let mut world = *values;
    turn(&mut world, axes, true);
    let motion = BodyMotion::new(&world.as_slice()[..COORDINATES], &[0.0; COORDINATES]);
    let (mut residual, mut jacobian) = (Rows::zeros(), Jacobian::zeros());
    for (side, row, column, held) in
        [(Side::Left, 0, COORDINATES, COORDINATES - 1), (Side::Right, CONSTRAINTS, COORDINATES + PARAMETERS, 0)]
    {
        if is_elastic(&memory[model.contact_memory(contact_index(index, side))]) {
            let others = (0..CONSTRAINTS).filter(|i| *i != NORMAL);
            for (parameter, i) in others.enumerate() {
                jacobian[(row + i, column + parameter)] = 1.0;
            }
            jacobian[(row + NORMAL, held)] = 1.0;
            continue;
        }
        let found = pair(model, wheelset, side, &motion).point_contact(&parameters(values, column));
        residual.fixed_rows_mut::<CONSTRAINTS>(row).copy_from(&found.residual);
        jacobian.fixed_view_mut::<CONSTRAINTS, PARAMETERS>(row, column).copy_from(&found.by_parameters);
        for i in 0..CONSTRAINTS {
            let mut coefficients = motion.coefficients(&found.by_velocity[i], &found.by_rotation[i]);
            if let Some(axes) = axes {
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
