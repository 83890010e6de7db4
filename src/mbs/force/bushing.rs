//! Bushing: three translational and three rotational springs and dampers in the axes of the `from` body.
//!
//! With A the axes of `from`, a and p the places on `from` and `to`, o the angular velocity of `from`, and t the
//! rotation vector of the `to` body's axes in A ([`super::orientation`], with the map G):
//!
//! ```text
//! d = A^T (p - a) - d0,     d' = A^T (p' - a' - o x (p - a)),     w = A^T (o_to - o)
//! f = f0 + k d + c d'       force A f on `from` and -A f on `to`, both at p
//! m = G^T K t + C w         couple A m on `from` and -A m on `to`
//! ```
//!
//! The power of all four is `-f . d' - m . w`, and `dV/dt = (f0 + k d) . d' + K t . t'` is just its conservative part,
//! so nothing is lost or gained at large angles. f0 is the preload, the force in the design configuration; its sign
//! is that of a tension along the positive axis. On an axle K and C about it are none: its box, which no moment holds, turns with the other body. `preload = "static"`: the preload that balance asks for in the design configuration.

use super::attachment::Attachment;
use super::line::ends;
use super::orientation::{Couple, rotation_vector, transposed_rate_map};
use super::{ForceElement, Parse, Places, Quantity, QuantityKind};
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::settings::{Constant, Entry, Numbered, Section, SettingsError};
use crate::units::{Dimension, Unit};
use nalgebra::{Matrix3, Vector3};

/// Six springs and dampers between two places; all vectors in the attachment axes of `from`.
#[derive(Clone, Debug)]
pub struct Bushing {
    pub name: String,
    pub from: Attachment,
    pub to: Attachment,
    /// d0, m.
    pub design_vector: Vector3<f64>,
    /// f0, N.
    pub preload: Vector3<f64>,
    /// Is the preload to be found from balance?
    pub balanced: bool,
    /// k, N/m, and c, N s/m.
    pub stiffness: Vector3<f64>,
    pub damping: Vector3<f64>,
    /// K, N m/rad, and C, N m s/rad.
    pub rotational_stiffness: Vector3<f64>,
    pub rotational_damping: Vector3<f64>,
}

/// A bushing at one instant, in the axes of `from`.
struct Deflection {
    /// d, m; d', m/s; t, rad; w, rad/s.
    displacement: Vector3<f64>,
    rate: Vector3<f64>,
    turn: Vector3<f64>,
    turn_rate: Vector3<f64>,
}

impl Bushing {
    #[inline]
    fn deflection(&self, bodies: &Moving, point: &Vector3<f64>) -> Deflection {
        let axes = self.from.axes(bodies);
        let relative = self.to.velocity(bodies, point) - self.from.velocity(bodies, point);
        let mut deflection = Deflection {
            displacement: axes.tr_mul(&(point - self.from.point(bodies))) - self.design_vector,
            rate: axes.tr_mul(&relative),
            turn: Vector3::zeros(),
            turn_rate: Vector3::zeros(),
        };
        if self.turns() {
            deflection.turn = self.turn(bodies, &axes);
            deflection.turn_rate = axes.tr_mul(&(self.to.rotation(bodies) - self.from.rotation(bodies)));
        }
        deflection
    }

    /// t, rad, in the axes of `from`.
    #[inline]
    fn turn(&self, bodies: &Moving, axes: &Matrix3<f64>) -> Vector3<f64> {
        rotation_vector(&axes.tr_mul(&self.to.axes(bodies)))
    }

    /// Does it resist rotation?
    fn turns(&self) -> bool {
        self.rotational_stiffness != Vector3::zeros() || self.rotational_damping != Vector3::zeros()
    }

    fn force(&self, at: &Deflection) -> Vector3<f64> {
        self.preload + self.stiffness.component_mul(&at.displacement) + self.damping.component_mul(&at.rate)
    }

    fn couple(&self, at: &Deflection) -> Vector3<f64> {
        transposed_rate_map(&at.turn, &self.rotational_stiffness.component_mul(&at.turn))
            + self.rotational_damping.component_mul(&at.turn_rate)
    }
}

const fn quantity(number: u32, name: &'static str, kind: QuantityKind, description: &'static str) -> Quantity {
    Quantity { number, name, kind, description }
}

const FORCE: &str = "force of the bushing along an axis of its first body, positive where the second body has moved along the axis";
const MOMENT: &str = "moment of the bushing on its first body about one of that body's axes";
const DISPLACEMENT: &str = "displacement of the second body's place along an axis of the first body, from the design configuration";
const ANGLE: &str = "rotation of the second body about an axis of the first (component of the rotation vector)";
const QUANTITIES: [Quantity; 12] = [
    quantity(0, "forceX", QuantityKind::Force, FORCE),
    quantity(1, "forceY", QuantityKind::Force, FORCE),
    quantity(2, "forceZ", QuantityKind::Force, FORCE),
    quantity(3, "momentX", QuantityKind::Moment, MOMENT),
    quantity(4, "momentY", QuantityKind::Moment, MOMENT),
    quantity(5, "momentZ", QuantityKind::Moment, MOMENT),
    quantity(6, "displacementX", QuantityKind::Displacement, DISPLACEMENT),
    quantity(7, "displacementY", QuantityKind::Displacement, DISPLACEMENT),
    quantity(8, "displacementZ", QuantityKind::Displacement, DISPLACEMENT),
    quantity(9, "angleX", QuantityKind::Angle, ANGLE),
    quantity(10, "angleY", QuantityKind::Angle, ANGLE),
    quantity(11, "angleZ", QuantityKind::Angle, ANGLE),
];

/// One component of a vector of constants: those that are zero are not called for.
macro_rules! component {
    ($number:literal, $name:literal, $field:ident, $axis:literal, $unit:ident, $text:literal) => {
        Constant {
            number: $number,
            name: $name,
            unit: Unit::$unit,
            least: Some(0.0),
            tunable: true,
            description: $text,
            get: |bushing: &Bushing| (bushing.$field[$axis] != 0.0).then_some(bushing.$field[$axis]),
            set: |bushing, value| bushing.$field[$axis] = value,
        }
    };
}

/// A component of a preload that is given.
macro_rules! preload {
    ($number:literal, $name:literal, $axis:literal) => {
        Constant {
            least: None,
            get: |bushing: &Bushing| (!bushing.balanced && bushing.preload[$axis] != 0.0).then_some(bushing.preload[$axis]),
            ..component!($number, $name, preload, $axis, Newton, "force in the design configuration along an axis of the first body")
        }
    };
}

impl Numbered for Bushing {
    const CONSTANTS: &'static [Constant<Self>] = &[
        component!(0, "stiffnessX", stiffness, 0, NewtonPerMetre, "stiffness along the first body's x axis"),
        component!(1, "stiffnessY", stiffness, 1, NewtonPerMetre, "stiffness along the first body's y axis"),
        component!(2, "stiffnessZ", stiffness, 2, NewtonPerMetre, "stiffness along the first body's z axis"),
        component!(3, "dampingX", damping, 0, NewtonSecondPerMetre, "damping along the first body's x axis"),
        component!(4, "dampingY", damping, 1, NewtonSecondPerMetre, "damping along the first body's y axis"),
        component!(5, "dampingZ", damping, 2, NewtonSecondPerMetre, "damping along the first body's z axis"),
        component!(6, "rotationalStiffnessX", rotational_stiffness, 0, NewtonMetrePerRadian, "stiffness about the first body's x axis"),
        component!(7, "rotationalStiffnessY", rotational_stiffness, 1, NewtonMetrePerRadian, "stiffness about the first body's y axis"),
        component!(8, "rotationalStiffnessZ", rotational_stiffness, 2, NewtonMetrePerRadian, "stiffness about the first body's z axis"),
        component!(9, "rotationalDampingX", rotational_damping, 0, NewtonMetreSecondPerRadian, "damping about the first body's x axis"),
        component!(10, "rotationalDampingY", rotational_damping, 1, NewtonMetreSecondPerRadian, "damping about the first body's y axis"),
        component!(11, "rotationalDampingZ", rotational_damping, 2, NewtonMetreSecondPerRadian, "damping about the first body's z axis"),
        preload!(12, "preloadX", 0),
        preload!(13, "preloadY", 1),
        preload!(14, "preloadZ", 2),
    ];
}

impl ForceElement for Bushing {
    fn name(&self) -> &str {
        &self.name
    }

    #[inline]
    fn apply(&self, bodies: &Moving, _: &[f64], _: &mut [f64], wrenches: &mut [Wrench]) {
        let point = self.to.point(bodies);
        let at = self.deflection(bodies, &point);
        let axes = self.from.axes(bodies);
        let force = axes * self.force(&at);
        let couple = if self.turns() { axes * self.couple(&at) } else { Vector3::zeros() };
        self.from.load(bodies, wrenches, &force, &point, &couple);
        self.to.load(bodies, wrenches, &-force, &point, &-couple);
    }

    fn bodies(&self) -> Ends {
        [self.from.body, self.to.body]
    }

    fn holds(&self) -> [Option<Attachment>; 2] {
        [Some(self.from), Some(self.to)]
    }

    fn tangent(&self, bodies: &Moving, _: &[f64], _: usize, sum: &mut PairTangent) {
        let point = self.to.point(bodies);
        let at = self.deflection(bodies, &point);
        let axes = self.from.axes(bodies);
        let in_world = |diagonal: &Vector3<f64>| {
            let mut matrix = Matrix3::zeros();
            for (axis, factor) in axes.column_iter().zip(diagonal) {
                matrix += axis * (axis * *factor).transpose();
            }
            matrix
        };
        sum.add_point(&point, &in_world(&self.stiffness), &in_world(&self.damping));
        sum.add_force(&point, &(axes * self.force(&at)));
        if self.turns() {
            let (stiffness, damping) = (self.rotational_stiffness, self.rotational_damping);
            Couple { axes, turn: at.turn, stiffness, damping, couple: self.couple(&at) }.tangent(sum);
        }
    }

    fn free_about_axle(&mut self) {
        (self.rotational_stiffness.y, self.rotational_damping.y) = (0.0, 0.0);
    }

    fn static_stiffness(&self) -> Vec<f64> {
        if self.balanced { self.stiffness.iter().copied().collect() } else { Vec::new() }
    }

    fn set_preload(&mut self, index: usize, force: f64) {
        self.preload[index] = force;
    }

    fn quantities(&self) -> &'static [Quantity] {
        &QUANTITIES
    }

    fn quantity(&self, index: usize, bodies: &Moving, _: &[f64]) -> f64 {
        let at = self.deflection(bodies, &self.to.point(bodies));
        let vector = match index / 3 {
            0 => self.force(&at),
            1 => self.couple(&at),
            2 => at.displacement,
            // Also where nothing resists it, and no moment needs it.
            3 => self.turn(bodies, &self.from.axes(bodies)),
            _ => Vector3::zeros(),
        };
        vector[index % 3]
    }

    fn potential_energy(&self, bodies: &Moving, _: &[f64]) -> f64 {
        let at = self.deflection(bodies, &self.to.point(bodies));
        let spring = |k: &Vector3<f64>, x: &Vector3<f64>| 0.5 * k.component_mul(x).dot(x);
        self.preload.dot(&at.displacement) + spring(&self.stiffness, &at.displacement) + spring(&self.rotational_stiffness, &at.turn)
    }

    fn dissipated_power(&self, bodies: &Moving, _: &[f64]) -> f64 {
        let at = self.deflection(bodies, &self.to.point(bodies));
        self.damping.component_mul(&at.rate).dot(&at.rate) + self.rotational_damping.component_mul(&at.turn_rate).dot(&at.turn_rate)
    }
}

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    let (from, to) = ends(section, places)?;
    let constants = |key: &'static str, dimension| -> Result<Vector3<f64>, SettingsError> {
        let values = section.triple_or(key, dimension, [0.0; 3])?;
        if values.iter().any(|value| *value < 0.0) {
            return Err(section.error(key, "must not be negative"));
        }
        Ok(values.into())
    };
    let balanced = super::static_preload(section)?;
    let mut preload = if balanced { Vector3::zeros() } else { section.triple_or("preload", Dimension::Force, [0.0; 3])?.into() };
    preload.y *= places.mirror();
    let bushing = Bushing {
        name: places.name(section)?,
        from,
        to,
        design_vector: places.design_vector(&from, &to),
        preload,
        balanced,
        stiffness: constants("stiffness", Dimension::Stiffness)?,
        damping: constants("damping", Dimension::Damping)?,
        rotational_stiffness: constants("rotational_stiffness", Dimension::RotationalStiffness)?,
        rotational_damping: constants("rotational_damping", Dimension::RotationalDamping)?,
    };
    if bushing.stiffness == Vector3::zeros() && bushing.damping == Vector3::zeros() && !bushing.turns() {
        return Err(section.error("stiffness", "a bushing needs a stiffness or damping: three numbers, for x, y and z"));
    }
    if balanced && bushing.stiffness == Vector3::zeros() {
        return Err(section.error("preload", "\"static\" needs a stiffness that carries"));
    }
    Ok(Box::new(bushing))
}

pub(super) const ENTRY: Entry<Parse> = Entry {
    name: "bushing",
    summary: "springs and dampers for three displacements and three rotations, in the axes of \"from\"",
    reference: "",
    parse,
};
