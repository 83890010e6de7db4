#!/usr/bin/env python3
"""Wheel-slide protection: a coach braked from 160 km/h to rest on a slippery rail, then held on a grade of 4 %.

    pip install fmpy pythonfmu
    python examples/wheel_slide.py -o wheel_slide.svg

The coach (examples/braked_coach.toml) has a disc brake on each axle that is asked for 7 kN m, an adhesion of 0.14. The rail is wet, with mu = 0.12 at rest and falling friction, and gives less than that: without
protection all axles lock. With it the controller of examples/slip_control.py (an FMU made by pythonfmu, one for each axle) holds each axle's slip at the adhesion's maximum.

Compared with formulas: the way of locked wheels from m v dv/dx = -m g mu(v) - resistance - grade with Polach's friction of full sliding; the best way from the same with the maximum of Polach's law at
each speed; nothing moves while the brakes hold.

Left out: heat and wear of the discs, what sliding does to the film on the rail, the lag of valves and cylinders, flats of locked wheels. The controller is told the coach's speed (a real one
estimates it from its axles); the slip that it measures has noise (0.02 m/s, `--seed`).
"""

import math
import pathlib
import random
import tempfile

from pythonfmu.builder import FmuBuilder

from anti_slip import DECAY, NOISE, RATIO, best
from partner import HERE, Fmu, Instance, Report, arguments, draw
import anti_slip

AXLES = [f"truck[{i}].wheelset[{j}]" for i in (1, 2) for j in (1, 2)]
BRAKES = [f"brake[{i}]" for i in (1, 2, 3, 4)]
TORQUE, RADIUS, FRICTION = 7000.0, 0.46, 0.12  # N m of each brake, m, -
MASS, RUNNING = 44482.0, (600.0, 2.0)  # kg, N and kg/m
GRADE, LEVEL = 0.04, (700.0, 760.0)
WALKING = 1.5  # m/s, below which protection is off
CHANGES = [f"contact.friction={FRICTION}", 'contact.creep.surface="wet"', 'interface.outputs=["motion", "contacts", "bodies", "forces", "adhesion"]']


def grade(distance):
    """The scene's: linear between its nodes (their rounded corners are left out here)."""
    return GRADE * min(max((distance - LEVEL[0]) / (LEVEL[1] - LEVEL[0]), 0.0), 1.0)


def way(adhesion, begin, speed):
    """Distance at rest of a coach on whose wheels the rail acts with `adhesion(v)` [-]; what wheels turn with, brakes take."""
    distance, step = begin, 2e-3
    while speed > 0.0:
        force = MASS * 9.81 * (adhesion(speed) + grade(distance)) + RUNNING[0] + RUNNING[1] * speed**2
        distance, speed = distance + step * speed, speed - step * force / MASS
    return distance


def brake(coach, controller, protected, step, seed):
    """Brakes to rest; rows of time, distance, speed, axle speeds, torques. The instance stands then."""
    noise, rows = random.Random(seed), []
    vehicle = Instance(coach, {})
    patch = vehicle.get([f"{AXLES[0]}.left.contact[1].{name}" for name in ("semiAxisA", "semiAxisB", "normalForce")])
    controllers = [Instance(controller, {"gain": 6000.0, "enabled": float(protected)}) for _ in AXLES]
    slip, brakes, motion = ([f"{name}.{end}" for name in names] for names, end in ((AXLES, "slipSpeed"), (BRAKES, "torque"), (["car"], "distance")))
    while True:
        speed = vehicle.get([f"{AXLES[0]}.vx"])[0]
        slips, torques = vehicle.get(slip), vehicle.get(brakes)
        rows.append((vehicle.time, vehicle.get(motion)[0], speed, [speed + own for own in slips], torques))
        if speed < 1e-3 or vehicle.time > 120.0:
            break
        on = protected and speed > WALKING
        target = best(speed, *patch)[0] if on else 0.0
        for control, name, own in zip(controllers, BRAKES, slips):
            control.set({"demand": TORQUE, "slip": -own + noise.gauss(0.0, NOISE), "target": target, "enabled": float(on)})
            control.step(step)
            vehicle.set({f"{name}.largestTorque": control.get(["torque"])[0]})
        vehicle.step(step)
    for control in controllers:
        control.__exit__()
    return rows, vehicle, patch


def hold(vehicle, time, step):
    """Largest motion over `time` [s] of a coach that has come to rest on its brakes, m, after its swinging has died away."""
    vehicle.set({f"{name}.largestTorque": TORQUE for name in BRAKES})
    for _ in range(100):
        vehicle.step(0.2)
    places = [f"{axle}.distance" for axle in AXLES] + ["car.distance"]
    begin, most = vehicle.get(places), 0.0
    for _ in range(round(time / step)):
        vehicle.step(step)
        most = max([most] + [abs(now - then) for now, then in zip(vehicle.get(places), begin)])
    return most


def main():
    asked = arguments(__doc__, step=0.01, seed="of the measured slip's noise (1)")
    seed = int(asked.seed or 1)
    anti_slip.FRICTION = FRICTION
    report = Report()
    with tempfile.TemporaryDirectory() as folder:
        made = FmuBuilder.build_FMU(HERE / "slip_control.py", dest=folder)
        with Fmu(pathlib.Path(folder) / made.name) as controller, Fmu.of_scene(HERE / "braked_coach.toml", *CHANGES) as coach:
            free, standing, patch = brake(coach, controller, True, asked.step, seed)
            with standing:
                crept = hold(standing, 60.0 if asked.short else 600.0, 0.1)
            locked, other, _ = brake(coach, controller, False, asked.step, seed)
            other.__exit__()
    lock = next(row for row in locked if max(row[3]) < 0.1)
    sliding = way(lambda v: FRICTION * ((1.0 - RATIO) * math.exp(-DECAY * v) + RATIO), *lock[1:3])
    most = TORQUE * len(AXLES) / RADIUS / MASS / 9.81
    ideal = way(lambda v: min(best(max(v, 0.5), *patch)[1], most), *free[0][1:3]) - free[0][1]
    ways = [rows[-1][1] - rows[0][1] for rows in (free, locked)]
    report.near("locked wheels: way from there to rest", locked[-1][1] - lock[1], sliding - lock[1], 0.01, "m")
    report.above("locked wheels: share of the time at rest, all axles", sum(max(row[3]) < 0.5 for row in locked) / len(locked), 0.7)
    report.near("protected: way to rest against the law's maximum at each speed", ways[0], ideal, 0.04, "m")
    report.below("protected: way to rest", ways[0], 0.85 * ways[1], "m")
    moving = [row for row in free if row[2] > 5.0]
    report.above("protected: slowest axle over speed, above 5 m/s", min(min(row[3]) / row[2] for row in moving), 0.7)
    report.below("held on 4 %: motion of wheelsets and car", crept, 1e-9, "m")
    print(f"        {ways[0]:.1f} m in {free[-1][0]:.1f} s, locked {ways[1]:.1f} m in {locked[-1][0]:.1f} s; {asked.step * 1e3:g} ms, seed {seed}")
    if asked.picture:
        column = lambda rows, of: [of(row) for row in rows]
        time, other = column(free, lambda row: row[0]), column(locked, lambda row: row[0])
        draw(asked.picture, "Coach from 160 km/h to rest on a slippery rail, the last part on 4 %", "time, s", [
            ("speed, m/s", [("coach, protected", time, column(free, lambda row: row[2])), ("coach, wheels locked", other, column(locked, lambda row: row[2]))], []),
            ("axle speed, m/s", [("last axle, protected", time, column(free, lambda row: row[3][3])),
                                 ("last axle, unprotected", other, column(locked, lambda row: row[3][3]))], []),
            ("brake torque, kN m", [("last axle, protected", time, column(free, lambda row: -row[4][3] / 1e3)),
                                    ("unprotected", other, column(locked, lambda row: -row[4][3] / 1e3))], [("asked for", TORQUE / 1e3)]),
            ("distance, m", [("protected", time, column(free, lambda row: row[1])), ("locked", other, column(locked, lambda row: row[1]))], []),
        ])
    report.finish(at_once=True)


if __name__ == "__main__":
    main()
