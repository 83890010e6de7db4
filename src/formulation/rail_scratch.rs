//! Scratch of rails that are beams (`beam_rails`).

use super::rail_beam::LaidRails;

/// What wheels feel of their rails, found by each evaluation.
#[derive(Clone, Debug, Default)]
pub struct RailScratch {
    /// phi and its slope, by wheelset.
    pub(super) shapes: Vec<f64>,
    pub(super) slopes: Vec<f64>,
    /// u_z [m], w [m/s] and u_s [-] by contact.
    pub(super) under: Vec<[f64; 3]>,
    /// Shape of what modes leave out, and its slope, by wheelset.
    pub(super) local: Vec<[f64; 2]>,
}

impl RailScratch {
    pub(super) fn new(beam: Option<&LaidRails>) -> RailScratch {
        let Some(beam) = beam else { return RailScratch::default() };
        let (count, modes) = (beam.seats.len(), beam.ring.modes());
        RailScratch {
            shapes: vec![0.0; count * modes],
            slopes: vec![0.0; count * modes],
            under: vec![[0.0; 3]; 2 * count],
            local: vec![[1.0, 0.0]; count],
        }
    }

    pub(super) fn shape(&self, wheelset: usize, modes: usize) -> &[f64] {
        &self.shapes[wheelset * modes..(wheelset + 1) * modes]
    }

    pub(super) fn slope(&self, wheelset: usize, modes: usize) -> &[f64] {
        &self.slopes[wheelset * modes..(wheelset + 1) * modes]
    }
}
