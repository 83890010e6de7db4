//! Equivalent slopes for wheelsets that swing across by a given amplitude a: profiles, and patches that follow wheels from strip to strip, are not linear over it.
//!
//! *Harmonic linearisation*: of what answers a displacement `x = a sin(theta)` the part that goes with it,
//!
//! ```text
//! <F> = sum F(a sin theta) sin theta / (a sum sin^2 theta),     sums over theta at equal distances
//! d(x) = x e_y + z(x) e_z + phi(x) e_phi,     both wheels' loads N as in the steady state
//! J e_y = <f(y0 + d)> - <z> J e_z - <phi> J e_phi
//! ```
//!
//! (Equivalent conicity is the same for kinematics alone: UIC 519, EN 15302.) Wheels keep their loads on the way d, which a displacement alone would change by as much as they are.
//!
//! Patches, and with them what creepages do, change on the way. Columns of the wheelset's yaw and velocities are means of the slopes beside it, by `cos^2 theta` where they are a quarter of a
//! turn ahead of the displacement (yaw, lateral and roll velocity), by `sin^2 theta` where they go with it (yaw rate), by 1 for the others. Left out: creepages of that size (creep laws saturate), and
//! what even harmonics do.

use super::slopes::{Linear, Met, Neighbourhood, add_to_column, scale_column};
use crate::formulation::{EvaluationError, contact_index};
use crate::geometry::Side;
use crate::mbs::body::{COORDINATES, YAW};
use nalgebra::{Matrix2, Vector2};
use std::f64::consts::FRAC_PI_2;

/// Places over a quarter of the swing.
const NODES: u32 = 12;
/// Part of the loads to which they are kept, and tries.
const KEPT: f64 = 1e-6;
const TRIES: usize = 12;
/// Places of y, z and roll among a body's coordinates.
const Y: usize = 1;
const Z: usize = 2;
const ROLL: usize = 4;

/// A wheelset aside of the steady state: the state that was asked for, what was met there, by how much the wheelset rises, m, and rolls, rad, and by how far
/// its wheels' loads are then off, in parts of themselves.
struct Displaced {
    state: Vec<f64>,
    met: Met,
    way: Vector2<f64>,
    off: f64,
}

/// Columns of a wheelset that are taken as means.
const BESIDE: usize = 7;

/// Of a part of hunting against the displacement.
#[derive(Clone, Copy)]
enum Phase {
    Ahead,
    With,
    None,
}

impl Phase {
    /// Where the displacement is the amplitude times `sine`.
    fn weight(self, sine: f64) -> f64 {
        match self {
            Phase::Ahead => 1.0 - sine * sine,
            Phase::With => sine * sine,
            Phase::None => 1.0,
        }
    }
}

/// sin theta at a place of the quarter of a swing.
fn sine(node: u32) -> f64 {
    (FRAC_PI_2 * (f64::from(node) + 0.5) / f64::from(NODES)).sin()
}

/// Of all contacts those of a wheelset's two wheels.
fn both(index: usize, all: &[f64]) -> Vector2<f64> {
    Vector2::from(Side::BOTH.map(|side| all[contact_index(index, side)]))
}

impl Neighbourhood<'_> {
    /// Puts equivalent slopes into the columns of the wheelsets' lateral displacements.
    ///
    /// # Errors
    /// Where the model has no answer beside the steady state.
    pub fn swing(&mut self, (length, amplitude): (f64, f64), linear: &mut Linear) -> Result<(), EvaluationError> {
        for (index, body) in self.model.wheelsets.iter().map(|wheelset| wheelset.body).enumerate() {
            let [y, z, roll] = [Y, Z, ROLL].map(|axis| COORDINATES * body + axis);
            let of = |all: &[f64]| both(index, all);
            let kept = of(&linear.carried);
            let Some(back) = Matrix2::from_columns(&[of(&linear.loads[z]), of(&linear.loads[roll])]).try_inverse() else { continue };
            let beside = self.columns_beside(body);
            [y].into_iter().chain(beside.iter().map(|own| own.0)).for_each(|column| scale_column(linear, column, 0.0));
            let (mut way, mut sum, mut weights) = (Vector2::zeros(), 0.0, [0.0; BESIDE]);
            for node in 0..NODES {
                let sine = sine(node);
                let mut at = |x: f64| self.displaced((index, [y, z, roll]), x, (&back, &kept));
                let (ahead, behind) = (at(amplitude * sine)?, at(-amplitude * sine)?);
                add_to_column(linear, y, (&ahead.met, &behind.met), sine);
                linear.off = linear.off.max(ahead.off).max(behind.off);
                way += (ahead.way - behind.way) * sine;
                sum += 2.0 * amplitude * sine * sine;
                for state in [&ahead.state, &behind.state] {
                    for ((column, phase), sum) in beside.iter().zip(&mut weights) {
                        let weight = phase.weight(sine);
                        self.add_slope(state, *column, length, weight, linear)?;
                        *sum += weight;
                    }
                }
            }
            scale_column(linear, y, sum.recip());
            beside.iter().zip(weights).for_each(|((column, _), sum)| scale_column(linear, *column, sum.recip()));
            way /= sum;
            for matrix in [&mut linear.projector, &mut linear.slopes] {
                for row in 0..matrix.nrows() {
                    let less = way.x * matrix[(row, z)] + way.y * matrix[(row, roll)];
                    matrix[(row, y)] -= less;
                }
            }
        }
        Ok(())
    }

    /// Yaw and velocities of a wheelset.
    fn columns_beside(&self, body: usize) -> [(usize, Phase); BESIDE] {
        let (places, velocities) = (COORDINATES * body, COORDINATES * (self.model.system.bodies.len() + body));
        let ahead = [places + YAW, velocities + Y, velocities + ROLL].map(|column| (column, Phase::Ahead));
        let others = [0, Z, COORDINATES - 1].map(|axis| (velocities + axis, Phase::None));
        [ahead[0], ahead[1], ahead[2], (velocities + YAW, Phase::With), others[0], others[1], others[2]]
    }

    /// The state with a wheelset (its number, and where its y, z and roll are) displaced by x, and by how much it rises and rolls there for its wheels to keep their loads;
    /// with how these change loads the other way round.
    fn displaced(
        &mut self,
        (index, [y, z, roll]): (usize, [usize; 3]),
        x: f64,
        (back, kept): (&Matrix2<f64>, &Vector2<f64>),
    ) -> Result<Displaced, EvaluationError> {
        let mut way = Vector2::zeros();
        let mut at = |way: &Vector2<f64>| {
            let mut state = self.y.clone();
            for (place, moved) in [(y, x), (z, way.x), (roll, way.y)] {
                state[place] += moved;
            }
            let met = self.rates(state.clone())?;
            Ok((Displaced { state, met, way: *way, off: 0.0 }, both(index, &self.wheel_loads()) - kept))
        };
        let (mut found, mut more) = at(&way)?;
        for _ in 0..TRIES {
            if more.amax() < KEPT * kept.amax() {
                break;
            }
            way -= back * more;
            (found, more) = at(&way)?;
        }
        found.off = more.amax() / kept.amax();
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a coefficient `C(y) = 1 + y^2` does, times something that goes ahead of or with y = a sin t: its first harmonic, `1 + a^2 / 4` or `1 + 3 a^2 / 4`; the mean is `1 + a^2 / 2`.
    #[test]
    fn analytic_weights_are_those_of_the_first_harmonic() {
        let amplitude = 0.7;
        for (phase, part) in [(Phase::Ahead, 0.25), (Phase::With, 0.75), (Phase::None, 0.5)] {
            let (mut sum, mut weights) = (0.0, 0.0);
            for node in 0..NODES {
                let sine = sine(node);
                let weight = phase.weight(sine);
                sum += weight * (1.0 + (amplitude * sine).powi(2));
                weights += weight;
            }
            assert!((sum / weights - 1.0 - part * amplitude * amplitude).abs() < 1e-12, "{part}: {}", sum / weights);
        }
    }
}
