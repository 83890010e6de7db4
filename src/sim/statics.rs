//! How a vehicle stands at its start: heights of bodies against where the scene draws them, wheel loads, forces of elements and travel used.

use super::outputs::on_track;
pub use super::uneven_loads::WheelLoads;
use super::{Simulation, SimulationError, SimulationState, uneven_loads};
use crate::formulation::contact_index;
use crate::geometry::Side;
use crate::mbs::body::{COORDINATES, Wrench};
use crate::mbs::force::{ForceElement, Quantity, QuantityKind};
use crate::mbs::moving::Moving;
use crate::scene::spec::Scene;
use nalgebra::Vector3;
use serde::Serialize;

/// A body that stands further from where it is drawn than this is worth a note, m.
pub const SETTLED: f64 = 0.05;

/// Slack of a coupler that is worth a word, m, and the largest force that counts as next to nothing, N.
const SLACK: f64 = 2e-3;
const LIGHT: f64 = 1e3;

/// One body's place; lengths in m, angles in rad.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodyPlace {
    pub name: String,
    /// Height of the centre of mass over the nominal contact height: in the scene's design configuration, and at the start.
    pub drawn_height: f64,
    pub height: f64,
    /// By how much lower it stands than it is drawn.
    pub settles: f64,
    pub roll: f64,
    pub pitch: f64,
}

/// One force of an element with the displacement that belongs to it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ElementForce {
    /// With the axis, where it has several.
    pub name: String,
    /// N, or N m where `turns`.
    pub force: f64,
    /// From the design configuration, m, or rad where `turns`.
    pub displacement: f64,
    pub turns: bool,
    /// Where a stop is free, m; `None` on a side that does not stop, and of elements that are no stops.
    pub free_travel: Option<[Option<f64>; 2]>,
    /// Share of the free travel on the side of the displacement that is used: above 1 the stop presses.
    pub travel_used: Option<f64>,
    /// Does it act along the track, as couplers do?
    #[serde(skip)]
    pub along_track: bool,
}

/// All of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statics {
    pub bodies: Vec<BodyPlace>,
    pub wheels: Vec<WheelLoads>,
    pub elements: Vec<ElementForce>,
}

/// How the scene's vehicle stands at the simulation's present time.
///
/// # Errors
/// When the model cannot be evaluated here.
pub fn statics(scene: &Scene, simulation: &mut Simulation) -> Result<Statics, SimulationError> {
    let s = simulation.snapshot()?.clone();
    let model = simulation.model();
    let bodies = model.system.bodies.iter().enumerate().map(|(index, body)| {
        let q = on_track(&s, index)
            .map_or_else(|| std::array::from_fn::<f64, COORDINATES, _>(|i| s.y[COORDINATES * index + i]), |(motion, _)| motion.coordinates);
        let drawn_height = scene.vehicle.design_position(index).z;
        // A wheelset's pitch is its rotation.
        let pitch = if index < model.wheelsets.len() { 0.0 } else { q[5] };
        BodyPlace { name: body.name.clone(), drawn_height, height: q[2], settles: drawn_height - q[2], roll: q[4], pitch }
    });
    let wheels = model.wheelsets.iter().enumerate().map(|(index, wheelset)| {
        let [left, right] = Side::BOTH.map(|side| s.workspace.wheel_force(contact_index(index, side), wheelset.body).z);
        WheelLoads { wheelset: wheelset.name.clone(), left, right }
    });
    let elements = model.system.forces.iter().enumerate().flat_map(|(index, element)| {
        let states = &s.y[model.system.states_of_force(index)];
        element_forces(element.as_ref(), &model.system.seen_by(index, &s.workspace.system), states)
    });
    Ok(Statics { bodies: bodies.collect(), wheels: wheels.collect(), elements: elements.collect() })
}

fn element_forces(element: &dyn ForceElement, bodies: &Moving, states: &[f64]) -> Vec<ElementForce> {
    let of = |kind: QuantityKind| {
        let all: Vec<(usize, &Quantity)> = element.quantities().iter().enumerate().filter(|(_, quantity)| quantity.kind == kind).collect();
        all
    };
    let value = |index: usize| element.quantity(index, bodies, states);
    let free = element.free_travel();
    let along_track = free.is_some() && acts_along_track(element, bodies, states);
    let pair = |turns: bool| {
        let (loads, ways, prefix) = match turns {
            false => (of(QuantityKind::Force), of(QuantityKind::Displacement), "force"),
            true => (of(QuantityKind::Moment), of(QuantityKind::Angle), "moment"),
        };
        let one = move |((load, quantity), (way, _)): ((usize, &Quantity), (usize, &Quantity))| {
            let axis = quantity.name.strip_prefix(prefix).map_or(quantity.name.to_string(), str::to_lowercase);
            let kind = if turns { "about " } else { "" };
            let name = if axis.is_empty() { element.name().to_string() } else { format!("{} {kind}{axis}", element.name()) };
            let displacement = value(way);
            let limit = free.map(|[shorter, longer]| if displacement < 0.0 { shorter } else { longer }).filter(|limit| limit.is_finite());
            ElementForce {
                name,
                force: value(load),
                displacement,
                turns,
                free_travel: free.map(|limits| limits.map(|limit| limit.is_finite().then_some(limit))),
                travel_used: limit.filter(|limit| *limit != 0.0).map(|limit| displacement / limit),
                along_track,
            }
        };
        loads.into_iter().zip(ways).map(one).collect::<Vec<_>>()
    };
    [pair(false), pair(true)].concat()
}

/// Is the force on an element's first body one along the track, not across it?
fn acts_along_track(element: &dyn ForceElement, bodies: &Moving, states: &[f64]) -> bool {
    let Some(first) = element.bodies().into_iter().flatten().next() else { return false };
    let (mut rates, mut wrenches) = (vec![0.0; states.len()], vec![Wrench::default(); bodies.motions.len()]);
    element.apply(bodies, states, &mut rates, &mut wrenches);
    let force = wrenches[first].force;
    force.dot(&bodies.station(first).map_or(Vector3::x(), |station| station.frame.along())).abs() > 0.7 * force.norm()
}

impl Statics {
    /// What a reader should know: bodies that stand far from where they are drawn, slack that is taken up, wheels that carry unlike loads.
    pub fn notes(&self, scene: &Scene) -> Vec<String> {
        self.settled().into_iter().chain(self.taken_up()).chain(uneven_loads::note(scene, &self.wheels)).collect()
    }

    /// Couplers whose whole slack a few newtons have taken up: what differs in the resistance of the vehicles beside them.
    fn taken_up(&self) -> Option<String> {
        let ends = |element: &ElementForce| match element.free_travel {
            Some([Some(shorter), Some(longer)]) => {
                element.along_track && longer - shorter > SLACK && element.travel_used.is_some_and(|used| used > 1.0 - 1e-6)
            }
            _ => false,
        };
        let mut all = self.elements.iter().filter(|element| ends(element) && element.force.abs() < LIGHT);
        let first = all.next()?;
        let more = match all.count() {
            0 => String::new(),
            count => format!(" (and {count} more)"),
        };
        Some(format!(
            "{}{more} starts at the end of its slack, {:.1} mm from the middle, under {:.0} N: so much the vehicles beside it differ in resistance (wheels that are not there roll without any), and what the slack does \
             when it is run in or out begins from there",
            first.name,
            1e3 * first.displacement,
            first.force
        ))
    }

    fn settled(&self) -> Option<String> {
        let mut far: Vec<&BodyPlace> = self.bodies.iter().filter(|body| !(body.settles.abs() <= SETTLED)).collect();
        far.sort_by(|a, b| b.settles.abs().total_cmp(&a.settles.abs()));
        let worst = far.first()?;
        let side = if worst.settles > 0.0 { "below" } else { "above" };
        let more = match far.len() - 1 {
            0 => String::new(),
            1 => " (and another body by more than 50 mm)".to_string(),
            count => format!(" (and {count} more bodies by more than 50 mm)"),
        };
        let (height, drawn, by) = (worst.height, worst.drawn_height, 1e3 * worst.settles.abs());
        Some(format!(
            "{} starts {by:.0} mm {side} where it is drawn, at {height:.3} m instead of {drawn:.3} m{more}: the preloads do not carry the weight there; preload = \"static\" takes them from balance, and wheelrail plan --static shows heights and forces",
            worst.name
        ))
    }
}

impl Simulation {
    /// Puts rails that give way where they rest under the contacts as they are now.
    ///
    /// # Errors
    /// [`SimulationError`] where contacts can't be evaluated.
    pub(super) fn settle_rails(&mut self) -> Result<(), SimulationError> {
        let SimulationState { time, integration, memories, .. } = &mut self.state;
        let inputs = self.model.start_inputs();
        self.model.at(&mut self.workspace, *time, &mut integration.y, &mut memories.accepted).settle_rails(&inputs)?;
        Ok(())
    }
}
