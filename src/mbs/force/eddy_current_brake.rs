//! Eddy-current track brake: magnets over the rail that brake without touching it.
//!
//! At the place `on`, with its speed v along the track, the largest force F0 (input, N, with the square of the magnets' current) and the speed v_k at which it is reached:
//!
//! ```text
//! F = -2 F0 (v / v_k) / (1 + (v / v_k)^2)
//! ```
//!
//! Eddy currents in a moving conductor: in proportion to v when slow, to 1/v beyond v_k, where the field no longer enters the rail. Nothing is held at rest. The magnets'
//! attraction, which is carried by the rail and the brake's own frame, and the heating of the rail are left out.

use super::along_track::{AlongTrack, read_place};
use super::{ElementInput, ForceElement, POSITIVE, Parse, Places, Quantity, QuantityKind};
use crate::mbs::body::Wrench;
use crate::mbs::moving::Moving;
use crate::mbs::pair_tangent::{Ends, PairTangent};
use crate::settings::{Constant, Entry, Numbered, Section, SettingsError, constant};
use crate::units::{Dimension, Unit};

/// An eddy-current brake on one body.
#[derive(Clone, Debug)]
pub struct EddyCurrentBrake {
    pub name: String,
    pub place: AlongTrack,
    /// v_k, m/s.
    pub critical_speed: f64,
    /// F0 until a master sets it, N.
    pub largest_force: f64,
}

impl EddyCurrentBrake {
    /// v, F and dF/dv.
    #[inline]
    fn now(&self, bodies: &Moving) -> [f64; 3] {
        let speed = self.place.speed(bodies);
        let (ratio, most) = (speed / self.critical_speed, 2.0 * bodies.input(0).max(0.0));
        let below = 1.0 + ratio * ratio;
        [speed, -most * ratio / below, -most * (1.0 - ratio * ratio) / (below * below * self.critical_speed)]
    }
}

const INPUTS: [ElementInput; 1] = [ElementInput {
    number: 0,
    name: "largestForce",
    unit: Unit::Newton,
    least: Some(0.0),
    description: "braking force that the magnets reach at their critical speed, as excited now",
}];

const QUANTITIES: [Quantity; 2] = [
    Quantity {
        number: 0,
        name: "force",
        kind: QuantityKind::Force,
        description: "force of the brake on the body, forward positive: negative while it runs forward",
    },
    Quantity { number: 1, name: "heatFlow", kind: QuantityKind::Power, description: "power that becomes heat in the rail" },
];

impl Numbered for EddyCurrentBrake {
    const CONSTANTS: &'static [Constant<Self>] =
        &[constant!(tunable 0, "criticalSpeed", MetrePerSecond, POSITIVE, "speed at which the braking force is largest", critical_speed)];
}

impl ForceElement for EddyCurrentBrake {
    fn name(&self) -> &str {
        &self.name
    }

    fn inputs(&self) -> &'static [ElementInput] {
        &INPUTS
    }

    fn start_input(&self, _: usize) -> f64 {
        self.largest_force
    }

    #[inline]
    fn apply(&self, bodies: &Moving, _: &[f64], _: &mut [f64], wrenches: &mut [Wrench]) {
        self.place.load(bodies, self.now(bodies)[1], wrenches);
    }

    fn bodies(&self) -> Ends {
        self.place.ends()
    }

    fn tangent(&self, bodies: &Moving, _: &[f64], _: usize, sum: &mut PairTangent) {
        let [_, force, slope] = self.now(bodies);
        self.place.tangent(bodies, force, slope, sum);
    }

    fn quantities(&self) -> &'static [Quantity] {
        &QUANTITIES
    }

    fn quantity(&self, index: usize, bodies: &Moving, state: &[f64]) -> f64 {
        match index {
            0 => self.now(bodies)[1],
            1 => self.dissipated_power(bodies, state),
            _ => 0.0,
        }
    }

    fn potential_energy(&self, _: &Moving, _: &[f64]) -> f64 {
        0.0
    }

    fn dissipated_power(&self, bodies: &Moving, _: &[f64]) -> f64 {
        let [speed, force, _] = self.now(bodies);
        -force * speed
    }
}

fn parse(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    Ok(Box::new(EddyCurrentBrake {
        name: places.name(section)?,
        place: read_place(section, places)?,
        critical_speed: section.positive("critical_speed", Dimension::Speed)?,
        largest_force: section.not_negative_or("largest_force", Dimension::Force, 0.0)?,
    }))
}

pub(super) const ENTRY: Entry<Parse> = Entry {
    name: "eddy_current_brake",
    summary: "eddy-current track brake on a place of a body, largest at its critical speed",
    reference: "J. H. Wouterse, IEE Proceedings B 138 (1991) 153-158",
    parse,
};
