//! How bodies of a search move beside the pattern: on displaced rails, and aside for a trial.

use super::rails::Riding;
use super::search::Search;
use crate::formulation::{EvaluationError, contact_index};
use crate::geometry::Side;
use crate::mbs::body::COORDINATES;
use nalgebra::Vector3;

impl Search<'_> {
    /// Moves bodies to where a further share of the displacements takes them in first approximation.
    pub fn move_along(&mut self, riding: &Riding, further: f64) {
        for (at, ride) in self.now.at.iter_mut().zip(&riding.bodies) {
            for (coordinate, place) in at.coordinates.iter_mut().zip(&ride.places) {
                *coordinate += further * place;
            }
        }
    }

    /// Lets bodies ride on rails with a share of their displacements.
    pub fn ride(&mut self, riding: &Riding, share: f64) {
        self.rides = riding.bodies.iter().map(|ride| ride.times(share)).collect();
        self.bend();
    }

    /// Lets bodies ride as they do in another search for the same vehicle.
    pub fn ride_as(&mut self, other: &Search) {
        self.rides.clone_from(&other.rides);
        self.bend();
    }

    /// What bodies that ride are to have of accelerations.
    fn bend(&mut self) {
        let square = self.pattern.centripetal * self.pattern.speed.powi(2);
        self.accelerations = self.rides.iter().map(|ride| ride.bends.map(|bend| square * bend)).collect();
        self.riding = true;
    }

    /// The part of accelerations off the balance that constraints allow: the nearest in kinetic energy, as with velocities. The rest is what
    /// constraints demand of bodies that ride (a bar goes up with its axle boxes, and with squares of velocities).
    pub fn allowed(&mut self, off: &mut [f64]) -> Result<(), EvaluationError> {
        let bodies = self.rides.len();
        for body in 0..bodies {
            let (axes, off) = (self.axes(body), &off[COORDINATES * body..]);
            let velocities = &mut self.y[self.model.system.velocities(body)];
            velocities[..3].copy_from_slice((axes * Vector3::new(off[0], off[1], off[2])).as_slice());
            velocities[3..].copy_from_slice(&off[3..COORDINATES]);
        }
        self.model.at(&mut self.workspace, 0.0, &mut self.y, &mut self.now.memory).project()?;
        for body in 0..bodies {
            let v = &self.y[self.model.system.velocities(body)];
            let along = self.axes(body).tr_mul(&Vector3::new(v[0], v[1], v[2]));
            off[COORDINATES * body..][..COORDINATES].copy_from_slice(&[along.x, along.y, along.z, v[3], v[4], v[5]]);
        }
        Ok(())
    }

    /// Lets no pressed contact be compressed: corrects the wheelsets' vertical and roll velocities, which the first approximation takes from
    /// the rails' heights alone.
    pub fn follow_contacts(&mut self) {
        for (wheelset, ride) in self.model.wheelsets.iter().zip(&mut self.rides) {
            let centre = self.workspace.system.motions[wheelset.body].position;
            // Rate of penetration per upward and per roll velocity of the wheelset.
            let rows = Side::BOTH.map(|side| {
                let index = contact_index(wheelset.body, side);
                let most = self.workspace.reports(index).max_by(|a, b| a.normal_force.total_cmp(&b.normal_force))?;
                let (n, arm) = (most.axes.normal, most.wheel_point - centre);
                (most.normal_force > 0.0).then_some((most.penetration_rate, -n.z, n.y * arm.z - n.z * arm.y))
            });
            let [Some((left, a, b)), Some((right, c, d))] = rows else { continue };
            let determinant = a * d - b * c;
            // Contacts side by side, or on flanks, do not hold both.
            if determinant.abs() > 0.1 {
                ride.slopes[2] -= (left * d - right * b) / determinant / self.now.travel;
                ride.slopes[4] -= (right * a - left * c) / determinant / self.now.travel;
            }
        }
    }
}
