//! The picture of a run: lateral displacement, yaw and wheel loads over distance.

use super::plot::{BLUE, DARK, Ink, ORANGE, Panel, Series, Sheet};
use super::{Failure, make_folder};
use crate::sim::recording::Recording;
use std::path::{Path, PathBuf};

const NEEDS: &str = "the plot needs the output group \"motion\"; add it to interface.outputs";

/// Title, axis, outputs with label and ink, and what makes SI of the axis' unit.
type Shown = (&'static str, &'static str, f64, &'static [(&'static str, &'static str, Ink)]);
const SHOWN: [Shown; 3] = [
    ("Lateral displacement", "y [mm], left positive", 1e3, &[("y", "", Ink::line(DARK))]),
    ("Yaw", "yaw [mrad]", 1e3, &[("yaw", "", Ink::line(DARK))]),
    (
        "Wheel loads",
        "Q [kN]",
        1e-3,
        &[("left.verticalForce", "left wheel", Ink::line(BLUE)), ("right.verticalForce", "right wheel", Ink::line(ORANGE))],
    ),
];

/// Can a plot be drawn into `folder`? Asked before the run, so that nothing computed is lost.
pub(super) fn prepare(folder: &Path, groups: &[&str]) -> Result<(), Failure> {
    if !groups.contains(&"motion") {
        return Err(Failure::Input(NEEDS.into()));
    }
    make_folder(folder)
}

/// Draws `DIR/NAME.svg`; a panel whose output group the scene does not show is left out.
pub(super) fn draw(folder: &Path, name: &str, title: &str, wheelset: &str, recording: &Recording) -> Result<PathBuf, String> {
    let column = |output: &str| recording.column(&format!("{wheelset}.{output}"));
    let distance = column("distance").ok_or(NEEDS)?;
    let panel = |(title, axis, factor, outputs): &Shown| {
        let curve = |(output, label, ink): &(&str, &str, Ink)| {
            let points = distance.iter().copied().zip(column(output)?.iter().map(|value| value * factor)).collect();
            Some(Series::line(label, *ink, points))
        };
        let series: Vec<Series> = outputs.iter().filter_map(curve).collect();
        let height = 290.0;
        (!series.is_empty()).then(|| Panel { height, ..Panel::new(title, ["distance [m]", axis], series) })
    };
    let file = folder.join(format!("{name}.svg"));
    Sheet { title: title.into(), subtitles: vec![], columns: 1, panels: SHOWN.iter().filter_map(panel).collect() }.draw(&file)?;
    Ok(file)
}
