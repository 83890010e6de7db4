//! `wheelrail modes` as a program.

use std::process::Command;

fn modes(arguments: &[&str]) -> (String, String, i32) {
    wheelrail(&[&["modes"], arguments].concat())
}

fn wheelrail(arguments: &[&str]) -> (String, String, i32) {
    let output = Command::new(env!("CARGO_BIN_EXE_wheelrail")).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.code().unwrap())
}

#[test]
fn prop_modes_are_told_in_words_and_as_json() {
    let (words, _, code) = modes(&["suspended_wheelset"]);
    assert_eq!(code, 0);
    for said in ["hunting, wheelset: lateral", "Left out: wheelset: distance and speed along the track (imposed)", "Stable"] {
        assert!(words.contains(said), "{words}");
    }
    let (words, _, _) = modes(&["suspended_wheelset", "--set", "vehicle.speed=80"]);
    assert!(words.contains("Unstable: hunting, wheelset: lateral at 3.057 Hz"), "{words}");
    let (json, _, _) = modes(&["vehicle_manchester_1", "--json"]);
    let found: serde_json::Value = serde_json::from_str(&json).unwrap();
    let all = found["modes"].as_array().unwrap();
    // One entry for a pair, one for a real eigenvalue.
    let swinging = all.iter().filter(|mode| mode["frequency"].as_f64().unwrap() > 0.0).count();
    assert_eq!(all.len() + swinging, found["free"].as_u64().unwrap() as usize);
    let names: Vec<&str> = all.iter().map(|mode| mode["name"].as_str().unwrap()).collect();
    for name in ["car: lower sway", "car: upper sway", "car: bounce", "car: yaw", "car: pitch"] {
        assert!(names.contains(&name), "{names:?}");
    }
    // Two dampers side by side whose springs relax against each other: no body moves.
    let own = |mode: &serde_json::Value| {
        mode["name"].as_str().unwrap().contains("secondary_lateral_damper") && mode["parts"].as_array().unwrap().is_empty()
    };
    assert_eq!(all.iter().filter(|mode| own(mode)).count(), 2, "{names:?}");
    for mode in all.iter().filter(|mode| !own(mode)) {
        let shares: f64 = mode["parts"].as_array().unwrap().iter().map(|part| part["share"].as_f64().unwrap()).sum();
        assert!(shares > 0.5 && shares < 1.0 + 1e-9, "{mode}");
    }
}

#[test]
fn prop_a_sweep_has_a_locus_a_critical_speed_and_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("locus.svg");
    let sweep = ["suspended_wheelset", "--sweep", "vehicle.speed=216..252:18 km/h", "--plot", picture.to_str().unwrap()];
    let (words, said, code) = modes(&sweep);
    assert_eq!(code, 0, "{said}");
    assert!(words.contains("Linear critical speed: 65.82 m/s (237.0 km/h)") && said.contains("wrote"), "{words}{said}");
    assert!(std::fs::read_to_string(&picture).unwrap().contains("critical speed 65.8 m/s"));
    let (words, _, _) = modes(&["suspended_wheelset", "--sweep", "vehicle.speed=20..40:10"]);
    assert!(words.contains("No critical speed within the sweep"), "{words}");
    let (words, _, _) = modes(&["suspended_wheelset", "--sweep", "vehicle.speed=70..90:10"]);
    assert!(words.contains("Unstable at the lowest speed already") && words.contains("hunting"), "{words}");
}

/// Shapes are drawn with every body, in three views of each mode, and nothing moves that the mode doesn't move: the bounce of a car is upright.
#[test]
fn prop_shapes_of_modes_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("shapes.svg");
    let (words, said, code) = modes(&["vehicle_manchester_1", "--plot", picture.to_str().unwrap()]);
    assert!(code == 0 && said.contains("wrote") && words.contains("damping"), "{words}{said}");
    let svg = std::fs::read_to_string(&picture).unwrap();
    for text in ["Mode shapes", "from above", "from the front", "at rest", "bounce", "lower sway", "the 10 slowest of"] {
        assert!(svg.contains(text), "{text}");
    }
    // Nothing that swings: a word, and no picture.
    let (_, said, code) =
        modes(&["suspended_wheelset", "--set", "vehicle.suspension.lateral_damping=1e7", "--plot", picture.to_str().unwrap()]);
    assert!(code == 0 || said.contains("nothing to draw"), "{said}");
}

/// A two-axle wagon on leaf springs: its car sways and yaws long before its wheelsets hunt.
const WAGON: &str = r#"
[vehicle]
template = "free"
speed = 15.0
wheel_profile = { kind = "s1002", radius = 0.46 }

[[vehicle.body]]
name = "car"
mass = 24000.0
inertia_xx = 32000.0
inertia_yy = 420000.0
inertia_zz = 410000.0
position = [0.0, 0.0, 1.5]

[[vehicle.wheelset]]
name = "leading"
x = 4.5
mass = 1300.0
inertia_xx = 800.0
inertia_yy = 100.0
inertia_zz = 800.0
tread_circle_distance = 1.5
driven = true

[[vehicle.wheelset]]
name = "trailing"
x = -4.5
mass = 1300.0
inertia_xx = 800.0
inertia_yy = 100.0
inertia_zz = 800.0
tread_circle_distance = 1.5

[[vehicle.force]]
name = "leaf[1]"
kind = "bushing"
mirrored = true
from = "car"
to = "leading"
at = [4.5, 1.0, 0.46]
stiffness = [3.4e6, 3.2e6, 0.9e6]
damping = [3e3, 3e3, 2.0e3]
preload = "static"

[[vehicle.force]]
name = "leaf[2]"
kind = "bushing"
mirrored = true
from = "car"
to = "trailing"
at = [-4.5, 1.0, 0.46]
stiffness = [3.4e6, 3.2e6, 0.9e6]
damping = [3e3, 3e3, 2.0e3]
preload = "static"

[track]
gauge = "1435 mm"
inclination = "1:40"
rail = { kind = "60e1" }

[contact]
formulation = "ECF-A"
friction = 0.35
material = { youngs_modulus = 2.1e11, poisson_ratio = 0.28 }
creep = { law = "usetab" }

[run]
stop = 10.0
step = "5 ms"
"#;

#[test]
fn hard_a_car_that_sways_before_wheelsets_hunt_makes_the_critical_speed() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("wagon.toml");
    std::fs::write(&scene, WAGON).unwrap();
    let (words, said, code) = modes(&[scene.to_str().unwrap(), "--sweep", "vehicle.speed=15..45:10", "--json"]);
    assert_eq!(code, 0, "{said}");
    let found = &serde_json::from_str::<serde_json::Value>(&words).unwrap()["locus"];
    let (critical, onsets) = (&found["critical"], found["onsets"].as_array().unwrap());
    let growing = |point: &serde_json::Value| {
        point["modes"].as_array().unwrap().iter().filter(|mode| mode["growth"].as_f64().unwrap() > 1e-4).count()
    };
    let points: Vec<usize> = found["points"].as_array().unwrap().iter().map(growing).collect();
    println!("{critical} {onsets:?} {points:?}");
    let speed = critical["speed"].as_f64().unwrap();
    assert!(points[0] == 0 && points[3] > 0 && (15.0..45.0).contains(&speed) && onsets.len() >= points[3], "{words}");
    // From 25 to 35 m/s it changes from one of hunting to one of the car.
    assert!(critical["mode"].as_str().unwrap().contains("car: yaw"), "{critical}");
    let text = modes(&[scene.to_str().unwrap(), "--sweep", "vehicle.speed=15..45:10"]).0;
    assert!(text.contains(&format!("Linear critical speed: {speed:.2} m/s")) && text.contains("car: "), "{text}");
}

/// On perfect track nothing sets hunting going: a truck above its critical speed runs on, in six steps, and `run` says what that hides. What does move says it itself.
#[test]
fn hard_a_rest_that_is_not_stable_is_told() {
    let said = |settings: &[&str]| {
        let set = settings.iter().flat_map(|setting| ["--set", setting]);
        wheelrail(&["run", "bogie", "--stop", "4"].into_iter().chain(set).collect::<Vec<_>>()).1
    };
    let (plain, fast) = ("track.deviation=[]", "vehicle.speed=90");
    let words = said(&[plain, fast]);
    assert!(words.contains("note: steady running at 90.0 m/s is not stable") && words.contains("at 6.60 Hz grows by 2.8"), "{words}");
    let curve = said(&[plain, fast, "track.node=[{distance=0,radius=6000,superelevation=\"-0.1 m\"}]"]);
    assert!(curve.contains("at 90.0 m/s in this curve is not stable") && curve.contains("hunting"), "{curve}");
    for quiet in [said(&[plain]), said(&[fast])] {
        assert!(!quiet.contains("is not stable"), "{quiet}");
    }
}

#[test]
fn hard_what_has_no_modes_is_refused_in_words() {
    let cases: &[(&[&str], &str)] = &[
        (&["vehicle_curve", "--set", "vehicle.initial.distance=45"], "on a transition; expected a straight or a constant curve"),
        (&["suspended_wheelset", "--sweep", "vehicle.speed=20"], "expected vehicle.speed=FROM..TO:STEP"),
        (&["suspended_wheelset", "--sweep", "contact.friction=0..1:0.1"], "swept over vehicle.speed alone"),
        (&["suspended_wheelset", "--sweep", "vehicle.speed=20..10:1"], "expected the lowest speed first"),
        (&["suspended_wheelset", "--sweep", "vehicle.speed=20..30:1", "--plot", "/no/such/folder/x.svg"], "can't be written"),
        (&["suspended_wheelset", "--plot", "/no/such/folder/x.svg"], "can't be written"),
    ];
    for (arguments, sentence) in cases {
        let (words, said, code) = modes(arguments);
        assert!(code == 2 && said.contains(sentence) && words.is_empty(), "{arguments:?} said: {said}");
    }
}
