//! Which rows of the joints repeat what the others demand (a closed loop of parallel hinges, for example).
//!
//! Rows are compared in the metric of the masses, as `M^-1/2 J^T`, each scaled to length one. Joints on bodies that no
//! other joint touches cannot be part of a repetition as long as they are independent on that body alone, so trees
//! are peeled off from their ends first; what is left (loops) goes into a QR factorisation with column pivoting. A
//! dependence may hold only at one special position, such as a dead centre. Therefore the system is moved a little
//! along its free motions: a row is redundant if it then still follows from the others, in value and in direction.

use super::body::COORDINATES;
use super::kkt::{Coefficients, Kkt, Mobility};
use super::projection::ProjectionError;
use super::system::{System, SystemWorkspace};
use nalgebra::{DMatrix, DVector, RowDVector};

/// Sine of the angle between a row and the others below which it depends on them.
const DEPENDENT: f64 = 1e-6;

/// The same for the square of the sine at the displaced position, where a special position's dependence has gone
/// like the displacement.
const STILL_DEPENDENT: f64 = 1e-10;

/// Displacement along the free motions, m and rad.
const DISPLACEMENT: f64 = 1e-3;

/// Constraints are met to this, m, rad or a cosine (and per second).
const TOLERANCE: f64 = 1e-11;

/// A redundant row that is violated by more is not redundant but contradicts.
const CONTRADICTION: f64 = 1e-8;

/// A row that may be left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RedundantRow {
    pub row: usize,
    /// Joint and scalar constraint, such as `pivot.tilt_x`.
    pub name: String,
}

/// The joints contradict each other, or the position is special.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AssemblyError {
    #[error("constraints contradict others: {names}; check positions, speeds and axes of these joints")]
    Contradiction { names: String },
    #[error("constraints depend on others at the initial position only (a dead centre?): {names}; start a little beside it")]
    SpecialPosition { names: String },
    #[error(transparent)]
    Projection(#[from] ProjectionError),
}

impl System {
    /// Finds redundant rows of the joints near the state `y` at time t [s]; put them into [`System::redundant`].
    ///
    /// # Errors
    /// [`AssemblyError`] with the names of the rows.
    pub fn find_redundant(&self, t: f64, y: &[f64]) -> Result<Vec<RedundantRow>, AssemblyError> {
        let mut workspace = self.workspace(&[]);
        let mut y = y.to_vec();
        for row in 0..workspace.constraints.kkt.rows() {
            workspace.constraints.kkt.set_active(row, true);
        }
        self.move_bodies(&y, &mut workspace);
        self.prepare_constraints(t, &mut workspace);
        let suspects = self.dependent_rows(&workspace.constraints.kkt);
        if suspects.is_empty() {
            return Ok(Vec::new());
        }
        for row in &suspects {
            workspace.constraints.kkt.set_active(*row, false);
        }
        let mut none = |_: &mut SystemWorkspace| Ok::<(), AssemblyError>(());
        self.project(t, &mut y, &mut workspace, TOLERANCE, none)?;
        self.move_bodies(&y, &mut workspace);
        self.prepare_constraints(t, &mut workspace);
        let constraints = &workspace.constraints;
        let violated = |row: &usize| constraints.residual[*row].abs().max(constraints.rate[*row].abs()) > CONTRADICTION;
        let contradicting: Vec<usize> = suspects.iter().copied().filter(violated).collect();
        if !contradicting.is_empty() {
            return Err(AssemblyError::Contradiction { names: self.row_names(&contradicting) });
        }
        if self.displace(&mut y, &mut workspace) {
            self.project_positions(t, &mut y, &mut workspace, TOLERANCE, &mut none)?;
            self.move_bodies(&y, &mut workspace);
            self.prepare_constraints(t, &mut workspace);
            let special = self.independent_rows(&suspects, &mut workspace)?;
            if !special.is_empty() {
                return Err(AssemblyError::SpecialPosition { names: self.row_names(&special) });
            }
        }
        Ok(suspects.into_iter().map(|row| RedundantRow { row, name: self.row_name(row) }).collect())
    }

    /// Moves the positions along some free motion; false if there is none.
    fn displace(&self, y: &mut [f64], workspace: &mut SystemWorkspace) -> bool {
        let constraints = &mut workspace.constraints;
        let mut random = 1u64;
        let direction = constraints.free.iter_mut();
        for value in direction {
            random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            *value = (random >> 32) as f64 / f64::from(u32::MAX) - 0.5;
        }
        for drive in &self.drives {
            constraints.free[COORDINATES * drive.body] = 0.0;
        }
        let across: Vec<f64> = (0..constraints.kkt.rows()).map(|row| constraints.kkt.row_times(row, &constraints.free)).collect();
        constraints.kkt.correction(&across, &mut constraints.accelerations);
        let motion: Vec<f64> = constraints.free.iter().zip(&constraints.accelerations).map(|(a, b)| a + b).collect();
        let largest = motion.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        if largest < 1e-6 {
            return false;
        }
        for (value, motion) in y.iter_mut().zip(&motion) {
            *value += DISPLACEMENT / largest * motion;
        }
        true
    }

    /// Those of the inactive `suspects` that the active rows do not imply at the workspace's position.
    fn independent_rows(&self, suspects: &[usize], workspace: &mut SystemWorkspace) -> Result<Vec<usize>, ProjectionError> {
        let constraints = &mut workspace.constraints;
        constraints.kkt.factorise().map_err(|error| ProjectionError::Singular { name: self.row_name(error.row) })?;
        let mut independent = Vec::new();
        for &row in suspects {
            let (bodies, first, second) = constraints.kkt.row(row);
            let (first, second) = (*first, *second);
            constraints.free.fill(0.0);
            let parts = [Some((bodies.first, first)), bodies.second.map(|body| (body, second))];
            for (body, coefficients) in parts.into_iter().flatten() {
                let motion = constraints.kkt.mobility(body) * coefficients;
                constraints.free[COORDINATES * body..COORDINATES * (body + 1)].copy_from_slice(motion.as_slice());
            }
            let whole = constraints.kkt.row_times(row, &constraints.free);
            let across: Vec<f64> = (0..constraints.kkt.rows()).map(|other| constraints.kkt.row_times(other, &constraints.free)).collect();
            constraints.kkt.correction(&across, &mut constraints.accelerations);
            let rest = whole + constraints.kkt.row_times(row, &constraints.accelerations);
            if rest > STILL_DEPENDENT * whole || constraints.residual[row].abs() > CONTRADICTION {
                independent.push(row);
            }
        }
        Ok(independent)
    }

    /// Rows that the others imply at the position for which `kkt` was filled.
    fn dependent_rows(&self, kkt: &Kkt) -> Vec<usize> {
        let scaled = ScaledRows::new(kkt);
        let mut dependent: Vec<usize> = (0..kkt.rows()).filter(|row| scaled.vanishes(*row)).collect();
        let rows: Vec<usize> = self.rows_in_loops(kkt, &scaled).into_iter().filter(|row| !scaled.vanishes(*row)).collect();
        if rows.is_empty() {
            return dependent;
        }
        let mut bodies: Vec<usize> = rows.iter().flat_map(|row| scaled.parts(kkt, *row)).map(|part| part.0).collect();
        bodies.sort_unstable();
        bodies.dedup();
        let mut matrix = DMatrix::zeros(COORDINATES * bodies.len(), rows.len());
        for (column, row) in rows.iter().enumerate() {
            for (body, part) in scaled.parts(kkt, *row) {
                let place = COORDINATES * bodies.partition_point(|other| *other < body);
                matrix.fixed_view_mut::<COORDINATES, 1>(place, column).copy_from(&part);
            }
        }
        dependent.extend(dependent_columns(matrix).into_iter().map(|column| rows[column]));
        dependent.sort_unstable();
        dependent
    }

    /// Rows of the joints that are left when joints at free ends are taken away, again and again.
    fn rows_in_loops(&self, kkt: &Kkt, scaled: &ScaledRows) -> Vec<usize> {
        let mut first_row = 0;
        let rows: Vec<std::ops::Range<usize>> = self
            .joints
            .iter()
            .map(|joint| {
                let start = first_row;
                first_row += joint.rows();
                start..first_row
            })
            .collect();
        let mut joints_of = vec![Vec::new(); self.bodies.len()];
        for (joint, data) in self.joints.iter().enumerate() {
            joints_of[data.bodies.first].push(joint);
            if let Some(second) = data.bodies.second {
                joints_of[second].push(joint);
            }
        }
        let mut present = vec![true; self.joints.len()];
        let mut ends: Vec<usize> = (0..self.bodies.len()).collect();
        while let Some(body) = ends.pop() {
            let mut left = joints_of[body].iter().filter(|joint| present[**joint]);
            let (Some(&joint), None) = (left.next(), left.next()) else { continue };
            let part = |row: usize| scaled.parts(kkt, row).find(|part| part.0 == body).map_or(Coefficients::zeros(), |part| part.1);
            let on_body: Vec<Coefficients> = rows[joint].clone().map(part).collect();
            let independent = on_body.len() <= COORDINATES
                && on_body.iter().all(|part| part.norm() > DEPENDENT)
                && dependent_columns(DMatrix::from_fn(COORDINATES, on_body.len(), |i, j| on_body[j][i] / on_body[j].norm())).is_empty();
            if independent {
                present[joint] = false;
                let bodies = self.joints[joint].bodies;
                ends.extend(std::iter::once(bodies.first).chain(bodies.second).filter(|other| *other != body));
            }
        }
        rows.into_iter().zip(present).filter(|(_, present)| *present).flat_map(|(rows, _)| rows).collect()
    }

    fn row_names(&self, rows: &[usize]) -> String {
        rows.iter().map(|row| self.row_name(*row)).collect::<Vec<_>>().join(", ")
    }
}

/// Columns of `M^-1/2 J^T`, of length one.
struct ScaledRows {
    first: Vec<Coefficients>,
    second: Vec<Coefficients>,
}

impl ScaledRows {
    fn new(kkt: &Kkt) -> Self {
        let roots: Vec<Mobility> = (0..kkt.bodies()).map(|body| root(kkt.mobility(body))).collect();
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for row in 0..kkt.rows() {
            let (bodies, one, two) = kkt.row(row);
            let one = roots[bodies.first] * one;
            let two = bodies.second.map_or(Coefficients::zeros(), |body| roots[body] * two);
            let length = one.norm().hypot(two.norm());
            let largest = std::iter::once(bodies.first).chain(bodies.second).map(|body| roots[body].norm()).fold(0.0, f64::max);
            // Nothing that the row asks for can move.
            let scale = if length > 1e-9 * largest { 1.0 / length } else { 0.0 };
            first.push(one * scale);
            second.push(two * scale);
        }
        ScaledRows { first, second }
    }

    fn vanishes(&self, row: usize) -> bool {
        self.first[row] == Coefficients::zeros() && self.second[row] == Coefficients::zeros()
    }

    /// Bodies of a row with its part on them.
    fn parts(&self, kkt: &Kkt, row: usize) -> impl Iterator<Item = (usize, Coefficients)> {
        let bodies = kkt.row(row).0;
        std::iter::once((bodies.first, self.first[row])).chain(bodies.second.map(|body| (body, self.second[row])))
    }
}

/// Symmetric root of a positive semidefinite matrix.
fn root(matrix: &Mobility) -> Mobility {
    let eigen = matrix.symmetric_eigen();
    eigen.eigenvectors * Mobility::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0).sqrt())) * eigen.eigenvectors.transpose()
}

/// Columns (of length one) that depend on the others. The rank comes from a QR factorisation with pivoting. The
/// columns to blame are those that depend on columns before them, so that what was added last is named; if that does
/// not add up to the rank (columns nearly depend), they are those that the pivoting left over.
fn dependent_columns(matrix: DMatrix<f64>) -> Vec<usize> {
    let columns = matrix.ncols();
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut late = Vec::new();
    for column in 0..columns {
        let mut rest = matrix.column(column).into_owned();
        // Twice, so that rounding does not leave a part along the basis.
        for _ in 0..2 {
            for direction in &basis {
                rest.axpy(-direction.dot(&rest), direction, 1.0);
            }
        }
        let length = rest.norm();
        if length > DEPENDENT {
            basis.push(rest / length);
        } else {
            late.push(column);
        }
    }
    let qr = matrix.col_piv_qr();
    let r = qr.r();
    let rank = (0..r.nrows().min(columns)).filter(|k| r[(*k, *k)].abs() > DEPENDENT).count();
    if rank == basis.len() {
        return late;
    }
    let mut order = RowDVector::from_fn(columns, |_, column| column as f64);
    qr.p().permute_columns(&mut order);
    order.iter().skip(rank).map(|column| *column as usize).collect()
}
