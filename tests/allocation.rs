//! Nothing on the stepping path allocates: a counting allocator watches a run.

mod common;
#[path = "common/counting.rs"]
mod counting;

#[test]
fn prop_stepping_and_looking_do_not_allocate() {
    for changes in [
        &[][..],
        &["solver.integrator=rk43"],
        &["solver.integrator=rk4", "solver.step=0.001"],
        &["solver.integrator=rosenbrock"],
        &["solver.integrator=imex"],
        &["solver.integrator=generalised_alpha", "solver.step=0.001"],
        &["solver.integrator=zhai", "solver.step=0.001"],
        &["solver.integrator=real_time", "solver.step=0.001"],
        &["contact.formulation=ECCF"],
        &["contact.formulation=ACCF"],
        &["contact.formulation=ECF-N"],
        &["contact.patch=linear"],
        &["contact.patch=linear", "solver.integrator=rosenbrock"],
    ] {
        let scene = common::scene(changes);
        let mut simulation = common::start(&scene);
        let outputs = common::table(&simulation, &scene);
        simulation.advance(0.01).unwrap();
        let before = counting::count();
        for i in 2..=100 {
            // Between jumps the input's slope goes on: what a step found is found again when the next call begins.
            if i % 3 == 0 {
                simulation.set_input(wheelrail::formulation::LATERAL_FORCE, f64::from(i), 10.0, 0.0);
            }
            simulation.advance(0.01 * f64::from(i)).unwrap();
            let snapshot = simulation.snapshot().unwrap();
            assert!(outputs.iter().all(|output| output.value(snapshot).is_finite()));
        }
        let after = counting::count();
        assert_eq!(after - before, 0, "{changes:?}");
        std::hint::black_box(Box::new(changes.len()));
        assert!(counting::count() > after, "the counter must count");
    }
}

/// Setting a parameter during a run may allocate; the steps behind it don't.
#[test]
fn prop_steps_behind_a_tuned_parameter_do_not_allocate() {
    let scene = common::scene(&[]);
    let mut simulation = common::start(&scene);
    let outputs = common::table(&simulation, &scene);
    simulation.advance(0.01).unwrap();
    let integrator = scene.solver.integrator.with_setting(1e-7);
    let mut other = scene.clone();
    other.contact.friction = 0.3;
    let constants = [(0, 2, 3e4)];
    simulation.tune(&wheelrail::sim::tuning::Tuning { scene: &other, integrator: &integrator, constants: &constants });
    assert_eq!(watched(&mut simulation, &outputs, 0.01).0, 0);
}

#[test]
fn prop_curves_do_not_allocate() {
    for formulation in ["ECF-A", "ECCF", "ACCF", "ECF-N"] {
        let file = common::data("scenes/curve.toml");
        let changes = [format!("contact.formulation={formulation}"), "vehicle.initial.distance=75".into()];
        let scene = wheelrail::scene::load::open(file.to_str().unwrap(), &changes).unwrap();
        let mut simulation = common::start(&scene);
        let outputs = common::table(&simulation, &scene);
        simulation.advance(0.01).unwrap();
        assert_eq!(watched(&mut simulation, &outputs, 0.01).0, 0, "{formulation}");
    }
}

/// Runs on from `begin` [s]; returns allocations and the number of contact events.
fn watched(simulation: &mut wheelrail::sim::Simulation, outputs: &[wheelrail::sim::outputs::Output], begin: f64) -> (u64, u64) {
    let before = counting::count();
    for i in 1..=50 {
        simulation.set_input(wheelrail::formulation::DRIVE_TORQUE, f64::from(i), 10.0, 0.0);
        simulation.advance(begin + 0.01 * f64::from(i)).unwrap();
        let snapshot = simulation.snapshot().unwrap();
        assert!(outputs.iter().all(|output| output.value(snapshot).is_finite()));
    }
    let after = counting::count();
    (after - before, simulation.take_events().len() as u64)
}

#[test]
fn prop_searches_for_contacts_and_transient_contact_do_not_allocate() {
    let apta = common::data("scenes/apta_flange.toml");
    let apta = apta.to_str().unwrap();
    const BOTH: &[&str] = &["ECF-A", "ECCF"];
    // Scene, lateral force [N] that is on for 2 s before, changes, formulations, whether its flange must press.
    type Case<'a> = (&'a str, f64, &'a [&'a str], &'a [&'a str], bool);
    let cases: &[Case] = &[
        ("wheelset_s1002", 0.0, &[], &["ECF-A"], false),
        ("wheelset_s1002", 0.0, &["contact.patch=strips"], &["ECF-A", "ECF-N"], false),
        ("wheelset_s1002", 0.0, &["contact.patch=table"], &["ECF-A"], false),
        ("wheelset_s1002", 0.0, &["track.flexibility=beam"], &["ECF-A", "ECF-N"], false),
        ("wheelset_standstill", 0.0, &[], BOTH, false),
        ("wheelset_standstill", 0.0, &["vehicle.speed=0"], BOTH, false),
        (apta, 25e3, &[], BOTH, true),
        (apta, 0.0, &["vehicle.initial.vy=1"], BOTH, false),
    ];
    for (name, force, changes, formulations, flange) in cases {
        for &formulation in *formulations {
            let mut all = vec![format!("contact.formulation={formulation}")];
            if formulation == "ECCF" {
                all.push("contact.on_lift=elastic".into());
            }
            all.extend(changes.iter().map(|change| (*change).to_string()));
            let scene = wheelrail::scene::load::open(name, &all).unwrap();
            let mut simulation = common::start(&scene);
            let outputs = common::table(&simulation, &scene);
            let mut begin = 1e-3;
            if *force != 0.0 {
                simulation.set_input(wheelrail::formulation::LATERAL_FORCE, 0.0, force / 0.5, 0.0);
                simulation.advance(0.5).unwrap();
                simulation.set_input(wheelrail::formulation::LATERAL_FORCE, *force, 0.0, 0.0);
                begin = 2.0;
            }
            simulation.advance(begin).unwrap();
            simulation.take_events();
            let (found, events) = watched(&mut simulation, &outputs, begin);
            println!("{} {formulation} {changes:?}: {found} allocations, {events} events", scene.name);
            // An event carries a name and stands in a list that grows.
            assert!(found <= 2 * events, "{name} {formulation} {changes:?}: {found} allocations, {events} events");
            let pressed = common::read(&mut simulation, &outputs)["left.contact[2].normalForce"] > 0.0;
            assert!(pressed || !flange, "the flange must press");
        }
    }
}
