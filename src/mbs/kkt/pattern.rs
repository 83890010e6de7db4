//! Which elements of S = J M^-1 J^T are stored, and which products make each of them.
//!
//! A slot is a row's part on one body (2 r for the first, 2 r + 1 for the second). Element (r, s) is the sum over
//! the pairs of slots of r and s that lie on the same body.

use super::RowBodies;
use std::ops::Range;

/// One stored element of S.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub rows: [u32; 2],
    /// Its products in [`Pattern::pairs`].
    pub pairs: Range<u32>,
}

/// Stored elements in the order of the storage, and their products.
#[derive(Clone, Debug)]
pub(super) struct Pattern {
    pub entries: Vec<Entry>,
    /// Slots whose weighted and plain coefficients are multiplied.
    pub pairs: Vec<(u32, u32)>,
    /// Slots of body b: `slots[starts[b]..starts[b + 1]]`.
    slots: Vec<u32>,
    starts: Vec<usize>,
}

/// One product: the element it belongs to (by `place`, which sorts into storage order) and its two slots.
struct Product {
    place: (u32, u32),
    slots: (u32, u32),
}

impl Pattern {
    /// All elements of the lower triangles of islands, row by row, also those that are zero: row `order[place]` stands at `place`, the
    /// islands end before the places `ends`.
    pub fn dense(bodies: usize, rows: &[RowBodies], order: &[u32], ends: &[usize]) -> Pattern {
        let mut position = vec![0; order.len()];
        for (place, row) in (0u32..).zip(order) {
            position[*row as usize] = place;
        }
        let starts = std::iter::once(0).chain(ends.iter().copied());
        let places = starts.zip(ends).flat_map(|(start, end)| (start as u32..*end as u32).map(move |row| (start as u32, row)));
        let all = places.flat_map(|(start, row)| (start..=row).map(move |column| (row, column)));
        Self::permuted(bodies, rows, all.collect(), &position, order)
    }

    /// Elements that are not zero, for a matrix whose row r stands at place `position[r]`: upper triangle, column by
    /// column. `order` is the inverse of `position`.
    pub fn sparse(bodies: usize, rows: &[RowBodies], position: &[u32], order: &[u32]) -> Pattern {
        Self::permuted(bodies, rows, Vec::new(), position, order)
    }

    /// `wanted` places (sorted) are kept even without products.
    fn permuted(bodies: usize, rows: &[RowBodies], wanted: Vec<(u32, u32)>, position: &[u32], order: &[u32]) -> Pattern {
        let place = |row: u32, column: u32| {
            let (a, b) = (position[row as usize], position[column as usize]);
            (a.max(b), a.min(b))
        };
        let (slots, starts) = slots(bodies, rows);
        let mut products = Vec::new();
        for body in 0..bodies {
            let own = &slots[starts[body]..starts[body + 1]];
            for &a in own {
                // Each unordered pair of rows once, the pairs within a row in both orders.
                for &b in own.iter().filter(|b| **b / 2 <= a / 2) {
                    products.push(Product { place: place(a / 2, b / 2), slots: (a, b) });
                }
            }
        }
        products.sort_by_key(|product| (product.place, product.slots));
        let places = if wanted.is_empty() {
            let mut found: Vec<_> = products.iter().map(|product| product.place).collect();
            found.dedup();
            found
        } else {
            wanted
        };
        let mut next = 0;
        let entries = places.into_iter().map(|place| {
            let start = next;
            while products.get(next).is_some_and(|product| product.place == place) {
                next += 1;
            }
            Entry { rows: [place.0, place.1].map(|place| order[place as usize]), pairs: start as u32..next as u32 }
        });
        let entries = entries.collect();
        Pattern { entries, pairs: products.iter().map(|product| product.slots).collect(), slots, starts }
    }

    pub fn slots_of(&self, body: usize) -> &[u32] {
        &self.slots[self.starts[body]..self.starts[body + 1]]
    }
}

/// Slots sorted by body, and where each body's begin.
fn slots(bodies: usize, rows: &[RowBodies]) -> (Vec<u32>, Vec<usize>) {
    let mut used: Vec<(usize, u32)> = Vec::with_capacity(2 * rows.len());
    for (row, touched) in (0u32..).zip(rows) {
        used.push((touched.first, 2 * row));
        used.extend(touched.second.map(|second| (second, 2 * row + 1)));
    }
    used.sort_unstable();
    let starts = (0..=bodies).map(|body| used.partition_point(|slot| slot.0 < body)).collect();
    (used.into_iter().map(|slot| slot.1).collect(), starts)
}
