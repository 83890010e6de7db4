//! `wheelrail contact SCENE --patch --sweep STEP`: laws of the patch against half-space contact, over lateral shifts, yaws and loads.

use super::patch_map;
use super::{Arguments, load, number, positive};
use crate::cli::{Failure, csv_target, file_names, print, say, table};
use crate::scene::spec::Scene;
use crate::study::patch_laws::{Difference, Poses, Row, mean_and_worst, rows};
use crate::units::Dimension;
use serde_json::json;

/// Yaws, rad, and loads, N, where none is named.
const YAWS: [f64; 2] = [0.0, 10e-3];
const LOADS: [f64; 3] = [10e3, 50e3, 100e3];
const MOST: f64 = 1e3;

type Law = (&'static str, fn(&Row) -> Option<Difference>);
type Figure = (&'static str, usize, fn(&Difference) -> f64);

const LAWS: [Law; 3] = [("strips", |row| Some(row.strips)), ("table", |row| row.table), ("ellipse", |row| row.ellipse)];
const FIGURES: [Figure; 4] = [
    ("N [%]", 2, |d| 100.0 * d.normal_force),
    ("centre [mm]", 3, |d| 1e3 * d.centre),
    ("area [%]", 1, |d| 100.0 * d.area),
    ("creep [mu N]", 3, |d| d.creep),
];

/// Cells each way, for hundreds of patches.
const CELLS: usize = 32;

pub(super) fn patch_laws(arguments: &Arguments, scene: &Scene, step: &str) -> Result<(), Failure> {
    let (range, step) = (positive("range", &arguments.range)?, positive("sweep", step)?);
    if range / step > MOST {
        return Err(Failure::Input(format!("--sweep {step} m: more than {MOST} shifts to one side")));
    }
    let count = (range / step + 1e-9).floor() as i32;
    let poses = Poses {
        shifts: (-count..=count).map(|k| f64::from(k) * step).collect(),
        yaws: if arguments.yaw == "0" { YAWS.to_vec() } else { vec![number("yaw", &arguments.yaw, Dimension::Angle)?] },
        loads: if arguments.load.is_some() { vec![load(arguments, scene)?] } else { LOADS.to_vec() },
        cells: arguments.cells.unwrap_or(CELLS),
    };
    let target = csv_target(&arguments.output, arguments.json)?;
    let rows = rows(scene, &poses);
    if rows.is_empty() {
        return Err(Failure::Run(format!("{}: the wheelset stands at none of these shifts", scene.source.file)));
    }
    if let Some(target) = &target {
        target.write(&csv(&rows).map_err(|error| Failure::Run(error.to_string()))?)?;
    }
    let drawn = arguments.plot.iter().map(|folder| patch_map::draw(folder, scene, &poses, &rows));
    let files = drawn.collect::<Result<Vec<_>, _>>()?;
    if arguments.json {
        let of = |d: &Difference| json!({"normal_force": d.normal_force, "centre": d.centre, "area": d.area, "creep": d.creep});
        let row = |row: &Row| {
            let [table, ellipse] = [&row.table, &row.ellipse].map(|law| law.as_ref().map(of));
            json!({"y": row.y, "yaw": row.yaw, "load": row.load, "normal_force": row.normal_force, "strips": of(&row.strips), "table": table, "ellipse": ellipse})
        };
        let all = json!({"scene": scene.name, "title": scene.title, "rows": rows.iter().map(row).collect::<Vec<_>>(), "pictures": file_names(&files)});
        return Ok(print(&format!("{all}\n"))?);
    }
    files.iter().for_each(|file| say(&format!("wrote {}", file.display())));
    if !target.is_some_and(|target| target.is_stdout()) {
        print(&text(scene, &poses, &rows))?;
    }
    Ok(())
}

fn csv(rows: &[Row]) -> csv::Result<Vec<u8>> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    let mut head = vec!["y [m]".to_string(), "yaw [rad]".into(), "load [N]".into(), "normalForce [N]".into()];
    for (law, _) in LAWS {
        head.extend(["normalForce [-]", "centre [m]", "area [-]", "creep [mu N]"].map(|what| format!("{law}.{what}")));
    }
    csv.write_record(&head)?;
    for row in rows {
        let mut line = [row.y, row.yaw, row.load, row.normal_force].map(|value| format!("{value:?}")).to_vec();
        for (_, law) in LAWS {
            let shown = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:?}"));
            let found = law(row);
            line.extend([found.map(|d| d.normal_force), found.map(|d| d.centre), found.map(|d| d.area), found.map(|d| d.creep)].map(shown));
        }
        csv.write_record(&line)?;
    }
    csv.into_inner().map_err(|error| csv::Error::from(error.into_error()))
}

fn text(scene: &Scene, poses: &Poses, rows: &[Row]) -> String {
    let mut head = vec!["law".to_string(), "yaw [mrad]".into(), "load [kN]".into(), "poses".into()];
    head.extend(FIGURES.iter().flat_map(|(name, ..)| [format!("{name} mean"), "worst".to_string()]));
    let mut lines = Vec::new();
    for (name, law) in LAWS {
        let mut add = |yaw: Option<f64>, load: Option<f64>| {
            let of: Vec<Row> = rows
                .iter()
                .filter(|row| yaw.is_none_or(|yaw| row.yaw == yaw) && load.is_none_or(|load| row.load == load))
                .cloned()
                .collect();
            let what = |value: Option<f64>, scale: f64| value.map_or("all".to_string(), |value| format!("{:.0}", scale * value));
            let mut line = vec![name.to_string(), what(yaw, 1e3), what(load, 1e-3), of.iter().filter_map(law).count().to_string()];
            for (_, digits, figure) in FIGURES {
                line.extend(
                    mean_and_worst(&of, law, figure).map(|value| if value.is_finite() { format!("{value:.digits$}") } else { "-".into() }),
                );
            }
            lines.push(line);
        };
        poses.yaws.iter().for_each(|yaw| poses.loads.iter().for_each(|load| add(Some(*yaw), Some(*load))));
        add(None, None);
    }
    let contact = &scene.contact;
    format!(
        "{}\n\n  left wheel, y from {:.1} to {:.1} mm by {:.3} mm, in the poses in which half-space contact on {} x {} cells or more carries the load\n  rolling at {} m/s with the pitch rate of the tread circle, friction {}\n\n{}\nN, centre, area: at equal approach; creep: vector of the creep force\nellipse: contact.normal.law = \"{}\" at the deepest place; both with contact.creep.law = \"{}\"\n",
        scene.title,
        1e3 * poses.shifts[0],
        1e3 * poses.shifts[poses.shifts.len() - 1],
        1e3 * (poses.shifts[1] - poses.shifts[0]),
        poses.cells,
        poses.cells,
        scene.vehicle.speed,
        contact.friction,
        table(&head, &lines),
        contact.normal_name,
        contact.creep_name
    )
}
