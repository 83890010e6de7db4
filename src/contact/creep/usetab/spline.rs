//! Interpolation of the table: quadratic splines on an even lattice.
//!
//! In each of the four directions K is a sum of quadratic B-splines centred at the lattice points. Three of them act at
//! a place (81 numbers in all, where cubic convolution would need 256), and the first derivatives are continuous. The
//! coefficients c that make the spline pass through the tabulated values f solve `(c_{i-1} + 6 c_i + c_{i+1}) / 8 = f_i`
//! along each lattice line, with `c = f` at its ends; this is done once, when the table is read.
//!
//! Reference: Unser, Splines: a perfect fit for signal and image processing, IEEE Signal Processing Magazine 16 (1999).

use super::coordinates::{RATIOS, Triple, size, spin_weight};
use super::layout::{Layout, Slopes};

/// Coefficients of K and of the slopes.
#[derive(Clone, Debug)]
pub(crate) struct Spline {
    steps: f64,
    /// Lattice points in memory along X and Z (from -1 to n + 1), and along Y (from -n-1 to n + 1).
    depth: usize,
    rows: usize,
    /// One more shape at each end.
    shapes: usize,
    /// Three components and a gap.
    values: Vec<[f32; 4]>,
    slopes: Vec<[f64; 5]>,
    /// Shapes per unit of ln(a/b), and ln of the smallest.
    shapes_per_unit: f64,
    first: f64,
}

/// Weights of three points at `t` from the middle one, |t| <= 1/2.
#[inline]
fn weights(t: f64) -> [f64; 3] {
    let (left, right) = (0.5 - t, 0.5 + t);
    [0.5 * left * left, 0.75 - t * t, 0.5 * right * right]
}

/// Turns values along a line into coefficients (Thomas algorithm).
fn filter<const C: usize>(line: &mut [[f64; C]], scratch: &mut Vec<f64>) {
    let n = line.len();
    if n < 3 {
        return;
    }
    scratch.clear();
    scratch.push(0.0);
    for i in 1..n - 1 {
        let pivot = 1.0 / (6.0 - scratch[i - 1]);
        scratch.push(pivot);
        // The end is known, so its term moves to the right-hand side.
        let end = if i + 2 == n { line[n - 1] } else { [0.0; C] };
        let before = line[i - 1];
        line[i] = std::array::from_fn(|c| (8.0 * line[i][c] - before[c] - end[c]) * pivot);
    }
    for i in (1..n.saturating_sub(2)).rev() {
        let next = line[i + 1];
        line[i] = std::array::from_fn(|c| line[i][c] - scratch[i] * next[c]);
    }
}

/// Point beyond the end on the parabola through the last three.
fn beyond<const C: usize>(a: [f64; C], b: [f64; C], c: [f64; C]) -> [f64; C] {
    std::array::from_fn(|k| 3.0 * (a[k] - b[k]) + c[k])
}

/// The whole lattice, mirror images included, while the coefficients are found.
struct Whole {
    side: usize,
    shapes: usize,
    used: Vec<bool>,
    values: Vec<Triple>,
}

impl Whole {
    fn new(layout: &Layout, stored: &[Triple]) -> Self {
        let (side, middle, half) = (2 * layout.steps + 3, layout.steps + 1, layout.steps + 2);
        let (points, last) = (layout.points(), layout.shapes - 1);
        let mut whole = Whole { side, shapes: layout.shapes + 2, used: Vec::new(), values: Vec::new() };
        let shape = |s: usize, index: usize| {
            let at = |s: usize| stored[s * points + index];
            match s {
                0 => beyond(at(0), at(1), at(2)),
                s if s <= last + 1 => at(s - 1),
                _ => beyond(at(last), at(last - 1), at(last - 2)),
            }
        };
        for s in 0..whole.shapes {
            for i in 0..side {
                for j in 0..side {
                    for k in 0..side {
                        let x = if i < middle { -1.0 } else { 1.0 };
                        let z = if k < middle { -1.0 } else { 1.0 };
                        let row = if k < middle { side - 1 - j } else { j };
                        let index = (i.abs_diff(middle) * side + row) * half + k.abs_diff(middle);
                        let [fx, fy, mz] = shape(s, index);
                        whole.values.push([x * fx, z * fy, z * mz]);
                        if s == 0 {
                            whole.used.push(layout.used(layout.place(index)));
                        }
                    }
                }
            }
        }
        whole
    }

    /// Filters along each axis and over the shapes; points that are not used end a line.
    fn filter(&mut self) {
        let (side, points) = (self.side, self.side * self.side * self.side);
        let (mut line, mut scratch): (Vec<Triple>, Vec<f64>) = (Vec::new(), Vec::new());
        for stride in [side * side, side, 1] {
            for shape in 0..self.shapes {
                for start in (0..points).filter(|p| p / stride % side == 0) {
                    let place = |i: usize| start + i * stride;
                    let Some(from) = (0..side).find(|i| self.used[place(*i)]) else { continue };
                    let to = (from..side).find(|i| !self.used[place(*i)]).unwrap_or(side);
                    line.clear();
                    line.extend((from..to).map(|i| self.values[shape * points + place(i)]));
                    filter(&mut line, &mut scratch);
                    for (i, value) in (from..to).zip(&line) {
                        self.values[shape * points + place(i)] = *value;
                    }
                }
            }
        }
        for point in 0..points {
            line.clear();
            line.extend((0..self.shapes).map(|s| self.values[s * points + point]));
            filter(&mut line, &mut scratch);
            for (s, value) in line.iter().enumerate() {
                self.values[s * points + point] = *value;
            }
        }
    }
}

impl Spline {
    /// From the stored half of K and the slopes, shape after shape.
    pub(crate) fn new(layout: &Layout, slopes: &[Slopes], stored: &[Triple]) -> Self {
        let mut whole = Whole::new(layout, stored);
        whole.filter();
        let (side, last) = (whole.side, slopes.len() - 1);
        // The slope of Fy over Z contains 1/k, which is not left to the spline.
        let scaled = |(shape, slopes): (usize, &Slopes)| {
            let [xx, yy, yz, zy, zz] = slopes.0;
            [xx, yy, yz * spin_weight(layout.ratio(shape)), zy, zz]
        };
        let given: Vec<[f64; 5]> = slopes.iter().enumerate().map(scaled).collect();
        let mut slopes = vec![beyond(given[0], given[1], given[2])];
        slopes.extend(&given);
        slopes.push(beyond(given[last], given[last - 1], given[last - 2]));
        filter(&mut slopes, &mut Vec::new());
        let values = (0..whole.values.len())
            .filter(|index| index / (side * side) % side >= layout.steps && index % side >= layout.steps)
            .map(|index| whole.values[index])
            .map(|[x, y, spin]| [x as f32, y as f32, spin as f32, 0.0])
            .collect();
        let (first, last) = (RATIOS.0.ln(), RATIOS.1.ln());
        Spline {
            steps: layout.steps as f64,
            depth: layout.steps + 3,
            rows: side,
            shapes: whole.shapes,
            values,
            slopes,
            shapes_per_unit: (layout.shapes - 1) as f64 / (last - first),
            first,
        }
    }

    /// Force in mu N and moment in mu N sqrt(a b) at `u` in the ball; `a_over_b` within the table.
    #[inline]
    pub(crate) fn force(&self, a_over_b: f64, u: Triple) -> Triple {
        // Into the quarter in memory.
        let x_sign = if u[0] < 0.0 { -1.0 } else { 1.0 };
        let z_sign = if u[2] < 0.0 { -1.0 } else { 1.0 };
        let u = [x_sign * u[0], z_sign * u[1], z_sign * u[2]];
        // Nearest lattice point, as the place in memory of the one before it, and the weights of three.
        let split = |x: f64| {
            let nearest = (x + 0.5) as usize;
            (nearest, weights(x - nearest as f64))
        };
        let n = self.steps;
        let (shape, ws) = split(((a_over_b.ln() - self.first) * self.shapes_per_unit).clamp(0.0, (self.shapes - 3) as f64));
        let ((i, wi), (j, wj), (k, wk)) = (split(u[0] * n), split(u[1] * n + n), split(u[2] * n));
        // The table is kept in single precision, the sum is not: what integrates over it sees no noise.
        let mut sum = [0f64; 4];
        let mut slopes = [0.0; 5];
        for (s, ws) in ws.into_iter().enumerate() {
            for (slope, c) in slopes.iter_mut().zip(&self.slopes[shape + s]) {
                *slope += ws * c;
            }
            for (di, wi) in wi.into_iter().enumerate() {
                let start = (((shape + s) * self.depth + i + di) * self.rows + j) * self.depth + k;
                let outer = ws * wi;
                for (dj, wj) in wj.into_iter().enumerate() {
                    let line = self.values.get(start + dj * self.depth..).and_then(|rest| rest.first_chunk::<3>());
                    let Some([p, q, r]) = line else { continue };
                    let weight = outer * wj;
                    let w = wk.map(|w| w * weight);
                    for c in 0..4 {
                        sum[c] += w[0] * f64::from(p[c]) + w[1] * f64::from(q[c]) + w[2] * f64::from(r[c]);
                    }
                }
            }
        }
        slopes[2] /= spin_weight(a_over_b);
        let linear = Slopes(slopes).force(u);
        let radius = size(u);
        let force: Triple = std::array::from_fn(|c| linear[c] + radius * sum[c]);
        [x_sign * force[0], z_sign * force[1], z_sign * force[2]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_coefficients_give_back_the_values() {
        let values = [1.0, -2.0, 0.5, 4.0, 3.0, 3.5, -1.0];
        let mut line = values.map(|v| [v]);
        filter(&mut line, &mut Vec::new());
        for i in 1..values.len() - 1 {
            let [a, b, c] = weights(0.0);
            let found = a * line[i - 1][0] + b * line[i][0] + c * line[i + 1][0];
            assert!((found - values[i]).abs() < 1e-14, "{i}: {found}");
        }
        assert_eq!((line[0][0], line[6][0]), (1.0, -1.0));
    }
}
