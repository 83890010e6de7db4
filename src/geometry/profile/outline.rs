//! From the pieces of a drawing to a profile without steps and kinks.
//!
//! Published definitions are rounded: their pieces miss each other by nanometres to micrometres and meet at
//! small angles. Contact forces and contact searches feel both, so three treatments make the profile C1 to
//! rounding; each says how much it has changed.
//! 1. [`Outline::cut_steep`]: ends that are steeper than a limit are cut (a vertical tangent has no finite slope).
//! 2. [`Outline::close`]: at each joint one of the two pieces, the softer or else the shorter one, gets a cubic
//!    (a straight line where its other end is free) that takes up the step, and the angle where it is small.
//! 3. [`Outline::round`]: what remains as an angle is rounded over the length that a fillet of a given radius
//!    would take between straight lines, by a cubic in the lateral coordinate that leaves both neighbours
//!    tangentially. Between arcs its curvature is about the fillet's and the arcs' together.

use super::piecewise::{Curve, Piece, hermite};

/// The pieces of a drawing, from left to right, m.
#[derive(Clone, Debug, Default)]
pub(super) struct Outline {
    pieces: Vec<Piece>,
    soft: Vec<bool>,
}

/// The largest changes made, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Changes {
    /// Largest correction of a piece, m.
    pub closing: f64,
    /// Largest distance of a fillet from the corner that it replaces, m.
    pub rounding: f64,
}

/// Pieces narrower than this are vertical lines of the drawing, m.
const NARROWEST: f64 = 1e-6;

impl Outline {
    /// Adds a piece; `soft` marks those that are to give way at joints.
    pub(super) fn push(&mut self, from: f64, to: f64, curve: Curve, soft: bool) {
        if to - from > NARROWEST {
            // Coordinates of a drawing meet exactly or not at all.
            let from = self.pieces.last().map_or(from, |last| last.to);
            self.pieces.push(Piece { from, to, curve });
            self.soft.push(soft);
        }
    }

    /// Cuts both ends where |slope| exceeds `limit`.
    pub(super) fn cut_steep(&mut self, limit: f64) {
        let steep = |piece: &Piece, x: f64| !(piece.curve.at(x).d1.abs() <= limit);
        while self.pieces.first().is_some_and(|piece| steep(piece, piece.to)) {
            self.pieces.remove(0);
            self.soft.remove(0);
        }
        while self.pieces.last().is_some_and(|piece| steep(piece, piece.from)) {
            self.pieces.pop();
            self.soft.pop();
        }
        let bisect = |piece: &Piece, mut inside: f64, mut outside: f64| {
            for _ in 0..60 {
                let middle = 0.5 * (inside + outside);
                *(if steep(piece, middle) { &mut outside } else { &mut inside }) = middle;
            }
            inside
        };
        if let Some(piece) = self.pieces.first_mut().filter(|piece| steep(piece, piece.from)) {
            piece.from = bisect(piece, piece.to, piece.from);
        }
        if let Some(piece) = self.pieces.last_mut().filter(|piece| steep(piece, piece.to)) {
            piece.to = bisect(piece, piece.from, piece.to);
        }
    }

    /// Takes up all steps, and the angles below `small_angle` [rad].
    pub(super) fn close(&mut self, small_angle: f64) -> Changes {
        let count = self.pieces.len();
        // Wanted change of (value, slope) at begin and end of each piece; `None` where nothing asks for one.
        let mut begin = vec![None; count];
        let mut end = vec![None; count];
        for i in 1..count {
            let (left, right) = (&self.pieces[i - 1], &self.pieces[i]);
            let x = left.to;
            let (a, b) = (left.curve.at(x), right.curve.at(x));
            let step = b.value - a.value;
            let slope = if (b.d1.atan() - a.d1.atan()).abs() < small_angle { b.d1 - a.d1 } else { 0.0 };
            let right_gives_way = match (self.soft[i - 1], self.soft[i]) {
                (false, true) => true,
                (true, false) => false,
                _ => right.to - right.from < left.to - left.from,
            };
            let none = Some((0.0, 0.0));
            (end[i - 1], begin[i]) = if right_gives_way { (none, Some((-step, -slope))) } else { (Some((step, slope)), none) };
        }
        let mut changes = Changes::default();
        for (i, piece) in self.pieces.iter_mut().enumerate() {
            let length = piece.to - piece.from;
            let cubic = match (begin[i], end[i]) {
                (None, None) => continue,
                (Some(begin), Some(end)) => hermite(length, begin, end),
                (Some(begin), None) => [begin.0, begin.1, 0.0, 0.0],
                (None, Some(end)) => [end.0 - length * end.1, end.1, 0.0, 0.0],
            };
            let [c0, c1, c2, c3] = cubic;
            let largest = (0..=20).map(|k| f64::from(k) / 20.0 * length).map(|t| (c0 + t * (c1 + t * (c2 + t * c3))).abs());
            changes.closing = largest.fold(changes.closing, f64::max);
            if cubic != [0.0; 4] {
                piece.curve.add(piece.from, cubic);
            }
        }
        changes
    }

    /// Rounds the angles above `least` [rad] by fillets of `radius` [m]; a fillet takes at most 40 % of a neighbour.
    pub(super) fn round(&mut self, least: f64, radius: f64) -> Changes {
        let mut changes = Changes::default();
        let lengths: Vec<f64> = self.pieces.iter().map(|piece| piece.to - piece.from).collect();
        let mut rounded: Vec<Piece> = Vec::with_capacity(2 * self.pieces.len());
        for (i, piece) in self.pieces.iter().enumerate() {
            let mut piece = piece.clone();
            if let Some(left) = rounded.last_mut() {
                let corner = piece.from;
                let (before, after) = (left.curve.at(corner), piece.curve.at(corner));
                let (a, b) = (before.d1.atan(), after.d1.atan());
                if (b - a).abs() > least {
                    let tangent = radius * (0.5 * (b - a).abs()).tan();
                    left.to = corner - (tangent * a.cos()).min(0.4 * lengths[i - 1]);
                    piece.from = corner + (tangent * b.cos()).min(0.4 * lengths[i]);
                    let (p, q) = (left.curve.at(left.to), piece.curve.at(piece.from));
                    let fillet = Curve::hermite((left.to, p.value, p.d1), (piece.from, q.value, q.d1));
                    let miss = (fillet.at(corner).value - before.value) * (0.5 * (a + b)).cos();
                    changes.rounding = changes.rounding.max(miss.abs());
                    let fillet = Piece { from: left.to, to: piece.from, curve: fillet };
                    rounded.push(fillet);
                }
            }
            rounded.push(piece);
        }
        self.soft = vec![false; rounded.len()];
        self.pieces = rounded;
        changes
    }

    /// Value at `x`, of the piece that holds it.
    pub(super) fn value(&self, x: f64) -> Option<f64> {
        self.pieces.iter().find(|piece| (piece.from..=piece.to).contains(&x)).map(|piece| piece.curve.at(x).value)
    }

    /// The pieces, moved by (`dx`, `dy`).
    pub(super) fn moved(self, dx: f64, dy: f64) -> Vec<Piece> {
        let mut pieces: Vec<Piece> = self
            .pieces
            .into_iter()
            .map(|piece| Piece { from: piece.from + dx, to: piece.to + dx, curve: piece.curve.moved(dx, dy) })
            .collect();
        // Rounding of the two sums must leave no gap.
        for i in 1..pieces.len() {
            pieces[i].from = pieces[i - 1].to;
        }
        pieces
    }
}
