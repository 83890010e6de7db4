//! The linearised system: each element's changes and the whole J against differences, the solution against a dense one, cost.

use super::properties::{stage, walk};
use super::stage::brick;
use crate::counting;
use nalgebra::{DMatrix, DVector, Matrix6, Vector3, Vector6};
use wheelrail::mbs::body::{Body, COORDINATES};
use wheelrail::mbs::force::{Attachment, Bushing, ForceElement, Guide, GuidedSpring};
use wheelrail::mbs::inertia::Inertia;
use wheelrail::mbs::joint::{Joint, Place, revolute};
use wheelrail::mbs::kkt::RowBodies;
use wheelrail::mbs::system::{System, SystemWorkspace};
use wheelrail::mbs::tangent::{StateCoupling, Tangent, WrenchTangent};
use wheelrail::scene::{assemble, load};
use wheelrail::settings::Source;
use wheelrail::sim::Simulation;

pub fn wheelset(mass: f64, transverse: f64, axial: f64) -> Body {
    Body { name: "wheelset".into(), mass, inertia: Inertia::Revolution { transverse, axial } }
}

/// Reproducible numbers in (-1, 1).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// J without constraints.
pub fn dense(tangent: &Tangent, dimension: usize) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(dimension, dimension);
    let (mut unit, mut column) = (vec![0.0; dimension], vec![0.0; dimension]);
    for j in 0..dimension {
        unit[j] = 1.0;
        tangent.times(&unit, &mut column);
        matrix.column_mut(j).copy_from_slice(&column);
        unit[j] = 0.0;
    }
    matrix
}

/// J of the system's force elements at `y`, whose motions are in the workspace then.
pub fn linearise(system: &System, workspace: &mut SystemWorkspace, y: &[f64], tangent: &mut Tangent) {
    system.apply_forces(y, workspace);
    tangent.clear();
    tangent.add_forces(system, workspace, y);
    tangent.finish(system, workspace);
}

/// Generalised forces and rates of states: M times accelerations without the inertia's own terms.
fn forces(system: &System, workspace: &mut SystemWorkspace, y: &[f64]) -> Vec<f64> {
    system.apply_forces(y, workspace);
    let loads = workspace.motions.iter().zip(&workspace.wrenches).take(system.bodies.len());
    let mut all: Vec<f64> = loads.flat_map(|(motion, wrench)| <[f64; 6]>::from(motion.generalised_force(wrench))).collect();
    all.extend(&workspace.force_rates);
    all
}

/// dQ and d(rates) of a system (rows) by its state (columns): its own and central differences.
pub fn changes(system: &System, y: &[f64], inputs: &[f64]) -> [DMatrix<f64>; 2] {
    let mut workspace = system.workspace(&[]);
    workspace.inputs.copy_from_slice(inputs);
    let mut tangent = Tangent::new(system, &[], 0);
    linearise(system, &mut workspace, y, &mut tangent);
    let n = COORDINATES * system.bodies.len();
    let mut own = dense(&tangent, y.len());
    // What the inertia adds by itself.
    tangent.clear();
    tangent.finish(system, &workspace);
    own -= dense(&tangent, y.len());
    let mut own = own.rows(n, y.len() - n).into_owned();
    for (body, data) in system.bodies.iter().enumerate() {
        let mass = data.mobility(&workspace.motions[body]).try_inverse().unwrap();
        let block = mass * own.rows(6 * body, 6);
        own.rows_mut(6 * body, 6).copy_from(&block);
    }
    let mut differences = DMatrix::zeros(own.nrows(), own.ncols());
    let mut moved = y.to_vec();
    for j in 0..y.len() {
        let h = if j < n { 1e-6 } else { 1e-5 };
        moved[j] = y[j] + h;
        let ahead = forces(system, &mut workspace, &moved);
        moved[j] = y[j] - h;
        let behind = forces(system, &mut workspace, &moved);
        moved[j] = y[j];
        for (i, (ahead, behind)) in ahead.iter().zip(&behind).enumerate() {
            differences[(i, j)] = (ahead - behind) / (2.0 * h);
        }
    }
    [own, differences]
}

/// Largest error of forces (rows below n) or rates, relative to the largest change of each row, or 1e-3 of all of them.
pub fn worst(system: &System, [own, differences]: &[DMatrix<f64>; 2], columns: std::ops::Range<usize>) -> f64 {
    let n = COORDINATES * system.bodies.len();
    let mut worst: f64 = 0.0;
    for rows in [0..n, n..own.nrows()] {
        let largest =
            differences.rows_range(rows.clone()).columns_range(columns.clone()).iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        for i in rows {
            let (a, b) =
                (own.row(i).columns_range(columns.clone()).into_owned(), differences.row(i).columns_range(columns.clone()).into_owned());
            let error = (a - &b).iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let scale = b.iter().fold(1e-3 * largest, |most: f64, x| most.max(x.abs()));
            worst = worst.max(if error == 0.0 { 0.0 } else { error / scale });
        }
    }
    worst
}

/// What fades for ever (a brake that was let go) never leaves the range of numbers: squares of 1e-160 are 0, and 0 / 0 is no number.
#[test]
fn prop_forces_and_changes_stay_numbers_as_states_fade() {
    let stage = stage(1.0);
    walk(&stage, |element, case| {
        let bodies = vec![brick(900.0, 300.0, 500.0, 700.0), brick(1500.0, 300.0, 500.0, 700.0)];
        let system =
            System { bodies, forces: vec![element.clone_box()], drives: vec![], supported: vec![], joints: vec![], redundant: vec![] };
        let (mut workspace, mut tangent) = (system.workspace(&[]), Tangent::new(&system, &[], 0));
        for decade in (0..=330).step_by(10) {
            let faded = |x: &f64| x * 10f64.powi(-(decade / 2)) * 10f64.powi(-(decade - decade / 2));
            for inputs in [case.inputs.clone(), case.inputs.iter().map(faded).collect(), vec![0.0; case.inputs.len()]] {
                workspace.inputs.copy_from_slice(&inputs);
                let y = [case.coordinates(&stage), case.v.clone(), case.state.iter().map(faded).collect()].concat();
                let found = forces(&system, &mut workspace, &y);
                linearise(&system, &mut workspace, &y, &mut tangent);
                let changes = dense(&tangent, y.len());
                assert!(found.iter().chain(changes.iter()).all(|x| x.is_finite()), "1e-{decade}, {inputs:?}: {element:?} {case:?}");
            }
        }
    });
}

/// Random poses and states of two bodies, general or of revolution, either of them first: by displacements at rest; by velocities and
/// states in motion. In motion the changes by displacements lack angular velocity times damping, and velocity times damping.
#[test]
fn analytic_changes_of_every_element_match_differences() {
    let pair = || [brick(900.0, 300.0, 500.0, 700.0), wheelset(1500.0, 800.0, 120.0)];
    let (mut at_rest, mut moving, mut left_out): (f64, f64, f64) = (0.0, 0.0, 0.0);
    for (mirror, kinds) in [(1.0, [0, 0]), (-1.0, [0, 1]), (1.0, [1, 0]), (1.0, [1, 1])] {
        let stage = stage(mirror);
        walk(&stage, |element, case| {
            // What turns an axle is carried by a body that does not spin.
            if element.turns_axle() && kinds[0] == 1 {
                return;
            }
            let bodies = kinds.map(|kind| pair()[kind].clone()).to_vec();
            let system =
                System { bodies, forces: vec![element.clone_box()], drives: vec![], supported: vec![], joints: vec![], redundant: vec![] };
            let q = case.coordinates(&stage);
            let still = changes(&system, &[q.clone(), vec![0.0; q.len()], case.state.clone()].concat(), &case.inputs);
            let error = worst(&system, &still, 0..q.len());
            assert!(error < 1e-5, "{kinds:?} at rest: {error:.1e}, {element:?} {case:?}");
            at_rest = at_rest.max(error);
            let found = changes(&system, &[q.clone(), case.v.clone(), case.state.clone()].concat(), &case.inputs);
            let error = worst(&system, &found, q.len()..found[0].ncols());
            assert!(error < 1e-5, "{kinds:?} in motion: {error:.1e}, {element:?} {case:?}");
            moving = moving.max(error);
            let [own, differences] = &found;
            for rows in [0..q.len(), q.len()..own.nrows()].into_iter().filter(|rows| !rows.is_empty()) {
                let part = |matrix: &DMatrix<f64>, columns| {
                    matrix.rows_range(rows.clone()).columns_range::<std::ops::Range<usize>>(columns).amax()
                };
                let error = part(&(own - differences), 0..q.len());
                let damping = part(differences, q.len()..2 * q.len());
                left_out = left_out.max(if error == 0.0 { 0.0 } else { error / (damping + 1e-5 * part(differences, 0..q.len()) + 1e-3) });
            }
        });
    }
    println!("relative error by displacements at rest {at_rest:.1e}, by velocities and states {moving:.1e}");
    println!("left out in motion at 1 rad/s and 1 m/s: {left_out:.2} times the largest damping");
    assert!(left_out < 8.0, "{left_out}");
}

#[test]
fn analytic_changes_of_a_guided_spring_match_differences() {
    let guide = Some(Guide { stiffness: 2e5, damping: 4e3 });
    let spring = |longitudinal, lateral| GuidedSpring { name: "e".into(), body: 0, distance: 2.0, longitudinal, lateral };
    let y = [3.0, 0.01, 0.46, 0.04, -0.02, 30.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    for (longitudinal, lateral) in [(guide, None), (None, guide)] {
        let forces: Vec<Box<dyn ForceElement>> = vec![Box::new(spring(longitudinal, lateral))];
        let system = System {
            bodies: vec![wheelset(1500.0, 800.0, 120.0)],
            forces,
            drives: vec![],
            supported: vec![],
            joints: vec![],
            redundant: vec![],
        };
        let error = worst(&system, &changes(&system, &y, &[]), 0..12);
        assert!(error < 1e-6, "{longitudinal:?}, {lateral:?}: {error:.1e}");
    }
}

/// A spinning axle: accelerations by rates of the angles at constant moments, and contacts' angular velocity that turns with it.
#[test]
fn analytic_spin_is_in_the_changes() {
    let bodies = vec![wheelset(1500.0, 800.0, 120.0)];
    let system = System { bodies, forces: vec![], drives: vec![], supported: vec![], joints: vec![], redundant: vec![] };
    let mut workspace = system.workspace(&[]);
    let y = [0.0, 0.0, 0.46, 0.03, -0.05, 7.0, 20.0, 0.1, 0.0, 0.4, -0.3, 43.0];
    // A force and moment that follow displacement, rotation, velocity and angular velocity in the world.
    let mut random = Random(3);
    let matrix = |random: &mut Random, size: f64| Matrix6::from_fn(|_, _| size * random.next());
    let tangent_of_wrench = WrenchTangent { by_position: Matrix6::zeros(), by_velocity: matrix(&mut random, 1e4) };
    let by_velocity = tangent_of_wrench.by_velocity;
    let mut accelerations = |y: &[f64]| {
        system.move_bodies(y, &mut workspace);
        let motion = &workspace.motions[0];
        let moving = Vector6::from_iterator(motion.velocity.iter().chain(motion.rotation.iter()).copied());
        let load = by_velocity * moving;
        let wrench =
            wheelrail::mbs::body::Wrench { force: load.fixed_rows::<3>(0).into_owned(), moment: load.fixed_rows::<3>(3).into_owned() };
        // What the projection of the wrench changes by is left out in contacts: divide it out.
        (motion.generalised_force(&wrench), Vector6::from(system.bodies[0].accelerations(motion, &wrench)))
    };
    let mut tangent = Tangent::new(&system, &[], 0);
    tangent.clear();
    tangent.add_wrench(0, 0, &tangent_of_wrench);
    let (_, now) = accelerations(&y);
    assert!(now.norm() > 0.0);
    let mut own_workspace = system.workspace(&[]);
    system.move_bodies(&y, &mut own_workspace);
    tangent.finish(&system, &own_workspace);
    let own = dense(&tangent, 12);
    let h = 1e-5;
    for j in 6..12 {
        let (mut ahead, mut behind) = (y, y);
        ahead[j] += h;
        behind[j] -= h;
        let difference = (accelerations(&ahead).1 - accelerations(&behind).1) / (2.0 * h);
        let error = (own.view((6, j), (6, 1)) - difference).norm();
        assert!(error < 1e-6 * difference.norm().max(1.0), "{j}: {error:.1e}");
    }
    // Yaw turns the spin of 43 rad/s into a roll velocity; compare the wrench itself, whose projection is left out.
    for j in [3, 4] {
        let mut moved = |step: f64| {
            let mut y = y;
            y[j] += step;
            system.move_bodies(&y, &mut own_workspace);
            let motion = own_workspace.motions[0];
            by_velocity * Vector6::from_iterator(motion.velocity.iter().chain(motion.rotation.iter()).copied())
        };
        let wrench = (moved(h) - moved(-h)) / (2.0 * h);
        let _ = moved(0.0);
        let motion = &own_workspace.motions[0];
        let split =
            wheelrail::mbs::body::Wrench { force: wrench.fixed_rows::<3>(0).into_owned(), moment: wrench.fixed_rows::<3>(3).into_owned() };
        let expected = system.bodies[0].mobility(motion) * motion.generalised_force(&split);
        let error = (own.view((6, j), (6, 1)) - expected).norm();
        assert!(expected.norm() > 1.0 && error < 1e-6 * expected.norm(), "{j}: {error:.1e} of {:.1e}", expected.norm());
    }
}

fn coaches(count: usize) -> System {
    let embedded = wheelrail::scene::embedded::find("vehicle_manchester_1").unwrap().text;
    let mut places = String::from("[vehicle.module.coach]\ntemplate = \"vehicle_manchester_1\"\n");
    for coach in 1..=count {
        let x = -26.0 * (coach - 1) as f64;
        places += &format!("[[vehicle.place]]\nname = \"coach[{coach}]\"\nmodule = \"coach\"\nposition = [{x:?}, 0, 0]\n");
        if coach < count {
            let ends =
                [(coach, x - 12.5), (coach + 1, x - 13.5)].map(|(c, x)| format!("{{ body = \"coach[{c}].car\", at = [{x:?}, 0, 1] }}"));
            places += &format!(
                "[[vehicle.force]]\nname = \"coupler[{coach}]\"\nkind = \"coupler\"\nfrom = {}\nto = {}\ndraw_stiffness = 5e6\nbuffer_stiffness = 1e7\n",
                ends[0], ends[1]
            );
        }
    }
    let text = embedded.replace("template = \"vehicle_manchester_1\"", "template = \"free\"").replacen(
        "\n[track]\n",
        &format!("\n{places}\n[track]\n"),
        1,
    );
    let source = Source { file: "train.toml".into(), text, overridden: vec![], folder: None };
    let scene = load::read("train", source, &[]).unwrap_or_else(|error| panic!("{error}"));
    assemble::model(&scene).unwrap_or_else(|error| panic!("{error}")).system
}

/// Standing in the steady state of its scene, with small deviations.
fn manchester() -> (Simulation, Vec<f64>) {
    let scene = load::open("vehicle_manchester_1", &[]).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = Simulation::new(&scene, 0.0).unwrap_or_else(|error| panic!("{error}"));
    let mut y = simulation.snapshot().unwrap().y.clone();
    y.truncate(simulation.model().system.dimension());
    (simulation, y)
}

/// The whole J of the Manchester coach without contacts, whose sum of moments is not zero then: 1e-4 of each row bounds what J
/// leaves out.
#[test]
fn analytic_j_of_the_manchester_coach_matches_differences() {
    let (simulation, y) = manchester();
    let system = &simulation.model().system;
    let mut workspace = system.workspace(&[]);
    let mut tangent = Tangent::new(system, &[], 0);
    linearise(system, &mut workspace, &y, &mut tangent);
    let own = dense(&tangent, y.len());
    let h = 1e-6;
    let mut worst: f64 = 0.0;
    let (mut moved, mut ahead, mut behind) = (y.clone(), vec![0.0; y.len()], vec![0.0; y.len()]);
    let mut differences = DMatrix::zeros(y.len(), y.len());
    for j in 0..y.len() {
        moved[j] = y[j] + h;
        system.apply_forces(&moved, &mut workspace);
        system.derivative(&moved, &mut workspace, &mut ahead);
        moved[j] = y[j] - h;
        system.apply_forces(&moved, &mut workspace);
        system.derivative(&moved, &mut workspace, &mut behind);
        moved[j] = y[j];
        for i in 0..y.len() {
            differences[(i, j)] = (ahead[i] - behind[i]) / (2.0 * h);
        }
    }
    for i in 0..y.len() {
        let error = (own.row(i) - differences.row(i)).amax();
        let scale = differences.row(i).amax();
        worst = worst.max(if error == 0.0 { 0.0 } else { error / scale.max(1.0) });
    }
    println!("{} states: worst row {worst:.1e}", y.len());
    assert!(worst < 1e-4, "{worst:.1e}");
}

/// Hinged bodies in a row with springs between them, fixed at one end; the last hinge may close a loop.
fn mechanism(links: usize, closed: bool) -> (System, Vec<f64>) {
    let bodies: Vec<Body> = (0..links).map(|_| brick(1.0, 0.01, 0.02, 0.03)).collect();
    let hinge = |x: f64| Place::along(Vector3::new(x, 0.0, 0.0), &Vector3::y());
    let mut joints: Vec<Joint> = Vec::new();
    let mut forces: Vec<Box<dyn ForceElement>> = Vec::new();
    let mut random = Random(5);
    for k in 0..links {
        let bodies = RowBodies { first: k, second: k.checked_sub(1) };
        joints.push(revolute(&format!("{k}"), bodies, &hinge(-0.1), &hinge(if k == 0 { 0.0 } else { 0.1 })));
        let from = Attachment { body: k.checked_sub(1), local: Vector3::new(0.02, 0.1, 0.0) };
        forces.push(Box::new(Bushing {
            name: "e".into(),
            from,
            to: Attachment::on(k, Vector3::new(-0.05, 0.0, 0.1)),
            design_vector: Vector3::zeros(),
            preload: Vector3::new(10.0, 20.0, -5.0),
            balanced: false,
            stiffness: Vector3::from_fn(|_, _| 1e3 * (1.5 + random.next())),
            damping: Vector3::from_fn(|_, _| 10.0 * (1.5 + random.next())),
            rotational_stiffness: Vector3::from_fn(|_, _| 10.0 * (1.5 + random.next())),
            rotational_damping: Vector3::from_fn(|_, _| 1.5 + random.next()),
        }));
    }
    if closed {
        joints.push(revolute("last", RowBodies { first: links - 1, second: None }, &hinge(0.1), &hinge(0.2)));
    }
    // A closed loop of parallel hinges repeats three demands.
    let rows = 5 * links;
    let redundant = if closed { vec![rows + 1, rows + 3, rows + 4] } else { vec![] };
    // Folded flat in pairs, a little open: links at x = 0.1, 0.1, 0.1 ...
    let mut y = Vec::new();
    let (mut x, mut z) = (0.0, 0.0);
    for k in 0..links {
        let angle: f64 = 0.3 + 0.7 * k as f64;
        (x, z) = (x + 0.1 * angle.cos(), z - 0.1 * angle.sin());
        y.extend([x, 0.0, z, 0.0, 0.0, angle]);
        (x, z) = (x + 0.1 * angle.cos(), z - 0.1 * angle.sin());
    }
    y.resize(2 * y.len(), 0.0);
    (System { bodies, forces, drives: vec![], supported: vec![], joints, redundant }, y)
}

/// The solution against one of the whole dense matrix: constraints project J's rows of accelerations.
fn worst_solution(system: &System, y: &[f64], contact_bodies: &[usize], random: &mut Random) -> f64 {
    let mut workspace = system.workspace(contact_bodies);
    let mut tangent = Tangent::new(system, contact_bodies, 2);
    system.apply_forces(y, &mut workspace);
    system.prepare_constraints(0.0, &mut workspace);
    let kkt = &mut workspace.constraints.kkt;
    let joint_rows = kkt.rows() - contact_bodies.len();
    for row in joint_rows..kkt.rows() {
        kkt.set_row(row, &Vector6::from_fn(|_, _| random.next()), &Vector6::zeros());
        kkt.set_active(row, (row - joint_rows) % 3 != 1);
    }
    kkt.factorise().unwrap();
    // Something like a contact with two states behind the others.
    let damping = Matrix6::from_fn(|_, _| random.next());
    let wrench = WrenchTangent { by_position: -damping * damping.transpose() * 1e4, by_velocity: -damping.transpose() * damping * 10.0 };
    let mut vector = || Vector6::from_fn(|_, _| random.next());
    let couplings =
        [0, 1].map(|_| StateCoupling { body: 0, rate_by_position: vector(), rate_by_velocity: vector(), wrench_by_state: vector() * 10.0 });
    let sum = |tangent: &mut Tangent, workspace: &SystemWorkspace| {
        tangent.clear();
        tangent.add_forces(system, workspace, y);
        tangent.add_wrench(0, 0, &wrench);
        for (state, coupling) in couplings.iter().enumerate() {
            tangent.add_state(y.len() + state, -50.0, std::slice::from_ref(coupling));
        }
        tangent.finish(system, workspace);
    };
    sum(&mut tangent, &workspace);
    let dimension = y.len() + 2;
    let n = COORDINATES * system.bodies.len();
    let mut j = dense(&tangent, dimension);
    let kkt = &workspace.constraints.kkt;
    let active: Vec<usize> = (0..kkt.rows()).filter(|row| kkt.is_active(*row)).collect();
    if !active.is_empty() {
        let mut g = DMatrix::zeros(active.len(), n);
        let mut weighted = DMatrix::zeros(n, active.len());
        for (i, row) in active.iter().enumerate() {
            let (bodies, first, second) = kkt.row(*row);
            for (body, own) in std::iter::once((bodies.first, first)).chain(bodies.second.map(|body| (body, second))) {
                let at = COORDINATES * body;
                let mut part = g.view_mut((i, at), (1, 6));
                part += own.transpose();
                let mut part = weighted.view_mut((at, i), (6, 1));
                part += kkt.mobility(body) * own;
            }
        }
        let inverse = (&g * &weighted).try_inverse().unwrap();
        let projection = DMatrix::identity(n, n) - weighted * inverse * g;
        let projected = projection * j.rows(n, n);
        j.rows_mut(n, n).copy_from(&projected);
    }
    let mut worst: f64 = 0.0;
    for a in [1e-4, 3e-3, 0.1] {
        tangent.factorise(a, &workspace).unwrap();
        let right = DVector::from_fn(dimension, |_, _| random.next());
        let expected = (DMatrix::identity(dimension, dimension) - &j * a).lu().solve(&right).unwrap();
        let mut found = right.as_slice().to_vec();
        let before = counting::count();
        sum(&mut tangent, &workspace);
        tangent.factorise(a, &workspace).unwrap();
        tangent.solve(&mut found);
        assert_eq!(counting::count(), before, "it allocates");
        worst = worst.max((DVector::from_vec(found) - &expected).amax() / expected.amax());
    }
    worst
}

#[test]
fn equiv_block_elimination_solves_like_a_dense_matrix() {
    let mut random = Random(11);
    let coach = coaches(1);
    let train = coaches(3);
    let standing = |system: &System, random: &mut Random| {
        let mut y = vec![0.0; system.dimension()];
        let n = COORDINATES * system.bodies.len();
        // Away from each other, so that no line has zero length.
        y[..n].iter_mut().for_each(|q| *q = 0.02 * random.next());
        y[n..].iter_mut().for_each(|v| *v = 0.01 * random.next());
        y
    };
    let (chain, chain_y) = mechanism(8, false);
    let (loops, loops_y) = mechanism(3, true);
    let (coach_y, train_y) = (standing(&coach, &mut random), standing(&train, &mut random));
    let cases: [(&str, &System, &[f64], &[usize]); 6] = [
        ("coach", &coach, &coach_y, &[]),
        ("coach with contact rows", &coach, &coach_y, &[3, 3, 4, 4, 5, 5]),
        ("train", &train, &train_y, &[]),
        ("chain", &chain, &chain_y, &[]),
        ("chain with contact rows", &chain, &chain_y, &[7, 7]),
        ("closed loop", &loops, &loops_y, &[]),
    ];
    for (name, system, y, contact_bodies) in cases {
        let error = worst_solution(system, y, contact_bodies, &mut random);
        println!("{name}: {} unknowns, off by {error:.1e}", y.len());
        assert!(error < 1e-10, "{name}: {error:.1e}");
    }
}

/// Blocks and products per coach do not grow with the train.
#[test]
fn regress_cost_is_linear_along_a_train() {
    let costs: Vec<(usize, usize)> = [1, 2, 4, 8, 16].map(|count| Tangent::new(&coaches(count), &[], 0).cost()).to_vec();
    println!("blocks and products for 1, 2, 4, 8, 16 coaches: {costs:?}");
    // 7 bodies and 6 joined pairs each way per coach, one pair more per coupler; no fill.
    for (count, cost) in [1, 2, 4, 8, 16].into_iter().zip(&costs) {
        assert_eq!(cost.0, 7 * count + 12 * count + 2 * (count - 1));
        assert!(cost.1 <= costs[0].1 * count + 3 * (count - 1));
    }
}
