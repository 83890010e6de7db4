//! Loads and half lengths of the strips of one wheel.

use super::RailStrips;
use super::influence::Feeling;
use super::pressed::Pressed;
use super::strip::{Section, Strip};
use crate::contact::Material;
use crate::contact::search::algebraic::Pair;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Half lengths are at least this, m: at the edge of a patch they go to nothing.
const SHORTEST: f64 = 1.5e-4;
/// Sets of strips in contact that are tried; a few are enough.
const MOST_SETS: usize = 40;
/// What the fit of the influence (see [`super::influence`]) leaves out on average.
const FITTED: f64 = 0.996;

/// What one wheel's strips are found in; nothing in it outlasts a call.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    pressed: Vec<Pressed>,
    feeling: Feeling,
    /// Rows of K over the compliance, 1/m, for the strips that have been in contact.
    matrix: Vec<f64>,
    filled: Vec<bool>,
    /// Overlaps less what the lengths take, over the compliance, N/m.
    wanted: Vec<f64>,
    inside: Vec<bool>,
    touching: Vec<usize>,
    factor: Vec<f64>,
    loads: Vec<f64>,
    /// What is left of the overlaps, over the compliance, N/m.
    left: Vec<f64>,
    compliance: f64,
    moved: Vec<Pressed>,
}

impl Scratch {
    /// For rails of so many strips.
    pub fn new(strips: usize) -> Scratch {
        let reals = |count: usize| Vec::with_capacity(count);
        Scratch {
            pressed: Vec::with_capacity(strips),
            feeling: Feeling::new(strips),
            matrix: reals(strips * strips),
            filled: Vec::with_capacity(strips),
            wanted: reals(strips),
            inside: Vec::with_capacity(strips),
            touching: Vec::with_capacity(strips),
            factor: reals(strips * strips),
            loads: reals(strips),
            left: reals(strips),
            compliance: 0.0,
            moved: Vec::with_capacity(strips),
        }
    }
}

/// Finds the strips over which the wheel overlaps, around the rail coordinates `places` [m] at which it may, and what they carry.
///
/// The strips come in the order of their numbers, those without load among them.
pub fn press<'s>(
    pair: &Pair,
    rail: &RailStrips,
    places: impl Iterator<Item = f64>,
    material: Material,
    scratch: &'s mut Scratch,
) -> &'s [Pressed] {
    scratch.pressed.clear();
    let section = Section::new(pair);
    for eta in places {
        overlap_around(pair, rail, &section, rail.nearest(eta), &mut scratch.pressed);
    }
    scratch.pressed.sort_unstable_by_key(|strip| strip.number);
    scratch.press(rail, material)
}

/// The same where nothing is known: all strips are looked at.
pub fn press_anywhere<'s>(pair: &Pair, rail: &RailStrips, material: Material, scratch: &'s mut Scratch) -> &'s [Pressed] {
    scratch.pressed.clear();
    let section = Section::new(pair);
    for number in 0..rail.len() {
        let own = rail.strip(number);
        let found = Strip::new(pair, &section, (own.eta, &own.profile), None).filter(|strip| strip.overlap > 0.0);
        scratch.pressed.extend(found.map(|strip| Pressed { number, strip, width: own.width, ..Pressed::default() }));
    }
    scratch.press(rail, material)
}

/// Adds the strips on both sides of one as far as the wheel overlaps.
fn overlap_around(pair: &Pair, rail: &RailStrips, section: &Section, start: usize, pressed: &mut Vec<Pressed>) {
    let known = pressed.len();
    let mut add = |number: usize, near: Option<Strip>| {
        if pressed[..known].iter().any(|known| known.number == number) {
            return None;
        }
        let own = rail.strip(number);
        let found = Strip::new(pair, section, (own.eta, &own.profile), near).filter(|strip| strip.overlap > 0.0)?;
        pressed.push(Pressed { number, strip: found, width: own.width, ..Pressed::default() });
        Some(found)
    };
    // The deepest place may lie between two strips of which it is the neighbour that overlaps.
    let here = add(start, None);
    for up in [true, false] {
        let (mut last, mut number) = (here, start);
        loop {
            let next = if up { number + 1 } else { number.wrapping_sub(1) };
            if next >= rail.len() {
                break;
            }
            match add(next, last) {
                None if here.is_some() || number != start => break,
                found => (last, number) = (found, next),
            }
            if last.is_none() {
                break;
            }
        }
    }
}

/// Half lengths as in the Hertzian patch of the same proportions, and which strips carry load at first.
///
/// There `A a^2 + B b^2 = delta`, and the strip at the edge still overlaps by `e delta` with `e = A a^2 / delta`, a function of A / B alone that is
/// `1 / (1 + (A / B)^0.3)` to 0.013 from b/a = 1/20 to 20: `a_i^2 = 2 e (d_i - e delta) / ((1 - e) kappa_i)`. B and delta are those of the parabola with
/// the same sums of d and d^2 over what is near; A is kappa / 2.
fn lengthen(rail: &RailStrips, scratch: &mut Scratch) {
    let Scratch { pressed, inside, .. } = scratch;
    inside.clear();
    for k in 0..pressed.len() {
        let (mut first, mut second) = (0.0, 0.0);
        for other in pressed.iter() {
            let weight = rail.nearness(pressed[k].number, other.number) * other.width * other.strip.overlap;
            (first, second) = (first + weight, second + weight * other.strip.overlap);
        }
        let own = &mut pressed[k];
        // 5/4 of the ratio is delta, and 4/3 delta sqrt(delta / B) the first sum.
        let deepest = 1.25 * second / first;
        let half_width = 0.75 * first / deepest;
        let edge = 1.0 / (1.0 + (0.5 * own.strip.curvature * half_width * half_width / deepest).powf(0.3));
        let above = own.strip.overlap - edge * deepest;
        inside.push(above > 0.0);
        own.half_length = (2.0 * edge * above.max(0.0) / ((1.0 - edge) * own.strip.curvature)).sqrt().max(SHORTEST);
    }
}

/// The loads: none pulls, and no strip without load overlaps.
fn carry(rail: &RailStrips, scratch: &mut Scratch) {
    let Scratch { pressed, feeling, matrix, filled, wanted, inside, touching, factor, loads, left, compliance, .. } = scratch;
    let count = pressed.len();
    feeling.fill(pressed);
    matrix.clear();
    matrix.resize(count * count, 0.0);
    filled.clear();
    filled.resize(count, false);
    wanted.clear();
    let less = |own: &Pressed| own.strip.curvature * own.half_length * own.half_length / 8.0;
    wanted.extend(pressed.iter().map(|own| (own.strip.overlap - less(own)) / *compliance));
    for _ in 0..MOST_SETS {
        touching.clear();
        touching.extend((0..count).filter(|k| inside[*k]));
        for k in touching.iter() {
            if !filled[*k] {
                feeling.row(rail, *k, matrix, filled);
                filled[*k] = true;
            }
        }
        solve(matrix, count, touching, wanted, factor, loads);
        let pulls = loads.iter().any(|load| *load < 0.0);
        for (k, load) in touching.iter().zip(loads.iter()) {
            inside[*k] = *load >= 0.0;
        }
        if pulls {
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
        for (inside, left) in inside.iter_mut().zip(left.iter()) {
            if !*inside && *left > 0.0 {
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
fn solve(matrix: &[f64], count: usize, touching: &[usize], wanted: &[f64], factor: &mut Vec<f64>, loads: &mut Vec<f64>) {
    let n = touching.len();
    factor.clear();
    for (i, k) in touching.iter().enumerate() {
        let row = &matrix[k * count..(k + 1) * count];
        factor.extend(std::iter::repeat_n(0.0, i));
        factor.extend(touching[i..].iter().map(|j| row[*j]));
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
    for i in 0..n {
        let row = &factor[i * n..(i + 1) * n];
        let load = loads[i] / row[i];
        loads[i] = load;
        for (other, by) in loads[i + 1..].iter_mut().zip(&row[i + 1..]) {
            *other -= by * load;
        }
    }
    for i in (0..n).rev() {
        let row = &factor[i * n..(i + 1) * n];
        let known: f64 = row[i + 1..].iter().zip(&loads[i + 1..]).map(|(a, b)| a * b).sum();
        loads[i] = (loads[i] - known) / row[i];
    }
}

impl Scratch {
    /// Finds what the strips carry over which the wheel overlaps.
    fn press(&mut self, rail: &RailStrips, material: Material) -> &[Pressed] {
        lengthen(rail, self);
        self.compliance = FITTED * (1.0 - material.poisson_ratio) / (PI * material.shear_modulus());
        carry(rail, self);
        &self.pressed
    }

    /// Elastic energy of the patch that was pressed last, J: `1/2 sum Q (d - kappa a^2 / 8)`, the least value of Pi with the other sign.
    pub fn energy(&self) -> f64 {
        0.5 * self.compliance * self.pressed.iter().zip(&self.wanted).map(|(own, wanted)| own.load * wanted).sum::<f64>()
    }

    /// The strips that were pressed last as they are, to first order, after the wheelset has moved by `way` [m] and turned by `turn` [rad].
    ///
    /// Each overlap changes by `-against . (way + turn x r)`, since its place is stationary. Loads follow with the strips in contact and their half lengths
    /// as they are, `growth` times: lengths grow with the load, which makes a patch stiffer.
    pub fn moved(&mut self, way: &Vector3<f64>, turn: &Vector3<f64>, growth: f64) -> &[Pressed] {
        self.moved.clear();
        self.moved.extend_from_slice(&self.pressed);
        let deeper = |strip: &Strip| -strip.against.dot(&(way + turn.cross(&strip.point)));
        self.loads.clear();
        self.loads.extend(self.touching.iter().map(|k| growth * deeper(&self.pressed[*k].strip) / self.compliance));
        substitute(&self.factor, &mut self.loads);
        for own in &mut self.moved {
            own.strip.overlap += deeper(&own.strip);
            own.strip.point -= way;
        }
        for (k, load) in self.touching.iter().zip(&self.loads) {
            self.moved[*k].load += load;
        }
        &self.moved
    }
}
