//! How the system's accelerations change with its state, for implicit integration: J close to df/dy, and the solution of
//! `(I - a J) x = b`.
use super::system::{System, SystemWorkspace};
use nalgebra::{Matrix6, Vector6};

/// Change of a wrench (force above moment about the centre of the body that it acts on, world axes, N and N m) with the motion of a body
/// (world axes, displacement of its centre above rotation vector, m and rad; velocity above angular velocity, m/s and rad/s).
///
/// `by_position` counts at constant velocity and angular velocity in the world: that a turned axle turns its spin too,
/// `d omega = d theta x omega`-like, is added by [`Tangent::finish`] (through `by_velocity`), and so it must not be in here.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WrenchTangent {
    pub by_position: Matrix6<f64>,
    pub by_velocity: Matrix6<f64>,
}

/// How one first-order state and a body act on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateCoupling {
    pub body: usize,
    /// Change of the state's rate with displacement and rotation, and with velocity and angular velocity of the body.
    pub rate_by_position: Vector6<f64>,
    pub rate_by_velocity: Vector6<f64>,
    /// Change of the wrench on the body with the state.
    pub wrench_by_state: Vector6<f64>,
}

/// I - a J can't be inverted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the linearised equations of motion are singular at body {body} for this step; a shorter step may help")]
pub struct SingularTangent {
    /// Body, or the first body of a constraint.
    pub body: usize,
}

/// J of a system and the factors of I - a J; only `new` allocates.
#[derive(Clone, Debug)]
pub struct Tangent {}

impl Tangent {
    /// Finds pattern and order of elimination. `contact_bodies` as in [`System::workspace`]; `further_states` bounds the
    /// number of states handed to [`Tangent::add_state`].
    pub fn new(_system: &System, _contact_bodies: &[usize], _further_states: usize) -> Tangent {
        Tangent {}
    }

    /// J = 0.
    pub fn clear(&mut self) {}

    /// Adds the change of a wrench on the body `on` with the motion of the body `by`.
    pub fn add_wrench(&mut self, _on: usize, _by: usize, _tangent: &WrenchTangent) {}

    /// Adds a first-order state at index `state` of the state vector: the change of its rate with itself, 1/s, and what couples it
    /// with up to two bodies.
    pub fn add_state(&mut self, _state: usize, _rate_by_state: f64, _bodies: &[StateCoupling]) {}

    /// Adds every force element, with the motions in the workspace.
    pub fn add_forces(&mut self, _system: &System, _workspace: &SystemWorkspace, _y: &[f64]) {}

    /// Ends the sum: wrenches become accelerations of coordinates.
    pub fn finish(&mut self, _system: &System, _workspace: &SystemWorkspace) {}

    /// Factorises I - a J, a in s, with the active constraint rows in the workspace.
    ///
    /// # Errors
    /// [`SingularTangent`].
    pub fn factorise(&mut self, _a: f64, _workspace: &SystemWorkspace) -> Result<(), SingularTangent> {
        Ok(())
    }

    /// Solves (I - a J) x = x in place, x as long as the state vector; states that J does not know (J = 0) stay.
    pub fn solve(&mut self, _x: &mut [f64]) {}
}
