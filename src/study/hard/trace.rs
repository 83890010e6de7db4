//! What is kept of a run on its dense grid.

use super::super::beside::beside;
use super::finding::Unit;
use crate::formulation::Model;
use crate::geometry::Side;
use crate::sim::Snapshot;
use crate::sim::outputs::{Output, outputs};

/// A quantity of every wheelset, or of every wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    Distance,
    Y,
    Z,
    Yaw,
    Speed,
    LateralSpeed,
    VerticalSpeed,
    PitchRate,
    LateralAcceleration,
    VerticalAcceleration,
    YawAcceleration,
    /// Force of the driving constraint; absent on wheelsets without.
    Driving,
    /// Q, Y, force along the track, N, Y/Q.
    Vertical,
    Lateral,
    Longitudinal,
    Normal,
    Quotient,
    /// Of each place of contact: N and the contact angle.
    PlaceNormal,
    PlaceAngle,
}

impl Quantity {
    const ALL: [Quantity; 19] = [
        Quantity::Distance,
        Quantity::Y,
        Quantity::Z,
        Quantity::Yaw,
        Quantity::Speed,
        Quantity::LateralSpeed,
        Quantity::VerticalSpeed,
        Quantity::PitchRate,
        Quantity::LateralAcceleration,
        Quantity::VerticalAcceleration,
        Quantity::YawAcceleration,
        Quantity::Driving,
        Quantity::Vertical,
        Quantity::Lateral,
        Quantity::Longitudinal,
        Quantity::Normal,
        Quantity::Quotient,
        Quantity::PlaceNormal,
        Quantity::PlaceAngle,
    ];

    /// Its name among the outputs of a wheelset or a wheel.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Distance => "distance",
            Quantity::Y => "y",
            Quantity::Z => "z",
            Quantity::Yaw => "yaw",
            Quantity::Speed => "vx",
            Quantity::LateralSpeed => "vy",
            Quantity::VerticalSpeed => "vz",
            Quantity::PitchRate => "pitchRate",
            Quantity::LateralAcceleration => "ay",
            Quantity::VerticalAcceleration => "az",
            Quantity::YawAcceleration => "yawAcceleration",
            Quantity::Driving => "drivingForce",
            Quantity::Vertical => "verticalForce",
            Quantity::Lateral => "lateralForce",
            Quantity::Longitudinal => "longitudinalForce",
            Quantity::Normal | Quantity::PlaceNormal => "normalForce",
            Quantity::PlaceAngle => "angle",
            Quantity::Quotient => "derailmentQuotient",
        }
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Quantity::Vertical => "Q",
            Quantity::Lateral => "Y",
            Quantity::Longitudinal => "Fx",
            Quantity::Normal => "N",
            Quantity::Quotient => "Y/Q",
            Quantity::Driving => "driving force",
            Quantity::YawAcceleration => "yaw acceleration",
            other => other.name(),
        }
    }

    fn of_wheels(self) -> bool {
        matches!(self, Quantity::Vertical | Quantity::Lateral | Quantity::Longitudinal | Quantity::Normal | Quantity::Quotient)
    }

    fn of_places(self) -> bool {
        matches!(self, Quantity::PlaceNormal | Quantity::PlaceAngle)
    }

    /// Of its errors; forces are told as shares.
    pub fn unit(self) -> Unit {
        match self {
            Quantity::Distance | Quantity::Y | Quantity::Z => Unit::Metre,
            Quantity::Yaw | Quantity::PlaceAngle => Unit::Radian,
            Quantity::Speed | Quantity::LateralSpeed | Quantity::VerticalSpeed => Unit::MetrePerSecond,
            Quantity::LateralAcceleration | Quantity::VerticalAcceleration => Unit::MetrePerSecond2,
            Quantity::YawAcceleration => Unit::RadianPerSecond2,
            Quantity::PitchRate | Quantity::Quotient => Unit::One,
            _ => Unit::Newton,
        }
    }

    /// Is it a force, whose error is told as a share of the static wheel load?
    pub fn is_force(self) -> bool {
        self.of_wheels() && self != Quantity::Quotient || matches!(self, Quantity::Driving | Quantity::PlaceNormal)
    }
}

/// One column: a quantity of a wheelset or one of its wheels.
struct Channel {
    quantity: Quantity,
    wheelset: usize,
    side: Option<Side>,
    output: Output,
}

/// A run on its grid.
pub struct Trace {
    channels: Vec<Channel>,
    pub time: Vec<f64>,
    /// By channel.
    columns: Vec<Vec<f64>>,
}

impl Trace {
    /// An empty one for the wheelsets of a model.
    pub fn new(model: &Model) -> Trace {
        let mut channels = Vec::new();
        for output in outputs(model, &["motion", "wheels", "contacts"]) {
            let wheelset = output.reference as usize / 1000 - 1;
            let Some(local) =
                model.wheelsets.get(wheelset).and_then(|known| output.name.strip_prefix(known.name.as_str())?.strip_prefix('.'))
            else {
                continue;
            };
            let side = Side::BOTH.into_iter().find(|side| local.strip_prefix(side.name()).is_some_and(|rest| rest.starts_with('.')));
            let name = local.rsplit('.').next().unwrap_or(local);
            let place = local.contains(".contact[");
            let found = Quantity::ALL.into_iter().find(|quantity| {
                quantity.name() == name && (quantity.of_wheels() || quantity.of_places()) == side.is_some() && quantity.of_places() == place
            });
            if let Some(quantity) = found {
                channels.push(Channel { quantity, wheelset, side, output });
            }
        }
        let columns = vec![Vec::new(); channels.len()];
        Trace { channels, time: Vec::new(), columns }
    }

    /// Adds a sample.
    pub fn push(&mut self, snapshot: &Snapshot) {
        self.time.push(snapshot.time);
        for (channel, column) in self.channels.iter().zip(&mut self.columns) {
            column.push(channel.output.value(snapshot));
        }
    }

    /// Columns of a quantity, of every wheelset and wheel (place).
    pub fn of(&self, quantity: Quantity) -> impl Iterator<Item = &[f64]> {
        self.channels
            .iter()
            .zip(&self.columns)
            .filter(move |(channel, _)| channel.quantity == quantity)
            .map(|(_, column)| column.as_slice())
    }

    /// Columns of every place of a wheel.
    pub fn places(&self, quantity: Quantity, wheelset: usize, side: Side) -> Vec<&[f64]> {
        let wanted = |channel: &Channel| channel.quantity == quantity && channel.wheelset == wheelset && channel.side == Some(side);
        self.channels.iter().zip(&self.columns).filter(|(channel, _)| wanted(channel)).map(|(_, column)| column.as_slice()).collect()
    }

    /// One column; empty where there is none.
    pub fn one(&self, quantity: Quantity, wheelset: usize, side: Option<Side>) -> &[f64] {
        let wanted = |channel: &&Channel| channel.quantity == quantity && channel.wheelset == wheelset && channel.side == side;
        let place = self.channels.iter().position(|channel| wanted(&channel));
        place.map_or(&[], |place| self.columns[place].as_slice())
    }

    /// Of the leading wheelset.
    pub fn first(&self, quantity: Quantity) -> &[f64] {
        self.one(quantity, 0, quantity.of_wheels().then_some(Side::Left))
    }

    /// The largest size of a quantity, of all wheelsets and wheels.
    pub fn largest(&self, quantity: Quantity) -> f64 {
        self.of(quantity).flatten().fold(0.0, |most: f64, value| most.max(value.abs()))
    }

    /// The largest distance of a quantity from that of another run on the same grid, as far as both go, and when. `jumps`: where
    /// forces jump, as those of rigid contacts do where their place changes, a jump may come one sample sooner or later: what lies
    /// within the other run's three samples around is no error; nor what it has within `shift` [s].
    pub fn distance(&self, other: &Trace, quantity: Quantity, jumps: bool, shift: f64) -> (f64, f64) {
        self.distances(other, quantity, jumps, shift).fold((0.0, 0.0), |worst, next| if next.0 > worst.0 { next } else { worst })
    }

    /// When it is first further than `bound` from another run, jumps counted as such, s.
    pub fn first_beyond(&self, other: &Trace, quantity: Quantity, bound: f64) -> Option<f64> {
        let beyond = self.distances(other, quantity, true, 0.0).filter(|(size, _)| *size > bound);
        beyond.map(|(_, time)| time).reduce(f64::min)
    }

    fn distances<'a>(&'a self, other: &'a Trace, quantity: Quantity, jumps: bool, shift: f64) -> impl Iterator<Item = (f64, f64)> + 'a {
        let grid = if let [first, second, ..] = self.time[..] { second - first } else { f64::INFINITY };
        let around = usize::from(jumps).max((shift / grid).round() as usize);
        self.of(quantity).zip(other.of(quantity)).flat_map(move |(ours, theirs)| {
            let samples = ours.iter().zip(&self.time).enumerate().take(theirs.len());
            samples.map(move |(sample, (value, time))| (beside(*value, theirs, sample, around), *time))
        })
    }
}
