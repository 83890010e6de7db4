//! Units of outputs, inputs and parameters, with the type definitions that go with them.

use super::Dimension;

/// Units that outputs, inputs and parameters carry (names as in modelDescription.xml).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    One,
    /// Metres of a displacement (shown in mm).
    Metre,
    /// Metres along the track.
    Distance,
    Radian,
    Second,
    MetrePerSecond,
    /// Metres per second of travel (shown in km/h).
    TravelSpeed,
    RadianPerSecond,
    MetrePerSecond2,
    RadianPerSecond2,
    Newton,
    NewtonMetre,
    PerMetre,
    Kilogram,
    KilogramMetre2,
    NewtonPerMetre,
    NewtonSecondPerMetre,
    NewtonSecondPerMetre2,
    NewtonMetrePerRadian,
    NewtonMetreSecondPerRadian,
    SecondPerMetre,
    Pascal,
    Watt,
    Joule,
    KilogramPerMetre,
}

impl Unit {
    /// The type definition in modelDescription.xml that goes with the unit.
    pub fn type_name(self) -> &'static str {
        match self {
            Unit::One => "Ratio",
            Unit::Metre => "Displacement",
            Unit::Distance => "Distance",
            Unit::Radian => "Angle",
            Unit::Second => "Time",
            Unit::MetrePerSecond => "Velocity",
            Unit::TravelSpeed => "TravellingSpeed",
            Unit::RadianPerSecond => "AngularVelocity",
            Unit::MetrePerSecond2 => "Acceleration",
            Unit::RadianPerSecond2 => "AngularAcceleration",
            Unit::Newton => "Force",
            Unit::NewtonMetre => "Torque",
            Unit::PerMetre => "SpinCreepage",
            Unit::Kilogram => "Mass",
            Unit::KilogramMetre2 => "Inertia",
            Unit::NewtonPerMetre => "Stiffness",
            Unit::NewtonSecondPerMetre => "Damping",
            Unit::NewtonSecondPerMetre2 => "PenetrationDamping",
            Unit::NewtonMetrePerRadian => "RotationalStiffness",
            Unit::NewtonMetreSecondPerRadian => "RotationalDamping",
            Unit::SecondPerMetre => "StopDamping",
            Unit::Pascal => "Pressure",
            Unit::Watt => "Power",
            Unit::Joule => "Energy",
            Unit::KilogramPerMetre => "AirResistance",
        }
    }

    /// Its dimension in scenes.
    pub fn dimension(self) -> Dimension {
        match self {
            Unit::One => Dimension::None,
            Unit::Metre | Unit::Distance => Dimension::Length,
            Unit::Radian => Dimension::Angle,
            Unit::Second => Dimension::Time,
            Unit::MetrePerSecond | Unit::TravelSpeed => Dimension::Speed,
            Unit::RadianPerSecond => Dimension::AngularSpeed,
            Unit::MetrePerSecond2 | Unit::RadianPerSecond2 => Dimension::Acceleration,
            Unit::Newton => Dimension::Force,
            Unit::NewtonMetre | Unit::Watt | Unit::Joule => Dimension::Torque,
            Unit::PerMetre => Dimension::Curvature,
            Unit::Kilogram => Dimension::Mass,
            Unit::KilogramMetre2 => Dimension::Inertia,
            Unit::NewtonPerMetre => Dimension::Stiffness,
            Unit::NewtonSecondPerMetre => Dimension::Damping,
            Unit::NewtonSecondPerMetre2 => Dimension::PenetrationDamping,
            Unit::NewtonMetrePerRadian => Dimension::RotationalStiffness,
            Unit::NewtonMetreSecondPerRadian => Dimension::RotationalDamping,
            Unit::SecondPerMetre => Dimension::PerSpeed,
            Unit::Pascal => Dimension::Pressure,
            Unit::KilogramPerMetre => Dimension::AirResistance,
        }
    }

    /// The bounds of a number with this unit, SI, where it has none of its own: what a scene may give.
    pub fn bounds(self, least: Option<f64>, most: Option<f64>) -> [Option<f64>; 2] {
        let largest = self.dimension().largest();
        [Some(least.unwrap_or(-largest)), Some(most.unwrap_or(largest))]
    }

    /// The unit's name in files.
    pub fn name(self) -> &'static str {
        match self {
            Unit::One => "1",
            Unit::Metre | Unit::Distance => "m",
            Unit::Radian => "rad",
            Unit::Second => "s",
            Unit::MetrePerSecond | Unit::TravelSpeed => "m/s",
            Unit::RadianPerSecond => "rad/s",
            Unit::MetrePerSecond2 => "m/s2",
            Unit::RadianPerSecond2 => "rad/s2",
            Unit::Newton => "N",
            Unit::NewtonMetre => "N.m",
            Unit::PerMetre => "1/m",
            Unit::Kilogram => "kg",
            Unit::KilogramMetre2 => "kg.m2",
            Unit::NewtonPerMetre => "N/m",
            Unit::NewtonSecondPerMetre => "N.s/m",
            Unit::NewtonSecondPerMetre2 => "N.s/m2",
            Unit::NewtonMetrePerRadian => "N.m/rad",
            Unit::NewtonMetreSecondPerRadian => "N.m.s/rad",
            Unit::SecondPerMetre => "s/m",
            Unit::Pascal => "Pa",
            Unit::Watt => "W",
            Unit::Joule => "J",
            Unit::KilogramPerMetre => "kg/m",
        }
    }
}
