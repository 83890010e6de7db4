//! Units of outputs, inputs and parameters, with the type definitions that go with them.

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
