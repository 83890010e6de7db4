//! Floor 2: where wheel and rail touch, how hard they press, how they creep.

pub mod creep;
pub mod creepage;
pub mod friction;
mod half_space;
pub mod normal;
pub mod patch;
pub mod profile_end;
pub mod search;
pub mod strips;
pub mod transient;

/// Elastic constants shared by wheel and rail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// E, Pa.
    pub youngs_modulus: f64,
    /// nu, -.
    pub poisson_ratio: f64,
}

impl Material {
    /// G = E / (2 (1 + nu)), Pa.
    pub fn shear_modulus(&self) -> f64 {
        self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))
    }

    /// E* = G / (1 - nu) of two alike bodies, Pa.
    pub fn contact_modulus(&self) -> f64 {
        self.shear_modulus() / (1.0 - self.poisson_ratio)
    }
}

/// Elliptic contact patch, axes along e1 (rolling direction) and e2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Patch {
    /// Semi-axis along e1, m.
    pub a: f64,
    /// Semi-axis along e2, m.
    pub b: f64,
}
