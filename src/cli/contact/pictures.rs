//! The contact geometry as diagrams.

use super::pair_in_force;
use super::{Conicities, Elastic, Study};
use crate::cli::plot::{Axis, BLUE, DARK, Ink, Mark, ORANGE, Panel, Series, Sheet, inside, width};
use crate::geometry::Side;
use crate::geometry::track::rail_surface::rail_point;
use crate::study::conicity::{Conicity, NoConicity};
use crate::study::contact_geometry::{Stand, Touch};
use crate::study::sweep::Sample;
use nalgebra::Vector3;
use plotters::style::RGBColor;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// Of elastic wheels and rails.
const GREEN: RGBColor = RGBColor(0, 158, 115);
const SHIFT: &str = "lateral shift y [mm], left positive";

/// Draws every picture; returns the files.
pub(super) fn draw(folder: &Path, study: &Study) -> Result<Vec<PathBuf>, String> {
    let attitude = study.wheelset.attitude;
    let held = if attitude.level { "axle held level" } else { "both wheels touch" };
    let subtitle = format!("{}; {held}, yaw {} mrad", study.scene.title, 1e3 * attitude.yaw);
    let sheets = [
        ("contact_geometry", "Contact geometry", geometry(study)),
        ("conicity", "Equivalent conicity", conicity(study)),
        ("contact_points", "Contact points", Side::BOTH.map(|side| section(study, side)).into()),
    ];
    let sheet = |(key, title, panels): (&str, &str, Vec<Panel>)| {
        let file = folder.join(format!("{}_{key}.svg", study.scene.name));
        let mut subtitles = vec![subtitle.clone(), pair_in_force(study.scene)];
        if key == "contact_points" {
            subtitles.push("numbers: lateral shift in mm, left positive; the wheel is lifted so that the lines are seen".into());
        }
        Sheet { title: title.into(), subtitles, columns: 2, panels }.draw(&file)?;
        Ok(file)
    };
    sheets.into_iter().map(sheet).collect()
}

/// Something of a stand over the lateral shift in mm; branches are joined where it does not jump.
fn curve(study: &Study, label: &str, ink: Ink, value: impl Fn(&Stand) -> f64) -> Series {
    let point = |sample: &Sample| (1e3 * sample.stand.y, value(&sample.stand));
    let all: Vec<Vec<(f64, f64)>> = study.sweep.branches().into_iter().map(|branch| branch.iter().map(point).collect()).collect();
    let (low, high) = all.iter().flatten().fold((f64::MAX, f64::MIN), |(low, high), point| (low.min(point.1), high.max(point.1)));
    let mut branches: Vec<Vec<(f64, f64)>> = Vec::new();
    for branch in all {
        match branches.last_mut() {
            Some(last) if last.last().zip(branch.first()).is_some_and(|(a, b)| (a.1 - b.1).abs() < 1e-4 * (high - low)) => {
                last.extend(branch)
            }
            _ => branches.push(branch),
        }
    }
    Series { label: label.into(), ink, branches, marks: vec![] }
}

/// The rolling-radius difference at lateral shifts up to `within`, mm.
fn difference(study: &Study, within: f64) -> Panel {
    let mut panel = Panel::new(
        "Rolling-radius difference",
        [SHIFT, "left minus right [mm]"],
        vec![curve(study, if study.elastic.is_some() { "rigid" } else { "" }, Ink::line(DARK), |stand| 1e3 * stand.radius_difference())],
    );
    if let Some(elastic) = &study.elastic {
        let points = elastic.differences.iter().map(|(y, difference)| (1e3 * y, 1e3 * difference)).collect();
        panel.series.push(Series::line(&elastic_label(elastic), Ink::line(GREEN), points));
    }
    for series in &mut panel.series {
        series.branches.iter_mut().for_each(|branch| branch.retain(|point| point.0.abs() <= within));
        series.branches.retain(|branch| !branch.is_empty());
    }
    panel.y.zero = true;
    if let Some((limit, all)) = on_the_tread(study, within) {
        panel.y.range = Some((-limit, limit));
        panel.aside = format!("cut off at {limit:.1} mm; on the flange {all:.1} mm");
        panel.series.iter_mut().for_each(|series| series.branches = cut(&series.branches, limit));
    }
    panel
}

/// How far the axis of the radius difference reaches so that the flange, where it grows tenfold, leaves the tread to be seen, mm: all that is rolled on
/// where neither wheel stands steeper than [`FLANGE`]; and how far the flange's goes. `None` where the tread's is most of it.
fn on_the_tread(study: &Study, within: f64) -> Option<(f64, f64)> {
    /// Contact angle, rad (30 degrees), beyond which a wheel rolls on its flange.
    const FLANGE: f64 = PI / 6.0;
    const MOST: f64 = 0.6;
    const AIR: f64 = 1.1;
    let sizes = |keep: &dyn Fn(&Stand) -> bool| {
        let stands = study.sweep.samples.iter().map(|sample| &sample.stand);
        let stands = stands.filter(|stand| 1e3 * stand.y.abs() <= within && keep(stand));
        stands.map(|stand| 1e3 * stand.radius_difference().abs()).fold(0.0, f64::max)
    };
    let (tread, all) = (sizes(&|stand| stand.contacts.iter().all(|touch| touch.angle.abs() < FLANGE)), sizes(&|_| true));
    (tread > 0.0 && tread < MOST * all).then_some((AIR * tread, all))
}

/// Lines cut off at `limit` either way, where they reach it.
fn cut(branches: &[Vec<(f64, f64)>], limit: f64) -> Vec<Vec<(f64, f64)>> {
    let mut parts: Vec<Vec<(f64, f64)>> = Vec::new();
    for branch in branches {
        let mut inside: Vec<(f64, f64)> = Vec::new();
        for (k, point) in branch.iter().enumerate() {
            // Where the line from the point before goes through an end of the axis.
            let end = |from: &(f64, f64), to: &(f64, f64)| {
                let y = limit.copysign(if from.1.abs() > limit { from.1 } else { to.1 });
                (from.0 + (to.0 - from.0) * (y - from.1) / (to.1 - from.1), y)
            };
            let before = k.checked_sub(1).map(|k| &branch[k]);
            match (before.map(|before| before.1.abs() <= limit), point.1.abs() <= limit) {
                (Some(false), true) => inside.extend(before.map(|before| end(before, point))),
                (Some(true), false) => {
                    inside.extend(before.map(|before| end(before, point)));
                    parts.push(std::mem::take(&mut inside));
                }
                _ => {}
            }
            if point.1.abs() <= limit {
                inside.push(*point);
            }
        }
        parts.push(inside);
    }
    parts.retain(|part| !part.is_empty());
    parts
}

fn elastic_label(elastic: &Elastic) -> String {
    format!("elastic, {:.0} kN", 1e-3 * elastic.load)
}

fn geometry(study: &Study) -> Vec<Panel> {
    let panel = |title, axis, series| Panel::new(title, [SHIFT, axis], series);
    let both = |value: &dyn Fn(&Touch) -> f64| {
        let inks = [("left wheel", Side::Left, BLUE), ("right wheel", Side::Right, ORANGE)];
        inks.map(|(label, side, color)| curve(study, label, Ink::line(color), |stand| value(&stand.contacts[side.index()]))).into()
    };
    let one = |value: &dyn Fn(&Stand) -> f64| vec![curve(study, "", Ink::line(DARK), value)];
    let mut panels = vec![
        difference(study, f64::INFINITY),
        panel("Contact angle", "angle [deg]", both(&|touch| touch.angle.to_degrees())),
        panel("Contact on the wheel", "u, outward [mm]", both(&|touch| 1e3 * touch.wheel)),
        panel("Contact on the rail", "eta, outward [mm]", both(&|touch| 1e3 * touch.rail)),
    ];
    if !study.wheelset.attitude.level {
        let centred = study.sweep.nearest(0.0).height[0];
        panels.push(panel("Roll", "roll [mrad], left side up", one(&|stand| 1e3 * stand.roll)));
        panels.push(panel("Height of the centre", "rise [mm]", one(&|stand| 1e3 * (stand.height[0] - centred))));
    }
    panels
}

/// The rolling-radius difference within 4/3 of the chosen amplitude, and the cone that is equivalent at that amplitude.
fn near_difference(study: &Study) -> Panel {
    let range = 1e3 * study.chosen.amplitude * 4.0 / 3.0;
    let mut panel = difference(study, range);
    for series in &mut panel.series {
        if series.ink == Ink::line(DARK) {
            series.label = "profiles".into();
        }
    }
    if let Ok(found) = study.chosen.en15302 {
        let end = 1e3 * study.chosen.amplitude;
        let cone = [-end, end].map(|y| (1e3 * found.centre + y, 2.0 * found.value * y));
        panel.series.push(Series::line("equivalent cone", Ink { color: DARK, ..Ink::dashed(ORANGE) }, cone.into()));
    }
    panel
}

fn conicity(study: &Study) -> Vec<Panel> {
    let line = |curve: &[Conicities], label: &str, ink, value: fn(&Conicities) -> Result<Conicity, NoConicity>| {
        // A gap where there is no conicity, as between branches.
        let known = |at: &Conicities| value(at).ok().map(|found| (1e3 * at.amplitude, found.value));
        let parts = curve.chunk_by(|a, b| known(a).is_some() == known(b).is_some());
        let branches = parts.map(|part| part.iter().filter_map(known).collect::<Vec<_>>()).filter(|branch| branch.len() > 1);
        Series { label: label.into(), ink, branches: branches.collect(), marks: vec![] }
    };
    let mut series = vec![
        line(&study.curve, "EN 15302", Ink::line(BLUE), |at| at.en15302),
        line(&study.curve, "harmonic", Ink::dashed(ORANGE), |at| at.harmonic),
    ];
    if let Some(elastic) = &study.elastic {
        let label = format!("EN 15302, {}", elastic_label(elastic));
        series.push(line(&elastic.curve, &label, Ink::line(GREEN), |at| at.en15302));
    }
    if let Ok(found) = study.chosen.en15302 {
        let (x, y) = (1e3 * study.chosen.amplitude, found.value);
        let mark = Mark { x, y, label: format!("{y:.3} at {x} mm"), ..Mark::default() };
        series.push(Series::marks("", Ink { radius: 4.0, ..Ink::line(DARK) }, vec![mark]));
    }
    let mut panel = Panel { leaders: false, ..Panel::new("Equivalent conicity", ["amplitude [mm]", "conicity [-]"], series) };
    panel.y.zero = true;
    vec![near_difference(study), panel]
}

/// How far the wheel is lifted in the picture of contact points, mm.
const LIFT: f64 = 22.0;
/// Pixels per mm there, on both axes.
const SCALE: f64 = 4.4;

/// One side in section, seen along the track: left is left, z up, mm. Lines join the points that touch at each shift.
fn section(study: &Study, side: Side) -> Panel {
    let wheelset = study.wheelset;
    let (wheel, rail) = (&wheelset.wheels[side.index()], wheelset.track.rail(side));
    // In the picture the centred wheelset stands without roll and yaw.
    let height = study.sweep.nearest(0.0).height[side.index()];
    let flat = |point: Vector3<f64>, lift: f64| (1e3 * point.y, 1e3 * point.z + lift);
    let wheel_at = |u: f64| flat(Vector3::new(0.0, side.sign() * (wheel.half_spacing + u), height - wheel.profile.at(u).value), LIFT);
    let rail_at = |eta: f64| flat(rail_point(rail, wheelset.station, eta).0.position, 0.0);
    let along = |(first, last): (f64, f64), place: &dyn Fn(f64) -> (f64, f64)| {
        // Closer together near the ends, where profiles are steep.
        let points = (0..=800).map(|k| place(first + (last - first) * 0.5 * (1.0 - (PI * f64::from(k) / 800.0).cos())));
        Series::line("", Ink::line(DARK), points.collect())
    };
    let every = (study.step.max(1e-3) / study.step).round().max(1.0) * study.step;
    let whole = |sample: &&Sample| sample.asked && (sample.stand.y / every - (sample.stand.y / every).round()).abs() < 1e-6;
    let shifted = |label: &str, color, of: &dyn Fn(f64) -> bool| {
        let ink = Ink { radius: 2.0, width: 1.25, alpha: 0.8, ..Ink::line(color) };
        let mut samples: Vec<&Sample> = study.sweep.samples.iter().filter(whole).filter(|sample| of(sample.stand.y)).collect();
        // Where numbers have no room, those of small shifts come first.
        samples.sort_by(|a, b| a.stand.y.abs().total_cmp(&b.stand.y.abs()));
        let touching = samples.iter().map(|sample| (sample.stand.y, &sample.stand.contacts[side.index()]));
        let places: Vec<_> = touching.map(|(y, touch)| (y, wheel_at(touch.wheel), rail_at(touch.rail))).collect();
        let label_of = |y: f64| format!("{}", (1e6 * y).round() / 1e3);
        let mark = |(x, y): (f64, f64), label: String| Mark { x, y, label, ..Mark::default() };
        let marks = places.iter().flat_map(|(y, wheel, rail)| [mark(*wheel, label_of(*y)), mark(*rail, String::new())]);
        Series { label: label.into(), ink, marks: marks.collect(), branches: places.iter().map(|(_, a, b)| vec![*a, *b]).collect() }
    };
    const NEAR: f64 = 1e-9;
    let series = vec![
        shifted("to the left", BLUE, &|y| y > NEAR),
        shifted("centred", DARK, &|y| y.abs() <= NEAR),
        shifted("to the right", ORANGE, &|y| y < -NEAR),
        along(wheel.profile.range(), &wheel_at),
        along(rail.profile.range(), &rail_at),
    ];
    let tall = 400.0;
    let (across, up) = inside((width(2), tall));
    let (across, up) = (across / SCALE, up / SCALE);
    let centre = rail_at(0.0);
    // The flange hangs toward the track's centre: more room there.
    let (left, below) = (centre.0 + 0.5 * across - side.sign() * 8.0, centre.1 - 0.5 * up + 12.0);
    let axis = |label: &str, range| Axis { label: label.into(), range: Some(range), ..Axis::default() };
    Panel {
        x: axis("across the track, left positive [mm]", (left, left - across)),
        y: axis("height [mm]", (below, below + up)),
        leaders: false,
        height: tall,
        ..Panel::new(if side == Side::Left { "Left wheel and rail" } else { "Right wheel and rail" }, ["", ""], series)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_lines_are_cut_where_they_reach_the_end_of_the_axis() {
        let line = vec![(0.0, -6.0), (1.0, -2.0), (2.0, 0.0), (3.0, 8.0), (4.0, 9.0), (5.0, 3.0)];
        let parts = cut(&[line, vec![(6.0, 20.0), (7.0, 30.0)]], 4.0);
        let wanted = [vec![(0.5, -4.0), (1.0, -2.0), (2.0, 0.0), (2.5, 4.0)], vec![(4.0 + 5.0 / 6.0, 4.0), (5.0, 3.0)]];
        assert_eq!(parts.len(), 2, "{parts:?}");
        for (part, wanted) in parts.iter().zip(&wanted) {
            assert!(part.len() == wanted.len(), "{parts:?}");
            assert!(part.iter().zip(wanted).all(|(a, b)| (a.0 - b.0).abs() < 1e-12 && (a.1 - b.1).abs() < 1e-12), "{parts:?}");
        }
    }
}
