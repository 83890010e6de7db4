//! No friction, full slip, locked and spinning wheels, standstill, grades, reversing.

use super::super::case::{AUDIT, Audited, CASE, Case, InputChange, Method, Must, SMOOTH};
use super::super::finding::{Finding, Unit};
use super::super::run::Ran;
use super::super::trace::Quantity;
use super::{bound, near};
use crate::formulation::{DRIVE_TORQUE, LEFT_FRICTION, RIGHT_FRICTION};

const METHODS: &[Method] = &[
    Method::new("rosenbrock", "tolerance=1e-5"),
    Method::new("imex", "tolerance=1e-5"),
    Method::new("dormand_prince", "tolerance=1e-5"),
    Method::new("generalised_alpha", "step=0.5 ms"),
    Method::new("real_time", "step=0.5 ms"),
];

/// Of the scenes wheelset_standstill and wheelset_s1002.
const MASS: f64 = 1813.0;
const LOAD: f64 = 91_300.0;
const AXIAL: f64 = 112.0;
const RADIUS: f64 = 0.46;
const GRAVITY: f64 = 9.81;

const fn change(time: f64, input: usize, value: f64) -> InputChange {
    InputChange { time, input, value }
}

pub(super) const CASES: &[Case] = &[
    Case {
        name: "standstill_without_friction",
        hard: "a wheelset stands on a grade of 30 per thousand and friction is 0: creep's slopes divide by it",
        claim: "it slides with a = g sin(atan 0.03): v to 0.1 % after 1 s, and does not turn",
        scene: "wheelset_standstill",
        changes: &["contact.friction=0", "vehicle.speed=0"],
        formulations: SMOOTH,
        methods: METHODS,
        must: &[Must::Formula(slides)],
        ..CASE
    },
    Case {
        name: "reversing",
        hard: "a wheelset rolls uphill at 1 m/s, stops and rolls back: creepage has no meaning when it stands",
        claim: "v after 8 s within 1 % of v0 - g sin(atan 0.03) t / (1 + I / ((m + M) r^2)), M the load's mass, rolling all the time",
        scene: "wheelset_standstill",
        changes: &["vehicle.speed=1"],
        stop: 8.0,
        grid: 1e-3,
        methods: &[
            Method::new("rosenbrock", "tolerance=1e-5"),
            Method::new("imex", "tolerance=1e-5"),
            Method::new("dormand_prince", "tolerance=1e-7"),
        ],
        must: &[Must::Formula(rolls_back)],
        ..CASE
    },
    Case {
        name: "ten_minutes_on_4_percent",
        hard: "ten minutes up a grade of 4 % with long steps: errors must not add up",
        claim: "force of the drive (m + M) g sin(atan 0.04), M the load's mass, to 1 % (spin in the contacts takes 5 N of 4360 N more) at every 50 ms, y within 0.01 mm of 0",
        scene: "wheelset_s1002",
        changes: &["track.deviation=[]", "track.grade=0.04"],
        stop: 600.0,
        grid: 0.05,
        formulations: &["ECF-A", "ECCF"],
        methods: &[
            Method::new("rosenbrock", "tolerance=1e-5"),
            Method::new("imex", "tolerance=1e-5"),
            Method::new("real_time", "step=5 ms"),
        ],
        must: &[Must::Formula(pulls_its_weight)],
        audit: Audited { energy: 0.05, ..AUDIT },
        quick: false,
        ..CASE
    },
    Case {
        name: "locked_wheel",
        hard: "a wheelset that does not turn is set on its rails at 20 m/s: full slip, then the end of slip",
        claim: "turning at 0.1 s by 2 mu N r t / I to 3 %; rolling at 1 s to 0.2 %",
        scene: "suspended_wheelset",
        changes: &["track.deviation=[]", "vehicle.speed=20", "vehicle.initial.from_equilibrium=false", "vehicle.initial.pitch_rate=0"],
        methods: METHODS,
        must: &[Must::Formula(is_spun_up)],
        ..CASE
    },
    Case {
        name: "spin_at_ten_times",
        hard: "the same turning at ten times the speed of rolling",
        claim: "turning less at 0.1 s by 2 mu N r t / I to 3 %",
        scene: "suspended_wheelset",
        changes: &["track.deviation=[]", "vehicle.speed=20", "vehicle.initial.from_equilibrium=false", "vehicle.initial.pitch_rate=437.6"],
        methods: METHODS,
        must: &[Must::Formula(is_slowed_down)],
        ..CASE
    },
    Case {
        name: "friction_falls_to_0_02",
        hard: "under 5 kN m of traction friction falls from 0.5 to 0.02 within nothing: the wheels spin up",
        claim: "pitch rate, y and force along the track as dormand_prince 1e-9 says: 0.1 rad/s, 0.02 mm, 2 % of the static load",
        scene: "suspended_wheelset",
        changes: &["track.deviation=[]"],
        inputs: &[change(0.1, DRIVE_TORQUE, 5e3), change(0.4, LEFT_FRICTION, 0.04), change(0.4, RIGHT_FRICTION, 0.04)],
        stop: 0.8,
        methods: METHODS,
        must: &[near(&[bound(Quantity::PitchRate, 0.1), bound(Quantity::Y, 2e-5), bound(Quantity::Longitudinal, 0.02)])],
        ..CASE
    },
    Case {
        name: "one_million_newton_metres",
        hard: "a torque of 1e6 N m for 1 ms",
        claim: "pitch rate, y and Q as dormand_prince 1e-9 says: 0.1 rad/s, 0.02 mm, 2 % of the static load",
        scene: "suspended_wheelset",
        changes: &["track.deviation=[]"],
        inputs: &[change(0.1, DRIVE_TORQUE, 1e6), change(0.101, DRIVE_TORQUE, 0.0)],
        stop: 0.3,
        methods: METHODS,
        must: &[near(&[bound(Quantity::PitchRate, 0.1), bound(Quantity::Y, 2e-5), bound(Quantity::Vertical, 0.02)])],
        ..CASE
    },
    Case {
        name: "friction_1_2",
        hard: "friction of 1.2 in flange contact: steep rigid contacts lock",
        claim: "y to 0.05 mm, Q to 10 % of the static load at every 0.2 ms within 0.4 ms, against dormand_prince 1e-10",
        scene: "bogie",
        changes: &[
            "track.deviation=[{rail=\"both\",direction=\"lateral\",shape=\"ramp\",amplitude=\"7 mm\",from=5,to=9}]",
            "contact.friction=1.2",
        ],
        methods: METHODS,
        must: &[super::near_strikes(&[bound(Quantity::Y, 5e-5), super::strike(Quantity::Vertical, 0.1)])],
        ..CASE
    },
];

fn last(ran: &Ran, quantity: Quantity) -> f64 {
    ran.trace.first(quantity).last().copied().unwrap_or(f64::NAN)
}

fn slides(ran: &Ran) -> Vec<Finding> {
    let (v, time) = (last(ran, Quantity::Speed), ran.trace.time.last().copied().unwrap_or(f64::NAN));
    vec![
        Finding::relative("v against -g sin(atan 0.03) t", v, -GRAVITY * 0.03_f64.atan().sin() * time, 1e-3),
        Finding::new("pitch rate", ran.trace.largest(Quantity::PitchRate), 1e-6, Unit::One),
    ]
}

fn rolls_back(ran: &Ran) -> Vec<Finding> {
    let (v, time) = (last(ran, Quantity::Speed), ran.trace.time.last().copied().unwrap_or(f64::NAN));
    let expected = 1.0 - GRAVITY * 0.03_f64.atan().sin() * time / (1.0 + AXIAL / ((MASS + LOAD / GRAVITY) * RADIUS * RADIUS));
    vec![
        Finding::relative("v at the end", v, expected, 0.01),
        Finding::relative("pitch rate at the end against v / r", last(ran, Quantity::PitchRate), v / RADIUS, 0.01),
    ]
}

fn pulls_its_weight(ran: &Ran) -> Vec<Finding> {
    let expected = (MASS * GRAVITY + LOAD) * 0.04_f64.atan().sin();
    let worst = ran.trace.of(Quantity::Driving).flatten().map(|force| (force / expected - 1.0).abs()).fold(0.0, f64::max);
    vec![
        Finding::new("driving force against (m + M) g sin(atan 0.04)", worst, 0.01, Unit::Share),
        Finding::new("y", ran.trace.largest(Quantity::Y), 1e-5, Unit::Metre),
    ]
}

/// 2 mu N r t / I at 0.1 s, with the load of the scene suspended_wheelset, rad/s.
const SPUN: f64 = 2.0 * 0.5 * 56_691.0 * 0.457 * 0.1 / 168.0;

fn pitch_rate_at(ran: &Ran, time: f64) -> f64 {
    let place = ran.trace.time.iter().position(|t| *t >= time - 1e-9).unwrap_or(0);
    ran.trace.first(Quantity::PitchRate).get(place).copied().unwrap_or(f64::NAN)
}

fn is_spun_up(ran: &Ran) -> Vec<Finding> {
    vec![
        Finding::relative("pitch rate at 0.1 s", pitch_rate_at(ran, 0.1), SPUN, 0.03),
        Finding::relative("pitch rate at the end against V / r", last(ran, Quantity::PitchRate), 20.0 / 0.457, 0.002),
    ]
}

fn is_slowed_down(ran: &Ran) -> Vec<Finding> {
    vec![Finding::relative("loss of pitch rate at 0.1 s", 437.6 - pitch_rate_at(ran, 0.1), SPUN, 0.03)]
}
