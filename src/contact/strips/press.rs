//! Loads and half lengths of the strips of one wheel.

use super::RailStrips;
use super::bearing::Bearing;
use super::cut::BESIDE;
use super::influence::Feeling;
use super::lengths::Lengths;
use super::pressed::Pressed;
use super::strip::{Section, Strip};
use crate::contact::Material;
use crate::contact::search::algebraic::Pair;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

/// Sets of strips in contact that are tried; a few are enough.
const MOST_SETS: usize = 40;
/// Sections from which a strip on a sharp bend is looked at, and how near to its place the last must stand, m.
const MOST_STATIONS: usize = 12;
const ABOUT_THERE: f64 = 2e-3;
/// Places along the track at which one is looked for there, to each side, and their distance, m.
const STARTS: i32 = 5;
const STARTS_APART: f64 = 0.02;
/// What the fit of the influence (see [`super::influence`]) leaves out on average.
const FITTED: f64 = 0.996;

/// What one wheel's strips are found in; holds the last that was pressed.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    pressed: Vec<Pressed>,
    lengths: Lengths,
    feeling: Feeling,
    /// Rows of K over the compliance, 1/m, for the strips that have been in contact.
    matrix: Vec<f64>,
    filled: Vec<bool>,
    /// Overlaps less what the lengths take, over the compliance, N/m.
    wanted: Vec<f64>,
    /// How strips carry that are pressed over a part of their width.
    bearings: Vec<Bearing>,
    inside: Vec<bool>,
    touching: Vec<usize>,
    factor: Vec<f64>,
    loads: Vec<f64>,
    /// What is left of the overlaps, over the compliance, N/m.
    left: Vec<f64>,
    compliance: f64,
    /// Where the wheelset was, and its distance.
    pose: Option<(Vector3<f64>, Matrix3<f64>, f64)>,
    /// Do rails stay where they are, so that what was pressed in a pose still is in the same pose?
    pub rails_stay: bool,
}

impl Scratch {
    /// For rails of so many strips.
    pub fn new(strips: usize) -> Scratch {
        let reals = |count: usize| Vec::with_capacity(count);
        Scratch {
            pressed: Vec::with_capacity(strips),
            lengths: Lengths::new(strips),
            feeling: Feeling::new(strips),
            matrix: reals(strips * strips),
            filled: Vec::with_capacity(strips),
            wanted: reals(strips),
            bearings: Vec::with_capacity(strips),
            inside: Vec::with_capacity(strips),
            touching: Vec::with_capacity(strips),
            factor: reals(strips * strips),
            loads: reals(strips),
            left: reals(strips),
            compliance: 0.0,
            pose: None,
            rails_stay: false,
        }
    }
}

/// Where a wheel may overlap, m: rail coordinate, how far ahead of the wheelset's centre, and by about how much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    pub eta: f64,
    pub lead: f64,
    pub overlap: f64,
}

/// Finds the strips over which the wheel overlaps, around the `places` at which it may, and what they carry.
///
/// The strips come in the order of their numbers, those without load among them, and on each side of those that overlap (or nearly do, by [`BESIDE`]) one that does not.
pub fn press<'s>(
    pair: &Pair,
    rail: &RailStrips,
    places: impl Iterator<Item = Near>,
    material: Material,
    scratch: &'s mut Scratch,
) -> &'s [Pressed] {
    let overlaps = Overlaps::new(pair, rail);
    let pressed = &mut scratch.pressed;
    pressed.clear();
    for Near { eta, lead, overlap } in places {
        // On the flange of a yawed wheel the place lies tens of millimetres ahead: from beside the centre it is not found.
        let (nearest, near) = (rail.nearest(eta), (lead, overlap));
        match pressed.iter().find(|known| known.number == nearest) {
            None => overlaps.join(nearest, near, pressed),
            // The place lies beside the end of an earlier one.
            Some(end) if !(end.strip.overlap > -BESIDE) => {
                [nearest.wrapping_sub(1), nearest + 1].iter().for_each(|start| overlaps.join(*start, near, pressed))
            }
            Some(_) => {}
        }
    }
    scratch.press(pair, rail, material)
}

/// The same where nothing is known: all strips are looked at.
pub fn press_anywhere<'s>(pair: &Pair, rail: &RailStrips, material: Material, scratch: &'s mut Scratch) -> &'s [Pressed] {
    let overlaps = Overlaps::new(pair, rail);
    let Scratch { pressed, inside, .. } = scratch;
    pressed.clear();
    pressed.extend((0..rail.len()).filter_map(|number| overlaps.strip_anywhere(number)));
    let kept = |k: usize| (k.saturating_sub(1)..=k + 1).filter_map(|beside| pressed.get(beside)).any(|own| own.strip.overlap > -BESIDE);
    inside.clear();
    inside.extend((0..pressed.len()).map(kept));
    let mut kept = inside.iter();
    pressed.retain(|_| kept.next().is_some_and(|kept| *kept));
    scratch.press(pair, rail, material)
}

/// A wheel over a rail's strips.
struct Overlaps<'a> {
    pair: &'a Pair<'a>,
    rail: &'a RailStrips,
    section: Section,
    /// Does the rail bend sideways sharply?
    sharp: bool,
}

impl<'a> Overlaps<'a> {
    fn new(pair: &'a Pair<'a>, rail: &'a RailStrips) -> Self {
        Overlaps { pair, rail, section: Section::new(pair), sharp: pair.is_on_sharp_bend() }
    }

    /// A strip over which the wheel stands, from about where it is (lead and overlap, m).
    #[inline]
    fn strip(&self, number: usize, about: (f64, f64)) -> Option<Pressed> {
        let own = self.rail.strip(number);
        let strip = if self.sharp {
            self.strip_ahead(number, about)?
        } else {
            Strip::new(self.pair, &self.section, (own.eta, &own.profile), about)?
        };
        Some(Pressed { number, strip, width: own.width, ..Pressed::default() })
    }

    /// A strip of which nothing is known; on a rail that bends sideways sharply the deepest of its places.
    fn strip_anywhere(&self, number: usize) -> Option<Pressed> {
        if !self.sharp {
            return self.strip(number, (0.0, 0.0));
        }
        let starts = (-STARTS..=STARTS).map(|k| (f64::from(k) * STARTS_APART, 0.0));
        let found = starts.filter_map(|about| self.strip(number, about));
        found.reduce(|a, b| if b.strip.overlap > a.strip.overlap { b } else { a })
    }

    /// A strip on a rail that bends sideways sharply: seen from the section at the strip's own place.
    fn strip_ahead(&self, number: usize, (mut lead, mut overlap): (f64, f64)) -> Option<Strip> {
        let own = self.rail.strip(number);
        for _ in 0..MOST_STATIONS {
            let station = lead;
            let section = Section::ahead(self.pair, station);
            let mut strip = Strip::new(self.pair, &section, (own.eta, &own.profile), (0.0, overlap))?;
            strip.lead += station;
            if (strip.lead - station).abs() < ABOUT_THERE {
                return Some(strip);
            }
            (lead, overlap) = (strip.lead, strip.overlap);
        }
        None
    }

    /// Adds those around a strip that is not among them yet to strips in the order of their numbers.
    fn join(&self, start: usize, near: (f64, f64), pressed: &mut Vec<Pressed>) {
        if start >= self.rail.len() || pressed.iter().any(|known| known.number == start) {
            return;
        }
        let known = pressed.len();
        self.around(start, near, pressed);
        let before = pressed[..known].iter().filter(|own| own.number < start).count();
        pressed[before..].rotate_left(known - before);
    }

    /// Adds the strips on both sides of one up to the first over which the wheel is well off the rail, in the order of their numbers.
    fn around(&self, start: usize, near: (f64, f64), pressed: &mut Vec<Pressed>) {
        let first = pressed.len();
        let here = self.strip(start, near);
        pressed.extend(here);
        // Inwards; where the deepest place lies between two strips its neighbour may be the one that overlaps.
        self.along((0..start).rev(), near, first, pressed);
        pressed[first..].reverse();
        self.along(start + 1..self.rail.len(), near, first, pressed);
    }

    /// Adds strips after those from `first` on, up to one over which the wheel is well off the rail, or one which stands before.
    #[inline]
    fn along(&self, numbers: impl Iterator<Item = usize>, near: (f64, f64), first: usize, pressed: &mut Vec<Pressed>) {
        for number in numbers {
            if pressed[..first].iter().any(|known| known.number == number) {
                break;
            }
            let Some(found) = self.strip(number, about(&pressed[first..]).unwrap_or(near)) else { break };
            pressed.push(found);
            if !(found.strip.overlap > -BESIDE) {
                break;
            }
        }
    }
}

/// Lead and overlap of the strip after these, by the parabola through the last three; `None` where there are none.
#[inline]
fn about(found: &[Pressed]) -> Option<(f64, f64)> {
    let of = |own: &Pressed| (own.strip.lead, own.strip.overlap);
    match found {
        [.., a, b, c] if (a.width - c.width).abs() < 0.1 * c.width => {
            let (a, b, c) = (of(a), of(b), of(c));
            Some((3.0 * (c.0 - b.0) + a.0, 3.0 * (c.1 - b.1) + a.1))
        }
        [.., last] => Some(of(last)),
        [] => None,
    }
}

/// The loads: none pulls, and no strip without load overlaps.
fn carry(rail: &RailStrips, scratch: &mut Scratch) {
    let Scratch { pressed, lengths, feeling, matrix, filled, wanted, bearings, inside, touching, factor, loads, left, compliance, .. } =
        scratch;
    let count = pressed.len();
    feeling.fill(rail, pressed);
    // What is left of another pose is not read: rows are filled first.
    matrix.resize(count * count, 0.0);
    filled.clear();
    filled.resize(count, false);
    bearings.clear();
    bearings.extend(pressed.iter().zip(&lengths.covers).map(|(own, cover)| Bearing::new(own, cover, *compliance)));
    wanted.clear();
    wanted.extend(bearings.iter().map(Bearing::wanted));
    for _ in 0..MOST_SETS {
        touching.clear();
        touching.extend((0..count).filter(|k| inside[*k]));
        for k in touching.iter() {
            if !filled[*k] {
                feeling.row(rail, &lengths.arcs, *k, matrix, filled);
                filled[*k] = true;
            }
        }
        solve(matrix, count, touching, (wanted, bearings), factor, loads);
        let mut others = false;
        for (k, load) in touching.iter().zip(loads.iter()) {
            let bearing = &mut bearings[*k];
            let settled = bearing.settle(*load, matrix[k * count + k]);
            inside[*k] = settled || *load >= 0.0;
            if !inside[*k] {
                bearing.leave();
            }
            wanted[*k] = bearing.wanted();
            others |= settled || *load < 0.0;
        }
        if others {
            continue;
        }
        // What is left of each overlap: rows are added, since columns of strips without load are not known.
        left.clear();
        left.extend_from_slice(wanted);
        for (k, load) in touching.iter().zip(loads.iter()) {
            for (left, felt) in left.iter_mut().zip(&matrix[k * count..(k + 1) * count]) {
                *left -= felt * load;
            }
        }
        let mut overlaps = false;
        for ((inside, left), own) in inside.iter_mut().zip(left.iter()).zip(pressed.iter()) {
            if !*inside && *left > 0.0 && own.depth > 0.0 {
                (*inside, overlaps) = (true, true);
            }
        }
        if !overlaps {
            break;
        }
    }
    pressed.iter_mut().for_each(|strip| strip.load = 0.0);
    for (k, load) in touching.iter().zip(loads.iter()) {
        pressed[*k].load = load.max(0.0);
    }
}

/// Solves K Q = wanted for the strips that touch: Cholesky's upper factor, row by row, so that the inner loops run along rows.
fn solve(
    matrix: &[f64],
    count: usize,
    touching: &[usize],
    (wanted, bearings): (&[f64], &[Bearing]),
    factor: &mut Vec<f64>,
    loads: &mut Vec<f64>,
) {
    let n = touching.len();
    factor.clear();
    for (i, k) in touching.iter().enumerate() {
        let row = &matrix[k * count..(k + 1) * count];
        factor.extend(std::iter::repeat_n(0.0, i));
        factor.push(row[*k] / bearings[*k].stiffness());
        factor.extend(touching[i + 1..].iter().map(|j| row[*j]));
    }
    for i in 0..n {
        let (above, below) = factor.split_at_mut((i + 1) * n);
        let row = &mut above[i * n..];
        // K is positive definite; its fit may bring a pivot to nothing where strips are very short.
        let own = matrix[touching[i] * count + touching[i]];
        let scale = 1.0 / row[i].max(1e-6 * own).sqrt();
        row[i..].iter_mut().for_each(|value| *value *= scale);
        row[i] = 1.0 / scale;
        for (j, other) in (i + 1..n).zip(below.chunks_exact_mut(n)) {
            let by = row[j];
            for (value, own) in other[j..].iter_mut().zip(&row[j..]) {
                *value -= by * own;
            }
        }
    }
    loads.clear();
    loads.extend(touching.iter().map(|k| wanted[*k]));
    substitute(factor, loads);
}

/// Forward and back.
fn substitute(factor: &[f64], loads: &mut [f64]) {
    let n = loads.len();
    for (i, row) in factor.chunks_exact(n.max(1)).enumerate() {
        let (before, behind) = loads.split_at_mut(i + 1);
        let load = before[i] / row[i];
        before[i] = load;
        for (other, by) in behind.iter_mut().zip(&row[i + 1..]) {
            *other -= by * load;
        }
    }
    for (i, row) in factor.chunks_exact(n.max(1)).enumerate().rev() {
        let (before, behind) = loads.split_at_mut(i + 1);
        let mut known = 0.0;
        for (a, b) in row[i + 1..].iter().zip(behind.iter()) {
            known += a * b;
        }
        before[i] = (before[i] - known) / row[i];
    }
}

impl Scratch {
    /// Finds what the strips carry over which the wheel overlaps.
    fn press(&mut self, pair: &Pair, rail: &RailStrips, material: Material) -> &[Pressed] {
        self.pose = Some((*pair.centre, *pair.axes, pair.distance));
        self.lengths.find(rail, &mut self.pressed, &mut self.inside);
        self.compliance = FITTED * (1.0 - material.poisson_ratio) / (PI * material.shear_modulus());
        carry(rail, self);
        &self.pressed
    }

    /// Was the wheel in this pose when it was pressed last?
    pub fn is_of(&self, pair: &Pair) -> bool {
        self.pose == Some((*pair.centre, *pair.axes, pair.distance))
    }

    /// The strips that were pressed last.
    pub fn pressed(&self) -> &[Pressed] {
        &self.pressed
    }

    /// Elastic energy of the patch that was pressed last, J: `1/2 sum Q (d - kappa a^2 / 8)`, each spring of a strip by its own overlap; the least value of Pi with the other sign.
    pub fn energy(&self) -> f64 {
        let count = self.pressed.len();
        let of = |k: usize| {
            let load = self.pressed[k].load;
            if load > 0.0 { load * self.wanted[k] + self.bearings[k].apart(self.matrix[k * count + k]) } else { 0.0 }
        };
        0.5 * self.compliance * (0..count).map(of).sum::<f64>()
    }
}
