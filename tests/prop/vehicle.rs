//! Free vehicles: loads, steady state, order, symmetry, balances.

use crate::common;
use crate::common::{run, start};
use std::collections::HashMap;
use wheelrail::formulation::Model;
use wheelrail::mbs::body::COORDINATES;
use wheelrail::scene::spec::Scene;
use wheelrail::scene::{load, plan};
use wheelrail::sim::Simulation;
use wheelrail::sim::vehicle_outputs::scene_outputs;

const G: f64 = 9.81;

fn scene(name: &str, changes: &[&str]) -> Scene {
    let changes: Vec<String> = common::EXACT.iter().chain(changes).map(|change| (*change).to_string()).collect();
    load::open(name, &changes).unwrap_or_else(|error| panic!("{error}"))
}

/// Behind the deviations of the embedded scenes.
const STRAIGHT: &str = "vehicle.initial.distance=150";

fn values(scene: &Scene, simulation: &mut Simulation) -> HashMap<String, f64> {
    let outputs = scene_outputs(scene, simulation.model());
    let snapshot = simulation.snapshot().unwrap();
    outputs.iter().map(|output| (output.name.clone(), output.value(snapshot))).collect()
}

#[test]
fn analytic_static_wheel_loads_follow_from_the_mass_table() {
    let bodies = 32000.0 + 2.0 * 2615.0 + 4.0 * 1813.0;
    let cases: [(&str, &[&str], f64); 3] = [
        ("bogie", &[], 0.0),
        ("vehicle_manchester_1", &[], 0.0),
        // The truck's share of the car moves with its centre.
        ("vehicle_manchester_1", &["vehicle.body[car].position=[0.95, 0, 1.8]"], 0.95),
    ];
    for (name, changes, shift) in cases {
        let scene = scene(name, &[&[STRAIGHT], changes].concat());
        let mut simulation = start(&scene);
        let found = values(&scene, &mut simulation);
        let shares = if name == "bogie" {
            vec![0.5 * bodies * G]
        } else {
            vec![1.0, -1.0].into_iter().map(|front: f64| 0.5 * bodies * G + front * 0.5 * 32000.0 * G * shift / 9.5).collect()
        };
        for (truck, share) in shares.iter().enumerate() {
            let prefix = if name == "bogie" { String::new() } else { format!("truck[{}].", truck + 1) };
            let q: Vec<f64> = ["wheelset[1].left", "wheelset[1].right", "wheelset[2].left", "wheelset[2].right"]
                .iter()
                .map(|wheel| found[&format!("{prefix}{wheel}.verticalForce")])
                .collect();
            let sum: f64 = q.iter().sum();
            println!("{name} {changes:?} truck {}: {q:.3?}, sum {sum:.3} N, mass table {share:.3} N", truck + 1);
            // The rods and the tilt of the car move a little load: the lever rule is exact for the design configuration.
            let bound = if shift == 0.0 { 1e-6 } else { 1e-2 };
            assert!((sum / share - 1.0).abs() < bound);
            assert!((q[0] - q[1]).abs() < 1e-5 * q[0] && (q[2] - q[3]).abs() < 1e-5 * q[2], "left and right alike");
        }
    }
}

/// Accelerations of all bodies at the steady state, by formulation.
#[test]
fn prop_steady_state_has_no_accelerations() {
    for name in ["bogie", "vehicle_manchester_1", "vehicle_equalised"] {
        for formulation in ["ECF-A", "ECF-N", "ECCF", "ACCF"] {
            let scene = scene(name, &[STRAIGHT, &format!("contact.formulation={formulation}")]);
            let mut simulation = start(&scene);
            let bodies = simulation.model().system.bodies.len();
            let snapshot = simulation.snapshot().unwrap();
            let largest = snapshot.dy[6 * bodies..12 * bodies].iter().fold(0.0f64, |most, a| most.max(a.abs()));
            println!("{name} {formulation}: largest acceleration {largest:.2e}");
            assert!(largest < 2e-5);
        }
    }
}

/// Frequencies of the 4-dof model (body bounce and pitch, two frames' bounce, wheelsets fixed, no damping) with the same
/// springs; solved as an eigenvalue problem by another program.
#[test]
fn validate_vertical_modes_of_the_manchester_coach() {
    let expected = [1.0739, 1.2991, 7.4705, 7.4772];
    // That model knows no springs along the track, which resist the car's pitch because they lie below its centre.
    let whole = start(&scene("vehicle_manchester_1", &[STRAIGHT]));
    let names = ["car", "truck[1].frame", "truck[2].frame"];
    println!("with springs along the track: {:?}", frequencies(whole.model(), whole.state().integration.y.clone(), &names));
    let vertical = [
        STRAIGHT,
        "vehicle.module.truck.force[traction_rod].stiffness=0",
        "vehicle.module.truck.force[secondary].stiffness=[0, 160e3, 430e3]",
    ];
    let simulation = start(&scene("vehicle_manchester_1", &vertical));
    let found = frequencies(simulation.model(), simulation.state().integration.y.clone(), &names);
    println!("{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 2e-3, "{found} Hz, expected {expected} Hz");
    }
}

/// Of the car's z and pitch and the frames' z, Hz.
fn frequencies(model: &Model, y: Vec<f64>, names: &[&str]) -> Vec<f64> {
    let system = &model.system;
    let body = |name: &str| system.bodies.iter().position(|body| body.name == name).unwrap();
    let mut places: Vec<usize> = names.iter().map(|name| COORDINATES * body(name) + 2).collect();
    places.push(COORDINATES * body(names[0]) + 5);
    let count = places.len();
    let mut workspace = system.workspace(&[]);
    let mut accelerations = |place: usize, h: f64| {
        let (mut moved, mut dy) = (y.clone(), vec![0.0; y.len()]);
        moved[place] += h;
        // At rest, with the states of series springs where they come to rest.
        system.settle_forces(&mut moved, &mut workspace);
        system.apply_forces(&moved, &mut workspace);
        system.constrained_derivative(0.0, &moved, &mut workspace, &mut dy).unwrap();
        places.iter().map(|other| dy[other + COORDINATES * system.bodies.len()]).collect::<Vec<f64>>()
    };
    const H: f64 = 1e-6;
    let columns: Vec<Vec<f64>> = places
        .iter()
        .map(|place| accelerations(*place, H).iter().zip(accelerations(*place, -H)).map(|(a, b)| (a - b) / (2.0 * H)).collect())
        .collect();
    let matrix = nalgebra::DMatrix::from_fn(count, count, |row, column| -columns[column][row]);
    let mut found: Vec<f64> = matrix.complex_eigenvalues().iter().map(|value| value.re.sqrt() / std::f64::consts::TAU).collect();
    found.sort_by(f64::total_cmp);
    found
}

#[test]
fn hard_a_body_without_support_is_named() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/fmu/scenes/bogie.toml")).unwrap();
    let read = |extra: &str| {
        let text = text.replace("[track]\n", &format!("{extra}\n[track]\n"));
        let source = wheelrail::settings::Source { file: "s.toml".into(), text, overridden: vec![], folder: None };
        load::read("s", source, &[])
    };
    let brick = "[[vehicle.body]]\nname = \"brick\"\nmass = 10\ninertia_xx = 1\ninertia_yy = 1\ninertia_zz = 1\nposition = [0, 0, 1]\n";
    let scene = read(brick).unwrap();
    let error = Simulation::new(&scene, 0.0).unwrap_err().to_string();
    println!("{error}");
    assert!(error.contains("nothing holds brick along z"), "{error}");
    for (extra, words) in [
        (
            "[[vehicle.force]]\nname = \"f\"\nkind = \"bushing\"\nfrom = \"fram\"\nto = \"car\"\nat = [0,0,1]\n",
            "s.toml:14: vehicle.force[1].from: found \"fram\" (did you mean \"frame\"?)",
        ),
        ("[[vehicle.force]]\nname = \"secondary\"\nstifness = 3\n", "unknown key (did you mean \"stiffness\"?)"),
        ("[[vehicle.body]]\nname = \"frame\"\nmass = -1\n", "s.toml:13: vehicle.body[1].mass: found -1.0, expected"),
        ("[[vehicle.place]]\nname = \"t\"\nmodule = \"truk\"\nposition = [0,0,0]\n", "expected the name of a module"),
        ("[[vehicle.body]]\nname = \"wheelset[1]\"\nmass = 1\n", "names something else already"),
    ] {
        let error = read(extra).err().map(|error| error.to_string()).unwrap_or_default();
        println!("{error}");
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn prop_the_order_of_entries_does_not_matter() {
    // The vehicle's tables of the template written into the scene, forward and backward.
    let template = wheelrail::scene::vehicle::templates::text("vehicle_manchester_1");
    let scene = wheelrail::scene::embedded::find("vehicle_manchester_1").unwrap().text;
    let tables: Vec<String> =
        template.split("\n\n").filter(|part| part.contains("[[")).map(|part| part.replace("[[", "[[vehicle.")).collect();
    let write = |tables: Vec<String>| {
        let profile = "[vehicle.wheel_profile]\nkind = \"s1002\"\nradius = 0.46\n";
        let text = scene
            .replace("template = \"vehicle_manchester_1\"", "template = \"free\"")
            .replace("[track]\n", &format!("{profile}\n{}\n\n[track]\n", tables.join("\n\n")));
        let source = wheelrail::settings::Source { file: "s.toml".into(), text, overridden: vec![], folder: None };
        let scene = load::read("s", source, &[]).unwrap_or_else(|error| panic!("{error}"));
        let recording = run_all(&scene, 0.3, 0.1);
        (recording, scene)
    };
    let (forward, _) = write(tables.clone());
    let (backward, _) = write(tables.into_iter().rev().collect());
    assert_eq!(forward, backward, "bit for bit");
    let embedded = run_all(&load::open("vehicle_manchester_1", &["vehicle.initial.distance=0".into()]).unwrap(), 0.3, 0.1);
    assert_eq!(forward, embedded, "as the template itself");
}

/// All outputs over time.
fn run_all(scene: &Scene, stop: f64, step: f64) -> Vec<Vec<f64>> {
    let mut simulation = start(scene);
    let outputs = scene_outputs(scene, simulation.model());
    wheelrail::sim::recording::record(&mut simulation, &outputs, stop, step, |_| {}).unwrap_or_else(|error| panic!("{error}")).rows
}

/// Newton's second law for the whole vehicle: inner forces cancel.
#[test]
fn prop_momentum_balance_of_the_coach() {
    let scene = scene("vehicle_manchester_1", &["solver.tolerance=1e-8"]);
    let mut simulation = start(&scene);
    for stop in [0.0, 0.4, 0.8, 1.2] {
        simulation.advance(stop).unwrap();
        let model = simulation.model();
        let bodies = model.system.bodies.clone();
        let snapshot = simulation.snapshot().unwrap();
        let reports = snapshot.workspace.contacts.iter().chain(&snapshot.workspace.further_contacts);
        let mut force: nalgebra::Vector3<f64> = reports.map(|report| report.force).sum();
        force.x += snapshot.workspace.system.drive_forces.iter().sum::<f64>();
        let mut change = nalgebra::Vector3::zeros();
        for (index, body) in bodies.iter().enumerate() {
            force.z -= body.mass * G;
            let v = 6 * (bodies.len() + index);
            change += body.mass * nalgebra::Vector3::new(snapshot.dy[v], snapshot.dy[v + 1], snapshot.dy[v + 2]);
        }
        println!("t = {stop}: forces {force:.3?}, mass times acceleration {change:.3?}");
        assert!((force - change).norm() < 1e-6 * 44000.0 * G);
    }
}

/// A scene turned left to right gives the turned motion.
#[test]
fn prop_mirrored_vehicle_moves_mirrored() {
    let motion = |sign: &str| {
        let changes = [
            STRAIGHT.to_string(),
            format!("vehicle.module.truck.wheelset[wheelset[1]].initial_y={sign}2 mm"),
            "solver.tolerance=1e-9".into(),
        ];
        let changes: Vec<&str> = changes.iter().map(String::as_str).collect();
        run(&scene("vehicle_manchester_1", &changes), 0.3, 0.05)
    };
    let (left, right) = (motion(""), motion("-"));
    for name in ["truck[1].wheelset[1].y", "truck[2].wheelset[2].yaw", "truck[1].wheelset[2].roll"] {
        let (a, b) = (left.column(name).unwrap(), right.column(name).unwrap());
        let (size, difference) = a.iter().zip(&b).fold((0.0f64, 0.0f64), |(s, d), (a, b)| (s.max(a.abs()), d.max((a + b).abs())));
        println!("{name}: largest {size:.3e}, sum of both {difference:.1e}");
        assert!(size > 1e-6 && difference < 1e-5 * size + 1e-12);
    }
}

/// With free travel the vehicle slows down by the rolling resistance of spin creepage alone; on a grade by that of its weight.
#[test]
fn analytic_free_travel_on_a_grade() {
    let slowing = |changes: &[&str]| {
        let scene = scene("bogie", &[&[STRAIGHT, "vehicle.travel=free"], changes].concat());
        let mut simulation = start(&scene);
        let model = simulation.model();
        let (bodies, dimension) = (model.system.bodies.len(), model.system.dimension());
        let dy = simulation.snapshot().unwrap().dy.clone();
        (0..bodies).map(|body| dy[6 * (bodies + body)]).collect::<Vec<f64>>().into_iter().chain([dimension as f64]).collect::<Vec<f64>>()
    };
    let (level, climbing) = (slowing(&[]), slowing(&["track.grade=0.01"]));
    println!("level: {level:?}, grade 0.01: {climbing:?}");
    for a in &level[..level.len() - 1] {
        assert!((a - level[0]).abs() < 1e-6 && a.abs() < 2e-3, "{a}");
    }
    // Wheels that turn more slowly, too, add their inertia: m + sum(I / r^2).
    let mass = 16000.0 + 2615.0 + 2.0 * 1813.0;
    let expected = -G * 0.01f64.sin() * mass / (mass + 2.0 * 112.0 / (0.46 * 0.46));
    for a in &climbing[..climbing.len() - 1] {
        assert!((a - level[0] - expected).abs() < 2e-3 * expected.abs(), "{a} {expected}");
    }
}

#[test]
fn prop_a_train_stands_on_its_mass_table() {
    // A train that its first wheelset pulls has 2 N less under that.
    let scene = scene("train", &[STRAIGHT, "vehicle.drive=all"]);
    let clock = std::time::Instant::now();
    let mut simulation = start(&scene);
    println!("steady state and start of three coaches: {:.2} s", clock.elapsed().as_secs_f64());
    let found = values(&scene, &mut simulation);
    let share = (32000.0 + 2.0 * 2615.0 + 4.0 * 1813.0) * G / 8.0;
    for wheel in ["coach[1].truck[1].wheelset[1].left", "coach[3].truck[2].wheelset[2].right"] {
        let q = found[&format!("{wheel}.verticalForce")];
        println!("{wheel}: {q:.3} N, mass table {share:.3} N");
        assert!((q / share - 1.0).abs() < 1e-5);
    }
    assert!(found.keys().all(|name| !name.starts_with("coach[2]")), "only what interface.only names");
}

/// A vehicle at rest, on springs, dampers and elastic contacts with friction, stays where it is.
#[test]
fn hard_a_standing_vehicle_stays() {
    let changes = [STRAIGHT, "vehicle.travel=free", "vehicle.speed=0", "contact.transient={ below = \"2 m/s\" }"];
    let scene = scene("bogie", &changes);
    let mut simulation = start(&scene);
    let before = simulation.state().integration.y.clone();
    simulation.advance(0.5).unwrap();
    let after = &simulation.state().integration.y;
    let bodies = simulation.model().system.bodies.len();
    let moved = before.iter().zip(after).take(6 * bodies).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("largest move in 0.5 s: {moved:.2e} m or rad");
    // Steady rolling and standstill differ a little in the deflections of the contacts.
    assert!(moved < 2e-5);
}

/// What contacts and imposed speeds bring in and dampers take out is the change of the vehicle's energy.
#[test]
fn prop_energy_balance_of_vehicles() {
    for name in ["vehicle_manchester_1", "vehicle_equalised"] {
        let scene = scene(name, &["solver.tolerance=1e-8"]);
        let mut simulation = start(&scene);
        for stop in [0.9, 1.3] {
            simulation.advance(stop).unwrap();
            let snapshot = simulation.snapshot().unwrap().clone();
            let (system, inner) = (&simulation.model().system, &snapshot.workspace.system);
            let contacts = snapshot.workspace.contacts.iter().chain(&snapshot.workspace.further_contacts);
            let brought: f64 = contacts
                .map(|report| {
                    let (force, slip) = (report.creep_force, report.slip);
                    force.longitudinal * slip.longitudinal + force.lateral * slip.lateral + force.spin_moment * slip.spin
                        - report.normal_force * report.penetration_rate
                })
                .sum();
            let driven = system.drives.iter().zip(&inner.drive_forces);
            let driven: f64 = driven.map(|(drive, force)| force * inner.motions[drive.body].velocity.x).sum();
            let heat = system.dissipated_power(&snapshot.y, inner);
            let mut workspace = system.workspace(&[]);
            let mut energy = |h: f64| {
                let y: Vec<f64> = snapshot.y.iter().zip(&snapshot.dy).map(|(y, dy)| y + h * dy).collect();
                system.move_bodies(&y, &mut workspace);
                system.kinetic_energy(&workspace.motions) + system.potential_energy(&y, &workspace.moving())
            };
            const H: f64 = 1e-4;
            let change = (energy(H) - energy(-H)) / (2.0 * H);
            println!("{name} t = {stop}: contacts {brought:.3} W, drives {driven:.3} W, dampers {heat:.3} W, change {change:.3} W");
            assert!((brought + driven - heat - change).abs() < 1e-3 * (heat + driven.abs()) + 0.05);
        }
    }
}

/// A start on a transition is refused; before it, one imposed speed leaves the traction rods alone where two strain them.
#[test]
fn hard_starts_on_transitions_are_refused_and_two_imposed_speeds_said() {
    let nodes = "track.node=[{distance=0.0},{distance=60.0,radius=150.0,superelevation=\"-0.1 m\"}]";
    let within = load::open("vehicle_manchester_1", &[nodes.into(), "vehicle.initial.distance=30".into()]).unwrap();
    let refused = Simulation::new(&within, 0.0).unwrap_err().to_string();
    assert!(refused.contains("starts on a transition") && refused.contains("start before it or behind it"), "{refused}");
    let words = |drive: &str| {
        let overrides = [nodes.to_string(), "vehicle.initial.distance=-20".into(), format!("vehicle.drive={drive}")];
        let scene = load::open("vehicle_manchester_1", &overrides).unwrap();
        let simulation = Simulation::new(&scene, 0.0).unwrap();
        let plan = plan::plan(&scene, simulation.model());
        plan.effects.into_iter().find(|effect| effect.name == "driving constraint").unwrap().why
    };
    assert!(words("all").contains("strain the vehicle") && !words("leading").contains("strain"));
    assert!(!words("leading").contains("truck[2]"));
}

/// A run that another simulation goes on with ends in the same bits, counters too: an implicit method's findings are not part of the
/// state. One evaluation at the begin of a step serves for events, stage and Jacobian.
#[test]
fn prop_a_restored_vehicle_goes_on_bit_for_bit() {
    for (formulation, integrator) in [("ECF-A", "rosenbrock"), ("ECF-A", "real_time"), ("ECCF", "rosenbrock")] {
        let formulation = format!("contact.formulation={formulation}");
        let integrator = format!("solver.integrator={integrator}");
        let scene = scene("vehicle_manchester_1", &[&formulation, &integrator, "solver.tolerance=1e-5", "solver.step=0.001"]);
        let mut simulation = start(&scene);
        simulation.advance(0.31).unwrap();
        let saved = simulation.state().clone();
        let mut other = start(&scene);
        assert!(other.restore(&saved));
        for at in [&mut simulation, &mut other] {
            at.advance(0.33).unwrap();
            at.advance(0.45).unwrap();
        }
        assert_eq!(simulation.state(), other.state());
        let done = simulation.statistics();
        println!("{formulation} {integrator}: {done:?}");
        let stages = if integrator.contains("rosenbrock") { 4 } else { 2 };
        assert!(done.evaluations <= stages * (done.steps + done.rejected) + 40);
    }
}

/// The same on irregular track, straight and curved, by methods without Jacobians: what lies ahead bounds their steps, and it is known from
/// the last evaluation alone.
#[test]
fn prop_a_restored_explicit_run_sees_the_same_ahead() {
    const WAVES: &str = "track.irregularity=[{kind=\"spectrum\", spectrum=\"ore_b176_low\", seed=1, from=-15, to=400, fade=5}]";
    const CURVE: &[&str] =
        &[WAVES, "track.node=[{distance=0.0},{distance=30.0,radius=400.0,superelevation=\"-0.1 m\"}]", "vehicle.initial.distance=-20"];
    for (track, formulation, integrator) in [
        (&[WAVES][..], "ECF-A", "dormand_prince"),
        (CURVE, "ECF-A", "dormand_prince"),
        (CURVE, "ECF-A", "rk43"),
        (CURVE, "ECF-A", "rk4"),
        (CURVE, "ECCF", "dormand_prince"),
    ] {
        let own = [format!("contact.formulation={formulation}"), format!("solver.integrator={integrator}")];
        let mut changes = vec!["solver.tolerance=1e-5", "solver.step=0.0002", &own[0], &own[1]];
        changes.extend(track);
        let scene = scene("vehicle_manchester_1", &changes);
        let (mut simulation, mut other) = (start(&scene), start(&scene));
        for sample in 1..=20 {
            simulation.advance(0.03 * f64::from(sample)).unwrap();
            let saved = simulation.state().clone();
            assert!(other.restore(&saved));
            for at in [&mut simulation, &mut other] {
                at.advance(0.03 * f64::from(sample) + 0.02).unwrap();
            }
            assert_eq!(simulation.state(), other.state(), "{changes:?} at {sample}");
        }
    }
}
