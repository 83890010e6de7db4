//! Balance of vehicles whose couplers have slack.
//!
//! In the middle of its slack a coupler has no stiffness: Newton's method knows nothing of what a vehicle does there, and steps far beyond. So the
//! slack along the track is taken away first: each coupler is then a spring from its middle on and has the force T that balance
//! asks for. Back in the scene's slack the same balance has each coupler longer (T > 0) or shorter by its free travel, so that all vehicles behind it
//! stand moved by that, and Newton's method begins there.

use super::search::Search;
use crate::mbs::force::ForceElement;
use crate::mbs::system::System;
use crate::scene::equilibrium::EquilibriumError;

/// Forces below this leave a coupler in the middle of its slack, N.
const LEAST: f64 = 1e-3;
/// Name of the slack among an element's numbers.
const CLEARANCE: &str = "clearance";

/// A coupler with slack.
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
    let clearance = force.constants().into_iter().find(|number| number.name == CLEARANCE && number.value > 0.0)?;
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
        if !slacks.is_empty() && self.balance_without(&slacks) && self.balance().is_ok() {
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
        let bodies = self.workspace.system.moving();
        // What pulls is longer than in the middle.
        let pulls = |slack: &Slack| {
            let element = &self.model.system.forces[slack.element];
            let states = self.model.system.states_of_force(slack.element);
            let tension = element.quantity(0, &bodies, &self.y[states]);
            if tension.abs() < LEAST { 0.0 } else { tension.signum() }
        };
        let longer: Vec<f64> = slacks.iter().map(|slack| slack.sign * slack.clearance * pulls(slack)).collect();
        set(self, 1.0);
        if found {
            for (at, forward) in self.now.at.iter_mut().zip(moves(&self.model.system, slacks, &longer)) {
                at.coordinates[0] += forward;
            }
        }
        found
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
