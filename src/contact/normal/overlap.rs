//! Mean depth of the overlap of two bodies from their gap at a few places: `integral over t of (1 - G / L)^2 where G < L`, G(t) = the
//! largest gap g between 0 and t; and the same of 1 - G / L alone, which tells how the first one grows with L:
//!
//! ```text
//! I = integral of (1 - G/L)^2,   J = integral of (1 - G/L),   dI/dL = 2 (J - I) / L
//! ```
//!
//! Between two nodes g is the cubic that has its values and slopes at both, so the integrand is a polynomial of degree 6 or, where G is
//! more than g, a constant, and is integrated in closed form. With d = 1 - g/L, a and b its values and m and n its slopes (per width of
//! the interval) at the interval's ends,
//!
//! ```text
//! integral of d^2 = w / 420 (156 (a^2 + b^2) + 108 a b + 44 (a m - b n) + 26 (b m - a n) + 4 (m^2 + n^2) - 6 m n)
//! integral of d   = w / 12 (6 (a + b) + m - n)
//! ```
//!
//! At the place where the depth reaches zero the integrand has a double zero: an error e of that place is felt as e^3, and as e^2 at a
//! place where G leaves a plateau. So the sum is a C1 function of all nodal values.

use nalgebra::Vector2;

/// Integrals of d^2 and of d, m.
pub(super) type Depths = Vector2<f64>;

/// A cubic a + m s + c2 s^2 + c3 s^3, and the same by its values and slopes at s = 0 and 1.
#[derive(Clone, Copy, Debug)]
struct Cubic {
    ends: [f64; 2],
    slopes: [f64; 2],
    c2: f64,
    c3: f64,
}

/// Integrals of the square of a cubic and of itself over an interval of width 1 from its values and slopes at both ends.
#[inline(always)]
fn depths([a, b]: [f64; 2], [m, n]: [f64; 2]) -> Depths {
    let values = 156.0 * (a * a + b * b) + 108.0 * a * b;
    let slopes = 4.0 * (m * m + n * n) - 6.0 * m * n;
    let square = (values + slopes + m * (44.0 * a + 26.0 * b) - n * (44.0 * b + 26.0 * a)) * (1.0 / 420.0);
    Depths::new(square, 0.5 * (a + b) + (1.0 / 12.0) * (m - n))
}

/// The same of a constant.
#[inline(always)]
fn level_depths(depth: f64) -> Depths {
    Depths::new(depth * depth, depth)
}

/// Steps of Newton's method for a root between bounds, and the step after which it ends.
const ITERATIONS: usize = 50;
const SETTLED: f64 = 1e-3;

impl Cubic {
    #[inline(always)]
    fn new(ends: [f64; 2], slopes: [f64; 2]) -> Self {
        let ([a, b], [m, n]) = (ends, slopes);
        Cubic { ends, slopes, c2: 3.0 * (b - a) - 2.0 * m - n, c3: 2.0 * (a - b) + m + n }
    }

    #[inline(always)]
    fn value(&self, s: f64) -> f64 {
        self.ends[0] + s * (self.slopes[0] + s * (self.c2 + s * self.c3))
    }

    #[inline(always)]
    fn slope(&self, s: f64) -> f64 {
        self.slopes[0] + s * (2.0 * self.c2 + 3.0 * s * self.c3)
    }

    /// Integrals from `from` to `to`.
    #[inline(always)]
    fn depths(&self, from: f64, to: f64) -> Depths {
        let width = to - from;
        width * depths([self.value(from), self.value(to)], [width * self.slope(from), width * self.slope(to)])
    }

    /// Where the cubic, falling from more than `target` to less between two places, has that value.
    fn fall_to(&self, target: f64, mut from: f64, mut to: f64) -> f64 {
        let first = self.value(from) - target;
        let chord = from + (to - from) * first / (first + target - self.value(to));
        let inside = |s: f64, from: f64, to: f64| if s > from && s < to { s } else { 0.5 * (from + to) };
        let mut s = inside(chord, from, to);
        for _ in 0..ITERATIONS {
            let over = self.value(s) - target;
            *(if over > 0.0 { &mut from } else { &mut to }) = s;
            let next = s - over / self.slope(s);
            if (next - s).abs() <= SETTLED {
                return if next < from || next > to { s } else { next };
            }
            // NaN on a level place.
            s = inside(next, from, to);
        }
        s
    }

    /// Where the cubic, falling all the way, is zero: Newton's method from the parabola with the same ends and the first slope.
    #[inline(always)]
    fn fall_from_above(&self, a: f64, m: f64, b: f64) -> f64 {
        let root = (m * m - 4.0 * (b - a - m) * a).max(0.0).sqrt();
        let mut s = (2.0 * a / (root - m)).min(1.0);
        for _ in 0..ITERATIONS {
            let step = self.value(s) / self.slope(s);
            if !(step.abs() > SETTLED) {
                // 0 / 0 where the cubic only touches zero.
                return if step.is_nan() { s } else { s - step };
            }
            s = (s - step).clamp(0.0, 1.0);
        }
        s
    }

    /// Places between 0 and 1 where the cubic is level, increasing; the others are 1.
    fn level(&self) -> [f64; 2] {
        let (half, product) = (self.c2, 3.0 * self.c3 * self.slopes[0]);
        let discriminant = half * half - product;
        if !(discriminant > 0.0) {
            return [1.0; 2];
        }
        let sum = -half - discriminant.sqrt().copysign(half);
        let inside = |s: f64| if s > 0.0 && s < 1.0 { s } else { 1.0 };
        let (one, other) = (inside(sum / (3.0 * self.c3)), inside(self.slopes[0] / sum));
        [one.min(other), one.max(other)]
    }
}

/// The integrals up to a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Overlap {
    /// m.
    pub sum: Depths,
    /// 1 - G/L.
    pub depth: f64,
    /// 1 - g/L and its slope, 1/m, at the node.
    node: (f64, f64),
}

impl Overlap {
    /// At t = 0, where g and dg/dt are zero.
    #[inline]
    pub fn new() -> Self {
        Overlap { sum: Depths::zeros(), depth: 1.0, node: (1.0, 0.0) }
    }

    /// Adds the next interval of `width` [m]; at its end 1 - g/L and its slope are `node`. True as soon as the depth is used up.
    #[inline(always)]
    pub fn add(&mut self, width: f64, node: (f64, f64)) -> bool {
        let (ends, slopes) = ([self.node.0, node.0], [width * self.node.1, width * node.1]);
        self.node = node;
        let thrice = 3.0 * (ends[1] - ends[0]);
        // A cubic is monotone whose slopes at both ends lie between none and thrice the mean one.
        let falls = slopes[0] <= 0.0 && slopes[1] <= 0.0 && slopes[0] >= thrice && slopes[1] >= thrice;
        if !(falls && ends[0] <= self.depth) {
            return self.add_any(width, ends, slopes);
        }
        if ends[1] > 0.0 {
            self.sum += width * depths(ends, slopes);
            self.depth = ends[1];
            return false;
        }
        let cubic = Cubic::new(ends, slopes);
        let end = cubic.fall_from_above(ends[0], slopes[0], ends[1]);
        self.sum += width * cubic.depths(0.0, end);
        true
    }

    /// The same for gaps that do not grow all the way from G.
    #[inline(never)]
    fn add_any(&mut self, width: f64, ends: [f64; 2], slopes: [f64; 2]) -> bool {
        let ([a, b], [m, n], plateau) = (ends, slopes, self.depth);
        // A cubic stays above a line if its four control points do.
        if a >= plateau && b >= plateau && 3.0 * (a - plateau) + m >= 0.0 && 3.0 * (b - plateau) - n >= 0.0 {
            self.sum += width * level_depths(plateau);
            return false;
        }
        let cubic = Cubic::new(ends, slopes);
        let level = cubic.level();
        let mut from = 0.0;
        for to in [level[0], level[1], 1.0] {
            if !(to > from) {
                continue;
            }
            let last = if to == 1.0 { cubic.ends[1] } else { cubic.value(to) };
            if !(last < self.depth) {
                self.sum += width * (to - from) * level_depths(self.depth);
                from = to;
                continue;
            }
            if cubic.value(from) > self.depth {
                let start = cubic.fall_to(self.depth, from, to);
                self.sum += width * (start - from) * level_depths(self.depth);
                from = start;
            }
            if last <= 0.0 {
                let end = cubic.fall_to(0.0, from, to);
                self.sum += width * cubic.depths(from, end);
                return true;
            }
            self.sum += width * cubic.depths(from, to);
            (self.depth, from) = (last, to);
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The integrals of the piecewise cubic's (1 - G)^2 and 1 - G by 2000 points, L = 1, from gaps and slopes at nodes 1 m apart.
    fn by_points(nodes: &[(f64, f64)]) -> Depths {
        let (mut sum, mut largest) = (Depths::zeros(), 0.0f64);
        for pair in nodes.windows(2) {
            let cubic = Cubic::new([pair[0].0, pair[1].0], [pair[0].1, pair[1].1]);
            for i in 0..2_000 {
                largest = largest.max(cubic.value((f64::from(i) + 0.5) / 2_000.0));
                sum += level_depths(1.0 - largest.min(1.0)) / 2_000.0;
            }
        }
        sum
    }

    fn closed(nodes: &[(f64, f64)]) -> Depths {
        let mut overlap = Overlap::new();
        for &(gap, slope) in &nodes[1..] {
            if overlap.add(1.0, (1.0 - gap, -slope)) {
                break;
            }
        }
        overlap.sum
    }

    #[test]
    fn analytic_a_parabola_is_met_wherever_its_nodes_lie() {
        for end in [0.2, 0.9, 1.0, 1.7, 3.0] {
            let nodes: Vec<(f64, f64)> = (0..=4).map(f64::from).map(|t| (t * t / (end * end), 2.0 * t / (end * end))).collect();
            let depths = closed(&nodes);
            assert!((depths.x / (8.0 / 15.0 * end) - 1.0).abs() < 1e-12 && (depths.y / (2.0 / 3.0 * end) - 1.0).abs() < 1e-12, "{end}");
        }
    }

    #[test]
    fn analytic_ridges_valleys_and_plateaus_are_met() {
        // Gaps and slopes that rise, fall below zero, rise again; ridges inside an interval, and ends of all kinds.
        let mut worst = 0.0f64;
        for i in 0..4000u32 {
            let part = |k: u32| f64::from((i / 10u32.pow(k)) % 10) / 10.0;
            let random = |k: u32| (f64::from(i) * 12.9898 + f64::from(k) * 78.233).sin() * 0.9;
            let nodes = [
                (0.0, 0.0),
                (0.6 * part(0), random(1)),
                (random(2), random(3)),
                (0.9 * part(1), 2.0 * random(4)),
                (0.5 + part(2), 1.0),
                (2.0 + part(3), 1.5),
            ];
            let error = (closed(&nodes) - by_points(&nodes)).amax();
            assert!(error < 2e-5, "{nodes:?}: {} {}", closed(&nodes), by_points(&nodes));
            worst = worst.max(error);
        }
        println!("closed form and points differ by {worst:.1e}");
    }

    #[test]
    fn analytic_the_sum_is_smooth_where_a_ridge_passes_the_level() {
        let at = |height: f64| closed(&[(0.0, 0.0), (height, 0.0), (-0.2, 0.0), (3.0, 4.0)]).x;
        let slope = |x: f64| (at(x + 1e-6) - at(x - 1e-6)) / 2e-6;
        for height in [0.1, 0.3, 0.999, 1.0, 1.001] {
            let (left, right) = (slope(height - 4e-6), slope(height + 4e-6));
            assert!((left - right).abs() < 1e-3, "{height}: {left} {right}");
        }
    }
}
