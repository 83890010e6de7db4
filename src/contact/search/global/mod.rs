//! All places where one wheel and one rail come near each other, from the pose alone.
//!
//! The four equations of [`super::algebraic`] hold at every stationary distance: minima (tread, flange root, flange), the
//! ridges between them, and whatever lies near the start of the iteration. Here the wheel is seen along the rail as a plane
//! curve (`view`), its signed distance d(u) from the rail's section (negative where the surfaces overlap) is bounded over
//! stretches of both profiles (`curve`, `foot`), and branch and bound (`branch`) leaves brackets of all minima below a
//! reach, which Newton then makes exact (`refine`). On a straight rail they solve the four equations; on one that bends they
//! start [`GlobalSearch::polish`].
//!
//! *Limits.* A rail is its profile continued straight beyond its ends; minima there, and those at the ends of the wheel's
//! profile, are reported `at_edge`. Flanks steeper than 12 (85 degrees) of a wheel and 25 of a rail are left out. The foot of a point
//! on a hollow rail is the one that is found by walking along the rail, so the hollow's radius must exceed the gap.

mod along;
mod branch;
mod curve;
mod foot;
mod joint;
mod look;
mod motion;
mod polish;
mod refine;
mod standing;
#[cfg(test)]
mod tests;
mod view;
mod watch;

pub use polish::{Polished, bending_ahead, is_least};
pub use refine::Kink;
pub use standing::WheelPose;

use super::algebraic::{Pair, SurfaceParameters};
use crate::geometry::profile::Profile;
use branch::Scan;
use curve::{Bounds, Curve};
use foot::RailCurve;
use refine::Spot;
use view::View;
pub use watch::{Extreme, POINTS, Point, Watch};

/// Most minima of one wheel that are returned.
pub const MOST: usize = 8;

/// How often the reach is lowered where minima are many.
const ROUNDS: usize = 24;

/// Greatest slope at which a wheel is looked at.
const STEEPEST_WHEEL_SEEN: f64 = 12.0;

/// A greatest distance between two minima.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ridge {
    pub parameters: SurfaceParameters,
    /// m.
    pub distance: f64,
}

/// A least distance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Minimum {
    /// Solves the four equations on a straight rail, starts [`GlobalSearch::polish`] on any.
    pub parameters: SurfaceParameters,
    /// Signed distance of the surfaces, m; negative where they overlap.
    pub distance: f64,
    /// Wheel coordinates [m] within which the distance falls to this minimum and is below the reach: from ridge to ridge, or
    /// to a place at or a little beyond that where the reach is passed.
    pub basin: (f64, f64),
    /// Is the contact at a kink? The wheel's vertex then stands on the rail's smooth surface or the other way round.
    pub kink: Kink,
    /// R' at the contact; differs from that of the profile only at a kink of the wheel.
    pub slope: f64,
    /// Off the rail's profile or at an end of the wheel's.
    pub at_edge: bool,
    /// The ridge before the next minimum; `None` where the distance passes the reach in between.
    pub ridge_to_next: Option<Ridge>,
}

/// What [`GlobalSearch::find`] found.
#[derive(Clone, Copy, Debug)]
pub struct Minima {
    list: [Minimum; MOST],
    count: usize,
    /// Every minimum that is not in the list has at least this distance, m (infinite when there is none at all).
    pub clearance: f64,
    /// The list keeps its length, but for minima that pass the reach, as long as no point of the wheel moves by more than
    /// this relative to the rail, m, and the wheel turns by no more than this over half a metre (at most 1 mm; 0 when
    /// `delicate`).
    pub steady: f64,
    /// What `watch` leaves out keeps its minima while the wheel moves by no more than this, m; 0 when the watch is of no use.
    pub apart: f64,
    /// Where the list may change sooner.
    pub watch: Watch,
    /// There is a stretch of wheel nearer than the reach where the relative curvature is not certified: minimum and ridge
    /// may be born or merge by a small motion.
    pub delicate: bool,
}

impl Default for Minima {
    fn default() -> Self {
        Minima {
            list: [Minimum::default(); MOST],
            count: 0,
            clearance: f64::INFINITY,
            steady: 0.0,
            apart: 0.0,
            watch: Watch::default(),
            delicate: false,
        }
    }
}

impl std::ops::Deref for Minima {
    type Target = [Minimum];
    /// Minima by growing u (from the flange outward).
    fn deref(&self) -> &[Minimum] {
        &self.list[..self.count]
    }
}

impl Minima {
    /// The least of all.
    pub fn deepest(&self) -> Option<&Minimum> {
        self.iter().min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// Adds one; when there is no room the shallowest goes, and the ridges beside it with it.
    fn push(&mut self, minimum: Minimum) {
        if self.count == MOST {
            let shallowest = (0..MOST).max_by(|a, b| self.list[*a].distance.total_cmp(&self.list[*b].distance)).unwrap_or(0);
            if self.list[shallowest].distance <= minimum.distance {
                self.clearance = self.clearance.min(minimum.distance);
                return;
            }
            self.clearance = self.clearance.min(self.list[shallowest].distance);
            self.list.copy_within(shallowest + 1.., shallowest);
            self.count -= 1;
        }
        self.list[self.count] = minimum;
        self.count += 1;
    }
}

/// What the search knows of one pair of profiles; the pose comes with each call.
#[derive(Clone, Debug)]
pub struct GlobalSearch {
    wheel: Curve,
    /// Bounds over 1, 2, 4 ... stretches: block i has the halves 2 i and 2 i + 1, the first block is 1.
    tree: Vec<Bounds>,
    /// Stretches under the first block, a power of 2.
    leaves: usize,
    /// Blocks above this size are hardly ever decided.
    coarse: usize,
    rail: RailCurve,
    /// Coordinates at which the wheel's own curvature jumps, m.
    joints: Vec<f64>,
    /// R0, m.
    radius: f64,
}

impl GlobalSearch {
    pub fn new(wheel: &dyn Profile, rail: &dyn Profile) -> Self {
        let radius = wheel.at(0.0).value;
        let wheel = Curve::new(wheel, -1.0, STEEPEST_WHEEL_SEEN);
        let leaves = wheel.stretches.len().next_power_of_two();
        let mut tree = vec![Bounds::NONE; 2 * leaves];
        tree[leaves..leaves + wheel.stretches.len()].copy_from_slice(&wheel.stretches);
        for i in (1..leaves).rev() {
            tree[i] = tree[2 * i].merge(&tree[2 * i + 1]);
        }
        let rail = RailCurve::new(rail);
        let joints = wheel.joints().map(|knot| wheel.knots[knot].x).collect();
        let mut search = GlobalSearch { joints, wheel, tree, leaves, coarse: leaves, rail, radius };
        if !search.strictly_convex() {
            search.coarse = (leaves / 8).max(1);
        }
        search
    }

    /// Radius of the tread circle, m.
    #[inline]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// All minima with a distance below `reach` [m], by growing u; of more than [`MOST`] the deepest.
    pub fn find(&self, pair: &Pair, reach: f64, found: &mut Minima) {
        self.find_from(pair, View::new(pair, None), reach, found);
    }

    fn find_from(&self, pair: &Pair, view: View, reach: f64, found: &mut Minima) {
        let mut brackets = [None; branch::MOST];
        let scan = Scan::run(self, pair, view, reach, &mut brackets);
        if scan.overflow {
            return self.find_in_a_crowd(pair, view, reach, found);
        }
        self.refine(pair, &scan, found);
    }

    /// Of a crowd of minima, as noisy points have them, the deepest ones. (This takes memory, and a hundred times as long.)
    #[cold]
    fn find_in_a_crowd(&self, pair: &Pair, view: View, mut reach: f64, found: &mut Minima) {
        let mut brackets = vec![None; branch::CROWD];
        for round in 0..ROUNDS {
            brackets.fill(None);
            let scan = Scan::run(self, pair, view, reach, &mut brackets);
            match scan.crowded().filter(|_| round + 1 < ROUNDS) {
                Some(lower) => reach = lower,
                None => {
                    self.refine(pair, &scan, found);
                    break;
                }
            }
        }
        found.clearance = found.clearance.min(reach);
    }

    fn refine(&self, pair: &Pair, scan: &Scan, found: &mut Minima) {
        let reach = scan.reach;
        found.count = 0;
        found.clearance = scan.clearance;
        found.steady = scan.certificates.steady;
        let mut whole = true;
        let mut ridge: Option<Ridge> = None;
        // Where the basins of neighbours part: at a ridge, also one that is hidden or above the reach.
        let mut parting: Option<f64> = None;
        for i in 0..scan.count {
            let Some(bracket) = scan.bracket(i) else { continue };
            let spot = scan.refine(bracket);
            if !bracket.minimum {
                parting = Some(spot.map_or(bracket.a.u, |spot| spot.u));
            }
            let Some(spot) = spot else {
                (found.steady, whole) = (0.0, false);
                continue;
            };
            let near = spot.distance < reach;
            if !bracket.minimum {
                let at = |spot: Spot| scan.view.parameters(pair, spot.u, spot.slope, spot.eta);
                ridge = near.then(|| Ridge { parameters: at(spot), distance: spot.distance });
            }
            if !near && bracket.minimum {
                found.clearance = found.clearance.min(spot.distance);
            }
            if !near || !bracket.minimum {
                continue;
            }
            let Spot { distance, kink, slope, edge, .. } = spot;
            let parameters = scan.view.parameters(pair, spot.u, slope, spot.eta);
            let mut basin = bracket.basin;
            if let Some(before) = found.count.checked_sub(1).map(|i| &mut found.list[i])
                && before.basin.1 > basin.0
            {
                // No place above the reach in between.
                let edge = parting.unwrap_or(0.5 * (before.parameters.wheel + spot.u));
                (before.basin.1, basin.0, before.ridge_to_next) = (edge, edge, ridge);
            }
            (ridge, parting) = (None, None);
            found.push(Minimum { parameters, distance, basin, kink, slope, at_edge: edge, ridge_to_next: None });
        }
        (found.watch, found.apart) = scan.certificates.split();
        if found.watch.stretches != 0
            && let Some(contact) = found.first()
        {
            match self.look(pair, &found.watch, &contact.parameters) {
                Some((signature, _)) => found.watch.signature = signature,
                None => found.apart = 0.0,
            }
        }
        if !whole {
            found.apart = 0.0;
        }
        found.delicate = found.steady == 0.0;
    }

    /// Can only one minimum exist, wherever the wheel stands? True when the relative curvature is positive for all stretches of
    /// both smooth profiles that can face each other: tilted by up to 0.15 rad (roll and inclination), yawed by up to 50 mrad, up to
    /// 5 mm apart or deep.
    pub fn strictly_convex(&self) -> bool {
        const TILT: f64 = 0.15;
        const YAW: f64 = 0.05;
        const GAP: f64 = 5e-3;
        let kinked = |curve: &Curve| curve.stretches.iter().any(|b| b.length == 0.0);
        if kinked(&self.wheel) || kinked(&self.rail.curve) {
            return false;
        }
        self.wheel.stretches.iter().all(|wheel| {
            let own = branch::trace_curvature(wheel, YAW * YAW).0;
            self.rail.curve.stretches.iter().all(|rail| {
                let facing = wheel.angle.0 - TILT < rail.angle.1 && wheel.angle.1 + TILT > rail.angle.0;
                let curvature = rail.curvature.1;
                !facing || (curvature * GAP < 0.9 && own > curvature / (1.0 - curvature * GAP))
            })
        })
    }
}
