//! Runs cases one by one and watches each: panics, time, memory.

use super::mutate::Random;
use cpu_time::ThreadTime;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::{Mutex, Once};
use std::time::{Duration, Instant};

/// No case may hold more than this at a time, bytes.
const MOST_MEMORY: i64 = 1 << 30;
/// A case that takes longer than this, s, hangs.
const HANGS: u64 = 100;

thread_local! {
    static HELD: Cell<i64> = const { Cell::new(0) };
    static PEAK: Cell<i64> = const { Cell::new(0) };
    static PANIC: RefCell<Option<String>> = const { RefCell::new(None) };
    static WATCHED: Cell<bool> = const { Cell::new(false) };
}

/// Counts what each thread holds; a request beyond 16 GB gets nothing, which ends the process with a message.
struct Measuring;

fn note(change: i64) {
    let _ = HELD.try_with(|held| {
        held.set(held.get() + change);
        let _ = PEAK.try_with(|peak| peak.set(peak.get().max(held.get())));
    });
}

// The only way to watch the allocator; it hands everything on.
unsafe impl GlobalAlloc for Measuring {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if layout.size() > 1 << 34 {
            return std::ptr::null_mut();
        }
        note(layout.size() as i64);
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        note(-(layout.size() as i64));
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Measuring = Measuring;

/// One case: what it is made of, for the report.
#[derive(Default)]
pub struct Case {
    pub text: String,
    started: Option<ThreadTime>,
}

impl Case {
    /// Begins to count processor time.
    pub fn begin(&mut self) {
        self.started = Some(ThreadTime::now());
    }

    /// Processor time since then, which must not be more than `seconds`.
    pub fn within(&self, seconds: f64, what: &str) {
        let taken = self.started.map_or(0.0, |started| started.elapsed().as_secs_f64());
        assert!(taken <= seconds, "SLOW: {what} took {taken:.1} s");
    }
}

/// What is under way on each target, and since when.
static UNDER_WAY: Mutex<BTreeMap<&'static str, (Instant, u64)>> = Mutex::new(BTreeMap::new());

fn folder() -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("fuzz");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Panics of watched threads are kept, also those that somebody catches on the way.
fn watch() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if !WATCHED.with(Cell::get) {
                return before(info);
            }
            let place = info.location().map(|place| format!("{}:{}", place.file(), place.line())).unwrap_or_default();
            let what = info.payload_as_str().unwrap_or("?").to_string();
            PANIC.with(|panic| *panic.borrow_mut() = Some(format!("{place}: {what}")));
        }));
        std::thread::spawn(|| {
            loop {
                std::thread::sleep(Duration::from_secs(1));
                for (target, (since, seed)) in UNDER_WAY.lock().unwrap().iter() {
                    if since.elapsed().as_secs() > HANGS {
                        eprintln!("{target}: case {seed} hangs; see {}", folder().join(format!("{target}-now.txt")).display());
                        std::process::abort();
                    }
                }
            }
        });
    });
}

fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok().and_then(|text| text.parse().ok())
}

/// Runs `case` on many seeds; fails with what was found, each place once.
pub fn each(target: &'static str, default: u64, mut case: impl FnMut(&mut Random, &mut Case)) {
    watch();
    WATCHED.with(|watched| watched.set(true));
    let (first, seconds) = (number("WHEELRAIL_FUZZ_SEED").unwrap_or(0), number("WHEELRAIL_FUZZ_SECONDS"));
    let count = number("WHEELRAIL_FUZZ_CASES").unwrap_or(default);
    let begun = Instant::now();
    let mut found: BTreeMap<String, (u64, u64)> = BTreeMap::new();
    let mut done = 0;
    let mut seed = first;
    while seconds.map_or(done < count, |seconds| begun.elapsed().as_secs() < seconds) {
        let mut random = Random::new(seed);
        let mut now = Case::default();
        UNDER_WAY.lock().unwrap().insert(target, (Instant::now(), seed));
        PANIC.with(|panic| panic.borrow_mut().take());
        let before = HELD.with(Cell::get);
        PEAK.with(|peak| peak.set(before));
        let _ = catch_unwind(AssertUnwindSafe(|| case(&mut random, &mut now)));
        let held = PEAK.with(Cell::get) - before;
        let failure = PANIC.with(|panic| panic.borrow_mut().take());
        let failure = failure.or((held > MOST_MEMORY).then(|| format!("LARGE: held {} MB", held >> 20)));
        if let Some(failure) = failure {
            // Numbers differ from case to case; the words say what it is.
            let kind: String = failure.chars().filter(|c| !c.is_ascii_digit()).take(160).collect();
            let entry = found.entry(kind).or_insert((seed, 0));
            entry.1 += 1;
            if entry.1 == 1 {
                println!("{target}: case {seed}: {failure}");
                std::fs::write(folder().join(format!("{target}-{seed}.txt")), format!("{failure}\n\n{}", now.text)).unwrap();
            }
        }
        done += 1;
        seed += 1;
    }
    UNDER_WAY.lock().unwrap().remove(target);
    WATCHED.with(|watched| watched.set(false));
    println!("{target}: {done} cases from {first} on in {:.0} s, {} faults", begun.elapsed().as_secs_f64(), found.len());
    assert!(found.is_empty(), "{target}: {found:#?}");
}

/// Notes what is under way, for the case of a hang or an abort.
pub fn now(target: &'static str, text: &str) {
    std::fs::write(folder().join(format!("{target}-now.txt")), text).unwrap();
}

#[cfg(test)]
mod tests {
    use super::each;

    /// A panic counts, also one that somebody caught on the way.
    #[test]
    #[should_panic(expected = "caught on the way")]
    fn hard_a_caught_panic_is_a_fault() {
        each("none", 3, |random, _| {
            let _ = std::panic::catch_unwind(|| panic!("caught on the way"));
            random.next();
        });
    }

    #[test]
    #[should_panic(expected = "LARGE")]
    fn hard_too_much_memory_is_a_fault() {
        each("none", 1, |random, _| {
            let held: Vec<u8> = Vec::with_capacity((1 << 31) + random.below(10));
            std::hint::black_box(&held);
        });
    }
}
