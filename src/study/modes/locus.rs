//! Modes over speed, and the speed from which on hunting grows.

use super::{Modes, ModesError, modes_over};
use crate::scene::spec::Scene;
use rayon::prelude::*;
use serde::Serialize;

/// A critical speed is found to this, m/s.
pub const ACCURACY: f64 = 0.01;

/// Modes at several speeds.
#[derive(Clone, Debug, Serialize)]
pub struct Locus {
    /// By growing speed.
    pub points: Vec<Modes>,
    /// Where hunting begins to grow.
    pub critical: Option<Critical>,
}

/// The linear critical speed.
#[derive(Clone, Debug, Serialize)]
pub struct Critical {
    /// m/s.
    pub speed: f64,
    /// Of the mode that begins to grow there, Hz.
    pub frequency: f64,
    pub mode: String,
}

/// Modes at speeds [m/s], which must grow, and the first speed between two of them at which the largest growth rate of hunting passes zero upward.
///
/// # Errors
/// [`ModesError`] of the first speed that has no modes.
pub fn locus(scene: &Scene, speeds: &[f64], done: impl Fn() + Sync) -> Result<Locus, ModesError> {
    locus_over(scene, speeds, 0.0, done)
}

/// The same where wheelsets swing across by an `amplitude` [m] (equivalent slopes).
///
/// # Errors
/// [`ModesError`] of the first speed that has no modes.
pub fn locus_over(scene: &Scene, speeds: &[f64], amplitude: f64, done: impl Fn() + Sync) -> Result<Locus, ModesError> {
    let at = |speed: &f64| {
        let found = modes_over(scene, *speed, amplitude);
        done();
        found
    };
    let points: Vec<Modes> = speeds.par_iter().map(at).collect::<Result<_, _>>()?;
    let growth = |modes: &Modes| modes.hunting().map(|mode| mode.growth);
    let crossing = points.windows(2).find(|pair| growth(&pair[0]).is_none_or(|a| a <= 0.0) && growth(&pair[1]).is_some_and(|b| b > 0.0));
    let critical = match crossing {
        Some(pair) => critical(scene, pair[0].speed, &pair[1])?,
        None => None,
    };
    Ok(Locus { points, critical })
}

/// By bisection: which mode hunts most may change on the way, and growth rates then have kinks.
fn critical(scene: &Scene, mut stable: f64, unstable: &Modes) -> Result<Option<Critical>, ModesError> {
    let mut unstable = unstable.clone();
    while unstable.speed - stable > ACCURACY {
        let middle = modes_over(scene, 0.5 * (stable + unstable.speed), unstable.amplitude)?;
        if middle.hunting().is_some_and(|mode| mode.growth > 0.0) {
            unstable = middle;
        } else {
            stable = middle.speed;
        }
    }
    let found = |mode: &super::Mode| Critical { speed: unstable.speed, frequency: mode.frequency, mode: mode.name.clone() };
    Ok(unstable.hunting().map(found))
}
