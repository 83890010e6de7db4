//! The contact geometry as CSV, in words and as JSON.

use super::{Conicities, Elastic, Study};
use crate::cli::{file_names, notes, table};
use crate::geometry::Side;
use crate::scene::profile_notes::profile_doubts;
use crate::study::conicity::{Conicity, NoConicity, wavelength};
use crate::study::contact_geometry::{Stand, Touch};
use serde_json::{Value, json};
use std::io::Write;
use std::path::PathBuf;

/// Columns of one contact: name, unit, value.
type Column = (&'static str, &'static str, fn(&Touch) -> f64);
const CONTACT: [Column; 5] = [
    ("wheelCoordinate", "m", |touch| touch.wheel),
    ("railCoordinate", "m", |touch| touch.rail),
    ("angle", "rad", |touch| touch.angle),
    ("rollingRadius", "m", |touch| touch.rolling_radius),
    ("lead", "m", |touch| touch.lead),
];
/// Of a second place that is near; empty where there is none.
const NEAR: [Column; 3] =
    [("wheelCoordinate", "m", |touch| touch.wheel), ("railCoordinate", "m", |touch| touch.rail), ("gap", "m", |touch| touch.distance)];

/// Every lateral shift that was asked for, and both sides of each jump.
pub(super) fn csv(study: &Study, writer: impl Write) -> csv::Result<()> {
    let mut csv = csv::Writer::from_writer(writer);
    let name = &study.scene.vehicle.leading().name;
    let level = study.wheelset.attitude.level;
    let mut head = vec![format!("{name}.y [m]"), format!("{name}.rollingRadiusDifference [m]")];
    if level {
        head.extend(Side::BOTH.map(|side| format!("{name}.{}.z [m]", side.name())));
    } else {
        head.extend([format!("{name}.z [m]"), format!("{name}.roll [rad]")]);
    }
    for side in Side::BOTH {
        head.extend(CONTACT.iter().map(|(column, unit, _)| format!("{name}.{}.contact[1].{column} [{unit}]", side.name())));
        head.extend(NEAR.iter().map(|(column, unit, _)| format!("{name}.{}.contact[2].{column} [{unit}]", side.name())));
    }
    head.extend(study.elastic.iter().map(|_| format!("{name}.elasticRollingRadiusDifference [m]")));
    csv.write_record(&head)?;
    let mut elastic = study.elastic.as_ref().map(|elastic| elastic.differences.iter());
    for sample in study.sweep.shown() {
        let stand = &sample.stand;
        let mut row = vec![stand.y, stand.radius_difference(), stand.height[0], if level { stand.height[1] } else { stand.roll }]
            .into_iter()
            .map(|value| format!("{value:?}"))
            .collect::<Vec<_>>();
        for side in [0, 1] {
            row.extend(CONTACT.iter().map(|column| format!("{:?}", (column.2)(&stand.contacts[side]))));
            row.extend(
                NEAR.iter().map(|column| stand.near[side].as_ref().map_or(String::new(), |touch| format!("{:?}", (column.2)(touch)))),
            );
        }
        if let Some(elastic) = &mut elastic {
            // At the shifts that were asked for, not at both sides of jumps between them.
            let found = if sample.asked { elastic.next() } else { None };
            row.push(found.map_or(String::new(), |(_, difference)| format!("{difference:?}")));
        }
        csv.write_record(&row)?;
    }
    csv.flush()?;
    Ok(())
}

fn millimetres(value: f64) -> String {
    format!("{:.3}", if (1e3 * value).abs() < 5e-4 { 0.0 } else { 1e3 * value })
}

fn value(found: Result<Conicity, NoConicity>) -> String {
    found.map_or_else(|_| "-".into(), |found| format!("{:.4}", found.value))
}

/// NP in words.
fn nonlinearity(found: Result<f64, NoConicity>) -> String {
    let found = found.map_or_else(|_| "-".into(), |found| format!("{:.4} 1/mm", 1e-3 * found));
    format!("nonlinearity parameter NP (lambda at 4 mm less lambda at 2 mm, over 2 mm; EN 15302:2021): {found}")
}

/// The whole text for a person.
pub(super) fn text(study: &Study) -> String {
    let (scene, wheelset) = (study.scene, study.wheelset);
    let attitude = wheelset.attitude;
    let [left, right] = [Side::Left, Side::Right]
        .map(|side| format!("{} on {}", wheelset.wheels[side.index()].profile.describe(), wheelset.track.rail(side).profile.describe()));
    let pairs = if left == right { left } else { format!("left {left}; right {right}") };
    let mut text = format!(
        "{}\n\n  {pairs}\n  tread circles {:.3} mm apart, rail sections {:.3} mm apart{} and inclined by {:.4} rad\n  {}, yaw {} mrad\n\n",
        scene.title,
        1e3 * wheelset.tread_circle_distance(),
        2e3 * scene.track.half_rail_distance,
        scene.track.gauge().map_or(String::new(), |gauge| format!(" (gauge {:.2} mm)", 1e3 * gauge)),
        scene.track.inclination,
        if attitude.level { "axle held level" } else { "both wheels touch: roll and height are found" },
        1e3 * attitude.yaw
    );
    text += &shifts(study);
    text += &jumps(study);
    text += &notes(doubts(study));
    text += &conicities(study);
    text
}

/// What a user should know of the profiles and of the shifts.
fn doubts(study: &Study) -> Vec<String> {
    profile_doubts(study.scene).into_iter().chain(study.elastic.as_ref().and_then(Elastic::note)).collect()
}

/// One row per millimetre.
fn shifts(study: &Study) -> String {
    let head = [
        "y [mm]",
        "dr [mm]",
        "u left",
        "u right",
        "eta left",
        "eta right",
        "angle left [deg]",
        "angle right [deg]",
        "roll [mrad]",
        "z [mm]",
    ];
    let centred = study.sweep.nearest(0.0).height;
    let first = study.sweep.samples.first().map_or(0.0, |sample| sample.stand.y);
    let last = study.sweep.samples.last().map_or(0.0, |sample| sample.stand.y);
    let rows: Vec<Vec<String>> = ((1e3 * first - 1e-6).ceil() as i64..=(1e3 * last + 1e-6).floor() as i64)
        .filter_map(|mm| {
            let stand = study.sweep.nearest(1e-3 * mm as f64);
            let at = (stand.y - 1e-3 * mm as f64).abs() < 0.5 * study.step;
            at.then(|| shift(stand, &centred))
        })
        .collect();
    format!(
        "Lateral shift (left positive), rolling-radius difference (left minus right), contacts u and eta in mm outward\n\n{}",
        table(&head.map(String::from), &rows)
    )
}

fn shift(stand: &Stand, centred: &[f64; 2]) -> Vec<String> {
    let [left, right] = &stand.contacts;
    let degrees = |touch: &Touch| format!("{:.2}", touch.angle.to_degrees());
    let rise = 0.5 * (stand.height[0] - centred[0] + stand.height[1] - centred[1]);
    vec![
        millimetres(stand.y),
        millimetres(stand.radius_difference()),
        millimetres(left.wheel),
        millimetres(right.wheel),
        millimetres(left.rail),
        millimetres(right.rail),
        degrees(left),
        degrees(right),
        millimetres(stand.roll),
        millimetres(rise),
    ]
}

fn jumps(study: &Study) -> String {
    let jumps = study.sweep.jumps();
    if jumps.is_empty() {
        return "\nNo contact jumps.\n".into();
    }
    let head = ["Contact jumps", "y [mm]", "u from", "to", "eta from", "to", "radius by", "dr from", "to"].map(String::from);
    let rows: Vec<Vec<String>> = jumps
        .iter()
        .map(|jump| {
            let (a, b) = (&jump.before.contacts[jump.side.index()], &jump.after.contacts[jump.side.index()]);
            let lengths = [
                jump.before.y,
                a.wheel,
                b.wheel,
                a.rail,
                b.rail,
                b.rolling_radius - a.rolling_radius,
                jump.before.radius_difference(),
                jump.after.radius_difference(),
            ];
            [jump.side.name().to_string()].into_iter().chain(lengths.map(millimetres)).collect()
        })
        .collect();
    format!("\n{}", table(&head, &rows))
}

fn conicities(study: &Study) -> String {
    let (distance, radius) = (study.wheelset.tread_circle_distance(), study.wheelset.nominal_radius());
    let row = |at: &Conicities| {
        let length = at.en15302.ok().filter(|found| found.value > 0.0).map(|found| wavelength(found.value, distance, radius));
        let centre = at.en15302.or(at.harmonic).map_or_else(|_| "-".into(), |found| millimetres(found.centre));
        vec![
            millimetres(at.amplitude),
            value(at.en15302),
            value(at.harmonic),
            length.map_or_else(|| "-".into(), |length| format!("{length:.2}")),
            centre,
        ]
    };
    let head = ["amplitude [mm]", "EN 15302", "harmonic", "wavelength [m]", "about y [mm]"].map(String::from);
    let rows: Vec<Vec<String>> = study.table.iter().map(row).collect();
    let chosen = &study.chosen;
    let mut text = format!(
        "\nEquivalent conicity at {} mm: {} (EN 15302), {} (harmonic linearisation)\n  {}\n\n{}",
        millimetres(chosen.amplitude),
        value(chosen.en15302),
        value(chosen.harmonic),
        nonlinearity(study.nonlinearity),
        table(&head, &rows)
    );
    if let Some(elastic) = &study.elastic {
        let head = ["amplitude [mm]", "EN 15302", "harmonic"].map(String::from);
        let rows: Vec<Vec<String>> =
            elastic.table.iter().map(|at| vec![millimetres(at.amplitude), value(at.en15302), value(at.harmonic)]).collect();
        text += &format!(
            "\nElastic wheels and rails, {:.1} kN on each wheel, rolling on the centres of their patches: equivalent conicity at {} mm: {} (EN 15302), {} \
             (harmonic linearisation)\n  {}\n\n{}",
            1e-3 * elastic.load,
            millimetres(elastic.chosen.amplitude),
            value(elastic.chosen.en15302),
            value(elastic.chosen.harmonic),
            nonlinearity(elastic.nonlinearity),
            table(&head, &rows)
        );
    }
    let mut reasons: Vec<NoConicity> = study
        .table
        .iter()
        .chain([chosen])
        .flat_map(|at| [at.en15302.err(), at.harmonic.err()])
        .flatten()
        .chain(study.nonlinearity.err())
        .collect();
    reasons.sort_by_key(|reason| *reason as u8);
    reasons.dedup();
    for reason in reasons {
        text += &format!("  -: {reason}\n");
    }
    text
}

/// Everything in SI units.
pub(super) fn json(study: &Study, files: &[PathBuf]) -> Value {
    let touch = |touch: &Touch| {
        json!({
            "wheel_coordinate": touch.wheel, "rail_coordinate": touch.rail, "angle": touch.angle,
            "rolling_radius": touch.rolling_radius, "lead": touch.lead, "gap": touch.distance,
        })
    };
    let stand = |stand: &Stand| {
        json!({
            "y": stand.y, "height": stand.height, "roll": stand.roll, "rolling_radius_difference": stand.radius_difference(),
            "left": touch(&stand.contacts[0]), "right": touch(&stand.contacts[1]),
            "left_second": stand.near[0].as_ref().map(touch), "right_second": stand.near[1].as_ref().map(touch),
        })
    };
    let conicity = |at: &Conicities| {
        let words = |found: Result<Conicity, NoConicity>| match found {
            Ok(found) => json!({"value": found.value, "centre": found.centre}),
            Err(reason) => json!({"value": null, "reason": reason.to_string()}),
        };
        json!({"amplitude": at.amplitude, "en15302": words(at.en15302), "harmonic": words(at.harmonic)})
    };
    let jumps: Vec<Value> = study
        .sweep
        .jumps()
        .iter()
        .map(|jump| json!({"side": jump.side.name(), "before": stand(&jump.before), "after": stand(&jump.after)}))
        .collect();
    json!({
        "scene": study.scene.name, "title": study.scene.title,
        "yaw": study.wheelset.attitude.yaw, "roll": if study.wheelset.attitude.level { "zero" } else { "found" },
        "tread_circle_distance": study.wheelset.tread_circle_distance(), "nominal_radius": study.wheelset.nominal_radius(),
        "conicity": conicity(&study.chosen), "conicities": study.table.iter().map(conicity).collect::<Vec<_>>(),
        "nonlinearity": study.nonlinearity.ok(),
        "elastic": study.elastic.as_ref().map(|elastic| json!({
            "load": elastic.load, "conicity": conicity(&elastic.chosen), "conicities": elastic.table.iter().map(conicity).collect::<Vec<_>>(),
            "nonlinearity": elastic.nonlinearity.ok(),
            "rolling_radius_difference": elastic.differences,
        })),
        "jumps": jumps, "shifts": study.sweep.shown().map(|sample| stand(&sample.stand)).collect::<Vec<_>>(),
        "doubts": doubts(study),
        "ended_early": study.sweep.ended.iter().flatten().map(ToString::to_string).collect::<Vec<_>>(),
        "pictures": file_names(files),
    })
}
