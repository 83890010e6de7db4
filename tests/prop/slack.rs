//! Trains whose couplers have slack: where they start, and what their couplers carry.

use wheelrail::formulation::Model;
use wheelrail::mbs::body::COORDINATES;
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::settings::Source;
use wheelrail::sim::{Simulation, statics};

/// Coaches of the Manchester benchmarks with 30 mm of slack between them.
const TRAIN: &str = r#"
name = "slack"
[vehicle]
template = "free"
speed = 20.0
travel = "free"
[vehicle.module.coach]
template = "vehicle_manchester_1"
[[vehicle.module.coach.force]]
name = "load"
kind = "external_load"
on = { body = "car", at = [0.0, 0.0, 1.8] }
[[vehicle.place]]
name = "coach"
module = "coach"
position = [0.0, 0.0, 0.0]
count = 3
spacing = [-26.0, 0.0, 0.0]
[[vehicle.place.between]]
name = "coupler"
kind = "coupler"
from = { body = "car", at = [-12.5, 0.0, 1.0] }
to = { body = "car", at = [12.5, 0.0, 1.0] }
slack = "30 mm"
draw_stiffness = 5.0e6
buffer_stiffness = 10.0e6
damping = 0.5
[track]
gauge = "1435 mm"
inclination = "1:40"
[track.rail]
kind = "60e1"
[contact]
formulation = "ECF-A"
friction = 0.35
damping = 2.0e9
patch = "ellipse"
[contact.material]
youngs_modulus = 2.1e11
poisson_ratio = 0.28
[contact.creep]
law = "shen_hedrick_elkins"
[interface]
outputs = ["motion", "forces"]
inputs = ["elements"]
[run]
stop = 8.0
step = "2 ms"
"#;

fn scene(changes: &[String]) -> Scene {
    let source = Source { file: "slack.toml".into(), text: TRAIN.into(), overridden: vec![], folder: None };
    load::read("slack", source, changes).unwrap_or_else(|error| panic!("{error}"))
}

/// Force [N] and displacement [m] of each coupler in the balance that a run begins with.
fn couplers(scene: &Scene) -> Vec<(f64, f64)> {
    let mut simulation = Simulation::new(scene, 0.0).unwrap_or_else(|error| panic!("{error}"));
    let statics = statics::statics(scene, &mut simulation).unwrap();
    statics.elements.iter().filter(|row| row.name.starts_with("coupler")).map(|row| (row.force, row.displacement)).collect()
}

/// On a grade a train that its leading wheelset pulls has each coupler carry the coaches behind it. Newton's method knew no stiffness in the middle of the slack and gave up from
/// five coaches on: "nothing holds coach[6].car along x".
#[test]
fn prop_trains_with_slack_start_whatever_their_length() {
    for (count, grade) in [(2, 0.01), (6, 0.01), (6, -0.01), (9, 0.01), (6, 0.0)] {
        let changes = [
            "vehicle.travel=imposed".to_string(),
            "vehicle.drive=leading".into(),
            format!("vehicle.place[coach].count={count}"),
            format!("track.grade={grade:?}"),
        ];
        let found = couplers(&scene(&changes));
        assert_eq!(found.len(), count - 1);
        // Weight of a coach along the grade; rolling asks for 20 N each.
        let last = found[count - 2].0;
        for (k, (force, displacement)) in found.iter().enumerate() {
            let behind = (count - 1 - k) as f64;
            println!("{count} coaches, grade {grade}: coupler {k} {force:.1} N, {:.3} mm", 1e3 * displacement);
            assert!((force / last - behind).abs() < 1e-3 * behind, "{count} {grade}: {force} of {last}");
            let stiffness = if *force > 0.0 { 5e6 } else { 10e6 };
            let expected = 0.015f64.copysign(*force) + force / stiffness;
            assert!((displacement - expected).abs() < 1e-6, "{displacement} {expected}");
        }
        let of_coach = 44_482.0 * 9.81 * grade / f64::sqrt(1.0 + grade * grade);
        assert!((last - of_coach).abs() < 40.0, "{last} {of_coach}");
    }
}

/// The same where running resistance strains the couplers, and where coaches are points of mass.
#[test]
fn prop_trains_with_slack_start_under_unlike_forces() {
    let points = "vehicle.point_masses=[\"coach[2]\",\"coach[3]\",\"coach[4]\"]".to_string();
    for grade in ["0.001", "-0.01", "0.02"] {
        let changes = [points.clone(), "vehicle.place[coach].count=4".into(), format!("track.grade={grade}")];
        for (force, displacement) in couplers(&scene(&changes)) {
            println!("grade {grade}: {force:.1} N, {:.3} mm", 1e3 * displacement);
            // All roll down alike.
            assert!(force.abs() < 100.0 && displacement.abs() < 0.0151, "{grade}: {force} {displacement}");
        }
    }
}

/// A wagon that is pushed uphill by the one behind it: the wheelset with the imposed speed, the third, stands where the scene puts it, and it is the others that move by
/// the slack.
#[test]
fn prop_slack_moves_no_wheelset_with_an_imposed_speed() {
    let mut text = String::from(
        "name = \"pushed\"\n[vehicle]\ntemplate = \"free\"\nspeed = 10.0\ndrive = \"leading\"\n[vehicle.wheel_profile]\nkind = \"s1002\"\nradius = 0.46\n",
    );
    for (name, x) in [("front", 0.0), ("rear", -14.0)] {
        text += &format!(
            "[[vehicle.body]]\nname = \"{name}\"\nmass = 20000.0\ninertia_xx = 24000.0\ninertia_yy = 180000.0\ninertia_zz = 180000.0\n\
             position = [{x:?}, 0.0, 1.4]\n"
        );
        for (axle, ahead) in [(1, 3.0), (2, -3.0)] {
            let at: f64 = x + ahead;
            text += &format!(
                "[[vehicle.wheelset]]\nname = \"{name}_axle[{axle}]\"\nx = {at:?}\nmass = 1400.0\ninertia_xx = 900.0\ninertia_yy = 120.0\n\
                 inertia_zz = 900.0\ntread_circle_distance = 1.5\ndriven = {}\n[[vehicle.force]]\nname = \"{name}_primary[{axle}]\"\n\
                 kind = \"bushing\"\nmirrored = true\nfrom = \"{name}\"\nto = \"{name}_axle[{axle}]\"\nat = [{at:?}, 1.0, 0.46]\n\
                 stiffness = [8e6, 4e6, 1.5e6]\ndamping = [2e4, 2e4, 2e4]\npreload = \"static\"\n",
                name == "rear"
            );
        }
    }
    text += "[[vehicle.force]]\nname = \"coupler\"\nkind = \"coupler\"\nfrom = { body = \"front\", at = [-6.5, 0.0, 1.0] }\nto = { body = \"rear\", at = [-7.5, 0.0, 1.0] }\n\
             slack = \"30 mm\"\ndraw_stiffness = 5e6\nbuffer_stiffness = 10e6\n[track]\ngauge = \"1435 mm\"\ninclination = \"1:40\"\ngrade = 0.01\n\
             rail = { kind = \"60e1\" }\n[contact]\nformulation = \"ECF-A\"\nfriction = 0.35\nmaterial = { youngs_modulus = 2.1e11, poisson_ratio = 0.28 }\n\
             creep = { law = \"polach\" }\n[run]\nstop = 1.0\nstep = \"10 ms\"\n";
    let source = Source { file: "pushed.toml".into(), text, overridden: vec![], folder: None };
    let scene = load::read("pushed", source, &[]).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = Simulation::new(&scene, 0.0).unwrap_or_else(|error| panic!("{error}"));
    let drives: Vec<usize> = simulation.model().system.drives.iter().map(|drive| drive.body).collect();
    let y = simulation.snapshot().unwrap().y.clone();
    let forward = |body: usize| y[COORDINATES * body] - scene.vehicle.design_position(body).x;
    let [front, rear] = [0, 2].map(forward);
    println!("driven {drives:?}: front wagon {front:.6} m, rear {rear:.3e} m");
    assert!(drives == [2] && rear.abs() < 1e-9 && (0.014..0.017).contains(&-front), "{drives:?} {front} {rear}");
}

/// Forces of both couplers each 2 ms, N, of three coaches that are braked one after the other and then pulled by the first one.
fn braked(tolerance: &str, integrator: &str) -> Vec<[f64; 2]> {
    let changes = [format!("solver.tolerance={tolerance}"), format!("solver.integrator={integrator}")];
    let scene = scene(&changes);
    let mut simulation = Simulation::new(&scene, 0.0).unwrap_or_else(|error| panic!("{error}"));
    let loads: Vec<usize> = {
        let model: &Model = simulation.model();
        let mut first = model.first_element_input();
        let inputs = model.system.forces.iter().map(|force| {
            let own = first;
            first += force.inputs().len();
            (force.name().ends_with("load"), own)
        });
        inputs.filter(|(is_load, _)| *is_load).map(|(_, own)| own).collect()
    };
    assert_eq!(loads.len(), 3);
    let mut forces = Vec::new();
    // From when on, s, which coach, from what, to what, N, in 0.3 s.
    let ramps = [
        (0.5, 0, 0.0, -40e3),
        (0.8, 1, 0.0, -40e3),
        (1.1, 2, 0.0, -40e3),
        (3.0, 0, -40e3, 60e3),
        (3.1, 1, -40e3, 0.0),
        (3.2, 2, -40e3, 0.0),
    ];
    for k in 0..3500 {
        let t = 2e-3 * f64::from(k);
        for (from, coach, first, last) in ramps {
            if (t - from).abs() < 1e-6 {
                simulation.set_input(loads[coach], first, (last - first) / 0.3, 0.0);
            } else if (t - from - 0.3).abs() < 1e-6 {
                simulation.set_input(loads[coach], last, 0.0, 0.0);
            }
        }
        simulation.advance(2e-3 * f64::from(k + 1)).unwrap();
        let rows = statics::statics(&scene, &mut simulation).unwrap().elements;
        let of = |name: &str| rows.iter().find(|row| row.name == name).map_or(f64::NAN, |row| row.force);
        forces.push([of("coupler[1]"), of("coupler[2]")]);
    }
    forces
}

/// An error of a speed is an error of the next strike's force, and each strike hands it on: coupler forces of 90 kN were off by 45 kN at the default tolerance.
#[test]
fn hard_coupler_forces_are_right_at_the_default_tolerance() {
    let right = braked("1e-8", "dormand_prince");
    let largest = right.iter().flatten().fold(0.0, |most: f64, force| most.max(force.abs()));
    for integrator in ["rosenbrock", "imex"] {
        let found = braked("1e-5", integrator);
        let off = |k: usize| (0..2).map(|i| (found[k][i] - right[k][i]).abs()).fold(0.0, f64::max);
        let off = (0..right.len()).map(off).fold(0.0, f64::max);
        println!("{integrator}: off by {:.2} kN of {:.1}", 1e-3 * off, 1e-3 * largest);
        assert!(largest > 5e4 && off < 0.05 * largest, "{integrator}: {off} of {largest}");
    }
}

/// Wagons of unlike mass that roll on level track: couplers hold a newton or less, a tenth of a micrometre beyond their slack.
const ROLLING: &str = r#"
name = "rolling"
[vehicle]
template = "free"
speed = 5.0
travel = "free"
[vehicle.wheel_profile]
kind = "s1002"
radius = 0.46
[vehicle.module.heavy]
[[vehicle.module.heavy.body]]
name = "car"
mass = 30000.0
inertia_xx = 36000.0
inertia_yy = 180000.0
inertia_zz = 180000.0
position = [0.0, 0.0, 1.6]
WHEELSETS
[vehicle.module.light]
[[vehicle.module.light.body]]
name = "car"
mass = 12000.0
inertia_xx = 14400.0
inertia_yy = 72000.0
inertia_zz = 72000.0
position = [0.0, 0.0, 1.6]
WHEELSETS
PLACES
[track]
gauge = "1435 mm"
inclination = "1:40"
[track.rail]
kind = "60e1"
[contact]
formulation = "ECF-A"
friction = 0.35
patch = "ellipse"
[contact.material]
youngs_modulus = 2.1e11
poisson_ratio = 0.28
[contact.creep]
law = "shen_hedrick_elkins"
[interface]
outputs = ["motion", "forces"]
[run]
stop = 1.0
step = "2 ms"
"#;

/// Wagons with a spring rate of their primary suspension [N/m], the second one light.
fn rolling(stiffness: f64, height: f64) -> String {
    let mut places = String::new();
    for (k, module) in ["heavy", "light", "heavy", "heavy"].iter().enumerate() {
        let at = -10.0 * k as f64;
        places += &format!("[[vehicle.place]]\nname = \"v{k}\"\nmodule = \"{module}\"\nposition = [{at:?}, 0.0, 0.0]\n");
        if k > 0 {
            let (from, to, slack, before) = (at + 5.5, at + 4.5, [10, 5, 10][k - 1], k - 1);
            places += &format!(
                "[[vehicle.force]]\nname = \"coupler{k}\"\nkind = \"coupler\"\nfrom = {{ body = \"v{before}.car\", at = [{from:?}, 0.0, 1.0] }}\n\
                 to = {{ body = \"v{k}.car\", at = [{to:?}, 0.0, {height:?}] }}\nslack = \"{slack} mm\"\ndraw_stiffness = 2e6\nbuffer_stiffness = 8e6\n"
            );
        }
    }
    ROLLING
        .split("WHEELSETS")
        .zip(["heavy", "light", ""])
        .map(|(text, module)| {
            let axle = |(axle, at): (i32, f64)| {
                format!(
                    "[[vehicle.module.{module}.wheelset]]\nname = \"wheelset[{axle}]\"\nx = {at:?}\nmass = 1500.0\ninertia_xx = 800.0\ninertia_yy = 120.0\n\
                     inertia_zz = 800.0\ntread_circle_distance = 1.5\n[[vehicle.module.{module}.force]]\nname = \"primary[{axle}]\"\nkind = \"bushing\"\n\
                     mirrored = true\nfrom = \"car\"\nto = \"wheelset[{axle}]\"\nat = [{at:?}, 1.0, 0.46]\nstiffness = [8e6, 3e6, {stiffness:?}]\n\
                     damping = [3e4, 3e4, 2.5e4]\npreload = \"static\"\n"
                )
            };
            let axles = if module.is_empty() { String::new() } else { [(1, 2.5), (2, -2.5)].map(axle).concat() };
            format!("{text}{axles}")
        })
        .collect::<String>()
        .replace("PLACES", &places)
}

/// Differences of 1 um went over the end of the slack and told nothing of what holds a vehicle ("nothing holds v1.car along x"); and where a coupler was inclined, vehicles that
/// were moved by its free travel stood short of its end.
#[test]
fn prop_trains_start_that_hang_together_by_a_newton() {
    for (speed, height) in [(5.0, 1.0), (5.5, 1.0), (6.0, 1.0), (8.0, 1.0), (5.0, 1.15), (20.0, 1.15)] {
        let source = Source { file: "rolling.toml".into(), text: rolling(1e6, height), overridden: vec![], folder: None };
        let scene = load::read("rolling", source, &[format!("vehicle.speed={speed:?}")]).unwrap_or_else(|error| panic!("{error}"));
        for ((force, displacement), half) in couplers(&scene).into_iter().zip([5e-3f64, 2.5e-3, 5e-3]) {
            println!("{speed} m/s: {force:.3} N, {:.5} mm", 1e3 * displacement);
            assert!(force.abs() < 20.0);
            let expected = half.copysign(force) + force / if force > 0.0 { 2e6 } else { 8e6 };
            assert!(force.abs() < 1e-3 || (displacement - expected).abs() < 1e-9, "{displacement} {expected}");
        }
    }
}
