//! Wheel loads between the ends of long steps.

use super::super::case::{ALL, CASE, Case, Method, Must};
use super::super::finding::{Finding, Unit};
use super::super::run::Ran;
use super::super::trace::Quantity;
use super::{bound, near};

const METHODS: &[Method] = &[
    Method::new("rosenbrock", "tolerance=1e-4"),
    Method::new("rosenbrock", "tolerance=3e-5"),
    Method::new("rosenbrock", "tolerance=1e-5"),
    Method::new("rosenbrock", "tolerance=1e-6"),
    Method::new("imex", "tolerance=1e-5"),
    Method::new("generalised_alpha", "step=1 ms"),
    Method::new("real_time", "step=1 ms"),
];
/// The generalised-alpha method is of order 2 and has no moving frame: with 1 ms it takes ay off by 0.014 m/s2 here, with 0.5 ms by 0.0033.
const STEADY: &[Method] = &[
    Method::new("rosenbrock", "tolerance=1e-4"),
    Method::new("rosenbrock", "tolerance=3e-5"),
    Method::new("rosenbrock", "tolerance=1e-5"),
    Method::new("rosenbrock", "tolerance=1e-6"),
    Method::new("imex", "tolerance=1e-5"),
    Method::new("generalised_alpha", "step=0.5 ms"),
    Method::new("real_time", "step=1 ms"),
];

pub(super) const CASES: &[Case] = &[
    Case {
        name: "loads_between_steps",
        hard: "coach on ORE B176 low with long implicit steps: Q was right at their ends and off by 17 kN between them",
        claim: "Q to 1 %, Y to 2 % of the static load at every 0.5 ms, y to 0.05 mm, against dormand_prince 1e-9",
        scene: "vehicle_manchester_1",
        changes: &["track.deviation=[]", "track.irregularity=[{kind=\"spectrum\",spectrum=\"ore_b176_low\",seed=1,from=15,to=400,fade=5}]"],
        stop: 1.5,
        grid: 5e-4,
        formulations: &["ECF-A", "ECCF"],
        methods: METHODS,
        must: &[near(&[bound(Quantity::Y, 5e-5), bound(Quantity::Vertical, 0.01), bound(Quantity::Lateral, 0.02)])],
        quick: false,
        ..CASE
    },
    Case {
        name: "steady_curve",
        hard: "R 600 m at 25 m/s in the steady state: the state moves with the turning frame, every step is long",
        claim: "Q constant to 0.5 % of the static load, yaw acceleration 0 to 0.02 rad/s2, ay constant to 0.01 m/s2, at every 1 ms (rigid contacts: after their landing, from 0.5 s on)",
        scene: "bogie",
        changes: &["track.deviation=[]", "track.node=[{distance=0,radius=600,superelevation=\"-100 mm\"}]", "vehicle.speed=25"],
        stop: 2.0,
        grid: 1e-3,
        formulations: ALL,
        methods: STEADY,
        must: &[Must::Formula(steady)],
        ..CASE
    },
];

/// Largest less smallest.
fn spread(column: &[f64]) -> f64 {
    let (least, most) =
        column.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| (least.min(*value), most.max(*value)));
    most - least
}

/// Wheels of rigid contacts start elastic in a curve and land, each with a jolt that is gone by then, s.
const LANDED: f64 = 0.5;

/// The part of a column that is judged.
fn steady_part<'a>(ran: &Ran, column: &'a [f64]) -> &'a [f64] {
    let first = if ran.rigid { ran.trace.time.partition_point(|time| *time < LANDED) } else { 0 };
    &column[first.min(column.len())..]
}

fn widest(ran: &Ran, quantity: Quantity) -> f64 {
    ran.trace.of(quantity).map(|column| spread(steady_part(ran, column))).fold(0.0, f64::max)
}

/// Nothing changes in a steady state.
fn steady(ran: &Ran) -> Vec<Finding> {
    let part = |column| steady_part(ran, column).iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let turned = ran.trace.of(Quantity::YawAcceleration).map(part).fold(0.0, f64::max);
    vec![
        Finding::new("change of Q", widest(ran, Quantity::Vertical) / ran.load, 0.005, Unit::Share),
        Finding::new("yaw acceleration", turned, 0.02, Unit::RadianPerSecond2),
        Finding::new("change of ay", widest(ran, Quantity::LateralAcceleration), 0.01, Unit::MetrePerSecond2),
    ]
}
