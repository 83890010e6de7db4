"""derailment.py FMU FOLDER

Flange contact and derailment through the FMU's interface. FOLDER holds exports of a wheelset with flanges, NAME.fmu for some
formulations; in NAME-stop.fmu a wheel that lifts off ends the run. FMU is the shipped scene and not used.
"""

import pathlib
import re

import numpy as np
from fmpy.fmi2 import fmi2Discard, fmi2OK, fmi2Warning

from common import LAST_SUCCESSFUL_TIME, W, Fmu, columns, grid, main

LATERAL, VERTICAL = f"{W}.lateralForceInput", f"{W}.verticalForceInput"
FLANGE = f"{W}.left.contact[2]"
DO_STEP_STATUS, TERMINATED = 0, 3
STEP = 2e-3  # s


def push(instance, force, ramp):
    """A lateral force that grows from now on."""
    instance.set({LATERAL: force})
    instance.set_derivatives(LATERAL, ramp)


def flange_contact(report, name, fmu):
    report.section(f"{name}: flange contact begins and ends")
    found, rows = [], []
    with fmu.instance() as instance:
        for begin, end, force, ramp in ((0.0, 0.5, 0.0, 60e3), (0.5, 1.0, 30e3, -60e3), (1.0, 1.5, 0.0, 0.0)):
            push(instance, force, ramp)
            for time in grid(end, STEP, begin):
                status, messages = instance.try_step(time)
                rows.append(np.append(instance.outputs(), status))
                found += [(time, *message) for message in messages]
        report.check(not instance.slave.getBooleanStatus(TERMINATED), "fmi2Terminated is false")
    rows = np.array(rows)
    report.check(np.all(rows[:, -1] == fmi2OK), "fmi2OK in every step")
    run = columns(fmu, rows[:, :-1])
    force = run[f"{FLANGE}.normalForce"]
    report.check(np.max(force) > 5e3 and force[0] == force[-1] == 0.0, f"{FLANGE}.normalForce", f"0 to {np.max(force):.1f} to 0 N")
    words = [re.search(r"left wheel: contact 2 (begins|ends)", text) for _, _, text in found]
    kinds = [word[1] for word in words if word]
    report.check(len(kinds) == len(found) > 0 and all(status == fmi2OK for _, status, _ in found), "the log says so, with fmi2OK",
                 "; ".join(text for _, _, text in found))
    report.check(kinds == ["begins", "ends"] * (len(kinds) // 2), "begin and end take turns", f"{len(kinds)} messages")
    for time, _, text in found:
        at = float(re.match(r"t = ([0-9.]+) s, wheelset, ", text)[1])
        # The integrator may be ahead of the communication point by one of its steps.
        report.between(time - STEP - 1e-9, at, time + 0.02, "time in the message", "s")
        index = round(time / STEP) - 1
        before, after = force[max(0, index - 1)], force[min(len(force) - 1, index + 12)]
        report.check((before == 0.0) if "begins" in text else (after == 0.0), "the force has the same tale to tell",
                     f"{before:.3g} N, later {after:.3g} N")


def runs_on(status):
    """A wheel with rigid contact that lifts off is a warning."""
    return status in (fmi2OK, fmi2Warning)


SCENARIO = {"contact.friction": 0.6, "solver.tolerance": 1e-7}


def only_stops(report, name, fmu):
    report.section(f"{name}: a step that ends early for another reason")
    with fmu.instance(SCENARIO) as instance:
        instance.set({VERTICAL: 60e3})
        push(instance, 0.0, 150e3 / 0.2)
        for time in grid(0.2, STEP):
            status, messages = instance.try_step(time)
            if status != fmi2OK:
                break
        report.check(status == fmi2Discard, "fmi2DoStep: fmi2Discard", messages[-1][1] if messages else "")
        report.check(not instance.slave.getBooleanStatus(TERMINATED), "fmi2Terminated is false")


def derails(report, name, fmu):
    report.section(f"{name}: derailment")
    with fmu.instance(SCENARIO) as instance, fmu.instance(SCENARIO) as other:
        for each in (instance, other):
            each.set({VERTICAL: 60e3})
            push(each, 0.0, 150e3 / 0.2)
        state, last, finite = None, 0.0, True
        for time in grid(5.0, STEP):
            if state is None and time > 0.02:
                state, kept = instance.slave.getFMUState(), instance.time
            if abs(time - STEP - 0.2) < 1e-9:
                push(instance, 150e3, 0.0)
            last, row = instance.time, instance.outputs()
            status, messages = instance.try_step(time)
            finite = finite and np.all(np.isfinite(row))
            if not runs_on(status):
                break
        slave = instance.slave
        report.check(finite, "outputs are finite all the way")
        report.check(status == fmi2Discard, "fmi2DoStep: fmi2Discard", f"status {status} in the step to {time:.4f} s")
        report.check(slave.getStatus(DO_STEP_STATUS) == fmi2Discard, "fmi2GetStatus says so too")
        report.check(slave.getBooleanStatus(TERMINATED) is True, "fmi2GetBooleanStatus(fmi2Terminated) is true")
        reached = slave.getRealStatus(LAST_SUCCESSFUL_TIME)
        report.check(last <= reached <= time, "last successful time lies in the step", f"{last:.4f} <= {reached!r} <= {time:.4f}")
        text = messages[-1][1] if messages else ""
        report.check(messages and messages[-1][0] == fmi2Discard and "derailed" in text, "the log says derailed", text)
        outputs = instance.outputs()
        report.check(np.all(np.isfinite(outputs)), "outputs are finite and can be read", f"{outputs.size} values")
        report.check(abs(instance.get(f"{W}.y")) > 8e-3, f"{W}.y", f"{instance.get(f'{W}.y'):.4f} m")
        status, messages = instance.try_step(reached + STEP)
        report.check(status == fmi2Discard and slave.getBooleanStatus(TERMINATED), "tried again, the same")
        report.near(slave.getRealStatus(LAST_SUCCESSFUL_TIME), reached, STEP, "it goes no further", "s")

        slave.setFMUState(state)
        slave.freeFMUState(state)
        instance.time = kept
        report.check(not slave.getBooleanStatus(TERMINATED) and slave.getStatus(DO_STEP_STATUS) == fmi2OK,
                     "an earlier state put back: not terminated", f"t = {kept:.3f} s")
        other.run(grid(kept, STEP), [])
        for each in (instance, other):
            push(each, 0.0, 0.0)
        times = grid(kept + 1.0, STEP, kept)
        report.same_bits(instance.run(times), other.run(times), "goes on like one that never derailed")
        report.check(not slave.getBooleanStatus(TERMINATED), "not terminated after it")

        push(instance, 150e3, 0.0)
        status = fmi2OK
        for time in grid(instance.time + 5.0, STEP, instance.time):
            status, _ = instance.try_step(time)
            if not runs_on(status):
                break
        report.check(status == fmi2Discard and slave.getBooleanStatus(TERMINATED), "pushed again, it derails again")
        slave.reset()
        instance.start()
        report.check(not slave.getBooleanStatus(TERMINATED), "fmi2Reset: not terminated")
        with fmu.instance() as fresh:
            report.same_bits(instance.run(grid(0.1, STEP)), fresh.run(grid(0.1, STEP)), "and as new")


def script(report, _shipped, folder):
    for path in sorted(pathlib.Path(folder).glob("*.fmu")):
        with Fmu(path) as fmu:
            if path.stem.endswith("-stop"):
                only_stops(report, path.stem, fmu)
                continue
            flange_contact(report, path.stem, fmu)
            derails(report, path.stem, fmu)


if __name__ == "__main__":
    main(script, "FOLDER")
