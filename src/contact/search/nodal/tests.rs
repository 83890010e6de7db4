use super::super::test_surfaces::locate;
use super::*;
use crate::geometry::Side;
use crate::geometry::profile::{Profile, ProfilePoint};
use crate::geometry::track::rail_surface::rail_point;
use crate::geometry::track::{Deviation, DeviationShape, Direction};
use crate::math::rotation::AxleFrame;
use crate::math::spline::CubicSpline;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use std::cell::Cell;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

const RADIUS: f64 = 0.457;
const HALF_SPACING: f64 = 0.716;

/// A profile from its function and range.
struct Shape<F>(F, (f64, f64));
impl<F> std::fmt::Debug for Shape<F> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "shape {:?}", self.1)
    }
}
impl<F: Fn(f64) -> [f64; 3] + Send + Sync> Profile for Shape<F> {
    fn at(&self, x: f64) -> ProfilePoint {
        let [value, d1, d2] = (self.0)(x);
        ProfilePoint { value, d1, d2, d3: 0.0 }
    }
    fn range(&self) -> (f64, f64) {
        self.1
    }
    fn describe(&self) -> String {
        format!("{self:?}")
    }
}

fn cone_over(slope: f64, range: (f64, f64)) -> Arc<dyn Profile> {
    Arc::new(Shape(move |u| [RADIUS - slope * u, -slope, 0.0], range))
}

fn cone(slope: f64) -> Arc<dyn Profile> {
    cone_over(slope, (-0.07, 0.07))
}

fn hollow() -> Arc<dyn Profile> {
    let k = TAU / 0.016;
    let wave = move |u: f64| {
        let (sin, cos) = (k * u).sin_cos();
        [RADIUS - 0.025 * u - 2e-4 * cos, -0.025 + 2e-4 * k * sin, 2e-4 * k * k * cos]
    };
    Arc::new(Shape(wave, (-0.06, 0.06)))
}

/// Tread of slope 1/40 that runs into a flange of slope 3 with a rounded tip, as points through a spline.
fn flanged() -> Arc<dyn Profile> {
    let smooth = |x: f64| {
        let x = x.clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    };
    let slope = |u: f64| -0.025 - 3.0 * smooth((-0.030 - u) / 0.012) + 6.0 * smooth((-0.046 - u) / 0.008);
    let fine = 5e-5;
    // From the tread circle inward and outward; every tenth point carries the spline.
    let side = |sign: f64, steps: usize| {
        let mut radius = RADIUS;
        let mut points = Vec::new();
        for k in 0..=steps {
            let u = sign * fine * k as f64;
            if k % 10 == 0 {
                points.push((u, radius));
            }
            radius += sign * fine * slope(u + 0.5 * sign * fine);
        }
        points
    };
    let mut points = side(-1.0, 1200);
    points.reverse();
    points.pop();
    points.extend(side(1.0, 1200));
    let spline = CubicSpline::natural(&points).unwrap();
    let range = spline.range();
    let at = move |u| {
        let [value, d1, d2, _] = spline.at(u);
        [value, d1, d2]
    };
    Arc::new(Shape(at, range))
}

fn arc_over(radius: f64, range: (f64, f64)) -> Arc<dyn Profile> {
    let at = move |x: f64| {
        let drop = (radius * radius - x * x).sqrt();
        [-x * x / (drop + radius), -x / drop, -radius * radius / drop.powi(3)]
    };
    Arc::new(Shape(at, range))
}

fn arc(radius: f64) -> Arc<dyn Profile> {
    arc_over(radius, (-0.036, 0.036))
}

/// Crown of 300 mm between corners of 13 mm that end with a vertical tangent 36 mm from the middle.
fn head() -> Arc<dyn Profile> {
    let (crown, corner, half_width) = (0.3f64, 0.013, 0.036);
    let centre = half_width - corner;
    let height = ((crown - corner).powi(2) - centre * centre).sqrt() - crown;
    let at = move |x: f64| {
        let begin = centre * crown / (crown - corner);
        let (radius, x, base) = if x.abs() < begin { (crown, x, -crown) } else { (corner, x - centre.copysign(x), height) };
        let root = (radius * radius - x * x).sqrt();
        [base + root, -x / root, -radius * radius / root.powi(3)]
    };
    Arc::new(Shape(at, (-half_width, half_width)))
}

/// `amplitude / 2 (1 - cos(2 pi s / 10 m))`.
#[derive(Debug)]
struct Cosine(f64);
impl DeviationShape for Cosine {
    fn at(&self, s: f64) -> [f64; 4] {
        let k = TAU / 10.0;
        let (sin, cos) = (k * s).sin_cos();
        let half = 0.5 * self.0;
        [half * (1.0 - cos), half * k * sin, half * k * k * cos, -half * k * k * k * sin]
    }
    fn waves(&self) -> Vec<crate::geometry::track::waves::Stretch> {
        Vec::new()
    }

    fn breaks(&self) -> Vec<f64> {
        vec![]
    }
    fn describe(&self) -> String {
        "cosine".into()
    }
}

fn rail(side: Side, head: Arc<dyn Profile>, inclination: f64, lateral: f64, vertical: f64) -> Rail {
    let deviation = |direction, amplitude| Deviation { side, direction, shape: Arc::new(Cosine(amplitude)) };
    let deviations = [deviation(Direction::Lateral, lateral), deviation(Direction::Vertical, vertical)];
    Rail::new(side, head, HALF_SPACING, inclination, &deviations)
}

fn wheel(side: Side, profile: Arc<dyn Profile>) -> Wheel {
    Wheel { side, profile, half_spacing: HALF_SPACING }
}

/// s of a point: root of `(r - R) . R' = 0`.
fn project(rail: &Rail, point: &Vector3<f64>) -> f64 {
    let mut s = point.x;
    for _ in 0..20 {
        let section = rail.section(s);
        let r = point - section.origin;
        s += r.dot(&section.d1) / (section.d1.norm_squared() - r.dot(&section.d2));
    }
    s
}

struct Stand {
    wheel: Wheel,
    rail: Rail,
    search: NodalSearch,
}

impl Stand {
    fn new(wheel: Wheel, rail: Rail, spacing: f64) -> Self {
        let search = NodalSearch::new(&wheel, &rail, spacing).unwrap();
        Stand { wheel, rail, search }
    }

    fn search(&self, centre: &Vector3<f64>, axes: &Matrix3<f64>) -> NodalContacts {
        let arc = project(&self.rail, &self.search.centre_point(centre, axes));
        self.search.search(centre, axes, (centre.x, arc), &self.rail.section(arc), MOST)
    }

    /// The one contact, or the closest pair.
    fn first(&self, centre: &Vector3<f64>, axes: &Matrix3<f64>) -> ContactLocation {
        self.search(centre, axes).contacts[0].unwrap()
    }

    fn exact(&self, centre: &Vector3<f64>, axes: &Matrix3<f64>, start: &SurfaceParameters) -> ContactLocation {
        locate(&self.wheel, &self.rail, centre, axes, centre.x, start).unwrap()
    }

    /// Height of the centre at which the deepest pair penetrates by about `penetration` [m].
    fn settle(&self, mut centre: Vector3<f64>, axes: &Matrix3<f64>, penetration: f64) -> Vector3<f64> {
        for _ in 0..4 {
            let deepest = self.search(&centre, axes).contacts.iter().flatten().map(|c| c.penetration).fold(-1.0, f64::max);
            centre.z += deepest - penetration;
        }
        centre
    }
}

fn tread(side: Side, spacing: f64, lateral: f64, vertical: f64) -> Stand {
    Stand::new(wheel(side, cone(0.025)), rail(side, arc(0.3), 0.025f64.atan(), lateral, vertical), spacing)
}

// Eq. 29.

/// Q as it travels: straight on at 40 m/s with a lateral and a vertical motion.
fn travelling(t: f64) -> (Vector3<f64>, Vector3<f64>) {
    let (y, z) = (9.0 * t, 14.0 * t);
    (Vector3::new(40.0 * t, HALF_SPACING + 0.004 * y.sin(), RADIUS + 0.002 * z.sin()), Vector3::new(40.0, 0.036 * y.cos(), 0.028 * z.cos()))
}

/// Largest |s - projection| [m] along one wave of the deviation when `rate` is integrated by RK4 in `steps` steps.
fn slip(rail: &Rail, steps: usize, rate: impl Fn(&RailSection, &Vector3<f64>, &Vector3<f64>) -> f64) -> f64 {
    let h = 0.25 / steps as f64;
    let at = |t: f64, s: f64| {
        let (point, velocity) = travelling(t);
        rate(&rail.section(s), &point, &velocity)
    };
    let mut s = project(rail, &travelling(0.0).0);
    let mut worst: f64 = 0.0;
    for step in 0..steps {
        let t = h * step as f64;
        let k1 = at(t, s);
        let k2 = at(t + 0.5 * h, s + 0.5 * h * k1);
        let k3 = at(t + 0.5 * h, s + 0.5 * h * k2);
        let k4 = at(t + h, s + h * k3);
        s += h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
        worst = worst.max((s - project(rail, &travelling(t + h).0)).abs());
    }
    worst
}

#[test]
fn order_arc_rate_keeps_the_projection_to_integration_accuracy() {
    let rail = rail(Side::Left, arc(0.3), 0.025, 0.01, 0.01);
    let errors: Vec<f64> = [10, 20, 40].map(|steps| slip(&rail, steps, arc_rate)).to_vec();
    let order = (errors[0] / errors[2]).log2() / 2.0;
    println!("|s - projection|: {errors:?} m, order {order:.2}");
    assert!((order - 4.0).abs() < 0.4 && slip(&rail, 500, arc_rate) < 1e-12);
}

#[test]
fn analytic_printed_arc_rate_slips_by_millimetres_over_a_bump() {
    // Eq. 29 with the unit tangent, s per centre-line distance: v . R' / |R'|^2.
    let printed = |section: &RailSection, _: &Vector3<f64>, v: &Vector3<f64>| v.dot(&section.d1) / section.d1.norm_squared();
    // The unit tangent taken for R' itself.
    let unit = |section: &RailSection, _: &Vector3<f64>, v: &Vector3<f64>| v.dot(&section.d1) / section.d1.norm();
    let bare = |section: &RailSection, _: &Vector3<f64>, v: &Vector3<f64>| v.dot(&section.d1);
    let of = |lateral, vertical| {
        let rail = rail(Side::Left, arc(0.3), 0.025, lateral, vertical);
        [slip(&rail, 500, printed), slip(&rail, 500, unit), slip(&rail, 500, bare), slip(&rail, 500, arc_rate)]
    };
    let (lateral, vertical) = (of(0.01, 0.0), of(0.0, 0.01));
    println!("10 mm over 10 m, slip of v.R'/|R'|^2, v.R'/|R'|, v.R', corrected [m]");
    println!("lateral  {lateral:?}\nvertical {vertical:?}");
    // Vertical: Q stands the radius R over the curve, so s differs by R times the slope, at most R pi A / L.
    let expected = RADIUS * PI * 0.01 / 10.0;
    assert!((vertical[0] / expected - 1.0).abs() < 0.05, "{} {expected}", vertical[0]);
    assert!(vertical[3] < 1e-12 && lateral[3] < 1e-12);
    // Lateral: offsets of 4 to 10 mm only, hence some tens of micrometres.
    assert!(lateral[0] > 5e-6 && lateral[0] < 1e-4);
}

// Wheel angle and the node in the section.

#[test]
fn prop_wheel_angle_turns_the_normal_into_the_section() {
    for side in Side::BOTH {
        let stand = Stand::new(wheel(side, flanged()), rail(side, head(), 0.025, 0.01, 0.01), 1e-3);
        for (yaw, roll) in [(0.03, 0.01), (-0.02, 0.004), (0.1, -0.02), (0.0, 0.0)] {
            let axes = AxleFrame::new(yaw, roll).axes;
            let centre = Vector3::new(2.5, 0.003, 0.46);
            let arc = project(&stand.rail, &stand.search.centre_point(&centre, &axes));
            let section = stand.rail.section(arc);
            let plane = stand.search.section(&centre, &axes, &section);
            for index in 0..stand.search.wheel.count() {
                let u = stand.search.wheel.coordinate(index);
                let angle = plane.angle + (plane.turn * stand.search.wheel.point(index).d1).asin();
                let (w, profile) = stand.wheel.point(&centre, &axes, u, angle);
                let normal = w.t1.cross(&w.t2).normalize();
                assert!(normal.dot(&section.d1).abs() < 1e-13, "{side:?} {yaw} {u}");
                // The point itself, brought into the section along the tangent.
                let r = w.position - section.origin;
                let r = r - section.d1 * (r.x / section.d1.x);
                let (eta, height) = plane.place(u, profile.value, profile.d1).unwrap();
                assert!((r - stand.rail.outward * eta - stand.rail.up * height).norm() < 1e-14, "{side:?} {yaw} {u}");
            }
        }
    }
}

#[test]
fn analytic_yawed_wheel_keeps_its_lead() {
    // R slope yaw to first order: ahead on the left for yaw > 0, behind on the right.
    for side in Side::BOTH {
        for yaw in [1e-3, -5e-3, 0.02] {
            let stand = tread(side, 1e-4, 0.0, 0.0);
            let axes = AxleFrame::new(yaw, 0.0).axes;
            // Q moves along the track by the yaw; the lead counts from the wheelset's centre.
            let centre = stand.settle(Vector3::new(3.0, 0.0, RADIUS), &axes, 1e-4);
            let (found, exact) = (stand.first(&centre, &axes), stand.exact(&centre, &axes, &SurfaceParameters::default()));
            let lead = RADIUS * found.parameters.angle;
            let expected = side.sign() * RADIUS * 0.025 * yaw;
            assert!((lead - expected).abs() < 1e-3 * expected.abs(), "{side:?} {lead} {expected}");
            let (p, e) = (found.parameters, exact.parameters);
            println!("{side:?} yaw {yaw}: angle {:.3e} off {:.1e}, lead off {:.1e} m", p.angle, p.angle - e.angle, p.lead - e.lead);
            assert!((p.angle - e.angle).abs() < 1e-9);
            // What is left is yaw times the distance to the node.
            assert!((p.lead - e.lead).abs() < 1.01 * yaw.abs() * (p.wheel - e.wheel).abs() + 1e-8);
        }
    }
}

// All pairs.

/// Batches of all wheel nodes from the surfaces in space, without any of the search's shortcuts.
fn all_pairs(stand: &Stand, centre: &Vector3<f64>, axes: &Matrix3<f64>) -> (Vec<(f64, f64, f64)>, Option<f64>) {
    let arc = project(&stand.rail, &stand.search.centre_point(centre, axes));
    let section = stand.rail.section(arc);
    let (wheel, rail) = (&stand.search.wheel, &stand.search.rail);
    let nodes: Vec<f64> = (0..rail.count()).map(|j| rail.coordinate(j)).collect();
    let (mut batches, mut open, mut closest) = (Vec::new(), None::<(f64, f64, f64)>, None::<f64>);
    for i in 0..wheel.count() {
        let u = wheel.coordinate(i);
        // Secant steps on normal . t = 0.
        let tilt = |angle: f64| {
            let w = stand.wheel.point(centre, axes, u, angle).0;
            w.t1.cross(&w.t2).dot(&section.d1) / RADIUS
        };
        let (mut a, mut b) = (0.0, 1e-3);
        for _ in 0..30 {
            let (fa, fb) = (tilt(a), tilt(b));
            if fa == fb {
                break;
            }
            (a, b) = (b, b - fb * (b - a) / (fb - fa));
        }
        let r = stand.wheel.point(centre, axes, u, b).0.position - section.origin;
        let r = r - section.d1 * (r.x / section.d1.x);
        let across = r.dot(&stand.rail.outward);
        let nearest = |at: f64| (0..nodes.len()).min_by(|&j, &k| (nodes[j] - at).abs().total_cmp(&(nodes[k] - at).abs())).unwrap();
        let against = |j: usize| {
            let (p, f) = rail_point(&stand.rail, arc, nodes[j]);
            let normal = (p.t1.cross(&p.t2) * stand.rail.side.sign()).normalize();
            (-(r - (p.position - section.origin)).dot(&normal), r.dot(&stand.rail.up) - f.value - f.d1 * (across - nodes[j]), f.d1)
        };
        let mut j = nearest(across);
        let mut penetration = -1.0;
        if (nodes[j] - across).abs() <= 0.5 * rail.spacing {
            let touching = against(j).1 < 0.0;
            for _ in 0..if touching { PROJECTIONS } else { 0 } {
                let (_, gap, slope) = against(j);
                j = nearest(across + slope * gap / (1.0 + slope * slope));
            }
            penetration = against(j).0;
            closest = Some(closest.map_or(penetration, |c| c.max(penetration)));
        }
        if penetration > 0.0 {
            if open.is_none_or(|o| penetration > o.0) {
                open = Some((penetration, u, nodes[j]));
            }
        } else if let Some(batch) = open.take() {
            batches.push(batch);
        }
    }
    batches.extend(open);
    batches.sort_by(|a, b| b.1.total_cmp(&a.1));
    (batches, closest)
}

#[test]
fn prop_search_finds_what_all_pairs_give() {
    let wheels: Vec<Arc<dyn Profile>> = vec![cone(0.025), hollow(), flanged(), cone(-0.2)];
    let rails: Vec<Arc<dyn Profile>> = vec![arc(0.3), head(), arc(0.08), arc_over(0.02, (-0.0199, 0.02))];
    let counts = [const { Cell::new(0u32) }; 5];
    let flange = Cell::new(0u32);
    let nodes = Cell::new((0usize, 0usize));
    let poses = (
        (
            prop_oneof![Just(0usize), Just(1), Just(1), Just(2), Just(2), Just(3)],
            0usize..4,
            any::<bool>(),
            prop_oneof![Just(2e-4), Just(5e-4), Just(1.1e-3)],
        ),
        (prop_oneof![-0.012..0.012f64, 0.003..0.009f64], -0.04..0.04f64, -0.02..0.02f64, 0.0..10.0f64),
        (-5e-4..8e-4f64, 0.0..0.06f64, -0.01..0.01f64, -0.01..0.01f64),
    );
    let mut config = ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() };
    config.max_shrink_iters = 200;
    let mut runner = TestRunner::new_with_rng(config, proptest::test_runner::TestRng::deterministic_rng(Default::default()));
    runner
        .run(&poses, |((w, r, left, spacing), (y, yaw, roll, x), (penetration, inclination, lateral, vertical))| {
            let side = if left { Side::Left } else { Side::Right };
            let stand = Stand::new(wheel(side, wheels[w].clone()), rail(side, rails[r].clone(), inclination, lateral, vertical), spacing);
            let axes = AxleFrame::new(yaw, roll).axes;
            let centre = stand.settle(Vector3::new(x, side.sign() * y, RADIUS), &axes, penetration);
            let search = &stand.search;
            let arc = project(&stand.rail, &search.centre_point(&centre, &axes));
            let plane = search.section(&centre, &axes, &stand.rail.section(arc));
            let walk = search.walked(&plane);
            let found = stand.search(&centre, &axes);
            // Each hump of nodes has a contact near it that is no less deep.
            for (penetration, (node, _)) in walk.humps.iter() {
                let aside = |contact: &&ContactLocation| (contact.parameters.wheel - search.wheel.coordinate(node)).abs();
                let nearest = found.contacts.iter().flatten().min_by(|a, b| aside(a).total_cmp(&aside(b))).unwrap();
                let lost = penetration - nearest.penetration;
                prop_assert!(lost < 100.0 * spacing * spacing, "{lost:e} of {penetration:e} on {}", nearest.rail_profile.d1);
            }
            // The deepest hump of each batch.
            let mut pairs: Vec<NodePair> = Vec::new();
            for (k, (penetration, (wheel, rail))) in walk.humps.iter().enumerate() {
                let pair = NodePair { wheel, rail, penetration };
                match pairs.last_mut() {
                    Some(last) if walk.humps.saddles()[k - 1] > 0.0 => {
                        if pair.penetration > last.penetration {
                            *last = pair;
                        }
                    }
                    _ => pairs.push(pair),
                }
            }
            pairs.reverse();
            let count = pairs.len();
            let (batches, closest) = all_pairs(&stand, &centre, &axes);
            prop_assert_eq!(count, batches.len());
            counts[count].set(counts[count].get() + 1);
            for (pair, batch) in pairs.iter().zip(&batches) {
                prop_assert!((pair.penetration - batch.0).abs() < 1e-12, "{} {}", pair.penetration, batch.0);
                let place = (search.wheel.coordinate(pair.wheel), search.rail.coordinate(pair.rail));
                prop_assert_eq!(place, (batch.1, batch.2));
                flange.set(flange.get() + u32::from(search.rail.point(pair.rail).d1.abs() > 0.8));
            }
            match (count, walk.closest) {
                (0, Some(pair)) => prop_assert!((pair.penetration - closest.unwrap()).abs() < 1e-12),
                (0, None) => prop_assert!(closest.is_none()),
                _ => nodes.set((nodes.get().0 + walk.evaluated, nodes.get().1 + search.wheel.count())),
            }
            Ok(())
        })
        .unwrap();
    let counts = counts.map(|c| c.get());
    let (evaluated, all) = nodes.get();
    println!("poses with 0 to 4 contacts: {counts:?}; contacts on a slope above 0.8: {}", flange.get());
    println!("evaluated {evaluated} of {all} wheel nodes");
    assert!(counts[..3].iter().all(|&count| count > 30) && flange.get() > 30 && evaluated < all / 2);
}

#[test]
fn prop_gap_never_falls_faster_than_its_bound() {
    // The claim itself, on every stretch: sharper than the search's outcome, which forgives a bound that is a little low.
    let shapes: [(Arc<dyn Profile>, Arc<dyn Profile>); 5] = [
        (cone(0.025), arc(0.3)),
        (cone(-0.2), arc_over(0.02, (-0.0199, 0.02))),
        (hollow(), head()),
        (flanged(), head()),
        (flanged(), Arc::new(Shape(|x| [-0.1 * x, -0.1, 0.0], (-0.036, 0.036)))),
    ];
    let (mut tightest, mut checked) = (f64::INFINITY, 0);
    for (number, (w, r)) in shapes.into_iter().enumerate() {
        for pose in 0..12 {
            let phase = f64::from(pose);
            let side = if pose % 2 == 0 { Side::Left } else { Side::Right };
            let spacing = [1e-4, 5e-4, 1e-3][pose as usize % 3];
            let stand = Stand::new(wheel(side, w.clone()), rail(side, r.clone(), 0.03, 0.01, -0.01), spacing);
            let axes = AxleFrame::new(0.05 * (phase * 1.1).sin(), 0.02 * (phase * 0.7).cos()).axes;
            let centre = Vector3::new(phase, 0.01 * (1.9 * phase).sin(), RADIUS);
            let search = &stand.search;
            let arc = project(&stand.rail, &search.centre_point(&centre, &axes));
            let plane = search.section(&centre, &axes, &stand.rail.section(arc));
            let nodes: Vec<Option<Node>> = (0..search.wheel.count()).map(|i| search.node(&plane, i)).collect();
            for (i, node) in nodes.iter().enumerate() {
                let Some((node, gap)) = node.and_then(|n| n.rail.map(|rail| (n, search.gap(rail, &n)))) else { continue };
                for level in 0..=search.wheel.top() {
                    let Some(ahead) = search.ahead(&plane, i, node.place, level) else { continue };
                    let end = (i + NodeTable::stretch(level)).min(nodes.len() - 1);
                    for (k, other) in nodes[i..=end].iter().enumerate().skip(1) {
                        let Some(other) = other else { panic!("no point {number} {pose} {i}") };
                        let (k, moved) = (k as f64, other.place - node.place);
                        assert!(moved >= k * ahead.drift.0 - 1e-9 && moved <= k * ahead.drift.1 + 1e-9, "{number} {pose} {i}");
                        let Some(rail) = other.rail else { continue };
                        let slack = search.gap(rail, other) - (gap - k * ahead.fall - 2.0 * ahead.rail.misfit);
                        assert!(slack >= -1e-13, "{number} {pose} {i} {level} {k}: {slack}");
                        assert!(search.rail.point(rail).d1.abs() <= ahead.rail.steepest);
                        if level == 0 && ahead.fall > 1e-2 * spacing {
                            tightest = tightest.min(slack / (k * ahead.fall));
                            checked += 1;
                        }
                    }
                }
            }
        }
    }
    println!("{checked} gaps on short stretches; the tightest bound leaves {tightest:.1e} of the fall");
    assert!(checked > 10_000 && tightest < 1e-3);
}

#[test]
fn regress_tread_stays_in_place_0_when_the_flange_touches() {
    for side in Side::BOTH {
        let stand = Stand::new(wheel(side, flanged()), rail(side, head(), 0.025, 0.0, 0.0), 1e-4);
        let axes = AxleFrame::new(0.0, 0.0).axes;
        let (mut deeper_flange, mut deeper_tread, mut single) = (0, 0, 0);
        // Outward: the flange comes to the gauge corner and goes deeper than the tread, which rests at its height.
        for step in 0..400 {
            let y = side.sign() * 2e-5 * step as f64;
            let found = stand.search(&Vector3::new(0.0, y, RADIUS - 1e-4), &axes);
            let first = found.contacts[0].unwrap();
            assert!(first.parameters.wheel > -0.028, "{side:?} {y} {}", first.parameters.wheel);
            match found.contacts[1] {
                Some(second) if second.penetration > first.penetration => deeper_flange += 1,
                Some(second) => {
                    assert!(second.parameters.wheel < -0.03);
                    deeper_tread += 1;
                }
                None => single += 1,
            }
            if deeper_flange == 20 {
                break;
            }
        }
        println!("{side:?}: tread alone {single}, with a flange contact that is less deep {deeper_tread}, deeper {deeper_flange}");
        assert!(deeper_flange > 0 && deeper_tread > 0 && single > 0);
    }
}

// Accuracy.

#[test]
fn equiv_contact_is_that_of_the_algebraic_search() {
    for (name, lateral, vertical) in [("straight", 0.0, 0.0), ("deviated", 0.01, 0.01)] {
        for side in Side::BOTH {
            for spacing in [4e-4, 2e-4, 1e-4, 5e-5] {
                let stand = tread(side, spacing, lateral, vertical);
                let mut worst = [0.0f64; 4];
                for step in 0..60 {
                    let phase = step as f64;
                    let axes = AxleFrame::new(0.01 * (0.7 * phase).sin(), 0.002 * (1.3 * phase).cos()).axes;
                    let centre = Vector3::new(0.17 * phase, -0.003 + 1.017e-4 * phase, RADIUS);
                    let centre = stand.settle(centre, &axes, 1e-4);
                    let (found, exact) = (stand.first(&centre, &axes), stand.exact(&centre, &axes, &SurfaceParameters::default()));
                    let (p, e) = (found.parameters, exact.parameters);
                    let errors = [p.wheel - e.wheel, p.rail - e.rail, p.lead - e.lead, found.penetration - exact.penetration];
                    for (worst, error) in worst.iter_mut().zip(errors) {
                        *worst = worst.max(error.abs());
                    }
                }
                let [u, eta, lead, penetration] = worst;
                println!("{name} {side:?} {spacing:.0e}: u {u:.2e}, eta {eta:.2e}, lead {lead:.2e}, penetration {penetration:.2e} m");
                // What replacing a deviated rail by its tangent costs is left, at any spacing.
                assert!(u < 4e-9 && eta < 4e-7 && lead < 4e-7 && penetration < 6e-11, "{worst:?}");
            }
        }
    }
}

#[test]
fn order_flange_contact_converges() {
    // Flank against gauge corner, where half a spacing in eta is longer along the slope.
    for spacing in [4e-4, 2e-4, 1e-4, 5e-5, 1e-5] {
        let stand = Stand::new(wheel(Side::Left, flanged()), rail(Side::Left, head(), 0.025, 0.0, 0.0), spacing);
        let mut worst = [0.0f64; 4];
        for step in 0..40 {
            let axes = AxleFrame::new(0.01, 0.0).axes;
            let centre = Vector3::new(0.0, 0.006 + 3.7e-6 * f64::from(step), RADIUS + 2e-4);
            let mut centre = centre;
            // Pushed outward until the flange is 0.1 mm deep, clear of the tread.
            for _ in 0..30 {
                let found = stand.search(&centre, &axes).contacts;
                let flange = found.iter().flatten().find(|c| c.parameters.wheel < -0.03);
                centre.y += flange.map_or(5e-5, |c| 1e-4 - c.penetration);
            }
            let found = *stand.search(&centre, &axes).contacts.iter().flatten().find(|c| c.parameters.wheel < -0.03).unwrap();
            let exact = stand.exact(&centre, &axes, &found.parameters);
            let slope = found.rail_profile.d1;
            let (p, e) = (found.parameters, exact.parameters);
            worst = [
                worst[0].max((p.wheel - e.wheel).abs()),
                worst[1].max((p.rail - e.rail).abs()),
                worst[2].max(slope),
                worst[3].max((found.penetration - exact.penetration).abs()),
            ];
        }
        let [u, eta, slope, penetration] = worst;
        println!("{spacing:.0e}: slope {slope:.2}, u {u:.2e}, eta {eta:.2e}, penetration {penetration:.2e} m");
        assert!(slope > 1.0 && u < 2.0 * spacing + 1e-4 && eta < 2.0 * spacing + 1e-4);
        assert!(penetration < 2.0 * 77.0 * (1.0 + slope * slope) * spacing * spacing / 8.0 + 1e-8);
    }
}

#[test]
fn prop_mirrored_pose_gives_mirrored_contacts() {
    for (w, r) in [(cone(0.025), arc(0.3)), (hollow(), arc(0.3)), (flanged(), head())] {
        let find = |side: Side, sign: f64| {
            let stand = Stand::new(wheel(side, w.clone()), rail(side, r.clone(), 0.025, sign * 0.01, 0.004), 1e-4);
            let axes = AxleFrame::new(sign * 0.01, sign * 0.003).axes;
            let centre = stand.settle(Vector3::new(1.0, sign * 0.004, RADIUS), &axes, 2e-4);
            stand.search(&centre, &axes)
        };
        let (left, right) = (find(Side::Left, 1.0), find(Side::Right, -1.0));
        assert!(left.count == right.count && left.count > 0 && left.evaluated == right.evaluated);
        for (a, b) in left.contacts.iter().flatten().zip(right.contacts.iter().flatten()) {
            assert_eq!((a.penetration, a.parameters.wheel, a.parameters.rail), (b.penetration, b.parameters.wheel, b.parameters.rail));
            assert!((a.wheel_point.y + b.wheel_point.y).abs() < 1e-15 && (a.normal.y + b.normal.y).abs() < 1e-15);
            assert!((a.normal.norm() - 1.0).abs() < 1e-15 && a.normal.dot(&a.forward).abs() < 1e-15);
        }
    }
}

#[test]
fn prop_penetration_is_continuous_while_the_deepest_node_changes() {
    // The flange moves outward and up along its flank, so that the contact wanders around the gauge corner.
    let (still, along) = (Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, 1.0, 2.33));
    let flange = |spacing| ("flange", flanged(), head(), spacing, 4.1e-3, along, 2e-3);
    let mut jumps = Vec::new();
    for (name, w, r, spacing, from, way, length) in
        [("cone on arc", cone(0.025), arc(0.3), 1e-4, -4e-3, still, 8e-3), flange(2e-4), flange(1e-4), flange(5e-5)]
    {
        let stand = Stand::new(wheel(Side::Left, w), rail(Side::Left, r, 0.025f64.atan(), 0.0, 0.0), spacing);
        let axes = AxleFrame::new(0.002, 0.0).axes;
        // The innermost contact: the only one, or that of the flange.
        let at = |q: f64| {
            let found = stand.search(&(Vector3::new(0.0, from, RADIUS - 1e-4) + way * q), &axes);
            found.contacts.into_iter().flatten().last().unwrap()
        };
        let pair = |c: &ContactLocation| (c.parameters.wheel, c.parameters.rail);
        let (mut jump, mut radius_jump, mut changes) = (0.0f64, 0.0f64, 0);
        let (mut depth, mut steepness) = ((1.0f64, 0.0f64), (9.0f64, 0.0f64));
        // Coarse over the sweep; where the pair changes, again in fine steps.
        let (coarse, fine) = (2e-6, 1e-8);
        let mut q = 0.0;
        let mut before = at(q);
        while q < length {
            let after = at(q + coarse);
            if pair(&after) != pair(&before) {
                changes += 1;
                let mut a = before;
                for k in 1..=200 {
                    let b = at(q + fine * f64::from(k));
                    // The motion itself changes the depth by its part along the normal.
                    let moved = fine * way.dot(&a.normal).abs().max(way.dot(&b.normal).abs());
                    jump = jump.max((b.penetration - a.penetration).abs() - moved);
                    radius_jump = radius_jump.max((b.wheel_profile.value - a.wheel_profile.value).abs());
                    a = b;
                }
            }
            let slope = after.rail_profile.d1.abs();
            depth = (depth.0.min(after.penetration), depth.1.max(after.penetration));
            steepness = (steepness.0.min(slope), steepness.1.max(slope));
            before = after;
            q += coarse;
        }
        println!("{name} {spacing:.0e}: {changes} changes, {depth:?} m deep, on slopes {steepness:?};");
        println!("  largest jump of the penetration {jump:.1e} m, of the rolling radius {radius_jump:.1e} m");
        assert!(changes > 5 && depth.0 > 0.0 && radius_jump < 1e-7);
        jumps.push(jump);
    }
    assert!(jumps.iter().all(|jump| *jump < 1e-12), "{jumps:?}");
}

// Cost.

#[test]
fn prop_cost_grows_with_the_nodes_near_contact_only() {
    let count = |wheel_half: f64, rail_half: f64, spacing: f64, penetration: f64| {
        let stand = Stand::new(
            wheel(Side::Left, cone_over(0.025, (-wheel_half, wheel_half))),
            rail(Side::Left, arc_over(0.3, (-rail_half, rail_half)), 0.025f64.atan(), 0.0, 0.0),
            spacing,
        );
        let axes = AxleFrame::new(0.003, 0.001).axes;
        let centre = stand.settle(Vector3::new(0.0, 0.001, RADIUS), &axes, penetration);
        let found = stand.search(&centre, &axes);
        // Nodes with delta > 0 on this arc: all of them must be seen.
        let inside = 2.0 * (2.0 * 0.3 * penetration).sqrt() / spacing;
        (found.evaluated, found.looked_up, inside, stand.search.wheel.count())
    };
    let short = count(0.03, 0.03, 1e-4, 1e-4);
    for (wheel_half, rail_half) in [(0.06, 0.03), (0.06, 0.06), (0.2, 0.2), (0.4, 0.25)] {
        let long = count(wheel_half, rail_half, 1e-4, 1e-4);
        println!("{} wheel nodes: {} pairs, {} bounds (short: {short:?})", long.3, long.0, long.1);
        assert!(long.0 <= short.0 + 10 && long.1 <= short.1 + 30);
    }
    for spacing in [4e-4, 2e-4, 1e-4, 5e-5, 2.5e-5] {
        let (pairs, bounds, inside, all) = count(0.07, 0.036, spacing, 1e-4);
        println!("{spacing:.1e}: {pairs} pairs, {bounds} bounds, {inside:.0} nodes inside, {all} nodes");
        assert!((pairs as f64) < 1.15 * inside + 40.0 && pairs as f64 >= inside - 2.0);
    }
}
