"""fmi3_calls.py FMU FOLDER

Calls of FMI 3.0 that a faulty master could make. Each must end in an error with a message and change nothing. FMU is the shipped scene for FMI 2.0;
FOLDER holds three.fmu, the same scene for FMI 3.0.
"""

import os
import shutil
import tempfile
from ctypes import byref, c_bool, c_double, c_int32, c_size_t, c_uint, c_void_p

from fmpy import fmi3
from fmpy.fmi1 import FMICallException

from common import INPUTS, TORQUE, W, grid, main
from common3 import DISCARD, ERROR, OK, Fmu3, Instance3

STEP, STOP = 0.01, 0.6
NAN, INFINITE = float("nan"), float("inf")
# Of other kinds of FMU, of clocks and of structural parameters.
STRANGERS = ("enterConfigurationMode", "exitConfigurationMode", "enterContinuousTimeMode", "evaluateDiscreteStates")


class Attempts:
    """Makes bad calls and watches status and message."""

    def __init__(self, report, instance):
        self.report, self.instance = report, instance

    def __call__(self, what, call, statuses=(ERROR,), quiet=False):
        before = len(self.instance.log)
        try:
            answer = call()
            status = answer if isinstance(answer, int) and not isinstance(answer, bool) else OK
        except FMICallException as error:
            status = error.status
        messages = [text for _, text in self.instance.log[before:] if text.strip()]
        self.report.check(status in statuses and (messages or quiet), what, f"status {status}, {messages[0][:150] if messages else 'no message'}")


def undisturbed(fmu):
    with fmu.instance(stop=STOP) as instance:
        instance.set({TORQUE: 300.0})
        return instance.run(grid(STOP, STEP))


def before_the_run(report, fmu):
    report.section("before and during initialisation")
    with Instance3(fmu) as instance:
        slave, attempt = instance.slave, Attempts(report, instance)
        y = f"{W}.initial.y"
        attempt("a step before initialisation", lambda: slave.doStep(0.0, STEP))
        attempt("exitInitializationMode first", slave.exitInitializationMode)
        attempt("a parameter NaN", lambda: instance.set({y: NAN}))
        attempt("event mode before initialisation", slave.enterEventMode)
        attempt("start time NaN", lambda: slave.enterInitializationMode(startTime=NAN))
        attempt("stop time before the start", lambda: slave.enterInitializationMode(startTime=1.0, stopTime=0.5))
        attempt("tolerance 0", lambda: slave.enterInitializationMode(tolerance=0.0))
        slave.enterInitializationMode(startTime=0.0, stopTime=STOP)
        attempt("initialisation twice", slave.enterInitializationMode)
        attempt("a step in initialisation mode", lambda: slave.doStep(0.0, STEP))
        attempt("step mode in initialisation mode", slave.enterStepMode)
        slave.exitInitializationMode()
        attempt("event mode of a host that has none", slave.enterEventMode)
        attempt("update of discrete states in step mode", slave.updateDiscreteStates)
        attempt("step mode in step mode", slave.enterStepMode)
    with fmu.instance(events=True) as instance:
        slave, attempt = instance.slave, Attempts(report, instance)
        slave.enterEventMode()
        attempt("a step in event mode", lambda: slave.doStep(0.0, STEP))
        attempt("event mode in event mode", slave.enterEventMode)
        instance.settle()
        instance.run(grid(0.05, STEP))
        slave.terminate()
        attempt("a step after termination", lambda: slave.doStep(0.05, STEP))
        attempt("an input after termination", lambda: instance.set({TORQUE: 1.0}))


def running(report, fmu, expected):
    report.section("while running")
    times = grid(STOP, STEP)
    with fmu.instance(stop=STOP) as instance:
        instance.set({TORQUE: 300.0})
        rows = list(instance.run(times[:30]))
        bad_calls(report, fmu, instance)
        rows += list(instance.run(times[30:]))
        report.same_bits(rows, expected, "results with the bad calls in between")


def bad_calls(report, fmu, instance):
    slave, now, attempt = instance.slave, instance.time, Attempts(report, instance)
    c = slave.component
    unknown = 999_999
    torque, y, start, contacts = fmu.references([TORQUE, f"{W}.y", f"{W}.initial.y", f"{W}.left.contacts"])
    one, value, flag, count, number = (c_uint * 1)(torque), (c_double * 2)(), c_bool(), c_size_t(), c_double()
    attempt("unknown value reference got", lambda: slave.getFloat64([unknown]))
    attempt("unknown one after a known one set", lambda: slave.setFloat64([torque, unknown], [9e3, 1.0]))
    attempt("an output set", lambda: slave.setFloat64([y], [0.01]))
    attempt("time set", lambda: slave.setFloat64([0], [0.01]))
    attempt("a fixed parameter set", lambda: slave.setFloat64([start], [0.01]))
    attempt("an input NaN", lambda: slave.setFloat64([torque], [NAN]))
    attempt("an input infinite", lambda: slave.setFloat64([torque], [-INFINITE]))
    attempt("an Int32 got as Float64", lambda: slave.getFloat64([contacts]))
    attempt("a Float64 got as Int32", lambda: slave.getInt32([y]))
    attempt("an Int32 set", lambda: slave.setInt32([contacts], [1]))
    attempt("a String set", lambda: slave.setString(fmu.references(["scene.title"]), ["x"]))
    attempt("fewer values than variables", lambda: slave.fmi3GetFloat64(c, one, 1, value, 0))
    attempt("more values than variables", lambda: slave.fmi3GetFloat64(c, one, 1, value, 2))
    attempt("more values than variables set", lambda: slave.fmi3SetFloat64(c, one, 1, value, 2))
    attempt("more Booleans than variables", lambda: slave.fmi3GetBoolean(c, one, 1, (c_bool * 2)(), 2))
    attempt("references NULL", lambda: slave.fmi3GetFloat64(c, None, 1, value, 1))
    attempt("values NULL", lambda: slave.fmi3GetFloat64(c, one, 1, None, 1))
    attempt("values to set NULL", lambda: slave.fmi3SetFloat64(c, one, 1, None, 1))
    attempt("instance NULL", lambda: slave.fmi3GetFloat64(None, one, 1, value, 1), quiet=True)
    for kind in ("Float32", "Int8", "UInt8", "Int16", "UInt16", "UInt32", "Int64", "UInt64"):
        attempt(f"{kind} got", lambda: getattr(slave, f"get{kind}")([torque]))
        attempt(f"{kind} set", lambda: getattr(slave, f"set{kind}")([torque], [1]))
        attempt(f"no {kind} got", lambda: getattr(slave, f"get{kind}")([]), (OK,), quiet=True)
    attempt("Binary got", lambda: slave.fmi3GetBinary(c, one, 1, byref(count), None, 1))
    attempt("Binary set", lambda: slave.fmi3SetBinary(c, one, 1, byref(count), None, 1))

    for step in (0.0, -STEP, NAN, INFINITE):
        attempt(f"a step of {step}", lambda: slave.doStep(now, step))
    for point in (now + 0.1, now - 0.1, NAN):
        attempt(f"a step from {point:g} s at {now:g} s", lambda: slave.doStep(point, STEP))
    attempt("a step past the stop time", lambda: slave.doStep(now, STOP))
    for place in range(4):
        pointers = [byref(flag), byref(flag), byref(flag), byref(number)]
        pointers[place] = None
        attempt(f"a step with NULL as {place + 1}. answer", lambda: slave.fmi3DoStep(c, now, STEP, True, *pointers))

    for order in (0, 3):
        attempt(f"output derivative of order {order}", lambda: slave.getOutputDerivatives([y], [order]))
    attempt("derivative of an input", lambda: slave.getOutputDerivatives([torque], [1]))
    attempt("derivatives, orders NULL", lambda: slave.fmi3GetOutputDerivatives(c, one, 1, None, value, 1))
    for which in ("Directional", "Adjoint"):
        derivative = getattr(slave, f"get{which}Derivative")
        attempt(f"{which} derivative of an input", lambda: derivative([torque], [torque], [1.0]))
        attempt(f"{which} derivative by an output", lambda: derivative([y], [y], [1.0]))
        attempt(f"{which} derivative, unknown reference", lambda: derivative([unknown], [torque], [1.0]))
        attempt(f"{which} derivative along NaN", lambda: derivative([y], [torque], [NAN]))
        attempt(f"{which} derivative, too many seeds", lambda: derivative([y], [torque], [1.0, 1.0]))
        attempt(f"{which} derivative, too many places", lambda: derivative([y], [torque], [1.0], 2))
        function = getattr(slave, f"fmi3Get{which}Derivative")
        attempt(f"{which} derivative, pointers NULL", lambda: function(c, one, 1, None, 1, None, 1, value, 1))
    attempt("dependencies of an input", lambda: slave.fmi3GetNumberOfVariableDependencies(c, torque, byref(count)))
    attempt("dependencies of nothing", lambda: slave.fmi3GetNumberOfVariableDependencies(c, unknown, byref(count)))
    attempt("number of dependencies to NULL", lambda: slave.fmi3GetNumberOfVariableDependencies(c, y, None))
    force = fmu.references([f"{W}.left.verticalForce"])[0]
    attempt("dependencies, too few places", lambda: slave.fmi3GetVariableDependencies(
        c, force, (c_size_t * 1)(), (c_uint * 1)(), (c_size_t * 1)(), (c_int32 * 1)(), 0))
    attempt("dependencies to NULL", lambda: slave.fmi3GetVariableDependencies(c, force, None, None, None, None, 1))

    for name in STRANGERS:
        attempt(name, lambda: getattr(slave, f"fmi3{name[0].upper()}{name[1:]}")(c))
    attempt("time of model exchange", lambda: slave.fmi3SetTime(c, 0.0))
    attempt("states of model exchange", lambda: slave.fmi3GetContinuousStates(c, value, 2))
    attempt("event indicators", lambda: slave.fmi3GetNumberOfEventIndicators(c, byref(count)))
    attempt("a clock got", lambda: slave.fmi3GetClock(c, one, 1, byref(flag)))
    attempt("a clock set", lambda: slave.fmi3SetClock(c, one, 1, byref(flag)))
    attempt("a clock's interval", lambda: slave.fmi3GetIntervalDecimal(c, one, 1, value, (c_int32 * 1)()))
    attempt("a clock's shift", lambda: slave.fmi3SetShiftDecimal(c, one, 1, value))
    attempt("a model partition", lambda: slave.fmi3ActivateModelPartition(c, torque, 0.0))
    attempt("update of discrete states, in step mode", lambda: slave.fmi3UpdateDiscreteStates(c, *[byref(flag)] * 5, byref(number)))
    attempt("a log category that does not exist", lambda: slave.setDebugLogging(True, ["nothing"]))

    attempt("state NULL set", lambda: slave.setFMUState(c_void_p()))
    state = slave.getFMUState()
    data = slave.serializeFMUState(state)
    for what, wrong in (("cut", data[:-1]), ("short", data[:3]), ("one bit", data[:-1] + bytes([data[-1] ^ 1]))):
        attempt(f"state from bytes: {what}", lambda: slave.deserializeFMUState(wrong))
    attempt("a state to a short buffer", lambda: slave.fmi3SerializeFMUState(c, state, (fmi3.fmi3Byte * 4)(), 4))
    attempt("a state to NULL", lambda: slave.fmi3SerializeFMUState(c, state, None, len(data)))
    attempt("a state's size to NULL", lambda: slave.fmi3SerializedFMUStateSize(c, state, None))
    slave.freeFMUState(state)


def instantiation(report, fmu):
    report.section("instantiation")

    def refused(what, **options):
        log = []
        try:
            Instance3(fmu, log=log, **options).free()
            report.check(False, what, "instantiated")
        except Exception:  # fmpy raises a plain Exception
            report.check(any(text.strip() for _, text in log), what, log[0][1][:150] if log else "no message")

    token = fmu.description.guid
    refused("another token", token=token[:-2] + ("0" if token[-2] != "0" else "1") + token[-1])
    refused("no token", token="")
    refused("no logging: errors are told all the same", token="x", logging=False)
    with tempfile.TemporaryDirectory() as folder:
        copy = os.path.join(folder, "fmu")
        shutil.copytree(fmu.directory, copy)
        with open(os.path.join(copy, "resources", "scene.toml"), "a", encoding="utf-8") as scene:
            scene.write("# one line more\n")
        refused("resources changed", directory=copy)
        shutil.rmtree(os.path.join(copy, "resources"))
        refused("no resources", directory=copy)
        odd = os.path.join(folder, "a folder, with 100 % odd characters äöü")
        shutil.copytree(fmu.directory, odd)
        with Instance3(fmu, directory=odd) as instance:
            report.check(len(instance.start().outputs()) > 10, "an oddly named folder")
    with Instance3(fmu) as instance:
        slave, log = instance.slave, len(instance.log)
        path = os.path.join(fmu.directory, "resources", "").encode()
        common = (b"test", token.encode(), path, False, True)
        me = slave.fmi3InstantiateModelExchange(*common, None, slave.logMessage)
        none = fmi3.fmi3IntermediateUpdateCallback()
        se = slave.fmi3InstantiateScheduledExecution(*common, None, slave.logMessage, fmi3.fmi3ClockUpdateCallback(),
                                                     fmi3.fmi3LockPreemptionCallback(), fmi3.fmi3UnlockPreemptionCallback())
        report.check(not me and not se and len(instance.log) == log + 2, "as model exchange, for scheduled execution", instance.log[-1][1])
        cosimulation = lambda name, token, path, required, n: slave.fmi3InstantiateCoSimulation(
            name, token, path, False, True, False, False, required, n, None, slave.logMessage, none)
        for what, arguments in {"no name": (None, token.encode(), path, None, 0), "a blank name": (b" ", token.encode(), path, None, 0),
                                "token NULL": (b"x", None, path, None, 0), "resource path NULL": (b"x", token.encode(), None, None, 0),
                                "intermediate variables NULL": (b"x", token.encode(), path, None, 3),
                                "intermediate variables unknown": (b"x", token.encode(), path, (c_uint * 1)(77), 1)}.items():
            log = len(instance.log)
            report.check(not cosimulation(*arguments) and len(instance.log) == log + 1, what, instance.log[-1][1])
        silent = slave.fmi3InstantiateCoSimulation(b"x", token.encode(), path, False, True, False, False, None, 0, None,
                                                   fmi3.fmi3LogMessageCallback(), none)
        report.check(bool(silent), "no logger")
        try:
            slave.fmi3EnterStepMode(silent)
            report.check(False, "an error without logger")
        except FMICallException as failure:
            report.check(failure.status == ERROR, "an error without logger")
        slave.fmi3FreeInstance(silent)
        slave.fmi3FreeInstance(None)
        percent = [text for _, text in instance.log if "%%" in text]
        report.check(not percent, "messages are no formats")


def script(report, _two, folder):
    with Fmu3(os.path.join(folder, "three.fmu")) as fmu:
        expected = undisturbed(fmu)
        before_the_run(report, fmu)
        running(report, fmu, expected)
        instantiation(report, fmu)


if __name__ == "__main__":
    main(script, "FOLDER")
