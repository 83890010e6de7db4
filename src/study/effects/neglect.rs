//! What the absence of an effect would neglect, as a number that a formula gives with this scene's values. No run is made.

use crate::contact::creep::RollingContact;
use crate::contact::creepage::Creepage;
use crate::contact::patch::PatchLaw;
use crate::formulation::{Model, algebraic, contact_index};
use crate::geometry::Side;
use crate::geometry::track::centre_line::Node;
use crate::geometry::track::components;
use crate::geometry::track::irregularity::Quantity;
use crate::scene::assemble;
use crate::scene::effects::QUANTITIES;
use crate::scene::spec::{PatchSpec, Scene};
use crate::scene::start;
use crate::sim::Snapshot;
use crate::study::contact_geometry::{Attitude, Start, WheelsetOnTrack};
use crate::study::digits::sized;
use serde::Serialize;
use std::f64::consts::TAU;

/// One number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Neglected {
    pub effect: &'static str,
    /// In words, with the formula.
    pub words: String,
    /// SI.
    pub value: f64,
}

/// Weight's acceleration where a scene has none, m/s2: what accelerations are compared with.
const STANDARD: f64 = 9.81;

/// Three significant digits without a prefix.
fn plain(value: f64, unit: &str) -> String {
    let value: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    format!("{value} {unit}")
}

/// All that formulas tell, at the state of a snapshot.
pub fn neglected(scene: &Scene, model: &Model, snapshot: &Snapshot) -> Vec<Neglected> {
    let track = bends(scene).into_iter().chain(slopes(scene)).chain(displacements(scene));
    track.chain(waves(scene)).chain(linear(scene)).chain(contacts(scene, model, snapshot)).collect()
}

/// Centrifugal force, what cant takes off it, and the moment that turns a spinning axle.
fn bends(scene: &Scene) -> Vec<Neglected> {
    let nodes = scene.track.alignment.as_ref().map_or(&[][..], |alignment| &alignment.nodes);
    let Some(sharpest) = nodes.iter().max_by(|a, b| a.curvature.abs().total_cmp(&b.curvature.abs())).filter(|node| node.curvature != 0.0)
    else {
        return Vec::new();
    };
    let speed = scene.vehicle.speed;
    let across = speed * speed * sharpest.curvature.abs();
    let mut all = vec![Neglected {
        effect: "curvature",
        words: format!("V^2/R = {} across the track, {:.1} % of the weight", plain(across, "m/s2"), 100.0 * across / STANDARD),
        value: across,
    }];
    let leading = scene.vehicle.leading();
    let radius = leading.profiles[0].profile.at(0.0).value;
    let moment = leading.axial_inertia * (speed / radius) * speed * sharpest.curvature.abs();
    let (change, static_load) =
        (0.5 * moment / leading.half_tread_circle_distance, scene.vehicle.weight() / (2 * scene.vehicle.wheelsets.len()) as f64);
    all.push(Neglected {
        effect: "gyroscopic moments",
        words: format!(
            "Iyy (V/r) V/R = {} rolls a wheelset in the curve: {} at each wheel, {:.2} % of Q",
            plain(moment, "N m"),
            sized(change, "N", 3),
            100.0 * change / static_load
        ),
        value: change,
    });
    all
}

/// Weight across canted and along climbing track.
fn slopes(scene: &Scene) -> Vec<Neglected> {
    let nodes = scene.track.alignment.as_ref().map_or(&[][..], |alignment| &alignment.nodes);
    let steepest = |of: fn(&Node) -> f64| nodes.iter().map(|node| of(node).abs()).fold(0.0, f64::max);
    let (cant, grade) = (steepest(|node| node.superelevation), steepest(|node| node.grade).max(scene.track.grade.abs()));
    let part = |effect, formula: &str, angle: f64| {
        let value = scene.vehicle.gravity * angle.sin();
        let words = format!("{formula} = {}, {:.1} % of the weight", plain(value, "m/s2"), 100.0 * angle.sin());
        (value != 0.0).then_some(Neglected { effect, words, value })
    };
    part("cant", "g sin f across the track", cant).into_iter().chain(part("grade", "g sin along the track", grade)).collect()
}

/// Largest shift at which a flange is looked for, m, and to what its begin is located.
const WIDEST: f64 = 20e-3;
const LOCATED: f64 = 1e-5;
/// A contact this steep is a flange's, rad.
const STEEP: f64 = std::f64::consts::FRAC_PI_4;

/// Shift [m] at which a flange of the leading wheelset meets its rail, both wheels standing and yaw 0; `None` where none does.
fn clearance(scene: &Scene) -> Option<f64> {
    let wheelset = WheelsetOnTrack::new(scene, Attitude { yaw: 0.0, level: false, near: 0.0 }, None);
    let centred = wheelset.stand(0.0, wheelset.start()).ok()?;
    let flanged = |y: f64, from: Start| {
        let stand = wheelset.stand(y, from).ok()?;
        let steep = stand.contacts.iter().any(|touch| touch.angle.abs() > STEEP);
        Some((steep, Start::from(&stand)))
    };
    let (mut low, mut from) = (0.0, Start::from(&centred));
    let step = WIDEST / 40.0;
    let mut high = loop {
        let (steep, next) = flanged(low + step, from)?;
        if steep {
            break low + step;
        }
        (low, from) = (low + step, next);
        if low > WIDEST {
            return None;
        }
    };
    while high - low > LOCATED {
        let middle = 0.5 * (low + high);
        match flanged(middle, from)? {
            (true, _) => high = middle,
            (false, next) => (low, from) = (middle, next),
        }
    }
    Some(high)
}

/// Displacements of the rails, beside the way to the flange.
fn displacements(scene: &Scene) -> Vec<Neglected> {
    let found = components::largest(&start::deviations(scene), super::list::way(scene, scene.run.stop));
    let mut all: Vec<Neglected> = (QUANTITIES.into_iter())
        .map(|(switch, quantity)| (switch.name(), found[quantity.index()]))
        .filter(|(_, size)| *size > super::list::NOTHING)
        .map(|(effect, size)| Neglected { effect, words: format!("up to {} on the way", sized(size, "m", 3)), value: size })
        .collect();
    let sideways = found[Quantity::Alignment.index()] + 0.5 * found[Quantity::Gauge.index()];
    if let Some(clearance) = clearance(scene) {
        let against = if sideways > super::list::NOTHING {
            format!(", {:.1} times the largest lateral displacement of a rail", clearance / sideways)
        } else {
            String::new()
        };
        let words = format!("a shift of {} brings it to the rail{against}", sized(clearance, "m", 3));
        all.push(Neglected { effect: "flange", words, value: clearance });
    }
    all
}

/// The shortest wave of the rails on the way.
fn waves(scene: &Scene) -> Option<Neglected> {
    let places: Vec<f64> = super::list::way(scene, scene.run.stop).collect();
    let (first, last) = (places.first()?, places.last()?);
    let deviations = start::deviations(scene);
    let waves = deviations.iter().flat_map(|deviation| deviation.shape.waves()).filter(|wave| wave.from < *last && wave.to > *first);
    let shortest = waves.map(|wave| wave.wave).reduce(f64::min)?;
    let frequency = scene.vehicle.speed.abs() / shortest;
    let base = scene.vehicle.wheelsets.windows(2).map(|pair| (pair[0].x - pair[1].x).abs()).filter(|base| *base > 0.0).reduce(f64::min);
    let against = base.map_or(String::new(), |base| format!(", {:.1} wheelbases of {}", shortest / base, sized(base, "m", 3)));
    Some(Neglected {
        effect: "shortest wave",
        words: format!("{} long{against}: V/length = {}", sized(shortest, "m", 3), sized(frequency, "Hz", 3)),
        value: shortest,
    })
}

/// What contact is that is linear about the middle of the track: Klingel's wave, the way on which it holds, and where a curve's free rolling is beside it. `None` where it can't be had.
fn linear(scene: &Scene) -> Option<Neglected> {
    let mut scene = scene.clone();
    (scene.contact.formulation, scene.contact.transient, scene.points) = (algebraic(), None, 1);
    scene.contact.patch = PatchSpec { law: PatchLaw::Linear, why: None };
    (scene.interface.inputs, scene.track.flexibility) = (Vec::new(), None);
    let model = assemble::model(&scene).ok()?;
    let contact = model.linear_contact(0)?;
    let (half, radius) = (scene.vehicle.leading().half_tread_circle_distance, contact.patch.radius().0);
    let conicity = contact.conicity(half);
    let holds = model.linear_ranges().first()?.holds.into_iter().fold(f64::INFINITY, f64::min);
    if !(conicity > 0.0) {
        return None;
    }
    let wave = TAU * (radius * half / conicity).sqrt();
    let sharpest = scene.track.alignment.iter().flat_map(|alignment| &alignment.nodes).map(|node| node.curvature.abs()).fold(0.0, f64::max);
    let aside = radius * half * sharpest / conicity;
    let curve = if sharpest > 0.0 {
        format!("; free rolling in the curve, r b/(conicity R), stands {} aside", sized(aside, "m", 3))
    } else {
        String::new()
    };
    let words = format!(
        "conicity {conicity:.3}, Klingel's wave {}: V/length = {}; holds to 20 % of the radius difference up to {} from the middle{curve}",
        sized(wave, "m", 3),
        sized(scene.vehicle.speed.abs() / wave, "Hz", 3),
        sized(holds, "m", 3)
    );
    Some(Neglected { effect: "linear contact", words, value: holds })
}

/// Spin's force, and the time in which a patch is passed, of the most loaded contact.
fn contacts(scene: &Scene, model: &Model, snapshot: &Snapshot) -> Vec<Neglected> {
    let wheels = (0..model.wheelsets.len()).flat_map(|index| Side::BOTH.map(|side| contact_index(index, side)));
    let reports = wheels.flat_map(|wheel| snapshot.workspace.reports(wheel));
    let Some(report) = reports.filter(|report| report.normal_force > 0.0).max_by(|a, b| a.normal_force.total_cmp(&b.normal_force)) else {
        return Vec::new();
    };
    let speed = scene.vehicle.speed.abs();
    let contact = RollingContact {
        patch: report.patch,
        normal_force: report.normal_force,
        friction: model.laws.friction,
        creepage: Creepage { spin: report.creepage.spin, ..Creepage::default() },
        speed,
    };
    let mut all = Vec::new();
    let force = model.laws.creep.force(&contact).lateral.abs();
    if force > 0.0 && force.is_finite() {
        let words = format!(
            "phi = {} alone makes {} across in a wheel at the start, {:.1} % of N",
            plain(report.creepage.spin.abs(), "1/m"),
            sized(force, "N", 3),
            100.0 * force / report.normal_force
        );
        all.push(Neglected { effect: "spin creepage", words, value: force });
    }
    if speed > 0.0 && model.laws.transient.is_none() {
        let time = 2.0 * report.patch.a / speed;
        let words = format!("a patch is passed in 2a/V = {}: creep is steady for what changes more slowly", sized(time, "s", 3));
        all.push(Neglected { effect: "transient contact", words, value: time });
    }
    all
}
