//! Peaks of a quantity that swings about its mean, half swing by half swing: what each keeps of the one before on its side tells whether a swing grows, lasts or fades.

use serde::{Deserialize, Serialize};

/// A peak that is so many times the one before begins another swing.
const ANEW: f64 = 1.5;

/// Peaks on either side (above: second); part of a simulation's state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct HalfSwings {
    above: bool,
    /// Of the present half swing.
    peak: f64,
    sides: [Side; 2],
}

/// The last whole half swing on one side, and what it and the one before kept of those before them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Side {
    peak: Option<f64>,
    kept: [Option<f64>; 2],
}

impl HalfSwings {
    pub fn note(&mut self, from_mean: f64) {
        let above = from_mean > 0.0;
        if above != self.above {
            let side = &mut self.sides[usize::from(self.above)];
            let kept = side.peak.map(|last| self.peak / last).filter(|kept| *kept < ANEW);
            *side = Side { peak: Some(self.peak), kept: [kept, side.kept[0].filter(|_| kept.is_some())] };
            *self = HalfSwings { above, peak: 0.0, ..*self };
        }
        self.peak = self.peak.max(from_mean.abs());
        let side = &mut self.sides[usize::from(above)];
        if side.peak.is_some_and(|last| self.peak > ANEW * last) {
            side.kept = [None; 2];
        }
    }

    /// What peaks keep of those before, the less of two in a row, the more of both sides; `None` where no swing is known. One that lasts has kept its peaks twice, on one side at
    /// least: what is only led aside and back has not.
    pub fn kept(&self) -> Option<f64> {
        let lasting = |side: &Side| side.kept[0].zip(side.kept[1]).map(|(now, before)| now.min(before));
        self.sides.iter().filter_map(lasting).reduce(f64::max)
    }

    /// Did the last peak on either side, and what is known of the present one, keep less than `part` of the one before?
    pub fn fade(&self, part: f64) -> bool {
        let present = &self.sides[usize::from(self.above)];
        present.peak.is_some_and(|last| self.peak < part * last)
            && self.sides.iter().all(|side| side.kept[0].is_some_and(|kept| kept < part))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Does a swing that grows by `rate` [1/s], 4 Hz about `mean`, fade after three seconds?
    fn fades(rate: f64, mean: f64) -> bool {
        let mut swings = HalfSwings::default();
        (0..600).for_each(|i| {
            let t = 0.005 * f64::from(i);
            swings.note(mean + (rate * t).exp() * (std::f64::consts::TAU * 4.0 * t).sin());
        });
        swings.fade(0.98)
    }

    #[test]
    fn analytic_a_swing_fades_when_its_peaks_do() {
        assert!(fades(-0.2, 0.0) && fades(-1.0, 0.02) && fades(-1.0, -0.02));
        assert!(!fades(0.2, 0.0) && !fades(1.0, 0.5), "grows");
        assert!(!fades(0.0, 0.0), "a limit cycle");
        assert!(!fades(-1.0, 2.0), "it never came back");
    }
}
