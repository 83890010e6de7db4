//! Hunting as a limit cycle, over speed: which periodic motions there are, stable and unstable, the lowest speed at which one lives (the nonlinear critical speed),
//! and what runs from a developed motion come to (True, H.: Multiple attractors and critical parameters and how to find them numerically, Vehicle System Dynamics 51, 2013).
//!
//! The branch of motions begins at the linear critical speed ([`crate::study::modes::locus`]), where it has no size (a Hopf bifurcation), and is followed by its arc length
//! ([`crate::study::cycles`]) over a vehicle ([`vehicle`]) that runs from passage to passage ([`station`]).
//! Runs over many turns, which know nothing of it, stand beside it ([`settle`]).

mod extremes;
mod follow;
pub mod settle;
mod station;
pub mod vehicle;

use crate::scene::spec::Scene;
use crate::study::modes::locus::{self, Critical, Locus};
use crate::study::modes::{Modes, ModesError};
use rayon::prelude::*;
use serde::Serialize;
use settle::{Outcome, settle};
use vehicle::Vehicle;

/// Swing of the leading wheelset with which the run at the highest speed begins, m.
const LARGE: f64 = 5e-3;

/// Why there is no diagram.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HuntingError {
    #[error(transparent)]
    Modes(#[from] ModesError),
    #[error("no limit cycles: {0}")]
    None(String),
}

/// A number and by how much it may be off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Value {
    pub value: f64,
    pub bound: f64,
}

/// A periodic motion.
#[derive(Clone, Debug, Serialize)]
pub struct Motion {
    /// m/s.
    pub speed: f64,
    /// Half the way between the extremes of each wheelset's lateral displacement, m.
    pub swings: Vec<f64>,
    /// By how much that of the leading wheelset may be off, m; `None` where it was not looked at.
    pub bound: Option<f64>,
    /// Turns per second.
    pub frequency: Value,
    pub stable: bool,
    /// Floquet multiplier with the largest absolute value, as real and imaginary part.
    pub multiplier: [f64; 2],
    /// Number of multipliers outside the unit circle.
    pub unstable: usize,
}

/// Where the branch passes a speed of the sweep, but Newton's method met no motion.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Unmet {
    /// m/s.
    pub speed: f64,
    /// Half swings of the motions before and behind it on the branch, m.
    pub swings: [f64; 2],
}

/// Where two motions meet.
#[derive(Clone, Debug, Serialize)]
pub struct Turning {
    pub speed: Value,
    pub motion: Motion,
    /// Is it the lowest speed of motions nearby (else the highest)?
    pub lowest: bool,
    /// Is one of the motions that meet stable?
    pub stable: bool,
}

/// A run over many turns.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// m/s.
    pub speed: f64,
    pub turns: usize,
    #[serde(flatten)]
    pub outcome: Outcome,
}

/// All of it.
#[derive(Clone, Debug, Serialize)]
pub struct Diagram {
    /// Small motions, and the linear critical speed.
    pub locus: Locus,
    pub wheelsets: Vec<String>,
    /// The one whose swing is followed.
    pub leading: usize,
    pub integration: String,
    /// Speed to which the branch tends as its motions become small, m/s.
    pub begin: Option<Value>,
    /// Along the branch, from small motions on.
    pub branch: Vec<Motion>,
    /// How the branch ends, in words.
    pub end: String,
    /// At the speeds of the sweep.
    pub motions: Vec<Motion>,
    /// Motions that must be there and were not met.
    pub missed: Vec<Unmet>,
    pub turnings: Vec<Turning>,
    /// From a developed motion.
    pub runs: Vec<Run>,
}

impl Diagram {
    /// Where the first swinging motion begins to grow.
    pub fn linear(&self) -> Option<&Critical> {
        self.locus.hopf()
    }

    /// The turning point with the lowest speed at which a stable motion lives.
    pub fn fold(&self) -> Option<&Turning> {
        let lowest = self.turnings.iter().filter(|turning| turning.lowest && turning.stable);
        lowest.min_by(|a, b| a.speed.value.total_cmp(&b.speed.value))
    }

    /// Half the swing of a motion's leading wheelset, m.
    pub fn swing(&self, motion: &Motion) -> f64 {
        motion.swings[self.leading]
    }
}

/// What is done while a diagram is made.
pub trait Progress: Sync {
    /// One of the speeds of the sweep is done: each counts twice, for its modes and for its run.
    fn speed(&self);
    /// A motion of the branch was found.
    fn motion(&self, speed: f64, swing: f64);
}

/// Limit cycles of a scene's vehicle within a range of speeds [m/s], which must grow.
///
/// # Errors
/// [`HuntingError`].
pub fn diagram(scene: &Scene, speeds: &[f64], progress: &dyn Progress) -> Result<Diagram, HuntingError> {
    let locus = locus::locus(scene, speeds, || progress.speed())?;
    let (Some(lowest), Some(highest)) = (locus.points.first(), locus.points.last()) else {
        return Err(HuntingError::None("no speed was given".into()));
    };
    let at = match locus.hopf() {
        Some(critical) => crate::study::modes::modes(scene, critical.speed)?,
        None => highest.clone(),
    };
    let unit = 0.05 * at.speed;
    let swinging = at.begins(locus.hopf().map(|onset| onset.frequency));
    let swinging = swinging.ok_or_else(|| HuntingError::None("no mode grows, and none is one of hunting".into()))?;
    let vehicle = Vehicle::new(scene, at.speed, swinging, unit).map_err(HuntingError::None)?;
    let range = lowest.speed..highest.speed;
    let wheelsets = station::steady(scene, at.speed)?.model().wheelsets.iter().map(|wheelset| wheelset.name.clone()).collect();
    let followed = match locus.hopf() {
        Some(_) => follow::from_small(&vehicle, (at.speed, swinging), range, speeds, progress),
        None => follow::Followed::none("no swinging motion begins to grow at any speed of the sweep"),
    };
    let runs = runs(&vehicle, highest, speeds, followed.largest.as_ref(), progress);
    Ok(Diagram {
        locus,
        wheelsets,
        leading: vehicle.section.leading(),
        integration: vehicle.integration(),
        begin: followed.begin,
        branch: followed.branch,
        end: followed.end,
        motions: followed.motions,
        missed: followed.missed,
        turnings: followed.turnings,
        runs,
    })
}

/// From the motion of the branch that swings most; where it does not get large, from what a large swing in the shape of hunting comes to at the highest speed.
fn runs(vehicle: &Vehicle, highest: &Modes, speeds: &[f64], largest: Option<&(Vec<f64>, f64)>, progress: &dyn Progress) -> Vec<Run> {
    let Some(fastest) = speeds.last() else { return Vec::new() };
    let begin = match (largest, highest.leads()) {
        (Some((place, swing)), _) if *swing > 0.5 * LARGE => place.clone(),
        (_, Some(hunting)) => settle(vehicle, *fastest, &vehicle.section.place(&hunting.shape, LARGE)).place,
        _ => return Vec::new(),
    };
    let run = |speed: &f64| {
        let found = settle(vehicle, *speed, &begin);
        progress.speed();
        Run { speed: *speed, turns: found.turns, outcome: found.outcome }
    };
    speeds.par_iter().map(run).collect()
}
