//! The comparison in words and as JSON.

use super::measure::{Cost, ROUNDS, Run, Times};
use super::pairs;
use super::quantity::{Apart, QUANTITIES, Samples, Trace};
use crate::cli::table;
use crate::scene::spec::Scene;
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
    /// Both rigid: the same equations in other variables.
    Numerical,
    /// Both elastic: the same force law, contact points found in another way.
    Search,
    /// Rigid against elastic.
    Models,
}

impl Kind {
    fn word(self) -> &'static str {
        match self {
            Kind::Numerical => "numerical",
            Kind::Search => "contact search",
            Kind::Models => "models",
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
        let kind = match run.rigid {
            Some(true) => "rigid:   ",
            Some(false) => "elastic: ",
            None => "",
        };
        text += &format!("  {:width$}  {kind}{}\n", run.name, run.summary);
        if let Some(failure) = &run.failure {
            text += &format!("  {:width$}  FAILED: {failure}\n", "");
        }
    }
    if comparison.runs.iter().any(|run| !run.finished() && run.samples.len() > 1) {
        text += "\n  What failed is compared as far as it came.\n";
    }
    text += &costs(comparison);
    text += &differences(comparison);
    text
}

fn costs(comparison: &Comparison) -> String {
    let done: Vec<(&Run, &Cost)> = comparison.runs.iter().filter_map(|run| Some((run, run.cost.as_ref()?))).collect();
    if done.is_empty() {
        return String::new();
    }
    let stop = comparison.times.stop;
    let mut rows: Vec<Vec<String>> = Vec::new();
    let mut row = |label: &str, value: &dyn Fn(&Cost) -> f64, always: bool| {
        let values: Vec<f64> = done.iter().map(|(_, cost)| value(cost)).collect();
        if always || values.iter().any(|value| *value > 0.0) {
            let cell = |value: f64| if value.fract() == 0.0 && value < 1e15 { format!("{value:.0}") } else { number(value) };
            rows.push([label.to_string()].into_iter().chain(values.into_iter().map(cell)).collect());
        }
    };
    row("CPU time per simulated second [ms]", &|cost| 1e3 * cost.median() / stop, true);
    row("times faster than real time", &|cost| stop / cost.median().max(1e-12), true);
    row("accepted steps", &|cost| cost.statistics.steps as f64, true);
    row("rejected steps", &|cost| cost.statistics.rejected as f64, true);
    row("evaluations of the right-hand side", &|cost| cost.statistics.evaluations as f64, true);
    row("Jacobians", &|cost| cost.statistics.linearisations as f64, false);
    row("factorisations", &|cost| cost.statistics.factorisations as f64, false);
    row("Newton iterations of the integrator", &|cost| cost.statistics.iterations as f64, false);
    row("CPU time per evaluation [us]", &|cost| 1e6 * cost.median() / cost.statistics.evaluations as f64, true);
    row("contact search: iterations or pairs of nodes", &|cost| cost.work.search_iterations as f64, false);
    row("normal against creep forces: iterations", &|cost| cost.work.force_iterations as f64, false);
    row("position constraints: iterations", &|cost| cost.work.constraint_iterations as f64, false);
    row("steps moved back onto the constraints", &|cost| cost.statistics.projections as f64, false);
    row("choices of independent variables", &|cost| cost.work.partitions as f64, false);
    row("lift-offs and landings", &|cost| cost.statistics.events as f64, false);
    let head: Vec<String> = [String::new()].into_iter().chain(done.iter().map(|(run, _)| run.name.to_string())).collect();
    format!("\nCost of the run without outputs (median of {ROUNDS} runs on one core)\n\n{}", table(&head, &rows))
}

fn differences(comparison: &Comparison) -> String {
    let Some(reference) = comparison.reference else { return String::new() };
    let shown: Vec<usize> = (0..QUANTITIES.len()).filter(|quantity| !comparison.trace(&reference.samples, *quantity).is_idle()).collect();
    let head: Vec<String> = [""].into_iter().chain(shown.iter().map(|quantity| QUANTITIES[*quantity].column)).map(String::from).collect();
    let cells = |label: String, values: &dyn Fn(usize) -> Option<f64>| -> Vec<String> {
        let cell = |quantity: usize| values(quantity).map_or("-".into(), |value| number(value * QUANTITIES[quantity].fine));
        [label].into_iter().chain(shown.iter().copied().map(cell)).collect()
    };
    let compared = comparison.compared();
    let mut rows = vec![cells(format!("for scale: largest change, {}", reference.name), &|quantity| {
        comparison.trace(&reference.samples, quantity).change()
    })];
    let mut means: Vec<Vec<String>> = Vec::new();
    for [first, second] in &compared {
        let apart = comparison.apart(&first.samples, &second.samples);
        let label = format!("{} against {} ({})", first.name, second.name, Kind::of(first, second).word());
        rows.push(cells(label.clone(), &|quantity| apart[quantity].map(|apart| apart.largest)));
        means.push(cells(label, &|quantity| apart[quantity].map(|apart| apart.rms)));
    }
    let mut text = format!("\nLargest differences at equal times\n\n{}", table(&head, &rows));
    if !means.is_empty() {
        text += &format!("\nRoot mean square of the differences\n\n{}", table(&head, &means));
    }
    let jumps = reference.samples.jumps();
    if jumps > 0 {
        text += &format!(
            "\n{}",
            wrapped(&format!(
                "Left out: {jumps} of {} samples, at which a wheel stands where the curvature of its rail jumps. The normal force of a \
                 rigid wheel jumps there too, and rounding decides which side of the jump such a sample shows.",
                reference.samples.len()
            ))
        );
    }
    if let Some(finer) = &comparison.finer {
        let own = comparison.runs.iter().filter_map(|run| Some((run, run.refined.as_ref()?)));
        let rows: Vec<Vec<String>> = own
            .map(|(run, refined)| {
                let apart = comparison.apart(&run.samples, refined);
                cells(run.name.to_string(), &|quantity| apart[quantity].map(|apart| apart.largest))
            })
            .collect();
        if !rows.is_empty() {
            let head: Vec<String> = [format!("against itself with {finer}")].into_iter().chain(head[1..].iter().cloned()).collect();
            text += &format!("\nNumerical error of each formulation\n\n{}", table(&head, &rows));
        }
    }
    text + &explanations(comparison, &compared)
}

/// What the differences mean, as far as they occur.
fn explanations(comparison: &Comparison, compared: &[[&Run; 2]]) -> String {
    let names = |rigid: bool| -> String {
        let names: Vec<&str> = comparison.runs.iter().filter(|run| run.rigid == Some(rigid)).map(|run| run.name).collect();
        names.join(" and ")
    };
    let mut text = String::new();
    let mut say = |kind: Kind, words: String| {
        if compared.iter().any(|[first, second]| Kind::of(first, second) == kind) {
            text += &format!("\n{}", wrapped(&words));
        }
    };
    say(
        Kind::Numerical,
        format!(
            "Numerical: {} hold rigid wheels on rigid rails. They solve the same equations in other variables, so exact solutions would be \
             equal; what is left is numerical error (see above).",
            names(true)
        ),
    );
    say(
        Kind::Search,
        format!(
            "Contact search: {} use the same elastic force law but find the points of contact in different ways. The difference comes \
             from the distance of the nodes (contact.node_spacing) and shrinks with its square: between them the point is that of a parabola \
             through three of them.",
            names(false)
        ),
    );
    say(
        Kind::Models,
        format!(
            "Models: rigid ({}) against elastic ({}). A rigid wheel cannot enter the rail, and the constraint gives its normal force; an \
             elastic wheel sinks in until the spring and damper of the contact carry it. These are two descriptions of the same \
             wheelset: the difference stays when the integration gets finer. Where the wheels stay on the rails, it is in z the \
             depth of that sinking, and in N the short ringing of the contact springs after a jump of the rail's curvature.",
            names(true),
            names(false)
        ),
    );
    text
}

/// Lines of at most 110 characters.
fn wrapped(words: &str) -> String {
    const WIDTH: usize = 110;
    let mut lines = vec![String::new()];
    for word in words.split_whitespace() {
        let last = lines.len() - 1;
        if lines[last].is_empty() {
            lines[last] = word.into();
        } else if lines[last].len() + 1 + word.len() <= WIDTH {
            lines[last] += &format!(" {word}");
        } else {
            lines.push(word.into());
        }
    }
    lines.join("\n") + "\n"
}

/// Everything in SI units.
pub(super) fn json(comparison: &Comparison, pictures: &[PathBuf]) -> Value {
    let stop = comparison.times.stop;
    let apart = |first: &Samples, second: &Samples| -> Map<String, Value> {
        let apart = comparison.apart(first, second);
        QUANTITIES.iter().zip(apart).map(|(quantity, apart)| (quantity.key.to_string(), json!(apart))).collect()
    };
    let formulations: Vec<Value> = comparison
        .runs
        .iter()
        .map(|run| {
            let cost = run.cost.as_ref().map(|cost| {
                json!({
                    "cpu_seconds_per_simulated_second": cost.median() / stop,
                    "real_time_factor": stop / cost.median().max(1e-12),
                    "cpu_seconds_per_evaluation": cost.median() / cost.statistics.evaluations as f64,
                    "cpu_seconds": cost.seconds, "statistics": cost.statistics, "work": cost.work,
                })
            });
            let changes: Map<String, Value> = QUANTITIES
                .iter()
                .enumerate()
                .map(|(index, quantity)| (quantity.key.to_string(), json!(comparison.trace(&run.samples, index).change())))
                .collect();
            json!({
                "name": run.name, "rigid": run.rigid, "error": run.failure, "cost": cost, "largest_changes": changes,
                "numerical_error": run.refined.as_ref().map(|refined| apart(&run.samples, refined)),
            })
        })
        .collect();
    let differences: Vec<Value> = comparison
        .compared()
        .into_iter()
        .map(|[first, second]| {
            json!({
                "first": first.name, "second": second.name, "kind": Kind::of(first, second).word(),
                "quantities": apart(&first.samples, &second.samples),
            })
        })
        .collect();
    json!({
        "scene": comparison.scene.name, "wheelset": comparison.wheelset, "title": comparison.scene.title, "stop": stop, "step": comparison.times.step,
        "reference": comparison.reference.map(|run| run.name), "finer": comparison.finer,
        "formulations": formulations, "differences": differences,
        "pictures": pictures.iter().map(|file| file.display().to_string()).collect::<Vec<_>>(),
    })
}
