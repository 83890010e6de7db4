//! Against the IVP Test Set's problem "Wheelset": the crate's constraint solver, projection and integrator on a published
//! index-2 problem.

mod fixed_point;
mod model;
mod motion;

use model::Wheelset;
use motion::{MEMORY, MULTIPLIERS, Motion};
use nalgebra::{Vector2, Vector6};
use std::path::Path;
use std::time::Instant;
use toml_edit::{DocumentMut, Item};
use wheelrail::solve::{DormandPrince, Integrator, Scratch, Statistics};

/// The test set's multipliers are scaled.
const SCALE: f64 = 1e4;
const NAMES: [&str; 15] = ["x", "y", "z", "theta", "phi", "x'", "y'", "z'", "theta'", "phi'", "beta'", "psiL", "xiL", "psiR", "xiR"];
const X: usize = 0;
const THETA: usize = 3;

struct Problem {
    data: DocumentMut,
    wheelset: Wheelset,
}

/// Values in the test set's order as ours: q, q', memory.
struct Values {
    q: Vector6<f64>,
    v: Vector6<f64>,
    memory: [f64; MEMORY],
}

impl Problem {
    fn read() -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/ivp_wheelset.toml");
        let data: DocumentMut = std::fs::read_to_string(path).unwrap().parse().unwrap();
        let wheelset = Wheelset::new(data["parameters"].as_table().unwrap());
        Problem { data, wheelset }
    }

    fn values(&self, section: &str) -> Values {
        let y = numbers(&self.data[section]["y"]);
        let multipliers = [-SCALE * y[16], -SCALE * y[15]];
        Values {
            q: Vector6::new(y[0], y[1], y[2], y[3], y[4], 0.0),
            v: Vector6::from_column_slice(&y[5..11]),
            memory: [y[11], y[12], y[13], y[14], multipliers[0], multipliers[1]],
        }
    }

    fn number(&self, section: &str, key: &str) -> f64 {
        let item = &self.data[section][key];
        item.as_float().or_else(|| item.as_integer().map(|integer| integer as f64)).unwrap()
    }

    /// Gaps of the initial values.
    fn gaps(&self) -> [f64; 2] {
        let Values { q, memory, .. } = self.values("initial");
        [0, 2].map(|i| self.wheelset.touch(&q, &Vector2::new(memory[i], memory[i + 1])).gap)
    }
}

fn numbers(item: &Item) -> Vec<f64> {
    item.as_array().unwrap().iter().map(|value| value.as_float().unwrap()).collect()
}

/// Number of leading digits that agree.
fn digits(found: f64, published: f64) -> f64 {
    -((found - published) / published).abs().max(1e-16).log10()
}

#[test]
fn validate_ivp_wheelset_accelerations_with_the_published_multipliers() {
    let problem = Problem::read();
    let Values { q, v, memory } = problem.values("initial");
    let mut force = problem.wheelset.applied(&q, &v);
    for i in 0..2 {
        let contact = Vector2::new(memory[2 * i], memory[2 * i + 1]);
        let mut found = contact;
        problem.wheelset.find_contact(&q, &mut found).unwrap();
        assert!((found - contact).norm() < 1e-15, "contact {i}: found {found}, published {contact}");
        let multiplier = memory[MULTIPLIERS + i];
        let touch = problem.wheelset.touch(&q, &contact);
        let rolling = problem.wheelset.rolling(&q, &v, &contact, &touch);
        force += problem.wheelset.creep(&rolling, &touch, multiplier) - touch.row * multiplier;
    }
    let accelerations = problem.wheelset.mobility(q[4]) * force;
    let published = numbers(&problem.data["initial"]["accelerations"]);
    for (found, published) in accelerations.iter().zip(&published) {
        let digits = digits(*found, *published);
        println!("{found:22.16} {published:22.16} {digits:5.1} digits");
        // Yaw: 11.5, for the factor cos phi that the published equation lacks.
        assert!(digits > 11.3, "{found} instead of {published}");
    }
}

#[test]
fn validate_ivp_wheelset_multipliers_from_the_constraints() {
    // The initial multipliers are published with 5 digits (and miss the constraint on accelerations by so much); those at the end belong to
    // a state that is consistent.
    let problem = Problem::read();
    for (section, required) in [("initial", 4.5), ("reference", 8.0)] {
        let Values { q, v, memory } = problem.values(section);
        let mut found = memory;
        found[MULTIPLIERS..].fill(80.0);
        Motion::new(&problem.wheelset, problem.gaps(), 0.0).accelerations(&q, &v, &mut found).unwrap();
        for (found, published) in found[MULTIPLIERS..].iter().zip(&memory[MULTIPLIERS..]) {
            let digits = digits(*found, *published);
            println!("{section:>10}: {found:.9} N, published {published:.9} N, {digits:.1} digits");
            assert!(digits > required, "{section}: {found} instead of {published}");
        }
    }
}

struct Run {
    /// In the test set's order.
    y: [f64; 15],
    statistics: Statistics,
    creep_evaluations: u64,
    seconds: f64,
    drift: [f64; 2],
    violation: [f64; 2],
}

fn integrate(problem: &Problem, tolerance: f64) -> Run {
    let end = problem.number("reference", "time");
    let Values { q, v, memory } = problem.values("initial");
    let mut motion = Motion::new(&problem.wheelset, problem.gaps(), end);
    let method = DormandPrince { tolerance };
    let mut scratch = Scratch::new(12, 0);
    let start: Vec<f64> = q.iter().chain(&v).copied().collect();
    (motion.memory, motion.accepted) = (memory, memory);
    let mut state = method.start(0.0, &start);
    let clock = Instant::now();
    method.advance(&mut motion, &mut state, &mut scratch, end).unwrap();
    let seconds = clock.elapsed().as_secs_f64();
    assert!(state.t == end, "the last step ends at the end");
    let violation = motion.violation(&state.y, &mut motion.accepted.clone()).unwrap();
    let y = std::array::from_fn(|i| match i {
        0..5 => state.y[i],
        5..11 => state.y[i + 1],
        _ => motion.accepted[i - 11],
    });
    let Motion { drift, creep_evaluations, .. } = motion;
    Run { y, statistics: state.statistics, creep_evaluations, seconds, drift, violation }
}

#[test]
fn validate_ivp_wheelset_ten_seconds() {
    let problem = Problem::read();
    let published = numbers(&problem.data["reference"]["y"]);
    let independent = ["x", "theta"].map(|key| problem.number("independent", key));
    println!("matching digits with the published end values (DASSL at 1e-9), and with an independent Radau IIA run (last two columns)");
    println!(
        "tolerance   steps rejected evaluations creep evaluations      s {}  | x theta",
        NAMES.map(|name| format!("{name:>6}")).join("")
    );
    let mut last = None;
    for tolerance in [1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13] {
        let run = integrate(&problem, tolerance);
        let digits: Vec<f64> = run.y.iter().zip(&published).map(|(found, published)| self::digits(*found, *published)).collect();
        let own = [self::digits(run.y[X], independent[0]), self::digits(run.y[THETA], independent[1])];
        let Statistics { steps, rejected, evaluations, .. } = run.statistics;
        println!(
            "{tolerance:9.0e} {steps:7} {rejected:8} {evaluations:11} {:17} {:6.2} {}  | {:.1} {:.1}",
            run.creep_evaluations,
            run.seconds,
            digits.iter().map(|digits| format!("{digits:6.1}")).collect::<String>(),
            own[0],
            own[1]
        );
        last = Some((run, digits, own));
    }
    let reference = |key: &str| problem.number("reference", key);
    println!(
        "    DASSL {:7} {:8} {:11} (and {} Jacobians): the published run",
        reference("accepted"),
        reference("steps") - reference("accepted"),
        reference("evaluations"),
        reference("jacobians")
    );
    println!(
        "  Rodas5P {:7} steps at 1e-10 with a frozen mass matrix (SciML): x {:.1}, theta {:.1} digits",
        problem.number("frozen", "steps"),
        digits(problem.number("frozen", "x"), published[X]),
        digits(problem.number("frozen", "theta"), published[THETA])
    );

    let (run, digits, own) = last.unwrap();
    println!("x = {:.12e} m, theta = {:.12e} rad", run.y[X], run.y[THETA]);
    println!(
        "constraints at the end: {:.1e} m, {:.1e} m/s; largest drift that projection met: {:.1e} m, {:.1e} m/s",
        run.violation[0], run.violation[1], run.drift[0], run.drift[1]
    );
    assert!(digits[X] > 6.0 && digits[THETA] > 6.0, "x {:.1}, theta {:.1} digits", digits[X], digits[THETA]);
    // What the published y and rates themselves carry, as the independent run confirms.
    for (name, digits) in NAMES.iter().zip(&digits) {
        assert!(*digits > 5.0, "{name}: {digits:.1} digits");
    }
    assert!(own[0] > 7.0 && own[1] > 7.0, "independent run: x {:.1}, theta {:.1} digits", own[0], own[1]);
    assert!(run.violation[0] < 1e-15 && run.violation[1] < 1e-15);
}
