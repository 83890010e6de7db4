//! The comparison in words and as JSON.

use super::measure::{ROUNDS, Run};
use super::pairs;
use super::quantity::{Apart, QUANTITIES, Samples, Trace};
use crate::cli::plot::wrapped;
use crate::cli::{file_names, table};
use crate::scene::spec::Scene;
use crate::sim::recording::Times;
use crate::study::accuracy::Measured;
use crate::study::digits::rounded;
use serde_json::{Map, Value, json};
use std::path::PathBuf;

/// Everything that was found.
pub(super) struct Comparison<'a> {
    pub scene: &'a Scene,
    /// Name of the wheelset that is compared.
    pub wheelset: &'a str,
    pub times: Times,
    /// How the finer integration is written in a scene, if there is one.
    pub finer: Option<String>,
    pub runs: &'a [Run],
    pub reference: Option<&'a Run>,
}

/// Why two formulations differ.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Both rigid.
    Numerical,
    /// Both elastic.
    Search,
    /// Rigid against elastic.
    Models,
}

impl Kind {
    /// In a word, and what that means.
    fn words(self) -> [&'static str; 2] {
        match self {
            Kind::Numerical => ["numerical", "the same equations in other variables; what is left is numerical error."],
            Kind::Search => {
                ["contact search", "the same elastic law, places found in other ways; falls with the square of contact.node_spacing."]
            }
            Kind::Models => [
                "models",
                "a rigid wheel can't enter the rail, an elastic one sinks in: two descriptions of the same wheelset, whose difference stays \
                 when the integration gets finer. In z it is the penetration, in N the ringing of the contact springs behind a jump of the \
                 rail's curvature.",
            ],
        }
    }

    fn of(first: &Run, second: &Run) -> Kind {
        match (first.rigid, second.rigid) {
            (Some(true), Some(true)) => Kind::Numerical,
            (Some(false), Some(false)) => Kind::Search,
            _ => Kind::Models,
        }
    }
}

impl<'a> Comparison<'a> {
    fn trace(&self, samples: &Samples, quantity: usize) -> Trace {
        samples.trace(self.wheelset, &QUANTITIES[quantity])
    }

    /// How far two runs are apart in each quantity.
    fn apart(&self, first: &Samples, second: &Samples) -> [Option<Apart>; QUANTITIES.len()] {
        std::array::from_fn(|quantity| self.trace(first, quantity).apart(&self.trace(second, quantity)))
    }

    /// Pairs that are drawn, then every other formulation against the reference.
    fn compared(&self) -> Vec<[&'a Run; 2]> {
        let mut compared = pairs(self.runs);
        if let Some(reference) = self.reference {
            for run in self.runs.iter().filter(|run| run.samples.len() > 1 && run.name != reference.name) {
                if !compared.iter().any(|pair| pair.iter().all(|known| [run.name, reference.name].contains(&known.name))) {
                    compared.push([run, reference]);
                }
            }
        }
        compared
    }
}

/// Three digits or so.
fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".into()
    } else if !(1e-3..1e7).contains(&size) {
        format!("{value:.1e}")
    } else {
        let decimals = (2 - size.log10().floor() as i32).max(0) as usize;
        format!("{value:.decimals$}")
    }
}

/// The whole text for a person.
pub(super) fn text(comparison: &Comparison) -> String {
    let Times { stop, step } = comparison.times;
    let width = comparison.runs.iter().map(|run| run.name.len()).max().unwrap_or(0);
    let mut text = format!("{}\n{stop} s with each formulation, sampled every {} ms\n\n", comparison.scene.title, rounded(1e3 * step));
    for run in comparison.runs {
        let kind = run.rigid.map_or("", |rigid| if rigid { "rigid:   " } else { "elastic: " });
        text += &format!("  {:width$}  {kind}{}\n", run.name, run.summary);
        if let Some(failure) = &run.failure {
            text += &format!("  {:width$}  FAILED: {failure}\n", "");
        }
    }
    if comparison.runs.iter().any(|run| !run.finished() && run.samples.len() > 1) {
        text += "\n  What failed is compared as far as it came.\n";
    }
    text + &costs(comparison) + &differences(comparison)
}

/// A row of the table of costs: label, is it there where all are 0, value of a run over so many seconds.
type CostRow = (&'static str, bool, fn(&Measured, f64) -> f64);
const COSTS: [CostRow; 15] = [
    ("CPU time per simulated second [ms]", true, |cost, _| 1e3 * cost.median()),
    ("times faster than real time", true, |cost, _| 1.0 / cost.median().max(1e-12)),
    ("accepted steps", true, |cost, _| cost.statistics.steps as f64),
    ("rejected steps", true, |cost, _| cost.statistics.rejected as f64),
    ("evaluations of the right-hand side", true, |cost, _| cost.statistics.evaluations as f64),
    ("Jacobians", false, |cost, _| cost.statistics.linearisations as f64),
    ("factorisations", false, |cost, _| cost.statistics.factorisations as f64),
    ("Newton iterations of the integrator", false, |cost, _| cost.statistics.iterations as f64),
    ("CPU time per evaluation [us]", true, |cost, stop| 1e6 * stop * cost.median() / cost.statistics.evaluations as f64),
    ("contact search: iterations or pairs of nodes", false, |cost, _| cost.work.search_iterations as f64),
    ("normal against creep forces: iterations", false, |cost, _| cost.work.force_iterations as f64),
    ("position constraints: iterations", false, |cost, _| cost.work.constraint_iterations as f64),
    ("steps moved back onto the constraints", false, |cost, _| cost.statistics.projections as f64),
    ("choices of independent variables", false, |cost, _| cost.work.partitions as f64),
    ("lift-offs and landings", false, |cost, _| cost.statistics.events as f64),
];

fn costs(comparison: &Comparison) -> String {
    let done: Vec<(&Run, &Measured)> = comparison.runs.iter().filter_map(|run| Some((run, run.cost.as_ref()?))).collect();
    if done.is_empty() {
        return String::new();
    }
    let cell = |value: &f64| if value.fract() == 0.0 && *value < 1e15 { format!("{value:.0}") } else { number(*value) };
    let row = |(label, always, value): &CostRow| {
        let values: Vec<f64> = done.iter().map(|(_, cost)| value(cost, comparison.times.stop)).collect();
        let shown = *always || values.iter().any(|value| *value > 0.0);
        shown.then(|| [label.to_string()].into_iter().chain(values.iter().map(cell)).collect())
    };
    let rows: Vec<Vec<String>> = COSTS.iter().filter_map(row).collect();
    let head: Vec<String> = [String::new()].into_iter().chain(done.iter().map(|(run, _)| run.name.to_string())).collect();
    format!("\nCost of the run without outputs (median of {ROUNDS} runs on one core)\n\n{}", table(&head, &rows))
}

fn differences(comparison: &Comparison) -> String {
    let Some(reference) = comparison.reference else { return String::new() };
    let shown: Vec<usize> = (0..QUANTITIES.len()).filter(|quantity| !comparison.trace(&reference.samples, *quantity).is_idle()).collect();
    let head = |first: &str| {
        [first].into_iter().chain(shown.iter().map(|quantity| QUANTITIES[*quantity].column.0)).map(String::from).collect::<Vec<_>>()
    };
    let cells = |label: String, values: &dyn Fn(usize) -> Option<f64>| -> Vec<String> {
        let cell = |quantity: &usize| values(*quantity).map_or("-".into(), |value| number(value * QUANTITIES[*quantity].column.1));
        [label].into_iter().chain(shown.iter().map(cell)).collect()
    };
    let scale = cells(format!("for scale: largest change, {}", reference.name), &|quantity| {
        comparison.trace(&reference.samples, quantity).change()
    });
    let (mut largest, mut means) = (vec![scale], Vec::new());
    let compared = comparison.compared();
    for [first, second] in &compared {
        let apart = comparison.apart(&first.samples, &second.samples);
        let label = format!("{} against {} ({})", first.name, second.name, Kind::of(first, second).words()[0]);
        largest.push(cells(label.clone(), &|quantity| apart[quantity].map(|apart| apart.largest)));
        means.push(cells(label, &|quantity| apart[quantity].map(|apart| apart.rms)));
    }
    let mut text = format!("\nLargest differences at equal times\n\n{}", table(&head(""), &largest));
    if !means.is_empty() {
        text += &format!("\nRoot mean square of the differences\n\n{}", table(&head(""), &means));
    }
    let jumps = reference.samples.jumps();
    if jumps > 0 {
        let all = reference.samples.len();
        text += &format!(
            "\nLeft out: {jumps} of {all} samples, on jumps of a rail's curvature: a rigid wheel's normal force has two values there.\n"
        );
    }
    let refined = comparison.runs.iter().filter_map(|run| Some((run, comparison.apart(&run.samples, run.refined.as_ref()?))));
    let errors: Vec<Vec<String>> =
        refined.map(|(run, apart)| cells(run.name.into(), &|quantity| apart[quantity].map(|apart| apart.largest))).collect();
    if let (Some(finer), false) = (&comparison.finer, errors.is_empty()) {
        text += &format!("\nNumerical error of each formulation\n\n{}", table(&head(&format!("against itself with {finer}")), &errors));
    }
    text + &explanations(&compared)
}

/// What the differences mean, as far as they occur.
fn explanations(compared: &[[&Run; 2]]) -> String {
    let occurs = |kind: &Kind| compared.iter().any(|[first, second]| Kind::of(first, second) == *kind);
    let told = [Kind::Numerical, Kind::Search, Kind::Models].into_iter().filter(occurs);
    told.map(|kind| format!("\n{}\n", wrapped(&kind.words().join(": "), 110).join("\n"))).collect()
}

/// Everything in SI units.
pub(super) fn json(comparison: &Comparison, pictures: &[PathBuf]) -> Value {
    let stop = comparison.times.stop;
    let of_each = |value: &dyn Fn(usize) -> Value| -> Map<String, Value> {
        QUANTITIES.iter().enumerate().map(|(index, quantity)| (quantity.key.to_string(), value(index))).collect()
    };
    let apart = |first: &Samples, second: &Samples| {
        let apart = comparison.apart(first, second);
        of_each(&|quantity| json!(apart[quantity]))
    };
    let cost = |cost: &Measured| {
        json!({
            "cpu_seconds_per_simulated_second": cost.median(), "real_time_factor": 1.0 / cost.median().max(1e-12),
            "cpu_seconds_per_evaluation": cost.median() * stop / cost.statistics.evaluations as f64,
            "cpu_seconds": cost.cpu.iter().map(|seconds| seconds * stop).collect::<Vec<_>>(),
            "statistics": cost.statistics, "work": cost.work,
        })
    };
    let run = |run: &Run| {
        json!({
            "name": run.name, "rigid": run.rigid, "error": run.failure, "cost": run.cost.as_ref().map(cost),
            "largest_changes": of_each(&|quantity| json!(comparison.trace(&run.samples, quantity).change())),
            "numerical_error": run.refined.as_ref().map(|refined| apart(&run.samples, refined)),
        })
    };
    let difference = |[first, second]: [&Run; 2]| {
        let (kind, quantities) = (Kind::of(first, second).words()[0], apart(&first.samples, &second.samples));
        json!({"first": first.name, "second": second.name, "kind": kind, "quantities": quantities})
    };
    json!({
        "scene": comparison.scene.name, "wheelset": comparison.wheelset, "title": comparison.scene.title, "stop": stop, "step": comparison.times.step,
        "reference": comparison.reference.map(|run| run.name), "finer": comparison.finer,
        "formulations": comparison.runs.iter().map(run).collect::<Vec<_>>(),
        "differences": comparison.compared().into_iter().map(difference).collect::<Vec<_>>(),
        "pictures": file_names(pictures),
    })
}
