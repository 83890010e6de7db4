//! The sums over pairs of bodies and their blocks.

use super::pattern::Neighbours;
use crate::mbs::pair_tangent::StateTangent;
use crate::mbs::pair_tangent::pair::PairSum;
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
}

impl TangentSum {
    pub fn new(neighbours: Neighbours, pairs: Vec<PairSum>, states: usize) -> TangentSum {
        let zero = vec![Matrix6::zeros(); neighbours.slots()];
        TangentSum { neighbours, pairs, by_position: zero.clone(), by_velocity: zero, states: Vec::with_capacity(states) }
    }

    /// Blocks are begun anew by [`super::Tangent::finish`].
    pub fn clear(&mut self) {
        self.pairs.iter_mut().for_each(PairSum::clear);
        self.states.clear();
    }
}
