//! Friction wedge of a three-piece truck: dry friction in two directions whose limit follows from the wedge's spring and from the friction itself.
//!
//! A wedge without mass stands on a spring of the side frame (`from`), goes up and down with the bolster (`to`), whose slope presses it against the frame's column, and rubs there
//! along `axis` (the spring's) and across it. With the spring's force S, the slope's angle b from the column's face, no friction on the slope, and F the
//! friction that holds the wedge up, its balance gives the force N on the column:
//!
//! ```text
//! P cos b = N,   P sin b = S + F     so  N = (S + F) / tan b,   |F| <= mu N
//! bolster going down: N = S / (tan b - mu);   going up: N = S / (tan b + mu)
//! ```
//!
//! S = max(0, S0 - k_s a . d) with the displacement d of `to` and the axis a, which points to where the spring presses `to`. Friction has a spring k before slip and the states of [`DryFriction`], z [m],
//! one along the axis and one across, with F = -k z_1 and the limit mu N for both together: a wedge that slips down carries little across. What the bolster gets along the axis is S + F.
//! One element stands for two wedges that face each other, with the sum of their springs: their forces N are opposite and none is left.
//!
//! Stored is `k z^2 / 2 + S^2 / (2 k_s)`; slip turns `k z . (v - z')` into heat. Needs tan b > mu: a steeper wedge locks.
//!
//! *Left out:* the wedge's mass, friction on its slope (about a tenth of the force where both faces have the same), its toe in and turning, wear.

use super::attachment::{Attachment, axis};
use super::dry_friction::{DryFriction, RELAXATION, Surfaces};
use super::line::ends;
use super::rubbing::{Rub, dragged};
use super::{ForceElement, POSITIVE, Parse, Places, Quantity, QuantityKind};
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::settings::{Constant, Entry, Numbered, Section, SettingsError, constant};
use crate::units::Dimension;
use nalgebra::{Matrix2, Vector2, Vector3, Vector6};

/// Wedges with their spring.
#[derive(Clone, Debug)]
pub struct FrictionWedge {
    /// The column's face; its slip axes are a and that across it, its normal force is found here.
    column: DryFriction,
    /// S0, N, and k_s, N/m.
    spring_force: f64,
    spring_stiffness: f64,
    /// tan b.
    slope: f64,
}

/// Wedges at one instant.
struct Pressed {
    surfaces: Surfaces,
    /// S, N.
    spring: f64,
}

impl FrictionWedge {
    #[inline]
    fn pressed(&self, bodies: &Moving, z: &Vector2<f64>) -> Pressed {
        let mut surfaces = self.column.pair(bodies);
        let spring = (self.spring_force - self.spring_stiffness * self.let_out(&surfaces, bodies)).max(0.0);
        surfaces.normal_force = ((spring - self.column.stiffness * z.x) / self.slope).max(0.0);
        Pressed { surfaces, spring }
    }

    /// a . d, m.
    #[inline]
    fn let_out(&self, surfaces: &Surfaces, bodies: &Moving) -> f64 {
        self.column.slip_axes[0].dot(&self.column.displacement(bodies, &surfaces.point))
    }

    /// Force on `from` in its axes, N.
    fn force(&self, spring: f64, z: &Vector2<f64>) -> Vector3<f64> {
        let [along, across] = [0, 1].map(|i| self.column.slip_axes[i]);
        along * (self.column.stiffness * z.x - spring) + across * (self.column.stiffness * z.y)
    }
}

const QUANTITIES: [Quantity; 5] = [
    Quantity { number: 0, name: "springForce", kind: QuantityKind::Force, description: "force of the wedges' spring, pressing positive" },
    Quantity {
        number: 1,
        name: "frictionForce",
        kind: QuantityKind::Force,
        description: "friction on the column along the spring's axis, positive where it carries the bolster",
    },
    Quantity {
        number: 2,
        name: "lateralFrictionForce",
        kind: QuantityKind::Force,
        description: "friction on the column across the spring's axis, tension positive",
    },
    Quantity { number: 3, name: "normalForce", kind: QuantityKind::Force, description: "normal force on the column, pressing positive" },
    Quantity {
        number: 4,
        name: "displacement",
        kind: QuantityKind::Displacement,
        description: "of the spring from the design configuration, positive where it is let out",
    },
];

impl Numbered for FrictionWedge {
    const CONSTANTS: &'static [Constant<Self>] = &[
        constant!(tunable 0, "designSpringForce", Newton, Some(0.0), "force of the wedges' spring in the design configuration", spring_force),
        constant!(tunable 1, "springStiffness", NewtonPerMetre, POSITIVE, "stiffness of the wedges' spring", spring_stiffness),
        constant!(tunable 2, "stiffness", NewtonPerMetre, POSITIVE, "stiffness of the friction pair before slip", get: |wedge| Some(wedge.column.stiffness), set: |wedge, value| wedge.column.stiffness = value),
        constant!(tunable 3, "relaxation", Second, POSITIVE, "time within which friction lets go where the normal force falls", get: |wedge| Some(wedge.column.relaxation), set: |wedge, value| wedge.column.relaxation = value),
    ];
}

impl ForceElement for FrictionWedge {
    fn name(&self) -> &str {
        &self.column.name
    }

    fn states(&self) -> usize {
        2
    }

    /// Without friction force.
    fn settle(&self, _: &Moving, state: &mut [f64]) {
        state.fill(0.0);
    }

    fn presses(&self) -> Option<Vector3<f64>> {
        Some(self.column.slip_axes[0])
    }

    /// The load is that of the spring.
    fn rub(&self, bodies: &Moving) -> Option<Rub> {
        self.column.rub_under(bodies, self.pressed(bodies, &Vector2::zeros()).spring)
    }

    fn drag(&self, from: &Rub, bodies: &Moving, state: &mut [f64]) {
        let Some(to) = self.rub(bodies) else { return };
        let per_force = self.column.friction / (self.column.stiffness * self.slope);
        let most = |spring: f64, z: &Vector2<f64>| (per_force * (spring - self.column.stiffness * z.x)).max(0.0);
        state.copy_from_slice(dragged(from, &to, self.column.exponent, most).as_slice());
    }

    #[inline]
    fn apply(&self, bodies: &Moving, state: &[f64], rates: &mut [f64], wrenches: &mut [Wrench]) {
        let z = Vector2::new(state[0], state[1]);
        let Pressed { surfaces, spring } = self.pressed(bodies, &z);
        rates.copy_from_slice((surfaces.speed - self.column.slip(&surfaces, &z)).as_slice());
        let column = &self.column;
        let force = column.from.axes(bodies) * self.force(spring, &z);
        column.from.load(bodies, wrenches, &force, &surfaces.point, &Vector3::zeros());
        column.to.load(bodies, wrenches, &-force, &surfaces.point, &Vector3::zeros());
    }

    fn bodies(&self) -> Ends {
        self.column.bodies()
    }

    fn holds(&self) -> [Option<Attachment>; 2] {
        self.column.holds()
    }

    fn tangent(&self, bodies: &Moving, state: &[f64], first_state: usize, sum: &mut PairTangent) {
        let z = Vector2::new(state[0], state[1]);
        let Pressed { surfaces, spring } = self.pressed(bodies, &z);
        let slopes = self.column.slip_slopes(&surfaces, &z);
        let axes = self.column.from.axes(bodies);
        let lines = [0, 1].map(|i| sum.line(&surfaces.point, &(axes * self.column.slip_axes[i])));
        sum.add_force(&surfaces.point, &(axes * self.force(spring, &z)));
        let mut softens = Vector6::zeros();
        if spring > 0.0 {
            sum.add_spring(&lines[0], &lines[0], self.spring_stiffness);
            // N falls as the spring is let out.
            softens = lines[0] * (self.spring_stiffness / self.slope);
        }
        let by_friction = self.column.stiffness / self.slope;
        let (falls, by_friction) = if surfaces.normal_force > 0.0 { (softens, by_friction) } else { (Vector6::zeros(), 0.0) };
        let follows = Matrix2::identity() - slopes.by_speed;
        let Some(own) = sum.add_states(first_state, 2) else { return };
        own.rate_by_state = slopes.by_normal_force * Vector2::new(by_friction, 0.0).transpose() - slopes.by_deflection;
        for i in 0..2 {
            own.rate_by_position[i][0] = falls * slopes.by_normal_force[i];
            own.rate_by_velocity[i][0] = lines[0] * follows[(i, 0)] + lines[1] * follows[(i, 1)];
            own.load_by_state[i][0] = lines[i] * self.column.stiffness;
        }
    }

    fn quantities(&self) -> &'static [Quantity] {
        &QUANTITIES
    }

    fn quantity(&self, index: usize, bodies: &Moving, state: &[f64]) -> f64 {
        let z = Vector2::new(state[0], state[1]);
        let Pressed { surfaces, spring } = self.pressed(bodies, &z);
        match index {
            0 => spring,
            1 => -self.column.stiffness * z.x,
            2 => self.column.stiffness * z.y,
            3 => surfaces.normal_force,
            4 => self.let_out(&surfaces, bodies),
            _ => 0.0,
        }
    }

    fn potential_energy(&self, bodies: &Moving, state: &[f64]) -> f64 {
        let z = Vector2::new(state[0], state[1]);
        let spring = self.pressed(bodies, &z).spring;
        0.5 * (self.column.stiffness * z.norm_squared() + spring * spring / self.spring_stiffness)
    }

    fn dissipated_power(&self, bodies: &Moving, state: &[f64]) -> f64 {
        let z = Vector2::new(state[0], state[1]);
        self.column.stiffness * z.dot(&self.column.slip(&self.pressed(bodies, &z).surfaces, &z))
    }
}

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    let (from, to) = ends(section, places)?;
    let (along, normal) = (axis(section, places, "axis")?, axis(section, places, "normal")?);
    if along.dot(&normal) != 0.0 {
        return Err(section.error("normal", "is the axis of the spring; it must stand across it, where the wedge presses on the column"));
    }
    let friction = section.positive("friction", Dimension::None)?;
    let angle = section.within("angle", Dimension::Angle, STEEPNESS)?;
    if angle.tan() <= friction {
        let problem = format!(
            "found {angle:?} rad, with which the wedge locks: its tangent {:.3} must be larger than the friction coefficient {friction:?}",
            angle.tan()
        );
        return Err(section.error("angle", problem));
    }
    let all = [Vector3::x(), Vector3::y() * places.mirror(), Vector3::z()];
    let across = all.into_iter().find(|axis| axis.dot(&along) == 0.0 && axis.dot(&normal) == 0.0).unwrap_or_default();
    let column = DryFriction {
        name: places.name(section)?,
        from,
        to,
        design_vector: places.design_vector(&from, &to),
        slip_axes: vec![along, across],
        normal: Vector3::zeros(),
        friction,
        normal_force: 0.0,
        normal_stiffness: 0.0,
        stiffness: section.positive("stiffness", Dimension::Stiffness)?,
        exponent: super::dry_friction::exponent(section)?,
        relaxation: section.positive_or("relaxation", Dimension::Time, RELAXATION)?,
    };
    Ok(Box::new(FrictionWedge {
        column,
        spring_force: section.not_negative("spring_force", Dimension::Force)?,
        spring_stiffness: section.positive("spring_stiffness", Dimension::Stiffness)?,
        slope: angle.tan(),
    }))
}

/// Angles of slopes, rad.
const STEEPNESS: (f64, f64) = (0.05, 1.5);

pub(super) const ENTRY: Entry<Parse> = Entry {
    name: "friction_wedge",
    summary: "wedges of a three-piece truck: a spring, and dry friction along it and across it whose limit follows the spring's force",
    reference: "Kaiser, Cusumano and Gardner, Vehicle System Dynamics 38 (2002) 59-82; a wedge without mass and without friction on its slope",
    parse,
};
