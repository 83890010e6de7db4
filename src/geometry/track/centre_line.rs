//! The centre line as a space curve over its arc length, and the track frame on it.
//!
//! Heading psi, climb g (angle of the grade) and cant f are given along the arc length s: `psi' = curvature(s)`, all three linear
//! between nodes with rounded corners ([`super::ramp`]), so that heading and climb are polynomials piece by piece. The
//! tangent is `(cos g cos psi, cos g sin psi, sin g)`, of length 1: s is the arc length of the space curve (on a grade the radius
//! seen from above is cos g times smaller than 1 / curvature: 5e-5 at 1 %). The position is the tangent's integral,
//! in closed form where curvature and climb are constant (a circle or a helix of any length), elsewhere from Chebyshev polynomials
//! that interpolate the tangent on pieces that turn by at most a quarter of a radian: their error is below rounding
//! (1e-18 of the piece's length), so values and derivatives agree to rounding and an evaluation costs the same anywhere.
//!
//! A superelevation is a pure roll of the sections about the centre line; about the low rail the centre line also rises by half the
//! superelevation, base / 2 times the cant angle (its height is base / 2 sin: 0.02 mm less at 75 mm), which is added to
//! the climb; the low rail then moves sideways by base / 2 (1 - cos f), 1 mm at 75 mm.

use super::frame::{Angle, TrackFrame};
use super::ramp::{Polynomial, Ramp};
use super::waves::Stretch;
use nalgebra::{Matrix3, Vector3};

/// One node of the alignment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Node {
    /// s, m.
    pub distance: f64,
    /// 1/m, left-hand curve positive.
    pub curvature: f64,
    /// Angle of the cant, rad, left rail up positive.
    pub superelevation: f64,
    /// Angle of the grade, rad, climbing positive.
    pub grade: f64,
}

/// About which line the sections roll.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Pivot {
    #[default]
    Centre,
    /// The lower rail; with the distance of the rails' nominal contact points, m.
    LowRail { base: f64 },
}

/// What a centre line is made from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Alignment {
    /// By ascending distance.
    pub nodes: Vec<Node>,
    /// Length over which corners of the table are rounded, m.
    pub smoothing: f64,
    pub pivot: Pivot,
}

/// Corners of the superelevation are rounded over at least this length, m: a rail has no kinks.
pub const LEAST_ROUNDING: f64 = 2.0;

/// Tangents on a piece, and one less than the coefficients of its position.
const ORDER: usize = 10;
/// Largest turn of heading and climb on a piece whose position is a polynomial, rad.
const TURN: f64 = 0.25;
/// Distances that are nearer than this are one, m.
const SAME: f64 = 1e-9;
/// A step of a projection, m, after which the next would be rounding: it converges quadratically, and no track turns by more than 1 rad/m.
const LAST_STEP: f64 = 1e-8;

/// A centre line.
#[derive(Clone, Debug)]
pub struct CentreLine {
    pieces: Vec<Piece>,
    /// It is X itself as far as there, m.
    x_until: f64,
    /// The piece in which each of equal stretches from `first` on begins.
    bins: Vec<u32>,
    first: f64,
    bins_per_metre: f64,
    breaks: Vec<f64>,
    /// Where curvature, grade or cant change.
    waves: Vec<Stretch>,
}

#[derive(Clone, Debug)]
struct Piece {
    from: f64,
    to: f64,
    /// Where the polynomials count from, m.
    middle: f64,
    degree: usize,
    heading: Polynomial,
    climb: Polynomial,
    cant: Polynomial,
    path: Path,
    form: Form,
}

/// What the frames of a piece have in common.
#[derive(Clone, Debug)]
enum Form {
    /// Nothing turns: all but distance and origin.
    Straight(TrackFrame),
    /// Climb and cant.
    Even(Angle, Angle),
    Any,
}

#[derive(Clone, Debug)]
enum Path {
    /// Constant curvature and climb, through this point at the middle.
    Arc(Vector3<f64>),
    /// Half the piece's length and coefficients of Chebyshev polynomials.
    Table(f64, Box<[Vector3<f64>; ORDER + 1]>),
}

impl Piece {
    fn tangent(&self, s: f64) -> Vector3<f64> {
        let [psi, g] = [&self.heading, &self.climb].map(|p| p.jet(s - self.middle, 7)[0]);
        Vector3::new(g.cos() * psi.cos(), g.cos() * psi.sin(), g.sin())
    }

    /// Finds the form of a piece that lies where it stays.
    fn note_form(&mut self) {
        self.form = match [&self.heading, &self.climb, &self.cant].map(Polynomial::degree) {
            [0, 0, 0] => Form::Straight(self.any_frame(self.middle)),
            [_, 0, 0] => {
                let [climb, cant] = [&self.climb, &self.cant].map(|p| Angle::new(p.jet(0.0, 0)));
                Form::Even(climb, cant)
            }
            _ => Form::Any,
        };
    }

    fn angle(&self, p: &Polynomial, s: f64) -> Angle {
        Angle::new(p.jet(s - self.middle, self.degree))
    }

    fn any_frame(&self, s: f64) -> TrackFrame {
        let [heading, climb, cant] = [&self.heading, &self.climb, &self.cant].map(|p| self.angle(p, s));
        TrackFrame::new(s, self.position(s), &heading, &climb, &cant)
    }

    /// The track frame at distance `s` [m].
    #[inline]
    fn frame(&self, s: f64) -> TrackFrame {
        match &self.form {
            Form::Straight(frame) => TrackFrame { distance: s, origin: frame.origin + frame.along() * (s - self.middle), ..*frame },
            Form::Even(climb, cant) => TrackFrame::new(s, self.position(s), &self.angle(&self.heading, s), climb, cant),
            Form::Any => self.any_frame(s),
        }
    }

    #[inline]
    fn position(&self, s: f64) -> Vector3<f64> {
        let ahead = s - self.middle;
        match &self.path {
            Path::Arc(origin) => origin + self.chord(ahead),
            Path::Table(half, coefficients) => {
                let u2 = 2.0 * ahead / half;
                let (mut next, mut after) = (Vector3::zeros(), Vector3::zeros());
                for c in coefficients[1..].iter().rev() {
                    (next, after) = (c + next * u2 - after, next);
                }
                coefficients[0] + next * (0.5 * u2) - after
            }
        }
    }

    /// From the middle along a helix.
    #[inline]
    fn chord(&self, ahead: f64) -> Vector3<f64> {
        let half_turn = 0.5 * self.heading.0[1] * ahead;
        let length = if half_turn == 0.0 { ahead } else { ahead * half_turn.sin() / half_turn };
        let (sin, cos) = (self.heading.0[0] + half_turn).sin_cos();
        let (climb, level) = self.climb.0[0].sin_cos();
        Vector3::new(level * length * cos, level * length * sin, climb * ahead)
    }

    /// Makes the path begin at `at`; its end is returned.
    fn lay(&mut self, at: Vector3<f64>) -> Vector3<f64> {
        if self.heading.degree() <= 1 && self.climb.degree() == 0 {
            self.path = Path::Arc(at - self.chord(self.from - self.middle));
            return self.position(self.to);
        }
        let half = 0.5 * (self.to - self.from);
        let angle = |j: usize| std::f64::consts::PI * (j as f64 + 0.5) / ORDER as f64;
        let tangents: Vec<_> = (0..ORDER).map(|j| self.tangent(self.middle + half * angle(j).cos())).collect();
        let mut slopes = [Vector3::zeros(); ORDER + 2];
        for (k, slope) in slopes.iter_mut().enumerate().take(ORDER) {
            *slope = (0..ORDER).map(|j| tangents[j] * (2.0 / ORDER as f64 * (k as f64 * angle(j)).cos())).sum();
        }
        // Integral of T_k: (T_(k+1) / (k + 1) - T_(k-1) / (k - 1)) / 2.
        let mut path = [Vector3::zeros(); ORDER + 1];
        for k in 1..=ORDER {
            path[k] = (slopes[k - 1] - slopes[k + 1]) * (half / (2 * k) as f64);
        }
        self.path = Path::Table(half, Box::new(path));
        let shift = at - self.position(self.from);
        self.shift(&shift);
        self.position(self.to)
    }

    fn shift(&mut self, by: &Vector3<f64>) {
        match &mut self.path {
            Path::Arc(origin) => *origin += by,
            Path::Table(_, coefficients) => coefficients[0] += by,
        }
    }
}

/// Between breaks where one of the functions changes: over the distance of the breaks, or over the rounding where breaks of several
/// corners lie closer than a corner's own.
fn changes(breaks: &[f64], smoothing: f64, changes: impl Fn(f64) -> bool) -> Vec<Stretch> {
    let parts =
        breaks.windows(2).map(|pair| Stretch { from: pair[0], to: pair[1], wave: (pair[1] - pair[0]).max(smoothing.max(LEAST_ROUNDING)) });
    parts.filter(|part| changes(0.5 * (part.from + part.to))).collect()
}

impl CentreLine {
    /// The line that at s = 0 is at `origin` [m] and runs with `heading` [rad] about the vertical. `None` for straight level track
    /// without cant.
    pub fn new(alignment: &Alignment, origin: Vector3<f64>, heading: f64) -> Option<CentreLine> {
        let nodes = &alignment.nodes;
        let tangent = nodes.iter().all(|n| n.curvature == 0.0 && n.superelevation == 0.0 && n.grade == 0.0);
        if tangent && heading == 0.0 && origin == Vector3::zeros() {
            return None;
        }
        let level = [Node::default()];
        let nodes = if nodes.is_empty() { &level[..] } else { nodes };
        let table = |of: fn(&Node) -> f64| nodes.iter().map(|n| (n.distance, of(n))).collect::<Vec<_>>();
        let (curvature, grade) =
            (Ramp::new(table(|n| n.curvature), alignment.smoothing), Ramp::new(table(|n| n.grade), alignment.smoothing));
        let rounding = alignment.smoothing.max(LEAST_ROUNDING);
        let cant = Ramp::new(table(|n| n.superelevation), rounding);
        let rise = match alignment.pivot {
            Pivot::LowRail { base } if !cant.is_constant() => Some((0.5 * base, Ramp::new(magnitudes(nodes), rounding))),
            _ => None,
        };
        let rough = [curvature.breaks(), grade.breaks()].concat();
        let rising = rise.as_ref().map(|(_, ramp)| ramp.breaks()).unwrap_or_default();
        let breaks = ascending([rough.clone(), cant.breaks(), rising].concat());
        let mut line = CentreLine {
            pieces: Vec::new(),
            x_until: f64::NEG_INFINITY,
            bins: Vec::new(),
            first: 0.0,
            bins_per_metre: 0.0,
            breaks: Vec::new(),
            waves: Vec::new(),
        };
        let mut psi = 0.0;
        let places = split(&breaks, |a, b| {
            let turn = |ramp: &Ramp| [a, 0.5 * (a + b), b].map(|s| ramp.around(s).0[0].abs()).into_iter().fold(0.0, f64::max);
            let climbs = |s: f64| grade.around(s).0[0];
            turn(&curvature) * (b - a) + (climbs(b) - climbs(a)).abs()
        });
        for (from, to) in places {
            let middle = if from.is_infinite() {
                if to.is_infinite() { 0.0 } else { to }
            } else if to.is_infinite() {
                from
            } else {
                0.5 * (from + to)
            };
            // Beyond the table the middle is a corner.
            let inside = if from.is_infinite() {
                middle - 1.0
            } else if to.is_infinite() {
                middle + 1.0
            } else {
                middle
            };
            let around = |ramp: &Ramp| {
                let mut p = ramp.around(inside);
                if inside != middle {
                    p = Polynomial([p.0[0], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
                }
                p
            };
            let mut climb = around(&grade);
            if let Some((half, ramp)) = &rise {
                for (sum, slope) in climb.0.iter_mut().zip(around(ramp).derivative().0) {
                    *sum += half * slope;
                }
            }
            let (cant, mut heading) = (around(&cant), around(&curvature).integral());
            let at = |heading: &Polynomial, s: f64| heading.jet(s - middle, 7)[0];
            heading.0[0] = if from.is_infinite() { 0.0 } else { psi - at(&heading, from) };
            psi = if to.is_infinite() { psi } else { at(&heading, to) };
            let degree = [&heading, &climb, &cant].into_iter().map(Polynomial::degree).max().unwrap_or(0);
            line.pieces.push(Piece { from, to, middle, degree, heading, climb, cant, path: Path::Arc(Vector3::zeros()), form: Form::Any });
        }
        line.waves = changes(&breaks, alignment.smoothing, |s| {
            let jet = |ramp: &Ramp| ramp.around(s).degree() > 0;
            jet(&curvature) || jet(&grade) || jet(&cant) || rise.iter().any(|(_, ramp)| jet(ramp))
        });
        line.breaks = if alignment.smoothing > 0.0 { Vec::new() } else { ascending(rough) };
        line.index();
        line.lay(origin, heading);
        Some(line)
    }

    /// The same line by its general formulas everywhere, also where nothing turns.
    pub fn in_full(&self) -> CentreLine {
        let mut line = self.clone();
        line.x_until = f64::NEG_INFINITY;
        line.pieces.iter_mut().for_each(|piece| piece.form = Form::Any);
        line
    }

    /// Where curvature, grade or cant change with the distance, and over which length.
    pub fn waves(&self) -> impl Iterator<Item = Stretch> + '_ {
        self.waves.iter().copied()
    }

    /// Finds the pieces by distance in constant time.
    fn index(&mut self) {
        let count = self.pieces.len();
        if count < 3 {
            return;
        }
        let (first, last) = (self.pieces[0].to, self.pieces[count - 1].from);
        let bins = 2 * count;
        self.first = first;
        self.bins_per_metre = bins as f64 / (last - first);
        let begins = |bin: usize| first + bin as f64 / self.bins_per_metre;
        self.bins = (0..bins).map(|bin| self.pieces.partition_point(|piece| piece.to <= begins(bin)) as u32).collect();
    }

    /// Turns and shifts all pieces so that the line starts where it shall.
    fn lay(&mut self, origin: Vector3<f64>, heading: f64) {
        let turn = heading - self.frame(0.0).heading;
        for piece in &mut self.pieces {
            piece.heading.0[0] += turn;
        }
        let mut at = Vector3::zeros();
        for piece in self.pieces.iter_mut().skip(1) {
            at = piece.lay(at);
        }
        let shift = origin - self.frame(0.0).origin;
        for piece in &mut self.pieces {
            piece.shift(&shift);
            piece.note_form();
        }
        if let Piece { to, middle, form: Form::Straight(frame), .. } = &self.pieces[0]
            && frame.axes == Matrix3::identity()
            && (frame.origin - Vector3::x() * *middle).norm() <= SAME
        {
            self.x_until = *to;
        }
    }

    #[inline]
    fn piece(&self, s: f64) -> &Piece {
        let last = self.pieces.len() - 1;
        // A cast of a negative number gives 0, one of a large number the largest.
        let bin = ((s - self.first) * self.bins_per_metre) as usize;
        let mut at = if s < self.pieces[0].to { 0 } else { self.bins.get(bin).map_or(last, |piece| *piece as usize) };
        while at > 0 && s < self.pieces[at].from {
            at -= 1;
        }
        while at < last && s >= self.pieces[at].to {
            at += 1;
        }
        &self.pieces[at]
    }

    /// Is the line X itself at distance `s` [m], as before its first node?
    #[inline]
    pub fn is_x(&self, s: f64) -> bool {
        s < self.x_until
    }

    /// The distance until which it is so, m.
    pub fn x_until(&self) -> f64 {
        self.x_until
    }

    /// Is the line X beside `point` [m] and at a guess of its distance [m]?
    #[inline]
    pub fn keeps_to_x(&self, point: &Vector3<f64>, guess: f64) -> bool {
        self.is_x(guess) && self.is_x(point.x)
    }

    /// The track frame at distance `s` [m].
    #[inline]
    pub fn frame(&self, s: f64) -> TrackFrame {
        if self.is_x(s) {
            return TrackFrame { distance: s, origin: Vector3::x() * s, ..TrackFrame::default() };
        }
        self.piece(s).frame(s)
    }

    /// The frame whose plane across the track goes through `point` [m], from a guess of its distance [m]; to rounding. Points must
    /// be nearer to the line than its radius of curvature, and the guess nearer than a quarter of a turn.
    #[inline]
    pub fn project(&self, point: &Vector3<f64>, guess: f64) -> TrackFrame {
        const ITERATIONS: usize = 20;
        if self.keeps_to_x(point, guess) {
            return self.frame(point.x);
        }
        let mut frame = self.frame(guess);
        for _ in 0..ITERATIONS {
            let offset = point - frame.origin;
            let step = offset.dot(&frame.along()) / frame.stretch(&offset);
            let rounding = 4.0 * f64::EPSILON * (frame.distance.abs() + point.x.abs() + point.y.abs() + 1.0);
            // Not a number ends it too.
            if !(step.abs() > rounding) {
                break;
            }
            frame = self.frame(frame.distance + step);
            if step.abs() < LAST_STEP {
                break;
            }
        }
        frame
    }

    /// Distances [m] where the third derivative of a rail jumps; none with smoothing.
    pub fn breaks(&self) -> &[f64] {
        &self.breaks
    }
}

fn ascending(mut places: Vec<f64>) -> Vec<f64> {
    places.sort_by(f64::total_cmp);
    places.dedup_by(|a, b| *a - *b < SAME);
    places
}

/// Distances and sizes of the cant, with nodes where it changes its sign.
fn magnitudes(nodes: &[Node]) -> Vec<(f64, f64)> {
    let mut all = Vec::new();
    for (i, node) in nodes.iter().enumerate() {
        if let Some(before) = i.checked_sub(1).map(|before| &nodes[before])
            && before.superelevation * node.superelevation < 0.0
        {
            let share = before.superelevation / (before.superelevation - node.superelevation);
            all.push((before.distance + share * (node.distance - before.distance), 0.0));
        }
        all.push((node.distance, node.superelevation.abs()));
    }
    all
}

/// Stretches from minus to plus infinity, those between breaks shared out so that none turns by more than [`TURN`].
fn split(breaks: &[f64], turn: impl Fn(f64, f64) -> f64) -> Vec<(f64, f64)> {
    let Some((first, last)) = breaks.first().zip(breaks.last()) else { return vec![(f64::NEG_INFINITY, f64::INFINITY)] };
    let mut places = vec![(f64::NEG_INFINITY, *first)];
    for pair in breaks.windows(2) {
        let count = (turn(pair[0], pair[1]) / TURN).ceil().max(1.0);
        let at = |i: usize| if i as f64 == count { pair[1] } else { pair[0] + (pair[1] - pair[0]) * i as f64 / count };
        places.extend((0..count as usize).map(|i| (at(i), at(i + 1))));
    }
    places.push((*last, f64::INFINITY));
    places
}
