//! Loads a scene, runs it and reads forces: `cargo run --release --example run_scene`.

use wheelrail::formulation::contact_index;
use wheelrail::geometry::Side;
use wheelrail::{Simulation, open};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // An embedded scene, or the path of a file; changes as with `--set`.
    let scene = open("vehicle_manchester_1", &["vehicle.speed=30 m/s".into()])?;
    let mut simulation = Simulation::new(&scene, 0.0)?;
    for i in 1..=10 {
        simulation.advance(0.1 * f64::from(i))?;
        let snapshot = simulation.snapshot()?;
        let loads = Side::BOTH.map(|side| snapshot.workspace.wheel_force(contact_index(0, side), 0).z);
        println!(
            "{:.1} s: leading wheelset at y = {:+.3} mm, wheels carry {:.2} and {:.2} kN",
            snapshot.time,
            1e3 * snapshot.y[1],
            1e-3 * loads[0],
            1e-3 * loads[1]
        );
    }
    Ok(())
}
