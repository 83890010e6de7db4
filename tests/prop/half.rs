//! `effects.symmetry = "half"`: contacts of right wheels in a mirror. A symmetric run is the same, and what is not symmetric is refused or ends.

use crate::common::start;
use std::collections::HashMap;
use wheelrail::formulation::{LATERAL_FORCE, RIGHT_FRICTION, input_index};
use wheelrail::scene::load;
use wheelrail::sim::recording::record;
use wheelrail::sim::vehicle_outputs::scene_outputs;

const HALF: &str = "effects.symmetry=half";
/// Both rails sink and rise again.
const DIP: &str = r#"track.deviation=[{rail="both",direction="vertical",shape="cosine",amplitude=-0.006,from=10.013,to=16.017}]"#;

fn example(name: &str) -> String {
    format!("{}/examples/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

/// Scene, its changes, stop [s].
fn cases() -> Vec<(String, Vec<&'static str>, f64)> {
    let tight = "solver.tolerance=1e-8";
    vec![
        ("wheelset_s1002".into(), vec![DIP, tight], 2.0),
        ("vehicle_manchester_1".into(), vec![DIP, tight, "contact.patch=ellipse"], 1.5),
        ("vehicle_manchester_1".into(), vec![DIP, tight], 0.6),
        (example("driven_truck"), vec![DIP, tight], 0.0),
        (example("scenes/locomotive_with_motors"), vec![tight, "contact.patch=ellipse"], 3.0),
        (example("scenes/freight_wagon_wedges"), vec![tight, "contact.patch=ellipse"], 2.0),
    ]
}

#[test]
fn prop_half_of_a_symmetric_run_is_the_same_run() {
    for (scene, changes, stop) in cases().into_iter().filter(|case| case.2 > 0.0) {
        let of = |half: &[&str]| {
            let all: Vec<String> = changes.iter().chain(half).map(|change| (*change).to_string()).collect();
            let scene = load::open(&scene, &all).unwrap_or_else(|error| panic!("{error}"));
            let mut simulation = start(&scene);
            let outputs = scene_outputs(&scene, simulation.model());
            let recording = record(&mut simulation, &outputs, stop, 2e-3, |_| ()).unwrap_or_else(|error| panic!("{error}"));
            let found: HashMap<String, Vec<f64>> =
                recording.columns.iter().map(|(name, _)| (name.clone(), recording.column(name).unwrap())).collect();
            (found, simulation.state().work.search_iterations, simulation.statistics().evaluations)
        };
        let ((whole, searches, evaluations), (half, fewer, again)) = (of(&[]), of(&[HALF]));
        let (mut load, mut motion, mut sides): (f64, f64, f64) = (0.0, 0.0, 0.0);
        for (name, values) in &whole {
            let other = &half[name];
            let apart = values.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            if name.ends_with("verticalForce") {
                load = load.max(apart);
            }
            if name.ends_with(".z") || name.ends_with(".distance") {
                motion = motion.max(apart);
            }
            if let Some(left) = name.strip_suffix("right.verticalForce") {
                let left = &half[&format!("{left}left.verticalForce")];
                sides = sides.max(other.iter().zip(left).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max));
            }
        }
        let share = fewer as f64 * evaluations as f64 / (searches as f64 * again as f64);
        println!("{scene} {changes:?}: loads {load:.3} N, places {motion:.1e} m, left and right {sides:.1e} N, searches {share:.2}");
        assert!(load < 2.0 && motion < 1e-7 && sides < 1e-6 && (searches == 0 || share < 0.6), "{scene}");
    }
}

#[test]
fn prop_what_is_not_symmetric_is_refused_with_the_reason() {
    let coach = "vehicle_manchester_1";
    for (scene, changes, reason) in [
        (coach, vec![], "the rails are no mirror images"),
        ("vehicle_curve", vec![], "the track is curved or canted at"),
        (coach, vec!["track.deviation=[]", "contact.formulation=ECF-N"], "contact.formulation must be"),
        (coach, vec!["track.deviation=[]", "contact.formulation=ECCF"], "contact.formulation must be"),
        (coach, vec!["track.deviation=[]", "contact.transient={below=2}"], "[contact.transient] does not go with it"),
        (coach, vec!["track.deviation=[]", "track.flexibility=travelling"], "track.flexibility does not go with it"),
        ("suspended_wheelset", vec!["track.deviation=[]", "vehicle.initial.y=0.001"], "begins with y = 1.00e-3"),
        (
            "wheelset_s1002",
            vec![
                "track.deviation=[]",
                "vehicle.force=[{name=\"axle\",kind=\"flexible_axle\",body=\"wheelset\",stiffness=6e6,damping=100,left_share=0.45}]",
            ],
            "accelerated against each other",
        ),
        ("wheelset_s1002", vec!["track.deviation=[]", "vehicle.wheelset.right_profile={kind=\"s1002\",radius=0.45}"], "different profiles"),
    ] {
        let changes: Vec<String> = changes.into_iter().chain([HALF]).map(String::from).collect();
        let error = match load::open(scene, &changes) {
            Err(error) => error.to_string(),
            Ok(scene) => wheelrail::sim::Simulation::new(&scene, 0.0).err().map(|error| error.to_string()).unwrap_or_default(),
        };
        println!("{error}");
        assert!(error.contains("effects.symmetry = \"half\", but ") && error.contains(reason), "{scene} {changes:?}: {error}");
    }
    // One wedge damper alone.
    let text = std::fs::read_to_string(example("scenes/freight_wagon_wedges")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("wagon.toml");
    std::fs::write(
        &file,
        text.replacen("[vehicle]", "[effects]\nsymmetry = \"half\"\nwithout = [\"truck[1].wedge.left\"]\n\n[vehicle]", 1),
    )
    .unwrap();
    let error = wheelrail::sim::Simulation::new(&load::open(&file.display().to_string(), &[]).unwrap(), 0.0).unwrap_err().to_string();
    println!("{error}");
    assert!(error.contains("displaced symmetrically") || error.contains("begins with"), "{error}");
}

#[test]
fn prop_a_run_that_loses_its_symmetry_ends_with_the_reason() {
    for (input, value, reason) in [(LATERAL_FORCE, 5.0, "acceleration"), (RIGHT_FRICTION, 0.9, "friction factors")] {
        let changes = ["track.deviation=[]".to_string(), HALF.to_string()];
        let mut simulation = start(&load::open("bogie", &changes).unwrap());
        simulation.advance(0.2).unwrap();
        simulation.set_input(input_index(0, input), value, 0.0, 0.0);
        let error = simulation.advance(1.0).unwrap_err().to_string();
        println!("{error}");
        assert!(error.contains("no longer symmetric") && error.contains(reason), "{error}");
        assert!(simulation.time() < 0.25);
    }
    // A rail that rises alone far behind what the start looks at.
    let far = r#"track.deviation=[{rail="left",direction="vertical",shape="cosine",amplitude=0.003,from=600,to=610}]"#;
    let changes = [far.to_string(), HALF.to_string(), "vehicle.speed=60".to_string()];
    let mut simulation = start(&load::open("bogie", &changes).unwrap());
    let error = simulation.advance(12.0).unwrap_err().to_string();
    assert!(error.contains("the rails' difference in height"), "{error}");
    // A torque on one of two wheels that turn apart.
    let free = r#"vehicle.force=[{name="axle",kind="independent_wheels",body="truck[1].wheelset[1]",damping=500},{name="brake",kind="brake",type="disc",wheel="right",from={body="truck[1].frame",at=[9.5,0,0.6]},to={body="truck[1].wheelset[1]",at=[10.78,0,0.46]},torque=500,stiffness="6 MN m/rad"}]"#;
    let changes = ["track.deviation=[]", "vehicle.travel=free", "contact.patch=ellipse", free, HALF].map(String::from);
    let scene = load::open("vehicle_manchester_1", &changes).unwrap_or_else(|error| panic!("{error}"));
    let error = match wheelrail::sim::Simulation::new(&scene, 0.0) {
        Ok(mut simulation) => simulation.advance(1.0).unwrap_err().to_string(),
        Err(error) => error.to_string(),
    };
    println!("{error}");
    assert!(error.contains("one wheel against the other") || error.contains("accelerated against each other"), "{error}");
}
