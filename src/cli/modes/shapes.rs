//! Mode shapes: the vehicle from its right side, from above and from the front, at rest and as it swings.

use crate::cli::plot::{BLUE, DARK, Ink, ORANGE, Panel, Series, Sheet, inside, width};
use crate::mbs::body::COORDINATES;
use crate::scene::spec::Scene;
use crate::scene::vehicle::outline::half_edges;
use crate::study::digits::rounded;
use crate::study::modes::{Mode, Modes};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::path::Path;

/// Modes drawn, and those that are not: Hz, and parts of critical damping from which on hardly anything swings.
const MOST: usize = 10;
const HIGHEST: f64 = 40.0;
const DAMPED: f64 = 0.95;
/// Largest displacement that is drawn, in parts of the vehicle's height.
const SWING: f64 = 0.15;
/// Phases that are looked at for the largest swing, in half a period.
const PHASES: u32 = 24;
/// Ways that are none, in parts of the vehicle's height.
const STILL: f64 = 2e-3;
/// Half width of a wheel, m.
const RIM: f64 = 0.065;
/// Least height of what is drawn, m.
const LEAST: f64 = 1.0;
/// Around the vehicle, in parts of its height.
const MARGIN: f64 = 0.25;

/// Places on a body from its centre of mass, m: for each view lines through points.
type Lines = Vec<Vec<Vector3<f64>>>;

/// The views: coordinates that are drawn to the right and upward.
const VIEWS: [(&str, [usize; 2], [&str; 2]); 3] = [
    ("from the right", [0, 2], ["x [m]", "z [m]"]),
    ("from above", [0, 1], ["x [m]", "y [m]"]),
    ("from the front", [1, 2], ["y [m]", "z [m]"]),
];

/// A body as it is drawn.
struct Outline {
    centre: Vector3<f64>,
    /// Does its own turning about y show?
    pitches: bool,
    views: [Lines; 3],
}

impl Outline {
    /// Where its points are after a displacement and a small rotation.
    fn moved(&self, view: usize, motion: &[f64]) -> impl Iterator<Item = Vec<(f64, f64)>> {
        let shift = Vector3::new(motion[0], motion[1], motion[2]);
        let turn = Vector3::new(motion[4], if self.pitches { motion[5] } else { 0.0 }, motion[3]);
        let [right, up] = VIEWS[view].1;
        let at = move |point: &Vector3<f64>| {
            let place = self.centre + point + shift + turn.cross(point);
            (place[right], place[up])
        };
        self.views[view].iter().map(move |line| line.iter().map(at).collect())
    }
}

/// A closed rectangle with half edges along two axes.
fn rectangle([a, b]: [Vector3<f64>; 2]) -> Vec<Vector3<f64>> {
    vec![a + b, a - b, -a - b, b - a, a + b]
}

/// All bodies in the model's order.
fn outlines(scene: &Scene) -> Vec<Outline> {
    let vehicle = &scene.vehicle;
    let wheelsets = vehicle.wheelsets.iter().map(|placed| {
        let (centre, half) = (placed.design_position(), placed.spec.half_tread_circle_distance);
        let radius = centre.z;
        let rim = |part: f64| Vector3::new(part.sin(), 0.0, part.cos()) * radius;
        let circle = (0..=20).map(|k| rim(TAU * f64::from(k) / 20.0)).collect();
        let axle = vec![Vector3::y() * half, -Vector3::y() * half];
        let wheels = |edges: [Vector3<f64>; 2]| {
            [1.0, -1.0].map(|side| rectangle(edges).into_iter().map(|point| point + Vector3::y() * (side * half)).collect::<Vec<_>>())
        };
        let [above, front] = [Vector3::x(), Vector3::z()].map(|axis| wheels([axis * radius, Vector3::y() * RIM]));
        let with_axle = |wheels: [Vec<Vector3<f64>>; 2]| std::iter::once(axle.clone()).chain(wheels).collect::<Lines>();
        Outline { centre, pitches: false, views: [vec![circle], with_axle(above), with_axle(front)] }
    });
    let bodies = vehicle.bodies.iter().map(|placed| {
        let [x, y, z] = half_edges(&placed.body);
        let [x, y, z] = [Vector3::x() * x, Vector3::y() * y, Vector3::z() * z];
        Outline { centre: placed.position, pitches: true, views: [[x, z], [x, y], [y, z]].map(|edges| vec![rectangle(edges)]) }
    });
    wheelsets.chain(bodies).collect()
}

/// Draws the slowest modes.
pub(super) fn draw(file: &Path, scene: &Scene, found: &Modes) -> Result<(), String> {
    let outlines = outlines(scene);
    let swings = |mode: &&Mode| mode.frequency > 0.0 && mode.frequency < HIGHEST && mode.damping < DAMPED;
    let all = found.modes.iter().filter(swings).count();
    let panels: Vec<Panel> = found.modes.iter().filter(swings).take(MOST).flat_map(|mode| panels(&outlines, mode)).collect();
    if panels.is_empty() {
        return Err(format!(
            "no mode swings below {HIGHEST} Hz with less than {:.0} % of critical damping: nothing to draw",
            100.0 * DAMPED
        ));
    }
    let shown = if all > MOST { format!("the {MOST} slowest of {all} modes") } else { format!("{all} modes") };
    let subtitles = vec![
        format!("{} at {} m/s; {shown} below {HIGHEST} Hz and {:.0} % of critical damping", scene.title, rounded(found.speed), 100.0 * DAMPED),
        "displacements enlarged alike for all bodies of a mode; of bodies a scene knows mass and inertia: boxes of even density stand for them".into(),
    ];
    Sheet { title: "Mode shapes".into(), subtitles, columns: 3, panels }.draw(file)
}

/// The three views of one mode.
fn panels(outlines: &[Outline], mode: &Mode) -> [Panel; 3] {
    // What moves by the mode's phase [rad]: COORDINATES per body.
    let motion = |phase: f64| -> Vec<f64> {
        let (sin, cos) = phase.sin_cos();
        mode.shape.iter().take(COORDINATES * outlines.len()).map(|[re, im]| re * cos - im * sin).collect()
    };
    let bounds = |view: usize, motion: &[f64]| {
        let points =
            outlines.iter().zip(motion.chunks(COORDINATES)).flat_map(|(body, own)| body.moved(view, own).flatten().collect::<Vec<_>>());
        points.fold([f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY], |[a, b, c, d], (x, y)| {
            [a.min(x), b.max(x), c.min(y), d.max(y)]
        })
    };
    let rest = vec![0.0; COORDINATES * outlines.len()];
    let [_, _, bottom, top] = bounds(0, &rest);
    let height = (top - bottom).max(LEAST);
    // Where it swings farthest: shapes are turned by velocities.
    let reach = |phase: f64| farthest(outlines, &motion(phase));
    let swung =
        (0..PHASES).map(|k| 0.5 * TAU * f64::from(k) / f64::from(PHASES)).max_by(|a, b| reach(*a).total_cmp(&reach(*b))).unwrap_or(0.0);
    let largest = reach(swung);
    let scale = if largest > 0.0 { SWING * height / largest } else { 0.0 };
    let [now, later] = [swung, swung + 0.25 * TAU].map(|phase| motion(phase).iter().map(|part| scale * part).collect::<Vec<f64>>());
    [0, 1, 2].map(|view| {
        let (name, _, labels) = VIEWS[view];
        let mut series = Vec::new();
        for (number, body) in outlines.iter().enumerate() {
            let own = COORDINATES * number..COORDINATES * (number + 1);
            let lines = |motion: &[f64]| body.moved(view, &motion[own.clone()]).collect::<Vec<_>>();
            for ((rest, later), now) in lines(&rest).into_iter().zip(lines(&later)).zip(lines(&now)) {
                // What stands still is drawn once.
                if way(&rest, &later).max(way(&rest, &now)) < STILL * height {
                    series.push(Series::line("", Ink { width: 1.25, ..Ink::line(DARK) }, rest));
                    continue;
                }
                series.push(Series::line("at rest", Ink { width: 1.0, alpha: 0.5, ..Ink::line(DARK) }, rest));
                series.push(Series::line("a quarter of a period later", Ink { width: 1.5, ..Ink::dashed(ORANGE) }, later));
                series.push(Series::line("at its largest swing", Ink::line(BLUE), now));
            }
        }
        let title = if view == 0 { mode.name.as_str() } else { name };
        let aside = [String::new(), format!("{:.3} Hz", mode.frequency), format!("{:.1} % damping", 100.0 * mode.damping)][view].clone();
        let mut panel = Panel { aside, height: 300.0, ..Panel::new(title, labels, series) };
        fit(&mut panel, bounds(view, &rest), MARGIN * height);
        panel
    })
}

/// The largest way of a point of a line.
fn way(from: &[(f64, f64)], to: &[(f64, f64)]) -> f64 {
    from.iter().zip(to).map(|(a, b)| (a.0 - b.0).hypot(a.1 - b.1)).fold(0.0, f64::max)
}

/// Gives both axes the same scale, with room around what is drawn.
fn fit(panel: &mut Panel, [left, right, low, high]: [f64; 4], margin: f64) {
    let (across, upward) = inside((width(3), panel.height));
    let [wide, tall] = [right - left, high - low].map(|length| length + 2.0 * margin);
    let per_pixel = (wide / across).max(tall / upward);
    let around = |from: f64, to: f64, pixels: f64| {
        let (middle, half) = (0.5 * (from + to), 0.5 * per_pixel * pixels);
        Some((middle - half, middle + half))
    };
    (panel.x.range, panel.y.range) = (around(left, right, across), around(low, high, upward));
}

/// The largest displacement of any point.
fn farthest(outlines: &[Outline], motion: &[f64]) -> f64 {
    let moved = |body: &Outline, own: &[f64], view: usize| {
        body.moved(view, &[0.0; COORDINATES]).zip(body.moved(view, own)).map(|(still, now)| way(&still, &now)).fold(0.0, f64::max)
    };
    let all = outlines.iter().zip(motion.chunks(COORDINATES));
    all.flat_map(|(body, own)| (0..VIEWS.len()).map(move |view| moved(body, own, view))).fold(0.0, f64::max)
}
