//! Cubic smoothing spline (Reinsch, Numerische Mathematik 10 (1967), 177-183) of a plane curve.
//!
//! The points (x_i, y_i) are functions of the length s along their polygon. Each coordinate v is replaced by the
//! natural cubic spline g(s) that minimises `sum (v_i - g_i)^2 + lambda integral g''^2 ds`. With the distances
//! `h_i = s_(i+1) - s_i`, the second derivatives c of g at the inner knots solve `(R + lambda Q'Q) c = Q'v` (five
//! diagonals, positive definite), and `g = v - lambda Q c`. Smoothing over s treats flat and steep parts of a curve
//! alike; lambda is the one number for both coordinates that leaves a wanted root-mean-square distance.

/// A curve's points after smoothing.
#[derive(Clone, Debug)]
pub struct Smoothed {
    pub points: Vec<(f64, f64)>,
    /// Root-mean-square distance of the points from where they were.
    pub rms: f64,
    /// The largest of these distances.
    pub largest: f64,
}

/// The bands of R and Q'Q of one set of knots.
struct Reinsch {
    h: Vec<f64>,
}

impl Reinsch {
    /// The column of Q at inner knot i + 1: its entries in rows i, i + 1, i + 2.
    fn column(&self, i: usize) -> [f64; 3] {
        let (a, b) = (1.0 / self.h[i], 1.0 / self.h[i + 1]);
        [a, -a - b, b]
    }

    /// Removes from `v` what smoothing with `lambda` takes away: lambda Q c.
    fn taken(&self, v: &[f64], lambda: f64) -> Vec<f64> {
        let n = self.h.len() - 1;
        // Symmetric band of A = R + lambda Q'Q: main diagonal and the two above it.
        let (mut d, mut e, mut f) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let mut c = vec![0.0; n];
        for i in 0..n {
            let q = self.column(i);
            d[i] = (self.h[i] + self.h[i + 1]) / 3.0 + lambda * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
            if i + 1 < n {
                let next = self.column(i + 1);
                e[i] = self.h[i + 1] / 6.0 + lambda * (q[1] * next[0] + q[2] * next[1]);
            }
            if i + 2 < n {
                f[i] = lambda * q[2] * self.column(i + 2)[0];
            }
            c[i] = q[0] * v[i] + q[1] * v[i + 1] + q[2] * v[i + 2];
        }
        // A = L D L' in place: d holds D, e and f the two diagonals of L below the main one.
        for i in 0..n {
            if i >= 1 {
                d[i] -= d[i - 1] * e[i - 1] * e[i - 1];
            }
            if i >= 2 {
                d[i] -= d[i - 2] * f[i - 2] * f[i - 2];
            }
            if i >= 1 {
                e[i] -= d[i - 1] * e[i - 1] * f[i - 1];
            }
            e[i] /= d[i];
            f[i] /= d[i];
        }
        for i in 0..n {
            if i >= 1 {
                c[i] -= e[i - 1] * c[i - 1];
            }
            if i >= 2 {
                c[i] -= f[i - 2] * c[i - 2];
            }
        }
        for i in (0..n).rev() {
            c[i] /= d[i];
            if i + 1 < n {
                c[i] -= e[i] * c[i + 1];
            }
            if i + 2 < n {
                c[i] -= f[i] * c[i + 2];
            }
        }
        let mut taken = vec![0.0; n + 2];
        for (i, c) in c.iter().enumerate() {
            for (row, q) in self.column(i).iter().enumerate() {
                taken[i + row] += lambda * q * c;
            }
        }
        taken
    }
}

/// How far points may move, in the unit of the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reach {
    /// Root mean square.
    RootMeanSquare(f64),
    /// The furthest of them.
    Largest(f64),
}

/// Smooths a curve of distinct points so that they move by `reach`; less where even the straight
/// line is nearer. `None` for fewer than four points, for points that coincide, and for what is not finite.
pub fn smooth(points: &[(f64, f64)], reach: Reach) -> Option<Smoothed> {
    let (Reach::RootMeanSquare(wanted) | Reach::Largest(wanted)) = reach;
    if points.len() < 4 || !(wanted > 0.0) {
        return None;
    }
    let h: Vec<f64> = points.windows(2).map(|p| (p[1].0 - p[0].0).hypot(p[1].1 - p[0].1)).collect();
    if h.iter().any(|h| !(*h > 0.0 && h.is_finite())) {
        return None;
    }
    // In units of the mean distance lambda has no dimension and the matrix entries are near 1.
    let unit = h.iter().sum::<f64>() / h.len() as f64;
    let reinsch = Reinsch { h: h.iter().map(|h| h / unit).collect() };
    let (x, y): (Vec<f64>, Vec<f64>) = points.iter().map(|p| (p.0 / unit, p.1 / unit)).unzip();
    let at = |lambda: f64| {
        let (dx, dy) = (reinsch.taken(&x, lambda), reinsch.taken(&y, lambda));
        let squares = || dx.iter().zip(&dy).map(|(dx, dy)| dx * dx + dy * dy);
        let (sum, largest) = (squares().sum::<f64>(), squares().fold(0.0, f64::max));
        let [rms, largest] = [sum / points.len() as f64, largest].map(|square| unit * square.sqrt());
        (rms, largest, dx, dy)
    };
    // The distance grows with lambda.
    let (mut low, mut high) = (-30.0f64, 30.0f64);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let (rms, largest, ..) = at(middle.exp());
        let moved = if let Reach::Largest(_) = reach { largest } else { rms };
        if moved < wanted { low = middle } else { high = middle }
    }
    let (rms, largest, dx, dy) = at(low.exp());
    let moved = points.iter().zip(dx.iter().zip(&dy)).map(|(p, (dx, dy))| (p.0 - unit * dx, p.1 - unit * dy));
    Some(Smoothed { points: moved.collect(), rms, largest })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a circle with deterministic noise of about 0.29 `size` in each coordinate.
    fn circle(n: u32, size: f64) -> Vec<(f64, f64)> {
        let noise =
            |i: u32, k: u32| f64::from(i.wrapping_mul(2_654_435_761).wrapping_add(k.wrapping_mul(40_503)) >> 8) / f64::from(1 << 24) - 0.5;
        (0..n)
            .map(|i| {
                let a = 0.3 + 2.5 * f64::from(i) / f64::from(n);
                (a.cos() + size * noise(i, 1), a.sin() + size * noise(i * i + 7, 2))
            })
            .collect()
    }

    #[test]
    fn analytic_normal_equations_hold() {
        // g + lambda K g = v with K = Q R^-1 Q': checked as R c = Q'g, with c from lambda Q c = v - g.
        let h = vec![1.0, 0.5, 2.0, 1.5, 0.7];
        let reinsch = Reinsch { h: h.clone() };
        let v = [0.3, -1.0, 2.0, 0.1, 0.7, -0.4];
        let lambda = 0.37;
        let taken = reinsch.taken(&v, lambda);
        let g: Vec<f64> = v.iter().zip(&taken).map(|(v, t)| v - t).collect();
        // lambda Q c = taken: solve from the top.
        let mut c = [0.0; 4];
        for i in 0..4 {
            let before = if i >= 1 { reinsch.column(i - 1)[1] * c[i - 1] } else { 0.0 };
            let before2 = if i >= 2 { reinsch.column(i - 2)[2] * c[i - 2] } else { 0.0 };
            c[i] = (taken[i] / lambda - before - before2) / reinsch.column(i)[0];
        }
        for i in 0..4 {
            let q = reinsch.column(i);
            let left = q[0] * g[i] + q[1] * g[i + 1] + q[2] * g[i + 2];
            let mut right = (h[i] + h[i + 1]) / 3.0 * c[i];
            if i >= 1 {
                right += h[i] / 6.0 * c[i - 1];
            }
            if i < 3 {
                right += h[i + 1] / 6.0 * c[i + 1];
            }
            assert!((left - right).abs() < 1e-12, "{i}: {left} {right}");
        }
    }

    #[test]
    fn prop_points_move_by_the_wanted_distance_and_noise_shrinks() {
        let noisy = circle(400, 2e-3);
        // Noise is 2e-3 / sqrt(12) in each coordinate; its part across the curve is what matters.
        let across = |points: &[(f64, f64)]| {
            let squares: f64 = points[20..380].iter().map(|p| (p.0.hypot(p.1) - 1.0).powi(2)).sum();
            (squares / 360.0).sqrt()
        };
        let smoothed = smooth(&noisy, Reach::RootMeanSquare(8e-4)).unwrap();
        println!("across the curve: {:.2e} before, {:.2e} after", across(&noisy), across(&smoothed.points));
        assert!((smoothed.rms - 8e-4).abs() < 1e-8);
        let within = smooth(&noisy, Reach::Largest(1.5e-3)).unwrap();
        let furthest = noisy.iter().zip(&within.points).map(|(a, b)| (a.0 - b.0).hypot(a.1 - b.1)).fold(0.0, f64::max);
        assert!((furthest - 1.5e-3).abs() < 1e-8 && (furthest - within.largest).abs() < 1e-15, "{furthest}");
        assert!(across(&smoothed.points) < 0.5 * across(&noisy));
    }

    #[test]
    fn analytic_a_straight_line_stays() {
        let line: Vec<(f64, f64)> = (0..30).map(|i| (f64::from(i), 0.5 * f64::from(i))).collect();
        let smoothed = smooth(&line, Reach::Largest(1.0)).unwrap();
        assert!(smoothed.rms < 1e-9);
        assert!(smooth(&line[..3], Reach::RootMeanSquare(1.0)).is_none());
        assert!(smooth(&[(0.0, 0.0), (0.0, 0.0), (1.0, 0.0), (2.0, 0.0)], Reach::RootMeanSquare(1.0)).is_none());
    }
}
