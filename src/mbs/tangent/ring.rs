//! Wheels on a common rail, a ring of modes (`mbs::ring`): modes, what is under each wheel, and tangential states are eliminated together, before the bodies.
//!
//! A wheel c stands on a mass on springs as [`super::follower`] says, which vertically stands on the rail: it feels d = phi_c . q and s = phi_c . q' more. With `H = (1 + a C + a^2 omega^2)^-1`, phi_c held,
//! and R_c the change of the vertical force that it presses down with less (so on the wheel, up)
//!
//! ```text
//! q' part:  k = h - a H sum_c phi_c R_c,   h = H (r' - a omega^2 r)      (r, r': right-hand sides of q and q'; q part: r + a k)
//! s_c + a sum_e G_ce R_e = phi_c . h,   d_c - a s_c = phi_c . r,   G_ce = phi_c . H phi_e
//! ```
//!
//! so that each wheel has those of its follower and d and s as states, and those of all wheels of a ring are one dense block, coupled by G.
//! Left out of J: that shapes change as the wheels travel (the moving frame brings it, see `formulation::moving_frame`), and how the climb along a bent rail changes with q.

use super::follower::{Block, Follower, OWN, factorise};
use super::{SingularTangent, Tangent, WrenchTangent};
use crate::mbs::pair_tangent::pair::add_outer;
use crate::mbs::ring::Ring;
use nalgebra::{Vector3, Vector6};
use std::sync::Arc;

/// Places of d and s among the states of a wheel, behind those of its mass, and number of all these.
const SUNK: usize = OWN;
const SINKING: usize = OWN + 1;
const BEFORE: usize = OWN + 2;
/// Those of the mass's vertical deflection and its rate.
const VERTICAL: usize = 1;
const VERTICAL_RATE: usize = 3;

/// One rail and the bodies whose wheels stand on it; its states q and q' begin at `first` in the state vector.
#[derive(Clone, Debug)]
pub struct RingPlan {
    pub first: usize,
    pub bodies: Vec<usize>,
}

/// All rails, which are alike.
#[derive(Clone, Debug)]
pub(super) struct Rings {
    ring: Arc<Ring>,
    /// Of H^-1.
    factors: Vec<f64>,
    rails: Vec<Rail>,
}

#[derive(Clone, Debug)]
struct Rail {
    first: usize,
    wheels: Vec<Block>,
    /// phi by wheel, and H phi.
    shapes: Vec<f64>,
    moved: Vec<f64>,
    /// Where the states of each wheel begin among all, and their number.
    begins: Vec<usize>,
    compliance: Vec<f64>,
    factors: Vec<f64>,
    pivots: Vec<usize>,
    /// By body, then state.
    solved: Vec<Vector6<f64>>,
    known: Vec<f64>,
    /// h, and what a right-hand side is put together in.
    free: Vec<f64>,
    scratch: Vec<f64>,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Rings {
    pub fn wheels_mut(&mut self) -> impl Iterator<Item = &mut Block> {
        self.rails.iter_mut().flat_map(|rail| &mut rail.wheels)
    }
}

impl Rail {
    fn new(plan: &RingPlan, modes: usize, most: usize) -> Rail {
        let count = plan.bodies.len();
        let states = count * most;
        Rail {
            first: plan.first,
            wheels: (0..count).map(|_| Block::new(most)).collect(),
            shapes: vec![0.0; count * modes],
            moved: vec![0.0; count * modes],
            begins: Vec::with_capacity(count + 1),
            compliance: vec![0.0; count * count],
            factors: Vec::with_capacity(states * states),
            pivots: Vec::with_capacity(states),
            solved: Vec::with_capacity(count * states),
            known: Vec::with_capacity(states),
            free: vec![0.0; modes],
            scratch: vec![0.0; modes],
        }
    }

    fn states(&self) -> usize {
        self.begins.last().copied().unwrap_or_default()
    }

    /// Factorises the block of all wheels' states; `false` where it is singular.
    fn factorise(&mut self, ring: &Ring, factors: &[f64], a: f64) -> bool {
        let (modes, count) = (ring.modes(), self.wheels.len());
        self.begins.clear();
        self.begins.push(0);
        for wheel in &self.wheels {
            let next = self.states() + wheel.states.len();
            self.begins.push(next);
        }
        self.moved.copy_from_slice(&self.shapes);
        for (row, moved) in self.moved.chunks_exact_mut(modes).enumerate() {
            ring.solve(factors, moved);
            for (column, shape) in self.shapes.chunks_exact(modes).enumerate() {
                self.compliance[row * count + column] = dot(shape, moved);
            }
        }
        let size = self.states();
        self.factors.clear();
        self.factors.resize(size * size, 0.0);
        for (own, wheel) in self.wheels.iter().enumerate() {
            let (begin, inside) = (self.begins[own], wheel.states.len());
            for (i, row) in wheel.own.chunks_exact(inside).enumerate() {
                for (j, value) in row.iter().enumerate() {
                    if i != SINKING {
                        self.factors[(begin + i) * size + begin + j] = -a * value;
                        continue;
                    }
                    for (felt, at) in self.begins[..count].iter().enumerate() {
                        self.factors[(at + SINKING) * size + begin + j] = -a * self.compliance[felt * count + own] * value;
                    }
                }
            }
        }
        for i in 0..size {
            self.factors[i * size + i] += 1.0;
        }
        if !factorise(&mut self.factors, size, &mut self.pivots) {
            return false;
        }
        self.solved.clear();
        self.solved.resize(count * size, Vector6::zeros());
        for (own, wheel) in self.wheels.iter().enumerate() {
            let solved = &mut self.solved[own * size..(own + 1) * size];
            for (i, (position, velocity)) in wheel.by_position.iter().zip(&wheel.by_velocity).enumerate() {
                let change = (position * a + velocity) * a;
                if i != SINKING {
                    solved[self.begins[own] + i] = change;
                    continue;
                }
                for (felt, at) in self.begins[..count].iter().enumerate() {
                    solved[at + SINKING] = change * self.compliance[felt * count + own];
                }
            }
            Block::solve(&self.factors, &self.pivots, solved);
        }
        true
    }

    /// What states change by without the bodies' velocities.
    fn reduce(&mut self, ring: &Ring, factors: &[f64], a: f64, (positions, rest, count): (&[f64], &[f64], usize)) {
        let (modes, wheels) = (ring.modes(), self.wheels.len());
        let (q, v) = rest[self.first - count..][..2 * modes].split_at(modes);
        for ((free, square), (q, v)) in self.free.iter_mut().zip(ring.squares()).zip(q.iter().zip(v)) {
            *free = v - a * square * q;
        }
        ring.solve(factors, &mut self.free);
        self.known.clear();
        for (wheel, shape) in self.wheels.iter().zip(self.shapes.chunks_exact(modes)) {
            let own = Vector6::from_column_slice(&positions[6 * wheel.body..6 * wheel.body + 6]);
            for (i, (state, by)) in wheel.states.iter().zip(&wheel.by_position).enumerate() {
                self.known.push(match i {
                    SUNK => dot(shape, q) + a * by.dot(&own),
                    SINKING => dot(shape, &self.free),
                    _ => rest[state - count] + a * by.dot(&own),
                });
            }
        }
        for (other, wheel) in self.wheels.iter().enumerate() {
            let own = Vector6::from_column_slice(&positions[6 * wheel.body..6 * wheel.body + 6]);
            let moved = a * wheel.by_position[SINKING].dot(&own);
            for (felt, at) in self.begins[..wheels].iter().enumerate() {
                self.known[at + SINKING] += self.compliance[felt * wheels + other] * moved;
            }
        }
        Block::solve(&self.factors, &self.pivots, &mut self.known);
    }

    /// States from the velocities that were found.
    fn restore(&mut self, ring: &Ring, factors: &[f64], a: f64, (positions, rest, count): (&[f64], &mut [f64], usize)) {
        let (modes, size) = (ring.modes(), self.states());
        for (other, wheel) in self.wheels.iter().enumerate() {
            let own = Vector6::from_column_slice(&rest[6 * wheel.body..6 * wheel.body + 6]);
            let solved = &self.solved[other * size..(other + 1) * size];
            self.known.iter_mut().zip(solved).for_each(|(known, solved)| *known += solved.dot(&own));
        }
        self.scratch.fill(0.0);
        for (number, wheel) in self.wheels.iter().enumerate() {
            let states = &self.known[self.begins[number]..self.begins[number + 1]];
            let velocity = Vector6::from_column_slice(&rest[6 * wheel.body..6 * wheel.body + 6]);
            let position = Vector6::from_column_slice(&positions[6 * wheel.body..6 * wheel.body + 6]) + velocity * a;
            let row = &wheel.own[SINKING * states.len()..(SINKING + 1) * states.len()];
            let pressed = dot(row, states) + wheel.by_position[SINKING].dot(&position) + wheel.by_velocity[SINKING].dot(&velocity);
            for (sum, shape) in self.scratch.iter_mut().zip(&self.shapes[number * modes..]) {
                *sum += a * pressed * shape;
            }
            for (i, (state, value)) in wheel.states.iter().zip(states).enumerate() {
                if i != SUNK && i != SINKING {
                    rest[state - count] = *value;
                }
            }
        }
        ring.solve(factors, &mut self.scratch);
        let (q, v) = rest[self.first - count..][..2 * modes].split_at_mut(modes);
        for ((q, v), (free, pressed)) in q.iter_mut().zip(v).zip(self.free.iter().zip(&self.scratch)) {
            *v = free + pressed;
            *q += a * *v;
        }
    }
}

/// The contact feels the rail under its mass as it feels the mass, and the rail takes what presses the mass, but not what holds that.
fn feel_rail(block: &mut Block) {
    let (count, follower) = (block.states.len(), block.mass);
    let [mass, stiffness, damping] = [follower.mass[1], follower.stiffness[1], follower.damping[1]];
    // The mass may count by a shape.
    let shape = follower.axes[1].norm();
    const FELT: [(usize, usize); 2] = [(VERTICAL, SUNK), (VERTICAL_RATE, SINKING)];
    block.own[SUNK * count + SINKING] = 1.0;
    for (own, felt) in FELT {
        block.load[felt] = block.load[own] / shape;
        for row in (0..count).filter(|row| ![VERTICAL, SUNK, SINKING].contains(row)) {
            let held = if row == VERTICAL_RATE { [stiffness, damping][felt - SUNK] / mass } else { 0.0 };
            block.own[row * count + felt] = (block.own[row * count + own] + held) / shape;
        }
    }
    for column in 0..count {
        let (felt, by) = FELT.iter().find(|(own, _)| *own == column).map_or((column, 1.0), |(_, felt)| (*felt, shape));
        block.own[SINKING * count + column] = mass / shape * by * block.own[VERTICAL_RATE * count + felt];
    }
    block.by_position[SINKING] = block.by_position[VERTICAL_RATE] * (mass / shape);
    block.by_velocity[SINKING] = block.by_velocity[VERTICAL_RATE] * (mass / shape);
}

impl Tangent {
    /// Makes room for rails that are all like `ring`, with at most `further` states of each wheel's contacts.
    pub fn with_rings(mut self, ring: &Arc<Ring>, plans: &[RingPlan], further: usize) -> Tangent {
        let rails = plans.iter().map(|plan| Rail::new(plan, ring.modes(), BEFORE + further)).collect();
        self.rings = Some(Rings { ring: ring.clone(), factors: Vec::with_capacity(ring.factor_room()), rails });
        self
    }

    /// Adds the wheel number `place` of a rail: like [`Tangent::add_follower`], its mass on what the rail is of; `shape`: phi at its place.
    pub fn add_on_ring(
        &mut self,
        (rail, place): (usize, usize),
        follower: &Follower,
        wrench: &WrenchTangent,
        before: usize,
        shape: &[f64],
    ) {
        let taken = self.sum.states.len() - before;
        let Some(rail) = self.rings.as_mut().and_then(|rings| rings.rails.get_mut(rail)) else { return };
        let block = &mut rail.wheels[place];
        block.begin(follower.body, BEFORE + taken);
        block.take_mass(follower, wrench);
        for (own, state) in self.sum.states[before..].iter().enumerate() {
            block.take_state(BEFORE + own, state, follower);
        }
        self.sum.states.truncate(before);
        feel_rail(block);
        rail.shapes[place * shape.len()..(place + 1) * shape.len()].copy_from_slice(shape);
    }

    /// How u'' of the mass under a wheel changes with a motion of its body, as in [`Tangent::follower_accelerations`], and with sinking of the rail by `sunk` [m] and its rate.
    pub fn ring_accelerations(
        &self,
        (rail, place): (usize, usize),
        [displacement, velocity]: [&Vector6<f64>; 2],
        known: &Vector3<f64>,
        sunk: [f64; 2],
    ) -> Option<[f64; 2]> {
        let block = self.rings.as_ref()?.rails.get(rail)?.wheels.get(place)?;
        let Block { mass: Follower { axes, mass, .. }, pressed, own, .. } = block;
        let count = block.states.len();
        Some([0, 1].map(|i| {
            let [by_position, by_velocity]: [Vector6<f64>; 2] = pressed[i];
            let moved = -(by_position.dot(displacement) + by_velocity.dot(velocity) - axes[i].dot(known)) / mass[i];
            moved + own[(2 + i) * count + SUNK] * sunk[0] + own[(2 + i) * count + SINKING] * sunk[1]
        }))
    }

    /// How the accelerations of a wheel's body change with the sinking of the rail under it.
    pub fn ring_load(&self, (rail, place): (usize, usize), sunk: [f64; 2]) -> Option<Vector6<f64>> {
        let block = self.rings.as_ref()?.rails.get(rail)?.wheels.get(place)?;
        Some(block.load[SUNK] * sunk[0] + block.load[SINKING] * sunk[1])
    }

    pub(super) fn eliminate_rings(&mut self, a: f64) -> Result<(), SingularTangent> {
        let Some(Rings { ring, factors, rails }) = &mut self.rings else { return Ok(()) };
        ring.factorise(a, factors);
        let nodes = self.x.len() + self.sum.states.len() + self.followed;
        for (index, rail) in rails.iter_mut().enumerate() {
            if !rail.factorise(ring, factors, a) {
                return Err(SingularTangent { node: nodes + index });
            }
            let size = rail.states();
            for (own, on) in rail.wheels.iter().enumerate() {
                for (other, by) in rail.wheels.iter().enumerate() {
                    let Some(slot) = self.sum.neighbours.slot(on.body, by.body) else { continue };
                    let target = self.lu.block_mut(self.places[slot]);
                    let solved = &rail.solved[other * size + rail.begins[own]..];
                    for (load, solved) in on.load.iter().zip(solved) {
                        add_outer(target, load, solved, -a);
                    }
                }
            }
        }
        Ok(())
    }

    pub(super) fn reduce_rings(&mut self, positions: &[f64], rest: &[f64], count: usize) {
        let Some(Rings { ring, factors, rails }) = &mut self.rings else { return };
        for rail in rails {
            rail.reduce(ring, factors, self.a, (positions, rest, count));
            for (number, wheel) in rail.wheels.iter().enumerate() {
                for (load, known) in wheel.load.iter().zip(&rail.known[rail.begins[number]..]) {
                    self.x[wheel.body] += load * (self.a * known);
                }
            }
        }
    }

    pub(super) fn restore_rings(&mut self, positions: &[f64], rest: &mut [f64], count: usize) {
        let Some(Rings { ring, factors, rails }) = &mut self.rings else { return };
        for rail in rails {
            rail.restore(ring, factors, self.a, (positions, rest, count));
        }
    }

    /// Adds what rings do to the product of J and `x`.
    pub(super) fn add_rings_times(&self, x: &[f64], result: &mut [f64]) {
        let Some(Rings { ring, rails, .. }) = &self.rings else { return };
        let (modes, count) = (ring.modes(), 6 * self.mobility.len());
        for rail in rails {
            let (q, v) = x[rail.first..][..2 * modes].split_at(modes);
            let (dq, dv) = result[rail.first..][..2 * modes].split_at_mut(modes);
            ring.rates(q, v, dq, dv);
            for (wheel, shape) in rail.wheels.iter().zip(rail.shapes.chunks_exact(modes)) {
                let [position, velocity] =
                    [0, count].map(|from| Vector6::from_column_slice(&x[from + 6 * wheel.body..from + 6 * wheel.body + 6]));
                let inside = wheel.states.len();
                let (sunk, sinking) = (dot(shape, q), dot(shape, v));
                let state = |j: usize| match j {
                    SUNK => sunk,
                    SINKING => sinking,
                    _ => x[wheel.states[j]],
                };
                for i in (0..inside).filter(|i| *i != SUNK) {
                    let own: f64 = (0..inside).map(|j| wheel.own[i * inside + j] * state(j)).sum();
                    let rate = own + wheel.by_position[i].dot(&position) + wheel.by_velocity[i].dot(&velocity);
                    if i == SINKING {
                        let rates = &mut result[rail.first + modes..][..modes];
                        rates.iter_mut().zip(shape).for_each(|(own, phi)| *own += phi * rate);
                    } else {
                        result[wheel.states[i]] = rate;
                    }
                }
                let accelerations = &mut result[count + 6 * wheel.body..count + 6 * wheel.body + 6];
                for (j, load) in wheel.load.iter().enumerate() {
                    accelerations.iter_mut().zip(load.iter()).for_each(|(own, load)| *own += load * state(j));
                }
            }
        }
    }
}
