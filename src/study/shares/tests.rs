//! All of the time is somewhere, and where it belongs; the watch changes nothing but time.

use super::watch::Call;
use super::*;
use crate::scene::load;
use crate::solve::{Dynamics, Integrator, Rosenbrock, Scratch, StiffPart, Undefined};
use std::time::Duration;

fn open(name: &str, changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    load::open(name, &changes).unwrap_or_else(|error| panic!("{error}"))
}

fn found(scene: &str, changes: &[&str], stop: f64) -> Shares {
    let found = shares(&open(scene, changes), Span { stop, step: 0.01 }, 2).unwrap();
    println!("{found}");
    found
}

/// No part is missing or counted twice, all together are the whole, and exactly those are there that the run has.
fn check(found: &Shares, absent: &[Part]) {
    let parts: Vec<Part> = found.shares.iter().map(|share| share.part).collect();
    assert_eq!(parts, Part::ALL);
    let sum: f64 = found.shares.iter().map(|share| share.share).sum();
    assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    let groups: f64 = Group::ALL.iter().map(|group| found.of(*group)).sum();
    assert!((groups - 1.0).abs() < 1e-12, "{groups}");
    for Share { part, share } in &found.shares {
        assert_eq!(*share > 0.0, !absent.contains(part), "{part:?}: {share}");
    }
    let integration = 1.0 - found.of(Group::Outputs);
    assert!(found.of(Group::RightHandSides) > 0.2 * integration && found.seconds > 0.0 && found.watched > 0.0);
}

const IMPLICIT: [Part; 4] = [Part::JacobianContacts, Part::JacobianForces, Part::Factorisation, Part::LinearSystems];

#[test]
fn prop_shares_of_implicit_and_explicit_runs_are_whole() {
    let implicit = found("suspended_wheelset", &["solver.integrator=rosenbrock", "solver.tolerance=1e-5"], 0.8);
    check(&implicit, &[Part::Track, Part::ContactAndEquations]);
    let explicit = found("suspended_wheelset", &["solver.integrator=dormand_prince", "solver.tolerance=1e-7"], 0.3);
    check(&explicit, &[&IMPLICIT[..], &[Part::Track, Part::ContactAndEquations]].concat());
    // The split method's Jacobians leave the force elements out.
    let split = found("suspended_wheelset", &["solver.integrator=imex", "solver.tolerance=1e-5"], 0.3);
    check(&split, &[Part::Track, Part::ContactAndEquations, Part::JacobianForces]);
    let rigid = found("suspended_wheelset", &["solver.tolerance=1e-7", "contact.formulation=ECCF"], 0.3);
    check(&rigid, &[&IMPLICIT[..], &[Part::Track, Part::ContactSearch, Part::EquationsOfMotion]].concat());
}

#[test]
fn prop_a_curve_has_a_share_for_the_track() {
    check(&found("vehicle_curve", &["solver.integrator=rosenbrock"], 0.05), &[Part::ContactAndEquations]);
}

/// The same run to the bit, and as many calls as the integrator's own counters say.
#[test]
fn equiv_the_watch_changes_no_bit_and_counts_what_the_integrator_counts() {
    let scene = open("suspended_wheelset", &["solver.integrator=rosenbrock", "solver.tolerance=1e-5"]);
    let meter = Shared::default();
    let mut guarded = scene.clone();
    guarded.solver.integrator = Arc::new(Watched { inner: scene.solver.integrator.clone(), meter: meter.clone() });
    let (mut plain, mut watched) = (Simulation::new(&scene, 0.0).unwrap(), Simulation::new(&guarded, 0.0).unwrap());
    meter.sample();
    for time in [0.3, 0.7, 1.0] {
        plain.advance(time).unwrap();
        watched.advance(time).unwrap();
    }
    assert_eq!(plain.state(), watched.state());
    let counts = meter.take().map(|tally| tally.count);
    let work = plain.statistics();
    let of = |call: Call| counts[call as usize];
    assert!(work.linearisations > 10);
    assert_eq!([of(Call::Linearise), of(Call::Factorise)], [work.linearisations, work.factorisations]);
    // Where a run goes on, an evaluation may be repeated, which the integrator does not count.
    assert!((0..=3).contains(&(of(Call::Derivative) - work.evaluations)), "{} {}", of(Call::Derivative), work.evaluations);
    // Four stages, and one for the check of each end that the stages leave standing.
    let checks = of(Call::Solve) - 4 * work.factorisations;
    assert!((work.steps..=work.factorisations).contains(&checks), "{checks} {work:?}");
    let samples = meter.take_samples();
    assert!((40..=80).contains(&samples.len()) && meter.take_samples().is_empty(), "{}", samples.len());
    let last = samples.last().unwrap().t;
    assert!(samples.windows(2).any(|pair| pair[1].t > pair[0].t) && last > 0.9, "samples of all of the run: {last}");
    assert!(meter.covers_forces());
}

/// A method of [`Dynamics`] that the watch does not hand on would fall back to its default without a word.
#[test]
fn prop_the_watch_hands_on_every_method() {
    let methods = |text: &'static str, begin: &str| -> Vec<&'static str> {
        let body = text.split(begin).nth(1).and_then(|rest| rest.split("\n}").next()).unwrap_or_default();
        body.split("\n    fn ").skip(1).filter_map(|rest| rest.split('(').next()).collect()
    };
    for (text, interface, watched, least) in [
        (include_str!("../../solve/mod.rs"), "pub trait Dynamics {", "impl Dynamics for Guarded<'_> {", 25),
        (include_str!("../../solve/mod.rs"), "pub trait Integrator: Send + Sync + Debug {", "impl Integrator for Watched {", 8),
    ] {
        let (asked, handed) = (methods(text, interface), methods(include_str!("watch.rs"), watched));
        assert!(asked.len() >= least, "{asked:?}");
        let missing: Vec<_> = asked.iter().filter(|name| !handed.contains(name)).collect();
        assert!(missing.is_empty(), "{watched} leaves out {missing:?}");
    }
}

/// y' = -y that takes its time in each call.
struct Slow;

/// Calls take so long, s; in the order of [`Call`].
const SLOW: [f64; CALLS] = [50e-6, 400e-6, 200e-6, 100e-6, 25e-6];

fn spin(call: Call) {
    let clock = Instant::now();
    while clock.elapsed().as_secs_f64() < SLOW[call as usize] {}
}

impl Dynamics for Slow {
    fn derivative(&mut self, _: f64, y: &[f64], _: &mut [f64], dy: &mut [f64]) -> Result<(), Undefined> {
        spin(Call::Derivative);
        dy[0] = -y[0];
        Ok(())
    }
    fn error_weight(&self, _: usize) -> f64 {
        1.0
    }
    fn next_break(&self, _: f64, _: &[f64], _: &[f64]) -> f64 {
        spin(Call::Keep);
        f64::INFINITY
    }
    fn margin(&self, _: &[f64]) -> Option<f64> {
        spin(Call::Keep);
        None
    }
    fn project(&mut self, _: f64, _: &mut [f64], _: &mut [f64]) -> Result<bool, Undefined> {
        spin(Call::Keep);
        Ok(false)
    }
    fn linearise(&mut self, _: f64, _: &[f64], _: &[f64], _: StiffPart) -> Result<(), Undefined> {
        spin(Call::Linearise);
        Ok(())
    }
    fn factorise(&mut self, _: f64) -> Result<(), Undefined> {
        spin(Call::Factorise);
        Ok(())
    }
    fn solve_linear(&mut self, _: &mut [f64]) {
        spin(Call::Solve);
    }
}

/// Time is counted where it is spent: at least what each call takes, and all calls together no more than the run.
#[test]
fn analytic_calls_of_known_length_are_counted_where_they_belong() {
    let integrator = Rosenbrock { tolerance: 1e-5, part: StiffPart::All };
    let meter = Shared::default();
    let watched = Watched { inner: Arc::new(integrator), meter: meter.clone() };
    let (mut state, mut scratch) = (watched.start(0.0, &[1.0], &[]), Scratch::new(1, 0));
    let clock = Instant::now();
    watched.advance(&mut Slow, &mut state, &mut scratch, 1.0).unwrap();
    let all = clock.elapsed().as_secs_f64();
    let tallies = meter.take();
    let mut sum = 0.0;
    for (tally, slow) in tallies.iter().zip(SLOW) {
        let (count, time) = (tally.count as f64, tally.time.as_secs_f64());
        assert!(count > 4.0 && time >= count * slow, "{tally:?}");
        sum += time;
    }
    println!("{sum} of {all} s; {tallies:?}");
    assert!(sum <= all && sum > 0.8 * all);
}

#[test]
fn analytic_the_clock_is_taken_off_and_times_are_divided() {
    let tally = |count: u64, micros: u64| Tally { count, time: Duration::from_micros(micros) };
    let tallies = [tally(10, 100), tally(2, 60), tally(2, 20), tally(8, 16), tally(4, 4)];
    // 26 calls: 1 us of each lies in the call's time, 2 us beside it.
    let times = cleared(&tallies, [300e-6, 40e-6, 10e-6], [1e-6, 3e-6]);
    let near = |found: f64, micros: f64| (found - 1e-6 * micros).abs() < 1e-12;
    assert!(times.calls.iter().zip([90.0, 58.0, 18.0, 8.0, 0.0]).all(|(found, wanted)| near(*found, wanted)), "{times:?}");
    assert!(near(times.own, 48.0) && near(times.reading, 40.0) && near(times.writing, 10.0) && near(times.sum(), 272.0), "{times:?}");
    let parts = Replay {
        whole: 9e-6,
        normal: 1e-6,
        creep: 1e-6,
        track: 0.5e-6,
        forces: 1.5e-6,
        equations: 2e-6,
        jacobian: 4e-6,
        jacobian_forces: 1e-6,
    };
    let micros = |shares: &[Share]| -> Vec<f64> { shares.iter().map(|share| (share.share * 272.0 * 1e3).round() * 1e-3).collect() };
    let expected = [30.0, 10.0, 10.0, 5.0, 15.0, 20.0, 0.0, 43.5, 14.5, 18.0, 8.0, 0.0, 48.0, 40.0, 10.0];
    let found = micros(&divide(&times, &parts));
    assert!(found.iter().zip(expected).all(|(found, wanted)| (found - wanted).abs() < 1e-9), "{found:?}");
    // Parts that were measured as more than the whole: nothing is left for the search, and the sum is the whole all the same.
    let found = divide(&times, &Replay { whole: 4e-6, ..parts });
    let sum: f64 = found.iter().map(|share| share.share).sum();
    assert!(found[0].share == 0.0 && (sum - 1.0).abs() < 1e-12, "{found:?}");
    // Which is said, and nothing else where all is well.
    assert_eq!(doubt(&times, &parts), None);
    let said = |replay: Replay| doubt(&times, &replay).unwrap();
    let more = said(Replay { whole: 4e-6, ..parts });
    assert!(more.contains("measured as 150 % of it") && more.contains("repeat it on a quiet machine"), "{more}");
    assert!(said(Replay { jacobian_forces: 5e-6, ..parts }).contains("force elements of a Jacobian were measured as 125 % of it"));
    // 26 calls take more than the 52 us that were not spent in calls.
    let busy = cleared(&tallies, [230e-6, 40e-6, 10e-6], [1e-6, 3e-6]);
    assert!(near(busy.own, 0.0) && near(busy.clipped, 22.0) && doubt(&busy, &parts).unwrap().contains("less than nothing"), "{busy:?}");
}

/// What the watch itself takes is some tens of nanoseconds, and less of it inside the call's time than in all.
#[test]
fn prop_the_watch_is_quick() {
    let [inside, all] = own_time();
    println!("{:.0} ns, {:.0} ns of them in the call's time", 1e9 * all, 1e9 * inside);
    assert!(inside > 0.0 && inside < all && all < 1e-5);
}

#[test]
fn hard_runs_that_end_early_say_why() {
    let off = open("suspended_wheelset", &["solver.integrator=rk4", "solver.step=0.01"]);
    let reason = shares(&off, Span { stop: 1.0, step: 0.01 }, 1).unwrap_err();
    assert!(reason.contains("t = "), "{reason}");
}
