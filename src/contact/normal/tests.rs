use super::curvature::{Across, Conformal, LARGEST_RATIO, Rule};
use super::hertz::Hertz;
use super::hertz_integrals::ellipse_functions_exact;
use super::hertz_table::EllipseTable;
use super::test_surfaces::{Shape, Stand, touching};
use super::*;
use crate::contact::search::algebraic::SurfaceParameters;
use crate::geometry::profile::Profile;

const STEEL: Material = Material { youngs_modulus: 2.07e11, poisson_ratio: 0.28 };

fn law(across: Across, conformal: Conformal) -> Hertz {
    Hertz::with(STEEL, Rule { across, conformal })
}

#[test]
fn analytic_overlap_of_a_circle_with_its_tangent_at_any_slope() {
    // g(t) = r - sqrt(r^2 - t^2): the integral of (1 - g/L)^2 by Simpson's rule, however steep the flank is.
    let mut worst = 0.0f64;
    for radius in [0.013, 0.08, 0.3] {
        for level in [1e-6, 6e-5] {
            let end = f64::sqrt(2.0 * radius * level - level * level);
            let depth = |i: u32| {
                let t = end * f64::from(i) / 1000.0;
                (1.0 - t * t / (radius + f64::sqrt(radius * radius - t * t)) / level).powi(2)
            };
            let exact = (0..500).map(|i| depth(2 * i) + 4.0 * depth(2 * i + 1) + depth(2 * i + 2)).sum::<f64>() * end / 3000.0;
            for slope in [0.0, 0.03, -0.5, 1.0] {
                let wheel = Shape::new(0.46, -slope, &[(0.0, 0.0)]);
                let rail = Shape::new(0.0, slope, &[(0.0, -1.0 / radius)]);
                let shape = touching(&wheel, &rail, 1.09);
                // As the rule has it, and half of that.
                for share in [0.5, 1.0] {
                    let reach = share * 1.5 * f64::sqrt(level * LARGEST_RATIO / 1.09);
                    let first = 0.04 * reach / (1.0 + 40.0 * slope * slope);
                    for found in shape.overlap(level, reach) {
                        let error = found.unwrap().x / exact - 1.0;
                        worst = worst.max(error.abs());
                        // The cubic from 0 to h through an arc lies below it by (h - t)^2 / (4 r^2) of the gap, at most h^2 / (4 r^2). Sections are read p h beside the
                        // wanted points.
                        let bound = 0.25 * (first / radius).powi(2) + (0.02 + 0.2 * slope.abs()) * level / radius;
                        assert!(error.abs() < 1e-6 + 1e-15 / level + bound, "{slope} {radius} {level} {share} {error:e} {bound:e}");
                    }
                }
                assert_eq!(shape.overlap(level, 0.29 * end), [None; 2]);
            }
        }
    }
    println!("furthest from the circle's integral: {worst:.1e}");
}

#[test]
fn analytic_constant_curvature_gives_the_point_rule() {
    let (point, patch) = (law(Across::Point, Conformal::Error), law(Across::Patch, Conformal::Error));
    let shape = ContactShape::of_constant_curvature(1.09, 1.7);
    for delta in [1e-6, 7e-5] {
        let (a, b) = (point.contact(&shape, delta).unwrap(), patch.contact(&shape, delta).unwrap());
        assert!((a.force / b.force - 1.0).abs() < 1e-14 && (a.patch.b / b.patch.b - 1.0).abs() < 1e-14);
    }
    // Arcs: B (1 + 3/14 L/r), L = 0.9 delta.
    let wheel = Shape::new(0.46, 0.4, &[(0.0, 0.0)]);
    for radius in [0.013, 0.3] {
        let rail = Shape::new(0.0, -0.4, &[(0.0, -1.0 / radius)]);
        let shape = touching(&wheel, &rail, 1.09);
        let rule = Rule { across: Across::Patch, conformal: Conformal::Error };
        let found = rule.across(&shape, 7e-5).unwrap().across;
        let expected = (1.0 + 3.0 / 14.0 * 0.9 * 7e-5 / radius) / (2.0 * radius);
        assert!((found / expected - 1.0).abs() < 0.05 * 0.9 * 7e-5 / radius, "{radius}: {found} {expected}");
        let (a, b) = (point.contact(&shape, 7e-5).unwrap(), patch.contact(&shape, 7e-5).unwrap());
        println!("arc of {radius} m: N over the patch / at the point - 1 = {:.1e}", b.force / a.force - 1.0);
        assert!((b.force / a.force - 1.0).abs() < 5e-4);
    }
}

#[test]
fn analytic_two_radii_that_meet_under_the_contact_give_the_mean_width() {
    let wheel = Shape::new(0.46, 0.0, &[(0.0, 0.0)]);
    // The first piece serves x < 0.
    let rail = Shape::new(0.0, 0.0, &[(0.0, -1.0 / 0.3), (0.0, -1.0 / 0.08)]);
    let shape = touching(&wheel, &rail, 1.09);
    let level = 0.9 * 7e-5;
    let half_width = 0.5 * f64::sqrt(2.0 * level) * (f64::sqrt(0.3) + f64::sqrt(0.08));
    let found = Rule { across: Across::Patch, conformal: Conformal::Error }.across(&shape, 7e-5).unwrap().across;
    // But for 0.21 L / r.
    assert!((found / (level / (half_width * half_width)) - 1.0).abs() < 2e-4, "{found}");
}

#[test]
fn analytic_force_is_smooth_where_the_contact_crosses_a_jump_of_curvature() {
    // Radii 300 mm | 80 mm meet where the slope is that of the wheel's tread circle.
    let joint = 0.010;
    let rail = Shape::new(0.0, 0.0, &[(0.0, -1.0 / 0.3), (joint, -1.0 / 0.08)]);
    let slope = rail.at(joint).d1;
    // A hollow wheel (radius 400 mm), so that the contact moves with y.
    let wheel = Shape::new(0.46, -slope, &[(0.0, 1.0 / 0.4)]);
    let stand = Stand::new(wheel, rail);
    let z = 0.46 - 7e-5 + stand.rail.profile.at(joint).value;
    let (point, patch) = (law(Across::Point, Conformal::Error), law(Across::Patch, Conformal::Error));
    let mut memory = SurfaceParameters { rail: joint, ..Default::default() };
    let mut at = |y: f64| {
        let found = stand.find(joint + y, z, &memory).unwrap();
        memory = found.parameters;
        let forces = [stand.force(&point, &found), stand.force(&patch, &found)];
        (found.parameters.rail - joint, forces, found.penetration)
    };
    // The pose at which the contact is at the joint.
    let (mut low, mut high) = (-2e-3, 2e-3);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if at(middle).0 > 0.0 { low = middle } else { high = middle }
    }
    let crossing = 0.5 * (low + high);
    let h = 1e-6;
    let side = |at: &mut dyn FnMut(f64) -> (f64, [f64; 2], f64), sign: f64| {
        let (near, far) = (at(crossing + sign * 1e-9), at(crossing + sign * (1e-9 + h)));
        (near.1, [0, 1].map(|i| sign * (far.1[i] - near.1[i]) / h), sign * (far.0 - near.0) / h)
    };
    let (before, after) = (side(&mut at, -1.0), side(&mut at, 1.0));
    let jump = [0, 1].map(|i| after.0[i] / before.0[i] - 1.0);
    println!("the contact moves {:.2} and {:.2} m per m of the wheelset", before.2, after.2);
    println!("jump of N: at the point {:.2e}, over the patch {:.2e}", jump[0], jump[1]);
    println!("slope of N before and after, N/m: {:.4e} {:.4e}; N {:.4e}", before.1[1], after.1[1], before.0[1]);
    assert!(jump[0].abs() > 0.5 && jump[1].abs() < 2e-6);
    // What is left of a kink, as a change of N over the patch's half width of 5 mm.
    let kink = (after.1[1] - before.1[1]).abs() * 5e-3 / before.0[1];
    println!("kink over 5 mm: {kink:.1e} of N");
    assert!(kink < 1e-3);
    // The whole crossing: no step of N stands out from its neighbours.
    for i in 0..150 {
        // Warm starts need neighbours.
        at(crossing - 1e-5 * f64::from(i));
    }
    let forces: Vec<f64> = (-150..=150).map(|i| at(crossing + 1e-5 * f64::from(i)).1[1]).collect();
    let second: Vec<f64> = forces.windows(3).map(|n| (n[0] - 2.0 * n[1] + n[2]) / n[1]).collect();
    let worst = second.iter().fold(0.0, |worst: f64, s| worst.max(s.abs()));
    println!("largest second difference at steps of 10 um: {worst:.1e} of N");
    assert!(worst < 2e-4);
}

#[test]
fn validate_force_over_the_patch_against_half_space_solutions() {
    // Boundary elements of 0.3 mm on an elastic half space (conjugate gradients, FFT; another program), given penetration 70 um,
    // E 207 GPa, nu 0.28, S1002 on 60E1 inclined 1:40, gap of the profiles taken along the normal; kN.
    let exact = [
        (-3.0, 58.53),
        (-1.0, 66.11),
        (-0.5, 70.77),
        (0.0, 79.10),
        (0.5, 89.16),
        (1.0, 80.67),
        (1.2, 73.10),
        (1.5, 63.20),
        (2.0, 51.78),
        (2.5, 47.41),
        (3.0, 46.50),
        (4.0, 47.25),
    ];
    let stand = Stand::s1002_on_60e1();
    let (point, patch) = (law(Across::Point, Conformal::Error), law(Across::Patch, Conformal::Error));
    let (mut worst_point, mut worst_patch) = (0.0f64, 0.0f64);
    for (y, force) in exact {
        // To the right of y = 0.7 mm the contact lies on the rail's inner radius of 80 mm.
        let start = if y < 0.7 { 0.0 } else { -0.011 };
        let start = SurfaceParameters { rail: start, wheel: start, ..Default::default() };
        let found = stand.pressed(1e-3 * y, 7e-5, &start).unwrap();
        let [at_point, over_patch] = [&point, &patch].map(|law| 1e-3 * stand.force(law, &found) / force - 1.0);
        println!("y {y:4.1} mm: at the point {:+6.1} %, over the patch {:+6.1} %", 100.0 * at_point, 100.0 * over_patch);
        worst_point = worst_point.max(at_point.abs());
        worst_patch = worst_patch.max(over_patch.abs());
    }
    assert!(worst_patch < 0.06 && worst_point > 0.25, "{worst_patch} {worst_point}");
}

#[test]
fn hard_s1002_on_60e1_never_fails_when_bounded_and_does_not_jump() {
    let stand = Stand::s1002_on_60e1();
    let laws = [
        law(Across::Point, Conformal::Error),
        law(Across::Point, Conformal::Bounded),
        law(Across::Patch, Conformal::Error),
        law(Across::Patch, Conformal::Bounded),
    ];
    let delta = 7e-5;
    let (mut count, mut refused, mut ratios) = (0, [0; 4], [f64::INFINITY; 4]);
    let mut steepest = [0.0f64; 4];
    let mut last: Option<(f64, [Option<f64>; 4])> = None;
    let mut memory = SurfaceParameters::default();
    let mut bounded_changes = 0;
    for i in -600..=600 {
        let y = 1e-5 * f64::from(i);
        let Some(found) = stand.pressed(y, delta, &memory) else {
            (last, memory) = (None, SurfaceParameters::default());
            continue;
        };
        memory = found.parameters;
        let shape = found.shape(&stand.wheel, &stand.rail);
        let forces = [0, 1, 2, 3].map(|k| match laws[k].contact(&shape, found.penetration) {
            Ok(contact) => {
                ratios[k] = ratios[k].min(contact.patch.a / contact.patch.b);
                Some(contact.force)
            }
            Err(_) => {
                refused[k] += 1;
                None
            }
        });
        count += 1;
        assert!(forces[1].is_some() && forces[3].is_some());
        if forces[2] != forces[3] {
            bounded_changes += 1;
        }
        if i % 50 == 0 {
            let n = forces.map(|f| f.map_or("refused".into(), |f| format!("{:.1} kN", 1e-3 * f)));
            println!("y {:5.1} mm, eta {:6.2} mm, B {:8.3}: {n:?}", 1e3 * y, 1e3 * found.parameters.rail, shape.across);
        }
        if let Some((rail, before)) = last
            && (found.parameters.rail - rail).abs() < 5e-4
        {
            for k in 0..4 {
                if let (Some(a), Some(b)) = (before[k], forces[k]) {
                    steepest[k] = steepest[k].max((b / a - 1.0).abs());
                }
            }
        }
        last = Some((found.parameters.rail, forces));
    }
    println!("{count} places; refused {refused:?}; smallest a/b {ratios:?}; largest change of N in 10 um {steepest:?}");
    println!("bounded changes the force over the patch at {bounded_changes} places");
    assert!(count > 900);
    assert!(ratios[1] > 0.05 && ratios[3] > 0.05);
    assert!(steepest[3] < 0.05, "{steepest:?}");
}

#[test]
fn analytic_force_grows_with_penetration_across_jumps_and_both_readings_agree() {
    let rail = Shape::new(0.0, -0.2, &[(0.0, -1.0 / 0.3), (2e-3, -1.0 / 0.013)]);
    let wheel = Shape::new(0.46, 0.2, &[(0.0, 1.0 / 0.5)]);
    let shape = touching(&wheel, &rail, 1.09);
    for conformal in [Conformal::Error, Conformal::Bounded] {
        let law = law(Across::Patch, conformal);
        let mut last = 0.0;
        let mut least_exponent = f64::INFINITY;
        for i in 0..400 {
            let delta = 1e-7 * 1.02f64.powi(i);
            let contact = law.contact(&shape, delta).unwrap();
            if last > 0.0 {
                least_exponent = least_exponent.min((contact.force / last).ln() / 1.02f64.ln());
            }
            last = contact.force;
            let (found, under) = law.contact_under(&shape, contact.force).unwrap();
            assert!((found / delta - 1.0).abs() < 1e-9, "{delta} {found}");
            assert!((under.patch.a / contact.patch.a - 1.0).abs() < 1e-8 && under.force == contact.force);
        }
        println!("N grows at least like delta^{least_exponent:.3}");
        assert!(least_exponent > 1.0);
        assert_eq!(law.contact_under(&shape, 0.0).unwrap().1.patch, Patch::default());
    }
}

#[test]
fn analytic_bounds_are_smooth_keep_axes_within_1_to_20_and_leave_the_rest_alone() {
    let (bounded, free) = (law(Across::Point, Conformal::Bounded), law(Across::Point, Conformal::Error));
    let rolling = 1.09;
    let contact = |across: f64| bounded.contact(&ContactShape::of_constant_curvature(rolling, across), 7e-5).unwrap();
    for across in [-1e9, -100.0, -1.0, 0.0, 1e-6, 0.01, 0.02, 1.0, 50.0, 100.0, 200.0, 1e4, 1e12] {
        let patch = contact(across).patch;
        let ratio = patch.a / patch.b;
        assert!(ratio > 0.05 && ratio < 20.0, "{across}: {ratio}");
    }
    for across in [2.0 * rolling / LARGEST_RATIO, 0.1, 1.7, 38.0, 0.49 * rolling * LARGEST_RATIO] {
        assert_eq!(contact(across), free.contact(&ContactShape::of_constant_curvature(rolling, across), 7e-5).unwrap());
    }
    // C1 at the ends of the bends.
    for (at, scale) in [(0.0, 0.01), (2.0 * rolling / LARGEST_RATIO, 0.01), (0.5 * rolling * LARGEST_RATIO, 30.0)] {
        let slope = |side: f64| (contact(at + side * 2e-6 * scale).force - contact(at + side * 1e-6 * scale).force) / (side * 1e-6);
        let (left, right) = (slope(-1.0), slope(1.0));
        assert!((left - right).abs() < 1e-3 * contact(at).force * 0.1, "{at}: {left} {right}");
    }
    assert!(free.contact(&ContactShape::of_constant_curvature(rolling, -0.1), 7e-5).is_err());
}

#[test]
fn hard_hollow_surfaces_are_refused_or_bounded_over_the_patch() {
    // A wheel throat that is narrower than the rail: the bodies never part.
    let wheel = Shape::new(0.46, 0.2, &[(0.0, 1.0 / 0.30)]);
    let rail = Shape::new(0.0, -0.2, &[(0.0, -1.0 / 0.31)]);
    let shape = touching(&wheel, &rail, 0.8);
    assert!(shape.across < 0.0);
    assert_eq!(
        law(Across::Patch, Conformal::Error).contact(&shape, 5e-5).unwrap_err(),
        ConformalContact { rolling: 0.8, across: shape.across }
    );
    let patch = law(Across::Patch, Conformal::Bounded).contact(&shape, 5e-5).unwrap().patch;
    assert!(patch.a / patch.b > 0.05);
}

#[test]
fn analytic_assumed_stiffness_keeps_hertz_ellipse_under_the_force() {
    let source = |text: &str| crate::settings::Source { file: "a.toml".into(), text: text.into(), overridden: vec![], folder: None };
    let read = |text: &str| {
        let source = source(text);
        let document = toml_edit::Document::parse(source.text.clone()).unwrap();
        parse(&crate::settings::Section::root(document.as_table(), &source)).map(|build| build(STEEL))
    };
    let shape = ContactShape::of_constant_curvature(1.09, 1.7);
    let assumed = read("law = \"assumed\"\nstiffness = 9e10").unwrap();
    let contact = assumed.contact(&shape, 7e-5).unwrap();
    assert!((contact.force / (9e10 * 7e-5f64.powf(1.5)) - 1.0).abs() < 1e-14 && contact.stiffness == 9e10);
    let (_, hertz) = law(Across::Point, Conformal::Error).contact_under(&shape, contact.force).unwrap();
    assert_eq!(contact.patch, hertz.patch);
    let (delta, under) = assumed.contact_under(&shape, contact.force).unwrap();
    assert!((delta / 7e-5 - 1.0).abs() < 1e-14 && under.patch == contact.patch);
    for ratio in [0.1, 0.7, 1.0, 3.0] {
        let stated = read(&format!("law = \"assumed\"\nstiffness = 9e10\naxis_ratio = {ratio}")).unwrap();
        // Also where the surfaces are hollow.
        let patch = stated.contact(&ContactShape::of_constant_curvature(1.09, -3.0), 7e-5).unwrap().patch;
        assert!((patch.a / patch.b / ratio - 1.0).abs() < 1e-9, "{ratio} {patch:?}");
    }
    assert!(read("law = \"assumed\"").unwrap_err().to_string().contains("stiffness: is missing"));
    assert!(read("law = \"assumed\"\nstiffness = 1e10\naxis_ratio = 50").unwrap_err().to_string().contains("0.05 to 20"));
    assert!(read("law = \"hertz\"\ncurvature = \"path\"").unwrap_err().to_string().contains("did you mean \"patch\""));
}

#[test]
fn analytic_table_holds_for_axes_to_1_in_20() {
    let table = EllipseTable::shared();
    let reach = LARGEST_RATIO.ln();
    let mut worst: f64 = 0.0;
    for i in 0..=1000 {
        let x = reach * (f64::from(i) / 500.0 - 1.0) * 1.001;
        let (found, exact) = (table.at(x), ellipse_functions_exact(x));
        for (a, b) in [(found.m_a, exact.m_a), (found.m_b, exact.m_b), (found.approach, exact.approach)] {
            worst = worst.max((a / b - 1.0).abs());
        }
    }
    let slenderest = ellipse_functions_exact(reach);
    println!("axes 1:{:.3}, table within {worst:.1e}", slenderest.m_a / slenderest.m_b);
    assert!(worst < 1e-10 && slenderest.m_a / slenderest.m_b < 20.0 && slenderest.m_a / slenderest.m_b > 19.0);
}

#[test]
fn validate_published_hertz_coefficients_in_full() {
    // Complete elliptic integrals by another program (mpmath), see the file's head and docs/sources.md.
    let text = include_str!("../../../tests/data/hertz_m_n.csv");
    let mut rows = 0;
    for line in text.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let row: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
        let cos = row[0].to_radians().cos();
        let found = EllipseTable::shared().at(((1.0 + cos) / (1.0 - cos)).ln());
        for (a, b) in [(found.m_a, row[1]), (found.m_b, row[2]), (found.m_b / found.m_a, row[3]), (found.approach, row[4])] {
            // Six decimals are printed, eight of b/a.
            assert!((a - b).abs() < 6e-7 * b.max(1.0), "theta {}: {a} {b}", row[0]);
        }
        rows += 1;
    }
    assert_eq!(rows, 27);
}
