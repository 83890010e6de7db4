//! What imposed speeds ([`super::driving`]) take of a system: the forces of driving constraints, and speeds that are kept to their tables, or to that of the leading body.

use super::body::BodyMotion;
use super::driving::{Course, DrivingConstraint};
use super::speed_profile::Over;
use super::system::{System, SystemWorkspace};
use crate::geometry::track::station::Station;
use nalgebra::Vector3;

/// A speed that is off by less than this [m/s] stays as it is: rounding.
const KEPT: f64 = 1e-12;

impl System {
    /// Force of a driving constraint [N] on a curved track with what it demands [m/s2], where all else loads its body with `other` [N].
    #[inline]
    pub(super) fn force_in_curve(
        &self,
        drive: &DrivingConstraint,
        demand: f64,
        other: &Vector3<f64>,
        motion: &BodyMotion,
        station: &Station,
    ) -> f64 {
        let force = self.bodies[drive.body].mass * demand - other.dot(&station.frame.along());
        if drive.is_constant() {
            return force;
        }
        force + self.supported_by(drive.body) * (demand + station.swing_of_speed(&motion.velocity))
    }

    /// The same on straight track.
    #[inline]
    pub(super) fn force_on_straight(&self, drive: &DrivingConstraint, demand: f64, other: f64) -> f64 {
        if drive.is_constant() {
            return -other;
        }
        (self.bodies[drive.body].mass + self.supported_by(drive.body)) * demand - other
    }

    /// M, kg.
    fn supported_by(&self, body: usize) -> f64 {
        self.supported.iter().filter(|supported| supported.body == body).map(|supported| supported.mass).sum()
    }

    /// Gives bodies whose speed comes from a table just that speed, and where it follows an input that of the leading one. On a curved track the workspace holds motions and stations at `y`. Returns whether anything was changed.
    pub fn keep_speeds(&self, t: f64, y: &mut [f64], workspace: &SystemWorkspace) -> bool {
        let mut moved = false;
        for drive in &self.drives {
            let stations = &workspace.stations;
            let leader = stations.get(drive.leader);
            let speed = match &drive.course {
                Course::Constant => continue,
                Course::Input(_) if drive.body == drive.leader => continue,
                Course::Input(_) => leader.map_or(y[self.velocities(drive.leader).start], |station| station.speed),
                Course::Profile(profile) if profile.over == Over::Time => profile.at(t)[0],
                Course::Profile(profile) => {
                    profile.at(leader.map_or(y[self.coordinates(drive.leader).start], |station| station.frame.distance))[0]
                }
            };
            let first = self.velocities(drive.body).start;
            let along = stations.along(drive.body);
            let linear = &mut y[first..first + 3];
            let off = speed - linear.iter().zip(along.iter()).map(|(v, x)| v * x).sum::<f64>();
            if off.abs() > KEPT {
                linear.iter_mut().zip(along.iter()).for_each(|(v, x)| *v += off * x);
                moved = true;
            }
        }
        moved
    }
}
