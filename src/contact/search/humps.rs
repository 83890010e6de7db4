//! The two humps of a row of depths: where an overlap is deepest, and where it is deepest beside that.
//!
//! A hump is told by its prominence, its depth less that of the saddle between it and the deepest place: what is left of a second one is
//! small where it merges with its saddle, whatever its depth.

/// Depths, passed in their order along a profile, each with its place.
#[derive(Clone, Copy, Debug)]
pub struct Humps<P> {
    deepest: Option<(f64, P)>,
    beside: Option<Hump<P>>,
    /// Least depth since the deepest one, m.
    valley: f64,
}

/// A hump beside the deepest one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hump<P> {
    pub place: P,
    /// m.
    pub depth: f64,
    /// Least depth between both, m.
    pub saddle: f64,
}

impl<P> Hump<P> {
    fn prominence(&self) -> f64 {
        self.depth - self.saddle
    }
}

impl<P: Copy> Humps<P> {
    pub fn new() -> Self {
        Humps { deepest: None, beside: None, valley: f64::INFINITY }
    }

    /// Takes the next depth [m].
    #[inline]
    pub fn pass(&mut self, depth: f64, place: P) {
        self.valley = self.valley.min(depth);
        match self.deepest {
            Some((deepest, _)) if depth <= deepest => {
                self.take(Hump { place, depth, saddle: self.valley });
            }
            before => {
                if let Some(beside) = &mut self.beside {
                    beside.saddle = beside.saddle.min(self.valley);
                }
                if let Some((depth, place)) = before {
                    self.take(Hump { place, depth, saddle: self.valley });
                }
                (self.deepest, self.valley) = (Some((depth, place)), depth);
            }
        }
    }

    #[inline]
    fn take(&mut self, hump: Hump<P>) {
        if hump.prominence() > self.beside.as_ref().map_or(0.0, Hump::prominence) {
            self.beside = Some(hump);
        }
    }

    /// The deepest place with its depth [m].
    pub fn deepest(&self) -> Option<(f64, P)> {
        self.deepest
    }

    /// The most prominent hump beside it.
    pub fn beside(&self) -> Option<Hump<P>> {
        self.beside
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(depths: &[f64]) -> Humps<usize> {
        let mut humps = Humps::new();
        for (place, depth) in depths.iter().enumerate() {
            humps.pass(*depth, place);
        }
        humps
    }

    #[test]
    fn analytic_humps_of_rows() {
        let beside = |depths: &[f64]| of(depths).beside().map(|hump| (hump.place, hump.saddle));
        assert_eq!(beside(&[1.0, 2.0, 5.0, 4.0, 1.0]), None);
        assert_eq!(beside(&[1.0, 5.0, 2.0, 4.0, 1.0]), Some((3, 2.0)));
        assert_eq!(beside(&[1.0, 4.0, 2.0, 5.0, 1.0]), Some((1, 2.0)));
        // The one between two higher ones is told by the saddle to the deepest.
        assert_eq!(beside(&[4.0, 1.0, 3.0, 2.0, 5.0]), Some((0, 1.0)));
        assert_eq!(beside(&[4.0, 3.5, 3.9, 2.0, 5.0, 1.0, 3.0]), Some((0, 2.0)));
        assert_eq!(of(&[3.0, 5.0, 2.0, 4.0]).deepest(), Some((5.0, 1)));
        assert_eq!(of(&[]).deepest(), None);
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
            let [one, other] = [of(&row), of(&mirrored)].map(|humps| humps.beside().map(|hump| (hump.depth, hump.saddle)));
            assert_eq!(one, other, "{row:?}");
        }
    }
}
