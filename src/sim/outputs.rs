//! The one table of outputs: FMU variables, CSV columns and plot labels all come from it.

use super::Snapshot;
use crate::formulation::{ContactReport, Model};
use crate::geometry::Side;
use crate::mbs::body::COORDINATES;

/// Units that outputs, inputs and parameters carry (names as in modelDescription.xml).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    One,
    /// Metres of a displacement (shown in mm).
    Metre,
    /// Metres along the track.
    Distance,
    Radian,
    Second,
    MetrePerSecond,
    /// Metres per second of travel (shown in km/h).
    TravelSpeed,
    RadianPerSecond,
    MetrePerSecond2,
    RadianPerSecond2,
    Newton,
    NewtonMetre,
    PerMetre,
    Kilogram,
    KilogramMetre2,
    NewtonPerMetre,
    NewtonSecondPerMetre,
    NewtonSecondPerMetre2,
    Pascal,
}

impl Unit {
    /// The type definition in modelDescription.xml that goes with the unit.
    pub fn type_name(self) -> &'static str {
        match self {
            Unit::One => "Ratio",
            Unit::Metre => "Displacement",
            Unit::Distance => "Distance",
            Unit::Radian => "Angle",
            Unit::Second => "Time",
            Unit::MetrePerSecond => "Velocity",
            Unit::TravelSpeed => "TravellingSpeed",
            Unit::RadianPerSecond => "AngularVelocity",
            Unit::MetrePerSecond2 => "Acceleration",
            Unit::RadianPerSecond2 => "AngularAcceleration",
            Unit::Newton => "Force",
            Unit::NewtonMetre => "Torque",
            Unit::PerMetre => "SpinCreepage",
            Unit::Kilogram => "Mass",
            Unit::KilogramMetre2 => "Inertia",
            Unit::NewtonPerMetre => "Stiffness",
            Unit::NewtonSecondPerMetre => "Damping",
            Unit::NewtonSecondPerMetre2 => "PenetrationDamping",
            Unit::Pascal => "Pressure",
        }
    }

    /// The unit's name in files.
    pub fn name(self) -> &'static str {
        match self {
            Unit::One => "1",
            Unit::Metre | Unit::Distance => "m",
            Unit::Radian => "rad",
            Unit::Second => "s",
            Unit::MetrePerSecond | Unit::TravelSpeed => "m/s",
            Unit::RadianPerSecond => "rad/s",
            Unit::MetrePerSecond2 => "m/s2",
            Unit::RadianPerSecond2 => "rad/s2",
            Unit::Newton => "N",
            Unit::NewtonMetre => "N.m",
            Unit::PerMetre => "1/m",
            Unit::Kilogram => "kg",
            Unit::KilogramMetre2 => "kg.m2",
            Unit::NewtonPerMetre => "N/m",
            Unit::NewtonSecondPerMetre => "N.s/m",
            Unit::NewtonSecondPerMetre2 => "N.s/m2",
            Unit::Pascal => "Pa",
        }
    }
}

/// Which inputs an output depends on at the same instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feedthrough {
    /// A coordinate or velocity, or computed from those alone.
    None,
    /// The friction factor of one wheel.
    Friction(Side),
    /// Both friction factors.
    BothFrictions,
    /// Every input of the wheelset.
    All,
}

type Read = Box<dyn Fn(&Snapshot) -> f64 + Send + Sync>;

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
    pub feedthrough: Feedthrough,
    read: Read,
}

impl Output {
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
        feedthrough: Feedthrough,
        text: &str,
        read: impl Fn(&Snapshot) -> f64 + Send + Sync + 'static,
    ) {
        if self.groups.contains(&group) {
            self.outputs.push(Output {
                reference: self.base + id,
                name: format!("{}.{name}", self.prefix),
                group,
                unit,
                description: text.into(),
                feedthrough,
                read: Box::new(read),
            });
        }
    }
}

/// All outputs of a model, restricted to `groups`.
pub fn outputs(model: &Model, groups: &[&'static str]) -> Vec<Output> {
    let mut outputs = Vec::new();
    let bodies = model.system.bodies.len();
    for (index, wheelset) in model.wheelsets.iter().enumerate() {
        let mut collector = Collector { prefix: wheelset.name.clone(), base: (index as u32 + 1) * 1000, groups, outputs: &mut outputs };
        motion(&mut collector, wheelset.body, bodies);
        if let Some(drive) = model.system.drives.iter().position(|drive| drive.body == wheelset.body) {
            let text = "force of the driving constraint, forward positive: what a locomotive must supply to keep the imposed speed";
            collector.add(30, "drivingForce", "motion", Unit::Newton, Feedthrough::BothFrictions, text, move |s| {
                s.workspace.system.drive_forces[drive]
            });
        }
        for side in Side::BOTH {
            wheel(&mut collector, 2 * index + usize::from(side == Side::Right), side);
        }
        for (element, force) in model.system.forces.iter().enumerate().filter(|(_, force)| force.is_axial()) {
            let id = 300 + element as u32;
            let text = "force of the suspension element on the wheelset along its track axis (X forward, Y left positive)";
            let elements = element_force(model, element);
            collector.add(id, &format!("{}Force", force.name()), "suspension", Unit::Newton, Feedthrough::None, text, elements);
        }
    }
    outputs
}

/// Reads one element's force: the element's constants are copied, so that outputs do not borrow the model.
fn element_force(model: &Model, element: usize) -> impl Fn(&Snapshot) -> f64 + Send + Sync + 'static {
    let force = model.system.forces[element].clone_box();
    move |s| force.scalar_force(&s.workspace.system.motions).unwrap_or(0.0)
}

fn motion(c: &mut Collector, body: usize, bodies: usize) {
    use Feedthrough::{All, BothFrictions, None};
    let q = body * COORDINATES;
    let v = (bodies + body) * COORDINATES;
    let y = |at: usize| move |s: &Snapshot| s.y[at];
    let dy = |at: usize| move |s: &Snapshot| s.dy[at];
    let g = "motion";
    c.add(10, "distance", g, Unit::Distance, None, "distance of the centre along the track", y(q));
    c.add(11, "y", g, Unit::Metre, None, "lateral displacement of the centre, left positive", y(q + 1));
    c.add(12, "z", g, Unit::Metre, None, "height of the centre over the nominal contact height", y(q + 2));
    c.add(13, "roll", g, Unit::Radian, None, "roll angle, left side up positive", y(q + 4));
    c.add(14, "yaw", g, Unit::Radian, None, "yaw angle, nose left positive", y(q + 3));
    c.add(15, "vx", g, Unit::TravelSpeed, None, "speed of the centre along the track", y(v));
    c.add(16, "vy", g, Unit::MetrePerSecond, None, "lateral speed of the centre, left positive", y(v + 1));
    c.add(17, "vz", g, Unit::MetrePerSecond, None, "vertical speed of the centre, up positive", y(v + 2));
    c.add(18, "rollRate", g, Unit::RadianPerSecond, None, "time derivative of the roll angle", y(v + 4));
    c.add(19, "yawRate", g, Unit::RadianPerSecond, None, "time derivative of the yaw angle", y(v + 3));
    c.add(20, "pitchRate", g, Unit::RadianPerSecond, None, "time derivative of the pitch angle, rolling forward positive", y(v + 5));
    c.add(21, "ax", g, Unit::MetrePerSecond2, None, "acceleration of the centre along the track (zero under an imposed speed)", dy(v));
    c.add(22, "ay", g, Unit::MetrePerSecond2, All, "lateral acceleration of the centre, left positive", dy(v + 1));
    c.add(23, "az", g, Unit::MetrePerSecond2, All, "vertical acceleration of the centre, up positive", dy(v + 2));
    c.add(24, "rollAcceleration", g, Unit::RadianPerSecond2, BothFrictions, "second time derivative of the roll angle", dy(v + 4));
    c.add(25, "yawAcceleration", g, Unit::RadianPerSecond2, BothFrictions, "second time derivative of the yaw angle", dy(v + 3));
    c.add(26, "pitchAcceleration", g, Unit::RadianPerSecond2, All, "second time derivative of the pitch angle", dy(v + 5));
}

/// Wheel unloading below this force [N] makes quotients meaningless; they are reported as zero.
const UNLOADED: f64 = 1.0;

fn wheel(c: &mut Collector, contact: usize, side: Side) {
    let friction = Feedthrough::Friction(side);
    let none = Feedthrough::None;
    let prefix = c.prefix.clone();
    let outward = side.sign();
    c.prefix = format!("{prefix}.{}", side.name());
    let base = c.base;
    c.base = base + if side == Side::Left { 100 } else { 200 };
    let of = |read: fn(&ContactReport) -> f64| move |s: &Snapshot| read(&s.workspace.contacts[contact]);

    let g = "wheels";
    c.add(
        0,
        "verticalForce",
        g,
        Unit::Newton,
        friction,
        "Q: vertical force of the rail on the wheel in the track frame, up positive",
        of(|k| k.force.z),
    );
    c.add(1, "lateralForce", g, Unit::Newton, friction, "Y: lateral force of the rail on the wheel in the track frame, left positive on both sides (EN 14363 guiding force: left -Y, right +Y)", of(|k| k.force.y));
    c.add(
        2,
        "longitudinalForce",
        g,
        Unit::Newton,
        friction,
        "longitudinal force of the rail on the wheel in the track frame, forward positive",
        of(|k| k.force.x),
    );
    c.add(3, "normalForce", g, Unit::Newton, none, "sum of the normal forces of the wheel's contacts", of(|k| k.normal_force));
    let text = "guiding force of the wheel on the rail, outward positive, over Q: positive when a flange climbs; 0 below Q = 1 N";
    c.add(4, "derailmentQuotient", g, Unit::One, friction, text, move |s| {
        let force = s.workspace.contacts[contact].force;
        if force.z > UNLOADED { -outward * force.y / force.z } else { 0.0 }
    });
    let text = "T-gamma without spin: |Fx xi_x| + |Fy xi_y|, summed over the wheel's contacts (energy per distance, J/m)";
    c.add(
        5,
        "wearNumber",
        g,
        Unit::Newton,
        friction,
        text,
        of(|k| (k.creep_force.longitudinal * k.creepage.longitudinal).abs() + (k.creep_force.lateral * k.creepage.lateral).abs()),
    );

    c.prefix = format!("{prefix}.{}.contact[1]", side.name());
    c.base += 20;
    let g = "contacts";
    c.add(0, "normalForce", g, Unit::Newton, none, "normal force", of(|k| k.normal_force));
    c.add(
        1,
        "penetration",
        g,
        Unit::Metre,
        none,
        "penetration of the undeformed surfaces along the normal, negative when they are apart",
        of(|k| k.penetration),
    );
    c.add(
        2,
        "longitudinalCreepage",
        g,
        Unit::One,
        none,
        "longitudinal creepage, positive when the wheel slips forward (braking); 0 without contact",
        of(|k| k.creepage.longitudinal),
    );
    c.add(
        3,
        "lateralCreepage",
        g,
        Unit::One,
        none,
        "lateral creepage, positive when the wheel slips to the left; 0 without contact",
        of(|k| k.creepage.lateral),
    );
    c.add(
        4,
        "spinCreepage",
        g,
        Unit::PerMetre,
        none,
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
    c.add(8, "semiAxisA", g, Unit::Metre, none, "semi-axis of the contact patch along e1 (rolling direction)", of(|k| k.patch.a));
    c.add(9, "semiAxisB", g, Unit::Metre, none, "semi-axis of the contact patch along e2", of(|k| k.patch.b));
    c.add(
        10,
        "wheelCoordinate",
        g,
        Unit::Metre,
        none,
        "u: contact on the wheel profile from the tread circle, outward positive",
        of(|k| k.parameters.wheel),
    );
    c.add(11, "railCoordinate", g, Unit::Metre, none, "eta: contact on the rail profile, outward positive", of(|k| k.parameters.rail));
    c.add(12, "angle", g, Unit::Radian, none, "contact angle: lean of the normal toward the track centre in the cross-section", move |s| {
        let n = s.workspace.contacts[contact].axes.normal;
        (-outward * n.y).atan2(n.z)
    });
    c.add(
        13,
        "wheelAngle",
        g,
        Unit::Radian,
        none,
        "contact on the wheel: angle about the axle ahead of the lowest point",
        of(|k| k.parameters.angle),
    );
    c.add(14, "lead", g, Unit::Metre, none, "contact on the rail: distance ahead of the wheelset's centre", of(|k| k.parameters.lead));
    c.prefix = prefix;
    c.base = base;
}
