//! Books of energy (`formulation::energy`): they close, they are the integrals of the powers that are shown, and keeping them changes nothing.

use std::collections::BTreeMap;
use wheelrail::formulation::LATERAL_FORCE;
use wheelrail::scene::load;
use wheelrail::sim::Simulation;
use wheelrail::sim::recording::record;
use wheelrail::sim::vehicle_outputs::scene_outputs;

const GROUPS: &str =
    "interface.outputs=[\"motion\",\"wheels\",\"contacts\",\"forces\",\"suspension\",\"bodies\",\"adhesion\",\"power\",\"energy\"]";
const WITHOUT: &str = "interface.outputs=[\"motion\",\"wheels\",\"contacts\",\"forces\",\"suspension\",\"bodies\"]";

type Columns = BTreeMap<String, Vec<f64>>;

fn run(scene: &str, changes: &[&str], groups: &str, stop: f64, step: f64) -> Columns {
    let changes: Vec<String> = changes.iter().chain([&groups]).map(|change| (*change).to_string()).collect();
    let scene = load::open(scene, &changes).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = Simulation::new(&scene, 0.0).unwrap_or_else(|error| panic!("{error}"));
    let outputs = scene_outputs(&scene, simulation.model());
    let mut names: Vec<u32> = outputs.iter().map(|output| output.reference).collect();
    names.sort_unstable();
    assert!(names.windows(2).all(|pair| pair[0] != pair[1]), "two outputs have one number");
    let recording = record(&mut simulation, &outputs, stop, step, |_| ()).unwrap_or_else(|error| panic!("{error}"));
    recording.columns.iter().map(|(name, _)| (name.clone(), recording.column(name).unwrap())).collect()
}

fn example(name: &str) -> String {
    format!("{}/examples/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

/// Sum of the columns whose name ends so, at each row.
fn sum(columns: &Columns, end: &str) -> Vec<f64> {
    let mut total = vec![0.0; columns["time"].len()];
    for (_, values) in columns.iter().filter(|(name, _)| name.ends_with(end)) {
        total.iter_mut().zip(values).for_each(|(total, value)| *total += value);
    }
    total
}

/// What the books leave over at worst, and all that was exchanged, J.
fn left_over(columns: &Columns) -> [f64; 2] {
    let of = |ends: &[&str]| -> Vec<f64> {
        let parts: Vec<Vec<f64>> = ends.iter().map(|end| sum(columns, end)).collect();
        (0..parts[0].len()).map(|row| parts.iter().map(|part| part[row]).sum()).collect()
    };
    let stored = of(&["energy.kinetic", "energy.height", "energy.elements"]);
    let given = of(&[".inputWork", ".drivingWork", ".work", "energy.contactWork", "energy.guideWork"]);
    let taken = of(&[".frictionHeat", ".heat", "energy.suspensionHeat"]);
    let worst = (0..stored.len()).map(|row| (stored[row] - stored[0] - given[row] + taken[row]).abs()).fold(0.0, f64::max);
    [worst, given.iter().chain(&taken).fold(0.0_f64, |most, value| most.max(value.abs()))]
}

const FLAT: &str = "vehicle.wheelset.out_of_round=[{kind=\"flat\",wheel=\"left\",length=\"50 mm\",depth=\"0.2 mm\",at=\"115 deg\"}]";

/// Scenes with motors, brakes, an imposed speed, rigid contact, a curve; the share of what was exchanged that may be left over.
fn cases() -> Vec<(String, Vec<&'static str>, f64, f64)> {
    let speed = "vehicle.speed=20";
    vec![
        (example("driven_truck"), vec![], 5.0, 1e-3),
        (example("braked_coach"), vec![], 5.0, 1e-3),
        (example("braked_coach"), vec!["vehicle.speed=3"], 6.0, 1e-3),
        // An imposed speed makes V dF out of an error dF of a creep force: 7e-3 at the scene's 1e-5.
        ("vehicle_curve".into(), vec!["solver.tolerance=1e-7"], 4.0, 1e-3),
        ("wheelset_s1002".into(), vec![], 1.0, 1e-3),
        // A guide takes power only where gravity pulls down a grade.
        (example("driven_truck"), vec!["vehicle.detail=truck", "track.grade=0.01"], 5.0, 1e-3),
        (example("driven_truck"), vec!["vehicle.detail=wheelset"], 5.0, 1e-3),
        ("vehicle_equalised".into(), vec!["vehicle.detail=truck", "vehicle.travel=free"], 3.0, 1e-3),
        // Rails that give way under traction, wheels that turn for themselves, wheels that are not round.
        (example("driven_truck"), vec!["track.flexibility=travelling"], 3.0, 1e-3),
        (example("driven_truck"), vec!["track.flexibility=beam"], 0.5, 2e-3),
        (example("scenes/tram_independent_wheels"), vec!["solver.tolerance=1e-7"], 3.0, 1e-3),
        ("suspended_wheelset".into(), vec!["vehicle.travel=free", FLAT, "solver.integrator=dormand_prince"], 1.0, 1e-3),
        ("suspended_wheelset".into(), vec![speed, "contact.formulation=ECCF"], 1.0, 1e-3),
        ("suspended_wheelset".into(), vec![speed, "solver.integrator=dormand_prince"], 1.0, 1e-3),
    ]
}

/// Stored energy changes by what goes in and out.
#[test]
fn prop_the_books_of_energy_close() {
    for (scene, changes, stop, share) in cases() {
        let columns = run(&scene, &changes, GROUPS, stop, 0.01);
        let [worst, exchanged] = left_over(&columns);
        println!("{scene} {changes:?}: {worst:.3e} J of {exchanged:.3e} J, {:.1e}", worst / exchanged);
        assert!(exchanged > 1.0 && worst <= share * exchanged, "{scene} {changes:?}: {worst} J of {exchanged} J");
    }
}

/// A block presses toward the axle wherever the frame has moved: beside it the pressing force braked or drove the wheel (12 mm lower: 13 % of the brake's heat was in no book).
#[test]
fn prop_a_tread_brake_under_a_lowered_frame_brakes_with_its_torque() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/scenes/tread_brake.toml");
    for load in [-60e3, 60e3] {
        let scene = load::open(path, &[GROUPS.to_string()]).unwrap_or_else(|error| panic!("{error}"));
        let mut simulation = Simulation::new(&scene, 0.0).unwrap();
        let outputs = scene_outputs(&scene, simulation.model());
        // The block's force, then the load's along X, Y and Z.
        let vertical = simulation.model().first_element_input() + 3;
        simulation.set_input(vertical, load, 0.0, 0.0);
        let recording = record(&mut simulation, &outputs, 4.0, 0.01, |_| ()).unwrap();
        let columns: Columns = recording.columns.iter().map(|(name, _)| (name.clone(), recording.column(name).unwrap())).collect();
        let lowered = columns["frame.z"][400] - columns["frame.z"][0];
        let [worst, exchanged] = left_over(&columns);
        println!("{load}: frame {lowered:.4} m, {worst:.3e} J of {exchanged:.3e} J");
        assert!(lowered.abs() > 5e-3 && lowered * load > 0.0 && worst < 2e-3 * exchanged, "{worst} J of {exchanged} J");
    }
}

/// A block that is put on pushes its axle forward against the springs: what its cylinder does there is its work (a train that was braked at rest had 141 J in no book).
#[test]
fn prop_what_a_block_does_on_its_axle_is_in_the_books() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/scenes/tread_brake.toml");
    let scene = load::open(path, &[GROUPS.to_string(), "solver.tolerance=1e-8".into()]).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = Simulation::new(&scene, 0.0).unwrap();
    let outputs = scene_outputs(&scene, simulation.model());
    let block = simulation.model().first_element_input();
    simulation.set_input(block, 50e3, 0.0, 0.0);
    let recording = record(&mut simulation, &outputs, 1.0, 0.01, |_| ()).unwrap();
    let columns: Columns = recording.columns.iter().map(|(name, _)| (name.clone(), recording.column(name).unwrap())).collect();
    let work = sum(&columns, ".work").iter().fold(0.0, |most: f64, work| most.max(work.abs()));
    let [worst, exchanged] = left_over(&columns);
    println!("{worst:.3e} J of {exchanged:.3e} J, work of the block {work:.2} J");
    assert!(work > 10.0 && worst < 0.02 * work, "{worst} J, {work} J");
}

/// The other outputs are the same to the bit: the books' states have no part in the error control and act on nothing.
#[test]
fn prop_keeping_the_books_changes_nothing() {
    for (scene, changes, _, _) in cases() {
        let (kept, without) = (run(&scene, &changes, GROUPS, 0.5, 0.05), run(&scene, &changes, WITHOUT, 0.5, 0.05));
        for (name, values) in &without {
            let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&kept[name]), bits(values), "{scene}: {name}");
        }
    }
}

/// Works and heats under an input that moves each millisecond: with a force of 3 N the driving work of a wheelset was 73 J for 105, as an implicit step's stages lag.
#[test]
fn hard_works_hold_where_inputs_move() {
    let booked = |solver: &[&str]| {
        let changes: Vec<String> = solver.iter().chain([&GROUPS]).map(|change| (*change).to_string()).collect();
        let scene = load::open("wheelset_s1002", &changes).unwrap();
        let mut simulation = Simulation::new(&scene, 0.0).unwrap();
        let outputs = scene_outputs(&scene, simulation.model());
        for i in 0..1000 {
            let time = 1e-3 * f64::from(i);
            simulation.set_input(LATERAL_FORCE, 3.0 * (12.6 * time).sin(), 0.0, 0.0);
            simulation.advance(time + 1e-3).unwrap();
        }
        let snapshot = simulation.snapshot().unwrap();
        let value = |name: &str| outputs.iter().find(|output| output.name == name).unwrap().value(snapshot);
        ["wheelset.drivingWork", "wheelset.left.frictionHeat", "energy.contactWork"].map(value)
    };
    let right = booked(&["solver.integrator=dormand_prince", "solver.tolerance=1e-9"]);
    for method in ["rosenbrock", "imex"] {
        let found = booked(&[&format!("solver.integrator={method}"), "solver.tolerance=1e-5"]);
        println!("{method}: {found:?} J, right {right:?} J");
        let near = |k: usize, most: f64| (found[k] - right[k]).abs() < most * right[k].abs();
        assert!(near(0, 0.02) && near(1, 2e-3) && near(2, 0.05), "{method}: {found:?} J, right {right:?} J");
    }
}

/// Works and heats are the integrals of the powers that are shown.
#[test]
fn prop_works_are_integrals_of_powers() {
    let pairs = [
        (example("driven_truck"), "motor[1].power", "motor[1].work", 1.0),
        (example("driven_truck"), "resistance.power", "resistance.heat", -1.0),
        (example("driven_truck"), "wheelset[1].left.frictionPower", "wheelset[1].left.frictionHeat", 1.0),
        (example("braked_coach"), "brake[2].heatFlow", "brake[2].heat", 1.0),
        (example("braked_coach"), "power.suspension", "energy.suspensionHeat", 1.0),
    ];
    for (scene, power, work, sign) in pairs {
        let columns = run(&scene, &[], GROUPS, 1.0, 2e-4);
        let (time, power, work) = (&columns["time"], &columns[power], &columns[work]);
        let mut integral = 0.0;
        for row in 1..time.len() {
            integral += 0.5 * sign * (time[row] - time[row - 1]) * (power[row] + power[row - 1]);
        }
        let (found, size) = (work.last().unwrap(), power.iter().map(|power| power.abs()).sum::<f64>() * 2e-4);
        assert!((found - integral).abs() < 2e-3 * size, "{scene}: {found} J, integral of the power {integral} J");
    }
}

/// Adhesion that is used stays within what is there; on one place per wheel what is there is friction, and friction's power is its work per distance times the speed.
#[test]
fn prop_adhesion_and_friction_power_follow_from_forces() {
    let columns = run(&example("driven_truck"), &["contact.friction=0.3"], GROUPS, 2.0, 0.05);
    let at = |row: usize, name: &str| columns[&format!("wheelset[1].{name}")][row];
    let mut pressed = 0;
    for row in 0..columns["time"].len() {
        let of = |name: &str| at(row, name);
        let (mut used, mut load) = (0.0, 0.0);
        for side in ["left", "right"] {
            let of = |name: &str| of(&format!("{side}.{name}"));
            used += of("usedAdhesion") * of("verticalForce");
            load += of("verticalForce");
            assert!(of("usedAdhesion").abs() <= of("availableAdhesion"));
            let expected = 0.3 * of("normalForce") / of("verticalForce");
            assert!((of("availableAdhesion") - expected).abs() < 1e-12, "{} {expected}", of("availableAdhesion"));
            let power = of("frictionWork") * at(row, "vx");
            assert!((of("frictionPower") - power).abs() < 1e-9 * power.abs() + 1e-9, "{} {power}", of("frictionPower"));
            pressed += 1;
        }
        assert!((of("usedAdhesion") - used / load).abs() < 1e-12);
    }
    assert!(pressed > 50);
}
