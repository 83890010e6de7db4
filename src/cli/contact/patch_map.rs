//! Picture of `wheelrail contact SCENE --patch --sweep STEP`: where the left wheel presses on its rail, over lateral shifts.

use super::pair_in_force;
use crate::cli::plot::{Axis, Panel, Sheet, Tile, shade};
use crate::cli::{Failure, make_folder};
use crate::scene::spec::Scene;
use crate::study::patch_laws::{Poses, Row};
use std::path::{Path, PathBuf};

/// Shades of the pressure.
const LEVELS: f64 = 12.0;
/// The brightest is so many times the median of all shifts' highest pressures, or the highest of all.
const OVER_MEDIAN: f64 = 1.6;
const TALL: f64 = 300.0;
/// Beside what is drawn, mm.
const MARGIN: f64 = 1.0;

/// Draws the patches of half-space contact for the first yaw: across, how far each shift's patch reaches and how hard it presses.
pub(super) fn draw(folder: &Path, scene: &Scene, poses: &Poses, rows: &[Row]) -> Result<PathBuf, Failure> {
    make_folder(folder)?;
    let yaw = poses.yaws[0];
    let step = poses.shifts.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let panels = poses.loads.iter().map(|load| {
        let rows: Vec<&Row> = rows.iter().filter(|row| row.yaw == yaw && row.load == *load).collect();
        let (brightest, highest) = brightest(&rows);
        let tiles: Vec<Tile> = rows.iter().flat_map(|row| tiles(row, step, brightest)).collect();
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
        format!("{}; yaw {} mrad", scene.title, 1e3 * yaw),
        pair_in_force(scene),
        "highest pressure along the rail at each place across, counted from the middle of the rail's head".into(),
    ];
    Sheet { title: "Contact patches over the lateral shift".into(), subtitles, columns: 1, panels }.draw(&file).map_err(Failure::Run)?;
    Ok(file)
}

/// Pa.
fn highest(row: &Row) -> f64 {
    row.bands.iter().map(|band| band.pressure).fold(0.0, f64::max)
}

/// The pressure of the brightest shade, and the highest one, Pa: a flange presses several times as hard as treads do, which would all be dark.
fn brightest(rows: &[&Row]) -> (f64, f64) {
    let mut tops: Vec<f64> = rows.iter().map(|row| highest(row)).collect();
    tops.sort_by(f64::total_cmp);
    let at = |index: usize| tops.get(index).copied().unwrap_or(f64::MIN_POSITIVE);
    let highest = at(tops.len().saturating_sub(1));
    (highest.min(OVER_MEDIAN * at(tops.len() / 2)), highest)
}

/// A column of the map, as wide as the shifts are apart, m; neighbours of one shade are one tile.
fn tiles(row: &Row, step: f64, brightest: f64) -> Vec<Tile> {
    let level = |pressure: f64| (LEVELS * pressure / brightest).min(LEVELS - 1.0).floor();
    let mut runs: Vec<([f64; 2], f64)> = Vec::new();
    for band in &row.bands {
        match runs.last_mut() {
            Some((own, of)) if *of == level(band.pressure) && band.ends[0] - own[1] < 0.5 * (band.ends[1] - band.ends[0]) => {
                own[1] = band.ends[1];
            }
            _ => runs.push((band.ends, level(band.pressure))),
        }
    }
    let tile = |([low, high], level): ([f64; 2], f64)| Tile {
        from: (1e3 * (row.y - 0.5 * step), 1e3 * low),
        to: (1e3 * (row.y + 0.5 * step), 1e3 * high),
        color: shade(Some(level / (LEVELS - 1.0))),
        label: String::new(),
    };
    runs.into_iter().map(tile).collect()
}
