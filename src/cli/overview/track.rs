//! The track below the curves of a run: curvature, cant, displacements of the rails.

use super::Drawn;
use crate::cli::plot::{BLUE, DARK, Ink, ORANGE, Panel, Series};
use crate::geometry::Side;

/// Places that a picture shows, and the least distance between them, m: shorter waves than twice that are not drawn one by one.
const PLACES: usize = 20_000;
const NEAR: f64 = 0.05;

fn panel(title: &str, axis: &str, series: Vec<Series>) -> Panel {
    Panel { height: 210.0, ..Panel::new(title, ["distance [m]", axis], series) }
}

/// Those of which there is something to see from one distance to another, m.
pub(super) fn panels(drawn: &Drawn, (from, to): (f64, f64)) -> Vec<Panel> {
    let track = &drawn.model.track;
    let count = (((to - from) / NEAR).ceil() as usize).clamp(1, PLACES);
    let places: Vec<f64> = (0..=count).map(|k| from + (to - from) * k as f64 / count as f64).collect();
    let curve = |value: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> { places.iter().map(|s| (*s, value(*s))).collect() };
    let acts = |points: &[(f64, f64)]| points.iter().any(|point| point.1 != 0.0);
    let mut panels = Vec::new();
    if let Some(line) = track.line() {
        // The heading is counted through; its slope is the curvature.
        const HALF: f64 = 0.02;
        let curvature = curve(&|s| 1e3 * (line.frame(s + HALF).heading - line.frame(s - HALF).heading) / (2.0 * HALF));
        let base = track.rail(Side::Left).spacing(track.rail(Side::Right));
        let cant = curve(&|s| {
            let axes = line.frame(s).axes;
            // Height of the left rail over the right one, square to the track.
            1e3 * base * axes[(2, 1)] / axes[(2, 1)].hypot(axes[(2, 2)])
        });
        for (title, axis, points) in [("Curvature", "1/R [1/km], left", curvature), ("Cant", "cant [mm], left up", cant)] {
            if acts(&points) {
                panels.push(panel(title, axis, vec![Series::line("", Ink::line(DARK), points)]));
            }
        }
    }
    let words = [("Rails, lateral displacement", "y [mm], rails"), ("Rails, vertical displacement", "z [mm], rails")];
    for (axis, (title, label)) in words.into_iter().enumerate() {
        let rail = |side: Side| curve(&|s| 1e3 * track.rail(side).deviation(s)[axis][0]);
        let both =
            [(Side::Left, "left rail", BLUE), (Side::Right, "right rail", ORANGE)].map(|(side, name, color)| (rail(side), name, color));
        if both.iter().any(|one| acts(&one.0)) {
            let series = both.into_iter().map(|(points, name, color)| Series::line(name, Ink { width: 1.5, ..Ink::line(color) }, points));
            panels.push(panel(title, label, series.collect()));
        }
    }
    panels
}
