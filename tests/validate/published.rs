//! Against numbers that other programs computed.

use crate::common::{data, read, read_csv, scene, start, table};
use serde_json::Value;
use wheelrail::scene::steady_state::steady_state;

/// Column of the reference file and output of ours.
const COLUMNS: &[(&str, &str)] = &[
    ("distance", "distance"),
    ("y", "y"),
    ("z", "z"),
    ("roll", "roll"),
    ("yaw", "yaw"),
    ("pitchRate", "pitchRate"),
    ("vy", "vy"),
    ("rollRate", "rollRate"),
    ("yawRate", "yawRate"),
    ("N_left", "left.normalForce"),
    ("N_right", "right.normalForce"),
    ("Q_left", "left.verticalForce"),
    ("Q_right", "right.verticalForce"),
    ("Y_left", "left.lateralForce"),
    ("Y_right", "right.lateralForce"),
    ("Fx_left", "left.longitudinalForce"),
    ("Fx_right", "right.longitudinalForce"),
    ("u_left", "left.contact[1].wheelCoordinate"),
    ("u_right", "right.contact[1].wheelCoordinate"),
    ("eta_left", "left.contact[1].railCoordinate"),
    ("eta_right", "right.contact[1].railCoordinate"),
    ("penetration_left", "left.contact[1].penetration"),
    ("penetration_right", "right.contact[1].penetration"),
    ("a_left", "left.contact[1].semiAxisA"),
    ("b_left", "left.contact[1].semiAxisB"),
    ("a_right", "right.contact[1].semiAxisA"),
    ("b_right", "right.contact[1].semiAxisB"),
    ("xi_x_left", "left.contact[1].longitudinalCreepage"),
    ("xi_y_left", "left.contact[1].lateralCreepage"),
    ("phi_left", "left.contact[1].spinCreepage"),
    ("creepFx_left", "left.contact[1].creepForceX"),
    ("creepFy_left", "left.contact[1].creepForceY"),
    ("creepMz_left", "left.contact[1].spinMoment"),
    ("xi_x_right", "right.contact[1].longitudinalCreepage"),
    ("xi_y_right", "right.contact[1].lateralCreepage"),
    ("phi_right", "right.contact[1].spinCreepage"),
    ("creepFx_right", "right.contact[1].creepForceX"),
    ("creepFy_right", "right.contact[1].creepForceY"),
    ("creepMz_right", "right.contact[1].spinMoment"),
    ("drivingForce", "drivingForce"),
];

/// Largest difference allowed for a column, in its unit: 1e-11 for lengths and angles, a relative 1e-8 of the column's size
/// for the rest.
fn allowed(name: &str, size: f64) -> f64 {
    if name == "y" || name == "yaw" {
        return 5e-14;
    }
    let small = ["distance", "y", "z", "roll", "yaw", "u_", "eta_", "penetration_"];
    if small.iter().any(|prefix| name == *prefix || (prefix.ends_with('_') && name.starts_with(prefix))) { 1e-11 } else { 2e-8 * size }
}

#[test]
fn validate_independent_implementation_over_the_whole_run() {
    // Reference: an independent Python implementation, see the head of the file.
    let reference = read_csv(&data("suspended_wheelset_trajectory.csv"));
    let scene = scene(&["solver.tolerance=1e-13"]);
    let mut simulation = start(&scene);
    let outputs = table(&simulation, &scene);
    let mut worst = vec![0f64; COLUMNS.len()];
    for row in &reference {
        if row["t"] > simulation.time() {
            simulation.advance(row["t"]).unwrap();
        }
        let found = read(&mut simulation, &outputs);
        for (worst, (theirs, ours)) in worst.iter_mut().zip(COLUMNS) {
            *worst = worst.max((found[*ours] - row[*theirs]).abs());
        }
    }
    for (worst, (theirs, _)) in worst.iter().zip(COLUMNS) {
        let size = reference.iter().map(|row| row[*theirs].abs()).fold(0.0, f64::max);
        println!("{theirs:20} size {size:10.3e}  largest difference {worst:8.1e}");
        assert!(*worst <= allowed(theirs, size), "{theirs}: {worst:e} of {size:e}");
    }
}

#[test]
fn validate_independent_evaluation_of_perturbed_states() {
    // Reference: 40-digit evaluation by an independent program; states far from equilibrium, lifted wheels, clipped forces.
    let reference: Value = serde_json::from_slice(&std::fs::read(data("suspended_wheelset_points.json")).unwrap()).unwrap();
    for point in reference["points"].as_array().unwrap() {
        let input = |key: &str| point["input"][key].as_f64().unwrap();
        let set = |key: &str, from: &str| format!("vehicle.initial.{key}={:?}", input(from));
        let changes = [
            "vehicle.initial.from_equilibrium=false".to_string(),
            set("distance", "distance"),
            set("y", "y"),
            set("z", "z"),
            set("roll", "roll"),
            set("yaw", "yaw"),
            set("vy", "vy"),
            set("vz", "vz"),
            set("roll_rate", "rollRate"),
            set("yaw_rate", "yawRate"),
            set("pitch_rate", "pitchRate"),
        ];
        let scene = scene(&changes.iter().map(String::as_str).collect::<Vec<_>>());
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        let found = read(&mut simulation, &outputs);
        let name = point["name"].as_str().unwrap();
        let check = |ours: &str, theirs: &Value, scale: f64| {
            let (ours_value, theirs) = (found[ours], theirs.as_f64().unwrap());
            assert!((ours_value - theirs).abs() <= 1e-9 * theirs.abs() + scale, "{name}: {ours} = {ours_value:e}, expected {theirs:e}");
        };
        let accelerations = &point["accelerations"];
        for (ours, theirs) in
            [("ay", "ay"), ("az", "az"), ("yawAcceleration", "yawAcc"), ("rollAcceleration", "rollAcc"), ("pitchAcceleration", "pitchAcc")]
        {
            check(ours, &accelerations[theirs], 1e-7);
        }
        check("drivingForce", &accelerations["drivingForce"], 1e-5);
        for side in ["left", "right"] {
            let theirs = &point["contact"][side];
            let ours = |name: &str| format!("{side}.contact[1].{name}");
            for (name, key) in
                [("wheelCoordinate", "u"), ("wheelAngle", "alpha"), ("railCoordinate", "eta"), ("penetration", "penetration")]
            {
                check(&ours(name), &theirs[key], 1e-13);
            }
            check(&format!("{side}.normalForce"), &theirs["N"], 1e-4);
            for (name, key) in [("longitudinalForce", "FX"), ("lateralForce", "FY"), ("verticalForce", "FZ")] {
                check(&format!("{side}.{name}"), &theirs[key], 1e-4);
            }
            check(&ours("spinMoment"), &theirs["creepMz"], 1e-6);
        }
    }
}

/// The right contact meets the ends of the deviation here [s]: accelerations and normal forces jump.
const KINKS: [f64; 2] = [0.5, 0.75];

fn validate_rigid_trajectory(formulation: &str) {
    // Reference: an independent Python program with minimal coordinates and the gaps as implicit functions; see the file's head.
    let reference = read_csv(&data("suspended_wheelset_constraint_trajectory.csv"));
    let scene = scene(&[&format!("contact.formulation={formulation}"), "solver.tolerance=1e-13"]);
    let mut simulation = start(&scene);
    let outputs = table(&simulation, &scene);
    // Column there, output here, largest difference allowed.
    let columns = [
        ("y", "y", 1e-10),
        ("z", "z", 1e-13),
        ("yaw", "yaw", 5e-11),
        ("roll", "roll", 1e-11),
        ("vy", "vy", 5e-8),
        ("yawRate", "yawRate", 2e-8),
        ("pitchRate", "pitchRate", 5e-8),
        ("left_N", "left.normalForce", 1e-2),
        ("right_N", "right.normalForce", 1e-2),
        ("left_Fx", "left.contact[1].creepForceX", 5e-3),
        ("left_Fy", "left.contact[1].creepForceY", 5e-3),
        ("right_Fx", "right.contact[1].creepForceX", 5e-3),
        ("right_Fy", "right.contact[1].creepForceY", 5e-3),
    ];
    let mut worst = [0f64; 13];
    for row in &reference {
        if row["t"] > simulation.time() {
            simulation.advance(row["t"]).unwrap();
        }
        let found = read(&mut simulation, &outputs);
        let at_kink = KINKS.iter().any(|kink| (row["t"] - kink).abs() < 1e-6);
        for (worst, (theirs, ours, _)) in worst.iter_mut().zip(columns).filter(|(_, column)| !(at_kink && column.0.contains('_'))) {
            *worst = worst.max((found[ours] - row[theirs]).abs());
        }
    }
    for (worst, (name, _, allowed)) in worst.iter().zip(columns) {
        println!("{formulation} {name:10} largest difference {worst:8.1e}");
        assert!(*worst <= allowed, "{formulation} {name}: {worst:e}");
    }
}

#[test]
fn validate_eccf_against_an_independent_rigid_program() {
    validate_rigid_trajectory("ECCF");
}

#[test]
fn validate_accf_against_an_independent_rigid_program() {
    validate_rigid_trajectory("ACCF");
}

#[test]
fn validate_rigid_contact_in_states_far_from_equilibrium() {
    // Reference: 60-digit evaluation by an independent program (surface equations of both wheels, Newton-Euler).
    let reference: Value = serde_json::from_slice(&std::fs::read(data("suspended_wheelset_constraint_states.json")).unwrap()).unwrap();
    let states = reference["states"].as_array().unwrap();
    assert!(states.len() >= 5);
    for (formulation, state) in ["ECCF", "ACCF"].into_iter().flat_map(|f| states.iter().map(move |state| (f, state))) {
        let number = |group: &str, key: &str| state[group][key].as_f64().unwrap();
        let mut changes = vec![format!("contact.formulation={formulation}"), "vehicle.initial.from_equilibrium=false".to_string()];
        for (key, group, name) in [
            ("distance", "input", "distance"),
            ("y", "input", "y"),
            ("yaw", "input", "yaw"),
            ("vy", "input", "vy"),
            ("yaw_rate", "input", "yawRate"),
            ("pitch_rate", "input", "pitchRate"),
            ("z", "dependent", "z"),
            ("roll", "dependent", "roll"),
            ("vz", "dependent", "vz"),
            ("roll_rate", "dependent", "rollRate"),
        ] {
            changes.push(format!("vehicle.initial.{key}={:?}", number(group, name)));
        }
        let scene = scene(&changes.iter().map(String::as_str).collect::<Vec<_>>());
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        let found = read(&mut simulation, &outputs);
        let name = state["name"].as_str().unwrap();
        let check = |ours: &str, theirs: f64, absolute: f64| {
            let ours_value = found[ours];
            assert!(
                (ours_value - theirs).abs() <= 1e-9 * theirs.abs() + absolute,
                "{formulation}, {name}: {ours} = {ours_value:e}, expected {theirs:e}"
            );
        };
        // The state must not have been moved: it satisfied the constraints.
        for (ours, theirs) in [("z", "z"), ("roll", "roll"), ("vz", "vz"), ("rollRate", "rollRate")] {
            check(ours, number("dependent", theirs), 1e-12);
        }
        for (ours, theirs) in
            [("ay", "ddy"), ("az", "ddz"), ("yawAcceleration", "ddyaw"), ("rollAcceleration", "ddroll"), ("pitchAcceleration", "ddpitch")]
        {
            check(ours, number("accelerations", theirs), 1e-7);
        }
        for side in ["left", "right"] {
            let theirs = |key: &str| state["contact"][side][key].as_f64().unwrap();
            let ours = |key: &str| format!("{side}.contact[1].{key}");
            for (name, key, absolute) in [
                ("normalForce", "N", 1e-4),
                ("creepForceX", "Fx", 1e-4),
                ("creepForceY", "Fy", 1e-4),
                ("spinMoment", "Mz", 1e-6),
                ("longitudinalCreepage", "xi_x", 1e-12),
                ("lateralCreepage", "xi_y", 1e-12),
                ("spinCreepage", "phi", 1e-10),
                ("semiAxisA", "a", 1e-12),
                ("semiAxisB", "b", 1e-12),
                ("wheelCoordinate", "u", 1e-11),
                ("railCoordinate", "eta", 1e-11),
            ] {
                check(&ours(name), theirs(key), absolute);
            }
        }
    }
}

#[test]
fn validate_equilibrium_on_rigid_contact() {
    // Reference: the same independent program.
    for formulation in ["ECCF", "ACCF"] {
        let scene = scene(&[&format!("contact.formulation={formulation}")]);
        let [_, _, z, .., pitch_rate] = steady_state(&scene).unwrap().initial_values();
        assert!((z - 0.457).abs() < 1e-15, "{z}");
        assert!((pitch_rate - 87.527_350_755_034_09).abs() < 1e-12, "{pitch_rate}");
    }
}
