//! Preloads from balance: `preload = "static"` of a force element.
//!
//! The vehicle stands at rest on straight level track in its design configuration. On the bodies that are no wheelsets act weights,
//! given preloads and other forces, together the generalised force b (six numbers per body), the preloads f [N] that are to be found, with
//! the columns A, and the joints, with multipliers l and rows G:
//!
//! ```text
//! A f + G^T l + b = 0,   sum of f_i^2 / k_i  least
//! ```
//!
//! k_i is the element's stiffness. These are the forces with which the vehicle would stand if it were set down on springs without preload
//! and found its place but for its displacements (least complementary energy), so that springs side by side share a load as their
//! stiffnesses do. With D = diag(k) the solution is `f = -D A^T x`, `(A D A^T + c G^T G) x = b`; joints count as springs of c, far stiffer than all
//! others. Wheelsets have no equations but one: the rails hold them, and they roll freely along the track. Where given preloads
//! pull one along the track, nothing is asked of that. A body that the found forces leave out of balance is an error.

use super::VehicleSpec;
use super::design::design_state;
use crate::formulation::AssemblyError;
use crate::mbs::body::{COORDINATES, Wrench};
use crate::mbs::carried::{generalised, joint_rows};
use crate::mbs::system::System;
use nalgebra::{DMatrix, DVector};

/// Joints are stiffer than the stiffest spring by this.
const STIFFER: f64 = 1e4;
/// Rest of a force or moment, as a share of the whole weight (times 1 m), that is none.
const BALANCED: f64 = 1e-9;
/// What pulls less is a rounding, N.
const PULLS: f64 = 1.0;
/// A body has its part in what is left from this share of the largest on; so many of them are named.
const SHARED: f64 = 1e-3;
const NAMED: usize = 3;
/// Eigenvalues below this share of the largest are zero: nothing holds a body that way.
const FREE: f64 = 1e-13;

/// Element, index and force [N] of each preload that is asked for.
///
/// # Errors
/// [`AssemblyError::StaticPreload`], and [`AssemblyError::StaticPull`] where an element would have to do what it can't.
pub(super) fn found(vehicle: &VehicleSpec, system: &System) -> Result<Vec<(usize, usize, f64)>, AssemblyError> {
    match solved(vehicle, system, true) {
        Err(AssemblyError::StaticPreload { .. }) => solved(vehicle, system, false),
        found => found,
    }
}

/// The same, with wheelsets that roll freely or that the rails hold along the track too.
fn solved(vehicle: &VehicleSpec, system: &System, free: bool) -> Result<Vec<(usize, usize, f64)>, AssemblyError> {
    let asked: Vec<(usize, usize, f64)> = (system.forces.iter().enumerate())
        .flat_map(|(element, force)| force.static_stiffness().into_iter().enumerate().map(move |(index, k)| (element, index, k)))
        .filter(|(_, _, k)| *k > 0.0)
        .collect();
    if asked.is_empty() {
        return Ok(Vec::new());
    }
    let mut y = design_state(vehicle, system, 0.0);
    let mut workspace = system.workspace(&[]);
    system.settle_forces(&mut y, &mut workspace);
    system.apply_forces(&y, &mut workspace);
    system.fold_wheels(&mut workspace);
    let first = vehicle.wheelsets.len();
    let free = if free { first } else { 0 };
    let along = |wrenches: &[Wrench]| {
        let wheelsets = workspace.motions.iter().zip(wrenches).take(free);
        let rolling: Vec<f64> = wheelsets.map(|(motion, wrench)| motion.generalised_force(wrench)[0]).collect();
        let held = generalised(system, first, &workspace, wrenches);
        DVector::from_iterator(held.len() + rolling.len(), held.iter().copied().chain(rolling))
    };
    let load = along(&workspace.wrenches);
    let mut a = DMatrix::zeros(load.len(), asked.len());
    for (column, (element, index, _)) in asked.iter().enumerate() {
        let states = &y[system.states_of_force(*element)];
        let wrenches = |preload: f64| {
            let mut element = system.forces[*element].clone_box();
            element.set_preload(*index, preload);
            let (mut wrenches, mut rates) = (vec![Wrench::default(); system.bodies.len()], vec![0.0; states.len()]);
            element.apply(&workspace.moving(), states, &mut rates, &mut wrenches);
            along(&wrenches)
        };
        a.set_column(column, &(wrenches(1.0) - wrenches(0.0)));
    }
    let stiffest = asked.iter().map(|(_, _, k)| *k).fold(0.0, f64::max);
    let mut columns = a.clone();
    for (mut column, (_, _, k)) in columns.column_iter_mut().zip(&asked) {
        column *= k.sqrt();
    }
    let rows = joint_rows(system, (first, free), &workspace);
    let matrix = &columns * columns.transpose() + &rows * rows.transpose() * (STIFFER * stiffest);
    let eigen = matrix.symmetric_eigen();
    let least = FREE * eigen.eigenvalues.amax();
    // Twice: the second round takes off what rounding of the stiff joints leaves.
    let (mut forces, mut rest) = (DVector::zeros(asked.len()), load.clone());
    for _ in 0..3 {
        let weighed =
            eigen.eigenvectors.tr_mul(&rest).zip_map(&eigen.eigenvalues, |part, value| if value > least { part / value } else { 0.0 });
        let x = &eigen.eigenvectors * weighed;
        let own = DVector::from_iterator(asked.len(), a.tr_mul(&x).iter().zip(&asked).map(|(part, (_, _, k))| -k * part));
        rest += &a * &own - &rows * rows.tr_mul(&x) * (STIFFER * stiffest);
        forces += own;
    }
    let (worst, left) =
        rest.iter().enumerate().fold((0, 0.0), |most: (usize, f64), (i, rest)| if rest.abs() > most.1.abs() { (i, *rest) } else { most });
    if !(left.abs() <= BALANCED * vehicle.weight().max(load.amax())) {
        let (body, left) = unheld(vehicle, &rest, (worst, left));
        let direction = ["along the track", "to the side", "vertically", "in yaw", "in roll", "in pitch"][worst % COORDINATES];
        let unit = if worst % COORDINATES < 3 { "N" } else { "N m" };
        return Err(AssemblyError::StaticPreload { body, direction, rest: left, unit });
    }
    let pulls = asked.iter().zip(forces.iter()).find(|((element, ..), force)| **force > PULLS && system.forces[*element].pushes_alone());
    if let Some(((element, ..), force)) = pulls {
        return Err(AssemblyError::StaticPull { element: system.forces[*element].name().to_string(), force: *force });
    }
    Ok(asked.iter().zip(forces.iter()).map(|((element, index, _), force)| (*element, *index, *force)).collect())
}

/// Whom the preloads that are asked for don't hold, and what is left: the least squares of the balance spread it over all bodies between which they act, of which each could hand it on.
fn unheld(vehicle: &VehicleSpec, rest: &DVector<f64>, (worst, left): (usize, f64)) -> (String, f64) {
    let direction = worst % COORDINATES;
    let shared = |body: &usize| rest[COORDINATES * body + direction].abs() > SHARED * left.abs();
    let held_by: Vec<usize> = if direction < 3 { (0..vehicle.bodies.len()).filter(shared).collect() } else { vec![worst / COORDINATES] };
    let names: Vec<&str> = held_by.iter().filter_map(|body| Some(vehicle.bodies.get(*body)?.body.name.as_str())).collect();
    let sum = held_by.iter().filter_map(|body| rest.get(COORDINATES * body + direction)).sum();
    match names.as_slice() {
        [one] => ((*one).into(), sum),
        [some @ .., last] if some.len() <= NAMED => (format!("{} and {last} together", some.join(", ")), sum),
        some => {
            (format!("{} and {} more bodies together", some[..NAMED.min(some.len())].join(", "), some.len() - NAMED.min(some.len())), sum)
        }
    }
}
