//! Units: what a scene file may write ("3 deg", "10 mm", "90 km/h", "-3 in") becomes SI here, once.

mod unit;

pub use unit::Unit;

/// A physical dimension that a scene value can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    None,
    Length,
    Angle,
    Time,
    Speed,
    Acceleration,
    AngularSpeed,
    Mass,
    Inertia,
    Force,
    Torque,
    /// Force over the square of a speed.
    AirResistance,
    Stiffness,
    Damping,
    RotationalStiffness,
    RotationalDamping,
    /// Reciprocal of a speed: how a stop's force grows with the speed of pressing.
    PerSpeed,
    /// Factor of penetration times penetration speed in the paper's Eq. 28, N s/m2.
    PenetrationDamping,
    /// K_h of the paper's Eq. 28, N/m^1.5.
    ContactStiffness,
    Pressure,
    /// Of the track, 1/m; degrees are those of a chord of 100 ft.
    Curvature,
}

/// Unit names and their size in SI, the first one being the SI unit itself.
type Units = &'static [(&'static str, f64)];

const DEGREE: f64 = std::f64::consts::PI / 180.0;
const INCH: f64 = 0.0254;
const FOOT: f64 = 0.3048;
/// kg and N (international pound, standard gravity).
const POUND: f64 = 0.45359237;
const POUND_FORCE: f64 = POUND * 9.80665;
const KIP: f64 = 1e3 * POUND_FORCE;
/// Degrees of curvature; the size among the units is that of small ones.
const CHORD_DEGREE: &str = "deg";

impl Dimension {
    fn units(self) -> Units {
        match self {
            Dimension::None => &[("", 1.0), ("%", 0.01), ("‰", 1e-3), ("per mille", 1e-3)],
            Dimension::Length => &[("m", 1.0), ("mm", 1e-3), ("um", 1e-6), ("cm", 1e-2), ("km", 1e3), ("in", INCH), ("ft", FOOT)],
            Dimension::Angle => &[("rad", 1.0), ("mrad", 1e-3), ("deg", DEGREE)],
            Dimension::Time => &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6)],
            Dimension::Speed => &[("m/s", 1.0), ("mm/s", 1e-3), ("km/h", 1.0 / 3.6), ("mph", 0.44704)],
            Dimension::Acceleration => &[("m/s2", 1.0)],
            Dimension::AngularSpeed => &[("rad/s", 1.0), ("deg/s", DEGREE)],
            Dimension::Mass => &[("kg", 1.0), ("t", 1e3), ("lb", POUND)],
            Dimension::Inertia => &[("kg m2", 1.0), ("t m2", 1e3), ("lbf in s2", POUND_FORCE * INCH), ("lb ft2", POUND * FOOT * FOOT)],
            Dimension::Force => &[("N", 1.0), ("kN", 1e3), ("MN", 1e6), ("lbf", POUND_FORCE), ("kip", KIP)],
            Dimension::Torque => &[("N m", 1.0), ("kN m", 1e3), ("lbf ft", POUND_FORCE * FOOT), ("lbf in", POUND_FORCE * INCH)],
            Dimension::AirResistance => &[("kg/m", 1.0), ("N s2/m2", 1.0)],
            Dimension::Stiffness => &[
                ("N/m", 1.0),
                ("kN/m", 1e3),
                ("MN/m", 1e6),
                ("N/mm", 1e3),
                ("kN/mm", 1e6),
                ("lbf/in", POUND_FORCE / INCH),
                ("kip/in", KIP / INCH),
            ],
            Dimension::Damping => {
                &[("N s/m", 1.0), ("kN s/m", 1e3), ("N s/mm", 1e3), ("lbf s/in", POUND_FORCE / INCH), ("kip s/in", KIP / INCH)]
            }
            Dimension::RotationalStiffness => {
                &[("N m/rad", 1.0), ("kN m/rad", 1e3), ("MN m/rad", 1e6), ("lbf in/rad", POUND_FORCE * INCH), ("kip in/rad", KIP * INCH)]
            }
            Dimension::RotationalDamping => {
                &[("N m s/rad", 1.0), ("kN m s/rad", 1e3), ("lbf in s/rad", POUND_FORCE * INCH), ("kip in s/rad", KIP * INCH)]
            }
            Dimension::PerSpeed => &[("s/m", 1.0)],
            Dimension::PenetrationDamping => &[("N s/m2", 1.0)],
            Dimension::ContactStiffness => &[("N/m^1.5", 1.0)],
            Dimension::Curvature => &[("1/m", 1.0), ("1/km", 1e-3), (CHORD_DEGREE, DEGREE / (100.0 * FOOT))],
            Dimension::Pressure => {
                &[("Pa", 1.0), ("MPa", 1e6), ("GPa", 1e9), ("psi", POUND_FORCE / (INCH * INCH)), ("ksi", KIP / (INCH * INCH))]
            }
        }
    }

    /// Largest size that a scene may give, SI: far beyond any railway, and small enough that squares and products stay finite.
    /// Distances end where a double still tells nanometres apart.
    pub fn largest(self) -> f64 {
        match self {
            Dimension::None => 1e16,
            Dimension::Length => 1e7,
            Dimension::Angle | Dimension::Curvature => 1e3,
            Dimension::Time => 1e9,
            Dimension::Speed | Dimension::Acceleration => 1e4,
            Dimension::AngularSpeed | Dimension::PerSpeed => 1e6,
            Dimension::Mass => 1e9,
            Dimension::Inertia | Dimension::Force | Dimension::Torque | Dimension::AirResistance => 1e12,
            Dimension::Stiffness | Dimension::Damping | Dimension::RotationalStiffness | Dimension::RotationalDamping => 1e15,
            Dimension::PenetrationDamping | Dimension::ContactStiffness => 1e18,
            Dimension::Pressure => 1e15,
        }
    }

    /// Name of the SI unit with a blank before it; nothing for plain numbers.
    pub fn unit(self) -> String {
        let name = self.units()[0].0;
        if name.is_empty() { String::new() } else { format!(" {name}") }
    }

    /// Is it a number with a unit of this dimension?
    pub fn has_unit(self, text: &str) -> bool {
        self.parse(text).is_some() && !parts(text).1.is_empty()
    }

    /// What to write instead, for error messages: `a length in m (also mm, um, ...)`.
    pub fn expectation(self) -> String {
        let names: Vec<_> = self.units().iter().map(|unit| unit.0).collect();
        if self == Dimension::None {
            return "a plain number, or a string with %".into();
        }
        let more = if names.len() > 1 { format!("; a string may carry {}", names[1..].join(", ")) } else { String::new() };
        format!("a number in {}{more}", names[0])
    }

    /// `"10 kN s/m"` where `"10 kN.s/m"` was written: the unit of this dimension that differs in capitals and in signs between letters
    /// alone, or one of its other names.
    pub fn meant(self, text: &str) -> Option<String> {
        let (number, name) = parts(text);
        let value: f64 = number.parse().ok()?;
        let wanted = bare(name);
        if !value.is_finite() || wanted.is_empty() {
            return None;
        }
        let wanted = OTHER_NAMES.iter().find(|other| other.0 == wanted).map_or(wanted, |other| bare(other.1));
        let known = || self.units().iter().map(|unit| unit.0).filter(|known| bare(known) == wanted);
        // Capitals tell milli from mega; without any that fit the first one will do.
        let exact = |known: &&str| known.chars().find(char::is_ascii_alphabetic) == name.chars().find(char::is_ascii_alphabetic);
        let found = known().find(exact).or(known().next())?;
        let meant = format!("{number} {found}");
        // A number of another size than allowed was written as it should be.
        (meant != text.trim()).then_some(meant)
    }

    /// Reads `"10 mm"` as 0.01. `None` when number or unit is not understood.
    pub fn parse(self, text: &str) -> Option<f64> {
        let (number, name) = parts(text);
        let number: f64 = number.parse().ok()?;
        if name.is_empty() {
            return Some(number);
        }
        if self == Dimension::Curvature && name == CHORD_DEGREE {
            // A chord of 100 ft is seen from the centre under this angle.
            return Some((0.5 * DEGREE * number).sin() / (50.0 * FOOT));
        }
        let named = self.units().iter().find(|unit| unit.0 == name);
        named.or_else(|| self.units().iter().find(|unit| joined(unit.0).eq(joined(name)))).map(|unit| number * unit.1)
    }
}

/// A unit without what may stand between its factors: `N m`, `N.m`, `N*m` and `Nm` are one.
fn joined(name: &str) -> impl Iterator<Item = char> {
    name.chars().filter(|c| !matches!(c, ' ' | '.' | '*' | '\u{b7}' | '\u{22c5}'))
}

/// Other names of units, as [`bare`] writes them.
const OTHER_NAMES: &[(&str, &str)] = &[
    ("\u{b0}", "deg"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("radian", "rad"),
    ("radians", "rad"),
    ("\"", "in"),
    ("inch", "in"),
    ("inches", "in"),
    ("foot", "ft"),
    ("feet", "ft"),
    ("metre", "m"),
    ("metres", "m"),
    ("meter", "m"),
    ("meters", "m"),
    ("micron", "um"),
    ("kph", "km/h"),
    ("kmph", "km/h"),
    ("sec", "s"),
    ("msec", "ms"),
    ("to", "t"),
    ("percent", "%"),
    ("lbs", "lb"),
    ("lb", "lbf"),
    ("kips", "kip"),
    ("lbin", "lbf/in"),
    ("lbsin", "lbf s/in"),
    ("lbinrad", "lbf in/rad"),
    ("lbft", "lbf ft"),
    ("ftlb", "lbf ft"),
    ("inlb", "lbf in"),
    ("lbins2", "lbf in s2"),
    ("nmm2", "MPa"),
];

/// The number and the unit of a quantity, as written.
fn parts(text: &str) -> (&str, &str) {
    let text = text.trim();
    let split = text
        .char_indices()
        .find(|&(at, c)| {
            let exponent = (c == 'e' || c == 'E') && text[at + 1..].starts_with(|d: char| d.is_ascii_digit() || d == '-' || d == '+');
            !(c.is_ascii_digit() || ".+-".contains(c) || exponent)
        })
        .map_or(text.len(), |(at, _)| at);
    (text[..split].trim(), text[split..].trim())
}

/// A unit in small letters, without what stands between letters; raised digits and the Greek mu are plain.
fn bare(name: &str) -> String {
    let plain = |c: char| match c {
        '\u{b2}' => Some('2'),
        '\u{b3}' => Some('3'),
        '\u{b5}' | '\u{3bc}' => Some('u'),
        ' ' | '.' | '*' | '\u{b7}' | '\u{d7}' | '\u{22c5}' | '^' | '/' | '_' | '-' | '(' | ')' => None,
        other => Some(other),
    };
    name.chars().filter_map(plain).flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_a_unit_written_otherwise_is_recognised() {
        let cases = [
            (Dimension::Damping, "10 kN.s/m", Some("10 kN s/m")),
            (Dimension::Damping, "10 kN*s/m", Some("10 kN s/m")),
            (Dimension::Damping, "10 KN\u{b7}s/m", Some("10 kN s/m")),
            (Dimension::Stiffness, "2 MN/M", Some("2 MN/m")),
            (Dimension::Length, "3 MM", Some("3 mm")),
            (Dimension::Length, "3 \u{3bc}m", Some("3 um")),
            (Dimension::Angle, "3\u{b0}", Some("3 deg")),
            (Dimension::Speed, "90 kmh", Some("90 km/h")),
            (Dimension::Inertia, "5 kg*m^2", Some("5 kg m2")),
            (Dimension::Pressure, "207 gpa", Some("207 GPa")),
            (Dimension::Force, "58 lb", Some("58 lbf")),
            (Dimension::Mass, "286000 lbs", Some("286000 lb")),
            (Dimension::Stiffness, "24000 lb/in", Some("24000 lbf/in")),
            (Dimension::Torque, "100 ft-lb", Some("100 lbf ft")),
            (Dimension::Length, "3 deg", None),
            (Dimension::Length, "ten mm", None),
        ];
        for (dimension, text, meant) in cases {
            assert_eq!(dimension.meant(text).as_deref(), meant, "{text}");
            assert!(meant.is_none_or(|meant| dimension.parse(meant).is_some()), "{meant:?} can be read");
        }
    }

    #[test]
    fn analytic_units_become_si() {
        let cases = [
            (Dimension::Length, "10 mm", 0.01),
            (Dimension::Length, "-3 in", -0.0762),
            (Dimension::Length, "1.5e1mm", 0.015),
            (Dimension::Speed, "90 km/h", 25.0),
            (Dimension::Angle, "180 deg", std::f64::consts::PI),
            (Dimension::Stiffness, "0.25 MN/m", 2.5e5),
            // NIST Special Publication 811, appendix B.
            (Dimension::Mass, "1000 lb", 453.59237),
            (Dimension::Force, "1 kip", 4448.2216152605),
            (Dimension::Stiffness, "1 lbf/in", 175.12683524647637),
            (Dimension::Inertia, "1 lbf in s2", 0.1129848290276167),
            (Dimension::Inertia, "1 lb ft2", 0.042140110093804806),
            (Dimension::Pressure, "1 psi", 6894.757293168361),
            (Dimension::None, "0.4", 0.4),
            (Dimension::None, "30 ‰", 0.03),
            (Dimension::None, "30 per mille", 0.03),
        ];
        for (dimension, text, value) in cases {
            let read = dimension.parse(text).unwrap();
            assert!((read - value).abs() < 1e-15 * value.abs().max(1.0), "{text}: {read}");
        }
        assert_eq!(Dimension::Length.parse("3 deg"), None);
        assert_eq!(Dimension::Length.parse("ten mm"), None);
    }
}
