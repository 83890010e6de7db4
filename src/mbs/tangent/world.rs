//! From displacements and wrenches in the world to coordinates and generalised forces; from generalised forces to accelerations.
//!
//! With the axes e_j of yaw, roll and pitch and the velocities v of the coordinates, displacement and velocity of a body are
//!
//! ```text
//! du = B dq,   w = B v,   dw = B dv + D dq,   B = diag(1, [e_1 e_2 e_3]),   D: e_j x (what of the angular velocity turns with angle j)
//! Q = B^T W:   dQ/dq = B^T (dW/du B + dW/dw D),   dQ/dv = B^T dW/dw B
//! ```

use super::expand::PairFrames;
use super::sum::TangentSum;
use super::{Tangent, WrenchTangent};
use crate::mbs::body::{BodyMotion, Wrench};
use crate::mbs::inertia::Inertia;
use crate::mbs::pair_tangent::pair::add_outer;
use crate::mbs::pair_tangent::{Across, StateTangent, Terms};
use crate::mbs::system::{System, SystemWorkspace};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// B and D of one body: their parts on angles.
#[derive(Clone, Copy)]
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
    #[inline]
    fn columns(&self, matrix: &Matrix6<f64>) -> [[f64; 6]; 6] {
        let mut columns = matrix.data.0;
        let (_, angles) = columns.split_at_mut(3);
        for (j, own) in angles.iter_mut().enumerate() {
            *own = times(matrix, &self.b, j);
        }
        columns
    }

    /// Rows: B^T times the columns.
    #[inline]
    fn rows(&self, columns: &[[f64; 6]; 6], block: &mut Matrix6<f64>) {
        for (target, own) in block.data.0.iter_mut().zip(columns) {
            for i in 0..3 {
                target[i] = own[i];
                target[3 + i] = self.b[(0, i)] * own[3] + self.b[(1, i)] * own[4] + self.b[(2, i)] * own[5];
            }
        }
    }

    /// Changes of a rate with position and velocity.
    fn rates(&self, position: &Vector6<f64>, velocity: &Vector6<f64>) -> (Vector6<f64>, Vector6<f64>) {
        let mut position = self.angles(position);
        let mut angles = position.fixed_rows_mut::<3>(3);
        angles += self.d.tr_mul(&velocity.fixed_rows::<3>(3));
        (position, self.angles(velocity))
    }

    fn angles(&self, vector: &Vector6<f64>) -> Vector6<f64> {
        let mut result = *vector;
        result.fixed_rows_mut::<3>(3).copy_from(&self.b.tr_mul(&vector.fixed_rows::<3>(3)));
        result
    }
}

/// The matrix's columns of rotation times column j of `angles`.
#[inline]
fn times(matrix: &Matrix6<f64>, angles: &Matrix3<f64>, j: usize) -> [f64; 6] {
    let [_, _, _, yaw, roll, pitch] = &matrix.data.0;
    let mut sum = [0.0; 6];
    for (i, sum) in sum.iter_mut().enumerate() {
        *sum = yaw[i] * angles[(0, j)] + roll[i] * angles[(1, j)] + pitch[i] * angles[(2, j)];
    }
    sum
}

impl Tangent {
    /// Ends the sum: with the motions in the workspace, everything is turned into terms of coordinates.
    pub fn finish(&mut self, system: &System, workspace: &SystemWorkspace) {
        let motions = &workspace.motions;
        for (slot, row, column) in self.sum.neighbours.iter().chain(self.sum.neighbours.wheels()) {
            let blocks = [&mut self.sum.by_position[slot], &mut self.sum.by_velocity[slot]];
            let Some(WrenchTangent { by_position, by_velocity }) = &self.world[slot] else {
                for block in blocks {
                    *block = Matrix6::zeros();
                }
                continue;
            };
            let by = Axes::of(&motions[column]);
            let on = if row == column { by } else { Axes::of(&motions[row]) };
            let mut position = by.columns(by_position);
            for (j, own) in position[3..].iter_mut().enumerate() {
                for (own, turning) in own.iter_mut().zip(&times(by_velocity, &by.d, j)) {
                    *own += turning;
                }
            }
            for (block, columns) in blocks.into_iter().zip([position, by.columns(by_velocity)]) {
                on.rows(&columns, block);
            }
        }
        self.expand_pairs(motions);
        self.read_twists(system);
        self.fold_wheels();
        for (mobility, (body, motion)) in self.mobility.iter_mut().zip(system.bodies.iter().zip(motions)) {
            *mobility = body.mobility(motion);
        }
        for supported in &system.supported {
            let body = supported.body;
            supported.slow_down(system.bodies[body].mass, workspace.stations.get(body), &mut self.mobility[body]);
        }
        for drive in &system.drives {
            drive.immobilise(&system.bodies[drive.body], motions, &mut self.mobility[drive.body], &workspace.stations);
        }
        self.follow.clear();
        for drive in &system.drives {
            self.follow.extend(drive.follow(motions, &workspace.stations, &workspace.orders).map(|follow| (drive.body, follow)));
        }
        for (spin, (body, motion)) in self.spin.iter_mut().zip(system.bodies.iter().zip(motions)) {
            *spin = gyroscopic(&body.inertia, motion);
        }
        self.weigh_twists();
        for state in &mut self.sum.states {
            for i in 0..state.count {
                for (load, body) in state.load_by_state[i].iter_mut().zip(&state.ends) {
                    let Some(body) = body else { continue };
                    weigh(&self.mobility[*body], &mut load.data.0[0]);
                }
            }
            if let Some((body, loads)) = &mut state.far {
                loads.iter_mut().for_each(|load| weigh(&self.mobility[*body], &mut load.data.0[0]));
            }
        }
        let on_rings = self.rings.iter_mut().flat_map(|rings| rings.wheels_mut());
        for block in self.followers[..self.followed].iter_mut().chain(on_rings) {
            let axes = Axes::of(&motions[block.body]);
            for ((position, velocity), load) in block.by_position.iter_mut().zip(&mut block.by_velocity).zip(&mut block.load) {
                (*position, *velocity) = axes.rates(position, velocity);
                *load = axes.angles(load);
                weigh(&self.mobility[block.body], &mut load.data.0[0]);
            }
        }
    }

    /// How the wrench on a body that [`Tangent::add_wrench`] put there changes with its own motion.
    pub fn own_wrench(&self, body: usize) -> Option<&WrenchTangent> {
        self.world[self.sum.neighbours.slot(body, body)?].as_ref()
    }

    /// How the wrenches that [`Tangent::add_wrench`] put on a body by its own motion change the accelerations of its coordinates. The
    /// motion in world axes: displacement above rotation, and velocity above angular velocity; `known` is taken off the wrench's change.
    pub fn acceleration(
        &self,
        body: usize,
        motion: &BodyMotion,
        [displacement, velocity]: [&Vector6<f64>; 2],
        known: &Wrench,
    ) -> Vector6<f64> {
        let slot = self.sum.neighbours.slot(body, body);
        let Some(tangent) = slot.and_then(|slot| self.world[slot].as_ref()) else { return Vector6::zeros() };
        let change = tangent.by_position * displacement + tangent.by_velocity * velocity;
        let force = Vector3::new(change[0], change[1], change[2]) - known.force;
        let moment = Vector3::new(change[3], change[4], change[5]) - known.moment;
        let generalised = motion.generalised_force(&Wrench { force, moment });
        self.mobility[body] * Vector6::from_iterator(generalised.iter().copied())
    }

    /// Generalised forces and states of pairs, and states of contacts, in terms of coordinates.
    fn expand_pairs(&mut self, motions: &[BodyMotion]) {
        let TangentSum { neighbours, pairs, by_position, by_velocity, states, across } = &mut self.sum;
        self.frames.clear();
        for pair in pairs {
            let frames = PairFrames::new(pair, motions);
            // Weights have nothing to add; many pairs have no dampers.
            if !pair.used {
                self.frames.push(frames);
                continue;
            }
            let mut slots = [[None; 2]; 2];
            for (slots, on) in slots.iter_mut().zip(pair.ends) {
                for (slot, by) in slots.iter_mut().zip(pair.ends) {
                    *slot = on.zip(by).and_then(|(on, by)| neighbours.slot(on, by));
                }
            }
            if !is_zero(&pair.stiffness) {
                frames.add_blocks(&pair.stiffness, &slots, by_position);
            }
            // Forces of both sides may cancel, their lever arms do not.
            if pair.arm_force != Matrix3::zeros() || pair.force != Vector3::zeros() || pair.couple != Vector3::zeros() {
                frames.add_geometry(pair, &slots, by_position);
            }
            if !is_zero(&pair.damping) {
                frames.add_blocks(&pair.damping, &slots, by_velocity);
            }
            for (rates, slots) in pair.rates.iter().flatten().zip(&slots) {
                for (rates, slot) in rates.iter().zip(slots) {
                    if let Some(slot) = slot {
                        by_velocity[*slot] += rates;
                    }
                }
            }
            self.frames.push(frames);
        }
        for Across { on, load, by, measured } in across {
            for (on, load) in on.iter().zip(load) {
                for (by, measured) in by.iter().zip(&*measured) {
                    if let Some(slot) = on.zip(*by).and_then(|(on, by)| neighbours.slot(on, by)) {
                        add_outer(&mut by_position[slot], load, measured, 1.0);
                    }
                }
            }
        }
        for state in states {
            match state.terms {
                Terms::Pair(pair) => self.frames[pair].expand_state(state),
                Terms::World => world_state(state, motions),
                Terms::Coordinates => (),
            }
        }
    }
}

#[inline]
fn is_zero(matrix: &Matrix6<f64>) -> bool {
    matrix.data.0.iter().all(|column| column.iter().fold(0.0, |sum: f64, value| sum + value.abs()) == 0.0)
}

/// A contact's state in terms of its bodies' coordinates.
fn world_state(state: &mut StateTangent, motions: &[BodyMotion]) {
    for (end, body) in state.ends.iter().enumerate() {
        let Some(body) = body else { continue };
        let axes = Axes::of(&motions[*body]);
        let (position, velocity) = axes.rates(&state.rate_by_position[0][end], &state.rate_by_velocity[0][end]);
        (state.rate_by_position[0][end], state.rate_by_velocity[0][end]) = (position, velocity);
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
/// With u = k q - w, k = I/J, in the notation of [`crate::mbs::inertia`]: roll'' = r u + .., r' = -p u + .. . Where the spin makes no moments w stands for q.
#[inline]
fn gyroscopic(inertia: &Inertia, motion: &BodyMotion) -> Matrix3<f64> {
    let (transverse, axial, spin) = match inertia {
        Inertia::Revolution { transverse, axial } => (transverse, axial, 1.0),
        Inertia::NotGyroscopic { transverse, axial } => (transverse, axial, 0.0),
        Inertia::General { .. } => return Matrix3::zeros(),
    };
    let (sin, cos, k) = (motion.frame.sin_roll, motion.frame.cos_roll, axial / transverse);
    let (yaw, roll) = (motion.yaw_rate, motion.roll_rate);
    let u = k * spin * motion.pitch_rate + (k - 1.0) * sin * yaw;
    let [u_yaw, u_pitch] = [(k - 1.0) * sin, k * spin];
    let yaw_row = [(sin * roll - roll * u_yaw) / cos, (sin * yaw - u) / cos, -roll * u_pitch / cos];
    let roll_row = [cos * (u + yaw * u_yaw), 0.0, cos * yaw * u_pitch];
    let pitch_row = [-sin * yaw_row[0] - cos * roll, -sin * yaw_row[1] - cos * yaw, -sin * yaw_row[2]];
    Matrix3::from([yaw_row, roll_row, pitch_row]).transpose()
}
