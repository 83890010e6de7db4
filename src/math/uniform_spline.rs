//! Spline of fifth degree on equally spaced knots: value and four derivatives are continuous, one number for each knot, constant-time lookup.
//!
//! `f(x) = sum_i c_i B(x / h - i)`, B the cardinal B-spline of degree 5 (support -3 .. 3, values 66, 26, 1 over 120 at the
//! integers). A wave cos(theta i) of coefficients has the values H(theta) cos(theta i) at the knots,
//! `H(theta) = (66 + 52 cos theta + 2 cos 2 theta) / 120`; so a function that is known as a sum of waves is interpolated by
//! dividing each amplitude by H. Between knots such a wave is off by at most about theta^6 / 15400 of its amplitude
//! (theta = 2 pi h / wavelength; ten knots in a wave: 4e-6), its third derivative by 0.008 theta^3 of its own (2e-3).

/// A spline of fifth degree.
#[derive(Clone, Debug)]
pub struct UniformSpline {
    /// Knots for each unit of x.
    density: f64,
    /// Number of the knot, counted from x = 0, of the first coefficient.
    first: i64,
    coefficients: Vec<f64>,
}

/// What a wave of coefficients that turns by `theta` [rad] from knot to knot is multiplied by.
pub fn response(theta: f64) -> f64 {
    (66.0 + 52.0 * theta.cos() + 2.0 * (2.0 * theta).cos()) / 120.0
}

/// Coefficients that a spline needs beyond the knots at both ends of an interval: two before, three behind.
pub const BEFORE: i64 = 2;
pub const BEHIND: i64 = 3;

impl UniformSpline {
    /// A spline with knots at `i * spacing`, the first coefficient being that of `i = first`. Six coefficients or more.
    pub fn new(spacing: f64, first: i64, coefficients: Vec<f64>) -> Option<Self> {
        (coefficients.len() >= 6 && spacing > 0.0).then(|| UniformSpline { density: 1.0 / spacing, first, coefficients })
    }

    /// Is it zero everywhere?
    pub fn is_zero(&self) -> bool {
        self.coefficients.iter().all(|c| *c == 0.0)
    }

    /// Value and first three derivatives at `x`; where coefficients are missing the outermost polynomial goes on.
    #[inline]
    pub fn at(&self, x: f64) -> [f64; 4] {
        let scaled = x * self.density;
        let place = (scaled.floor() as i64 - BEFORE - self.first).clamp(0, self.coefficients.len() as i64 - 6);
        let t = scaled - (place + BEFORE + self.first) as f64;
        let c = &self.coefficients[place as usize..place as usize + 6];
        // Powers of t of the polynomial between the third and the fourth knot of the six.
        let (outer, inner) = (c[0] + c[4], c[1] + c[3]);
        let (outer_slope, inner_slope) = (c[4] - c[0], c[3] - c[1]);
        let a0 = (outer + 26.0 * inner + 66.0 * c[2]) * (1.0 / 120.0);
        let a1 = (outer_slope + 10.0 * inner_slope) * (1.0 / 24.0);
        let a2 = (outer + 2.0 * inner - 6.0 * c[2]) * (1.0 / 12.0);
        let a3 = (outer_slope - 2.0 * inner_slope) * (1.0 / 12.0);
        let a4 = (outer - 4.0 * inner + 6.0 * c[2]) * (1.0 / 24.0);
        let a5 = (c[5] - c[0] + 5.0 * (c[1] - c[4]) + 10.0 * (c[3] - c[2])) * (1.0 / 120.0);
        let k = self.density;
        [
            a0 + t * (a1 + t * (a2 + t * (a3 + t * (a4 + t * a5)))),
            k * (a1 + t * (2.0 * a2 + t * (3.0 * a3 + t * (4.0 * a4 + t * 5.0 * a5)))),
            k * k * (2.0 * a2 + t * (6.0 * a3 + t * (12.0 * a4 + t * 20.0 * a5))),
            k * k * k * (6.0 * a3 + t * (24.0 * a4 + t * 60.0 * a5)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// cos(x) interpolated with `knots` in a wave.
    fn wave(knots: i64) -> UniformSpline {
        let h = TAU / knots as f64;
        UniformSpline::new(h, -5, (-5..knots + 6).map(|i| (h * i as f64).cos() / response(h)).collect()).unwrap()
    }

    fn error(knots: i64, derivative: usize) -> f64 {
        let spline = wave(knots);
        (0..1000)
            .map(|i| {
                let x = TAU * (f64::from(i) + 0.5) / 1000.0;
                (spline.at(x)[derivative] - [x.cos(), -x.sin(), -x.cos(), x.sin()][derivative]).abs()
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn order_value_and_derivatives_converge() {
        for (derivative, order) in [(0, 6.0), (1, 5.0), (2, 4.0), (3, 3.0)] {
            let measured = (error(10, derivative) / error(40, derivative)).log2() / 2.0;
            println!("derivative {derivative}: {:.1e} with ten knots in a wave, order {measured:.2}", error(10, derivative));
            assert!((measured - order).abs() < 0.25, "derivative {derivative}: order {measured}");
        }
        assert!(error(10, 0) < 5e-6 && error(10, 3) < 2.5e-3);
    }

    #[test]
    fn analytic_a_polynomial_of_fifth_degree_from_its_blossom() {
        // The coefficient of knot i is the blossom of the polynomial at i-2 .. i+2: for x^5 their product.
        let coefficients = (-4..5).map(|i: i64| (i - 2..=i + 2).map(|k| k as f64).product()).collect();
        let spline = UniformSpline::new(1.0, -4, coefficients).unwrap();
        for x in [-1.9, -0.3, 0.0, 0.7, 1.0] {
            let exact = [f64::powi(x, 5), 5.0 * f64::powi(x, 4), 20.0 * f64::powi(x, 3), 60.0 * x * x];
            for (found, exact) in spline.at(x).into_iter().zip(exact) {
                assert!((found - exact).abs() < 1e-12, "{x}: {found} {exact}");
            }
        }
    }

    #[test]
    fn prop_continuous_at_knots() {
        let spline = wave(8);
        for knot in 1..8 {
            let x = f64::from(knot) * TAU / 8.0;
            for (before, after) in spline.at(x - 1e-10).into_iter().zip(spline.at(x + 1e-10)) {
                assert!((before - after).abs() < 1e-8, "{knot}: {before} {after}");
            }
        }
        assert!(UniformSpline::new(1.0, 0, vec![0.0; 5]).is_none());
    }
}
