//! Does a result belong to the scene that it is held against?
//!
//! A file of results does not name its scene. What must fit whatever the vehicle does on its way: names of wheelsets, mean axle loads, and the balance across the track. With the
//! curvature kappa (left-hand positive), the cant angle phi (left rail up positive) and the speed v, over all wheelsets and some seconds,
//!
//! ```text
//! sum Y = sum Q (v^2 kappa / g + phi),
//! ```
//!
//! Y left positive, forces of the rails on the wheels. Couplers of a train in a curve, wind and forces from outside are not in it, nor the car body's own swing: they move the quotient by
//! some 0.01.

use super::known::{Axle, Vehicle};
use super::signals::Signals;

/// Part of an axle's static load by which its mean may be another one.
const LOAD: f64 = 0.15;
/// Lateral quotient by which windows may be off in the root of the mean of squares: 45 mm of cant.
const ACROSS: f64 = 0.03;
/// Length of a window, s.
const WINDOW: f64 = 2.0;

/// What does not fit, in words.
pub fn misfits(signals: &Signals, vehicle: &Vehicle) -> Vec<String> {
    let known = |name: &str| vehicle.axles.iter().any(|axle| axle.name == name);
    let strange: Vec<&str> = signals.owners(".left.verticalForce").into_iter().filter(|name| !known(name)).collect();
    if let Some(first) = strange.first() {
        return vec![format!("the scene has no wheelset \"{first}\" ({} such in the result)", strange.len())];
    }
    let load = vehicle.axles.iter().find_map(|axle| {
        let [left, right] = loads(signals, &axle.name)?;
        let mean = left.iter().chain(right).sum::<f64>() / left.len().max(1) as f64;
        let differs = (mean - axle.load).abs() > LOAD * axle.load;
        differs.then(|| format!("mean load of {}: {:.1} kN in the result, in the scene {:.1} kN", axle.name, 1e-3 * mean, 1e-3 * axle.load))
    });
    load.into_iter().chain(across(signals, vehicle)).collect()
}

/// What the scene has and the result lacks, by name, so that it is not looked at.
pub fn left_out(signals: &Signals, vehicle: &Vehicle) -> Vec<String> {
    let there = |column: String| signals.column(&column).is_some();
    let wears = !signals.owners(".wearNumber").is_empty();
    let whole = |axle: &Axle| {
        let forces = ["left", "right"].into_iter().flat_map(|side| ["lateralForce", "verticalForce"].map(|of| format!("{side}.{of}")));
        let worn = ["left.wearNumber".to_string(), "right.wearNumber".to_string()];
        forces.chain(["distance".to_string()]).chain(worn.into_iter().filter(|_| wears)).all(|of| there(format!("{}.{of}", axle.name)))
    };
    let axles = vehicle.axles.iter().filter(|axle| !whole(axle)).map(|axle| axle.name.clone());
    let sensors = vehicle.body_sensors.iter().map(|sensor| &sensor.name).chain(vehicle.frame_sensors.iter().map(|sensor| &sensor.name));
    let shown = |sensor: &&String| ["distance", "measuredAx", "measuredAy", "measuredAz"].iter().all(|of| there(format!("{sensor}.{of}")));
    axles.chain(sensors.filter(|sensor| !shown(sensor)).cloned()).collect()
}

fn loads<'a>(signals: &'a Signals, name: &str) -> Option<[&'a [f64]; 2]> {
    let column = |side: &str| signals.column(&format!("{name}.{side}.verticalForce"));
    Some([column("left")?, column("right")?])
}

/// The balance across the track.
fn across(signals: &Signals, vehicle: &Vehicle) -> Option<String> {
    let rows = signals.len();
    let (mut lateral, mut expected, mut vertical) = (vec![0.0; rows], vec![0.0; rows], vec![0.0; rows]);
    for axle in &vehicle.axles {
        let [left, right] = loads(signals, &axle.name)?;
        let column = |what: &str| signals.column(&format!("{}.{what}", axle.name));
        let (distance, y) = (column("distance")?, [column("left.lateralForce")?, column("right.lateralForce")?]);
        for k in 0..rows {
            let (before, after) = (k.saturating_sub(1), (k + 1).min(rows - 1));
            let speed = (distance[after] - distance[before]) / (signals.interval * (after - before).max(1) as f64);
            let (curvature, cant) = vehicle.track.at(distance[k]);
            let load = left[k] + right[k];
            lateral[k] += y[0][k] + y[1][k];
            expected[k] += load * (speed * speed * curvature / vehicle.track.gravity + cant);
            vertical[k] += load;
        }
    }
    let window = ((WINDOW / signals.interval).round() as usize).clamp(1, rows.max(1));
    let means: Vec<[f64; 2]> = (0..rows / window)
        .map(|k| {
            let of = |values: &[f64]| values[k * window..(k + 1) * window].iter().sum::<f64>();
            [of(&lateral) / of(&vertical), of(&expected) / of(&vertical)]
        })
        .collect();
    let off = (means.iter().map(|[is, shall]| (is - shall).powi(2)).sum::<f64>() / means.len().max(1) as f64).sqrt();
    let worst = means.iter().copied().max_by(|a, b| (a[0] - a[1]).abs().total_cmp(&(b[0] - b[1]).abs()))?;
    (off > ACROSS).then(|| {
        format!(
            "sum Y / sum Q over {WINDOW} s is {:.3} in the result where curvature, cant and speed ask for {:.3} (root mean square of the difference {off:.3})",
            worst[0], worst[1]
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::assess::guiding_angle::GuidingAngle;
    use crate::study::assess::known::Friction;
    use crate::study::assess::sections::Track;
    use std::fmt::Write;

    /// A wheelset of 100 kN on straight track, `across` of it to the left.
    fn found(name: &str, load: f64, across: f64) -> Vec<String> {
        let columns =
            ["distance [m]", "left.lateralForce [N]", "right.lateralForce [N]", "left.verticalForce [N]", "right.verticalForce [N]"];
        let mut text = String::from("time [s]");
        columns.iter().for_each(|column| write!(text, ",wheelset.{column}").unwrap());
        for k in 0..1000 {
            let t = 0.01 * f64::from(k);
            // A swing of 1 Hz is no curve.
            let y = 1e5 * (across + 0.1 * (std::f64::consts::TAU * t).sin());
            write!(text, "\n{t},{},{},1000,52000,48000", 20.0 * t, y - 1e3).unwrap();
        }
        let axle = Axle { name: name.into(), load, flange: [GuidingAngle { angle: 1.2, flank: 1.2 }; 2] };
        let track = Track { line: None, base: 1.5, gravity: 9.81 };
        let friction = Friction { coefficient: 0.3, map: None };
        let vehicle = Vehicle { car: None, axles: vec![axle], friction, body_sensors: vec![], frame_sensors: vec![], track };
        misfits(&Signals::read(text.as_bytes()).unwrap(), &vehicle)
    }

    #[test]
    fn prop_a_result_of_another_scene_is_noticed() {
        assert_eq!(found("wheelset", 1e5, 0.0), Vec::<String>::new());
        assert_eq!(found("wheelset", 1.05e5, 0.02), Vec::<String>::new());
        for (told, part) in [
            (found("wheelset", 1e5, 0.05), "sum Y / sum Q over 2 s is 0.050"),
            (found("wheelset", 1e5, -0.05), "-0.050"),
            (found("wheelset", 1.3e5, 0.0), "mean load of wheelset: 100.0 kN in the result, in the scene 130.0 kN"),
            (found("axle", 1e5, 0.0), "the scene has no wheelset \"wheelset\""),
        ] {
            assert!(told.len() == 1 && told[0].contains(part), "{told:?}");
        }
    }
}
