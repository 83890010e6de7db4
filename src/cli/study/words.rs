//! The study in words: the references, what to choose for an accuracy, how far models differ, what was not run.

use super::csv::machine;
use crate::cli::table;
use crate::study::accuracy::{Apart, Best, COUPLING, FACTOR, HOLDS, Model, Outcome, Point, Quantity, Standing, Study, best};
use crate::study::digits::rounded;
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

/// "0.1 mm", "10 um", "250 N".
pub(super) fn size(value: f64, quantity: Quantity) -> String {
    const PREFIXES: [(&str, f64); 7] = [("k", 1e3), ("", 1.0), ("m", 1e-3), ("u", 1e-6), ("n", 1e-9), ("p", 1e-12), ("f", 1e-15)];
    let digits = |value: f64| -> String {
        let text = format!("{value:.1e}").parse::<f64>().unwrap_or(value);
        if text >= 10.0 { format!("{text:.0}") } else { format!("{text}") }
    };
    match quantity.unit() {
        "" if value < 1e-3 => format!("{value:.0e}"),
        "" => digits(value),
        unit if value < 1e-15 => format!("0 {unit}"),
        unit => {
            // 0.1 mm is what people say, not 100 um; and no kilometres.
            let most = if unit == "m" { 1.0 } else { 1e3 };
            let round = value * (1.0 + 1e-9);
            let prefix =
                PREFIXES.iter().find(|(_, size)| *size <= most && (round >= *size || *size == 1e-3 && unit == "m" && round >= 1e-4));
            let (prefix, size) = prefix.copied().unwrap_or(("f", 1e-15));
            format!("{} {prefix}{unit}", digits(value / size))
        }
    }
}

/// "0.0041 s per simulated second, 240 times real time".
fn cost(seconds: f64) -> String {
    let decimals = (1 - seconds.log10().floor() as i32).clamp(0, 9) as usize;
    let factor = 1.0 / seconds;
    let factor = if factor < 9.95 { format!("{factor:.1}") } else { format!("{factor:.0}") };
    format!("{seconds:.decimals$} s per simulated second, {factor} times real time")
}

/// "rigid contact (ACCF, ECCF)".
fn model_words(study: &Study, model: &Model) -> String {
    let names: Vec<&str> = model.variants.iter().map(|variant| study.variants[*variant].formulation).collect();
    let changes = model.variants.first().map(|variant| study.variants[*variant].changes()).unwrap_or_default();
    let changes = if changes.is_empty() { changes } else { format!(", {changes}") };
    let kind = if model.rigid { "rigid" } else { "elastic" };
    format!("{kind} contact ({}){changes}", names.join(", "))
}

/// Accuracies out of `levels` that are smaller than the model's motion itself.
fn sensible(model: &Model, quantity: Quantity, levels: &[f64]) -> Vec<f64> {
    let motion = model.reference.as_ref().ok().and_then(|reference| reference.motion.of(quantity)).unwrap_or(f64::INFINITY);
    levels.iter().copied().filter(|level| *level < motion).collect()
}

/// Points with an error that is larger than the motion itself.
pub(super) fn useless(study: &Study, quantity: Quantity) -> usize {
    study.points.iter().filter(|point| study.standing(point, quantity) == Standing::Useless).count()
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
    let mut rows = Vec::new();
    let mut missing = String::new();
    for model in &study.models {
        match &model.reference {
            Ok(reference) => {
                let cell = |quantity: Quantity| reference.uncertainty.of(quantity).map_or("-".into(), |value| format!("{value:.1e}"));
                let mut row = vec![model_words(study, model), format!("{:.0e}", reference.tolerance)];
                row.extend(Quantity::ALL.map(cell));
                row.push(reference.wavelength.map_or("-".into(), |length| format!("{length:.3}")));
                rows.push(row);
            }
            Err(reason) => missing += &format!("  {}: no reference: {reason}\n", model_words(study, model)),
        }
    }
    let methods = study.models.iter().find_map(|model| model.reference.as_ref().ok()).map(|reference| reference.methods.join(" and "));
    format!(
        "\nReferences: distance of two methods, {}; errors below {FACTOR} times that are not told\n\n{}{missing}",
        methods.unwrap_or_default(),
        table(&head, &rows)
    )
}

fn choices(study: &Study, quantity: Quantity, levels: &[f64]) -> String {
    let mut text = String::new();
    let any = study.points.iter().any(|point| study.standing(point, quantity) != Standing::Absent);
    if !any {
        let why = match quantity {
            Quantity::Wavelength => "no wheelset swings through two waves of more than 10 um, or all waves agree",
            Quantity::Displacement => "does not move by more than the references can tell",
            _ => "changes by no more than the references can tell",
        };
        return format!("\n  {}: {why}\n", quantity.words());
    }
    for (index, model) in study.models.iter().enumerate() {
        let levels = &sensible(model, quantity, levels);
        if let (true, Ok(reference)) = (levels.is_empty(), &model.reference) {
            let motion = size(reference.motion.of(quantity).unwrap_or(0.0), quantity);
            text += &format!("\n  {}, {}: changes by {motion}, less than any accuracy here\n", quantity.words(), model_words(study, model));
        }
        let found = best(study, index, quantity, levels);
        if found.is_empty() {
            continue;
        }
        text += &format!("\n  {}, {}\n", quantity.words(), model_words(study, model));
        for one in &found {
            text += &format!("    {}\n", choice(study, quantity, one));
        }
        let reached = found.last().and_then(|one| one.levels.last()).copied().unwrap_or(f64::INFINITY);
        if let Some(next) = levels.iter().find(|level| **level < reached) {
            text += &format!("    {}: not reached, or not to be told from the reference\n", size(*next, quantity));
        }
    }
    text
}

fn choice(study: &Study, quantity: Quantity, one: &Best) -> String {
    let point = &study.points[one.point];
    let Outcome::Done { measured, .. } = &point.outcome else { return String::new() };
    let levels: Vec<String> = one.levels.iter().map(|level| size(*level, quantity)).collect();
    let levels = match levels.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
        None => String::new(),
    };
    let bound = if matches!(study.standing(point, quantity), Standing::Below(_)) { "below " } else { "" };
    format!(
        "for {levels} use {} with {}: {} (error {bound}{})",
        study.variants[point.variant].label(),
        point.setting.words(),
        cost(measured.median()),
        size(one.error, quantity)
    )
}

fn differences(study: &Study) -> String {
    if study.differences.is_empty() {
        return String::new();
    }
    let mut text = String::from("\nDifferences of models: they stay however fine the integration is, and are no numerical error\n\n");
    for difference in &study.differences {
        let [first, second] = [difference.first, difference.second].map(|model| model_words(study, &study.models[model]));
        let parts: Vec<String> = Quantity::ALL
            .into_iter()
            .filter_map(|quantity| {
                let words = match study.apart(difference, quantity)? {
                    Apart::Told(value) => size(value, quantity),
                    Apart::Untold => "not to be told from the references".into(),
                };
                Some(format!("{} {words}", quantity.words()))
            })
            .collect();
        text += &format!("  {first} against {second}: {}\n", parts.join(", "));
    }
    text
}

fn coupling(study: &Study) -> String {
    let Some(one) = study.coupled.first() else { return String::new() };
    let mut steps: Vec<f64> = study.coupled.iter().map(|coupled| coupled.step).collect();
    steps.sort_by(f64::total_cmp);
    steps.dedup();
    let head: Vec<String> = ["largest error of y at a communication step of".to_string()]
        .into_iter()
        .chain(steps.iter().map(|step| format!("{} ms", rounded(1e3 * step))))
        .collect();
    let mut rows = Vec::new();
    for (hold, words) in HOLDS.iter().enumerate() {
        let cell = |step: &f64| {
            let found = study.coupled.iter().find(|coupled| coupled.hold == hold && coupled.step == *step);
            found.map_or("-".into(), |coupled| {
                let below = if coupled.errors.y.largest < coupled.floor { "< " } else { "" };
                format!("{below}{}", size(coupled.errors.y.largest.max(coupled.floor), Quantity::Displacement))
            })
        };
        rows.push([format!("input {words}")].into_iter().chain(steps.iter().map(cell)).collect());
    }
    format!("\nCommunication step: {COUPLING} ({}, {})\n\n{}", one.formulation, one.setting.words(), table(&head, &rows))
}

/// Points that gave nothing, with their reasons.
fn counts(study: &Study) -> String {
    let mut text = String::new();
    let points = |count: usize| if count == 1 { "1 point".to_string() } else { format!("{count} points") };
    for quantity in Quantity::ALL {
        let standings: Vec<Standing> = study.points.iter().map(|point| study.standing(point, quantity)).collect();
        let below = standings.iter().filter(|standing| matches!(standing, Standing::Below(_))).count();
        let words = quantity.words();
        if below > 0 {
            text += &format!("  {words}: {} more exact than the references can tell: only the bound is drawn\n", points(below));
        }
        if useless(study, quantity) > 0 {
            text += &format!("  {words}: {} with an error larger than the motion itself: not drawn\n", points(useless(study, quantity)));
        }
        // Where no point has it the choices have said why.
        let done = study.points.iter().zip(&standings).filter(|(point, _)| matches!(point.outcome, Outcome::Done { .. }));
        let absent = done.filter(|(_, standing)| **standing == Standing::Absent).count();
        if absent > 0 && standings.iter().any(|standing| *standing != Standing::Absent) {
            text += &format!("  {words}: {} where it is absent or moves by less than the reference can tell: not drawn\n", points(absent));
        }
    }
    for (index, variant) in study.variants.iter().enumerate() {
        let own: Vec<&Point> = study.points.iter().filter(|point| point.variant == index).collect();
        let mut names: Vec<&str> = own.iter().map(|point| point.setting.integrator).collect();
        names.dedup();
        for name in names {
            text += &failures(&format!("{}, {name}", variant.label()), &own, name);
        }
        let skipped: Vec<(&Point, &String)> = own.iter().filter_map(|point| Some((*point, skipped(point)?))).collect();
        if let Some((_, reason)) = skipped.first() {
            text += &format!("  {}: {} of {} points not run, the first because {reason}\n", variant.label(), skipped.len(), own.len());
        }
    }
    if text.is_empty() { text } else { format!("\nPoints without a number\n{text}") }
}

fn skipped(point: &Point) -> Option<&String> {
    if let Outcome::Skipped(reason) = &point.outcome { Some(reason) } else { None }
}

/// One line for the settings of an integrator that failed, with the first reason.
fn failures(label: &str, points: &[&Point], integrator: &str) -> String {
    const LONGEST: usize = 110;
    let mut settings = Vec::new();
    let mut first: Option<&str> = None;
    for point in points.iter().filter(|point| point.setting.integrator == integrator) {
        if let Outcome::Failed(reason) = &point.outcome {
            settings.push(format!("{} {}", if point.setting.fixed { "step" } else { "tolerance" }, point.setting.number()));
            first = first.or(Some(reason));
        }
    }
    let Some(reason) = first else { return String::new() };
    let short: String = reason.chars().take(LONGEST).collect();
    let dots = if short.len() < reason.len() { " ..." } else { "" };
    format!("  {label}, {}: failed: {short}{dots}\n", settings.join(", "))
}

/// The choices for machines.
pub(super) fn json(study: &Study) -> Value {
    let mut all = Vec::new();
    for (quantity, levels) in LEVELS {
        for (index, model) in study.models.iter().enumerate() {
            for one in best(study, index, quantity, &sensible(model, quantity, levels)) {
                all.push(json!({"quantity": quantity, "model": model.name, "levels": one.levels, "point": one.point, "error": one.error}));
            }
        }
    }
    all.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_sizes_are_written_as_people_say_them() {
        let length = |value| size(value, Quantity::Displacement);
        assert_eq!([1e-3, 1e-4, 1e-5, 1e-6, 1e-7].map(length), ["1 mm", "0.1 mm", "10 um", "1 um", "100 nm"]);
        assert_eq!([2.34, 4.57e-13, 0.0].map(length), ["2.3 m", "460 fm", "0 m"]);
        let force = |value| size(value, Quantity::NormalForce);
        assert_eq!([1e3, 250.0, 1.0, 3.21e-4].map(force), ["1 kN", "250 N", "1 N", "320 uN"]);
        assert_eq!([0.01, 1e-3, 1e-4].map(|value| size(value, Quantity::DerailmentQuotient)), ["0.01", "0.001", "1e-4"]);
        assert_eq!(cost(0.00412), "0.0041 s per simulated second, 243 times real time");
        assert_eq!(cost(1.62), "1.6 s per simulated second, 0.6 times real time");
    }
}
