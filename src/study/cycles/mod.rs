//! Periodic motions of any system with a parameter, and how they change with it. Knows nothing of railways.
//!
//! A motion that passes a surface (the section) again and again makes a map of the section into itself, `z -> P(z, p)`; a periodic motion is a fixed point,
//! `P(z, p) = z` (R. Seydel, Practical Bifurcation and Stability Analysis, chapter 7; Y. Kuznetsov, Elements of Applied Bifurcation Theory, chapter 10).
//! The eigenvalues of `dP/dz` at a fixed point are its Floquet multipliers without the trivial one: the motion is stable where all are inside the unit circle.
//! Unstable motions are fixed points like stable ones: Newton's method ([`corrector`]) finds both. A family of them is a curve in (z, p), which is followed by
//! its arc length, so that it may turn round ([`branch`]); where it turns, two motions meet and vanish ([`fold`]).
//!
//! The map comes from integration alone ([`Flow`]); its derivatives are differences of whole turns in the few directions that do not die within one
//! ([`slopes`]).

pub mod branch;
pub mod corrector;
pub mod fold;
pub mod slopes;

use faer::c64;

/// Multipliers come of differences: what is outside the unit circle by less than this is not told from what is inside.
pub const MARGIN: f64 = 0.01;
/// A real multiplier as near to 1 as this may come out on the other side of it.
const NEAR: f64 = 0.05;

/// A system with a section.
pub trait Flow: Sync {
    /// One turn: from a place on the section to where the motion passes it next in the same direction. Places are in units in which what matters is of order 1.
    ///
    /// # Errors
    /// [`Lost`].
    fn turn(&self, parameter: f64, from: &[f64]) -> Result<Turn, Lost>;

    /// A change of the parameter that counts as much as a change of a place by 1.
    fn unit(&self) -> f64;

    /// What the place at a turn's end may be off by, in units of places.
    fn error(&self) -> f64;
}

/// What a turn comes to.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    pub to: Vec<f64>,
    /// s.
    pub period: f64,
    /// Half the way between the extremes of each observed coordinate.
    pub swings: Vec<f64>,
}

/// Why there is no turn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Lost {
    #[error("the motion does not come back: it dies or no longer swings")]
    NoReturn,
    #[error("{0}")]
    Failed(String),
}

/// Why a periodic motion was not found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Missed {
    #[error("{0}")]
    Lost(#[from] Lost),
    #[error("Newton's method does not converge: a turn still misses its begin by {residual:.1e} of its size")]
    NotConverged { residual: f64 },
    #[error("the equations of a step are singular")]
    Singular,
    #[error("the motion shrinks to the steady one")]
    Vanished,
}

/// A periodic motion.
#[derive(Clone, Debug)]
pub struct Cycle {
    /// On the section, with the parameter in units of [`Flow::unit`] behind.
    pub place: Vec<f64>,
    pub parameter: f64,
    pub period: f64,
    pub swings: Vec<f64>,
    /// The largest first.
    pub multipliers: Vec<c64>,
    /// Unit vector along the branch.
    pub tangent: Vec<f64>,
    pub slopes: slopes::Slopes,
}

impl Cycle {
    /// Multipliers outside the unit circle by more than differences may be off. On which side of 1 the nearest real one is tells the branch itself: where
    /// it turns round one passes 1, and it begins with small motions of which one multiplier is above 1 if the parameter falls.
    pub fn unstable(&self) -> usize {
        let far = |value: &c64| (value.re - 1.0).abs();
        let real = self.multipliers.iter().enumerate().filter(|(_, value)| value.im == 0.0 && far(value) < NEAR);
        let nearest = real.min_by(|(_, a), (_, b)| far(a).total_cmp(&far(b))).map(|(k, _)| k);
        let falls = self.tangent.last().is_some_and(|part| *part < 0.0);
        let outside = |(k, value): (usize, &c64)| if Some(k) == nearest { falls } else { value.norm() > 1.0 + MARGIN };
        self.multipliers.iter().enumerate().filter(|entry| outside(*entry)).count()
    }

    pub fn is_stable(&self) -> bool {
        self.unstable() == 0
    }
}

/// The largest of some swings.
pub fn largest(swings: &[f64]) -> f64 {
    swings.iter().copied().fold(0.0, f64::max)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// a + factor b.
fn along(a: &[f64], factor: f64, b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + factor * b).collect()
}
