//! Brakes whose demand ramps take the momentum that their torque says.

use wheelrail::formulation::Model;
use wheelrail::scene::load;
use wheelrail::settings::Source;
use wheelrail::sim::Simulation;

/// A wagon of two wheelsets with a disc brake each.
const WAGON: &str = r#"
name="one"
[vehicle]
template = "free"
travel = "free"
speed = "72 km/h"
[vehicle.wheel_profile]
kind = "s1002"
radius = 0.46
[[vehicle.body]]
name = "car"
mass = 24000.0
inertia_xx = 30000.0
inertia_yy = 300000.0
inertia_zz = 300000.0
position = [0.0, 0.0, 1.8]
[[vehicle.wheelset]]
name = "ws[1]"
x = 4.0
mass = 1500.0
inertia_xx = 900.0
inertia_yy = 100.0
inertia_zz = 900.0
tread_circle_distance = 1.5
[[vehicle.wheelset]]
name = "ws[2]"
x = -4.0
mass = 1500.0
inertia_xx = 900.0
inertia_yy = 100.0
inertia_zz = 900.0
tread_circle_distance = 1.5
[[vehicle.force]]
name = "p[1]"
kind = "bushing"
mirrored = true
from = "car"
to = "ws[1]"
at = [4.0, 1.0, 0.46]
stiffness = [5.0e6, 3.0e6, 1.0e6]
damping = [20e3, 20e3, 40e3]
preload = "static"
[[vehicle.force]]
name = "p[2]"
kind = "bushing"
mirrored = true
from = "car"
to = "ws[2]"
at = [-4.0, 1.0, 0.46]
stiffness = [5.0e6, 3.0e6, 1.0e6]
damping = [20e3, 20e3, 40e3]
preload = "static"
[[vehicle.force]]
name = "d1"
kind = "brake"
type = "disc"
from = { body = "car", at = [4.0, 0.0, 0.8] }
to = { body = "ws[1]", at = [4.0, 0.0, 0.46] }
torque = 0
stiffness = "6 MN m/rad"
[[vehicle.force]]
name = "d2"
kind = "brake"
type = "disc"
from = { body = "car", at = [-4.0, 0.0, 0.8] }
to = { body = "ws[2]", at = [-4.0, 0.0, 0.46] }
torque = 0
stiffness = "6 MN m/rad"

[track]
gauge = "1435 mm"
inclination = "1:40"

[track.rail]
kind = "60e1"
[contact]
formulation = "ECF-A"
friction = 0.30
[contact.transient]
below = "2 m/s"
[contact.material]
youngs_modulus = 2.1e11
poisson_ratio = 0.28
[contact.creep]
law = "polach"
[interface]
inputs = ["elements"]
[run]
stop = 4.0
step = "5 ms"
"#;
/// N m/s, from 1 s to 2.5 s.
const RAMP: f64 = 5000.0 / 1.5;

/// How far the wagon has gone after 4 s, m, from a speed [m/s].
fn way(speed: f64, integrator: &str, tolerance: f64) -> f64 {
    let source = Source { file: "wagon.toml".into(), text: WAGON.into(), overridden: vec![], folder: None };
    let changes =
        [format!("vehicle.speed={speed:?}"), format!("solver.integrator={integrator}"), format!("solver.tolerance={tolerance:e}")];
    let mut simulation = Simulation::new(&load::read("wagon", source, &changes).unwrap(), 0.0).unwrap();
    let brakes = |model: &Model| [0, 1].map(|brake| model.first_element_input() + brake);
    let set = |simulation: &mut Simulation, value: f64, slope: f64| {
        for input in brakes(simulation.model()) {
            simulation.set_input(input, value, slope, 0.0);
        }
    };
    simulation.advance(1.0).unwrap();
    set(&mut simulation, 0.0, RAMP);
    simulation.advance(2.5).unwrap();
    set(&mut simulation, 5000.0, 0.0);
    simulation.advance(4.0).unwrap();
    simulation.snapshot().unwrap().y[0]
}

#[test]
fn hard_a_ramp_of_a_brake_takes_its_momentum_from_the_vehicle() {
    // Which step meets the brake's begin decides about the rest: over ten speeds 8e-7 to 1.9e-4, 1.2e-5 to 3.2e-5, 1e-8 to 1.3e-5 m. Without the bound's
    // slope in the steps: 7.2e-3, 3.1e-3, 8.3e-4 m.
    for speed in [20.0, 20.013, 20.104] {
        let right = way(speed, "dormand_prince", 1e-9);
        for (tolerance, allowed) in [(1e-5, 5e-4), (1e-6, 5e-5), (1e-7, 4e-5)] {
            let off = way(speed, "rosenbrock", tolerance) - right;
            println!("{speed} m/s, {tolerance:e}: off by {off:.1e} m of {right:.3}");
            assert!(off.abs() < allowed, "{speed} m/s, {tolerance:e}: {off:e}");
        }
    }
}
