//! Checkpoints of a run: when they are due, where they stand, and how a run goes on from one.

use super::super::{Failure, say, seconds};
use crate::sim::Simulation;
use crate::sim::checkpoint::{CheckpointError, Checkpoints, Found, Origin};
use crate::sim::outputs::Output;
use crate::sim::recording::{Run, Times};
use crate::study::digits::rounded;
use clap::Args;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Args)]
pub(super) struct CheckpointArguments {
    /// Keep the run at intervals, so that --resume can go on: simulated time ("10 s") or the clock's ("5 min wall"), at the next output row
    #[arg(long, value_name = "EVERY", value_parser = interval)]
    checkpoint: Option<Interval>,
    /// File of checkpoints [default: the output's name, or the scene's, with .checkpoints]
    #[arg(long, value_name = "FILE", requires = "checkpoint")]
    checkpoint_file: Option<PathBuf>,
    /// Go on from the last checkpoint in a file: same scene, --set, --step and program; --stop may be later
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
}

/// Between two checkpoints, s.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Interval {
    Simulated(f64),
    Wall(f64),
}

fn interval(text: &str) -> Result<Interval, String> {
    let (time, kind): (&str, fn(f64) -> Interval) = match text.trim_end().strip_suffix("wall") {
        Some(time) => (time, Interval::Wall),
        None => (text, Interval::Simulated),
    };
    let expected = "expected a time above 0 s, such as \"10 s\" (simulated) or \"5 min wall\"";
    seconds(time).ok().filter(|time| time.is_finite() && *time > 0.0).map(kind).ok_or_else(|| expected.into())
}

/// What a user can set right is bad input.
fn refused(error: CheckpointError) -> Failure {
    Failure::Input(error.to_string())
}

impl CheckpointArguments {
    /// The run to go on with, if any.
    pub(super) fn found(&self, origin: &Origin, times: Times) -> Result<Option<Found>, Failure> {
        const OTHERS: [&str; 4] = ["csv", "parquet", "mat", "toml"];
        let ending = |path: &PathBuf| path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        if let Some(path) =
            self.checkpoint_file.as_ref().filter(|path| ending(path).is_some_and(|ending| OTHERS.contains(&ending.as_str())))
        {
            return Err(Failure::Input(format!(
                "--checkpoint-file {}: expected a name that does not end like a result or a scene",
                path.display()
            )));
        }
        let Some(path) = &self.resume else { return Ok(None) };
        if let Some(other) = self.checkpoint_file.as_ref().filter(|other| *other != path) {
            let (path, other) = (path.display(), other.display());
            return Err(Failure::Input(format!(
                "--checkpoint-file {other}: a run that goes on keeps its checkpoints in {path}; expected that file, or none"
            )));
        }
        let found = Found::read(path, origin).map_err(refused)?;
        found.check(times).map_err(refused)?;
        Ok(Some(found))
    }

    /// What keeps the run, if it is to be kept.
    pub(super) fn keeper(
        &self,
        (name, origin): (&str, &Origin),
        times: Times,
        (outputs, output): (&[Output], Option<&Path>),
        found: Option<&Found>,
    ) -> Result<Keeper, Failure> {
        let (time, before) = found.map_or((0.0, 0.0), |found| (found.time(), found.elapsed()));
        let now = Instant::now();
        let mut keeper = Keeper { kept: None, path: PathBuf::new(), time, wall: now, begun: now, before };
        let Some(every) = self.checkpoint else { return Ok(keeper) };
        let beside = || match output.filter(|path| *path != Path::new("-")) {
            Some(path) => path.with_extension("checkpoints"),
            None => PathBuf::from(format!("{name}.checkpoints")),
        };
        keeper.path = self.resume.clone().or_else(|| self.checkpoint_file.clone()).unwrap_or_else(beside);
        let names: Vec<String> = outputs.iter().map(|output| output.name.clone()).collect();
        let file = match found {
            Some(found) => Checkpoints::go_on(found),
            None => Checkpoints::begin(&keeper.path, origin, times, &names),
        };
        keeper.kept = Some((file.map_err(refused)?, every));
        Ok(keeper)
    }
}

/// The outputs of a run that goes on: those that its rows hold.
pub(super) fn columns(found: &Found, all: Vec<Output>, needed: impl Fn(&Output) -> bool) -> Result<Vec<Output>, Failure> {
    match all.iter().find(|output| needed(output) && !found.columns().contains(&output.name)) {
        Some(missing) => Err(refused(found.without(&missing.name))),
        None => Ok(all.into_iter().filter(|output| found.columns().contains(&output.name)).collect()),
    }
}

/// Puts simulation and run where the last checkpoint was made.
pub(super) fn go_on(found: &Found, simulation: &mut Simulation, run: &mut Run) -> Result<(), Failure> {
    found.restore(simulation, run).map_err(refused)?;
    let torn = match found.torn() {
        0 => String::new(),
        bytes => format!("; {bytes} bytes of a checkpoint that was not finished are left out"),
    };
    say(&format!("goes on at t = {} s{torn}", rounded(found.time())));
    Ok(())
}

/// Keeps a run at intervals, and its clock.
pub(super) struct Keeper {
    kept: Option<(Checkpoints, Interval)>,
    path: PathBuf,
    /// Time and clock of the last checkpoint.
    time: f64,
    wall: Instant,
    begun: Instant,
    /// What the run had taken when it was ended, s.
    before: f64,
}

impl Keeper {
    /// Wall time of the whole run, s.
    pub(super) fn elapsed(&self) -> f64 {
        self.before + self.begun.elapsed().as_secs_f64()
    }

    /// Makes a checkpoint where one is due.
    pub(super) fn look(&mut self, simulation: &mut Simulation, run: &mut Run) -> Result<(), CheckpointError> {
        let due = match &self.kept {
            None => false,
            // A row that rounding puts just before it will do.
            Some((_, Interval::Simulated(every))) => simulation.time() - self.time >= every * (1.0 - 1e-9),
            Some((_, Interval::Wall(every))) => self.wall.elapsed().as_secs_f64() >= *every,
        };
        if due { self.add(simulation, run) } else { Ok(()) }
    }

    /// The last checkpoint, where the run ends.
    pub(super) fn end(&mut self, simulation: &mut Simulation, run: &mut Run) -> Result<(), CheckpointError> {
        let new = self.kept.as_ref().is_some_and(|(file, _)| file.rows() < run.recording.rows.len());
        if new { self.add(simulation, run) } else { Ok(()) }
    }

    fn add(&mut self, simulation: &mut Simulation, run: &mut Run) -> Result<(), CheckpointError> {
        let elapsed = self.elapsed();
        if let Some((file, _)) = &mut self.kept {
            file.add(simulation, run, elapsed)?;
            (self.time, self.wall) = (simulation.time(), Instant::now());
        }
        Ok(())
    }

    /// How an interrupted run goes on.
    pub(super) fn words(&self) -> String {
        match self.kept {
            Some(_) => format!("; --resume {} goes on", self.path.display()),
            None => String::new(),
        }
    }
}
