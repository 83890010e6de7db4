//! The sums over pairs of bodies and their blocks.

use super::pattern::Neighbours;
use crate::mbs::pair_tangent::pair::PairSum;
use crate::mbs::pair_tangent::{Across, StateTangent};
use nalgebra::Matrix6;

/// Sums over all force elements.
#[derive(Clone, Debug)]
pub(super) struct TangentSum {
    pub neighbours: Neighbours,
    pub pairs: Vec<PairSum>,
    /// By slot: dQ/dq and dQ/dv.
    pub by_position: Vec<Matrix6<f64>>,
    pub by_velocity: Vec<Matrix6<f64>>,
    /// As many as `new` was told at most.
    pub states: Vec<StateTangent>,
    /// Of elements that act on three bodies.
    pub across: Vec<Across>,
}

impl TangentSum {
    pub fn new(neighbours: Neighbours, pairs: Vec<PairSum>, [states, across]: [usize; 2]) -> TangentSum {
        let zero = vec![Matrix6::zeros(); neighbours.slots()];
        let (states, across) = (Vec::with_capacity(states), Vec::with_capacity(across));
        TangentSum { neighbours, pairs, by_position: zero.clone(), by_velocity: zero, states, across }
    }

    /// Blocks are begun anew by [`super::Tangent::finish`].
    pub fn clear(&mut self) {
        self.pairs.iter_mut().for_each(PairSum::clear);
        self.states.clear();
        self.across.clear();
    }
}
