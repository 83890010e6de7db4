//! Scenes: embedded ones and those of the tests, with wanted changes and mutations.

use super::mutate::{self, Random};
use super::run::{self, Case};
use std::path::{Path, PathBuf};
use wheelrail::scene::load::{self, SceneError};
use wheelrail::scene::{assemble, embedded, plan};
use wheelrail::settings::Source;
use wheelrail::sim::Simulation;
use wheelrail::sim::vehicle_outputs::scene_outputs;

/// Processor time, s, for reading a scene (mutated in any way), and for starting one that could be read.
pub const READING: f64 = 2.0;
const STARTING: f64 = 20.0;
/// How far it is then run, s: a step of a fixed length, and few enough of an explicit method's where numbers make a stiff vehicle.
const AHEAD: f64 = 1e-6;

/// What scenes may also say; the mutations go over it too.
const CHANGES: &[&str] = &[
    "contact.formulation=ACCF",
    "contact.formulation=ECCF",
    "contact.formulation=ECF-A",
    "contact.formulation=ECF-N",
    "contact.node_spacing=0.0005",
    "contact.on_lift=elastic",
    "contact.points=4",
    "contact.friction=0.3",
    "contact.transient={below=2, time_floor=0.002, damping_time=5e-5}",
    "contact.creep={law=\"kalker_linear\"}",
    "contact.creep={law=\"polach\", surface=\"dry\", friction_ratio=0.4, friction_decay=0.6}",
    "contact.creep={law=\"fastsim\", strips=20, cells=20}",
    "contact.creep={law=\"fastrip\", strips=20, cells=20}",
    "contact.creep={law=\"usetab\"}",
    "contact.creep={law=\"exact\", grid=9, tolerance=1e-4}",
    "contact.normal={law=\"hertz\", curvature=\"patch\", conformal=\"error\"}",
    "contact.normal={law=\"hertz\", curvature=\"point\", conformal=\"bounded\"}",
    "contact.normal={law=\"assumed\", stiffness=1e11, axis_ratio=1.5}",
    "contact.damping_law={kind=\"hunt_crossley\", restitution=0.5, impact_speed=0.1}",
    "solver.integrator=rosenbrock",
    "solver.integrator=auto",
    "solver.integrator=zhai",
    "solver.integrator=real_time",
    "solver.step=0.001",
    "solver.tolerance=1e-5",
    "vehicle.speed=20",
    "vehicle.travel=free",
    "vehicle.gravity=9.81",
    "vehicle.detail=wheelset",
    "vehicle.point_masses=[\"coach[2]\"]",
    "vehicle.detail=truck",
    "vehicle.detail=vehicle",
    "vehicle.initial.distance=100",
    "vehicle.initial.y=0.002",
    "vehicle.initial.from_equilibrium=false",
    "vehicle.place[coach].count=2",
    "track.rail={kind=\"arc\", radius=0.3}",
    "track.rail={kind=\"60e2\"}",
    "track.left_rail={kind=\"uic60\"}",
    "track.gauge=1.435",
    "track.gauge_depth=0.014",
    "track.inclination=0.025",
    "track.grade=0.01",
    "track.smoothing=10",
    "track.superelevation_about=low_rail",
    "track.node=[{distance=100}, {distance=200, radius=500, superelevation=\"0.1 m\", grade=0.01}, {distance=900, radius=500}]",
    "track.node=[{distance=-500, radius=600, superelevation=\"0.1 m\"}, {distance=900, radius=600, superelevation=\"0.1 m\"}]",
    "track.deviation=[{rail=\"both\", direction=\"lateral\", shape=\"ramp\", amplitude=0.005, from=10, to=20}]",
    "track.deviation=[{rail=\"left\", direction=\"vertical\", shape=\"haversine\", amplitude=0.005, from=10, to=20}]",
    "track.irregularity=[{kind=\"spectrum\", spectrum=\"fra4\", seed=1, from=60, to=275, fade=3, shortest=1.5, longest=50, scale=0.5}]",
    "track.irregularity=[{kind=\"spectrum\", spectrum=\"ore_b176_low\", seed=1, from=-60, to=2e4}]",
    "interface.outputs=[\"motion\", \"wheels\", \"sliding_means\"]",
    "interface.inputs=[\"rail_motion\"]",
    "run.stop=5",
    "run.step=0.01",
];

pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/scenes")
}

/// Name, text and folder of every scene to begin with.
fn seeds() -> Vec<(String, String, Option<PathBuf>)> {
    let mut all: Vec<_> = embedded::SCENES.iter().map(|scene| (scene.name.to_string(), scene.text.to_string(), None)).collect();
    let mut own: Vec<PathBuf> = std::fs::read_dir(folder()).unwrap().map(|entry| entry.unwrap().path()).collect();
    own.sort();
    all.extend(own.iter().map(|path| {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        (name, std::fs::read_to_string(path).unwrap(), Some(folder()))
    }));
    all
}

/// What a reader's error must say.
fn check(error: &SceneError) {
    let text = error.to_string();
    assert!(text.len() > 20 && !text.contains("panicked"), "SPEECHLESS: {text}");
    if let SceneError::Settings(error) = error {
        assert!(!error.file.is_empty() && !error.problem.is_empty(), "SPEECHLESS: {text}");
    }
}

/// Reads a scene; if that can be done, plans and starts it and runs it a little. Returns what came of it.
pub fn try_scene(case: &mut Case, name: &str, text: &str, folder: Option<PathBuf>, changes: &[String]) -> &'static str {
    case.begin();
    let source = Source { file: format!("{name}.toml"), text: text.into(), overridden: vec![], folder };
    let scene = match load::read(name, source, changes) {
        Ok(scene) => scene,
        Err(error) => {
            check(&error);
            case.within(READING, &format!("refusing it ({error})"));
            return "refused";
        }
    };
    // Whoever asks for the exact theory on a fine grid waits for it, and is told so.
    let law = (scene.contact.creep)(scene.contact.material).describe();
    let cells = law.strip_prefix(" on ").and_then(|law| law.split(' ').next()?.parse::<usize>().ok());
    if law.contains("s a call") && cells.is_none_or(|cells| cells > 16) {
        return "slow by request";
    }
    case.within(READING, "reading it");
    case.begin();
    let model = match assemble::model(&scene) {
        Ok(model) => model,
        Err(error) => panic!("{error}: not said when it was read"),
    };
    let planned = plan::plan(&scene, &model);
    assert!(planned.notes.iter().all(|note| !note.contains("NaN")), "{:?}", planned.notes);
    case.within(READING, "planning it");
    case.begin();
    let started = Simulation::new(&scene, 0.0);
    let words = started.as_ref().err().map(ToString::to_string).unwrap_or_default();
    case.within(STARTING, &format!("starting it ({words})"));
    let Ok(mut simulation) = started else {
        assert!(words.len() > 10 && !words.contains("NaN"), "SPEECHLESS: {words}");
        return "not started";
    };
    let outputs = scene_outputs(&scene, simulation.model());
    let check = |simulation: &mut Simulation| {
        let Ok(snapshot) = simulation.snapshot() else { return };
        for output in &outputs {
            let value = output.value(snapshot);
            assert!(value.is_finite(), "{} is {value} at t = {} s", output.name, snapshot.time);
        }
    };
    check(&mut simulation);
    case.begin();
    if let Err(error) = simulation.advance(scene.run.step.min(AHEAD)) {
        let words = error.to_string();
        case.within(STARTING, &format!("failing ({words})"));
        assert!(words.len() > 10 && !words.contains("NaN"), "SPEECHLESS: {words}");
        return "failed";
    }
    case.within(STARTING, "a first step");
    check(&mut simulation);
    "ran"
}

#[test]
fn prop_any_scene_is_read_and_started_or_refused() {
    let seeds = seeds();
    let mut counts = std::collections::BTreeMap::new();
    run::each("scenes", 150, |random: &mut Random, case| {
        // Short ones more often: they are quicker.
        let (mut at, other) = (random.below(seeds.len()), random.below(seeds.len()));
        if seeds[other].1.len() < seeds[at].1.len() {
            at = other;
        }
        let (name, text, folder) = &seeds[at];
        let mut text = text.clone();
        let mut changes: Vec<String> = (0..random.below(4)).map(|_| (*random.of(CHANGES)).to_string()).collect();
        for change in &mut changes {
            if random.once_in(3) {
                *change = mutate::text(random, change);
            }
        }
        for _ in 0..random.below(3) {
            text = mutate::text(random, &text);
        }
        case.text = format!("{name} {changes:?}\n{text}");
        run::now("scenes", &case.text);
        *counts.entry(try_scene(case, name, &text, folder.clone(), &changes)).or_insert(0) += 1;
    });
    println!("{counts:?}");
}
