//! CPU time of the present thread, and what is left of the time for a study.

use cpu_time::ThreadTime;
use std::time::{Duration, Instant};

/// Calls `work`; returns what it gave and the CPU time of this thread, s. A system without a clock of CPU time gives the time that
/// passed.
pub fn cpu_time<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let (clock, wall) = (ThreadTime::try_now(), Instant::now());
    let done = work();
    let time = clock.and_then(|clock| clock.try_elapsed()).unwrap_or_else(|_| wall.elapsed());
    (done, time.as_secs_f64())
}

/// Does the user want what is ready?
pub type Interrupted<'a> = &'a (dyn Fn() -> bool + Sync);

/// Time that a study may take.
#[derive(Clone, Copy)]
pub(super) struct Budget<'a> {
    start: Instant,
    /// s.
    pub seconds: f64,
    pub interrupted: Interrupted<'a>,
}

impl<'a> Budget<'a> {
    /// From now on.
    pub(super) fn new(seconds: f64, interrupted: Interrupted<'a>) -> Budget<'a> {
        Budget { start: Instant::now(), seconds, interrupted }
    }

    /// s.
    pub(super) fn spent(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// What is left of a share of the whole, s; nothing once it is interrupted.
    pub(super) fn left_of(&self, share: f64) -> f64 {
        if (self.interrupted)() { f64::NEG_INFINITY } else { share * self.seconds - self.spent() }
    }
}

/// The instant in so many seconds; `None` when that is beyond all clocks.
pub(super) fn in_seconds(seconds: f64) -> Option<Instant> {
    let duration = Duration::try_from_secs_f64(seconds.max(0.0)).ok()?;
    Instant::now().checked_add(duration)
}
