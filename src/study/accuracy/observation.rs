//! What is kept of a run to be compared with another one: per wheelset y, accelerations, wheel loads, normal forces and Y/Q at common times.

use crate::formulation;
use crate::geometry::Side;
use crate::sim::outputs::{Output, outputs};
use crate::sim::recording::Recording;

/// A contact closer than this to a place where its rail's curvature jumps may be on either side of it, m.
const ON_JUMP: f64 = 1e-6;

/// For each row of a recording: does no wheel stand where the curvature of its rail jumps? There the normal force of a rigid wheel
/// has two values, and rounding picks one.
pub fn is_smooth(recording: &Recording, model: &formulation::Model) -> Vec<bool> {
    let mut smooth = vec![true; recording.rows.len()];
    for wheelset in &model.wheelsets {
        for side in Side::BOTH {
            let name = format!("{}.{}.contact[1].railDistance", wheelset.name, side.name());
            let places = recording.column(&name).unwrap_or_default();
            for (smooth, place) in smooth.iter_mut().zip(places) {
                *smooth &= !model.track.rail(side).has_break_near(place, ON_JUMP);
            }
        }
    }
    smooth
}

/// Outputs of a wheelset that are compared, in the order of the errors: y; of the left and the right wheel; of its centre.
const OBSERVED: [&[&str]; 5] = [
    &["y"],
    &["left.verticalForce", "right.verticalForce"],
    &["left.normalForce", "right.normalForce"],
    &["left.derailmentQuotient", "right.derailmentQuotient"],
    &["ay", "az"],
];

/// One wheelset over time, SI.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Trace {
    pub distance: Vec<f64>,
    /// Of each of the observed outputs.
    pub values: [Vec<Vec<f64>>; OBSERVED.len()],
}

impl Trace {
    pub(super) fn y(&self) -> &[f64] {
        self.values[0].first().map_or(&[], Vec::as_slice)
    }
}

/// A run on its output times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Observation {
    pub(super) smooth: Vec<bool>,
    /// Do forces jump with the state (places of rigid contacts)? A jump may come one sample sooner or later.
    pub(super) jumps: bool,
    pub(super) wheelsets: Vec<Trace>,
}

/// The outputs that an observation needs, no others: `wheelset` alone, or those of all.
pub(super) fn needed(model: &formulation::Model, wheelset: Option<&str>) -> Vec<Output> {
    const PLACES: [&str; 2] = ["left.contact[1].railDistance", "right.contact[1].railDistance"];
    let wanted = |name: &str| {
        model.wheelsets.iter().any(|known| {
            let Some(own) = name.strip_prefix(known.name.as_str()).and_then(|rest| rest.strip_prefix('.')) else { return false };
            let observed = own == "distance" || OBSERVED.iter().any(|names| names.contains(&own));
            PLACES.contains(&own) || observed && wheelset.is_none_or(|wheelset| wheelset == known.name)
        })
    };
    outputs(model, &["motion", "wheels", "contacts"]).into_iter().filter(|output| wanted(&output.name)).collect()
}

impl Observation {
    /// From a recording of [`needed`] outputs.
    pub(super) fn new(recording: &Recording, model: &formulation::Model) -> Observation {
        let trace = |wheelset: &formulation::Wheelset| {
            let column = |output: &str| recording.column(&format!("{}.{output}", wheelset.name)).unwrap_or_default();
            Trace { distance: column("distance"), values: OBSERVED.map(|names| names.iter().map(|name| column(name)).collect()) }
        };
        let wheelsets = model.wheelsets.iter().map(trace).filter(|trace| !trace.y().is_empty());
        Observation { smooth: is_smooth(recording, model), jumps: model.formulation.constrains(), wheelsets: wheelsets.collect() }
    }

    /// The longest mean hunting wavelength of a wheelset, m; `None` where none swings twice.
    pub fn wavelength(&self) -> Option<f64> {
        self.wheelsets.iter().filter_map(|trace| mean_wavelength(&crossings(trace), usize::MAX)).reduce(f64::max)
    }
}

/// A swing smaller than this is no hunting, m.
const SWING: f64 = 1e-5;

/// Distances at which y passes zero upward between swings to both sides, m.
pub(super) fn crossings(trace: &Trace) -> Vec<f64> {
    let mut found = Vec::new();
    // Where y was last below zero on its way up from a swing to the right.
    let (mut armed, mut passed) = (false, None);
    for (x, y) in trace.distance.windows(2).zip(trace.y().windows(2)) {
        armed |= y[0] < -SWING;
        if y[0] < 0.0 && y[1] >= 0.0 {
            passed = Some(x[0] - y[0] * (x[1] - x[0]) / (y[1] - y[0]));
        }
        if let (true, true, Some(place)) = (armed, y[1] > SWING, passed) {
            found.push(place);
            (armed, passed) = (false, None);
        }
    }
    found
}

/// Mean of the waves between the first `most` crossings, m; `None` for fewer than two waves.
pub(super) fn mean_wavelength(crossings: &[f64], most: usize) -> Option<f64> {
    let used = &crossings[..crossings.len().min(most)];
    match used {
        [first, _, .., last] => Some((last - first) / (used.len() - 1) as f64),
        _ => None,
    }
}
