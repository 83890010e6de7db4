//! What friction and twisted axles of a search hold: begun at a balance, and taken over from another search.

use super::continuation::{Before, Steps};
use super::friction::Friction;
use super::search::Search;

impl Search<'_> {
    /// Friction counts from the balance that it has, on straight track.
    pub fn friction_from_here(&mut self) -> Friction {
        self.take_places();
        Friction::following(&self.model.system, &self.workspace.system)
    }

    /// Lets friction, which the balance in a curve was found without, hold more and more of what it then would, up to the share with which there is a balance.
    pub fn rub_in(&mut self, friction: &Friction) {
        let steps = Steps { from: 0.0, to: 1.0, first: 0.25, growth: 2.0, shortest: 0.02 };
        let mut reached = 0.0;
        let balance = |search: &mut Search, done: f64, next: f64, before: Option<&Before>| {
            search.friction = friction.in_part(next);
            if let Some(before) = before {
                search.go_on(&before.1, before.ahead(done, next));
            }
            search.balance().inspect(|()| reached = next)
        };
        // What was found last is in place then.
        let _ = steps.follow(self, balance);
        if reached < 1.0 {
            self.friction = friction.in_part(reached);
            self.take_places();
            self.friction.put(&self.model.system, &self.workspace.system, &mut self.y);
        }
    }

    /// Friction stays what it is in the balance that it has.
    pub fn keep_friction(&mut self) {
        self.take_places();
        self.friction = self.friction.staying(&self.model.system, &self.workspace.system, &mut self.y);
    }

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
