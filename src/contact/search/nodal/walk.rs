//! What is met on the way along the wheel's nodes: pairs, batches, the deepest of them.

use super::plane::Section;
use crate::contact::search::nodes::Bounds;

/// A wheel node and its partner.
#[derive(Clone, Copy)]
pub struct NodePair {
    pub wheel: usize,
    pub rail: usize,
    /// delta, m.
    pub penetration: f64,
}

impl NodePair {
    pub fn touches(&self) -> bool {
        self.penetration > 0.0
    }
}

/// Consecutive nodes that touch.
#[derive(Clone, Copy)]
pub struct Batch {
    pub deepest: NodePair,
    /// A second hump with the penetration at the saddle, m.
    pub beside: Option<(NodePair, f64)>,
}

/// What has been seen on the way along the wheel's profile.
#[derive(Default)]
pub struct Walk {
    /// The deepest batch and the next.
    pub deepest: Option<Batch>,
    second: Option<Batch>,
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

    /// Keeps a batch if it is one of the two deepest so far.
    pub fn keep(&mut self, batch: Batch) {
        let deeper = |other: Option<Batch>| other.is_none_or(|other| batch.deepest.penetration > other.deepest.penetration);
        if deeper(self.deepest) {
            self.second = self.deepest;
            self.deepest = Some(batch);
        } else if deeper(self.second) {
            self.second = Some(batch);
        }
    }

    /// The contacts, and the penetration at the saddle between them where they are humps of one batch.
    pub fn found(&self) -> ([Option<NodePair>; 2], Option<f64>) {
        let deepest = |batch: Option<Batch>| batch.map(|batch| batch.deepest);
        match (self.second, self.deepest.and_then(|batch| batch.beside)) {
            (None, Some((beside, saddle))) => ([deepest(self.deepest), Some(beside)], Some(saddle)),
            _ => ([deepest(self.deepest), deepest(self.second)], None),
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
