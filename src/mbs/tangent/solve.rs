//! I - a J in velocities alone: forming its blocks, and the way of a right-hand side through it.

use super::world::weigh;
use super::{SingularTangent, Tangent};
use crate::mbs::body::COORDINATES;
use crate::mbs::pair_tangent::Gradient;
use crate::mbs::pair_tangent::pair::add_outer;
use crate::mbs::system::SystemWorkspace;
use nalgebra::{Matrix2, Matrix6, Vector2, Vector3, Vector6};

/// First-order states after their elimination.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Eliminated {
    /// (1 - a d s'/d s)^-1.
    pub inverse: Matrix2<f64>,
    /// c = a (a df/dq + df/dv), per state.
    pub change: [Gradient; 2],
    /// a M^-1 dQ/ds.
    pub acceleration: [Gradient; 2],
    /// The same of a third body.
    pub far: [Vector6<f64>; 2],
    /// The same two of the twist of the axle that they follow.
    pub twist_change: [f64; 2],
    pub twist_acceleration: [f64; 2],
    /// What the states change by without the bodies' velocities, for the present right-hand side.
    pub known: Vector2<f64>,
}

impl Tangent {
    /// J x without constraints, in a vector as long as the state vector; needs [`Tangent::finish`].
    pub fn times(&self, x: &[f64], result: &mut [f64]) {
        let count = COORDINATES * self.mobility.len();
        let (positions, velocities) = (&x[..count], &x[count..2 * count]);
        result.fill(0.0);
        result[..count].copy_from_slice(velocities);
        for (slot, row, column) in self.sum.neighbours.iter() {
            let at = |body: usize| COORDINATES * body..COORDINATES * (body + 1);
            let (position, velocity) =
                (Vector6::from_column_slice(&positions[at(column)]), Vector6::from_column_slice(&velocities[at(column)]));
            let mut part = self.sum.by_position[slot] * position + self.sum.by_velocity[slot] * velocity;
            weigh(&self.mobility[row], &mut part.data.0[0]);
            if row == column {
                let mut angles = part.fixed_rows_mut::<3>(3);
                angles += self.spin[row] * velocity.fixed_rows::<3>(3);
            }
            for (result, part) in result[count..][at(row)].iter_mut().zip(part.iter()) {
                *result += part;
            }
        }
        for (body, follow) in &self.follow {
            let first = COORDINATES * body;
            let part = follow * Vector3::from_column_slice(&velocities[first..first + 3]);
            for (result, part) in result[count..][first..].iter_mut().zip(part.iter()) {
                *result += part;
            }
        }
        for block in &self.followers[..self.followed] {
            let at = COORDINATES * block.body..COORDINATES * (block.body + 1);
            let own = [positions, velocities].map(|all| Vector6::from_column_slice(&all[at.clone()]));
            let acceleration = block.add_product([&own[0], &own[1]], x, result);
            for (result, part) in result[count..][at].iter_mut().zip(acceleration.iter()) {
                *result += part;
            }
        }
        self.add_rings_times(x, result);
        for state in &self.sum.states {
            let own = Vector2::from_fn(|i, _| if i < state.count { x[state.index(i)] } else { 0.0 });
            let rates = state.rate_by_state * own;
            for i in 0..state.count {
                let moved = state.along(&state.rate_by_position[i], positions) + state.along(&state.rate_by_velocity[i], velocities);
                result[state.index(i)] = moved + rates[i];
                for (end, body) in state.ends.iter().enumerate() {
                    let Some(body) = body else { continue };
                    let part = state.load_by_state[i][end] * own[i];
                    for (result, part) in result[count + COORDINATES * body..].iter_mut().zip(part.iter()) {
                        *result += part;
                    }
                }
                if let Some((body, loads)) = &state.far {
                    for (result, part) in result[count + COORDINATES * body..].iter_mut().zip(loads[i].iter()) {
                        *result += part * own[i];
                    }
                }
            }
        }
        if !self.twists.is_empty() {
            self.add_twists_times(x, result);
        }
    }

    /// Change of the force on a body [N], of elements and contacts, where bodies' coordinates and velocities change by those in x; needs [`Tangent::finish`].
    /// Without what first-order states of elements (dampers in series with springs) add.
    pub fn force_on(&self, body: usize, x: &[f64]) -> Vector3<f64> {
        let count = COORDINATES * self.mobility.len();
        let mut force = Vector3::zeros();
        for (slot, _, column) in self.sum.neighbours.iter().filter(|(_, row, _)| *row == body) {
            let at = |first: usize| Vector6::from_column_slice(&x[first + COORDINATES * column..][..COORDINATES]);
            let (position, velocity) = (&self.sum.by_position[slot], &self.sum.by_velocity[slot]);
            force += position.fixed_rows::<3>(0) * at(0) + velocity.fixed_rows::<3>(0) * at(count);
        }
        force
    }

    /// Factorises I - a J, a in s, with the active constraint rows in the workspace.
    ///
    /// # Errors
    /// [`SingularTangent`]: for some a there may be one, if the system is unstable.
    pub fn factorise(&mut self, a: f64, workspace: &SystemWorkspace) -> Result<(), SingularTangent> {
        self.a = a;
        self.lu.clear();
        for (slot, row, column) in self.sum.neighbours.iter() {
            let block = self.lu.block_mut(self.places[slot]);
            let sources = self.sum.by_position[slot].data.0.iter().zip(&self.sum.by_velocity[slot].data.0);
            for (block, (position, velocity)) in block.data.0.iter_mut().zip(sources) {
                for (block, (position, velocity)) in block.iter_mut().zip(position.iter().zip(velocity)) {
                    *block = -a * (velocity + a * position);
                }
                weigh(&self.mobility[row], block);
            }
            if row == column {
                for i in 0..COORDINATES {
                    block[(i, i)] += 1.0;
                }
                let mut angles = block.fixed_view_mut::<3, 3>(3, 3);
                angles -= self.spin[row] * a;
            }
        }
        for (body, follow) in &self.follow {
            let Some(slot) = self.sum.neighbours.slot(*body, *body) else { continue };
            let mut displacements = self.lu.block_mut(self.places[slot]).fixed_view_mut::<3, 3>(0, 0);
            displacements -= follow * a;
        }
        self.add_twist_blocks(a);
        self.eliminate_states(a)?;
        if !self.twists.is_empty() {
            self.eliminate_onto_twists(a);
        }
        self.eliminate_followers(a)?;
        self.eliminate_rings(a)?;
        self.add_rows(workspace);
        self.lu.factorise().map_err(|node| SingularTangent { node })
    }

    fn eliminate_states(&mut self, a: f64) -> Result<(), SingularTangent> {
        let places = &self.places;
        self.eliminated.resize(self.sum.states.len(), Eliminated::default());
        for (index, (state, own)) in self.sum.states.iter().zip(&mut self.eliminated).enumerate() {
            own.inverse = state.inverse(a).ok_or(SingularTangent { node: self.x.len() + index })?;
            for i in 0..state.count {
                for end in (0..2).filter(|end| state.ends[*end].is_some()) {
                    own.change[i][end] = (state.rate_by_position[i][end] * a + state.rate_by_velocity[i][end]) * a;
                    own.acceleration[i][end] = state.load_by_state[i][end] * a;
                }
            }
            for (on, row) in state.ends.iter().enumerate() {
                for (by, column) in state.ends.iter().enumerate() {
                    let (Some(row), Some(column)) = (row, column) else { continue };
                    let Some(slot) = self.sum.neighbours.slot(*row, *column) else { continue };
                    let block = self.lu.block_mut(places[slot]);
                    for i in 0..state.count {
                        for j in 0..state.count {
                            add_outer(block, &own.acceleration[i][on], &own.change[j][by], -own.inverse[(i, j)]);
                        }
                    }
                }
            }
            let Some((far, loads)) = &state.far else { continue };
            own.far = loads.map(|load| load * a);
            for (by, column) in state.ends.iter().enumerate() {
                let Some(slot) = column.and_then(|column| self.sum.neighbours.slot(*far, column)) else { continue };
                let block = self.lu.block_mut(places[slot]);
                for i in 0..state.count {
                    (0..state.count).for_each(|j| add_outer(block, &own.far[i], &own.change[j][by], -own.inverse[(i, j)]));
                }
            }
        }
        Ok(())
    }

    /// Constraint rows and the accelerations that their multipliers cause; a row that is left out has the multiplier zero.
    fn add_rows(&mut self, workspace: &SystemWorkspace) {
        let kkt = &workspace.constraints.kkt;
        for group in &mut self.groups {
            let pivot = self.lu.block_mut(group.pivot);
            for i in 0..COORDINATES {
                pivot[(i, i)] = f64::from(!group.rows.get(i).is_some_and(|row| kkt.is_active(*row)));
            }
            for (end, side) in group.sides.iter_mut().enumerate() {
                let (mut rows, mut columns) = (Matrix6::zeros(), Matrix6::zeros());
                for (i, row) in group.rows.iter().enumerate().filter(|(_, row)| kkt.is_active(**row)) {
                    let (_, first, second) = kkt.row(*row);
                    let own = if end == 0 { first } else { second };
                    rows.set_row(i, &own.transpose());
                    columns.set_column(i, &(self.mobility[side.body] * own));
                }
                *self.lu.block_mut(side.lower) = rows;
                *self.lu.block_mut(side.upper) = columns;
                side.rows = rows;
            }
        }
    }

    /// What states change by without the bodies' velocities, and what they push bodies with by that.
    fn push_states(&mut self, positions: &[f64], rest: &[f64], count: usize) {
        let a = self.a;
        for (state, eliminated) in self.sum.states.iter().zip(&mut self.eliminated) {
            let mut right = Vector2::zeros();
            for i in 0..state.count {
                right[i] = a * state.along(&state.rate_by_position[i], positions) + rest[state.index(i) - count];
            }
            eliminated.known = eliminated.inverse * right;
            for i in 0..state.count {
                for (end, body) in state.ends.iter().enumerate() {
                    let Some(body) = body else { continue };
                    self.x[*body] += eliminated.acceleration[i][end] * eliminated.known[i];
                }
                if let Some((body, _)) = &state.far {
                    self.x[*body] += eliminated.far[i] * eliminated.known[i];
                }
            }
        }
    }

    /// Solves (I - a J) x = x in place, x as long as the state vector; states that J does not know (J = 0) stay.
    pub fn solve(&mut self, x: &mut [f64]) {
        self.solve_pushed(x, 0.0, &[]);
    }

    /// Solves (I - a J) x = x + weight push in place. Constraints hold for x as it comes, so that accelerations in `push`, as long as x
    /// or empty, may be what forces do without them. Its coordinates do not count.
    pub fn solve_pushed(&mut self, x: &mut [f64], weight: f64, push: &[f64]) {
        let (a, count) = (self.a, COORDINATES * self.mobility.len());
        let (positions, rest) = x.split_at_mut(count);
        let velocities = &mut rest[..count];
        for (own, values) in self.x.iter_mut().zip(velocities.chunks_exact(COORDINATES)) {
            own.copy_from_slice(values);
        }
        for group in &self.groups {
            let mut own = Vector6::zeros();
            for side in &group.sides {
                own += side.rows * self.x[side.body];
            }
            self.x[group.node] = own;
        }
        if let Some(push) = push.get(count..) {
            for (own, push) in self.x.iter_mut().zip(push[..count].chunks_exact(COORDINATES)) {
                own.iter_mut().zip(push).for_each(|(own, push)| *own += weight * push);
            }
            rest[count..].iter_mut().zip(&push[count..]).for_each(|(own, push)| *own += weight * push);
        }
        for row in 0..self.mobility.len() {
            let mut load = [0.0; 6];
            for (slot, column) in self.sum.neighbours.of(row) {
                let values = &positions[COORDINATES * column..COORDINATES * (column + 1)];
                for (block, value) in self.sum.by_position[slot].data.0.iter().zip(values) {
                    for (load, block) in load.iter_mut().zip(block) {
                        *load += block * value;
                    }
                }
            }
            weigh(&self.mobility[row], &mut load);
            for (own, load) in self.x[row].data.0[0].iter_mut().zip(&load) {
                *own += a * load;
            }
        }
        if !self.twists.is_empty() {
            self.start_twists(positions, rest);
        }
        self.push_states(positions, rest, count);
        if !self.twists.is_empty() {
            self.push_twists();
        }
        self.reduce_followers(positions, rest, count);
        self.reduce_rings(positions, rest, count);
        self.lu.solve(&mut self.x);
        let velocities = &mut rest[..count];
        for (own, values) in self.x.iter().zip(velocities.chunks_exact_mut(COORDINATES)) {
            values.copy_from_slice(own.as_slice());
        }
        for (state, eliminated) in self.sum.states.iter().zip(&self.eliminated) {
            let mut moved = Vector2::zeros();
            for i in 0..state.count {
                moved[i] = state.along(&eliminated.change[i], &rest[..count]);
            }
            if let Some(twist) = &state.twist {
                let rate = self.found_twist(twist);
                (0..state.count).for_each(|i| moved[i] += eliminated.twist_change[i] * rate);
            }
            let found = eliminated.known + eliminated.inverse * moved;
            for i in 0..state.count {
                rest[state.index(i) - count] = found[i];
            }
        }
        self.end_twists(rest);
        self.restore_followers(rest, count);
        self.restore_rings(positions, rest, count);
        for (position, velocity) in positions.iter_mut().zip(&rest[..count]) {
            *position += a * velocity;
        }
    }
}
