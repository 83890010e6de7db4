//! What each effect of a scene contributes to the answer, and what it costs.
//!
//! The scene runs once with its own tolerance and once with a tighter one, the *reference*; the distance of both is the integration's own error.
//! Then it runs once per effect ([`list`]) with that effect switched off, or exchanged for a simpler or a fuller neighbour, at the scene's tolerance. The
//! distance to the reference is what the effect changes; below twice the integration's error nothing is told, since the changed run has an error too.
//! Every change is an override that a user can type: `--set key=value`.

pub mod change;
pub mod list;
pub mod neglect;
pub mod observed;
pub mod run;

use crate::geometry::Side;
use crate::scene::load;
use crate::scene::spec::Scene;
use crate::sim::Simulation;
use crate::sim::recording::Times;
use crate::solve::SettingKind;
use change::{Changed, Distance};
use list::Variant;
use observed::{Observed, Quantity};
use rayon::prelude::*;
use run::{Cost, Ended, Ran};
use serde::Serialize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// What is asked for.
pub struct Request<'a> {
    /// Name or file, and `key=value`.
    pub scene: &'a str,
    pub overrides: &'a [String],
    pub span: Times,
    /// Effects whose name contains one of these; all where it is empty.
    pub only: &'a [String],
    /// Runs at the same time.
    pub parallel: usize,
    /// For all runs together, s.
    pub budget: f64,
    /// Has somebody asked for the end?
    pub interrupted: &'a (dyn Fn() -> bool + Sync),
    /// Is told the runs that are ready, their number, and what was run.
    pub progress: &'a (dyn Fn(usize, usize, &str) + Sync),
}

/// What became of a run with a changed effect.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    Ran {
        changes: Vec<Changed>,
        growth: Option<f64>,
        cost: Cost,
        /// What the run says of itself.
        notes: Vec<String>,
    },
    /// The run ended at `time` [s].
    Failed { time: f64, derailed: bool, reason: String },
    /// The changed scene can't start.
    Refused { reason: String },
    /// There was no time for it.
    NotRun { reason: String },
}

/// One effect.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    #[serde(flatten)]
    pub variant: Variant,
    pub outcome: Outcome,
}

/// Size of a quantity in the reference, and the integration's own error, SI.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Base {
    pub quantity: Quantity,
    pub largest: f64,
    pub error: Distance,
}

/// All of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    pub scene: String,
    pub title: String,
    /// s.
    pub stop: f64,
    pub step: f64,
    pub integrator: &'static str,
    /// Is the setting a step [s]? Otherwise it is a tolerance [m].
    pub fixed: bool,
    pub setting: f64,
    pub reference_setting: f64,
    pub base: Vec<Base>,
    /// Growth of hunting in the reference, 1/s, where nothing pushes from outside.
    pub growth: Option<f64>,
    pub cost: Cost,
    pub rows: Vec<Row>,
    /// Was the end asked for before all had run?
    pub interrupted: bool,
}

/// The reference's tolerance in parts of the scene's, and its step.
const TIGHTER: f64 = 1e-2;
const SHORTER: f64 = 0.25;
/// The least that a scene may ask for.
const LEAST_LOAD_TOLERANCE: f64 = 1e-9;

/// The scene as the reference runs it.
fn tighter(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    let setting = scene.solver.integrator.setting();
    let part = if setting.kind == SettingKind::Step { SHORTER } else { TIGHTER };
    scene.solver.integrator = scene.solver.integrator.with_setting((part * setting.value).clamp(setting.range.0, setting.range.1));
    scene.solver.load_tolerance = (0.1 * scene.solver.load_tolerance).max(LEAST_LOAD_TOLERANCE);
    scene
}

/// From which time on nothing pushes the vehicle from outside, s: rails that are straight and in their place from there on. `None` where that leaves
/// less than a third of the run.
fn undisturbed(scene: &Scene, simulation: &Simulation, stop: f64) -> Option<f64> {
    const LEAST: f64 = 1.0 / 3.0;
    const READINGS: usize = 2000;
    let (model, speed) = (simulation.model(), scene.vehicle.speed);
    if model.track.line().is_some() || !scene.vehicle.keeps_speed() {
        return None;
    }
    let origin = crate::scene::start::origin(scene);
    let pushed = |time: f64| {
        scene.vehicle.wheelsets.iter().any(|wheelset| {
            let place = origin + wheelset.x + speed * time;
            Side::BOTH.iter().any(|side| model.track.rail(*side).deviation(place).iter().any(|axis| axis[1] != 0.0))
        })
    };
    let last = (0..=READINGS).rev().map(|k| stop * k as f64 / READINGS as f64).find(|time| pushed(*time)).unwrap_or(0.0);
    (stop - last > LEAST * stop).then_some(last)
}

/// Runs all of it.
///
/// # Errors
/// In words, when the scene itself can't be run.
pub fn effects(scene: &Scene, request: &Request) -> Result<Report, String> {
    let start = Instant::now();
    let Request { span, budget, interrupted, progress, .. } = *request;
    let deadline = Duration::try_from_secs_f64(budget).ok().and_then(|budget| start.checked_add(budget));
    let late = || deadline.is_some_and(|deadline| Instant::now() > deadline);
    let give_up = || interrupted() || late();
    let reference_scene = tighter(scene);
    let simulation = Simulation::new(scene, 0.0).map_err(|error| error.to_string())?;
    let variants = list::variants(scene, simulation.model(), span.stop);
    let known = |variant: &Variant, word: &String| variant.effect.contains(word.as_str()) || variant.change == *word;
    let unknown = request.only.iter().find(|word| !variants.iter().any(|variant| known(variant, word)));
    if let Some(word) = unknown {
        let mut names: Vec<&str> = variants.iter().map(|variant| variant.effect.as_str()).collect();
        names.dedup();
        return Err(format!("--only {word}: expected a part of the name of an effect of this scene: {}", names.join(", ")));
    }
    let variants: Vec<Variant> =
        variants.into_iter().filter(|variant| request.only.is_empty() || request.only.iter().any(|word| known(variant, word))).collect();
    let from = undisturbed(scene, &simulation, span.stop);
    let (all, ready) = (variants.len() + 2, AtomicUsize::new(0));
    let tell = |what: &str| progress(ready.fetch_add(1, Ordering::Relaxed) + 1, all, what);
    progress(0, all, "reference");
    let own = |scene: &Scene, what: &str| {
        let done = run::run(scene, span, &|_| give_up()).map(|ran| (ran.observed, ran.cost)).map_err(|ended| match ended {
            Ended::Refused(reason) | Ended::Failed { reason, .. } => {
                format!("the run {what} failed, so there is nothing to compare with: {reason}")
            }
            Ended::GivenUp { at, .. } => {
                format!("the run {what} was {at} when its time was over; expected a shorter --stop or more --budget")
            }
        });
        tell(what);
        done
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(request.parallel).build().map_err(|error| error.to_string())?;
    let (base, reference) = pool.install(|| rayon::join(|| own(scene, "of the scene"), || own(&reference_scene, "of the reference")));
    let ((base, cost), (reference, _)) = (base?, reference?);
    let errors: Vec<Option<Distance>> = Quantity::ALL.into_iter().map(|quantity| change::distance(quantity, &reference, &base)).collect();
    let limit = Limit { give_up: &give_up, late: &late, own: cost.cpu };
    let one = |variant: &Variant| {
        let outcome = changed(request, variant, &reference, &errors, from, &limit);
        tell(&variant.effect);
        Row { variant: variant.clone(), outcome }
    };
    let rows = pool.install(|| variants.par_iter().with_max_len(1).map(one).collect());
    let [setting, tight] = [scene, &reference_scene].map(|scene| scene.solver.integrator.setting());
    Ok(Report {
        scene: scene.name.clone(),
        title: scene.title.clone(),
        stop: span.stop,
        step: span.step,
        integrator: scene.solver.name,
        fixed: setting.kind == SettingKind::Step,
        setting: setting.value,
        reference_setting: tight.value,
        base: (Quantity::ALL.into_iter().zip(&errors))
            .filter_map(|(quantity, error)| Some(Base { quantity, largest: reference.largest(quantity)?, error: (*error)? }))
            .collect(),
        growth: from.and_then(|begin| change::growth(&reference, begin)),
        cost,
        rows,
        interrupted: interrupted(),
    })
}

/// A changed run that takes so many times the CPU time of the scene's own, and no less than some seconds, crawls: others shall have their turn.
const CRAWLS: f64 = 20.0;
const LEAST: f64 = 2.0;

/// When a run is given up.
struct Limit<'a> {
    give_up: &'a (dyn Fn() -> bool + Sync),
    /// Is the budget spent?
    late: &'a (dyn Fn() -> bool + Sync),
    /// CPU time of the scene's own run, s.
    own: f64,
}

impl Limit<'_> {
    /// CPU time from which a run crawls, s.
    fn longest(&self) -> f64 {
        (CRAWLS * self.own).max(LEAST)
    }

    /// Why a run of so many seconds was given up.
    fn words(&self, cpu: f64) -> String {
        match () {
            () if cpu > self.longest() => format!("given up after {:.0} times the time of the scene's own run", cpu / self.own.max(1e-9)),
            () if (self.late)() => "the budget is spent".into(),
            () => "interrupted".into(),
        }
    }
}

/// Runs the scene with one effect changed.
fn changed(
    request: &Request,
    variant: &Variant,
    reference: &Observed,
    errors: &[Option<Distance>],
    from: Option<f64>,
    limit: &Limit,
) -> Outcome {
    if (limit.give_up)() {
        return Outcome::NotRun { reason: limit.words(0.0) };
    }
    let longest = limit.longest();
    let overrides: Vec<String> = request.overrides.iter().chain(&variant.overrides).cloned().collect();
    let scene = match load::open(request.scene, &overrides) {
        Ok(scene) => scene,
        Err(error) => return Outcome::Refused { reason: error.to_string() },
    };
    match run::run_unless(scene, request.span, move |cpu| cpu > longest, limit.give_up) {
        Ok(Ran { observed, cost, notes }) => Outcome::Ran {
            changes: change::changes(reference, &observed, errors),
            growth: from.and_then(|begin| change::growth(&observed, begin)),
            cost,
            notes,
        },
        Err(Ended::Refused(reason)) => Outcome::Refused { reason },
        Err(Ended::Failed { time, derailed, reason }) => Outcome::Failed { time, derailed, reason },
        Err(Ended::GivenUp { at, cpu }) => Outcome::NotRun { reason: format!("{} {at}", limit.words(cpu)) },
    }
}
