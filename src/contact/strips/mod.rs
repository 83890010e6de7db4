//! The patch as strips along the track: a fast law for any profiles.
//!
//! The rail is cut into strips ([`rail`]); over each the wheel overlaps by `d - kappa x^2 / 2` around the deepest place ([`strip`]). Each strip
//! carries a load Q with a semi-elliptic pressure over a half length a. Loads and lengths are those that make the potential
//!
//! ```text
//! Pi = 1/2 sum_ij K_ij(a_i, a_j) Q_i Q_j - sum_i Q_i (d_i - kappa_i a_i^2 / 8),      Q_i >= 0
//! ```
//!
//! stationary (the true pressure makes it least among all pressures): K from [`influence`], d_i the mean over the strip's width; the mean of x^2 over a semi-ellipse is a^2 / 4. Patches of
//! any number join and part without being counted, and feel each other. A Hertzian patch is among the pressures that can be described.
//!
//! *Half lengths.* Pi is nearly stationary in them: an error in a is one of second order in N. They are those of the Hertzian patch of the same
//! proportions, in which `A a^2 + B b^2 = delta`: the strip at the edge of the patch still overlaps by `e delta`, `e = A a^2 / delta`, a function of A / B
//! alone, so that
//!
//! ```text
//! a_i^2 = 2 e (d_i - e delta) / ((1 - e) kappa_i),    e = 1 / (1 + (A / B)^0.3)       0.013 from b/a = 1/20 to 20
//! ```
//!
//! with A = kappa / 2, and B and delta of the parabola that has the same sums of d and d^2 over what is near (12 mm) and not beyond a gap. d_i is the mean over the part of the
//! strip's width that is above the edge, and the strip is as wide as that ([`cut`]): patches end within strips, and small ones lie within one or two.
//!
//! *What creep laws see* are parts of the patch ([`parts`]) with the ellipse of their moments, for which half lengths are taken from the loads:
//! `a^2 = lambda q / (kappa E*)`, q the load over the strip's width, `E* = G / (1 - nu)`, lambda a function of the proportions,
//! `lambda = 4/pi (1 + 1.961 g^3.293)^-0.2697` with `g = sum q^2 / (E* sum q d)`: 2 % from b/a = 0.03 to 30.
//!
//! What the law does not know of a part, its strips add ([`uneven`]).
//!
//! *Direction.* Wheel and rail are alike and yield alike: the pressed surface lies half way between both, and each load acts along the mean of their
//! normals. (Along the rail's or the wheel's alone a patch that lies to one side of the deepest place would push across by up to 2e-3 of N more or less.)
//!
//! *Error* against half-space contact on a grid: docs/real_profiles.md. *What it leaves out:* pressure that is not semi-elliptic along the track; flat
//! half-spaces over the arc length, as on the grid ([`super::patch`]). Forces are the gradient of the least value of Pi but for what half lengths are off their stationary ones: the energy of a lossless run swings by 1 % of what the contacts store.

mod bearing;
mod cut;
mod fifths;
mod influence;
mod lengths;
mod mixed;
mod parts;
mod press;
mod pressed;
mod rail;
mod strip;
mod table;
#[cfg(test)]
mod tests;
mod traction;
mod uneven;

pub use fifths::{Cells, Fifths};
pub use mixed::Creep;
pub use parts::{MOST, Part, Parts, Share};
pub use press::{Near, Scratch, press, press_anywhere};
pub use pressed::Pressed;
pub use rail::RailStrips;
pub use strip::Section;
pub use table::{Expanded, FLANK, LinearPatch, Looked, PatchTable, Range, Standing, ToTabulate};
pub use uneven::Uneven;
