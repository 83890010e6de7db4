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
];

/// The text behind a template; `None` for those without one.
pub fn text(name: &str) -> Option<&'static str> {
    VEHICLES.iter().find(|template| template.name == name).map(|template| template.text)
}

/// Reads a scene's `[vehicle]` laid over the template of that name.
pub(super) fn read(section: Section, name: &'static str) -> Result<VehicleSpec, SettingsError> {
    let Some(text) = text(name) else { return Err(section.error("template", format!("\"{name}\" has no text"))) };
    let source = Source { file: format!("template {name}.toml"), text: text.into(), overridden: vec![], folder: None };
    let document = Document::parse(source.text.clone()).map_err(|error| SettingsError {
        file: source.file.clone(),
        line: 0,
        key: "vehicle.template".into(),
        problem: error.message().trim().into(),
    })?;
    parts::free(section.over(Section::root(document.as_table(), &source)), name)
}
