//! What the description says otherwise in FMI 3.0: capabilities, variables with a type each, arrays, references in place of indices.

use super::kind_of;
use super::{OUTPUT_DERIVATIVE_ORDER, Xml, number};
use crate::fmi::variables::{Array, Kind, Role, Variable, VariableTable};
use crate::scene::spec::Scene;
use std::io;

/// Are directional derivatives (and adjoint ones) provided? `ffi::v3::derivatives` answers the calls.
const DIRECTIONAL_DERIVATIVES: &str = "true";

pub(super) fn co_simulation(xml: &mut Xml, identifier: &str) -> io::Result<()> {
    let order = OUTPUT_DERIVATIVE_ORDER.to_string();
    xml.create_element("CoSimulation")
        .with_attributes([
            ("modelIdentifier", identifier),
            ("canGetAndSetFMUState", "true"),
            ("canSerializeFMUState", "true"),
            ("providesDirectionalDerivatives", DIRECTIONAL_DERIVATIVES),
            ("providesAdjointDerivatives", DIRECTIONAL_DERIVATIVES),
            ("providesPerElementDependencies", "true"),
            ("canHandleVariableCommunicationStepSize", "true"),
            ("maxOutputDerivativeOrder", order.as_str()),
            ("recommendedIntermediateInputSmoothness", "0"),
            ("providesIntermediateUpdate", "true"),
            ("mightReturnEarlyFromDoStep", "true"),
            ("canReturnEarlyAfterIntermediateUpdate", "true"),
            ("hasEventMode", "true"),
            ("providesEvaluateDiscreteStates", "false"),
        ])
        .write_empty()?;
    Ok(())
}

pub(super) fn model_variables(xml: &mut Xml, scene: &Scene, table: &VariableTable) -> io::Result<()> {
    let (time, discrete) = table.additions.variables.split_at(1);
    xml.create_element("ModelVariables").write_inner_content(|xml| {
        for variable in time.iter().chain(&table.variables).chain(discrete) {
            scalar(xml, scene, table, variable)?;
        }
        for array in &table.additions.arrays {
            whole(xml, array)?;
        }
        Ok(())
    })?;
    Ok(())
}

/// May a host read or set it while a step is under way?
fn in_steps(variable: &Variable) -> bool {
    matches!(variable.role, Role::Input(_) | Role::Output(_))
}

fn scalar(xml: &mut Xml, scene: &Scene, table: &VariableTable, variable: &Variable) -> io::Result<()> {
    let kind = match variable.kind {
        Kind::Real => "Float64",
        Kind::Integer => "Int32",
        Kind::Boolean => "Boolean",
        Kind::String => "String",
    };
    let reference = variable.reference.to_string();
    let mut element = xml.create_element(kind).with_attributes([
        ("name", variable.name.as_str()),
        ("valueReference", reference.as_str()),
        ("description", variable.description.as_str()),
        ("causality", variable.causality),
        ("variability", variable.variability),
    ]);
    if in_steps(variable) {
        element = element.with_attribute(("intermediateUpdate", "true"));
    }
    if let Some(initial) = variable.initial {
        element = element.with_attribute(("initial", initial));
    }
    if variable.kind == Kind::Real {
        element = element.with_attributes([("declaredType", variable.unit.type_name()), ("unit", variable.unit.name())]);
    }
    let written = |value: f64| match variable.kind {
        Kind::Real => number(value),
        Kind::Boolean => (value == 1.0).to_string(),
        _ => format!("{value:.0}"),
    };
    for (name, value) in [("min", variable.min), ("max", variable.max), ("start", variable.start)] {
        if let Some(value) = value {
            element = element.with_attribute((name, written(value).as_str()));
        }
    }
    if let Some(place) = table.integral(variable) {
        element = element.with_attribute(("derivative", table.at(place).reference.to_string().as_str()));
    }
    match variable.role {
        Role::Title => element.write_inner_content(|xml| {
            xml.create_element("Start").with_attribute(("value", scene.title.as_str())).write_empty()?;
            Ok(())
        })?,
        _ => element.write_empty()?,
    };
    Ok(())
}

fn whole(xml: &mut Xml, array: &Array) -> io::Result<()> {
    let reference = array.reference.to_string();
    xml.create_element("Float64")
        .with_attributes([
            ("name", array.name.as_str()),
            ("valueReference", reference.as_str()),
            ("description", array.description.as_str()),
            ("causality", "output"),
            ("variability", "continuous"),
            ("intermediateUpdate", "true"),
            ("initial", "calculated"),
            ("declaredType", array.unit.type_name()),
            ("unit", array.unit.name()),
        ])
        .write_inner_content(|xml| {
            for dimension in &array.dimensions {
                xml.create_element("Dimension").with_attribute(("start", dimension.to_string().as_str())).write_empty()?;
            }
            Ok(())
        })?;
    Ok(())
}

/// Words, one space between.
fn list(words: impl IntoIterator<Item = impl ToString>) -> String {
    words.into_iter().map(|word| word.to_string()).collect::<Vec<_>>().join(" ")
}

pub(super) fn model_structure(xml: &mut Xml, table: &VariableTable) -> io::Result<()> {
    let outputs: Vec<u32> = table.output_references();
    xml.create_element("ModelStructure").write_inner_content(|xml| {
        for reference in &outputs {
            let element = xml.create_element("Output").with_attribute(("valueReference", reference.to_string().as_str()));
            // Without a list it depends on all: so do numbers of contacts.
            match table.known_dependencies(*reference) {
                None => element.write_empty()?,
                Some(known) => element
                    .with_attribute(("dependencies", list(known.iter().map(|(input, _)| input)).as_str()))
                    .with_attribute(("dependenciesKind", list(known.iter().map(|(_, fixed)| kind_of(*fixed))).as_str()))
                    .write_empty()?,
            };
        }
        // Initial values depend on every parameter and input: no list means just that.
        for reference in &outputs {
            xml.create_element("InitialUnknown").with_attribute(("valueReference", reference.to_string().as_str())).write_empty()?;
        }
        Ok(())
    })?;
    Ok(())
}
