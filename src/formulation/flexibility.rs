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

    /// The mean of the track along it, under wheelsets at these places [m] at this speed [m/s].
    pub fn mean(self, places: &[f64], speed: f64) -> Self {
        match self {
            Flexibility::Travelling(_) => self,
            Flexibility::Beam(beam) => Flexibility::Travelling(beam.lay(places, speed).stand_in),
        }
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
