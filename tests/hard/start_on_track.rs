//! Starts where rails are displaced: the vehicle stands on them as they are there and moves as one that came along.

use crate::common::start;
use wheelrail::formulation::contact_index;
use wheelrail::geometry::Side;
use wheelrail::mbs::body::COORDINATES;
use wheelrail::scene::spec::Scene;
use wheelrail::scene::{assemble, load, plan};
use wheelrail::sim::Simulation;

const FORMULATIONS: [&str; 4] = ["ECF-A", "ECF-N", "ECCF", "ACCF"];

fn scene(name: &str, changes: &[String]) -> Scene {
    let all: Vec<String> = ["track.deviation=[]".to_string()].iter().chain(changes).cloned().collect();
    load::open(name, &all).unwrap_or_else(|error| panic!("{error}"))
}

fn rough(spectrum: &str, seed: u32, scale: f64) -> String {
    format!("track.irregularity=[{{kind=\"spectrum\",spectrum=\"{spectrum}\",seed={seed},from=-50,to=400,scale={scale:?}}}]")
}

/// Vertical forces of all wheels now, N.
fn loads(simulation: &mut Simulation) -> Vec<f64> {
    let bodies: Vec<usize> = simulation.model().wheelsets.iter().map(|wheelset| wheelset.body).collect();
    let workspace = &simulation.snapshot().unwrap().workspace;
    let both =
        bodies.into_iter().enumerate().flat_map(|(i, body)| Side::BOTH.map(|side| workspace.wheel_force(contact_index(i, side), body).z));
    both.collect()
}

/// What each wheel of a free vehicle carries on these rails: its static load and what the rails' curvature demands of the wheelset's mass and
/// roll inertia, N.
fn demanded(scene: &Scene, simulation: &Simulation) -> Vec<f64> {
    let (model, free) = (simulation.model(), &scene.vehicle);
    let (square, base) = (scene.vehicle.speed.powi(2), 2.0 * scene.track.half_rail_distance);
    let both = model.wheelsets.iter().zip(&free.wheelsets).flat_map(|(wheelset, placed)| {
        let [left, right] = Side::BOTH.map(|side| model.track.rail(side).deviation(free.initial.values[0] + placed.x)[1][2]);
        let up = 0.5 * placed.spec.mass * square * 0.5 * (left + right);
        let over = placed.spec.transverse_inertia * square * (left - right) / (base * base);
        [up + over, up - over].map(|inertial| wheelset.static_wheel_load + inertial)
    });
    both.collect()
}

/// A truck at 50 m/s on FRA 6 at half scale: it was put into the rails or above them (both wheels of an axle in the air, then 540 kN). Each wheel
/// carries what statics and curved rails ask for, within 10 % of the static load (twist and dampers make the rest).
#[test]
fn hard_wheels_carry_their_loads_at_a_start_on_rough_track() {
    let mut worst = 0.0f64;
    for seed in 1..=24 {
        let scene = scene("bogie", &[rough("fra6", seed, 0.5), "vehicle.speed=50".into()]);
        let mut simulation = start(&scene);
        let wanted = demanded(&scene, &simulation);
        let fixed = simulation.model().wheelsets[0].static_wheel_load;
        for (found, wanted) in loads(&mut simulation).into_iter().zip(wanted) {
            worst = worst.max((found - wanted).abs() / fixed);
        }
    }
    println!("largest difference: {:.1} % of the static load", 100.0 * worst);
    assert!(worst < 0.1, "{worst}");
}

/// The largest load of the first half second against that of a run that came from 100 m before the irregularity begins.
#[test]
fn equiv_loads_after_the_start_are_those_of_a_vehicle_that_came_along() {
    for seed in [1, 2, 3] {
        let changes = [rough("fra6", seed, 0.5), "vehicle.speed=50".into()];
        let largest = |distance: f64, from: f64| {
            let mut all = changes.to_vec();
            all.push(format!("vehicle.initial.distance={distance:?}"));
            let mut simulation = start(&scene("bogie", &all));
            let mut most = 0.0f64;
            for step in 0..=250 {
                simulation.advance(from + 2e-3 * f64::from(step)).unwrap();
                most = loads(&mut simulation).into_iter().fold(most, f64::max);
            }
            most
        };
        let (own, far) = (largest(0.0, 0.0), largest(-150.0, 3.0));
        println!("seed {seed}: {own:.0} N, {far:.0} N from far");
        assert!((own / far - 1.0).abs() < 0.1, "{seed}: {own} {far}");
    }
}

/// All vehicles and formulations, slow and fast, straight and in a curve: every wheel is on its rail and presses, rigid contacts are closed
/// and stay so.
#[test]
fn hard_no_start_on_displaced_rails_leaves_a_wheel_in_the_air() {
    let curve = "track.node=[{distance=0.0,radius=-5000.0,superelevation=\"0.05 m\"}]".to_string();
    for (name, speed, spectrum) in [
        ("bogie", 0.5, "fra5"),
        ("bogie", 80.0, "ore_b176_high"),
        ("vehicle_manchester_1", 40.0, "ore_b176_high"),
        ("vehicle_equalised", 20.0, "ore_b176_high"),
        ("suspended_wheelset", 40.0, "fra5"),
        ("wheelset_s1002", 30.0, "fra6"),
        ("train", 30.0, "ore_b176_low"),
    ] {
        for formulation in FORMULATIONS {
            for curved in [false, true] {
                let costly = matches!(name, "train" | "vehicle_equalised");
                if costly && (curved || formulation == "ACCF" || formulation == "ECF-N") {
                    continue;
                }
                let mut changes = vec![rough(spectrum, 7, 1.0), format!("vehicle.speed={speed:?}"), "contact.on_lift=elastic".into()];
                changes.push(format!("contact.formulation={formulation}"));
                changes.extend(curved.then(|| curve.clone()));
                let mut simulation = Simulation::new(&scene(name, &changes), 0.0)
                    .unwrap_or_else(|error| panic!("{name} {speed} {formulation} {curved}: {error}"));
                let fixed = simulation.model().wheelsets[0].static_wheel_load;
                let found = loads(&mut simulation);
                let least = found.iter().copied().fold(f64::INFINITY, f64::min);
                let most = found.iter().copied().fold(0.0, f64::max);
                assert!(least > 0.4 * fixed && most < 1.7 * fixed, "{name} {speed} {formulation} {curved}: {least} {most}");
                let workspace = &simulation.snapshot().unwrap().workspace;
                for report in workspace.contacts.iter().filter(|report| report.constrained) {
                    assert!(report.penetration.abs() < 1e-10, "{name} {formulation}: {}", report.penetration);
                    assert!(report.penetration_rate.abs() < 1e-9, "{name} {formulation}: {}", report.penetration_rate);
                }
            }
        }
    }
}

/// Measured track: the vehicle starts within the first metres of the file, where it still fades in, and in the midst of it.
#[test]
fn hard_a_start_on_measured_track() {
    let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("start_on_track.csv");
    let wave = |s: f64, length: f64| (std::f64::consts::TAU * s / length).sin();
    let row = |s: f64| format!("{s},{},{},{}\n", 4.0 * wave(s, 23.0), 5.0 * wave(s, 31.0) + 0.5 * wave(s, 4.0), 3.0 * wave(s, 17.0));
    let rows: String = (0..1200).map(|i| row(-1.5 + 0.25 * f64::from(i))).collect();
    std::fs::write(&file, format!("distance [m],alignment [mm],longitudinal_level [mm],cross_level [mm]\n{rows}")).unwrap();
    // An embedded scene has no folder for files.
    let copy = file.with_file_name("start_on_track_bogie.toml");
    std::fs::copy(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("fmu/scenes/bogie.toml"), &copy).unwrap();
    let series = "track.irregularity=[{kind=\"series\",file=\"start_on_track.csv\"}]".to_string();
    for distance in [-1.28, 2.0, 8.0, 100.0] {
        for formulation in ["ECF-A", "ECCF"] {
            let changes = [series.clone(), format!("vehicle.initial.distance={distance:?}"), format!("contact.formulation={formulation}")];
            let scene = scene(copy.to_str().unwrap(), &changes);
            let mut simulation = start(&scene);
            let (wanted, fixed) = (demanded(&scene, &simulation), simulation.model().wheelsets[0].static_wheel_load);
            for (found, wanted) in loads(&mut simulation).into_iter().zip(wanted) {
                assert!((found - wanted).abs() < 0.1 * fixed, "{distance} {formulation}: {found} {wanted}");
            }
            simulation.advance(0.2).unwrap();
        }
    }
}

/// Rails that are lifted all the way are as good as others: the same state, higher up.
#[test]
fn analytic_a_start_on_rails_that_are_lifted_alike() {
    let lifted = "track.deviation=[{rail=\"both\",direction=\"vertical\",shape=\"ramp\",amplitude=0.02,from=-60,to=-30}]".to_string();
    for name in ["bogie", "vehicle_equalised", "suspended_wheelset"] {
        let plain = start(&scene(name, &[]));
        let high = start(&load::open(name, std::slice::from_ref(&lifted)).unwrap());
        let bodies = plain.model().system.bodies.len();
        let (plain, high) = (&plain.state().integration.y, &high.state().integration.y);
        for i in 0..2 * COORDINATES * bodies {
            // The spin's equilibrium is flat, and with it how far creep bends the vehicle.
            let wanted = if i < COORDINATES * bodies && i % COORDINATES == 2 { plain[i] + 0.02 } else { plain[i] };
            assert!((high[i] - wanted).abs() < 1e-5, "{name} {i}: {} {wanted}", high[i]);
        }
    }
}

/// Where no rail is displaced under a wheel nothing changes, bit by bit; a fade makes the start that of ideal track and leaves the track in
/// front as it is.
#[test]
fn prop_undisplaced_and_faded_starts_are_those_of_ideal_track() {
    for name in ["bogie", "suspended_wheelset"] {
        let plain = start(&scene(name, &[]));
        let ahead = start(&scene(name, &[rough("fra6", 1, 1.0).replace("from=-50", "from=60")]));
        let changes = [rough("fra6", 1, 1.0), "track.start_fade=\"30 m\"".into()];
        let faded = scene(name, &changes);
        let fading = start(&faded);
        assert_eq!(plain.state().integration.y, ahead.state().integration.y, "{name}");
        assert_eq!(plain.state().integration.y, fading.state().integration.y, "{name}");
        let (bare, own) = (assemble::model(&scene(name, &changes[..1])).unwrap(), fading.model());
        let far = own.track.left.deviation(50.0);
        assert_eq!(bare.track.left.deviation(50.0), far);
        assert!(own.track.left.deviation(20.0) != bare.track.left.deviation(20.0) && own.track.left.deviation(20.0) != [[0.0; 4]; 2]);
    }
}

/// The plan says how the vehicle starts.
#[test]
fn prop_the_plan_says_how_the_start_stands() {
    let line = |changes: &[String]| {
        let scene = scene("bogie", changes);
        let plan = plan::plan(&scene, &assemble::model(&scene).unwrap());
        plan.effects.into_iter().find(|effect| effect.name == "start on displaced rails").map(|effect| effect.why)
    };
    let said = line(&[rough("fra6", 1, 1.0)]).unwrap();
    assert!(said.contains("mm out of place") && said.contains("track.start_fade"), "{said}");
    assert_eq!(line(&[]), None);
    assert_eq!(line(&[rough("fra6", 1, 1.0), "track.start_fade=20".into()]), None);
}

/// Values that a scene gives keep their meaning: absolute ones of a wheelset are what it starts with, others are added to the balance on the
/// displaced rails.
#[test]
fn prop_given_initial_values_are_kept() {
    let rails = rough("fra6", 3, 1.0);
    let given = ["vehicle.initial.y=0.002".to_string(), "vehicle.initial.vy=0.01".into(), rails.clone()];
    let absolute = [&given[..], &["vehicle.initial.from_equilibrium=false".into()]].concat();
    let state = |changes: &[String]| start(&scene("suspended_wheelset", changes)).state().integration.y.clone();
    let (found, added, free) = (state(&absolute), state(&given), state(std::slice::from_ref(&rails)));
    assert!((found[1] - 0.002).abs() < 1e-15 && (found[COORDINATES + 1] - 0.01).abs() < 1e-15, "{found:?}");
    assert!(free[1] != 0.0 && free[2] == found[2] && free[COORDINATES + 2] != 0.0);
    let off = [added[1] - free[1] - 0.002, added[COORDINATES + 1] - free[COORDINATES + 1] - 0.01, added[2] - free[2]];
    assert!(off.iter().all(|off| off.abs() < 1e-15), "{off:?}");
}

/// What can't be balanced is refused with place, reason and cure.
#[test]
fn hard_a_start_that_has_no_balance_is_refused() {
    let wide = "track.deviation=[{rail=\"right\",direction=\"lateral\",shape=\"ramp\",amplitude=-0.25,from=-60,to=-30}]".to_string();
    let scene = load::open("bogie", &[wide]).unwrap();
    let message = Simulation::new(&scene, 0.0).err().map(|error| error.to_string()).unwrap_or_default();
    assert!(message.contains("% of their displacements") && message.contains("track.start_fade"), "{message}");
    let tight = ["vehicle.speed=25".to_string(), "track.node=[{distance=0.0,radius=150.0,superelevation=0.0}]".into()];
    let refused = Simulation::new(&self::scene("vehicle_manchester_1", &tight), 0.0);
    let message = refused.err().map(|error| error.to_string()).unwrap_or_default();
    assert!(message.contains("no steady curving"), "{message}");
}

/// Wheels that are worn hollow stand on the field side of their treads, with up to 4 mm more of radius than the nominal one. Those of 1.5 mm and more slid so fast at the first try that no balance was found.
#[test]
fn prop_hollow_wheels_start() {
    let folder = tempfile::tempdir().unwrap();
    let scene = load::open("wheelset_s1002", &[]).unwrap();
    let profile = scene.vehicle.leading().profiles[0].profile.clone();
    std::fs::write(folder.path().join("s.toml"), include_str!("../../fmu/scenes/wheelset_s1002.toml")).unwrap();
    for hollow in [0.3e-3, 1.0e-3, 1.5e-3, 2.0e-3, 3.0e-3] {
        let (first, last) = profile.range();
        let next = |u: &f64| Some(u + 2.5e-4 / 1f64.hypot(profile.at(*u).d1));
        let worn = |u: f64| profile.at(u).value - hollow * (-((u - 0.004) / 0.018).powi(4)).exp();
        let rows: String =
            std::iter::successors(Some(first), next).take_while(|u| *u <= last).map(|u| format!("{u:.7},{:.7}\n", worn(u))).collect();
        std::fs::write(folder.path().join("w.csv"), format!("u,radius\n{rows}")).unwrap();
        for patch in ["strips", "ellipse"] {
            let changes = [
                "vehicle.wheelset.profile={kind=\"points\",file=\"w.csv\",radius=0.46}".to_string(),
                format!("contact.patch={patch}"),
                "track.deviation=[]".into(),
            ];
            let scene = load::open(&folder.path().join("s.toml").display().to_string(), &changes).unwrap_or_else(|error| panic!("{error}"));
            let mut simulation = start(&scene);
            let wheels = wheelrail::sim::statics::statics(&scene, &mut simulation).unwrap().wheels;
            println!("{:.1} mm, {patch}: {wheels:?}", 1e3 * hollow);
            let [left, right] = [wheels[0].left, wheels[0].right];
            assert!(left > 3e4 && (left / right - 1.0).abs() < 1e-6, "{left} {right}");
            simulation.advance(0.2).unwrap_or_else(|error| panic!("{error}"));
        }
    }
}

/// In a curve the search for where rails rest under flanges went on for minutes: its slopes did not know them. The vehicle starts in what it then keeps.
#[test]
fn hard_vehicles_start_in_curves_on_track_that_gives_way() {
    for (node, speed) in [("radius=\"500 m\",superelevation=\"-80 mm\"", 20.0), ("radius=\"-250 m\",superelevation=\"100 mm\"", 15.0)] {
        let track = format!("track.node=[{{distance=0,{node}}}]");
        let changes = |more: &[&str]| -> Vec<String> {
            let own = [track.clone(), "vehicle.drive=leading".into(), format!("vehicle.speed={speed}")];
            own.into_iter().chain(more.iter().map(|change| (*change).to_string())).collect()
        };
        let rigid = loads(&mut start(&scene("vehicle_manchester_1", &changes(&[]))));
        let yielding = scene("vehicle_manchester_1", &changes(&["track.flexibility=travelling"]));
        let mut simulation = start(&yielding);
        let before = loads(&mut simulation);
        simulation.advance(0.5).unwrap();
        let after = loads(&mut simulation);
        for ((rigid, before), after) in rigid.into_iter().zip(before).zip(after) {
            println!("{node}: {rigid:.0} {before:.0} {after:.0}");
            // The gauge widens and rails roll away: some per cent.
            assert!((after - before).abs() < 30.0 && (before - rigid).abs() < 0.05 * rigid, "{rigid} {before} {after}");
        }
    }
    let beam = scene(
        "vehicle_manchester_1",
        &[
            "track.node=[{distance=0,radius=\"500 m\",superelevation=\"-80 mm\"}]".into(),
            "vehicle.drive=leading".into(),
            "track.flexibility=beam".into(),
        ],
    );
    assert!(loads(&mut start(&beam)).iter().all(|load| *load > 1e4));
}

/// Rigid contacts with friction that falls with slip found no balance from the design configuration ("does not press on its rails"); by symmetry it is that of any law.
#[test]
fn hard_constraints_start_where_elastic_contact_does() {
    for formulation in ["ECCF", "ACCF", "ECF-A"] {
        let changes = [
            "vehicle.speed=20",
            "vehicle.wheelset.mass=700",
            "vehicle.wheelset.vertical_load=7400",
            "vehicle.wheelset.profile={ kind=\"cone\", radius=0.363, slope=0.1 }",
            "track.inclination=\"1:40\"",
            "track.rail={ kind=\"arc\", radius=0.3 }",
            "contact.friction=0.21",
            "contact.creep={ law=\"polach\", surface=\"dry\" }",
            &format!("contact.formulation={formulation}"),
        ]
        .map(String::from);
        let mut simulation = start(&scene("suspended_wheelset", &changes));
        simulation.advance(0.5).unwrap_or_else(|error| panic!("{formulation}: {error}"));
        let body = simulation.model().wheelsets[0].body;
        let snapshot = simulation.snapshot().unwrap_or_else(|error| panic!("{formulation}: {error}"));
        let loads = [0, 1].map(|contact| snapshot.workspace.wheel_force(contact, body).z);
        println!("{formulation}: Q {loads:?} N");
        assert!(loads.iter().all(|load| (load / (0.5 * (700.0 * 9.81 + 7400.0)) - 1.0).abs() < 2e-5), "{formulation}: {loads:?}");
    }
}
