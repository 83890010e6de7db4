"""derivatives.py FMU

Output derivatives of order 1 and 2 against central differences of the outputs, and against outputs that are derivatives.
"""

import numpy as np

from common import INPUTS, SIDES, TORQUE, W, Fmu, main

MOTION = [f"{W}.{name}" for name in ("distance", "y", "z", "roll", "yaw", "pitchRate", "vy", "vz", "rollRate",
                                     "yawRate")]
FORCES = [f"{W}.{side}.{name}" for side in SIDES for name in ("verticalForce", "lateralForce", "longitudinalForce")]
RATES = {f"{W}.y": f"{W}.vy", f"{W}.z": f"{W}.vz", f"{W}.yaw": f"{W}.yawRate", f"{W}.vy": f"{W}.ay",
         f"{W}.vz": f"{W}.az", f"{W}.yawRate": f"{W}.yawAcceleration"}
SMALL = 1e-4  # s


def difference(instance, time, read, look):
    """How what `read` gives changes by time: differences over SMALL and SMALL/2 on both sides, of fourth order; `look` is called at the time itself."""
    around = {}
    for offset in (-2, -1, 0, 1, 2):
        instance.step_to(time + offset * SMALL / 2)
        around[offset] = read()
        if offset == 0:
            look()
    wide = (around[2] - around[-2]) / (2 * SMALL)
    narrow = (around[1] - around[-1]) / SMALL
    return (4 * narrow - wide) / 3


def sample(fmu, names, times, values, drive):
    """Derivatives told by the FMU, and differences over SMALL and SMALL/2 on both sides, at the given times."""
    told, differences, outputs = [], [], []
    with fmu.instance(values) as instance:
        drive(instance)

        def look():
            told.append(instance.derivatives(*names))
            outputs.append(dict(zip(fmu.outputs, instance.outputs())))

        for time in times:
            differences.append(difference(instance, time, lambda: instance.get(*names), look))
    return np.array(told), np.array(differences), outputs


def second(report, fmu):
    """Order 2 against central differences of order 1, and against accelerations."""
    report.section("order 2")
    names, moments = MOTION + FORCES, [0.1, 0.53, 0.58, 0.63, 0.68, 0.72, 0.93]
    accelerations = {f"{W}.y": f"{W}.ay", f"{W}.z": f"{W}.az", f"{W}.yaw": f"{W}.yawAcceleration"}
    told, differences = [], []
    with fmu.instance({"solver.tolerance": 1e-13}) as instance:

        def look():
            before = instance.outputs()
            told.append(instance.derivatives(*names, order=2))
            report.same_bits(instance.outputs(), before, "asking for them changes nothing")
            for name, acceleration in accelerations.items():
                off = abs(told[-1][names.index(name)] - instance.get(acceleration))
                # Of yaw it is that output; those across and upward hold the centripetal part in a curve and are no derivatives.
                report.below(off, 0.0 if acceleration == f"{W}.yawAcceleration" else 1e-6, f"d2 {name} / dt2 is {acceleration}")

        for time in moments:
            differences.append(difference(instance, time, lambda: instance.derivatives(*names), look))
        mixed = instance.slave.getRealOutputDerivatives(fmu.references([f"{W}.vy", f"{W}.vy"]), [2, 1])
        alone = [instance.derivatives(f"{W}.vy", order=order)[0] for order in (2, 1)]
        report.same_bits(mixed, alone, "orders may be mixed in one call")
    told, differences = np.array(told), np.array(differences)
    for i, name in enumerate(names):
        scale = np.max(np.abs(differences[:, i]))
        floor = 1e4 if name in FORCES else 1.0
        limit = (5e-3 if name in FORCES else 5e-4) * max(scale, floor)
        report.below(np.max(np.abs(told[:, i] - differences[:, i])), limit, f"{name}, second derivative up to {scale:.3e}")


def compare(report, fmu, what, times, values, drive):
    report.section(what)
    names = MOTION + FORCES
    # Differences of the solution amplify the integrator's error by the square of the contact frequency (1e6 1/s2).
    values = {"solver.tolerance": 1e-13} | (values or {})
    told, differences, outputs = sample(fmu, names, times, values, drive)
    for i, name in enumerate(names):
        scale = np.max(np.abs(differences[:, i]))
        # Below these a derivative is noise: m/s, rad/s, their rates, N/s.
        floor = 1.0 if name in FORCES else 1e-3 if name.endswith("Rate") or ".v" in name else 1e-5
        limit = (2e-2 if name in FORCES else 2e-3) * max(scale, floor)
        error = np.abs(told[:, i] - differences[:, i])
        report.below(np.max(error), limit, f"{name}, derivative up to {scale:.3e}")
    for name, rate in RATES.items():
        other = np.array([o[rate] for o in outputs])
        scale = max(np.max(np.abs(other)), 1e-5)
        report.below(np.max(np.abs(told[:, names.index(name)] - other)), 1e-3 * scale, f"d {name} / dt = {rate}")


def directional(report, fmu):
    """Partial derivatives by inputs, the rest held."""
    report.section("directional derivatives")
    report.check(fmu.description.coSimulation.providesDirectionalDerivative, "the description announces them")
    with fmu.instance() as instance:
        instance.run([0.55, 0.6], [])
        outputs, known = fmu.references(fmu.outputs), fmu.references(INPUTS)
        before = instance.outputs()

        def ask(seeds):
            return np.array(instance.slave.getDirectionalDerivative(outputs, known, list(seeds)))

        columns = np.array([ask(row) for row in np.eye(len(known))]).T
        report.same_bits(instance.outputs(), before, "asking for them changes nothing")
        seeds = np.array([120.0, -3e3, 2e3, 0.05, -0.1])
        size = np.abs(columns) @ np.abs(seeds)
        report.below(np.max(np.abs(ask(seeds) - columns @ seeds) - 1e-11 * size), 0.0, "a mixed seed is the sum of its parts")
        report.below(np.max(np.abs(ask(np.zeros(5)))), 0.0, "no seed, no derivative")
        state = instance.slave.getFMUState()
        for k, (name, h) in enumerate(zip(INPUTS, (500.0, 500.0, 500.0, 2e-3, 2e-3))):
            start, found = instance.get(name), {}
            for part in (-1.0, -0.5, 0.5, 1.0):
                instance.set({name: start + part * h})
                found[part] = np.array(instance.outputs())
                instance.slave.setFMUState(state)
            wide, narrow = (found[1.0] - found[-1.0]) / (2 * h), (found[0.5] - found[-0.5]) / h
            error = np.abs(columns[:, k] - (4 * narrow - wide) / 3)
            rounding = 2e-14 * np.maximum(np.abs(before), 10.0) / h + 1e-9 * np.abs(columns[:, k])
            report.below(np.max(error / rounding), 1.0, f"by {name}: {np.count_nonzero(columns[:, k])} outputs, error over rounding and 1e-9")
        instance.slave.freeFMUState(state)


def script(report, path):
    with Fmu(path) as fmu:
        # Off the ends of the disturbance (0.5 s, 0.75 s), where the rail's curvature may jump.
        compare(report, fmu, "disturbance", [0.1, 0.53, 0.58, 0.63, 0.68, 0.72, 0.81, 0.93, 1.1], None, lambda i: None)

        def drive(instance):
            instance.set({TORQUE: 100.0, INPUTS[1]: 1000.0})
            instance.set_derivatives(TORQUE, 1e4)
            instance.set_derivatives(INPUTS[1], 5e3)

        compare(report, fmu, "1 mm off the centre, with rising torque and lateral force",
                [0.06, 0.11, 0.17, 0.23, 0.31], {f"{W}.initial.distance": 100.0, f"{W}.initial.y": 0.001}, drive)

        second(report, fmu)
        directional(report, fmu)

        report.section("all outputs")
        with fmu.instance() as instance:
            instance.run([0.55, 0.6], [])
            before = instance.outputs()
            told = instance.derivatives(*fmu.outputs)
            report.check(np.all(np.isfinite(told)), "finite", f"{len(told)} derivatives")
            report.same_bits(instance.outputs(), before, "asking for them changes nothing")


if __name__ == "__main__":
    main(script)
