//! What an evaluation says of one contact.

use crate::contact::Patch;
use crate::contact::creepage::{ContactAxes, CreepForce, Creepage, Slip};
use crate::contact::profile_end::ProfileEnd;
use crate::contact::search::algebraic::SurfaceParameters;
use crate::contact::strips::Near;
use crate::contact::transient;
use crate::geometry::profile::{Profile, ProfilePoint};
use crate::mbs::body::Wrench;
use nalgebra::Vector3;

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
    /// Moment of the normal forces of a part of a patch of strips about its centre, N m.
    pub couple: Vector3<f64>,
    /// mu N of a part of a patch of strips, N: where parts are partly one, friction that varies across the head is mixed as their forces are.
    pub friction_bound: Option<f64>,
    pub iterations: usize,
    /// Is the contact a constraint (its normal force a multiplier), not elastic?
    pub constrained: bool,
}

impl ContactReport {
    /// Is it pressed, or a constraint that holds?
    pub fn carries(&self) -> bool {
        self.constrained || self.normal_force > 0.0
    }

    /// The end of a wheel's or a rail's profile, if the loaded patch reaches it.
    pub fn profile_end(&self, wheel: &dyn Profile, rail: &dyn Profile) -> Option<ProfileEnd> {
        let reach = |k: usize, coordinate: f64| {
            let half = self.patch.b / self.profiles[k].d1.hypot(1.0);
            [coordinate - half, coordinate + half]
        };
        let SurfaceParameters { wheel: u, rail: eta, .. } = self.parameters;
        if self.normal_force > 0.0 { ProfileEnd::within((wheel, reach(0, u)), (rail, reach(1, eta))) } else { None }
    }

    /// Where it is, for strips that are to be pressed there again.
    pub fn near(&self) -> Near {
        Near { eta: self.parameters.rail, lead: self.parameters.lead, overlap: self.penetration }
    }

    /// Adds `force` [N] of this contact and its spin moment to the wrench of a wheelset whose centre is at `centre`.
    #[inline]
    pub(super) fn add_to(&self, wrench: &mut Wrench, force: Vector3<f64>, centre: &Vector3<f64>) {
        wrench.add_at(force, &self.wheel_point, centre);
        wrench.moment += self.axes.normal * self.creep_force.spin_moment + self.couple;
    }
}
