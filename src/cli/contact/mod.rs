//! `wheelrail contact SCENE`: contact geometry over lateral shift, equivalent conicity.

mod patch;
mod patch_laws;
mod patch_map;
mod pictures;
mod pose;
mod report;

use super::{Failure, SceneArguments, csv_target, make_folder, notes, print, say};
use crate::contact::patch::Settings;
use crate::scene::assemble;
use crate::scene::profile_notes::profile_doubts;
use crate::scene::spec::Scene;
use crate::study::conicity::{Conicity, NoConicity, RadiusDifference, RollingPose};
use crate::study::contact_geometry::{Attitude, NoStand, Stand, WheelsetOnTrack};
use crate::study::patch::{NoPatch, Question, elastic_pose};
use crate::study::sweep::Sweep;
use crate::units::Dimension;
use clap::Args;
use rayon::prelude::*;
use std::path::PathBuf;
use std::time::{Duration, Instant};

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
    #[arg(long, value_name = "H", default_value = "0.1 mm", allow_hyphen_values = true)]
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
    /// Solve the patches that really form at one lateral shift under a load: half-space contact of the real surfaces
    #[arg(long)]
    patch: bool,
    /// ... at this lateral shift, left positive
    #[arg(long, value_name = "Y", default_value = "0", allow_hyphen_values = true, requires = "patch")]
    y: String,
    /// ... with this pitch rate, rad/s [default: rolling freely]
    #[arg(long, value_name = "RATE", requires = "patch", conflicts_with = "sweep", allow_hyphen_values = true)]
    pitch_rate: Option<String>,
    /// ... or over --range at this distance, for yaws of 0 and 10 mrad and loads of 10, 50 and 100 kN unless one is named: the law of strips and the
    /// ellipse against it; --plot draws where the left wheel presses
    #[arg(long, value_name = "H", requires = "patch")]
    sweep: Option<String>,
    /// Also roll on the centres of the patches that really form under a load: radius difference and conicity of elastic wheels and rails
    #[arg(long, conflicts_with = "patch")]
    elastic: bool,
    /// Evaluate one pose with all that the scene's laws say of it; keys: y, yaw, roll, one of load (of each wheel), approach and z, speed, pitch_rate
    /// or the creepages longitudinal, lateral and spin; e.g. "y=3mm,yaw=5mrad,load=50kN"
    #[arg(
        long,
        value_name = "KEY=VALUE,...",
        allow_hyphen_values = true,
        conflicts_with_all = ["patch", "elastic", "yaw", "load", "output", "plot"]
    )]
    pose: Option<String>,
    /// Vertical load of each wheel with --patch and --elastic [default: the static one]
    #[arg(long, value_name = "Q", allow_hyphen_values = true)]
    load: Option<String>,
    /// Cells of --patch each way [default: 64; with --sweep 32]; more where the wheel presses at several small places
    #[arg(long, value_name = "N", requires = "patch")]
    cells: Option<usize>,
    /// Write every lateral shift (with --patch: every cell) as CSV ("-" for stdout)
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
    /// NP, 1/m.
    nonlinearity: Result<f64, NoConicity>,
    /// The same of elastic wheels and rails.
    elastic: Option<Elastic>,
}

/// What rolls on the centres of patches under a load.
struct Elastic {
    /// Vertical, of each wheel, N.
    load: f64,
    /// y and rolling-radius difference, m.
    differences: Vec<(f64, f64)>,
    chosen: Conicities,
    table: Vec<Conicities>,
    curve: Vec<Conicities>,
    nonlinearity: Result<f64, NoConicity>,
    /// The amplitude [m] at which every other shift would change the conicity most, in parts, and by that, where it is much.
    coarse: Option<(f64, f64)>,
}

/// Changes of an elastic conicity by every other shift that are told, in parts of it; and a conicity that is small, -.
const COARSE: f64 = 0.03;
const SMALL: f64 = 0.03;

impl Elastic {
    fn new(
        scene: &Scene,
        wheelset: &WheelsetOnTrack,
        sweep: &Sweep,
        load: f64,
        [chosen, table, curve]: [&[f64]; 3],
    ) -> Result<Self, Failure> {
        let settings = Settings { columns: 24, rows: 24, extrapolate: false, ..Settings::default() };
        let question = Question { y: 0.0, attitude: wheelset.attitude, station: Some(wheelset.station), load, pitch_rate: None, settings };
        let stands: Vec<&Stand> = sweep.samples.iter().filter(|sample| sample.asked).map(|sample| &sample.stand).collect();
        // Neighbours are lowered by about as much.
        let in_a_row = |stands: &[&Stand]| -> Result<Vec<RollingPose>, NoPatch> {
            let mut near = None;
            let pose = |stand: &&Stand| {
                let (pose, lowered) = elastic_pose(scene, &question, wheelset, stand, near)?;
                near = Some(lowered);
                Ok(pose)
            };
            stands.iter().map(pose).collect()
        };
        let poses: Result<Vec<Vec<RollingPose>>, NoPatch> = stands.par_chunks(NEIGHBOURS).map(in_a_row).collect();
        let poses = poses.map_err(|error| Failure::Run(format!("{}: {error}", scene.source.file)))?.concat();
        let differences = poses.iter().map(|pose| (pose.y, pose.radii[0] - pose.radii[1])).collect();
        let every_other = RadiusDifference::of_poses(poses.iter().step_by(2).copied());
        let difference = RadiusDifference::of_poses(poses);
        // Where a flange takes over the difference grows by millimetres within one or two tenths of one: it is what lies between shifts.
        let change = |amplitude: f64| {
            let [fine, coarse] = [&difference, &every_other].map(|of| Conicities::new(of, amplitude).en15302);
            let [fine, coarse] = [fine.ok()?.value, coarse.ok()?.value];
            Some((amplitude, (fine - coarse).abs() / fine.abs().max(SMALL)))
        };
        let changes = chosen.iter().chain(table).filter_map(|amplitude| change(*amplitude));
        let coarse = changes.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, part)| *part > COARSE);
        let all = |amplitudes: &[f64]| amplitudes.iter().map(|amplitude| Conicities::new(&difference, *amplitude)).collect();
        let nonlinearity = difference.nonlinearity();
        Ok(Elastic {
            load,
            differences,
            chosen: Conicities::new(&difference, chosen[0]),
            table: all(table),
            curve: all(curve),
            nonlinearity,
            coarse,
        })
    }

    /// What a user should know of the shifts.
    fn note(&self) -> Option<String> {
        let (amplitude, part) = self.coarse?;
        Some(format!(
            "shifts at twice the distance change the elastic conicity at {:.1} mm by {:.0} %: it is known to some part of that; a smaller --step resolves it",
            1e3 * amplitude,
            100.0 * part
        ))
    }
}

/// Wheel and rail, radius at the tread circle, gauge and inclination, for the subtitle of a picture.
fn pair_in_force(scene: &Scene) -> String {
    let (track, wheels) = (&scene.track, &scene.vehicle.leading().profiles);
    let gauge = track
        .gauge()
        .map_or_else(|| format!("rail_distance {:.1} mm", 2e3 * track.half_rail_distance), |gauge| format!("gauge {:.1} mm", 1e3 * gauge));
    let named = |names: [String; 2]| if names[0] == names[1] { names[0].clone() } else { names.join(" and ") };
    let radii = [0, 1].map(|side| format!("{:.1} mm", 1e3 * wheels[side].profile.at(0.0).value));
    format!(
        "{} on {}; radius {}, {}, rails inclined {:.2} deg",
        named([0, 1].map(|side| wheels[side].profile.describe())),
        named([0, 1].map(|side| track.rails[side].profile.describe())),
        named(radii),
        gauge,
        track.inclination.to_degrees()
    )
}

/// Stands that are computed one after the other.
const NEIGHBOURS: usize = 16;

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

pub(in crate::cli) fn number(name: &str, text: &str, dimension: Dimension) -> Result<f64, Failure> {
    let value = dimension.parse(text).filter(|value| value.is_finite());
    value.ok_or_else(|| Failure::Input(format!("--{name} {text}: expected {}", dimension.expectation())))
}

fn positive(name: &str, text: &str) -> Result<f64, Failure> {
    let value = number(name, text, Dimension::Length)?;
    if value > 0.0 { Ok(value) } else { Err(Failure::Input(format!("--{name} {text}: expected a length greater than 0"))) }
}

/// The load of each wheel, N.
fn load(arguments: &Arguments, scene: &Scene) -> Result<f64, Failure> {
    const HEAVIEST: f64 = 1e6;
    let load = match &arguments.load {
        Some(load) => number("load", load, Dimension::Force)?,
        None => assemble::model(scene).map_err(|error| Failure::Run(error.to_string()))?.wheelsets[0].static_wheel_load,
    };
    if load > 0.0 && load <= HEAVIEST {
        Ok(load)
    } else {
        Err(Failure::Input(format!("a wheel load of {load} N: expected one above 0, up to {HEAVIEST:.0e} N, e.g. --load \"50 kN\"")))
    }
}

/// How the wheelset is held, and the place along the track whose deviations count, m.
fn attitude(arguments: &Arguments) -> Result<(Attitude, Option<f64>), Failure> {
    let near = number("near", &arguments.near, Dimension::Length)?;
    let yaw = number("yaw", &arguments.yaw, Dimension::Angle)?;
    const MOST_YAW: f64 = 0.1;
    if !(yaw.abs() <= MOST_YAW) {
        return Err(Failure::Input(format!("--yaw {}: expected an angle of at most {MOST_YAW} rad", arguments.yaw)));
    }
    let station = arguments.at.as_deref().map(|at| number("at", at, Dimension::Length)).transpose()?;
    Ok((Attitude { yaw, level: arguments.no_roll, near }, station))
}

/// Says after some seconds what takes so long, once: noisy points, mostly, on which contacts jump from one to the next.
fn patience(scene: &Scene) -> impl FnMut(f64) {
    const LONG: Duration = Duration::from_secs(3);
    let begin = Instant::now();
    let mut words = Some(notes(profile_doubts(scene)));
    move |y| {
        if begin.elapsed() > LONG
            && let Some(words) = words.take()
        {
            let y = 1e3 * y;
            say(&format!(
                "contact geometry is at y = {y:.3} mm; wherever a contact jumps, the jump is closed in to a nanometre, which may take minutes{words}"
            ));
        }
    }
}

/// Why there is nothing to show, and what in the profiles may be the cause.
fn no_sweep(scene: &Scene, error: &NoStand) -> Failure {
    let doubts = profile_doubts(scene).into_iter().map(|doubt| format!("\n  note: {doubt}"));
    Failure::Run(format!("{}: {error}{}", scene.source.file, doubts.collect::<String>()))
}

pub(super) fn contact(arguments: &Arguments) -> Result<(), Failure> {
    let scene = arguments.scene.open()?;
    if let Some(given) = &arguments.pose {
        return pose::pose(arguments, &scene, given);
    }
    if let Some(step) = &arguments.sweep {
        return patch_laws::patch_laws(arguments, &scene, step);
    }
    if arguments.patch {
        return patch::patch(arguments, &scene);
    }
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
    let (attitude, station) = attitude(arguments)?;
    let target = csv_target(&arguments.output, arguments.json)?;
    if let Some(folder) = &arguments.plot {
        make_folder(folder)?;
    }
    let wheelset = WheelsetOnTrack::new(&scene, attitude, station);
    let sweep = Sweep::watched(&wheelset, range, step, &mut patience(&scene)).map_err(|error| no_sweep(&scene, &error))?;
    for error in sweep.ended.iter().flatten() {
        say(&format!("the lateral shifts end early: {error}"));
    }
    let difference = RadiusDifference::of_poses(sweep.poses());
    let at = |amplitude: &f64| Conicities::new(&difference, *amplitude);
    let millimetres = (range / 1e-3 + 1e-9).floor() as usize;
    const CURVE: usize = 200;
    let table: Vec<f64> = (1..=millimetres.min(20)).map(|mm| 1e-3 * mm as f64).collect();
    let curve: Vec<f64> = (2..=CURVE).map(|k| range * k as f64 / CURVE as f64).collect();
    let elastic = arguments.elastic.then(|| {
        let load = load(arguments, &scene)?;
        Elastic::new(&scene, &wheelset, &sweep, load, [&[amplitude], &table, &curve])
    });
    let study = Study {
        scene: &scene,
        wheelset: &wheelset,
        sweep: &sweep,
        step,
        chosen: at(&amplitude),
        table: table.iter().map(at).collect(),
        curve: curve.iter().map(at).collect(),
        nonlinearity: difference.nonlinearity(),
        elastic: elastic.transpose()?,
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
