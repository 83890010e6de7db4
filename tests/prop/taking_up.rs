//! Inputs that a master changes at communication points, taken up by the step in hand.

use crate::scene_keys::open;
use cpu_time::ThreadTime;
use wheelrail::formulation::{DRIVE_TORQUE, LATERAL_FORCE, LEFT_FRICTION};
use wheelrail::scene::spec::Scene;
use wheelrail::sim::vehicle_outputs::scene_outputs;
use wheelrail::sim::{Simulation, SimulationState, serialized};
use wheelrail::solve::Statistics;

const STEP: f64 = 1e-3;

/// What a master sets at a time.
type Told = fn(&mut Simulation, u32, f64);

fn nothing(_: &mut Simulation, _: u32, _: f64) {}

fn lateral(simulation: &mut Simulation, _: u32, t: f64) {
    simulation.set_input(LATERAL_FORCE, 100.0 * (20.0 * t).sin(), 0.0, 0.0);
}

fn torque(simulation: &mut Simulation, _: u32, t: f64) {
    simulation.set_input(DRIVE_TORQUE, 400.0 * (2.0 * std::f64::consts::PI * t).sin(), 0.0, 0.0);
}

fn strong(simulation: &mut Simulation, _: u32, t: f64) {
    simulation.set_input(LATERAL_FORCE, 5e3 * (6.0 * t).sin(), 0.0, 0.0);
}

/// A friction factor that turns by rounding has the integration restarted each time.
fn restarting(simulation: &mut Simulation, i: u32) {
    simulation.set_input(LEFT_FRICTION, 1.0 + f64::EPSILON * f64::from(i % 2), 0.0, 0.0);
}

struct Run {
    /// y of wheelsets, Q and Y of wheels at each communication point.
    rows: Vec<[Vec<f64>; 3]>,
    statistics: Statistics,
    seconds: f64,
}

fn run(scene: &Scene, stop: f64, told: Told, restarts: bool) -> Run {
    let mut simulation = Simulation::new(scene, 0.0).unwrap();
    let outputs = scene_outputs(scene, simulation.model());
    let kinds = [".y", ".verticalForce", ".lateralForce"]
        .map(|end| outputs.iter().filter(|output| output.name.ends_with(end) && output.name.contains("wheelset")).collect::<Vec<_>>());
    assert!(kinds.iter().all(|kind| !kind.is_empty()));
    let (mut rows, mut seconds) = (Vec::new(), 0.0);
    for i in 0..(stop / STEP).round() as u32 {
        let clock = ThreadTime::now();
        told(&mut simulation, i, STEP * f64::from(i));
        if restarts {
            restarting(&mut simulation, i);
        }
        simulation.advance(STEP * f64::from(i + 1)).unwrap();
        seconds += clock.elapsed().as_secs_f64();
        let snapshot = simulation.snapshot().unwrap();
        rows.push(kinds.each_ref().map(|kind| kind.iter().map(|output| output.value(snapshot)).collect()));
    }
    Run { rows, statistics: simulation.statistics(), seconds }
}

fn apart(a: &Run, b: &Run) -> [f64; 3] {
    std::array::from_fn(|kind| {
        let both = a.rows.iter().zip(&b.rows).flat_map(|(a, b)| a[kind].iter().zip(&b[kind]));
        both.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    })
}

/// Scenes with their ends, s.
const SCENES: [(&str, &[&str], f64); 3] = [
    ("vehicle_manchester_1", &[], 0.7),
    ("vehicle_curve", &["vehicle.initial.distance=15"], 0.7),
    (
        "vehicle_manchester_1",
        &["track.deviation=[]", "track.irregularity=[{kind=\"spectrum\",spectrum=\"ore_b176_low\",seed=1,from=5,to=400,fade=2}]"],
        0.5,
    ),
];

/// Against an explicit method at 1e-9 that restarts at each change, every millisecond: results are as exact as those of a run that restarts too, or as the tolerance asks.
#[test]
fn equiv_inputs_that_are_taken_up_act_as_those_that_restart() {
    for (name, changes, stop) in SCENES {
        let scene = open(name, changes).unwrap();
        let exact = open(name, &[changes, &["solver.integrator=dormand_prince", "solver.tolerance=1e-9"]].concat()).unwrap();
        for (what, told) in [("lateral", lateral as Told), ("torque", torque), ("strong", strong)] {
            let [reference, own, plain] =
                [(&exact, false), (&scene, false), (&scene, true)].map(|(scene, restarts)| run(scene, stop, told, restarts));
            let [own_off, plain_off] = [&own, &plain].map(|run| apart(run, &reference));
            println!("{name} {what}: {own_off:.2?} taken up, {plain_off:.2?} restarting; {:?}, {:?}", own.statistics, plain.statistics);
            // Of a static wheel load of 50 kN and more a hundredth; of the tolerance as much as a run without inputs is off.
            for (off, (plain, allowed)) in own_off.iter().zip(plain_off.iter().zip([5e-6f64, 500.0, 100.0])) {
                assert!(*off < allowed.max(1.5 * plain), "{name} {what}: {off} {plain}");
            }
        }
    }
}

/// Work under inputs that change each millisecond, for 1.5 s: what restarting takes, and what is left of it. (A swing that inputs drive does not fade and is followed closely: 278 steps of the coach, 200 when tolerances alone counted; the curve's bolsters swing without damping at 6.8 Hz, 510.)
#[test]
fn regress_inputs_that_change_cost_no_step_each() {
    for (name, changes, told, most) in [
        ("vehicle_manchester_1", &[] as &[&str], lateral as Told, [300, 30, 1500]),
        ("vehicle_manchester_1", &[], torque, [200, 180, 1000]),
        ("vehicle_curve", &["vehicle.initial.distance=15"], lateral, [600, 90, 3100]),
        ("vehicle_curve", &["vehicle.initial.distance=15"], torque, [600, 170, 3100]),
    ] {
        let scene = open(name, changes).unwrap();
        let [alone, own, plain] =
            [(nothing as Told, false), (told, false), (told, true)].map(|(told, restarts)| run(&scene, 1.5, told, restarts));
        let (own_cost, plain_cost) = (own.seconds / alone.seconds, plain.seconds / alone.seconds);
        let Statistics { steps, restarts, evaluations, taken_up, .. } = own.statistics;
        println!("{name}: {own_cost:.1} times steps alone, {plain_cost:.1} where each change restarts; {:?}", own.statistics);
        assert!([steps, restarts, evaluations].iter().zip(most).all(|(count, most)| *count <= most), "{name}: {:?}", own.statistics);
        assert_eq!(restarts + taken_up, 1499, "{name}: every change counts once");
        assert!(plain.statistics.evaluations > 7000 && plain.statistics.restarts == 1499, "{:?}", plain.statistics);
    }
}

fn bits(simulation: &mut Simulation) -> Vec<u64> {
    let snapshot = simulation.snapshot().unwrap();
    snapshot.dy.iter().chain(&snapshot.y).map(|value| value.to_bits()).collect()
}

/// A state that was saved within a step that has taken changes up goes on to the same bits, in the run itself and in another one, through bytes too, and
/// whatever was looked at.
#[test]
fn prop_a_state_with_changes_taken_up_goes_on_the_same() {
    for (name, changes, stop) in SCENES {
        let scene = open(name, changes).unwrap();
        let start = || Simulation::new(&scene, 0.0).unwrap();
        let go_on = |simulation: &mut Simulation, from: u32| {
            for i in from..(0.6 * stop / STEP) as u32 {
                lateral(simulation, i, STEP * f64::from(i));
                simulation.advance(STEP * f64::from(i + 1)).unwrap();
            }
            bits(simulation)
        };
        let mut through = start();
        let (mut saved, mut looked) = (Vec::new(), start());
        for i in 0..(0.6 * stop / STEP) as u32 {
            for simulation in [&mut through, &mut looked] {
                lateral(simulation, i, STEP * f64::from(i));
            }
            looked.snapshot().unwrap();
            if i % 29 == 3 {
                saved.push((i, through.state().clone()));
            }
            for simulation in [&mut through, &mut looked] {
                simulation.advance(STEP * f64::from(i + 1)).unwrap();
            }
            looked.snapshot().unwrap();
        }
        assert!(looked.state() == through.state(), "{name}: looking changes nothing");
        let last = through.state().clone();
        assert!(last.integration.statistics.taken_up > 100, "{name}: {:?}", last.integration.statistics);
        let within = saved.iter().filter(|(_, state)| state.integration.has_taken_up()).count();
        assert!(within > 2, "{name}: {within} states within a step that has taken something up");
        let end = bits(&mut through);
        for (i, state) in &saved {
            let bytes = serialized::write("{00000000-0000-0000-0000-000000000000}", state).unwrap();
            let read: SimulationState = serialized::read("{00000000-0000-0000-0000-000000000000}", &bytes).unwrap();
            assert!(read == *state, "{name} {i}: bytes");
            let mut other = start();
            for simulation in [&mut other, &mut through] {
                assert!(simulation.restore(&read), "{name} {i}");
                assert!(go_on(simulation, *i) == end, "{name} from {i}: bits");
                assert!(*simulation.state() == last, "{name} from {i}: state");
            }
        }
    }
}

/// Once inputs rest, results do not depend on where a master looks, in a step that has taken changes up as in any other.
#[test]
fn prop_communication_steps_do_not_show_behind_changes() {
    for (name, changes, _) in SCENES {
        let scene = open(name, changes).unwrap();
        let mut coarse = Simulation::new(&scene, 0.0).unwrap();
        for i in 0..150 {
            lateral(&mut coarse, i, STEP * f64::from(i));
            coarse.advance(STEP * f64::from(i + 1)).unwrap();
        }
        assert!(coarse.statistics().taken_up > 50, "{name}");
        let mut fine = Simulation::new(&scene, 0.0).unwrap();
        assert!(fine.restore(coarse.state()));
        for i in 0..20 {
            for part in 1..=10 {
                fine.advance(0.15 + 0.01 * f64::from(i) + 0.001 * f64::from(part)).unwrap();
                bits(&mut fine);
            }
            let target = 0.15 + 0.01 * f64::from(i) + 0.01;
            fine.advance(target).unwrap();
            coarse.advance(target).unwrap();
            assert!(bits(&mut coarse) == bits(&mut fine), "{name} at {target}");
        }
    }
}

/// What the Jacobian does not know, or what changes contacts at once, restarts the integration as ever.
#[test]
fn prop_other_inputs_and_models_restart() {
    let turned = |name: &str, changes: &[&str], input: usize, value: f64| {
        let mut simulation = Simulation::new(&open(name, changes).unwrap(), 0.0).unwrap();
        simulation.advance(0.2004).unwrap();
        simulation.set_input(input, value, 0.0, 0.0);
        simulation.advance(0.2005).unwrap();
        let Statistics { restarts, taken_up, .. } = simulation.statistics();
        assert_eq!(restarts + taken_up, 1, "{name} {changes:?}");
        taken_up == 1
    };
    let coach = "vehicle_manchester_1";
    assert!(turned(coach, &[], LATERAL_FORCE, 1.0));
    assert!(!turned(coach, &[], LATERAL_FORCE, 1e5), "too much");
    assert!(!turned(coach, &[], LEFT_FRICTION, 0.999));
    for changes in [
        "contact.formulation=ECCF",
        "contact.formulation=ECF-N",
        "solver.integrator=imex",
        "solver.integrator=dormand_prince",
        "interface.outputs=[\"energy\"]",
        "contact.transient={below=2}",
    ] {
        assert!(!turned(coach, &[changes], LATERAL_FORCE, 1.0), "{changes}");
    }
}
