//! Profiles that are kinked, noisy, coarse, oversampled, conformal, hollow or flat.

use super::super::case::{CASE, Case, Method, Must, SMOOTH};
use super::super::trace::Quantity;
use super::{bound, near};
use std::fmt::Write as _;

const METHODS: &[Method] = &[
    Method::new("rosenbrock", "tolerance=1e-5"),
    Method::new("imex", "tolerance=1e-5"),
    Method::new("dormand_prince", "tolerance=1e-6"),
    Method::new("real_time", "step=1 ms"),
];

const BOUNDS: &[super::Bound] = &[bound(Quantity::Y, 2e-5), bound(Quantity::Vertical, 0.03)];

const NEAR: &[Must] = &[near(BOUNDS)];

/// Points of a curve between two coordinates.
fn points(head: &str, (from, to): (f64, f64), count: u32, curve: impl Fn(f64) -> f64) -> String {
    let mut text = format!("{head}\n");
    for i in 0..count {
        let x = from + (to - from) * f64::from(i) / f64::from(count - 1);
        let _ = writeln!(text, "{x:.9},{:.12}", curve(x));
    }
    text
}

/// A circular rail head of this radius, m.
fn head(radius: f64) -> impl Fn(f64) -> f64 {
    move |eta| (radius * radius - eta * eta).sqrt() - radius
}

const RAIL: (f64, f64) = (-0.034, 0.034);
const WHEEL: (f64, f64) = (-0.04, 0.05);

fn coarse() -> Vec<(&'static str, String)> {
    vec![("rail.csv", points("eta,height", RAIL, 20, head(0.3)))]
}

fn oversampled() -> Vec<(&'static str, String)> {
    vec![("rail.csv", points("eta,height", RAIL, 20_000, head(0.3)))]
}

/// Noise of some micrometres that is the same everywhere.
fn noisy() -> Vec<(&'static str, String)> {
    let noise = |eta: f64| 2e-6 * ((4_000.0 * eta).sin() + (9_100.0 * eta + 1.0).sin() + (13_700.0 * eta + 2.0).sin());
    vec![("rail.csv", points("eta,height", RAIL, 137, move |eta| head(0.3)(eta) + noise(eta)))]
}

/// Two straight flanks of 1:60 that meet in the middle.
fn kinked() -> Vec<(&'static str, String)> {
    vec![("rail.csv", points("eta,height", RAIL, 69, |eta| -eta.abs() / 60.0))]
}

fn flat() -> Vec<(&'static str, String)> {
    vec![("rail.csv", points("eta,height", RAIL, 35, |_| 0.0))]
}

/// A tread that is hollow with this radius, over a cone of 1:40.
fn hollow(radius: f64) -> impl Fn(f64) -> f64 {
    move |u| 0.457 - 0.025 * u + 0.5 * u * u / radius
}

fn conformal() -> Vec<(&'static str, String)> {
    vec![("wheel.csv", points("u,radius", WHEEL, 181, hollow(0.33)))]
}

fn negative() -> Vec<(&'static str, String)> {
    vec![("wheel.csv", points("u,radius", WHEEL, 181, hollow(0.28)))]
}

const POINTS_RAIL: &str = "track.rail={kind=\"points\",file=\"rail.csv\"}";
const POINTS_WHEEL: &str = "vehicle.wheelset.profile={kind=\"points\",file=\"wheel.csv\"}";
const PATCH: &str = "contact.normal={law=\"hertz\",curvature=\"patch\",conformal=\"bounded\"}";
/// 2 mm of gauge reduction: a swing that stays on the tread.
const SMALL: &str = "track.deviation[1].amplitude=2 mm";

const fn case(name: &'static str, hard: &'static str, files: super::super::case::Files, changes: &'static [&'static str]) -> Case {
    Case {
        name,
        hard,
        claim: "y to 0.02 mm, Q to 3 % of the static load at every 0.2 ms, against dormand_prince 1e-9, or a refusal with its reason",
        scene: "suspended_wheelset",
        changes,
        files: Some(files),
        stop: 1.0,
        formulations: SMOOTH,
        methods: METHODS,
        must: NEAR,
        refusable: true,
        ..CASE
    }
}

pub(super) const CASES: &[Case] = &[
    case("coarse_profile", "a rail head of 20 points", coarse, &[POINTS_RAIL, PATCH, SMALL]),
    case("oversampled_profile", "a rail head of 20 000 points", oversampled, &[POINTS_RAIL, PATCH, SMALL]),
    case(
        "noisy_profile",
        "a rail head with 3 um of noise at every 0.5 mm",
        noisy,
        &["track.rail={kind=\"points\",file=\"rail.csv\",smoothing=\"0.003 mm\"}", PATCH, SMALL],
    ),
    case("kinked_profile", "two straight flanks that meet in a kink under the wheel", kinked, &[POINTS_RAIL, PATCH, SMALL]),
    case("flat_on_flat", "a cone on a flat rail head: a line of contact", flat, &[POINTS_RAIL, PATCH, SMALL]),
    Case {
        claim: "y to 0.05 mm (the place of contact moves eleven times as far), Q to 3 % of the static load at every 0.2 ms, against dormand_prince 1e-9",
        must: &[near(&[bound(Quantity::Y, 5e-5), bound(Quantity::Vertical, 0.03)])],
        ..case("conformal", "a tread hollow with 0.33 m on a head of 0.3 m", conformal, &[POINTS_WHEEL, PATCH, SMALL])
    },
    case(
        "negative_relative_curvature",
        "a tread hollower (0.28 m) than the head is round (0.3 m): it stands on its edges",
        negative,
        &[POINTS_WHEEL, PATCH, SMALL],
    ),
    Case {
        name: "sharp_rail",
        hard: "a rail head of 5 mm radius: patches of a/b 1:20 and beyond, 0.3 mm of penetration",
        claim: "y to 0.02 mm, Q to 3 % of the static load at every 0.2 ms, against dormand_prince 1e-9, or a refusal with its reason",
        scene: "suspended_wheelset",
        changes: &["track.rail={kind=\"arc\",radius=0.005}", PATCH, SMALL],
        methods: METHODS,
        must: NEAR,
        refusable: true,
        ..CASE
    },
    Case {
        name: "edge_of_a_rail",
        hard: "a rail head of 1 mm radius: patches of a/b 1:50, beyond most tables of creep coefficients",
        claim: "y to 0.02 mm, Q to 3 % of the static load at every 0.2 ms, against dormand_prince 1e-9, or a refusal with its reason",
        scene: "suspended_wheelset",
        changes: &["track.rail={kind=\"arc\",radius=0.001}", PATCH, SMALL],
        methods: METHODS,
        must: NEAR,
        refusable: true,
        ..CASE
    },
    Case {
        name: "blunt_rail",
        hard: "a rail head of 2 m radius under a cone: patches of a/b 1:4 across; the search for several contacts panicked",
        claim: "y to 0.02 mm, Q to 3 % of the static load at every 0.2 ms, against dormand_prince 1e-9, or a refusal with its reason",
        scene: "suspended_wheelset",
        changes: &["track.rail={kind=\"arc\",radius=2.0}", PATCH, SMALL],
        methods: METHODS,
        must: NEAR,
        refusable: true,
        ..CASE
    },
    Case {
        name: "blunt_rail_searched",
        hard: "the same under S1002: its flange is searched for",
        claim: "comes back within 2 s each: refused with its reason, or right to 0.02 mm and 3 %",
        scene: "wheelset_s1002",
        changes: &["track.rail={kind=\"arc\",radius=2.0}", "contact.on_lift=elastic"],
        methods: METHODS,
        must: NEAR,
        refusable: true,
        ..CASE
    },
];
