//! The linearised model against central differences of the model itself.
//!
//! J is read from what an integrator gets: the columns of (I - a J)^-1. Two measures: per row of a wheelset's accelerations the
//! relative error of J, and the spectral radius of `a (I - a J)^-1 (J - J')` with J' from differences, which says by what share J
//! misses in a step of about 2 a; below 1 a linearly implicit step can be stable.

use crate::common;
use crate::counting;
use nalgebra::DMatrix;
use wheelrail::formulation::memory::ModelMemory;
use wheelrail::formulation::{Evaluation, Model};
use wheelrail::scene::load;
use wheelrail::sim::Simulation;

struct Linearised {
    exact: DMatrix<f64>,
    found: DMatrix<f64>,
    bodies: usize,
    wheelset: usize,
}

fn derivative(
    model: &Model,
    workspace: &mut wheelrail::formulation::Workspace,
    y: &[f64],
    memory: &ModelMemory,
    inputs: &[f64],
) -> Vec<f64> {
    let (mut memory, mut dy) = (memory.clone(), vec![0.0; y.len()]);
    let at = Evaluation { t: 0.0, inputs, y, memory: &mut memory };
    model.derivative(workspace, at, &mut dy).unwrap_or_else(|error| panic!("{error}"));
    dy
}

/// J of a simulation's present state, found and differenced.
fn linearised(simulation: &Simulation) -> Linearised {
    linearised_over(simulation, 1e-6)
}

/// The same with differences over `reach` [m or rad].
fn linearised_over(simulation: &Simulation, reach: f64) -> Linearised {
    linearised_for(simulation, reach, &simulation.model().neutral_inputs())
}

fn linearised_for(simulation: &Simulation, reach: f64, inputs: &[f64]) -> Linearised {
    let model = simulation.model();
    let (y, memory) = (&simulation.state().integration.y, &simulation.state().memories.accepted);
    let mut workspace = model.workspace();
    model.prepare_tangent(&mut workspace);
    derivative(model, &mut workspace, y, memory, inputs);
    model.linearise(&mut workspace, (y, memory), inputs, true);
    let (n, a) = (y.len(), 1e-3);
    model.factorise(&mut workspace, a).unwrap_or_else(|error| panic!("{error}"));
    let mut inverse = DMatrix::zeros(n, n);
    for j in 0..n {
        let mut x = vec![0.0; n];
        x[j] = 1.0;
        model.solve_linear(&mut workspace, &mut x);
        inverse.set_column(j, &nalgebra::DVector::from_vec(x));
    }
    let found = (DMatrix::identity(n, n) - inverse.try_inverse().unwrap()) / a;
    let count = 6 * model.system.bodies.len();
    let mut exact = DMatrix::zeros(n, n);
    for j in 0..n {
        let h = if j < count {
            reach
        } else if j < 2 * count {
            1e-4
        } else {
            1e-8
        };
        let mut at = |sign: f64| {
            let mut y = y.clone();
            y[j] += sign * h;
            derivative(model, &mut workspace, &y, memory, inputs)
        };
        let (ahead, behind) = (at(1.0), at(-1.0));
        for i in 0..n {
            exact[(i, j)] = (ahead[i] - behind[i]) / (2.0 * h);
        }
    }
    Linearised { exact, found, bodies: model.system.bodies.len(), wheelset: model.wheelsets[0].body }
}

impl Linearised {
    /// By row of the first wheelset's accelerations: relative error by coordinates and by velocities.
    fn rows(&self) -> [[f64; 2]; 6] {
        let count = 6 * self.bodies;
        std::array::from_fn(|row| {
            let row = count + 6 * self.wheelset + row;
            [0, count].map(|start| {
                let range = |m: &DMatrix<f64>| m.view((row, start), (1, count)).into_owned();
                let (exact, found) = (range(&self.exact), range(&self.found));
                let scale = exact.norm();
                if scale < 1.0 { 0.0 } else { (exact - found).norm() / scale }
            })
        })
    }

    /// Spectral radius for the step factor a.
    fn radius(&self, a: f64) -> f64 {
        let n = self.exact.nrows();
        let matrix = DMatrix::identity(n, n) - &self.found * a;
        let missed = (&self.exact - &self.found) * a;
        let error = matrix.lu().solve(&missed).unwrap();
        error.complex_eigenvalues().iter().map(|z| z.norm()).fold(0.0, f64::max)
    }
}

/// Runs a scene up to `until` [s] and compares; returns the worst row (positions, velocities) and the radii for 1 ms and 5 ms.
fn compare(name: &str, changes: &[&str], until: f64) -> (f64, f64, [f64; 2]) {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    let scene = load::open(name, &changes).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = common::start(&scene);
    simulation.advance(until).unwrap_or_else(|error| panic!("{error}"));
    let linearised = linearised(&simulation);
    let rows = linearised.rows();
    let worst = |k: usize| rows.iter().map(|row| row[k]).fold(0.0, f64::max);
    let radii = [1e-3, 5e-3].map(|a| linearised.radius(a));
    println!("{name} {changes:?}: rows by position {:.3?}, by velocity {:.3?}, radii {radii:.3?}", rows.map(|r| r[0]), rows.map(|r| r[1]));
    if std::env::var_os("SHOW_J").is_some() {
        let count = 6 * linearised.bodies;
        for start in [0, count] {
            for (label, m) in [("exact", &linearised.exact), ("found", &linearised.found)] {
                let b = linearised.wheelset;
                println!("{label} {start}:{:12.3e}", m.view((count + 6 * b, start + 6 * b), (6, 6)));
            }
        }
    }
    (worst(0), worst(1), radii)
}

/// Scene, changes, time [s].
type Case<'a> = (&'a str, &'a [&'a str], f64);

/// Compares all cases; rows and radii must stay below these limits.
fn check(cases: &[Case], rows: f64, radii: [f64; 2]) {
    let mut wrong = Vec::new();
    for (name, changes, until) in cases {
        let (position, velocity, found) = compare(name, changes, *until);
        if !(position < rows && velocity < rows && found[0] < radii[0] && found[1] < radii[1]) {
            wrong.push(format!("{name} {changes:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn analytic_cones_with_every_creep_law() {
    for law in ["kalker_linear", "shen_hedrick_elkins", "polach", "fastsim", "fastrip", "usetab"] {
        let law = format!("contact.creep.law={law}");
        // 21 m: in the gauge reduction.
        let changes = [law.as_str(), "vehicle.initial.distance=18", "vehicle.initial.y=0.003", "vehicle.initial.yaw=0.002"];
        check(&[("suspended_wheelset", &changes, 0.08)], 0.02, [0.01, 0.01]);
    }
}

#[test]
fn analytic_damping_laws() {
    let laws: [&[&str]; 3] = [
        &["contact.damping=0"],
        &["contact.damping={ law = \"hunt_crossley\", restitution = 0.8, impact_speed = 0.1 }"],
        &["contact.damping={ law = \"linear\", coefficient = 1e5, full_at = 1e-4 }"],
    ];
    check(&laws.map(|law| ("suspended_wheelset", law, 0.6)), 0.02, [0.01, 0.01]);
}

#[test]
fn analytic_real_profiles_at_several_offsets() {
    let offsets = ["0", "0.0005", "0.002", "0.004", "0.006"].map(|y| format!("vehicle.initial.y={y}"));
    let changes = offsets.each_ref().map(|y| [y.as_str(), "vehicle.initial.yaw=0.001"]);
    check(&changes.each_ref().map(|changes| ("wheelset_s1002", &changes[..], 0.02)), ROWS, [0.02, 0.05]);
}

/// Single entries may be far off where they are small beside those that count; no limit.
const ROWS: f64 = f64::INFINITY;

#[test]
fn analytic_flange_contact() {
    check(
        &[
            ("wheelset_s1002", &["vehicle.initial.y=0.0075", "vehicle.initial.vy=0.05"], 0.01),
            ("wheelset_s1002", &["vehicle.initial.y=0.007", "vehicle.initial.vy=0.2"], 0.005),
            ("wheelset_s1002", &["vehicle.initial.y=-0.007", "vehicle.initial.vy=-0.3"], 0.003),
        ],
        ROWS,
        [0.02, 0.02],
    );
}

#[test]
fn analytic_transient_contact_in_motion_and_at_rest() {
    let speeds: [&[&str]; 4] = [&["vehicle.speed=0"], &["vehicle.speed=0.5"], &["vehicle.speed=1.5"], &[]];
    check(&speeds.map(|speed| ("wheelset_standstill", speed, 0.1)), ROWS, [0.02, 0.03]);
}

/// How the angle of a wheel that is not round changes its load is in the tangent.
#[test]
fn analytic_angle_of_a_wheel_that_is_not_round() {
    const POLYGON: &str =
        "vehicle.wheelset.out_of_round=[{kind=polygon,order=5,depth=0.1 mm,phase=0.3},{kind=polygon,order=2,depth=0.4 mm,wheel=left}]";
    for patch in ["contact.patch=ellipse", "contact.patch=strips"] {
        let changes = [
            POLYGON.replace("polygon,", "\"polygon\",").replace("=left", "=\"left\"").replace(" mm", "e-3"),
            patch.into(),
            "contact.damping=2e9".into(),
        ];
        let scene = load::open("wheelset_s1002", &changes).unwrap_or_else(|error| panic!("{error}"));
        let mut simulation = common::start(&scene);
        simulation.advance(0.3).unwrap();
        let Linearised { exact, found, .. } = linearised(&simulation);
        // Accelerations of height, roll and the wheel's turning by the pitch, and (what the larger radius has of it is left out) of the height by its rate.
        // What strips' own slopes leave out is some percent.
        let rows = [(8, 5, 100.0, 0.06), (10, 5, 100.0, 0.06), (11, 5, 10.0, 0.4), (8, 11, 1e-3, 0.15)];
        for (row, column, least, most) in rows.into_iter().take(if patch.ends_with("strips") { 2 } else { 4 }) {
            let (exact, found) = (exact[(row, column)], found[(row, column)]);
            println!("{patch}: d a[{row}] / d y[{column}] = {exact:.4e}, tangent {found:.4e}");
            assert!(exact.abs() > least && (found / exact - 1.0).abs() < most, "{exact} {found}");
        }
    }
}

/// The rails' own states, and what couples them with wheels and with deflections of contacts.
#[test]
fn analytic_track_that_gives_way() {
    const YIELDS: &str = "track.flexibility=travelling";
    const LIGHT: &str = "track.flexibility={model=\"travelling\",vertical_mass=60,lateral_mass=40,vertical_damping=2e4}";
    check(
        &[
            ("suspended_wheelset", &[YIELDS, "vehicle.initial.distance=18", "vehicle.initial.y=0.003", "vehicle.initial.yaw=0.002"], 0.08),
            ("suspended_wheelset", &[LIGHT, "vehicle.initial.distance=18"], 0.09),
            ("wheelset_s1002", &[YIELDS, "vehicle.initial.y=0.006", "vehicle.initial.yaw=0.001"], 0.01),
            ("wheelset_standstill", &[YIELDS, "vehicle.speed=0"], 0.05),
            ("wheelset_standstill", &[LIGHT, "vehicle.speed=1.5"], 0.02),
        ],
        ROWS,
        // 0.029 and 0.044 at the standstill since spin is rolled in: not by how its rate follows the rolling speed (tried), which J holds beside p.
        [0.035, 0.05],
    );
    // All wheels of a vehicle, on rails that are nowhere plain.
    let rough = "track.irregularity=[{kind=\"spectrum\", spectrum=\"ore_b176_low\", seed=1, from=15, to=400, fade=5}]";
    for patch in ["contact.patch=ellipse", "contact.patch=strips"] {
        check(&[("vehicle_manchester_1", &[YIELDS, rough, patch], 1.3)], ROWS, [0.05, 0.05]);
    }
}

/// The same of rails on sleepers, with the wheels of a bogie on one rail.
#[test]
fn analytic_rails_on_sleepers() {
    const BEAM: &str = "track.flexibility={model=\"beam\", highest_frequency=900, bays=24}";
    check(
        &[
            ("suspended_wheelset", &[BEAM, "vehicle.initial.distance=18", "vehicle.initial.y=0.003", "vehicle.initial.yaw=0.002"], 0.08),
            ("wheelset_s1002", &[BEAM, "vehicle.initial.y=0.006", "vehicle.initial.yaw=0.001"], 0.01),
            ("wheelset_standstill", &[BEAM, "vehicle.speed=1.5"], 0.02),
            ("vehicle_manchester_1", &["track.flexibility={model=\"beam\", highest_frequency=500, bays=12}"], 0.3),
        ],
        ROWS,
        [0.1, 0.4],
    );
}

#[test]
fn analytic_vehicles() {
    check(
        &[
            ("vehicle_manchester_1", &[], 1.3),
            ("vehicle_manchester_1", &["contact.creep.law=fastsim"], 1.3),
            ("vehicle_manchester_1", &["contact.creep.law=polach"], 1.3),
            ("vehicle_manchester_1", &["vehicle.detail=truck"], 1.3),
            ("vehicle_manchester_1", &["vehicle.detail=wheelset"], 1.3),
            ("vehicle_equalised", &["vehicle.detail=truck"], 1.3),
            ("vehicle_curve", &[], 3.0),
            ("vehicle_curve", &[], 4.5),
            ("vehicle_manchester_1", &["contact.formulation=ECCF"], 0.2),
        ],
        ROWS,
        [0.5, 0.9],
    );
}

#[test]
fn analytic_constraints_and_nodes() {
    check(
        &[
            ("suspended_wheelset", &["contact.formulation=ECCF"], 0.6),
            ("suspended_wheelset", &["contact.formulation=ECCF", "contact.creep.law=fastsim"], 0.6),
            ("suspended_wheelset", &["contact.formulation=ECF-N", "contact.node_spacing=1e-4"], 0.6),
        ],
        ROWS,
        [0.02, 0.02],
    );
}

#[test]
fn prop_linearising_and_solving_do_not_allocate_and_cost_little() {
    let scene = load::open("vehicle_manchester_1", &[]).unwrap();
    let mut simulation = common::start(&scene);
    simulation.advance(1.3).unwrap();
    let model = simulation.model();
    let (y, memory) = (&simulation.state().integration.y, simulation.state().memories.accepted.clone());
    let (inputs, mut workspace) = (model.neutral_inputs(), model.workspace());
    model.prepare_tangent(&mut workspace);
    let (mut dy, mut x, mut memory) = (vec![0.0; y.len()], vec![1.0; y.len()], memory);
    let rounds = 2000;
    let mut spent = [0.0; 5];
    let before = counting::count();
    for _ in 0..rounds {
        let start = std::time::Instant::now();
        model.derivative(&mut workspace, Evaluation { t: 0.0, inputs: &inputs, y, memory: &mut memory }, &mut dy).unwrap();
        let evaluated = start.elapsed();
        model.linearise(&mut workspace, (y, &memory), &inputs, false);
        let contacts = start.elapsed();
        model.linearise(&mut workspace, (y, &memory), &inputs, true);
        let all = start.elapsed();
        model.factorise(&mut workspace, 1e-3).unwrap();
        let factorised = start.elapsed();
        x.fill(1.0);
        model.solve_linear(&mut workspace, &mut x);
        let solved = start.elapsed();
        for (sum, part) in spent.iter_mut().zip([evaluated, contacts - evaluated, all - contacts, factorised - all, solved - factorised]) {
            *sum += part.as_secs_f64() / f64::from(rounds);
        }
    }
    assert_eq!(counting::count() - before, 0);
    let [f, contacts, all, factorise, solve] = spent.map(|s| 1e6 * s);
    println!(
        "coach: f {f:.1} us, J of contacts {contacts:.1} us, J of contacts and forces {all:.1} us, factorise {factorise:.1} us, solve {solve:.1} us"
    );
}

#[test]
fn analytic_tangent_of_patches_of_strips() {
    let [strips, table] = ["contact.patch = \"strips\"", "contact.patch = \"table\""];
    check(
        &[
            ("wheelset_s1002", &[strips], 1.0),
            ("vehicle_manchester_1", &[strips], 1.0),
            ("vehicle_curve", &[strips], 2.0),
            ("vehicle_curve", &[strips], 4.9),
            ("wheelset_s1002", &[table], 1.0),
            ("vehicle_manchester_1", &[table], 1.0),
            ("vehicle_curve", &[table], 2.0),
            ("vehicle_curve", &[table], 4.9),
        ],
        // Of no meaning here: y at the tread and x in a curve have rows next to nothing. The radii are what counts.
        1.05,
        [0.03, 0.15],
    );
}

#[test]
fn analytic_friction_by_place_is_in_the_tangent() {
    let at = |map: &[&str]| {
        // Yawed so much that all slides; nothing but friction changes along the track.
        let start = ["track.deviation=[]", "vehicle.initial.distance=20.5", "vehicle.initial.yaw=0.02"];
        let changes: Vec<String> = start.iter().copied().chain(map.iter().copied()).map(str::to_string).collect();
        linearised(&common::start(&load::open("suspended_wheelset", &changes).unwrap_or_else(|error| panic!("{error}"))))
    };
    let entry = |m: &DMatrix<f64>, row: usize, column: usize| m[(6 + row, column)];
    let along = at(&["contact.friction_along=[{factors=[[0,1.0],[21,0.3]],transition=\"4 m\"}]"]);
    for row in [0, 1, 3, 5] {
        let [exact, found] = [&along.exact, &along.found].map(|m| entry(m, row, 0));
        println!("along, row {row}: {exact:.4} {found:.4}");
        // Imposed speed: the row of x is empty.
        assert!((exact - found).abs() < 0.01 * exact.abs() + 1e-4, "row {row}: {exact} {found}");
    }
    assert!(entry(&along.exact, 1, 0).abs() > 0.1);
    // Contacts of the cones lie at 1/40 on the rail's arc, more or less with roll: on the right wheel alone, or both would cancel out. The same
    // friction everywhere shows what its change adds.
    let left = "contact.friction_along=[{rail=\"left\",factors=[[-200,0.05],[-100,0.05]],transition=1}]";
    let t: f64 = 0.025f64.atan() / 0.06;
    let w = t.powi(4) * (35.0 + t * (-84.0 + t * (70.0 - 20.0 * t)));
    let across = at(&["contact.friction_across={gauge_face=0.2,from=0,to=0.06}", left]);
    let constant = at(&[&format!("contact.friction={}", 0.5 * (1.0 - 0.8 * w)), left]);
    for row in [1, 4] {
        let [exact, found] = [&across.exact, &across.found].map(|m| entry(m, row, 4));
        let adds = exact - entry(&constant.exact, row, 4);
        println!("across, row {row}, roll: {exact:.3} {found:.3}, of which {adds:.3} by its change");
        assert!(adds.abs() > 10.0 && (exact - found).abs() < 0.1 * adds.abs(), "row {row}: {exact} {found} {adds}");
    }
}

#[test]
fn analytic_tangent_with_friction_by_place() {
    let across = "contact.friction_across={gauge_face=0.2,from=0,to=0.2}";
    let flange = "contact.friction_across={gauge_face=0.3,from=\"15 deg\",to=\"60 deg\"}";
    check(
        &[
            ("wheelset_s1002", &[flange, "vehicle.initial.y=0.0075", "vehicle.initial.vy=0.05"], 0.01),
            ("wheelset_s1002", &[flange, "contact.patch=strips", "vehicle.initial.y=0.004", "vehicle.initial.yaw=0.01"], 0.02),
            ("wheelset_standstill", &[across, "vehicle.speed=0.5", "vehicle.initial.yaw=0.004"], 0.1),
        ],
        ROWS,
        [0.03, 0.05],
    );
}

/// The oscillation of a wheelset on its contacts that grows fastest: growth and circular frequency, 1/s.
fn fastest(linearised: &Linearised, matrix: &DMatrix<f64>) -> (f64, f64) {
    const FAST: f64 = 300.0;
    let (count, first) = (6 * linearised.bodies, 6 * linearised.wheelset);
    let mut own = DMatrix::<f64>::zeros(12, 12);
    for i in 0..6 {
        own[(i, 6 + i)] = 1.0;
        for j in 0..6 {
            own[(6 + i, j)] = matrix[(count + first + i, first + j)];
            own[(6 + i, 6 + j)] = matrix[(count + first + i, count + first + j)];
        }
    }
    // Times of 1 ms: numbers of both halves are alike.
    own.view_mut((0, 6), (6, 6)).scale_mut(1e3);
    own.view_mut((6, 0), (6, 6)).scale_mut(1e-3);
    let values = own.complex_eigenvalues();
    values.iter().map(|value| (value.re, value.im)).filter(|value| value.1 > FAST).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
}

/// All that are driven go faster by the same: -1 / T of it comes back, nothing where the acceleration is at its bound.
#[test]
fn analytic_a_speed_that_follows_an_input_comes_back() {
    for (name, detail) in
        [("suspended_wheelset", "track.deviation=[]"), ("vehicle_curve", "vehicle.drive=all"), ("bogie", "vehicle.drive=all")]
    {
        for (wanted, expected) in [(0.3, -4.0), (5.0, 0.0)] {
            let changes = ["vehicle.speed={start=20,time_constant=0.25,largest_acceleration=2}", detail].map(String::from);
            let mut simulation = common::start(&load::open(name, &changes).unwrap_or_else(|error| panic!("{error}")));
            simulation.advance(0.05).unwrap();
            let mut inputs = simulation.model().neutral_inputs();
            let place = simulation.model().first_travel_input(inputs.len()).unwrap();
            inputs[place] = 20.0 + wanted;
            let Linearised { exact, found, bodies, .. } = linearised_for(&simulation, 1e-6, &inputs);
            let y = &simulation.state().integration.y;
            let mut along = nalgebra::DVector::zeros(y.len());
            for drive in &simulation.model().system.drives {
                for i in (6 * (bodies + drive.body)..).take(3) {
                    along[i] = y[i] / 20.0;
                }
            }
            for (told, matrix) in [("differences", exact), ("J", found)] {
                let back = matrix * &along;
                for drive in &simulation.model().system.drives {
                    let back: f64 = (6 * (bodies + drive.body)..).take(3).map(|i| back[i] * along[i]).sum();
                    println!("{name}, {told}, body {}: {back}", drive.body);
                    assert!((back - expected).abs() < 2e-3, "{name}, {told}, body {}: {back}, {expected}", drive.body);
                }
            }
        }
    }
}

/// Two parts of a patch on the flange root: told from the strips that are in contact alone, their stiffness hid a growth of 43 1/s.
#[test]
fn analytic_flutter_on_strips_is_that_of_the_model() {
    let track = "track.node=[{distance=0},{distance=30},{distance=80,curvature=0.006667},{distance=300,curvature=0.006667}]";
    let changes = [track, "vehicle.speed=11", "contact.friction=0.55", "contact.patch=strips", "solver.tolerance=1e-7"].map(String::from);
    let mut simulation = common::start(&load::open("vehicle_manchester_1", &changes).unwrap());
    let (mut apart, mut grown) = (Vec::new(), f64::NEG_INFINITY);
    // From where the wheel reaches the root into the flutter, whose states depend on how it began: what they share is looked at.
    for until in (350..=370).map(|i| 0.01 * f64::from(i)) {
        simulation.advance(until).unwrap();
        // Strips come into contact a fraction of a micrometre apart on this root.
        let linearised = linearised_over(&simulation, 1e-7);
        let [exact, found] = [&linearised.exact, &linearised.found].map(|matrix| fastest(&linearised, matrix));
        println!("{until:.2} s: {exact:.1?}, found {found:.1?}");
        apart.push((exact.0 - found.0).hypot(exact.1 - found.1));
        grown = grown.max(exact.0);
    }
    // Slopes jump where a strip comes into contact: some states stand there.
    apart.sort_by(f64::total_cmp);
    let median = apart[apart.len() / 2];
    assert!(median < 4.0, "eigenvalues differ by {median} 1/s");
    assert!(grown > 20.0, "nothing grows: {grown}");
}
