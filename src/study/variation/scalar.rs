//! `KIND:PATTERN`: one number of a run.
//!
//! Kinds: `min`, `max`, `absmax`, `mean`, `rms`, `end`, and percentiles `p0.15`, `p50`, `p99.85` ... (any from 0 to 100). PATTERN names outputs as `run --columns` does
//! (`*` any letters, `?` one); of several outputs all values count together, so that `max:*.verticalForce` is the largest Q of all wheels. Values are
//! taken at equal intervals of time; the first row counts.

use crate::sim::outputs::Output;
use crate::sim::pattern::matches;
use crate::sim::recording::Recording;
use crate::study::assess::statistics::percentile;

/// What is made of the values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Min,
    Max,
    AbsMax,
    Mean,
    Rms,
    End,
    /// %.
    Percentile(f64),
}

/// A number of each run.
#[derive(Clone, Debug, PartialEq)]
pub struct Scalar {
    pub kind: Kind,
    pub pattern: String,
    /// As written.
    pub text: String,
}

/// Why a scalar can't be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScalarError {
    #[error(
        "--scalar {text}: expected KIND:OUTPUT, such as max:*.verticalForce; KIND is min, max, absmax, mean, rms, end or p99.85 (a percentile)"
    )]
    Unknown { text: String },
    #[error("--scalar {text}: no output of that name; the scene shows {all}, such as {some} (interface.outputs adds groups)")]
    NoOutput { text: String, all: usize, some: String },
    #[error("--scalar {text}: outputs of different units, {first} and {second}")]
    Units { text: String, first: String, second: String },
}

impl Scalar {
    /// Reads `KIND:PATTERN`.
    ///
    /// # Errors
    /// [`ScalarError`].
    pub fn parse(text: &str) -> Result<Scalar, ScalarError> {
        let unknown = || ScalarError::Unknown { text: text.into() };
        let (kind, pattern) = text.trim().split_once(':').ok_or_else(unknown)?;
        let kind = match kind.trim() {
            "min" => Kind::Min,
            "max" => Kind::Max,
            "absmax" => Kind::AbsMax,
            "mean" => Kind::Mean,
            "rms" => Kind::Rms,
            "end" => Kind::End,
            other => {
                let percent: Option<f64> = other.strip_prefix('p').and_then(|number| number.parse().ok());
                Kind::Percentile(percent.filter(|percent| (0.0..=100.0).contains(percent)).ok_or_else(unknown)?)
            }
        };
        let pattern = pattern.trim().to_string();
        if pattern.is_empty() { Err(unknown()) } else { Ok(Scalar { kind, pattern, text: text.trim().into() }) }
    }

    /// The unit of its outputs.
    ///
    /// # Errors
    /// [`ScalarError`] without outputs, or with several units.
    pub fn unit(&self, outputs: &[Output]) -> Result<&'static str, ScalarError> {
        let mut found = outputs.iter().filter(|output| matches(&self.pattern, &output.name));
        let text = self.text.clone();
        let Some(first) = found.next() else {
            let some = outputs.iter().take(3).map(|output| output.name.as_str()).collect::<Vec<_>>().join(", ");
            return Err(ScalarError::NoOutput { text, all: outputs.len(), some });
        };
        match found.find(|output| output.unit.name() != first.unit.name()) {
            Some(other) => Err(ScalarError::Units { text, first: first.name.clone(), second: other.name.clone() }),
            None => Ok(first.unit.name()),
        }
    }

    /// Its value in a recording; `None` where there are no such outputs or no rows.
    pub fn of(&self, recording: &Recording) -> Option<f64> {
        let columns: Vec<usize> =
            (1..recording.columns.len()).filter(|index| matches(&self.pattern, &recording.columns[*index].0)).collect();
        let all = || recording.rows.iter().flat_map(|row| columns.iter().map(|column| row[*column]));
        let count = (columns.len() * recording.rows.len()) as f64;
        let value = match self.kind {
            Kind::Min => all().reduce(f64::min)?,
            Kind::Max => all().reduce(f64::max)?,
            Kind::AbsMax => all().map(f64::abs).reduce(f64::max)?,
            Kind::Mean => all().sum::<f64>() / count,
            Kind::Rms => (all().map(|value| value * value).sum::<f64>() / count).sqrt(),
            Kind::End => {
                let last = recording.rows.last()?;
                columns.iter().map(|column| last[*column]).reduce(|a, b| if b.abs() > a.abs() { b } else { a })?
            }
            Kind::Percentile(percent) => percentile(&all().collect::<Vec<_>>(), percent)?,
        };
        Some(value).filter(|value| value.is_finite())
    }
}

/// Scalars where none are asked for: those that the scene has outputs for.
pub fn defaults(leading: &str, outputs: &[Output]) -> Vec<Scalar> {
    let lines = [
        "p99.85:*.derailmentQuotient".to_string(),
        "max:*.verticalForce".into(),
        "min:*.verticalForce".into(),
        "absmax:*.trackShiftingForce".into(),
        format!("absmax:{leading}.y"),
        format!("rms:{leading}.y"),
        "max:*.wearNumber".into(),
    ];
    let mut found: Vec<Scalar> = lines.iter().filter_map(|line| Scalar::parse(line).ok()).collect();
    // Accelerations of sensors, not those of wheelsets.
    let sensors =
        outputs.iter().filter(|output| output.group == "sensors" && (output.name.ends_with(".ay") || output.name.ends_with(".az")));
    found.extend(sensors.filter_map(|output| Scalar::parse(&format!("rms:{}", output.name)).ok()));
    found.retain(|scalar| scalar.unit(outputs).is_ok());
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Option<f64> {
        let columns = ["time", "a.x", "b.x", "c.y"].map(|name| (name.to_string(), "m")).into();
        let rows = vec![vec![0.0, 1.0, -4.0, 7.0], vec![1.0, 2.0, 3.0, 8.0]];
        Scalar::parse(text).unwrap().of(&Recording { columns, rows, notes: vec![] })
    }

    #[test]
    fn analytic_scalars_of_four_values() {
        let found = ["min:*.x", "max:*.x", "absmax:?.x", "mean:*.x", "end:*.x", "p50:*.x", "max:c.y"].map(|text| value(text).unwrap());
        assert_eq!(found, [-4.0, 3.0, 4.0, 0.5, 3.0, 1.5, 8.0]);
        assert!((value("rms:*.x").unwrap() - 7.5_f64.sqrt()).abs() < 1e-15);
        assert_eq!(["max:d", "mean:d", "rms:d", "p1:d", "end:d"].map(value), [None; 5]);
        for wrong in ["max", "most:a", "p101:a", "p:a", "max:", "p-1:a"] {
            assert!(Scalar::parse(wrong).is_err(), "{wrong}");
        }
    }
}
