//! Is a profile the part that it should be, the right way round and up?
//!
//! Going inward from its tread a wheel first rises, at the root of its flange; its field side falls by some millimetres and never by a flange's height over more than
//! a chamfer. A rail's head is convex.

use super::Part;
use super::cleaning::Sample;

/// Where a wheel's flange is, m.
pub(super) const FLANGE: (f64, f64) = (-0.062, -0.042);
/// A flange is higher over the tread than this; a rail never rises this much over its middle, m.
const FLANGE_HEIGHT: f64 = 0.01;
/// Wider than this no rim face and no chamfer falls so far, m.
const FLANGE_WIDTH: f64 = 0.008;
/// Between tread circle and flange a wheel's surface is told from its tread by this, m, or where it ends before by this.
const RISE: f64 = 2e-3;
const LEAST_RISE: f64 = 0.2e-3;
/// There its tread ends, m either way.
const TREAD: f64 = 0.01;

/// How the surface turns first, going inward from the tread: the point that shows it.
fn turn(samples: &[Sample], middle: f64) -> Option<&Sample> {
    let inner = || samples.iter().rev().filter(|sample| (FLANGE.0..-TREAD).contains(&sample.x));
    let off = |sample: &&Sample| (sample.z - middle).abs();
    inner()
        .find(|sample| off(sample) > RISE)
        .or_else(|| inner().max_by(|a, b| off(a).total_cmp(&off(b))).filter(|sample| off(sample) > LEAST_RISE))
}

/// Do heights grow downward (rail), or away from the flange tip (wheel)?
pub(super) fn downward(samples: &[Sample], middle: f64, part: Part) -> bool {
    match part {
        Part::Rail => 0.5 * (samples[0].z + samples[samples.len() - 1].z) > middle,
        Part::Wheel => turn(samples, middle).is_some_and(|sample| sample.z < middle),
    }
}

/// Where a wheel's outer side stands, or falls, by the height of a flange, m.
fn outer_flange(samples: &[Sample], middle: f64) -> Option<(f64, f64)> {
    let high = |sample: &Sample| sample.x > 0.02 && (sample.z - middle).abs() > FLANGE_HEIGHT;
    let mut parts = samples.windows(2).filter(|pair| high(&pair[0]) && high(&pair[1]));
    let first = parts.next()?;
    let last = parts.next_back().unwrap_or(first);
    (last[1].x - first[0].x > FLANGE_WIDTH).then_some((first[0].x, last[1].x))
}

/// Is it the part that it should be, the right way round? An error names the line of the point that shows it.
pub(super) fn check_shape(samples: &[Sample], middle: f64, part: Part) -> Result<(), (usize, String)> {
    let highest = |keep: &dyn Fn(f64) -> bool| {
        samples.iter().filter(|sample| keep(sample.x)).max_by(|a, b| a.z.total_cmp(&b.z)).filter(|top| top.z - middle > FLANGE_HEIGHT)
    };
    if part == Part::Rail {
        return highest(&|_| true).map_or(Ok(()), |top| {
            Err((top.line, format!("rises {:.1} mm over the middle: a rail does not; is this a wheel?", 1e3 * (top.z - middle))))
        });
    }
    let inner = highest(&|x| x < -0.02);
    if let Some((from, to)) = outer_flange(samples, middle) {
        let line = samples.iter().find(|sample| sample.x >= from).map_or(0, |sample| sample.line);
        let place = format!("{:.1} to {:.1} mm", 1e3 * from, 1e3 * to);
        return Err((line, format!("u = {place}, on the outer side, has the shape of a flange: set mirror, or tread_circle")));
    }
    if let Some(low) = turn(samples, middle).filter(|first| inner.is_none() && middle - first.z > RISE) {
        let lowest = samples.iter().filter(|sample| (FLANGE.0..-TREAD).contains(&sample.x)).map(|sample| sample.z).fold(low.z, f64::min);
        let fall = 1e3 * (middle - lowest);
        return Err((low.line, format!("falls {fall:.1} mm below the tread where a flange rises: are heights, or radii, upside down?")));
    }
    match (inner, highest(&|x| x > 0.02)) {
        (None, Some(top)) => {
            Err((top.line, format!("the flange stands at u = {:.1} mm, on the outer side: set mirror, or tread_circle", 1e3 * top.x)))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tread of 1:20 with a flange from -35 mm on, its back cut, and a chamfer.
    fn wheel(from: f64, to: f64, turned: f64) -> Vec<Sample> {
        let height = |u: f64| {
            let flange = if u < -0.035 { 0.028 * (1.0 - ((u + 0.052) / 0.017).powi(2)).max(0.0) } else { 0.0 };
            flange - 0.05 * u - if u > 0.06 { 3.0 * (u - 0.06) } else { 0.0 }
        };
        let count = ((to - from) / 5e-4) as usize;
        (0..=count).map(|i| from + 5e-4 * i as f64).map(|x| Sample { x, z: turned * height(x), line: 1 }).collect()
    }

    #[test]
    fn prop_a_wheel_that_ends_before_its_flange_shows_which_way_is_up() {
        for from in [-0.069, -0.06, -0.045, -0.042, -0.038, -0.03, -0.02, -0.012] {
            assert!(
                !downward(&wheel(from, 0.065, 1.0), 0.0, Part::Wheel) && downward(&wheel(from, 0.065, -1.0), 0.0, Part::Wheel),
                "{from}"
            );
            assert!(check_shape(&wheel(from, 0.065, 1.0), 0.0, Part::Wheel).is_ok(), "{from}");
        }
        assert!(check_shape(&wheel(-0.04, 0.065, -1.0), 0.0, Part::Wheel).unwrap_err().1.contains("upside down"));
    }

    #[test]
    fn prop_a_flange_on_the_outer_side_is_an_error_either_way_up() {
        for up in [1.0, -1.0] {
            let mirrored: Vec<Sample> = wheel(-0.065, 0.06, up).into_iter().rev().map(|own| Sample { x: -own.x, ..own }).collect();
            let problem = check_shape(&mirrored, 0.0, Part::Wheel).unwrap_err().1;
            assert!(problem.contains("on the outer side") && problem.contains("set mirror"), "{problem}");
        }
        // A rim's face that belongs to no flange.
        let mut rim = wheel(-0.065, 0.06, 1.0);
        rim.extend((1..30).map(|i| Sample { x: 0.06 + 1e-5 * f64::from(i), z: -3e-3 - 1e-3 * f64::from(i), line: 2 }));
        assert!(check_shape(&rim, 0.0, Part::Wheel).is_ok());
    }
}
