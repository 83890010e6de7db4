//! The study's parts on curves that are known, and a small study of the embedded wheelset.

use super::observation::{Observation, Trace, crossings, mean_wavelength};
use super::schedule::{Item, Pilot, Schedule};
use super::*;
use std::f64::consts::PI;

/// y = amplitude sin(2 pi x / length), sampled every 0.1 m.
fn wave(amplitude: f64, length: f64, normal: f64) -> Observation {
    let distance: Vec<f64> = (0..1000).map(|i| 0.1 * f64::from(i)).collect();
    let y = distance.iter().map(|x| amplitude * (2.0 * PI * x / length).sin()).collect();
    let both = || vec![vec![normal; 1000]; 2];
    let trace = Trace { distance, values: [vec![y], both(), both(), both(), both()] };
    Observation { smooth: vec![true; 1000], jumps: false, wheelsets: vec![trace] }
}

#[test]
fn analytic_errors_of_waves_of_different_length() {
    let (a, b) = (wave(1e-3, 20.0, 5e4), wave(1e-3, 20.5, 5e4 + 3.0));
    assert!((a.wavelength().unwrap() - 20.0).abs() < 1e-3, "{:?}", a.wavelength());
    let errors = Errors::between(&a, &b);
    println!("{errors:?}");
    assert!((errors.wavelength.unwrap() - 0.5).abs() < 1e-3);
    assert_eq!((errors.normal.largest, errors.normal.most, errors.normal.rms), (3.0, 3.0, 3.0));
    assert!(errors.y.most < errors.y.largest && errors.y.rms < errors.y.most);
    // Too small to be called hunting, and too short for two waves.
    assert!(wave(9e-6, 20.0, 0.0).wavelength().is_none() && wave(1e-3, 60.0, 0.0).wavelength().is_none());
    let places = crossings(&a.wheelsets[0]);
    assert!(places.len() == 4 && mean_wavelength(&places, 2).is_none() && mean_wavelength(&places, 3).is_some(), "{places:?}");
}

/// A jump that two runs meet at different times moves the largest difference, unless the model's forces jump and it is one sample away.
#[test]
fn analytic_single_jumps_and_samples_on_breaks_do_not_count() {
    let (a, mut b) = (wave(1e-3, 20.0, 5e4), wave(1e-3, 20.0, 5e4));
    b.wheelsets[0].values[2][1][500] = 6e4;
    let errors = Errors::between(&a, &b);
    assert_eq!((errors.normal.largest, errors.normal.most), (1e4, 0.0));
    let mut later = b.clone();
    later.wheelsets[0].values[2][1].swap(500, 501);
    assert_eq!(Errors::between(&b, &later).normal.largest, 1e4);
    later.jumps = true;
    assert_eq!(Errors::between(&b, &later).normal.largest, 0.0);
    assert_eq!(Errors::between(&a, &later).normal.largest, 1e4, "a jump that only one has is an error");
    b.smooth[500] = false;
    assert_eq!(Errors::between(&a, &b).normal.largest, 0.0);
    b.wheelsets[0].values[0][0][3] = f64::NAN;
    assert_eq!(Errors::between(&a, &b).y.largest, f64::INFINITY, "what is no number is no small error");
}

#[test]
fn analytic_predictions_follow_the_step_and_learn() {
    let pilot = Pilot { per_second: 0.01, per_evaluation: 2e-6 };
    let mut schedule = Schedule::new(vec![Some(pilot), None], 3, 1.0);
    let item = |variant, fixed, value| Item { variant, setting: Setting { integrator: if fixed { "rk4" } else { "rk43" }, fixed, value } };
    let predicted = |schedule: &Schedule, fixed, value| schedule.predict(&item(0, fixed, value)).unwrap();
    assert!((predicted(&schedule, true, 1e-3) - 5.0 * 2e-6 / 1e-3).abs() < 1e-12);
    assert_eq!(predicted(&schedule, false, 1e-5), 0.01);
    assert!(schedule.predict(&item(1, true, 1e-3)).is_none());
    // Stiff contact does not limit the steps of an implicit method.
    let implicit = |value| Item { variant: 0, setting: Setting { integrator: "rosenbrock", fixed: false, value } };
    let [loose, tight] = [1e-5, 1e-8].map(|value| schedule.predict(&implicit(value)).unwrap());
    assert!((loose - 0.002).abs() < 1e-12 && (tight - 0.02).abs() < 1e-9, "{loose} {tight}");
    schedule.learn(item(0, true, 1e-3), 0.03);
    assert!((predicted(&schedule, true, 1e-4) - 0.3).abs() < 1e-12);
    schedule.learn(item(0, false, 1e-6), 0.02);
    assert!((predicted(&schedule, false, 1e-10) - 0.2).abs() < 1e-12);
    let items = [item(0, true, 1e-4), item(0, false, 1e-6), item(1, true, 1e-3)];
    assert_eq!(schedule.cheapest(&items, 1.0, 0.0).unwrap().0, 1);
}

fn request(overrides: &[String]) -> Request<'_> {
    Request {
        scene: "suspended_wheelset",
        overrides,
        formulations: vec!["ECCF", "ECF-A"],
        integrators: vec!["dormand_prince", "rk4"],
        tolerances: vec![1e-5],
        steps: vec![5e-3, 2e-3, 1e-3],
        own_lists: [true; 2],
        creep_laws: vec![],
        node_spacings: vec![],
        smoothings: vec![],
        communication_steps: vec![],
        stop: Some(0.8),
        step: 5e-3,
        wheelset: None,
        repeats: 1,
        budget: 60.0,
        reference: None,
        interrupted: &|| false,
    }
}

/// The same numbers whatever the machine does, errors that fall with the step, a step beyond stability named as a failure, and models
/// told from numerics.
#[test]
fn prop_a_small_study_is_deterministic_and_ranks_steps() {
    let overrides = Vec::new();
    let request = Request { reference: Some(1e-12), ..request(&overrides) };
    let make = || study(&request, &mut |_, _| {}).unwrap();
    let (first, second) = (make(), make());
    let errors = |study: &Study| -> Vec<Option<Errors>> {
        let error = |point: &Point| if let Outcome::Done { errors, .. } = &point.outcome { Some(*errors) } else { None };
        study.points.iter().map(error).collect()
    };
    assert_eq!(errors(&first), errors(&second));
    for point in &first.points {
        println!(
            "{} {}: {:?}",
            first.variants[point.variant].label(),
            point.setting.words(),
            first.standing(point, Quantity::Displacement)
        );
    }
    assert!(first.points.len() == 8 && first.models.len() == 2 && first.differences.len() == 1);
    let known = errors(&first);
    for rk4 in [1, 5] {
        assert_eq!(first.points[rk4].setting.value, 5e-3);
        let fell = |a: usize, b: usize| known[a].is_none_or(|a| known[b].is_some_and(|b| b.y.largest < 0.3 * a.y.largest));
        assert!(fell(rk4, rk4 + 1) && fell(rk4 + 1, rk4 + 2), "{known:?}");
    }
    assert!(matches!(&first.points[5].outcome, Outcome::Failed(reason) if reason.contains("t = ")), "{:?}", first.points[5].outcome);
    // Elastic wheels sink in, which lateral displacement feels by less than 1 um here: more than any error of the reference.
    let apart = first.differences[0].errors.y.largest;
    assert!((1e-8..1e-5).contains(&apart), "{apart:e}");
    assert_eq!(first.apart(&first.differences[0], Quantity::Displacement), Some(Apart::Told(apart)));
    // The same distance below what both references are uncertain by is no fact.
    let mut uncertain = first.clone();
    for model in &mut uncertain.models {
        model.reference.as_mut().unwrap().uncertainty.y.largest = 0.6 * apart;
    }
    assert_eq!(uncertain.apart(&uncertain.differences[0], Quantity::Displacement), Some(Apart::Untold));
    for model in 0..2 {
        let found = best(&first, model, Quantity::Displacement, &[1e-3, 1e-4, 1e-6]);
        assert!(!found.is_empty() && found.iter().all(|one| one.levels.iter().all(|level| one.error <= *level)), "{found:?}");
    }
    let all: Vec<usize> = (0..first.points.len()).collect();
    let cheap = front(&first, &all, Quantity::Displacement);
    assert!(cheap.len() < all.len() && cheap.windows(2).all(|pair| pair[0] != pair[1]));
}

#[test]
fn analytic_the_median_of_an_even_number_of_runs_lies_between_the_middle_two() {
    let median = |cpu: &[f64]| Measured { cpu: cpu.to_vec(), statistics: Default::default(), work: Default::default() }.median();
    assert_eq!([median(&[1.0]), median(&[1.0, 3.0]), median(&[1.0, 2.0, 7.0]), median(&[1.0, 2.0, 4.0, 9.0])], [1.0, 2.0, 2.0, 3.0]);
    assert!(median(&[]).is_nan());
}

/// Each method takes what is in its range; what it does not take is named, and nothing at all is an error.
#[test]
fn prop_tolerances_and_steps_that_no_method_takes_are_named() {
    let overrides = Vec::new();
    let of = |integrators: &[&'static str], tolerances: &[f64], own_lists: [bool; 2]| {
        let (integrators, tolerances, steps) = (integrators.to_vec(), tolerances.to_vec(), vec![1e-3]);
        run::settings(&Request { integrators, tolerances, steps, own_lists, ..request(&overrides) })
    };
    let explicit = of(&["dormand_prince", "rosenbrock", "rk4"], &[1e-4, 3e-5, 1e-6], [true; 2]).unwrap();
    assert_eq!(explicit.1, ["dormand_prince: tolerances 1e-4, 3e-5 left out, it takes 1e-15 to 1e-5"]);
    assert_eq!(explicit.0.iter().map(Setting::number).collect::<Vec<_>>(), ["1e-6", "1e-4", "3e-5", "1e-6", "1 ms"]);
    assert_eq!(of(&["rk4"], &[1e-6], [true; 2]).unwrap().1, ["tolerances left out: none of the methods takes one"]);
    assert!(of(&["dormand_prince", "rk4"], &[1e-4, 1e-6], [false; 2]).unwrap().1.is_empty(), "of the standard lists nothing is said");
    let none = of(&["dormand_prince"], &[1e-4], [true; 2]).unwrap_err();
    assert!(none.ends_with("dormand_prince: tolerance 1e-4 left out, it takes 1e-15 to 1e-5"), "{none}");
    let empty = Request { integrators: vec!["dormand_prince"], tolerances: vec![1e-4], ..request(&overrides) };
    assert!(matches!(study(&empty, &mut |_, _| {}), Err(StudyError::Setting(words)) if words.contains("1e-5")));
}

/// References that are no better than the points tell nothing.
#[test]
fn hard_a_loose_reference_is_refused() {
    let overrides = Vec::new();
    let loose = Request {
        formulations: vec!["ECF-A"],
        integrators: vec!["dormand_prince"],
        tolerances: vec![1e-8, 1e-10],
        reference: Some(1e-5),
        ..request(&overrides)
    };
    let refused = study(&loose, &mut |_, _| {}).unwrap_err();
    println!("{refused}");
    assert!(matches!(&refused, StudyError::Refused(words) if words.contains("100 times") && words.contains("tolerance 1e-5")));
}

/// A held input costs order 1 in the communication step, its derivatives 2 and 3.
#[test]
fn order_of_the_communication_step_with_and_without_input_derivatives() {
    let overrides = Vec::new();
    let coupled = Request { formulations: vec!["ECF-A"], communication_steps: vec![0.05, 0.025], ..request(&overrides) };
    let found = study(&coupled, &mut |_, _| {}).unwrap().coupled;
    assert_eq!(found.len(), 6);
    for (hold, order) in [(0, 1.0), (1, 2.0), (2, 3.0)] {
        let [coarse, fine] = [0, 1].map(|i| found[2 * hold + i].errors.y.largest);
        let measured = (coarse / fine).log2();
        println!("input {}: {coarse:.2e} m, {fine:.2e} m, order {measured:.2}", HOLDS[hold]);
        assert!((measured - order).abs() < 0.35 && fine > found[2 * hold].floor, "{measured}");
    }
}

/// A run that has no time to end is given up long before its time is over; a pilot goes on.
#[test]
fn hard_a_run_that_will_not_end_in_time_is_given_up_early() {
    let scene = crate::scene::load::open("suspended_wheelset", &["solver.tolerance=1e-12".to_string()]).unwrap();
    let run = |limit: f64, early: bool| {
        let mut simulation = crate::sim::Simulation::new(&scene, 0.0).unwrap();
        run::observe(&mut simulation, None, crate::sim::recording::Times { stop: 500.0, step: 5e-3 }, (limit, early, &|| false))
    };
    let given_up = run(0.2, true);
    let why = given_up.failure.unwrap();
    println!("{why}; {} s", given_up.cpu);
    assert!(why.starts_with("given up at t = ") && why.contains("it needs about") && why.contains("the budget has 0.2 s"), "{why}");
    assert!(given_up.cpu < 0.2 && given_up.reached < 500.0);
    let pilot = run(0.05, false);
    assert!(pilot.failure.unwrap().starts_with("stopped after") && pilot.reached > 0.0);
}

/// Rigid contact that can't go on is told how it could, and that communication steps have no room.
#[test]
fn hard_a_study_without_a_reference_says_what_to_do() {
    // A dip that a wheel can't follow.
    let overrides = ["direction=vertical", "amplitude=-25 mm", "to=23"].map(|change| format!("track.deviation[1].{change}"));
    let dip = Request { stop: Some(0.6), budget: 20.0, communication_steps: vec![0.01], ..request(&overrides) };
    match study(&dip, &mut |_, _| {}) {
        Ok(found) => {
            assert!(found.notes.iter().all(|note| !note.contains("communication steps")) || found.coupled.is_empty());
            let rigid = found.models.iter().find(|model| model.rigid).unwrap();
            assert!(rigid.reference.as_ref().is_err_and(|reason| reason.contains("--set contact.on_lift=elastic")));
        }
        Err(error) => panic!("{error}"),
    }
}

/// What coupled references take: a decade of tolerance costs 1.8 times, and no more than 2 s are simulated.
#[test]
fn analytic_coupled_references_are_foreseen() {
    let seconds = |stop: f64| communication::duration(0.1, crate::sim::recording::Times { stop, step: 5e-3 });
    assert!((seconds(1.0) - 0.1 * 1.8f64.powi(6)).abs() < 1e-9 && (seconds(5.0) - 2.0 * seconds(1.0)).abs() < 1e-9);
}

/// Nodes at another distance and another creep law are models of their own.
#[test]
fn prop_variants_make_models_with_references_of_their_own() {
    let overrides = Vec::new();
    let laws = Request {
        formulations: vec!["ECF-A"],
        integrators: vec!["rk4"],
        creep_laws: vec!["shen_hedrick_elkins", "polach"],
        stop: Some(0.6),
        ..request(&overrides)
    };
    let found = study(&laws, &mut |_, _| {}).unwrap();
    let names: Vec<&str> = found.models.iter().map(|model| model.name.as_str()).collect();
    assert_eq!(names, ["ECF-A, creep law shen_hedrick_elkins", "ECF-A, creep law polach"]);
    assert!(found.differences.len() == 1 && found.differences[0].errors.y.largest > 1e-7, "{:?}", found.differences);
    let nodes = variant::variants(&["ECF-A", "ECF-N"], &[], &[1e-3, 1e-4], &[]);
    let labels: Vec<String> = nodes.iter().map(Variant::label).collect();
    assert_eq!(labels, ["ECF-A", "ECF-N, nodes every 1 mm", "ECF-N, nodes every 0.1 mm"]);
}

/// What is ready when the user ends a study is the study.
#[test]
fn hard_an_interrupted_study_keeps_what_is_ready() {
    use std::cell::Cell;
    use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
    let (overrides, ended) = (Vec::new(), AtomicBool::new(false));
    let interrupted = || ended.load(Relaxed);
    let asked = Request { reference: Some(1e-12), communication_steps: vec![0.05], interrupted: &interrupted, ..request(&overrides) };
    let points = Cell::new(0);
    let found = study(&asked, &mut |_, what| {
        points.set(points.get() + usize::from(what.contains("rk4") || what.contains("dormand_prince")));
        // While the sixth point runs: the first ones fail.
        ended.store(points.get() >= 6, Relaxed);
    })
    .unwrap();
    let done = found.points.iter().filter(|point| matches!(point.outcome, Outcome::Done { .. })).count();
    let left = found.points.iter().filter(|point| matches!(&point.outcome, Outcome::Skipped(why) if why == "interrupted")).count();
    println!("{done} done, {left} of {} left: {:?}", found.points.len(), found.notes);
    assert!(done >= 2 && left == 3 && found.points.len() == 8 && found.coupled.is_empty());
    assert!(found.notes.iter().any(|note| note.contains("were not run (interrupted)")));
}
