use wheelrail::scene::load;
use wheelrail::sim::{Simulation, outputs::outputs};
#[test]
fn quick() {
    let scene = load::open("suspended_wheelset", &["solver.tolerance=1e-11".into()]).unwrap();
    let mut sim = Simulation::new(&scene, 0.0).unwrap();
    let outs = outputs(sim.model(), &scene.interface.outputs);
    let s = sim.snapshot().unwrap();
    for o in &outs { println!("{} {:?}", o.name, o.value(s)); }
    for t in [0.6, 0.75, 1.0, 2.0, 5.0] {
        sim.advance(t).unwrap();
        let s = sim.snapshot().unwrap();
        println!("{t} {:?} {:?}", s.y[1], s.y[3]);
    }
    println!("{:?}", sim.statistics());
    for tol in [1e-6, 1e-7,1e-8,1e-9] {
    let scene = load::open("suspended_wheelset", &[format!("solver.tolerance={tol}")]).unwrap();
    let mut sim = Simulation::new(&scene, 0.0).unwrap();
    let t0=std::time::Instant::now();
    sim.advance(5.0).unwrap();
    println!("{tol} {:?} {:?} {:?}", t0.elapsed(), sim.statistics(), sim.snapshot().unwrap().y[1]-9.595403664e-4);
    }
}
