//! `wheelrail contact SCENE`: contact geometry over lateral shift, equivalent conicity.

mod pictures;
mod report;

use super::{Failure, SceneArguments, csv_target, make_folder, print, say};
use crate::scene::spec::Scene;
use crate::study::conicity::{Conicity, NoConicity, RadiusDifference};
use crate::study::contact_geometry::{Attitude, WheelsetOnTrack};
use crate::study::sweep::Sweep;
use crate::units::Dimension;
use clap::Args;
use std::path::PathBuf;

#[derive(Args)]
#[command(after_long_help = "\
The wheelset is set down on its rails at each lateral shift: rigid surfaces, both wheels touch, height and roll are found. With \
--no-roll the axle is held level and each wheel has a height of its own at which it touches, as in EN 15302.

Rows of the CSV: every step, and both sides of each jump of a contact from one place to another (found by bisection, less than a \
nanometre apart). Near a jump a wheel touches at two places; second places that are nearer than --near are listed too.

Equivalent conicity at amplitudes up to the range: by EN 15302 (wavelength of the kinematic motion) and by harmonic \
linearisation. The figures of EN 15302 need --no-roll.

Deviations of the track are left out, unless --at says which place along the track is meant. Lengths are in m and angles in rad; they \
may carry units, such as --range \"10 mm\".")]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Greatest lateral shift to both sides
    #[arg(long, value_name = "Y", default_value = "8 mm")]
    range: String,
    /// Distance of lateral shifts
    #[arg(long, value_name = "H", default_value = "0.1 mm")]
    step: String,
    /// Yaw of the wheelset, left positive
    #[arg(long, value_name = "ANGLE", default_value = "0", allow_hyphen_values = true)]
    yaw: String,
    /// Hold the axle level: each wheel's contact is found at zero roll
    #[arg(long)]
    no_roll: bool,
    /// Place along the track whose deviations count [default: no deviations]
    #[arg(long, value_name = "DISTANCE", allow_hyphen_values = true)]
    at: Option<String>,
    /// Amplitude at which the conicity is reported first
    #[arg(long, value_name = "A", default_value = "3 mm")]
    amplitude: String,
    /// Report second places that are nearer to touching than this
    #[arg(long, value_name = "GAP", default_value = "10 um")]
    near: String,
    /// Write every lateral shift as CSV ("-" for stdout)
    #[arg(short, long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    /// Draw contact geometry, contact points and conicity as SVG into a folder
    #[arg(long, value_name = "DIR")]
    plot: Option<PathBuf>,
    /// Print the result as JSON (SI units)
    #[arg(long)]
    json: bool,
}

/// Most lateral shifts to one side.
const MOST: f64 = 1e5;

/// What was found.
struct Study<'a> {
    scene: &'a Scene,
    wheelset: &'a WheelsetOnTrack,
    sweep: &'a Sweep,
    step: f64,
    /// The amplitude that is asked for first, then those of the table.
    chosen: Conicities,
    table: Vec<Conicities>,
    curve: Vec<Conicities>,
}

/// Both conicities at one amplitude.
struct Conicities {
    /// m.
    amplitude: f64,
    en15302: Result<Conicity, NoConicity>,
    harmonic: Result<Conicity, NoConicity>,
}

impl Conicities {
    fn new(difference: &RadiusDifference, amplitude: f64) -> Self {
        Conicities { amplitude, en15302: difference.en15302(amplitude), harmonic: difference.harmonic(amplitude) }
    }
}

fn number(name: &str, text: &str, dimension: Dimension) -> Result<f64, Failure> {
    let value = dimension.parse(text).filter(|value| value.is_finite());
    value.ok_or_else(|| Failure::Input(format!("--{name} {text}: expected {}", dimension.expectation())))
}

fn positive(name: &str, text: &str) -> Result<f64, Failure> {
    let value = number(name, text, Dimension::Length)?;
    if value > 0.0 { Ok(value) } else { Err(Failure::Input(format!("--{name} {text}: expected a length greater than 0"))) }
}

pub(super) fn contact(arguments: &Arguments) -> Result<(), Failure> {
    let scene = arguments.scene.open()?;
    let (range, step) = (positive("range", &arguments.range)?, positive("step", &arguments.step)?);
    const FURTHEST: f64 = 0.2;
    if range > FURTHEST {
        return Err(Failure::Input(format!("--range {}: {range} m, expected at most {FURTHEST} m, e.g. \"8 mm\"", arguments.range)));
    }
    if range / step > MOST || range < step {
        let count = range / step;
        return Err(Failure::Input(format!("--step {}: {count:.1e} shifts to each side; expected 1 to {MOST:.0e}", arguments.step)));
    }
    let amplitude = positive("amplitude", &arguments.amplitude)?;
    let near = number("near", &arguments.near, Dimension::Length)?;
    let yaw = number("yaw", &arguments.yaw, Dimension::Angle)?;
    const MOST_YAW: f64 = 0.1;
    if !(yaw.abs() <= MOST_YAW) {
        return Err(Failure::Input(format!("--yaw {}: expected an angle of at most {MOST_YAW} rad", arguments.yaw)));
    }
    let station = arguments.at.as_deref().map(|at| number("at", at, Dimension::Length)).transpose()?;
    let target = csv_target(&arguments.output, arguments.json)?;
    if let Some(folder) = &arguments.plot {
        make_folder(folder)?;
    }
    let wheelset = WheelsetOnTrack::new(&scene, Attitude { yaw, level: arguments.no_roll, near }, station);
    let sweep = Sweep::new(&wheelset, range, step).map_err(|error| Failure::Run(format!("{}: {error}", scene.source.file)))?;
    for error in sweep.ended.iter().flatten() {
        say(&format!("the lateral shifts end early: {error}"));
    }
    let difference = RadiusDifference::of_poses(sweep.poses());
    let at = |amplitude: f64| Conicities::new(&difference, amplitude);
    let millimetres = (range / 1e-3 + 1e-9).floor() as usize;
    const CURVE: usize = 200;
    let study = Study {
        scene: &scene,
        wheelset: &wheelset,
        sweep: &sweep,
        step,
        chosen: at(amplitude),
        table: (1..=millimetres.min(20)).map(|mm| at(1e-3 * mm as f64)).collect(),
        curve: (2..=CURVE).map(|k| at(range * k as f64 / CURVE as f64)).collect(),
    };
    if let Some(target) = &target {
        let mut text = Vec::new();
        report::csv(&study, &mut text).map_err(|error| Failure::Run(error.to_string()))?;
        target.write(&text)?;
    }
    let files = match &arguments.plot {
        Some(folder) => pictures::draw(folder, &study).map_err(Failure::Run)?,
        None => Vec::new(),
    };
    if arguments.json {
        print(&format!("{}\n", report::json(&study, &files)))?;
    } else {
        for file in &files {
            say(&format!("wrote {}", file.display()));
        }
        if !target.is_some_and(|target| target.is_stdout()) {
            print(&report::text(&study))?;
        }
    }
    Ok(())
}
