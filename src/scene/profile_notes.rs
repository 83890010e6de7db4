//! What reading the profiles of wheels and rails has found.

use super::gauge_fit::misfit;
use super::spec::Scene;
use crate::geometry::Side;
use crate::geometry::profile::ProfileChoice;

/// What was assumed when profiles were read, each once.
pub fn profile_notes(scene: &Scene) -> Vec<String> {
    of_profiles(scene, |choice| choice.notes.clone())
}

/// Radii of wheels from trolleys to steam locomotives, m.
pub(super) const RADII: [f64; 2] = [0.1, 1.2];

/// Of a wheel at its tread circle, m.
pub(super) fn radius(wheel: &ProfileChoice) -> f64 {
    wheel.profile.at(0.0).value
}

/// Where profiles are doubtful: points of their files, radii, how they stand on each other.
pub fn profile_doubts(scene: &Scene) -> Vec<String> {
    let wheels = scene
        .vehicle
        .wheelsets
        .iter()
        .flat_map(|wheelset| wheelset.spec.profiles.iter().map(|choice| (&wheelset.spec.name, radius(choice))));
    let odd = wheels.filter(|(_, radius)| !(RADII[0]..=RADII[1]).contains(radius)).take(1).map(|(name, radius)| {
        let [least, most] = RADII;
        format!("wheels of {name} have a radius of {radius} m; those of railways have {least} to {most} m: was another unit meant?")
    });
    odd.chain(of_profiles(scene, |choice| choice.doubt.iter().cloned().collect())).chain(unlike_rails(scene)).chain(misfit(scene)).collect()
}

/// Tops, and gauge faces about the track's centre, of which one rail's is so much off the other's are worth a note, m.
const UNLIKE: f64 = 0.5e-3;

/// Rails whose sections stand differently about their origins: worn on one side, or measured from unlike datums.
fn unlike_rails(scene: &Scene) -> Option<String> {
    let track = &scene.track;
    let (sin, cos) = track.inclination.sin_cos();
    let top = |choice: &ProfileChoice| {
        let (first, last) = choice.profile.range();
        let at = |k: u32| first + (last - first) * f64::from(k) / f64::from(LOOKS);
        (0..=LOOKS).map(|k| at(k) * sin + choice.profile.at(at(k)).value * cos).fold(f64::NEG_INFINITY, f64::max)
    };
    let [left, right] = track.rails.each_ref().map(top);
    // Faces stand half a distance of sections, less their reach, from the centre.
    let aside = match track.reaches() {
        [Some(left), Some(right)] => 0.5 * (right - left),
        _ => 0.0,
    };
    let mut found = Vec::new();
    if (left - right).abs() > UNLIKE {
        found.push(format!("the {} rail's top is {:.2} mm lower", if left < right { "left" } else { "right" }, 1e3 * (left - right).abs()));
    }
    if aside.abs() > UNLIKE {
        let way = if aside > 0.0 { "left" } else { "right" };
        found.push(format!("the middle between the gauge faces is {:.2} mm to the {way} of the track's centre", 1e3 * aside.abs()));
    }
    (!found.is_empty()).then(|| {
        format!(
            "{}: sections stand with their origins as far left as right of the centre, and as high. Where it is not wear but the files' datums that differ, align them with shift_z and shift_y of one rail",
            found.join(", and ")
        )
    })
}

/// Places on a section.
const LOOKS: u32 = 2000;

/// Of every wheelset and of the rails, each text of a wheelset once.
fn of_profiles(scene: &Scene, notes: impl Fn(&ProfileChoice) -> Vec<String>) -> Vec<String> {
    let both = |sides: &[ProfileChoice; 2], of: &str| {
        let [left, right] = sides.each_ref().map(&notes);
        let right = if left == right { Vec::new() } else { right };
        let sides = Side::BOTH.into_iter().zip([left, right]);
        sides
            .flat_map(|(side, notes)| notes.into_iter().map(move |note| (side, note)))
            .map(|(side, note)| format!("{} {of} profile: {note}", side.name()))
            .collect::<Vec<_>>()
    };
    let mut all: Vec<String> = Vec::new();
    for (index, wheelset) in scene.vehicle.wheelsets.iter().enumerate() {
        let fresh: Vec<String> =
            both(&wheelset.spec.profiles, "wheel").into_iter().filter(|text| !all.iter().any(|before| before.ends_with(text))).collect();
        all.extend(fresh.into_iter().map(|text| if index == 0 { text } else { format!("{}, {text}", wheelset.spec.name) }));
    }
    all.extend(both(&scene.track.rails, "rail"));
    all
}
