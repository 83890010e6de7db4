//! Rails that move under the wheels: their motion comes from outside, as of a model of track or bridge, or from track that gives way (`travelling_track`, `rail_beam`).
//!
//! The rail under a wheel is displaced by `u = (0, u_y, u_z)` in the axes of the track frame beside the wheelset's centre (left and up
//! positive), the same along and around the contact; its material there moves with the velocity w = (0, w_y, w_z), and it is bent
//! with the slope u_s = du/ds along the track. Then wheel and rail stand to each other as if the rail were in its place and
//! the wheel displaced by -u, so that search, slip and moment arms need nothing but a shifted motion of the wheelset, one for each
//! wheel. With A the track frame's axes, omega its turn per length (own axes), s' its travel, v the velocity of the wheel's material
//! point and v* = v - A w that against the rail's material:
//!
//! ```text
//! p* = p - A u        slip: v* . e1, v* . e2        rate of penetration: -(v* - c) . n,  c = s' A (u_s + omega x u)
//! ```
//!
//! c is what the travelling wheel meets of a bent rail: under the wheel u changes by `du/dt = w + s' u_s`. It is part of the rate
//! of penetration but no slip: a wheel that rolls along a bent rail at rest does not slide. A model of track that travels with
//! the wheels (a mass under each) has no slope; a beam or bridge has, and left out at 40 m/s a slope of 1e-3 is
//! an error of 0.04 m/s in the rate of penetration, thus in the contact's damping (5.6 kN at 70 um and C = 2e9 N s/m2) and nowhere else.
//! Orientation, distance, travelling speed V and rolling direction are the wheelset's own.
//!
//! *Left out:* the turn of a bent rail itself: the normal force's part along X (N du_z/ds), spin and lead (a slope of 1e-3
//! moves a contact by R 1e-3 = 0.5 mm along the rail, where a bend over 10 m has changed by 1e-4 of its height).
//! A displacement that does not change by w + s' u_s is taken as it is: penetration follows the displacement, damping and creepage
//! the velocity, and the energy of the coupled system does not balance.
//!
//! Rigid contact (ACCF, ECCF) is refused: its constraints would need the rail's acceleration too.

use super::inputs::{RAIL_INPUTS, first_of_rail};
use super::rail_scratch::RailScratch;
use super::{AssemblyError, Model};
use crate::mbs::body::BodyMotion;
use crate::mbs::system::SystemWorkspace;
use nalgebra::Vector3;

/// A wheelset as the rail under one of its wheels sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct AgainstRail {
    /// p* and v*.
    pub motion: BodyMotion,
    /// c, m/s.
    pub climb: Vector3<f64>,
    /// Of a wheel that is not round.
    pub round: Option<Swollen>,
}

/// A wheel that is not round (`out_of_round`): d e [m], d' e [m/rad], d'' e [m/rad2], and the axle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Swollen {
    pub larger: Vector3<f64>,
    pub growing: Vector3<f64>,
    pub bending: Vector3<f64>,
    pub axle: Vector3<f64>,
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
        self.surfaces_move |= asked;
        Ok(self)
    }

    /// A wheelset, with the motion of the wheel of this contact, against the rail under it; `None` where rails do not move.
    #[inline]
    pub(super) fn against_rail(
        &self,
        (system, rails): (&SystemWorkspace, &RailScratch),
        (inputs, y): (&[f64], &[f64]),
        (body, turning): (usize, usize),
        contact: usize,
    ) -> Option<AgainstRail> {
        if !self.surfaces_move {
            return None;
        }
        let [displacement, velocity, slope] = self.rail_under(rails, inputs, y, contact)?;
        let mut motion = system.motions[turning];
        let (displacement, velocity, climb) = match system.stations.get(body) {
            None => (displacement, velocity, slope * motion.speed),
            Some(station) => {
                let (axes, turn) = (&station.frame.axes, &station.frame.turn);
                (axes * displacement, axes * velocity, axes * (slope + turn.cross(&displacement)) * station.travel)
            }
        };
        motion.position -= displacement;
        motion.velocity -= velocity;
        let mut moved = AgainstRail { motion, climb, round: None };
        if let Some(Some(wheel)) = self.out_of_round.get(contact) {
            moved.swell(wheel);
        }
        Some(moved)
    }

    /// u, w and u_s of the rail under a wheel in the track frame.
    fn rail_under(&self, rails: &RailScratch, inputs: &[f64], y: &[f64], contact: usize) -> Option<[Vector3<f64>; 3]> {
        let across = |y: f64, z: f64| Vector3::new(0.0, y, z);
        if self.rail_motion {
            let start = first_of_rail(self.wheelsets.len(), contact);
            let &[y, z, vy, vz, slope_y, slope_z] = inputs.get(start..start + RAIL_INPUTS)? else { return None };
            return Some([across(y, z), across(vy, vz), across(slope_y, slope_z)]);
        }
        if self.beam.is_some() {
            return self.beam_under(&rails.under, y, contact);
        }
        match &y[self.rail_states(contact)] {
            &[y, z, vy, vz] => Some([across(y, z), across(vy, vz), Vector3::zeros()]),
            _ => Some([Vector3::zeros(); 3]),
        }
    }
}
