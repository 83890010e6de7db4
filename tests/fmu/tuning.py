"""tuning.py FMU

Tunable parameters: set between steps, in force from the next step on, part of the state.
"""

import numpy as np
from fmpy.fmi1 import FMICallException

from common import FRICTION, MASS, W, Fmu, grid, main

TUNED, BACK, STOP, STEP = 0.6, 0.8, 1.0, 0.01  # s; the disturbance is at 0.5 s to 0.75 s
MU = "contact.friction"


def described(report, fmu):
    report.section("description")
    kinds = {v.name: v.variability for v in fmu.description.modelVariables if v.causality == "parameter"}
    for name in (MU, "contact.damping", "solver.tolerance"):
        report.check(kinds.get(name) == "tunable", name, str(kinds.get(name)))
    for name in (f"{W}.mass", "speed", "contact.youngsModulus", f"{W}.initial.y"):
        report.check(kinds.get(name) == "fixed", name, str(kinds.get(name)))
    springs = [name for name in kinds if name.startswith(f"{W}.suspension.")]
    report.check(springs and all(kinds[name] == "tunable" for name in springs), "the suspension", f"{len(springs)} parameters")
    return springs


def midway(report, fmu, springs):
    report.section("tuned in the middle of a run")
    values = {MU: 0.15, "contact.damping": 2e4, "solver.tolerance": 1e-7}
    values |= {name: 0.7 * float(fmu.variables[name].start) for name in springs}
    first, second = grid(BACK, STEP, TUNED), grid(STOP, STEP, BACK)
    after = first + second
    with fmu.instance() as plain, fmu.instance() as instance, fmu.instance({MU: 0.3}) as other:
        plain.run(grid(TUNED, STEP), [])
        untouched = plain.run(after)
        instance.run(grid(TUNED, STEP), [])
        before = instance.slave.getFMUState()
        data = instance.slave.serializeFMUState(before)
        instance.set(values)
        report.same_bits(instance.get(*values), list(values.values()), "tuned values can be read")
        head = instance.run(first)
        late = instance.slave.getFMUState()
        late_data = instance.slave.serializeFMUState(late)
        tail = instance.run(second)
        tuned = np.vstack((head, tail))
        report.check(not np.array_equal(tuned, untouched), "they make a difference")

        state = other.slave.deserializeFMUState(data)
        other.slave.setFMUState(state)
        other.time = TUNED
        report.near(other.get(MU), FRICTION, 0.0, "a state brings its values")
        other.set(dict(reversed(values.items())))
        report.same_bits(other.run(after), tuned, "another instance, from the saved state with the new values")

        instance.slave.setFMUState(before)
        instance.time = TUNED
        report.near(instance.get(MU), FRICTION, 0.0, "back across the change: the old value")
        report.same_bits(instance.run(after), untouched, "and the run without the change")
        for each, slave_state in ((instance, late), (other, other.slave.deserializeFMUState(late_data))):
            each.slave.setFMUState(slave_state)
            each.time = BACK
            report.same_bits(each.get(*values), list(values.values()), "forward across it: the new values")
            report.same_bits(each.run(second), tail, "and the tuned run")
        instance.slave.reset()
        report.near(instance.get(MU), FRICTION, 0.0, "reset: as exported")


def refused(report, fmu):
    report.section("refused")
    times = grid(0.3, STEP)
    with fmu.instance() as plain:
        expected = plain.run(times)
    with fmu.instance() as instance:
        for name, value, words, held in ((MU, -0.1, "smallest value", FRICTION), (MU, float("nan"), "finite", FRICTION),
                                         (f"{W}.mass", 2000.0, "fixed", MASS)):
            try:
                instance.set({name: value})
                report.check(False, f"{name} = {value}", "was taken")
            except FMICallException:
                report.check(words in instance.log[-1][1] and instance.get(name) == held, f"{name} = {value}", instance.log[-1][1])
        report.same_bits(instance.run(times), expected, "the run is that without the attempts")


def script(report, path):
    with Fmu(path) as fmu:
        springs = described(report, fmu)
        midway(report, fmu, springs)
        refused(report, fmu)


if __name__ == "__main__":
    main(script)
