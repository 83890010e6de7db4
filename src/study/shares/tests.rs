//! All of the time is somewhere, and where it belongs; the watch changes nothing but time.

use super::watch::Call;
use super::*;
use crate::scene::load;

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
