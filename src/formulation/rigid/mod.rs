//! Contacts as constraints: ECCF and ACCF.
//!
//! From below: [`row`] (a located contact and its constraint row), [`balance`] (normal
//! forces with the creep forces that depend on them), [`lasting`] (how long a rigid contact's place lasts), [`evaluation`] (the equations of
//! motion), [`projection`] (positions and velocities on the constraints), [`load_transfer`] and [`modes`] (a contact whose N would fall below zero,
//! or whose place ceases, ends the run or is handed to elastic forces, and becomes a constraint again where it no longer bounces), and on top
//! the two formulations, which differ in how they find a row and in what they integrate.

pub(super) mod accf;
mod balance;
pub(super) mod eccf;
mod evaluation;
mod lasting;
mod load_transfer;
pub(super) mod modes;
mod projection;
mod row;
