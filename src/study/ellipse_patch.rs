//! The ellipse that the scene's laws make of the deepest place of a wheel, beside half-space contact of the same surfaces.

use super::contact_geometry::Touch;
use crate::contact::Patch;
use crate::contact::creep::RollingContact;
use crate::contact::creepage::{ContactAxes, CreepForce, in_rolling_direction};
use crate::contact::patch::Motion;
use crate::contact::search::algebraic::{Pair, SurfaceParameters};
use crate::scene::spec::Scene;
use nalgebra::Vector3;

/// What they say.
#[derive(Clone, Copy, Debug)]
pub struct EllipsePatch {
    /// Penetration, m.
    pub penetration: f64,
    /// N.
    pub normal_force: f64,
    pub patch: Patch,
    /// The rigid contact that it was looked for from, and the deepest place on the wheel in the world, m.
    pub touch: Touch,
    pub place: Vector3<f64>,
    pub axes: ContactAxes,
    /// On the wheel, in these axes.
    pub creep: CreepForce,
}

/// Of the place near one that touches, under a vertical `load` [N] or as deep as the pose has it. `None` where the place is not found or its surfaces
/// have no ellipse.
pub fn ellipse_patch(scene: &Scene, pair: &Pair, touch: &Touch, load: Option<f64>, motion: &Motion) -> Option<EllipsePatch> {
    let contact = &scene.contact;
    let start = SurfaceParameters { wheel: touch.wheel, angle: 0.0, lead: touch.lead, rail: touch.rail };
    let found = pair.locate(&start).ok()?;
    let (law, shape) = ((contact.normal)(contact.material), found.shape(pair.wheel, pair.rail));
    let (penetration, elastic) = match load {
        Some(load) => law.contact_under(&shape, load / found.normal.z).ok()?,
        None => (found.penetration, law.contact(&shape, found.penetration).ok()?),
    };
    let normal_force = load.map_or(elastic.force, |load| load / found.normal.z);
    let axes = ContactAxes::new(found.normal, found.forward);
    let velocity = motion.velocity + motion.rotation.cross(&(found.wheel_point - pair.centre));
    let creepage = axes.slip(&velocity, &motion.rotation).creepage(motion.speed);
    let law = (contact.creep)(contact.material);
    let rolling = RollingContact { patch: elastic.patch, normal_force, friction: contact.friction, creepage, speed: motion.speed.abs() };
    let creep = in_rolling_direction(motion.speed, creepage, |creepage| law.force(&RollingContact { creepage, ..rolling }));
    Some(EllipsePatch { touch: *touch, penetration, normal_force, patch: elastic.patch, place: found.wheel_point, axes, creep })
}
