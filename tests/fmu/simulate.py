"""simulate.py FMU

fmpy.simulate_fmu as a user calls it: the default experiment, start values, an input table, output lists; the results
are checked against statics, Newton's law and the friction bound.
"""

import re

import fmpy
import numpy as np

from common import (CLEAR, CONTACTS, FRICTION, GRAVITY, INPUTS, MASS, RADIUS, SIDES, SPEED, TORQUE, W, WEIGHT, Fmu,
                    main)

LATERAL, VERTICAL = INPUTS[1:3]


class Run:
    """Calls simulate_fmu and fails on any message of level warning or above."""

    def __init__(self, report, fmu):
        self.report, self.fmu = report, fmu

    def __call__(self, path=None, **options):
        self.log = []
        result = fmpy.simulate_fmu(path or self.fmu.directory, logger=self._message, **options)
        bad = [text for status, text in self.log if status > 0]
        self.report.check(not bad, "no warning or error message", "; ".join(bad[:3]) or f"{len(self.log)} messages")
        return result

    def _message(self, _environment, _name, status, _category, message):
        self.log.append((status, (message or b"").decode("utf-8", "replace")))


def total(result, name):
    return sum(result[f"{W}.{side}.{name}"] for side in SIDES)


def general(report, result, factor=None, vertical=0.0):
    """What holds at any time, whatever the wheelset does."""
    names = [n for n in result.dtype.names if result[n].dtype.kind == "f"]
    bad = [n for n in names if not np.all(np.isfinite(result[n]))]
    report.check(not bad, "finite", ", ".join(bad) or f"{len(names)} columns, {len(result)} rows")

    for contact in CONTACTS:
        force = result[f"{contact}.normalForce"]
        report.check(force.min() > 0.0, f"{contact} pressed", f"N from {force.min():.1f} to {force.max():.1f} N")
    contacts = sorted({m[1] for n in names if (m := re.match(r"(.+\.contact\[\d+\])\.normalForce$", n))})
    worst = 0.0
    for contact in contacts:
        limit = FRICTION * result[f"{contact}.normalForce"]
        limit = limit * (factor if factor is not None else 1.0)
        force = np.hypot(result[f"{contact}.creepForceX"], result[f"{contact}.creepForceY"])
        worst = max(worst, np.max(force / np.maximum(limit, 1e-9)))
        report.check(result[f"{contact}.normalForce"].min() >= 0.0, f"{contact} does not pull")
    report.below(worst, 1.0 + 1e-6, f"friction bound |F| / (mu N), {len(contacts)} contacts")

    residual = total(result, "verticalForce") + vertical - WEIGHT - MASS * result[f"{W}.az"]
    report.below(np.max(np.abs(residual)), 1e-6 * WEIGHT, "sum Q + Fz - m g - W = m az", "N")
    if f"{W}.ax" in names:
        residual = total(result, "longitudinalForce") + result[f"{W}.drivingForce"] - MASS * result[f"{W}.ax"]
        report.note(f"sum Fx + drivingForce - m ax: {np.max(np.abs(residual)):.3g} N, suspension left out")

    for side, outward in (("left", -1.0), ("right", 1.0)):
        wheel = f"{W}.{side}"
        quotient = outward * result[f"{wheel}.lateralForce"] / result[f"{wheel}.verticalForce"]
        error = np.max(np.abs(result[f"{wheel}.derailmentQuotient"] - quotient))
        report.below(error, 1e-9, f"{wheel}.derailmentQuotient = outward guiding force / Q")
        own = [c for c in contacts if c.startswith(wheel + ".")]
        normal = sum(result[f"{c}.normalForce"] for c in own)
        error = np.max(np.abs(result[f"{wheel}.normalForce"] / normal - 1.0))
        report.below(error, 1e-9, f"{wheel}.normalForce = sum over {len(own)} contacts, relative")
        wear = sum(np.abs(result[f"{c}.creepForceX"] * result[f"{c}.longitudinalCreepage"])
                   + np.abs(result[f"{c}.creepForceY"] * result[f"{c}.lateralCreepage"]) for c in own)
        error = np.max(np.abs(result[f"{wheel}.wearNumber"] - wear) / (1e-3 + wear))
        report.below(error, 1e-9, f"{wheel}.wearNumber = |Fx xi_x| + |Fy xi_y|, relative")
        work = -sum(result[f"{c}.{force}"] * result[f"{c}.{creepage}Creepage"] for c in own for force, creepage in (
            ("creepForceX", "longitudinal"), ("creepForceY", "lateral"), ("spinMoment", "spin")))
        error = np.max(np.abs(result[f"{wheel}.frictionWork"] - work) / (1e-3 + np.abs(work)))
        report.below(error, 1e-9, f"{wheel}.frictionWork = -(Fx xi_x + Fy xi_y + Mz phi), relative")
        if len(own) == 1:  # the wheel's force is the contact's force in other axes
            there = np.sqrt(sum(result[f"{own[0]}.{n}"] ** 2 for n in ("normalForce", "creepForceX", "creepForceY")))
            here = np.sqrt(sum(result[f"{wheel}.{n}"] ** 2
                               for n in ("verticalForce", "lateralForce", "longitudinalForce")))
            report.below(np.max(np.abs(here / there - 1.0)), 1e-9, f"{wheel}: size of the force, wheel and contact")


def windows(time, values, edges):
    """The largest |value| in each interval between the edges."""
    return [np.max(np.abs(values[(time >= a) & (time < b)])) for a, b in zip(edges, edges[1:])]


def decays(report, time, values, edges, what, floor):
    peaks = windows(time, values, edges)
    falling = all(b <= max(a, floor) for a, b in zip(peaks, peaks[1:])) and peaks[-1] < max(0.9 * peaks[0], floor)
    report.check(falling, f"{what} decays", ", ".join(f"{p:.3e}" for p in peaks)
                 + f" in {edges[0]:g} s to {edges[-1]:g} s")


def default_experiment(report, run):
    report.section("default experiment")
    result = run(run.fmu.path, output_interval=0.0025)
    t, y, yaw = result["time"], result[f"{W}.y"], result[f"{W}.yaw"]
    report.near(t[-1], 5.0, 1e-9, "stop time", "s")
    report.check(len(t) == 2001, "rows", str(len(t)))
    report.below(np.max(np.abs(result[f"{W}.distance"] - SPEED * t)), 1e-6, "distance - 40 m/s t", "m")
    for side in SIDES:
        report.near(result[f"{W}.{side}.verticalForce"][0], WEIGHT / 2, 1e-6 * WEIGHT, f"{side} Q at the start", "N")
    report.near(result[f"{W}.pitchRate"][0], SPEED / RADIUS, 1e-3 * SPEED / RADIUS, "pitch rate at the start", "rad/s")
    general(report, result)

    before = t < 0.5 - 1e-9
    report.below(np.max(np.abs(y[before])), 1e-6, "|y| before the disturbance", "m")
    report.below(np.max(np.abs(yaw[before])), 1e-6, "|yaw| before the disturbance", "rad")
    report.between(5e-4, y[np.searchsorted(t, 0.75)], 0.015, "y at 30 m: the right rail has come in, to the left", "m")
    report.between(5e-4, np.max(np.abs(y)), 0.015, "largest |y|", "m")
    report.between(1e-4, np.max(np.abs(yaw)), 0.02, "largest |yaw|", "rad")
    decays(report, t, y, (0.75, 1.75, 2.75, 3.75, 5.0), "y", 1e-7)
    decays(report, t, yaw, (0.75, 1.75, 2.75, 3.75, 5.0), "yaw", 1e-8)

    report.section("sampling")
    some = [f"{W}.y", f"{W}.left.verticalForce"]
    coarse = run(output_interval=0.01, stop_time=1.2345, output=some)
    report.check(list(coarse.dtype.names) == ["time"] + some, "columns", ", ".join(coarse.dtype.names))
    report.near(coarse["time"][-1], 1.2345, 1e-9, "stop time, no multiple of the step", "s")
    at = np.rint(coarse["time"][:-1] / 0.0025).astype(int)
    report.below(np.max(np.abs(coarse[some[0]][:-1] - y[at])), 1e-9, "y, step 10 ms and 2.5 ms", "m")
    again = run(output_interval=0.01, stop_time=1.2345, output=some, debug_logging=True)
    report.same_bits(np.array([again[n] for n in some]), np.array([coarse[n] for n in some]), "with debug logging on")


def start_values(report, run, fmu):
    report.section("start values: y = 1 mm on the undisturbed track")
    name = f"{W}.initial.y"
    rest = run(start_values=CLEAR, stop_time=1.0, output_interval=0.01)
    report.below(np.max(np.abs(rest[f"{W}.y"] - rest[f"{W}.y"][0])), 1e-7, "y at rest", "m")
    report.near(rest[f"{W}.distance"][0], 100.0, 1e-9, "distance at the start", "m")
    report.below(np.max(np.abs(total(rest, "longitudinalForce") + rest[f"{W}.drivingForce"])), 1e-3,
                 "sum Fx + drivingForce", "N")

    result = run(start_values=CLEAR | {name: 0.001}, output_interval=0.0025)
    t, y = result["time"], result[f"{W}.y"]
    report.near(y[0], 0.001 + rest[f"{W}.y"][0], 1e-9, "y at the start", "m")
    general(report, result)
    decays(report, t, y - rest[f"{W}.y"][0], (0.0, 1.25, 2.5, 3.75, 5.0), "y", 1e-8)
    crossings = t[np.flatnonzero(np.diff(np.sign(y - rest[f"{W}.y"][0])))]
    if len(crossings) > 1:
        length = 2 * SPEED * np.mean(np.diff(crossings[:4]))
        report.between(10.0, length, 60.0, "wave length", "m")

    report.section("parameters")
    weight = fmu.parameters("mass")
    if report.check(weight, "a parameter for the mass", ", ".join(weight)):
        heavy = run(start_values=CLEAR | {weight[0]: MASS + 100.0}, stop_time=0.01)
        for side in SIDES:
            report.near(heavy[f"{W}.{side}.verticalForce"][0], (WEIGHT + 100.0 * GRAVITY) / 2, 1e-6 * WEIGHT,
                        f"{side} Q with 100 kg more", "N")
    speed = fmu.parameters("speed")
    if report.check(speed, "a parameter for the speed", ", ".join(speed)):
        slow = run(start_values=CLEAR | {speed[0]: 20.0}, stop_time=1.0)
        report.near(slow[f"{W}.distance"][-1] - slow[f"{W}.distance"][0], 20.0, 1e-6, "distance in 1 s at 20 m/s", "m")
        report.near(slow[f"{W}.pitchRate"][-1], 20.0 / RADIUS, 1e-3 * 20.0 / RADIUS, "pitch rate", "rad/s")
    tolerance = fmu.parameters("tolerance")
    if report.check(tolerance, "a parameter for the tolerance", ", ".join(tolerance)):
        default = float(fmu.variables[tolerance[0]].start)
        outcome = [run(start_values={tolerance[0]: default * f}, stop_time=1.5, output_interval=0.01)[f"{W}.y"]
                   for f in (1.0, 0.1)]
        report.below(np.max(np.abs(outcome[1] - outcome[0])), 1e-5, f"y with tolerance {default:g} and a tenth", "m")


def inputs(report, run):
    report.section("input table with steps, undisturbed track")
    torque, side_force, load = 5000.0, 2000.0, -20000.0
    steps = [(0.0, {}), (0.5, {TORQUE: torque}), (1.5, {TORQUE: torque, LATERAL: side_force}),
             (2.0, {TORQUE: torque}), (3.0, {TORQUE: torque, VERTICAL: load}),
             (4.0, {TORQUE: torque, INPUTS[3]: 0.05, INPUTS[4]: 0.05}), (4.1, {}), (4.5, None)]
    rows = []
    for (time, values), (end, _) in zip(steps, steps[1:]):
        row = [values.get(name, 1.0 if name.endswith("Factor") else 0.0) for name in INPUTS]
        rows += [(time, *row), (end, *row)]
    table = np.array(rows, dtype=[("time", float)] + [(name, float) for name in INPUTS])
    result = run(start_values=CLEAR, input=table, stop_time=4.5, output_interval=0.0025)
    t = result["time"]
    applied = {name: np.zeros(len(t)) for name in INPUTS}  # in the interval that ends at t
    for (time, values), (end, _) in zip(steps, steps[1:]):
        for name in INPUTS:
            applied[name][(t > time + 1e-9) & (t <= end + 1e-9)] = values.get(name, 1.0 if "Factor" in name else 0.0)
    # At the instants of a step an output may belong to either side of it.
    edge = np.min(np.abs(t[:, None] - np.array([s[0] for s in steps])), axis=1) < 1e-9
    inside = result[~edge]
    general(report, inside, applied[INPUTS[3]][~edge], applied[VERTICAL][~edge])

    def at(time):
        return result[np.searchsorted(t, time - 1e-9)]

    driven = at(1.49)
    force = sum(driven[f"{W}.{side}.longitudinalForce"] for side in SIDES)
    report.near(force, torque / RADIUS, 2e-3 * torque / RADIUS, "sum Fx with a drive torque of 5 kN m", "N")
    report.near(force + driven[f"{W}.drivingForce"], 0.0, 1e-6 * force, "sum Fx + drivingForce", "N")
    report.check(driven[f"{W}.pitchRate"] > at(0.49)[f"{W}.pitchRate"], "the driven wheelset slips forward",
                 f"{driven[f'{W}.pitchRate'] - at(0.49)[f'{W}.pitchRate']:.4f} rad/s")
    for contact in CONTACTS:
        report.check(driven[f"{contact}.longitudinalCreepage"] < 0.0 < driven[f"{contact}.creepForceX"],
                     f"{contact}: signs", f"creepage {driven[f'{contact}.longitudinalCreepage']:.3e}, "
                     f"force {driven[f'{contact}.creepForceX']:.1f} N")
    moved = at(1.55)[f"{W}.y"] - driven[f"{W}.y"]
    report.check(moved > 5e-5, "in 50 ms a lateral force to the left moves the wheelset to the left",
                 f"{moved * 1e3:.3f} mm")
    loaded = at(3.99)
    report.near(sum(loaded[f"{W}.{side}.verticalForce"] for side in SIDES), WEIGHT - load, 1e-5 * WEIGHT,
                "sum Q with 20 kN downward", "N")
    slipping, caught = at(4.09), at(4.49)
    report.check(slipping[f"{W}.pitchRate"] > driven[f"{W}.pitchRate"] + 1.0, "on slippery rails it spins up",
                 f"{slipping[f'{W}.pitchRate']:.4f} rad/s")
    report.near(caught[f"{W}.pitchRate"], at(0.49)[f"{W}.pitchRate"], 1e-2, "and is caught again", "rad/s")


def script(report, path):
    with Fmu(path) as fmu:
        run = Run(report, fmu)
        default_experiment(report, run)
        start_values(report, run, fmu)
        inputs(report, run)


if __name__ == "__main__":
    main(script)
