//! Rails as beams on sleepers (`track.flexibility = "beam"`): sag, ripple of the sleepers, energy, and runs against a second program made of finite elements.

use crate::common::{self, column, read, start, straight, table};
use nalgebra::{Cholesky, Complex, DMatrix, DVector};
use std::f64::consts::TAU;
use wheelrail::formulation::flexibility::Flexibility;
use wheelrail::formulation::rail_beam::RailBeam;
use wheelrail::scene::load;

const BEAM: &str = "track.flexibility=beam";
const EXACT: [&str; 2] = ["solver.integrator=rosenbrock", "solver.tolerance=1e-8"];
/// Static wheel load, N, and half the wheelset, kg.
const LOAD: f64 = 0.5 * (1568.0 * 9.81 + 98000.0);
const UNSPRUNG: f64 = 784.0;

const SPEED: &str = "vehicle.speed=20";

fn run(changes: &[&str], stop: f64) -> Vec<f64> {
    column(&common::run(&straight(&[&[BEAM, SPEED][..], changes].concat()), stop, 1e-4), "left.verticalForce")
}

/// Fourier's amplitude of a frequency, N.
fn amplitude(values: &[f64], step: f64, frequency: f64) -> Complex<f64> {
    let turn = |n: usize| Complex::from_polar(1.0, -TAU * frequency * step * n as f64);
    values.iter().enumerate().map(|(n, value)| turn(n) * *value).sum::<Complex<f64>>() * (2.0 / values.len() as f64)
}

#[test]
fn analytic_a_start_is_settled_and_sleepers_are_felt() {
    for formulation in ["ECF-A", "ECF-N"] {
        let scene = straight(&[BEAM, SPEED, &format!("contact.formulation={formulation}"), EXACT[0], "solver.tolerance=1e-7"]);
        let mut simulation = start(&scene);
        let outputs = table(&simulation, &scene);
        let begin = read(&mut simulation, &outputs);
        let Some(Flexibility::Beam(beam)) = scene.track.flexibility else { panic!() };
        let rails = beam.lay(&[0.0], 20.0);
        let (sunk, mean) = (begin["left.railVerticalDeflection"], -LOAD * rails.ring.mean_compliance(0.0, 20.0));
        println!("{formulation}: Q {:.1} N, sunk by {:.4} mm, on the mean {:.4} mm", begin["left.verticalForce"], -1e3 * sunk, -1e3 * mean);
        assert!((sunk / mean - 1.0).abs() < 0.03 && (begin["left.verticalForce"] / LOAD - 1.0).abs() < 0.05);
        // 20 m/s over 0.6 m: the ripple of Q is there from the start, and does not change.
        let force = column(&common::run(&scene, 0.6, 1e-4), "left.verticalForce");
        let nine = |from: f64| amplitude(&force[(from * 1e4) as usize..][..2700], 1e-4, 20.0 / 0.6);
        let (early, late) = (nine(0.03), nine(0.30));
        let mean = force[3000..5700].iter().sum::<f64>() / 2700.0;
        println!(
            "ripple at V / L {:.1} N, later {:.1} N, changed by {:.1} N; mean {mean:.1} N",
            early.norm(),
            late.norm(),
            (early - late).norm()
        );
        assert!((early - late).norm() < 0.05 * late.norm() && late.norm() > 0.005 * LOAD);
        assert!((mean / LOAD - 1.0).abs() < 1e-4);
    }
}

/// The ring comes round without a seam, and sleepers are all alike.
#[test]
fn equiv_starts_that_differ_by_whole_bays() {
    let at = |distance: f64| run(&[EXACT[0], "solver.tolerance=1e-7", &format!("vehicle.initial.distance={distance}")], 0.1);
    let first = at(102.0);
    let scene = load::open("suspended_wheelset", &[BEAM.to_string()]).unwrap();
    let length = start(&scene).model().beam.as_ref().unwrap().ring.length();
    // Other bays have the same waves in other coordinates, so that steps are others.
    for (other, bound) in [(102.0 + length, 0.05), (102.6, 20.0), (102.0 + 0.6 * 1001.0, 20.0)] {
        let off = common::largest_difference(&first, &at(other));
        println!("{other} m: {off:.1e} N");
        assert!(off < bound, "{other}: {off}");
    }
    let between = common::largest_difference(&first, &at(102.3));
    assert!(between > 500.0, "a start between sleepers is another one: {between}");
}

/// Soft pads damp little: what a flat sends along the rails comes round a ring of 24 m and strikes the wheel again. The ring is as long as that needs.
#[test]
fn equiv_no_wave_comes_round() {
    let under = |bays: &str| {
        let flexibility = format!("track.flexibility={{model=\"beam\", pad_stiffness=60e6, pad_damping=2e3{bays}}}");
        let flat = "vehicle.wheelset.out_of_round=[{kind=\"flat\", length=0.04, depth=8e-5, at=3.5}]";
        run(&[&flexibility, flat, "vehicle.speed=43", EXACT[0], "solver.tolerance=1e-7"], 0.13)
    };
    let usual = under("");
    let [short, long] = [", bays=40", ", bays=300"].map(|bays| common::largest_difference(&usual, &under(bays)));
    println!("40 bays {short:.0} N, 300 bays {long:.0} N");
    assert!(long < 0.01 * LOAD && short > 0.04 * LOAD, "{short} {long}");
}

/// Step lengths follow the tolerance, errors too; on a dense grid.
#[test]
fn order_errors_follow_the_tolerance() {
    let exact = run(&[EXACT[0], "solver.tolerance=1e-9"], 0.1);
    let errors = ["1e-5", "1e-6", "1e-7"].map(|tolerance| {
        let off = common::largest_difference(&exact, &run(&[EXACT[0], &format!("solver.tolerance={tolerance}")], 0.1));
        println!("tolerance {tolerance}: Q off by {off:.2} N");
        off
    });
    // The first is small beside what its tolerance allows, so that the second is held to half of what the first may be.
    assert!(
        errors[0] < 0.005 * LOAD && errors[1] < 0.0025 * LOAD && errors[1] < 0.7 * errors[0] && errors[2] < 0.4 * errors[1],
        "{errors:?}"
    );
}

#[test]
fn equiv_integrators_on_rails_on_sleepers() {
    let exact = run(&["solver.integrator=dormand_prince", "solver.tolerance=1e-8"], 0.1);
    let cases: [(&[&str], f64); 6] = [
        (&EXACT, 2e-3),
        (&["solver.integrator=rk43", "solver.tolerance=1e-7"], 1e-3),
        (&["solver.integrator=imex", "solver.tolerance=1e-7"], 5e-3),
        (&["solver.integrator=generalised_alpha", "solver.step=1e-4"], 2e-2),
        (&["solver.integrator=real_time", "solver.step=1e-4"], 2e-2),
        (&["solver.integrator=zhai", "solver.step=2e-5"], 1e-2),
    ];
    let mut wrong = Vec::new();
    for (integrator, bound) in cases {
        let off = common::largest_difference(&exact, &run(integrator, 0.1)) / LOAD;
        println!("{integrator:?}: Q off by {off:.1e} of the static load");
        if !(off < bound) {
            wrong.push(format!("{integrator:?}: {off:e}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// Work of the drive is energy of vehicle, contacts and rails, and heat in rails: also by the force that holds a wheel back on the slope of its rail.
#[test]
fn analytic_energy_of_vehicle_and_rails() {
    let scene = straight(&[
        BEAM,
        "contact.damping=0",
        "contact.friction=0",
        "solver.integrator=rosenbrock",
        "solver.tolerance=1e-9",
        "vehicle.initial.vz=-0.02",
    ]);
    let mut simulation = start(&scene);
    // Energy, and powers of drive and heat.
    let look = |simulation: &mut wheelrail::sim::Simulation| {
        let snapshot = simulation.snapshot().unwrap();
        let (y, workspace) = (snapshot.y.clone(), snapshot.workspace.clone());
        let model = simulation.model();
        let contacts: f64 = workspace.contacts.iter().map(|contact| 0.4 * contact.normal_force * contact.penetration).sum();
        let (stored, heat) = model.rail_energy(&y);
        let drive: f64 = model
            .system
            .drives
            .iter()
            .zip(&workspace.system.drive_forces)
            .map(|(drive, force)| force * workspace.system.motions[drive.body].velocity.x)
            .sum();
        [model.system.mechanical_energy(&y, &workspace.system) + contacts + stored, drive, heat, stored]
    };
    let (h, count) = (1e-4, 1500);
    let seen: Vec<[f64; 4]> = (0..=count)
        .map(|n| {
            simulation.advance(h * f64::from(n)).unwrap();
            look(&mut simulation)
        })
        .collect();
    let simpson = |of: &dyn Fn(&[f64; 4]) -> f64| {
        let weight = |n: usize| {
            if n == 0 || n == count as usize {
                1.0
            } else if n % 2 == 1 {
                4.0
            } else {
                2.0
            }
        };
        seen.iter().enumerate().map(|(n, one)| weight(n) * of(one)).sum::<f64>() * h / 3.0
    };
    let (drive, heat) = (simpson(&|one| one[1]), simpson(&|one| one[2]));
    let change = seen[count as usize][0] - seen[0][0];
    let left = change - drive + heat;
    println!("drive {drive:.4} J, heat {heat:.4} J, energy changes by {change:.4} J, {left:.2e} J are left");
    assert!(heat > 10.0 && drive > 5.0, "{heat} {drive}");
    assert!(left.abs() < 2e-3 * heat, "{left} of {heat}");
}

/// The second program: Timoshenko's elements (interpolation that does not lock, consistent mass) on a ring with its sleepers, Hertz's contact and half a wheelset, by
/// Newmark's method. It shares nothing with the modes but the numbers of the track.
struct Elements {
    mass: DMatrix<f64>,
    damping: DMatrix<f64>,
    stiffness: DMatrix<f64>,
    h: f64,
    nodes: usize,
    shear: f64,
}

impl Elements {
    fn new(beam: &RailBeam, bays: usize, per_bay: usize) -> Elements {
        let bay = &beam.bay;
        let (nodes, h) = (bays * per_bay, bay.spacing / per_bay as f64);
        let n = 2 * nodes + bays;
        let zero = || DMatrix::<f64>::zeros(n, n);
        let (mut mass, mut damping, mut stiffness) = (zero(), zero(), zero());
        let shear = 12.0 * bay.bending / (bay.shear * h * h);
        let mut elements = Elements { mass: zero(), damping: zero(), stiffness: zero(), h, nodes, shear };
        let k = bay.bending / (h * h * h * (1.0 + shear));
        let own = [
            [12.0, 6.0 * h, -12.0, 6.0 * h],
            [6.0 * h, (4.0 + shear) * h * h, -6.0 * h, (2.0 - shear) * h * h],
            [-12.0, -6.0 * h, 12.0, -6.0 * h],
            [6.0 * h, (2.0 - shear) * h * h, -6.0 * h, (4.0 + shear) * h * h],
        ];
        for element in 0..nodes {
            let places = [2 * element, 2 * element + 1, 2 * ((element + 1) % nodes), 2 * ((element + 1) % nodes) + 1];
            for i in 0..4 {
                for j in 0..4 {
                    stiffness[(places[i], places[j])] += k * own[i][j];
                    // Gauss's rule for the masses.
                    for (x, weight) in [(0.1127016653792583, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.8872983346207417, 5.0 / 18.0)] {
                        let (w, turn) = (elements.shape(x), elements.turn(x));
                        mass[(places[i], places[j])] += h * weight * (bay.mass * w[i] * w[j] + bay.rotary * turn[i] * turn[j]);
                    }
                }
            }
        }
        for m in 0..bays {
            let (rail, sleeper) = (2 * m * per_bay, 2 * nodes + m);
            for (matrix, pad, ballast) in
                [(&mut stiffness, bay.pad_stiffness, bay.ballast_stiffness), (&mut damping, bay.pad_damping, bay.ballast_damping)]
            {
                matrix[(rail, rail)] += pad;
                matrix[(rail, sleeper)] -= pad;
                matrix[(sleeper, rail)] -= pad;
                matrix[(sleeper, sleeper)] += pad + ballast;
            }
            mass[(sleeper, sleeper)] += bay.sleeper_mass;
        }
        (elements.mass, elements.damping, elements.stiffness) = (mass, damping, stiffness);
        elements
    }

    /// Deflection and turn of the sections by the ends' deflections and turns, at the part x of an element.
    fn shape(&self, x: f64) -> [f64; 4] {
        let (p, h, s) = (self.shear, self.h, 1.0 / (1.0 + self.shear));
        [
            s * (1.0 - 3.0 * x * x + 2.0 * x * x * x + p * (1.0 - x)),
            s * h * (x - 2.0 * x * x + x * x * x + 0.5 * p * (x - x * x)),
            s * (3.0 * x * x - 2.0 * x * x * x + p * x),
            s * h * (-x * x + x * x * x - 0.5 * p * (x - x * x)),
        ]
    }

    fn turn(&self, x: f64) -> [f64; 4] {
        let (p, h, s) = (self.shear, self.h, 1.0 / (1.0 + self.shear));
        [
            s * 6.0 / h * (x * x - x),
            s * (1.0 - 4.0 * x + 3.0 * x * x + p * (1.0 - x)),
            s * 6.0 / h * (x - x * x),
            s * (3.0 * x * x - 2.0 * x + p * x),
        ]
    }

    fn force(&self, distance: f64) -> DVector<f64> {
        let mut force = DVector::zeros(self.mass.nrows());
        let at = distance.rem_euclid(self.h * self.nodes as f64) / self.h;
        let element = at as usize;
        for (i, value) in self.shape(at - element as f64).into_iter().enumerate() {
            force[(2 * element + i) % (2 * self.nodes)] += value;
        }
        force
    }

    /// Wheel loads of a wheel that presses with `load` [N] and is carried by K d^1.5, every `dt` until `stop`.
    fn run(&self, speed: f64, from: f64, contact: f64, (dt, stop): (f64, f64)) -> Vec<f64> {
        let n = self.mass.nrows();
        let (beta, gamma) = (0.25, 0.5);
        let implicit = Cholesky::new(&self.mass + &self.damping * (gamma * dt) + &self.stiffness * (beta * dt * dt)).unwrap();
        let (mut u, mut v, mut a) = (DVector::zeros(n), DVector::zeros(n), DVector::zeros(n));
        u -= Cholesky::new(self.stiffness.clone()).unwrap().solve(&self.force(from)) * LOAD;
        let sunk = (LOAD / contact).powf(2.0 / 3.0);
        let (mut z, mut rise, mut faster) = (self.force(from).dot(&u) - sunk, 0.0, 0.0);
        let mut loads = vec![LOAD];
        for step in 1..=(stop / dt).round() as usize {
            let place = self.force(from + speed * dt * step as f64);
            u += &v * dt + &a * (dt * dt * (0.5 - beta));
            v += &a * (dt * (1.0 - gamma));
            let free = implicit.solve(&(-(&self.damping * &v) - &self.stiffness * &u));
            let pushed = implicit.solve(&place);
            z += rise * dt + faster * dt * dt * (0.5 - beta);
            rise += faster * dt * (1.0 - gamma);
            let part = beta * dt * dt;
            // Depth = rail - wheel, with both moved by the force that it makes.
            let give = part * (place.dot(&pushed) + 1.0 / UNSPRUNG);
            let depth = place.dot(&u) + part * place.dot(&free) - z + part * LOAD / UNSPRUNG;
            let (mut force, mut d) = (loads[step - 1], 0.0f64);
            for _ in 0..60 {
                d = (depth - give * force).max(0.0);
                let next = contact * d.powf(1.5);
                force += (next - force) / (1.0 + give * 1.5 * contact * d.sqrt());
            }
            assert!((force - contact * d.powf(1.5)).abs() < 1.0);
            a = free - pushed * force;
            u += &a * part;
            v += &a * (gamma * dt);
            faster = (force - LOAD) / UNSPRUNG;
            z += faster * part;
            rise += faster * gamma * dt;
            loads.push(force);
        }
        loads
    }
}

#[test]
fn validate_a_wheel_over_sleepers_against_finite_elements() {
    let mut wrong = Vec::new();
    for (speed, dt) in [(20.0, 1e-4), (40.0, 1e-4), (60.0, 5e-5)] {
        let flexibility = "track.flexibility={model=\"beam\", rail_loss_factor=0, highest_frequency=8000, bays=24}";
        let scene = straight(&[flexibility, &format!("vehicle.speed={speed}"), "contact.damping=0", EXACT[0], "solver.tolerance=1e-8"]);
        let Some(Flexibility::Beam(beam)) = scene.track.flexibility else { panic!() };
        let mut simulation = start(&scene);
        let contact = simulation.snapshot().unwrap().workspace.contacts[0].stiffness;
        let stop = 0.5;
        let found = column(&common::run(&scene, stop, dt), "left.verticalForce");
        let expected = Elements::new(&beam, 24, 8).run(speed, 100.0, contact, (dt, stop));
        let whole = (0.25 / (beam.bay.spacing / speed)).floor() * beam.bay.spacing / speed;
        let tail = |loads: &[f64]| loads[loads.len() - (whole / dt).round() as usize..].to_vec();
        let (own, other) = (tail(&found), tail(&expected));
        // A force gives elements kinks at their nodes, 8 in a bay, which ring on the contact: harmonics of the sleepers well below that are compared, with their phases.
        let harmonics = [1.0, 2.0, 3.0].map(|n| [&own, &other].map(|loads| amplitude(loads, dt, n * speed / beam.bay.spacing)));
        let first = harmonics[0][1].norm();
        let off = harmonics.map(|[own, other]| (own - other).norm() / first);
        println!(
            "{speed} m/s: {:.1} Hz and twice and three times that with {:.1?} N; apart {off:.4?} of the first",
            speed / beam.bay.spacing,
            harmonics.map(|both| both.map(|amplitude| amplitude.norm()))
        );
        if !off.iter().all(|off| *off < 0.035) {
            wrong.push(format!("{speed} m/s"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// Wheels that feel each other's waves share their rails, as far as the work stays bounded; a state that is kept goes on to the bit.
#[test]
fn prop_rails_of_a_vehicle() {
    let changes = [BEAM, "vehicle.speed=40", "track.deviation=[]"].map(str::to_string);
    let scene = load::open("vehicle_manchester_1", &changes).unwrap();
    let mut simulation = start(&scene);
    {
        let rails = simulation.model().beam.as_ref().unwrap();
        assert_eq!((rails.groups.len(), rails.groups[0].len()), (1, 4));
        let train = start(&load::open("train", &[BEAM.to_string()]).unwrap());
        let rails_of_train = train.model().beam.as_ref().unwrap();
        assert!(
            rails_of_train.groups.len() == 2 && rails_of_train.longest < 72.0,
            "{} {}",
            rails_of_train.groups.len(),
            rails_of_train.longest
        );
        println!("{} modes, {} bays, {} states", rails.ring.modes(), rails.ring.bays(), simulation.model().dimension());
    }
    simulation.advance(0.1).unwrap();
    let kept = simulation.state().clone();
    simulation.advance(0.2).unwrap();
    let bits = |simulation: &wheelrail::sim::Simulation| simulation.state().integration.y.iter().map(|y| y.to_bits()).collect::<Vec<u64>>();
    let first = bits(&simulation);
    let mut other = start(&scene);
    other.restore(&kept);
    other.advance(0.2).unwrap();
    assert!(first == bits(&other));
}

#[test]
fn prop_senseless_rails_are_refused_with_reasons() {
    let message = |changes: &[&str]| {
        let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
        let made = load::open("suspended_wheelset", &changes).map_err(|error| error.to_string());
        made.and_then(|scene| wheelrail::sim::Simulation::new(&scene, 0.0).map(|_| ()).map_err(|error| error.to_string())).unwrap_err()
    };
    let table = |inside: &str| format!("track.flexibility={{model=\"beam\",{inside}}}");
    for (changes, expected) in [
        (vec![table("rail=\"60E9\"")], "60E1"),
        (vec![table("sleeper_spacing=0")], "sleeper_spacing: found 0.0"),
        (vec![table("vertical_mass=245")], "vertical_mass"),
        (vec![table("bays=31")], "an even whole number"),
        (vec![table("ballast_stiffness=1e6, pad_stiffness=1e6")], "starts are found up to"),
        (vec![BEAM.to_string(), "contact.formulation=ECCF".to_string()], "track.flexibility needs elastic contact"),
        (vec![BEAM.to_string(), "interface.inputs=[\"rail_motion\"]".to_string()], "track.flexibility stands beside \"rail_motion\""),
    ] {
        let found = message(&changes.iter().map(String::as_str).collect::<Vec<_>>());
        assert!(found.contains(expected), "{changes:?}: {found}");
    }
    let short = ["track.flexibility={model=\"beam\", bays=8}".to_string()];
    let found = load::open("vehicle_manchester_1", &short).map(|_| ()).unwrap_err().to_string();
    assert!(found.contains("too short"), "{found}");
}

/// Derivatives of forces go along the solution that is handed out. Along f, which says how what implicit steps leave of the stiffest motions would swing back, Q' was off by
/// four times its own size. At each time two derivatives and the difference between them are taken, in the order of time, so near that no step of the integrator ends in between: there the slope
/// jumps.
#[test]
fn equiv_derivatives_on_beam_rails_are_slopes_of_the_solution() {
    const APART: f64 = 2e-6;
    const SMALL: f64 = 1e-6;
    let scene = load::open("vehicle_manchester_1", &[BEAM.into()]).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = start(&scene);
    let outputs = table(&simulation, &scene);
    let output = outputs.iter().find(|output| output.name == "truck[1].wheelset[1].left.verticalForce").expect("no Q");
    let mut look = |time: f64| {
        simulation.advance(time).unwrap_or_else(|error| panic!("{error}"));
        let value = output.value(simulation.snapshot().unwrap_or_else(|error| panic!("{error}")));
        let along = simulation.slope().unwrap_or_else(|error| panic!("{error}"));
        let mut at = |offset: f64| {
            simulation.displace(offset, &along, None).unwrap_or_else(|error| panic!("{error}"));
            output.value(simulation.seen())
        };
        (value, (at(SMALL) - at(-SMALL)) / (2.0 * SMALL))
    };
    let (mut worst, mut largest) = (0.0f64, 0.0f64);
    for i in 1..40 {
        let time = 0.0373 * f64::from(i);
        let ((before, slope_before), (after, slope_after)) = (look(time), look(time + APART));
        let slope = (after - before) / APART;
        (worst, largest) = (worst.max((0.5 * (slope_before + slope_after) - slope).abs()), largest.max(slope.abs()));
    }
    println!("dQ/dt within {worst:.3e} N/s of {largest:.3e}");
    assert!(worst < 0.01 * largest);
}
