//! The elastic contacts of one wheel in a pose and motion that are given: nothing is remembered, nothing moves on.

use super::elastic::half_spaces;
use super::elastic::patch::highest_pressures;
use super::elastic::points;
use super::loading::{Contact, WheelAt};
use super::memory::{Mode, WheelMemory};
use super::patch_loads::Loaded;
use super::rail_motion::Climb;
use super::{ContactFailure, ContactReport, Model};
use crate::contact::strips::Scratch;
use crate::geometry::Side;
use crate::mbs::body::{BodyMotion, Wrench};
use std::f64::consts::PI;

/// A place where a wheel is pressed, or nearly so.
#[derive(Clone, Copy, Debug)]
pub struct PlaceOnWheel {
    pub report: ContactReport,
    /// Half the relative curvatures A along e1 and B along e2 at the place, 1/m.
    pub half_curvatures: [f64; 2],
    /// Pa; 0 where nothing presses.
    pub highest_pressure: f64,
}

impl Model {
    /// All places of a wheel as the laws of elastic contact see them, with `friction` as the factor of the friction coefficient.
    ///
    /// The model must have an elastic formulation and steady creepages.
    ///
    /// # Errors
    /// [`ContactFailure`] where the laws do not hold in this pose.
    pub fn places_on_wheel(
        &self,
        wheelset: usize,
        side: Side,
        motion: &BodyMotion,
        friction: f64,
    ) -> Result<Vec<PlaceOnWheel>, ContactFailure> {
        let contact = super::contact_index(wheelset, side);
        let state = vec![0.0; self.dimension()];
        let wheelset = &self.wheelsets[wheelset];
        let wheel = WheelAt { model: self, wheelset, side, contact, motion, climb: Climb::default(), friction, y: &state };
        let mut strips = Scratch::new(self.strips.as_ref().map_or(0, |rails| rails[side.index()].len()));
        let (mut first, mut further) = (ContactReport::default(), vec![ContactReport::default(); self.points - 1]);
        let (mut memory, mut wrench) = (WheelMemory::new(Mode::ELASTIC), Wrench::default());
        points::elastic_wheel(&wheel, &mut memory, (&mut strips, &mut Loaded::default()), &mut wrench, (&mut first, &mut further))?;
        let highest = self.strips.as_ref().map(|rails| match self.half_spaces {
            Some(settings) => half_spaces::highest_pressures(&wheel, settings),
            None => highest_pressures(&wheel, &rails[side.index()], &mut strips),
        });
        // A report without a place belongs to none.
        let is_place = |report: &ContactReport| report.iterations > 0 || report.penetration != 0.0;
        let found: Vec<ContactReport> = std::iter::once(first).chain(further).filter(is_place).collect();
        // A place of a table may hold several parts of the strips' patch: the highest pressure is that of the part that has most.
        let nearest = |eta: f64| {
            let off = |report: &ContactReport| (report.parameters.rail - eta).abs();
            let pressed = found.iter().enumerate().filter(|(_, report)| report.normal_force > 0.0);
            pressed.min_by(|a, b| off(a.1).total_cmp(&off(b.1))).map(|(number, _)| number)
        };
        let place = |(number, report): (usize, &ContactReport)| {
            let again = Contact::again(report);
            let shape = again.shape(wheelset.wheel(side), self.track.rail(side));
            let hertzian = 1.5 * report.normal_force / (PI * report.patch.a * report.patch.b);
            let own = highest.iter().flatten().filter(|part| nearest(part.0) == Some(number)).map(|part| part.1);
            let highest_pressure = if report.normal_force > 0.0 { own.reduce(f64::max).unwrap_or(hertzian) } else { 0.0 };
            PlaceOnWheel { report: *report, half_curvatures: [shape.rolling, shape.across], highest_pressure }
        };
        Ok(found.iter().enumerate().map(place).collect())
    }
}
