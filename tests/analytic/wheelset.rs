//! Against formulas.

use crate::common::{column, read, run, scene, start, straight, table};
use nalgebra::{Matrix2, Vector2, Vector3};
use std::f64::consts::PI;
use wheelrail::contact::search::algebraic::{ContactLocation, Pair, SurfaceParameters};
use wheelrail::formulation::memory::ModelMemory;
use wheelrail::formulation::{Evaluation, EvaluationError, Model, Workspace};
use wheelrail::geometry::Side;
use wheelrail::math::rotation::AxleFrame;
use wheelrail::solve::{DormandPrince, Dynamics, Implicit, Integrator, Scratch, Undefined};

#[test]
fn analytic_static_wheel_load_is_half_of_weight_and_load() {
    let scene = scene(&[]);
    let mut simulation = start(&scene);
    let outputs = table(&simulation, &scene);
    let found = read(&mut simulation, &outputs);
    let load = (1568.0 * 9.81 + 98_000.0) / 2.0;
    for side in ["left", "right"] {
        let q = found[&format!("{side}.verticalForce")];
        println!("{side}: Q = {q:.9} N, (m g + W) / 2 = {load} N");
        assert!((q / load - 1.0).abs() < 1e-9);
    }
    assert!((found["z"] - 0.4569).abs() < 1e-4);
}

/// Friction work per metre is what forces and moment take from all three creepages; the wear number leaves spin out.
#[test]
fn analytic_friction_work_has_the_spins_part() {
    for (law, moment) in [("fastsim", true), ("polach", false)] {
        let scene = scene(&[&format!("contact.creep.law={law}"), "vehicle.initial.y=0.002", "vehicle.initial.yaw=0.0005"]);
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        let found = read(&mut simulation, &outputs);
        for side in ["left", "right"] {
            let of = |name: &str| found[&format!("{side}.contact[1].{name}")];
            let plain = of("creepForceX") * of("longitudinalCreepage") + of("creepForceY") * of("lateralCreepage");
            let spin = of("spinMoment") * of("spinCreepage");
            let (work, wear) = (found[&format!("{side}.frictionWork")], found[&format!("{side}.wearNumber")]);
            println!("{law}, {side}: friction work {work:.4} J/m, spin's part {:.4}, wear number {wear:.4}", -spin);
            assert!(work > 0.0 && (work + plain + spin).abs() < 1e-12 * work, "{work} {plain} {spin}");
            assert!(wear >= -plain - 1e-12 && (spin != 0.0) == moment);
        }
    }
}

/// Contacts of a rigid wheelset at lateral displacement `y`: z and roll such that both wheels just touch.
fn rigid_contacts(model: &Model, y: f64) -> (f64, [ContactLocation; 2]) {
    let wheelset = &model.wheelsets[0];
    let find = |z: f64, roll: f64| {
        Side::BOTH.map(|side| {
            let axes = AxleFrame::new(0.0, roll).axes;
            let (wheel, rail) = (wheelset.wheel(side), model.track.rail(side));
            let centre = Vector3::new(0.0, y, z);
            Pair { wheel, rail, centre: &centre, axes: &axes, distance: 0.0 }.locate(&SurfaceParameters::default()).unwrap()
        })
    };
    let mut x = Vector2::new(0.457, 0.0);
    for _ in 0..20 {
        let residual = |x: &Vector2<f64>| {
            let contacts = find(x[0], x[1]);
            Vector2::new(contacts[0].penetration, contacts[1].penetration)
        };
        let h = 1e-7;
        let columns = [Vector2::new(h, 0.0), Vector2::new(0.0, h)].map(|step| (residual(&(x + step)) - residual(&(x - step))) / (2.0 * h));
        x -= Matrix2::from_columns(&columns).lu().solve(&residual(&x)).unwrap();
    }
    (x[1], find(x[0], x[1]))
}

#[test]
fn analytic_klingel_wavelength_with_the_roll_term() {
    // 2 pi sqrt(r0 s / lambda) sqrt(1 + r0 d(roll)/dy) at 2 m/s without suspension: the roll of the wheelset moves its
    // axle over the rail, so the centre's path is longer than Klingel's by the second root.
    let amplitude = 0.2e-3;
    let mut wheelset = straight(&["vehicle.speed=2", &format!("vehicle.initial.y={amplitude}"), "solver.tolerance=1e-9"]);
    wheelset.vehicle.forces.clear();
    let (r0, s) = (0.457, 0.716);
    let y = 1e-4;
    let model = wheelrail::scene::assemble::model(&wheelset).unwrap();
    let (roll_left, left) = rigid_contacts(&model, y);
    let (roll_right, _) = rigid_contacts(&model, -y);
    let conicity = (left[0].wheel_profile.value - left[1].wheel_profile.value) / (2.0 * y);
    let roll_slope = (roll_left - roll_right) / (2.0 * y);
    let klingel = 2.0 * PI * (r0 * s / conicity).sqrt();
    let with_roll = klingel * (1.0 + r0 * roll_slope).sqrt();

    let recording = run(&wheelset, 26.0, 0.01);
    let (y, x) = (column(&recording, "y"), column(&recording, "distance"));
    let crossings: Vec<f64> = (1..y.len())
        .filter(|&i| x[i] - x[0] > 3.0 && y[i - 1] * y[i] < 0.0)
        .map(|i| x[i - 1] + (x[i] - x[i - 1]) * y[i - 1] / (y[i - 1] - y[i]))
        .collect();
    assert!(crossings.len() >= 3, "{crossings:?}");
    let measured = crossings[2] - crossings[0];
    println!("conicity {:.6}, d(roll)/dy {roll_slope:.6} rad/m", conicity);
    println!(
        "Klingel {klingel:.4} m ({:+.3} %), with roll {with_roll:.4} m, simulated {measured:.4} m",
        100.0 * (klingel / measured - 1.0)
    );
    assert!((measured / with_roll - 1.0).abs() < 1e-3, "{measured} {with_roll}");
    assert!((measured / klingel - 1.0).abs() > 5e-3, "without the roll term the formula must be off by nearly 1 %");
    // Validated by the independent implementation (tests/data): eigenvalue 22.6138550 m, conicity 0.02567142.
    assert!((measured - 22.613855).abs() < 0.003 && (conicity - 0.025671421).abs() < 1e-7);
}

/// The model with one more state: the integral of 0.4 delta^2.5 dK_h, because Hertz's stiffness varies with position.
struct EnergyAudit {
    model: Model,
    workspace: Workspace,
    memory: ModelMemory,
}

impl EnergyAudit {
    fn evaluate(&mut self, y: &[f64], dy: &mut [f64]) -> Result<(), EvaluationError> {
        self.model.derivative(
            &mut self.workspace,
            Evaluation { t: 0.0, inputs: &self.model.neutral_inputs(), y, memory: &mut self.memory },
            dy,
        )
    }

    /// Kinetic, gravity, load, spring and contact energy minus the integral, J.
    fn energy(&mut self, y: &[f64]) -> f64 {
        let n = y.len() - 1;
        let mut dy = vec![0.0; n];
        self.evaluate(&y[..n], &mut dy).unwrap();
        let system = &self.model.system;
        let motions = &self.workspace.system.motions;
        let contact: f64 = self.workspace.contacts.iter().map(|c| 0.4 * c.stiffness * c.penetration.powf(2.5)).sum();
        system.kinetic_energy(motions) + system.potential_energy(&y[..n], &motions[..].into()) + contact - y[n]
    }
}

impl Dynamics for EnergyAudit {
    fn derivative(&mut self, _: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        let n = y.len() - 1;
        let (dy, extra) = dy.split_at_mut(n);
        self.evaluate(&y[..n], dy).map_err(|_| Undefined)?;
        // Rate of K_h along the motion, by a central difference.
        let h = 1e-5;
        let mut power = 0.0;
        let deep: Vec<f64> = self.workspace.contacts.iter().map(|c| 0.4 * c.penetration.powf(2.5)).collect();
        for sign in [1.0, -1.0] {
            let moved: Vec<f64> = y[..n].iter().zip(dy.iter()).map(|(y, dy)| y + sign * h * dy).collect();
            self.evaluate(&moved, &mut vec![0.0; n]).map_err(|_| Undefined)?;
            for (deep, contact) in deep.iter().zip(&self.workspace.contacts) {
                power += deep * sign * contact.stiffness / (2.0 * h);
            }
        }
        extra[0] = power;
        Ok(())
    }
    fn error_weight(&self, i: usize) -> f64 {
        if i < 6 { 1.0 } else { 0.0 }
    }
    fn next_break(&self, _: f64, _: &[f64]) -> f64 {
        f64::INFINITY
    }
}

impl Implicit for EnergyAudit {}

#[test]
fn analytic_energy_without_creep_and_damping_is_constant() {
    // Half a second of a wheelset that was pushed 1 mm aside: springs, contact and gyroscopic motion exchange energy.
    // At 10 m/s the energy of rolling does not drown the disturbance in rounding.
    let changes = [
        "vehicle.speed=10",
        "contact.friction=0",
        "contact.damping=0",
        "vehicle.suspension.longitudinal_damping=0",
        "vehicle.initial.y=0.001",
        "vehicle.initial.yaw=0.0005",
    ];
    let scene = straight(&changes);
    let drift = |tolerance: f64| {
        let model = wheelrail::scene::assemble::model(&scene).unwrap();
        let mut simulation = start(&scene);
        let mut y = simulation.snapshot().unwrap().y.clone();
        let rest = start(&straight(&changes[..4])).snapshot().unwrap().y.clone();
        y.push(0.0);
        let mut audit = EnergyAudit { workspace: model.workspace(), memory: model.blank_memory(), model };
        let at_rest = audit.energy(&[&rest[..], &[0.0]].concat());
        let before = audit.energy(&y);
        let disturbance = before - at_rest;
        let integrator = DormandPrince { tolerance };
        let mut state = integrator.start(0.0, &y);
        let mut scratch = Scratch::new(y.len(), 0);
        let mut largest = 0f64;
        for i in 1..=20 {
            integrator.advance(&mut audit, &mut state, &mut scratch, f64::from(i) / 40.0).unwrap();
            largest = largest.max((audit.energy(&state.y) - before).abs());
        }
        println!("tolerance {tolerance:.0e}: disturbance {disturbance:.4} J, largest drift {:.1e} of it", largest / disturbance);
        assert!(disturbance > 0.1);
        largest / disturbance
    };
    let (loose, tight, tightest) = (drift(1e-9), drift(1e-11), drift(1e-15));
    assert!(tightest < 1e-8, "{tightest:e}");
    // The local error of the step-size control is of order 5 in the step, the drift of order 5 or 6: the drift must fall
    // like tolerance^1 to tolerance^1.2.
    let slope = (loose / tight).log10() / 2.0;
    println!("drift falls like tolerance^{slope:.2}");
    assert!((0.85..1.4).contains(&slope), "{slope}");
}

#[test]
fn analytic_driven_axle_and_driving_force_balance() {
    let scene = straight(&[]);
    let torque = 5000.0;
    let mut simulation = start(&scene);
    simulation.set_input(wheelrail::formulation::DRIVE_TORQUE, torque, 0.0, 0.0);
    simulation.advance(3.0).unwrap();
    let outputs = table(&simulation, &scene);
    let found = read(&mut simulation, &outputs);
    let traction = found["left.longitudinalForce"] + found["right.longitudinalForce"];
    println!(
        "(Fx left + Fx right) r0 = {:.4} N m for T = {torque} N m; creepage {:.3e}",
        traction * 0.457,
        found["left.contact[1].longitudinalCreepage"]
    );
    assert!((traction * 0.457 / torque - 1.0).abs() < 1e-4);
    assert!(traction > 0.0 && found["left.contact[1].longitudinalCreepage"] < 0.0, "driving pushes forward and slips backward");

    let suspension = found["suspension.left.longitudinalForce"] + found["suspension.right.longitudinalForce"];
    assert!((found["drivingForce"] + traction + suspension).abs() < 1e-9 * traction.abs());

    // Also while everything moves.
    simulation.set_input(wheelrail::formulation::LATERAL_FORCE, 20_000.0, 0.0, 0.0);
    simulation.advance(3.033).unwrap();
    let found = read(&mut simulation, &outputs);
    let sum =
        ["left.longitudinalForce", "right.longitudinalForce", "suspension.left.longitudinalForce", "suspension.right.longitudinalForce"]
            .iter()
            .map(|name| found[*name])
            .sum::<f64>();
    assert!(found["yaw"].abs() > 1e-6 && (found["drivingForce"] + sum).abs() < 1e-6, "{} {sum}", found["drivingForce"]);
}

#[test]
fn analytic_rolling_backward_mirrors_the_braking_side() {
    // Steady rolling backward: pitch rate and driving force change sign, loads and spin effects stay.
    let (forward, backward) = (straight(&[]), straight(&["vehicle.speed=-40"]));
    let found = [forward, backward].map(|scene| {
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        read(&mut simulation, &outputs)
    });
    for name in ["pitchRate", "drivingForce"] {
        assert!((found[0][name] + found[1][name]).abs() < 1e-6 * found[0][name].abs(), "{name}");
    }
    // Spin phi = w . n / V keeps the sign of the rotation; its lateral force lies on the other side of the patch's frame.
    let spin = |i: usize| found[i]["left.contact[1].spinCreepage"];
    assert!((spin(0) + spin(1)).abs() < 1e-9);
    let y = |i: usize| found[i]["left.lateralForce"];
    assert!((y(0) - y(1)).abs() < 1e-6 * y(0).abs(), "{} {}", y(0), y(1));
}
