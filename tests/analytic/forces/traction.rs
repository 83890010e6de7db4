//! Motors and brakes on an axle: inertia through the gear, reactions, sticking, stopping.

use super::stage::{Mechanism, Stage, apply_under, brick, under};
use nalgebra::Vector3;
use std::f64::consts::PI;
use wheelrail::mbs::body::{Body, BodyMotion};
use wheelrail::mbs::force::ForceElement;
use wheelrail::mbs::inertia::Inertia;

const RADIUS: f64 = 0.46;

/// An axle 1.2 m behind the centre of its carrier, both 0.5 m high; `nose` is a place of the carrier 0.9 m ahead of the axle, `block` one at the tread's rear.
fn stage() -> Stage {
    let centre = Vector3::new(1.2, 0.0, 0.5);
    let places = vec![
        ("nose", Some(0), Vector3::new(0.9, 0.0, 0.7)),
        ("block", Some(0), Vector3::new(-RADIUS, 0.75, 0.5)),
        ("axle", Some(1), Vector3::new(0.0, 0.0, 0.5)),
    ];
    Stage { centres: vec![centre, Vector3::new(0.0, 0.0, 0.5)], places, mirror: 1.0 }
}

fn element(from: &str, settings: &str) -> Box<dyn ForceElement> {
    stage().element(&format!("name = \"e\"\nfrom = \"{from}\"\nto = \"axle\"\n{settings}"))
}

fn axle(axial: f64) -> Body {
    Body { name: "axle".into(), mass: 1500.0, inertia: Inertia::Revolution { transverse: 800.0, axial } }
}

/// Carrier and axle at rest in their places, the axle spinning.
fn standing(spin: f64) -> Vec<BodyMotion> {
    let q = stage().design();
    vec![BodyMotion::general(&q[..6], &[0.0; 6]), BodyMotion::new(&q[6..], &[0.0, 0.0, 0.0, 0.0, 0.0, spin])]
}

/// Carrier far heavier than all that acts on it, and an axle that nothing else holds.
fn on_a_rock(element: Box<dyn ForceElement>, axial: f64) -> Mechanism {
    Mechanism::new(vec![brick(1e15, 1e15, 1e15, 1e15), axle(axial)], vec![element])
}

/// Torque on the axle i M forward; on the carrier i M backward about the axle, as a couple, or as M i / L at the nose, pressed down ahead of a driven axle.
#[test]
fn analytic_a_motor_pushes_its_carrier_back() {
    let (torque, ratio) = (1022.0, 4.5);
    let whole = ratio * torque;
    let shaft = element("nose", "kind = \"motor_gear\"\nmount = \"shaft\"\nratio = 4.5");
    let (on, _) = apply_under(shaft.as_ref(), &standing(30.0), &[], &[torque]);
    assert!((on[1].moment - Vector3::y() * whole).norm() < 1e-9 && (on[0].moment + Vector3::y() * whole).norm() < 1e-9);
    assert!(on.iter().all(|wrench| wrench.force.norm() == 0.0));
    let nose = element("nose", "kind = \"motor_gear\"\nmount = \"nose\"\nratio = 4.5");
    let (on, _) = apply_under(nose.as_ref(), &standing(30.0), &[], &[torque]);
    assert!((on[1].moment.y - whole).abs() < 1e-9 && (on[1].force.z + whole / 0.9).abs() < 1e-9, "{:?}", on[1]);
    assert!((on[0].force.z - whole / 0.9).abs() < 1e-9, "a motor ahead of its axle lifts its nose");
    let (bodies, inputs) = (standing(30.0), [torque]);
    assert!((nose.supplied_power(&under(&bodies, &inputs), &[]) - whole * 30.0).abs() < 1e-9);
}

/// An axle that has come 20 mm along in its guides has the gear's torque and its ratio as before, and a block keeps its radius: links and blocks go with the axle's bearings.
#[test]
fn analytic_an_axle_that_has_moved_in_its_guides_keeps_torque_and_ratio() {
    let (torque, ratio, spin) = (1022.0, 4.5, 30.0);
    let mut q = stage().design();
    (q[6], q[8]) = (q[6] + 0.02, q[8] + 0.01);
    let bodies = vec![BodyMotion::general(&q[..6], &[0.0; 6]), BodyMotion::new(&q[6..], &[0.0, 0.0, 0.0, 0.0, 0.0, spin])];
    let inputs = [torque];
    let moving = under(&bodies, &inputs);
    let nose = element("nose", "kind = \"motor_gear\"\nmount = \"nose\"\nratio = 4.5");
    let (on, _) = apply_under(nose.as_ref(), &bodies, &[], &inputs);
    assert!((on[1].moment.y - ratio * torque).abs() < 1e-9, "{:?}", on[1]);
    assert!((nose.quantity(2, &moving, &[]) - ratio * spin).abs() < 1e-9 && (nose.quantity(1, &moving, &[]) - spin).abs() < 1e-12);
    assert!((nose.supplied_power(&moving, &[]) - ratio * torque * spin).abs() < 1e-8);
    // The block's brake turns as fast as the axle, and its friction acts at the tread's radius.
    let block = element("block", "kind = \"brake\"\ntype = \"tread\"\nblock_force = 0\nfriction = 0.3\nstiffness = 1e6");
    let deflected = [1e-4];
    let (on, _) = apply_under(block.as_ref(), &bodies, &deflected, &[1e5]);
    let (sliding, held) = (block.quantity(1, &under(&bodies, &[1e5]), &deflected), block.quantity(0, &under(&bodies, &[1e5]), &deflected));
    assert!((sliding - spin).abs() < 1e-12 && held < 0.0, "{sliding} {held}");
    assert!((on[1].moment.y - held).abs() < 1e-6 * held.abs(), "{} {held}", on[1].moment.y);
}

/// Driven from rest, an axle with the rotor behind an elastic drive swings about the motion with the inertia I + i^2 J: after whole periods of
/// sqrt(k (1/I + 1/(i^2 J))) its speed is i M t / (I + i^2 J), and the carrier has been turned by what the rotor's own momentum leaves.
#[test]
fn analytic_rotor_inertia_is_felt_through_the_square_of_the_ratio() {
    let (axial, ratio, inertia, k, torque): (f64, f64, f64, f64, f64) = (120.0, 4.5, 9.0, 2e6, 500.0);
    let rotor = ratio * ratio * inertia;
    let period = 2.0 * PI / (k * (1.0 / axial + 1.0 / rotor)).sqrt();
    let time = 5.0 * period;
    for (sense, mount) in [("opposite", "shaft"), ("same", "shaft"), ("opposite", "nose"), ("same", "nose")] {
        let settings = format!(
            "kind = \"motor_gear\"\nmount = \"{mount}\"\ngear = \"{sense}\"\nratio = {ratio}\nrotor_inertia = {inertia}\nstiffness = {k}"
        );
        let held = element("nose", "kind = \"bushing\"\nstiffness = [1e11, 1e11, 1e11]");
        let mut mechanism = on_a_rock(element("nose", &settings), axial);
        mechanism.system.forces.push(held);
        let mut mechanism = Mechanism::of(mechanism.system);
        mechanism.workspace.inputs[0] = torque;
        let start = mechanism.state(&stage().design(), &[0.0; 12]);
        let end = mechanism.run(&start, time, 1e-11);
        let expected = ratio * torque * time / (axial + rotor);
        println!("{mount}, {sense}: {:.6} rad/s, formula {expected:.6} rad/s", end[23]);
        assert!((end[23] / expected - 1.0).abs() < 5e-4, "{mount} {sense}: {} {expected}", end[23]);
        let energy = mechanism.energy(&end);
        assert!(energy.abs() < 1e-6 * torque * ratio * expected * time, "what the motor brought in is there: {energy}");
    }
    // A drive without stiffness known is none: the rotor is at the axle's speed from the start.
    let drive = element("nose", "kind = \"motor_gear\"\nmount = \"shaft\"\nratio = 4.5\nrotor_inertia = 9\nstiffness = 2e6\ndamping = 1e3");
    let mut state = [0.3, 0.3];
    drive.settle(&(&standing(87.0)[..]).into(), &mut state);
    let (on, rates) = apply_under(drive.as_ref(), &standing(87.0), &state, &[0.0]);
    assert!(state[0] == 0.0 && rates.iter().all(|rate| rate.abs() < 1e-9) && on[1].moment.norm() < 1e-6, "{state:?} {rates:?} {on:?}");
}

/// Rotor and carrier alone: turned about the vertical, the spinning rotor asks for J p W about the track.
#[test]
fn analytic_a_turned_rotor_loads_its_carrier() {
    let drive = element("nose", "kind = \"motor_gear\"\nmount = \"shaft\"\nratio = 4\nrotor_inertia = 10\nstiffness = 2e6");
    let (spin, turn) = (50.0, 0.2);
    let mut bodies = standing(spin);
    let mut state = [0.0; 2];
    drive.settle(&(&bodies[..]).into(), &mut state);
    bodies[0] = BodyMotion::general(&stage().design()[..6], &[0.0, 0.0, 0.0, turn, 0.0, 0.0]);
    let (on, _) = apply_under(drive.as_ref(), &bodies, &state, &[0.0]);
    // p = -4 x 50 rad/s about y; -J p W z x y = J p W x.
    assert!((on[0].moment.x - 10.0 * -200.0 * turn).abs() < 1e-9, "{}", on[0].moment);
}

/// M brakes an axle of the inertia I to rest in I w / M, within the time in which the brake takes hold; what it had is heat.
#[test]
fn analytic_a_brake_stops_an_axle_and_holds_it() {
    let (axial, spin, most): (f64, f64, f64) = (120.0, 40.0, 6e3);
    let cases = [
        ("nose", "type = \"disc\"\nstiffness = 3e6".to_string(), most),
        ("nose", "type = \"disc\"\nfriction = 0.35\nradius = 0.25\nstiffness = 3e6".into(), most / (0.35 * 0.25)),
        ("block", "type = \"tread\"\nfriction = 0.25\nstiffness = 3e6".into(), most / (0.25 * RADIUS)),
    ];
    for (from, settings, input) in cases {
        let brake = element(from, &format!("kind = \"brake\"\n{settings}"));
        let tread = from == "block";
        let mut mechanism = on_a_rock(brake.clone_box(), axial);
        mechanism.workspace.inputs[0] = input;
        let mut v = [0.0; 12];
        v[11] = spin;
        let start = mechanism.state(&stage().design(), &v);
        if tread {
            // The block pushes the axle away, which nothing holds here: the force alone.
            let (on, _) = apply_under(brake.as_ref(), &standing(spin), &[most / 3e6], &[input]);
            assert!((on[1].moment.y + most).abs() < 1e-6 && (on[1].force.x - input).abs() < 1e-6, "{:?}", on[1]);
            assert!((on[1].force.z.abs() - most / RADIUS).abs() < 1e-6 && (on[0].force + on[1].force).norm() < 1e-9);
            continue;
        }
        let time = axial * spin / most;
        let before = mechanism.run(&start, 0.9 * time, 1e-9);
        assert!((before[23] / spin - 0.1).abs() < 0.01, "{}", before[23]);
        // What is left of its motion is the integration's error.
        let late = mechanism.run(&start, time + 2.0, 1e-11);
        let later = mechanism.run(&start, time + 6.0, 1e-11);
        println!("stops after {time:.2} s; at rest {:.1e} rad/s, turned by {:.1e} rad in 4 s", later[23], later[11] - late[11]);
        assert!(later[23].abs() < 1e-6 && (later[11] - late[11]).abs() < 1e-9);
        let energy = mechanism.energy(&start);
        assert!((mechanism.energy(&later) / energy - 1.0).abs() < 1e-6);
    }
}

/// A hanging load below the brake's torque is held without creep at any step; above a share of it, it goes.
#[test]
fn hard_a_brake_holds_without_creep_in_vibration() {
    let brake = element("nose", "kind = \"brake\"\ntype = \"disc\"\nstiffness = 1e6\ndamping_time = 0");
    let grip = |angle: f64, speed: f64, most: f64| apply_under(brake.as_ref(), &standing(speed), &[angle], &[most]).1[0];
    // Half of the torque in use, and any small motion: the deflection follows all of it, both ways.
    for speed in [1e-3, -1e-3, 1e-12, -1e-12] {
        assert_eq!(grip(3e-3, speed, 6e3), speed);
    }
    // Released, it lets go and hands on no motion; nothing is torn at the change of sign.
    assert!(grip(0.0, 80.0, 0.0) == 0.0 && grip(-1e-12, 80.0, 0.0).abs() < 1e-9 && grip(1e-3, 80.0, 0.0) == -0.5);
    // At speed the whole torque, and no rate faster than seven of the relaxation time's.
    assert!(grip(6e-3, 80.0, 6e3).abs() < 1e-12);
    let slope = (grip(6e-3 - 1e-9, 80.0, 6e3) - grip(6e-3 - 2e-9, 80.0, 6e3)) / 1e-9;
    assert!(slope < 0.0 && slope > -7.0 / 2e-3, "{slope}");
}

#[test]
fn prop_wrong_settings_of_motors_and_brakes_are_refused() {
    let cases = [
        ("kind = \"motor_gear\"\nmount = \"nose\"\nratio = 4\nfrom = \"above\"", "along the track"),
        ("kind = \"motor_gear\"\nmount = \"shaft\"\nratio = 4\nfrom = \"nose\"\nstiffness = 1e6", "rotor_inertia"),
        ("kind = \"motor_gear\"\nmount = \"shaft\"\nratio = 4\nfrom = \"world\"", "world"),
        ("kind = \"brake\"\ntype = \"tread\"\nfriction = 0.2\nstiffness = 1e6\nfrom = \"middle\"", "tread"),
        ("kind = \"brake\"\ntype = \"disc\"\nfriction = 0.2\nstiffness = 1e6\nfrom = \"nose\"", "radius"),
        ("kind = \"brake\"\ntype = \"disc\"\nstiffness = 1e6\ntorque = -1\nfrom = \"nose\"", "torque"),
    ];
    let mut stage = stage();
    stage.places.extend([
        ("above", Some(0), Vector3::new(0.01, 0.0, 1.0)),
        ("middle", Some(0), Vector3::new(0.0, 0.5, 0.5)),
        ("world", None, Vector3::zeros()),
    ]);
    for (settings, word) in cases {
        let error = stage.read(&format!("name = \"e\"\nto = \"axle\"\n{settings}")).unwrap_err().to_string();
        assert!(error.contains(word), "{settings}: {error}");
    }
}
