//! Floor 8: what is asked of a scene beyond one run of it.
//!
//! [`contact_geometry`] sets the wheelset on its rails at one lateral shift, [`sweep`] does so over a range of shifts, and
//! [`conicity`] makes equivalent conicities of the rolling-radius difference that comes out. [`accuracy`] measures what accuracy
//! costs in time, [`shares`] where the time of a run goes; [`hard`] shows that
//! hard cases stay right; [`patch`] solves the contact of real surfaces under a load, [`pose`] evaluates the scene's own laws in one pose; [`modes`] are small motions about
//! steady running, [`hunting`] large ones that repeat themselves, followed over speed by [`cycles`]; [`effects`] is what each effect contributes and costs; [`assess`] holds results against EN 14363 and comfort standards; [`variation`] runs a scene
//! with many values; [`spectrum`] estimates power spectral densities; [`beside`] compares samples, [`digits`] writes numbers in words.

pub mod accuracy;
pub mod assess;
mod beside;
pub mod conicity;
pub mod contact_geometry;
pub mod cycles;
pub mod digits;
pub mod effects;
pub mod ellipse_patch;
pub mod hard;
pub mod hunting;
pub mod modes;
pub mod patch;
pub mod patch_laws;
pub mod pose;
pub mod shares;
pub mod spectrum;
pub mod strip_patch;
pub mod sweep;
pub mod variation;
