//! Places of contact that merge at low speed: what a patch remembers stays with it.

use crate::common::{column, run};
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;
use wheelrail::settings::Source;

/// A suspended wheelset on S1002 and 60E1, whose tread has two least distances near the centre.
fn wheelset(speed: f64, track: &str, below: f64, changes: &[&str]) -> Scene {
    let text = format!(
        r#"
name = "merging"
[vehicle]
template = "suspended_wheelset"
speed = {speed:?}
[vehicle.wheelset]
mass = 1813.0
inertia_xx = 1120.0
inertia_yy = 112.0
inertia_zz = 1120.0
vertical_load = 91300.0
tread_circle_distance = "1500 mm"
profile = {{ kind = "s1002", radius = 0.46 }}
[vehicle.suspension]
distance = "2 m"
longitudinal_stiffness = 1.0e6
longitudinal_damping = 15.0e3
lateral_stiffness = 0.5e6
lateral_damping = 2.0e3
[track]
gauge = "1435 mm"
inclination = "1:40"
rail = {{ kind = "60e1" }}
{track}
[contact]
formulation = "ECF-A"
friction = 0.35
patch = "ellipse"
[contact.transient]
below = {below:?}
[contact.material]
youngs_modulus = 2.1e11
poisson_ratio = 0.28
[contact.creep]
law = "usetab"
[interface]
outputs = ["motion", "wheels", "contacts"]
[run]
stop = 4.0
step = "1 ms"
"#
    );
    let source = Source { file: "merging.toml".into(), text, overridden: vec![], folder: None };
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_string()).collect();
    load::read("merging", source, &changes).unwrap_or_else(|error| panic!("{error}"))
}

/// Both rails move by 3 mm, and the loaded place, number 2, merges with the shallower number 1. With number 1's deflection for its own Y jumped by 3.5 kN.
#[test]
fn hard_a_patch_keeps_its_deflection_where_two_places_merge() {
    let shift = "[[track.deviation]]\nrail=\"both\"\ndirection=\"lateral\"\nshape=\"cosine\"\namplitude=\"3 mm\"\nfrom=\"1 m\"\nto=\"7 m\"";
    for speed in [0.5, 1.0, 1.3] {
        let recording = run(&wheelset(speed, shift, 2.0, &[]), 7.0 / speed, 5e-4 / speed);
        let mut merged = 0;
        for side in ["left", "right"] {
            let load = |number: usize| column(&recording, &format!("{side}.contact[{number}].normalForce"));
            let carries = |number: usize| load(number).iter().map(|load| *load > 0.0).collect::<Vec<_>>();
            let (first, second) = (carries(1), carries(2));
            merged += (1..first.len()).filter(|k| first[k - 1] && second[k - 1] && first[*k] != second[*k]).count();
            let y = column(&recording, &format!("{side}.lateralForce"));
            let jump = y.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
            println!("{speed} m/s {side}: largest change of Y in 0.5 mm {jump:.1} N");
            assert!(jump < 20.0, "{speed} m/s {side}: {jump}");
        }
        assert!(merged > 0, "nothing merges at {speed} m/s");
    }
}

/// Patches end and begin at grazing angles, where rates of their states that jumped stopped each run with a tolerance of 1e-7 or less.
#[test]
fn hard_patches_that_end_at_a_grazing_angle_stop_no_run() {
    let rough = "[[track.irregularity]]\nkind=\"spectrum\"\nspectrum=\"ore_b176_low\"\nseed=3\nfrom=5.0\nto=\"150 m\"\nfade=\"10 m\"";
    let y = |tolerance: &str| {
        let scene = wheelset(10.0, rough, 40.0, &["solver.integrator=rosenbrock", &format!("solver.tolerance={tolerance}")]);
        let recording = run(&scene, 3.0, 1e-3);
        ["left", "right"].map(|side| column(&recording, &format!("{side}.lateralForce")))
    };
    let [right, middle, loose] = ["1e-8", "1e-7", "1e-5"].map(y);
    for (found, allowed) in [(middle, 10.0), (loose, 100.0)] {
        for side in 0..2 {
            let off = found[side].iter().zip(&right[side]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            println!("Y off by {off:.1} N of {allowed}");
            assert!(found[side].len() == right[side].len() && off < allowed, "{off}");
        }
    }
}
