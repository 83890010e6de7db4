//! Linear contact against the strips whose first order it is, against formulas of the linear theory, and what a run tells of its bounds.

use crate::common;
use std::f64::consts::PI;
use wheelrail::formulation::Model;
use wheelrail::geometry::Side;
use wheelrail::mbs::body::BodyMotion;
use wheelrail::scene::spec::Scene;
use wheelrail::scene::{assemble, load};
use wheelrail::sim::Simulation;
use wheelrail::study::modes::{Mode, Modes, modes};

fn open(name: &str, patch: &str, changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(ToString::to_string).chain([format!("contact.patch={patch}")]).collect();
    load::open(name, &changes).unwrap_or_else(|error| panic!("{error}"))
}

fn found(scene: &Scene) -> Modes {
    modes(scene, scene.vehicle.speed).unwrap_or_else(|error| panic!("{error}"))
}

/// Relative distance of two eigenvalues.
fn apart(a: &Mode, b: &Mode) -> f64 {
    (a.growth - b.growth).hypot(a.angular_frequency - b.angular_frequency) / b.growth.hypot(b.angular_frequency)
}

/// The free wheelset whose suspension does nothing.
const FREE: [&str; 4] = [
    "vehicle.suspension.longitudinal_stiffness=0",
    "vehicle.suspension.longitudinal_damping=0",
    "vehicle.suspension.lateral_stiffness=0",
    "vehicle.speed=2",
];

/// Klingel's wave 2 pi sqrt(r0 b / gamma) of a free wheelset at walking speed, with the numbers that linear contact is made of; on cones also the wavelength with roll of the
/// independent implementation under tests/reference.
#[test]
fn analytic_a_free_wheelset_with_linear_contact_rolls_in_klingels_wave() {
    for (name, known) in [("suspended_wheelset", Some(22.613_855)), ("wheelset_s1002", None)] {
        let scene = open(name, "linear", &FREE);
        let all = found(&scene);
        let mode = all.hunting().unwrap();
        let model = assemble::model(&scene).unwrap();
        let (linear, half) = (model.linear_contact(0).unwrap(), model.wheelsets[0].wheel(Side::Left).half_spacing);
        let (radius, conicity) = (linear.patch.radius().0, linear.conicity(half));
        // Klingel leaves out roll, 0.8 % on a cone; on S1002 gravity and spin, whose shares grow with the way of the contact, make the wave longer than the formula.
        let most = if known.is_some() { 0.01 } else { 0.1 };
        let (wavelength, klingel) = (all.speed / mode.frequency, 2.0 * PI * (radius * half / conicity).sqrt());
        println!("{name}: {wavelength:.5} m, Klingel {klingel:.5} m with conicity {conicity:.5}, growth {:.1e} 1/s", mode.growth);
        assert!((wavelength / klingel - 1.0).abs() < most, "{name}: {wavelength} {klingel}");
        // That of the independent implementation under tests/reference.
        assert!(known.is_none() || (conicity / 0.025_671_42 - 1.0).abs() < 3e-3, "{conicity}");
        let full = known.unwrap_or_else(|| {
            let all = found(&open(name, "table", &FREE));
            all.speed / all.hunting().unwrap().frequency
        });
        assert!((wavelength / full - 1.0).abs() < if known.is_some() { 1e-3 } else { 0.01 }, "{wavelength} {full}");
    }
}

/// Cones under load are what the strips make of them at any amplitude; on S1002 and 60E1 slopes over 0.1 mm are those of the table (whose nodes are as far apart), while strips have
/// others within one strip.
#[test]
fn equiv_linear_contact_has_the_modes_of_the_full_one() {
    for (name, full, hunting, others) in [
        ("suspended_wheelset", "strips", 2e-3, 0.01),
        ("wheelset_s1002", "table", 0.02, 0.02),
        ("vehicle_manchester_1", "table", 0.03, 0.03),
    ] {
        let [linear, full] = ["linear", full].map(|patch| found(&open(name, patch, &[])));
        let [a, b] = [&linear, &full].map(|all| all.hunting().unwrap());
        println!(
            "{name}: hunting {:.4} Hz {:.4} 1/s for {:.4} Hz {:.4} 1/s: {:.1e}",
            a.frequency,
            a.growth,
            b.frequency,
            b.growth,
            apart(a, b)
        );
        assert!(apart(a, b) < hunting, "{name}");
        for mode in full.modes.iter().filter(|mode| mode.frequency > 0.0 && mode.damping < 0.5) {
            let nearest = linear.modes.iter().map(|own| apart(own, mode)).fold(f64::INFINITY, f64::min);
            println!("  {}: {nearest:.1e}", mode.name);
            assert!(nearest < if mode.hunting { hunting } else { others }, "{name}, {}", mode.name);
        }
    }
}

/// The wheelset's rails swing aside: y, and forces of the left wheel, every 5 ms.
fn swung(patch: &str, amplitude: &str) -> Vec<[f64; 3]> {
    let deviation = format!(
        "track.deviation=[{{ rail = \"both\", direction = \"lateral\", shape = \"cosine\", amplitude = \"{amplitude}\", from = 10.0, to = 30.0 }}]"
    );
    let mut simulation = common::start(&open("wheelset_s1002", patch, &[&deviation]));
    let row = |k: i32| {
        simulation.advance(5e-3 * f64::from(k)).unwrap_or_else(|error| panic!("{error}"));
        let snapshot = simulation.snapshot().unwrap();
        let force = snapshot.workspace.wheel_force(0, 0);
        [snapshot.workspace.system.motions[0].position.y, force.z, force.y]
    };
    (0..500).map(row).collect()
}

#[test]
fn equiv_small_motions_with_linear_contact_are_those_with_strips() {
    for (amplitude, share) in [("0.1 mm", 0.05), ("1 mm", 0.04), ("3 mm", 0.02)] {
        let [strips, table, linear, ellipse] = ["strips", "table", "linear", "ellipse"].map(|patch| swung(patch, amplitude));
        let most = |all: &[[f64; 3]], k: usize| all.iter().zip(&strips).map(|(a, b)| (a[k] - b[k]).abs()).fold(0.0, f64::max);
        let size = strips.iter().map(|row| row[0].abs()).fold(0.0, f64::max);
        let of = |all: &[[f64; 3]]| [(0, 1e6), (1, 1.0), (2, 1.0)].map(|(k, scale)| scale * most(all, k));
        println!(
            "{amplitude}: y up to {size:.2e}; off [y um, Q N, Y N] linear {:.2?}, table {:.2?}, ellipse {:.2?}",
            of(&linear),
            of(&table),
            of(&ellipse)
        );
        assert!(most(&linear, 0) < share * size, "{amplitude}");
        assert!(most(&linear, 0) < 0.4 * most(&ellipse, 0), "the ellipse has another conicity");
    }
}

/// A cone runs in a curve where its radii differ as the ways do: y = -r0 b / (gamma R), at a speed that asks for no force.
#[test]
fn analytic_a_free_wheelset_with_linear_contact_stands_aside_in_a_curve() {
    let curve = ["track.node=[{ distance = 0.0, curvature = 1e-4 }]", "track.deviation=[]"];
    let changes = [&FREE[..], &curve[..]].concat();
    let [simulation, strips] = ["linear", "strips"].map(|patch| common::start(&open("suspended_wheelset", patch, &changes)));
    let model = simulation.model();
    let (linear, half) = (model.linear_contact(0).unwrap(), model.wheelsets[0].wheel(Side::Left).half_spacing);
    let expected = -linear.patch.radius().0 * half / (linear.conicity(half) * 1e4);
    let y = simulation.solution()[1];
    println!("y = {y:e} m, expected {expected:e} m");
    assert!((y / expected - 1.0).abs() < 3e-3, "{y} {expected}");
    assert!((y / strips.solution()[1] - 1.0).abs() < 1e-3, "{y} {}", strips.solution()[1]);
}

/// Work of the contact's normal force around closed ways of the wheel, in parts of what goes in and out.
#[test]
fn prop_linear_contact_gives_back_what_it_takes() {
    let scene = open("wheelset_s1002", "linear", &["contact.friction=0", "contact.damping={ law = \"none\" }"]);
    let simulation = common::start(&scene);
    let model: &Model = simulation.model();
    let height = simulation.solution()[2];
    let force = |y: f64, z: f64, roll: f64| {
        let motion = BodyMotion::new(&[0.0, y, height + z, 0.0, roll, 0.0], &[20.0, 0.0, 0.0, 0.0, 0.0, 20.0 / 0.46]);
        let places = model.places_on_wheel(0, Side::Left, &motion, 1.0).unwrap();
        let report = places[0].report;
        (report.force, (report.wheel_point - motion.position).cross(&report.force).x)
    };
    const COUNT: usize = 2000;
    for (across, up, turn) in [(1.5e-3, 3e-5, 0.0), (1e-3, 0.0, 2e-5), (0.0, 2e-5, 2e-5)] {
        let at = |k: f64| {
            let phase = 2.0 * PI * k / COUNT as f64;
            let second = if up > 0.0 && across > 0.0 { phase.sin() } else { phase.cos() };
            (across * phase.cos(), up * second.max(-1.0), turn * phase.sin())
        };
        let (mut work, mut exchanged) = (0.0, 0.0);
        for k in 0..COUNT {
            let ((y0, z0, r0), (y1, z1, r1), (y, z, roll)) = (at(k as f64), at(k as f64 + 1.0), at(k as f64 + 0.5));
            let (force, moment) = force(y, z, roll);
            let own = force.y * (y1 - y0) + force.z * (z1 - z0) + moment * (r1 - r0);
            work += own;
            exchanged += 0.5 * own.abs();
        }
        println!("around ({across}, {up}, {turn}): {work:.2e} J of {exchanged:.2e} J");
        // What the strips' height and direction are apart: 1.3e-3 of N across.
        assert!(work.abs() < 0.04 * exchanged, "{work} {exchanged}");
    }
}

/// Sides are alike to the last digit, and rolling backward is its mirror image in time.
#[test]
fn equiv_linear_contact_is_symmetric() {
    let run = |changes: &[&str]| {
        let mut simulation = common::start(&open("vehicle_manchester_1", "linear", &[&["track.deviation=[]"], changes].concat()));
        simulation.advance(0.5).unwrap();
        let snapshot = simulation.snapshot().unwrap();
        [0, 1].map(|contact| snapshot.workspace.wheel_force(contact, 0))
    };
    let (whole, half, back) = (run(&[]), run(&["effects.symmetry=half"]), run(&["vehicle.speed=-20"]));
    println!("{whole:?} {half:?} {back:?}");
    for (side, mirror) in [(0, 1), (1, 0)] {
        assert!((whole[side] - half[side]).norm() < 1.0);
        assert!((whole[side].y + whole[mirror].y).abs() < 1.0 && (whole[side].z - whole[mirror].z).abs() < 1.0);
        assert!((whole[side].y - back[side].y).abs() < 2.0 && (whole[side].z - back[side].z).abs() < 20.0);
    }
}

fn notes(simulation: &Simulation) -> Vec<String> {
    simulation.notes().into_iter().filter(|note| note.contains("\"linear\"")).collect()
}

#[test]
fn prop_a_run_tells_where_linear_contact_does_not_hold() {
    let mut small = common::start(&open("wheelset_s1002", "linear", &["track.deviation=[]"]));
    small.advance(0.2).unwrap();
    assert!(notes(&small).is_empty(), "{:?}", notes(&small));
    let mut curve = common::start(&open("vehicle_curve", "linear", &[]));
    curve.advance(2.5).unwrap();
    let told = notes(&curve);
    println!("{told:#?}");
    for part in ["its flange carries", "its rolling radius changes by 20 %", "more than 30 % of mu N"] {
        let note = told.iter().find(|note| note.contains(part)).unwrap_or_else(|| panic!("{part}: {told:?}"));
        assert!(note.contains("truck[1].wheelset") && note.contains(" s on"), "{note}");
    }
    // A saved run has not forgotten it.
    let saved = curve.state().clone();
    assert!(curve.restore(&saved) && notes(&curve) == told);
}

#[test]
fn hard_linear_contact_is_refused_with_the_reason() {
    for (changes, why) in [
        (&["contact.formulation=ECCF"][..], "needs elastic contact"),
        (&["contact.formulation=ECF-N"], "needs contact.formulation = \"ECF-A\""),
        (&["contact.points=2"], "counts no places"),
        (&["contact.transient={ below = 1.0 }"], "has no tangential states"),
    ] {
        let changes: Vec<String> = changes.iter().map(ToString::to_string).chain(["contact.patch=linear".into()]).collect();
        let refused = match load::open("wheelset_s1002", &changes) {
            Err(error) => error.to_string(),
            Ok(scene) => Simulation::new(&scene, 0.0).err().map(|error| error.to_string()).unwrap_or_default(),
        };
        assert!(refused.contains(why) && refused.contains("\"linear\""), "{changes:?}: {refused}");
    }
}
