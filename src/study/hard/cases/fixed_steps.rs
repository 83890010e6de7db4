//! Fixed steps within what docs/scene.md calls safe.

use super::super::case::{AUDIT, Audited, CASE, Case, Method, Must, SMOOTH};
use super::super::finding::{Finding, Unit};
use super::super::run::Ran;
use super::super::trace::Quantity;
use super::{Bound, bound, near_strikes};

const FIXED: &[Method] = &[
    Method::new("generalised_alpha", "step=2 ms"),
    Method::new("real_time", "step=2 ms"),
    Method::new("generalised_alpha", "step=1 ms"),
    Method::new("real_time", "step=1 ms"),
    Method::new("rosenbrock", "tolerance=1e-5"),
];

const COARSE: &[Bound] = &[bound(Quantity::Y, 5e-4), bound(Quantity::Vertical, 0.15)];

const INTO_R_300_M: &[&str] = &[
    "track.deviation=[]",
    "vehicle.speed=16",
    "track.node=[{distance=0},{distance=5},{distance=17,radius=300,superelevation=\"-60 mm\"},{distance=400,radius=300,superelevation=\"-60 mm\"}]",
];

pub(super) const CASES: &[Case] = &[
    Case {
        name: "lateral_step_6_mm",
        hard: "a bogie over a lateral step of 6 mm within 2 m: the flange strikes within one or two steps of 2 ms",
        claim: "it does not derail; y to 0.5 mm, Q to 15 % of the static load, against dormand_prince 1e-9, or a refusal that names solver.step",
        scene: "bogie",
        changes: &["track.deviation=[{rail=\"both\",direction=\"lateral\",shape=\"ramp\",amplitude=\"6 mm\",from=5,to=7}]"],
        stop: 1.2,
        methods: FIXED,
        must: &[near_strikes(COARSE)],
        ..CASE
    },
    Case {
        name: "into_R_300_m",
        hard: "a bogie at 16 m/s through a spiral of 12 m into R 300 m: flange contact begins in the spiral",
        claim: "it does not derail; y to 0.5 mm, Q to 15 % of the static load, against dormand_prince 1e-9, or a refusal that names solver.step",
        scene: "bogie",
        changes: INTO_R_300_M,
        stop: 1.1,
        methods: FIXED,
        must: &[near_strikes(COARSE)],
        ..CASE
    },
    Case {
        name: "flutter_in_R_300_m",
        hard: "the same until the outer wheel, which rests on tread and flange, begins to flutter at 110 Hz out of nothing: rounding decides about the instant",
        claim: "it does not derail; y to 0.5 mm, Q to 15 % of the static load within half a period of the flutter, against dormand_prince 1e-9, or a refusal that names solver.step",
        scene: "bogie",
        changes: INTO_R_300_M,
        stop: 1.5,
        methods: FIXED,
        must: &[near_strikes(&[bound(Quantity::Y, 5e-4), Bound { quantity: Quantity::Vertical, most: 0.15, shift: 4.5e-3 }])],
        ..CASE
    },
    Case {
        name: "limit_cycle_2_ms",
        hard: "a wheelset far above its critical speed swings from flange to flange; steps of 2 ms derail it",
        claim: "it stays on the track for 5 s, with the amplitude of y of dormand_prince 1e-8 (6.41 mm) to 3 %, or a refusal that names solver.step",
        scene: "wheelset_s1002",
        changes: &["track.deviation=[]", "vehicle.speed=60", "vehicle.initial.y=3 mm"],
        stop: 5.0,
        grid: 2e-4,
        methods: FIXED,
        must: &[Must::Formula(swings_between_flanges)],
        audit: Audited { energy: 0.05, ..AUDIT },
        quick: false,
        ..CASE
    },
    Case {
        name: "hump",
        hard: "a wheelset at 40 m/s over a hump of 20 mm in 2 m takes off; one ended \"ok\" 7.6 m above the track",
        claim: "z stays below 0.6 m (the hump's slope gives it at most 0.8 m/s); at rest at the end: Q its static load to 5 %",
        scene: "wheelset_s1002",
        changes: &[
            "track.deviation=[{rail=\"both\",direction=\"vertical\",shape=\"haversine\",amplitude=\"20 mm\",from=10,to=12}]",
            "vehicle.speed=40",
        ],
        stop: 1.2,
        grid: 1e-4,
        formulations: SMOOTH,
        methods: FIXED,
        must: &[Must::Formula(comes_down)],
        audit: Audited { weight: 0.01, energy: 0.03, ..AUDIT },
        ..CASE
    },
];

fn swings_between_flanges(ran: &Ran) -> Vec<Finding> {
    let y = ran.trace.first(Quantity::Y);
    let late = &y[y.len() * 3 / 5..];
    let amplitude = 0.5 * (late.iter().copied().fold(f64::MIN, f64::max) - late.iter().copied().fold(f64::MAX, f64::min));
    vec![Finding::relative("amplitude of y against 6.41 mm", amplitude, 6.41e-3, 0.03)]
}

fn comes_down(ran: &Ran) -> Vec<Finding> {
    let rest = ran.trace.of(Quantity::Vertical).filter_map(<[f64]>::last).map(|q| (q / ran.load - 1.0).abs()).fold(0.0, f64::max);
    vec![
        Finding::new("largest z", ran.trace.largest(Quantity::Z), 0.6, Unit::Metre),
        Finding::new("Q at rest against the static load", rest, 0.05, Unit::Share),
    ]
}
