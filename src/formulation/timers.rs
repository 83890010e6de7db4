//! Clocks of what an integrator asks of a model, off unless somebody asks where the time of a run goes.
//!
//! What costs next to nothing is always counted ([`Work`](super::work::Work), the integrator's statistics). A run that does not ask for clocks
//! looks once per call whether they are on.

use std::time::{Duration, Instant};

/// What an integrator calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call {
    /// Right-hand sides.
    Derivative,
    /// Jacobians.
    Linearise,
    /// Factorisations of I - a J.
    Factorise,
    /// Solutions with them.
    Solve,
    /// Projections onto constraints, changes of contacts.
    Keep,
}

pub const CALLS: usize = 5;

/// Number of calls and their time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    pub count: u64,
    pub time: Duration,
}

/// Clocks of all calls.
#[derive(Clone, Debug, Default)]
pub struct Timers {
    on: bool,
    tallies: [Tally; CALLS],
    /// Did a Jacobian cover force elements, not contacts alone?
    pub forces: bool,
}

impl Timers {
    /// On and at zero.
    pub fn running() -> Timers {
        Timers { on: true, ..Timers::default() }
    }

    /// In the order of [`Call`].
    pub fn tallies(&self) -> [Tally; CALLS] {
        self.tallies
    }

    /// Before a call.
    #[inline]
    pub fn start(&self) -> Option<Instant> {
        self.on.then(Instant::now)
    }

    /// After it.
    #[inline]
    pub fn stop(&mut self, call: Call, clock: Option<Instant>) {
        if let Some(clock) = clock {
            let tally = &mut self.tallies[call as usize];
            (tally.count, tally.time) = (tally.count + 1, tally.time + clock.elapsed());
        }
    }

    /// What a clock itself takes, s: the part that it counts as the call's, and all of it.
    pub fn own_time() -> [f64; 2] {
        const TIMES: u32 = 2000;
        let mut best = [f64::INFINITY; 2];
        for _ in 0..10 {
            let (mut timers, clock) = (Timers::running(), Instant::now());
            for _ in 0..TIMES {
                let clock = std::hint::black_box(&timers).start();
                timers.stop(Call::Keep, clock);
            }
            let seconds = [timers.tallies[Call::Keep as usize].time, clock.elapsed()].map(|time| time.as_secs_f64() / f64::from(TIMES));
            best = [0, 1].map(|i| best[i].min(seconds[i]));
        }
        best
    }
}
