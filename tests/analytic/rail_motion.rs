//! Rails that move under the wheels (inputs `rail_motion`): against fixed rails seen from a moving place, against track of the same
//! shape, and the energy that goes through them.

use crate::common;
use crate::common::{largest_difference, scene, start, straight, table};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::sync::Arc;
use wheelrail::fmi::variables::{Role, VariableTable};
use wheelrail::formulation::{
    ContactReport, Evaluation, Model, RAIL_LATERAL, RAIL_LATERAL_SLOPE, RAIL_LATERAL_VELOCITY, RAIL_VERTICAL, RAIL_VERTICAL_SLOPE,
    RAIL_VERTICAL_VELOCITY, rail_input,
};
use wheelrail::geometry::Side;
use wheelrail::geometry::track::centre_line::{Alignment, CentreLine, Node};
use wheelrail::mbs::on_track::{self, OnTrack};
use wheelrail::scene::assemble;
use wheelrail::scene::spec::Scene;
use wheelrail::sim::Simulation;

const MOVING: &str = "interface.inputs=[\"rail_motion\", \"friction\"]";

fn moving(changes: &[&str]) -> Scene {
    straight(&[&[MOVING], changes].concat())
}

/// A displacement with three derivatives, m and s.
type Jet = [f64; 4];

/// Sets the motion of the rails under the first wheelset from now on.
fn set(simulation: &mut Simulation, side: Side, lateral: Jet, vertical: Jet) {
    let wheelsets = simulation.model().wheelsets.len();
    for (input, [value, first, second]) in [
        (RAIL_LATERAL, [lateral[0], lateral[1], lateral[2]]),
        (RAIL_VERTICAL, [vertical[0], vertical[1], vertical[2]]),
        (RAIL_LATERAL_VELOCITY, [lateral[1], lateral[2], lateral[3]]),
        (RAIL_VERTICAL_VELOCITY, [vertical[1], vertical[2], vertical[3]]),
    ] {
        simulation.set_input(rail_input(wheelsets, 0, side, input), value, first, second);
    }
}

/// A rail at rest that is bent: what a wheel with this speed [m/s] meets of it.
fn bend(simulation: &mut Simulation, side: Side, lateral: Jet, vertical: Jet, speed: f64) {
    let wheelsets = simulation.model().wheelsets.len();
    for (displacement, slope, jet) in [(RAIL_LATERAL, RAIL_LATERAL_SLOPE, lateral), (RAIL_VERTICAL, RAIL_VERTICAL_SLOPE, vertical)] {
        simulation.set_input(rail_input(wheelsets, 0, side, displacement), jet[0], jet[1], jet[2]);
        simulation.set_input(rail_input(wheelsets, 0, side, slope), jet[1] / speed, jet[2] / speed, jet[3] / speed);
    }
}

/// The same displacement and velocity of the rails under both wheels, as the inputs of one evaluation.
fn inputs(model: &Model, displacement: [f64; 2], velocity: [f64; 2]) -> Vec<f64> {
    let mut inputs = model.neutral_inputs();
    for side in Side::BOTH {
        inputs[rail_input(1, 0, side, RAIL_LATERAL)] = displacement[0];
        inputs[rail_input(1, 0, side, RAIL_VERTICAL)] = displacement[1];
        inputs[rail_input(1, 0, side, RAIL_LATERAL_VELOCITY)] = velocity[0];
        inputs[rail_input(1, 0, side, RAIL_VERTICAL_VELOCITY)] = velocity[1];
    }
    inputs
}

/// Accelerations and contacts of a state.
fn evaluate(model: &Model, y: &[f64], inputs: &[f64], distance: f64) -> (Vec<f64>, Vec<ContactReport>) {
    let (mut workspace, mut memory, mut dy) = (model.workspace(), model.blank_memory(), vec![0.0; y.len()]);
    model.set_distances(|_| distance, &mut memory);
    model.derivative(&mut workspace, Evaluation { t: 0.0, inputs, y, memory: &mut memory }, &mut dy).unwrap();
    (dy[6..12].to_vec(), workspace.contacts.clone())
}

const DISPLACEMENT: [f64; 2] = [3e-3, -7e-3];
const VELOCITY: [f64; 2] = [0.04, -0.3];

/// Whoever moves along with the rails sees rails at rest.
#[test]
fn analytic_rails_and_wheelset_that_move_together_feel_the_same_forces() {
    for formulation in ["ECF-A", "ECF-N"] {
        let mut scene = moving(&[&format!("contact.formulation={formulation}")]);
        scene.vehicle.forces.clear();
        let model = assemble::model(&scene).unwrap();
        let mut y = start(&scene).snapshot().unwrap().y.clone();
        (y[1], y[3], y[7], y[8]) = (2e-3, 1e-3, 0.02, -0.01);
        let (rest, at_rest) = evaluate(&model, &y, &inputs(&model, [0.0; 2], [0.0; 2]), y[0]);
        for i in 0..2 {
            y[1 + i] += DISPLACEMENT[i];
            y[7 + i] += VELOCITY[i];
        }
        let (together, contacts) = evaluate(&model, &y, &inputs(&model, DISPLACEMENT, VELOCITY), y[0]);
        let difference = largest_difference(&rest, &together);
        println!("{formulation}: accelerations {rest:.3?}, differ by {difference:.1e}; N {:.1} N", at_rest[0].normal_force);
        // A rounding of 1e-16 m is 1e-9 of a wheel load's force.
        assert!(difference < 1e-8 && at_rest[0].normal_force > 4e4, "{formulation}");
        for (a, b) in at_rest.iter().zip(&contacts) {
            assert!((a.penetration - b.penetration).abs() < 1e-15 && (a.penetration_rate - b.penetration_rate).abs() < 1e-14);
            assert!((a.normal_force - b.normal_force).abs() < 1e-9 * a.normal_force, "{a:?}");
        }
        let alone = evaluate(&model, &y, &inputs(&model, DISPLACEMENT, [0.0; 2]), y[0]).0;
        assert!(largest_difference(&rest, &alone) > 1.0, "velocities matter: {alone:?}");
    }
}

/// The same in a curve whose cant and curvature change, where the displaced rail turns with the track: that is no slip of its own
/// material, so the wheel on it slips by s' omega x u, less what its contact leads by where the rail rises against the track.
#[test]
fn analytic_rails_that_move_together_with_the_wheelset_on_a_canted_spiral() {
    let mut scene = moving(&[]);
    scene.vehicle.forces.clear();
    let node = |distance, curvature, superelevation| Node { distance, curvature, superelevation, grade: 0.0 };
    let alignment = Alignment { nodes: vec![node(0.0, 0.0, 0.0), node(40.0, 5e-3, 0.1)], ..Alignment::default() };
    scene.track.line = CentreLine::new(&alignment, Vector3::zeros(), 0.0).map(Arc::new);
    let model = assemble::model(&scene).unwrap();
    let frame = model.track.line().unwrap().frame(20.0);
    let turn = frame.turn;
    let travel = 40.0;
    // Rates of the coordinates are those relative to the track; the speed is that of the centre itself.
    let state = |offset: [f64; 2], rate: [f64; 2]| {
        let (y, z) = (2e-3 + offset[0], 0.4569 + offset[1]);
        let speed = travel * (1.0 - (y * turn.z - z * turn.y));
        let coordinates = [20.0, y, z, 1e-3, 0.0, 0.0];
        let velocities = [speed, 0.02 + rate[0], rate[1], -0.01, 0.0, 87.5];
        let (q, v) = on_track::place(&frame, &OnTrack { coordinates, velocities });
        [q, v].concat()
    };
    let at_rest = evaluate(&model, &state([0.0; 2], [0.0; 2]), &inputs(&model, [0.0; 2], [0.0; 2]), 20.0).1;
    let together = evaluate(&model, &state(DISPLACEMENT, VELOCITY), &inputs(&model, DISPLACEMENT, VELOCITY), 20.0).1;
    let swing = turn.cross(&Vector3::new(0.0, DISPLACEMENT[0], DISPLACEMENT[1])) * travel;
    for (a, b) in at_rest.iter().zip(&together) {
        let (depth, rate) = (b.penetration - a.penetration, b.penetration_rate - a.penetration_rate);
        let slips = [b.slip.longitudinal - a.slip.longitudinal, b.slip.lateral - a.slip.lateral];
        let up = Vector3::z();
        let normal = frame.components(&a.axes.normal);
        let lead = up * (swing.dot(&normal) / up.dot(&normal));
        let expected = [a.axes.e1, a.axes.e2].map(|axis| frame.components(&axis).dot(&(swing - lead)));
        println!("penetration {:.3e} m, differs by {depth:.1e}; rate {:.3e} m/s, by {rate:.1e}", a.penetration, a.penetration_rate);
        println!("slip differs by {:.9e} and {:.9e} m/s, expected {:.9e} and {:.9e}", slips[0], slips[1], expected[0], expected[1]);
        assert!(depth.abs() < 1e-13 && rate.abs() < 1e-9);
        // Roll and yaw of the axle tilt `up` a little.
        assert!((0..2).all(|i| (slips[i] - expected[i]).abs() < 3e-8));
    }
}

/// Up by `height` [m] within a second and no further: two parabolas.
fn rise(height: f64, t: f64) -> Jet {
    let a = 4.0 * height;
    match t {
        t if t < 0.5 => [0.5 * a * t * t, a * t, a, 0.0],
        t if t < 1.0 => [height - 0.5 * a * (1.0 - t) * (1.0 - t), a * (1.0 - t), -a, 0.0],
        _ => [height, 0.0, 0.0, 0.0],
    }
}

#[test]
fn analytic_lifted_rails_lift_the_wheelset() {
    let height = 20e-3;
    for (what, left, right) in [("both rails", height, height), ("left rail", height, 0.0)] {
        let scene = moving(&["vehicle.travel=imposed"]);
        let mut simulation = start(&scene);
        let before = simulation.snapshot().unwrap().y.clone();
        for (from, to) in [(0.0, 0.5), (0.5, 1.0), (1.0, 3.0)] {
            for (side, height) in [(Side::Left, left), (Side::Right, right)] {
                set(&mut simulation, side, [0.0; 4], rise(height, from));
            }
            simulation.advance(to).unwrap();
        }
        let after = simulation.snapshot().unwrap();
        let (lifted, roll) = (after.y[2] - before[2], after.y[4] - before[4]);
        println!("{what} up by {:.1} mm: centre {:.6} mm, roll {:.6} mrad", 1e3 * height, 1e3 * lifted, 1e3 * roll);
        if left == right {
            assert!((lifted - height).abs() < 1e-9 && roll.abs() < 1e-12, "{lifted} {roll}");
        } else {
            // Half the lift, and a lean of lift over the distance of the contacts; the wheelset also moves to the low side.
            assert!((lifted / (0.5 * height) - 1.0).abs() < 0.02, "{lifted}");
            assert!((roll / (height / 1.432) - 1.0).abs() < 0.02, "{roll}");
        }
    }
}

/// The disturbance of the embedded scene as motion of the rail under the wheel.
fn cosine(amplitude: f64, distance: f64, speed: f64) -> Jet {
    let (from, length) = (20.0, 10.0);
    if !(from..from + length).contains(&distance) {
        return [0.0; 4];
    }
    let k = TAU / length;
    let (sin, cos) = (k * (distance - from)).sin_cos();
    let (a, w) = (0.5 * amplitude, k * speed);
    [a * (1.0 - cos), a * w * sin, a * w * w * cos, -a * w * w * w * sin]
}

/// Name, changes of the scene, how far each side moves to the left and up [m], and the bounds of output differences, parts of the swing.
type Bend = (&'static str, &'static [&'static str], [(Side, [f64; 2]); 2], &'static [(&'static str, f64)]);

/// A rail with a deviation, and one that inputs bend in the same way: the same but for what the turn of a rail does.
#[test]
fn equiv_moving_rail_and_deviation_of_the_same_shape() {
    let speed = 40.0;
    let cases: [Bend; 3] = [
        (
            "right rail 10 mm to the left",
            &[],
            [(Side::Left, [0.0, 0.0]), (Side::Right, [10e-3, 0.0])],
            &[("y", 1e-3), ("yaw", 1e-3), ("left.lateralForce", 2e-3), ("right.normalForce", 2e-3)],
        ),
        (
            "both rails 5 mm up",
            &["track.deviation[1].rail=both", "track.deviation[1].direction=vertical", "track.deviation[1].amplitude=5 mm"],
            [(Side::Left, [0.0, 5e-3]), (Side::Right, [0.0, 5e-3])],
            &[("z", 1e-3), ("left.verticalForce", 3e-3), ("drivingForce", 1e-2)],
        ),
        (
            "outer rail of a curve 5 mm down",
            &[
                "track.deviation[1].direction=vertical",
                "track.deviation[1].amplitude=-5 mm",
                "track.node=[{distance=0, radius=1500, superelevation=\"-100 mm\"}]",
            ],
            [(Side::Left, [0.0, 0.0]), (Side::Right, [0.0, -5e-3])],
            &[
                ("y", 1e-2),
                ("yaw", 1e-2),
                ("left.lateralForce", 1e-2),
                ("right.lateralForce", 1e-2),
                ("right.normalForce", 1e-2),
                ("drivingForce", 1e-2),
            ],
        ),
    ];
    for (what, changes, rails, compared) in cases {
        let fixed = common::run(&scene(&[&["solver.tolerance=1e-9"], changes].concat()), 1.2, 2.5e-3);
        let node: Vec<&str> = changes.iter().copied().filter(|change| change.starts_with("track.node")).collect();
        let scene = moving(&[&["solver.tolerance=1e-9"], &node[..]].concat());
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        let place = outputs.iter().position(|output| output.name == "wheelset.distance").unwrap();
        let begin = outputs[place].value(simulation.snapshot().unwrap());
        let substeps = 10;
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for row in 0..=480 {
            let snapshot = simulation.snapshot().unwrap();
            rows.push(outputs.iter().map(|output| output.value(snapshot)).collect());
            for sub in 0..substeps {
                let snapshot = simulation.snapshot().unwrap();
                let distance = outputs[place].value(snapshot) - begin;
                for (side, [lateral, vertical]) in rails {
                    bend(&mut simulation, side, cosine(lateral, distance, speed), cosine(vertical, distance, speed), speed);
                }
                simulation.advance(2.5e-3 * (f64::from(row) + f64::from(sub + 1) / f64::from(substeps))).unwrap();
            }
        }
        for (name, bound) in compared {
            let place = outputs.iter().position(|output| output.name == format!("wheelset.{name}")).unwrap();
            let (track, moved) = (common::column(&fixed, name), rows.iter().map(|row| row[place]).collect::<Vec<f64>>());
            let swing = track.iter().map(|v| (v - track[0]).abs()).fold(0.0, f64::max);
            let difference = largest_difference(&track, &moved[..track.len()]);
            println!("{what}: {name} swings by {swing:.4e}, differs by {difference:.2e}: {:.1e}", difference / swing);
            assert!(difference < bound * swing, "{name}");
        }
    }
}

/// Work of the forces on rails that swing up and down = change of the wheelset's energy (no damping, no friction).
#[test]
fn analytic_work_of_the_rails_is_the_energy_of_the_wheelset() {
    let scene = moving(&["contact.friction=0", "contact.damping=0", "solver.tolerance=1e-11"]);
    let (amplitude, frequency, h) = (2e-5, TAU * 20.0, 1e-4);
    let swing = |t: f64| {
        let (sin, cos) = (frequency * t).sin_cos();
        let (a, w) = (amplitude, frequency);
        [a * (1.0 - cos), a * w * sin, a * w * w * cos, -a * w * w * w * sin]
    };
    let mut simulation = start(&scene);
    let outputs = table(&simulation, &scene);
    let read = |simulation: &mut Simulation, t: f64| {
        let found = common::read(simulation, &outputs);
        let contacts: f64 = ["left", "right"]
            .iter()
            .map(|side| 0.4 * found[&format!("{side}.normalForce")] * found[&format!("{side}.contact[1].penetration")])
            .sum();
        let energy = 0.5 * 1568.0 * found["vz"].powi(2) + (1568.0 * 9.81 + 98000.0) * found["z"] + contacts;
        let push: f64 = ["left", "right"].iter().map(|side| found[&format!("{side}.railVerticalForce")]).sum();
        let given = -push * swing(t)[1];
        assert!((push + found["left.verticalForce"] + found["right.verticalForce"]).abs() < 1e-6);
        (energy, given)
    };
    let (first, mut before) = read(&mut simulation, 0.0);
    let (mut work, mut worst, mut exchanged) = (0.0, 0f64, 0f64);
    for step in 0..1000 {
        let mut power = [before, 0.0, 0.0];
        for half in 0..2 {
            let t = h * (f64::from(step) + 0.5 * f64::from(half));
            for side in Side::BOTH {
                set(&mut simulation, side, [0.0; 4], swing(t));
            }
            simulation.advance(t + 0.5 * h).unwrap();
            let (energy, given) = read(&mut simulation, t + 0.5 * h);
            power[half as usize + 1] = given;
            if half == 1 {
                work += h / 6.0 * (power[0] + 4.0 * power[1] + given);
                worst = worst.max((energy - first - work).abs());
                exchanged = exchanged.max(work.abs());
                before = given;
            }
        }
    }
    println!("rails swing by {amplitude:e} m: up to {exchanged:.4} J exchanged, balance misses {worst:.1e} J");
    assert!(exchanged > 0.5 && worst < 1e-5 * exchanged, "{worst:e} of {exchanged}");
}

/// Outputs change at once with the inputs that the description names, and with no other.
#[test]
fn prop_outputs_depend_on_the_rails_as_described() {
    let scene = moving(&[]);
    let described = VariableTable::new(&scene).unwrap();
    let names: Vec<(&str, u32)> = described
        .variables
        .iter()
        .filter(|v| v.name.contains(".rail") && v.causality == "input")
        .map(|v| (v.name.as_str(), v.reference))
        .collect();
    println!("{names:?}");
    assert_eq!(names.len(), 12);
    assert!(
        names.contains(&("wheelset.left.railLateralDisplacement", 1501)) && names.contains(&("wheelset.right.railVerticalVelocity", 1514))
    );
    let values = |changed: Option<usize>| -> Vec<f64> {
        let mut simulation = start(&scene);
        set(&mut simulation, Side::Left, [1e-4, 1e-3, 0.0, 0.0], [2e-6, -2e-4, 0.0, 0.0]);
        simulation.advance(0.01).unwrap();
        if let Some(input) = changed {
            let [value, ..] = simulation.input(input);
            simulation.set_input(input, value + 1e-6, 0.0, 0.0);
        }
        let snapshot = simulation.snapshot().unwrap();
        described.outputs.iter().map(|output| output.value(snapshot)).collect()
    };
    let plain = values(None);
    let mut seen = 0;
    for variable in &described.variables {
        let Role::Input(input) = variable.role else { continue };
        if !variable.name.contains(".rail") {
            continue;
        }
        for ((output, a), b) in described.outputs.iter().zip(&plain).zip(values(Some(input))) {
            let named = described.depends(output, input);
            assert!(named || *a == b, "{} depends on {}", output.name, variable.name);
            seen += usize::from(*a != b);
            if output.name.contains(variable.name.split('.').nth(1).unwrap())
                && output.name.ends_with("verticalForce")
                && variable.name.contains("Vertical")
            {
                assert!(named && *a != b, "{} and {}", output.name, variable.name);
            }
        }
    }
    assert!(seen > 100, "{seen}");
    // A scene that does not ask for it has nothing of it.
    let plain = VariableTable::new(&straight(&[])).unwrap();
    assert!(plain.variables.iter().all(|variable| !variable.name.contains(".rail")
        || variable.name.contains("railCoordinate")
        || variable.name.contains("railDistance")));
    assert_eq!(plain.start_inputs.len(), 6);
}

#[test]
fn hard_rigid_contact_on_moving_rails_is_refused() {
    for formulation in ["ACCF", "ECCF"] {
        let changes = [MOVING.to_string(), format!("contact.formulation={formulation}")];
        let error = wheelrail::scene::load::open("suspended_wheelset", &changes).err().map(|error| error.to_string()).unwrap_or_default();
        println!("{error}");
        assert!(error.contains("rail_motion") && error.contains("acceleration") && error.contains("ECF-A"), "{error}");
    }
}
