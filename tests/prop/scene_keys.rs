//! Keys of scenes that stand for more than one thing, and what is said where numbers are allowed but perhaps not meant.

use crate::common;
use nalgebra::Vector3;
use std::collections::HashMap;
use std::sync::Arc;
use wheelrail::fmi::instance::Instance;
use wheelrail::fmi::package;
use wheelrail::fmi::variables::{Role, VariableTable};
use wheelrail::geometry::track::centre_line::{Alignment, CentreLine, Node};
use wheelrail::scene::spec::Scene;
use wheelrail::scene::{assemble, load, plan};
use wheelrail::sim::Simulation;
use wheelrail::sim::vehicle_outputs::scene_outputs;

pub fn open(name: &str, changes: &[&str]) -> Result<Scene, String> {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    load::open(name, &changes).map_err(|error| error.to_string())
}

/// The resources of an FMU in a folder of their own.
pub fn unpacked(packed: &package::PackedScene) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in &packed.resources {
        let file = folder.path().join(name);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(file, content).unwrap();
    }
    folder
}

fn error(name: &str, changes: &[&str]) -> String {
    let error = open(name, changes).err().unwrap_or_default();
    println!("{error}");
    error
}

fn notes(scene: &Scene) -> Vec<String> {
    let notes = plan::plan(scene, &assemble::model(scene).unwrap()).notes;
    println!("{notes:#?}");
    notes
}

#[test]
fn analytic_a_train_of_any_number_of_coaches() {
    for coaches in [1, 3, 5] {
        let count = format!("vehicle.place[coach].count={coaches}");
        let only = "interface.only=[\"coach[1].car\"]";
        let free = open("train", &[&count, only]).unwrap().vehicle;
        let names: Vec<&str> = free.forces.iter().map(|force| force.0.name()).filter(|name| name.starts_with("coupler")).collect();
        let expected: Vec<String> = (1..coaches).map(|n| format!("coupler[{n}]")).collect();
        assert_eq!((free.wheelsets.len(), names), (4 * coaches, expected.iter().map(String::as_str).collect()));
        for body in free.bodies.iter().filter(|body| body.body.name.ends_with(".car")) {
            let number: f64 = body.body.name.trim_start_matches("coach[").split(']').next().unwrap().parse().unwrap();
            assert_eq!(body.position, Vector3::new(-26.0 * (number - 1.0), 0.0, 1.8), "{}", body.body.name);
        }
    }
    // The couplers join the ends that meet: 1 m apart between points 12.5 m from the middle of each car.
    let (lone, pair) =
        (open("train", &["vehicle.place[coach].count=1", "interface.only=[\"coach[1]\"]"]).unwrap(), open("train", &[]).unwrap());
    let simulation = common::start(&pair);
    let model = simulation.model();
    let y = &simulation.state().integration.y;
    let mut workspace = model.workspace();
    model.system.apply_forces(y, &mut workspace.system);
    for element in model.system.forces.iter().filter(|element| element.name().starts_with("coupler")) {
        let (force, stretch) = (element.quantity(0, &workspace.system.moving(), &[]), element.quantity(1, &workspace.system.moving(), &[]));
        println!("{}: {force:.3e} N, elongation {stretch:.3e} m", element.name());
        assert!(force.abs() < 1e3 && stretch.abs() < 5e-3, "at rest within their slack");
    }
    let share = pair.vehicle.weight() / lone.vehicle.weight();
    assert!((share - 3.0).abs() < 1e-12, "{share}");
}

#[test]
fn hard_wrong_copies_are_refused() {
    let cases = [
        ("vehicle.place[coach].count=2.5", "vehicle.place[1].count: found 2.5, expected a whole number"),
        ("vehicle.place[coach].count=0", "expected a whole number from 1"),
        ("vehicle.place[coach].spacing=26", "vehicle.place[1].spacing"),
        ("vehicle.place[coach].name=\"coach[1]\"", "expected no number: count makes the numbers"),
    ];
    for (change, words) in cases {
        assert!(error("train", &[change]).contains(words), "{change}");
    }
    let bogie = [
        "vehicle.module.m.template=bogie",
        "vehicle.place[m].module=m",
        "vehicle.place[m].position=[5, 0, 0]",
        "vehicle.place[m].spacing=[1, 0, 0]",
    ];
    assert!(error("bogie", &bogie).contains("serves nothing without count"));
}

#[test]
fn hard_a_slip_of_the_pen_in_a_name_is_met_by_the_names_there_are() {
    let cases = [
        ("vehicle_manchester_1", "vehicle.body[cra].mass=30000", ["\"cra\" is a new entry that --set made", "vehicle.body had car"]),
        (
            "vehicle_manchester_1",
            "vehicle.module.truck.force[secondery].stiffness=[0, 1e5, 1e5]",
            ["did you mean \"secondary\"?", "traction_rod"],
        ),
        ("train", "vehicle.module.coach.body[cra].mass=30000", ["\"cra\" is a new entry", "had car"]),
        ("train", "vehicle.place[coahc].count=4", ["did you mean \"coach\"?", "vehicle.place had coach"]),
    ];
    for (scene, change, words) in cases {
        let error = error(scene, &[change]);
        assert!(words.iter().all(|words| error.contains(words)), "{change}: {error}");
    }
    // A new entry that is complete is one; so is a change of a template's entry.
    let sensor = ["vehicle.sensor[floor].body=car", "vehicle.sensor[floor].at=[0, 0, 1.8]"];
    assert!(open("bogie", &sensor).is_ok());
    assert!(!error("bogie", &["vehicle.body[car].mass=-3"]).contains("new entry"));
}

#[test]
fn hard_roundings_that_melt_corners_are_told() {
    let found = |smoothing: &str| notes(&open("vehicle_curve", &[&format!("track.smoothing={smoothing}")]).unwrap());
    let told = found("200 m");
    assert!(told.iter().any(|note| note.contains("track.smoothing = 200 m is longer than the stretch between the corners at")), "{told:?}");
    assert!(found("1 m").iter().all(|note| !note.contains("smoothing")));
}

#[test]
fn hard_dampers_faster_than_wheels_are_told() {
    let damper = [
        "vehicle.force[quick].kind=maxwell_damper",
        "vehicle.force[quick].from.body=car",
        "vehicle.force[quick].from.at=[0, 0, 1]",
        "vehicle.force[quick].to=frame",
        "vehicle.force[quick].at=[0, 0, 0.6]",
        "vehicle.force[quick].stiffness=1e8",
        "vehicle.force[quick].damping=1e4",
    ];
    let told = notes(&open("bogie", &damper).unwrap());
    let expected = "quick: time constant c/k = 0.100 ms; explicit integrators can't step further than 0.330 ms";
    assert!(told.iter().any(|note| note.starts_with(expected) && note.contains("1592 Hz")), "{told:?}");
    assert!(
        notes(&open("bogie", &[]).unwrap()).iter().all(|note| !note.contains("time constant")),
        "the coach's own dampers are slow enough"
    );
}

/// What an accelerometer on the floor of a car in a steady curve shows across: V^2 / R cos f - g sin f, f = cant + roll of the car.
#[test]
fn analytic_measured_acceleration_in_a_steady_curve() {
    let (speed, radius, height, g) = (25.0, 600.0, 0.1, 9.81);
    let sensor = ["vehicle.sensor[floor].body=car", "vehicle.sensor[floor].at=[0, 0, 1.8]", "vehicle.sensor[floor].measured=true"];
    let changes = [&sensor[..], &["vehicle.speed=25", "vehicle.drive=leading", "interface.outputs=[\"bodies\", \"sensors\"]"]].concat();
    let mut scene = open("vehicle_manchester_1", &changes).unwrap();
    let base = 2.0 * scene.track.half_rail_distance;
    let cant = (height / base).asin();
    let node = |distance: f64, share: f64| Node { distance, curvature: share / radius, superelevation: -share * cant, grade: 0.0 };
    let alignment = Alignment { nodes: vec![node(20.0, 0.0), node(70.0, 1.0)], smoothing: 10.0, ..Alignment::default() };
    scene.track.deviations.clear();
    scene.track.line = CentreLine::new(&alignment, Vector3::zeros(), 0.0).map(Arc::new);
    scene.track.alignment = Some(alignment);
    let mut simulation = common::start(&scene);
    let read = |simulation: &mut Simulation| -> HashMap<String, f64> {
        let outputs = scene_outputs(&scene, simulation.model());
        let snapshot = simulation.snapshot().unwrap();
        outputs.iter().map(|output| (output.name.clone(), output.value(snapshot))).collect()
    };
    let at_rest = read(&mut simulation);
    let shown = ["floor.measuredAx", "floor.measuredAy", "floor.measuredAz"].map(|name| at_rest[name]);
    println!("straight and level: {shown:?}, kinematic az {:.1e}", at_rest["floor.az"]);
    assert!((shown[2] - g * at_rest["car.pitch"].cos() * at_rest["car.roll"].cos()).abs() < 1e-6 && shown[1].abs() < 1e-6);
    simulation.advance(6.0).unwrap();
    let in_curve = read(&mut simulation);
    let lean = in_curve["car.roll"] - cant;
    let expected = speed * speed / radius * lean.cos() + g * lean.sin();
    let (shown, plain) = (in_curve["floor.measuredAy"], in_curve["floor.ay"]);
    println!("in the curve: {shown:.4} m/s2, formula {expected:.4}; kinematic {plain:.4}; roll {:.2e}", in_curve["car.roll"]);
    // What gravity adds is exact but for yaw and pitch; the car still swings a little.
    assert!((shown - plain - g * lean.sin()).abs() < 1e-4, "{}", shown - plain - g * lean.sin());
    assert!((shown - expected).abs() < 0.05, "{shown} {expected}");
}

/// A scene with several faults: all are told, each once, by line, what is missing last; a slip of the pen stands for the key that it hides.
#[test]
fn prop_all_faults_of_a_scene_are_told_at_once() {
    let embedded = wheelrail::scene::embedded::find("suspended_wheelset").unwrap().text;
    let found = |changes: &[(&str, &str)]| {
        let text = changes.iter().fold(embedded.to_string(), |text, (from, to)| {
            assert!(text.contains(from), "{from}");
            text.replacen(from, to, 1)
        });
        let source = wheelrail::settings::Source { file: "a.toml".into(), text, overridden: vec![], folder: None };
        let message = load::read("a", source, &[]).err().map(|error| error.to_string()).unwrap_or_default();
        println!("{message}\n");
        message
    };
    let places = |message: &str| -> Vec<String> {
        let lines = message.lines().filter_map(|line| line.trim_start().strip_prefix("a.toml:"));
        lines.map(|line| line.split(": ").nth(1).unwrap_or_default().to_string()).collect()
    };
    let many = found(&[
        ("\nspeed = ", "\nspeed = \"forty\" # "),
        ("\nmass = ", "\n# mass = "),
        ("\nlateral_damping = ", "\nlateral_dampig = "),
        ("\nformulation = \"ECF-A\"", "\nformulation = \"ecf-a\""),
        ("\nfriction = ", "\nfrction = "),
        ("\nstop = ", "\nstop = -"),
    ]);
    assert!(many.starts_with("6 faults in the scene:\n"), "{many}");
    let expected = [
        "vehicle.speed",
        "vehicle.suspension.lateral_dampig",
        "contact.formulation",
        "contact.frction",
        "run.stop",
        "vehicle.wheelset.mass",
    ];
    assert_eq!(places(&many), expected);
    for words in ["frction: unknown key (did you mean \"friction\"?)", "found \"ecf-a\" (did you mean \"ECF-A\"?)", "mass: is missing"] {
        assert!(many.contains(words), "{words}: {many}");
    }
    assert!(!many.contains("friction: is missing"), "{many}");
    // One fault is told as before.
    assert!(found(&[("\nfriction = ", "\nfrction = ")]).starts_with("a.toml:"));
    // What follows from a fault is not told: settings of a law that is not known, numbers that belong together, a table's own keys.
    assert_eq!(places(&found(&[("law = \"shen_hedrick_elkins\"", "law = \"fastsimm\"\nstrips = 10")])), ["contact.creep.law"]);
    assert_eq!(places(&found(&[("\ninertia_xx = ", "\ninertia_xx = \"x\" # ")])), ["vehicle.wheelset.inertia_xx"]);
    let renamed = found(&[("[contact]", "[contct]")]);
    assert!(renamed.contains("contact: is missing (there is \"contct\")") || renamed.contains("did you mean \"contact\"?"), "{renamed}");
    // A word that decides how the rest is read.
    let kind = error("bogie", &["vehicle.force[new].knd=spring_damper"]);
    assert!(kind.contains("kind: is missing (there is \"knd\")"), "{kind}");
}

#[test]
fn prop_faults_in_several_parts_of_a_vehicle() {
    let message = error(
        "bogie",
        &["vehicle.body[car].mass=-3", "vehicle.body[car].inertia_xx=\"1 KG M2\"", "vehicle.speed=1e6", "solver.tolerance=1"],
    );
    for words in [
        "4 faults in the scene:",
        "mass: found -3.0, expected 1e-6 or more",
        "(did you mean \"1 kg m2\"?)",
        "vehicle.speed: found 1000000.0 m/s, expected at most 500.0 m/s either way: contact is computed as at rest",
        "solver.tolerance: found 1.0",
    ] {
        assert!(message.contains(words), "{words}: {message}");
    }
    let spectrum = ["track.irregularity=[{kind=\"spectrum\",spectrum=\"FRA4\",seed=1}]"];
    assert!(error("suspended_wheelset", &spectrum).contains("(did you mean \"fra4\"?)"));
    assert!(error("suspended_wheelset", &["run.step=10"]).contains("run.step: found 10.0 s, expected at most run.stop = 5.0 s"));
}

/// What nobody knows may be left out, and the plan says what is taken instead.
#[test]
fn prop_defaults_for_what_nobody_knows() {
    let text = wheelrail::scene::embedded::find("suspended_wheelset").unwrap().text;
    let kept: String = text
        .lines()
        .take_while(|line| *line != "[solver]")
        .chain(text.lines().skip_while(|line| *line != "[run]"))
        .filter(|line| !["gravity", "damping"].iter().any(|key| line.starts_with(key)))
        .map(|line| format!("{line}\n"))
        .collect();
    let read = |text: &str, changes: &[&str]| {
        let source = wheelrail::settings::Source { file: "a.toml".into(), text: text.into(), overridden: vec![], folder: None };
        load::read("a", source, &changes.iter().map(|change| (*change).to_string()).collect::<Vec<_>>())
            .unwrap_or_else(|error| panic!("{error}"))
    };
    let scene = read(&kept, &[]);
    assert_eq!((scene.vehicle.gravity, scene.solver.name, scene.solver.integrator.setting().value), (9.81, "rosenbrock", 1e-5));
    let plan = plan::plan(&scene, &assemble::model(&scene).unwrap());
    let damping = plan.effects.iter().find(|effect| effect.name == "contact damping").unwrap();
    assert!(damping.why.contains("restitution 0.8 at 0.1 m/s"), "{}", damping.why);
    assert!(plan.notes.iter().any(|note| note.starts_with("solver.tolerance is 1e-5 m, the default")), "{:?}", plan.notes);
    // A step alone still asks for equal steps.
    assert_eq!(read(&kept, &["solver.step=1 ms"]).solver.name, "real_time");
    let mut simulation = common::start(&scene);
    simulation.advance(0.1).unwrap();
}

/// A file's initial values and flag mean what the FMU's mean: on a curve, where the balance is not at zero.
#[test]
fn equiv_initial_values_mean_the_same_in_a_file_and_in_the_fmu() {
    let curve = ["track.deviation=[]", "track.node=[{distance=0.0,radius=800.0,superelevation=\"50 mm\"}]"];
    let native = |changes: &[&str]| {
        let scene = open("suspended_wheelset", &[&curve[..], changes].concat()).unwrap();
        common::start(&scene).state().integration.y.clone()
    };
    let names = ["distance", "y", "z", "roll", "yaw", "vy", "vz", "rollRate", "yawRate", "pitchRate"];
    // Initial values as outputs of the FMU of a scene with `changes`, with parameters set; and what its parameters read.
    let fmu = |changes: &[&str], flag: Option<bool>, values: &[(&str, f64)]| -> (Vec<f64>, f64) {
        let packed = package::pack_scene(&open("suspended_wheelset", &[&curve[..], changes].concat()).unwrap()).unwrap();
        let folder = unpacked(&packed);
        let reference =
            |name: &str| packed.table.variables.iter().find(|variable| variable.name == format!("wheelset.{name}")).unwrap().reference;
        let mut instance = Instance::new(folder.path(), &packed.description.guid).unwrap();
        instance.setup_experiment(None, 0.0, None).unwrap();
        if let Some(flag) = flag {
            instance.set_boolean(&[reference("initial.fromEquilibrium")], &[flag]).unwrap();
        }
        for (name, value) in values {
            instance.set_real(&[reference(&format!("initial.{name}"))], &[*value]).unwrap();
        }
        instance.enter_initialization().unwrap();
        instance.exit_initialization().unwrap();
        let mut found = vec![0.0; names.len()];
        instance.get_real(&names.map(reference), &mut found).unwrap();
        let mut y = [0.0];
        instance.get_real(&[reference("initial.y")], &mut y).unwrap();
        (found, y[0])
    };
    let balance = fmu(&[], None, &[]).0;
    assert!(balance[1].abs() > 1e-5, "the curve moves the wheelset: {balance:?}");
    // Added to the balance, by default and where it is said.
    let given = ["vehicle.initial.y=1 mm", "vehicle.initial.yaw=0.5 mrad", "vehicle.initial.vz=0.01"];
    let set = [("y", 1e-3), ("yaw", 5e-4), ("vz", 0.01)];
    let from_file = fmu(&given, None, &[]);
    assert_eq!((from_file.0.clone(), from_file.1), fmu(&[], None, &set));
    assert_eq!(native(&given), native(&[&given[..], &["vehicle.initial.from_equilibrium=true"]].concat()));
    assert!((from_file.0[1] - balance[1] - 1e-3).abs() < 1e-12, "{from_file:?}");
    // Absolute.
    let absolute =
        ["vehicle.initial.from_equilibrium=false", "vehicle.initial.y=1 mm", "vehicle.initial.z=457 mm", "vehicle.initial.pitch_rate=87.5"];
    let from_file = fmu(&absolute, None, &[]).0;
    let all: Vec<(&str, f64)> = names.iter().copied().zip(from_file.iter().copied()).collect();
    let set = fmu(&[], Some(false), &all).0;
    // Coordinates go through the curve's frame and back.
    assert!(from_file.iter().zip(&set).all(|(a, b)| (a - b).abs() <= 1e-13 * a.abs().max(1.0)), "{from_file:?} {set:?}");
    assert!((from_file[1] - 1e-3).abs() < 1e-12 && (from_file[2] - 0.457).abs() < 1e-12, "{from_file:?}");
    // A radius is no offset.
    assert!(error("suspended_wheelset", &["vehicle.initial.z=0.467"]).contains("or from_equilibrium = false"));
}

/// Numbers without a unit that a reader of another habit means otherwise: degrees, per mille, millimetres.
#[test]
fn prop_numbers_that_may_mean_something_else_are_refused_with_both_spellings() {
    let node = |own: &str| format!("track.node=[{{distance=0, radius=600, {own}}}]");
    for (change, words) in [
        (node("superelevation=0.08"), ["\"80 mm\"", "\"0.08 rad\" (4.58 deg)"]),
        (node("cant=-0.08"), ["\"-80 mm\"", "\"-0.08 rad\""]),
        (node("superelevation=80"), ["\"80000 mm\"", "\"80.0 rad\""]),
        ("track.grade=3".into(), ["a slope (0.01, \"1 %\")", "\"0.5 deg\""]),
        ("vehicle.initial.yaw=1".into(), ["found 1.0 rad", "\"1.0 deg\""]),
        ("vehicle.initial.roll=-2".into(), ["found -2.0 rad", "\"-2.0 deg\""]),
    ] {
        let said = error("suspended_wheelset", &[change.as_str()]);
        assert!(words.iter().all(|word| said.contains(word)), "{change}: {said}");
    }
    let superelevation = |own: &str| open("suspended_wheelset", &[&node(own)]).unwrap().track.alignment.unwrap().nodes[0].superelevation;
    assert_eq!(superelevation("cant=\"-80 mm\""), superelevation("superelevation=\"-0.08 m\""));
    assert_eq!(superelevation("cant=\"3 deg\""), 3f64.to_radians());
    // The whole track's grade and a node's are read alike.
    for own in ["0.03", "\"3 %\"", "\"30 ‰\"", "\"1.5 deg\""] {
        let whole = open("suspended_wheelset", &[&format!("track.grade={own}")]).unwrap().track.grade;
        let node = open("suspended_wheelset", &[&format!("track.node=[{{distance=0, grade={own}}}]")]).unwrap().track.alignment.unwrap();
        assert_eq!(whole, node.nodes[0].grade, "{own}");
    }
}

/// One walk over the table of parameters: names and references are nobody else's, each reads what the scene says, and setting it changes that and
/// nothing else. Every part of every vehicle has some.
#[test]
fn prop_every_parameter_reads_and_writes_a_number_of_its_own() {
    for embedded in wheelrail::scene::embedded::SCENES {
        let scene = open(embedded.name, &["interface={}"]).unwrap();
        let variables = VariableTable::new(&scene).unwrap().variables;
        let mut names: Vec<&str> = variables.iter().map(|variable| variable.name.as_str()).collect();
        let mut references: Vec<u32> = variables.iter().map(|variable| variable.reference).collect();
        names.sort_unstable();
        references.sort_unstable();
        assert!(names.windows(2).all(|pair| pair[0] != pair[1]), "{}", embedded.name);
        assert!(references.windows(2).all(|pair| pair[0] != pair[1]), "{}", embedded.name);
        let parameters = variables.iter().filter_map(|variable| match variable.role {
            Role::RealParameter(parameter) => Some((variable, parameter)),
            _ => None,
        });
        let parameters: Vec<_> = parameters.collect();
        let values = |scene: &Scene| -> Vec<f64> { parameters.iter().map(|(_, parameter)| parameter.value(scene)).collect() };
        let start = values(&scene);
        for (place, (variable, parameter)) in parameters.iter().enumerate() {
            assert_eq!(variable.start, Some(start[place]), "{}", variable.name);
            assert!(variable.min.is_none_or(|min| start[place] >= min) && variable.max.is_none_or(|max| start[place] <= max));
            let least = variable.min.unwrap_or(f64::MIN);
            let value = (0.9 * start[place]).max(least) + if start[place] == 0.0 { 1e-3 } else { 0.0 };
            let mut changed = scene.clone();
            parameter.assign(&mut changed, value);
            let found = values(&changed);
            for (other, found) in found.iter().enumerate() {
                let wanted = if other == place { value } else { start[other] };
                assert_eq!(*found, wanted, "{}: {} changes {}", embedded.name, variable.name, parameters[other].0.name);
            }
        }
        for part in scene.vehicle.part_names() {
            let own = |name: &str| name.strip_prefix(part).is_some_and(|rest| rest.starts_with('.'));
            // What is a table of the scene alone has none.
            let any = parameters.iter().any(|(variable, _)| own(&variable.name));
            assert!(any, "{}: {part} has no parameter", embedded.name);
        }
    }
}

/// The numbers of track that gives way are the same as parameters of the FMU and as keys of the scene, to the last bit of a run; a scene with rigid track has none.
#[test]
fn equiv_parameters_of_track_are_those_of_the_scene_file() {
    let run = |track: &str, values: &[(&str, f64)]| -> Vec<u64> {
        let bump = "track.deviation=[{rail=\"both\",direction=\"vertical\",shape=\"cosine\",amplitude=\"2 mm\",from=2.0,to=4.0}]";
        let packed = package::pack_scene(&open("wheelset_s1002", &["interface={}", bump, track]).unwrap()).unwrap();
        let folder = unpacked(&packed);
        let named = |name: &str| packed.table.variables.iter().find(|variable| variable.name == name);
        let mut instance = Instance::new(folder.path(), &packed.description.guid).unwrap();
        instance.setup_experiment(None, 0.0, None).unwrap();
        for (name, value) in values {
            let variable = named(name).unwrap_or_else(|| panic!("no {name}"));
            assert_eq!((variable.causality, variable.variability), ("parameter", "fixed"));
            for bad in [variable.min.unwrap() - 1.0, variable.max.unwrap() * 2.0] {
                assert!(instance.set_real(&[variable.reference], &[bad]).is_err(), "{name} = {bad}");
            }
            instance.set_real(&[variable.reference], &[*value]).unwrap();
        }
        instance.enter_initialization().unwrap();
        instance.exit_initialization().unwrap();
        if let Some((name, _)) = values.first() {
            assert!(instance.set_real(&[named(name).unwrap().reference], &[2e7]).is_err(), "fixed during the run");
        }
        instance.do_step(0.0, 0.2).unwrap();
        let names = ["wheelset.z", "wheelset.y", "wheelset.left.verticalForce", "wheelset.right.lateralForce"];
        let mut found = [0.0; 4];
        instance.get_real(&names.map(|name| named(name).unwrap().reference), &mut found).unwrap();
        found.map(f64::to_bits).to_vec()
    };
    let plain = run("track.flexibility=travelling", &[]);
    for (key, name, value) in [
        ("vertical_stiffness", "track.verticalStiffness", 4e7),
        ("vertical_mass", "track.verticalMass", 300.0),
        ("vertical_damping", "track.verticalDamping", 3e4),
        ("lateral_stiffness", "track.lateralStiffness", 2e7),
        ("lateral_mass", "track.lateralMass", 100.0),
        ("lateral_damping", "track.lateralDamping", 4e4),
    ] {
        let scene = run(&format!("track.flexibility={{model=\"travelling\",{key}={value:?}}}"), &[]);
        assert_eq!(run("track.flexibility=travelling", &[(name, value)]), scene, "{name}");
        assert_ne!(scene, plain, "{name} changes nothing");
    }
    let rigid = package::pack_scene(&open("wheelset_s1002", &["interface={}"]).unwrap()).unwrap();
    assert!(rigid.table.variables.iter().all(|variable| !variable.name.starts_with("track.")));
}

/// A part's number is the same, to the last bit of a run, as parameter of the FMU and as key of the scene.
#[test]
fn equiv_parameters_of_elements_are_those_of_the_scene_file() {
    let run = |changes: &[&str], values: &[(&str, f64)]| -> Vec<u64> {
        let bump = "track.deviation=[{rail=\"both\",direction=\"vertical\",shape=\"cosine\",amplitude=\"5 mm\",from=11.5,to=13.5}]";
        let common = ["interface={}", "run.stop=0.1", "solver.tolerance=1e-5", bump];
        let packed = package::pack_scene(&open("vehicle_manchester_1", &[&common[..], changes].concat()).unwrap()).unwrap();
        let folder = unpacked(&packed);
        let reference = |name: &str| {
            let found = packed.table.variables.iter().find(|variable| variable.name == name);
            found.unwrap_or_else(|| panic!("no {name}")).reference
        };
        let mut instance = Instance::new(folder.path(), &packed.description.guid).unwrap();
        instance.setup_experiment(None, 0.0, None).unwrap();
        for (name, value) in values {
            instance.set_real(&[reference(name)], &[*value]).unwrap();
            let mut found = [0.0];
            instance.get_real(&[reference(name)], &mut found).unwrap();
            assert_eq!(found[0], *value, "{name}");
        }
        instance.enter_initialization().unwrap();
        instance.exit_initialization().unwrap();
        instance.do_step(0.0, 0.1).unwrap();
        let names = ["car.z", "truck[1].secondary.left.forceZ", "truck[2].traction_rod.force", "truck[1].wheelset[1].left.verticalForce"];
        let mut found = names.map(|_| 0.0);
        instance.get_real(&names.map(reference), &mut found).unwrap();
        found.map(f64::to_bits).to_vec()
    };
    let plain = run(&[], &[]);
    type Changed = (&'static [&'static str], &'static [(&'static str, f64)]);
    let cases: [Changed; 5] = [
        (
            &["vehicle.module.truck.force[secondary].stiffness=[170e3, 160e3, 400e3]"],
            &[
                ("truck[1].secondary.left.stiffnessX", 170e3),
                ("truck[1].secondary.right.stiffnessX", 170e3),
                ("truck[2].secondary.left.stiffnessX", 170e3),
                ("truck[2].secondary.right.stiffnessX", 170e3),
                ("truck[1].secondary.left.stiffnessZ", 400e3),
                ("truck[1].secondary.right.stiffnessZ", 400e3),
                ("truck[2].secondary.left.stiffnessZ", 400e3),
                ("truck[2].secondary.right.stiffnessZ", 400e3),
            ],
        ),
        (
            &["vehicle.module.truck.force[traction_rod].stiffness=4e6", "vehicle.module.truck.force[traction_rod].damping=2e4"],
            &[
                ("truck[1].traction_rod.stiffness", 4e6),
                ("truck[2].traction_rod.stiffness", 4e6),
                ("truck[1].traction_rod.damping", 2e4),
                ("truck[2].traction_rod.damping", 2e4),
            ],
        ),
        (
            &["vehicle.module.truck.force[secondary_vertical_damper].damping=3e4"],
            &[
                ("truck[1].secondary_vertical_damper.left.damping", 3e4),
                ("truck[1].secondary_vertical_damper.right.damping", 3e4),
                ("truck[2].secondary_vertical_damper.left.damping", 3e4),
                ("truck[2].secondary_vertical_damper.right.damping", 3e4),
            ],
        ),
        (&["vehicle.body[car].mass=33e3", "vehicle.body[car].inertia_yy=2e6"], &[("car.mass", 33e3), ("car.inertiaYy", 2e6)]),
        (
            &["vehicle.module.truck.force[anti_roll_bar].stiffness=9e5", "vehicle.initial.distance=2"],
            &[("truck[1].anti_roll_bar.stiffness", 9e5), ("truck[2].anti_roll_bar.stiffness", 9e5), ("initial.distance", 2.0)],
        ),
    ];
    for (changes, values) in cases {
        let found = run(&[], values);
        assert_eq!(found, run(changes, &[]), "{changes:?}");
        assert_ne!(found, plain, "{changes:?} changes nothing");
    }
}

/// The template of the suspended wheelset is a table like any other: the same vehicle in a scene's own words runs the same, bit for bit, and other
/// parts may stand beside it.
#[test]
fn equiv_suspended_wheelset_in_own_words() {
    use wheelrail::settings::Source;
    let text = wheelrail::scene::embedded::find("suspended_wheelset").unwrap().text;
    let read = |text: String, changes: &[&str]| {
        let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
        let source = Source { file: "s.toml".into(), text, overridden: vec![], folder: None };
        load::read("s", source, &changes).unwrap_or_else(|error| panic!("{error}"))
    };
    let run = |scene: &Scene| {
        let mut simulation = common::start(scene);
        simulation.advance(0.8).unwrap();
        simulation.solution()
    };
    let own = text
        .replace("template = \"suspended_wheelset\"", "template = \"free\"")
        .replace("[vehicle.wheelset]", "[[vehicle.wheelset]]\nname = \"axle\"\nx = 0.0\ndriven = true")
        .replace("[vehicle.suspension]", "[[vehicle.force]]\nname = \"springs\"\nkind = \"guided_spring\"\nbody = \"axle\"");
    let own = own.replace("[vehicle.wheelset.profile]", "[vehicle.wheel_profile]");
    // Tables of an array end where another one begins.
    let (head, profile) = own.split_at(own.find("[vehicle.wheel_profile]").unwrap());
    let (profile, rest) = profile.split_at(profile.find("[[vehicle.force]]").unwrap());
    let at = head.find("[[vehicle.wheelset]]").unwrap();
    let own = format!("{}{profile}\n{}\n{rest}", &head[..at], &head[at..]);
    let (shipped, own) = (read(text.to_string(), &[]), read(own, &[]));
    assert_eq!((own.vehicle.leading().name.as_str(), own.vehicle.forces[0].0.name()), ("axle", "springs"));
    assert_eq!(run(&shipped), run(&own));
    let sensor = "vehicle.sensor=[{name=\"box\",body=\"wheelset\",at=[0,1,0.457]}]";
    let (scene, mut simulation) = (read(text.to_string(), &[sensor]), common::start(&read(text.to_string(), &[sensor])));
    let outputs = scene_outputs(&scene, simulation.model());
    let snapshot = simulation.snapshot().unwrap();
    let value = |name: &str| outputs.iter().find(|output| output.name == name).unwrap().value(snapshot);
    assert_eq!(value("box.y") - value("wheelset.y"), 1.0);
}

/// A bag whose ends are the other way round would pull with its load, and so would one on the other side of the centre of mass from all that is carried: a car hung on air at 0.08 Hz, and runs ended "ok".
#[test]
fn hard_bags_that_would_have_to_pull_are_refused() {
    let scene = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/scenes/metro_r100.toml");
    let open = |changes: &[&str]| {
        let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
        wheelrail::scene::load::open(scene.to_str().unwrap(), &changes).err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert_eq!(open(&[]), "");
    let bag = "vehicle.module.truck.force[air_spring]";
    for changes in [&[&*format!("{bag}.from=car"), &format!("{bag}.to=frame")][..], &["vehicle.body[car].position=[9.0, 0.0, 1.6]"]] {
        let error = open(changes);
        assert!(error.contains("air_spring") && error.contains("would have to pull with"), "{error}");
    }
}
