//! Rails that move under the wheels: their motion comes from outside, as of a model of track or bridge.
//!
//! The rail under a wheel is displaced by `u = (0, u_y, u_z)` in the axes of the track frame beside the wheelset's centre (left and up
//! positive), the same along and around the contact: it is not turned. Then wheel and rail stand to each other as if the rail
//! were in its place and the wheel displaced by -u, so that the search, slip and moment arms need nothing but a shifted motion of the
//! wheelset, one for each wheel. With A the track frame's axes, omega its turn per length (own axes) and s' its travel:
//!
//! ```text
//! p* = p - A u,   v* = v - A (0, u_y' - s' omega_x u_z, u_z' + s' omega_x u_y)
//! ```
//!
//! The terms in omega_x (where the superelevation changes) make v* the rate of p*, so that the rate of penetration is that of the
//! penetration. The part of the rate along X, s' (omega_y u_z - omega_z u_y), is left out: a rail that is displaced for good does not
//! slide along itself. Orientation, distance, travelling speed V and rolling direction are the wheelset's own.
//!
//! *Which velocity:* that of the displacement under the moving wheel: for a beam w(x, t) the total `w_t + V w_x`. It is the
//! exact rate of penetration, and with it the lateral creepage is the one against the turned rail, `v_y - w_t - V w_x`, to first
//! order in the slope w_x. What a turned rail does beyond that is left out: the normal force's part along X (N w_x), spin and
//! lead (1e-3 of rail slope moves a flange contact by about 0.3 mm along the rail).
//! A displacement whose velocity is not its rate is taken as it is: penetration follows the displacement, damping and creepage the
//! velocity, and the energy of the coupled system no longer balances.
//!
//! Rigid contact (ACCF, ECCF) is refused: its constraints would need the rail's acceleration too.

use super::{AssemblyError, Model, WHEELSET_INPUTS, contact_index};
use crate::geometry::Side;
use crate::mbs::body::BodyMotion;
use crate::mbs::system::SystemWorkspace;
use nalgebra::Vector3;

/// Inputs of the rail under one wheel, in the order in which they stand behind those of all wheelsets: u_y, u_z [m], u_y', u_z' [m/s].
pub const RAIL_INPUTS: usize = 4;
pub const RAIL_LATERAL: usize = 0;
pub const RAIL_VERTICAL: usize = 1;
pub const RAIL_LATERAL_VELOCITY: usize = 2;
pub const RAIL_VERTICAL_VELOCITY: usize = 3;

/// Place in the input vector of a model with `wheelsets` wheelsets.
pub fn rail_input(wheelsets: usize, wheelset: usize, side: Side, input: usize) -> usize {
    first(wheelsets, contact_index(wheelset, side)) + input
}

fn first(wheelsets: usize, contact: usize) -> usize {
    WHEELSET_INPUTS * wheelsets + RAIL_INPUTS * contact
}

impl Model {
    /// The same model on rails that move, where that is `asked` for.
    ///
    /// # Errors
    /// [`AssemblyError::RailMotion`] where contact is a constraint.
    pub fn with_rail_motion(mut self, asked: bool) -> Result<Self, AssemblyError> {
        if asked && self.formulation.constrains() {
            return Err(AssemblyError::RailMotion);
        }
        self.rail_motion = asked;
        Ok(self)
    }

    /// The wheelset's motion as the rail under one of its wheels sees it; `None` where rails do not move.
    #[inline]
    pub(super) fn against_rail(&self, system: &SystemWorkspace, inputs: &[f64], body: usize, contact: usize) -> Option<BodyMotion> {
        let start = first(self.wheelsets.len(), contact);
        let &[y, z, vy, vz] = inputs.get(start..start + RAIL_INPUTS)? else { return None };
        let mut motion = system.motions[body];
        let (displacement, velocity) = match system.stations.get(body) {
            None => (Vector3::new(0.0, y, z), Vector3::new(0.0, vy, vz)),
            Some(station) => {
                let roll_rate = station.travel * station.frame.turn.x;
                let axes = &station.frame.axes;
                (axes * Vector3::new(0.0, y, z), axes * Vector3::new(0.0, vy - roll_rate * z, vz + roll_rate * y))
            }
        };
        motion.position -= displacement;
        motion.velocity -= velocity;
        Some(motion)
    }
}
