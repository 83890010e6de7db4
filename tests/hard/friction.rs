//! Friction that varies along the track and across the rail's head: bounded by what holds at the place, seen by steps, free of charge where it is not named.

use crate::common;
use wheelrail::contact::patch::PatchLaw;
use wheelrail::formulation::{Evaluation, LEFT_FRICTION, RIGHT_FRICTION, contact_index};
use wheelrail::geometry::Side;
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;

/// Dry, then a film over 10 m that begins and ends within 1 m; grease on the gauge face.
const ALONG: &str = "contact.friction_along=[{factors=[[0,1.0],[15,0.2],[25,1.0]],transition=\"1 m\"}]";
const ACROSS: &str = "contact.friction_across={gauge_face=0.25,from=\"15 deg\",to=\"40 deg\"}";

fn scene(name: &str, changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(ToString::to_string).collect();
    load::open(name, &changes).unwrap_or_else(|error| panic!("{error}"))
}

fn step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t.powi(4) * (35.0 - 84.0 * t + 70.0 * t * t - 20.0 * t.powi(3))
}

/// What the two keys say, written out once more.
fn factor(s: f64, slope: f64) -> f64 {
    let along = 1.0 - 0.8 * step(s - 14.5) + 0.8 * step(s - 24.5);
    let [from, to] = [15f64, 40.0].map(f64::to_radians);
    along * (1.0 - 0.75 * step((slope.atan() - from) / (to - from)))
}

#[test]
fn hard_creep_forces_stay_within_the_friction_of_their_place() {
    for more in [
        &["contact.formulation=ECF-A", "contact.patch=ellipse"][..],
        &["contact.formulation=ECF-A"],
        &["contact.formulation=ECF-N"],
        &["contact.formulation=ECCF", "contact.on_lift=elastic"],
        &["contact.formulation=ACCF", "contact.on_lift=elastic"],
        &["contact.formulation=ECF-A", "contact.transient={below=\"40 m/s\"}", "contact.creep.law=fastsim"],
    ] {
        let mut changes = vec![
            ALONG,
            ACROSS,
            "track.deviation=[]",
            "vehicle.initial.y=0.004",
            "vehicle.initial.yaw=0.004",
            "vehicle.initial.vy=0.5",
            "solver.tolerance=1e-6",
        ];
        changes.extend(more);
        let scene = scene("wheelset_s1002", &changes);
        let mut simulation = common::start(&scene);
        // Largest use of the bound, with and without grease on the gauge face, and in the film along the track.
        let (mut used, mut greased, mut filmed) = (0.0f64, 0.0f64, 0.0f64);
        // The flange strikes within the first 50 ms.
        let times = (1..=100).map(|k| 5e-4 * f64::from(k)).chain((11..=300).map(|k| 5e-3 * f64::from(k)));
        for time in times {
            simulation.advance(time).unwrap_or_else(|error| panic!("{more:?}: {error}"));
            let points = simulation.model().points;
            let rails = Side::BOTH.map(|side| simulation.model().track.rail(side).profile.clone());
            let snapshot = simulation.snapshot().unwrap();
            let distance = snapshot.y[0];
            for side in Side::BOTH {
                for report in (0..points).map(|slot| snapshot.workspace.report(contact_index(0, side), slot)) {
                    if !(report.normal_force > 0.0) {
                        continue;
                    }
                    // A part of a patch of strips has the mean slope of its surface.
                    let own = rails[side.index()].at(report.parameters.rail).d1;
                    assert!(scene.contact.patch.law == PatchLaw::Strips || (own - report.profiles[1].d1).abs() < 1e-9);
                    let mu = 0.35 * factor(distance + report.parameters.lead, report.profiles[1].d1);
                    let use_of = report.creep_force.longitudinal.hypot(report.creep_force.lateral) / (mu * report.normal_force);
                    used = used.max(use_of);
                    if report.profiles[1].d1 > 0.4 {
                        greased = greased.max(use_of);
                    }
                    if (16.0..24.0).contains(&distance) {
                        filmed = filmed.max(use_of);
                    }
                }
            }
        }
        println!("{more:?}: {used:.6} of the bound, {greased:.4} on the gauge face, {filmed:.4} in the film");
        // Fastsim's and the mixed parts' resultants are bounded by their own sums.
        assert!(used < 1.0 + 1e-3, "{more:?}: {used}");
        assert!(greased > 0.5, "{more:?}: no contact on the gauge face, {greased}");
        assert!(filmed > 0.6, "{more:?}: the film is not felt, {filmed}");
    }
}

#[test]
fn prop_friction_by_place_multiplies_with_the_input() {
    // One ellipse: parts that are partly one add forces of their own directions, which are a little less than their sum.
    let alone = "contact.patch=ellipse";
    let scene = scene("wheelset_s1002", &[ALONG, "track.deviation=[]", "vehicle.initial.distance=20", "vehicle.initial.yaw=0.03", alone]);
    let simulation = common::start(&scene);
    let model = simulation.model();
    let force = |factor: f64| {
        let mut inputs = model.neutral_inputs();
        (inputs[LEFT_FRICTION], inputs[RIGHT_FRICTION]) = (factor, factor);
        let (mut workspace, mut memory, y) = (model.workspace(), model.blank_memory(), &simulation.state().integration.y);
        let mut dy = vec![0.0; y.len()];
        model.derivative(&mut workspace, Evaluation { t: 0.0, inputs: &inputs, y, memory: &mut memory }, &mut dy).unwrap();
        let report = workspace.report(0, 0);
        report.creep_force.longitudinal.hypot(report.creep_force.lateral) / report.normal_force
    };
    // 30 mrad slide altogether: 0.35 times 0.2 times the input.
    let [whole, half] = [force(1.0), force(0.5)];
    assert!((whole - 0.07).abs() < 1e-9 && (half - 0.035).abs() < 1e-9, "{whole} {half}");
}

/// A vehicle in a curve that comes to grease: a run at the tolerance that scenes have by default against a tight one.
#[test]
fn equiv_a_run_across_changes_of_friction_agrees_with_a_tight_run() {
    // The first patch is 0.5 m long, 25 ms: steps on this track are longer.
    let film = "contact.friction_along=[{factors=[[0,1.0],[75,0.3],[75.5,1.0],[88,0.3]],transition=\"0.2 m\"}]";
    const COLUMNS: [&str; 4] = ["y", "yaw", "left.verticalForce", "left.lateralForce"];
    let run = |changes: &[&str]| {
        let scene = scene("vehicle_curve", changes);
        let mut simulation = common::start(&scene);
        let outputs = common::table(&simulation, &scene);
        let mut rows = Vec::new();
        for k in 140..=200 {
            simulation.advance(0.025 * f64::from(k)).unwrap_or_else(|error| panic!("{error}"));
            let values = common::read(&mut simulation, &outputs);
            let of = |name: &str| values[&format!("{}.wheelset[1].{name}", "truck[1]")];
            rows.push(COLUMNS.map(of));
        }
        (rows, simulation.statistics())
    };
    let apart = |a: &[[f64; 4]], b: &[[f64; 4]]| -> [f64; 4] {
        std::array::from_fn(|i| a.iter().zip(b).map(|(a, b)| (a[i] - b[i]).abs()).fold(0.0, f64::max))
    };
    let (loose, work) = run(&[film]);
    let (tight, _) = run(&[film, "solver.tolerance=1e-8"]);
    let (dry, _) = run(&[]);
    let (off, changed) = (apart(&loose, &tight), apart(&dry, &tight));
    println!("{work:?}: off by {off:?}; the film changes {changed:?}");
    // Yaw: 7e-6 rad, less than the tolerance.
    assert!(off[0] < 0.01 * changed[0] && off[1] < 0.02 * changed[1], "{off:?} of {changed:?}");
    // solver.load_tolerance is 1 % of 60 kN.
    assert!(off[2] < 600.0 && off[3] < 600.0, "{off:?}");
    assert!(changed[3] > 1e3, "the film is not felt: {changed:?}");
}

#[test]
fn prop_factors_of_one_cost_nothing_and_change_no_bit() {
    let end = |changes: &[&str]| {
        let scene = scene("vehicle_manchester_1", changes);
        let mut simulation = common::start(&scene);
        simulation.advance(1.5).unwrap();
        (simulation.state().integration.y.clone(), format!("{:?}", simulation.statistics()))
    };
    let one = "contact.friction_along=[{factors=[[0,1.0],[20,1.0]],transition=\"1 m\"}]";
    assert_eq!(end(&[]), end(&[one]));
}

#[test]
fn prop_friction_by_place_is_refused_where_it_can_not_apply() {
    let refused = |changes: &[&str]| {
        let changes: Vec<String> = changes.iter().map(ToString::to_string).collect();
        load::open("suspended_wheelset", &changes).err().unwrap_or_else(|| panic!("{changes:?} was taken")).to_string()
    };
    let along = |settings: &str| refused(&[&format!("contact.friction_along=[{{{settings}}}]")]);
    for (settings, words) in [
        ("factors=[[0,1]],transition=1", "expected at least 2"),
        ("factors=[[0,1],[0.5,2]],transition=1", "distances that grow by the transition of 1.0 m"),
        ("factors=[[0,1],[5,-1]],transition=1", "found the factor -1.0, expected 0 to 10"),
        ("factors=[[0,1],[5,0.5]],transition=\"1 mm\"", "0.01 or more"),
        ("factors=[[0,1],[5,0.5]],transition=1,rail=\"middle\"", "expected one of \"both\", \"left\", \"right\""),
        ("factors=[[0,1],[5,0.5]],transition=1,width=2", "width"),
    ] {
        let found = along(settings);
        assert!(found.contains("contact.friction_along") && found.contains(words), "{settings}: {found}");
    }
    let found = refused(&["contact.friction=0", ALONG]);
    assert!(found.contains("contact.friction, which is 0"), "{found}");
    let found = refused(&["contact.friction_across={gauge_face=0.3,from=\"30 deg\",to=\"20 deg\"}"]);
    assert!(found.contains("contact.friction_across.to"), "{found}");
    // The head of one arc ends at 53 degrees.
    let found = refused(&["contact.friction_across={gauge_face=0.3,from=\"60 deg\",to=\"70 deg\"}"]);
    assert!(found.contains("has no surface toward the gauge face that is steeper than 53.1 deg"), "{found}");
}
