//! The linearised model: every contact's wrench tangent, then the multibody system's, for implicit integrators.
//!
//! Contacts that share a patch (`points`) change with their shares `s(d1, r, d2)`, penetrations d1, d2 and that of the ridge r between
//! them: `dN = .. + N ds / s`, each penetration stationary in its place, so that `d delta = -n . (d + w x rho)` for all three.
//!
//! [`Model::linearise`] starts from what the last evaluation left in the workspace (motions, contact reports) and J is assembled in
//! the [`Tangent`] that lives there. What J leaves out is said in [`contact`], in [`crate::contact::transient::slopes`] and in
//! [`crate::mbs::tangent`]; besides: the states of ACCF (surface parameters), of ECF-N (distance along the rail) and of sliding means
//! count as not stiff (J = 0).

mod contact;
mod linear;
mod patch;

use super::elastic::points;
use super::half::tangent_in_mirror;
use super::loading::WheelAt;
use super::memory::{ModelMemory, RidgeMemory};
use super::model::factor_at;
use super::rail_motion::Climb;
use super::step::WheelRef;
use super::wheel_search::MOST_POINTS;
use super::yielding_rails::Under;
use super::{ContactReport, EvaluationError, LEFT_FRICTION, Model, RIGHT_FRICTION, WHEELSET_INPUTS, Wheelset, Workspace};
use crate::contact::creep::RollingContact;
use crate::contact::creepage::{CreepForce, Creepage};
use crate::contact::friction::by_friction;
use crate::contact::search::migration::{Row, add, sum};
use crate::contact::strips::Uneven;
use crate::contact::transient::{self, LoadedPatch, TransientContact};
use crate::geometry::Side;
use crate::mbs::body::BodyMotion;
use crate::mbs::tangent::{Follower, SingularTangent, StateCoupling, Tangent, WrenchTangent};
pub(super) use contact::normal_slopes;
use contact::{ByMotion, NormalSlopes, Touching, penetration_by_pose};
use nalgebra::Vector3;

/// A contact that carries less than this share of its force counts as one that carries so much.
const LEAST_SHARE: f64 = 1e-2;

/// By number of the contact.
type Shares = [Row; MOST_POINTS];

/// A contact of one wheel.
struct At<'a> {
    wheelset: &'a Wheelset,
    side: Side,
    contact: usize,
    slot: usize,
    motion: &'a BodyMotion,
    report: &'a ContactReport,
    /// mu.
    friction: f64,
    /// Change of the travelling speed with the centre's velocity; `None` where it is imposed.
    travel: Option<Vector3<f64>>,
}

impl Model {
    /// Gives the workspace what [`Model::linearise`] needs.
    pub fn prepare_tangent(&self, workspace: &mut Workspace) {
        let states = self.contacts() * self.points * self.deflection_states();
        let (plans, pairs) = self.beam.as_ref().map_or_else(Default::default, |beam| self.ring_plans(beam));
        let mut tangent = Tangent::joining(&self.system, &self.constrained_bodies(), states, &pairs);
        if let Some(beam) = &self.beam {
            tangent = tangent.with_rings(&beam.ring, &plans, self.points * self.deflection_states());
        }
        if self.travelling_track.is_some() {
            tangent = tangent.with_followers(self.contacts(), self.points * self.deflection_states());
        }
        workspace.tangent = Some(tangent);
        workspace.frame = self.moving_frame();
    }

    /// Finds J at the state `y`, with its memory, that was evaluated last: of the contacts and, with `forces`, of the force elements.
    pub fn linearise(&self, workspace: &mut Workspace, (y, memory): (&[f64], &ModelMemory), inputs: &[f64], forces: bool) {
        let Some(mut tangent) = workspace.tangent.take() else { return };
        tangent.clear();
        let mut left = WrenchTangent::default();
        let mut strips = (std::mem::take(&mut workspace.strips), std::mem::take(&mut workspace.deeper));
        let mut loaded = std::mem::take(&mut workspace.loaded);
        for WheelRef { contact, wheelset, side } in self.wheels() {
            let turning = wheelset.turning[side.index()];
            if self.half.is_some() && side == Side::Right {
                tangent.add_wrench(turning, turning, &tangent_in_mirror(&left, turning == wheelset.turning[0]));
                continue;
            }
            let without = if self.half.is_some() { tangent.take_wrench(turning) } else { None };
            let moved = self.against_rail((&workspace.system, &workspace.rails), (inputs, y), (wheelset.body, turning), contact);
            let as_it_is = &workspace.system.motions[turning];
            let (motion, climb) = moved.as_ref().map_or((as_it_is, Climb::default()), |moved| (&moved.motion, moved.climb));
            let factor = inputs[contact / 2 * WHEELSET_INPUTS + if side == Side::Left { LEFT_FRICTION } else { RIGHT_FRICTION }];
            let along = workspace.system.stations.along(wheelset.body);
            let under = self.under((&workspace.system, &workspace.rails), &WheelRef { contact, wheelset, side });
            let round = moved.as_ref().filter(|moved| moved.round.is_some());
            // What this wheel alone does.
            let alone = under.is_some() || round.is_some();
            let (before, others) = (tangent.states(), if alone { tangent.take_wrench(turning) } else { None });
            let shares = self.share_changes(workspace, contact, (wheelset, side, motion), memory);
            let places = if self.strips.is_some() || !self.linear.is_empty() { 0 } else { self.points };
            for slot in 0..places {
                let report = workspace.report(contact, slot);
                let friction = self.friction_at(side, motion, report) * factor.max(0.0);
                let travel = wheelset.imposed_speed.is_none().then_some(along);
                let at = At { wheelset, side, contact, slot, motion, report, friction, travel };
                self.add_contact(&at, shares.get(slot), y, &mut tangent);
            }
            if let Some(linear) = self.linear.get(contact) {
                let wheel = WheelAt { model: self, wheelset, side, contact, motion, climb, friction: factor, y };
                self.add_linear(&wheel, linear, wheelset.imposed_speed.is_none().then_some(along), &mut tangent);
            }
            if let Some(rails) = &self.strips {
                let wheel = WheelAt { model: self, wheelset, side, contact, motion, climb, friction: factor, y };
                let travel = wheelset.imposed_speed.is_none().then_some(along);
                let scratch = (&mut strips.0[contact], &mut strips.1, &mut loaded);
                self.add_patch(&wheel, &rails[side.index()], workspace.reports(contact), travel, scratch, &mut tangent);
            }
            if let Some(moved) = round
                && let Some(own) = tangent.wrench_mut(turning, turning)
            {
                Self::add_turning_bumps(moved, own);
            }
            if self.half.is_some() {
                left = tangent.take_wrench(turning).unwrap_or_default();
                for wrench in without.iter().chain([&left]) {
                    tangent.add_wrench(turning, turning, wrench);
                }
            }
            if let Some(Under { first, axes, mass, stiffness, damping }) = under {
                let own = tangent.take_wrench(turning).unwrap_or_default();
                let follower = Follower { body: wheelset.body, first, axes, mass, stiffness, damping };
                match &self.beam {
                    None => tangent.add_follower(&follower, &own, before),
                    Some(beam) => {
                        let place = (self.rail_of(beam, contact), beam.seats[contact / 2].place);
                        let shape = workspace.rails.shape(contact / 2, beam.ring.modes());
                        tangent.add_on_ring(place, &follower, &own, before, shape);
                    }
                }
                tangent.add_wrench(turning, turning, &own);
            }
            if let Some(others) = others {
                tangent.add_wrench(turning, turning, &others);
            }
        }
        (workspace.strips, workspace.deeper) = strips;
        workspace.loaded = loaded;
        if forces {
            tangent.add_forces(&self.system, &workspace.system, y);
        }
        tangent.finish(&self.system, &workspace.system);
        self.note_frame(workspace, y, &tangent);
        workspace.tangent = Some(tangent);
    }

    /// Factorises I - a J, a in s.
    ///
    /// # Errors
    /// [`SingularTangent`].
    pub fn factorise(&self, workspace: &mut Workspace, a: f64) -> Result<(), SingularTangent> {
        workspace.tangent.as_mut().map_or(Ok(()), |tangent| tangent.factorise(a, &workspace.system))
    }

    /// The same error with the wheel that it stands nearest to. Its time is not a number: a factorisation does not know it.
    pub fn singular_tangent(&self, workspace: &Workspace, error: SingularTangent) -> EvaluationError {
        let bodies = self.system.bodies.len();
        let own = self.wheelsets.iter().find(|wheelset| wheelset.body == error.node);
        match error.node.checked_sub(bodies) {
            None => EvaluationError::new(f64::NAN, own.unwrap_or(&self.wheelsets[0]), Side::Left, error.into()),
            Some(row) => self.wheel_of_row(&workspace.system, row).error(f64::NAN, error.into()),
        }
    }

    /// Solves (I - a J) x = x in place.
    pub fn solve_linear(&self, workspace: &mut Workspace, x: &mut [f64]) {
        self.solve_linear_pushed(workspace, x, 0.0, &[]);
    }

    /// Solves (I - a J) x = x + weight push in place, where accelerations in `push` are none that constraints let pass.
    pub fn solve_linear_pushed(&self, workspace: &mut Workspace, x: &mut [f64], weight: f64, push: &[f64]) {
        if let Some(tangent) = &mut workspace.tangent {
            tangent.solve_pushed(x, weight, push);
        }
    }

    fn add_contact(&self, at: &At, share: Option<&Row>, y: &[f64], tangent: &mut Tangent) {
        let At { wheelset, side, motion, report, .. } = *at;
        let transient = self.laws.transient.as_ref();
        if !(report.normal_force > 0.0) {
            if let Some(transient) = transient {
                self.add_own_rates(at, transient.unloaded_rates(wheelset.speed(motion), &[-1.0; transient::STATES]), tangent);
            }
            return;
        }
        let pair = WheelRef { contact: at.contact, wheelset, side }.pair(self, motion);
        let slopes = match report.constrained {
            true => NormalSlopes::default(),
            false => normal_slopes(self.laws.damping.as_ref(), report),
        };
        let touching = Touching::new(report, motion, &pair);
        let normal = touching.normal_force(slopes, share.map_or([0.0; 6], |share| sum([report.normal_force], [share])));
        let creep = match transient {
            None => self.steady(at, None, &touching, &normal),
            Some(transient) if transient.is_idle(wheelset.speed(motion)) => {
                self.add_own_rates(at, [0.0; transient::STATES], tangent);
                self.steady(at, None, &touching, &normal)
            }
            Some(transient) => self.add_transient(at, transient, &touching, &normal, y, tangent),
        };
        let turning = wheelset.turning[side.index()];
        if let Some(wrench) = tangent.wrench_mut(turning, turning) {
            touching.add_wrench(report, &normal, &creep, wrench);
        }
    }

    /// Relative changes of the shares of a wheel's contacts with its pose, by number.
    fn share_changes(
        &self,
        workspace: &Workspace,
        contact: usize,
        (wheelset, side, motion): (&Wheelset, Side, &BodyMotion),
        memory: &ModelMemory,
    ) -> Shares {
        let mut changes = Shares::default();
        for RidgeMemory { between, parameters, .. } in (0..self.points - 1).filter_map(|i| memory.wheels[contact].ridge(i, self.points)) {
            let sides = between.map(|slot| workspace.report(contact, slot));
            // One of both carries less than its whole force where the ridge is pressed.
            if !(sides.iter().all(|report| report.normal_force > 0.0) && sides.iter().any(|report| report.share < 1.0)) {
                continue;
            }
            let saddle = WheelRef { contact, wheelset, side }.pair(self, motion).at(parameters);
            let depth = saddle.penetration;
            let [own, other] = sides.map(|report| penetration_by_pose(&(report.wheel_point - motion.position), &report.axes.normal));
            let by_pose = penetration_by_pose(&(saddle.wheel_point - motion.position), &saddle.normal);
            for (i, by_own, by_other) in [(0, &own, &other), (1, &other, &own)] {
                let (slopes, share) = points::share_slopes(sides[i].penetration, depth, sides[1 - i].penetration);
                let per_share = 1.0 / share.max(LEAST_SHARE);
                for (slope, row) in slopes.iter().zip([by_own, &by_pose, by_other]) {
                    add(&mut changes[between[i]], slope * per_share, row);
                }
            }
        }
        changes
    }

    /// Change of the creep force of a contact without states: the report has the law's, to which `uneven` adds.
    fn steady(&self, at: &At, uneven: Option<&Uneven>, touching: &Touching, normal: &ByMotion<1>) -> ByMotion<3> {
        let At { report, friction, .. } = *at;
        let speed = at.wheelset.speed(at.motion);
        let sign = speed.signum();
        let (found, force) = (report.creepage, report.creep_force);
        let creepage = Creepage { longitudinal: sign * found.longitudinal, lateral: sign * found.lateral, ..found };
        let rolling = RollingContact { patch: report.patch, normal_force: report.normal_force, friction, creepage, speed: speed.abs() };
        let turned = CreepForce { longitudinal: sign * force.longitudinal, lateral: sign * force.lateral, ..force };
        let slopes = self.laws.creep.slopes(&rolling, &turned);
        let slopes = uneven.map_or(slopes, |uneven| uneven.slopes(&turned, &slopes, &rolling));
        let mut change = touching.steady(report, &slopes, normal, (speed, at.travel));
        let law = |friction: f64| {
            let force = self.laws.creep.force(&RollingContact { friction, ..rolling });
            CreepForce { longitudinal: sign * force.longitudinal, lateral: sign * force.lateral, ..force }
        };
        self.add_friction(at, touching, &law, &mut change);
        change
    }

    /// Change of the creep force of a contact with deflection; adds its states.
    fn add_transient(
        &self,
        at: &At,
        transient: &TransientContact,
        touching: &Touching,
        normal: &ByMotion<1>,
        y: &[f64],
        tangent: &mut Tangent,
    ) -> ByMotion<3> {
        let (report, states) = (at.report, self.deflection(at.contact, at.slot));
        let body = at.wheelset.turning[at.side.index()];
        let mut state = [0.0; transient::STATES];
        state.copy_from_slice(&y[states.clone()]);
        let loaded = LoadedPatch { patch: report.patch, normal_force: report.normal_force, friction: at.friction };
        let slip = report.slip.rolling(at.wheelset.speed(at.motion));
        let slopes = transient.slopes(self.laws.creep.as_ref(), &loaded, &slip, &state);
        let rates = touching.state_rates(&slopes);
        let own = [slopes.rate_by_deflection[(0, 0)], slopes.rate_by_deflection[(1, 1)], slopes.spin_rate];
        for (i, state) in [0, 1, 3].into_iter().enumerate() {
            let coupling = StateCoupling {
                body,
                rate_by_position: rates.position[i].into(),
                rate_by_velocity: rates.velocity[i].into(),
                wrench_by_state: touching.wrench_of(slopes.force_by_state.column(i).into_owned().into()),
            };
            tangent.add_state(states.start + state, own[i], &[coupling]);
        }
        tangent.add_state(states.start + 2, slopes.direction_rate, &[]);
        let mut change = touching.creep(&slopes.force_by_slip, &slopes.force_by_normal_force, normal);
        let law = |friction: f64| transient.evaluate(self.laws.creep.as_ref(), &LoadedPatch { friction, ..loaded }, &slip, &state).force;
        self.add_friction(at, touching, &law, &mut change);
        change
    }

    /// Adds what friction that varies by place makes of the creep force, which `law` knows over mu.
    fn add_friction(&self, at: &At, touching: &Touching, law: &dyn Fn(f64) -> CreepForce, change: &mut ByMotion<3>) {
        /// Of mu, for a difference.
        const CHANGE: f64 = 1e-4;
        let Some(map) = &self.laws.friction_map else { return };
        let factor = factor_at(map, at.side, at.motion, at.report);
        let flat = factor.by_distance == 0.0 && factor.by_angle == 0.0;
        if flat || !(at.friction > 0.0) {
            return;
        }
        let forces = [law(at.friction), law((1.0 + CHANGE) * at.friction)];
        let by_friction = by_friction(at.friction, CHANGE, &forces[0], &forces[1]);
        let per_factor = at.friction / factor.value;
        let [along, across] = [factor.by_distance, factor.by_angle * at.side.sign()].map(|slope| slope * per_factor);
        touching.add_friction(&by_friction, (along, across), change);
    }

    /// The states of a contact that changes them on their own: how fast they fade, 1/s.
    fn add_own_rates(&self, at: &At, rates: [f64; transient::STATES], tangent: &mut Tangent) {
        // What stands still has no part in J.
        for (state, rate) in self.deflection(at.contact, at.slot).zip(rates).filter(|(_, rate)| *rate != 0.0) {
            tangent.add_state(state, -rate, &[]);
        }
    }
}
