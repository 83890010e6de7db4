//! Scalars over the values: lines for one key, heat maps for two, points for more.

use super::Sweep;
use super::table::{Columns, Row, with_unit};
use crate::cli::plot::{Axis, Ink, Mark, Panel, Series, Sheet, Tile, shade};
use crate::study::variation::parameter::{number, shown};
use crate::study::variation::single::State;

/// Most panels of a sheet.
const MOST: usize = 12;

/// A key's values as numbers; `None` of words.
fn numbers(columns: &Columns, rows: &[Row], key: usize) -> Option<Vec<f64>> {
    columns.keys[key].1.as_ref()?;
    rows.iter().map(|row| Some(number(&row.values[key])?.0)).collect()
}

pub(super) fn sheet(sweep: &Sweep, columns: &Columns, rows: &[Row], drawn: bool) -> Sheet {
    let axes: Vec<Option<Vec<f64>>> = (0..columns.keys.len()).map(|key| numbers(columns, rows, key)).collect();
    let each = |panel: &dyn Fn(usize) -> Panel| (0..columns.scalars.len()).map(panel).collect::<Vec<_>>();
    let mut panels = match axes.as_slice() {
        [_] if !drawn => each(&|scalar| lines(columns, rows, scalar, 0, None)),
        [Some(x), Some(y)] if !drawn => each(&|scalar| map(columns, rows, scalar, x, y)),
        [Some(_), None] if !drawn => each(&|scalar| lines(columns, rows, scalar, 0, Some(1))),
        [None, _] if !drawn && axes.len() == 2 => each(&|scalar| lines(columns, rows, scalar, 1, Some(0))),
        _ => {
            let keys = 0..columns.keys.len();
            keys.flat_map(|key| (0..columns.scalars.len()).map(move |scalar| (key, scalar)))
                .map(|(key, scalar)| points(columns, rows, scalar, key))
                .collect()
        }
    };
    let all = panels.len();
    panels.truncate(MOST);
    let open = rows.iter().filter(|row| row.state != State::Ok).count();
    let mut notes = vec![format!("{} runs", rows.len())];
    notes.extend(panels.iter().any(|panel| !panel.tiles.is_empty()).then(|| "dark: low, bright: high".to_string()));
    notes.extend((open > 0).then(|| format!("{open} of them not ok")));
    notes.extend((all > MOST).then(|| format!("{MOST} of {all} panels: --scalar chooses")));
    let subtitles = vec![sweep.title.clone(), notes.join("; ")];
    Sheet { title: format!("Sweep of {}", sweep.scene), subtitles, columns: if panels.len() > 1 { 2 } else { 1 }, panels }
}

/// A scalar with its unit, for an axis.
fn label(columns: &Columns, scalar: usize) -> String {
    let (name, unit) = &columns.scalars[scalar];
    with_unit(name, if *unit == "1" { "-" } else { unit })
}

fn place(columns: &Columns, row: &Row, scalar: usize, key: usize) -> Option<(f64, f64)> {
    let value = row.scalars[scalar].filter(|_| row.state == State::Ok)?;
    let _ = columns.keys[key].1.as_ref()?;
    Some((number(&row.values[key])?.0, value))
}

/// Over one key, a line for each value of another one.
fn lines(columns: &Columns, rows: &[Row], scalar: usize, key: usize, other: Option<usize>) -> Panel {
    let name = |row: &Row| other.map_or(String::new(), |other| format!("{} = {}", columns.keys[other].0, row.values[other]));
    let mut names: Vec<String> = Vec::new();
    rows.iter().map(name).for_each(|name| {
        if !names.contains(&name) {
            names.push(name)
        }
    });
    // Words stand side by side in the order of the list.
    let mut words: Vec<&String> = Vec::new();
    rows.iter().map(|row| &row.values[key]).for_each(|word| {
        if !words.contains(&word) {
            words.push(word)
        }
    });
    let is_number = columns.keys[key].1.is_some();
    let mark = |row: &Row| {
        if is_number {
            let (x, y) = place(columns, row, scalar, key)?;
            return Some(Mark { x, y, ..Mark::default() });
        }
        let y = row.scalars[scalar].filter(|_| row.state == State::Ok)?;
        let x = words.iter().position(|word| **word == row.values[key])? as f64 + 1.0;
        Some(Mark { x, y, label: row.values[key].clone(), ..Mark::default() })
    };
    let series = names.iter().enumerate().map(|(style, own)| {
        let mut marks: Vec<Mark> = rows.iter().filter(|row| name(row) == *own).filter_map(mark).collect();
        marks.sort_by(|a, b| a.x.total_cmp(&b.x));
        let ink = Ink { radius: 3.5, width: if is_number { 1.5 } else { 0.0 }, ..Ink::marks(style) };
        Series::marks(own, ink, marks)
    });
    let x = if is_number { columns.key(key) } else { format!("{}, as listed", columns.keys[key].0) };
    Panel::new(&columns.scalars[scalar].0, [&x, &label(columns, scalar)], series.collect())
}

/// Over one key, whatever the others are.
fn points(columns: &Columns, rows: &[Row], scalar: usize, key: usize) -> Panel {
    let panel = lines(columns, rows, scalar, key, None);
    let unlabelled = |mark: Mark| Mark { label: String::new(), ..mark };
    let series = panel.series.into_iter().map(|series| Series {
        ink: Ink { width: 0.0, ..series.ink },
        branches: vec![],
        marks: series.marks.into_iter().map(unlabelled).collect(),
        label: series.label,
    });
    Panel { series: series.collect(), ..panel }
}

/// Sorted different values, and the edges between their neighbours.
fn edges(values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let mut own = values.to_vec();
    own.sort_by(f64::total_cmp);
    own.dedup();
    let half = |k: usize| own.get(k).zip(own.get(k + 1)).map_or(0.5, |(a, b)| 0.5 * (b - a));
    let last = own.len() - 1;
    let mut edges = vec![own[0] - half(0)];
    edges.extend(own.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])));
    edges.push(own[last] + half(last.saturating_sub(1)));
    (own, edges)
}

/// Over two keys.
fn map(columns: &Columns, rows: &[Row], scalar: usize, x: &[f64], y: &[f64]) -> Panel {
    let ((xs, x_edges), (ys, y_edges)) = (edges(x), edges(y));
    let value = |row: &Row| row.scalars[scalar].filter(|_| row.state == State::Ok);
    let (low, high) =
        rows.iter().filter_map(value).fold((f64::INFINITY, f64::NEG_INFINITY), |range, value| (range.0.min(value), range.1.max(value)));
    let tile = |(row, (x, y)): (&Row, (&f64, &f64))| {
        let (i, j) = (xs.partition_point(|other| other < x), ys.partition_point(|other| other < y));
        let part = value(row).map(|value| if high > low { (value - low) / (high - low) } else { 0.5 });
        let label = value(row).map_or(row.state.word().to_string(), |value| shown(format!("{value:.2e}").parse().unwrap_or(value)));
        Tile { from: (x_edges[i], y_edges[j]), to: (x_edges[i + 1], y_edges[j + 1]), color: shade(part), label }
    };
    let tiles: Vec<Tile> = rows.iter().zip(x.iter().zip(y)).map(tile).collect();
    let ends = |edges: &[f64]| Some((edges[0], edges[edges.len() - 1]));
    let axis = |key: usize, edges: &[f64]| Axis { label: columns.key(key), range: ends(edges), ..Axis::default() };
    let panel = Panel::new(&label(columns, scalar), ["", ""], vec![]);
    let aside = if low <= high { format!("{} to {}", shown3(low), shown3(high)) } else { String::new() };
    Panel { x: axis(0, &x_edges), y: axis(1, &y_edges), tiles, aside, height: 420.0, ..panel }
}

fn shown3(value: f64) -> String {
    shown(format!("{value:.2e}").parse().unwrap_or(value))
}
