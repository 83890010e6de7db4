//! How a strip carries of which a patch covers a part.
//!
//! It is two springs beside each other: one feels the mean overlap over the whole width and has `1 - c` of the strip's stiffness, the other the mean over what
//! is in contact and has c of it; none of them pulls. With the load Q of the strip, its influence K on itself and what it feels of the others, o,
//!
//! ```text
//! K Q = (1 - c) max(0, d_whole - o) + c max(0, d_pressed - o)
//! ```
//!
//! c grows smoothly from 0 to 1 with the part that is covered. So a strip that a patch reaches carries from the first on, and nothing jumps. As a whole, until it
//! overlaps on average, it came in late, by a fourth of its width, and then fast: forces changed by up to 14 % more or less over hundredths of a millimetre than over tenths.

use super::lengths::Cover;
use super::pressed::Pressed;

/// The springs of one strip. Overlaps are less what the lengths take, over the compliance, N/m.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bearing {
    whole: f64,
    pressed: f64,
    cut: f64,
    /// Does the whole carry?
    both: bool,
}

impl Bearing {
    pub fn new(own: &Pressed, cover: &Cover, compliance: f64) -> Bearing {
        let less = own.strip.curvature * own.half_length * own.half_length / 8.0;
        let of = |overlap: f64| (overlap - less) / compliance;
        Bearing { whole: of(cover.whole), pressed: of(cover.pressed), cut: cover.cut, both: cover.above || !(cover.cut > 0.0) }
    }

    /// By what the springs that carry are pressed together, N/m.
    pub fn wanted(&self) -> f64 {
        if self.both { self.whole + self.cut * (self.pressed - self.whole) } else { self.pressed }
    }

    /// The strip's stiffness in parts.
    pub fn stiffness(&self) -> f64 {
        if self.both { 1.0 } else { self.cut }
    }

    /// Sets whether the whole carries from the load [N] that was found with the `influence` [1/m] of the strip on itself; is that something else than before?
    pub fn settle(&mut self, load: f64, influence: f64) -> bool {
        if !(self.cut > 0.0 && self.cut < 1.0) {
            return false;
        }
        let others = self.wanted() - load * influence / self.stiffness();
        let before = std::mem::replace(&mut self.both, self.whole > others);
        self.both != before
    }

    /// Twice what both springs hold beyond half of their load times the overlap that they share, over the compliance, N^2/m: each is pressed by its own.
    pub fn apart(&self, influence: f64) -> f64 {
        let (apart, cut) = (self.pressed - self.whole, self.cut);
        if self.both { cut * (1.0 - cut) * apart * apart / influence } else { 0.0 }
    }

    /// A strip that comes back does so over the part that is in contact.
    pub fn leave(&mut self) {
        self.both = !(self.cut > 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Load of a strip alone that feels so much of others.
    fn load(cut: f64, others: f64) -> f64 {
        let cover = Cover { whole: -2e-6, pressed: 1e-6, cut, above: false };
        let mut own = Bearing::new(&Pressed::default(), &cover, 1.0);
        let mut load = 0.0;
        for _ in 0..4 {
            load = own.stiffness() * (own.wanted() - others) / 3.0;
            if !own.settle(load, 3.0) {
                break;
            }
        }
        load
    }

    #[test]
    fn analytic_each_spring_holds_half_of_its_load_times_its_overlap() {
        let cover = Cover { whole: 2e-6, pressed: 5e-6, cut: 0.3, above: true };
        let own = Bearing::new(&Pressed::default(), &cover, 1.0);
        let [whole, pressed] = [0.7 * 2e-6 / 3.0, 0.3 * 5e-6 / 3.0];
        let held = (whole + pressed) * own.wanted() + own.apart(3.0);
        assert!((held / (whole * 2e-6 + pressed * 5e-6) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn analytic_two_springs_carry_and_none_pulls() {
        for cut in [1e-9, 0.2, 0.7, 1.0 - 1e-9] {
            for others in [-9e-6f64, -3e-6, -2e-6, -1.9e-6, 0.0, 0.9e-6] {
                let whole = (1.0 - cut) * (-2e-6 - others).max(0.0);
                let pressed = cut * (1e-6 - others).max(0.0);
                assert!((load(cut, others) - (whole + pressed) / 3.0).abs() < 1e-20, "{cut} {others}");
            }
        }
    }
}
