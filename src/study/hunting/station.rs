//! A vehicle at one speed, run from one passage of its leading swing to the next.
//!
//! The section is where the lateral displacement of one wheelset passes its steady value to the left. A place on it is the state beside the steady one, in millimetres
//! and milliradians, velocities in parts of what such a swing has. Travel along the track and states on which nothing depends (the
//! turn of wheelsets) grow from turn to turn; they are taken back, which changes nothing.

use super::extremes::{Extremes, bisect};
use crate::mbs::body::{COORDINATES, LATERAL};
use crate::scene::spec::Scene;
use crate::sim::{Simulation, SimulationError, SimulationState};
use crate::study::cycles::{Lost, Turn};
use crate::study::modes::{self, ModesError};
use std::ops::ControlFlow;

/// A displacement of this is a place of 1, m and rad; velocities count in parts of it, 1/s.
pub const LENGTH: f64 = 1e-3;
const RATE: f64 = 30.0;
/// A motion that swings less than this is at rest, m.
const REST: f64 = 1e-7;

/// What is the same at all speeds.
#[derive(Clone, Debug)]
pub struct Section {
    /// The state whose passage is looked for.
    pub lead: usize,
    /// Size of a place of 1 of each state.
    scales: Vec<f64>,
    /// States of which a place has no part: they are imposed, or nothing depends on them.
    left_out: Vec<usize>,
    /// The body whose travel is imposed.
    driven: usize,
    bodies: usize,
    /// Lateral displacements that are observed.
    observed: Vec<usize>,
    /// A turn takes no longer than this, s.
    longest: f64,
}

impl Section {
    /// Of a simulation in its steady state, about a mode's shape: the wheelset that moves most in it leads.
    ///
    /// # Errors
    /// Why there is none, in words.
    pub fn new(simulation: &Simulation, shape: &[[f64; 2]], period: f64) -> Result<Self, String> {
        let system = &simulation.model().system;
        let bodies = system.bodies.len();
        let size = |state: usize| f64::hypot(shape[state][0], shape[state][1]);
        let observed: Vec<usize> = simulation.model().wheelsets.iter().map(|wheelset| COORDINATES * wheelset.body + LATERAL).collect();
        let lead = observed.iter().copied().max_by(|a, b| size(*a).total_cmp(&size(*b))).ok_or("there is no wheelset")?;
        let driven = system
            .drives
            .first()
            .ok_or("nothing imposes the speed: hunting takes its energy from the vehicle's own, and is not periodic")?
            .body;
        let mut left_out = modes::indifferent(simulation).map_err(|error| error.to_string())?;
        for wheelset in &simulation.model().wheelsets {
            if !left_out.contains(&(COORDINATES * wheelset.body + COORDINATES - 1)) {
                return Err(format!("{}: its turn about the axle is felt, so that no motion repeats itself", wheelset.name));
            }
        }
        left_out.extend(system.drives.iter().flat_map(|drive| [0, COORDINATES * bodies].map(|first| first + COORDINATES * drive.body)));
        left_out.push(lead);
        // Other states count as much as the largest of them moves beside the leading wheelset.
        let count = 2 * COORDINATES * bodies;
        let other = (count..shape.len()).map(|state| size(state) / size(lead)).fold(0.0, f64::max);
        let scale = |state: usize| match state {
            _ if state < COORDINATES * bodies => LENGTH,
            _ if state < count => RATE * LENGTH,
            _ if other > 0.0 => other * LENGTH,
            _ => LENGTH,
        };
        let scales = (0..shape.len()).map(scale).collect();
        Ok(Section { lead, scales, left_out, driven, bodies, observed, longest: 6.0 * period })
    }

    /// A mode's shape on the section, the leading wheelset swinging by so much, m.
    pub fn place(&self, shape: &[[f64; 2]], swing: f64) -> Vec<f64> {
        // At the passage the swing y = Re(c e^(i p)) is zero and grows: e^(i p) = -i |c| / c.
        let [re, im] = shape[self.lead];
        let size = f64::hypot(re, im);
        let (turn_re, turn_im) = (-im / size, -re / size);
        let part = |[a, b]: &[f64; 2]| swing / size * (a * turn_re - b * turn_im);
        let mut place: Vec<f64> = shape.iter().zip(&self.scales).map(|(part_of, scale)| part(part_of) / scale).collect();
        self.cut(&mut place);
        place
    }

    /// What a place has no part of.
    fn cut(&self, place: &mut [f64]) {
        self.left_out.iter().for_each(|state| place[*state] = 0.0);
    }

    /// Number of the leading wheelset among the model's.
    pub fn leading(&self) -> usize {
        self.observed.iter().position(|state| *state == self.lead).unwrap_or(0)
    }
}

/// A vehicle at a speed.
#[derive(Debug)]
pub struct Station {
    pub speed: f64,
    simulation: Simulation,
    steady: SimulationState,
}

/// The scene at a speed, rolling steadily.
///
/// # Errors
/// [`ModesError`].
pub fn steady(scene: &Scene, speed: f64) -> Result<Simulation, ModesError> {
    modes::steady(&modes::undisturbed(scene, speed)?, speed)
}

impl Station {
    /// # Errors
    /// [`Lost`] where there is no steady state.
    pub fn new(scene: &Scene, speed: f64) -> Result<Self, Lost> {
        let simulation = steady(scene, speed).map_err(|error| Lost::Failed(error.to_string()))?;
        Ok(Station { speed, steady: simulation.state().clone(), simulation })
    }

    fn begin(&mut self, section: &Section, from: &[f64]) {
        let mut state = self.steady.clone();
        let mut from = from.to_vec();
        section.cut(&mut from);
        for ((y, part), scale) in state.integration.y.iter_mut().zip(&from).zip(&section.scales) {
            *y += part * scale;
        }
        self.simulation.restore(&state);
    }

    /// The place of a solution.
    fn place(&self, section: &Section, y: &[f64]) -> Vec<f64> {
        let base = &self.steady.integration.y;
        let x = COORDINATES * section.driven;
        let travelled = y[x] - base[x];
        let own = |state: usize| if state < COORDINATES * section.bodies && state.is_multiple_of(COORDINATES) { travelled } else { 0.0 };
        let mut place: Vec<f64> = (0..y.len()).map(|state| (y[state] - own(state) - base[state]) / section.scales[state]).collect();
        section.cut(&mut place);
        place
    }

    /// Runs without a stop from a place; `each` gets every turn and says whether to go on.
    ///
    /// # Errors
    /// [`Lost`].
    pub fn run(&mut self, section: &Section, from: &[f64], mut each: impl FnMut(Turn) -> ControlFlow<()>) -> Result<(), Lost> {
        self.begin(section, from);
        let failed = |error: SimulationError| Lost::Failed(error.to_string());
        let lead = section.lead;
        let middle = self.steady.integration.y[lead];
        let mut extremes = Extremes::new(&section.observed, COORDINATES * section.bodies);
        let mut last = self.simulation.state().integration.y.clone();
        let mut y = last.clone();
        let (mut passed, mut been_right) = (self.simulation.time(), false);
        extremes.begin(&last);
        loop {
            self.simulation.advance_to_stop(f64::INFINITY).map_err(failed)?;
            let (begin, end) = (self.simulation.state().integration.step_begin(), self.simulation.state().integration.t);
            y.copy_from_slice(&self.simulation.state().integration.y);
            extremes.see(&last, &y, (begin, end), |time, y| self.simulation.solution_at(time, y));
            if been_right && last[lead] < middle && y[lead] >= middle {
                let mut at = vec![0.0; last.len()];
                let time = bisect(begin, end, |time| {
                    self.simulation.solution_at(time, &mut at);
                    at[lead] < middle
                });
                self.simulation.solution_at(time, &mut at);
                let swings = extremes.take();
                if swings.iter().all(|swing| *swing < REST) {
                    return Err(Lost::NoReturn);
                }
                let turn = Turn { to: self.place(section, &at), period: time - passed, swings };
                if each(turn).is_break() {
                    return Ok(());
                }
                (passed, been_right) = (time, false);
                extremes.begin(&at);
            }
            been_right |= y[lead] < middle;
            std::mem::swap(&mut last, &mut y);
            if end - passed > section.longest {
                return Err(Lost::NoReturn);
            }
        }
    }
}
