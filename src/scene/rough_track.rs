//! Where rigid rails say too much of wheel loads: rough track at speed.
//!
//! A wheel of unsprung mass M that follows a wave of the rail with circular frequency w needs the force `M w^2 z` on rigid rails. On track of mass m and stiffness k
//! (`formulation::travelling_track`) it is less or more by `(k - m w^2) / (k - (m + M) w^2)`: 10 % more at a third of the P2 frequency f2, and beyond f2 the track
//! takes most of it. So track that gives way is recommended where both hold:
//!
//! * the shortest wave L that the vehicle meets is felt with `V / L >= f2 / 3`,
//! * rigid rails would make dynamic wheel forces of `M V^2 rms(z'') >= 0.1 Q`, Q the static wheel load, z'' the rails' vertical curvature over the run.

use super::spec::Scene;
use super::start;
use crate::formulation::Model;
use crate::formulation::travelling_track::TravellingTrack;
use crate::geometry::Side;

/// Of f2, and of the static wheel load.
const FREQUENCY: f64 = 1.0 / 3.0;
const FORCE: f64 = 0.1;
/// Samples in a shortest wave, and at most in all.
const PER_WAVE: f64 = 8.0;
const MOST: usize = 20_000;

/// What `wheelrail plan` recommends, if anything.
pub fn note(scene: &Scene, model: &Model) -> Option<String> {
    if model.gives_way() || scene.track.deviations.is_empty() {
        return None;
    }
    let speed = scene.vehicle.speed;
    let begin = start::origin(scene);
    let end = begin + speed * scene.run.stop;
    let (from, to) = (begin.min(end), begin.max(end));
    let rails = Side::BOTH.map(|side| model.track.rail(side));
    let met = rails.iter().flat_map(|rail| rail.waves().cells()).filter(|cell| cell.from < to && cell.to > from);
    let shortest = met.map(|cell| cell.wave).fold(f64::INFINITY, f64::min);
    let heaviest = model.wheelsets.iter().max_by(|a, b| {
        let of = |wheelset: &crate::formulation::Wheelset| model.system.bodies[wheelset.body].mass / wheelset.static_wheel_load;
        of(a).total_cmp(&of(b))
    })?;
    let (mass, load) = (model.system.bodies[heaviest.body].mass, heaviest.static_wheel_load);
    let p2 = TravellingTrack::default().p2_frequency(mass);
    let felt = speed.abs() / shortest;
    if !(felt >= FREQUENCY * p2) {
        return None;
    }
    let count = ((to - from) / shortest * PER_WAVE).clamp(1.0, MOST as f64) as usize;
    let place = |index: usize| from + (to - from) * (index as f64 + 0.5) / count as f64;
    let squares: f64 = (0..count).flat_map(|index| rails.map(|rail| rail.deviation(place(index))[1][2].powi(2))).sum();
    let force = 0.5 * mass * speed * speed * (squares / (2 * count) as f64).sqrt();
    (force >= FORCE * load).then(|| {
        format!(
            "rails are rough: their shortest wave of {shortest:.2} m is felt with {felt:.0} Hz, a third or more of the {p2:.0} Hz with which wheels swing on usual track, and on rigid rails the unsprung mass alone makes {:.0} % of the static wheel load (root mean square); track.flexibility = \"travelling\" lets the track give way",
            100.0 * force / load
        )
    })
}

/// Share of the static load that unsprung masses on rigid rails may add (rms) without a word.
const ROUGH: f64 = 0.3;
/// How far is looked, m, spacing, and readings of a stretch.
const AHEAD: f64 = 500.0;
pub(super) const SPACING: f64 = 0.1;
const STRETCH: usize = 500;

/// Distances along the track that are looked at, m, from where the run begins.
pub(super) fn places_ahead(scene: &Scene) -> impl ExactSizeIterator<Item = f64> {
    let (speed, begin) = (scene.vehicle.speed, start::origin(scene));
    let count = (AHEAD.min(scene.run.stop * speed.abs()) / SPACING) as usize;
    (0..count).map(move |i| begin + speed.signum() * SPACING * i as f64)
}

/// Cross level of displaced rails without a word, m. Irregularities have some millimetres; a ramp of this height may be meant as cant.
const TILTED: f64 = 0.03;

/// Rails are shifted, not turned: what a cross level of this size leaves out.
pub fn tilted(scene: &Scene, model: &Model) -> Option<String> {
    let [left, right] = Side::BOTH.map(|side| model.track.rail(side));
    let level = |place: f64| left.deviation(place)[1][0] - right.deviation(place)[1][0];
    let (place, highest) = places_ahead(scene).map(|place| (place, level(place))).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let tilt = highest / left.spacing(right);
    (highest.abs() > TILTED).then(|| {
        format!(
            "track: displacements of the rails make a cross level of {:.0} mm (at {place:.0} m). Displaced rails do not turn with it: {:.0} mrad are left out of their inclination, which moves contacts and \
             makes lateral forces of their own; cant is superelevation in track.node",
            1e3 * highest,
            1e3 * tilt.abs()
        )
    })
}

/// What a run should say: a rail of the height l(s) under a wheel at speed V accelerates it by `V^2 l''`; half the wheelset's mass times that adds to the wheel's load,
/// where nothing yields. Of track that does yield nothing is said.
pub fn on_rigid_rails(scene: &Scene, model: &Model) -> Option<String> {
    let speed = scene.vehicle.speed;
    if model.gives_way() || places_ahead(scene).len() < 10 || Side::BOTH.iter().all(|side| !model.track.rail(*side).deviates()) {
        return None;
    }
    let squared = |place: f64| 0.5 * Side::BOTH.iter().map(|side| model.track.rail(*side).deviation(place)[1][2].powi(2)).sum::<f64>();
    let all: Vec<f64> = places_ahead(scene).map(squared).collect();
    // The roughest stretch: others may be smooth.
    let roughest = all.chunks(STRETCH).map(|some| some.iter().sum::<f64>() / some.len().max(STRETCH / 2) as f64).fold(0.0, f64::max);
    let acceleration = speed * speed * roughest.sqrt();
    let share = model.wheelsets.iter().map(|wheelset| 0.5 * model.system.bodies[wheelset.body].mass / wheelset.static_wheel_load);
    let added = acceleration * share.fold(0.0, f64::max);
    (added > ROUGH && added.is_finite()).then(|| {
        format!(
            "the rails accelerate wheels by {acceleration:.1} m/s2 (rms over {:.0} m at {speed} m/s): on rigid rails that adds {:.0} % of the static load (rms), \
             and wheels lift at peaks. Real track yields; such loads are mostly too high",
            SPACING * STRETCH as f64,
            100.0 * added
        )
    })
}
