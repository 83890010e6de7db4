//! Rail heads 60E1, 60E2 and the older UIC60 as chains of arcs (`data/rails.csv`).
//!
//! f(eta) = 0 at the crown, symmetric. Each arc's centre lies on the normal at the end of the arc before it, so
//! value and slope are continuous by construction and only the curvature jumps (1/300, 1/80, 1/13 per mm). The
//! last arc ends tangent to the flank, slope 20, at |eta| = 36.000 mm; beyond, the flank itself goes on as the
//! straight line. The section is un-inclined: `track.inclination` turns it.

use super::drawing::{MM, broken, rows};
use super::piecewise::{Curve, Piece, Piecewise};
use super::{Part, ProfileChoice};
use crate::settings::{Entry, Section, SettingsError};
use serde::Deserialize;
use std::sync::Arc;

pub(super) const E1: Entry<super::Parse> = Entry {
    name: "60e1",
    summary: "rail 60E1, head of arcs R300, R80, R13, un-inclined",
    reference: "EN 13674-1:2017, drawing numbers",
    parse: |section, part| parse(section, part, "60E1"),
};
pub(super) const E2: Entry<super::Parse> = Entry {
    name: "60e2",
    summary: "rail 60E2, head of arcs R200, R70, R16, R8, un-inclined",
    reference: "EN 13674-1:2017, drawing numbers",
    parse: |section, part| parse(section, part, "60E2"),
};
pub(super) const UIC60: Entry<super::Parse> = Entry {
    name: "uic60",
    summary: "rail UIC60 of the Manchester Benchmarks and EN 15302: as 60e1, R80 and R13 begin up to 0.3 mm elsewhere",
    reference: "limits of the arcs fitted to a point file of the open program CONTACT",
    parse: |section, part| parse(section, part, "UIC60"),
};

/// Slope of the flank, 1:20 from the vertical.
const FLANK: f64 = 20.0;

#[derive(Deserialize)]
struct Row {
    rail: String,
    radius: f64,
    limit: Option<f64>,
}

/// One arc of the right half, m.
struct Link {
    radius: f64,
    centre: (f64, f64),
    to: f64,
}

/// The chain of arcs from the crown to the flank, mm made m.
fn chain(section: &Section, rail: &str) -> Result<Vec<Link>, SettingsError> {
    let flank = FLANK / (1.0 + FLANK * FLANK).sqrt();
    let mut links: Vec<Link> = Vec::new();
    for row in rows::<Row>(section, include_str!("data/rails.csv"))?.into_iter().filter(|row| row.rail == rail) {
        let radius = row.radius * MM;
        let centre = match links.last() {
            None => (0.0, -radius),
            Some(last) => {
                // From the old centre along the common normal: sine and cosine of its angle from the vertical.
                let sine = (last.to - last.centre.0) / last.radius;
                let step = last.radius - radius;
                (last.centre.0 + step * sine, last.centre.1 + step * (1.0 - sine * sine).sqrt())
            }
        };
        let to = row.limit.map_or(centre.0 + radius * flank, |limit| limit * MM);
        links.push(Link { radius, centre, to });
    }
    Ok(links)
}

/// The head as a profile: the chain and its mirror image.
fn head(section: &Section, rail: &str) -> Result<Piecewise, SettingsError> {
    let links = chain(section, rail)?;
    let mut pieces = Vec::new();
    for (i, link) in links.iter().enumerate().rev().filter(|(i, _)| *i > 0) {
        let curve = Curve::arc(-link.centre.0, link.centre.1, link.radius, 1.0);
        pieces.push(Piece { from: -link.to, to: -links[i - 1].to, curve });
    }
    for (i, link) in links.iter().enumerate() {
        // The crown is one arc, and f(0) = 0 exactly.
        let curve = Curve::arc(link.centre.0, link.centre.1, link.radius, 1.0);
        pieces.push(Piece { from: if i == 0 { -link.to } else { links[i - 1].to }, to: link.to, curve });
    }
    Piecewise::new(pieces, format!("rail {rail}, head of arcs, un-inclined")).ok_or_else(|| broken(section))
}

fn parse(section: &Section, part: Part, rail: &str) -> Result<ProfileChoice, SettingsError> {
    if part == Part::Wheel {
        return Err(section.error("kind", format!("{rail} is a rail profile; a wheel may be \"s1002\", \"apta\", \"cone\", ...")));
    }
    Ok(ProfileChoice::own(Arc::new(head(section, rail)?)))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{check_derivatives, with_section};
    use super::*;
    use crate::geometry::profile::Profile;

    fn rail(name: &str) -> Piecewise {
        with_section("", |section| head(section, name)).unwrap()
    }

    #[test]
    fn validate_last_arc_ends_on_the_flank_of_a_72_mm_head() {
        // EN 13674-1: head 72 mm wide at 14.3 mm below the crown, tangent to the flank 1:20.
        for (name, height) in [("60E1", -14.29996), ("60E2", -14.30017), ("UIC60", -14.25974)] {
            let rail = rail(name);
            let (first, last) = rail.range();
            let end = rail.at(last);
            println!("{name}: ends at {:.6} mm, {:.6} mm, slope {}", 1e3 * last, 1e3 * end.value, end.d1);
            assert!((last - 0.036).abs() < 2.5e-7 && first == -last, "{last}");
            assert!((1e3 * end.value - height).abs() < 1e-5, "{}", end.value);
            assert!((end.d1 + 20.0).abs() < 1e-9);
            assert_eq!(rail.at(0.0), ProfilePointAt::crown(if name == "60E2" { 0.2 } else { 0.3 }));
        }
    }

    /// What a crown must be.
    struct ProfilePointAt;
    impl ProfilePointAt {
        fn crown(radius: f64) -> crate::geometry::profile::ProfilePoint {
            let inverse = 1.0 / radius;
            crate::geometry::profile::ProfilePoint { value: 0.0, d1: -0.0, d2: -(radius * radius * inverse * inverse * inverse), d3: -0.0 }
        }
    }

    #[test]
    fn validate_end_points_of_the_arcs() {
        // Computed independently with the same construction: 60E1 leaves R300 0.174404 mm and R80 2.302524 mm below the crown.
        let rail = rail("60E1");
        for (eta, drop) in [(10.228, 0.174404), (26.0265, 2.302524), (-26.0265, 2.302524)] {
            assert!((1e3 * rail.at(1e-3 * eta).value + drop).abs() < 1e-6, "{eta}");
        }
        for eta in [0.001, 0.02, 0.03, 0.035] {
            assert_eq!(rail.at(eta).value, rail.at(-eta).value);
        }
    }

    #[test]
    fn validate_60e1_and_uic60_differ_by_40_micrometres_on_the_gauge_corner() {
        // An independent program with the same two constructions: UIC60 is higher, by 0.024400 mm at 20 mm, 0.040343 mm
        // at 30 mm (R13, whose centre is 0.0402 mm higher); across the surface by at most 0.0392 mm, at 26.03 mm.
        let (new, old) = (rail("60E1"), rail("UIC60"));
        for (eta, gap) in [(10.0, 0.0), (20.0, 0.024400), (30.0, 0.040343)] {
            assert!((1e3 * (old.at(1e-3 * eta).value - new.at(1e-3 * eta).value) - gap).abs() < 1e-6, "{eta}");
        }
        let across = |x: f64| (old.at(x).value - new.at(x).value) / (1.0 + new.at(x).d1.powi(2)).sqrt();
        let (eta, gap) =
            (0..35_900).map(|i| 1e-6 * f64::from(i)).map(|x| (x, across(x))).fold((0.0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        println!("largest distance {:.4} mm at {:.3} mm", 1e3 * gap, 1e3 * eta);
        assert!((1e3 * gap - 0.03917).abs() < 1e-5 && (1e3 * eta - 26.025).abs() < 0.01);
    }

    #[test]
    fn analytic_tangent_chain_has_no_steps_and_no_kinks() {
        for (name, joints) in [("60E1", 4), ("60E2", 6), ("UIC60", 4)] {
            let rail = rail(name);
            let (step, slope) = rail.largest_jumps();
            println!("{name}: steps {step:.1e} m, slopes {slope:.1e}");
            assert!(step < 1e-16 && slope < 1e-14, "{step} {slope}");
            assert!(rail.kinks().is_empty());
            assert_eq!(rail.joints().len(), joints);
            check_derivatives(&rail);
        }
    }

    #[test]
    fn hard_a_rail_is_no_wheel() {
        let error = with_section("kind = \"60e1\"\n", |section| parse(section, Part::Wheel, "60E1")).unwrap_err();
        assert!(error.to_string().starts_with("t.toml:1: kind: 60E1 is a rail profile"));
    }
}
