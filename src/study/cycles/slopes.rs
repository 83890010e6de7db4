//! How a turn's end depends on its begin and on the parameter, by differences of whole turns in few directions.
//!
//! Most of what disturbs a motion dies within a turn: `dP/dz` has few eigenvalues that are not nearly zero. So an orthonormal basis V is built from given
//! directions, the parameter's, and the images of all of these (Arnoldi's method with several starts), until images bring nothing new. In the span of V the equations
//! are solved exactly, outside the turn itself is the iteration (Lust, Roose, Spence and Champneys, SIAM J. Sci. Comput. 19, 1998: Newton-Picard):
//!
//! ```text
//! dz = V c + (1 - V V^T) r,    (V^T W - 1) c + V^T P_p dp = -V^T r,    r = P(z, p) - z,    W = dP/dz V
//! ```
//!
//! Differences reach over a part of the motion's size: contact has kinks, and turns have the error of their integration.

use super::{Flow, Lost, Turn, along, dot, norm};
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};
use rayon::prelude::*;

/// Length of a difference in parts of the place's size, and of the parameter's unit.
const LENGTH: f64 = 1e-3;
const PARAMETER: f64 = 1e-2;
/// It is so many times the error of a turn at least, and this part of the place's size at most.
const ABOVE: f64 = 200.0;
const LONGEST: f64 = 0.05;
/// An image brings nothing new where less than this is outside the basis.
const NEW: f64 = 2e-2;
/// Most directions.
const MOST: usize = 36;

#[derive(Clone, Debug)]
pub struct Slopes {
    basis: Vec<Vec<f64>>,
    images: Vec<Vec<f64>>,
    /// dP/dp in the parameter's unit.
    by_parameter: Vec<f64>,
}

/// One equation beside P(z, p) = z: `direction . (z, p) = value`.
#[derive(Clone, Debug)]
pub struct Condition {
    pub direction: Vec<f64>,
    pub value: f64,
}

impl Condition {
    /// Through a place, across a direction.
    pub fn across(direction: Vec<f64>, place: &[f64]) -> Self {
        let value = dot(&direction, place);
        Condition { direction, value }
    }

    /// The parameter keeps its value, of a place with so many components.
    pub fn parameter(size: usize, value: f64) -> Self {
        let mut direction = vec![0.0; size];
        direction[size - 1] = 1.0;
        Condition { direction, value }
    }
}

impl Slopes {
    /// At a place (with the parameter behind) whose turn is known.
    ///
    /// # Errors
    /// [`Lost`] of a turn beside it.
    pub fn find(flow: &dyn Flow, place: &[f64], turn: &Turn, seeds: Vec<Vec<f64>>) -> Result<Self, Lost> {
        let size = place.len() - 1;
        let (z, parameter) = (&place[..size], place[size]);
        let beside = |to: Vec<f64>, step: f64| along(&to, -1.0, &turn.to).iter().map(|change| change / step).collect::<Vec<f64>>();
        let moved = flow.turn((parameter + PARAMETER) * flow.unit(), z)?;
        let by_parameter = beside(moved.to, PARAMETER);
        let size_of_place = norm(z);
        let length = (LENGTH * size_of_place).max(ABOVE * flow.error()).min(LONGEST * size_of_place);
        let image = |direction: &Vec<f64>| Ok(beside(flow.turn(parameter * flow.unit(), &along(z, length, direction))?.to, length));
        let mut slopes = Slopes { basis: Vec::new(), images: Vec::new(), by_parameter };
        let mut front = vec![unit(&slopes.by_parameter)];
        front.extend(seeds.iter().map(|seed| unit(&seed[..size])));
        while !front.is_empty() && slopes.basis.len() < MOST.min(size) {
            let old = slopes.basis.len();
            front.into_iter().for_each(|direction| slopes.extend(direction));
            // Equal work on all threads, in a fixed order.
            let found: Vec<Vec<f64>> = slopes.basis[old..].par_iter().map(image).collect::<Result<_, Lost>>()?;
            slopes.images.extend(found.iter().cloned());
            front = found;
        }
        Ok(slopes)
    }

    /// Takes what a direction has outside the basis into it.
    fn extend(&mut self, direction: Vec<f64>) {
        if self.basis.len() >= MOST.min(direction.len()) {
            return;
        }
        let mut rest = direction;
        for _ in 0..2 {
            for own in &self.basis {
                rest = along(&rest, -dot(own, &rest), own);
            }
        }
        if norm(&rest) > NEW {
            self.basis.push(unit(&rest));
        }
    }

    /// V^T W.
    fn inner(&self) -> Mat<f64> {
        Mat::from_fn(self.basis.len(), self.basis.len(), |i, j| dot(&self.basis[i], &self.images[j]))
    }

    /// Floquet multipliers that are not nearly zero, the largest first.
    pub fn multipliers(&self) -> Vec<c64> {
        let mut values: Vec<c64> = self.inner().eigenvalues().unwrap_or_default();
        values.sort_by(|a, b| b.norm().total_cmp(&a.norm()).then(b.im.total_cmp(&a.im)));
        values
    }

    /// The change of the place that makes the residual and the condition's gap vanish; `None` where the equations are singular.
    pub fn step(&self, residual: &[f64], condition: &Condition, gap: f64) -> Option<Vec<f64>> {
        let inside: Vec<f64> = self.basis.iter().map(|own| dot(own, residual)).collect();
        let mut outside = residual.to_vec();
        for (own, part) in self.basis.iter().zip(&inside) {
            outside = along(&outside, -part, own);
        }
        let size = residual.len();
        let gap = gap + dot(&condition.direction[..size], &outside);
        let mut change = self.solve(&inside, condition, gap)?;
        change[..size].iter_mut().zip(&outside).for_each(|(change, outside)| *change += outside);
        Some(change)
    }

    /// The direction of the branch that has a positive part along another.
    pub fn tangent(&self, along: &[f64]) -> Option<Vec<f64>> {
        let condition = Condition { direction: along.to_vec(), value: 0.0 };
        self.solve(&vec![0.0; self.basis.len()], &condition, -1.0).map(|tangent| unit(&tangent))
    }

    /// `(V^T W - 1) c + V^T P_p dp = -inside`, `condition . (V c, dp) = -gap`.
    fn solve(&self, inside: &[f64], condition: &Condition, gap: f64) -> Option<Vec<f64>> {
        let (count, size) = (self.basis.len(), self.by_parameter.len());
        let inner = self.inner();
        let matrix = Mat::from_fn(count + 1, count + 1, |i, j| match (i < count, j < count) {
            (true, true) => inner[(i, j)] - if i == j { 1.0 } else { 0.0 },
            (true, false) => dot(&self.basis[i], &self.by_parameter),
            (false, true) => dot(&condition.direction[..size], &self.basis[j]),
            (false, false) => condition.direction[size],
        });
        let right = Mat::from_fn(count + 1, 1, |i, _| if i < count { -inside[i] } else { -gap });
        let found = matrix.full_piv_lu().solve(&right);
        let mut change = vec![0.0; size + 1];
        for (k, own) in self.basis.iter().enumerate() {
            change[..size].iter_mut().zip(own).for_each(|(change, own)| *change += found[(k, 0)] * own);
        }
        change[size] = found[(count, 0)];
        change.iter().all(|change| change.is_finite()).then_some(change)
    }
}

/// In the same direction with length 1; nothing stays nothing.
pub(super) fn unit(a: &[f64]) -> Vec<f64> {
    let size = norm(a);
    if size > 0.0 { a.iter().map(|a| a / size).collect() } else { a.to_vec() }
}
