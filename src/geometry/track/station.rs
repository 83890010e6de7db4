//! Where a body is along the track: the track frame at its centre, and how fast that travels.
//!
//! The frame's plane across the track goes through the centre P: `(P - C) . X = 0`. Differentiated, with v the centre's velocity:
//!
//! ```text
//! s' = v . X / (1 - (P - C) . dX/ds)
//! ```

use super::centre_line::CentreLine;
use super::frame::TrackFrame;
use super::upright::Upright;
use nalgebra::{Matrix3, Vector3};

/// The track frame of a moving point.
#[derive(Clone, Copy, Debug, Default)]
pub struct Station {
    pub frame: TrackFrame,
    /// Speed of the point along the frame's X, v . X, m/s.
    pub speed: f64,
    /// Speed of the frame along the centre line, s', m/s: greater than `speed` for a point on the inner side of a curve, by the share
    /// curvature x offset (1e-5 for 5 mm at a radius of 500 m).
    pub travel: f64,
    /// How the boxes of an axle stand there.
    pub upright: Option<Upright>,
    /// See [`TrackFrame::stretch`].
    stretch: f64,
    /// Is the frame that of straight level track, the world's axes? The rest is then not kept.
    on_x: bool,
}

impl Station {
    /// Of a point [m] with this velocity [m/s], from a guess of its distance [m].
    #[inline]
    pub fn new(line: &CentreLine, point: &Vector3<f64>, velocity: &Vector3<f64>, guess: f64) -> Station {
        let frame = line.project(point, guess);
        let speed = velocity.dot(&frame.along());
        let stretch = frame.stretch(&(point - frame.origin));
        Station { frame, speed, travel: speed / stretch, upright: None, stretch, on_x: line.is_x(frame.distance) }
    }

    /// Notes that the point is an axle's, whose frame `Rz Rx` has these axes.
    #[inline]
    pub fn carry_boxes(&mut self, axes: &Matrix3<f64>) {
        self.upright = Upright::new(axes, &self.frame, self.stretch);
    }

    /// d(v . X)/dt when the point does not accelerate: v . dX/ds s', m/s2.
    #[inline]
    pub fn swing_of_speed(&self, velocity: &Vector3<f64>) -> f64 {
        velocity.dot(&self.frame.bend()) * self.travel
    }

    /// Notes that the point is where the line is X.
    #[inline]
    pub fn stay_on_x(&mut self) {
        self.on_x = true;
    }

    /// A vector of the world in the track frame.
    #[inline]
    pub fn components(&self, vector: &Vector3<f64>) -> Vector3<f64> {
        self.frame.components(vector)
    }
}

/// The stations of all bodies on a track with a centre line; none on straight level track.
#[derive(Clone, Debug, Default)]
pub struct Stations(Vec<Station>);

impl Stations {
    /// On no track yet.
    pub const NONE: &Stations = &Stations(Vec::new());

    /// For so many bodies.
    pub fn new(bodies: usize) -> Stations {
        Stations(vec![Station::default(); bodies])
    }

    /// Of a body; `None` where the track is straight and level, so that its frame is the world's.
    #[inline]
    pub fn get(&self, body: usize) -> Option<&Station> {
        self.0.get(body).filter(|station| !station.on_x)
    }

    /// The track's direction beside a body.
    #[inline]
    pub fn along(&self, body: usize) -> Vector3<f64> {
        self.get(body).map_or(Vector3::x(), |station| station.frame.along())
    }

    /// All of them, to be found anew.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Station> {
        self.0.iter_mut()
    }
}
