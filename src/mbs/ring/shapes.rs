//! Shapes of a ring's modes at any place, from a table over one bay.
//!
//! With the wave number k that all amplitudes of a family have in common, its modes are the parts of `e^{i k x} (A(x) + i B(x))`, A and B with the period L:
//!
//! ```text
//! even: A cos k x - B sin k x      odd: A sin k x + B cos k x        A + i B = sum_j W_j e^{i (k_j - k) x}
//! ```
//!
//! A and B stand in the table with two derivatives each at [`NODES`] places; between them they are polynomials of degree 5, so that shapes have two continuous derivatives.
//! The slope is exactly that of the shape as it is read.

use super::waves::Family;
use super::{Placed, Ring};

/// Places in a bay.
const NODES: usize = 48;
/// A, A', A'', B, B', B''.
const VALUES: usize = 6;

#[derive(Debug)]
pub(super) struct Table {
    /// m.
    step: f64,
    /// Waves of all families.
    strands: usize,
    /// By node, then strand; the last node is the first.
    values: Vec<f64>,
}

impl Table {
    pub fn new<'a>(spacing: f64, families: impl Iterator<Item = &'a Family>) -> Table {
        let families: Vec<&Family> = families.collect();
        let strands = families.iter().map(|family| family.waves.len()).sum::<usize>();
        let step = spacing / NODES as f64;
        let mut values = Vec::with_capacity((NODES + 1) * strands * VALUES);
        for node in 0..=NODES {
            let x = step * (node % NODES) as f64;
            for family in &families {
                for wave in &family.waves {
                    let mut own = [0.0; VALUES];
                    for (number, amplitude) in family.numbers.iter().zip(&wave.amplitudes) {
                        let k = number - family.phase;
                        let (sin, cos) = (k * x).sin_cos();
                        let parts = [cos, -k * sin, -k * k * cos, sin, k * cos, -k * k * sin];
                        own.iter_mut().zip(parts).for_each(|(own, part)| *own += amplitude * part);
                    }
                    values.extend(own);
                }
            }
        }
        Table { step, strands, values }
    }
}

/// Weights of value and two derivatives at both ends of an interval of length h for the value at its part t, and for the slope there.
fn quintic(t: f64, h: f64) -> [[f64; 6]; 2] {
    let (t2, u) = (t * t, 1.0 - t);
    let t3 = t2 * t;
    let end = t3 * (10.0 + t * (-15.0 + 6.0 * t));
    let ends = 30.0 * t2 * u * u;
    let value = [
        1.0 - end,
        h * t * (1.0 + t2 * (-6.0 + t * (8.0 - 3.0 * t))),
        h * h * 0.5 * t2 * (1.0 + t * (-3.0 + t * (3.0 - t))),
        end,
        h * t3 * (-4.0 + t * (7.0 - 3.0 * t)),
        h * h * 0.5 * t3 * (1.0 + t * (-2.0 + t)),
    ];
    let slope = [
        -ends / h,
        1.0 + t2 * (-18.0 + t * (32.0 - 15.0 * t)),
        h * 0.5 * t * (2.0 + t * (-9.0 + t * (12.0 - 5.0 * t))),
        ends / h,
        t2 * (-12.0 + t * (28.0 - 15.0 * t)),
        h * 0.5 * t2 * (3.0 + t * (-8.0 + 5.0 * t)),
    ];
    [value, slope]
}

impl Ring {
    /// phi and d phi/dx of all modes at the place x [m], which counts modulo the ring's length.
    pub fn shapes(&self, x: f64, shape: &mut [f64], slope: &mut [f64]) {
        let Table { step, strands, values } = &self.table;
        let x = x.rem_euclid(self.length());
        let within = x.rem_euclid(self.bay.spacing) / step;
        let node = (within as usize).min(NODES - 1);
        let [weights, slopes] = quintic(within - node as f64, *step);
        let row = strands * VALUES;
        let (left, right) = (&values[node * row..][..row], &values[(node + 1) * row..][..row]);
        let mut strand = 0;
        for Placed { family, even, odd } in &self.families {
            let (sin, cos) = (family.phase * x).sin_cos();
            let (count, k) = (family.waves.len(), family.phase);
            for own in 0..count {
                let at = (strand + own) * VALUES;
                let (from, to) = (&left[at..at + VALUES], &right[at..at + VALUES]);
                let sum = |w: &[f64; 6], i: usize| {
                    w[0] * from[i] + w[1] * from[i + 1] + w[2] * from[i + 2] + w[3] * to[i] + w[4] * to[i + 1] + w[5] * to[i + 2]
                };
                let (a, b) = (sum(&weights, 0), sum(&weights, 3));
                let (a1, b1) = (sum(&slopes, 0) - k * b, sum(&slopes, 3) + k * a);
                if let Some(first) = even {
                    (shape[first + own], slope[first + own]) = (a * cos - b * sin, a1 * cos - b1 * sin);
                }
                if let Some(first) = odd {
                    (shape[first + own], slope[first + own]) = (a * sin + b * cos, a1 * sin + b1 * cos);
                }
            }
            strand += count;
        }
    }
}
