//! Mass that rests on a body and goes along the track with it: the inertia of a vertical load ([`super::force::VerticalLoad`]).
//!
//! What rests on a wheelset moves with it along the track, but not across: a suspension holds it there. Its velocity is the part
//! of the wheelset's velocity v along the track's unit tangent X, `v_L = S X` with `S = v . X`. With the travel s' of the track frame
//! and `X_s = dX/ds`, and M the supported mass,
//!
//! ```text
//! a_L = S_dot X + S s' X_s,   S_dot = a . X + v . X_s s'
//! m a + M S_dot X = F         =>   a . X = (F . X - M v . X_s s') / (m + M),   across: a = F / m
//! ```
//!
//! F has all forces, also the load's weight and `-M S s' X_s`, which its force element applies. The body's mobility is
//! `(1 - M / (m + M) X X^T) / m`. Where a body's speed is imposed and constant S_dot is zero: nothing of this is there. Where it changes the driving force moves M too ([`super::driving`]).

use super::body::BodyMotion;
use super::kkt::Mobility;
use crate::geometry::track::station::Station;
use nalgebra::Vector3;

/// Inertia along the track beside a body's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportedMass {
    pub body: usize,
    /// M, kg.
    pub mass: f64,
}

impl SupportedMass {
    /// Takes off a linear acceleration [m/s2] of the body, of mass `own` [kg], what the supported mass takes; no station: straight track.
    #[inline]
    pub(super) fn hold_back(&self, own: f64, station: Option<&Station>, motion: &BodyMotion, linear: &mut [f64]) {
        let share = self.mass / (own + self.mass);
        let Some(station) = station else {
            linear[0] -= share * linear[0];
            return;
        };
        let along = station.frame.along();
        let rate = linear.iter().zip(along.iter()).map(|(a, x)| a * x).sum::<f64>() + station.swing_of_speed(&motion.velocity);
        for (a, x) in linear.iter_mut().zip(along.iter()) {
            *a -= share * rate * x;
        }
    }

    /// Takes the share of the supported mass out of the body's mobility.
    #[inline]
    pub(super) fn slow_down(&self, own: f64, station: Option<&Station>, mobility: &mut Mobility) {
        let along = station.map_or(Vector3::x(), |station| station.frame.along());
        let less = along * along.transpose() * (self.mass / (own + self.mass) / own);
        let mut linear = mobility.fixed_view_mut::<3, 3>(0, 0);
        linear -= less;
    }
}
