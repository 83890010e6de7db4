//! Swings of bodies on smooth track, at the default tolerance: those that nothing damps last, and those that are damped fade as they should.

use crate::common;
use wheelrail::scene::load;
use wheelrail::study::modes::modes;

/// Rate of a swing's envelope between two instants that are whole periods apart, 1/s: from its extremes within a period about each.
fn rate(times: &[f64], values: &[f64], period: f64, [from, to]: [f64; 2]) -> f64 {
    let swing = |at: f64| {
        let near = times.iter().zip(values).filter(|(t, _)| (**t - at).abs() < 0.5 * period).map(|(_, value)| *value);
        let (low, high) = near.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        high - low
    };
    (swing(to) / swing(from)).ln() / (to - from)
}

/// A two-axle wagon bounces by 2 mm after a wave of its track. (Without the bound: -0.027 for 0 and -0.3 for -0.16 1/s, and nothing left after 15 s.)
#[test]
fn analytic_cars_bounce_on_smooth_track_as_their_eigenvalues_say() {
    let path = common::data("two_axle_wagon.toml");
    for (damping, fall) in [(0.0, 20.0), (1600.0, 15.0), (8000.0, 5.0)] {
        let springs = [1, 2].map(|k| format!("vehicle.force[p{k}].damping=[3e4, 3e4, {damping}]"));
        let scene = load::open(path.to_str().unwrap(), &springs).unwrap_or_else(|error| panic!("{error}"));
        let all = modes(&scene, scene.vehicle.speed).unwrap();
        let bounce = all.modes.iter().find(|mode| mode.name == "car: bounce").unwrap();
        let recording = common::run(&scene, fall + 1.0, 0.01);
        let column = |name: &str| recording.column(name).unwrap_or_else(|| panic!("no column {name}"));
        let (times, heights) = (column("time"), column("car.z"));
        let period = 1.0 / bounce.frequency;
        let found = rate(&times, &heights, period, [3.0, 3.0 + period * ((fall - 3.0) / period).round()]);
        println!("{damping} N s/m: {found:.4} 1/s, eigenvalue {:.4}", bounce.growth);
        assert!((found - bounce.growth).abs() < 1.5e-3 - 0.06 * bounce.growth, "{found} {}", bounce.growth);
    }
}

/// Locked wheels swing on the springs of their brakes, which dry friction that falls with the slip keeps up for long: the default fades as an explicit method at 1e-9. (Without the bound of such
/// twists: 399 for 1978 N m after nine seconds.)
#[test]
fn equiv_locked_wheels_swing_on_their_brakes_at_the_default_tolerance() {
    let path = common::data("locked_truck.toml");
    let swing = |changes: &[&str]| {
        let locked = ["vehicle.force[brake[1]].torque=40000", "vehicle.force[brake[2]].torque=40000"];
        let changes: Vec<String> = locked.iter().chain(changes).map(ToString::to_string).collect();
        let scene = load::open(path.to_str().unwrap(), &changes).unwrap_or_else(|error| panic!("{error}"));
        let recording = common::run(&scene, 7.2, 0.002);
        let (times, torques) = (recording.column("time").unwrap(), recording.column("brake[1].torque").unwrap());
        [3.0, 5.0, 7.0].map(|from| {
            let near = times.iter().zip(&torques).filter(|(t, _)| (from..from + 0.2).contains(*t)).map(|(_, torque)| *torque);
            let (low, high) = near.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), torque| (low.min(torque), high.max(torque)));
            high - low
        })
    };
    let (usual, exact) = (swing(&[]), swing(&["solver.integrator=dormand_prince", "solver.tolerance=1e-9"]));
    println!("peak to peak after 3, 5, 7 s: {usual:.0?} N m, explicitly {exact:.0?}");
    assert!(exact[2] > 500.0 && usual.iter().zip(&exact).all(|(usual, exact)| (usual / exact - 1.0).abs() < 0.15));
}
