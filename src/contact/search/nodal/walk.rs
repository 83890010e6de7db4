//! What is met on the way along the wheel's nodes: pairs, and the humps of their depths.

use super::plane::Section;
use crate::contact::search::humps::Humps;
use crate::contact::search::nodes::Bounds;

/// A wheel node and its partner.
#[derive(Clone, Copy)]
pub struct NodePair {
    pub wheel: usize,
    pub rail: usize,
    /// delta, m.
    pub penetration: f64,
}

/// A hump of a batch's depth stands out by more than so much of the greatest depth.
pub const LEAST_HUMP: f64 = 1e-3;

/// What has been seen on the way along the wheel's profile.
#[derive(Default)]
pub struct Walk {
    /// Depths of nodes that touch, with wheel and rail node.
    pub humps: Humps<(usize, usize)>,
    /// NodePair with the greatest penetration, touching or not.
    pub closest: Option<NodePair>,
    /// Only pairs that cannot come closer than `closest` may be passed over.
    pub closest_wanted: bool,
    pub evaluated: usize,
    pub looked_up: usize,
}

impl Walk {
    #[inline]
    pub fn apart(&mut self, pair: NodePair) {
        if self.closest.is_none_or(|closest| pair.penetration > closest.penetration) {
            self.closest = Some(pair);
        }
    }

    /// Least G, m, of a node that may be passed over on a rail with these bounds: the normal gap of the closest pair
    /// against the steepest normal.
    #[inline]
    pub fn least_gap(&self, plane: &Section, rail: &Bounds) -> f64 {
        match self.closest {
            Some(closest) if self.closest_wanted => {
                let lean = plane.lean.0.abs() + plane.lean.1.abs() * rail.steepest;
                -closest.penetration * (1.0 + rail.steepest * rail.steepest + lean * lean).sqrt()
            }
            _ => 0.0,
        }
    }
}
