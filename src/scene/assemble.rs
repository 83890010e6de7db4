//! From scene data to a model: only what the scene calls for becomes an object.

use super::effects::Switch;
use super::spec::{ENERGY, SLIDING_MEANS, Scene};
use super::{start, vehicle};
use crate::contact::transient::TransientContact;
use crate::formulation::inputs::RAIL_MOTION;
use crate::formulation::{AssemblyError, ContactLaws, Model, Parts, wheel_search};
use crate::geometry::Side;
use crate::geometry::track::{Rail, Track};

/// Distance over which forces are averaged, m (EN 14363).
pub const MEAN_WINDOW: f64 = 2.0;

/// Contacts that a wheel of the scene can have at once. (Rails are looked at where nothing displaces them.)
pub fn points_needed(scene: &Scene) -> usize {
    let track = &scene.track;
    let rail = |side: Side| Rail::new(side, track.rails[side.index()].profile.clone(), track.half_rail_distance, track.inclination, &[]);
    let track = Track { left: rail(Side::Left), right: rail(Side::Right) };
    wheel_search::needed(vehicle::assemble::all_wheels(&scene.vehicle).as_flattened(), &track, &scene.prepared)
}

/// Assembles the model of a scene.
///
/// # Errors
/// [`AssemblyError`] when the formulation can't treat the scene.
pub fn model(scene: &Scene) -> Result<Model, AssemblyError> {
    let track = &scene.track;
    let (deviations, contact) = (start::deviations(scene), &scene.contact);
    let rail = |side: Side| {
        let profile = track.rails[side.index()].profile.clone();
        let rail =
            Rail::new(side, profile, track.half_rail_distance, track.inclination, &deviations).with_sharp_bends().along(track.line.clone());
        let rail = if scene.effects.all { rail.in_full() } else { rail };
        match &contact.friction_map {
            Some(map) => rail.with_waves(map.waves(side)),
            None => rail,
        }
    };
    let creep = (contact.creep)(contact.material);
    let transient = contact.transient.map(|settings| TransientContact::new(settings, contact.material, creep.as_ref()));
    let transient = if scene.effects.is_off(Switch::Spin) { transient.map(TransientContact::without_spin) } else { transient };
    let transient = if scene.effects.all { transient.map(TransientContact::always) } else { transient };
    let (system, wheelsets) = vehicle::assemble::parts(&scene.vehicle, track.grade)?;
    let design = vehicle::assemble::design(&scene.vehicle, &system);
    let parts = Parts {
        system,
        track: Track { left: rail(Side::Left), right: rail(Side::Right) },
        wheelsets,
        laws: ContactLaws {
            normal: (contact.normal)(contact.material),
            creep,
            damping: (contact.damping_law.build)(contact.damping),
            friction: contact.friction,
            friction_map: contact.friction_map.clone(),
            transient,
            material: contact.material,
            patch: contact.patch.law,
        },
        points: scene.points,
        prepared: scene.prepared.clone(),
        prepared_tables: scene.tables.clone(),
    };
    let places: Vec<f64> = scene.vehicle.wheelsets.iter().map(|placed| placed.x).collect();
    let window = scene.interface.outputs.contains(&SLIDING_MEANS).then_some(MEAN_WINDOW);
    let model = Model::new(parts, &contact.formulation)?;
    model
        .with_sliding_means(window)
        .with_energy_books(scene.interface.outputs.contains(&ENERGY))
        .with_load_tolerance(scene.solver.load_tolerance)
        .searching_always(scene.effects.all)
        .with_rail_motion(scene.interface.inputs.contains(&RAIL_MOTION.name))?
        .with_flexibility(track.flexibility, &places, scene.vehicle.speed)?
        .with_design(design)
        .with_out_of_round(scene.vehicle.wheelsets.iter().flat_map(|placed| placed.spec.out_of_round.clone()).collect())
}
