//! Runs a case in one formulation with all its methods and says what holds.

use super::case::{Bound, Case, Method, Must};
use super::finding::{Finding, Unit};
use super::open;
use super::run::{End, Look, Ran, exchanged, restored, run};
use super::trace::Trace;
use crate::scene::spec::Scene;
use crate::sim::Simulation;
use crate::study::accuracy::cpu_time;
use serde::Serialize;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// CPU time that one run may take, s, and a reference: machines differ by a factor of two, and the longest reference takes 55 s on one.
const LIMIT: f64 = 90.0;
const REFERENCE_LIMIT: f64 = 240.0;
/// A refusal comes within this, s; so does a start.
const REFUSAL: f64 = 2.0;
/// The references' distance may be at most this share of a bound.
const SURE: f64 = 0.25;

/// What became of a case with one formulation and method.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "lowercase", tag = "outcome")]
pub enum Outcome {
    /// Every number is within its bound.
    Held { findings: Vec<Finding> },
    /// The program says that it can't, why, and what to do.
    Refused { reason: String },
    /// A number is not within its bound, or the run ended where it must not.
    Broken { findings: Vec<Finding>, reason: String },
}

/// One row of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Judged {
    pub case: &'static str,
    pub formulation: &'static str,
    /// "rosenbrock 1e-5"; empty where nothing was run.
    pub method: String,
    #[serde(flatten)]
    pub outcome: Outcome,
    /// CPU time, s.
    pub cpu: f64,
    pub steps: u64,
    /// What shows it on the command line.
    pub command: String,
}

impl Outcome {
    pub fn is_broken(&self) -> bool {
        matches!(self, Outcome::Broken { .. })
    }

    /// The number that is nearest to its bound, or beyond it.
    pub fn worst(&self) -> Option<&Finding> {
        match self {
            Outcome::Held { findings } | Outcome::Broken { findings, .. } => {
                findings.iter().filter(|finding| finding.bound > 0.0 || !finding.holds()).max_by(|a, b| a.strain().total_cmp(&b.strain()))
            }
            Outcome::Refused { .. } => None,
        }
    }

    /// In one line.
    pub fn words(&self) -> String {
        match self {
            Outcome::Held { .. } => self.worst().map(Finding::words).unwrap_or_default(),
            Outcome::Refused { reason } => reason.clone(),
            Outcome::Broken { findings, reason } => {
                let beyond: Vec<String> = findings.iter().filter(|finding| !finding.holds()).map(Finding::words).collect();
                [reason.clone(), beyond.join("; ")].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("; ")
            }
        }
    }
}

/// What is said of a reference that did not start.
const START: &str = "the start is refused: ";

/// Where contacts are constraints, fixed steps meet their changes of place too late to be a check: another adaptive method is.
fn checked([first, second]: &[Method; 2], formulation: &str) -> [Method; 2] {
    let rigid = matches!(formulation, "ECCF" | "ACCF") && second.is_fixed() && first.integrator == "dormand_prince";
    [*first, if rigid { Method::new("rk43", "tolerance=1e-8") } else { *second }]
}

/// Runs a case with one of its formulations and some of its methods.
pub fn judge(case: &Case, formulation: &'static str, methods: &[Method]) -> Vec<Judged> {
    let folder = match open::folder(case) {
        Ok(folder) => folder,
        Err(reason) => return vec![row(case, formulation, None, Outcome::Broken { findings: vec![], reason }, 0.0, 0)],
    };
    let path = folder.as_ref().map(tempfile::TempDir::path);
    let scene = |method: &Method| {
        let more: Vec<String> = open::formulation(formulation).into_iter().chain(method.changes()).collect();
        open::open(case, path, &more).map_err(|error| error.to_string())
    };
    if let Some(words) = case.must.iter().find_map(|must| if let Must::Refusal(words) = must { Some(*words) } else { None }) {
        return methods.iter().map(|method| refusal(case, formulation, method, words, &scene)).collect();
    }
    let reference = case.must.iter().find_map(|must| match must {
        Must::Reference { methods, bounds } => Some((methods, *bounds)),
        _ => None,
    });
    let mut found = Vec::new();
    let mut tight = None;
    if let Some((tighter, bounds)) = reference {
        match references(case, &checked(tighter, formulation), bounds, &scene) {
            // A start that may be refused is judged with the methods.
            Err((_, reason)) if case.refusable && reason.starts_with(START) => {}
            Ok(trace) => tight = Some((trace, bounds)),
            Err((findings, reason)) => {
                found.push(row(case, formulation, Some(&tighter[0]), Outcome::Broken { findings, reason }, 0.0, 0));
            }
        }
    }
    for method in methods {
        let judged = guarded(|| one(case, formulation, method, tight.as_ref().map(|(trace, bounds)| (trace, *bounds)), &scene));
        found.push(
            judged.unwrap_or_else(|reason| row(case, formulation, Some(method), Outcome::Broken { findings: vec![], reason }, 0.0, 0)),
        );
    }
    found
}

/// A panic in words.
pub(super) fn guarded<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|cause| {
        let words = cause.downcast_ref::<String>().cloned().or_else(|| cause.downcast_ref::<&str>().map(|text| (*text).to_string()));
        format!("panic: {}", words.unwrap_or_default())
    })
}

fn row(case: &Case, formulation: &'static str, method: Option<&Method>, outcome: Outcome, cpu: f64, steps: u64) -> Judged {
    let mut command = format!("wheelrail run {}", case.scene);
    if case.text.is_some() || case.files.is_some() || !case.inputs.is_empty() {
        command = format!("wheelrail hard {} --formulation {formulation}", case.name);
    } else {
        let own = case.changes.iter().map(ToString::to_string).chain(open::formulation(formulation));
        for change in own.chain(method.into_iter().flat_map(Method::changes)) {
            command += &format!(" --set '{change}'");
        }
        command += &format!(" --stop {} --step {}", case.stop, case.grid);
    }
    Judged { case: case.name, formulation, method: method.map(Method::words).unwrap_or_default(), outcome, cpu, steps, command }
}

type Open<'a> = &'a dyn Fn(&Method) -> Result<Scene, String>;

/// Two tight runs; the first one's trace where they agree.
fn references(case: &Case, methods: &[Method; 2], bounds: &[Bound], scene: Open) -> Result<Trace, (Vec<Finding>, String)> {
    let look = Look { stop: case.stop, grid: case.grid, inputs: case.inputs, limit: REFERENCE_LIMIT, audit: case.audit };
    let tight = |method: &Method| -> Result<Ran, String> {
        let scene = scene(method).map_err(|error| format!("{START}{error}"))?;
        let ran = guarded(|| {
            let mut simulation = Simulation::new(&scene, 0.0).map_err(|error| format!("{START}{error}"))?;
            Ok::<Ran, String>(run(&scene, &mut simulation, &look))
        })??;
        match &ran.end {
            End::Stopped { words, .. } => Err(format!("reference {}: {words}", method.words())),
            End::Late { time, limit } => Err(format!("reference {}: at t = {time:.3} s after {limit} s of CPU time", method.words())),
            _ => Ok(ran),
        }
    };
    let fail = |reason: String| (vec![], reason);
    let (first, second) = (tight(&methods[0]).map_err(fail)?, tight(&methods[1]).map_err(fail)?);
    let findings: Vec<Finding> = compare(&first, &second.trace, bounds, "distance of the references in", SURE);
    match findings.iter().all(Finding::holds) {
        true => Ok(first.trace),
        false => Err((findings, format!("{} and {} disagree", methods[0].words(), methods[1].words()))),
    }
}

/// Largest distances of two runs against `share` of the bounds.
fn compare(found: &Ran, right: &Trace, bounds: &[Bound], what: &str, share: f64) -> Vec<Finding> {
    let one = |bound: &Bound| {
        let (size, time) = found.trace.distance(right, bound.quantity, found.rigid, bound.shift);
        let words = format!("{what} {} at t = {time:.4} s", bound.quantity.words());
        // Of the static load, or of the largest force where that is more: an impact's height is known to a share of itself.
        let load = found.load.max(if bound.quantity.is_force() { right.largest(bound.quantity) } else { 0.0 });
        match bound.quantity.is_force() {
            true => Finding::new(words, size / load, share * bound.most, Unit::Share),
            false => Finding::new(words, size, share * bound.most, bound.quantity.unit()),
        }
    };
    bounds.iter().map(one).collect()
}

fn one(case: &Case, formulation: &'static str, method: &Method, tight: Option<(&Trace, &[Bound])>, open: Open) -> Judged {
    let refused = |reason: String| {
        let outcome = match case.refusable || method.is_fixed() && reason.contains("solver.step") {
            true => Outcome::Refused { reason },
            false => Outcome::Broken { findings: vec![], reason: format!("refused: {reason}") },
        };
        row(case, formulation, Some(method), outcome, 0.0, 0)
    };
    let started = || {
        let scene = open(method)?;
        Simulation::new(&scene, 0.0).map(|simulation| (scene, simulation)).map_err(|error| error.to_string())
    };
    let (started, start) = cpu_time(started);
    let (scene, mut simulation) = match started {
        Ok(started) => started,
        Err(reason) => return refused(reason),
    };
    let look = Look { stop: case.stop, grid: case.grid, inputs: case.inputs, limit: LIMIT, audit: case.audit };
    let ran = run(&scene, &mut simulation, &look);
    let (cpu, steps) = (ran.cpu, ran.statistics.steps);
    let row = |outcome| row(case, formulation, Some(method), outcome, cpu, steps);
    let mut reason = match &ran.end {
        End::Finished => String::new(),
        End::Derailed { .. } if case.audit.derailment => String::new(),
        End::Derailed { words, .. } => words.clone(),
        // A step that is too long for the case and says so is a refusal.
        End::Stopped { words, .. } if method.is_fixed() && words.contains("solver.step") => {
            return row(Outcome::Refused { reason: words.clone() });
        }
        End::Stopped { words, .. } => words.clone(),
        End::Late { time, limit } => format!("at t = {time:.3} s after {limit} s of CPU time"),
    };
    let mut findings = ran.audit.findings([0.0; 2]);
    if let Some((trace, bounds)) = tight {
        findings.extend(compare(&ran, trace, bounds, "error of", 1.0));
    }
    for must in case.must {
        match must {
            Must::Formula(formula) => findings.extend(formula(&ran)),
            Must::Exchanges(count) => {
                if let Err(words) = exchanged(&scene, &look, *count) {
                    reason = if reason.is_empty() { words } else { format!("{reason}; {words}") };
                }
            }
            Must::Reference { .. } | Must::Refusal(_) => {}
        }
    }
    // Starts are as quick as refusals.
    findings.push(Finding::new("time to start", start, REFUSAL, Unit::Second));
    if let Err(words) = restored(&scene, &look, &ran) {
        reason = if reason.is_empty() { words } else { format!("{reason}; {words}") };
    }
    let holds = reason.is_empty() && findings.iter().all(Finding::holds);
    let doubts = simulation.doubts();
    row(if holds {
        Outcome::Held { findings }
    } else if doubts.steps > 0 {
        // The run says itself that it is not to be believed, and what to do.
        Outcome::Refused { reason: format!("warned: {doubts}") }
    } else {
        Outcome::Broken { findings, reason }
    })
}

/// A scene that must be refused in these words, or run to its end.
fn refusal(case: &Case, formulation: &'static str, method: &Method, words: &[&str], open: Open) -> Judged {
    let tried = || {
        let scene = open(method)?;
        let mut simulation = Simulation::new(&scene, 0.0).map_err(|error| error.to_string())?;
        simulation.advance(case.stop).map_err(|error| error.to_string())
    };
    let (tried, seconds) = cpu_time(|| guarded(tried));
    let time = Finding::new("time to be refused", seconds, REFUSAL, Unit::Second);
    let outcome = match tried {
        Err(panic) => Outcome::Broken { findings: vec![time], reason: panic },
        Ok(Ok(())) => Outcome::Broken { findings: vec![time], reason: "it runs, but makes no sense".into() },
        Ok(Err(reason)) => {
            let missing: Vec<&str> = words.iter().copied().filter(|word| !reason.contains(word)).collect();
            match (missing.as_slice(), time.holds()) {
                ([], true) => Outcome::Refused { reason },
                ([], false) => Outcome::Broken { findings: vec![time], reason },
                _ => Outcome::Broken { findings: vec![time], reason: format!("\"{reason}\" does not say \"{}\"", missing.join("\", \"")) },
            }
        }
    };
    row(case, formulation, Some(method), outcome, seconds, 0)
}
