"""speed.py FMU TWO THREE

A speed that the master imposes: start, derivatives, staircases, jumps, states, refusals; FMUs of FMI 2.0 and 3.0 whose `vehicle.speed` is
{start = 20, time_constant = 0.5, largest_acceleration = 2}.
"""

import numpy as np
from fmpy.fmi1 import FMICallException

from common import W, Fmu, grid, main
from common3 import Fmu3

START, CONSTANT, BOUND = 20.0, 0.5, 2.0  # m/s, s, m/s2
READ = (f"{W}.vx", f"{W}.ax", f"{W}.distance", f"{W}.drivingForce", f"{W}.y")


def described(report, fmu):
    report.section("description")
    speed, acceleration = fmu.variables["speed"], fmu.variables["acceleration"]
    report.check(speed.causality == "input" and float(speed.start) == START, "speed", f"{speed.causality}, {speed.start}")
    report.check(acceleration.causality == "input" and float(acceleration.start) == 0.0, "acceleration")
    for variable in (speed, acceleration):
        report.check(bool(variable.description) and bool(variable.declaredType), variable.name, variable.description or "")
    known = {o.variable.name: {d.name for d in o.dependencies or ()} for o in fmu.description.outputs}
    for name in (f"{W}.ax", f"{W}.drivingForce"):
        report.check({"speed", "acceleration"} <= known[name], f"{name} depends on both at once")
    for name in (f"{W}.vx", f"{W}.ay", f"{W}.left.verticalForce"):
        report.check(not {"speed", "acceleration"} & known[name], f"{name} does not")


def begins(report, fmu):
    report.section("what is wanted before initialization ends is what the run begins with")
    with fmu.instance({"speed": 27.0}) as instance:
        vx, ax, _, force, _ = instance.get(*READ)
        report.near(vx, 27.0, 1e-12, "speed")
        report.near(ax, 0.0, 1e-9, "acceleration")
        report.below(abs(force), 50.0, "driving force", "N")
        instance.step_to(0.5)
        report.near(instance.get(f"{W}.vx"), 27.0, 1e-9, "it stays")
        instance.slave.reset()
        report.near(instance.get("speed"), START, 0.0, "reset: as exported")


def follows(report, fmu, three):
    report.section("followed")

    def wanted(t):
        return START + 0.9 * t - 0.15 * t * t, 0.9 - 0.3 * t

    step = 0.02
    times = grid(2.0, step)
    with fmu.instance() as told, fmu.instance() as slopes, three.instance() as slopes3, fmu.instance() as held:
        rows = []
        for time in times:
            speed, slope = wanted(told.time)
            told.set({"speed": speed})
            told.set_derivatives("speed", slope, -0.3)
            for each in (slopes, slopes3):
                setter = each.slave.setReal if each is slopes else each.slave.setFloat64
                setter(each.fmu.references(["speed", "acceleration"]), [speed, slope])
            held.set({"speed": speed})
            for each in (told, slopes, slopes3, held):
                each.step_to(time)
            rows.append([wanted(time)[0]] + [each.get(f"{W}.vx") for each in (told, slopes, slopes3, held)])
        speed, *found = np.array(rows).T
        report.below(np.max(np.abs(found[0] - speed)), 1e-6, "with derivatives: the polynomial", "m/s")
        report.below(np.max(np.abs(found[1] - speed)), 0.5 * 0.9 * step + 1e-3, "with the slope as acceleration: to slope x step / 2", "m/s")
        report.same_bits(found[2], found[1], "FMI 3.0 gives the same")
        report.between(0.2, np.max(np.abs(found[3] - speed)), 0.9 * CONSTANT, "without: slope x time constant at most", "m/s")


def jumps(report, fmu):
    report.section("a jump")
    with fmu.instance() as instance:
        instance.set({"speed": START + 4.0})
        report.near(instance.get(f"{W}.ax"), BOUND, 1e-12, "acceleration at once")
        times = grid(4.0, 0.05)
        rows = instance.run(times, READ)
        late = np.maximum(np.array(times) - 1.5, 0.0)
        expected = np.where(late > 0.0, START + 4.0 - np.exp(-late / CONSTANT), START + BOUND * np.array(times))
        report.below(np.max(np.abs(rows[:, 0] - expected)), 1e-4, "bound, then time constant", "m/s")
        report.check(np.all(np.diff(rows[:, 0]) > -1e-12) and np.max(rows[:, 0]) <= START + 4.0 + 1e-9, "no overshoot")


def states(report, fmu):
    report.section("states")
    first, second = grid(0.6, 0.02), grid(1.4, 0.02, 0.6)
    with fmu.instance({"speed": 23.0}) as instance, fmu.instance() as other:
        instance.set({"speed": 25.0})
        instance.set_derivatives("speed", 0.4)
        instance.run(first, [])
        state = instance.slave.getFMUState()
        data = instance.slave.serializeFMUState(state)
        expected = instance.run(second)
        instance.slave.setFMUState(state)
        instance.time = 0.6
        report.same_bits(instance.run(second), expected, "taken back")
        other.run(grid(0.1, 0.02), [])
        other.slave.setFMUState(other.slave.deserializeFMUState(data))
        other.time = 0.6
        report.same_bits(other.run(second), expected, "from bytes in an instance that began with another speed")
        instance.slave.setFMUState(state)
        report.check(instance.slave.serializeFMUState(instance.slave.getFMUState()) == data, "bytes are the same again")


def refused(report, fmu):
    report.section("refused")
    times = grid(0.3, 0.02)
    with fmu.instance() as plain, fmu.instance() as instance:
        expected = plain.run(times)
        for name, value, words in (("speed", 0.0, "creepages"), ("speed", float("nan"), "finite"), ("speed", float("inf"), "finite"),
                                   ("speed", 1e4, "largest"), ("speed", -1e300, "smallest"), ("acceleration", float("nan"), "finite")):
            try:
                instance.set({name: value})
                report.check(False, f"{name} = {value}", "was taken")
            except FMICallException:
                report.check(words in instance.log[-1][1], f"{name} = {value}", instance.log[-1][1])
        report.same_bits(instance.run(times), expected, "and nothing has changed")
    for what, tell in (("an acceleration that stops the vehicle", lambda i: i.set({"acceleration": -1e4})),
                       ("the other sign", lambda i: i.set({"speed": -START})),
                       ("a slope through 0", lambda i: i.set_derivatives("speed", -1.9))):
        with fmu.instance() as instance:
            tell(instance)
            status, log = 0, []
            while status == 0 and instance.time < 15.0:
                status, log = instance.try_step(instance.time + 0.25)
                report.check(np.all(np.isfinite(instance.outputs())), "outputs are numbers") if status else None
            text = log[-1][1] if log else ""
            report.check(status == 2 and "travelling speed has fallen" in text, what, f"t = {instance.time:.3f} s: {text}")
            report.near(instance.get(f"{W}.vx"), 0.05, 0.02, "it stands just before", "m/s")
    for first, second in ((1e308, 0.0), (-1e308, 1e308), (1e308, -1e308)):
        with fmu.instance() as instance:
            instance.set_derivatives("speed", first, second)
            status, log = 0, []
            while status == 0 and instance.time < 1.0:
                status, log = instance.try_step(instance.time + 0.25)
                report.check(np.all(np.isfinite(instance.outputs())), f"derivatives {first}, {second}: numbers at {instance.time} s",
                             log[-1][1] if log else "")


def script(report, _, two, three):
    with Fmu(two) as fmu, Fmu3(three) as other:
        described(report, fmu)
        begins(report, fmu)
        follows(report, fmu, other)
        jumps(report, fmu)
        states(report, fmu)
        refused(report, fmu)


main(script, "TWO", "THREE")
