//! Dry friction with a spring before slip: side bearers, wedges, centre plates, leaf springs.
//!
//! Friction acts along one axis of `from`, or in the plane across a `normal` axis of it. The state z [m] (one number
//! or two, in the axes of `from`) is the deflection of a spring k that carries the friction force; with the relative
//! speed v of the places in these axes, e = z/|z|, and the limit `mu N`:
//!
//! ```text
//! F = k z,   z_c = mu N / k
//! z' = v - min(1, |z|/z_c)^p max(0, v . e) e - max(0, |z| - z_c)/tau e
//! ```
//!
//! The spring follows the motion until it nears the limit, then the part of v along z slips: for steady motion from
//! z = 0 with p = 2, `F = mu N tanh(k x / (mu N))`. A turn back is elastic, so a body at rest stays at rest under any
//! force below the limit: there is no creep as with a viscous regularisation. |z| never passes a constant z_c; the last
//! term lets go within tau where N falls. The power `F . (v - z')` of both slip terms is heat, never negative.
//!
//! What the regularisation costs: displacement of z_c before slip (1 mm for 10 kN and 10 MN/m); slip a little before
//! the limit (loss below it falls as (F/(mu N))^p); oscillations of the mass m on the stuck spring, sqrt(k/m), which an
//! explicit integrator must follow; F may pass mu N for a time tau after N has fallen.
//!
//! N is constant, or that of a normal spring: `N = max(0, N0 - k_n n . d)` with the displacement d of `to`, pressing
//! `to` away along the axis n. Without a normal spring the element bears no normal force: another element does.

use super::attachment::{Attachment, axis};
use super::line::ends;
use super::rubbing::{Rub, dragged};
use super::{ForceElement, POSITIVE, Parse, Places, Quantity, QuantityKind};
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::settings::{Constant, Entry, Numbered, Section, SettingsError, constant};
use crate::units::Dimension;
use nalgebra::{Matrix2, Vector2, Vector3, Vector6};

/// A surface pair with dry friction; all axes in the attachment axes of `from`.
#[derive(Clone, Debug)]
pub struct DryFriction {
    pub name: String,
    pub from: Attachment,
    pub to: Attachment,
    /// From place to place in the design configuration, m.
    pub design_vector: Vector3<f64>,
    /// One or two unit vectors across each other, along which the places slip.
    pub slip_axes: Vec<Vector3<f64>>,
    /// n, from `from` to `to`; zero without a normal spring.
    pub normal: Vector3<f64>,
    /// mu.
    pub friction: f64,
    /// N0, N, and k_n, N/m.
    pub normal_force: f64,
    pub normal_stiffness: f64,
    /// k, N/m.
    pub stiffness: f64,
    /// p.
    pub exponent: i32,
    /// tau, s.
    pub relaxation: f64,
}

/// The pair at one instant.
pub(super) struct Surfaces {
    pub point: Vector3<f64>,
    /// v, m/s, and N, N.
    pub speed: Vector2<f64>,
    pub normal_force: f64,
}

impl DryFriction {
    #[inline]
    pub(super) fn pair(&self, bodies: &Moving) -> Surfaces {
        let point = self.to.point(bodies);
        let axes = self.from.axes(bodies);
        let rate = axes.tr_mul(&(self.to.velocity(bodies, &point) - self.from.velocity(bodies, &point)));
        let mut speed = Vector2::zeros();
        for (speed, axis) in speed.iter_mut().zip(&self.slip_axes) {
            *speed = axis.dot(&rate);
        }
        let mut normal_force = self.normal_force;
        if self.normal_stiffness > 0.0 {
            let displacement = self.displacement(bodies, &point);
            normal_force = (normal_force - self.normal_stiffness * self.normal.dot(&displacement)).max(0.0);
        }
        Surfaces { point, speed, normal_force }
    }

    #[inline]
    fn deflection(&self, state: &[f64]) -> Vector2<f64> {
        Vector2::new(state[0], state.get(1).copied().unwrap_or(0.0))
    }

    /// d, m: from place to place, less what it is in the design configuration; in the axes of `from`.
    #[inline]
    pub(super) fn displacement(&self, bodies: &Moving, point: &Vector3<f64>) -> Vector3<f64> {
        self.from.axes(bodies).tr_mul(&(point - self.from.point(bodies))) - self.design_vector
    }

    /// Where the places are under a load [N], of a pair between two bodies.
    pub(super) fn rub_under(&self, bodies: &Moving, load: f64) -> Option<Rub> {
        let displacement = self.displacement(bodies, &self.to.point(bodies));
        let mut place = Vector2::zeros();
        place.iter_mut().zip(&self.slip_axes).for_each(|(place, axis)| *place = axis.dot(&displacement));
        (self.from.body.is_some() && self.to.body.is_some()).then_some(Rub { place, load })
    }

    /// v - z', m/s, along e.
    #[inline]
    pub(super) fn slip(&self, pair: &Surfaces, z: &Vector2<f64>) -> Vector2<f64> {
        let length = z.norm();
        if length == 0.0 {
            return Vector2::zeros();
        }
        let most = self.friction * pair.normal_force / self.stiffness;
        let along = z / length;
        let nearness = if length < most { (length / most).powi(self.exponent) } else { 1.0 };
        along * (nearness * pair.speed.dot(&along).max(0.0) + (length - most).max(0.0) / self.relaxation)
    }
}

/// Derivatives of [`DryFriction::slip`] by z, v and N.
pub(super) struct SlipSlopes {
    pub by_deflection: Matrix2<f64>,
    pub by_speed: Matrix2<f64>,
    pub by_normal_force: Vector2<f64>,
}

impl DryFriction {
    pub(super) fn slip_slopes(&self, pair: &Surfaces, z: &Vector2<f64>) -> SlipSlopes {
        let length = z.norm();
        let mut slopes = SlipSlopes { by_deflection: Matrix2::zeros(), by_speed: Matrix2::zeros(), by_normal_force: Vector2::zeros() };
        if length == 0.0 {
            return slopes;
        }
        let per_force = self.friction / self.stiffness;
        let most = per_force * pair.normal_force;
        let e = z / length;
        let along = e * e.transpose();
        let across = (Matrix2::identity() - along) / length;
        let (nearness, by_length, by_most) = if length < most {
            let nearness = (length / most).powi(self.exponent);
            let slope = f64::from(self.exponent) * nearness;
            (nearness, slope / length, -slope / most)
        } else {
            (1.0, 0.0, 0.0)
        };
        let speed = pair.speed.dot(&e).max(0.0);
        let return_slope = if length > most { 1.0 / self.relaxation } else { 0.0 };
        let slip = nearness * speed + (length - most).max(0.0) / self.relaxation;
        slopes.by_deflection = across * slip + along * (by_length * speed + return_slope);
        if speed > 0.0 {
            slopes.by_deflection += e * (across * pair.speed).transpose() * nearness;
            slopes.by_speed = along * nearness;
        }
        slopes.by_normal_force = e * ((by_most * speed - return_slope) * per_force);
        slopes
    }
}

const QUANTITIES: [Quantity; 3] = [
    Quantity {
        number: 0,
        name: "frictionForce1",
        kind: QuantityKind::Force,
        description: "friction force along the first slip axis, tension positive",
    },
    Quantity {
        number: 1,
        name: "frictionForce2",
        kind: QuantityKind::Force,
        description: "friction force along the second slip axis, tension positive",
    },
    Quantity {
        number: 2,
        name: "normalForce",
        kind: QuantityKind::Force,
        description: "normal force of the friction surfaces, pressing positive",
    },
];

/// A `limit` is kept as a normal force with mu = 1.
fn limited(element: &DryFriction) -> bool {
    element.friction == 1.0 && element.normal_stiffness == 0.0
}

impl Numbered for DryFriction {
    const CONSTANTS: &'static [Constant<Self>] = &[
        constant!(tunable 0, "friction", One, POSITIVE, "friction coefficient of the surfaces", get: |element| (!limited(element)).then_some(element.friction), set: |element, value| element.friction = value),
        constant!(tunable 1, "limit", Newton, POSITIVE, "largest friction force", get: |element| limited(element).then_some(element.normal_force), set: |element, value| element.normal_force = value),
        constant!(tunable 2, "designNormalForce", Newton, Some(0.0), "normal force in the design configuration", get: |element| (!limited(element)).then_some(element.normal_force), set: |element, value| element.normal_force = value),
        constant!(tunable 3, "normalStiffness", NewtonPerMetre, POSITIVE, "stiffness of the normal spring", get: |element| (element.normal_stiffness > 0.0).then_some(element.normal_stiffness), set: |element, value| element.normal_stiffness = value),
        constant!(tunable 4, "stiffness", NewtonPerMetre, POSITIVE, "stiffness before slip", stiffness),
        constant!(tunable 5, "relaxation", Second, POSITIVE, "time within which friction lets go where the normal force falls", relaxation),
    ];
}

impl ForceElement for DryFriction {
    fn name(&self) -> &str {
        &self.name
    }

    fn states(&self) -> usize {
        self.slip_axes.len()
    }

    /// Without friction force: what a state at rest carries depends on how it came to rest.
    fn settle(&self, _: &Moving, state: &mut [f64]) {
        state.fill(0.0);
    }

    fn rub(&self, bodies: &Moving) -> Option<Rub> {
        self.rub_under(bodies, self.pair(bodies).normal_force)
    }

    fn drag(&self, from: &Rub, bodies: &Moving, state: &mut [f64]) {
        let Some(to) = self.rub(bodies) else { return };
        let z = dragged(from, &to, self.exponent, |load, _| self.friction * load / self.stiffness);
        state.iter_mut().zip(&z).for_each(|(state, z)| *state = *z);
    }

    #[inline]
    fn apply(&self, bodies: &Moving, state: &[f64], rates: &mut [f64], wrenches: &mut [Wrench]) {
        let pair = self.pair(bodies);
        let z = self.deflection(state);
        let rate = pair.speed - self.slip(&pair, &z);
        rates.copy_from_slice(&rate.as_slice()[..rates.len()]);
        let mut force = Vector3::zeros();
        for (axis, z) in self.slip_axes.iter().zip(&z) {
            force += axis * (self.stiffness * z);
        }
        if self.normal_stiffness > 0.0 {
            force -= self.normal * pair.normal_force;
        }
        let force = self.from.axes(bodies) * force;
        self.from.load(bodies, wrenches, &force, &pair.point, &Vector3::zeros());
        self.to.load(bodies, wrenches, &-force, &pair.point, &Vector3::zeros());
    }

    fn bodies(&self) -> Ends {
        [self.from.body, self.to.body]
    }

    fn holds(&self) -> [Option<Attachment>; 2] {
        [Some(self.from), Some(self.to)]
    }

    fn tangent(&self, bodies: &Moving, state: &[f64], first_state: usize, sum: &mut PairTangent) {
        let (now, z) = (self.pair(bodies), self.deflection(state));
        let slopes = self.slip_slopes(&now, &z);
        let axes = self.from.axes(bodies);
        let mut force = Vector3::zeros();
        let mut lines = [Vector6::zeros(); 2];
        for (axis, (line, z)) in self.slip_axes.iter().zip(lines.iter_mut().zip(z.iter())) {
            let axis = axes * axis;
            force += axis * (self.stiffness * z);
            *line = sum.line(&now.point, &axis);
        }
        let mut pressed = Vector6::zeros();
        if self.normal_stiffness > 0.0 && now.normal_force > 0.0 {
            let normal = axes * self.normal;
            force -= normal * now.normal_force;
            pressed = sum.line(&now.point, &normal);
            sum.add_spring(&pressed, &pressed, self.normal_stiffness);
        }
        sum.add_force(&now.point, &force);
        let follows = Matrix2::identity() - slopes.by_speed;
        let Some(own) = sum.add_states(first_state, self.slip_axes.len()) else { return };
        own.rate_by_state = -slopes.by_deflection;
        for i in 0..self.slip_axes.len() {
            // N falls by the normal spring's stiffness.
            own.rate_by_position[i][0] = pressed * (self.normal_stiffness * slopes.by_normal_force[i]);
            own.rate_by_velocity[i][0] = lines[0] * follows[(i, 0)] + lines[1] * follows[(i, 1)];
            own.load_by_state[i][0] = lines[i] * self.stiffness;
        }
    }

    fn quantities(&self) -> &'static [Quantity] {
        &QUANTITIES
    }

    fn quantity(&self, index: usize, bodies: &Moving, state: &[f64]) -> f64 {
        match index {
            0 | 1 => self.stiffness * self.deflection(state)[index],
            2 => self.pair(bodies).normal_force,
            _ => 0.0,
        }
    }

    fn potential_energy(&self, bodies: &Moving, state: &[f64]) -> f64 {
        let normal = if self.normal_stiffness > 0.0 { self.pair(bodies).normal_force.powi(2) / self.normal_stiffness } else { 0.0 };
        0.5 * (self.stiffness * self.deflection(state).norm_squared() + normal)
    }

    fn dissipated_power(&self, bodies: &Moving, state: &[f64]) -> f64 {
        let z = self.deflection(state);
        self.stiffness * z.dot(&self.slip(&self.pair(bodies), &z))
    }
}

/// The default tau, s.
pub(super) const RELAXATION: f64 = 2e-3;

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    let (from, to) = ends(section, places)?;
    let optional_axis = |key| if section.has(key) { axis(section, places, key).map(Some) } else { Ok(None) };
    let normal = optional_axis("normal")?;
    let slip_axes = match (optional_axis("axis")?, normal) {
        (Some(axis), Some(normal)) if axis.dot(&normal) != 0.0 => {
            return Err(section.error("normal", "is the axis of slip; it must stand across it"));
        }
        (Some(axis), _) => vec![axis],
        (None, Some(normal)) => {
            let all = [Vector3::x(), Vector3::y() * places.mirror(), Vector3::z()];
            all.into_iter().filter(|axis| axis.dot(&normal) == 0.0).collect()
        }
        (None, None) => return Err(section.error("axis", "give the axis of slip, or the \"normal\" axis across which all slip is free")),
    };
    let (friction, normal_force) = if section.has("limit") {
        if section.has("friction") || section.has("normal_force") {
            return Err(section.error("limit", "is \"friction\" times \"normal_force\"; give either it or them"));
        }
        (1.0, section.positive("limit", Dimension::Force)?)
    } else {
        (section.positive("friction", Dimension::None)?, section.not_negative("normal_force", Dimension::Force)?)
    };
    let normal_stiffness = section.optional("normal_stiffness", Dimension::Stiffness)?;
    if normal_stiffness.is_some() && (normal.is_none() || section.has("limit")) {
        return Err(section.error("normal_stiffness", "needs the \"normal\" axis, \"friction\" and \"normal_force\""));
    }
    let exponent = exponent(section)?;
    Ok(Box::new(DryFriction {
        name: places.name(section)?,
        from,
        to,
        design_vector: places.design_vector(&from, &to),
        slip_axes,
        normal: normal.unwrap_or_else(Vector3::zeros),
        friction,
        normal_force,
        normal_stiffness: if normal_stiffness.is_some() { section.positive("normal_stiffness", Dimension::Stiffness)? } else { 0.0 },
        stiffness: section.positive("stiffness", Dimension::Stiffness)?,
        exponent,
        relaxation: section.positive_or("relaxation", Dimension::Time, RELAXATION)?,
    }))
}

/// Reads p.
pub(super) fn exponent(section: &Section) -> Result<i32, SettingsError> {
    let exponent = section.number_or("exponent", Dimension::None, 2.0)?;
    if !(1.0..=64.0).contains(&exponent) || exponent.fract() != 0.0 {
        return Err(section.error("exponent", format!("found {exponent:?}, expected a whole number from 1 to 64")));
    }
    Ok(exponent as i32)
}

pub(super) const ENTRY: Entry<Parse> = Entry {
    name: "dry_friction",
    summary: "dry friction along an axis of \"from\" or across a normal, with a spring before slip",
    reference: "P. R. Dahl, The Aerospace Corporation, TOR-0158(3107-18)-1 (1968), with elastic return",
    parse,
};
