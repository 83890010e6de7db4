//! The motion that the track gives a vehicle: what implicit methods take for granted within a step, and what that is worth.

use crate::common::{run, start, table};
use wheelrail::formulation::{Evaluation, Model, Workspace};
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::sim::Simulation;
use wheelrail::sim::recording::{Recording, record};

const IRREGULAR: [&str; 2] =
    ["track.deviation=[]", "track.irregularity=[{kind=\"spectrum\", spectrum=\"ore_b176_low\", seed=1, from=15, to=400, fade=5}]"];

fn open(name: &str, changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    load::open(name, &changes).unwrap_or_else(|error| panic!("{error}"))
}

fn column(recording: &Recording, name: &str) -> Vec<f64> {
    recording.column(name).unwrap_or_else(|| panic!("no column {name}"))
}

struct Beside {
    /// Greatest rate of change of a wheelset's vertical acceleration, m/s3, where all bodies move along the track alone, straight on ..
    still: f64,
    /// .. and where they move as they are frame.
    left: f64,
    /// By how much J c' - c'' errs in that.
    missed: f64,
    /// The first and the last of them for rails that give way.
    rails: [f64; 2],
}

/// The model's evaluation beside the moving frame, f(y + c) - c', `ahead` [s] of a state.
fn beside(model: &Model, workspace: &mut Workspace, frame: &Workspace, simulation: &Simulation, ahead: f64) -> Vec<f64> {
    let integration = &simulation.state().integration;
    let (n, inputs, mut memory) = (integration.y.len(), model.neutral_inputs(), simulation.state().memories.accepted.clone());
    let (mut shift, mut rate, mut dy) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    model.frame_at(frame, ahead, &mut shift, &mut rate);
    let y: Vec<f64> = integration.y.iter().zip(&shift).map(|(y, c)| y + c).collect();
    let at = Evaluation { t: 0.0, inputs: &inputs, y: &y, memory: &mut memory };
    model.derivative(workspace, at, &mut dy).unwrap_or_else(|error| panic!("{error}"));
    dy.iter().zip(&rate).map(|(rate, frame)| rate - frame).collect()
}

fn measure(name: &str, changes: &[&str], until: f64) -> Beside {
    let scene = open(name, changes);
    let mut simulation = start(&scene);
    simulation.advance(until).unwrap_or_else(|error| panic!("{error}"));
    let (model, integration) = (simulation.model(), &simulation.state().integration);
    let (mut workspace, inputs) = (model.workspace(), model.neutral_inputs());
    model.prepare_tangent(&mut workspace);
    let (mut memory, n) = (simulation.state().memories.accepted.clone(), integration.y.len());
    let mut dy = vec![0.0; n];
    let at = Evaluation { t: 0.0, inputs: &inputs, y: &integration.y, memory: &mut memory };
    model.derivative(&mut workspace, at, &mut dy).unwrap_or_else(|error| panic!("{error}"));
    model.linearise(&mut workspace, (&integration.y, &memory), &inputs, true);
    let mut change = vec![0.0; n];
    model.frame_change(&workspace, &mut change);
    let mut other = model.workspace();
    const H: f64 = 1e-5;
    let (before, behind) = [-H, H].map(|ahead| beside(model, &mut other, &workspace, &simulation, ahead)).into();
    // The same with the bodies travelling on alone.
    let mut rolled = |ahead: f64| {
        let mut y = integration.y.clone();
        let count = 6 * model.system.bodies.len();
        for body in 0..model.system.bodies.len() {
            y[6 * body] += ahead * integration.y[count + 6 * body];
        }
        let (mut memory, mut dy) = (simulation.state().memories.accepted.clone(), vec![0.0; n]);
        let at = Evaluation { t: 0.0, inputs: &inputs, y: &y, memory: &mut memory };
        model.derivative(&mut other, at, &mut dy).unwrap_or_else(|error| panic!("{error}"));
        dy
    };
    let (slow, fast) = (rolled(-H), rolled(H));
    let count = 6 * model.system.bodies.len();
    let mut found = Beside { still: 0.0, left: 0.0, missed: 0.0, rails: [0.0; 2] };
    for wheelset in &model.wheelsets {
        let i = count + 6 * wheelset.body + 2;
        let slope = (behind[i] - before[i]) / (2.0 * H);
        found.still = found.still.max(((fast[i] - slow[i]) / (2.0 * H)).abs());
        found.left = found.left.max(slope.abs());
        found.missed = found.missed.max((slope - change[i]).abs());
    }
    for i in (0..model.contacts()).flat_map(|contact| model.rail_states(contact).skip(2)) {
        let slope = (behind[i] - before[i]) / (2.0 * H);
        found.rails[0] = found.rails[0].max(((fast[i] - slow[i]) / (2.0 * H)).abs());
        found.rails[1] = found.rails[1].max((slope - change[i]).abs());
    }
    if std::env::var_os("SHOW").is_some() {
        let mut rows: Vec<(f64, f64, f64, String)> = (0..count)
            .map(|k| {
                let i = count + k;
                let slope = (behind[i] - before[i]) / (2.0 * H);
                (slope - change[i], slope, change[i], format!("{} {}", model.system.bodies[k / 6].name, k % 6))
            })
            .collect();
        rows.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
        for (missed, slope, change, what) in rows.iter().take(16) {
            println!("  {what}: {slope:.2e}, J c' - c'' {change:.2e}, missed {missed:.2e}");
        }
    }
    println!(
        "{name} {changes:?} at {until} s: {:.1e} m/s3 for a body travelling on, {:.1e} beside the moving frame, of which J c' - c'' misses {:.1e}; rails {:?}",
        found.still, found.left, found.missed, found.rails
    );
    found
}

/// A wheel that travels on straight while its rail rises or bends away is pressed by its contact's stiffness; one that is frame is not.
#[test]
fn analytic_carried_wheels_stay_on_their_rails() {
    let vertical = IRREGULAR[1].replace("fade=5", "fade=5, quantities=[\"longitudinal_level\", \"cross_level\"]");
    let coach = ["solver.tolerance=1e-7", IRREGULAR[0], &vertical];
    let both = ["solver.tolerance=1e-7", IRREGULAR[0], IRREGULAR[1]];
    let yielding = ["solver.tolerance=1e-7", IRREGULAR[0], IRREGULAR[1], "track.flexibility=travelling"];
    for (name, changes, until, share) in [
        ("vehicle_manchester_1", &coach[..], 1.5, 0.02),
        ("vehicle_manchester_1", &both[..], 1.5, 0.1),
        ("vehicle_manchester_1", &both[..], 2.2, 0.1),
        ("vehicle_curve", &["solver.tolerance=1e-7"], 3.4, 0.02),
        ("vehicle_curve", &["solver.tolerance=1e-7"], 4.5, 0.02),
        ("vehicle_manchester_1", &yielding[..], 1.5, 0.1),
        ("vehicle_manchester_1", &yielding[..], 2.2, 0.1),
        ("vehicle_curve", &["solver.tolerance=1e-7", "track.flexibility=travelling"], 3.4, 0.02),
        ("vehicle_curve", &["solver.tolerance=1e-7", "track.flexibility=travelling"], 4.5, 0.02),
    ] {
        let found = measure(name, changes, until);
        assert!(found.still > 1e4, "the rails hardly move: {:e}", found.still);
        assert!(found.left < share * found.still && found.missed < 0.05 * found.still, "{name} at {until}");
        let [still, missed] = found.rails;
        let yields = changes.contains(&"track.flexibility=travelling");
        assert!(if yields { still > 1e4 && missed < 0.05 * still } else { still == 0.0 }, "{name} at {until}: rails {still:e}, {missed:e}");
    }
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / a.len() as f64).sqrt()
}

/// In a steady curve nothing changes; without the moving frame the outputs between the ends of steps waved by some 100 N.
#[test]
fn regress_wheel_loads_in_a_steady_curve_do_not_wave() {
    let exact = run(&open("vehicle_curve", &["solver.integrator=rosenbrock", "solver.tolerance=1e-7"]), 5.0, 1.25e-3);
    // At 4 ms a wheel that passes from one arc of its rail to the next at 2.64 s moves the load by more than a step may, and the run ends there.
    for solver in [["solver.integrator=real_time", "solver.step=3 ms"], ["solver.integrator=rosenbrock", "solver.tolerance=1e-5"]] {
        let found = run(&open("vehicle_curve", &solver), 5.0, 1.25e-3);
        for side in ["left", "right"] {
            let name = format!("truck[1].wheelset[1].{side}.verticalForce");
            let last = |recording| column(recording, &name)[3600..].to_vec();
            let (mine, true_load) = (last(&found), last(&exact));
            let waves = rms(&mine, &true_load);
            println!("{solver:?} {side}: {waves:.1} N rms in the last half second");
            assert!(waves < 25.0, "{solver:?} {side}: {waves}");
        }
    }
}

/// On irregular track the rails' rise and fall does not limit the step. Contact forces weigh in the error, and a step's end is checked: that
/// took 351 steps, with y within 2 um (before, 189 steps and 14 um).
#[test]
fn regress_irregular_track_takes_few_steps() {
    let changes = |tolerance| [IRREGULAR[0], IRREGULAR[1], "solver.integrator=rosenbrock", tolerance];
    let exact = run(&open("vehicle_manchester_1", &changes("solver.tolerance=1e-7")), 3.0, 5e-3);
    let scene = open("vehicle_manchester_1", &changes("solver.tolerance=3e-5"));
    let found = run(&scene, 3.0, 5e-3);
    let mut simulation = start(&scene);
    simulation.advance(3.0).unwrap_or_else(|error| panic!("{error}"));
    let statistics = simulation.statistics();
    let mut worst = 0.0f64;
    for name in ["truck[1].wheelset[1].y", "truck[1].wheelset[2].y", "truck[2].wheelset[1].y", "truck[2].wheelset[2].y"] {
        let (mine, exact) = (column(&found, name), column(&exact, name));
        worst = mine.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(worst, f64::max);
    }
    println!(
        "{} steps, {} rejected, {} evaluations; y within {worst:.1e} m",
        statistics.steps, statistics.rejected, statistics.evaluations
    );
    // 622 and 0.14 um: swings are followed by their own size too, bodies by their accelerations, which this tolerance alone would not ask for.
    assert!(statistics.steps < 660 && worst < 1e-6);
}

const CURVING: [&str; 4] = ["track.deviation=[]", "contact.patch=ellipse", "vehicle.speed=15", "vehicle.drive=leading"];

fn curved(radius: f64) -> String {
    format!("track.node=[{{distance=0, curvature={0}}}, {{distance=300, curvature={0}}}]", 1.0 / radius)
}

/// Flutter at 153 Hz, which steps at the limit of stability damp: 854 steps of `rk43` ran quietly. All methods follow it, and say so.
#[test]
fn hard_explicit_steps_do_not_hide_flutter() {
    let curve = curved(300.0);
    for method in ["dormand_prince", "rk43", "rosenbrock"].map(|name| format!("solver.integrator={name}")) {
        let scene = open("bogie", &[&CURVING[..], &["contact.friction=0.35", &curve, &method, "solver.tolerance=1e-6"]].concat());
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        let found = record(&mut simulation, &outputs, 1.5, 1e-3, |_| {}).unwrap_or_else(|error| panic!("{error}"));
        let largest = column(&found, "wheelset[1].right.verticalForce").into_iter().fold(0.0f64, f64::max);
        let notes = simulation.notes();
        println!("{method}: Q to {largest:.0} N in {} steps", simulation.statistics().steps);
        assert!(largest > 80e3 && notes.iter().any(|note| note.contains("flutters on its contacts")), "{method}: {largest} {notes:?}");
    }
}

/// Stages of explicit methods that leave the track along its tangent press wheels into rails; beside the motion along the track they don't. In this
/// curve that took 3809 (`dormand_prince`) and 11 245 steps (`rk43`), now 1056 and 863.
#[test]
fn regress_explicit_methods_take_curves_as_straight_track() {
    let scene = |curve: &str, method: &str, tolerance: &str| {
        open("bogie", &[&CURVING[..], &["contact.friction=0.2", curve, method, tolerance]].concat())
    };
    let (curve, straight) = (curved(300.0), curved(f64::INFINITY));
    let exact = run(&scene(&curve, "solver.integrator=dormand_prince", "solver.tolerance=1e-10"), 2.0, 1.3e-3);
    for method in ["dormand_prince", "rk43"].map(|name| format!("solver.integrator={name}")) {
        let [there, here] = [&curve, &straight].map(|track| {
            let mut simulation = start(&scene(track, &method, "solver.tolerance=1e-7"));
            simulation.advance(2.0).unwrap_or_else(|error| panic!("{error}"));
            simulation.statistics().steps
        });
        let found = run(&scene(&curve, &method, "solver.tolerance=1e-7"), 2.0, 1.3e-3);
        let mut worst = 0.0f64;
        for side in ["left", "right"] {
            let name = format!("wheelset[1].{side}.verticalForce");
            let (mine, exact) = (column(&found, &name), column(&exact, &name));
            worst = mine.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(worst, f64::max);
        }
        println!("{method}: {there} steps in the curve, {here} on straight track; Q within {worst:.2} N");
        assert!(10 * there <= 12 * here && worst < 5.0, "{method}: {there} steps for {here}, {worst} N");
    }
}
