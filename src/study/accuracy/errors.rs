//! Distance between two observed runs in the terms that people use.

use super::super::beside::beside;
use super::observation::{Observation, crossings, mean_wavelength};
use serde::Serialize;

/// Distance between two curves at equal times, SI.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Distance {
    pub largest: f64,
    /// Root mean square.
    pub rms: f64,
    /// 95 % of the samples are nearer.
    pub most: f64,
}

/// The part of the samples that [`Distance::most`] covers.
const MOST: f64 = 0.95;

impl Distance {
    /// Of differences without sign.
    fn new(mut differences: Vec<f64>) -> Distance {
        // A difference that is no number is larger than any.
        differences.iter_mut().filter(|value| value.is_nan()).for_each(|value| *value = f64::INFINITY);
        differences.sort_by(f64::total_cmp);
        let Some(largest) = differences.last().copied() else { return Distance::default() };
        let place = (MOST * (differences.len() - 1) as f64).round() as usize;
        let squares: f64 = differences.iter().map(|value| value * value).sum();
        Distance { largest, rms: (squares / differences.len() as f64).sqrt(), most: differences[place] }
    }

    fn worse(self, other: Distance) -> Distance {
        let Distance { largest, rms, most } = other;
        Distance { largest: self.largest.max(largest), rms: self.rms.max(rms), most: self.most.max(most) }
    }
}

/// What an error is an error of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Lateral displacement, m.
    Displacement,
    /// Q of a wheel, N.
    WheelLoad,
    /// Normal force of a wheel, N.
    NormalForce,
    /// Y/Q.
    DerailmentQuotient,
    /// Of a wheelset's centre, lateral or vertical, m/s2.
    Acceleration,
    /// Mean hunting wavelength, m.
    Wavelength,
}

impl Quantity {
    pub const ALL: [Quantity; 6] = [
        Quantity::Displacement,
        Quantity::WheelLoad,
        Quantity::NormalForce,
        Quantity::DerailmentQuotient,
        Quantity::Acceleration,
        Quantity::Wavelength,
    ];

    /// In the names of files.
    pub fn key(self) -> &'static str {
        ["y", "Q", "N", "YQ", "acceleration", "wavelength"][self as usize]
    }

    /// In words.
    pub fn words(self) -> &'static str {
        ["lateral displacement", "wheel load Q", "normal force", "Y/Q", "acceleration", "hunting wavelength"][self as usize]
    }

    /// The SI unit, empty for pure numbers.
    pub fn unit(self) -> &'static str {
        ["m", "N", "N", "", "m/s2", "m"][self as usize]
    }
}

/// Distances between two runs, the worst of all wheelsets and wheels that both observed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    pub y: Distance,
    pub vertical: Distance,
    pub normal: Distance,
    pub quotient: Distance,
    pub acceleration: Distance,
    /// m; `None` where one of the runs shows no two waves.
    pub wavelength: Option<f64>,
}

impl Errors {
    /// Between two runs, as long as both lasted.
    pub fn between(a: &Observation, b: &Observation) -> Errors {
        let smooth: Vec<bool> = a.smooth.iter().zip(&b.smooth).map(|(a, b)| *a && *b).collect();
        let reach = usize::from(a.jumps || b.jumps);
        let apart = |a: &[f64], b: &[f64], reach: usize| {
            let samples = (0..a.len().min(b.len())).filter(|sample| smooth[*sample]);
            Distance::new(samples.map(|sample| beside(a[sample], b, sample, reach).max(beside(b[sample], a, sample, reach))).collect())
        };
        let mut all = Errors::default();
        for (a, b) in a.wheelsets.iter().zip(&b.wheelsets) {
            let pairs = all.distances().into_iter().zip(a.values.iter().zip(&b.values)).enumerate();
            for (quantity, (distance, (a, b))) in pairs {
                // Displacements do not jump.
                let reach = if quantity == 0 { 0 } else { reach };
                for (a, b) in a.iter().zip(b) {
                    *distance = distance.worse(apart(a, b, reach));
                }
            }
            let waves = [crossings(a), crossings(b)];
            let common = waves[0].len().min(waves[1].len());
            if let [Some(a), Some(b)] = waves.map(|waves| mean_wavelength(&waves, common)) {
                all.wavelength = Some(all.wavelength.unwrap_or(0.0).max((a - b).abs()));
            }
        }
        all
    }

    /// In the order of a trace's values.
    fn distances(&mut self) -> [&mut Distance; 5] {
        [&mut self.y, &mut self.vertical, &mut self.normal, &mut self.quotient, &mut self.acceleration]
    }

    /// How far the run moves away from its first sample: what an error is large or small against.
    pub fn motion(run: &Observation) -> Errors {
        let mut start = Observation { jumps: false, ..run.clone() };
        for values in start.wheelsets.iter_mut().flat_map(|trace| trace.values.iter_mut().flatten()) {
            let first = values.first().copied().unwrap_or_default();
            values.fill(first);
        }
        let moving = Observation { jumps: false, ..run.clone() };
        Errors { wavelength: run.wavelength(), ..Errors::between(&moving, &start) }
    }

    /// The number by which a quantity is judged; `None` where there is none.
    pub fn of(&self, quantity: Quantity) -> Option<f64> {
        match quantity {
            Quantity::Displacement => Some(self.y.largest),
            Quantity::WheelLoad => Some(self.vertical.largest),
            Quantity::NormalForce => Some(self.normal.largest),
            Quantity::DerailmentQuotient => Some(self.quotient.largest),
            Quantity::Acceleration => Some(self.acceleration.largest),
            Quantity::Wavelength => self.wavelength,
        }
    }
}
