//! One wheel's patch as strips, beside the half-space contact of the same surfaces in the same pose.

use crate::contact::creep::{CreepLaw, RollingContact};
use crate::contact::creepage::{ContactAxes, in_rolling_direction};
use crate::contact::patch::Motion;
use crate::contact::search::algebraic::Pair;
use crate::contact::strips::{
    Cells, Creep, FLANK, MOST, Part, Parts, PatchTable, Pressed, RailStrips, Scratch, Section, Uneven, press_anywhere,
};
use crate::scene::spec::Scene;
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::sync::Arc;

/// What the strips say.
#[derive(Clone, Copy, Debug)]
pub struct StripPatch {
    /// Of all pressures on the wheel, N.
    pub pressing: Vector3<f64>,
    /// Load's centre in the world, m, on the undeformed wheel.
    pub centre: Vector3<f64>,
    /// m^2.
    pub area: f64,
    pub parts: usize,
    /// With the scene's creep law on the parts, N.
    pub creep_force: Vector3<f64>,
}

/// A wheel and a rail in any pose.
pub struct Strips<'a> {
    scene: &'a Scene,
    rail: RailStrips,
    table: Arc<PatchTable>,
}

impl<'a> Strips<'a> {
    /// Of the scene's wheel and rail of this pair; a table that is not known yet is made.
    pub fn new(scene: &'a Scene, pair: &Pair) -> Strips<'a> {
        let rail = RailStrips::new(pair.rail, std::iter::once(pair.wheel));
        let table = scene.tables.of_pair(pair.wheel, pair.rail, &rail);
        Strips { scene, rail, table }
    }

    /// What the strips say, `None` where nothing overlaps; and what their table says where it knows the pose wholly, and no flange presses.
    pub fn patches(&self, pair: &Pair, motion: &Motion) -> Option<(StripPatch, Option<StripPatch>)> {
        let mut scratch = Scratch::new(self.rail.len());
        let pressed = press_anywhere(pair, &self.rail, self.scene.contact.material, &mut scratch);
        let tabled = if self.rail.carries_beyond(FLANK, pressed) { None } else { self.tabled(pair, motion) };
        Some((self.pressed(pair, motion, pressed)?, tabled))
    }

    fn pressed(&self, pair: &Pair, motion: &Motion, pressed: &[Pressed]) -> Option<StripPatch> {
        let (scene, rail, material) = (self.scene, &self.rail, self.scene.contact.material);
        let parts = Parts::new(pressed, rail, MOST);
        let part = |first, last| Part::new(parts.share(pressed, first, last), rail, pair.wheel.profile.as_ref(), material);
        let last = parts.len().checked_sub(1)?;
        let law = (scene.contact.creep)(material);
        let creep = |first: usize, last: usize| {
            let cells = Cells::Strips(parts.share(pressed, first, last));
            rolling(scene, law.as_ref(), motion, (cells, &part(first, last)))
        };
        let own: Vec<Part> = (0..=last).map(|k| part(k, k)).collect();
        let forces: Vec<f64> = own.iter().map(|part| part.load).collect();
        let creeps = match motion.speed == 0.0 {
            true => [Creep::default(); MOST],
            false => parts.mixed(&forces, &mut |first, last| creep(first, last)),
        };
        Some(StripPatch {
            pressing: own.iter().map(|part| part.normal * part.force).sum(),
            centre: pair.centre + part(0, last).arm,
            area: own.iter().map(|part| PI * part.patch.a * part.patch.b).sum(),
            parts: last + 1,
            creep_force: creeps.iter().map(|creep| creep.force).sum(),
        })
    }

    fn tabled(&self, pair: &Pair, motion: &Motion) -> Option<StripPatch> {
        let (scene, material) = (self.scene, self.scene.contact.material);
        let looked = self.table.look(pair, &Section::new(pair), material)?;
        if looked.weight < 1.0 {
            return None;
        }
        let (law, part) = ((scene.contact.creep)(material), &looked.part);
        let creep = match motion.speed == 0.0 {
            true => Creep::default(),
            false => rolling(scene, law.as_ref(), motion, (Cells::Fifths(&looked.fifths), part)),
        };
        Some(StripPatch {
            pressing: part.normal * part.force,
            centre: pair.centre + part.arm,
            area: PI * part.patch.a * part.patch.b,
            parts: 1,
            creep_force: creep.force,
        })
    }
}

/// Creep of a part with the scene's law.
fn rolling(scene: &Scene, law: &dyn CreepLaw, motion: &Motion, (cells, part): (Cells, &Part)) -> Creep {
    let Motion { velocity, rotation, speed } = *motion;
    let (material, friction) = (scene.contact.material, scene.contact.friction);
    let axes = ContactAxes::new(part.normal, part.forward);
    let creepage = axes.slip(&(velocity + rotation.cross(&part.arm)), &rotation).creepage(speed);
    let contact = RollingContact { patch: part.patch, normal_force: part.load, friction, speed: speed.abs(), creepage };
    let uneven = Uneven { cells, part, axes: axes.rolling(speed), velocity, rotation, material };
    let found = in_rolling_direction(speed, creepage, |creepage| {
        let contact = RollingContact { creepage, ..contact };
        uneven.force(&law.force(&contact), &contact)
    });
    Creep { force: axes.e1 * found.longitudinal + axes.e2 * found.lateral, moment: found.spin_moment, bound: contact.bound() }
}
