//! A wheelset on irregular track, and irregularities in an FMU.

use crate::common::{column, run, start, straight};
use wheelrail::fmi::package::pack_scene;
use wheelrail::geometry::Side;
use wheelrail::geometry::track::Direction;
use wheelrail::scene::load;
use wheelrail::scene::spec::Scene;

/// Behind the deviation of the embedded scene.
const BEGIN: f64 = 110.0;

fn spectrum(keys: &str) -> Scene {
    let table = format!("track.irregularity=[{{kind=\"spectrum\", spectrum=\"fra5\", seed=1, from={BEGIN}, to=500, fade=20{keys}}}]");
    straight(&[&table])
}

/// Displacement of a rail with derivatives.
fn rail(scene: &Scene, side: Side, direction: Direction, s: f64) -> [f64; 4] {
    let parts = scene.track.deviations.iter().filter(|d| d.side == side && d.direction == direction).map(|d| d.shape.at(s));
    parts.fold([0.0; 4], |sum, part| std::array::from_fn(|i| sum[i] + part[i]))
}

#[test]
fn analytic_a_wheelset_follows_the_level_and_its_wheels_carry_what_that_takes() {
    // Waves of 10 m to 100 m at 40 m/s are slow for a mass on two contacts (2.3e9 N/m): it follows the rails, and each wheel
    // gains half of m V^2 d2z/ds2. On a slope a the centre of a wheel is R a^2/2 higher over the rail below it, and the contact
    // of stiffness dN/d delta = 3/2 N / delta gives way to the load.
    let scene = spectrum(", quantities=[\"longitudinal_level\"], shortest=10, longest=100");
    let recording = run(&scene, 5.0, 5e-3);
    let (distance, z) = (column(&recording, "distance"), column(&recording, "z"));
    let forces = ["left", "right"].map(|side| column(&recording, &format!("{side}.verticalForce")));
    let stiffness = 1.5 * column(&recording, "left.normalForce")[0] / column(&recording, "left.contact[1].penetration")[0];
    let (mut off, mut gained, mut missed) = (0.0f64, 0.0f64, 0.0f64);
    for row in 0..z.len() {
        let [level, slope, curvature, _] = rail(&scene, Side::Left, Direction::Vertical, distance[row]);
        let load = 0.5 * 1568.0 * 40.0f64.powi(2) * curvature;
        off = off.max((z[row] - z[0] - level - 0.5 * 0.457 * slope * slope + load / stiffness).abs());
        gained = gained.max(load.abs());
        for force in &forces {
            missed = missed.max((force[row] - force[0] - load).abs());
        }
    }
    println!("height off by {off:.2e} m at most; load up to {gained:.0} N more, off by {missed:.1} N at most");
    assert!(off < 5e-8, "{off}");
    assert!(gained > 500.0 && missed < 2e-3 * gained, "{gained} {missed}");
}

#[test]
fn hard_all_irregularities_of_class_5_keep_both_wheels_loaded() {
    let scene = spectrum("");
    let begin = std::time::Instant::now();
    let recording = run(&scene, 5.0, 5e-3);
    let irregular = begin.elapsed();
    let begin = std::time::Instant::now();
    run(&straight(&[]), 5.0, 5e-3);
    println!("5 s on irregular track in {irregular:?}, on smooth track in {:?}", begin.elapsed());
    for side in ["left", "right"] {
        let force = column(&recording, &format!("{side}.normalForce"));
        let (least, most) = force.iter().fold((f64::MAX, 0.0f64), |(least, most), n| (least.min(*n), most.max(*n)));
        println!("{side}: {least:.0} N to {most:.0} N");
        assert!(least > 0.2 * force[0] && most < 2.0 * force[0] && most > 1.02 * force[0]);
    }
    let y = column(&recording, "y");
    let farthest = y.iter().fold(0.0f64, |most, y| most.max(y.abs()));
    println!("farthest from the centre line: {:.2} mm", 1e3 * farthest);
    assert!(farthest > 1e-3 && farthest < 0.05);
}

/// A series sampled from a random track is that track again, to the error of a spline through points 0.25 m apart.
#[test]
fn equiv_a_series_of_samples_and_the_spectrum_that_they_come_from() {
    let random = spectrum(", shortest=10, longest=100");
    let folder = tempfile::tempdir().unwrap();
    let text = &random.source.text;
    let begin = text.find("irregularity").unwrap();
    let end = begin + text[begin..].find('\n').unwrap();
    let line =
        "irregularity = [{kind=\"series\", file=\"car/measured.csv\", fade=1}, {kind=\"series\", file=\"other/measured.csv\", scale=0}]";
    let text = format!("{}{line}{}", &text[..begin], &text[end..]);
    std::fs::write(folder.path().join("scene.toml"), text).unwrap();
    let rows: String = (0..=2000)
        .map(|i| {
            let s = 100.0 + 0.25 * f64::from(i);
            let at = |side, direction| 1e3 * rail(&random, side, direction, s)[0];
            let (y, z) = (Side::BOTH.map(|side| at(side, Direction::Lateral)), Side::BOTH.map(|side| at(side, Direction::Vertical)));
            format!("{:.5},{},{},{},{}\n", 1e-3 * s, 0.5 * (y[0] + y[1]), 0.5 * (z[0] + z[1]), z[0] - z[1], y[0] - y[1])
        })
        .collect();
    let content = format!("distance [km],alignment [mm],longitudinal_level [mm],cross_level [mm],gauge [mm]\n{rows}");
    for (name, content) in [("car", content), ("other", "distance,gauge\n1,0\n2,0\n3,0\n4,0\n".to_string())] {
        std::fs::create_dir(folder.path().join(name)).unwrap();
        std::fs::write(folder.path().join(name).join("measured.csv"), content).unwrap();
    }
    let measured = load::open_file(&folder.path().join("scene.toml"), "measured", &[]).unwrap();
    // As an FMU carries it: two files of one name, both beside the scene.
    let packed = pack_scene(&measured).unwrap();
    for name in ["irregularities/measured.csv", "irregularities/measured_2.csv"] {
        assert!(packed.resources.contains_key(name), "{:?}", packed.resources.keys());
    }
    let mut worst = 0.0f64;
    for i in 0..5000 {
        let s = 101.5 + 0.0787 * f64::from(i);
        for side in Side::BOTH {
            for direction in [Direction::Lateral, Direction::Vertical] {
                let exact = rail(&random, side, direction, s)[0];
                let found = rail(&measured, side, direction, s);
                worst = worst.max((found[0] - exact).abs());
                assert_eq!(found, rail(&packed.scene, side, direction, s));
            }
        }
    }
    println!("largest difference {worst:.2e} m");
    assert!(worst < 1e-7, "{worst}");
}

#[test]
fn prop_a_random_track_is_the_same_in_an_fmu() {
    let scene = spectrum("");
    let packed = pack_scene(&scene).unwrap().scene;
    for s in [120.0, 333.3, 499.0] {
        assert_eq!(rail(&scene, Side::Left, Direction::Lateral, s), rail(&packed, Side::Left, Direction::Lateral, s));
    }
    start(&packed);
}

#[test]
fn prop_a_deviation_of_both_rails_is_one_of_each() {
    let keys = "direction=\"vertical\", amplitude=\"10 mm\", from=120, to=123";
    let both = straight(&[&format!("track.deviation=[{{rail=\"both\", shape=\"haversine\", {keys}}}]")]);
    let each = ["left", "right"].map(|rail| format!("{{rail=\"{rail}\", shape=\"cosine\", {keys}}}"));
    let each = straight(&[&format!("track.deviation=[{}]", each.join(","))]);
    for side in Side::BOTH {
        let found = rail(&both, side, Direction::Vertical, 121.5);
        assert_eq!(found, rail(&each, side, Direction::Vertical, 121.5));
        assert!((found[0] - 0.01).abs() < 1e-15);
    }
}
