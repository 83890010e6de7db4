//! How the bodies that are no wheelsets swing on their springs about a configuration, wheelsets held.
//!
//! With K the change of the generalised forces with the bodies' coordinates (by differences, so that preloads that turn with their bodies are in it), first-order states of force
//! elements where they come to rest, M the masses and Z a basis of what joints leave free,
//!
//! ```text
//! Z^T K Z v = lambda Z^T M Z v,   shape = Z v
//! ```
//!
//! where lambda > 0 bodies swing with the rate `sqrt(lambda)`, where it is negative they fall with `sqrt(-lambda)`. Dampers are looked at mode by mode ([`damping`]).

mod damping;

use super::body::{COORDINATES, Wrench};
use super::system::{System, SystemWorkspace};
use nalgebra::{DMatrix, DVector};

/// Differences of coordinates, m and rad.
const STEP: f64 = 1e-5;
/// Joints' rows whose share of the largest is below this leave a motion free.
const FREE: f64 = 1e-9;

/// The bodies from `first` on as they hang on their elements in a configuration.
pub struct Carried<'a> {
    system: &'a System,
    /// Number of the first of them: those before are held.
    first: usize,
    state: Vec<f64>,
    workspace: SystemWorkspace,
    stiffness: DMatrix<f64>,
    masses: DVector<f64>,
}

/// A mode without damping.
pub struct Mode {
    /// lambda, 1/s2.
    pub value: f64,
    /// Displacements of the coordinates of all of these bodies (zero of those that were left out), of any size.
    pub shape: DVector<f64>,
}

impl<'a> Carried<'a> {
    /// In the configuration `state` (a state vector of the system).
    pub fn new(system: &'a System, first: usize, state: &[f64]) -> Self {
        let masses = system.bodies[first..].iter().flat_map(|body| {
            let [xx, yy, zz] = body.inertia.moments();
            // Yaw, roll and pitch.
            [body.mass, body.mass, body.mass, zz, xx, yy]
        });
        let masses = DVector::from_vec(masses.collect());
        let count = masses.len();
        let workspace = system.workspace(&[]);
        let mut carried = Carried { system, first, state: state.to_vec(), workspace, stiffness: DMatrix::zeros(count, count), masses };
        for coordinate in 0..count {
            let change = carried.change(coordinate, true);
            carried.stiffness.set_column(coordinate, &-change);
        }
        system.settle_forces(&mut carried.state, &mut carried.workspace);
        carried.apply();
        carried
    }

    /// Masses and moments of inertia by coordinate.
    pub fn masses(&self) -> &DVector<f64> {
        &self.masses
    }

    /// How the generalised forces change with a coordinate, of these bodies or (`own` false) of all.
    fn change(&mut self, coordinate: usize, own: bool) -> DVector<f64> {
        let place = coordinate + if own { COORDINATES * self.first } else { 0 };
        let at = self.state[place];
        let mut forces = |step: f64| {
            self.state[place] = at + step;
            self.system.settle_forces(&mut self.state, &mut self.workspace);
            self.apply();
            generalised(self.system, self.first, &self.workspace, &self.workspace.wrenches)
        };
        let change = (forces(STEP) - forces(-STEP)) / (2.0 * STEP);
        self.state[place] = at;
        change
    }

    /// Change of the generalised forces with a coordinate of a body that is held, N/m or N/rad.
    pub fn led(&mut self, held: usize, coordinate: usize) -> DVector<f64> {
        self.change(COORDINATES * held + coordinate, false)
    }

    fn apply(&mut self) {
        self.system.apply_forces(&self.state, &mut self.workspace);
        self.system.fold_wheels(&mut self.workspace);
    }

    /// Groups of these bodies that elements and joints hold together, by their number among them.
    pub fn groups(&self) -> Vec<Vec<usize>> {
        let count = self.system.bodies.len() - self.first;
        let mut group: Vec<usize> = (0..count).collect();
        let forces = self.system.forces.iter().map(|force| force.bodies());
        let joints = self.system.joints.iter().map(|joint| [Some(joint.bodies.first), joint.bodies.second]);
        for ends in forces.chain(joints) {
            let own = |end: Option<usize>| end?.checked_sub(self.first).filter(|body| *body < count);
            if let [Some(one), Some(other)] = ends.map(own) {
                let (kept, gone) = (group[one].min(group[other]), group[one].max(group[other]));
                group.iter_mut().filter(|group| **group == gone).for_each(|group| *group = kept);
            }
        }
        let members = |number: usize| -> Vec<usize> { (0..count).filter(|body| group[*body] == number).collect() };
        (0..count).map(members).filter(|members| !members.is_empty()).collect()
    }

    /// The modes of some of these bodies (by their number among them) while all others are held; none where they can't move.
    pub fn modes(&self, bodies: &[usize]) -> Vec<Mode> {
        let own: Vec<usize> = bodies.iter().flat_map(|body| COORDINATES * body..COORDINATES * (body + 1)).collect();
        let rows = joint_rows(self.system, (self.first, 0), &self.workspace).select_rows(&own);
        let held = (&rows * rows.transpose()).symmetric_eigen();
        let least = FREE * held.eigenvalues.amax().max(f64::MIN_POSITIVE);
        let ways = held.eigenvalues.iter().zip(held.eigenvectors.column_iter());
        let free: Vec<DVector<f64>> = ways.filter(|(value, _)| **value <= least).map(|(_, way)| way.into()).collect();
        if free.is_empty() {
            return Vec::new();
        }
        let basis = DMatrix::from_columns(&free);
        let stiffness = self.stiffness.select_rows(&own).select_columns(&own);
        let masses = self.masses.select_rows(&own);
        let root = (basis.transpose() * DMatrix::from_diagonal(&masses) * &basis).cholesky();
        let Some(inverse) = root.and_then(|root| root.l().try_inverse()) else { return Vec::new() };
        let reduced = basis.transpose() * (0.5 * (&stiffness + stiffness.transpose())) * &basis;
        let eigen = (&inverse * reduced * inverse.transpose()).symmetric_eigen();
        let spread = |column: usize| {
            let motion = &basis * (inverse.transpose() * eigen.eigenvectors.column(column));
            let mut shape = DVector::zeros(self.masses.len());
            own.iter().zip(motion.iter()).for_each(|(place, value)| shape[*place] = *value);
            Mode { value: eigen.eigenvalues[column], shape }
        };
        (0..eigen.eigenvalues.len()).map(spread).collect()
    }
}

/// Generalised forces on the bodies from `first` on.
pub fn generalised(system: &System, first: usize, workspace: &SystemWorkspace, wrenches: &[Wrench]) -> DVector<f64> {
    let bodies = workspace.motions.iter().zip(wrenches).take(system.bodies.len()).skip(first);
    let count = COORDINATES * system.bodies.len().saturating_sub(first);
    DVector::from_iterator(count, bodies.flat_map(|(motion, wrench)| motion.generalised_force(wrench).data.0[0]))
}

/// Rows of all joints on the coordinates of the bodies from `first` on and, below these, on the x of the first `rolling` bodies, as columns.
pub fn joint_rows(system: &System, (first, rolling): (usize, usize), workspace: &SystemWorkspace) -> DMatrix<f64> {
    let own = COORDINATES * system.bodies.len().saturating_sub(first);
    let mut rows = DMatrix::zeros(own + rolling, system.joints.iter().map(|joint| joint.rows()).sum());
    let joints = system.joints.iter().flat_map(|joint| joint.evaluate(0.0, &workspace.motions).map(|values| (joint.bodies, values)));
    for (column, (bodies, values)) in joints.enumerate() {
        for (body, coefficients) in [(Some(bodies.first), &values.first), (bodies.second, &values.second)] {
            match body {
                Some(body) if body >= first => {
                    rows.view_mut((COORDINATES * (body - first), column), (COORDINATES, 1)).copy_from(coefficients);
                }
                Some(body) if body < rolling => rows[(own + body, column)] = coefficients[0],
                _ => {}
            }
        }
    }
    rows
}
