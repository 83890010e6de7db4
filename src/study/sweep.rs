//! The wheelset set down over a range of lateral shifts.
//!
//! Between the shifts that are asked for, more are added until rolling radius and place on the wheel are straight lines from one to the
//! next. Where that never happens the contact *jumps* from one place to another: the jump is closed in by bisection and shown by
//! the stands on both of its sides, a nanometre apart.

use super::conicity::RollingPose;
use super::contact_geometry::{NoStand, Stand, Start, WheelsetOnTrack};
use crate::geometry::Side;

/// One stand of a sweep.
#[derive(Clone, Debug)]
pub struct Sample {
    pub stand: Stand,
    /// Was this shift asked for? Others were added to follow the curve.
    pub asked: bool,
    /// Does a contact jump between this stand and the next one?
    pub jumps_after: bool,
}

/// A contact that jumps from one place to another while the wheelset moves to the left.
#[derive(Clone, Debug)]
pub struct Jump {
    pub side: Side,
    pub before: Stand,
    pub after: Stand,
}

/// Stands by growing y.
#[derive(Clone, Debug)]
pub struct Sweep {
    pub samples: Vec<Sample>,
    /// Why it ends earlier than asked for, to the right and to the left.
    pub ended: [Option<NoStand>; 2],
}

/// Errors of a straight line between two stands that are accepted: of the rolling radius and of the place on the wheel, m.
const RADIUS: f64 = 1e-8;
const PLACE: f64 = 5e-5;
/// Two stands nearer than this stand on the two sides of a jump, m.
const SHARP: f64 = 1e-9;
/// Shortest move of the contact on wheel or rail that is called a jump, m.
const JUMP: f64 = 1e-4;

impl Sweep {
    /// Stands at `-range, ... -step, 0, step, ... range` [m] and what is needed in between.
    ///
    /// # Errors
    /// [`NoStand`] when the wheelset does not stand at y = 0; where it does not stand elsewhere the sweep ends.
    pub fn new(wheelset: &WheelsetOnTrack, range: f64, step: f64) -> Result<Sweep, NoStand> {
        Self::watched(wheelset, range, step, &mut |_| {})
    }

    /// The same; `reached` hears of each shift [m] that was asked for, or added between two.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn watched(wheelset: &WheelsetOnTrack, range: f64, step: f64, reached: &mut dyn FnMut(f64)) -> Result<Sweep, NoStand> {
        let centred = wheelset.stand(0.0, wheelset.start())?;
        let count = (range / step + 1e-9).floor() as usize;
        let mut ended = [None; 2];
        let mut halves: [Vec<Stand>; 2] = Default::default();
        for (half, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let mut last = centred.clone();
            for k in 1..=count {
                match wheelset.stand(sign * step * k as f64, Start::from(&last)) {
                    Ok(stand) => {
                        reached(stand.y);
                        halves[half].push(stand.clone());
                        last = stand;
                    }
                    Err(error) => {
                        ended[half] = Some(error);
                        break;
                    }
                }
            }
        }
        let [right, left] = halves;
        let asked: Vec<Stand> = right.into_iter().rev().chain([centred]).chain(left).collect();
        let mut samples = Vec::new();
        for (index, stand) in asked.iter().enumerate() {
            samples.push(Sample { stand: stand.clone(), asked: true, jumps_after: false });
            if let Some(next) = asked.get(index + 1) {
                follow(wheelset, [stand, next], &mut samples, reached)?;
            }
        }
        Ok(Sweep { samples, ended })
    }

    /// The samples without those that were only added to follow the curve: what was asked for and both sides of jumps.
    pub fn shown(&self) -> impl Iterator<Item = &Sample> {
        let after_jump = |index: usize| index > 0 && self.samples[index - 1].jumps_after;
        self.samples
            .iter()
            .enumerate()
            .filter(move |(index, sample)| sample.asked || sample.jumps_after || after_jump(*index))
            .map(|(_, sample)| sample)
    }

    /// Every jump, by growing y.
    pub fn jumps(&self) -> Vec<Jump> {
        let pairs = self.samples.windows(2).filter(|pair| pair[0].jumps_after);
        pairs
            .flat_map(|pair| {
                let (before, after) = (&pair[0].stand, &pair[1].stand);
                let moved = move |side: &Side| moves(before, after, *side);
                Side::BOTH.into_iter().filter(moved).map(|side| Jump { side, before: before.clone(), after: after.clone() })
            })
            .collect()
    }

    /// Stretches without a jump.
    pub fn branches(&self) -> Vec<&[Sample]> {
        self.samples.split_inclusive(|sample| sample.jumps_after).collect()
    }

    /// Lateral shift, roll and rolling radii of each sample.
    pub fn poses(&self) -> impl Iterator<Item = RollingPose> + '_ {
        let pose =
            |stand: &Stand| RollingPose { y: stand.y, roll: stand.roll, radii: [0, 1].map(|side| stand.contacts[side].rolling_radius) };
        self.samples.iter().map(move |sample| pose(&sample.stand))
    }

    /// The stand nearest to a lateral shift [m].
    pub fn nearest(&self, y: f64) -> &Stand {
        let after = self.samples.partition_point(|sample| sample.stand.y < y).min(self.samples.len() - 1);
        let near = [after.saturating_sub(1), after].map(|index| &self.samples[index].stand);
        if (near[0].y - y).abs() < (near[1].y - y).abs() { near[0] } else { near[1] }
    }
}

fn moves(before: &Stand, after: &Stand, side: Side) -> bool {
    let (a, b) = (&before.contacts[side.index()], &after.contacts[side.index()]);
    (a.wheel - b.wheel).abs() > JUMP || (a.rail - b.rail).abs() > JUMP
}

/// Adds stands between `first` and `last` to `samples`, of which the last one is `first`.
fn follow(
    wheelset: &WheelsetOnTrack,
    [first, last]: [&Stand; 2],
    samples: &mut Vec<Sample>,
    reached: &mut dyn FnMut(f64),
) -> Result<(), NoStand> {
    // What is still to be reached, the nearest on top.
    let mut ahead = vec![last.clone()];
    let mut here = first.clone();
    while let Some(next) = ahead.last() {
        if next.y - here.y < SHARP {
            if let Some(sample) = samples.last_mut() {
                sample.jumps_after = Side::BOTH.iter().any(|side| moves(&here, next, *side));
            }
        } else {
            let middle = wheelset.stand(0.5 * (here.y + next.y), Start::from(&here))?;
            reached(middle.y);
            if !straight(&here, &middle, next) {
                ahead.push(middle);
                continue;
            }
            samples.push(Sample { stand: middle, asked: false, jumps_after: false });
        }
        if let Some(next) = ahead.pop() {
            if !ahead.is_empty() {
                samples.push(Sample { stand: next.clone(), asked: false, jumps_after: false });
            }
            here = next;
        }
    }
    Ok(())
}

fn straight(a: &Stand, middle: &Stand, b: &Stand) -> bool {
    (0..2).all(|side| {
        let (a, m, b) = (&a.contacts[side], &middle.contacts[side], &b.contacts[side]);
        let off = |a: f64, m: f64, b: f64| (m - 0.5 * (a + b)).abs();
        off(a.rolling_radius, m.rolling_radius, b.rolling_radius) < RADIUS
            && off(a.wheel, m.wheel, b.wheel) < PLACE
            && off(a.rail, m.rail, b.rail) < PLACE
    })
}
