//! Twists of axles as unknowns of their own beside the bodies.
//!
//! What acts on a wheel that turns against its axle is handed in as of a body of its own, whose coordinates are the axle's but for its pitch rate, `pitch' + f tau'`
//! ([`crate::mbs::twist`]). So its blocks are the axle's too, and their rows and columns of the pitch are those of the twist, times f. With the factor P = [`Twist::TIME`] and
//! w = P tau', the generalised force M of the twist and what M and the bodies' generalised forces Q change by:
//!
//! ```text
//! tau' = w / P,   w' = P / mu (M - k tau - c tau')
//! k_tau = r_tau + a k_w / P,   k_q = r_q + a k_v
//! (1 + a c / mu + a^2 k / mu - a M_tau' / mu) k_w - a P / mu (M_v + a M_q) k_v = r_w + a P / mu (M_q r_q - k r_tau)
//! bodies: - a M^-1 Q_tau' k_w / P
//! ```
//!
//! Left out: how masses under wheels and rails ([`super::follower`], [`super::ring`]) act on twists and the other way round (they act on the axle); as for bodies: that the axle on which moments are projected turns (moment of a wheel load over mu, 1e3 1/s2). Where J has the contacts alone (`imex`), k, c and `tau' = w / P` are left to the explicit part. First-order states that follow such a wheel are eliminated onto the twist as they are onto bodies.

use super::pattern::Neighbours;
use super::solve::Eliminated;
use super::sum::TangentSum;
use super::world::weigh;
use super::{BlockLu, Graph, Tangent};
use crate::mbs::body::COORDINATES;
use crate::mbs::pair_tangent::TwistTerms;
use crate::mbs::system::System;
use crate::mbs::twist::Twist;
use nalgebra::{Matrix6, Vector6};

/// Place of the pitch among a body's coordinates.
const PITCH: usize = COORDINATES - 1;

/// A body that acts on a twist, and the other way round.
#[derive(Clone, Debug)]
struct Near {
    body: usize,
    /// Places of the blocks (twist, body) and (body, twist).
    lower: usize,
    upper: usize,
    /// M by the body's coordinates and velocities.
    by_position: Vector6<f64>,
    by_velocity: Vector6<f64>,
    /// Accelerations of the body by tau'.
    acceleration: Vector6<f64>,
}

/// The twist of one axle.
#[derive(Clone, Debug)]
pub(super) struct TwistNode {
    element: usize,
    /// Index of tau in the state vector.
    state: usize,
    node: usize,
    pivot: usize,
    /// The axle first.
    near: Vec<Near>,
    twist: Twist,
    /// Are the force elements in J, and with them k, c and `tau' = w / P`?
    whole: bool,
    /// M by tau'.
    by_rate: f64,
}

/// Twists, and pairs of bodies and wheels that act on each other where at least one is a wheel.
pub(super) fn twists(system: &System) -> (Vec<TwistNode>, Vec<(usize, usize)>) {
    let (bodies, mut wheels) = (system.bodies.len(), Vec::new());
    let axles: Vec<_> = system.twisted_axles().collect();
    let mut found = Vec::new();
    for (number, axle) in axles.iter().enumerate() {
        let Some(twist) = system.forces[axle.element].twist() else { continue };
        let own = bodies + 2 * number..bodies + 2 * number + 2;
        let mut near = vec![axle.body];
        for wheel in own.clone() {
            wheels.push((wheel, wheel));
            for force in system.forces.iter().filter(|force| force.wheel() == Some(wheel)) {
                for carrier in force.bodies()[1].into_iter().filter(|carrier| !wheels.contains(&(wheel, *carrier))).collect::<Vec<_>>() {
                    wheels.extend([(wheel, carrier), (carrier, wheel)]);
                    near.push(carrier);
                }
            }
        }
        near.sort_unstable();
        near.dedup();
        let zero = Vector6::zeros();
        let near = near.into_iter().map(|body| Near { body, lower: 0, upper: 0, by_position: zero, by_velocity: zero, acceleration: zero });
        let (element, state) = (axle.element, 2 * COORDINATES * bodies + axle.state);
        found.push(TwistNode { element, state, node: 0, pivot: 0, near: near.collect(), twist, whole: false, by_rate: 0.0 });
    }
    (found, wheels)
}

impl TwistNode {
    /// Takes its place in the graph.
    pub fn join(&mut self, graph: &mut Graph, node: usize) {
        self.node = node;
        graph.edges.extend(self.near.iter().map(|near| (near.body, node)));
    }

    pub fn find_places(&mut self, lu: &BlockLu) {
        self.pivot = lu.place(self.node, self.node);
        for near in &mut self.near {
            (near.lower, near.upper) = (lu.place(self.node, near.body), lu.place(near.body, self.node));
        }
    }

    /// k and c, as far as J has them.
    fn elasticity(&self) -> [f64; 2] {
        if self.whole { [self.twist.stiffness, self.twist.damping] } else { [0.0; 2] }
    }

    fn near(&mut self, body: usize) -> Option<&mut Near> {
        self.near.iter_mut().find(|near| near.body == body)
    }
}

/// The body that a body or wheel belongs to, and the twist and f of a wheel.
fn of_wheel(twists: &[TwistNode], bodies: usize, neighbours: &[usize], index: usize) -> (usize, Option<(usize, f64)>) {
    match index.checked_sub(bodies) {
        None => (index, None),
        Some(wheel) => (neighbours[wheel / 2], Some((wheel / 2, twists[wheel / 2].twist.factors()[wheel % 2]))),
    }
}

impl Tangent {
    /// Takes the twists' present constants.
    pub(super) fn read_twists(&mut self, system: &System) {
        for own in &mut self.twists {
            if let Some(twist) = system.forces[own.element].twist() {
                own.twist = twist;
            }
        }
    }

    /// Are their own stiffness and damping part of J?
    pub(super) fn take_twists(&mut self, whole: bool) {
        self.twists.iter_mut().for_each(|own| own.whole = whole);
    }

    /// Hands what wheels have to their axles and twists; all is in terms of coordinates, states not yet in accelerations.
    pub(super) fn fold_wheels(&mut self) {
        if self.twists.is_empty() {
            return;
        }
        let Tangent { sum, twists, world, mobility, axles, .. } = self;
        let bodies = mobility.len();
        for own in twists.iter_mut() {
            own.by_rate = 0.0;
            for near in &mut own.near {
                (near.by_position, near.by_velocity, near.acceleration) = (Vector6::zeros(), Vector6::zeros(), Vector6::zeros());
            }
        }
        let TangentSum { neighbours, by_position, by_velocity, states, .. } = sum;
        for (slot, row, column) in neighbours.wheels() {
            let ((on, row), (by, column)) = (of_wheel(twists, bodies, axles, row), of_wheel(twists, bodies, axles, column));
            let (position, velocity) = (by_position[slot], by_velocity[slot]);
            let Some(base) = neighbours.slot(on, by) else { continue };
            by_position[base] += position;
            by_velocity[base] += velocity;
            if let Some(wheel) = world[slot] {
                let sum = world[base].get_or_insert_default();
                sum.by_position += wheel.by_position;
                sum.by_velocity += wheel.by_velocity;
            }
            if let Some((twist, factor)) = row {
                if let Some(near) = twists[twist].near(by) {
                    near.by_position += position.row(PITCH).transpose() * factor;
                    near.by_velocity += velocity.row(PITCH).transpose() * factor;
                }
                twists[twist].by_rate += column.map_or(0.0, |(_, other)| factor * other * velocity[(PITCH, PITCH)]);
            }
            if let Some((twist, factor)) = column
                && let Some(near) = twists[twist].near(on)
            {
                near.acceleration += velocity.column(PITCH) * factor;
            }
        }
        for state in states.iter_mut() {
            for end in 0..2 {
                let Some((body, Some((twist, factor)))) = state.ends[end].map(|index| of_wheel(twists, bodies, axles, index)) else {
                    continue;
                };
                state.ends[end] = Some(body);
                let [rate, load] = [&state.rate_by_velocity, &state.load_by_state].map(|of| [0, 1].map(|i| factor * of[i][end][PITCH]));
                state.twist = Some(TwistTerms { twist, rate, load });
            }
        }
    }

    /// Turns what twists do to bodies into accelerations.
    pub(super) fn weigh_twists(&mut self) {
        for near in self.twists.iter_mut().flat_map(|own| &mut own.near) {
            weigh(&self.mobility[near.body], &mut near.acceleration.data.0[0]);
        }
    }

    /// The twists' part of J x.
    pub(super) fn add_twists_times(&self, x: &[f64], result: &mut [f64]) {
        let count = COORDINATES * self.mobility.len();
        for own in &self.twists {
            let [stiffness, damping] = own.elasticity();
            let (twist, rate) = (x[own.state], x[own.state + 1] / Twist::TIME);
            let mut moment = (own.by_rate - damping) * rate - stiffness * twist;
            for near in &own.near {
                let at = COORDINATES * near.body..COORDINATES * (near.body + 1);
                for i in 0..COORDINATES {
                    moment += near.by_position[i] * x[at.start + i] + near.by_velocity[i] * x[count + at.start + i];
                    result[count + at.start + i] += near.acceleration[i] * rate;
                }
            }
            (result[own.state], result[own.state + 1]) = (if own.whole { rate } else { 0.0 }, Twist::TIME / own.twist.inertia() * moment);
        }
        for state in &self.sum.states {
            let Some(TwistTerms { twist, rate, load }) = &state.twist else { continue };
            let own = &self.twists[*twist];
            for i in 0..state.count {
                result[state.index(i)] += rate[i] * x[own.state + 1] / Twist::TIME;
                result[own.state + 1] += Twist::TIME / own.twist.inertia() * load[i] * x[state.index(i)];
            }
        }
    }

    /// The twists' blocks in I - a J; before states are eliminated.
    pub(super) fn add_twist_blocks(&mut self, a: f64) {
        for own in &self.twists {
            let ([stiffness, damping], mu) = (own.elasticity(), own.twist.inertia());
            let mut pivot = Matrix6::identity();
            pivot[(0, 0)] += a * (damping + a * stiffness - own.by_rate) / mu;
            *self.lu.block_mut(own.pivot) = pivot;
            for near in &own.near {
                let row = (near.by_velocity + near.by_position * a) * (-a * Twist::TIME / mu);
                self.lu.block_mut(near.lower).set_row(0, &row.transpose());
                self.lu.block_mut(near.upper).set_column(0, &(near.acceleration * (-a / Twist::TIME)));
            }
        }
    }

    /// What eliminated states make of the twists that they follow.
    pub(super) fn eliminate_onto_twists(&mut self, a: f64) {
        for (state, own) in self.sum.states.iter().zip(&mut self.eliminated) {
            let Some(TwistTerms { twist, rate, load }) = &state.twist else { continue };
            let node = &self.twists[*twist];
            own.twist_change = [0, 1].map(|i| a * rate[i] / Twist::TIME);
            own.twist_acceleration = [0, 1].map(|i| a * Twist::TIME / node.twist.inertia() * load[i]);
            let Eliminated { inverse, change, acceleration, twist_change, twist_acceleration, .. } = own;
            for i in 0..state.count {
                for j in 0..state.count {
                    let weight = -inverse[(i, j)];
                    self.lu.block_mut(node.pivot)[(0, 0)] += weight * twist_acceleration[i] * twist_change[j];
                    for (end, body) in state.ends.iter().enumerate() {
                        let Some(near) = body.and_then(|body| node.near.iter().find(|near| near.body == body)) else { continue };
                        for k in 0..COORDINATES {
                            self.lu.block_mut(near.lower)[(0, k)] += weight * twist_acceleration[i] * change[j][end][k];
                            self.lu.block_mut(near.upper)[(k, 0)] += weight * acceleration[i][end][k] * twist_change[j];
                        }
                    }
                }
            }
        }
    }

    /// Right-hand sides of the twists, from the coordinates' and, behind them, the states'.
    pub(super) fn start_twists(&mut self, positions: &[f64], rest: &[f64]) {
        let (a, count) = (self.a, COORDINATES * self.mobility.len());
        for own in &self.twists {
            let mut moment = -own.elasticity()[0] * rest[own.state - count];
            for near in &own.near {
                let moved = &positions[COORDINATES * near.body..];
                moment += near.by_position.iter().zip(moved).map(|(by, moved)| by * moved).sum::<f64>();
            }
            let mut right = Vector6::zeros();
            right[0] = rest[own.state + 1 - count] + a * Twist::TIME / own.twist.inertia() * moment;
            self.x[own.node] = right;
        }
    }

    /// What states make of the twists' right-hand sides, as [`Tangent::start_twists`] left them.
    pub(super) fn push_twists(&mut self) {
        for (state, own) in self.sum.states.iter().zip(&self.eliminated) {
            let Some(TwistTerms { twist, .. }) = &state.twist else { continue };
            let right = &mut self.x[self.twists[*twist].node];
            right[0] += (0..state.count).map(|i| own.twist_acceleration[i] * own.known[i]).sum::<f64>();
        }
    }

    /// The rate of the twist that a state follows, found.
    pub(super) fn found_twist(&self, twist: &TwistTerms) -> f64 {
        self.x[self.twists[twist.twist].node][0]
    }

    /// Puts the twists that were found into the solution.
    pub(super) fn end_twists(&self, rest: &mut [f64]) {
        let count = COORDINATES * self.mobility.len();
        for own in &self.twists {
            let rate = self.x[own.node][0];
            rest[own.state + 1 - count] = rate;
            rest[own.state - count] += if own.whole { self.a * rate / Twist::TIME } else { 0.0 };
        }
    }
}

/// By twist: its axle.
pub(super) fn axles(system: &System) -> Vec<usize> {
    system.twisted_axles().map(|axle| axle.body).collect()
}

/// Bodies of pairs that wheels act on, as bodies: their blocks must exist.
pub(super) fn joined(system: &System, wheels: &[(usize, usize)]) -> Vec<(usize, usize)> {
    let (bodies, axles) = (system.bodies.len(), axles(system));
    let body = |index: usize| index.checked_sub(bodies).map_or(index, |wheel| axles[wheel / 2]);
    wheels.iter().map(|(row, column)| (body(*row), body(*column))).collect()
}

impl Neighbours {
    /// Slots of pairs with a wheel, with row and column among bodies and wheels.
    pub fn wheels(&self) -> impl Iterator<Item = (usize, usize, usize)> {
        let first = self.of_bodies();
        self.with_wheels.iter().enumerate().map(move |(i, (row, column))| (first + i, *row, *column))
    }
}
