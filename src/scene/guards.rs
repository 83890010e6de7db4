//! What holds an effect back where it does nothing (`effects.mode = "auto"`): in words, for `wheelrail plan`.

use super::spec::Scene;
use super::start;
use crate::formulation::Model;
use crate::geometry::Side;

/// What a scene's guarded effects wait for, by the effect's name in the plan; `None` where it acts all the way, or always by the scene's word.
pub fn guard(effect: &str, scene: &Scene, model: &Model) -> Option<String> {
    if scene.effects.all {
        return None;
    }
    match effect {
        "curves" | "superelevation" | "grades" => nodes_ahead(scene, model),
        "left rail deviations" => ahead(scene, Side::Left),
        "right rail deviations" => ahead(scene, Side::Right),
        "several contacts per wheel" => {
            let searched = !scene.contact.patch.law.forms() && (0..model.contacts()).any(|wheel| model.searches_contacts(wheel));
            searched.then(|| "looked for anew when the certificate of the last search no longer excludes another place".to_string())
        }
        "transient tangential contact" => {
            let below = scene.contact.transient?.below;
            Some(format!("below {below} m/s; its states stand still above {} m/s, where they have no part in the forces", 2.0 * below))
        }
        _ => None,
    }
}

/// The track is X itself until a node.
fn nodes_ahead(scene: &Scene, model: &Model) -> Option<String> {
    let line = model.track.line().filter(|line| line.is_x(front(scene)))?;
    Some(format!("from s = {:.1} m on; before, all is computed as on straight level track", line.x_until()))
}

/// No deviation of a rail acts before a place.
fn ahead(scene: &Scene, side: Side) -> Option<String> {
    let own = start::deviations(scene).into_iter().filter(|deviation| deviation.side == side);
    let from = own.filter_map(|deviation| deviation.shape.acts()).map(|(from, _)| from).reduce(f64::min)?;
    (from > front(scene)).then(|| format!("from s = {from:.1} m on"))
}

/// Distance of the foremost body's centre at the start, m.
fn front(scene: &Scene) -> f64 {
    start::centres(scene).into_iter().fold(f64::NEG_INFINITY, f64::max)
}
