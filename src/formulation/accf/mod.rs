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
//! States per contact: u, angle, s, eta (s along the track) and their rates. Memory per contact: that of `rigid`, and in the left
//! contact's the partition and the conditioning that it had when it was chosen.

mod partition;
mod variables;

use super::lift::{self, OnLift};
use super::loading::{keep, pair};
use super::rigid::{self, ConstraintRow, is_elastic, wheels};
use super::{Build, ContactFailure, Evaluation, EvaluationError, Formulation, Model, Parts, Wheelset, Workspace, contact_index, eccf};
use crate::contact::search::algebraic::SurfaceParameters;
use crate::contact::search::point_contact::{CONSTRAINTS, PARAMETERS, ParameterJacobian, PointContact, Residual};
use crate::geometry::Side;
use crate::math::newton::{self, NewtonLimits};
use crate::mbs::body::COORDINATES;
use crate::mbs::kkt::Coefficients;
use crate::settings::{Entry, Section, SettingsError};
use nalgebra::{Matrix4, Vector4};
pub(super) use partition::Partition;
use partition::{Jacobian, Rows, conditioning};
use std::sync::Arc;
use variables::{constraints, gather, scatter};

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "ACCF",
    summary: "contact as five constraints, surface parameters as further coordinates, independent ones picked by pivoting",
    reference: "paper, section 3.2, Eqs. 9-14",
    parse,
};

fn parse(section: &Section) -> Result<Build, SettingsError> {
    let on_lift = lift::parse(section)?;
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
/// Places in the left contact's memory.
const PARTITION: usize = rigid::MEMORY;
const CONDITIONING: usize = rigid::MEMORY + 1;
const MEMORY: usize = rigid::MEMORY + 2;

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

    fn memory_per_contact(&self) -> usize {
        MEMORY
    }

    fn on_lift(&self) -> Option<OnLift> {
        Some(self.on_lift)
    }

    fn start(&self, model: &Model, workspace: &mut Workspace, t: f64, y: &mut [f64], memory: &mut [f64]) -> Result<(), EvaluationError> {
        lift::start(model, workspace, y, memory);
        self.reset(model, workspace, t, y, memory)
    }

    fn derivative(&self, model: &Model, workspace: &mut Workspace, at: Evaluation, dy: &mut [f64]) -> Result<(), EvaluationError> {
        let Evaluation { t, inputs, y, memory } = at;
        // The dependent part of y only starts the iteration: the equations hold at the point that the constraints give.
        let mut consistent = std::mem::take(&mut workspace.rigid.consistent);
        consistent.copy_from_slice(y);
        let done = evaluate(model, workspace, t, inputs, &mut consistent, memory, dy);
        workspace.rigid.consistent = consistent;
        done
    }

    /// Writes the dependent variables into `y`. An evaluation before and after it gives the same: it says `false`, unless variables that were
    /// dependent become independent, which then go on from what the constraints give.
    fn project(
        &self,
        model: &Model,
        workspace: &mut Workspace,
        t: f64,
        y: &mut [f64],
        memory: &mut [f64],
    ) -> Result<bool, EvaluationError> {
        let mut chosen = false;
        for (index, wheelset) in model.wheelsets.iter().enumerate() {
            let jacobian = close(model, workspace, index, wheelset, t, y, memory)?;
            idle(model, workspace, index, wheelset, y, memory);
            let crossing = self.joints[index] || crosses_break(model, index, y);
            let memory = &mut memory[model.contact_memory(contact_index(index, Side::Left))];
            let kept = Partition::from_mask(memory[PARTITION]).map_or(0.0, |partition| conditioning(&partition.block(&jacobian)));
            // A partition for a crossing has infinity as mark.
            if crossing != memory[CONDITIONING].is_infinite() || (!crossing && kept < WORSE * memory[CONDITIONING]) {
                choose(&jacobian, crossing, wheelset, t, memory)?;
                workspace.work.partitions += 1;
                chosen = true;
            }
        }
        Ok(chosen)
    }

    /// The local error of independent variables is controlled; while a wheel is elastic that of all coordinates.
    fn error_weight(&self, model: &Model, workspace: &Workspace, i: usize, plain: f64) -> f64 {
        let plain = lift::error_weight(model, workspace, i, plain);
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
        let times = wheels(model).filter_map(|(contact, _, side)| {
            let own = &y[model.contact_states(contact)];
            let (s, speed) = (own[DISTANCE], own[PARAMETERS + DISTANCE]);
            let ahead = model.track.rail(side).distance_to_break(s, speed)? - CROSSING * speed.abs();
            (ahead > 0.0).then(|| t + (ahead + INSIDE) / speed.abs())
        });
        times.fold(f64::INFINITY, f64::min)
    }

    fn resettle(&self, model: &Model, workspace: &mut Workspace, t: f64, y: &mut [f64], memory: &mut [f64]) -> Result<(), EvaluationError> {
        self.reset(model, workspace, t, y, memory)
    }
}

impl Accf {
    /// Brings the coordinates onto the constraints without regard to a partition (mass-weighted, as in ECCF), takes the surface
    /// parameters from the located contacts and chooses a partition.
    fn reset(&self, model: &Model, workspace: &mut Workspace, t: f64, y: &mut [f64], memory: &mut [f64]) -> Result<(), EvaluationError> {
        eccf::project(model, workspace, t, y, memory)?;
        model.move_bodies(y, memory, &mut workspace.system);
        for (contact, wheelset, side) in wheels(model) {
            let memory = &mut memory[model.contact_memory(contact)];
            if is_elastic(memory) {
                continue;
            }
            let motion = &workspace.system.motions[wheelset.body];
            let found = eccf::locate(model, (contact, wheelset, side), motion, memory)
                .map_err(|cause| EvaluationError::new(t, wheelset, side, cause))?;
            let p = found.location.parameters;
            let states = &mut y[model.contact_states(contact)];
            states[..PARAMETERS].copy_from_slice(&[p.wheel, p.angle, p.lead + motion.distance, p.rail]);
            states[PARAMETERS..].copy_from_slice(found.parameter_rates.as_slice());
        }
        for (index, wheelset) in model.wheelsets.iter().enumerate() {
            idle(model, workspace, index, wheelset, y, memory);
            let axes = model.axes_beside(wheelset.body, y, memory);
            let (variables, _) = gather(model, (index, wheelset), &axes, y);
            let (_, jacobian) = constraints(model, (index, wheelset), &axes, memory, &variables);
            let crossing = self.joints[index] || crosses_break(model, index, y);
            choose(&jacobian, crossing, wheelset, t, &mut memory[model.contact_memory(contact_index(index, Side::Left))])?;
        }
        Ok(())
    }
}

/// The states of a wheel that is elastic at present take no part in anything but the way to the next break of its rail: they travel
/// with the wheelset.
fn idle(model: &Model, workspace: &mut Workspace, index: usize, wheelset: &Wheelset, y: &mut [f64], memory: &mut [f64]) {
    for side in Side::BOTH {
        if !is_elastic(&memory[model.contact_memory(contact_index(index, side))]) {
            continue;
        }
        model.move_bodies(y, memory, &mut workspace.system);
        let motion = &workspace.system.motions[wheelset.body];
        let (travelled, speed) = (motion.distance, motion.speed);
        let states = &mut y[model.contact_states(contact_index(index, side))];
        states[DISTANCE] = travelled;
        states[PARAMETERS..].fill(0.0);
        states[PARAMETERS + DISTANCE] = speed;
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

/// Chooses a partition and keeps it in the left contact's memory. One for a crossing ends with it.
fn choose(jacobian: &Jacobian, crossing: bool, wheelset: &Wheelset, t: f64, memory: &mut [f64]) -> Result<(), EvaluationError> {
    let mut free = *jacobian;
    if wheelset.imposed_speed.is_some() {
        // x is given: constraints must not change it. (Where an elastic contact's row holds x itself, that entry stays.)
        let held = free[(CONSTRAINTS + NORMAL, 0)];
        let holds = free.row(CONSTRAINTS + NORMAL).norm() == held.abs();
        free.column_mut(0).fill(0.0);
        free[(CONSTRAINTS + NORMAL, 0)] = if holds { held } else { 0.0 };
    }
    let partition = Partition::choose(&free, if crossing { ALWAYS } else { PREFERRED });
    let partition = partition.ok_or_else(|| EvaluationError::new(t, wheelset, least_certain(jacobian), ContactFailure::Dependent))?;
    memory[PARTITION] = partition.mask();
    memory[CONDITIONING] = if crossing { f64::INFINITY } else { conditioning(&partition.block(jacobian)) };
    Ok(())
}

/// The row of Eq. 10 along the normal.
const NORMAL: usize = 2;

/// Makes a wheelset's dependent variables and rates in `y` satisfy the constraints; returns the Jacobian there.
fn close(
    model: &Model,
    workspace: &mut Workspace,
    index: usize,
    wheelset: &Wheelset,
    t: f64,
    y: &mut [f64],
    memory: &mut [f64],
) -> Result<Jacobian, EvaluationError> {
    let own = &*memory;
    let left = &own[model.contact_memory(contact_index(index, Side::Left))];
    let fail = |cause| EvaluationError::new(t, wheelset, Side::Left, cause);
    let partition = Partition::from_mask(left[PARTITION]).ok_or_else(|| fail(ContactFailure::Dependent))?;
    let axes = model.axes_beside(wheelset.body, y, own);
    let (mut values, mut rates) = gather(model, (index, wheelset), &axes, y);
    let base = values;
    let at = |change: &Rows| {
        let mut values = base;
        partition.add(&mut values, change);
        values
    };
    let mut change = Rows::zeros();
    let evaluate = |change: &Rows| constraints(model, (index, wheelset), &axes, own, &at(change));
    let q = &y[model.system.coordinates(wheelset.body)];
    // Distances along the rail are among the variables: they are known to the rounding of the way travelled, on straight track too.
    let rounding = model.rounding(q).max(8.0 * f64::EPSILON * q[0].abs());
    let limits = NewtonLimits { next_step: POSITION.next_step.max(rounding), rounding: POSITION.rounding.max(rounding), ..POSITION };
    let elastic = Side::BOTH.map(|side| is_elastic(&memory[model.contact_memory(contact_index(index, side))]));
    let uncertain =
        |jacobian: &Jacobian| if elastic[0] == elastic[1] { least_certain(jacobian) } else { Side::BOTH[usize::from(elastic[0])] };
    let solved = newton::solve(&mut change, limits, evaluate, |_, jacobian| partition.block(jacobian));
    let (jacobian, iterations) = match solved {
        Ok(solved) => solved,
        Err(failure) => {
            let (rest, jacobian) = evaluate(&change);
            let (iterations, y_wheelset) = (failure.iterations, base[1]);
            let certain = lost(model, workspace, wheelset, t, y, memory, 0.0).or_else(|| {
                let cause = ContactFailure::NotFound { iterations, residual: failure.residual, y: y_wheelset };
                unplaced(&rest).map(|side| EvaluationError::new(t, wheelset, side, cause))
            });
            let certain = certain.or_else(|| AHEAD.iter().find_map(|ahead| lost(model, workspace, wheelset, t, y, memory, *ahead)));
            return Err(certain.unwrap_or_else(|| {
                let cause = ContactFailure::NotClosed { iterations, gap: failure.residual, y: y_wheelset };
                EvaluationError::new(t, wheelset, uncertain(&jacobian), cause)
            }));
        }
    };
    workspace.work.constraint_iterations += iterations as u64;
    values = at(&change);
    let mut excess: Rows = jacobian * rates;
    for (side, row) in [(Side::Left, NORMAL), (Side::Right, CONSTRAINTS + NORMAL)] {
        if is_elastic(&own[model.contact_memory(contact_index(index, side))]) {
            excess.fixed_rows_mut::<CONSTRAINTS>(row - NORMAL).fill(0.0);
        }
    }
    if !partition.block(&jacobian).lu().solve_mut(&mut excess) {
        return Err(EvaluationError::new(t, wheelset, uncertain(&jacobian), ContactFailure::Dependent));
    }
    partition.add(&mut rates, &-excess);
    scatter(model, (index, wheelset), &axes, values, rates, y);
    workspace.rigid.partitions[index] = Some(partition);
    Ok(jacobian)
}

/// Which wheel has lost its place, or will have `ahead` [s]: contacts of a wheelset are closed together here, but ECCF's projection locates each
/// on its own.
fn lost(
    model: &Model,
    workspace: &mut Workspace,
    wheelset: &Wheelset,
    t: f64,
    y: &[f64],
    memory: &[f64],
    ahead: f64,
) -> Option<EvaluationError> {
    let mut moved = y.to_vec();
    for (coordinate, rate) in model.system.coordinates(wheelset.body).zip(model.system.velocities(wheelset.body)) {
        moved[coordinate] += ahead * y[rate];
    }
    let failure = eccf::project(model, workspace, t, &mut moved, &mut memory.to_vec()).err()?;
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
    let certainty = |row: usize, column: usize| {
        without(&jacobian.fixed_view::<CONSTRAINTS, PARAMETERS>(row, column).into_owned(), NORMAL).determinant().abs()
    };
    if certainty(0, COORDINATES) <= certainty(CONSTRAINTS, COORDINATES + PARAMETERS) { Side::Left } else { Side::Right }
}

/// The equations of motion at a state that is made consistent first.
fn evaluate(
    model: &Model,
    workspace: &mut Workspace,
    t: f64,
    inputs: &[f64],
    y: &mut [f64],
    memory: &mut [f64],
    dy: &mut [f64],
) -> Result<(), EvaluationError> {
    for (index, wheelset) in model.wheelsets.iter().enumerate() {
        close(model, workspace, index, wheelset, t, y, memory)?;
    }
    let mut points = std::mem::take(&mut workspace.rigid.points);
    points.clear();
    model.move_bodies(y, memory, &mut workspace.system);
    for (contact, wheelset, side) in wheels(model) {
        if is_elastic(&memory[model.contact_memory(contact)]) {
            points.push(None);
            continue;
        }
        let own = &y[model.contact_states(contact)];
        let motion = &workspace.system.motions[wheelset.body];
        let pair = pair(model, wheelset, side, motion);
        let found = pair.point_contact(&Vector4::from_column_slice(&own[..PARAMETERS]));
        let bias = pair.bias(&found, &Vector4::from_column_slice(&own[PARAMETERS..]), &motion.carrier());
        points.push(Some((found, bias)));
    }
    let done = rigid::derivative(model, workspace, Evaluation { t, inputs, y, memory }, dy, |contact, wheelset, side, motion, memory| {
        let own = &y[model.contact_states(contact)];
        let (found, bias) = points[contact].as_ref().ok_or(ContactFailure::Dependent)?;
        keep(&SurfaceParameters { wheel: own[0], angle: own[1], lead: own[2] - motion.distance, rail: own[3] }, memory);
        let weights = free_multiplier(found).ok_or(ContactFailure::Dependent)?;
        let mut row = Coefficients::zeros();
        for (i, weight) in weights.iter().enumerate() {
            row += motion.coefficients(&found.by_velocity[i], &found.by_rotation[i]) * *weight;
        }
        let rates = [own[PARAMETERS], own[PARAMETERS + 3]];
        Ok(ConstraintRow { location: pair(model, wheelset, side, motion).location(found), row, bias: weights.dot(bias), rates })
    });
    let done = done.and_then(|()| parameter_derivatives(model, workspace, t, y, &points, dy));
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
    for ((contact, wheelset, side), point) in wheels(model).zip(points) {
        let range = model.contact_states(contact);
        dy[range.start..range.start + PARAMETERS].copy_from_slice(&y[range.start + PARAMETERS..range.end]);
        dy[range.start + PARAMETERS..range.end].fill(0.0);
        let Some((found, bias)) = point else { continue };
        let motion = &workspace.system.motions[wheelset.body];
        let accelerations = Coefficients::from_column_slice(&dy[model.system.velocities(wheelset.body)]);
        let mut rest = *bias;
        for i in 0..CONSTRAINTS {
            rest[i] += motion.coefficients(&found.by_velocity[i], &found.by_rotation[i]).dot(&accelerations);
        }
        let accelerations =
            parameter_accelerations(found, &rest).ok_or_else(|| EvaluationError::new(t, wheelset, side, ContactFailure::Dependent))?;
        dy[range.start + PARAMETERS..range.end].copy_from_slice(accelerations.as_slice());
    }
    Ok(())
}

/// The four rows of C_s that are left without row `out`.
fn without(by_parameters: &ParameterJacobian, out: usize) -> Matrix4<f64> {
    Matrix4::from_fn(|row, column| by_parameters[(row + usize::from(row >= out), column)])
}

/// Multipliers `w` with `C_s^T w = 0` (Eq. 14), scaled such that they press with 1 N along the normal.
fn free_multiplier(contact: &PointContact) -> Option<Residual> {
    let minors = Residual::from_fn(|row, _| {
        let minor = without(&contact.by_parameters, row).determinant();
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
