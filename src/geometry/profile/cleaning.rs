//! Measured points made a function of the lateral coordinate: order, duplicates, folds, steep ends, outliers.
//!
//! Points are taken along the profile, as instruments write them; from the point nearest the origin outward, each
//! must lie further out than all before it. Points that run backward are left out; those after the last one that
//! does not form an overhang (flange back, rail flank) and are cut, as are ends steeper than [`STEEPEST_END`] over
//! 0.5 mm. An outlier is a point that stands off the cubic through its four neighbours by more than 0.05 mm and more
//! than eight times the median of all such distances, and either by more than 0.6 times the spacing there or while its neighbours lie on a smooth
//! curve without it; or, along a profile, a spike out and back. (A corner of the profile stands off by 1/3 of spacing times angle, and without its tip
//! its neighbours still do.) The two points at each end are not judged.

/// A point of a profile, m, and its line in the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub x: f64,
    pub z: f64,
    pub line: usize,
}

/// Slope of the end of a profile beyond which it is cut. A rail's flank, 20, is kept.
pub(super) const STEEPEST_END: f64 = 25.0;
/// Length over which the slope of an end is taken, m.
const SLOPE_LENGTH: f64 = 0.5e-3;
/// Points nearer to each other than this are one, m.
const SAME: f64 = 1e-8;
/// An outlier stands off by more than this, m ...
const OUTLIER: f64 = 0.05e-3;
/// ... and by more than this share of the spacing ...
const OUTLIER_SHARE: f64 = 0.6;
/// ... and by more than this many medians.
const OUTLIER_MEDIANS: f64 = 8.0;

fn distance(a: &Sample, b: &Sample) -> f64 {
    (a.x - b.x).hypot(a.z - b.z)
}

/// Of fewer points than these nobody can say, -.
const LEAST_ALONG: usize = 20;

/// Do points follow the section, though they run backward in places (flanks that lean inward)? Then the way along them is shorter than that by ascending coordinate,
/// which jumps to and fro between what lies above each other. Points that never run backward follow it where they stand above each other in a vertical face.
pub(super) fn come_along(samples: &[Sample]) -> bool {
    let way = |points: &[Sample]| points.windows(2).map(|pair| distance(&pair[0], &pair[1])).sum::<f64>();
    let monotone = |sign: f64| samples.windows(2).all(|pair| sign * (pair[1].x - pair[0].x) >= 0.0);
    if samples.len() < LEAST_ALONG {
        return false;
    }
    if monotone(1.0) || monotone(-1.0) {
        return vertical_faces(samples);
    }
    let mut sorted = samples.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x));
    way(samples) < way(&sorted)
}

/// A vertical face spans more than this share of the steps that lead to it and from it: less is one place measured twice, -.
const FACE: f64 = 0.5;

/// Do points that never run backward stand above each other somewhere, and wherever they do, as a face that goes on the way they came?
fn vertical_faces(samples: &[Sample]) -> bool {
    let places: Vec<&[Sample]> = samples.chunk_by(|a, b| (b.x - a.x).abs() < SAME).collect();
    let step = |k: usize| places.get(k..k + 2).map_or(0.0, |pair| (pair[1][0].x - pair[0][0].x).abs());
    let mut stacked =
        places.iter().enumerate().filter(|(_, place)| place.windows(2).any(|pair| (pair[1].z - pair[0].z).abs() > SAME)).peekable();
    let is_face = |(k, place): (usize, &&[Sample])| {
        let rise = place[place.len() - 1].z - place[0].z;
        let goes_on = place.windows(2).all(|pair| rise * (pair[1].z - pair[0].z) >= 0.0);
        goes_on && rise.abs() >= FACE * step(k).max(k.checked_sub(1).map_or(0.0, step))
    };
    stacked.peek().is_some() && stacked.all(is_face)
}

/// Sorts points that come in any order; an error names the two lines that give one coordinate two values.
pub(super) fn sort(samples: &mut Vec<Sample>, notes: &mut Vec<String>) -> Result<(), (Sample, Sample)> {
    samples.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.line.cmp(&b.line)));
    let before = samples.len();
    let mut conflict = None;
    samples.dedup_by(|next, kept| {
        // Nearer in x than this, the slope between them is none.
        let same = next.x - kept.x < SAME;
        if same && (next.z - kept.z).abs() > SAME {
            conflict = conflict.or(Some((*kept, *next)));
        }
        same
    });
    if let Some(conflict) = conflict {
        return Err(conflict);
    }
    duplicates_note(before - samples.len(), notes);
    Ok(())
}

fn duplicates_note(count: usize, notes: &mut Vec<String>) {
    if count > 0 {
        notes.push(format!("{count} points given twice, used once"));
    }
}

/// Makes points along a profile run outward in x: direction, duplicates, folds and overhangs.
pub(super) fn unfold(samples: &mut Vec<Sample>, notes: &mut Vec<String>) {
    if samples.first().zip(samples.last()).is_some_and(|(first, last)| last.x < first.x) {
        samples.reverse();
    }
    let before = samples.len();
    samples.dedup_by(|next, kept| distance(next, kept) < SAME);
    duplicates_note(before - samples.len(), notes);
    let Some(start) = nearest(samples, 0.0) else { return };
    // Outward to the right, then the same on the mirrored left part.
    let outward = |points: &mut dyn Iterator<Item = Sample>, sign: f64| {
        let (mut kept, mut behind, mut folded) = (Vec::new(), Vec::new(), 0);
        let mut furthest = f64::NEG_INFINITY;
        for point in points {
            if sign * point.x > furthest + SAME {
                furthest = sign * point.x;
                folded += behind.len();
                behind.clear();
                kept.push(point);
            } else {
                behind.push(point);
            }
        }
        (kept, folded, behind.len())
    };
    let (right, folded_right, beyond_right) = outward(&mut samples[start..].iter().copied(), 1.0);
    let (left, folded_left, beyond_left) = outward(&mut samples[..=start].iter().rev().copied(), -1.0);
    if folded_left + folded_right > 0 {
        notes.push(format!("{} points that run backward left out", folded_left + folded_right));
    }
    for (count, end) in [(beyond_left, left.last()), (beyond_right, right.last())] {
        if let Some(end) = end.filter(|_| count > 0) {
            notes.push(format!("{count} points that overhang beyond {:.2} mm cut off", 1e3 * end.x));
        }
    }
    *samples = left.into_iter().rev().chain(right.into_iter().skip(1)).collect();
}

/// Height at `x` between two points; `None` beyond them.
pub(super) fn value_at(samples: &[Sample], x: f64) -> Option<f64> {
    let pair = samples.windows(2).find(|pair| pair[0].x <= x && x <= pair[1].x)?;
    Some(pair[0].z + (x - pair[0].x) / (pair[1].x - pair[0].x) * (pair[1].z - pair[0].z))
}

/// The index of the point whose coordinate is nearest to `x`.
fn nearest(samples: &[Sample], x: f64) -> Option<usize> {
    (0..samples.len()).min_by(|&a, &b| (samples[a].x - x).abs().total_cmp(&(samples[b].x - x).abs()))
}

/// Cuts both ends where they are steeper than [`STEEPEST_END`].
pub(super) fn cut_steep(samples: &mut Vec<Sample>, notes: &mut Vec<String>) {
    let Some(start) = nearest(samples, 0.0) else { return };
    // The last point that is kept, going from `start` in steps of `step`.
    let last_kept = |step: isize| {
        let (mut behind, mut at) = (start as isize, start as isize + step);
        while at >= 0 && (at as usize) < samples.len() {
            while behind != at - step && distance(&samples[(behind + step) as usize], &samples[at as usize]) >= SLOPE_LENGTH {
                behind += step;
            }
            let (a, b) = (&samples[behind as usize], &samples[at as usize]);
            if (b.z - a.z).abs() > STEEPEST_END * (b.x - a.x).abs() {
                return behind as usize;
            }
            at += step;
        }
        (at - step) as usize
    };
    let (first, last) = (last_kept(-1), last_kept(1));
    for (count, end) in [(first, first), (samples.len() - 1 - last, last)] {
        if count > 0 {
            notes.push(format!("{count} points steeper than {STEEPEST_END} beyond {:.2} mm cut off", 1e3 * samples[end].x));
        }
    }
    samples.truncate(last + 1);
    samples.drain(..first);
}

/// Value at `x` of the polynomial through these points.
fn lagrange(points: &[&Sample], x: f64) -> f64 {
    (0..points.len())
        .map(|i| {
            let others = (0..points.len()).filter(|&j| j != i);
            others.fold(points[i].z, |term, j| term * (x - points[j].x) / (points[i].x - points[j].x))
        })
        .sum()
}

/// How far point `i` stands off its neighbours, across the profile, and the spacing there, m.
fn standing_off(samples: &[Sample], i: usize) -> (f64, f64) {
    let [a, b, point, c, d] = [i - 2, i - 1, i, i + 1, i + 2].map(|i| &samples[i]);
    let slope = (c.z - b.z) / (c.x - b.x);
    let off = (point.z - lagrange(&[a, b, c, d], point.x)).abs() / (1.0 + slope * slope).sqrt();
    (off, 0.5 * distance(b, c))
}

/// Do the neighbours of point `i` lie on a smooth curve without it? Those of a spike do, those of a corner don't: without its tip they stand off by 0.3 of what it does.
fn smooth_without(samples: &[Sample], i: usize, off: f64) -> bool {
    const REST: f64 = 0.15;
    let from = i.saturating_sub(4);
    let own = i - from;
    let mut near = samples[from..samples.len().min(i + 5)].to_vec();
    near.remove(own);
    // Where the two on either side went.
    let sides = [own.checked_sub(2), own.checked_sub(1), Some(own), Some(own + 1)];
    let judged = |j: &usize| *j >= 2 && j + 2 < near.len();
    sides.into_iter().flatten().filter(judged).all(|j| standing_off(&near, j).0 < REST * off)
}

/// Does point `i`, which stands off by so much, go on from the three on one of its sides? So do a sharp corner, as on a groove's floor, and the points beside it; not a spike.
fn goes_on(samples: &[Sample], i: usize, off: f64) -> bool {
    const REST: f64 = 0.2;
    let from = |side: Option<[usize; 3]>| {
        let three = side.and_then(|side| side.map(|j| samples.get(j)).into_iter().collect::<Option<Vec<_>>>());
        three.is_some_and(|three| {
            let at = |x: f64| lagrange(&three, x);
            let slope = (three[2].z - three[1].z) / (three[2].x - three[1].x);
            (samples[i].z - at(samples[i].x)).abs() < REST * off * (1.0 + slope * slope).sqrt()
        })
    };
    from(i.checked_sub(3).map(|first| [first, i - 2, i - 1])) || from(Some([i + 3, i + 2, i + 1]))
}

/// Takes the outliers out of points with increasing coordinates.
pub(super) fn take_outliers(samples: &mut Vec<Sample>) -> Vec<Sample> {
    let mut found = Vec::new();
    while samples.len() > 8 {
        let off: Vec<(f64, f64)> = (2..samples.len() - 2).map(|i| standing_off(samples, i)).collect();
        let mut sorted: Vec<f64> = off.iter().map(|off| off.0).collect();
        sorted.sort_by(f64::total_cmp);
        let least = OUTLIER.max(OUTLIER_MEDIANS * sorted[sorted.len() / 2]);
        // Neighbours of an outlier stand off too, but less: one at a time.
        let worst = off
            .iter()
            .enumerate()
            .filter(|(index, (off, spacing))| *off > least && (*off > OUTLIER_SHARE * spacing || smooth_without(samples, index + 2, *off)))
            .filter(|(index, (off, _))| !goes_on(samples, index + 2, *off))
            .max_by(|a, b| a.1.0.total_cmp(&b.1.0));
        let Some((index, _)) = worst else { break };
        found.push(samples.remove(index + 2));
    }
    found
}

/// Takes out points along a profile from which the way leads out and back.
pub(super) fn take_spikes(samples: &mut Vec<Sample>) -> Vec<Sample> {
    let mut steps: Vec<f64> = samples.windows(2).map(|pair| distance(&pair[0], &pair[1])).collect();
    steps.sort_by(f64::total_cmp);
    let Some(&median) = steps.get(steps.len() / 2) else { return Vec::new() };
    let mut found = Vec::new();
    let mut i = 1;
    while i + 1 < samples.len() {
        let [a, b, c] = [&samples[i - 1], &samples[i], &samples[i + 1]];
        let (there, back) = (distance(a, b), distance(b, c));
        if there.min(back) > (5.0 * median).max(OUTLIER) && there + back > 4.0 * distance(a, c) {
            found.push(samples.remove(i));
        } else {
            i += 1;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parabola(n: usize) -> Vec<Sample> {
        (0..n)
            .map(|i| {
                let x = 0.06 * (i as f64 / (n - 1) as f64 - 0.5);
                Sample { x, z: -x * x / 0.6, line: i + 2 }
            })
            .collect()
    }

    #[test]
    fn prop_one_bad_point_is_found_and_no_good_one() {
        let clean = parabola(201);
        assert!(take_outliers(&mut clean.clone()).is_empty());
        assert!(take_spikes(&mut clean.clone()).is_empty());
        for (at, size) in [(40, 3e-4), (100, -2e-4), (150, 5e-3)] {
            let mut bad = clean.clone();
            bad[at].z += size;
            let found = take_outliers(&mut bad);
            assert_eq!(found.iter().map(|sample| sample.line).collect::<Vec<_>>(), vec![at + 2]);
        }
        // Far off along the profile: it would hide all points that it has overtaken.
        let mut bad = clean.clone();
        bad[120].x += 0.02;
        assert_eq!(take_spikes(&mut bad).iter().map(|sample| sample.line).collect::<Vec<_>>(), vec![122]);
        assert_eq!(bad.len(), 200);
    }

    #[test]
    fn hard_coarse_points_of_a_round_corner_are_no_outliers() {
        // 13 mm radius, a point every 2 mm along the arc.
        let mut arc: Vec<Sample> = (-9..=9)
            .map(|i| {
                let a = 2.0 / 13.0 * f64::from(i);
                Sample { x: 0.013 * a.sin(), z: 0.013 * a.cos(), line: 0 }
            })
            .collect();
        assert!(take_outliers(&mut arc).is_empty());
    }

    #[test]
    fn hard_sharp_corners_of_a_groove_are_no_outliers() {
        // Down a face of 6:1, 30 mm of floor, up again, every 0.5 mm.
        let face = |from: f64, way: f64| (1..=40).map(move |i| (from + way * 5e-4 * f64::from(i) / 6.0, 5e-4 * f64::from(i)));
        let floor = (0..=60).map(|i| (5e-4 * f64::from(i), 0.0));
        let mut groove: Vec<(f64, f64)> = face(0.0, -1.0).chain(floor).chain(face(0.03, 1.0)).collect();
        groove.sort_by(|a, b| a.0.total_cmp(&b.0));
        let clean: Vec<Sample> = groove.iter().enumerate().map(|(line, (x, z))| Sample { x: *x, z: *z, line }).collect();
        assert!(take_outliers(&mut clean.clone()).is_empty());
        // A spike on the floor or on a face is one; beside a corner a good neighbour may be named with it.
        for (at, most) in [(70, 1), (20, 1), (46, 1), (43, 2), (95, 1)] {
            let mut bad = clean.clone();
            bad[at].z += 8e-4;
            let found = take_outliers(&mut bad);
            assert!(found.iter().any(|sample| sample.line == at) && found.len() <= most, "{at}: {found:?}");
        }
    }

    #[test]
    fn prop_overhangs_and_folds_are_left_out_and_named() {
        // From a flank that leans back, over the top, with a step back in the middle.
        let mut samples: Vec<Sample> =
            (0..10).map(|i| Sample { x: -0.0301 + 1e-5 * f64::from(9 - i), z: -0.02 + 1e-3 * f64::from(i), line: 1 }).collect();
        samples.extend(parabola(61));
        let fold = Sample { x: 0.0095, z: -1.5e-4, line: 99 };
        let at = samples.iter().position(|sample| sample.x > 0.0105).unwrap();
        samples.insert(at, fold);
        let mut notes = Vec::new();
        let mut forward = samples.clone();
        unfold(&mut forward, &mut notes);
        assert!(forward.windows(2).all(|pair| pair[1].x > pair[0].x) && !forward.contains(&fold));
        assert!(notes.iter().any(|note| note.starts_with("1 points that run backward")), "{notes:?}");
        assert!(notes.iter().any(|note| note.starts_with("9 points that overhang beyond -30.10 mm")), "{notes:?}");
        samples.reverse();
        let mut backward = samples;
        unfold(&mut backward, &mut Vec::new());
        assert!((forward.len() as i32 - backward.len() as i32).abs() <= 1);
    }

    #[test]
    fn hard_a_vertical_face_follows_the_section_and_a_place_measured_twice_does_not() {
        // A flange back of 20 mm, straight up, before a tread of points every 1 mm.
        let tread = |k: usize| Sample { x: -0.03 + 1e-3 * k as f64, z: -1e-4 * k as f64, line: k + 22 };
        let back = |k: usize| Sample { x: -0.03, z: -0.02 + 1e-3 * k as f64, line: k + 2 };
        let mut section: Vec<Sample> = (0..20).map(back).chain((0..=60).map(tread)).collect();
        assert!(come_along(&section));
        section.reverse();
        assert!(come_along(&section));
        let mut notes = Vec::new();
        unfold(&mut section, &mut notes);
        assert_eq!((section.len(), section[0].z), (61, 0.0), "the corner stays");
        assert!(notes.iter().any(|note| note.starts_with("20 points that overhang beyond -30.00 mm")), "{notes:?}");
        let mut twice: Vec<Sample> = (0..=60).map(tread).collect();
        twice.insert(31, Sample { z: twice[30].z - 4e-5, ..twice[30] });
        assert!(!come_along(&twice), "one place, two heights");
        assert!(sort(&mut twice, &mut Vec::new()).is_err());
        assert!(!come_along(&(0..=60).map(tread).collect::<Vec<_>>()));
    }

    #[test]
    fn prop_steep_ends_are_cut() {
        let mut samples = parabola(61);
        for i in 0..20 {
            samples.push(Sample { x: 0.03 + 1e-6 * f64::from(i + 1), z: -1.5e-3 - 1e-4 * f64::from(i + 1), line: 0 });
        }
        let mut notes = Vec::new();
        cut_steep(&mut samples, &mut notes);
        assert!((samples.len() as i32 - 61).abs() < 8 && samples.len() >= 59, "{}", samples.len());
        assert!(notes.len() == 1 && notes[0].contains("steeper than 25 beyond 30.0"), "{notes:?}");
    }

    proptest! {
        #[test]
        fn prop_order_does_not_matter(order in Just((0..50usize).collect::<Vec<_>>()).prop_shuffle(), twice in 0..50usize) {
            let clean = parabola(50);
            let mut mixed: Vec<Sample> = order.iter().map(|&i| clean[i]).collect();
            mixed.push(clean[twice]);
            let mut notes = Vec::new();
            sort(&mut mixed, &mut notes).unwrap();
            prop_assert_eq!(&mixed, &clean);
            prop_assert_eq!(notes, vec!["1 points given twice, used once".to_string()]);
        }
    }
}
