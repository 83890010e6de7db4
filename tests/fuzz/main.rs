//! Mutated inputs: scenes, files of profiles and measured tracks, saved states, FMI calls in any order.
//!
//! What must hold for whatever comes in: an answer or a typed error, never a panic, within seconds and bounded memory, and no
//! number that is none in what is answered. `WHEELRAIL_FUZZ_CASES` says how many cases each target tries (few by default),
//! `WHEELRAIL_FUZZ_SECONDS` for how long instead, `WHEELRAIL_FUZZ_SEED` with which it begins. A case is its seed: what failed is named
//! with it, written to `target/tmp/fuzz/`, and run again by `WHEELRAIL_FUZZ_SEED=n WHEELRAIL_FUZZ_CASES=1`. Cases that once failed
//! stand in `found.rs`.

mod calls;
mod calls3;
mod files;
mod found;
mod mutate;
mod run;
mod scenes;
mod states;
