//! What `solver.integrator = "auto"` stands for, and what a plan says about a scene's integrator.

use super::spec::Scene;
use crate::contact::search::algebraic;
use crate::formulation::Model;
use crate::formulation::mode_swings::Vibration;
use crate::mbs::projection;
use crate::settings::{Section, SettingsError};
use crate::solve::{AUTO, DEFAULT_TOLERANCE, SettingKind};
use crate::units::Dimension;

/// What the choice depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facts {
    /// Is tangential contact transient (low speed, standstill)?
    pub transient: bool,
    /// Bound of the local error, m; `None` where the scene gives a step alone.
    pub tolerance: Option<f64>,
    /// Are contacts elastic without damping?
    pub rings: bool,
}

/// One line of the rule: the first that fits holds.
struct Rule {
    integrator: &'static str,
    fits: fn(&Facts) -> bool,
    why: &'static str,
}

/// Tolerance [m] below which accuracy limits the step of a method of order 3 more than stability does that of an explicit one of
/// order 5.
const TIGHT: f64 = 1e-7;

/// The one place where the choice is made. `wheelrail study` shows it for any scene (docs/accuracy.md: in the suspended wheelset explicit methods win
/// below 1 um, for vehicles `rosenbrock` down to 0.1 um); `rk43` and `rk4`, which win by up to 30 % below 1 um there, are not chosen because they fall behind at
/// tolerances below 1e-9. Older figures of the first comparison: time for a simulated second with `dormand_prince` against that with `rosenbrock` at the
/// same tolerance, in ms on a busy virtual machine (numbers to be compared with each other only; errors of y in brackets):
/// suspended wheelset, 1e-6, ECF-A 17 (8e-10 m) to 3 (4e-6), ECCF 18 (2e-8) to 7 (1e-5); at 1e-8 ECF-A 19 (3e-12) to 20 (4e-8);
/// bogie, ECF-A, 1e-5 433 to 26 (both 3e-7), 1e-7 530 (9e-9) to 90 (5e-9); coach over bumps, ECF-A, 1e-6 2400 (1.4e-7) to 1600 (9e-8), before
/// the bumps with ECCF 7100 to 130; wheelset at standstill, 1e-6 350 to 5. So a vehicle's suspension limits explicit steps also where contact
/// is a constraint, and the formulation does not decide.
const RULES: &[Rule] = &[
    Rule {
        integrator: "real_time",
        fits: |facts| facts.tolerance.is_none(),
        why: "the scene gives a step and no tolerance; implicit, so that the step need not follow fast vibrations",
    },
    Rule {
        integrator: "rosenbrock",
        fits: |facts| facts.transient,
        why: "the contact's tangential deflection decays within milliseconds, which would limit an explicit method's step",
    },
    Rule {
        integrator: "dormand_prince",
        fits: |facts| facts.rings,
        why: "nothing damps the contacts, so that wheels ring on them (100 to 300 Hz) for ever: implicit steps would take that away, two thirds in some seconds",
    },
    Rule {
        integrator: "dormand_prince",
        fits: |facts| facts.tolerance.is_some_and(|tolerance| tolerance < TIGHT),
        why: "tolerance below 1e-7: accuracy limits the step, and high order pays",
    },
    Rule {
        integrator: "rosenbrock",
        fits: |_| true,
        why: "tolerance of 1e-7 or more: vibrations of contacts and suspensions would limit an explicit method's step",
    },
];

/// Steps for a vibration that are worth a word, s.
const SHORT: f64 = 0.7e-3;

/// The method for a scene, and why.
pub fn choose(facts: &Facts) -> (&'static str, &'static str) {
    let rule = RULES.iter().find(|rule| (rule.fits)(facts)).unwrap_or(&RULES[RULES.len() - 1]);
    (rule.integrator, rule.why)
}

/// The facts of a scene that is being read.
pub(super) fn facts(solver: &Section, (transient, rings): (bool, bool)) -> Result<Facts, SettingsError> {
    let given = solver.optional("tolerance", Dimension::Length)?;
    // A scene that gives neither a tolerance nor a step leaves both to the program.
    let tolerance = if solver.has("tolerance") || solver.has("step") { given } else { Some(DEFAULT_TOLERANCE) };
    Ok(Facts { transient, tolerance, rings })
}

/// Lines for the plan: the choice where the scene leaves it open, and the worst case where the method has one.
pub(super) fn notes(scene: &Scene, model: &Model) -> Vec<String> {
    let solver = &scene.solver;
    let assumed = (solver.assumed && solver.integrator.setting().kind == SettingKind::Tolerance)
        .then(|| format!("solver.tolerance is {DEFAULT_TOLERANCE:e} m, the default: displacements come out to some micrometres, where dry friction, slack or flange impacts do not make more of them (a run with 1e-6 tells)"));
    let chosen = solver.why.map(|why| format!("solver.integrator = \"{}\" is {}: {why}", AUTO.name, solver.name));
    let bounded = solver.integrator.worst_case().map(|worst| {
        let search = algebraic::LIMITS.iterations;
        let constraints = match model.formulation.constrains() || !model.system.joints.is_empty() {
            true => format!("; ends of steps are moved onto constraints in at most {} iterations", projection::MOST_ITERATIONS),
            false => String::new(),
        };
        format!(
            "{}: {worst}. Inside an evaluation each contact's search takes 1 to 3 Newton iterations, at most {search}{constraints}",
            solver.name
        )
    });
    let short = |vibration: &Vibration| solver.name == "rosenbrock" && vibration.step < SHORT;
    let vibrates = model.quickest_vibration().filter(short).map(|Vibration { body, frequency, step }| {
        format!(
            "{body} can swing at {frequency:.0} Hz, and little damps it: while it does steps are at most {:.2} ms; where that lasts (wheels out of round, rough track) \
             solver.integrator = \"dormand_prince\" may be faster",
            1e3 * step
        )
    });
    assumed.into_iter().chain(chosen).chain(bounded).chain(vibrates).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::assemble;

    #[test]
    fn prop_each_rule_is_reached_and_names_a_method() {
        let cases = [
            (Facts { transient: true, tolerance: None, rings: true }, 0),
            (Facts { transient: true, tolerance: Some(1e-9), rings: true }, 1),
            (Facts { transient: false, tolerance: Some(1e-5), rings: true }, 2),
            (Facts { transient: false, tolerance: Some(1e-8), rings: false }, 3),
            (Facts { transient: false, tolerance: Some(1e-7), rings: false }, 4),
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
        let notes = |scene: &Scene| notes(scene, &assemble::model(scene).unwrap());
        let plain = open(&[]);
        assert!(plain.solver.why.is_none() && notes(&plain).is_empty());
        let scene = open(&["solver.integrator=auto", "solver.tolerance=1e-9"]);
        assert_eq!(scene.solver.name, "dormand_prince");
        assert!(notes(&scene)[0].starts_with("solver.integrator = \"auto\" is dormand_prince: "), "{:?}", notes(&scene));
        assert_eq!(open(&["solver.integrator=auto", "solver.tolerance=1e-5"]).solver.name, "rosenbrock");
        // What is shown has no part in how it is found.
        let moving =
            ["solver.integrator=auto", "solver.tolerance=1e-5", "interface.inputs=[\"rail_motion\"]", "interface.outputs=[\"energy\"]"];
        assert_eq!([open(&moving).solver.name, open(&moving[..3]).solver.name], ["rosenbrock"; 2]);
        let bounded = open(&["solver.integrator=real_time", "solver.step=1 ms"]);
        assert!(notes(&bounded)[0].contains("2 evaluations, 1 Jacobian"), "{:?}", notes(&bounded));
    }
}
