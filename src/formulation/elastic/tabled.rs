//! A wheel whose patch is read from a table (`contact.patch = "table"`, [`crate::contact::strips`]).
//!
//! The table knows treads. Where a flange comes near its rail, or the pose is not in the table, the strips are asked; on the way both are, and mixed by a weight
//! that goes smoothly from one to the other: the table's own, times that of the flange's clearance. (The table's own ends 0.4 mm across before a flange carries that is not
//! yawed. By 20 mrad of yaw, where it ends too, flanks of up to 76 degrees come nearer by less: the clearance is for steeper ones.)

use super::super::ContactFailure;
use super::super::loading::{Contact, WheelAt};
use super::super::patch_loads::{Carried, creep_of, location};
use crate::contact::normal::damping::damped_force;
use crate::contact::search::algebraic::Pair;
use crate::contact::strips::{Cells, FLANK, Looked, Section};
use crate::math::smooth_step::cubic_step;
use nalgebra::Vector3;

/// Clearances of a flange [m] below which the strips are asked alone, and above which the table alone.
const CLEARANCES: (f64, f64) = (3e-6, 2.5e-5);

/// What the table says of a wheel.
pub(in crate::formulation) struct TabledWheel<'a> {
    pub wheel: &'a WheelAt<'a>,
    pub looked: Looked,
}

impl<'a> TabledWheel<'a> {
    /// `None` where it says nothing; from slopes of the rail and penetrations [m] at the places where the surfaces are nearest.
    pub fn find(wheel: &'a WheelAt<'a>, pair: &Pair, flanks: impl Iterator<Item = (f64, f64)>) -> Option<TabledWheel<'a>> {
        let table = wheel.model.tables.get(wheel.contact)?;
        let clear = clearance(flanks);
        if !(clear > 0.0) {
            return None;
        }
        let mut looked = table.look(pair, &Section::new(pair), wheel.model.laws.material)?;
        looked.weight *= clear;
        Some(TabledWheel { wheel, looked })
    }

    /// Its patch under load.
    ///
    /// # Errors
    /// [`ContactFailure`] where the wheel is not on its rail.
    pub fn load(&self, carried: &mut Carried) -> Result<(), ContactFailure> {
        let (wheel, part) = (self.wheel, &self.looked.part);
        let found = location(part, wheel.motion);
        let contact = Contact { wheel, found: &found, slot: 0, share: 1.0 };
        contact.check_depth()?;
        let Carried { count, all: [report, ..], creeps, forces, couples } = carried;
        *report = contact.report();
        report.stiffness = part.force / (part.overlap * part.overlap.sqrt());
        (report.elastic_slope, report.patch) = (1.5 * part.force / part.overlap, part.patch);
        report.normal_force = damped_force(wheel.model.laws.damping.as_ref(), part.load, part.overlap, report.penetration_rate);
        let uneven = wheel.uneven(Cells::Fifths(&self.looked.fifths), part, &report.axes);
        contact.creep_as(report, |law, rolling| uneven.force(law, rolling));
        *count = 1;
        creeps[0] = creep_of(report, wheel.friction_at(report));
        (forces[0], couples[0]) = (part.force * (report.normal_force / part.load), Vector3::zeros());
        Ok(())
    }
}

/// 1 where all flanks are clear of the rail, 0 where one is about to touch.
fn clearance(flanks: impl Iterator<Item = (f64, f64)>) -> f64 {
    let clear = |(_, penetration): (f64, f64)| cubic_step((-penetration - CLEARANCES.0) / (CLEARANCES.1 - CLEARANCES.0));
    flanks.filter(|(slope, _)| slope.abs() > FLANK).map(clear).product()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_flanks_take_the_weight_away_before_they_touch() {
        let of = |places: &[(f64, f64)]| clearance(places.iter().copied());
        // Treads don't count, however deep; neither do flanks that are far away.
        assert_eq!(of(&[(0.05, 6e-5), (-0.2, 1e-5), (-2.0, -1e-3)]), 1.0);
        assert_eq!([of(&[(-1.5, -CLEARANCES.0)]), of(&[(1.5, 1e-5)]), of(&[(0.05, 6e-5), (-0.5, 0.0)])], [0.0; 3]);
        let way: Vec<f64> = (0..=100).map(|k| of(&[(-2.0, -3e-7 * f64::from(k))])).collect();
        assert!(way.windows(2).all(|pair| (0.0..0.03).contains(&(pair[1] - pair[0]))) && way[0] == 0.0 && way[100] == 1.0);
    }
}
