//! Where a force element holds on to a body or to the world.
//!
//! On a body of revolution an attachment sits on a box that the axle spins in and that stays upright on the track ([`Upright`]; on straight
//! level track that is the axle frame `Rz Rx`). The bearing hands no moment about the axle to it; so of a moment M on the box with the part
//! m about the axle, the wheelset gets `M - m (y - g)` and the force m h: the same power at every motion of the box and none at spin, so
//! that the energy bill is exact. What holds the box upright is not modelled: the moment m is missing in the balance of angular momentum.
//! It is zero when the force passes through the axle, so an element between a wheelset and a frame should start at the frame (`from`) and
//! end on the axle's line (`to`), where all forces act.

use crate::geometry::track::upright::Upright;
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::settings::{Section, SettingsError};
use nalgebra::{Matrix3, Vector3};

/// A point of a body, or of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attachment {
    /// `None`: the world.
    pub body: Option<usize>,
    /// In the body's attachment axes (see [`BodyMotion::frame`]) from its centre of mass, or in the world's axes, m.
    pub local: Vector3<f64>,
}

/// Resolves the places that a scene names.
pub trait Places {
    /// Reads the place at `key` (`from`, `to`) of an element's section.
    ///
    /// # Errors
    /// The key is absent or names no place.
    fn attachment(&self, section: &Section, key: &'static str) -> Result<Attachment, SettingsError>;

    /// Reads the body at `key`.
    ///
    /// # Errors
    /// The key is absent or names no body.
    fn body(&self, section: &Section, key: &'static str) -> Result<usize, SettingsError> {
        self.attachment(section, key)?.body.ok_or_else(|| section.error(key, "is no body"))
    }

    /// From one place to another in the design configuration, world axes, m.
    fn design_vector(&self, from: &Attachment, to: &Attachment) -> Vector3<f64>;

    /// The element's name; a place that builds one section several times tells the copies apart here.
    ///
    /// # Errors
    /// The section has no name.
    fn name(&self, section: &Section) -> Result<String, SettingsError> {
        section.text("name")
    }

    /// -1 for the mirrored copy of an element (its places have the opposite y), else 1. Elements that act along a
    /// body's y axis count it in the mirrored direction then, and their lateral preloads too.
    fn mirror(&self) -> f64 {
        1.0
    }
}

impl Attachment {
    /// On a body, at a point in its attachment axes, m.
    pub fn on(body: usize, local: Vector3<f64>) -> Self {
        Attachment { body: Some(body), local }
    }

    /// A fixed point of the world, m.
    pub fn world(local: Vector3<f64>) -> Self {
        Attachment { body: None, local }
    }

    /// World position, m.
    #[inline]
    pub fn point(&self, bodies: &Moving) -> Vector3<f64> {
        let Some(body) = self.body else { return self.local };
        let motion = &bodies[body];
        match upright(bodies, body) {
            Some(upright) => motion.position + upright.axes * self.local,
            None => motion.attachment_point(&self.local),
        }
    }

    /// Velocity at `point` [m, world] of the frame that the attachment sits in, m/s.
    #[inline]
    pub fn velocity(&self, bodies: &Moving, point: &Vector3<f64>) -> Vector3<f64> {
        let Some(body) = self.body else { return Vector3::zeros() };
        bodies[body].velocity + self.rotation(bodies).cross(&(point - bodies[body].position))
    }

    /// Axes of the frame that the attachment sits in.
    #[inline]
    pub fn axes(&self, bodies: &Moving) -> Matrix3<f64> {
        let Some(body) = self.body else { return Matrix3::identity() };
        upright(bodies, body).map_or(bodies[body].frame.axes, |upright| upright.axes)
    }

    /// Angular velocity of these axes, rad/s.
    #[inline]
    pub fn rotation(&self, bodies: &Moving) -> Vector3<f64> {
        let Some(body) = self.body else { return Vector3::zeros() };
        let motion = &bodies[body];
        upright(bodies, body).map_or(motion.frame_rotation, |upright| upright.rotation(&motion.frame_rotation, &motion.velocity))
    }

    /// Loads the body with a force [N] at `point` [m] and a couple [N m], all in world axes.
    #[inline]
    pub fn load(&self, bodies: &Moving, wrenches: &mut [Wrench], force: &Vector3<f64>, point: &Vector3<f64>, couple: &Vector3<f64>) {
        let Some(body) = self.body else { return };
        let motion = &bodies[body];
        let mut wrench = Wrench { force: *force, moment: (point - motion.position).cross(force) + couple };
        if motion.turn.is_none() {
            let frame = &motion.frame;
            let about_axle = frame.axes.column(1).dot(&wrench.moment);
            if let Some(upright) = upright(bodies, body) {
                wrench.moment -= (frame.axes.column(1) - upright.by_rotation) * about_axle;
                wrench.force += upright.by_velocity * about_axle;
            } else {
                wrench.moment -= (frame.axes.column(1) - frame.axes.column(2) * (frame.sin_roll / frame.cos_roll)) * about_axle;
            }
        }
        wrenches[body] += wrench;
    }
}

/// How a body's boxes stand, where it is an axle on a track that is not straight and level.
#[inline]
fn upright<'a>(bodies: &Moving<'a>, body: usize) -> Option<&'a Upright> {
    bodies.station(body)?.upright.as_ref()
}

/// Directions that a scene can name, with their unit vectors; y is mirrored in mirrored copies.
pub(super) fn axes(places: &dyn Places) -> [(&'static str, Vector3<f64>); 6] {
    let [x, y, z] = [Vector3::x(), Vector3::y() * places.mirror(), Vector3::z()];
    [("x", x), ("y", y), ("z", z), ("-x", -x), ("-y", -y), ("-z", -z)]
}

/// The unit vector of `axis = "x" | "y" | "z" | "-x" ...`.
pub(super) fn axis(section: &Section, places: &dyn Places, key: &'static str) -> Result<Vector3<f64>, SettingsError> {
    let all = axes(places);
    let word = section.word(key, &all.map(|(name, _)| name))?;
    Ok(all.iter().find(|(name, _)| *name == word).map_or(all[0].1, |(_, axis)| *axis))
}
