//! Damped Newton iteration for small systems of fixed size, without allocation.

use nalgebra::{SMatrix, SVector};

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct NewtonLimits {
    /// The iteration ends when the next step would be shorter than this (norm). The next step is foreseen from the
    /// last one and the fall of the residual, so that it need not be computed.
    pub next_step: f64,
    pub iterations: usize,
    /// A residual (norm) that is below this and can't be reduced is rounding: the iteration ends well, however long the step that
    /// an ill-conditioned Jacobian makes of it.
    pub rounding: f64,
}

/// The iteration did not converge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonFailure {
    pub iterations: usize,
    /// Norm of the residual at the last point.
    pub residual: f64,
}

/// Solves `residual(x) = 0` from the start in `x`.
///
/// `evaluate(x)` returns the residual and whatever else was computed at `x`, from which `jacobian` makes the derivative
/// of the residual when a step is needed; the value that belongs to the solution is returned with the number of steps. A
/// step is halved while the residual's norm does not fall, so a good start (warm start) costs nothing extra.
///
/// # Errors
/// [`NewtonFailure`] when the Jacobian is singular, the residual cannot be reduced or iterations run out.
#[inline]
pub fn solve<const N: usize, T>(
    x: &mut SVector<f64, N>,
    limits: NewtonLimits,
    mut evaluate: impl FnMut(&SVector<f64, N>) -> (SVector<f64, N>, T),
    mut jacobian: impl FnMut(&SVector<f64, N>, &T) -> SMatrix<f64, N, N>,
) -> Result<(T, usize), NewtonFailure> {
    const HALVINGS: usize = 8;
    let (mut residual, mut value) = evaluate(x);
    let mut norm = residual.norm();
    for iteration in 1..=limits.iterations {
        let failure = NewtonFailure { iterations: iteration, residual: norm };
        // Where two solutions merge the Jacobian is singular at the solution itself.
        let solved = norm <= limits.rounding;
        let Some(inverse) = jacobian(x, &value).try_inverse() else { return if solved { Ok((value, iteration)) } else { Err(failure) } };
        let step = inverse * residual;
        let length = step.norm();
        if !length.is_finite() {
            return if solved { Ok((value, iteration)) } else { Err(failure) };
        }
        let mut factor = 1.0;
        let mut foreseen = f64::INFINITY;
        for halving in 0..=HALVINGS {
            let trial = *x - factor * step;
            let (trial_residual, trial_value) = evaluate(&trial);
            let trial_norm = trial_residual.norm();
            // Within rounding of the solution the norm may not fall any more; a short step is still right.
            let rounding = length <= limits.next_step && trial_norm.is_finite();
            if trial_norm < norm || rounding {
                foreseen = if rounding || norm == 0.0 { 0.0 } else { factor * length * trial_norm / norm };
                (*x, residual, value, norm) = (trial, trial_residual, trial_value, trial_norm);
                break;
            }
            if halving == HALVINGS && norm <= limits.rounding {
                return Ok((value, iteration));
            }
            if halving == HALVINGS {
                return Err(failure);
            }
            factor *= 0.5;
        }
        if foreseen <= limits.next_step {
            return Ok((value, iteration));
        }
    }
    if norm <= limits.rounding {
        return Ok((value, limits.iterations));
    }
    Err(NewtonFailure { iterations: limits.iterations, residual: norm })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Vector2};

    fn limits() -> NewtonLimits {
        NewtonLimits { next_step: 1e-14, iterations: 30, rounding: 0.0 }
    }

    #[test]
    fn analytic_circle_and_parabola_meet_at_the_golden_ratio() {
        // x^2 + y^2 = 1 and y = x^2 give y = (sqrt 5 - 1) / 2.
        let mut x = Vector2::new(3.0, 2.0);
        solve(
            &mut x,
            limits(),
            |x| (Vector2::new(x.x * x.x + x.y * x.y - 1.0, x.y - x.x * x.x), ()),
            |x, ()| Matrix2::new(2.0 * x.x, 2.0 * x.y, -2.0 * x.x, 1.0),
        )
        .unwrap();
        assert!((x.y - (5f64.sqrt() - 1.0) / 2.0).abs() < 1e-15);
    }

    #[test]
    fn hard_damping_saves_arctan_from_overshoot() {
        // Undamped Newton on atan diverges from |x| > 1.39.
        let mut x = SVector::<f64, 1>::new(20.0);
        let value = |x: f64| SVector::<f64, 1>::new(x);
        let (_, iterations) =
            solve(&mut x, limits(), |x| (value(x[0].atan()), ()), |x, ()| SMatrix::<f64, 1, 1>::new(1.0 / (1.0 + x[0] * x[0]))).unwrap();
        assert!(x[0].abs() < 1e-14 && iterations < 20);
    }

    #[test]
    fn hard_no_root_is_reported_with_the_residual() {
        let mut x = SVector::<f64, 1>::new(1.0);
        let square = |x: &SVector<f64, 1>| (SVector::<f64, 1>::new(x[0] * x[0] + 1.0), ());
        let failure = solve(&mut x, limits(), square, |x, ()| SMatrix::<f64, 1, 1>::new(2.0 * x[0])).unwrap_err();
        assert!(failure.residual >= 1.0);
    }
}
