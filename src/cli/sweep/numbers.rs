//! What a sweep keeps of each run: scalars, and expressions of them.
//!
//! `NAME = EXPRESSION` or `NAME [UNIT] = EXPRESSION`, with scalars in braces: `unloading = 1 - {min:*.verticalForce} / {mean:*.verticalForce}`. A number that
//! an expression needs and a run does not have, or one that is not finite, leaves nothing.

use crate::cli::Failure;
use crate::sim::outputs::Output;
use crate::study::variation::scalar::{self, Scalar};
use exmex::prelude::*;
use exmex::{FloatOpsFactory, MatchLiteral, literal_matcher_from_pattern};

literal_matcher_from_pattern!(Decimal, r"^([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?");

/// Of numbers as people write them: the crate's own know no exponents.
type Expression = FlatEx<f64, FloatOpsFactory<f64>, Decimal>;

/// A column of the table.
pub(super) struct Number {
    pub name: String,
    pub unit: String,
    made: Made,
}

enum Made {
    /// One of the scalars.
    Scalar(usize),
    /// Of these scalars, in the order in which it takes them.
    Expression(Box<Expression>, Vec<usize>),
}

pub(super) struct Numbers {
    /// All that each run is asked for.
    pub scalars: Vec<Scalar>,
    pub shown: Vec<Number>,
}

/// Columns that every table of a sweep has.
const FIXED: [&str; 5] = ["run", "state", "time", "reason", "scene"];

impl Numbers {
    /// From what `--scalar` says; without it the usual ones of a vehicle with this leading wheelset.
    ///
    /// # Errors
    /// [`Failure::Input`] where one is none, or the scene shows no such outputs.
    pub fn new(texts: &[String], leading: &str, outputs: &[Output]) -> Result<Numbers, Failure> {
        let mut numbers = Numbers { scalars: Vec::new(), shown: Vec::new() };
        if texts.is_empty() {
            scalar::defaults(leading, outputs).into_iter().try_for_each(|scalar| numbers.show(scalar, outputs))?;
        }
        for text in texts {
            match text.split_once('=') {
                Some((name, expression)) => numbers.show_expression(text, name.trim(), expression, outputs)?,
                None => numbers.show(parse(text)?, outputs)?,
            }
        }
        if numbers.shown.is_empty() {
            let problem = "the scene shows no outputs that sweeps keep numbers of: --scalar KIND:OUTPUT, or more in interface.outputs";
            return Err(Failure::Input(problem.into()));
        }
        for (place, number) in numbers.shown.iter().enumerate() {
            if numbers.shown[..place].iter().any(|other| other.name == number.name) {
                return Err(Failure::Input(format!("--scalar: {} is there twice; expected names that differ", number.name)));
            }
        }
        Ok(numbers)
    }

    /// The place of a scalar among those that runs are asked for, and its unit.
    fn place(&mut self, scalar: Scalar, outputs: &[Output]) -> Result<(usize, &'static str), Failure> {
        let unit = scalar.unit(outputs).map_err(|error| Failure::Input(error.to_string()))?;
        let known = self.scalars.iter().position(|known| *known == scalar);
        Ok((
            known.unwrap_or_else(|| {
                self.scalars.push(scalar);
                self.scalars.len() - 1
            }),
            unit,
        ))
    }

    fn show(&mut self, scalar: Scalar, outputs: &[Output]) -> Result<(), Failure> {
        let name = scalar.text.clone();
        let (place, unit) = self.place(scalar, outputs)?;
        self.shown.push(Number { name, unit: unit.into(), made: Made::Scalar(place) });
        Ok(())
    }

    fn show_expression(&mut self, text: &str, name: &str, expression: &str, outputs: &[Output]) -> Result<(), Failure> {
        let wrong = |problem: &str| Failure::Input(format!("--scalar {text}: {problem}"));
        let (name, unit) = match name.strip_suffix(']').and_then(|name| name.split_once('[')) {
            Some((name, unit)) => (name.trim(), unit.trim()),
            None => (name, ""),
        };
        if name.is_empty() {
            return Err(wrong("the expression has no name; expected NAME = EXPRESSION"));
        }
        if FIXED.contains(&name) {
            return Err(wrong(&format!("\"{name}\" is a column of every sweep; expected another name")));
        }
        // A scalar alone needs no braces.
        if let Ok(scalar) = Scalar::parse(expression.trim()) {
            let (place, own) = self.place(scalar, outputs)?;
            let unit = if unit.is_empty() { own } else { unit };
            self.shown.push(Number { name: name.into(), unit: unit.into(), made: Made::Scalar(place) });
            return Ok(());
        }
        if expression.matches('{').count() != expression.matches('}').count() {
            return Err(wrong("braces do not pair; expected {KIND:OUTPUT}"));
        }
        let parsed = Expression::parse(expression).map_err(|error| wrong(problem(&error.to_string())))?;
        let mut of = Vec::new();
        for variable in parsed.var_names() {
            if !expression.contains(&format!("{{{variable}}}")) {
                return Err(wrong(&format!("{variable} is no number; expected scalars in braces, such as {{max:*.verticalForce}}")));
            }
            of.push(self.place(parse(variable)?, outputs)?.0);
        }
        self.shown.push(Number { name: name.into(), unit: unit.into(), made: Made::Expression(Box::new(parsed), of) });
        Ok(())
    }

    /// What is shown of a run with these scalars.
    pub fn of(&self, scalars: &[Option<f64>]) -> Vec<Option<f64>> {
        let value = |number: &Number| match &number.made {
            Made::Scalar(place) => scalars[*place],
            Made::Expression(expression, of) => {
                let known = of.iter().map(|place| scalars[*place]).collect::<Option<Vec<f64>>>()?;
                expression.eval(&known).ok().filter(|value| value.is_finite())
            }
        };
        self.shown.iter().map(value).collect()
    }
}

/// The first line of a message without what the parser held in its hands.
fn problem(message: &str) -> &str {
    let first = message.lines().next().unwrap_or_default();
    first.split(", Operator {").next().unwrap_or(first).trim()
}

fn parse(text: &str) -> Result<Scalar, Failure> {
    Scalar::parse(text).map_err(|error| Failure::Input(error.to_string()))
}
