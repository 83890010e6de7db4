//! What stays constant during a simulation, and the scratch of its evaluations.

use super::carried::Carried;
use super::events::ContactEvent;
use super::lift::OnLift;
use super::points::{self, PreparedSearches, WheelSearch};
use super::rigid::{self, RigidScratch};
use super::sliding_mean::SlidingMean;
use super::work::Work;
use super::{AssemblyError, Build, EvaluationError, Formulation, RAIL_INPUTS, lasting, lift};
use crate::contact::Patch;
use crate::contact::creep::CreepLaw;
use crate::contact::creepage::{ContactAxes, CreepForce, Creepage, Slip};
use crate::contact::normal::NormalLaw;
use crate::contact::normal::damping::DampingLaw;
use crate::contact::search::algebraic::SurfaceParameters;
use crate::contact::transient::{self, LoadedPatch, SlipVelocity, TransientContact};
use crate::geometry::Side;
use crate::geometry::profile::ProfilePoint;
use crate::geometry::surface::Wheel;
use crate::geometry::track::Track;
use crate::mbs::body::{BodyMotion, Wrench};
use crate::mbs::system::{System, SystemWorkspace};
use crate::mbs::tangent::Tangent;
use nalgebra::Vector3;
use std::sync::Arc;

/// Inputs of one wheelset, in the order in which they stand in the input vector.
pub const WHEELSET_INPUTS: usize = 6;
pub const DRIVE_TORQUE: usize = 0;
pub const LATERAL_FORCE: usize = 1;
pub const VERTICAL_FORCE: usize = 2;
pub const LEFT_FRICTION: usize = 3;
pub const RIGHT_FRICTION: usize = 4;
pub const LONGITUDINAL_FORCE: usize = 5;
/// Values of a wheelset's inputs that leave it alone.
pub const NEUTRAL_INPUTS: [f64; WHEELSET_INPUTS] = [0.0, 0.0, 0.0, 1.0, 1.0, 0.0];

/// Of `solver.load_tolerance`, where a scene names none.
pub const LOAD_TOLERANCE: f64 = 0.01;

/// A body with two wheels on the track.
#[derive(Debug)]
pub struct Wheelset {
    pub name: String,
    pub body: usize,
    pub left: Wheel,
    pub right: Wheel,
    /// Imposed travelling speed [m/s], `None` when the wheelset is free along the track.
    pub imposed_speed: Option<f64>,
    /// Vertical force of each wheel on level track at rest, N.
    pub static_wheel_load: f64,
}

impl Wheelset {
    /// Travelling speed that creepages are relative to, m/s; with the sign of the direction.
    #[inline]
    pub fn speed(&self, motion: &BodyMotion) -> f64 {
        self.imposed_speed.unwrap_or(motion.speed)
    }

    pub fn wheel(&self, side: Side) -> &Wheel {
        match side {
            Side::Left => &self.left,
            Side::Right => &self.right,
        }
    }
}

/// Place of a wheel's contact in [`Workspace::contacts`] and, times the memory per contact, in the state's memory.
pub fn contact_index(wheelset: usize, side: Side) -> usize {
    2 * wheelset + usize::from(side == Side::Right)
}

/// Laws and constants of contact.
#[derive(Debug)]
pub struct ContactLaws {
    pub normal: Box<dyn NormalLaw>,
    pub creep: Box<dyn CreepLaw>,
    pub damping: Box<dyn DampingLaw>,
    /// Tangential contact at low speed; `None` where the scene does not call for it.
    pub transient: Option<TransientContact>,
    /// mu, -.
    pub friction: f64,
    /// G, Pa.
    pub shear_modulus: f64,
}

/// Everything that stays constant during a simulation, before a formulation is chosen.
#[derive(Debug)]
pub struct Parts {
    pub system: System,
    pub track: Track,
    pub wheelsets: Vec<Wheelset>,
    pub laws: ContactLaws,
    /// Contacts that each wheel may have at the same time, at least 1.
    pub points: usize,
    /// Searches for them that other models of the same scene have prepared.
    pub prepared: PreparedSearches,
}

/// Everything that stays constant during a simulation.
#[derive(Debug)]
pub struct Model {
    pub system: System,
    pub track: Track,
    pub wheelsets: Vec<Wheelset>,
    pub laws: ContactLaws,
    pub formulation: Box<dyn Formulation>,
    /// Contacts that each wheel may have at the same time.
    pub points: usize,
    /// Where the contacts' states begin in the state vector (the system's dimension).
    pub(super) contact_states_begin: usize,
    /// Error of a contact's normal or creep force that a step may make, in parts of the static wheel load or, where it is larger, of the
    /// normal force, -.
    pub load_tolerance: f64,
    /// Means over the last stretch of travel; `None` where the scene does not ask for them.
    pub means: Option<SlidingMean>,
    /// Does the rail under each wheel move as inputs say (see `rail_motion`)?
    pub rail_motion: bool,
    /// Per wheel: the search for all of them; `None` where one place alone can touch.
    pub(super) searches: Vec<Option<Arc<WheelSearch>>>,
}

/// One contact as it was found and loaded at one instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactReport {
    pub parameters: SurfaceParameters,
    /// delta, m, negative when the surfaces are apart; its rate, m/s.
    pub penetration: f64,
    pub penetration_rate: f64,
    /// The wheel's material point, m, and the profiles of wheel and rail there.
    pub wheel_point: Vector3<f64>,
    pub profiles: [ProfilePoint; 2],
    /// Of its Hertzian force that it carries: less than 1 where it shares its patch with another contact (see `points`).
    pub share: f64,
    /// K_h, N/m^1.5; zero without contact.
    pub stiffness: f64,
    /// How the undivided elastic force grows with delta, N/m.
    pub elastic_slope: f64,
    /// N, N.
    pub normal_force: f64,
    pub patch: Patch,
    pub axes: ContactAxes,
    pub creepage: Creepage,
    pub creep_force: CreepForce,
    /// Velocity of the wheel's material point along e1 and e2 [m/s] and angular velocity about n [rad/s].
    pub slip: Slip,
    /// Rates of the tangential states, where there are any.
    pub deflection_rates: [f64; transient::STATES],
    /// Force on the wheelset in the world (on straight track the track frame), N.
    pub force: Vector3<f64>,
    pub iterations: usize,
    /// Is the contact a constraint (its normal force a multiplier), not elastic?
    pub constrained: bool,
}

impl ContactReport {
    /// Adds `force` [N] of this contact and its spin moment to the wrench of a wheelset whose centre is at `centre`.
    #[inline]
    pub(super) fn add_to(&self, wrench: &mut Wrench, force: Vector3<f64>, centre: &Vector3<f64>) {
        wrench.add_at(force, &self.wheel_point, centre);
        wrench.moment += self.axes.normal * self.creep_force.spin_moment;
    }
}

/// Scratch of an evaluation; holds its findings until the next one.
#[derive(Clone, Debug)]
pub struct Workspace {
    pub system: SystemWorkspace,
    /// First contacts of all wheels in the order wheelset 1 left, right, wheelset 2 left, ...
    pub contacts: Vec<ContactReport>,
    /// The other contacts of all wheels in the same order, as many for each as the model allows; empty where it is one.
    pub further_contacts: Vec<ContactReport>,
    /// What constraint formulations work in.
    pub(crate) rigid: RigidScratch,
    /// Counted up by each evaluation.
    pub work: Work,
    /// Lift-offs and landings since they were last taken away.
    pub events: Vec<ContactEvent>,
    /// Do the findings of the last evaluation belong to the begin of the integrator's next step?
    pub findings_marked: bool,
    /// The linearised model, for integrators that need it ([`Model::prepare_tangent`]).
    pub(super) tangent: Option<Tangent>,
    /// How the track carries the bodies along from that state.
    pub(super) carried: Carried,
}

/// Time, inputs and state of an evaluation; the memory is both read and written.
#[derive(Debug)]
pub struct Evaluation<'a> {
    pub t: f64,
    pub inputs: &'a [f64],
    pub y: &'a [f64],
    pub memory: &'a mut [f64],
}

impl Workspace {
    /// Reports of a wheel's contacts beyond the first.
    #[inline]
    fn further(&self, contact: usize) -> &[ContactReport] {
        let count = self.further_contacts.len() / self.contacts.len();
        &self.further_contacts[contact * count..(contact + 1) * count]
    }

    /// Reports of all contacts of the wheel whose first contact has the index `contact`.
    #[inline]
    pub fn reports(&self, contact: usize) -> impl Iterator<Item = &ContactReport> {
        std::iter::once(&self.contacts[contact]).chain(self.further(contact))
    }

    /// Sum of the forces on a wheel of `body` in the track frame beside it, N.
    pub fn wheel_force(&self, contact: usize, body: usize) -> Vector3<f64> {
        let force: Vector3<f64> = self.reports(contact).map(|report| report.force).sum();
        self.in_track(body, force)
    }

    /// A vector of the world in the track frame beside a body.
    pub fn in_track(&self, body: usize, vector: Vector3<f64>) -> Vector3<f64> {
        self.system.stations.get(body).map_or(vector, |station| station.components(&vector))
    }

    /// Report of a wheel's contact `slot` (from 0).
    #[inline]
    pub fn report(&self, contact: usize, slot: usize) -> &ContactReport {
        match slot {
            0 => &self.contacts[contact],
            _ => &self.further(contact)[slot - 1],
        }
    }
}

impl Model {
    /// Completes the parts with a formulation.
    ///
    /// # Errors
    /// [`AssemblyError`] when the formulation can't treat the parts.
    pub fn new(parts: Parts, build: &Build) -> Result<Model, AssemblyError> {
        let formulation = build(&parts)?;
        let Parts { system, track, wheelsets, laws, points, prepared } = parts;
        let own = formulation.points_per_wheel();
        let searches = points::searches(&wheelsets, &track, own == 1, &prepared);
        let points = if searches.iter().any(Option::is_some) { points } else { own };
        let contact_states_begin = system.dimension();
        Ok(Model {
            system,
            track,
            wheelsets,
            laws,
            formulation,
            points,
            contact_states_begin,
            searches,
            load_tolerance: LOAD_TOLERANCE,
            means: None,
            rail_motion: false,
        })
    }

    pub fn contacts(&self) -> usize {
        2 * self.wheelsets.len()
    }

    /// Are the places of a wheel's contacts searched for? Otherwise only one can touch (or the formulation knows them itself).
    pub fn searches_contacts(&self, contact: usize) -> bool {
        self.searches[contact].is_some()
    }

    /// Length of the state vector.
    pub fn dimension(&self) -> usize {
        self.mean_states(self.wheelsets.len()).start
    }

    pub(super) fn means_begin(&self) -> usize {
        self.deflections_begin() + self.contacts() * self.points * self.deflection_states()
    }

    fn deflections_begin(&self) -> usize {
        self.contact_states_begin + self.contacts() * self.formulation.states_per_contact()
    }

    /// States of the tangential deflection of one contact: none without `contact.transient`.
    pub fn deflection_states(&self) -> usize {
        if self.laws.transient.is_some() { transient::STATES } else { 0 }
    }

    /// The tangential states of a wheel's contact `slot` (from 0) in the state vector; they stand at its end.
    pub fn deflection(&self, contact: usize, slot: usize) -> std::ops::Range<usize> {
        let start = self.deflections_begin() + (contact * self.points + slot) * self.deflection_states();
        start..start + self.deflection_states()
    }

    /// Writes the rates of all tangential states, which the contacts' reports hold.
    #[inline]
    pub(super) fn deflection_rates(&self, workspace: &Workspace, y: &[f64], dy: &mut [f64]) {
        let Some(transient) = &self.laws.transient else { return };
        for contact in 0..self.contacts() {
            for slot in 0..self.points {
                let report = workspace.report(contact, slot);
                let range = self.deflection(contact, slot);
                let unloaded = || {
                    let mut state = [0.0; transient::STATES];
                    state.copy_from_slice(&y[range.clone()]);
                    let (patch, slip) = (LoadedPatch::default(), SlipVelocity::default());
                    transient.evaluate(self.laws.creep.as_ref(), &patch, &slip, &state).rates
                };
                let rates = if report.normal_force > 0.0 { report.deflection_rates } else { unloaded() };
                dy[range].copy_from_slice(&rates);
            }
        }
    }

    /// Puts the tangential states where they are in steady rolling with the contacts as they were found last.
    pub fn settle_deflections(&self, workspace: &Workspace, y: &mut [f64]) {
        let Some(transient) = &self.laws.transient else { return };
        for (contact, wheelset, _) in rigid::wheels(self) {
            for slot in 0..self.points {
                let report = workspace.report(contact, slot);
                let speed = wheelset.speed(&workspace.system.motions[wheelset.body]);
                let patch = LoadedPatch { patch: report.patch, normal_force: report.normal_force, friction: self.laws.friction };
                let state = transient.steady_state(&patch, &report.slip.rolling(speed));
                y[self.deflection(contact, slot)].copy_from_slice(&state);
            }
        }
    }

    /// Length of the state's memory.
    pub fn memory(&self) -> usize {
        self.mean_memory(self.wheelsets.len()).start + self.followed()
    }

    fn memory_per_contact(&self) -> usize {
        let record = if self.searches.iter().any(Option::is_some) { points::record_length(self.points) } else { 0 };
        self.formulation.memory_per_contact() + record
    }

    /// A contact's own states in the state vector.
    pub fn contact_states(&self, contact: usize) -> std::ops::Range<usize> {
        let count = self.formulation.states_per_contact();
        let start = self.contact_states_begin + contact * count;
        start..start + count
    }

    /// A contact's part of the state's memory.
    pub fn contact_memory(&self, contact: usize) -> std::ops::Range<usize> {
        let count = self.memory_per_contact();
        contact * count..(contact + 1) * count
    }

    pub fn workspace(&self) -> Workspace {
        let constrained = self.constrained_bodies();
        let further = (self.points - 1) * self.contacts();
        let mut system = self.system.workspace(&constrained);
        self.add_stations(&mut system);
        Workspace {
            system,
            contacts: vec![ContactReport::default(); self.contacts()],
            further_contacts: vec![ContactReport::default(); further],
            rigid: if self.formulation.constrains() { RigidScratch::new(self) } else { RigidScratch::default() },
            work: Work::default(),
            events: Vec::new(),
            findings_marked: false,
            tangent: None,
            carried: Carried::default(),
        }
    }

    /// The bodies of the contacts that are constraints, contact by contact.
    pub(super) fn constrained_bodies(&self) -> Vec<usize> {
        let both = |wheelset: &Wheelset| [wheelset.body; 2];
        if self.formulation.constrains() { self.wheelsets.iter().flat_map(both).collect() } else { Vec::new() }
    }

    /// The reports of one wheel's contacts: the first and the others.
    #[inline]
    pub(super) fn reports<'a>(
        &self,
        contact: usize,
        first: &'a mut [ContactReport],
        further: &'a mut [ContactReport],
    ) -> (&'a mut ContactReport, &'a mut [ContactReport]) {
        let count = self.points - 1;
        (&mut first[contact], &mut further[contact * count..(contact + 1) * count])
    }

    /// Values of all inputs that leave the model alone.
    pub fn neutral_inputs(&self) -> Vec<f64> {
        let own = NEUTRAL_INPUTS.iter().copied().cycle().take(WHEELSET_INPUTS * self.wheelsets.len());
        own.chain(std::iter::repeat_n(0.0, if self.rail_motion { RAIL_INPUTS * self.contacts() } else { 0 })).collect()
    }

    /// Derivative `dy` of the state `at.y` at time `at.t`; leaves motions, wrenches and contacts in the workspace.
    ///
    /// # Errors
    /// [`EvaluationError`] when a contact cannot be found or lies outside what the laws cover.
    #[inline]
    pub fn derivative(&self, workspace: &mut Workspace, at: Evaluation, dy: &mut [f64]) -> Result<(), EvaluationError> {
        self.formulation.derivative(self, workspace, at, dy)?;
        self.mean_rates(workspace, dy);
        Ok(())
    }

    /// The smallest normal force [N] of a constrained contact as it was found last, how far its place is from being left, or how far
    /// (times a stiffness) a contact beside the first is from beginning or ending; `None` when there is none of them.
    pub fn margin(&self, memory: &[f64]) -> Option<f64> {
        let pressing = self.formulation.on_lift().and_then(|_| rigid::least_pressed(self, memory)).map(|(_, force)| force);
        let lasting = if self.may_be_elastic() { lasting::least_lasting(self, memory).map(|(_, margin)| margin) } else { None };
        let touching = points::margin(self, memory);
        pressing.into_iter().chain(lasting).chain(touching).reduce(f64::min)
    }

    /// Are contacts constraints that may also be elastic for a time (`contact.on_lift`)?
    pub fn may_be_elastic(&self) -> bool {
        self.formulation.on_lift() == Some(OnLift::Elastic)
    }

    /// Starts at `y` with all contacts elastic; see [`Formulation::start`].
    ///
    /// # Errors
    /// [`EvaluationError`] when a contact cannot be found.
    pub fn start_elastic(&self, workspace: &mut Workspace, t: f64, y: &mut [f64], memory: &mut [f64]) -> Result<(), EvaluationError> {
        lift::start_elastic(self, workspace, t, y, memory);
        self.formulation.resettle(self, workspace, t, y, memory)
    }

    /// When an elastic contact tries next to become a constraint again, s; infinity for never.
    pub fn next_return(&self, memory: &[f64]) -> f64 {
        self.formulation.on_lift().map_or(f64::INFINITY, |_| lift::next_return(self, memory))
    }

    /// Changes the mode of the contacts that are to change it, by what the last evaluation found in this state; returns whether one did.
    ///
    /// # Errors
    /// [`EvaluationError`] when the formulation can't go on.
    pub fn switch(&self, workspace: &mut Workspace, t: f64, y: &mut [f64], memory: &mut [f64]) -> Result<bool, EvaluationError> {
        if points::switch(self, workspace, t, memory) {
            return Ok(true);
        }
        self.formulation.on_lift().map_or(Ok(false), |on_lift| lift::switch(on_lift, self, workspace, t, y, memory))
    }

    /// Hands a constrained contact that can't be found any more to elastic forces, where the scene allows it; returns whether it
    /// did.
    ///
    /// # Errors
    /// [`EvaluationError`] when there is no state near `y` in which the other constraints hold.
    pub fn release(
        &self,
        failure: &EvaluationError,
        workspace: &mut Workspace,
        t: f64,
        y: &mut [f64],
        memory: &mut [f64],
    ) -> Result<bool, EvaluationError> {
        match self.formulation.on_lift() {
            Some(OnLift::Elastic) => lift::release(failure, self, workspace, t, y, memory),
            _ => Ok(false),
        }
    }
}
