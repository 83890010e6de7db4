//! The search against plain looking on grids, against the four equations, and against itself in mirrored and moved poses.

#[cfg(test)]
use super::*;
use crate::contact::search::test_surfaces::Wave;
use crate::geometry::Side;
use crate::geometry::profile::test_profiles::built_in;
use crate::geometry::profile::{Part, Profile, ProfilePoint};
use crate::geometry::surface::Wheel;
use crate::geometry::track::{Deviation, Direction, Rail};
use crate::math::rotation::AxleFrame;
use crate::math::spline::CubicSpline;
use nalgebra::{Matrix3, Vector2, Vector3};
use std::sync::Arc;
use std::time::Instant;

/// Random numbers that are the same in each run (SplitMix64).
struct Random(u64);
impl Random {
    fn new(seed: u64) -> Self {
        Random(seed)
    }
    /// Between -1 and 1.
    fn sign(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

const RELEASE: bool = !cfg!(debug_assertions);

fn s1002() -> Arc<dyn Profile> {
    built_in("kind = \"s1002\"\nradius = 0.46\n", Part::Wheel)
}

fn rail_60e1() -> Arc<dyn Profile> {
    built_in("kind = \"60e1\"\n", Part::Rail)
}

#[derive(Debug)]
struct Worn(CubicSpline);
impl Profile for Worn {
    fn at(&self, x: f64) -> ProfilePoint {
        let [value, d1, d2, d3] = self.0.at(x);
        ProfilePoint { value, d1, d2, d3 }
    }
    fn range(&self) -> (f64, f64) {
        self.0.range()
    }
    fn describe(&self) -> String {
        "worn".into()
    }
}

/// A spline through points about `spacing` apart along `base`, each off it by up to `wear`.
fn worn(base: &dyn Profile, spacing: f64, wear: f64, random: &mut Random) -> Arc<dyn Profile> {
    let (mut x, last) = base.range();
    let mut points = vec![];
    while x < last {
        let p = base.at(x);
        let rise = (1.0 + p.d1 * p.d1).sqrt();
        if p.d1.abs() < 6.0 {
            points.push((x, p.value + wear * random.sign() * rise));
        }
        x += spacing / rise;
    }
    Arc::new(Worn(CubicSpline::natural(&points).unwrap()))
}

/// Raw measured points, 0.5 mm apart and off by up to 15 um: some 30 minima within the reach. The deepest one was lost where more than a dozen came before it.
#[test]
fn prop_the_deepest_place_of_a_noisy_wheel_is_found() {
    for seed in 1..=4 {
        let mut random = Random::new(seed);
        let wheel = worn(s1002().as_ref(), 5e-4, 1.5e-5, &mut random);
        let scene = Scene::new("noisy", Side::Left, wheel, rail_60e1());
        let brute = Brute::new(&scene, 2e-5);
        let (mut found, mut most) = (Minima::default(), 0);
        for _ in 0..25 {
            let mut pose = Pose::new(0.003 * random.sign(), 0.46, 0.0, 0.0);
            let depth = |pose: &Pose| brute.all(&scene, pose, 1).iter().map(|d| d.1).fold(f64::INFINITY, f64::min);
            pose.centre.z -= depth(&pose) + 5e-5;
            let expected = depth(&pose);
            scene.search.find(&scene.pair(&pose), 3e-4, &mut found);
            let deepest = found.deepest().unwrap().distance;
            most = most.max(found.len());
            assert!((deepest - expected).abs() < 2e-7, "seed {seed}: {deepest:e} {expected:e}");
            assert!(found.clearance >= deepest);
        }
        assert_eq!(most, MOST, "as many as are returned");
    }
}

/// Pieces of parabolas: (from, slope, curvature) continued with equal value; kinks and jumps of curvature as given.
#[derive(Debug)]
struct Pieces {
    pieces: Vec<(f64, f64, f64, f64)>,
    last: f64,
}
impl Pieces {
    fn through(start: f64, pieces: &[(f64, f64, f64)], last: f64) -> Arc<dyn Profile> {
        let mut value = start;
        let mut list = vec![];
        for (i, (from, slope, curvature)) in pieces.iter().enumerate() {
            list.push((*from, value, *slope, *curvature));
            let x = pieces.get(i + 1).map_or(last, |p| p.0) - from;
            value += x * (slope + 0.5 * x * curvature);
        }
        Arc::new(Pieces { pieces: list, last })
    }
}
impl Profile for Pieces {
    fn at(&self, x: f64) -> ProfilePoint {
        let (from, value, slope, curvature) = *self.pieces.iter().rev().find(|p| p.0 <= x).unwrap_or(&self.pieces[0]);
        let x = x - from;
        ProfilePoint { value: value + x * (slope + 0.5 * x * curvature), d1: slope + x * curvature, d2: curvature, d3: 0.0 }
    }
    fn range(&self) -> (f64, f64) {
        (self.pieces[0].0, self.last)
    }
    fn describe(&self) -> String {
        "pieces".into()
    }
}

/// A wheel of straight lines and parabolas with kinks: flange, root and a broken tread, all kinks convex.
fn kinked_wheel() -> Arc<dyn Profile> {
    let pieces = [
        (-0.065, 1.5, -150.0),
        (-0.045, -1.5, 0.0),
        (-0.035, -1.5, 134.5),
        (-0.024, -0.025, 0.0),
        (0.0, -0.05, 0.0),
        (0.02, -0.08, -0.5),
        (0.04, -0.2, 0.0),
    ];
    Pieces::through(0.4675, &pieces, 0.06)
}

/// A rail of parabolas with kinks that point up.
fn kinked_rail() -> Arc<dyn Profile> {
    let pieces = [(-0.034, 2.0, -80.0), (-0.02, 0.5, -10.0), (-0.01, 0.15, -5.0), (0.01, -0.02, -3.0), (0.025, -0.3, -60.0)];
    Pieces::through(-0.02, &pieces, 0.034)
}

struct Scene {
    name: String,
    wheel: Wheel,
    rail: Rail,
    search: GlobalSearch,
}

impl Scene {
    fn new(name: &str, side: Side, wheel: Arc<dyn Profile>, rail: Arc<dyn Profile>) -> Scene {
        let wheel = Wheel { side, profile: wheel, half_spacing: 0.75 };
        let rail = Rail::new(side, rail, 0.75, 0.025, &[]);
        let search = GlobalSearch::new(wheel.profile.as_ref(), rail.profile.as_ref());
        Scene { name: name.into(), wheel, rail, search }
    }
    fn all() -> Vec<Scene> {
        let mut random = Random::new(7);
        let mut scenes = vec![
            Scene::new("S1002 on 60E1", Side::Left, s1002(), rail_60e1()),
            Scene::new("S1002 on 60E1, right", Side::Right, s1002(), rail_60e1()),
            Scene::new("kinked wheel", Side::Left, kinked_wheel(), rail_60e1()),
            Scene::new("kinked rail", Side::Left, s1002(), kinked_rail()),
            Scene::new("both kinked", Side::Right, kinked_wheel(), kinked_rail()),
        ];
        for i in 0..4 {
            let wheel = worn(s1002().as_ref(), 4e-3, 1e-5 * f64::from(i + 1), &mut random);
            let rail = worn(rail_60e1().as_ref(), 4e-3, 5e-6 * f64::from(i + 1), &mut random);
            scenes.push(Scene::new(&format!("worn {i}"), Side::BOTH[i as usize % 2], wheel, rail));
        }
        scenes
    }
    fn kinked(&self) -> bool {
        self.name.contains("kinked")
    }
    fn rail_kinked(&self) -> bool {
        self.kinked() && self.name != "kinked wheel"
    }
    fn pair<'a>(&'a self, pose: &'a Pose) -> Pair<'a> {
        Pair { wheel: &self.wheel, rail: &self.rail, centre: &pose.centre, axes: &pose.axes, distance: 0.0 }
    }
}

#[derive(Clone, Debug)]
struct Pose {
    centre: Vector3<f64>,
    axes: Matrix3<f64>,
    yaw: f64,
    roll: f64,
}

impl Pose {
    fn new(y: f64, z: f64, yaw: f64, roll: f64) -> Pose {
        Pose { centre: Vector3::new(0.0, y, z), axes: AxleFrame::new(yaw, roll).axes, yaw, roll }
    }
}

/// The same distances by plain looking: points of wheel and rail on grids.
struct Brute {
    wheel: Vec<(f64, ProfilePoint)>,
    /// In the track frame (Y, Z).
    rail: Vec<Vector2<f64>>,
    skip: usize,
}

impl Brute {
    fn new(scene: &Scene, step: f64) -> Brute {
        let knots = &scene.search.wheel.knots;
        let (first, last) = (knots[0].x, knots[knots.len() - 1].x);
        let (mut u, mut wheel) = (first, vec![]);
        while u < last {
            let p = scene.wheel.profile.at(u);
            wheel.push((u, p));
            let next = u + step / (1.0 + p.d1 * p.d1).sqrt();
            for knot in knots.windows(2).filter(|k| k[0].x == k[1].x && k[0].x > u && k[0].x < next) {
                wheel.extend([knot[0].x - 2e-10, knot[0].x + 2e-10].map(|u| (u, scene.wheel.profile.at(u))));
            }
            u = next;
        }
        wheel.push((last, scene.wheel.profile.at(last)));
        let (from, to) = scene.search.rail.ends();
        let point = |eta: f64, h: f64| {
            let p = scene.rail.section(0.0).origin + scene.rail.outward * eta + scene.rail.up * h;
            Vector2::new(p.y * scene.rail.side.sign(), p.z)
        };
        let mut rail = vec![];
        let (a, b) = (scene.rail.profile.at(from + 1e-9), scene.rail.profile.at(to - 1e-9));
        let far = 0.2;
        rail.push(point(from - far / (1.0 + a.d1 * a.d1).sqrt(), a.value - a.d1 * far / (1.0 + a.d1 * a.d1).sqrt()));
        let mut eta = from;
        while eta < to {
            let p = scene.rail.profile.at(eta);
            rail.push(point(eta, p.value));
            eta += 0.5 * step / (1.0 + p.d1 * p.d1).sqrt();
        }
        rail.push(point(to, b.value));
        rail.push(point(to + far / (1.0 + b.d1 * b.d1).sqrt(), b.value + b.d1 * far / (1.0 + b.d1 * b.d1).sqrt()));
        let skip = (1e-3 / step) as usize;
        Brute { wheel, rail, skip }
    }

    fn segment(&self, i: usize, p: &Vector2<f64>) -> (f64, f64) {
        let (a, b) = (self.rail[i], self.rail[i + 1]);
        let along = b - a;
        let share = (along.dot(&(p - a)) / along.norm_squared()).clamp(0.0, 1.0);
        ((p - a - along * share).norm_squared(), along.perp(&(p - a)) / along.norm())
    }

    /// Signed distance: nearest of all coarse points, then the segments around it.
    fn distance(&self, p: &Vector2<f64>) -> f64 {
        let last = self.rail.len() - 2;
        let coarse =
            (0..=last).step_by(self.skip).map(|i| (i, (self.rail[i] - p).norm_squared())).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap().0;
        let near = coarse.saturating_sub(2 * self.skip)..=(coarse + 2 * self.skip).min(last);
        let ends = [0, last];
        let best = near.chain(ends).map(|i| (i, self.segment(i, p))).min_by(|a, b| a.1.0.total_cmp(&b.1.0)).unwrap();
        // Beside a point between two segments, the side of the bisector counts.
        let (i, (square, mut side)) = best;
        for other in [i.wrapping_sub(1), i + 1] {
            if other <= last {
                let (distance, other_side) = self.segment(other, p);
                if (distance - square).abs() < 1e-12 * square + 1e-24 {
                    side += other_side;
                }
            }
        }
        square.sqrt().copysign(side)
    }

    /// The same from a guess, which is right where the rail is not hollow.
    fn walk(&self, p: &Vector2<f64>, guess: &mut usize) -> f64 {
        let last = self.rail.len() - 2;
        let mut best = self.segment(*guess, p);
        for step in [1, -1] {
            while let Some(next) = guess.checked_add_signed(step).filter(|i| *i <= last) {
                let other = self.segment(next, p);
                if other.0 > best.0 {
                    break;
                }
                // Equal at a common point: the side of the bisector.
                let side = if other.0 == best.0 || (other.0 - best.0).abs() < 1e-12 * best.0 { best.1 + other.1 } else { other.1 };
                (best, *guess) = ((other.0, side), next);
            }
        }
        best.0.sqrt().copysign(best.1)
    }

    /// (u, distance, does the trace run forward?) at each place of the wheel.
    fn all(&self, scene: &Scene, pose: &Pose, step: usize) -> Vec<(f64, f64, bool)> {
        let sign = scene.wheel.side.sign();
        let (axle, x, z) = (pose.axes.column(1) * sign, pose.axes.column(0), pose.axes.column(2));
        let (ahead, up) = (x.x, z.x);
        let mut points: Vec<(f64, Vector2<f64>)> = vec![];
        for (u, p) in self.wheel.iter().step_by(step) {
            // sin(angle) X.t - cos(angle) Z.t = R' a.t
            let angle = up.atan2(ahead) + (p.d1 * axle.x / ahead.hypot(up)).asin();
            let (sin, cos) = angle.sin_cos();
            let r = pose.centre + axle * (scene.wheel.half_spacing + u) + (x * sin - z * cos) * p.value;
            points.push((*u, Vector2::new(r.y * sign, r.z)));
        }
        let k2 = axle.x * axle.x / (1.0 - axle.x * axle.x);
        let (mut guess, fine) = (1, self.skip > 10);
        points
            .iter()
            .zip(self.wheel.iter().step_by(step))
            .map(|((u, point), (_, p))| {
                let distance = if fine || *u == self.wheel[0].0 { self.distance(point) } else { self.walk(point, &mut guess) };
                (*u, distance, 1.0 - k2 * (p.d1 * p.d1 + p.value * p.d2) > 0.0)
            })
            .collect()
    }
}

/// Minima of sampled distances below `reach` that lie deeper than their surroundings by `depth`: (u, distance).
fn sampled_minima(d: &[(f64, f64, bool)], reach: f64, depth: f64) -> Vec<(f64, f64, f64)> {
    let mut minima: Vec<(f64, f64, f64)> = vec![];
    for i in 0..d.len() {
        let ahead = i + 1 == d.len() || d[i + 1].1 >= d[i].1;
        let behind = i == 0 || d[i - 1].1 > d[i].1;
        let (from, to) = (i.saturating_sub(1), (i + 1).min(d.len() - 1));
        let forward = d[from].2 && d[i].2 && d[to].2;
        if d[i].1 >= reach || !ahead || !behind || !forward {
            continue;
        }
        // How far it rises on both sides before it falls below.
        let rise = |side: &mut dyn Iterator<Item = usize>| {
            let mut most = f64::NEG_INFINITY;
            for j in side {
                if !d[j].2 || d[j].1 < d[i].1 {
                    return most - d[i].1;
                }
                most = most.max(d[j].1);
            }
            f64::INFINITY
        };
        let prominence = rise(&mut (0..i).rev()).min(rise(&mut (i + 1..d.len())));
        if prominence > depth {
            minima.push((d[i].0, d[i].1, prominence));
        }
    }
    minima
}

/// A random pose whose least distance is about `gap`.
fn random_pose(scene: &Scene, brute: &Brute, random: &mut Random, wide: bool) -> Pose {
    let (y, yaw, gap) = (0.06 * random.sign(), 0.05 * random.sign(), 5e-3 * random.sign());
    let roll = if wide { 0.1 } else { 0.03 } * random.sign();
    let mut pose = Pose::new(y, 0.46, yaw, roll);
    pose.centre.y -= (pose.axes * Vector3::new(0.0, 0.0, -0.46)).y;
    for _ in 0..2 {
        let least = brute.all(scene, &pose, brute.skip).iter().map(|d| d.1).fold(f64::INFINITY, f64::min);
        pose.centre.z += gap - least;
    }
    pose
}

#[derive(Default, Debug)]
struct Tally {
    poses: usize,
    minima: usize,
    several: usize,
    kinks: usize,
    edges: usize,
    delicate: usize,
    worst: f64,
    missed: Vec<String>,
}

fn compare(scene: &Scene, brute: &Brute, pose: &Pose, reach: f64, depth: f64, tally: &mut Tally) {
    let pair = scene.pair(pose);
    let mut found = Minima::default();
    scene.search.find(&pair, reach, &mut found);
    let sampled = brute.all(scene, pose, 1);
    // Deeper than that the nearest side of the rail may be another one; a vertex is measured along the wheel's normal.
    let deepest = if scene.rail_kinked() { -5e-4 } else { -5e-3 };
    if sampled.iter().any(|d| d.1 < deepest) {
        return;
    }
    let spacing = 3e-4;
    let wanted = sampled_minima(&sampled, reach, depth);
    tally.poses += 1;
    tally.minima += found.len();
    tally.several += usize::from(found.len() > 1);
    tally.kinks += found.iter().filter(|m| m.kink != Kink::None).count();
    tally.edges += found.iter().filter(|m| m.at_edge).count();
    tally.delicate += usize::from(found.delicate);
    let what = || {
        let got: Vec<_> = found.iter().map(|m| (m.parameters.wheel, m.distance, m.kink, m.at_edge)).collect();
        format!("{}: {pose:?} reach {reach}\n found {got:?}\n wanted {wanted:?}", scene.name)
    };
    for (u, distance, _) in &wanted {
        let near = found
            .iter()
            .map(|m| ((m.parameters.wheel - u).abs(), (m.distance - distance).abs()))
            .min_by(|a, b| (a.0 + 10.0 * a.1).total_cmp(&(b.0 + 10.0 * b.1)));
        match near {
            Some((_, error)) if error < depth => tally.worst = tally.worst.max(error),
            _ if *distance > reach - depth => {}
            _ => tally.missed.push(format!("missed u {u} d {distance}: {}", what())),
        }
    }
    // What was found is there: no sample in its basin is lower.
    for m in found.iter() {
        let lowest = sampled
            .iter()
            .filter(|d| d.2 && d.0 >= m.basin.0 + spacing && d.0 <= m.basin.1 - spacing)
            .map(|d| d.1)
            .fold(f64::INFINITY, f64::min);
        if lowest < m.distance - depth {
            tally.missed.push(format!("at u {} a basin falls to {lowest}: {}", m.parameters.wheel, what()));
        }
    }
}

fn report(name: &str, tally: &Tally, start: Instant) {
    println!(
        "{name}: {} poses, {} minima, {} poses with several, {} kinks, {} edges, {} delicate, worst difference {:.1e} m, {:.1} s",
        tally.poses,
        tally.minima,
        tally.several,
        tally.kinks,
        tally.edges,
        tally.delicate,
        tally.worst,
        start.elapsed().as_secs_f64()
    );
    for missed in tally.missed.iter().take(3) {
        println!("{missed}");
    }
}

#[test]
fn prop_minima_agree_with_a_fine_grid() {
    let mut failures = 0;
    for scene in Scene::all() {
        let brute = Brute::new(&scene, 2e-5);
        let (mut random, mut tally, start) = (Random::new(1), Tally::default(), Instant::now());
        for i in 0..if RELEASE { 60 } else { 4 } {
            let pose = random_pose(&scene, &brute, &mut random, i % 4 == 0);
            compare(&scene, &brute, &pose, 6e-3, if scene.kinked() { 5e-6 } else { 2e-7 }, &mut tally);
        }
        report(&scene.name, &tally, start);
        failures += tally.missed.len();
    }
    assert_eq!(failures, 0);
}

#[test]
fn prop_no_contact_is_missed_in_many_poses() {
    let mut failures = 0;
    for scene in Scene::all() {
        let brute = Brute::new(&scene, 2e-4);
        let (mut random, mut tally, start) = (Random::new(2), Tally::default(), Instant::now());
        for i in 0..if RELEASE { 11_200 } else { 60 } {
            let pose = random_pose(&scene, &brute, &mut random, i % 4 == 0);
            let depth = if scene.kinked() { 5e-5 } else { 1e-5 };
            compare(&scene, &brute, &pose, 2e-3, depth, &mut tally);
        }
        report(&scene.name, &tally, start);
        failures += tally.missed.len();
    }
    assert_eq!(failures, 0);
}

#[test]
fn equiv_candidates_solve_the_four_equations_on_a_straight_rail() {
    for scene in Scene::all() {
        let brute = Brute::new(&scene, 2e-4);
        let mut random = Random::new(3);
        let (mut worst, mut smooth, mut rough) = ((0.0f64, 0.0f64), 0, 0);
        for _ in 0..if RELEASE { 2000 } else { 100 } {
            let pose = random_pose(&scene, &brute, &mut random, false);
            let pair = scene.pair(&pose);
            let mut found = Minima::default();
            scene.search.find(&pair, 2e-3, &mut found);
            for m in found.iter().filter(|m| m.kink == Kink::None && !m.at_edge) {
                let polished = scene.search.polish(&pair, m);
                let (a, b) = (polished.location.parameters, m.parameters);
                if !polished.smooth {
                    rough += 1;
                }
                smooth += 1;
                let place =
                    (a.wheel - b.wheel).abs().max((a.rail - b.rail).abs()).max((a.lead - b.lead).abs()).max((a.angle - b.angle).abs());
                worst.0 = worst.0.max(place);
                worst.1 = worst.1.max((polished.location.penetration + m.distance).abs());
            }
        }
        println!("{}: {smooth} minima, {rough} narrowed, place {:.1e} m, distance {:.1e} m", scene.name, worst.0, worst.1);
        assert!(worst.0 < 1e-9 && worst.1 < 1e-12, "{} {worst:?}", scene.name);
    }
}

#[test]
fn prop_mirrored_pose_gives_mirrored_minima() {
    let scenes = Scene::all();
    let (left, right) = (&scenes[0], &scenes[1]);
    let brute = Brute::new(left, 2e-4);
    let mut random = Random::new(4);
    for _ in 0..if RELEASE { 1000 } else { 100 } {
        let pose = random_pose(left, &brute, &mut random, true);
        let mirrored = Pose::new(-pose.centre.y, pose.centre.z, -pose.yaw, -pose.roll);
        let (mut a, mut b) = (Minima::default(), Minima::default());
        left.search.find(&left.pair(&pose), 3e-3, &mut a);
        right.search.find(&right.pair(&mirrored), 3e-3, &mut b);
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(b.iter()) {
            assert!((a.distance - b.distance).abs() < 1e-14 && (a.parameters.wheel - b.parameters.wheel).abs() < 1e-11);
            assert!((a.parameters.lead - b.parameters.lead).abs() < 1e-11);
        }
    }
}

/// A minimum of `b` that goes on from one of `a` when the wheel moved by `step`.
fn goes_on(a: &[Minimum], b: &Minimum, step: f64) -> bool {
    a.iter().any(|a| (a.distance - b.distance).abs() < 1.2 * step + 1e-12 && (a.parameters.wheel - b.parameters.wheel).abs() < 4e-3)
}

/// Depth of minimum i below the nearer ridge beside it.
fn depth(list: &[Minimum], i: usize) -> f64 {
    let before = i.checked_sub(1).and_then(|i| list[i].ridge_to_next);
    [before, list[i].ridge_to_next].iter().flatten().map(|r| r.distance - list[i].distance).fold(f64::INFINITY, f64::min)
}

#[test]
fn prop_minima_are_continuous_but_for_births_and_deaths_beside_a_ridge() {
    const STEP: f64 = 5e-6;
    for scene in Scene::all().iter().filter(|s| !s.kinked()) {
        for (yaw, roll) in [(0.0, 0.0), (0.02, 0.004), (-0.04, -0.01)] {
            let (mut before, mut events, mut deepest) = (Minima::default(), 0, 0.0f64);
            for i in 0..if RELEASE { 4000 } else { 800 } {
                let pose = Pose::new(-0.01 + STEP * f64::from(i), 0.46, yaw, roll);
                let mut now = Minima::default();
                scene.search.find(&scene.pair(&pose), 4e-3, &mut now);
                for (from, to) in [(&before, &now), (&now, &before)] {
                    for (j, m) in to.iter().enumerate().filter(|(_, m)| i > 0 && m.distance < 4e-3 - 2.0 * STEP) {
                        if !goes_on(from, m, STEP) {
                            events += 1;
                            deepest = deepest.max(depth(to, j));
                        }
                    }
                }
                before = now;
            }
            println!("{} yaw {yaw}: {events} births and deaths, deepest {deepest:.1e} m below its ridge", scene.name);
            assert!(deepest < 3e-6, "{}", scene.name);
        }
    }
}

/// A pose in which no point of the wheel is further away than `length`: half by shifting, the rest by turning about a point on the
/// tread.
fn moved(scene: &Scene, pose: &Pose, length: f64, random: &mut Random) -> Pose {
    let turn = 0.5 * length / branch::ARM * random.sign();
    let about = Vector3::new(0.0, scene.wheel.side.sign() * 0.75 + pose.centre.y, 0.0);
    let axes = AxleFrame::new(pose.yaw, pose.roll + turn).axes;
    let turned = AxleFrame::new(0.0, turn).axes * (pose.centre - about) + about;
    let shift = Vector3::new(0.0, random.sign(), random.sign()) * (0.45 * length);
    Pose { centre: turned + shift, axes, roll: pose.roll + turn, ..pose.clone() }
}

#[test]
fn prop_no_point_of_the_wheel_moves_further_than_the_motion_says() {
    let (mut random, mut closest) = (Random::new(10), 0.0f64);
    for scene in Scene::all() {
        for i in 0..200 {
            let size = 10f64.powi(-(i % 4) - 2);
            let at = [0.008, 0.46 + 5e-3, 0.03, 0.03].map(|most| most * random.sign());
            let change = [1.0, 1.0, 1.0, 1.0].map(|most| most * size * random.sign() * random.sign());
            let poses = [0.0, 1.0].map(|s| {
                Pose::new(at[0] + s * 0.1 * change[0], 0.46 + s * 0.1 * change[1], at[2] + s * 0.3 * change[2], at[3] + s * 0.3 * change[3])
            });
            let [from, to] = poses.each_ref().map(|pose| (scene.search.standing(&scene.pair(pose)), View::new(&scene.pair(pose), None)));
            let motion = scene.search.motion(&from.0, &to.0);
            for knot in scene.search.wheel.knots.iter().filter(|knot| knot.slope.abs() < 4.0 && knot.x.abs() < 0.08) {
                let [a, b] = [from.1, to.1].map(|view| view.trace(knot.x, knot.y, knot.slope));
                let turn = a.tangent.perp(&b.tangent).atan2(a.tangent.dot(&b.tangent)).abs();
                let moved = (a.point - b.point).norm().max(branch::ARM * turn);
                closest = closest.max(moved / motion);
                assert!(moved < 0.51 * motion, "{} {poses:?} u {}: {moved} of {motion}", scene.name, knot.x);
            }
        }
    }
    println!("points move by up to {closest:.3} of the motion");
    assert!(closest > 0.25);
}

#[test]
fn prop_what_is_watched_shows_births_and_deaths() {
    const REACH: f64 = 3e-3;
    let (mut watched, mut unlike, mut held, mut changed, mut alarms) = (0, 0, 0, 0, 0);
    for scene in Scene::all() {
        let mut random = Random::new(9);
        for _ in 0..if RELEASE { 4000 } else { 200 } {
            let pose = Pose::new(0.008 * random.sign(), 0.46 + 5e-4 * random.sign(), 0.01 * random.sign(), 0.003 * random.sign());
            let (mut a, mut b) = (Minima::default(), Minima::default());
            scene.search.find(&scene.pair(&pose), REACH, &mut a);
            if a.is_empty() || a.apart == 0.0 || a.watch.is_empty() || a.iter().any(|m| m.distance < -4e-3) {
                continue;
            }
            watched += 1;
            let again = scene.search.watched(&scene.pair(&pose), &a.watch, &a[0].parameters);
            unlike += usize::from(again.is_none());
            let moved = moved(&scene, &pose, a.apart, &mut random);
            scene.search.find(&scene.pair(&moved), REACH, &mut b);
            let holds = scene.search.watched(&scene.pair(&moved), &a.watch, &a[0].parameters).is_some();
            let sure = |list: &Minima| list.iter().filter(|m| m.distance < REACH - 1.5 * a.apart).count();
            let same = sure(&a) <= b.len() && sure(&b) <= a.len();
            assert!(!holds || same, "{} {pose:?} {moved:?}\n{:?}\n{:?}", scene.name, &a[..], &b[..]);
            held += usize::from(holds);
            changed += usize::from(!same);
            alarms += usize::from(same && !holds);
        }
    }
    println!(
        "{watched} poses with a watch: {held} hold, {changed} births and deaths, all of them seen, {alarms} other alarms, {unlike} at the same pose"
    );
    assert!(changed > 10 && held * 2 > watched && unlike * 100 < watched);
}

#[test]
fn prop_many_looks_one_after_another_miss_nothing() {
    const REACH: f64 = 3e-3;
    let (mut poses, mut searches, mut looks, mut changes) = (0, 0, 0, 0);
    for scene in Scene::all() {
        let mut random = Random::new(12);
        for walk in 0..if RELEASE { 200 } else { 4 } {
            let mut pose = Pose::new(0.006 * random.sign(), 0.46, 0.005 * random.sign(), 0.003 * random.sign());
            let way = [random.sign(), 0.05 * random.sign()];
            let mut found = Minima::default();
            // Motions that are left until there must be a search, and until there must be a look, with the poses that they count from.
            let mut left = None;
            for _ in 0..100 {
                let step = 10f64.powi(-4 - walk % 3) * random.sign().abs();
                pose = Pose::new(pose.centre.y + step * way[0], pose.centre.z, pose.yaw, pose.roll + step * way[1]);
                let pair = scene.pair(&pose);
                let now = scene.search.standing(&pair);
                poses += 1;
                let holds = left.is_some_and(|(apart, from, steady, since): (f64, WheelPose, f64, WheelPose)| {
                    if scene.search.motion(&from, &now) >= apart {
                        return false;
                    }
                    if !found.watch.is_empty() && scene.search.motion(&since, &now) >= steady {
                        looks += 1;
                        let Some(steady) = scene.search.watched(&pair, &found.watch, &found[0].parameters) else { return false };
                        left = Some((apart, from, steady, now));
                    }
                    true
                });
                let mut fresh = Minima::default();
                scene.search.find(&pair, REACH, &mut fresh);
                if fresh.is_empty() || fresh.iter().any(|m| m.distance < -2e-3) {
                    break;
                }
                let near = |list: &Minima| list.iter().filter(|m| m.distance < REACH - 1.5e-3).count();
                if holds {
                    let same = near(&found) <= fresh.len() && near(&fresh) <= found.len();
                    let shallow = (0..fresh.len()).any(|i| depth(&fresh, i) < 1e-9);
                    assert!(same || shallow, "{} {pose:?}\n{:?}\n{:?}", scene.name, &found[..], &fresh[..]);
                } else {
                    searches += 1;
                    changes += usize::from(found.len() != fresh.len());
                    found = fresh;
                    left = Some((found.apart, now, found.steady, now));
                }
            }
        }
    }
    println!("{poses} poses, {searches} searches, {looks} looks, {changes} changes of number");
    assert!(searches * 3 < poses && changes > 20 && looks > 100);
}

#[test]
fn analytic_phi_is_extreme_opposite_a_joint() {
    let scene = Scene::new("S1002 on 60E1", Side::Left, s1002(), rail_60e1());
    let joints = &scene.search.rail.joints;
    assert_eq!(joints.len(), 4, "arcs of 13, 80, 300, 80 and 13 mm");
    let pose = Pose::new(0.001, 0.46, 0.004, 0.001);
    let pair = scene.pair(&pose);
    let scan = Scan::seen(&scene.search, &pair, View::new(&pair, None), 1.0);
    let joint = scene.search.rail.curve.knots[joints[1]];
    let found = scan.opposite(joints[1], joint.x).unwrap();
    // By the foot of the wheel's point; the wheel is hollower than the flat arc and less so than the round one.
    let at = |off: f64| scan.at(found.u + off, found.foot - 1.0);
    assert!((at(0.0).phi - found.phi).abs() < 1e-9 && (at(0.0).distance - found.distance).abs() < 1e-12);
    let [below, above] = [-5e-4, 5e-4].map(|off| at(off).phi - found.phi);
    println!("u {:.6}: phi {:.3e}, {below:.2e} and {above:.2e} beside it", found.u, found.phi);
    assert!(below * above > 0.0 && below.abs().min(above.abs()) > 1e-4);
}

#[test]
fn prop_steady_motion_keeps_the_minima() {
    const REACH: f64 = 3e-3;
    let (mut certified, mut all) = (0, 0);
    for scene in Scene::all() {
        let brute = Brute::new(&scene, 2e-4);
        let mut random = Random::new(8);
        for i in 0..if RELEASE { 4000 } else { 200 } {
            let mut pose = random_pose(&scene, &brute, &mut random, false);
            if i % 2 == 0 {
                pose = Pose::new(0.008 * random.sign(), 0.46 + 5e-4 * random.sign(), 0.01 * random.sign(), 0.003 * random.sign());
            }
            let (mut a, mut b) = (Minima::default(), Minima::default());
            scene.search.find(&scene.pair(&pose), REACH, &mut a);
            all += 1;
            if a.delicate || a.iter().any(|m| m.distance < -4e-3) {
                continue;
            }
            certified += 1;
            let (steady, moved) = (a.steady, moved(&scene, &pose, a.steady, &mut random));
            scene.search.find(&scene.pair(&moved), REACH, &mut b);
            let sure = |list: &Minima| list.iter().filter(|m| m.distance < REACH - 1.5 * steady).count();
            let (before, after) = (&a[..], &b[..]);
            assert!(sure(&a) <= b.len() && sure(&b) <= a.len(), "{} {pose:?} {moved:?}\n{before:?}\n{after:?}", scene.name);
        }
    }
    println!("{certified} of {all} poses certified");
    assert!(certified * 2 > all);
}

#[test]
fn analytic_cone_on_arc() {
    // The distance of the circle's centre from the cone's line, minus the radius.
    let arch = built_in("kind = \"arc\"\nradius = 0.3\n", Part::Rail);
    let cone = built_in("kind = \"cone\"\nradius = 0.46\nslope = 0.025\n", Part::Wheel);
    let scene = Scene::new("cone on arc", Side::Left, cone, arch);
    assert!(scene.search.strictly_convex());
    for (y, roll, gap) in [(0.0, 0.0, 0.0), (0.004, 0.002, 1e-4), (-0.006, -0.003, -2e-4)] {
        let pose = Pose::new(y, 0.46 + gap, 0.0, roll);
        let mut found = Minima::default();
        scene.search.find(&scene.pair(&pose), 0.01, &mut found);
        let angle = roll + 0.025f64.atan();
        let tread = pose.centre + pose.axes * Vector3::new(0.0, 0.75, -0.46);
        let middle = scene.rail.section(0.0).origin - scene.rail.up * 0.3;
        let expected = (tread - middle).dot(&Vector3::new(0.0, -angle.sin(), angle.cos())) - 0.3;
        assert_eq!(found.len(), 1);
        assert!((found[0].distance - expected).abs() < 1e-15 + 1e-13, "{} {expected}", found[0].distance);
        assert!(!found.delicate && found.steady > 1e-4 && found[0].kink == Kink::None && !found[0].at_edge);
    }
    assert!(Scene::all().iter().all(|scene| !scene.search.strictly_convex()));
}

#[test]
fn prop_every_pressed_pose_has_a_minimum() {
    let arch = built_in("kind = \"arc\"\nradius = 0.3\n", Part::Rail);
    let cone = built_in("kind = \"cone\"\nradius = 0.46\nslope = 0.025\n", Part::Wheel);
    let mut scenes = Scene::all();
    scenes.push(Scene::new("cone on arc", Side::Left, cone, arch));
    for scene in scenes {
        let brute = Brute::new(&scene, 2e-4);
        for (name, reach, small) in [("running", 5e-4, true), ("running, reach 2 mm", 2e-3, true), ("anywhere", 5e-4, false)] {
            let mut random = Random::new(5);
            let poses: Vec<Pose> = (0..200)
                .map(|_| {
                    let mut pose = random_pose(&scene, &brute, &mut random, false);
                    if small {
                        pose = Pose::new(0.007 * random.sign(), 0.46, 0.01 * random.sign(), 0.003 * random.sign());
                        let least = brute.all(&scene, &pose, 1).iter().map(|d| d.1).fold(f64::INFINITY, f64::min);
                        pose.centre.z -= least + 5e-5;
                    }
                    pose
                })
                .collect();
            let mut found = Minima::default();
            let (mut count, mut delicate, mut steady) = (0, 0, 0.0);
            for pose in &poses {
                scene.search.find(&scene.pair(pose), reach, &mut found);
                count += found.len();
                delicate += usize::from(found.delicate);
                steady += found.steady;
            }
            assert!(!small || scene.kinked() || count >= poses.len(), "{}: {count}", scene.name);
            println!(
                "{} ({} stretches of wheel, {} of rail), {name}: {:.2} minima, {delicate} of 200 delicate, mean steady {:.0} um, convex {}",
                scene.name,
                scene.search.wheel.stretches.len(),
                scene.search.rail.curve.stretches.len(),
                count as f64 / poses.len() as f64,
                1e6 * steady / poses.len() as f64,
                scene.search.strictly_convex()
            );
        }
    }
}

/// Keeps the wavy surfaces of the neighbours in use here.
fn wavy(side: Side) -> Rail {
    let deviation = |direction| Deviation { side, direction, shape: Arc::new(Wave) };
    Rail::new(side, rail_60e1(), 0.75, 0.025, &[deviation(Direction::Lateral), deviation(Direction::Vertical)])
}

#[test]
fn equiv_polished_minima_solve_the_equations_on_a_rail_that_bends() {
    let straight = Scene::new("straight", Side::Left, s1002(), rail_60e1());
    let brute = Brute::new(&straight, 2e-4);
    let scene = Scene { rail: wavy(Side::Left), ..Scene::new("wavy", Side::Left, s1002(), rail_60e1()) };
    let mut random = Random::new(6);
    let (mut shift, mut count, mut rough) = (0.0f64, 0, 0);
    for _ in 0..if RELEASE { 2000 } else { 100 } {
        let mut pose = random_pose(&straight, &brute, &mut random, false);
        let s = 3.0 * random.sign();
        let origin = scene.rail.section(s).origin - straight.rail.section(s).origin;
        pose.centre += origin;
        pose.centre.x = s;
        let pair = Pair { distance: s, ..scene.pair(&pose) };
        let mut found = Minima::default();
        scene.search.find(&pair, 2e-3, &mut found);
        for m in found.iter().filter(|m| !m.at_edge) {
            let polished = scene.search.polish(&pair, m);
            let p = polished.location.parameters;
            shift = shift.max((p.wheel - m.parameters.wheel).abs());
            count += 1;
            rough += usize::from(!polished.smooth);
            let (residual, _) = pair.residual(&nalgebra::Vector4::new(p.wheel, p.angle, p.lead, p.rail));
            if polished.smooth {
                // Slopes of tables are within 1e-10.
                assert!(residual.norm() < 5e-10, "{residual} {m:?} {polished:?}");
            }
        }
    }
    println!("{count} minima, {rough} narrowed, shift by bending up to {shift:.1e} m");
    assert!(count > 50 && rough * 50 < count);
}

#[test]
fn analytic_bending_ahead_is_the_bending_and_its_rate() {
    use crate::contact::search::algebraic::{ContactLocation, SurfaceParameters};
    let scene = Scene::new("S1002 on 60E1", Side::Left, s1002(), rail_60e1());
    let frame = AxleFrame::new(0.0, 0.0);
    fn posed<'a>(scene: &'a Scene, frame: &'a AxleFrame, centre: &'a Vector3<f64>) -> Pair<'a> {
        Pair { wheel: &scene.wheel, rail: &scene.rail, centre, axes: &frame.axes, distance: 0.0 }
    }
    // The wheel rests on its place, as a constraint has it.
    let resting = |y: f64| -> Option<(Vector3<f64>, ContactLocation)> {
        let mut centre = Vector3::new(0.0, y, 0.46);
        let mut found = posed(&scene, &frame, &centre).locate(&SurfaceParameters::default()).ok()?;
        for _ in 0..4 {
            centre.z += found.penetration / found.normal.z;
            found = posed(&scene, &frame, &centre).locate(&found.parameters).ok()?;
        }
        Some((centre, found))
    };
    let bending = |(centre, found): &(Vector3<f64>, ContactLocation), rates: [f64; 2]| {
        bending_ahead(&posed(&scene, &frame, centre), found, rates, 0.5)
    };
    let (step, mut count) = (1e-7, 0);
    for i in -20..=20 {
        let y = 1e-4 * f64::from(i);
        let (Some(before), Some(here), Some(after)) = (resting(y - step), resting(y), resting(y + step)) else { continue };
        let change = |a: f64, b: f64| (b - a) / (2.0 * step);
        let (p, q) = (before.1.parameters, after.1.parameters);
        // Of 1 m/s sideways; the time 1/2 then makes it k + dk/dy.
        let rates = [change(p.wheel, q.wheel), change(p.rail, q.rail)];
        let expected = change(bending(&before, [0.0; 2]), bending(&after, [0.0; 2]));
        // Jumps of curvature and other places of contact apart.
        if !(rates[0].abs() < 1e2 && expected.abs() < 1e5) {
            continue;
        }
        let rate = bending(&here, rates) - bending(&here, [0.0; 2]);
        println!("y = {y:.4} m: k = {:.4} 1/m, dk/dy = {rate:.5e}, by differences {expected:.5e}", bending(&here, [0.0; 2]));
        assert!((rate - expected).abs() < 1e-3 * (1.0 + expected.abs()), "y = {y:.4}: {rate} {expected}");
        count += 1;
    }
    assert!(count >= 15, "{count}");
}

/// A rail of some thousand stretches: what lies beyond its end is no stretch, however the sum rounds.
#[test]
fn hard_feet_beyond_the_ends_of_a_long_rail() {
    #[derive(Debug)]
    struct Long(f64);
    impl Profile for Long {
        fn at(&self, x: f64) -> ProfilePoint {
            ProfilePoint { value: -0.05 * x * x, d1: -0.1 * x, d2: -0.1, d3: 0.0 }
        }
        fn range(&self) -> (f64, f64) {
            (-self.0, self.0)
        }
        fn describe(&self) -> String {
            "long".into()
        }
    }
    for half in [0.3, 0.6, 1.2, 2.5] {
        let profile = Long(half);
        let rail = super::foot::RailCurve::new(&profile);
        let count = rail.curve.stretches.len();
        for eta in [-half - 0.1, -half, -half + 1e-13, 0.1, half - 1e-13, half, half + 1e-13, half + 0.1] {
            for guess in [-1e-9, 0.0, 0.5 * count as f64, (count as f64).next_down(), count as f64] {
                let point = Vector2::new(eta, profile.at(eta).value + 1e-4);
                let foot = rail.foot(&point, guess);
                let exact = rail.exact(&profile, &point, &foot);
                assert!((exact.eta - eta).abs() < 1e-4 && (exact.distance - 1e-4).abs() < 1e-3, "{half} {eta}: {exact:?}");
            }
        }
    }
}
