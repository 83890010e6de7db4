//! Against a formula, or against differences of what is differentiated.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/counting.rs"]
mod counting;

mod carried;
mod contact_geometry;
mod directional;
mod example_scenes;
mod forces;
mod input_table;
mod joints;
mod limit_cycles;
mod modes;
mod moving_frame;
mod out_of_round;
mod outputs;
mod rail_beam;
mod rail_motion;
mod sliding_means;
mod speed;
mod speed_input;
mod swings;
mod tangent;
mod traction;
mod travelling_track;
mod twist;
mod twisting_wheelsets;
mod vertical_load;
mod wheelset;
