//! What `solver.integrator = "auto"` stands for, and what a plan says about a scene's integrator.

use super::spec::Scene;
use super::vehicle::VehicleSpec;
use crate::contact::search::algebraic;
use crate::mbs::projection;
use crate::settings::{Section, SettingsError};
use crate::solve::AUTO;
use crate::units::Dimension;

/// What the choice depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facts {
    /// Is (tread) contact a constraint?
    pub constrained: bool,
    pub bodies: usize,
    /// Bound of the local error, m; `None` where the scene gives a step alone.
    pub tolerance: Option<f64>,
}

/// One line of the rule: the first that fits holds.
struct Rule {
    integrator: &'static str,
    fits: fn(&Facts) -> bool,
    why: &'static str,
}

/// Below this tolerance [m] a method of order 3 takes steps so short that contact's vibration no longer limits an explicit one of
/// order 5.
const TIGHT: f64 = 1e-9;

/// The one place where the choice is made.
const RULES: &[Rule] = &[
    Rule {
        integrator: "generalised_alpha",
        fits: |facts| facts.tolerance.is_none(),
        why: "the scene gives a step and no tolerance; implicit, so that the step need not follow contact's vibration",
    },
    Rule {
        integrator: "dormand_prince",
        fits: |facts| facts.constrained,
        why: "contact as a constraint does not vibrate: accuracy limits the step, and high order pays",
    },
    Rule {
        integrator: "dormand_prince",
        fits: |facts| facts.bodies == 1,
        why: "one wheelset: an evaluation is cheap, and a Jacobian costs more than the steps that it saves",
    },
    Rule {
        integrator: "dormand_prince",
        fits: |facts| facts.tolerance.is_some_and(|tolerance| tolerance < TIGHT),
        why: "tolerance below 1e-9: accuracy limits the step, and high order pays",
    },
    Rule {
        integrator: "rosenbrock",
        fits: |_| true,
        why: "elastic contact of a vehicle: its vibration would limit an explicit method's step, accuracy asks for less",
    },
];

/// The method for a scene, and why.
pub fn choose(facts: &Facts) -> (&'static str, &'static str) {
    let rule = RULES.iter().find(|rule| (rule.fits)(facts)).unwrap_or(&RULES[RULES.len() - 1]);
    (rule.integrator, rule.why)
}

/// Formulations in which contact is a constraint.
const CONSTRAINED: &[&str] = &["ACCF", "ECCF"];

/// The facts of a scene that is being read.
pub(super) fn facts(solver: &Section, vehicle: &VehicleSpec, formulation: &str) -> Result<Facts, SettingsError> {
    Ok(Facts {
        constrained: CONSTRAINED.contains(&formulation),
        bodies: vehicle.free.as_ref().map_or(1, |free| free.body_count()),
        tolerance: solver.optional("tolerance", Dimension::Length)?,
    })
}

/// Lines for the plan: the choice where the scene leaves it open, and the worst case where the method has one.
pub(super) fn notes(scene: &Scene) -> Vec<String> {
    let solver = &scene.solver;
    let chosen = solver.why.map(|why| format!("solver.integrator = \"{}\" is {}: {why}", AUTO.name, solver.name));
    let bounded = solver.integrator.worst_case().map(|worst| {
        let search = algebraic::LIMITS.iterations;
        let constraints = match CONSTRAINED.contains(&scene.contact.formulation_name) || joined(&scene.vehicle) {
            true => format!("; ends of steps are moved onto constraints in at most {} iterations", projection::MOST_ITERATIONS),
            false => String::new(),
        };
        format!(
            "{}: {worst}. Inside an evaluation each contact's search takes 1 to 3 Newton iterations, at most {search}{constraints}",
            solver.name
        )
    });
    chosen.into_iter().chain(bounded).collect()
}

fn joined(vehicle: &VehicleSpec) -> bool {
    vehicle.free.as_ref().is_some_and(|free| !free.joints.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_each_rule_is_reached_and_names_a_method() {
        let cases = [
            (Facts { constrained: false, bodies: 1, tolerance: None }, 0),
            (Facts { constrained: true, bodies: 7, tolerance: Some(1e-7) }, 1),
            (Facts { constrained: false, bodies: 1, tolerance: Some(1e-7) }, 2),
            (Facts { constrained: false, bodies: 7, tolerance: Some(1e-11) }, 3),
            (Facts { constrained: false, bodies: 7, tolerance: Some(1e-7) }, 4),
        ];
        for (facts, rule) in cases {
            assert_eq!(choose(&facts), (RULES[rule].integrator, RULES[rule].why), "{facts:?}");
        }
        assert!(RULES.iter().all(|rule| crate::solve::REGISTRY.iter().any(|entry| entry.name == rule.integrator)));
    }

    #[test]
    fn prop_auto_reads_as_the_chosen_method_and_the_plan_says_why() {
        let open = |changes: &[&str]| {
            let changes: Vec<String> = changes.iter().map(|change| change.to_string()).collect();
            crate::scene::load::open("suspended_wheelset", &changes).unwrap()
        };
        let plain = open(&[]);
        assert!(plain.solver.why.is_none() && notes(&plain).is_empty());
        let scene = open(&["solver.integrator=auto"]);
        assert_eq!(scene.solver.name, "dormand_prince");
        assert!(notes(&scene)[0].starts_with("solver.integrator = \"auto\" is dormand_prince: "), "{:?}", notes(&scene));
        let bounded = open(&["solver.integrator=real_time", "solver.step=1 ms"]);
        assert!(notes(&bounded)[0].contains("2 evaluations, 1 Jacobian"), "{:?}", notes(&bounded));
    }
}
