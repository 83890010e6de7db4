//! An axle whose wheels turn against each other: the flexible axle of a wheelset, or wheels that turn on their own on an axle bridge.
//!
//! With tau the angle by which the left wheel is ahead of the right one, tau' its rate, k and c the stiffness and damping of the axle in torsion, and J_l, J_r the moments of
//! inertia of the wheels about the axle with what turns with them ([`Twist`] has the equations; torques M_l, M_r on them come from contacts, brakes and motors):
//!
//! ```text
//! J_l J_r / (J_l + J_r) tau'' = (J_r M_l - J_l M_r) / (J_l + J_r) - k tau - c tau',   energy  k tau^2 / 2 + J_l J_r / (J_l + J_r) tau'^2 / 2,   heat  c tau'^2
//! ```
//!
//! With wheels that are held, the axle swings with `sqrt(k (1 / J_l + 1 / J_r))`. `independent_wheels` has k = 0 (c: what the bearings of one wheel on the other's shaft,
//! or a coupling that slips, brake). J_l is `left_share` of the wheelset's `inertia_yy`, J_r the rest. States: tau, and tau' times [`Twist::TIME`].
//!
//! Left out: the axle's own modes between its wheels (one torsional spring, its inertia shared by the wheels), its bending, and the turn of an axle bridge, which has its
//! springs' places like the axle boxes of any wheelset and bears no moment about the axle.

use super::{ForceElement, Parse, Places, Quantity, QuantityKind};
use crate::mbs::body::Wrench;
use crate::mbs::inertia::Inertia;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::mbs::twist::{Axles, Twist};
use crate::settings::{Constant, Entry, Numbered, Section, SettingsError, constant};
use crate::units::Dimension;

/// What lets the wheels of one wheelset turn against each other.
#[derive(Clone, Debug)]
pub struct TwistingAxle {
    pub name: String,
    pub twist: Twist,
    /// Has it a stiffness? Otherwise its wheels are independent.
    pub elastic: bool,
}

impl TwistingAxle {
    /// k tau + c tau', N m: forward on the right wheel, backward on the left one.
    #[inline]
    fn torque(&self, state: &[f64]) -> f64 {
        self.twist.stiffness * state[0] + self.twist.damping * rate(state)
    }

    /// Spin of the left and the right wheel against the frame that does not spin, rad/s.
    fn spins(&self, bodies: &Moving, state: &[f64]) -> [f64; 2] {
        self.twist.factors().map(|factor| bodies[self.twist.body].pitch_rate + factor * rate(state))
    }
}

/// tau', rad/s.
#[inline]
fn rate(state: &[f64]) -> f64 {
    state[1] / Twist::TIME
}

const QUANTITIES: [Quantity; 4] = [
    Quantity { number: 0, name: "leftSpeed", kind: QuantityKind::AngularSpeed, description: "spin of the left wheel, forward positive" },
    Quantity { number: 1, name: "rightSpeed", kind: QuantityKind::AngularSpeed, description: "spin of the right wheel, forward positive" },
    Quantity {
        number: 2,
        name: "twist",
        kind: QuantityKind::Angle,
        description: "angle by which the left wheel is ahead of the right one",
    },
    Quantity {
        number: 3,
        name: "torque",
        kind: QuantityKind::Moment,
        description: "torque that the axle hands on, positive where it drives the right wheel forward",
    },
];

impl Numbered for TwistingAxle {
    const CONSTANTS: &'static [Constant<Self>] = &[
        constant!(tunable 0, "stiffness", NewtonMetrePerRadian, Some(0.0), "stiffness of the axle in torsion", get: |axle| axle.elastic.then_some(axle.twist.stiffness), set: |axle, value| axle.twist.stiffness = value),
        constant!(tunable 1, "damping", NewtonMetreSecondPerRadian, Some(0.0), "damping between both wheels", twist.damping),
    ];
}

impl ForceElement for TwistingAxle {
    fn name(&self) -> &str {
        &self.name
    }

    fn states(&self) -> usize {
        2
    }

    fn time_constant(&self) -> Option<f64> {
        let Twist { stiffness, damping, .. } = self.twist;
        let fastest = (stiffness / self.twist.inertia()).sqrt().max(damping / self.twist.inertia());
        (fastest > 0.0).then(|| 1.0 / fastest)
    }

    fn twist(&self) -> Option<Twist> {
        Some(self.twist)
    }

    fn own_inertia(&self) -> Option<(usize, &'static str, f64)> {
        Some((1, "twist", self.twist.inertia() / (Twist::TIME * Twist::TIME)))
    }

    fn torsion(&self) -> Option<usize> {
        self.elastic.then_some(0)
    }

    fn fit(&mut self, axles: &Axles) {
        if let Inertia::Revolution { axial, .. } | Inertia::NotGyroscopic { axial, .. } = axles.bodies[self.twist.body].inertia {
            self.twist.axial_inertia = axial;
        }
    }

    /// Both wheels turn alike, without torque.
    fn settle(&self, _: &Moving, state: &mut [f64]) {
        state.fill(0.0);
    }

    /// What both wheels get from elsewhere is added by the system ([`crate::mbs::system::System::fold_wheels`]).
    #[inline]
    fn apply(&self, _: &Moving, state: &[f64], rates: &mut [f64], _: &mut [Wrench]) {
        rates[0] = rate(state);
        rates[1] = -Twist::TIME * self.torque(state) / self.twist.inertia();
    }

    fn bodies(&self) -> Ends {
        [Some(self.twist.body), None]
    }

    /// The tangent knows twists itself.
    fn tangent(&self, _: &Moving, _: &[f64], _: usize, _: &mut PairTangent) {}

    fn quantities(&self) -> &'static [Quantity] {
        &QUANTITIES
    }

    fn quantity(&self, index: usize, bodies: &Moving, state: &[f64]) -> f64 {
        match index {
            0 | 1 => self.spins(bodies, state)[index],
            2 => state[0],
            3 => self.torque(state),
            _ => 0.0,
        }
    }

    fn potential_energy(&self, _: &Moving, state: &[f64]) -> f64 {
        0.5 * (self.twist.stiffness * state[0].powi(2) + self.twist.inertia() * rate(state).powi(2))
    }

    fn dissipated_power(&self, _: &Moving, state: &[f64]) -> f64 {
        self.twist.damping * rate(state).powi(2)
    }
}

/// A wheel has at least this share of the inertia of both.
const LEAST_SHARE: f64 = 0.01;

fn read(section: &Section, places: &dyn Places, elastic: bool) -> Result<Box<dyn ForceElement>, SettingsError> {
    let left_share =
        if section.has("left_share") { section.within("left_share", Dimension::None, (LEAST_SHARE, 1.0 - LEAST_SHARE))? } else { 0.5 };
    let stiffness = if elastic { section.positive("stiffness", Dimension::RotationalStiffness)? } else { 0.0 };
    let damping = section.not_negative_or("damping", Dimension::RotationalDamping, 0.0)?;
    // The inertia is known with the vehicle.
    let twist = Twist { body: places.body(section, "body")?, left_share, axial_inertia: 1.0, stiffness, damping };
    Ok(Box::new(TwistingAxle { name: places.name(section)?, twist, elastic }))
}

pub(super) const FLEXIBLE: Entry<Parse> = Entry {
    name: "flexible_axle",
    summary: "axle of the wheelset \"body\" that twists between its wheels: stiffness and damping in torsion",
    reference: "",
    parse: |section, places| read(section, places, true),
};

pub(super) const INDEPENDENT: Entry<Parse> = Entry {
    name: "independent_wheels",
    summary: "wheels of the wheelset \"body\" that turn on their own on their axle bridge",
    reference: "",
    parse: |section, places| read(section, places, false),
};
