//! A watch around an integrator: it hands everything on and times the integrator's calls of the system.
//!
//! The simulation runs as always, with [`Watched`] in place of its integrator, which shows the integrator [`Guarded`] in place of the
//! system. So nothing on the product's own stepping path knows of a clock. Reading the clock takes some 30 ns, twice per call; both what falls
//! into the timed section and what falls beside it are measured and taken off.

use crate::solve::{Dynamics, Event, Implicit, IntegrationState, Integrator, Scratch, Setting, SolveError, StiffPart, Undefined};
use std::cell::{Cell, RefCell};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// What an integrator calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Call {
    /// Right-hand sides.
    Derivative,
    /// Jacobians.
    Linearise,
    /// Factorisations of I - a J.
    Factorise,
    /// Solutions with them.
    Solve,
    /// Projections onto constraints; looking for breaks of the track and for changes of contacts; these changes.
    Keep,
}

pub(super) const CALLS: usize = 5;

/// Number of calls and their time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Tally {
    pub count: u64,
    pub time: Duration,
}

/// Arguments of an evaluation in a run: time, state, and memory before it.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    pub t: f64,
    pub y: Vec<f64>,
}

/// Keeps evaluations at equal distances (counted in evaluations), however many there will be.
#[derive(Debug, Default)]
struct Sampler {
    kept: Vec<Sample>,
    every: u64,
    seen: u64,
}

/// Between so many and twice as many samples are kept.
const SAMPLES: usize = 40;

impl Sampler {
    fn note(&mut self, t: f64, y: &[f64]) {
        self.every = self.every.max(1);
        if self.seen.is_multiple_of(self.every) {
            if self.kept.len() == 2 * SAMPLES {
                // Every other one goes: those left are still at equal distances, and so is this one.
                let mut place = 0;
                self.kept.retain(|_| {
                    place += 1;
                    place % 2 == 1
                });
                self.every *= 2;
            }
            self.kept.push(Sample { t, y: y.to_vec() });
        }
        self.seen += 1;
    }
}

/// What was counted and timed.
#[derive(Debug, Default)]
pub(super) struct Meter {
    tallies: [Cell<Tally>; CALLS],
    /// Did a Jacobian cover more than the contacts?
    whole: Cell<bool>,
    /// Samples are taken in a run of their own, whose times do not count.
    sampler: Option<RefCell<Sampler>>,
}

impl Meter {
    fn timed<T>(&self, call: Call, work: impl FnOnce() -> T) -> T {
        let clock = Instant::now();
        let done = work();
        let time = clock.elapsed();
        let cell = &self.tallies[call as usize];
        let Tally { count, time: before } = cell.get();
        cell.set(Tally { count: count + 1, time: before + time });
        done
    }
}

/// A meter that an integrator and its reader share.
#[derive(Clone, Debug, Default)]
pub(super) struct Shared(Arc<Mutex<Meter>>);

impl Shared {
    fn with<T>(&self, work: impl FnOnce(&mut Meter) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// From now on evaluations are kept.
    pub(super) fn sample(&self) {
        self.with(|meter| meter.sampler = Some(RefCell::default()));
    }

    /// Ends that; gives them.
    pub(super) fn take_samples(&self) -> Vec<Sample> {
        self.with(|meter| meter.sampler.take().map(|sampler| sampler.into_inner().kept)).unwrap_or_default()
    }

    /// Do Jacobians cover the force elements too?
    pub(super) fn covers_forces(&self) -> bool {
        self.with(|meter| meter.whole.get())
    }

    /// Gives the tallies and begins anew.
    pub(super) fn take(&self) -> [Tally; CALLS] {
        self.with(|meter| std::array::from_fn(|call| meter.tallies[call].take()))
    }
}

/// Time that a call of the watch itself takes, s: the part that it counts as the call's, and all of it.
pub(super) fn own_time() -> [f64; 2] {
    const CALLS: u32 = 2000;
    const ROUNDS: usize = 10;
    let mut best = [f64::INFINITY; 2];
    for _ in 0..ROUNDS {
        let meter = Meter::default();
        let clock = Instant::now();
        for _ in 0..CALLS {
            std::hint::black_box(&meter).timed(Call::Keep, || ());
        }
        let all = clock.elapsed().as_secs_f64() / f64::from(CALLS);
        let inside = meter.tallies[Call::Keep as usize].get().time.as_secs_f64() / f64::from(CALLS);
        best = [best[0].min(inside), best[1].min(all)];
    }
    best
}

/// An integrator under the watch.
#[derive(Clone, Debug)]
pub(super) struct Watched {
    pub inner: Arc<dyn Integrator>,
    pub meter: Shared,
}

impl Integrator for Watched {
    fn setting(&self) -> Setting {
        self.inner.setting()
    }

    fn with_setting(&self, value: f64) -> Arc<dyn Integrator> {
        Arc::new(Watched { inner: self.inner.with_setting(value), meter: self.meter.clone() })
    }

    fn dense_vectors(&self) -> usize {
        self.inner.dense_vectors()
    }

    fn record_vectors(&self) -> usize {
        self.inner.record_vectors()
    }

    fn linearises(&self) -> bool {
        self.inner.linearises()
    }

    fn worst_case(&self) -> Option<String> {
        self.inner.worst_case()
    }

    fn slack(&self) -> f64 {
        self.inner.slack()
    }

    fn step(&self, dynamics: &mut dyn Implicit, state: &mut IntegrationState, scratch: &mut Scratch) -> Result<(), SolveError> {
        self.meter.with(|meter| self.inner.step(&mut Guarded { inner: dynamics, meter }, state, scratch))
    }

    fn start(&self, t: f64, y: &[f64]) -> IntegrationState {
        self.inner.start(t, y)
    }

    fn advance(
        &self,
        dynamics: &mut dyn Implicit,
        state: &mut IntegrationState,
        scratch: &mut Scratch,
        target: f64,
    ) -> Result<(), SolveError> {
        self.meter.with(|meter| self.inner.advance(&mut Guarded { inner: dynamics, meter }, state, scratch, target))
    }
}

/// A system under the watch.
pub(super) struct Guarded<'a> {
    inner: &'a mut dyn Implicit,
    meter: &'a Meter,
}

impl Guarded<'_> {
    fn note(&self, t: f64, y: &[f64]) {
        if let Some(sampler) = &self.meter.sampler {
            sampler.borrow_mut().note(t, y);
        }
    }
}

impl Dynamics for Guarded<'_> {
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        self.note(t, y);
        self.meter.timed(Call::Derivative, || self.inner.derivative(t, y, dy))
    }

    fn repeat(&mut self, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        self.note(t, y);
        self.meter.timed(Call::Derivative, || self.inner.repeat(t, y, dy))
    }

    fn project(&mut self, t: f64, y: &mut [f64]) -> Result<bool, Undefined> {
        self.meter.timed(Call::Keep, || self.inner.project(t, y))
    }

    fn next_break(&self, t: f64, y: &[f64]) -> f64 {
        self.meter.timed(Call::Keep, || self.inner.next_break(t, y))
    }

    fn derivative_at_end(&mut self, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        self.note(t, y);
        self.meter.timed(Call::Derivative, || self.inner.derivative_at_end(t, y, dy))
    }
    fn rollback(&mut self) {
        self.inner.rollback();
    }
    fn accept(&mut self, evaluated: bool) {
        self.inner.accept(evaluated);
    }
    fn is_cached(&self) -> bool {
        self.inner.is_cached()
    }
    fn event_functions(&self) -> usize {
        self.inner.event_functions()
    }
    fn event_values(&self, values: &mut [f64]) {
        self.inner.event_values(values);
    }
    fn due(&self, t: f64) -> Option<Event> {
        self.inner.due(t)
    }
    fn on_event(&mut self, event: Event, t: f64, y: &mut [f64]) -> Result<bool, Undefined> {
        self.meter.timed(Call::Keep, || self.inner.on_event(event, t, y))
    }

    fn release(&mut self, t: f64, y: &mut [f64]) -> Result<bool, Undefined> {
        self.meter.timed(Call::Keep, || self.inner.release(t, y))
    }

    // Too short to be timed, and asked for by the integrator's own work.
    fn error_weight(&self, i: usize) -> f64 {
        self.inner.error_weight(i)
    }

    fn coordinates(&self) -> usize {
        self.inner.coordinates()
    }

    fn longest_step(&self, dy: &[f64]) -> f64 {
        self.inner.longest_step(dy)
    }

    fn longest_known(&self) -> f64 {
        self.inner.longest_known()
    }

    fn load_error(&self, error: &[f64]) -> f64 {
        self.inner.load_error(error)
    }

    fn swing_error(&self, error: &[f64]) -> f64 {
        self.inner.swing_error(error)
    }

    fn note_step(&mut self, t: f64) {
        self.inner.note_step(t);
    }

    fn doubtful_error(&self) -> f64 {
        self.inner.doubtful_error()
    }
}

impl Implicit for Guarded<'_> {
    fn linearise(&mut self, t: f64, y: &[f64], part: StiffPart) -> Result<(), Undefined> {
        self.meter.whole.set(self.meter.whole.get() | (part == StiffPart::All));
        self.meter.timed(Call::Linearise, || self.inner.linearise(t, y, part))
    }

    fn factorise(&mut self, a: f64) -> Result<(), Undefined> {
        self.meter.timed(Call::Factorise, || self.inner.factorise(a))
    }

    fn solve_linear(&mut self, x: &mut [f64]) {
        self.meter.timed(Call::Solve, || self.inner.solve_linear(x));
    }

    fn solve_linear_pushed(&mut self, x: &mut [f64], weight: f64, push: &[f64]) {
        self.meter.timed(Call::Solve, || self.inner.solve_linear_pushed(x, weight, push));
    }

    // The carried motion counts as the integrator's own.
    fn carry(&mut self, ahead: f64, shift: &mut [f64], rate: &mut [f64]) -> bool {
        self.inner.carry(ahead, shift, rate)
    }

    fn keep_carried(&mut self) {
        self.inner.keep_carried();
    }

    fn add_carried(&self, ahead: f64, y: &mut [f64]) {
        self.inner.add_carried(ahead, y);
    }

    fn carried_change(&mut self, change: &mut [f64]) {
        self.inner.carried_change(change);
    }
}
