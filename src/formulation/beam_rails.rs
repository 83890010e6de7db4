//! Wheels on rails that are beams (`rail_beam`): what each wheel feels of them, their rates, energy and rest.
//!
//! Under a wheel at x the rail has sunk by `u_z = phi(x) . q`, its material moves with `w = phi . q'`, and it is bent with the slope `u_s = phi' . q`; wheel and rail then stand
//! to each other as [`super::rail_motion`] says. That a wheel which climbs the slope while it carries the force F_z is held back by `-F_z u_s` keeps energy: `F_z (w + s' u_s)` goes in at
//! the wheel, `F_z w` arrives at the rail.
//!
//! *At rest* rails lie as the wheels' forces, if they were constant, would have left them after travelling for ever (`Ring::carried`): a start has no transient but that which sleepers
//! make of wheels that do not yet follow them.

use super::rail_beam::LaidRails;
use super::rail_scratch::RailScratch;
use super::resting_rails::{ROUNDS, RestingRail, SETTLED};
use super::step::{Step, WheelRef};
use super::travelling_track::RAIL_STATES;
use super::{ContactReport, Evaluation, EvaluationError, Model, Workspace};

use crate::mbs::system::SystemWorkspace;
use crate::mbs::tangent::RingPlan;
use nalgebra::{Vector2, Vector3};
use std::ops::Range;

/// A step goes over at most this part of a bay.
const PART_OF_BAY: f64 = 0.25;

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// How fast a body goes along the track, m/s.
fn travel(system: &SystemWorkspace, body: usize) -> f64 {
    system.stations.get(body).map_or(system.motions[body].speed, |station| station.travel)
}

impl Model {
    /// States of all rails that give way.
    pub(super) fn rail_state_count(&self) -> usize {
        match &self.beam {
            Some(beam) => self.contacts() * RAIL_STATES + 4 * beam.groups.len() * beam.ring.modes(),
            None => self.contacts() * self.rail_states(0).len(),
        }
    }

    /// q and q' of the rail under a contact in the state vector.
    fn ring_states(&self, beam: &LaidRails, contact: usize) -> [Range<usize>; 2] {
        let modes = beam.ring.modes();
        let rail = self.rail_of(beam, contact);
        let first = self.rails_begin() + self.contacts() * RAIL_STATES + 2 * rail * modes;
        [first..first + modes, first + modes..first + 2 * modes]
    }

    /// Rails are numbered as contacts are: group by group, left then right.
    pub(super) fn rail_of(&self, beam: &LaidRails, contact: usize) -> usize {
        2 * beam.seats[contact / 2].group + contact % 2
    }

    /// What the linearised system needs to know of all rails, and the pairs of bodies that they join.
    pub(super) fn ring_plans(&self, beam: &LaidRails) -> (Vec<RingPlan>, Vec<(usize, usize)>) {
        let (mut plans, mut pairs) = (Vec::new(), Vec::new());
        for group in &beam.groups {
            let bodies: Vec<usize> = group.iter().map(|wheelset| self.wheelsets[*wheelset].body).collect();
            for side in 0..2 {
                plans.push(RingPlan { first: self.ring_states(beam, 2 * group[0] + side)[0].start, bodies: bodies.clone() });
            }
            for (place, body) in bodies.iter().enumerate() {
                pairs.extend(bodies[..place].iter().map(|other| (*other, *body)));
            }
        }
        (plans, pairs)
    }

    /// Finds what the wheels feel of rails that are beams, with the bodies' motions in the workspace.
    #[inline]
    pub(super) fn feel_rails(&self, workspace: &mut Workspace, y: &[f64]) {
        if let Some(beam) = &self.beam {
            self.feel_beam(beam, workspace, y);
        }
    }

    #[inline(never)]
    fn feel_beam(&self, beam: &LaidRails, workspace: &mut Workspace, y: &[f64]) {
        let modes = beam.ring.modes();
        let RailScratch { shapes, slopes, under, local } = &mut workspace.rails;
        for (index, wheelset) in self.wheelsets.iter().enumerate() {
            let own = index * modes..(index + 1) * modes;
            let (shape, slope) = (&mut shapes[own.clone()], &mut slopes[own]);
            let distance = workspace.system.motions[wheelset.body].distance;
            beam.ring.shapes(distance, shape, slope);
            local[index] = beam.ring.left_out().shape(distance);
            let [phi, turn] = local[index];
            for contact in [2 * index, 2 * index + 1] {
                let [q, v] = self.ring_states(beam, contact).map(|range| &y[range]);
                let own = self.rail_states(contact).start;
                under[contact] = [dot(shape, q) + phi * y[own + 1], dot(shape, v) + phi * y[own + 3], dot(slope, q) + turn * y[own + 1]];
            }
        }
    }

    /// u, w and u_s of a rail that is a beam, in the track frame.
    pub(super) fn beam_under(&self, under: &[[f64; 3]], y: &[f64], contact: usize) -> Option<[Vector3<f64>; 3]> {
        let [sunk, sinking, slope] = *under.get(contact)?;
        let own = &y[self.rail_states(contact)];
        Some([Vector3::new(0.0, own[0], sunk), Vector3::new(0.0, own[2], sinking), Vector3::new(0.0, 0.0, slope)])
    }

    /// [`Model::rail_change`] where rails are beams: lateral and vertical displacement and velocity.
    pub(super) fn beam_change(&self, beam: &LaidRails, workspace: &Workspace, contact: usize, change: &[f64]) -> [[f64; 2]; 2] {
        let shape = workspace.rails.shape(contact / 2, beam.ring.modes());
        let [q, v] = self.ring_states(beam, contact).map(|range| &change[range]);
        let own = &change[self.rail_states(contact)];
        let [phi, _] = workspace.rails.local[contact / 2];
        [[own[0], phi * own[1] + dot(shape, q)], [own[2], phi * own[3] + dot(shape, v)]]
    }

    /// Writes the rates of the modes of rails that are beams.
    #[inline(never)]
    pub(super) fn beam_rates(&self, beam: &LaidRails, workspace: &Workspace, y: &[f64], dy: &mut [f64]) {
        let modes = beam.ring.modes();
        for group in &beam.groups {
            for contact in [2 * group[0], 2 * group[0] + 1] {
                let [q, v] = self.ring_states(beam, contact);
                let (dq, dv) = dy[q.start..v.end].split_at_mut(modes);
                beam.ring.rates(&y[q], &y[v], dq, dv);
            }
        }
        for WheelRef { contact, wheelset, .. } in self.wheels() {
            let force = workspace.wheel_force(contact, wheelset.body);
            let [_, rates] = self.ring_states(beam, contact);
            let shape = workspace.rails.shape(contact / 2, modes);
            dy[rates].iter_mut().zip(shape).for_each(|(rate, phi)| *rate -= phi * force.z);
        }
    }

    /// [`Model::weight_of_rail`] of the modes of rails that are beams: of their state number `own`.
    pub(super) fn weight_of_mode(&self, beam: &LaidRails, own: usize) -> f64 {
        let modes = beam.ring.modes();
        if own % (2 * modes) < modes { beam.ring.largest(own % (2 * modes)) } else { 0.0 }
    }

    /// [`Model::load_error`] of the waves that an error of the modes of rails sends along to the wheels on them: N' times what they displace.
    pub(super) fn wave_error(&self, workspace: &Workspace, error: &[f64]) -> f64 {
        /// Of a wave's displacement a wheel on its contact feels a part (the rail yields too), and steps' errors have changing signs.
        const FELT: f64 = 0.2;
        let Some(beam) = &self.beam else { return 0.0 };
        let mut largest: f64 = 0.0;
        for group in &beam.groups {
            for side in 0..2 {
                let [q, v] = self.ring_states(beam, 2 * group[0] + side).map(|range| &error[range]);
                let wave = beam.ring.wave(q, v);
                for own in group {
                    let pressed = workspace.reports(2 * own + side).filter(|report| report.normal_force > 0.0);
                    let load = |report: &ContactReport| {
                        FELT * (report.share * report.elastic_slope) * wave * self.per_allowed(&self.wheelsets[*own], report)
                    };
                    largest = pressed.map(load).fold(largest, f64::max);
                }
            }
        }
        largest
    }

    /// Stored energy of the modes of all rails, J, and the power that becomes heat, W.
    pub(super) fn beam_energy(&self, beam: &LaidRails, y: &[f64]) -> (f64, f64) {
        let (mut stored, mut heat) = (0.0, 0.0);
        for group in &beam.groups {
            for contact in [2 * group[0], 2 * group[0] + 1] {
                let [q, v] = self.ring_states(beam, contact).map(|range| &y[range]);
                let (own, lost) = beam.ring.energy(q, v);
                (stored, heat) = (stored + own, heat + lost);
            }
        }
        (stored, heat)
    }

    /// How long a step may last by the sleepers ahead, s.
    pub(super) fn longest_on_sleepers(&self, workspace: &Workspace) -> f64 {
        let Some(beam) = &self.beam else { return f64::INFINITY };
        let fastest = self.wheelsets.iter().map(|wheelset| travel(&workspace.system, wheelset.body).abs()).fold(0.0, f64::max);
        if fastest > 0.0 { PART_OF_BAY * beam.ring.bay().spacing / fastest } else { f64::INFINITY }
    }

    /// Adds to J c' - c'' what rails that are beams do as the vehicle travels on (see `moving_frame`): wheels turn with the whole (`motion`, `turned`: what that makes of forces),
    /// and meet other parts of the rail.
    pub(super) fn add_travel_on_beams(
        &self,
        beam: &LaidRails,
        workspace: &Workspace,
        place: WheelRef,
        turned: &[f64; 2],
        change: &mut [f64],
    ) {
        let WheelRef { contact, wheelset, .. } = place;
        let modes = beam.ring.modes();
        let [_, rates] = self.ring_states(beam, contact);
        let own = self.rail_states(contact);
        change[own.start + 2..own.end].iter_mut().zip(turned).for_each(|(own, turned)| *own += turned);
        let [phi, turn] = workspace.rails.local[contact / 2];
        let vertical = beam.under.vertical.mass * turned[1] / phi;
        let force = workspace.wheel_force(contact, wheelset.body).z * travel(&workspace.system, wheelset.body);
        change[own.start + 3] -= turn * force / beam.under.vertical.mass;
        let (shape, slope) = (workspace.rails.shape(contact / 2, modes), workspace.rails.slope(contact / 2, modes));
        for (own, (phi, slope)) in change[rates].iter_mut().zip(shape.iter().zip(slope)) {
            *own += phi * vertical - slope * force;
        }
    }

    /// How fast the rail under a wheel sinks, and that gets faster, by the wheel's travel alone: `s' u_s` and `s' w_s`.
    pub(super) fn met_by_travel(&self, beam: &LaidRails, workspace: &Workspace, place: WheelRef, y: &[f64]) -> [f64; 2] {
        let speed = travel(&workspace.system, place.wheelset.body);
        let slope = workspace.rails.slope(place.contact / 2, beam.ring.modes());
        let (own, turn) = (self.rail_states(place.contact).start, workspace.rails.local[place.contact / 2][1]);
        let [q, v] = self.ring_states(beam, place.contact).map(|range| dot(slope, &y[range]));
        [speed * (q + turn * y[own + 1]), speed * (v + turn * y[own + 3])]
    }
}

impl Step<'_> {
    /// [`Step::settle_rails`] where rails are beams: Newton's method wheel by wheel for the forces, with what a wheel's own force does to the rail under it.
    pub(super) fn settle_beams(&mut self, beam: &LaidRails, inputs: &[f64]) -> Result<usize, EvaluationError> {
        let model = self.model;
        let (modes, count) = (beam.ring.modes(), model.wheelsets.len());
        let mut dy = vec![0.0; self.y.len()];
        self.move_bodies();
        model.feel_rails(self.workspace, self.y);
        let mut carried = vec![vec![0.0; 2 * modes]; count];
        for (wheelset, carried) in model.wheelsets.iter().zip(&mut carried) {
            let distance = self.workspace.system.motions[wheelset.body].distance;
            let (q, v) = carried.split_at_mut(modes);
            beam.ring.carried(distance, travel(&self.workspace.system, wheelset.body), q, v);
        }
        let shapes: Vec<Vec<f64>> = (0..count).map(|index| self.workspace.rails.shape(index, modes).to_vec()).collect();
        let local = beam.under.vertical.stiffness;
        let shape = |index: usize| self.workspace.rails.local[index][0];
        let shaped: Vec<f64> = (0..count).map(shape).collect();
        let give = |index: usize| dot(&shapes[index], &carried[index][..modes]) + shaped[index] * shaped[index] / local;
        let own: Vec<f64> = (0..count).map(give).collect();
        let mut loads: Vec<f64> = model.wheels().map(|wheel| wheel.wheelset.static_wheel_load).collect();
        for contact in 0..model.contacts() {
            self.y[model.rail_states(contact)][2..].fill(0.0);
        }
        let mut rails = vec![RestingRail::default(); model.contacts()];
        for round in 1..=ROUNDS {
            for contact in 0..model.contacts() {
                let [q, v] = model.ring_states(beam, contact);
                self.y[q.start..v.end].fill(0.0);
            }
            for (contact, load) in loads.iter().enumerate() {
                self.y[model.rail_states(contact)][1] = -load * shaped[contact / 2] / local;
                let [q, v] = model.ring_states(beam, contact);
                self.y[q.start..v.end].iter_mut().zip(&carried[contact / 2]).for_each(|(state, by)| *state -= load * by);
            }
            let at = Evaluation { t: self.t, inputs, y: self.y, memory: self.memory };
            model.derivative(self.workspace, at, &mut dy)?;
            let mut moved: f64 = 0.0;
            let found: Vec<Vector3<f64>> =
                model.wheels().map(|wheel| self.workspace.wheel_force(wheel.contact, wheel.wheelset.body)).collect();
            for WheelRef { contact, wheelset, .. } in model.wheels() {
                let (force, give) = (found[contact], own[contact / 2]);
                let stiffness = Vector2::new(beam.under.lateral.stiffness, 1.0 / give);
                let lateral = model.rail_states(contact).start;
                // Other wheels' forces are as they were taken: near their places they change by little.
                let rest = Vector2::new(stiffness[0] * self.y[lateral] + force.y, force.z - loads[contact]);
                let slope = || self.workspace.pressed_slope(contact, wheelset.body, &stiffness);
                let change = rails[contact].next_move(rest, slope);
                self.y[lateral] += change.x;
                loads[contact] -= change.y / give;
                moved = moved.max(change.amax());
            }
            if moved < SETTLED {
                return Ok(round);
            }
        }
        Ok(ROUNDS)
    }
}
