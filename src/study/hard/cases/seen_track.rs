//! Track that begins, ends or is short where a step is long.

use super::super::case::{ALL, CASE, Case, Method, SMOOTH};
use super::super::trace::Quantity;
use super::{ADAPTIVE, EVERY, bound, near, near_strikes, strike};
use std::fmt::Write as _;

const STRAIGHT: &str = "track.deviation=[]";

/// Violent track: flanges run against rails, wheels lift.
const ROUGH: &[super::Bound] =
    &[bound(Quantity::Y, 5e-5), bound(Quantity::Vertical, 0.05), bound(Quantity::Lateral, 0.05), bound(Quantity::Normal, 0.05)];
/// Half a second of strikes before makes the last ones come sooner or later by as much as this, s.
const LATE: f64 = 8e-4;
const STRUCK: &[super::Bound] = &[
    bound(Quantity::Y, 5e-5),
    super::Bound { shift: LATE, ..strike(Quantity::Vertical, 0.05) },
    super::Bound { shift: LATE, ..strike(Quantity::Lateral, 0.05) },
    super::Bound { shift: LATE, ..strike(Quantity::Normal, 0.05) },
];
/// What fast settings must hold.
const MILD: &[super::Bound] = &[
    bound(Quantity::Y, 1e-5),
    bound(Quantity::Vertical, 0.01),
    bound(Quantity::Lateral, 0.02),
    bound(Quantity::VerticalAcceleration, 0.5),
];

/// A dip of 15 mm over 3 m at 50 m in a series of points every 0.25 m.
fn dip() -> Vec<(&'static str, String)> {
    let mut text = String::from("distance [m],longitudinal_level [mm]\n");
    for point in 0..=400 {
        let s = 0.25 * f64::from(point);
        let inside = (50.0..53.0).contains(&s);
        let level = if inside { -7.5 * (1.0 - (std::f64::consts::TAU * (s - 50.0) / 3.0).cos()) } else { 0.0 };
        let _ = writeln!(text, "{s},{level:.6}");
    }
    vec![("dip.csv", text)]
}

pub(super) const CASES: &[Case] = &[
    Case {
        name: "stretch_after_smooth",
        hard: "15 m of FRA 4 from 60 m behind smooth track: in the steady state before it the error is 0 and steps grow to seconds",
        claim: "y to 0.05 mm, Q, Y and N to 5 % of the static load at every 0.2 ms, within 0.8 ms (flanges strike for 2 ms), against dormand_prince 1e-10",
        scene: "bogie",
        changes: &[
            STRAIGHT,
            "track.irregularity=[{kind=\"spectrum\",spectrum=\"fra4\",seed=1,from=60,to=75,fade=3}]",
            "vehicle.initial.distance=40",
        ],
        stop: 2.2,
        methods: ADAPTIVE,
        must: &[near_strikes(STRUCK)],
        ..CASE
    },
    Case {
        name: "dip_in_a_series",
        hard: "a dip of 15 mm over 3 m in a measured series whose other values are zero",
        claim: "y to 0.05 mm, Q, Y and N to 5 % of the static load at every 0.2 ms, against dormand_prince 1e-9",
        scene: "bogie",
        changes: &[STRAIGHT, "track.irregularity=[{kind=\"series\",file=\"dip.csv\"}]", "vehicle.initial.distance=36"],
        files: Some(dip),
        stop: 1.2,
        methods: EVERY,
        must: &[near(ROUGH)],
        ..CASE
    },
    Case {
        name: "ramps_down_and_up",
        hard: "two ramps of 0.5 m, 5 mm down and up again, on smooth track: a ramp has no break that a step could end at",
        claim: "y to 0.05 mm, Q, Y and N to 5 % of the static load at every 0.2 ms, against dormand_prince 1e-9",
        scene: "bogie",
        changes: &[
            "track.deviation=[{rail=\"both\",direction=\"vertical\",shape=\"ramp\",amplitude=\"-5 mm\",from=20,to=20.5},\
             {rail=\"both\",direction=\"vertical\",shape=\"ramp\",amplitude=\"5 mm\",from=23,to=23.5}]",
            "vehicle.initial.distance=10",
        ],
        stop: 1.0,
        methods: EVERY,
        must: &[near(ROUGH)],
        ..CASE
    },
    Case {
        name: "fade_of_mild_track",
        hard: "a coach at 160 km/h enters ORE B176 low through its fade: the first metres are small, one Q was wrong by 30 %",
        claim: "y to 0.01 mm, Q to 1 %, Y to 2 % of the static load, az to 0.5 m/s2 at every 0.5 ms, against dormand_prince 1e-9",
        scene: "vehicle_manchester_1",
        changes: &[
            STRAIGHT,
            "vehicle.speed=160 km/h",
            "track.irregularity=[{kind=\"spectrum\",spectrum=\"ore_b176_low\",seed=1,from=30,to=2000}]",
        ],
        stop: 1.0,
        grid: 5e-4,
        formulations: &["ECF-A", "ECCF"],
        methods: &[
            Method::new("rosenbrock", "tolerance=1e-5"),
            Method::new("rosenbrock", "tolerance=3e-6"),
            Method::new("imex", "tolerance=1e-5"),
            Method::new("dormand_prince", "tolerance=1e-6"),
        ],
        must: &[near(MILD)],
        quick: false,
        ..CASE
    },
    Case {
        name: "one_wave_after_200_m",
        hard: "one wave of 2 m, 2 mm high, after 200 m of nothing",
        claim: "y to 0.05 mm, Q, Y and N to 5 % of the static load at every 1 ms, against dormand_prince 1e-9",
        scene: "wheelset_s1002",
        changes: &["track.deviation=[{rail=\"left\",direction=\"vertical\",shape=\"ramp\",amplitude=\"-2 mm\",from=200,to=201},\
             {rail=\"left\",direction=\"vertical\",shape=\"ramp\",amplitude=\"2 mm\",from=201,to=202}]"],
        stop: 10.5,
        grid: 1e-3,
        formulations: SMOOTH,
        methods: ADAPTIVE,
        must: &[near(ROUGH)],
        quick: false,
        ..CASE
    },
    Case {
        name: "start_on_irregular_track",
        hard: "a start at 50 m/s in the middle of FRA 6 at half scale: both wheels of the first axle were in the air at t = 0",
        claim: "every N above 0 at the start, none above 3 static loads before 0.3 s",
        scene: "bogie",
        changes: &[
            STRAIGHT,
            "vehicle.speed=50",
            "track.irregularity=[{kind=\"spectrum\",spectrum=\"fra6\",seed=1,from=-50,to=400,scale=0.5}]",
        ],
        stop: 0.3,
        formulations: ALL,
        methods: &[Method::new("rosenbrock", "tolerance=1e-5"), Method::new("dormand_prince", "tolerance=1e-6")],
        must: &[super::Must::Formula(stands_at_the_start)],
        ..CASE
    },
];

/// Wheels stand on their rails at t = 0, and stay on them like those of a vehicle that came along.
fn stands_at_the_start(ran: &super::super::run::Ran) -> Vec<super::super::finding::Finding> {
    use super::super::finding::{Finding, Unit};
    let least = ran.trace.of(Quantity::Normal).filter_map(<[f64]>::first).fold(f64::INFINITY, |least, n| least.min(*n));
    vec![
        Finding::new("share of N that a wheel lacks at the start", (1.0 - least / ran.load).max(0.0), 0.9, Unit::Share),
        Finding::new("largest N over the static load", ran.trace.largest(Quantity::Normal) / ran.load, 3.0, Unit::One),
    ]
}
