//! The wheelset of the test set as a [`Dynamics`]: embedded contact conditions, constraints on accelerations, projection.
//!
//! State: q and q' (12 numbers; only beta' of the spin matters). Each evaluation finds the contact points by Newton's method, sets up
//! the constraints on accelerations and iterates the multipliers, because creep forces depend on normal forces. After each step the
//! state is moved back onto the constraints. The gap is held at its initial value instead of 0: the published initial values keep
//! the constraint only to 5e-10 m, and the index-2 form, which has only `J q' = 0`, keeps that.

use super::fixed_point::{Limits, NotSettled, Work, settle};
use super::model::{Rolling, Touch, Wheelset};
use nalgebra::{Vector2, Vector6};
use wheelrail::mbs::kkt::{Kkt, RowBodies};
use wheelrail::solve::{Dynamics, Implicit, Undefined};

/// Memory: psi and xi of both contacts, both multipliers.
pub const MULTIPLIERS: usize = 4;
pub const MEMORY: usize = 6;

const LOOP: Limits = Limits { relative: 1e-13, floor: 0.0, iterations: 50, accepted: 0.0 };

/// What rounding leaves of the constraints: m, m/s.
const GAP_ROUNDING: f64 = 1e-16;
const RATE_ROUNDING: f64 = 1e-16;
const CORRECTIONS: usize = 3;

pub struct Motion<'a> {
    wheelset: &'a Wheelset,
    kkt: Kkt,
    work: Work,
    /// Gaps to be kept, m.
    gaps: [f64; 2],
    /// A step ends here, s.
    end: f64,
    /// Largest violation of the constraints that projection met: m, m/s.
    pub drift: [f64; 2],
    /// Evaluations of the creep forces in the loop of the normal forces.
    pub creep_evaluations: u64,
    /// Of the evaluation made last, and as accepted.
    pub memory: [f64; MEMORY],
    pub accepted: [f64; MEMORY],
}

impl<'a> Motion<'a> {
    pub fn new(wheelset: &'a Wheelset, gaps: [f64; 2], end: f64) -> Self {
        let row = RowBodies { first: 0, second: None };
        Motion {
            wheelset,
            kkt: Kkt::new(1, &[row; 2]),
            work: Work::new(2),
            gaps,
            end,
            drift: [0.0; 2],
            creep_evaluations: 0,
            memory: [0.0; MEMORY],
            accepted: [0.0; MEMORY],
        }
    }

    /// Contacts at q; the system is factorised there.
    fn prepare(&mut self, q: &Vector6<f64>, memory: &mut [f64]) -> Result<[Touch; 2], Undefined> {
        for contact in memory[..MULTIPLIERS].chunks_exact_mut(2) {
            let mut found = Vector2::new(contact[0], contact[1]);
            self.wheelset.find_contact(q, &mut found).map_err(|_| Undefined)?;
            contact.copy_from_slice(found.as_slice());
        }
        let touches = contacts(memory).map(|contact| self.wheelset.touch(q, &contact));
        self.kkt.set_mobility(0, &self.wheelset.mobility(q[4]));
        for (row, touch) in touches.iter().enumerate() {
            self.kkt.set_row(row, &touch.row, &Vector6::zeros());
        }
        self.kkt.factorise().map_err(|_| Undefined)?;
        Ok(touches)
    }

    /// Accelerations; multipliers and contacts are left in the memory.
    pub fn accelerations(&mut self, q: &Vector6<f64>, v: &Vector6<f64>, memory: &mut [f64]) -> Result<Vector6<f64>, Undefined> {
        let touches = self.prepare(q, memory)?;
        let (wheelset, kkt) = (self.wheelset, &mut self.kkt);
        let points = contacts(memory);
        let mut gamma = [0.0; 2];
        for (gamma, contact) in gamma.iter_mut().zip(&points) {
            *gamma = wheelset.gamma(q, v, contact).ok_or(Undefined)?;
        }
        let rollings: [Rolling; 2] = std::array::from_fn(|i| wheelset.rolling(q, v, &points[i], &touches[i]));
        let applied = wheelset.applied(q, v);
        let mobility = wheelset.mobility(q[4]);
        let mut accelerations = Vector6::zeros();
        let evaluations = settle::<NotSettled>(&mut memory[MULTIPLIERS..], LOOP, &mut self.work, |multipliers, image| {
            let creep = |i: usize| wheelset.creep(&rollings[i], &touches[i], multipliers[i]);
            let free = mobility * (applied + creep(0) + creep(1));
            kkt.solve(free.as_slice(), &gamma, accelerations.as_mut_slice(), image);
            Ok(())
        });
        self.creep_evaluations += evaluations.map_err(|_| Undefined)? as u64;
        Ok(accelerations)
    }

    /// Violation of both constraints: m, m/s.
    pub fn violation(&mut self, y: &[f64], memory: &mut [f64]) -> Result<[f64; 2], Undefined> {
        let (q, v) = (Vector6::from_column_slice(&y[..6]), Vector6::from_column_slice(&y[6..]));
        let touches = self.prepare(&q, memory)?;
        Ok([largest(&self.gap_errors(&touches)), largest(&touches.map(|touch| touch.row.dot(&v)))])
    }

    fn gap_errors(&self, touches: &[Touch; 2]) -> [f64; 2] {
        std::array::from_fn(|i| touches[i].gap - self.gaps[i])
    }
}

fn contacts(memory: &[f64]) -> [Vector2<f64>; 2] {
    [Vector2::new(memory[0], memory[1]), Vector2::new(memory[2], memory[3])]
}

fn largest(values: &[f64; 2]) -> f64 {
    values[0].abs().max(values[1].abs())
}

impl Dynamics for Motion<'_> {
    fn derivative(&mut self, _t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        let (q, v) = (Vector6::from_column_slice(&y[..6]), Vector6::from_column_slice(&y[6..]));
        let mut memory = self.memory;
        let accelerations = self.accelerations(&q, &v, &mut memory)?;
        self.memory = memory;
        dy[..6].copy_from_slice(v.as_slice());
        dy[6..].copy_from_slice(accelerations.as_slice());
        Ok(())
    }

    /// Creep lets velocities settle within some hundredths of a second.
    fn error_weight(&self, i: usize) -> f64 {
        match i {
            0..5 => 1.0,
            5 => 0.0,
            _ => 0.01,
        }
    }

    fn next_break(&self, t: f64, _y: &[f64]) -> f64 {
        if t < self.end { self.end } else { f64::INFINITY }
    }

    fn project(&mut self, _t: f64, y: &mut [f64]) -> Result<bool, Undefined> {
        let mut memory = self.memory;
        let memory = &mut memory;
        let mut changed = false;
        let mut change = Vector6::zeros();
        let mut touches = self.prepare(&Vector6::from_column_slice(&y[..6]), memory)?;
        self.drift[0] = self.drift[0].max(largest(&self.gap_errors(&touches)));
        for _ in 0..CORRECTIONS {
            let errors = self.gap_errors(&touches);
            if largest(&errors) <= GAP_ROUNDING {
                break;
            }
            self.kkt.correction(&errors, change.as_mut_slice());
            y[..6].iter_mut().zip(&change).for_each(|(y, change)| *y += change);
            touches = self.prepare(&Vector6::from_column_slice(&y[..6]), memory)?;
            changed = true;
        }
        let v = Vector6::from_column_slice(&y[6..]);
        let errors = touches.map(|touch| touch.row.dot(&v));
        self.drift[1] = self.drift[1].max(largest(&errors));
        if largest(&errors) > RATE_ROUNDING {
            self.kkt.correction(&errors, change.as_mut_slice());
            y[6..].iter_mut().zip(&change).for_each(|(y, change)| *y += change);
            changed = true;
        }
        self.memory = *memory;
        Ok(changed)
    }

    fn rollback(&mut self) {
        self.memory = self.accepted;
    }

    fn accept(&mut self, _: bool) {
        self.accepted = self.memory;
    }
}

impl Implicit for Motion<'_> {}
