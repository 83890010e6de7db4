//! Velocity and acceleration of the gap between wheel and rail at their located contact (Eqs. 17, 19, 22, 23).
//!
//! The surface parameters s follow from the four equations E(s, q) = 0 of [`super::algebraic`] (Eq. 16), so they move with
//! `s' = B q' = -(dE/ds)^-1 dE/dt` (Eq. 19), where dE/dt is taken at fixed s: the rail rests, the wheel's surface moves with
//! the axle frame (velocity v of its centre, angular velocity W; spin does not change a surface of revolution):
//!
//! ```text
//! dE1/dt = t_s . v_w,   dE2/dt = t_eta . v_w,   dE3/dt = (W x t_u) . m,   dE4/dt = (W x t_angle) . m,   v_w = v + W x rho
//! ```
//!
//! with rho from the centre to the wheel's point, m the rail's normal before and n after normalising. The gap `g = n . r`
//! (Eq. 17) does not change with s to first order: n . t = 0 for all four tangents, and dn/ds is normal to n and so to r.
//! Hence `C_s^n = 0` wherever Eq. 16 holds; in the second derivative of Eq. 17 the term `C_s^n (B q'' + B' q')` (Eq. 22)
//! vanishes exactly, and
//!
//! ```text
//! g' = n . (v + W x rho)                                                   = H q'
//! g'' = n . (a + W' x rho) + n' . v_w + n . (W x rho')                     = H q'' - Q_cn
//! rho' = W x rho + t_u u' + t_angle angle',   n' = (m' - n (n . m')) / |m|,   m' = m_s s' + m_eta eta'
//! ```
//!
//! so that Q_cn holds the exact derivative of H along the motion with second derivatives of the surfaces only.

use super::algebraic::{Candidate, ContactLocation, Pair, SurfaceParameters};
use crate::math::newton::NewtonFailure;
use crate::math::rotation::CarrierMotion;
use nalgebra::{Vector3, Vector4};

/// The contact with the first two time derivatives of its gap.
#[derive(Clone, Copy, Debug)]
pub struct MovingContact {
    pub location: ContactLocation,
    /// rho: from the wheelset's centre to the wheel's point, m.
    pub arm: Vector3<f64>,
    /// g', m/s: minus the rate of the penetration.
    pub gap_rate: f64,
    /// g'' when all coordinates have zero acceleration, m/s2: -Q_cn.
    pub gap_bias: f64,
    /// Time derivatives of u, angle, distance along the rail, eta.
    pub parameter_rates: Vector4<f64>,
}

impl Pair<'_> {
    /// Finds the contact from a warm start, with the motion of its gap.
    ///
    /// # Errors
    /// [`NewtonFailure`] when the iteration finds no solution.
    #[inline]
    pub fn locate_moving(&self, start: &SurfaceParameters, carrier: &CarrierMotion) -> Result<MovingContact, NewtonFailure> {
        let (location, at) = self.solve(start)?;
        self.motion(location, &at, carrier).ok_or(NewtonFailure { iterations: location.iterations, residual: 0.0 })
    }

    /// `None` where dE/ds is singular.
    #[inline]
    fn motion(&self, location: ContactLocation, at: &Candidate, carrier: &CarrierMotion) -> Option<MovingContact> {
        let CarrierMotion { velocity, rotation, rotation_bias } = *carrier;
        let (wheel, rail, normal) = (&at.wheel, &at.rail, location.normal);
        let arm = wheel.position - self.centre;
        let arm_rate = rotation.cross(&arm);
        let point_velocity = velocity + arm_rate;
        let explicit = Vector4::new(
            rail.t1.dot(&point_velocity),
            rail.t2.dot(&point_velocity),
            rotation.cross(&wheel.t1).dot(&at.normal),
            rotation.cross(&wheel.t2).dot(&at.normal),
        );
        let rates = -(self.jacobian(at).try_inverse()? * explicit);
        let arm_rate = arm_rate + wheel.t1 * rates[0] + wheel.t2 * rates[1];
        let t1_rate = rail.t11 * rates[2] + rail.t12 * rates[3];
        let t2_rate = rail.t12 * rates[2] + rail.t22 * rates[3];
        let raw_rate = (t1_rate.cross(&rail.t2) + rail.t1.cross(&t2_rate)) * self.rail.side.sign();
        let normal_rate = (raw_rate - normal * normal.dot(&raw_rate)) / at.normal.norm();
        Some(MovingContact {
            location,
            arm,
            gap_rate: normal.dot(&point_velocity),
            gap_bias: normal_rate.dot(&point_velocity) + normal.dot(&(rotation_bias.cross(&arm) + rotation.cross(&arm_rate))),
            parameter_rates: rates,
        })
    }
}
