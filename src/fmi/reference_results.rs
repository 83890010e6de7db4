//! Results of a native run inside the FMU, for whoever wants to know that it runs elsewhere as it did here: the layered standard FMI-LS-REF (related files, 1.0.0-alpha.1).

use super::description::Xml;
use super::packed_scene::PackedScene;
use crate::sim::Simulation;
use crate::sim::recording::{Recording, communication_points};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::collections::BTreeMap;
use std::io;

/// The layered standard's name, and below `extra/` its folder.
pub const STANDARD: &str = "org.fmi-standard.fmi-ls-ref";
/// The file of results in that folder.
pub const RESULTS: &str = "reference.csv";
/// Rows of results, at most, beside the first.
const ROWS: f64 = 100.0;

/// The layered standard's files: a manifest and the values of all outputs over a run until `stop` [s] with the start values of parameters and inputs, at whole numbers of `run.step`. A run
/// that ends early (a derailment) gives the rows until then.
pub fn files(packed: &PackedScene, stop: f64) -> BTreeMap<String, Vec<u8>> {
    let folder = format!("extra/{STANDARD}");
    let (recording, problem) = record(packed, stop);
    let mut csv = Vec::new();
    // Writing to memory cannot fail.
    let written = recording.write_csv(&mut csv);
    debug_assert!(written.is_ok());
    let manifest = manifest(packed, &recording, problem.as_deref());
    [(RESULTS, csv), ("fmi-ls-manifest.xml", manifest)].map(|(name, bytes)| (format!("{folder}/{name}"), bytes)).into()
}

/// The run, and why it ended before its time.
fn record(packed: &PackedScene, stop: f64) -> (Recording, Option<String>) {
    let outputs = &packed.table.outputs;
    let mut recording = Recording::new(outputs);
    // Columns have the names of variables and nothing more, so that a tool finds them.
    recording.columns.iter_mut().for_each(|column| column.1 = "");
    let step = packed.scene.run.step * (stop / packed.scene.run.step / ROWS).ceil().max(1.0);
    let result = Simulation::new(&packed.scene, 0.0).and_then(|mut simulation| {
        recording.sample(&mut simulation, outputs)?;
        for time in communication_points(0.0, stop, step) {
            simulation.advance(time)?;
            recording.sample(&mut simulation, outputs)?;
        }
        Ok(())
    });
    (recording, result.err().map(|error| error.to_string()))
}

fn manifest(packed: &PackedScene, recording: &Recording, problem: Option<&str>) -> Vec<u8> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    let written = write(&mut xml, packed, recording, problem);
    debug_assert!(written.is_ok());
    let mut text = xml.into_inner();
    text.push(b'\n');
    text
}

fn write(xml: &mut Xml, packed: &PackedScene, recording: &Recording, problem: Option<&str>) -> io::Result<()> {
    let end = recording.rows.last().map_or(0.0, |row| row[0]);
    let early = problem.map(|problem| format!(" The run ended there: {problem}")).unwrap_or_default();
    let results = format!(
        "All outputs of a native run of this scene to {end} s, inputs and parameters at their start values, made by wheelrail {} on {}.{early}",
        env!("CARGO_PKG_VERSION"),
        super::platform::Platform::host().folder(super::version::Version::Three),
    );
    let scene = format!("The scene that this FMU was made from: {}", packed.scene.title);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    xml.create_element("fmiReferences")
        .with_attributes([
            ("xmlns:fmi-ls", "http://fmi-standard.org/fmi-ls-manifest"),
            ("fmi-ls:fmi-ls-name", STANDARD),
            ("fmi-ls:fmi-ls-version", "1.0.0-alpha.1"),
            ("fmi-ls:fmi-ls-description", "Layered Standard providing information on related files included in an FMU."),
        ])
        .write_inner_content(|xml| {
            for (kind, source, role, description) in [
                ("text/csv", RESULTS, "result", results.as_str()),
                ("application/toml", "../../resources/scene.toml", "model", scene.as_str()),
                ("text/html", "../../documentation/index.html", "document", "Variables, axes and the vehicle"),
            ] {
                xml.create_element("Related")
                    .with_attributes([("type", kind), ("source", source), ("role", role), ("description", description)])
                    .write_empty()?;
            }
            Ok(())
        })?;
    Ok(())
}
