//! What a run is given: inputs, and what its audit allows.

/// An input of the leading wheelset that takes a value at a time.
#[derive(Clone, Copy, Debug)]
pub struct InputChange {
    /// s.
    pub time: f64,
    /// See `formulation`: DRIVE_TORQUE ...
    pub input: usize,
    pub value: f64,
}

/// What the audit allows.
#[derive(Clone, Copy, Debug)]
pub struct Audited {
    /// Energy that no one accounts for, over what was exchanged.
    pub energy: f64,
    /// Share of the weight whose creep is exchanged over the way travelled: the energy of travel and spin is told to that only.
    pub way: f64,
    /// Mean vertical force that no one accounts for, over the weight.
    pub weight: f64,
    /// May a wheel leave its rail for good? Else a derailment breaks the case.
    pub derailment: bool,
}
