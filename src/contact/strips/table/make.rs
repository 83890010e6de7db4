//! Making a table.

use super::super::fifths::{FIFTHS, Fifths};
use super::super::parts::{Part, Parts};
use super::super::pressed::Pressed;
use super::super::{RailStrips, Scratch, press_anywhere};
use super::column::{Column, Node};
use super::trust;
use super::{Axis, FEWEST, LEAN, LEVELS, MOST_LOAD, NUMBERS, OWN, PLACE, PatchTable, REACH, STEEL, STEEPEST, STEP, TURN, load_of};
use crate::contact::search::algebraic::Pair;
use crate::geometry::Side;
use crate::geometry::profile::{Profile, ProfilePoint};
use crate::geometry::surface::Wheel;
use crate::geometry::track::Rail;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::f64::consts::PI;
use std::sync::Arc;

/// Loads are met so well, in parts of them.
const MET: f64 = 1e-5;
const TRIES: usize = 30;
/// Nodes around a node that must be known where it is read: two are read, and over the others the weight of what is read falls.
const AROUND: usize = 4;
/// Distance at which outlines are looked at to find how high a wheel just touches, m.
const LOOKED: f64 = 5e-5;

/// A pair whose patches are to be tabulated.
#[derive(Clone, Debug)]
pub struct ToTabulate {
    pub strips: RailStrips,
    pub rail: Arc<dyn Profile>,
    pub wheel: Arc<dyn Profile>,
    /// Where the wheel stands in the middle of the track: across and lean as in [`super::Standing`].
    pub middle: (f64, f64),
}

impl ToTabulate {
    /// Is it made of the same objects? (Others may be equal: [`ToTabulate::key`].)
    pub fn is(&self, other: &ToTabulate) -> bool {
        Arc::ptr_eq(&self.rail, &other.rail)
            && Arc::ptr_eq(&self.wheel, &other.wheel)
            && self.middle == other.middle
            && self.strips == other.strips
    }

    /// What the table depends on: outlines, strips, place and grid.
    pub fn key(&self) -> String {
        let mut hash = Sha256::new();
        // Rounded: the last bits of a profile are the platform's, and an FMU finds its tables on each.
        let mut add = |value: f64| hash.update(((value / ROUNDED).round() as i64).to_le_bytes());
        [REACH, STEP, LEAN, TURN, FEWEST, MOST_LOAD, STEEPEST, VERSION, self.middle.0, self.middle.1].into_iter().for_each(&mut add);
        [LEVELS, NUMBERS].into_iter().for_each(|count| add(count as f64));
        for profile in [&self.rail, &self.wheel] {
            outline(profile.as_ref()).for_each(|(_, at)| [at.value, at.d1].into_iter().for_each(&mut add));
        }
        for k in 0..self.strips.len() {
            let strip = self.strips.strip(k);
            [strip.eta, strip.width].into_iter().for_each(&mut add);
        }
        hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect()
    }
}

/// A profile every [`LOOKED`].
fn outline(profile: &dyn Profile) -> impl Iterator<Item = (f64, ProfilePoint)> {
    let (first, last) = profile.range();
    let count = ((last - first) / LOOKED).ceil().max(1.0);
    (0..=count as usize).map(move |k| {
        let at = first + (last - first) * k as f64 / count;
        (at, profile.at(at))
    })
}

/// Lengths [m] and slopes that differ by less are the same.
const ROUNDED: f64 = 1e-9;
/// Counted up where the strips say something else.
const VERSION: f64 = 8.0;

impl PatchTable {
    /// Makes it on all threads; the same bits on any number of them.
    pub fn make(pair: &ToTabulate) -> PatchTable {
        let (across, lean) = (Axis::around(pair.middle.0, REACH, STEP), Axis::around(pair.middle.1, LEAN, TURN));
        let flat = Flat::new(pair);
        let mut columns: Vec<Column> = (0..across.count * lean.count)
            .into_par_iter()
            .map_init(
                || Scratch::new(pair.strips.len()),
                |scratch, k| flat.column(across.at(k / lean.count), lean.at(k % lean.count), scratch),
            )
            .collect();
        let heights: Vec<_> = columns.iter().map(|column| column.heights).collect();
        let known: Vec<usize> = heights.iter().map(|levels| levels.iter().take_while(|height| height.is_finite()).count()).collect();
        trust::note(&mut columns, &across, &lean, &known);
        let (places, fields) = columns.iter().flat_map(|column| column.nodes).unzip();
        // Cubic convolution at level s reads the levels from floor(s) - 1 to floor(s) + 2.
        let top = |k: usize| -> f32 {
            let (i, j) = (k / lean.count, k % lean.count);
            if i < AROUND || j < AROUND || i + AROUND >= across.count || j + AROUND >= lean.count {
                return 0.0;
            }
            let near = (i - AROUND..=i + AROUND).flat_map(|i| (j - AROUND..=j + AROUND).map(move |j| i * lean.count + j));
            near.map(|k| known[k]).min().unwrap_or(0).saturating_sub(2) as f32
        };
        let tops = (0..heights.len()).map(top).collect();
        let middle = |of: fn(&Node) -> f64| -> Vec<f32> {
            let node = |k: usize| columns[k].nodes[(LEVELS / 2).min(known[k].saturating_sub(1))];
            (0..columns.len()).map(|k| of(&node(k)) as f32).collect()
        };
        let middles = [middle(|node| node.0[0]), middle(|node| node.0[2]), middle(|node| f64::from(node.1[WHEEL_BEND]))];
        let radius = pair.wheel.at(0.0).value;
        PatchTable { across, lean, heights, places, fields, tops, middles, radius }
    }
}

const WHEEL_BEND: usize = 4;

/// The pair on straight track, the rail's section in the axes of its own.
pub(super) struct Flat<'a> {
    strips: &'a RailStrips,
    rail: Rail,
    wheel: Wheel,
    /// Outline of the wheel: u and R.
    outline: Vec<(f64, f64)>,
}

impl Flat<'_> {
    pub fn new(pair: &ToTabulate) -> Flat<'_> {
        let wheel = Wheel { side: Side::Left, profile: pair.wheel.clone(), half_spacing: 0.0 };
        let outline = outline(pair.wheel.as_ref()).map(|(u, at)| (u, at.value)).collect();
        Flat { strips: &pair.strips, rail: Rail::new(Side::Left, pair.rail.clone(), 0.0, 0.0, &[]), wheel, outline }
    }

    /// Height at which the wheel just touches.
    fn touching(&self, across: f64, lean: f64) -> f64 {
        let (sin, cos) = lean.sin_cos();
        let (first, last) = self.rail.profile.range();
        let of = |(u, radius): &(f64, f64)| {
            let place = across + u * cos + radius * sin;
            (first..=last).contains(&place).then(|| self.rail.profile.at(place).value + radius * cos - u * sin)
        };
        self.outline.iter().filter_map(of).fold(f64::NEG_INFINITY, f64::max)
    }

    fn column(&self, across: f64, lean: f64, scratch: &mut Scratch) -> Column {
        let mut column = Column { heights: [f64::NAN; LEVELS], nodes: [([0.0; PLACE], [0.0; NUMBERS]); LEVELS] };
        let axes = *Rotation3::from_axis_angle(&Vector3::x_axis(), lean).matrix();
        let touching = self.touching(across, lean);
        if !touching.is_finite() {
            return column;
        }
        let mut depth = 5e-6;
        for k in 0..LEVELS {
            let wanted = load_of(k as f64);
            let Some((found, node)) = self.under((wanted, MET), (across, touching), &axes, depth, scratch) else { break };
            (column.heights[k], column.nodes[k]) = (touching - found, node);
            depth = found * (load_of(k as f64 + 1.0) / wanted).powf(2.0 / 3.0);
        }
        column
    }

    /// Height [m] at which a wheel that stands across and leans like this carries a load, met to a part of it, and its patch; about how deep that may be, m.
    pub fn under_load(&self, load: f64, (across, lean): (f64, f64), met: f64, about: f64, scratch: &mut Scratch) -> Option<(f64, Node)> {
        let axes = *Rotation3::from_axis_angle(&Vector3::x_axis(), lean).matrix();
        let touching = Some(self.touching(across, lean)).filter(|height| height.is_finite())?;
        let (depth, node) = self.under((load, met), (across, touching), &axes, about, scratch)?;
        Some((touching - depth, node))
    }

    /// The depth under which the wheel carries a load, and its patch; `None` where it is not for the table.
    fn under(
        &self,
        (wanted, met): (f64, f64),
        (across, touching): (f64, f64),
        axes: &Matrix3<f64>,
        about: f64,
        scratch: &mut Scratch,
    ) -> Option<(f64, Node)> {
        let (mut depth, mut power) = (about, 1.5);
        let mut before: Option<(f64, f64)> = None;
        for _ in 0..TRIES {
            let centre = Vector3::new(0.0, across, touching - depth);
            let pair = Pair { wheel: &self.wheel, rail: &self.rail, centre: &centre, axes, distance: 0.0 };
            let pressed = press_anywhere(&pair, self.strips, STEEL, scratch);
            let load: f64 = pressed.iter().map(|own| own.load).sum();
            if !(load > 0.0) {
                depth += 1e-6;
                continue;
            }
            if (load / wanted - 1.0).abs() < met {
                let node = self.node(pressed, &centre)?;
                return Some((depth * (wanted / load).powf(1.0 / power), node));
            }
            if let Some((other, its)) = before
                && other != depth
                && its != load
            {
                power = ((load / its).ln() / (depth / other).ln()).clamp(1.0, 4.0);
            }
            before = Some((depth, load));
            depth *= (wanted / load).powf(1.0 / power).clamp(0.3, 3.0);
        }
        None
    }

    fn node(&self, pressed: &[Pressed], centre: &Vector3<f64>) -> Option<Node> {
        if self.strips.carries_beyond(STEEPEST, pressed) {
            return None;
        }
        let parts = Parts::new(pressed, self.strips, 1);
        let share = parts.share(pressed, 0, parts.len().checked_sub(1)?);
        let part = Part::new(share, self.strips, self.wheel.profile.as_ref(), STEEL);
        let fifths = Fifths::new(share, &part, Vector3::y());
        let mut fields = [0.0f32; NUMBERS];
        // Half lengths with the mean square of the ellipse's.
        let lengthening = (0.8 / part.mean_square).sqrt() * part.patch.a;
        let presses: f64 = pressed.iter().filter(|own| own.load > 0.0).map(|own| 2.0 * own.half_length * lengthening * own.width).sum();
        let excess = PI * part.patch.a * part.patch.b / presses - 1.0;
        let own =
            [1.0 - part.force / part.load, part.patch.a, part.patch.b, part.overlap, part.profiles[0].d2, part.profiles[1].d2, excess];
        for (field, value) in fields.iter_mut().zip(own) {
            *field = value as f32;
        }
        for (k, cell) in fifths.each.iter().enumerate() {
            for (i, value) in [cell.across, cell.above, cell.size].into_iter().enumerate() {
                fields[OWN + i * FIFTHS + k] = value as f32;
            }
        }
        Some(([centre.y + part.arm.y, centre.z + part.arm.z, part.normal.y.atan2(part.normal.z)], fields))
    }
}
