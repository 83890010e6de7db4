//! Ctrl-C (SIGINT) and SIGTERM ask a run to end in order; the second one ends the program at once.

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Which signal came, if any.
pub(super) struct Interrupt(Arc<AtomicUsize>);

impl Interrupt {
    /// Watches from now on. Where a signal can't be watched it ends the program as it does without us.
    pub fn watch() -> Interrupt {
        let (came, which) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicUsize::new(0)));
        for signal in [SIGINT, SIGTERM] {
            // In this order: the first signal finds nothing to end.
            let _ = flag::register_conditional_shutdown(signal, exit_code(signal).into(), came.clone())
                .and_then(|_| flag::register(signal, came.clone()))
                .and_then(|_| flag::register_usize(signal, which.clone(), signal as usize));
        }
        Interrupt(which)
    }

    /// Exit code of the signal that came: 130 for Ctrl-C, 143 for SIGTERM, as shells count.
    pub fn code(&self) -> Option<u8> {
        match self.0.load(Ordering::Relaxed) {
            0 => None,
            signal => Some(exit_code(signal as i32)),
        }
    }
}

fn exit_code(signal: i32) -> u8 {
    128 + signal as u8
}
