//! An SSP 1.0 package: the FMU, and a placeholder for each model that it may be coupled with (traction, brake, controller, track).
//!
//! A placeholder is a system that sees what one of the FMU's terminals shows. What the vehicle takes comes from inputs of the whole system, which begin with the scene's values: the package runs as
//! it is, as the vehicle alone does, and a model in a placeholder takes an input's place. A placeholder with outputs that hand the inputs through would be nearer to what it is for, but
//! FMPy's master can't follow a connection from a system's input to its own output.

use super::description::{Xml, number, ssp_units};
use super::packed_scene::PackedScene;
use super::terminals::{Terminal, terminals};
use super::variables::{Kind, Role, Variable};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::collections::{BTreeMap, BTreeSet};
use std::io;

/// The vehicle's name in the system.
pub const VEHICLE: &str = "vehicle";
/// The name of the whole system.
const ROOT: &str = "root";

/// The package's files: the description, and the FMU's `bytes` beside it.
pub fn files(packed: &PackedScene, bytes: Vec<u8>) -> BTreeMap<String, Vec<u8>> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    // Writing to memory cannot fail.
    let written = write(&mut xml, packed);
    debug_assert!(written.is_ok());
    let mut text = xml.into_inner();
    text.push(b'\n');
    [("SystemStructure.ssd".to_string(), text), (source(packed), bytes)].into()
}

fn source(packed: &PackedScene) -> String {
    format!("resources/{}.fmu", packed.scene.name)
}

/// A name of letters, digits and underscores, which every tool takes, and that nothing else in its place has.
fn plain(name: &str, taken: &mut BTreeSet<String>) -> String {
    let mut plain: String = name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '_' }).collect();
    plain = plain.trim_matches('_').to_string();
    if !plain.starts_with(|first: char| first.is_ascii_alphabetic()) {
        plain.insert(0, 'x');
    }
    let mut unique = plain.clone();
    let mut count = 1;
    while !taken.insert(unique.clone()) {
        count += 1;
        unique = format!("{plain}_{count}");
    }
    unique
}

/// One variable of the vehicle at its placeholder.
struct Wire<'a> {
    variable: &'a Variable,
    /// The placeholder's connector; of an input of the vehicle the whole system's.
    connector: String,
}

impl Wire<'_> {
    fn drives(&self) -> bool {
        is_input(self.variable)
    }
}

struct Placeholder<'a> {
    name: String,
    description: &'a str,
    wires: Vec<Wire<'a>>,
}

impl Placeholder<'_> {
    /// Does it see anything of the vehicle?
    fn sees(&self) -> bool {
        self.wires.iter().any(|wire| !wire.drives())
    }
}

fn is_input(variable: &Variable) -> bool {
    matches!(variable.role, Role::Input(_))
}

fn placeholders<'a>(packed: &'a PackedScene, terminals: &'a [Terminal]) -> Vec<Placeholder<'a>> {
    let by_name: BTreeMap<&str, &Variable> = packed.table.variables.iter().map(|variable| (variable.name.as_str(), variable)).collect();
    let (mut names, mut inputs) = (BTreeSet::from([VEHICLE.to_string()]), BTreeSet::new());
    let mut all = Vec::new();
    for terminal in terminals {
        let mut own = BTreeSet::new();
        let wires = terminal.members.iter().filter_map(|(member, variable)| {
            let variable = *by_name.get(variable)?;
            let connector = if is_input(variable) { plain(&variable.name, &mut inputs) } else { plain(member, &mut own) };
            Some(Wire { variable, connector })
        });
        let wires: Vec<Wire> = wires.collect();
        all.push(Placeholder { name: plain(&terminal.name, &mut names), description: terminal.description, wires });
    }
    all
}

fn connector(xml: &mut Xml, name: &str, kind: &str, variable: &Variable) -> io::Result<()> {
    xml.create_element("ssd:Connector").with_attributes([("name", name), ("kind", kind)]).write_inner_content(|xml| {
        match variable.kind {
            Kind::Real => xml.create_element("ssc:Real").with_attribute(("unit", variable.unit.name())).write_empty()?,
            Kind::Integer => xml.create_element("ssc:Integer").write_empty()?,
            Kind::Boolean => xml.create_element("ssc:Boolean").write_empty()?,
            Kind::String => xml.create_element("ssc:String").write_empty()?,
        };
        Ok(())
    })?;
    Ok(())
}

/// From (element, connector) to the same; no element is the system itself.
fn connection(xml: &mut Xml, start: (Option<&str>, &str), end: (Option<&str>, &str)) -> io::Result<()> {
    let mut element = xml.create_element("ssd:Connection");
    for (name, value) in
        [("startElement", start.0), ("startConnector", Some(start.1)), ("endElement", end.0), ("endConnector", Some(end.1))]
    {
        if let Some(value) = value {
            element = element.with_attribute((name, value));
        }
    }
    element.write_empty()?;
    Ok(())
}

fn write(xml: &mut Xml, packed: &PackedScene) -> io::Result<()> {
    let terminals = terminals(packed);
    let placeholders = placeholders(packed, &terminals);
    let stop = number(packed.scene.run.stop);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    xml.create_element("ssd:SystemStructureDescription")
        .with_attributes([
            ("xmlns:ssd", "http://ssp-standard.org/SSP1/SystemStructureDescription"),
            ("xmlns:ssc", "http://ssp-standard.org/SSP1/SystemStructureCommon"),
            ("xmlns:ssv", "http://ssp-standard.org/SSP1/SystemStructureParameterValues"),
            ("version", "1.0"),
            ("name", packed.scene.name.as_str()),
            ("description", packed.scene.title.as_str()),
            ("generationTool", concat!("wheelrail ", env!("CARGO_PKG_VERSION"))),
        ])
        .write_inner_content(|xml| {
            xml.create_element("ssd:System").with_attribute(("name", ROOT)).write_inner_content(|xml| root(xml, packed, &placeholders))?;
            ssp_units(xml, &packed.table)?;
            xml.create_element("ssd:DefaultExperiment")
                .with_attributes([("startTime", "0.0"), ("stopTime", stop.as_str())])
                .write_empty()?;
            Ok(())
        })?;
    Ok(())
}

fn root(xml: &mut Xml, packed: &PackedScene, placeholders: &[Placeholder]) -> io::Result<()> {
    let wires = || placeholders.iter().flat_map(|placeholder| &placeholder.wires);
    let inputs: Vec<(&Variable, &str)> =
        wires().filter(|wire| wire.drives()).map(|wire| (wire.variable, wire.connector.as_str())).collect();
    if !inputs.is_empty() {
        xml.create_element("ssd:Connectors")
            .write_inner_content(|xml| inputs.iter().try_for_each(|(variable, name)| connector(xml, name, "input", variable)))?;
        start_values(xml, &inputs)?;
    }
    xml.create_element("ssd:Elements").write_inner_content(|xml| {
        vehicle(xml, packed)?;
        placeholders.iter().filter(|placeholder| placeholder.sees()).try_for_each(|placeholder| system(xml, placeholder))
    })?;
    if wires().next().is_some() {
        xml.create_element("ssd:Connections").write_inner_content(|xml| {
            for placeholder in placeholders {
                for wire in &placeholder.wires {
                    let (own, outer) = (wire.connector.as_str(), (Some(VEHICLE), wire.variable.name.as_str()));
                    if wire.drives() {
                        connection(xml, (None, own), outer)?;
                    } else {
                        connection(xml, outer, (Some(&placeholder.name), own))?;
                    }
                }
            }
            Ok(())
        })?;
    }
    Ok(())
}

/// What the system's inputs are until someone sets them.
fn start_values(xml: &mut Xml, inputs: &[(&Variable, &str)]) -> io::Result<()> {
    xml.create_element("ssd:ParameterBindings").write_inner_content(|xml| {
        xml.create_element("ssd:ParameterBinding").write_inner_content(|xml| {
            xml.create_element("ssd:ParameterValues").write_inner_content(|xml| {
                let set = xml.create_element("ssv:ParameterSet").with_attributes([("version", "1.0"), ("name", "start")]);
                set.write_inner_content(|xml| {
                    xml.create_element("ssv:Parameters").write_inner_content(|xml| {
                        for (variable, name) in inputs {
                            let value = number(variable.start.unwrap_or(0.0));
                            xml.create_element("ssv:Parameter").with_attribute(("name", *name)).write_inner_content(|xml| {
                                let real = [("value", value.as_str()), ("unit", variable.unit.name())];
                                xml.create_element("ssv:Real").with_attributes(real).write_empty()?;
                                Ok(())
                            })?;
                        }
                        Ok(())
                    })?;
                    Ok(())
                })?;
                Ok(())
            })?;
            Ok(())
        })?;
        Ok(())
    })?;
    Ok(())
}

/// The FMU, with all its inputs and outputs.
fn vehicle(xml: &mut Xml, packed: &PackedScene) -> io::Result<()> {
    let source = source(packed);
    let attributes = [
        ("name", VEHICLE),
        ("type", "application/x-fmu-sharedlibrary"),
        ("source", source.as_str()),
        ("implementation", "CoSimulation"),
        ("description", packed.scene.title.as_str()),
    ];
    let shown = || packed.table.variables.iter().filter(|variable| is_input(variable) || matches!(variable.role, Role::Output(_)));
    let component = xml.create_element("ssd:Component").with_attributes(attributes);
    if shown().next().is_none() {
        component.write_empty()?;
        return Ok(());
    }
    component.write_inner_content(|xml| {
        xml.create_element("ssd:Connectors").write_inner_content(|xml| {
            shown().try_for_each(|variable| connector(xml, &variable.name, if is_input(variable) { "input" } else { "output" }, variable))
        })?;
        Ok(())
    })?;
    Ok(())
}

/// A placeholder, empty.
fn system(xml: &mut Xml, placeholder: &Placeholder) -> io::Result<()> {
    let attributes = [("name", placeholder.name.as_str()), ("description", placeholder.description)];
    xml.create_element("ssd:System").with_attributes(attributes).write_inner_content(|xml| {
        xml.create_element("ssd:Connectors").write_inner_content(|xml| {
            let seen = placeholder.wires.iter().filter(|wire| !wire.drives());
            seen.into_iter().try_for_each(|wire| connector(xml, &wire.connector, "input", wire.variable))
        })?;
        Ok(())
    })?;
    Ok(())
}
