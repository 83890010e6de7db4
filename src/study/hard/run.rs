//! One run of a scene on a dense grid, with its books.

use super::audit::Audit;
use super::given::{Audited, InputChange};
use super::trace::Trace;
use crate::scene::spec::Scene;
use crate::sim::{Simulation, SimulationError, SimulationState};
use crate::solve::Statistics;
use crate::study::accuracy::cpu_time;

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum End {
    Finished,
    /// A wheel left its rail.
    Derailed {
        time: f64,
        words: String,
    },
    /// The program gave up.
    Stopped {
        time: f64,
        words: String,
    },
    /// It took longer than it may, s of CPU time.
    Late {
        time: f64,
        limit: f64,
    },
}

/// A run that was looked at.
pub struct Ran {
    pub trace: Trace,
    pub audit: Audit,
    pub end: End,
    /// CPU time of the integration and of looking, s.
    pub cpu: f64,
    pub statistics: Statistics,
    /// Largest static wheel load, N.
    pub load: f64,
    /// Are contacts constraints, so that forces jump where a place changes?
    pub rigid: bool,
    /// Lift-offs and landings, places that vanish.
    pub mode_changes: usize,
    /// Contacts beside the first that began or ended.
    pub touches: usize,
    /// State at about the middle, and when.
    pub middle: Option<(usize, SimulationState)>,
    pub last: Option<SimulationState>,
}

/// When and how a run is looked at.
#[derive(Clone, Copy, Debug)]
pub struct Look<'a> {
    pub stop: f64,
    pub grid: f64,
    pub inputs: &'a [InputChange],
    /// CPU time that it may take, s.
    pub limit: f64,
    pub audit: Audited,
}

impl Look<'_> {
    /// Number of the last sample.
    fn samples(&self) -> usize {
        (self.stop / self.grid).round().max(1.0) as usize
    }

    fn time(&self, sample: usize) -> f64 {
        self.stop * sample as f64 / self.samples() as f64
    }

    /// Sets the inputs that change between the sample before and this one.
    fn drive(&self, simulation: &mut Simulation, sample: usize) {
        for change in self.changes(sample) {
            simulation.set_input(change.input, change.value, 0.0, 0.0);
        }
    }

    fn changes(&self, sample: usize) -> impl Iterator<Item = &InputChange> {
        let (before, now) = (if sample == 0 { f64::NEG_INFINITY } else { self.time(sample - 1) }, self.time(sample));
        self.inputs.iter().filter(move |change| change.time > before && change.time <= now)
    }
}

/// Runs a simulation from its start.
pub fn run(scene: &Scene, simulation: &mut Simulation, look: &Look) -> Ran {
    let mut trace = Trace::new(simulation.model());
    let mut audit = Audit::new(scene, simulation.model(), look.audit);
    let load = simulation.model().wheelsets.iter().map(|wheelset| wheelset.static_wheel_load).fold(0.0, f64::max);
    let rigid = simulation.model().formulation.constrains();
    let (mut cpu, mut mode_changes, mut touches, mut middle) = (0.0, 0, 0, None);
    let mut end = End::Finished;
    for sample in 0..=look.samples() {
        let (done, seconds) = cpu_time(|| -> Result<(), SimulationError> {
            if sample > 0 {
                simulation.advance(look.time(sample))?;
            }
            if look.changes(sample).next().is_some() {
                simulation.snapshot()?;
                audit.push(simulation.model(), simulation.last_snapshot());
                look.drive(simulation, sample);
                simulation.snapshot()?;
                audit.restart(simulation.model(), simulation.last_snapshot());
            }
            let events = simulation.take_events();
            let changes = events.iter().filter(|event| event.change.changes_mode()).count();
            mode_changes += changes;
            touches += events.len() - changes;
            audit.note(&events);
            simulation.snapshot()?;
            Ok(())
        });
        cpu += seconds;
        if let Err(error) = done {
            let (time, words) = (simulation.time(), error.to_string());
            end = if error.is_derailed() { End::Derailed { time, words } } else { End::Stopped { time, words } };
            break;
        }
        trace.push(simulation.last_snapshot());
        if look.changes(sample).next().is_none() {
            audit.push(simulation.model(), simulation.last_snapshot());
        }
        if sample == look.samples() / 2 {
            middle = Some((sample, simulation.state().clone()));
        }
        if cpu > look.limit && sample < look.samples() {
            end = End::Late { time: simulation.time(), limit: look.limit };
            break;
        }
    }
    let last = (end == End::Finished).then(|| simulation.state().clone());
    let statistics = simulation.statistics();
    Ran { trace, audit, end, cpu, statistics, load, rigid, mode_changes, touches, middle, last }
}

/// From a sample to the end; `look_at_it`: evaluating a snapshot at each.
fn go_on(simulation: &mut Simulation, look: &Look, from: usize, look_at_it: bool) -> Result<(), String> {
    for sample in from + 1..=look.samples() {
        simulation.advance(look.time(sample)).map_err(|error| error.to_string())?;
        if look_at_it && look.changes(sample).next().is_some() {
            simulation.snapshot().map_err(|error| error.to_string())?;
        }
        look.drive(simulation, sample);
        if look_at_it {
            simulation.snapshot().map_err(|error| error.to_string())?;
        }
    }
    Ok(())
}

/// Does a simulation that takes up the state of the middle end with the same bits?
///
/// # Errors
/// In words, what differs or fails.
pub fn restored(scene: &Scene, look: &Look, ran: &Ran) -> Result<(), String> {
    let (Some((middle, state)), Some(last)) = (&ran.middle, &ran.last) else { return Ok(()) };
    let words = |error: postcard::Error| error.to_string();
    let bytes = postcard::to_stdvec(state).map_err(words)?;
    let state: SimulationState = postcard::from_bytes(&bytes).map_err(words)?;
    let mut other = Simulation::new(scene, 0.0).map_err(|error| error.to_string())?;
    if !other.restore(&state) {
        return Err("the saved state does not fit its own scene".into());
    }
    go_on(&mut other, look, *middle, false)?;
    let bytes = |state: &SimulationState| postcard::to_stdvec(state).map_err(words);
    if bytes(other.state())? == bytes(last)? {
        return Ok(());
    }
    let away = other.state().integration.y.iter().zip(&last.integration.y).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let what = if away > 0.0 {
        format!("ends elsewhere, by {away:.1e}")
    } else {
        "ends in the same place, but with another memory or other counts".into()
    };
    // Nobody has looked at it on its way; does one that is looked at as the first run was end where that did?
    let mut looked = Simulation::new(scene, 0.0).map_err(|error| error.to_string())?;
    looked.restore(&state);
    go_on(&mut looked, look, *middle, true)?;
    let why = if bytes(looked.state())? == bytes(last)? { " (looking at it changes it)" } else { "" };
    Err(format!("a run that was saved in its middle and restored {what}{why}"))
}

/// Does a run in many communication steps end with the same bits as one in a single step?
///
/// # Errors
/// In words, what differs or fails.
pub fn exchanged(scene: &Scene, look: &Look, count: u64) -> Result<(), String> {
    let end = |count: u64| -> Result<Vec<f64>, String> {
        let mut simulation = Simulation::new(scene, 0.0).map_err(|error| error.to_string())?;
        for exchange in 1..=count {
            simulation.advance(look.stop * exchange as f64 / count as f64).map_err(|error| error.to_string())?;
        }
        Ok(simulation.solution())
    };
    let (many, one) = (end(count)?, end(1)?);
    let same = many.iter().zip(&one).all(|(a, b)| a.to_bits() == b.to_bits());
    if same { Ok(()) } else { Err(format!("{count} communication steps end elsewhere than one")) }
}
