//! Wheel profiles of APTA PR-M-S-015-06 (`data/apta.csv`): lines and arcs of the standard's appendix.
//!
//! R(u) = radius + y(x) - y(taping line), u = x - x(flange back) - `taping_line`. The standard's drawings, as
//! published, name no taping line that the data carry: 70 mm from the flange back is assumed unless the scene
//! says otherwise. The published points, radii and centres miss each other by up to 0.022 mm, and pieces meet
//! at angles of up to 0.175 rad (flange tip of APTA120; 0.05 rad on its tread). Steps, and angles below 2 mrad,
//! are closed in the shorter piece; larger angles are rounded by fillets of 20 mm radius, which leave the
//! corner by radius angle^2 / 8: 0.08 mm at that flange tip, 6 um on that tread. Ends steeper than 10 are cut.

use super::drawing::{MM, broken, rows};
use super::outline::{Changes, Outline};
use super::piecewise::{Curve, Piecewise};
use super::s1002::{SMALL_ANGLE, STEEPEST_FLANK, wheel_radius};
use super::{Part, ProfileChoice};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use serde::Deserialize;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "apta",
    summary: "North American wheel: needs design (\"APTA120\", \"APTA140\", ... \"NRCCAmtrak\") and radius; taping_line = \"70 mm\" from the flange back is assumed",
    reference: "APTA PR-M-S-015-06 Rev. 1 (2022), appendix C",
    parse,
};

/// Designs in the data.
const DESIGNS: &[&str] = &["APTA120", "APTA140", "APTA140M", "APTA220", "APTA240", "APTA320", "APTA340", "NRCC6Acela", "NRCCAmtrak"];
/// Distance of the taping line from the flange back where the scene gives none, m. Assumed.
const TAPING_LINE: f64 = 0.07;
/// Fillets that round the angles of the drawing, m.
const FILLET: f64 = 0.02;

#[derive(Deserialize)]
struct Row {
    design: String,
    x0: f64,
    y0: f64,
    x1: f64,
    y1: f64,
    radius: Option<f64>,
    xc: Option<f64>,
    yc: Option<f64>,
}

/// Profile of a design, and the changes that smoothed it.
fn profile(section: &Section, design: &str, radius: f64, taping_line: f64) -> Result<(Piecewise, Changes), SettingsError> {
    let mut outline = Outline::default();
    let mut back = None;
    for row in rows::<Row>(section, include_str!("data/apta.csv"))?.iter().filter(|row| row.design == design) {
        let (from, to) = ((row.x0 * MM, row.y0 * MM), (row.x1 * MM, row.y1 * MM));
        back = back.or(Some(from.0));
        let curve = match (row.radius, row.xc, row.yc) {
            (Some(radius), Some(xc), Some(yc)) => {
                // The upper half where the arc lies above its centre.
                let branch = if row.y0 + row.y1 > 2.0 * yc { 1.0 } else { -1.0 };
                Curve::arc(xc * MM, yc * MM, radius * MM, branch)
            }
            _ => Curve::line(from, to),
        };
        outline.push(from.0, to.0, curve, false);
    }
    outline.cut_steep(STEEPEST_FLANK);
    let closing = outline.close(SMALL_ANGLE);
    let rounding = outline.round(SMALL_ANGLE, FILLET);
    let datum = back.ok_or_else(|| broken(section))? + taping_line;
    let height = outline.value(datum).ok_or_else(|| {
        section.error("taping_line", format!("found {taping_line} m, which is not on the profile; it counts from the flange back"))
    })?;
    let description = format!("{design}, radius {radius} m at the taping line {:.2} mm from the flange back", 1e3 * taping_line);
    let pieces = outline.moved(-datum, radius - height);
    let profile = Piecewise::new(pieces, description).ok_or_else(|| broken(section))?;
    Ok((profile, Changes { closing: closing.closing, rounding: rounding.rounding }))
}

fn parse(section: &Section, part: Part) -> Result<ProfileChoice, SettingsError> {
    if part == Part::Rail {
        return Err(section.error("kind", "APTA profiles are wheel profiles; a rail may be \"60e1\", \"60e2\", \"uic60\", ..."));
    }
    let design = section.word("design", DESIGNS)?;
    let radius = wheel_radius(section, 0.03)?;
    let given = section.optional("taping_line", Dimension::Length)?;
    let (profile, _) = profile(section, design, radius, given.unwrap_or(TAPING_LINE))?;
    let mut choice = ProfileChoice::own(Arc::new(profile));
    if given.is_none() {
        choice.notes.push("taping_line: 70 mm from the flange back assumed (the published data name none)".into());
    }
    Ok(choice)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{check_derivatives, with_section};
    use super::*;
    use crate::geometry::profile::Profile;

    #[test]
    fn analytic_every_design_is_smooth_and_its_changes_are_small() {
        let mut names: Vec<String> = with_section("", |section| rows::<Row>(section, include_str!("data/apta.csv")))
            .unwrap()
            .into_iter()
            .map(|row| row.design)
            .collect();
        names.dedup();
        assert_eq!(names, DESIGNS);
        for design in DESIGNS {
            let (profile, changes) = with_section("", |section| profile(section, design, 0.46, 0.07)).unwrap();
            let (step, slope) = profile.largest_jumps();
            let (first, last) = profile.range();
            println!(
                "{design:10}: closed {:.4} mm, rounded {:.4} mm, {:.2} .. {:.2} mm, {} joints, steps {step:.0e}, slopes {slope:.0e}",
                1e3 * changes.closing,
                1e3 * changes.rounding,
                1e3 * first,
                1e3 * last,
                profile.joints().len()
            );
            assert!(step < 5e-16 && slope < 2e-13);
            assert!(profile.kinks().is_empty());
            assert!(changes.closing < 0.025e-3 && changes.rounding < 0.08e-3);
            assert!((profile.at(0.0).value - 0.46).abs() < 1e-15);
            check_derivatives(&profile);
        }
    }

    #[test]
    fn validate_apta120_dimensions() {
        let (profile, _) = with_section("", |section| profile(section, "APTA120", 0.46, 0.07)).unwrap();
        // Tread 1:20 (drawing: 3.8506 mm on 76.9925 mm); the flange's face at its flattest 65.6 degrees as published.
        assert!((profile.at(0.0).d1 + 3.8506 / 76.9925).abs() < 1e-6, "{}", profile.at(0.0).d1);
        // x = 0 (gauge point) is u = -40.63 mm; beside it the published corner (-0.6858, 1.1811), of which the fillet
        // takes 20 mm 0.066^2 / 8 = 0.011 mm across the flank, 0.025 mm in height.
        let published = profile.at((-0.6858 + 29.37 - 70.0) * 1e-3).value - profile.at((26.0 + 29.37 - 70.0) * 1e-3).value;
        let line = -15.875 - (26.0 - 18.2575) * 3.8506 / 76.9925;
        assert!((published * 1e3 - (1.1811 - line) + 0.022).abs() < 0.004, "{published}");
        // The flange tip is a design height of 1 in above the base line y = -15.875 mm, rounded here.
        let tip = (0..2000).map(|i| profile.at(-0.06 + 1e-5 * f64::from(i)).value).fold(0.0, f64::max);
        let base = profile.at((18.2575 + 29.37 - 70.0) * 1e-3).value;
        assert!(((tip - base) * 1e3 - 25.4).abs() < 0.1, "{}", tip - base);
    }

    #[test]
    fn hard_taping_line_and_design_are_checked() {
        let refuse = |text: &str| with_section(text, |section| parse(section, Part::Wheel)).unwrap_err().to_string();
        assert!(refuse("design = \"APTA12\"\nradius = 0.46\n").contains("did you mean \"APTA120\""));
        assert!(
            refuse("design = \"APTA120\"\nradius = 0.46\ntaping_line = 0.2\n")
                .starts_with("t.toml:3: taping_line: found 0.2 m, which is not on the profile")
        );
        let text = "design = \"APTA120\"\nradius = 0.46\n";
        let choice = with_section(text, |section| parse(section, Part::Wheel)).unwrap();
        assert_eq!(choice.notes.len(), 1);
    }
}
