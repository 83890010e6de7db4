//! Where an interpolating spline swings between the points of a file.
//!
//! A natural cubic spline through coarse points beside a jump of curvature, or through noise, bends to and fro from point to point. Heights are off by next
//! to nothing, but the curvature, by `4 e / h^2` for an error e at the spacing h, and a contact that is nearly conformal then moves in jumps that the
//! real surface does not make. With the curvature k_i at the points, a point swings where
//!
//! ```text
//! (k_i - k_i-1)(k_i+1 - k_i) < 0   and   |k_i - (k_i-1 + k_i+1) / 2| > max(2 1/m, |k_i-1 + k_i+1| / 20)
//! ```
//!
//! (2 1/m is what tread and head differ by), and the spline does where three and more of five points in a row do over 4 mm at least, or stand more than 3 um beside a smooth curve: what is
//! narrower than a patch, as beside the jumps of curvature of a drawing with a point every 0.5 mm, has made no contact jump (docs/contact_geometry.md).

use super::Profile;

/// A part of a profile where it does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Swing {
    /// Coordinates, m.
    pub from: f64,
    pub to: f64,
    /// Largest swing of the curvature, 1/m, and points that swing.
    pub most: f64,
    pub points: usize,
    /// How far they stand beside a smooth curve, by the median and the farthest, m.
    pub noise: f64,
    pub farthest: f64,
}

/// 1/m, and the share.
const LEAST: f64 = 2.0;
const SHARE: f64 = 0.05;
/// Narrowest part that counts, m, and how far points may stand beside a smooth curve in a narrower one, m: one point 20 um off the others at a spacing of 0.25 mm moved conicity by 7 %.
const NARROWEST: f64 = 4e-3;
const FARTHEST: f64 = 3e-6;
const OF_POINTS: usize = 5;
const SWINGING: usize = 3;

/// Widths of a fit that are recommended, m, and how much wider than that they must be: points of a normal distribution go to and fro by half of its deviation, and
/// the largest of some hundreds is three deviations.
const WIDTHS: [f64; 6] = [5e-6, 10e-6, 20e-6, 30e-6, 60e-6, 100e-6];
const WIDER: f64 = 6.0;
/// Points further apart than this make a spline ring without any noise, m.
const COARSE: f64 = 1.5e-3;

/// All such parts of a profile through points with these coordinates.
pub(super) fn swings(profile: &dyn Profile, coordinates: &[f64]) -> Vec<Swing> {
    let curvature = |x: &f64| {
        let point = profile.at(*x);
        point.d2 / (1.0 + point.d1 * point.d1).powf(1.5)
    };
    let bends: Vec<f64> = coordinates.iter().map(curvature).collect();
    let swing = |k: &[f64]| {
        let size = (k[1] - 0.5 * (k[0] + k[2])).abs();
        let alternates = (k[1] - k[0]) * (k[2] - k[1]) < 0.0;
        if alternates && size > LEAST.max(SHARE * (k[0] + k[2]).abs()) { size } else { 0.0 }
    };
    // Of the inner points.
    let sizes: Vec<f64> = bends.windows(3).map(swing).collect();
    // Points that stand +-e beside a smooth curve by turns, h apart, have it bend by +-12 e / h^2 more.
    let beside = |i: usize| {
        let apart = 0.5 * (coordinates[i + 2] - coordinates[i]);
        if apart < COARSE { sizes[i] * apart * apart / 24.0 } else { 0.0 }
    };
    let mut found: Vec<(usize, usize)> = Vec::new();
    for (first, some) in sizes.windows(OF_POINTS).enumerate() {
        if some.iter().filter(|size| **size > 0.0).count() < SWINGING {
            continue;
        }
        match found.last_mut() {
            Some(last) if last.1 >= first => last.1 = first + OF_POINTS,
            _ => found.push((first, first + OF_POINTS)),
        }
    }
    let part = |(first, end): (usize, usize)| {
        let own = &sizes[first..end];
        let most = own.iter().copied().fold(0.0, f64::max);
        let mut noise: Vec<f64> = (first..end).map(beside).filter(|e| *e > 0.0).collect();
        noise.sort_by(f64::total_cmp);
        let farthest = noise.last().copied().unwrap_or_default();
        let noise = noise.get(noise.len() / 2).copied().unwrap_or_default();
        Swing {
            noise,
            farthest,
            from: coordinates[first + 1],
            to: coordinates[end],
            most,
            points: own.iter().filter(|size| **size > 0.0).count(),
        }
    };
    found.into_iter().map(part).filter(|swing| swing.to - swing.from >= NARROWEST || swing.farthest > FARTHEST).collect()
}

/// In words, `None` where it does not; `smoothed_by` is the scene's key by which points have moved already.
pub(super) fn describe(swings: &[Swing], smoothed_by: Option<&str>) -> Option<String> {
    const SHOWN: usize = 3;
    let worst = swings.iter().map(|swing| swing.most).reduce(f64::max)?;
    let places: Vec<String> =
        swings.iter().take(SHOWN).map(|swing| format!("{:.1} .. {:.1} mm", 1e3 * swing.from, 1e3 * swing.to)).collect();
    let more = if swings.len() > SHOWN { format!(" and {} more", swings.len() - SHOWN) } else { String::new() };
    let points: usize = swings.iter().map(|swing| swing.points).sum();
    let noise = swings.iter().map(|swing| swing.noise).fold(0.0, f64::max);
    let fit = WIDTHS.into_iter().find(|width| *width >= WIDER * noise).unwrap_or(WIDTHS[WIDTHS.len() - 1]);
    let advice = match smoothed_by {
        None => format!("fit_within = \"{:.0} um\" lays a smooth curve within so much of all points", 1e6 * fit),
        Some("fit_within") => "fit_within is reached at one point, mostly an edge or chamfer, and holds the curve back everywhere: leave such points out, or give smoothing (the root mean square of all) in its place".into(),
        Some(key) => format!("more {key} lays a smoother curve"),
    };
    Some(format!(
        "the spline swings between coarse or noisy points: its curvature goes to and fro by up to {worst:.1} 1/m at {points} points ({}{more}); contacts may jump there that \
         do not on the real surface. {advice}",
        places.join(", "),
    ))
}

#[cfg(test)]
mod tests {
    use super::super::measured::SplineProfile;
    use super::*;

    fn found(points: &[(f64, f64)]) -> Vec<Swing> {
        let coordinates: Vec<f64> = points.iter().map(|point| point.0).collect();
        swings(&SplineProfile::through(points).unwrap(), &coordinates)
    }

    #[test]
    fn prop_arcs_do_not_swing_and_noise_does() {
        let arc = |noise: f64| -> Vec<(f64, f64)> {
            let x = (-30..=30).map(|k| 1e-3 * f64::from(k));
            x.enumerate().map(|(k, x)| (x, (0.09 - x * x).sqrt() + noise * if k % 2 == 0 { 1.0 } else { -1.0 })).collect()
        };
        assert!(found(&arc(0.0)).is_empty());
        // The width that is recommended goes with the noise; what coarse points ring by is none.
        let width = |noise: f64| describe(&found(&arc(noise)), None).unwrap();
        assert!(width(2e-6).contains("\"20 um\"") && width(8e-6).contains("\"60 um\""), "{} {}", width(2e-6), width(8e-6));
        // Where arcs of 300 and 13 mm meet the spline rings: over 3 mm with a point every 0.5 mm, over 9 mm with one every 1.5 mm.
        let joined = |h: f64| -> Vec<(f64, f64)> {
            let count = (0.02 / h) as i32;
            let height = |x: f64| if x < 0.0 { (0.09 - x * x).sqrt() - 0.3 } else { (1.69e-4 - x * x).sqrt() - 0.013 };
            (-count..=count / 2).map(|k| h * (f64::from(k) + 0.3)).map(|x| (x, height(x))).collect()
        };
        assert!(found(&joined(5e-4)).is_empty() && found(&joined(1.5e-3)).len() == 1, "{:?}", found(&joined(1.5e-3)));
        // +-1 um at 1 mm: the curvature of a triangle wave's spline goes to and fro by 12 e / h^2 = 12 1/m, twice that from its mean.
        let noisy = found(&arc(1e-6));
        assert!(noisy.len() == 1 && noisy[0].points > 50 && (noisy[0].most / 24.0 - 1.0).abs() < 0.1, "{noisy:?}");
        assert!(describe(&noisy, None).is_some_and(|words| words.contains("1/m at") && words.contains("fit_within = \"")));
        // What is in force already is not advised again.
        assert!(describe(&noisy, Some("fit_within")).is_some_and(|words| words.contains("give smoothing")));
        assert!(describe(&noisy, Some("smoothing")).is_some_and(|words| words.ends_with("more smoothing lays a smoother curve")));
        assert!(describe(&[], None).is_none());
    }
}
