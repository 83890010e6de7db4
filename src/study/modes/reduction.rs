//! What can move freely: the states that constraints leave, without those that are imposed or that nothing depends on.
//!
//! The directions on the constraints are those that P leaves alone. An imposed travelling speed fixes distance and speed of its wheelset, which no motion
//! of the rest changes: the directions without them are an invariant subspace. A direction n that changes nothing (the turn of a wheelset about its axle,
//! a common shift along the track) has `J n = 0` and is an eigenvector of the eigenvalue 0: across it, the others are those of the quotient. So with an orthonormal
//! basis Q of
//!
//! ```text
//! { u : (1 - P) u = 0,  u_imposed = 0,  n . u = 0 },      A = Q^T J P Q
//! ```
//!
//! has all other eigenvalues, exactly (in curves: [`super::turning`]). Whether a direction changes nothing is tried with a finite shift, not assumed. A mode's shape is found up to its part along n.

use super::Dense;
use super::shape::owner;
use super::slopes::{Linear, Neighbourhood};
use crate::formulation::EvaluationError;
use crate::mbs::body::COORDINATES;
use faer::{Mat, c64};

/// Velocities count in parts of this, 1/s: about what makes them as large as coordinates.
const UNIT: f64 = 30.0;
/// Singular values below this belong to directions that are free.
const FREE: f64 = 1e-3;
/// A finite shift, m or rad, and the changes per shift that are none.
const SHIFT: f64 = 1e-2;
const NOTHING: f64 = 1e-5;

pub(super) struct Reduction {
    /// Q by columns, and the states' scales D.
    basis: Dense,
    scale: Vec<f64>,
    /// In words.
    pub left_out: Vec<String>,
}

/// A direction in the space of states.
struct Direction {
    parts: Vec<(usize, f64)>,
    words: String,
    /// Is it the travel of the whole about a curve's centre?
    turns: bool,
}

impl Reduction {
    /// `None` where the singular values that tell free directions from others were not found.
    pub fn new(here: &mut Neighbourhood, linear: &Linear) -> Option<Self> {
        let size = linear.size();
        let count = COORDINATES * here.model.system.bodies.len();
        let scale: Vec<f64> = (0..size).map(|i| if (count..2 * count).contains(&i) { UNIT } else { 1.0 }).collect();
        let mut left_out = Vec::new();
        let mut rows: Vec<Vec<(usize, f64)>> = Vec::new();
        for drive in &here.model.system.drives {
            let x = COORDINATES * drive.body;
            let name = &here.model.system.bodies[drive.body].name;
            if let Some(turning) = &here.turning {
                rows.push(turning.along(drive.body).to_vec());
                left_out.push(format!("{name}: speed along the track (imposed)"));
            } else {
                rows.extend([vec![(x, 1.0)], vec![(count + x, 1.0)]]);
                left_out.push(format!("{name}: distance and speed along the track (imposed)"));
            }
        }
        for direction in candidates(here) {
            if changes_nothing(here, &linear.rates, &direction) {
                rows.push(direction.parts.into_iter().map(|(state, part)| (state, part / scale[state])).collect());
                left_out.push(direction.words);
            }
        }
        let left_out = counted(left_out);
        let mut conditions = Mat::<f64>::zeros(size + rows.len(), size);
        for i in 0..size {
            for j in 0..size {
                let unit = if i == j { 1.0 } else { 0.0 };
                conditions[(i, j)] = unit - linear.projector[(i, j)] * scale[j] / scale[i];
            }
        }
        for (row, parts) in rows.iter().enumerate() {
            parts.iter().for_each(|(column, part)| conditions[(size + row, *column)] = *part);
        }
        null_space(&conditions).map(|basis| Reduction { basis, scale, left_out })
    }

    /// A.
    pub fn matrix(&self, linear: &Linear) -> Dense {
        let size = linear.size();
        let scaled = Mat::from_fn(size, size, |i, j| linear.slopes[(i, j)] * self.scale[j] / self.scale[i]);
        self.basis.transpose() * scaled * &self.basis
    }

    /// Rates of the free states from those of all.
    pub fn free(&self, rates: &[f64]) -> Vec<f64> {
        let scaled = |k: usize| rates.iter().enumerate().map(|(i, rate)| self.basis[(i, k)] * rate / self.scale[i]).sum();
        (0..self.basis.ncols()).map(scaled).collect()
    }

    /// A motion of all states from that of the free ones.
    pub fn full(&self, part: impl Fn(usize) -> c64) -> Vec<c64> {
        let states = 0..self.basis.nrows();
        states.map(|i| (0..self.basis.ncols()).map(|k| part(k) * (self.basis[(i, k)] * self.scale[i])).sum()).collect()
    }
}

/// Single states on which nothing depends, near the state that `here` is about.
pub(super) fn indifferent(here: &mut Neighbourhood) -> Result<Vec<usize>, EvaluationError> {
    let usual = here.rates(here.y.clone())?.1;
    let single = candidates(here).into_iter().filter(|direction| direction.parts.len() == 1);
    Ok(single.filter(|direction| changes_nothing(here, &usual, direction)).map(|direction| direction.parts[0].0).collect())
}

/// Directions that may change nothing: the turn of each body of revolution, states beside bodies that only count, and travel where nothing imposes it.
fn candidates(here: &Neighbourhood) -> Vec<Direction> {
    let system = &here.model.system;
    let bodies = system.bodies.len();
    let mut found = Vec::new();
    for wheelset in &here.model.wheelsets {
        let name = &system.bodies[wheelset.body].name;
        let pitch = COORDINATES * wheelset.body + COORDINATES - 1;
        found.push(Direction { parts: vec![(pitch, 1.0)], words: format!("{name}: turn about the axle"), turns: false });
    }
    for state in 2 * COORDINATES * bodies..here.y.len() {
        found.push(Direction {
            parts: vec![(state, 1.0)],
            words: format!("{}, on which nothing depends", owner(here.model, state)),
            turns: false,
        });
    }
    if let Some(turning) = &here.turning {
        found.push(Direction { parts: turning.travel(), words: "travel of the whole along the curve".into(), turns: true });
    } else if system.drives.is_empty() {
        let parts = (0..bodies).map(|body| (COORDINATES * body, 1.0)).collect();
        found.push(Direction { parts, words: "travel of the whole along the track".into(), turns: false });
    }
    found
}

/// The same words once, with how often they come.
fn counted(words: Vec<String>) -> Vec<String> {
    let mut all: Vec<(String, usize)> = Vec::new();
    for word in words {
        match all.iter_mut().find(|known| known.0 == word) {
            Some(known) => known.1 += 1,
            None => all.push((word, 1)),
        }
    }
    all.into_iter().map(|(word, count)| if count > 1 { format!("{count} x {word}") } else { word }).collect()
}

/// Are rates and constraints the same after a finite shift?
fn changes_nothing(here: &mut Neighbourhood, usual: &[f64], direction: &Direction) -> bool {
    let mut y = here.y.clone();
    match &here.turning {
        Some(turning) if direction.turns => y = turning.travelled(SHIFT),
        _ => direction.parts.iter().for_each(|(state, part)| y[*state] += SHIFT * part),
    }
    // A state of an element or a contact may not be free to move so far.
    let Ok((found, rates)) = here.rates(y.clone()) else { return false };
    let same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < NOTHING * SHIFT);
    same(&found, &y) && same(&rates, usual)
}

/// Orthonormal vectors that meet all conditions.
fn null_space(conditions: &Dense) -> Option<Dense> {
    let size = conditions.ncols();
    let svd = conditions.thin_svd().ok()?;
    let values = svd.S().column_vector();
    let free: Vec<usize> = (0..size).filter(|k| values[*k] < FREE).collect();
    Some(Mat::from_fn(size, free.len(), |i, k| svd.V()[(i, free[k])]))
}
