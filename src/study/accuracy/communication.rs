//! What a communication step costs in accuracy: a master gives the leading wheelset a lateral force that it knows only at communication
//! points.
//!
//! F(t) = 1 kN sin(2 pi t / 1 s). Between communication points the wheelset sees it held (as a master without input derivatives gives it),
//! or going on along its tangent or its parabola (first and second input derivatives of FMI). The error of the force over a step H is
//! F' H, F'' H^2 / 2, F''' H^3 / 6: orders 1, 2 and 3. A run without changing inputs does not depend on the communication step at all.
//! Reference: parabolas of steps of an eighth and a sixteenth of the shortest one, with two methods: of order 3, so 512 times as exact.

use super::clock::{Budget, Interrupted, in_seconds};
use super::errors::{Errors, Quantity};
use super::observation::{Observation, needed};
use super::reference::{METHODS, PER_DECADE};
use super::request::Request;
use super::run::{INTERRUPTED, Measured, Setting, repeated, with_setting};
use super::schedule::PILOT_TOLERANCE;
use crate::formulation::LATERAL_FORCE;
use crate::formulation::input_index;
use crate::scene::spec::Scene;
use crate::sim::Simulation;
use crate::sim::recording::{Recording, Times};
use serde::Serialize;
use std::f64::consts::PI;
use std::time::Instant;

/// Amplitude, N, and period, s.
const AMPLITUDE: f64 = 1e3;
const PERIOD: f64 = 1.0;
/// Longest span, s.
const LONGEST: f64 = 2.0;
/// m. As tight as possible: each exchange takes the run back to a point within its last step, by the continuous output.
const REFERENCE_TOLERANCE: f64 = 1e-13;

/// In words.
pub const COUPLING: &str = "a master gives the leading wheelset a lateral force of 1 kN at 1 Hz at communication points";

/// How the force goes on between communication points.
pub const HOLDS: [&str; 3] = ["held", "first derivative", "first and second derivative"];

/// A coupled run.
#[derive(Clone, Debug, Serialize)]
pub struct Coupled {
    /// Index in [`HOLDS`].
    pub hold: usize,
    /// Communication step, s.
    pub step: f64,
    /// s.
    pub stop: f64,
    pub formulation: &'static str,
    pub setting: Setting,
    pub errors: Errors,
    pub measured: Measured,
    /// Errors below this can't be told, m.
    pub floor: f64,
}

/// Takes a sample of a run at an output time.
type Sample<'a> = &'a mut dyn FnMut(&mut Simulation) -> Result<(), String>;

struct Drive<'a> {
    hold: usize,
    step: f64,
    span: Times,
    deadline: Option<Instant>,
    interrupted: Interrupted<'a>,
}

impl Drive<'_> {
    /// Advances to the end; `sample` is called at every output time where it is wanted.
    fn run(&self, simulation: &mut Simulation, mut sample: Option<Sample>) -> Result<(), String> {
        const SAME: f64 = 1e-9;
        let input = input_index(0, LATERAL_FORCE);
        let (mut exchange, mut row) = (0u64, 0u64);
        loop {
            let now = simulation.time();
            if exchange as f64 * self.step <= now + SAME {
                let w = 2.0 * PI / PERIOD;
                let (sine, cosine) = (w * now).sin_cos();
                let slopes = [AMPLITUDE * w * cosine, -AMPLITUDE * w * w * sine];
                let keep = |order: usize| if self.hold >= order { slopes[order - 1] } else { 0.0 };
                simulation.set_input(input, AMPLITUDE * sine, keep(1), keep(2));
                exchange += 1;
                if (self.interrupted)() {
                    return Err(INTERRUPTED.into());
                }
                if self.deadline.is_some_and(|deadline| Instant::now() > deadline) {
                    return Err("the budget has no room for it".into());
                }
            }
            if row as f64 * self.span.step <= now + SAME {
                row += 1;
                if let Some(sample) = &mut sample {
                    sample(simulation)?;
                }
            }
            if now >= self.span.stop - SAME {
                return Ok(());
            }
            let mut next = (exchange as f64 * self.step).min(self.span.stop);
            if sample.is_some() {
                next = next.min(row as f64 * self.span.step);
            }
            simulation.advance(next).map_err(|error| error.to_string())?;
        }
    }

    fn observe(&self, scene: &Scene, wheelset: Option<&str>) -> Result<(Observation, Simulation), String> {
        let mut simulation = Simulation::new(scene, 0.0).map_err(|error| error.to_string())?;
        let outputs = needed(simulation.model(), wheelset);
        let mut recording = Recording::new(&outputs);
        let mut sample = |simulation: &mut Simulation| recording.sample(simulation, &outputs).map_err(|error| error.to_string());
        self.run(&mut simulation, Some(&mut sample))?;
        Ok((Observation::new(&recording, simulation.model()), simulation))
    }
}

/// What the reference takes, s: both methods on a core of their own, where a run at the pilots' tolerance takes `pilot` per simulated second.
pub(super) fn duration(pilot: f64, span: Times) -> f64 {
    pilot * span.stop.min(LONGEST) * PER_DECADE.powf((PILOT_TOLERANCE / REFERENCE_TOLERANCE).log10())
}

/// Every way of holding with every communication step.
pub(super) fn sweep(scene: &Scene, request: &Request, span: Times, budget: &Budget) -> Result<Vec<Coupled>, String> {
    let steps = &request.communication_steps;
    let span = Times { stop: span.stop.min(LONGEST), ..span };
    let interrupted = budget.interrupted;
    let deadline = in_seconds(budget.left_of(1.0).max(0.0));
    let shortest = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let reference = |method: &'static str, part: f64| {
        let setting = Setting { integrator: method, fixed: false, value: REFERENCE_TOLERANCE };
        let drive = Drive { hold: HOLDS.len() - 1, step: shortest / part, span, deadline, interrupted };
        drive.observe(&with_setting(scene, &setting)?, request.wheelset).map(|observed| observed.0)
    };
    let (first, second) = rayon::join(|| reference(METHODS[0], 16.0), || reference(METHODS[1], 8.0));
    let (first, second) = (first?, second?);
    let floor = super::FACTOR * Errors::between(&first, &second).of(Quantity::Displacement).unwrap_or(f64::INFINITY);
    let own = scene.solver.integrator.setting();
    let fixed = own.kind == crate::solve::SettingKind::Step;
    let setting = Setting { integrator: scene.solver.name, fixed, value: own.value };
    let mut all = Vec::new();
    for hold in 0..HOLDS.len() {
        for step in steps.iter().copied().filter(|step| *step <= 0.5 * span.stop) {
            let drive = Drive { hold, step, span, deadline, interrupted };
            let (observation, simulation) = drive.observe(scene, request.wheelset)?;
            let errors = Errors::between(&observation, &first);
            let mut fresh = Simulation::new(scene, 0.0).map_err(|error| error.to_string())?;
            let start = fresh.state().clone();
            let cpu = repeated(&mut fresh, &start, span, request.repeats, |simulation| drive.run(simulation, None))?;
            let measured = Measured { statistics: simulation.statistics(), work: simulation.state().work, cpu };
            let (stop, formulation) = (span.stop, scene.contact.formulation_name);
            all.push(Coupled { hold, step, stop, formulation, setting, errors, measured, floor });
        }
    }
    Ok(all)
}
