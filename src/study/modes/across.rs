//! Slopes across the track where patches are made of strips.
//!
//! A patch of strips moves over its rail in steps: within a strip (0.35 mm) its centre, and with it the rolling radius, follows the wheel by up to a fourth more or less than from strip to strip. On S1002
//! and 60E1, whose patch moves by 8 mm per mm of the wheelset, slopes of 0.1 um made hunting 6 % (wheelset) and 10 % (coach) too slow. Wheelsets move across by
//! [`ACROSS`] instead, along the way `d` on which their wheels keep their loads N, which a displacement alone would change by as much as they are:
//!
//! ```text
//! d = e_y + z_y e_z + phi_y e_phi,   N_y + z_y N_z + phi_y N_phi = 0 (both wheels)
//! J e_y = (f(y0 + h d) - f(y0 - h d)) / 2 h - z_y J e_z - phi_y J e_phi
//! ```
//!
//! What is of third order in h is left: loads change by 1e-5 of themselves on the way; how far the slopes themselves change over it is in the uncertainty of the
//! eigenvalues, which is from twice that way.

use super::slopes::{Linear, Neighbourhood, put_column};
use crate::formulation::{EvaluationError, contact_index};
use crate::geometry::Side;
use crate::mbs::body::COORDINATES;
use nalgebra::{Matrix2, Vector2};

/// h, m: some four strips of a nearly conformal pair.
const ACROSS: f64 = 1e-4;
/// Places of y, z and roll among a body's coordinates.
const Y: usize = 1;
const Z: usize = 2;
const ROLL: usize = 4;

/// Loads of the wheels, N, by state.
pub(super) type Loads = Vec<Vec<f64>>;

impl Neighbourhood<'_> {
    /// Puts the columns of the wheelsets' lateral displacements right, given how wheels' `loads` change with each state; `length` as in [`Neighbourhood::linear`].
    pub fn slopes_across(&mut self, length: f64, loads: &Loads, linear: &mut Linear) -> Result<(), EvaluationError> {
        for (index, body) in self.model.wheelsets.iter().map(|wheelset| wheelset.body).enumerate() {
            let [y, z, roll] = [Y, Z, ROLL].map(|axis| COORDINATES * body + axis);
            let of = |column: usize| Vector2::from(Side::BOTH.map(|side| loads[column][contact_index(index, side)]));
            let Some(back) = Matrix2::from_columns(&[of(z), of(roll)]).try_inverse() else { continue };
            let way = -back * of(y);
            let step = length * ACROSS;
            let mut beside = |sign: f64| {
                let mut state = self.y.clone();
                for (place, part) in [(y, 1.0), (z, way.x), (roll, way.y)] {
                    state[place] += sign * step * part;
                }
                self.rates(state)
            };
            let (ahead, behind) = (beside(1.0)?, beside(-1.0)?);
            put_column(linear, y, (&ahead, &behind), 2.0 * step);
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
