//! What lies ahead of a vehicle, so that no step is longer than what its first evaluation can speak for.
//!
//! *Track.* Each wheelset travels at most [`crate::geometry::track::waves::Waves::reach`] in a step: a part of the shortest wave where it
//! is, and no further than such a part into what its rails or the centre line have ahead of it.
//!
//! *Landing.* A wheel in the air feels nothing of its rail, and in free flight every method is exact: nothing would stop a step from ending
//! below the rail. With gap g, closing speed r and closing acceleration a of the nearest place, from the state and its derivative,
//!
//! ```text
//! g = r t + a t^2 / 2      a step takes at most t + e / v,   v = sqrt(r^2 + 2 a g): speed at the touch
//! ```
//!
//! with e = 20 um: at most that deep (a third of a static penetration) has the wheel come when its step ends, wherever the rail is plain. What
//! happens from there on is the error control's.

use super::step::WheelRef;
use super::tangent::normal_slopes;
use super::{ContactReport, Model, Wheelset, Workspace};
use crate::geometry::track::station::Station;
use crate::mbs::body::{BodyMotion, COORDINATES};
use crate::mbs::force::Strike;
use nalgebra::Vector3;

/// e, m.
const ENTRY: f64 = 2e-5;
/// Of the load tolerance that the estimate for one step may use: forces between the ends of steps, and where places of contact join or part,
/// are off by up to five times what is estimated at the ends (a coach on irregular track, tolerances 1e-4 to 1e-6).
const PART: f64 = 0.2;
/// ... where a wheel's bouncing on its contact fades so fast, s. Errors of a bouncing that lasts longer add up in it, most of all in its phase:
/// less is allowed in that proportion, down to what adds up over the longest time.
const FADING: f64 = 0.06;
const LONGEST_FADING: f64 = 2.0;
/// The same part for stops along the track: a strike multiplies an error of the speeds before it, and a train has many of them, one after the other.
/// (Three coaches with 30 mm of slack, braked one after the other: coupler forces of 93 kN were off by 45 kN without a bound, by 26, 9, 5 and 2 kN with parts of 0.2,
/// 0.07, 0.02, 0.007.)
const STRIKING: f64 = 0.007;
/// The same part for forces that impose speeds: what they are off by adds up to their work.
const DRIVING: f64 = 0.02;

impl Model {
    /// The longest step that may begin at the state `y` with derivative `dy`, s, whose evaluation the workspace holds.
    pub fn longest_step(&self, workspace: &Workspace, dy: &[f64]) -> f64 {
        let mut longest = self.longest_known(workspace);
        for WheelRef { contact, wheelset, .. } in self.wheels() {
            // A report without iterations belongs to no place.
            let mut places = workspace.reports(contact).filter(|report| report.iterations > 0 || report.penetration != 0.0).peekable();
            if places.peek().is_some() && places.all(|report| report.normal_force <= 0.0 && report.penetration < 0.0 && !report.constrained)
            {
                for report in workspace.reports(contact).filter(|report| report.penetration < 0.0) {
                    longest = longest.min(self.time_to_touch((wheelset, contact), workspace, report, dy));
                }
            }
        }
        longest
    }

    /// The part of it that the track alone asks for, s.
    pub fn longest_known(&self, workspace: &Workspace) -> f64 {
        let mut longest = self.longest_of_wheels(workspace).min(self.longest_on_sleepers(workspace));
        for WheelRef { wheelset, side, .. } in self.wheels() {
            let motion = &workspace.system.motions[wheelset.body];
            let travel = workspace.system.stations.get(wheelset.body).map_or(motion.speed, |Station { travel, .. }| *travel);
            let reach = self.track.rail(side).waves().reach(motion.distance, travel);
            // At rest nothing comes nearer.
            if reach < f64::INFINITY && travel != 0.0 {
                longest = longest.min(reach / travel.abs());
            }
        }
        longest
    }

    fn time_to_touch(&self, (wheelset, contact): (&Wheelset, usize), workspace: &Workspace, report: &ContactReport, dy: &[f64]) -> f64 {
        let motion = &workspace.system.motions[wheelset.body];
        let rates = &dy[self.system.velocities(wheelset.body)];
        let (moved, turned) = without_pitch(motion, rates);
        let mut acceleration = moved + turned.cross(&(report.wheel_point - motion.position));
        if let Some([_, rail]) = self.rail_change(workspace, wheelset.body, contact, dy) {
            acceleration -= rail;
        }
        let normal = &report.axes.normal;
        let (gap, closing, faster) = (-report.penetration, report.penetration_rate, -acceleration.dot(normal));
        let at_touch = closing * closing + 2.0 * faster * gap;
        if !(at_touch > 0.0) || (closing <= 0.0 && faster <= 0.0) {
            return f64::INFINITY;
        }
        let speed = at_touch.sqrt();
        // The first root without the difference of nearly equal numbers.
        let time = if closing > 0.0 { 2.0 * gap / (closing + speed) } else { (speed - closing) / faster };
        time + ENTRY / speed
    }

    /// Changes of the contacts' forces that an error `error` of the state makes, in parts of what the scene allows
    /// ([`Model::load_tolerance`]): the largest over all wheels, of normal and creep force. The workspace holds an evaluation nearby.
    pub fn load_error(&self, workspace: &Workspace, error: &[f64]) -> f64 {
        let contacts = self.wheels().map(|wheel| self.contact_error(workspace, &wheel, error)).fold(0.0, larger);
        larger(larger(contacts, self.strike_error(workspace, error)), self.wave_error(workspace, error))
    }

    /// The same at one wheel.
    ///
    /// `dN = N' n . d P`, P the wheel's point, or what a velocity across the contact becomes when the wheel of mass m bounces on it,
    /// `sqrt(N' m) n . d P'`: the force that a wrong speed of impact will have. Creep forces grow with slip by no more than linear theory says, `G a b C / V`, C the larger of
    /// Kalker's C11 and C22 (about 5), those of transient contact with its deflection as its stiffness says, and never beyond twice the friction bound.
    pub(super) fn contact_error(&self, workspace: &Workspace, &WheelRef { contact, wheelset, side }: &WheelRef, error: &[f64]) -> f64 {
        const KALKER: f64 = 5.0;
        /// Below, a contact with deflection answers with its stiffness, not with slip, m/s.
        const SLOW: f64 = 0.5;
        let velocities = COORDINATES * self.system.bodies.len();
        let mut largest: f64 = 0.0;
        let motion = &workspace.system.motions[wheelset.body];
        let part = |first: usize| {
            let e = &error[first + COORDINATES * wheelset.body..first + COORDINATES * (wheelset.body + 1)];
            let (moved, turned) = without_pitch(motion, e);
            (moved, turned, motion.axle() * e[5])
        };
        let ((mut moved, turned, _), (mut velocity, turning, spin)) = (part(0), part(velocities));
        if let Some([displaced, displacing]) = self.rail_change(workspace, wheelset.body, contact, error) {
            (moved, velocity) = (moved - displaced, velocity - displacing);
        }
        for (slot, report) in workspace.reports(contact).enumerate().filter(|(_, report)| report.normal_force > 0.0) {
            let arm = report.wheel_point - motion.position;
            let axes = &report.axes;
            let scale = self.per_allowed(wheelset, report);
            let slip = velocity + (turning + spin).cross(&arm);
            if !report.constrained {
                let sunk = (moved + turned.cross(&arm)).dot(&axes.normal);
                let slope = report.share * report.elastic_slope;
                let impedance = (slope * self.bouncing_mass(wheelset)).sqrt();
                let lasting = self.lasting_of_bouncing(wheelset, report);
                largest = larger(largest, (slope * sunk).abs().max((impedance * slip.dot(&axes.normal)).abs()) * scale * lasting);
            }
            let slip = slip.dot(&axes.e1).hypot(slip.dot(&axes.e2));
            let stiffness = self.laws.material.shear_modulus() * report.patch.a * report.patch.b * KALKER;
            let speed = wheelset.speed(motion).abs();
            let by_deflection = self.laws.transient.as_ref().map_or(0.0, |transient| {
                let first = self.deflection(contact, slot).start;
                transient.force_of(report.patch, speed, [error[first], error[first + 1]])
            });
            let creep = (stiffness * slip / speed.max(SLOW)).max(by_deflection);
            largest = larger(largest, creep.min(2.0 * self.friction_at(side, motion, report) * report.normal_force) * scale);
        }
        largest
    }

    /// 1 over the change of a contact's forces that is allowed in a step, 1/N.
    pub(super) fn per_allowed(&self, wheelset: &Wheelset, report: &ContactReport) -> f64 {
        1.0 / (PART * self.load_tolerance * wheelset.static_wheel_load.max(report.normal_force))
    }

    /// The same of stops along the track (couplers, buffers): `k e . d x`, or what a velocity along their line becomes when they strike, `sqrt(k m) e . d x'` with
    /// the reduced mass m of their ends; in parts of what the scene allows of the first wheelset's static wheel load.
    ///
    /// Nothing else holds vehicles along the track, so an error of their speeds lasts until the next strike, and each one hands it on.
    fn strike_error(&self, workspace: &Workspace, error: &[f64]) -> f64 {
        let Some(wheelset) = self.wheelsets.first() else { return 0.0 };
        let bodies = workspace.system.moving();
        let velocities = COORDINATES * self.system.bodies.len();
        let mut largest: f64 = 0.0;
        let along = |strike: &Strike| {
            let body = strike.ends.into_iter().flatten().next()?;
            strike.along(&workspace.system.stations.along(body))
        };
        let strikes = self.system.forces.iter().filter_map(|element| element.strike(&bodies));
        for Strike { stiffness, unit, point, ends } in strikes.filter(|strike| along(strike).is_some()) {
            let (mut moved, mut moving, mut lightness) = (0.0, 0.0, 0.0);
            for (end, sign) in ends.into_iter().zip([-1.0, 1.0]) {
                let Some(body) = end else { continue };
                let motion = &workspace.system.motions[body];
                let along = |first: usize| {
                    let (moved, turned) = without_pitch(motion, &error[first + COORDINATES * body..first + COORDINATES * (body + 1)]);
                    sign * (moved + turned.cross(&(point - motion.position))).dot(&unit)
                };
                moved += along(0);
                moving += along(velocities);
                lightness += 1.0 / self.system.bodies[body].mass;
            }
            let force = (stiffness * moved.abs()).max((stiffness / lightness).sqrt() * moving.abs());
            largest = largest.max(force / (STRIKING * self.load_tolerance * wheelset.static_wheel_load));
        }
        largest
    }

    /// Change of the forces that impose speeds which an error of the state makes, in parts of what is allowed; at the linearisation of this step, of methods that
    /// have one. Elements along the track are stiff (62 MN/m at a coach's wheelset), so that an error of 1e-5 m, which is all of a tolerance, was one of
    /// some 300 N, to one side on every slope: the work of a whole climb had the wrong sign.
    pub fn driving_error(&self, workspace: &Workspace, error: &[f64]) -> f64 {
        let Some(tangent) = workspace.tangent.as_ref().filter(|_| workspace.linearised.is_some()) else { return 0.0 };
        let mut largest: f64 = 0.0;
        for drive in &self.system.drives {
            let Some(wheelset) = self.wheelsets.iter().find(|wheelset| wheelset.body == drive.body) else { continue };
            let along = workspace.system.stations.along(drive.body);
            let force = tangent.force_on(drive.body, error).dot(&along).abs();
            largest = largest.max(force / (DRIVING * self.load_tolerance * wheelset.static_wheel_load));
        }
        if largest.is_nan() { f64::INFINITY } else { largest }
    }

    /// How much longer than [`FADING`] a wheel's bouncing lasts, at least 1: half the wheelset's mass m on a contact whose damping is c fades
    /// with the time 2 m / c.
    fn lasting_of_bouncing(&self, wheelset: &Wheelset, report: &ContactReport) -> f64 {
        let damping = normal_slopes(self.laws.damping.as_ref(), report).by_rate;
        let fading = 2.0 * self.bouncing_mass(wheelset) / damping;
        (fading.min(LONGEST_FADING) / FADING).max(1.0)
    }
}

/// The larger of two errors; what is not a number is larger than any.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::INFINITY } else { a.max(b) }
}

/// Translation and rotation of six changes of a body's coordinates or velocities, without that of its pitch.
#[inline]
pub(super) fn without_pitch(motion: &BodyMotion, changes: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
    (Vector3::new(changes[0], changes[1], changes[2]), Vector3::z() * changes[3] + motion.roll_axis() * changes[4])
}
