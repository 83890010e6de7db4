//! Curves of a run over distance, and spectra.

use super::Drawn;
use super::track;
use crate::cli::plot::{BLUE, DARK, Ink, ORANGE, Panel, Series};
use crate::sim::recording::Recording;
use crate::study::spectrum::welch;
use plotters::style::RGBColor;

const DISTANCE: &str = "distance [m]";

/// Ink of part number `k` of `count`: where it is alone one that is neither a wheel's nor the reference's.
fn ink(k: usize, count: usize) -> Ink {
    Ink::part(if count == 1 { 2 } else { k })
}

/// Of the reference, on the curve of the run: alone in a panel it is dark, else a darker shade of the colour it belongs to.
fn other(own: Ink, alone: bool) -> Ink {
    let darker = |part: u8| (f64::from(part) * SHADE) as u8;
    let color = if alone { DARK } else { RGBColor(darker(own.color.0), darker(own.color.1), darker(own.color.2)) };
    Ink { width: 1.5, ..Ink::dashed(color) }
}

/// Brightness that a shade keeps.
const SHADE: f64 = 0.55;

/// Is it a curve of the reference?
fn is_other(drawn: &Drawn, series: &Series) -> bool {
    drawn.against.is_some_and(|reference| reference.name == series.label)
}

/// What a curve is called: nothing where there is but one that the title names.
fn label<'a>(drawn: &Drawn, parts: &'a [String], k: usize) -> &'a str {
    let alone = parts.len() == 1 && drawn.against.is_none() && drawn.scene.vehicle.bodies.is_empty();
    if alone { "" } else { &parts[k] }
}

/// Names of parts of which an output is recorded, in order.
fn parts(recording: &Recording, output: &str) -> Vec<String> {
    recording.columns.iter().filter_map(|column| column.0.strip_suffix(output)?.strip_suffix('.')).map(String::from).collect()
}

/// Wheelsets that are recorded.
fn wheelsets(drawn: &Drawn) -> Vec<String> {
    let names = drawn.scene.vehicle.axles().into_iter().map(|axle| axle.0.to_string());
    names.filter(|name| drawn.recording.column(&format!("{name}.distance")).is_some()).collect()
}

/// An output of a part over the part's distance, and that of the reference below a label of its own.
fn curves(drawn: &Drawn, part: &str, output: &str, factor: f64, (label, ink, alone): (&str, Ink, bool)) -> Vec<Series> {
    let [along, name] = ["distance", output].map(|end| format!("{part}.{end}"));
    let points = |x: &[f64], y: &[f64]| x.iter().copied().zip(y.iter().map(|value| factor * value)).collect();
    let own = drawn.recording.column(&along).zip(drawn.recording.column(&name)).map(|(x, y)| Series::line(label, ink, points(&x, &y)));
    let reference = drawn.against.and_then(|reference| {
        let (x, y) = reference.signals.column(&along).zip(reference.signals.column(&name))?;
        Some(Series::line(&reference.name, other(ink, alone), points(x, y)))
    });
    // A reference of what is not recorded is none.
    if own.is_none() { vec![] } else { own.into_iter().chain(reference).collect() }
}

/// One panel with an output of several parts; `None` where none has it.
fn panel(drawn: &Drawn, parts: &[String], (title, axis): (&str, &str), output: &str, factor: f64) -> Option<Panel> {
    let of =
        |(k, part): (usize, &String)| curves(drawn, part, output, factor, (label(drawn, parts, k), ink(k, parts.len()), parts.len() == 1));
    let mut series: Vec<Series> = parts.iter().enumerate().flat_map(of).collect();
    // The reference lies on top.
    series.sort_by_key(|series| is_other(drawn, series));
    (!series.is_empty()).then(|| Panel { height: 270.0, ..Panel::new(title, [DISTANCE, axis], series) })
}

/// An output of the wheels: of a single wheelset both in one panel, else one panel for each side.
fn wheels(drawn: &Drawn, parts: &[String], (title, axis): (&str, &str), output: &str, factor: f64) -> Vec<Panel> {
    if let [only] = parts {
        let both = [("left", "left wheel", BLUE), ("right", "right wheel", ORANGE)];
        let mut series: Vec<Series> = both
            .into_iter()
            .flat_map(|(side, label, color)| curves(drawn, only, &format!("{side}.{output}"), factor, (label, Ink::line(color), false)))
            .collect();
        series.sort_by_key(|series| is_other(drawn, series));
        let panel = Panel { height: 270.0, ..Panel::new(title, [DISTANCE, axis], series) };
        return if panel.series.is_empty() { vec![] } else { vec![panel] };
    }
    let side = |side: &str| panel(drawn, parts, (&format!("{title}, {side} wheels"), axis), &format!("{side}.{output}"), factor);
    ["left", "right"].into_iter().filter_map(side).collect()
}

/// With the track below, as far as the panels reach.
fn on_track(drawn: &Drawn, mut panels: Vec<Panel>) -> Vec<Panel> {
    // A ten-thousandth of mm, mrad, kN: what is less is rounding.
    panels.iter_mut().for_each(|panel| panel.y.span = 1e-4);
    let ends = panels
        .iter()
        .flat_map(|panel| &panel.series)
        .filter(|series| !is_other(drawn, series))
        .flat_map(|series| series.branches.iter().flatten());
    let range = ends.map(|point| (point.0, point.0)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    if let Some(range) = range {
        panels.extend(track::panels(drawn, range));
    }
    panels
}

/// Lateral displacement, yaw, wheel loads.
pub(super) fn motions(drawn: &Drawn) -> Vec<Panel> {
    let all = wheelsets(drawn);
    let mut panels: Vec<Panel> = [
        panel(drawn, &all, ("Lateral displacement", "y [mm], left positive"), "y", 1e3),
        panel(drawn, &all, ("Yaw", "yaw [mrad]"), "yaw", 1e3),
    ]
    .into_iter()
    .flatten()
    .collect();
    panels.extend(wheels(drawn, &all, ("Wheel loads", "Q [kN]"), "verticalForce", 1e-3));
    on_track(drawn, panels)
}

/// Y, Y/Q, sum of Y.
pub(super) fn forces(drawn: &Drawn) -> Vec<Panel> {
    let all = wheelsets(drawn);
    let mut panels = wheels(drawn, &all, ("Lateral forces", "Y [kN], left positive"), "lateralForce", 1e-3);
    panels.extend(wheels(drawn, &all, ("Derailment quotients", "Y/Q [-], outward positive"), "derailmentQuotient", 1.0));
    panels.extend(panel(drawn, &all, ("Track shifting forces", "sum of Y [kN]"), "trackShiftingForce", 1e-3));
    if panels.is_empty() { panels } else { on_track(drawn, panels) }
}

/// Positions and angles of bodies that are no wheelsets.
pub(super) fn bodies(drawn: &Drawn) -> Vec<Panel> {
    // Wheelsets have no pitch.
    let all = parts(drawn.recording, "pitch");
    let panels: Vec<Panel> = [
        panel(drawn, &all, ("Lateral displacement", "y [mm], left positive"), "y", 1e3),
        panel(drawn, &all, ("Roll", "roll [mrad], left side up"), "roll", 1e3),
        panel(drawn, &all, ("Pitch", "pitch [mrad], nose down"), "pitch", 1e3),
        panel(drawn, &all, ("Yaw", "yaw [mrad], nose left"), "yaw", 1e3),
        rise(drawn, &all),
    ]
    .into_iter()
    .flatten()
    .collect();
    if panels.is_empty() { panels } else { on_track(drawn, panels) }
}

/// Heights of bodies over that at the beginning: they stand at very different ones.
fn rise(drawn: &Drawn, all: &[String]) -> Option<Panel> {
    let mut panel = panel(drawn, all, ("Height over that at the beginning", "rise [mm]"), "z", 1e3)?;
    for branch in panel.series.iter_mut().flat_map(|series| &mut series.branches) {
        let first = branch.first().map_or(0.0, |point| point.1);
        branch.iter_mut().for_each(|point| point.1 -= first);
    }
    Some(panel)
}

/// Points whose accelerations are recorded: sensors, then wheelsets.
fn points(drawn: &Drawn) -> [(&'static str, Vec<String>); 2] {
    let all = wheelsets(drawn);
    let sensors = parts(drawn.recording, "az").into_iter().filter(|part| !all.contains(part)).collect();
    [("sensors", sensors), ("wheelsets", all)]
}

const DIRECTIONS: [(&str, &str, &str); 2] = [("ay", "Lateral", "ay [m/s2]"), ("az", "Vertical", "az [m/s2]")];

/// Of sensors and wheelsets.
pub(super) fn accelerations(drawn: &Drawn) -> Vec<Panel> {
    let panels: Vec<Panel> = points(drawn)
        .iter()
        .flat_map(|(kind, parts)| {
            // Those of wheelsets are far larger: axes of their own.
            DIRECTIONS.map(|(output, word, axis)| {
                panel(drawn, parts, (&format!("{word} acceleration, {kind}"), &format!("{axis}, {kind}")), output, 1.0)
            })
        })
        .flatten()
        .collect();
    if panels.is_empty() { panels } else { on_track(drawn, panels) }
}

/// Windows that are averaged, and most samples of one.
const WINDOWS: usize = 8;
const WINDOW: usize = 4096;

/// Spectra of the same accelerations.
pub(super) fn spectra(drawn: &Drawn) -> Vec<Panel> {
    let rows = &drawn.recording.rows;
    // The last row may stand nearer than the others.
    let even = rows.len().saturating_sub(1);
    if even < 64 {
        return vec![];
    }
    let interval = (rows[even - 1][0] - rows[0][0]) / (even - 1) as f64;
    let window = (even / WINDOWS * 2).clamp(32, WINDOW);
    let spectrum = |values: &[f64], interval: f64| -> Vec<(f64, f64)> {
        welch(values, interval, window).into_iter().flatten().filter(|line| line.0 > 0.0 && line.1 > 0.0).collect()
    };
    let mut panels = Vec::new();
    for (kind, parts) in points(drawn) {
        for (output, word, _) in DIRECTIONS {
            let of = |(k, part): (usize, &String)| {
                let name = format!("{part}.{output}");
                let ink = ink(k, parts.len());
                let own = drawn
                    .recording
                    .column(&name)
                    .map(|values| Series::line(label(drawn, &parts, k), ink, spectrum(&values[..even], interval)));
                let reference = drawn.against.filter(|_| own.is_some()).and_then(|reference| {
                    let values = reference.signals.column(&name)?;
                    Some(Series::line(&reference.name, other(ink, parts.len() == 1), spectrum(values, reference.signals.interval)))
                });
                own.into_iter().chain(reference).collect::<Vec<_>>()
            };
            let mut series: Vec<Series> = parts.iter().enumerate().flat_map(of).collect();
            series.retain(|series| series.branches.iter().any(|branch| !branch.is_empty()));
            series.sort_by_key(|series| is_other(drawn, series));
            if series.is_empty() {
                continue;
            }
            // Ten decades below the highest line there is rounding.
            let top = series.iter().flat_map(|series| series.branches.iter().flatten()).map(|line| line.1).fold(0.0, f64::max);
            series.iter_mut().flat_map(|series| &mut series.branches).for_each(|branch| branch.retain(|line| line.1 > 1e-10 * top));
            let mut panel =
                Panel::new(&format!("{word} acceleration, {kind}"), ["frequency [Hz]", &format!("density [(m/s2)2/Hz], {kind}")], series)
                    .log();
            panel.aside = format!("Welch, Hann, {window} samples");
            panel.height = 300.0;
            panels.push(panel);
        }
    }
    panels
}
