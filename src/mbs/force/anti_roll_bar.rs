//! Anti-roll bar: a moment about the x axis of `from` against the roll of `to` in it, and nothing else.
//!
//! The roll is the x component of the rotation vector t of `to` in `from` ([`super::orientation`]). With
//! `V = k t_x^2 / 2` the couple on `from` is `m = G^T (k t_x, 0, 0) + (c w_x, 0, 0)`, on `to` -m, so that the element is
//! conservative at all angles; with yaw or pitch of the order e between the bodies its y and z parts are e/2 of it.
//! The places of `from` and `to` on their bodies do not matter.

use super::attachment::Attachment;
use super::line::ends;
use super::orientation::{Couple, rotation_vector, transposed_rate_map};
use super::{ForceElement, POSITIVE, Parse, Places, Quantity, QuantityKind};
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::settings::{Constant, Entry, Numbered, Section, SettingsError, constant};
use crate::units::Dimension;
use nalgebra::Vector3;

/// A torsion bar between two bodies.
#[derive(Clone, Debug)]
pub struct AntiRollBar {
    pub name: String,
    pub from: Attachment,
    pub to: Attachment,
    /// k, N m/rad.
    pub stiffness: f64,
    /// c, N m s/rad.
    pub damping: f64,
}

const QUANTITIES: [Quantity; 2] = [
    Quantity {
        number: 0,
        name: "moment",
        kind: QuantityKind::Moment,
        description: "moment of the anti-roll bar on its first body, about that body's x axis",
    },
    Quantity { number: 1, name: "angle", kind: QuantityKind::Angle, description: "roll of the second body in the first" },
];

impl Numbered for AntiRollBar {
    const CONSTANTS: &'static [Constant<Self>] = &[
        constant!(tunable 0, "stiffness", NewtonMetrePerRadian, POSITIVE, "stiffness of the anti-roll bar", stiffness),
        constant!(tunable 1, "damping", NewtonMetreSecondPerRadian, Some(0.0), "damping of the anti-roll bar", damping),
    ];
}

impl AntiRollBar {
    /// t [rad] and w_x [rad/s].
    #[inline]
    fn turn(&self, bodies: &Moving) -> (Vector3<f64>, f64) {
        let axes = self.from.axes(bodies);
        let relative = self.to.rotation(bodies) - self.from.rotation(bodies);
        (rotation_vector(&axes.tr_mul(&self.to.axes(bodies))), axes.column(0).dot(&relative))
    }

    /// m, in the axes of `from`, N m.
    #[inline]
    fn couple(&self, bodies: &Moving) -> Vector3<f64> {
        let (turn, rate) = self.turn(bodies);
        let mut couple = transposed_rate_map(&turn, &Vector3::new(self.stiffness * turn.x, 0.0, 0.0));
        couple.x += self.damping * rate;
        couple
    }
}

impl ForceElement for AntiRollBar {
    fn name(&self) -> &str {
        &self.name
    }

    #[inline]
    fn apply(&self, bodies: &Moving, _: &[f64], _: &mut [f64], wrenches: &mut [Wrench]) {
        let couple = self.from.axes(bodies) * self.couple(bodies);
        for (end, couple) in [(&self.from, couple), (&self.to, -couple)] {
            end.load(bodies, wrenches, &Vector3::zeros(), &Vector3::zeros(), &couple);
        }
    }

    fn bodies(&self) -> Ends {
        [self.from.body, self.to.body]
    }

    fn tangent(&self, bodies: &Moving, _: &[f64], _: usize, sum: &mut PairTangent) {
        let along_x = |value: f64| Vector3::new(value, 0.0, 0.0);
        let couple = Couple {
            axes: self.from.axes(bodies),
            turn: self.turn(bodies).0,
            stiffness: along_x(self.stiffness),
            damping: along_x(self.damping),
            couple: self.couple(bodies),
        };
        couple.tangent(sum);
    }

    fn quantities(&self) -> &'static [Quantity] {
        &QUANTITIES
    }

    fn quantity(&self, index: usize, bodies: &Moving, _: &[f64]) -> f64 {
        match index {
            0 => self.couple(bodies).x,
            1 => self.turn(bodies).0.x,
            _ => 0.0,
        }
    }

    fn potential_energy(&self, bodies: &Moving, _: &[f64]) -> f64 {
        0.5 * self.stiffness * self.turn(bodies).0.x.powi(2)
    }

    fn dissipated_power(&self, bodies: &Moving, _: &[f64]) -> f64 {
        self.damping * self.turn(bodies).1.powi(2)
    }
}

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    let (from, to) = ends(section, places)?;
    let damping = section.not_negative_or("damping", Dimension::RotationalDamping, 0.0)?;
    let stiffness = section.positive("stiffness", Dimension::RotationalStiffness)?;
    Ok(Box::new(AntiRollBar { name: places.name(section)?, from, to, stiffness, damping }))
}

pub(super) const ENTRY: Entry<Parse> =
    Entry { name: "anti_roll_bar", summary: "moment about the x axis of \"from\" against the roll of \"to\" in it", reference: "", parse };
