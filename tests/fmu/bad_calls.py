"""bad_calls.py FMU

Calls that a faulty master could make. Each must end in an error with a message, must change nothing, and the instance
must go on to the results of an undisturbed one, bit for bit.
"""

import os
import pathlib
import re
import shutil
import tempfile
from ctypes import byref, c_double, c_uint, c_void_p

import numpy as np
from fmpy import fmi2
from fmpy.fmi1 import FMICallException

from common import INPUTS, TORQUE, W, Fmu, Instance, grid, main

STEP, STOP = 0.01, 0.8
NAN, INFINITE = float("nan"), float("inf")
ERROR, REFUSED = (fmi2.fmi2Error,), (fmi2.fmi2Discard, fmi2.fmi2Error)


class Attempts:
    """Makes bad calls and watches status and message."""

    def __init__(self, report, instance):
        self.report, self.instance = report, instance

    def __call__(self, what, call, statuses=ERROR, quiet=False):
        before = len(self.instance.log)
        try:
            call()
            status = fmi2.fmi2OK
        except FMICallException as error:
            status = error.status
        messages = [text for _, text in self.instance.log[before:] if text.strip()]
        detail = f"status {status}, {messages[0][:150] if messages else 'no message'}"
        self.report.check(status in statuses and (messages or quiet), what, detail)


def begin(fmu, instance):
    """Inputs for both the disturbed and the undisturbed run."""
    instance.set({TORQUE: 300.0})
    instance.set_derivatives(TORQUE, 1e3, 500.0)


def undisturbed(fmu):
    with Instance(fmu) as instance:
        instance.start(stop=STOP)
        begin(fmu, instance)
        return instance.run(grid(STOP, STEP))


def before_initialisation(report, fmu, expected):
    report.section("before and during initialisation")
    y = f"{W}.initial.y"
    with Instance(fmu) as instance:
        slave, attempt = instance.slave, Attempts(report, instance)
        unknown = 1 + max(v.valueReference for v in fmu.variables.values())
        attempt("doStep before initialisation", lambda: slave.doStep(0.0, STEP))
        attempt("exitInitializationMode before enterInitializationMode", slave.exitInitializationMode)
        attempt("parameter NaN", lambda: instance.set({y: NAN}))
        attempt("parameter infinite", lambda: instance.set({y: INFINITE}))
        attempt("unknown value reference set", lambda: slave.setReal([unknown], [1.0]))
        attempt("a state without initialisation", lambda: slave.setFMUState(c_void_p()))
        slave.setupExperiment(startTime=0.0, stopTime=STOP)
        slave.enterInitializationMode()
        attempt("doStep in initialisation mode", lambda: slave.doStep(0.0, STEP))
        attempt("enterInitializationMode twice", slave.enterInitializationMode)
        attempt("setupExperiment in initialisation mode", lambda: slave.setupExperiment(startTime=0.0))
        attempt("input NaN in initialisation mode", lambda: instance.set({TORQUE: NAN}))
        slave.exitInitializationMode()
        begin(fmu, instance)
        report.same_bits(instance.run(grid(STOP, STEP)), expected, "results after that")
        messages(report, instance)


def running(report, fmu, expected):
    report.section("while running")
    times = grid(STOP, STEP)
    with Instance(fmu) as instance:
        instance.start(stop=STOP)
        begin(fmu, instance)
        rows = [instance.run(times[:40])]
        every_bad_call(report, fmu, instance)
        rows.append(instance.run(times[40:60]))
        every_bad_call(report, fmu, instance, again=True)
        rows.append(instance.run(times[60:-1]))
        slave, attempt = instance.slave, Attempts(report, instance)
        attempt("a step past the stop time", lambda: slave.doStep(instance.time, 2 * STEP), REFUSED)
        attempt("a step just past the stop time", lambda: slave.doStep(instance.time, 1.001 * STEP), REFUSED)
        rows.append(instance.run(times[-1:]))
        attempt("a step after the stop time", lambda: slave.doStep(STOP, STEP), REFUSED)
        report.same_bits(np.vstack(rows), expected, "results with the bad calls in between")
        slave.terminate()
        attempt("doStep after terminate", lambda: slave.doStep(STOP, STEP))
        attempt("an input after terminate", lambda: instance.set({TORQUE: 1.0}))
        messages(report, instance)


class Silent:
    """The second time only what fails is printed."""

    def __init__(self, report):
        self.report, self.count = report, 0

    def check(self, holds, what, detail=""):
        self.count += 1
        return bool(holds) or self.report.check(False, what, detail)


def every_bad_call(report, fmu, instance, again=False):
    printer = Silent(report) if again else report
    slave, now, attempt = instance.slave, instance.time, Attempts(printer, instance)
    component = slave.component
    unknown = 1 + max(v.valueReference for v in fmu.variables.values())
    torque, y, force = fmu.references([TORQUE, f"{W}.y", INPUTS[1]])
    flag, start = fmu.references([f"{W}.initial.fromEquilibrium", f"{W}.initial.y"])
    one, two = (c_uint * 1)(torque), c_double(0.0)

    attempt("unknown value reference got", lambda: slave.getReal([unknown]))
    attempt("unknown value reference set", lambda: slave.setReal([unknown], [1.0]))
    attempt("unknown one after a known one set", lambda: slave.setReal([torque, unknown], [9e3, 1.0]))
    attempt("an output set", lambda: slave.setReal([y], [0.01]))
    attempt("an output after an input set", lambda: slave.setReal([torque, y], [9e3, 0.01]))
    attempt("a fixed parameter set after initialisation", lambda: slave.setReal([start], [0.01]))
    attempt("input NaN", lambda: slave.setReal([torque], [NAN]))
    attempt("input infinite", lambda: slave.setReal([torque], [-INFINITE]))
    attempt("input NaN after a number", lambda: slave.setReal([torque, force], [9e3, NAN]))
    attempt("a Boolean got as Real", lambda: slave.getReal([flag]))
    attempt("a Real got as Boolean", lambda: slave.getBoolean([y]))
    attempt("an Integer that does not exist", lambda: slave.getInteger([0]))
    attempt("a String that does not exist", lambda: slave.setString([0], ["x"]))
    attempt("references NULL", lambda: slave.fmi2GetReal(component, None, 1, byref(two)))
    attempt("values NULL", lambda: slave.fmi2GetReal(component, one, 1, None))
    attempt("instance NULL", lambda: slave.fmi2GetReal(None, one, 1, byref(two)), quiet=True)

    for step in (0.0, -STEP, NAN, INFINITE, -INFINITE):
        attempt(f"step of {step}", lambda: slave.doStep(now, step))
    for point in (now + 0.1, now - 0.1, NAN):
        attempt(f"step from {point:g} s at {now:g} s", lambda: slave.doStep(point, STEP))

    attempt("input derivative of an output", lambda: slave.setRealInputDerivatives([y], [1], [1.0]))
    attempt("input derivative, unknown reference", lambda: slave.setRealInputDerivatives([unknown], [1], [1.0]))
    attempt("input derivative NaN", lambda: slave.setRealInputDerivatives([torque], [1], [NAN]))
    for order in (0, -1, 3):
        attempt(f"input derivative of order {order}", lambda: slave.setRealInputDerivatives([torque], [order], [1.0]))
    attempt("input derivatives, one of them NaN",
            lambda: slave.setRealInputDerivatives([torque, torque], [1, 2], [9e3, NAN]))
    for order in (0, 3):
        attempt(f"output derivative of order {order}", lambda: slave.getRealOutputDerivatives([y], [order]), REFUSED)
    attempt("output derivative, unknown reference", lambda: slave.getRealOutputDerivatives([unknown], [1]))

    attempt("setupExperiment while running", lambda: slave.setupExperiment(startTime=0.0))
    attempt("enterInitializationMode while running", slave.enterInitializationMode)
    attempt("exitInitializationMode while running", slave.exitInitializationMode)
    attempt("cancelStep", slave.cancelStep)
    attempt("directional derivative of an input", lambda: slave.getDirectionalDerivative([torque], [torque], [1.0]))
    attempt("directional derivative by an output", lambda: slave.getDirectionalDerivative([y], [y], [1.0]))
    attempt("directional derivative, unknown reference", lambda: slave.getDirectionalDerivative([unknown], [torque], [1.0]))
    attempt("directional derivative along NaN", lambda: slave.getDirectionalDerivative([y], [torque], [NAN]))
    attempt("directional derivative, pointers NULL", lambda: slave.fmi2GetDirectionalDerivative(component, one, 1, None, 1, None, byref(two)))
    attempt("status of a kind that does not exist", lambda: slave.getStatus(99), REFUSED, quiet=True)

    attempt("state NULL set", lambda: slave.setFMUState(c_void_p()))
    state = slave.getFMUState()
    data = slave.serializeFMUState(state)
    for what, bytes_ in (("cut", data[:-1]), ("cut in half", data[:len(data) // 2]), ("short", data[:3]),
                         ("random", bytes(i * 37 % 251 for i in range(len(data))))):
        attempt(f"state from bytes: {what}", lambda: slave.deserializeFMUState(bytes_))
    slave.freeFMUState(state)

    printer.check(slave.fmi2GetReal(component, None, 0, None) == fmi2.fmi2OK, "nothing got, pointers NULL")
    printer.check(slave.fmi2SetReal(component, None, 0, None) == fmi2.fmi2OK, "nothing set, pointers NULL")
    if again:
        report.check(True, "all of these again", f"{printer.count} calls at {now:g} s")


def messages(report, instance):
    """A message is used as a format: a percent sign must be doubled."""
    texts = [text for _, text in instance.log]
    bad = [text for text in texts if "%" in text.replace("%%", "")]
    report.check(texts and not bad, "messages: no lone percent sign", bad[0] if bad else f"{len(texts)} messages")


def refused(report, fmu, what, **options):
    log = []
    try:
        Instance(fmu, log=log, **options).free()
    except Exception as error:  # fmpy raises a plain Exception
        report.check(options.get("logger") is False or any(text.strip() for _, text in log), what,
                     f"{error}: {log[0][1][:150] if log else 'no message'}")
    else:
        report.check(False, what, "instantiated")


def instantiation(report, fmu, expected):
    report.section("instantiation")
    guid = fmu.description.guid
    digit = re.search(r"[0-9a-f](?=[^0-9a-f]*$)", guid, re.IGNORECASE).start()
    other = guid[:digit] + ("0" if guid[digit] != "0" else "1") + guid[digit + 1:]
    for wrong in (other, "", "{00000000-0000-0000-0000-000000000000}"):
        refused(report, fmu, f"GUID '{wrong}'", guid=wrong)
    refused(report, fmu, "wrong GUID without logger", guid=other, logger=False)

    resources = os.path.join(fmu.directory, "resources")
    scene = open(os.path.join(resources, "scene.toml"), "rb").read()
    number = re.search(rb"=\s*\d*(\d)", scene)
    changed = scene[:number.start(1)] + (b"1" if number[1] != b"1" else b"2") + scene[number.end(1):]
    damages = {"one digit changed": changed, "a table more": scene + b"\n[surplus]\nkey = 1\n",
               "cut in half": scene[:len(scene) // 2], "empty": b"", "not UTF-8": b"\xff\xfe" + scene, "missing": None}
    for what, content in damages.items():
        with tempfile.TemporaryDirectory() as directory:
            copy = os.path.join(directory, "fmu")
            shutil.copytree(fmu.directory, copy)
            target = os.path.join(copy, "resources", "scene.toml")
            os.remove(target)
            if content is not None:
                with open(target, "wb") as file:
                    file.write(content)
            refused(report, fmu, f"scene.toml: {what}", directory=copy)
    with tempfile.TemporaryDirectory() as directory:
        copy = os.path.join(directory, "fmu")
        shutil.copytree(fmu.directory, copy, ignore=shutil.ignore_patterns("resources"))
        refused(report, fmu, "no folder resources", directory=copy)
    with tempfile.TemporaryDirectory() as directory:
        copy = os.path.join(directory, "a folder, with 100 % odd characters äöü")
        shutil.copytree(fmu.directory, copy)
        with Instance(fmu, directory=copy) as instance:
            instance.start(stop=STOP)
            begin(fmu, instance)
            report.same_bits(instance.run(grid(STOP, STEP)), expected, "good resources in an oddly named folder")

    with Instance(fmu) as instance:
        slave = instance.slave
        component = slave.fmi2Instantiate(b"test", fmi2.fmi2ModelExchange, guid.encode(),
                                          pathlib.Path(resources).as_uri().encode(),
                                          byref(slave.callbacks), fmi2.fmi2False, fmi2.fmi2False)
        report.check(component is None, "as model exchange", "refused" if component is None else "instantiated")

    with Instance(fmu, logger=False) as instance:  # no logger, no memory functions
        instance.start(stop=STOP)
        begin(fmu, instance)
        Attempts(report, instance)("input NaN, without logger", lambda: instance.set({TORQUE: NAN}), quiet=True)
        report.same_bits(instance.run(grid(STOP, STEP)), expected, "results without logger")


def extreme(report, fmu, expected):
    report.section("inputs beyond reason")
    for what, values in (("a lateral force of 1e12 N", {INPUTS[1]: 1e12}), ("1e9 N upward", {INPUTS[2]: 1e9}),
                         ("a torque of 1e300 N.m", {TORQUE: 1e300})):
        with Instance(fmu) as instance:
            instance.start(stop=STOP)
            status = fmi2.fmi2OK
            try:
                instance.set(values)
                for time in grid(0.1, STEP):
                    instance.step_to(time)
                last = instance.time
            except FMICallException as error:
                status, last = error.status, instance.time
            if status == fmi2.fmi2Discard:
                last = instance.slave.getRealStatus(fmi2.fmi2LastSuccessfulTime)
            text = instance.log[-1][1][:150] if instance.log else "no message"
            report.check(status in (fmi2.fmi2OK, *REFUSED) and 0.0 <= last <= 0.1 + 1e-9, what,
                         f"status {status} at {last:g} s, {text}")
            if status == fmi2.fmi2OK:
                report.check(np.all(np.isfinite(instance.outputs())), "finite outputs")
            instance.slave.reset()
            instance.start(stop=STOP)
            begin(fmu, instance)
            report.same_bits(instance.run(grid(STOP, STEP)), expected, "results after a reset")


def script(report, path):
    with Fmu(path) as fmu:
        expected = undisturbed(fmu)
        before_initialisation(report, fmu, expected)
        running(report, fmu, expected)
        instantiation(report, fmu, expected)
        extreme(report, fmu, expected)


if __name__ == "__main__":
    main(script)
