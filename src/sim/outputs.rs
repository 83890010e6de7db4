//! The one table of outputs: FMU variables, CSV columns and plot labels all come from it.

use super::Snapshot;
use super::feedthrough::{ACROSS, ALONG, DRIVING, Depends, Feedthrough, STATE, TURNING, Ties, UPWARD, of_wheel};
pub use super::look::Needs;
use crate::formulation::derailment_quotient;
use crate::formulation::sliding_mean::{Averaged, CUT_OFF};
use crate::formulation::{ContactReport, Model, contact_index};
use crate::geometry::Side;
use crate::geometry::track::station::Station;
use crate::mbs::body::COORDINATES;
use crate::mbs::on_track::{OnTrack, accelerations, relative};
use crate::scene::spec::{RAIL_FORCES, SLIDING_MEANS};
use crate::units::Unit;

pub(super) type Read = Box<dyn Fn(&Snapshot) -> f64 + Send + Sync>;

/// One output.
pub struct Output {
    /// Number that stays the same whatever else a scene shows: (wheelset + 1) * 1000 + local number.
    pub reference: u32,
    /// Structured name, e.g. `wheelset.left.normalForce`.
    pub name: String,
    /// Group that `interface.outputs` names.
    pub group: &'static str,
    pub unit: Unit,
    pub description: String,
    /// Inputs that it depends on at the same instant.
    pub feedthrough: Feedthrough,
    /// What must be known of the present state before it can be read.
    pub needs: Needs,
    /// Of what a force element reports: the element's number among the vehicle's, and which of its quantities it is.
    pub quantity: Option<(usize, usize)>,
    read: Read,
}

impl Output {
    pub(super) fn new(
        (reference, name): (u32, String),
        group: &'static str,
        unit: Unit,
        description: &str,
        feedthrough: Feedthrough,
        read: Read,
    ) -> Self {
        Output { reference, name, group, unit, description: description.into(), feedthrough, needs: Needs::Contacts, quantity: None, read }
    }

    /// Reads it in another way.
    pub(super) fn read_by(&mut self, read: Read) {
        self.read = read;
    }

    /// Reads it as another one does.
    pub(super) fn read_as(&mut self, other: Output) {
        self.read = other.read;
    }

    /// The value in a snapshot, SI.
    pub fn value(&self, snapshot: &Snapshot) -> f64 {
        (self.read)(snapshot)
    }
}

impl std::fmt::Debug for Output {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} [{}]", self.name, self.unit.name())
    }
}

/// Collects outputs of one wheelset.
struct Collector<'a> {
    prefix: String,
    base: u32,
    groups: &'a [&'static str],
    model: &'a Model,
    ties: &'a Ties,
    /// The wheelset's body.
    body: usize,
    outputs: &'a mut Vec<Output>,
}

impl Collector<'_> {
    #[allow(clippy::too_many_arguments)]
    fn add(
        &mut self,
        id: u32,
        name: &str,
        group: &'static str,
        unit: Unit,
        depends: Depends,
        text: &str,
        read: impl Fn(&Snapshot) -> f64 + Send + Sync + 'static,
    ) {
        if self.groups.contains(&group) {
            let label = (self.base + id, format!("{}.{name}", self.prefix));
            let feedthrough = Feedthrough::of_wheelset(self.model, self.ties, self.body, depends);
            self.outputs.push(Output::new(label, group, unit, text, feedthrough, Box::new(read)));
        }
    }

    /// The same; it needs positions, velocities and forces of elements alone.
    fn add_of_motion(
        &mut self,
        (id, name): (u32, &str),
        group: &'static str,
        unit: Unit,
        text: &str,
        read: impl Fn(&Snapshot) -> f64 + Send + Sync + 'static,
    ) {
        let before = self.outputs.len();
        self.add(id, name, group, unit, STATE, text, read);
        self.outputs[before..].iter_mut().for_each(|output| output.needs = Needs::Motion);
    }
}

/// What must be known before these outputs can be read; `None` where there are none.
pub fn needs<'a>(outputs: impl IntoIterator<Item = &'a Output>) -> Option<Needs> {
    outputs.into_iter().map(|output| output.needs).max()
}

/// All outputs of a model, restricted to `groups`.
pub fn outputs(model: &Model, groups: &[&'static str]) -> Vec<Output> {
    let mut outputs = Vec::new();
    let bodies = model.system.bodies.len();
    let ties = Ties::of(model);
    for (index, wheelset) in model.wheelsets.iter().enumerate() {
        let mut collector = Collector {
            prefix: wheelset.name.clone(),
            base: (index as u32 + 1) * 1000,
            groups,
            model,
            ties: &ties,
            body: wheelset.body,
            outputs: &mut outputs,
        };
        let drive = model.system.drives.iter().position(|drive| drive.body == wheelset.body);
        let along = match drive {
            None => ALONG,
            Some(_) if model.speed_is_input() => Depends::Imposed,
            Some(_) => STATE,
        };
        motion(&mut collector, wheelset.body, bodies, along);
        if let Some(drive) = drive {
            let text = "force of the driving constraint, forward positive: what a locomotive must supply to keep the imposed speed";
            collector.add(30, "drivingForce", "motion", Unit::Newton, DRIVING, text, move |s| s.workspace.system.drive_forces[drive]);
        }
        for side in Side::BOTH {
            let points = model.points;
            wheel(&mut collector, contact_index(index, side), points, side, wheelset.body);
        }
        means(&mut collector, model, index);
    }
    outputs
}

/// The body's motion relative to a curved track and the track frame beside it; `None` on straight track.
pub(super) fn on_track(s: &Snapshot, body: usize) -> Option<(OnTrack, &Station)> {
    let station = s.workspace.system.stations.get(body)?;
    Some((relative(&s.workspace.system.motions[body], station), station))
}

/// Coordinate or velocity at a place of the state vector.
pub(super) fn in_order(motion: &OnTrack, at: usize, q: usize, v: usize) -> f64 {
    if at < v { motion.coordinates[at - q] } else { motion.velocities[at - v] }
}

fn motion(c: &mut Collector, body: usize, bodies: usize, along: Depends) {
    let q = body * COORDINATES;
    let v = (bodies + body) * COORDINATES;
    let y = |at: usize| move |s: &Snapshot| on_track(s, body).map_or(s.y[at], |(motion, _)| in_order(&motion, at, q, v));
    let dy = |at: usize| {
        move |s: &Snapshot| match s.workspace.system.stations.get(body) {
            None => s.dy[at],
            Some(station) => accelerations(&s.workspace.system.motions[body], station, &s.dy[v..v + COORDINATES])[at - v],
        }
    };
    let g = "motion";
    c.add_of_motion((10, "distance"), g, Unit::Distance, "distance of the centre along the track", y(q));
    c.add_of_motion((11, "y"), g, Unit::Metre, "lateral displacement of the centre, left positive", y(q + 1));
    c.add_of_motion((12, "z"), g, Unit::Distance, "height of the centre over the nominal contact height", y(q + 2));
    c.add_of_motion((13, "roll"), g, Unit::Radian, "roll angle, left side up positive", y(q + 4));
    c.add_of_motion((14, "yaw"), g, Unit::Radian, "yaw angle, nose left positive", y(q + 3));
    c.add_of_motion((15, "vx"), g, Unit::TravelSpeed, "speed of the centre along the track", y(v));
    c.add_of_motion((16, "vy"), g, Unit::MetrePerSecond, "lateral speed of the centre, left positive", y(v + 1));
    c.add_of_motion((17, "vz"), g, Unit::MetrePerSecond, "vertical speed of the centre, up positive", y(v + 2));
    c.add_of_motion((18, "rollRate"), g, Unit::RadianPerSecond, "time derivative of the roll angle", y(v + 4));
    c.add_of_motion((19, "yawRate"), g, Unit::RadianPerSecond, "time derivative of the yaw angle", y(v + 3));
    c.add_of_motion((20, "pitchRate"), g, Unit::RadianPerSecond, "time derivative of the pitch angle, rolling forward positive", y(v + 5));
    c.add(
        21,
        "ax",
        g,
        Unit::MetrePerSecond2,
        along,
        "acceleration of the centre along the track (where an imposed speed acts, that of the speed: 0 where it stays)",
        dy(v),
    );
    c.add(
        22,
        "ay",
        g,
        Unit::MetrePerSecond2,
        ACROSS,
        "lateral acceleration of the centre, left positive; in a curve with the centripetal part",
        dy(v + 1),
    );
    c.add(
        23,
        "az",
        g,
        Unit::MetrePerSecond2,
        UPWARD,
        "vertical acceleration of the centre, up positive; in a canted curve with the centripetal part",
        dy(v + 2),
    );
    c.add(24, "rollAcceleration", g, Unit::RadianPerSecond2, TURNING, "second time derivative of the roll angle", dy(v + 4));
    c.add(25, "yawAcceleration", g, Unit::RadianPerSecond2, TURNING, "second time derivative of the yaw angle", dy(v + 3));
    c.add(26, "pitchAcceleration", g, Unit::RadianPerSecond2, TURNING, "second time derivative of the pitch angle", dy(v + 5));
}

/// Of an output of a wheelset's motion by its number among the wheelset's: the number of the output whose derivative by time it is. On track that is not `straight` the speed is
/// that of the centre, not of its place along the centre line.
pub fn integral(number: u32, straight: bool) -> Option<u32> {
    match number {
        15 if !straight => None,
        15..=19 => Some(number - 5),
        // Not `ax`, `ay` and `az`: in a curve they hold the centripetal part, which is no change of a speed along or across the track.
        24..=26 => Some(number - 6),
        _ => None,
    }
}

/// The other way round: the number of the output that is its derivative by time.
pub fn rate(number: u32, straight: bool) -> Option<u32> {
    (15..=26).find(|other| integral(*other, straight) == Some(number))
}

/// Means over the last stretch of travel.
fn means(c: &mut Collector, model: &Model, wheelset: usize) {
    let Some(mean) = model.means else { return };
    let states = model.mean_states(wheelset);
    let lines = [
        (106, 110, "left.derailmentQuotientMean", Unit::One, "derailmentQuotient of the left wheel"),
        (206, 210, "right.derailmentQuotientMean", Unit::One, "derailmentQuotient of the right wheel"),
        (32, 33, "trackShiftingForceMean", Unit::Newton, "sum of Y (lateral force of both wheels on the track, left positive)"),
    ];
    for (quantity, (filtered, unfiltered, name, unit, text)) in lines.into_iter().enumerate() {
        let over = format!("sliding mean over {} m (over what was travelled until then; before that the present value)", mean.window);
        let kinds = [
            (
                filtered,
                "",
                format!("{text}, low-pass filtered ({CUT_OFF} Hz, Butterworth of fourth order), then {over}: as EN 14363 evaluates it"),
                Averaged::Filtered,
            ),
            (unfiltered, "Unfiltered", format!("{text}, {over}, without the low-pass filter of EN 14363"), Averaged::Unfiltered),
        ];
        for (id, suffix, text, averaged) in kinds {
            let states = states.clone();
            let read = move |s: &Snapshot| mean.mean(quantity, averaged, s.time, &s.y[states.clone()], &s.memory().means[wheelset]);
            c.add_of_motion((id, &format!("{name}{suffix}")), SLIDING_MEANS, unit, &text, read);
        }
    }
}

fn wheel(c: &mut Collector, contact: usize, points: usize, side: Side, body: usize) {
    let on = of_wheel(side);
    let friction = on.friction;
    let prefix = c.prefix.clone();
    c.prefix = format!("{prefix}.{}", side.name());
    let base = c.base;
    c.base = base + if side == Side::Left { 100 } else { 200 };
    // Sum over the wheel's contacts.
    let of = |read: fn(&ContactReport) -> f64| move |s: &Snapshot| s.workspace.reports(contact).map(read).sum::<f64>();

    // The sum of their forces in the track frame.
    let total = move |s: &Snapshot| s.workspace.wheel_force(contact, body);

    let g = "wheels";
    c.add(
        0,
        "verticalForce",
        g,
        Unit::Newton,
        friction,
        "Q: vertical force of the rail on the wheel in the track frame, up positive",
        move |s| total(s).z,
    );
    c.add(1, "lateralForce", g, Unit::Newton, friction, "Y: lateral force of the rail on the wheel in the track frame, left positive on both sides (EN 14363 guiding force: left -Y, right +Y)", move |s| total(s).y);
    c.add(
        2,
        "longitudinalForce",
        g,
        Unit::Newton,
        friction,
        "longitudinal force of the rail on the wheel in the track frame, forward positive",
        move |s| total(s).x,
    );
    c.add(3, "normalForce", g, Unit::Newton, on.pressing, "sum of the normal forces of the wheel's contacts", of(|k| k.normal_force));
    let text = "guiding force of the wheel on the rail, outward positive, over Q: positive when a flange climbs; 0 below Q = 1 N";
    c.add(4, "derailmentQuotient", g, Unit::One, friction, text, move |s| derailment_quotient(side, &total(s)));
    let text = "T-gamma without spin: |Fx xi_x| + |Fy xi_y|, summed over the wheel's contacts, J/m; frictionWork has spin's part";
    c.add(
        5,
        "wearNumber",
        g,
        Unit::Newton,
        friction,
        text,
        of(|k| (k.creep_force.longitudinal * k.creepage.longitudinal).abs() + (k.creep_force.lateral * k.creepage.lateral).abs()),
    );

    let text = "work of friction per distance travelled, with spin: -(Fx xi_x + Fy xi_y + Mz phi), summed over the wheel's contacts, J/m (laws without a spin moment: Mz = 0)";
    c.add(9, "frictionWork", g, Unit::Newton, friction, text, of(friction_work));

    let text = "force of the wheel on the rail across the track, left positive as the rail's displacement; EN 14363 guiding force: left +, right -";
    c.add(7, "railLateralForce", RAIL_FORCES, Unit::Newton, friction, text, move |s| -total(s).y);
    let text = "force of the wheel on the rail upward, as the rail's displacement: -Q, negative under load";
    c.add(8, "railVerticalForce", RAIL_FORCES, Unit::Newton, friction, text, move |s| -total(s).z);

    if c.model.gives_way() {
        let first = c.model.rail_states(contact).start;
        let beam = c.model.beam.is_some();
        let deflection =
            |axis: usize| move |s: &Snapshot| if beam && axis == 1 { s.workspace.rail_sunk(contact) } else { s.y[first + axis] };
        let text = "deflection of the rail under the wheel across the track (track.flexibility), left positive; 0 unloaded";
        c.add_of_motion((11, "railLateralDeflection"), g, Unit::Metre, text, deflection(0));
        let text = "deflection of the rail under the wheel (track.flexibility), up positive: -Q over stiffness at rest";
        c.add_of_motion((12, "railVerticalDeflection"), g, Unit::Metre, text, deflection(1));
    }

    for index in 0..points {
        point_of_contact(c, &format!("{prefix}.{}.contact[{}]", side.name(), index + 1), contact, index, side, body);
    }
    c.prefix = prefix;
    c.base = base;
}

/// Work of a contact's friction per distance travelled, J/m: what the tractions take from the rigid slip. In steady rolling all of it becomes heat; a transient
/// contact also stores some of it elastically and gives it back.
fn friction_work(k: &ContactReport) -> f64 {
    let (force, creepage) = (&k.creep_force, &k.creepage);
    -(force.longitudinal * creepage.longitudinal + force.lateral * creepage.lateral + force.spin_moment * creepage.spin)
}

/// Outputs of a wheel's contact number `index` from 0.
fn point_of_contact(c: &mut Collector, name: &str, contact: usize, index: usize, side: Side, body: usize) {
    let on = of_wheel(side);
    let (friction, place) = (on.friction, on.place);
    let of = |read: fn(&ContactReport) -> f64| move |s: &Snapshot| read(s.workspace.report(contact, index));
    let (prefix, base) = (std::mem::replace(&mut c.prefix, name.into()), c.base);
    c.base += 20 * (index as u32 + 1);
    let g = "contacts";
    c.add(0, "normalForce", g, Unit::Newton, on.pressing, "normal force", of(|k| k.normal_force));
    c.add(
        1,
        "penetration",
        g,
        Unit::Metre,
        place,
        "penetration of the undeformed surfaces along the normal, negative when they are apart",
        of(|k| k.penetration),
    );
    c.add(
        2,
        "longitudinalCreepage",
        g,
        Unit::One,
        on.slip,
        "longitudinal creepage, positive when the wheel slips forward (braking); 0 without contact",
        of(|k| k.creepage.longitudinal),
    );
    c.add(
        3,
        "lateralCreepage",
        g,
        Unit::One,
        on.slip,
        "lateral creepage, positive when the wheel slips to the left; 0 without contact",
        of(|k| k.creepage.lateral),
    );
    c.add(
        4,
        "spinCreepage",
        g,
        Unit::PerMetre,
        on.slip,
        "spin creepage about the contact normal (up); 0 without contact",
        of(|k| k.creepage.spin),
    );
    c.add(
        5,
        "creepForceX",
        g,
        Unit::Newton,
        friction,
        "creep force on the wheel along the rail's tangent e1, forward positive",
        of(|k| k.creep_force.longitudinal),
    );
    c.add(
        6,
        "creepForceY",
        g,
        Unit::Newton,
        friction,
        "creep force on the wheel along e2 = n x e1, left positive",
        of(|k| k.creep_force.lateral),
    );
    c.add(
        7,
        "spinMoment",
        g,
        Unit::NewtonMetre,
        friction,
        "spin moment on the wheel about the contact normal",
        of(|k| k.creep_force.spin_moment),
    );
    c.add(8, "semiAxisA", g, Unit::Metre, on.pressing, "semi-axis of the contact patch along e1 (rolling direction)", of(|k| k.patch.a));
    c.add(9, "semiAxisB", g, Unit::Metre, on.pressing, "semi-axis of the contact patch along e2", of(|k| k.patch.b));
    place_of_contact(c, of_wheel(side).place, (contact, index), side.sign(), body);
    c.prefix = prefix;
    c.base = base;
}

/// By how much a wheelset's own axes, which do not follow a grade, lag behind the track's about the axle, rad.
fn leaning(s: &Snapshot, body: usize) -> f64 {
    let system = &s.workspace.system;
    let frame = |station: &Station| {
        let axes = system.motions[body].frame.axes;
        let up = station.frame.axes.column(0).cross(&axes.column(1));
        (-up.dot(&axes.column(0))).atan2(up.dot(&axes.column(2)))
    };
    system.stations.get(body).map_or(0.0, frame)
}

/// Where a contact is on wheel and rail.
fn place_of_contact(c: &mut Collector, place: Depends, (contact, index): (usize, usize), outward: f64, body: usize) {
    let g = "contacts";
    let of = |read: fn(&ContactReport) -> f64| move |s: &Snapshot| read(s.workspace.report(contact, index));
    c.add(
        10,
        "wheelCoordinate",
        g,
        Unit::Metre,
        place,
        "u: contact on the wheel profile from the tread circle, outward positive",
        of(|k| k.parameters.wheel),
    );
    c.add(11, "railCoordinate", g, Unit::Metre, place, "eta: contact on the rail profile, outward positive", of(|k| k.parameters.rail));
    c.add(
        12,
        "angle",
        g,
        Unit::Radian,
        place,
        "contact angle: lean of the normal toward the track centre in the cross-section",
        move |s| {
            let n = s.workspace.in_track(body, s.workspace.report(contact, index).axes.normal);
            (-outward * n.y).atan2(n.z)
        },
    );
    c.add(
        13,
        "wheelAngle",
        g,
        Unit::Radian,
        place,
        "contact on the wheel: angle about the axle ahead of the point nearest to the track's plane",
        move |s| s.workspace.report(contact, index).parameters.angle - leaning(s, body),
    );
    let text = "contact on the rail: distance along the track";
    c.add(14, "railDistance", g, Unit::Distance, place, text, move |s| {
        let system = &s.workspace.system;
        let distance = system.stations.get(body).map_or(s.y[body * COORDINATES], |_| system.motions[body].distance);
        distance + s.workspace.report(contact, index).parameters.lead
    });
}
