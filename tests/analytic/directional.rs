//! Directional derivatives of outputs by inputs against differences, their linearity, and what asking for them leaves behind.

use crate::counting;
use wheelrail::fmi::variables::{Role, VariableTable};
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::sim::Simulation;
use wheelrail::sim::outputs::Output;

fn opened(file: &str, changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    load::open(file, &changes).unwrap_or_else(|error| panic!("{error}"))
}

fn inputs(table: &VariableTable) -> Vec<(usize, String)> {
    let of = |variable: &wheelrail::fmi::variables::Variable| match variable.role {
        Role::Input(input) => Some((input, variable.name.clone())),
        _ => None,
    };
    table.variables.iter().filter_map(of).collect()
}

/// First distance of the differences that are compared with.
fn distance(name: &str) -> f64 {
    match name {
        _ if name.ends_with("frictionFactor") => 1e-3,
        _ if name.contains(".rail") && name.ends_with("Displacement") => 1e-6,
        _ if name.contains(".rail") && name.ends_with("Slope") => 2e-5,
        _ if name.contains(".rail") => 4e-4,
        _ if name.ends_with("headWind") => 1e-2,
        "speed" | "acceleration" => 1e-1,
        _ if name.contains(".largest") => 2.0,
        _ => 1e3,
    }
}

/// What an output is a sum or difference of, SI: rounding is that of its parts.
fn parts(output: &Output) -> f64 {
    match output.unit.name() {
        "N" => 1e5,
        "N.m" => 1e4,
        "W" => 1e5,
        "m/s2" => 50.0,
        "rad/s2" => 500.0,
        "1" => 1.0,
        _ => 1e-1,
    }
}

fn values(simulation: &mut Simulation, table: &VariableTable) -> Vec<f64> {
    let snapshot = simulation.snapshot().unwrap();
    table.outputs.iter().map(|output| output.value(snapshot)).collect()
}

/// Differences over h, h/2 and h/4 through the whole program, extrapolated, to both sides; the mean of those to each side where these differ (a corner).
/// With what rounding may leave of them, and whether there is a corner.
fn differences(simulation: &mut Simulation, table: &VariableTable, input: usize, name: &str, noise: f64) -> Vec<(f64, f64, bool)> {
    let saved = simulation.state().clone();
    let [value, ..] = simulation.input(input);
    let h = distance(name);
    let mut at = |offset: f64| {
        simulation.set_input(input, value + offset, 0.0, 0.0);
        let found = values(simulation, table);
        assert!(simulation.restore(&saved));
        found
    };
    let sides = [1.0, -1.0].map(|side| [h, 0.5 * h, 0.25 * h].map(|h| at(side * h)));
    let here = at(0.0);
    let extrapolated = |[a, b, c]: [f64; 3], power: f64| {
        let (ab, bc) = ((power * b - a) / (power - 1.0), (power * c - b) / (power - 1.0));
        (power * power * bc - ab) / (power * power - 1.0)
    };
    let steps = [h, 0.5 * h, 0.25 * h];
    (0..here.len())
        .map(|i| {
            let of = |level: usize| (sides[0][level][i], sides[1][level][i], steps[level]);
            let both = extrapolated([0, 1, 2].map(|level| (of(level).0 - of(level).1) / (2.0 * of(level).2)), 4.0);
            let ahead = extrapolated([0, 1, 2].map(|level| (of(level).0 - here[i]) / of(level).2), 2.0);
            let behind = extrapolated([0, 1, 2].map(|level| (here[i] - of(level).1) / of(level).2), 2.0);
            let rounding = 64.0 * noise * here[i].abs().max(parts(&table.outputs[i])) / h;
            let corner = (ahead - behind).abs() > 1e-3 * (ahead.abs() + behind.abs()) + 100.0 * rounding;
            (if corner { 0.5 * (ahead + behind) } else { both }, rounding, corner)
        })
        .collect()
}

fn slopes(simulation: &mut Simulation, table: &VariableTable, seeds: &[(usize, f64)]) -> Vec<f64> {
    let outputs: Vec<&Output> = table.outputs.iter().collect();
    let mut found = vec![0.0; outputs.len()];
    simulation.directional_derivative(seeds, &outputs, |output, input| table.depends(output, input), &mut found).unwrap();
    found
}

/// Every output by every input; returns the largest error over what may be.
fn compare(what: &str, scene: &Scene, times: &[f64], noise: f64) {
    let table = VariableTable::new(scene).unwrap();
    let mut simulation = Simulation::new(scene, 0.0).unwrap();
    let known = inputs(&table);
    let (mut count, mut corners, mut worst, mut wrong) = (0, 0, 0.0f64, Vec::new());
    for time in times {
        for (input, name) in &known {
            let [value, ..] = simulation.input(*input);
            let kick = if name.ends_with("frictionFactor") {
                -0.1
            } else if name.contains(".rail") {
                0.0
            } else if matches!(name.as_str(), "speed" | "acceleration") {
                0.3
            } else {
                300.0
            };
            simulation.set_input(*input, value + kick, 0.0, 0.0);
        }
        simulation.advance(*time).unwrap();
        for (input, name) in &known {
            let before = values(&mut simulation, &table);
            let told = slopes(&mut simulation, &table, &[(*input, 1.0)]);
            let after = values(&mut simulation, &table);
            assert!(before.iter().zip(&after).all(|(a, b)| a.to_bits() == b.to_bits()), "{what}: {name} left something behind");
            for ((output, told), (other, rounding, corner)) in
                table.outputs.iter().zip(&told).zip(differences(&mut simulation, &table, *input, name, noise))
            {
                count += usize::from(*told != 0.0);
                let error = (told - other).abs();
                corners += usize::from(corner);
                if error > if corner { 1e-5 } else { 1e-9 } * other.abs() + rounding {
                    wrong.push(format!(
                        "{what}, t = {time}: d {} / d {name} = {told:e}, differences {other:e}, rounding {rounding:.1e}",
                        output.name
                    ));
                }
                if other.abs() > 100.0 * rounding && !corner {
                    worst = worst.max(error / other.abs());
                }
            }
        }
    }
    println!(
        "{what}: {count} derivatives that are not zero, {corners} at corners, largest error of the others that are well above rounding {worst:.1e}"
    );
    assert!(count > 10 && wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong[..wrong.len().min(40)].join("\n"));
}

#[test]
fn analytic_directional_derivatives_of_elastic_contact() {
    compare("suspended_wheelset ECF-A", &opened("suspended_wheelset", &[]), &[0.3, 0.6], 2e-16);
    compare("suspended_wheelset ECF-N", &opened("suspended_wheelset", &["contact.formulation=ECF-N"]), &[0.6], 2e-16);
    compare("power", &opened("suspended_wheelset", &["interface.outputs=[\"motion\",\"power\"]"]), &[0.3], 2e-16);
    compare("vehicle_curve", &opened("vehicle_curve", &[]), &[0.1, 3.0], 2e-16);
    compare("coach", &opened("vehicle_manchester_1", &[]), &[0.5], 2e-16);
}

#[test]
fn analytic_directional_derivatives_of_motors_and_brakes() {
    let root = env!("CARGO_MANIFEST_DIR");
    compare("braked_coach", &opened(&format!("{root}/examples/braked_coach.toml"), &[]), &[0.5], 2e-16);
    compare("driven_truck", &opened(&format!("{root}/examples/driven_truck.toml"), &[]), &[0.5], 2e-16);
}

#[test]
fn analytic_directional_derivatives_by_a_speed() {
    let speed = "vehicle.speed={start=20}";
    compare("speed ECF-A", &opened("suspended_wheelset", &[speed]), &[0.3, 0.6], 2e-16);
    compare("speed, curve", &opened("vehicle_curve", &[speed]), &[0.1, 3.0], 4e-16);
    compare("speed ECCF", &opened("bogie", &[speed, "contact.formulation=ECCF"]), &[0.2], 1e-11);
    // Beyond the bound nothing changes, at it half as much as within.
    let scene = opened("suspended_wheelset", &["vehicle.speed={start=20,time_constant=0.5,largest_acceleration=2}"]);
    let table = VariableTable::new(&scene).unwrap();
    let mut simulation = Simulation::new(&scene, 0.0).unwrap();
    let place = table.outputs.iter().position(|output| output.name == "wheelset.ax").unwrap();
    let speed = table.speed_input.unwrap();
    for (wanted, expected) in [(20.5, 2.0), (22.0, 0.0), (21.0, 1.0), (18.0, 0.0)] {
        simulation.set_input(speed, wanted, 0.0, 0.0);
        let told = slopes(&mut simulation, &table, &[(speed, 1.0)])[place];
        assert!((told - expected).abs() < 1e-9, "{wanted}: {told}");
    }
}

#[test]
fn analytic_directional_derivatives_by_rails_that_move() {
    let rails = "interface.inputs=[\"rail_motion\", \"centre_forces\"]";
    // Penetrations are differences of numbers of the size of a metre: 1e-16 of 7e-5 m.
    compare("moving rails", &opened("suspended_wheelset", &[rails]), &[0.1, 0.6], 5e-12);
}

#[test]
fn analytic_directional_derivatives_of_rigid_contact() {
    // The loop between normal and creep forces ends at 1e-11 where nobody differentiates it.
    for formulation in ["ECCF", "ACCF"] {
        let change = format!("contact.formulation={formulation}");
        compare(formulation, &opened("suspended_wheelset", &[&change]), &[0.3, 0.6], 1e-11);
        compare(&format!("bogie {formulation}"), &opened("bogie", &[&change]), &[0.2], 1e-11);
    }
}

/// A seed over several inputs is the sum of the single ones, each times its part, and asking again allocates next to nothing.
#[test]
fn prop_directional_derivatives_are_linear() {
    for formulation in ["ECF-A", "ECCF"] {
        let scene = opened("bogie", &[&format!("contact.formulation={formulation}")]);
        let table = VariableTable::new(&scene).unwrap();
        let mut simulation = Simulation::new(&scene, 0.0).unwrap();
        simulation.advance(0.1).unwrap();
        let known = inputs(&table);
        let seeds: Vec<(usize, f64)> = known.iter().enumerate().map(|(i, (input, _))| (*input, (i as f64) - 3.5)).collect();
        let whole = slopes(&mut simulation, &table, &seeds);
        let mut sum = vec![0.0; whole.len()];
        let mut size = vec![0.0; whole.len()];
        for (input, seed) in &seeds {
            for ((sum, size), part) in sum.iter_mut().zip(&mut size).zip(slopes(&mut simulation, &table, &[(*input, 1.0)])) {
                *sum += seed * part;
                *size += (seed * part).abs();
            }
        }
        for (((whole, sum), size), output) in whole.iter().zip(&sum).zip(&size).zip(&table.outputs) {
            assert!((whole - sum).abs() <= 1e-11 * size, "{}: {whole} and {sum}", output.name);
        }
        let outputs: Vec<&Output> = table.outputs.iter().collect();
        let mut found = vec![0.0; outputs.len()];
        let before = counting::count();
        simulation.directional_derivative(&seeds, &outputs, |output, input| table.depends(output, input), &mut found).unwrap();
        let allocations = counting::count() - before;
        assert!(allocations <= 1, "{allocations} allocations");
        assert!(found.iter().zip(&whole).all(|(a, b)| a.to_bits() == b.to_bits()), "asked twice, told two things");
    }
}

/// A force on a wheelset that nothing but springs ties to others accelerates it by 1 / m.
#[test]
fn analytic_a_force_accelerates_a_wheelset_by_its_mass() {
    let scene = opened("suspended_wheelset", &[]);
    let table = VariableTable::new(&scene).unwrap();
    let mut simulation = Simulation::new(&scene, 0.0).unwrap();
    simulation.advance(0.6).unwrap();
    let mass = simulation.model().system.bodies[0].mass;
    let input = |name: &str| inputs(&table).into_iter().find(|(_, other)| other.ends_with(name)).unwrap().0;
    for (force, shown) in [("lateralForceInput", "wheelset.ay"), ("verticalForceInput", "wheelset.az")] {
        let told = slopes(&mut simulation, &table, &[(input(force), 1.0)]);
        let place = table.outputs.iter().position(|output| output.name == shown).unwrap();
        assert!((told[place] * mass - 1.0).abs() < 1e-13, "{shown}: {}", told[place] * mass);
        let others = table.outputs.iter().zip(&told).filter(|(output, slope)| output.name.contains("ontact[") && **slope != 0.0);
        assert_eq!(others.count(), 0);
    }
}
