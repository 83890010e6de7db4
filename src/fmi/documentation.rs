//! documentation/index.html of an FMU, from the same table as modelDescription.xml.

use super::packed_scene::PackedScene;
use super::variables::{Kind, Variable};
use super::vehicle_picture::{self, Drawing};
use super::version::Version;
use crate::scene::assemble;
use crate::scene::plan::{self, Effect};

/// Text as HTML.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn rows(packed: &PackedScene, causality: &str) -> String {
    let row = |variable: &Variable| {
        let start = match (variable.kind, variable.start) {
            (Kind::Boolean, Some(value)) => (value == 1.0).to_string(),
            (_, Some(value)) => value.to_string(),
            (_, None) => String::new(),
        };
        let (kind, unit) = match variable.kind {
            Kind::Real => ("real", variable.unit.name()),
            Kind::Integer => ("integer", ""),
            Kind::Boolean => ("boolean", ""),
            Kind::String => ("text", ""),
        };
        let bound = |bound: Option<f64>| bound.map(|bound| bound.to_string()).unwrap_or_default();
        let (least, most, tunable) = (bound(variable.min), bound(variable.max), if variable.is_tunable() { ", tunable" } else { "" });
        let derivative = packed.table.integral(variable).map(|place| format!("; derivative of {}", packed.table.at(place).name));
        format!(
            "<tr><td><code>{}</code></td><td>{kind}{tunable}</td><td>{unit}</td><td>{start}</td><td>{least}</td><td>{most}</td><td>{}</td></tr>\n",
            escape(&variable.name),
            escape(&format!("{}{}", variable.description, derivative.unwrap_or_default()))
        )
    };
    packed
        .table
        .variables
        .iter()
        .chain(&packed.table.additions.variables)
        .filter(|variable| variable.causality == causality)
        .map(row)
        .collect()
}

/// The table of arrays, with their dimensions.
fn arrays(packed: &PackedScene) -> String {
    let arrays = &packed.table.additions.arrays;
    if arrays.is_empty() {
        return String::new();
    }
    let mut table =
        "<h2>Arrays of outputs</h2>\n<table>\n<tr><th>Name</th><th>Unit</th><th>Dimensions</th><th>Meaning</th></tr>\n".to_string();
    for array in arrays {
        let dimensions: Vec<String> = array.dimensions.iter().map(usize::to_string).collect();
        let (name, unit, text) = (escape(&array.name), array.unit.name(), escape(&array.description));
        table += &format!("<tr><td><code>{name}</code></td><td>{unit}</td><td>{}</td><td>{text}</td></tr>\n", dimensions.join(" x "));
    }
    table + "</table>\n"
}

/// What the page says of the calls of its version: on moving inputs, and on steps that can't be finished.
fn words(version: Version) -> (&'static str, &'static str) {
    match version {
        Version::Two => (
            "; <code>fmi2SetRealInputDerivatives</code> (orders 1 and 2) spares that while an input moves smoothly. Setting an input's value ends its derivatives",
            "A step that cannot be finished returns fmi2Discard; time then stands at the last successful step.",
        ),
        Version::Three => (
            ". Inputs may also be set within a step, from <code>intermediateUpdate</code>",
            "A step that cannot be finished returns fmi3Discard, and the instance stands where the step began. A derailment is an end: terminateSimulation.",
        ),
    }
}

/// The table of effects: what is computed, what only where it acts, what not, and why.
fn effects(packed: &PackedScene) -> String {
    let Ok(model) = assemble::model(&packed.scene) else { return String::new() };
    let plan = plan::plan(&packed.scene, &model);
    let row = |effect: &Effect| {
        format!("<tr><td>{}</td><td>{}</td><td>{}</td></tr>\n", effect.mark(), escape(effect.name), escape(&effect.words()))
    };
    let notes = plan.notes.iter().map(|note| format!("<li>{}</li>\n", escape(note))).collect::<String>();
    let rows = plan.effects.iter().map(row).collect::<String>();
    format!("<table>\n<tr><th></th><th>Effect</th><th>Why</th></tr>\n{rows}</table>\n<ul>\n{notes}</ul>\n")
}

/// The page.
pub fn html(packed: &PackedScene) -> String {
    let mut tables = String::new();
    for (causality, heading) in [("input", "Inputs"), ("output", "Outputs"), ("parameter", "Parameters"), ("local", "Local variables")] {
        let rows = rows(packed, causality);
        if !rows.is_empty() {
            tables += &format!(
                "<h2>{heading}</h2>\n<table>\n<tr><th>Name</th><th>Type</th><th>Unit</th><th>Start</th><th>Min</th><th>Max</th><th>Meaning</th></tr>\n{rows}</table>\n"
            );
        }
    }
    tables += &arrays(packed);
    let (derivatives, discard) = words(packed.table.version);
    let text = packed.resources.get("scene.toml").map(|bytes| String::from_utf8_lossy(bytes).into_owned()).unwrap_or_default();
    include_str!("../../fmu/documentation/index.html")
        .replace("{{title}}", &escape(&packed.scene.title))
        .replace("{{name}}", &escape(&packed.scene.name))
        .replace("{{version}}", env!("CARGO_PKG_VERSION"))
        .replace("{{fmi}}", packed.table.version.name())
        .replace("{{stop}}", &packed.scene.run.stop.to_string())
        .replace("{{step}}", &packed.scene.run.step.to_string())
        .replace("{{axes}}", vehicle_picture::AXES)
        .replace("{{vehicle}}", &Drawing::new(&packed.scene.vehicle).svg())
        .replace("{{derivatives}}", derivatives)
        .replace("{{discard}}", discard)
        .replace("{{effects}}", &effects(packed))
        .replace("{{tables}}", &tables)
        .replace("{{scene}}", &escape(&text))
}
