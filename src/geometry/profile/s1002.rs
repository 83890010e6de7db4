//! Wheel profile S1002 of EN 13715 (UIC 510-2), from its eight zones (`data/s1002.csv`).
//!
//! R(u) = radius + z(u), z = 0 at the tread circle u = 0, 70 mm from the flange back. The published zones miss
//! each other by up to 1.2e-4 mm and 8e-6 rad at both ends of zone C (its coefficients are rounded): C alone
//! gives way, by a cubic of at most 1.19e-4 mm; the other joints (below 7e-8 mm) are closed likewise, in the
//! shorter zone. Zone C is evaluated in powers of u + 30.5 mm: in powers of u its terms of 6e4 mm cancel.
//! At u = -70 mm the tangent is vertical; the profile ends where the slope is 10, at u = -69.90 mm. The outer
//! end is u = 60 mm; the chamfer beyond is left out.

use super::drawing::{MM, broken, rows};
use super::outline::{Changes, Outline};
use super::piecewise::{Curve, Piecewise, TERMS};
use super::table::shifted;
use super::{Part, ProfileChoice};
use crate::settings::{Entry, Section, SettingsError};
use crate::units::Dimension;
use serde::Deserialize;
use std::sync::Arc;

pub(super) const ENTRY: Entry<super::Parse> = Entry {
    name: "s1002",
    summary: "wheel S1002 (flange 32.5 mm thick, 28 mm high): needs radius, at the tread circle 70 mm from the flange back",
    reference: "EN 13715, UIC 510-2; coefficients of Netter (DLR)",
    parse,
};

/// Slope at which a wheel profile is cut.
pub(super) const STEEPEST_FLANK: f64 = 10.0;
/// Angles below this belong to the rounding of a drawing's numbers, rad.
pub(super) const SMALL_ANGLE: f64 = 2e-3;

#[derive(Deserialize)]
struct Zone {
    zone: String,
    shape: String,
    from: f64,
    to: f64,
    numbers: String,
}

/// The curve of a zone, m.
fn curve(zone: &Zone) -> Option<Curve> {
    let numbers: Vec<f64> = zone.numbers.split(' ').map(str::parse).collect::<Result<_, _>>().ok()?;
    match (zone.shape.as_str(), numbers.as_slice()) {
        ("crest", [a, r, c]) => Some(Curve::arc(-c * MM, a * MM, r * MM, 1.0)),
        ("hollow", [a, r, c]) => Some(Curve::arc(-c * MM, a * MM, r * MM, -1.0)),
        ("polynomial", terms) if terms.len() <= TERMS => {
            let mut c = [0.0; TERMS];
            c[..terms.len()].copy_from_slice(terms);
            // Zones that do not reach u = 0 are developed about their middle.
            let origin = if zone.from < 0.0 && zone.to > 0.0 { 0.0 } else { 0.5 * (zone.from + zone.to) };
            let c = shifted(c, origin);
            let terms: Vec<f64> = (0..terms.len()).map(|i| c[i] * MM.powi(1 - i as i32)).collect();
            Some(Curve::polynomial(origin * MM, &terms))
        }
        _ => None,
    }
}

/// The profile of a wheel of `radius` [m], and what was changed to close its joints.
fn profile(section: &Section, radius: f64) -> Result<(Piecewise, Changes), SettingsError> {
    let mut outline = Outline::default();
    for zone in rows::<Zone>(section, include_str!("data/s1002.csv"))? {
        let curve = curve(&zone).ok_or_else(|| broken(section))?;
        outline.push(zone.from * MM, zone.to * MM, curve, zone.zone == "C");
    }
    outline.cut_steep(STEEPEST_FLANK);
    let changes = outline.close(SMALL_ANGLE);
    let profile = Piecewise::new(outline.moved(0.0, radius), format!("S1002, radius {radius} m"));
    Ok((profile.ok_or_else(|| broken(section))?, changes))
}

/// No wheel is larger, m.
const LARGEST: f64 = 3.0;

/// Radius at the tread circle; `deepest` [m] is how far the profile reaches below it.
pub(super) fn wheel_radius(section: &Section, deepest: f64) -> Result<f64, SettingsError> {
    let radius = section.positive("radius", Dimension::Length)?;
    if radius > LARGEST {
        return Err(
            section.error("radius", format!("found {radius} m, expected that of a wheel, at most {LARGEST} m: another unit of length?"))
        );
    }
    if radius > deepest {
        return Ok(radius);
    }
    Err(section.error("radius", format!("found {radius} m, but the profile alone reaches {deepest} m below its tread circle")))
}

fn parse(section: &Section, part: Part) -> Result<ProfileChoice, SettingsError> {
    if part == Part::Rail {
        return Err(section.error("kind", "S1002 is a wheel profile; a rail may be \"60e1\", \"60e2\", \"uic60\", ..."));
    }
    // The flange back is cut 21 mm above the tread, the outer edge lies 2.7 mm below it.
    let (profile, _) = profile(section, wheel_radius(section, 0.01)?)?;
    Ok(ProfileChoice::own(Arc::new(profile)))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{check_derivatives, with_section};
    use super::*;
    use crate::geometry::profile::Profile;

    fn s1002(radius: f64) -> (Piecewise, Changes) {
        with_section("", |section| profile(section, radius)).unwrap()
    }

    #[test]
    fn analytic_joints_are_closed_to_rounding_by_less_than_a_micrometre() {
        let (profile, changes) = s1002(0.46);
        let (step, angle) = profile.largest_jumps();
        println!("closing {:.3e} m, steps {step:.1e} m, slopes {angle:.1e}", changes.closing);
        assert!(step < 2e-16 && angle < 1e-13, "{step} {angle}");
        assert!(changes.closing > 1.1e-7 && changes.closing < 1.19e-7, "{}", changes.closing);
        assert!(profile.kinks().is_empty());
        // Seven joints; the curvature jumps at every one, if only by 1e-3 1/m at both ends of zone C.
        assert_eq!(profile.joints().len(), 7);
        for (found, wanted) in
            profile.joints().iter().zip([-62.764705882, -49.662510381, -39.764473993, -38.426669071, -35.0, -26.0, 32.15796])
        {
            assert!((found - 1e-3 * wanted).abs() < 1e-15);
        }
    }

    #[test]
    fn validate_published_heights_and_slopes() {
        let (profile, _) = s1002(0.46);
        // EN 13715: tread circle at u = 0; flange 28 mm high, its tip at 55 mm; outer tread 1:15; throat slope.
        assert_eq!(profile.at(0.0).value, 0.46);
        let tip = profile.at(-0.055);
        assert!((tip.value - 0.488).abs() < 1e-10 && tip.d1.abs() < 1e-7, "{tip:?}");
        assert!((profile.at(0.05).d1 + 1.0 / 15.0).abs() < 1e-8);
        assert!((profile.at(-0.039).d1 + 70f64.to_radians().tan()).abs() < 1e-7, "70 degree flange");
        // Flange thickness: 10 mm below the tread circle's height the flange face is 32.5 mm from the back.
        let gauge = (0..60).fold((-0.0395, -0.0375), |(a, b), _| {
            let middle = 0.5 * (a + b);
            if profile.at(middle).value > 0.47 { (middle, b) } else { (a, middle) }
        });
        assert!((1e3 * gauge.0 + 37.5).abs() < 0.02, "{gauge:?}");
        // The zones' own formulas where nothing was changed (zone B) and in zone C, where at most 1.2e-4 mm were.
        let zone_b = |y: f64| {
            let c = [
                0.0,
                -0.03358537058,
                0.001565681624,
                -2.810427944e-5,
                5.844240864e-8,
                -1.562379023e-8,
                5.309217349e-15,
                -5.957839843e-12,
                2.646656573e-13,
            ];
            c.iter().rev().fold(0.0, |sum, c| sum * y + c)
        };
        for y in [-25.0, -10.0, 3.0, 20.0, 32.0] {
            assert!((profile.at(1e-3 * y).value - 0.46 - 1e-3 * zone_b(y)).abs() < 1e-15, "{y}");
        }
        let c = [-4320.221063, -1038.384026, -106.5501873, -6.051367875, -0.2054332446, -0.004169739389, -4.687195829e-5, -2.25275554e-7];
        for y in [-34.9, -30.0, -26.1] {
            let z = c.iter().rev().fold(0.0, |sum, c| sum * y + c);
            assert!((profile.at(1e-3 * y).value - 0.46 - 1e-3 * z).abs() < 1.2e-7, "{y}");
        }
    }

    #[test]
    fn analytic_derivatives_are_those_of_the_value() {
        let (profile, _) = s1002(0.46);
        let (first, last) = profile.range();
        assert!((first + 0.06990).abs() < 1e-5 && last == 0.06, "{first} {last}");
        assert!((profile.at(first).d1 - 10.0).abs() < 1e-9);
        check_derivatives(&profile);
    }

    #[test]
    fn hard_wrong_use_is_refused() {
        let refuse = |text: &str, part| with_section(text, |section| parse(section, part)).unwrap_err().to_string();
        assert_eq!(
            refuse("kind = \"s1002\"\n", Part::Wheel),
            "t.toml: radius: is missing; expected a number in m; a string may carry mm, um, cm, km, in, ft"
        );
        assert!(refuse("kind = \"s1002\"\n", Part::Rail).starts_with("t.toml:1: kind: S1002 is a wheel profile"));
        assert!(refuse("kind = \"s1002\"\nradius = \"4 mm\"\n", Part::Wheel).starts_with("t.toml:2: radius: found 0.004 m"));
    }
}
