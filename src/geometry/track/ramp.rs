//! What a node table says between its nodes: linear there, constant outside, corners rounded over a length.
//!
//! Rounding is the mean over a window, `f(s) = integral of f0(s + h x) w(x) dx` with `w = 15/16 (1 - x^2)^2` on -1 .. 1: C3, and
//! the same integral as before. A corner at c where the slope changes by m becomes `m h r((s - c) / h)`,
//!
//! ```text
//! r(x) = 5/32 + x/2 + 15/32 x^2 - 5/32 x^4 + 1/32 x^6    (0 at x <= -1, x at x >= 1; 5 h / 32 high at the corner)
//! ```
//!
//! so that between all `c - h` and `c + h` f is a polynomial of at most the sixth degree.

/// r of the window's corner.
const CORNER: [f64; 7] = [5.0 / 32.0, 0.5, 15.0 / 32.0, 0.0, -5.0 / 32.0, 0.0, 1.0 / 32.0];

/// Coefficients of a polynomial in one variable, lowest first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Polynomial(pub [f64; 8]);

impl Polynomial {
    /// Value and three derivatives.
    #[inline]
    pub fn jet(&self, x: f64, degree: usize) -> [f64; 4] {
        let [mut p, mut d1, mut d2, mut d3] = [0.0; 4];
        for c in self.0[..=degree].iter().rev() {
            d3 = d3 * x + d2;
            d2 = d2 * x + d1;
            d1 = d1 * x + p;
            p = p * x + c;
        }
        [p, d1, 2.0 * d2, 6.0 * d3]
    }

    pub fn degree(&self) -> usize {
        self.0.iter().rposition(|c| *c != 0.0).unwrap_or(0)
    }

    /// With value 0 at 0; a term of the seventh degree would be lost.
    pub fn integral(&self) -> Polynomial {
        let mut sum = [0.0; 8];
        for (k, (sum, c)) in sum[1..].iter_mut().zip(self.0).enumerate() {
            *sum = c / (k + 1) as f64;
        }
        Polynomial(sum)
    }

    pub fn derivative(&self) -> Polynomial {
        let mut slope = [0.0; 8];
        for (k, (slope, c)) in slope.iter_mut().zip(&self.0[1..]).enumerate() {
            *slope = c * (k + 1) as f64;
        }
        Polynomial(slope)
    }
}

/// The function.
#[derive(Clone, Debug)]
pub(super) struct Ramp {
    /// Distance [m] and value, distances ascending.
    nodes: Vec<(f64, f64)>,
    /// Distances and changes of slope of the corners.
    corners: Vec<(f64, f64)>,
    /// h: half the length of rounding, m.
    half: f64,
}

impl Ramp {
    pub fn new(nodes: Vec<(f64, f64)>, rounding: f64) -> Self {
        let slopes: Vec<f64> = nodes.windows(2).map(|pair| (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0)).collect();
        let slope = |i: Option<usize>| i.and_then(|i| slopes.get(i)).copied().unwrap_or(0.0);
        let corner = |(i, node): (usize, &(f64, f64))| (node.0, slope(Some(i)) - slope(i.checked_sub(1)));
        let corners = nodes.iter().enumerate().map(corner).filter(|corner| corner.1 != 0.0).collect();
        Ramp { nodes, corners, half: 0.5 * rounding }
    }

    pub fn is_constant(&self) -> bool {
        self.nodes.windows(2).all(|pair| pair[0].1 == pair[1].1)
    }

    /// Slope behind the first `count` nodes.
    fn slope(&self, count: usize) -> f64 {
        match (count.checked_sub(1).map(|i| self.nodes[i]), self.nodes.get(count)) {
            (Some(a), Some(b)) => (b.1 - a.1) / (b.0 - a.0),
            _ => 0.0,
        }
    }

    /// Distances between which the function is one polynomial; not sorted.
    pub fn breaks(&self) -> Vec<f64> {
        // Plain: nested iterators are compiled to reads that memory checkers call uninitialised.
        let mut breaks = Vec::with_capacity(2 * self.corners.len());
        for (at, _) in &self.corners {
            breaks.push(at - self.half);
            breaks.push(at + self.half);
        }
        breaks
    }

    /// The polynomial that holds around `s` [m], in the distance from there.
    pub fn around(&self, s: f64) -> Polynomial {
        let mut sum = [0.0; 8];
        let behind = self.nodes.partition_point(|node| node.0 <= s);
        sum[1] = self.slope(behind);
        let from = self.nodes[behind.saturating_sub(1)];
        sum[0] = from.1 + sum[1] * (s - from.0);
        // The line above has the corners before s in full and none of those behind.
        let near = self.corners.partition_point(|corner| corner.0 <= s - self.half);
        for (at, change) in self.corners[near..].iter().take_while(|corner| corner.0 < s + self.half) {
            let x = (s - at) / self.half;
            let mut scale = change * self.half;
            for (k, sum) in sum.iter_mut().enumerate().take(CORNER.len()) {
                let line = if *at <= s { [x, 1.0].get(k).copied().unwrap_or(0.0) } else { 0.0 };
                *sum += scale * (shifted(k, x) - line);
                scale /= self.half;
            }
        }
        Polynomial(sum)
    }
}

/// Coefficient k of r(x + y) as a polynomial in y.
fn shifted(k: usize, x: f64) -> f64 {
    let mut binomial = 1.0;
    let mut sum = 0.0;
    for (n, c) in CORNER.iter().enumerate().skip(k) {
        if n > k {
            binomial *= n as f64 / (n - k) as f64;
        }
        sum += c * binomial * x.powi((n - k) as i32);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean over the window by Gauss's rule between the window's corners is what the polynomials say.
    #[test]
    fn analytic_rounding_is_the_windows_mean() {
        let nodes = vec![(0.0, 0.0), (10.0, 2.0), (13.0, 2.0), (30.0, -1.0)];
        let ramp = Ramp::new(nodes.clone(), 8.0);
        let plain = |s: f64| {
            let at = nodes.partition_point(|n| n.0 <= s);
            match (at.checked_sub(1), nodes.get(at)) {
                (Some(i), Some(b)) => nodes[i].1 + (b.1 - nodes[i].1) * (s - nodes[i].0) / (b.0 - nodes[i].0),
                (None, Some(b)) => b.1,
                _ => nodes[nodes.len() - 1].1,
            }
        };
        let mut largest: f64 = 0.0;
        for i in 0..200 {
            let s = -8.0 + 0.23 * i as f64;
            const N: usize = 20000;
            let mean: f64 = (0..N)
                .map(|j| {
                    let x = (j as f64 + 0.5) / N as f64 * 2.0 - 1.0;
                    plain(s + 4.0 * x) * 15.0 / 16.0 * (1.0 - x * x).powi(2) * 2.0 / N as f64
                })
                .sum();
            largest = largest.max((mean - ramp.around(s).0[0]).abs());
        }
        assert!(largest < 1e-8, "{largest}");
    }

    /// Neighbouring polynomials agree in value and three derivatives where they meet.
    #[test]
    fn prop_pieces_meet_with_three_derivatives() {
        let ramp = Ramp::new(vec![(0.0, 0.0), (10.0, 2.0), (13.0, 2.0), (30.0, -1.0)], 8.0);
        for at in ramp.breaks() {
            let (left, right) = (ramp.around(at - 0.01).jet(0.01, 7), ramp.around(at + 0.01).jet(-0.01, 7));
            for (a, b) in left.iter().zip(right) {
                assert!((a - b).abs() < 1e-13, "{at}: {left:?} {right:?}");
            }
        }
    }
}
