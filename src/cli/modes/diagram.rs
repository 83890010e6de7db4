//! The bifurcation diagram: swings of periodic motions over speed, stable and unstable, and what runs come to.

use crate::cli::plot::{BLUE, Ink, Mark, ORANGE, Panel, Series, Sheet};
use crate::scene::spec::Scene;
use crate::study::hunting::settle::Outcome;
use crate::study::hunting::{Diagram, Motion};
use std::path::Path;

/// Draws it.
pub(super) fn draw(file: &Path, scene: &Scene, found: &Diagram) -> Result<(), String> {
    let leading = found.wheelsets.get(found.leading).map_or("", String::as_str);
    let swing = |motion: &Motion| 1e3 * found.swing(motion);
    let mut swings = lines(found, swing);
    swings.extend(marks(found));
    let mut frequencies = lines(found, |motion| motion.frequency.value);
    let repeats = found.runs.iter().filter_map(|run| match &run.outcome {
        Outcome::Repeats { frequency, .. } => Some(Mark { x: run.speed, y: *frequency, ..Mark::default() }),
        _ => None,
    });
    frequencies.push(dots("", 2, repeats.collect()));
    let panels = vec![
        Panel { height: 480.0, ..Panel::new("Half the lateral swing", ["speed [m/s]", "half swing [mm]"], swings) },
        Panel { height: 480.0, ..Panel::new("Frequency", ["speed [m/s]", "frequency [Hz]"], frequencies) },
    ];
    let critical = |name: &str, speed: Option<f64>| {
        speed.map_or(format!("no {name} critical speed found"), |speed| format!("{name} critical speed {speed:.2} m/s"))
    };
    let subtitles = vec![format!(
        "{}; {leading}; {}, {}",
        scene.title,
        critical("linear", found.linear().map(|critical| critical.speed)),
        critical("nonlinear", found.fold().map(|fold| fold.speed.value))
    )];
    Sheet { title: "Limit cycles of hunting".into(), subtitles, columns: 2, panels }.draw(file)
}

fn dots(label: &str, style: usize, marks: Vec<Mark>) -> Series {
    Series { branches: vec![], ..Series::marks(label, Ink { width: 0.0, radius: 4.0, ..Ink::marks(style) }, marks) }
}

/// The branch in pieces of equal stability, each up to the middle of the way to the next.
fn lines(found: &Diagram, value: impl Fn(&Motion) -> f64) -> Vec<Series> {
    let point = |motion: &Motion| (motion.speed, value(motion));
    let mut pieces: [Vec<Vec<(f64, f64)>>; 2] = [Vec::new(), Vec::new()];
    let mut branch: Vec<&Motion> = found.branch.iter().collect();
    // Turning points stand between the motions whose swings are about theirs.
    for turning in &found.turnings {
        let swing = found.swing(&turning.motion);
        let place = branch.windows(2).position(|pair| (found.swing(pair[0])..found.swing(pair[1])).contains(&swing));
        if let Some(place) = place {
            branch.insert(place + 1, &turning.motion);
        }
    }
    let branch = branch.into_iter().map(|motion| (motion.stable, point(motion)));
    let mut last: Option<(bool, (f64, f64))> = None;
    for (stable, at) in branch {
        let own = &mut pieces[usize::from(stable)];
        match last {
            Some((before, _)) if before == stable => {
                if let Some(piece) = own.last_mut() {
                    piece.push(at);
                }
            }
            Some((_, from)) => own.push(vec![from, at]),
            None => own.push(vec![at]),
        }
        last = Some((stable, at));
    }
    let [unstable, stable] = pieces;
    let series = |label: &str, ink: Ink, branches: Vec<Vec<(f64, f64)>>| Series { branches, ..Series::line(label, ink, vec![]) };
    vec![series("stable motion", Ink::line(BLUE), stable), series("unstable motion", Ink::dashed(ORANGE), unstable)]
}

/// What runs come to, and the two ends of the range with two ways to run.
fn marks(found: &Diagram) -> Vec<Series> {
    let mut alike = Vec::new();
    let mut other = Vec::new();
    for run in &found.runs {
        let at = |swing: f64| Mark { x: run.speed, y: 1e3 * swing, ..Mark::default() };
        match &run.outcome {
            Outcome::Dies => alike.push(at(0.0)),
            Outcome::Repeats { swings, .. } => alike.push(at(swings[found.leading])),
            Outcome::Changes { from, to } => other.extend([at(*from), at(*to)]),
            Outcome::Irregular { least, most } => other.extend([at(*least), at(*most)]),
            Outcome::Fails { .. } => {}
        }
    }
    let mut ends = Vec::new();
    if let Some(linear) = found.linear() {
        ends.push(Mark { x: linear.speed, y: 0.0, label: format!("{:.2}", linear.speed), ..Mark::default() });
    }
    for turning in &found.turnings {
        let (x, y) = (turning.speed.value, 1e3 * found.swing(&turning.motion));
        ends.push(Mark { x, y, label: format!("{x:.2}"), ..Mark::default() });
    }
    let mut series = vec![dots("run settled", 2, alike)];
    if !other.is_empty() {
        series.push(dots("run not settled: least and most", 3, other));
    }
    series.push(dots("critical speeds and turning points", 6, ends));
    series
}
