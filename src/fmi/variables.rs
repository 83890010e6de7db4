//! The table of FMU variables: inputs, outputs, parameters and what they mean.

use super::parameters;
use super::variable::WHEELSET;
pub use super::variable::{Kind, Role, Variable};
use crate::formulation::{
    AssemblyError, DRIVE_TORQUE, LATERAL_FORCE, LEFT_FRICTION, LONGITUDINAL_FORCE, NEUTRAL_INPUTS, RAIL_INPUTS, RIGHT_FRICTION,
    VERTICAL_FORCE, rail_input,
};
use crate::geometry::Side;
use crate::scene::assemble;
use crate::scene::spec::{RAIL_MOTION, Scene};
use crate::sim::feedthrough::whose;
use crate::sim::outputs::Output;
use crate::sim::vehicle_outputs::scene_outputs;
use crate::sim::{SimulationState, input_index};
use crate::units::Unit;
use std::collections::HashMap;

/// All variables of a scene.
pub struct VariableTable {
    pub variables: Vec<Variable>,
    pub outputs: Vec<Output>,
    /// Values of all inputs of the model, shown or not, before a master sets any.
    pub neutral_inputs: Vec<f64>,
    wheelsets: usize,
    /// Index of each reference.
    index: HashMap<u32, usize>,
}

/// Local numbers of the rails' motion: left from here, right 10 behind.
const RAIL: u32 = 501;

impl VariableTable {
    /// Builds the table of a scene.
    ///
    /// # Errors
    /// [`AssemblyError`] when the formulation can't treat the scene.
    pub fn new(scene: &Scene) -> Result<Self, AssemblyError> {
        let model = assemble::model(scene)?;
        let outputs = scene_outputs(scene, &model);
        let mut variables = inputs(scene);
        variables.extend(outputs.iter().enumerate().map(|(index, output)| Variable {
            reference: output.reference,
            name: output.name.clone(),
            description: output.description.clone(),
            kind: Kind::Real,
            causality: "output",
            variability: "continuous",
            initial: Some("calculated"),
            unit: output.unit,
            start: None,
            min: None,
            max: None,
            role: Role::Output(index),
        }));
        variables.extend(parameters::parameters(scene));
        variables.extend(locals(model.formulation.constrains(), scene.solver.integrator.linearises()));
        let index = variables.iter().enumerate().map(|(index, variable)| (variable.reference, index)).collect();
        Ok(VariableTable { variables, outputs, neutral_inputs: model.neutral_inputs(), wheelsets: model.wheelsets.len(), index })
    }

    /// The variable with a reference.
    pub fn find(&self, reference: u32) -> Option<&Variable> {
        self.index.get(&reference).map(|index| &self.variables[*index])
    }

    /// 1-based indices of the inputs that an output depends on.
    pub fn dependencies(&self, output: &Output) -> Vec<usize> {
        let depends = |input: usize| {
            let (wheelset, number) = whose(self.wheelsets, input);
            output.wheelset.is_none_or(|own| own == wheelset) && output.feedthrough.contains(&number)
        };
        let indexed = self.variables.iter().enumerate();
        indexed.filter_map(|(index, variable)| matches!(variable.role, Role::Input(input) if depends(input)).then_some(index + 1)).collect()
    }
}

fn inputs(scene: &Scene) -> Vec<Variable> {
    let axles = scene.vehicle.axles().into_iter().enumerate();
    let of_axle = |(index, axle): (usize, (&str, bool))| {
        let mut variables = axle_inputs(scene, index, axle);
        variables.extend(rail_inputs(scene, index, axle.0));
        variables
    };
    axles.filter(|(_, axle)| scene.interface.shows(axle.0)).flat_map(of_axle).collect()
}

/// Motion of the rails under a wheelset; none where the scene does not ask for it.
fn rail_inputs(scene: &Scene, index: usize, wheelset: &str) -> Vec<Variable> {
    if !scene.interface.inputs.contains(&RAIL_MOTION) {
        return Vec::new();
    }
    let rows: [(&str, Unit, &str); RAIL_INPUTS] = [
        ("railLateralDisplacement", Unit::Metre, "displacement of the rail under the wheel across the track, left positive"),
        ("railVerticalDisplacement", Unit::Metre, "displacement of the rail under the wheel, up positive"),
        ("railLateralVelocity", Unit::MetrePerSecond, "velocity of the rail's material under the wheel across the track, left positive"),
        ("railVerticalVelocity", Unit::MetrePerSecond, "velocity of the rail's material under the wheel, up positive"),
        ("railLateralSlope", Unit::One, "change of railLateralDisplacement per distance along the track; 0 for a track that travels along"),
        (
            "railVerticalSlope",
            Unit::One,
            "change of railVerticalDisplacement per distance along the track; 0 for a track that travels along",
        ),
    ];
    let wheelsets = scene.vehicle.axles().len();
    let of_side = |side: Side| {
        rows.into_iter().enumerate().map(move |(number, (name, unit, text))| {
            let id = RAIL + 10 * side.index() as u32 + number as u32;
            let name = format!("{}.{name}", side.name());
            input((index, wheelset), (id, &name, text), (unit, None), 0.0, rail_input(wheelsets, index, side, number))
        })
    };
    Side::BOTH.into_iter().flat_map(of_side).collect()
}

fn axle_inputs(scene: &Scene, index: usize, (wheelset, driven): (&str, bool)) -> Vec<Variable> {
    let rows = [
        (1, "drive_torque", "driveTorque", Unit::NewtonMetre, None, DRIVE_TORQUE, "torque about the axle, positive drives forward"),
        (2, "centre_forces", "lateralForceInput", Unit::Newton, None, LATERAL_FORCE, "external lateral force on the centre, left positive"),
        (
            3,
            "centre_forces",
            "verticalForceInput",
            Unit::Newton,
            None,
            VERTICAL_FORCE,
            "external vertical force on the centre, up positive",
        ),
        (4, "friction", "left.frictionFactor", Unit::One, Some(0.0), LEFT_FRICTION, "factor on the friction coefficient at the left wheel"),
        (
            5,
            "friction",
            "right.frictionFactor",
            Unit::One,
            Some(0.0),
            RIGHT_FRICTION,
            "factor on the friction coefficient at the right wheel",
        ),
        (
            6,
            "centre_forces",
            "longitudinalForceInput",
            Unit::Newton,
            None,
            LONGITUDINAL_FORCE,
            "external longitudinal force on the centre, forward positive",
        ),
    ];
    // Along the track an imposed speed leaves no room for a force.
    let moves = |input| input != LONGITUDINAL_FORCE || !driven;
    let shown = rows.into_iter().filter(|row| scene.interface.inputs.contains(&row.1) && moves(row.5));
    shown
        .map(|(id, _, name, unit, min, number, text)| {
            input((index, wheelset), (id, name, text), (unit, min), NEUTRAL_INPUTS[number], input_index(index, number))
        })
        .collect()
}

/// The input `place` of the model, at a wheelset: index and name of that; number, name and words; unit and least value; neutral value.
fn input(
    (index, wheelset): (usize, &str),
    (id, name, text): (u32, &str, &str),
    (unit, min): (Unit, Option<f64>),
    neutral: f64,
    place: usize,
) -> Variable {
    Variable {
        reference: WHEELSET * (index as u32 + 1) + id,
        name: format!("{wheelset}.{name}"),
        description: text.into(),
        kind: Kind::Real,
        causality: "input",
        variability: "continuous",
        initial: None,
        unit,
        start: Some(neutral),
        min,
        max: None,
        role: Role::Input(place),
    }
}

/// Counters of work; those of constraints only where contact is one, those of implicit methods only with one.
fn locals(constrains: bool, linearises: bool) -> Vec<Variable> {
    let counter = |reference, name: &str, text: &str, read: fn(&SimulationState) -> u64| Variable {
        reference,
        name: name.into(),
        description: text.into(),
        kind: Kind::Integer,
        causality: "local",
        variability: "discrete",
        initial: Some("calculated"),
        unit: Unit::One,
        start: None,
        min: None,
        max: None,
        role: Role::Counter(read),
    };
    let mut locals = vec![
        counter(900, "solver.steps", "accepted steps of the integrator since the start", |s| s.integration.statistics.steps),
        counter(901, "solver.rejectedSteps", "rejected attempts", |s| s.integration.statistics.rejected),
        counter(902, "solver.evaluations", "evaluations of the right-hand side", |s| s.integration.statistics.evaluations),
        counter(903, "solver.restarts", "restarts at changes of inputs", |s| s.integration.statistics.restarts),
        counter(904, "solver.searchIterations", "Newton iterations of contact searches; pairs of nodes looked at in ECF-N", |s| {
            s.work.search_iterations
        }),
        Variable {
            reference: 910,
            name: "scene.title".into(),
            description: "title of the scene that this FMU was made from".into(),
            kind: Kind::String,
            causality: "local",
            variability: "constant",
            initial: Some("exact"),
            unit: Unit::One,
            start: None,
            min: None,
            max: None,
            role: Role::Title,
        },
    ];
    if constrains {
        locals.extend([
            counter(905, "solver.projections", "steps whose end was moved onto the constraints (in ACCF every evaluation does it)", |s| {
                s.integration.statistics.projections
            }),
            counter(906, "solver.events", "lift-offs and landings", |s| s.integration.statistics.events),
            counter(907, "solver.constraintIterations", "Newton iterations on the position constraints", |s| s.work.constraint_iterations),
            counter(908, "solver.forceIterations", "evaluations of the loop between normal and creep forces", |s| s.work.force_iterations),
        ]);
    }
    if linearises {
        locals.extend([
            counter(911, "solver.linearisations", "Jacobians", |s| s.integration.statistics.linearisations),
            counter(912, "solver.factorisations", "factorisations of I - a J", |s| s.integration.statistics.factorisations),
            counter(913, "solver.iterations", "Newton iterations of the integrator", |s| s.integration.statistics.iterations),
        ]);
    }
    locals
}
