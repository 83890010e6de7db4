//! The table of FMU variables: inputs, outputs, parameters and what they mean.

use crate::formulation::{DRIVE_TORQUE, LATERAL_FORCE, LEFT_FRICTION, NEUTRAL_INPUTS, RIGHT_FRICTION, VERTICAL_FORCE};
use crate::geometry::Side;
use crate::scene::assemble;
use crate::scene::spec::{INITIAL, Scene};
use crate::sim::input_index;
use crate::sim::outputs::{Feedthrough, Output, Unit, outputs};
use crate::solve::{Integrator, Statistics};

/// What a variable stands for.
pub enum Role {
    /// Index in the model's input vector.
    Input(usize),
    /// Index in the table of outputs.
    Output(usize),
    /// A field of the scene.
    RealParameter(RealParameter),
    /// `initial.fromEquilibrium`.
    FromEquilibrium,
    /// A work counter.
    Counter(fn(&Statistics) -> u64),
    /// The scene's title.
    Title,
}

/// A real parameter as a field of the scene.
#[derive(Clone, Copy)]
pub struct RealParameter {
    pub get: fn(&Scene, usize) -> f64,
    pub set: fn(&mut Scene, usize, f64),
    /// For fields in arrays.
    index: usize,
}

impl RealParameter {
    pub fn value(&self, scene: &Scene) -> f64 {
        (self.get)(scene, self.index)
    }
    pub fn assign(&self, scene: &mut Scene, value: f64) {
        (self.set)(scene, self.index, value);
    }
}

/// FMI's basic types.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Real,
    Integer,
    Boolean,
    String,
}

/// One scalar variable.
pub struct Variable {
    pub reference: u32,
    pub name: String,
    pub description: String,
    pub kind: Kind,
    pub causality: &'static str,
    pub variability: &'static str,
    /// FMI's attribute `initial`; `None` where it may not be given.
    pub initial: Option<&'static str>,
    /// Of Real variables.
    pub unit: Unit,
    pub start: Option<f64>,
    pub min: Option<f64>,
    pub max: Option<f64>,
    pub role: Role,
}

/// All variables of a scene.
pub struct VariableTable {
    pub variables: Vec<Variable>,
    pub outputs: Vec<Output>,
}

/// References of parameters that belong to no wheelset stay below this; wheelset k (from 1) has k * 1000 to k * 1000 + 999.
const WHEELSET: u32 = 1000;

impl VariableTable {
    /// Builds the table of a scene.
    pub fn new(scene: &Scene) -> Self {
        let model = assemble::model(scene);
        let outputs = outputs(&model, &scene.interface.outputs);
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
        variables.extend(parameters(scene));
        variables.extend(locals());
        VariableTable { variables, outputs }
    }

    /// The variable with a reference and its index.
    pub fn find(&self, reference: u32) -> Option<(usize, &Variable)> {
        self.variables.iter().enumerate().find(|(_, variable)| variable.reference == reference)
    }

    /// 1-based indices of the inputs that an output depends on.
    pub fn dependencies(&self, output: &Output) -> Vec<usize> {
        let depends = |input: usize| match output.feedthrough {
            Feedthrough::None => false,
            Feedthrough::Friction(Side::Left) => input == LEFT_FRICTION,
            Feedthrough::Friction(Side::Right) => input == RIGHT_FRICTION,
            Feedthrough::BothFrictions => input == LEFT_FRICTION || input == RIGHT_FRICTION,
            Feedthrough::All => true,
        };
        let indexed = self.variables.iter().enumerate();
        indexed.filter_map(|(index, variable)| matches!(variable.role, Role::Input(input) if depends(input)).then_some(index + 1)).collect()
    }
}

fn inputs(scene: &Scene) -> Vec<Variable> {
    let wheelset = &scene.vehicle.wheelset.name;
    let rows = [
        (1, "drive_torque", "driveTorque", Unit::NewtonMetre, None, DRIVE_TORQUE, "torque about the axle, positive drives forward"),
        (2, "centre_forces", "lateralForceInput", Unit::Newton, None, LATERAL_FORCE, "external lateral force on the centre, left positive"),
        (3, "centre_forces", "verticalForceInput", Unit::Newton, None, VERTICAL_FORCE, "external vertical force on the centre, up positive"),
        (4, "friction", "left.frictionFactor", Unit::One, Some(0.0), LEFT_FRICTION, "factor on the friction coefficient at the left wheel"),
        (5, "friction", "right.frictionFactor", Unit::One, Some(0.0), RIGHT_FRICTION, "factor on the friction coefficient at the right wheel"),
    ];
    let shown = rows.into_iter().filter(|row| scene.interface.inputs.contains(&row.1));
    shown
        .map(|(id, _, name, unit, min, input, text)| Variable {
            reference: WHEELSET + id,
            name: format!("{wheelset}.{name}"),
            description: text.into(),
            kind: Kind::Real,
            causality: "input",
            variability: "continuous",
            initial: None,
            unit,
            start: Some(NEUTRAL_INPUTS[input]),
            min,
            max: None,
            role: Role::Input(input_index(0, input)),
        })
        .collect()
}

/// One row of the parameter table.
struct Row {
    id: u32,
    group: &'static str,
    name: String,
    unit: Unit,
    min: Option<f64>,
    max: Option<f64>,
    text: &'static str,
    index: usize,
    get: fn(&Scene, usize) -> f64,
    set: fn(&mut Scene, usize, f64),
}

macro_rules! row {
    ($id:expr, $group:literal, $name:expr, $unit:ident, $min:expr, $max:expr, $text:literal, $($field:ident).+) => {
        Row { id: $id, group: $group, name: $name.into(), unit: Unit::$unit, min: $min, max: $max, text: $text, index: 0,
              get: |scene, _| scene.$($field).+, set: |scene, _, value| scene.$($field).+ = value }
    };
}

/// A field of the suspension; absent suspensions have no such parameter.
macro_rules! suspension_row {
    ($id:expr, $name:expr, $unit:ident, $text:literal, $field:ident) => {
        Row {
            id: $id,
            group: "suspension",
            name: $name,
            unit: Unit::$unit,
            min: Some(0.0),
            max: None,
            text: $text,
            index: 0,
            get: |scene, _| scene.vehicle.suspension.as_ref().map_or(0.0, |s| s.$field),
            set: |scene, _, value| {
                if let Some(suspension) = scene.vehicle.suspension.as_mut() {
                    suspension.$field = value;
                }
            },
        }
    };
}

/// Parameters below these bounds make no physical sense or no number.
const SMALLEST: Option<f64> = Some(1e-6);

fn parameters(scene: &Scene) -> Vec<Variable> {
    let w = &scene.vehicle.wheelset.name;
    let mut rows = vec![
        row!(1, "vehicle", "speed", TravelSpeed, None, None, "imposed travelling speed of the centre, forward positive; not 0", vehicle.speed),
        row!(2, "vehicle", "gravity", MetrePerSecond2, Some(0.0), None, "gravitational acceleration", vehicle.gravity),
        row!(3, "contact", "contact.friction", One, Some(0.0), None, "friction coefficient mu", contact.friction),
        row!(4, "contact", "contact.damping", NewtonSecondPerMetre2, Some(0.0), None, "C in N = K_h delta^1.5 + C delta d(delta)/dt", contact.damping),
        row!(5, "contact", "contact.youngsModulus", Pascal, Some(1e6), None, "Young's modulus of wheel and rail", contact.material.youngs_modulus),
        row!(6, "contact", "contact.poissonRatio", One, Some(0.0), Some(0.5), "Poisson's ratio of wheel and rail", contact.material.poisson_ratio),
        row!(WHEELSET + 400, "vehicle", format!("{w}.mass"), Kilogram, SMALLEST, None, "mass of the wheelset", vehicle.wheelset.mass),
        row!(WHEELSET + 401, "vehicle", format!("{w}.transverseInertia"), KilogramMetre2, SMALLEST, None, "moment of inertia about any axis across the axle (Ixx = Izz)", vehicle.wheelset.transverse_inertia),
        row!(WHEELSET + 402, "vehicle", format!("{w}.axialInertia"), KilogramMetre2, SMALLEST, None, "moment of inertia about the axle (Iyy)", vehicle.wheelset.axial_inertia),
        row!(WHEELSET + 403, "vehicle", format!("{w}.verticalLoad"), Newton, None, None, "constant vertical force on the centre, down positive; adds no mass", vehicle.wheelset.vertical_load),
    ];
    if let Some(suspension) = &scene.vehicle.suspension {
        let name = |field: &str| format!("{w}.suspension.{field}");
        if suspension.longitudinal {
            rows.push(suspension_row!(WHEELSET + 410, name("longitudinalStiffness"), NewtonPerMetre, "stiffness of each longitudinal element", longitudinal_stiffness));
            rows.push(suspension_row!(WHEELSET + 411, name("longitudinalDamping"), NewtonSecondPerMetre, "damping of each longitudinal element", longitudinal_damping));
        }
        if suspension.lateral {
            rows.push(suspension_row!(WHEELSET + 412, name("lateralStiffness"), NewtonPerMetre, "stiffness of each lateral element", lateral_stiffness));
            rows.push(suspension_row!(WHEELSET + 413, name("lateralDamping"), NewtonSecondPerMetre, "damping of each lateral element", lateral_damping));
        }
    }
    rows.push(solver_row(scene));
    rows.extend(initial_rows(w));
    let mut variables: Vec<Variable> = rows
        .into_iter()
        .filter(|row| scene.interface.parameters.contains(&row.group))
        .map(|row| {
            let parameter = RealParameter { get: row.get, set: row.set, index: row.index };
            Variable {
                reference: row.id,
                name: row.name,
                description: row.text.into(),
                kind: Kind::Real,
                causality: "parameter",
                variability: "fixed",
                initial: Some("exact"),
                unit: row.unit,
                start: Some(parameter.value(scene)),
                min: row.min,
                max: row.max,
                role: Role::RealParameter(parameter),
            }
        })
        .collect();
    if scene.interface.parameters.contains(&"initial") {
        variables.push(Variable {
            reference: WHEELSET + 460,
            name: format!("{w}.initial.fromEquilibrium"),
            description: "true: the steady rolling equilibrium for the parameters then set (no inputs acting) is found on leaving initialization mode and initial.* are added to it; false: initial.* are absolute".into(),
            kind: Kind::Boolean,
            causality: "parameter",
            variability: "fixed",
            initial: Some("exact"),
            unit: Unit::One,
            start: Some(f64::from(u8::from(scene.vehicle.initial.from_equilibrium))),
            min: None,
            max: None,
            role: Role::FromEquilibrium,
        });
    }
    variables
}

fn solver_row(scene: &Scene) -> Row {
    match scene.solver.integrator {
        Integrator::DormandPrince { .. } => Row {
            id: 7,
            group: "solver",
            name: "solver.tolerance".into(),
            unit: Unit::Metre,
            min: Some(1e-14),
            max: Some(1e-3),
            text: "bound of the local error of positions (m) and angles (rad) per step; the tolerance of fmi2SetupExperiment overrides it",
            index: 0,
            get: |scene, _| match scene.solver.integrator {
                Integrator::DormandPrince { tolerance } => tolerance,
                Integrator::RungeKutta4 { step } => step,
            },
            set: |scene, _, value| scene.solver.integrator = Integrator::DormandPrince { tolerance: value },
        },
        Integrator::RungeKutta4 { .. } => Row {
            id: 8,
            group: "solver",
            name: "solver.step".into(),
            unit: Unit::Second,
            min: Some(1e-9),
            max: Some(1.0),
            text: "fixed step of the integrator",
            index: 0,
            get: |scene, _| match scene.solver.integrator {
                Integrator::DormandPrince { tolerance } => tolerance,
                Integrator::RungeKutta4 { step } => step,
            },
            set: |scene, _, value| scene.solver.integrator = Integrator::RungeKutta4 { step: value },
        },
    }
}

/// `roll_rate` as `rollRate`.
fn camel_case(name: &str) -> String {
    let mut words = name.split('_');
    let first = words.next().unwrap_or_default().to_string();
    words.fold(first, |mut text, word| {
        let mut letters = word.chars();
        text.extend(letters.next().map(|letter| letter.to_ascii_uppercase()));
        text.push_str(letters.as_str());
        text
    })
}

fn initial_rows(w: &str) -> Vec<Row> {
    let units = [
        Unit::Distance,
        Unit::Metre,
        Unit::Metre,
        Unit::Radian,
        Unit::Radian,
        Unit::MetrePerSecond,
        Unit::MetrePerSecond,
        Unit::RadianPerSecond,
        Unit::RadianPerSecond,
        Unit::RadianPerSecond,
    ];
    INITIAL
        .iter()
        .zip(units)
        .enumerate()
        .map(|(index, ((name, _), unit))| Row {
            id: WHEELSET + 450 + index as u32,
            group: "initial",
            name: format!("{w}.initial.{}", camel_case(name)),
            unit,
            min: None,
            max: None,
            text: "initial value: added to the steady rolling equilibrium when initial.fromEquilibrium is true, else absolute",
            index,
            get: |scene, index| scene.vehicle.initial.values[index],
            set: |scene, index, value| scene.vehicle.initial.values[index] = value,
        })
        .collect()
}

fn locals() -> Vec<Variable> {
    let counter = |reference, name: &str, text: &str, read: fn(&Statistics) -> u64| Variable {
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
    vec![
        counter(900, "solver.steps", "accepted steps of the integrator since the start", |s| s.steps),
        counter(901, "solver.rejectedSteps", "rejected attempts", |s| s.rejected),
        counter(902, "solver.evaluations", "evaluations of the right-hand side", |s| s.evaluations),
        counter(903, "solver.restarts", "restarts at changes of inputs", |s| s.restarts),
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
    ]
}
