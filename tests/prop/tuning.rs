//! Parameters that change during a run.

use crate::scene_keys::{open, unpacked};
use std::collections::BTreeSet;
use wheelrail::fmi::instance::{Instance, SavedState};
use wheelrail::fmi::package::{self, PackedScene};
use wheelrail::fmi::variables::{Role, Variable, VariableTable};
use wheelrail::scene::spec::Scene;
use wheelrail::sim::Simulation;
use wheelrail::sim::tuning::Tuning;
use wheelrail::sim::vehicle_outputs::scene_outputs;

const BUMP: &str = "track.deviation=[{rail=\"left\",direction=\"vertical\",shape=\"cosine\",amplitude=\"6 mm\",from=11.5,to=14.5}]";
/// For a wheelset at 40 m/s that goes on bearing on both rails: it is on it at 0.32 s.
const LOW: [&str; 2] = [
    "track.deviation=[{rail=\"left\",direction=\"vertical\",shape=\"cosine\",amplitude=\"0.4 mm\",from=11.5,to=14.5}]",
    "vehicle.initial.y=3 mm",
];

/// Bits of the state's slope and of all outputs now.
fn seen(simulation: &mut Simulation, scene: &Scene) -> Vec<u64> {
    let outputs = scene_outputs(scene, simulation.model());
    let snapshot = simulation.snapshot().unwrap();
    snapshot.dy.iter().copied().chain(outputs.iter().map(|output| output.value(snapshot))).map(f64::to_bits).collect()
}

/// Numbers that were tuned in a run make the same model as numbers that a scene was assembled with: from one state, the same forces to the bit
/// and, where the static wheel load is no matter of balance, the same way on. One of each kind of constant of each scene.
#[test]
fn equiv_a_tuned_model_is_that_of_a_scene_with_these_numbers() {
    let mut kinds = BTreeSet::new();
    let examples = ["braked_coach", "driven_truck"].map(|name| format!("{}/examples/{name}.toml", env!("CARGO_MANIFEST_DIR")));
    let cases: [(&str, &[&str]); 7] = [
        ("suspended_wheelset", &LOW),
        ("suspended_wheelset", &[LOW[0], LOW[1], "contact.formulation=ECCF"]),
        ("suspended_wheelset", &[LOW[0], LOW[1], "contact.formulation=ACCF"]),
        ("suspended_wheelset", &[LOW[0], LOW[1], "solver.integrator=zhai", "solver.step=0.5 ms"]),
        ("vehicle_manchester_1", &[BUMP]),
        (&examples[0], &[]),
        (&examples[1], &[BUMP]),
    ];
    for (name, changes) in cases {
        let scene = open(name, &[&["interface={}"], changes].concat()).unwrap();
        let mut tuned = Simulation::new(&scene, 0.0).unwrap();
        let lone = scene.vehicle.is_lone();
        tuned.advance(if lone { 0.32 } else { 0.22 }).unwrap();
        let state = tuned.state().clone();
        let none = Tuning { scene: &scene, integrator: &scene.solver.integrator, constants: &[] };
        let (mut effects, mut all, mut done) = (0, 0, BTreeSet::new());
        for variable in VariableTable::new(&scene).unwrap().variables.iter().filter(|variable| variable.is_tunable()) {
            let Role::RealParameter(parameter) = variable.role else { panic!("{}", variable.name) };
            if !done.insert(variable.description.clone()) {
                continue;
            }
            kinds.insert(variable.description.clone());
            let mut changed = scene.clone();
            let value = 0.8 * parameter.value(&scene) + if parameter.value(&scene) == 0.0 { 1.0 } else { 0.0 };
            parameter.assign(&mut changed, value);
            let mut other = Simulation::new(&changed, 0.0).unwrap();
            let own = Tuning { scene: &changed, integrator: &changed.solver.integrator, constants: &[] };
            assert!(other.restore(&state) && tuned.restore(&state), "{}", variable.name);
            // Both restart here.
            other.tune(&own);
            tuned.tune(&none);
            let before = seen(&mut tuned, &scene);
            assert!(tuned.restore(&state));
            let constants: Vec<(usize, u32, f64)> = variable.constant_of_force(value).into_iter().collect();
            tuned.tune(&Tuning { constants: &constants, ..own });
            let now = seen(&mut tuned, &changed);
            assert!(now == seen(&mut other, &changed), "{name}, {}", variable.name);
            if lone {
                tuned.advance(0.4).unwrap();
                other.advance(0.4).unwrap();
                assert!(tuned.state() == other.state(), "{name}, {}", variable.name);
            }
            all += 1;
            if now == before {
                println!("{name}: {} does not act at once", variable.name);
            }
            effects += usize::from(now != before);
            // Back to what it was: nothing is left behind.
            assert!(tuned.restore(&state));
            tuned.tune(&none);
            assert!(seen(&mut tuned, &scene) == before, "{name}, {}", variable.name);
        }
        println!("{name} {changes:?}: {effects} of {all} act at once");
        // The setting of the integrator is no force; a stop out of reach has none, and contact no damping where it is a constraint.
        assert!(effects + 6 >= all && effects >= 5, "{name}: {effects} of {all} act at once");
    }
    println!("{} kinds of constants", kinds.len());
    assert!(kinds.len() >= 25, "{kinds:#?}");
}

/// A spring that grows stiffer during a run is not hung up anew: its preload stays that which the balance of the start has found. (In a scene with
/// the other stiffness the springs would share the car otherwise, by a sixth of the load.)
#[test]
fn analytic_preloads_from_balance_stay() {
    let static_preload = "vehicle.module.truck.force[secondary].preload=static";
    let scene = open("vehicle_manchester_1", &["interface={}", static_preload]).unwrap();
    let mut simulation = Simulation::new(&scene, 0.0).unwrap();
    // Beside its position of rest, so that stiffness tells.
    simulation.advance(1.0).unwrap();
    let force = |simulation: &mut Simulation| -> f64 {
        let outputs = scene_outputs(&scene, simulation.model());
        let output = outputs.iter().find(|output| output.name == "truck[1].secondary.left.forceZ").unwrap();
        output.value(simulation.snapshot().unwrap())
    };
    let before = force(&mut simulation);
    let table = VariableTable::new(&scene).unwrap();
    let stiffness = table.variables.iter().find(|variable| variable.name == "truck[1].secondary.left.stiffnessZ").unwrap();
    let constants: Vec<(usize, u32, f64)> = stiffness.constant_of_force(2.0 * stiffness.start.unwrap()).into_iter().collect();
    simulation.tune(&Tuning { scene: &scene, integrator: &scene.solver.integrator, constants: &constants });
    let after = force(&mut simulation);
    println!("{before:.3} N, then {after:.3} N");
    assert!((before.abs() - 78480.0).abs() < 100.0 && before != after && (after / before - 1.0).abs() < 2e-3, "{before} {after}");
}

/// A host of one scene.
struct Host {
    packed: PackedScene,
    folder: tempfile::TempDir,
}

type Values<'a> = &'a [(&'a str, f64)];

impl Host {
    fn new(scene: &str, changes: &[&str]) -> Host {
        let packed = package::pack_scene(&open(scene, &[&["interface={}"], changes].concat()).unwrap()).unwrap();
        Host { folder: unpacked(&packed), packed }
    }

    fn variable(&self, name: &str) -> &Variable {
        self.packed.table.variables.iter().find(|variable| variable.name == name).unwrap_or_else(|| panic!("no {name}"))
    }

    fn blank(&self) -> Instance {
        Instance::new(self.folder.path(), &self.packed.description.guid).unwrap()
    }

    fn start(&self, values: Values) -> Instance {
        let mut instance = self.blank();
        instance.setup_experiment(None, 0.0, None).unwrap();
        self.set(&mut instance, values);
        instance.enter_initialization().unwrap();
        instance.exit_initialization().unwrap();
        instance
    }

    fn set(&self, instance: &mut Instance, values: Values) {
        let references: Vec<u32> = values.iter().map(|(name, _)| self.variable(name).reference).collect();
        instance.set_real(&references, &values.iter().map(|(_, value)| *value).collect::<Vec<f64>>()).unwrap();
        self.reads(instance, values);
    }

    fn reads(&self, instance: &mut Instance, values: Values) {
        for (name, value) in values {
            let mut found = [0.0];
            instance.get_real(&[self.variable(name).reference], &mut found).unwrap();
            assert_eq!(found[0], *value, "{name}");
        }
    }

    /// Runs on to `stop` [s] in steps of 10 ms; bits of all outputs after each.
    fn run(&self, instance: &mut Instance, stop: f64) -> Vec<u64> {
        let references: Vec<u32> = self.packed.table.outputs.iter().map(|output| output.reference).collect();
        let mut values = vec![0.0; references.len()];
        let mut rows = Vec::new();
        while instance.time() < stop - 1e-6 {
            let time = instance.time();
            instance.do_step(time, 0.01).unwrap();
            instance.get_real(&references, &mut values).unwrap();
            rows.extend(values.iter().map(|value| value.to_bits()));
        }
        rows
    }

    fn through_bytes(&self, instance: &Instance) -> SavedState {
        let bytes = instance.serialize(&instance.save()).unwrap();
        let state = self.blank().deserialize(&bytes).unwrap();
        assert_eq!(instance.serialize(&state).unwrap(), bytes);
        state
    }
}

/// What is tuned in the middle of a run: the run is that of another instance which takes up the saved state and gets the same values; going back
/// across the change brings the old values, going forward again the new ones, all bit for bit.
#[test]
fn equiv_a_run_tuned_midway_is_the_run_from_its_saved_state() {
    let coach = format!("{}/examples/braked_coach.toml", env!("CARGO_MANIFEST_DIR"));
    let wheelset: Values =
        &[("contact.friction", 0.2), ("contact.damping", 5e4), ("wheelset.suspension.lateralStiffness", 6e4), ("solver.tolerance", 1e-7)];
    let wheelset_old: Values = &[("contact.friction", 0.5), ("wheelset.mass", 1568.0)];
    let brakes: Values = &[
        ("brake[1].stiffness", 4e6),
        ("brake[2].dampingTime", 0.01),
        ("truck[1].secondary.left.stiffnessZ", 4e5),
        ("resistance.rolling", 9e3),
    ];
    let brakes_old: Values = &[("brake[1].stiffness", 6e6), ("resistance.rolling", 600.0)];
    let lone = |changes: &'static [&'static str]| ("suspended_wheelset", changes, wheelset, wheelset_old);
    let cases =
        [lone(&[]), lone(&["contact.formulation=ECCF"]), lone(&["solver.integrator=rosenbrock"]), (&coach, &[], brakes, brakes_old)];
    for (scene, changes, new, old) in cases {
        let host = Host::new(scene, changes);
        let mut plain = host.start(&[]);
        host.run(&mut plain, 0.3);
        let untouched = host.run(&mut plain, 0.5);

        let mut first = host.start(&[]);
        host.run(&mut first, 0.3);
        let before = host.through_bytes(&first);
        host.set(&mut first, new);
        let head = host.run(&mut first, 0.4);
        let within = host.through_bytes(&first);
        let tail = host.run(&mut first, 0.5);
        assert!(untouched != [&head[..], &tail].concat(), "{scene}: the change must show");

        // Another instance, with other parameters of its own, takes up either state.
        let mut second = host.start(&[("contact.friction", 0.25), ("initial.distance", 1.0)].map(|(name, value)| {
            if name == "initial.distance" && scene == "suspended_wheelset" { ("wheelset.initial.distance", value) } else { (name, value) }
        }));
        host.run(&mut second, 0.05);
        host.set(&mut second, &[("contact.friction", 0.3)]);
        second.restore(&before).unwrap();
        host.reads(&mut second, old);
        // One by one or together, in any order.
        new.iter().rev().for_each(|value| host.set(&mut second, &[*value]));
        assert!(host.run(&mut second, 0.4) == head && host.run(&mut second, 0.5) == tail, "{scene}: tuned from the saved state");
        let mut third = host.blank();
        third.restore(&within).unwrap();
        host.reads(&mut third, new);
        assert!(host.run(&mut third, 0.5) == tail, "{scene}: a state of a tuned run");

        for _ in 0..2 {
            first.restore(&before).unwrap();
            host.reads(&mut first, old);
            assert!(host.run(&mut first, 0.5) == untouched, "{scene}: back across the change, and not made");
            first.restore(&within).unwrap();
            host.reads(&mut first, new);
            assert!(host.run(&mut first, 0.5) == tail, "{scene}: forward across it");
        }
        first.reset();
        host.reads(&mut first, old);
    }
}

/// What may not change during a run, and values that can't be: each is refused with a sentence, and the run is that without the attempt.
#[test]
fn prop_refused_values_leave_the_run_as_it_is() {
    let host = Host::new("vehicle_manchester_1", &[]);
    let mut plain = host.start(&[]);
    let expected = host.run(&mut plain, 0.1);
    let mut instance = host.start(&[]);
    let clearance =
        host.packed.table.variables.iter().find(|variable| variable.name.ends_with(".clearance")).map(|variable| variable.name.clone());
    let clearance = clearance.expect("a stop");
    let bad: [(&str, f64, &str); 8] = [
        ("contact.friction", -0.1, "the smallest value is 0"),
        ("contact.friction", f64::NAN, "finite"),
        ("truck[1].secondary.left.stiffnessZ", -1.0, "the smallest value is 0"),
        ("solver.tolerance", 1.0, "the largest value is"),
        (&clearance, 1e300, "the largest value is 10000000"),
        ("car.mass", 3e4, "fixed"),
        ("speed", 30.0, "fixed"),
        ("contact.youngsModulus", 1e11, "fixed"),
    ];
    for (name, value, words) in bad {
        let good = host.variable("truck[2].secondary.left.stiffnessX").reference;
        let error = instance.set_real(&[good, host.variable(name).reference], &[1.0, value]).unwrap_err().to_string();
        assert!(error.contains(words) && error.contains(name), "{error}");
        for name in [name, "truck[2].secondary.left.stiffnessX"] {
            host.reads(&mut instance, &[(name, host.variable(name).start.unwrap())]);
        }
    }
    // What it is already is no change.
    host.set(&mut instance, &[("contact.friction", host.variable("contact.friction").start.unwrap())]);
    assert!(host.run(&mut instance, 0.1) == expected);
    instance.terminate().unwrap();
    let error = instance.set_real(&[host.variable("contact.friction").reference], &[0.3]).unwrap_err().to_string();
    assert!(error.contains("after termination"), "{error}");
}

/// Masses, moments of inertia, places and the start stay; what says how a force follows from a motion may change.
#[test]
fn prop_what_is_tunable_is_no_mass_and_no_place() {
    let mut tunable = 0;
    for embedded in wheelrail::scene::embedded::SCENES {
        let scene = open(embedded.name, &["interface={}"]).unwrap();
        for variable in VariableTable::new(&scene).unwrap().variables {
            let last = variable.name.rsplit('.').next().unwrap_or_default();
            let fixed = [
                "mass",
                "nertia",
                "point",
                "place",
                "speed",
                "gravity",
                "youngsModulus",
                "poissonRatio",
                "verticalLoad",
                "ratio",
                "radius",
            ];
            let fixed = variable.name.contains("initial.") || fixed.iter().any(|word| last.contains(word));
            if matches!(variable.role, Role::RealParameter(_)) {
                assert_eq!(variable.is_tunable(), !fixed, "{}", variable.name);
                tunable += usize::from(!fixed);
            } else {
                assert!(!variable.is_tunable(), "{}", variable.name);
            }
        }
    }
    assert!(tunable > 500, "{tunable}");
}

/// The drive of a motor that grows stiffer during a run leaves its rotor the speed that it has.
#[test]
fn analytic_a_rotor_keeps_its_speed_when_its_drive_is_tuned() {
    let file = format!("{}/examples/driven_truck.toml", env!("CARGO_MANIFEST_DIR"));
    let scene = wheelrail::scene::load::open(&file, &[]).unwrap();
    let mut simulation = Simulation::new(&scene, 0.0).unwrap();
    simulation.advance(0.5).unwrap();
    let speed = |simulation: &mut Simulation| -> f64 {
        let outputs = scene_outputs(&scene, simulation.model());
        let output = outputs.iter().find(|output| output.name == "motor[1].motorSpeed").unwrap();
        output.value(simulation.snapshot().unwrap())
    };
    let before = speed(&mut simulation);
    let table = VariableTable::new(&scene).unwrap();
    let stiffness = table.variables.iter().find(|variable| variable.name == "motor[1].stiffness").unwrap();
    let constants: Vec<(usize, u32, f64)> = stiffness.constant_of_force(2.0 * stiffness.start.unwrap()).into_iter().collect();
    simulation.tune(&Tuning { scene: &scene, integrator: &scene.solver.integrator, constants: &constants });
    let after = speed(&mut simulation);
    println!("{before} rad/s, then {after} rad/s");
    assert!(before.abs() > 50.0 && (after / before - 1.0).abs() < 1e-9, "{before} {after}");
}
