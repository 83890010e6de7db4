//! Slopes across the track where patches are made of strips, or read from a table of them.
//!
//! Such a patch follows a wheel that moves across in steps: within a strip (0.35 mm) conicity and contact angle change by up to a fourth more or less than from strip to strip. On
//! S1002 and 60E1 slopes of 0.1 um made hunting 6 % (wheelset) and 10 % (coach) slower than motions of some tenths of a millimetre are. Wheelsets move across by some such steps
//! ([`PatchLaw::step_across`](crate::contact::patch::PatchLaw::step_across)) to both sides instead, along the way `d` on which their wheels keep their loads N, which a displacement alone would change by as much as they are:
//!
//! ```text
//! d = e_y + z_y e_z + phi_y e_phi,   N_y + z_y N_z + phi_y N_phi = 0 (both wheels)
//! J e_y = sum w(h) (f(y0 + h d) - f(y0 - h d)) / sum 2 w(h) h - z_y J e_z - phi_y J e_phi,   w = h (1 - (h / H)^2)^2
//! ```
//!
//! with h up to H = 1.6 steps: what comes again from strip to strip falls out whatever its period is.
//!
//! What profiles do in third order over that way is in the slopes: 0.2 % of the frequency there. The uncertainty of eigenvalues is from twice that way.

use super::slopes::{Linear, Neighbourhood, add_to_column, clear_column, scale_column};
use crate::formulation::{EvaluationError, contact_index};
use crate::geometry::Side;
use crate::mbs::body::COORDINATES;
use nalgebra::{Matrix2, Vector2};

/// How far to both sides slopes are looked for, in parts of such a step, and at how many places.
const REACH: f64 = 1.6;
const NODES: u32 = 12;
/// Places of y, z and roll among a body's coordinates.
const Y: usize = 1;
const Z: usize = 2;
const ROLL: usize = 4;

/// Loads of the wheels, N, by state.
pub(super) type Loads = Vec<Vec<f64>>;

impl Neighbourhood<'_> {
    /// Puts the columns of the wheelsets' lateral displacements right, given how wheels' `loads` change with each state, by moving them by `step` [m] to both sides.
    pub fn slopes_across(&mut self, step: f64, loads: &Loads, linear: &mut Linear) -> Result<(), EvaluationError> {
        for (index, body) in self.model.wheelsets.iter().map(|wheelset| wheelset.body).enumerate() {
            let [y, z, roll] = [Y, Z, ROLL].map(|axis| COORDINATES * body + axis);
            let of = |column: usize| Vector2::from(Side::BOTH.map(|side| loads[column][contact_index(index, side)]));
            let Some(back) = Matrix2::from_columns(&[of(z), of(roll)]).try_inverse() else { continue };
            let way = -back * of(y);
            let mut weights = 0.0;
            clear_column(linear, y);
            for node in 1..=NODES {
                let part = f64::from(node) / f64::from(NODES);
                let moved = part * REACH * step;
                let mut beside = |sign: f64| {
                    let mut state = self.y.clone();
                    for (place, part) in [(y, 1.0), (z, way.x), (roll, way.y)] {
                        state[place] += sign * moved * part;
                    }
                    self.rates(state)
                };
                let weight = moved * (1.0 - part * part).powi(2);
                add_to_column(linear, y, (&beside(1.0)?, &beside(-1.0)?), 0.5 * weight);
                weights += weight * moved;
            }
            scale_column(linear, y, weights.recip());
            for matrix in [&mut linear.projector, &mut linear.slopes] {
                for row in 0..matrix.nrows() {
                    let less = way.x * matrix[(row, z)] + way.y * matrix[(row, roll)];
                    matrix[(row, y)] -= less;
                }
            }
        }
        Ok(())
    }
}
