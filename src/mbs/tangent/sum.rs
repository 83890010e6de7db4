//! What force elements and contacts add up to: generalised forces by coordinates and velocities, pair of bodies by pair, and the
//! first-order states with what they couple.

use super::pattern::Neighbours;
use super::relative::{Blocks, Gradient};
use nalgebra::{Matrix2, Matrix6, Vector2, Vector6};

/// Bodies of the two ends of something; `None`: the world.
pub type Ends = [Option<usize>; 2];

/// One or two first-order states, all derivatives by coordinates and their velocities.
#[derive(Clone, Copy, Debug)]
pub struct StateTangent {
    /// Index in the state vector, and number.
    pub first: usize,
    pub count: usize,
    pub ends: Ends,
    /// d sigma_i' / d sigma_j, 1/s.
    pub rate_by_state: Matrix2<f64>,
    /// Per state: change of its rate with coordinates and velocities, and of the generalised forces with it.
    pub rate_by_position: [Gradient; 2],
    pub rate_by_velocity: [Gradient; 2],
    pub load_by_state: [Gradient; 2],
}

impl StateTangent {
    /// `count` states (at most two) that nothing acts on yet.
    #[inline]
    pub fn new(first: usize, count: usize, ends: Ends) -> StateTangent {
        let none = [[Vector6::zeros(); 2]; 2];
        let rate_by_state = Matrix2::zeros();
        StateTangent { first, count, ends, rate_by_state, rate_by_position: none, rate_by_velocity: none, load_by_state: none }
    }

    #[inline]
    pub(super) fn index(&self, i: usize) -> usize {
        self.first + i
    }

    /// (1 - a d sigma'/d sigma)^-1; a single state's partner is left alone. Zero where it has no inverse.
    pub(super) fn inverse(&self, a: f64) -> Option<Matrix2<f64>> {
        let mut matrix = Matrix2::identity() - self.rate_by_state * a;
        if self.count == 1 {
            (matrix[(0, 1)], matrix[(1, 0)], matrix[(1, 1)]) = (0.0, 0.0, 1.0);
        }
        matrix.try_inverse()
    }

    /// Change of the rates with coordinate changes `x` (6 per body).
    #[inline]
    pub(super) fn times(&self, gradients: &[Gradient; 2], x: &[f64]) -> Vector2<f64> {
        let mut result = Vector2::zeros();
        for i in 0..self.count {
            for (end, gradient) in self.ends.iter().zip(&gradients[i]) {
                let Some(body) = end else { continue };
                result[i] += x[6 * body..6 * body + 6].iter().zip(gradient.iter()).map(|(x, g)| x * g).sum::<f64>();
            }
        }
        result
    }
}

/// Adds `left right^T` to a block; column by column, which the compiler turns into vector instructions.
#[inline]
pub(super) fn add_outer(block: &mut Matrix6<f64>, left: &Vector6<f64>, right: &Vector6<f64>) {
    let left: &[f64; 6] = &left.data.0[0];
    for (column, factor) in block.data.0.iter_mut().zip(right.iter()) {
        for (value, left) in column.iter_mut().zip(left) {
            *value += left * factor;
        }
    }
}

/// Sums over all force elements.
#[derive(Clone, Debug)]
pub struct TangentSum {
    pub(super) neighbours: Neighbours,
    /// dQ/dq and dQ/dv by slot.
    pub(super) by_position: Vec<Matrix6<f64>>,
    pub(super) by_velocity: Vec<Matrix6<f64>>,
    /// As many as `new` was told at most.
    pub(super) states: Vec<StateTangent>,
}

impl TangentSum {
    pub(super) fn new(neighbours: Neighbours, states: usize) -> TangentSum {
        let zero = vec![Matrix6::zeros(); neighbours.slots()];
        TangentSum { neighbours, by_position: zero.clone(), by_velocity: zero, states: Vec::with_capacity(states) }
    }

    pub(super) fn clear(&mut self) {
        self.by_position.fill(Matrix6::zeros());
        self.by_velocity.fill(Matrix6::zeros());
        self.states.clear();
    }

    /// The block (row end, column end) of each pair of ends that are bodies of the pattern.
    #[inline]
    fn slots(&self, ends: Ends) -> [[Option<usize>; 2]; 2] {
        ends.map(|on| ends.map(|by| self.neighbours.slot(on?, by?)))
    }

    /// Generalised forces that change by `dQ = load (by_position . dq + by_velocity . dv)`.
    #[inline]
    pub fn add_force(&mut self, ends: Ends, load: &Gradient, by_position: &Gradient, by_velocity: &Gradient) {
        for (on, row) in self.slots(ends).into_iter().enumerate() {
            for (by, slot) in row.into_iter().enumerate() {
                let Some(slot) = slot else { continue };
                add_outer(&mut self.by_position[slot], &load[on], &by_position[by]);
                add_outer(&mut self.by_velocity[slot], &load[on], &by_velocity[by]);
            }
        }
    }

    /// The same without velocities.
    #[inline]
    pub fn add_spring(&mut self, ends: Ends, load: &Gradient, by_position: &Gradient) {
        for (on, row) in self.slots(ends).into_iter().enumerate() {
            for (by, slot) in row.into_iter().enumerate() {
                let Some(slot) = slot else { continue };
                add_outer(&mut self.by_position[slot], &load[on], &by_position[by]);
            }
        }
    }

    /// Generalised forces that change by `dQ = factor blocks dq`.
    #[inline]
    pub fn add_blocks(&mut self, ends: Ends, factor: f64, blocks: &Blocks) {
        for (row, blocks) in self.slots(ends).into_iter().zip(blocks) {
            for (slot, block) in row.into_iter().zip(blocks) {
                let Some(slot) = slot else { continue };
                self.by_position[slot] += block * factor;
            }
        }
    }

    /// First-order states.
    #[inline]
    pub fn add_states(&mut self, states: StateTangent) {
        debug_assert!(self.states.len() < self.states.capacity(), "more states than Tangent::new was told");
        self.states.push(states);
    }
}
