//! Each element's force against its formula, and what its settings must not be.

use super::stage::{Mechanism, Stage, alone, apply, brick, motions};
use nalgebra::{Complex, Vector3};
use wheelrail::mbs::force::{Curve, ForceElement, Gravity};

/// Tension of an element between the world and a body that is displaced along X.
fn tension(element: &dyn ForceElement, x: f64, speed: f64, state: &[f64]) -> f64 {
    let bodies = motions(&[x, 0.0, 0.0, 0.0, 0.0, 0.0], &[speed, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let force = element.quantity(0, &(&bodies[..]).into(), state);
    // Tension pulls the body back along X.
    assert!((apply(element, &bodies, state).0[0].force.x + force).abs() <= 1e-12 * force.abs());
    force
}

fn along_x(settings: &str) -> Box<dyn ForceElement> {
    alone(Vector3::zeros()).element(&format!("name = \"e\"\nfrom = \"world\"\nto = \"body\"\naxis = \"x\"\n{settings}"))
}

/// A mass on a spring: vertical mode sqrt(k/m), swinging mode sqrt(g/L), by the linear part of the accelerations.
#[test]
fn analytic_mass_on_a_spring_swings_and_bounces() {
    let (mass, k, length, g) = (40.0, 3e4, 0.7, 9.81);
    let stage = alone(Vector3::new(0.0, 0.0, length));
    let spring = |own: String| {
        stage.element(&format!("name = \"e\"\nkind = \"spring_damper\"\nfrom = \"world\"\nto = \"body\"\nstiffness = {k}\n{own}"))
    };
    for own in [format!("preload = {}", mass * g), format!("natural_length = {}", length - mass * g / k)] {
        let weight = Box::new(Gravity { body: 0, mass, acceleration: g, grade: 0.0 });
        let mut pendulum = Mechanism::new(vec![brick(mass, 1.0, 1.0, 1.0)], vec![weight, spring(own)]);
        assert!(pendulum.accelerations(&[0.0; 6])[2].abs() < 1e-12, "stands in the design configuration");
        let h = 1e-5;
        let mut square = |axis: usize| {
            let mut q = [0.0; 6];
            q[axis] = h;
            let ahead = pendulum.accelerations(&q)[axis];
            q[axis] = -h;
            (pendulum.accelerations(&q)[axis] - ahead) / (2.0 * h)
        };
        assert!((square(2) / (k / mass) - 1.0).abs() < 1e-7 && (square(0) / (g / length) - 1.0).abs() < 1e-7);
        assert!((square(1) / (g / length) - 1.0).abs() < 1e-7);
    }
}

/// Steady oscillation x = Re X exp(i w t): z and T have the amplitudes X k/(k + c i w) and k c i w/(k + c i w) X.
#[test]
fn analytic_maxwell_damper_has_its_complex_stiffness() {
    // Vertical damper of the Manchester vehicle's primary suspension.
    let (k, c, amplitude): (f64, f64, f64) = (1e6, 4e3, 2e-3);
    let damper = along_x("kind = \"maxwell_damper\"\nstiffness = 1e6\ndamping = 4e3");
    let table = along_x("kind = \"maxwell_damper\"\nstiffness = 1e6\nforce_over_speed = [[-1, -4e3], [0.2, 800], [1, 4e3]]");
    for w in [1.0, 25.0, k / c, 3e3] {
        let i = Complex::i();
        let piston = Complex::from(k) / (k + c * i * w) * amplitude;
        let stiffness = k * c * i * w / (k + c * i * w) * amplitude;
        for t in [0.0, 0.3 / w, 2.0 / w] {
            let now: Complex<f64> = (i * w * t).exp();
            let (x, speed) = ((amplitude * now).re, (amplitude * i * w * now).re);
            let state = [(piston * now).re];
            let bodies = motions(&[x, 0.0, 0.0, 0.0, 0.0, 0.0], &[speed, 0.0, 0.0, 0.0, 0.0, 0.0]);
            for element in [&damper, &table] {
                let (_, rates) = apply(element.as_ref(), &bodies, &state);
                assert!((rates[0] - (i * w * piston * now).re).abs() < 1e-9 * w * amplitude, "{w}");
                assert!((tension(element.as_ref(), x, speed, &state) - (stiffness * now).re).abs() < 1e-9 * k * amplitude, "{w}");
            }
        }
    }
}

/// Steady oscillation with a laminar orifice against the closed formula; slow and fast motion at the two stiffnesses; a turbulent orifice by its own equation.
#[test]
fn analytic_air_spring_has_its_complex_stiffness() {
    let (load, area, volume, reservoir, growth, n, c): (f64, f64, f64, f64, f64, f64, f64) = (1.2e5, 0.25, 0.03, 0.05, 0.2, 1.38, 4e4);
    let settings = "kind = \"air_spring\"\npreload = -1.2e5\narea = 0.25\nvolume = 0.03\nreservoir_volume = 0.05\narea_growth = 0.2\npolytropic = 1.38\norifice_damping = 4e4";
    let spring = along_x(settings);
    let pressure = 101_325.0 + load / area;
    let [k1, k2, k3] = [n * pressure * area * area / volume, n * pressure * area * area / reservoir, load / area * growth];
    println!("bag {k1:.4e}, reservoir {k2:.4e}, area {k3:.4e} N/m");
    let (amplitude, i) = (5e-3, Complex::i());
    for w in [1e-3, 1.0, (k1 + k2) / c, 300.0, 1e6] {
        let piston = Complex::from(k1) / (k1 + k2 + c * i * w) * amplitude;
        let stiffness = k3 + k1 * (k2 + c * i * w) / (k1 + k2 + c * i * w);
        for t in [0.0, 0.3 / w, 2.0 / w] {
            let now: Complex<f64> = (i * w * t).exp();
            let (x, speed, state) = ((amplitude * now).re, (amplitude * i * w * now).re, [(piston * now).re]);
            let bodies = motions(&[x, 0.0, 0.0, 0.0, 0.0, 0.0], &[speed, 0.0, 0.0, 0.0, 0.0, 0.0]);
            let rates = apply(spring.as_ref(), &bodies, &state).1;
            assert!((rates[0] - (i * w * piston * now).re).abs() < 1e-9 * (w * amplitude + k1 / c * amplitude), "{w}");
            let force = tension(spring.as_ref(), x, speed, &state);
            assert!((force + load - (stiffness * amplitude * now).re).abs() < 1e-9 * load, "{w}");
        }
        if w < 0.01 {
            assert!((stiffness.re / (k3 + k1 * k2 / (k1 + k2)) - 1.0).abs() < 1e-6);
        } else if w > 1e5 {
            assert!((stiffness.re / (k3 + k1) - 1.0).abs() < 1e-4);
        }
    }
    let turbulent = along_x(&format!("{settings}\norifice_turbulence = 3e5"));
    for s in [-2e-2, -1e-5, 0.0, 3e-4, 1e-2] {
        let bodies = motions(&[1e-3, 0.0, 0.0, 0.0, 0.0, 0.0], &[0.0; 6]);
        let rate = apply(turbulent.as_ref(), &bodies, &[s]).1[0];
        let head = k1 * (1e-3 - s) - k2 * s;
        assert!((c * rate + 3e5 * rate.abs() * rate - head).abs() < 1e-9 * (1.0 + head.abs()), "{s}");
    }
}

/// A wedge that slips down, and up again: N = S / (tan b -+ mu); across it the friction alone.
#[test]
fn analytic_friction_wedge_slips_with_its_loading_and_unloading_forces() {
    let (mu, angle, force, ks): (f64, f64, f64, f64) = (0.4, 0.61, 2e4, 3e5);
    let stage = alone(Vector3::zeros());
    let wedge = stage.element(
        "name = \"e\"\nkind = \"friction_wedge\"\nfrom = \"world\"\nto = \"body\"\naxis = \"z\"\nnormal = \"x\"\nangle = 0.61\nfriction = 0.4\nspring_force = 2e4\nspring_stiffness = 3e5\nstiffness = 2e8",
    );
    // Moved from z0 for so long, midpoint rule; slowly beside the time within which friction lets go.
    let slide = |z0: f64, velocity: [f64; 2], time: f64, state: [f64; 2]| {
        let (steps, mut s) = (40_000, state);
        let dt = time / f64::from(steps);
        let rates = |at: f64, s: &[f64; 2]| {
            let q = [0.0, velocity[0] * at, z0 + velocity[1] * at, 0.0, 0.0, 0.0];
            apply(wedge.as_ref(), &motions(&q, &[0.0, velocity[0], velocity[1], 0.0, 0.0, 0.0]), s).1
        };
        for i in 0..steps {
            let at = dt * f64::from(i);
            let first = rates(at, &s);
            let middle = [0, 1].map(|k| s[k] + 0.5 * dt * first[k]);
            let rate = rates(at + 0.5 * dt, &middle);
            s = [0, 1].map(|k| s[k] + dt * rate[k]);
        }
        let bodies = motions(&[0.0, velocity[0] * time, z0 + velocity[1] * time, 0.0, 0.0, 0.0], &[0.0; 6]);
        let quantity = |k: usize| wedge.quantity(k, &(&bodies[..]).into(), &s);
        let up = apply(wedge.as_ref(), &bodies, &s).0[0].force;
        (s, [0, 1, 2, 3].map(quantity), up)
    };
    let (down, [spring, friction, across, normal], up) = slide(0.0, [0.0, -0.1], 0.2, [0.0; 2]);
    let expected = (force + ks * 0.02) / (angle.tan() - mu);
    println!("down: S {spring:.1} N, N {normal:.1} N, formula {expected:.1} N, friction {friction:.1} N");
    assert!((spring - force - ks * 0.02).abs() < 1e-6 && across == 0.0);
    assert!((normal / expected - 1.0).abs() < 5e-3 && (friction / (mu * expected) - 1.0).abs() < 5e-3);
    assert!((up.z - spring - friction).abs() < 1e-6);
    let (_, [spring, friction, _, normal], up) = slide(-0.02, [0.0, 0.1], 0.2, down);
    let expected = force / (angle.tan() + mu);
    println!("up: S {spring:.1} N, N {normal:.1} N, formula {expected:.1} N, friction {friction:.1} N");
    assert!((normal / expected - 1.0).abs() < 5e-3 && (friction / (-mu * expected) - 1.0).abs() < 5e-3);
    assert!((up.z - spring - friction).abs() < 1e-6);
    let (_, [_, friction, across, normal], up) = slide(0.0, [0.1, 0.0], 0.2, [0.0; 2]);
    let expected = force / angle.tan();
    assert!(friction == 0.0 && (normal / expected - 1.0).abs() < 1e-9 && (across.abs() / (mu * expected) - 1.0).abs() < 5e-3);
    assert!((up.y + across).abs() < 1e-6, "against the motion: {up}");
}

/// The lateral bump stop of the Manchester vehicle (S. Iwnicki, Vehicle System Dynamics 30 (1998) 295-313, by way of a public
/// parameter file): table of force over displacement, symmetric, free up to 25 mm.
#[test]
fn validate_bump_stop_follows_the_manchester_table() {
    let table = [
        (0.0, 0.0),
        (0.025, 0.0),
        (0.03, 600.0),
        (0.035, 1760.0),
        (0.04, 3730.0),
        (0.045, 6870.0),
        (0.05, 11580.0),
        (0.055, 17170.0),
        (0.06, 29200.0),
        (0.065, 230000.0),
    ];
    let text: Vec<String> = table.iter().map(|(x, force)| format!("[{x:?}, {force:?}]")).collect();
    let stop = along_x(&format!("kind = \"bump_stop\"\nforce_over_displacement = [{}]", text.join(", ")));
    for (x, force) in table.into_iter().chain([(0.02, 0.0), (0.0325, 1180.0)]) {
        assert!((tension(stop.as_ref(), x, 0.3, &[]) - force).abs() < 1e-7, "{x}");
        assert!((tension(stop.as_ref(), -x, 0.3, &[]) + force).abs() < 1e-7, "{x}");
    }
    let energy = |x: f64| stop.potential_energy(&(&motions(&[x, 0.0, 0.0, 0.0, 0.0, 0.0], &[0.0; 6])[..]).into(), &[]);
    // Trapezia of 5 mm.
    let stored = 0.005 * (600.0 / 2.0 + (600.0 + 1760.0) / 2.0 + (1760.0 + 3730.0) / 2.0);
    assert!((energy(0.04) - stored).abs() < 1e-9 && (energy(-0.04) - stored).abs() < 1e-9 && energy(0.02) == 0.0);
}

#[test]
fn analytic_stops_and_coupler_press_beyond_their_free_travel_only() {
    let stop = |own: &str| along_x(&format!("kind = \"bump_stop\"\nstiffness = 1e6\nclearance = 0.01\n{own}"));
    let at = |element: &dyn ForceElement, x: f64| tension(element, x, 0.0, &[]);
    assert!((at(stop("").as_ref(), 0.013) - 3e3).abs() < 1e-9 && (at(stop("").as_ref(), -0.013) + 3e3).abs() < 1e-9);
    assert!(at(stop("sides = \"compression\"").as_ref(), 0.013) == 0.0 && at(stop("sides = \"extension\"").as_ref(), -0.013) == 0.0);
    assert!((at(stop("sides = \"compression\"").as_ref(), -0.013) + 3e3).abs() < 1e-9);
    // In the middle of the rounded corner: a quarter of the half-width times the stiffness.
    assert!((at(stop("rounding = 0.004").as_ref(), 0.01) - 1e3).abs() < 1e-9 && at(stop("rounding = 0.004").as_ref(), 0.006) == 0.0);
    // Damping rises with the force and never pulls.
    let damped = stop("damping = 2");
    assert!((tension(damped.as_ref(), 0.013, 0.25, &[]) - 4.5e3).abs() < 1e-9);
    assert!((tension(damped.as_ref(), -0.013, 0.25, &[]) + 1.5e3).abs() < 1e-9);
    assert!(tension(damped.as_ref(), 0.013, -0.7, &[]) == 0.0 && tension(damped.as_ref(), 0.005, 5.0, &[]) == 0.0);
    let coupler = along_x("kind = \"coupler\"\nslack = 0.02\ndraw_stiffness = 2e6\nbuffer_force_over_displacement = [[0, 0], [0.1, 1e5]]");
    for (x, force) in [(0.009, 0.0), (-0.009, 0.0), (0.015, 1e4), (-0.03, -2e4)] {
        assert!((at(coupler.as_ref(), x) - force).abs() < 1e-8, "{x}");
    }
}

#[test]
fn analytic_anti_roll_bar_resists_roll_alone() {
    let stage = Stage {
        centres: vec![Vector3::zeros(), Vector3::new(0.0, 0.0, 1.2)],
        places: vec![("a", Some(0), Vector3::zeros()), ("b", Some(1), Vector3::new(0.0, 0.0, 1.0))],
        mirror: 1.0,
    };
    let bar = stage.element("name = \"bar\"\nkind = \"anti_roll_bar\"\nfrom = \"a\"\nto = \"b\"\nstiffness = 940e3\ndamping = 2e3");
    let (roll, rate) = (0.03, 0.2);
    let mut q = stage.design();
    q[10] = roll;
    let mut v = vec![0.0; 12];
    v[10] = rate;
    let (wrenches, _) = apply(bar.as_ref(), &motions(&q, &v), &[]);
    let moment = 940e3 * roll + 2e3 * rate;
    assert!((wrenches[0].moment - Vector3::x() * moment).norm() < 1e-8 && (wrenches[1].moment + Vector3::x() * moment).norm() < 1e-8);
    assert!(wrenches.iter().all(|wrench| wrench.force.norm() == 0.0));
    assert!(
        (bar.quantity(0, &(&motions(&q, &v)[..]).into(), &[]) - moment).abs() < 1e-8
            && (bar.quantity(1, &(&motions(&q, &v)[..]).into(), &[]) - roll).abs() < 1e-12
    );
    // Displacement, yaw and pitch alone call up nothing.
    for coordinate in [6, 7, 8, 9, 11] {
        let mut q = stage.design();
        q[coordinate] += 0.1;
        let (wrenches, _) = apply(bar.as_ref(), &motions(&q, &[0.0; 12]), &[]);
        assert!(wrenches[0].moment.norm() < 1e-9, "{coordinate}: {}", wrenches[0].moment);
    }
}

/// A body on four bushings at (+-a, +-b, 0): six uncoupled modes.
#[test]
fn analytic_body_on_four_bushings_has_its_six_modes() {
    let (a, b, mass, inertia) = (1.3, 1.0, 2600.0, [1700.0, 1500.0, 3100.0]);
    let corners = [("1", a, b), ("2", a, -b), ("3", -a, b), ("4", -a, -b)];
    let on = |body| move |(name, x, y): (&'static str, f64, f64)| (name, body, Vector3::new(x, y, 0.0));
    let mut places: Vec<_> = corners.map(on(None)).into();
    places.extend([("b1", a, b), ("b2", a, -b), ("b3", -a, b), ("b4", -a, -b)].map(on(Some(0))));
    let stage = Stage { centres: vec![Vector3::zeros()], places, mirror: 1.0 };
    let forces = corners.map(|(name, ..)| {
        let springs = "stiffness = [31e6, 3.9e6, 1.2e6]\nrotational_stiffness = [1e4, 2e4, 5e4]";
        stage.element(&format!("name = \"p{name}\"\nkind = \"bushing\"\nfrom = \"{name}\"\nto = \"b{name}\"\n{springs}"))
    });
    let mut body = Mechanism::new(vec![brick(mass, inertia[0], inertia[1], inertia[2])], forces.into());
    let (kx, ky, kz) = (31e6, 3.9e6, 1.2e6);
    let squares = [
        4.0 * kx / mass,
        4.0 * ky / mass,
        4.0 * kz / mass,
        4.0 * (kx * b * b + ky * a * a + 5e4) / inertia[2],
        4.0 * (kz * b * b + 1e4) / inertia[0],
        4.0 * (kz * a * a + 2e4) / inertia[1],
    ];
    let h = 1e-5;
    for (axis, expected) in squares.into_iter().enumerate() {
        let mut q = [0.0; 6];
        q[axis] = h;
        let ahead = body.accelerations(&q);
        q[axis] = -h;
        let behind = body.accelerations(&q);
        for (other, (ahead, behind)) in ahead.iter().zip(&behind).enumerate() {
            let square = (behind - ahead) / (2.0 * h);
            let expected = if other == axis { expected } else { 0.0 };
            assert!((square - expected).abs() < 1e-6 * squares[axis], "{axis} {other}: {square} {expected}");
        }
    }
}

/// What a bushing says of angles does not depend on whether anything resists them.
#[test]
fn analytic_a_bushing_without_rotational_stiffness_shows_the_angles_too() {
    let stage = Stage {
        centres: vec![Vector3::zeros()],
        places: vec![("world", None, Vector3::zeros()), ("body", Some(0), Vector3::zeros())],
        mirror: 1.0,
    };
    let of = |more: &str, q: [f64; 6]| {
        let settings = format!("name = \"e\"\nkind = \"bushing\"\nfrom = \"world\"\nto = \"body\"\nstiffness = [1e6, 1e6, 1e6]\n{more}");
        let bodies = motions(&q, &[0.0; 6]);
        [9, 10, 11, 3, 4, 5].map(|index| stage.element(&settings).quantity(index, &(&bodies[..]).into(), &[]))
    };
    // Yaw, roll and pitch alone; then all at once against a bushing that resists.
    for (place, axis) in [(3, 2), (4, 0), (5, 1)] {
        let mut q = [0.0; 6];
        q[place] = 0.06;
        let found = of("", q);
        assert!(
            (found[axis] - 0.06).abs() < 1e-15 && found.iter().map(|value| value.abs()).sum::<f64>() < 0.06 + 1e-15,
            "{place}: {found:?}"
        );
    }
    let q = [0.1, 0.2, -0.1, 0.07, -0.03, 0.02];
    assert_eq!(of("", q)[..3], of("rotational_stiffness = [1, 1, 1]", q)[..3]);
}

#[test]
fn prop_wrong_settings_are_refused_with_their_place() {
    let stage = alone(Vector3::new(0.0, 0.0, 0.0));
    let message = |own: &str| {
        let error = stage.read(&format!("name = \"e\"\nfrom = \"world\"\nto = \"body\"\n{own}")).err();
        error.map_or_else(String::new, |error| error.to_string())
    };
    for (settings, expected) in [
        ("kind = \"spring_dampr\"", "scene:4: kind: found \"spring_dampr\" (did you mean \"spring_damper\"?)"),
        ("kind = \"spring_damper\"\nstiffness = 1", "scene:3: to: both places coincide"),
        ("kind = \"spring_damper\"\naxis = \"x\"", "stiffness: an element needs"),
        ("kind = \"spring_damper\"\naxis = \"x\"\nstiffness = 1\nforce_over_length = [[0, 0], [1, 1]]", "force_over_length: says again"),
        ("kind = \"spring_damper\"\naxis = \"x\"\nforce_over_speed = [[0, 0], [1, -1]]", "force_over_speed: the force must not fall"),
        ("kind = \"spring_damper\"\naxis = \"x\"\nforce_over_speed = [[0, 5], [1, 6]]", "force_over_speed: the force must vanish at zero"),
        ("kind = \"spring_damper\"\naxis = \"x\"\nforce_over_length = [[0, 0], [0, 6]]", "force_over_length: expected two or more points"),
        ("kind = \"spring_damper\"\naxis = \"x\"\nforce_over_length = [[0, 0, 1], [0, 6]]", "force_over_length: found"),
        ("kind = \"spring_damper\"\naxis = \"x\"\nstiffnes = 3", "stiffness: an element needs"),
        ("kind = \"bushing\"\nstiffness = [1, 2]", "stiffness: found [1, 2], expected a list of three"),
        ("kind = \"bushing\"\nstiffness = [1, -2, 3]", "stiffness: must not be negative"),
        ("kind = \"bump_stop\"\naxis = \"x\"\nstiffness = 1\nrounding = 0.1", "rounding: must not be larger than the free travel"),
        ("kind = \"maxwell_damper\"\naxis = \"x\"\nstiffness = 1\ndamping = 0", "damping: found 0.0, expected a number greater than 0"),
        ("kind = \"spring_damper\"\naxis = \"x\"\nforce_over_speed = [[-1, -2], [1, 2]]\nodd = true", "force_over_speed: with odd = true"),
        ("kind = \"spring_damper\"\naxis = \"x\"\nstiffness = 1\nodd = true", "odd: serves nothing without a table"),
        ("kind = \"spring_damper\"\naxis = \"x\"\nforce_over_speed = [[0, 0], [1, 2]]\nbeyond = \"hld\"", "beyond: found \"hld\""),
        ("kind = \"bump_stop\"\naxis = \"x\"\nforce_over_displacement = [[0, 0], [1, 2]]\nodd = true", "odd: serves nothing here"),
        (
            "kind = \"maxwell_damper\"\naxis = \"x\"\nstiffness = 1\nforce_over_speed = [[0, 0], [1, 2]]\nbeyond = \"hold\"",
            "beyond: \"hold\" leaves the speed open",
        ),
        ("kind = \"spring_damper\"\naxis = \"x\"\nforce_over_speed = [[0, 0], [1, 2]]\npreload = \"static\"", "preload: \"static\" needs"),
        (
            "kind = \"friction_wedge\"\naxis = \"z\"\nnormal = \"x\"\nangle = 0.3\nfriction = 0.4\nspring_force = 1\nspring_stiffness = 1\nstiffness = 1",
            "angle: found 0.3 rad, with which the wedge locks",
        ),
        (
            "kind = \"air_spring\"\naxis = \"z\"\npreload = 1\narea = 1\nvolume = 1\nreservoir_volume = 1\norifice_damping = 1",
            "preload: found 1.0 N, which pulls",
        ),
        (
            "kind = \"air_spring\"\naxis = \"z\"\npreload = -1e5\narea = 0.2\nvolume = 1\nreservoir_volume = 1\narea_growth = -9\norifice_damping = 1",
            "area_growth: leaves a static stiffness of",
        ),
        ("kind = \"dry_friction\"\nlimit = 1\nstiffness = 1", "axis: give the axis of slip"),
        ("kind = \"dry_friction\"\naxis = \"x\"\nlimit = 1\nfriction = 1\nstiffness = 1", "limit: is \"friction\" times"),
    ] {
        assert!(message(settings).contains(expected), "{settings}: {}", message(settings));
    }
    let same = stage.read("name = \"e\"\nkind = \"bushing\"\nfrom = \"body\"\nto = \"body\"\nstiffness = [1, 1, 1]").unwrap_err();
    assert!(same.to_string().contains("to: is on the same body as \"from\""), "{same}");
}

/// `odd` and `beyond` of tables of force over speed and over length.
#[test]
fn analytic_tables_are_mirrored_and_hold_where_they_are_told_to() {
    let half = "kind = \"spring_damper\"\nforce_over_speed = [[0, 0], [0.1, 1000], [0.5, 2000]]\n";
    let at = |own: &str, speed: f64| tension(along_x(&format!("{half}{own}")).as_ref(), 0.0, speed, &[]);
    // Without a word the first and last slope go on.
    for (own, cases) in [
        ("", [(-0.2, -2000.0), (0.05, 500.0), (1.0, 3250.0)]),
        ("odd = true", [(-0.3, -1500.0), (-1.0, -3250.0), (1.0, 3250.0)]),
        ("odd = true\nbeyond = \"hold\"", [(-0.3, -1500.0), (-7.0, -2000.0), (7.0, 2000.0)]),
        ("beyond = \"hold\"", [(-0.3, 0.0), (0.3, 1500.0), (7.0, 2000.0)]),
        ("beyond = \"slope\"", [(-0.2, -2000.0), (0.05, 500.0), (1.0, 3250.0)]),
    ] {
        for (speed, expected) in cases {
            assert!((at(own, speed) - expected).abs() < 1e-9, "{own} at {speed}: {}", at(own, speed));
        }
    }
    let spring = along_x("kind = \"spring_damper\"\nforce_over_length = [[0, 0], [0.01, 5e3]]\nodd = true\nbeyond = \"hold\"");
    assert!(
        [(-0.005, -2500.0), (-0.03, -5e3), (0.03, 5e3)]
            .iter()
            .all(|(x, force)| (tension(spring.as_ref(), *x, 0.0, &[]) - force).abs() < 1e-9)
    );
    // Integral of the force: a triangle, then a constant.
    let bodies = motions(&[0.03, 0.0, 0.0, 0.0, 0.0, 0.0], &[0.0; 6]);
    assert!((spring.potential_energy(&(&bodies[..]).into(), &[]) - (25.0 + 0.02 * 5e3)).abs() < 1e-9);
    let stop = along_x("kind = \"bump_stop\"\nforce_over_displacement = [[0, 0], [0.01, 5e3]]\nclearance = 0.02\nbeyond = \"hold\"");
    for (x, force) in [(0.025, 2500.0), (0.5, 5e3), (-0.5, -5e3), (0.01, 0.0)] {
        assert!((tension(stop.as_ref(), x, 0.0, &[]) - force).abs() < 1e-9, "{x}: {}", tension(stop.as_ref(), x, 0.0, &[]));
    }
    assert_eq!(stop.free_travel(), Some([-0.02, 0.02]));
    // In series with a spring the mirrored table is the whole one.
    let [mirrored, whole] = ["[[0, 0], [0.1, 5e3], [1, 9e3]]\nodd = true", "[[-1, -9e3], [-0.1, -5e3], [0, 0], [0.1, 5e3], [1, 9e3]]"]
        .map(|table| along_x(&format!("kind = \"maxwell_damper\"\nstiffness = 1e6\nforce_over_speed = {table}")));
    for x in [-0.02, -0.004, 0.004, 0.02] {
        let bodies = motions(&[x, 0.0, 0.0, 0.0, 0.0, 0.0], &[0.0; 6]);
        assert_eq!(apply(mirrored.as_ref(), &bodies, &[0.0]).1, apply(whole.as_ref(), &bodies, &[0.0]).1);
    }
}

#[test]
fn analytic_sharp_curve_passes_through_its_points_and_goes_on_straight() {
    let points = [[-0.02, -900.0], [-0.01, -100.0], [0.0, 0.0], [0.03, 600.0], [0.04, 5000.0]];
    let curve = Curve::new(&points, 0.0).unwrap();
    for [x, force] in points {
        assert!((curve.force(x) - force).abs() < 1e-9, "{x}: {}", curve.force(x));
    }
    assert!((curve.force(0.05) - 9400.0).abs() < 1e-9 && (curve.force(-0.03) + 1700.0).abs() < 1e-9);
    // Trapezia from zero.
    assert!((curve.energy(0.04) - (0.5 * 0.03 * 600.0 + 0.01 * 2800.0)).abs() < 1e-9);
    assert!((curve.energy(-0.02) - (0.5 * 0.01 * 100.0 + 0.01 * 500.0)).abs() < 1e-9);
    assert_eq!(curve.energy(0.0), 0.0);
}

#[test]
fn analytic_rounded_corner_is_the_mean_of_the_sharp_one() {
    let points = [[-0.1, -100.0], [0.0, 0.0], [0.01, 10.0], [0.03, 400.0], [0.1, 500.0]];
    let (sharp, round) = (Curve::new(&points, 0.0).unwrap(), Curve::new(&points, 0.004).unwrap());
    for x in [-0.05, 0.0, 0.007, 0.012, 0.031, 0.08] {
        let mean = |x: f64| (sharp.energy(x + 0.004) - sharp.energy(x - 0.004)) / 0.008;
        assert!((round.force(x) - (mean(x) - mean(0.0))).abs() < 1e-9, "{x}");
        let h = 1e-5;
        let slope = (round.energy(x + h) - round.energy(x - h)) / (2.0 * h);
        assert!((slope - round.force(x)).abs() < 1e-4 * (1.0 + slope.abs()), "{x}: {slope}");
    }
}
