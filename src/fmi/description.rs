//! modelDescription.xml, generated from the variable table, and the GUID that ties it to scene and program.

mod version3;

use super::variables::{Kind, Role, Variable, VariableTable};
use super::version::Version;
use crate::scene::spec::Scene;
use crate::scene::vehicle::templates;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::io;
use toml_edit::{DocumentMut, TableLike};

/// Categories of log messages.
pub const LOG_CATEGORIES: &[(&str, &str)] = &[
    ("logEvents", "initial equilibrium, restarts and work done; contacts beside the first that begin or end"),
    ("logStatusWarning", "calls that were taken otherwise than meant; wheels that lift off or land on rigid contact (always logged)"),
    ("logStatusDiscard", "steps that ended early, and why"),
    ("logStatusError", "calls that were refused, and why (always logged)"),
    ("logAll", "everything"),
];

/// The orders of derivatives that the FMU takes and gives.
pub const INPUT_DERIVATIVE_ORDER: i32 = 2;
pub const OUTPUT_DERIVATIVE_ORDER: i32 = 2;

/// The document and its GUID.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    pub guid: String,
    pub xml: String,
}

/// Writes the description of a scene for the table's version of FMI.
///
/// The GUID is a hash of the document without it, the scene's text, every file that the scene refers to and the
/// program's version: an instance refuses resources that do not belong to the description it was imported with.
pub fn describe(scene: &Scene, table: &VariableTable) -> Description {
    let without = document(scene, table, "");
    let mut hash = Sha256::new();
    let own = [
        env!("CARGO_PKG_VERSION").as_bytes(),
        without.as_bytes(),
        scene.source.text.as_bytes(),
        templates::text(scene.vehicle.template).as_bytes(),
    ];
    for part in own {
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    for file in scene.files() {
        hash.update((file.content.len() as u64).to_le_bytes());
        hash.update(&file.content);
    }
    let digits: String = hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect();
    let guid = format!("{{{}-{}-{}-{}-{}}}", &digits[..8], &digits[8..12], &digits[12..16], &digits[16..20], &digits[20..]);
    Description { xml: document(scene, table, &guid), guid }
}

/// Numbers as XML wants them, shortest form that reads back the same.
pub(super) fn number(value: f64) -> String {
    format!("{value:?}")
}

pub(super) type Xml = Writer<Vec<u8>>;

fn document(scene: &Scene, table: &VariableTable, guid: &str) -> String {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    // Writing to memory cannot fail.
    let written = write_document(&mut xml, scene, table, guid);
    debug_assert!(written.is_ok());
    let mut text = String::from_utf8_lossy(&xml.into_inner()).into_owned();
    text.push('\n');
    text
}

fn settings(text: &str) -> DocumentMut {
    text.parse().unwrap_or_else(|error| unreachable!("embedded description settings: {error}"))
}

fn write_document(xml: &mut Xml, scene: &Scene, table: &VariableTable, guid: &str) -> io::Result<()> {
    let fmi = table.version;
    let header = settings(include_str!("../../modelDescription/header.toml"));
    let entry = |key: &str| header.get(key).and_then(|item| item.as_str()).unwrap_or_default().to_string();
    let types = settings(include_str!("../../modelDescription/types.toml"));
    let version = env!("CARGO_PKG_VERSION");
    let tool = format!("wheelrail {version}");
    let (author, copyright, license) = (entry("author"), entry("copyright"), entry("license"));

    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let token = if fmi == Version::Two { "guid" } else { "instantiationToken" };
    let of_two = (fmi == Version::Two).then_some(("numberOfEventIndicators", "0"));
    xml.create_element("fmiModelDescription")
        .with_attributes([
            ("fmiVersion", fmi.name()),
            ("modelName", scene.name.as_str()),
            (token, guid),
            ("description", scene.title.as_str()),
            ("author", author.as_str()),
            ("version", version),
            ("copyright", copyright.as_str()),
            ("license", license.as_str()),
            ("generationTool", tool.as_str()),
            ("variableNamingConvention", "structured"),
        ])
        .with_attributes(of_two)
        .write_inner_content(|xml| {
            match fmi {
                Version::Two => co_simulation(xml, &scene.name)?,
                Version::Three => version3::co_simulation(xml, &scene.name)?,
            }
            let used = used(table);
            unit_definitions(xml, &types, &used.0)?;
            type_definitions(xml, &types, &used.1, fmi)?;
            xml.create_element("LogCategories").write_inner_content(|xml| {
                for (name, text) in LOG_CATEGORIES {
                    xml.create_element("Category").with_attributes([("name", *name), ("description", *text)]).write_empty()?;
                }
                Ok(())
            })?;
            let (stop, step) = (number(scene.run.stop), number(scene.run.step));
            xml.create_element("DefaultExperiment")
                .with_attributes([("startTime", "0.0"), ("stopTime", stop.as_str()), ("stepSize", step.as_str())])
                .write_empty()?;
            match fmi {
                Version::Two => {
                    model_variables(xml, scene, table)?;
                    model_structure(xml, table)
                }
                Version::Three => {
                    version3::model_variables(xml, scene, table)?;
                    version3::model_structure(xml, table)
                }
            }
        })?;
    Ok(())
}

fn co_simulation(xml: &mut Xml, identifier: &str) -> io::Result<()> {
    let order = OUTPUT_DERIVATIVE_ORDER.to_string();
    xml.create_element("CoSimulation")
        .with_attributes([
            ("modelIdentifier", identifier),
            ("canHandleVariableCommunicationStepSize", "true"),
            ("canInterpolateInputs", "true"),
            ("maxOutputDerivativeOrder", order.as_str()),
            ("canNotUseMemoryManagementFunctions", "true"),
            ("canGetAndSetFMUstate", "true"),
            ("canSerializeFMUstate", "true"),
            ("providesDirectionalDerivative", "true"),
        ])
        .write_empty()?;
    Ok(())
}

fn tables<'a>(types: &'a DocumentMut, key: &str) -> impl Iterator<Item = &'a toml_edit::Table> {
    types.get(key).and_then(|item| item.as_array_of_tables()).into_iter().flat_map(|tables| tables.iter())
}

fn text<'a>(table: &'a dyn TableLike, key: &str) -> &'a str {
    table.get(key).and_then(|item| item.as_str()).unwrap_or_default()
}

fn float(item: &toml_edit::Item) -> f64 {
    item.as_float().or(item.as_integer().map(|i| i as f64)).unwrap_or_default()
}

/// Names of units and types that real variables use.
fn used(table: &VariableTable) -> (BTreeSet<&'static str>, BTreeSet<&'static str>) {
    let reals = table.variables.iter().chain(&table.additions.variables).filter(|variable| variable.kind == Kind::Real);
    reals.map(|variable| (variable.unit.name(), variable.unit.type_name())).unzip()
}

fn unit_definitions(xml: &mut Xml, types: &DocumentMut, units: &BTreeSet<&str>) -> io::Result<()> {
    xml.create_element("UnitDefinitions").write_inner_content(|xml| {
        for unit in tables(types, "unit").filter(|unit| units.contains(text(*unit, "name"))) {
            xml.create_element("Unit").with_attribute(("name", text(unit, "name"))).write_inner_content(|xml| {
                base_unit(xml, "BaseUnit", unit)?;
                let displays = unit.get("display").and_then(|item| item.as_array()).into_iter().flat_map(|array| array.iter());
                for display in displays.filter_map(|display| display.as_inline_table()) {
                    let factor = number(display.get("factor").and_then(|factor| factor.as_float()).unwrap_or(1.0));
                    xml.create_element("DisplayUnit")
                        .with_attributes([("name", text(display, "name")), ("factor", factor.as_str())])
                        .write_empty()?;
                }
                Ok(())
            })?;
        }
        Ok(())
    })?;
    Ok(())
}

/// The exponents of a unit's base units.
fn base_unit(xml: &mut Xml, element: &str, unit: &toml_edit::Table) -> io::Result<()> {
    let mut base = xml.create_element(element);
    if let Some(exponents) = unit.get("base").and_then(|item| item.as_table_like()) {
        for (name, exponent) in exponents.iter() {
            let exponent = exponent.as_integer().unwrap_or_default().to_string();
            base = base.with_attribute((name, exponent.as_str()));
        }
    }
    base.write_empty()?;
    Ok(())
}

/// The units of a table's variables as an SSD file has them.
pub(super) fn ssp_units(xml: &mut Xml, table: &VariableTable) -> io::Result<()> {
    let types = settings(include_str!("../../modelDescription/types.toml"));
    let (units, _) = used(table);
    xml.create_element("ssd:Units").write_inner_content(|xml| {
        for unit in tables(&types, "unit").filter(|unit| units.contains(text(*unit, "name"))) {
            let element = xml.create_element("ssc:Unit").with_attribute(("name", text(unit, "name")));
            element.write_inner_content(|xml| base_unit(xml, "ssc:BaseUnit", unit))?;
        }
        Ok(())
    })?;
    Ok(())
}

fn type_definitions(xml: &mut Xml, types: &DocumentMut, names: &BTreeSet<&str>, fmi: Version) -> io::Result<()> {
    xml.create_element("TypeDefinitions").write_inner_content(|xml| {
        for definition in tables(types, "type").filter(|definition| names.contains(text(*definition, "name"))) {
            let name = ("name", text(definition, "name"));
            let nominal = definition.get("nominal").map(|nominal| number(float(nominal)));
            let mut attributes = vec![("quantity", text(definition, "quantity")), ("unit", text(definition, "unit"))];
            attributes.extend(definition.contains_key("display").then(|| ("displayUnit", text(definition, "display"))));
            attributes.extend(nominal.as_ref().map(|nominal| ("nominal", nominal.as_str())));
            match fmi {
                Version::Two => xml.create_element("SimpleType").with_attribute(name).write_inner_content(|xml| {
                    xml.create_element("Real").with_attributes(attributes).write_empty()?;
                    Ok(())
                })?,
                Version::Three => xml.create_element("Float64Type").with_attribute(name).with_attributes(attributes).write_empty()?,
            };
        }
        Ok(())
    })?;
    Ok(())
}

fn model_variables(xml: &mut Xml, scene: &Scene, table: &VariableTable) -> io::Result<()> {
    xml.create_element("ModelVariables").write_inner_content(|xml| {
        for (index, variable) in table.variables.iter().enumerate() {
            // Numbers help a reader with the indices of ModelStructure.
            xml.write_event(Event::Comment(BytesText::new(&format!(" {} ", index + 1))))?;
            let reference = variable.reference.to_string();
            let mut element = xml.create_element("ScalarVariable").with_attributes([
                ("name", variable.name.as_str()),
                ("valueReference", reference.as_str()),
                ("description", variable.description.as_str()),
                ("causality", variable.causality),
                ("variability", variable.variability),
            ]);
            if let Some(initial) = variable.initial {
                element = element.with_attribute(("initial", initial));
            }
            element.write_inner_content(|xml| type_element(xml, scene, table, variable))?;
        }
        Ok(())
    })?;
    Ok(())
}

fn type_element(xml: &mut Xml, scene: &Scene, table: &VariableTable, variable: &Variable) -> io::Result<()> {
    match variable.kind {
        Kind::Real => {
            let mut real =
                xml.create_element("Real").with_attributes([("declaredType", variable.unit.type_name()), ("unit", variable.unit.name())]);
            for (name, value) in [("min", variable.min), ("max", variable.max), ("start", variable.start)] {
                if let Some(value) = value {
                    real = real.with_attribute((name, number(value).as_str()));
                }
            }
            if let Some(place) = table.integral(variable) {
                real = real.with_attribute(("derivative", (place + 1).to_string().as_str()));
            }
            real.write_empty()?;
        }
        Kind::Integer => {
            xml.create_element("Integer").write_empty()?;
        }
        Kind::Boolean => {
            let start = if variable.start == Some(1.0) { "true" } else { "false" };
            xml.create_element("Boolean").with_attribute(("start", start)).write_empty()?;
        }
        Kind::String => {
            let start = if matches!(variable.role, Role::Title) { scene.title.as_str() } else { "" };
            xml.create_element("String").with_attribute(("start", start)).write_empty()?;
        }
    }
    Ok(())
}

/// dependenciesKind of an input that enters an output with a factor that parameters alone say, or not.
fn kind_of(fixed: bool) -> &'static str {
    if fixed { "fixed" } else { "dependent" }
}

fn model_structure(xml: &mut Xml, table: &VariableTable) -> io::Result<()> {
    let outputs: Vec<(String, String, String)> = table
        .variables
        .iter()
        .enumerate()
        .filter_map(|(index, variable)| match variable.role {
            Role::Output(output) => {
                let known = table.dependencies(&table.outputs[output]);
                let inputs: Vec<String> = known.iter().map(|(input, _)| input.to_string()).collect();
                let kinds: Vec<&str> = known.iter().map(|(_, fixed)| kind_of(*fixed)).collect();
                Some(((index + 1).to_string(), inputs.join(" "), kinds.join(" ")))
            }
            _ => None,
        })
        .collect();
    xml.create_element("ModelStructure").write_inner_content(|xml| {
        if outputs.is_empty() {
            return Ok(());
        }
        xml.create_element("Outputs").write_inner_content(|xml| {
            for (index, dependencies, kinds) in &outputs {
                let known = [("index", index.as_str()), ("dependencies", dependencies.as_str())];
                let kinds = (!kinds.is_empty()).then_some(("dependenciesKind", kinds.as_str()));
                xml.create_element("Unknown").with_attributes(known.into_iter().chain(kinds)).write_empty()?;
            }
            Ok(())
        })?;
        // Initial values depend on every parameter and input: no list means just that.
        xml.create_element("InitialUnknowns").write_inner_content(|xml| {
            for (index, ..) in &outputs {
                xml.create_element("Unknown").with_attribute(("index", index.as_str())).write_empty()?;
            }
            Ok(())
        })?;
        Ok(())
    })?;
    Ok(())
}
