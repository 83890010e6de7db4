//! What a scene says that does nothing, or something else than was meant: found by looking where the vehicle goes and at what it is made of.

use super::element_doubts::doubts;
use super::far_places::far_places;
use super::spec::Scene;
use super::start::origin;
use super::vehicle::assemble::static_preloads;
use super::vehicle::extent::Away;
use super::vehicle::stability::{Fall, fall};
use crate::formulation::Model;
use crate::formulation::wheelset::Wheelset;
use crate::geometry::Side;
use crate::geometry::surface::Wheel;
use crate::geometry::track::Deviation;
use crate::geometry::track::centre_line::Node;
use crate::mbs::body::Body;
use crate::mbs::force::ForceElement;
use crate::mbs::joint::Joint;

/// All of them.
pub(super) fn oversights(scene: &Scene, model: &Model) -> Vec<String> {
    let missed = scene.vehicle.away().and_then(Away::missed);
    unreached(scene)
        .into_iter()
        .chain(friction_ahead(scene))
        .chain(curve_ahead(scene))
        .chain(given_twice(scene))
        .chain(off_the_axle(scene, model))
        .chain(off_the_tread(model))
        .chain(doubts(model))
        .chain(far_places(model))
        .chain(soft_springs(scene).or_else(|| falls(scene)))
        .chain(two_along_the_track(model))
        .chain(level_boxes(scene, model))
        .chain(extents(scene, model))
        .chain(adverse(scene))
        .chain(missed)
        .collect()
}

/// Spacing of the places that are looked at, and how far beyond its way, m.
const SPACING: f64 = 0.1;
const BESIDE: f64 = 1.0;
/// Places of a displacement that is not reached, which are looked at.
const MIDDLES: usize = 16;

/// Where wheels come to in a run, m; known where the speed is imposed and stays.
pub(super) fn way(scene: &Scene) -> Option<[f64; 2]> {
    let vehicle = &scene.vehicle;
    if !vehicle.speed_imposed || vehicle.speed_profile().is_some() {
        return None;
    }
    let way = vehicle.speed * scene.run.stop;
    let wheels = vehicle.wheelsets.iter().map(|wheelset| wheelset.x);
    let (rear, front) = wheels.fold((f64::INFINITY, f64::NEG_INFINITY), |(rear, front), x| (rear.min(x), front.max(x)));
    Some([origin(scene) + rear + way.min(0.0), origin(scene) + front + way.max(0.0)])
}

/// Friction that changes where no wheel comes to.
fn friction_ahead(scene: &Scene) -> Option<String> {
    let [first, last] = way(scene)?;
    let map = scene.contact.friction_map.as_ref()?;
    let mut changes = Side::BOTH.into_iter().flat_map(|side| map.waves(side)).peekable();
    let nearest = changes.peek()?.from;
    changes.all(|change| change.to < first - BESIDE || change.from > last + BESIDE).then(|| {
        format!(
            "contact.friction_along: friction changes nowhere where the vehicle goes (at {nearest:.0} m and beyond; its wheels stand between {first:.0} and {last:.0} m in this run): see \
             vehicle.initial.distance, run.stop"
        )
    })
}

/// A curve that the vehicle does not come to.
fn curve_ahead(scene: &Scene) -> Option<String> {
    let [_, last] = way(scene)?;
    let nodes = &scene.track.alignment.as_ref()?.nodes;
    let plain = |node: &Node| node.curvature == 0.0 && node.superelevation == 0.0 && node.grade == nodes[0].grade;
    let begins = nodes.windows(2).find(|pair| plain(&pair[0]) && !plain(&pair[1])).filter(|_| plain(&nodes[0]))?[0].distance;
    (begins > last + BESIDE).then(|| {
        format!(
            "track.node: the track is plain as far as the vehicle goes (to {last:.0} m; it changes from {begins:.0} m on): see vehicle.initial.distance, run.stop"
        )
    })
}

/// A displacement that is there two times, as from one file under two tables.
fn given_twice(scene: &Scene) -> Option<String> {
    let all = &scene.track.deviations;
    let same = |a: &Deviation, b: &Deviation| a.side == b.side && a.direction == b.direction && a.shape.describe() == b.shape.describe();
    let twice = all.iter().enumerate().find(|(i, deviation)| all[..*i].iter().any(|before| same(before, deviation)))?.1;
    Some(format!(
        "track: {} acts twice on the {} rail: what one and the same displacement does is added up",
        twice.shape.describe(),
        twice.side.name()
    ))
}

/// Displacements of the rails that no wheel comes to.
fn unreached(scene: &Scene) -> Option<String> {
    let [rear, front] = way(scene)?;
    let (first, last) = (rear - BESIDE, front + BESIDE);
    let mut missed = scene.track.deviations.iter().filter(|deviation| {
        let places = (0..=((last - first) / SPACING) as usize).map(|k| first + SPACING * k as f64);
        let acts = |s: f64| deviation.shape.at(s)[0] != 0.0;
        let begins = deviation.shape.waves().iter().map(|stretch| stretch.from).fold(f64::INFINITY, f64::min);
        let ends = deviation.shape.waves().iter().map(|stretch| stretch.to).fold(f64::NEG_INFINITY, f64::max);
        // One of amplitude 0 is none.
        let somewhere = (1..MIDDLES).any(|k| acts(begins + (ends - begins) * k as f64 / MIDDLES as f64));
        (ends < first || begins > last) && somewhere && !places.into_iter().any(acts)
    });
    let one = missed.next()?;
    Some(format!(
        "track: {} acts nowhere where the vehicle goes (its wheels stand between {:.0} and {:.0} m in this run): see from, to and offset, vehicle.initial.distance, run.stop",
        one.shape.describe(),
        rear,
        front
    ))
}

/// An attachment to an axle may be so far off its line, m: 0.1 kN m of a static spring force of 10 kN.
const OFF_AXLE: f64 = 0.01;

/// Elements whose moment about the axle is lost ([`crate::mbs::force::Attachment`]).
fn off_the_axle(scene: &Scene, model: &Model) -> Option<String> {
    let of = |element: &super::vehicle::Element| {
        let on_wheelset = |body: usize| model.wheelsets.iter().find(|wheelset| wheelset.body == body);
        element.0.holds().into_iter().flatten().find_map(|place| {
            let wheelset = on_wheelset(place.body?)?;
            let off = place.local.x.hypot(place.local.z);
            (off > OFF_AXLE).then(|| (element.0.name().to_string(), wheelset.name.clone(), off))
        })
    };
    let mut found = scene.vehicle.forces.iter().filter_map(of);
    let (name, wheelset, off) = found.next()?;
    let others = match found.count() {
        0 => String::new(),
        more => format!(" (and {more} more)"),
    };
    Some(format!(
        "{name}{others} holds on to {wheelset} {:.0} mm off the axle's line: bearings hand no moment about the axle over, so that its force times that distance is lost and wheel loads \
         of a bogie no longer add up about its middle; attach it on the axle's line, or to a body of its own (axle box, swing arm) that a joint holds on the axle",
        1e3 * off
    ))
}

/// A block's place may be off its tread by so much, in parts of the radius: what is worn, and where on the tread it presses.
const OFF_TREAD: f64 = 0.08;

/// Blocks of tread brakes that are not where a tread is: their distance from the axle is the lever of their friction.
fn off_the_tread(model: &Model) -> Option<String> {
    let of = |force: &dyn ForceElement| {
        let (body, lever) = force.block()?;
        let wheelset = model.wheelsets.iter().find(|wheelset| wheelset.body == body)?;
        let radius = wheelset.left.profile.at(0.0).value;
        ((lever / radius - 1.0).abs() > OFF_TREAD).then(|| {
            format!(
                "{}: its block is {lever:.3} m from the axle, and wheels of {} have a radius of {radius:.3} m: that distance is the lever of its friction; put \"from\" on the tread",
                force.name(),
                wheelset.name
            )
        })
    };
    model.system.forces.iter().find_map(|force| of(force.as_ref()))
}

/// No spring of a vehicle is pressed so far by what it carries, m: a body would swing on it with 0.3 Hz.
const SOFTEST: f64 = 3.0;

/// Springs that balance gives a preload which presses them beyond all bounds.
fn soft_springs(scene: &Scene) -> Option<String> {
    let of = |(element, index, force): &(usize, usize, f64)| {
        let element = scene.vehicle.forces.get(*element)?;
        // A bag's is that of the pressure under its load.
        let mut loaded = element.0.clone_box();
        loaded.set_preload(*index, *force);
        let stiffness = *loaded.static_stiffness().get(*index)?;
        let pressed = force.abs() / stiffness;
        (pressed > SOFTEST).then(|| {
            format!(
                "{}: it carries {:.1} kN with a stiffness of {stiffness:.1} N/m, which is {pressed:.0} m of spring: was another unit meant (N/mm, litres)?",
                element.0.name(),
                1e-3 * force.abs()
            )
        })
    };
    static_preloads(&scene.vehicle).ok()?.iter().find_map(of)
}

/// A body that its springs do not keep upright.
fn falls(scene: &Scene) -> Option<String> {
    let Fall { body, direction, rate } = fall(&scene.vehicle)?;
    Some(format!(
        "{body} does not stand by itself: springs and joints let it fall, first {direction}, {rate:.2} 1/s at the start, until friction or a stop holds it; the run begins where it balances"
    ))
}

/// Grades of nodes that count, rad.
const GRADE: f64 = 1e-3;

/// Joints hold to boxes on axles that stay level in the world where nodes give the track a grade: those that feel how a box is turned about its axle are turned by it.
fn level_boxes(scene: &Scene, model: &Model) -> Option<String> {
    let nodes = scene.track.alignment.iter().flat_map(|alignment| &alignment.nodes);
    let steepest = nodes.map(|node| node.grade.abs()).fold(0.0, f64::max);
    let feels = |joint: &&Joint| model.wheelsets.iter().any(|wheelset| joint.feels_turn_about_y(wheelset.body));
    let joint = (steepest > GRADE).then(|| model.system.joints.iter().find(feels)).flatten()?;
    Some(format!(
        "{}: joints on an axle stay level in the world where track.node gives a grade (up to {:.1} % here), so that what this one holds is turned by it against the track; with track.grade it is \
         not. Give a constant grade as track.grade, or hold it by a joint that is free about the axle, on the axle's line",
        joint.name,
        1e2 * steepest.tan()
    ))
}

/// Steps of a profile in which its steepest place is looked for.
const STEPS: u32 = 2000;
/// The steepest flank that counts as a flange's: 75 degrees.
const STEEPEST: f64 = 3.73;

/// Hollows along a rail in which a flange stands on two places: seen from above it is an arc of the radius `R tan(angle)`.
fn two_along_the_track(model: &Model) -> Option<String> {
    let arc = |wheel: &Wheel| {
        let (first, _) = wheel.profile.range();
        let at = |step: u32| wheel.profile.at(first * f64::from(step) / f64::from(STEPS)).d1.abs();
        let steepest = if first < 0.0 { (0..=STEPS).map(at).fold(0.0, f64::max).min(STEEPEST) } else { 0.0 };
        steepest * wheel.profile.at(0.0).value
    };
    Side::BOTH.into_iter().find_map(|side| {
        let (hollow, distance) = model.track.rail(side).sharpest_hollow()?;
        let longest = model.wheelsets.iter().map(|wheelset| arc(wheelset.wheel(side))).fold(0.0, f64::max);
        (hollow * longest > 1.0).then(|| {
            format!(
                "track: at {distance:.3} m the {} rail is hollow along its face by {hollow:.2} 1/m, and a flange is less curved there ({:.2} 1/m, seen from above): it stands on two places along \
                 the track, of which the deeper one alone is taken, so that its forces there are worth their order of magnitude",
                side.name(),
                1.0 / longest
            )
        })
    })
}

/// Radii of gyration beyond which no vehicle's body, and no wheelset, is, m.
const EXTENT: f64 = 20.0;
const EXTENT_OF_WHEELSETS: f64 = 3.0;
/// The least one of wheelsets across the axle, with wheels at both ends, m.
const LEAST_OF_WHEELSETS: f64 = 0.25;
/// Moment about the axle, by that of its mass at the tread.
const MOST_AT_TREAD: f64 = 1.2;

/// Moments of inertia of another unit than the mass.
fn extents(scene: &Scene, model: &Model) -> Option<String> {
    let far = |body: &Body, most: f64| {
        let largest = body.inertia.moments().into_iter().fold(0.0, f64::max);
        let radius = (largest / body.mass).sqrt();
        (radius > most).then(|| {
            format!(
                "{}: {largest} kg m2 of {} kg are a radius of gyration of {radius:.0} m, which no such body has: was another unit meant?",
                body.name, body.mass
            )
        })
    };
    let rolls = |wheelset: &Wheelset| {
        let (body, radius) = (&model.system.bodies[wheelset.body], wheelset.left.profile.at(0.0).value);
        let (about_axle, most) = (body.inertia.moments()[1], body.mass * radius * radius);
        (about_axle > MOST_AT_TREAD * most).then(|| {
            format!(
                "{}: inertia_yy = {about_axle} kg m2 about its axle is more than all of its mass at the tread would have ({most:.0} kg m2): was another unit meant, or have moments changed places?",
                body.name
            )
        })
    };
    let slender = |wheelset: &Wheelset| {
        let body = &model.system.bodies[wheelset.body];
        let yaw = body.inertia.moments()[2];
        let radius = (yaw / body.mass).sqrt();
        (radius < LEAST_OF_WHEELSETS).then(|| {
            format!(
                "{}: inertia_zz = {yaw} kg m2 of {} kg are a radius of gyration of {radius:.2} m; wheels at both ends of an axle give 0.5 to 0.8 m: was another unit meant?",
                body.name, body.mass
            )
        })
    };
    if let Some(note) = model.wheelsets.iter().find_map(|wheelset| rolls(wheelset).or_else(|| slender(wheelset))) {
        return Some(note);
    }
    let wheelsets = model.wheelsets.iter().find_map(|wheelset| far(&model.system.bodies[wheelset.body], EXTENT_OF_WHEELSETS));
    wheelsets.or_else(|| scene.vehicle.bodies.iter().find_map(|placed| far(&placed.body, EXTENT)))
}

/// Adverse cant without a word, rad: 13 mm.
const ADVERSE: f64 = 9e-3;

/// Rails lean by less, rad: 1:12.
const STEEPEST_RAIL: f64 = 1.0 / 12.0;

/// Cant that lifts the inner rail, and rails that lean outward.
fn adverse(scene: &Scene) -> Vec<String> {
    let nodes = scene.track.alignment.iter().flat_map(|alignment| &alignment.nodes);
    let wrong = nodes.into_iter().find(|node| node.curvature != 0.0 && node.superelevation * node.curvature.signum() > ADVERSE);
    let cant = wrong.map(|node| {
        format!(
            "track.node at {} m: the inner rail of the curve stands higher (superelevation is positive where the left rail is up, radius where the curve goes left): adverse cant",
            node.distance
        )
    });
    let inclination = scene.track.inclination;
    let outward = (inclination < 0.0)
        .then(|| format!("track.inclination = {inclination}: rails that lean outward; rails of railways lean inward by 1:20 or 1:40"));
    let steep = (inclination > STEEPEST_RAIL).then(|| {
        format!(
            "track.inclination = {inclination:.3}: rails that lean inward by 1:{:.1}; those of railways lean by 1:20 or 1:40",
            1.0 / inclination.tan()
        )
    });
    cant.into_iter().chain(outward).chain(steep).collect()
}
