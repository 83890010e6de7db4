//! The root locus: eigenvalues in the complex plane, and growth over speed.

use crate::cli::plot::{Ink, Mark, Panel, Series, Sheet};
use crate::scene::spec::Scene;
use crate::study::modes::Mode;
use crate::study::modes::locus::Locus;
use std::path::Path;

/// Contact modes and motions that hardly swing stand far beyond what is looked at: Hz, and parts of critical damping.
const HIGHEST: f64 = 15.0;
const DAMPED: f64 = 0.6;

/// Why there is no critical speed.
fn without(found: &Locus) -> &'static str {
    if found.growing_at_lowest().next().is_some() { "unstable at the lowest speed already" } else { "no critical speed within the sweep" }
}

/// Draws both.
pub(super) fn draw(file: &Path, scene: &Scene, found: &Locus) -> Result<(), String> {
    let shown = |mode: &&Mode| mode.frequency > 0.0 && mode.frequency < HIGHEST && mode.damping < DAMPED;
    let marks = |hunting: bool, place: fn(f64, &Mode) -> (f64, f64)| {
        let own = found.points.iter().flat_map(|point| point.modes.iter().filter(shown).map(|mode| (point.speed, mode)));
        own.filter(|(_, mode)| mode.hunting == hunting)
            .map(|(speed, mode)| {
                let (x, y) = place(speed, mode);
                Mark { x, y, ..Mark::default() }
            })
            .collect::<Vec<Mark>>()
    };
    let series = |place: fn(f64, &Mode) -> (f64, f64)| {
        let dots = |label: &str, style: usize, marks: Vec<Mark>| Series {
            branches: vec![],
            ..Series::marks(label, Ink { width: 0.0, radius: 3.0, ..Ink::marks(style) }, marks)
        };
        vec![dots("hunting", 1, marks(true, place)), dots("other modes", 0, marks(false, place))]
    };
    let plane = Panel::new("Root locus", ["growth [1/s]", "frequency [Hz]"], series(|_, mode| (mode.growth, mode.frequency)));
    let mut growth =
        Panel::new("Damping over speed", ["speed [m/s]", "damping [% of critical]"], series(|speed, mode| (speed, 100.0 * mode.damping)));
    growth.levels = vec![0.0];
    let speeds = found.points.iter().map(|point| point.speed);
    let range = speeds.clone().fold(f64::INFINITY, f64::min)..speeds.fold(0.0, f64::max);
    let critical =
        found.critical.as_ref().map_or_else(|| without(found).into(), |critical| format!("critical speed {:.1} m/s", critical.speed));
    let subtitles = vec![format!(
        "{}; {:.0} to {:.0} m/s, {critical}; modes below {HIGHEST:.0} Hz and {:.0} % of critical damping",
        scene.title,
        range.start,
        range.end,
        100.0 * DAMPED
    )];
    Sheet {
        title: "Modes over speed".into(),
        subtitles,
        columns: 2,
        panels: vec![Panel { height: 480.0, ..plane }, Panel { height: 480.0, ..growth }],
    }
    .draw(file)
}
