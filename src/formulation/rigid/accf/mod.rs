//! ACCF: contact as augmented constraints (Eqs. 9-14 of the paper).
//!
//! Five constraints per contact (Eq. 10 with its missing fifth row); the surface parameters s are coordinates without inertia, so
//! that coordinates, surface parameters and multipliers solve Eq. 13 together:
//!
//! ```text
//! M q'' + C_q^T lambda = Q,   C_s^T lambda = 0,   C_q q'' + C_s s'' = Q_c
//! ```
//!
//! C_s is block-diagonal, one 5 x 4 block per contact, so Eq. 13 is solved block by block: the second equation leaves one free
//! multiplier per contact, `lambda = w mu` with the vector w that spans the null space of C_s^T (its components are the 4 x 4
//! minors of C_s, none preferred), and `w . C_q q'' = w . Q_c` is one row in the coordinates. With w scaled such that the
//! normal's row has `w_3 |m| = 1`, mu is minus the normal force. s'' follows from the four constraints left.
//!
//! Independent variables (coordinates or surface parameters, see `partition`) are integrated; the dependent ones follow from the
//! constraints in every evaluation, on position level by Newton iteration, on velocity level linearly. The partition is made
//! per wheelset: contact constraints tie no two wheelsets to each other.
//!
//! On a curved track a wheelset's x, y, z are counted along the track frame's axes beside it, so that what is independent does not depend
//! on the heading and an imposed speed stays out of the constraints' reach.
//!
//! Where a rail's second derivative jumps (the end of a deviation), the rates of surface parameters jump while the coordinates'
//! do not: within 20 ms of such a place coordinates are the independent variables; elsewhere pivoting chooses, and prefers coordinates as
//! independent ones ten to one: with a parameter in the place of y an error of 1e-5 m in it pulls at the suspension, however stiff that is.
//! The same rates jump
//! where the curvature of a profile does. A contact may stand at such a joint for long (S1002 on 60E1: 0.3 mm beside one at the
//! place to which it jumps), so that on a pair of profiles with joints coordinates are independent all the time.
//!
//! States per contact: u, angle, s, eta (s along the track) and their rates.

mod variables;

use super::projection;
use super::row::locate;
use super::{evaluation, modes};
use crate::contact::search::algebraic::SurfaceParameters;
use crate::contact::search::point_contact::{CONSTRAINTS, PARAMETERS, ParameterJacobian, PointContact, Residual};
use crate::formulation::memory::ChosenPartition;
use crate::formulation::partition::{Jacobian, Partition, Rows, conditioning};
use crate::formulation::rigid_scratch::ConstraintRow;
use crate::formulation::step::{Step, WheelRef};
use crate::formulation::{
    Build, ContactFailure, Evaluation, EvaluationError, Formulation, Model, OnLift, Parse, Parts, Wheelset, Workspace, contact_index,
};
use crate::geometry::Side;
use crate::math::newton::{self, NewtonLimits};
use crate::mbs::body::COORDINATES;
use crate::mbs::kkt::Coefficients;
use crate::settings::{Entry, Section, SettingsError};
use nalgebra::{Matrix3, Matrix4, Vector4};
use std::sync::Arc;
use variables::{OfWheelset, constraints, gather, scatter};

pub(in crate::formulation) const ENTRY: Entry<Parse> = Entry {
    name: "ACCF",
    summary: "contact as five constraints, surface parameters as further coordinates, independent ones picked by pivoting",
    reference: "paper, section 3.2, Eqs. 9-14",
    parse,
};

fn parse(section: &Section) -> Result<Build, SettingsError> {
    let on_lift = modes::parse(section)?;
    Ok(Arc::new(move |parts: &Parts| {
        let joints = parts.wheelsets.iter().map(|wheelset| {
            Side::BOTH.into_iter().any(|side| {
                let profiles = [&wheelset.wheel(side).profile, &parts.track.rail(side).profile];
                profiles.iter().any(|profile| !profile.joints().is_empty())
            })
        });
        Ok(Box::new(Accf { on_lift, joints: joints.collect() }))
    }))
}

#[derive(Debug)]
struct Accf {
    on_lift: OnLift,
    /// Per wheelset: does the curvature of one of its profiles jump?
    joints: Vec<bool>,
}

/// Surface parameters and their rates.
const STATES: usize = 2 * PARAMETERS;
/// A partition is given up when its conditioning has fallen to this part of what it was.
const WORSE: f64 = 0.5;

/// Steps below this (m, rad) end the iteration on position level; a residual at the rounding does where a place of contact is about
/// to cease and Newton's steps of rounding are long.
const POSITION: NewtonLimits = NewtonLimits { next_step: 1e-13, iterations: 12, rounding: 1e-12 };

impl Formulation for Accf {
    fn describe(&self) -> String {
        format!("constraint, five multipliers per wheel, surface parameters as states; {} (contact.on_lift)", self.on_lift.describe())
    }

    fn states_per_contact(&self) -> usize {
        STATES
    }

    fn on_lift(&self) -> Option<OnLift> {
        Some(self.on_lift)
    }

    fn start(&self, step: &mut Step) -> Result<(), EvaluationError> {
        modes::start(step);
        self.resettle(step)
    }

    fn derivative(&self, model: &Model, workspace: &mut Workspace, at: Evaluation, dy: &mut [f64]) -> Result<(), EvaluationError> {
        let Evaluation { t, inputs, y, memory } = at;
        // The dependent part of y only starts the iteration: the equations hold at the point that the constraints give.
        let mut consistent = std::mem::take(&mut workspace.rigid.consistent);
        consistent.copy_from_slice(y);
        let done = evaluate(&mut model.at(workspace, t, &mut consistent, memory), inputs, dy);
        workspace.rigid.consistent = consistent;
        done
    }

    /// Writes the dependent variables into `y`. An evaluation before and after it gives the same: it says `false`, unless variables that were
    /// dependent become independent, which then go on from what the constraints give.
    fn project(&self, step: &mut Step) -> Result<bool, EvaluationError> {
        let mut chosen = false;
        for index in 0..step.model.wheelsets.len() {
            let jacobian = close(step, index)?;
            idle(step, index);
            let crossing = self.joints[index] || crosses_break(step.model, index, step.y);
            let worse = |known: &ChosenPartition| match known.conditioning {
                None => !crossing,
                Some(then) => crossing || conditioning(&known.partition.block(&jacobian)) < WORSE * then,
            };
            if step.memory.partitions[index].as_ref().is_none_or(worse) {
                choose(step, index, &jacobian, crossing)?;
                step.workspace.work.partitions += 1;
                chosen = true;
            }
        }
        Ok(chosen)
    }

    /// The local error of independent variables is controlled; while a wheel is elastic that of all coordinates.
    fn error_weight(&self, model: &Model, workspace: &Workspace, i: usize, plain: f64) -> f64 {
        let plain = modes::error_weight(model, workspace, i, plain);
        let count = model.contact_states_begin;
        let dependent = |wheelset: usize, variable: usize| {
            workspace.rigid.partitions[wheelset].is_some_and(|p: Partition| p.is_dependent(variable))
                && Side::BOTH.into_iter().all(|side| workspace.contacts[contact_index(wheelset, side)].constrained)
        };
        if i >= count + model.contacts() * STATES {
            return plain;
        }
        if i >= count {
            let (contact, state) = ((i - count) / STATES, (i - count) % STATES);
            let variable = COORDINATES + contact % 2 * PARAMETERS + state;
            let integrated = state < PARAMETERS && workspace.contacts[contact].constrained && !dependent(contact / 2, variable);
            return if integrated { plain } else { 0.0 };
        }
        let owner = model.wheelsets.iter().position(|wheelset| i / COORDINATES == wheelset.body);
        match owner {
            // On a curved track x and y of the world are no coordinates of the constraints.
            Some(_) if i % COORDINATES < 2 && model.track.line().is_some() => plain,
            Some(wheelset) if plain == 1.0 && dependent(wheelset, i % COORDINATES) => 0.0,
            _ => plain,
        }
    }

    /// Steps end where the independent variables have to change.
    fn next_break(&self, model: &Model, t: f64, y: &[f64]) -> f64 {
        let times = model.wheels().filter_map(|WheelRef { contact, side, .. }| {
            let own = &y[model.contact_states(contact)];
            let (s, speed) = (own[DISTANCE], own[PARAMETERS + DISTANCE]);
            let ahead = model.track.rail(side).distance_to_break(s, speed)? - CROSSING * speed.abs();
            (ahead > 0.0).then(|| t + (ahead + INSIDE) / speed.abs())
        });
        times.fold(f64::INFINITY, f64::min)
    }

    /// Brings the coordinates onto the constraints without regard to a partition (mass-weighted, as in ECCF), takes the surface
    /// parameters from the located contacts and chooses a partition.
    fn resettle(&self, step: &mut Step) -> Result<(), EvaluationError> {
        projection::project(step)?;
        step.move_bodies();
        let (model, t) = (step.model, step.t);
        for wheel in model.wheels() {
            let memory = &mut step.memory.wheels[wheel.contact];
            if memory.mode.is_elastic() {
                continue;
            }
            let motion = &step.workspace.system.motions[wheel.wheelset.body];
            let found = locate(model, wheel, motion, memory).map_err(|cause| wheel.error(t, cause))?;
            let p = found.location.parameters;
            let states = &mut step.y[model.contact_states(wheel.contact)];
            states[..PARAMETERS].copy_from_slice(&[p.wheel, p.angle, p.lead + motion.distance, p.rail]);
            states[PARAMETERS..].copy_from_slice(found.parameter_rates.as_slice());
        }
        for index in 0..model.wheelsets.len() {
            idle(step, index);
            let own = OfWheelset::new(model, index, step.y, step.memory);
            let (variables, _) = gather(&own, step.y);
            let (_, jacobian) = constraints(&own, &variables);
            let crossing = self.joints[index] || crosses_break(model, index, step.y);
            choose(step, index, &jacobian, crossing)?;
        }
        Ok(())
    }
}

/// The states of a wheel that is elastic at present take no part in anything but the way to the next break of its rail: they travel
/// with the wheelset.
fn idle(step: &mut Step, index: usize) {
    for side in Side::BOTH {
        let contact = contact_index(index, side);
        if !step.memory.wheels[contact].mode.is_elastic() {
            continue;
        }
        step.move_bodies();
        let motion = &step.workspace.system.motions[step.model.wheelsets[index].body];
        let states = &mut step.y[step.model.contact_states(contact)];
        states[DISTANCE] = motion.distance;
        states[PARAMETERS..].fill(0.0);
        states[PARAMETERS + DISTANCE] = motion.speed;
    }
}

/// Is one of a wheelset's contacts near a place where its rail is not smooth?
fn crosses_break(model: &Model, index: usize, y: &[f64]) -> bool {
    Side::BOTH.into_iter().any(|side| {
        let states = &y[model.contact_states(contact_index(index, side))];
        model.track.rail(side).has_break_near(states[DISTANCE], CROSSING * states[PARAMETERS + DISTANCE].abs())
    })
}

/// Half the time of a crossing, s.
const CROSSING: f64 = 0.02;
/// How far inside the crossing the step that reaches it ends, m: the contact may move a little on its wheel meanwhile.
const INSIDE: f64 = 1e-5;

/// Place of s among the surface parameters.
const DISTANCE: usize = 2;

/// How much more columns of surface parameters weigh in the choice of dependent variables: in general, and where coordinates must be
/// independent.
const PREFERRED: f64 = 10.0;
const ALWAYS: f64 = 1e4;

/// Chooses a wheelset's partition. One for a crossing ends with it.
fn choose(step: &mut Step, index: usize, jacobian: &Jacobian, crossing: bool) -> Result<(), EvaluationError> {
    let wheelset = &step.model.wheelsets[index];
    let mut free = *jacobian;
    if step.model.system.drives.iter().any(|drive| drive.body == wheelset.body) {
        // x is given: constraints must not change it. (Where an elastic contact's row holds x itself, that entry stays.)
        let held = free[(CONSTRAINTS + NORMAL, 0)];
        let holds = free.row(CONSTRAINTS + NORMAL).norm() == held.abs();
        free.column_mut(0).fill(0.0);
        free[(CONSTRAINTS + NORMAL, 0)] = if holds { held } else { 0.0 };
    }
    let partition = Partition::choose(&free, if crossing { ALWAYS } else { PREFERRED });
    let partition = partition.ok_or_else(|| EvaluationError::new(step.t, wheelset, least_certain(jacobian), ContactFailure::Dependent))?;
    let conditioning = (!crossing).then(|| conditioning(&partition.block(jacobian)));
    step.memory.partitions[index] = Some(ChosenPartition { partition, conditioning });
    Ok(())
}

/// The row of Eq. 10 along the normal.
const NORMAL: usize = 2;

/// Makes a wheelset's dependent variables and rates satisfy the constraints; returns the Jacobian there.
fn close(step: &mut Step, index: usize) -> Result<Jacobian, EvaluationError> {
    let (model, t) = (step.model, step.t);
    let wheelset = &model.wheelsets[index];
    let own = OfWheelset::new(model, index, step.y, step.memory);
    let dependent = || EvaluationError::new(t, wheelset, Side::Left, ContactFailure::Dependent);
    let partition = step.memory.partitions[index].ok_or_else(dependent)?.partition;
    let (mut values, mut rates) = gather(&own, step.y);
    let base = values;
    let at = |change: &Rows| {
        let mut values = base;
        partition.add(&mut values, change);
        values
    };
    let mut change = Rows::zeros();
    let evaluate = |change: &Rows| constraints(&own, &at(change));
    let q = &step.y[model.system.coordinates(wheelset.body)];
    // Distances along the rail are among the variables: they are known to the rounding of the way travelled, on straight track too.
    let rounding = model.rounding(q).max(8.0 * f64::EPSILON * q[0].abs());
    let limits = NewtonLimits { next_step: POSITION.next_step.max(rounding), rounding: POSITION.rounding.max(rounding), ..POSITION };
    let uncertain = |jacobian: &Jacobian| {
        if own.elastic[0] == own.elastic[1] { least_certain(jacobian) } else { Side::BOTH[usize::from(own.elastic[0])] }
    };
    let solved = newton::solve(&mut change, limits, evaluate, |_, jacobian| partition.block(jacobian));
    let (jacobian, iterations) = match solved {
        Ok(solved) => solved,
        Err(failure) => {
            let (rest, jacobian) = evaluate(&change);
            let (iterations, y_wheelset) = (failure.iterations, base[1]);
            let certain = lost(step, wheelset, 0.0).or_else(|| {
                let cause = ContactFailure::NotFound { iterations, residual: failure.residual, y: y_wheelset };
                unplaced(&rest).map(|side| EvaluationError::new(t, wheelset, side, cause))
            });
            let certain = certain.or_else(|| AHEAD.iter().find_map(|ahead| lost(step, wheelset, *ahead)));
            return Err(certain.unwrap_or_else(|| {
                let cause = ContactFailure::NotClosed { iterations, gap: failure.residual, y: y_wheelset };
                EvaluationError::new(t, wheelset, uncertain(&jacobian), cause)
            }));
        }
    };
    step.workspace.work.constraint_iterations += iterations as u64;
    values = at(&change);
    let mut excess: Rows = jacobian * rates;
    for side in Side::BOTH.into_iter().filter(|side| own.elastic[side.index()]) {
        excess.fixed_rows_mut::<CONSTRAINTS>(CONSTRAINTS * side.index()).fill(0.0);
    }
    if !partition.block(&jacobian).lu().solve_mut(&mut excess) {
        return Err(EvaluationError::new(t, wheelset, uncertain(&jacobian), ContactFailure::Dependent));
    }
    partition.add(&mut rates, &-excess);
    scatter(&own, values, rates, step.y);
    step.workspace.rigid.partitions[index] = Some(partition);
    Ok(jacobian)
}

/// Which wheel has lost its place, or will have `ahead` [s]: contacts of a wheelset are closed together here, but ECCF's projection locates each
/// on its own.
fn lost(step: &mut Step, wheelset: &Wheelset, ahead: f64) -> Option<EvaluationError> {
    let (mut moved, mut memory) = (step.y.to_vec(), step.memory.clone());
    for (coordinate, rate) in step.model.system.coordinates(wheelset.body).zip(step.model.system.velocities(wheelset.body)) {
        moved[coordinate] += ahead * step.y[rate];
    }
    let failure = projection::project(&mut step.model.at(step.workspace, step.t, &mut moved, &mut memory)).err()?;
    (failure.wheelset == wheelset.name && matches!(failure.cause, ContactFailure::NotFound { .. })).then_some(failure)
}

/// Where both contacts are closed to rounding but Newton's method fails beside a corner of curvature: how far ahead the wheel is looked for
/// that loses its place, s.
const AHEAD: [f64; 4] = [1e-7, 1e-6, 1e-5, 1e-4];

/// The side whose surfaces are not parallel yet, or not above each other, where the other one's are: its place ends at a corner of curvature.
fn unplaced(residual: &Rows) -> Option<Side> {
    const CLEARLY: f64 = 3.0;
    let size = |begin: usize| (0..CONSTRAINTS).filter(|row| *row != NORMAL).map(|row| residual[begin + row].abs()).fold(0.0, f64::max);
    let (left, right) = (size(0), size(CONSTRAINTS));
    if left > CLEARLY * right { Some(Side::Left) } else { (right > CLEARLY * left).then_some(Side::Right) }
}

/// The side whose contact's place is least certain: where it ceases to exist the determinant of its equations falls to zero.
fn least_certain(jacobian: &Jacobian) -> Side {
    let certainty =
        |row: usize, column: usize| minor(&jacobian.fixed_view::<CONSTRAINTS, PARAMETERS>(row, column).into_owned(), NORMAL).abs();
    if certainty(0, COORDINATES) <= certainty(CONSTRAINTS, COORDINATES + PARAMETERS) { Side::Left } else { Side::Right }
}

/// The equations of motion at a state that is made consistent first.
fn evaluate(step: &mut Step, inputs: &[f64], dy: &mut [f64]) -> Result<(), EvaluationError> {
    for index in 0..step.model.wheelsets.len() {
        close(step, index)?;
    }
    step.move_bodies();
    let Step { model, workspace, t, y, memory } = step;
    let y: &[f64] = y;
    let mut points = std::mem::take(&mut workspace.rigid.points);
    points.clear();
    for wheel in model.wheels() {
        if memory.wheels[wheel.contact].mode.is_elastic() {
            points.push(None);
            continue;
        }
        let own = &y[model.contact_states(wheel.contact)];
        let motion = &workspace.system.motions[wheel.wheelset.body];
        let pair = wheel.pair(model, motion);
        let found = pair.point_contact(&Vector4::from_column_slice(&own[..PARAMETERS]));
        let bias = pair.bias(&found, &Vector4::from_column_slice(&own[PARAMETERS..]), &motion.carrier());
        points.push(Some((found, bias)));
    }
    let done = evaluation::derivative(model, workspace, Evaluation { t: *t, inputs, y, memory }, dy, |wheel, motion, memory| {
        let own = &y[model.contact_states(wheel.contact)];
        let (found, bias) = points[wheel.contact].as_ref().ok_or(ContactFailure::Dependent)?;
        memory.set_start(SurfaceParameters { wheel: own[0], angle: own[1], lead: own[2] - motion.distance, rail: own[3] });
        let weights = free_multiplier(found).ok_or(ContactFailure::Dependent)?;
        let mut row = Coefficients::zeros();
        for (i, weight) in weights.iter().enumerate() {
            row += motion.coefficients(&found.by_velocity[i], &found.by_rotation[i]) * *weight;
        }
        let rates = [own[PARAMETERS], own[PARAMETERS + 3]];
        Ok(ConstraintRow { location: wheel.pair(model, motion).location(found), row, bias: weights.dot(bias), rates })
    });
    let done = done.and_then(|()| parameter_derivatives(model, workspace, *t, y, &points, dy));
    workspace.rigid.points = points;
    done
}

/// Derivatives of the surface parameters and of their rates: s'' from the constraints (Eq. 12), now that the coordinates'
/// accelerations are known.
fn parameter_derivatives(
    model: &Model,
    workspace: &Workspace,
    t: f64,
    y: &[f64],
    points: &[Option<(PointContact, Residual)>],
    dy: &mut [f64],
) -> Result<(), EvaluationError> {
    for (wheel, point) in model.wheels().zip(points) {
        let range = model.contact_states(wheel.contact);
        dy[range.start..range.start + PARAMETERS].copy_from_slice(&y[range.start + PARAMETERS..range.end]);
        dy[range.start + PARAMETERS..range.end].fill(0.0);
        let Some((found, bias)) = point else { continue };
        let motion = &workspace.system.motions[wheel.wheelset.body];
        let accelerations = Coefficients::from_column_slice(&dy[model.system.velocities(wheel.wheelset.body)]);
        let mut rest = *bias;
        for i in 0..CONSTRAINTS {
            rest[i] += motion.coefficients(&found.by_velocity[i], &found.by_rotation[i]).dot(&accelerations);
        }
        let accelerations = parameter_accelerations(found, &rest).ok_or_else(|| wheel.error(t, ContactFailure::Dependent))?;
        dy[range.start + PARAMETERS..range.end].copy_from_slice(accelerations.as_slice());
    }
    Ok(())
}

/// The minor of C_s without row `out`: expanded along a row, not factorised, because a motion that has died away leaves pivots below 1e-308,
/// whose reciprocals overflow.
fn minor(by_parameters: &ParameterJacobian, out: usize) -> f64 {
    let rows = without(by_parameters, out);
    let cofactor = |column: usize| {
        let rest: Matrix3<f64> = rows.remove_row(0).remove_column(column);
        if column.is_multiple_of(2) { rest.determinant() } else { -rest.determinant() }
    };
    (0..PARAMETERS).map(|column| rows[(0, column)] * cofactor(column)).sum()
}

/// The four rows of C_s that are left without row `out`.
fn without(by_parameters: &ParameterJacobian, out: usize) -> Matrix4<f64> {
    Matrix4::from_fn(|row, column| by_parameters[(row + usize::from(row >= out), column)])
}

/// Multipliers `w` with `C_s^T w = 0` (Eq. 14), scaled such that they press with 1 N along the normal.
fn free_multiplier(contact: &PointContact) -> Option<Residual> {
    let minors = Residual::from_fn(|row, _| {
        let minor = minor(&contact.by_parameters, row);
        if row % 2 == 0 { minor } else { -minor }
    });
    let pressing = minors[NORMAL] * contact.normal_length();
    (pressing != 0.0).then(|| minors / pressing)
}

/// s'' from `C_s s'' = -rest`: four rows serve, the one along the normal holds by itself (it has no part in C_s).
fn parameter_accelerations(contact: &PointContact, rest: &Residual) -> Option<Vector4<f64>> {
    let inverse = without(&contact.by_parameters, NORMAL).try_inverse()?;
    Some(-(inverse * Vector4::from_fn(|row, _| rest[row + usize::from(row >= NORMAL)])))
}
