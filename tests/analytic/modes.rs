//! Modes against simulated motions, formulas and the linearisation of the implicit integrators.

use crate::common;
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::PI;
use wheelrail::formulation::Evaluation;
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::sim::Simulation;
use wheelrail::study::modes::rest::unstable_rest;
use wheelrail::study::modes::{Mode, Modes, locus, modes, modes_over, undisturbed};

fn open(name: &str, changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    load::open(name, &changes).unwrap_or_else(|error| panic!("{error}"))
}

fn found(scene: &Scene) -> Modes {
    modes(scene, scene.vehicle.speed).unwrap_or_else(|error| panic!("{error}"))
}

fn value(mode: &Mode) -> Complex<f64> {
    Complex::new(mode.growth, mode.angular_frequency)
}

/// The eigenvalue of a run that starts in a mode's shape, from lateral displacements of a body at equal times: of
/// `y(k+1) = p y(k) - q y(k-1)`, by least squares, the root with the positive imaginary part.
fn simulated(scene: &Scene, mode: &Mode, body: usize, periods: f64) -> Complex<f64> {
    // Small beside what laws are curved over.
    const AMPLITUDE: f64 = 1e-6;
    let scene = undisturbed(scene, scene.vehicle.speed).unwrap();
    let mut simulation: Simulation = common::start(&scene);
    let mut state = simulation.state().clone();
    let lateral = 6 * body + 1;
    let middle = state.integration.y[lateral];
    let [re, im] = mode.shape[lateral];
    let scale = AMPLITUDE / Complex::new(re, im);
    state.integration.y.iter_mut().zip(&mode.shape).for_each(|(y, part)| *y += (scale * Complex::new(part[0], part[1])).re);
    assert!(simulation.restore(&state));
    let step = 1.0 / mode.frequency / 16.0;
    let mut samples = Vec::new();
    for k in 1..=(16.0 * periods) as usize {
        simulation.advance(step * k as f64).unwrap_or_else(|error| panic!("{error}"));
        samples.push(simulation.solution()[lateral] - middle);
    }
    eigenvalue(&samples, step)
}

/// That of a swing read at equal times.
fn eigenvalue(samples: &[f64], step: f64) -> Complex<f64> {
    let rows = samples.len() - 2;
    let matrix = DMatrix::from_fn(rows, 2, |i, j| samples[i + 1 - j]);
    let next = DVector::from_fn(rows, |i, _| samples[i + 2]);
    let found = matrix.svd(true, true).solve(&next, 1e-14).unwrap();
    let (p, q) = (found[0], -found[1]);
    let root = Complex::new(0.5 * p, (q - 0.25 * p * p).max(0.0).sqrt());
    root.ln() / step
}

/// Of hunting, the relative distance from what a run does.
fn compare(scene: &Scene, body: usize, periods: f64) -> f64 {
    let all = found(scene);
    let mode = all.hunting().unwrap();
    let (wanted, measured) = (value(mode), simulated(scene, mode, body, periods));
    let distance = (measured - wanted).norm() / wanted.norm();
    println!("{} at {} m/s: {wanted:.6} found, {measured:.6} simulated: {distance:.1e}", scene.name, scene.vehicle.speed);
    distance
}

const TIGHT: [&str; 2] = ["solver.integrator=dormand_prince", "solver.tolerance=1e-12"];

#[test]
fn analytic_hunting_of_a_wheelset_grows_as_simulated() {
    // Below, near and above the critical speed.
    for speed in ["vehicle.speed=40", "vehicle.speed=64", "vehicle.speed=80"] {
        for formulation in ["contact.formulation=ECF-A", "contact.formulation=ECCF"] {
            let scene = open("suspended_wheelset", &[TIGHT[0], TIGHT[1], speed, formulation]);
            assert!(compare(&scene, 0, 4.0) < 1e-6);
        }
    }
    for formulation in ["contact.formulation=ECF-A", "contact.formulation=ECCF"] {
        let scene = open("wheelset_s1002", &[TIGHT[0], TIGHT[1], formulation]);
        assert!(compare(&scene, 0, 2.0) < 1e-4);
    }
}

#[test]
fn analytic_hunting_of_a_coach_grows_as_simulated() {
    for speed in ["vehicle.speed=50", "vehicle.speed=60"] {
        let scene = open("vehicle_manchester_1", &["solver.integrator=dormand_prince", "solver.tolerance=1e-10", speed]);
        assert!(compare(&scene, 0, 4.0) < 1e-4);
    }
}

/// Polach's law has no derivative where creepage vanishes: slopes by one coordinate after the other say that this wheelset hunts (+0.0415 1/s), runs say that it does not.
#[test]
fn analytic_small_swings_of_a_law_without_a_derivative_grow_as_simulated() {
    let cone = [
        "vehicle.speed=52.1",
        "vehicle.wheelset={mass=1600, inertia_xx=700, inertia_yy=120, inertia_zz=700, vertical_load=90e3, tread_circle_distance=\"1500 mm\", profile={kind=\"cone\", radius=0.46, slope=0.15}}",
        "vehicle.suspension={distance=2, longitudinal_stiffness=8e5, longitudinal_damping=5e3, lateral_stiffness=1e5, lateral_damping=0}",
        "track={rail_distance=\"1500 mm\", inclination=\"0.15 rad\", rail={kind=\"arc\", radius=0.3}}",
        "contact={formulation=\"ECF-A\", patch=\"ellipse\", friction=0.4, creep={law=\"polach\"}, material={youngs_modulus=2.1e11, poisson_ratio=0.28}}",
    ];
    let scene = open("suspended_wheelset", &[&TIGHT[..], &cone[..]].concat());
    let all = found(&scene);
    let mode = all.hunting().unwrap();
    let measured = simulated(&scene, mode, 0, 6.0);
    println!("{:+.4} found, {:+.4} simulated, {:?} beside slopes", mode.growth, measured.re, all.kinked);
    assert!((mode.growth - measured.re).abs() < 2e-3 && mode.growth < -0.04 && all.kinked.is_some_and(|most| most > 0.08));
    let smooth = open("suspended_wheelset", &[&TIGHT[..], &cone[..], &["contact.creep.law=fastsim"]].concat());
    assert_eq!(found(&smooth).kinked, None);
}

/// A free wheelset at walking speed rolls without slip: Klingel's wave, longer by the roll of the axle over the rails. The independent implementation under
/// `tests/reference` has the conicity 0.02567142 and the wavelength 22.6138550 m (see `analytic_klingel_wavelength_with_the_roll_term`).
#[test]
fn analytic_wavelength_of_a_free_wheelset_is_klingels() {
    let free = ["longitudinal_stiffness", "longitudinal_damping", "lateral_stiffness"].map(|key| format!("vehicle.suspension.{key}=0"));
    let mut changes: Vec<&str> = free.iter().map(String::as_str).collect();
    changes.push("vehicle.speed=2");
    let all = found(&open("suspended_wheelset", &changes));
    let mode = all.hunting().unwrap();
    let klingel = 2.0 * PI * (0.457 * 0.716 / 0.025_671_42f64).sqrt();
    let wavelength = all.speed / mode.frequency;
    println!("{wavelength:.6} m, Klingel {klingel:.4} m, growth {:.1e} 1/s", mode.growth);
    assert!((wavelength / 22.613_855 - 1.0).abs() < 1e-6);
    assert!((wavelength / klingel - 1.0).abs() < 0.01);
    assert!(mode.damping.abs() < 2e-3);
}

/// Car and frames on their springs, dampers in series with springs: `(M s^2 + K2)(m s^2 + K1 + K2) = K2^2` with `K(s) = k + 1 / (1 / (c s) + 1 / k')`, by
/// Newton's method from what was found.
#[test]
fn analytic_bounce_of_a_coach() {
    let all = found(&open("vehicle_manchester_1", &[]));
    let (car, frames) = (32000.0, 2.0 * 2615.0);
    let stiffness = |s: Complex<f64>, count: f64, k: f64, c: f64, series: f64| count * (k + 1.0 / (1.0 / (c * s) + 1.0 / series));
    let rest = |s: Complex<f64>| {
        let primary = stiffness(s, 8.0, 1220e3, 4e3, 1e6);
        let secondary = stiffness(s, 4.0, 430e3, 20e3, 6e6);
        (car * s * s + secondary) * (frames * s * s + primary + secondary) - secondary * secondary
    };
    for name in ["car: bounce", "truck[1].frame + truck[2].frame: bounce, in phase"] {
        let mode = all.modes.iter().find(|mode| mode.name == name && mode.frequency > 0.0).unwrap_or_else(|| panic!("{name}"));
        let mut s = value(mode);
        for _ in 0..20 {
            let h = 1e-6 * s.norm();
            let slope = (rest(s + h) - rest(s - h)) / (2.0 * h);
            s -= rest(s) / slope;
        }
        let distance = (value(mode) - s).norm() / s.norm();
        println!("{name}: {:.6} Hz, by hand {:.6} Hz, {distance:.1e}", mode.frequency, s.im / (2.0 * PI));
        // Frames stand on contacts of finite stiffness, and the traction rod is not level.
        assert!(distance < 1e-3);
    }
}

/// Contacts that are constraints leave the same free motions however they are written.
#[test]
fn equiv_constraint_formulations_have_the_same_modes() {
    for (name, limit) in [("suspended_wheelset", 1e-5), ("wheelset_s1002", 1e-4)] {
        let [eccf, accf] = ["ECCF", "ACCF"].map(|formulation| found(&open(name, &[&format!("contact.formulation={formulation}")])));
        assert_eq!((eccf.free, accf.free), (5, 5));
        for (a, b) in eccf.modes.iter().zip(&accf.modes) {
            let distance = (value(a) - value(b)).norm() / value(a).norm();
            println!("{name}, {}: {:.6} {:.6}: {distance:.1e}", a.name, value(a), value(b));
            assert!(distance < limit);
        }
    }
}

/// The Jacobian of the implicit integrators against differences: what it leaves out (how the curvatures of real profiles change as contacts move) counts in
/// hunting, where large parts cancel out, and nowhere else. Runs side with differences, see above.
#[test]
fn analytic_eigenvalues_of_the_tangent() {
    for (name, limit, hunting, changes) in [
        ("suspended_wheelset", 2e-3, 1e-4, &[][..]),
        ("vehicle_manchester_1", 1e-2, 0.1, &[]),
        // Of linear contact nothing is left out.
        ("wheelset_s1002", 1e-4, 1e-5, &["contact.patch=linear"]),
        ("vehicle_manchester_1", 1e-4, 1e-5, &["contact.patch=linear"]),
    ] {
        let scene = open(name, changes);
        let all = found(&scene);
        let scene = undisturbed(&scene, scene.vehicle.speed).unwrap();
        let simulation = common::start(&scene);
        let model = simulation.model();
        let (y, memory) = (&simulation.state().integration.y, &simulation.state().memories.accepted);
        let (inputs, mut workspace) = (model.start_inputs(), model.workspace());
        model.prepare_tangent(&mut workspace);
        let (mut dy, mut trial) = (vec![0.0; y.len()], memory.clone());
        model.derivative(&mut workspace, Evaluation { t: 0.0, inputs: &inputs, y, memory: &mut trial }, &mut dy).unwrap();
        model.linearise(&mut workspace, (y, memory), &inputs, true);
        let (n, a) = (y.len(), 1e-3);
        model.factorise(&mut workspace, a).unwrap();
        let mut inverse = DMatrix::zeros(n, n);
        for j in 0..n {
            let mut x = vec![0.0; n];
            x[j] = 1.0;
            model.solve_linear(&mut workspace, &mut x);
            inverse.set_column(j, &DVector::from_vec(x));
        }
        let tangent = (DMatrix::identity(n, n) - inverse.try_inverse().unwrap()) / a;
        let values = tangent.complex_eigenvalues();
        for mode in all.modes.iter().filter(|mode| mode.frequency > 0.0 && mode.damping < 0.9) {
            let own = value(mode);
            let distance =
                values.iter().map(|other| (own - Complex::new(other.re, other.im)).norm()).fold(f64::INFINITY, f64::min) / own.norm();
            println!("{name}, {}: {own:.4}: {distance:.1e}", mode.name);
            assert!(distance < if mode.hunting { hunting } else { limit }, "{name}, {}: {distance:e}", mode.name);
        }
    }
}

/// docs/accuracy.md finds 66 m/s from runs.
#[test]
fn analytic_critical_speed_of_the_suspended_wheelset() {
    let scene = open("suspended_wheelset", &[]);
    let found = locus::locus(&scene, &[20.0, 50.0, 80.0], || {}).unwrap();
    let critical = found.critical.unwrap();
    println!("{critical:?}");
    assert!((critical.speed - 65.8).abs() < 0.1 && critical.mode.starts_with("hunting"));
    let growth = |speed: f64| modes(&scene, speed).unwrap().hunting().unwrap().growth;
    assert!(growth(critical.speed - 0.1) < 0.0 && growth(critical.speed + 0.1) > 0.0);
}

/// What nothing depends on is left out, not found as a noisy zero; the speed of a free vehicle is its own, neutral motion.
#[test]
fn prop_travel_and_turns_are_left_out() {
    for name in ["suspended_wheelset", "vehicle_manchester_1"] {
        let [imposed, free] = ["imposed", "free"].map(|travel| found(&open(name, &[&format!("vehicle.travel={travel}")])));
        let neutral = |modes: &Modes| modes.modes.iter().filter(|mode| mode.neutral).count();
        assert_eq!((neutral(&imposed), neutral(&free)), (0, 1), "{name}");
        assert!(free.left_out.iter().any(|words| words.starts_with("travel")), "{:?}", free.left_out);
        assert!(imposed.left_out.iter().any(|words| words.ends_with("(imposed)")), "{:?}", imposed.left_out);
    }
}

#[test]
fn hard_a_scene_on_a_transition_is_refused() {
    let scene = open("vehicle_curve", &["vehicle.initial.distance=45"]);
    let error = modes(&scene, scene.vehicle.speed).unwrap_err().to_string();
    assert!(error.contains("on a transition; expected a straight or a constant curve"), "{error}");
    // Limit cycles and equivalent slopes are those of straight track.
    let scene = open("vehicle_curve", &["vehicle.initial.distance=150"]);
    for (change, words) in
        [("contact.formulation=ACCF", "expected contact.formulation = \"ECCF\""), ("vehicle.travel=free", "expected an imposed speed")]
    {
        let error = modes(&open("vehicle_curve", &["vehicle.initial.distance=150", change]), 20.0).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    for error in [modes_over(&scene, 20.0, 1e-3).unwrap_err(), undisturbed(&scene, 20.0).err().unwrap()] {
        assert!(error.to_string().contains("in a curve; expected a straight"), "{error}");
    }
}

/// A truck in curves, by cant and hand: the eigenvalue of a run that starts beside steady curving in the shape of hunting, which is another one than on straight track.
#[test]
fn analytic_hunting_in_a_curve_grows_as_simulated() {
    // It grows thirtyfold.
    const AMPLITUDE: f64 = 1e-7;
    for (radius, cant, speed) in [(6000.0, -0.1, 90.0), (-2500.0, 0.15, 70.0)] {
        let node = format!("track.node=[{{distance=0,radius={radius},superelevation=\"{cant} m\"}}]");
        // Strips are curved within a micrometre (0.6 %).
        let plain = ["track.deviation=[]", "contact.patch=table", &format!("vehicle.speed={speed}")];
        let (scene, straight) = (open("bogie", &[&plain[..], &TIGHT, &[&node]].concat()), open("bogie", &plain));
        let all = found(&scene);
        let (mode, there) = (all.hunting().unwrap(), found(&straight).hunting().map(value).unwrap());
        let mut simulation = common::start(&scene);
        let mut state = simulation.state().clone();
        let lateral = |simulation: &mut Simulation| simulation.snapshot().unwrap().workspace.beside_track(0)[0];
        let middle = lateral(&mut simulation);
        let [re, im] = mode.shape[1];
        let scale = AMPLITUDE / Complex::new(re, im);
        let moved: Vec<f64> = mode.shape.iter().map(|part| (scale * Complex::new(part[0], part[1])).re).collect();
        let count = 6 * simulation.model().system.bodies.len();
        let courses: Vec<f64> =
            (0..count).step_by(6).map(|first| state.integration.y[count + first + 1].atan2(state.integration.y[count + first])).collect();
        for (i, y) in state.integration.y.iter_mut().enumerate() {
            let (first, axis) = (i - i % 6, i % 6);
            // Shapes are along and across each body's course.
            let world = match (axis, courses.get(first % count / 6).filter(|_| i < 2 * count)) {
                (0, Some(course)) => moved[i] * course.cos() - moved[i + 1] * course.sin(),
                (1, Some(course)) => moved[i - 1] * course.sin() + moved[i] * course.cos(),
                _ => moved[i],
            };
            *y += world;
        }
        assert!(simulation.restore(&state));
        let step = 1.0 / mode.frequency / 16.0;
        let mut samples = Vec::new();
        for k in 1..=48 {
            simulation.advance(step * f64::from(k)).unwrap_or_else(|error| panic!("{error}"));
            samples.push(lateral(&mut simulation) - middle);
        }
        let (wanted, measured) = (value(mode), eigenvalue(&samples, step));
        println!("R {radius} m: {wanted:.5} found, {measured:.5} simulated, {there:.5} on straight track");
        assert!((measured - wanted).norm() < 3e-4 * wanted.norm() && (there - wanted).norm() > 10.0 * (measured - wanted).norm());
        assert!(all.unbalanced < 1e-3, "{}", all.unbalanced);
    }
}

/// Equal vehicles have equal eigenvalues, whose vectors are any of a whole space: three coaches that nothing couples bounced at -6e10 Hz.
#[test]
fn regress_equal_vehicles_swing_as_one_does() {
    // Each coach keeps its own speed: a pulled one pitches otherwise.
    let [train, coach] = ["train", "vehicle_manchester_1"].map(|name| open(name, &["track.deviation=[]", "vehicle.drive=all"]));
    let (train, coach) = (found(&train), found(&coach));
    println!("{:?} {:?}", train.kinked, coach.kinked);
    assert!(train.growing().count() == 0 && coach.growing().count() == 0);
    for mode in &coach.modes {
        let alike = train.modes.iter().filter(|other| (value(other) - value(mode)).norm() < 1e-3 * value(mode).norm().max(0.1)).count();
        assert!(alike >= 3, "{}: {} of {:?}", mode.name, alike, value(mode));
    }
}

/// With an amplitude, strips have the hunting of their table, whose nodes are as far apart as slopes over them, and on cones nothing changes; at half a millimetre it is that of a wheelset that swings so.
/// Rails that lie aside for good are another gauge: a truck at 65 m/s is stable on 1432 mm and hunts on 1435 mm, whether nominal or by rails that moved apart before; and a run that rests there says so.
#[test]
fn equiv_rails_that_lie_aside_for_good_are_another_gauge() {
    let apart = |by: &str| {
        let rail = |side: &str, amplitude: String| {
            format!("{{rail=\"{side}\", direction=\"lateral\", shape=\"ramp\", amplitude=\"{amplitude} mm\", from=-200, to=-100}}")
        };
        format!(
            "track.deviation=[{}, {}]",
            rail("left", by.to_string()),
            rail("right", by.strip_prefix('-').map_or(format!("-{by}"), str::to_string))
        )
    };
    let scene = |gauge: &str, deviation: &str| {
        open(
            "bogie",
            &["vehicle.speed=65", &format!("track.gauge=\"{gauge} mm\""), deviation, "contact.patch=ellipse", "solver.tolerance=1e-6"],
        )
    };
    let none = "track.deviation=[]";
    for (gauge, other, by, grows) in [("1435", "1432", "1.5", true), ("1432", "1435", "-1.5", false)] {
        let (nominal, moved) = (scene(gauge, none), scene(other, &apart(by)));
        let [one, two] = [&nominal, &moved].map(|scene| found(scene).hunting().unwrap().growth);
        println!("{gauge} mm: growth {one:.5}, by rails that moved {two:.5} 1/s");
        assert!((one - two).abs() < 1e-4 * one.abs() && (one > 0.0) == grows, "{gauge}: {one} {two}");
        let mut simulation = Simulation::new(&moved, 0.0).unwrap();
        simulation.advance(0.5).unwrap();
        let said = unstable_rest(&moved, &mut simulation);
        assert_eq!(said.is_some(), grows, "{said:?}");
    }
}

#[test]
fn analytic_equivalent_slopes_are_those_over_some_strips() {
    let frequency = |name: &str, patch: &str, amplitude: f64| {
        let changes = [format!("contact.patch={patch}"), "track.deviation=[]".into()];
        let scene = load::open(name, &changes).unwrap();
        let found = modes_over(&scene, scene.vehicle.speed, amplitude).unwrap();
        let mode = found.hunting().unwrap();
        println!("{name}, {patch}, {:.2} mm: {:.4} Hz, {:.4} 1/s", 1e3 * amplitude, mode.frequency, mode.growth);
        mode.frequency
    };
    for name in ["wheelset_s1002", "vehicle_manchester_1"] {
        let [point, over, table] =
            [("strips", 0.0), ("strips", 5e-4), ("table", 5e-4)].map(|(patch, amplitude)| frequency(name, patch, amplitude));
        assert!((over / table - 1.0).abs() < 0.02 && (point / table - 1.0).abs() > 0.04, "{name}");
    }
    let [point, over] = [0.0, 5e-4].map(|amplitude| frequency("suspended_wheelset", "strips", amplitude));
    assert!((over / point - 1.0).abs() < 1e-3);
}

/// At the amplitude of a limit cycle (docs/modes.md; found by continuation) hunting has its frequency and hardly grows or dies away: what saturation of creep forces does is left out.
#[test]
fn analytic_equivalent_slopes_are_neutral_at_a_limit_cycle() {
    for (speed, amplitude, cycle) in [(36.0, 3.493e-4, 7.0861), (39.0, 2.611e-4, 7.5240), (42.0, 1.597e-4, 7.8439)] {
        let changes = ["contact.patch=ellipse".to_string(), "track.deviation=[]".into()];
        let found = modes_over(&load::open("wheelset_s1002", &changes).unwrap(), speed, amplitude).unwrap();
        let mode = found.by_damping().into_iter().find(|mode| mode.hunting).unwrap();
        println!("{speed} m/s, {:.3} mm: {:.4} Hz for {cycle} Hz, damping {:.2} %", 1e3 * amplitude, mode.frequency, 100.0 * mode.damping);
        assert!((mode.frequency / cycle - 1.0).abs() < 6e-3 && mode.damping.abs() < 7e-3);
    }
}

/// A wheelset bounces on rails on sleepers: its frequency and damping are those of a mass on a contact spring on an endless Euler beam on two layers (with the bay's masses, pads and ballast
/// spread along it), `D(s) = 8 EI (k(s) / 4 EI)^(3/4)`, found by Newton in the complex plane.
#[test]
fn analytic_wheelsets_bounce_on_beam_rails_as_on_an_endless_beam() {
    for (pad, ballast) in [(16e3, 80e3), (2e3, 8e3)] {
        let track = format!("track.flexibility={{model=\"beam\", pad_damping={pad}, ballast_damping={ballast}}}");
        let scene = open("suspended_wheelset", &["vehicle.speed=40", &track]);
        let all = found(&scene);
        let bounce = all.modes.iter().find(|mode| mode.name == "wheelset: bounce").unwrap();
        let c = |re: f64| Complex::new(re, 0.0);
        let bending = 210e9 * 3038.3e-8;
        let dynamic = |s: Complex<f64>| {
            let (upper, lower) = (c(200e6) + s * pad, c(50e6) + s * ballast + s * s * 150.0);
            let bed = (upper * lower / (upper + lower)) / 0.6 + s * s * 60.21;
            c(8.0 * bending) * (bed / (4.0 * bending)).powf(0.75)
        };
        // Half the wheelset on its contact and rail; the suspension is soft.
        let half = 0.5 * scene.vehicle.wheelsets[0].spec.mass;
        let contact = 1.5 * bounce_stiffness(&scene);
        let rest = |s: Complex<f64>| s * s * half + (c(contact).inv() + dynamic(s).inv()).inv();
        let mut s = Complex::new(-20.0, 300.0);
        for _ in 0..50 {
            let step = c(1e-3);
            s -= rest(s) * (step * 2.0) / (rest(s + step) - rest(s - step));
        }
        println!("pad {pad}, ballast {ballast}: {:.2} {:.2} 1/s, endless beam {s:.2}", bounce.growth, bounce.angular_frequency);
        let off = (value(bounce) - s) / s.norm();
        assert!(off.im.abs() < 0.03 && off.re.abs() < 0.005, "{} {s}", value(bounce));
        assert!(all.track.as_ref().unwrap().contains("the beam's answer at"));
    }
}

/// Of a contact under the static load, over its approach, N/m.
fn bounce_stiffness(scene: &Scene) -> f64 {
    let mut simulation = Simulation::new(&undisturbed(scene, scene.vehicle.speed).unwrap(), 0.0).unwrap();
    let report = simulation.snapshot().unwrap().workspace.contacts[0];
    report.normal_force / report.penetration
}

/// A motor's torque is in the balance of modes: hunting under traction grows as a run's does (without: -0.047 for +0.033 1/s). Its rotor is a part of modes.
#[test]
fn analytic_modes_know_traction_and_rotors() {
    let path = common::data("driven_wheelset.toml");
    let driven = |changes: &[&str]| open(path.to_str().unwrap(), changes);
    let scene = driven(&["vehicle.speed=36", "vehicle.force[motor].torque=2500"]);
    let all = found(&scene);
    let hunting = all.hunting().unwrap();
    assert!(all.unbalanced < 1e-3 && (hunting.growth - 0.033).abs() < 2e-3, "{} {}", all.unbalanced, hunting.growth);
    let coasting = found(&driven(&["vehicle.speed=36", "vehicle.force[motor].torque=0"])).hunting().unwrap().growth;
    assert!(coasting < -0.04, "{coasting}");
    // A brake that has come to its torque (at the start of a run it has not): a run at 36 m/s fades by 0.412 1/s.
    let braked =
        found(&driven(&["vehicle.speed=36", "vehicle.force[motor].torque=0", "vehicle.force[brake].torque=1e4"])).hunting().unwrap().growth;
    assert!((braked + 0.412).abs() < 5e-3, "{braked}");
    let (inertia, stiffness, ratio) = (8.0, 4000.0, 4.0_f64);
    let rotor = [
        format!("vehicle.force[motor].rotor_inertia={inertia}"),
        format!("vehicle.force[motor].stiffness={stiffness}"),
        "vehicle.force[motor].damping=0".into(),
    ];
    let rotor: Vec<&str> = rotor.iter().map(String::as_str).collect();
    let all = found(&driven(&[&["vehicle.speed=30", "vehicle.force[motor].torque=0"], &rotor[..]].concat()));
    let mode = all.modes.iter().find(|mode| mode.name == "motor: rotor").unwrap();
    let formula = (stiffness / (ratio * ratio * inertia)).sqrt() / (2.0 * PI);
    println!("rotor {:.4} Hz, formula {formula:.4}, share {:.3}", mode.frequency, mode.parts[0].share);
    assert!((mode.frequency / formula - 1.0).abs() < 0.02 && mode.parts[0].share > 0.9);
}

/// Eigenvalues are no slopes of a grid.
#[test]
fn prop_half_spaces_have_no_modes() {
    let scene = open("wheelset_s1002", &["contact.patch=exact", "contact.creep={law=\"exact\"}"]);
    let said = modes(&scene, 20.0).unwrap_err().to_string();
    assert!(said.contains("expected contact.patch = \"strips\""), "{said}");
}

/// Named is what begins to grow, not what grows least: a truck's car sways a little at all speeds, and its hunting that begins at 53 m/s was called that.
#[test]
fn regress_what_begins_to_grow_is_named() {
    let scene = open("bogie", &["contact.patch=ellipse"]);
    let found = locus::locus(&scene, &[50.0, 56.0], || {}).unwrap_or_else(|error| panic!("{error}"));
    println!("{:?}, growing before: {:?}", found.onsets, found.growing_at_lowest().map(|mode| &mode.name).collect::<Vec<_>>());
    let hunting = found.onsets.last().expect("no onset");
    assert!(found.growing_at_lowest().any(|mode| mode.name.starts_with("car")));
    assert!(hunting.mode.contains("hunting") && (hunting.frequency - 8.4).abs() < 0.2, "{hunting:?}");
}
