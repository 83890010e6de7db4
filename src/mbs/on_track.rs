//! Coordinates of a body relative to the track frame at its own distance.
//!
//! Bodies move in the world; what a railway engineer asks for is counted from the track frame whose plane goes through the body's
//! centre P: distance s, `y = (P - C) . Y`, `z = (P - C) . Z`, and yaw, roll, pitch of `A_track^T A_body = Rz Rx Ry`. Velocities
//! are their time derivatives, but for the distance: there it is `v . X`, the speed along the track (s' is greater inside a curve).
//! With the frame's turn omega (per length, in its own axes):
//!
//! ```text
//! y' = v . Y + s' z omega_x,   z' = v . Z - s' y omega_x,   angular velocity relative to the frame: w - s' A omega
//! ```
//!
//! The pitch of a body of revolution is not an angle of its frame: its rate is the spin about the axle relative to the track.

use super::body::{BodyMotion, COORDINATES};
use crate::geometry::track::frame::TrackFrame;
use crate::geometry::track::station::Station;
use crate::math::rotation::AxleFrame;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Coordinates (distance, y, z, yaw, roll, pitch) and velocities relative to the track frame, m and rad, m/s and rad/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OnTrack {
    pub coordinates: [f64; COORDINATES],
    pub velocities: [f64; COORDINATES],
}

/// Yaw, roll and pitch of `Rz Rx Ry`, rad; yaw and pitch within half a turn.
fn angles(axes: &Matrix3<f64>) -> [f64; 3] {
    let roll = axes[(2, 1)].clamp(-1.0, 1.0).asin();
    [(-axes[(0, 1)]).atan2(axes[(1, 1)]), roll, (-axes[(2, 0)]).atan2(axes[(2, 2)])]
}

/// Rates of yaw, roll and pitch from an angular velocity in the axes of the frame `Rz Rx`.
fn rates(rotation: &Vector3<f64>, roll: f64) -> [f64; 3] {
    let yaw_rate = rotation.z / roll.cos();
    [yaw_rate, rotation.x, rotation.y - yaw_rate * roll.sin()]
}

/// The coordinates and velocities in the world that a body of that motion relative to `frame` has. `at.coordinates[0]` is not used: the
/// distance is the frame's.
pub fn place(frame: &TrackFrame, at: &OnTrack) -> ([f64; COORDINATES], [f64; COORDINATES]) {
    let [_, y, z, yaw, roll, pitch] = at.coordinates;
    let [speed, y_rate, z_rate, yaw_rate, roll_rate, pitch_rate] = at.velocities;
    let turn = &frame.turn;
    let travel = speed / (1.0 - (y * turn.z - z * turn.y));
    let position = frame.origin + frame.axes * Vector3::new(0.0, y, z);
    let velocity = frame.axes * Vector3::new(speed, y_rate - travel * z * turn.x, z_rate + travel * y * turn.x);
    let own = AxleFrame::new(yaw, roll);
    let (sin, cos) = pitch.sin_cos();
    let body = frame.axes * own.axes * Matrix3::new(cos, 0.0, sin, 0.0, 1.0, 0.0, -sin, 0.0, cos);
    let rotation = frame.axes * (own.axes * own.body_rate(yaw_rate, roll_rate, pitch_rate) + turn * travel);
    let [world_yaw, world_roll, world_pitch] = angles(&body);
    // Headings are counted through, and so are yaw angles.
    let near = frame.heading + yaw;
    let world_yaw = world_yaw + TAU * ((near - world_yaw) / TAU).round();
    let axle = AxleFrame::new(world_yaw, world_roll);
    let [yaw_rate, roll_rate, pitch_rate] = rates(&axle.axes.tr_mul(&rotation), world_roll);
    (
        [position.x, position.y, position.z, world_yaw, world_roll, world_pitch],
        [velocity.x, velocity.y, velocity.z, yaw_rate, roll_rate, pitch_rate],
    )
}

/// The motion of a body relative to the track frame at its station.
pub fn relative(motion: &BodyMotion, station: &Station) -> OnTrack {
    let frame = &station.frame;
    let turn = &frame.turn;
    let offset = frame.components(&(motion.position - frame.origin));
    let speed = frame.components(&motion.velocity);
    let [yaw, roll, pitch] = angles(&frame.axes.tr_mul(&motion.frame.axes));
    let rotation = frame.components(&motion.rotation) - turn * station.travel;
    let [yaw_rate, roll_rate, pitch_rate] = rates(&AxleFrame::new(yaw, roll).axes.tr_mul(&rotation), roll);
    let pitch = if motion.turn.is_some() { pitch } else { motion.pitch };
    let lift = station.travel * turn.x;
    OnTrack {
        coordinates: [frame.distance, offset.y, offset.z, yaw, roll, pitch],
        velocities: [station.speed, speed.y + lift * offset.z, speed.z - lift * offset.y, yaw_rate, roll_rate, pitch_rate],
    }
}

/// Accelerations of a body of revolution on the track from those of its coordinates in the world: rate of the speed along the track,
/// absolute accelerations along Y and Z of the track frame (with the centripetal part), second derivatives of yaw and roll relative
/// to the track, rate of the relative pitch rate.
pub fn accelerations(motion: &BodyMotion, station: &Station, world: &[f64]) -> [f64; COORDINATES] {
    let Station { frame, travel, .. } = station;
    let turn = &frame.turn;
    let linear = Vector3::new(world[0], world[1], world[2]);
    let along = frame.components(&linear);
    let offset = motion.position - frame.origin;
    // s'' from s' = v . X / (1 - (P - C) . X_s), with (P - C)' = v - X s' and X . X_s = 0.
    let speed_rate = along.x + station.swing_of_speed(&motion.velocity);
    let bend = frame.bend();
    let bend1 = frame.axes * (frame.turn1.cross(&Vector3::x()) + turn.cross(&turn.cross(&Vector3::x())));
    let stretch = 1.0 - offset.dot(&bend);
    let stretch_rate = -(motion.velocity.dot(&bend) + offset.dot(&bend1) * travel);
    let travel_rate = (speed_rate - travel * stretch_rate) / stretch;
    // The axle u as the track sees it, e = A^T u, with two derivatives.
    let carrier = motion.carrier();
    let axle = motion.axle();
    let (x, z) = (motion.frame.axes.column(0), Vector3::z());
    let turning = z * world[3] + x * world[4] + carrier.rotation_bias;
    let axle1 = carrier.rotation.cross(&axle);
    let axle2 = turning.cross(&axle) + carrier.rotation.cross(&axle1);
    let [e, b, b1] = [axle, axle1, axle2].map(|v| frame.components(&v));
    let e1 = b - turn.cross(&e) * *travel;
    let e2 = (b1 - turn.cross(&b) * *travel)
        - (turn.cross(&e) * travel_rate + frame.turn1.cross(&e) * (travel * travel) + turn.cross(&e1) * *travel);
    let (square, square1) = (e.x * e.x + e.y * e.y, 2.0 * (e.x * e1.x + e.y * e1.y));
    let moment = e.x * e1.y - e.y * e1.x;
    let yaw_rate = moment / square;
    let yaw = (e.x * e2.y - e.y * e2.x - yaw_rate * square1) / square;
    let cos_roll = square.sqrt();
    let roll_rate = e1.z / cos_roll;
    let roll = (e2.z + e.z * roll_rate * roll_rate) / cos_roll;
    let pitch = world[3] * motion.frame.sin_roll + motion.yaw_rate * motion.frame.cos_roll * motion.roll_rate + world[5]
        - travel_rate * turn.dot(&e)
        - travel * (travel * frame.turn1.dot(&e) + turn.dot(&e1))
        - yaw * e.z
        - yaw_rate * e1.z;
    [speed_rate, along.y, along.z, yaw, roll, pitch]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::track::centre_line::{Alignment, CentreLine, Node, Pivot};

    fn line() -> CentreLine {
        let node = |distance, curvature, superelevation, grade| Node { distance, curvature, superelevation, grade };
        let nodes = vec![node(0.0, 0.01, -0.05, 0.02), node(30.0, -0.01, 0.1, -0.02)];
        CentreLine::new(&Alignment { nodes, smoothing: 20.0, pivot: Pivot::Centre }, Vector3::new(10.0, 3.0, 1.0), 3.0).unwrap()
    }

    fn example() -> OnTrack {
        OnTrack { coordinates: [12.0, 0.02, 0.46, 0.03, -0.02, 0.0], velocities: [20.0, 0.3, -0.2, 0.4, -0.3, 43.0] }
    }

    #[test]
    fn prop_place_and_relative_are_inverse() {
        let line = line();
        for distance in [-4.0, 12.0, 29.0, 60.0] {
            let (q, v) = place(&line.frame(distance), &example());
            for (motion, general) in [(BodyMotion::new(&q, &v), false), (BodyMotion::general(&q, &v), true)] {
                let station = Station::new(&line, &motion.position, &motion.velocity, distance + 1.0);
                let found = relative(&motion, &station);
                for i in 0..COORDINATES {
                    let expected = if i == 0 { distance } else { example().coordinates[i] };
                    let compared = i < 5 || general;
                    assert!(!compared || (found.coordinates[i] - expected).abs() < 1e-13, "{distance} {i}: {found:?}");
                    assert!((found.velocities[i] - example().velocities[i]).abs() < 1e-12, "{distance} {i}: {found:?}");
                }
            }
        }
    }

    /// Velocities and accelerations against differences along a motion of constant accelerations in the world.
    #[test]
    fn analytic_rates_match_differences() {
        let line = line();
        let (q0, v0) = place(&line.frame(12.0), &example());
        let a = [0.5, -4.0, 1.0, 0.7, -0.4, 2.0];
        let at = |t: f64| {
            let q: Vec<f64> = (0..6).map(|i| q0[i] + t * v0[i] + 0.5 * t * t * a[i]).collect();
            let v: Vec<f64> = (0..6).map(|i| v0[i] + t * a[i]).collect();
            let motion = BodyMotion::new(&q, &v);
            let station = Station::new(&line, &motion.position, &motion.velocity, 12.0);
            (relative(&motion, &station), accelerations(&motion, &station, &a), station)
        };
        let h = 1e-5;
        let ((now, found, station), (ahead, ..), (behind, ..)) = (at(0.0), at(h), at(-h));
        for (i, acceleration) in found.iter().enumerate() {
            let slope = (ahead.coordinates[i] - behind.coordinates[i]) / (2.0 * h);
            let rate = if i == 0 { station.travel } else { now.velocities[i] };
            // The pitch of a body of revolution is its own, its rate is relative.
            assert!(i == 5 || (slope - rate).abs() < 1e-7, "{i}: {slope} {rate}");
            let slope = (ahead.velocities[i] - behind.velocities[i]) / (2.0 * h);
            let absolute = i == 1 || i == 2;
            assert!(absolute || (slope - acceleration).abs() < 1e-6, "{i}: {slope} {acceleration}");
        }
        let across = station.frame.components(&Vector3::new(a[0], a[1], a[2]));
        assert!((found[1] - across.y).abs() < 1e-15 && (found[2] - across.z).abs() < 1e-15);
    }
}
