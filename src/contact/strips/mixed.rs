//! Creep forces, and damping, of parts that are partly one.
//!
//! Where the pressure between two parts has not gone to nothing, creep forces are mixed from those of the parts and of the whole: with the independence
//! s of the valley between them
//!
//! ```text
//! T_k = s T(part k) + (1 - s) (N_k / N) T(whole),    w_k = s + (1 - s) N_k / N
//! ```
//!
//! and again for valleys within the parts, so that nothing jumps where parts become one, or where one disappears. w_k is the share of a part in the
//! force of a whole that is pressed by N_k / w_k: what damping is stated for.

use super::parts::{MOST, Parts};
use super::pressed::Pressed;
use nalgebra::Vector3;
use std::ops::{Add, Mul};

/// Creep force [N] of a part and its moment about its normal [N m].
#[derive(Clone, Copy, Debug, Default)]
pub struct Creep {
    pub force: Vector3<f64>,
    pub moment: f64,
    /// mu N, N: what friction allows.
    pub bound: f64,
}

impl Add for Creep {
    type Output = Creep;
    fn add(self, other: Creep) -> Creep {
        Creep { force: self.force + other.force, moment: self.moment + other.moment, bound: self.bound + other.bound }
    }
}

impl Mul<f64> for Creep {
    type Output = Creep;
    fn mul(self, factor: f64) -> Creep {
        Creep { force: self.force * factor, moment: self.moment * factor, bound: self.bound * factor }
    }
}

/// What parts can be mixed from.
pub trait Mixable: Copy + Default + Add<Output = Self> + Mul<f64, Output = Self> {}
impl Mixable for Creep {}
impl Mixable for f64 {}

impl Parts {
    /// w_k.
    pub fn shares(&self, pressed: &[Pressed]) -> [f64; MOST] {
        let mut shares = [1.0; MOST];
        if !self.is_empty() {
            self.share_among(pressed, 0, self.len() - 1, &mut shares);
        }
        shares
    }

    fn share_among(&self, pressed: &[Pressed], first: usize, last: usize, shares: &mut [f64; MOST]) {
        if first == last {
            return;
        }
        let (divide, independence) = self.divide(first, last);
        self.share_among(pressed, first, divide, shares);
        self.share_among(pressed, divide + 1, last, shares);
        let whole = self.share(pressed, first, last).load();
        for (k, share) in shares.iter_mut().enumerate().take(last + 1).skip(first) {
            *share = independence * *share + (1.0 - independence) * self.share(pressed, k, k).load() / whole;
        }
    }

    /// T_k, or what else parts share with their whole, from the normal forces of the parts [N] and what parts from the first to the last number have as
    /// one.
    pub fn mixed<T: Mixable>(&self, normal_forces: &[f64], of: &mut impl FnMut(usize, usize) -> T) -> [T; MOST] {
        let mut mixed = [T::default(); MOST];
        if !self.is_empty() {
            self.mix(0, self.len() - 1, normal_forces, of, &mut mixed);
        }
        mixed
    }

    fn mix<T: Mixable>(&self, first: usize, last: usize, forces: &[f64], of: &mut impl FnMut(usize, usize) -> T, mixed: &mut [T; MOST]) {
        if first == last {
            mixed[first] = of(first, first);
            return;
        }
        let (divide, independence) = self.divide(first, last);
        self.mix(first, divide, forces, of, mixed);
        self.mix(divide + 1, last, forces, of, mixed);
        if independence == 1.0 {
            return;
        }
        let sum: f64 = forces[first..=last].iter().sum();
        // Damping may leave a patch that parts fast no force at all.
        if !(sum > 0.0) {
            return;
        }
        let all = of(first, last);
        for (own, force) in mixed[first..=last].iter_mut().zip(&forces[first..=last]) {
            *own = *own * independence + all * ((1.0 - independence) * force / sum);
        }
    }
}
