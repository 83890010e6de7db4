//! From the points of a file to a profile: datum, directions, cleaning, smoothing, a natural cubic spline.
//!
//! Scene keys, the same for every format: `mirror` (the file's lateral axis is reversed), `shift_y`, `shift_z`
//! (added after mirroring), `tread_circle` of wheels (the file's lateral coordinate of u = 0), `smoothing` (root-mean-square distance by which the points may move) or `fit_within` (the largest such distance; neither by
//! default: the spline interpolates), `drop_outliers` (otherwise an outlier is an error that names its line). A wheel whose
//! file gives heights only needs `radius`, at the tread circle. Which way is up is seen from the shape where the format leaves it open: a rail's head is
//! convex, a wheel's flange (u = -62 .. -42 mm) stands above its tread. Where the file has a radius the scene's key is not needed, and goes before it.

use super::super::file::OpenFile;
use super::cleaning::{self, Sample, value_at};
use super::doubts::doubts;
use super::groove;
use super::orientation::{check_shape, downward};
use super::s1002::wheel_radius;
use super::{Part, Profile, ProfileChoice, ProfilePoint, swinging};
use crate::math::smoothing::{Reach, smooth};
use crate::math::spline::{CubicSpline, SplineError};
use crate::settings::{Section, SettingsError};
use crate::units::Dimension;
use std::sync::Arc;

/// Do points come along the profile, or in any order?
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Order {
    Along,
    Any,
}

/// What the second coordinate of a file is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Level {
    /// Radius of the wheel, or height of the rail, upward.
    Absolute,
    /// Height over a level of the file's own, toward flange tip or crown.
    Height,
    /// Height, upward or downward.
    EitherWay,
}

/// What a reader found in a file, m.
pub(super) struct Reading {
    pub samples: Vec<Sample>,
    pub order: Order,
    pub level: Level,
    /// Lateral coordinate of a wheel's tread circle unless the scene says otherwise.
    pub tread_circle: f64,
    /// Of a wheel, where the file names it beside its points.
    pub radius: Option<FileRadius>,
    /// The file's lateral coordinate grows toward the track centre.
    pub inward: bool,
    /// Columns, for messages.
    pub columns: &'static str,
    pub notes: Vec<String>,
}

/// A wheel's radius at the tread circle that a file names.
pub(super) struct FileRadius {
    /// m.
    pub radius: f64,
    /// As the file calls it, and where.
    pub key: String,
    pub line: usize,
}

/// Wheels are that large, m: another number means another unit, or nothing.
const RADII: (f64, f64) = (0.1, 1.0);

/// Fewest points of a profile.
const LEAST_POINTS: usize = 3;
/// Widths that a profile can have, m.
const WIDTHS: (f64, f64) = (0.01, 0.5);

/// A natural cubic spline through points.
#[derive(Debug, Clone)]
pub struct SplineProfile {
    spline: CubicSpline,
    description: String,
}

impl SplineProfile {
    /// A profile through `(coordinate, value)` points [m] with increasing coordinates.
    ///
    /// # Errors
    /// [`SplineError`] for too few, unordered or non-finite points.
    pub fn through(points: &[(f64, f64)]) -> Result<Self, SplineError> {
        let spline = CubicSpline::natural(points)?;
        let (first, last) = spline.range();
        Ok(SplineProfile { spline, description: format!("{} points from {:.1} mm to {:.1} mm", points.len(), 1e3 * first, 1e3 * last) })
    }
}

impl Profile for SplineProfile {
    #[inline]
    fn at(&self, x: f64) -> ProfilePoint {
        let [value, d1, d2, d3] = self.spline.at(x);
        ProfilePoint { value, d1, d2, d3 }
    }

    fn range(&self) -> (f64, f64) {
        self.spline.range()
    }

    fn describe(&self) -> String {
        self.description.clone()
    }
}

/// The file's lateral coordinate of a wheel's u = 0, m. A kind of file has its `usual` datum as far from the flange whichever way the axis goes.
fn datum(section: &Section, part: Part, (usual, turned): (f64, bool)) -> Result<f64, SettingsError> {
    let usual = if turned { -usual } else { usual };
    if part == Part::Wheel { section.number_or("tread_circle", Dimension::Length, usual) } else { Ok(0.0) }
}

/// Cleans, places and smooths the points, and carries them by a spline.
pub(super) fn profile(section: &Section, part: Part, file: OpenFile, reading: Reading) -> Result<ProfileChoice, SettingsError> {
    let Reading { mut samples, order, level, tread_circle, radius, inward, columns, mut notes } = reading;
    let radius = radius_in_force(section, part, level, (&file, radius), &mut notes)?;
    let turned = section.flag_or("mirror", false)?;
    let tread_circle = datum(section, part, (tread_circle, turned))?;
    let mirrored = turned != inward;
    let shift = (section.number_or("shift_y", Dimension::Length, 0.0)?, section.number_or("shift_z", Dimension::Length, 0.0)?);
    let drop_outliers = section.flag_or("drop_outliers", false)?;
    let reach = read_reach(section)?;

    let wrong = |line: usize, problem: String| file.error(line, columns, problem);
    for sample in &mut samples {
        sample.x = if mirrored { tread_circle - sample.x } else { sample.x - tread_circle } + shift.0;
    }
    enough(&samples).map_err(|problem| wrong(0, problem))?;
    let off_origin = |samples: &[Sample]| {
        let (low, high) = extent(samples);
        let keys = if part == Part::Wheel { "tread_circle, shift_y or mirror" } else { "shift_y or mirror" };
        wrong(0, format!("the points reach from {:.2} mm to {:.2} mm: not over the origin; see {keys}", 1e3 * low, 1e3 * high))
    };
    // Cleaning works from the origin outward.
    let (low, high) = extent(&samples);
    if !(low <= 0.0 && high >= 0.0) {
        return Err(off_origin(&samples));
    }

    let mut outliers = Vec::new();
    match order {
        Order::Any => cleaning::sort(&mut samples, &mut notes).map_err(|(kept, next)| {
            let coordinate = columns.split(',').next().unwrap_or_default();
            wrong(next.line, format!("{coordinate} = {} was given before in line {}", next.x, kept.line))
        })?,
        Order::Along => {
            outliers = cleaning::take_spikes(&mut samples);
            cleaning::unfold(&mut samples, &mut notes);
            cleaning::cut_steep(&mut samples, &mut notes);
        }
    }
    outliers.extend(cleaning::take_outliers(&mut samples));
    judge_outliers(&outliers, drop_outliers, &mut notes, &wrong)?;
    enough(&samples).map_err(|problem| wrong(0, problem))?;

    let Some(middle) = value_at(&samples, 0.0) else { return Err(off_origin(&samples)) };
    if level == Level::EitherWay && downward(&samples, middle, part) {
        samples.iter_mut().for_each(|sample| sample.z = -sample.z);
        notes.push("heights were downward positive (seen from the shape)".into());
    }
    let middle = value_at(&samples, 0.0).unwrap_or_default();
    check_shape(&samples, middle, part).map_err(|(line, problem)| wrong(line, problem))?;
    let datum = match radius {
        Some(radius) => {
            if part == Part::Rail || level == Level::Absolute {
                notes.push(format!("radius {:.3} mm of the scene instead of the file's {:.3} mm", 1e3 * radius, 1e3 * middle));
            } else if middle.abs() > 0.05e-3 {
                notes.push(format!("height {:.3} mm at the tread circle taken off: the radius is given there", 1e3 * middle));
            }
            radius - middle
        }
        None => 0.0,
    };
    samples.iter_mut().for_each(|sample| sample.z += datum + shift.1);
    if part == Part::Rail && (middle + shift.1).abs() > 1e-3 {
        notes.push(format!("the rail's height at eta = 0 is {:.3} mm, not 0: see shift_z", 1e3 * (middle + shift.1)));
    }
    if let Some(sample) = samples.iter().find(|sample| part == Part::Wheel && !(sample.z > 0.0)) {
        return Err(wrong(sample.line, format!("found radius {}, expected more than 0", sample.z)));
    }

    let groove = if part == Part::Rail { groove::cut(&mut samples) } else { None };
    let mut points: Vec<(f64, f64)> = samples.iter().map(|sample| (sample.x, sample.z)).collect();
    points = match reach {
        Some((key, reach)) => smoothed(&points, reach, &mut notes).map_err(|problem| section.error(key, problem))?,
        None => eased(points, &samples, &mut notes),
    };
    if let Some(radius) = radius {
        // The radius holds for the spline itself, not for the chord between two points.
        let spline = CubicSpline::natural(&points).map_err(|error| wrong(0, error.to_string()))?;
        let rest = radius + shift.1 - spline.at(0.0)[0];
        points.iter_mut().for_each(|point| point.1 += rest);
    }
    let profile = SplineProfile::through(&points).map_err(|error| section.error("file", format!("\"{}\": {error}", file.path)))?;
    let coordinates: Vec<f64> = points.iter().map(|point| point.0).collect();
    let swings = swinging::describe(&swinging::swings(&profile, &coordinates), reach.map(|(key, _)| key));
    let doubt = doubts(&samples, part).into_iter().chain(swings).chain(groove).reduce(|all, more| format!("{all}; {more}"));
    Ok(ProfileChoice { profile: Arc::new(profile), file: Some(file.kept), notes, doubt })
}

/// The radius at a wheel's tread circle, m: that of the scene, or of the file. `None` where the points themselves give it, and of rails.
fn radius_in_force(
    section: &Section,
    part: Part,
    level: Level,
    (file, found): (&OpenFile, Option<FileRadius>),
    notes: &mut Vec<String>,
) -> Result<Option<f64>, SettingsError> {
    const DEEPEST: f64 = 0.03;
    if part == Part::Rail || (level == Level::Absolute && !section.has("radius")) {
        return Ok(None);
    }
    let Some(FileRadius { radius, key, line }) = found else { return wheel_radius(section, DEEPEST).map(Some) };
    if section.has("radius") {
        let own = wheel_radius(section, DEEPEST)?;
        if (own - radius).abs() > 0.05e-3 {
            notes.push(format!(
                "radius {:.3} mm of the scene instead of the file's {:.3} mm ({key}, line {line})",
                1e3 * own,
                1e3 * radius
            ));
        }
        return Ok(Some(own));
    }
    if !(RADII.0..=RADII.1).contains(&radius) {
        let wanted = format!("expected {} to {} mm; the scene's key radius goes before it", 1e3 * RADII.0, 1e3 * RADII.1);
        return Err(file.error(line, &key, format!("found a wheel radius of {:.3} mm, {wanted}", 1e3 * radius)));
    }
    notes.push(format!("radius {:.3} mm of the file ({key}, line {line})", 1e3 * radius));
    Ok(Some(radius))
}

/// Are these points that a profile can be made of?
fn enough(samples: &[Sample]) -> Result<(), String> {
    if samples.len() < LEAST_POINTS {
        return Err(format!("found {} points, expected at least {LEAST_POINTS}", samples.len()));
    }
    let (low, high) = extent(samples);
    if high - low < WIDTHS.0 || high - low > WIDTHS.1 {
        let wanted = format!("expected {} to {} mm", 1e3 * WIDTHS.0, 1e3 * WIDTHS.1);
        return Err(format!("the points are {:.3} mm wide, {wanted}: another unit of length?", 1e3 * (high - low)));
    }
    Ok(())
}

/// Smallest and largest coordinate.
fn extent(samples: &[Sample]) -> (f64, f64) {
    samples.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), sample| (low.min(sample.x), high.max(sample.x)))
}

fn judge_outliers(
    outliers: &[Sample],
    drop: bool,
    notes: &mut Vec<String>,
    wrong: &impl Fn(usize, String) -> SettingsError,
) -> Result<(), SettingsError> {
    let mut lines: Vec<usize> = outliers.iter().map(|sample| sample.line).collect();
    lines.sort_unstable();
    let Some(&first) = lines.first() else { return Ok(()) };
    let shown: Vec<String> = lines.iter().take(10).map(usize::to_string).collect();
    let more = if lines.len() > 10 { format!(" and {} more", lines.len() - 10) } else { String::new() };
    let list = format!("lines {}{more}", shown.join(", "));
    if !drop {
        return Err(wrong(first, format!("found outliers in {list}; mend them, or set drop_outliers = true to leave them out")));
    }
    notes.push(format!("{} outliers left out: {list}", lines.len()));
    Ok(())
}

/// How far smoothing may move the points, as the scene says; `None`: a spline through the points.
fn read_reach(section: &Section) -> Result<Option<(&'static str, Reach)>, SettingsError> {
    let [smoothing, fit] = ["smoothing", "fit_within"];
    match (section.has(smoothing), section.has(fit)) {
        (true, true) => Err(section.error(fit, "stands beside smoothing; expected one of them")),
        (true, false) => Ok(Some((smoothing, Reach::RootMeanSquare(section.positive(smoothing, Dimension::Length)?)))),
        (false, true) => Ok(Some((fit, Reach::Largest(section.positive(fit, Dimension::Length)?)))),
        (false, false) => Ok(None),
    }
}

/// Digits of coordinates that are looked for, m, and by which part of itself a rounded number may miss its last one.
const DIGITS: [f64; 5] = [1e-5, 1e-6, 1e-7, 1e-8, 1e-9];
const MISSES: f64 = 1e-3;
/// Rounding to more than this is no rounding that a curve may be laid through, m; to less than that, no file has.
const COARSEST: f64 = 1.001e-6;

/// The last digit to which all numbers of a file are rounded, m.
fn last_digit(numbers: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    let whole = |digit: f64| move |number: f64| (number / digit - (number / digit).round()).abs() < MISSES;
    DIGITS.into_iter().find(|digit| numbers.clone().all(whole(*digit)))
}

/// Points that are rounded so that a spline through them swings, on a smooth curve within their last digit; others as they are.
fn eased(points: Vec<(f64, f64)>, samples: &[Sample], notes: &mut Vec<String>) -> Vec<(f64, f64)> {
    let coordinates: Vec<f64> = points.iter().map(|point| point.0).collect();
    let level = samples.first().map_or(0.0, |sample| sample.z);
    let smoother = SplineProfile::through(&points)
        .ok()
        .filter(|through| !swinging::swings(through, &coordinates).is_empty())
        .and_then(|_| last_digit(samples.iter().map(move |sample| sample.z - level)).filter(|digit| *digit <= COARSEST))
        .and_then(|digit| Some((digit, smooth(&points, Reach::Largest(digit))?.points)))
        .filter(|(_, found)| found.windows(2).all(|pair| pair[1].0 > pair[0].0));
    let Some((digit, found)) = smoother else { return points };
    let tenths = if digit < 1e-7 { 3 } else { 1 };
    notes.push(format!("points are rounded to {:.tenths$} um: a smooth curve is laid within so much of them", 1e6 * digit));
    found
}

fn smoothed(points: &[(f64, f64)], reach: Reach, notes: &mut Vec<String>) -> Result<Vec<(f64, f64)>, String> {
    let (Reach::RootMeanSquare(size) | Reach::Largest(size)) = reach;
    let found = smooth(points, reach).ok_or("needs at least 4 points")?;
    if found.points.windows(2).any(|pair| !(pair[1].0 > pair[0].0)) {
        return Err(format!("found {:.4} mm, with which the profile folds; take less", 1e3 * size));
    }
    notes.push(format!("smoothed: points moved by {:.4} mm (root mean square), at most {:.4} mm", 1e3 * found.rms, 1e3 * found.largest));
    Ok(found.points)
}
