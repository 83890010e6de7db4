//! Normal forces of constrained contacts in balance with the creep forces that depend on them.
//!
//! The multipliers follow linearly from the wrenches, and the creep wrench w of a contact depends on its own normal force alone:
//!
//! ```text
//! N = G(w_1(N_1), ..., w_n(N_n)),   dG_i / dN_j = P_ij . w_j'
//! ```
//!
//! P_ij is the multiplier's answer to a wrench. Newton's method solves this with w' from the last two points of the same contact;
//! the first guess of w' is that of a patch that grows like N^(1/3) with the saturation of Vermeulen and Johnson
//! (see [`Contact::growth`]), so that three to five evaluations do. Contacts of one wheelset are coupled exactly; between
//! wheelsets only joints of rigid bodies pass accelerations on, which is left to the iteration.
//!
//! A law of contact is read at a penetration delta, which costs no iteration of its own: delta is the unknown behind N, followed with
//! the slope `d ln delta / d ln N` (2/3 of a Hertzian contact of constant shape). Memory of it is only a start.
//!
//! Where a law jumps (curvature over the patch where a second place of contact joins it: by up to 0.8 % of N for S1002 on 60E1) two deltas
//! may fit N, or none. A secant across a jump says nothing, and is not used: slopes are then those of the first guess. A contact that goes on
//! jumping keeps the stiffness that it has, `N = K delta^1.5` with a patch that grows like N^(1/3), so that the balance is smooth again: its
//! patch is then off by a third of the jump at most. An iteration that does not gain for other reasons ends with the multipliers when
//! they rest to 1e-4 of the force: creep forces alone act on them, so that they hardly move.

use crate::contact::Patch;
use crate::contact::normal::{ConformalContact, ElasticContact};
use crate::formulation::loading::{Contact, WheelAt, friction};
use crate::formulation::rail_motion::Climb;
use crate::formulation::rigid_scratch::{Balance, ConstraintRow, Pressing};
use crate::formulation::step::WheelRef;
use crate::formulation::{ContactFailure, ContactReport, EvaluationError, Model, Workspace, contact_index};
use crate::geometry::Side;
use crate::mbs::body::Wrench;
use crate::mbs::system::SystemWorkspace;

/// The loop ends when it changes the forces by less than this part of the largest, or by less than the floor [N].
const RELATIVE: f64 = 1e-11;
const FLOOR: f64 = 1e-7;
/// The part where it goes on to rounding.
const EXACT: f64 = 1e-16;
/// An iteration that no longer gains ends with what it has: soon with this part of the largest force, ...
const ROUNDING: f64 = 1e-9;
/// ... after some more with this, ...
const JUMP: f64 = 1e-4;
/// ... when nothing helps with this.
const LAST: f64 = 1e-3;
const ITERATIONS: usize = 40;
/// Widest jump of a law, as a part of the largest force.
const WIDEST_JUMP: f64 = 0.02;
/// A larger change of the creep force with the normal force than this can't be that of a smooth law: friction is below 1.
const STEEPEST_SECANT: f64 = 2.0;
/// What has not settled after so many iterations is steeper, up to this: strips of FASTSIM and FaStrip in which the rigid slip vanishes turn their traction round
/// within a small change of the contact force.
const SOON: usize = 5;
const STEEPEST_STEP: f64 = 1e3;
/// Least determinant for which the coupling of two wheels is solved for.
const LEAST_DETERMINANT: f64 = 1e-3;
/// Two points that are nearer to each other (relative to N) say nothing of the slope.
const NEAR: f64 = 1e-7;
/// d ln delta / d ln N of a law that does not jump: 2/3 with constant curvature, up to 1 where the curvature over the patch grows like it.
const LEAST_EXPONENT: f64 = 0.3;
const LARGEST_EXPONENT: f64 = 1.2;
/// After so many jumps a contact keeps its stiffness.
const MOST_JUMPS: usize = 3;
/// Largest change of N in one iteration, as a factor.
const LARGEST_CHANGE: f64 = 10.0;

/// A contact of the same stiffness under another force.
fn grown(kept: &ElasticContact, force: f64) -> ElasticContact {
    let growth = (force / kept.force).cbrt();
    ElasticContact { force, slope: growth * kept.slope, patch: Patch { a: growth * kept.patch.a, b: growth * kept.patch.b }, ..*kept }
}

fn scaled(wrench: &Wrench, factor: f64) -> Wrench {
    Wrench { force: wrench.force * factor, moment: wrench.moment * factor }
}

impl Pressing {
    /// Reads the law at the present penetration.
    fn evaluate(&mut self, load: &Contact, report: &mut ContactReport, (first, steepest): (bool, f64)) -> Result<(), ConformalContact> {
        if first && self.force > 0.0 && !(self.approach > 0.0) {
            self.approach = load.approach_under(self.force)?;
        }
        let loaded = self.approach > 0.0;
        let (force, creep) = match self.kept.filter(|_| loaded) {
            Some(kept) => (self.force, load.pressed(report, &grown(&kept, self.force))),
            None => load.squeezed(report, self.approach)?,
        };
        self.creep = creep;
        if !loaded {
            report.normal_force = self.force;
            self.slope = Wrench::default();
            return Ok(());
        }
        self.force = force;
        let moved = self.last.filter(|last| (force - last.1).abs() > NEAR * force);
        let exponent = |approach: f64, before: f64| (self.approach / approach).ln() / (force / before).ln();
        let exponent = moved.map(|(approach, before, _)| exponent(approach, before));
        if self.kept.is_none() && exponent.is_some_and(|exponent| !(LEAST_EXPONENT..=LARGEST_EXPONENT).contains(&exponent)) {
            self.jumps += 1;
            self.slope = scaled(&creep, load.growth(report) / force);
            self.exponent = 2.0 / 3.0;
            if self.jumps >= MOST_JUMPS {
                self.keep(report);
            }
        } else if let Some((_, before, wrench)) = moved {
            let part = 1.0 / (force - before);
            let slope = Wrench { force: (creep.force - wrench.force) * part, moment: (creep.moment - wrench.moment) * part };
            if slope.force.norm() < steepest {
                self.slope = slope;
            }
            self.exponent = exponent.unwrap_or(2.0 / 3.0);
        } else if self.last.is_none() {
            self.slope = scaled(&creep, load.growth(report) / force);
            self.exponent = 2.0 / 3.0;
        }
        Ok(())
    }

    /// Keeps the stiffness that the law had when it was read last, into the report.
    fn keep(&mut self, report: &ContactReport) {
        let (stiffness, slope, patch) = (report.stiffness, report.elastic_slope, report.patch);
        self.kept = Some(ElasticContact { stiffness, force: self.force, slope, patch });
    }

    /// Goes on towards N = `next`.
    fn advance(&mut self, load: &Contact, next: f64) -> Result<(), ConformalContact> {
        if self.approach > 0.0 {
            if next <= 0.0 {
                *self = Pressing { force: next, ..Pressing::default() };
                return Ok(());
            }
            self.last = Some((self.approach, self.force, self.creep));
            if let Some(kept) = &self.kept {
                let root = (next / kept.stiffness).cbrt();
                (self.force, self.approach) = (next, root * root);
                return Ok(());
            }
            let change = (next / self.force).clamp(1.0 / LARGEST_CHANGE, LARGEST_CHANGE);
            self.approach *= change.powf(self.exponent);
        } else {
            self.force = next;
            if next > 0.0 {
                (self.approach, self.last) = (load.approach_under(next)?, None);
            }
        }
        Ok(())
    }
}

/// Multipliers under the base's wrenches and those that `add` gives each constrained contact; wrenches and accelerations stay in the
/// workspace.
fn respond(
    model: &Model,
    system: &mut SystemWorkspace,
    (rows, base): (&[Option<ConstraintRow>], &[Wrench]),
    image: &mut [f64],
    mut add: impl FnMut(usize, Side) -> Wrench,
) {
    system.wrenches.copy_from_slice(base);
    for WheelRef { contact, wheelset, side } in model.wheels() {
        if rows[contact].is_some() {
            system.wrenches[wheelset.body] += add(contact, side);
        }
    }
    model.system.free_accelerations(system);
    system.constraints.solve();
    for (image, multiplier) in image.iter_mut().zip(&system.constraints.multipliers[system.constraints.joint_rows..]) {
        *image = -multiplier;
    }
}

/// Finds dG/dN of each wheelset: how the multipliers answer to a change of its normal forces by `scale` [N].
fn couple(
    model: &Model,
    system: &mut SystemWorkspace,
    at: (&[Option<ConstraintRow>], &[Wrench]),
    (contacts, coupling): (&[Pressing], &mut [[f64; 4]]),
    (image, answer): (&[f64], &mut [f64]),
    scale: f64,
) {
    // One size of change for all, that of the largest force: what is subtracted keeps its digits, and what reaches a wheelset
    // from others through joints stays as small as it is.
    for (column, side) in Side::BOTH.into_iter().enumerate() {
        respond(model, system, at, answer, |contact, of| {
            let Pressing { creep, slope, .. } = &contacts[contact];
            let mut wrench = *creep;
            if of == side {
                wrench += scaled(slope, scale);
            }
            wrench
        });
        for (index, coupling) in coupling.iter_mut().enumerate() {
            for (row, of) in Side::BOTH.into_iter().enumerate() {
                let contact = contact_index(index, of);
                let change = answer[contact] - image[contact];
                coupling[2 * row + column] = change / scale;
            }
        }
    }
}

/// The change of a wheelset's two normal forces that removes what is left between them and the multipliers, N.
fn newton_step([ll, lr, rl, rr]: &[f64; 4], rest: [f64; 2]) -> [f64; 2] {
    let determinant = (1.0 - ll) * (1.0 - rr) - lr * rl;
    if determinant.abs() > LEAST_DETERMINANT {
        [((1.0 - rr) * rest[0] + lr * rest[1]) / determinant, ((1.0 - ll) * rest[1] + rl * rest[0]) / determinant]
    } else {
        rest
    }
}

/// How much of a step is made after so many iterations without gain.
fn damping_after(stale: usize) -> f64 {
    match stale {
        0..=2 => 1.0,
        3..=8 => 0.5,
        _ => 0.2,
    }
}

/// Finds the normal forces with which creep forces and multipliers agree, from those in `balance.contacts`; leaves wrenches with
/// creep forces, accelerations and multipliers in the workspace.
///
/// Where that does not settle all contacts keep the stiffness that they have, as one that goes on jumping does.
pub(super) fn settle(
    model: &Model,
    workspace: &mut Workspace,
    rows: &[Option<ConstraintRow>],
    balance: &mut Balance,
    at: (f64, &[f64], &[f64]),
) -> Result<(), EvaluationError> {
    balance.base.copy_from_slice(&workspace.system.wrenches);
    let settled = iterate(model, workspace, rows, balance, at);
    let unsettled =
        matches!(&settled, Err(failure) if matches!(failure.cause, ContactFailure::NotSettled { residual, .. } if residual.is_finite()));
    let mut any = false;
    for (pressing, report) in balance.contacts.iter_mut().zip(&workspace.contacts).filter(|_| unsettled) {
        if pressing.kept.is_none() && pressing.approach > 0.0 && pressing.force > 0.0 {
            (any, pressing.last) = (true, None);
            pressing.keep(report);
        }
    }
    if any { iterate(model, workspace, rows, balance, at) } else { settled }
}

fn iterate(
    model: &Model,
    workspace: &mut Workspace,
    rows: &[Option<ConstraintRow>],
    balance: &mut Balance,
    (t, y, inputs): (f64, &[f64], &[f64]),
) -> Result<(), EvaluationError> {
    let Balance { contacts, coupling, base, image, last_image, answer, exact } = balance;
    let (relative, floor) = if *exact { (EXACT, 0.0) } else { (RELATIVE, FLOOR) };
    let Workspace { system, contacts: reports, work, .. } = workspace;
    let (mut best, mut stale, mut worst, mut damping) = (f64::INFINITY, 0, 0, 1.0);
    for iteration in 1..=ITERATIONS {
        let steepest = if iteration <= SOON { STEEPEST_SECANT } else { STEEPEST_STEP };
        for WheelRef { contact, wheelset, side } in model.wheels() {
            let Some(found) = &rows[contact] else { continue };
            let (motion, friction) = (&system.motions[wheelset.turning[side.index()]], friction(inputs, contact, side));
            let wheel = WheelAt { model, wheelset, side, contact, motion, climb: Climb::default(), friction, y };
            let load = Contact { wheel: &wheel, found: &found.location, slot: 0, share: 1.0 };
            let evaluated = contacts[contact].evaluate(&load, &mut reports[contact], (iteration == 1, steepest));
            evaluated.map_err(|cause| EvaluationError::new(t, wheelset, side, cause.into()))?;
        }
        respond(model, system, (rows, base), image, |contact, _| contacts[contact].creep);
        work.force_iterations += 1;
        let (mut largest, mut residual, mut moved) = (0.0f64, 0.0f64, 0.0f64);
        for WheelRef { contact, .. } in model.wheels().filter(|wheel| rows[wheel.contact].is_some()) {
            let pressing = &mut contacts[contact];
            if pressing.approach <= 0.0 && image[contact] <= 0.0 {
                pressing.force = image[contact];
            }
            let rest = (image[contact] - pressing.force).abs();
            largest = largest.max(image[contact].abs());
            // As far as the whole step would have gone.
            moved = moved.max((image[contact] - last_image[contact]).abs() / damping);
            // NaN must not pass.
            if !(rest <= residual) {
                (residual, worst) = (rest, contact);
            }
        }
        if residual < 0.5 * best {
            (best, stale) = (residual, 0);
        } else {
            stale += 1;
        }
        // Only a narrow jump: far from it multipliers that rest mean that delta creeps.
        let rest = if residual <= WIDEST_JUMP * largest { residual.min(moved) } else { residual };
        let gained = stale >= 2 && residual <= ROUNDING * largest
            || stale >= 6 && rest <= JUMP * largest
            || iteration == ITERATIONS && rest <= LAST * largest;
        last_image.copy_from_slice(image);
        if residual <= (relative * largest).max(floor) || gained {
            for contact in (0..contacts.len()).filter(|contact| rows[*contact].is_some()) {
                let report = &mut reports[contact];
                report.force += report.axes.normal * (image[contact] - report.normal_force);
                (report.normal_force, contacts[contact].force) = (image[contact], image[contact]);
            }
            return Ok(());
        }
        if !residual.is_finite() || iteration == ITERATIONS {
            let cause = ContactFailure::NotSettled { iterations: iteration, residual };
            return Err(model.wheel(worst).error(t, cause));
        }
        if iteration <= 2 || stale > 0 || iteration > SOON {
            couple(model, system, (rows, base), (contacts, coupling), (image, answer), largest.max(1.0));
        }
        damping = damping_after(stale);
        for (index, coupling) in coupling.iter().enumerate() {
            let pair = Side::BOTH.map(|side| contact_index(index, side));
            let rest = pair.map(|contact| if rows[contact].is_some() { image[contact] - contacts[contact].force } else { 0.0 });
            let step = newton_step(coupling, rest);
            for (k, side) in Side::BOTH.into_iter().enumerate() {
                let Some(found) = &rows[pair[k]] else { continue };
                let wheelset = &model.wheelsets[index];
                let (motion, friction) = (&system.motions[wheelset.turning[k]], friction(inputs, pair[k], side));
                let wheel = WheelAt { model, wheelset, side, contact: pair[k], motion, climb: Climb::default(), friction, y };
                let load = Contact { wheel: &wheel, found: &found.location, slot: 0, share: 1.0 };
                let next = contacts[pair[k]].force + damping * step[k];
                let advanced = contacts[pair[k]].advance(&load, next);
                advanced.map_err(|cause| EvaluationError::new(t, wheelset, side, cause.into()))?;
            }
        }
    }
    Ok(())
}
