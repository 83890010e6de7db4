//! terminalsAndIcons/terminalsAndIcons.xml of FMI 3.0, which FMI 2.0.4 has taken over as it is: variables that belong to one connection, in one terminal.
//!
//! A wheelset has a terminal `W.axle` (what acts on it, and what a model of traction or control reads), each wheel on rails that move `W.left.rail`, and each force element
//! with inputs one of its own name. Members have the names that are the same in every terminal of a kind, so that a tool connects by them (rule `bus`).

use super::packed_scene::PackedScene;
use super::variable::WHEELSET;
use super::variables::{Role, Variable};
use crate::sim::vehicle_outputs::FORCE_INPUT;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::io;

/// Base name of the terminals' picture in the same folder.
pub const ICON: &str = "terminal";

/// Outputs that a wheelset's terminal shows beside its inputs, where the scene shows them.
const READ: [&str; 8] = ["distance", "y", "yaw", "vx", "pitchRate", "drivingForce", "slipSpeed", "usedAdhesion"];

/// One terminal: its name, what it is, and member names with their variables.
pub(super) struct Terminal<'a> {
    pub name: String,
    pub description: &'static str,
    pub members: Vec<(&'a str, &'a str)>,
    /// At the upper edge of the icon, else at the lower one.
    above: bool,
}

fn is_input(variable: &Variable) -> bool {
    matches!(variable.role, Role::Input(_))
}

/// Members: variables below a part, by their names there.
fn members<'a>(variables: &'a [Variable], part: &str, wanted: impl Fn(&Variable, &str) -> bool) -> Vec<(&'a str, &'a str)> {
    let below = |variable: &'a Variable| {
        let rest = variable.name.strip_prefix(part)?.strip_prefix('.')?;
        wanted(variable, rest).then_some((rest, variable.name.as_str()))
    };
    variables.iter().filter_map(below).collect()
}

/// The terminals of an FMU.
pub(super) fn terminals(packed: &PackedScene) -> Vec<Terminal<'_>> {
    let variables = &packed.table.variables;
    let mut all = Vec::new();
    for (wheelset, _) in packed.scene.vehicle.axles() {
        let of_rail = |rest: &str| rest.starts_with("rail");
        let axle = |variable: &Variable, rest: &str| {
            let own = variable.reference < FORCE_INPUT && variable.reference >= WHEELSET;
            own && (is_input(variable) && !rest.split('.').any(of_rail) || READ.contains(&rest))
        };
        let description = "forces on the wheelset, friction under its wheels, and its motion";
        all.push(Terminal { name: format!("{wheelset}.axle"), description, members: members(variables, wheelset, axle), above: false });
        for side in ["left", "right"] {
            let part = format!("{wheelset}.{side}");
            let description = "the rail under the wheel: its motion in, the wheel's forces on it out";
            let members = members(variables, &part, |_, rest| of_rail(rest));
            // Forces alone are no connection.
            let moves = members.iter().any(|member| member.0.ends_with("Displacement"));
            if moves {
                all.push(Terminal { name: format!("{part}.rail"), description, members, above: false });
            }
        }
    }
    for element in packed.scene.vehicle.forces.iter().map(|element| element.0.name()) {
        let found =
            members(variables, element, |variable, rest| !rest.contains('.') && (is_input(variable) || variable.causality == "output"));
        let driven = variables.iter().any(|variable| {
            is_input(variable) && variable.reference >= FORCE_INPUT && found.iter().any(|member| member.1 == variable.name)
        });
        if driven {
            let description = "inputs of the force element, and what it reports";
            all.push(Terminal { name: element.into(), description, members: found, above: true });
        }
    }
    all.retain(|terminal| !terminal.members.is_empty());
    all
}

/// The document.
pub fn xml(packed: &PackedScene) -> String {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    // Writing to memory cannot fail.
    let written = write(&mut xml, &terminals(packed));
    debug_assert!(written.is_ok());
    let mut text = String::from_utf8_lossy(&xml.into_inner()).into_owned();
    text.push('\n');
    text
}

/// Half the icon's width and height, and a terminal's, mm.
const HALF: f64 = 100.0;
const SMALL: f64 = 4.0;

fn corners(low: (f64, f64), high: (f64, f64)) -> [(&'static str, String); 4] {
    [("x1", low.0), ("y1", low.1), ("x2", high.0), ("y2", high.1)].map(|(name, value)| (name, format!("{value:.1}")))
}

/// Of the terminals' format, in FMUs of either version.
const VERSION: &str = "3.0";

fn write(xml: &mut Writer<Vec<u8>>, terminals: &[Terminal]) -> io::Result<()> {
    let whole = corners((-HALF, -HALF), (HALF, HALF));
    let whole = || whole.iter().map(|(name, value)| (*name, value.as_str()));
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    xml.create_element("fmiTerminalsAndIcons").with_attribute(("fmiVersion", VERSION)).write_inner_content(|xml| {
        xml.create_element("GraphicalRepresentation").write_inner_content(|xml| {
            let system = xml.create_element("CoordinateSystem").with_attributes(whole());
            system.with_attribute(("suggestedScalingFactorTo_mm", "0.1")).write_empty()?;
            xml.create_element("Icon").with_attributes(whole()).write_empty()?;
            Ok(())
        })?;
        if terminals.is_empty() {
            return Ok(());
        }
        xml.create_element("Terminals").write_inner_content(|xml| {
            for (place, terminal) in terminals.iter().enumerate() {
                let row = terminals.iter().filter(|other| other.above == terminal.above).count();
                let before = terminals[..place].iter().filter(|other| other.above == terminal.above).count();
                let x = HALF * ((2 * before + 1) as f64 / row as f64 - 1.0);
                one(xml, terminal, (x, if terminal.above { HALF } else { -HALF }))?;
            }
            Ok(())
        })?;
        Ok(())
    })?;
    Ok(())
}

/// A terminal with its middle at (x, y) of the icon.
fn one(xml: &mut Writer<Vec<u8>>, terminal: &Terminal, (x, y): (f64, f64)) -> io::Result<()> {
    let attributes = [("name", terminal.name.as_str()), ("matchingRule", "bus"), ("description", terminal.description)];
    xml.create_element("Terminal").with_attributes(attributes).write_inner_content(|xml| {
        for (member, variable) in &terminal.members {
            xml.create_element("TerminalMemberVariable")
                .with_attributes([("variableName", *variable), ("memberName", *member), ("variableKind", "signal")])
                .write_empty()?;
        }
        let corners = corners((x - SMALL, y - SMALL), (x + SMALL, y + SMALL));
        xml.create_element("TerminalGraphicalRepresentation")
            .with_attributes(corners.iter().map(|(name, value)| (*name, value.as_str())))
            .with_attribute(("iconBaseName", ICON))
            .write_empty()?;
        Ok(())
    })?;
    Ok(())
}
