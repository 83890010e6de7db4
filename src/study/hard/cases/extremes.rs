//! Speeds, curves, stiffnesses, masses and distances at the ends of what is possible.

use super::super::case::{AUDIT, Audited, CASE, Case, ELASTIC, Method, Must, SMOOTH};
use super::super::finding::{Finding, Unit};
use super::super::run::Ran;
use super::super::trace::Quantity;
use super::{EVERY, bound, near, near_strikes, strike};
use crate::formulation::VERTICAL_FORCE;
use crate::geometry::Side;

const METHODS: &[Method] = &[
    Method::new("rosenbrock", "tolerance=1e-5"),
    Method::new("imex", "tolerance=1e-5"),
    Method::new("dormand_prince", "tolerance=1e-5"),
    Method::new("generalised_alpha", "step=1 ms"),
    Method::new("real_time", "step=1 ms"),
];
const IMPLICIT: &[Method] = &[
    Method::new("rosenbrock", "tolerance=1e-5"),
    Method::new("rosenbrock", "tolerance=1e-7"),
    Method::new("generalised_alpha", "step=0.5 ms"),
    Method::new("real_time", "step=0.5 ms"),
];
const BOUNDS: &[super::Bound] = &[bound(Quantity::Y, 2e-5), bound(Quantity::Vertical, 0.03)];
const STRIKES: &[super::Bound] = &[bound(Quantity::Y, 1e-4), strike(Quantity::Vertical, 0.1)];
/// One strike, otherwise calm.
const STRUCK: &[super::Bound] = &[bound(Quantity::Y, 2e-5), strike(Quantity::Vertical, 0.03)];
const CLAIM: &str = "y to 0.02 mm, Q to 3 % of the static load at every 0.2 ms, against dormand_prince 1e-9";
const CLAIM_STRIKES: &str = "y to 0.1 mm, Q to 10 % of the static load at every 0.2 ms within 0.4 ms, against dormand_prince 1e-10";
const CLAIM_STRUCK: &str = "y to 0.02 mm, Q to 3 % of the static load at every 0.2 ms within 0.4 ms, against dormand_prince 1e-9";
const STRAIGHT: &str = "track.deviation=[]";
/// Two stiff implicit runs where explicit ones take steps of nanoseconds.
const STIFF: Must = Must::Reference {
    methods: [Method::new("rosenbrock", "tolerance=1e-9"), Method::new("generalised_alpha", "step=0.02 ms")],
    bounds: BOUNDS,
};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "gauge_narrowing",
        hard: "the paper's wheelset at 40 m/s over 10 mm of gauge reduction",
        claim: CLAIM,
        scene: "suspended_wheelset",
        changes: &["vehicle.initial.distance=15"],
        methods: EVERY,
        must: &[near(BOUNDS)],
        ..CASE
    },
    Case {
        name: "lateral_step_15_mm",
        hard: "a bogie over a lateral step of 15 mm within 4 m: flanges strike on both sides",
        claim: CLAIM_STRIKES,
        changes: &[
            "track.deviation=[{rail=\"both\",direction=\"lateral\",shape=\"ramp\",amplitude=\"15 mm\",from=5,to=9}]",
            "vehicle.speed=15",
        ],
        methods: METHODS,
        must: &[near_strikes(STRIKES)],
        ..CASE
    },
    Case {
        name: "rail_joint",
        hard: "a step of 1 mm within 70 mm of the left rail, up, at 20 m/s: it is over in 3.5 ms and nearly as curved as the wheel",
        claim: CLAIM_STRIKES,
        scene: "wheelset_s1002",
        changes: &["track.deviation=[{rail=\"left\",direction=\"vertical\",shape=\"ramp\",amplitude=\"1 mm\",from=4,to=4.07}]"],
        stop: 0.5,
        grid: 1e-4,
        methods: METHODS,
        must: &[near_strikes(STRIKES)],
        ..CASE
    },
    Case {
        name: "walking_pace_and_less",
        hard: "0.05 m/s with steady creep: the creep mode has 500 000/s",
        claim: CLAIM,
        scene: "wheelset_s1002",
        changes: &[STRAIGHT, "vehicle.speed=0.05", "vehicle.initial.y=0.2 mm"],
        stop: 0.5,
        methods: IMPLICIT,
        must: &[STIFF],
        ..CASE
    },
    Case {
        name: "one_centimetre_per_second",
        hard: "0.01 m/s: contacts deflect more than they slip",
        claim: CLAIM,
        scene: "wheelset_s1002",
        changes: &[STRAIGHT, "vehicle.speed=0.01", "vehicle.initial.y=0.2 mm", "contact.transient.below=0.5"],
        stop: 0.3,
        methods: IMPLICIT,
        must: &[STIFF],
        ..CASE
    },
    Case {
        name: "fifty_kilometres",
        hard: "a spectrum over 50 km: waves ahead by the hundred thousand, of which a start may cost nothing",
        claim: CLAIM,
        changes: &[
            STRAIGHT,
            "track.irregularity=[{kind=\"spectrum\",spectrum=\"ore_b176_low\",seed=1,from=0,to=50000,fade=5}]",
            "vehicle.initial.distance=24000",
        ],
        stop: 0.5,
        formulations: &["ECF-A"],
        methods: METHODS,
        must: &[near(BOUNDS)],
        ..CASE
    },
    Case {
        name: "redundant_joints",
        hard: "a box held to the car by two rigid joints: six constraints of twelve say what the others say",
        claim: CLAIM,
        changes: &[
            "vehicle.body[box].mass=200",
            "vehicle.body[box].inertia_xx=20",
            "vehicle.body[box].inertia_yy=20",
            "vehicle.body[box].inertia_zz=20",
            "vehicle.body[box].position=[0.0,0.0,2.5]",
            "vehicle.joint[fore].kind=rigid",
            "vehicle.joint[fore].first=car",
            "vehicle.joint[fore].second=box",
            "vehicle.joint[fore].at=[0.5,0.0,2.0]",
            "vehicle.joint[aft].kind=rigid",
            "vehicle.joint[aft].first=car",
            "vehicle.joint[aft].second=box",
            "vehicle.joint[aft].at=[-0.5,0.0,2.0]",
            "vehicle.initial.distance=15",
        ],
        methods: super::ADAPTIVE,
        must: &[near(BOUNDS)],
        refusable: true,
        ..CASE
    },
    Case {
        name: "150_m_s",
        hard: "150 m/s, far above the critical speed, into the flanges",
        claim: CLAIM_STRIKES,
        scene: "wheelset_s1002",
        changes: &[STRAIGHT, "vehicle.speed=150", "vehicle.initial.vy=0.05"],
        stop: 0.15,
        methods: METHODS,
        must: &[near_strikes(STRIKES)],
        ..CASE
    },
    Case {
        name: "yaw_of_5_degrees",
        hard: "a wheelset on cones starts yawed by 5 degrees at 2 m/s: full slip across, contacts 1 mm ahead",
        claim: "y to 0.1 mm, Q to 10 % of the static load at every 0.2 ms, against dormand_prince 1e-10",
        scene: "suspended_wheelset",
        changes: &[STRAIGHT, "vehicle.speed=2", "vehicle.initial.yaw=5 deg"],
        stop: 0.3,
        methods: METHODS,
        must: &[near_strikes(STRIKES)],
        ..CASE
    },
    Case {
        name: "R_80_m",
        hard: "a bogie into R 80 m at 5 m/s: flange contact at 16 mrad of attack, contacts well ahead of the axle",
        claim: CLAIM_STRIKES,
        changes: &[STRAIGHT, "vehicle.speed=5", "track.node=[{distance=0},{distance=3},{distance=7,radius=80},{distance=400,radius=80}]"],
        stop: 2.0,
        methods: METHODS,
        must: &[near_strikes(STRIKES)],
        ..CASE
    },
    Case {
        name: "curvature_as_a_step",
        hard: "the table jumps from straight to R 500 m within 1 cm",
        claim: CLAIM_STRUCK,
        changes: &[
            STRAIGHT,
            "vehicle.drive=leading",
            "track.node=[{distance=0},{distance=5},{distance=5.01,radius=500},{distance=400,radius=500}]",
        ],
        methods: METHODS,
        must: &[near(STRUCK)],
        ..CASE
    },
    Case {
        name: "at_100_km",
        hard: "a deviation at 100 km: distances of which 1e-11 m are left",
        claim: CLAIM,
        scene: "wheelset_s1002",
        changes: &[
            "vehicle.initial.distance=99995",
            "track.deviation[1].from=100000",
            "track.deviation[1].to=100010",
            "track.deviation[2].from=100000",
            "track.deviation[2].to=100010",
        ],
        methods: METHODS,
        must: &[near(BOUNDS)],
        ..CASE
    },
    Case {
        name: "contact_a_thousand_times_stiffer",
        hard: "a modulus of 2.07e14: the contact vibrates with 3 kHz, penetrations of 0.7 um",
        claim: "y to 0.02 mm, Q to 3 % of the static load at every 0.2 ms, against rosenbrock 1e-9",
        scene: "suspended_wheelset",
        changes: &["contact.material.youngs_modulus=2.07e14", "vehicle.initial.distance=19", "track.deviation[1].to=40"],
        stop: 0.5,
        formulations: ELASTIC,
        methods: IMPLICIT,
        must: &[STIFF],
        ..CASE
    },
    Case {
        name: "suspension_of_1e12",
        hard: "a lateral and a longitudinal suspension of 1e12 N/m: modes of 4 kHz and nothing that moves",
        claim: "y to 0.02 mm, Q to 3 % of the static load at every 0.2 ms, against rosenbrock 1e-9",
        scene: "suspended_wheelset",
        changes: &[
            "vehicle.suspension.longitudinal_stiffness=1e12",
            "vehicle.suspension.lateral_stiffness=1e12",
            "vehicle.initial.distance=15",
        ],
        stop: 0.5,
        methods: IMPLICIT,
        must: &[STIFF],
        ..CASE
    },
    Case {
        name: "suspension_of_nothing",
        hard: "a free wheelset: its mean place and yaw are held by creep alone",
        claim: CLAIM,
        scene: "suspended_wheelset",
        changes: &[
            "vehicle.suspension.longitudinal_stiffness=0",
            "vehicle.suspension.lateral_stiffness=0",
            "vehicle.suspension.longitudinal_damping=0",
            "vehicle.initial.distance=15",
            "track.deviation[1].amplitude=2 mm",
        ],
        methods: METHODS,
        must: &[near(BOUNDS)],
        ..CASE
    },
    Case {
        name: "pebble_on_the_car",
        hard: "1 kg on a spring of 1e7 N/m on a car of 16 t: 500 Hz without damping that nobody asks for",
        claim: CLAIM,
        changes: &[
            "vehicle.body[pebble].mass=1",
            "vehicle.body[pebble].inertia_xx=0.01",
            "vehicle.body[pebble].inertia_yy=0.01",
            "vehicle.body[pebble].inertia_zz=0.01",
            "vehicle.body[pebble].position=[0.0,0.0,2.5]",
            "vehicle.force[link].kind=bushing",
            "vehicle.force[link].from=car",
            "vehicle.force[link].to=pebble",
            "vehicle.force[link].at=[0.0,0.0,2.5]",
            "vehicle.force[link].stiffness=[1e7,1e7,1e7]",
            "vehicle.force[link].rotational_stiffness=[1e5,1e5,1e5]",
            "vehicle.force[link].preload=[0.0,0.0,9.81]",
            "vehicle.initial.distance=15",
        ],
        methods: METHODS,
        must: &[near(BOUNDS)],
        ..CASE
    },
    Case {
        name: "far_from_equilibrium",
        hard: "a start 4 mm aside, rolled by 20 mrad and 5 mm too high: one wheel lands after the other",
        claim: CLAIM_STRIKES,
        scene: "wheelset_s1002",
        changes: &[
            STRAIGHT,
            "vehicle.initial.y=4 mm",
            "vehicle.initial.roll=20 mrad",
            "vehicle.initial.from_equilibrium=false",
            "vehicle.initial.z=0.48",
        ],
        stop: 0.5,
        formulations: &["ECF-A"],
        methods: METHODS,
        must: &[near_strikes(STRIKES)],
        ..CASE
    },
    Case {
        name: "unloaded_in_a_curve",
        hard: "in R 500 m the whole load is taken off within nothing and put on again after 60 ms: wheels lift and land on flanges",
        claim: CLAIM_STRIKES,
        scene: "wheelset_s1002",
        changes: &[STRAIGHT, "track.node=[{distance=0,radius=500,superelevation=\"-60 mm\"}]"],
        inputs: &[
            super::super::case::InputChange { time: 0.1, input: VERTICAL_FORCE, value: 112e3 },
            super::super::case::InputChange { time: 0.16, input: VERTICAL_FORCE, value: 0.0 },
        ],
        stop: 0.4,
        grid: 1e-4,
        methods: METHODS,
        must: &[near_strikes(STRIKES)],
        audit: Audited { weight: 0.02, ..AUDIT },
        ..CASE
    },
    Case {
        name: "ten_million_exchanges",
        hard: "10 s in 1e7 communication steps of 1 us, within steps of milliseconds",
        claim: "the same bits at the end as with one",
        scene: "suspended_wheelset",
        changes: &["vehicle.initial.distance=15"],
        stop: 10.0,
        grid: 5e-3,
        formulations: &["ECF-A", "ECCF"],
        methods: &[
            Method::new("rosenbrock", "tolerance=1e-5"),
            Method::new("dormand_prince", "tolerance=1e-6"),
            Method::new("real_time", "step=1 ms"),
        ],
        must: &[Must::Exchanges(10_000_000)],
        audit: Audited { energy: f64::INFINITY, ..AUDIT },
        quick: false,
        ..CASE
    },
    Case {
        name: "nodes_on_standard_profiles",
        hard: "ECF-N on S1002 and 60E1 over 3 mm of alignment: contacts among nodes, and two places that are equally deep",
        claim: "N changes by at most 50 N from one 0.1 ms to the next",
        scene: "wheelset_s1002",
        changes: &["vehicle.initial.distance=8"],
        stop: 1.0,
        grid: 1e-4,
        formulations: ELASTIC,
        methods: &[Method::new("dormand_prince", "tolerance=1e-6"), Method::new("rosenbrock", "tolerance=1e-5")],
        must: &[Must::Formula(does_not_jump)],
        audit: Audited { energy: 0.05, ..AUDIT },
        ..CASE
    },
    Case {
        name: "nadal",
        hard: "a flange climbs at 50 mrad of attack under a lateral force that grows by 100 kN/s: Y/Q at the limit of friction",
        claim: "while the flange alone carries and climbs, above 58 degrees, Y/Q (mean of 5 ms) within 3 % of Nadal's (tan d - mu) / (1 + mu tan d), mu = 0.35, at its contact angle d",
        scene: "wheelset_s1002",
        changes: &[
            "track.deviation=[{rail=\"both\",direction=\"lateral\",shape=\"ramp\",amplitude=\"500 mm\",from=2,to=12}]",
            "vehicle.speed=5",
            "vehicle.initial.distance=2",
            "vehicle.suspension.lateral_stiffness=0",
            "vehicle.suspension.longitudinal_stiffness=1e9",
        ],
        inputs: CLIMB,
        stop: 2.0,
        formulations: SMOOTH,
        methods: &[Method::new("rosenbrock", "tolerance=1e-5"), Method::new("dormand_prince", "tolerance=1e-7")],
        must: &[Must::Formula(climbs_at_nadal)],
        audit: Audited { derailment: true, weight: 0.05, energy: 0.05, ..AUDIT },
        ..CASE
    },
];

/// A force to the right that grows by 2 kN every 20 ms from 0.5 s on.
const CLIMB: &[super::super::case::InputChange] = &{
    let mut all = [super::super::case::InputChange { time: 0.0, input: crate::formulation::LATERAL_FORCE, value: 0.0 }; 75];
    let mut i = 0;
    while i < all.len() {
        all[i].time = 0.5 + 0.02 * i as f64;
        all[i].value = -2e3 * (i as f64 + 1.0);
        i += 1;
    }
    all
};

fn does_not_jump(ran: &Ran) -> Vec<Finding> {
    let jump = |n: &[f64]| n.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    let most = ran.trace.of(Quantity::Normal).map(jump).fold(0.0, f64::max);
    vec![Finding::new("change of N in 0.1 ms", most, 50.0, Unit::Newton)]
}

fn climbs_at_nadal(ran: &Ran) -> Vec<Finding> {
    const SAMPLES: usize = 25;
    const STEEP: f64 = 58.0;
    let wheel = |quantity| ran.trace.one(quantity, 0, Some(Side::Right));
    let (quotient, normal) = (wheel(Quantity::Quotient), ran.trace.places(Quantity::PlaceNormal, 0, Side::Right));
    // What is left of the tread's contact is over when the climb begins.
    let two = |sample: usize| normal.iter().filter(|n| n[sample] > 0.0).count() > 1;
    let begin = (0..quotient.len()).rev().find(|sample| two(*sample)).map_or(0, |sample| sample + 1);
    let angles: Vec<f64> = (0..quotient.len())
        .map(|sample| {
            let places = normal.iter().zip(ran.trace.places(Quantity::PlaceAngle, 0, Side::Right));
            places.filter(|(n, _)| n[sample] > 0.0).map(|(_, angle)| angle[sample].abs()).fold(0.0, f64::max)
        })
        .collect();
    let steep = angles[begin..].iter().take_while(|angle| **angle > STEEP.to_radians()).count();
    let mean = |part: &[f64]| part.iter().sum::<f64>() / SAMPLES as f64;
    let nadal = |angle: f64| (angle.tan() - FRICTION) / (1.0 + FRICTION * angle.tan());
    let climb = quotient[begin..begin + steep].windows(SAMPLES).zip(angles[begin..begin + steep].windows(SAMPLES));
    let apart = climb.clone().map(|(quotient, angles)| (mean(quotient) / nadal(mean(angles)) - 1.0).abs());
    vec![
        Finding::new("Y/Q against Nadal's", apart.fold(0.0, f64::max), 0.03, Unit::Share),
        // Some of the climb must be seen: 20 ms.
        Finding::new("5 ms parts of the climb that are missing", 75.0 - climb.count() as f64, 0.0, Unit::One),
    ]
}

/// mu of the scene.
const FRICTION: f64 = 0.35;
