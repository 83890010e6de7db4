//! Nothing on the stepping path allocates: a counting allocator watches a run.

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

/// Counts the allocations of each thread.
struct Counting;

// The only way to watch the allocator; it hands everything on.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = COUNT.try_with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

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
        let before = COUNT.with(Cell::get);
        for i in 2..=100 {
            simulation.set_input(wheelrail::formulation::LATERAL_FORCE, f64::from(i), 10.0, 0.0);
            simulation.advance(0.01 * f64::from(i)).unwrap();
            let snapshot = simulation.snapshot().unwrap();
            assert!(outputs.iter().all(|output| output.value(snapshot).is_finite()));
        }
        let after = COUNT.with(Cell::get);
        assert_eq!(after - before, 0, "{changes:?}");
        let _seen = Box::new(changes.len());
        assert!(COUNT.with(Cell::get) > after, "the counter must count");
    }
}
