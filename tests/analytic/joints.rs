//! Mechanisms with joints against formulas: pendulums, slider-crank, Hooke's joint, parallelogram, gyroscope, chains.

use crate::counting;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::PI;
use std::time::Instant;
use wheelrail::mbs::body::{Body, BodyMotion, Wrench};
use wheelrail::mbs::driving::DrivingConstraint;
use wheelrail::mbs::force::{ForceElement, Gravity};
use wheelrail::mbs::inertia::Inertia;
use wheelrail::mbs::joint::{Joint, Level, Place, Prescribed, cylindrical, driven, prismatic, revolute, rigid, spherical, universal};
use wheelrail::mbs::kkt::RowBodies;
use wheelrail::mbs::moving::Moving;
use wheelrail::mbs::projection::{Projection, ProjectionError};
use wheelrail::mbs::redundancy::AssemblyError;
use wheelrail::mbs::system::{System, SystemWorkspace};
use wheelrail::mbs::tangent::{Ends, PairTangent};
use wheelrail::settings::Numbered;
use wheelrail::solve::{DormandPrince, Dynamics, Implicit, IntegrationState, Integrator, RungeKutta4, Scratch, Undefined};

const G: f64 = 9.81;

/// A system whose state is integrated.
struct Mechanism {
    system: System,
    workspace: SystemWorkspace,
}

impl Mechanism {
    /// With gravity on all bodies.
    fn new(bodies: Vec<Body>, joints: Vec<Joint>) -> Self {
        let weight = |(body, data): (usize, &Body)| {
            Box::new(Gravity { body, mass: data.mass, acceleration: G, grade: 0.0 }) as Box<dyn ForceElement>
        };
        let forces = bodies.iter().enumerate().map(weight).collect();
        Self::of(System { bodies, forces, drives: Vec::new(), supported: Vec::new(), joints, redundant: Vec::new() })
    }

    fn of(system: System) -> Self {
        Mechanism { workspace: system.workspace(&[]), system }
    }

    /// Leaves redundant rows out and returns their names.
    fn assemble(&mut self, y: &[f64]) -> Result<Vec<String>, AssemblyError> {
        let found = self.system.find_redundant(0.0, y)?;
        self.system.redundant = found.iter().map(|row| row.row).collect();
        self.workspace = self.system.workspace(&[]);
        Ok(found.into_iter().map(|row| row.name).collect())
    }

    fn project(&mut self, t: f64, y: &mut [f64]) -> Projection {
        self.system.project::<ProjectionError>(t, y, &mut self.workspace, 1e-13, |_| Ok(())).unwrap()
    }

    fn energy(&mut self, y: &[f64]) -> f64 {
        self.system.move_bodies(y, &mut self.workspace);
        self.system.kinetic_energy(&self.workspace.motions) + self.system.potential_energy(y, &self.workspace.moving())
    }

    /// Integrates from y at 0 to `end`, with a projection at the end of each of `parts` equal parts.
    fn run(&mut self, y: &[f64], end: f64, parts: u32, tolerance: f64) -> (Vec<f64>, f64) {
        let integrator = DormandPrince { tolerance };
        let mut y = y.to_vec();
        let mut scratch = Scratch::new(y.len(), 0);
        let mut drift: f64 = 0.0;
        for part in 0..parts {
            let at = |part: u32| end * f64::from(part) / f64::from(parts);
            let mut state = integrator.start(at(part), &y);
            integrator.advance(self, &mut state, &mut scratch, at(part + 1)).unwrap();
            state.interpolate_beside(at(part + 1), &mut y, |_, _| ());
            drift = drift.max(self.project(at(part + 1), &mut y).drift);
        }
        (y, drift)
    }
}

impl Dynamics for Mechanism {
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        self.system.apply_forces(y, &mut self.workspace);
        self.system.constrained_derivative(t, y, &mut self.workspace, dy).map_err(|_| Undefined)
    }
    fn error_weight(&self, i: usize) -> f64 {
        if i < self.system.dimension() / 2 { 1.0 } else { 0.0 }
    }
    fn next_break(&self, _: f64, _: &[f64]) -> f64 {
        f64::INFINITY
    }
}

impl Implicit for Mechanism {}

fn brick(mass: f64, x: f64, y: f64, z: f64) -> Body {
    Body { name: "brick".into(), mass, inertia: Inertia::General { principal: Vector3::new(x, y, z) } }
}

fn to_ground(first: usize) -> RowBodies {
    RowBodies { first, second: None }
}

fn between(first: usize, second: usize) -> RowBodies {
    RowBodies { first, second: Some(second) }
}

/// A place whose axis is the body's (or the track's) Y.
fn about_y(x: f64, y: f64, z: f64) -> Place {
    Place::along(Vector3::new(x, y, z), &Vector3::y())
}

/// Complete elliptic integral of the first kind, by the arithmetic-geometric mean.
fn elliptic_k(k: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
    for _ in 0..12 {
        (a, b) = ((a + b) / 2.0, f64::sqrt(a * b));
    }
    PI / (2.0 * a)
}

/// State of bodies at the given coordinates, at rest.
fn at_rest(coordinates: &[[f64; 6]]) -> Vec<f64> {
    let mut y = coordinates.concat();
    y.resize(2 * y.len(), 0.0);
    y
}

/// Centre of a body with yaw 0, roll 0 whose point `local` [x, z] is at (x, z) in the plane of X and Z.
fn centre(at: [f64; 2], local: [f64; 2], pitch: f64) -> [f64; 6] {
    let (sin, cos) = pitch.sin_cos();
    [at[0] - cos * local[0] - sin * local[1], 0.0, at[1] + sin * local[0] - cos * local[1], 0.0, 0.0, pitch]
}

#[test]
fn analytic_period_of_a_pendulum_with_large_amplitude() {
    let (mass, length, inertia, amplitude) = (3.0, 0.8, 0.4, 2.0f64);
    let joint = revolute("pivot", to_ground(0), &about_y(0.0, 0.0, length), &about_y(0.0, 0.0, 0.0));
    let mut pendulum = Mechanism::new(vec![brick(mass, 0.7, inertia, 0.2)], vec![joint]);
    let y = at_rest(&[centre([0.0, 0.0], [0.0, length], amplitude)]);
    assert!(pendulum.assemble(&y).unwrap().is_empty());
    let about_pivot = inertia + mass * length * length;
    let period = 4.0 * (about_pivot / (mass * G * length)).sqrt() * elliptic_k((amplitude / 2.0).sin());
    // At a quarter the pendulum passes the bottom at full speed.
    let (y, drift) = pendulum.run(&y, period / 4.0, 1, 1e-13);
    let speed = -(2.0 * mass * G * length * (1.0 - amplitude.cos()) / about_pivot).sqrt();
    println!("pitch at the bottom {:.1e} rad, rate off by {:.1e}, drift {drift:.1e}", y[5], y[11] - speed);
    assert!(y[5].abs() < 1e-9 && (y[11] - speed).abs() < 1e-9);
    // The pin's force at the bottom: weight and centripetal force.
    let mut dy = vec![0.0; 12];
    pendulum.derivative(0.0, &y, &mut dy).unwrap();
    let lifted = pendulum.workspace.constraints.kkt.constraint_force(0, 2, &pendulum.workspace.constraints.multipliers);
    let expected = mass * (G + speed * speed * length);
    assert!((lifted / expected - 1.0).abs() < 1e-9, "{lifted} {expected}");
}

#[test]
fn analytic_double_pendulum_in_space_keeps_its_energy() {
    let bodies = vec![brick(2.0, 0.3, 0.2, 0.1), brick(1.0, 0.05, 0.06, 0.04)];
    let joints = vec![
        spherical("upper", to_ground(0), &Place::at(Vector3::new(0.0, 0.1, 0.5)), &Place::at(Vector3::zeros())),
        universal(
            "lower",
            between(0, 1),
            &Place::along(Vector3::new(0.0, 0.0, -0.5), &Vector3::x()),
            &Place::along(Vector3::new(0.0, 0.0, 0.4), &Vector3::y()),
        ),
    ];
    let mut pendulum = Mechanism::new(bodies, joints);
    // Thrown together roughly: the projection assembles it.
    let mut y = at_rest(&[[0.3, -0.1, -0.4, 0.1, 0.5, -0.8], [0.7, -0.2, -0.8, 0.2, 0.4, -0.9]]);
    y[12..].copy_from_slice(&[0.5, 0.2, 0.0, 1.0, -0.5, 0.8, 0.3, 0.1, 0.0, -1.0, 0.7, 0.2]);
    let assembled = pendulum.project(0.0, &mut y);
    println!("assembly: {assembled:?}");
    assert!(assembled.iterations > 2 && assembled.residual < 1e-13 && assembled.position_change > 0.05);
    assert!(pendulum.assemble(&y).unwrap().is_empty());
    let before = pendulum.energy(&y);
    let (end, drift) = pendulum.run(&y, 3.0, 30, 1e-11);
    let error = (pendulum.energy(&end) - before).abs();
    let after = pendulum.project(3.0, &mut end.clone());
    println!("energy {before:.3} J, off by {error:.1e} J after 3 s; drift before projections {drift:.1e}, after {:.1e}", after.drift);
    assert!(error < 1e-7 && drift > 1e-13 && drift < 1e-8 && after.drift < 1e-12);
    assert!((end[0] - y[0]).abs() > 0.05);
    // Rates satisfy the constraints too.
    let rates = &pendulum.workspace.constraints.rate;
    assert!(rates.iter().all(|rate| rate.abs() < 1e-12), "{rates:?}");
}

/// Crank of length 0.3 about Y, driven; rod of length 1; slider along X. Bodies: crank, rod, slider.
fn slider_crank(drive: Joint) -> Mechanism {
    let bodies = vec![brick(2.0, 0.1, 0.1, 0.1), brick(1.0, 0.02, 0.1, 0.1), brick(4.0, 0.3, 0.3, 0.3)];
    let joints = vec![
        revolute("crank", to_ground(0), &about_y(-0.15, 0.0, 0.0), &about_y(0.0, 0.0, 0.0)),
        spherical("pin", between(0, 1), &Place::at(Vector3::new(0.15, 0.0, 0.0)), &Place::at(Vector3::new(-0.5, 0.0, 0.0))),
        universal("gudgeon", between(2, 1), &about_y(0.0, 0.0, 0.0), &Place::at(Vector3::new(0.5, 0.0, 0.0))),
        prismatic("guide", to_ground(2), &Place::along(Vector3::zeros(), &Vector3::x()), &Place::along(Vector3::zeros(), &Vector3::x())),
        drive,
    ];
    Mechanism::new(bodies, joints)
}

/// Slider's place for a crank angle, and the mechanism's coordinates.
fn slider_crank_at(angle: f64) -> (f64, Vec<f64>) {
    let (sin, cos) = angle.sin_cos();
    let slider = 0.3 * cos + (1.0 - 0.09 * sin * sin).sqrt();
    let rod = -(0.3 * sin).asin();
    let pin = [0.3 * cos, -0.3 * sin];
    let y = at_rest(&[centre([0.0; 2], [-0.15, 0.0], angle), centre(pin, [-0.5, 0.0], rod), [slider, 0.0, 0.0, 0.0, 0.0, 0.0]]);
    (slider, y)
}

#[test]
fn analytic_slider_crank() {
    let speed = 7.0;
    let mut mechanism = slider_crank(driven("motor", to_ground(0), 5, Level::Position, Prescribed::uniform(0.4, speed)));
    let (_, mut y) = slider_crank_at(0.4);
    mechanism.project(0.0, &mut y);
    assert!(mechanism.assemble(&y).unwrap().is_empty());
    let end = 2.0;
    let (y, drift) = mechanism.run(&y, end, 20, 1e-10);
    let angle: f64 = 0.4 + speed * end;
    let (slider, _) = slider_crank_at(angle);
    let root = (1.0 - 0.09 * angle.sin().powi(2)).sqrt();
    let velocity = -0.3 * speed * angle.sin() * (1.0 + 0.3 * angle.cos() / root);
    println!("slider off by {:.1e} m, {:.1e} m/s after {end} s; drift {drift:.1e}", y[12] - slider, y[30] - velocity);
    assert!((y[12] - slider).abs() < 1e-12 && (y[30] - velocity).abs() < 1e-12);
    // The motor's power is the rate of the energy.
    let mut dy = vec![0.0; 36];
    mechanism.derivative(end, &y, &mut dy).unwrap();
    let motor = mechanism.system.joints.iter().map(Joint::rows).sum::<usize>() - 1;
    let power = -mechanism.workspace.constraints.multipliers[motor] * speed;
    let h = 1e-5;
    let at = |h: f64| y.iter().zip(&dy).map(|(y, dy)| y + h * dy).collect::<Vec<_>>();
    let rate = (mechanism.energy(&at(h)) - mechanism.energy(&at(-h))) / (2.0 * h);
    println!("motor {power:.6} W, rate of energy {rate:.6} W");
    assert!((power - rate).abs() < 1e-4 * power.abs());
}

#[test]
fn hard_dead_centre_is_reported() {
    // At a dead centre the slider cannot drive the crank.
    let law = Prescribed::new(|_| [1.3, 0.0, 0.0]);
    let mut mechanism = slider_crank(driven("piston", to_ground(2), 0, Level::Position, law));
    let (_, y) = slider_crank_at(0.0);
    let error = mechanism.assemble(&y).unwrap_err();
    println!("{error}");
    assert!(matches!(&error, AssemblyError::SpecialPosition { names } if names == "piston.x"), "{error}");
    // Beside it the same drive is one of the mechanism's 18 independent rows.
    let (slider, y) = slider_crank_at(0.5);
    let law = Prescribed::new(move |_| [slider, 0.0, 0.0]);
    let mut mechanism = slider_crank(driven("piston", to_ground(2), 0, Level::Position, law));
    assert_eq!(mechanism.assemble(&y), Ok(vec![]));
}

#[test]
fn hard_contradictions_are_named() {
    let (_, y) = slider_crank_at(0.4);
    let mut mechanism = slider_crank(driven("motor", to_ground(0), 5, Level::Position, Prescribed::uniform(0.4, 7.0)));
    // A second motor, one that agrees and one that does not.
    let second = |speed| driven("second", to_ground(0), 5, Level::Speed, Prescribed::uniform(0.0, speed));
    mechanism.system.joints.push(second(7.0));
    let named = mechanism.assemble(&y).unwrap();
    assert_eq!(named, ["second.pitch"]);
    mechanism.system.joints.pop();
    mechanism.system.joints.push(second(8.0));
    let error = mechanism.assemble(&y).unwrap_err();
    println!("{error}");
    assert!(matches!(&error, AssemblyError::Contradiction { names } if names == "second.pitch"), "{error}");
}

#[test]
fn analytic_hookes_joint_speed_ratio() {
    // Shaft 1 along Y, shaft 2 yawed by beta; both in bearings, so the joint's own point is redundant.
    let (beta, speed) = (0.6f64, 5.0);
    let shaft = Place::along(Vector3::zeros(), &Vector3::new(-beta.sin(), beta.cos(), 0.0));
    let joints = vec![
        revolute("bearing1", to_ground(0), &about_y(0.0, 0.0, 0.0), &about_y(0.0, 0.0, 0.0)),
        revolute("bearing2", to_ground(1), &about_y(0.0, 0.0, 0.0), &shaft),
        universal("cross", between(0, 1), &Place::at(Vector3::zeros()), &Place::along(Vector3::zeros(), &Vector3::x())),
        driven("motor", to_ground(0), 5, Level::Speed, Prescribed::uniform(0.0, speed)),
    ];
    let mut mechanism = Mechanism::new(vec![brick(1.0, 0.1, 0.2, 0.1), brick(1.0, 0.3, 0.4, 0.3)], joints);
    let mut y = at_rest(&[[0.0; 6], [0.0, 0.0, 0.0, beta, 0.0, 0.0]]);
    y[17] = speed;
    y[23] = speed * beta.cos();
    let names = mechanism.assemble(&y).unwrap();
    println!("redundant: {names:?}");
    assert_eq!(names, ["cross.x", "cross.y", "cross.z"]);
    let mut worst: f64 = 0.0;
    for end in [0.1, 0.35, 0.7, 1.2] {
        let (y, _) = mechanism.run(&y, end, 10, 1e-11);
        let angle = y[5];
        assert!((angle - speed * end).abs() < 1e-9);
        let ratio = beta.cos() / (angle.cos().powi(2) + (beta.cos() * angle.sin()).powi(2));
        worst = worst.max((y[23] / y[17] - ratio).abs());
        assert!(((y[11] - angle).tan() - ((beta.cos() * angle.tan()).atan() - angle).tan()).abs() < 1e-10);
    }
    println!("speed ratio between {:.3} and {:.3}, off by {worst:.1e}", beta.cos(), 1.0 / beta.cos());
    assert!(worst < 1e-11);
}

/// Parallelogram in the plane of X and Z: two cranks of length 0.5, 0.8 apart, and a coupler; four parallel hinges.
fn parallelogram(last_axis: Vector3<f64>) -> Mechanism {
    let bodies = vec![brick(1.0, 0.1, 0.1, 0.1), brick(2.0, 0.1, 0.3, 0.1), brick(1.0, 0.1, 0.1, 0.1)];
    let joints = vec![
        revolute("a", to_ground(0), &about_y(0.0, 0.0, 0.25), &about_y(0.0, 0.0, 0.0)),
        revolute("b", between(0, 1), &about_y(0.0, 0.0, -0.25), &about_y(-0.4, 0.0, 0.0)),
        revolute("c", between(1, 2), &about_y(0.4, 0.0, 0.0), &about_y(0.0, 0.0, -0.25)),
        revolute("d", to_ground(2), &Place::along(Vector3::new(0.0, 0.0, 0.25), &last_axis), &about_y(0.8, 0.0, 0.0)),
    ];
    Mechanism::new(bodies, joints)
}

#[test]
fn analytic_parallelogram_in_space_with_redundant_rows() {
    let pitch: f64 = 0.9;
    let crank = |x: f64| centre([x, 0.0], [0.0, 0.25], pitch);
    let coupler = [0.4 - 0.5 * pitch.sin(), 0.0, -0.5 * pitch.cos(), 0.0, 0.0, 0.0];
    let y = at_rest(&[crank(0.0), coupler, crank(0.8)]);
    let mut mechanism = parallelogram(Vector3::y());
    let names = mechanism.assemble(&y).unwrap();
    println!("redundant: {names:?}");
    // 18 coordinates, one free motion, 20 rows: three too many, all of them out of the plane.
    assert_eq!(names, ["d.y", "d.tilt_x", "d.tilt_y"]);
    let before = mechanism.energy(&y);
    let (end, drift) = mechanism.run(&y, 1.1, 11, 1e-11);
    let error = (mechanism.energy(&end) - before).abs();
    println!("energy off by {error:.1e} J, coupler turned by {:.1e} rad, drift {drift:.1e}, cranks at {:.3} rad", end[11], end[5]);
    assert!(error < 1e-8 && end[11].abs() < 1e-12 && (end[5] - end[17]).abs() < 1e-12 && (end[5] - pitch).abs() > 0.1);
    // It swings like a pendulum with the coupler's mass at the cranks' ends.
    let inertia = 2.0 * (0.1 + 0.0625) + 2.0 * 0.25;
    let torque = (2.0 * 0.25 + 2.0 * 0.5) * G;
    let rate = (2.0 * torque * (end[5].cos() - pitch.cos()) / inertia).sqrt();
    assert!((end[18 + 5].abs() - rate).abs() < 1e-8, "{} {rate}", end[23]);

    // A hinge out of parallel: the loop does not close.
    let error = parallelogram(Vector3::new(0.0, 1.0, 1e-3)).assemble(&y).unwrap_err();
    println!("{error}");
    assert!(matches!(&error, AssemblyError::Contradiction { names } if names.contains("tilt")), "{error}");
}

#[test]
fn analytic_steady_precession_of_a_gyroscope() {
    // A spinning wheel (its attachments do not spin) held at one end of its axle: with the axle level it precesses at
    // m g L / (I spin) exactly.
    let (mass, arm, axial, spin) = (5.0, 0.6, 0.9, 40.0);
    let wheel = Body { name: "wheel".into(), mass, inertia: Inertia::Revolution { transverse: 0.5, axial } };
    let joint = spherical("tip", to_ground(0), &Place::at(Vector3::new(0.0, -arm, 0.0)), &Place::at(Vector3::zeros()));
    let mut gyroscope = Mechanism::new(vec![wheel], vec![joint]);
    let mut y = at_rest(&[[0.0, arm, 0.0, 0.0, 0.0, 0.0]]);
    // The weight's moment about the tip is m g l along -X; it is the rate of the momentum I spin Y: yaw' Z x Y.
    let precession = mass * G * arm / (axial * spin);
    y[6] = -precession * arm;
    y[9] = precession;
    y[11] = spin;
    let end = 3.0;
    let (after, drift) = gyroscope.run(&y, end, 10, 1e-12);
    println!("yaw off by {:.1e} rad, roll {:.1e} rad after {end} s; drift {drift:.1e}", after[3] - y[9] * end, after[4]);
    assert!((after[3] - y[9] * end).abs() < 1e-8 && after[4].abs() < 1e-8 && (after[5] - spin * end).abs() < 1e-6);
}

#[test]
fn analytic_sliding_on_an_inclined_axis() {
    // Down an axis inclined by alpha a body slides with g sin(alpha); in a cylindrical joint it keeps spinning.
    let alpha: f64 = 0.5;
    let axis = Vector3::new(alpha.cos(), 0.0, -alpha.sin());
    let ground = Place::along(Vector3::new(0.1, 0.2, 0.3), &axis);
    for spinning in [true, false] {
        let motion = BodyMotion::general(&[0.1, 0.2, 0.3, 0.0, 0.0, alpha], &[0.0; 6]);
        let place = ground.seen_from(Some(&motion));
        let make = if spinning { cylindrical } else { prismatic };
        // The ground's axis carries the body's point, or the body's axis passes through the ground's point: the same.
        let mut slider = Mechanism::new(vec![brick(2.0, 0.1, 0.3, 0.3)], vec![make("axis", to_ground(0), &place, &ground)]);
        let mut y = at_rest(&[[0.1, 0.2, 0.3, 0.0, 0.0, alpha]]);
        let spin = 2.0;
        if spinning {
            // Roll about the axle frame's X is not the body's X; the angular velocity along the axis in coordinates:
            let omega = axis * spin;
            (y[9], y[10], y[11]) = (omega.z, omega.x, omega.y);
        }
        let end = 0.4;
        let (after, drift) = slider.run(&y, end, 4, 1e-12);
        let path = 0.5 * G * alpha.sin() * end * end;
        let found = Vector3::new(after[0] - 0.1, after[1] - 0.2, after[2] - 0.3);
        println!("spinning {spinning}: path off by {:.1e} m, drift {drift:.1e}", (found - axis * path).norm());
        assert!((found - axis * path).norm() < 1e-10);
        let motion = BodyMotion::general(&after[..6], &after[6..]);
        let expected = axis * if spinning { spin } else { 0.0 };
        assert!((motion.rotation - expected).norm() < 1e-10);
        let turned = Rotation3::from_scaled_axis(expected * end) * Rotation3::from_axis_angle(&Vector3::y_axis(), alpha);
        assert!((motion.frame.axes - turned.matrix()).norm() < 1e-10);
    }
}

#[test]
fn equiv_rigidly_joined_bodies_swing_as_one() {
    // Two halves 0.6 m apart against one body of their mass and inertia.
    let (half, offset) = (brick(1.5, 0.1, 0.2, 0.15), 0.3);
    let whole = brick(3.0, 0.2, 0.4 + 3.0 * offset * offset, 0.3 + 3.0 * offset * offset);
    let pivot = |x: f64| spherical("pivot", to_ground(0), &Place::at(Vector3::new(x, 0.0, 0.9)), &Place::at(Vector3::zeros()));
    let weld = rigid("weld", between(0, 1), &Place::at(Vector3::new(offset, 0.0, 0.0)), &Place::at(Vector3::new(-offset, 0.0, 0.0)));
    let mut one = Mechanism::new(vec![whole], vec![pivot(0.0)]);
    let mut two = Mechanism::new(vec![half.clone(), half], vec![pivot(offset), weld]);
    let angles = [0.2, 0.3, 0.7];
    let rates = [0.5, -0.4, 0.9];
    let state = |shifts: &[f64]| {
        let (mut positions, mut velocities) = (Vec::new(), Vec::new());
        for shift in shifts {
            let motion =
                BodyMotion::general(&[0.0, 0.0, 0.0, angles[0], angles[1], angles[2]], &[0.0, 0.0, 0.0, rates[0], rates[1], rates[2]]);
            let arm = motion.frame.axes * Vector3::new(*shift, 0.0, -0.9);
            let velocity = motion.rotation.cross(&arm);
            positions.extend(arm.iter().chain(&angles));
            velocities.extend(velocity.iter().chain(&rates));
        }
        [positions, velocities].concat()
    };
    let (a, _) = one.run(&state(&[0.0]), 1.0, 5, 1e-12);
    let (b, drift) = two.run(&state(&[-offset, offset]), 1.0, 5, 1e-12);
    let difference = (0..3).map(|i| (a[3 + i] - b[3 + i]).abs()).fold(0.0, f64::max);
    println!("angles differ by {difference:.1e} rad after 1 s; drift {drift:.1e}");
    assert!(difference < 1e-9 && (a[3] - angles[0]).abs() > 0.1);
}

/// A constant force along X.
#[derive(Clone, Debug)]
struct Push(usize, f64);

impl Numbered for Push {}

impl ForceElement for Push {
    fn name(&self) -> &str {
        "push"
    }
    fn apply(&self, _: &Moving, _: &[f64], _: &mut [f64], wrenches: &mut [Wrench]) {
        wrenches[self.0].force.x += self.1;
    }
    fn bodies(&self) -> Ends {
        [Some(self.0), None]
    }
    fn tangent(&self, _: &Moving, _: &[f64], _: usize, _: &mut PairTangent) {}
    fn potential_energy(&self, _: &Moving, _: &[f64]) -> f64 {
        0.0
    }
    fn dissipated_power(&self, _: &Moving, _: &[f64]) -> f64 {
        0.0
    }
}

#[test]
fn analytic_driving_force_carries_what_joints_hand_on() {
    // Body 0 travels with imposed speed and pulls body 1, which is pushed back.
    let bodies = vec![brick(2.0, 0.1, 0.1, 0.1), brick(3.0, 0.1, 0.1, 0.1)];
    let coupling = rigid("coupling", between(0, 1), &Place::at(Vector3::new(-1.0, 0.0, 0.0)), &Place::at(Vector3::new(1.0, 0.0, 0.0)));
    let drives = vec![DrivingConstraint::constant(0, 20.0)];
    let forces: Vec<Box<dyn ForceElement>> = vec![Box::new(Push(1, -700.0)), Box::new(Push(0, 50.0))];
    let mut train = Mechanism::of(System { bodies, forces, drives, supported: vec![], joints: vec![coupling], redundant: vec![] });
    let mut y = at_rest(&[[0.0; 6], [-2.0, 0.0, 0.0, 0.0, 0.0, 0.0]]);
    (y[12], y[18]) = (20.0, 15.0);
    let projected = train.project(0.0, &mut y);
    // The imposed speed does not give way.
    assert_eq!((y[12], projected.velocity_change), (20.0, 5.0));
    assert_eq!(y[18], 20.0);
    let mut dy = vec![0.0; 24];
    train.derivative(0.0, &y, &mut dy).unwrap();
    assert!((train.workspace.drive_forces[0] - 650.0).abs() < 1e-9 && dy[12] == 0.0 && dy[18].abs() < 1e-12);
    // A second drive of the same coordinate has nothing left to move.
    train.system.joints.push(driven("again", to_ground(0), 0, Level::Speed, Prescribed::uniform(0.0, 20.0)));
    assert_eq!(train.assemble(&y), Ok(vec!["again.x".to_string()]));
}

#[test]
fn analytic_drive_between_two_bodies_follows_its_law() {
    let law = Prescribed::new(|t: f64| [0.5 + 0.1 * (4.0 * t).sin(), 0.4 * (4.0 * t).cos(), -1.6 * (4.0 * t).sin()]);
    let joint = driven("actuator", between(1, 0), 1, Level::Position, law);
    let bodies = vec![brick(2.0, 0.1, 0.1, 0.1), brick(3.0, 0.1, 0.1, 0.1)];
    let mut pair = Mechanism::new(bodies, vec![joint]);
    let mut y = at_rest(&[[0.0; 6], [0.0, 0.5, 0.0, 0.0, 0.0, 0.0]]);
    pair.project(0.0, &mut y);
    let (after, _) = pair.run(&y, 1.0, 5, 1e-11);
    let expected = 0.5 + 0.1 * 4.0f64.sin();
    assert!((after[7] - after[1] - expected).abs() < 1e-12);
    // The common centre of mass, at rest after the start, stays where it was.
    let moved = (2.0 * after[1] + 3.0 * after[7]) / 5.0 - 0.3;
    println!("centre of mass moved by {moved:.1e} m");
    assert!(moved.abs() < 1e-10);
}

/// A chain of `links` bodies 0.2 m long, fixed at one end, with hinges across it that lie in different directions,
/// each bent by some angle.
fn chain(links: usize) -> (Mechanism, Vec<f64>) {
    let bodies = vec![brick(1.0, 0.01, 0.02, 0.02); links];
    let axis = |k: usize| if k.is_multiple_of(2) { Vector3::y() } else { Vector3::new(0.0, 0.6, 0.8) };
    let joints = (0..links).map(|k| {
        let place = |x: f64| Place::along(Vector3::new(x, 0.0, 0.0), &axis(k));
        match k.checked_sub(1) {
            None => revolute("root", to_ground(0), &place(-0.1), &place(0.0)),
            Some(before) => revolute(&format!("link{k}"), between(k, before), &place(-0.1), &place(0.1)),
        }
    });
    let (mut end, mut turned) = (Vector3::zeros(), Rotation3::identity());
    let coordinates: Vec<[f64; 6]> = (0..links)
        .map(|k| {
            turned *= Rotation3::from_scaled_axis(axis(k) * 0.4 * (1.7 * k as f64).sin());
            let middle: Vector3<f64> = end + turned * Vector3::new(0.1, 0.0, 0.0);
            end += turned * Vector3::new(0.2, 0.0, 0.0);
            let axes = turned.matrix();
            let (yaw, roll) = ((-axes[(0, 1)]).atan2(axes[(1, 1)]), axes[(2, 1)].asin());
            [middle.x, middle.y, middle.z, yaw, roll, (-axes[(2, 0)]).atan2(axes[(2, 2)])]
        })
        .collect();
    (Mechanism::new(bodies, joints.collect()), at_rest(&coordinates))
}

#[test]
fn prop_cost_of_a_chain_is_linear_and_nothing_allocates() {
    let mut stored = Vec::new();
    for links in [10, 100, 1000] {
        let (mut chain, mut y) = chain(links);
        let start = Instant::now();
        assert_eq!(chain.assemble(&y), Ok(vec![]));
        let assembly = start.elapsed().as_secs_f64();
        let integrator = RungeKutta4 { step: 0.01 };
        let mut scratch = Scratch::new(y.len(), 0);
        let mut state = integrator.start(0.0, &y);
        integrator.advance(&mut chain, &mut state, &mut scratch, 0.1).unwrap();
        y.copy_from_slice(&state.y);
        let mut dy = vec![0.0; y.len()];
        let before = counting::count();
        let start = Instant::now();
        let projection = chain.project(0.1, &mut y);
        let projecting = start.elapsed().as_secs_f64();
        let start = Instant::now();
        for _ in 0..10 {
            chain.derivative(0.1, &y, &mut dy).unwrap();
        }
        let derivative = start.elapsed().as_secs_f64() / 10.0;
        assert_eq!(counting::count(), before, "the stepping path allocates");
        let again = chain.project(0.1, &mut y);
        let (matrix, factor) = chain.workspace.constraints.kkt.stored();
        println!(
            "{links} links: S {matrix}, L {factor} numbers; assembly {:.1} ms, evaluation {:.1} us, projection {:.1} us; drift {:.1e} -> {:.1e} in {} iterations",
            1e3 * assembly,
            1e6 * derivative,
            1e6 * projecting,
            projection.drift,
            again.drift,
            projection.iterations
        );
        assert!(again.drift < 1e-12 && projection.drift > again.drift);
        stored.push(factor as f64 / links as f64);
    }
    let _seen = Box::new(stored.len());
    // At most the blocks on and beside the diagonal (15 + 25 numbers per link) and little fill.
    assert!(stored.iter().all(|numbers| *numbers < 1.3 * 40.0), "{stored:?}");
}

#[test]
fn prop_projected_chain_swings_without_drift() {
    let (mut chain, y) = chain(8);
    let before = chain.energy(&y);
    let integrator = DormandPrince { tolerance: 1e-10 };
    let mut state: IntegrationState = integrator.start(0.0, &y);
    let mut scratch = Scratch::new(y.len(), 0);
    integrator.advance(&mut chain, &mut state, &mut scratch, 0.8).unwrap();
    let free_drift = chain.project(state.t, &mut state.y.clone()).drift;
    let (end, drift) = chain.run(&y, 0.8, 40, 1e-10);
    let after = chain.project(0.8, &mut end.clone()).drift;
    let energy = (chain.energy(&end) - before).abs();
    println!("drift without projection {free_drift:.1e}, between projections {drift:.1e}, after {after:.1e}; energy off by {energy:.1e} J");
    assert!(after < 1e-12 && drift < free_drift && energy < 1e-6);
}
