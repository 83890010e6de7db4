#!/usr/bin/env python3
"""A bridge under a coach: a beam integrated here, coupled through the motion of the rails.

    pip install fmpy
    python examples/bridge.py -o bridge.svg

A simply supported Euler-Bernoulli beam of 30 m carries both rails; its modes q_n'' + 2 d w_n q_n' + w_n^2 q_n = 2 / (m L) sum F sin(n pi x / L) are integrated here, each exactly for
forces that change linearly within a communication step. The vehicle is the Manchester coach. Under each wheel the FMU gets the beam's displacement, velocity and slope with derivatives
(inputs `rail_motion`, docs/fmu.md), so that between communication points rails follow parabolas, and gives back the forces on the rails.

Compared with formulas: the quasi-static influence line of the four axle loads, and Fryba's series for constant forces that travel over a beam (L. Fryba, Vibration of Solids and Structures under
Moving Loads, 1999, chapter 1), whose difference from the coupled run is what the vehicle's own motion does. A wheel sees the beam only between the supports.

The scheme is explicit in the contacts' stiffness: communication steps above 2.1 ms are refused.

Left out: any transition at the supports, where the rails kink by the beam's slope (at 60 m/s a wheel that leaves the bridge strikes with half its load more), rotation of sections (no roll of the deck: both wheels see the centre's deflection), rails and ballast between beam and wheel, irregularities (`--seed` does nothing here).
"""

import math

from partner import Fmu, Instance, Report, arguments, draw

LENGTH, STIFFNESS, MASS, DAMPING, MODES = 30.0, 4.0e10, 1.0e4, 0.01, 5  # m, N m2, kg/m, -, -
WHEEL = 1.2e9  # N/m, of a wheel on its rail under this load: 1.5 Q / penetration
AXLES = [f"truck[{i}].wheelset[{j}]" for i in (1, 2) for j in (1, 2)]
SIDES = ("left", "right")
OMEGA = [(n * math.pi / LENGTH) ** 2 * math.sqrt(STIFFNESS / MASS) for n in range(1, MODES + 1)]
START = -16.0  # m, of the car's centre: the leading axle stands 5.2 m before the beam
CHANGES = ['interface.inputs=["rail_motion"]', 'interface.outputs=["motion", "wheels", "rail_forces"]', f"vehicle.initial.distance={START}"]


def mode(n, x):
    return math.sin(n * math.pi * x / LENGTH) if 0.0 < x < LENGTH else 0.0


class Beam:
    """Modal coordinates, their rates and accelerations."""

    def __init__(self):
        self.q, self.p, self.a = ([0.0] * MODES for _ in range(3))

    def modal(self, places, forces):
        """Of forces [N, up] at places."""
        return [2.0 / (MASS * LENGTH) * sum(force * mode(n, x) for x, force in zip(places, forces)) for n in range(1, MODES + 1)]

    def step(self, before, after, length):
        """The exact step of each mode under a modal force that goes linearly from `before` to `after`."""
        for i, w in enumerate(OMEGA):
            rise = (after[i] - before[i]) / length
            # Quasi-static solution (f - 2 d / w f') / w^2 with the free vibration around it.
            q0 = (before[i] - 2.0 * DAMPING / w * rise) / w**2
            free, rate = self.q[i] - q0, self.p[i] - rise / w**2
            v = w * math.sqrt(1.0 - DAMPING**2)
            decay, cos, sin = math.exp(-DAMPING * w * length), math.cos(v * length), math.sin(v * length)
            b = (rate + DAMPING * w * free) / v
            swing = decay * (free * cos + b * sin)
            self.p[i] = decay * ((b * v - DAMPING * w * free) * cos - (free * v + DAMPING * w * b) * sin) + rise / w**2
            self.q[i] = swing + q0 + rise * length / w**2
            self.a[i] = after[i] - 2.0 * DAMPING * w * self.p[i] - w**2 * self.q[i]

    def at(self, x, speed):
        """Displacement, velocity, slope; and the first two derivatives of the displacement, the first of the velocity, that a wheel meets."""
        w = [0.0] * 6
        if not 0.0 < x < LENGTH:
            return w
        for i in range(MODES):
            k = (i + 1) * math.pi / LENGTH
            s, c = math.sin(k * x), math.cos(k * x)
            q, p, a = self.q[i], self.p[i], self.a[i]
            w[0] += q * s
            w[1] += p * s
            w[2] += q * k * c
            w[3] += p * s + speed * q * k * c
            w[4] += a * s + 2.0 * speed * p * k * c - speed**2 * q * k * k * s
            w[5] += a * s + speed * p * k * c
        return w


def put(vehicle, beam, places, speed, ahead=False):
    """The rails' motion under all wheels; with derivatives where the vehicle goes on from here."""
    for axle, x in zip(AXLES, places):
        u, v, slope, du, ddu, dv = beam.at(x, speed)
        for side in SIDES:
            name = f"{axle}.{side}.railVertical"
            vehicle.set({f"{name}Displacement": u, f"{name}Velocity": v, f"{name}Slope": slope})
            if ahead:
                vehicle.derivatives(f"{name}Displacement", du, ddu)
                vehicle.derivatives(f"{name}Velocity", dv)


def cross(fmu, speed, step):
    """Rows of time, place of the leading axle, deflection in the middle, load of the leading axle; and the static axle loads [N] and places of axles."""
    beam, rows = Beam(), []
    shown = [f"{axle}.{side}.railVerticalForce" for axle in AXLES for side in SIDES]
    with Instance(fmu, {"speed": speed}) as vehicle:
        places = vehicle.get([f"{axle}.distance" for axle in AXLES])
        first = list(places)
        axle_forces = lambda: [sum(pair) for pair in zip(*[iter(vehicle.get(shown))] * 2)]
        forces = axle_forces()
        loads = list(forces)
        now = beam.modal(places, forces)
        for _ in range(round((LENGTH + 12.0 + 16.0) / speed / step)):
            put(vehicle, beam, places, speed, ahead=True)
            vehicle.step(step)
            places = [x + speed * vehicle.time for x in first]
            # The beam under the old forces, extrapolated nowhere: predicted, then corrected with the forces that the predicted rails give.
            old = beam.q[:], beam.p[:]
            beam.step(now, beam.modal(places, forces), step)
            put(vehicle, beam, places, speed)
            forces = axle_forces()
            after = beam.modal(places, forces)
            beam.q, beam.p = old
            beam.step(now, after, step)
            now = after
            rows.append((vehicle.time, places[0], beam.at(0.5 * LENGTH, 0.0)[0], -forces[0]))
    return rows, loads, first


def influence(places, loads):
    """Quasi-static deflection in the middle of forces [N, up] at places."""
    bent = 0.0
    for x, load in zip(places, loads):
        if 0.0 < x < LENGTH:
            x = min(x, LENGTH - x)
            bent += load * x * (3.0 * LENGTH**2 - 4.0 * x**2) / (48.0 * STIFFNESS)
    return bent


def fryba(time, speed, first, loads):
    """Deflection in the middle of constant forces that travel over the beam: each mode's answer while its force is on it, and its decay afterwards."""
    bent = 0.0
    for begin, load in zip(first, loads):
        arrived, left = -begin / speed, (LENGTH - begin) / speed
        if time <= arrived:
            continue
        for n, w in enumerate(OMEGA, 1):
            drive, height = n * math.pi * speed / LENGTH, 2.0 * load / (MASS * LENGTH)
            # q = A sin(drive t) + B cos(drive t) and the free vibration that begins at rest.
            gap, loss = w**2 - drive**2, 2.0 * DAMPING * w * drive
            a, b = height * gap / (gap**2 + loss**2), -height * loss / (gap**2 + loss**2)
            v, d = w * math.sqrt(1.0 - DAMPING**2), DAMPING * w

            def free(t, q, p):
                c = (p + d * q) / v
                decay, cos, sin = math.exp(-d * t), math.cos(v * t), math.sin(v * t)
                return decay * (q * cos + c * sin), decay * ((c * v - d * q) * cos - (q * v + d * c) * sin)

            t = min(time, left) - arrived
            q, p = free(t, -b, -a * drive)
            q += a * math.sin(drive * t) + b * math.cos(drive * t)
            p += drive * (a * math.cos(drive * t) - b * math.sin(drive * t))
            if time > left:
                q, _ = free(time - left, q, p)
            bent += q * math.sin(0.5 * n * math.pi)
    return bent


def main():
    asked = arguments(__doc__, step=0.001, seed="not used")
    gain = asked.step**2 * 8 * WHEEL * 2.0 / (MASS * LENGTH)
    if gain > 0.3:
        most = asked.step * math.sqrt(0.3 / gain)
        raise SystemExit(f"--step {asked.step:g} s: rails that are put too low by u change the wheels' forces by k u, and those the rails by {gain:.2g} u: use at most {1e3 * most:.1f} ms")
    report, panels = Report(), []
    with Fmu.of_scene("vehicle_manchester_1", *CHANGES) as fmu:
        for speed in (10.0,) if asked.short else (10.0, 60.0):
            rows, loads, first = cross(fmu, speed, asked.step)
            bent = [row[2] * 1e3 for row in rows]
            quasi = [influence([x + speed * row[0] for x in first], loads) * 1e3 for row in rows]
            series = [fryba(row[0], speed, first, loads) * 1e3 for row in rows]
            scale, slow = -min(quasi), speed < 20.0
            report.near(f"{speed:g} m/s: largest deflection against Fryba's series", -min(bent), -min(series), 0.01 if slow else 0.05, "mm")
            off = max(abs(a - b) for a, b in zip(bent, series)) / scale
            report.below(f"{speed:g} m/s: largest distance from the series, of the static deflection", off, 0.02 if slow else 0.1)
            if slow:
                # Means over one period: without the beam's free vibration, whose phase the axles' mass shifts.
                apart = [a - b for a, b in zip(bent, quasi)]
                span = round(2.0 * math.pi / OMEGA[0] / asked.step)
                off = max(abs(sum(apart[at:at + span]) / span) for at in range(0, len(apart) - span, span // 4)) / scale
                report.below(f"{speed:g} m/s: largest distance from the influence line, means over a period", off, 0.01)
            panels.append((f"middle at {speed:g} m/s, mm", [("coupled", [row[1] for row in rows], bent), ("Fryba's series", [row[1] for row in rows], series),
                                                         ("influence line", [row[1] for row in rows], quasi)], []))
            panels.append((f"leading axle at {speed:g} m/s, kN", [("load", [row[1] for row in rows], [row[3] / 1e3 for row in rows])], []))
        print(f"        first frequency {OMEGA[0] / 2.0 / math.pi:.3f} Hz, axle loads {-loads[0] / 1e3:.2f} kN, {asked.step * 1e3:g} ms")
    if asked.picture:
        draw(asked.picture, "A coach on a bridge of 30 m", "leading axle from the bridge's begin, m", panels)
    report.finish()


if __name__ == "__main__":
    main()
