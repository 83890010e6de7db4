//! Steady running on ideal track, straight or in a curve, by Newton's method from the design configuration.
//!
//! *Pattern.* On a track of constant curvature, superelevation and grade (a helix) all bodies move with it as if they were one rigid body on
//! a screw: they turn about the vertical through the curve's centre and climb with the track. In the track frame beside each
//! body nothing changes. With the common speed S = s' of the frames along the centre line, heading rate `W = S curvature` and the velocity v of a
//! body's centre, in the world:
//!
//! ```text
//! a = W Z x v,   yaw' = W,   roll' = pitch' = 0,   yaw'' = roll'' = pitch'' = 0
//! ```
//!
//! V is the speed v . X of the leading driven wheelset (of the leading one, where none is driven), which gives
//! `S = V / (1 - (P - C) . X_s)`. W = 0 on straight track.
//!
//! *Unknowns* are the six coordinates of each body in the track frame; a wheelset has its pitch rate in place of its pitch. Wheelsets with
//! imposed speed keep their distance along the track; where there is none the leading wheelset keeps its distance, and in its
//! place stands the common acceleration along the track with which the vehicle slows down (rolling resistance of spin
//! creepage, grade). Where several speeds are imposed, the wheelsets that stand elsewhere across the track than the leading one
//! have that pattern's speed, not their own (off by y/R, 1e-5): a run takes that back within 0.1 s and goes on straining the vehicle.
//!
//! *Equations:* accelerations of the constrained system less those of the pattern, along the axes of the track frame; and, where joints or
//! contacts are constraints, the moves that bring the coordinates onto them. First-order states of force elements are at rest, dry friction holds what the way into a curve leaves it (`friction`); an axle
//! that twists is twisted as the moments on its wheels ask for, independent wheels turn each as fast as asks for no moment between them (`twists`).
//!
//! *Continuation:* the balance on straight track (of the curve's grade) comes first; curvature and superelevation then grow together in
//! steps that double while Newton's method converges and are halved where it fails (a flange begins to touch), each
//! from the line through the last two states. Contacts that are constraints stay where they were; if there is no balance with
//! them they are chosen anew (each wheel's deepest place, as at any start). Rigid contact on nearly conformal profiles (S1002 on 60E1) jumps
//! from place to place and mostly has no balance between; on profiles that can touch at several places a vehicle with
//! `contact.on_lift = "elastic"` therefore starts in a curve with all contacts elastic, in the balance of ECF-A, and each becomes a constraint
//! when it has settled.
//!
//! *Slow:* a vehicle that starts slower than 1 m/s is balanced at 1 m/s and its velocities are scaled, because creepages do not depend
//! on the speed. What would be the centripetal accelerations of 1 m/s is scaled too, unless joints or contacts are constraints: those balance
//! it (1.7 mm/s2 at a radius of 600 m, a cant deficiency of 0.3 mm). The centrifugal force of a vertical load stays that of 1 m/s, too (17 N of 10 t).
//!
//! *A lone wheelset* on straight, undisturbed track stands centred (y = yaw = 0, and roll = 0 where both sides are alike) and keeps its speed: height
//! and pitch rate, and where the sides differ the roll angle, are such that vertical force, axle moment and roll moment vanish. Where the
//! sides differ lateral force and yaw moment then remain: it starts off its running line. On a transition, where there is no steady state, it
//! starts as on straight track.
//!
//! A direction in which nothing pushes a body back has a vanishing singular value: neutral ones (a cylinder across its rail) stay
//! where they are, and if no balance exists the body that moves most in such a direction is named.

mod continuation;
mod couplings;
mod friction;
mod holding;
mod newton;
mod rails;
mod riding;
mod search;
mod slack;
mod slopes;
mod standing;
mod twists;

use super::vehicle::VehicleSpec;
use crate::formulation;
use crate::formulation::memory::ModelMemory;
use crate::geometry::track::centre_line::Node;
use crate::scene::equilibrium::EquilibriumError;
use crate::scene::spec::Scene;
use crate::scene::start::{self, Start};
use continuation::{Before, Steps};
use friction::Friction;
use nalgebra::Vector3;
use rails::Riding;
use search::{Pattern, Search};
use std::sync::Arc;
use twists::Twists;

/// A state of steady running.
#[derive(Clone, Debug, PartialEq)]
pub struct SteadyState {
    /// The state vector, coordinates and velocities in the track frame; the design frame's origin is at distance 0.
    pub y: Vec<f64>,
    /// Mean vertical force of a wheel of each wheelset on straight track, N.
    pub wheel_loads: Vec<f64>,
    /// Common acceleration along the track where no speed is imposed, m/s2.
    pub acceleration: f64,
    /// What joints and imposed speeds pull each body with along straight track, N: its mass times that acceleration less all other forces.
    pub pulls: Vec<f64>,
    pub contacts: Contacts,
    /// Share of what dry friction would hold after the way into a curve that it holds: less than 1 where no balance was found with all of it.
    pub rubbed_in: f64,
}

/// How a run begins with contacts that may be constraints.
#[derive(Clone, Debug, PartialEq)]
pub enum Contacts {
    /// Chosen by the formulation.
    Any,
    /// Those of this memory, with which the balance was found.
    Kept(ModelMemory),
    /// Elastic, as the balance was found.
    Elastic,
}

/// What stands on the track: wheelsets first, then other bodies.
struct Standing {
    wheelsets: usize,
    /// Centres in the design configuration, m.
    positions: Vec<Vector3<f64>>,
    /// Weight and constant loads, N.
    weight: f64,
    /// Coordinates of the first body that stay what they are, and whose accelerations may be anything.
    held: &'static [usize],
}

impl SteadyState {
    /// Of a lone wheelset, in the order of [`super::wheelset::INITIAL`].
    pub fn initial_values(&self) -> [f64; 10] {
        let [_, y, z, yaw, roll, _, _, vy, vz, yaw_rate, roll_rate, pitch_rate, ..] = self.y[..] else { return [0.0; 10] };
        [0.0, y, z, roll, yaw, vy, vz, roll_rate, yaw_rate, pitch_rate]
    }
}

/// Speed at which a vehicle that starts at rest is balanced, m/s.
const CREEPING: f64 = 1.0;
/// Rest of the equations (parts of g) that counts as none: smoothed curvatures of real profiles leave contact forces less smooth than this.
const BALANCED: f64 = 1e-6;
/// The same in a curve, where a contact may lie on a joint of its profile.
const IN_CURVE: f64 = 1e-5;
/// The same on displaced rails: joints are followed but for squares of velocities.
const ON_RAILS: f64 = 1e-4;
/// Share of the displacements that is tried first, and the one that is too small a step.
const FIRST_SHARE: f64 = 0.0625;
const LEAST_SHARE: f64 = 0.01;
/// A longer step is halved at once where it does not go well.
const HASTY_SHARE: f64 = 0.05;
/// Corrections of wheelsets' vertical velocities.
const CORRECTIONS: usize = 2;
/// Shares of the curve: the first step of the continuation, and the one that is too short.
const FIRST: f64 = 0.25;
const SHORTEST: f64 = 8e-3;

/// Have both sides of the leading wheelset and of the track the same profiles? Then the steady wheelset does not roll.
pub fn alike(scene: &Scene) -> bool {
    [&scene.vehicle.leading().profiles, &scene.track.rails].iter().all(|[left, right]| Arc::ptr_eq(&left.profile, &right.profile))
}

/// Finds the steady state of a scene's vehicle on the track at its start.
///
/// # Errors
/// [`EquilibriumError`], with the name of a body that has no support if that is the reason.
pub fn steady_state(scene: &Scene) -> Result<SteadyState, EquilibriumError> {
    match (scene.contact.friction_map.clone(), start::origin(scene)) {
        (Some(map), origin) if origin != 0.0 => {
            let mut there = scene.clone();
            there.contact.friction_map = Some(map.counted_from(origin));
            balance(&there)
        }
        _ => balance(scene),
    }
}

/// The same of a scene whose friction is counted from its design frame's origin.
fn balance(scene: &Scene) -> Result<SteadyState, EquilibriumError> {
    let vehicle: &VehicleSpec = &scene.vehicle;
    let (straight, node) = match start::start(scene) {
        Start::Straight => (true, Node::default()),
        Start::Curve(node) => (false, node),
        Start::Transition { .. } if vehicle.is_lone() => (true, Node::default()),
        Start::Transition { distance } => return Err(EquilibriumError::OnTransition { distance }),
    };
    let held: &[usize] = match vehicle.is_lone() && straight && start::displaced(scene).is_none() {
        true if alike(scene) => &[0, 1, 3, 4],
        true => &[0, 1, 3],
        false => &[],
    };
    let standing = Standing {
        wheelsets: vehicle.wheelsets.len(),
        positions: (0..vehicle.body_count()).map(|body| vehicle.design_position(body)).collect(),
        weight: vehicle.weight(),
        held,
    };
    running(scene, &standing, &node)
}

fn running(scene: &Scene, standing: &Standing, node: &Node) -> Result<SteadyState, EquilibriumError> {
    let load = standing.weight * (scene.track.grade + node.grade).cos();
    if load <= 0.0 {
        return Err(EquilibriumError::NoLoad { load });
    }
    let wanted = scene.vehicle.speed;
    let slow = wanted == 0.0 || (scene.contact.transient.is_some() && wanted.abs() < CREEPING);
    let speed = if slow { CREEPING.copysign(wanted) } else { wanted };
    let pattern = Pattern { speed, centripetal: (wanted / speed).powi(2) };
    let riding = Riding::new(scene, standing);
    if let Some(riding) = &riding {
        return on_displaced_rails(scene, standing, pattern, node, riding);
    }
    let scale = wanted / speed;
    let straight = node.curvature == 0.0 && node.superelevation == 0.0;
    if !straight && standing.positions.len() > 1 {
        let model = Search::new(scene, standing, pattern)?.model;
        if model.may_be_elastic() && (0..model.contacts()).any(|contact| model.searches_contacts(contact)) {
            let (search, wheel_loads) = balanced(&with_elastic_contacts(scene), standing, pattern, node)?;
            return Ok(search.found(scale, wheel_loads, Some(Contacts::Elastic)));
        }
    }
    match balanced(scene, standing, pattern, node) {
        Ok((search, wheel_loads)) => {
            let kept = !straight && search.model.formulation.constrains();
            Ok(search.found(scale, wheel_loads, (!kept).then_some(Contacts::Any)))
        }
        Err(cause) => by_elastic_contacts(scene, standing, pattern, node, cause),
    }
}

/// The scene with ECF-A.
fn with_elastic_contacts(scene: &Scene) -> Scene {
    let mut other = scene.clone();
    other.contact.formulation = formulation::algebraic();
    other
}

/// The balance of contacts that are constraints, begun at that of elastic ones, because it was not found from the design configuration for that `cause`: there
/// laws of creep may ask for more than constraints can balance. Where it is not found from there either wheels begin elastic, if they may.
fn by_elastic_contacts(
    scene: &Scene,
    standing: &Standing,
    pattern: Pattern,
    node: &Node,
    cause: EquilibriumError,
) -> Result<SteadyState, EquilibriumError> {
    let mut own = Search::new(scene, standing, pattern)?;
    if !own.model.formulation.constrains() {
        return Err(cause);
    }
    let smooth = with_elastic_contacts(scene);
    let Ok((search, wheel_loads)) = balanced(&smooth, standing, pattern, node) else { return Err(cause) };
    own.lay(node, None);
    own.effort = search.effort;
    own.put_bodies(&search.now);
    own.held_as(&search);
    let scale = scene.vehicle.speed / pattern.speed;
    if own.choose_anew().and_then(|()| own.balance()).is_ok() && own.presses() {
        return Ok(own.found(scale, wheel_loads, None));
    }
    if own.model.may_be_elastic() {
        return Ok(search.found(scale, wheel_loads, Some(Contacts::Elastic)));
    }
    Err(cause)
}

/// The balance on displaced rails: with elastic contacts first, whatever the formulation.
fn on_displaced_rails(
    scene: &Scene,
    standing: &Standing,
    pattern: Pattern,
    node: &Node,
    riding: &Riding,
) -> Result<SteadyState, EquilibriumError> {
    let smooth = with_elastic_contacts(scene);
    let with_bends = on_rails_with(&smooth, standing, pattern, node, riding);
    let mut level = None;
    let (search, wheel_loads) = match with_bends {
        Ok(found) => found,
        // Rails may demand more than contacts between wheels and rails can give, or the search lost its way: then with static loads alone.
        Err(_) => on_rails_with(&smooth, standing, pattern, node, level.insert(riding.without_bends()))?,
    };
    let riding = level.as_ref().unwrap_or(riding);
    let mut own = Search::new(scene, standing, pattern)?;
    own.lay(node, Some((riding, 1.0)));
    own.effort = search.effort;
    own.put_bodies(&search.now);
    own.ride_as(&search);
    own.held_as(&search);
    let scale = scene.vehicle.speed / pattern.speed;
    own.tolerance = ON_RAILS;
    if !own.model.formulation.constrains() {
        // ECF-A is balanced already, ECF-N beside it.
        let balanced = own.is_balanced() || own.balance().is_ok();
        return Ok(if balanced { own } else { search }.found(scale, wheel_loads, Some(Contacts::Any)));
    }
    if own.choose_anew().and_then(|()| own.balance()).is_ok() && own.presses() {
        return Ok(own.found(scale, wheel_loads, None));
    }
    let several = (0..own.model.contacts()).any(|contact| own.model.searches_contacts(contact));
    let contacts = if own.model.may_be_elastic() && several { Contacts::Elastic } else { Contacts::Any };
    Ok(search.found(scale, wheel_loads, Some(contacts)))
}

/// The balance with elastic contacts on displaced rails, and the wheel loads of straight track, N.
///
/// Independent wheels are led by their weight alone. In a curve a flange holds them; on straight track they mostly have no balance where rails are displaced (at speed they would not come to
/// it either), and start as wheels do that turn together.
fn on_rails_with<'a>(
    smooth: &Scene,
    standing: &'a Standing,
    pattern: Pattern,
    node: &Node,
    riding: &Riding,
) -> Result<(Search<'a>, Vec<f64>), EquilibriumError> {
    let (mut search, wheel_loads) = balanced(smooth, standing, pattern, node)?;
    let independent = Twists::independent(&search.model);
    if !independent || node.curvature != 0.0 {
        match onto_the_rails(&mut search, node, riding) {
            Err(_) if independent => search = balanced(smooth, standing, pattern, node)?.0,
            found => return found.map(|()| (search, wheel_loads)),
        }
    }
    search.twists.held_by = f64::INFINITY;
    search.balance()?;
    onto_the_rails(&mut search, node, riding)?;
    let together = (search.configuration(), search.twists.clone());
    if release(&mut search).is_err() {
        search.put(&together.0);
        (search.effort, search.twists) = (0, together.1);
        search.balance()?;
    }
    Ok((search, wheel_loads))
}

/// From the balance on ideal rails to that on displaced ones, by parts of the displacements where need be.
fn onto_the_rails(search: &mut Search, node: &Node, riding: &Riding) -> Result<(), EquilibriumError> {
    (search.following, search.tolerance) = (true, ON_RAILS);
    search.keep_friction();
    // The first approximation is a poor one, but the balance at the first share shows the way.
    let steps = Steps { from: 0.0, to: 1.0, first: FIRST_SHARE, growth: 4.0, shortest: LEAST_SHARE };
    let balance = |search: &mut Search, done: f64, next: f64, before: Option<&Before>| {
        search.lay(node, Some((riding, next)));
        match before {
            Some(before) => search.go_on(&before.1, before.ahead(done, next)),
            None => search.move_along(riding, next - done),
        }
        search.ride(riding, next);
        search.hasty = next - done > HASTY_SHARE;
        let mut found = search.balance();
        for _ in 0..if next == 1.0 { CORRECTIONS } else { 0 } {
            found = found.and_then(|()| {
                search.hasty = false;
                search.follow_contacts();
                search.balance()
            });
        }
        found
    };
    let failed = |(next, cause)| EquilibriumError::OnRails { percent: 100.0 * next, cause: Box::new(cause) };
    steps.follow(search, balance).map_err(failed)
}

/// The balance on a track of that node all the way, and the wheel loads of straight track, N.
fn balanced<'a>(scene: &Scene, standing: &'a Standing, pattern: Pattern, node: &Node) -> Result<(Search<'a>, Vec<f64>), EquilibriumError> {
    let load = standing.weight * (scene.track.grade + node.grade).cos();
    let mut search = Search::new(scene, standing, pattern)?;
    search.lay(&Node { curvature: 0.0, superelevation: 0.0, ..*node }, None);
    search.stand(load)?;
    search.balance_with_slack()?;
    let wheel_loads = search.wheel_loads();
    if node.curvature != 0.0 || node.superelevation != 0.0 {
        search.rails_yield = false;
        rubbing_into_the_curve(&mut search, node)?;
        search.rails_yield = true;
        if search.model.gives_way() {
            search.balance()?;
        }
    }
    Ok((search, wheel_loads))
}

/// Into the curve with dry friction that holds what the way leaves it; where there is no balance that way, without it, and then with as much of it as there is one with.
fn rubbing_into_the_curve(search: &mut Search, node: &Node) -> Result<(), EquilibriumError> {
    let straight = search.configuration();
    let friction = search.friction_from_here();
    let go = |search: &mut Search| match Twists::independent(&search.model) {
        true => on_independent_wheels(search, node),
        false => into_the_curve(search, node),
    };
    search.friction = friction.clone();
    let found = go(search);
    if found.is_ok() || matches!(friction, Friction::Without) {
        return found;
    }
    search.put(&straight);
    (search.effort, search.friction, search.hasty) = (0, Friction::Without, false);
    search.lay(&Node { curvature: 0.0, superelevation: 0.0, ..*node }, None);
    go(search)?;
    search.effort = 0;
    search.rub_in(&friction);
    Ok(())
}

/// From wheels that turn together to wheels that turn on their own: what resists that goes down from the first of these to the last, N m s, then away.
const HOLDING: [f64; 2] = [1e8, 1.0];

/// Into the curve on independent wheels: from those that turn together, or, as rigid contacts rather have it, from straight track; the other way where one fails.
fn on_independent_wheels(search: &mut Search, node: &Node) -> Result<(), EquilibriumError> {
    let together = !search.model.formulation.constrains();
    let straight = search.configuration();
    let mut go = |together: bool| {
        search.put(&straight);
        (search.effort, search.twists.held_by) = (0, if together { f64::INFINITY } else { 0.0 });
        search.lay(&Node { curvature: 0.0, superelevation: 0.0, ..*node }, None);
        into_the_curve(search, node)?;
        if together { release(search).map_err(led_by_weight) } else { Ok(()) }
    };
    go(together).or_else(|cause| go(!together).map_err(|_| cause))
}

/// Why independent wheels found no place in the whole curve though wheels that turn together did.
fn led_by_weight(cause: EquilibriumError) -> EquilibriumError {
    let advice = "; with wheels that turn together there is one, but independent wheels are led by their weight alone, and their place may be anywhere between the flanges: start on straight track before the curve (track.node, vehicle.initial.distance)";
    EquilibriumError::Curving { percent: 100.0, cause: Box::new(cause), advice }
}

/// From the balance in a curve with independent wheels that turn together, which creep leads to their place, to that of wheels that turn on their own: what
/// holds them on each other falls off by decades. (From straight track nothing would lead them: the balance jumps from flange to flange.)
fn release(search: &mut Search) -> Result<(), EquilibriumError> {
    let [most, least] = HOLDING.map(f64::ln);
    let shortest = SHORTEST * (most - least);
    let steps = Steps { from: most, to: least, first: 0.5 * (most - least), growth: 1.5, shortest };
    let balance = |search: &mut Search, done: f64, next: f64, before: Option<&Before>| {
        search.twists.held_by = if next == least { 0.0 } else { next.exp() };
        if let Some(before) = before {
            search.go_on(&before.1, before.ahead(done, next));
        }
        search.hasty = done - next > shortest;
        let found = search.balance();
        search.hasty = false;
        found
    };
    steps.follow(search, balance).map_err(|(_, cause)| cause)
}

/// From the balance on straight track to that in the curve.
fn into_the_curve(search: &mut Search, node: &Node) -> Result<(), EquilibriumError> {
    (search.following, search.tolerance) = (true, IN_CURVE);
    let steps = Steps { from: 0.0, to: 1.0, first: FIRST, growth: 2.0, shortest: SHORTEST };
    let balance = |search: &mut Search, done: f64, next: f64, before: Option<&Before>| {
        search.lay(&Node { curvature: next * node.curvature, superelevation: next * node.superelevation, ..*node }, None);
        if let Some(before) = before {
            search.go_on(&before.1, before.ahead(done, next));
        }
        let predicted = search.configuration();
        search.balance().or_else(|cause| {
            // The contact that is a constraint may have come to its end: another one takes its place.
            if !search.model.formulation.constrains() {
                return Err(cause);
            }
            search.put(&predicted);
            search.choose_anew()?;
            search.balance()
        })
    };
    steps.follow(search, balance).map_err(|(next, cause)| {
        let rigid = search.model.formulation.constrains() && !search.model.may_be_elastic();
        let advice = match (rigid, search.exhausted()) {
            (true, _) => "; contact.on_lift = \"elastic\" lets contacts begin elastic",
            (false, true) => "; the search was given up there (its work is bounded): start before the curve, or on a wider one",
            (false, false) => "",
        };
        EquilibriumError::Curving { percent: 100.0 * next, cause: Box::new(cause), advice }
    })
}
