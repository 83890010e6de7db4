//! Pictures of a run over distance: motions and loads of all wheelsets, guiding forces, bodies, accelerations, each with the track below; where the wheels touched the
//! profiles; spectra of accelerations. Another run may lie over all of them.

mod panels;
mod places;
mod track;

use super::plot::{Panel, Sheet};
use super::{Failure, make_folder};
use crate::formulation::Model;
use crate::scene::spec::Scene;
use crate::sim::outputs::Output;
use crate::sim::recording::Recording;
use crate::study::assess::signals::{Signals, foreign_unit};
use std::path::{Path, PathBuf};

const NEEDS: &str = "the plot needs the output group \"motion\"; add it to interface.outputs";

/// Outputs that pictures are made of: groups, and ends of the names.
const SHOWN: [(&str, &[&str]); 6] = [
    ("motion", &["distance", "y", "yaw", "ay", "az"]),
    ("wheels", &["verticalForce", "lateralForce", "derailmentQuotient"]),
    ("axles", &["trackShiftingForce"]),
    ("bodies", &["distance", "y", "z", "roll", "pitch", "yaw"]),
    ("sensors", &["distance", "ay", "az"]),
    ("contacts", &["wheelCoordinate", "railCoordinate", "normalForce"]),
];

/// Do pictures need an output? (Contacts are those of the wheelset that is shown.)
pub(super) fn needs(output: &Output, wheelset: &str) -> bool {
    let end = output.name.rsplit('.').next().unwrap_or_default();
    let own = output.group != "contacts" || output.name.strip_prefix(wheelset).is_some_and(|rest| rest.starts_with('.'));
    own && SHOWN.iter().any(|(group, ends)| *group == output.group && ends.contains(&end))
}

/// Another run, from a CSV.
pub(super) struct Reference {
    /// In the legend.
    name: String,
    signals: Signals,
}

impl Reference {
    /// Reads it; it must hold something that is drawn.
    pub(super) fn read(path: &Path, outputs: &[Output], wheelset: &str) -> Result<Reference, Failure> {
        let failed = |error: &dyn std::fmt::Display| Failure::Input(format!("--against {}: {error}", path.display()));
        let bytes = std::fs::read(path).map_err(|error| failed(&error))?;
        let text =
            String::from_utf8(bytes).map_err(|_| failed(&"it is no text; expected a CSV, which `wheelrail run -o FILE.csv` writes"))?;
        let signals = Signals::read(text.as_bytes()).map_err(|error| failed(&error))?;
        let titles: Vec<&str> = text.lines().next().unwrap_or_default().split(',').map(str::trim).collect();
        let drawn = outputs.iter().filter(|output| needs(output, wheelset) && signals.column(&output.name).is_some());
        for output in drawn.clone() {
            let own = titles.iter().find(|title| title.split('[').next().is_some_and(|name| name.trim() == output.name));
            if let Some(unit) = own.and_then(|title| foreign_unit(title, output.unit.name())) {
                return Err(failed(&format!("{} has the unit {unit}, expected {}", output.name, output.unit.name())));
            }
        }
        if drawn.clone().all(|output| output.name.ends_with(".distance")) && drawn.count() > 0 {
            return Err(failed(&"no column beside distances is one that the pictures of this scene show"));
        }
        let distances = |output: &&Output| output.name.ends_with(".distance") && needs(output, wheelset);
        if !outputs.iter().filter(distances).any(|output| signals.column(&output.name).is_some()) {
            let some = format!("{wheelset}.distance");
            return Err(failed(&format!("no distance of a part of this scene, such as {some}: pictures stand over distances")));
        }
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Ok(Reference { name, signals })
    }
}

/// What is drawn.
pub(super) struct Drawn<'a> {
    pub scene: &'a Scene,
    pub model: &'a Model,
    pub wheelset: &'a str,
    pub recording: &'a Recording,
    pub against: Option<&'a Reference>,
}

/// Can a plot be drawn into `folder`? Asked before the run, so that nothing computed is lost.
pub(super) fn prepare(folder: &Path, groups: &[&str]) -> Result<(), Failure> {
    if !groups.contains(&"motion") {
        return Err(Failure::Input(NEEDS.into()));
    }
    make_folder(folder)
}

/// Draws `DIR/NAME.svg` and those of forces, bodies, accelerations, contacts and spectra beside it; a panel whose outputs the scene does not show is left out, and a
/// sheet without panels.
pub(super) fn draw(folder: &Path, drawn: &Drawn) -> Result<Vec<PathBuf>, String> {
    let sheets: [(&str, &str, usize, Vec<Panel>); 6] = [
        ("", "", 1, panels::motions(drawn)),
        ("_forces", "guiding forces", 1, panels::forces(drawn)),
        ("_bodies", "bodies", 1, panels::bodies(drawn)),
        ("_accelerations", "accelerations", 1, panels::accelerations(drawn)),
        ("_contacts", "contact places", 2, places::panels(drawn)),
        ("_spectra", "power spectral densities", 1, panels::spectra(drawn)),
    ];
    let mut files = Vec::new();
    for (key, title, columns, panels) in sheets.into_iter().filter(|sheet| !sheet.3.is_empty()) {
        let file = folder.join(format!("{}{key}.svg", drawn.scene.name));
        let title = if title.is_empty() { drawn.scene.title.clone() } else { format!("{}: {title}", drawn.scene.title) };
        let subtitles = if key == "_contacts" { vec![places::words(drawn)] } else { vec![] };
        Sheet { title, subtitles, columns, panels }.draw(&file)?;
        files.push(file);
    }
    if files.is_empty() { Err(NEEDS.into()) } else { Ok(files) }
}
