//! Friction of brakes that stick truly: with an elastic deflection as state.
//!
//! M is the largest friction torque [N m] (or force, N), theta the elastic deflection [rad at the axle] (or m), k the stiffness, rho the speed against what carries
//! the brake, forward positive. With the bound `theta_M = M / k`, `rho_M = theta_M / tau` and v the speed rho cut to +-rho_M:
//!
//! ```text
//! theta' = v (1 - s) - (1 - |v| / rho_M) max(0, |theta| - theta_M) / tau sign(theta)
//! s = 0 up to |theta| = a theta_M,  (|theta|/theta_M - a) / (1 - a) beyond;   only while the brake is loaded: theta rho > 0
//! T = k theta + c v (1 - s) / sqrt(1 + (c v (1 - s) / B)^2),   B = b M max(0, 1 - (theta / theta_M)^2),
//!     against the motion;   unloading: k theta v / rho in place of k theta, and B = b M
//! ```
//!
//! Unloading beyond theta_M, where M has fallen, |theta| takes the place of theta_M in rho_M: with a bound that is gone the torque would jump from k theta to nothing where the speed turns round.
//!
//! Below a M (a = 0.7) nothing slips: what is at rest stays where it is, without creep; at speed theta rests at theta_M and T = M. The bound of v keeps
//! the equation's rate below 3.4 / tau at any speed, so that no integrator must follow rho / theta_M; while the brake slides it is the same on both sides of theta_M (a rate that
//! changed there made long implicit steps go to and fro across it, and T 0.4 % too large). c = k x `damping_time` lets a stopped vehicle come to rest on its
//! brakes; b = 0.5 is the largest with which no T is above M (x + b (1 - x^2) has its largest value, 1, at x = 1), but for what a falling M leaves. Without M there is no torque. Heat, `T rho - k theta theta'`, is never negative: loading it is `k theta (rho - v (1 - s))` and
//! what c takes, unloading what c takes, and where M falls `k |theta| (|theta| - theta_M) / tau`.

/// a.
pub const STICKING: f64 = 0.7;
/// b.
const DAMPED: f64 = 0.5;
/// theta_M, and a deflection, below which there is no brake: squares and quotients of what fades for ever leave the range of numbers.
const LEAST_REACH: f64 = 1e-30;

/// How a brake holds.
#[derive(Clone, Copy, Debug)]
pub struct Sticking {
    /// k, N m/rad or N/m.
    pub stiffness: f64,
    /// tau, s.
    pub relaxation: f64,
    /// c / k, s.
    pub damping_time: f64,
}

/// A brake at one instant, and its slopes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Grip {
    /// T, against the motion; theta'.
    pub torque: f64,
    pub rate: f64,
    pub torque_by_angle: f64,
    pub torque_by_speed: f64,
    pub rate_by_angle: f64,
    pub rate_by_speed: f64,
}

/// Stiffness beyond which an error of the deflection weighs more than one of a position, N m/rad or N/m.
const WEIGHED: f64 = 1e6;

/// Slower than this what a brake holds is at rest where the brake settles, rad/s or m/s.
const AT_REST: f64 = 1e-3;

impl Sticking {
    /// Deflections are some 1e-5 rad, as small as a usual tolerance: by plain errors the torque of a brake that was let go was off by 135 of 666 N m, and its heat by 4 %.
    pub fn state_weight(&self) -> f64 {
        (self.stiffness / WEIGHED).max(1.0)
    }

    /// The deflection at which it settles under a bound `most` at a constant speed: that of M; at rest none, what a brake holds there depends on how it came to rest.
    pub fn settled(&self, most: f64, speed: f64) -> f64 {
        if speed.abs() > AT_REST { most / self.stiffness * speed.signum() } else { 0.0 }
    }

    /// Does a brake with the bound `most` do nothing?
    pub fn is_off(&self, most: f64) -> bool {
        !(most / self.stiffness >= LEAST_REACH)
    }

    /// The brake at a deflection and speed, of the bound `most`.
    #[inline]
    pub fn grip(&self, most: f64, angle: f64, speed: f64) -> Grip {
        let (k, reach) = (self.stiffness, most / self.stiffness);
        if self.is_off(most) && angle.abs() < LEAST_REACH {
            return Grip { rate: -angle / self.relaxation, rate_by_angle: -1.0 / self.relaxation, ..Grip::default() };
        }
        let loaded = angle * speed >= 0.0;
        // A brake that was let go gives its deflection back as one does that was not.
        let beyond = !loaded && angle.abs() > reach;
        let span = if beyond { angle.abs() } else { reach };
        let fastest = span / self.relaxation;
        let bound = speed.clamp(-fastest, fastest);
        let (share, follows) = if bound == speed { (1.0, 1.0) } else { (bound / speed, 0.0) };
        let (mut slip, mut slip_by_angle) = (0.0, 0.0);
        let mut grip = Grip { torque: k * angle, torque_by_angle: k, ..Grip::default() };
        if !loaded {
            grip.torque *= share;
            grip.torque_by_angle *= if beyond && follows == 0.0 { 2.0 * share } else { share };
            grip.torque_by_speed = if follows == 0.0 { -grip.torque / speed } else { 0.0 };
        } else if self.is_off(most) {
            slip = 1.0;
        } else {
            slip = ((angle.abs() / reach - STICKING) / (1.0 - STICKING)).max(0.0);
            slip_by_angle = if slip > 0.0 { angle.signum() / ((1.0 - STICKING) * reach) } else { 0.0 };
        }
        let (elastic, mut by_angle, by_speed) = (bound * (1.0 - slip), -bound * slip_by_angle, follows * (1.0 - slip));
        if beyond && follows == 0.0 {
            by_angle -= 1.0 / self.relaxation;
        }
        let excess = (angle.abs() - reach).max(0.0) * angle.signum();
        let (resting, by_speed_of_resting) =
            if span < LEAST_REACH { (1.0, 0.0) } else { (1.0 - bound.abs() / fastest, -follows * speed.signum() / fastest) };
        grip.rate = elastic - resting * excess / self.relaxation;
        grip.rate_by_angle = by_angle - if excess != 0.0 { resting / self.relaxation } else { 0.0 };
        if beyond {
            grip.rate_by_angle -= follows * bound.abs() / (fastest * angle) * excess / self.relaxation;
        }
        grip.rate_by_speed = by_speed - by_speed_of_resting * excess / self.relaxation;
        // Unloading takes from the deflection's part.
        let (c, x) = (
            k * self.damping_time,
            if self.is_off(most) {
                1.0
            } else if loaded {
                angle / reach
            } else {
                0.0
            },
        );
        let bend = DAMPED * most * (1.0 - x * x);
        if bend > 0.0 {
            let size = bend.hypot(c * elastic);
            let (softer, used) = (bend / size, c * elastic / size);
            grip.torque += c * elastic * softer;
            // B falls by 2 b k x with theta.
            grip.torque_by_angle += c * by_angle * softer.powi(3) - 2.0 * DAMPED * k * x * used.powi(3);
            grip.torque_by_speed += c * by_speed * softer.powi(3);
        }
        grip
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BRAKE: Sticking = Sticking { stiffness: 6e6, relaxation: 2e-3, damping_time: 4e-3 };
    const MOST: f64 = 5000.0;

    /// A braking torque is never above the bound, whatever the speed with which a deflection builds up, and never drives.
    #[test]
    fn prop_no_torque_is_above_the_bound() {
        let mut largest: f64 = 0.0;
        for x in -100..=100 {
            for speed in [0.0, 1e-6, 1e-4, 0.01, 0.1, 0.4, 1.0, 30.0].into_iter().flat_map(|speed| [-speed, speed]) {
                let grip = BRAKE.grip(MOST, 0.01 * f64::from(x) * MOST / BRAKE.stiffness, speed);
                largest = largest.max(grip.torque.abs());
            }
        }
        assert!(largest <= MOST * (1.0 + 1e-12) && largest > 0.99 * MOST, "{largest}");
    }

    /// A brake that is let go: no jump where the speed turns round, heat is never negative, and the deflection goes back.
    #[test]
    fn prop_a_brake_that_is_let_go_turns_round_without_a_jump() {
        for most in [0.0, 1.0, 300.0, MOST] {
            for x in [-1.0, -0.2, 0.3, 1.0, 1.3] {
                let angle = x * MOST / BRAKE.stiffness;
                let [before, after] = [-1e-13, 1e-13].map(|speed| BRAKE.grip(most, angle, speed).torque);
                assert!((before - after).abs() < 1e-6 * MOST, "{most} {x}: {before} {after}");
                for speed in [-3.0, -0.05, -1e-4, 1e-4, 0.05, 3.0] {
                    let grip = BRAKE.grip(most, angle, speed);
                    let heat = grip.torque * speed - BRAKE.stiffness * angle * grip.rate;
                    assert!(heat > -1e-9 * MOST, "{most} {x} {speed}: {heat}");
                    assert!(angle.abs() <= most / BRAKE.stiffness || grip.rate * angle <= 0.0 || angle * speed > 0.0);
                }
            }
        }
    }

    #[test]
    fn analytic_slopes_are_those_of_differences() {
        let reach = MOST / BRAKE.stiffness;
        for x in [-1.2, -0.93, -0.5, -0.1, 0.05, 0.3, 0.6, 0.75, 0.97, 1.1] {
            for speed in [-5.0, -0.2, -1e-3, 2e-4, 0.05, 0.3, 8.0] {
                let (angle, step) = (x * reach, 1e-6);
                let at = |angle: f64, speed: f64| BRAKE.grip(MOST, angle, speed);
                let grip = at(angle, speed);
                let by_angle = (at(angle + step * reach, speed).torque - at(angle - step * reach, speed).torque) / (2.0 * step * reach);
                let by_speed = (at(angle, speed * (1.0 + step)).torque - at(angle, speed * (1.0 - step)).torque) / (2.0 * step * speed);
                assert!(
                    (grip.torque_by_angle - by_angle).abs() < 1e-4 * BRAKE.stiffness,
                    "{x} {speed}: {} {by_angle}",
                    grip.torque_by_angle
                );
                let rates = |angle: f64, speed: f64| at(angle, speed).rate;
                let rate_by_angle = (rates(angle + step * reach, speed) - rates(angle - step * reach, speed)) / (2.0 * step * reach);
                let rate_by_speed = (rates(angle, speed * (1.0 + step)) - rates(angle, speed * (1.0 - step))) / (2.0 * step * speed);
                assert!(
                    (grip.rate_by_angle - rate_by_angle).abs() < 1e-4 / BRAKE.relaxation,
                    "{x} {speed}: {} {rate_by_angle}",
                    grip.rate_by_angle
                );
                assert!((grip.rate_by_speed - rate_by_speed).abs() < 1e-4, "{x} {speed}: {} {rate_by_speed}", grip.rate_by_speed);
                assert!(
                    (grip.torque_by_speed - by_speed).abs() < 1e-4 * (MOST / speed.abs()),
                    "{x} {speed}: {} {by_speed}",
                    grip.torque_by_speed
                );
            }
        }
    }
}
