//! Accelerations of bodies and bogie frames after EN 14363: safety (simplified method) and ride characteristics.
//!
//! | quantity | filter | of a section |
//! |---|---|---|
//! | body, lateral, safety | low pass 6 Hz | larger size of the 0.15 % and 99.85 % percentile |
//! | body, vertical, safety | band pass 0.4-4 Hz | the same |
//! | bogie frame, lateral, safety | low pass 10 Hz | the same |
//! | ride, lateral and vertical | band pass 0.4-10 Hz | the same; and rms |
//! | quasi-static, lateral | low pass 20 Hz | size of the 50 % percentile, in full curves |
//!
//! Band passes are a high pass and a low pass of fourth order in series (`filter.rs`). Accelerations are those that an accelerometer at the point shows (`measuredAy`).
//! Nothing else stands in: under cant and roll the kinematic ones are another matter, without gravity across the track (R 400 m, 150 mm of cant, 10 m/s: 0.3 for
//! 1.0 m/s2) and without the curve's part across the floor.
//!
//! Limits [m/s2]: safety, lateral 3.0 in zones 1 and 2, 2.8 in 3, 2.6 in 4; vertical 3.0, 5.0 with one level of suspension; frame 12 - m/5 (mass m of its truck in t, wheelsets with it); ride 2.5, rms
//! 0.5 lateral and 0.75 (locomotives 1.0) vertical; quasi-static 1.5 (freight wagons 1.3). Those of freight wagons' bodies (safety and ride) depend on their running gear and are left open.
//! Sources: EN 14363:2005, 5.5, Tables 8 to 10; UIC 518:2005, 10 and Appendix, as known from the literature; the texts were not at hand.

use super::filter::Filter;
use super::quantity::{self as q, Quantity, VehicleKind};
use super::sections::{Section, Zone};
use super::statistics::{extreme, percentile, rms};
use super::{COARSEST, Estimate, Made, OfSection, Run, Trace};

/// The scene's lines for a sensor on a body.
fn lines(body: &str) -> String {
    format!("[[vehicle.sensor]] name = \"floor\", body = \"{body}\", at = [x, y, z], measured = true; and \"sensors\" in interface.outputs")
}

/// Why there is nothing.
pub(super) const SHOWN: &str = "needs what an accelerometer shows (gravity and curves under cant): measured = true in the sensor's table";

/// A point on a body.
pub(super) struct Point<'a> {
    pub name: String,
    distance: Option<&'a [f64]>,
    /// Along x, y and z as an accelerometer shows them, m/s2.
    pub along: [Option<&'a [f64]>; 3],
    /// Has the result its kinematic acceleration alone?
    unmeasured: bool,
}

impl<'a> Point<'a> {
    fn read(run: &Run<'a>, name: &str) -> Point<'a> {
        let column = |of: &str| run.signals.column(&format!("{name}.{of}"));
        let along = [column("measuredAx"), column("measuredAy"), column("measuredAz")];
        Point { name: name.into(), distance: column("distance"), along, unmeasured: along[1].is_none() && column("ay").is_some() }
    }
}

/// Sensors on car bodies: those of the scene, else all that are no wheelsets.
pub(super) fn floor<'a>(run: &Run<'a>) -> Vec<Point<'a>> {
    let there =
        |name: &&str| ["measuredAy", "ay", "measuredAz", "az"].iter().any(|of| run.signals.column(&format!("{name}.{of}")).is_some());
    let names: Vec<&str> = match &run.known.vehicle {
        Some(vehicle) => vehicle.body_sensors.iter().map(|sensor| sensor.name.as_str()).filter(there).collect(),
        None => {
            let wheelsets = [run.signals.owners(".left.verticalForce"), run.signals.owners(".yawAcceleration")].concat();
            let mut names = [run.signals.owners(".measuredAy"), run.signals.owners(".ay")].concat();
            names.retain(|name| !wheelsets.contains(name));
            names.sort_unstable();
            names.dedup();
            names
        }
    };
    names.into_iter().map(|name| Point::read(run, name)).collect()
}

/// Why there are no accelerations of a car body.
pub(super) fn no_floor(run: &Run) -> String {
    match &run.known.vehicle {
        Some(vehicle) if vehicle.body_sensors.is_empty() => match &vehicle.car {
            Some(car) => format!("the scene has no sensor on a car body: {}", lines(car)),
            None => "wheelsets alone have no car body".into(),
        },
        Some(vehicle) => format!("no columns {}.ay: \"sensors\" in interface.outputs", vehicle.body_sensors[0].name),
        None => format!("no columns SENSOR.ay: {}", lines("car")),
    }
}

const RIDE: [&Quantity; 7] =
    [&q::SAFETY_LATERAL, &q::SAFETY_VERTICAL, &q::RIDE_LATERAL, &q::RIDE_VERTICAL, &q::RMS_LATERAL, &q::RMS_VERTICAL, &q::LATERAL_QST];

pub(super) fn assess(made: &mut Made) {
    let points = floor(made.run);
    let coarse = made.run.too_coarse(COARSEST, "for filters up to 20 Hz");
    if let Some(why) = if points.is_empty() { Some(no_floor(made.run)) } else { coarse.clone() } {
        RIDE.iter().for_each(|quantity| made.nothing(quantity, &why));
    } else {
        body(made, &points);
        traces(made, &points);
        tell_of_left_out(made, &points, &q::SAFETY_LATERAL);
    }
    let frames = made.run.known.vehicle.iter().flat_map(|vehicle| &vehicle.frame_sensors);
    let frames: Vec<(Point, f64)> = frames.map(|sensor| (Point::read(made.run, &sensor.name), sensor.mass)).collect();
    if !frames.is_empty() && coarse.is_none() {
        let rate = made.run.signals.rate();
        let limits: Vec<f64> = frames.iter().map(|frame| 12.0 - frame.1 / 5e3).collect();
        let points: Vec<Point> = frames.into_iter().map(|frame| frame.0).collect();
        let of = Treated { axis: 1, filter: Filter::low_pass(10.0, rate), value: extreme };
        of.rows(made, &points, &q::SAFETY_FRAME, Estimate::Safety, &Zone::ALL, |index| limits.get(index).copied());
        tell_of_left_out(made, &points, &q::SAFETY_FRAME);
    }
}

/// A row for each point that had to be left out, beside others that are judged.
fn tell_of_left_out(made: &mut Made, points: &[Point], quantity: &'static Quantity) {
    if points.iter().any(|point| point.along[1].is_some()) {
        for point in points.iter().filter(|point| point.unmeasured) {
            made.nothing(quantity, &format!("{} is left out: {SHOWN}", point.name));
        }
    }
}

/// What is done to an acceleration.
struct Treated {
    axis: usize,
    filter: Filter,
    value: fn(&[f64]) -> Option<f64>,
}

impl Treated {
    fn rows(
        &self,
        made: &mut Made,
        points: &[Point],
        quantity: &'static Quantity,
        estimate: Estimate,
        zones: &[Zone],
        limit: impl Fn(usize) -> Option<f64>,
    ) {
        if points.iter().all(|point| point.along[self.axis].is_none()) {
            return made.nothing(quantity, SHOWN);
        }
        let run = made.run;
        let signals: Vec<Option<Vec<f64>>> = points.iter().map(|point| point.along[self.axis].map(|raw| self.filter.of(raw))).collect();
        let of: Vec<Box<OfSection>> = points
            .iter()
            .zip(&signals)
            .map(|(point, signal)| -> Box<OfSection> {
                Box::new(move |section: &Section| (self.value)(&signal.as_ref()?[run.samples(point.distance?, section)?]))
            })
            .collect();
        let places: Vec<(String, Option<f64>, &OfSection)> =
            points.iter().enumerate().map(|(index, point)| (point.name.clone(), limit(index), of[index].as_ref())).collect();
        made.zones(quantity, estimate, zones, &places);
    }
}

fn body(made: &mut Made, points: &[Point]) {
    let (rate, kind) = (made.run.signals.rate(), made.run.known.kind);
    let carries = kind != VehicleKind::Freight;
    let sensors = made.run.known.vehicle.as_ref().map_or(&[][..], |vehicle| &vehicle.body_sensors);
    let single = |index: usize| sensors.iter().any(|sensor| sensor.single_level && points[index].name == sensor.name);
    let limit = |value: f64| move |_: usize| carries.then_some(value).filter(|value| value.is_finite());
    // The lateral limit falls with the radius.
    let lateral = Treated { axis: 1, filter: Filter::low_pass(6.0, rate), value: extreme };
    let groups: [(&[Zone], f64); 4] = [
        (&[Zone::Straight, Zone::LargeRadius], 3.0),
        (&[Zone::SmallRadius], 2.8),
        (&[Zone::VerySmallRadius, Zone::Tighter], 2.6),
        (&[Zone::Unknown], f64::INFINITY),
    ];
    let run = made.run;
    let is_there = |zones: &[Zone]| run.sections.iter().any(|section| zones.contains(&section.zone));
    if points.iter().all(|point| point.along[1].is_none()) {
        made.nothing(&q::SAFETY_LATERAL, SHOWN);
    } else if run.sections.is_empty() {
        made.nothing(&q::SAFETY_LATERAL, &run.no_sections(&Zone::ALL));
    } else {
        for (zones, value) in groups.into_iter().filter(|group| is_there(group.0)) {
            lateral.rows(made, points, &q::SAFETY_LATERAL, Estimate::Safety, zones, limit(value));
        }
    }
    let vertical = Treated { axis: 2, filter: Filter::band_pass([0.4, 4.0], rate), value: extreme };
    vertical
        .rows(made, points, &q::SAFETY_VERTICAL, Estimate::Safety, &Zone::ALL, |index| limit(if single(index) { 5.0 } else { 3.0 })(index));
    let vertical_rms = if kind == VehicleKind::Locomotive { 1.0 } else { 0.75 };
    type Line = (&'static Quantity, usize, fn(&[f64]) -> Option<f64>, f64);
    let lines: [Line; 4] = [
        (&q::RIDE_LATERAL, 1, extreme, 2.5),
        (&q::RIDE_VERTICAL, 2, extreme, 2.5),
        (&q::RMS_LATERAL, 1, rms, 0.5),
        (&q::RMS_VERTICAL, 2, rms, vertical_rms),
    ];
    for (quantity, axis, value, most) in lines {
        let treated = Treated { axis, filter: Filter::band_pass([0.4, 10.0], rate), value };
        treated.rows(made, points, quantity, Estimate::Loading, &Zone::ALL, limit(most));
    }
    let curves: Vec<Zone> = Zone::ALL.into_iter().filter(|zone| zone.is_curve()).collect();
    let middle = |values: &[f64]| percentile(values, 50.0).map(f64::abs);
    let most = if carries { 1.5 } else { 1.3 };
    let treated = Treated { axis: 1, filter: Filter::low_pass(20.0, rate), value: middle };
    treated.rows(made, points, &q::LATERAL_QST, Estimate::QuasiStatic, &curves, |_| Some(most));
}

/// Curves for the picture.
fn traces(made: &mut Made, points: &[Point]) {
    let filter = Filter::band_pass([0.4, 10.0], made.run.signals.rate());
    for point in points {
        for (quantity, axis) in [(&q::RIDE_LATERAL, 1), (&q::RIDE_VERTICAL, 2)] {
            let Some((distance, raw)) = point.distance.zip(point.along[axis]) else { continue };
            let points = distance.iter().copied().zip(filter.of(raw)).collect();
            made.traces.push(Trace { quantity, place: point.name.clone(), points });
        }
    }
}
