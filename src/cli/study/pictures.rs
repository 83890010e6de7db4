//! The study's pictures.

use super::words::{size, useless};
use crate::cli::plot::loglog::{self, Mark, Panel, Series, Sheet};
use crate::cli::plot::scatter;
use crate::solve;
use crate::study::accuracy::{Apart, COUPLING, HOLDS, Measured, Model, Outcome, Quantity, Setting, Standing, Study, front};
use crate::study::digits::rounded;
use std::path::{Path, PathBuf};

/// A horizontal axis.
struct Along {
    key: &'static str,
    title: &'static str,
    axis: &'static str,
    /// Median, smallest and largest of a point.
    value: fn(&Measured, f64) -> [f64; 3],
}

const ALONG: [Along; 2] = [
    Along {
        key: "time",
        title: "numerical error against CPU time",
        axis: "CPU time per simulated second [ms]; 1000 ms is real time",
        value: |measured, _| [measured.median(), measured.spread().0, measured.spread().1].map(|seconds| 1e3 * seconds),
    },
    Along {
        key: "work",
        title: "numerical error against work",
        axis: "evaluations of the right-hand side per simulated second",
        value: |measured, stop| [measured.statistics.evaluations.max(1) as f64 / stop; 3],
    },
];

/// Draws all of them; returns the files.
pub(super) fn draw(folder: &Path, study: &Study) -> Result<Vec<PathBuf>, String> {
    let mut files = Vec::new();
    for quantity in Quantity::ALL {
        for along in &ALONG {
            files.extend(errors(folder, study, quantity, along)?);
        }
    }
    files.extend(best(folder, study)?);
    files.extend(communication(folder, study)?);
    Ok(files)
}

/// Caption of an error's axis.
fn axis(quantity: Quantity) -> String {
    let unit = if quantity.unit().is_empty() { String::new() } else { format!(" [{}]", quantity.unit()) };
    let how = match quantity {
        Quantity::Wavelength => "error of the mean",
        _ => "largest error",
    };
    format!("{}: {how}{unit}", capital(quantity.words()))
}

fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

/// An integrator's colour and mark: its place in the registry.
fn style(integrator: &str) -> usize {
    solve::REGISTRY.iter().position(|entry| entry.name == integrator).unwrap_or(0)
}

/// What all pictures say below their title.
fn subtitles(study: &Study, stop: f64, bounds: bool) -> Vec<String> {
    let mut lines = vec![format!("{}, {} s", study.title, rounded(stop))];
    if bounds {
        lines.push("hollow with an arrow: better than this, which is all that the reference can tell".into());
    }
    lines
}

/// One panel per variant, one series per integrator; nothing where no point can be shown.
fn errors(folder: &Path, study: &Study, quantity: Quantity, along: &Along) -> Result<Option<PathBuf>, String> {
    let mut panels = Vec::new();
    let (mut bounded, mut runs) = (Vec::new(), 0);
    for (index, variant) in study.variants.iter().enumerate() {
        let Some(model) = study.model_of(index) else { continue };
        let mut series: Vec<Series> = Vec::new();
        for point in study.points.iter().filter(|point| point.variant == index) {
            let Outcome::Done { measured, .. } = &point.outcome else { continue };
            let (y, bound) = match study.standing(point, quantity) {
                Standing::Shown(error) => (error, false),
                Standing::Below(floor) => (floor, true),
                Standing::Useless | Standing::Absent => continue,
            };
            let [x, low, high] = (along.value)(measured, study.stop);
            let mark = Mark { x, y, low, high, bound };
            runs = measured.cpu.len().max(runs);
            let name = point.setting.integrator;
            match series.iter_mut().find(|series| series.label == name) {
                Some(series) => series.marks.push(mark),
                None => series.push(Series { label: name.into(), style: style(name), marks: vec![mark] }),
            }
        }
        if series.is_empty() {
            continue;
        }
        // Where all points are better than the reference can tell there is nothing to see.
        if !series.iter().any(|series| series.marks.iter().any(|mark| !mark.bound)) {
            let floor = model.reference.as_ref().map_or(f64::INFINITY, |reference| reference.floor(quantity));
            bounded.push(format!("{} (all below {})", variant.label(), size(floor, quantity)));
            continue;
        }
        let (levels, aside) = levels(study, model, quantity);
        let kind = if model.rigid { "rigid" } else { "elastic" };
        panels.push(Panel { title: format!("{} ({kind})", variant.label()), series, levels, aside });
    }
    if panels.is_empty() {
        return Ok(None);
    }
    let marks = || panels.iter().flat_map(|panel| panel.series.iter().flat_map(|series| series.marks.iter()));
    let file = folder.join(format!("{}_{}_{}.svg", study.scene, along.key, quantity.key()));
    let title = format!("{}: {}", capital(quantity.words()), along.title);
    let mut subtitles = subtitles(study, study.stop, marks().any(|mark| mark.bound));
    if !bounded.is_empty() {
        subtitles.push(format!("without a panel, better than the reference can tell: {}", bounded.join(", ")));
    }
    if along.key == "time" && runs > 1 {
        subtitles.push(format!("bars: spread of up to {runs} runs"));
    }
    match useless(study, quantity) {
        0 => {}
        1 => subtitles.push("not drawn: 1 point with an error larger than the motion itself".into()),
        count => subtitles.push(format!("not drawn: {count} points with errors larger than the motion itself")),
    }
    loglog::draw(&file, &Sheet { title: &title, subtitles: &subtitles, axes: [along.axis, &axis(quantity)], panels: &panels })?;
    Ok(Some(file))
}

/// Distances of a model from others, and their words.
fn levels(study: &Study, model: &Model, quantity: Quantity) -> (Vec<f64>, String) {
    let (mut levels, mut words) = (Vec::new(), Vec::new());
    for difference in &study.differences {
        let [first, second] = [difference.first, difference.second].map(|index| &study.models[index]);
        let other = if first.name == model.name { second } else { first };
        let concerned = first.name == model.name || second.name == model.name;
        // A distance that the references can't tell is no line.
        if let (true, Some(Apart::Told(level))) = (concerned, study.apart(difference, quantity))
            && level > 0.0
        {
            levels.push(level);
            words.push(format!("{} {}", other.name, size(level, quantity)));
        }
    }
    let words = if words.is_empty() { String::new() } else { format!("dashed, difference of models: {}", words.join(", ")) };
    (levels, words)
}

/// The points of each model that no other one beats, by name.
fn best(folder: &Path, study: &Study) -> Result<Option<PathBuf>, String> {
    let quantity = [Quantity::Displacement, Quantity::WheelLoad]
        .into_iter()
        .find(|quantity| study.points.iter().any(|point| matches!(study.standing(point, *quantity), Standing::Shown(_))));
    let Some(quantity) = quantity else { return Ok(None) };
    let mut labels = Vec::new();
    for model in &study.models {
        let among: Vec<usize> = (0..study.points.len()).filter(|point| model.variants.contains(&study.points[*point].variant)).collect();
        for point in front(study, &among, quantity) {
            let point = &study.points[point];
            let Outcome::Done { measured, .. } = &point.outcome else { continue };
            let (error, better) = match study.standing(point, quantity) {
                Standing::Shown(error) => (error, ""),
                // The cheapest of those that the reference can't tell apart.
                Standing::Below(floor) if floor > 0.0 => (floor, " (or better)"),
                _ => continue,
            };
            let Setting { integrator, .. } = point.setting;
            let label = format!("{} {integrator} {}{better}", study.variants[point.variant].label(), point.setting.number());
            labels.push((label, 1e3 * measured.median(), error));
        }
    }
    if labels.is_empty() {
        return Ok(None);
    }
    let points: Vec<scatter::Point> = labels.iter().map(|(label, x, y)| scatter::Point { label, x: *x, y: *y }).collect();
    let file = folder.join(format!("{}_best.svg", study.scene));
    let subtitle = format!("{}, {} s; ECCF and ACCF are rigid, ECF elastic: errors within each model", study.title, rounded(study.stop));
    scatter::draw(
        &file,
        "What to choose: in its model nothing is more exact and faster",
        &subtitle,
        [ALONG[0].axis, &axis(quantity)],
        &points,
    )?;
    Ok(Some(file))
}

/// Error against communication step.
fn communication(folder: &Path, study: &Study) -> Result<Option<PathBuf>, String> {
    let Some(one) = study.coupled.first() else { return Ok(None) };
    let series = HOLDS.iter().enumerate().map(|(hold, words)| {
        let own = study.coupled.iter().filter(|coupled| coupled.hold == hold);
        let mark = |step: f64, error: f64, floor: f64| {
            let x = 1e3 * step;
            Mark { x, y: error.max(floor), low: x, high: x, bound: error < floor }
        };
        let marks = own.map(|coupled| mark(coupled.step, coupled.errors.y.largest, coupled.floor)).filter(|mark| mark.y > 0.0).collect();
        Series { label: format!("input: {words}"), style: hold, marks }
    });
    let title = format!("{}, {}", one.formulation, one.setting.words());
    let panels = [Panel { title, series: series.collect(), levels: Vec::new(), aside: String::new() }];
    let bounds = panels[0].series.iter().any(|series| series.marks.iter().any(|mark| mark.bound));
    let mut subtitles = subtitles(study, one.stop, bounds);
    subtitles.insert(1, COUPLING.into());
    let file = folder.join(format!("{}_communication.svg", study.scene));
    let axes = ["communication step [ms]", &axis(Quantity::Displacement)];
    loglog::draw(
        &file,
        &Sheet { title: "Lateral displacement: error against communication step", subtitles: &subtitles, axes, panels: &panels },
    )?;
    Ok(Some(file))
}
