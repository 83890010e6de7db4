//! Creep forces whose own mode is faster than the steps and hides below the tolerance.

use super::super::case::{CASE, Case, ELASTIC, Method, Must, SMOOTH};
use super::super::finding::{Finding, Unit};
use super::super::run::Ran;
use super::super::trace::Quantity;
use super::{bound, near};
use crate::geometry::Side;

/// On straight smooth track a wheel is drawn by what its bearings and spin take: nothing. Largest sizes that count as nothing, N.
const NOTHING: f64 = 120.0;

pub(super) const CASES: &[Case] = &[
    Case {
        name: "creep_rattle_coach",
        hard: "coach, straight and smooth: each wheelset's spin about its axle is held by creep alone, with 1 200/s at 20 m/s",
        claim: "force along the track of every wheel within 120 N (0.2 % of a wheel load) of 0 at every 0.5 ms (steady rolling; it was 19 kN)",
        scene: "vehicle_manchester_1",
        changes: &["track.deviation=[]"],
        stop: 1.0,
        grid: 5e-4,
        formulations: &["ECF-A", "ECCF"],
        methods: &[
            Method::new("dormand_prince", "tolerance=1e-5"),
            Method::new("dormand_prince", "tolerance=1e-6"),
            Method::new("rk43", "tolerance=1e-5"),
            Method::new("imex", "tolerance=1e-4"),
            Method::new("rosenbrock", "tolerance=1e-4"),
        ],
        must: &[Must::Formula(rolls_freely)],
        ..CASE
    },
    Case {
        name: "creep_rattle_free_travel",
        hard: "the same with free travel, where creep forces and speed act on each other",
        claim: "force along the track of every wheel within 120 N (0.2 % of a wheel load) of 0 at every 0.5 ms (it was 14 kN)",
        scene: "bogie",
        changes: &["track.deviation=[]", "vehicle.travel=free"],
        stop: 1.0,
        grid: 5e-4,
        formulations: SMOOTH,
        methods: &[
            Method::new("rosenbrock", "tolerance=1e-4"),
            Method::new("rosenbrock", "tolerance=1e-5"),
            Method::new("imex", "tolerance=1e-4"),
        ],
        must: &[Must::Formula(rolls_freely)],
        ..CASE
    },
    Case {
        name: "slow_wheelset",
        hard: "a wheelset at 5 m/s over 10 mm of gauge reduction: the creep mode has 5 000/s",
        claim: "y to 0.01 mm, Q and force along the track to 2 % of the static load at every 1 ms, against dormand_prince 1e-9",
        scene: "suspended_wheelset",
        changes: &["vehicle.speed=5", "vehicle.initial.distance=15"],
        stop: 3.0,
        grid: 1e-3,
        methods: &[
            Method::new("dormand_prince", "tolerance=1e-6"),
            Method::new("rk43", "tolerance=1e-6"),
            Method::new("rosenbrock", "tolerance=1e-5"),
            Method::new("imex", "tolerance=1e-5"),
        ],
        must: &[near(&[bound(Quantity::Y, 1e-5), bound(Quantity::Vertical, 0.02), bound(Quantity::Longitudinal, 0.02)])],
        ..CASE
    },
    Case {
        name: "slow_wheelset_long_steps",
        hard: "explicit fixed steps beyond the stability of the creep mode at 5 m/s: 9 to 56 kN of braking from nothing, without a word",
        claim: "force along the track of every wheel within 120 N of 0 on straight smooth track, or a refusal that names solver.step",
        scene: "suspended_wheelset",
        changes: &["vehicle.speed=5", "track.deviation=[]", "vehicle.initial.y=0.5 mm"],
        stop: 1.0,
        grid: 1e-3,
        formulations: ELASTIC,
        methods: &[Method::new("zhai", "step=0.5 ms"), Method::new("rk4", "step=0.7 ms"), Method::new("rk4", "step=0.1 ms")],
        must: &[Must::Formula(axles_are_not_braked)],
        ..CASE
    },
];

fn rolls_freely(ran: &Ran) -> Vec<Finding> {
    vec![Finding::new("force along the track", ran.trace.largest(Quantity::Longitudinal), NOTHING, Unit::Newton)]
}

/// A wheelset that swings yaws: its wheels pull in opposite directions, and only the sum is nothing.
fn axles_are_not_braked(ran: &Ran) -> Vec<Finding> {
    let [left, right] = Side::BOTH.map(|side| ran.trace.one(Quantity::Longitudinal, 0, Some(side)));
    let sum = left.iter().zip(right).map(|(left, right)| (left + right).abs()).fold(0.0, f64::max);
    vec![Finding::new("force of the axle along the track", sum, NOTHING, Unit::Newton)]
}
