//! A speed that is imposed over time or over distance, from a table.
//!
//! The speed V passes through every node. Its slope (over time: the acceleration) is a trapezium between two nodes: it changes linearly
//! over a length w behind the first, is constant, and changes linearly over w before the second. With the slopes k0 and k1 at the nodes, which
//! are T apart and differ by D in speed,
//!
//! ```text
//! p = (D - w (k0 + k1) / 2) / (T - w)       slope between the corners
//! k = 0 at the first node, the last one, and where slopes to both sides differ in sign; else 2 / (1 / a + 1 / b)
//! ```
//!
//! where a and b are the mean slopes to both sides. So V is smooth (its rate has no jumps), is constant before the first node and behind the last one, and
//! does not overshoot: |k| <= 2 |D| / T and w <= T / 4 leave p the sign of D.

use std::f64::consts::PI;

/// What a speed is given over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// s.
    Time,
    /// Of the leading driven wheelset along the track, m.
    Distance,
}

/// w, s and m, and its largest part of the way between two nodes.
const CORNER_TIME: f64 = 1.0;
const CORNER_LENGTH: f64 = 20.0;
const LARGEST_PART: f64 = 0.25;

/// From `from` on: `value + d (slope + d bend / 2)`, d behind `from`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    from: f64,
    value: f64,
    slope: f64,
    bend: f64,
}

impl Piece {
    fn at(&self, place: f64) -> [f64; 2] {
        let d = place - self.from;
        [self.value + d * (self.slope + 0.5 * d * self.bend), self.slope + d * self.bend]
    }
}

/// V over time or distance.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedProfile {
    pub over: Over,
    nodes: Vec<[f64; 2]>,
    /// Ascending; the last one is constant.
    pieces: Vec<Piece>,
}

impl SpeedProfile {
    /// Through nodes [s or m, m/s], at least one, by ascending place.
    pub fn new(over: Over, nodes: Vec<[f64; 2]>) -> SpeedProfile {
        let corner = if over == Over::Time { CORNER_TIME } else { CORNER_LENGTH };
        let mean = |i: usize| (nodes[i + 1][1] - nodes[i][1]) / (nodes[i + 1][0] - nodes[i][0]);
        let slope = |i: usize| match i == 0 || i + 1 == nodes.len() {
            true => 0.0,
            false => between(mean(i - 1), mean(i)),
        };
        let mut pieces = Vec::with_capacity(3 * nodes.len());
        for (i, pair) in nodes.windows(2).enumerate() {
            let ([from, value], [to, _], [before, after]) = (pair[0], pair[1], [slope(i), slope(i + 1)]);
            let length = to - from;
            let w = corner.min(LARGEST_PART * length);
            let plateau = (length * mean(i) - 0.5 * w * (before + after)) / (length - w);
            let first = Piece { from, value, slope: before, bend: (plateau - before) / w };
            let middle = Piece { from: from + w, value: first.at(from + w)[0], slope: plateau, bend: 0.0 };
            let last = Piece { from: to - w, value: middle.at(to - w)[0], slope: plateau, bend: (after - plateau) / w };
            pieces.extend([first, middle, last]);
        }
        if let Some([place, value]) = nodes.last() {
            pieces.push(Piece { from: *place, value: *value, slope: 0.0, bend: 0.0 });
        }
        SpeedProfile { over, nodes, pieces }
    }

    /// The nodes, s or m and m/s.
    pub fn nodes(&self) -> &[[f64; 2]] {
        &self.nodes
    }

    /// V [m/s] and its slope there [m/s2 over time, 1/s over distance].
    #[inline]
    pub fn at(&self, place: f64) -> [f64; 2] {
        match self.pieces.partition_point(|piece| piece.from <= place).checked_sub(1) {
            Some(piece) => self.pieces[piece].at(place),
            None => [self.pieces.first().map_or(0.0, |piece| piece.value), 0.0],
        }
    }

    /// Where the slope bends next: ahead of `place` in the direction of travel, by more than `margin`; infinity for nowhere.
    pub fn next_bend(&self, place: f64, direction: f64, margin: f64) -> f64 {
        let all = self.pieces.iter().map(|piece| piece.from);
        let ahead = all.filter(|from| direction * (from - place) > margin);
        ahead.min_by(|a, b| (direction * (a - b)).total_cmp(&0.0)).unwrap_or(direction * f64::INFINITY)
    }

    /// Smallest and largest |V|, m/s.
    pub fn range(&self) -> [f64; 2] {
        let sizes = || self.nodes.iter().map(|node| node[1].abs());
        [sizes().fold(f64::INFINITY, f64::min), sizes().fold(0.0, f64::max)]
    }

    /// The largest |acceleration|, m/s2: over distance V V' is largest at a corner or inside of a ramp's faster half.
    pub fn steepest(&self) -> f64 {
        const READINGS: usize = 8;
        let mut largest: f64 = 0.0;
        for pair in self.pieces.windows(2) {
            for k in 0..=READINGS {
                // Denser at the ends.
                let share = 0.5 * (1.0 - (PI * k as f64 / READINGS as f64).cos());
                let [speed, slope] = pair[0].at(pair[0].from + share * (pair[1].from - pair[0].from));
                largest = largest.max(match self.over {
                    Over::Time => slope.abs(),
                    Over::Distance => (slope * speed).abs(),
                });
            }
        }
        largest
    }
}

/// Slope at a node between two mean slopes.
fn between(a: f64, b: f64) -> f64 {
    if a * b > 0.0 { 2.0 / (1.0 / a + 1.0 / b) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile() -> SpeedProfile {
        SpeedProfile::new(Over::Time, vec![[2.0, 10.0], [10.0, 30.0], [12.0, 31.0], [12.5, 31.0], [20.0, 12.0]])
    }

    #[test]
    fn analytic_it_passes_its_nodes_and_is_smooth() {
        let profile = profile();
        for [place, value] in profile.nodes() {
            assert!((profile.at(*place)[0] - value).abs() < 1e-12);
        }
        for from in profile.pieces.iter().map(|piece| piece.from) {
            let ([a, da], [b, db]) = (profile.at(from - 1e-9), profile.at(from));
            assert!((a - b).abs() < 1e-7 && (da - db).abs() < 1e-6, "{from}: {a} {b}, {da} {db}");
        }
        assert_eq!(profile.at(-5.0), [10.0, 0.0]);
        assert_eq!(profile.at(2.0), [10.0, 0.0]);
        assert_eq!(profile.at(99.0), [12.0, 0.0]);
    }

    #[test]
    fn analytic_one_ramp_is_a_trapezium() {
        let profile = SpeedProfile::new(Over::Time, vec![[0.0, 10.0], [21.0, 30.0]]);
        // Corners of 1 s: 20 m/s in 20 s.
        assert_eq!(profile.at(5.0), [10.0 + 4.5, 1.0]);
        assert_eq!(profile.at(0.5)[1], 0.5);
        assert_eq!(profile.steepest(), 1.0);
        assert_eq!(profile.range(), [10.0, 30.0]);
    }

    #[test]
    fn prop_it_does_not_overshoot_and_its_slope_is_its_own() {
        let profile = profile();
        let all: Vec<[f64; 2]> = (0..=2200).map(|i| profile.at(0.01 * f64::from(i))).collect();
        for (i, pair) in all.windows(3).enumerate() {
            assert!((10.0..=31.0 + 1e-12).contains(&pair[1][0]), "{i}: {pair:?}");
            assert!(((pair[2][0] - pair[0][0]) / 0.02 - pair[1][1]).abs() < 0.3, "{i}: {pair:?}");
        }
        assert!(all[..1200].windows(2).all(|pair| pair[1][0] >= pair[0][0]));
    }

    #[test]
    fn prop_bends_ahead_are_found_both_ways() {
        let profile = SpeedProfile::new(Over::Distance, vec![[0.0, 10.0], [200.0, 30.0]]);
        assert_eq!(profile.next_bend(-7.0, 1.0, 0.0), 0.0);
        assert_eq!(profile.next_bend(0.0, 1.0, 0.0), 20.0);
        assert_eq!(profile.next_bend(100.0, -1.0, 0.0), 20.0);
        assert_eq!(profile.next_bend(20.0 + 1e-9, -1.0, 1e-6), 0.0);
        assert_eq!(profile.next_bend(200.0, 1.0, 0.0), f64::INFINITY);
        assert_eq!(profile.next_bend(0.0, -1.0, 0.0), f64::NEG_INFINITY);
    }
}
