"""Instances of FMUs of FMI 3.0 for the test scripts, with the interface of `common.Instance`."""

import ctypes

import numpy as np
from fmpy import fmi3
from fmpy.fmi1 import FMICallException

from common import Fmu, Instance

OK, WARNING, DISCARD, ERROR = range(4)


class Fmu3(Fmu):
    """An FMU of FMI 3.0: scalar Float64 outputs, and arrays of them."""

    def __enter__(self):
        super().__enter__()
        variables = self.description.modelVariables
        self.outputs = [v.name for v in variables if v.causality == "output" and v.type == "Float64" and not v.dimensions]
        self.arrays = [v for v in variables if v.dimensions]
        self.contacts = [v.name for v in variables if v.name.endswith(".contacts")]
        return self

    def instance(self, values=None, stop=None, **options):
        return Instance3(self, **options).start(values, stop)


class Instance3(Instance):
    """One co-simulation instance that keeps the time and the log messages."""

    def __init__(self, fmu, token=None, directory=None, log=None, events=False, early=False, update=None, required=(), logging=True):
        self.fmu, self.time, self.slave, self.log, self.events = fmu, 0.0, None, [] if log is None else log, events
        slave = fmi3.FMU3Slave(guid=fmu.description.guid if token is None else token,
                               unzipDirectory=str(directory or fmu.directory),
                               modelIdentifier=fmu.description.coSimulation.modelIdentifier, instanceName="test")
        slave.instantiate(loggingOn=logging, eventModeUsed=events, earlyReturnAllowed=early, logMessage=self._message,
                          intermediateUpdate=update, requiredIntermediateVariables=fmu.references(required))
        self.slave = slave

    def _message(self, _environment, status, _category, message):
        self.log.append((status, (message or b"").decode("utf-8", "replace")))

    def start(self, values=None, stop=None):
        self.set(values or {})
        self.slave.enterInitializationMode(startTime=0.0, stopTime=stop)
        self.slave.exitInitializationMode()
        if self.events:
            self.settle()
        self.time = 0.0
        return self

    def settle(self):
        """In event mode: updates until nothing changes, then on to steps; returns whether the FMU wants to end."""
        needed = True
        while needed:
            needed, terminate, *_ = self.slave.updateDiscreteStates()
        self.slave.enterStepMode()
        return terminate

    def get(self, *names):
        values = self.slave.getFloat64(self.fmu.references(names))
        return values[0] if len(names) == 1 else np.array(values)

    def array(self, name):
        variable = self.fmu.variables[name]
        return np.array(self.slave.getFloat64([variable.valueReference], nValues=int(np.prod(variable.shape)))).reshape(variable.shape)

    def counts(self):
        return self.slave.getInt32(self.fmu.references(self.fmu.contacts))

    def outputs(self):
        return np.array(self.slave.getFloat64(self.fmu.references(self.fmu.outputs)))

    def derivatives(self, *names, order=1):
        return np.array(self.slave.getOutputDerivatives(self.fmu.references(names), [order] * len(names)))

    def step(self, time):
        """fmi3DoStep up to `time`: (event, terminate, early); keeps the time reached."""
        event, terminate, early, self.time = self.slave.doStep(self.time, time - self.time, False)
        return event, terminate, early

    def step_to(self, time):
        """As often as the FMU returns early; events are handled."""
        while self.time < time:
            event, terminate, _ = self.step(time)
            if terminate:
                break
            if event:
                self.slave.enterEventMode()
                self.settle()

    def try_step(self, time):
        """One communication step, whatever its status; returns the status and the messages that came with it."""
        before = len(self.log)
        try:
            self.step(time)
            status = OK
        except FMICallException as failure:
            status = failure.status
        return status, self.log[before:]

    def dependencies(self, reference):
        """Elements of the dependent, and references on which they depend. (FMPy's own call of the first function fails.)"""
        slave, count = self.slave, ctypes.c_size_t()
        slave.fmi3GetNumberOfVariableDependencies(slave.component, reference, ctypes.byref(count))
        elements, others = (ctypes.c_size_t * count.value)(), (ctypes.c_size_t * count.value)()
        references, kinds = (ctypes.c_uint * count.value)(), (ctypes.c_int * count.value)()
        slave.fmi3GetVariableDependencies(slave.component, reference, elements, references, others, kinds, count.value)
        assert set(kinds) <= {fmi3.fmi3Dependent} and set(others) <= {0}
        return list(elements), list(references)

    def bytes(self):
        """The state as bytes."""
        state = self.slave.getFMUState()
        data = self.slave.serializeFMUState(state)
        self.slave.freeFMUState(state)
        return data
