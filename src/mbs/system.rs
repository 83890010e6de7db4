//! Bodies, force elements, driving constraints and joints as one system: state layout and accelerations.
//!
//! The state vector holds the coordinates of all bodies (x, y, z, yaw, roll, pitch each), then their velocities in
//! the same order, then the first-order states of the force elements that have some, in the elements' order. A driving constraint `x' = V` replaces its coordinate's acceleration exactly: the centre of mass
//! is the body's origin, so X is not coupled to other coordinates by inertia, the acceleration is V' (zero where V is constant) and the
//! constraint force is what mass times that leaves of the sum of all other longitudinal forces. On a curved track the constraint holds the speed along the
//! track's tangent ([`super::driving`]). Joints and contact constraints are solved
//! for together ([`super::constraints`]); a system that has none pays nothing for them.

use super::body::{Body, BodyMotion, COORDINATES, Wrench};
use super::constraints::Constraints;
use super::driving::{DrivingConstraint, Orders};
use super::force::ForceElement;
use super::joint::Joint;
use super::kkt::RowBodies;
use super::moving::Moving;
use super::supported::SupportedMass;
use super::twist::TwistedAxle;
use crate::geometry::track::station::Stations;

/// The constant part of a multibody system.
#[derive(Debug)]
pub struct System {
    pub bodies: Vec<Body>,
    pub forces: Vec<Box<dyn ForceElement>>,
    pub drives: Vec<DrivingConstraint>,
    /// On bodies whose speed is not imposed, or changes.
    pub supported: Vec<SupportedMass>,
    pub joints: Vec<Joint>,
    /// Rows of joints that repeat what others demand ([`System::find_redundant`]); they are left out.
    pub redundant: Vec<usize>,
}

/// What is computed on the way to the accelerations; nothing in here outlives an evaluation.
#[derive(Clone, Debug)]
pub struct SystemWorkspace {
    /// Of the bodies, then of the wheels of axles that twist.
    pub motions: Vec<BodyMotion>,
    pub wrenches: Vec<Wrench>,
    pub twists: Vec<TwistedAxle>,
    /// Rates of the force elements' states.
    pub force_rates: Vec<f64>,
    /// Inputs of all force elements, in their order.
    pub inputs: Vec<f64>,
    /// Where each element's states and inputs end among them; empty if there are none of either.
    ends: Vec<[usize; 2]>,
    /// Force of each driving constraint, N, forward positive.
    pub drive_forces: Vec<f64>,
    pub orders: Orders,
    pub constraints: Constraints,
    /// By body, for the bodies that are followed along a curved track.
    pub stations: Stations,
}

impl System {
    /// Bodies of the joints' rows.
    fn joint_rows(&self) -> Vec<RowBodies> {
        self.joints.iter().flat_map(|joint| std::iter::repeat_n(joint.bodies, joint.rows())).collect()
    }

    /// Length of the state vector.
    pub fn dimension(&self) -> usize {
        self.force_states().end
    }

    /// The states of all force elements in the state vector. Counted anew each time: not for the stepping path.
    pub fn force_states(&self) -> std::ops::Range<usize> {
        let start = 2 * COORDINATES * self.bodies.len();
        start..start + self.forces.iter().map(|force| force.states()).sum::<usize>()
    }

    /// The states of one force element in the state vector. Counted anew each time: not for the stepping path.
    pub fn states_of_force(&self, element: usize) -> std::ops::Range<usize> {
        let before: usize = self.forces[..element].iter().map(|force| force.states()).sum();
        let start = 2 * COORDINATES * self.bodies.len() + before;
        start..start + self.forces[element].states()
    }

    /// Number of inputs of all force elements.
    pub fn force_inputs(&self) -> usize {
        self.forces.iter().map(|force| force.inputs().len()).sum()
    }

    /// The inputs of one force element among those of all. Counted anew each time: not for the stepping path.
    pub fn inputs_of_force(&self, element: usize) -> std::ops::Range<usize> {
        let start: usize = self.forces[..element].iter().map(|force| force.inputs().len()).sum();
        start..start + self.forces[element].inputs().len()
    }

    /// The bodies as one force element sees them, with its inputs in the workspace. Not for the stepping path.
    pub fn seen_by<'a>(&self, element: usize, workspace: &'a SystemWorkspace) -> Moving<'a> {
        workspace.with_inputs(self.inputs_of_force(element))
    }

    /// Puts the states of elements that turn with axles where they come to rest with the axles spinning as they do in `y`, under the inputs in the workspace.
    pub fn spin_up_forces(&self, y: &mut [f64], workspace: &mut SystemWorkspace) {
        if self.forces.iter().any(|force| force.turns_axle()) {
            self.move_bodies(y, workspace);
            for (element, force) in self.forces.iter().enumerate().filter(|(_, force)| force.turns_axle()) {
                force.settle(&self.seen_by(element, workspace), &mut y[self.states_of_force(element)]);
            }
        }
    }

    /// Puts the force elements' states where they come to rest with the bodies at rest in their places of `y`, under the inputs in the workspace.
    pub fn settle_forces(&self, y: &mut [f64], workspace: &mut SystemWorkspace) {
        self.move_bodies(y, workspace);
        for (element, force) in self.forces.iter().enumerate() {
            force.settle(&self.seen_by(element, workspace), &mut y[self.states_of_force(element)]);
        }
    }

    /// With one more scalar constraint, on one body each, for every element of `contact_bodies`; they follow the rows
    /// of the joints.
    pub fn workspace(&self, contact_bodies: &[usize]) -> SystemWorkspace {
        let (count, inputs) = (self.force_states().len(), self.force_inputs());
        let ends = self.forces.iter().scan([0, 0], |end, force| {
            *end = [end[0] + force.states(), end[1] + force.inputs().len()];
            Some(*end)
        });
        let zero = BodyMotion::new(&[0.0; COORDINATES], &[0.0; COORDINATES]);
        let twists: Vec<TwistedAxle> = self.twisted_axles().collect();
        let moving = self.bodies.len() + 2 * twists.len();
        SystemWorkspace {
            motions: vec![zero; moving],
            wrenches: vec![Wrench::default(); moving],
            twists,
            force_rates: vec![0.0; count],
            inputs: vec![0.0; inputs],
            ends: if count + inputs == 0 { Vec::new() } else { ends.collect() },
            drive_forces: vec![0.0; self.drives.len()],
            orders: Orders::default(),
            constraints: Constraints::new(self.bodies.len(), self.joint_rows(), &self.redundant, contact_bodies),
            stations: Stations::default(),
        }
    }

    /// Coordinates of a body in the state vector.
    pub fn coordinates(&self, body: usize) -> std::ops::Range<usize> {
        body * COORDINATES..(body + 1) * COORDINATES
    }

    /// Velocities of a body in the state vector.
    pub fn velocities(&self, body: usize) -> std::ops::Range<usize> {
        let start = COORDINATES * (self.bodies.len() + body);
        start..start + COORDINATES
    }

    /// Fills the workspace with the bodies' motion.
    #[inline(always)] // on the wheelset's path, with several callers
    pub fn move_bodies(&self, y: &[f64], workspace: &mut SystemWorkspace) {
        for body in 0..self.bodies.len() {
            workspace.motions[body].set(&self.bodies[body], &y[self.coordinates(body)], &y[self.velocities(body)]);
        }
        if !workspace.twists.is_empty() {
            self.turn_wheels(&y[2 * COORDINATES * self.bodies.len()..], workspace);
        }
    }

    /// Fills the workspace with the bodies' motion and the force elements' wrenches on straight level track.
    #[inline(always)] // on the wheelset's path, with several callers
    pub fn apply_forces(&self, y: &[f64], workspace: &mut SystemWorkspace) {
        self.move_bodies(y, workspace);
        self.load_bodies(y, workspace);
    }

    /// Fills the workspace with the force elements' wrenches and rates where motions and stations are known.
    #[inline(always)] // on the wheelset's path, with several callers
    pub fn load_bodies(&self, y: &[f64], workspace: &mut SystemWorkspace) {
        workspace.wrenches.fill(Wrench::default());
        if !workspace.ends.is_empty() {
            return self.load_with_states(y, workspace);
        }
        let SystemWorkspace { motions, stations, wrenches, .. } = workspace;
        let bodies = Moving { motions, stations, inputs: &[] };
        for force in &self.forces {
            force.apply(&bodies, &[], &mut [], wrenches);
        }
    }

    /// The force elements' wrenches and the rates of their states. Out of line: most systems have neither states nor inputs.
    #[inline(never)]
    fn load_with_states(&self, y: &[f64], workspace: &mut SystemWorkspace) {
        let SystemWorkspace { motions, stations, wrenches, force_rates, inputs, ends, .. } = workspace;
        let states = &y[2 * COORDINATES * self.bodies.len()..];
        let [mut start, mut first] = [0, 0];
        for (force, [end, last]) in self.forces.iter().zip(ends) {
            let bodies = Moving { motions, stations, inputs: &inputs[first..*last] };
            force.apply(&bodies, &states[start..*end], &mut force_rates[start..*end], wrenches);
            [start, first] = [*end, *last];
        }
    }

    /// Derivative of the state under the wrenches in the workspace, without joints and contact constraints; fills the
    /// driving constraints' forces.
    #[inline(always)] // on the wheelset's path, with several callers
    pub fn derivative(&self, y: &[f64], workspace: &mut SystemWorkspace, dy: &mut [f64]) {
        for (body, data) in self.bodies.iter().enumerate() {
            let accelerations = data.accelerations(&workspace.motions[body], &workspace.wrenches[body]);
            let velocities = self.velocities(body);
            dy[self.coordinates(body)].copy_from_slice(&y[velocities.clone()]);
            dy[velocities].copy_from_slice(&accelerations);
        }
        workspace.copy_force_rates(COORDINATES * self.bodies.len(), dy);
        for supported in &self.supported {
            let body = supported.body;
            let linear = &mut dy[self.velocities(body).start..][..3];
            supported.hold_back(self.bodies[body].mass, workspace.stations.get(body), &workspace.motions[body], linear);
        }
        let SystemWorkspace { wrenches, drive_forces, stations, motions, orders, .. } = workspace;
        for (drive, force) in self.drives.iter().zip(drive_forces) {
            let first = self.velocities(drive.body).start;
            if let Some(station) = stations.get(drive.body) {
                let demand = drive.demand(station, motions, stations, orders);
                drive.hold(station, demand, &mut dy[first..first + 3]);
                *force = self.force_in_curve(drive, demand, &wrenches[drive.body].force, &motions[drive.body], station);
                continue;
            }
            let demand = drive.straight_demand(motions, stations, orders);
            dy[first] = demand;
            *force = self.force_on_straight(drive, demand, wrenches[drive.body].force.x);
        }
    }

    /// Kinetic energy of all bodies, and of what they support, J.
    pub fn kinetic_energy(&self, motions: &[BodyMotion]) -> f64 {
        kinetic_energy(&self.bodies, &self.supported, motions)
    }

    /// Power that inputs bring into force elements, W, in the motion in the workspace; their states are those in `y`.
    pub fn supplied_power(&self, y: &[f64], workspace: &SystemWorkspace) -> f64 {
        let forces = self.forces.iter().enumerate();
        forces.map(|(element, force)| force.supplied_power(&self.seen_by(element, workspace), &y[self.states_of_force(element)])).sum()
    }

    /// Stored energy of all force elements, J; their states are those in `y`.
    pub fn potential_energy(&self, y: &[f64], bodies: &Moving) -> f64 {
        let forces = self.forces.iter().enumerate();
        forces.map(|(element, force)| force.potential_energy(bodies, &y[self.states_of_force(element)])).sum()
    }

    /// Power that all force elements turn into heat, W, in the motion in the workspace; their states are those in `y`.
    pub fn dissipated_power(&self, y: &[f64], workspace: &SystemWorkspace) -> f64 {
        let forces = self.forces.iter().enumerate();
        forces.map(|(element, force)| force.dissipated_power(&self.seen_by(element, workspace), &y[self.states_of_force(element)])).sum()
    }

    /// Kinetic and stored energy of the motion in the workspace, J; the force elements' states are those in `y`.
    pub fn mechanical_energy(&self, y: &[f64], workspace: &SystemWorkspace) -> f64 {
        self.kinetic_energy(&workspace.motions) + self.potential_energy(y, &workspace.moving())
    }
}

/// Kinetic energy of bodies and of what they support, J.
pub fn kinetic_energy(bodies: &[Body], supported: &[SupportedMass], motions: &[BodyMotion]) -> f64 {
    let supported = supported.iter().map(|load| 0.5 * load.mass * motions[load.body].speed.powi(2)).sum::<f64>();
    bodies.iter().zip(motions).map(|(body, motion)| body.kinetic_energy(motion)).sum::<f64>() + supported
}

impl SystemWorkspace {
    /// The bodies as they move.
    #[inline]
    pub fn moving(&self) -> Moving<'_> {
        self.with_inputs(0..0)
    }

    /// The same with some of the inputs.
    #[inline]
    pub fn with_inputs(&self, inputs: std::ops::Range<usize>) -> Moving<'_> {
        Moving { motions: &self.motions, stations: &self.stations, inputs: &self.inputs[inputs] }
    }

    /// Where the inputs of each element end; empty if no element has states or inputs.
    pub(super) fn inputs_end(&self, element: usize) -> usize {
        self.ends.get(element).map_or(0, |end| end[1])
    }

    /// Copies the rates of the force elements' states behind those of the bodies, of which there are twice `coordinates`.
    #[inline]
    pub(super) fn copy_force_rates(&self, coordinates: usize, dy: &mut [f64]) {
        if !self.force_rates.is_empty() {
            dy[2 * coordinates..2 * coordinates + self.force_rates.len()].copy_from_slice(&self.force_rates);
        }
    }
}
