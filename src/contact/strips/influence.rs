//! Mutual influence of two strips under semi-elliptic pressure.
//!
//! Two strips a distance y apart carry 1 N each over the half lengths a1, a2, the pressure falling as `sqrt(1 - x^2 / a^2)`; the middle of one may lie
//! `shift` ahead of the other's. The mean displacement of one, weighted by its own pressure, under the load of the other is
//!
//! ```text
//! K = (1 - nu) / (pi G)  E[ 1 / sqrt((X + shift)^2 + y^2) ],     X = x1 - x2 distributed like both pressures
//! ```
//!
//! (Boussinesq, both bodies; the same both ways round). The density of X is taken as two boxes of equal height k, half widths c1, c2: their height at
//! the middle is that of X and their variance is `(a1^2 + a2^2) / 4 = s^2 / 2`, so that K is right for strips that are very near (logarithm) and far. In
//! units of s, with p0 the density at the middle,
//!
//! ```text
//! k = p0 / 2,   c = (1 / p0 +- sqrt(2 - 1 / (3 p0^2))) / 2,     E = k sum over c of [ asinh((shift + c) / y) - asinh((shift - c) / y) ]
//! ```
//!
//! Against the integral with a1 = a2: 0.8 % without shift, 4 % with shift and y of a fifth of s or more (16 % at shift = s / 2, y = s / 100).

use super::pressed::Pressed;
use super::rail::RailStrips;
use crate::math::elementary::logarithm;
use crate::math::smooth_step::cubic_step;

/// p0 by powers of the squared ratio of the half lengths, the smaller over the larger: fits the convolution of both pressures to 4e-5. 0.4502 is
/// `sqrt(2) / pi`, 0.5404 at equal lengths `16 / (3 pi^2)`.
const MIDDLE: [f64; 6] = [0.450_146_75, 0.169_474_58, -0.096_090_9, 0.037_861_78, -0.021_006_99, 0.0];
/// The same for c of both boxes over s, to 4e-4.
const NARROWER: [f64; 6] = [0.812_479_16, -0.918_749_79, 1.185_709_95, -1.206_323_55, 0.804_771_86, -0.216_100_44];
const WIDER: [f64; 6] = [1.408_964_31, 0.084_917_05, -0.424_432_04, 0.670_884_61, -0.511_847_05, 0.160_214_29];

/// Shifts below this part of s enter by their square: E is then right to 1e-4. From 0.7 of it on the full formula comes in smoothly.
const SMALL_SHIFT: f64 = 0.1;

/// Written out: the compiler then finds several at once.
#[inline(always)]
fn polynomial(by: &[f64; 6], x: f64) -> f64 {
    by[0] + x * (by[1] + x * (by[2] + x * (by[3] + x * (by[4] + x * by[5]))))
}

/// What strips feel of each other by, one after the other: numbers that run along, for the vector instructions of the compiler.
#[derive(Clone, Debug, Default)]
pub(super) struct Feeling {
    numbers: Vec<usize>,
    /// Squares of the half lengths, m^2, and leads, m.
    squares: Vec<f64>,
    leads: Vec<f64>,
    /// Distances from the strip whose row is made, m, then their squares.
    apart: Vec<f64>,
    /// Of strips that are pressed over a part of their width: that width, and how far its middle lies from the strip's, m; else no width.
    cuts: Vec<(f64, f64)>,
}

impl Feeling {
    pub fn new(strips: usize) -> Feeling {
        let reals = || Vec::with_capacity(strips);
        Feeling { numbers: Vec::with_capacity(strips), squares: reals(), leads: reals(), apart: reals(), cuts: Vec::with_capacity(strips) }
    }

    pub fn fill(&mut self, rail: &RailStrips, pressed: &[Pressed]) {
        let cut = |own: &Pressed| if own.width < rail.strip(own.number).width { (own.width, own.offset) } else { (0.0, 0.0) };
        self.cuts.clear();
        self.cuts.extend(pressed.iter().map(cut));
        self.numbers.clear();
        self.numbers.extend(pressed.iter().map(|own| own.number));
        self.squares.clear();
        self.squares.extend(pressed.iter().map(|own| own.half_length * own.half_length));
        self.leads.clear();
        self.leads.extend(pressed.iter().map(|own| own.strip.lead));
    }

    /// E, 1/m, of strip `own` with all strips, whose middles lie at `arcs` [m], a row of the `matrix`; rows that are known are taken for their columns.
    pub fn row(&mut self, rail: &RailStrips, arcs: &[f64], own: usize, matrix: &mut [f64], known: &[bool]) {
        self.distances(rail, &arcs[own..], own);
        let Feeling { numbers, squares, leads, apart, cuts } = self;
        let count = numbers.len();
        let (square, lead) = (squares[own], leads[own]);
        for other in 0..own {
            matrix[own * count + other] = if known[other] {
                matrix[other * count + own]
            } else {
                let felt = rail.apart(numbers[own], numbers[other]);
                let apart = between(felt, arcs[other] - arcs[own], [cuts[own], cuts[other]]);
                pair(apart * apart, [square, squares[other]], leads[other] - lead)
            };
        }
        let (squares, leads, row) = (&squares[own..], &leads[own..], &mut matrix[own * count + own..(own + 1) * count]);
        let shifted = squares.iter().zip(leads).filter(|(other, ahead)| !small(**ahead - lead, [square, **other])).count();
        let pairs = row.iter_mut().zip(apart.iter()).zip(squares).zip(leads);
        // The same numbers, sooner: several at once, or the few that are shifted one by one.
        if MANY * shifted > squares.len() {
            for (((value, y2), other), ahead) in pairs {
                *value = pair(*y2, [square, *other], ahead - lead);
            }
            return;
        }
        for (((value, y2), other), ahead) in pairs {
            *value = near(*y2, boxes(square, *other), ahead - lead);
        }
        if shifted > 0 {
            for (((value, y2), other), ahead) in row.iter_mut().zip(apart.iter()).zip(squares).zip(leads) {
                if !small(ahead - lead, [square, *other]) {
                    *value = pair(*y2, [square, *other], ahead - lead);
                }
            }
        }
    }

    /// Squares of the distances at which a strip feels itself and those after it, whose middles lie at `arcs` [m].
    fn distances(&mut self, rail: &RailStrips, arcs: &[f64], own: usize) {
        let Feeling { numbers, apart, cuts, .. } = self;
        let (here, cuts) = (arcs[0], &cuts[own..]);
        apart.clear();
        apart.extend(arcs.iter().map(|arc| arc - here));
        for (apart, number) in apart.iter_mut().zip(&numbers[own..]) {
            let Some(felt) = rail.felt(numbers[own]).get(number - numbers[own]) else { break };
            *apart = *felt;
        }
        let (itself, others) = (cuts[0], apart.iter_mut().zip(arcs).zip(cuts).skip(1));
        for ((apart, arc), cut) in others {
            *apart = between(*apart, arc - here, [itself, *cut]);
        }
        if itself.0 != 0.0 {
            apart[0] = ITSELF * itself.0;
        }
        apart.iter_mut().for_each(|apart| *apart *= *apart);
    }
}

/// A strip feels itself at this part of its width: `exp(-3/2)`.
const ITSELF: f64 = 0.223_130_16;

/// The distance at which two strips feel each other whose middles are `gap` apart and that feel each other at `felt` where both are pressed over their whole
/// width, m: from the middles of what is pressed of them.
#[inline(always)]
fn between(felt: f64, gap: f64, [(width, from), (other, to)]: [(f64, f64); 2]) -> f64 {
    if width == 0.0 && other == 0.0 { felt } else { felt * ((gap + to - from) / gap).abs() }
}

/// A row of which more than one in so many is shifted is found with the formula for shifts.
const MANY: usize = 4;

/// Half the square of [`SMALL_SHIFT`]: over the sum of two squared half lengths, so much of the square of a shift is large, and half of it still small.
const LARGE: f64 = 0.5 * SMALL_SHIFT * SMALL_SHIFT;

#[inline(always)]
fn small(shift: f64, [one, other]: [f64; 2]) -> bool {
    shift * shift <= 0.5 * LARGE * (one + other)
}

/// E, 1/m, of two strips with squares of their distance and of their half lengths, m^2. Without branches, for the vector instructions.
#[inline(always)]
fn pair(y2: f64, [one, other]: [f64; 2], shift: f64) -> f64 {
    let both = boxes(one, other);
    let of_small = near(y2, both, shift);
    let part = cubic_step(shift * shift / (0.5 * LARGE * (one + other)) - 1.0);
    of_small + part * (far(y2, both, shift.abs()) - of_small)
}

/// What two strips have in common: k, and c of both boxes, from the squares of their half lengths.
#[inline(always)]
fn boxes(one: f64, other: f64) -> (f64, [f64; 2]) {
    let (small, large) = if one < other { (one, other) } else { (other, one) };
    let ratio = small / large;
    let s = (0.5 * (small + large)).sqrt();
    (0.5 * polynomial(&MIDDLE, ratio) / s, [s * polynomial(&NARROWER, ratio), s * polynomial(&WIDER, ratio)])
}

/// E, 1/m, of two strips with the square of their distance, m^2, and a small shift, m.
#[inline(always)]
fn near(y2: f64, (height, [c1, c2]): (f64, [f64; 2]), shift: f64) -> f64 {
    let (root1, root2) = ((c1 * c1 + y2).sqrt(), (c2 * c2 + y2).sqrt());
    let reach = (c1 + root1) * (c2 + root2) / y2;
    let (cube1, cube2) = (root1 * root1 * root1, root2 * root2 * root2);
    // Half the second derivative of both differences of asinh by the shift.
    let less = (c1 * cube2 + c2 * cube1) / (cube1 * cube2);
    height * (2.0 * logarithm(reach) - shift * shift * less)
}

/// The same with any shift, not negative.
#[inline(always)]
fn far(y2: f64, (height, [c1, c2]): (f64, [f64; 2]), shift: f64) -> f64 {
    let ([over1, under1], [over2, under2]) = (ratio_of_reaches(shift, c1, y2), ratio_of_reaches(shift, c2, y2));
    height * logarithm(over1 * over2 / (under1 * under2))
}

/// exp of `asinh((shift + c) / y) - asinh((shift - c) / y)`, as numerator and denominator.
#[inline(always)]
fn ratio_of_reaches(shift: f64, c: f64, y2: f64) -> [f64; 2] {
    let (far, near) = (shift + c, shift - c);
    let far = far + (far * far + y2).sqrt();
    let beside = near.abs() + (near * near + y2).sqrt();
    let within = near < 0.0;
    [far * if within { beside } else { 1.0 }, if within { y2 } else { beside }]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn of_pair(apart: f64, lengths: [f64; 2], shift: f64) -> f64 {
        pair(apart * apart, lengths.map(|length| length * length), shift)
    }

    /// E by summation over both semi-ellipses.
    fn summed(apart: f64, lengths: [f64; 2], shift: f64) -> f64 {
        let nodes =
            |n: usize| (1..=n).map(move |k| k as f64 * PI / (n + 1) as f64).map(move |t| (t.cos(), 2.0 / (n + 1) as f64 * t.sin().powi(2)));
        let inner = |x: f64| -> f64 { nodes(1501).map(|(t, w)| w / (x + shift - lengths[1] * t).hypot(apart)).sum() };
        nodes(1000).map(|(t, w)| w * inner(lengths[0] * t)).sum()
    }

    #[test]
    fn analytic_influence_is_that_of_two_semi_ellipses() {
        let mut worst: [f64; 2] = [0.0; 2];
        for lengths in [[5e-3, 5e-3], [5e-3, 3e-3], [1e-3, 4e-3]] {
            for apart in [3e-4, 1e-3, 4e-3, 2e-2] {
                for (k, shift) in [0.0, 2e-3].into_iter().enumerate() {
                    let off = of_pair(apart, lengths, shift) / summed(apart, lengths, shift) - 1.0;
                    println!("{lengths:?} {apart} {shift}: {off:+.4}");
                    worst[k] = worst[k].max(off.abs());
                }
            }
        }
        assert!(worst[0] < 0.012 && worst[1] < 0.16, "{worst:?}");
    }

    #[test]
    fn prop_small_and_large_shifts_meet() {
        for (apart, lengths) in [(4e-5, [5e-3f64, 4e-3f64]), (4e-4, [5e-3, 4e-3]), (4e-3, [1e-3, 4e-3])] {
            let [one, other] = lengths.map(|length| length * length);
            let s = (0.5 * (one + other)).sqrt();
            let both = boxes(one, other);
            let off = |shift: f64| near(apart * apart, both, shift * s) / far(apart * apart, both, shift * s) - 1.0;
            println!("{apart} {lengths:?}: {:e}", off(SMALL_SHIFT));
            assert!(off(SMALL_SHIFT).abs() < 1e-4);
            for meets in [SMALL_SHIFT, SMALL_SHIFT * 0.5f64.sqrt()] {
                let at = |shift: f64| of_pair(apart, lengths, meets * s * shift);
                assert!((at(1.0 - 1e-9) / at(1.0 + 1e-9) - 1.0).abs() < 1e-9);
            }
        }
    }
}
