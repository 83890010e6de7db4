//! The books of a run, kept on its dense grid whatever the case.
//!
//! *Energy.* Stored: motion, height, springs. What goes in: contacts (their forces on the wheelset times the velocity of the wheel's
//! material there, which is what slip, damping and elastic deformation take away, and what a rail that rises gives), driving constraints,
//! inputs. Track that gives way has its own springs, masses and dampers in the books. Dissipated: dampers and friction elements. `stored(t) - stored(0) = integral of (in - dissipated)` holds for any
//! law of contact, so that what is left over is the error of the integration alone. It is told as a share of everything that was
//! exchanged, in and out, of what the static loads do over 1 mm (without which a wheelset at rest would be judged by rounding), and of
//! what creep of 2.5 % of the weight does over the way travelled (an imposed speed V makes V dF out of an error dF of a creep force: 1 % of
//! that is a mean error of 2.5e-4 of the weight, 25 N under a wheelset, where a step may be off by 0.2 % of each wheel load). Impacts are booked without the latter.
//!
//! *Vertical momentum.* The mean of all wheels' vertical forces is the weight, but for the change of momentum.
//!
//! *At every instant*: no contact pulls, creep forces stay within friction, rigid contacts are closed.
//!
//! *Vertical loads* are weight; their inertia along the track is stored energy and momentum. What holds a load in a curve does work and gives
//! momentum that nothing tells: there all elements count as outside.
//!
//! Integrals are Simpson's over pairs of samples.

use super::finding::{Finding, Unit};
use super::given::Audited;
use crate::formulation::events::{ContactChange, ContactEvent};
use crate::formulation::{
    DRIVE_TORQUE, LATERAL_FORCE, LEFT_FRICTION, LONGITUDINAL_FORCE, Model, VERTICAL_FORCE, WHEELSET_INPUTS, contact_index,
};
use crate::geometry::Side;
use crate::mbs::body::Wrench;
use crate::mbs::force::VerticalLoad;
use crate::scene::spec::Scene;
use crate::sim::Snapshot;
use nalgebra::Vector3;

/// What the static loads do over this is exchanged in any run, m.
const REST: f64 = 1e-3;
/// A rigid contact is closed to this, m.
const GAP: f64 = 1e-10;
/// Creep force beyond friction, over it: rounding of the laws.
const BEYOND: f64 = 1e-6;
/// A wheel that goes on elastically sinks by this into its rail before it carries what the rigid contact carried, m.
const SINK: f64 = 1e-4;
/// Friction of this size [N] is none.
const NO_FORCE: f64 = 1.0;

/// Rates and amounts at one instant.
#[derive(Clone, Copy, Debug, Default)]
struct Instant {
    time: f64,
    /// J.
    stored: f64,
    /// In less dissipated, W, and the sum of their sizes.
    power: f64,
    exchange: f64,
    /// N s, and what the rails and inputs do to it, N.
    momentum: f64,
    lift: f64,
    /// Of the leading wheelset, m/s.
    speed: f64,
}

/// The books of one run.
#[derive(Debug)]
pub struct Audit {
    allowed: Audited,
    /// N.
    weight: f64,
    mass: Vec<f64>,
    /// What is driven along a curved track does work that nothing tells (the suspension's frame, what a load stands for): its elements count
    /// as outside.
    driven_frame: bool,
    loads: Vec<VerticalLoad>,
    bounded_creep: bool,
    first: Option<Instant>,
    last: [Instant; 2],
    pending: usize,
    /// Integrals of power, exchange and lift.
    work: f64,
    exchanged: f64,
    impulse: f64,
    /// Travelled, m.
    way: f64,
    landings: f64,
    /// Largest static wheel load, N.
    heaviest: f64,
    /// Worst of each, with its time.
    energy: (f64, f64),
    pull: (f64, f64),
    gap: (f64, f64),
    beyond: (f64, f64),
    wrenches: Vec<Wrench>,
    rates: Vec<f64>,
}

impl Audit {
    pub fn new(scene: &Scene, model: &Model, allowed: Audited) -> Audit {
        let mass: Vec<f64> = model.system.bodies.iter().map(|body| body.mass).collect();
        let square = if scene.track.line.is_none() { scene.track.grade.cos() } else { 1.0 };
        let loads: Vec<f64> = scene.vehicle.wheelsets.iter().map(|placed| placed.spec.vertical_load).collect();
        let load = |(body, force): (usize, &f64)| VerticalLoad::new(body, *force, scene.vehicle.gravity, scene.track.grade);
        let own_weight = mass.iter().sum::<f64>() * scene.vehicle.gravity;
        let loaded = loads.iter().any(|load| *load != 0.0);
        let guided = scene.vehicle.forces.iter().any(|element| element.0.bodies().contains(&None));
        let zero = (0.0, 0.0);
        Audit {
            allowed,
            weight: (own_weight + loads.iter().sum::<f64>()) * square,
            driven_frame: scene.track.line.is_some() && (guided || loaded),
            loads: loads.iter().enumerate().map(load).collect(),
            bounded_creep: scene.contact.creep_name != "kalker_linear",
            first: None,
            last: [Instant::default(); 2],
            pending: 0,
            work: 0.0,
            exchanged: 0.0,
            impulse: 0.0,
            way: 0.0,
            landings: 0.0,
            heaviest: model.wheelsets.iter().map(|wheelset| wheelset.static_wheel_load).fold(0.0, f64::max),
            energy: zero,
            pull: zero,
            gap: zero,
            beyond: zero,
            wrenches: vec![Wrench::default(); model.workspace().system.wrenches.len()],
            rates: vec![0.0; model.system.force_states().len()],
            mass,
        }
    }

    /// Books a sample.
    pub fn push(&mut self, model: &Model, snapshot: &Snapshot) {
        self.look(model, snapshot);
        let now = self.instant(model, snapshot);
        let Some(first) = self.first else {
            (self.first, self.last) = (Some(now), [now; 2]);
            return;
        };
        self.pending += 1;
        if self.pending < 2 {
            self.last[1] = now;
            return;
        }
        // Three samples, not always at equal distances: the parabola through them.
        let [a, b] = self.last;
        let simpson = |rate: fn(&Instant) -> f64| parabola([a.time, b.time, now.time], [rate(&a), rate(&b), rate(&now)]);
        self.work += simpson(|at| at.power);
        self.exchanged += simpson(|at| at.exchange).abs();
        self.impulse += simpson(|at| at.lift);
        (self.last, self.pending) = ([now; 2], 0);
        let left = (now.stored - first.stored - self.work).abs() - self.landings;
        self.way += simpson(|at| at.speed).abs();
        let share = left.max(0.0) / (self.exchanged + (REST + self.allowed.way * self.way) * self.weight);
        keep(&mut self.energy, share, now.time);
    }

    /// Inputs have jumped since the last sample, which was booked with the old ones.
    pub fn restart(&mut self, model: &Model, snapshot: &Snapshot) {
        let [a, b] = self.last;
        if self.pending == 1 {
            let mean = |rate: fn(&Instant) -> f64| 0.5 * (b.time - a.time) * (rate(&a) + rate(&b));
            self.work += mean(|at| at.power);
            self.exchanged += mean(|at| at.exchange);
            self.impulse += mean(|at| at.lift);
        }
        (self.last, self.pending) = ([self.instant(model, snapshot); 2], 0);
    }

    /// Rigid contacts that were closed again: what that changed is known, and what the elastic contact held until then is not more than
    /// the work of the load over its penetration.
    pub fn note(&mut self, events: &[ContactEvent]) {
        for event in events {
            match event.change {
                ContactChange::Landed { penetration, energy, .. } => self.landings += energy.abs() + self.heaviest * penetration.abs(),
                ContactChange::Lifted | ContactChange::Vanished | ContactChange::Undecided => self.landings += self.heaviest * SINK,
                ContactChange::Touched { .. } | ContactChange::Parted { .. } => {}
            }
        }
    }

    fn look(&mut self, model: &Model, snapshot: &Snapshot) {
        for (index, wheelset) in model.wheelsets.iter().enumerate() {
            let motion = &snapshot.workspace.system.motions[wheelset.body];
            for (place, side) in Side::BOTH.into_iter().enumerate() {
                let factor = snapshot.inputs().get(WHEELSET_INPUTS * index + LEFT_FRICTION + place).unwrap_or(&1.0);
                for report in snapshot.workspace.reports(contact_index(index, side)) {
                    keep(&mut self.pull, -report.normal_force, snapshot.time);
                    if report.constrained {
                        keep(&mut self.gap, report.penetration.abs(), snapshot.time);
                    }
                    let own = || factor * model.friction_at(side, motion, report) * report.normal_force.max(0.0);
                    let bound = report.friction_bound.unwrap_or_else(own);
                    let creep = report.creep_force.longitudinal.hypot(report.creep_force.lateral);
                    if self.bounded_creep {
                        keep(&mut self.beyond, (creep - bound) / (bound + NO_FORCE), snapshot.time);
                    }
                }
            }
        }
    }

    fn instant(&mut self, model: &Model, snapshot: &Snapshot) -> Instant {
        let (workspace, system) = (&snapshot.workspace, &snapshot.workspace.system);
        let mut now = Instant { time: snapshot.time, ..Instant::default() };
        let mut book = |power: f64| {
            now.power += power;
            now.exchange += power.abs();
        };
        for (index, wheelset) in model.wheelsets.iter().enumerate() {
            let motion = &system.motions[wheelset.body];
            for side in Side::BOTH {
                let motion = &system.motions[wheelset.turning[side.index()]];
                let contact = contact_index(index, side);
                book(model.power_of_turns(workspace, (snapshot.inputs(), &snapshot.y), (index, side)));
                // Places are told as if a rail that has given way were where it was, and the wheel above it.
                let [sunk, sinking] = model.rail_change(workspace, wheelset.body, contact, &snapshot.y).unwrap_or_default();
                for report in workspace.reports(contact) {
                    let velocity = motion.material_velocity(&(report.wheel_point + sunk));
                    let spin = report.creep_force.spin_moment * report.axes.normal.dot(&motion.rotation);
                    book(report.force.dot(&velocity) + spin);
                    if model.gives_way() {
                        book(-report.force.dot(&sinking));
                    }
                }
            }
            let input = |local: usize| snapshot.inputs().get(WHEELSET_INPUTS * index + local).copied().unwrap_or(0.0);
            let local = Vector3::new(input(LONGITUDINAL_FORCE), input(LATERAL_FORCE), input(VERTICAL_FORCE));
            let force = system.stations.get(wheelset.body).map_or(local, |station| station.frame.axes * local);
            book(force.dot(&motion.velocity) + input(DRIVE_TORQUE) * motion.axle().dot(&motion.rotation));
            now.lift += force.z;
        }
        for (drive, force) in model.system.drives.iter().zip(&system.drive_forces) {
            let motion = &system.motions[drive.body];
            let along = system.stations.along(drive.body);
            book(force * along.dot(&motion.velocity));
            now.lift += force * along.z;
        }
        if self.driven_frame {
            now.stored = model.system.kinetic_energy(&system.motions);
            let (power, lift) = self.outside(model, snapshot);
            book(power);
            // A twist is a motion of its own, not one of a body that an element loads.
            for axle in &system.twists {
                let (force, states) = (&model.system.forces[axle.element], &snapshot.y[model.system.states_of_force(axle.element)]);
                now.stored += force.potential_energy(&system.moving(), states);
                book(-force.dissipated_power(&system.moving(), states));
            }
            // Across a canted track a suspension lifts too; weight is among its forces.
            now.lift += lift + self.weight;
        } else {
            now.stored = model.system.mechanical_energy(&snapshot.y, system);
            for (element, force) in model.system.forces.iter().enumerate() {
                let states = &snapshot.y[model.system.states_of_force(element)];
                let bodies = model.system.seen_by(element, system);
                book(force.supplied_power(&bodies, states) - force.dissipated_power(&bodies, states));
            }
        }
        let (stored, heat) = model.rail_energy(&snapshot.y);
        now.stored += stored;
        if model.gives_way() {
            book(-heat);
        }
        now.speed = model.wheelsets.first().map_or(0.0, |wheelset| system.motions[wheelset.body].velocity.norm());
        now.momentum = self.mass.iter().zip(&system.motions).map(|(mass, motion)| mass * motion.velocity.z).sum();
        // On straight level track neither has a part.
        for (load, station) in self.loads.iter().enumerate().filter_map(|(body, load)| Some((load, system.stations.get(body)?))) {
            now.momentum += load.mass * station.speed * station.frame.along().z;
            now.lift -= load.centrifugal(station).z;
        }
        now.lift += (0..model.contacts()).flat_map(|contact| workspace.reports(contact)).map(|report| report.force.z).sum::<f64>();
        now
    }

    /// Power of all force elements on the bodies, W, and their vertical force, N.
    fn outside(&mut self, model: &Model, snapshot: &Snapshot) -> (f64, f64) {
        let system = &snapshot.workspace.system;
        self.wrenches.fill(Wrench::default());
        let begin = model.system.force_states().start;
        for (element, force) in model.system.forces.iter().enumerate() {
            let range = model.system.states_of_force(element);
            let rates = &mut self.rates[range.start - begin..range.end - begin];
            force.apply(&model.system.seen_by(element, system), &snapshot.y[range], rates, &mut self.wrenches);
        }
        let pairs = self.wrenches.iter().zip(&system.motions);
        let power = pairs.map(|(wrench, motion)| wrench.force.dot(&motion.velocity) + wrench.moment.dot(&motion.rotation)).sum();
        (power, self.wrenches.iter().map(|wrench| wrench.force.z).sum())
    }

    /// Energy that nobody accounts for at worst, as a share.
    pub fn energy(&self) -> f64 {
        self.energy.0
    }

    /// How far the mean of all vertical forces is from the weight and the change of momentum, in parts of the weight.
    pub fn lifted(&self) -> f64 {
        let Some(first) = self.first else { return 0.0 };
        let (now, span) = (self.last[0], self.last[0].time - first.time);
        let left = self.impulse - self.weight * span - (now.momentum - first.momentum);
        if span > 0.0 { left.abs() / (self.weight * span) } else { 0.0 }
    }

    /// What the books say. `unbooked`: shares of energy and of weight that the grid can't tell.
    pub fn findings(&self, unbooked: [f64; 2]) -> Vec<Finding> {
        let at = |what: &str, time: f64| if time > 0.0 { format!("{what} at t = {time:.4} s") } else { what.to_string() };
        vec![
            Finding::new(at("energy from nowhere", self.energy.1), self.energy.0, self.allowed.energy.max(unbooked[0]), Unit::Share),
            Finding::new(at("pull of a contact", self.pull.1), self.pull.0.max(0.0), 0.0, Unit::Newton),
            Finding::new(at("creep force beyond friction", self.beyond.1), self.beyond.0.max(0.0), BEYOND, Unit::Share),
            Finding::new(at("gap of a rigid contact", self.gap.1), self.gap.0, GAP, Unit::Metre),
            Finding::new("mean of all Q against the weight", self.lifted(), self.allowed.weight.max(unbooked[1]), Unit::Share),
        ]
    }
}

/// The larger one, or what is no number.
fn keep(worst: &mut (f64, f64), value: f64, time: f64) {
    if value > worst.0 || value.is_nan() {
        *worst = (value, time);
    }
}

/// Integral of the parabola through three points over all of them.
fn parabola(t: [f64; 3], f: [f64; 3]) -> f64 {
    let (h, k) = (t[1] - t[0], t[2] - t[1]);
    if !(h > 0.0 && k > 0.0) {
        return 0.5 * (t[2] - t[0]) * (f[0] + f[2]);
    }
    let sum = h + k;
    sum / 6.0 * ((2.0 - k / h) * f[0] + sum * sum / (h * k) * f[1] + (2.0 - h / k) * f[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_parabolas_are_integrated_exactly() {
        let f = |t: f64| 3.0 - 2.0 * t + 5.0 * t * t;
        let whole = |t: f64| 3.0 * t - t * t + 5.0 / 3.0 * t.powi(3);
        for t in [[0.0, 1.0, 2.0], [1.0, 1.5, 2.7], [0.3, 1.9, 2.0]] {
            assert!((parabola(t, t.map(f)) - (whole(t[2]) - whole(t[0]))).abs() < 1e-12);
        }
    }
}
