//! Rigid contacts (ECCF, ACCF) whose place ceases to exist, or where the law of contact jumps: a truck runs into a curve of 300 m radius with
//! a friction of 0.6; S1002 on 60E1.
//!
//! Two places cease on the way (0.229 s and 0.257 s). The curvature over the patch jumps twice before (0.120 s and 0.149 s), where a rigid
//! contact has to stay one.

use wheelrail::formulation::events::ContactChange;
use wheelrail::geometry::Side;
use wheelrail::mbs::body::COORDINATES;
use wheelrail::scene::load;
use wheelrail::sim::Simulation;

const STOP: f64 = 0.28;

/// What was seen along a run.
struct Run {
    /// When and where places ceased.
    ceased: Vec<(f64, String, Side)>,
    /// Other changes of mode.
    others: usize,
    /// Lateral displacements of both wheelsets [m] and vertical forces of their wheels [N] every 0.2 ms.
    lateral: Vec<[f64; 2]>,
    vertical: Vec<[f64; 4]>,
}

fn run(formulation: &str, integrator: &str, tolerance: &str) -> Run {
    let node = "curvature=0.0033333333333333335, superelevation=\"-60 mm\"";
    let changes = [
        format!("contact.formulation={formulation}"),
        "contact.on_lift=elastic".into(),
        format!("track.node=[{{distance=0}}, {{distance=3}}, {{distance=15, {node}}}, {{distance=400, {node}}}]"),
        "track.deviation=[]".into(),
        "vehicle.speed=16".into(),
        "contact.friction=0.6".into(),
        format!("solver.integrator={integrator}"),
        format!("solver.tolerance={tolerance}"),
    ];
    let scene = load::open("bogie", &changes).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = Simulation::new(&scene, 0.0).unwrap_or_else(|error| panic!("{error}"));
    let bodies: Vec<usize> = simulation.model().wheelsets.iter().map(|wheelset| wheelset.body).collect();
    let mut run = Run { ceased: vec![], others: 0, lateral: vec![], vertical: vec![] };
    let step = 2e-4;
    for row in 0..=(STOP / step).round() as u32 {
        simulation.advance(step * f64::from(row)).unwrap_or_else(|error| panic!("{formulation}, {integrator}, {tolerance}: {error}"));
        let snapshot = simulation.snapshot().unwrap_or_else(|error| panic!("{error}"));
        run.lateral.push([0, 1].map(|i| snapshot.y[COORDINATES * bodies[i] + 1]));
        run.vertical.push([0, 1, 2, 3].map(|contact| snapshot.workspace.wheel_force(contact, bodies[contact / 2]).z));
    }
    for event in simulation.take_events().iter().filter(|event| event.change.changes_mode()) {
        match event.change {
            ContactChange::Vanished => run.ceased.push((event.time, event.wheelset.clone(), event.side)),
            _ => run.others += 1,
        }
    }
    run
}

/// Largest difference of lateral displacements, m.
fn apart(a: &Run, b: &Run) -> f64 {
    let pairs = a.lateral.iter().flatten().zip(b.lateral.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn equiv_places_cease_where_they_do_whatever_integrates() {
    let reference = run("ECCF", "dormand_prince", "1e-9");
    assert_eq!(reference.ceased.len(), 2, "{:?}", reference.ceased);
    for (formulation, integrator, tolerance, near, soon) in
        [("ECCF", "rk43", "1e-8", 3e-8, 3e-6), ("ACCF", "dormand_prince", "1e-8", 3e-8, 3e-6), ("ECCF", "rosenbrock", "1e-6", 3e-6, 3e-4)]
    {
        let other = run(formulation, integrator, tolerance);
        let lateral = apart(&reference, &other);
        assert_eq!((other.ceased.len(), other.others), (2, reference.others), "{formulation}, {integrator}: {:?}", other.ceased);
        for (a, b) in reference.ceased.iter().zip(&other.ceased) {
            println!("{formulation}, {integrator}, {tolerance}: {} {:?} {:+.1e} s; y {lateral:.1e} m", b.1, b.2, b.0 - a.0);
            assert!((&a.1, a.2) == (&b.1, b.2) && (a.0 - b.0).abs() < soon, "{formulation}, {integrator}: {a:?} {b:?}");
        }
        assert!(lateral < near, "{formulation}, {integrator}: {lateral:.1e} m");
    }
}

#[test]
fn hard_wheel_loads_pass_over_the_end_of_a_place_without_a_blow() {
    let rigid = run("ECCF", "dormand_prince", "1e-8");
    let elastic = run("ECF-A", "dormand_prince", "1e-8");
    // Between rows, and against elastic contact.
    let jump =
        rigid.vertical.windows(2).flat_map(|rows| (0..4).map(|i| ((rows[1][i] - rows[0][i]) / rows[0][i]).abs())).fold(0.0, f64::max);
    let pairs = rigid.vertical.iter().flatten().zip(elastic.vertical.iter().flatten());
    let apart = pairs.map(|(rigid, elastic)| ((rigid - elastic) / elastic).abs()).fold(0.0, f64::max);
    println!("wheel loads: by {:.2} % within 0.2 ms, {:.2} % from elastic ones", 100.0 * jump, 100.0 * apart);
    assert!(jump < 0.015, "{jump}");
    assert!(apart < 0.04, "{apart}");
}

/// Two places of S1002 on 60E1 cease within milliseconds of each other, the left one beside a corner of curvature where nothing announces it. ACCF closes
/// both contacts together: it freed the right wheel first, and y was off by 0.1 to 0.2 mm whatever the step.
#[test]
fn equiv_accf_frees_the_wheel_that_loses_its_place() {
    let run = |formulation: &str, distance: f64, solver: [&str; 2]| {
        let changes = [
            format!("contact.formulation={formulation}"),
            "contact.on_lift=elastic".into(),
            format!("vehicle.initial.distance={distance}"),
            format!("solver.integrator={}", solver[0]),
            format!("solver.{}", solver[1]),
        ];
        let scene = load::open("wheelset_s1002", &changes).unwrap_or_else(|error| panic!("{error}"));
        let mut simulation = Simulation::new(&scene, 0.0).unwrap_or_else(|error| panic!("{error}"));
        let lateral: Vec<f64> = (1..=700)
            .map(|row| {
                simulation.advance(1e-3 * f64::from(row)).unwrap_or_else(|error| panic!("{formulation}: {error}"));
                simulation.snapshot().unwrap().y[1]
            })
            .collect();
        let ceased = |event: &&wheelrail::formulation::events::ContactEvent| matches!(event.change, ContactChange::Vanished);
        (lateral, simulation.take_events().iter().filter(ceased).map(|event| event.side).collect::<Vec<_>>())
    };
    for (distance, solver) in [
        (8.0, ["dormand_prince", "tolerance=1e-5"]),
        (8.0, ["generalised_alpha", "step=0.5 ms"]),
        (15.0, ["generalised_alpha", "step=0.1 ms"]),
        (15.0, ["generalised_alpha", "step=1 ms"]),
        (15.0, ["rk4", "step=0.1 ms"]),
        (15.0, ["real_time", "step=1 ms"]),
    ] {
        let [(eccf, order), (accf, found)] = ["ECCF", "ACCF"].map(|formulation| run(formulation, distance, solver));
        let apart = eccf.iter().zip(&accf).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{distance} m, {solver:?}: {apart:.1e} m, places cease {found:?}");
        assert_eq!(order, found, "{solver:?}");
        assert!(apart < 1e-6 && order.len() >= 4, "{solver:?}: {apart:e}");
    }
}

/// A place may cease to exist between an accepted step's end and the next step: what can be read there is what the run goes on with.
#[test]
fn hard_every_end_of_a_step_can_be_read_where_places_cease() {
    for (scene, until) in [("wheelset_s1002", 1.6), ("vehicle_manchester_1", 2.2)] {
        let deviations = ["left", "right"].map(|rail| {
            format!("{{rail=\"{rail}\", direction=\"lateral\", shape=\"cosine\", amplitude=\"8 mm\", from=\"10 m\", to=\"30 m\"}}")
        });
        let changes =
            ["contact.formulation=ACCF".into(), "contact.on_lift=elastic".into(), format!("track.deviation=[{}]", deviations.join(", "))];
        let scene = load::open(scene, &changes).unwrap_or_else(|error| panic!("{error}"));
        let mut simulation = Simulation::new(&scene, 0.0).unwrap_or_else(|error| panic!("{error}"));
        let bodies: Vec<usize> = simulation.model().wheelsets.iter().flat_map(|wheelset| [wheelset.body; 2]).collect();
        let (mut stops, mut ceased, mut foreseen) = (0, 0, 0);
        let mut before: (f64, Vec<f64>) = (f64::NAN, Vec::new());
        while simulation.time() < until {
            simulation.advance_to_stop(until).unwrap_or_else(|error| panic!("{error}"));
            let time = simulation.time();
            let snapshot = simulation.snapshot().unwrap_or_else(|error| panic!("stop {stops} at {time}: {error}"));
            assert!(snapshot.dy.iter().all(|rate| rate.is_finite()));
            let forces: Vec<f64> = (0..bodies.len()).map(|contact| snapshot.workspace.wheel_force(contact, bodies[contact]).z).collect();
            let gone = simulation.take_events().iter().filter(|event| event.change == ContactChange::Vanished).count();
            // Read once before the run has freed the wheel, and once after; a hand-over may move loads by 2 %.
            if gone > 0 && before.0 == time {
                let apart = before.1.iter().zip(&forces).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(apart < 1e3, "{time}: {:?} {forces:?}", before.1);
                println!("{time:.6} s: {apart:.0} N apart");
                foreseen += 1;
            }
            before = (time, forces);
            ceased += gone;
            stops += 1;
        }
        println!("{stops} stops, {ceased} places ceased, {foreseen} read before");
        assert!(ceased > 0 && foreseen > 0);
    }
}

/// A light wheelset on stiff guides over irregular track, whose left wheel loses its place at 0.60 s.
const IRREGULAR: &str = r#"
name = "irregular"

[vehicle]
template = "suspended_wheelset"
speed = [{ time = "0.3 s", speed = "8.63 m/s" }, { time = "1.5 s", speed = "6.77 m/s" }]
travel = "imposed"

[vehicle.wheelset]
mass = 800.0
inertia_xx = 479.1
inertia_yy = 50.52
inertia_zz = 479.1
vertical_load = 20000.0
tread_circle_distance = 1.5

[vehicle.wheelset.profile]
kind = "s1002"
radius = 0.361

[vehicle.suspension]
distance = 2.0
longitudinal_stiffness = 2e7
longitudinal_damping = 1e3
lateral_stiffness = 3e6
lateral_damping = 2e4

[track]
gauge = "1432 mm"
inclination = "1:40"

[track.rail]
kind = "uic60"

[[track.deviation]]
rail = "both"
direction = "lateral"
shape = "ramp"
amplitude = "1.149 mm"
from = 4.13
to = 7.13

[[track.irregularity]]
kind = "spectrum"
spectrum = "fra5"
seed = 464
from = 3.0
to = 300.0
fade = 4.0
scale = 0.6

[contact]
formulation = "ACCF"
on_lift = "elastic"
friction = 0.4
damping = 5e8

[contact.material]
youngs_modulus = 2.1e11
poisson_ratio = 0.28

[contact.creep]
law = "usetab"

[solver]
tolerance = 1e-5

[interface]
outputs = ["motion", "wheels"]

[run]
stop = 0.9
step = 1e-3
"#;

/// A wheel that tries to become a constraint again where the constraint has no solution stays elastic and tries later: the run ended there.
#[test]
fn regress_a_landing_without_a_solution_is_put_off() {
    let folder = tempfile::tempdir().unwrap_or_else(|error| panic!("{error}"));
    let path = folder.path().join("irregular.toml");
    std::fs::write(&path, IRREGULAR).unwrap_or_else(|error| panic!("{error}"));
    let lateral = |formulation: &str| {
        let change = format!("contact.formulation={formulation}");
        let scene = load::open_file(&path, "irregular", &[change]).unwrap_or_else(|error| panic!("{error}"));
        let mut simulation = Simulation::new(&scene, 0.0).unwrap_or_else(|error| panic!("{error}"));
        let y: Vec<f64> = (0..=900)
            .map(|row| {
                simulation.advance(1e-3 * f64::from(row)).unwrap_or_else(|error| panic!("{formulation}: {error}"));
                simulation.snapshot().unwrap_or_else(|error| panic!("{formulation}: {error}")).y[1]
            })
            .collect();
        let changes = simulation.take_events().iter().filter(|event| event.change.changes_mode()).count();
        (y, changes)
    };
    let (elastic, _) = lateral("ECF-A");
    for formulation in ["ACCF", "ECCF"] {
        let (rigid, changes) = lateral(formulation);
        let apart = rigid.iter().zip(&elastic).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{formulation}: {changes} changes; y within {:.3} mm of elastic contact", 1e3 * apart);
        assert!(changes > 2 && apart < 1e-4, "{formulation}: {changes}, {apart:.1e} m");
    }
}
