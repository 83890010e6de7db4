//! `wheelrail modes SCENE`: eigenvalues and shapes about steady running, root locus over speed, linear critical speed.

mod cycles;
mod diagram;
mod picture;
mod report;
mod shapes;

use super::progress::bar;
use super::{Failure, SceneArguments, check_picture, file_names, print, say};
use crate::scene::spec::Scene;
use crate::scene::vehicle::FASTEST;
use crate::study::hunting::{self, Diagram, HuntingError};
use crate::study::modes::locus::{self, Locus};
use crate::study::modes::{self, ModesError};
use crate::units::Dimension;
use clap::Args;
use std::path::PathBuf;

#[derive(Args)]
#[command(after_long_help = "\
The steady state is that of the scene's start on undisturbed track, straight or one curve, at the scene's speed: deviations, irregularities and initial displacements are \
left out; a start on a transition or a straight climb is refused, and in curves free travel and ACCF. About it the whole model (contact search, normal and creep laws, suspension, joints) is \
linearised by central differences; constraints of joints and of ECCF and ACCF leave their free directions. The column +- tells by how much the eigenvalue changes with differences of \
twice the length.

--amplitude 0.5mm takes slopes that wheelsets feel which swing across by so much, at equal loads of their wheels (harmonic linearisation; conicity by amplitude, as EN 15302 has it): \
profiles are not linear, and where two humps of one patch exchange their load slopes at a point are others by 3 to 5 % of the frequency. Saturation of creep forces is left out.

A mode grows where its growth is above 0. Damping is in percent of critical. Hunting are lateral motions in which \
wheelsets roll along their wave. What nothing depends on (a wheelset's turn about its axle, the place along the track) or what is imposed \
(the travelling speed) is left out and named.

--sweep vehicle.speed=20..120:5 finds the modes from 20 to 120 m/s every 5 m/s; numbers may carry units, such as \"72km/h..430km/h:18km/h\" (a unit at the end alone counts for all \
three). The critical speed is the first one within the sweep from which on any motion grows, by bisection; others that begin to grow beyond it are named too.

--limit-cycle follows the periodic motions from the speed on at which the first swinging motion begins to grow within the range of the sweep, stable and unstable ones, by their arc length: motions are fixed points of \
the map from one passage of a wheelset through its steady place to the next, and stable where all multipliers (eigenvalues of its slope) are inside the unit circle. Where the branch turns round \
is the lowest speed of the motions that meet there: with a stable one the nonlinear critical speed. Beside it stands what long runs come to that begin with the largest motion found. Swings are half the way between \
extremes; +- is what a tighter integration changes and Newton's method leaves. Takes seconds to minutes. See docs/modes.md.")]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Modes over speed and the critical speed
    #[arg(long, value_name = "vehicle.speed=FROM..TO:STEP")]
    sweep: Option<String>,
    /// Let wheelsets swing across by this for the slopes of profiles (harmonic linearisation), e.g. "0.5 mm" [default: slopes at the steady state]
    #[arg(long, value_name = "LENGTH", conflicts_with = "limit_cycle", allow_hyphen_values = true)]
    amplitude: Option<String>,
    /// Limit cycles within the speeds of --sweep: stable and unstable periodic motions, the nonlinear critical speed
    #[arg(long, requires = "sweep")]
    limit_cycle: bool,
    /// Draw as SVG: the shapes of the slowest modes; with --sweep the root locus, with --limit-cycle swings over speed
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Print the result as JSON (SI units)
    #[arg(long)]
    json: bool,
}

/// Most speeds of a sweep.
const MOST: f64 = 2000.0;

pub(super) fn modes(arguments: &Arguments) -> Result<(), Failure> {
    let scene = arguments.scene.open()?;
    let speeds = arguments.sweep.as_deref().map(sweep).transpose()?;
    let amplitude = amplitude(arguments.amplitude.as_deref())?;
    // Whatever can't be written is better known before the work.
    check_picture(&arguments.plot)?;
    let Some(speeds) = speeds else {
        return at_one_speed(arguments, &scene, amplitude);
    };
    if arguments.limit_cycle {
        return limit_cycles(arguments, &scene, &speeds);
    }
    let found = run(&scene, &speeds, amplitude)?;
    if let Some(file) = &arguments.plot {
        picture::draw(file, &scene, &found).map_err(Failure::Run)?;
    }
    let files: Vec<PathBuf> = arguments.plot.iter().cloned().collect();
    if arguments.json {
        print(&format!("{}\n", serde_json::json!({"locus": found, "pictures": file_names(&files)})))?;
    } else {
        print(&report::locus(&scene, &found))?;
        files.iter().for_each(|file| say(&format!("wrote {}", file.display())));
    }
    Ok(())
}

/// The modes at the scene's speed.
fn at_one_speed(arguments: &Arguments, scene: &Scene, amplitude: f64) -> Result<(), Failure> {
    let found = modes::modes_over(scene, scene.vehicle.speed, amplitude).map_err(|error| failed(scene, &error))?;
    let text = if arguments.json { format!("{}\n", serde_json::json!(found)) } else { report::modes(scene, &found) };
    if let Some(file) = &arguments.plot {
        shapes::draw(file, scene, &found).map_err(Failure::Run)?;
    }
    print(&text)?;
    if let Some(file) = arguments.plot.as_ref().filter(|_| !arguments.json) {
        say(&format!("wrote {}", file.display()));
    }
    Ok(())
}

fn limit_cycles(arguments: &Arguments, scene: &Scene, speeds: &[f64]) -> Result<(), Failure> {
    let progress = Bar(bar(2 * speeds.len() as u64, "{msg}"));
    let found = hunting::diagram(scene, speeds, &progress);
    progress.0.finish_and_clear();
    let found: Diagram = found.map_err(|error| match &error {
        HuntingError::Modes(error) => failed(scene, error),
        HuntingError::None(_) => Failure::Input(format!("{}: {error}", scene.source.file)),
    })?;
    if let Some(file) = &arguments.plot {
        diagram::draw(file, scene, &found).map_err(Failure::Run)?;
    }
    let files: Vec<PathBuf> = arguments.plot.iter().cloned().collect();
    if arguments.json {
        print(&format!("{}\n", serde_json::json!({"limit_cycles": found, "pictures": file_names(&files)})))?;
    } else {
        print(&cycles::cycles(scene, &found))?;
        files.iter().for_each(|file| say(&format!("wrote {}", file.display())));
    }
    Ok(())
}

/// Speeds of the sweep that are done, then motions of the branch, whose number is not known.
struct Bar(indicatif::ProgressBar);

impl hunting::Progress for Bar {
    fn speed(&self) {
        self.0.inc(1);
    }

    fn motion(&self, speed: f64, swing: f64) {
        self.0.set_message(format!("{speed:.2} m/s: {:.2} mm", 1e3 * swing));
        self.0.tick();
    }
}

/// Largest amplitude, m: beyond it flanges carry and creep forces are at their bound, and nothing is nearly linear.
const WIDEST: f64 = 5e-3;

fn amplitude(text: Option<&str>) -> Result<f64, Failure> {
    let Some(text) = text else { return Ok(0.0) };
    let found = crate::cli::contact::number("amplitude", text, Dimension::Length)?;
    let known = found > 0.0 && found <= WIDEST;
    known
        .then_some(found)
        .ok_or_else(|| Failure::Input(format!("--amplitude: found {text}, expected more than 0 and at most {:.0} mm", 1e3 * WIDEST)))
}

fn run(scene: &Scene, speeds: &[f64], amplitude: f64) -> Result<Locus, Failure> {
    let bar = bar(speeds.len() as u64, "");
    let found = locus::locus_over(scene, speeds, amplitude, || bar.inc(1));
    bar.finish_and_clear();
    found.map_err(|error| failed(scene, &error))
}

/// A scene without a steady state is bad input.
fn failed(scene: &Scene, error: &ModesError) -> Failure {
    let words = format!("{}: {error}", scene.source.file);
    match error {
        ModesError::Place { .. }
        | ModesError::InCurve { .. }
        | ModesError::NoStart { .. }
        | ModesError::TooWide { .. }
        | ModesError::Rigid
        | ModesError::OnGrid => Failure::Input(words),
        ModesError::Beside { .. } | ModesError::NoEigenvalues { .. } => Failure::Run(words),
    }
}

/// The speeds of a sweep, m/s, growing.
fn sweep(text: &str) -> Result<Vec<f64>, Failure> {
    let expected = || {
        Failure::Input(format!(
            "--sweep {text}: expected vehicle.speed=FROM..TO:STEP, e.g. vehicle.speed=20..120:5 or \"vehicle.speed=72..430:18 km/h\""
        ))
    };
    let (key, range) = text.split_once('=').ok_or_else(expected)?;
    if key.trim() != "vehicle.speed" {
        return Err(Failure::Input(format!("--sweep {text}: found {}, but modes are swept over vehicle.speed alone", key.trim())));
    }
    let (from, rest) = range.split_once("..").ok_or_else(expected)?;
    let (to, step) = rest.split_once(':').ok_or_else(expected)?;
    let bare = |text: &str| text.trim().parse::<f64>().is_ok();
    let unit = step.trim().trim_start_matches(|c: char| c.is_ascii_digit() || ".+-".contains(c));
    let read = |part: &str| {
        let whole = if bare(part) { format!("{} {unit}", part.trim()) } else { part.to_string() };
        let speed = Dimension::Speed.parse(&whole).filter(|speed| speed.is_finite() && *speed > 0.0);
        speed.ok_or_else(|| {
            Failure::Input(format!("--sweep {text}: {}: expected {}, greater than 0", part.trim(), Dimension::Speed.expectation()))
        })
    };
    let (from, to, step) = (read(from)?, read(to)?, read(step)?);
    let count = (to - from) / step;
    if to.max(from) > FASTEST {
        return Err(Failure::Input(format!("--sweep {text}: {} m/s; expected at most {FASTEST} m/s", to.max(from))));
    }
    if count < 0.0 {
        return Err(Failure::Input(format!("--sweep {text}: {from} m/s is above {to} m/s; expected the lowest speed first")));
    }
    if count >= MOST {
        return Err(Failure::Input(format!("--sweep {text}: {:.0} speeds; expected at most {MOST}", count + 1.0)));
    }
    Ok((0..=(count + 1e-9).floor() as usize).map(|k| from + step * k as f64).collect())
}

#[cfg(test)]
mod tests {
    use super::sweep;

    #[test]
    fn prop_a_sweep_is_read_in_any_unit() {
        let read = |text: &str| sweep(text).ok();
        let close = |found: Option<Vec<f64>>, wanted: &[f64]| {
            let found = found.unwrap();
            assert!(found.len() == wanted.len() && found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        };
        close(read("vehicle.speed=20..30:5"), &[20.0, 25.0, 30.0]);
        close(read("vehicle.speed=72..108:18 km/h"), &[20.0, 25.0, 30.0]);
        close(read("vehicle.speed=72km/h..31:5"), &[20.0, 25.0, 30.0]);
        for wrong in [
            "vehicle.mass=1..2:1",
            "vehicle.speed=20..30",
            "vehicle.speed=30..20:5",
            "vehicle.speed=20..3000:500",
            "vehicle.speed=0..20:5",
            "vehicle.speed=1..2:1 kg",
            "20..30:5",
        ] {
            assert!(read(wrong).is_none(), "{wrong}");
        }
    }
}
