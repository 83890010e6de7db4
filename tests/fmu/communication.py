"""communication.py FMU

The communication pattern must not matter: step sizes, getting outputs, the way an input is handed over.
"""

import random

import numpy as np

from common import CLEAR, INPUTS, TORQUE, W, Fmu, grid, main

PLACE = (f"{W}.y", f"{W}.z", f"{W}.yaw")
STOP = 2.0  # s, the disturbance is at 0.5 s to 0.75 s


def irregular(marks, seed):
    """Steps of 0.1 ms to 25 ms that meet the marks."""
    chance, times, time = random.Random(seed), [], 0.0
    for mark in marks:
        while mark - time > 1e-9:
            time += chance.choice((1e-4, 7e-4, 1e-3, 2.5e-3, 0.0137, 0.025)) * (0.5 + chance.random() / 2)
            time = mark if time > mark - 1e-4 else time
            times.append(time)
    return times


def step_sizes(report, fmu):
    report.section("step sizes")
    marks = grid(STOP, 0.05)
    patterns = {"1 ms": grid(STOP, 1e-3), "10 ms": grid(STOP, 1e-2), "50 ms": marks,
                "irregular": irregular(marks, 1), "irregular, other": irregular(marks, 2)}
    found = {}
    for name, times in patterns.items():
        with fmu.instance() as instance:
            rows = instance.run(times, PLACE)
        at = np.searchsorted(np.array(times), np.array(marks) - 1e-9)
        found[name] = rows[at]
    report.note(f"largest |y| at the {len(marks)} common times: {np.max(np.abs(found['1 ms'][:, 0])):.3e} m")
    for name in list(patterns)[1:]:
        difference = np.max(np.abs(found[name] - found["1 ms"]), axis=0)
        for quantity, value in zip(PLACE, difference):
            report.below(value, 1e-9, f"{quantity}, {name} ({len(patterns[name])} steps) and 1 ms")

    report.section("getting values")
    times = irregular(grid(1.0, 0.05), 3)
    with fmu.instance() as instance:
        for time in times:
            instance.step_to(time)
        silent = instance.outputs()
    with fmu.instance() as instance:
        for time in times:
            instance.step_to(time)
            instance.outputs()
            instance.derivatives(*PLACE)
            instance.outputs()
        report.same_bits(instance.outputs(), silent, f"outputs got or not in {len(times)} steps")
    with fmu.instance(stop=1.0) as instance:
        report.same_bits(instance.run(times)[-1], silent, "stop time told or not")


def hold(fmu, quantity, name, law, stop, step, marks):
    """The input as a staircase through setReal alone, held at its value at the start of each step."""
    with fmu.instance(CLEAR) as instance:
        rows = []
        for time in grid(stop, step):
            instance.set({name: law(instance.time)})
            instance.step_to(time)
            if np.min(np.abs(marks - time)) < 1e-9:
                rows.append(instance.get(quantity))
        return np.array(rows)


def smooth(fmu, quantity, name, derivatives, stop, step, marks, once=False):
    """The input by value and derivatives: at each step, or `once` at the start."""
    with fmu.instance(CLEAR) as instance:
        rows = []
        for i, time in enumerate(grid(stop, step)):
            if i == 0 or not once:
                value, *rates = derivatives(instance.time)
                instance.set({name: value})
                instance.set_derivatives(name, *rates)
            instance.step_to(time)
            if np.min(np.abs(marks - time)) < 1e-9:
                rows.append(instance.get(quantity))
        return np.array(rows)


def input_derivatives(report, fmu):
    stop, marks = 0.2, np.array(grid(0.2, 0.02))
    ramps = ((TORQUE, f"{W}.pitchRate", 2.5e4), (INPUTS[1], f"{W}.y", 2.5e4))
    for name, quantity, rate in ramps:
        for order, law in ((1, lambda t, k=rate: (k * t, k)),
                           (2, lambda t, k=rate / stop: (k * t * t, 2 * k * t, 2 * k))):
            report.section(f"{name} by value and derivatives up to order {order}, seen in {quantity}")
            exact = smooth(fmu, quantity, name, law, stop, 1e-2, marks)
            start = hold(fmu, quantity, name, lambda t: 0.0, stop, 1e-2, marks)
            change = np.max(np.abs(exact - start))
            report.check(change > 1e-5, "the input is felt", f"{quantity} changes by {change:.3e}")
            steps = (1e-3, 5e-4, 1e-4)
            error = [np.max(np.abs(hold(fmu, quantity, name, lambda t: law(t)[0], stop, h, marks) - exact))
                     for h in steps]
            report.note("staircase of " + ", ".join(f"{h * 1e3:g} ms: {e:.3e}" for h, e in zip(steps, error)))
            report.near(error[0] / error[1], 2.0, 0.3, "a staircase of half the step has half the error")
            report.near(error[0] / error[2], 10.0, 2.0, "a staircase of a tenth of the step has a tenth of it")
            middle = np.max(np.abs(hold(fmu, quantity, name, lambda t: law(t + 5e-5)[0], stop, 1e-4, marks) - exact))
            report.below(middle, 0.1 * error[2], "staircase of 0.1 ms through the middle of each step")
            other = smooth(fmu, quantity, name, law, stop, 2.5e-3, marks)
            report.below(np.max(np.abs(other - exact)), 1e-5 * change, "handed over each 2.5 ms or each 10 ms")
            once = smooth(fmu, quantity, name, law, stop, 1e-2, marks, once=True)
            report.below(np.max(np.abs(once - exact)), 1e-5 * change, "goes on if nothing is set again")
            if order == 2:  # the second derivative must not be lost
                line = smooth(fmu, quantity, name, lambda t: law(t)[:2], stop, 1e-2, marks)
                report.check(np.max(np.abs(line - exact)) > 10 * np.max(np.abs(other - exact)),
                             "without the second derivative it is another curve",
                             f"{np.max(np.abs(line - exact)):.3e}")


def value_alone(report, fmu):
    report.section("a value set alone ends the derivatives")
    times, tail = grid(0.1, 0.01), grid(0.2, 0.01, 0.1)

    def run(last):
        with fmu.instance(CLEAR) as instance:
            instance.set({TORQUE: 500.0})
            instance.set_derivatives(TORQUE, 2e4, 1e4)
            instance.run(times)
            last(instance)
            return instance.run(tail)

    def zero(instance):
        instance.set({TORQUE: 2000.0})
        instance.set_derivatives(TORQUE, 0.0, 0.0)

    def first_only(instance):
        instance.set({TORQUE: 2000.0})
        instance.set_derivatives(TORQUE, 0.0)

    def each_step(instance):
        for time in tail[:-1]:
            instance.set({TORQUE: 2000.0})
            instance.step_to(time)
        instance.set({TORQUE: 2000.0})

    alone = run(lambda instance: instance.set({TORQUE: 2000.0}))
    report.same_bits(alone, run(zero), "value alone, and value with derivatives 0")
    report.same_bits(alone, run(first_only), "value alone, and value with the first derivative 0")
    on = run(lambda instance: None)
    index = fmu.outputs.index(f"{W}.pitchRate")
    report.check(abs(on[-1, index] - alone[-1, index]) > 1e-3, "unlike a torque that goes on rising",
                 f"pitch rates {on[-1, index]:.6f} and {alone[-1, index]:.6f} rad/s")
    with fmu.instance(CLEAR) as instance:
        instance.set({TORQUE: 500.0})
        instance.set_derivatives(TORQUE, 2e4, 1e4)
        instance.run(times)
        each_step(instance)
        instance.step_to(tail[-1])
        report.below(abs(instance.get(f"{W}.pitchRate") - alone[-1, index]), 1e-6,
                     "the same value set again at each step, pitch rate", "rad/s")


def script(report, path):
    with Fmu(path) as fmu:
        step_sizes(report, fmu)
        input_derivatives(report, fmu)
        value_alone(report, fmu)


if __name__ == "__main__":
    main(script)
