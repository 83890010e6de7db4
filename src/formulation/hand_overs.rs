//! Constraints that became elastic contacts for a while (`contact.on_lift = "elastic"`): how often, and how their forces swung then.
//!
//! A constraint whose place ceases leaves a wheel that rings on its contact, some 100 to 300 Hz, until damping ends it. When it begins is as sharp as the
//! lateral place that decides it: an error e of y moves it by e / y', which is milliseconds where the wheelset turns back (1 um at 1 mm/s is 1 ms),
//! and a hand-over that one run makes another may not. So loads of such a phase hold to their swing, whatever the tolerance says.

use super::step::WheelRef;
use super::{Model, OnLift, Workspace};
use serde::{Deserialize, Serialize};

/// So long after a hand-over its ringing counts, s: later swings are those of the load itself.
const RINGS: f64 = 0.02;
/// Swings from end to end below this part of the static load are not worth a word.
const LEAST: f64 = 0.04;

/// Of one wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Phases {
    /// Since when it is elastic, s, and the least and greatest of each component of its force since then, by the static load.
    now: Option<(f64, [f64; 3], [f64; 3])>,
    /// Has it been a constraint?
    rigid: bool,
    /// Hand-overs so far, and when the first was, s.
    count: u32,
    first: f64,
    /// Largest swing from end to end by the static load, when its phase began, s, and of which component.
    worst: (f64, f64, usize),
}

impl Phases {
    fn note(&mut self, elastic: bool, shares: [f64; 3], t: f64) {
        let begins = elastic && self.rigid && self.now.is_none();
        self.rigid |= !elastic;
        if begins {
            self.first = if self.count == 0 { t } else { self.first };
            self.count = self.count.saturating_add(1);
        }
        let (since, least, most) = match self.now {
            _ if !elastic => return self.now = None,
            Some((since, least, most)) if t - since <= RINGS => {
                let of = |pick: fn(f64, f64) -> f64, known: [f64; 3]| [0, 1, 2].map(|k| pick(shares[k], known[k]));
                (since, of(f64::min, least), of(f64::max, most))
            }
            None if begins => (t, shares, shares),
            _ => return,
        };
        self.now = Some((since, least, most));
        for component in 0..3 {
            let swing = most[component] - least[component];
            if swing > self.worst.0 {
                self.worst = (swing, since, component);
            }
        }
    }

    fn take_back(&mut self, time: f64) {
        if self.count > 0 && self.first > time {
            *self = Phases { rigid: self.rigid, ..Phases::default() };
        }
        self.now = self.now.filter(|now| now.0 <= time);
        if self.worst.1 > time {
            self.worst = Default::default();
        }
    }
}

/// Looks at the wheels of an evaluation at `t` [s].
pub(super) fn look(model: &Model, workspace: &Workspace, t: f64, phases: &mut [Phases]) {
    for (WheelRef { contact, wheelset, .. }, phases) in model.wheels().zip(phases) {
        let elastic = !workspace.reports(contact).any(|report| report.constrained);
        phases.note(elastic, (workspace.wheel_force(contact, wheelset.body) / wheelset.static_wheel_load).into(), t);
    }
}

/// One per wheel of a model whose constraints may become elastic; else none.
pub(super) fn of(model: &Model) -> Vec<Phases> {
    let may = model.formulation.on_lift() == Some(OnLift::Elastic);
    vec![Phases::default(); if may { model.contacts() } else { 0 }]
}

/// Forgets what came after `time` [s].
pub(super) fn take_back(phases: &mut [Phases], time: f64) {
    phases.iter_mut().for_each(|phases| phases.take_back(time));
}

/// What a user should know.
pub(super) fn note(phases: &[Phases], named: impl Fn(usize) -> String) -> Option<String> {
    let count: u32 = phases.iter().map(|phases| phases.count).sum();
    let (contact, worst) = phases.iter().enumerate().max_by(|a, b| a.1.worst.0.total_cmp(&b.1.worst.0))?;
    (count > 0 && worst.worst.0 >= LEAST).then(|| {
        format!(
            "{count} {} as a constraint became elastic, for a while or until the end: the wheel then rings on its contact, and since errors of the size of the tolerance shift the instant, \
             loads at an instant are known to no more than that ringing there ({} force: up to {:.0} % of the static load from end to end, {} from {:.4} s on); elastic contact (ECF-A) hands nothing over",
            if count == 1 { "time a contact that began" } else { "times a contact that began" },
            ["longitudinal", "lateral", "vertical"][worst.worst.2],
            100.0 * worst.worst.0,
            named(contact),
            worst.worst.1
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_ringing_after_a_hand_over_is_measured_and_what_was_elastic_from_the_start_is_none() {
        let mut phases = Phases::default();
        let ring = |t: f64| 1.0 + 0.1 * (1000.0 * t).sin();
        // Elastic from the start, a constraint, elastic again from 0.2 s on, and slowly loaded later.
        for k in 0..4000 {
            let t = 1e-4 * f64::from(k);
            let elastic = !(0.1..0.2).contains(&t);
            let share = if t < 0.1 {
                1.0 + t
            } else if t < 0.25 {
                ring(t)
            } else {
                3.0
            };
            phases.note(elastic, [0.0, 0.5 * share, share], t);
        }
        assert!(phases.count == 1 && (phases.first - 0.2).abs() < 2e-4 && (phases.worst.1 - 0.2).abs() < 2e-4, "{phases:?}");
        assert!((phases.worst.0 - 0.2).abs() < 2e-3 && phases.worst.2 == 2, "{phases:?}");
        let words = note(&[Phases::default(), phases], |contact| format!("wheel {contact}")).unwrap();
        assert!(
            words.starts_with("1 time a") && words.contains("vertical force: up to 20 % of") && words.contains("wheel 1 from 0.2"),
            "{words}"
        );
        let before = phases;
        phases.take_back(0.3);
        assert_eq!(phases.count, before.count);
        phases.take_back(0.15);
        assert!(note(&[phases], |_| String::new()).is_none() && phases.rigid);
    }
}
