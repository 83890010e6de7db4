//! Cost of one contact, one right-hand side, one simulated second natively and through the C interface.
//!
//! `cargo bench` prints criterion's measurements and, before them, real-time factors at a stated accuracy and where the time of whole
//! runs goes. Times depend on the machine; nothing here is asserted.

#[path = "common/aims.rs"]
mod aims;

use aims::{Aim, Measured};
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::{Duration, Instant};
use wheelrail::contact::creep::RollingContact;
use wheelrail::contact::creepage::in_rolling_direction;
use wheelrail::contact::search::algebraic::{Pair, SurfaceParameters};
use wheelrail::fmi::ffi::host::LoadedFmu;
use wheelrail::fmi::{libraries, package, uri};
use wheelrail::formulation::Evaluation;
use wheelrail::geometry::Side;
use wheelrail::scene::load;
use wheelrail::sim::Simulation;
use wheelrail::sim::recording::Times;
use wheelrail::study::shares::shares;

const SCENE: &str = "suspended_wheelset";

fn simulation(changes: &[&str]) -> Simulation {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    let scene = load::open(SCENE, &changes).unwrap_or_else(|error| panic!("{error}"));
    Simulation::new(&scene, 0.0).unwrap_or_else(|error| panic!("{error}"))
}

/// Lateral displacement every 10 ms over 5 s.
fn displacement(simulation: &mut Simulation) -> Vec<f64> {
    (1..=500)
        .map(|i| {
            simulation.advance(0.01 * f64::from(i)).unwrap_or_else(|error| panic!("{error}"));
            simulation.snapshot().unwrap_or_else(|error| panic!("{error}")).y[1]
        })
        .collect()
}

/// Best of several runs of 5 s without outputs, s per simulated second, and the slowest one over the best.
fn cost(changes: &[&str]) -> (f64, f64) {
    let (mut best, mut worst) = (f64::INFINITY, 0.0f64);
    for _ in 0..7 {
        let mut simulation = simulation(changes);
        let clock = Instant::now();
        simulation.advance(5.0).unwrap_or_else(|error| panic!("{error}"));
        let seconds = clock.elapsed().as_secs_f64() / 5.0;
        (best, worst) = (best.min(seconds), worst.max(seconds));
    }
    (best, worst / best)
}

const AIMS: [Aim; 2] = [Aim { what: SCENE, factor: 500.0, error: 1e-6 }, Aim { what: SCENE, factor: 2000.0, error: 1e-4 }];

/// Error against a run at 1e-13 and real-time factor of several settings.
fn accuracy_table() {
    let reference = displacement(&mut simulation(&["solver.tolerance=1e-13"]));
    println!(
        "suspended_wheelset, 5 s: largest error of the lateral displacement (against tolerance 1e-13) and cost without outputs (best of 7); * = 1e-6 m or better"
    );
    let mut points = Vec::new();
    let settings: [&[&str]; 21] = [
        &["solver.integrator=rosenbrock", "solver.tolerance=3e-4"],
        &["solver.integrator=rosenbrock", "solver.tolerance=1e-4"],
        &["solver.integrator=rosenbrock", "solver.tolerance=3e-5"],
        &["solver.integrator=rosenbrock", "solver.tolerance=1e-5"],
        &["solver.integrator=rosenbrock", "solver.tolerance=1e-6"],
        &["solver.integrator=rosenbrock", "solver.tolerance=2e-7"],
        &["solver.integrator=rosenbrock", "solver.tolerance=1e-7"],
        &["solver.integrator=real_time", "solver.step=0.002"],
        &["solver.integrator=zhai", "solver.step=0.0005"],
        &["solver.tolerance=1e-6"],
        &["solver.tolerance=1e-7"],
        &["solver.tolerance=1e-8"],
        &["solver.tolerance=1e-10"],
        &["solver.tolerance=1e-12"],
        &["solver.integrator=rk43", "solver.tolerance=1e-7"],
        &["solver.integrator=rk43", "solver.tolerance=1e-8"],
        &["solver.integrator=rk43", "solver.tolerance=1e-9"],
        &["solver.integrator=rk43", "solver.tolerance=1e-10"],
        &["solver.integrator=rk4", "solver.step=0.002"],
        &["solver.integrator=rk4", "solver.step=0.001"],
        &["solver.integrator=rk4", "solver.step=0.0005"],
    ];
    for changes in settings {
        let found = displacement(&mut simulation(changes));
        let error = found.iter().zip(&reference).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let (cost, spread) = cost(changes);
        let value = |key: &str| changes.iter().find_map(|change| change.strip_prefix(key)).map(String::from);
        let integrator = value("solver.integrator=").unwrap_or("dormand_prince".into());
        let setting = value("solver.tolerance=").or(value("solver.step=")).unwrap_or_default();
        points.push(Measured { integrator, setting, error, factor: 1.0 / cost, spread });
        println!(
            "{} {:45} error {error:8.1e} m   {:6.2} ms per simulated second   {:4.0} times real time",
            if error <= 1e-6 { "*" } else { " " },
            changes.join(" "),
            1e3 * cost,
            1.0 / cost
        );
    }
    for aim in &AIMS {
        println!("{}", aim.words(&points));
    }
}

/// Scenes with their changes and simulated time, of which a whole run is divided.
const WHERE: [(&str, &[&str], f64); 4] = [
    (SCENE, &[], 5.0),
    (SCENE, &["solver.integrator=rosenbrock", "solver.tolerance=1e-6"], 5.0),
    (
        "vehicle_manchester_1",
        &[
            "track.deviation=[]",
            "track.irregularity=[{kind=\"spectrum\", spectrum=\"ore_b176_low\", seed=1, from=15, to=400, fade=5}]",
            "solver.tolerance=3e-5",
        ],
        3.0,
    ),
    ("vehicle_curve", &["vehicle.initial.distance=15", "solver.tolerance=3e-5"], 3.0),
];

/// Where the time of whole runs goes.
fn where_table() {
    for (name, changes, stop) in WHERE {
        let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
        let scene = load::open(name, &changes).unwrap_or_else(|error| panic!("{error}"));
        let span = Times { stop, step: scene.run.step };
        println!("{}", shares(&scene, span, 7).unwrap_or_else(|error| panic!("{error}")));
    }
}

const FORMULATIONS: [&str; 4] = ["ECF-A", "ECCF", "ACCF", "ECF-N"];

/// Cost of one right-hand side in the middle of the disturbance, s: best of several rounds.
fn cost_of_right_hand_side(formulation: &str) -> f64 {
    const CALLS: u32 = 2000;
    let mut simulation = simulation(&[&format!("contact.formulation={formulation}")]);
    simulation.advance(0.6).unwrap_or_else(|error| panic!("{error}"));
    let snapshot = simulation.snapshot().unwrap_or_else(|error| panic!("{error}")).clone();
    let model = simulation.model();
    let mut workspace = model.workspace();
    let (mut memory, mut dy) = (snapshot.memory().clone(), snapshot.dy.clone());
    // As far off as it is from stage to stage of a step: warm starts must not be exact.
    let mut y = snapshot.y.clone();
    let mut best = f64::INFINITY;
    for _ in 0..20 {
        let clock = Instant::now();
        for call in 0..CALLS {
            y[1] = snapshot.y[1] + if call % 2 == 0 { 1e-6 } else { 0.0 };
            let at = Evaluation { t: 0.6, inputs: snapshot.inputs(), y: black_box(&y), memory: &mut memory };
            model.derivative(&mut workspace, at, &mut dy).unwrap_or_else(|error| panic!("{error}"));
        }
        best = best.min(clock.elapsed().as_secs_f64() / f64::from(CALLS));
    }
    best
}

/// Each formulation's cost per right-hand side and per simulated second, and its error against itself at 1e-13.
fn formulation_table() {
    println!("formulations, scene {SCENE}, dormand_prince: cost per right-hand side; error of y, cost per simulated second (5 s)");
    let elastic = cost_of_right_hand_side(FORMULATIONS[0]);
    for formulation in FORMULATIONS {
        let one = cost_of_right_hand_side(formulation);
        let named = format!("contact.formulation={formulation}");
        // Jumps from node to node keep ECF-N from a tight tolerance.
        let (reference, tolerances) = match formulation {
            "ECF-N" => ("solver.tolerance=1e-10", &["1e-7", "1e-8"][..]),
            _ => ("solver.tolerance=1e-13", &["1e-7", "1e-8", "1e-10"][..]),
        };
        let reference = displacement(&mut simulation(&[&named, reference]));
        println!("  {formulation:6} {:6.2} us per right-hand side, {:.2} times ECF-A", 1e6 * one, one / elastic);
        for tolerance in tolerances {
            let changes = [named.as_str(), &format!("solver.tolerance={tolerance}")];
            let found = displacement(&mut simulation(&changes));
            let error = found.iter().zip(&reference).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let cost = cost(&changes).0;
            let per_second = 1e3 * cost;
            println!(
                "         tolerance {tolerance}: error {error:8.1e} m, {per_second:7.2} ms per simulated second, {:5.0} times real time",
                1.0 / cost
            );
        }
    }
}

/// The FMU's library as an instance in initialized state, and the folder that must outlive it.
fn loaded() -> Option<(tempfile::TempDir, std::path::PathBuf, String, String)> {
    let libraries = libraries::find(&[]).map_err(|error| println!("FMU part left out: {error}")).ok()?;
    let scene = load::open(SCENE, &[]).ok()?;
    let packed = package::pack_scene(&scene).ok()?;
    let folder = tempfile::tempdir().ok()?;
    for (name, content) in &packed.resources {
        std::fs::write(folder.path().join(name), content).ok()?;
    }
    let file = folder.path().join("fmu.so");
    std::fs::write(&file, &libraries[0].bytes).ok()?;
    let resources = uri::from_path(folder.path());
    Some((folder, file, packed.description.guid, resources))
}

/// Native against FMU at 10 ms and 1 ms, alternating so that the machine's noise hits both.
fn fmu_table() {
    let Some((_folder, file, guid, resources)) = loaded() else { return };
    println!("native against the C interface, 5 s, no outputs read (median of 15):");
    for step in [0.01, 0.001] {
        let count = (5.0f64 / step).round() as u32;
        let (mut native, mut through_c) = (Vec::new(), Vec::new());
        for _ in 0..15 {
            let mut simulation = simulation(&[]);
            let clock = Instant::now();
            for i in 1..=count {
                simulation.advance(step * f64::from(i)).unwrap_or_else(|error| panic!("{error}"));
            }
            native.push(clock.elapsed());
            let mut fmu = LoadedFmu::start(&file, &guid, &resources).unwrap_or_else(|error| panic!("{error}"));
            let clock = Instant::now();
            for i in 0..count {
                fmu.do_step(step * f64::from(i), step).unwrap_or_else(|error| panic!("{error}"));
            }
            through_c.push(clock.elapsed());
        }
        let median = |times: &mut Vec<Duration>| {
            times.sort();
            times[times.len() / 2].as_secs_f64() / 5.0
        };
        let (native, through_c) = (median(&mut native), median(&mut through_c));
        println!(
            "  every {:4.1} ms: native {:.2} ms, FMU {:.2} ms per simulated second ({:+.1} %)",
            1e3 * step,
            1e3 * native,
            1e3 * through_c,
            100.0 * (through_c / native - 1.0)
        );
    }
}

/// What one doStep costs beyond the core: steps so small that the integrator hardly moves, native against the C interface.
fn overhead() {
    let Some((_folder, file, guid, resources)) = loaded() else { return };
    const COUNT: u32 = 20_000;
    const STEP: f64 = 1e-7;
    let mut differences: Vec<f64> = (0..15)
        .map(|_| {
            let mut simulation = simulation(&[]);
            let clock = Instant::now();
            for i in 1..=COUNT {
                simulation.advance(STEP * f64::from(i)).unwrap_or_else(|error| panic!("{error}"));
            }
            let native = clock.elapsed().as_secs_f64();
            let mut fmu = LoadedFmu::start(&file, &guid, &resources).unwrap_or_else(|error| panic!("{error}"));
            let clock = Instant::now();
            for i in 0..COUNT {
                fmu.do_step(STEP * f64::from(i), STEP).unwrap_or_else(|error| panic!("{error}"));
            }
            (clock.elapsed().as_secs_f64() - native) / f64::from(COUNT)
        })
        .collect();
    differences.sort_by(f64::total_cmp);
    let median = differences[differences.len() / 2];
    println!(
        "one doStep beyond the core: {:.0} ns, {:.4} % of a communication step of 1 ms (median of 15)",
        1e9 * median,
        100.0 * median / 1e-3
    );
}

fn benchmarks(criterion: &mut Criterion) {
    accuracy_table();
    where_table();
    formulation_table();
    fmu_table();
    overhead();

    let mut simulation = simulation(&[]);
    // In the middle of the disturbance.
    simulation.advance(0.6).unwrap_or_else(|error| panic!("{error}"));
    let snapshot = simulation.snapshot().unwrap_or_else(|error| panic!("{error}")).clone();
    let model = simulation.model();
    let wheelset = &model.wheelsets[0];
    let motion = &snapshot.workspace.system.motions[0];
    let report = &snapshot.workspace.contacts[1];
    // A warm start as far off as it is from stage to stage of a step.
    let start = SurfaceParameters { rail: report.parameters.rail + 1e-6, wheel: report.parameters.wheel + 1e-5, ..report.parameters };
    criterion.bench_function("contact: search, Hertz and creep", |bencher| {
        bencher.iter(|| {
            let (wheel, rail) = (wheelset.wheel(Side::Right), model.track.rail(Side::Right));
            let (centre, axes) = (&motion.position, &motion.frame.axes);
            let found = Pair { wheel, rail, centre, axes, distance: centre.x }.locate(black_box(&start));
            let Ok(found) = found else { return None };
            let elastic = model.laws.normal.contact(&found.shape(wheel, rail), found.penetration).ok()?;
            Some(in_rolling_direction(40.0, report.creepage, |creepage| {
                let (patch, normal_force, friction) = (elastic.patch, elastic.force, model.laws.friction);
                model.laws.creep.force(&RollingContact { patch, normal_force, friction, creepage, speed: 40.0 })
            }))
        });
    });
    let mut workspace = model.workspace();
    let (mut memory, mut dy) = (snapshot.memory().clone(), snapshot.dy.clone());
    criterion.bench_function("right-hand side", |bencher| {
        bencher.iter(|| {
            let at = Evaluation { t: 0.6, inputs: snapshot.inputs(), y: black_box(&snapshot.y), memory: &mut memory };
            model.derivative(&mut workspace, at, &mut dy).is_ok()
        });
    });
    criterion.bench_function("one simulated second, native", |bencher| {
        let saved = self::simulation(&[]).state().clone();
        let mut simulation = self::simulation(&[]);
        bencher.iter(|| {
            simulation.restore(&saved);
            simulation.advance(1.0).is_ok()
        });
    });
}

criterion_group! {
    name = speed;
    config = Criterion::default().sample_size(50).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(3));
    targets = benchmarks
}
criterion_main!(speed);
