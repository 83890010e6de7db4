//! How far a wheel must be lowered to carry its load.

use super::{Pressed, Settings};
use crate::contact::Material;
use crate::contact::search::algebraic::Pair;
use nalgebra::Vector3;

const DEEPEST: f64 = 5e-3;
/// Where nothing is known, m.
const FIRST: f64 = 5e-5;
/// Error of the load, in parts of it to the power 2/3.
const CARRIED: f64 = 1e-7;

/// By how much, m, the wheel must be lowered from the pose of `pair` until its normal pressures carry a vertical load [N], and the patch there.
///
/// `near`: a depth that may be about right. `None` where no depth within 5 mm carries the load. The grid is made finer than the settings say where the
/// wheel presses at several places that are small beside the way between them.
pub fn depth_under_load(pair: &Pair, load: f64, material: Material, settings: Settings, near: Option<f64>) -> Option<(f64, Pressed)> {
    let (depth, pressed) = search(pair, load, material, settings, near)?;
    let finer = pressed.resolving(settings);
    if finer == settings { Some((depth, pressed)) } else { search(pair, load, material, finer, Some(depth)) }
}

/// The same on the grid that the settings name.
fn search(pair: &Pair, load: f64, material: Material, settings: Settings, near: Option<f64>) -> Option<(f64, Pressed)> {
    let press = |depth: f64, settings| {
        let centre = pair.centre - Vector3::z() * depth;
        Pressed::new(&Pair { centre: &centre, ..*pair }, material, settings)
    };
    let missing = |depth: f64| {
        let carried = press(depth, Settings { extrapolate: false, ..settings })?.at_rest().pressing.z;
        // Loads grow about as depth^1.5.
        Some((carried.max(0.0) / load).powf(2.0 / 3.0) - 1.0)
    };
    let found = |depth: f64| Some((depth, press(depth, settings)?));
    let first = near.unwrap_or(FIRST);
    let (mut low, mut high) = ((0.0, -1.0), (first, missing(first)?));
    while high.1 < 0.0 {
        if high.0 > DEEPEST {
            return None;
        }
        low = high;
        let next = if near.is_some() { 1.1 } else { 2.0 } * high.0;
        high = (next, missing(next)?);
    }
    // False position with halved weights (Illinois): the ends enclose the depth.
    for _ in 0..60 {
        let depth = low.0 - low.1 * (high.0 - low.0) / (high.1 - low.1);
        let off = missing(depth)?;
        if off.abs() < CARRIED || !(depth > low.0 && depth < high.0) {
            return found(depth);
        }
        if off < 0.0 {
            (low, high.1) = ((depth, off), 0.5 * high.1);
        } else {
            (high, low.1) = ((depth, off), 0.5 * low.1);
        }
    }
    found(0.5 * (low.0 + high.0))
}
