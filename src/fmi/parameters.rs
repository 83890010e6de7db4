//! The table of parameters: fields of the scene that a master may set before initialization ends, and during the run those that are tunable.
//!
//! Each kind of part has one table of [`Constant`]s: number, name, unit, bounds, description, and where its value is read and written in the
//! scene. Force elements bring theirs along. References: of the scene 1 to 99, of wheelset k (from 1) 1000 k + number, of a wheelset's own springs
//! 1000 k + 410, of body b 1000000 + 100 b + number, of force element f 2000000 + 100 f + 50, of sensor s 3000000 + 100 s + number (from 0).

use super::real_parameter::RealParameter;
use super::variable::{Kind, Role, TUNABLE, Variable, WHEELSET};
use crate::formulation::flexibility::Flexibility;
use crate::formulation::travelling_track::{DAMPINGS, MASSES, STIFFNESSES, Support};
use crate::mbs::inertia::Inertia;
use crate::scene::spec::{SMALLEST, SMALLEST_MODULUS, Scene};
use crate::scene::vehicle::extent::Away;
use crate::scene::vehicle::{FASTEST, LARGEST_ANGLE, PlacedBody, PlacedWheelset, Sensor};
use crate::settings::{Constant, Number, constant};
use crate::sim::vehicle_outputs::{BODY, FORCE, SENSOR, STRIDE};
use crate::solve::SettingKind;
use crate::units::Unit;

const VEHICLE: [Constant<Scene>; 2] = [
    Constant {
        get: |scene| scene.vehicle.keeps_speed().then_some(scene.vehicle.speed),
        ..constant!(
            1,
            "speed",
            TravelSpeed,
            Some(-FASTEST),
            "imposed travelling speed of the centre, forward positive; not 0",
            vehicle.speed
        )
    },
    constant!(2, "gravity", MetrePerSecond2, Some(0.0), "gravitational acceleration", vehicle.gravity),
];

/// Where the speed is only that of the start it may be 0.
const FREE_SPEED: Constant<Scene> =
    constant!(1, "speed", TravelSpeed, Some(-FASTEST), "travelling speed of the centre at the start, forward positive", vehicle.speed);

const CONTACT: [Constant<Scene>; 4] = [
    constant!(tunable 3, "contact.friction", One, Some(0.0), "friction coefficient mu", contact.friction),
    Constant {
        get: |scene| (scene.contact.damping_law.name == "proportional").then_some(scene.contact.damping),
        ..constant!(tunable 4, "contact.damping", NewtonSecondPerMetre2, Some(0.0), "C in N = K_h delta^1.5 + C delta d(delta)/dt", contact.damping)
    },
    constant!(
        5,
        "contact.youngsModulus",
        Pascal,
        Some(SMALLEST_MODULUS),
        "Young's modulus of wheel and rail",
        contact.material.youngs_modulus
    ),
    constant!(6, "contact.poissonRatio", One, Some(0.0), "Poisson's ratio of wheel and rail", contact.material.poisson_ratio),
];

fn vertical(track: &mut Flexibility) -> Option<&mut Support> {
    track.vertical_mut()
}

fn lateral(track: &mut Flexibility) -> Option<&mut Support> {
    Some(track.lateral_mut())
}

macro_rules! support {
    ($number:literal, $name:literal, $unit:ident, $range:expr, $text:literal, $way:ident, $field:ident) => {
        constant!($number, $name, $unit, Some($range.0), $text, get: |scene| scene.track.flexibility.and_then(|mut track| Some($way(&mut track)?.$field)), set: |scene, value| {
            if let Some(way) = scene.track.flexibility.as_mut().and_then($way) {
                way.$field = value;
            }
        })
    };
}

/// Of track that gives way under each wheel, with the largest values.
const TRACK: [(Constant<Scene>, f64); 6] = [
    (support!(20, "track.verticalMass", Kilogram, MASSES, "mass of the track that goes down under a wheel", vertical, mass), MASSES.1),
    (
        support!(
            21,
            "track.verticalStiffness",
            NewtonPerMetre,
            STIFFNESSES,
            "vertical stiffness of the track under a wheel",
            vertical,
            stiffness
        ),
        STIFFNESSES.1,
    ),
    (
        support!(
            22,
            "track.verticalDamping",
            NewtonSecondPerMetre,
            DAMPINGS,
            "vertical damping of the track under a wheel",
            vertical,
            damping
        ),
        DAMPINGS.1,
    ),
    (support!(23, "track.lateralMass", Kilogram, MASSES, "mass of the track that goes sideways under a wheel", lateral, mass), MASSES.1),
    (
        support!(
            24,
            "track.lateralStiffness",
            NewtonPerMetre,
            STIFFNESSES,
            "lateral stiffness of the track under a wheel",
            lateral,
            stiffness
        ),
        STIFFNESSES.1,
    ),
    (
        support!(
            25,
            "track.lateralDamping",
            NewtonSecondPerMetre,
            DAMPINGS,
            "lateral damping of the track under a wheel",
            lateral,
            damping
        ),
        DAMPINGS.1,
    ),
];

/// Of the distance of a vehicle of several bodies.
const ORIGIN: Constant<Scene> = constant!(
    10,
    "initial.distance",
    Distance,
    None,
    "distance along the track of the vehicle's design origin at the start",
    vehicle.initial.values[0]
);

macro_rules! initial {
    ($number:literal, $name:literal, $unit:ident, $place:literal) => {
        constant!(
            $number,
            $name,
            $unit,
            None,
            "initial value: added to the steady rolling equilibrium when initial.fromEquilibrium is true, else absolute (z and pitchRate must be given then)",
            vehicle.initial.values[$place]
        )
    };
}

/// Of a lone wheelset, with that one's base.
const INITIAL: [Constant<Scene>; 10] = [
    initial!(450, "initial.distance", Distance, 0),
    initial!(451, "initial.y", Metre, 1),
    initial!(452, "initial.z", Metre, 2),
    initial!(453, "initial.roll", Radian, 3),
    initial!(454, "initial.yaw", Radian, 4),
    initial!(455, "initial.vy", MetrePerSecond, 5),
    initial!(456, "initial.vz", MetrePerSecond, 6),
    initial!(457, "initial.rollRate", RadianPerSecond, 7),
    initial!(458, "initial.yawRate", RadianPerSecond, 8),
    initial!(459, "initial.pitchRate", RadianPerSecond, 9),
];

/// Of a wheelset among other bodies.
const OFFSETS: [Constant<PlacedWheelset>; 2] = [
    constant!(451, "initial.y", Metre, None, "added to y of the steady state at the start", offset[0]),
    constant!(454, "initial.yaw", Radian, None, "added to the yaw of the steady state at the start", offset[1]),
];

const WHEELSETS: [Constant<PlacedWheelset>; 4] = [
    constant!(400, "mass", Kilogram, Some(SMALLEST), "mass of the wheelset", spec.mass),
    constant!(
        401,
        "transverseInertia",
        KilogramMetre2,
        Some(SMALLEST),
        "moment of inertia about any axis across the axle (Ixx = Izz)",
        spec.transverse_inertia
    ),
    constant!(402, "axialInertia", KilogramMetre2, Some(SMALLEST), "moment of inertia about the axle (Iyy)", spec.axial_inertia),
    constant!(
        403,
        "verticalLoad",
        Newton,
        None,
        "weight of what rests on the wheelset, down positive: plumb, with its centrifugal force and its inertia along the track",
        spec.vertical_load
    ),
];

macro_rules! inertia {
    ($number:literal, $name:literal, $axis:ident, $text:literal) => {
        Constant {
            number: $number,
            name: $name,
            unit: Unit::KilogramMetre2,
            least: Some(SMALLEST),
            tunable: false,
            description: $text,
            get: |placed: &PlacedBody| match &placed.body.inertia {
                Inertia::General { principal } => Some(principal.$axis),
                Inertia::Revolution { .. } | Inertia::NotGyroscopic { .. } => None,
            },
            set: |placed, value| {
                if let Inertia::General { principal } = &mut placed.body.inertia {
                    principal.$axis = value;
                }
            },
        }
    };
}

const BODIES: [Constant<PlacedBody>; 4] = [
    constant!(50, "mass", Kilogram, Some(SMALLEST), "mass of the body", body.mass),
    inertia!(51, "inertiaXx", x, "moment of inertia about the body's x axis"),
    inertia!(52, "inertiaYy", y, "moment of inertia about the body's y axis"),
    inertia!(53, "inertiaZz", z, "moment of inertia about the body's z axis"),
];

const SENSORS: [Constant<Sensor>; 3] = [
    constant!(50, "pointX", Distance, None, "place of the sensor along its body's x axis, from the centre of mass", point.x),
    constant!(51, "pointY", Distance, None, "place of the sensor along its body's y axis, from the centre of mass", point.y),
    constant!(52, "pointZ", Distance, None, "place of the sensor along its body's z axis, from the centre of mass", point.z),
];

const TOLERANCE: Constant<Scene> = Constant {
    number: 7,
    name: "solver.tolerance",
    unit: Unit::Metre,
    least: None,
    tunable: true,
    description: "bound of the local error of positions (m) and angles (rad) per step; a tolerance that the master sets up the run with overrides it (this variable then still reads as it was set)",
    get: |scene| Some(scene.solver.integrator.setting().value),
    set: |scene, value| scene.solver.integrator = scene.solver.integrator.with_setting(value),
};

const STEP: Constant<Scene> =
    Constant { number: 8, name: "solver.step", unit: Unit::Second, description: "fixed step of the integrator", ..TOLERANCE };

/// Numbers of force elements' constants behind those of what they report, and of wheelsets' own springs.
const ELEMENT: u32 = 50;
const SUSPENSION: u32 = 410;

/// Collects the variables of a scene.
struct Collector<'s> {
    scene: &'s Scene,
    variables: Vec<Variable>,
}

impl Collector<'_> {
    /// Adds a line where its group and part are shown; `part`: its name and the base of its references.
    fn add(&mut self, group: &'static str, part: Option<(&str, u32)>, number: &Number, role: RealParameter) {
        if self.cut(number.name) {
            return;
        }
        let (name, base) = match part {
            Some((part, base)) => (format!("{part}.{}", number.name), base),
            None => (number.name.to_string(), 0),
        };
        let shown = self.scene.interface.parameters.contains(&group);
        if !shown || part.is_some_and(|part| !self.scene.interface.shows(part.0)) {
            return;
        }
        let [min, max] = number.unit.bounds(number.least, None);
        self.variables.push(Variable {
            reference: base + number.number,
            name,
            description: number.description.into(),
            kind: Kind::Real,
            causality: "parameter",
            variability: if number.tunable { TUNABLE } else { "fixed" },
            initial: Some("exact"),
            unit: number.unit,
            start: Some(number.value),
            min,
            max,
            role: Role::RealParameter(role),
        });
    }

    /// Of a scene that `vehicle.detail` has cut guides hold what the whole vehicle has done: what changes that is no parameter.
    fn cut(&self, name: &str) -> bool {
        let resists = |away: &Away| name == "speed" && !away.kept_constant.is_empty();
        self.scene.vehicle.away().is_some_and(|away| ["gravity", "mass"].contains(&name) || resists(away))
    }

    /// Adds what a part has of a table.
    fn table<T>(
        &mut self,
        group: &'static str,
        part: Option<(&str, u32)>,
        (table, of): (&'static [Constant<T>], &T),
        role: impl Fn(&'static Constant<T>) -> RealParameter,
    ) {
        for line in table {
            for number in Constant::read(std::slice::from_ref(line), of) {
                self.add(group, part, &number, role(line));
            }
        }
    }

    fn of_scene(&mut self, group: &'static str, part: Option<(&str, u32)>, table: &'static [Constant<Scene>]) {
        self.table(group, part, (table, self.scene), RealParameter::Scene);
    }

    /// Largest value of a variable.
    fn bounded(&mut self, name: &str, greatest: f64) {
        if let Some(variable) = self.variables.iter_mut().find(|variable| variable.name == name) {
            variable.max = Some(greatest);
        }
    }

    /// Bounds of all angles that a wheelset may start with, as in a scene.
    fn turned_at_most(&mut self, angle: f64) {
        let angles = |variable: &&mut Variable| variable.unit == Unit::Radian && variable.name.contains(".initial.");
        for variable in self.variables.iter_mut().filter(angles) {
            (variable.min, variable.max) = (Some(-angle), Some(angle));
        }
    }

    fn forces(&mut self, own: bool) {
        let vehicle = &self.scene.vehicle;
        for (place, element) in vehicle.forces.iter().enumerate() {
            let name = element.0.name();
            let wheelset = vehicle.suspended_by(name);
            if wheelset.is_some() != own {
                continue;
            }
            let base = wheelset.map_or(FORCE + STRIDE * place as u32 + ELEMENT, |k| WHEELSET * (k as u32 + 1) + SUSPENSION);
            for number in element.0.constants() {
                self.add("suspension", Some((name, base)), &number, RealParameter::Force(place, number.number));
            }
        }
    }
}

/// All parameters of a scene.
pub(super) fn parameters(scene: &Scene) -> Vec<Variable> {
    let vehicle = &scene.vehicle;
    let lone = vehicle.is_lone();
    let mut all = Collector { scene, variables: Vec::new() };
    if !vehicle.speed_imposed {
        all.of_scene("vehicle", None, const { &[FREE_SPEED] });
    }
    all.of_scene("vehicle", None, &VEHICLE);
    all.bounded("speed", FASTEST);
    all.of_scene("contact", None, &CONTACT);
    all.bounded("contact.poissonRatio", 0.5);
    for (line, greatest) in const { &TRACK } {
        all.of_scene("track", None, std::slice::from_ref(line));
        all.bounded(line.name, *greatest);
    }
    let base = |place: usize| WHEELSET * (place as u32 + 1);
    for (place, wheelset) in vehicle.wheelsets.iter().enumerate() {
        let part = Some((wheelset.spec.name.as_str(), base(place)));
        let role = |line| RealParameter::Wheelset(place, line);
        all.table("vehicle", part, (&WHEELSETS, wheelset), role);
        if !lone {
            all.table("initial", part, (&OFFSETS, wheelset), role);
        }
    }
    let place_of = |first: u32, place: usize| first + STRIDE * place as u32;
    for (place, body) in vehicle.bodies.iter().enumerate() {
        let part = Some((body.body.name.as_str(), place_of(BODY, place)));
        all.table("vehicle", part, (&BODIES, body), |line| RealParameter::Body(place, line));
    }
    for (place, sensor) in vehicle.sensors.iter().enumerate() {
        let part = Some((sensor.name.as_str(), place_of(SENSOR, place)));
        all.table("vehicle", part, (&SENSORS, sensor), |line| RealParameter::Sensor(place, line));
    }
    if !lone {
        all.of_scene("initial", None, const { &[ORIGIN] });
    }
    all.forces(true);
    all.forces(false);
    let setting = scene.solver.integrator.setting();
    let line: &'static [Constant<Scene>] = if setting.kind == SettingKind::Tolerance { const { &[TOLERANCE] } } else { const { &[STEP] } };
    all.of_scene("solver", None, line);
    for variable in all.variables.iter_mut().filter(|variable| variable.name == line[0].name) {
        (variable.min, variable.max) = (Some(setting.range.0), Some(setting.range.1));
    }
    if lone {
        let name = vehicle.leading().name.as_str();
        all.of_scene("initial", Some((name, WHEELSET)), &INITIAL);
        if scene.interface.parameters.contains(&"initial") {
            all.variables.push(from_equilibrium(scene, name));
        }
    }
    all.turned_at_most(LARGEST_ANGLE);
    all.variables
}

fn from_equilibrium(scene: &Scene, wheelset: &str) -> Variable {
    Variable {
        reference: WHEELSET + 460,
        name: format!("{wheelset}.initial.fromEquilibrium"),
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
    }
}
