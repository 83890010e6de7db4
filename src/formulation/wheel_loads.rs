//! Wheel loads over a run, for what its user should know: wheels that unload, wheels that strike, and loads that no rigid track would meet.

use super::beat::{self, Beat, Swing};
use super::flange::{Flanges, Reach};
use super::hand_overs::{self, Phases};
use super::hunting::{self, Turns};
use super::linear_range::{Beyond, Ranges};
use super::step::WheelRef;
use super::{Model, Workspace, contact_index};
use crate::contact::profile_end::ProfileEnd;
use crate::geometry::Side;
use serde::{Deserialize, Serialize};

/// Shares of the static load below and above which a wheel is named.
const LEAST: f64 = 0.1;
const MOST: f64 = 4.0;
/// A wheel that has carried nothing and then carries this share has struck its rail.
const STRIKE: f64 = 2.0;

/// Least and greatest load of a wheel by its static load, and when, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Range {
    least: (f64, f64),
    most: (f64, f64),
}

impl Range {
    const NONE: Range = Range { least: (f64::INFINITY, f64::NEG_INFINITY), most: (0.0, f64::NEG_INFINITY) };

    fn note(&mut self, share: f64, t: f64) {
        if share < self.least.0 {
            self.least = (share, t);
        }
        if share > self.most.0 && share.is_finite() {
            self.most = (share, t);
        }
    }

    fn take_back(&mut self, time: f64) {
        if self.least.1 > time {
            self.least = Range::NONE.least;
        }
        if self.most.1 > time {
            self.most = Range::NONE.most;
        }
    }
}

/// Those of all wheels, the left one of each wheelset first.
#[derive(Clone, Debug, Default)]
pub struct WheelLoads {
    ranges: Vec<Range>,
    /// The first wheel that struck its rail (its contact), and when, s.
    strike: Option<(usize, f64)>,
    /// The first wheel whose patch reached the end of a profile (its contact), when, s, and which.
    ended: Option<(usize, f64, ProfileEnd)>,
    beats: Vec<Beat>,
    /// Small swings of each wheel's load and lateral force, and its loads, while small swings of its wheelset grow.
    trembles: Vec<[Beat; 2]>,
    fluttering: Vec<Range>,
    /// Where flanges are left out.
    flanges: Option<Flanges>,
    /// Where contact is linear.
    linear: Option<Ranges>,
    /// Where constraints may become elastic.
    phases: Vec<Phases>,
    /// Flanges of each wheelset in turn.
    turns: Vec<Turns>,
}

impl WheelLoads {
    /// Has the load of a wheelset's wheel swung by half its static value or more while small swings grew?
    pub fn swings(&self, wheelset: usize) -> bool {
        let mut ranges = Side::BOTH.into_iter().filter_map(|side| self.fluttering.get(contact_index(wheelset, side)));
        ranges.any(|range| range.least.0 < 0.5 && range.most.0 > 1.5)
    }

    /// The wheel of a wheelset whose load or lateral force has swung most, and fast, for a short while and by little too, while small ones grew, and which force, near a frequency [Hz] by a factor.
    pub fn trembles(&self, wheelset: usize, frequency: f64, factor: f64) -> Option<(Side, bool, Swing)> {
        let all = Side::BOTH.into_iter().flat_map(|side| {
            let both = self.trembles.get(contact_index(wheelset, side)).into_iter().flatten().zip([false, true]);
            both.filter_map(move |(beat, lateral)| Some((side, lateral, beat.swing?)))
        });
        let near = all.filter(|(.., swing)| (swing.frequency / frequency).ln().abs() < factor.ln());
        near.max_by(|a, b| a.2.size.total_cmp(&b.2.size))
    }

    /// The wheel of a wheelset whose load has swung most, and fast, and how.
    pub fn fast_swing(&self, wheelset: usize) -> Option<(Side, Swing)> {
        let both = Side::BOTH.into_iter().filter_map(|side| Some((side, self.beats.get(contact_index(wheelset, side))?.swing?)));
        both.max_by(|a, b| a.1.size.total_cmp(&b.1.size))
    }
}

/// What [`WheelLoads`] have noted so far, to be saved with a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NotedLoads {
    ranges: Vec<Range>,
    strike: Option<(usize, f64)>,
    ended: Option<(usize, f64, ProfileEnd)>,
    beats: Vec<Beat>,
    trembles: Vec<[Beat; 2]>,
    fluttering: Vec<Range>,
    reached: Vec<Reach>,
    beyond: Vec<Beyond>,
    phases: Vec<Phases>,
    turns: Vec<Turns>,
}

impl WheelLoads {
    /// What is noted so far.
    pub fn noted(&self) -> NotedLoads {
        let reached = self.flanges.as_ref().map_or(&[][..], Flanges::reached).to_vec();
        let beyond = self.linear.as_ref().map_or(&[][..], Ranges::beyond).to_vec();
        NotedLoads {
            ranges: self.ranges.clone(),
            strike: self.strike,
            ended: self.ended,
            beats: self.beats.clone(),
            trembles: self.trembles.clone(),
            fluttering: self.fluttering.clone(),
            reached,
            beyond,
            phases: self.phases.clone(),
            turns: self.turns.clone(),
        }
    }

    /// Becomes a copy of another's notes on the same wheels, in the memory that it has.
    pub fn copy_from(&mut self, other: &WheelLoads) {
        self.ranges.clone_from(&other.ranges);
        self.beats.clone_from(&other.beats);
        self.trembles.clone_from(&other.trembles);
        self.fluttering.clone_from(&other.fluttering);
        self.phases.clone_from(&other.phases);
        self.turns.clone_from(&other.turns);
        (self.strike, self.ended) = (other.strike, other.ended);
        self.flanges.clone_from(&other.flanges);
        self.linear.clone_from(&other.linear);
    }

    /// Goes on with what was noted before. Returns false and changes nothing when it is not of the same wheels.
    pub fn go_on(&mut self, noted: NotedLoads) -> bool {
        let wheels = self.ranges.len();
        let counts = noted.ranges.len() == wheels
            && noted.beats.len() == wheels
            && noted.trembles.len() == wheels
            && noted.fluttering.len() == wheels
            && noted.phases.len() == self.phases.len()
            && noted.turns.len() == self.turns.len();
        let own =
            counts && noted.strike.is_none_or(|(contact, _)| contact < wheels) && noted.ended.is_none_or(|(contact, ..)| contact < wheels);
        let linear = own && self.linear.as_mut().map_or(noted.beyond.is_empty(), |linear| linear.go_on(noted.beyond));
        let flanges = linear && self.flanges.as_mut().map_or(noted.reached.is_empty(), |flanges| flanges.go_on(noted.reached));
        if flanges {
            (self.ranges, self.strike, self.beats, self.phases) = (noted.ranges, noted.strike, noted.beats, noted.phases);
            (self.trembles, self.fluttering, self.turns, self.ended) = (noted.trembles, noted.fluttering, noted.turns, noted.ended);
        }
        flanges
    }

    /// Forgets what was noted after `time` [s], where a state of that time is taken up again: what an abandoned course did has not happened.
    pub fn take_back(&mut self, time: f64) {
        self.ranges.iter_mut().chain(&mut self.fluttering).for_each(|range| range.take_back(time));
        self.strike = self.strike.filter(|strike| strike.1 <= time);
        self.ended = self.ended.filter(|ended| ended.1 <= time);
        self.beats.iter_mut().chain(self.trembles.iter_mut().flatten()).for_each(|beat| beat.take_back(time));
        hand_overs::take_back(&mut self.phases, time);
        hunting::take_back(&mut self.turns, time);
        self.flanges.iter_mut().for_each(|flanges| flanges.take_back(time));
        self.linear.iter_mut().for_each(|linear| linear.take_back(time));
    }

    /// When a wheel first struck its rail, s.
    pub fn first_strike(&self) -> Option<f64> {
        self.strike.map(|(_, time)| time)
    }
}

impl Model {
    /// Before a run.
    pub fn wheel_loads(&self) -> WheelLoads {
        WheelLoads {
            ranges: vec![Range::NONE; self.contacts()],
            strike: None,
            ended: None,
            beats: vec![Beat::default(); self.contacts()],
            trembles: vec![Default::default(); self.contacts()],
            fluttering: vec![Range::NONE; self.contacts()],
            flanges: Flanges::of(self),
            linear: Ranges::of(self),
            phases: hand_overs::of(self),
            turns: vec![Turns::default(); self.wheelsets.len()],
        }
    }

    /// Notes the loads that the workspace's evaluation found at `t` [s]; on plain track nothing excites wheelsets, and small swings of some of them grow.
    pub fn note_wheel_loads(
        &self,
        workspace: &Workspace,
        (t, plain): (f64, bool),
        flutters: impl Fn(usize) -> bool,
        loads: &mut WheelLoads,
    ) {
        if let Some(flanges) = &mut loads.flanges {
            flanges.look(self, workspace, t);
        }
        if let Some(linear) = &mut loads.linear {
            linear.look(self, workspace, t);
        }
        hand_overs::look(self, workspace, t, &mut loads.phases);
        hunting::look(self, workspace, (t, plain), &mut loads.turns);
        for (WheelRef { contact, wheelset, side }, range) in self.wheels().zip(&mut loads.ranges) {
            let force = workspace.wheel_force(contact, wheelset.body) / wheelset.static_wheel_load;
            let share = force.z;
            let beat = &mut loads.beats[contact];
            if beat.counts() && self.shakes(side, workspace.system.motions[wheelset.body].distance) {
                beat.interrupt();
            } else {
                beat.note(share, t, &beat::GREAT);
            }
            let flutters = flutters(contact / Side::BOTH.len());
            for (tremble, share) in loads.trembles[contact].iter_mut().zip([force.z, force.y]) {
                if flutters { tremble.note(share, t, &beat::SMALL) } else { tremble.interrupt() }
            }
            if flutters {
                loads.fluttering[contact].note(share, t);
            }
            range.note(share, t);
            if loads.ended.is_none() && self.laws.patch.forms() {
                let (wheel, rail) = (&wheelset.wheel(side).profile, &self.track.rail(side).profile);
                let mut ends = workspace.reports(contact).filter_map(|report| report.profile_end(wheel.as_ref(), rail.as_ref()));
                loads.ended = ends.next().map(|end| (contact, t, end));
            }
            if range.least.0 <= 0.0 && share > STRIKE && loads.strike.is_none() {
                loads.strike = Some((contact, t));
            }
        }
    }

    /// Does a rail deviate there so that it moves a wheel?
    fn shakes(&self, side: Side, distance: f64) -> bool {
        let rail = self.track.rail(side);
        rail.deviates() && rail.deviation(distance).iter().any(|[_, slopes @ ..]| slopes.iter().any(|slope| *slope != 0.0))
    }

    /// What a user should know about loads, the extreme wheel of each kind.
    pub fn load_notes(&self, loads: &WheelLoads) -> Vec<String> {
        let others = |count: usize| match count {
            0 | 1 => String::new(),
            2 => ", another wheel too".into(),
            more => format!(", {} more wheels too", more - 1),
        };
        let mut notes = Vec::new();
        let named = |WheelRef { wheelset, side, .. }: WheelRef| format!("{}, {} wheel", wheelset.name, side.name());
        let all: Vec<(String, &Range)> = self.wheels().map(named).zip(&loads.ranges).collect();
        notes.extend(loads.flanges.as_ref().and_then(|flanges| flanges.note(|contact| all[contact].0.clone())));
        notes.extend(loads.linear.iter().flat_map(|linear| linear.notes(|contact| all[contact].0.clone())));
        notes.extend(hand_overs::note(&loads.phases, |contact| all[contact].0.clone()));
        notes.extend(if loads.strike.is_none() { hunting::note(self, &loads.turns) } else { None });
        let light = all.iter().filter(|(_, range)| range.least.0 < LEAST);
        if let Some((wheel, range)) = light.clone().min_by(|a, b| a.1.least.0.total_cmp(&b.1.least.0)) {
            let load = if range.least.0 > 0.0 { format!("{:.1} % of the static load", 100.0 * range.least.0) } else { "nothing".into() };
            let landing = if range.least.0 > 0.0 {
                ""
            } else {
                "; where its bounces soon die, loads at the instants of its landing are known to some per cent of the static load, with solver.load_tolerance = 1e-3 to some tenths of a per cent"
            };
            notes.push(format!(
                "{wheel} carries {load} at {:.4} s (below {:.0} %{}: guidance is not safe then{landing})",
                range.least.1,
                100.0 * LEAST,
                others(light.count())
            ));
        }
        if let Some((contact, time)) = loads.strike {
            notes.push(format!(
                "{} has left its rail and strikes it at {time:.4} s: an error of the size of the tolerance shifts each impact, and the next ones grow by it. Where contacts are \
                 damped so that a bounce dies within some of them, loads hold; else they are orders of magnitude from there on: runs with solver.load_tolerance = 1e-3, and with solver.integrator = \"dormand_prince\", show how far they hold",
                all[contact].0
            ));
        }
        if let Some((contact, time, end)) = &loads.ended {
            notes.push(end.words(&format!("{}: at {time:.4} s its patch", all[*contact].0)));
        }
        let heavy = all.iter().filter(|(_, range)| range.most.0 > MOST);
        if let Some((wheel, range)) = heavy.clone().max_by(|a, b| a.1.most.0.total_cmp(&b.1.most.0)) {
            notes.push(format!(
                "{wheel} carries {:.1} times its static load at {:.4} s (above {MOST} times{}){}",
                range.most.0,
                range.most.1,
                others(heavy.count()),
                if self.gives_way() {
                    ""
                } else {
                    ": rails are rigid here; a real track yields and has mass, and an impact on it is another one, mostly a smaller one"
                }
            ));
        }
        notes
    }
}
