//! What a hard case is.

use super::finding::Finding;
pub use super::given::{Audited, InputChange};
use super::run::Ran;
use super::trace::Quantity;

/// An integrator with the number that governs it, as a scene says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Method {
    pub integrator: &'static str,
    /// "tolerance=1e-5" or "step=2 ms".
    pub setting: &'static str,
}

impl Method {
    pub const fn new(integrator: &'static str, setting: &'static str) -> Method {
        Method { integrator, setting }
    }

    /// "rosenbrock 1e-5", "real_time 2 ms".
    pub fn words(&self) -> String {
        format!("{} {}", self.integrator, self.value())
    }

    fn value(&self) -> &'static str {
        self.setting.split_once('=').map_or(self.setting, |(_, value)| value)
    }

    /// As `--set` says it.
    pub fn changes(&self) -> [String; 2] {
        let (key, value) = self.setting.split_once('=').unwrap_or(("tolerance", self.setting));
        [format!("solver.integrator={}", self.integrator), format!("solver.{key}={value}")]
    }

    /// Does it have fixed steps?
    pub fn is_fixed(&self) -> bool {
        self.setting.starts_with("step")
    }
}

/// The largest distance from the reference: SI, forces as a share of the static wheel load.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    pub quantity: Quantity,
    pub most: f64,
    /// It may come so much sooner or later, s: a flange that closes with 0.03 m/s strikes 0.3 ms sooner for an error of 1e-5 m.
    pub shift: f64,
}

/// What must hold of a run.
#[derive(Clone, Copy)]
pub enum Must {
    /// Comes near a tight run: the first method; the second checks it.
    Reference { methods: [Method; 2], bounds: &'static [Bound] },
    /// A formula, a conservation law or a published number.
    Formula(fn(&Ran) -> Vec<Finding>),
    /// Ends with the same bits when a master looks in so many times.
    Exchanges(u64),
    /// Is refused before it runs, within 2 s, in words that contain all of these.
    Refusal(&'static [&'static str]),
}

/// Files that a scene reads: name and content.
pub type Files = fn() -> Vec<(&'static str, String)>;

/// A hard case.
#[derive(Clone, Copy)]
pub struct Case {
    pub name: &'static str,
    /// What makes it hard.
    pub hard: &'static str,
    /// What must hold, in words with its number and where that comes from.
    pub claim: &'static str,
    /// An embedded scene and its changes, as `--set` takes them.
    pub scene: &'static str,
    pub changes: &'static [&'static str],
    /// A scene of its own instead, and files that it reads.
    pub text: Option<fn() -> String>,
    pub files: Option<Files>,
    /// s; the dense grid's distance need not divide it.
    pub stop: f64,
    pub grid: f64,
    pub inputs: &'static [InputChange],
    pub formulations: &'static [&'static str],
    pub methods: &'static [Method],
    pub must: &'static [Must],
    pub audit: Audited,
    /// May the start be refused? Else a refusal breaks the case, but for fixed steps that are too long.
    pub refusable: bool,
    /// Does it run in the tests too?
    pub quick: bool,
}

impl Case {
    /// Those of its methods that have `text` in their words.
    pub fn methods_with(&self, text: &str) -> Vec<Method> {
        self.methods.iter().copied().filter(|method| method.words().contains(text)).collect()
    }
}

/// What holds for a run that nothing is wrong with.
pub const AUDIT: Audited = Audited { energy: 0.01, way: 0.025, weight: 0.002, derailment: false };

pub const ALL: &[&str] = &["ECF-A", "ECF-N", "ECCF", "ACCF"];
pub const ELASTIC: &[&str] = &["ECF-A", "ECF-N"];
pub const SMOOTH: &[&str] = &["ECF-A", "ECCF", "ACCF"];
pub const RIGID: &[&str] = &["ECCF", "ACCF"];

/// A case to start from: the others change what differs.
pub const CASE: Case = Case {
    name: "",
    hard: "",
    claim: "",
    scene: "bogie",
    changes: &[],
    text: None,
    files: None,
    stop: 1.0,
    grid: 2e-4,
    inputs: &[],
    formulations: SMOOTH,
    methods: &[],
    must: &[],
    audit: AUDIT,
    refusable: false,
    quick: true,
};
