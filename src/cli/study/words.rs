//! The study in words: the references, what to choose for an accuracy, how far models differ, what gave no number.

use super::csv::machine;
use crate::cli::table;
use crate::study::accuracy::{Apart, Best, COUPLING, FACTOR, HOLDS, Outcome, Point, Quantity, Standing, StudiedModel, Study, best};
use crate::study::digits::{rounded, sized};
use serde_json::{Value, json};

/// Accuracies that are asked for, SI.
const LEVELS: [(Quantity, &[f64]); 6] = [
    (Quantity::Displacement, &[1e-3, 1e-4, 1e-5, 1e-6, 1e-7]),
    (Quantity::WheelLoad, &[1e3, 1e2, 1e1, 1.0]),
    (Quantity::NormalForce, &[1e3, 1e2, 1e1, 1.0]),
    (Quantity::DerailmentQuotient, &[1e-2, 1e-3, 1e-4]),
    (Quantity::Acceleration, &[1.0, 0.1, 0.01, 1e-3]),
    (Quantity::Wavelength, &[1.0, 0.1, 0.01]),
];

fn size(value: f64, quantity: Quantity) -> String {
    sized(value, quantity.unit(), 2)
}

/// "rigid contact (ACCF, ECCF)".
pub(super) fn model_words(study: &Study, model: &StudiedModel) -> String {
    let names: Vec<&str> = model.variants.iter().map(|variant| study.variants[*variant].formulation).collect();
    let changes = model.variants.first().map(|variant| study.variants[*variant].changes()).filter(|changes| !changes.is_empty());
    format!("{} contact ({}){}", model.kind(), names.join(", "), changes.map(|changes| format!(", {changes}")).unwrap_or_default())
}

/// Accuracies that are smaller than the model's motion itself.
fn sensible(model: &StudiedModel, quantity: Quantity, levels: &[f64]) -> Vec<f64> {
    let motion = model.reference.as_ref().ok().and_then(|reference| reference.motion.of(quantity)).unwrap_or(f64::INFINITY);
    levels.iter().copied().filter(|level| *level < motion).collect()
}

/// The whole text.
pub(super) fn text(study: &Study) -> String {
    let whose = study.wheelset.as_deref().map_or("the worst wheelset and wheel count".into(), |name| format!("errors of {name}"));
    let mut text =
        format!("{}\n{} s, outputs every {} ms, {whose}; {}\n", study.title, rounded(study.stop), rounded(1e3 * study.step), machine());
    for note in &study.notes {
        text += &format!("  note: {note}\n");
    }
    text += &references(study);
    text += "\nWhat to choose: the cheapest way to a numerical error, against the reference of the same model\n";
    for (quantity, levels) in LEVELS {
        text += &choices(study, quantity, levels);
    }
    text + &differences(study) + &coupling(study) + &counts(study)
}

fn references(study: &Study) -> String {
    let head = ["model", "tolerance", "y [m]", "Q [N]", "N [N]", "Y/Q", "a [m/s2]", "wavelength [m]", "waves of [m]"].map(String::from);
    let (mut rows, mut missing, mut methods) = (Vec::new(), String::new(), String::new());
    for model in &study.models {
        match &model.reference {
            Ok(reference) => {
                let cell = |quantity: Quantity| reference.uncertainty.of(quantity).map_or("-".into(), |value| format!("{value:.1e}"));
                let mut row = vec![model_words(study, model), format!("{:.0e}", reference.tolerance)];
                row.extend(Quantity::ALL.map(cell));
                row.push(reference.wavelength.map_or("-".into(), |length| format!("{length:.3}")));
                rows.push(row);
                methods = reference.methods.join(" and ");
            }
            Err(reason) => missing += &format!("  {}: no reference: {reason}\n", model_words(study, model)),
        }
    }
    let table = table(&head, &rows);
    format!("\nReferences: distance of two methods, {methods}; errors below {FACTOR} times that are not resolved\n\n{table}{missing}")
}

/// A table of the cheapest points for a quantity.
fn choices(study: &Study, quantity: Quantity, levels: &[f64]) -> String {
    let head = [quantity.words(), "to", "use", "with", "error", "ms per simulated second", "times real time"].map(String::from);
    if study.count(quantity, |standing| standing != Standing::Absent) == 0 {
        return format!("\n  {}: absent, or moves by less than the references can tell\n", quantity.words());
    }
    let mut rows: Vec<Vec<String>> = Vec::new();
    for (index, model) in study.models.iter().enumerate().filter(|(_, model)| model.reference.is_ok()) {
        let levels = sensible(model, quantity, levels);
        let found = best(study, index, quantity, &levels);
        let mut own: Vec<Vec<String>> = found.iter().filter_map(|one| choice(study, quantity, one)).collect();
        let reached = found.last().and_then(|one| one.levels.last()).copied().unwrap_or(f64::INFINITY);
        // Where the reference tells nothing of a model, there is nothing to be reached.
        let told =
            study.points.iter().any(|point| model.variants.contains(&point.variant) && study.standing(point, quantity) != Standing::Absent);
        if let Some(next) = levels.iter().find(|level| told && **level < reached) {
            own.push([String::new(), size(*next, quantity), "not reached".into()].into_iter().chain((3..7).map(|_| "-".into())).collect());
        }
        if let Some(first) = own.first_mut() {
            first[0] = model_words(study, model);
        }
        rows.extend(own);
    }
    if rows.is_empty() {
        return format!("\n  {}: changes by less than any accuracy here\n", quantity.words());
    }
    format!("\n{}", table(&head, &rows))
}

fn choice(study: &Study, quantity: Quantity, one: &Best) -> Option<Vec<String>> {
    let point = &study.points[one.point];
    let seconds = Study::done(point)?.0.median();
    let levels: Vec<String> = one.levels.iter().map(|level| size(*level, quantity)).collect();
    let bound = if matches!(study.standing(point, quantity), Standing::Below(_)) { "< " } else { "" };
    let factor = 1.0 / seconds;
    Some(vec![
        String::new(),
        levels.join(", "),
        study.variants[point.variant].label(),
        point.setting.words(),
        format!("{bound}{}", size(one.error, quantity)),
        sized(1e3 * seconds, "", 2),
        if factor < 9.95 { format!("{factor:.1}") } else { format!("{factor:.0}") },
    ])
}

fn differences(study: &Study) -> String {
    let mut text = String::new();
    for difference in &study.differences {
        let [first, second] = [difference.first, difference.second].map(|model| model_words(study, &study.models[model]));
        let part = |quantity: Quantity| {
            let apart = study.apart(difference, quantity)?;
            Some(match apart {
                Apart::Told(value) => format!("{} {}", quantity.words(), size(value, quantity)),
                Apart::Untold => format!("{} below the references' uncertainty", quantity.words()),
            })
        };
        let parts: Vec<String> = Quantity::ALL.into_iter().filter_map(part).collect();
        text += &format!("  {first} against {second}: {}\n", parts.join(", "));
    }
    if text.is_empty() {
        text
    } else {
        format!("\nDifferences of models: no numerical error, they stay however fine the integration is\n\n{text}")
    }
}

fn coupling(study: &Study) -> String {
    let Some(one) = study.coupled.first() else { return String::new() };
    let mut steps: Vec<f64> = study.coupled.iter().map(|coupled| coupled.step).collect();
    steps.sort_by(f64::total_cmp);
    steps.dedup();
    let head = steps.iter().map(|step| format!("{} ms", rounded(1e3 * step)));
    let head: Vec<String> = ["largest error of y at a communication step of".to_string()].into_iter().chain(head).collect();
    let row = |(hold, words): (usize, &&str)| {
        let cell = |step: &f64| {
            let found = study.coupled.iter().find(|coupled| coupled.hold == hold && coupled.step == *step);
            found.map_or("-".into(), |coupled| {
                let below = if coupled.errors.y.largest < coupled.floor { "< " } else { "" };
                format!("{below}{}", size(coupled.errors.y.largest.max(coupled.floor), Quantity::Displacement))
            })
        };
        [format!("input {words}")].into_iter().chain(steps.iter().map(cell)).collect()
    };
    let rows: Vec<Vec<String>> = HOLDS.iter().enumerate().map(row).collect();
    format!("\nCommunication step: {COUPLING} ({}, {})\n\n{}", one.formulation, one.setting.words(), table(&head, &rows))
}

/// Points that gave nothing, with their reasons.
fn counts(study: &Study) -> String {
    let mut text = String::new();
    for quantity in Quantity::ALL {
        let done = study.points.iter().filter(|point| Study::done(point).is_some()).count();
        let absent = study.count(quantity, |standing| standing == Standing::Absent) + done - study.points.len();
        let counts = [
            (study.count(quantity, |standing| matches!(standing, Standing::Below(_))), "better than the reference can tell"),
            (study.count(quantity, |standing| standing == Standing::Useless), "with errors larger than the motion"),
            // Where no point has it the choices have said so.
            (if absent < done { absent } else { 0 }, "without it"),
        ];
        let parts: Vec<String> = counts.iter().filter(|one| one.0 > 0).map(|(count, words)| format!("{count} {words}")).collect();
        if !parts.is_empty() {
            text += &format!("  {}: {}\n", quantity.words(), parts.join(", "));
        }
    }
    for (index, variant) in study.variants.iter().enumerate() {
        let own: Vec<&Point> = study.points.iter().filter(|point| point.variant == index).collect();
        for points in own.chunk_by(|a, b| a.setting.integrator == b.setting.integrator) {
            text += &failures(&variant.label(), points);
        }
        let skipped = || own.iter().filter_map(|point| if let Outcome::Skipped(reason) = &point.outcome { Some(reason) } else { None });
        if let Some(first) = skipped().next() {
            text += &format!("  {}: {} of {} points not run, the first because {first}\n", variant.label(), skipped().count(), own.len());
        }
    }
    if text.is_empty() { text } else { format!("\nPoints without a number\n{text}") }
}

/// One line for the settings of an integrator that failed, with the first reason.
fn failures(label: &str, points: &[&Point]) -> String {
    const LONGEST: usize = 110;
    let failed = || {
        points.iter().filter_map(|point| if let Outcome::Failed(reason) = &point.outcome { Some((point.setting, reason)) } else { None })
    };
    let Some((setting, reason)) = failed().next() else { return String::new() };
    let (what, numbers): (_, Vec<String>) =
        (if setting.fixed { "step" } else { "tolerance" }, failed().map(|one| one.0.number()).collect());
    let short: String = reason.chars().take(LONGEST).collect();
    let dots = if short.len() < reason.len() { " ..." } else { "" };
    format!("  {label}, {}, {what} {}: failed: {short}{dots}\n", setting.integrator, numbers.join(", "))
}

/// The choices for machines.
pub(super) fn json(study: &Study) -> Value {
    let choices = |(quantity, levels): (Quantity, &'static [f64])| {
        study.models.iter().enumerate().flat_map(move |(index, model)| {
            let found = best(study, index, quantity, &sensible(model, quantity, levels));
            found.into_iter().map(
                move |one| json!({"quantity": quantity, "model": model.name, "levels": one.levels, "point": one.point, "error": one.error}),
            )
        })
    };
    LEVELS.into_iter().flat_map(choices).collect()
}
