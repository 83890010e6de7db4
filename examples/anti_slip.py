#!/usr/bin/env python3
"""Anti-slip control of a locomotive on a wet rail with falling friction.

    pip install fmpy pythonfmu
    python examples/anti_slip.py -o anti_slip.svg

The locomotive (examples/locomotive.toml: 84 t, four nose-suspended motors) is one FMU, the controller of an axle (slip_control.py) another, made here by pythonfmu and instanced four times.
Within 1 s the driver asks for more than the rail gives. Without control the leading axle of each truck, which its own pull unloads, spins up; with control its torque is cut
so that its slip stays at the adhesion's maximum.

Compared with formulas: Polach's law (Wear 258 (2005), 992-1000) written out here, with the ellipse and load that the FMU shows: its maximum is what the controlled axle should use, and its
friction at great slip, 0.4 mu, is what is left to the axle that spins.

Left out: the inertia of the train (its pull is a constant force), the motors' electrical part (torque follows at once), and a real controller's search for the maximum (it is told the slip).
The slip that it measures has noise (0.02 m/s, `--seed`) and is one step old.
"""

import math
import pathlib
import random
import tempfile

from pythonfmu.builder import FmuBuilder

from partner import HERE, Fmu, Instance, Report, arguments, draw

AXLES = [f"truck[{i}].wheelset[{j}]" for i in (1, 2) for j in (1, 2)]
MOTORS = [f"truck[{i}].motor[{j}]" for i in (1, 2) for j in (1, 2)]
DEMAND, RISE, POWER = 5200.0, 1.0, 1.6e6  # of each motor: N m (52 kN at the rail), s, W
NOISE = 0.02  # m/s
# Wet rail of Polach 2005, and steel; Kalker's c11 over a/b at nu = 0.25 (0.1, 0.2 ... 1.0).
FRICTION, RATIO, DECAY, K_A, K_S = 0.30, 0.4, 0.2, 0.3, 0.1
SHEAR_MODULUS = 2.1e11 / 2.56
C11 = [3.31, 3.37, 3.44, 3.53, 3.62, 3.72, 3.81, 3.91, 4.01, 4.12]


def polach(slip, speed, a, b, load):
    """Adhesion of a wheel that slips along the track alone, -."""
    friction = FRICTION * ((1.0 - RATIO) * math.exp(-DECAY * slip) + RATIO)
    place = min(max(10.0 * a / b - 1.0, 0.0), 8.999)
    c11 = C11[int(place)] + (place % 1.0) * (C11[int(place) + 1] - C11[int(place)])
    gradient = SHEAR_MODULUS * math.pi * a * b * c11 * (slip / speed) / (4.0 * friction * load)
    return 2.0 * friction / math.pi * (K_A * gradient / (1.0 + (K_A * gradient) ** 2) + math.atan(K_S * gradient))


def best(speed, a, b, load):
    """Slip [m/s] and adhesion at the law's maximum."""
    return max(((0.01 * i, polach(0.01 * i, speed, a, b, load)) for i in range(1, 400)), key=lambda point: point[1])


def drive(locomotive, controller, controlled, step, stop, seed):
    """Rows of time, speed, and of each axle slip, used adhesion and torque at the rail."""
    noise, rows = random.Random(seed), []
    shown = [f"{axle}.{name}" for axle in AXLES for name in ("slipSpeed", "usedAdhesion")]
    shown += [f"{motor}.{name}" for name in ("axleTorque", "motorSpeed") for motor in MOTORS]
    patch = [f"{AXLES[0]}.left.contact[1].{name}" for name in ("semiAxisA", "semiAxisB", "normalForce")]
    with Instance(locomotive) as vehicle:
        # What the leading axle's left wheel stands on; the controllers' slip is that of the maximum there.
        standing = (vehicle.get([f"{AXLES[0]}.vx"])[0], *vehicle.get(patch))
        values = {"enabled": 1.0 if controlled else 0.0, "target": best(*standing)[0]}
        controllers = [Instance(controller, values) for _ in AXLES]
        slips, speeds = [0.0] * len(AXLES), [0.0] * len(AXLES)
        for _ in range(round(stop / step)):
            demand = DEMAND * min(1.0, vehicle.time / RISE)
            for control, motor, slip, speed in zip(controllers, MOTORS, slips, speeds):
                control.set({"demand": min(demand, POWER / max(speed, 1.0)), "slip": slip + noise.gauss(0.0, NOISE)})
                control.step(step)
                vehicle.set({f"{motor}.torque": control.get(["torque"])[0]})
            vehicle.step(step)
            found = vehicle.get(shown)
            slips, speeds = found[0:8:2], found[12:]
            rows.append([vehicle.time, vehicle.get([f"{AXLES[0]}.vx"])[0], slips, found[1:8:2], found[8:12]])
        at_end = (rows[-1][1], *vehicle.get(patch))
        for control in controllers:
            control.__exit__()
    return rows, standing, at_end


def mean(values):
    values = list(values)
    return sum(values) / len(values)


def main():
    asked = arguments(__doc__, step=0.01, seed="of the measured slip's noise (1)")
    stop, seed = (4.0 if asked.short else 10.0), int(asked.seed or 1)
    report = Report()
    with tempfile.TemporaryDirectory() as folder:
        made = FmuBuilder.build_FMU(HERE / "slip_control.py", dest=folder)
        with Fmu(pathlib.Path(folder) / made.name) as controller, Fmu.of_scene(HERE / "locomotive.toml") as locomotive:
            with_control, standing, at_end = drive(locomotive, controller, True, asked.step, stop, seed)
            without, _, _ = drive(locomotive, controller, False, asked.step, stop, seed)
    target, peak = best(*standing)
    late = lambda rows: [row for row in rows if row[0] > 0.6 * stop]
    report.near("controlled: slip of the leading axle, mean", mean(row[2][0] for row in late(with_control)), target, 0.05, "m/s")
    report.near("controlled: used adhesion of the leading axle, mean", mean(row[3][0] for row in late(with_control)), best(*at_end)[1], 0.03)
    report.below("controlled: largest slip of any axle", max(max(row[2]) for row in with_control), 2.0 * target, "m/s")
    report.above("without: slip of the leading axle at the end", without[-1][2][0], 8.0, "m/s")
    report.near("without: its used adhesion then, against the friction of full sliding", mean(row[3][0] for row in late(without)), RATIO * FRICTION, 0.03)
    gained = with_control[-1][1] - without[-1][1]
    report.above("speed gained by control", gained, 0.02 * stop, "m/s")
    print(f"        Polach's maximum {peak:.4f} at {target:.2f} m/s; {asked.step * 1e3:g} ms, seed {seed}")
    if asked.picture:
        time = [row[0] for row in with_control]
        line = lambda rows, of: [of(row) for row in rows]
        force = lambda row: row[4][0] / 1e3
        draw(asked.picture, "Locomotive on a wet rail: leading axle with and without anti-slip control", "time, s", [
            ("slip speed, m/s", [("control", time, line(with_control, lambda row: row[2][0])),
                                 ("none", time, line(without, lambda row: row[2][0]))], [("maximum of Polach's law", target)]),
            ("used adhesion", [("control", time, line(with_control, lambda row: row[3][0])), ("none", time, line(without, lambda row: row[3][0]))],
             [("maximum of Polach's law", peak), ("0.4 mu", RATIO * FRICTION)]),
            ("torque on the axle, kN m", [("control", time, line(with_control, force)), ("none", time, line(without, force))], []),
            ("speed, m/s", [("control", time, line(with_control, lambda row: row[1])), ("none", time, line(without, lambda row: row[1]))], []),
        ])
    report.finish(at_once=True)


if __name__ == "__main__":
    main()
