//! The limit table in words.

use crate::cli::table;
use crate::study::assess::quantity::VehicleKind;
use crate::study::assess::sections::Zone;
use crate::study::assess::{Assessment, Row, Verdict};

/// What the limits are of.
pub(super) fn vehicle(kind: VehicleKind) -> &'static str {
    match kind {
        VehicleKind::Passenger => "passenger vehicle",
        VehicleKind::Locomotive => "locomotive",
        VehicleKind::Freight => "freight wagon",
    }
}

/// Lines above the table.
pub(super) fn head(found: &Assessment) -> [String; 2] {
    let speed = |speed: f64| format!("{:.1} km/h", 3.6 * speed);
    let run = format!(
        "{:.1} s, {:.0} m, up to {} (admissible {}), results every {} ms; limits of a {}",
        found.duration,
        found.distance,
        speed(found.highest_speed),
        speed(found.admissible_speed),
        (1e6 * found.interval).round() / 1e3,
        vehicle(found.vehicle)
    );
    let zones = Zone::ALL.into_iter().filter_map(|zone| {
        let of: Vec<f64> = found.sections.iter().filter(|section| section.zone == zone).map(|section| section.to - section.from).collect();
        let length = of.first()?;
        Some(format!("{}: {} of {length:.0} m ({} wanted)", zone.words(), of.len(), zone.wanted()))
    });
    let zones: Vec<String> = zones.collect();
    let sections = if zones.is_empty() { "none: no stretch is long enough".into() } else { zones.join("; ") };
    [run, format!("Sections: {sections}")]
}

/// Cells of a row: quantity with unit, track, place, value, limit, verdict.
pub(super) fn cells(row: &Row) -> [String; 6] {
    let quantity = row.quantity;
    let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{:.*}", quantity.digits, quantity.factor * value));
    let zone = row.zone.map_or("", Zone::words);
    [
        format!("{} [{}]", quantity.name, quantity.unit),
        zone.into(),
        row.place.clone(),
        number(row.value),
        number(row.limit),
        row.verdict.words().into(),
    ]
}

/// Rows by their table, in order.
pub(super) fn groups(found: &Assessment) -> Vec<(&'static str, Vec<&Row>)> {
    let mut groups: Vec<(&'static str, Vec<&Row>)> = Vec::new();
    for row in &found.rows {
        match groups.iter_mut().find(|group| group.0 == row.quantity.group) {
            Some(group) => group.1.push(row),
            None => groups.push((row.quantity.group, vec![row])),
        }
    }
    groups
}

/// One line about all.
pub(super) fn verdict(found: &Assessment) -> String {
    let count = |verdict: Verdict| found.rows.iter().filter(|row| row.verdict == verdict).count();
    let failed: Vec<&str> = found.rows.iter().filter(|row| row.verdict == Verdict::Fail).map(|row| row.quantity.name).collect();
    let (passed, open) = (count(Verdict::Pass), count(Verdict::NotAssessable));
    let mut words = if failed.is_empty() {
        format!("{passed} limits kept, none exceeded")
    } else {
        format!("{passed} limits kept, {} exceeded: {}", failed.len(), failed.join("; "))
    };
    if open > 0 {
        words += &format!("; {open} not assessable");
    }
    words
}

pub(super) fn text(title: &str, input: &str, found: &Assessment) -> String {
    let [run, sections] = head(found);
    let mut text = format!("{input}: {title}\n  {run}\n  {sections}\n");
    for (group, rows) in groups(found) {
        let open = |row: &&&Row| row.verdict == Verdict::NotAssessable;
        let (open, told): (Vec<&Row>, Vec<&Row>) = rows.iter().partition(|row| open(row));
        text += &format!("\n{group}\n");
        if !told.is_empty() {
            let names = ["", "track", "where", "value", "limit", "verdict"].map(String::from);
            let lines = table(&names, &told.iter().map(|row| cells(row).to_vec()).collect::<Vec<_>>());
            let width = lines.lines().map(|line| line.chars().count()).max().unwrap_or(0);
            for (line, note) in lines.lines().zip(std::iter::once("").chain(told.iter().map(|row| row.note.as_str()))) {
                let pad = " ".repeat(width - line.chars().count());
                text += &format!("{}\n", format!("{line}{pad}  {note}").trim_end());
            }
        }
        // The same reason once.
        let mut reasons: Vec<(&str, Vec<&str>)> = Vec::new();
        for row in open {
            match reasons.iter_mut().find(|reason| reason.0 == row.note) {
                Some(reason) => reason.1.push(row.quantity.name),
                None => reasons.push((&row.note, vec![row.quantity.name])),
            }
        }
        for (reason, names) in reasons {
            text += &format!("  not assessable: {}\n    {reason}\n", names.join("; "));
        }
    }
    text + &format!("\n{}\n", verdict(found))
}
