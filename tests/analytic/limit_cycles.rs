//! Limit cycles: the continuation against a system whose motions are known, those of a wheelset against plain runs.

use crate::common;
use std::f64::consts::{FRAC_1_SQRT_2, TAU};
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::study::cycles::branch::{Reach, between, follow};
use wheelrail::study::cycles::corrector::{correct, cycle};
use wheelrail::study::cycles::slopes::Condition;
use wheelrail::study::cycles::{Flow, Lost, Turn, fold};
use wheelrail::study::hunting::settle::Outcome;
use wheelrail::study::hunting::{Diagram, Progress, diagram};
use wheelrail::study::modes;

/// The normal form of a Hopf bifurcation that is subcritical, its motions held by a term of fifth order (Kuznetsov, Elements of Applied Bifurcation Theory, section 8.3), with a third
/// state that follows:
///
/// ```text
/// r' = r (p + r^2 - r^4),   phi' = 6 + r^2,   w' = -3 w + x^2
/// ```
///
/// Its motions have `p = r^4 - r^2`, the period `2 pi / (6 + r^2)` and the multiplier `exp((2 r^2 - 4 r^4) T)`; they turn round at `r^2 = 1/2, p = -1/4`.
struct NormalForm;

impl NormalForm {
    fn rates(p: f64, [x, y, w]: [f64; 3]) -> [f64; 3] {
        let square = x * x + y * y;
        let (grow, turn) = (p + square - square * square, 6.0 + square);
        [grow * x - turn * y, grow * y + turn * x, x * x - 3.0 * w]
    }

    /// A step of the classical Runge-Kutta method.
    fn step(p: f64, state: [f64; 3], h: f64) -> [f64; 3] {
        let beside = |k: [f64; 3], part: f64| std::array::from_fn(|i| state[i] + part * h * k[i]);
        let first = Self::rates(p, state);
        let second = Self::rates(p, beside(first, 0.5));
        let third = Self::rates(p, beside(second, 0.5));
        let fourth = Self::rates(p, beside(third, 1.0));
        std::array::from_fn(|i| state[i] + h / 6.0 * (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]))
    }
}

impl Flow for NormalForm {
    /// The section is y = 0, x > 0; a place on it is (x, w).
    fn turn(&self, p: f64, from: &[f64]) -> Result<Turn, Lost> {
        const STEP: f64 = 1.0 / 400.0;
        let mut state = [from[0], 0.0, from[1]];
        let (mut time, mut most, mut least) = (0.0, from[0], from[0]);
        loop {
            let next = Self::step(p, state, STEP);
            if time > 0.5 && state[1] < 0.0 && next[1] >= 0.0 {
                let (mut low, mut high) = (0.0, STEP);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if Self::step(p, state, middle)[1] < 0.0 { low = middle } else { high = middle }
                }
                let end = Self::step(p, state, high);
                most = most.max(end[0]);
                return Ok(Turn { to: vec![end[0], end[2]], period: time + high, swings: vec![0.5 * (most - least)] });
            }
            (most, least) = (most.max(next[0]), least.min(next[0]));
            state = next;
            time += STEP;
            if !(time < 10.0 && next[0].abs() < 10.0) {
                return Err(Lost::NoReturn);
            }
        }
    }

    fn unit(&self) -> f64 {
        0.5
    }

    fn error(&self) -> f64 {
        1e-8
    }
}

#[test]
fn analytic_branch_of_a_normal_form_with_both_ends_of_its_bistable_range() {
    let flow = NormalForm;
    let guess = vec![0.1, 0.0, 0.0];
    let direction = vec![1.0, 0.0, 0.0];
    let found = correct(&flow, &guess, &Condition::across(direction.clone(), &guess), None, 1e-8).unwrap();
    let start = cycle(&flow, &found, &direction).unwrap();
    assert!((start.parameter - (1e-4 - 1e-2)).abs() < 1e-5, "{}", start.parameter);
    let reach = Reach { parameters: -1.0..1.0, step: 0.05, shortest: 1e-3, longest: 0.15, swings: 0.01..2.0, most: 60 };
    let branch = follow(&flow, start, &reach, &|_| {});
    assert!(branch.cycles.last().unwrap().parameter > 1.0);
    for cycle in &branch.cycles {
        let square = cycle.place[0] * cycle.place[0];
        let period = TAU / (6.0 + square);
        // That of the radius, or the third state's where it is larger.
        let multiplier = ((2.0 * square - 4.0 * square * square) * period).exp().max((-3.0 * period).exp());
        assert!((cycle.parameter - (square * square - square)).abs() < 2e-3 * square, "{square}: {}", cycle.parameter);
        assert!((cycle.period / period - 1.0).abs() < 1e-4);
        assert!(
            (cycle.multipliers[0].re - multiplier).abs() < 5e-3 + 0.02 * (multiplier - 1.0).abs(),
            "{square}: {multiplier} {}",
            cycle.multipliers[0]
        );
        assert!((multiplier - 1.0).abs() < 0.02 || cycle.is_stable() == (square > 0.5));
    }
    let folds: Vec<_> = branch.cycles.windows(3).filter(|trio| fold::turns(trio)).collect();
    assert_eq!(folds.len(), 1);
    let turning = fold::find(&flow, folds[0], 1e-4).unwrap();
    println!("fold at {:.6} +- {:.1e}, radius {:.4}", turning.cycle.parameter, turning.bracket, turning.cycle.place[0]);
    assert!(turning.least && (turning.cycle.parameter + 0.25).abs() < turning.bracket + 1e-5 && turning.bracket < 1e-4);
    assert!((turning.cycle.place[0] - FRAC_1_SQRT_2).abs() < 0.02);
    // Two motions at p = -0.1.
    let at = branch.cycles.windows(2).filter(|pair| (pair[0].parameter + 0.1) * (pair[1].parameter + 0.1) < 0.0);
    let radii: Vec<f64> = at.map(|pair| between(&flow, &pair[0], &pair[1], -0.1).unwrap().place[0]).collect();
    let wanted = [-1.0, 1.0].map(|sign: f64| (0.5 * (1.0 + sign * 0.6f64.sqrt())).sqrt());
    println!("{radii:?} {wanted:?}");
    assert!(radii.len() == 2 && radii.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-4 * b));
}

struct Silent;

impl Progress for Silent {
    fn speed(&self) {}
    fn motion(&self, _: f64, _: f64) {}
}

fn wheelset(speed: f64) -> Scene {
    let ellipse = "contact.patch=\"ellipse\"";
    let changes = [ellipse, "solver.integrator=rosenbrock", "solver.tolerance=1e-6", "track.deviation=[]"].map(String::from);
    let mut changes = changes.to_vec();
    changes.push(format!("vehicle.speed={speed}"));
    load::open("wheelset_s1002", &changes).unwrap_or_else(|error| panic!("{error}"))
}

/// Half the swing of a plain run that begins with a lateral displacement [m], over the last tenth of `stop` [s].
fn plain(speed: f64, begin: f64, stop: f64) -> f64 {
    let mut scene = modes::undisturbed(&wheelset(speed), speed).unwrap();
    scene.vehicle.initial.values[1] = begin;
    let mut simulation = common::start(&scene);
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    let steps = (stop * 1000.0) as usize;
    for k in 1..=steps {
        simulation.advance(k as f64 * 1e-3).unwrap();
        if 10 * k > 9 * steps {
            let y = simulation.solution()[1];
            (least, most) = (least.min(y), most.max(y));
        }
    }
    0.5 * (most - least)
}

fn found() -> Diagram {
    diagram(&wheelset(44.0), &[30.0, 36.0, 42.0, 48.0], &Silent).unwrap_or_else(|error| panic!("{error}"))
}

/// The fold of S1002 on 60E1: long runs just above it keep what they begin with, just below they die; small motions come down to the linear critical
/// speed; and stable motions are those of plain runs.
#[test]
fn equiv_limit_cycles_of_a_wheelset_are_those_of_plain_runs() {
    let found = found();
    println!("{:?} {:?}", found.begin, found.end);
    for turning in &found.turnings {
        println!("{:?} {} {} {:?}", turning.speed, turning.lowest, turning.stable, turning.motion.swings);
    }
    found.motions.iter().for_each(|motion| println!("{motion:?}"));
    found.runs.iter().for_each(|run| println!("{run:?}"));
    let (linear, begin) = (found.linear().unwrap(), found.begin.unwrap());
    assert!((begin.value - linear.speed).abs() < begin.bound + 0.05, "{begin:?} {}", linear.speed);
    let fold = found.fold().unwrap();
    assert!(fold.speed.bound < 0.1 && fold.speed.value < linear.speed);
    let swing = fold.motion.swings[0];
    let (above, below) = (1.01 * fold.speed.value, 0.99 * fold.speed.value);
    let (lives, dies) = (plain(above, 3.0 * swing, 14.0), plain(below, 3.0 * swing, 14.0));
    println!("{swing}: at {above} m/s {lives}, at {below} m/s {dies}");
    assert!(lives > 0.5 * swing && dies < 0.05 * swing);
    let stable: Vec<_> = found.motions.iter().filter(|motion| motion.stable).collect();
    assert!(!stable.is_empty());
    for motion in stable {
        let run = plain(motion.speed, 2.0 * motion.swings[0], 6.0);
        println!("{} m/s: {} +- {:?}, plain run {run}", motion.speed, motion.swings[0], motion.bound);
        assert!((run / motion.swings[0] - 1.0).abs() < 0.01);
    }
    let repeats = found.runs.iter().filter(|run| matches!(run.outcome, Outcome::Repeats { .. })).count();
    assert!(repeats > 0);
}
