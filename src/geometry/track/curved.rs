//! Rails along a centre line that is not straight.
//!
//! A point of a rail's section is `w(s) = (0, offset + lateral(s), vertical(s)) + eta outward + f(eta) up` in the track frame; the
//! frame carries it along ([`super::frame`]), so all derivatives are exact.

use super::centre_line::CentreLine;
use super::frame::Jet;
use super::{Rail, RailSection};
use crate::geometry::profile::ProfilePoint;
use crate::geometry::surface::{SurfacePoint, ThirdDerivatives};
use nalgebra::Vector3;
use std::sync::Arc;

impl Rail {
    /// What the rail follows; `None`: X.
    #[inline]
    pub fn line(&self) -> Option<&CentreLine> {
        self.line.as_deref()
    }

    /// The same, to be kept.
    pub fn shared_line(&self) -> Option<Arc<CentreLine>> {
        self.line.clone()
    }

    /// What the rail follows at distance `s` [m] where that is not X.
    #[inline]
    pub(in super::super) fn line_at(&self, s: f64) -> Option<&CentreLine> {
        self.line().filter(|line| !line.is_x(s))
    }

    /// The section's origin in the track frame with three derivatives along s.
    #[inline]
    fn displacement(&self, s: f64) -> Jet {
        let mut w = [Vector3::new(0.0, self.offset, 0.0), Vector3::zeros(), Vector3::zeros(), Vector3::zeros()];
        self.deviate(s, |axis, values| w.iter_mut().zip(values).for_each(|(w, value)| w[axis] += value));
        w
    }

    #[inline(never)]
    pub(super) fn curved_section(&self, line: &CentreLine, s: f64) -> RailSection {
        let (frame, w) = (line.frame(s), self.displacement(s));
        let [origin, d1, d2] = frame.carry(&w);
        let [outward, up, turn] = [self.outward, self.up, frame.turn].map(|own| frame.axes * own);
        RailSection { origin, d1, d2, d3: frame.carry3(&w), outward, up, turn }
    }

    #[inline(never)]
    pub(in super::super) fn curved_point(&self, line: &CentreLine, s: f64, eta: f64, f: &ProfilePoint) -> SurfacePoint {
        let (frame, mut w) = (line.frame(s), self.displacement(s));
        w[0] += self.outward * eta + self.up * f.value;
        let [position, t1, t11] = frame.carry(&w);
        let across = self.outward + self.up * f.d1;
        SurfacePoint { position, t1, t2: frame.axes * across, t11, t12: frame.swing(&across), t22: frame.axes * (self.up * f.d2) }
    }

    #[inline(never)]
    pub(in super::super) fn curved_third_derivatives(&self, line: &CentreLine, s: f64, eta: f64, f: &ProfilePoint) -> ThirdDerivatives {
        let (frame, mut w) = (line.frame(s), self.displacement(s));
        w[0] += self.outward * eta + self.up * f.value;
        ThirdDerivatives {
            t111: frame.carry3(&w),
            t112: frame.swing2(&(self.outward + self.up * f.d1)),
            t122: frame.swing(&(self.up * f.d2)),
            t222: frame.axes * (self.up * f.d3),
        }
    }
}
