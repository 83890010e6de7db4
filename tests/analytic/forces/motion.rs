//! Systems whose elements have states of their own, integrated in time.

use super::stage::{Mechanism, Stage, alone, brick};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;
use wheelrail::mbs::force::ForceElement;
use wheelrail::mbs::joint::{Place, prismatic};
use wheelrail::mbs::kkt::RowBodies;
use wheelrail::mbs::system::System;

fn maxwell() -> Vec<Box<dyn ForceElement>> {
    let read = |own: &str| alone(Vector3::zeros()).element(&format!("name = \"e\"\nfrom = \"world\"\nto = \"body\"\naxis = \"x\"\n{own}"));
    vec![
        read("kind = \"spring_damper\"\nstiffness = 4e4"),
        read("kind = \"maxwell_damper\"\nstiffness = 1e6\ndamping = 4e3"),
        // A second element with states, so that their places in the state vector matter.
        read("kind = \"maxwell_damper\"\nstiffness = 2e5\ndamping = 9e3"),
    ]
}

/// Free motion against the matrix exponential of its linear equations; energy with the heat made is constant.
#[test]
fn analytic_mass_on_maxwell_dampers_moves_as_its_equations_say() {
    let mass = 500.0;
    let mut body = Mechanism::new(vec![brick(mass, 1.0, 1.0, 1.0)], maxwell());
    assert_eq!((body.system.dimension(), body.system.force_states(), body.system.states_of_force(2)), (14, 12..14, 13..14));
    let start = body.state(&[0.02, 0.0, 0.0, 0.0, 0.0, 0.0], &[-0.3, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(start[12..14], [0.02, 0.02], "settled");
    let (k0, k1, c1, k2, c2) = (4e4, 1e6, 4e3, 2e5, 9e3);
    #[rustfmt::skip]
    let matrix = nalgebra::Matrix4::new(
        0.0, 1.0, 0.0, 0.0,
        -(k0 + k1 + k2) / mass, 0.0, k1 / mass, k2 / mass,
        k1 / c1, 0.0, -k1 / c1, 0.0,
        k2 / c2, 0.0, 0.0, -k2 / c2,
    );
    let begin = body.energy(&start);
    for t in [0.01, 0.1, 0.5] {
        let end = body.run(&start, t, 1e-11);
        let exact = (matrix * t).exp() * nalgebra::Vector4::new(0.02, -0.3, 0.02, 0.02);
        let error = (nalgebra::Vector4::new(end[0], end[6], end[12], end[13]) - exact).norm();
        let lost = body.energy(&end) / begin - 1.0;
        println!("t = {t}: error {error:.1e}, energy {lost:.1e}");
        assert!(error < 1e-8 && lost.abs() < 1e-7);
    }
    // The same through the solution with joints.
    let rail = prismatic(
        "rail",
        RowBodies { first: 0, second: None },
        &Place::along(Vector3::zeros(), &Vector3::x()),
        &Place::along(Vector3::zeros(), &Vector3::x()),
    );
    let guided = System {
        bodies: vec![brick(mass, 1.0, 1.0, 1.0)],
        forces: maxwell(),
        drives: vec![],
        supported: vec![],
        joints: vec![rail],
        redundant: vec![],
    };
    let (free, guided) = (body.run(&start, 0.1, 1e-11), Mechanism::of(guided).run(&start, 0.1, 1e-11));
    assert!((0..14).all(|i| (free[i] - guided[i]).abs() < 1e-10));
}

/// A mass meets a stop and comes back with its speed: half a period of sqrt(k/m) in contact. An integrator that steps over
/// the corner of the law is less exact than its tolerance.
#[test]
fn analytic_rebound_from_a_bump_stop() {
    let (mass, k, clearance, speed): (f64, f64, f64, f64) = (100.0, 1e6, 0.005, 1.0);
    let stop = |own: &str| {
        let settings = format!(
            "name = \"e\"\nkind = \"bump_stop\"\nfrom = \"world\"\nto = \"body\"\naxis = \"x\"\nstiffness = {k}\nclearance = {clearance}\n{own}"
        );
        Mechanism::new(vec![brick(mass, 1.0, 1.0, 1.0)], vec![alone(Vector3::zeros()).element(&settings)])
    };
    let mut body = stop("");
    let start = body.state(&[0.0; 6], &[speed, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let (flight, touching) = (clearance / speed, PI * (mass / k).sqrt());
    let deepest = body.run(&start, flight + 0.5 * touching, 1e-10);
    assert!((deepest[0] - clearance - speed * (mass / k).sqrt()).abs() < 2e-7 && deepest[6].abs() < 1e-5, "{deepest:?}");
    let back = body.run(&start, 2.0 * flight + touching, 1e-10);
    assert!(back[0].abs() < 1e-6 && (back[6] + speed).abs() < 2e-5, "{back:?}");
    // With damping it comes back slower and what is missing is heat.
    let mut damped = stop("damping = 0.5\nsides = \"extension\"");
    let begin = damped.energy(&start);
    let back = damped.run(&start, 0.1, 1e-10);
    println!("returns at {:.3} m/s, heat {:.2} J of {begin:.2} J", back[6], back[12]);
    assert!(back[6] < 0.0 && back[6] > -0.9 * speed && (damped.energy(&back) / begin - 1.0).abs() < 1e-5);
}

/// Two equal vehicles that meet at their coupler exchange their speeds.
#[test]
fn analytic_vehicles_exchange_speeds_through_an_elastic_coupler() {
    let places = vec![("rear", Some(0), Vector3::new(-9.0, 0.0, 1.0)), ("front", Some(1), Vector3::new(-10.0, 0.0, 1.0))];
    let stage = Stage { centres: vec![Vector3::zeros(), Vector3::new(-19.0, 0.0, 0.0)], places, mirror: 1.0 };
    let settings = "name = \"c\"\nkind = \"coupler\"\nfrom = \"rear\"\nto = \"front\"\nslack = \"30 mm\"\ndraw_stiffness = 5e6\nbuffer_stiffness = 2e6";
    // Long inertia: the couple of force and height hardly turns them.
    let vehicle = || brick(3e4, 1e12, 1e12, 1e12);
    let mut train = Mechanism::new(vec![vehicle(), vehicle()], vec![stage.element(settings)]);
    let mut v = [0.0; 12];
    v[6] = 2.0;
    let start = train.state(&stage.design(), &v);
    // 0.0075 s to meet, half a period of 0.2721 s in contact, 0.015 s until the draw gear pulls.
    let met = train.run(&start, 0.285, 1e-9);
    let momentum = 3e4 * (met[12] + met[18]);
    assert!((met[12] - 2.0).abs() < 1e-5 && met[18].abs() < 1e-5 && (momentum - 6e4).abs() < 1e-6, "{} {}", met[12], met[18]);
}

/// An isolated pair of turning bodies keeps momentum, angular momentum and energy (with heat) over large motions.
#[test]
fn hard_tumbling_pair_keeps_its_momenta_and_energy() {
    let places = vec![("a", Some(0), Vector3::new(0.3, 0.2, 0.0)), ("b", Some(1), Vector3::new(0.6, -0.1, 0.1))];
    let stage = Stage { centres: vec![Vector3::zeros(), Vector3::new(1.0, 0.0, 0.0)], places, mirror: 1.0 };
    let read = |own: &str| stage.element(&format!("name = \"e\"\nfrom = \"a\"\nto = \"b\"\n{own}"));
    let forces = vec![
        read("kind = \"bushing\"\nstiffness = [300, 200, 250]\nrotational_stiffness = [30, 20, 40]\nrotational_damping = [0.1, 0, 0.2]"),
        read("kind = \"maxwell_damper\"\nstiffness = 500\ndamping = 20"),
        read("kind = \"dry_friction\"\nnormal = \"x\"\nfriction = 0.3\nnormal_force = 5\nnormal_stiffness = 100\nstiffness = 800"),
        read("kind = \"anti_roll_bar\"\nstiffness = 20"),
    ];
    let bodies = vec![brick(2.0, 0.4, 0.5, 0.7), brick(3.0, 0.3, 0.8, 0.6)];
    let mut pair = Mechanism::new(bodies, forces);
    let start = pair.state(&stage.design(), &[0.5, 0.1, -0.2, 0.8, 0.3, -0.6, -0.3, 0.2, 0.1, -0.4, 0.5, 0.9]);
    let end = pair.run(&start, 2.0, 1e-11);
    let mut momenta = |y: &[f64]| {
        let energy = pair.energy(y);
        let (mut linear, mut angular) = (Vector3::zeros(), Vector3::zeros());
        for (body, motion) in pair.system.bodies.iter().zip(&pair.workspace.motions) {
            linear += motion.velocity * body.mass;
            let wheelrail::mbs::inertia::Inertia::General { principal } = &body.inertia else { continue };
            let axes = motion.frame.axes;
            angular += axes * Matrix3::from_diagonal(principal) * axes.transpose() * motion.rotation;
            angular += motion.position.cross(&(motion.velocity * body.mass));
        }
        (linear, angular, energy)
    };
    let before = momenta(&start);
    let after = momenta(&end);
    let turned = (3..6).map(|i| (end[i] - start[i]).abs()).fold(0.0, f64::max);
    println!(
        "turned {turned:.2} rad; momentum {:.1e}, angular momentum {:.1e}, energy {:.1e}",
        (after.0 - before.0).norm(),
        (after.1 - before.1).norm(),
        after.2 / before.2 - 1.0
    );
    assert!(turned > 0.5, "a large motion");
    assert!((after.0 - before.0).norm() < 1e-9 && (after.1 - before.1).norm() < 1e-8 && (after.2 / before.2 - 1.0).abs() < 1e-7);
}
