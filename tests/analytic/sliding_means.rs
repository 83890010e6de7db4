//! Sliding means over 2 m (EN 14363) that a scene asks for by the output group "sliding_means".

use wheelrail::scene::load;
use wheelrail::sim::Simulation;
use wheelrail::sim::recording::{Recording, record};
use wheelrail::sim::vehicle_outputs::scene_outputs;

fn recorded(outputs: &str, step: f64) -> Recording {
    let overrides = [format!("interface.outputs=[{outputs}]")];
    let scene = load::open("wheelset_s1002", &overrides).unwrap();
    let mut simulation = Simulation::new(&scene, 0.0).unwrap();
    let outputs = scene_outputs(&scene, simulation.model());
    record(&mut simulation, &outputs, 0.8, step, |_| {}).unwrap()
}

/// Butterworth's filter of fourth order as two oscillators in series, Runge-Kutta with the step of the rows; it starts settled.
fn low_pass(values: &[f64], step: f64) -> Vec<f64> {
    let omega = std::f64::consts::TAU * 20.0;
    let damping = [1.0, 3.0].map(|k| (k * std::f64::consts::FRAC_PI_8).cos());
    let mut y = [values[0], 0.0, values[0], 0.0];
    let rate = |y: [f64; 4], q: f64| {
        let spring = |from: f64, at: f64, speed: f64, damping: f64| omega * omega * (from - at) - 2.0 * damping * omega * speed;
        [y[1], spring(q, y[0], y[1], damping[0]), y[3], spring(y[0], y[2], y[3], damping[1])]
    };
    let mut out = vec![y[2]];
    for pair in values.windows(2) {
        let moved = |k: [f64; 4], h: f64| -> [f64; 4] { std::array::from_fn(|i| y[i] + h * k[i]) };
        let middle = 0.5 * (pair[0] + pair[1]);
        let k1 = rate(y, pair[0]);
        let k2 = rate(moved(k1, 0.5 * step), middle);
        let k3 = rate(moved(k2, 0.5 * step), middle);
        let k4 = rate(moved(k3, step), pair[1]);
        y = std::array::from_fn(|i| y[i] + step / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        out.push(y[2]);
    }
    out
}

/// Against the trapezoidal rule over outputs at every 0.1 ms; the motion itself is the same to the last bit without the means.
#[test]
fn analytic_means_are_those_of_the_recorded_forces() {
    let run = recorded(r#""motion","wheels","sliding_means""#, 1e-4);
    let column = |name: &str| run.column(&format!("wheelset.{name}")).unwrap();
    let distance = column("distance");
    let sum: Vec<f64> = column("left.lateralForce").iter().zip(column("right.lateralForce")).map(|(a, b)| -(a + b)).collect();
    let cases = [
        (column("left.derailmentQuotient"), column("left.derailmentQuotientMeanUnfiltered"), column("left.derailmentQuotientMean"), 1.0),
        (column("right.derailmentQuotient"), column("right.derailmentQuotientMeanUnfiltered"), column("right.derailmentQuotientMean"), 1.0),
        (sum, column("trackShiftingForceMeanUnfiltered"), column("trackShiftingForceMean"), 5e4),
    ];
    for (values, unfiltered, filtered, scale) in cases {
        // The filter starts settled on the mean of the first step, not on its first value: it is looked at from 0.1 s on.
        for (values, means, first, tolerance) in [(&values, unfiltered, 10, 2e-4), (&low_pass(&values, 1e-4), filtered, 1000, 1e-5)] {
            let mut integral = vec![0.0];
            for i in 1..values.len() {
                integral.push(integral[i - 1] + 0.5 * (values[i] + values[i - 1]) * (distance[i] - distance[i - 1]));
            }
            let at = |s: f64| {
                let i = distance.partition_point(|d| *d < s).clamp(1, distance.len() - 1);
                let part = (s - distance[i - 1]) / (distance[i] - distance[i - 1]);
                integral[i - 1] + part * (integral[i] - integral[i - 1])
            };
            let (mut worst, mut largest) = (0.0f64, 0.0f64);
            for i in first..values.len() {
                let begin = (distance[i] - 2.0).max(distance[0]);
                let mean = (integral[i] - at(begin)) / (distance[i] - begin);
                worst = worst.max((mean - means[i]).abs() / scale);
                largest = largest.max(mean.abs() / scale);
            }
            println!("largest mean {largest:.4}, largest difference {worst:.1e}");
            assert!(largest > 1e-3 && worst < tolerance * (1.0 + largest), "{worst}");
        }
    }
    let plain = recorded(r#""motion","wheels""#, 1e-2);
    let with = recorded(r#""motion","wheels","sliding_means""#, 1e-2);
    for (name, _) in &plain.columns {
        assert_eq!(plain.column(name), with.column(name), "{name}");
    }
}

/// A saved state holds the filters: what is read after going back is the same to the last bit.
#[test]
fn prop_means_are_part_of_the_state() {
    let scene = load::open("wheelset_s1002", &[r#"interface.outputs=["motion","sliding_means"]"#.to_string()]).unwrap();
    let mut simulation = Simulation::new(&scene, 0.0).unwrap();
    let outputs = scene_outputs(&scene, simulation.model());
    let read = |simulation: &mut Simulation, until: f64| -> Vec<u64> {
        simulation.advance(until).unwrap();
        let snapshot = simulation.snapshot().unwrap();
        outputs.iter().map(|output| output.value(snapshot).to_bits()).collect()
    };
    read(&mut simulation, 0.303);
    let saved = simulation.state().clone();
    let first = read(&mut simulation, 0.5);
    assert!(simulation.restore(&saved));
    assert_eq!(first, read(&mut simulation, 0.5));
}
