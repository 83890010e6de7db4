//! Scenes that make no sense, and say so at once.

use super::super::case::{CASE, Case, Method, Must};

const ONE: &[Method] = &[Method::new("rosenbrock", "tolerance=1e-5")];
const ALL: &[&str] = &["ECF-A", "ECCF"];

const fn case(
    name: &'static str,
    hard: &'static str,
    claim: &'static str,
    changes: &'static [&'static str],
    must: &'static [Must],
) -> Case {
    Case { name, hard, claim, changes, stop: 0.1, formulations: ALL, methods: ONE, must, ..CASE }
}

pub(super) const CASES: &[Case] = &[
    case(
        "node_at_1e30_m",
        "a node of the track at 1e30 m",
        "refused within 2 s, naming the node's distance",
        &["track.deviation=[]", "track.node=[{distance=0},{distance=1e30,radius=500}]"],
        &[Must::Refusal(&["track.node", "distance"])],
    ),
    case(
        "node_at_1e14_m",
        "a node of the track at 1e14 m, whose table would take 12.8 TB",
        "refused within 2 s, naming the node's distance",
        &["track.deviation=[]", "track.node=[{distance=0},{distance=1e14,radius=500}]"],
        &[Must::Refusal(&["track.node", "distance"])],
    ),
    case(
        "arc_radius_300_m",
        "a rail head of 300 m radius: nearly flat over its whole width, the search took minutes",
        "refused within 2 s, naming how far its face would have to go down for the gauge",
        &["track.rail={kind=\"arc\",radius=300}"],
        &[Must::Refusal(&["track.gauge", "ends"])],
    ),
    case(
        "steady_creep_at_a_crawl",
        "0.01 m/s where creepage is steady: the creep mode has 2 500 000/s and creep forces divide by the speed",
        "refused within 2 s, naming contact.transient",
        &["track.deviation=[]", "vehicle.speed=0.01"],
        &[Must::Refusal(&["travelling speed", "[contact.transient]"])],
    ),
    case(
        "square_step",
        "a step of 1 mm within 20 mm, up: more curved than the wheel, which stands on two places along the track; the one that was found changed between two looks",
        "refused within 2 s, naming the place and the radii",
        &["track.deviation=[{rail=\"left\",direction=\"vertical\",shape=\"ramp\",amplitude=\"1 mm\",from=6,to=6.02}]"],
        &[Must::Refusal(&["two places along the track", "left rail", "6.0"])],
    ),
    case(
        "body_without_support",
        "a body that nothing holds falls for ever: there is no steady state",
        "refused within 2 s, naming the body",
        &[
            "vehicle.body[lost].mass=100",
            "vehicle.body[lost].inertia_xx=1",
            "vehicle.body[lost].inertia_yy=1",
            "vehicle.body[lost].inertia_zz=1",
            "vehicle.body[lost].position=[0.0,0.0,3.0]",
        ],
        &[Must::Refusal(&["lost"])],
    ),
    case(
        "curve_too_fast",
        "R 150 m at 60 m/s: no steady curving; the search took 5 to 42 s",
        "refused within 2 s, saying how far it goes",
        &["track.deviation=[]", "track.node=[{distance=0,radius=150}]", "vehicle.speed=60", "vehicle.drive=leading"],
        &[Must::Refusal(&["steady curving"])],
    ),
];
