//! What became of a random scene.
//!
//! The same scene with a tight explicit method (a tight implicit one where that can't) says what is right, for every third seed with each effect
//! computed at each evaluation (`effects.mode = "all"`): no guard of the run has a part in what it is judged by. Bounds: y to 20 times the
//! tolerance, at least 0.01 mm and at most 0.5 mm; with fixed steps to 0.1 mm and 3 % of the largest |y|. Q to 3 % (fixed steps: 10 %) of the static
//! load or of the largest Q, whichever is more. Where a scene is so sensitive that two tight methods differ by more than a third of a
//! bound, that difference three times is the bound: beyond it nobody can say what is right. Both on a grid of 0.2 ms; what lies within the
//! reference's three samples around is no error, since an impact may come a sample sooner or later. The books (see `audit`) must balance to 5 %.
//!
//! Beyond a bound a run is wrong unless the scene itself is that sensitive: wheels that fly and strike again and again multiply any error. The
//! tight method is then run again from starts that are moved aside by half of what y may be off by, in up to four ways. Where one of them moves the
//! result as far as half the error, that error is one that these bounds allow, amplified by the scene ("beyond foresight", counted on its own). Where y holds and
//! loads are off only after a wheel has left its rail and struck it, or flutters, the run's own notes say that they are no more than orders of magnitude from there on
//! ("struck or flutters, and says so", counted on its own too).

use super::super::audit::Audit;
use super::super::case::{Audited, Method};
use super::super::judge::guarded;
use super::super::run::{End, Look, Ran, run};
use super::super::trace::{Quantity, Trace};
use super::super::{finding::Finding, open};
use super::scene::RandomScene;
use crate::mbs::body::{LATERAL, YAW};
use crate::scene::spec::Scene;
use crate::sim::Simulation;
use crate::study::accuracy::cpu_time;
use serde::Serialize;
use std::sync::mpsc;
use std::time::Duration;

const GRID: f64 = 2e-4;
/// CPU time of a run and of a reference, s; a refusal comes within. (The longest run of the first 300 seeds, ECF-N with steps of 33 us, takes 15 to 20 s.)
const LIMIT: f64 = 45.0;
const REFERENCE_LIMIT: f64 = 20.0;
const REFUSAL: f64 = 2.0;
/// A run that has not come back after this hangs, s of wall time.
const HANG: u64 = 150;
const BOOKS: Audited = Audited { energy: 0.05, way: 0.01, weight: 0.02, derailment: true };
/// A derailment or a physical end is the same one within this, s.
const SAME_END: f64 = 0.03;

/// A load rises to what is named as a strike within this, s.
const RISE: f64 = 2e-3;

/// Least bound of y with fixed steps, m.
const OF_FIXED_STEPS: f64 = 1e-4;

/// What became of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    Right,
    /// Before the run with a reason, or in it because of a fixed step that is too long, which is said with its cure.
    Refused,
    /// A wheel left its rail, or the model ended (a constraint would pull, a profile ends), as the reference says.
    Derailed,
    /// The integration gave up, with place and reason.
    GaveUp,
    /// No reference could be made.
    Unjudged,
    /// An error of the size of the tolerance grows as far as what was found.
    Unforeseeable,
    /// Wheel loads are off after a wheel has left its rail and struck it; the run's notes say that they are no more than orders of magnitude from then on.
    Struck,
    SilentlyWrong,
    Panic,
    Hang,
    /// It started or was refused, but took longer than a user waits. By the clock: the machine has a part in it.
    SlowStart,
}

impl Class {
    pub const ALL: [Class; 11] = [
        Class::Right,
        Class::Refused,
        Class::Derailed,
        Class::GaveUp,
        Class::Unjudged,
        Class::Unforeseeable,
        Class::Struck,
        Class::SilentlyWrong,
        Class::Panic,
        Class::Hang,
        Class::SlowStart,
    ];

    pub fn words(self) -> &'static str {
        match self {
            Class::Right => "right",
            Class::Refused => "refused",
            Class::Derailed => "derailed as it must",
            Class::GaveUp => "gave up",
            Class::Unjudged => "no reference",
            Class::Unforeseeable => "beyond foresight",
            Class::Struck => "struck or flutters, and says so",
            Class::SilentlyWrong => "SILENTLY WRONG",
            Class::Panic => "PANIC",
            Class::Hang => "HANG",
            Class::SlowStart => "SLOW START",
        }
    }

    /// What must not be at all.
    pub fn is_failure(self) -> bool {
        matches!(self, Class::SilentlyWrong | Class::Panic | Class::Hang | Class::SlowStart)
    }
}

/// A scene's class with the reason.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    pub seed: u64,
    pub class: Class,
    /// Method and formulation, what is wrong and by how much.
    pub reason: String,
    /// How many times its bound the worst error is; infinite where the reason is no number.
    pub strain: f64,
    /// CPU time of the run without its references, s.
    pub cpu: f64,
}

/// Judges the scene of a seed; whatever it does, this comes back.
pub fn judge(seed: u64) -> Verdict {
    judge_with(seed, None)
}

/// The same scene with another method.
pub fn judge_with(seed: u64, method: Option<Method>) -> Verdict {
    let (sender, receiver) = mpsc::channel();
    let spawned = std::thread::Builder::new().name(format!("random {seed}")).spawn(move || {
        let judged = guarded(|| judge_here(seed, method));
        let _ = sender.send(judged.unwrap_or_else(|reason| Verdict { seed, class: Class::Panic, reason, strain: f64::INFINITY, cpu: 0.0 }));
    });
    if let Err(error) = spawned {
        return Verdict { seed, class: Class::Unjudged, reason: format!("no thread: {error}"), strain: f64::INFINITY, cpu: 0.0 };
    }
    // A thread that hangs can't be ended; it is left behind.
    let late = || Verdict { seed, class: Class::Hang, reason: format!("not back after {HANG} s"), strain: f64::INFINITY, cpu: HANG as f64 };
    receiver.recv_timeout(Duration::from_secs(HANG)).unwrap_or_else(|_| late())
}

fn open_with(drawn: &RandomScene, changes: &[&str]) -> Result<Scene, String> {
    let changes: Vec<String> = changes.iter().map(ToString::to_string).collect();
    open::read(&format!("random_{}", drawn.seed), drawn.text.clone(), None, &changes).map_err(|error| error.to_string())
}

fn judge_here(seed: u64, method: Option<Method>) -> Verdict {
    let drawn = RandomScene::draw(seed).with(method);
    let own: Vec<String> = method.iter().flat_map(Method::changes).collect();
    let own: Vec<&str> = own.iter().map(String::as_str).collect();
    let verdict = |class, reason: String, cpu| Verdict { seed, class, reason, strain: f64::INFINITY, cpu };
    let start = || {
        let scene = open_with(&drawn, &own)?;
        Simulation::new(&scene, 0.0).map(|run| (scene, run)).map_err(|error| error.to_string())
    };
    let (started, seconds) = cpu_time(start);
    if seconds > REFUSAL {
        return verdict(Class::SlowStart, format!("{seconds:.1} s to start or to refuse"), seconds);
    }
    let (scene, mut simulation) = match started {
        Ok(started) => started,
        Err(reason) => return verdict(Class::Refused, reason, seconds),
    };
    let label = format!("{}, {} {:e}", scene.contact.formulation_name, drawn.integrator, drawn.setting);
    let look = Look { stop: drawn.stop, grid: GRID, inputs: &drawn.inputs, limit: LIMIT, audit: BOOKS };
    let ran = run(&scene, &mut simulation, &look);
    let doubts = simulation.doubts();
    let say = |class, reason: &str| match class {
        // A run of fixed steps that says itself that they are too long, and what to do, is not silent.
        Class::SilentlyWrong if doubts.steps > 0 => verdict(Class::Refused, format!("{label}: warned: {doubts}; {reason}"), ran.cpu),
        _ => verdict(class, format!("{label}: {reason}"), ran.cpu),
    };
    if let End::Late { time, limit } = ran.end {
        return say(Class::Hang, &format!("at t = {time:.3} s after {limit} s"));
    }
    // Its own books may say enough where no reference can be made.
    let unjudged = |reason: &str| match (&ran.end, broken(&ran.audit, [0.0; 2])) {
        (End::Finished, Some((reason, strain))) => Verdict { strain, ..say(Class::SilentlyWrong, &reason) },
        (End::Stopped { words, .. }, _) if drawn.fixed && words.contains("solver.step") => say(Class::Refused, words),
        (End::Stopped { words, .. }, _) => say(end_class(words), words),
        _ => say(Class::Unjudged, reason),
    };
    let (first, explicit) = match reference(&drawn, &look) {
        Ok(right) => right,
        Err(reason) => return unjudged(&reason),
    };
    let (ours, theirs) = (ended(&ran), ended(&first));
    // What the first reference says is right is right: the second one only widens bounds, by what nobody can know.
    let holds = match (&ran.end, theirs) {
        (End::Finished, None) => distances(&drawn, &ran, [&first; 2], None).is_none() && booked(&ran, [&first; 2]).is_none(),
        (End::Finished, Some(_)) => false,
        (_, end) => end.is_some_and(|time| (time - ours.unwrap_or(time)).abs() < SAME_END),
    };
    if holds {
        return say(if theirs.is_some() { Class::Derailed } else { Class::Right }, &words(&ran));
    }
    let second = match second_reference(&drawn, &look, explicit) {
        Ok(second) => second,
        Err(reason) => return unjudged(&reason),
    };
    match (&ran.end, theirs) {
        (End::Finished, Some(time)) => {
            return say(Class::SilentlyWrong, &format!("runs on where the reference ends at t = {time:.4} s: {}", words(&first)));
        }
        (End::Finished, None) => {}
        (End::Derailed { .. }, _) => return say(Class::SilentlyWrong, &format!("{}, but the reference does not end there", words(&ran))),
        (End::Stopped { words, .. }, _) if drawn.fixed && words.contains("solver.step") => return say(Class::Refused, words),
        (_, _) => return say(Class::GaveUp, &words(&ran)),
    }
    let warned = simulation.first_strike().into_iter().chain(simulation.first_flutter()).reduce(f64::min);
    let (class, reason, strain) = weigh(&drawn, &look, (&ran, warned), [&first, &second]);
    Verdict { strain, ..say(class, &reason) }
}

/// What a run is that ends as its references do: class, reason, and how many times its bound the worst error is. `warned`: from when on its
/// notes say that loads are orders of magnitude, s.
fn weigh(drawn: &RandomScene, look: &Look, (ran, warned): (&Ran, Option<f64>), right: [&Ran; 2]) -> (Class, String, f64) {
    let books = booked(ran, right);
    let Some((reason, strain)) = distances(drawn, ran, right, None) else {
        return books.map_or((Class::Right, String::new(), 0.0), |(reason, strain)| (Class::SilentlyWrong, reason, strain));
    };
    let excused = |way| shaken(drawn, look, way).is_ok_and(|shaken| distances(drawn, ran, right, Some(&shaken.trace)).is_none());
    if WAYS.into_iter().any(excused) {
        return (Class::Unforeseeable, reason, strain);
    }
    // Loads alone, after an impact or from a flutter on that the run's notes name.
    let excused_from = |begin: f64| {
        let after = |wrong: &(Quantity, f64)| wrong.0 == Quantity::Vertical && wrong.1 >= begin - RISE;
        wrong_at(drawn, ran, right).iter().all(after) && books.is_none()
    };
    (if warned.is_some_and(excused_from) { Class::Struck } else { Class::SilentlyWrong }, reason, strain)
}

/// What the books say against a run. Impacts between two samples can't be booked; tight runs have them too.
fn booked(ran: &Ran, right: [&Ran; 2]) -> Option<(String, f64)> {
    let of = |what: fn(&Audit) -> f64| 3.0 * what(&right[0].audit).max(what(&right[1].audit));
    broken(&ran.audit, [of(Audit::energy), of(Audit::lifted)])
}

fn ended(ran: &Ran) -> Option<f64> {
    match &ran.end {
        End::Derailed { time, .. } | End::Stopped { time, .. } | End::Late { time, .. } => Some(*time),
        End::Finished => None,
    }
}

fn words(ran: &Ran) -> String {
    match &ran.end {
        End::Derailed { words, .. } | End::Stopped { words, .. } => words.clone(),
        End::Late { limit, .. } => format!("after {limit} s"),
        End::Finished => String::new(),
    }
}

/// Ends that belong to the model and not to its integration.
fn end_class(words: &str) -> Class {
    let physical = ["would have to pull", "profile reaches only", "travelling speed has fallen", "derailed"];
    if physical.iter().any(|part| words.contains(part)) { Class::Derailed } else { Class::GaveUp }
}

/// A tight run of the scene, and whether an explicit method made it.
fn reference(drawn: &RandomScene, look: &Look) -> Result<(Ran, bool), String> {
    match tight(drawn, look, ("dormand_prince", "1e-9"), [0.0; 2]) {
        Ok(first) => Ok((first, true)),
        Err(_) => Ok((tight(drawn, look, ("rosenbrock", "1e-9"), [0.0; 2])?, false)),
    }
}

/// Another tight run beside such a one.
fn second_reference(drawn: &RandomScene, look: &Look, explicit: bool) -> Result<Ran, String> {
    let implicit = || tight(drawn, look, ("rosenbrock", "1e-8"), [0.0; 2]);
    if explicit { tight(drawn, look, ("rk43", "1e-8"), [0.0; 2]).or_else(|_| implicit()) } else { implicit() }
}

/// Ways to move bodies aside: signs of even and of odd ones. Each way meets a scene's sensitive motion more or less.
const WAYS: [[f64; 2]; 4] = [[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];

/// The scene from a start that is moved aside by half of what y may be off by: without amplification it says no more than the bounds.
fn shaken(drawn: &RandomScene, look: &Look, way: [f64; 2]) -> Result<Ran, String> {
    let aside = 0.5 * if drawn.fixed { OF_FIXED_STEPS } else { bound_of_y(drawn.setting) };
    let finished = |method| {
        let ran = tight(drawn, look, method, way.map(|sign| sign * aside))?;
        if matches!(ran.end, End::Finished) { Ok(ran) } else { Err(words(&ran)) }
    };
    finished(("dormand_prince", "1e-9")).or_else(|_| finished(("rosenbrock", "1e-8")))
}

/// A run with an integrator and its tolerance that did not give up. At the start y and yaw of even and odd bodies are moved `aside` (m, rad).
fn tight(drawn: &RandomScene, look: &Look, (integrator, tolerance): (&str, &str), aside: [f64; 2]) -> Result<Ran, String> {
    let look = Look { limit: REFERENCE_LIMIT, ..*look };
    // Everything computed costs the references of some scenes more time than a test has.
    let mode = if drawn.seed.is_multiple_of(3) { "effects.mode=all" } else { "effects.mode=auto" };
    guarded(|| {
        let scene = open_with(drawn, &[mode, &format!("solver.integrator={integrator}"), &format!("solver.tolerance={tolerance}")])?;
        let mut simulation = Simulation::new(&scene, 0.0).map_err(|error| error.to_string())?;
        if aside != [0.0; 2] {
            move_aside(&mut simulation, aside)?;
        }
        let ran = run(&scene, &mut simulation, &look);
        match &ran.end {
            End::Late { .. } => Err(format!("{integrator} needs more than {} s", look.limit)),
            End::Stopped { words, .. } if end_class(words) == Class::GaveUp => Err(words.clone()),
            _ => Ok(ran),
        }
    })
    .and_then(|done| done)
}

fn move_aside(simulation: &mut Simulation, aside: [f64; 2]) -> Result<(), String> {
    let mut state = simulation.state().clone();
    for body in 0..simulation.model().system.bodies.len() {
        let coordinates = &mut state.integration.y[simulation.model().system.coordinates(body)];
        coordinates[LATERAL] += aside[body % 2];
        coordinates[YAW] += aside[body % 2];
    }
    if simulation.restore(&state) { Ok(()) } else { Err("the moved state does not fit".into()) }
}

/// What the books say against a run, where shares `unbooked` of energy and weight can't be told on this grid.
fn broken(audit: &Audit, unbooked: [f64; 2]) -> Option<(String, f64)> {
    told(&audit.findings(unbooked))
}

/// Those that do not hold, in words, and how many times its bound the worst of them is.
fn told(findings: &[Finding]) -> Option<(String, f64)> {
    let wrong: Vec<&Finding> = findings.iter().filter(|finding| !finding.holds()).collect();
    let strain = wrong.iter().map(|finding| finding.strain()).fold(0.0, f64::max);
    (!wrong.is_empty()).then(|| (wrong.iter().map(|finding| finding.words()).collect::<Vec<_>>().join("; "), strain))
}

/// m, of a tolerance.
fn bound_of_y(tolerance: f64) -> f64 {
    (20.0 * tolerance).clamp(1e-5, 5e-4)
}

/// What is further from the reference than it may be, or than half of how far a start that was moved aside is from it.
fn distances(drawn: &RandomScene, ran: &Ran, right: [&Ran; 2], shaken: Option<&Trace>) -> Option<(String, f64)> {
    let finding = |(quantity, bound): (Quantity, f64)| {
        let bound = shaken.map_or(bound, |shaken| bound.max(2.0 * shaken.distance(&right[0].trace, quantity, true, 0.0).0));
        let (size, time) = ran.trace.distance(&right[0].trace, quantity, true, 0.0);
        let what = format!("error of {} at t = {time:.4} s", quantity.words());
        match quantity.is_force() {
            true => Finding::new(what, size / ran.load, bound / ran.load, super::super::Unit::Share),
            false => Finding::new(what, size, bound, quantity.unit()),
        }
    };
    told(&bounds(drawn, ran, right).map(finding))
}

/// Quantities that are off, and when first by more than they may be, s.
fn wrong_at(drawn: &RandomScene, ran: &Ran, right: [&Ran; 2]) -> Vec<(Quantity, f64)> {
    let first = |(quantity, bound)| ran.trace.first_beyond(&right[0].trace, quantity, bound).map(|time| (quantity, time));
    bounds(drawn, ran, right).into_iter().filter_map(first).collect()
}

/// How far y and Q may be off.
fn bounds(drawn: &RandomScene, ran: &Ran, [first, second]: [&Ran; 2]) -> [(Quantity, f64); 2] {
    let (y, q) = (first.trace.largest(Quantity::Y), first.trace.largest(Quantity::Vertical));
    let [of_y, of_q] = match drawn.fixed {
        true => [(0.03 * y).max(OF_FIXED_STEPS), 0.1 * q.max(ran.load)],
        false => [bound_of_y(drawn.setting), 0.03 * q.max(ran.load)],
    };
    [(Quantity::Y, of_y), (Quantity::Vertical, of_q)].map(|(quantity, bound)| {
        let unsure = first.trace.distance(&second.trace, quantity, true, 0.0).0;
        (quantity, if unsure > bound / 3.0 { 3.0 * unsure } else { bound })
    })
}
