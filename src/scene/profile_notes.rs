//! What reading the profiles of wheels and rails has found.

use super::spec::Scene;
use crate::geometry::Side;
use crate::geometry::profile::ProfileChoice;

/// What was assumed when profiles were read, each once.
pub fn profile_notes(scene: &Scene) -> Vec<String> {
    of_profiles(scene, |choice| choice.notes.clone())
}

/// Where the curvature of profiles is doubtful.
pub fn profile_doubts(scene: &Scene) -> Vec<String> {
    of_profiles(scene, |choice| choice.doubt.iter().cloned().collect())
}

fn of_profiles(scene: &Scene, notes: impl Fn(&ProfileChoice) -> Vec<String>) -> Vec<String> {
    let parts = [("wheel", &scene.vehicle.leading().profiles), ("rail", &scene.track.rails)];
    let mut all = Vec::new();
    for (part, sides) in parts {
        let [left, right] = sides.each_ref().map(&notes);
        let right = if left == right { Vec::new() } else { right };
        for (side, notes) in Side::BOTH.into_iter().zip([left, right]) {
            all.extend(notes.into_iter().map(|note| format!("{} {part} profile: {note}", side.name())));
        }
    }
    all
}
