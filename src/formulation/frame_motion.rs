//! The motion of a moving frame: bodies that travel on along the track, wheelsets that ride their rails' deviations (see `moving_frame`).

use crate::mbs::body::ROLL;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// c from one state on; part of a simulation's state, because the solution within its last step is read beside it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameMotion {
    pub(super) bodies: Vec<Travel>,
    /// By wheelset; none where no rail has a deviation and all wheels are round.
    pub(super) rides: Vec<Ride>,
}

impl FrameMotion {
    /// Could this have come from the same model as `other`?
    pub fn fits(&self, other: &FrameMotion) -> bool {
        self.bodies.len() == other.bodies.len() && self.rides.len() == other.rides.len()
    }

    /// Becomes that of the same model's `other`, in the memory that it has: this is on the stepping path.
    pub fn take_over(&mut self, other: &FrameMotion) {
        self.bodies.clone_from(&other.bodies);
        self.rides.clone_from(&other.rides);
    }
}

/// The motion from one state on, and scratch.
#[derive(Clone, Debug, Default)]
pub struct MovingFrame {
    pub motion: FrameMotion,
    /// c' in part, and J c' - c'', as long as the state.
    pub(super) rate: Vec<f64>,
    pub(super) change: Vec<f64>,
    /// Scratch of [`super::drift`].
    pub(super) drift: [Vec<f64>; 2],
}

/// A body along the track.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Travel {
    /// Velocity along the track, m/s, its rate of turn about the vertical, rad/s, and how fast that changes, rad/s2.
    pub velocity: [f64; 3],
    pub turn: f64,
    pub winding: f64,
}

/// A wheelset on its rails.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Ride {
    /// Distance along the track, m, and its rate, m/s.
    pub distance: f64,
    pub speed: f64,
    /// The track's Z in the world.
    pub up: [f64; 3],
    /// n_y / n_z, left and right.
    pub tilt: [f64; 2],
    /// Angle that the left and the right wheel have turned, rad, and its rate, rad/s; zero where both are round.
    pub turned: [[f64; 2]; 2],
    /// H and roll at the begin, with derivatives with time.
    pub begin: [[f64; 4]; 2],
}

impl Travel {
    pub fn velocity(&self) -> Vector3<f64> {
        self.velocity.into()
    }

    /// What position, velocity and acceleration are after `ahead` [s], the first counted from the begin.
    pub fn after(&self, ahead: f64) -> [Vector3<f64>; 3] {
        let (v, Travel { turn, winding, .. }) = (self.velocity(), *self);
        if turn == 0.0 && winding == 0.0 {
            return [v * ahead, v, Vector3::zeros()];
        }
        let (sin, cos) = (turn * ahead + 0.5 * winding * ahead * ahead).sin_cos();
        let (level, climb) = (Vector3::new(v.x, v.y, 0.0), Vector3::new(0.0, 0.0, v.z));
        let now = level * cos + up_cross(&v) * sin;
        // Chord and sagitta of the circle; with its turn zero it is the tangent.
        let (half, _) = (0.5 * turn * ahead).sin_cos();
        let [along, aside] = if turn == 0.0 { [ahead, 0.0] } else { [(turn * ahead).sin() / turn, 2.0 * half * half / turn] };
        let way = level * along + up_cross(&v) * (aside + winding * ahead * ahead * ahead / 6.0);
        [way + climb * ahead, now + climb, up_cross(&now) * (turn + winding * ahead)]
    }
}

impl Ride {
    /// Coordinates of the wheelset that take part, by what share, in H (0) or roll (1).
    pub fn rows(&self) -> [(usize, f64, usize); 4] {
        [(0, self.up[0], 0), (1, self.up[1], 0), (2, self.up[2], 0), (ROLL, 1.0, 1)]
    }

    /// Adds the rates of a wheelset's coordinates from `first` on and of its velocities where the ride is `now`.
    pub fn add_rates(&self, first: usize, velocities: usize, now: &[[f64; 4]; 2], rate: &mut [f64]) {
        for (i, share, k) in self.rows() {
            rate[first + i] += share * now[k][1];
            rate[velocities + first + i] += share * now[k][2];
        }
    }
}

/// Z x v.
pub(super) fn up_cross(v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(-v.y, v.x, 0.0)
}
