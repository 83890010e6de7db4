//! The equations of steady running: places in the track frame, the pattern's velocities, and what is left of the balance.

use super::couplings::Couplings;
use super::friction::Friction;
use super::rails::{Ride, Riding};
use super::slopes::Entry;
use super::twists::Twists;
use super::{Contacts, Standing, SteadyState};
use crate::formulation::memory::ModelMemory;
use crate::formulation::{AssemblyError, Evaluation, EvaluationError, Model, Workspace, contact_index};
use crate::geometry::Side;
use crate::geometry::track::Track;
use crate::geometry::track::centre_line::{Alignment, CentreLine, Node};
use crate::geometry::track::station::Station;
use crate::mbs::body::COORDINATES;
use crate::mbs::on_track::{self, OnTrack};
use crate::scene::assemble;
use crate::scene::equilibrium::EquilibriumError;
use crate::scene::spec::Scene;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// The motion that all bodies take part in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pattern {
    /// V, m/s.
    pub speed: f64,
    /// Of the centripetal accelerations at that speed which count where nothing constrains them (see `super`, *Slow*).
    pub centripetal: f64,
}

/// What Newton's method may change.
#[derive(Clone, Copy, Debug)]
pub(super) enum Unknown {
    /// A coordinate of a body, and how far it is moved for a difference, m or rad.
    Coordinate { body: usize, axis: usize, step: f64 },
    /// The pitch rate of a wheelset, in parts of `unit` [rad/s].
    Spin { body: usize, unit: f64 },
    /// The common acceleration along the track.
    Slowing,
}

/// Where the bodies are, and what goes with it.
#[derive(Clone, Debug)]
pub(super) struct Configuration {
    pub at: Vec<OnTrack>,
    /// m/s2.
    slowing: f64,
    /// S, m/s.
    pub travel: f64,
    /// Which places of the wheels are in contact, and where.
    pub memory: ModelMemory,
}

/// Place of a wheelset's pitch rate among its velocities, of pitch among coordinates.
pub(super) const PITCH: usize = COORDINATES - 1;

/// Accelerations count in parts of this, m/s2 or rad/s2.
pub(super) const UNIT: f64 = 9.81;
/// Evaluations of one wheel after which a search is given up: about 1 s, on a machine that does much else 2 s.
const MOST_EFFORT: u64 = 150_000;
/// Wheels of a vehicle that has so much. A train has more: by its length and half as much again, for shares of the curve at which one of its wheels hangs.
const COACH: u64 = 8;
/// Moves onto constraints count in parts of this, m or rad.
const MOVE: f64 = 1e-4;

pub(super) struct Search<'a> {
    pub standing: &'a Standing,
    pub pattern: Pattern,
    pub model: Model,
    pub workspace: Workspace,
    pub now: Configuration,
    /// The body whose speed is V.
    leading: usize,
    /// Of the track at present, 1/m.
    curvature: f64,
    /// What bodies do beside the pattern, and the accelerations along the track frame's axes that go with it, m/s2 or rad/s2.
    pub rides: Vec<Ride>,
    pub accelerations: Vec<[f64; COORDINATES]>,
    /// Do bodies ride at all?
    pub riding: bool,
    pub y: Vec<f64>,
    dy: Vec<f64>,
    inputs: Vec<f64>,
    /// Do contacts that are constraints stay those that they were? Otherwise each wheel's deepest place is taken each time.
    pub following: bool,
    /// Do rails that can give way do so?
    pub rails_yield: bool,
    /// Are there constraints that coordinates must be moved onto?
    pub constrained: bool,
    /// Rest of the equations that counts as none.
    pub tolerance: f64,
    /// Is a try given up early, because a nearer place is tried next?
    pub hasty: bool,
    /// Work done so far, in evaluations of one wheel.
    pub effort: u64,
    pub unknowns: Vec<Unknown>,
    /// Row of the square system for each coordinate; `None` where the speed is imposed.
    pub square: Vec<Option<usize>>,
    couplings: Couplings,
    pub twists: Twists,
    pub friction: Friction,
}

impl<'a> Search<'a> {
    pub fn new(scene: &Scene, standing: &'a Standing, pattern: Pattern) -> Result<Self, AssemblyError> {
        let mut scene = scene.clone();
        // The balance is that at the speed of the pattern.
        scene.vehicle = scene.vehicle.steady();
        scene.vehicle.speed = pattern.speed;
        let model = assemble::model(&scene)?.ideal();
        let place = |position: &Vector3<f64>| OnTrack {
            coordinates: [position.x, position.y, position.z, 0.0, 0.0, 0.0],
            velocities: [pattern.speed, 0.0, 0.0, 0.0, 0.0, 0.0],
        };
        let mut at: Vec<OnTrack> = standing.positions.iter().map(place).collect();
        for wheelset in &model.wheelsets {
            at[wheelset.body].velocities[PITCH] = pattern.speed / wheelset.left.profile.at(0.0).value;
        }
        let mut search = Search {
            workspace: model.workspace(),
            y: vec![0.0; model.dimension()],
            dy: vec![0.0; model.dimension()],
            following: false,
            rails_yield: true,
            tolerance: super::BALANCED,
            hasty: false,
            effort: 0,
            twists: Twists::new(&model),
            friction: Friction::default(),
            inputs: if scene.vehicle.initial.driven { model.start_inputs() } else { model.neutral_inputs() },
            constrained: model.formulation.constrains() || !model.system.joints.is_empty(),
            leading: model.system.drives.iter().map(|drive| drive.body).min().unwrap_or(0),
            curvature: 0.0,
            rides: vec![Ride::default(); at.len()],
            accelerations: vec![[0.0; COORDINATES]; at.len()],
            riding: false,
            now: Configuration { at, slowing: 0.0, travel: pattern.speed, memory: model.blank_memory() },
            unknowns: Vec::new(),
            square: Vec::new(),
            couplings: Couplings::new(&model.system),
            standing,
            pattern,
            model,
        };
        search.unknowns = search.unknowns();
        let mut count = 0..;
        let coordinates = 0..COORDINATES * search.now.at.len();
        search.square = coordinates.map(|i| if search.fixed(i / COORDINATES, i % COORDINATES) { None } else { count.next() }).collect();
        Ok(search)
    }

    pub fn held(&self, body: usize, axis: usize) -> bool {
        body == 0 && self.standing.held.contains(&axis)
    }

    /// Does it go where rigid rails lead it? A body that is held aside of its balance is pushed along them.
    fn led(&self, body: usize, axis: usize) -> bool {
        body == 0 && axis != PITCH && !self.standing.held.is_empty() && self.model.formulation.constrains()
    }

    /// Is a coordinate no unknown, and its acceleration whatever it is?
    fn fixed(&self, body: usize, axis: usize) -> bool {
        self.held(body, axis) || axis == 0 && self.model.system.drives.iter().any(|drive| drive.body == body)
    }

    fn unknowns(&self) -> Vec<Unknown> {
        let wheelsets = self.standing.wheelsets;
        let elastic = !self.model.formulation.constrains();
        let mut unknowns = Vec::new();
        for body in 0..self.now.at.len() {
            for axis in 0..COORDINATES {
                unknowns.push(match axis {
                    _ if self.fixed(body, axis) => continue,
                    0 if body == 0 && self.model.system.drives.is_empty() => Unknown::Slowing,
                    PITCH if body < wheelsets => Unknown::Spin { body, unit: self.now.at[body].velocities[PITCH].abs() },
                    // Height and roll press wheels into rails: 1e-9 m are some newtons.
                    2 | 4 if body < wheelsets && elastic => Unknown::Coordinate { body, axis, step: 1e-9 },
                    _ => Unknown::Coordinate { body, axis, step: 1e-6 },
                });
            }
        }
        unknowns
    }

    /// Lays the track: `node` all the way, the rails displaced by a share of what `riding` says. Contacts are where they were.
    pub fn lay(&mut self, node: &Node, riding: Option<(&Riding, f64)>) {
        let line = CentreLine::new(&Alignment { nodes: vec![*node], ..Alignment::default() }, Vector3::zeros(), 0.0).map(Arc::new);
        self.model.lay(match riding {
            Some((riding, share)) => riding.track(line, share),
            None => {
                let Track { left, right } = self.model.track.ideal();
                Track { left: left.along(line.clone()), right: right.along(line) }
            }
        });
        self.curvature = node.curvature;
        self.workspace = self.model.workspace();
        self.now.memory.distances.resize(self.model.followed(), 0.0);
    }

    pub fn configuration(&self) -> Configuration {
        self.now.clone()
    }

    /// Puts a configuration back, on whatever track lies here now.
    pub fn put(&mut self, configuration: &Configuration) {
        self.now.clone_from(configuration);
        self.now.memory.distances.resize(self.model.followed(), 0.0);
    }

    /// The same without what it knows of contacts, which may be those of another formulation.
    pub fn put_bodies(&mut self, configuration: &Configuration) {
        self.now = Configuration { memory: self.model.blank_memory(), ..configuration.clone() };
    }

    /// Chooses the contacts that are constraints here anew.
    pub fn choose_anew(&mut self) -> Result<(), EquilibriumError> {
        self.follow_pattern(true);
        self.following = false;
        let done = self.evaluate();
        self.following = true;
        done.map_err(EquilibriumError::Evaluation)
    }

    /// Goes on along the line from an earlier configuration through the present one, by this part of their distance.
    pub fn go_on(&mut self, earlier: &Configuration, part: f64) {
        self.now.slowing += part * (self.now.slowing - earlier.slowing);
        for (now, earlier) in self.now.at.iter_mut().zip(&earlier.at) {
            let numbers = now.coordinates.iter_mut().chain(&mut now.velocities);
            for (now, earlier) in numbers.zip(earlier.coordinates.iter().chain(&earlier.velocities)) {
                *now += part * (*now - earlier);
            }
        }
    }

    /// Gives all bodies the velocities of the pattern; with `renew` its travel is that of the leading wheelset where it now is.
    pub fn follow_pattern(&mut self, renew: bool) {
        let Configuration { at, travel, .. } = &mut self.now;
        let system = &mut self.model.system;
        let line = self.model.track.line();
        let turn = line.map_or(Vector3::zeros(), |line| line.frame(0.0).turn);
        let stretch = |at: &OnTrack| 1.0 - (at.coordinates[1] * turn.z - at.coordinates[2] * turn.y);
        if renew {
            *travel = self.pattern.speed / stretch(&at[self.leading]);
        }
        for (body, (at, ride)) in at.iter_mut().zip(&self.rides).enumerate() {
            at.velocities[0] = *travel * stretch(at);
            let count = if body < self.standing.wheelsets { PITCH } else { COORDINATES };
            for (velocity, slope) in at.velocities[1..count].iter_mut().zip(&ride.slopes[1..]) {
                *velocity = *travel * slope;
            }
            let (q, v) = match line {
                Some(line) => on_track::place(&line.frame(at.coordinates[0]), at),
                None => (at.coordinates, at.velocities),
            };
            self.y[system.coordinates(body)].copy_from_slice(&q);
            self.y[system.velocities(body)].copy_from_slice(&v);
        }
        for drive in &mut system.drives {
            drive.speed = at[drive.body].velocities[0];
        }
    }

    /// Accelerations at `y`, which is moved onto the constraints first.
    pub fn evaluate(&mut self) -> Result<(), EvaluationError> {
        let Search { model, workspace, y, dy, inputs, now: Configuration { at, memory, .. }, following, twists, friction, .. } = self;
        model.set_distances(|body| at[body].coordinates[0], memory);
        let mut step = model.at(workspace, 0.0, y, memory);
        if model.formulation.constrains() && *following {
            model.formulation.resettle(&mut step)?;
        } else if model.formulation.constrains() || model.formulation.states_per_contact() > 0 {
            model.formulation.start(&mut step)?;
        }
        if self.constrained {
            step.project()?;
        }
        model.take_inputs(&mut workspace.system, 0.0, inputs);
        model.system.settle_forces(y, &mut workspace.system);
        friction.put(&model.system, &workspace.system, y);
        twists.put(&workspace.system, y);
        if self.rails_yield {
            let rounds = model.at(workspace, 0.0, y, memory).settle_rails(inputs)?;
            self.effort += (rounds * model.contacts()) as u64;
        }
        model.derivative(workspace, Evaluation { t: 0.0, inputs, y, memory }, dy)?;
        let rounds = twists.settle(model, workspace, inputs, (y, dy), memory)?;
        self.effort += (rounds * model.contacts()) as u64;
        Ok(())
    }

    /// Has the search done all the work that it may?
    pub fn exhausted(&self) -> bool {
        let coaches = (self.model.contacts() as u64).div_ceil(COACH);
        self.effort > MOST_EFFORT * ((3 * coaches - 1) / 2)
    }

    fn change(&mut self, unknown: Unknown, change: f64) {
        match unknown {
            Unknown::Coordinate { body, axis, .. } => self.now.at[body].coordinates[axis] += change,
            Unknown::Spin { body, unit } => self.now.at[body].velocities[PITCH] += unit * change,
            Unknown::Slowing => self.now.slowing += UNIT * change,
        }
    }

    /// What is to vanish, with the unknowns moved by `change`; the configuration stays as it was unless `keep`.
    pub fn residual(&mut self, change: &[f64], keep: bool) -> Result<Vec<f64>, EvaluationError> {
        let before = self.now.clone();
        for (place, change) in change.iter().enumerate() {
            self.change(self.unknowns[place], *change);
        }
        let rest = self.rest(true, keep);
        if !keep || rest.is_err() {
            self.now = before;
        }
        rest
    }

    /// What is to vanish here. With `keep` the configuration is put onto the constraints.
    pub fn rest(&mut self, renew: bool, keep: bool) -> Result<Vec<f64>, EvaluationError> {
        self.follow_pattern(renew);
        // Bringing what is left onto the constraints costs as much again.
        self.effort += self.model.contacts() as u64 * if self.constrained && self.riding { 2 } else { 1 };
        self.evaluate()?;
        let count = COORDINATES * self.now.at.len();
        let mut rest = vec![0.0; if self.constrained { 2 * count } else { count }];
        for body in 0..self.now.at.len() {
            let row = COORDINATES * body;
            let mut off = self.off_the_pattern(body);
            (0..COORDINATES).filter(|axis| self.fixed(body, *axis) || self.led(body, *axis)).for_each(|axis| off[axis] = 0.0);
            rest[row..row + COORDINATES].copy_from_slice(&off);
        }
        let constrained = if self.constrained { self.now.at.len() } else { 0 };
        for body in 0..constrained {
            let row = COORDINATES * body;
            let found = self.in_the_track_frame(body);
            for (i, found) in found.into_iter().enumerate() {
                if self.held(body, i) {
                    continue;
                }
                let asked = &mut self.now.at[body].coordinates;
                rest[count + row + i] = if keep { 0.0 } else { (found - asked[i]) / MOVE };
                if keep {
                    asked[i] = found;
                }
            }
        }
        if self.constrained && self.riding {
            self.allowed(&mut rest[..count])?;
            for drive in &self.model.system.drives {
                rest[COORDINATES * drive.body] = 0.0;
            }
        }
        Ok(rest)
    }

    /// A body's coordinates in the track frame from those that the constraints have given it in the world.
    fn in_the_track_frame(&self, body: usize) -> [f64; COORDINATES] {
        let system = &self.model.system;
        let (q, v) = (&self.y[system.coordinates(body)], &self.y[system.velocities(body)]);
        let asked = &self.now.at[body].coordinates;
        let mut found = [0.0; COORDINATES];
        match self.model.track.line() {
            None => found.copy_from_slice(q),
            Some(line) => {
                let motion = system.bodies[body].motion(q, v);
                let station = Station::new(line, &motion.position, &motion.velocity, asked[0]);
                found = on_track::relative(&motion, &station).coordinates;
            }
        }
        if body < self.standing.wheelsets {
            // A body of revolution has no pitch that matters.
            found[PITCH] = asked[PITCH];
        }
        found
    }

    /// Acceleration of a body that is not the pattern's, along the track frame's axes.
    fn off_the_pattern(&self, body: usize) -> [f64; COORDINATES] {
        let [turning, slower] = self.rates();
        let at = self.model.system.velocities(body);
        let (v, a) = (&self.y[at.clone()], &self.dy[at]);
        let wanted = [slower * v[0] - turning * v[1], slower * v[1] + turning * v[0]];
        let linear = Vector3::new(a[0] - wanted[0], a[1] - wanted[1], a[2] - slower * v[2]);
        let along = self.components(body, &linear);
        let off = [along.x, along.y, along.z, a[3] - slower * v[3], a[4] - slower * v[4], a[5] - slower * v[5]];
        let mut rest = self.accelerations[body];
        rest.iter_mut().zip(off).for_each(|(rest, off)| *rest = (off - *rest) / UNIT);
        rest
    }

    /// W [rad/s] as it makes centripetal accelerations, and the rate of all speeds relative to themselves, 1/s.
    fn rates(&self) -> [f64; 2] {
        let share = if self.constrained { 1.0 } else { self.pattern.centripetal };
        [share * self.now.travel * self.curvature, self.now.slowing / self.pattern.speed]
    }

    fn components(&self, body: usize, vector: &Vector3<f64>) -> Vector3<f64> {
        self.axes(body).tr_mul(vector)
    }

    /// Of the track frame beside a body.
    pub fn axes(&self, body: usize) -> Matrix3<f64> {
        self.model.track.line().map_or(Matrix3::identity(), |line| line.frame(self.now.at[body].coordinates[0]).axes)
    }

    /// Differences of the equations for all unknowns, as many at once as share no row; `rest` is that here. One-sided ones serve
    /// a step, central ones show what holds a body.
    pub fn differences(&mut self, rest: &[f64], central: bool) -> Result<Vec<Entry>, EvaluationError> {
        let mut of_body: Vec<Vec<usize>> = vec![Vec::new(); self.now.at.len()];
        let mut entries = Vec::new();
        for (column, unknown) in self.unknowns.iter().enumerate() {
            match unknown {
                Unknown::Coordinate { body, .. } | Unknown::Spin { body, .. } => of_body[*body].push(column),
                Unknown::Slowing => entries.extend(self.slowing_column().map(|(row, slope)| (row, column, slope))),
            }
        }
        let here = self.now.clone();
        let count = COORDINATES * self.now.at.len();
        for colour in 0..self.couplings.colours.len() {
            let clusters = self.couplings.colours[colour].clone();
            let columns: Vec<Vec<usize>> = clusters
                .iter()
                .map(|cluster| self.couplings.clusters[*cluster].iter().flat_map(|body| of_body[*body].iter().copied()).collect())
                .collect();
            // Wheels that stay where they are press on their rails as before.
            let wheels_stay =
                clusters.iter().flat_map(|cluster| &self.couplings.clusters[*cluster]).all(|body| *body >= self.standing.wheelsets);
            self.workspace.reuse_patches(wheels_stay && !self.constrained && !self.model.gives_way());
            for turn in 0..columns.iter().map(Vec::len).max().unwrap_or(0) {
                let moved: Vec<(usize, usize)> =
                    clusters.iter().zip(&columns).filter_map(|(cluster, columns)| Some((*cluster, *columns.get(turn)?))).collect();
                let mut at = |sign: f64| {
                    for (_, column) in &moved {
                        let unknown = self.unknowns[*column];
                        self.change(unknown, sign * step(unknown));
                    }
                    let found = self.rest(false, false);
                    self.now.clone_from(&here);
                    found
                };
                let (ahead, behind) = (at(1.0)?, if central { Some(at(-1.0)?) } else { None });
                let (behind, width) = behind.as_ref().map_or((rest, 1.0), |behind| (behind.as_slice(), 2.0));
                for (cluster, column) in moved {
                    let scale = 1.0 / (width * step(self.unknowns[column]));
                    for body in self.couplings.reach[cluster].iter().flat_map(|near| &self.couplings.clusters[*near]) {
                        let first = COORDINATES * body..COORDINATES * (body + 1);
                        let second = first.start + count..first.end + count;
                        let rows = first.chain(if self.constrained { second } else { 0..0 });
                        let slopes = rows.map(|row| (row, column, scale * (ahead[row] - behind[row])));
                        entries.extend(slopes.filter(|entry| entry.2 != 0.0));
                    }
                }
            }
        }
        self.workspace.reuse_patches(false);
        Ok(entries)
    }

    /// How the equations change with the common acceleration.
    fn slowing_column(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        (0..self.now.at.len()).flat_map(|body| {
            let v = &self.y[self.model.system.velocities(body)];
            let along = self.components(body, &Vector3::new(v[0], v[1], v[2]));
            let slopes = [along.x, along.y, along.z, v[3], v[4], v[5]].map(|speed| -speed / self.pattern.speed);
            (0..).zip(slopes).map(move |(i, slope)| (COORDINATES * body + i, slope)).filter(|entry| entry.1 != 0.0)
        })
    }

    /// Does every contact that is a constraint press?
    pub fn presses(&self) -> bool {
        self.model.due(f64::NEG_INFINITY, &self.now.memory).is_none()
    }

    /// Mean vertical force of each wheelset's wheels, N.
    pub fn wheel_loads(&self) -> Vec<f64> {
        let vertical = |wheelset, side| self.workspace.reports(contact_index(wheelset, side)).map(|report| report.force.z).sum::<f64>();
        (0..self.model.wheelsets.len()).map(|wheelset| 0.5 * Side::BOTH.map(|side| vertical(wheelset, side)).iter().sum::<f64>()).collect()
    }

    /// The state in the track frame, with all speeds scaled; contacts are kept as they are, if they are not told how to begin.
    pub fn found(mut self, scale: f64, wheel_loads: Vec<f64>, contacts: Option<Contacts>) -> SteadyState {
        let system = &self.model.system;
        for (body, at) in self.now.at.iter().enumerate() {
            self.y[system.coordinates(body)].copy_from_slice(&at.coordinates);
            self.y[system.velocities(body)].copy_from_slice(&at.velocities.map(|velocity| scale * velocity));
        }
        self.twists.slow_down(&self.workspace.system, scale, &mut self.y);
        self.y.truncate(system.dimension());
        let Configuration { slowing, memory, .. } = self.now;
        let carried = |body: usize| system.supported.iter().filter(|own| own.body == body).map(|own| own.mass).sum::<f64>();
        let masses = system.bodies.iter().enumerate().map(|(body, data)| data.mass + carried(body));
        let pulls = masses.zip(&self.workspace.system.wrenches).map(|(mass, wrench)| mass * slowing - wrench.force.x).collect();
        let contacts = contacts.unwrap_or(Contacts::Kept(memory));
        SteadyState { y: self.y, wheel_loads, acceleration: slowing, pulls, contacts, rubbed_in: self.friction.share() }
    }
}

/// How far an unknown is moved for a difference.
fn step(unknown: Unknown) -> f64 {
    match unknown {
        Unknown::Coordinate { step, .. } => step,
        Unknown::Spin { .. } => 1e-7,
        Unknown::Slowing => 0.0,
    }
}
