//! What is asked of a study.

use super::clock::Interrupted;

/// What is asked for. Empty lists stand for what the scene says.
#[derive(Clone)]
pub struct Request<'a> {
    /// Name or file, and `key=value`.
    pub scene: &'a str,
    pub overrides: &'a [String],
    pub formulations: Vec<&'static str>,
    pub integrators: Vec<&'static str>,
    /// m.
    pub tolerances: Vec<f64>,
    /// s.
    pub steps: Vec<f64>,
    /// Are tolerances and steps the user's? What no method takes of them is then noted.
    pub own_lists: [bool; 2],
    pub creep_laws: Vec<&'static str>,
    /// m.
    pub node_spacings: Vec<f64>,
    /// m.
    pub smoothings: Vec<f64>,
    /// s; none: no coupling.
    pub communication_steps: Vec<f64>,
    /// s; `None`: that of the scene, shortened where the budget asks for it.
    pub stop: Option<f64>,
    /// Distance of the output times, s.
    pub step: f64,
    /// The only wheelset that counts; `None`: the worst of all.
    pub wheelset: Option<&'a str>,
    pub repeats: usize,
    /// s.
    pub budget: f64,
    /// Tolerance of the reference, m; `None`: as tight as the budget allows.
    pub reference: Option<f64>,
    /// Is asked between the steps of all runs; then what is ready is the study.
    pub interrupted: Interrupted<'a>,
}
