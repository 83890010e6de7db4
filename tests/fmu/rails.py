"""rails.py FMU RAILS

A track model as the master's: under each wheel a mass on a spring and a damper, which travels along (no slope). `RAILS` is the
suspended wheelset with inputs `rail_motion` and `centre_forces`. The scheme is that of Verlet: within a communication step the rail
follows a parabola, which the FMU knows from the inputs' derivatives, or is held at its mean over the step.
"""

import numpy as np

from common import CLEAR, SIDES, W, WEIGHT, MASS, Fmu, main

STEP = 1e-4  # s
STIFFNESS, RAIL_MASS = 5e7, 300.0  # N/m, kg, per wheel


class Track:
    """m u'' + d u' + k u = F under each wheel, up positive."""

    def __init__(self, instance, damping, derivatives=True):
        self.instance, self.damping, self.derivatives = instance, damping, derivatives
        self.u, self.v = np.zeros(2), np.zeros(2)
        self.forces = [f"{W}.{side}.railVerticalForce" for side in SIDES]
        self.a = self.acceleration(self.v)

    def acceleration(self, velocity):
        force = self.instance.get(*self.forces)
        return (force - self.damping * velocity - STIFFNESS * self.u) / RAIL_MASS

    def put(self, velocity):
        for side, u, v in zip(SIDES, self.u, velocity):
            self.instance.set({f"{W}.{side}.railVerticalDisplacement": u, f"{W}.{side}.railVerticalVelocity": v})

    def step(self):
        if self.derivatives:
            for side, v, a in zip(SIDES, self.v, self.a):
                self.instance.set_derivatives(f"{W}.{side}.railVerticalDisplacement", v, a)
                self.instance.set_derivatives(f"{W}.{side}.railVerticalVelocity", a)
        else:
            # What is held is the mean over the step.
            now, ahead = self.u, self.v + 0.5 * STEP * self.a
            self.u = now + 0.5 * STEP * self.v + STEP ** 2 / 6.0 * self.a
            self.put(ahead)
            self.u = now
        self.instance.step_to(self.instance.time + STEP)
        # Forces are those of the inputs just set: of the new place of the rail, with the velocity that it is about to have.
        self.u = self.u + STEP * self.v + 0.5 * STEP ** 2 * self.a
        ahead = self.v + STEP * self.a
        self.put(ahead)
        a = self.acceleration(ahead)
        self.v = self.v + 0.5 * STEP * (self.a + a)
        self.a = a
        self.put(self.v)

    def run(self, time):
        rows = []
        for _ in range(round(time / STEP)):
            self.step()
            rows.append((self.instance.time, self.instance.get(f"{W}.z"), self.u[0]))
        return np.array(rows).T


def damped_modes(contact_stiffness, contact_damping, damping):
    """Eigenvalues of half the wheelset on the contact's spring on the rail's mass on the track's spring."""
    k, c, m = contact_stiffness, contact_damping, 0.5 * MASS
    system = np.zeros((4, 4))
    system[0, 2] = system[1, 3] = 1.0
    system[2] = np.array([-k, k, -c, c]) / m
    system[3] = np.array([k, -k - STIFFNESS, c, -c - damping]) / RAIL_MASS
    return np.linalg.eigvals(system)


def free_vibration(times, values):
    """Frequency, Hz, and decay, 1/s, of a damped swing about its end: from its crossings and its peaks."""
    swing = values - values[-1]
    at = np.nonzero(np.diff(np.signbit(swing)))[0]
    crossings = times[at] - swing[at] * np.diff(times)[at] / np.diff(swing)[at]
    crossings = crossings[2:14]
    peaks = np.array([np.max(np.abs(swing[(times > a) & (times < b)])) for a, b in zip(crossings, crossings[1:])])
    middle = 0.5 * (crossings[1:] + crossings[:-1])
    return 0.5 * (len(crossings) - 1) / (crossings[-1] - crossings[0]), -np.polyfit(middle, np.log(peaks), 1)[0]


def script(report, _, path):
    with Fmu(path) as fmu:
        report.section("a wheelset comes onto a soft track")
        names = [f"{W}.{side}.rail{what}" for side in SIDES for what in
                 ("LateralDisplacement", "VerticalDisplacement", "LateralVelocity", "VerticalVelocity", "LateralSlope",
                  "VerticalSlope")]
        units = {fmu.variables[name].unit for name in names}
        report.check(all(fmu.variables[name].causality == "input" for name in names) and units == {"m", "m/s", "1"},
                     "twelve inputs", ", ".join(sorted(units)))
        with fmu.instance(CLEAR) as instance:
            height = instance.get(f"{W}.z")
            track = Track(instance, damping=3e5)
            track.run(0.6)
            static = -0.5 * WEIGHT / STIFFNESS
            for side, u in zip(SIDES, track.u):
                report.near(u, static, 1e-6 * abs(static), f"{side} rail: deflection Q / k", "m")
            report.near(instance.get(f"{W}.z") - height, static, 1e-6 * abs(static), "the wheelset sinks as much", "m")
            load = instance.get(f"{W}.left.verticalForce")
            report.near(instance.get(f"{W}.left.railVerticalForce"), -load, 1e-9 * load, "force on the rail = -Q", "N")

            report.section("a force of 1 kN comes off: free vibration with the mass of the track")
            force, penetration = (instance.get(f"{W}.left.contact[1].{what}") for what in ("normalForce", "penetration"))
            stiffness, damping = 1.5 * force / penetration, 2e9 * penetration
            instance.set({f"{W}.verticalForceInput": -1000.0})
            track.run(0.4)
            instance.set({f"{W}.verticalForceInput": 0.0})
            track.damping = 1e4
            times, z, _ = track.run(1.2)
            modes = damped_modes(stiffness, damping, track.damping)
            slow = min((mode for mode in modes if mode.imag > 0.0), key=abs)
            frequency, decay = free_vibration(times, z)
            report.near(frequency, slow.imag / (2.0 * np.pi), 2e-3 * frequency, "frequency", "Hz")
            report.near(decay, -slow.real, 2e-2 * decay, "decay", "1/s")
            rigid = np.sqrt(STIFFNESS / (0.5 * MASS + RAIL_MASS)) / (2.0 * np.pi)
            report.note(f"on a rigid contact it would be {rigid:.4f} Hz; modes {np.round(modes, 2)}")
            fast = max(modes, key=abs)
            report.note(f"fast mode {abs(fast.imag) / (2.0 * np.pi):.1f} Hz, {abs(fast) * STEP:.3f} rad per step")

        report.section("without derivatives of the inputs: the rail is held at its mean place over each step")
        with fmu.instance(CLEAR) as instance:
            track = Track(instance, damping=3e5, derivatives=False)
            track.run(0.6)
            report.near(track.u[0], static, 1e-5 * abs(static), "deflection Q / k", "m")
            instance.set({f"{W}.verticalForceInput": -1000.0})
            track.run(0.4)
            instance.set({f"{W}.verticalForceInput": 0.0})
            track.damping = 1e4
            times, z, _ = track.run(1.2)
            held, fading = free_vibration(times, z)
            report.near(held, frequency, 1e-3 * frequency, "frequency", "Hz")
            report.near(fading, decay, 5e-2 * decay, "decay", "1/s")


if __name__ == "__main__":
    main(script, "RAILS")
