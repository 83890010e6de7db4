//! A progress bar on stderr for long work, only where stderr is a terminal.

use indicatif::{ProgressBar, ProgressStyle};
use std::cell::Cell;

/// Smallest number of simulated seconds that gets a progress bar.
const LONG: f64 = 30.0;

/// A bar of some length with a word behind it.
pub(super) fn bar(length: u64, word: &str) -> ProgressBar {
    let style = ProgressStyle::with_template(&format!("{{wide_bar}} {{percent}} % {word}"));
    ProgressBar::new(length).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Progress through simulated time.
pub(super) struct Progress {
    bar: ProgressBar,
    /// What runs before the present one have simulated, s.
    done: Cell<f64>,
}

impl Progress {
    /// For `total` simulated seconds.
    pub(super) fn new(total: f64) -> Progress {
        let done = Cell::new(0.0);
        if total < LONG {
            return Progress { bar: ProgressBar::hidden(), done };
        }
        Progress { bar: bar((1e3 * total) as u64, "{eta}"), done }
    }

    /// The present run has reached `time` [s].
    pub(super) fn at(&self, time: f64) {
        self.bar.set_position((1e3 * (self.done.get() + time)) as u64);
    }

    /// A run of `time` [s] is over.
    pub(super) fn add(&self, time: f64) {
        self.done.set(self.done.get() + time);
        self.at(0.0);
    }

    /// Takes the bar away.
    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
