//! Vehicles that the program carries: tables of free models, which a scene may change entry by entry.

use super::{VehicleSpec, read as parts};
use crate::settings::{Section, SettingsError, Source};
use toml_edit::Document;

/// A template's name and its text: what would stand in `[vehicle]` with `template = "free"`.
pub struct Template {
    pub name: &'static str,
    pub text: &'static str,
}

/// Every template of a free model.
pub static VEHICLES: &[Template] = &[
    Template { name: "bogie", text: include_str!("../../../fmu/vehicles/bogie.toml") },
    Template { name: "vehicle_manchester_1", text: include_str!("../../../fmu/vehicles/vehicle_manchester_1.toml") },
    Template { name: "vehicle_equalised", text: include_str!("../../../fmu/vehicles/vehicle_equalised.toml") },
];

/// The text behind a template; `None` for those without one.
pub fn text(name: &str) -> Option<&'static str> {
    VEHICLES.iter().find(|template| template.name == name).map(|template| template.text)
}

/// Reads a free model, or what a scene's `[vehicle]` makes of the template of that name. Modules, too, may lie over a template.
pub(super) fn read(section: Section, name: &'static str) -> Result<VehicleSpec, SettingsError> {
    let mut parsed = Vec::new();
    for template in VEHICLES {
        let source =
            Source { file: format!("template {}.toml", template.name), text: template.text.into(), overridden: vec![], folder: None };
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
    let base = library.iter().find(|template| template.0 == name).map(|template| template.1.clone());
    let section = match base {
        Some(base) => section.over(base),
        None => section,
    };
    parts::free(section, name, &library)
}
