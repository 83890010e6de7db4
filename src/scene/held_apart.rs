//! Wheelsets whose speeds are imposed keep their distance along the track; in curves the bodies between them ask for more.
//!
//! A rigid body over two places c apart along a straight line needs an arc of `2 R asin(c / (2 R)) = c + c^3 / (24 R^2)` between them.

use super::oversights::way;
use super::spec::Scene;

/// What goes without a word, m: suspensions along the track of 1 to 5 kN/mm make at most some kilonewtons of it.
const STRAIN: f64 = 5e-4;

pub(super) fn held_apart(scene: &Scene) -> Option<String> {
    let vehicle = &scene.vehicle;
    let mut driven: Vec<(f64, &str)> = vehicle
        .wheelsets
        .iter()
        .filter(|wheelset| vehicle.speed_imposed && wheelset.driven)
        .map(|wheelset| (wheelset.x, wheelset.spec.name.as_str()))
        .collect();
    driven.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [(behind, second), (ahead, first)] =
        driven.windows(2).map(|pair| [pair[0], pair[1]]).max_by(|a, b| (a[1].0 - a[0].0).total_cmp(&(b[1].0 - b[0].0)))?;
    let distance = ahead - behind;
    let curvature = sharpest(scene)?;
    let strain = distance.powi(3) * curvature * curvature / 24.0;
    (strain > STRAIN).then(|| {
        format!(
            "vehicle.drive = \"all\": {first} and {second}, whose speeds are imposed, stay {distance:.1} m apart along the track, where a curve of {:.0} m asks for {:.1} mm more: springs along the \
             track take that up, and the drivingForce of one pushes against the other's (a coach whose rods have 5 kN/mm: by 17 kN in R 300 m, 43 kN in R 150 m, where Y of leading outer wheels is \
             3 and 7 % off, of others up to 19 %); vehicle.drive = \"leading\" or travel = \"free\" lets them",
            1.0 / curvature,
            1e3 * strain
        )
    })
}

/// The sharpest curvature that the vehicle comes to, 1/m.
fn sharpest(scene: &Scene) -> Option<f64> {
    let nodes = &scene.track.alignment.as_ref()?.nodes;
    let [rear, front] = way(scene).unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let reached = |k: usize| {
        let begins = k.checked_sub(1).map_or(f64::NEG_INFINITY, |before| nodes[before].distance);
        let ends = nodes.get(k + 1).map_or(f64::INFINITY, |after| after.distance);
        begins < front && ends > rear
    };
    (0..nodes.len()).filter(|k| reached(*k)).map(|k| nodes[k].curvature.abs()).reduce(f64::max)
}
