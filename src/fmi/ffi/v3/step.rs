//! fmi3DoStep: to the end of the step, or early at an event or at the host's wish, with the host's own function called on the way.
//!
//! The instance is let go before that function is called, which may use it.

use super::super::common::{guard, refuse};
use super::super::component::Component as Instance;
use super::super::remarks;
use super::super::session::{Boolean, FALSE, IntermediateUpdate};
use super::super::types::{Component as Fmi3Instance, Status};
use super::call;
use crate::fmi::instance::{Pace, StepOutcome};

/// A step under way.
#[derive(Default)]
struct Under {
    /// As the host has asked for, s.
    end: f64,
    /// Sooner where it has asked for an early return meanwhile, s.
    target: f64,
    /// Of the integrator, when it began.
    steps: u64,
    event: bool,
    terminate: bool,
    status: Option<Status>,
}

/// How a step goes on.
enum Next {
    /// No further.
    Stop,
    /// To the next stop.
    On,
    /// The host's function is called with the time, and whether the step may end early; then on.
    Update(IntermediateUpdate, f64, bool),
}

/// # Safety
/// The instance must be null or come from this library, the other pointers null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    c: Fmi3Instance,
    current_communication_point: f64,
    communication_step_size: f64,
    _no_set_state_prior: Boolean,
    event_handling_needed: *mut Boolean,
    terminate_simulation: *mut Boolean,
    early_return: *mut Boolean,
    last_successful_time: *mut f64,
) -> Status {
    let mut under = Under::default();
    let begun = call(c, "fmi3DoStep", |component| {
        if [event_handling_needed, terminate_simulation, early_return].iter().any(|flag| flag.is_null()) || last_successful_time.is_null() {
            return refuse(component, "fmi3DoStep: a pointer is NULL");
        }
        match component.instance.step_end(current_communication_point, communication_step_size) {
            Ok(end) => {
                (under.end, under.target) = (end, end);
                under.steps = component.instance.integrator_steps();
                component.instance.keep_begin();
                Status::Ok
            }
            Err(error) => refuse(component, &error.to_string()),
        }
    });
    if begun != Status::Ok {
        return begun;
    }
    loop {
        let mut next = Next::Stop;
        let status = guard(c, |component| advance(component, &mut under, &mut next));
        if !matches!(status, Status::Ok | Status::Warning) {
            return status;
        }
        under.status = if status == Status::Warning { Some(status) } else { under.status };
        match next {
            Next::Stop => break,
            Next::On => {}
            Next::Update(update, time, may_return) => {
                let asked = unsafe { ask(c, update, time, may_return, &mut under) };
                if asked != Status::Ok {
                    return asked;
                }
                if under.target <= time {
                    break;
                }
            }
        }
    }
    let mut time = f64::NAN;
    let done = guard(c, |component| {
        time = component.instance.time();
        component.last_step = under.status.unwrap_or(Status::Ok);
        component.derailed = under.terminate;
        component.last_step
    });
    // Early without leave is not said: a derailment ends the step all the same, and the time tells where.
    let early = time < under.end && unsafe { allows_early_return(c) };
    unsafe {
        event_handling_needed.write(under.event.into());
        terminate_simulation.write(under.terminate.into());
        early_return.write(early.into());
        last_successful_time.write(time);
    }
    done
}

/// # Safety
/// The instance must be null or come from this library.
unsafe fn allows_early_return(c: Fmi3Instance) -> bool {
    unsafe { c.cast::<Instance>().as_ref() }.is_some_and(|component| component.session.early_return)
}

/// From one stop to the next, or through where nobody waits at stops.
fn advance(component: &mut Instance, under: &mut Under, next: &mut Next) -> Status {
    let session = &component.session;
    let (event_mode, may_return, update) = (session.event_mode, session.early_return, session.update);
    let pace = if event_mode && may_return || update.is_some() { Pace::ToStop } else { Pace::Through };
    let (events, doubt) = match component.instance.advance(under.target, pace) {
        Ok(StepOutcome::Done) => (Vec::new(), None),
        Ok(StepOutcome::DoneWithRemarks(events, doubt)) => (events, doubt),
        Ok(StepOutcome::Discarded(error, events)) => {
            remarks(component, &events);
            let time = component.instance.time();
            if error.is_derailed() {
                component.log.remark(&format!("the run ends at t = {time} s: {error}"));
                under.terminate = true;
                return Status::Ok;
            }
            component.instance.take_back();
            let begin = component.instance.time();
            component.last_step = Status::Discard;
            let message = format!("the step can't be made beyond t = {time} s: {error}; the instance stands at its begin, t = {begin} s");
            component.log.error(Status::Discard, &message);
            return Status::Discard;
        }
        Err(error) => return refuse(component, &error.to_string()),
    };
    let mut status = remarks(component, &events);
    if let Some(doubt) = doubt {
        component.log.remark(&doubt);
        status = Status::Warning;
    }
    let time = component.instance.time();
    let reached = time >= under.target;
    under.event |= event_mode && !events.is_empty();
    // Looked at once for each step of the integrator, however often the host comes by.
    let looks = match may_return {
        true => component.instance.is_at_stop(),
        false => reached && component.instance.integrator_steps() != under.steps,
    };
    if event_mode && looks && !under.event {
        under.event = component.instance.discrete_outputs_are_late();
    }
    let stops = reached || under.event && may_return;
    if !stops {
        *next = update.map_or(Next::On, |update| Next::Update(update, time, may_return));
        component.session.updating = update.is_some();
    }
    status
}

/// # Safety
/// The instance must come from this library, and not be held.
unsafe fn ask(c: Fmi3Instance, update: IntermediateUpdate, time: f64, may_return: bool, under: &mut Under) -> Status {
    let (mut wanted, mut at) = (FALSE, time);
    let environment = unsafe { c.cast::<Instance>().as_ref() }.map_or(std::ptr::null_mut(), |component| component.session.environment.0);
    unsafe { update(environment, time, true, true, true, may_return, &mut wanted, &mut at) };
    guard(c, |component| {
        component.session.updating = false;
        if wanted == FALSE {
            return Status::Ok;
        }
        if !may_return || at.is_nan() {
            let why = if may_return { "earlyReturnTime is not a number" } else { "an early return was asked for that is not allowed" };
            component.instance.take_back();
            return refuse(component, &format!("intermediateUpdate: {why}"));
        }
        under.target = at.clamp(time, under.target);
        Status::Ok
    })
}
