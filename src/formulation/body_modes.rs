//! In which ways the bodies that are no wheelsets swing on their springs, and by how much they do at present.
//!
//! A step's error takes something of a swing, or gives it: with a local error of the part e of its amplitude the third-order method of stiff contacts damps it by 0.65 e of critical
//! damping. So each mode of the bodies (wheelsets held, see [`crate::mbs::carried`]) has its own bound, by its acceleration, which is what is read of a fast swing: a box at 60 Hz
//! with 0.6 m/s2 moves by 4 um beside a car that sways by centimetres.
//!
//! ```text
//! w^2 |e_i| <= r max(A_i, a_0),   e_i = shape . M e / m,   r = 0.03 zeta between 1e-4 and 5e-3,   a_0 = 0.2 m/s2
//! ```
//!
//! A_i: an envelope of the modal acceleration `shape . Q / m` (Q the generalised forces on the bodies: what joints add to them does no work in the mode) about its mean over some
//! periods. With r = 0.03 zeta a resonance comes out 2 % low; undamped swings lose 0.04 % in a period. The shape's largest displacement counts 1, so that A is the acceleration of
//! the body that moves most. Along and across the track, and in yaw, errors are relative to what the wheelsets' own let the bodies follow by: they last longer than a swing. In height and
//! roll the rails take a wheelset's error back at once, so that it does not count.
//!
//! Modes beyond 100 Hz, and those damped by more than half of critical damping, have none: a vehicle of rigid bodies means little there, and nothing swings.

use crate::mbs::body::{COORDINATES, YAW};
use crate::mbs::carried::{Carried, Mode};
use crate::mbs::system::System;
use std::f64::consts::TAU;

/// r per damping ratio, and its bounds.
const PER_DAMPING: f64 = 0.03;
const LEAST: f64 = 1e-4;
const MOST: f64 = 5e-3;
/// Tolerance at which r is that, m and rad; r goes with the root of tighter ones down to this part.
const USUAL: f64 = 1e-5;
const TIGHTEST: f64 = 0.1;
/// Between these rates [1/s] modes are followed, and up to this damping ratio.
const RATES: [f64; 2] = [TAU * 0.3, TAU * 100.0];
const DAMPED: f64 = 0.5;
/// Bodies that are looked at together: the time grows with the cube of their number. Of more, each is looked at with all others held.
const TOGETHER: usize = 24;
/// Coordinates of wheelsets that bodies follow: along and across the track, yaw.
const LEADING: [usize; 3] = [0, 1, YAW];
/// Parts of a mode's largest that are rounding.
const ROUNDING: f64 = 1e-6;

/// One of them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BodyMode {
    /// w, 1/s.
    pub rate: f64,
    /// r, -; infinity of one that is not followed, which keeps its place: what elements' numbers are changed to while a simulation runs takes no state away.
    pub share: f64,
    pub parts: Vec<Part>,
    /// Of displacements of the wheelsets along and across the track, and in yaw: wheelset, and what e gets of each.
    pub led: Vec<(usize, [f64; 3])>,
}

/// What a body has to do with a mode; coordinates along and across the track, up, yaw, roll, pitch.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    pub body: usize,
    /// Modal acceleration by generalised forces, 1/kg and 1/(kg m).
    pub by_force: [f64; COORDINATES],
    /// Modal displacement by coordinates.
    pub by_place: [f64; COORDINATES],
}

/// Of the bodies from `first` on, which hang in the configuration `state` of the system, for runs at a tolerance.
pub(super) fn body_modes(system: &System, first: usize, state: &[f64], tolerance: f64) -> Vec<BodyMode> {
    if system.bodies.len() <= first {
        return Vec::new();
    }
    let tightness = (tolerance / USUAL).sqrt().clamp(TIGHTEST, 1.0);
    let mut carried = Carried::new(system, first, state);
    let groups = carried.groups();
    let alone = |group: Vec<usize>| -> Vec<Vec<usize>> {
        if group.len() > TOGETHER { group.into_iter().map(|body| vec![body]).collect() } else { vec![group] }
    };
    let groups: Vec<Vec<usize>> = groups.into_iter().flat_map(alone).collect();
    let modes: Vec<Mode> = groups.iter().flat_map(|group| carried.modes(group)).collect();
    let swings = carried.swings(&modes);
    let led: Vec<_> = (0..first).map(|wheelset| LEADING.map(|coordinate| carried.led(wheelset, coordinate))).collect();
    let gyration: Vec<f64> = system.bodies[first..]
        .iter()
        .flat_map(|body| {
            let [xx, yy, zz] = body.inertia.moments().map(|moment| (moment / body.mass).sqrt());
            [1.0, 1.0, 1.0, zz, xx, yy]
        })
        .collect();
    let all = modes.iter().zip(swings).map(|(mode, swing)| {
        let followed = swing.filter(|swing| (RATES[0]..RATES[1]).contains(&swing.rate) && swing.damping < DAMPED);
        let largest = mode.shape.iter().zip(&gyration).map(|(part, arm)| (part * arm).abs()).fold(0.0, f64::max);
        let shape = &mode.shape / largest;
        let mass = shape.component_mul(&shape).dot(carried.masses());
        let least = ROUNDING * shape.amax();
        let moves = |body: &usize| shape.rows(COORDINATES * body, COORDINATES).amax() > least;
        let part = |body: usize| {
            let of = |scale: &dyn Fn(usize) -> f64| std::array::from_fn(|i| scale(COORDINATES * body + i));
            Part { body: first + body, by_force: of(&|i| shape[i] / mass), by_place: of(&|i| shape[i] * carried.masses()[i] / mass) }
        };
        BodyMode {
            rate: followed.map_or(0.0, |swing| swing.rate),
            share: followed.map_or(f64::INFINITY, |swing| tightness * (PER_DAMPING * swing.damping).clamp(LEAST, MOST)),
            parts: (0..system.bodies.len() - first).filter(moves).map(part).collect(),
            // Where all move alike no force changes: what wheelsets do is taken off by the forces that it makes.
            led: led
                .iter()
                .map(|of| of.each_ref().map(|forces| -shape.dot(forces) / (mass * mode.value)))
                .enumerate()
                .filter(|(_, parts)| parts.iter().any(|part| part.abs() > ROUNDING))
                .collect(),
        }
    });
    all.collect()
}
