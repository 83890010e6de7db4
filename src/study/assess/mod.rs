//! Assessment of a run: running safety, track loading and ride characteristics after EN 14363, comfort after EN 12299, ISO 2631-1 and Sperling, wear.
//!
//! [`signals`] are results at even intervals, [`filter`] and [`statistics`] what is done to them, [`sections`] cuts the track, [`quantity`] has names and limits,
//! [`known`] what a scene says of vehicle and track. [`forces`], [`accelerations`], [`comfort`] make rows of the table; each says what it is, by which filter, and
//! where it is defined. docs/assess.md has the same for who reads the table.

mod accelerations;
pub mod aliased;
mod comfort;
pub mod filter;
mod forces;
pub mod guiding_angle;
pub mod known;
pub mod origin;
pub mod quantity;
pub mod sections;
pub mod signals;
pub mod statistics;
pub mod weighting;

use known::Known;
use quantity::{Quantity, VehicleKind};
use sections::{Section, Zone};
use serde::Serialize;
use signals::Signals;
use statistics::mean_and_deviation;

/// What a value means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    Pass,
    Fail,
    /// There is no limit.
    Value,
    NotAssessable,
}

impl Verdict {
    pub fn words(self) -> &'static str {
        match self {
            Verdict::Pass => "pass",
            Verdict::Fail => "FAIL",
            Verdict::Value => "-",
            Verdict::NotAssessable => "not assessable",
        }
    }
}

/// A line of the table; values in SI.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub key: &'static str,
    #[serde(skip)]
    pub quantity: &'static Quantity,
    /// Kind of track, where it matters.
    pub zone: Option<Zone>,
    /// Wheel, wheelset or sensor with the largest value.
    pub place: String,
    pub value: Option<f64>,
    pub limit: Option<f64>,
    pub verdict: Verdict,
    /// What the value is made of, or why there is none.
    pub note: String,
}

/// A curve over distance for the picture, in the quantity's shown unit.
#[derive(Clone, Debug)]
pub struct Trace {
    pub quantity: &'static Quantity,
    pub place: String,
    pub points: Vec<(f64, f64)>,
}

/// The whole of it.
#[derive(Clone, Debug, Serialize)]
pub struct Assessment {
    pub vehicle: VehicleKind,
    /// s, m, m/s.
    pub duration: f64,
    pub distance: f64,
    pub highest_speed: f64,
    pub admissible_speed: f64,
    /// Of the results, s.
    pub interval: f64,
    pub sections: Vec<Section>,
    pub rows: Vec<Row>,
    #[serde(skip)]
    pub traces: Vec<Trace>,
}

impl Assessment {
    /// Of a run.
    ///
    /// # Errors
    /// [`CannotAssess`] where no row could be made.
    pub fn of(signals: &Signals, known: &Known) -> Result<Assessment, CannotAssess> {
        let travel = Travel::of(signals)?;
        let admissible = known.admissible_speed.unwrap_or(travel.highest);
        let stretches = match &known.vehicle {
            Some(vehicle) => vehicle.track.stretches(travel.from, travel.to, travel.highest),
            None => vec![Section { zone: Zone::Unknown, from: travel.from, to: travel.to }],
        };
        let run = Run { signals, known, sections: sections::cut(&stretches, travel.highest), stretches, speed: travel.highest, admissible };
        let mut made = Made { run: &run, rows: Vec::new(), traces: Vec::new() };
        forces::assess(&mut made);
        accelerations::assess(&mut made);
        comfort::assess(&mut made);
        forces::wear(&mut made);
        let (rows, traces) = (made.rows, made.traces);
        Ok(Assessment {
            vehicle: known.kind,
            duration: signals.duration(),
            distance: travel.to - travel.from,
            highest_speed: travel.highest,
            admissible_speed: admissible,
            interval: signals.interval,
            sections: run.sections,
            rows,
            traces,
        })
    }

    /// Is a limit exceeded?
    pub fn fails(&self) -> bool {
        self.rows.iter().any(|row| row.verdict == Verdict::Fail)
    }

    /// Has anything a value?
    pub fn says_something(&self) -> bool {
        self.rows.iter().any(|row| row.value.is_some())
    }
}

/// Why there is nothing to assess.
#[derive(Debug, thiserror::Error)]
pub enum CannotAssess {
    #[error("no column NAME.distance: record wheelsets' motion and wheels, interface.outputs = [\"motion\", \"wheels\", \"sensors\"]")]
    NoDistance,
    #[error("{name}.distance falls from {from} m to {to} m at {time} s: a run is assessed forward; turn it (vehicle.speed > 0)")]
    Backward { name: String, from: f64, to: f64, time: f64 },
    #[error("{name}.distance does not grow: nothing has run")]
    Standing { name: String },
}

/// Where the first part that has a distance goes.
struct Travel {
    from: f64,
    to: f64,
    highest: f64,
}

impl Travel {
    fn of(signals: &Signals) -> Result<Travel, CannotAssess> {
        let owners = signals.owners(".distance");
        if owners.is_empty() {
            return Err(CannotAssess::NoDistance);
        }
        for name in &owners {
            let distance = signals.column(&format!("{name}.distance")).unwrap_or_default();
            if let Some(k) = distance.windows(2).position(|pair| pair[1] < pair[0] - 1e-6) {
                let time = signals.start + signals.interval * (k + 1) as f64;
                return Err(CannotAssess::Backward { name: name.to_string(), from: distance[k], to: distance[k + 1], time });
            }
        }
        let distance = signals.column(&format!("{}.distance", owners[0])).unwrap_or_default();
        let (from, to) = (distance[0], distance[distance.len() - 1]);
        // Over a tenth of a second, so that rounding of places makes no speeds.
        let apart = ((0.1 * signals.rate()).round() as usize).clamp(1, distance.len() - 1);
        let speeds = (apart..distance.len()).map(|k| (distance[k] - distance[k - apart]) / (apart as f64 * signals.interval));
        let highest = speeds.fold(0.0, f64::max);
        if !(highest > 1e-3) {
            return Err(CannotAssess::Standing { name: owners[0].into() });
        }
        Ok(Travel { from, to, highest })
    }
}

/// What rows are made of.
struct Run<'a> {
    signals: &'a Signals,
    known: &'a Known,
    stretches: Vec<Section>,
    sections: Vec<Section>,
    /// Highest of the run and admissible, m/s.
    speed: f64,
    admissible: f64,
}

/// Sampling interval of forces and accelerations up to 20 Hz, s: ten samples of the shortest wave that passes.
const COARSEST: f64 = 5e-3;

impl Run<'_> {
    /// Why the interval is too coarse, if it is.
    fn too_coarse(&self, coarsest: f64, reason: &str) -> Option<String> {
        let found = self.signals.coarsest;
        (found > coarsest * (1.0 + 1e-6)).then(|| {
            let [found, needed] = [found, coarsest].map(|time| (1e6 * time).round() / 1e3);
            format!("rows every {found} ms are too coarse {reason}: run.step = \"{needed} ms\" or less")
        })
    }

    /// Samples of a section, by the distance of the part that the signal belongs to.
    fn samples(&self, distance: &[f64], section: &Section) -> Option<std::ops::Range<usize>> {
        let (first, last) = (distance.first()?, distance.last()?);
        let inside = *first <= section.from + 0.5 && *last >= section.to - 0.5;
        let range = distance.partition_point(|s| *s < section.from)..distance.partition_point(|s| *s <= section.to);
        (inside && range.len() > 3).then_some(range)
    }

    /// Why none of these kinds of track has a section.
    fn no_sections(&self, zones: &[Zone]) -> String {
        let longest = zones.iter().filter_map(|zone| {
            let of = self.stretches.iter().filter(|stretch| stretch.zone == *zone).map(|stretch| stretch.to - stretch.from);
            let longest = of.fold(0.0, f64::max);
            (longest > 1.0).then(|| format!("{}: {longest:.0} m of {:.0} m", zone.words(), zone.length(self.speed)))
        });
        format!("too short for one section ({}): longer run.stop", longest.collect::<Vec<_>>().join("; "))
    }
}

/// How values of sections become the one that is compared: safety `mean + 3 s`, loading and ride `mean + 2.2 s`, quasi-static values their mean. With fewer
/// sections than the standard wants it is the largest of them.
///
/// Source: UIC 518:2005, 10 (one-dimensional method); EN 14363:2005, 5.5.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Estimate {
    Safety,
    Loading,
    QuasiStatic,
}

impl Estimate {
    fn factor(self) -> f64 {
        match self {
            Estimate::Safety => 3.0,
            Estimate::Loading => 2.2,
            Estimate::QuasiStatic => 0.0,
        }
    }

    /// Value and note.
    fn of(self, zone: Zone, values: &[f64]) -> Option<(f64, String)> {
        let (mean, deviation) = mean_and_deviation(values)?;
        let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (count, wanted) = (values.len(), zone.wanted());
        Some(if count < wanted {
            let all = if count == 1 { "1 section".into() } else { format!("largest of {count} sections") };
            (largest, format!("{all}; statistics need {wanted}"))
        } else if self == Estimate::QuasiStatic {
            (mean, format!("mean of {count} sections"))
        } else {
            (mean + self.factor() * deviation, format!("mean + {} s of {count} sections", self.factor()))
        })
    }
}

/// Values of sections at one place.
type OfSection<'a> = dyn Fn(&Section) -> Option<f64> + 'a;

/// Rows in the making.
struct Made<'a> {
    run: &'a Run<'a>,
    rows: Vec<Row>,
    traces: Vec<Trace>,
}

impl Made<'_> {
    /// A row with a value; the user's limit goes before the table's.
    fn value(&mut self, quantity: &'static Quantity, zone: Option<Zone>, place: &str, value: f64, limit: Option<f64>, note: String) {
        let own = self.run.known.limits.iter().find(|limit| limit.0 == quantity.key).map(|limit| limit.1);
        let limit = own.or(limit);
        let verdict = match limit {
            None => Verdict::Value,
            Some(limit) if value <= limit => Verdict::Pass,
            Some(_) => Verdict::Fail,
        };
        self.rows.push(Row { key: quantity.key, quantity, zone, place: place.into(), value: Some(value), limit, verdict, note });
    }

    fn nothing(&mut self, quantity: &'static Quantity, note: &str) {
        let verdict = Verdict::NotAssessable;
        self.rows.push(Row {
            key: quantity.key,
            quantity,
            zone: None,
            place: String::new(),
            value: None,
            limit: None,
            verdict,
            note: note.into(),
        });
    }

    /// One row per zone with the place whose value is nearest to its limit, or largest.
    fn zones(&mut self, quantity: &'static Quantity, estimate: Estimate, zones: &[Zone], places: &[(String, Option<f64>, &OfSection)]) {
        let run = self.run;
        let mut any = false;
        for zone in zones {
            let sections: Vec<&Section> = run.sections.iter().filter(|section| section.zone == *zone).collect();
            let found = places.iter().filter_map(|(place, limit, of)| {
                let values: Vec<f64> = sections.iter().filter_map(|section| of(section)).collect();
                let (value, note) = estimate.of(*zone, &values)?;
                Some((place, *limit, value, note))
            });
            let use_of = |found: &(&String, Option<f64>, f64, String)| found.2 / found.1.unwrap_or(1.0);
            if let Some((place, limit, value, note)) = found.max_by(|a, b| use_of(a).total_cmp(&use_of(b))) {
                any = true;
                self.value(quantity, Some(*zone), place, value, limit, note);
            }
        }
        if !any {
            let curves = zones.iter().all(|zone| zone.is_curve());
            let there = run.stretches.iter().any(|stretch| zones.contains(&stretch.zone) && stretch.to - stretch.from > 1.0);
            let note = match (&run.known.vehicle, curves && !there) {
                (None, true) => "in curves alone, and the track is not known: --scene SCENE".into(),
                (Some(_), true) => "in curves alone: the run has none".into(),
                _ => run.no_sections(zones),
            };
            self.nothing(quantity, &note);
        }
    }
}
