//! The study's pictures.

use super::words::model_words;
use crate::cli::plot::{Ink, Mark, Panel, Series, Sheet};
use crate::solve;
use crate::study::accuracy::{Apart, COUPLING, HOLDS, Measured, Quantity, Standing, StudiedModel, Study, front};
use crate::study::digits::{rounded, sized};
use std::path::{Path, PathBuf};

/// A horizontal axis.
struct Along {
    key: &'static str,
    title: &'static str,
    axis: &'static str,
    /// Of a point: median, smallest and largest.
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

/// Below the title of a picture with marks that are only bounds.
const BOUNDS: &str = "hollow with an arrow: better than this, which is all that the reference can tell";

/// Draws all of them; returns the files.
pub(super) fn draw(folder: &Path, study: &Study) -> Result<Vec<PathBuf>, String> {
    let errors = Quantity::ALL.iter().flat_map(|quantity| ALONG.iter().map(|along| errors(study, *quantity, along)));
    let sheets = errors.chain([best(study), communication(study)]).flatten();
    let draw = |(key, sheet): (String, Sheet)| {
        let file = folder.join(format!("{}_{key}.svg", study.scene));
        sheet.draw(&file).map(|()| file)
    };
    sheets.map(draw).collect()
}

/// Caption of an error's axis.
fn axis(quantity: Quantity) -> String {
    let unit = if quantity.unit().is_empty() { String::new() } else { format!(" [{}]", quantity.unit()) };
    let how = if quantity == Quantity::Wavelength { "error of the mean" } else { "largest error" };
    format!("{how}{unit}")
}

fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

fn bounded<'a>(panels: impl IntoIterator<Item = &'a Panel>) -> bool {
    panels.into_iter().flat_map(|panel| &panel.series).flat_map(|series| &series.marks).any(|mark| mark.bound)
}

/// One panel per variant, one series per integrator in the registry's order; nothing where no point can be shown.
fn errors(study: &Study, quantity: Quantity, along: &Along) -> Option<(String, Sheet)> {
    let (mut panels, mut better, mut runs) = (Vec::new(), Vec::new(), 0);
    for (index, variant) in study.variants.iter().enumerate() {
        let Some(model) = study.model_of(index) else { continue };
        let mut of_method = |name: &str| -> Vec<Mark> {
            let own = study.points.iter().filter(|point| point.variant == index && point.setting.integrator == name);
            let shown = own.filter_map(|point| Some((point, study.standing(point, quantity).bound()?)));
            let mark = |(point, (y, bound))| {
                let (measured, _) = Study::done(point)?;
                let [x, low, high] = (along.value)(measured, study.stop);
                runs = runs.max(measured.cpu.len());
                Some(Mark { x, y, bar: Some((low, high)), bound, ..Mark::default() })
            };
            shown.filter_map(mark).collect()
        };
        let methods = solve::REGISTRY.iter().enumerate().map(|(style, entry)| (style, entry.name, of_method(entry.name)));
        let series: Vec<Series> = methods
            .filter(|(.., marks)| !marks.is_empty())
            .map(|(style, name, marks)| Series::marks(name, Ink::marks(style), marks))
            .collect();
        if series.is_empty() {
            continue;
        }
        // Where all points are better than the reference can tell there is nothing to see.
        if series.iter().all(|series| series.marks.iter().all(|mark| mark.bound)) {
            let floor = model.reference.as_ref().map_or(f64::INFINITY, |reference| reference.floor(quantity));
            better.push(format!("{} (below {})", variant.label(), sized(floor, quantity.unit(), 2)));
            continue;
        }
        let (levels, aside) = levels(study, model, quantity);
        let title = format!("{} ({})", variant.label(), model.kind());
        panels.push(Panel { levels, aside, height: 430.0, ..Panel::new(&title, [along.axis, &axis(quantity)], series).log() });
    }
    let mut subtitles = vec![format!("{}, {} s", study.title, rounded(study.stop))];
    let mut note = |said: bool, words: String| subtitles.extend(said.then_some(words));
    note(bounded(&panels), BOUNDS.into());
    note(!better.is_empty(), format!("all better than the reference can tell: {}", better.join(", ")));
    note(along.key == "time" && runs > 1, format!("bars: spread of up to {runs} runs"));
    let useless = study.count(quantity, |standing| standing == Standing::Useless);
    note(useless > 0, format!("not drawn: errors larger than the motion itself ({useless})"));
    let title = format!("{}: {}", capital(quantity.words()), along.title);
    (!panels.is_empty()).then(|| (format!("{}_{}", along.key, quantity.key()), Sheet { title, subtitles, columns: 2, panels }))
}

/// Distances of a model from others, and their words.
fn levels(study: &Study, model: &StudiedModel, quantity: Quantity) -> (Vec<f64>, String) {
    let told = study.differences.iter().filter_map(|difference| {
        let pair = [difference.first, difference.second].map(|index| study.models[index].name.as_str());
        let other = pair.iter().find(|name| **name != model.name).filter(|_| pair.contains(&model.name.as_str()))?;
        match study.apart(difference, quantity)? {
            Apart::Told(level) if level > 0.0 => Some((level, format!("{other} {}", sized(level, quantity.unit(), 2)))),
            // A distance that the references can't tell is no line.
            _ => None,
        }
    });
    let (levels, words): (Vec<f64>, Vec<String>) = told.unzip();
    let words = if words.is_empty() { String::new() } else { format!("dashed: away from {}", words.join(", ")) };
    (levels, words)
}

/// The points of each model that no other one beats, by name.
fn best(study: &Study) -> Option<(String, Sheet)> {
    let shown = |quantity: &Quantity| study.count(*quantity, |standing| matches!(standing, Standing::Shown(_))) > 0;
    let quantity = [Quantity::Displacement, Quantity::WheelLoad].into_iter().find(shown)?;
    let series = study.models.iter().enumerate().map(|(style, model)| {
        let among: Vec<usize> = (0..study.points.len()).filter(|point| model.variants.contains(&study.points[*point].variant)).collect();
        let mark = |point: usize| {
            let point = &study.points[point];
            // The cheapest of those that the reference can't tell apart.
            let (y, bound) = study.standing(point, quantity).bound().filter(|(error, _)| *error > 0.0)?;
            let label = format!("{} {} {}", study.variants[point.variant].label(), point.setting.integrator, point.setting.number());
            Some(Mark { x: 1e3 * Study::done(point)?.0.median(), y, bar: None, bound, label })
        };
        let marks = front(study, &among, quantity).into_iter().filter_map(mark).collect();
        Series::marks(&model_words(study, model), Ink::marks(style), marks)
    });
    let series: Vec<Series> = series.filter(|series| !series.marks.is_empty()).collect();
    let panel = Panel { height: 620.0, ..Panel::new(capital(quantity.words()).as_str(), [ALONG[0].axis, &axis(quantity)], series).log() };
    let mut subtitles = vec![format!("{}, {} s; errors within each model", study.title, rounded(study.stop))];
    subtitles.extend(bounded([&panel]).then(|| BOUNDS.into()));
    let title = "What to choose: in its model nothing is more exact and faster".into();
    (!panel.series.is_empty()).then(|| ("best".into(), Sheet { title, subtitles, columns: 1, panels: vec![panel] }))
}

/// Error against communication step.
fn communication(study: &Study) -> Option<(String, Sheet)> {
    let one = study.coupled.first()?;
    let series = HOLDS.iter().enumerate().map(|(hold, words)| {
        let own = study.coupled.iter().filter(|coupled| coupled.hold == hold);
        let marks = own.map(|coupled| {
            let (error, floor) = (coupled.errors.y.largest, coupled.floor);
            Mark { x: 1e3 * coupled.step, y: error.max(floor), bound: error < floor, ..Mark::default() }
        });
        Series::marks(&format!("input: {words}"), Ink::marks(hold), marks.filter(|mark| mark.y > 0.0).collect())
    });
    let title = format!("{}, {}", one.formulation, one.setting.words());
    let panel = Panel::new(&title, ["communication step [ms]", &axis(Quantity::Displacement)], series.collect()).log();
    let panel = Panel { height: 480.0, ..panel };
    let mut subtitles = vec![format!("{}, {} s", study.title, rounded(one.stop)), COUPLING.into()];
    subtitles.extend(bounded([&panel]).then(|| BOUNDS.into()));
    let title = "Lateral displacement: error against communication step".into();
    Some(("communication".into(), Sheet { title, subtitles, columns: 1, panels: vec![panel] }))
}
