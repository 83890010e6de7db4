//! What is doubtful about the points of a file, though a profile can be made of them.

use super::Part;
use super::cleaning::{Sample, value_at};
use super::orientation::FLANGE;

/// A stretch without points, m, and how much longer it is than the usual spacing, beyond which one is missing rather than left out.
const HOLE: f64 = 5e-3;
const TIMES: f64 = 10.0;
/// A step leads from one smooth stretch to another: its height, m, in medians of what single stretches between points stand off, and its slope beside theirs.
const STEP: f64 = 0.1e-3;
const STEP_MEDIANS: f64 = 8.0;
const STEP_SLOPE: f64 = 0.3;
/// Farther from the middle there are corners, chamfers and flanks: of wheels, and of rails, m.
const RUNNING: [f64; 2] = [0.03, 0.02];
/// A tread or head that leans more than this at its middle belongs to a section that is turned (a cone of 1:10 and a rail canted by 1:20 lean less), -.
const LEAN: f64 = 0.12;
/// A rail's head that leans toward the track by this much or more may have been measured in track, where rails are inclined by 1:20 to 1:40, -.
const INCLINED: f64 = 0.02;
/// Shoulders of a rail's head, m, and by how much the outer one is lower where wear is on the wrong side.
const SHOULDER: (f64, f64) = (0.022, 0.031);
const WORN: f64 = 0.2e-3;
/// Seen over so much to either side, m: wider than hollows.
const MIDDLE: f64 = 0.015;
/// A flange is 25 to 40 mm high, m.
const FLANGE_HEIGHT: f64 = 0.045;

/// All of them, of points as they were measured, by ascending coordinate.
pub(super) fn doubts(samples: &[Sample], part: Part) -> Vec<String> {
    let coordinates: Vec<f64> = samples.iter().map(|sample| sample.x).collect();
    let own = [hole(&coordinates), step(samples, part), lean(samples, part)];
    let others = if part == Part::Wheel { [no_flange(samples), high_flange(samples)] } else { [worn_outside(samples), None] };
    own.into_iter().chain(others).flatten().collect()
}

/// The widest stretch without points: the spline across it is a guess.
fn hole(coordinates: &[f64]) -> Option<String> {
    let mut spacings: Vec<f64> = coordinates.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let widest = coordinates.windows(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
    spacings.sort_by(f64::total_cmp);
    let usual = spacings[spacings.len() / 2];
    (widest[1] - widest[0] > HOLE.max(TIMES * usual)).then(|| {
        format!(
            "there are no points from {:.1} to {:.1} mm (elsewhere every {:.2} mm): what lies between is a guess; measure it, or give points on it",
            1e3 * widest[0],
            1e3 * widest[1],
            1e3 * usual
        )
    })
}

/// The highest step where wheels run: measurements that were put together, dirt, a lip.
fn step(samples: &[Sample], part: Part) -> Option<String> {
    let slope = |pair: &[Sample]| (pair[1].z - pair[0].z) / (pair[1].x - pair[0].x);
    let standing: Vec<(f64, bool, &[Sample])> = samples
        .windows(4)
        .map(|four| {
            let [before, own, behind] = [slope(&four[..2]), slope(&four[1..3]), slope(&four[2..])];
            let steeper = own - 0.5 * (before + behind);
            let alike = (before - behind).abs() < 0.25 * steeper.abs() && steeper.abs() > STEP_SLOPE;
            (steeper * (four[2].x - four[1].x), alike, &four[1..3])
        })
        .collect();
    let mut sizes: Vec<f64> = standing.iter().map(|own| own.0.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let least = STEP.max(STEP_MEDIANS * sizes.get(sizes.len() / 2)?);
    let far = RUNNING[usize::from(part == Part::Rail)];
    let runs = |pair: &[Sample]| pair.iter().all(|sample| sample.x.abs() < far);
    let steps = standing.iter().filter(|(size, alike, pair)| *alike && size.abs() > least && runs(pair));
    let (size, _, pair) = steps.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
    Some(format!(
        "a step of {:.2} mm between {:.2} and {:.2} mm (lines {} and {}): a wheel would stand on its edge; mend the points",
        1e3 * size.abs(),
        1e3 * pair[0].x,
        1e3 * pair[1].x,
        pair[0].line,
        pair[1].line
    ))
}

/// Does the section seem turned?
fn lean(samples: &[Sample], part: Part) -> Option<String> {
    let near: Vec<&Sample> = samples.iter().filter(|sample| sample.x.abs() < MIDDLE).collect();
    let (first, last) = (near.first()?, near.last()?);
    let slope = (last.z - first.z) / (last.x - first.x);
    let (what, axis) = if part == Part::Wheel { ("tread", "u") } else { ("head", "eta") };
    let even = first.x < -0.8 * MIDDLE && last.x > 0.8 * MIDDLE && (first.x + last.x).abs() < 0.1 * MIDDLE;
    if part == Part::Rail && even && (INCLINED..LEAN).contains(&slope) {
        return Some(format!(
            "the head leans toward the track by 1:{:.0} over its middle {:.0} mm: points measured on an inclined rail hold the inclination already (track.inclination = 0 then), or the rail is worn",
            1.0 / slope,
            2e3 * MIDDLE
        ));
    }
    (slope.abs() > LEAN).then(|| {
        let degrees = slope.atan().to_degrees();
        format!("the {what} leans by {degrees:.1} degrees at {axis} = 0: is the section turned? (rails are given un-inclined: track.inclination)")
    })
}

/// Does a rail lack on its outer side what wheels take off the inner one?
fn worn_outside(samples: &[Sample]) -> Option<String> {
    let places: Vec<f64> = (0..).map(|k| SHOULDER.0 + 1e-3 * f64::from(k)).take_while(|x| *x <= SHOULDER.1).collect();
    let lower: Vec<f64> = places.iter().filter_map(|x| Some(value_at(samples, -x)? - value_at(samples, *x)?)).collect();
    let mean = lower.iter().sum::<f64>() / lower.len() as f64;
    (lower.len() == places.len() && mean > WORN).then(|| {
        format!("the head is {:.1} mm lower on its outer shoulder than on its inner one, where wheels wear it: is eta the other way? mirror = true turns it", 1e3 * mean)
    })
}

fn no_flange(samples: &[Sample]) -> Option<String> {
    let first = samples.first()?.x;
    (first > FLANGE.1 + 0.012).then(|| {
        format!(
            "the points begin at u = {:.1} mm, before a flange: of what the wheel has there nothing is known, and contacts there are not found",
            1e3 * first
        )
    })
}

fn high_flange(samples: &[Sample]) -> Option<String> {
    let middle = samples.iter().min_by(|a, b| a.x.abs().total_cmp(&b.x.abs()))?.z;
    let top = samples.iter().filter(|sample| sample.x < 0.0).map(|sample| sample.z - middle).fold(0.0, f64::max);
    (top > FLANGE_HEIGHT).then(|| format!("the flange is {:.0} mm high, usual are 25 to 40 mm: were diameters given for radii?", 1e3 * top))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tread(height: impl Fn(f64) -> f64) -> Vec<Sample> {
        (0..=240).map(|i| (i + 2, -0.06 + 5e-4 * i as f64)).map(|(line, x)| Sample { x, z: height(x), line }).collect()
    }

    fn found(height: impl Fn(f64) -> f64) -> Vec<String> {
        doubts(&tread(height), Part::Wheel)
    }

    #[test]
    fn prop_steps_turned_sections_and_high_flanges_are_doubtful_and_good_points_are_not() {
        let good = |u: f64| -0.05 * u + if u < -0.035 { 0.028 } else { 0.0 };
        assert_eq!(found(good), Vec::<String>::new());
        let step = found(|u| good(u) + if u > 6.2e-3 { 5e-4 } else { 0.0 });
        assert!(step.len() == 1 && step[0].starts_with("a step of 0.50 mm between 6.00 and 6.50 mm (lines 134 and 135)"), "{step:?}");
        assert!(found(|u| good(u) + 0.17 * u)[0].contains("degrees at u = 0"));
        assert!(found(|u| 2.0 * good(u))[0].contains("diameters"));
        let short: Vec<Sample> = tread(good).into_iter().filter(|sample| sample.x > -0.0195).collect();
        assert!(doubts(&short, Part::Wheel)[0].contains("before a flange") && doubts(&short, Part::Rail).is_empty());
        // Measured on a rail inclined by 1:20; a crown of R300 upright; one of which a part is known.
        let crown = |x: f64| -x * x / 0.6;
        let rail = |slope: f64| doubts(&tread(|x| crown(x) + slope * x), Part::Rail);
        assert!(rail(0.05)[0].starts_with("the head leans toward the track by 1:20"), "{:?}", rail(0.05));
        // One that leans outward has its file the wrong way round.
        assert!(rail(0.0).is_empty() && rail(-0.05).len() == 1 && rail(-0.05)[0].contains("mirror = true"), "{:?}", rail(-0.05));
        let part: Vec<Sample> = tread(|x| 5.0 * crown(x)).into_iter().filter(|sample| sample.x < 4e-3).collect();
        assert_eq!(doubts(&part, Part::Rail), Vec::<String>::new());
        // The inner shoulder worn by 0.8 mm, and the same file the wrong way round.
        let worn = |x: f64| crown(x) - if x < -0.02 { 8e-4 } else { 0.0 };
        assert_eq!(doubts(&tread(worn), Part::Rail), Vec::<String>::new());
        assert!(doubts(&tread(|x| worn(-x)), Part::Rail)[0].starts_with("the head is 0.8 mm lower on its outer shoulder"));
        // A kink is no step.
        assert_eq!(found(|u| good(u) - if u > 12e-3 { 0.5 * (u - 12e-3) } else { 0.0 }), Vec::<String>::new());
    }
}
