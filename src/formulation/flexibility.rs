//! How a track gives way, as a scene says it: `flexibility` of `[track]`.

use super::rail_beam::RailBeam;
use super::travelling_track::{Support, TravellingTrack};
use crate::settings::{Section, SettingsError};

/// Models by the word that lays them, coarser first.
pub const TRAVELLING: &str = "travelling";
pub const BEAM: &str = "beam";
const MODELS: [&str; 2] = [TRAVELLING, BEAM];

/// A track that gives way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flexibility {
    Travelling(TravellingTrack),
    Beam(RailBeam),
}

impl Flexibility {
    /// Reads `flexibility` of `[track]`: a model's word, or a table with that word as its `model` and numbers that differ from the default; `None` where it is absent.
    ///
    /// # Errors
    /// [`SettingsError`] with file and line.
    pub fn parse(track: &Section) -> Result<Option<Self>, SettingsError> {
        if !track.has("flexibility") {
            return Ok(None);
        }
        if !track.has_table("flexibility") {
            let word = track.word("flexibility", &MODELS)?;
            return Ok(Some(if word == BEAM { Self::Beam(RailBeam::default()) } else { Self::Travelling(TravellingTrack::default()) }));
        }
        let section = track.section("flexibility")?;
        let read = match section.word("model", &MODELS)? {
            BEAM => Self::Beam(RailBeam::read(&section)?),
            _ => Self::Travelling(TravellingTrack::read(&section)?),
        };
        section.finish()?;
        Ok(Some(read))
    }

    /// What stands for it in small motions, where nothing goes over sleepers, of wheels with an unsprung mass [kg] each that stand at these places [m] and run at this speed [m/s]; and
    /// where that is not the track itself, its words.
    pub fn in_modes(self, places: &[f64], speed: f64, unsprung: f64) -> (Self, Option<String>) {
        let Flexibility::Beam(beam) = self else { return (self, None) };
        let (track, frequency) = beam.stand_in(places, speed, unsprung);
        let words = format!(
            "the beam's answer at {frequency:.1} Hz, where a wheelset swings on it: {:.0} kg on {:.1} MN/m and {:.1} kN s/m under each wheel (a swing of that mass against the wheel is none of \
             the track; waves, and what wheels feel of each other, are left out)",
            track.vertical.mass,
            1e-6 * track.vertical.stiffness,
            1e-3 * track.vertical.damping
        );
        (Flexibility::Travelling(track), Some(words))
    }

    /// What carries a wheel laterally, in both models.
    pub fn lateral_mut(&mut self) -> &mut Support {
        match self {
            Flexibility::Travelling(track) => &mut track.lateral,
            Flexibility::Beam(beam) => &mut beam.lateral,
        }
    }

    /// The mass that travels vertically; `None` where there is none.
    pub fn vertical_mut(&mut self) -> Option<&mut Support> {
        if let Flexibility::Travelling(track) = self { Some(&mut track.vertical) } else { None }
    }
}
