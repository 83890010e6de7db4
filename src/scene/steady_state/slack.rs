//! Balance of vehicles whose couplers have slack.
//!
//! In the middle of its slack a coupler has no stiffness: Newton's method knows nothing of what a vehicle does there, and steps far beyond. So the
//! slack along the track is taken away first: each coupler is then a spring from its middle on and has the force T that balance
//! asks for. Back in the scene's slack the same balance has each coupler longer (T > 0) or shorter by its free travel, so that all vehicles behind it
//! stand moved by that, and Newton's method begins there.

use super::search::{Search, Unknown};
use crate::formulation::EvaluationError;
use crate::mbs::force::ForceElement;
use crate::mbs::system::System;
use crate::scene::equilibrium::EquilibriumError;

/// Forces below this leave a coupler in the middle of its slack, N.
const LEAST: f64 = 1e-3;
/// Lengths are right to this, m, and after so many rounds at most.
const EXACT: f64 = 1e-13;
const ROUNDS: usize = 8;
/// Numbers of a coupler's quantities.
const TENSION: usize = 0;
const DISPLACEMENT: usize = 1;
/// Name of the slack among an element's numbers.
const CLEARANCE: &str = "clearance";

/// How far a vehicle is moved along the track for a difference, m. A coupler that holds a newton or less is pulled or pushed by less than a micrometre, and beyond lies
/// its slack, or its other stiffness: with steps of 1e-6 m trains that hang together by such forces had no balance.
const STEP: f64 = 1e-8;

/// A coupler; its slack may be none.
struct Slack {
    element: usize,
    /// Number of its clearance, and the clearance, m.
    number: u32,
    clearance: f64,
    /// Bodies that it joins.
    ends: [usize; 2],
    /// Does it become longer when its second end moves forward? 1 or -1.
    sign: f64,
}

fn slack_of(search: &Search, element: usize, force: &dyn ForceElement) -> Option<Slack> {
    let clearance = force.constants().into_iter().find(|number| number.name == CLEARANCE)?;
    let strike = force.strike(&search.workspace.system.moving())?;
    let [Some(first), Some(second)] = strike.ends else { return None };
    let sign = strike.along(&search.axes(first).column(0).into_owned())?.signum();
    Some(Slack { element, number: clearance.number, clearance: clearance.value, ends: [first, second], sign })
}

impl Search<'_> {
    /// Finds the balance from where the bodies stand with their wheels on the rails.
    ///
    /// # Errors
    /// There is none, or it was not found.
    pub fn balance_with_slack(&mut self) -> Result<(), EquilibriumError> {
        let before = self.configuration();
        // Elements tell their lines where the bodies were evaluated.
        self.rest(true, false).map_err(EquilibriumError::Evaluation)?;
        let slacks: Vec<Slack> =
            self.model.system.forces.iter().enumerate().filter_map(|(i, force)| slack_of(self, i, force.as_ref())).collect();
        let joined = |body: usize| slacks.iter().any(|slack| slack.ends.contains(&body));
        for unknown in &mut self.unknowns {
            if let Unknown::Coordinate { body, axis: 0, step } = unknown
                && joined(*body)
            {
                *step = STEP;
            }
        }
        if slacks.iter().any(|slack| slack.clearance > 0.0) && self.balance_without(&slacks) && self.balance().is_ok() {
            return Ok(());
        }
        self.put(&before);
        self.balance()
    }

    /// Balances without slack and puts the bodies where they stand with it.
    fn balance_without(&mut self, slacks: &[Slack]) -> bool {
        let set = |search: &mut Self, free: f64| {
            for Slack { element, number, clearance, .. } in slacks {
                search.model.system.forces[*element].set_constant(*number, free * clearance);
            }
        };
        set(self, 0.0);
        let found = self.balance().is_ok();
        // What pulls is longer by its free travel than without.
        let longer = |slack: &Slack| {
            let tension = self.quantity_of(slack, TENSION);
            self.quantity_of(slack, DISPLACEMENT) + if tension.abs() < LEAST { 0.0 } else { tension.signum() * slack.clearance }
        };
        let wanted: Vec<f64> = slacks.iter().map(longer).collect();
        set(self, 1.0);
        found && self.put_apart(slacks, &wanted).is_ok()
    }

    /// Moves vehicles along the track until their couplers are as long as wanted [m]: one that is inclined grows by less than its ends move.
    fn put_apart(&mut self, slacks: &[Slack], wanted: &[f64]) -> Result<(), EvaluationError> {
        for _ in 0..ROUNDS {
            self.rest(true, false)?;
            let missing = |(slack, wanted): (&Slack, &f64)| wanted - self.quantity_of(slack, DISPLACEMENT);
            let missing: Vec<f64> = slacks.iter().zip(wanted).map(missing).collect();
            if missing.iter().all(|missing| missing.abs() < EXACT) {
                break;
            }
            let longer: Vec<f64> = slacks.iter().zip(missing).map(|(slack, missing)| slack.sign * missing).collect();
            for (at, forward) in self.now.at.iter_mut().zip(moves(&self.model.system, slacks, &longer)) {
                at.coordinates[0] += forward;
            }
        }
        Ok(())
    }

    /// Of a coupler where the bodies were evaluated.
    fn quantity_of(&self, slack: &Slack, index: usize) -> f64 {
        let states = self.model.system.states_of_force(slack.element);
        self.model.system.forces[slack.element].quantity(index, &self.workspace.system.moving(), &self.y[states])
    }
}

/// How far each body moves forward when the second ends of the slacks move by these lengths [m] from the first ones. Wheelsets with an imposed speed stay where
/// they are; where there are none, the first does.
fn moves(system: &System, slacks: &[Slack], longer: &[f64]) -> Vec<f64> {
    let is_slack = |element: usize| slacks.iter().any(|slack| slack.element == element);
    let fixed = system.forces.iter().enumerate().filter(|(i, _)| !is_slack(*i)).map(|(_, force)| force.reach());
    let fixed = fixed.chain(system.joints.iter().map(|joint| [Some(joint.bodies.first), joint.bodies.second, None]));
    let mut ties: Vec<(usize, usize, f64)> = Vec::new();
    for bodies in fixed {
        let mut bodies = bodies.into_iter().flatten();
        let first = bodies.next();
        ties.extend(bodies.filter_map(|other| Some((first?, other, 0.0))));
    }
    // Bodies without slack between them move together, so they are looked at first.
    ties.extend(slacks.iter().zip(longer).map(|(slack, longer)| (slack.ends[0], slack.ends[1], *longer)));
    let mut moved: Vec<Option<f64>> = vec![None; system.bodies.len()];
    let stay = if system.drives.is_empty() { vec![0] } else { system.drives.iter().map(|drive| drive.body).collect() };
    stay.into_iter().for_each(|body| moved[body] = Some(0.0));
    while let Some((body, by)) = ties.iter().find_map(|(a, b, longer)| match (moved[*a], moved[*b]) {
        (Some(known), None) => Some((*b, known + longer)),
        (None, Some(known)) => Some((*a, known - longer)),
        _ => None,
    }) {
        moved[body] = Some(by);
    }
    moved.into_iter().map(|by| by.unwrap_or(0.0)).collect()
}
