//! Time of one call of a law, also where it is shorter than the clock's steps.

use crate::contact::creep::{CreepLaw, RollingContact};
use std::hint::black_box;
use std::time::Instant;

/// A batch lasts at least this long, s, so that reading the clock does not count.
const BATCH: f64 = 20e-6;
const BATCHES: usize = 7;
/// Calls that take longer, s, are measured once.
const SLOW: f64 = 5e-3;

fn seconds(calls: usize, law: &dyn CreepLaw, contact: &RollingContact) -> f64 {
    let clock = Instant::now();
    for _ in 0..calls {
        black_box(law.force(black_box(contact)));
    }
    clock.elapsed().as_secs_f64()
}

/// Median of several batches, s per call.
pub(super) fn per_call(law: &dyn CreepLaw, contact: &RollingContact) -> f64 {
    let mut calls = 1;
    let mut last = seconds(calls, law, contact);
    if last > SLOW {
        return last;
    }
    while last < BATCH {
        calls *= 2;
        last = seconds(calls, law, contact);
    }
    median((0..BATCHES).map(|_| seconds(calls, law, contact) / calls as f64).collect())
}

/// Median of a list that is not empty; 0 of an empty one.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or_default()
}
