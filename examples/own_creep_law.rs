//! A creep law of one's own in a scene: `cargo run --release --example own_creep_law`.

use std::sync::Arc;
use wheelrail::contact::creep::RollingContact;
use wheelrail::contact::creep::kalker::LinearTheory;
use wheelrail::contact::creepage::CreepForce;
use wheelrail::{CreepLaw, Material, Simulation, open};

/// Kalker's linear theory up to the friction bound, and not beyond it.
#[derive(Debug)]
struct Clipped(LinearTheory);

impl CreepLaw for Clipped {
    fn force(&self, contact: &RollingContact) -> CreepForce {
        let linear = self.0.force(contact.patch, contact.creepage);
        let size = linear.longitudinal.hypot(linear.lateral);
        let share = if size > contact.bound() { contact.bound() / size } else { 1.0 };
        CreepForce { longitudinal: share * linear.longitudinal, lateral: share * linear.lateral, spin_moment: linear.spin_moment }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = open("wheelset_s1002", &[])?;
    let lateral = |simulation: &mut Simulation| -> Result<f64, Box<dyn std::error::Error>> {
        simulation.advance(1.0)?;
        Ok(1e3 * simulation.snapshot()?.y[1])
    };
    let before = lateral(&mut Simulation::new(&scene, 0.0)?)?;
    scene.contact.creep = Arc::new(|material: Material| Box::new(Clipped(LinearTheory::new(material))));
    let after = lateral(&mut Simulation::new(&scene, 0.0)?)?;
    println!("y after 1 s: {before:+.4} mm with the scene's law, {after:+.4} mm with ours");
    Ok(())
}
