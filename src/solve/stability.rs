//! How long a step an explicit method may take over a vibration.

/// Limits are searched for in steps of this size, up to this.
const FINE: f64 = 0.02;
const MOST: f64 = 4.0;
/// Beyond this damping a vibration counts as no more damped: it is known roughly, and steps must be right too.
const DAMPED: f64 = 0.3;
/// What is used of it.
const USED: f64 = 0.9;

/// What a method is explicit in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Explicit {
    Nothing,
    /// All, with this stability polynomial R by its coefficients, lowest first.
    All(&'static [f64]),
    /// Force elements, while contacts and the kinematics of all bodies are implicit ([`super::imex`]).
    Elements,
}

impl Explicit {
    /// |lambda| h up to which a vibration of that damping ratio does not grow.
    pub fn limit(self, damping: f64) -> f64 {
        let damping = damping.clamp(0.0, DAMPED);
        match self {
            Explicit::Nothing => f64::INFINITY,
            Explicit::All(polynomial) => on_ray(polynomial, damping),
            // Without damping an amplitude grows by 0.0104 (w h)^4.2 in each step (eigenvalues of the step, to 1.2), whatever its length is.
            Explicit::Elements => (damping / 0.0104).powf(1.0 / 3.2).min(1.35),
        }
    }
}

/// |z| up to which `|R(z)| <= 1` on the ray of a damping ratio.
fn on_ray(polynomial: &[f64], damping: f64) -> f64 {
    let unit = [-damping, (1.0 - damping * damping).sqrt()];
    let grows = |size: f64| {
        let z = unit.map(|part| part * size);
        let value = polynomial.iter().rev().fold([0.0, 0.0], |[re, im], c| [re * z[0] - im * z[1] + c, re * z[1] + im * z[0]]);
        value[0] * value[0] + value[1] * value[1] > 1.0 + 1e-12
    };
    let beyond = (1..).map(|k| FINE * f64::from(k)).find(|size| *size >= MOST || grows(*size)).unwrap_or(MOST);
    beyond - FINE
}

/// The longest step over a vibration of size `rate` [1/s] and damping ratio `damping`, s; `wanted` where that is shorter.
pub(super) fn bounded(wanted: f64, explicit: Explicit, [rate, damping]: [f64; 2]) -> f64 {
    // Slower growth than below this does not matter: of `imex` 0.06 % in a step.
    const LEAST: f64 = 0.5;
    if explicit == Explicit::Nothing || !(wanted * rate > USED * LEAST) {
        return wanted;
    }
    wanted.min(USED * explicit.limit(damping).max(LEAST) / rate)
}

#[cfg(test)]
mod tests {
    use super::super::adaptive::StepPair;
    use super::super::{DormandPrince, RungeKutta43};
    use super::*;

    /// Known limits: of the classical method sqrt(8) on the imaginary axis, of Dormand and Prince's pair just below 1; damping moves them out.
    #[test]
    fn analytic_limits_on_the_imaginary_axis() {
        let [classical, pair] = [RungeKutta43 { tolerance: 1.0 }.explicitly(), DormandPrince { tolerance: 1.0 }.explicitly()];
        assert!((classical.limit(0.0) - 8f64.sqrt()).abs() < FINE && (0.9..1.0).contains(&pair.limit(0.0)));
        assert!(pair.limit(0.02) > 1.6 && pair.limit(0.1) > pair.limit(0.02));
        assert!(bounded(1e-3, pair, [400.0, 0.0]) == 1e-3 && bounded(1e-3, Explicit::Nothing, [4e3, 0.0]) == 1e-3);
        assert!(bounded(1e-3, pair, [2e3, 0.0]) < 0.45e-3);
        // Eigenvalues of one step over x'' = - w^2 x - 2 d w x' with J of x' = v alone.
        for (damping, limit) in [(0.005, 0.8), (0.01, 0.97), (0.05, 1.39)] {
            assert!((Explicit::Elements.limit(damping) / limit - 1.0).abs() < 0.04);
        }
    }
}
