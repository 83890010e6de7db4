//! Equally spaced nodes of a profile, with bounds by which a search passes over nodes that cannot touch.
//!
//! Node k stands at the coordinate `k * spacing` (k any whole number, so there is a node at 0 wherever the profile
//! covers it) and carries the profile's value and derivatives. The bounds belong to nodes, not to the curve between
//! them: slopes are differences of neighbouring nodes divided by the spacing, so a kink or a steep end between two
//! nodes is covered too. They are stored for stretches of 8, 16, 32 ... intervals.

use crate::geometry::profile::{Profile, ProfilePoint};

/// Why a profile gives no usable nodes.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NodeError {
    #[error("the spacing of nodes is {spacing} m; expected a number above 0")]
    Spacing { spacing: f64 },
    #[error(
        "the {part} profile (from {first:.4} m to {last:.4} m) gets {nodes} nodes at a spacing of {spacing} m; \
         expected {FEWEST} to {MOST}: choose another spacing"
    )]
    Count { part: &'static str, nodes: f64, spacing: f64, first: f64, last: f64 },
    #[error("the {part} profile is not finite at the node {coordinate} m; nodes need a value and two derivatives")]
    NotFinite { part: &'static str, coordinate: f64 },
}

/// With fewer nodes there is nothing to search; with more, the spacing was meant in another unit.
const FEWEST: usize = 5;
const MOST: usize = 1_000_000;

/// The shortest stretch that has bounds of its own has `2^SHORTEST` intervals.
const SHORTEST: usize = 3;

/// Bounds over a stretch of intervals and the nodes at their ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// Least and greatest slope from a node to the next, -.
    pub lowest: f64,
    pub highest: f64,
    /// Greatest |d1| of a node, -.
    pub steepest: f64,
    /// Greatest change of `value * d1` from a node to the next per spacing, m.
    pub bend: f64,
    /// Greatest distance, m, in height between a node's tangent and the line through neighbouring nodes, up to half a
    /// spacing from the node.
    pub misfit: f64,
}

impl Bounds {
    fn merge(self, other: Bounds) -> Bounds {
        Bounds {
            lowest: self.lowest.min(other.lowest),
            highest: self.highest.max(other.highest),
            steepest: self.steepest.max(other.steepest),
            bend: self.bend.max(other.bend),
            misfit: self.misfit.max(other.misfit),
        }
    }
}

/// The nodes of one profile.
#[derive(Clone, Debug)]
pub struct NodeTable {
    /// m.
    pub spacing: f64,
    per_spacing: f64,
    /// Coordinate of the first node in spacings.
    first: f64,
    points: Vec<ProfilePoint>,
    /// `levels[n]` bounds stretches of `2^(SHORTEST + n)` intervals, one after the other.
    levels: Vec<Vec<Bounds>>,
}

impl NodeTable {
    /// Nodes at multiples of `spacing` [m] inside the profile's range. A node at an end where the profile is not finite
    /// (a vertical tangent) is left out. `part` names the profile in messages.
    ///
    /// # Errors
    /// [`NodeError`] when the spacing leaves too few or too many nodes, or the profile is not finite between its ends.
    pub fn new(profile: &dyn Profile, part: &'static str, spacing: f64) -> Result<Self, NodeError> {
        if !(spacing > 0.0 && spacing.is_finite()) {
            return Err(NodeError::Spacing { spacing });
        }
        let (from, to) = profile.range();
        let (mut first, mut last) = ((from / spacing).ceil(), (to / spacing).floor());
        // The quotient is rounded; the node itself must lie inside.
        first += f64::from(first * spacing < from);
        last -= f64::from(last * spacing > to);
        let count = |first: f64, last: f64| {
            let nodes = last - first + 1.0;
            let fits = nodes >= FEWEST as f64 && nodes <= MOST as f64;
            if fits { Ok(nodes as usize) } else { Err(NodeError::Count { part, nodes: nodes.max(0.0), spacing, first: from, last: to }) }
        };
        count(first, last)?;
        let finite = |k: f64| {
            let p = profile.at(k * spacing);
            p.value.is_finite() && p.d1.is_finite() && p.d2.is_finite()
        };
        first += f64::from(!finite(first));
        last -= f64::from(!finite(last));
        let nodes = count(first, last)?;
        let mut points = Vec::with_capacity(nodes);
        for k in 0..nodes {
            let k = first + k as f64;
            if !finite(k) {
                return Err(NodeError::NotFinite { part, coordinate: k * spacing });
            }
            points.push(profile.at(k * spacing));
        }
        let levels = levels(&points, spacing);
        Ok(NodeTable { spacing, per_spacing: 1.0 / spacing, first, points, levels })
    }

    /// Number of nodes.
    #[inline]
    pub fn count(&self) -> usize {
        self.points.len()
    }

    /// Coordinate of a node, m.
    #[inline]
    pub fn coordinate(&self, index: usize) -> f64 {
        (self.first + index as f64) * self.spacing
    }

    /// Value and derivatives at a node.
    #[inline]
    pub fn point(&self, index: usize) -> &ProfilePoint {
        &self.points[index]
    }

    /// Place of the coordinate `x` [m] among the nodes: 0 at the first node, 1 at the second, ...
    #[inline]
    pub(super) fn place(&self, x: f64) -> f64 {
        x * self.per_spacing - self.first
    }

    /// Node nearest to a place among the nodes.
    #[inline]
    pub(super) fn nearest(&self, place: f64) -> usize {
        // A cast of a negative number gives 0.
        ((place + 0.5) as usize).min(self.points.len() - 1)
    }

    /// Highest level of `bounds`: its stretch covers the table.
    #[inline]
    pub(super) fn top(&self) -> usize {
        self.levels.len() - 1
    }

    /// Intervals in a stretch of `level`.
    #[inline]
    pub(super) fn stretch(level: usize) -> usize {
        1 << (SHORTEST + level)
    }

    /// Bounds that hold at least from interval `from` through interval `to` (interval k joins the nodes k and k + 1);
    /// places outside the table count as its outermost intervals. Put together from stretches of `level` or longer.
    #[inline]
    pub(super) fn bounds(&self, from: f64, to: f64, level: usize) -> Bounds {
        let stretches = &self.levels[level.min(self.top())];
        // A cast of a negative number gives 0.
        let at = |interval: f64| (interval as usize >> (SHORTEST + level)).min(stretches.len() - 1);
        let (begin, end) = (at(from), at(to));
        stretches[begin + 1..=end.max(begin)].iter().fold(stretches[begin], |bounds, &next| bounds.merge(next))
    }
}

/// Bounds of all stretches from the shortest to one that covers everything.
fn levels(points: &[ProfilePoint], spacing: f64) -> Vec<Vec<Bounds>> {
    let intervals: Vec<Bounds> = points
        .windows(2)
        .map(|pair| {
            let slope = (pair[1].value - pair[0].value) / spacing;
            Bounds {
                lowest: slope,
                highest: slope,
                steepest: pair[0].d1.abs().max(pair[1].d1.abs()),
                bend: (pair[1].value * pair[1].d1 - pair[0].value * pair[0].d1).abs() / spacing,
                misfit: 0.5 * spacing * (pair[0].d1 - slope).abs().max((pair[1].d1 - slope).abs()),
            }
        })
        .collect();
    let join = |parts: &[Bounds]| parts[1..].iter().fold(parts[0], |bounds, &next| bounds.merge(next));
    let mut levels = vec![intervals.chunks(NodeTable::stretch(0)).map(join).collect::<Vec<_>>()];
    while levels[levels.len() - 1].len() > 1 {
        let coarser = levels[levels.len() - 1].chunks(2).map(join).collect();
        levels.push(coarser);
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half a circle: vertical tangents at both ends.
    #[derive(Debug)]
    struct HalfCircle(f64);
    impl Profile for HalfCircle {
        fn at(&self, x: f64) -> ProfilePoint {
            let root = (self.0 * self.0 - x * x).sqrt();
            ProfilePoint { value: root, d1: -x / root, d2: -self.0 * self.0 / root.powi(3), d3: 0.0 }
        }
        fn range(&self) -> (f64, f64) {
            (-self.0, self.0)
        }
        fn describe(&self) -> String {
            "half circle".into()
        }
    }

    #[derive(Debug)]
    struct Wavy(f64, f64);
    impl Profile for Wavy {
        fn at(&self, x: f64) -> ProfilePoint {
            let (sin, cos) = (900.0 * x).sin_cos();
            ProfilePoint { value: 0.4 + 1e-3 * sin, d1: 0.9 * cos, d2: -810.0 * sin, d3: 0.0 }
        }
        fn range(&self) -> (f64, f64) {
            (self.0, self.1)
        }
        fn describe(&self) -> String {
            "wave".into()
        }
    }

    #[test]
    fn prop_nodes_stand_at_multiples_of_the_spacing_inside_the_range() {
        for (from, to, spacing) in [(-0.0503, 0.0401, 1e-4), (-0.05, 0.05, 1e-4), (0.011, 0.3, 7e-4), (-0.03, 0.0, 0.3e-3)] {
            let table = NodeTable::new(&Wavy(from, to), "wheel", spacing).unwrap();
            let last = table.coordinate(table.count() - 1);
            assert!(table.coordinate(0) >= from && table.coordinate(0) < from + 1.001 * spacing, "{from}");
            assert!(last <= to && last > to - 1.001 * spacing, "{to}");
            for index in 0..table.count() {
                let x = table.coordinate(index);
                assert_eq!(x, (x / spacing).round() * spacing);
                assert!((table.place(x) - index as f64).abs() < 1e-9);
                assert_eq!(*table.point(index), Wavy(from, to).at(x));
            }
            let anchor = table.place(0.0).round();
            assert!(anchor < 0.0 || table.coordinate(anchor as usize) == 0.0);
        }
    }

    #[test]
    fn prop_bounds_hold_for_every_node_of_their_stretch() {
        let table = NodeTable::new(&Wavy(-0.0201, 0.0303), "wheel", 1e-4).unwrap();
        let last = table.count() - 2;
        let mut widths = Vec::new();
        for level in 0..=table.top() + 1 {
            for from in (0..=last).step_by(7) {
                let to = from + NodeTable::stretch(level) - 1;
                let bounds = table.bounds(from as f64 + 0.3, to as f64 + 0.9, level);
                widths.push(bounds.highest - bounds.lowest);
                for i in from..=to.min(last) {
                    let (a, b) = (table.point(i), table.point(i + 1));
                    let slope = (b.value - a.value) / table.spacing;
                    assert!(bounds.lowest <= slope && slope <= bounds.highest);
                    assert!(bounds.steepest >= a.d1.abs() && bounds.steepest >= b.d1.abs());
                    assert!(bounds.bend >= (b.value * b.d1 - a.value * a.d1).abs() / table.spacing);
                    // The tangent at the nearer node against the line between both, at its worst half way.
                    let middle = 0.5 * (a.value + b.value);
                    let half = 0.5 * table.spacing;
                    assert!(bounds.misfit >= (a.value + a.d1 * half - middle).abs() - 1e-15);
                    assert!(bounds.misfit >= (b.value - b.d1 * half - middle).abs() - 1e-15);
                }
            }
        }
        // Short stretches have narrower bounds, or they would be of no use.
        assert!(widths[0] < 0.5 * widths[widths.len() - 1]);
        let outside = table.bounds(-30.0, -20.0, 0);
        assert_eq!(outside.lowest, table.bounds(0.0, 0.0, 0).lowest);
    }

    #[test]
    fn hard_vertical_ends_are_left_out_and_useless_spacings_refused() {
        let table = NodeTable::new(&HalfCircle(0.013), "rail", 1e-3).unwrap();
        assert_eq!((table.count(), table.coordinate(0), table.coordinate(24)), (25, -0.012, 0.012));
        assert!(table.bounds(0.0, 24.0, 5).steepest.is_finite());

        let message = |spacing| NodeTable::new(&HalfCircle(0.013), "rail", spacing).unwrap_err().to_string();
        assert!(message(0.01).starts_with("the rail profile (from -0.0130 m to 0.0130 m) gets 3 nodes at a spacing of 0.01 m; expected 5"));
        assert!(message(1e-9).contains("expected 5 to 1000000"));
        assert!(message(0.0).contains("above 0") && message(f64::NAN).contains("above 0") && message(-1e-4).contains("above 0"));

        #[derive(Debug)]
        struct Broken;
        impl Profile for Broken {
            fn at(&self, x: f64) -> ProfilePoint {
                ProfilePoint { d1: if x == 0.0 { f64::INFINITY } else { 0.0 }, ..ProfilePoint::default() }
            }
            fn range(&self) -> (f64, f64) {
                (-0.01, 0.01)
            }
            fn describe(&self) -> String {
                "broken".into()
            }
        }
        assert_eq!(NodeTable::new(&Broken, "rail", 1e-3).unwrap_err(), NodeError::NotFinite { part: "rail", coordinate: 0.0 });
    }
}
