//! Bodies and places for elements that are read from text, and their integration in time.

use nalgebra::Vector3;
use wheelrail::mbs::body::{Body, BodyMotion, COORDINATES, Wrench};
use wheelrail::mbs::force::{self, Attachment, ForceElement, Places};
use wheelrail::mbs::inertia::Inertia;
use wheelrail::mbs::moving::Moving;
use wheelrail::mbs::system::{System, SystemWorkspace};
use wheelrail::settings::{Section, SettingsError, Source};
use wheelrail::solve::{DormandPrince, Dynamics, Implicit, Integrator, Scratch, Undefined};

/// Places by name: body and position in the design configuration, world axes.
pub struct Stage {
    pub centres: Vec<Vector3<f64>>,
    pub places: Vec<(&'static str, Option<usize>, Vector3<f64>)>,
    pub mirror: f64,
}

impl Stage {
    fn position(&self, place: &Attachment) -> Vector3<f64> {
        place.local + place.body.map_or_else(Vector3::zeros, |body| self.centres[body])
    }

    pub fn read(&self, settings: &str) -> Result<Box<dyn ForceElement>, SettingsError> {
        let source = Source { file: "scene".into(), text: settings.into(), overridden: vec![], folder: None };
        let document = toml_edit::Document::parse(settings.to_string()).unwrap();
        let section = Section::root(document.as_table(), &source);
        let element = force::read(&section, self)?;
        section.finish()?;
        Ok(element)
    }

    pub fn element(&self, settings: &str) -> Box<dyn ForceElement> {
        self.read(settings).unwrap_or_else(|error| panic!("{settings}: {error}"))
    }

    /// Coordinates of the design configuration.
    pub fn design(&self) -> Vec<f64> {
        self.centres.iter().flat_map(|centre| [centre.x, centre.y, centre.z, 0.0, 0.0, 0.0]).collect()
    }
}

impl Places for Stage {
    fn attachment(&self, section: &Section, key: &'static str) -> Result<Attachment, SettingsError> {
        let name = section.text(key)?;
        let place = self.places.iter().find(|place| place.0 == name).ok_or_else(|| section.error(key, "no such place"))?;
        let centre = place.1.map_or_else(Vector3::zeros, |body| self.centres[body]);
        Ok(Attachment { body: place.1, local: place.2 - centre })
    }

    fn design_vector(&self, from: &Attachment, to: &Attachment) -> Vector3<f64> {
        self.position(to) - self.position(from)
    }

    fn mirror(&self) -> f64 {
        self.mirror
    }
}

/// One body at the origin, held at its centre; `reach` is a place of the world beside it.
pub fn alone(reach: Vector3<f64>) -> Stage {
    Stage { centres: vec![Vector3::zeros()], places: vec![("world", None, reach), ("body", Some(0), Vector3::zeros())], mirror: 1.0 }
}

pub fn brick(mass: f64, x: f64, y: f64, z: f64) -> Body {
    Body { name: "brick".into(), mass, inertia: Inertia::General { principal: Vector3::new(x, y, z) } }
}

pub fn motions(q: &[f64], v: &[f64]) -> Vec<BodyMotion> {
    q.chunks(COORDINATES).zip(v.chunks(COORDINATES)).map(|(q, v)| BodyMotion::general(q, v)).collect()
}

/// Wrenches and rates of an element without inputs.
pub fn apply(element: &dyn ForceElement, bodies: &[BodyMotion], state: &[f64]) -> (Vec<Wrench>, Vec<f64>) {
    apply_under(element, bodies, state, &[])
}

/// Bodies on straight level track as an element with inputs sees them.
pub fn under<'a>(bodies: &'a [BodyMotion], inputs: &'a [f64]) -> Moving<'a> {
    Moving { inputs, ..Moving::from(bodies) }
}

/// Wrenches and rates of an element.
pub fn apply_under(element: &dyn ForceElement, bodies: &[BodyMotion], state: &[f64], inputs: &[f64]) -> (Vec<Wrench>, Vec<f64>) {
    let (mut wrenches, mut rates) = (vec![Wrench::default(); bodies.len()], vec![0.0; element.states()]);
    element.apply(&under(bodies, inputs), state, &mut rates, &mut wrenches);
    (wrenches, rates)
}

/// A system with the heat that its elements make, less what their inputs bring in, as one more component of the state.
pub struct Mechanism {
    pub system: System,
    pub workspace: SystemWorkspace,
}

impl Mechanism {
    pub fn new(bodies: Vec<Body>, forces: Vec<Box<dyn ForceElement>>) -> Self {
        Self::of(System { bodies, forces, drives: Vec::new(), supported: Vec::new(), joints: Vec::new(), redundant: Vec::new() })
    }

    pub fn of(system: System) -> Self {
        Mechanism { workspace: system.workspace(&[]), system }
    }

    /// The whole state from coordinates and velocities, the elements at rest without their inputs, no heat yet.
    pub fn state(&mut self, q: &[f64], v: &[f64]) -> Vec<f64> {
        let mut y = [q, v].concat();
        y.resize(self.system.dimension() + 1, 0.0);
        let inputs = self.workspace.inputs.clone();
        self.workspace.inputs.fill(0.0);
        self.system.settle_forces(&mut y, &mut self.workspace);
        self.workspace.inputs = inputs;
        y
    }

    pub fn run(&mut self, y: &[f64], end: f64, tolerance: f64) -> Vec<f64> {
        let integrator = DormandPrince { tolerance };
        let mut y = y.to_vec();
        let mut scratch = Scratch::new(y.len(), 0);
        let mut state = integrator.start(0.0, &y);
        integrator.advance(self, &mut state, &mut scratch, end).unwrap();
        state.interpolate_beside(end, &mut y, |_, _| ());
        y
    }

    /// Kinetic and stored energy and heat so far, J.
    pub fn energy(&mut self, y: &[f64]) -> f64 {
        self.system.move_bodies(y, &mut self.workspace);
        let motions = &self.workspace.motions;
        self.system.kinetic_energy(motions) + self.system.potential_energy(y, &self.workspace.moving()) + y[self.system.dimension()]
    }

    pub fn accelerations(&mut self, q: &[f64]) -> Vec<f64> {
        let y = self.state(q, &vec![0.0; q.len()]);
        let mut dy = vec![0.0; y.len()];
        self.derivative(0.0, &y, &mut dy).unwrap();
        dy[q.len()..2 * q.len()].to_vec()
    }
}

impl Dynamics for Mechanism {
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) -> Result<(), Undefined> {
        self.system.apply_forces(y, &mut self.workspace);
        dy[y.len() - 1] = self.system.dissipated_power(y, &self.workspace) - self.system.supplied_power(y, &self.workspace);
        self.system.constrained_derivative(t, y, &mut self.workspace, dy).map_err(|_| Undefined)
    }
    fn error_weight(&self, i: usize) -> f64 {
        let velocities = COORDINATES * self.system.bodies.len();
        if (velocities..2 * velocities).contains(&i) || i == self.system.dimension() { 0.0 } else { 1.0 }
    }
    fn next_break(&self, _: f64, _: &[f64]) -> f64 {
        f64::INFINITY
    }
}

impl Implicit for Mechanism {}
