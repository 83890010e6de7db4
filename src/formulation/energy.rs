//! The books of a vehicle's energy: what brings power in, what takes it, and the integrals of both as states.
//!
//! With E the kinetic energy of all bodies (and of the loads that wheelsets support) and the stored energy of all force elements
//!
//! ```text
//! dE/dt = inputs of wheelsets + imposed speeds + inputs of elements - heat of elements - friction of wheels + contact + guides
//!
//! inputs of a wheelset   F . v + T w_a          (forces on the centre, torque about the axle)
//! imposed speed          F_d X . v              (force of the driving constraint)
//! friction of a wheel    -(Fx s_x + Fy s_y + Mz s_n), summed over its contacts: what slip takes
//! guides                 what stands for parts that are cut away (`vehicle.detail`) and gravity pulls down a grade: from outside
//! contact                the rest of what contacts do on the wheels: elastic compression, damping, rails that move
//! ```
//!
//! s is the slip of the wheel's material against that of the rail (m/s, rad/s about the normal). This holds at every instant for any law of contact, so that what the
//! integrals leave over is the error of the integration alone. Two things are in no book: a rigid contact that lands or lifts, and in curves (vertical ones too) what turns the weight of a
//! wheelset's supported load and what its suspension's travelling frame does.
//!
//! The integrals are states without weight in the error control: steps are those of the run without them. They are as exact as the method is for what it does not control; of implicit adaptive steps
//! they are made from the solution (`solve::integrals`).

use super::energy_books::{CONTACT, EnergyBooks};
use super::inputs::{DRIVE_TORQUE, LATERAL_FORCE, LONGITUDINAL_FORCE, VERTICAL_FORCE, WHEELSET_INPUTS};
use super::rail_motion::AgainstRail;
use super::{ContactReport, Model, Workspace, contact_index};
use crate::geometry::Side;
use nalgebra::Vector3;

impl Model {
    /// Does the model keep the books of its energy from now on?
    pub fn with_energy_books(mut self, asked: bool) -> Self {
        self.books = asked.then(|| EnergyBooks::new(&self.system, self.wheelsets.len()));
        self
    }

    /// What a user should know of the books where an implicit method integrates them by its stages (`Integrator::lags_in_integrals`): they lie beside the motion by what is stiff,
    /// and lag behind rails that move from outside (wheelset on rails that swing by 2 mm at 8 Hz, inputs each ms, `real_time` with 0.2 ms: contact work 570 J for 554, driving work 249 for 180).
    pub fn books_note(&self) -> Option<String> {
        (self.books.is_some() && self.rail_motion).then(|| {
            "works and heats (outputs \"energy\") are integrals over the steps of an implicit method, which lag behind rails that move from outside: they may be wrong by more \
             than what they say; an adaptive solver.integrator has them right. Motions and forces are not concerned"
                .into()
        })
    }

    /// Rates of the books from the forces that were found last.
    pub(super) fn book_energy(&self, workspace: &Workspace, inputs: &[f64], y: &[f64], dy: &mut [f64]) {
        let Some(books) = &self.books else { return };
        let begin = self.books_begin();
        let rates = &mut dy[begin..begin + books.states()];
        rates.fill(0.0);
        for (index, wheelset) in self.wheelsets.iter().enumerate() {
            for side in Side::BOTH {
                let contact = contact_index(index, side);
                let friction = friction_power(workspace, contact);
                rates[books.friction(index, side)] = friction;
                rates[CONTACT] += self.wheel_power(workspace, (inputs, y), (index, side)) + friction;
            }
            rates[books.inputs(index)] = input_power(workspace, inputs, index, wheelset.body);
        }
        for (index, drive) in self.system.drives.iter().enumerate() {
            rates[books.drive(index)] = driving_power(workspace, index, drive.body);
        }
        for account in &books.accounts {
            let (force, bodies) = (&self.system.forces[account.element], workspace.system.with_inputs(account.inputs.clone()));
            let own = &y[account.own.clone()];
            if let Some(work) = account.work {
                rates[work] += force.supplied_power(&bodies, own);
            }
            if let Some(heat) = account.heat {
                rates[heat] += force.dissipated_power(&bodies, own);
            }
        }
    }
}

impl Model {
    /// Power of all contacts of a wheel on it, W: their wrench on what turns (the wheel itself, where the axle twists), with arms from where the wheel stands against a rail that has
    /// moved, with what turns a wheel that is not round (`out_of_round`), and with what does so on a bent rail (`rail_motion`).
    pub fn wheel_power(&self, workspace: &Workspace, (inputs, y): (&[f64], &[f64]), (wheelset, side): (usize, Side)) -> f64 {
        let (contact, own) = (contact_index(wheelset, side), &self.wheelsets[wheelset]);
        let turning = own.turning[side.index()];
        let motion = &workspace.system.motions[turning];
        let moved = self.against_rail((&workspace.system, &workspace.rails), (inputs, y), (own.body, turning), contact);
        let stands = moved.as_ref().map_or(motion.position, |moved| moved.motion.position);
        let of = |k: &ContactReport| {
            let moment = (k.wheel_point - stands).cross(&k.force) + k.axes.normal * k.creep_force.spin_moment + k.couple;
            k.force.dot(&motion.velocity) + moment.dot(&motion.rotation)
        };
        workspace.reports(contact).map(of).sum::<f64>() + moved.map_or(0.0, |moved| self.turning_power(workspace, &moved, contact))
    }

    /// Power of what turns a wheel that is not round, or on a bent rail, because its contacts are ahead of its lowest place, W.
    pub fn power_of_turns(&self, workspace: &Workspace, (inputs, y): (&[f64], &[f64]), (wheelset, side): (usize, Side)) -> f64 {
        let (contact, own) = (contact_index(wheelset, side), &self.wheelsets[wheelset]);
        let bodies = (own.body, own.turning[side.index()]);
        let moved = self.against_rail((&workspace.system, &workspace.rails), (inputs, y), bodies, contact);
        moved.map_or(0.0, |moved| self.turning_power(workspace, &moved, contact))
    }

    fn turning_power(&self, workspace: &Workspace, moved: &AgainstRail, contact: usize) -> f64 {
        let motion = &workspace.system.motions[self.wheelsets[contact / 2].turning[contact % 2]];
        (self.turned_by_lead(workspace, moved, contact) - self.turned_by_bumps(workspace, moved, contact)).dot(&motion.rotation)
    }
}

/// Power that slip takes at all contacts of a wheel, W.
pub fn friction_power(workspace: &Workspace, contact: usize) -> f64 {
    let of = |k: &ContactReport| {
        let (force, slip) = (&k.creep_force, &k.slip);
        -(force.longitudinal * slip.longitudinal + force.lateral * slip.lateral + force.spin_moment * slip.spin)
    };
    workspace.reports(contact).map(of).sum()
}

/// Power of the inputs of a wheelset, W; its forces are in the axes of the track beside it.
pub fn input_power(workspace: &Workspace, inputs: &[f64], wheelset: usize, body: usize) -> f64 {
    let (motion, own) = (&workspace.system.motions[body], &inputs[WHEELSET_INPUTS * wheelset..][..WHEELSET_INPUTS]);
    let force = Vector3::new(own[LONGITUDINAL_FORCE], own[LATERAL_FORCE], own[VERTICAL_FORCE]);
    let velocity = workspace.in_track(body, motion.velocity);
    force.dot(&velocity) + own[DRIVE_TORQUE] * motion.axle().dot(&motion.rotation)
}

/// Power of a driving constraint on its body, W.
pub fn driving_power(workspace: &Workspace, drive: usize, body: usize) -> f64 {
    workspace.system.drive_forces[drive] * workspace.in_track(body, workspace.system.motions[body].velocity).x
}
