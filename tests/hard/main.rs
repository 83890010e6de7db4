//! Hard cases, each with the number that must hold.

#[path = "../common/mod.rs"]
mod common;

mod cases;
mod continuity;
mod flange;
mod flutter;
mod friction;
mod merging;
mod nodes;
mod patches;
mod pockets;
mod points;
mod robustness;
mod standstill;
mod start_on_track;
mod strikes;
mod vehicles;
mod wheelset;
