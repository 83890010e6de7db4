//! What the description says of outputs and inputs at the same instant: nothing else reacts, and little of it is said for nothing.

use wheelrail::fmi::variables::{Role, VariableTable};
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::sim::Simulation;

/// Inputs of a scene: place in the input vector and name.
fn inputs(table: &VariableTable) -> Vec<(usize, String)> {
    let named = |variable: &wheelrail::fmi::variables::Variable| match variable.role {
        Role::Input(input) => Some((input, variable.name.clone())),
        _ => None,
    };
    table.variables.iter().filter_map(named).collect()
}

/// A change of an input that matters and breaks nothing.
fn change(name: &str, value: f64) -> f64 {
    match name {
        _ if name.ends_with("frictionFactor") => 0.9 * value,
        _ if name.contains(".rail") && name.ends_with("Displacement") => value + 2e-6,
        _ if name.contains(".rail") => value + 1e-4,
        _ if name.ends_with("headWind") => value + 1.0,
        "speed" | "acceleration" => value + 0.3,
        _ => value + 1e3,
    }
}

/// What was found of all pairs of outputs and inputs.
#[derive(Default)]
struct Pairs {
    declared: usize,
    fixed: usize,
    reacting: usize,
}

/// Changes every input in states along a run under random inputs, and compares all outputs to the bit.
fn pairs(name: &str, scene: &Scene, times: &[f64]) -> Pairs {
    let table = VariableTable::new(scene).unwrap();
    let known = inputs(&table);
    let mut simulation = Simulation::new(scene, 0.0).unwrap();
    let mut drawn = 0.0;
    let mut reacting = vec![vec![false; known.len()]; table.outputs.len()];
    let mut slopes = vec![vec![Vec::new(); known.len()]; table.outputs.len()];
    for time in times {
        for (input, of) in &known {
            let [value, ..] = simulation.input(*input);
            // Spread over 0 to 1 without a pattern.
            drawn += 0.618_033_988_749_895_f64;
            let kick = if of.contains(".rail") { 0.0 } else { drawn.fract() };
            simulation.set_input(*input, value + kick * (change(of, value) - value), 0.0, 0.0);
        }
        simulation.advance(*time).unwrap_or_else(|error| panic!("{name}: {error}"));
        let saved = simulation.state().clone();
        let snapshot = simulation.snapshot().unwrap();
        let before: Vec<f64> = table.outputs.iter().map(|output| output.value(snapshot)).collect();
        for (place, (input, of)) in known.iter().enumerate() {
            let [value, ..] = simulation.input(*input);
            let changed = change(of, value);
            simulation.set_input(*input, changed, 0.0, 0.0);
            let snapshot = simulation.snapshot().unwrap();
            for ((output, before), number) in table.outputs.iter().zip(&before).zip(0..) {
                let after = output.value(snapshot);
                reacting[number][place] |= after.to_bits() != before.to_bits();
                let slope = (after - before) / (changed - value);
                // An imposed speed along a curve is held by taking the rest of the acceleration off: to rounding.
                let held = output.name.ends_with(".ax") && (after - before).abs() < 1e-14;
                assert!(
                    after.to_bits() == before.to_bits() || table.depends(output, *input) || held,
                    "{name}, t = {time} s: {} reacts to {of} by {slope:e} and does not say so",
                    output.name
                );
                slopes[number][place].push((slope, f64::EPSILON * before.abs() / (changed - value).abs()));
            }
            assert!(simulation.restore(&saved));
        }
    }
    let mut found = Pairs::default();
    for (number, output) in table.outputs.iter().enumerate() {
        for (place, (input, of)) in known.iter().enumerate() {
            let declared = table.depends(output, *input);
            found.declared += usize::from(declared);
            found.reacting += usize::from(reacting[number][place] && declared);
            if declared && table.is_fixed(output, *input) {
                found.fixed += 1;
                let first = slopes[number][place][0].0;
                assert!(first > 0.0, "{name}: {} by {of}", output.name);
                for (slope, rounding) in &slopes[number][place] {
                    assert!(
                        (slope - first).abs() <= 8.0 * rounding + 1e-13 * first,
                        "{name}: {} by {of}: {slope} and {first}",
                        output.name
                    );
                }
            }
        }
    }
    println!(
        "{name}: {} outputs, {} inputs, {} pairs declared, of which {} with a fixed factor; {} react",
        table.outputs.len(),
        known.len(),
        found.declared,
        found.fixed,
        found.reacting
    );
    found
}

fn opened(file: &str, changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    load::open(file, &changes).unwrap_or_else(|error| panic!("{error}"))
}

/// A curve for scenes of straight track.
const CURVE: &str = "track.node=[{distance=\"0 m\"}, {distance=\"10 m\"}, {distance=\"60 m\", curvature=0.002, superelevation=\"-50 mm\"}, {distance=\"400 m\", curvature=0.002, superelevation=\"-50 mm\"}]";

#[test]
fn prop_no_output_reacts_to_an_input_that_it_does_not_name() {
    let root = env!("CARGO_MANIFEST_DIR");
    let (braked, driven) = (format!("{root}/examples/braked_coach.toml"), format!("{root}/examples/driven_truck.toml"));
    let rails = "interface.inputs=[\"rail_motion\", \"centre_forces\", \"drive_torque\", \"friction\"]";
    let books = "interface.outputs=[\"adhesion\",\"power\",\"energy\"]";
    let all_inputs = "interface.inputs=[\"drive_torque\",\"centre_forces\",\"friction\",\"elements\"]";
    let speed = "vehicle.speed={start=20}";
    let cases: [(&str, &[&str], f64); 26] = [
        ("suspended_wheelset", &[], 1.0),
        ("suspended_wheelset", &["contact.formulation=ECF-N"], 1.0),
        ("suspended_wheelset", &["contact.formulation=ECCF"], 1.0),
        ("suspended_wheelset", &["contact.formulation=ACCF"], 1.0),
        ("suspended_wheelset", &[rails], 0.3),
        ("wheelset_s1002", &[], 1.0),
        ("wheelset_standstill", &[], 0.3),
        ("bogie", &[], 0.5),
        ("bogie", &["contact.formulation=ECCF"], 0.5),
        ("bogie", &["vehicle.travel=\"free\"", "contact.transient={below=\"2 m/s\"}", "track.deviation=[]", CURVE], 3.0),
        (
            "vehicle_manchester_1",
            &["interface.outputs=[\"motion\",\"wheels\",\"axles\",\"bodies\",\"sensors\",\"forces\",\"contacts\"]"],
            1.0,
        ),
        ("vehicle_equalised", &[], 0.5),
        ("vehicle_bumps", &[], 0.5),
        ("vehicle_curve", &[], 3.0),
        ("train", &[], 0.2),
        (&braked, &[], 1.0),
        (&driven, &[], 1.0),
        (&driven, &[books, all_inputs], 1.0),
        ("suspended_wheelset", &[books, "contact.formulation=ECCF"], 1.0),
        ("suspended_wheelset", &[books, rails], 0.3),
        ("suspended_wheelset", &[books, speed], 1.0),
        ("suspended_wheelset", &["contact.formulation=ACCF", speed], 0.5),
        ("bogie", &["track.deviation=[]", CURVE, speed], 3.0),
        ("bogie", &["contact.formulation=ECCF", speed], 0.5),
        ("vehicle_curve", &[speed], 3.0),
        ("train", &[speed], 0.2),
    ];
    let mut all = Vec::new();
    for (file, changes, stop) in cases {
        let scene = opened(file, changes);
        let found = pairs(&format!("{} {}", scene.name, changes.join(" ")), &scene, &[0.02, 0.5 * stop, stop]);
        all.push((scene.name.clone(), found));
    }
    // What a joint ties together is one body to an input on it; forces of elastic contact are not.
    let curve = &all.iter().find(|(name, _)| name == "vehicle_curve").unwrap().1;
    assert!(curve.declared < 2 * curve.reacting, "{} of {}", curve.reacting, curve.declared);
    assert!(all.iter().all(|(_, found)| found.reacting <= found.declared));
    assert!(all.iter().any(|(_, found)| found.fixed > 0));
}
