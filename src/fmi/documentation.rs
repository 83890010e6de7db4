//! documentation/index.html of an FMU, from the same table as modelDescription.xml.

use super::packed_scene::PackedScene;
use super::variables::{Kind, Variable};

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
        let unit = if variable.kind == Kind::Real { variable.unit.name() } else { "" };
        format!(
            "<tr><td><code>{}</code></td><td>{unit}</td><td>{start}</td><td>{}</td></tr>\n",
            escape(&variable.name),
            escape(&variable.description)
        )
    };
    packed.table.variables.iter().filter(|variable| variable.causality == causality).map(row).collect()
}

/// The page.
pub fn html(packed: &PackedScene) -> String {
    let mut tables = String::new();
    for (causality, heading) in [("input", "Inputs"), ("output", "Outputs"), ("parameter", "Parameters"), ("local", "Local variables")] {
        let rows = rows(packed, causality);
        if !rows.is_empty() {
            tables += &format!(
                "<h2>{heading}</h2>\n<table>\n<tr><th>Name</th><th>Unit</th><th>Start</th><th>Meaning</th></tr>\n{rows}</table>\n"
            );
        }
    }
    let text = packed.resources.get("scene.toml").map(|bytes| String::from_utf8_lossy(bytes).into_owned()).unwrap_or_default();
    include_str!("../../fmu/documentation/index.html")
        .replace("{{title}}", &escape(&packed.scene.title))
        .replace("{{name}}", &escape(&packed.scene.name))
        .replace("{{version}}", env!("CARGO_PKG_VERSION"))
        .replace("{{tables}}", &tables)
        .replace("{{scene}}", &escape(&text))
}
