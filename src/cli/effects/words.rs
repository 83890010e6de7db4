//! The report as a table, with reasons and advice in words.

use crate::cli::{SceneArguments, table};
use crate::study::digits::{rounded, sized};
use crate::study::effects::change::{Change, Changed};
use crate::study::effects::list::Kind;
use crate::study::effects::observed::Quantity;
use crate::study::effects::run::Cost;
use crate::study::effects::{Outcome, Report, Row};

/// The whole text; with the overrides of each row for `shown` scene.
pub(super) fn text(report: &Report, rms: bool, shown: Option<&SceneArguments>) -> String {
    let setting = |value: f64| if report.fixed { format!("step {} ms", rounded(1e3 * value)) } else { format!("tolerance {value:.0e}") };
    let kind = if rms { "root mean square" } else { "largest" };
    let mut text = format!(
        "{}: {}\n{} s, compared every {} ms; {}, {}, reference {}\n\nWhat changes ({kind}, worst wheelset, wheel or car body) when an effect is off or something else is in its place\n\n",
        report.scene,
        report.title,
        rounded(report.stop),
        rounded(1e3 * report.step),
        report.integrator,
        setting(report.setting),
        setting(report.reference_setting)
    );
    text += &changes(report, rms);
    text += "\n  below: less than twice the integration's error. Evaluations and CPU time (noisy) in parts of the scene's own run.\n  A tighter solver.tolerance tells smaller changes.\n";
    let advice = advice(report);
    if !advice.is_empty() {
        text += "\nIn words\n";
        advice.iter().for_each(|line| text += &format!("  {line}\n"));
    }
    if let Some(scene) = shown {
        text += "\nTo run a row\n";
        for row in &report.rows {
            text += &format!("  {}\n    wheelrail run {}\n", name(row), command(scene, row));
        }
    }
    text
}

/// "anti_roll_bar: off".
fn name(row: &Row) -> String {
    format!("{}: {}", row.variant.effect, row.variant.change)
}

fn command(scene: &SceneArguments, row: &Row) -> String {
    let plain = |word: &str| word.chars().all(|c| c.is_ascii_alphanumeric() || "._=-/+".contains(c));
    let quoted = |word: &String| if plain(word) { word.clone() } else { format!("'{word}'") };
    let sets = scene.overrides.iter().chain(&row.variant.overrides).map(|one| format!(" --set {}", quoted(one)));
    format!("{}{}", quoted(&scene.scene), sets.collect::<String>())
}

/// Two significant digits.
fn two(value: f64) -> String {
    let short: f64 = format!("{value:.1e}").parse().unwrap_or(value);
    if short != 0.0 && short.abs() < 1e-3 { format!("{short:e}") } else { format!("{short}") }
}

fn changes(report: &Report, rms: bool) -> String {
    let quantities: Vec<Quantity> = report.base.iter().map(|base| base.quantity).collect();
    let grows = report.growth.is_some();
    let mut head = vec![String::new()];
    head.extend(quantities.iter().map(|quantity| match quantity.unit().0 {
        "" => quantity.words().0.to_string(),
        unit => format!("{} [{unit}]", quantity.words().0),
    }));
    head.extend(grows.then(|| "growth [1/s]".to_string()));
    head.extend(["evaluations", "CPU"].map(String::from));
    let line = |label: &str, cells: Vec<String>, growth: String, cost: [String; 2]| {
        let growth = grows.then_some(growth);
        [label.to_string()].into_iter().chain(cells).chain(growth).chain(cost).collect::<Vec<_>>()
    };
    let in_units = |quantity: Quantity, value: f64| if value < quantity.rounding() { "0".into() } else { two(value / quantity.unit().1) };
    let none = || [String::new(), String::new()];
    let own = report.base.iter().map(|base| in_units(base.quantity, base.largest)).collect();
    let error = report.base.iter().map(|base| in_units(base.quantity, if rms { base.error.rms } else { base.error.largest })).collect();
    let counted = [format!("{}", report.cost.statistics.evaluations), format!("{} s", two(report.cost.cpu))];
    let mut rows = vec![
        line("largest size in the reference", own, report.growth.map_or("-".into(), two), counted),
        line("error of the integration", error, String::new(), none()),
    ];
    for row in &report.rows {
        let (cells, growth, cost) = match &row.outcome {
            Outcome::Ran { changes, growth, cost, .. } => {
                let cell = |quantity: &Quantity| {
                    let found =
                        changes.iter().find(|change| change.quantity == *quantity).map(|found| if rms { found.rms } else { found.largest });
                    match found {
                        Some(Change::Told(size)) => in_units(*quantity, size),
                        Some(Change::Below(_)) => "below".into(),
                        None => "-".into(),
                    }
                };
                (quantities.iter().map(cell).collect(), growth.map_or("-".into(), two), relative(cost, &report.cost))
            }
            other => {
                let word = match other {
                    Outcome::Failed { derailed: true, .. } => "derailed",
                    Outcome::Failed { .. } => "failed",
                    Outcome::Refused { .. } => "refused",
                    _ => "not run",
                };
                let cells = quantities.iter().enumerate().map(|(column, _)| if column == 0 { word.to_string() } else { String::new() });
                (cells.collect(), String::new(), none())
            }
        };
        rows.push(line(&name(row), cells, growth, cost));
    }
    table(&head, &rows)
}

/// Evaluations and CPU time over those of the scene's run.
fn relative(cost: &Cost, own: &Cost) -> [String; 2] {
    let evaluations = cost.statistics.evaluations as f64 / own.statistics.evaluations.max(1) as f64;
    [format!("x {evaluations:.2}"), format!("x {}", factor(cost.cpu / own.cpu.max(1e-9)))]
}

/// CPU times that differ by less are the same, in parts.
const NOISE: f64 = 0.15;
/// Where the scene's run is short, a difference below this over its CPU time, s, tells nothing: what a machine does beside it counts for more.
const HICCUP: f64 = 0.08;
/// A reason that is longer is cut.
const LONGEST: usize = 160;

/// Each effect in a line; those that change nothing, and those that are free, together.
pub(super) fn advice(report: &Report) -> Vec<String> {
    let (mut lines, mut nothing, mut waiting) = (Vec::new(), Vec::new(), Vec::<(&str, Vec<String>)>::new());
    let short = |reason: &str| {
        let cut: String = reason.chars().take(LONGEST).collect();
        format!("{cut}{}", if cut.len() < reason.len() { " ..." } else { "" })
    };
    for row in &report.rows {
        match &row.outcome {
            Outcome::Ran { changes, growth, cost, notes } => {
                let growth = report.growth.zip(*growth).filter(|(own, other)| own.signum() != other.signum());
                let told = told(changes);
                // What a switch says of itself.
                let own: Vec<&String> = notes.iter().filter(|note| note.contains("effects.")).collect();
                match told.is_empty() && growth.is_none() {
                    true => nothing.push(name(row)),
                    false => lines.push(sentence(row, &told, growth, [cost.cpu, report.cost.cpu.max(1e-9)])),
                }
                lines.extend(own.into_iter().map(|note| format!("{}: note: {note}", name(row))));
            }
            Outcome::Failed { time, derailed: true, reason } => {
                lines.push(format!("{}: derails at {time:.3} s: {}", name(row), short(reason)))
            }
            Outcome::Failed { time, reason, .. } => lines.push(format!("{}: fails at {time:.3} s: {}", name(row), short(reason))),
            Outcome::Refused { reason } => lines.push(format!("{}: refused: {}", name(row), short(reason))),
            Outcome::NotRun { reason } => match waiting.iter_mut().find(|known| known.0 == reason) {
                Some(known) => known.1.push(name(row)),
                None => waiting.push((reason, vec![name(row)])),
            },
        }
    }
    lines.extend(waiting.into_iter().map(|(reason, rows)| format!("Not run, {reason}: {}", rows.join("; "))));
    if !nothing.is_empty() {
        lines.push(format!("No change beyond the integration's error: {}", nothing.join("; ")));
    }
    lines
}

/// The two quantities that change most in parts of their size.
fn told(changes: &[Changed]) -> Vec<String> {
    let mut told: Vec<(&Changed, f64)> = changes.iter().filter_map(|change| Some((change, change.largest.told()?))).collect();
    told.sort_by(|a, b| b.0.share.unwrap_or(0.0).total_cmp(&a.0.share.unwrap_or(0.0)));
    let words = |(change, size): &(&Changed, f64)| {
        let quantity = change.quantity;
        let share = change.share.filter(|share| *share < 2.0).map_or(String::new(), |share| format!(" ({} %)", two(100.0 * share)));
        format!("{} by {}{share}", quantity.words().0, sized(*size, quantity.si(), 2))
    };
    told.iter().take(2).map(words).collect()
}

/// How many times as much: no 0.0.
fn factor(times: f64) -> String {
    match times {
        _ if times < 0.1 => format!("{times:.3}"),
        _ if times < 10.0 => format!("{times:.1}"),
        _ => format!("{times:.0}"),
    }
}

fn sentence(row: &Row, told: &[String], growth: Option<(f64, f64)>, [cpu, own]: [f64; 2]) -> String {
    let variant = &row.variant;
    let mut parts = Vec::new();
    if !told.is_empty() {
        parts.push(format!("changes {}", told.join(" and ")));
    }
    if let Some((own, other)) = growth {
        parts.push(format!("turns growth of hunting from {} to {} 1/s", two(own), two(other)));
    }
    let changes = parts.join(", ");
    let time = cpu / own;
    let (off, takes) = ((time - 1.0).abs(), factor(time));
    let stands = variant.effect.trim_start_matches("creep law ");
    let subject = match variant.kind {
        Kind::Off => variant.effect.clone(),
        Kind::On => format!("with {}", variant.effect),
        _ => format!("{} instead of {stands}", variant.change),
    };
    let costs = match variant.kind {
        Kind::Off if off < NOISE => "costs nothing to speak of".into(),
        _ if off < NOISE => "takes the same time".into(),
        _ if off < HICCUP / own => "too short runs to tell their times".into(),
        Kind::Off if time < 1.0 => format!("costs {:.0} % of the run", 100.0 * (1.0 - time)),
        Kind::Off => format!("without it the run takes {takes} times as long"),
        _ => format!("takes {takes} times as long"),
    };
    format!("{subject}: {changes}; {costs}")
}
