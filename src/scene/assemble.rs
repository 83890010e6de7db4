//! From scene data to a model: only what the scene calls for becomes an object.

use super::spec::{Scene, SuspensionSpec};
use crate::contact::transient::TransientContact;
use crate::formulation::{AssemblyError, ContactLaws, Model, Parts, Wheelset};
use crate::geometry::Side;
use crate::geometry::surface::Wheel;
use crate::geometry::track::{Rail, Track};
use crate::mbs::body::Body;
use crate::mbs::force::{ForceElement, Gravity, GuidedSpring, TrackAxis, VerticalLoad};
use crate::mbs::inertia::Inertia;
use crate::mbs::system::{DrivingConstraint, System};

/// Assembles the model of a scene.
///
/// # Errors
/// [`AssemblyError`] when the formulation can't treat the scene.
pub fn model(scene: &Scene) -> Result<Model, AssemblyError> {
    let spec = &scene.vehicle.wheelset;
    let inertia = Inertia::Revolution { transverse: spec.transverse_inertia, axial: spec.axial_inertia };
    let body = Body { name: spec.name.clone(), mass: spec.mass, inertia };
    let mut forces: Vec<Box<dyn ForceElement>> = Vec::new();
    if scene.vehicle.gravity != 0.0 {
        forces.push(Box::new(Gravity { body: 0, mass: spec.mass, acceleration: scene.vehicle.gravity, grade: scene.track.grade }));
    }
    if spec.vertical_load != 0.0 {
        forces.push(Box::new(VerticalLoad { body: 0, force: spec.vertical_load }));
    }
    if let Some(suspension) = &scene.vehicle.suspension {
        forces.extend(springs(suspension).map(|spring| Box::new(spring) as Box<dyn ForceElement>));
    }
    let wheel =
        |side: Side| Wheel { side, profile: spec.profiles[side.index()].profile.clone(), half_spacing: spec.half_tread_circle_distance };
    let track = &scene.track;
    let rail = |side: Side| {
        let profile = track.rails[side.index()].profile.clone();
        Rail::new(side, profile, track.half_rail_distance, track.inclination, &track.deviations).along(track.line.clone())
    };
    let imposed_speed = scene.vehicle.speed_imposed.then_some(scene.vehicle.speed);
    let contact = &scene.contact;
    let creep = (contact.creep)(contact.material);
    let transient = contact.transient.map(|settings| TransientContact::new(settings, contact.material, creep.as_ref()));
    let parts = Parts {
        system: System {
            bodies: vec![body],
            forces,
            drives: imposed_speed.map(|speed| DrivingConstraint { body: 0, speed }).into_iter().collect(),
            joints: Vec::new(),
            redundant: Vec::new(),
        },
        track: Track { left: rail(Side::Left), right: rail(Side::Right) },
        wheelsets: vec![Wheelset {
            name: spec.name.clone(),
            body: 0,
            left: wheel(Side::Left),
            right: wheel(Side::Right),
            imposed_speed,
            static_wheel_load: 0.5 * (spec.mass * scene.vehicle.gravity * track.grade.cos() + spec.vertical_load),
        }],
        laws: ContactLaws {
            normal: (contact.normal)(contact.material),
            creep,
            damping: (contact.damping_law.build)(contact.damping),
            friction: contact.friction,
            transient,
        },
        points: contact.points,
    };
    Model::new(parts, &contact.formulation)
}

/// The suspension's elements; a direction that the scene does not call for has none.
fn springs(spec: &SuspensionSpec) -> impl Iterator<Item = GuidedSpring> + '_ {
    let directions = [
        (spec.longitudinal, "longitudinal", TrackAxis::Longitudinal, spec.longitudinal_stiffness, spec.longitudinal_damping),
        (spec.lateral, "lateral", TrackAxis::Lateral, spec.lateral_stiffness, spec.lateral_damping),
    ];
    let numbered = (0..).zip(directions).filter(|(_, direction)| direction.0);
    numbered.flat_map(|(row, (_, direction, axis, stiffness, damping))| {
        (0..).zip(Side::BOTH).zip(spec.attachments()).map(move |((column, side), attachment)| GuidedSpring {
            name: format!("suspension.{}.{direction}", side.name()),
            output_number: 2 * row + column,
            body: 0,
            axis,
            attachment,
            stiffness,
            damping,
        })
    })
}
