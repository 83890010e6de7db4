//! The track: a centre line, straight along X or a space curve, two rails beside it, and what displaces them.
//!
//! Rail sections stay in planes normal to the centre line; a deviation shifts a section along Y or Z of the track frame without
//! turning it, so the section axes are constant on straight track (Eqs. 5 and 6 with constant A^rp) and follow the track frame
//! elsewhere.

mod bend;
pub mod centre_line;
pub mod components;
mod curved;
mod deviation;
pub mod frame;
pub mod gauge;
pub mod irregularity;
pub mod node;
pub mod rail_surface;
mod ramp;
pub mod station;
#[cfg(test)]
mod tests;
pub mod upright;
pub mod waves;

pub use deviation::{Deviation, DeviationShape, Direction, REGISTRY, parse_deviation};

use super::Side;
use super::profile::Profile;
use centre_line::CentreLine;
use nalgebra::Vector3;
use std::sync::Arc;
use waves::Waves;

/// Where a rail's section stands at some distance, with derivatives along the track.
#[derive(Clone, Copy, Debug)]
pub struct RailSection {
    /// Origin of the section, m.
    pub origin: Vector3<f64>,
    /// First, second and third derivative of the origin with respect to distance.
    pub d1: Vector3<f64>,
    pub d2: Vector3<f64>,
    pub d3: Vector3<f64>,
    /// Unit vectors of the section's axes: eta (outward) and height.
    pub outward: Vector3<f64>,
    pub up: Vector3<f64>,
    /// How fast the axes turn along the track, rad/m: `outward' = turn x outward`.
    pub turn: Vector3<f64>,
}

impl RailSection {
    /// Derivative with respect to distance of the point with section coordinates `eta` and `height` [m].
    #[inline]
    pub fn tangent(&self, eta: f64, height: f64) -> Vector3<f64> {
        if self.is_parallel() { self.d1 } else { self.d1 + self.turn.cross(&(self.outward * eta + self.up * height)) }
    }

    /// Are all sections parallel, as on a straight centre line?
    #[inline]
    pub fn is_parallel(&self) -> bool {
        self.turn == Vector3::zeros()
    }

    /// The section `ahead` [m], continued by the derivatives that are known: off by the origin's fourth one times `ahead^4 / 24`, in
    /// direction by `ahead^3 / 6`. In a curve of radius R the axes are off by `ahead^2 / 2 R^2`, and how fast they turn is kept: a twist that
    /// grows by 1e-4 1/m2 makes 5e-12 rad at 10 mm from the origin over 5 um.
    #[inline]
    pub fn continued(&self, ahead: f64) -> RailSection {
        let half = 0.5 * ahead;
        let turned = |axis: Vector3<f64>| if self.is_parallel() { axis } else { axis + self.turn.cross(&axis) * ahead };
        RailSection {
            outward: turned(self.outward),
            up: turned(self.up),
            origin: self.origin + (self.d1 + (self.d2 + self.d3 * (ahead / 3.0)) * half) * ahead,
            d1: self.d1 + (self.d2 + self.d3 * half) * ahead,
            d2: self.d2 + self.d3 * ahead,
            ..*self
        }
    }
}

/// No distance lies between these.
const NOWHERE: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

/// One rail of the track.
#[derive(Clone, Debug)]
pub struct Rail {
    pub side: Side,
    pub profile: Arc<dyn Profile>,
    /// Unit vector of the section's eta axis (outward), in the track frame.
    pub outward: Vector3<f64>,
    /// Unit vector of the section's height axis (up, leaning toward the track centre), in the track frame.
    pub up: Vector3<f64>,
    /// What the rail follows; `None`: X.
    line: Option<Arc<CentreLine>>,
    /// Y of the undisplaced section origin, m.
    offset: f64,
    deviations: Vec<(Direction, Arc<dyn DeviationShape>)>,
    /// Distances outside which none of them does anything, m.
    deviated: (f64, f64),
    /// Distances where the rail is not smooth, increasing.
    breaks: Vec<f64>,
    /// How short its waves are.
    waves: Waves,
    /// Where it bends sideways sharply.
    sharp: Arc<bend::Sharp>,
}

impl Rail {
    /// Distance of a place of its section from the middle of the track, outward, where nothing displaces it, m.
    pub fn across(&self, eta: f64, height: f64) -> f64 {
        (self.offset + self.outward.y * eta + self.up.y * height) * self.side.sign()
    }

    /// A straight rail whose section origin stands `half_spacing` [m] from the centre line and whose section leans
    /// by `inclination` [rad] toward it.
    pub fn new(side: Side, profile: Arc<dyn Profile>, half_spacing: f64, inclination: f64, deviations: &[Deviation]) -> Self {
        let (sin, cos) = inclination.sin_cos();
        let sign = side.sign();
        // What is zero everywhere is left out: it would only cost.
        let own: Vec<(&Deviation, (f64, f64))> =
            deviations.iter().filter(|d| d.side == side).filter_map(|d| Some((d, d.shape.acts()?))).collect();
        Rail {
            side,
            profile,
            outward: Vector3::new(0.0, sign * cos, sin),
            up: Vector3::new(0.0, -sign * sin, cos),
            line: None,
            offset: sign * half_spacing,
            breaks: {
                let mut breaks: Vec<f64> = own.iter().flat_map(|(d, _)| d.shape.breaks()).collect();
                breaks.sort_by(f64::total_cmp);
                breaks.dedup();
                breaks
            },
            waves: Waves::new(own.iter().flat_map(|(d, _)| d.shape.waves())),
            deviated: own.iter().fold(NOWHERE, |all, (_, acts)| (all.0.min(acts.0), all.1.max(acts.1))),
            deviations: own.iter().map(|(d, _)| (d.direction, d.shape.clone())).collect(),
            sharp: Arc::default(),
        }
    }

    /// The same, straight and with nothing that displaces it.
    pub fn undisturbed(&self) -> Self {
        let Rail { side, profile, outward, up, offset, .. } = self.clone();
        let waves = Waves::new(std::iter::empty());
        let sharp = Arc::default();
        Rail { side, profile, outward, up, offset, line: None, deviations: Vec::new(), deviated: NOWHERE, breaks: Vec::new(), waves, sharp }
    }

    /// The rail laid along a centre line.
    pub fn along(mut self, line: Option<Arc<CentreLine>>) -> Self {
        self.breaks.extend(line.iter().flat_map(|line| line.breaks()));
        self.breaks.sort_by(f64::total_cmp);
        self.breaks.dedup();
        self.waves = self.waves.with(line.iter().flat_map(|line| line.waves()));
        self.line = line;
        self
    }

    /// The same, computed everywhere in full: as if it were not known where deviations do nothing and where the line is straight.
    pub fn in_full(mut self) -> Self {
        if self.deviates() {
            self.deviated = (f64::NEG_INFINITY, f64::INFINITY);
        }
        self.line = self.line.map(|line| Arc::new(line.in_full()));
        self
    }

    /// With further stretches of the track at which a step must look.
    pub fn with_waves(mut self, stretches: impl IntoIterator<Item = waves::Stretch>) -> Self {
        self.waves = self.waves.with(stretches);
        self
    }

    /// Hands over what each deviation does at distance `s` [m]: along which axis (1: Y, 2: Z), displacement and three derivatives.
    #[inline]
    fn deviate(&self, s: f64, mut add: impl FnMut(usize, [f64; 4])) {
        if !(s > self.deviated.0 && s < self.deviated.1) {
            return;
        }
        for (direction, shape) in &self.deviations {
            let axis = match direction {
                Direction::Lateral => 1,
                Direction::Vertical => 2,
            };
            add(axis, shape.at(s));
        }
    }

    /// How finely a step must look at it.
    pub fn waves(&self) -> &Waves {
        &self.waves
    }

    /// Does any deviation move it?
    pub fn deviates(&self) -> bool {
        !self.deviations.is_empty()
    }

    /// Lateral and vertical displacement by deviations at distance `s` [m], m, with three derivatives each.
    #[inline]
    pub fn deviation(&self, s: f64) -> [[f64; 4]; 2] {
        let mut sum = [[0.0; 4]; 2];
        self.deviate(s, |axis, values| sum[axis - 1].iter_mut().zip(values).for_each(|(own, value)| *own += value));
        sum
    }

    /// How far this rail stands to the left of another, both undisturbed, m.
    pub fn spacing(&self, other: &Rail) -> f64 {
        self.offset - other.offset
    }

    /// Is there any place where the rail is not smooth?
    pub fn has_breaks(&self) -> bool {
        !self.breaks.is_empty()
    }

    /// Is there a place within `reach` [m] of `s` where the rail is not smooth?
    pub fn has_break_near(&self, s: f64, reach: f64) -> bool {
        self.breaks.iter().any(|b| (b - s).abs() <= reach)
    }

    /// How far ahead in the direction of travel the next place is where the rail is not smooth, m.
    pub fn distance_to_break(&self, s: f64, speed: f64) -> Option<f64> {
        let direction = speed.signum();
        let ahead = self.breaks.iter().map(|b| (b - s) * direction).filter(|ahead| *ahead > 0.0);
        ahead.reduce(f64::min)
    }

    /// Where the next step must end at the latest when it travels from `s` with `speed`: a micrometre before the next place
    /// where the rail is not smooth, then a micrometre behind it. So every evaluation of a long step sees one side only; the
    /// short step across takes 2 um.
    pub fn next_break(&self, s: f64, speed: f64) -> Option<f64> {
        const EDGE: f64 = 1e-6;
        let direction = speed.signum();
        // A contact that moves on its wheel may miss its aim by a fraction of the edge.
        let aim = |b: f64| {
            let ahead = (b - s) * direction;
            if ahead > 1.5 * EDGE { Some(b - EDGE * direction) } else { (ahead > -0.5 * EDGE).then_some(b + EDGE * direction) }
        };
        if speed > 0.0 {
            self.breaks.iter().copied().find_map(aim)
        } else if speed < 0.0 {
            self.breaks.iter().rev().copied().find_map(aim)
        } else {
            None
        }
    }

    /// The section at distance `s` [m].
    #[inline]
    pub fn section(&self, s: f64) -> RailSection {
        if let Some(line) = self.line_at(s) {
            return self.curved_section(line, s);
        }
        let mut section = RailSection {
            origin: Vector3::new(s, self.offset, 0.0),
            d1: Vector3::x(),
            d2: Vector3::zeros(),
            d3: Vector3::zeros(),
            outward: self.outward,
            up: self.up,
            turn: Vector3::zeros(),
        };
        self.deviate(s, |axis, [value, d1, d2, d3]| {
            section.origin[axis] += value;
            section.d1[axis] += d1;
            section.d2[axis] += d2;
            section.d3[axis] += d3;
        });
        section
    }
}

/// Both rails.
#[derive(Clone, Debug)]
pub struct Track {
    pub left: Rail,
    pub right: Rail,
}

impl Track {
    pub fn rail(&self, side: Side) -> &Rail {
        match side {
            Side::Left => &self.left,
            Side::Right => &self.right,
        }
    }

    /// The centre line; `None` where it is X.
    pub fn line(&self) -> Option<&CentreLine> {
        self.left.line.as_deref()
    }

    /// The same rails without deviations on straight level track.
    pub fn ideal(&self) -> Track {
        let bare = |rail: &Rail| Rail {
            deviations: Vec::new(),
            deviated: NOWHERE,
            breaks: Vec::new(),
            waves: Waves::default(),
            sharp: Arc::default(),
            line: None,
            ..rail.clone()
        };
        Track { left: bare(&self.left), right: bare(&self.right) }
    }
}
