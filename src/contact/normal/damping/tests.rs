use super::hunt_crossley::Hysteresis;
use super::linear::Linear;
use super::*;
use crate::settings::Source;

/// Reads the damping of a scene's `[contact]`.
fn read(text: &str) -> Result<(f64, Choice), SettingsError> {
    let source = Source { file: "a.toml".into(), text: text.into(), overridden: vec![], folder: None };
    let document = toml_edit::Document::parse(source.text.clone()).unwrap();
    parse(&Section::root(document.as_table(), &source))
}

/// A mass meets a contact with the speed `v`: (speed of rebound / v, damping's work / kinetic energy).
fn impact(law: &dyn DampingLaw, v: f64) -> (f64, f64) {
    let (stiffness, mass): (f64, f64) = (1e11, 800.0);
    // The time of contact is about 3 (m^2 / (K^2 v))^(1/5).
    let step = 3.0 * (mass * mass / (stiffness * stiffness * v)).powf(0.2) / 20_000.0;
    let rates = |delta: f64, rate: f64| {
        let delta = delta.max(0.0);
        let elastic = stiffness * delta * delta.sqrt();
        let force = damped_force(law, elastic, delta, rate);
        (rate, -force / mass, (force - elastic) * rate)
    };
    let (mut delta, mut rate, mut work) = (0.0, v, 0.0);
    loop {
        let k1 = rates(delta, rate);
        let k2 = rates(delta + 0.5 * step * k1.0, rate + 0.5 * step * k1.1);
        let k3 = rates(delta + 0.5 * step * k2.0, rate + 0.5 * step * k2.1);
        let k4 = rates(delta + step * k3.0, rate + step * k3.1);
        let mean = |a: f64, b: f64, c: f64, d: f64| step / 6.0 * (a + 2.0 * b + 2.0 * c + d);
        delta += mean(k1.0, k2.0, k3.0, k4.0);
        rate += mean(k1.1, k2.1, k3.1, k4.1);
        work += mean(k1.2, k2.2, k3.2, k4.2);
        if delta <= 0.0 {
            return (-rate / v, work / (0.5 * mass * v * v));
        }
    }
}

/// e of a mass that meets `N = K delta^n (1 + mu delta')` with d = mu v, from the exact relation.
fn restitution(d: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..100 {
        let e = 0.5 * (low + high);
        let excess = d.ln_1p() - (-e * d).ln_1p() - (1.0 + e) * d;
        if excess < 0.0 { low = e } else { high = e }
    }
    0.5 * (low + high)
}

#[test]
fn analytic_hunt_crossley_rebounds_with_the_stated_restitution() {
    for e in [0.3, 0.5, 0.7, 0.9, 0.99] {
        let law = Hysteresis::new(e, 0.2, hunt_crossley::factor);
        let (found, lost) = impact(&law, 0.2);
        println!("e {e}: rebound {found:.8}, mu v {:.6}, first order {:.6}", law.per_rate * 0.2, 1.5 * (1.0 - e));
        assert!((found - e).abs() < 1e-7, "{found} {e}");
        assert!((lost - (1.0 - e * e)).abs() < 1e-7, "{lost}");
    }
    assert_eq!(Hysteresis::new(1.0, 0.2, hunt_crossley::factor).per_rate, 0.0);
    // Hunt and Crossley's own factor is the limit.
    assert!((hunt_crossley::factor(0.999) / 1.5e-3 - 1.0).abs() < 2e-3);
}

#[test]
fn analytic_lankarani_nikravesh_loses_what_its_factor_says() {
    for e in [0.5, 0.7, 0.9, 0.99] {
        let law = Hysteresis::new(e, 0.2, lankarani_nikravesh::factor);
        let (found, lost) = impact(&law, 0.2);
        let exact = restitution(0.75 * (1.0 - e * e));
        println!("e {e}: rebound {found:.6}, exact for this factor {exact:.6}");
        assert!((found - exact).abs() < 1e-7 && (lost - (1.0 - exact * exact)).abs() < 1e-7);
        // The published claim: right for e near 1.
        assert!(found >= e && found - e < 1.6 * (1.0 - e) * (1.0 - e), "{found}");
        // At half the speed the rebound is a larger share.
        assert!((impact(&law, 0.1).0 - restitution(0.375 * (1.0 - e * e))).abs() < 1e-7);
    }
}

#[test]
fn prop_no_law_pulls_and_all_begin_at_zero() {
    let laws: [Box<dyn DampingLaw>; 5] = [
        (read("damping = 2e9").unwrap().1.build)(2e9),
        Box::new(Hysteresis::new(0.3, 0.1, hunt_crossley::factor)),
        Box::new(Hysteresis::new(0.3, 0.1, lankarani_nikravesh::factor)),
        Box::new(Linear { coefficient: 1e5, full_at: 1e-5 }),
        (read("[damping]\nlaw = \"none\"").unwrap().1.build)(0.0),
    ];
    for law in &laws {
        let force = |delta: f64, rate: f64| damped_force(law.as_ref(), 1e11 * delta.powf(1.5), delta, rate);
        for rate in [-5.0, -0.1, 0.0, 0.1, 5.0] {
            assert_eq!(force(0.0, rate), 0.0, "{law:?}");
            assert!(force(1e-12, rate) < 0.02, "{law:?}");
            assert!((0..200).all(|i| force(1e-6 * i as f64, rate) >= 0.0), "{law:?}");
        }
        let (rebound, lost) = impact(law.as_ref(), 0.1);
        println!("{:?}: rebound {rebound:.4}, lost {lost:.4}", law.describe());
        assert!(rebound <= 1.0 + 1e-9 && (lost - (1.0 - rebound * rebound)).abs() < 1e-5, "{law:?} {rebound} {lost}");
    }
}

#[test]
fn analytic_slopes_match_differences() {
    let laws: [Box<dyn DampingLaw>; 5] = [
        (read("damping = 2e9").unwrap().1.build)(2e9),
        Box::new(Hysteresis::new(0.3, 0.1, hunt_crossley::factor)),
        Box::new(Linear { coefficient: 1e5, full_at: 1e-4 }),
        Box::new(Linear { coefficient: 1e5, full_at: 1e-5 }),
        (read("[damping]\nlaw = \"none\"").unwrap().1.build)(0.0),
    ];
    let at = Approach { elastic: 6e4, penetration: 7e-5, rate: -0.02 };
    for law in &laws {
        let slopes = law.slopes(&at);
        let difference = |ahead: Approach, behind: Approach, step: f64| (law.force(&ahead) - law.force(&behind)) / (2.0 * step);
        let by_elastic = difference(Approach { elastic: 6.1e4, ..at }, Approach { elastic: 5.9e4, ..at }, 1e3);
        let by_penetration = difference(Approach { penetration: 7.001e-5, ..at }, Approach { penetration: 6.999e-5, ..at }, 1e-8);
        let by_rate = difference(Approach { rate: -0.01, ..at }, Approach { rate: -0.03, ..at }, 0.01);
        for (found, exact) in [(by_elastic, slopes.by_elastic), (by_penetration, slopes.by_penetration), (by_rate, slopes.by_rate)] {
            assert!((found - exact).abs() <= 1e-6 * exact.abs() + 1e-9, "{law:?}: {found} {exact}");
        }
    }
}

/// Where the scene gives no length the damper takes no more than the elastic force of the reference contact in parting at the reference speed, and
/// all of it at one depth.
#[test]
fn analytic_linear_damping_without_a_length_lets_go_at_the_reference_speed() {
    for coefficient in [1e3, 1e5, 2e6] {
        let full_at = linear::derived(coefficient);
        let law = Linear { coefficient, full_at };
        let left = |share: f64| {
            let (penetration, rate) = (share * full_at, -linear::REFERENCE_SPEED);
            let elastic = linear::REFERENCE_STIFFNESS * penetration.powf(1.5);
            (elastic + law.force(&Approach { elastic, penetration, rate })) / elastic
        };
        let least = (1..400).map(|i| left(0.005 * f64::from(i))).fold(f64::INFINITY, f64::min);
        println!("C = {coefficient:e} N s/m: full at {:.2} um, least share left {least:.2e}", 1e6 * full_at);
        assert!(left(0.5).abs() < 1e-12 && least > -1e-12, "{least}");
    }
    let (_, law) = read("damping = { law = \"linear\", coefficient = 1e5 }").unwrap();
    assert!((law.build)(0.0).describe().contains("fading in below"), "{}", (law.build)(0.0).describe());
    assert!(read("damping = { law = \"linear\", coefficient = 0 }").is_ok());
}

#[test]
fn analytic_linear_damping_is_smooth_at_its_end() {
    let law = Linear { coefficient: 1e5, full_at: 1e-5 };
    let force = |delta: f64| law.force(&Approach { elastic: 0.0, penetration: delta, rate: 0.2 });
    assert!((force(1e-5) - 2e4).abs() < 1e-9 && (force(3e-5) - 2e4).abs() < 1e-9 && (force(5e-6) - 1e4).abs() < 1e-9);
    let slope = |delta: f64| (force(delta + 1e-10) - force(delta - 1e-10)) / 2e-10;
    assert!(slope(1e-5 - 1e-9).abs() < 1e-3 * slope(5e-6) && slope(1e-9) < 1e-3 * slope(5e-6));
}

#[test]
fn prop_scenes_give_a_number_or_a_table() {
    let (coefficient, law) = read("damping = 2e9").unwrap();
    assert!(coefficient == 2e9 && law.name == "proportional");
    assert_eq!((law.build)(2e9).describe(), "= 2000000000.0 N s/m2");
    let at = Approach { elastic: 1e5, penetration: 7e-5, rate: 0.01 };
    assert_eq!((law.build)(2e9).force(&at), 2e9 * 7e-5 * 0.01);
    let (coefficient, law) = read("damping = { law = \"proportional\", coefficient = 1e9 }").unwrap();
    assert!(coefficient == 1e9 && law.name == "proportional");
    let (_, law) = read("[damping]\nlaw = \"hunt_crossley\"\nrestitution = 0.8\nimpact_speed = \"100 mm/s\"").unwrap();
    assert!((law.build)(0.0).describe().contains("restitution 0.8 at 0.1 m/s"));
    let wrong = |text: &str| read(text).err().unwrap().to_string();
    assert_eq!(wrong("damping = -1"), "a.toml:1: damping: found -1.0, expected 0 or more");
    assert!(wrong("[damping]\nlaw = \"hunt\"").starts_with("a.toml:2: damping.law: found \"hunt\""));
    assert!(
        wrong("damping = { law = \"lankarani_nikravesh\", restitution = 1.5, impact_speed = 1 }")
            .contains("damping.restitution: found 1.5")
    );
    assert!(wrong("damping = { law = \"none\", coefficient = 1 }").contains("unknown key"));
    // What nobody knows: a stated restitution, at a stated speed.
    let (_, law) = read("damping = { restitution = 0.7 }").unwrap();
    assert!(law.name == "hunt_crossley" && (law.build)(0.0).describe().contains("restitution 0.7 at 0.1 m/s"));
    let (coefficient, law) = read("friction = 1").unwrap();
    assert!(coefficient == 0.0 && (law.build)(0.0).describe().contains("restitution 0.8 at 0.1 m/s"));
    assert!(wrong("damping = { impact_speed = 0.2 }").contains("damping.law: is missing"));
}

/// Largest and least `(N / N_elastic)^(1/3) - 1` while N is above half of its maximum: by how much the semi-axes of an ellipse for the whole N differ from those
/// for the penetration, which are used.
fn semi_axes(law: &dyn DampingLaw, v: f64) -> [f64; 2] {
    let (stiffness, mass): (f64, f64) = (1e11, 800.0);
    let step = 3.0 * (mass * mass / (stiffness * stiffness * v)).powf(0.2) / 20_000.0;
    let (mut delta, mut rate, mut course) = (0.0, v, Vec::new());
    // Symplectic steps: two digits are wanted.
    while course.len() < 2 || delta > 0.0 {
        delta += step * rate;
        let elastic = stiffness * delta.max(0.0).powf(1.5);
        let force = damped_force(law, elastic, delta.max(0.0), rate);
        course.push((force, (force / elastic).cbrt() - 1.0));
        rate -= step * force / mass;
    }
    let most = course.iter().map(|(force, _)| *force).fold(0.0, f64::max);
    let loaded = || course.iter().filter(|(force, _)| *force > 0.5 * most).map(|(_, change)| *change);
    [loaded().fold(f64::MIN, f64::max), loaded().fold(f64::MAX, f64::min)]
}

/// The numbers of docs/model.md.
#[test]
fn regress_damping_that_is_not_counted_in_the_patch() {
    let hysteresis = |e, speed, factor| Box::new(Hysteresis::new(e, speed, factor)) as Box<dyn DampingLaw>;
    let number = |coefficient| (read(&format!("damping = {coefficient:?}")).unwrap().1.build)(coefficient);
    let crossley = || hysteresis(0.5, 1.0, hunt_crossley::factor);
    let cases = [
        (number(2e9), 0.01, [0.018, -0.017]),
        (number(2e9), 0.1, [0.074, -0.057]),
        (number(2e9), 1.0, [0.315, -0.115]),
        (crossley(), 0.1, [0.039, -0.036]),
        (crossley(), 1.0, [0.322, -0.104]),
        (crossley(), 3.0, [0.710, 0.061]),
        (hysteresis(0.5, 1.0, lankarani_nikravesh::factor), 1.0, [0.145, -0.100]),
        (hysteresis(0.9, 1.0, hunt_crossley::factor), 1.0, [0.045, -0.041]),
        (Box::new(Linear { coefficient: 1e5, full_at: 1e-4 }) as Box<dyn DampingLaw>, 0.1, [0.038, -0.035]),
    ];
    for (law, v, expected) in cases {
        let found = semi_axes(law.as_ref(), v);
        println!("{} at {v} m/s: {:.1} %, {:.1} %", law.describe(), 100.0 * found[0], 100.0 * found[1]);
        assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 2e-3), "{} at {v}: {found:?} {expected:?}", law.describe());
    }
}
