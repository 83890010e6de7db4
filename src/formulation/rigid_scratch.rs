//! What constraint formulations work in.

use super::partition::Partition;
use crate::contact::normal::ElasticContact;
use crate::contact::search::algebraic::ContactLocation;
use crate::contact::search::point_contact::{PointContact, Residual};
use crate::mbs::body::Wrench;
use crate::mbs::kkt::Coefficients;

/// A contact's constraint at one instant.
#[derive(Clone, Copy, Debug)]
pub struct ConstraintRow {
    pub location: ContactLocation,
    /// H on the wheelset's coordinates.
    pub row: Coefficients,
    /// -Q_cn: second derivative of the gap when no coordinate accelerates, m/s2.
    pub bias: f64,
    /// Rates of u and eta, m/s.
    pub rates: [f64; 2],
}

/// Scratch of the constraint formulations; rows and multipliers are in the system's workspace.
#[derive(Clone, Debug, Default)]
pub struct RigidScratch {
    pub rows: Vec<Option<ConstraintRow>>,
    pub balance: Balance,
    /// A state that the constraints have been made to hold in (ACCF).
    pub consistent: Vec<f64>,
    /// Each constrained contact's five constraints there with their second derivatives (ACCF).
    pub points: Vec<Option<(PointContact, Residual)>>,
    /// The partition of each wheelset in the last evaluation (ACCF).
    pub partitions: Vec<Option<Partition>>,
}

impl RigidScratch {
    pub fn new(wheelsets: usize, loaded: usize, dimension: usize) -> Self {
        RigidScratch {
            rows: vec![None; 2 * wheelsets],
            balance: Balance::new(wheelsets, loaded),
            consistent: vec![0.0; dimension],
            points: Vec::with_capacity(2 * wheelsets),
            partitions: vec![None; wheelsets],
        }
    }
}

/// A constrained contact in the loop.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pressing {
    /// Penetration at which the law is read, m; 0 where nothing presses.
    pub approach: f64,
    /// N there, N; what the constraint asks for where it would pull.
    pub force: f64,
    /// Wrench of the creep forces on the wheelset, its derivative by N, and d ln delta / d ln N.
    pub creep: Wrench,
    pub slope: Wrench,
    pub exponent: f64,
    /// Penetration, N and wrench one iteration ago.
    pub last: Option<(f64, f64, Wrench)>,
    /// How often the law has jumped between two iterations, and what is kept of it after that.
    pub jumps: usize,
    pub kept: Option<ElasticContact>,
}

/// Scratch of the loop.
#[derive(Clone, Debug, Default)]
pub struct Balance {
    pub contacts: Vec<Pressing>,
    /// Per wheelset dG/dN, row by row.
    pub coupling: Vec<[f64; 4]>,
    /// Wrenches without the creep forces of constrained contacts.
    pub base: Vec<Wrench>,
    pub image: Vec<f64>,
    /// The image one iteration ago.
    pub last_image: Vec<f64>,
    pub answer: Vec<f64>,
    /// Does the loop go on until rounding ends it? For whoever differentiates what it finds.
    pub exact: bool,
}

impl Balance {
    /// `loaded`: bodies and wheels that have wrenches.
    fn new(wheelsets: usize, loaded: usize) -> Self {
        let count = 2 * wheelsets;
        Balance {
            contacts: vec![Pressing::default(); count],
            coupling: vec![[0.0; 4]; wheelsets],
            base: vec![Wrench::default(); loaded],
            image: vec![0.0; count],
            last_image: vec![0.0; count],
            answer: vec![0.0; count],
            exact: false,
        }
    }
}

impl Pressing {
    /// From the state's memory.
    pub fn start(force: f64, approach: f64) -> Self {
        Pressing { approach: if force > 0.0 { approach } else { 0.0 }, force, ..Pressing::default() }
    }
}
