//! Checkpoints of long runs: a file that grows by whole blocks, from which a run goes on with the same bits.
//!
//! The first block says of which program, scene, step and columns the run is; every other one holds the rows since the block before it and all that the run
//! remembers at the last of them. Blocks are sealed as saved states are (`serialized`) and never written over: a run that is killed while it writes one leaves
//! those before it whole, and what is behind the last whole block is left out.

use super::recording::{Run, Times, communication_points};
use super::serialized::{self, BlobError};
use super::{Simulation, SimulationState};
use crate::formulation::events::ContactEvent;
use crate::formulation::wheel_loads::NotedLoads;
use crate::scene::spec::Scene;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs::{File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Stands in each block where saved states of an FMU have its GUID.
const OWNER: &str = "checkpoints of wheelrail run";

/// Part of an output step that rounding may put between a row and the end of a run that is asked for, as in [`communication_points`].
const ROUNDING: f64 = 1e-9;

/// Why a run can't be kept or go on.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    #[error("{}: can't be read: {problem}", path.display())]
    Unreadable { path: PathBuf, problem: std::io::Error },
    #[error("{}: can't be written: {problem}", path.display())]
    Unwritable { path: PathBuf, problem: std::io::Error },
    #[error("{}: is no file of checkpoints: {problem}", path.display())]
    Foreign { path: PathBuf, problem: BlobError },
    #[error("{}: these checkpoints are of another version of the program; only the same one goes on with the same bits: begin the run anew", path.display())]
    OtherProgram { path: PathBuf },
    #[error("{}: these checkpoints are of another scene (\"{was}\"): they go on with the same text, files, --set and --inputs alone", path.display())]
    OtherScene { path: PathBuf, was: String },
    #[error("{}: this run writes a row every {was} s, not every {asked} s; go on with that --step", path.display())]
    OtherStep { path: PathBuf, was: f64, asked: f64 },
    #[error("{}: this run does not record {column}; go on with the same --columns, or begin anew", path.display())]
    NoColumn { path: PathBuf, column: String },
    #[error("{}: the run ended before its first checkpoint; begin it anew", path.display())]
    NoState { path: PathBuf },
    #[error("{}: this run is at t = {time} s already, and {stop} s is asked for; choose a later --stop", path.display())]
    Ahead { path: PathBuf, time: f64, stop: f64 },
    #[error("{}: this run has ended at t = {time} s, between two rows of its step of {step} s, and can't go on from there", path.display())]
    BetweenRows { path: PathBuf, time: f64, step: f64 },
    #[error("{}: a checkpoint does not fit the scene: {what}", path.display())]
    Damaged { path: PathBuf, what: &'static str },
    #[error("{}: holds a run that has come to t = {time} s of {stop} s; go on with --resume {}, or remove it", path.display(), path.display())]
    Unfinished { path: PathBuf, time: f64, stop: f64 },
    #[error("{}: a checkpoint can't be made: {problem}", path.display())]
    Encoding { path: PathBuf, problem: BlobError },
}

/// What a run must have in common with its checkpoints to go on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// Build of the program.
    program: String,
    /// Name of the scene, and the hash of its text and files.
    name: String,
    scene: [u8; 32],
    /// Hash of a table of inputs.
    inputs: Option<[u8; 32]>,
}

impl Origin {
    /// With inputs by a table, `text` as it stands in its file.
    pub fn with_inputs(self, text: Option<&str>) -> Origin {
        Origin { inputs: text.map(|text| Sha256::digest(text).into()), ..self }
    }

    /// Of a scene in this program.
    pub fn of(scene: &Scene) -> Origin {
        let mut hash = Sha256::new();
        let mut add = |bytes: &[u8]| {
            hash.update((bytes.len() as u64).to_le_bytes());
            hash.update(bytes);
        };
        add(scene.name.as_bytes());
        add(scene.source.text.as_bytes());
        for file in scene.files() {
            add(file.key.as_bytes());
            add(&file.content);
        }
        Origin { inputs: None, program: env!("WHEELRAIL_BUILD_ID").into(), name: scene.name.clone(), scene: hash.finalize().into() }
    }
}

/// First block.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Head {
    origin: Origin,
    /// Of rows, and the stop time that was asked for first, s.
    step: f64,
    stop: f64,
    /// Names of what a row holds behind the time.
    columns: Vec<String>,
}

/// Every other one.
#[derive(Serialize, Deserialize)]
struct Block {
    /// Since the block before, one after the other.
    rows: Vec<f64>,
    events: Vec<ContactEvent>,
    state: SimulationState,
    loads: NotedLoads,
    left: Vec<Option<(f64, f64, f64)>>,
    /// Wall time of the run until then, s.
    elapsed: f64,
}

/// A run as its checkpoints hold it.
pub struct Found {
    path: PathBuf,
    head: Head,
    rows: Vec<Vec<f64>>,
    events: Vec<ContactEvent>,
    last: Block,
    /// Length of all whole blocks, and of the file, bytes.
    whole: usize,
    length: usize,
}

impl Found {
    /// Reads the checkpoints of a run of the same scene and program.
    ///
    /// # Errors
    /// [`CheckpointError`].
    pub fn read(path: &Path, origin: &Origin) -> Result<Found, CheckpointError> {
        let bytes = std::fs::read(path).map_err(|problem| CheckpointError::Unreadable { path: path.into(), problem })?;
        let head = read_head(path, &bytes)?;
        if head.origin.program != origin.program {
            return Err(CheckpointError::OtherProgram { path: path.into() });
        }
        if head.origin != *origin {
            return Err(CheckpointError::OtherScene { path: path.into(), was: head.origin.name });
        }
        read_blocks(path, head, &bytes)
    }

    /// Names of the columns behind the time.
    pub fn columns(&self) -> &[String] {
        &self.head.columns
    }

    /// When the run goes on, s.
    pub fn time(&self) -> f64 {
        self.last.state.time
    }

    /// Wall time that the run has taken, s.
    pub fn elapsed(&self) -> f64 {
        self.last.elapsed
    }

    /// Bytes behind the last whole block: of one that was being written when the run was killed.
    pub fn torn(&self) -> usize {
        self.length - self.whole
    }

    /// What is wrong where a column is asked for that the rows do not hold.
    pub fn without(&self, column: &str) -> CheckpointError {
        CheckpointError::NoColumn { path: self.path.clone(), column: column.into() }
    }

    /// Can a run to these times go on from here?
    ///
    /// # Errors
    /// [`CheckpointError`].
    pub fn check(&self, Times { stop, step }: Times) -> Result<(), CheckpointError> {
        let (path, time) = (self.path.clone(), self.time());
        if step.to_bits() != self.head.step.to_bits() {
            return Err(CheckpointError::OtherStep { path, was: self.head.step, asked: step });
        }
        if time > stop {
            return Err(CheckpointError::Ahead { path, time, stop });
        }
        // Where a run goes on it stands where the longer one has a row too, or an end that is that row but for rounding (0.78 s for 600 steps of 1.3 ms).
        let start = self.rows[0][0];
        let planned = [start].into_iter().chain(communication_points(start, stop, step)).nth(self.rows.len() - 1);
        match planned {
            Some(planned) if (planned - time).abs() <= ROUNDING * step => Ok(()),
            _ => Err(CheckpointError::BetweenRows { path, time, step }),
        }
    }

    /// Puts a new simulation and its run where the last checkpoint was made.
    ///
    /// # Errors
    /// [`CheckpointError::Damaged`].
    pub fn restore(&self, simulation: &mut Simulation, run: &mut Run) -> Result<(), CheckpointError> {
        let damaged = |what| CheckpointError::Damaged { path: self.path.clone(), what };
        if run.recording.columns.len() != self.head.columns.len() + 1 {
            return Err(damaged("its rows"));
        }
        if !self.last.state.is_sound() || !simulation.restore(&self.last.state) {
            return Err(damaged("its state"));
        }
        if !simulation.go_on_noting(self.last.loads.clone()) || !run.left.go_on(&self.last.left) {
            return Err(damaged("its notes"));
        }
        run.recording.rows.clone_from(&self.rows);
        run.events.clone_from(&self.events);
        Ok(())
    }
}

fn read_head(path: &Path, bytes: &[u8]) -> Result<Head, CheckpointError> {
    let foreign = |problem| CheckpointError::Foreign { path: path.into(), problem };
    let end = serialized::length(bytes).unwrap_or(bytes.len()).min(bytes.len());
    serialized::read(OWNER, &bytes[..end]).map_err(|problem| match problem {
        BlobError::Version(_) => CheckpointError::OtherProgram { path: path.into() },
        other => foreign(other),
    })
}

/// The whole blocks behind the head.
fn read_blocks(path: &Path, head: Head, bytes: &[u8]) -> Result<Found, CheckpointError> {
    let damaged = |what| CheckpointError::Damaged { path: path.into(), what };
    let width = head.columns.len() + 1;
    let (mut rows, mut events, mut last) = (Vec::new(), Vec::new(), None);
    let mut whole = serialized::length(bytes).unwrap_or(bytes.len());
    while let Some(block) = bytes.get(whole..).and_then(|rest| rest.get(..serialized::length(rest)?)) {
        let Ok(mut read) = serialized::read::<Block>(OWNER, block) else { break };
        whole += block.len();
        let new = std::mem::take(&mut read.rows);
        if new.is_empty() && rows.is_empty() || new.len() % width != 0 {
            return Err(damaged("its rows"));
        }
        rows.extend(new.chunks(width).map(<[f64]>::to_vec));
        events.append(&mut read.events);
        last = Some(read);
    }
    let Some(last) = last else { return Err(CheckpointError::NoState { path: path.into() }) };
    if rows.last().is_none_or(|row: &Vec<f64>| row[0].to_bits() != last.state.time.to_bits()) {
        return Err(damaged("its last row"));
    }
    Ok(Found { path: path.into(), head, rows, events, last, whole, length: bytes.len() })
}

/// A file of checkpoints that grows.
#[derive(Debug)]
pub struct Checkpoints {
    path: PathBuf,
    file: File,
    /// Rows and events that it holds.
    rows: usize,
    events: usize,
}

impl Checkpoints {
    /// Begins a new file. One that holds a run which has not come to its end is not written over.
    ///
    /// # Errors
    /// [`CheckpointError`].
    pub fn begin(path: &Path, origin: &Origin, Times { stop, step }: Times, columns: &[String]) -> Result<Checkpoints, CheckpointError> {
        let unwritable = |problem| CheckpointError::Unwritable { path: path.into(), problem };
        if path.exists() {
            check_replaceable(path)?;
        }
        let head = Head { origin: origin.clone(), step, stop, columns: columns.to_vec() };
        let bytes = serialized::write(OWNER, &head).map_err(|problem| CheckpointError::Encoding { path: path.into(), problem })?;
        let mut file = File::create(path).map_err(unwritable)?;
        file.write_all(&bytes).and_then(|()| file.sync_data()).map_err(unwritable)?;
        Ok(Checkpoints { path: path.into(), file, rows: 0, events: 0 })
    }

    /// Goes on with a file behind its last whole block.
    ///
    /// # Errors
    /// [`CheckpointError::Unwritable`].
    pub fn go_on(found: &Found) -> Result<Checkpoints, CheckpointError> {
        let unwritable = |problem| CheckpointError::Unwritable { path: found.path.clone(), problem };
        let mut file = OpenOptions::new().write(true).open(&found.path).map_err(unwritable)?;
        file.set_len(found.whole as u64).and_then(|()| file.seek(SeekFrom::End(0))).map_err(unwritable)?;
        Ok(Checkpoints { path: found.path.clone(), file, rows: found.rows.len(), events: found.events.len() })
    }

    /// Adds a block: the rows since the last one, and the simulation as it stands at the last row. A file that can't take all of it keeps what it had.
    ///
    /// # Errors
    /// [`CheckpointError`].
    pub fn add(&mut self, simulation: &mut Simulation, run: &mut Run, elapsed: f64) -> Result<(), CheckpointError> {
        run.events.append(&mut simulation.take_events());
        let block = Block {
            rows: run.recording.rows[self.rows..].concat(),
            events: run.events[self.events..].to_vec(),
            state: simulation.state.clone(),
            loads: simulation.loads.noted(),
            left: run.left.noted(),
            elapsed,
        };
        let bytes = serialized::write(OWNER, &block).map_err(|problem| CheckpointError::Encoding { path: self.path.clone(), problem })?;
        self.file
            .write_all(&bytes)
            .and_then(|()| self.file.sync_data())
            .map_err(|problem| CheckpointError::Unwritable { path: self.path.clone(), problem })?;
        (self.rows, self.events) = (run.recording.rows.len(), run.events.len());
        Ok(())
    }

    /// Rows that it holds.
    pub fn rows(&self) -> usize {
        self.rows
    }
}

/// Only what holds a run to its end, or none, gives its place to another one.
fn check_replaceable(path: &Path) -> Result<(), CheckpointError> {
    let bytes = std::fs::read(path).map_err(|problem| CheckpointError::Unreadable { path: path.into(), problem })?;
    if bytes.is_empty() {
        return Ok(());
    }
    let head = read_head(path, &bytes)?;
    let stop = head.stop;
    match read_blocks(path, head, &bytes) {
        Ok(found) if found.time() < stop => Err(CheckpointError::Unfinished { path: path.into(), time: found.time(), stop }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load;

    /// A file of a build whose numbers may differ in the last bit, one whose scene has another name, and one of another format.
    #[test]
    fn prop_checkpoints_of_other_programs_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.checkpoints");
        let origin = Origin::of(&load::open("suspended_wheelset", &[]).unwrap());
        let times = Times { stop: 1.0, step: 0.1 };
        let read = |found: &Origin| {
            Checkpoints::begin(&path, found, times, &[]).unwrap();
            Found::read(&path, &origin).err().unwrap()
        };
        assert!(matches!(read(&Origin { program: "older".into(), ..origin.clone() }), CheckpointError::OtherProgram { .. }));
        assert!(
            matches!(read(&Origin { name: "other".into(), ..origin.clone() }), CheckpointError::OtherScene { was, .. } if was == "other")
        );
        assert!(matches!(read(&origin), CheckpointError::NoState { .. }));
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[8] += 1;
        std::fs::write(&path, bytes).unwrap();
        assert!(matches!(Found::read(&path, &origin), Err(CheckpointError::OtherProgram { .. })));
        let other = Origin::of(&load::open("suspended_wheelset", &["vehicle.speed=21".into()]).unwrap());
        assert!(other.scene != origin.scene && other.name == origin.name && other.program == origin.program);
    }
}
