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
        &["contact.formulation=ECCF"],
        &["contact.formulation=ACCF"],
        &["contact.formulation=ECF-N"],
    ] {
        let scene = common::scene(changes);
        let mut simulation = common::start(&scene);
        let outputs = common::table(&simulation, &scene);
        simulation.advance(0.01).unwrap();
        let before = counting::count();
        for i in 2..=100 {
            simulation.set_input(wheelrail::formulation::LATERAL_FORCE, f64::from(i), 10.0, 0.0);
            simulation.advance(0.01 * f64::from(i)).unwrap();
            let snapshot = simulation.snapshot().unwrap();
            assert!(outputs.iter().all(|output| output.value(snapshot).is_finite()));
        }
        let after = counting::count();
        assert_eq!(after - before, 0, "{changes:?}");
        let _seen = Box::new(changes.len());
        assert!(counting::count() > after, "the counter must count");
    }
}
