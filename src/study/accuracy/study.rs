//! The study: variants, pilots, span, references, points, coupling.

use super::clock::{Budget, cpu_time};
use super::communication::{self, Coupled};
use super::difference::{ModelDifference, differences};
use super::division::{PILOTS, POINTS, POINTS_ALONE, shortened, turns};
use super::errors::{Errors, Quantity};
use super::reference::{self, ENDS, METHODS, Reference, Standing};
use super::run::{self, Measured, Setting, Span};
use super::schedule::{Item, PILOT_TOLERANCE, Pilot, Schedule, patience};
use super::variant::{Variant, variants};
use crate::scene::load::{self, SceneError};
use crate::scene::spec::Scene;
use crate::sim::Simulation;
use serde::Serialize;

/// What is asked for. Empty lists stand for what the scene says.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// Name or file, and `key=value`.
    pub scene: &'a str,
    pub overrides: &'a [String],
    pub formulations: Vec<&'static str>,
    pub integrators: Vec<&'static str>,
    /// m.
    pub tolerances: Vec<f64>,
    /// s.
    pub steps: Vec<f64>,
    pub creep_laws: Vec<&'static str>,
    /// m.
    pub node_spacings: Vec<f64>,
    /// m.
    pub smoothings: Vec<f64>,
    /// s; none: no coupling.
    pub communication_steps: Vec<f64>,
    /// s; `None`: that of the scene, shortened where the budget asks for it.
    pub stop: Option<f64>,
    /// Distance of the output times, s.
    pub step: f64,
    /// The only wheelset that counts; `None`: the worst of all.
    pub wheelset: Option<&'a str>,
    pub repeats: usize,
    /// s.
    pub budget: f64,
    /// Tolerance of the reference, m; `None`: as tight as the budget allows.
    pub reference: Option<f64>,
}

/// What became of a point.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
#[allow(clippy::large_enum_variant)] // some hundred points
pub enum Outcome {
    Done {
        measured: Measured,
        errors: Errors,
    },
    /// It was run, and this is why there is no result.
    Failed(String),
    /// It was not run, and this is why.
    Skipped(String),
}

/// One variant with one integrator at one setting.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// Index in [`Study::variants`].
    pub variant: usize,
    pub setting: Setting,
    pub outcome: Outcome,
}

/// A description of contact that has one exact solution.
#[derive(Clone, Debug, Serialize)]
pub struct Model {
    pub name: String,
    pub rigid: bool,
    /// Indices in [`Study::variants`].
    pub variants: Vec<usize>,
    pub reference: Result<Reference, String>,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    pub scene: String,
    pub title: String,
    /// s.
    pub stop: f64,
    pub step: f64,
    pub wheelset: Option<String>,
    pub budget: f64,
    pub variants: Vec<Variant>,
    pub models: Vec<Model>,
    pub points: Vec<Point>,
    pub differences: Vec<ModelDifference>,
    pub coupled: Vec<Coupled>,
    /// What was shortened, left out or could not be started.
    pub notes: Vec<String>,
}

/// Why there is no study.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    #[error("{0}")]
    Scene(#[from] SceneError),
    #[error("{0}")]
    Setting(String),
    #[error("{0}")]
    Refused(String),
}

struct Prepared {
    scene: Scene,
    rigid: bool,
    /// Is contact a constraint that ends the run where it has no solution?
    ends: bool,
}

/// Makes the study. `progress` is told the share that is done and what is being done.
///
/// # Errors
/// [`StudyError`], also when no point is worth drawing.
pub fn study(request: &Request, progress: &mut dyn FnMut(f64, &str)) -> Result<Study, StudyError> {
    let budget = Budget::new(request.budget);
    let own = load::open(request.scene, request.overrides)?;
    let mut notes = Vec::new();
    run::left_out(&request.integrators, &request.tolerances, &request.steps).map_err(StudyError::Setting)?;
    let mut items_of = Vec::new();
    for name in &request.integrators {
        items_of.extend(run::settings(name, &request.tolerances, &request.steps).map_err(StudyError::Setting)?);
    }
    let (variants, prepared) = prepare(request, &mut notes)?;
    if prepared.is_empty() {
        return Err(StudyError::Refused(format!("no formulation can start the scene: {}", notes.join("; "))));
    }
    let full = Span { stop: request.stop.unwrap_or(own.run.stop), step: request.step };
    let mut pilots = Vec::new();
    let (pilot_start, mut pilot_cpu) = (budget.spent(), 0.0);
    for (index, one) in prepared.iter().enumerate() {
        progress(budget.spent() / budget.seconds, &format!("pilot run of {}", variants[index].label()));
        let (pilot, cpu) = cpu_time(|| pilot(one, full, PILOTS * budget.seconds / prepared.len() as f64));
        pilots.push(pilot);
        pilot_cpu += cpu;
    }
    let slowness = ((budget.spent() - pilot_start) / pilot_cpu).max(1.0);
    let mut schedule = Schedule::new(pilots, request.repeats, slowness);
    let span = if request.stop.is_some() { full } else { shortened(full, &schedule, &items_of, &budget, &mut notes) };

    let mut models = models(&variants, &prepared);
    for (index, shares) in turns(&models, &variants, &schedule, own.contact.formulation_name) {
        let model = &mut models[index];
        progress(budget.spent() / budget.seconds, &format!("reference of {}", model.name));
        // Of the rigid formulations ECCF comes after ACCF and is the cheaper one.
        for variant in model.variants.iter().rev() {
            let Prepared { scene, ends, .. } = &prepared[*variant];
            let formulation = (variants[*variant].formulation, scene, if *ends { ENDS } else { "" });
            let Some(pilot) = schedule.pilots[*variant] else { continue };
            let seconds = pilot.per_second * span.stop * schedule.slowness;
            model.reference = reference::reference(formulation, request.wheelset, span, (&budget, shares, seconds), request.reference);
            if model.reference.is_ok() {
                break;
            }
        }
    }

    let own_pilot = variants.iter().position(|variant| variant.formulation == own.contact.formulation_name);
    let own_cost =
        own_pilot.and_then(|variant| schedule.pilots[variant]).map_or(f64::INFINITY, |pilot| pilot.per_second * schedule.slowness);
    let coupling = !request.communication_steps.is_empty();
    let coupled = coupling && communication::duration(own_cost, span) < (1.0 - POINTS) * budget.seconds;
    let until = if coupled { POINTS } else { POINTS_ALONE };
    if coupling && !coupled {
        notes.push("communication steps: left out, the budget has no room for their reference (a larger --budget has)".into());
    }

    let mut items: Vec<Item> = Vec::new();
    let mut points: Vec<Point> = Vec::new();
    for (variant, _) in prepared.iter().enumerate() {
        let referenced = models.iter().any(|model| model.variants.contains(&variant) && model.reference.is_ok());
        for setting in &items_of {
            if referenced {
                items.push(Item { variant, setting: *setting });
            } else {
                points.push(Point { variant, setting: *setting, outcome: Outcome::Skipped("the model has no reference".into()) });
            }
        }
    }
    let patience = patience(&budget, items.len());
    while let Some((next, seconds)) = schedule.cheapest(&items, span.stop, patience) {
        let Item { variant, setting } = items.swap_remove(next);
        let left = budget.left_of(until);
        let outcome = if seconds < left {
            progress(budget.spent() / budget.seconds, &format!("{}: {}", variants[variant].label(), setting.words()));
            let limits = [(4.0 * seconds).max(1.0).min(left), patience];
            let done = run::with_setting(&prepared[variant].scene, &setting)
                .and_then(|scene| run::measure(&scene, request.wheelset, span, request.repeats, limits));
            let reference = models.iter().find(|model| model.variants.contains(&variant)).and_then(|model| model.reference.as_ref().ok());
            match (done, reference) {
                (Ok((observation, measured)), Some(reference)) => {
                    schedule.learn(Item { variant, setting }, measured.median());
                    Outcome::Done { measured, errors: Errors::between(&observation, &reference.observation) }
                }
                (Ok(_), None) => Outcome::Skipped("the model has no reference".into()),
                (Err(failure), _) => Outcome::Failed(failure),
            }
        } else if seconds.is_finite() {
            Outcome::Skipped(format!("it needs about {seconds:.1} s, {:.1} s are left", left.max(0.0)))
        } else {
            Outcome::Skipped("its pilot run did not come to an end".into())
        };
        points.push(Point { variant, setting, outcome });
    }
    points.sort_by(|a, b| place(a, request).total_cmp(&place(b, request)));
    let skipped = points.iter().filter(|point| matches!(point.outcome, Outcome::Skipped(_))).count();
    if skipped > 0 {
        notes.push(format!("{skipped} of {} points were not run (a larger --budget has room for more)", points.len()));
    }
    let differences = differences(&models);
    let mut study = Study {
        scene: own.name.clone(),
        title: own.title.clone(),
        stop: span.stop,
        step: span.step,
        wheelset: request.wheelset.map(String::from),
        budget: request.budget,
        variants,
        models,
        points,
        differences,
        coupled: Vec::new(),
        notes,
    };
    study.refuse()?;
    if coupled {
        progress(budget.spent() / budget.seconds, "communication steps");
        match communication::sweep(&own, request, span, &budget) {
            Ok(coupled) => study.coupled = coupled,
            Err(reason) => study.notes.push(format!("communication steps: left out: {reason}")),
        }
    }
    Ok(study)
}

/// Variants in the order of the formulations, then of settings: where a point stands in tables.
fn place(point: &Point, request: &Request) -> f64 {
    let method = request.integrators.iter().position(|name| *name == point.setting.integrator).unwrap_or(0);
    // Values are below 1.
    (point.variant * 1000 + method) as f64 + (1.0 - point.setting.value).clamp(0.0, 1.0) * 0.5
}

/// Opens and starts every variant; those that can't be started are noted.
fn prepare(request: &Request, notes: &mut Vec<String>) -> Result<(Vec<Variant>, Vec<Prepared>), StudyError> {
    let all = variants(&request.formulations, &request.creep_laws, &request.node_spacings, &request.smoothings);
    let (mut started, mut prepared) = (Vec::new(), Vec::new());
    let count = all.len();
    for variant in all {
        match variant.open(request.scene, request.overrides) {
            // With one formulation alone its refusal is the user's matter.
            Err(error) if count == 1 => return Err(error.into()),
            Err(error) => notes.push(format!("{}: {error}", variant.label())),
            Ok(scene) => match Simulation::new(&scene, 0.0) {
                Err(error) => notes.push(format!("{}: {error}", variant.label())),
                Ok(simulation) => {
                    let model = simulation.model();
                    let rigid = model.formulation.constrains();
                    prepared.push(Prepared { rigid, ends: rigid && !model.may_be_elastic(), scene });
                    started.push(variant);
                }
            },
        }
    }
    Ok((started, prepared))
}

/// A first run that shows what a variant costs; `None` when it did not move.
fn pilot(prepared: &Prepared, span: Span, limit: f64) -> Option<Pilot> {
    let setting = Setting { integrator: METHODS[0], fixed: false, value: PILOT_TOLERANCE };
    let mut simulation = Simulation::new(&run::with_setting(&prepared.scene, &setting).ok()?, 0.0).ok()?;
    let observed = run::observe(&mut simulation, None, span, limit, false);
    let evaluations = simulation.statistics().evaluations.max(1) as f64;
    (observed.reached > 0.0).then(|| Pilot { per_second: observed.cpu / observed.reached, per_evaluation: observed.cpu / evaluations })
}

/// Variants by model, in the order in which the models first occur.
fn models(variants: &[Variant], prepared: &[Prepared]) -> Vec<Model> {
    let mut models: Vec<Model> = Vec::new();
    for (index, (variant, one)) in variants.iter().zip(prepared).enumerate() {
        let name = variant.model(one.rigid);
        match models.iter_mut().find(|model| model.name == name) {
            Some(model) => model.variants.push(index),
            None => models.push(Model {
                name,
                rigid: one.rigid,
                variants: vec![index],
                reference: Err("a pilot run came to nothing in its share of the budget".into()),
            }),
        }
    }
    models
}

impl Model {
    /// "rigid" or "elastic".
    pub fn kind(&self) -> &'static str {
        if self.rigid { "rigid" } else { "elastic" }
    }
}

impl Study {
    /// Cost and errors of a point that was run to its end.
    pub fn done(point: &Point) -> Option<(&Measured, &Errors)> {
        if let Outcome::Done { measured, errors } = &point.outcome { Some((measured, errors)) } else { None }
    }

    /// Points of some standing.
    pub fn count(&self, quantity: Quantity, of: impl Fn(Standing) -> bool) -> usize {
        self.points.iter().filter(|point| of(self.standing(point, quantity))).count()
    }

    /// The model of a variant.
    pub fn model_of(&self, variant: usize) -> Option<&Model> {
        self.models.iter().find(|model| model.variants.contains(&variant))
    }

    /// What is known of a point's error.
    pub fn standing(&self, point: &Point, quantity: Quantity) -> Standing {
        let reference = self.model_of(point.variant).and_then(|model| model.reference.as_ref().ok());
        match (&point.outcome, reference) {
            (Outcome::Done { errors, .. }, Some(reference)) => reference.standing(errors, quantity),
            _ => Standing::Absent,
        }
    }

    /// Does the study have anything to show? References must agree 100 times better than the best point that is drawn.
    fn refuse(&self) -> Result<(), StudyError> {
        let shown = |quantity: &Quantity| self.points.iter().any(|point| matches!(self.standing(point, *quantity), Standing::Shown(_)));
        if Quantity::ALL.iter().any(shown) {
            return Ok(());
        }
        let mut words = String::from("refused: there is no point whose error is 100 times the uncertainty of its reference");
        for model in &self.models {
            words += &match &model.reference {
                Ok(reference) => format!(
                    "\n  {}: {} and {} at tolerance {:.0e} agree to {:.1e} m, {:.1e} N",
                    model.name,
                    reference.methods[0],
                    reference.methods[1],
                    reference.tolerance,
                    reference.uncertainty.y.largest,
                    reference.uncertainty.vertical.largest
                ),
                Err(reason) => format!("\n  {}: no reference: {reason}", model.name),
            };
        }
        for point in &self.points {
            if let Outcome::Failed(reason) = &point.outcome {
                words += &format!("\n  {}, {}: {reason}", self.variants[point.variant].label(), point.setting.words());
                break;
            }
        }
        words += "\n  A larger --budget gives tighter references, looser --tolerances and longer --steps larger errors.";
        Err(StudyError::Refused(words))
    }
}
