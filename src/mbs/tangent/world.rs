//! From displacements and wrenches in the world to coordinates and generalised forces; from generalised forces to accelerations.
//!
//! With the axes e_j of yaw, roll and pitch and the velocities v of the coordinates, displacement and velocity of a body are
//!
//! ```text
//! du = B dq,   w = B v,   dw = B dv + D dq,   B = diag(1, [e_1 e_2 e_3]),   D: e_j x (what of the angular velocity turns with angle j)
//! Q = B^T W:   dQ/dq = B^T (dW/du B + dW/dw D),   dQ/dv = B^T dW/dw B
//! ```

use super::expand::PairFrames;
use super::sum::{StateTangent, TangentSum};
use super::{Tangent, WrenchTangent};
use crate::mbs::body::BodyMotion;
use crate::mbs::inertia::Inertia;
use crate::mbs::system::{System, SystemWorkspace};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// B and D of one body: their parts on angles.
struct Axes {
    b: Matrix3<f64>,
    d: Matrix3<f64>,
}

impl Axes {
    fn of(motion: &BodyMotion) -> Axes {
        let (yaw, roll, pitch) = (Vector3::z(), motion.roll_axis(), motion.axle());
        let spin = pitch * motion.pitch_rate;
        let by_yaw = yaw.cross(&(roll * motion.roll_rate + spin));
        Axes { b: Matrix3::from_columns(&[yaw, roll, pitch]), d: Matrix3::from_columns(&[by_yaw, roll.cross(&spin), Vector3::zeros()]) }
    }

    /// Columns: matrix times B.
    fn columns(&self, matrix: &Matrix6<f64>) -> Matrix6<f64> {
        let mut result = *matrix;
        result.fixed_view_mut::<6, 3>(0, 3).copy_from(&(matrix.fixed_view::<6, 3>(0, 3) * self.b));
        result
    }

    /// Rows: B^T times matrix.
    fn rows(&self, matrix: &Matrix6<f64>) -> Matrix6<f64> {
        let mut result = *matrix;
        result.fixed_view_mut::<3, 6>(3, 0).copy_from(&self.b.tr_mul(&matrix.fixed_view::<3, 6>(3, 0)));
        result
    }

    fn angles(&self, vector: &Vector6<f64>) -> Vector6<f64> {
        let mut result = *vector;
        result.fixed_rows_mut::<3>(3).copy_from(&self.b.tr_mul(&vector.fixed_rows::<3>(3)));
        result
    }
}

impl Tangent {
    /// Ends the sum: with the motions in the workspace, everything is turned into terms of coordinates.
    pub fn finish(&mut self, system: &System, workspace: &SystemWorkspace) {
        let motions = &workspace.motions;
        for (slot, row, column) in self.sum.neighbours.iter() {
            let Some(WrenchTangent { by_position, by_velocity }) = &self.world[slot] else { continue };
            let (on, by) = (Axes::of(&motions[row]), Axes::of(&motions[column]));
            let mut position = by.columns(by_position);
            let turning = by_velocity.fixed_view::<6, 3>(0, 3) * by.d;
            let mut angles = position.fixed_view_mut::<6, 3>(0, 3);
            angles += turning;
            self.sum.by_position[slot] += on.rows(&position);
            self.sum.by_velocity[slot] += on.rows(&by.columns(by_velocity));
        }
        self.expand_pairs(motions);
        for (mobility, (body, motion)) in self.mobility.iter_mut().zip(system.bodies.iter().zip(motions)) {
            *mobility = body.mobility(motion);
        }
        for drive in &system.drives {
            drive.immobilise(&mut self.mobility[drive.body], &workspace.stations);
        }
        for (spin, (body, motion)) in self.spin.iter_mut().zip(system.bodies.iter().zip(motions)) {
            *spin = gyroscopic(&body.inertia, motion);
        }
        for state in &mut self.sum.states {
            for i in 0..state.count {
                for (load, body) in state.load_by_state[i].iter_mut().zip(&state.ends) {
                    let Some(body) = body else { continue };
                    weigh(&self.mobility[*body], &mut load.data.0[0]);
                }
            }
        }
    }

    /// Generalised forces and states of pairs, and states of contacts, in terms of coordinates.
    fn expand_pairs(&mut self, motions: &[BodyMotion]) {
        let TangentSum { neighbours, pairs, by_position, by_velocity, states, .. } = &mut self.sum;
        self.frames.clear();
        for pair in pairs {
            let frames = PairFrames::new(pair, motions);
            let slots = pair.ends.map(|on| pair.ends.map(|by| neighbours.slot(on?, by?)));
            // Weights have nothing to add; many pairs have no dampers.
            if !is_zero(&pair.stiffness) {
                frames.add_blocks(&pair.stiffness, &slots, by_position);
            }
            if pair.force != Vector3::zeros() || pair.couple != Vector3::zeros() {
                frames.add_geometry(pair, &slots, by_position);
            }
            if !is_zero(&pair.damping) {
                frames.add_blocks(&pair.damping, &slots, by_velocity);
            }
            self.frames.push(frames);
        }
        for state in states {
            match state.pair {
                Some(pair) => self.frames[pair].expand_state(state),
                None => world_state(state, motions),
            }
        }
    }
}

#[inline]
fn is_zero(matrix: &Matrix6<f64>) -> bool {
    matrix.as_slice().iter().all(|value| *value == 0.0)
}

/// A contact's state in terms of its bodies' coordinates.
fn world_state(state: &mut StateTangent, motions: &[BodyMotion]) {
    for (end, body) in state.ends.iter().enumerate() {
        let Some(body) = body else { continue };
        let axes = Axes::of(&motions[*body]);
        let velocity = state.rate_by_velocity[0][end];
        let mut position = axes.angles(&state.rate_by_position[0][end]);
        let mut angles = position.fixed_rows_mut::<3>(3);
        angles += axes.d.tr_mul(&velocity.fixed_rows::<3>(3));
        state.rate_by_position[0][end] = position;
        state.rate_by_velocity[0][end] = axes.angles(&velocity);
        state.load_by_state[0][end] = axes.angles(&state.load_by_state[0][end]);
    }
}

/// Mobility times a generalised force: no coupling between displacements and rotations.
#[inline]
pub(super) fn weigh(mobility: &Matrix6<f64>, column: &mut [f64; 6]) {
    let m = &mobility.data.0;
    let [x, y, z, a, b, c] = *column;
    for i in 0..3 {
        column[i] = m[0][i] * x + m[1][i] * y + m[2][i] * z;
        column[3 + i] = m[3][3 + i] * a + m[4][3 + i] * b + m[5][3 + i] * c;
    }
}

/// Change of the accelerations of yaw, roll and pitch with their rates at constant moments, 1/s; zero for bodies that do not spin.
///
/// With u = k q - w, k = I/J, in the notation of [`crate::mbs::inertia`]: roll'' = r u + .., r' = -p u + .. .
#[inline]
fn gyroscopic(inertia: &Inertia, motion: &BodyMotion) -> Matrix3<f64> {
    let Inertia::Revolution { transverse, axial } = inertia else { return Matrix3::zeros() };
    let (sin, cos, k) = (motion.frame.sin_roll, motion.frame.cos_roll, axial / transverse);
    let (yaw, roll) = (motion.yaw_rate, motion.roll_rate);
    let u = k * motion.pitch_rate + (k - 1.0) * sin * yaw;
    let [u_yaw, u_pitch] = [(k - 1.0) * sin, k];
    let yaw_row = [(sin * roll - roll * u_yaw) / cos, (sin * yaw - u) / cos, -roll * u_pitch / cos];
    let roll_row = [cos * (u + yaw * u_yaw), 0.0, cos * yaw * u_pitch];
    let pitch_row = [-sin * yaw_row[0] - cos * roll, -sin * yaw_row[1] - cos * yaw, -sin * yaw_row[2]];
    Matrix3::from([yaw_row, roll_row, pitch_row]).transpose()
}
