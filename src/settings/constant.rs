//! Numbers that may be set after a scene is read and before it runs: what a parameter is called and where it is read and written.

use crate::units::Unit;

/// A number of a `T`. A table of these is all that `T` says about its parameters: what shows them takes them from there.
pub struct Constant<T: 'static> {
    /// Fixed among those of `T` (0 to 49): it stays whatever else there is.
    pub number: u32,
    /// As variables are called, appended to the name of the part.
    pub name: &'static str,
    pub unit: Unit,
    /// Smallest value.
    pub least: Option<f64>,
    /// May it change during a run? Then it only says which force follows from a motion: no mass, no place, no start depends on it.
    pub tunable: bool,
    pub description: &'static str,
    /// `None`: this one has no such number.
    pub get: fn(&T) -> Option<f64>,
    pub set: fn(&mut T, f64),
}

/// The same of one `T`, with its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number {
    pub number: u32,
    pub name: &'static str,
    pub unit: Unit,
    pub least: Option<f64>,
    pub tunable: bool,
    pub description: &'static str,
    pub value: f64,
}

impl<T> Constant<T> {
    /// All numbers that `of` has.
    pub fn read(table: &[Constant<T>], of: &T) -> Vec<Number> {
        let number = |line: &Constant<T>| {
            let Constant { number, name, unit, least, tunable, description, get, .. } = *line;
            Some(Number { number, name, unit, least, tunable, description, value: get(of)? })
        };
        table.iter().filter_map(number).collect()
    }

    /// Sets one of them; a number that is not in the table changes nothing.
    pub fn write(table: &[Constant<T>], of: &mut T, number: u32, value: f64) {
        if let Some(line) = table.iter().find(|line| line.number == number) {
            (line.set)(of, value);
        }
    }
}

/// What has numbers that may be set: a table says which.
pub trait Numbered: Sized + 'static {
    const CONSTANTS: &'static [Constant<Self>] = &[];

    /// All that this one has.
    fn numbers(&self) -> Vec<Number> {
        Constant::read(Self::CONSTANTS, self)
    }

    /// Sets the one of that [`Number::number`]; a number that it has not changes nothing.
    fn set_number(&mut self, number: u32, value: f64) {
        Constant::write(Self::CONSTANTS, self, number, value);
    }
}

/// A line of a table: `tunable` where it may change during a run, number, name, unit, smallest value, description, and the field that it is, or
/// where it is read and how it is written.
macro_rules! constant {
    (tunable $($line:tt)+) => {
        $crate::settings::Constant { tunable: true, ..$crate::settings::constant!($($line)+) }
    };
    ($number:literal, $name:literal, $unit:ident, $least:expr, $text:expr, get: $get:expr, set: $set:expr) => {
        $crate::settings::Constant {
            number: $number,
            name: $name,
            unit: $crate::units::Unit::$unit,
            least: $least,
            tunable: false,
            description: $text,
            get: $get,
            set: $set,
        }
    };
    ($number:literal, $name:literal, $unit:ident, $least:expr, $text:expr, $($field:tt)+) => {
        constant!($number, $name, $unit, $least, $text, get: |of| Some(of.$($field)+), set: |of, value| of.$($field)+ = value)
    };
}
pub(crate) use constant;
