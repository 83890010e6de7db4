//! Wheelsets that flutter on their contacts: an instability of the model that long steps would hide.
//!
//! A rigid wheelset of mass m and roll inertia J bounces and rolls on the contact stiffnesses of its wheels at nearly the same frequency
//! (2 K / m and 2 K b^2 / J: coach 1813 kg, 1120 kg m2, b = 0.75 m, 190 Hz). Where its creep forces are at their friction bound and a flange
//! or a steep contact ties lateral motion to these two, each wheel's force follows the other's load, which is a stiffness without
//! symmetry: beyond some friction the two motions feed each other (mode coupling). With a coefficient of 0.55 in a curve of 150 m the
//! leading wheelset of a coach grows so, until its wheels lift from the rails 100 times a second; friction of 0.35 leaves it at rest.
//!
//! That is the model's own motion: rails and axle are rigid in it. But an implicit step of 20 ms damps what grows at 100 Hz, and the same scene runs
//! quietly. So the linearised wheelset on its contacts alone,
//!
//! ```text
//! x'' = M^-1 (dW/dx x + dW/dx' x'),   x = displacement and rotation, W = wrench of all its contacts,
//! ```
//!
//! is asked for eigenvalues with a real part above zero; while it has one, steps follow it: `h <= 1/4 / |lambda|`. Explicit steps at the limit of
//! stability hide it too (the classical Runge-Kutta method leaves 0.6 of a swing in a step of 2.3 ms at 153 Hz): where wheels slide they are asked
//! each 2 ms. (Suspensions are a
//! hundred times softer, and gyroscopic moments 2 % of the frequency at 60 m/s: both are left out.)

use super::beat::Swing;
use super::vibration::Vibration;
use super::wheel_loads::WheelLoads;
use super::{ContactReport, Model, Workspace, contact_index};
use crate::geometry::Side;
use crate::mbs::body::COORDINATES;
use crate::mbs::inertia::Inertia;
use nalgebra::linalg::Schur;
use nalgebra::{Matrix3, SMatrix};
use serde::{Deserialize, Serialize};

/// Below this share of friction nothing flutters.
const LEAST_USE: f64 = 0.7;
/// Least growth [1/s], the same by |lambda|, and least frequency [rad/s] of what counts: below, hunting of a wheelset without its suspension grows too.
const GROWS: f64 = 1.0;
const GROWS_BY: f64 = 2e-3;
const FAST: f64 = 300.0;
/// Steps are at most this long, 1 / |lambda|: what the method itself damps at 0.5 (some 1/s) hid slow growth.
const FOLLOWED: f64 = 0.25;
/// How often it is looked at, while wheels slide, where steps make no Jacobian of their own, s: in a large swing they slide for some milliseconds at a time.
const LOOKED: f64 = 2e-3;
/// After so long without sliding nothing grows, s.
const QUIET: f64 = 0.05;
/// What the eigenvalues' iteration may cost.
const ITERATIONS: usize = 400;

/// A small swing has grown by e to this power before it counts (beyond some swing, contacts come and go and nothing is linear): errors of a thousandth by then are some per cent. It is
/// taken to fade at this rate, 1/s, while nothing grows.
const TOLD: f64 = 3.0;
const FADES: f64 = 5.0;
/// A wheel's load swings because of it where its frequency is so near, by a factor: in a large swing contacts come and go.
const NEAR: f64 = 1.6;

/// A swing that nothing excites is told from this size on, from turn to turn in parts of the static load.
const GREAT: f64 = 0.25;

/// An unstable motion of a wheelset on its contacts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fluttering {
    /// When it began to grow, s.
    pub since: f64,
    /// Number of the wheelset, from 0.
    pub wheelset: usize,
    /// Hz, and growth, 1/s, when it had grown.
    pub frequency: f64,
    pub growth: f64,
}

/// One wheelset as it was last looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Growing {
    /// |lambda|, 1/s; zero where nothing grows.
    rate: f64,
    /// When it was looked at, and when it began to grow, s.
    time: f64,
    since: f64,
    /// Logarithm of what a small swing has grown by since then.
    exponent: f64,
    /// When it first mattered.
    found: Option<Fluttering>,
}

/// What is known of a model's wheelsets; part of a simulation's state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Flutter {
    wheelsets: Vec<Growing>,
    /// The fastest vibration of force elements, of methods that are explicit in them.
    pub vibration: Vibration,
}

impl Flutter {
    /// Could this have come from the same model as `other`?
    pub fn fits(&self, other: &Flutter) -> bool {
        self.wheelsets.len() == other.wheelsets.len()
    }

    /// What grew so far that it matters, the earliest of each wheelset.
    pub fn found(&self) -> impl Iterator<Item = &Fluttering> {
        self.wheelsets.iter().filter_map(|growing| growing.found.as_ref())
    }

    /// Has it been looked at long enough before `t` [s] that a method which makes no Jacobians should do so again?
    pub fn is_due(&self, t: f64) -> bool {
        self.wheelsets.iter().any(|growing| !(growing.time..growing.time + LOOKED).contains(&t))
    }

    /// Has nothing slid for long?
    pub fn is_over(&self, t: f64) -> bool {
        self.wheelsets.iter().any(|growing| (growing.rate > 0.0 || growing.exponent > 0.0) && t > growing.time + QUIET)
    }

    /// Has a small swing of a wheelset begun to grow, and not faded since then?
    pub fn is_growing(&self, wheelset: usize) -> bool {
        self.wheelsets.get(wheelset).is_some_and(|growing| growing.exponent > 0.0)
    }

    /// The longest step that follows what grows, s.
    pub fn longest_step(&self) -> f64 {
        FOLLOWED / self.wheelsets.iter().map(|growing| growing.rate).fold(0.0, f64::max)
    }
}

impl Model {
    /// Before the first step.
    pub fn flutter(&self) -> Flutter {
        Flutter { wheelsets: vec![Growing::default(); self.wheelsets.len()], vibration: Vibration::default() }
    }

    /// Looks at the linearisations of wheelsets that slide, which were made at `t` [s]: at each, since growth of 100 1/s hidden for 20 ms is a swing of a tenth.
    pub fn note_flutter(&self, workspace: &Workspace, t: f64, flutter: &mut Flutter) {
        for wheelset in 0..flutter.wheelsets.len() {
            self.look_at(workspace, t, wheelset, flutter);
        }
    }

    fn look_at(&self, workspace: &Workspace, t: f64, wheelset: usize, flutter: &mut Flutter) {
        let found = if self.slides(workspace, wheelset) { self.grows(workspace, wheelset) } else { None };
        let growing = &mut flutter.wheelsets[wheelset];
        let Some((growth, rate)) = found else {
            let exponent = (growing.exponent - FADES * (t - growing.time).max(0.0)).max(0.0);
            *growing = Growing { rate: 0.0, time: t, exponent, ..*growing };
            return;
        };
        if growing.exponent == 0.0 {
            growing.since = t;
        }
        if growing.rate > 0.0 {
            growing.exponent += growth * (t - growing.time).max(0.0);
        }
        (growing.rate, growing.time) = (growth.hypot(rate), t);
        if growing.exponent > TOLD && growing.found.is_none() {
            growing.found = Some(Fluttering { since: growing.since, wheelset, frequency: rate / std::f64::consts::TAU, growth });
        }
    }

    /// Flutters that are told, with the swing of a force (is it the lateral one?): once forces show it, where steps follow it; with `fixed` steps always.
    fn told<'a>(
        &self,
        flutter: &'a Flutter,
        loads: &'a WheelLoads,
        fixed: bool,
    ) -> impl Iterator<Item = (Fluttering, Option<(Side, bool, Swing)>)> + 'a {
        flutter.found().filter_map(move |found| {
            let swing = loads.trembles(found.wheelset, found.frequency, NEAR);
            (fixed || swing.is_some() || loads.swings(found.wheelset)).then_some((*found, swing))
        })
    }

    /// When the first flutter that is told began, s.
    pub fn first_flutter(&self, flutter: &Flutter, loads: &WheelLoads, fixed: bool) -> Option<f64> {
        self.told(flutter, loads, fixed)
            .map(|(found, swing)| swing.map_or(found.since, |(.., swing)| swing.since.min(found.since)))
            .reduce(f64::min)
    }

    /// What a user should know of wheelsets that flutter, the earliest.
    pub fn flutter_note(&self, flutter: &Flutter, loads: &WheelLoads, fixed: bool) -> Option<String> {
        let all = || self.told(flutter, loads, fixed);
        let (Fluttering { since, wheelset, frequency, growth }, swing) = all().min_by(|a, b| a.0.since.total_cmp(&b.0.since))?;
        let name = &self.wheelsets[wheelset].name;
        let what = match swing {
            None => format!(
                "{name} flutters on its contacts from {since:.3} s on, at {frequency:.0} Hz (a small swing grows by {growth:.0} 1/s)"
            ),
            Some((side, lateral, Swing { since, frequency, size, .. })) => format!(
                "{name}, {} wheel flutters on its contacts from {since:.3} s on, at {frequency:.0} Hz: its {} swings by up to {:.0} % of the static load, to \
                 and fro (a small swing grows by {growth:.0} 1/s)",
                side.name(),
                if lateral { "lateral force" } else { "load" },
                100.0 * size
            ),
        };
        let others = match all().count() - 1 {
            0 => String::new(),
            1 => "; so does another wheelset".into(),
            more => format!("; so do {more} more wheelsets"),
        };
        let hidden = if fixed { "; steps of a fixed length may hide it, and loads are then those of an unstable balance" } else { "" };
        let (on, calmer) = match self.gives_way() {
            true => ("", "less friction calms it"),
            false => (" on rigid rails", "rails that yield (track.flexibility = \"travelling\") or less friction calm it"),
        };
        Some(format!(
            "{what}{others}: friction at its bound couples its bouncing and rolling{on}. That is the model's own motion, not an error of \
             steps{hidden}; small differences grow by it, so that loads at an instant may be known to their order of magnitude alone from there on (a run at a tenth of the tolerance shows it); {calmer}"
        ))
    }

    /// What a user should know of a wheel's load that swings fast and for long where no flutter of its wheelset alone is behind it, and neither track (sleepers that pass among it) nor wheels excite it; swings
    /// on deviations of rails are not counted.
    pub fn swing_note(&self, loads: &WheelLoads) -> Option<String> {
        let excited = self.rail_motion || self.beam.is_some() || self.out_of_round.iter().any(Option::is_some);
        let great = (0..self.wheelsets.len()).filter_map(|wheelset| Some((wheelset, loads.fast_swing(wheelset)?)));
        let (wheelset, (side, Swing { since, frequency, size, .. })) =
            great.filter(|(_, (_, swing))| swing.size > GREAT && !excited).max_by(|a, b| a.1.1.size.total_cmp(&b.1.1.size))?;
        Some(format!(
            "{}, {} wheel: its load swings by up to {:.0} % of the static one, up and down, at {frequency:.0} Hz, first at {since:.3} s, though neither track nor \
             wheels excite it. That is the model's own motion, not an error of steps: contact that passes between two places of the wheel, or friction near its \
             bound{}",
            self.wheelsets[wheelset].name,
            side.name(),
            100.0 * size,
            if self.gives_way() { "" } else { "; rails that yield (track.flexibility = \"travelling\") may calm it" }
        ))
    }

    /// Is there a wheelset near the friction bound of a contact?
    pub fn any_slides(&self, workspace: &Workspace) -> bool {
        (0..self.wheelsets.len()).any(|wheelset| self.slides(workspace, wheelset))
    }

    /// Is an elastic contact of the wheelset near its friction bound?
    fn slides(&self, workspace: &Workspace, wheelset: usize) -> bool {
        self.any_uses(workspace, wheelset, |report, (used, bound)| !report.constrained && used > LEAST_USE * bound)
    }

    /// Is there a contact of the wheelset of which this holds, with its creep force and the friction bound of that, N?
    pub(super) fn any_uses(&self, workspace: &Workspace, wheelset: usize, holds: impl Fn(&ContactReport, (f64, f64)) -> bool) -> bool {
        let motion = &workspace.system.motions[self.wheelsets[wheelset].body];
        Side::BOTH.into_iter().any(|side| {
            workspace.reports(contact_index(wheelset, side)).any(|report| {
                let bound = self.friction_at(side, motion, report) * report.normal_force;
                let force = report.creep_force.longitudinal.hypot(report.creep_force.lateral);
                bound > 0.0 && holds(report, (force, bound))
            })
        })
    }

    /// Real and imaginary part [1/s] of the fastest growing oscillation of a wheelset on its contacts.
    fn grows(&self, workspace: &Workspace, wheelset: usize) -> Option<(f64, f64)> {
        const N: usize = COORDINATES;
        let number = self.wheelsets[wheelset].body;
        let wrench = workspace.tangent.as_ref()?.own_wrench(number)?;
        let (body, motion) = (&self.system.bodies[number], &workspace.system.motions[number]);
        let (Inertia::Revolution { transverse, axial } | Inertia::NotGyroscopic { transverse, axial }) = body.inertia else { return None };
        let axle = motion.frame.axes.column(1).into_owned();
        let turn = Matrix3::identity() / transverse + axle * axle.transpose() * (1.0 / axial - 1.0 / transverse);
        let mut system = SMatrix::<f64, { 2 * COORDINATES }, { 2 * COORDINATES }>::zeros();
        for (from, block) in [(0, &wrench.by_position), (N, &wrench.by_velocity)] {
            let force = block.fixed_rows::<3>(0) / body.mass;
            let moment = turn * block.fixed_rows::<3>(3);
            system.fixed_view_mut::<3, 6>(N, from).copy_from(&force);
            system.fixed_view_mut::<3, 6>(N + 3, from).copy_from(&moment);
        }
        // In times of 1 ms the numbers of both halves are alike.
        const SCALE: f64 = 1e-3;
        for i in 0..N {
            system[(i, N + i)] = SCALE;
        }
        system.fixed_view_mut::<6, 12>(N, 0).scale_mut(SCALE);
        let values = Schur::try_new(system, f64::EPSILON, ITERATIONS)?.complex_eigenvalues();
        let growing = values.iter().map(|value| (value.re / SCALE, value.im / SCALE));
        growing.filter(|(re, im)| *im > FAST && *re > GROWS && *re > GROWS_BY * im).max_by(|a, b| a.0.total_cmp(&b.0))
    }
}
