//! Rails that bend sideways sharply: a flange touches them tens of millimetres ahead of the wheel's centre, where the rail is another one than beside it.

use crate::common::start;
use wheelrail::formulation::Model;
use wheelrail::geometry::Side;
use wheelrail::mbs::body::BodyMotion;
use wheelrail::scene::load;
use wheelrail::sim::Simulation;

fn begin(scene: &str, changes: &[&str]) -> Simulation {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    start(&load::open(scene, &changes).unwrap_or_else(|error| panic!("{error}")))
}

/// Deepest overlap of a wheel's surface with its rail, m, by looking everywhere: no search, no view along the rail.
fn overlap(model: &Model, wheelset: usize, side: Side, motion: &BodyMotion) -> f64 {
    let (wheel, rail) = (model.wheelsets[wheelset].wheel(side), model.track.rail(side));
    let (first, last) = rail.profile.range();
    let mut deepest = f64::NEG_INFINITY;
    for k in 0..=160 {
        let u = -0.042 + 0.06 * f64::from(k) / 160.0;
        for j in -75..=75 {
            let point = wheel.point(&motion.position, &motion.frame.axes, u, 4e-3 * f64::from(j)).0.position;
            let mut s = motion.distance;
            let mut section = rail.section(s);
            for _ in 0..4 {
                let across = section.outward.cross(&section.up);
                s += across.dot(&(point - section.origin)) / across.dot(&section.d1);
                section = rail.section(s);
            }
            let off = point - section.origin;
            let (eta, height) = (off.dot(&section.outward), off.dot(&section.up));
            if (first..=last).contains(&eta) {
                let there = rail.profile.at(eta);
                deepest = deepest.max((there.value - height) / there.d1.hypot(1.0));
            }
        }
    }
    deepest
}

/// Largest lateral force of the outer wheel of the leading wheelset [N], and the deepest overlap of its surfaces [m], on the way through a pocket in the outer rail.
fn pocket(formulation: &str, (depth, length): (f64, f64)) -> (f64, f64) {
    let to = 3.003 + length;
    let changes = [
        "vehicle.speed=2",
        "vehicle.wheel_profile={kind=\"s1002\",radius=0.46}",
        "track.rail={kind=\"60e1\"}",
        "track.node=[{distance=0,radius=\"150 m\"}]",
        &format!("track.deviation=[{{rail=\"right\",direction=\"lateral\",shape=\"cosine\",amplitude={},from=3.003,to={to}}}]", -depth),
        "contact.friction=0.25",
        &format!("contact.formulation={formulation}"),
    ];
    let mut simulation = begin("bogie", &changes);
    let (mut largest, mut deepest) = (0.0f64, 0.0f64);
    for k in 0..=1000 {
        simulation.advance(1.4 + 3e-4 * f64::from(k)).unwrap_or_else(|error| panic!("{formulation}: {error}"));
        let (body, contact) = (simulation.model().wheelsets[0].body, 1);
        let snapshot = simulation.snapshot().unwrap_or_else(|error| panic!("{formulation}: {error}"));
        largest = largest.max(snapshot.workspace.wheel_force(contact, body).y.abs());
        let motion = snapshot.workspace.system.motions[body];
        if k % 10 != 0 {
            continue;
        }
        deepest = deepest.max(overlap(simulation.model(), 0, Side::Right, &motion));
    }
    (largest, deepest)
}

/// The flange went 0.38 mm into the rail unseen, and then struck with 2 MN.
#[test]
fn hard_flanges_do_not_pass_through_pockets_of_the_rail() {
    for what in [(4e-3, 0.3), (4e-3, 0.4), (1e-3, 0.15)] {
        let all = ["ECF-A", "ECF-N"].map(|formulation| pocket(formulation, what));
        println!("{:.0} mm over {} m: {all:?}", 1e3 * what.0, what.1);
        let [(a, a_deep), (n, n_deep)] = all;
        assert!(a_deep < 1.3e-4 && n_deep < 1.3e-4, "{what:?}: {a_deep:.1e} {n_deep:.1e} m");
        assert!((a - n).abs() < 0.04 * n && a < 1.5e5, "{what:?}: {a:.0} {n:.0} N");
    }
}

/// On a flank that is nearly conformal a second minimum is born with a ridge beside it; without that ridge its load counted twice (44 kN for 14 kN).
#[test]
fn hard_places_ahead_share_their_patch() {
    let largest = |formulation: &str| {
        let changes = [
            "vehicle.speed=2",
            "vehicle.wheelset={mass=1813,inertia_xx=1120,inertia_yy=112,inertia_zz=1120,vertical_load=91300,tread_circle_distance=1.5,profile={kind=\"s1002\",radius=0.46}}",
            "vehicle.suspension={distance=2,longitudinal_stiffness=1e6,longitudinal_damping=15e3,lateral_stiffness=0.5e6,lateral_damping=2e3}",
            "track={gauge=1.435,inclination=\"1:40\",rail={kind=\"60e1\"},node=[{distance=0,radius=\"100 m\"}],deviation=[{rail=\"right\",direction=\"lateral\",shape=\"cosine\",amplitude=\"4 mm\",from=1,to=2}]}",
            "contact.friction=0.35",
            "contact.patch=ellipse",
            &format!("contact.formulation={formulation}"),
        ];
        let mut simulation = begin("suspended_wheelset", &changes);
        let body = simulation.model().wheelsets[0].body;
        let mut largest = 0.0f64;
        for k in 0..=2000 {
            simulation.advance(5e-4 * f64::from(k)).unwrap_or_else(|error| panic!("{formulation}: {error}"));
            let snapshot = simulation.snapshot().unwrap_or_else(|error| panic!("{formulation}: {error}"));
            largest = largest.max(snapshot.workspace.wheel_force(1, body).y.abs());
        }
        largest
    };
    let [a, n] = ["ECF-A", "ECF-N"].map(largest);
    println!("ECF-A {a:.0} N, ECF-N {n:.0} N");
    assert!((a - n).abs() < 0.03 * n, "{a:.0} {n:.0}");
}
