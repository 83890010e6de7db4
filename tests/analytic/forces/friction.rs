//! Dry friction: sticking, slipping, letting go.

use super::stage::{Mechanism, Stage, alone, apply, brick, motions};
use nalgebra::Vector3;
use wheelrail::mbs::force::{ForceElement, VerticalLoad};

fn element(stage: &Stage, settings: &str) -> Box<dyn ForceElement> {
    stage.element(&format!("name = \"e\"\nfrom = \"world\"\nto = \"body\"\n{settings}"))
}

/// Steady motion from rest: F = F_c tanh(k x / F_c).
#[test]
fn analytic_force_rises_to_the_limit_as_a_hyperbolic_tangent() {
    let stage = alone(Vector3::zeros());
    let (limit, k, speed) = (2e3, 1e6, 0.05);
    let friction = element(&stage, &format!("kind = \"dry_friction\"\naxis = \"x\"\nlimit = {limit}\nstiffness = {k}"));
    let mut body = Mechanism::new(vec![brick(1e9, 1.0, 1.0, 1.0)], vec![friction]);
    let start = body.state(&[0.0; 6], &[speed, 0.0, 0.0, 0.0, 0.0, 0.0]);
    for t in [0.01, 0.04, 0.2] {
        let end = body.run(&start, t, 1e-12);
        let force = k * end[12];
        assert!((force - limit * (k * speed * t / limit).tanh()).abs() < 1e-3, "{t}: {force}");
    }
}

/// A mass on a spring K with friction F_c. Over a half swing from a0 to a1 the element's spring goes from one limit to
/// the other, the energy in it being the same at both, and with z_c = F_c/k and p = 2 the heat is `F_c z_c` times the
/// integral of tanh^3 over U = (a0 + a1)/z_c - 1, i.e. `F_c (a0 + a1 - z_c (3/2 + ln 2))` for tanh U = 1. The spring loses
/// `K (a0^2 - a1^2)/2`, so `a0 - a1 = 2 F_c/K (1 - z_c (3/2 + ln 2)/(a0 + a1))`: Coulomb's 2 F_c/K less the sticking part.
#[test]
fn analytic_coulomb_decay_of_an_oscillation() {
    let stage = alone(Vector3::zeros());
    let (mass, spring, limit, k) = (100.0, 1e5, 200.0, 1e6);
    let forces = vec![
        element(&stage, &format!("kind = \"dry_friction\"\naxis = \"x\"\nlimit = {limit}\nstiffness = {k}")),
        element(&stage, &format!("kind = \"spring_damper\"\naxis = \"x\"\nstiffness = {spring}")),
    ];
    let mut body = Mechanism::new(vec![brick(mass, 1.0, 1.0, 1.0)], forces);
    let travel = limit / k;
    let next = |before: f64| {
        let mut after = before;
        for _ in 0..60 {
            after = before - 2.0 * limit / spring * (1.0 - travel * (1.5 + 2f64.ln()) / (before + after));
        }
        after
    };
    // From a turning point with the friction at its limit; turning points are where the speed changes sign.
    let mut y = body.state(&[0.05, 0.0, 0.0, 0.0, 0.0, 0.0], &[0.0; 6]);
    y[12] = travel;
    let begin = body.energy(&y);
    let mut expected: f64 = 0.05;
    let half = std::f64::consts::PI * (mass / spring).sqrt();
    for swing in 0..6 {
        let (mut early, mut late) = (0.8 * half, 1.1 * half);
        let sign = body.run(&y, early, 1e-11)[6].signum();
        for _ in 0..45 {
            let middle = 0.5 * (early + late);
            if body.run(&y, middle, 1e-11)[6].signum() == sign { early = middle } else { late = middle }
        }
        y = body.run(&y, early, 1e-11);
        expected = next(expected);
        println!("swing {swing}: amplitude {:.6} mm, formula {:.6} mm", y[0].abs() * 1e3, expected * 1e3);
        assert!((y[0].abs() - expected).abs() < 1e-7, "{swing}");
        assert!((body.energy(&y) / begin - 1.0).abs() < 1e-8, "the heat accounts for the loss");
    }
}

/// A load below the limit is carried at rest: after the start has died away nothing creeps.
#[test]
fn hard_a_body_at_rest_does_not_creep() {
    let stage = alone(Vector3::zeros());
    let forces: Vec<Box<dyn ForceElement>> = vec![
        Box::new(VerticalLoad::new(0, 900.0, 9.81, 0.0)),
        element(&stage, "kind = \"dry_friction\"\naxis = \"z\"\nlimit = 1e3\nstiffness = 1e6"),
        element(&stage, "kind = \"spring_damper\"\naxis = \"z\"\ndamping = 2e4"),
    ];
    let mut body = Mechanism::new(vec![brick(100.0, 1.0, 1.0, 1.0)], forces);
    let start = body.state(&[0.0; 6], &[0.0; 6]);
    let early = body.run(&start, 10.0, 1e-10);
    let late = body.run(&start, 60.0, 1e-10);
    println!("sunk by {:.6} mm after 10 s, {:.6} mm after 60 s", -early[2] * 1e3, -late[2] * 1e3);
    // The tolerance that an explicit step at its limit of stability trembles by adds up to 5e-12 m a step, always the same way.
    assert!((late[2] - early[2]).abs() < 1e-7);
    // Without overshoot: z_c artanh(F/F_c).
    assert!((late[2] + 1e-3 * 0.9f64.atanh()).abs() < 1e-6);
    // Above the limit it slides at c v = F - F_c.
    let mut heavy = Mechanism::new(vec![brick(100.0, 1.0, 1.0, 1.0)], body.system.forces);
    heavy.system.forces[0] = Box::new(VerticalLoad::new(0, 1200.0, 9.81, 0.0));
    let end = heavy.run(&start, 2.0, 1e-10);
    assert!((end[8] + 200.0 / 2e4).abs() < 1e-8, "{}", end[8]);
}

/// Slip in a plane under a normal spring: |F| is at most mu N and against the slip; it goes within tau when N has gone.
#[test]
fn analytic_friction_in_a_plane_is_bounded_and_lets_go() {
    let stage = alone(Vector3::zeros());
    let (mu, normal, k) = (0.3, 1e4, 1e6);
    let pair = element(
        &stage,
        "kind = \"dry_friction\"\nnormal = \"z\"\nfriction = 0.3\nnormal_force = 1e4\nnormal_stiffness = 1e6\nstiffness = 1e6",
    );
    // In a circle: the force follows the direction of motion. Midpoint rule.
    let mut z = [0.0, 0.0];
    let (radius, turns) = (0.05, 20_000);
    let step = 2.0 * std::f64::consts::PI / f64::from(turns);
    let rates = |angle: f64, z: &[f64; 2]| {
        let v = [-angle.sin(), angle.cos(), 0.0, 0.0, 0.0, 0.0];
        apply(pair.as_ref(), &motions(&[0.0; 6], &v), z).1
    };
    for i in 0..turns {
        let (angle, dt) = (step * f64::from(i), step * radius);
        let first = rates(angle, &z);
        let middle = [z[0] + 0.5 * dt * first[0], z[1] + 0.5 * dt * first[1]];
        let rates = rates(angle + 0.5 * step, &middle);
        z = [z[0] + dt * rates[0], z[1] + dt * rates[1]];
        assert!(k * z[0].hypot(z[1]) < mu * normal * (1.0 + 1e-5), "{i}: {z:?}");
    }
    // Back at the start, moving along y; the deflection lags by asin(z_c/radius).
    let lag = (z[0] / z[1]).atan();
    println!("force {:.1} N of {:.1} N, lag {lag:.4} rad", k * z[0].hypot(z[1]), mu * normal);
    assert!(k * z[0].hypot(z[1]) > 0.95 * mu * normal && (lag - (mu * normal / k / radius).asin()).abs() < 1e-3);
    // Lifted by more than N0/k_n: nothing presses, and the deflection falls at the rate z/tau.
    let (wrenches, rates) = apply(pair.as_ref(), &motions(&[0.0, 0.0, 0.02, 0.0, 0.0, 0.0], &[0.0; 6]), &[1e-3, 0.0]);
    assert!(wrenches[0].force.z == 0.0 && (rates[0] + 1e-3 / 2e-3).abs() < 1e-12);
    // Pressed down by 5 mm: N = N0 + 5 kN, upward on the body.
    let (wrenches, _) = apply(pair.as_ref(), &motions(&[0.0, 0.0, -0.005, 0.0, 0.0, 0.0], &[0.0; 6]), &[0.0, 0.0]);
    assert!((wrenches[0].force.z - 1.5e4).abs() < 1e-8);
}
