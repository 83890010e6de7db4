//! `wheelrail contact SCENE --patch`: the patches that really form at one lateral shift, beside the scene's ellipse.

use super::{Arguments, attitude, load, notes, number, pair_in_force};
use crate::cli::plot::{Axis, Ink, Mark, Panel, Series, Sheet, inside, width};
use crate::cli::{Failure, csv_target, file_names, make_folder, print, say, table};
use crate::contact::patch::{PatchCell, Settings};
use crate::scene::profile_notes::profile_doubts;
use crate::scene::spec::Scene;
use crate::study::patch::{Answer, Question, WheelPatch, patches};
use crate::units::Dimension;
use plotters::style::RGBColor;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};

/// Creep forces on ellipses are within 0.014 mu N with so many cells each way; 32 have them within 0.03.
const CELLS: usize = 64;

pub(super) fn patch(arguments: &Arguments, scene: &Scene) -> Result<(), Failure> {
    let (attitude, station) = attitude(arguments)?;
    let y = number("y", &arguments.y, Dimension::Length)?;
    let load = load(arguments, scene)?;
    let cells = arguments.cells.unwrap_or(CELLS);
    if !(cells.is_multiple_of(2) && (8..=128).contains(&cells)) {
        return Err(Failure::Input(format!("--cells {cells}: expected an even number from 8 to 128")));
    }
    let target = csv_target(&arguments.output, arguments.json)?;
    if let Some(folder) = &arguments.plot {
        make_folder(folder)?;
    }
    let settings = Settings { columns: cells, rows: cells, extrapolate: true, ..Settings::default() };
    let pitch_rate = arguments.pitch_rate.as_ref().map(|rate| number("pitch-rate", rate, Dimension::AngularSpeed)).transpose()?;
    let question = Question { y, attitude, station, load, pitch_rate, settings };
    let answer = patches(scene, &question).map_err(|error| Failure::Run(format!("{}: {error}", scene.source.file)))?;
    if let Some(target) = &target {
        target.write(&csv(&answer).map_err(|error| Failure::Run(error.to_string()))?)?;
    }
    let files = match &arguments.plot {
        Some(folder) => draw(folder, scene, &question, &answer).map_err(Failure::Run)?,
        None => Vec::new(),
    };
    if arguments.json {
        return Ok(print(&format!("{}\n", as_json(scene, &question, &answer, &files)))?);
    }
    files.iter().for_each(|file| say(&format!("wrote {}", file.display())));
    if !target.is_some_and(|target| target.is_stdout()) {
        print(&text(scene, &question, &answer))?;
    }
    Ok(())
}

/// Every cell.
fn csv(answer: &Answer) -> csv::Result<Vec<u8>> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    csv.write_record(["wheel", "x [m]", "y [m]", "pressure [Pa]", "tractionX [Pa]", "tractionY [Pa]", "slipX [-]", "slipY [-]", "sticks"])?;
    for wheel in &answer.wheels {
        for cell in &wheel.solution.cells {
            let numbers = [cell.place[0], cell.place[1], cell.pressure, cell.traction[0], cell.traction[1], cell.slip[0], cell.slip[1]];
            let numbers = numbers.map(|value| format!("{value:?}"));
            let row = [wheel.side.name()].into_iter().chain(numbers.iter().map(String::as_str));
            csv.write_record(row.chain([if cell.sticks { "1" } else { "0" }]))?;
        }
    }
    csv.into_inner().map_err(|error| csv::Error::from(error.into_error()))
}

/// A line of the table: what it is, digits, of the real patch and of the ellipse.
type Line = (&'static str, usize, fn(&WheelPatch) -> f64, fn(&WheelPatch) -> Option<f64>);

const LINES: [Line; 13] = [
    ("approach [um]", 2, |w| 1e6 * w.approach, |_| None),
    ("overlap along the normal [um]", 2, |w| 1e6 * w.solution.overlap, |w| Some(1e6 * w.ellipse?.penetration)),
    ("normal force [kN]", 3, |w| 1e-3 * w.solution.pressing.norm(), |w| Some(1e-3 * w.ellipse?.normal_force)),
    ("u of the load's centre [mm]", 3, |w| 1e3 * w.wheel, |w| Some(1e3 * w.ellipse?.touch.wheel)),
    ("rolling radius there [mm]", 3, |w| 1e3 * w.rolling_radius, |w| Some(1e3 * w.ellipse?.touch.rolling_radius)),
    ("contact angle [deg]", 3, |w| w.angle.to_degrees(), |w| Some(w.ellipse?.touch.angle.to_degrees())),
    ("area [mm2]", 1, |w| 1e6 * w.solution.area(), |w| w.ellipse.map(|e| 1e6 * PI * e.patch.a * e.patch.b)),
    ("parts", 0, |w| w.solution.parts() as f64, |w| w.ellipse.map(|_| 1.0)),
    (
        "highest pressure [MPa]",
        0,
        |w| 1e-6 * w.solution.highest_pressure(),
        |w| w.ellipse.map(|e| 1.5e-6 * e.normal_force / (PI * e.patch.a * e.patch.b)),
    ),
    ("creep force along [kN]", 3, |w| 1e-3 * w.creep.longitudinal, |w| Some(1e-3 * w.ellipse?.creep.longitudinal)),
    ("creep force across [kN]", 3, |w| 1e-3 * w.creep.lateral, |w| Some(1e-3 * w.ellipse?.creep.lateral)),
    ("spin moment [N m]", 2, |w| w.creep.spin_moment, |w| Some(w.ellipse?.creep.spin_moment)),
    ("share that sticks [%]", 1, |w| 100.0 * w.solution.sticking_share(), |_| None),
];

fn heading(question: &Question) -> String {
    format!(
        "y {:.3} mm, yaw {} mrad, {:.3} kN on each wheel (vertical, of the pressures)",
        1e3 * question.y,
        1e3 * question.attitude.yaw,
        1e-3 * question.load
    )
}

fn text(scene: &Scene, question: &Question, answer: &Answer) -> String {
    let contact = &scene.contact;
    let mut head = vec!["".to_string()];
    for wheel in &answer.wheels {
        head.extend([wheel.side.name().to_string(), "ellipse".into()]);
    }
    let row = |(name, digits, real, ellipse): &Line| {
        // No minus sign before zeros.
        let shown = |value: f64| if value.abs() < 0.5 * 0.1f64.powi(*digits as i32) { 0.0 } else { value };
        let number = |value: f64| if value.is_finite() { format!("{:.digits$}", shown(value)) } else { "-".into() };
        let both = |wheel: &WheelPatch| [number(real(wheel)), ellipse(wheel).map_or("-".into(), number)];
        [name.to_string()].into_iter().chain(answer.wheels.iter().flat_map(both)).collect::<Vec<_>>()
    };
    let rows: Vec<Vec<String>> = LINES.iter().map(row).collect();
    format!(
        "{}\n\n  {}\n  rolling {}at {} m/s (pitch rate {:.4} rad/s), friction {}{}\n\n{}\nellipse: contact.normal.law = \"{}\" and contact.creep.law = \"{}\" at the deepest place; the other column: half-spaces, with the friction alone (no kalker_factor, no falling friction)\n{}",
        scene.title,
        heading(question),
        if question.pitch_rate.is_none() { "freely " } else { "" },
        scene.vehicle.speed,
        answer.pitch_rate,
        contact.friction,
        if contact.friction_map.is_some() { " everywhere (its factors by place are left out)" } else { "" },
        table(&head, &rows),
        contact.normal_name,
        contact.creep_name,
        notes(doubts(scene, answer))
    )
}

/// What a user should know of the profiles and where patches end.
fn doubts(scene: &Scene, answer: &Answer) -> Vec<String> {
    let words = |wheel: &WheelPatch| Some(wheel.end?.words(&format!("the {} wheel's patch", wheel.side.name())));
    answer.wheels.iter().filter_map(words).chain(profile_doubts(scene)).collect()
}

fn as_json(scene: &Scene, question: &Question, answer: &Answer, files: &[PathBuf]) -> Value {
    let wheel = |wheel: &WheelPatch| {
        let line = |(name, _, real, ellipse): &Line| json!({"what": name, "real": real(wheel), "ellipse": ellipse(wheel)});
        let centre = wheel.solution.centre;
        let force = wheel.solution.pressing + wheel.solution.creep_force;
        json!({
            "force": [force.x, force.y, force.z], "side": wheel.side.name(), "values": LINES.iter().map(line).collect::<Vec<_>>(), "centre": [centre.x, centre.y, centre.z],
            "cells": wheel.solution.cells.len(), "cell_size": wheel.solution.cell_size,
        })
    };
    json!({
        "scene": scene.name, "title": scene.title, "y": question.y, "yaw": question.attitude.yaw, "load": question.load,
        "roll": answer.stand.roll, "pitch_rate": answer.pitch_rate, "doubts": doubts(scene, answer), "wheels": answer.wheels.each_ref().map(wheel),
        "pictures": file_names(files),
    })
}

/// Colours of fifths of the highest pressure, and of sliding cells.
const SHADES: [RGBColor; 5] =
    [RGBColor(209, 229, 240), RGBColor(146, 197, 222), RGBColor(67, 147, 195), RGBColor(33, 102, 172), RGBColor(5, 48, 97)];
const STICKS: RGBColor = RGBColor(0, 114, 178);
const SLIDES: RGBColor = RGBColor(213, 94, 0);
const OUTLINE: RGBColor = RGBColor(0, 0, 0);

/// Pressure, and stick and slip with tractions, of both wheels.
fn draw(folder: &Path, scene: &Scene, question: &Question, answer: &Answer) -> Result<Vec<PathBuf>, String> {
    let file = folder.join(format!("{}_patch.svg", scene.name));
    let panels = answer.wheels.iter().map(pressures).chain(answer.wheels.iter().map(tractions)).collect();
    let subtitles = vec![
        format!("{}; {}", scene.title, heading(question)),
        pair_in_force(scene),
        "across: along the rail's section from the deepest place, left positive; up: rolling direction. Black: the scene's ellipse".into(),
    ];
    Sheet { title: "Contact patches".into(), subtitles, columns: 2, panels }.draw(&file)?;
    Ok(vec![file])
}

/// Height of a panel, pixels.
const TALL: f64 = 340.0;

/// A panel with the same scale along and across, about everything that is drawn; and its pixels per mm.
fn panel(title: &str, wheel: &WheelPatch, series: impl FnOnce(f64) -> Vec<Series>) -> Panel {
    const MARGIN: f64 = 1.15;
    let (across, up) = inside((width(2), TALL));
    let cells = wheel.solution.cells.iter().map(|cell| (1e3 * cell.place[1], 1e3 * cell.place[0]));
    let ellipse =
        wheel.ellipse.map(|ellipse| [(1e3 * ellipse.patch.b, 1e3 * ellipse.patch.a), (-1e3 * ellipse.patch.b, -1e3 * ellipse.patch.a)]);
    let bounds = cells
        .chain(ellipse.into_iter().flatten())
        .fold([f64::INFINITY, f64::NEG_INFINITY, 0.0], |[low, high, far], (x, y)| [low.min(x), high.max(x), f64::max(far, y.abs())]);
    let [low, high, far] = bounds;
    let half = MARGIN * f64::max(0.5 * (high - low), far * across / up);
    let (middle, high) = (0.5 * (low + high), half * up / across);
    let axis = |label: &str, range| Axis { label: label.into(), range: Some(range), ..Axis::default() };
    Panel {
        // Left is left.
        x: axis("across the rail [mm], left positive", (middle + half, middle - half)),
        y: axis("along [mm]", (-high, high)),
        leaders: false,
        height: TALL,
        ..Panel::new(title, ["", ""], series(0.5 * across / half))
    }
}

/// Cells as marks that touch each other.
fn marks(label: &str, color: RGBColor, size: f64, cells: impl Iterator<Item = PatchCell>) -> Series {
    let mark = |cell: PatchCell| Mark { x: 1e3 * cell.place[1], y: 1e3 * cell.place[0], ..Mark::default() };
    let ink = Ink { width: 1.0, radius: size, alpha: 1.0, ..Ink::line(color) };
    Series { label: label.into(), ink, branches: vec![], marks: cells.map(mark).collect() }
}

/// The ellipse about the deepest place.
fn outline(wheel: &WheelPatch) -> Option<Series> {
    let patch = wheel.ellipse?.patch;
    let point = |k: i32| {
        let (sin, cos) = (TAU * f64::from(k) / 120.0).sin_cos();
        (1e3 * patch.b * cos, 1e3 * patch.a * sin)
    };
    Some(Series::line("", Ink { width: 1.5, ..Ink::line(OUTLINE) }, (0..=120).map(point).collect()))
}

fn pressures(wheel: &WheelPatch) -> Panel {
    let solution = &wheel.solution;
    let highest = solution.highest_pressure();
    let class = |cell: &PatchCell| ((5.0 * cell.pressure / highest) as usize).min(4);
    let title = format!("{} wheel: pressure, highest {:.0} MPa", wheel.side.name(), 1e-6 * highest);
    panel(&title, wheel, |scale| {
        let size = 0.55e3 * scale * solution.cell_size[0].min(solution.cell_size[1]);
        let of = |k: usize| marks("", SHADES[k], size, solution.cells.iter().filter(move |cell| class(cell) == k).copied());
        (0..5).map(of).chain(outline(wheel)).collect()
    })
}

fn tractions(wheel: &WheelPatch) -> Panel {
    let solution = &wheel.solution;
    let highest = solution.cells.iter().map(|cell| cell.traction[0].hypot(cell.traction[1])).fold(f64::MIN_POSITIVE, f64::max);
    // The longest line covers two and a half cells.
    let longest = 2.5e3 * solution.cell_size[0].max(solution.cell_size[1]) / highest;
    let line = |cell: &PatchCell| {
        let from = (1e3 * cell.place[1], 1e3 * cell.place[0]);
        vec![from, (from.0 + longest * cell.traction[1], from.1 + longest * cell.traction[0])]
    };
    let title = format!("{} wheel: tractions on it, {:.0} % sticks", wheel.side.name(), 100.0 * solution.sticking_share());
    panel(&title, wheel, |_| {
        let of = |label, color, sticks: bool| {
            let cells = || solution.cells.iter().filter(move |cell| cell.sticks == sticks);
            Series { branches: cells().map(line).collect(), ..marks(label, color, 2.0, cells().copied()) }
        };
        [of("sticks", STICKS, true), of("slides", SLIDES, false)].into_iter().chain(outline(wheel)).collect()
    })
}
