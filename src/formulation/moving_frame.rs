//! A frame that moves with the vehicle along its track: the motion that implicit integrators take for granted within a step
//! (`solve::moving_frame`).
//!
//! From the step's begin all bodies travel on at the mean of their rates s' along the track. In a curve, whose heading psi turns by psi' for
//! each metre, velocity v (along the track, at the body's place) and yaw turn about the vertical by `alpha = omega tau + omega' tau^2 / 2`,
//! `omega = psi' s'`:
//!
//! ```text
//! c' = Rz(alpha) v,   c'' = (omega + omega' tau) Z x c',   yaw: alpha
//! c = v sin(omega tau) / omega + Z x v ((1 - cos(omega tau)) / omega + omega' tau^3 / 6)
//! ```
//!
//! (c and c' differ by `omega omega' V tau^4 / 8`: 2e-9 m in 0.5 m of a transition of 50 m to R = 500 m at 25 m/s.) Wheelsets besides rise and
//! roll with what deviations do to their rails. With left and right deviations y and z, 2 b the distance of the rails, n the normal of each
//! wheel's most loaded contact at the begin, d(a) what a wheel that is not round has more in radius where it has turned by a (`out_of_round`)
//!
//! ```text
//! H = z + (n_y / n_z) y + d,   height: (H_left + H_right) / 2,   roll: (H_left - H_right) / 2b,   each at s + s' tau, a + a' tau minus at s, a
//! ```
//!
//! A tilt n_y / n_z beyond [`STEEPEST_TREAD`] (flange) counts as none. What c leaves out is not lost: the method itself finds it, as all
//! of it would be without.
//!
//! *J c' - c''.* J leaves out that forces turn with their bodies, so that J c' of a vehicle that turns as a whole is not what it should be
//! (rigid bodies that turn together press no spring). The turn that is common to all bodies (mean velocity, mean rate) is therefore taken out
//! of c': only contacts see it, by their part of J and without what turns in their wrenches (wheelsets, and rails that give way under them). For that common turn, without contacts, the
//! exact answer (Z omega x (v' - c''), of the order of 0.05 m/s3) is left out. In a steady curve 2e-1 rad/s3 is left of 6e5.

use super::frame_motion::{FrameMotion, MovingFrame, Ride, Travel, up_cross};
use super::step::WheelRef;
use super::{Model, Workspace, contact_index};
use crate::geometry::Side;
use crate::geometry::track::station::Station;
use crate::mbs::body::{BodyMotion, COORDINATES, Wrench, YAW};
use crate::mbs::system::SystemWorkspace;
use crate::mbs::tangent::Tangent;
use nalgebra::{Vector3, Vector6};

/// Greatest n_y / n_z of a contact on a tread.
const STEEPEST_TREAD: f64 = 0.3;

impl Workspace {
    /// For explicit methods, which ride along the track alone: their steps are as short as contacts vibrate, and where a deviation bends off, their order
    /// would be lost on it (0.4 % of a wheel load on a bump for 0.05 %).
    pub fn leave_out_rides(&mut self) {
        self.frame.motion.rides.clear();
    }
}

impl Model {
    /// Makes room for what [`Model::note_frame`] notes.
    pub(super) fn moving_frame(&self) -> MovingFrame {
        let moved = Side::BOTH.iter().any(|side| self.track.rail(*side).deviates()) || !self.out_of_round.is_empty();
        MovingFrame {
            motion: FrameMotion {
                bodies: vec![Travel::default(); self.system.bodies.len()],
                rides: if moved { vec![Ride::default(); self.wheelsets.len()] } else { Vec::new() },
            },
            rate: vec![0.0; self.dimension()],
            change: vec![0.0; self.dimension()],
            drift: [0; 2].map(|_| vec![0.0; self.dimension()]),
        }
    }

    /// H and roll of a wheelset `ahead` [s] from where a ride begins, with three derivatives with time.
    fn ride(&self, wheelset: usize, ride: &Ride, ahead: f64) -> [[f64; 4]; 2] {
        let powers = |rate: f64| [1.0, rate, rate * rate, rate * rate * rate];
        let (s, speed) = (ride.distance + ride.speed * ahead, powers(ride.speed));
        let [h, g] = [(Side::Left, ride.tilt[0]), (Side::Right, ride.tilt[1])].map(|(side, tilt)| {
            let [y, z] = self.track.rail(side).deviation(s);
            let of_rail = [0, 1, 2, 3].map(|i| (z[i] + tilt * y[i]) * speed[i]);
            let Some(Some(wheel)) = self.out_of_round.get(contact_index(wheelset, side)) else { return of_rail };
            let [angle, turning] = ride.turned[side.index()];
            let (more, rate) = (wheel.at(angle + turning * ahead), powers(turning));
            [0, 1, 2, 3].map(|i| of_rail[i] + more[i] * rate[i])
        });
        let spacing = self.track.rail(Side::Left).spacing(self.track.rail(Side::Right));
        [[0, 1, 2, 3].map(|i| 0.5 * (h[i] + g[i])), [0, 1, 2, 3].map(|i| (h[i] - g[i]) / spacing)]
    }

    /// Notes how the bodies travel on from the state that was evaluated last and linearised as `tangent`.
    pub(super) fn note_frame(&self, workspace: &mut Workspace, y: &[f64], tangent: &Tangent) {
        self.note_motion(workspace);
        let mut frame = std::mem::take(&mut workspace.frame);
        self.find_change(&mut frame, workspace, y, tangent);
        workspace.frame = frame;
    }

    /// Notes how the bodies travel on from the state that was evaluated last. Does that motion bend?
    pub fn note_motion(&self, workspace: &mut Workspace) -> bool {
        let mut frame = std::mem::take(&mut workspace.frame);
        let SystemWorkspace { motions, stations, .. } = &workspace.system;
        let advance = |body: usize| stations.get(body).map_or(motions[body].speed, |station| station.travel);
        // One for all: how bodies move against each other along the track is not the track's doing.
        let bodies = frame.motion.bodies.len();
        let advance = (0..bodies).map(advance).sum::<f64>() / bodies.max(1) as f64;
        for (body, travel) in frame.motion.bodies.iter_mut().enumerate() {
            *travel = Travel { velocity: [advance, 0.0, 0.0], ..Travel::default() };
            if let Some(Station { frame, .. }) = stations.get(body) {
                travel.velocity = (frame.along() * (advance * frame.stretch(&(motions[body].position - frame.origin)))).into();
                travel.turn = (frame.axes * frame.turn).z * advance;
                travel.winding = (frame.axes * frame.turn1).z * advance * advance;
            }
        }
        if !frame.motion.rides.is_empty() {
            for WheelRef { contact, wheelset, side } in self.wheels() {
                let ride = &mut frame.motion.rides[contact / 2];
                let pressed = workspace.reports(contact).max_by(|a, b| a.normal_force.total_cmp(&b.normal_force));
                let normal = pressed.map_or(Vector3::zeros(), |report| workspace.in_track(wheelset.body, report.axes.normal));
                let tilt = normal.y / normal.z;
                ride.tilt[usize::from(side == Side::Right)] = if tilt.abs() < STEEPEST_TREAD { tilt } else { 0.0 };
            }
            for (index, (ride, wheelset)) in frame.motion.rides.iter_mut().zip(&self.wheelsets).enumerate() {
                let motion = &workspace.system.motions[wheelset.body];
                let station = workspace.system.stations.get(wheelset.body);
                (ride.distance, ride.speed) = (motion.distance, advance);
                ride.up = station.map_or(Vector3::z(), |station| station.frame.axes.column(2).into_owned()).into();
                if !self.out_of_round.is_empty() {
                    ride.turned =
                        wheelset.turning.map(|wheel| &workspace.system.motions[wheel]).map(|wheel| [wheel.pitch, wheel.pitch_rate]);
                }
                ride.begin = self.ride(index, ride, 0.0);
            }
        }
        let bends = !frame.motion.rides.is_empty() || frame.motion.bodies.iter().any(|travel| travel.turn != 0.0 || travel.winding != 0.0);
        workspace.frame = frame;
        bends
    }

    /// c and c' after `ahead` [s]: what is added to the state that was linearised last, and its rate.
    pub fn frame_at(&self, workspace: &Workspace, ahead: f64, shift: &mut [f64], rate: &mut [f64]) {
        shift.fill(0.0);
        rate.fill(0.0);
        self.visit_frame(&workspace.frame.motion, ahead, |i, by, at| {
            shift[i] += by;
            rate[i] += at;
        });
    }

    /// Adds c after `ahead` [s] to the state in `y`.
    pub fn add_frame_motion(&self, motion: &FrameMotion, ahead: f64, y: &mut [f64]) {
        self.visit_frame(motion, ahead, |i, by, _| y[i] += by);
    }

    /// The motion from the state on that was linearised last.
    pub fn frame_motion<'a>(&self, workspace: &'a Workspace) -> &'a FrameMotion {
        &workspace.frame.motion
    }

    /// Hands over parts of c and c' after `ahead` [s], by place in the state.
    #[inline(always)] // twice, on the stepping path
    fn visit_frame(&self, motion: &FrameMotion, ahead: f64, mut add: impl FnMut(usize, f64, f64)) {
        let FrameMotion { bodies, rides } = motion;
        let velocities = COORDINATES * bodies.len();
        for (body, travel) in bodies.iter().enumerate() {
            let first = COORDINATES * body;
            let [way, velocity, acceleration] = travel.after(ahead);
            for i in 0..3 {
                add(first + i, way[i], velocity[i]);
                add(velocities + first + i, velocity[i] - travel.velocity[i], acceleration[i]);
            }
            let Travel { turn, winding, .. } = *travel;
            add(first + YAW, turn * ahead + 0.5 * winding * ahead * ahead, turn + winding * ahead);
            add(velocities + first + YAW, winding * ahead, winding);
        }
        for (index, (ride, wheelset)) in rides.iter().zip(&self.wheelsets).enumerate() {
            let first = COORDINATES * wheelset.body;
            let to = self.ride(index, ride, ahead);
            for (i, share, k) in ride.rows() {
                let (from, to) = (&ride.begin[k], &to[k]);
                add(first + i, share * (to[0] - from[0]), share * to[1]);
                add(velocities + first + i, share * (to[1] - from[1]), share * to[2]);
            }
        }
    }

    /// J c' - c'', and what inputs do to f, at the state that was linearised last.
    pub fn frame_change(&self, workspace: &Workspace, change: &mut [f64]) {
        change.copy_from_slice(&workspace.frame.change);
    }

    /// Finds J c' - c''.
    fn find_change(&self, frame: &mut MovingFrame, workspace: &Workspace, y: &[f64], tangent: &Tangent) {
        let MovingFrame { motion: FrameMotion { bodies, rides }, rate, change, .. } = frame;
        let whole = Turn::new(bodies, &workspace.system);
        let velocities = COORDINATES * bodies.len();
        rate.fill(0.0);
        for (body, (travel, motion)) in bodies.iter().zip(&workspace.system.motions).enumerate() {
            let first = COORDINATES * body;
            let own = travel.velocity() - whole.velocity(&motion.position);
            let bending = up_cross(&travel.velocity()) * travel.turn - up_cross(&motion.velocity) * whole.turn;
            for i in 0..3 {
                (rate[first + i], rate[velocities + first + i]) = (own[i], bending[i]);
            }
            (rate[first + YAW], rate[velocities + first + YAW]) = (travel.turn - whole.turn, travel.winding);
        }
        for (ride, wheelset) in rides.iter().zip(&self.wheelsets) {
            ride.add_rates(COORDINATES * wheelset.body, velocities, &ride.begin, rate);
        }
        tangent.times(rate, change);
        // What J finds for coordinates is c'' of the velocities, which is c'' of the coordinates.
        change[..velocities].fill(0.0);
        for (index, wheelset) in self.wheelsets.iter().enumerate() {
            let body = wheelset.body;
            let found = self.turned_contacts(workspace, tangent, index, &whole);
            for (own, value) in change[velocities + COORDINATES * body..].iter_mut().zip(found.iter()) {
                *own += value;
            }
        }
        self.add_turned_rails((workspace, y), tangent, &whole, change);
        for (travel, own) in bodies.iter().zip(change[velocities..].chunks_exact_mut(COORDINATES)) {
            let winding = up_cross(&travel.velocity()) * travel.winding;
            (own[0], own[1]) = (own[0] - winding.x, own[1] - winding.y);
        }
        for (ride, wheelset) in rides.iter().zip(&self.wheelsets) {
            let first = velocities + COORDINATES * wheelset.body;
            for (i, share, k) in ride.rows() {
                change[first + i] -= share * ride.begin[k][3];
            }
        }
    }

    /// How the contacts of a wheelset change its accelerations while it takes part in the motion of the whole, beside what turning with it is.
    fn turned_contacts(&self, workspace: &Workspace, tangent: &Tangent, wheelset: usize, whole: &Turn) -> Vector6<f64> {
        let body = self.wheelsets[wheelset].body;
        let motion = &workspace.system.motions[body];
        let mut wrench = Wrench::default();
        for side in Side::BOTH {
            for report in workspace.reports(contact_index(wheelset, side)).filter(|report| !report.constrained) {
                report.add_to(&mut wrench, report.force, &motion.position);
            }
        }
        let [displacement, velocity] = whole.motion(motion);
        let turned = Wrench { force: whole.turned(&wrench.force), moment: whole.turned(&wrench.moment) };
        tangent.acceleration(body, motion, [&displacement, &velocity], &turned)
    }

    /// The same of rails that give way: a wheel that takes part in the motion of the whole rises with its rail's deviations, which J alone would take for pressing.
    fn add_turned_rails(&self, (workspace, y): (&Workspace, &[f64]), tangent: &Tangent, whole: &Turn, change: &mut [f64]) {
        if !self.gives_way() {
            return;
        }
        let velocities = COORDINATES * self.system.bodies.len();
        for wheel in self.wheels() {
            let WheelRef { contact, wheelset, .. } = wheel;
            let [displacement, velocity] = whole.motion(&workspace.system.motions[wheelset.body]);
            let force: Vector3<f64> = workspace.reports(contact).map(|report| report.force).sum();
            if let Some(beam) = &self.beam {
                let place = (self.rail_of(beam, contact), beam.seats[contact / 2].place);
                let sunk = self.met_by_travel(beam, workspace, wheel, y);
                let found = tangent.ring_accelerations(place, [&displacement, &velocity], &whole.turned(&force), sunk);
                let Some((turned, load)) = found.zip(tangent.ring_load(place, sunk)) else { continue };
                self.add_travel_on_beams(beam, workspace, wheel, &turned, change);
                let own = &mut change[velocities + COORDINATES * wheelset.body..];
                own.iter_mut().zip(load.iter()).for_each(|(own, load)| *own += load);
                continue;
            }
            let found = tangent.follower_accelerations(contact, [&displacement, &velocity], &whole.turned(&force));
            let Some((first, accelerations)) = found else { continue };
            for (own, value) in change[first..].iter_mut().zip(accelerations) {
                *own += value;
            }
        }
    }
}

fn joined(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(a.x, a.y, a.z, b.x, b.y, b.z)
}

/// The motion of all bodies as one that turns about the vertical.
struct Turn {
    centre: Vector3<f64>,
    travel: Vector3<f64>,
    /// rad/s.
    turn: f64,
}

impl Turn {
    fn new(bodies: &[Travel], system: &SystemWorkspace) -> Turn {
        let share = 1.0 / bodies.len().max(1) as f64;
        let mut whole = Turn { centre: Vector3::zeros(), travel: Vector3::zeros(), turn: 0.0 };
        for (travel, motion) in bodies.iter().zip(&system.motions) {
            whole.centre += motion.position * share;
            whole.travel += travel.velocity() * share;
            whole.turn += travel.turn * share;
        }
        whole
    }

    fn velocity(&self, at: &Vector3<f64>) -> Vector3<f64> {
        self.travel + up_cross(&(at - self.centre)) * self.turn
    }

    /// What becomes of a vector that turns with it, per second.
    fn turned(&self, vector: &Vector3<f64>) -> Vector3<f64> {
        up_cross(vector) * self.turn
    }

    /// Rates of displacement and rotation, and of velocity and angular velocity, of a body that takes part.
    fn motion(&self, body: &BodyMotion) -> [Vector6<f64>; 2] {
        let displacement = joined(&self.velocity(&body.position), &(Vector3::z() * self.turn));
        [displacement, joined(&self.turned(&body.velocity), &self.turned(&body.rotation))]
    }
}
