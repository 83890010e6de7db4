//! Force elements: each states its law, its potential energy and the power it dissipates.
//!
//! An element between two places loads both with the same line of force and with opposite couples, so that momentum
//! and angular momentum of the bodies are kept exactly (one exception: moments about a spinning axle, see
//! [`Attachment`]). Elements that act along one line ([`LineElement`]) count tension and elongation positive.
//!
//! Design configuration: the bodies stand where the scene puts them, their axes parallel to the world's. There the
//! displacement of every element is zero and its force is its preload.

mod actuator;
mod air_spring;
mod along_track;
mod anti_roll_bar;
mod attachment;
mod axle_pair;
mod brake;
mod bump_stop;
mod bushing;
mod cardan_drive;
mod carried_pull;
mod coupler;
mod curve;
mod dry_friction;
mod eddy_current_brake;
mod external_load;
mod friction_wedge;
mod gravity;
mod guided_spring;
mod held;
mod line;
mod load;
mod magnetic_track_brake;
mod maxwell_damper;
mod motor_gear;
mod orientation;

mod rubbing;
mod running_resistance;
mod spring_damper;
mod sticking;
mod stop;
mod twisting_axle;

pub use air_spring::AirSpring;
pub use anti_roll_bar::AntiRollBar;
pub use attachment::{Attachment, Places};
pub use bushing::Bushing;
pub use carried_pull::CarriedPull;
pub use curve::{Beyond, Curve, Table};
pub use dry_friction::DryFriction;
pub use friction_wedge::FrictionWedge;
pub use gravity::Gravity;
pub use guided_spring::{ENTRY as GUIDED_SPRING, Guide, GuidedSpring};
pub use held::{Guide as HeldGuide, Held, Holder};
pub use line::{Direction, LineElement, LineLaw, Slopes, Span, Stretch};
pub use load::VerticalLoad;
pub use maxwell_damper::MaxwellDamper;
pub use rubbing::Rub;
pub use spring_damper::SpringDamper;
pub use stop::Stop;

use super::body::Wrench;
use super::moving::Moving;
use super::pair_tangent::{Ends, PairTangent};
use super::twist::{Axles, Twist};
use crate::settings::{Entry, Number, Numbered, Section, SettingsError, choose};
use crate::units::Unit;
use nalgebra::Vector3;

/// A force that depends on position and velocity of bodies, and on states of its own where it has any.
pub trait ForceElement: Part + Send + Sync + std::fmt::Debug {
    /// Name in reports.
    fn name(&self) -> &str;

    /// Number of first-order states; in m or rad, because the error control weighs them like positions.
    fn states(&self) -> usize {
        0
    }

    /// The shortest time constant of the element's own states, s: an explicit integrator's step is bound by it.
    fn time_constant(&self) -> Option<f64> {
        None
    }

    /// What a master may apply to it.
    fn inputs(&self) -> &'static [ElementInput] {
        &[]
    }

    /// The value of the input at `index` of [`ForceElement::inputs`] until a master sets another, SI.
    fn start_input(&self, _index: usize) -> f64 {
        0.0
    }

    /// Does it turn a spinning axle? Then its changes ([`ForceElement::tangent`]) count the bodies' own rotation, not that of the frames that bearings
    /// hold, and its states follow the axle's spin at the start.
    fn turns_axle(&self) -> bool {
        false
    }

    /// Of an element that turns an axle: the body that takes what the momentum of its own rotating parts demands, one of [`ForceElement::bodies`] or a third.
    fn rotor_carrier(&self) -> Option<usize> {
        None
    }

    /// Of an element that turns a wheel with a motion and wrench of its own ([`super::twist`]): which, among bodies and wheels.
    fn wheel(&self) -> Option<usize> {
        None
    }

    /// Of an element that lets both wheels of an axle turn against each other: how. Its states are two, the twist and its rate times [`Twist::TIME`].
    fn twist(&self) -> Option<Twist> {
        None
    }

    /// Of a block on a wheel's tread: the axle's body, and its distance from the axle, m.
    fn block(&self) -> Option<(usize, f64)> {
        None
    }

    /// Of an element with a shaft, or a brake, that twists elastically: which of its states is the twist.
    fn torsion(&self) -> Option<usize> {
        None
    }

    /// Does that shaft swing only while its wheel is locked, as one that hangs on a brake does?
    fn swings_when_locked(&self) -> bool {
        false
    }

    /// Of an element with a mass of its own: which of its states is its velocity, what is called so, and the inertia with which half of its square is kinetic energy, J.
    fn own_inertia(&self) -> Option<(usize, &'static str, f64)> {
        None
    }

    /// Of a rotor: the body of the axle that it turns with, and what the axle's turning feels of it below the drive's own frequency, n^2 J, kg m2.
    fn rotor_on_axle(&self) -> Option<(usize, f64)> {
        None
    }

    /// Of an element between places: one of them is on an axle, whose bearings hand no moment about it over.
    fn free_about_axle(&mut self) {}

    /// Takes from the vehicle, which is complete now, what it needs to know of axles.
    fn fit(&mut self, _axles: &Axles) {}

    /// Angular momentum of its own rotating parts, beside that of the bodies, in the world, N m s.
    fn angular_momentum(&self, _bodies: &Moving, _state: &[f64]) -> Vector3<f64> {
        Vector3::zeros()
    }

    /// Power that its inputs bring in, W.
    fn supplied_power(&self, _bodies: &Moving, _state: &[f64]) -> f64 {
        0.0
    }

    /// Does it act in steady running whatever its inputs are, from outside?
    fn resists(&self) -> bool {
        false
    }

    /// May its inputs bring power in?
    fn is_supplied(&self) -> bool {
        false
    }

    /// May it turn power into heat?
    fn is_dissipative(&self) -> bool {
        true
    }

    /// Puts the states where they come to rest with the bodies at rest where they are.
    fn settle(&self, _bodies: &Moving, _state: &mut [f64]) {}

    /// Of dry friction between two bodies: where its places are.
    fn rub(&self, _bodies: &Moving) -> Option<Rub> {
        None
    }

    /// Puts the states of dry friction where a slow, straight way of its places from there, where it held nothing, leaves them.
    fn drag(&self, _from: &Rub, _bodies: &Moving, _state: &mut [f64]) {}

    /// Adds the element's wrenches to those of the bodies, in the track frame, and writes the rates of its states.
    fn apply(&self, bodies: &Moving, state: &[f64], rates: &mut [f64], wrenches: &mut [Wrench]);

    /// The bodies that the element acts between and loads; it follows the motion of no others but its [`ForceElement::rotor_carrier`]. `None`: the world or the track.
    fn bodies(&self) -> Ends;

    /// Where it holds on to its bodies, of elements that hold on to places.
    fn holds(&self) -> [Option<Attachment>; 2] {
        [None; 2]
    }

    /// All bodies that it loads or follows; one may be named twice.
    fn reach(&self) -> [Option<usize>; 3] {
        let [from, to] = self.bodies();
        [from, to, self.rotor_carrier()]
    }

    /// Adds how wrenches and rates change with the motion of the element's bodies and with its own states, the first of which stands at
    /// `first_state` of the state vector.
    fn tangent(&self, bodies: &Moving, state: &[f64], first_state: usize, sum: &mut PairTangent);

    /// Weight of the local error of its states, by that of a position in metres: more where a small error makes a large force.
    fn state_weight(&self) -> f64 {
        1.0
    }

    /// What the element can report.
    fn quantities(&self) -> &'static [Quantity] {
        &[]
    }

    /// The value of the quantity at `index` of [`ForceElement::quantities`], SI; zero beyond them.
    fn quantity(&self, _index: usize, _bodies: &Moving, _state: &[f64]) -> f64 {
        0.0
    }

    /// The tables of force over length or speed that it follows.
    fn tables(&self) -> Vec<Table> {
        Vec::new()
    }

    /// Where it is in the table at an index of [`ForceElement::tables`], m or m/s.
    fn table_argument(&self, _table: usize, _bodies: &Moving, _state: &[f64]) -> f64 {
        0.0
    }

    /// Elongations between which a stop is free, m.
    fn free_travel(&self) -> Option<[f64; 2]> {
        None
    }

    /// What in its data was probably meant otherwise, in words.
    fn doubt(&self) -> Option<String> {
        None
    }

    /// Length between both places as it was drawn, m, of an element along the line between them that reports its elongation second; `None` of others.
    fn drawn_length(&self) -> Option<f64> {
        None
    }

    /// Of a stop: what it meets.
    fn strike(&self, _bodies: &Moving) -> Option<Strike> {
        None
    }

    /// Stiffness along each preload that balance is to find (`preload = "static"`), N/m; empty where the preload is given.
    fn static_stiffness(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Sets the preload at an index of [`ForceElement::static_stiffness`], N.
    fn set_preload(&mut self, _index: usize, _force: f64) {}

    /// Of an element whose spring can't but press: along which axis of its first body it presses the second one away.
    fn presses(&self) -> Option<Vector3<f64>> {
        None
    }

    /// Can its preload not pull, as a bag of air can't?
    fn pushes_alone(&self) -> bool {
        false
    }

    /// Stored energy, J, up to a constant; with the kinetic energy of its own rotating parts.
    fn potential_energy(&self, bodies: &Moving, state: &[f64]) -> f64;

    /// Power that turns into heat, W, never negative.
    fn dissipated_power(&self, bodies: &Moving, state: &[f64]) -> f64;
}

/// What each element has because it is copied ([`Clone`]) and says its numbers in a table ([`Numbered`]).
pub trait Part {
    /// Its numbers that may be set before a run, and which of them during it too.
    fn constants(&self) -> Vec<Number>;

    /// Sets the one of that [`Number::number`].
    fn set_constant(&mut self, number: u32, value: f64);

    /// A copy behind a pointer.
    fn clone_box(&self) -> Box<dyn ForceElement>;
}

impl<E: ForceElement + Numbered + Clone> Part for E {
    fn constants(&self) -> Vec<Number> {
        self.numbers()
    }

    fn set_constant(&mut self, number: u32, value: f64) {
        self.set_number(number, value);
    }

    fn clone_box(&self) -> Box<dyn ForceElement> {
        Box::new(self.clone())
    }
}

/// What a stop meets: how its force answers to relative motion of its ends where it is pressed, or will be when it touches.
#[derive(Clone, Copy, Debug)]
pub struct Strike {
    /// N/m.
    pub stiffness: f64,
    /// Its line's direction, and a point on it, m; world axes.
    pub unit: Vector3<f64>,
    pub point: Vector3<f64>,
    pub ends: Ends,
}

impl Strike {
    /// Least cosine between the lines of a stop and the track where it acts along the track.
    const ALONG: f64 = 0.7;

    /// Cosine between its line and the track's direction, `None` where it acts across.
    pub fn along(&self, track: &Vector3<f64>) -> Option<f64> {
        let cosine = self.unit.dot(track);
        (cosine.abs() >= Self::ALONG).then_some(cosine)
    }
}

/// One scalar that an element reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// Fixed among those of the element (0 to 49).
    pub number: u32,
    /// Structured name, appended to the element's.
    pub name: &'static str,
    pub kind: QuantityKind,
    pub description: &'static str,
}

/// One input of an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementInput {
    /// Fixed among those of the element (0 to 49).
    pub number: u32,
    /// Structured name, appended to the element's.
    pub name: &'static str,
    pub unit: Unit,
    pub least: Option<f64>,
    pub description: &'static str,
}

/// What a reported scalar is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuantityKind {
    /// N.
    Force,
    /// N m.
    Moment,
    /// m.
    Displacement,
    /// rad.
    Angle,
    /// m/s.
    Speed,
    /// rad/s.
    AngularSpeed,
    /// W.
    Power,
}

/// Is `preload = "static"` given?
fn static_preload(section: &Section) -> Result<bool, SettingsError> {
    match section.text("preload") {
        Ok(text) if text == "static" => Ok(true),
        // Any other word is an error, unless it is a number with a unit.
        Ok(text) if crate::units::Dimension::Force.parse(&text).is_none() => {
            Err(section
                .error("preload", format!("found \"{text}\", expected a force in N (\"12 kN\") or \"static\": what balance asks for")))
        }
        _ => Ok(false),
    }
}

/// Smallest value of a constant that must be greater than zero.
const POSITIVE: Option<f64> = Some(1e-9);

/// Reads an element from its section of a scene (`from`, `to` and its own keys).
pub type Parse = fn(&Section, &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError>;

/// The force elements that a scene can name in `kind`.
pub static REGISTRY: &[Entry<Parse>] = &[
    spring_damper::ENTRY,
    bushing::ENTRY,
    maxwell_damper::ENTRY,
    bump_stop::ENTRY,
    anti_roll_bar::ENTRY,
    dry_friction::ENTRY,
    coupler::ENTRY,
    GUIDED_SPRING,
    motor_gear::ENTRY,
    cardan_drive::ENTRY,
    brake::ENTRY,
    running_resistance::ENTRY,
    eddy_current_brake::ENTRY,
    magnetic_track_brake::ENTRY,
    external_load::ENTRY,
    actuator::ENTRY,
    twisting_axle::FLEXIBLE,
    twisting_axle::INDEPENDENT,
    air_spring::ENTRY,
    friction_wedge::ENTRY,
];

/// Reads the element that `kind` names; the caller finishes the section.
///
/// # Errors
/// What is missing or wrong, with its place.
pub fn read(section: &Section, places: &dyn Places) -> Result<Box<dyn ForceElement>, SettingsError> {
    (choose(REGISTRY, section, "kind")?.parse)(section, places)
}
