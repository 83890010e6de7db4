//! The scratch of a model's evaluations, and what they find.

use super::contact_report::ContactReport;
use super::events::ContactEvent;
use super::frame_motion::MovingFrame;
use super::memory::ModelMemory;
use super::patch_loads::Loaded;
use super::rail_scratch::RailScratch;
use super::rigid_scratch::RigidScratch;
use super::timers::Timers;
use super::work::Work;
use crate::contact::search::algebraic::Pair;
use crate::contact::strips::Scratch;
use crate::mbs::system::SystemWorkspace;
use crate::mbs::tangent::Tangent;
use nalgebra::Vector3;

/// Scratch of an evaluation; holds what it found until the next one.
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
    pub timers: Timers,
    /// Lift-offs and landings since they were last taken away.
    pub events: Vec<ContactEvent>,
    /// What patches of strips are found in, by wheel, and those of a wheel that is tried a little deeper.
    pub(super) strips: Vec<Scratch>,
    pub(super) deeper: Scratch,
    /// What the patch carries that was loaded last.
    pub(super) loaded: Loaded,
    /// Does what the last evaluation found belong to the begin of the integrator's next step?
    pub cached: Cached,
    /// When the integrator's step begins for which the system was linearised last, s; `None` where that may be another system's.
    pub linearised: Option<f64>,
    /// The linearised model, for integrators that need it .
    pub(super) tangent: Option<Tangent>,
    /// How the track carries the bodies along from that state.
    pub(super) frame: MovingFrame,
    /// What wheels feel of rails that are beams.
    pub(super) rails: RailScratch,
}

/// Whose is the evaluation that a workspace holds?
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cached {
    /// Nobody's that may need it.
    #[default]
    No,
    /// That at the end of a step which may yet be accepted.
    OfTrial,
    /// That at the begin of the next step.
    OfState,
}

/// Time, inputs and state of an evaluation; the memory is both read and written.
#[derive(Debug)]
pub struct Evaluation<'a> {
    pub t: f64,
    pub inputs: &'a [f64],
    pub y: &'a [f64],
    pub memory: &'a mut ModelMemory,
}

impl Workspace {
    /// What it holds belongs to no step any more.
    pub fn forget(&mut self) {
        (self.cached, self.linearised) = (Cached::No, None);
    }

    /// Rails stay where they are from now on (or no longer): a wheel whose pose is that of the last evaluation presses as it did then.
    pub fn reuse_patches(&mut self, reuse: bool) {
        self.strips.iter_mut().for_each(|strips| strips.rails_stay = reuse);
    }

    /// Reports of a wheel's contacts beyond the first.
    #[inline]
    fn further(&self, contact: usize) -> &[ContactReport] {
        let count = self.further_contacts.len() / self.contacts.len();
        &self.further_contacts[contact * count..(contact + 1) * count]
    }

    /// Reports of all contacts of the wheel whose first contact has the index `contact`.
    #[inline]
    pub fn reports(&self, contact: usize) -> impl Iterator<Item = &ContactReport> + Clone {
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

    /// How much the carrying contacts of a wheel on `body` lean across the track at most (sine of the normal's angle); `None` where nothing carries.
    pub fn lean(&self, contact: usize, body: usize) -> Option<f64> {
        let carrying = self.reports(contact).filter(|report| report.carries());
        carrying.map(|report| self.in_track(body, report.axes.normal).y.abs()).reduce(f64::max)
    }

    /// A body's lateral displacement [m] and yaw [rad, its sine] relative to the centre line beside it.
    pub fn beside_track(&self, body: usize) -> [f64; 2] {
        let motion = &self.system.motions[body];
        match self.system.stations.get(body) {
            None => [motion.position.y, motion.yaw],
            Some(station) => {
                let frame = &station.frame;
                [frame.components(&(motion.position - frame.origin)).y, frame.components(&motion.frame.axes.column(0).into_owned()).y]
            }
        }
    }

    /// How many strips a wheel was laid over in this pose; `None` where its patch was not made of strips.
    pub fn pressed_strips(&self, contact: usize, pair: &Pair) -> Option<usize> {
        self.strips.get(contact).filter(|scratch| scratch.is_of(pair)).map(|scratch| scratch.pressed().len())
    }

    /// How far a rail that is a beam has gone up under a wheel, m.
    pub fn rail_sunk(&self, contact: usize) -> f64 {
        self.rails.under.get(contact).map_or(0.0, |under| under[0])
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
