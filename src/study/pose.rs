//! One pose of a wheelset with all that the scene's laws of elastic contact say of it: places, forces, patches, creepages.
//!
//! The wheelset stands as rigid (`contact_geometry`), at a roll that is found or given; then it is lowered: each wheel until its normal forces carry a
//! vertical load, or both by a stated approach, or to a stated height. It rolls freely, at that pitch rate at which its creep forces turn it neither
//! faster nor slower, unless pitch rate or creepages are given. A constraint formulation (ACCF, ECCF) is looked at with its elastic laws.

use super::contact_geometry::{Attitude, NoStand, Start, WheelsetOnTrack};
use crate::contact::creep::RollingContact;
use crate::contact::creep::kalker::{Coefficients, LinearTheory};
use crate::contact::creepage::{Creepage, in_rolling_direction};
use crate::formulation::one_wheel::PlaceOnWheel;
use crate::formulation::{self, AssemblyError, ContactFailure, Model};
use crate::geometry::Side;
use crate::math::bracket::root;
use crate::mbs::body::BodyMotion;
use crate::scene::assemble;
use crate::scene::spec::Scene;
use nalgebra::Vector3;

/// What holds the wheelset up or presses it down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Height {
    /// Vertical load of each wheel, of its normal forces, N.
    Load(f64),
    /// Both wheels come nearer than they stand as rigid, m.
    Approach(f64),
    /// Of the wheelset's centre in the track frame, m.
    Stated(f64),
}

/// What is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Question {
    /// Lateral shift, m, and yaw, rad.
    pub y: f64,
    pub yaw: f64,
    /// rad; `None`: that at which both wheels touch as rigid.
    pub roll: Option<f64>,
    pub height: Height,
    /// Place along the track whose deviations count, m.
    pub station: Option<f64>,
    /// Travelling speed, m/s, not zero.
    pub speed: f64,
    /// rad/s; `None`: it rolls freely.
    pub pitch_rate: Option<f64>,
    /// Of every place; `None`: those of the motion.
    pub creepage: Option<Creepage>,
}

/// Why there is no answer.
#[derive(Clone, Debug, thiserror::Error)]
pub enum NoPose {
    #[error(transparent)]
    Stand(#[from] NoStand),
    #[error(transparent)]
    Model(#[from] AssemblyError),
    #[error("{} wheel: {cause}", side.name())]
    Contact { side: Side, cause: ContactFailure },
}

/// A place of contact; forces on the wheel.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub found: PlaceOnWheel,
    /// Radius of the wheel there, m, and contact angle, rad, positive where the rail pushes toward the track's centre.
    pub rolling_radius: f64,
    pub angle: f64,
    /// Of the patch; `None` where nothing is pressed.
    pub kalker: Option<Coefficients>,
    /// mu at the place.
    pub friction: f64,
}

/// One wheel.
#[derive(Clone, Debug)]
pub struct WheelInPose {
    pub side: Side,
    /// By how much it is nearer to its rail than it stands as rigid, m.
    pub approach: f64,
    /// Of the wheelset's centre, for this wheel, m.
    pub height: f64,
    pub places: Vec<Place>,
    /// Sum of all forces on the wheel in the track frame, N.
    pub force: Vector3<f64>,
    /// Does the top of its flange stand on the rail? It has derailed then.
    pub on_top: bool,
}

/// Both wheels.
#[derive(Clone, Debug)]
pub struct Answer {
    pub roll: f64,
    /// rad/s; `None` where creepages are given.
    pub pitch_rate: Option<f64>,
    pub wheels: [WheelInPose; 2],
}

/// The wheelset and its laws.
struct Laid<'a> {
    question: &'a Question,
    wheelset: WheelsetOnTrack,
    model: Model,
    roll: f64,
}

/// Accuracy of an approach under a load, m, and of the free pitch rate, in parts of it.
const SETTLED: f64 = 1e-13;
const SETTLED_RATE: f64 = 1e-13;
/// Part of its flange's height above which a wheel stands on the flange's top.
const NEAR_TOP: f64 = 0.9;
/// First guess of an approach, m, and first change of the pitch rate by which the free one is bracketed.
const GUESS: f64 = 2e-5;
const STEP: f64 = 1e-4;
const DOUBLINGS: usize = 12;

/// Evaluates one pose.
///
/// # Errors
/// [`NoPose`].
pub fn pose(scene: &Scene, question: &Question) -> Result<Answer, NoPose> {
    let attitude = Attitude { yaw: question.yaw, level: question.roll.is_some(), ..Attitude::default() };
    let wheelset = WheelsetOnTrack::new(scene, attitude, question.station);
    let start = Start { roll: question.roll.unwrap_or(0.0), ..wheelset.start() };
    let stand = wheelset.stand(question.y, start)?;
    let mut elastic = scene.clone();
    elastic.contact.formulation = formulation::algebraic();
    elastic.contact.transient = None;
    let mut model = assemble::model(&elastic)?;
    model.lay(wheelset.track.clone());
    model.wheelsets[0].imposed_speed = Some(question.speed);
    let laid = Laid { question, wheelset, model, roll: stand.roll };
    let height = |side: Side| -> Result<f64, NoPose> {
        let rigid = stand.height[side.index()];
        match question.height {
            Height::Load(load) => Ok(rigid - laid.approach_under(side, rigid, load)?),
            Height::Approach(approach) => Ok(rigid - approach),
            Height::Stated(height) => Ok(height),
        }
    };
    let heights = [height(Side::Left)?, height(Side::Right)?];
    let mean = 0.5 * (stand.contacts[0].rolling_radius + stand.contacts[1].rolling_radius);
    let rate = match question.pitch_rate {
        Some(rate) => rate,
        None => laid.free_rate(heights, question.speed / mean)?,
    };
    let wheel = |side: Side| -> Result<WheelInPose, NoPose> {
        let height = heights[side.index()];
        let places = laid.places(side, height, rate, 1.0)?;
        let places: Vec<Place> = places.into_iter().map(|found| laid.place(side, (height, rate), found)).collect();
        let force = places.iter().map(|place| place.found.report.force).sum();
        let on_top = places.iter().any(|place| laid.is_on_top(side, place));
        Ok(WheelInPose { side, approach: stand.height[side.index()] - height, height, places, force, on_top })
    };
    let wheels = [wheel(Side::Left)?, wheel(Side::Right)?];
    Ok(Answer { roll: stand.roll, pitch_rate: question.creepage.is_none().then_some(rate), wheels })
}

impl Laid<'_> {
    fn motion(&self, height: f64, rate: f64) -> BodyMotion {
        let Question { y, yaw, speed, .. } = *self.question;
        BodyMotion::new(&[self.wheelset.station, y, height, yaw, self.roll, 0.0], &[speed, 0.0, 0.0, 0.0, 0.0, rate])
    }

    /// Is the wheel pressed near the top of its flange there?
    fn is_on_top(&self, side: Side, place: &Place) -> bool {
        let (profile, tip) = (&self.wheelset.wheels[side.index()].profile, self.model.flange_tip(side.index()));
        let (tread, pressed) = (profile.at(0.0).value, place.found.report.normal_force > 0.0);
        pressed && tip.is_some_and(|tip| place.rolling_radius - tread > NEAR_TOP * (profile.at(tip).value - tread))
    }

    fn places(&self, side: Side, height: f64, rate: f64, friction: f64) -> Result<Vec<PlaceOnWheel>, NoPose> {
        let found = self.model.places_on_wheel(0, side, &self.motion(height, rate), friction);
        found.map_err(|cause| NoPose::Contact { side, cause })
    }

    /// How much nearer than `rigid` the wheel's normal forces carry the load, m.
    fn approach_under(&self, side: Side, rigid: f64, load: f64) -> Result<f64, NoPose> {
        let less = |approach: f64| -> Result<f64, NoPose> {
            let places = self.places(side, rigid - approach, 0.0, 0.0)?;
            Ok(places.iter().map(|place| place.report.force.z).sum::<f64>() - load)
        };
        let (mut low, mut high) = ((0.0, -load), (GUESS, less(GUESS)?));
        while high.1 < 0.0 {
            (low, high) = (high, (2.0 * high.0, less(2.0 * high.0)?));
        }
        // Between two approaches that can be evaluated nothing fails; if it does, the pose itself says so.
        Ok(root(low, high, SETTLED, |approach| less(approach).unwrap_or(f64::NAN)))
    }

    /// The pitch rate at which the creep forces have no moment about the axle, rad/s: it falls with the rate.
    fn free_rate(&self, heights: [f64; 2], start: f64) -> Result<f64, NoPose> {
        if self.question.creepage.is_some() {
            return Ok(start);
        }
        let turning = |rate: f64| -> Result<f64, NoPose> {
            let mut moment = 0.0;
            for side in Side::BOTH {
                let height = heights[side.index()];
                let motion = self.motion(height, rate);
                for PlaceOnWheel { report, .. } in self.places(side, height, rate, 1.0)? {
                    let about =
                        (report.wheel_point - motion.position).cross(&report.force) + report.axes.normal * report.creep_force.spin_moment;
                    moment += about.dot(&motion.axle());
                }
            }
            Ok(moment)
        };
        let here = (start, turning(start)?);
        if here.1 == 0.0 {
            return Ok(start);
        }
        let (mut near, mut step) = (here, STEP * start.abs() * here.1.signum());
        for _ in 0..DOUBLINGS {
            let far = (near.0 + step, turning(near.0 + step)?);
            if far.1 * here.1 <= 0.0 {
                return Ok(root(near, far, SETTLED_RATE * start.abs(), |rate| turning(rate).unwrap_or(f64::NAN)));
            }
            (near, step) = (far, 2.0 * step);
        }
        // Nothing drives it (no friction, no load): as its treads roll.
        Ok(start)
    }

    /// A place with what is made of it; given creepages take the place of those of the motion.
    fn place(&self, side: Side, (height, rate): (f64, f64), mut found: PlaceOnWheel) -> Place {
        let laws = &self.model.laws;
        let friction = self.model.friction_at(side, &self.motion(height, rate), &found.report);
        let report = &mut found.report;
        let pressed = report.normal_force > 0.0;
        if let (Some(creepage), true) = (self.question.creepage, pressed) {
            let speed = self.question.speed;
            let contact = RollingContact { patch: report.patch, normal_force: report.normal_force, friction, creepage, speed: speed.abs() };
            let old = report.axes.e1 * report.creep_force.longitudinal + report.axes.e2 * report.creep_force.lateral;
            report.creepage = creepage;
            report.creep_force =
                in_rolling_direction(speed, creepage, |creepage| laws.creep.force(&RollingContact { creepage, ..contact }));
            report.force += report.axes.e1 * report.creep_force.longitudinal + report.axes.e2 * report.creep_force.lateral - old;
        }
        let normal = report.axes.normal;
        Place {
            rolling_radius: report.profiles[0].value,
            angle: (-side.sign() * normal.y).atan2(normal.z),
            kalker: pressed.then(|| LinearTheory::new(laws.material).coefficients(report.patch)),
            friction,
            found,
        }
    }
}
