//! Where a scene asks for more than its model means: rigid rails that are too rough for the speed, measured points that are not smooth,
//! explicit methods at low speed, slips of units.

use super::improbable::improbable;
use super::rough_track::{SPACING, places_ahead};
use super::spec::Scene;
use crate::formulation::Model;
use crate::geometry::Side;
use crate::geometry::profile::{Part, Profile};

/// All of them.
pub(super) fn cautions(scene: &Scene, model: &Model) -> Vec<String> {
    improbable(scene, model)
        .into_iter()
        .chain(scattered_points(scene))
        .chain(slow_and_explicit(scene))
        .chain(lasting_displacement(scene, model))
        .chain(scene.track.doubts.iter().cloned())
        .collect()
}

/// Length over which the rails' displacements are averaged, m: longer than any vehicle's own base.
const BASE: f64 = 40.0;
/// What of that goes without a word, m: a primary spring of 1 kN/mm takes 2 % of a wheel's load from it.
const LASTING: f64 = 1e-3;

/// Where a body is cut away (`vehicle.detail`) its guide keeps the height and the roll of ideal track. Rails that stay higher, lower or twisted strain what hangs on it, as the body,
/// which would follow, does not.
fn lasting_displacement(scene: &Scene, model: &Model) -> Option<String> {
    let guides = &scene.vehicle.away()?.guides;
    if guides.is_empty() {
        return None;
    }
    let heights = |place: f64| Side::BOTH.map(|side| model.track.rail(side).deviation(place)[1][0]);
    let of = |window: &[[f64; 2]]| {
        let mean = [0, 1].map(|side| window.iter().map(|heights| heights[side]).sum::<f64>() / window.len() as f64);
        mean.iter().fold(0.0, |most: f64, height| most.max(height.abs()))
    };
    let (all, window): (Vec<[f64; 2]>, usize) = (places_ahead(scene).map(heights).collect(), (BASE / SPACING) as usize);
    let lasting = all.windows(window.min(all.len()).max(1)).step_by(window / 8).map(of).fold(0.0, f64::max);
    (lasting > LASTING).then(|| {
        format!(
            "a rail stays {:.1} mm beside its ideal height over {BASE:.0} m, and {} is cut away by vehicle.detail: it keeps its height and roll where it would follow the rails, so that \
             wheel loads change by its springs' stiffness times that; a fuller vehicle.detail is right there",
            1e3 * lasting,
            guides[0]
        )
    })
}

/// Scatter of the curvature that smooth profiles do not have, 1/m: treads and heads have 0 to 13, but from one point to the next they
/// change by less than 0.1 nearly everywhere.
const SCATTER: f64 = 2.0;
/// Part of a profile that is looked at, m, and the spacing of readings.
const TREAD: f64 = 25e-3;
const READINGS: usize = 200;

/// The median change of curvature between readings 0.25 mm apart tells noise from the joints of a drawing.
fn scattered_points(scene: &Scene) -> Vec<String> {
    let scatter = |profile: &dyn Profile| {
        let at = |i: usize| profile.at(TREAD * (2.0 * i as f64 / READINGS as f64 - 1.0)).d2;
        let mut changes: Vec<f64> = (1..=READINGS).map(|i| (at(i) - at(i - 1)).abs()).collect();
        changes.sort_by(f64::total_cmp);
        changes[changes.len() / 2]
    };
    let sides = [(Part::Wheel, &scene.vehicle.leading().profiles), (Part::Rail, &scene.track.rails)];
    let mut found = Vec::new();
    for (part, choices) in sides {
        let worst = choices.iter().map(|choice| scatter(choice.profile.as_ref())).fold(0.0, f64::max);
        if worst > SCATTER {
            let name = if part == Part::Wheel { "wheel" } else { "rail" };
            found.push(format!(
                "the curvature of the {name} profile scatters by {worst:.0} 1/m from 0.25 mm to the next: its points are not smooth, contacts jump between \
                 them and an evaluation costs several times as much. smoothing = \"0.01 mm\" (or the accuracy of the measurement) takes the noise out"
            ));
        }
    }
    found
}

/// Below this speed [m/s] creep forces settle faster than explicit steps can follow cheaply.
const SLOW: f64 = 5.0;

/// Creepage is slip over speed: a wheelset's creep forces settle at the rate c11 G a b / (m V), 5000 1/s at 5 m/s and 25 000 at 1 m/s.
fn slow_and_explicit(scene: &Scene) -> Option<String> {
    let explicit = !scene.solver.integrator.linearises();
    let (speed, transient) = (scene.vehicle.speed, scene.contact.transient.is_some());
    (explicit && speed.abs() < SLOW && !transient).then(|| {
        format!(
            "at {speed} m/s creep forces settle in some 0.0002 s V / (5 m/s), and {} must follow that in every step: \
             solver.integrator = \"rosenbrock\" or \"auto\" takes steps a hundred times as long",
            scene.solver.name
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{assemble, load};

    fn of(scene: &str, changes: &[&str]) -> Vec<String> {
        let changes: Vec<String> = changes.iter().map(|change| change.to_string()).collect();
        let scene = load::open(scene, &changes).unwrap_or_else(|error| panic!("{error}"));
        cautions(&scene, &assemble::model(&scene).unwrap())
    }

    #[test]
    fn prop_rough_rails_are_named_and_smooth_ones_are_not() {
        let rough = |spectrum: &str, speed: &str| {
            let irregularity = format!("track.irregularity=[{{kind=\"spectrum\",spectrum=\"{spectrum}\",seed=1,from=60,to=375,fade=3}}]");
            of("bogie", &["track.deviation=[]", &irregularity, &format!("vehicle.speed={speed}")])
        };
        let found = rough("fra4", "50");
        assert!(found.len() == 1 && found[0].contains("rigid rails"), "{found:?}");
        // At 5 m/s it is not even reached.
        let (smooth, slow) = (rough("ore_b176_low", "50"), rough("fra4", "5"));
        assert!(smooth.is_empty() && slow.len() == 1 && slow[0].contains("acts nowhere where the vehicle goes"), "{smooth:?} {slow:?}");
    }

    #[test]
    fn prop_noisy_points_are_named_and_smoothed_ones_and_drawings_are_not() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/profiles/rail_60e1.ban");
        let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/scenes/apta_flange.toml"));
        let with = |rail: &str| {
            let scene = load::open_file(path, "apta_flange", &[format!("track.rail={rail}"), "solver.integrator=auto".into()]).unwrap();
            cautions(&scene, &assemble::model(&scene).unwrap())
        };
        let noisy = with(&format!("{{kind=\"miniprof\",file=\"{file}\"}}"));
        assert!(
            noisy.len() == 2 && noisy[0].contains("swings") && noisy[1].contains("curvature of the rail profile scatters"),
            "{noisy:?}"
        );
        let smooth = with(&format!("{{kind=\"miniprof\",file=\"{file}\",smoothing=\"0.02 mm\"}}"));
        assert!(smooth.is_empty() && with("{kind=\"60e1\"}").is_empty(), "{smooth:?}");
    }

    #[test]
    fn prop_rails_that_stay_displaced_are_named_where_bodies_are_cut_away() {
        let ramp = |to: &str| {
            format!("track.deviation=[{{rail=\"left\",direction=\"vertical\",shape=\"ramp\",amplitude=\"{to}\",from=10,to=20}}]")
        };
        let with =
            |detail: &str, deviation: &str| of("vehicle_manchester_1", &[&format!("vehicle.detail={detail}"), deviation, "run.stop=6"]);
        let found = with("wheelset", &ramp("20 mm"));
        assert!(found.len() == 1 && found[0].contains("a rail stays 20.0 mm") && found[0].contains("truck[1].frame"), "{found:?}");
        let bump = "track.deviation=[{rail=\"left\",direction=\"vertical\",shape=\"cosine\",amplitude=\"5 mm\",from=10,to=12},{rail=\"left\",direction=\"vertical\",shape=\"cosine\",amplitude=\"-5 mm\",from=12,to=14}]";
        assert!(with("vehicle", &ramp("20 mm")).is_empty() && with("wheelset", bump).is_empty());
    }

    #[test]
    fn prop_what_the_vehicle_never_meets_and_what_is_there_twice_are_named() {
        let with = |changes: &[&str]| of("suspended_wheelset", &[&["vehicle.speed=20", "run.stop=2"][..], changes].concat());
        let named = |changes: &[&str], words: &str| {
            let found = with(changes);
            assert!(found.len() == 1 && found[0].contains(words), "{changes:?}: {found:?}");
        };
        let plain = "track.deviation=[]";
        named(&[plain, "contact.friction_along=[{factors=[[0,1.0],[2000,0.5]],transition=2}]"], "friction changes nowhere");
        named(&[plain, "track.node=[{distance=0},{distance=900},{distance=950,radius=500}]"], "it changes from 900 m on");
        let bump = "{rail=\"left\",direction=\"vertical\",shape=\"cosine\",amplitude=\"1 mm\",from=10,to=12}";
        named(&[&format!("track.deviation=[{bump},{bump}]")], "acts twice on the left rail");
        named(&[plain, "track.inclination=\"1:4\""], "lean inward by 1:4.0");
        let met = [
            "contact.friction_along=[{factors=[[0,1.0],[20,0.5]],transition=2}]",
            "track.node=[{distance=0},{distance=30},{distance=60,radius=900}]",
        ];
        assert_eq!(with(&[plain, met[0], met[1], &format!("track.deviation=[{bump}]")]), Vec::<String>::new());
    }

    #[test]
    fn prop_flanges_without_play_and_hollows_in_which_they_stand_twice_are_named() {
        let with = |changes: &[&str]| {
            of(
                "bogie",
                &[&["track.deviation=[]", "track.rail={kind=\"60e1\"}", "vehicle.wheel_profile={kind=\"s1002\",radius=0.46}"][..], changes]
                    .concat(),
            )
        };
        let pocket = |amplitude: &str| {
            format!("track.deviation=[{{rail=\"right\",direction=\"lateral\",shape=\"cosine\",amplitude=\"{amplitude}\",from=3,to=3.3}}]")
        };
        assert_eq!(with(&["track.gauge=1.435"]), Vec::<String>::new());
        let narrow = with(&["track.gauge=1.425"]);
        assert!(narrow.iter().any(|words| words.contains("of play between flange and rail")), "{narrow:?}");
        assert!(with(&["track.gauge=1.435", &pocket("-6 mm")]).iter().any(|words| words.contains("two places along the track")));
        assert_eq!(with(&["track.gauge=1.435", &pocket("-1 mm")]), Vec::<String>::new());
    }

    #[test]
    fn prop_speeds_imposed_on_several_wheelsets_are_named_in_curves() {
        let curve = "track.node=[{distance=0},{distance=30},{distance=70,radius=250},{distance=300,radius=250}]";
        let with = |drive: &str, stop: &str| {
            of("vehicle_manchester_1", &["track.deviation=[]", curve, &format!("vehicle.drive={drive}"), &format!("run.stop={stop}")])
        };
        let found = with("all", "20");
        // 19 m between the leading wheelsets of both trucks: 19^3 / (24 250^2) m.
        assert!(found.len() == 1 && found[0].contains("4.6 mm more"), "{found:?}");
        assert!(with("leading", "20").is_empty() && !with("all", "0.2").iter().any(|words| words.contains("mm more")));
    }

    #[test]
    fn prop_explicit_methods_are_named_where_they_are_slow() {
        let at = |speed: &str| {
            of("suspended_wheelset", &["track.deviation=[]", "solver.integrator=dormand_prince", &format!("vehicle.speed={speed}")])
        };
        assert!(at("2").len() == 1 && at("20").is_empty());
    }
}
