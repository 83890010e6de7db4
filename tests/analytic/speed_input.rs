//! `vehicle.speed` as an input: the vehicle follows what is wanted by the law of `mbs::speed_input`, whatever formulation, method, vehicle and track.

use crate::common::{largest_difference, start};
use std::collections::HashMap;
use wheelrail::formulation::inputs::{TRAVEL_INPUTS, WANTED_RATE, WANTED_SPEED};
use wheelrail::mbs::speed_profile::SpeedProfile;
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::sim::Simulation;
use wheelrail::sim::vehicle_outputs::scene_outputs;

const RAMP: &str = "vehicle.speed=[{time=0,speed=\"10 m/s\"},{time=1,speed=\"10 m/s\"},{time=4,speed=\"54 km/h\"}]";
const ENERGY: &str = "interface.outputs=[\"motion\",\"wheels\",\"suspension\",\"bodies\",\"power\",\"energy\"]";
const PLAIN: &str = "track.deviation=[]";

fn open(name: &str, changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    load::open(name, &changes).unwrap_or_else(|error| panic!("{changes:?}: {error}"))
}

/// A speed that is an input: start [m/s], time constant [s], largest acceleration [m/s2].
fn input(start: f64, time_constant: f64, largest: f64) -> String {
    format!("vehicle.speed={{start={start},time_constant={time_constant},largest_acceleration={largest}}}")
}

/// Where the inputs of the speed stand.
fn place(simulation: &Simulation) -> usize {
    simulation.model().first_travel_input(simulation.state().inputs.len()).unwrap()
}

fn want(simulation: &mut Simulation, [speed, first, second]: [f64; 3]) {
    let place = place(simulation) + WANTED_SPEED;
    simulation.set_input(place, speed, first, second);
}

/// Runs with `tell` called at each communication point, and returns all outputs there, with "time".
fn drive(scene: &Scene, stop: f64, step: f64, mut tell: impl FnMut(&mut Simulation, f64)) -> HashMap<String, Vec<f64>> {
    let mut simulation = start(scene);
    let outputs = scene_outputs(scene, simulation.model());
    let mut columns: HashMap<String, Vec<f64>> = HashMap::new();
    for row in 0..=(stop / step).round() as usize {
        let t = step * row as f64;
        simulation.advance(t).unwrap_or_else(|error| panic!("{error}"));
        tell(&mut simulation, t);
        let snapshot = simulation.snapshot().unwrap();
        columns.entry("time".into()).or_default().push(t);
        for output in &outputs {
            columns.entry(output.name.clone()).or_default().push(output.value(snapshot));
        }
    }
    columns
}

/// Largest |column - expected(t)|.
fn off(columns: &HashMap<String, Vec<f64>>, name: &str, expected: impl Fn(f64) -> f64) -> f64 {
    columns[name].iter().zip(&columns["time"]).map(|(value, t)| (value - expected(*t)).abs()).fold(0.0, f64::max)
}

/// Value and derivatives of a table on a piece that a bend does not divide.
fn jet(profile: &SpeedProfile, t: f64, step: f64) -> [f64; 3] {
    let ([value, slope], [_, next]) = (profile.at(t), profile.at(t + step));
    [value, slope, (next - slope) / step]
}

/// Speed, acceleration and way after a jump by `jump` m/s from `from` m/s, with T = 0.5 s and A = 2 m/s2.
fn jumped(t: f64, from: f64, jump: f64) -> [f64; 3] {
    let (constant, bound) = (0.5, 2.0 * jump.signum());
    let bounded = jump / bound - constant;
    if t < bounded {
        return [from + bound * t, bound, from * t + 0.5 * bound * t * t];
    }
    let (late, left) = (t - bounded, bound * constant);
    let rest = left * (-late / constant).exp();
    let way = from * bounded + 0.5 * bound * bounded * bounded + (from + jump) * late - constant * (left - rest);
    [from + jump - rest, rest / constant, way]
}

/// The table's run: an input with the same polynomials gives it in all formulations.
#[test]
fn equiv_an_input_like_a_table_gives_its_run() {
    let step = 0.0125;
    for (formulation, method, setting, most) in [
        ("ECF-A", "rosenbrock", "solver.tolerance=1e-8", 1e-7),
        ("ECF-A", "dormand_prince", "solver.tolerance=1e-9", 1e-8),
        ("ECF-N", "rosenbrock", "solver.tolerance=1e-8", 1e-7),
        ("ECCF", "rosenbrock", "solver.tolerance=1e-8", 1e-7),
        ("ACCF", "dormand_prince", "solver.tolerance=1e-9", 1e-8),
    ] {
        let [formulation, method] = [format!("contact.formulation={formulation}"), format!("solver.integrator={method}")];
        let with = |speed: &str| open("suspended_wheelset", &["vehicle.initial.distance=15", speed, &formulation, &method, setting]);
        let (table, follows) = (with(RAMP), with(&input(10.0, 0.5, 3.0)));
        let profile = table.vehicle.speed_profile().unwrap().clone();
        let expected = drive(&table, 4.5, step, |_, _| ());
        let found = drive(&follows, 4.5, step, |simulation, t| want(simulation, jet(&profile, t, step)));
        let speed = off(&found, "wheelset.vx", |t| profile.at(t)[0]);
        let apart = |name: &str| largest_difference(&expected[name], &found[name]);
        let [y, way, force, load] = ["wheelset.y", "wheelset.distance", "wheelset.drivingForce", "wheelset.left.verticalForce"].map(apart);
        println!("{formulation} {method}: speed {speed:.1e} m/s, y {y:.1e} m, way {way:.1e} m, forces {force:.1e} N, {load:.1e} N");
        assert!(speed < most && y < most && way < most && force < 50.0 && load < 50.0, "{formulation} {method}");
    }
}

/// A jump: the bound of the acceleration, then the time constant; in all methods.
#[test]
fn analytic_a_jump_is_followed_by_the_law() {
    let adaptive = "solver.tolerance=1e-7";
    let cases = [
        ("ECF-A", "rosenbrock", adaptive, 2e-6),
        ("ECF-A", "dormand_prince", adaptive, 2e-6),
        ("ECF-A", "rk43", adaptive, 2e-6),
        ("ECF-A", "imex", adaptive, 2e-6),
        ("ECF-A", "rk4", "solver.step=1e-4", 1e-6),
        ("ECF-A", "zhai", "solver.step=1e-4", 1e-6),
        ("ECF-A", "real_time", "solver.step=1e-3", 1e-5),
        ("ECF-A", "generalised_alpha", "solver.step=1e-3", 1e-5),
        ("ECF-N", "rosenbrock", adaptive, 2e-6),
        ("ECCF", "rosenbrock", adaptive, 2e-6),
        ("ECCF", "real_time", "solver.step=1e-3", 1e-5),
        ("ACCF", "dormand_prince", adaptive, 2e-6),
    ];
    for (formulation, method, setting, most) in cases {
        for jump in [4.0, -4.0] {
            let [formulation, method] = [format!("contact.formulation={formulation}"), format!("solver.integrator={method}")];
            let scene = open("suspended_wheelset", &[PLAIN, &input(20.0, 0.5, 2.0), &formulation, &method, setting]);
            let found = drive(&scene, 4.0, 0.0125, |simulation, t| {
                if t == 0.0 {
                    want(simulation, [20.0 + jump, 0.0, 0.0]);
                }
            });
            let [speed, rate, way] = ["wheelset.vx", "wheelset.ax", "wheelset.distance"]
                .into_iter()
                .zip(0..)
                .map(|(name, k)| off(&found, name, |t| jumped(t, 20.0, jump)[k]))
                .collect::<Vec<_>>()
                .try_into()
                .unwrap();
            println!("{formulation} {method} {jump}: speed {speed:.1e}, acceleration {rate:.1e}, way {way:.1e}");
            assert!(
                speed < 5.0 * most && rate < 10.0 * most && way < 5.0 * most,
                "{formulation} {method} {jump}: {speed:e} {rate:e} {way:e}"
            );
        }
    }
}

/// A master that knows no derivatives: with the slope as the input `acceleration` a staircase is followed to k H / 2, without it to k T.
#[test]
fn analytic_a_staircase_is_followed_to_its_lag() {
    let (slope, step, constant) = (0.8, 0.02, 0.5);
    // What is left of u - V at the end of a step comes again: e = (e + k H) q - a T (1 - q), q = exp(-H / T).
    let q = f64::exp(-step / constant);
    let end = slope * step * (1.0 + q / (1.0 - q));
    for (tells, lag) in [(true, end - slope * constant), (false, end)] {
        let scene = open("suspended_wheelset", &[PLAIN, &input(20.0, constant, 2.0), "solver.integrator=rosenbrock"]);
        let found = drive(&scene, 6.0, step, |simulation, t| {
            want(simulation, [20.0 + slope * t, 0.0, 0.0]);
            let place = place(simulation) + WANTED_RATE;
            simulation.set_input(place, if tells { slope } else { 0.0 }, 0.0, 0.0);
        });
        let behind = |row: usize| 20.0 + slope * found["time"][row] - found["wheelset.vx"][row];
        let last = found["time"].len() - 1;
        println!("{tells}: {} of {lag} m/s behind", behind(last));
        assert!((behind(last) - lag).abs() < 1e-5, "{tells}: {} {lag}", behind(last));
        let about = if tells { 0.5 * slope * step } else { slope * (constant + 0.5 * step) };
        assert!((lag - about).abs() < 0.01 * about, "{tells}: {lag} {about}");
    }
}

/// Vehicles: all driven wheelsets have the speed that is wanted, in curves along the track; the books of energy close with the work of the driving force.
#[test]
fn analytic_vehicles_in_a_curve_and_their_energy() {
    let curve = "track.node=[{distance=0},{distance=40},{distance=80,radius=500,superelevation=\"60 mm\"}]";
    let follows = input(15.0, 0.4, 2.0);
    let cases = [
        ("suspended_wheelset", vec!["solver.integrator=rosenbrock", "solver.tolerance=1e-8"]),
        ("suspended_wheelset", vec!["contact.formulation=ECCF"]),
        ("bogie", vec!["solver.tolerance=1e-7"]),
        ("vehicle_equalised", vec!["solver.tolerance=1e-7"]),
        ("vehicle_equalised", vec!["contact.formulation=ECCF", "contact.on_lift=elastic"]),
    ];
    for (name, mut changes) in cases {
        changes.extend([PLAIN, ENERGY, curve, &follows]);
        let scene = open(name, &changes);
        // Up by a ramp with derivatives from 0.5 s on, down by a jump at 4 s.
        let wanted = |t: f64| if t < 4.0 { 15.0 + (t - 0.5).clamp(0.0, 3.0) } else { 17.0 };
        let found = drive(&scene, 6.0, 0.02, |simulation, t| {
            let slope = if (0.5 - 1e-9..3.5 - 1e-9).contains(&t) { 1.0 } else { 0.0 };
            want(simulation, [wanted(t), slope, 0.0]);
        });
        for (wheelset, _) in scene.vehicle.axles().iter().filter(|axle| axle.1) {
            let expected = |t: f64| if t < 4.0 { wanted(t) } else { speed_after_a_fall(t - 4.0) };
            let worst = off(&found, &format!("{wheelset}.vx"), expected);
            println!("{name} {wheelset}: {worst:.1e} m/s");
            assert!(worst < 2e-5, "{name} {changes:?} {wheelset}: {worst:e}");
        }
        let sum = |ends: &[&str]| -> Vec<f64> {
            let mut total = vec![0.0; found["time"].len()];
            for (_, column) in found.iter().filter(|(name, _)| ends.iter().any(|end| name.ends_with(end))) {
                total.iter_mut().zip(column).for_each(|(total, value)| *total += value);
            }
            total
        };
        let stored = sum(&["energy.kinetic", "energy.height", "energy.elements"]);
        let given = sum(&[".inputWork", ".drivingWork", ".work", "energy.contactWork", "energy.guideWork"]);
        let taken = sum(&[".frictionHeat", ".heat", "energy.suspensionHeat"]);
        let left = (0..stored.len()).map(|i| (stored[i] - stored[0] - given[i] + taken[i]).abs()).fold(0.0, f64::max);
        let largest = given.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        println!("{name} {changes:?}: {left:.3e} J of {largest:.3e} J");
        // What turns the weight of a supported load in a curve is in no book.
        let share = if name == "suspended_wheelset" { 2e-3 } else { 1e-3 };
        assert!(left < share * largest, "{name} {changes:?}: {left} J of {largest}");
    }
}

/// From 18 m/s to 17 m/s with T = 0.4 s and A = 2 m/s2.
fn speed_after_a_fall(t: f64) -> f64 {
    let bounded = 1.0 / 2.0 - 0.4;
    if t < bounded { 18.0 - 2.0 * t } else { 17.0 + 0.8 * (-(t - bounded) / 0.4).exp() }
}

/// Inputs stand last, and a scene with any other speed has none of them.
#[test]
fn prop_places_and_the_scene_without() {
    let simulation = start(&open("suspended_wheelset", &[&input(20.0, 0.5, 2.0)]));
    assert_eq!(place(&simulation) + TRAVEL_INPUTS, simulation.state().inputs.len());
    for speed in ["vehicle.speed=20", RAMP] {
        let simulation = start(&open("suspended_wheelset", &[speed]));
        assert!(simulation.model().first_travel_input(simulation.state().inputs.len()).is_none(), "{speed}");
    }
}

/// Where a master looks changes nothing, and a state that is put back goes on with the same bits.
#[test]
fn prop_communication_and_states_change_no_bit() {
    for (formulation, method) in [("ECF-A", "rosenbrock"), ("ECF-N", "rosenbrock"), ("ECCF", "rosenbrock"), ("ACCF", "dormand_prince")] {
        let [formulation, method] = [format!("contact.formulation={formulation}"), format!("solver.integrator={method}")];
        let scene = open("suspended_wheelset", &[&input(10.0, 0.5, 2.0), &formulation, &method]);
        let run = |simulation: &mut Simulation, step: f64, stop: f64| {
            while simulation.time() < stop - 1e-12 {
                simulation.advance((simulation.time() + step).min(stop)).unwrap();
            }
        };
        let at = |step: f64| {
            let mut simulation = start(&scene);
            run(&mut simulation, step, 0.5);
            want(&mut simulation, [10.3, 0.7, 0.1]);
            run(&mut simulation, step, 1.5);
            want(&mut simulation, [10.0, -0.2, 0.0]);
            run(&mut simulation, step, 2.5);
            simulation.snapshot().unwrap().y.clone()
        };
        assert_eq!(at(0.0173), at(2.5), "{formulation}");
        let mut simulation = start(&scene);
        want(&mut simulation, [12.0, 0.0, 0.0]);
        simulation.advance(0.8).unwrap();
        let kept = simulation.state().clone();
        let mut on = |kept: Option<&wheelrail::sim::SimulationState>| {
            if let Some(kept) = kept {
                assert!(simulation.restore(kept));
            }
            simulation.advance(1.1).unwrap();
            want(&mut simulation, [11.0, 0.5, 0.0]);
            simulation.advance(2.0).unwrap();
            simulation.snapshot().unwrap().y.clone()
        };
        let (first, again) = (on(None), on(Some(&kept)));
        assert_eq!(first, again, "{formulation}");
    }
}

/// The step of a master that gives derivatives does not matter: to the tolerance.
#[test]
fn prop_the_masters_step_does_not_matter_where_it_gives_derivatives() {
    let scene = open("suspended_wheelset", &[&input(38.0, 0.5, 3.0), "solver.integrator=rosenbrock", "solver.tolerance=1e-7"]);
    // A parabola: its derivatives at any instant are those of all others.
    let wanted = |t: f64| [38.0 + 0.9 * t - 0.2 * t * t, 0.9 - 0.4 * t, -0.4];
    let runs: Vec<HashMap<String, Vec<f64>>> =
        [0.001, 0.01, 0.1].into_iter().map(|step| drive(&scene, 2.0, step, |simulation, t| want(simulation, wanted(t)))).collect();
    let thinned =
        |run: &HashMap<String, Vec<f64>>, name: &str, every: usize| -> Vec<f64> { run[name].iter().step_by(every).copied().collect() };
    for (run, every) in runs.iter().zip([100, 10, 1]) {
        for (name, most) in [("wheelset.y", 2e-7), ("wheelset.distance", 2e-7), ("wheelset.vx", 1e-7)] {
            let apart = largest_difference(&thinned(run, name, every), &runs[2][name]);
            println!("{name} {every}: {apart:.1e}");
            assert!(apart < most, "{name} {every}: {apart:e}");
        }
        let speed = off(run, "wheelset.vx", |t| wanted(t)[0]);
        println!("{every}: {speed:.1e} m/s off");
        assert!(speed < 1e-6, "{every}: {speed:e}");
    }
}

/// With `[contact.transient]` a vehicle is brought to rest on a grade, stands, and starts again, backwards too; without it the run ends and says so.
#[test]
fn hard_to_rest_and_on_again() {
    let changes = ["vehicle.travel=imposed", &input(3.0, 0.5, 1.0)];
    for formulation in ["ECF-A", "ECCF"] {
        let formulation = format!("contact.formulation={formulation}");
        let scene = open("wheelset_standstill", &[changes[0], changes[1], &formulation]);
        let found = drive(&scene, 30.0, 0.05, |simulation, t| {
            for (at, speed) in [(1.0, 0.0), (14.0, 2.0), (20.0, -1.5)] {
                if (t - at).abs() < 1e-9 {
                    want(simulation, [speed, 0.0, 0.0]);
                }
            }
        });
        let at = |t: f64, name: &str| found[&format!("wheelset.{name}")][(t / 0.05).round() as usize];
        let radius = 3.0 / at(0.5, "pitchRate");
        println!(
            "{formulation}: {:.1e} m/s at 14 s, {:.6} at 20 s, {:.6} at 30 s; wheels {:.1e}, {:.6}, {:.6}; force at rest {:.3} N",
            at(14.0, "vx"),
            at(20.0, "vx"),
            at(30.0, "vx"),
            at(14.0, "pitchRate"),
            at(20.0, "pitchRate") * radius,
            at(30.0, "pitchRate") * radius,
            at(13.9, "drivingForce")
        );
        assert!(found.values().flatten().all(|value| value.is_finite()), "{formulation}");
        assert!(at(14.0, "vx").abs() < 1e-7 && at(14.0, "pitchRate").abs() < 1e-5, "{formulation}");
        for (t, speed) in [(20.0, 2.0), (30.0, -1.5)] {
            assert!((at(t, "vx") - speed).abs() < 1e-3 && (at(t, "pitchRate") * radius - speed).abs() < 5e-3, "{formulation}: {t}");
        }
    }
    let mut simulation = start(&open("suspended_wheelset", &[PLAIN, &input(3.0, 0.5, 1.0)]));
    want(&mut simulation, [-3.0, 0.0, 0.0]);
    let error = simulation.advance(10.0).unwrap_err().to_string();
    println!("{error}");
    assert!(
        error.contains("the travelling speed has fallen to") && (simulation.time() - 2.95).abs() < 0.01,
        "{error} {}",
        simulation.time()
    );
    assert!(simulation.snapshot().unwrap().y.iter().all(|value| value.is_finite()));
}

/// What a scene may not say, where and why.
#[test]
fn prop_scenes_are_refused_with_a_reason() {
    let said = |change: &str| match load::open("suspended_wheelset", &[change.to_string()]) {
        Ok(_) => panic!("{change} was taken"),
        Err(error) => error.to_string(),
    };
    for (change, words) in [
        ("vehicle.speed={start=0}", "vehicle.speed.start: found 0, but creepages"),
        ("vehicle.speed={time_constant=1}", "vehicle.speed.start: is missing"),
        ("vehicle.speed={start=600}", "at most 500"),
        ("vehicle.speed={start=nan}", "vehicle.speed.start"),
        ("vehicle.speed={start=20,time_constant=0}", "vehicle.speed.time_constant: found 0"),
        ("vehicle.speed={start=20,largest_acceleration=-1}", "vehicle.speed.largest_acceleration: found -1"),
        ("vehicle.speed={start=20,time=1}", "vehicle.speed.time: unknown key"),
    ] {
        let said = said(change);
        assert!(said.contains(words), "{change}: {said}");
    }
    let changes = ["vehicle.speed={start=20}", "vehicle.travel=free"].map(String::from);
    let said = load::open("suspended_wheelset", &changes).map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("a speed that is an input") && said.contains("travel = \"imposed\""), "{said}");
}

/// A set point anew each millisecond restarts, and the run is that of an independent method with the same inputs. Each restart may leave what the tolerance allows of
/// a step: at 1e-6 the way is 5e-5 m off after a second, the speed up to 1e-4 m/s.
#[test]
fn equiv_a_speed_set_each_millisecond_is_followed() {
    let wanted = |t: f64| [20.0 + 0.3 * (3.0 * t).sin(), 0.9 * (3.0 * t).cos()];
    for (name, changes) in [("suspended_wheelset", vec!["track.deviation=[]"]), ("vehicle_manchester_1", vec![PLAIN, "vehicle.drive=all"])]
    {
        let mut work = Vec::new();
        let mut with = |method: &[&str]| {
            let scene = open(name, &[&changes[..], &[&input(20.0, 0.5, 3.0)], method].concat());
            drive(&scene, 1.0, 0.001, |simulation, t| {
                let [speed, slope] = wanted(t);
                want(simulation, [speed, 0.0, 0.0]);
                let place = place(simulation) + WANTED_RATE;
                simulation.set_input(place, slope, 0.0, 0.0);
                if t > 0.9995 {
                    work.push((simulation.statistics().steps, simulation.statistics().taken_up, simulation.statistics().restarts));
                }
            })
        };
        let reference = with(&["solver.integrator=dormand_prince", "solver.tolerance=1e-9"]);
        let found = with(&["solver.integrator=rosenbrock", "solver.tolerance=1e-8"]);
        println!("{name}: steps, changes taken up, restarts: {work:?}");
        assert!(work.iter().all(|(_, taken_up, restarts)| *taken_up == 0 && *restarts > 900), "{name}: {work:?}");
        for column in reference.keys().filter(|column| [".vx", ".y", ".distance"].iter().any(|end| column.ends_with(end))) {
            let apart = largest_difference(&reference[column], &found[column]);
            println!("{name} {column}: {apart:.1e}");
            assert!(apart < 5e-6, "{name} {column}: {apart:e}");
        }
    }
}
