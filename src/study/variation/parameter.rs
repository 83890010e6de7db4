//! `KEY=VALUES` of a sweep: one value, a list, a range with a step, or a range to draw from.
//!
//! ```text
//! a=3                       one value for all runs
//! a=1,2,5   a=x,y           a list; commas within brackets belong to a value
//! a=1..10:1                 from 1 to 10 every 1
//! a=90,110 km/h             numbers whose last alone has a unit: it counts for all
//! a=72..430:18 km/h         a unit at the end counts for all three, as in `wheelrail modes --sweep`
//! a=0.1..0.5                a range without step: for --latin alone
//! ```

use crate::study::digits::rounded;

/// Values of one key of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    pub key: String,
    pub values: Values,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Words or numbers, with their units, as written. One: the same in all runs.
    List(Vec<String>),
    /// Numbers of one unit, to draw from.
    Range { from: f64, to: f64, unit: String },
}

/// Why a parameter can't be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("--set {text}: {problem}")]
pub struct ParameterError {
    pub text: String,
    pub problem: String,
}

/// Most values of one parameter.
const MOST: f64 = 1e5;

impl Parameter {
    /// Reads `KEY=VALUES`.
    ///
    /// # Errors
    /// [`ParameterError`].
    pub fn parse(text: &str) -> Result<Parameter, ParameterError> {
        let wrong = |problem: String| ParameterError { text: text.into(), problem };
        let (key, values) = text.split_once('=').ok_or_else(|| wrong("expected KEY=VALUES, such as vehicle.speed=20..40:5".into()))?;
        let (key, values) = (key.trim().to_string(), values.trim());
        if key.is_empty() || values.is_empty() {
            return Err(wrong("expected KEY=VALUES, such as vehicle.speed=20..40:5".into()));
        }
        let values = match values.split_once("..").filter(|(from, _)| number(from).is_some()) {
            Some((from, rest)) => range(from, rest).map_err(wrong)?,
            None => Values::List(of_one_unit(list(values))),
        };
        Ok(Parameter { key, values })
    }

    /// Is there anything to choose?
    pub fn varies(&self) -> bool {
        !matches!(&self.values, Values::List(values) if values.len() == 1)
    }

    /// Unit of all its numbers, where they are numbers of one unit ("" for plain numbers).
    pub fn unit(&self) -> Option<&str> {
        match &self.values {
            Values::Range { unit, .. } => Some(unit),
            Values::List(values) => {
                let (_, first) = number(values.first()?)?;
                values.iter().all(|value| number(value).is_some_and(|(_, unit)| unit == first)).then_some(first)
            }
        }
    }
}

/// The number and the unit of a value as written; `None` of words.
pub fn number(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let is_part = |(at, c): &(usize, char)| {
        let exponent = (*c == 'e' || *c == 'E') && text[at + 1..].starts_with(|d: char| d.is_ascii_digit() || d == '-' || d == '+');
        !(c.is_ascii_digit() || ".+-".contains(*c) || exponent)
    };
    let end = text.char_indices().find(is_part).map_or(text.len(), |(at, _)| at);
    let value: f64 = text[..end].trim().parse().ok()?;
    let unit = text[end..].trim();
    // 60e1 and 1:40 are names, 3x is none.
    (value.is_finite() && !unit.starts_with([':', '_'])).then_some((value, unit))
}

/// Commas that stand in no bracket and no quotes.
fn list(text: &str) -> Vec<String> {
    let (mut depth, mut quoted) = (0, false);
    let mut parts = vec![String::new()];
    for c in text.chars() {
        match c {
            '"' => quoted = !quoted,
            '[' | '{' if !quoted => depth += 1,
            ']' | '}' if !quoted => depth -= 1,
            ',' if depth == 0 && !quoted => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(last) = parts.last_mut() {
            last.push(c);
        }
    }
    parts.into_iter().map(|part| part.trim().to_string()).filter(|part| !part.is_empty()).collect()
}

/// Numbers of which the last alone has a unit have that one, as those of a range.
fn of_one_unit(mut values: Vec<String>) -> Vec<String> {
    let units: Option<Vec<&str>> = values.iter().map(|value| Some(number(value)?.1)).collect();
    if let Some([bare @ .., unit]) = units.as_deref()
        && !unit.is_empty()
        && bare.iter().all(|unit| unit.is_empty())
    {
        let unit = unit.to_string();
        let last = values.len() - 1;
        values[..last].iter_mut().for_each(|value| *value = format!("{value} {unit}"));
    }
    values
}

fn range(from: &str, rest: &str) -> Result<Values, String> {
    let (to, step) = match rest.split_once(':') {
        Some((to, step)) => (to, Some(step)),
        None => (rest, None),
    };
    fn read(part: &str) -> Result<(f64, &str), String> {
        let wrong = || format!("{}: expected FROM..TO:STEP, such as 20..40:5 or 72..144:18 km/h", part.trim());
        number(part).ok_or_else(wrong)
    }
    let last = read(step.unwrap_or(to))?;
    let unit = last.1;
    let same = |part: &str| {
        let (value, own) = read(part)?;
        if own.is_empty() || own == unit { Ok(value) } else { Err(format!("{}: one unit for all, found {own} beside {unit}", part.trim())) }
    };
    let (from, to) = (same(from)?, same(to)?);
    if !(from <= to) {
        return Err(format!("from {from} to {to}: expected a range that grows"));
    }
    let Some(_) = step else { return Ok(Values::Range { from, to, unit: unit.into() }) };
    let step = last.0;
    let count = (to - from) / step;
    if !(step > 0.0 && count < MOST) {
        return Err(format!("a step of {step} from {from} to {to}: expected one above 0, and fewer than {MOST} values"));
    }
    let values = (0..=(count + 1e-9).floor() as usize).map(|k| written(from + step * k as f64, unit));
    Ok(Values::List(values.collect()))
}

/// A number with its unit, without what sums of steps leave behind.
pub fn written(value: f64, unit: &str) -> String {
    let value: f64 = format!("{value:.11e}").parse().unwrap_or(value);
    format!("{} {unit}", plain(value)).trim_end().into()
}

/// For words: six digits.
pub fn shown(value: f64) -> String {
    plain(rounded(value))
}

/// Without a row of zeros.
fn plain(value: f64) -> String {
    if value == 0.0 || (1e-4..1e9).contains(&value.abs()) { format!("{value}") } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<String> {
        match Parameter::parse(text).unwrap().values {
            Values::List(values) => values,
            Values::Range { from, to, unit } => vec![format!("{from}~{to} {unit}")],
        }
    }

    #[test]
    fn prop_values_are_read_as_modes_reads_them() {
        assert_eq!(values("a=1..3:1"), ["1", "2", "3"]);
        assert_eq!(values("a = 0.1..0.45:0.1"), ["0.1", "0.2", "0.3", "0.4"]);
        assert_eq!(values("vehicle.speed=72..108:18 km/h"), ["72 km/h", "90 km/h", "108 km/h"]);
        assert_eq!(values("vehicle.speed=72km/h..108km/h:18km/h").len(), 3);
        assert_eq!(values("k=1e6..3e6:1e6 N/m"), ["1000000 N/m", "2000000 N/m", "3000000 N/m"]);
        assert_eq!(values("a=x, y"), ["x", "y"]);
        assert_eq!(values("a=[1,2],[3,4]"), ["[1,2]", "[3,4]"]);
        assert_eq!(values("a=\"x,y\",z"), ["\"x,y\"", "z"]);
        assert_eq!(values("a=-2..2 mm"), ["-2~2 mm"]);
        assert_eq!((values("file=../wheel.csv"), values("a=x..y:1")), (vec!["../wheel.csv".into()], vec!["x..y:1".into()]));
        for wrong in ["a", "a=", "=1", "a=1..x:1", "a=3..1:1", "a=1..3:0", "a=1..3:-1", "a=1 m..3 mm:1 mm", "a=0..1:1e-9"] {
            assert!(Parameter::parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn prop_units_of_lists() {
        let unit = |text: &str| Parameter::parse(text).unwrap().unit().map(str::to_string);
        assert_eq!(unit("a=1 mm,2 mm"), Some("mm".into()));
        assert_eq!(
            (values("a=90,110 km/h"), values("a=1,2 mm,3")),
            (vec!["90 km/h".into(), "110 km/h".into()], vec!["1".into(), "2 mm".into(), "3".into()])
        );
        assert_eq!(
            (values("a=x,2 mm"), values("a=2 mm"), values("a=1:20,1:40")),
            (vec!["x".into(), "2 mm".into()], vec!["2 mm".into()], vec!["1:20".into(), "1:40".into()])
        );
        assert_eq!((unit("a=1,2"), unit("a=1 mm,2 m"), unit("a=ACCF,ECCF"), unit("a=1:20,1:40")), (Some("".into()), None, None, None));
        assert!(Parameter::parse("a=1,2").unwrap().varies() && !Parameter::parse("a=1").unwrap().varies());
    }
}
