//! Grooved rails: what lies beyond the groove.
//!
//! Places of contact are sought from the rail's head outward; beyond a groove stands its keeper, seen from below the head as if the wheel's flange were deep in
//! it. So a grooved rail ends on the floor of its groove, which flange tips may reach. What the keeper does, touch the backs of flanges in narrow curves, is not there.

use super::cleaning::Sample;

/// A groove is so deep below the origin, and its keeper stands so high above its floor, m.
const DEEP: f64 = 0.02;
const KEEPER: f64 = 5e-3;
/// Points within that of the deepest one belong to the floor, m.
const FLAT: f64 = 2e-4;

/// Cuts the points of a rail, in order of their coordinates and upward positive, behind a groove on the inner side; what was cut, in words.
pub(super) fn cut(samples: &mut Vec<Sample>) -> Option<String> {
    let head = samples.iter().filter(|sample| sample.x.abs() < DEEP).map(|sample| sample.z).fold(f64::NEG_INFINITY, f64::max);
    let inner = samples.iter().filter(|sample| sample.x < 0.0);
    let deepest = inner.clone().min_by(|a, b| a.z.total_cmp(&b.z))?;
    let floor = inner.clone().filter(|sample| sample.z < deepest.z + FLAT).map(|sample| sample.x).fold(f64::INFINITY, f64::min);
    let keeper = inner.filter(|sample| sample.x < floor).map(|sample| sample.z).fold(f64::NEG_INFINITY, f64::max);
    if !(head - deepest.z > DEEP && keeper - deepest.z > KEEPER) {
        return None;
    }
    samples.retain(|sample| sample.x >= floor);
    Some(format!(
        "ends on the floor of its groove, at {:.1} mm: the keeper beyond is left out, backs of flanges do not touch it",
        1e3 * floor
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(points: &[(f64, f64)]) -> Vec<Sample> {
        points.iter().enumerate().map(|(line, (x, z))| Sample { line, x: 1e-3 * x, z: 1e-3 * z }).collect()
    }

    #[test]
    fn prop_rails_end_on_the_floor_of_their_groove() {
        let grooved =
            [(-80.0, -6.0), (-75.0, -20.0), (-70.0, -45.0), (-50.0, -44.9), (-45.0, -20.0), (-36.0, -5.0), (0.0, 0.0), (36.0, -5.0)];
        let mut own = samples(&grooved);
        let said = cut(&mut own).unwrap();
        assert!(own[0].x == -0.070 && own.len() == 6 && said.contains("at -70.0 mm"), "{said}");
        // A lip of 1 mm, a foot below the head, and a groove outside are none.
        for (points, count) in [
            (&[(-38.0, -19.0), (-37.0, -20.5), (-30.0, -3.0), (0.0, 0.0), (30.0, -3.0)][..], 5),
            (&[(-60.0, -150.0), (-37.0, -30.0), (0.0, 0.0), (30.0, -3.0)], 4),
            (&[(-37.0, -30.0), (0.0, 0.0), (45.0, -45.0), (80.0, -6.0)], 4),
        ] {
            let mut own = samples(points);
            assert!(cut(&mut own).is_none() && own.len() == count);
        }
    }
}
