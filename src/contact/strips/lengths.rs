//! Half lengths of the strips of one wheel, before their loads are known.

use super::pressed::Pressed;
use super::rail::RailStrips;
use crate::math::elementary::power;

/// Strips within this distance make one patch whose proportions are taken together, m: their weights fall smoothly from 1 for a strip itself to 0 there.
const WINDOW: f64 = 12e-3;
/// Half lengths are at least this, m: at the edge of a patch they go to nothing.
const SHORTEST: f64 = 1.5e-4;

/// Numbers that run along the strips, for the vector instructions of the compiler.
#[derive(Clone, Debug, Default)]
pub(super) struct Lengths {
    /// m.
    arcs: Vec<f64>,
    overlaps: Vec<f64>,
    /// 1/m.
    curvatures: Vec<f64>,
    /// Sums of the overlap and of its square over the section, m^2 and m^3.
    first: Vec<f64>,
    second: Vec<f64>,
}

impl Lengths {
    pub fn new(strips: usize) -> Lengths {
        let reals = || Vec::with_capacity(strips);
        Lengths { arcs: reals(), overlaps: reals(), curvatures: reals(), first: reals(), second: reals() }
    }

    /// Half lengths as in the Hertzian patch of the same proportions, and which strips carry load at first (`inside`).
    ///
    /// There `A a^2 + B b^2 = delta`, and the strip at the edge still overlaps by `e delta` with `e = A a^2 / delta`, a function of A / B alone that is
    /// `1 / (1 + (A / B)^0.3)` to 0.013 from b/a = 1/20 to 20: `a_i^2 = 2 e (d_i - e delta) / ((1 - e) kappa_i)`. B and delta are those of the parabola
    /// with the same sums of d and d^2 over what is near; A is kappa / 2.
    pub fn find(&mut self, rail: &RailStrips, pressed: &mut [Pressed], inside: &mut Vec<bool>) {
        let Lengths { arcs, overlaps, curvatures, first, second } = self;
        let count = pressed.len();
        for (reals, of) in [
            (&mut *arcs, (|own, rail| rail.strip(own.number).arc) as fn(&Pressed, &RailStrips) -> f64),
            (overlaps, |own, _| own.strip.overlap),
            (curvatures, |own, _| own.strip.curvature),
        ] {
            reals.clear();
            reals.extend(pressed.iter().map(|own| of(own, rail)));
        }
        for sum in [&mut *first, &mut *second] {
            sum.clear();
            sum.resize(count, 0.0);
        }
        for other in pressed.iter() {
            let area = other.width * other.strip.overlap.max(0.0);
            let (arc, moment) = (rail.strip(other.number).arc, area * other.strip.overlap);
            for ((first, second), own) in first.iter_mut().zip(second.iter_mut()).zip(arcs.iter()) {
                let part = (own - arc) * (1.0 / WINDOW);
                let left = 1.0 - part * part;
                let left = if left > 0.0 { left } else { 0.0 };
                *first += left * left * area;
                *second += left * left * moment;
            }
        }
        // What is above the edge, and the square of the half length, in the places of the sums.
        for (((first, second), overlap), curvature) in first.iter_mut().zip(second.iter_mut()).zip(overlaps.iter()).zip(curvatures.iter()) {
            // 5/4 of the ratio is delta, and 4/3 delta sqrt(delta / B) the first sum.
            let deepest = 1.25 * *second / *first;
            let half_width = 0.75 * *first / deepest;
            let edge = 1.0 / (1.0 + power(0.5 * curvature * half_width * half_width / deepest, 0.3));
            let above = overlap - edge * deepest;
            (*first, *second) = (above, 2.0 * edge * above / ((1.0 - edge) * curvature));
        }
        inside.clear();
        inside.extend(first.iter().map(|above| *above > 0.0));
        for (own, square) in pressed.iter_mut().zip(second.iter()) {
            own.half_length = square.max(SHORTEST * SHORTEST).sqrt();
        }
    }
}
