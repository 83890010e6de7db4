//! How the derivative of a system's state changes with the state, and the solution of `(I - a J) x = b`, for implicit integrators.
//!
//! With coordinates q, velocities v = q', first-order states s, mass matrix M and generalised forces Q, without constraints:
//!
//! ```text
//! q' = v,   v' = M^-1 Q(q, v, s) + b,   s' = f(q, v, s)
//! J_q = M^-1 dQ/dq,   J_v = M^-1 dQ/dv + db/dv,   J_s = M^-1 dQ/ds
//! ```
//!
//! Force elements hand in dQ exactly but for what [`pair`] names; a body of revolution adds the gyroscopic db/dv of its spin.
//! Left out, because it is slow beside suspensions and creep forces: dM^-1/dq Q (angular accelerations times angles, of the order
//! 1 1/s2), the gyroscopic terms of bodies that do not spin (their angular velocity, 0.1 1/s), and for contacts the turning of the
//! axes that a wrench is projected on (moment over inertia, of the order 10 1/s2). Methods that use J keep their order whatever J is.
//!
//! k_q = r_q + a k_v holds exactly in `(I - a J) k = r`, and states are eliminated first, so that 6 x 6 blocks in k_v are left:
//!
//! ```text
//! A k_v = w,   A = 1 - a J_v - a^2 J_q - sum_s a J_s c^T / (1 - a df/ds),   c = a (a df/dq + df/dv)
//! w = r_v + a J_q r_q + a J_s (r_s + a df/dq . r_q) / (1 - a df/ds)
//! ```
//!
//! Joints and contacts as constraints, with rows G, project accelerations: `v' = P (M^-1 Q + b) + ..` with `G P = 0` and
//! `1 - P` in the range of M^-1 G^T. So k - r lies in the kernel of G, and
//!
//! ```text
//! A k_v + M^-1 G^T mu = w,   G k_v = G r_v
//! ```
//!
//! (left out: how P and the right-hand side of the constraints change, multipliers times the constraints' curvature over the mass: a
//! joint loaded with 50 kN at 1 m and 1 t gives 50 1/s2). A driving constraint has no mobility in its direction, so that rows and
//! columns vanish, but for db/dv of a speed that follows an input ([`crate::mbs::speed_input`]); its return to the imposed speed (10 1/s) is left out.
//!
//! Blocks are eliminated in an order of minimum degree that is found once ([`elimination`]); the cost grows linearly along a train.

mod elimination;
mod expand;
mod fastest;
mod follower;
mod pattern;
mod ring;
mod solve;
mod sum;
mod twist;
mod world;

pub use follower::Follower;
pub use ring::RingPlan;

pub use super::pair_tangent::{Ends, PairTangent, StateTangent, pair};

use super::body::COORDINATES;
use super::force::ForceElement;
use super::kkt::RowBodies;
use super::pair_tangent::Terms;
use super::system::{System, SystemWorkspace};
use elimination::BlockLu;
use expand::PairFrames;
use nalgebra::{Matrix3, Matrix6, Vector6};
use pair::PairSum;
use pattern::{Graph, Neighbours};
use solve::Eliminated;
use sum::TangentSum;
use twist::TwistNode;

/// Change of a wrench (force above moment about the centre of the body that it acts on, world axes, N and N m) with the motion of a
/// body: displacement of its centre [m] above a small rotation [rad], velocity of its centre [m/s] above angular velocity [rad/s],
/// all in world axes.
///
/// `by_position` counts at constant velocity and angular velocity. That the angular velocity of a body turns with it when its
/// coordinates' rates are held (a yawed wheelset turns its spin into a roll velocity) is added by [`Tangent::finish`] by way of
/// `by_velocity`; it must not be in `by_position`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WrenchTangent {
    pub by_position: Matrix6<f64>,
    pub by_velocity: Matrix6<f64>,
}

/// How one first-order state and a body act on each other; as in [`WrenchTangent`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateCoupling {
    pub body: usize,
    /// Change of the state's rate with displacement and rotation, and with velocity and angular velocity of the body.
    pub rate_by_position: Vector6<f64>,
    pub rate_by_velocity: Vector6<f64>,
    /// Change of the wrench on the body with the state.
    pub wrench_by_state: Vector6<f64>,
}

/// I - a J can't be inverted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the linearised equations of motion are singular for this step at node {node} (bodies, then groups of constraints): shorten the step"
)]
pub struct SingularTangent {
    /// Body, or number of bodies plus group of constraint rows, or the same plus a first-order state.
    pub node: usize,
}

/// Constraint rows that are eliminated together, at most six, on the same bodies.
#[derive(Clone, Debug)]
struct RowGroup {
    rows: Vec<usize>,
    node: usize,
    /// Place of its own block.
    pivot: usize,
    sides: Vec<Side>,
}

/// Rows of a group on one body.
#[derive(Clone, Debug)]
struct Side {
    body: usize,
    /// Places of the blocks (group, body) and (body, group).
    lower: usize,
    upper: usize,
    /// G on the body, rows that are left out zero.
    rows: Matrix6<f64>,
}

/// J of a system and the factors of I - a J; only [`Tangent::new`] allocates.
#[derive(Clone, Debug)]
pub struct Tangent {
    sum: TangentSum,
    /// By force element.
    pair_of_force: Vec<usize>,
    /// Pair of what holds its rotating parts and the world, likewise.
    carrier_of_force: Vec<Option<usize>>,
    /// Pair of an element's first body and that one, where it is a third.
    far_of_force: Vec<Option<usize>>,
    /// Changes of wrenches by slot, and whether there are any.
    world: Vec<Option<WrenchTangent>>,
    mobility: Vec<Matrix6<f64>>,
    /// Gyroscopic db/dv on the angles, by body, 1/s.
    spin: Vec<Matrix3<f64>>,
    /// db/dv on the displacements of driven bodies whose speed follows an input, 1/s.
    follow: Vec<(usize, Matrix3<f64>)>,
    frames: Vec<PairFrames>,
    lu: BlockLu,
    /// By slot of the sum.
    places: Vec<usize>,
    groups: Vec<RowGroup>,
    eliminated: Vec<Eliminated>,
    /// Axles that twist, and their bodies.
    twists: Vec<TwistNode>,
    axles: Vec<usize>,
    /// Room for followers, and how many there are.
    followers: Vec<follower::Block>,
    followed: usize,
    /// Rails that several wheels press, where there are any.
    rings: Option<ring::Rings>,
    /// a of the last factorisation, s.
    a: f64,
    /// Right-hand side and solution by node.
    x: Vec<Vector6<f64>>,
}

impl Tangent {
    /// Finds pattern and order of elimination. `contact_bodies` as in [`System::workspace`]: one row each. `further_states` is the
    /// largest number of states handed to [`Tangent::add_state`].
    pub fn new(system: &System, contact_bodies: &[usize], further_states: usize) -> Tangent {
        Tangent::joining(system, contact_bodies, further_states, &[])
    }

    /// The same with pairs of bodies that something else joins than force elements.
    pub fn joining(system: &System, contact_bodies: &[usize], further_states: usize, pairs: &[(usize, usize)]) -> Tangent {
        let bodies = system.bodies.len();
        let joined = system.forces.iter().flat_map(|force| {
            let [a, b, far] = force.reach();
            [(a, b), (a, far), (b, far)].into_iter().filter_map(|(a, b)| a.zip(b).filter(|(a, b)| a != b))
        });
        let joined = joined.chain(pairs.iter().copied());
        let (mut twists, wheels) = twist::twists(system);
        let neighbours = Neighbours::new(bodies, joined.chain(twist::joined(system, &wheels)), wheels);
        let mut pairs: Vec<PairSum> = Vec::new();
        let mut pair = |ends: Ends, spinning: bool| {
            let known = pairs.iter().position(|pair| pair.ends == ends && pair.spinning == spinning);
            known.unwrap_or_else(|| {
                pairs.push(PairSum::new(ends, spinning));
                pairs.len() - 1
            })
        };
        let ends = |force: &dyn ForceElement| match (force.wheel(), force.bodies()) {
            (Some(wheel), [_, carrier]) => [Some(wheel), carrier],
            (None, ends) => ends,
        };
        let pair_of_force = system.forces.iter().map(|force| pair(ends(force.as_ref()), force.turns_axle())).collect();
        let carriers = system.forces.iter().map(|force| force.rotor_carrier());
        let carrier_of_force = carriers.map(|body| body.map(|body| pair([Some(body), None], true))).collect();
        let far = |force: &dyn ForceElement| {
            let [a, b, far] = force.reach();
            far.filter(|far| ![a, b].contains(&Some(*far))).map(|far| [a, Some(far)])
        };
        let far_of_force: Vec<Option<usize>> = system.forces.iter().map(|force| far(force.as_ref()).map(|ends| pair(ends, true))).collect();
        let mut groups = groups(system, contact_bodies);
        let nodes = bodies + groups.len() + twists.len();
        let mut graph = Graph { nodes, edges: vec![], before: vec![vec![]; nodes] };
        graph.edges.extend(neighbours.iter().map(|(_, row, column)| (row, column)));
        for group in &groups {
            for side in &group.sides {
                graph.edges.push((side.body, group.node));
                graph.before[group.node].push(side.body);
            }
        }
        for (number, twist) in twists.iter_mut().enumerate() {
            twist.join(&mut graph, bodies + groups.len() + number);
        }
        let mut lu = BlockLu::new(&graph);
        let places: Vec<usize> = neighbours.iter().map(|(_, row, column)| lu.place(row, column)).collect();
        lu.overwritten(&places);
        for group in &mut groups {
            group.pivot = lu.place(group.node, group.node);
            for side in &mut group.sides {
                (side.lower, side.upper) = (lu.place(group.node, side.body), lu.place(side.body, group.node));
            }
        }
        twists.iter_mut().for_each(|twist| twist.find_places(&lu));
        let states = system.forces.iter().map(|force| force.states()).sum::<usize>() + further_states;
        Tangent {
            world: vec![None; neighbours.slots()],
            frames: Vec::with_capacity(pairs.len()),
            sum: TangentSum::new(neighbours, pairs, [states, system.forces.len()]),
            pair_of_force,
            carrier_of_force,
            far_of_force,
            mobility: vec![Matrix6::zeros(); bodies],
            spin: vec![Matrix3::zeros(); bodies],
            follow: Vec::with_capacity(system.drives.len()),
            x: vec![Vector6::zeros(); graph.nodes],
            lu,
            places,
            groups,
            eliminated: Vec::with_capacity(states),
            twists,
            axles: twist::axles(system),
            followers: Vec::new(),
            followed: 0,
            rings: None,
            a: 0.0,
        }
    }

    /// Blocks kept, and products of blocks in one factorisation.
    pub fn cost(&self) -> (usize, usize) {
        self.lu.cost()
    }

    /// J = 0.
    pub fn clear(&mut self) {
        self.sum.clear();
        self.world.fill(None);
        self.take_twists(false);
        self.followed = 0;
    }

    /// Adds the change of a wrench on the body `on` with the motion of the body `by`: the same, or one that a force element joins with
    /// it.
    #[inline]
    pub fn add_wrench(&mut self, on: usize, by: usize, tangent: &WrenchTangent) {
        if let Some(sum) = self.wrench_mut(on, by) {
            sum.by_position += tangent.by_position;
            sum.by_velocity += tangent.by_velocity;
        }
    }

    /// Takes away what [`Tangent::add_wrench`] has put on a body by its own motion.
    pub fn take_wrench(&mut self, body: usize) -> Option<WrenchTangent> {
        let slot = self.sum.neighbours.slot(body, body)?;
        self.world[slot].take()
    }

    /// What [`Tangent::add_wrench`] adds to.
    #[inline]
    pub fn wrench_mut(&mut self, on: usize, by: usize) -> Option<&mut WrenchTangent> {
        let slot = self.sum.neighbours.slot(on, by);
        debug_assert!(slot.is_some(), "no force element joins bodies {on} and {by}");
        Some(self.world[slot?].get_or_insert_default())
    }

    /// Adds a first-order state at index `state` of the state vector: the change of its rate with itself, 1/s, and what couples it
    /// with up to two bodies.
    pub fn add_state(&mut self, state: usize, rate_by_state: f64, bodies: &[StateCoupling]) {
        let mut tangent = StateTangent::new(state, 1, [None; 2], Terms::World);
        tangent.rate_by_state[(0, 0)] = rate_by_state;
        for (end, coupling) in bodies.iter().take(2).enumerate() {
            tangent.ends[end] = Some(coupling.body);
            tangent.rate_by_position[0][end] = coupling.rate_by_position;
            tangent.rate_by_velocity[0][end] = coupling.rate_by_velocity;
            tangent.load_by_state[0][end] = coupling.wrench_by_state;
        }
        debug_assert!(self.sum.states.len() < self.sum.states.capacity(), "more states than Tangent::new was told");
        self.sum.states.push(tangent);
    }

    /// Adds every force element, with the motions and stations in the workspace and the elements' states in `y`.
    pub fn add_forces(&mut self, system: &System, workspace: &SystemWorkspace, y: &[f64]) {
        self.take_twists(true);
        let mut start = 2 * COORDINATES * system.bodies.len();
        let TangentSum { pairs, states, across, .. } = &mut self.sum;
        let mut first = 0;
        for (element, (force, pair)) in system.forces.iter().zip(&self.pair_of_force).enumerate() {
            let (end, last) = (start + force.states(), workspace.inputs_end(element));
            let (sum, carrier, far) = match (self.carrier_of_force[element], self.far_of_force[element]) {
                (Some(carrier), Some(far)) => match pairs.get_disjoint_mut([*pair, carrier, far]) {
                    Ok([sum, carrier, far]) => (sum, Some(carrier), Some(far)),
                    Err(_) => (&mut pairs[*pair], None, None),
                },
                (Some(carrier), None) => match pairs.get_disjoint_mut([*pair, carrier]) {
                    Ok([sum, carrier]) => (sum, Some(carrier), None),
                    Err(_) => (&mut pairs[*pair], None, None),
                },
                (None, _) => (&mut pairs[*pair], None, None),
            };
            let reference = expand::reference(sum, &workspace.motions);
            let mut tangent = PairTangent { sum, carrier, far, across, pair: *pair, reference, states };
            force.tangent(&workspace.with_inputs(first..last), &y[start..end], start, &mut tangent);
            [start, first] = [end, last];
        }
    }
}

/// Each joint's rows; those of contacts body by body.
fn groups(system: &System, contact_bodies: &[usize]) -> Vec<RowGroup> {
    let mut groups: Vec<RowGroup> = Vec::new();
    let new = |rows: Vec<usize>, RowBodies { first, second }: RowBodies, index: usize| {
        let side = |body| Side { body, lower: 0, upper: 0, rows: Matrix6::zeros() };
        let sides = std::iter::once(first).chain(second).map(side).collect();
        RowGroup { rows, node: system.bodies.len() + index, pivot: 0, sides }
    };
    let mut row = 0;
    for joint in &system.joints {
        groups.push(new((row..row + joint.rows()).collect(), joint.bodies, groups.len()));
        row += joint.rows();
    }
    let joints = groups.len();
    for body in contact_bodies {
        let same = |group: &&mut RowGroup| group.sides[0].body == *body && group.rows.len() < COORDINATES;
        match groups[joints..].iter_mut().find(same) {
            Some(group) => group.rows.push(row),
            None => groups.push(new(vec![row], RowBodies { first: *body, second: None }, groups.len())),
        }
        row += 1;
    }
    groups
}
