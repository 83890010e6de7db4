//! Results assessed after a run, and the same quantities found while it runs.

use crate::common::run;
use wheelrail::scene::load;
use wheelrail::study::assess::filter::Filter;
use wheelrail::study::assess::signals::Signals;
use wheelrail::study::assess::statistics::sliding_means;

/// EN 14363's 2 m means: filtered digitally from rows every 2 ms, and by the run's own filter, whose input is the mean over a step: what rises comes half a step
/// later there, which is 0.05 m here.
#[test]
fn equiv_two_metre_means_after_a_run_and_within_it() {
    let scene = load::open("vehicle_curve", &["interface.outputs=[\"motion\",\"wheels\",\"sliding_means\"]".into()]).unwrap();
    let signals = Signals::of(&run(&scene, 5.0, 2e-3)).unwrap();
    let column = |name: &str| signals.column(&format!("truck[1].wheelset[1].{name}")).unwrap();
    let quotient = Filter::low_pass(20.0, signals.rate()).of(column("right.derailmentQuotient"));
    let (distance, within) = (column("distance"), column("right.derailmentQuotientMean"));
    let largest = within.iter().copied().fold(0.0, f64::max);
    let means = sliding_means(distance, &quotient, 2.0, 0.5);
    let apart = means.iter().map(|(at, mean)| {
        let k = distance.partition_point(|s| s < at).clamp(1, distance.len() - 1);
        let part = (at - distance[k - 1]) / (distance[k] - distance[k - 1]);
        (mean - within[k - 1] - part * (within[k] - within[k - 1])).abs()
    });
    let apart = apart.fold(0.0, f64::max);
    println!("{} means, largest {largest:.4}, apart {apart:.1e}", means.len());
    assert!(means.len() > 150 && largest > 0.05 && apart < 1e-3 * largest, "{largest} {apart}");
}
