//! Picture of `wheelrail contact SCENE --patch --sweep STEP`: where the left wheel presses on its rail, over lateral shifts.

use super::{number, pair_in_force};
use crate::cli::plot::{Axis, Panel, Sheet, Tile, shade};
use crate::cli::{Failure, make_folder};
use crate::contact::patch::{PatchSolution, Settings};
use crate::geometry::Side;
use crate::scene::spec::Scene;
use crate::study::contact_geometry::{Attitude, WheelsetOnTrack};
use crate::study::patch::{Question, patches};
use crate::study::patch_laws::Poses;
use crate::units::Dimension;
use std::path::{Path, PathBuf};

/// Shades of the pressure.
const LEVELS: f64 = 12.0;
/// The brightest is so many times the median of all shifts' highest pressures, or the highest of all.
const OVER_MEDIAN: f64 = 1.6;
const TALL: f64 = 300.0;
/// Beside what is drawn, mm.
const MARGIN: f64 = 1.0;

/// Draws the patches of half-space contact for the first yaw: across, how far each shift's patch reaches and how hard it presses.
pub(super) fn draw(folder: &Path, scene: &Scene, poses: &Poses, near: &str) -> Result<PathBuf, Failure> {
    make_folder(folder)?;
    let near = number("near", near, Dimension::Length)?;
    let attitude = Attitude { yaw: poses.yaws[0], near, ..Attitude::default() };
    let origin = WheelsetOnTrack::new(scene, attitude, None).track.rail(Side::Left).section(0.0).origin.y;
    let settings = Settings { columns: poses.cells, rows: poses.cells, extrapolate: false };
    // Only pressures are shown: how it rolls does not matter.
    let question = |y: f64, load: f64| Question { y, attitude, station: None, load, pitch_rate: Some(0.0), settings };
    let column = |y: f64, load: f64| {
        let answer = patches(scene, &question(y, load)).ok()?;
        let [left, _] = answer.wheels;
        Some((y, Column::new(&left.solution, origin)))
    };
    let step = poses.shifts.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let panels = poses.loads.iter().map(|load| {
        let columns: Vec<(f64, Column)> = poses.shifts.iter().filter_map(|y| column(*y, *load)).collect();
        let (brightest, highest) = brightest(&columns);
        let tiles = columns.iter().flat_map(|(y, column)| column.tiles((y - 0.5 * step, y + 0.5 * step), brightest));
        let tiles: Vec<Tile> = tiles.collect();
        let axis = |label: &str, of: fn(&(f64, f64)) -> f64| {
            let ends = tiles.iter().flat_map(|tile| [of(&tile.from), of(&tile.to)]);
            let [low, high] = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], end| [low.min(end), high.max(end)]);
            Axis { label: label.into(), range: (high > low).then_some((low - MARGIN, high + MARGIN)), ..Axis::default() }
        };
        Panel {
            x: axis("lateral shift y [mm], left positive", |place| place.0),
            y: axis("across the left rail [mm], outward", |place| place.1),
            tiles,
            leaders: false,
            height: TALL,
            aside: format!("dark to bright: 0 to {:.0} MPa; highest {:.0} MPa", 1e-6 * brightest, 1e-6 * highest),
            ..Panel::new(&format!("{} kN on each wheel", 1e-3 * load), ["", ""], vec![])
        }
    });
    let panels = panels.collect();
    let file = folder.join(format!("{}_patches.svg", scene.name));
    let subtitles = vec![
        format!("{}; yaw {} mrad", scene.title, 1e3 * poses.yaws[0]),
        pair_in_force(scene),
        "highest pressure along the rail at each place across, counted from the middle of the rail's head".into(),
    ];
    Sheet { title: "Contact patches over the lateral shift".into(), subtitles, columns: 1, panels }.draw(&file).map_err(Failure::Run)?;
    Ok(file)
}

/// The pressure of the brightest shade, and the highest one, Pa: a flange presses several times as hard as treads do, which would all be dark.
fn brightest(columns: &[(f64, Column)]) -> (f64, f64) {
    let mut tops: Vec<f64> = columns.iter().map(|(_, column)| column.highest()).collect();
    tops.sort_by(f64::total_cmp);
    let at = |index: usize| tops.get(index).copied().unwrap_or(f64::MIN_POSITIVE);
    let highest = at(tops.len().saturating_sub(1));
    (highest.min(OVER_MEDIAN * at(tops.len() / 2)), highest)
}

/// The highest pressure over the place across, of one shift.
struct Column {
    /// Ends across, m, outward, and pressure, Pa; by growing place.
    rows: Vec<([f64; 2], f64)>,
}

impl Column {
    fn new(solution: &PatchSolution, origin: f64) -> Column {
        let half = 0.5 * solution.cell_size[1];
        let mut rows: Vec<([f64; 2], f64, f64)> = Vec::new();
        for cell in &solution.cells {
            // Of a tilted cell the part across.
            let (at, half) = (cell.point.y - origin, half * cell.normal.z.abs());
            match rows.iter_mut().find(|row| (row.2 - cell.place[1]).abs() < 1e-9) {
                Some(row) => row.1 = row.1.max(cell.pressure),
                None => rows.push(([at - half, at + half], cell.pressure, cell.place[1])),
            }
        }
        rows.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
        Column { rows: rows.into_iter().map(|(ends, pressure, _)| (ends, pressure)).collect() }
    }

    fn highest(&self) -> f64 {
        self.rows.iter().map(|row| row.1).fold(0.0, f64::max)
    }

    /// Neighbours of one shade are one tile.
    fn tiles(&self, (from, to): (f64, f64), brightest: f64) -> Vec<Tile> {
        let level = |pressure: f64| (LEVELS * pressure / brightest).min(LEVELS - 1.0).floor();
        let mut runs: Vec<([f64; 2], f64)> = Vec::new();
        for (ends, pressure) in &self.rows {
            match runs.last_mut() {
                Some((own, of)) if *of == level(*pressure) && ends[0] - own[1] < 0.5 * (ends[1] - ends[0]) => own[1] = ends[1],
                _ => runs.push((*ends, level(*pressure))),
            }
        }
        let tile = |([low, high], level): ([f64; 2], f64)| Tile {
            from: (1e3 * from, 1e3 * low),
            to: (1e3 * to, 1e3 * high),
            color: shade(Some(level / (LEVELS - 1.0))),
            label: String::new(),
        };
        runs.into_iter().map(tile).collect()
    }
}
