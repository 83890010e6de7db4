//! The reference of a model: two independent methods at the same tight tolerance.
//!
//! Dormand-Prince 5(4) and the classical Runge-Kutta method with its own error estimate 4(3) share neither stages nor error estimate nor
//! continuous output, and both gain a decade for 1.6 to 1.8 times the work, which no method of order 3 does. An implicit method is a third
//! witness: its points in the sweep tend to the same reference.

use super::clock::{Budget, Interrupted};
use super::errors::{Errors, Quantity};
use super::observation::Observation;
use super::run::{Observed, Setting, observe, with_setting};
use super::schedule::PILOT_TOLERANCE;
use crate::scene::spec::Scene;
use crate::sim::Simulation;
use crate::sim::recording::Times;
use serde::Serialize;

/// The two methods.
pub(super) const METHODS: [&str; 2] = ["dormand_prince", "rk43"];

/// Tolerances from the first to the tightest that is tried, m.
const TOLERANCES: [f64; 4] = [1e-9, 1e-11, 1e-12, 1e-13];

/// What a decade of tolerance costs at most: an order of 4 has 10^(1/4).
pub(super) const PER_DECADE: f64 = 1.8;

/// A reference solution.
#[derive(Clone, Debug, Serialize)]
pub struct Reference {
    /// Formulation that it was computed with.
    pub formulation: &'static str,
    pub methods: [&'static str; 2],
    /// m.
    pub tolerance: f64,
    /// Distance of the two methods' solutions.
    pub uncertainty: Errors,
    /// Largest changes since the start.
    pub motion: Errors,
    pub wavelength: Option<f64>,
    #[serde(skip)]
    pub observation: Observation,
}

/// What helps where rigid contact ends a run: behind the reason.
pub(super) const ENDS: &str = " (--set contact.on_lift=elastic lets a wheel that loses its place go on elastically)";

/// Both methods at once, each on a core of its own; returns the time that passed too. `hint`: what helps where the model ends the run.
fn pair(
    (scene, hint): (&Scene, &str),
    wheelset: Option<&str>,
    span: Times,
    tolerance: f64,
    (limit, interrupted): (f64, Interrupted),
) -> Result<([Observed; 2], f64), String> {
    let clock = std::time::Instant::now();
    let one = |method: &'static str| -> Result<Observed, String> {
        let setting = Setting { integrator: method, fixed: false, value: tolerance };
        let mut simulation = Simulation::new(&with_setting(scene, &setting)?, 0.0).map_err(|error| error.to_string())?;
        let observed = observe(&mut simulation, wheelset, span, (limit, true, interrupted));
        match &observed.failure {
            Some(failure) => Err(format!("{}: {failure}{}", setting.words(), if observed.late { "" } else { hint })),
            None => Ok(observed),
        }
    };
    let (first, second) = rayon::join(|| one(METHODS[0]), || one(METHODS[1]));
    Ok(([first?, second?], clock.elapsed().as_secs_f64()))
}

/// As tight as fits into the budget until shares of it, that for a `first`, loose one and that for tighter ones, or as `fixed` [m] says.
/// `pilot`: what a run at the pilots' tolerance takes, s.
pub(super) fn reference(
    (formulation, scene, hint): (&'static str, &Scene, &str),
    wheelset: Option<&str>,
    span: Times,
    (budget, [first, share], pilot): (&Budget, [f64; 2], f64),
    fixed: Option<f64>,
) -> Result<Reference, String> {
    let mut found: Option<Reference> = None;
    let mut last = (PILOT_TOLERANCE, pilot);
    let tolerances: Vec<f64> = fixed.map_or(TOLERANCES.to_vec(), |tolerance| vec![tolerance]);
    for tolerance in tolerances {
        let left = budget.left_of(if found.is_none() { first } else { share });
        let predicted = last.1 * PER_DECADE.powf((last.0 / tolerance).log10().max(0.0));
        if predicted > left {
            if found.is_some() {
                break;
            }
            return Err(format!("it needs about {predicted:.0} s, {:.0} s are left for it", left.max(0.0)));
        }
        // What takes longer than predicted takes the points' time; the first model's loose reference alone has more.
        let ([one, other], seconds) = match pair((scene, hint), wheelset, span, tolerance, (left, budget.interrupted)) {
            Ok(done) => done,
            // A looser one is better than none.
            Err(failure) if found.is_none() => return Err(failure),
            Err(_) => break,
        };
        last = (tolerance, seconds);
        let uncertainty = Errors::between(&one.observation, &other.observation);
        let better = |old: &Errors| {
            let gain = |quantity| matches!((old.of(quantity), uncertainty.of(quantity)), (Some(old), Some(new)) if new < 0.5 * old);
            gain(Quantity::Displacement) || gain(Quantity::WheelLoad)
        };
        let gained = found.as_ref().is_none_or(|old| better(&old.uncertainty));
        if gained {
            let motion = Errors::motion(&one.observation);
            let (methods, wavelength) = (METHODS, one.observation.wavelength());
            found = Some(Reference { formulation, methods, tolerance, uncertainty, motion, wavelength, observation: one.observation });
        } else {
            // Rounding, or a system that is not smooth: tighter tolerances do not help.
            break;
        }
    }
    found.ok_or_else(|| "no tolerance was tried".into())
}

/// Is an error of a quantity known well enough to be shown?
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Standing {
    Shown(f64),
    /// Better than this, which is what the reference can tell.
    Below(f64),
    /// Larger than what the quantity itself does.
    Useless,
    /// The quantity does not occur, or does not move.
    Absent,
}

impl Standing {
    /// The error, or what it is better than, which is said by `true`.
    pub fn bound(self) -> Option<(f64, bool)> {
        match self {
            Standing::Shown(error) => Some((error, false)),
            Standing::Below(floor) => Some((floor, true)),
            Standing::Useless | Standing::Absent => None,
        }
    }
}

impl Reference {
    /// What can be said of a point's error.
    pub fn standing(&self, errors: &Errors, quantity: Quantity) -> Standing {
        let (Some(error), Some(motion)) = (errors.of(quantity), self.motion.of(quantity)) else { return Standing::Absent };
        let floor = self.floor(quantity);
        if !(motion > floor) {
            Standing::Absent
        } else if error < floor {
            Standing::Below(floor)
        } else if error > motion {
            Standing::Useless
        } else {
            Standing::Shown(error)
        }
    }

    /// The smallest error of which the study vouches for; 0 where both methods gave the same number.
    pub fn floor(&self, quantity: Quantity) -> f64 {
        super::FACTOR * self.uncertainty.of(quantity).unwrap_or(f64::INFINITY)
    }
}
