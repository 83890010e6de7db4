"""Shared by the FMU test scripts: the report, the FMU and its instances.

Each script is run as `python SCRIPT FMU [ARGS]`, prints what it checked and exits with 0 if all of it held.
"""

import faulthandler
import pathlib
import shutil
import sys
import tempfile

import fmpy
import numpy as np
from fmpy import fmi2
from fmpy.fmi1 import FMICallException

faulthandler.enable()
faulthandler.dump_traceback_later(1200, exit=True)  # s; an FMU that hangs fails

W = "wheelset"
SIDES = ("left", "right")
CONTACTS = tuple(f"{W}.{side}.contact[1]" for side in SIDES)
INPUTS = (f"{W}.driveTorque", f"{W}.lateralForceInput", f"{W}.verticalForceInput",
          f"{W}.left.frictionFactor", f"{W}.right.frictionFactor")
TORQUE = INPUTS[0]
LAST_SUCCESSFUL_TIME = 2  # fmi2StatusKind

# The shipped scene.
MASS, PITCH_INERTIA = 1568.0, 168.0  # kg, kg.m2
LOAD, GRAVITY = 98000.0, 9.81  # N, m/s2
SPEED, RADIUS, FRICTION = 40.0, 0.457, 0.5  # m/s, m, 1
WEIGHT = MASS * GRAVITY + LOAD  # N, on both wheels
CLEAR = {f"{W}.initial.distance": 100.0}  # m, beyond the track disturbance (20 m to 30 m)


class Report:
    """Prints each check with its numbers and counts them."""

    def __init__(self):
        self.name = pathlib.Path(sys.argv[0]).stem
        self.passed = self.failed = 0

    def section(self, title):
        print(f"\n{title}", flush=True)

    def check(self, holds, what, detail=""):
        if holds:
            self.passed += 1
        else:
            self.failed += 1
        print(f"  {'ok  ' if holds else 'FAIL'} {what}{': ' if detail else ''}{detail}", flush=True)
        return bool(holds)

    def note(self, text):
        print(f"       {text}", flush=True)

    def below(self, value, limit, what, unit=""):
        return self.check(value <= limit, what, f"{value:.6g} <= {limit:.6g} {unit}".rstrip())

    def between(self, low, value, high, what, unit=""):
        return self.check(low <= value <= high, what, f"{low:.6g} <= {value:.6g} <= {high:.6g} {unit}".rstrip())

    def near(self, value, expected, tolerance, what, unit=""):
        text = f"{value:.9g} = {expected:.9g} +- {tolerance:.3g} {unit}".rstrip()
        return self.check(abs(value - expected) <= tolerance, what, text)

    def same_bits(self, got, expected, what):
        """Equal bit for bit; says where the first difference is."""
        got, expected = np.asarray(got, dtype=float), np.asarray(expected, dtype=float)
        if got.shape != expected.shape:
            return self.check(False, what, f"shapes {got.shape} and {expected.shape}")
        if got.tobytes() == expected.tobytes():
            return self.check(True, what, f"{got.size} values equal bit for bit")
        where = np.argwhere(got.view(np.uint64) != expected.view(np.uint64))
        first = tuple(int(i) for i in where[0])
        return self.check(False, what, f"{len(where)} of {got.size} values differ, first at {first}: "
                                       f"{float(got[first])!r} and {float(expected[first])!r}")

    def finish(self):
        print(f"\n{self.name}: {self.passed} passed, {self.failed} failed", flush=True)
        sys.exit(1 if self.failed or not self.passed else 0)


class Fmu:
    """An FMU extracted to a temporary folder, with its description."""

    def __init__(self, path):
        self.path = str(path)

    def __enter__(self):
        self.directory = tempfile.mkdtemp(prefix="fmu_")
        fmpy.extract(self.path, self.directory)
        self.description = fmpy.read_model_description(self.directory)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.outputs = [v.name for v in self.description.modelVariables if v.causality == "output" and v.type == "Real"]
        return self

    def __exit__(self, *_):
        shutil.rmtree(self.directory, ignore_errors=True)

    def references(self, names):
        missing = [name for name in names if name not in self.variables]
        if missing:
            raise KeyError(f"the FMU has no variable {', '.join(missing)}")
        return [self.variables[name].valueReference for name in names]

    def parameters(self, word):
        """Names of the Real parameters whose name contains `word`, the shortest first."""
        return sorted((v.name for v in self.description.modelVariables
                       if v.causality == "parameter" and v.type == "Real" and word in v.name.lower()),
                      key=lambda name: (len(name), name))

    def instance(self, values=None, stop=None, **options):
        """A new instance, initialised at time 0."""
        return Instance(self, **options).start(values, stop)


class Instance:
    """One co-simulation instance that keeps the time and the log messages."""

    def __init__(self, fmu, guid=None, directory=None, logger=True, log=None):
        self.fmu, self.time, self.slave, self.log = fmu, 0.0, None, [] if log is None else log
        slave = fmi2.FMU2Slave(guid=fmu.description.guid if guid is None else guid,
                               unzipDirectory=str(directory or fmu.directory),
                               modelIdentifier=fmu.description.coSimulation.modelIdentifier, instanceName="test")
        callbacks = fmi2.fmi2CallbackFunctions()
        if logger:
            callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(self._message)
            callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
            callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        slave.instantiate(callbacks=callbacks, loggingOn=logger)  # raises if it returns NULL
        self.slave = slave

    def _message(self, _environment, _name, status, _category, message):
        self.log.append((status, (message or b"").decode("utf-8", "replace")))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.free()

    def free(self):
        if self.slave is not None:
            self.slave.freeInstance()
            self.slave = None

    def start(self, values=None, stop=None):
        self.slave.setupExperiment(startTime=0.0, stopTime=stop)
        self.set(values or {})
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()
        self.time = 0.0
        return self

    def set(self, values):
        for name, value in values.items():
            kind = self.fmu.variables[name].type
            getattr(self.slave, f"set{kind}")(self.fmu.references([name]), [value])

    def get(self, *names):
        values = self.slave.getReal(self.fmu.references(names))
        return values[0] if len(names) == 1 else np.array(values)

    def outputs(self):
        return np.array(self.slave.getReal(self.fmu.references(self.fmu.outputs)))

    def set_derivatives(self, name, *derivatives):
        """Sets the derivatives of an input: the first, the second ... in one call."""
        references = self.fmu.references([name]) * len(derivatives)
        self.slave.setRealInputDerivatives(references, range(1, len(derivatives) + 1), derivatives)

    def derivatives(self, *names, order=1):
        return np.array(self.slave.getRealOutputDerivatives(self.fmu.references(names), [order] * len(names)))

    def step_to(self, time):
        """One communication step. The state may be set back later, so the FMU must keep what it needs for that."""
        self.slave.doStep(self.time, time - self.time, fmi2.fmi2False)
        self.time = time

    def try_step(self, time):
        """One communication step, whatever its status; returns the status and the messages that came with it."""
        before = len(self.log)
        try:
            status = self.slave.fmi2DoStep(self.slave.component, self.time, time - self.time, 0)
        except FMICallException as failure:
            status = failure.status
        self.time = self.slave.getRealStatus(LAST_SUCCESSFUL_TIME)
        return status, self.log[before:]

    def run(self, times, names=None):
        """Steps through `times`; the values (all outputs without `names`) after each step, one row each."""
        rows = []
        for time in times:
            self.step_to(time)
            rows.append(self.outputs() if names is None else np.atleast_1d(self.get(*names)))
        return np.array(rows)


def grid(stop, step, start=0.0):
    """The times start + step, start + 2 step ... up to stop."""
    count = round((stop - start) / step)
    return [start + (stop - start) * (i + 1) / count for i in range(count)]


def columns(fmu, rows):
    """Rows of all outputs as a dictionary name -> array."""
    return {name: rows[:, i] for i, name in enumerate(fmu.outputs)}


def main(script, *usage):
    """Runs `script(report, fmu_path, *arguments)` with the command line's arguments."""
    if len(sys.argv) < 2 or len(sys.argv) > 2 + len(usage):
        sys.exit(f"usage: python {sys.argv[0]} FMU {' '.join(f'[{u}]' for u in usage)}")
    report = Report()
    print(f"{report.name}: {' '.join(sys.argv[1:])}")
    script(report, *sys.argv[1:])
    report.finish()
