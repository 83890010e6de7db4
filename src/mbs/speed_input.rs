//! A speed that is imposed from outside: the input u is the wanted speed, and the vehicle's speed V follows it.
//!
//! A velocity can't jump, an input may. So the vehicle's acceleration is that which takes V to u, behind what u itself and a second input a announce:
//!
//! ```text
//! V' = bound(u' + a + (u - V) / T),    bound(x) = min(max(x, -A), A)
//! ```
//!
//! - Where u' or a tell how u goes on (derivatives of the input; a master without them gives the slope as a) and |u'| stays within A, V is u once they are equal: the error dies as
//!   exp(-t / T).
//! - A jump of u is followed with the acceleration A until |u - V| < A T, then as exp(-t / T): without overshoot.
//! - A staircase with steps of H and a slope k is followed with the lag k (T + H / 2) where a = 0, and k H / 2 where a = k: that of its mean.
//!
//! V is no state of its own: it is the speed of the leading driven body along the track, which all that are driven have. It is smooth in so far as
//! its rate is bounded; the rate jumps with u by its jump over T at most.

/// How the speed follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedInput {
    /// T, s.
    pub time_constant: f64,
    /// A, m/s2.
    pub largest_acceleration: f64,
    /// |u| counts up to here, m/s: polynomials may go anywhere.
    pub fastest: f64,
}

/// What the inputs say at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wanted {
    /// u, m/s.
    pub speed: f64,
    /// u' + a, m/s2.
    pub rate: f64,
}

impl SpeedInput {
    /// V' where the speed is `speed` [m/s], m/s2.
    #[inline]
    pub fn acceleration(&self, wanted: &Wanted, speed: f64) -> f64 {
        let behind = wanted.speed.clamp(-self.fastest, self.fastest) - speed;
        (wanted.rate + behind / self.time_constant).clamp(-self.largest_acceleration, self.largest_acceleration)
    }

    /// dV'/dV where the speed is `speed` [m/s], 1/s: -1 / T, 0 at the bound.
    #[inline]
    pub fn slope(&self, wanted: &Wanted, speed: f64) -> f64 {
        if self.acceleration(wanted, speed).abs() < self.largest_acceleration { -1.0 / self.time_constant } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INPUT: SpeedInput = SpeedInput { time_constant: 0.5, largest_acceleration: 2.0, fastest: 100.0 };

    #[test]
    fn analytic_it_follows_within_its_bound() {
        let at = |speed: f64, rate: f64| INPUT.acceleration(&Wanted { speed, rate }, 20.0);
        assert_eq!([at(20.0, 0.0), at(20.0, 1.5), at(20.5, 0.0), at(19.5, 0.25)], [0.0, 1.5, 1.0, -0.75]);
        assert_eq!([at(30.0, 0.0), at(-30.0, 0.0), at(20.0, 7.0), at(f64::INFINITY, 0.0)], [2.0, -2.0, 2.0, 2.0]);
        let slope = |speed: f64, rate: f64| INPUT.slope(&Wanted { speed, rate }, 20.0);
        assert_eq!([slope(20.0, 0.0), slope(20.5, 0.5), slope(30.0, 0.0), slope(19.5, -7.0)], [-2.0, -2.0, 0.0, 0.0]);
    }
}
