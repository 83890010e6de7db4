//! Which runs a sweep makes of its parameters: every combination, or a Latin hypercube.
//!
//! Hypercube of N runs: each range is cut into N equal parts, each part is used once, at a random place in it, in an order of its own for each parameter; a list is
//! treated as equal shares of such a range. Source: M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21 (1979), 239-245. Random numbers: ChaCha8, the same
//! for the same seed on every machine.

use super::parameter::{Parameter, Values, written};
use crate::study::digits::rounded;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

/// Most runs of a sweep.
pub const MOST: usize = 1_000_000;

/// Why there are no runs.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DesignError {
    #[error("--set {key}=FROM..TO has no step: FROM..TO:STEP, or --latin N to draw from the range")]
    NoStep { key: String },
    #[error("{runs:.3e} runs; expected at most {MOST}: fewer values, or --latin N")]
    TooMany { runs: f64 },
    #[error("--set {key}: the key is given twice")]
    Twice { key: String },
}

/// The values of each run, in the parameters' order.
pub type Points = Vec<Vec<String>>;

/// Refuses a key that is given twice.
fn check(parameters: &[Parameter]) -> Result<(), DesignError> {
    let twice =
        parameters.iter().enumerate().find(|(index, parameter)| parameters[..*index].iter().any(|other| other.key == parameter.key));
    twice.map_or(Ok(()), |(_, parameter)| Err(DesignError::Twice { key: parameter.key.clone() }))
}

/// Every combination; the last parameter changes fastest.
///
/// # Errors
/// [`DesignError`].
pub fn grid(parameters: &[Parameter]) -> Result<Points, DesignError> {
    check(parameters)?;
    let mut lists = Vec::new();
    for parameter in parameters {
        match &parameter.values {
            Values::List(values) => lists.push(values),
            Values::Range { .. } => return Err(DesignError::NoStep { key: parameter.key.clone() }),
        }
    }
    let runs: f64 = lists.iter().map(|list| list.len() as f64).product();
    if runs > MOST as f64 {
        return Err(DesignError::TooMany { runs });
    }
    let mut points: Points = vec![Vec::new()];
    for list in lists {
        let longer = |point: &Vec<String>, value: &String| point.iter().chain([value]).cloned().collect::<Vec<_>>();
        points = points.iter().flat_map(|point| list.iter().map(move |value| longer(point, value))).collect();
    }
    Ok(points)
}

/// So many runs of a Latin hypercube.
///
/// # Errors
/// [`DesignError`].
pub fn latin(parameters: &[Parameter], runs: usize, seed: u64) -> Result<Points, DesignError> {
    check(parameters)?;
    if runs > MOST {
        return Err(DesignError::TooMany { runs: runs as f64 });
    }
    let mut dice = ChaCha8Rng::seed_from_u64(seed);
    // 53 bits: every number is exact.
    let mut uniform = || (dice.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let columns: Vec<Vec<String>> = parameters
        .iter()
        .map(|parameter| {
            let mut parts: Vec<usize> = (0..runs).collect();
            for k in (1..runs).rev() {
                parts.swap(k, (uniform() * (k + 1) as f64) as usize);
            }
            let shares: Vec<f64> = parts.into_iter().map(|part| (part as f64 + uniform()) / runs as f64).collect();
            let value = |share: f64| match &parameter.values {
                Values::List(values) => values[((share * values.len() as f64) as usize).min(values.len() - 1)].clone(),
                // Six digits: people read the table.
                Values::Range { from, to, unit } => written(rounded(from + share * (to - from)), unit),
            };
            shares.into_iter().map(value).collect()
        })
        .collect();
    Ok((0..runs).map(|run| columns.iter().map(|column| column[run].clone()).collect()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::variation::parameter::number;

    fn parameters(texts: &[&str]) -> Vec<Parameter> {
        texts.iter().map(|text| Parameter::parse(text).unwrap()).collect()
    }

    #[test]
    fn prop_a_grid_has_every_combination_once() {
        let points = grid(&parameters(&["a=1..3:1", "b=x,y", "c=7"])).unwrap();
        let shown: Vec<String> = points.iter().map(|point| point.join("")).collect();
        assert_eq!(shown, ["1x7", "1y7", "2x7", "2y7", "3x7", "3y7"]);
        assert_eq!(grid(&parameters(&["a=1..3"])), Err(DesignError::NoStep { key: "a".into() }));
        assert_eq!(grid(&parameters(&["a=1", "a=2"])), Err(DesignError::Twice { key: "a".into() }));
        assert!(matches!(grid(&parameters(&["a=1..9999:1", "b=1..9999:1"])), Err(DesignError::TooMany { .. })));
    }

    #[test]
    fn prop_each_part_of_each_range_is_used_once() {
        let all = parameters(&["a=10..20", "b=-1..1 mm", "c=x,y"]);
        let points = latin(&all, 40, 3).unwrap();
        for (column, (from, width)) in [(0, (10.0, 10.0)), (1, (-1.0, 2.0))] {
            let mut parts: Vec<usize> =
                points.iter().map(|point| ((number(&point[column]).unwrap().0 - from) / width * 40.0) as usize).collect();
            parts.sort_unstable();
            assert_eq!(parts, (0..40).collect::<Vec<_>>());
        }
        assert_eq!(points.iter().filter(|point| point[2] == "x").count(), 20);
        assert_eq!(points, latin(&all, 40, 3).unwrap());
        assert_ne!(points, latin(&all, 40, 4).unwrap());
    }
}
