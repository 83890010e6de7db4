//! How a study is made: variants, pilots, span, references, points, coupling.

use super::clock::{Budget, Interrupted, cpu_time};
use super::communication;
use super::difference::differences;
use super::division::{PILOTS, POINTS, POINTS_ALONE, shortened, turns};
use super::errors::Errors;
use super::reference::{self, ENDS, METHODS};
use super::request::Request;
use super::run::{self, INTERRUPTED, Setting};
use super::schedule::{Item, PILOT_TOLERANCE, Pilot, Schedule, patience};
use super::study::{Outcome, Point, StudiedModel, Study, StudyError};
use super::variant::{Variant, variants};
use crate::scene::load;
use crate::scene::spec::Scene;
use crate::sim::Simulation;
use crate::sim::recording::Times;

/// A variant that can be started.
struct Prepared {
    scene: Scene,
    rigid: bool,
    /// Is contact a constraint that ends the run where it has no solution?
    ends: bool,
}

/// A study under way.
struct Making<'a> {
    request: &'a Request<'a>,
    /// Is told the share that is done and what is being done.
    progress: &'a mut dyn FnMut(f64, &str),
    budget: Budget<'a>,
    own: Scene,
    settings: Vec<Setting>,
    prepared: Vec<Prepared>,
    schedule: Schedule,
    span: Times,
    study: Study,
}

/// Makes the study. `progress` is told the share that is done and what is being done.
///
/// # Errors
/// [`StudyError`], also when no point is worth drawing.
pub fn study(request: &Request, progress: &mut dyn FnMut(f64, &str)) -> Result<Study, StudyError> {
    let mut making = Making::begin(request, progress)?;
    making.references();
    let coupled = making.has_room_for_coupling();
    making.points(if coupled { POINTS } else { POINTS_ALONE });
    making.study.differences = differences(&making.study.models);
    making.study.refuse()?;
    if coupled {
        making.couple();
    }
    Ok(making.study)
}

impl<'a> Making<'a> {
    /// Opens and starts every variant, runs pilots, and chooses the span of all runs.
    fn begin(request: &'a Request, progress: &'a mut dyn FnMut(f64, &str)) -> Result<Self, StudyError> {
        let budget = Budget::new(request.budget, request.interrupted);
        let own = load::open(request.scene, request.overrides)?;
        let (settings, mut notes) = run::settings(request).map_err(StudyError::Setting)?;
        let (variants, prepared) = prepare(request, &mut notes)?;
        if prepared.is_empty() {
            return Err(StudyError::Refused(format!("no formulation can start the scene: {}", notes.join("; "))));
        }
        let full = Times { stop: request.stop.unwrap_or(own.run.stop), step: request.step };
        let (start, mut pilots, mut cpu) = (budget.spent(), Vec::new(), 0.0);
        for (variant, one) in variants.iter().zip(&prepared) {
            progress(budget.spent() / budget.seconds, &format!("pilot run of {}", variant.label()));
            let (pilot, seconds) =
                cpu_time(|| pilot(one, full, (PILOTS * budget.seconds / prepared.len() as f64, false, request.interrupted)));
            pilots.push(pilot);
            cpu += seconds;
        }
        let schedule = Schedule::new(pilots, request.repeats, ((budget.spent() - start) / cpu).max(1.0));
        let span = if request.stop.is_some() { full } else { shortened(full, &schedule, &settings, &budget, &mut notes) };
        let study = Study {
            scene: own.name.clone(),
            title: own.title.clone(),
            stop: span.stop,
            step: span.step,
            wheelset: request.wheelset.map(String::from),
            budget: request.budget,
            models: models(&variants, &prepared),
            variants,
            points: Vec::new(),
            differences: Vec::new(),
            coupled: Vec::new(),
            notes,
        };
        Ok(Making { request, progress, budget, own, settings, prepared, schedule, span, study })
    }

    fn tell(&mut self, what: &str) {
        (self.progress)(self.budget.spent() / self.budget.seconds, what);
    }

    /// Gives every model its reference, as far as the budget goes.
    fn references(&mut self) {
        for (index, shares) in turns(&self.study.models, &self.study.variants, &self.schedule, self.own.contact.formulation_name) {
            self.tell(&format!("reference of {}", self.study.models[index].name));
            let model = &mut self.study.models[index];
            // Of the rigid formulations ECCF comes after ACCF and is the cheaper one.
            for variant in model.variants.iter().rev() {
                let Prepared { scene, ends, .. } = &self.prepared[*variant];
                let formulation = (self.study.variants[*variant].formulation, scene, if *ends { ENDS } else { "" });
                let Some(pilot) = self.schedule.pilots[*variant] else { continue };
                let within = (&self.budget, shares, pilot.per_second * self.span.stop * self.schedule.slowness);
                model.reference = reference::reference(formulation, self.request.wheelset, self.span, within, self.request.reference);
                if model.reference.is_ok() {
                    break;
                }
            }
        }
    }

    /// Are communication steps asked for, and is there time for their reference?
    fn has_room_for_coupling(&mut self) -> bool {
        let own = self.study.variants.iter().position(|variant| variant.formulation == self.own.contact.formulation_name);
        let pilot = own.and_then(|variant| self.schedule.pilots[variant]);
        let cost = pilot.map_or(f64::INFINITY, |pilot| pilot.per_second * self.schedule.slowness);
        let asked = !self.request.communication_steps.is_empty();
        let room =
            asked && !(self.request.interrupted)() && communication::duration(cost, self.span) < (1.0 - POINTS) * self.budget.seconds;
        if asked && !room && !(self.request.interrupted)() {
            self.study
                .notes
                .push("communication steps: left out, the budget has no room for their reference (a larger --budget has)".into());
        }
        room
    }

    /// Runs every variant with a reference at every setting, the cheapest first, while the budget's share `until` lasts.
    fn points(&mut self, until: f64) {
        let count = self.prepared.len();
        let all = (0..count).flat_map(|variant| self.settings.iter().map(move |setting| Item { variant, setting: *setting }));
        let referenced = |item: &Item| self.study.model_of(item.variant).is_some_and(|model| model.reference.is_ok());
        let (mut items, without): (Vec<Item>, Vec<Item>) = all.partition(referenced);
        let skipped =
            |Item { variant, setting }| Point { variant, setting, outcome: Outcome::Skipped("the model has no reference".into()) };
        self.study.points = without.into_iter().map(skipped).collect();
        let patience = patience(&self.budget, items.len());
        while let Some((next, seconds)) = self.schedule.cheapest(&items, self.span.stop, patience) {
            let item = items.swap_remove(next);
            let left = self.budget.left_of(until);
            let outcome = if seconds < left {
                self.tell(&format!("{}: {}", self.study.variants[item.variant].label(), item.setting.words()));
                self.run(item, [(4.0 * seconds).max(1.0).min(left), patience])
            } else if (self.request.interrupted)() {
                Outcome::Skipped(INTERRUPTED.into())
            } else if seconds.is_finite() {
                Outcome::Skipped(format!("it needs about {seconds:.1} s, {:.1} s are left", left.max(0.0)))
            } else {
                Outcome::Skipped("its pilot run did not come to an end".into())
            };
            self.study.points.push(Point { variant: item.variant, setting: item.setting, outcome });
        }
        // Variants in the order of the formulations, then of settings.
        let method = |point: &Point| self.request.integrators.iter().position(|name| *name == point.setting.integrator);
        self.study
            .points
            .sort_by(|a, b| (a.variant, method(a)).cmp(&(b.variant, method(b))).then(b.setting.value.total_cmp(&a.setting.value)));
        // Of a model without a reference no budget makes errors.
        let measured =
            |point: &&Point| self.study.models.iter().any(|model| model.reference.is_ok() && model.variants.contains(&point.variant));
        let skipped = self.study.points.iter().filter(measured).filter(|point| matches!(point.outcome, Outcome::Skipped(_))).count();
        if skipped > 0 {
            let why = if (self.request.interrupted)() { INTERRUPTED } else { "a larger --budget has room for more" };
            let words = format!("{skipped} of {} points were not run ({why})", self.study.points.len());
            self.study.notes.push(words);
        }
    }

    /// One point; what it costs helps to foresee others.
    fn run(&mut self, item: Item, limits: [f64; 2]) -> Outcome {
        let done = run::with_setting(&self.prepared[item.variant].scene, &item.setting).and_then(|scene| {
            run::measure(&scene, self.request.wheelset, self.span, self.request.repeats, limits, self.request.interrupted)
        });
        let reference = self.study.model_of(item.variant).map(|model| &model.reference);
        match (done, reference) {
            (Ok((observation, measured)), Some(Ok(reference))) => {
                self.schedule.learn(item, measured.median());
                Outcome::Done { measured, errors: Errors::between(&observation, &reference.observation) }
            }
            (Ok(_), _) => Outcome::Skipped("the model has no reference".into()),
            (Err(_), _) if (self.request.interrupted)() => Outcome::Skipped(INTERRUPTED.into()),
            (Err(failure), _) => Outcome::Failed(failure),
        }
    }

    fn couple(&mut self) {
        self.tell("communication steps");
        match communication::sweep(&self.own, self.request, self.span, &self.budget) {
            Ok(coupled) => self.study.coupled = coupled,
            Err(reason) => self.study.notes.push(format!("communication steps: left out: {reason}")),
        }
    }
}

/// Opens and starts every variant; those that can't be started are noted.
fn prepare(request: &Request, notes: &mut Vec<String>) -> Result<(Vec<Variant>, Vec<Prepared>), StudyError> {
    let all = variants(&request.formulations, &request.creep_laws, &request.node_spacings, &request.smoothings);
    let alone = all.len() == 1;
    let mut started = Vec::new();
    for variant in all {
        let scene = match variant.open(request.scene, request.overrides) {
            // With one formulation alone its refusal is the user's matter.
            Err(error) if alone => return Err(error.into()),
            opened => opened.map_err(|error| error.to_string()),
        };
        let prepared = scene.and_then(|scene| {
            let simulation = Simulation::new(&scene, 0.0).map_err(|error| error.to_string())?;
            let rigid = simulation.model().formulation.constrains();
            Ok(Prepared { rigid, ends: rigid && !simulation.model().may_be_elastic(), scene })
        });
        match prepared {
            Ok(prepared) => started.push((variant, prepared)),
            Err(error) => notes.push(format!("{}: {error}", variant.label())),
        }
    }
    Ok(started.into_iter().unzip())
}

/// A first run that shows what a variant costs; `None` when it did not move.
fn pilot(prepared: &Prepared, span: Times, limit: (f64, bool, Interrupted)) -> Option<Pilot> {
    let setting = Setting { integrator: METHODS[0], fixed: false, value: PILOT_TOLERANCE };
    let mut simulation = Simulation::new(&run::with_setting(&prepared.scene, &setting).ok()?, 0.0).ok()?;
    let observed = run::observe(&mut simulation, None, span, limit);
    let evaluations = simulation.statistics().evaluations.max(1) as f64;
    (observed.reached > 0.0).then(|| Pilot { per_second: observed.cpu / observed.reached, per_evaluation: observed.cpu / evaluations })
}

/// Variants by model, in the order in which the models first occur.
fn models(variants: &[Variant], prepared: &[Prepared]) -> Vec<StudiedModel> {
    let mut models: Vec<StudiedModel> = Vec::new();
    for (index, (variant, one)) in variants.iter().zip(prepared).enumerate() {
        let name = variant.model(one.rigid);
        let reference = Err("a pilot run came to nothing in its share of the budget".into());
        match models.iter_mut().find(|model| model.name == name) {
            Some(model) => model.variants.push(index),
            None => models.push(StudiedModel { name, rigid: one.rigid, variants: vec![index], reference }),
        }
    }
    models
}
