//! Vehicles that the program carries: tables that a scene may change entry by entry.

use super::{VehicleSpec, read as parts};
use crate::settings::{Entry, Section, SettingsError, Source};
use toml_edit::Document;

/// A template's text: what would stand in `[vehicle]` without it.
pub type Text = &'static str;

/// Templates that `vehicle.template` can name.
pub static REGISTRY: &[Entry<Text>] = &[
    Entry {
        name: "suspended_wheelset",
        summary: "one wheelset on springs to a frame that travels with it (paper, section 3.4)",
        reference: "",
        parse: include_str!("../../../fmu/vehicles/suspended_wheelset.toml"),
    },
    Entry {
        name: "free",
        summary: "any vehicle: [[vehicle.body]], [[vehicle.wheelset]], [[vehicle.joint]], [[vehicle.force]], modules",
        reference: "",
        parse: "",
    },
    Entry {
        name: "bogie",
        summary: "one truck of the Manchester Benchmarks' coach under half of its body",
        reference: "",
        parse: include_str!("../../../fmu/vehicles/bogie.toml"),
    },
    Entry {
        name: "vehicle_manchester_1",
        summary: "the passenger coach of the Manchester Benchmarks (Iwnicki 1999)",
        reference: "",
        parse: include_str!("../../../fmu/vehicles/vehicle_manchester_1.toml"),
    },
    Entry {
        name: "vehicle_equalised",
        summary: "two trucks with equaliser bars, frame and bolster each, and a car body (paper, section 5): 13 bodies",
        reference: "",
        parse: include_str!("../../../fmu/vehicles/vehicle_equalised.toml"),
    },
];

/// The text behind a template; empty for a name that has none.
pub fn text(name: &str) -> Text {
    REGISTRY.iter().find(|template| template.name == name).map_or("", |template| template.parse)
}

/// Reads what a scene's `[vehicle]` makes of the template of that name. Modules, too, may lie over a template.
pub(super) fn read(section: Section, name: &'static str) -> Result<VehicleSpec, SettingsError> {
    let mut parsed = Vec::new();
    for template in REGISTRY {
        let source =
            Source { file: format!("template {}.toml", template.name), text: template.parse.into(), overridden: vec![], folder: None };
        let document = Document::parse(source.text.clone()).map_err(|error| SettingsError {
            file: source.file.clone(),
            line: 0,
            key: "vehicle.template".into(),
            problem: error.message().trim().into(),
        })?;
        parsed.push((template.name, source, document));
    }
    let library: Vec<(&'static str, Section)> =
        parsed.iter().map(|(name, source, document)| (*name, Section::beside(document.as_table(), source, &section))).collect();
    let section = match library.iter().find(|template| template.0 == name) {
        Some((_, base)) => section.over(base.clone()),
        None => section,
    };
    parts::vehicle(section, name, &library)
}
