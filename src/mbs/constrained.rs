//! Accelerations of a system with joints and contact constraints.
//!
//! An evaluation goes in steps, so that contact forces that depend on the constraint forces can be iterated between
//! them:
//!
//! ```text
//! apply_forces, prepare_constraints, (contact rows), constraints.kkt.factorise,
//! { free_accelerations, constraints.solve }, constrained_result
//! ```

use super::body::COORDINATES;
use super::kkt::SingularConstraints;
use super::system::{System, SystemWorkspace};

impl System {
    /// Fills mobilities and the joints' rows, residuals, rates and gamma from the workspace's motions, at time t [s].
    #[inline]
    pub fn prepare_constraints(&self, t: f64, workspace: &mut SystemWorkspace) {
        let constraints = &mut workspace.constraints;
        for (body, (data, motion)) in self.bodies.iter().zip(&workspace.motions).enumerate() {
            constraints.kkt.set_mobility(body, &data.mobility(motion));
        }
        for supported in &self.supported {
            let mut mobility = *constraints.kkt.mobility(supported.body);
            supported.slow_down(self.bodies[supported.body].mass, workspace.stations.get(supported.body), &mut mobility);
            constraints.kkt.set_mobility(supported.body, &mobility);
        }
        for drive in &self.drives {
            let mut mobility = *constraints.kkt.mobility(drive.body);
            drive.immobilise(&self.bodies[drive.body], &workspace.motions, &mut mobility, &workspace.stations);
            constraints.kkt.set_mobility(drive.body, &mobility);
        }
        let mut row = 0;
        for joint in &self.joints {
            for values in joint.evaluate(t, &workspace.motions) {
                constraints.kkt.set_row(row, &values.first, &values.second);
                constraints.residual[row] = values.residual;
                constraints.rate[row] = values.rate;
                constraints.gamma[row] = values.gamma;
                row += 1;
            }
        }
    }

    /// Fills the accelerations that the workspace's wrenches cause without constraints (but with imposed speeds).
    #[inline]
    pub fn free_accelerations(&self, workspace: &mut SystemWorkspace) {
        let free = workspace.constraints.free.chunks_exact_mut(COORDINATES);
        let loads = workspace.motions.iter().zip(&workspace.wrenches);
        for ((free, data), (motion, wrench)) in free.zip(&self.bodies).zip(loads) {
            free.copy_from_slice(&data.accelerations(motion, wrench));
        }
        for supported in &self.supported {
            let (body, own) = (supported.body, self.bodies[supported.body].mass);
            let linear = &mut workspace.constraints.free[COORDINATES * body..][..3];
            supported.hold_back(own, workspace.stations.get(body), &workspace.motions[body], linear);
        }
        let SystemWorkspace { constraints, stations, motions, orders, .. } = workspace;
        for drive in &self.drives {
            let linear = &mut constraints.free[COORDINATES * drive.body..][..3];
            match stations.get(drive.body) {
                Some(station) => drive.hold(station, drive.demand(station, motions, stations, orders), linear),
                None => linear[0] = drive.straight_demand(motions, stations, orders),
            }
        }
    }

    /// Derivative of the state from the solved accelerations; fills the driving constraints' forces.
    #[inline]
    pub fn constrained_result(&self, y: &[f64], workspace: &mut SystemWorkspace, dy: &mut [f64]) {
        // A state may go on after the bodies' part.
        let count = COORDINATES * self.bodies.len();
        dy[..count].copy_from_slice(&y[count..2 * count]);
        dy[count..2 * count].copy_from_slice(&workspace.constraints.accelerations);
        workspace.copy_force_rates(count, dy);
        let SystemWorkspace { constraints, wrenches, drive_forces, stations, motions, orders, .. } = workspace;
        for (drive, force) in self.drives.iter().zip(drive_forces) {
            if let Some(station) = stations.get(drive.body) {
                let held = |axis| constraints.kkt.constraint_force(drive.body, axis, &constraints.multipliers);
                let other = wrenches[drive.body].force + nalgebra::Vector3::new(held(0), held(1), held(2));
                let demand = drive.demand(station, motions, stations, orders);
                *force = self.force_in_curve(drive, demand, &other, &motions[drive.body], station);
                continue;
            }
            let demand = drive.straight_demand(motions, stations, orders);
            let held = constraints.kkt.constraint_force(drive.body, 0, &constraints.multipliers);
            *force = self.force_on_straight(drive, demand, wrenches[drive.body].force.x) - held;
        }
    }

    /// Derivative of the state under the wrenches in the workspace and all joints, without contact constraints.
    ///
    /// # Errors
    /// The constraints do not determine their forces.
    pub fn constrained_derivative(
        &self,
        t: f64,
        y: &[f64],
        workspace: &mut SystemWorkspace,
        dy: &mut [f64],
    ) -> Result<(), SingularConstraints> {
        self.fold_wheels(workspace);
        if self.joints.is_empty() {
            self.derivative(y, workspace, dy);
            return Ok(());
        }
        self.prepare_constraints(t, workspace);
        workspace.constraints.kkt.factorise()?;
        self.free_accelerations(workspace);
        workspace.constraints.solve();
        self.constrained_result(y, workspace, dy);
        Ok(())
    }

    /// Name of a row in messages: joint and scalar constraint, or the contact's number.
    pub fn row_name(&self, row: usize) -> String {
        let mut first = 0;
        for joint in &self.joints {
            if row < first + joint.rows() {
                return joint.row_name(row - first);
            }
            first += joint.rows();
        }
        format!("contact constraint {}", row - first + 1)
    }
}
