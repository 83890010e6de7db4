//! Bodies in motion on their track.

use super::body::BodyMotion;
use crate::geometry::track::station::Station;
use std::ops::Index;

/// The motions of all bodies and where they are along a curved track; no stations on straight level track, whose frame is the world's.
#[derive(Clone, Copy, Debug)]
pub struct Moving<'a> {
    pub motions: &'a [BodyMotion],
    pub stations: &'a [Station],
}

impl<'a> Moving<'a> {
    /// The track beside a body; `None`: straight and level.
    #[inline]
    pub fn station(&self, body: usize) -> Option<&'a Station> {
        self.stations.get(body)
    }
}

impl<'a> From<&'a [BodyMotion]> for Moving<'a> {
    /// On straight level track.
    fn from(motions: &'a [BodyMotion]) -> Self {
        Moving { motions, stations: &[] }
    }
}

impl Index<usize> for Moving<'_> {
    type Output = BodyMotion;

    #[inline]
    fn index(&self, body: usize) -> &BodyMotion {
        &self.motions[body]
    }
}
