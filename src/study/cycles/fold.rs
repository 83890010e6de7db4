//! Where a branch turns round: the least (or largest) parameter of its motions.
//!
//! Between three neighbours of which the middle one has the extreme parameter, motions are found across their chord, at fixed distances along it; the extreme
//! of p over this distance is sought by parabolas, beside them by shares of the longer side. The extreme found lies between two others: by how
//! much these differ from it is told, an upper bound of what is missed where p is about a parabola.

use super::branch::ACCURACY;
use super::corrector::{correct, cycle};
use super::slopes::{Condition, unit};
use super::{Cycle, Flow, Missed, along, dot};

/// Most motions that are found on the way.
const MOST: usize = 14;

/// A turning point.
#[derive(Clone, Debug)]
pub struct Fold {
    pub cycle: Cycle,
    /// By how much the parameter of the neighbours is less extreme.
    pub bracket: f64,
    /// Is it the least parameter?
    pub least: bool,
}

/// Do motions turn round at the middle one of three?
pub fn turns(trio: &[Cycle]) -> bool {
    let [a, b, c] = [&trio[0], &trio[1], &trio[2]].map(|cycle| cycle.parameter);
    (b - a) * (c - b) <= 0.0 && a != b
}

/// A motion at a distance along the chord.
struct Entry {
    s: f64,
    place: Vec<f64>,
    /// Of which the least is sought.
    value: f64,
}

/// The turning point between three neighbours, the parameter to `accuracy`.
///
/// # Errors
/// [`Missed`].
pub fn find(flow: &dyn Flow, trio: &[Cycle], accuracy: f64) -> Result<Fold, Missed> {
    let chord = unit(&along(&trio[2].place, -1.0, &trio[0].place));
    let least = trio[1].parameter < trio[0].parameter;
    let sign = if least { flow.unit() } else { -flow.unit() };
    let entry = |place: Vec<f64>| Entry { s: dot(&chord, &place), value: sign * place[place.len() - 1], place };
    let mut three: Vec<Entry> = trio.iter().map(|cycle| entry(cycle.place.clone())).collect();
    let bracket = |three: &[Entry]| three[0].value.max(three[2].value) - three[1].value;
    let slopes = &trio[1].slopes;
    for _ in 0..MOST {
        if bracket(&three) < accuracy {
            break;
        }
        let s = trial([0, 1, 2].map(|k| (three[k].s, three[k].value)));
        let (from, to) = if s < three[1].s { (&three[0], &three[1]) } else { (&three[1], &three[2]) };
        let guess = along(&from.place, (s - from.s) / (to.s - from.s), &along(&to.place, -1.0, &from.place));
        let condition = Condition { direction: chord.clone(), value: s };
        let found = entry(correct(flow, &guess, &condition, Some(slopes), 0.3 * ACCURACY)?.place);
        let place = if s < three[1].s { 1 } else { 2 };
        three.insert(place, found);
        // The best of the inner two stays in the middle.
        three.remove(if three[1].value <= three[2].value { 3 } else { 0 });
    }
    let condition = Condition { direction: chord.clone(), value: three[1].s };
    let found = correct(flow, &three[1].place, &condition, Some(slopes), 0.3 * ACCURACY)?;
    Ok(Fold { cycle: cycle(flow, &found, &chord)?, bracket: bracket(&three), least })
}

/// Where to look next: the vertex of the parabola through three points, or beside the middle one in the longer side where the vertex is too near to either.
fn trial([a, b, c]: [(f64, f64); 3]) -> f64 {
    let (left, right) = (b.0 - a.0, c.0 - b.0);
    let (up, down) = ((a.1 - b.1) / left, (c.1 - b.1) / right);
    let vertex = b.0 + 0.5 * (up * right - down * left) / (up + down);
    let apart = 0.1 * left.max(right);
    let inside = vertex > a.0 + 0.02 * left && vertex < c.0 - 0.02 * right;
    if inside && (vertex - b.0).abs() > apart {
        return vertex;
    }
    b.0 + 0.3 * if left > right { -left } else { right }
}
