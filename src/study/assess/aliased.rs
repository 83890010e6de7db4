//! Are rows near enough to each other? Forces between rows are not seen: a wheel that strikes its rail for 2 ms is a peak, or nothing, of rows every 5 ms.
//!
//! The same values of every other row tell: where they are others, rows twice as near may be others again. Content above half the sampling rate of either is what the
//! filters of EN 14363 can't take out afterwards.

use super::known::Known;
use super::signals::Signals;
use super::{Assessment, Row};

/// Values of forces that must not hang on the rows.
const FORCES: [&str; 8] = ["sum_y", "y_over_q", "sum_y_rms", "nadal", "unloading", "q_max", "y_qst", "q_qst"];
/// Part of the value, and of its limit, by which that of every other row may be another one.
const ALIKE: f64 = 0.03;
const OF_LIMIT: f64 = 0.01;

/// A value that hangs on the distance of rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Aliased {
    pub name: &'static str,
    /// From all rows and from every other one, in the quantity's shown `unit`.
    pub value: f64,
    pub of_half: f64,
    pub unit: &'static str,
    pub digits: usize,
}

impl std::fmt::Display for Aliased {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Aliased { name, value, of_half, unit, digits } = self;
        let unit = if *unit == "-" { String::new() } else { format!(" {unit}") };
        write!(f, "{name}: {value:.digits$}{unit}, of every other row {of_half:.digits$}{unit}")
    }
}

/// The values of `found` that are others where every other row is left out, those that differ most first.
pub fn aliased(signals: &Signals, known: &Known, found: &Assessment) -> Vec<Aliased> {
    let Some(half) = signals.every_other().and_then(|half| Assessment::of(&half, known).ok()) else { return Vec::new() };
    let mut differ: Vec<(f64, Aliased)> = found.rows.iter().filter_map(|row| differing(row, &half)).collect();
    differ.sort_by(|a, b| b.0.total_cmp(&a.0));
    differ.into_iter().map(|one| one.1).collect()
}

fn differing(row: &Row, half: &Assessment) -> Option<(f64, Aliased)> {
    let value = row.value.filter(|_| FORCES.contains(&row.key))?;
    let of_half = half.rows.iter().find(|other| other.key == row.key && other.zone == row.zone)?.value?;
    let off = (value - of_half).abs();
    let allowed = (ALIKE * value.abs()).max(OF_LIMIT * row.limit.unwrap_or(0.0).abs());
    let quantity = row.quantity;
    let shown = |value: f64| quantity.factor * value;
    (off > allowed).then(|| {
        let aliased =
            Aliased { name: quantity.name, value: shown(value), of_half: shown(of_half), unit: quantity.unit, digits: quantity.digits };
        (off / allowed, aliased)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write;

    /// A wheelset at 20 m/s whose right wheel is struck for `width` seconds every 0.31 s.
    fn assessed(width: f64, interval: f64) -> (Signals, Assessment) {
        let mut text = String::from(
            "time [s],wheelset.distance [m],wheelset.left.lateralForce [N],wheelset.right.lateralForce [N],wheelset.left.verticalForce [N],wheelset.right.verticalForce [N]\n",
        );
        for k in 0..(20.0 / interval) as usize {
            let t = interval * k as f64;
            let since = t % 0.31;
            let load = 50e3 + if since < width { 200e3 * (std::f64::consts::PI * since / width).sin() } else { 0.0 };
            writeln!(text, "{t},{},1000,-1000,50000,{load}", 20.0 * t).unwrap();
        }
        let signals = Signals::read(text.as_bytes()).unwrap();
        let found = Assessment::of(&signals, &Known::default()).unwrap();
        (signals, found)
    }

    #[test]
    fn prop_short_impacts_between_rows_are_noticed_and_slow_ones_are_not() {
        let noticed = |width: f64, interval: f64| {
            let (signals, found) = assessed(width, interval);
            aliased(&signals, &Known::default(), &found)
        };
        let short = noticed(3e-3, 2e-3);
        assert!(!short.is_empty(), "nothing noticed");
        assert!(short[0].to_string().contains("of every other row"), "{}", short[0]);
        assert_eq!(noticed(0.15, 2e-3), []);
        assert_eq!(noticed(3e-3, 1e-4), []);
    }
}
