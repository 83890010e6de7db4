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
//! p* = p - A u        slip: (v* - l) . e1, (v* - l) . e2        rate of penetration: -(v* - c) . n,  c = s' A (u_s + omega x u)
//! l = e (c . n) / (e . n),   e up in the plane of the wheel, across the rail: the rail's direction x the axle, which on a grade is not plumb
//! ```
//!
//! c is what the travelling wheel meets of a bent rail: under the wheel u changes by `du/dt = w + s' u_s`. A wheel that rolls along a bent rail at rest does not slide, and
//! l is why: on a rail that rises (or whose flank comes nearer) ahead, the wheel touches ahead of its lowest place, by `(c . n) / (e . n)` over the speed of turning, and
//! there its material is on its way down with l against that of the lowest place. Without it a wheel on a rail that rises with 1e-3 slips to the side by 1e-3 times the sine of
//! the contact angle: 3e-5 on a tread, nearly 1e-3 on a flange. A model of track that travels with the wheels (a mass under each) has no slope; a beam or bridge has.
//! Orientation, distance, travelling speed V and rolling direction are the wheelset's own.
//!
//! *Forces* lie on the rail, whose plane of contact is tilted along it: with N, n and the creep force F_1 along x (the axes of the track), each force of a contact gets
//!
//! ```text
//! dF = e F_1 (u_s . n) / (e . n) - x (u_s . n) N      and the moment about the axle  -r (u_s . n) / (e . n) (F . e)
//! ```
//!
//! with r the rolling radius: the force acts ahead of the lowest place. So a rolling wheel is held back by `-(u_s . n) N`, in the axle's height, and the work of it is what the
//! wheel's climb brings; a wheel that slides goes along the tilted plane, and its friction with it. Reported forces have that.
//!
//! *Left out:* what a bent rail's turn makes of places: a slope of 1e-3 moves a contact by R 1e-3 = 0.5 mm along the rail, where a bend over 10 m has changed by 1e-4
//! of its height, and `R u_s^2 / 2` (0.2 um for 1e-3, 6 um for 5e-3) in the wheel's height; reported places stay.
//! A displacement that does not change by w + s' u_s is taken as it is: penetration follows the displacement, damping and creepage
//! the velocity, and the energy of the coupled system does not balance.
//!
//! Rigid contact (ACCF, ECCF) is refused: its constraints would need the rail's acceleration too.

use super::inputs::{RAIL_INPUTS, first_of_rail};
use super::rail_scratch::RailScratch;
use super::{AssemblyError, ContactReport, Model, Workspace};
use crate::mbs::body::{BodyMotion, Wrench};
use crate::mbs::system::SystemWorkspace;
use nalgebra::Vector3;

/// A wheelset as the rail under one of its wheels sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct AgainstRail {
    /// p* and v*.
    pub motion: BodyMotion,
    pub climb: Climb,
    /// u_s of a rail that is bent, across the track, in the world.
    pub slope: Option<Vector3<f64>>,
    /// Of a wheel that is not round.
    pub round: Option<Swollen>,
}

/// What a travelling wheel meets of its rail and of its own outline.
#[derive(Clone, Copy, Debug)]
pub(super) struct Climb {
    /// c, m/s.
    pub velocity: Vector3<f64>,
    /// e.
    pub up: Vector3<f64>,
}

impl Default for Climb {
    /// Of a round wheel on a straight rail at rest.
    fn default() -> Self {
        Climb { velocity: Vector3::zeros(), up: Vector3::z() }
    }
}

impl Climb {
    /// l of a contact with this normal, m/s.
    #[inline]
    pub fn lead(&self, normal: &Vector3<f64>) -> Vector3<f64> {
        self.up * (self.velocity.dot(normal) / upright(self.up.dot(normal)))
    }
}

/// A wheel that is not round (`out_of_round`): d e [m], d' e [m/rad], d'' e [m/rad2], and the axle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Swollen {
    pub larger: Vector3<f64>,
    pub growing: Vector3<f64>,
    pub bending: Vector3<f64>,
    pub axle: Vector3<f64>,
}

/// A flank is taken to be no steeper than this against the plane of its wheel, cosine.
const STEEPEST: f64 = 0.1;

/// The cosine between the normal of a contact and the plane of its wheel, e . n.
fn upright(cosine: f64) -> f64 {
    cosine.max(STEEPEST)
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
        let bent = slope != Vector3::zeros();
        let (displacement, velocity, slope, climb) = match system.stations.get(body) {
            None => {
                let up = motion.frame.axes.column(2).into_owned();
                (displacement, velocity, slope, Climb { velocity: slope * motion.speed, up })
            }
            Some(station) => {
                let (axes, turn) = (&station.frame.axes, &station.frame.turn);
                let met = slope + turn.cross(&displacement);
                // A wheelset's own axes do not follow the grade.
                let up = axes.column(0).cross(&motion.axle()).normalize();
                (axes * displacement, axes * velocity, axes * slope, Climb { velocity: axes * met * station.travel, up })
            }
        };
        motion.position -= displacement;
        motion.velocity -= velocity;
        let mut moved = AgainstRail { motion, climb, slope: bent.then_some(slope), round: None };
        if let Some(Some(wheel)) = self.out_of_round.get(contact) {
            moved.swell(wheel);
        }
        Some(moved)
    }

    /// Lays the forces of a wheel's contacts on a rail that is bent: what this adds to the wheel's wrench, about where it stands against its rail.
    pub(super) fn lay_on_bent_rail(&self, workspace: &mut Workspace, moved: &AgainstRail, (contact, body): (usize, usize)) -> Wrench {
        let Some(slope) = moved.slope else { return Wrench::default() };
        let (along, up) = (workspace.system.stations.along(body), moved.climb.up);
        let (first, further) = self.reports(contact, &mut workspace.contacts, &mut workspace.further_contacts);
        let mut wrench = Wrench::default();
        for report in std::iter::once(first).chain(further) {
            let normal = &report.axes.normal;
            let (pressing, tilt) = (report.force.dot(normal), slope.dot(normal));
            let creeping = (report.force - normal * pressing).dot(&along);
            let force = up * (creeping * tilt / upright(up.dot(normal))) - along * (tilt * pressing);
            report.force += force;
            wrench.force += force;
            wrench.moment += (report.wheel_point - moved.motion.position).cross(&force);
        }
        wrench.moment += self.turned_by_lead(workspace, moved, contact);
        wrench
    }

    /// The moment of a wheel's contacts about its axle on a rail that is bent, because they are ahead of its lowest place, N m.
    pub(super) fn turned_by_lead(&self, workspace: &Workspace, moved: &AgainstRail, contact: usize) -> Vector3<f64> {
        let Some(slope) = moved.slope else { return Vector3::zeros() };
        let (up, axle) = (moved.climb.up, moved.motion.axle());
        let turned = |report: &ContactReport| {
            let radius = -(report.wheel_point - moved.motion.position).dot(&up);
            let normal = &report.axes.normal;
            -radius * slope.dot(normal) / upright(up.dot(normal)) * report.force.dot(&up)
        };
        axle * workspace.reports(contact).map(turned).sum::<f64>()
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
