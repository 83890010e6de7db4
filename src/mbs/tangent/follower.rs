//! Masses on springs that a body presses on, with all first-order states beside them: eliminated together, before the body.
//!
//! A follower moves along two axes E (3 x 2) fixed in the track: `m u'' = -E^T F - k u - c u'`, where the body's contact feels only the differences
//! p - E u and v - E u'. So with the change of that contact's wrench W = (F, M) with the body's motion, dW/dp and dW/dv (6 x 6):
//!
//! ```text
//! dW/du = -dW/dp E   (translations alone)        m du''/d(p, theta) = -E^T dF/d(p, theta)
//! m du''/du = -k + E^T dF/dp E                   m du''/du' = -c + E^T dF/dv E
//! ```
//!
//! States of the contact itself (its tangential deflection) answer to the same differences, and belong to the same dense block: n = 4 states and those.
//! As with other states, `(1 - a S) s = r_s + a J_q r_q + (a^2 J_q + a J_v) k_v`, solved by a factorisation with pivots, which the body's block then takes up.

use super::{SingularTangent, Tangent, WrenchTangent};
use crate::mbs::pair_tangent::pair::add_outer;
use crate::mbs::pair_tangent::{StateTangent, Terms};
use nalgebra::{Vector3, Vector6};

/// u, u' along both axes.
pub(super) const OWN: usize = 4;

/// A mass under a body's contact.
#[derive(Clone, Copy, Debug, Default)]
pub struct Follower {
    pub body: usize,
    /// Of its four states in the state vector: u, then u'.
    pub first: usize,
    /// E.
    pub axes: [Vector3<f64>; 2],
    /// kg, N/m, N s/m.
    pub mass: [f64; 2],
    pub stiffness: [f64; 2],
    pub damping: [f64; 2],
}

/// States that are eliminated together.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub body: usize,
    pub mass: Follower,
    /// Changes of E^T F with position and velocity of the body, in the world's terms.
    pub pressed: [[Vector6<f64>; 2]; 2],
    /// In the state vector.
    pub states: Vec<usize>,
    /// S, by rows.
    pub own: Vec<f64>,
    /// Changes of the states' rates, and of the body's acceleration with the states: in the world's terms until [`Tangent::finish`].
    pub by_position: Vec<Vector6<f64>>,
    pub by_velocity: Vec<Vector6<f64>>,
    pub load: Vec<Vector6<f64>>,
    /// Of 1 - a S: L and U, and the rows that were taken as pivots.
    factors: Vec<f64>,
    pivots: Vec<usize>,
    /// (1 - a S)^-1 (a^2 J_q + a J_v) by state.
    solved: Vec<Vector6<f64>>,
    /// What the states change by without the body's velocities.
    known: Vec<f64>,
}

impl Block {
    pub fn new(most: usize) -> Block {
        let room = || Vec::with_capacity(most);
        Block {
            body: 0,
            mass: Follower::default(),
            pressed: Default::default(),
            states: Vec::with_capacity(most),
            own: Vec::with_capacity(most * most),
            by_position: room(),
            by_velocity: room(),
            load: room(),
            factors: Vec::with_capacity(most * most),
            pivots: Vec::with_capacity(most),
            solved: room(),
            known: Vec::with_capacity(most),
        }
    }

    pub fn begin(&mut self, body: usize, count: usize) {
        self.body = body;
        self.states.clear();
        self.states.resize(count, 0);
        self.own.clear();
        self.own.resize(count * count, 0.0);
        for vectors in [&mut self.by_position, &mut self.by_velocity, &mut self.load] {
            vectors.clear();
            vectors.resize(count, Vector6::zeros());
        }
    }

    fn own_mut(&mut self, row: usize, column: usize) -> &mut f64 {
        let count = self.states.len();
        &mut self.own[row * count + column]
    }

    /// The mass itself; `wrench`: dW.
    pub fn take_mass(&mut self, follower: &Follower, wrench: &WrenchTangent) {
        let Follower { first, axes, mass, stiffness, damping, .. } = follower;
        self.mass = *follower;
        for i in 0..2 {
            (self.states[i], self.states[2 + i]) = (first + i, first + 2 + i);
            *self.own_mut(i, 2 + i) = 1.0;
            // E^T dF, row i.
            let [of_position, of_velocity] =
                [&wrench.by_position, &wrench.by_velocity].map(|part| part.fixed_rows::<3>(0).tr_mul(&axes[i]));
            self.pressed[i] = [of_position, of_velocity];
            self.by_position[2 + i] = -of_position / mass[i];
            self.by_velocity[2 + i] = -of_velocity / mass[i];
            self.load[i] = -(wrench.by_position.fixed_columns::<3>(0) * axes[i]);
            self.load[2 + i] = -(wrench.by_velocity.fixed_columns::<3>(0) * axes[i]);
            for (j, axis) in axes.iter().enumerate() {
                let own = if i == j { 1.0 } else { 0.0 };
                *self.own_mut(2 + i, j) = (of_position.fixed_rows::<3>(0).dot(axis) - own * stiffness[i]) / mass[i];
                *self.own_mut(2 + i, 2 + j) = (of_velocity.fixed_rows::<3>(0).dot(axis) - own * damping[i]) / mass[i];
            }
        }
    }

    /// A state of the contact as number `place`.
    pub fn take_state(&mut self, place: usize, state: &StateTangent, follower: &Follower) {
        self.states[place] = state.first;
        *self.own_mut(place, place) = state.rate_by_state[(0, 0)];
        if state.ends[0].is_none() {
            return;
        }
        let (position, velocity, load) = (state.rate_by_position[0][0], state.rate_by_velocity[0][0], state.load_by_state[0][0]);
        for (i, axis) in follower.axes.iter().enumerate() {
            *self.own_mut(place, i) = -position.fixed_rows::<3>(0).dot(axis);
            *self.own_mut(place, 2 + i) = -velocity.fixed_rows::<3>(0).dot(axis);
            *self.own_mut(2 + i, place) = -load.fixed_rows::<3>(0).dot(axis) / follower.mass[i];
        }
        (self.by_position[place], self.by_velocity[place], self.load[place]) = (position, velocity, load);
    }

    /// Factorises 1 - a S; `false` where it is singular.
    fn factorise(&mut self, a: f64) -> bool {
        let count = self.states.len();
        self.factors.clear();
        self.factors.extend(self.own.iter().map(|value| -a * value));
        for i in 0..count {
            self.factors[i * count + i] += 1.0;
        }
        factorise(&mut self.factors, count, &mut self.pivots)
    }

    /// Solves (1 - a S) x = x in place.
    pub fn solve<T>(factors: &[f64], pivots: &[usize], x: &mut [T])
    where
        T: Copy + std::ops::Mul<f64, Output = T> + std::ops::SubAssign,
    {
        let count = pivots.len();
        for (k, pivot) in pivots.iter().enumerate() {
            x.swap(k, *pivot);
        }
        for row in 1..count {
            for j in 0..row {
                let part = x[j] * factors[row * count + j];
                x[row] -= part;
            }
        }
        for row in (0..count).rev() {
            for j in row + 1..count {
                let part = x[j] * factors[row * count + j];
                x[row] -= part;
            }
            x[row] = x[row] * (1.0 / factors[row * count + row]);
        }
    }

    /// Adds what its states do to the product of J and `x`, positions and velocities of its body `q` and `v`, to rates and to the body's accelerations.
    pub fn add_product(&self, [q, v]: [&Vector6<f64>; 2], x: &[f64], rates: &mut [f64]) -> Vector6<f64> {
        let mut acceleration = Vector6::zeros();
        for (i, row) in self.own.chunks_exact(self.states.len()).enumerate() {
            let beside: f64 = row.iter().zip(&self.states).map(|(own, state)| own * x[*state]).sum();
            rates[self.states[i]] = self.by_position[i].dot(q) + self.by_velocity[i].dot(v) + beside;
            acceleration += self.load[i] * x[self.states[i]];
        }
        acceleration
    }
}

/// L and U of a matrix by rows in its place, with the rows that were taken as pivots; `false` where it is singular.
pub(super) fn factorise(m: &mut [f64], count: usize, pivots: &mut Vec<usize>) -> bool {
    pivots.clear();
    for k in 0..count {
        let size = |row: usize| m[row * count + k].abs();
        let pivot = (k..count).fold(k, |best, row| if size(row) > size(best) { row } else { best });
        if !(size(pivot) > 0.0) {
            return false;
        }
        pivots.push(pivot);
        for j in 0..count {
            m.swap(k * count + j, pivot * count + j);
        }
        for row in k + 1..count {
            let factor = m[row * count + k] / m[k * count + k];
            m[row * count + k] = factor;
            for j in k + 1..count {
                m[row * count + j] -= factor * m[k * count + j];
            }
        }
    }
    true
}

impl Tangent {
    /// Makes room for so many followers with at most `further` states of their contacts each.
    pub fn with_followers(mut self, count: usize, further: usize) -> Tangent {
        self.followers = (0..count).map(|_| Block::new(OWN + further)).collect();
        self
    }

    /// Number of states handed in so far.
    pub fn states(&self) -> usize {
        self.sum.states.len()
    }

    /// Adds a follower under a contact whose wrench on the body changes by `wrench` with the body's motion; the states handed in since there were `before`
    /// are those of that contact, and become part of it.
    pub fn add_follower(&mut self, follower: &Follower, wrench: &WrenchTangent, before: usize) {
        let taken = self.sum.states.len() - before;
        let Some(block) = self.followers.get_mut(self.followed) else { return };
        debug_assert!(OWN + taken <= block.states.capacity(), "more states than Tangent::with_followers was told");
        self.followed += 1;
        block.begin(follower.body, OWN + taken);
        block.take_mass(follower, wrench);
        for (place, state) in self.sum.states[before..].iter().enumerate() {
            debug_assert!(matches!(state.terms, Terms::World) && state.count == 1);
            block.take_state(OWN + place, state, follower);
        }
        self.sum.states.truncate(before);
    }

    /// Where a follower's states stand, u'' behind them, and how u'' changes with a motion of its body in world axes: displacement above rotation, velocity
    /// above angular velocity; `known` is taken off the change of the contact's force.
    pub fn follower_accelerations(
        &self,
        number: usize,
        [displacement, velocity]: [&Vector6<f64>; 2],
        known: &Vector3<f64>,
    ) -> Option<(usize, [f64; 2])> {
        let Block { mass: Follower { first, axes, mass, .. }, pressed, .. } = self.followers[..self.followed].get(number)?;
        let change = |i: usize| {
            let [by_position, by_velocity]: [Vector6<f64>; 2] = pressed[i];
            -(by_position.dot(displacement) + by_velocity.dot(velocity) - axes[i].dot(known)) / mass[i]
        };
        Some((first + 2, [change(0), change(1)]))
    }

    /// Takes followers' states out of the bodies' blocks of I - a J.
    pub(super) fn eliminate_followers(&mut self, a: f64) -> Result<(), SingularTangent> {
        let nodes = self.x.len() + self.sum.states.len();
        for (index, block) in self.followers[..self.followed].iter_mut().enumerate() {
            if !block.factorise(a) {
                return Err(SingularTangent { node: nodes + index });
            }
            block.solved.clear();
            block.solved.extend(block.by_position.iter().zip(&block.by_velocity).map(|(position, velocity)| (position * a + velocity) * a));
            Block::solve(&block.factors, &block.pivots, &mut block.solved);
            let Some(slot) = self.sum.neighbours.slot(block.body, block.body) else { continue };
            let target = self.lu.block_mut(self.places[slot]);
            for (load, solved) in block.load.iter().zip(&block.solved) {
                add_outer(target, load, solved, -a);
            }
        }
        Ok(())
    }

    /// What followers do to the right-hand side of their bodies: `positions` and `rest` as in the state vector, `count` coordinates.
    pub(super) fn reduce_followers(&mut self, positions: &[f64], rest: &[f64], count: usize) {
        let a = self.a;
        for block in &mut self.followers[..self.followed] {
            let own = Vector6::from_column_slice(&positions[6 * block.body..6 * block.body + 6]);
            block.known.clear();
            block.known.extend(block.states.iter().zip(&block.by_position).map(|(state, by)| rest[state - count] + a * by.dot(&own)));
            Block::solve(&block.factors, &block.pivots, &mut block.known);
            for (load, known) in block.load.iter().zip(&block.known) {
                self.x[block.body] += load * (a * known);
            }
        }
    }

    /// Followers' states from the velocities that were found, which stand first in `rest`.
    pub(super) fn restore_followers(&self, rest: &mut [f64], count: usize) {
        for block in &self.followers[..self.followed] {
            let own = Vector6::from_column_slice(&rest[6 * block.body..6 * block.body + 6]);
            for ((state, known), solved) in block.states.iter().zip(&block.known).zip(&block.solved) {
                rest[state - count] = known + solved.dot(&own);
            }
        }
    }
}
