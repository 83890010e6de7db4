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
const REACH: [usize; 2] = [4, 40];
/// Newton's steps to the foot; each squares what is left but for the third derivative times the depth.
const STEPS: usize = 4;

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
}

impl NodalSearch {
    /// At most `most` contacts that a walk has met; where nothing touches the pair that comes closest.
    pub(super) fn row(&self, walk: &Walk, plane: &Section, most: usize) -> Row {
        let mut exact = Humps::default();
        let mut last = f64::NEG_INFINITY;
        for (k, (penetration, (wheel, rail))) in walk.humps.iter().enumerate() {
            if let Some(saddle) = k.checked_sub(1).map(|before| walk.humps.saddles()[before]) {
                // Nodes tell saddles only roughly.
                if saddle > 0.0 { exact.valley(saddle) } else { exact.part() }
            }
            let pair = NodePair { wheel, rail, penetration };
            self.top(&pair, plane, |own, is_place| {
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
        let mut row = Row::default();
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
    /// last one that has a partner.
    fn top(&self, pair: &NodePair, plane: &Section, mut tell: impl FnMut(&Over, bool)) {
        let (u, eta) = (self.wheel.coordinate(pair.wheel), self.rail.coordinate(pair.rail));
        let node = Over { u, eta, depth: pair.penetration, rise: 0.0 };
        let Some(own) = self.over(plane, u, eta) else { return tell(&node, true) };
        let (first, last) = self.profiles[0].range();
        let flat = own.depth * (1.0 - LEAST_HUMP);
        let at = |k: isize| {
            let u = u + k as f64 * self.wheel.spacing;
            self.over(plane, u, own.eta).filter(|_| (first..=last).contains(&u))
        };
        // The nodes at which the top ends: beyond, the depth falls.
        let end = |side: isize| {
            let mut k = 0;
            while let Some(next) = at(side * (k + 1)).filter(|_| k < REACH[1] as isize) {
                k += 1;
                if next.depth < flat && (k >= REACH[0] as isize || side as f64 * next.rise < 0.0) {
                    break;
                }
            }
            side * k
        };
        let (begin, end) = (end(-1), end(1));
        let mut before: Option<Over> = None;
        let mut told = false;
        for k in begin..=end {
            let Some(here) = at(k) else { continue };
            if let Some(before) = before.replace(here)
                && (before.rise > 0.0) != (here.rise > 0.0)
            {
                let rise = |u: f64| self.over(plane, u, own.eta).map_or(f64::NAN, |over| over.rise);
                let u = root((before.u, before.rise), (here.u, here.rise), ACCURACY, rise);
                if let Some(found) = self.over(plane, u, own.eta) {
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
    }

    /// The wheel's curve at `u` over its foot, which is sought from `eta` [m] on; `None` where no point of its circle has its normal in the section.
    fn over(&self, plane: &Section, u: f64, eta: f64) -> Option<Over> {
        let wheel = self.profiles[0].at(u);
        let (across, height) = plane.place(u, wheel.value, wheel.d1)?;
        let mut x = eta;
        let mut rail = self.profiles[1].at(x);
        for _ in 0..STEPS {
            let (aside, above) = (across - x, height - rail.value);
            x += (aside + rail.d1 * above) / (1.0 + rail.d1 * rail.d1 - rail.d2 * above);
            rail = self.profiles[1].at(x);
        }
        let (by_across, by_height) = plane.moves(&wheel);
        let norm = plane.norm2(rail.d1).sqrt();
        let gap = height - rail.value - rail.d1 * (across - x);
        let found = Over { u, eta: x, depth: -gap / norm, rise: rail.d1 * by_across - by_height };
        (found.depth.is_finite() && found.rise.is_finite()).then_some(found)
    }
}
