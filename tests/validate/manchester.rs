//! The Manchester contact benchmark, case: new S1002 wheels on UIC60 rails from the middle of the track to 10 mm and 24 mrad, 10 kN on each wheel.
//!
//! Reference: half-space contact of the open program CONTACT (`tests/data/manchester_contact_benchmark.csv` has the source), whose lateral axis points to the
//! right and which gives forces on the rail; shifts, yaws, rolls and pitch rates are the benchmark's.

use crate::common::{data, read_csv};
use std::collections::HashMap;
use std::f64::consts::PI;
use wheelrail::contact::patch::Settings;
use wheelrail::geometry::Side;
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::study::contact_geometry::Attitude;
use wheelrail::study::{patch, pose};

/// Total vertical force on each wheel, N, and the coefficient of friction.
const LOAD: f64 = 10e3;
const FRICTION: f64 = 0.3;

fn scene(more: &[&str]) -> Scene {
    let case = [
        "track.deviation=[]",
        "track.rail={kind=\"uic60\"}",
        "vehicle.speed=2",
        "contact.friction=0.3",
        // G = 82 GPa.
        "contact.material={youngs_modulus=209.92e9,poisson_ratio=0.28}",
    ];
    let changes: Vec<String> = case.iter().chain(more).map(|change| (*change).to_string()).collect();
    load::open("wheelset_s1002", &changes).unwrap_or_else(|error| panic!("{error}"))
}

/// What a wheel carries: force on it forward, to the left and up, N, contact angle of what is pressed most, rad, highest pressure, Pa, and area, m^2.
struct Found {
    force: [f64; 3],
    angle: f64,
    pressure: f64,
    area: f64,
}

struct Row {
    y: f64,
    side: Side,
    found: Found,
    reference: Found,
}

impl Row {
    /// Difference of the force along the rails and across over mu N.
    fn creep(&self) -> f64 {
        let [along, across] = [0, 1].map(|k| self.found.force[k] - self.reference.force[k]);
        along.hypot(across) / (FRICTION * LOAD)
    }

    fn pressure(&self) -> f64 {
        self.found.pressure / self.reference.pressure - 1.0
    }

    fn area(&self) -> f64 {
        self.found.area / self.reference.area - 1.0
    }
}

/// Wheels at these shifts, mm (all 42 of them where none is named); `found` answers for the lateral shift [m], yaw, roll [rad], pitch rate [rad/s] and the load of the
/// pressures [N].
fn rows(shifts: &[f64], found: impl Fn(Side, [f64; 4], f64) -> Found) -> Vec<Row> {
    let of = |row: &HashMap<String, f64>| {
        let side = if row["left"] == 1.0 { Side::Left } else { Side::Right };
        let (y, yaw, roll) = (-1e-3 * row["y [mm]"], -1e-3 * row["yaw [mrad]"], 1e-3 * row["roll [mrad]"]);
        let reference = Found {
            // On the wheel, left positive: twice the other sign.
            force: [-row["along [N]"], row["to the right [N]"], LOAD],
            angle: row["angle [rad]"].abs(),
            pressure: 1e6 * row["highest pressure [MPa]"],
            area: 1e-6 * row["area [mm2]"],
        };
        let at = |load: f64| found(side, [y, yaw, roll, row["pitch rate [rad/s]"]], load);
        // The benchmark's load is the whole vertical force, creep forces among it.
        let mut found = at(LOAD);
        let mut load = LOAD;
        for _ in 0..5 {
            if (found.force[2] / LOAD - 1.0).abs() < 1e-3 {
                break;
            }
            load *= LOAD / found.force[2];
            found = at(load);
        }
        Row { y: -y, side, found, reference }
    };
    let all = read_csv(&data("manchester_contact_benchmark.csv"));
    assert_eq!(all.len(), 42);
    all.iter().filter(|row| shifts.is_empty() || shifts.contains(&row["y [mm]"])).map(of).collect()
}

fn show(name: &str, rows: &[Row]) {
    for row in rows {
        let Row { y, side, found, reference } = row;
        println!(
            "{:5} y {:4.1} mm: {:7.0} {:7.0} N ({:7.0} {:7.0}), off by {:.3} mu N; angle {:.4} ({:.4}) rad, {:5.0} ({:5.0}) MPa, {:4.1} ({:4.1}) mm2",
            side.name(),
            1e3 * y,
            found.force[0],
            found.force[1],
            reference.force[0],
            reference.force[1],
            row.creep(),
            found.angle,
            reference.angle,
            1e-6 * found.pressure,
            1e-6 * reference.pressure,
            1e6 * found.area,
            1e6 * reference.area
        );
    }
    let percent = |of: fn(&Row) -> f64| [100.0 * mean(rows, of), 100.0 * worst(rows, of)];
    let ([area, most_area], [pressure, most_pressure]) = (percent(Row::area), percent(Row::pressure));
    println!(
        "  {name:<12} {:2} wheels: creep force {:.3} mu N on average, {:.3} at worst; area {area:.1} %, {most_area:.0} %; highest pressure {pressure:.1} %, {most_pressure:.0} %",
        rows.len(),
        mean(rows, Row::creep),
        worst(rows, Row::creep),
    );
}

fn mean(rows: &[Row], of: impl Fn(&Row) -> f64) -> f64 {
    rows.iter().map(|row| of(row).abs()).sum::<f64>() / rows.len() as f64
}

fn worst(rows: &[Row], of: impl Fn(&Row) -> f64) -> f64 {
    rows.iter().map(|row| of(row).abs()).fold(0.0, f64::max)
}

/// What the equations of motion use.
fn by_laws(more: &[&str]) -> Vec<Row> {
    let scene = scene(more);
    rows(&[], |side, [y, yaw, roll, pitch_rate], load| {
        let question = pose::Question {
            y,
            yaw,
            roll: Some(roll),
            height: pose::Height::Load(load),
            station: None,
            speed: 2.0,
            pitch_rate: Some(pitch_rate),
            creepage: None,
        };
        let answer = pose::pose(&scene, &question).unwrap_or_else(|error| panic!("{error}"));
        let wheel = &answer.wheels[side.index()];
        let pressed = || wheel.places.iter().filter(|place| place.found.report.normal_force > 0.0);
        let most = pressed().max_by(|a, b| a.found.report.normal_force.total_cmp(&b.found.report.normal_force)).expect("a place");
        Found {
            force: wheel.force.into(),
            angle: most.angle.abs(),
            pressure: pressed().map(|place| place.found.highest_pressure).fold(0.0, f64::max),
            area: pressed().map(|place| PI * place.found.report.patch.a * place.found.report.patch.b).sum(),
        }
    })
}

/// `wheelrail contact --patch`.
fn by_half_spaces() -> Vec<Row> {
    let scene = scene(&[]);
    rows(&[0.0, 0.5, 1.0, 2.0, 3.5, 5.0, 5.5, 6.5, 8.0, 10.0], |side, [y, yaw, _, pitch_rate], load| {
        let settings = Settings { columns: 32, rows: 32, extrapolate: true, ..Settings::default() };
        let attitude = Attitude { yaw, ..Attitude::default() };
        let question = patch::Question { y, attitude, station: None, load, pitch_rate: Some(pitch_rate), settings };
        let answer = patch::patches(&scene, &question).unwrap_or_else(|error| panic!("{error}"));
        let wheel = &answer.wheels[side.index()];
        Found {
            force: (wheel.solution.pressing + wheel.solution.creep_force).into(),
            angle: wheel.angle.abs(),
            pressure: wheel.solution.highest_pressure(),
            area: wheel.solution.area(),
        }
    })
}

/// Creep force by the law of ellipses, in parts with the slip of the strips.
#[test]
fn validate_strips_on_the_manchester_contact_benchmark() {
    let rows = by_laws(&["contact.creep.law=\"usetab\""]);
    show("strips", &rows);
    assert!(mean(&rows, Row::creep) < 0.01 && worst(&rows, Row::creep) < 0.06);
    assert!(rows.iter().all(|row| (row.found.angle - row.reference.angle).abs() < 0.01 && (row.found.force[2] / LOAD - 1.0).abs() < 2e-3));
    assert!(mean(&rows, Row::area) < 0.05 && worst(&rows, Row::area) < 0.16);
    assert!(mean(&rows, Row::pressure) < 0.04 && worst(&rows, Row::pressure) < 0.18);
}

/// The reference takes the slip over a patch as linear about one place. On the tread of S1002 the wheel's radius over a patch 13 mm wide is no plane: by the mean of
/// `R'' y^2 / 2`, 11 um with R'' = 3 1/m, rolling radii differ at y = 0, which is 0.04 mu N.
#[test]
fn validate_half_spaces_on_the_manchester_contact_benchmark() {
    let rows = by_half_spaces();
    show("half-spaces", &rows);
    assert!(mean(&rows, Row::creep) < 0.015 && worst(&rows, Row::creep) < 0.05);
    assert!(mean(&rows, Row::area) < 0.03 && worst(&rows, Row::area) < 0.1);
    assert!(mean(&rows, Row::pressure) < 0.015 && worst(&rows, Row::pressure) < 0.04);
}

#[test]
fn validate_ellipses_on_the_manchester_contact_benchmark() {
    let rows = by_laws(&["contact.creep.law=\"usetab\"", "contact.patch=\"ellipse\""]);
    show("ellipse", &rows);
    assert!(mean(&rows, Row::creep) < 0.02 && worst(&rows, Row::creep) < 0.25);
}
