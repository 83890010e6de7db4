//! Humps of a row of depths: where an overlap is deepest, and where it is deepest beside that.
//!
//! A hump is told by its prominence, its depth less that of the saddle between it and a deeper one: what is left of one is small where it merges
//! with its saddle, whatever its depth.

/// Humps that are told apart; of more, the one that stands out least is filled.
const MOST: usize = 16;

/// Depths, passed in their order along a profile, each with its place.
#[derive(Clone, Copy, Debug)]
pub struct Humps<P> {
    /// In the order of the row: depth, m, and place.
    humps: [Option<(f64, P)>; MOST],
    count: usize,
    /// Depth of the saddle behind each, m.
    saddles: [f64; MOST],
    /// Least depth since the last hump's top, m.
    valley: f64,
}

impl<P: Copy> Default for Humps<P> {
    fn default() -> Self {
        Humps { humps: [None; MOST], count: 0, saddles: [f64::INFINITY; MOST], valley: f64::INFINITY }
    }
}

impl<P: Copy> Humps<P> {
    /// Takes the next depth [m].
    #[inline]
    pub fn pass(&mut self, depth: f64, place: P) {
        let top = self.humps[..self.count].last().and_then(|hump| hump.map(|hump| hump.0));
        match top {
            Some(top) if self.valley < top => {
                // On its way down, or up again.
                if depth > self.valley {
                    self.begin(depth, place);
                } else {
                    self.valley = depth;
                }
            }
            Some(top) if depth > top => {
                self.humps[self.count - 1] = Some((depth, place));
                self.valley = depth;
            }
            Some(_) => self.valley = self.valley.min(depth),
            None => self.begin(depth, place),
        }
    }

    /// Nothing overlaps here.
    #[inline]
    pub fn part(&mut self) {
        self.valley(0.0);
    }

    /// It is no deeper than this [m] here.
    #[inline]
    pub fn valley(&mut self, depth: f64) {
        self.valley = self.valley.min(depth);
    }

    fn begin(&mut self, depth: f64, place: P) {
        if self.count == MOST {
            self.fill(self.least_prominent());
        }
        if let Some(before) = self.count.checked_sub(1) {
            self.saddles[before] = self.valley;
        }
        self.humps[self.count] = Some((depth, place));
        self.count += 1;
        self.valley = depth;
    }

    fn depth(&self, k: usize) -> f64 {
        self.humps[k].map_or(f64::NEG_INFINITY, |hump| hump.0)
    }

    /// Of the saddles the one over which the lower hump beside it stands out least.
    fn least_prominent(&self) -> usize {
        let prominence = |k: usize| self.depth(k).min(self.depth(k + 1)) - self.saddles[k];
        (0..self.count.saturating_sub(1)).min_by(|a, b| prominence(*a).total_cmp(&prominence(*b))).unwrap_or(0)
    }

    /// Joins the humps on both sides of a saddle.
    fn fill(&mut self, k: usize) {
        let (lower, deepest) = if self.depth(k) > self.depth(k + 1) { (k + 1, self.humps[k]) } else { (k, self.humps[k + 1]) };
        // The saddle on the other side of the lower one now belongs to the deeper one.
        if lower > k && lower + 1 < self.count {
            self.saddles[lower] = self.saddles[lower].min(self.saddles[k]);
        } else if lower == k && k > 0 {
            self.saddles[k - 1] = self.saddles[k - 1].min(self.saddles[k]);
        }
        self.humps[k] = deepest;
        self.humps[k + 1..self.count].rotate_left(1);
        self.saddles[k..self.count].rotate_left(1);
        self.count -= 1;
    }

    /// Fills saddles until at most `most` humps are left, each of which stands out by more than the share `least` of the greatest depth where it
    /// overlaps with its neighbour. So that they rise from there, saddles are then taken to be higher by so much.
    pub fn settle(&mut self, most: usize, least: f64) {
        let least = least * self.deepest();
        loop {
            let shared = |k: &usize| self.saddles[*k] > 0.0 && self.depth(*k).min(self.depth(k + 1)) <= self.saddles[*k] + least;
            let small = (0..self.count.saturating_sub(1)).find(shared);
            let Some(k) = small.or_else(|| (self.count > most).then(|| self.least_prominent())) else { break };
            self.fill(k);
        }
        for saddle in self.saddles.iter_mut().take(self.count).filter(|saddle| **saddle > 0.0) {
            *saddle += least;
        }
    }

    /// Greatest depth, m; negative infinity where nothing was passed.
    fn deepest(&self) -> f64 {
        (0..self.count).map(|k| self.depth(k)).fold(f64::NEG_INFINITY, f64::max)
    }

    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Depths [m] and places in the order of the row.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = (f64, P)> + '_ {
        self.humps[..self.count].iter().filter_map(|hump| *hump)
    }

    /// Depths of the saddles between them, m; not positive where they are apart.
    pub fn saddles(&self) -> &[f64] {
        &self.saddles[..self.count.saturating_sub(1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(depths: &[f64], most: usize) -> (Vec<usize>, Vec<f64>) {
        let mut humps = Humps::default();
        for (place, depth) in depths.iter().enumerate() {
            if *depth > 0.0 {
                humps.pass(*depth, place);
            } else {
                humps.part();
            }
        }
        humps.settle(most, 0.0);
        (humps.iter().map(|hump| hump.1).collect(), humps.saddles().to_vec())
    }

    #[test]
    fn analytic_humps_of_rows() {
        assert_eq!(of(&[1.0, 2.0, 5.0, 4.0, 1.0], 2), (vec![2], vec![]));
        assert_eq!(of(&[1.0, 5.0, 2.0, 4.0, 1.0], 2), (vec![1, 3], vec![2.0]));
        assert_eq!(of(&[4.0, 1.0, 3.0, 2.0, 5.0], 3), (vec![0, 2, 4], vec![1.0, 2.0]));
        assert_eq!(of(&[4.0, 1.0, 3.0, 2.0, 5.0], 2), (vec![0, 4], vec![1.0]));
        assert_eq!(of(&[4.0, 3.5, 3.9, 2.0, 5.0, 1.0, 3.0], 3), (vec![0, 4, 6], vec![2.0, 1.0]));
        assert_eq!(of(&[4.0, 4.0, 3.0, 3.0, 3.5, 3.5, 3.0], 4), (vec![0, 4], vec![3.0]));
        // Apart.
        assert_eq!(of(&[2.0, 0.0, 0.0, 1.0, 3.0, 1.0, 0.0], 4), (vec![0, 4], vec![0.0]));
        assert_eq!(of(&[], 4), (vec![], vec![]));
        // More than there is room for: the small ones go.
        let waves: Vec<f64> = (0..200).map(|k| if k % 2 == 0 { 5.0 } else { 4.0 - if k == 99 { 2.0 } else { 0.0 } }).collect();
        assert_eq!(of(&waves, 2).1, vec![2.0]);
    }

    #[test]
    fn analytic_small_humps_are_none_and_rise_from_there() {
        let of = |depths: &[f64]| {
            let mut humps = Humps::default();
            depths.iter().enumerate().for_each(|(place, depth)| humps.pass(*depth, place));
            humps.settle(4, 1e-3);
            (humps.iter().count(), humps.saddles().first().copied())
        };
        assert_eq!(of(&[10.0, 5.0, 5.009]), (1, None));
        assert_eq!(of(&[10.0, 5.0, 5.011]), (2, Some(5.01)));
    }

    #[test]
    fn equiv_mirrored_rows_have_the_same_humps() {
        let mut state = 3u64;
        for _ in 0..2000 {
            let row: Vec<f64> = (0..9)
                .map(|_| {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    (state >> 33) as f64
                })
                .collect();
            let mirrored: Vec<f64> = row.iter().rev().copied().collect();
            let (one, mut other) = (of(&row, 3), of(&mirrored, 3));
            other.1.reverse();
            let depths = |row: &[f64], places: &[usize]| places.iter().map(|place| row[*place]).collect::<Vec<_>>();
            let mut seen = depths(&mirrored, &other.0);
            seen.reverse();
            assert_eq!((depths(&row, &one.0), one.1), (seen, other.1), "{row:?}");
        }
    }
}
