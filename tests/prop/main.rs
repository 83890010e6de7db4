//! What must hold whatever the scene.

#[path = "../common/mod.rs"]
mod common;

mod assess;
mod bearings;
mod brake_ramp;
mod checkpoints;
mod cli;
mod cli_output;
mod creep_laws;
mod dependencies;
mod detail;
mod effects;
mod energy;
mod half;
mod inputs;
mod irregularities;
mod licenses;
mod modes;
mod scene_keys;
mod slack;
mod static_preload;
mod steady_curving;
mod study;
mod sweep;
mod taking_up;
mod tuning;
mod vehicle;
