//! `contact.patch = "exact"`: half-space contact in the equations of motion.

use crate::common;
use wheelrail::contact::patch::Settings;
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::study::contact_geometry::Attitude;
use wheelrail::study::patch::{Question, patches};
use wheelrail::study::pose::{self, Answer, Height};

fn exact(changes: &[&str]) -> Scene {
    let usual = ["contact.patch=exact", "contact.creep={ law = \"exact\", grid = 16 }"];
    let changes: Vec<String> = usual.iter().chain(changes).map(ToString::to_string).collect();
    load::open("wheelset_s1002", &changes).unwrap_or_else(|error| panic!("{error}"))
}

fn posed(scene: &Scene, y: f64, yaw: f64, pitch_rate: Option<f64>) -> Answer {
    let (height, speed) = (Height::Load(50e3), scene.vehicle.speed);
    let question = pose::Question { y, yaw, roll: None, height, station: None, speed, pitch_rate, creepage: None };
    pose::pose(scene, &question).unwrap_or_else(|error| panic!("{error}"))
}

/// What the equations of motion feel is what `wheelrail contact --patch` shows on the same cells: on the tread, where its patch has two lobes, and on tread and flange.
#[test]
fn equiv_wheels_on_half_spaces_carry_what_their_patches_do() {
    let scene = exact(&["track.deviation=[]"]);
    let settings = Settings { columns: 16, rows: 16, ..Settings::default() };
    for (y, yaw) in [(0.0, 0.0), (3e-3, 5e-3), (6.3e-3, 10e-3)] {
        let attitude = Attitude { yaw, ..Attitude::default() };
        let shown = patches(&scene, &Question { y, attitude, station: None, load: 50e3, pitch_rate: None, settings }).unwrap();
        let felt = posed(&scene, y, yaw, Some(shown.pitch_rate));
        for (wheel, felt) in shown.wheels.iter().zip(&felt.wheels) {
            let of = |place: &pose::Place| place.found.report;
            let normal: f64 = felt.places.iter().map(|place| of(place).normal_force).sum();
            let creep: nalgebra::Vector3<f64> =
                felt.places.iter().map(|place| of(place).force - of(place).axes.normal * of(place).normal_force).sum();
            let off = (creep - wheel.solution.creep_force).norm() / (scene.contact.friction * normal);
            let highest = felt.places.iter().map(|place| place.found.highest_pressure).fold(0.0, f64::max);
            println!(
                "y {y} m, {} wheel, {} places: N {normal:.1} and {:.1} N, creep {off:.4} mu N apart",
                wheel.side.name(),
                felt.places.len(),
                wheel.solution.load
            );
            assert!((normal / wheel.solution.load - 1.0).abs() < 2e-3 && off < 0.01, "{normal} {:?} {off}", wheel.solution.load);
            assert!((highest / wheel.solution.highest_pressure() - 1.0).abs() < 0.01, "{highest}");
        }
    }
}

/// Rolling backward is rolling forward seen from behind: left and right change places, and so do signs along and across.
#[test]
fn equiv_half_spaces_roll_backward_as_forward_seen_from_behind() {
    let ahead = posed(&exact(&["track.deviation=[]"]), 2e-3, 3e-3, None);
    let back = posed(&exact(&["track.deviation=[]", "vehicle.speed=-20"]), -2e-3, 3e-3, None);
    for side in 0..2 {
        let (one, other) = (ahead.wheels[side].force, back.wheels[1 - side].force);
        assert!((one.x + other.x).abs() < 2.0 && (one.y + other.y).abs() < 2.0 && (one.z - other.z).abs() < 2.0, "{one:?} {other:?}");
        assert!(one.x.abs() > 1e3 && one.y.abs() > 500.0, "{one:?}");
    }
}

/// Each cell has the friction of its place: a map that says a half everywhere is half the coefficient.
#[test]
fn equiv_cells_have_the_friction_of_their_place() {
    let plain = posed(&exact(&["track.deviation=[]", "contact.friction=0.15"]), 5e-3, 0.0, Some(43.3));
    let mapped = exact(&[
        "track.deviation=[]",
        "contact.friction=0.3",
        "contact.friction_along=[{ factors = [[\"-10 m\", 0.5], [\"1 km\", 1.0]], transition = \"1 m\" }]",
    ]);
    let mapped = posed(&mapped, 5e-3, 0.0, Some(43.3));
    for (one, other) in plain.wheels.iter().zip(&mapped.wheels) {
        assert!((one.force - other.force).norm() < 1e-6 * one.force.norm(), "{:?} {:?}", one.force, other.force);
    }
}

/// A run over a lateral deviation: strips are by far nearer to it than an ellipse, and implicit steps, whose slopes are those of strips, end at the same place.
#[test]
fn equiv_runs_on_half_spaces_are_near_those_on_strips() {
    let bump = ["left", "right"].map(|rail| {
        format!(
            "{{ rail = \"{rail}\", direction = \"lateral\", shape = \"cosine\", amplitude = \"2 mm\", from = \"0.2 m\", to = \"4 m\" }}"
        )
    });
    let bump = format!("track.deviation=[{}]", bump.join(", "));
    let run = |scene: Scene| {
        let recording = common::run(&scene, 0.15, 5e-3);
        common::column(&recording, "y")
    };
    let half_spaces = run(exact(&[&bump]));
    let with = |patch: &str| {
        let changes = [bump.clone(), format!("contact.patch={patch}"), "contact.creep.law=usetab".into()];
        run(load::open("wheelset_s1002", &changes).unwrap())
    };
    let [strips, ellipse] = ["strips", "ellipse"].map(|patch| common::largest_difference(&half_spaces, &with(patch)));
    let implicit = common::largest_difference(&half_spaces, &run(exact(&[&bump, "solver.integrator=rosenbrock"])));
    let most = half_spaces.iter().fold(0.0_f64, |most, y| most.max(y.abs()));
    println!("y up to {most} m; strips {strips:.1e}, ellipse {ellipse:.1e}, implicit {implicit:.1e} m away");
    assert!(most > 1e-4 && strips < 0.3 * ellipse && implicit < 2e-5);
}

/// Creep laws of ellipses do not know the patch.
#[test]
fn equiv_half_spaces_ask_for_kalkers_theory() {
    for law in ["law = \"usetab\"", "law = \"exact\", kalker_factor = 0.6"] {
        let changes = ["contact.patch=exact".to_string(), format!("contact.creep={{ {law} }}")];
        let refused = load::open("wheelset_s1002", &changes).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(refused.contains("expected contact.creep.law = \"exact\""), "{law}: {refused}");
    }
}
