//! What a sweep found, in words and as JSON.

use super::table::{Columns, Row, with_unit};
use crate::cli::table;
use crate::study::variation::parameter::shown;
use crate::study::variation::single::State;
use serde_json::{Value, json};
use std::path::Path;

/// Extremes of a scalar over the runs that are ok: value and run.
pub(super) struct Extreme {
    pub name: String,
    pub unit: String,
    pub lowest: Option<(f64, usize)>,
    pub highest: Option<(f64, usize)>,
}

pub(super) struct Summary {
    pub states: Vec<(&'static str, usize)>,
    pub extremes: Vec<Extreme>,
    /// Values of each run in words.
    points: Vec<String>,
    /// The first few runs that are not ok: run, state, reason.
    faults: Vec<(usize, &'static str, String)>,
    /// Runs that are ok, but of which something is noted, and the first few of them.
    noted: usize,
    notes: Vec<(usize, String)>,
}

/// Most runs that are told why they are not ok.
const MOST: usize = 5;
/// Most runs that are ok whose notes are told.
const NOTED: usize = 3;

pub(super) fn summary(columns: &Columns, rows: &[Row]) -> Summary {
    let ok = || rows.iter().filter(|row| row.state == State::Ok);
    let extremes = columns.scalars.iter().enumerate().map(|(index, (name, unit))| {
        let values = || ok().filter_map(move |row| Some((row.scalars[index]?, row.run)));
        let lowest = values().min_by(|a, b| a.0.total_cmp(&b.0));
        Extreme { name: name.clone(), unit: unit.clone(), lowest, highest: values().max_by(|a, b| a.0.total_cmp(&b.0)) }
    });
    let point = |row: &Row| {
        let parts = columns.keys.iter().zip(&row.values).map(|((key, unit), value)| match unit.as_deref() {
            Some(unit) if !unit.is_empty() => format!("{key}={value} {unit}"),
            _ => format!("{key}={value}"),
        });
        parts.collect::<Vec<_>>().join(", ")
    };
    let noted = || ok().filter(|row| !row.reason.is_empty());
    let faults = rows.iter().filter(|row| row.state != State::Ok).take(MOST);
    Summary {
        states: State::ALL.map(|state| (state.word(), rows.iter().filter(|row| row.state == state).count())).into(),
        extremes: extremes.collect(),
        faults: faults.map(|row| (row.run, row.state.word(), row.reason.clone())).collect(),
        noted: noted().count(),
        notes: noted().take(NOTED).map(|row| (row.run, row.reason.clone())).collect(),
        points: rows.iter().map(point).collect(),
    }
}

pub(super) fn text(scene: &str, title: &str, summary: &Summary) -> String {
    let states = summary.states.iter().filter(|state| state.1 > 0).map(|(word, count)| format!("{count} {word}"));
    let mut text = format!("{scene}: {title}\n  {} runs: {}\n\n", summary.points.len(), states.collect::<Vec<_>>().join(", "));
    let end =
        |end: Option<(f64, usize)>| end.map_or([String::new(), String::new()], |(value, run)| [shown(value), summary.points[run].clone()]);
    let rows: Vec<Vec<String>> = summary
        .extremes
        .iter()
        .map(|extreme| {
            let ([low, low_at], [high, high_at]) = (end(extreme.lowest), end(extreme.highest));
            vec![with_unit(&extreme.name, &extreme.unit), low, low_at, high, high_at]
        })
        .collect();
    text += &table(&["", "lowest", "at", "highest", "at"].map(String::from), &rows);
    for (run, state, reason) in &summary.faults {
        text += &format!("  {state}: {}: {reason}\n", summary.points[*run]);
    }
    for (run, note) in &summary.notes {
        text += &format!("  ok, but: {}: {note}\n", summary.points[*run]);
    }
    if summary.noted > NOTED {
        text += &format!("  ... and {} more that are ok, but noted; the table has the notes\n", summary.noted - NOTED);
    }
    let told = summary.states[1..].iter().map(|state| state.1).sum::<usize>();
    if told > MOST {
        text += &format!("  ... and {} more; the table has the reasons\n", told - MOST);
    }
    text
}

pub(super) fn json(scene: &str, file: &Path, summary: &Summary) -> Value {
    let end = |end: Option<(f64, usize)>| end.map(|(value, run)| json!({"value": value, "run": run}));
    let scalars = summary.extremes.iter().map(
        |extreme| json!({"scalar": extreme.name, "unit": extreme.unit, "lowest": end(extreme.lowest), "highest": end(extreme.highest)}),
    );
    let states: serde_json::Map<String, Value> = summary.states.iter().map(|(word, count)| (word.to_string(), (*count).into())).collect();
    json!({
        "scene": scene, "file": file.display().to_string(), "runs": summary.points.len(), "states": states, "scalars": scalars.collect::<Vec<_>>(),
    })
}
