//! Steps from 0 to 1: [`cubic_step`] without a slope at either end, and one with three continuous derivatives: w(t) = t^4 (35 - 84 t + 70 t^2 - 20 t^3), 0 <= t <= 1.
//!
//! With u = t (1 - t): w' = 140 u^3, w'' = 420 u^2 (1 - 2 t), w''' = 840 u (1 - 5 u); all vanish at both ends. The
//! steepest place is the middle: w' = 35/16.

/// Largest w'.
pub const LARGEST_RATE: f64 = 35.0 / 16.0;

/// `3 t^2 - 2 t^3`, held outside 0 .. 1.
#[inline(always)]
pub fn cubic_step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Value and first three derivatives at `t`; constant before 0 and after 1.
#[inline]
pub fn smooth_step(t: f64) -> [f64; 4] {
    if !(t > 0.0) {
        return [0.0; 4];
    }
    if t >= 1.0 {
        return [1.0, 0.0, 0.0, 0.0];
    }
    let u = t * (1.0 - t);
    [
        t.powi(4) * (35.0 + t * (-84.0 + t * (70.0 - 20.0 * t))),
        140.0 * u * u * u,
        420.0 * u * u * (1.0 - 2.0 * t),
        840.0 * u * (1.0 - 5.0 * u),
    ]
}

/// Value and first three derivatives of `w f` with respect to s, w a smooth step of t whose `rate` is dt/ds [1/m].
#[inline]
pub fn weighted([w, w1, w2, w3]: [f64; 4], rate: f64, [f, f1, f2, f3]: [f64; 4]) -> [f64; 4] {
    let (w1, w2, w3) = (rate * w1, rate * rate * w2, rate * rate * rate * w3);
    [w * f, w * f1 + w1 * f, w * f2 + 2.0 * w1 * f1 + w2 * f, w * f3 + 3.0 * (w1 * f2 + w2 * f1) + w3 * f]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_ends_middle_and_derivatives() {
        assert_eq!(smooth_step(-0.1), [0.0; 4]);
        assert_eq!(smooth_step(1.0), [1.0, 0.0, 0.0, 0.0]);
        let [middle, steepest, ..] = smooth_step(0.5);
        assert!((middle - 0.5).abs() < 1e-15 && (steepest - LARGEST_RATE).abs() < 1e-15);
        for end in [1e-6, 1.0 - 1e-6] {
            let [_, d1, d2, d3] = smooth_step(end);
            assert!(d1 < 1e-15 && d2.abs() < 1e-9 && d3.abs() < 1e-3, "{end}");
        }
        assert_eq!([-1.0, 0.0, 0.5, 1.0, 2.0].map(cubic_step), [0.0, 0.0, 0.5, 1.0, 1.0]);
        let h = 1e-4;
        for t in [0.03, 0.2, 0.55, 0.9] {
            for d in 0..3 {
                let slope = (smooth_step(t + h)[d] - smooth_step(t - h)[d]) / (2.0 * h);
                assert!((slope - smooth_step(t)[d + 1]).abs() < 2e-5, "{t} {d}");
            }
        }
    }
}
