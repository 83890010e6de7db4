//! Where the wheels of the shown wheelset touched their profiles.

use super::Drawn;
use crate::cli::plot::{Axis, DARK, Ink, Mark, Panel, Series, inside, width};
use crate::geometry::Side;
use crate::geometry::profile::Profile;
use std::collections::BTreeMap;

/// Places nearer than this along a profile are one, m.
const APART: f64 = 1e-4;
/// Most contacts of a wheel that are looked for.
const MOST: usize = 8;
const HEIGHT: f64 = 330.0;

/// Below the title.
pub(super) fn words(drawn: &Drawn) -> String {
    format!("{}, every loaded contact of each output row; sections in their own axes, outward to the right", drawn.wheelset)
}

/// Both rails above, both wheels below; none without the output group "contacts".
pub(super) fn panels(drawn: &Drawn) -> Vec<Panel> {
    let Some(wheelset) = drawn.model.wheelsets.iter().find(|wheelset| wheelset.name == drawn.wheelset) else { return vec![] };
    let mut panels = Vec::new();
    for (part, coordinate, sign) in [("rail", "railCoordinate", 1.0), ("wheel", "wheelCoordinate", -1.0)] {
        for side in Side::BOTH {
            let profile: &dyn Profile =
                if part == "rail" { &*drawn.model.track.rail(side).profile } else { &*wheelset.wheel(side).profile };
            let Some(touched) = touched(drawn, side, coordinate) else { return vec![] };
            panels.push(panel(&format!("{} {part}", if side == Side::Left { "Left" } else { "Right" }), profile, sign, &touched));
        }
    }
    panels
}

/// Of each contact, its places and how many rows found it there; `None` where contacts are not recorded.
fn touched(drawn: &Drawn, side: Side, coordinate: &str) -> Option<Vec<BTreeMap<i64, usize>>> {
    let column =
        |contact: usize, output: &str| drawn.recording.column(&format!("{}.{}.contact[{contact}].{output}", drawn.wheelset, side.name()));
    let of = |contact: usize| -> Option<BTreeMap<i64, usize>> {
        let mut places = BTreeMap::new();
        for (place, force) in column(contact, coordinate)?.into_iter().zip(column(contact, "normalForce")?) {
            if force > 0.0 {
                *places.entry((place / APART).round() as i64).or_default() += 1;
            }
        }
        Some(places)
    };
    let all: Vec<_> = (1..=MOST).map_while(of).collect();
    (!all.is_empty()).then_some(all)
}

/// A profile and its places, mm, one scale on both axes; `sign` turns up what is measured downward.
fn panel(title: &str, profile: &dyn Profile, sign: f64, touched: &[BTreeMap<i64, usize>]) -> Panel {
    let at = |x: f64| (1e3 * x, sign * 1e3 * profile.at(x).value);
    let (first, last) = profile.range();
    let outline = Series::line("", Ink::line(DARK), (0..=1200).map(|k| at(first + (last - first) * f64::from(k) / 1200.0)).collect());
    let mark = |place: &i64| {
        let (x, y) = at(APART * *place as f64);
        Mark { x, y, ..Mark::default() }
    };
    let series = |(k, places): (usize, &BTreeMap<i64, usize>)| Series {
        label: format!("contact {}", k + 1),
        ink: Ink { radius: 4.0, width: 0.0, mark: 0, ..Ink::part(k) },
        branches: vec![],
        marks: places.keys().map(mark).collect(),
    };
    let seen = touched.iter().enumerate().filter(|(_, places)| !places.is_empty()).map(series);
    let all: Vec<Series> = [outline].into_iter().chain(seen).collect();
    let (across, up) = inside((width(2), HEIGHT));
    // The profile with some air, at one scale.
    let points = || all[0].branches.iter().flatten();
    let low = points().map(|point| point.1).fold(f64::INFINITY, f64::min);
    let high = points().map(|point| point.1).fold(f64::NEG_INFINITY, f64::max);
    let (wide, tall) = (1e3 * (last - first) * 1.06, (high - low) * 1.1);
    let scale = (wide / across).max(tall / up);
    let (middle, height) = (500.0 * (first + last), 0.5 * (low + high));
    let axis = |label: &str, middle: f64, pixels: f64| Axis {
        label: label.into(),
        range: Some((middle - 0.5 * scale * pixels, middle + 0.5 * scale * pixels)),
        ..Axis::default()
    };
    Panel {
        x: axis("outward [mm]", middle, across),
        y: axis("height [mm]", height, up),
        leaders: false,
        height: HEIGHT,
        ..Panel::new(title, ["", ""], all)
    }
}
