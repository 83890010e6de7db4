//! Flight, impact, rebound.

use super::super::case::{AUDIT, Audited, CASE, Case, ELASTIC, Method, Must};
use super::super::finding::{Finding, Unit};
use super::super::run::Ran;
use super::super::trace::Quantity;
use super::{TIGHTER, bound};

/// A wheelset on its own, straight, that stands so high above its place: 0.457 m less 0.07 mm at rest.
const STRAIGHT: &str = "track.deviation=[]";
/// m, kg, N, of the scene suspended_wheelset.
const RADIUS: f64 = 0.457;
const MASS: f64 = 1568.0;
const LOAD: f64 = 98_000.0;
const GRAVITY: f64 = 9.81;
const IMPACT: Audited = Audited { weight: 0.01, energy: 0.02, way: 0.0, ..AUDIT };

const METHODS: &[Method] = &[
    Method::new("rosenbrock", "tolerance=1e-5"),
    Method::new("rosenbrock", "tolerance=1e-8"),
    Method::new("imex", "tolerance=1e-5"),
    Method::new("dormand_prince", "tolerance=1e-5"),
    Method::new("dormand_prince", "tolerance=1e-8"),
    Method::new("rk43", "tolerance=1e-6"),
    Method::new("generalised_alpha", "step=0.2 ms"),
    Method::new("real_time", "step=0.2 ms"),
    Method::new("rk4", "step=0.05 ms"),
    Method::new("zhai", "step=0.02 ms"),
];

/// N is compared before impacts that a small error of time shifts: along the first one.
const FIRST: &[super::Bound] = &[bound(Quantity::Z, 1e-5), bound(Quantity::VerticalSpeed, 0.01)];

pub(super) const CASES: &[Case] = &[
    Case {
        name: "drop_without_damping",
        hard: "a wheelset falls 10 mm and bounces six times: in flight the error is 0 and a step can pass the whole impact",
        claim: "|vz| at most sqrt(2 (g + W/m) h) = 1.20 m/s and still 99 % of it at the last impact (energy); N within 1 % of the Hertzian 1.96 MN",
        scene: "suspended_wheelset",
        changes: &[STRAIGHT, "vehicle.initial.from_equilibrium=false", "vehicle.initial.z=0.467", "contact.damping={law=\"none\"}"],
        stop: 0.24,
        grid: 2e-5,
        formulations: &["ECF-A"],
        methods: METHODS,
        must: &[Must::Formula(keeps_its_speed)],
        audit: IMPACT,
        ..CASE
    },
    Case {
        name: "drop_with_restitution",
        hard: "the same with Hunt and Crossley's damping for a restitution of 0.5 at 1 m/s: the force at first touch must not pull, 42 MN were seen",
        claim: "rebound over impact as dormand_prince 1e-11 says: vz to 0.01 m/s, z to 0.01 mm at every 0.02 ms",
        scene: "suspended_wheelset",
        changes: &[
            STRAIGHT,
            "vehicle.initial.from_equilibrium=false",
            "vehicle.initial.z=0.467",
            "contact.damping={law=\"hunt_crossley\",restitution=0.5,impact_speed=1.0}",
        ],
        stop: 0.1,
        grid: 2e-5,
        formulations: &["ECF-A"],
        methods: METHODS,
        must: &[Must::Reference { methods: TIGHTER, bounds: FIRST }],
        audit: IMPACT,
        ..CASE
    },
    Case {
        name: "flight_of_50_mm",
        hard: "a wheelset comes down from 50 mm onto S1002 and 60E1, lands hard and settles",
        claim: "|vz| at first touch sqrt(2 (g + W/m) h) to 0.5 %; at rest after 1 s: Q its static load to 2 %",
        scene: "wheelset_s1002",
        changes: &[STRAIGHT, "vehicle.initial.from_equilibrium=false", "vehicle.initial.z=0.51"],
        stop: 1.0,
        grid: 1e-4,
        formulations: ELASTIC,
        methods: &[
            Method::new("rosenbrock", "tolerance=1e-5"),
            Method::new("imex", "tolerance=1e-5"),
            Method::new("dormand_prince", "tolerance=1e-6"),
            Method::new("generalised_alpha", "step=0.5 ms"),
            Method::new("real_time", "step=0.5 ms"),
        ],
        must: &[Must::Formula(lands_and_settles)],
        audit: IMPACT,
        ..CASE
    },
];

/// Elastic impacts keep the energy: no speed above that of the first, and the same at the last.
fn keeps_its_speed(ran: &Ran) -> Vec<Finding> {
    let (z, vz) = (ran.trace.first(Quantity::Z), ran.trace.first(Quantity::VerticalSpeed));
    let height = z.first().copied().unwrap_or(0.0) - RADIUS;
    let speed = (2.0 * (GRAVITY + LOAD / MASS) * height).sqrt();
    let last = vz.iter().rev().take(vz.len() / 4).fold(0.0, |most: f64, v| most.max(v.abs()));
    // Hertz: a body that falls with v onto two wheels' contacts of K has m v^2/2 + (m g + W) d = 2 (2/5) K d^2.5. N = K d^1.5.
    let most = ran.trace.largest(Quantity::Normal);
    vec![
        Finding::new("largest |vz| over the first, less 1", ran.trace.largest(Quantity::VerticalSpeed) / speed - 1.0, 0.01, Unit::Share),
        Finding::new("loss of |vz| at the last impact", 1.0 - last / speed, 0.01, Unit::Share),
        Finding::relative("largest N against 1.96 MN", most, 1.96e6, 0.01),
    ]
}

fn lands_and_settles(ran: &Ran) -> Vec<Finding> {
    let (z, vz, n) = (ran.trace.first(Quantity::Z), ran.trace.first(Quantity::VerticalSpeed), ran.trace.first(Quantity::Normal));
    let touch = n.iter().position(|n| *n > 0.0).unwrap_or(1).max(1) - 1;
    let fall = |z: f64| 2.0 * (GRAVITY + 91_300.0 / 1813.0) * (0.51 - z);
    let expected = z.get(touch).map_or(f64::NAN, |z| fall(*z).sqrt());
    let rest = ran.trace.of(Quantity::Vertical).filter_map(<[f64]>::last).map(|q| (q / ran.load - 1.0).abs()).fold(0.0, f64::max);
    vec![
        Finding::relative("|vz| at first touch against free fall", vz.get(touch).map_or(f64::NAN, |v| v.abs()), expected, 0.005),
        Finding::new("Q at rest against the static load", rest, 0.02, Unit::Share),
    ]
}
