//! How the wrench of a wheel whose patch is made of strips changes with the wheelset's motion.
//!
//! *By position*, at the same velocities: differences of all that the wheel carries, its patch pressed anew, over four motions in the wheelset's
//! axes: across, up, roll and yaw. Turning about the axle changes nothing. Where the wheelset goes along with the rail and turns with it,
//! by c = (tau, omega) for each metre, wrench W = (F, M) and velocities turn with the rail, so that at the same velocities
//!
//! ```text
//! dW/dp . c = omega x W - dW/dv . (omega x v)
//! ```
//!
//! which sets the derivative along the wheelset's first axis. *By velocity*: the slopes of the creep law and of damping at each part, places as they
//! are.
//!
//! Everything that differences see is in it: half lengths and strips in contact that change, centres that move, parts that become one. Told by the
//! loads alone (strips in contact and proportions as they were) a wheel with two parts on its flange root lost 20 % of the stiffness that ties its
//! lateral motion to its load, and the flutter of a coach in a curve of 150 m (see [`crate::formulation::flutter`]) was not seen.
//!
//! *Left out:* by velocity, how parts that are partly one with several others share; irregularities' slopes along the track.

use super::super::ContactReport;
use super::super::elastic::patch::{Places, PressedWheel, WheelPatch};
use super::super::elastic::tabled::TabledWheel;
use super::super::loading::{Contact, WheelAt};
use super::super::patch_loads::{Carried, Loaded, location};
use super::contact::{ByMotion, NormalSlopes, Touching, normal_slopes};
use super::{At, Model};
use crate::contact::search::migration::row;
use crate::contact::strips::{Cells, MOST, Part, RailStrips, Scratch, Section};
use crate::mbs::body::{BodyMotion, Wrench};
use crate::mbs::tangent::{Tangent, WrenchTangent};
use nalgebra::{Rotation3, Vector3, Vector6};

/// Differences: translations [m], rotations [rad]. Overlaps are known to 1e-13 m.
const STEP: f64 = 3e-7;
const TURN: f64 = 4e-7;

impl Model {
    /// Adds the patch of a wheel, whose contacts' `reports` are those of the present pose; the first scratch holds, or takes up, its strips in that pose.
    /// `travel` as in [`At`].
    pub(super) fn add_patch<'r>(
        &self,
        wheel: &WheelAt,
        rail: &RailStrips,
        reports: impl Iterator<Item = &'r ContactReport> + Clone,
        travel: Option<Vector3<f64>>,
        (scratch, tried, loaded): (&mut Scratch, &mut Scratch, &mut Loaded),
        tangent: &mut Tangent,
    ) {
        let WheelAt { wheelset, side, motion, .. } = *wheel;
        let body = wheelset.turning[side.index()];
        let seeds = reports.clone().filter(|report| report.normal_force > 0.0).map(ContactReport::near);
        if seeds.clone().next().is_none() {
            return;
        }
        let flanks = reports.map(|report| (report.profiles[1].d1, report.penetration));
        let pair = wheel.pair();
        // Where half-spaces press their places are not those of the strips.
        let (here, beside) = if self.half_spaces.is_some() { (Places::Some, Places::Some) } else { (Places::AsPressed, Places::All) };
        let on = WheelPatch::find(wheel, rail, seeds.clone(), here, flanks.clone(), scratch);
        let Ok(()) = on.load(loaded) else { return };
        let mut change = WrenchTangent::default();
        match &on {
            WheelPatch::Pressed(on) => self.by_velocity(wheel, on, &loaded.shown, travel, &mut change),
            WheelPatch::Tabled(on) => self.tabled_by_velocity(on, &loaded.shown, travel, &mut change),
            WheelPatch::Both(on, table) => {
                self.by_velocity(wheel, on, &loaded.shown, travel, &mut change);
                if let Some((weight, carried)) = loaded.beside() {
                    let mut of_table = WrenchTangent::default();
                    self.tabled_by_velocity(table, carried, travel, &mut of_table);
                    change.by_velocity += (of_table.by_velocity - change.by_velocity) * weight;
                }
            }
        }
        let mut here = Wrench::default();
        loaded.add_to(&mut here, &motion.position);
        let here = stacked(&here);
        let [ahead, across, up] = [0, 1, 2].map(|k| motion.frame.axes.column(k).into_owned());
        let none = Vector3::zeros();
        let mut known = [Vector6::zeros(); 4];
        let ways = [(across, none), (up, none), (none, ahead), (none, up)];
        for (known, (translation, rotation)) in known.iter_mut().zip(&ways) {
            let mut moved = *motion;
            moved.position += translation * STEP;
            moved.frame.axes = Rotation3::new(rotation * TURN) * motion.frame.axes;
            let there = WheelAt { motion: &moved, ..*wheel };
            let on = WheelPatch::find(&there, rail, seeds.clone(), beside, flanks.clone(), &mut *tried);
            // Where a neighbouring pose has no answer the patch counts as stiff as nothing that way.
            let Ok(()) = on.load(loaded) else { continue };
            let mut wrench = Wrench::default();
            loaded.add_to(&mut wrench, &moved.position);
            *known = (stacked(&wrench) - here) / if *rotation == none { STEP } else { TURN };
        }
        let (along, turning) = Section::new(&pair).course();
        let turned = |six: &Vector6<f64>| -> Vector6<f64> {
            let [first, second] = [0, 3].map(|start| turning.cross(&six.fixed_rows::<3>(start).into_owned()));
            stacked(&Wrench { force: first, moment: second })
        };
        let velocities = stacked(&Wrench { force: motion.velocity, moment: motion.rotation });
        let mut first = turned(&here) - change.by_velocity * turned(&velocities);
        for (known, (translation, rotation)) in known.iter().zip(&ways) {
            first -= known * (translation.dot(&along) + rotation.dot(&turning));
            change.by_position += known * Vector6::from(row(translation, rotation)).transpose();
        }
        change.by_position += first / ahead.dot(&along) * Vector6::from(row(&ahead, &none)).transpose();
        if let Some(wrench) = tangent.wrench_mut(body, body) {
            wrench.by_position += change.by_position;
            wrench.by_velocity += change.by_velocity;
        }
    }

    /// Adds what slip and the rate of penetration do, and friction that changes along the rail.
    fn by_velocity(&self, wheel: &WheelAt, on: &PressedWheel, carried: &Carried, travel: Option<Vector3<f64>>, change: &mut WrenchTangent) {
        let count = on.parts.len();
        let independence = if count > 1 { on.parts.divide(0, count - 1).1 } else { 1.0 };
        let mut add = |report: &ContactReport, (first, last): (usize, usize), part: &Part, share: f64, slopes: NormalSlopes| {
            let cells = Cells::Strips(on.parts.share(on.pressed, first, last));
            self.rolling(wheel, report, (cells, part), (share, slopes, first == last), travel, change);
        };
        let reports = carried.reports();
        let mut slopes = [NormalSlopes::default(); MOST];
        for (slopes, report) in slopes.iter_mut().zip(reports) {
            *slopes = normal_slopes(self.laws.damping.as_ref(), report);
        }
        for (k, report) in reports.iter().enumerate().filter(|(_, report)| report.normal_force > 0.0) {
            add(report, (k, k), &on.part(k, k), independence, slopes[k]);
        }
        if independence < 1.0 {
            let (part, motion): (Part, &BodyMotion) = (on.part(0, count - 1), wheel.motion);
            let found = location(&part, motion);
            let mut report = Contact { wheel, found: &found, slot: 0, share: 1.0 }.report();
            (report.patch, report.normal_force) = (part.patch, reports.iter().map(|report| report.normal_force).sum());
            let rates = NormalSlopes { by_rate: slopes[..count].iter().map(|slopes| slopes.by_rate).sum(), ..NormalSlopes::default() };
            if report.normal_force > 0.0 {
                add(&report, (0, count - 1), &part, 1.0 - independence, rates);
            }
        }
    }

    /// The same of a patch that is read from a table.
    fn tabled_by_velocity(&self, on: &TabledWheel, carried: &Carried, travel: Option<Vector3<f64>>, change: &mut WrenchTangent) {
        if let Some(report) = carried.reports().first().filter(|report| report.normal_force > 0.0) {
            let slopes = normal_slopes(self.laws.damping.as_ref(), report);
            self.rolling(on.wheel, report, (Cells::Fifths(&on.looked.fifths), &on.looked.part), (1.0, slopes, true), travel, change);
        }
    }

    /// What slip does at a part of which `share` is independent, and with `alone` the rate of its penetration.
    fn rolling(
        &self,
        wheel: &WheelAt,
        report: &ContactReport,
        (cells, part): (Cells, &Part),
        (share, slopes, alone): (f64, NormalSlopes, bool),
        travel: Option<Vector3<f64>>,
        change: &mut WrenchTangent,
    ) {
        let WheelAt { wheelset, side, motion, contact, .. } = *wheel;
        let mut law = *report;
        Contact { wheel, found: &Contact::again(report), slot: 0, share: report.share }.creep(&mut law);
        let at = At { wheelset, side, contact, slot: 0, motion, report: &law, friction: wheel.friction_at(report), travel };
        let uneven = wheel.uneven(cells, part, &report.axes);
        let touching = Touching::staying(&law, motion);
        let mut normal = touching.normal_force(NormalSlopes { by_penetration: 0.0, ..slopes }, [0.0; 6]);
        normal.position = [[0.0; 6]];
        let creep = self.steady(&at, Some(&uneven), &touching, &normal).times(share);
        let normal = if alone { normal } else { ByMotion { position: [[0.0; 6]], velocity: [[0.0; 6]] } };
        touching.add_wrench(&law, &normal, &creep, change);
    }
}

/// Force and moment, or velocity and rotation, in one.
pub(super) fn stacked(wrench: &Wrench) -> Vector6<f64> {
    let (force, moment) = (wrench.force, wrench.moment);
    Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z)
}
