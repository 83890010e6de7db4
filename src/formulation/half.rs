//! Half of a symmetric run (`effects.symmetry = "half"`): contacts of the right wheels are those of the left ones in a mirror.
//!
//! A vehicle whose left half is the mirror image of its right one, on straight track whose rails are mirror images too, under inputs that favour no side, runs with
//! y, yaw and roll of all bodies on its middle plane zero. There M = diag(1, -1, 1) maps the left wheel's contact onto the right one's:
//!
//! ```text
//! point, force, normal, e1: M v      moment: -M m      e2: -M e2 (axes stay right-handed)
//! creepage, slip and creep force: longitudinal as they are, lateral and spin with the other sign
//! wrench tangent by the left wheel's motion: S K_left, S = diag(1, -1, 1, -1, 1, -1)
//! ```
//!
//! (S K_left S by the right wheel's own motion is the same for symmetric motions. It is taken where axles twist; elsewhere it would make rounding grow, because what J then knows
//! of y and yaw the equations do not.)
//!
//! That these conditions hold is found out at the start: rails, wheels and laws by what they are, vehicle and elements by accelerations of the whole model in states that are
//! displaced symmetrically. What breaks the symmetry later (an input, a rail) ends the run: nothing pushes such a wheelset back.

use super::failure::Asymmetry;
use super::loading::WheelAt;
use super::{ContactFailure, ContactReport, Evaluation, EvaluationError, LEFT_FRICTION, Model, RIGHT_FRICTION, Wheelset, Workspace};
use crate::contact::creepage::{ContactAxes, CreepForce, Creepage, Slip};
use crate::geometry::Side;
use crate::geometry::profile::Profile;
use crate::mbs::body::{COORDINATES, HEIGHT, LATERAL, PITCH, ROLL, Wrench, YAW};
use crate::mbs::system::SystemWorkspace;
use crate::mbs::tangent::WrenchTangent;
use nalgebra::{Matrix6, Vector3, Vector6};

/// Coordinates that change their sign in the mirror.
const ODD: [usize; 3] = [LATERAL, YAW, ROLL];
const EVEN: [usize; 3] = [0, HEIGHT, PITCH];
const NAMES: [(usize, &str); COORDINATES] = [(0, "x"), (LATERAL, "y"), (HEIGHT, "z"), (YAW, "yaw"), (ROLL, "roll"), (PITCH, "pitch")];

/// What counts as none of y [m], yaw and roll [rad]: rounding of a run.
const NONE: f64 = 1e-8;
/// Of a start, whose steady state is found to some digits only.
const NONE_AT_START: f64 = 1e-7;
/// So near the middle a body belongs there, m.
const NEARLY: f64 = 0.05;
/// How far the track's Y axis may turn, rad.
const LEVEL: f64 = 1e-9;
/// Differences of profiles and rails that are none, m.
const ALIKE: f64 = 1e-9;
/// Places at which profiles are compared; so far ahead of the start rails are, m, and so far apart.
const PLACES: usize = 400;
const AHEAD: f64 = 500.0;
const APART: f64 = 0.25;
/// States in which accelerations are compared, how far they are from the start [m, rad; per s], and what counts as no difference, in parts of the largest.
const STATES: usize = 3;
const DISPLACED: [f64; 2] = [5e-5, 1e-2];
const SAME: f64 = 1e-7;
/// Accelerations of a run that count as symmetric: differences in parts of the largest, and in m/s2 or rad/s2.
const OF_LARGEST: f64 = 1e-9;
const LEAST: f64 = 1e-7;

/// Of a coordinate in the mirror.
fn sign(coordinate: usize) -> f64 {
    if ODD.contains(&coordinate) { -1.0 } else { 1.0 }
}

/// A vector in the mirror.
fn mirrored(v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(v.x, -v.y, v.z)
}

impl ContactReport {
    /// The same contact on the other side.
    fn in_mirror(&self) -> ContactReport {
        let ContactAxes { e1, e2, normal } = &self.axes;
        let (creepage, force, slip) = (self.creepage, self.creep_force, self.slip);
        ContactReport {
            wheel_point: mirrored(&self.wheel_point),
            axes: ContactAxes { e1: mirrored(e1), e2: -mirrored(e2), normal: mirrored(normal) },
            creepage: Creepage { lateral: -creepage.lateral, spin: -creepage.spin, ..creepage },
            creep_force: CreepForce { lateral: -force.lateral, spin_moment: -force.spin_moment, ..force },
            slip: Slip { lateral: -slip.lateral, spin: -slip.spin, ..slip },
            force: mirrored(&self.force),
            couple: -mirrored(&self.couple),
            iterations: 0,
            ..*self
        }
    }
}

/// What the left wheel's wrench tangent is for the right one: by the left wheel's motion where both are one body's, else by its own.
pub(super) fn tangent_in_mirror(left: &WrenchTangent, one_body: bool) -> WrenchTangent {
    let signs = Vector6::new(1.0, -1.0, 1.0, -1.0, 1.0, -1.0);
    let by = if one_body { Vector6::repeat(1.0) } else { signs };
    let turned = |matrix: &Matrix6<f64>| Matrix6::from_fn(|row, column| signs[row] * by[column] * matrix[(row, column)]);
    WrenchTangent { by_position: turned(&left.by_position), by_velocity: turned(&left.by_velocity) }
}

impl Model {
    /// Gives the right wheel of a wheelset the contacts of the left one, whose wrench is `left`.
    pub(super) fn mirror_wheel(&self, workspace: &mut Workspace, [from, to]: [usize; 2], turning: usize, left: &Wrench) {
        let count = workspace.further_contacts.len() / workspace.contacts.len();
        workspace.contacts[to] = workspace.contacts[from].in_mirror();
        for slot in 0..count {
            workspace.further_contacts[to * count + slot] = workspace.further_contacts[from * count + slot].in_mirror();
        }
        let wrench = &mut workspace.system.wrenches[turning];
        wrench.force += mirrored(&left.force);
        wrench.moment -= mirrored(&left.moment);
    }

    /// Is the wheelset of a left wheel still in the middle of rails that are mirror images?
    ///
    /// # Errors
    /// [`ContactFailure::SymmetryLost`].
    pub(super) fn check_half(&self, wheel: &WheelAt, inputs: &[f64]) -> Result<(), ContactFailure> {
        let WheelAt { wheelset, y, motion, .. } = *wheel;
        let q = self.system.coordinates(wheelset.body).start;
        let lost = |what, value| Err(ContactFailure::SymmetryLost { what, value });
        for (coordinate, name) in NAMES.into_iter().filter(|(coordinate, _)| ODD.contains(coordinate)) {
            if !(y[q + coordinate].abs() <= NONE) {
                return lost(name, y[q + coordinate]);
            }
        }
        if inputs[LEFT_FRICTION] != inputs[RIGHT_FRICTION] {
            return lost("the difference of its friction factors", inputs[LEFT_FRICTION] - inputs[RIGHT_FRICTION]);
        }
        let [lateral, vertical] = self.unlike(motion.distance);
        match () {
            () if lateral.abs() > ALIKE => lost("the rails' common lateral displacement", lateral),
            () if vertical.abs() > ALIKE => lost("the rails' difference in height", vertical),
            () => Ok(()),
        }
    }

    /// Makes the bodies' rates symmetric to the bit, which keeps rounding from growing where no contact pushes a wheelset back.
    ///
    /// # Errors
    /// [`ContactFailure::SymmetryLost`] where they are not nearly so.
    pub(super) fn level_rates(&self, system: &SystemWorkspace, t: f64, dy: &mut [f64]) -> Result<(), EvaluationError> {
        let Some(partners) = &self.half else { return Ok(()) };
        let velocities = COORDINATES * self.system.bodies.len();
        let largest = dy[velocities..2 * velocities].iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let most = OF_LARGEST * largest + LEAST;
        for place in twists(system) {
            if !(dy[place + 1].abs() <= most) {
                let what = "an acceleration of one wheel against the other, in rad/s2,";
                let lost = ContactFailure::SymmetryLost { what, value: dy[place + 1] };
                return Err(EvaluationError::new(t, &self.wheelsets[0], Side::Left, lost));
            }
            dy[place..place + 2].fill(0.0);
        }
        make_symmetric(partners, dy, |body, of_velocities, _, [apart, _]| {
            if !of_velocities || apart.abs() <= most {
                return Ok(());
            }
            let near = self.wheelsets.iter().find(|wheelset| wheelset.body == body).unwrap_or(&self.wheelsets[0]);
            let what = "an acceleration that favours a side, in m/s2 or rad/s2,";
            Err(EvaluationError::new(t, near, Side::Left, ContactFailure::SymmetryLost { what, value: apart }))
        })
    }

    /// How far the rails at `s` [m] are from mirror images, across and up, m.
    fn unlike(&self, s: f64) -> [f64; 2] {
        let rails = Side::BOTH.map(|side| self.track.rail(side));
        if !rails.iter().any(|rail| rail.deviates()) {
            return [0.0; 2];
        }
        let [left, right] = rails.map(|rail| rail.deviation(s));
        [0.5 * (left[0][0] + right[0][0]), left[1][0] - right[1][0]]
    }

    /// Computes one half from now on: the state `at` becomes symmetric to the bit.
    ///
    /// # Errors
    /// [`Asymmetry`] where the scene is not symmetric.
    pub fn halve(&mut self, workspace: &mut Workspace, at: Evaluation, start: &mut [f64]) -> Result<(), Asymmetry> {
        self.half = Some(self.find_asymmetry(workspace, at, start)?);
        Ok(())
    }

    fn find_asymmetry(&self, workspace: &mut Workspace, at: Evaluation, start: &mut [f64]) -> Result<Vec<usize>, Asymmetry> {
        if self.formulation.constrains() || self.formulation.states_per_contact() > 0 {
            return Err(Asymmetry::Formulation);
        }
        let beside = [
            (self.laws.transient.is_some(), "[contact.transient]"),
            (self.laws.friction_map.is_some(), "friction that varies along or across the rails"),
            (self.rail_motion, "\"rail_motion\" in interface.inputs"),
            (self.gives_way(), "track.flexibility"),
            (self.out_of_round.iter().any(Option::is_some), "a wheel out of round"),
        ];
        if let Some((_, what)) = beside.into_iter().find(|(there, _)| *there) {
            return Err(Asymmetry::Beside(what));
        }
        for Wheelset { name, left, right, .. } in &self.wheelsets {
            if !(alike(left.profile.as_ref(), right.profile.as_ref()) && (left.half_spacing - right.half_spacing).abs() < ALIKE) {
                return Err(Asymmetry::Wheels(name.clone()));
            }
        }
        let [left, right] = Side::BOTH.map(|side| self.track.rail(side));
        if !alike(left.profile.as_ref(), right.profile.as_ref()) {
            return Err(Asymmetry::RailProfiles);
        }
        for place in 0..(AHEAD / APART) as usize {
            let distance = start[0] + place as f64 * APART;
            if let Some(frame) = self.track.line().map(|line| line.frame(distance))
                && (frame.axes.column(1) - Vector3::y()).norm() > LEVEL
            {
                return Err(Asymmetry::Curve { distance });
            }
            let [lateral, vertical] = self.unlike(distance);
            if lateral.abs() > ALIKE || vertical.abs() > ALIKE {
                return Err(Asymmetry::Rails { distance, lateral, vertical });
            }
        }
        let partners = self.partners(start)?;
        self.level(&partners, start)?;
        self.compare_accelerations(workspace, at, &partners, start)?;
        Ok(partners)
    }

    /// Of each body the one that is its mirror image: itself on the middle plane.
    fn partners(&self, y: &[f64]) -> Result<Vec<usize>, Asymmetry> {
        let bodies = &self.system.bodies;
        let place = |body: usize| [0, LATERAL, HEIGHT].map(|i| y[self.system.coordinates(body).start + i]);
        let partner = |body: usize| {
            let [x, beside, z] = place(body);
            let like = |other: &usize| {
                let [x1, y1, z1] = place(*other);
                let same = (bodies[body].mass - bodies[*other].mass).abs() <= 1e-9 * bodies[body].mass;
                same && [x - x1, beside + y1, z - z1].iter().all(|difference| difference.abs() < 1e-5)
            };
            let other = if beside.abs() < 1e-5 { Some(body) } else { (0..bodies.len()).find(like) };
            // What stands a little beside the middle is meant to stand there.
            let own = other.or_else(|| (beside.abs() < NEARLY).then_some(body));
            own.ok_or_else(|| Asymmetry::Alone { body: bodies[body].name.clone(), y: beside })
        };
        (0..bodies.len()).map(partner).collect()
    }

    /// Makes the bodies' coordinates and velocities symmetric where they are nearly so.
    fn level(&self, partners: &[usize], y: &mut [f64]) -> Result<(), Asymmetry> {
        make_symmetric(partners, y, |body, _, coordinate, [apart, value]| {
            if apart.abs() <= NONE_AT_START {
                return Ok(());
            }
            Err(Asymmetry::Start { body: self.system.bodies[body].name.clone(), coordinate, value })
        })
    }

    /// In states that are displaced symmetrically, bodies are accelerated symmetrically.
    fn compare_accelerations(&self, workspace: &mut Workspace, at: Evaluation, partners: &[usize], start: &[f64]) -> Result<(), Asymmetry> {
        let Evaluation { t, inputs, memory, .. } = at;
        let velocities = COORDINATES * self.system.bodies.len();
        let (mut y, mut dy) = (start.to_vec(), vec![0.0; start.len()]);
        for state in 0..STATES {
            y.copy_from_slice(start);
            for (body, other) in partners.iter().enumerate() {
                let number = body.min(*other);
                for (first, size) in [0, velocities].into_iter().zip(DISPLACED) {
                    for (i, _) in NAMES.into_iter().filter(|(i, _)| EVEN.contains(i) || body != *other) {
                        let sign = if ODD.contains(&i) && body > *other { -1.0 } else { 1.0 };
                        // Numbers that have nothing to do with each other.
                        let random = ((((state * 97 + number) * COORDINATES + i + 7 * first) as f64) * 0.618_033_988_75).fract() - 0.5;
                        y[first + COORDINATES * body + i] += sign * size * random;
                    }
                }
            }
            // A state that can't be evaluated tells nothing.
            if self.derivative(workspace, Evaluation { t, inputs, y: &y, memory }, &mut dy).is_err() {
                continue;
            }
            let accelerations = &dy[velocities..2 * velocities];
            let turning = accelerations.iter().skip(PITCH).step_by(COORDINATES).fold(1e-3, |largest: f64, value| largest.max(value.abs()));
            if let Some(place) = twists(&workspace.system).find(|place| !(dy[place + 1].abs() <= SAME * turning)) {
                return Err(Asymmetry::Twist { share: dy[place + 1].abs() / turning });
            }
            let largest = |of: [usize; 3]| {
                let own = |(i, value): (usize, &f64)| of.contains(&(i % COORDINATES)).then_some(value.abs());
                accelerations.iter().enumerate().filter_map(own).fold(1e-3, f64::max)
            };
            let scales = [largest([0, LATERAL, HEIGHT]), largest([YAW, ROLL, PITCH])];
            for (body, other) in partners.iter().enumerate() {
                for (i, coordinate) in NAMES {
                    let apart = accelerations[COORDINATES * body + i] - sign(i) * accelerations[COORDINATES * other + i];
                    let share = apart.abs() / scales[usize::from(i > HEIGHT)];
                    if !(share <= SAME) {
                        return Err(Asymmetry::Accelerations { body: self.system.bodies[body].name.clone(), coordinate, share });
                    }
                }
            }
        }
        Ok(())
    }
}

/// Places of the twists of axles among the states; their rates follow them.
fn twists(system: &SystemWorkspace) -> impl Iterator<Item = usize> {
    let bodies = 2 * COORDINATES * system.bodies();
    system.twists.iter().map(move |axle| bodies + axle.state)
}

/// Makes bodies' coordinates and velocities, or their rates, symmetric to the bit. `check` is told of each value its body, whether it belongs to the velocities, its
/// coordinate, half its distance from its mirror image, and the value itself.
fn make_symmetric<E>(
    partners: &[usize],
    values: &mut [f64],
    check: impl Fn(usize, bool, &'static str, [f64; 2]) -> Result<(), E>,
) -> Result<(), E> {
    for (body, other) in partners.iter().enumerate() {
        for first in [0, COORDINATES * partners.len()] {
            for (i, coordinate) in NAMES {
                let (own, image) = (first + COORDINATES * body + i, first + COORDINATES * other + i);
                let apart = 0.5 * (values[own] - sign(i) * values[image]);
                check(body, first > 0, coordinate, [apart, values[own]])?;
                // Of a pair the second takes what the first one has.
                values[own] = if body == *other {
                    values[own] - apart
                } else if body < *other {
                    values[own]
                } else {
                    sign(i) * values[image]
                };
            }
        }
    }
    Ok(())
}

/// Are two profiles the same surface?
fn alike(one: &dyn Profile, other: &dyn Profile) -> bool {
    let ((first, last), range) = (one.range(), other.range());
    let same = |x: f64| (one.at(x).value - other.at(x).value).abs() < ALIKE;
    let place = |k: usize| first + (last - first) * k as f64 / PLACES as f64;
    (first - range.0).abs() < ALIKE && (last - range.1).abs() < ALIKE && (0..=PLACES).all(|k| same(place(k)))
}
