//! What all elements between the same two bodies add up to, in terms of the relative motion of the bodies' frames.
//!
//! Between a (`from`) and b (`to`), with the centres x, a point c (the centre of b, or of a where b is the world), an element's force F on
//! a and -F on b at p, r = p - c, and small displacements dx and rotations th of the frames:
//!
//! ```text
//! t = (dx_b - dx_a - th_a x (c - x_a),  th_b - th_a)     relative twist at c; the place p moves by u = (1, -[r x]) t seen from a
//! dF = th_a x F + K u + C u'                             also along a line: K = k e e^T + T/L (1 - e e^T)
//! dW = (sum of (1, -[r x])^T K (1, -[r x])) t + ..       wrench on a at c; one 6 x 6 matrix, likewise for C
//! ```
//!
//! Lever arms and forces that turn need no more of each element than F and r F^T. What is added up is expanded to coordinates once per
//! pair (`tangent::expand`). Exact for forces by displacements and by velocities. Left out is how velocities change by
//! displacements when bodies turn: angular velocity times damping beside the stiffness (0.05 1/s x 3e4 N s/m beside 1e5 N/m), and the
//! damper's own force times angle.

use super::state::{Across, Ends, Gradient, StateTangent, Terms};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// Sums over the elements of one pair of bodies.
#[derive(Clone, Debug)]
pub struct PairSum {
    pub(in crate::mbs) ends: Ends,
    /// Do displacements and rotations count those of the bodies themselves, which may spin? Otherwise those of the frames that bearings hold.
    pub(in crate::mbs) spinning: bool,
    /// Has anything been added?
    pub(in crate::mbs) used: bool,
    /// Change of the wrench on `from` at c with the relative twist at c, and with its rate.
    pub(in crate::mbs) stiffness: Matrix6<f64>,
    pub(in crate::mbs) damping: Matrix6<f64>,
    /// Sum of F, N, of r F^T, N m, and of the couples on `from`, N m.
    pub(in crate::mbs) force: Vector3<f64>,
    pub(in crate::mbs) arm_force: Matrix3<f64>,
    pub(in crate::mbs) couple: Vector3<f64>,
    /// dQ/dv of the coordinates themselves, row by row of ends; only of bodies that may spin.
    pub(in crate::mbs) rates: Option<[[Matrix6<f64>; 2]; 2]>,
}

impl PairSum {
    pub(in crate::mbs) fn new(ends: Ends, spinning: bool) -> PairSum {
        let (zero, six) = (Vector3::zeros(), Matrix6::zeros());
        let rates = spinning.then_some([[six; 2]; 2]);
        PairSum { ends, spinning, used: false, stiffness: six, damping: six, force: zero, arm_force: Matrix3::zeros(), couple: zero, rates }
    }

    fn add_couple_of_to(&mut self, couple: &Vector3<f64>) {
        self.used = true;
        self.couple += couple;
        let mut part = self.stiffness.fixed_view_mut::<3, 3>(3, 3);
        part -= couple.cross_matrix();
    }

    /// Takes in what elements have handed in elsewhere.
    pub(in crate::mbs) fn add(&mut self, other: &PairSum) {
        self.used |= other.used;
        self.stiffness += other.stiffness;
        self.damping += other.damping;
        self.force += other.force;
        self.arm_force += other.arm_force;
        self.couple += other.couple;
        let blocks = self.rates.iter_mut().flatten().flatten();
        for (block, more) in blocks.zip(other.rates.iter().flatten().flatten()) {
            *block += more;
        }
    }

    pub(in crate::mbs) fn clear(&mut self) {
        if self.used {
            let (zero, six) = (Vector3::zeros(), Matrix6::zeros());
            (self.used, self.force, self.couple, self.arm_force) = (false, zero, zero, Matrix3::zeros());
            (self.stiffness, self.damping) = (six, six);
            if let Some(rates) = &mut self.rates {
                *rates = [[six; 2]; 2];
            }
        }
    }
}

/// Where an element hands in its changes.
pub struct PairTangent<'a> {
    pub(in crate::mbs) sum: &'a mut PairSum,
    /// What holds the element's own rotating parts, against the world.
    pub(in crate::mbs) carrier: Option<&'a mut PairSum>,
    /// `from` and that body, where it is none of the element's two.
    pub(in crate::mbs) far: Option<&'a mut PairSum>,
    /// What changes with the coordinates of a third body, of all elements.
    pub(in crate::mbs) across: &'a mut Vec<Across>,
    /// Index of the pair.
    pub(in crate::mbs) pair: usize,
    /// c, m.
    pub(in crate::mbs) reference: Vector3<f64>,
    pub(in crate::mbs) states: &'a mut Vec<StateTangent>,
}

impl PairTangent<'_> {
    /// Coefficients, on the relative twist, of the displacement of the place at `point` [m, world] along `unit`; also the wrench on `from`
    /// of a unit force there.
    #[inline]
    pub fn line(&self, point: &Vector3<f64>, unit: &Vector3<f64>) -> Vector6<f64> {
        let moment = (point - self.reference).cross(unit);
        Vector6::new(unit.x, unit.y, unit.z, moment.x, moment.y, moment.z)
    }

    /// A force on `from` that turns with its frame, with its lever arms, N.
    #[inline]
    pub fn add_force(&mut self, point: &Vector3<f64>, force: &Vector3<f64>) {
        self.sum.used = true;
        self.sum.force += force;
        self.sum.arm_force += (point - self.reference) * force.transpose();
    }

    /// A couple on `from` that turns with its frame, N m.
    #[inline]
    pub fn add_couple(&mut self, couple: &Vector3<f64>) {
        self.sum.used = true;
        self.sum.couple += couple;
    }

    /// The wrench `load` per unit, which changes with `measured . t`, N/m.
    #[inline]
    pub fn add_spring(&mut self, load: &Vector6<f64>, measured: &Vector6<f64>, stiffness: f64) {
        self.sum.used = true;
        add_outer(&mut self.sum.stiffness, load, measured, stiffness);
    }

    /// The same with the twist's rate, N s/m.
    #[inline]
    pub fn add_damper(&mut self, load: &Vector6<f64>, measured: &Vector6<f64>, damping: f64) {
        self.sum.used = true;
        add_outer(&mut self.sum.damping, load, measured, damping);
    }

    /// A stiffness at a point that is the same in all directions, N/m.
    #[inline]
    pub fn add_uniform_spring(&mut self, point: &Vector3<f64>, stiffness: f64) {
        let arm = point - self.reference;
        let (cross, square) = (arm.cross_matrix() * stiffness, arm.norm_squared());
        self.sum.used = true;
        let matrix = &mut self.sum.stiffness;
        for i in 0..3 {
            matrix[(i, i)] += stiffness;
            matrix[(3 + i, 3 + i)] += stiffness * square;
            for j in 0..3 {
                matrix[(i, 3 + j)] -= cross[(i, j)];
                matrix[(3 + i, j)] += cross[(i, j)];
                matrix[(3 + i, 3 + j)] -= stiffness * arm[i] * arm[j];
            }
        }
    }

    /// Stiffness and damping at a point, symmetric, world axes, N/m and N s/m.
    pub fn add_point(&mut self, point: &Vector3<f64>, stiffness: &Matrix3<f64>, damping: &Matrix3<f64>) {
        self.sum.used = true;
        let arm = point - self.reference;
        add_at(&mut self.sum.stiffness, &arm, stiffness);
        if *damping != Matrix3::zeros() {
            add_at(&mut self.sum.damping, &arm, damping);
        }
    }

    /// A couple on `from` that changes with the relative rotation and its rate, world axes, N m/rad and N m s/rad.
    #[inline]
    pub fn add_turning(&mut self, stiffness: &Matrix3<f64>, damping: &Matrix3<f64>) {
        self.sum.used = true;
        let mut part = self.sum.stiffness.fixed_view_mut::<3, 3>(3, 3);
        part += stiffness;
        let mut part = self.sum.damping.fixed_view_mut::<3, 3>(3, 3);
        part += damping;
    }

    /// `count` first-order states from the index `first` of the state vector on, to be completed: rates by the relative twist and its rate,
    /// wrench on `from` by state, each in the first place of its pair.
    #[inline]
    pub fn add_states(&mut self, first: usize, count: usize) -> Option<&mut StateTangent> {
        debug_assert!(self.states.len() < self.states.capacity(), "more states than Tangent::new was told");
        self.states.push(StateTangent::new(first, count, self.sum.ends, Terms::Pair(self.pair)));
        self.states.last_mut()
    }

    /// The same in terms of both bodies' coordinates: rates by coordinates and velocities, generalised forces by state.
    pub fn add_own_states(&mut self, first: usize, count: usize) -> Option<&mut StateTangent> {
        debug_assert!(self.states.len() < self.states.capacity(), "more states than Tangent::new was told");
        self.states.push(StateTangent::new(first, count, self.sum.ends, Terms::Coordinates));
        self.states.last_mut()
    }

    /// Generalised forces `load` on both bodies' coordinates, which change by `factor` with `measured . velocities`. Of elements that turn an axle.
    pub fn add_rates(&mut self, load: &Gradient, measured: &Gradient, factor: f64) {
        self.sum.used = true;
        let Some(rates) = &mut self.sum.rates else { return };
        for (rates, load) in rates.iter_mut().zip(load) {
            for (block, measured) in rates.iter_mut().zip(measured) {
                add_outer(block, load, measured, factor);
            }
        }
    }

    /// A force on `from` whose place and direction are fixed in the frame of `to`, N.
    pub fn add_force_of_to(&mut self, point: &Vector3<f64>, force: &Vector3<f64>) {
        self.add_force(point, force);
        // It turns with `to`: as with `from`, and by the relative rotation.
        let (arm, turned) = ((point - self.reference).cross_matrix(), force.cross_matrix());
        let mut part = self.sum.stiffness.fixed_view_mut::<3, 3>(0, 3);
        part -= turned;
        let mut part = self.sum.stiffness.fixed_view_mut::<3, 3>(3, 3);
        part -= arm * turned;
    }

    /// A force on `from` whose place is fixed on it and whose direction is fixed in the world, where `to` is the world, N.
    pub fn add_outer_force(&mut self, point: &Vector3<f64>, force: &Vector3<f64>) {
        let arm = point - self.reference;
        self.add_couple_of_to(&arm.cross(force));
        // The arm turns with the body, against the relative rotation.
        let mut part = self.sum.stiffness.fixed_view_mut::<3, 3>(3, 3);
        part -= force.cross_matrix() * arm.cross_matrix();
    }

    /// A force on `from` that is fixed on it in place and direction, where `to` is the world, N.
    pub fn add_own_force(&mut self, point: &Vector3<f64>, force: &Vector3<f64>) {
        self.add_couple(&(point - self.reference).cross(force));
        let mut part = self.sum.stiffness.fixed_view_mut::<3, 3>(0, 3);
        part += force.cross_matrix();
    }

    /// A couple on `from` that turns with the frame of `to`, N m.
    pub fn add_couple_of_to(&mut self, couple: &Vector3<f64>) {
        self.sum.add_couple_of_to(couple);
    }

    /// A couple on `from`, and the opposite one on what holds the element's rotating parts, which turns with the frame of that body, N m.
    pub fn add_couple_of_carrier(&mut self, couple: &Vector3<f64>) {
        self.far.as_deref_mut().unwrap_or(self.sum).add_couple_of_to(couple);
    }

    /// Generalised forces `load` on both bodies, which change with `measured` on the coordinates of `from` and of what holds the rotating parts.
    pub fn add_across(&mut self, load: &Gradient, measured: &Gradient) {
        let Some(carrier) = self.carrier.as_deref() else { return };
        debug_assert!(self.across.len() < self.across.capacity(), "more elements of three bodies than Tangent::new has seen");
        self.across.push(Across { on: self.sum.ends, load: *load, by: [self.sum.ends[0], carrier.ends[0]], measured: *measured });
    }

    /// Of what holds the rotating parts: generalised forces `load` that change by `factor` with `measured . velocities`.
    pub fn add_carrier_rates(&mut self, load: &Vector6<f64>, measured: &Vector6<f64>, factor: f64) {
        let Some(carrier) = &mut self.carrier else { return };
        carrier.used = true;
        if let Some(rates) = &mut carrier.rates {
            add_outer(&mut rates[0][0], load, measured, factor);
        }
    }

    /// A couple on the body that holds the element's rotating parts; it turns with it and has no counterpart on another body, N m.
    pub fn add_carried_couple(&mut self, couple: &Vector3<f64>) {
        if let Some(carrier) = &mut self.carrier {
            carrier.used = true;
            carrier.couple += couple;
        }
    }
}

/// Adds `(1, -[r x])^T K (1, -[r x])` of a symmetric K.
#[inline]
fn add_at(matrix: &mut Matrix6<f64>, arm: &Vector3<f64>, part: &Matrix3<f64>) {
    let columns = &mut matrix.data.0;
    // r x K, whose transpose is -K [r x].
    let mut lower = Matrix3::zeros();
    for j in 0..3 {
        lower.set_column(j, &arm.cross(&part.column(j)));
    }
    for j in 0..3 {
        let turning = arm.cross(&Vector3::new(lower[(j, 0)], lower[(j, 1)], lower[(j, 2)]));
        for i in 0..3 {
            columns[j][i] += part[(i, j)];
            columns[j][3 + i] += lower[(i, j)];
            columns[3 + j][i] += lower[(j, i)];
            columns[3 + j][3 + i] += turning[i];
        }
    }
}

/// Adds `factor left right^T`; column by column, which the compiler turns into vector instructions.
#[inline]
pub(in crate::mbs) fn add_outer(block: &mut Matrix6<f64>, left: &Vector6<f64>, right: &Vector6<f64>, factor: f64) {
    let left: &[f64; 6] = &left.data.0[0];
    for (column, right) in block.data.0.iter_mut().zip(&right.data.0[0]) {
        let scaled = factor * right;
        for (value, left) in column.iter_mut().zip(left) {
            *value += left * scaled;
        }
    }
}
