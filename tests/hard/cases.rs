//! The table of hard cases and random scenes (`wheelrail hard`), the part that fits into a test run.
//!
//! What is still broken stands in tests/data/hard_open.csv, row by row with the number found and how many times its bound that is (`-` where no number
//! says it): a list that may only become shorter, and numbers that may not grow. Any other row must hold or be refused. Everything up to a sixth beyond,
//! because runs differ in the last digits between machines (the platform's sine and exponential).

use rayon::prelude::*;
use wheelrail::scene::load;
use wheelrail::settings::Source;
use wheelrail::study::hard::random::{self, Class, RandomScene};
use wheelrail::study::hard::{Finding, Judged, Outcome, Unit, all, judge};

/// Random scenes of a test run, and the first one's seed.
const SCENES: u64 = 300;
const SEED: u64 = 1;

/// Rows that are known to be broken: case, formulation and method, or "random" and the seed; with how many times its bound each may be.
fn open_rows() -> std::collections::BTreeMap<String, f64> {
    let text = include_str!("../data/hard_open.csv");
    let row = |line: &str| {
        let fields: Vec<&str> = line.splitn(5, ',').map(str::trim).collect();
        (fields[..3].join(","), fields[3].parse().unwrap_or(f64::INFINITY))
    };
    text.lines().skip(1).map(row).collect()
}

/// A row counts as broken, or as worse than it was, from so many times its bound on.
const NEAR: f64 = 7.0 / 6.0;

/// Is nothing else wrong with a row than a time? That is a matter of the machine, as the work of a start is bounded (scene::steady_state).
fn slow_at_most(row: &Judged) -> bool {
    match &row.outcome {
        Outcome::Broken { findings, reason } => {
            // A refusal in the right words, which are its reason, may be slow too; one that panics or says something else is wrong.
            let slow = findings.iter().any(|finding| finding.what == "time to be refused" && !finding.holds());
            let wrong = ["panic", "makes no sense", "does not say"].iter().any(|words| reason.contains(words));
            (reason.is_empty() || slow && !wrong) && findings.iter().all(|finding| finding.holds() || finding.unit == Unit::Second)
        }
        _ => false,
    }
}

#[test]
fn hard_nothing_in_the_table_is_broken_but_what_is_listed() {
    let open = open_rows();
    let quick: Vec<_> = all().into_iter().filter(|case| case.quick).collect();
    let mut jobs: Vec<_> = quick.iter().flat_map(|case| case.formulations.iter().map(move |formulation| (case, *formulation))).collect();
    jobs.sort_by(|a, b| b.0.stop.total_cmp(&a.0.stop));
    let rows: Vec<Judged> =
        jobs.par_iter().with_max_len(1).flat_map_iter(|(case, formulation)| judge(case, formulation, case.methods)).collect();
    for row in &rows {
        println!("{}: {}, {}: {}", row.case, row.formulation, row.method, row.outcome.words());
    }
    let broken: Vec<String> = rows
        .iter()
        .filter(|row| row.outcome.is_broken() && !slow_at_most(row))
        .filter(|row| {
            let most = open.get(&format!("{},{},{}", row.case, row.formulation, row.method)).copied().unwrap_or(1.0);
            let strain = row.outcome.worst().map_or(f64::INFINITY, Finding::strain);
            !(strain < NEAR * most || most.is_infinite())
        })
        .map(|row| format!("{}, {}, {}: {}\n    {}", row.case, row.formulation, row.method, row.outcome.words(), row.command))
        .collect();
    assert!(rows.len() > 300, "the table has shrunk: {}", rows.len());
    assert!(broken.is_empty(), "{} of {} broken:\n{}", broken.len(), rows.len(), broken.join("\n"));
}

#[test]
fn hard_random_scenes_are_right_or_say_why_not() {
    let all: Vec<random::Verdict> = (SEED..SEED + SCENES).into_par_iter().map(random::judge).collect();
    for class in Class::ALL {
        println!("{:20} {}", class.words(), all.iter().filter(|verdict| verdict.class == class).count());
    }
    let open = open_rows();
    let failed: Vec<String> = all
        .iter()
        // How long a start takes is a matter of the machine; its work is bounded (scene::steady_state).
        .filter(|verdict| verdict.class != Class::SlowStart)
        .filter(|verdict| {
            verdict.class.is_failure() && !(verdict.strain < NEAR) && !open.contains_key(&format!("random,,{}", verdict.seed))
        })
        .map(|verdict| format!("wheelrail hard --random-scene {}: {}: {}", verdict.seed, verdict.class.words(), verdict.reason))
        .collect();
    assert!(failed.is_empty(), "{} of {SCENES} fail:\n{}", failed.len(), failed.join("\n"));
    // A generator that makes nothing but refusals shows nothing.
    let right = all.iter().filter(|verdict| verdict.class == Class::Right).count() as u64;
    assert!(2 * right > SCENES, "only {right} of {SCENES} ran to their end");
}

#[test]
fn prop_a_seed_makes_the_same_scene_and_most_scenes_can_be_read() {
    let (mut read, mut formulations) = (0, std::collections::BTreeSet::new());
    for seed in 1..=100 {
        let (one, other) = (RandomScene::draw(seed), RandomScene::draw(seed));
        assert_eq!(one.text, other.text);
        let source = Source { file: "random.toml".into(), text: one.text, overridden: vec![], folder: None };
        if let Ok(scene) = load::read("random", source, &[]) {
            read += 1;
            formulations.insert(scene.contact.formulation_name);
        }
    }
    assert!(read > 80 && formulations.len() == 4, "{read} {formulations:?}");
}

#[test]
fn prop_a_number_that_is_none_does_not_hold() {
    assert!(!Finding::new("", f64::NAN, 1.0, Unit::One).holds());
    assert!(!Finding::new("", 1.1, 1.0, Unit::One).holds() && Finding::new("", 1.0, 1.0, Unit::One).holds());
    assert!(Finding::relative("", 1.01, 1.0, 0.02,).holds() && !Finding::relative("", 0.97, 1.0, 0.02).holds());
}

#[test]
fn prop_every_case_says_what_it_is_about_and_has_a_name_of_its_own() {
    let cases = all();
    let names: std::collections::BTreeSet<&str> = cases.iter().map(|case| case.name).collect();
    assert_eq!(names.len(), cases.len());
    for case in &cases {
        assert!(!case.hard.is_empty() && !case.claim.is_empty() && !case.must.is_empty(), "{}", case.name);
        assert!(!case.methods.is_empty() && !case.formulations.is_empty(), "{}", case.name);
    }
}
