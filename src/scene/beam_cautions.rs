//! Where rails as beams are too short, or too coarse, for what goes on in them.

use super::spec::Scene;
use crate::formulation::Model;
use crate::formulation::flexibility::Flexibility;

/// What may be left of a wave that has gone round the ring, in parts of its amplitude: a flat's echo then has some 2 % of the static load.
const ECHO: f64 = 0.05;
/// Modes below this lack what blows excite, Hz: flats and joints were 7 to 15 % off with 1000 Hz, by half their dynamic part with 300 Hz, 1 % with 3000 Hz.
const BLOWS: f64 = 2000.0;

pub(super) fn beam_cautions(scene: &Scene, model: &Model) -> Vec<String> {
    let (Some(Flexibility::Beam(beam)), Some(rails)) = (&scene.track.flexibility, &model.beam) else { return Vec::new() };
    let [left, _] = rails.left_of_waves();
    let echo = (left > ECHO).then(|| {
        format!(
            "track.flexibility: pads and rails damp so little that waves come round the ring of {} bays with up to {:.0} % of their amplitude, and meet the wheels again; more bays, or more damping, \
             lets them die out",
            rails.ring.bays(),
            100.0 * left
        )
    });
    let coarse = (beam.highest < BLOWS).then(|| {
        format!(
            "track.flexibility.highest_frequency = {} Hz leaves out what blows excite: loads of flats and joints are off by 10 % at 1000 Hz and by half of what they add at 300 Hz; 3000 Hz \
             (default) has them to 1 %",
            beam.highest
        )
    });
    echo.into_iter().chain(coarse).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{assemble, load};

    #[test]
    fn prop_short_rings_and_few_modes_are_told() {
        let cautions = |keys: &str| {
            let scene = load::open("wheelset_s1002", &[format!("track.flexibility={{model=\"beam\"{keys}}}")]).unwrap();
            let model = assemble::model(&scene).unwrap();
            (beam_cautions(&scene, &model), model.beam.unwrap().ring.bays())
        };
        let (none, usual) = cautions("");
        let (soft_none, soft) = cautions(", pad_stiffness=60e6, pad_damping=6e3");
        assert!(none.is_empty() && soft_none.is_empty() && usual < 60 && soft > 100, "{none:?} {soft_none:?} {usual} {soft}");
        assert!(cautions(", pad_stiffness=60e6, pad_damping=6e3, bays=40").0[0].contains("18 %"));
        assert!(cautions(", pad_damping=0, ballast_damping=0").0[0].contains("ring of 250 bays"));
        assert!(cautions(", highest_frequency=1000").0[0].contains("leaves out what blows excite"));
    }
}
