//! Normal and creep force of one contact, without a vehicle: `cargo run --release --example contact_alone`.

use wheelrail::contact::Patch;
use wheelrail::contact::creep::{RollingContact, ShenHedrickElkins};
use wheelrail::contact::creepage::Creepage;
use wheelrail::{CreepLaw, Material};

fn main() {
    let steel = Material { youngs_modulus: 2.1e11, poisson_ratio: 0.28 };
    let law = ShenHedrickElkins::new(steel);
    println!("creepage    force of Shen, Hedrick and Elkins on the wheel");
    for i in 0..=8 {
        let longitudinal = 5e-4 * f64::from(i);
        let contact = RollingContact {
            patch: Patch { a: 6e-3, b: 4e-3 },
            normal_force: 80e3,
            friction: 0.3,
            creepage: Creepage { longitudinal, lateral: 0.0, spin: 0.0 },
            speed: 20.0,
        };
        println!("{longitudinal:8.4} {:11.0} N of {:.0} N", law.force(&contact).longitudinal, contact.bound());
    }
}
