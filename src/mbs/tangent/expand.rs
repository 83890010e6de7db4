//! From the relative motion of a pair of bodies to their coordinates.
//!
//! With the axes e_j about which a frame's yaw, roll and pitch turn (zero for the pitch of a frame that does not spin with its body),
//! E = [e_1 e_2 e_3], D = c - x_a, and B = sum of r F^T (all of [`super::pair`]):
//!
//! ```text
//! t = P_b dq_b - P_a dq_a,   P_a: dx_a + th_a x D, th_a;   P_b: dx_b, th_b;   th = E d(angles)
//! Q_a = P_a^T W,  Q_b = -P_b^T W    with dW of stiffness and damping
//! (th_b x r) x F -> B - tr B,   r x (th_a x F) -> tr B - B^T,   (r + D) likewise with B_a = B + D F^T
//! d(e_i . M) = (e_j x e_i) . M for angles j outside of i
//! ```

use crate::mbs::body::BodyMotion;
use crate::mbs::pair_tangent::pair::PairSum;
use crate::mbs::pair_tangent::{Gradient, StateTangent, dot};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// A pair's frames at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct PairFrames {
    /// E per end; zero for the world.
    axes: [Matrix3<f64>; 2],
    /// D, m.
    lever: Vector3<f64>,
    /// P on the angles of each end: displacement above rotation.
    by_angles: [[[f64; 6]; 3]; 2],
}

fn axes_of(motion: &BodyMotion, spinning: bool) -> Matrix3<f64> {
    let pitch = if spinning || motion.turn.is_some() { motion.axle() } else { Vector3::zeros() };
    Matrix3::from_columns(&[Vector3::z(), motion.roll_axis(), pitch])
}

/// The point c of a pair, m.
#[inline]
pub(super) fn reference(pair: &PairSum, motions: &[BodyMotion]) -> Vector3<f64> {
    pair.ends[1].or(pair.ends[0]).map_or_else(Vector3::zeros, |body| motions[body].position)
}

/// Change of `E^T M` with the angles at constant M: row i, column j.
fn axes_moved(axes: &Matrix3<f64>, moment: &Vector3<f64>) -> Matrix3<f64> {
    let mut moved = Matrix3::zeros();
    for i in 1..3 {
        for j in 0..i {
            moved[(i, j)] = axes.column(j).cross(&axes.column(i)).dot(moment);
        }
    }
    moved
}

/// Adds to one part of a block.
#[inline]
fn add(block: &mut Matrix6<f64>, (row, column): (usize, usize), part: &Matrix3<f64>) {
    let mut view = block.fixed_view_mut::<3, 3>(row, column);
    view += part;
}

impl PairFrames {
    pub fn new(pair: &PairSum, motions: &[BodyMotion]) -> PairFrames {
        let mut frames = PairFrames { axes: [Matrix3::zeros(); 2], lever: Vector3::zeros(), by_angles: [[[0.0; 6]; 3]; 2] };
        if let Some(body) = pair.ends[0] {
            frames.lever = reference(pair, motions) - motions[body].position;
        }
        for (end, body) in pair.ends.iter().enumerate() {
            let Some(body) = body else { continue };
            frames.axes[end] = axes_of(&motions[*body], pair.spinning);
            for (j, column) in frames.by_angles[end].iter_mut().enumerate() {
                let axis = frames.axes[end].column(j);
                column[3..].copy_from_slice(axis.as_slice());
                if end == 0 {
                    column[..3].copy_from_slice(axis.cross(&frames.lever).as_slice());
                }
            }
        }
        frames
    }

    /// Adds dQ/d(motion) of the relative matrix to the blocks (row end, column end) of `slots`.
    #[inline]
    pub fn add_blocks(&self, matrix: &Matrix6<f64>, slots: &[[Option<usize>; 2]; 2], blocks: &mut [Matrix6<f64>]) {
        let matrix = &matrix.data.0;
        let [by_a, by_b] = &self.by_angles;
        for (column, columns) in [times::<0>(matrix, by_a), times::<3>(matrix, by_b)].iter().enumerate() {
            let sign = |row: usize| if row == column { -1.0 } else { 1.0 };
            if let Some(slot) = slots[0][column] {
                add_rows::<0>(columns, by_a, sign(0), &mut blocks[slot]);
            }
            if let Some(slot) = slots[1][column] {
                add_rows::<3>(columns, by_b, sign(1), &mut blocks[slot]);
            }
        }
    }

    /// Adds what turning forces, lever arms and axes change.
    pub fn add_geometry(&self, pair: &PairSum, slots: &[[Option<usize>; 2]; 2], blocks: &mut [Matrix6<f64>]) {
        let (force, moment) = (pair.force.cross_matrix(), pair.couple.cross_matrix());
        let (arm, arm_a) = (&pair.arm_force, pair.arm_force + self.lever * pair.force.transpose());
        let trace = |matrix: &Matrix3<f64>| Matrix3::from_diagonal_element(matrix.trace());
        let [a, b] = &self.axes;
        let (at, bt) = (a.transpose(), b.transpose());
        let other = at * (arm - trace(arm)) * b;
        let turned = force * a;
        if let Some(slot) = slots[0][0] {
            let block = &mut blocks[slot];
            add(block, (0, 3), &-turned);
            add(block, (3, 0), &-turned.transpose());
            let angles = at * (trace(&arm_a) - arm_a.transpose() - moment) * a + axes_moved(a, &(vee(&arm_a) + pair.couple));
            add(block, (3, 3), &angles);
        }
        if let Some(slot) = slots[0][1] {
            add(&mut blocks[slot], (3, 0), &turned.transpose());
            add(&mut blocks[slot], (3, 3), &other);
        }
        if let Some(slot) = slots[1][0] {
            add(&mut blocks[slot], (0, 3), &turned);
            add(&mut blocks[slot], (3, 3), &(other.transpose() + bt * moment * a));
        }
        if let Some(slot) = slots[1][1] {
            let angles = bt * (trace(arm) - arm) * b - axes_moved(b, &(vee(arm) + pair.couple));
            add(&mut blocks[slot], (3, 3), &angles);
        }
    }

    /// Of the coefficients on the relative twist: those on both ends' coordinates.
    #[inline]
    fn gradient(&self, relative: &Vector6<f64>) -> Gradient {
        let own = &relative.data.0[0];
        let [a, b] = &self.by_angles;
        [
            -Vector6::new(own[0], own[1], own[2], dot(&a[0], own), dot(&a[1], own), dot(&a[2], own)),
            Vector6::new(own[0], own[1], own[2], turned(&b[0], own), turned(&b[1], own), turned(&b[2], own)),
        ]
    }

    /// From relative twists and wrenches to coordinates and generalised forces.
    pub fn expand_state(&self, state: &mut StateTangent) {
        let StateTangent { rate_by_position, rate_by_velocity, load_by_state, .. } = state;
        for i in 0..state.count {
            for (gradient, sign) in [(&mut rate_by_position[i], 1.0), (&mut rate_by_velocity[i], 1.0), (&mut load_by_state[i], -1.0)] {
                if gradient[0] != Vector6::zeros() {
                    *gradient = self.gradient(&(gradient[0] * sign));
                }
            }
        }
    }
}

/// The same where the first one displaces nothing.
#[inline]
fn turned(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a[3] * b[3] + a[4] * b[4] + a[5] * b[5]
}

/// The matrix times P, whose columns of angles are zero above `FIRST` (angles of b displace nothing at c).
#[inline(always)]
fn times<const FIRST: usize>(matrix: &[[f64; 6]; 6], by_angles: &[[f64; 6]; 3]) -> [[f64; 6]; 6] {
    let mut columns = *matrix;
    for (j, angle) in by_angles.iter().enumerate() {
        let mut own = [0.0; 6];
        for k in FIRST..6 {
            for (own, matrix) in own.iter_mut().zip(&matrix[k]) {
                *own += matrix * angle[k];
            }
        }
        columns[3 + j] = own;
    }
    columns
}

/// Adds `sign P^T` times the columns, likewise.
#[inline(always)]
fn add_rows<const FIRST: usize>(columns: &[[f64; 6]; 6], by_angles: &[[f64; 6]; 3], sign: f64, block: &mut Matrix6<f64>) {
    for (target, own) in block.data.0.iter_mut().zip(columns) {
        for i in 0..3 {
            target[i] += sign * own[i];
            target[3 + i] += sign * if FIRST == 0 { dot(&by_angles[i], own) } else { turned(&by_angles[i], own) };
        }
    }
}

/// Sum of r x F from that of r F^T.
fn vee(arm: &Matrix3<f64>) -> Vector3<f64> {
    Vector3::new(arm[(1, 2)] - arm[(2, 1)], arm[(2, 0)] - arm[(0, 2)], arm[(0, 1)] - arm[(1, 0)])
}
