//! Shafts that twist while their wheels slide: axles between their wheels, drives between rotor and axle, and locked wheels on their brakes.
//!
//! Where a wheel rolls with little slip its creep force damps such a shaft beyond swinging. Where it slides, next to nothing does, and with a friction that falls with the slip a
//! swing grows of itself (slip-stick; two wheels of 14 kg m2 on 6 MN m/rad at 75 Hz, 10 m/s, 2 m/s of slip on a wet rail: by 2 1/s, to 95 kN m). A long implicit step takes it away,
//! and a tolerance of 1e-5 rad says nothing of 60 N m. So while a wheel slides that the shaft turns, a step's error of its twist is held against the twist's own swing:
//!
//! ```text
//! |e_psi| <= r A_psi,   r = 5e-5,   A_psi >= 1 urad
//! ```
//!
//! A is an envelope as in [`super::swing`], of a few periods.

use super::envelope::Envelope;
use super::{ContactReport, Model, Workspace};
use crate::mbs::body::COORDINATES;
use crate::mbs::force::ForceElement;
use serde::{Deserialize, Serialize};

/// r, -.
const SHARE: f64 = 5e-5;
/// Swings below this do not matter, rad: 6 N m of an axle.
const SMALLEST: f64 = 1e-6;
/// Time of mean and envelope, and so long after its wheels slid a shaft may still swing, s.
const TIME: f64 = 0.1;
/// A wheel slides from this share of its friction bound on, or, where friction falls with the slip, from this creepage on.
const SLIDES: f64 = 0.7;
const SLIPS: f64 = 0.01;
/// A wheel is locked from this creepage on: it swings on the springs of its brake.
const LOCKED: f64 = 0.8;

/// What is known of one shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Torsion {
    envelope: Envelope,
    /// Until when its wheels count as sliding, s.
    until: Option<f64>,
}

/// Does a contact slide, or is it near to it?
fn slips(report: &ContactReport, (used, bound): (f64, f64)) -> bool {
    used > SLIDES * bound || report.creepage.longitudinal.hypot(report.creepage.lateral) > SLIPS
}

/// Does the wheel of a contact slide without turning, or nearly so?
fn locked(report: &ContactReport, _: (f64, f64)) -> bool {
    report.creepage.longitudinal.abs() > LOCKED
}

impl Model {
    /// Elements with a shaft that twists, and the place of its twist among the states.
    fn shafts(&self) -> impl Iterator<Item = (&dyn ForceElement, usize)> {
        let mut next = 2 * COORDINATES * self.system.bodies.len();
        self.system.forces.iter().filter_map(move |force| {
            let first = next;
            next += force.states();
            force.torsion().map(|own| (force.as_ref(), first + own))
        })
    }

    /// Before the first step.
    pub(super) fn torsions(&self) -> Vec<Torsion> {
        self.shafts().map(|_| Torsion::default()).collect()
    }

    /// Notes the end of a step at time `t` [s], `before` the end of the one before, with the state there.
    pub(super) fn note_torsions(&self, workspace: &Workspace, (before, t): (Option<f64>, f64), y: &[f64], torsions: &mut [Torsion]) {
        let fading = before.map_or(1.0, |before| 1.0 - (-(t - before).max(0.0) / TIME).exp());
        // Torsions first: where there are none, no element is asked.
        for (own, (force, place)) in torsions.iter_mut().zip(self.shafts()) {
            own.envelope.note(y[place], fading, before.is_none());
            let turned = |body: usize| force.bodies().contains(&Some(body));
            let wheelsets = (0..self.wheelsets.len()).filter(|wheelset| turned(self.wheelsets[*wheelset].body));
            let swings = if force.swings_when_locked() { locked } else { slips };
            if wheelsets.into_iter().any(|wheelset| self.any_uses(workspace, wheelset, swings)) {
                own.until = Some(t + TIME);
            }
        }
    }

    /// The largest error of a twist in parts of what its swing allows, at the end of a step at `now` [s].
    pub(super) fn torsion_error(&self, now: f64, torsions: &[Torsion], error: &[f64]) -> f64 {
        let sliding = torsions.iter().zip(self.shafts()).filter(|(own, _)| own.until.is_some_and(|until| until > now));
        sliding.map(|(own, (_, place))| error[place].abs() / (SHARE * own.envelope.amplitude.max(SMALLEST))).fold(0.0, f64::max)
    }
}
