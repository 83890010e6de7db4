//! How wheelsets fit between the rails: running circles above the heads, flanges with play.

use super::spec::Scene;
use crate::geometry::profile::ProfileChoice;

/// What does not.
pub(super) fn misfit(scene: &Scene) -> Option<String> {
    beside_the_rails(scene).or_else(|| without_play(scene))
}

/// The running circle lies between these distances outside of the gauge line, m: 29 to 40 mm on usual wheels.
const OUTSIDE: [f64; 2] = [0.01, 0.08];
/// Sections have their origins in the middle of the head, or somewhere: above it a running circle needs no gauge line, m.
const BESIDE_ORIGIN: f64 = 0.02;

/// Running circles that are not above the rails' heads: a gauge for a distance of running circles, or the other way round.
fn beside_the_rails(scene: &Scene) -> Option<String> {
    let gauge = scene.track.gauge()?;
    scene.vehicle.wheelsets.iter().find_map(|wheelset| {
        let distance = 2.0 * wheelset.spec.half_tread_circle_distance;
        let outside = 0.5 * (distance - gauge);
        let beside = (wheelset.spec.half_tread_circle_distance - scene.track.half_rail_distance).abs();
        (beside > BESIDE_ORIGIN && !(OUTSIDE[0]..=OUTSIDE[1]).contains(&outside)).then(|| {
            format!(
                "{}: running circles {distance} m apart on a gauge of {gauge:.4} m: they lie {:.0} mm outside of each gauge line, where 30 to 40 mm are usual; tread_circle_distance is that \
                 of the running circles (1.5 m on 1.435 m), track.gauge that between the rails",
                wheelset.spec.name,
                1e3 * outside
            )
        })
    })
}

/// Where the thickness of a flange is measured below the tread circle, m, and the play between it and its rail that is not doubtful, m: 4 to 10 mm are usual, more on worn rails and wheels.
const FLANGE_AT: f64 = 10e-3;
const LEAST_PLAY: f64 = 1e-3;
const MOST_PLAY: f64 = 15e-3;
/// Steps of a profile in which that place is looked for.
const STEPS: u32 = 2000;

/// Flanges that stand at their rails in the middle of the track already, and those that never come to them.
fn without_play(scene: &Scene) -> Option<String> {
    let face = |choice: &ProfileChoice| {
        let (first, _) = choice.profile.range();
        let radius = choice.profile.at(0.0).value;
        let at = |step: u32| first * f64::from(step) / f64::from(STEPS);
        let flange = (0..=STEPS).map(at).find(|u| choice.profile.at(*u).value > radius + FLANGE_AT)?;
        Some(-flange)
    };
    let gauge = scene.track.gauge()?;
    scene.vehicle.wheelsets.iter().find_map(|wheelset| {
        let [left, right] = wheelset.spec.profiles.each_ref().map(face);
        let play = 0.5 * (gauge - 2.0 * wheelset.spec.half_tread_circle_distance + left? + right?);
        (!(LEAST_PLAY..=MOST_PLAY).contains(&play)).then(|| {
            format!(
                "{}: {:.1} mm of play between flange and rail on each side in the middle of the track, where 4 to 10 mm are usual: see track.gauge and tread_circle_distance",
                wheelset.spec.name,
                1e3 * play
            )
        })
    })
}
