//! Dry friction in steady running: none on straight track, and in a curve what the way there leaves it.
//!
//! What friction at rest holds depends on how it came to rest. A vehicle that runs from straight track through a transition moves its trucks and springs from one balance to the other in
//! one go; its friction (centre plates, side bearers, wedges) then holds what a slow, straight way between the two leaves ([`ForceElement::drag`](crate::mbs::force::ForceElement::drag)). Continuation
//! ([`super`]) follows that way, but each balance counts from the straight one, so that the result does not depend on its steps.
//!
//! *Left out:* that the way is not quite straight and not run at one rate (a truck turns in before its car), what the road before has left in the friction, and displaced rails, on which friction
//! stays as it was in the ideal curve.

use crate::mbs::force::Rub;
use crate::mbs::system::{System, SystemWorkspace};

/// Of each friction element, by its number among all elements.
#[derive(Clone, Debug, Default)]
pub(super) enum Friction {
    /// It holds nothing.
    #[default]
    Without,
    /// It counts from here, and holds this share of what it then would.
    Follows(Vec<(usize, Rub)>, f64),
    /// Its states stay these, m, that share of what it would hold.
    Stays(Vec<(usize, Vec<f64>)>, f64),
}

impl Friction {
    /// From the balance on straight track, with its bodies in the workspace.
    pub fn following(system: &System, workspace: &SystemWorkspace) -> Friction {
        let rub = |element: usize| Some((element, system.forces[element].rub(&system.seen_by(element, workspace))?));
        let counted: Vec<(usize, Rub)> = (0..system.forces.len()).filter_map(rub).collect();
        if counted.is_empty() { Friction::Without } else { Friction::Follows(counted, 1.0) }
    }

    /// Of what it would hold.
    pub fn share(&self) -> f64 {
        match self {
            Friction::Without => 1.0,
            Friction::Follows(_, share) | Friction::Stays(_, share) => *share,
        }
    }

    /// The same with a share of what it holds.
    pub fn in_part(&self, share: f64) -> Friction {
        match self {
            Friction::Follows(counted, _) => Friction::Follows(counted.clone(), share),
            other => other.clone(),
        }
    }

    /// What it holds with the bodies where they are in the workspace, from here on.
    pub fn staying(&self, system: &System, workspace: &SystemWorkspace, y: &mut [f64]) -> Friction {
        self.put(system, workspace, y);
        match self {
            Friction::Follows(counted, share) => {
                let states = counted.iter().map(|(element, _)| (*element, y[system.states_of_force(*element)].to_vec()));
                Friction::Stays(states.collect(), *share)
            }
            other => other.clone(),
        }
    }

    /// Puts the states of friction into `y`, with the bodies where they are in the workspace.
    pub fn put(&self, system: &System, workspace: &SystemWorkspace, y: &mut [f64]) {
        match self {
            Friction::Without => {}
            Friction::Follows(counted, share) => {
                for (element, from) in counted {
                    let state = &mut y[system.states_of_force(*element)];
                    system.forces[*element].drag(from, &system.seen_by(*element, workspace), state);
                    state.iter_mut().for_each(|state| *state *= share);
                }
            }
            Friction::Stays(states, _) => {
                for (element, state) in states {
                    y[system.states_of_force(*element)].copy_from_slice(state);
                }
            }
        }
    }
}
