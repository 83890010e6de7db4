//! Instructions of one right-hand side, counted by valgrind: what a change costs shows on any machine.
//!
//! What a scene names but what does not act is held to what it may cost, in per cent of a run (`tests/data/not_acting.txt`).
//!
//! `tests/data/instructions.csv` keeps the counts. A test fails where one leaves its number by more than 2 % (15 % with another
//! compiler, C library or processor than the file names): a change for the worse is to be looked into, one for the better to be written down.

use std::hint::black_box;
use std::process::Command;
use wheelrail::formulation::memory::ModelMemory;
use wheelrail::formulation::{Evaluation, Model, Workspace};
use wheelrail::scene::load;
use wheelrail::sim::outputs::Output;
use wheelrail::sim::vehicle_outputs::scene_outputs;
use wheelrail::sim::{Simulation, Snapshot, recording};
use wheelrail::study::shares::anatomy::Sample;
use wheelrail::study::shares::counted::Counted;

/// Stages of the Dormand-Prince method as shares of a step, whose length is typical for these scenes, s.
const STAGES: [f64; 6] = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
const STEP: f64 = 2e-3;
const STEPS: usize = 4;

/// Length of a run that is counted, s.
const RUN: f64 = 0.5;
/// Time between two looks at outputs, s.
const LOOKS: f64 = 5e-3;

/// Where the worker finds what to run: scene, time and changes, parted by blanks.
const CASE: &str = "WHEELRAIL_INSTRUCTIONS";

/// Evaluations as they follow each other along the motion, each step from the same state.
#[inline(never)]
fn counted_right_hand_sides(
    model: &Model,
    workspace: &mut Workspace,
    snapshot: &Snapshot,
    memory: &mut ModelMemory,
    y: &mut [f64],
    dy: &mut [f64],
) {
    for _ in 0..STEPS {
        memory.clone_from(snapshot.memory());
        for share in STAGES {
            for (y, (before, rate)) in y.iter_mut().zip(snapshot.y.iter().zip(&snapshot.dy)) {
                *y = before + share * STEP * rate;
            }
            let at = Evaluation { t: 0.0, inputs: snapshot.inputs(), y: black_box(&*y), memory };
            model.derivative(workspace, at, dy).unwrap();
        }
    }
}

/// Jacobians at one state, whose evaluation the workspace holds.
#[inline(never)]
fn counted_jacobians(model: &Model, workspace: &mut Workspace, snapshot: &Snapshot, memory: &ModelMemory) {
    for _ in 0..STEPS * STAGES.len() {
        model.linearise(workspace, (black_box(&snapshot.y), memory), snapshot.inputs(), true);
    }
}

/// A run goes on.
#[inline(never)]
fn counted_run(simulation: &mut Simulation, until: f64) {
    simulation.advance(until).unwrap();
}

/// The same with a look at the scene's outputs every few milliseconds.
#[inline(never)]
fn counted_recorded_run(simulation: &mut Simulation, outputs: &[Output], until: f64) {
    recording::record(simulation, outputs, until, LOOKS, |_| ()).unwrap();
}

/// What valgrind runs; not a test of its own.
#[test]
#[ignore = "run by the others"]
fn worker() {
    let case = std::env::var(CASE).unwrap();
    let mut words = case.split(' ');
    let (counted, scene, time) = (words.next().unwrap(), words.next().unwrap(), words.next().unwrap().parse().unwrap());
    let changes: Vec<String> = words.filter(|word| !word.is_empty()).map(String::from).collect();
    let scene = load::open(scene, &changes).unwrap();
    let mut simulation = Simulation::new(&scene, 0.0).unwrap();
    simulation.advance(time).unwrap();
    if counted == "run" {
        return counted_run(&mut simulation, time + RUN);
    }
    if counted == "recorded" {
        let outputs = scene_outputs(&scene, simulation.model());
        return counted_recorded_run(&mut simulation, &outputs, time + RUN);
    }
    let snapshot = simulation.snapshot().unwrap().clone();
    let model = simulation.model();
    let (mut workspace, mut memory) = (model.workspace(), snapshot.memory().clone());
    let (mut y, mut dy) = (snapshot.y.clone(), snapshot.dy.clone());
    if counted == "jacobian" {
        model.prepare_tangent(&mut workspace);
        let at = Evaluation { t: 0.0, inputs: snapshot.inputs(), y: &y, memory: &mut memory };
        model.derivative(&mut workspace, at, &mut dy).unwrap();
        return counted_jacobians(model, &mut workspace, &snapshot, &memory);
    }
    let mut best = f64::INFINITY;
    for _ in 0..std::env::var("WHEELRAIL_ROUNDS").map_or(1, |rounds| rounds.parse().unwrap()) {
        let clock = std::time::Instant::now();
        counted_right_hand_sides(model, &mut workspace, &snapshot, &mut memory, &mut y, &mut dy);
        best = best.min(clock.elapsed().as_secs_f64());
    }
    println!("{:.2} us", 1e6 * best / (STEPS * STAGES.len()) as f64);
}

/// Instructions of one right-hand side or Jacobian.
fn count(case: &str) -> f64 {
    let found = Command::new("valgrind")
        .args(["--tool=callgrind", "--collect-atstart=no", "--toggle-collect=*counted_*", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().unwrap())
        .args(["--ignored", "--exact", "worker"])
        .env(CASE, case)
        .output()
        .unwrap();
    let messages = String::from_utf8_lossy(&found.stderr);
    assert!(found.status.success(), "{case}: {messages}");
    let collected = messages.lines().find_map(|line| line.split("Collected : ").nth(1)).unwrap_or_else(|| panic!("{messages}"));
    collected.trim().parse::<f64>().unwrap() / (STEPS * STAGES.len()) as f64
}

/// Can instructions be counted here?
fn counts() -> bool {
    if cfg!(debug_assertions) {
        println!("left out: counts are those of a release build");
        return false;
    }
    if Command::new("valgrind").arg("--version").output().is_err() {
        assert!(std::env::var_os("WHEELRAIL_REQUIRE_VALGRIND").is_none(), "valgrind is required here but not installed");
        println!("left out: valgrind is not installed");
        return false;
    }
    true
}

fn table(name: &str) -> String {
    std::fs::read_to_string(format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// What `wheelrail plan` counts, against whole evaluations under valgrind.
#[test]
fn validate_counted_pieces_add_up_to_the_instructions_of_an_evaluation() {
    if !counts() {
        return;
    }
    let mut wrong = Vec::new();
    for (scene, time, changes, allowed) in [
        ("suspended_wheelset", 0.6, "", 0.25),
        ("wheelset_s1002", 0.6, "contact.patch=linear", 0.25),
        ("wheelset_s1002", 0.6, "contact.patch=ellipse", 0.25),
        ("wheelset_s1002", 0.6, "contact.patch=ellipse contact.creep.law=fastsim", 0.25),
        ("wheelset_s1002", 0.6, "contact.formulation=ECF-N contact.patch=ellipse", 0.4),
        ("vehicle_manchester_1", 0.2, "", 0.25),
        ("vehicle_manchester_1", 0.2, "contact.patch=table", 0.25),
        ("vehicle_manchester_1", 0.2, "contact.formulation=ECCF", 0.25),
        ("vehicle_curve", 3.0, "contact.patch=ellipse", 0.25),
        ("vehicle_curve", 3.0, "", 0.4),
    ] {
        let overrides: Vec<String> = changes.split(' ').filter(|change| !change.is_empty()).map(String::from).collect();
        let scene_read = load::open(scene, &overrides).unwrap();
        let mut simulation = Simulation::new(&scene_read, 0.0).unwrap();
        simulation.advance(time).unwrap();
        let sample = Sample::behind(&simulation.snapshot().unwrap().clone(), 6 * simulation.model().system.bodies.len(), STEP);
        let told = Counted::of(simulation.model(), &sample, &scene_read.contact.creep_name).unwrap();
        let again = Counted::of(simulation.model(), &sample, &scene_read.contact.creep_name).unwrap();
        let found = count(&format!("right_hand_side {scene} {time} {changes}"));
        let off = told.whole() / found - 1.0;
        println!("{scene} {changes}: told {:.0} of {found:.0} instructions: {:+.1} %; {:?}", told.whole(), 100.0 * off, told.parts);
        if off.abs() > allowed || told != again {
            wrong.push(format!("{scene} {changes}: {:+.1} %", 100.0 * off));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("; "));
}

/// What a scene names but what does nothing yet, or never, costs next to nothing: half a second with it against one without.
#[test]
fn prop_what_does_not_act_is_not_paid_for() {
    if !counts() {
        return;
    }
    let file = table("not_acting.txt");
    let mut wrong = Vec::new();
    let (mut without, mut of) = (0.0, "");
    for line in file.lines().filter(|line| !line.starts_with('#')) {
        let [scene, effect, allowed] = line.split(" | ").collect::<Vec<_>>().try_into().unwrap();
        if scene != of {
            (without, of) = (count(&format!("run {scene}")), scene);
        }
        let more = count(&format!("run {scene} {effect}")) / without - 1.0;
        println!("{scene} {effect}: {:+.2} %, allowed {allowed} %", 100.0 * more);
        if 100.0 * more > allowed.parse::<f64>().unwrap() {
            wrong.push(format!("{scene} {effect}: {:+.2} %", 100.0 * more));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("; "));
}

/// Outputs cost what is read: none nothing, those of a car no contact.
#[test]
fn prop_outputs_that_nobody_asked_for_are_not_paid_for() {
    if !counts() {
        return;
    }
    let more =
        |scene: &str, groups: &str| count(&format!("recorded {scene} interface.outputs=[{groups}]")) / count(&format!("run {scene}")) - 1.0;
    let (wheelset, coach) = ("suspended_wheelset 0.1 track.deviation=[]", "vehicle_manchester_1 0.1");
    let all = more(coach, "\"motion\",\"wheels\",\"contacts\"");
    for (scene, groups, allowed) in [(wheelset, "", 0.03), (coach, "", 0.03), (coach, "\"bodies\",\"sensors\"", 0.3 * all)] {
        let found = more(scene, groups);
        println!("{scene} [{groups}]: {:+.2} %, all {:+.2} %", 100.0 * found, 100.0 * all);
        assert!(found < allowed, "{scene} [{groups}]: {found}, all {all}");
    }
}

#[test]
fn regress_instructions_of_one_right_hand_side_and_jacobian() {
    if !counts() {
        return;
    }
    let file = table("instructions.csv");
    // Mathematical functions of the C library have other variants on other processors.
    let first_line = |program: &str| Command::new(program).arg("--version").output().map(|found| found.stdout).unwrap_or_default();
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).lines().next().unwrap_or_default().trim().to_string();
    let processor = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let processor = processor.lines().find(|line| line.starts_with("model name")).unwrap_or_default().replace('\t', "");
    let here = [text(first_line("rustc")), text(first_line("ldd")), processor];
    println!("{here:?}");
    let same = here.iter().all(|part| file.lines().any(|line| line.strip_prefix("# ") == Some(part)));
    let allowed = if same { 0.02 } else { 0.15 };
    let mut wrong = Vec::new();
    for line in file.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let [counted, scene, time, changes, kept] = line.split(',').collect::<Vec<_>>().try_into().unwrap();
        let found = count(&format!("{counted} {scene} {time} {changes}"));
        let change = found / kept.parse::<f64>().unwrap() - 1.0;
        println!("{counted} {scene} {changes}: {found:.0} instructions, kept {kept}, {:+.2} %", 100.0 * change);
        if change.abs() > allowed {
            wrong.push(format!("{counted} {scene} {changes}: {found:.0} instead of {kept}"));
        }
    }
    assert!(wrong.is_empty(), "{}; if that is meant, write it into tests/data/instructions.csv", wrong.join("; "));
}
