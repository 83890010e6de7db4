//! Modes over speed, and the speeds from which on motions grow.
//!
//! Any motion counts, by the number of those that grow: a mode changes its kind with speed (one of hunting on 5.9 Hz of a locomotive was one of its trucks' yaw and roll
//! where it began to grow), and cars on long suspensions sway before their wheelsets hunt. Named is what has just begun to: the motion that grows where the one next to it (by eigenvalue), a hundredth of
//! a metre per second below, does not yet; others may grow less than it all along.

use super::{Mode, Modes, ModesError, modes_over};
use crate::scene::spec::Scene;
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::TAU;

/// A critical speed is found to this, m/s.
pub const ACCURACY: f64 = 0.01;

/// Modes at several speeds.
#[derive(Clone, Debug, Serialize)]
pub struct Locus {
    /// By growing speed.
    pub points: Vec<Modes>,
    /// The linear critical speed: where the first motion begins to grow, of whatever kind; `None` where one grows at the lowest speed already.
    pub critical: Option<Critical>,
    /// Where motions begin to grow, by speed; the critical one is the first of them.
    pub onsets: Vec<Critical>,
}

impl Locus {
    /// Where the first swinging motion begins to grow within the sweep (a Hopf bifurcation).
    pub fn hopf(&self) -> Option<&Critical> {
        self.onsets.iter().find(|onset| onset.frequency > 0.0)
    }

    /// Neighbouring speeds between which everything that grew has ceased to grow, m/s.
    pub fn calmed(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.points.windows(2).filter(|pair| count(&pair[0]) > 0 && count(&pair[1]) == 0).map(|pair| [pair[0].speed, pair[1].speed])
    }

    /// Does nothing grow at that speed of the sweep?
    pub fn is_calm(&self, speed: f64) -> bool {
        self.points.iter().any(|modes| (modes.speed - speed).abs() < 1e-9 && count(modes) == 0)
    }

    /// What grows at the lowest speed already.
    pub fn growing_at_lowest(&self) -> impl Iterator<Item = &Mode> {
        self.points.first().into_iter().flat_map(Modes::growing)
    }
}

/// A speed from which on a motion grows.
#[derive(Clone, Debug, Serialize)]
pub struct Critical {
    /// m/s.
    pub speed: f64,
    /// Of the mode that begins to grow there, Hz.
    pub frequency: f64,
    pub mode: String,
}

/// Modes at speeds [m/s], which must grow, and the speeds between two of them from which on one more motion grows.
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
    let mut onsets = Vec::new();
    for pair in points.windows(2) {
        let mut below = pair[0].clone();
        while count(&pair[1]) > count(&below) {
            let [stable, unstable] = onset(scene, below, &pair[1])?;
            onsets.extend(named(&stable, &unstable));
            below = unstable;
        }
    }
    let mut found = Locus { points, critical: None, onsets };
    found.critical = found.onsets.first().filter(|_| found.growing_at_lowest().next().is_none()).cloned();
    Ok(found)
}

fn count(modes: &Modes) -> usize {
    modes.growing().count()
}

/// What begins to grow between two speeds.
fn named(stable: &Modes, unstable: &Modes) -> Option<Critical> {
    let apart = |a: &Mode, b: &Mode| (a.growth - b.growth).hypot(TAU * (a.frequency - b.frequency));
    let grew = |mode: &&Mode| {
        let next = stable.modes.iter().min_by(|a, b| apart(a, mode).total_cmp(&apart(b, mode)));
        next.is_some_and(|next| stable.growing().any(|growing| std::ptr::eq(growing, next)))
    };
    let least = |a: &&Mode, b: &&Mode| a.growth.total_cmp(&b.growth);
    let new = unstable.growing().filter(|mode| !grew(mode)).min_by(least).or_else(|| unstable.growing().min_by(least));
    new.map(|mode| Critical { speed: unstable.speed, frequency: mode.frequency, mode: mode.name.clone() })
}

/// Modes on both sides of where more of them grow than `below`, within [`ACCURACY`], by bisection: growth rates have kinks where modes cross.
fn onset(scene: &Scene, below: Modes, beyond: &Modes) -> Result<[Modes; 2], ModesError> {
    let before = count(&below);
    let (mut stable, mut unstable) = (below, beyond.clone());
    while unstable.speed - stable.speed > ACCURACY {
        let middle = modes_over(scene, 0.5 * (stable.speed + unstable.speed), unstable.amplitude)?;
        if count(&middle) > before {
            unstable = middle;
        } else {
            stable = middle;
        }
    }
    Ok([stable, unstable])
}
