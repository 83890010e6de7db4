"""standstill.py FMU STANDSTILL

A brake and a traction controller as external models on the scene wheelset_standstill (STANDSTILL): a free wheelset on a grade is
braked to a standstill, held, driven off uphill. FMU is the shipped scene and not used.
"""

import copy
import math

import numpy as np

from common import GRAVITY, SIDES, TORQUE, W, Fmu, columns, grid, main

# The scene wheelset_standstill.
MASS, PITCH_INERTIA, LOAD, RADIUS = 1813.0, 112.0, 91300.0, 0.46  # kg, kg.m2, N, m
GRADE, START_SPEED = math.atan(0.03), 3.0  # rad, m/s
ALONG = f"{W}.longitudinalForceInput"
# The load is a weight: it pulls downhill and has its inertia along the track.
DOWNHILL = (MASS * GRAVITY + LOAD) * math.sin(GRADE)  # N
INERTIA = MASS + LOAD / GRAVITY + PITCH_INERTIA / RADIUS**2  # kg
STEP, STANDS, HELD, END = 1e-3, 6.0, 9.0, 12.0  # s


class Brake:
    """Blocks on the wheel: friction torque up to what the cylinder gives; it holds a wheel that stands like a stiff spring."""

    damping, stiffness, most, filling = 2.0e4, 2.0e6, 4000.0, 0.3  # N.m.s, N.m/rad, N.m, s

    def __init__(self):
        self.twist = self.pressure = 0.0

    def torque(self, pitch_rate, applied, step):
        self.pressure = min(1.0, max(0.0, self.pressure + (step if applied else -step) / self.filling))
        most = self.most * self.pressure
        self.twist = float(np.clip(self.twist + pitch_rate * step, -most / self.stiffness, most / self.stiffness))
        return -float(np.clip(self.damping * pitch_rate + self.stiffness * self.twist, -most, most))


class Traction:
    """A motor with a first-order lag that a speed controller asks for torque, up to a limit."""

    lag, most, gain = 0.1, 5000.0, 2.0e4  # s, N.m, N.m per m/s

    def __init__(self):
        self.motor = 0.0

    def torque(self, speed, target, step):
        asked = self.most * float(np.clip(self.gain * (target - speed) / self.most, 0.0, 1.0))
        self.motor = asked + (self.motor - asked) * math.exp(-step / self.lag)
        return self.motor


class Driver:
    """Brakes until `HELD`, then pulls up to a speed and lets the brake go when the motor holds the wheelset."""

    target = 5.0  # m/s

    def __init__(self):
        self.brake, self.traction, self.applied = Brake(), Traction(), True

    def torque(self, time, speed, pitch_rate, step):
        driving = time > HELD - 0.5 * step
        pull = self.traction.torque(speed, self.target, step) if driving else 0.0
        if pull > DOWNHILL * RADIUS:
            self.applied = False
        return self.brake.torque(pitch_rate, self.applied, step) + pull


def drive(instance, driver, times):
    rows = []
    for time in times:
        speed, pitch_rate = instance.get(f"{W}.vx", f"{W}.pitchRate")
        instance.set({TORQUE: driver.torque(instance.time, speed, pitch_rate, time - instance.time)})
        instance.step_to(time)
        rows.append(instance.outputs())
    return np.array(rows)


def rails(values):
    return sum(values[f"{W}.{side}.longitudinalForce"] for side in SIDES)


def brakes_and_holds(report, fmu, instance, driver):
    report.section("braked on a grade")
    values = columns(fmu, drive(instance, driver, grid(STANDS, STEP)))
    speed = values[f"{W}.vx"]
    stands = int(np.argmax(speed < 1e-3))
    report.check(0 < stands, "it comes to a standstill", f"after {(stands + 1) * STEP:.3f} s, {values[f'{W}.distance'][stands]:.4f} m")
    # The twist that the brake gives back when the wheel stands, and the pull downhill until the brake is twisted the other way, throw it back.
    back = (Brake.most + DOWNHILL * RADIUS) / math.sqrt(Brake.stiffness * INERTIA)
    report.below(-np.min(speed), back, "speed of the jerk back", "m/s")
    # With the full torque and both downhill forces.
    full = slice(round(Brake.filling / STEP) + 20, stands - 50)
    expected = -(Brake.most / RADIUS + DOWNHILL) / INERTIA
    report.near(np.mean(values[f"{W}.ax"][full]), expected, 1e-2 * abs(expected), "deceleration with full brake", "m/s2")
    worst = max(np.max(np.hypot(values[f"{c}.creepForceX"], values[f"{c}.creepForceY"]) / np.maximum(values[f"{c}.normalForce"], 1.0))
                for c in (f"{W}.{side}.contact[1]" for side in SIDES))
    report.below(worst, 0.3 * (1.0 + 1e-6), "creep force over normal force, friction 0.3")

    report.section("held")
    held = columns(fmu, drive(instance, driver, grid(HELD, STEP, STANDS)))
    for name, unit in (("distance", "m"), ("y", "m"), ("z", "m"), ("yaw", "rad")):
        drift = np.max(np.abs(held[f"{W}.{name}"] - values[f"{W}.{name}"][-1]))
        report.below(drift, 1e-6, f"drift of {name} in 3 s", unit)
    last = {name: series[-1] for name, series in held.items()}
    report.below(abs(last[f"{W}.vx"]), 1e-7, "speed", "m/s")
    report.near(rails(last), DOWNHILL, 1e-4 * DOWNHILL, "the rails hold the downhill force", "N")
    report.near(rails({n: s[-1000] for n, s in held.items()}), DOWNHILL, 1e-4 * DOWNHILL, "a second earlier too", "N")
    report.near(instance.get(TORQUE), DOWNHILL * RADIUS, 1e-3 * DOWNHILL * RADIUS, "torque of the brake = downhill force r", "N.m")
    for name, expected in (("verticalForce", (MASS * GRAVITY + LOAD) * math.cos(GRADE)), ("lateralForce", 0.0)):
        total = sum(last[f"{W}.{side}.{name}"] for side in SIDES)
        report.near(total, expected, 1e-5 * LOAD, f"sum of {name}", "N")


def drives_off(report, fmu, instance, driver):
    report.section("driven off uphill")
    begin = instance.get(f"{W}.distance")
    rows = drive(instance, driver, grid(END, STEP, HELD))
    values = columns(fmu, rows)
    distance, speed = values[f"{W}.distance"], values[f"{W}.vx"]
    report.below(begin - np.min(distance), 1e-4, "it does not roll back", "m")
    # The motor has its torque and the speed controller still asks for all of it.
    rolling = (speed > 0.5) & (speed < Driver.target - Traction.most / Traction.gain - 0.3)
    rolling[:round(10 * Traction.lag / STEP)] = False
    report.check(np.count_nonzero(rolling) > 200, "time with full torque", f"{np.count_nonzero(rolling)} ms")
    expected = (Traction.most / RADIUS - DOWNHILL) / INERTIA
    found = np.polyfit(STEP * np.flatnonzero(rolling), speed[rolling], 1)[0]
    report.near(found, expected, 5e-3 * expected, "acceleration of a rolling body", "m/s2")
    report.near(np.mean(values[f"{W}.ax"][rolling]), found, 5e-3 * found, "output ax", "m/s2")
    report.check(np.all(np.diff(speed[rolling]) > 0.0), "no jump in speed", f"up to {speed[-1]:.3f} m/s")
    report.check(np.all(np.isfinite(rows)), "all outputs are numbers")
    return rows


def starts_from_rest(report, fmu):
    report.section("started from rest")
    with fmu.instance({"speed": 0.0}) as instance:
        torque = (Traction.most + DOWNHILL * RADIUS) / 2
        instance.set({TORQUE: torque})
        report.check(np.all(np.isfinite(instance.outputs())), "all outputs are numbers at rest")
        instance.run(grid(1.0, 0.01), [])
        expected = (torque / RADIUS - DOWNHILL) / INERTIA
        report.near(instance.get(f"{W}.vx"), expected, 1e-2 * expected, "speed after 1 s", "m/s")


def script(report, _shipped, path):
    with Fmu(path) as fmu:
        starts_from_rest(report, fmu)
        report.check(fmu.variables[ALONG].valueReference == 1006 and fmu.variables[ALONG].causality == "input", ALONG)
        with fmu.instance() as instance, fmu.instance() as other:
            report.near(instance.get(f"{W}.vx"), START_SPEED, 1e-12, "speed at the start", "m/s")
            driver = Driver()
            brakes_and_holds(report, fmu, instance, driver)
            state, waiting = instance.slave.getFMUState(), copy.deepcopy(driver)
            data = instance.slave.serializeFMUState(state)
            rows = drives_off(report, fmu, instance, driver)

            report.section("states saved at the standstill")
            instance.slave.setFMUState(state)
            instance.slave.freeFMUState(state)
            instance.time = HELD
            again = drive(instance, copy.deepcopy(waiting), grid(END, STEP, HELD))
            report.same_bits(again, rows, "put back and driven off again")
            back = other.slave.deserializeFMUState(data)
            other.slave.setFMUState(back)
            other.slave.freeFMUState(back)
            other.time = HELD
            report.same_bits(drive(other, waiting, grid(END, STEP, HELD)), rows, "as bytes into another instance")


if __name__ == "__main__":
    main(script, "STANDSTILL")
