//! Fixed-point iteration x = g(x) for small vectors, accelerated, without allocation.
//!
//! Each iteration takes the step that would be right if g were linear along the last change (Anderson's mixing with one
//! earlier point): with `f = g - x`, `x_next = g - theta (g - g_last)`, `theta = f . (f - f_last) / |f - f_last|^2`.
//! A contraction converges without it too; the acceleration makes weakly coupled systems converge like a secant method.
//!
//! Source: D.G. Anderson, J. ACM 12 (1965) 547-560.

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The iteration ends when |g(x) - x| is at most this times |g(x)| (largest components) ...
    pub relative: f64,
    /// ... or at most this.
    pub floor: f64,
    pub iterations: usize,
    /// When iterations run out, |g(x) - x| up to this times |g(x)| is accepted: g itself may not be smooth to the last digits.
    pub accepted: f64,
}

/// The iteration did not settle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotSettled {
    pub iterations: usize,
    /// Largest |g(x) - x| at the last point.
    pub residual: f64,
    /// The component that is largest.
    pub component: usize,
}

/// Scratch for vectors of one length.
#[derive(Clone, Debug, Default)]
pub struct Work {
    image: Vec<f64>,
    last_image: Vec<f64>,
    last_difference: Vec<f64>,
}

impl Work {
    pub fn new(length: usize) -> Self {
        Work { image: vec![0.0; length], last_image: vec![0.0; length], last_difference: vec![0.0; length] }
    }
}

/// Solves `x = g(x)` from the start in `x`; returns the number of evaluations of g. `x` then holds the last image g(x), and g
/// was evaluated last at a point that differs from it by less than the limit.
///
/// # Errors
/// [`NotSettled`] when iterations run out or a number is not finite; whatever g returns.
pub fn settle<E: From<NotSettled>>(
    x: &mut [f64],
    limits: Limits,
    work: &mut Work,
    mut g: impl FnMut(&[f64], &mut [f64]) -> Result<(), E>,
) -> Result<usize, E> {
    let Work { image, last_image, last_difference } = work;
    let (mut residual, mut largest) = (f64::INFINITY, 0.0);
    for iteration in 1..=limits.iterations {
        g(x, image)?;
        largest = image.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        residual = image.iter().zip(x.iter()).fold(0.0, |largest: f64, (g, x)| largest.max((g - x).abs()));
        // f64::max passes over NaN.
        if !image.iter().all(|value| value.is_finite()) {
            let component = image.iter().position(|value| !value.is_finite()).unwrap_or(0);
            return Err(NotSettled { iterations: iteration, residual: f64::NAN, component }.into());
        }
        if residual <= (limits.relative * largest).max(limits.floor) {
            x.copy_from_slice(image);
            return Ok(iteration);
        }
        let (mut product, mut norm) = (0.0, 0.0);
        for i in 0..x.len() {
            let difference = image[i] - x[i];
            let change = difference - last_difference[i];
            product += difference * change;
            norm += change * change;
            last_difference[i] = difference;
        }
        // A large theta means that the last change told little: then the plain step is safer.
        let theta = if iteration > 1 && norm > 0.0 { (product / norm).clamp(-4.0, 4.0) } else { 0.0 };
        for i in 0..x.len() {
            x[i] = image[i] - theta * (image[i] - last_image[i]);
            last_image[i] = image[i];
        }
    }
    if residual <= limits.accepted * largest {
        x.copy_from_slice(image);
        return Ok(limits.iterations);
    }
    // What was left in the last iteration.
    let component = (0..last_difference.len()).max_by(|a, b| last_difference[*a].abs().total_cmp(&last_difference[*b].abs())).unwrap_or(0);
    Err(NotSettled { iterations: limits.iterations, residual, component }.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { relative: 1e-14, floor: 0.0, iterations: 50, accepted: 0.0 };

    fn cosine(x: &[f64], image: &mut [f64]) -> Result<(), NotSettled> {
        image[0] = x[0].cos();
        Ok(())
    }

    #[test]
    fn analytic_cosine_settles_at_its_fixed_point_like_a_secant() {
        let mut x = [1.0];
        let evaluations = settle(&mut x, LIMITS, &mut Work::new(1), cosine).unwrap();
        assert!((x[0] - 0.739_085_133_215_160_6).abs() < 1e-14);
        assert!(evaluations <= 8, "{evaluations} evaluations; the plain iteration needs 80");
    }

    #[test]
    fn analytic_slope_beyond_one_settles_too() {
        // x = 3 - 2 x repels the plain iteration.
        let mut x = [5.0];
        settle::<NotSettled>(&mut x, LIMITS, &mut Work::new(1), |x, image| {
            image[0] = 3.0 - 2.0 * x[0];
            Ok(())
        })
        .unwrap();
        assert!((x[0] - 1.0).abs() < 1e-14);
    }

    #[test]
    fn prop_two_weakly_coupled_unknowns() {
        let mut x = [0.0, 0.0];
        let evaluations = settle::<NotSettled>(&mut x, LIMITS, &mut Work::new(2), |x, image| {
            image[0] = 1.0 + 0.05 * (x[1] * x[1]).sin() + 0.03 * x[0];
            image[1] = 2.0 - 0.04 * x[0] * x[1];
            Ok(())
        })
        .unwrap();
        assert!((x[0] - (1.0 + 0.05 * (x[1] * x[1]).sin() + 0.03 * x[0])).abs() < 1e-13);
        assert!((x[1] - (2.0 - 0.04 * x[0] * x[1])).abs() < 1e-13);
        println!("{evaluations} evaluations");
        assert!(evaluations < 25, "{evaluations}");
    }

    #[test]
    fn hard_without_fixed_point_it_says_so() {
        let mut x = [0.0];
        let failed = settle::<NotSettled>(&mut x, LIMITS, &mut Work::new(1), |x, image| {
            image[0] = x[0] + 1.0;
            Ok(())
        });
        assert_eq!(failed.unwrap_err().iterations, 50);
        let mut x = [1.0];
        let failed = settle::<NotSettled>(&mut x, LIMITS, &mut Work::new(1), |_, image| {
            image[0] = f64::NAN;
            Ok(())
        });
        assert_eq!(failed.unwrap_err().iterations, 1);
    }
}
