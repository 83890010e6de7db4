//! A model at a state that may be changed, and its wheels.

use super::events::{ContactChange, ContactEvent};
use super::memory::ModelMemory;
use super::{ContactFailure, ContactReport, EvaluationError, Model, Wheelset, Workspace, contact_index};
use crate::contact::search::algebraic::Pair;
use crate::geometry::Side;
use crate::mbs::body::BodyMotion;
use crate::mbs::system::SystemWorkspace;

/// What starts, projections and changes of a contact's mode work on.
#[derive(Debug)]
pub struct Step<'a> {
    pub model: &'a Model,
    pub workspace: &'a mut Workspace,
    /// s.
    pub t: f64,
    pub y: &'a mut [f64],
    pub memory: &'a mut ModelMemory,
}

/// One wheel of a model.
#[derive(Clone, Copy, Debug)]
pub struct WheelRef<'a> {
    /// Index of its first contact.
    pub contact: usize,
    pub wheelset: &'a Wheelset,
    pub side: Side,
}

impl<'a> WheelRef<'a> {
    /// Wheel and rail where they stand.
    #[inline]
    pub fn pair<'b>(&self, model: &'b Model, motion: &'b BodyMotion) -> Pair<'b>
    where
        'a: 'b,
    {
        Pair {
            wheel: self.wheelset.wheel(self.side),
            rail: model.track.rail(self.side),
            centre: &motion.position,
            axes: &motion.frame.axes,
            distance: motion.distance,
        }
    }

    /// What failed here at `t`.
    pub(super) fn error(&self, t: f64, cause: ContactFailure) -> EvaluationError {
        EvaluationError::new(t, self.wheelset, self.side, cause)
    }

    /// Its wheelset's number.
    pub(super) fn index(&self) -> usize {
        self.contact / 2
    }

    /// The other wheel of the wheelset.
    pub(super) fn other(&self) -> WheelRef<'a> {
        let side = self.side.other();
        WheelRef { contact: contact_index(self.index(), side), side, ..*self }
    }
}

impl Model {
    /// All wheels in the order of their contacts.
    pub fn wheels(&self) -> impl Iterator<Item = WheelRef<'_>> {
        let both = |(index, wheelset)| Side::BOTH.map(|side| WheelRef { contact: contact_index(index, side), wheelset, side });
        self.wheelsets.iter().enumerate().flat_map(both)
    }

    /// The wheel of a contact index.
    pub fn wheel(&self, contact: usize) -> WheelRef<'_> {
        let wheelset = &self.wheelsets[contact / 2];
        WheelRef { contact, wheelset, side: Side::BOTH[contact % 2] }
    }

    /// This model at a state.
    pub fn at<'a>(&'a self, workspace: &'a mut Workspace, t: f64, y: &'a mut [f64], memory: &'a mut ModelMemory) -> Step<'a> {
        Step { model: self, workspace, t, y, memory }
    }
}

impl Model {
    /// The reports of one wheel's contacts: the first and the others.
    #[inline]
    pub(super) fn reports<'a>(
        &self,
        contact: usize,
        first: &'a mut [ContactReport],
        further: &'a mut [ContactReport],
    ) -> (&'a mut ContactReport, &'a mut [ContactReport]) {
        let count = self.points - 1;
        (&mut first[contact], &mut further[contact * count..(contact + 1) * count])
    }

    /// The wheel that belongs to a row of the constraints; the first one for rows of joints.
    pub(super) fn wheel_of_row(&self, system: &SystemWorkspace, row: usize) -> WheelRef<'_> {
        let contact = row.checked_sub(system.constraints.joint_rows).filter(|contact| *contact < self.contacts());
        self.wheel(contact.unwrap_or(0))
    }

    /// The constraints do not determine the force of this row.
    pub(super) fn singular_row(&self, system: &SystemWorkspace, t: f64, row: usize) -> EvaluationError {
        let wheel = self.wheel_of_row(system, row);
        let y = self.beside(&system.motions[wheel.wheelset.body]).0;
        wheel.error(t, ContactFailure::Singular { row, y })
    }
}

impl Step<'_> {
    /// Finds the bodies' motions.
    pub(super) fn move_bodies(&mut self) {
        self.model.move_bodies(self.y, self.memory, &mut self.workspace.system);
    }

    pub(super) fn note(&mut self, wheel: WheelRef, change: ContactChange) {
        self.workspace.events.push(ContactEvent { time: self.t, wheelset: wheel.wheelset.name.clone(), side: wheel.side, change });
    }
}
