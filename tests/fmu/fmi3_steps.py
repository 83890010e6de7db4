"""fmi3_steps.py FMU FOLDER

Steps of FMI 3.0: intermediate update, early return, event mode, derailment, steps that can't be made. FMU is the shipped scene for FMI 2.0; FOLDER
holds for FMI 3.0 three.fmu (the same scene), dip.fmu (rigid contact, a dip in which a wheel lifts off and lands again), stop.fmu (the same, where lift-off
ends the run), bounce.fmu (elastic contact over that dip) and flange.fmu (a wheelset with flanges, elastic).
"""

import os
import re

import numpy as np
from fmpy.fmi1 import FMICallException

from common import INPUTS, TORQUE, W, grid, main
from common3 import DISCARD, ERROR, OK, Fmu3

STEP, STOP = 0.05, 0.8  # s
LATERAL, VERTICAL = INPUTS[1:3]
SEEN = (f"{W}.y", f"{W}.left.verticalForce", f"{W}.contacts")[:2]


class Updates:
    """An intermediateUpdate function that notes what it is told and does what a test wants."""

    def __init__(self, act=None):
        self.act, self.instance, self.told, self.wish = act, None, [], None

    def __call__(self, _environment, time, set_requested, get_allowed, finished, can_return, requested, at):
        self.told.append((time, set_requested, get_allowed, finished, can_return))
        if self.act:
            self.act(self, time)
        if self.wish is not None:
            requested[0], at[0] = True, self.wish

    @property
    def times(self):
        return [told[0] for told in self.told]


def start(fmu, values=None, updates=None, required=SEEN + (TORQUE, LATERAL), **options):
    instance = fmu.instance(values, update=updates, required=required, **options) if updates else fmu.instance(values, **options)
    if updates:
        updates.instance = instance
    return instance


def updates_change_nothing(report, fmu):
    report.section("intermediate update: reading")
    times, rows = grid(STOP, STEP), []

    def look(updates, _time):
        rows.append(updates.instance.slave.getFloat64(fmu.references(SEEN)))

    updates = Updates(look)
    with start(fmu) as plain, start(fmu, updates=updates) as instance:
        for each in (plain, instance):
            each.set({TORQUE: 500.0})
        report.same_bits(instance.run(times), plain.run(times), "results with updates, and without")
        told = np.array(updates.times)
        report.check(len(told) > 30 and np.all(np.diff(told) > 0) and told[0] >= 0 and told[-1] <= STOP, "times grow", f"{len(told)} updates")
        report.check(all(each[1:] == (True, True, True, False) for each in updates.told), "what may be done is said")
    with start(fmu) as again:
        again.set({TORQUE: 500.0})
        # The same places, as communication points of another instance.
        again.run([time for time in updates.times if time > 0], [])
        found = [row for row in rows if row]
        report.same_bits(found[-1], again.get(*SEEN), "what was read there is the state there")


def updates_set_inputs(report, fmu):
    report.section("intermediate update: setting inputs")
    force = lambda time: 4e3 * np.sin(20 * time)
    updates = Updates(lambda own, time: own.instance.slave.setFloat64(fmu.references([LATERAL]), [force(time)]))
    with start(fmu, updates=updates) as instance, start(fmu) as other:
        instance.step(0.2)
        for time in updates.times:
            other.step(time)
            other.set({LATERAL: force(time)})
        other.step(0.2)
        report.check(len(updates.times) > 10, "updates", f"{len(updates.times)} in 0.2 s")
        report.same_bits(instance.outputs(), other.outputs(), "as communication steps to the same places")
        report.near(instance.get(LATERAL), force(updates.times[-1]), 0.0, "the input holds its last value", "N")


def updates_are_fenced(report, fmu):
    report.section("intermediate update: what is refused in it")
    tried, seen = [], []

    def wrong(own, _time):
        slave, component = own.instance.slave, own.instance.slave.component
        for what, call in {
            "an output that was not named": lambda: slave.getFloat64(fmu.references([f"{W}.z"])),
            "an input that was not named": lambda: slave.setFloat64(fmu.references([VERTICAL]), [1.0]),
            "an output set": lambda: slave.setFloat64(fmu.references([f"{W}.y"]), [1.0]),
            "a step in a step": lambda: slave.doStep(0.0, 1.0),
            "terminate": slave.terminate, "reset": slave.reset, "event mode": slave.enterEventMode,
            "a state": slave.getFMUState, "a number": lambda: slave.getFloat64(fmu.references(["solver.steps"])),
        }.items():
            before = len(own.instance.log)
            try:
                call()
                tried.append((what, OK, ""))
            except FMICallException as failure:
                tried.append((what, failure.status, own.instance.log[before][1] if len(own.instance.log) > before else ""))
        slave.fmi3FreeInstance(component)
        seen.append(slave.getFloat64(fmu.references(SEEN))[0])

    updates = Updates(wrong)
    with start(fmu, updates=updates) as instance, start(fmu) as plain:
        instance.step(0.1)
        plain.step(0.1)
        for what in dict.fromkeys(each[0] for each in tried):
            statuses = {(status, bool(text)) for name, status, text in tried if name == what}
            report.check(statuses == {(ERROR, True)}, what, next(text for name, _, text in tried if name == what))
        report.same_bits(instance.outputs(), plain.outputs(), "and nothing has changed")
        report.check(len(seen) == len(updates.told), "what was named is read all the same")
    try:
        fmu.instance(required=("solver.tolerance",)).free()
        report.check(False, "a parameter named for updates")
    except Exception as failure:  # fmpy raises a plain Exception
        report.check(True, "a parameter named for updates", str(failure))


def early_returns(report, fmu):
    report.section("early return on request")
    for wish, what in ((0.0, "at once"), (0.015, "at a time between")):
        def act(own, time):
            if time > 0.1:
                own.wish = time + wish

        updates = Updates(act)
        with start(fmu, updates=updates, early=True) as instance, start(fmu) as plain:
            event, terminate, early = instance.step(0.5)
            last = updates.times[-1]
            expected = updates.times[[t > 0.1 for t in updates.times].index(True)] + wish
            report.check(early and not event and not terminate, what, f"{instance.time} s of 0.5 s, last update {last} s")
            report.check(instance.time <= expected if wish else instance.time == expected, "not later than asked for", f"{expected} s")
            plain.step(instance.time)
            report.same_bits(instance.outputs(), plain.outputs(), "the state there")
            updates.act, updates.wish = None, None
            instance.step_to(0.5), plain.step_to(0.5)
            report.same_bits(instance.outputs(), plain.outputs(), "and on from there")
    for what, wish, options in (("not allowed", 0.3, {}), ("not a number", float("nan"), {"early": True})):
        updates = Updates()
        updates.wish = wish
        with start(fmu, updates=updates, **options) as instance:
            before = instance.bytes()
            status, messages = instance.try_step(0.5)
            report.check(status == ERROR and messages, what, messages[-1][1] if messages else "no message")
            report.check(instance.bytes() == before, "and the step is not begun")


def collect(instance, stop, step):
    """Runs and handles events; rows at the grid, and (time, early, counts before and after the update, messages) of each event."""
    rows, events = [], []
    for time in grid(stop, step):
        while instance.time < time:
            before, log = instance.counts(), len(instance.log)
            event, terminate, early = instance.step(time)
            if event:
                held = instance.counts()
                instance.slave.enterEventMode()
                ended = instance.settle()
                events.append((instance.time, early, before, held, instance.counts(), [t for _, t in instance.log[log:]]))
                terminate |= ended
            if terminate:
                return np.array(rows), events
        rows.append(instance.outputs())
    return np.array(rows), events


def events_of(report, what, fmu, stop, prepare=None, values=None, step=0.02):
    """Event mode with and without early return, against a host without events: the same results, and when what happened."""
    report.section(f"event mode: {what}")
    prepare = prepare or (lambda instance: None)
    with fmu.instance(values) as plain:
        prepare(plain)
        expected = plain.run(grid(stop, step))
        log = [text for _, text in plain.log]
    with fmu.instance(values, events=True, early=True) as instance:
        prepare(instance)
        rows, events = collect(instance, stop, step)
    with fmu.instance(values, events=True) as late:
        prepare(late)
        late_rows, late_events = collect(late, stop, step)
    report.same_bits(rows, expected, "early returns at events: results at the same times")
    report.same_bits(late_rows, expected, "without early return")
    report.check(len(events) > 0 and all(early or any(abs(t - g) < 1e-12 for g in grid(stop, step)) for t, early, *_ in events),
                 "steps end early at events", f"{len(events)} events, {len(log)} messages")
    report.check(all(before == held for _, _, before, held, _, _ in events), "discrete outputs wait for event mode")
    after = [each[4] for each in events]
    report.check(all(a == b for (_, _, _, _, a, _), (_, _, b, _, _, _) in zip(events, events[1:])), "and stay until the next one")
    for time, _, _, _, counts, texts in events:
        for text in texts:
            at = re.match(r"t = ([0-9.]+) s, ", text)
            if at:
                report.near(time, float(at[1]), 1e-9, text[:110], "s")
    ends = {round(time / step + 0.499999) for time, *_ in events}
    found = {round(time / step) for time, *_ in late_events}
    # What is over by the end of its step has not been, for a host without early return.
    near = all(min(abs(each - end) for end in ends) <= 1 for each in found)
    report.check(found and near and not any(early for _, early, *_ in late_events), "without early return: at the ends of such steps",
                 f"{len(found)} of {len(ends)} with an event, {round(stop / step)} in all")
    report.note(f"contacts (left, right) after each event: {after}")
    return events


def derailment(report, fmu):
    report.section("derailment")
    for early in (True, False):
        with fmu.instance({"contact.friction": 0.6}, early=early, events=early) as instance:
            instance.set({VERTICAL: 60e3})
            time, terminate = 0.0, False
            for time in grid(1.0, 0.002):
                instance.set({LATERAL: 150e3 * time / 0.2})
                while instance.time < time and not terminate:
                    event, terminate, returned = instance.step(time)
                    if event and not terminate:
                        instance.slave.enterEventMode()
                        terminate = instance.settle()
                if terminate:
                    break
            text = instance.log[-1][1] if instance.log else ""
            report.check(terminate and "derailed" in text, "terminateSimulation", text)
            report.check(returned == early and instance.time <= time, "early return is said where it is allowed", f"{instance.time} s of {time} s")
            report.check(np.all(np.isfinite(instance.outputs())), "outputs can be read")
            again = instance.step(instance.time + 0.01)
            report.check(again[1], "it stays so")


def discarded(report, fmu):
    report.section("a step that can't be made")
    for options in ({}, {"early": True, "events": True}):
        with fmu.instance(**options) as instance:
            status = OK
            # The wheel lifts at 0.5 s to rounding: no communication point stands there.
            for time in grid(1.0, 0.03):
                before, begin, outputs = instance.bytes(), instance.time, instance.outputs()
                status, messages = instance.try_step(time)
                if status != OK:
                    break
            report.check(status == DISCARD, "fmi3Discard", messages[-1][1] if messages else "no message")
            report.check(instance.time == begin and instance.bytes() == before, "the FMU is in the state before the call", f"t = {begin} s")
            report.same_bits(instance.outputs(), outputs, "outputs")
            status, _ = instance.try_step(begin + 0.001)
            report.check(status == OK, "a shorter step can be made")


def script(report, _two, folder):
    named = lambda name: Fmu3(os.path.join(folder, f"{name}.fmu"))
    with named("three") as fmu:
        updates_change_nothing(report, fmu)
        updates_set_inputs(report, fmu)
        updates_are_fenced(report, fmu)
        early_returns(report, fmu)
    with named("dip") as fmu:
        events = events_of(report, "a wheel of rigid contact lifts off and lands", fmu, 0.8)
        texts = " ".join(" ".join(each[5]) for each in events)
        report.check("normal force fell to zero" in texts and "has settled" in texts, "lift-off and landing are among them")
    with named("bounce") as fmu:
        events = events_of(report, "a wheel of elastic contact leaves its rail and strikes it", fmu, 0.8)
        right = [counts[1] for *_, counts, _ in events]
        report.check(0 in right and right[-1] == 1, "the right wheel is in the air, and comes back", str(right))
    with named("flange") as fmu:
        push = lambda instance: instance.set({LATERAL: 28e3})
        events = events_of(report, "flange contact", fmu, 0.4, push)
        left = [counts[0] for *_, counts, _ in events]
        report.check(max(left) == 2, "the left wheel has two contacts", str(left))
        derailment(report, fmu)
    with named("stop") as fmu:
        discarded(report, fmu)


if __name__ == "__main__":
    main(script, "FOLDER")
