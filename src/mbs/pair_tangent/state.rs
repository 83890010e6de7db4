//! First-order states and what they couple.

use nalgebra::{Matrix2, Vector6};

/// Bodies of the two ends of something; `None`: the world.
pub type Ends = [Option<usize>; 2];

/// Something linear in the motion of `from` and of `to`.
pub type Gradient = [Vector6<f64>; 2];

/// Generalised forces on two bodies that change with the coordinates of two, of which one may be another.
#[derive(Clone, Copy, Debug)]
pub(in crate::mbs) struct Across {
    pub on: Ends,
    pub load: Gradient,
    pub by: Ends,
    pub measured: Gradient,
}

/// One or two first-order states.
#[derive(Clone, Copy, Debug)]
pub struct StateTangent {
    /// Index in the state vector, and number.
    pub first: usize,
    pub count: usize,
    pub(in crate::mbs) ends: Ends,
    /// d s_i' / d s_j, 1/s.
    pub rate_by_state: Matrix2<f64>,
    /// Per state: change of its rate with positions and velocities, and of forces with it. In [`super::pair::PairTangent`]'s terms until
    /// `Tangent::finish` turns them into coordinates and accelerations.
    pub rate_by_position: [Gradient; 2],
    pub rate_by_velocity: [Gradient; 2],
    pub load_by_state: [Gradient; 2],
    /// A third body and, per state, the change of its generalised force with it.
    pub far: Option<(usize, [Vector6<f64>; 2])>,
    pub(in crate::mbs) terms: Terms,
    /// Of states that follow a wheel which turns against its axle.
    pub(in crate::mbs) twist: Option<TwistTerms>,
}

/// What couples states with the twist of an axle.
#[derive(Clone, Copy, Debug)]
pub(in crate::mbs) struct TwistTerms {
    pub twist: usize,
    /// Per state: change of its rate with that of the twist, and of the twist's generalised force with the state.
    pub rate: [f64; 2],
    pub load: [f64; 2],
}

/// In terms of what states are handed in.
#[derive(Clone, Copy, Debug)]
pub(in crate::mbs) enum Terms {
    /// Relative motion of the pair of that number.
    Pair(usize),
    /// Each body's own displacement and wrench.
    World,
    /// Coordinates and generalised forces.
    Coordinates,
}

impl StateTangent {
    /// `count` states (at most two) that nothing acts on yet.
    #[inline]
    pub(in crate::mbs) fn new(first: usize, count: usize, ends: Ends, terms: Terms) -> StateTangent {
        let none = [[Vector6::zeros(); 2]; 2];
        let rate_by_state = Matrix2::zeros();
        StateTangent {
            first,
            count,
            ends,
            rate_by_state,
            rate_by_position: none,
            rate_by_velocity: none,
            load_by_state: none,
            far: None,
            terms,
            twist: None,
        }
    }

    #[inline]
    pub(in crate::mbs) fn index(&self, i: usize) -> usize {
        self.first + i
    }

    /// (1 - a ds'/ds)^-1, a single state's partner left alone; `None` where there is no inverse.
    #[inline]
    pub(in crate::mbs) fn inverse(&self, a: f64) -> Option<Matrix2<f64>> {
        if self.count == 1 {
            let own = 1.0 - a * self.rate_by_state[(0, 0)];
            return (own != 0.0).then(|| Matrix2::new(1.0 / own, 0.0, 0.0, 1.0));
        }
        (Matrix2::identity() - self.rate_by_state * a).try_inverse()
    }

    /// What coordinate changes `x` (6 per body) change by a gradient.
    #[inline(always)]
    pub(in crate::mbs) fn along(&self, gradient: &Gradient, x: &[f64]) -> f64 {
        let mut sum = 0.0;
        for (end, gradient) in self.ends.iter().zip(gradient) {
            if let Some(x) = end.and_then(|body| x[6 * body..].first_chunk::<6>()) {
                sum += dot(&gradient.data.0[0], x);
            }
        }
        sum
    }
}

#[inline]
pub(in crate::mbs) fn dot(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) + (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])
}
