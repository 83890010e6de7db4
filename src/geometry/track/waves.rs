//! How finely a track must be looked at: where it is not plain, and the shortest length over which it changes there.
//!
//! A step that travels past a dip without evaluating anything in it knows nothing of it, and its error estimate is zero. So the track says
//! beforehand where it does anything, and how short its waves are: a [`Stretch`] for each effect, laid one over the other into [`Waves`].
//! [`Waves::reach`] is how far a wheel may travel in one step so that each wave is met by several steps.

/// Steps in the shortest wave, at least: a step of three or four evaluations then has a dozen and more in each, so that what a wave does
/// can't look like nothing to an error estimate. Where waves are felt, the error estimate itself asks for shorter steps.
pub(super) const STEPS_IN_WAVE: f64 = 4.0;

/// A part of the track in which something changes with the distance, and no wave is shorter than `wave`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Distances, m.
    pub from: f64,
    pub to: f64,
    /// m.
    pub wave: f64,
}

/// The shortest wave by distance: cells that do not overlap, with gaps where the track is plain.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Waves {
    cells: Vec<Stretch>,
}

impl Waves {
    /// Lays stretches one over the other; where several hold the shortest wave counts.
    pub fn new(stretches: impl IntoIterator<Item = Stretch>) -> Self {
        let mut open: Vec<Stretch> = stretches.into_iter().filter(|stretch| stretch.from < stretch.to && stretch.wave > 0.0).collect();
        open.sort_by(|a, b| a.from.total_cmp(&b.from));
        let mut places: Vec<f64> = open.iter().flat_map(|stretch| [stretch.from, stretch.to]).collect();
        places.sort_by(f64::total_cmp);
        places.dedup();
        let mut cells: Vec<Stretch> = Vec::new();
        let mut active: Vec<Stretch> = Vec::new();
        let mut next = 0;
        for pair in places.windows(2) {
            active.retain(|stretch| stretch.to > pair[0]);
            while let Some(stretch) = open.get(next).filter(|stretch| stretch.from <= pair[0]) {
                active.push(*stretch);
                next += 1;
            }
            let Some(wave) = active.iter().map(|stretch| stretch.wave).reduce(f64::min) else { continue };
            match cells.last_mut() {
                Some(last) if last.to == pair[0] && last.wave == wave => last.to = pair[1],
                _ => cells.push(Stretch { from: pair[0], to: pair[1], wave }),
            }
        }
        Waves { cells }
    }

    /// Of two tracks' effects together.
    pub fn with(&self, others: impl IntoIterator<Item = Stretch>) -> Self {
        Waves::new(self.cells.iter().copied().chain(others))
    }

    /// How far from `s` [m] in the given direction (sign of the speed) one step may reach, m: a part of the shortest wave of where it is, and
    /// no further than such a part into anything that lies ahead. Infinite where the track is plain as far as it goes.
    pub fn reach(&self, s: f64, speed: f64) -> f64 {
        if speed >= 0.0 {
            let first = self.cells.partition_point(|cell| cell.to <= s);
            within(self.cells[first..].iter().map(|cell| (cell.from - s, cell.wave)))
        } else {
            let behind = self.cells.partition_point(|cell| cell.from < s);
            within(self.cells[..behind].iter().rev().map(|cell| (s - cell.to, cell.wave)))
        }
    }

    /// The shortest wave at `s`, m; `None` where the track is plain.
    pub fn shortest_at(&self, s: f64) -> Option<f64> {
        let first = self.cells.partition_point(|cell| cell.to <= s);
        self.cells.get(first).filter(|cell| cell.from <= s).map(|cell| cell.wave)
    }

    /// Parts with the same shortest wave, which do not overlap.
    pub fn cells(&self) -> &[Stretch] {
        &self.cells
    }

    /// Where the track is plain everywhere.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }
}

/// How far one step may reach over cells by the way to them (negative inside one) and their wave, nearest first, m.
fn within(ahead: impl Iterator<Item = (f64, f64)>) -> f64 {
    let mut reach = f64::INFINITY;
    for (gap, wave) in ahead.map(|(gap, wave)| (gap.max(0.0), wave)) {
        if gap >= reach {
            break;
        }
        reach = reach.min(gap + wave / STEPS_IN_WAVE);
    }
    reach
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_step_enters_what_lies_ahead_by_a_part_of_its_wave() {
        let waves = Waves::new([
            Stretch { from: 60.0, to: 75.0, wave: 2.0 },
            Stretch { from: 70.0, to: 90.0, wave: 8.0 },
            Stretch { from: 72.0, to: 73.0, wave: 0.4 },
        ]);
        for (s, speed, expected) in [
            (0.0, 1.0, 60.5),
            (65.0, 1.0, 0.5),
            (71.8, 3.0, 0.3),
            (72.5, 1.0, 0.1),
            (74.9, 1.0, 0.5),
            (80.0, 1.0, 2.0),
            (90.0, 1.0, f64::INFINITY),
            (95.0, -1.0, 7.0),
            (76.0, -1.0, 1.5),
            (60.0, -1.0, f64::INFINITY),
            (61.0, -2.0, 0.5),
        ] {
            assert!(
                (waves.reach(s, speed) - expected).abs() < 1e-12 || waves.reach(s, speed) == expected,
                "{s}: {}",
                waves.reach(s, speed)
            );
        }
        assert_eq!(waves.shortest_at(72.2), Some(0.4));
        assert_eq!(waves.shortest_at(50.0), None);
    }
}
