//! Bodies in motion on their track, and what acts on a force element from outside.

use super::body::BodyMotion;
use crate::geometry::track::station::{Station, Stations};
use std::ops::Index;

/// The motions of all bodies and where they are along a curved track; no stations on straight level track, whose frame is the world's. Beside
/// them the inputs of the one force element that looks at them.
#[derive(Clone, Copy, Debug)]
pub struct Moving<'a> {
    pub motions: &'a [BodyMotion],
    pub stations: &'a Stations,
    pub inputs: &'a [f64],
}

impl<'a> Moving<'a> {
    /// An input of the element, SI; 0 where nobody sets it.
    #[inline]
    pub fn input(&self, index: usize) -> f64 {
        self.inputs.get(index).copied().unwrap_or(0.0)
    }

    /// The track beside a body; `None`: straight and level.
    #[inline]
    pub fn station(&self, body: usize) -> Option<&'a Station> {
        self.stations.get(body)
    }
}

impl<'a> From<&'a [BodyMotion]> for Moving<'a> {
    /// On straight level track.
    fn from(motions: &'a [BodyMotion]) -> Self {
        Moving { motions, stations: Stations::NONE, inputs: &[] }
    }
}

impl Index<usize> for Moving<'_> {
    type Output = BodyMotion;

    #[inline]
    fn index(&self, body: usize) -> &BodyMotion {
        &self.motions[body]
    }
}
