//! A conical wheelset between springs, put together in code: `cargo run --release --example wheelset_in_code`.

use std::sync::Arc;
use wheelrail::contact::creep::ShenHedrickElkins;
use wheelrail::contact::normal::Hertz;
use wheelrail::contact::normal::damping::Proportional;
use wheelrail::contact::patch::PatchLaw;
use wheelrail::formulation;
use wheelrail::formulation::wheel_search::PreparedSearches;
use wheelrail::geometry::Side;
use wheelrail::geometry::profile::{Arch, Cone};
use wheelrail::geometry::surface::Wheel;
use wheelrail::geometry::track::{Rail, Track};
use wheelrail::mbs::body::Body;
use wheelrail::mbs::driving::DrivingConstraint;
use wheelrail::mbs::force::{Gravity, Guide, GuidedSpring};
use wheelrail::mbs::inertia::Inertia;
use wheelrail::mbs::system::System;
use wheelrail::solve::{Rosenbrock, StiffPart};
use wheelrail::{ContactLaws, Integrator, Material, Model, Parts, Simulation, Wheelset};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mass, gravity, radius, speed) = (9000.0, 9.81, 0.46, 20.0);
    let steel = Material { youngs_modulus: 2.1e11, poisson_ratio: 0.28 };
    let inertia = Inertia::Revolution { transverse: 700.0, axial: 100.0 };
    let springs = GuidedSpring {
        name: "suspension".into(),
        body: 0,
        distance: 2.0,
        longitudinal: Some(Guide { stiffness: 2e5, damping: 1e3 }),
        lateral: Some(Guide { stiffness: 1e5, damping: 1e3 }),
    };
    let system = System {
        bodies: vec![Body { name: "wheelset".into(), mass, inertia }],
        forces: vec![Box::new(Gravity { body: 0, mass, acceleration: gravity, grade: 0.0 }), Box::new(springs)],
        drives: vec![DrivingConstraint::constant(0, speed)],
        supported: Vec::new(),
        joints: Vec::new(),
        redundant: Vec::new(),
    };
    let wheel = |side| Wheel { side, profile: Arc::new(Cone { radius, slope: 0.05 }), half_spacing: 0.75 };
    let rail = |side| Rail::new(side, Arc::new(Arch { radius: 0.3 }), 0.75, 0.05, &[]);
    let parts = Parts {
        system,
        track: Track { left: rail(Side::Left), right: rail(Side::Right) },
        wheelsets: vec![Wheelset {
            name: "wheelset".into(),
            body: 0,
            turning: [0; 2],
            left: wheel(Side::Left),
            right: wheel(Side::Right),
            imposed_speed: Some(speed),
            static_wheel_load: 0.5 * mass * gravity,
        }],
        laws: ContactLaws {
            normal: Box::new(Hertz::over_the_patch(steel)),
            creep: Box::new(ShenHedrickElkins::new(steel)),
            damping: Box::new(Proportional(2e9)),
            transient: None,
            friction: 0.35,
            friction_map: None,
            material: steel,
            patch: PatchLaw::Strips,
        },
        points: 1,
        prepared: PreparedSearches::default(),
        prepared_tables: Default::default(),
    };
    let model = Model::new(parts, &formulation::algebraic())?;
    // x, y, z, yaw, roll, pitch and their rates: 2 mm aside, pressed into the rails by a little less than it will be.
    let start = vec![0.0, 2e-3, radius - 5e-5, 0.0, 0.0, 0.0, speed, 0.0, 0.0, 0.0, 0.0, speed / radius];
    let integrator: Arc<dyn Integrator> = Arc::new(Rosenbrock { tolerance: 1e-6, part: StiffPart::All });
    let mut simulation = Simulation::from_model(model, &integrator, start, 0.0)?;
    for i in 0..=10 {
        simulation.advance(0.1 * f64::from(i))?;
        let snapshot = simulation.snapshot()?;
        let loads: Vec<f64> = snapshot.workspace.contacts.iter().map(|contact| 1e-3 * contact.normal_force).collect();
        println!("{:.1} s: y = {:+.4} mm, N = {:.2} and {:.2} kN", snapshot.time, 1e3 * snapshot.y[1], loads[0], loads[1]);
    }
    Ok(())
}
