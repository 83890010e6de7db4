//! Elastic half-spaces on a grid of rectangles, wheel and rail of the same material: normal and tangential problem stand alone.
//!
//! - [`influence`]: displacements of a loaded rectangle (exact), sums by FFT
//! - [`cells`]: cells in contact and their pressure
//! - [`normal`]: which cells touch, and how hard they press
//! - [`rolling`]: influence of tractions that stand still while the bodies roll
//! - [`tangential`]: stick and slip under Coulomb's law, semismooth Newton ([`krylov`])

pub(crate) mod cells;
pub(crate) mod influence;
mod krylov;
pub(crate) mod normal;
pub(crate) mod rolling;
pub(crate) mod tangential;
