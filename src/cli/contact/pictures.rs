//! The contact geometry as diagrams.

use super::{Conicities, Study};
use crate::cli::plot::contact_points::{self, Section, Touching};
use crate::cli::plot::curves::{self, Curve, Panel};
use crate::cli::plot::{BLUE, ORANGE};
use crate::geometry::Side;
use crate::geometry::surface::rail_point;
use crate::study::conicity::{Conicity, NoConicity};
use crate::study::contact_geometry::{Stand, Touch};
use crate::study::sweep::Sample;
use nalgebra::Vector3;
use std::path::{Path, PathBuf};

const SHIFT: &str = "lateral shift y [mm], left positive";

/// Draws every picture; returns the files.
pub(super) fn draw(folder: &Path, study: &Study) -> Result<Vec<PathBuf>, String> {
    let file = |what: &str| folder.join(format!("{}_{what}.svg", study.scene.name));
    let [geometry, conicity, points] = ["contact_geometry", "conicity", "contact_points"].map(file);
    let attitude = study.wheelset.attitude;
    let held = if attitude.level { "axle held level" } else { "both wheels touch" };
    let subtitle = format!("{}; {held}, yaw {} mrad", study.scene.title, 1e3 * attitude.yaw);
    curves::draw(&geometry, "Contact geometry", &subtitle, 2, &geometry_panels(study))?;
    curves::draw(&conicity, "Equivalent conicity", &subtitle, 2, &conicity_panels(study))?;
    contact_points::draw(&points, "Contact points", &subtitle, &Side::BOTH.map(|side| section(study, side)))?;
    Ok(vec![geometry, conicity, points])
}

/// Branches of something of a stand, over the lateral shift in mm.
fn branches(study: &Study, value: impl Fn(&Stand) -> f64) -> Vec<Vec<(f64, f64)>> {
    let point = |sample: &Sample| (1e3 * sample.stand.y, value(&sample.stand));
    study.sweep.branches().into_iter().map(|branch| branch.iter().map(point).collect()).collect()
}

/// The same with branches joined where this quantity does not jump.
fn curve<'a>(study: &Study, label: &'a str, side: Option<Side>, value: impl Fn(&Stand) -> f64) -> Curve<'a> {
    let mut joined: Vec<Vec<(f64, f64)>> = Vec::new();
    let all = branches(study, value);
    let (low, high) = all.iter().flatten().fold((f64::MAX, f64::MIN), |(low, high), point| (low.min(point.1), high.max(point.1)));
    for branch in all {
        match joined.last_mut() {
            Some(last) if last.last().zip(branch.first()).is_some_and(|(a, b)| (a.1 - b.1).abs() < 1e-4 * (high - low)) => {
                last.extend(branch)
            }
            _ => joined.push(branch),
        }
    }
    Curve { label, color: if side == Some(Side::Right) { ORANGE } else { BLUE }, dashed: false, branches: joined }
}

fn both<'a>(study: &Study, value: impl Fn(&Touch) -> f64) -> Vec<Curve<'a>> {
    let of = |side: Side| curve(study, side.name(), Some(side), |stand: &Stand| value(&stand.contacts[side.index()]));
    Side::BOTH.map(of).into()
}

fn difference<'a>(study: &Study) -> Panel<'a> {
    let curves = vec![curve(study, "", None, |stand| 1e3 * stand.radius_difference())];
    Panel { title: "Rolling-radius difference", x: SHIFT, y: "left minus right [mm]", curves, marks: vec![], from_zero: true }
}

fn geometry_panels<'a>(study: &Study) -> Vec<Panel<'a>> {
    let panel = |title, y, curves| Panel { title, x: SHIFT, y, curves, marks: vec![], from_zero: false };
    let mut panels = vec![
        difference(study),
        panel("Contact angle", "angle [deg]", both(study, |touch| touch.angle.to_degrees())),
        panel("Contact on the wheel", "u from the tread circle, outward [mm]", both(study, |touch| 1e3 * touch.wheel)),
        panel("Contact on the rail", "eta from the crown, outward [mm]", both(study, |touch| 1e3 * touch.rail)),
    ];
    if !study.wheelset.attitude.level {
        let centred = study.sweep.nearest(0.0).height[0];
        panels.push(panel("Roll", "roll [mrad], left side up", vec![curve(study, "", None, |stand| 1e3 * stand.roll)]));
        panels.push(panel("Height of the centre", "rise [mm]", vec![curve(study, "", None, |stand| 1e3 * (stand.height[0] - centred))]));
    }
    panels
}

/// The rolling-radius difference within 4/3 of the chosen amplitude, and the cone that is equivalent at that amplitude.
fn near_difference<'a>(study: &Study) -> Panel<'a> {
    let range = 1e3 * study.chosen.amplitude * 4.0 / 3.0;
    let mut panel = difference(study);
    for curve in &mut panel.curves {
        for branch in &mut curve.branches {
            branch.retain(|point| point.0.abs() <= range);
        }
        curve.branches.retain(|branch| !branch.is_empty());
        curve.label = "profiles";
    }
    if let Ok(found) = study.chosen.en15302 {
        let end = 1e3 * study.chosen.amplitude;
        let cone = [-end, end].map(|y| (1e3 * found.centre + y, 2.0 * found.value * y)).to_vec();
        panel.curves.push(Curve { label: "equivalent cone", color: ORANGE, dashed: true, branches: vec![cone] });
    }
    panel
}

fn conicity_panels<'a>(study: &Study) -> Vec<Panel<'a>> {
    let line = |label, color, dashed, value: fn(&Conicities) -> Result<Conicity, NoConicity>| {
        // A gap where there is no conicity, as between branches.
        let mut branches: Vec<Vec<(f64, f64)>> = vec![vec![]];
        for at in &study.curve {
            match (value(at), branches.last_mut()) {
                (Ok(found), Some(last)) => last.push((1e3 * at.amplitude, found.value)),
                (Err(_), Some(last)) if !last.is_empty() => branches.push(vec![]),
                _ => {}
            }
        }
        branches.retain(|branch| branch.len() > 1);
        Curve { label, color, dashed, branches }
    };
    let curves = vec![line("EN 15302", BLUE, false, |at| at.en15302), line("harmonic", ORANGE, true, |at| at.harmonic)];
    let chosen = &study.chosen;
    let marks = chosen.en15302.map_or_else(
        |_| vec![],
        |found| vec![((1e3 * chosen.amplitude, found.value), format!("{:.3} at {} mm", found.value, 1e3 * chosen.amplitude))],
    );
    let conicity = Panel { title: "Equivalent conicity", x: "amplitude [mm]", y: "conicity [-]", curves, marks, from_zero: true };
    vec![near_difference(study), conicity]
}

/// How far the wheel is lifted in the picture of contact points, mm.
const LIFT: f64 = 22.0;

/// One side in section: x to the right (so minus Y), z up, mm.
fn section(study: &Study, side: Side) -> Section {
    let wheelset = study.wheelset;
    let centred = study.sweep.nearest(0.0);
    let (wheel, rail) = (&wheelset.wheels[side.index()], wheelset.track.rail(side));
    // In the picture the centred wheelset stands without roll and yaw.
    let height = centred.height[side.index()];
    let flat = |point: Vector3<f64>, lift: f64| (-1e3 * point.y, 1e3 * point.z + lift);
    let wheel_point = |u: f64| {
        let radius = wheel.profile.at(u).value;
        flat(Vector3::new(0.0, side.sign() * (wheel.half_spacing + u), height - radius), LIFT)
    };
    let rail_at = |eta: f64| flat(rail_point(rail, wheelset.station, eta).0.position, 0.0);
    let along = |(first, last): (f64, f64), place: &dyn Fn(f64) -> (f64, f64)| -> Vec<(f64, f64)> {
        // Closer together near the ends, where profiles are steep.
        (0..=800).map(|k| place(first + (last - first) * 0.5 * (1.0 - (std::f64::consts::PI * f64::from(k) / 800.0).cos()))).collect()
    };
    let every = (study.step.max(1e-3) / study.step).round().max(1.0) * study.step;
    let whole = |sample: &&Sample| {
        let place = sample.stand.y / every;
        sample.asked && (place - place.round()).abs() < 1e-6
    };
    let pair = |sample: &Sample| {
        let touch = &sample.stand.contacts[side.index()];
        Touching { shift: 1e3 * sample.stand.y, wheel: wheel_point(touch.wheel), rail: rail_at(touch.rail) }
    };
    let centre = rail_at(0.0);
    let (width, tall) = contact_points::size();
    // The flange hangs toward the track's centre: more room there.
    let inward = -side.sign() * -1.0 * 8.0;
    Section {
        title: if side == Side::Left { "Left wheel and rail" } else { "Right wheel and rail" },
        wheel: along(wheel.profile.range(), &wheel_point),
        rail: along(rail.profile.range(), &rail_at),
        pairs: study.sweep.samples.iter().filter(whole).map(pair).collect(),
        corner: (centre.0 - 0.5 * width + inward, centre.1 - 0.5 * tall + 12.0),
    }
}
