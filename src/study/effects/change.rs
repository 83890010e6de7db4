//! How far a run with a changed effect is from the reference, and what of that the integration's own error hides.

use super::observed::{Observed, Quantity};
use crate::study::beside::beside;
use serde::Serialize;

/// Distance between two runs in one quantity, the worst of all wheelsets, wheels or bodies, SI.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Distance {
    pub largest: f64,
    /// Root mean square.
    pub rms: f64,
}

impl Distance {
    fn worse(self, other: Distance) -> Distance {
        Distance { largest: self.largest.max(other.largest), rms: self.rms.max(other.rms) }
    }
}

/// A change counts from so many times the integration's error on: the changed run has an error of its own.
const TOLD: f64 = 2.0;

/// A change, or the bound below which it hides.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    Told(f64),
    /// Below the error: no larger than this.
    Below(f64),
}

impl Change {
    fn of(change: f64, error: f64, rounding: f64) -> Change {
        let bound = (TOLD * error).max(rounding);
        if change > bound { Change::Told(change) } else { Change::Below(bound) }
    }

    /// The size of a change that is told.
    pub fn told(self) -> Option<f64> {
        if let Change::Told(size) = self { Some(size) } else { None }
    }
}

/// Change of one quantity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Changed {
    pub quantity: Quantity,
    /// SI.
    pub largest: Change,
    pub rms: Change,
    /// Largest change in parts of the largest size in the reference.
    pub share: Option<f64>,
}

/// Distance in a quantity; `None` where one run does not have it.
pub(super) fn distance(quantity: Quantity, a: &Observed, b: &Observed) -> Option<Distance> {
    let [one, other] = [a, b].map(|run| run.names[quantity as usize].iter().zip(&run.series[quantity as usize]));
    let reach = usize::from(quantity.jumps() && (a.rigid || b.rigid));
    let apart = |a: &[f64], b: &[f64]| {
        let count = a.len().min(b.len());
        let mut found = Distance::default();
        let mut squares = 0.0;
        for sample in 0..count {
            let off = beside(a[sample], b, sample, reach).max(beside(b[sample], a, sample, reach));
            found.largest = found.largest.max(off);
            squares += off * off;
        }
        Distance { rms: (squares / count.max(1) as f64).sqrt(), ..found }
    };
    let pairs = one.filter_map(|(name, a)| Some((a, other.clone().find(|(known, _)| *known == name)?.1)));
    pairs.map(|(a, b)| apart(a, b)).reduce(Distance::worse)
}

/// Changes of all quantities that there are, against the reference whose own integration is `errors` off.
pub(super) fn changes(reference: &Observed, changed: &Observed, errors: &[Option<Distance>]) -> Vec<Changed> {
    let of = |(quantity, error): (Quantity, &Option<Distance>)| {
        let (found, error) = (distance(quantity, reference, changed)?, error.unwrap_or_default());
        let size = reference.largest(quantity).filter(|size| *size > quantity.rounding());
        let largest = Change::of(found.largest, error.largest, quantity.rounding());
        Some(Changed {
            quantity,
            largest,
            rms: Change::of(found.rms, error.rms, quantity.rounding()),
            share: largest.told().zip(size).map(|(change, size)| change / size),
        })
    };
    Quantity::ALL.into_iter().zip(errors).filter_map(of).collect()
}

/// Swings of y smaller than this are none, m.
const SWING: f64 = 1e-5;
/// Swings to one side that a growth is read from.
const FEWEST: usize = 5;

/// Growth of hunting from `begin` [s] on, 1/s: slope of the logarithm of the leading wheelset's swings (from one extreme to the next) over time.
/// `None` for fewer than five swings.
pub(super) fn growth(run: &Observed, begin: f64) -> Option<f64> {
    let y = run.leading();
    let extreme = |k: &usize| (y[*k] - y[k - 1]) * (y[k + 1] - y[*k]) < 0.0 || (y[*k] == y[k - 1] && y[*k] != y[k + 1]);
    let places: Vec<usize> = (1..y.len().saturating_sub(1)).filter(|k| run.time[*k] >= begin).filter(extreme).collect();
    let swing = |pair: &[usize]| (0.5 * (run.time[pair[0]] + run.time[pair[1]]), (y[pair[1]] - y[pair[0]]).abs());
    let swings: Vec<(f64, f64)> = places.windows(2).map(swing).filter(|swing| swing.1 > SWING).map(|(t, size)| (t, size.ln())).collect();
    if swings.len() < FEWEST {
        return None;
    }
    let mean = |of: fn(&(f64, f64)) -> f64| swings.iter().map(of).sum::<f64>() / swings.len() as f64;
    let (t0, l0) = (mean(|swing| swing.0), mean(|swing| swing.1));
    let [num, den] = swings.iter().fold([0.0; 2], |[num, den], (t, l)| [num + (t - t0) * (l - l0), den + (t - t0) * (t - t0)]);
    Some(num / den)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(values: Vec<f64>) -> Observed {
        let mut run = Observed { time: (0..values.len()).map(|k| 1e-2 * k as f64).collect(), ..Observed::default() };
        run.series[0] = vec![values];
        run.names[0] = vec!["wheelset.y".into()];
        run
    }

    #[test]
    fn analytic_growth_is_that_of_a_growing_wave() {
        for growth_rate in [-0.7, 0.0, 0.4] {
            let wave = |k: usize| 1e-3 * (growth_rate * 1e-2 * k as f64).exp() * (2.0 * std::f64::consts::TAU * 1e-2 * k as f64).sin();
            let found = growth(&run((0..500).map(wave).collect()), 1.0).unwrap();
            assert!((found - growth_rate).abs() < 2e-3, "{found} {growth_rate}");
        }
        assert_eq!(growth(&run(vec![0.0; 500]), 0.0), None);
        assert_eq!(growth(&run((0..500).map(|k| 1e-5 * k as f64).collect()), 0.0), None);
    }

    #[test]
    fn analytic_changes_below_twice_the_error_are_not_told() {
        let reference = run(vec![0.0, 1e-3, -2e-3]);
        let error = [Some(Distance { largest: 1e-5, rms: 5e-6 }), None, None, None, None, None, None, None];
        let of = |values: Vec<f64>| changes(&reference, &run(values), &error)[0];
        let large = of(vec![0.0, 1e-3, -2.5e-3]);
        assert!((large.largest.told().unwrap() - 5e-4).abs() < 1e-18 && (large.share.unwrap() - 0.25).abs() < 1e-12);
        assert!((large.rms.told().unwrap() - 5e-4 / 3f64.sqrt()).abs() < 1e-15);
        let small = of(vec![0.0, 1.015e-3, -2e-3]);
        assert_eq!((small.largest, small.share), (Change::Below(2e-5), None));
        assert!(matches!(of(vec![0.0, f64::NAN, 0.0]).largest, Change::Told(size) if size.is_infinite()));
        // Without any error it is rounding that hides.
        let exact = changes(&reference, &run(vec![0.0, 1e-3, -2e-3 + 1e-12]), &[None; 8]);
        assert_eq!((exact[0].largest, exact.len()), (Change::Below(1e-9), 1));
    }
}
