//! A wheelset that flutters on its contacts is not hidden by long steps, and a run tells what its loads mean.

use crate::common::start;
use wheelrail::scene::load;
use wheelrail::sim::Simulation;

/// A coach into a curve of 150 m.
fn sharp_curve(friction: f64, more: &[&str]) -> Simulation {
    let track = "track.node=[{distance=0},{distance=30},{distance=80,curvature=0.006667},{distance=300,curvature=0.006667}]";
    let friction = format!("contact.friction={friction}");
    let changes: Vec<String> = [track, "vehicle.speed=11", &friction].iter().chain(more).map(|change| (*change).to_string()).collect();
    start(&load::open("vehicle_manchester_1", &changes).unwrap_or_else(|error| panic!("{error}")))
}

/// With steps of 25 ms the bouncing and rolling at 100 to 180 Hz faded away (`rosenbrock` at 1e-5 saw 38 kN at least), while every tight setting shows
/// wheels that leave the rails.
#[test]
fn hard_flutter_at_high_friction_is_not_damped_by_long_steps() {
    let mut simulation = sharp_curve(0.55, &["solver.integrator=rosenbrock", "solver.tolerance=1e-5"]);
    simulation.advance(3.9).unwrap();
    let notes = simulation.notes();
    println!("{notes:#?}, {:?}", simulation.statistics());
    assert!(notes.iter().any(|note| note.contains("flutters on its contacts")), "{notes:?}");
    assert!(notes.iter().any(|note| note.contains("below 10 %")), "{notes:?}");
}

/// Friction of 0.35 leaves the same coach at rest, with steps as long as ever.
#[test]
fn prop_nothing_is_told_of_a_quiet_run() {
    let mut simulation = sharp_curve(0.35, &["solver.integrator=rosenbrock", "solver.tolerance=1e-5"]);
    simulation.advance(3.9).unwrap();
    let (notes, steps) = (simulation.notes(), simulation.statistics().steps);
    assert!(notes.is_empty() && steps < 400, "{steps} {notes:?}");
}

/// Steps of a fixed length can't follow: the run ends with that, or tells it.
#[test]
fn hard_fixed_steps_do_not_hide_a_flutter() {
    for step in ["0.5 ms", "2 ms", "5 ms"] {
        let mut simulation = sharp_curve(0.55, &[&format!("solver={{integrator=\"real_time\",step=\"{step}\"}}")]);
        let ended = simulation.advance(4.5);
        let notes = simulation.notes();
        println!("{step}: {ended:?} {notes:#?}");
        assert!(ended.is_err() || notes.iter().any(|note| note.contains("flutters") && note.contains("fixed length")), "{step}: {notes:?}");
    }
}

/// A swing that unloads no wheel is told too: the second wheelset of a tram in a curve of 50 m has its left wheel on tread and flange, whose ellipses pass its load on to each
/// other; it swings by three quarters of the static load and never falls below 70 % of it.
#[test]
fn hard_a_swing_that_unloads_no_wheel_is_told() {
    let tram = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/scenes/tram_independent_wheels.toml");
    let run = |friction: &str| {
        let changes = ["contact.patch=ellipse".to_string(), format!("contact.friction={friction}")];
        let mut simulation = start(&load::open(&tram.display().to_string(), &changes).unwrap_or_else(|error| panic!("{error}")));
        simulation.advance(5.0).unwrap();
        simulation.notes()
    };
    let notes = run("0.5");
    println!("{notes:#?}");
    let note = notes.iter().find(|note| note.contains("truck[1].wheelset[2], left wheel: its load swings by up to ")).expect("no note");
    let hertz: f64 = note.split(" up and down, at ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap().parse().unwrap();
    assert!((145.0..165.0).contains(&hertz), "{note}");
    assert!(run("0.3").is_empty());
}
