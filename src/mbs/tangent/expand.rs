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

use super::pair::PairSum;
use super::sum::{Gradient, StateTangent};
use crate::mbs::body::BodyMotion;
use nalgebra::{Matrix3, Matrix6, Matrix6x3, Vector3, Vector6};

/// A pair's frames at one instant.
pub(super) struct PairFrames {
    /// E per end; zero for the world.
    axes: [Matrix3<f64>; 2],
    /// D, m.
    lever: Vector3<f64>,
    /// P on the angles of a: displacement above rotation.
    by_angles: Matrix6x3<f64>,
}

fn axes_of(motion: &BodyMotion) -> Matrix3<f64> {
    let pitch = if motion.turn.is_some() { motion.axle() } else { Vector3::zeros() };
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
        let axes = pair.ends.map(|end| end.map_or_else(Matrix3::zeros, |body| axes_of(&motions[body])));
        let lever = pair.ends[0].map_or_else(Vector3::zeros, |body| reference(pair, motions) - motions[body].position);
        let mut by_angles = Matrix6x3::zeros();
        for j in 0..3 {
            let axis = axes[0].column(j).into_owned();
            by_angles.fixed_view_mut::<3, 1>(0, j).copy_from(&axis.cross(&lever));
            by_angles.fixed_view_mut::<3, 1>(3, j).copy_from(&axis);
        }
        PairFrames { axes, lever, by_angles }
    }

    /// matrix P, per end.
    #[inline]
    fn columns(&self, matrix: &Matrix6<f64>) -> [Matrix6<f64>; 2] {
        let (mut a, mut b) = (*matrix, *matrix);
        a.fixed_view_mut::<6, 3>(0, 3).copy_from(&(matrix * self.by_angles));
        b.fixed_view_mut::<6, 3>(0, 3).copy_from(&(matrix.fixed_view::<6, 3>(0, 3) * self.axes[1]));
        [a, b]
    }

    /// P^T matrix, per end.
    #[inline]
    fn rows(&self, end: usize, matrix: &Matrix6<f64>) -> Matrix6<f64> {
        let mut result = *matrix;
        let angles = if end == 0 { self.by_angles.tr_mul(matrix) } else { self.axes[1].tr_mul(&matrix.fixed_view::<3, 6>(3, 0)) };
        result.fixed_view_mut::<3, 6>(3, 0).copy_from(&angles);
        result
    }

    /// dQ/d(motion) of the relative matrix: blocks (row end, column end).
    #[inline]
    pub fn blocks(&self, matrix: &Matrix6<f64>) -> [[Matrix6<f64>; 2]; 2] {
        let [a, b] = self.columns(matrix);
        [[-self.rows(0, &a), self.rows(0, &b)], [self.rows(1, &a), -self.rows(1, &b)]]
    }

    /// Adds what turning forces, lever arms and axes change.
    pub fn add_geometry(&self, pair: &PairSum, blocks: &mut [[Matrix6<f64>; 2]; 2]) {
        let (force, moment) = (pair.force.cross_matrix(), pair.couple.cross_matrix());
        let (arm, arm_a) = (&pair.arm_force, pair.arm_force + self.lever * pair.force.transpose());
        let trace = |matrix: &Matrix3<f64>| Matrix3::from_diagonal_element(matrix.trace());
        let [a, b] = &self.axes;
        let (at, bt) = (a.transpose(), b.transpose());
        let [[aa, ab], [ba, bb]] = blocks;
        let turned = force * a;
        add(aa, (0, 3), &-turned);
        add(aa, (3, 0), &(at * force));
        add(aa, (3, 3), &(at * (trace(&arm_a) - arm_a.transpose() - moment) * a + axes_moved(a, &(vee(&arm_a) + pair.couple))));
        let other = at * (arm - trace(arm)) * b;
        add(ab, (3, 0), &-(at * force));
        add(ab, (3, 3), &other);
        add(ba, (0, 3), &turned);
        add(ba, (3, 3), &(other.transpose() + bt * moment * a));
        add(bb, (3, 3), &(bt * (trace(arm) - arm) * b - axes_moved(b, &(vee(arm) + pair.couple))));
    }

    /// Of the coefficients on the relative twist: those on both ends' coordinates.
    #[inline]
    fn gradient(&self, relative: &Vector6<f64>) -> Gradient {
        let (mut a, mut b) = (-relative, *relative);
        a.fixed_rows_mut::<3>(3).copy_from(&-self.by_angles.tr_mul(relative));
        b.fixed_rows_mut::<3>(3).copy_from(&self.axes[1].tr_mul(&relative.fixed_rows::<3>(3)));
        [a, b]
    }

    /// From relative twists and wrenches to coordinates and generalised forces.
    pub fn expand_state(&self, state: &mut StateTangent) {
        for i in 0..state.count {
            state.rate_by_position[i] = self.gradient(&state.rate_by_position[i][0]);
            state.rate_by_velocity[i] = self.gradient(&state.rate_by_velocity[i][0]);
            state.load_by_state[i] = self.gradient(&-state.load_by_state[i][0]);
        }
    }
}

/// Sum of r x F from that of r F^T.
fn vee(arm: &Matrix3<f64>) -> Vector3<f64> {
    Vector3::new(arm[(1, 2)] - arm[(2, 1)], arm[(2, 0)] - arm[(0, 2)], arm[(0, 1)] - arm[(1, 0)])
}
