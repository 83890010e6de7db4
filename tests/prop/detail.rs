//! `vehicle.detail`: what a part of a vehicle does in steady running is what it does in the whole, and what is cut away is not there.

use crate::common::{self, run, start};
use crate::scene_keys::open;
use std::collections::HashMap;
use wheelrail::formulation::LONGITUDINAL_FORCE;
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::scene::vehicle::extent::Extent;
use wheelrail::settings::Source;
use wheelrail::sim::Simulation;
use wheelrail::sim::recording::Recording;
use wheelrail::sim::vehicle_outputs::scene_outputs;

/// Behind the deviations of the embedded scenes, and more exact than what is looked at.
const STRAIGHT: [&str; 3] = ["vehicle.initial.distance=150", common::EXACT[0], common::EXACT[1]];

/// A vehicle of its own kind: one flat list without modules, axle boxes on joints, balanced preloads, a car that lies unevenly, friction and brakes.
const OWN: &str = r#"
[vehicle]
template = "free"
speed = 25.0

[vehicle.wheel_profile]
kind = "s1002"
radius = 0.46

[[vehicle.body]]
name = "box"
mass = 30000.0
inertia_xx = 50000.0
inertia_yy = 1.5e6
inertia_zz = 1.5e6
position = [0.3, 0.02, 1.7]
"#;

const TRACK: &str = r#"
[track]
gauge = "1435 mm"
inclination = "1:40"
rail = { kind = "60e1" }

[[track.deviation]]
rail = "both"
direction = "lateral"
shape = "cosine"
amplitude = "3 mm"
from = "220 m"
to = "240 m"

[contact]
formulation = "ECF-A"
friction = 0.35
damping = 2.0e9
material = { youngs_modulus = 2.1e11, poisson_ratio = 0.28 }
creep = { law = "fastsim" }

[solver]
integrator = "auto"
tolerance = 1e-7

[run]
stop = 2.0
step = "5 ms"
"#;

/// The parts of a truck whose middle is at x, with names that end in `n`.
fn truck(n: usize, x: f64) -> String {
    let inertia = "inertia_xx = 1000.0\ninertia_yy = 110.0\ninertia_zz = 1000.0\n";
    let mut text = format!(
        "[[vehicle.body]]\nname = \"frame{n}\"\nmass = 2800.0\ninertia_xx = 1800.0\ninertia_yy = 1500.0\ninertia_zz = 3000.0\nposition = [{x}, 0.0, 0.6]\n\
         [[vehicle.force]]\nname = \"air{n}\"\nmirrored = true\nkind = \"bushing\"\nfrom = \"frame{n}\"\nto = \"box\"\nat = [{x}, 1.0, 0.85]\n\
         stiffness = [1.5e5, 1.5e5, 4.0e5]\ndamping = [0.0, 2.0e4, 2.0e4]\npreload = \"static\"\n\
         [[vehicle.force]]\nname = \"yaw{n}\"\nkind = \"dry_friction\"\nmirrored = true\nfrom = \"frame{n}\"\nto = \"box\"\nat = [{x}, 1.1, 0.8]\n\
         axis = \"x\"\nlimit = 3000.0\nstiffness = 2.0e6\n\
         [[vehicle.force]]\nname = \"rod{n}\"\nkind = \"spring_damper\"\nfrom = {{ body = \"frame{n}\", at = [{x}, 0.0, 0.6] }}\nto = {{ body = \"box\", at = [{}, 0.0, 0.6] }}\n\
         stiffness = 4.0e6\ndamping = 2.0e4\n",
        x - 0.7
    );
    for (k, axle) in [(1, x + 1.2), (2, x - 1.2)] {
        text += &format!(
            "[[vehicle.wheelset]]\nname = \"axle{n}{k}\"\nx = {axle}\nmass = 1500.0\n{inertia}tread_circle_distance = 1.5\ndriven = {}\n\
             [[vehicle.body]]\nname = \"bearing{n}{k}\"\nmirrored = true\nmass = 90.0\ninertia_xx = 4.0\ninertia_yy = 5.0\ninertia_zz = 5.0\nposition = [{axle}, 1.0, 0.46]\n\
             [[vehicle.joint]]\nname = \"journal{n}{k}\"\nmirrored = true\nkind = \"revolute\"\nfirst = \"axle{n}{k}\"\nsecond = \"bearing{n}{k}\"\nat = [{axle}, 1.0, 0.46]\naxis = [0, 1, 0]\n\
             [[vehicle.force]]\nname = \"spring{n}{k}\"\nmirrored = true\nkind = \"bushing\"\nfrom = \"frame{n}\"\nto = \"bearing{n}{k}\"\nat = [{axle}, 1.0, 0.46]\n\
             stiffness = [2.0e7, 4.0e6, 1.2e6]\ndamping = [2.0e4, 2.0e3, 4.0e3]\nrotational_stiffness = [1.0e5, 1.0e5, 1.0e5]\npreload = \"static\"\n",
            n == 1 && k == 1
        );
    }
    text + &format!(
        "[[vehicle.force]]\nname = \"brake{n}\"\nkind = \"brake\"\nfrom = {{ body = \"frame{n}\", at = [{}, 0.0, 0.5] }}\nto = {{ body = \"axle{n}1\", at = [{}, 0.0, 0.46] }}\n\
         type = \"disc\"\nstiffness = 1.0e7\n",
        x + 0.6,
        x + 1.2
    )
}

fn own_text() -> String {
    format!("{OWN}{}{}{TRACK}", truck(1, 8.0), truck(2, -8.0))
}

fn own(changes: &[&str]) -> Result<Scene, String> {
    read(&own_text(), changes)
}

fn read(text: &str, changes: &[&str]) -> Result<Scene, String> {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    let source = Source { file: "own.toml".into(), text: text.into(), overridden: vec![], folder: None };
    load::read("own", source, &changes).map_err(|error| error.to_string())
}

fn values(scene: &Scene, simulation: &mut Simulation) -> HashMap<String, f64> {
    let outputs = scene_outputs(scene, simulation.model());
    let snapshot = simulation.snapshot().unwrap();
    outputs.iter().map(|output| (output.name.clone(), output.value(snapshot))).collect()
}

/// A scene and its levels: bodies that stay, and bodies, joints and elements that a name begins with and that are gone.
type Levels<'a> = (&'a str, &'a dyn Fn(&[&str]) -> Scene, [(&'a str, usize, &'a [&'a str]); 2]);

#[test]
fn equiv_every_level_has_the_wheel_loads_of_the_whole_in_steady_running() {
    let embedded = |name: &'static str| move |changes: &[&str]| open(name, &[&STRAIGHT[..], changes].concat()).unwrap();
    let (coach, equalised) = (embedded("vehicle_manchester_1"), embedded("vehicle_equalised"));
    // A joint of the centre plate pulls what is cut away uphill.
    let pulling = |changes: &[&str]| equalised(&[&["track.grade=0.01"], changes].concat());
    let uneven = |changes: &[&str]| coach(&[&["vehicle.body[car].position=[0.95, 0.03, 1.8]"], changes].concat());
    let uphill = |changes: &[&str]| coach(&[&["track.grade=0.01"], changes].concat());
    let rigid = |changes: &[&str]| coach(&[&["contact.formulation=ECCF"], changes].concat());
    let free = |changes: &[&str]| coach(&[&["vehicle.travel=free"], changes].concat());
    let own = |changes: &[&str]| own(changes).unwrap_or_else(|error| panic!("{error}"));
    let of_coach: [(&str, usize, &[&str]); 2] =
        [("truck", 3, &["car", "truck[2]"]), ("wheelset", 1, &["car", "truck[2]", "truck[1].frame"])];
    let of_equalised: [(&str, usize, &[&str]); 2] =
        [("truck", 6, &["car", "truck[2]"]), ("wheelset", 3, &["car", "truck[2]", "truck[1].frame", "truck[1].bolster"])];
    let of_own: [(&str, usize, &[&str]); 2] =
        [("truck", 7, &["box", "axle21", "frame2", "brake2"]), ("wheelset", 3, &["box", "axle12", "axle21", "frame1", "spring12"])];
    let cases: [Levels; 8] = [
        ("coach", &coach, of_coach),
        ("uneven coach", &uneven, of_coach),
        ("coach uphill", &uphill, of_coach),
        ("coach on rigid contacts", &rigid, of_coach),
        ("coach that rolls freely", &free, of_coach),
        ("equalised", &equalised, of_equalised),
        ("equalised uphill", &pulling, of_equalised),
        ("own", &own, of_own),
    ];
    for (name, scene, levels) in cases {
        let whole = scene(&[]);
        let mut simulation = start(&whole);
        let expected = values(&whole, &mut simulation);
        let mut states = simulation.model().dimension();
        for (level, bodies, gone) in levels {
            let part = scene(&[&format!("vehicle.detail={level}")]);
            let mut simulation = start(&part);
            let found = values(&part, &mut simulation);
            let fewer = simulation.model().dimension();
            assert!(fewer < states, "{name} {level}: {fewer} states instead of {states}");
            states = fewer;
            assert_eq!(simulation.model().system.bodies.len(), bodies, "{name} {level}");
            for part in gone {
                assert!(!found.keys().any(|known| known.starts_with(part)), "{name} {level}: {part} has outputs");
                assert!(
                    !simulation.model().system.forces.iter().any(|force| force.name().starts_with(part)),
                    "{name} {level}: {part} has elements"
                );
            }
            let mut worst: f64 = 0.0;
            let loads = found.iter().filter(|(key, _)| key.ends_with(".verticalForce"));
            for (key, load) in loads {
                worst = worst.max((load / expected[key] - 1.0).abs());
            }
            let still = simulation.snapshot().unwrap().dy[6 * bodies..12 * bodies].iter().fold(0.0f64, |most, a| most.max(a.abs()));
            println!("{name} {level}: wheel loads within {worst:.1e} of the whole vehicle's, accelerations below {still:.1e}");
            let count = found.keys().filter(|key| key.ends_with(".verticalForce")).count();
            assert_eq!(count, 2 * part.vehicle.wheelsets.len());
            assert!(worst < 1e-6 && worst.is_finite(), "{name} {level}: {worst:e}");
            assert!(still < 1e-2, "{name} {level}: {still}");
        }
    }
}

#[test]
fn prop_everything_is_what_it_is_without_the_word() {
    for (name, level) in
        [("vehicle_manchester_1", "vehicle"), ("vehicle_manchester_1", "train"), ("suspended_wheelset", "wheelset"), ("train", "train")]
    {
        let runs = [&[][..], &[&*format!("vehicle.detail={level}")]].map(|changes| run(&open(name, changes).unwrap(), 0.3, 0.01));
        let bits = |run: &Recording| -> Vec<u64> { run.rows.iter().flatten().map(|value| value.to_bits()).collect() };
        assert_eq!(bits(&runs[0]), bits(&runs[1]), "{name} {level}");
    }
}

/// The leading wheelset's way over a lateral deviation, m.
fn way(scene: &Scene, wheelset: &str) -> Vec<f64> {
    run(scene, 3.0, 0.01).column(&format!("{wheelset}.y")).unwrap()
}

/// A coupler in its slack holds nothing: alone, a coach of the train is the coach; the nearer a level is to the whole, the nearer is its motion.
#[test]
fn equiv_a_coach_cut_from_a_train_moves_as_the_coach_and_coarser_levels_are_farther_off() {
    let mut train = vec!["vehicle.place[coach].count=2", "interface.only=[\"coach[1]\"]"];
    train.extend(common::EXACT);
    let open_at = |level: &str| open("train", &[&train[..], &[&format!("vehicle.detail={level}")]].concat()).unwrap();
    let whole = way(&open_at("train"), "coach[1].truck[1].wheelset[1]");
    let coach = way(&open("vehicle_manchester_1", &common::EXACT).unwrap(), "truck[1].wheelset[1]");
    let off = |level: &str| common::largest_difference(&whole, &way(&open_at(level), "coach[1].truck[1].wheelset[1]"));
    let [vehicle, truck, wheelset] = ["vehicle", "truck", "wheelset"].map(off);
    let size = whole.iter().fold(0.0f64, |most, y| most.max(y.abs()));
    println!("y up to {size:.2e} m; off by {vehicle:.2e} (vehicle), {truck:.2e} (truck), {wheelset:.2e} m (wheelset)");
    assert!(size > 2e-3 && common::largest_difference(&whole, &coach) < 2e-6);
    // The frame of a wheelset alone stays on the line from which the rails, and with them the truck, deviate.
    assert!(vehicle < 1e-8 && 1e-6 < truck && truck < 0.05 * size && truck < wheelset && wheelset < size);
}

/// A truck alone is as heavy along the track as what its wheels carry: a = F / (m + I / r^2).
#[test]
fn analytic_a_free_truck_takes_its_share_of_the_car_along_the_track() {
    const FORCE: f64 = 8e3;
    let acceleration = |changes: &str, wheelsets: f64, mass: f64, force: f64| {
        let scene = open("vehicle_manchester_1", &[STRAIGHT[0], "solver.tolerance=1e-7", "vehicle.travel=free", changes]).unwrap();
        let mut simulation = start(&scene);
        simulation.set_input(LONGITUDINAL_FORCE, force, 0.0, 0.0);
        let speed = |simulation: &mut Simulation| values(&scene, simulation)["truck[1].wheelset[1].vx"];
        // Behind the swings of the start.
        simulation.advance(4.0).unwrap();
        let before = speed(&mut simulation);
        simulation.advance(14.0).unwrap();
        let found = 0.1 * (speed(&mut simulation) - before);
        // Axles as they roll without slip, on the wheels' running circles.
        (found, force / (mass + wheelsets * 112.0 / 0.46f64.powi(2)))
    };
    let whole = 32000.0 + 2.0 * 2615.0 + 4.0 * 1813.0;
    for (level, wheelsets, mass) in [("vehicle", 4.0, whole), ("truck", 2.0, 0.5 * whole), ("wheelset", 1.0, 0.25 * whole)] {
        let change = format!("vehicle.detail={level}");
        let (with, expected) = acceleration(&change, wheelsets, mass, FORCE);
        let (without, _) = acceleration(&change, wheelsets, mass, 0.0);
        println!("{level}: {:.5} m/s2, formula {expected:.5}", with - without);
        assert!(((with - without) / expected - 1.0).abs() < 1e-4, "{level}");
    }
}

/// What rolls freely down a grade, or against a resistance on the car, goes with the whole vehicle's acceleration, whichever wheelsets a template drives. (From the steady state of an imposed speed,
/// where driven wheelsets push the others, a driven one alone had twice that acceleration, and an undriven one none.)
#[test]
fn equiv_every_level_rolls_freely_with_the_acceleration_of_the_whole() {
    /// Of the leading wheelset in the second second, m/s2.
    fn acceleration(scene: &Scene) -> f64 {
        let mut simulation = start(scene);
        let names = scene.vehicle.wheelsets.iter().map(|wheelset| wheelset.spec.name.as_str());
        let keys: Vec<String> = names.flat_map(|name| [format!("{name}.vx"), "vx".into()]).collect();
        let mut speed = |time: f64| {
            simulation.advance(time).unwrap();
            let found = values(scene, &mut simulation);
            keys.iter().find_map(|key| found.get(key).copied()).unwrap()
        };
        let [before, after] = [0.1, 1.1].map(&mut speed);
        after - before
    }
    let air = "vehicle.force=[{name=\"air\", kind=\"running_resistance\", on={body=\"car\", at=[0.0, 0.0, 1.8]}, rolling=8e3}]";
    let embedded =
        |name: &'static str| move |changes: &[&str]| open(name, &[&STRAIGHT[..], &["vehicle.travel=free"], changes].concat()).unwrap();
    // Its cars on pivots: what these pull with along the track is in no force element.
    let pivot = |n: usize, x: f64| {
        format!(
            "[[vehicle.joint]]\nname = \"pivot{n}\"\nkind = \"spherical\"\nfirst = \"frame{n}\"\nsecond = \"box\"\nat = [{x:?}, 0.0, 0.6]\n"
        )
    };
    let text = format!("{}{}{}", own_text(), pivot(1, 8.0), pivot(2, -8.0));
    let on_pivots = |changes: &[&str]| read(&text, &[&["vehicle.travel=free"], changes].concat()).unwrap_or_else(|error| panic!("{error}"));
    let (coach, bogie) = (embedded("vehicle_manchester_1"), embedded("bogie"));
    type Case<'a> = (&'a str, &'a dyn Fn(&[&str]) -> Scene, &'a [&'a str], &'a [&'a [&'a str]]);
    let cases: [Case; 3] = [
        (
            "coach",
            &coach,
            &["track.grade=-0.01", air],
            &[
                &["vehicle.detail=truck"],
                &["vehicle.detail=wheelset"],
                &["vehicle.detail=wheelset", "vehicle.detail_of=truck[1].wheelset[2]"],
            ],
        ),
        (
            "bogie",
            &bogie,
            &["track.grade=0.01"],
            &[&["vehicle.detail=wheelset"], &["vehicle.detail=wheelset", "vehicle.detail_of=wheelset[2]"]],
        ),
        (
            "on pivots",
            &on_pivots,
            &["track.grade=-0.01"],
            &[&["vehicle.detail=truck"], &["vehicle.detail=wheelset", "vehicle.detail_of=axle22"]],
        ),
    ];
    for (name, scene, changes, details) in cases {
        let whole = acceleration(&scene(changes));
        for detail in details {
            let part = acceleration(&scene(&[changes, detail].concat()));
            println!("{name} {detail:?}: {part:.8} m/s2, whole {whole:.8}");
            assert!((part / whole - 1.0).abs() < 1e-4 && whole.abs() > 0.05, "{name} {detail:?}: {part} {whole}");
        }
    }
}

/// Coaches of 44 482 kg whose wheels add 4 Iyy / r^2 along the track.
const COACH: f64 = 32000.0 + 2.0 * 2615.0 + 4.0 * 1813.0;
const TURNING: f64 = 4.0 * 112.0 / (0.46 * 0.46);
const POINTS: &str = "vehicle.point_masses=[\"coach[2]\", \"coach[3]\"]";

#[test]
fn analytic_point_masses_pull_with_their_weight_on_a_grade() {
    let scene =
        open("train", &[&STRAIGHT[..], &[POINTS, "track.grade=0.01", "interface.only=[\"coupler[1]\", \"coupler[2]\"]"]].concat()).unwrap();
    let mut simulation = start(&scene);
    // One coach and two bodies with twelve states each.
    assert_eq!(simulation.model().dimension(), 100 + 24);
    assert_eq!((scene.vehicle.wheelsets.len(), scene.vehicle.bodies.len()), (4, 5));
    let down = COACH * 9.81 * 0.01f64.atan().sin();
    for time in [0.0, 5.0] {
        simulation.advance(time).unwrap();
        let found = values(&scene, &mut simulation);
        for (coupler, behind) in [("coupler[1].force", 2.0), ("coupler[2].force", 1.0)] {
            println!("{time} s {coupler}: {:.3} N, formula {:.3}", found[coupler], behind * down);
            assert!((found[coupler] / (behind * down) - 1.0).abs() < 1e-6);
        }
    }
}

/// Rotors of motors turn with the wheels of a point mass: 2 x 4.6^2 x 8 kg m2 are 1600 kg of a coach. (Without, coupler forces were 3 % too small for their acceleration.)
#[test]
fn analytic_point_masses_have_the_inertia_of_their_rotors() {
    let scene = open(
        "examples/electric_train.toml",
        &["track={ gauge = \"1435 mm\", inclination = \"1:40\", rail = { kind = \"60e1\" } }", POINTS],
    )
    .unwrap();
    let Extent::Cut(away) = &scene.vehicle.extent else { panic!("nothing is cut away") };
    let text = away.describe(&scene.vehicle);
    let turning = TURNING + 2.0 * 4.6 * 4.6 * 8.0 / (0.46 * 0.46);
    assert!(text.contains(&format!("coach[2].car 44482 kg (and {turning:.0} kg of")), "{text}");
}

/// A train braked at its leading wheelset, more and more within 4 s so that couplers hardly swing, with all vehicles and with two point masses: a third of the force is left
/// for each coach, and what rolls with a resistance of its own is told apart by a run without the force.
#[test]
fn equiv_a_train_of_point_masses_is_braked_as_the_train() {
    const FORCE: f64 = -6e3;
    let ends = |changes: &[&str], force: f64| {
        let tight = ["vehicle.place[coach].between[coupler].slack=0", "interface.only=[\"coupler[1]\", \"coupler[2]\", \"coach[1]\"]"];
        let scene = open("train", &[&[STRAIGHT[0], "solver.tolerance=1e-6", "vehicle.travel=free"], &tight[..], changes].concat()).unwrap();
        let mut simulation = start(&scene);
        simulation.set_input(LONGITUDINAL_FORCE, 0.0, 0.25 * force, 0.0);
        simulation.advance(4.0).unwrap();
        simulation.set_input(LONGITUDINAL_FORCE, force, 0.0, 0.0);
        let mut found = Vec::new();
        for time in [8.0, 12.0] {
            simulation.advance(time).unwrap();
            let values = values(&scene, &mut simulation);
            found.push([values["coupler[1].force"], values["coupler[2].force"], values["coach[1].truck[1].wheelset[1].vx"]]);
        }
        [found[1][0], found[1][1], 0.25 * (found[1][2] - found[0][2])]
    };
    let acceleration = FORCE / (3.0 * (COACH + TURNING));
    let expected = [2.0 / 3.0 * FORCE, FORCE / 3.0, acceleration];
    for changes in [&[][..], &[POINTS]] {
        let [with, without] = [FORCE, 0.0].map(|force| ends(changes, force));
        println!("{changes:?}: coupler forces [N] and acceleration {with:.4?}, rolling freely {without:.4?}; formula {expected:.4?}");
        for ((with, without), expected) in with.into_iter().zip(without).zip(expected) {
            // The corner of the force leaves a swing of 30 N that nothing damps.
            assert!(((with - without) / expected - 1.0).abs() < 1.5e-2);
        }
    }
}

/// Running resistance of a frame, or of a wheelset, of point masses acts on the bodies that stand for them: the train slows down as the whole one, and couplers carry nothing.
/// (It was gone, while a note said that it stayed: 0.96 of the speed's loss for 0.68, and couplers pulled with 4 kN.)
#[test]
fn equiv_point_masses_keep_the_running_resistance_of_their_bodies() {
    for body in ["car", "truck[1].frame", "truck[2].wheelset[1]"] {
        let resistance = format!(
            "vehicle.module.coach.force=[{{name=\"air\", kind=\"running_resistance\", on={{body=\"{body}\", at=[0.0, 0.0, 1.8]}}, rolling=2e3, air=2.0}}]"
        );
        let slowed = |changes: &[&str]| {
            let own = [STRAIGHT[0], "vehicle.travel=free", "vehicle.place[coach].between[coupler].slack=0", &resistance];
            let scene = open("train", &[&own[..], changes].concat()).unwrap();
            let mut simulation = start(&scene);
            simulation.advance(5.0).unwrap();
            let found = values(&scene, &mut simulation);
            let notes = wheelrail::scene::improbable::improbable(&scene, simulation.model());
            assert!(!notes.iter().any(|note| note.contains("air")), "{notes:?}");
            [found["coach[1].truck[1].wheelset[1].vx"], found["coupler[1].force"], found["coupler[2].force"]]
        };
        let (whole, points) = (slowed(&[]), slowed(&[POINTS]));
        println!("{body}: speed and coupler forces {whole:.4?}, with point masses {points:.4?}");
        assert!((whole[0] - points[0]).abs() < 2e-3 && (1..3).all(|k| (whole[k] - points[k]).abs() < 60.0));
    }
}

#[test]
fn prop_brakes_and_motors_that_are_cut_away_are_told_where_they_would_act() {
    let missed = |changes: &[&str]| {
        let scene = open("train", &[&[STRAIGHT[0]], changes].concat()).unwrap();
        let notes = wheelrail::scene::improbable::improbable(&scene, start(&scene).model());
        notes.into_iter().find(|note| note.contains("drive, brake or resist no more"))
    };
    let brake = |torque: &str| {
        format!(
            "vehicle.module.coach.force=[{{name=\"brake\",kind=\"brake\",type=\"disc\",from={{body=\"truck[1].frame\",at=[9.0,0.0,0.6]}},to={{body=\"truck[1].wheelset[1]\",at=[10.78,0.0,0.46]}},\
             stiffness=6e6,torque={torque}}}]"
        )
    };
    let (acting, idle) = (brake("2e3"), brake("0.0"));
    let found = missed(&[&acting, POINTS]).unwrap();
    assert!(found.starts_with("vehicle.point_masses: coach[2].brake, coach[3].brake went with what is cut away"), "{found}");
    assert_eq!((missed(&[&idle, POINTS]), missed(&[&acting]), missed(&[POINTS])), (None, None, None));
    // What resists without an input does so on in the forces that guides keep.
    let air = "vehicle.force=[{name=\"air\", kind=\"running_resistance\", on={body=\"car\", at=[0.0, 0.0, 1.8]}, rolling=8e3}]";
    let scene = open("vehicle_manchester_1", &[STRAIGHT[0], air, "vehicle.detail=truck"]).unwrap();
    let notes = wheelrail::scene::improbable::improbable(&scene, start(&scene).model());
    assert!(notes.iter().any(|note| note.contains("of air stays what the kept wheels carry of it")), "{notes:?}");
    // What an input may bring on a body that is gone is told, whatever it begins with.
    let wind = "vehicle.force=[{name=\"wind\", kind=\"external_load\", on={body=\"car\", at=[0.0, 0.0, 1.8]}}]";
    let scene = open("vehicle_manchester_1", &[STRAIGHT[0], wind, "vehicle.detail=truck"]).unwrap();
    let notes = wheelrail::scene::improbable::improbable(&scene, start(&scene).model());
    assert!(notes.iter().any(|note| note.contains("wind went with what is cut away")), "{notes:?}");
}

#[test]
fn hard_what_cannot_be_cut_says_why() {
    let telescope = format!(
        "{}[[vehicle.joint]]\nname = \"post\"\nkind = \"prismatic\"\nfirst = \"box\"\nsecond = \"frame1\"\nat = [8.0, 0.0, 0.8]\naxis = [0, 0, 1]\n",
        own_text()
    );
    let curve = ["vehicle.detail=truck", "track.node=[{distance=300}, {distance=400, radius=500}]"];
    let cases: [(&str, &[&str], &str); 6] = [
        (&own_text(), &["vehicle.detail=bogie"], "vehicle.detail: found \"bogie\", expected"),
        (&own_text(), &["vehicle.detail_of=axle21"], "vehicle.detail_of: serves nothing without detail"),
        (&own_text(), &["vehicle.detail=truck", "vehicle.detail_of=axle3"], "vehicle.detail_of: found \"axle3\""),
        (&own_text(), &curve, "vehicle.detail: leaves out bodies whose turning and centrifugal forces belong to a curve"),
        (&own_text(), &["vehicle.detail=truck", "interface.only=[\"box\"]"], "leaves none of the parts that interface.only names"),
        (&telescope, &["vehicle.detail=truck"], "cuts the joint post between frame1, which stays, and box"),
    ];
    for (text, changes, words) in cases {
        let error = read(text, changes).err().unwrap_or_default();
        println!("{error}");
        assert!(error.contains(words) && error.contains("own.toml"), "{error}");
    }
    let of_train: [(&str, &str); 4] = [
        (
            "vehicle.point_masses=[\"coach[4]\"]",
            "vehicle.point_masses: found \"coach[4]\" (did you mean \"coach[1]\"?), expected vehicles of the train",
        ),
        ("vehicle.point_masses=[\"coach[1]\", \"coach[2].car\", \"coach[3]\"]", "vehicle.point_masses: leaves no wheelset on the rails"),
        (
            "vehicle.place[coach].between[coupler].from.body=truck[2].frame",
            "a coupler holds on to coach[2].truck[2].frame, which is not the heaviest body of its vehicle",
        ),
        ("vehicle.detail=vehicle", "vehicle.point_masses: stands beside detail = \"vehicle\""),
    ];
    for (change, words) in of_train {
        let changes: &[&str] = if change.contains("point_masses") { &[change] } else { &[POINTS, change] };
        let error = open("train", changes).err().unwrap_or_default();
        println!("{error}");
        assert!(error.contains(words), "{error}");
    }
    // Wheelsets that carry the car itself.
    let error = open("bogie", &["vehicle.detail=truck", "vehicle.body[frame].mass=20 t"]).err().unwrap_or_default();
    assert!(error.contains("this vehicle's wheelsets carry its heaviest body with nothing between"), "{error}");
}

#[test]
fn prop_a_named_part_is_cut_out_and_the_plan_says_so() {
    let scene = open("vehicle_manchester_1", &["vehicle.detail=truck", "vehicle.detail_of=truck[2]"]).unwrap();
    let names: Vec<&str> = scene.vehicle.wheelsets.iter().map(|wheelset| wheelset.spec.name.as_str()).collect();
    assert_eq!(names, ["truck[2].wheelset[1]", "truck[2].wheelset[2]"]);
    let plan = wheelrail::scene::plan::plan(&scene, start(&scene).model());
    let row = plan.effects.iter().find(|effect| effect.name == "level of detail").unwrap();
    // Half the car.
    assert!(
        row.why.contains("vehicle.detail = \"truck\"") && row.why.contains("beside what it holds: car, with 156.960 kN on the wheels"),
        "{}",
        row.why
    );
    assert!(row.why.contains("gone with them: floor[1], floor[2]"));
}
