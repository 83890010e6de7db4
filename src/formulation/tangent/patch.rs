//! How the parts of a patch of strips change with the pose of their wheel: load, centre and normal.
//!
//! Along the rail nothing changes. Of the other motions four are tried, in the wheelset's axes: across, up, roll and yaw; turning about the axle changes
//! nothing. Loads of strips change as [`Scratch::moved`] says, stiffer by what one wheel that is pressed deeper shows; what parts make of them is differenced. How the patch's proportions change is left out.

use crate::contact::Material;
use crate::contact::search::algebraic::Pair;
use crate::contact::search::migration::{Row, add};
use crate::contact::strips::{MOST, Part, Parts, Pressed, RailStrips, Scratch, Section, press};
use crate::formulation::ContactReport;
use nalgebra::Vector3;

/// Differences: translations [m], rotations [rad].
const STEP: f64 = 1e-6;
const TURN: f64 = 2e-6;

/// Derivatives of one part in the world: of its elastic force [N], of its centre from the wheelset's [m], of its normal.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PartChange {
    pub force: Row,
    pub arm: [Row; 3],
    pub normal: [Row; 3],
    /// Of the direction along the rail.
    pub forward: [Row; 3],
    /// Length of that direction.
    pub length: f64,
}

/// What [`changes`] finds of a wheel.
#[derive(Clone, Debug, Default)]
pub(super) struct PatchChanges {
    /// Of the contacts by number; `None` where one carries nothing or is not what it was.
    pub parts: [Option<PartChange>; MOST],
    /// Number of the part in the order of the strips, by number of the contact.
    pub numbers: [Option<usize>; MOST],
    /// Where parts are partly one: of all as one.
    pub whole: Option<WholeChange>,
    pub found: Found,
}

/// All parts of a wheel as one.
#[derive(Clone, Copy, Debug)]
pub(super) struct WholeChange {
    /// Derivatives of the parts' independence.
    pub by_pose: Row,
    pub change: PartChange,
}

/// The parts of a wheel in one pose.
#[derive(Clone, Debug, Default)]
pub(super) struct Found {
    pub split: Parts,
    pub parts: [Option<Part>; MOST],
    /// All as one, where they are partly so, and their independence, 0 to 1.
    pub whole: Option<Part>,
    pub independence: f64,
}

fn find(pressed: &[Pressed], pair: &Pair, rail: &RailStrips, material: Material, most: usize) -> Found {
    let split = Parts::new(pressed, rail, most);
    let count = split.len();
    let part = |first: usize, last: usize| {
        (last < count).then(|| Part::new(split.share(pressed, first, last), rail, pair.wheel.profile.as_ref(), material))
    };
    let independence = if count > 1 { split.divide(0, count - 1).1 } else { 1.0 };
    let whole = if independence < 1.0 { part(0, count - 1) } else { None };
    let parts = std::array::from_fn(|k| part(k, k));
    Found { split, parts, whole, independence }
}

/// Finds them; `reports` are those of the wheel at the pose of `pair`, by number; the first scratch holds, or takes up, its strips in that pose.
pub(super) fn changes<'r>(
    pair: &Pair,
    rail: &RailStrips,
    reports: impl Iterator<Item = &'r ContactReport> + Clone,
    material: Material,
    (scratch, tried): (&mut Scratch, &mut Scratch),
) -> PatchChanges {
    let mut changes = PatchChanges::default();
    let most = reports.clone().count();
    let seeds = reports.clone().filter(|report| report.normal_force > 0.0).map(|report| report.parameters.rail);
    let [ahead, across, up] = [0, 1, 2].map(|k| pair.axes.column(k).into_owned());
    // Half lengths grow with the loads: by how much that makes the patch stiffer is tried once.
    let load = |pressed: &[Pressed]| pressed.iter().map(|strip| strip.load).sum::<f64>();
    let lowered = pair.centre - up * STEP;
    let deeper = load(press(&Pair { centre: &lowered, ..*pair }, rail, seeds.clone(), material, tried));
    let pressed = if scratch.is_of(pair) { scratch.pressed() } else { press(pair, rail, seeds, material, scratch) };
    let (here, all) = (find(pressed, pair, rail, material, most), load(pressed));
    let growth = (deeper - all) / (load(scratch.moved(&(-up * STEP), &Vector3::zeros(), 1.0)) - all);
    let mut by = [PartChange::default(); MOST + 1];
    let mut by_pose = [0.0; 6];
    let mut same = true;
    for (translation, rotation) in [(across, None), (up, None), (Vector3::zeros(), Some(ahead)), (Vector3::zeros(), Some(up))] {
        let turn = rotation.unwrap_or_default() * TURN;
        let moved = find(scratch.moved(&(translation * STEP), &turn, growth), pair, rail, material, most);
        same &= moved.split.len() == here.split.len() && moved.whole.is_some() == here.whole.is_some();
        let per_step = 1.0 / if rotation.is_some() { TURN } else { STEP };
        let mut row = [0.0; 6];
        for k in 0..3 {
            (row[k], row[3 + k]) = (translation[k] * per_step, rotation.map_or(0.0, |about| about[k] * per_step));
        }
        add(&mut by_pose, moved.independence - here.independence, &row);
        let pairs = here.parts.iter().chain([&here.whole]).zip(moved.parts.iter().chain([&moved.whole]));
        for (change, (one, other)) in by.iter_mut().zip(pairs) {
            let (Some(one), Some(other)) = (one, other) else { continue };
            add(&mut change.force, other.force - one.force, &row);
            for k in 0..3 {
                add(&mut change.arm[k], other.arm[k] - one.arm[k], &row);
                add(&mut change.normal[k], other.normal[k] - one.normal[k], &row);
                add(&mut change.forward[k], other.forward[k] - one.forward[k], &row);
            }
        }
    }
    for (slot, report) in reports.clone().enumerate().filter(|(_, report)| report.normal_force > 0.0) {
        let own = |part: &Option<Part>| part.is_some_and(|part| (part.coordinates[1] - report.parameters.rail).abs() < 1e-9);
        changes.numbers[slot] = here.parts.iter().position(own);
    }
    if !same {
        changes.found = here;
        return changes;
    }
    // Where the wheel goes along with the rail and turns with it, vectors turn and nothing else changes: that sets the derivative along the wheelset's first axis.
    let (along, turning) = Section::new(pair).course();
    let known = |row: &mut Row, change: f64| {
        let (way, turn) = (Vector3::new(row[0], row[1], row[2]), Vector3::new(row[3], row[4], row[5]));
        let missing = ahead * ((change - way.dot(&along) - turn.dot(&turning)) / ahead.dot(&along));
        (0..3).for_each(|k| row[k] += missing[k]);
    };
    for (change, part) in by.iter_mut().zip(here.parts.iter().chain([&here.whole])) {
        let Some(Part { arm, normal, forward, .. }) = part else { continue };
        let turned = [turning.cross(arm), turning.cross(normal), turning.cross(forward)];
        change.length = forward.norm();
        for (rows, turned) in [&mut change.arm, &mut change.normal, &mut change.forward].into_iter().zip(&turned) {
            rows.iter_mut().zip(turned.iter()).for_each(|(row, turned)| known(row, *turned));
        }
        known(&mut change.force, 0.0);
    }
    known(&mut by_pose, 0.0);
    for slot in 0..MOST {
        let Some(number) = changes.numbers[slot] else { continue };
        changes.parts[slot] = Some(by[number]);
    }
    // A whole without its first part would be loaded nowhere.
    if here.whole.is_some() && changes.numbers.contains(&Some(0)) {
        changes.whole = Some(WholeChange { by_pose, change: by[MOST] });
    }
    changes.found = here;
    changes
}

impl PartChange {
    /// Changes of the arm, and the rotation of the contact's axes, both in these axes.
    pub fn in_axes(&self, [e1, e2, normal]: [&Vector3<f64>; 3]) -> ([Row; 3], [Row; 3]) {
        let of = |rows: &[Row; 3], axis: &Vector3<f64>| {
            let mut sum = [0.0; 6];
            (0..3).for_each(|k| add(&mut sum, axis[k], &rows[k]));
            sum
        };
        let arm = [e1, e2, normal].map(|axis| of(&self.arm, axis));
        // dn = theta x n, de1 = theta x e1.
        let turn = [of(&self.normal, e2).map(|value| -value), of(&self.normal, e1), of(&self.forward, e2).map(|value| value / self.length)];
        (arm, turn)
    }
}
