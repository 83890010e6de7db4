"""coupling.py FMU

External models as a master would couple them: a traction motor with its controller, and a brake on slippery rails.
Forces and energy must balance.
"""

import math

import numpy as np

from common import (CLEAR, CONTACTS, FRICTION, INPUTS, PITCH_INERTIA, RADIUS, SIDES, SPEED, TORQUE, W, WEIGHT, Fmu,
                    columns, grid, main)


class Motor:
    """Torque that follows its reference with a first-order lag: T' = (reference - T) / lag."""

    def __init__(self, lag):
        self.lag, self.torque = lag, 0.0

    def rate(self, reference):
        return (reference - self.torque) / self.lag

    def advance(self, reference, step):
        self.torque = reference + (self.torque - reference) * math.exp(-step / self.lag)


def total(values, name):
    return sum(values[f"{W}.{side}.{name}"] for side in SIDES)


def dissipated(values):
    """Power of all creep forces, W: creepages are relative to the travelling speed."""
    return -SPEED * sum(values[f"{c}.creepForceX"] * values[f"{c}.longitudinalCreepage"]
                        + values[f"{c}.creepForceY"] * values[f"{c}.lateralCreepage"]
                        + values[f"{c}.spinMoment"] * values[f"{c}.spinCreepage"] for c in CONTACTS)


def bound(report, values, factor, what):
    worst = max(np.max(np.hypot(values[f"{c}.creepForceX"], values[f"{c}.creepForceY"])
                       / (FRICTION * factor * values[f"{c}.normalForce"])) for c in CONTACTS)
    report.below(worst, 1.0 + 1e-6, f"{what}: |F| / (mu N)")
    return worst


def traction(report, fmu):
    report.section("traction motor, undisturbed track")
    step, stop, target = 5e-3, 3.0, 5000.0
    with fmu.instance(CLEAR) as instance:
        free = instance.run([0.01])[0]
        rolling = SPEED / free[fmu.outputs.index(f"{W}.pitchRate")]
        report.near(rolling, RADIUS, 1e-3 * RADIUS, "rolling radius V / pitch rate", "m")
        motor, rows, torques = Motor(0.1), [], []
        for time in grid(stop, step, instance.time):
            reference = target * min(1.0, instance.time / 0.5)
            instance.set({TORQUE: motor.torque})
            instance.set_derivatives(TORQUE, motor.rate(reference))
            motor.advance(reference, time - instance.time)
            instance.step_to(time)
            rows.append(instance.outputs())
            torques.append(motor.torque)
    values, torques = columns(fmu, np.array(rows)), np.array(torques)
    last = {name: series[-1] for name, series in values.items()}
    torque, force = torques[-1], total(last, "longitudinalForce")
    report.near(torque, target, 1e-6 * target, "motor torque", "N.m")
    # What is left is the part of the spin moments along the axle.
    report.near(force * rolling, torque, 1e-4 * torque, "sum Fx r = T with the rolling radius", "N.m")
    report.near(force * RADIUS, torque, 1e-3 * torque, "sum Fx r0 = T with the nominal radius", "N.m")
    report.near(last[f"{W}.drivingForce"], -force, 1e-6 * force, "drivingForce = - sum Fx", "N")
    for name in ("longitudinalForce", "verticalForce", "lateralForce"):
        sign = -1.0 if name == "lateralForce" else 1.0
        left, right = (last[f"{W}.{side}.{name}"] for side in SIDES)
        report.near(left, sign * right, 1e-6 * WEIGHT, f"left and right {name}", "N")
    report.check(all(last[f"{c}.longitudinalCreepage"] < 0 < last[f"{c}.creepForceX"] for c in CONTACTS),
                 "driven: creepage < 0, force > 0",
                 ", ".join(f"{last[f'{c}.longitudinalCreepage']:.3e}" for c in CONTACTS))
    slip = last[f"{W}.pitchRate"] * rolling / SPEED - 1.0
    creepage = -np.mean([last[f"{c}.longitudinalCreepage"] for c in CONTACTS])
    report.near(slip, creepage, 2e-2 * abs(creepage), "slip of the pitch rate = creepage")
    # The difference of two numbers of 219 kW: what the integration leaves of the contact's vibration, 1 N of 57 kN, is averaged out.
    end = {name: series[-100:] for name, series in values.items()}
    power = np.mean(torques[-100:] * end[f"{W}.pitchRate"] + end[f"{W}.drivingForce"] * SPEED)
    heat = np.mean(dissipated(end))
    report.check(heat > 0.0, "creep dissipates", f"{heat:.3f} W")
    report.near(power, heat, 2e-3 * heat, "T omega + drivingForce V = dissipated power", "W")
    bound(report, values, 1.0, "friction bound")
    # While the torque rises: the wheels' force follows it, short of the pitch inertia.
    inertia = PITCH_INERTIA * np.gradient(values[f"{W}.pitchRate"], step)
    error = np.abs(total(values, "longitudinalForce") * RADIUS + inertia - torques)[2:-2]
    report.below(np.max(error), 5e-3 * target, "T - Iyy omega' - sum Fx r0 on the way", "N.m")


def slippery(report, fmu, torque, what):
    """A torque on rails with a friction factor of 0.05, then normal friction again and no torque."""
    report.section(f"{what}: {torque:g} N.m on a friction factor of 0.05")
    step, start, end, stop, factor = 1e-3, 0.1, 0.3, 1.0, 0.05
    friction = dict.fromkeys(INPUTS[3:], factor)
    with fmu.instance(CLEAR) as instance:
        before = instance.run(grid(start, step))
        instance.set({TORQUE: torque} | friction)
        during = instance.run(grid(end, step, start))
        instance.set({TORQUE: 0.0} | dict.fromkeys(INPUTS[3:], 1.0))
        after = instance.run(grid(stop, step, end))
    values = columns(fmu, during)
    rate = values[f"{W}.pitchRate"]
    free = before[-1][fmu.outputs.index(f"{W}.pitchRate")]
    adhesion = FRICTION * factor * WEIGHT * RADIUS
    expected = (abs(torque) - adhesion) / PITCH_INERTIA * (end - start)
    turn = (rate[-1] - free) * np.sign(torque)
    report.between(0.9 * expected, turn, 1.3 * expected, "change of the pitch rate against (|T| - mu N r) t / Iyy",
                   "rad/s")
    worst = bound(report, values, factor, "low friction")
    report.check(worst > 0.9, "adhesion is used up", f"{worst:.4f}")
    force = total(values, "longitudinalForce")
    report.check(np.all(force[20:] * np.sign(torque) > 0.0), "the wheels' force has the sign of the torque",
                 f"{force[20:].min():.1f} to {force[20:].max():.1f} N")

    mean = step * (np.sum(torque - RADIUS * force) - 0.5 * (2 * torque - RADIUS * (force[0] + force[-1])))
    report.near(PITCH_INERTIA * (rate[-1] - rate[0]), mean, 1e-2 * abs(mean), "Iyy change of omega = integral T - r Fx",
                "N.m.s")
    supplied = torque * rate + values[f"{W}.drivingForce"] * SPEED
    work, loss = ((series.sum() - 0.5 * (series[0] + series[-1])) * step for series in (supplied, dissipated(values)))
    energy = 0.5 * PITCH_INERTIA * (rate[-1] ** 2 - rate[0] ** 2)
    report.check(loss > 0.0, "creep dissipates", f"{loss:.1f} J")
    report.near(work, energy + loss, 1e-2 * loss + 1e-3 * abs(energy), "supplied work = pitch energy + dissipation",
                "J")
    residual = np.abs(force + values[f"{W}.drivingForce"])
    report.below(np.max(residual), 1e-3 * np.max(np.abs(force)), "sum Fx + drivingForce", "N")

    values = columns(fmu, after)
    bound(report, values, 1.0, "friction again")
    report.near(values[f"{W}.pitchRate"][-1], free, 1e-4 * free, "pitch rate after the slip", "rad/s")
    every = np.vstack([before, during, after])
    report.check(np.all(np.isfinite(every)), "finite", f"{every.size} values")
    index = [fmu.outputs.index(f"{c}.normalForce") for c in CONTACTS]
    report.check(every[:, index].min() > 0.0, "both wheels pressed", f"N >= {every[:, index].min():.1f} N")


def script(report, path):
    with Fmu(path) as fmu:
        traction(report, fmu)
        slippery(report, fmu, -5000.0, "brake")
        slippery(report, fmu, 4000.0, "traction")


if __name__ == "__main__":
    main(script)
