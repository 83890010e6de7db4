//! The centre line: lengths, headings and places against formulas, and derivatives against differences.

use super::centre_line::{Alignment, CentreLine, Node, Pivot};
use super::frame::TrackFrame;
use super::station::Station;
use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;

fn node(distance: f64, curvature: f64, superelevation: f64, grade: f64) -> Node {
    Node { distance, curvature, superelevation, grade }
}

fn line(nodes: Vec<Node>, smoothing: f64) -> CentreLine {
    CentreLine::new(&Alignment { nodes, smoothing, pivot: Pivot::Centre }, Vector3::zeros(), 0.0).unwrap()
}

/// Tangent, 60 m spiral to 3 degrees with 3 in of cant, circle, spiral back.
fn curve(smoothing: f64) -> CentreLine {
    let (k, f) = (1.0 / 582.192, (0.0762f64 / 1.5).asin());
    line(vec![node(20.0, 0.0, 0.0, 0.0), node(80.0, k, -f, 0.0), node(200.0, k, -f, 0.0), node(260.0, 0.0, 0.0, 0.0)], smoothing)
}

#[test]
fn analytic_straight_level_track_has_no_line() {
    let alignment = Alignment { nodes: vec![node(0.0, 0.0, 0.0, 0.0)], ..Alignment::default() };
    assert!(CentreLine::new(&alignment, Vector3::zeros(), 0.0).is_none());
}

#[test]
fn analytic_clothoid_is_fresnels() {
    // Curvature c s from 0: heading c s^2 / 2, place = integral of (cos, sin)(c x^2 / 2) as a power series.
    let (c, length) = (1.0 / 300.0 / 120.0, 240.0);
    let line = line(vec![node(0.0, 0.0, 0.0, 0.0), node(length, c * length, 0.0, 0.0)], 0.0);
    for s in [1e-3, 10.0, 61.7, 150.0, 240.0] {
        let (mut x, mut y, mut term) = (0.0, 0.0, s);
        for n in 0..60 {
            // term = s (c s^2 / 2)^n / n!
            let part = term / (2.0 * n as f64 + 1.0);
            match n % 4 {
                0 => x += part,
                1 => y += part,
                2 => x -= part,
                _ => y -= part,
            }
            term *= 0.5 * c * s * s / (n as f64 + 1.0);
        }
        let frame = line.frame(s);
        assert!((frame.heading - 0.5 * c * s * s).abs() < 1e-15, "{s}");
        assert!((frame.origin - Vector3::new(x, y, 0.0)).norm() < 5e-13, "{s}: {} {x} {y}", frame.origin);
    }
}

#[test]
fn analytic_circle_and_helix_close() {
    let (radius, climb) = (300.0, 0.01f64);
    let line = line(vec![node(0.0, 1.0 / radius, 0.0, climb)], 0.0);
    // After a full turn of heading the line is above its start.
    let frame = line.frame(2.0 * std::f64::consts::PI * radius);
    let rise = 2.0 * std::f64::consts::PI * radius * climb.sin();
    assert!((frame.origin - Vector3::new(0.0, 0.0, rise)).norm() < 1e-11, "{}", frame.origin);
    let centre = Vector3::new(0.0, radius * climb.cos(), 0.0);
    for s in [-1e5, -3.0, 700.0, 5e4] {
        let from = line.frame(s).origin - centre;
        assert!((from.xy().norm() - radius * climb.cos()).abs() < 1e-9, "{s}");
    }
}

/// 100 spirals of 500 m with grades between -1.5 and 1.5 %: reference by 30-digit quadrature (mpmath) of the same definition.
#[test]
fn validate_fifty_kilometres_of_spirals() {
    let k = |i: usize| (((i * 7) % 11) as f64 - 5.0) / 5000.0;
    let g = |i: usize| (((i * 5) % 7) as f64 - 3.0) / 200.0;
    let line = line((0..=100).map(|i| node(500.0 * i as f64, k(i), 0.0, g(i))).collect(), 0.0);
    let frame = line.frame(50_000.0);
    let expected = Vector3::new(48_525.940_115_000_68, 7_216.827_880_703_669, 1.250_013_020_614_150_4);
    let error = (frame.origin - expected).norm();
    println!("error after 50 km: {error:.1e} m, heading {:.1e} rad", frame.heading + 0.15);
    assert!(error < 1e-9 && (frame.heading + 0.15).abs() < 1e-14);
}

#[test]
fn analytic_frame_is_heading_climb_cant() {
    let line = line(vec![node(0.0, 0.002, 0.0, 0.01), node(100.0, -0.001, 0.08, 0.03)], 40.0);
    for s in [0.0, 3.0, 47.0, 98.0] {
        let frame = line.frame(s);
        let axes = frame.axes;
        let climb = axes[(2, 0)].asin();
        let cant = (axes[(2, 1)] / climb.cos()).asin();
        let expected = Rotation3::from_axis_angle(&Vector3::z_axis(), frame.heading)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), -climb)
            * Rotation3::from_axis_angle(&Vector3::x_axis(), cant);
        assert!((axes - expected.matrix()).norm() < 1e-15);
        // cant > 0: the left rail is up; grade > 0 climbs; curvature > 0 turns left.
        assert!(climb > 0.0 && cant >= 0.0);
    }
    assert!(line.frame(100.0).axes[(2, 1)] > 0.05 && line.frame(1.0).bend().y > 0.0);
}

/// Derivatives along s of origin, axes and turn against differences, with and without rounding, on both sides of corners.
#[test]
fn analytic_derivatives_match_differences() {
    for smoothing in [0.0, 10.0, 90.0] {
        let curved = curve(smoothing);
        let h = 1e-4;
        for s in [-5.0, 19.5, 20.5, 25.2, 50.0, 79.3, 81.3, 150.0, 233.0, 262.0] {
            let (at, ahead, behind): (_, TrackFrame, TrackFrame) = (curved.frame(s), curved.frame(s + h), curved.frame(s - h));
            let slope = |a: Vector3<f64>, b: Vector3<f64>| (a - b) / (2.0 * h);
            let near = |a: Vector3<f64>, b: Vector3<f64>, what: &str| assert!((a - b).norm() < 2e-9, "{smoothing} {s} {what}: {a} {b}");
            near(slope(ahead.origin, behind.origin), at.along(), "origin");
            near(slope(ahead.along(), behind.along()), at.bend(), "tangent");
            let turned = at.axes * at.turn.cross_matrix();
            for axis in 0..3 {
                near(slope(ahead.axes.column(axis).into(), behind.axes.column(axis).into()), turned.column(axis).into(), "axes");
            }
            near(slope(ahead.turn, behind.turn), at.turn1, "turn");
            near(slope(ahead.turn1, behind.turn1), at.turn2, "turn1");
        }
    }
}

/// Rounded corners: value and derivatives up to the rails' third are continuous everywhere.
#[test]
fn prop_smoothed_line_is_continuous_to_the_third_derivative() {
    let curved = curve(20.0);
    let jump = |s: f64| {
        let (a, b) = (curved.frame(s - 1e-9), curved.frame(s + 1e-9));
        (a.origin - b.origin).norm().max((a.turn - b.turn).norm()).max((a.turn1 - b.turn1).norm()).max((a.turn2 - b.turn2).norm())
    };
    let largest = (0..30_000).map(|i| jump(0.01 * i as f64)).fold(0.0, f64::max);
    assert!(largest < 3e-9, "{largest}");
    assert!(curved.breaks().is_empty());
}

#[test]
fn analytic_low_rail_stays_level() {
    let base = 1.5;
    let cant = 0.05;
    // From right-hand to left-hand cant: the low rail changes.
    let nodes = vec![node(5.0, 0.0, 0.0, 0.0), node(60.0, 0.0, -cant, 0.0), node(100.0, 0.0, -cant, 0.0), node(200.0, 0.0, cant, 0.0)];
    let alignment = Alignment { nodes, smoothing: 8.0, pivot: Pivot::LowRail { base } };
    let line = CentreLine::new(&alignment, Vector3::zeros(), 0.0).unwrap();
    for (s, low) in [(80.0, 1.0), (230.0, -1.0)] {
        let frame = line.frame(s);
        let rail = frame.origin + frame.axes * Vector3::new(0.0, low * 0.5 * base, 0.0);
        // base / 2 (cant - sin(cant)), plus what the climb of the ramp takes from the length.
        assert!(rail.z.abs() < 0.5 * base * cant.powi(3) / 6.0 + 1e-6, "{s}: {}", rail.z);
        assert!((frame.origin.z - 0.5 * base * cant).abs() < 1e-6);
    }
}

#[test]
fn analytic_station_travels_faster_inside_a_curve() {
    let line = line(vec![node(0.0, 0.002, 0.0, 0.0)], 0.0);
    let (s, y) = (123.0, 0.4);
    let frame = line.frame(s);
    let point = frame.origin + frame.axes * Vector3::new(0.0, y, 0.3);
    let velocity = frame.axes * Vector3::new(20.0, 1.0, -2.0);
    for guess in [s - 40.0, s - 0.3, s, s + 60.0] {
        let station = Station::new(&line, &point, &velocity, guess);
        assert!((station.frame.distance - s).abs() < 1e-12, "{guess}");
        assert!((station.speed - 20.0).abs() < 1e-12 && (station.travel - 20.0 / (1.0 - 0.002 * y)).abs() < 1e-12);
    }
}

proptest! {
    /// The start's place and heading turn and shift the line and change nothing else.
    #[test]
    fn prop_start_moves_the_whole_line(x in -1e3..1e3f64, y in -1e3..1e3f64, z in -50.0..50.0f64, heading in -7.0..7.0f64, s in -100.0..400.0f64) {
        let nodes = vec![node(20.0, 0.0, 0.0, 0.0), node(80.0, 0.002, -0.05, 0.01), node(200.0, -0.003, 0.06, -0.02)];
        let alignment = Alignment { nodes, smoothing: 5.0, pivot: Pivot::LowRail { base: 1.5 } };
        let start = Vector3::new(x, y, z);
        let moved = CentreLine::new(&alignment, start, heading).unwrap().frame(s);
        let plain = CentreLine::new(&alignment, Vector3::zeros(), 0.0).unwrap().frame(s);
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), heading);
        prop_assert!((moved.origin - (start + turn * plain.origin)).norm() < 1e-11);
        prop_assert!((moved.axes - turn.matrix() * plain.axes).norm() < 1e-13);
        prop_assert!((moved.turn - plain.turn).norm() < 1e-15 && (moved.turn2 - plain.turn2).norm() < 1e-15);
    }

    /// What is projected comes back to where it was put.
    #[test]
    fn prop_projection_returns(s in -50.0..350.0f64, y in -1.0..1.0f64, z in -1.0..2.0f64, miss in -5.0..5.0f64) {
        let curved = curve(0.0);
        let frame = curved.frame(s);
        let found = curved.project(&(frame.origin + frame.axes * Vector3::new(0.0, y, z)), s + miss);
        prop_assert!((found.distance - s).abs() < 1e-11, "{} {}", found.distance, s);
    }
}

/// Boxes on an axle: their x axis lies in the track's plane and y is the axle; how they turn agrees with differences along a motion.
#[test]
fn analytic_boxes_stand_upright_on_the_track() {
    let line = line(vec![node(0.0, 0.002, 0.05, -0.01), node(60.0, -0.003, -0.08, 0.03)], 0.0);
    let [v, centre] = [Vector3::new(22.0, 0.3, -0.2), Vector3::new(31.0, 0.7, 0.1)];
    // Yaw and roll, and their rates.
    let ([yaw, roll], [yaw1, roll1]) = ([0.04, -0.03], [0.7, -0.5]);
    let axes = |t: f64| crate::math::rotation::AxleFrame::new(yaw + yaw1 * t, roll + roll1 * t).axes;
    let at = |t: f64| {
        let mut station = Station::new(&line, &(centre + v * t), &v, 31.0);
        station.carry_boxes(&axes(t));
        (station.upright.unwrap(), station.frame.axes.column(2).into_owned())
    };
    let (upright, up) = at(0.0);
    let own = upright.axes;
    assert!((own.transpose() * own - nalgebra::Matrix3::identity()).norm() < 1e-15 && own.column(0).dot(&up).abs() < 1e-15);
    assert!((own.column(1) - axes(0.0).column(1)).norm() == 0.0 && own.column(2).dot(&up) > 0.99 && (own - axes(0.0)).norm() > 1e-3);
    let h = 1e-5;
    let slope = (at(h).0.axes - at(-h).0.axes) / (2.0 * h);
    let expected = slope * own.transpose();
    let frame = Vector3::z() * yaw1 + axes(0.0).column(0) * roll1;
    let found = upright.rotation(&frame, &v).cross_matrix();
    assert!((found - expected).norm() < 1e-8, "{found} {expected}");
    // h counts: the grade and the cant change along the track.
    assert!((upright.by_velocity.dot(&v)).abs() > 1e-3 && upright.by_rotation.norm() > 1e-3);
}
