//! What is compared between two runs, and how far the runs are apart at equal times.
//!
//! Where the curvature of a rail jumps, the normal force of a rigid wheel jumps too: it has two values there, and rounding picks
//! one. A sample that falls on such a place says nothing about the difference of two runs and is left out.

use crate::formulation::Model;
use crate::sim::recording::Recording;
use crate::study::accuracy::is_smooth;

/// An output of the wheelset that is compared.
pub(super) struct Quantity {
    /// In file names and JSON.
    pub key: &'static str,
    pub output: &'static str,
    pub title: &'static str,
    pub unit: &'static str,
    /// Column of the table, and how many of its units an SI unit has: differences are small.
    pub column: (&'static str, f64),
    /// Axis of its picture, likewise.
    pub axis: (&'static str, f64),
}

const fn quantity([key, output, title, unit]: [&'static str; 4], column: (&'static str, f64), axis: (&'static str, f64)) -> Quantity {
    Quantity { key, output, title, unit, column, axis }
}

/// Lateral displacement, yaw and normal forces as in the paper's Figs. 7-10, 12-14 and 18-24, and the height. An output that the
/// model does not have (a second contact) is left out.
pub(super) const QUANTITIES: [Quantity; 6] = [
    quantity(["lateral_displacement", "y", "Lateral displacement", "m"], ("y [um]", 1e6), ("y [mm], left positive", 1e3)),
    quantity(["yaw", "yaw", "Yaw", "rad"], ("yaw [urad]", 1e6), ("yaw [mrad], nose left positive", 1e3)),
    quantity(["height", "z", "Height", "m"], ("z [um]", 1e6), ("z [mm]", 1e3)),
    quantity(
        ["normal_force_right", "right.normalForce", "Normal force of the right wheel", "N"],
        ("N right [N]", 1.0),
        ("N right [kN]", 1e-3),
    ),
    quantity(["normal_force_left", "left.normalForce", "Normal force of the left wheel", "N"], ("N left [N]", 1.0), ("N left [kN]", 1e-3)),
    quantity(
        ["second_contact_right", SECOND_PLACE, "Normal force of the right wheel's second place", "N"],
        ("N2 right [N]", 1.0),
        ("N of the less loaded place, right [kN]", 1e-3),
    ),
];

/// The second largest of the normal forces of the right wheel's places. Not that of its contact 2: formulations number the places of a wheel each in
/// its own way, and one that changes its number has not changed.
const SECOND_PLACE: &str = "right.contact[].normalForce";

/// The output groups that these quantities stand in.
pub(super) const GROUPS: [&str; 3] = ["motion", "wheels", "contacts"];

/// A recorded run.
#[derive(Default)]
pub(super) struct Samples {
    recording: Recording,
    /// For each row: does no wheel stand where the curvature of its rail jumps?
    smooth: Vec<bool>,
}

impl Samples {
    pub(super) fn new(recording: Recording, model: &Model) -> Samples {
        let smooth = is_smooth(&recording, model);
        Samples { recording, smooth }
    }

    pub(super) fn len(&self) -> usize {
        self.smooth.len()
    }

    /// Samples on a jump.
    pub(super) fn jumps(&self) -> usize {
        self.smooth.iter().filter(|smooth| !**smooth).count()
    }

    /// One quantity of a wheelset; empty when nothing was recorded.
    pub(super) fn trace(&self, wheelset: &str, quantity: &Quantity) -> Trace {
        let column = |name: &str| self.recording.column(name).unwrap_or_default();
        let output = |name: &str| column(&format!("{wheelset}.{name}"));
        let values = match quantity.output {
            SECOND_PLACE => second_largest(&self.contacts(wheelset)),
            name => output(name),
        };
        Trace { times: column("time"), distances: output("distance"), values, smooth: self.smooth.clone() }
    }

    /// Normal forces of all contacts of the right wheel, each over the rows.
    fn contacts(&self, wheelset: &str) -> Vec<Vec<f64>> {
        let name = |contact: usize| format!("{wheelset}.{}", SECOND_PLACE.replace("[]", &format!("[{contact}]")));
        (1..).map_while(|contact| self.recording.column(&name(contact))).collect()
    }
}

/// The second largest value of each row; nothing where there are no two columns.
fn second_largest(columns: &[Vec<f64>]) -> Vec<f64> {
    let [first, others @ ..] = columns else { return vec![] };
    if others.is_empty() {
        return vec![];
    }
    let row = |row: usize| {
        let both = |(most, second): (f64, f64), value: f64| (most.max(value), second.max(most.min(value)));
        columns.iter().map(|column| column[row]).fold((f64::NEG_INFINITY, f64::NEG_INFINITY), both).1
    };
    (0..first.len()).map(row).collect()
}

/// One quantity over time, s, and distance, m.
pub(super) struct Trace {
    times: Vec<f64>,
    distances: Vec<f64>,
    values: Vec<f64>,
    smooth: Vec<bool>,
}

impl Trace {
    /// Values over distance.
    pub(super) fn points(&self) -> Vec<(f64, f64)> {
        self.distances.iter().copied().zip(self.values.iter().copied()).collect()
    }

    /// Is there nothing to be seen: no values, or zeros alone?
    pub(super) fn is_idle(&self) -> bool {
        self.values.iter().all(|value| *value == 0.0)
    }

    /// Largest change since the start; `None` when nothing was recorded.
    pub(super) fn change(&self) -> Option<f64> {
        let first = self.values.first()?;
        self.values.iter().map(|value| (value - first).abs()).reduce(f64::max)
    }

    /// This minus the other at equal times as (time, distance, difference), as long as both lasted.
    fn differences(&self, other: &Trace) -> impl Iterator<Item = (f64, f64, f64)> {
        let both = self.values.iter().zip(&other.values);
        let smooth = self.smooth.iter().zip(&other.smooth).map(|(a, b)| *a && *b);
        let places = self.times.iter().zip(&self.distances);
        both.zip(smooth).zip(places).filter(|((_, smooth), _)| *smooth).map(|(((a, b), _), (time, x))| (*time, *x, a - b))
    }

    /// This minus the other over distance.
    pub(super) fn minus(&self, other: &Trace) -> Vec<(f64, f64)> {
        self.differences(other).map(|(_, x, difference)| (x, difference)).collect()
    }

    /// How far the two are apart; `None` when they share no time.
    pub(super) fn apart(&self, other: &Trace) -> Option<Apart> {
        let (mut count, mut squares) = (0.0, 0.0);
        let mut largest: Option<Apart> = None;
        for (time, distance, difference) in self.differences(other) {
            (count, squares) = (count + 1.0, squares + difference * difference);
            if largest.is_none_or(|known| difference.abs() > known.largest) {
                largest = Some(Apart { largest: difference.abs(), time, distance, rms: 0.0 });
            }
        }
        largest.map(|apart| Apart { rms: (squares / count).sqrt(), ..apart })
    }
}

/// Distance between two traces, SI.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub(super) struct Apart {
    pub largest: f64,
    /// Where the largest difference is, s and m.
    pub time: f64,
    pub distance: f64,
    /// Root mean square over the samples.
    pub rms: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(values: &[f64]) -> Trace {
        let times: Vec<f64> = (0..values.len()).map(|i| 0.5 * i as f64).collect();
        let (distances, smooth) = (times.iter().map(|t| 40.0 * t).collect(), vec![true; values.len()]);
        Trace { distances, times, values: values.to_vec(), smooth }
    }

    #[test]
    fn analytic_largest_difference_its_place_and_rms() {
        let apart = trace(&[1.0, 2.0, 3.0, 4.0]).apart(&trace(&[1.0, 5.0, 3.0, 8.0])).unwrap();
        assert_eq!((apart.largest, apart.time, apart.distance, apart.rms), (4.0, 1.5, 60.0, 2.5));
    }

    #[test]
    fn prop_a_place_that_changes_its_number_changes_nothing() {
        let [tread, flange, none] = [[50.0, 40.0, 30.0], [0.0, 45.0, 20.0], [0.0; 3]].map(Vec::from);
        let other = [vec![50.0, 45.0, 0.0], vec![0.0, 40.0, 30.0], vec![0.0, 0.0, 20.0]];
        assert_eq!(second_largest(&[tread.clone(), flange, none]), vec![0.0, 40.0, 20.0]);
        assert_eq!(second_largest(&other), vec![0.0, 40.0, 20.0]);
        assert!(second_largest(&[tread]).is_empty() && second_largest(&[]).is_empty());
    }

    #[test]
    fn analytic_change_is_counted_from_the_start() {
        assert_eq!(trace(&[5.0, 6.0, 2.0]).change(), Some(3.0));
    }

    #[test]
    fn prop_a_sample_on_a_jump_of_either_run_is_left_out() {
        let (mut jumps, other) = (trace(&[0.0, 50.0, 2.0]), trace(&[0.0, 0.0, 0.0]));
        jumps.smooth[1] = false;
        assert_eq!((jumps.apart(&other).unwrap().largest, other.apart(&jumps).unwrap().largest), (2.0, 2.0));
        assert_eq!(jumps.minus(&other), vec![(0.0, 0.0), (40.0, 2.0)]);
    }

    /// The embedded scene's deviation ends at 20 m and 30 m on the right rail.
    #[test]
    fn prop_samples_on_the_ends_of_a_deviation_are_found() {
        let scene = crate::scene::load::open("suspended_wheelset", &["contact.formulation=ECCF".into()]).unwrap();
        let mut simulation = crate::sim::Simulation::new(&scene, 0.0).unwrap();
        let outputs = crate::sim::outputs::outputs(simulation.model(), &GROUPS);
        let recording = crate::sim::recording::record(&mut simulation, &outputs, 0.8, 0.1, |_| {}).unwrap();
        let samples = Samples::new(recording, simulation.model());
        let places: Vec<f64> = samples.trace("wheelset", &QUANTITIES[0]).points().iter().map(|point| point.0).collect();
        let jumps: Vec<f64> = places.iter().zip(&samples.smooth).filter(|(_, smooth)| !**smooth).map(|(place, _)| *place).collect();
        println!("samples on jumps: {jumps:?}");
        assert!(samples.len() == 9 && samples.jumps() == 1 && (jumps[0] - 20.0).abs() < 1e-6, "{jumps:?}");
    }

    #[test]
    fn hard_a_run_that_ended_early_is_compared_as_far_as_it_went() {
        let long = trace(&[0.0, 1.0, 100.0]);
        let short = trace(&[0.0, 3.0]);
        assert_eq!(long.apart(&short).unwrap().largest, 2.0);
        assert_eq!(short.apart(&long).unwrap().largest, 2.0);
        assert!(long.apart(&trace(&[])).is_none() && trace(&[]).apart(&long).is_none() && trace(&[]).change().is_none());
    }

    #[test]
    fn prop_every_quantity_is_an_output_of_the_embedded_scene() {
        let scene = crate::scene::load::open("wheelset_s1002", &[]).unwrap();
        let simulation = crate::sim::Simulation::new(&scene, 0.0).unwrap();
        let outputs = crate::sim::outputs::outputs(simulation.model(), &GROUPS);
        for name in QUANTITIES.iter().map(|quantity| quantity.output.replace("[]", "[2]")).chain(["distance".into()]) {
            assert!(outputs.iter().any(|output| output.name == format!("wheelset.{name}")), "{name}");
        }
    }
}
