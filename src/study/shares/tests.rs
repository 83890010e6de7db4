//! All of the time is somewhere, and where it belongs; clocks change nothing but time.

use super::*;
use crate::scene::load;

fn open(name: &str, changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    load::open(name, &changes).unwrap_or_else(|error| panic!("{error}"))
}

fn found(scene: &str, changes: &[&str], stop: f64) -> Shares {
    let found = shares(&open(scene, changes), Times { stop, step: 0.01 }, 2).unwrap();
    println!("{found}");
    found
}

/// No part is missing or counted twice, all together are the whole, and exactly those are there that the run has.
fn check(found: &Shares, absent: &[Part]) {
    let parts: Vec<Part> = found.shares.iter().map(|share| share.part).collect();
    let grouped: Vec<Part> = GROUPS.iter().flat_map(|group| group.1).map(|one| one.0).collect();
    assert_eq!(parts, grouped);
    assert_eq!(parts.len(), Part::WritingOutputs as usize + 1);
    let sum: f64 = found.shares.iter().map(|share| share.share).sum();
    assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    for Share { part, share } in &found.shares {
        // What is left of a whole behind its other parts may be measured as nothing on a busy machine.
        let rest = match part {
            Part::ContactSearch | Part::ContactAndEquations => found.doubt.is_some(),
            Part::JacobianForces => !absent.contains(part) && *share == 0.0,
            _ => false,
        };
        assert!(rest || (*share > 0.0) != absent.contains(part), "{part:?}: {share}");
    }
    // Half on a quiet machine; a run of milliseconds may be interrupted anywhere.
    assert!(found.of(GROUPS[0].1) > 0.01 && found.seconds > 0.0 && found.watched > 0.0);
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
fn equiv_clocks_change_no_bit_and_count_what_the_integrator_counts() {
    let scene = open("suspended_wheelset", &["solver.integrator=rosenbrock", "solver.tolerance=1e-5"]);
    let (mut plain, mut timed) = (Simulation::new(&scene, 0.0).unwrap(), Simulation::new(&scene, 0.0).unwrap());
    *timed.timers() = Timers::running();
    for time in [0.3, 0.7, 1.0] {
        plain.advance(time).unwrap();
        timed.advance(time).unwrap();
    }
    assert_eq!(plain.state(), timed.state());
    let (counts, work) = (timed.timers().tallies().map(|tally| tally.count), plain.statistics());
    let of = |call: Call| counts[call as usize];
    assert!(work.linearisations > 10 && timed.timers().forces);
    assert_eq!([of(Call::Linearise), of(Call::Factorise)], [work.linearisations, work.factorisations]);
    // Where a run goes on, an evaluation may be repeated, which the integrator does not count.
    assert!((0..=3).contains(&(of(Call::Derivative) - work.evaluations)), "{} {}", of(Call::Derivative), work.evaluations);
    // Four stages, and one for the check of each end that the stages leave standing.
    let checks = of(Call::Solve) - 4 * work.factorisations;
    assert!((work.steps..=work.factorisations).contains(&checks), "{checks} {work:?}");
    assert!(of(Call::Keep) >= work.steps);
    // Off they count nothing.
    assert!(plain.timers().tallies().iter().all(|tally| tally.count == 0));
}

/// Each call's time is in its own tally, and the clocks' own time is taken off.
#[test]
fn analytic_the_clock_is_taken_off_and_times_are_divided() {
    let mut timers = Timers::running();
    for (call, count) in [(Call::Derivative, 3), (Call::Solve, 2)] {
        for _ in 0..count {
            let clock = timers.start();
            std::thread::sleep(std::time::Duration::from_millis(2));
            timers.stop(call, clock);
        }
    }
    let tallies = timers.tallies();
    assert_eq!(tallies.map(|tally| tally.count), [3, 0, 0, 2, 0]);
    let [raw, solving] = [0, 3].map(|call| tallies[call].time.as_secs_f64());
    assert!(raw >= 6e-3 && solving >= 4e-3, "a clock shows at least what was slept");
    // 1 ms of each call lies in its time, 2 ms beside it.
    let outputs = Seconds { reading: 0.5, writing: 0.25, ..Seconds::default() };
    let times = outputs.cleared(&timers, raw + solving + 0.03, [1e-3, 3e-3]);
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
    near(times.calls[0], raw - 3e-3);
    near(times.calls[3], solving - 2e-3);
    near(times.own, 0.03 - 5.0 * 2e-3);
    let anatomy =
        Anatomy { whole: 9.0, normal: 1.0, creep: 1.0, track: 0.5, forces: 1.5, equations: 2.0, jacobian: 4.0, jacobian_contacts: 3.0 };
    let times = Seconds { calls: [90.0, 58.0, 18.0, 8.0, 0.0], own: 48.0, reading: 40.0, writing: 10.0 };
    let shares: Vec<f64> = divide(&times, &anatomy).iter().map(|share| share.share * 272.0).collect();
    let expected = [30.0, 10.0, 10.0, 5.0, 15.0, 20.0, 0.0, 43.5, 14.5, 18.0, 8.0, 0.0, 48.0, 40.0, 10.0];
    assert!(shares.iter().zip(expected).all(|(found, wanted)| (found - wanted).abs() < 1e-9), "{shares:?}");
    // Parts that were measured as more than the whole: nothing is left for the search, the sum is the whole all the same, and it is said.
    let busy = Anatomy { whole: 4.0, ..anatomy };
    let shares = divide(&times, &busy);
    let sum: f64 = shares.iter().map(|share| share.share).sum();
    assert!(shares[0].share == 0.0 && (sum - 1.0).abs() < 1e-12, "{shares:?}");
    assert_eq!(anatomy.doubt(), None);
    assert!(busy.doubt().unwrap().contains("measured as 150 % of it"), "{:?}", busy.doubt());
}

/// Of what a clock takes only a part falls into the call's own time.
#[test]
fn prop_clocks_know_their_own_time() {
    let [inside, all] = Timers::own_time();
    assert!(inside > 0.0 && inside < all, "{inside} {all}");
}

#[test]
fn hard_runs_that_end_early_say_why() {
    let off = open("suspended_wheelset", &["solver.integrator=rk4", "solver.step=0.01"]);
    let reason = shares(&off, Times { stop: 1.0, step: 0.01 }, 1).unwrap_err();
    assert!(reason.contains("t = "), "{reason}");
}
