//! Dry friction in steady running: none on straight track, and in a curve what the way there leaves it.
//!
//! What friction at rest holds depends on how it came to rest. A vehicle that runs from straight track through a transition moves its trucks and springs from one balance to the other in
//! one go; its friction (centre plates, side bearers, wedges) then holds what a slow, straight way between the two leaves ([`ForceElement::drag`](crate::mbs::force::ForceElement::drag)). Continuation
//! ([`super`]) follows that way, but each balance counts from the straight one, so that the result does not depend on its steps.
//!
//! *Left out:* that the way is not quite straight and not run at one rate (a truck turns in before its car), what the road before has left in the friction, and displaced rails, on which friction
//! stays as it was in the ideal curve.

use super::search::Search;
use crate::mbs::force::Rub;
use crate::mbs::system::{System, SystemWorkspace};

/// Of each friction element, by its number among all elements.
#[derive(Clone, Debug, Default)]
pub(super) enum Friction {
    /// It holds nothing.
    #[default]
    Without,
    /// It counts from here.
    Follows(Vec<(usize, Rub)>),
    /// Its states stay these, m.
    Stays(Vec<(usize, Vec<f64>)>),
}

impl Friction {
    /// From the balance on straight track, which `search` has.
    pub fn following(search: &mut Search) -> Friction {
        search.take_places();
        let (system, workspace) = (&search.model.system, &search.workspace.system);
        let rub = |element: usize| Some((element, system.forces[element].rub(&system.seen_by(element, workspace))?));
        Friction::Follows((0..system.forces.len()).filter_map(rub).collect())
    }

    /// What it holds in the balance that `search` has, from here on.
    pub fn staying(search: &mut Search) -> Friction {
        search.take_places();
        let Search { model, workspace, y, friction, .. } = search;
        friction.put(&model.system, &workspace.system, y);
        match friction {
            Friction::Follows(counted) => {
                Friction::Stays(counted.iter().map(|(element, _)| (*element, y[model.system.states_of_force(*element)].to_vec())).collect())
            }
            other => other.clone(),
        }
    }

    /// Puts the states of friction into `y`, with the bodies where they are in the workspace.
    pub fn put(&self, system: &System, workspace: &SystemWorkspace, y: &mut [f64]) {
        match self {
            Friction::Without => {}
            Friction::Follows(counted) => {
                for (element, from) in counted {
                    let state = &mut y[system.states_of_force(*element)];
                    system.forces[*element].drag(from, &system.seen_by(*element, workspace), state);
                }
            }
            Friction::Stays(states) => {
                for (element, state) in states {
                    y[system.states_of_force(*element)].copy_from_slice(state);
                }
            }
        }
    }
}

impl Search<'_> {
    /// Puts the bodies of the workspace where the configuration has them.
    fn take_places(&mut self) {
        self.follow_pattern(true);
        self.model.system.move_bodies(&self.y, &mut self.workspace.system);
    }

    /// Axles are twisted, and friction holds, as in another search.
    pub fn held_as(&mut self, other: &Search) {
        (self.twists, self.friction) = (other.twists.clone(), other.friction.clone());
    }
}
