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

/// Against the trapezoidal rule over outputs at every 0.1 ms; the motion itself is the same to the last bit without the means.
#[test]
fn analytic_means_are_those_of_the_recorded_forces() {
    let run = recorded(r#""motion","wheels","sliding_means""#, 1e-4);
    let column = |name: &str| run.column(&format!("wheelset.{name}")).unwrap();
    let distance = column("distance");
    let sum: Vec<f64> = column("left.lateralForce").iter().zip(column("right.lateralForce")).map(|(a, b)| -(a + b)).collect();
    let cases = [
        (column("left.derailmentQuotient"), column("left.derailmentQuotientMean"), 1.0),
        (column("right.derailmentQuotient"), column("right.derailmentQuotientMean"), 1.0),
        (sum, column("trackShiftingForceMean"), 5e4),
    ];
    for (values, means, scale) in cases {
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
        for i in 10..values.len() {
            let begin = (distance[i] - 2.0).max(distance[0]);
            let mean = (integral[i] - at(begin)) / (distance[i] - begin);
            worst = worst.max((mean - means[i]).abs() / scale);
            largest = largest.max(mean.abs() / scale);
        }
        println!("largest mean {largest:.4}, largest difference {worst:.1e}");
        assert!(largest > 1e-3 && worst < 2e-4 * (1.0 + largest), "{worst}");
    }
    let plain = recorded(r#""motion","wheels""#, 1e-2);
    let with = recorded(r#""motion","wheels","sliding_means""#, 1e-2);
    for (name, _) in &plain.columns {
        assert_eq!(plain.column(name), with.column(name), "{name}");
    }
}
