//! Where the overlap is deepest between nodes.
//!
//! A contact that lies at a node jumps by a spacing when the next node becomes the deepest, its normal by the spacing times the curvature (0.1 mm in a corner of
//! 13 mm: 8 mrad, 0.5 kN of lateral force), its stiffness by what the curvatures change by. Where profiles are nearly conformal (S1002's flange on 60E1's
//! gauge corner) even a parabola through three nodes jumps by a spacing or two, where a radius of one of the profiles begins: 160 kN on a flange then change by
//! 9 kN. So places are roots of the depth's slope on the profiles themselves. In the rail's section, with the wheel's curve (eta, h)(u) and the
//! foot (x, f(x)) of its normal,
//!
//! ```text
//! (eta - x) + f'(x) (h - f(x)) = 0           delta = -(h - f - f' (eta - x)) / N
//! N d delta / du = f' d eta / du - dh / du = 0
//! ```
//!
//! (the foot moves along the rail, so its motion does not count; N changes by a part of the lean's square, which is left out).
//!
//! A top among nodes is flat where its neighbours are as deep as it is to what nodes can tell. All roots within it are looked for: the places, and
//! the saddles between them.

use super::plane::Section;
use super::walk::{LEAST_HUMP, Walk};
use super::{MOST, NodalSearch, NodePair};
use crate::contact::search::humps::Humps;
use crate::math::bracket::root;

/// Of the place on the wheel, m.
const ACCURACY: f64 = 1e-11;
/// Nodes to each side of a top that are looked at, at least and at most.
const LEAST_NODES: usize = 4;
const MOST_NODES: usize = 40;
/// Newton's steps to the foot, each of which squares what is left but for the third derivative times the depth; the last is shorter than this, m.
const STEPS: usize = 6;
const FOOT: f64 = 1e-12;
/// Usual evaluations for a root.
const ROUNDS: usize = 7;

/// A place of the wheel's curve over its foot.
#[derive(Clone, Copy)]
struct Over {
    /// Of the place and of its foot, m.
    u: f64,
    eta: f64,
    /// m.
    depth: f64,
    /// N d delta / du, -.
    rise: f64,
}

/// u and eta of a contact, m, and the penetration there, m.
pub(super) type Place = [f64; 3];

/// Contacts, the outer one first, and the penetrations at the saddles between neighbours, m, 0 where they are apart.
#[derive(Default)]
pub(super) struct Row {
    pub places: [Option<Place>; MOST],
    pub saddles: [f64; MOST - 1],
    /// Places of the profiles that were looked at.
    pub looked_at: usize,
}

impl NodalSearch {
    /// At most `most` contacts that a walk has met; where nothing touches the pair that comes closest.
    pub(super) fn row(&self, walk: &Walk, plane: &Section, most: usize) -> Row {
        let mut exact = Humps::default();
        let (mut last, mut looked_at) = (f64::NEG_INFINITY, 0);
        for (k, (penetration, (wheel, rail))) in walk.humps.iter().enumerate() {
            if let Some(saddle) = k.checked_sub(1).map(|before| walk.humps.saddles()[before]) {
                // Nodes tell saddles only roughly.
                if saddle > 0.0 { exact.valley(saddle) } else { exact.part() }
            }
            let pair = NodePair { wheel, rail, penetration };
            looked_at += self.top(&pair, plane, |own, is_place| {
                if own.u <= last {
                    return;
                }
                if is_place {
                    exact.pass(own.depth, [own.u, own.eta])
                } else {
                    exact.valley(own.depth)
                }
                last = own.u;
            });
        }
        exact.settle(most.min(MOST), 0.0);
        let mut row = Row { looked_at, ..Row::default() };
        for (place, (depth, [u, eta])) in row.places.iter_mut().zip(exact.iter().rev()) {
            *place = Some([u, eta, depth]);
        }
        for (own, saddle) in row.saddles.iter_mut().zip(exact.saddles().iter().rev()) {
            *own = saddle.max(0.0);
        }
        if row.places[0].is_none() {
            row.places[0] = walk.closest.map(|pair| [self.wheel.coordinate(pair.wheel), self.rail.coordinate(pair.rail), pair.penetration]);
        }
        row
    }

    /// Tells the places (`true`) and the saddles between them about the deepest node of a hump, in their order. The node itself where it is the
    /// last one that has a partner. Returns how many places were looked at.
    fn top(&self, pair: &NodePair, plane: &Section, mut tell: impl FnMut(&Over, bool)) -> usize {
        let (u, eta) = (self.wheel.coordinate(pair.wheel), self.rail.coordinate(pair.rail));
        let node = Over { u, eta, depth: pair.penetration, rise: 0.0 };
        let Some(own) = self.over(plane, u, eta) else {
            tell(&node, true);
            return 1;
        };
        let mut looked_at = 1;
        let (first, last) = self.profiles[0].range();
        let flat = own.depth * (1.0 - LEAST_HUMP);
        // Nodes of the top in their order, its own in the middle; on both sides the depth falls where they end.
        let mut seen: [Option<Over>; 2 * MOST_NODES + 1] = [None; 2 * MOST_NODES + 1];
        seen[MOST_NODES] = Some(own);
        let mut ends = [MOST_NODES; 2];
        for (side, end) in [-1isize, 1].into_iter().zip(&mut ends) {
            let mut before = own;
            for k in 1..=MOST_NODES {
                let next = u + (side * k as isize) as f64 * self.wheel.spacing;
                let over = |next: f64| self.over(plane, next, before.eta);
                let Some(next) = Some(next).filter(|next| (first..=last).contains(next)).and_then(over) else { break };
                *end = MOST_NODES.wrapping_add_signed(side * k as isize);
                (seen[*end], before) = (Some(next), next);
                looked_at += 1;
                if next.depth < flat && (k >= LEAST_NODES || side as f64 * next.rise < 0.0) {
                    break;
                }
            }
        }
        let mut told = false;
        for k in ends[0]..ends[1] {
            let (Some(before), Some(here)) = (seen[k], seen[k + 1]) else { continue };
            if (before.rise > 0.0) != (here.rise > 0.0) {
                let over = |u: f64| self.over(plane, u, before.eta);
                let u = root((before.u, before.rise), (here.u, here.rise), ACCURACY, |u| over(u).map_or(f64::NAN, |over| over.rise));
                looked_at += ROUNDS;
                if let Some(found) = over(u) {
                    let is_place = before.rise > 0.0;
                    // A saddle parts two places.
                    if is_place || told {
                        tell(&found, is_place);
                    }
                    told |= is_place;
                }
            }
        }
        if !told {
            tell(&node, true);
        }
        looked_at
    }

    /// The wheel's curve at `u` over its foot, which is sought from `eta` [m] on; `None` where no point of its circle has its normal in the section.
    fn over(&self, plane: &Section, u: f64, eta: f64) -> Option<Over> {
        let wheel = self.profiles[0].at(u);
        let (across, height) = plane.place(u, wheel.value, wheel.d1)?;
        let mut x = eta;
        let mut rail = self.profiles[1].at(x);
        for _ in 0..STEPS {
            let (aside, above) = (across - x, height - rail.value);
            let step = (aside + rail.d1 * above) / (1.0 + rail.d1 * rail.d1 - rail.d2 * above);
            x += step;
            rail = self.profiles[1].at(x);
            if step.abs() < FOOT {
                break;
            }
        }
        let (by_across, by_height) = plane.moves(&wheel);
        let norm = plane.norm2(rail.d1).sqrt();
        let gap = height - rail.value - rail.d1 * (across - x);
        let found = Over { u, eta: x, depth: -gap / norm, rise: rail.d1 * by_across - by_height };
        (found.depth.is_finite() && found.rise.is_finite()).then_some(found)
    }
}
