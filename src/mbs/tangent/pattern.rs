//! Which pairs of bodies act on each other, and in which order blocks are eliminated.

use std::collections::BTreeSet;

/// The blocks of pairs of bodies that are joined by a force element, and of each body with itself; row by row.
#[derive(Clone, Debug)]
pub(super) struct Neighbours {
    /// Slots of row b: `starts[b]..starts[b + 1]`.
    starts: Vec<usize>,
    columns: Vec<u32>,
    /// Row and column of the blocks that follow: of pairs with a wheel that turns against its axle, counted behind the bodies.
    pub with_wheels: Vec<(usize, usize)>,
}

impl Neighbours {
    pub fn new(bodies: usize, pairs: impl Iterator<Item = (usize, usize)>, with_wheels: Vec<(usize, usize)>) -> Neighbours {
        let mut rows: Vec<BTreeSet<usize>> = (0..bodies).map(|body| BTreeSet::from([body])).collect();
        for (a, b) in pairs {
            rows[a].insert(b);
            rows[b].insert(a);
        }
        let mut starts = vec![0];
        let mut columns = Vec::new();
        for row in rows {
            columns.extend(row.into_iter().map(|column| column as u32));
            starts.push(columns.len());
        }
        Neighbours { starts, columns, with_wheels }
    }

    pub fn slots(&self) -> usize {
        self.columns.len() + self.with_wheels.len()
    }

    /// Slots of pairs of bodies, which come first.
    pub fn of_bodies(&self) -> usize {
        self.columns.len()
    }

    #[inline(never)]
    fn wheel_slot(&self, on: usize, by: usize) -> Option<usize> {
        self.with_wheels.iter().position(|own| *own == (on, by)).map(|at| self.columns.len() + at)
    }

    /// Few neighbours: a search is faster than a table.
    #[inline]
    pub fn slot(&self, on: usize, by: usize) -> Option<usize> {
        if !self.with_wheels.is_empty() && on.max(by) + 1 >= self.starts.len() {
            return self.wheel_slot(on, by);
        }
        let start = self.starts[on];
        let found = self.columns[start..self.starts[on + 1]].iter().position(|column| *column as usize == by);
        found.map(|at| start + at)
    }

    /// Slots and columns of a row.
    #[inline]
    pub fn of(&self, row: usize) -> impl Iterator<Item = (usize, usize)> {
        let range = self.starts[row]..self.starts[row + 1];
        range.clone().zip(self.columns[range].iter().map(|column| *column as usize))
    }

    /// All slots of pairs of bodies with row and column.
    pub fn iter(&self) -> impl Iterator<Item = (usize, usize, usize)> {
        let rows = self.starts.windows(2).enumerate();
        rows.flat_map(move |(row, range)| (range[0]..range[1]).map(move |slot| (slot, row, self.columns[slot] as usize)))
    }
}

/// Nodes of the elimination graph: bodies first, then groups of constraint rows, each with its bodies.
pub(super) struct Graph {
    pub nodes: usize,
    pub edges: Vec<(usize, usize)>,
    /// Nodes (all bodies of a group) that must be eliminated before a node.
    pub before: Vec<Vec<usize>>,
}

/// One elimination: a node and the nodes that it is still joined to then.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Elimination {
    pub node: usize,
    pub neighbours: Vec<usize>,
}

impl Graph {
    /// Minimum degree, ties to the lowest number; constraint rows after all of their bodies, so that no pivot is zero.
    pub fn order(&self) -> Vec<Elimination> {
        let mut joined = vec![BTreeSet::new(); self.nodes];
        for (a, b) in self.edges.iter().filter(|(a, b)| a != b) {
            joined[*a].insert(*b);
            joined[*b].insert(*a);
        }
        let mut left: BTreeSet<usize> = (0..self.nodes).collect();
        let mut order = Vec::with_capacity(self.nodes);
        let ready = |left: &BTreeSet<usize>, node: usize| !self.before[node].iter().any(|other| left.contains(other));
        while let Some(node) = left.iter().copied().filter(|node| ready(&left, *node)).min_by_key(|node| joined[*node].len()) {
            left.remove(&node);
            let neighbours = std::mem::take(&mut joined[node]);
            for a in &neighbours {
                joined[*a].remove(&node);
                joined[*a].extend(neighbours.iter().filter(|b| *b != a));
            }
            order.push(Elimination { node, neighbours: neighbours.into_iter().collect() });
        }
        order
    }
}
