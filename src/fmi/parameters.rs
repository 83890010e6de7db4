//! The table of parameters: fields of the scene that a master may set before initialization ends.

use super::variables::{Kind, Role, Variable, WHEELSET};
use super::vehicle_parameters;
use crate::scene::spec::{INITIAL, SMALLEST, SMALLEST_MODULUS, Scene};
use crate::scene::vehicle::FASTEST;
use crate::sim::unit::Unit;
use crate::solve::SettingKind;

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

/// One row of the parameter table.
pub(super) struct Row {
    pub id: u32,
    pub group: &'static str,
    pub name: String,
    pub unit: Unit,
    pub min: Option<f64>,
    pub max: Option<f64>,
    pub text: &'static str,
    /// Handed to `get` and `set`.
    pub index: usize,
    pub get: fn(&Scene, usize) -> f64,
    pub set: fn(&mut Scene, usize, f64),
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

/// All parameters of a scene.
pub(super) fn parameters(scene: &Scene) -> Vec<Variable> {
    let w = &scene.vehicle.wheelset.name;
    let mut speed = row!(
        1,
        "vehicle",
        "speed",
        TravelSpeed,
        Some(-FASTEST),
        Some(FASTEST),
        "imposed travelling speed of the centre, forward positive; not 0",
        vehicle.speed
    );
    // Where it is only that of the start it may be 0.
    if !scene.vehicle.speed_imposed {
        speed.text = "travelling speed of the centre at the start, forward positive";
    }
    let mut rows = vec![
        speed,
        row!(2, "vehicle", "gravity", MetrePerSecond2, Some(0.0), None, "gravitational acceleration", vehicle.gravity),
        row!(3, "contact", "contact.friction", One, Some(0.0), None, "friction coefficient mu", contact.friction),
        row!(
            4,
            "contact",
            "contact.damping",
            NewtonSecondPerMetre2,
            Some(0.0),
            None,
            "C in N = K_h delta^1.5 + C delta d(delta)/dt",
            contact.damping
        ),
        row!(
            5,
            "contact",
            "contact.youngsModulus",
            Pascal,
            Some(SMALLEST_MODULUS),
            None,
            "Young's modulus of wheel and rail",
            contact.material.youngs_modulus
        ),
        row!(
            6,
            "contact",
            "contact.poissonRatio",
            One,
            Some(0.0),
            Some(0.5),
            "Poisson's ratio of wheel and rail",
            contact.material.poisson_ratio
        ),
    ];
    match &scene.vehicle.free {
        None => rows.extend(wheelset_rows(w)),
        Some(free) => rows.extend(vehicle_parameters::rows(scene, free)),
    }
    if scene.contact.damping_law.name != "proportional" {
        rows.retain(|row| row.name != "contact.damping");
    }
    if let Some(suspension) = &scene.vehicle.suspension {
        let name = |field: &str| format!("{w}.suspension.{field}");
        if suspension.longitudinal {
            rows.push(suspension_row!(
                WHEELSET + 410,
                name("longitudinalStiffness"),
                NewtonPerMetre,
                "stiffness of each longitudinal element",
                longitudinal_stiffness
            ));
            rows.push(suspension_row!(
                WHEELSET + 411,
                name("longitudinalDamping"),
                NewtonSecondPerMetre,
                "damping of each longitudinal element",
                longitudinal_damping
            ));
        }
        if suspension.lateral {
            rows.push(suspension_row!(
                WHEELSET + 412,
                name("lateralStiffness"),
                NewtonPerMetre,
                "stiffness of each lateral element",
                lateral_stiffness
            ));
            rows.push(suspension_row!(
                WHEELSET + 413,
                name("lateralDamping"),
                NewtonSecondPerMetre,
                "damping of each lateral element",
                lateral_damping
            ));
        }
    }
    rows.push(solver_row(scene));
    if scene.vehicle.free.is_none() {
        rows.extend(initial_rows(w));
    }
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
    if scene.vehicle.free.is_none() && scene.interface.parameters.contains(&"initial") {
        variables.push(Variable {
            reference: WHEELSET + 460,
            name: format!("{w}.initial.fromEquilibrium"),
            description: "true: the steady rolling equilibrium for the parameters then set (no inputs acting) is found on leaving initialization mode and initial.* are added to it; false: initial.* are absolute, so at least z (about the wheel's radius) and pitchRate (speed over radius) must be set".into(),
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

/// The wheelset of the template `suspended_wheelset`.
fn wheelset_rows(w: &str) -> Vec<Row> {
    vec![
        row!(WHEELSET + 400, "vehicle", format!("{w}.mass"), Kilogram, Some(SMALLEST), None, "mass of the wheelset", vehicle.wheelset.mass),
        row!(
            WHEELSET + 401,
            "vehicle",
            format!("{w}.transverseInertia"),
            KilogramMetre2,
            Some(SMALLEST),
            None,
            "moment of inertia about any axis across the axle (Ixx = Izz)",
            vehicle.wheelset.transverse_inertia
        ),
        row!(
            WHEELSET + 402,
            "vehicle",
            format!("{w}.axialInertia"),
            KilogramMetre2,
            Some(SMALLEST),
            None,
            "moment of inertia about the axle (Iyy)",
            vehicle.wheelset.axial_inertia
        ),
        row!(
            WHEELSET + 403,
            "vehicle",
            format!("{w}.verticalLoad"),
            Newton,
            None,
            None,
            "weight of what rests on the wheelset, down positive: plumb, with its centrifugal force and its inertia along the track",
            vehicle.wheelset.vertical_load
        ),
    ]
}

/// The integrator's own number.
fn solver_row(scene: &Scene) -> Row {
    let setting = scene.solver.integrator.setting();
    let (id, name, unit, text) = match setting.kind {
        SettingKind::Tolerance => (
            7,
            "solver.tolerance",
            Unit::Metre,
            "bound of the local error of positions (m) and angles (rad) per step; the tolerance of fmi2SetupExperiment overrides it (this variable then still reads as it was set)",
        ),
        SettingKind::Step => (8, "solver.step", Unit::Second, "fixed step of the integrator"),
    };
    Row {
        id,
        group: "solver",
        name: name.into(),
        unit,
        min: Some(setting.range.0),
        max: Some(setting.range.1),
        text,
        index: 0,
        get: |scene, _| scene.solver.integrator.setting().value,
        set: |scene, _, value| scene.solver.integrator = scene.solver.integrator.with_setting(value),
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
            text: "initial value: added to the steady rolling equilibrium when initial.fromEquilibrium is true, else absolute (z and pitchRate must be given then)",
            index,
            get: |scene, index| scene.vehicle.initial.values[index],
            set: |scene, index, value| scene.vehicle.initial.values[index] = value,
        })
        .collect()
}
