"""states.py FMU

FMU states: save and restore, bytes, another instance, reset, two instances side by side; all bit for bit.
"""

import ctypes

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException

from common import CLEAR, INPUTS, TORQUE, W, Fmu, grid, main

SAVE, STOP, STEP = 0.6, 1.0, 0.01  # s; the disturbance is at 0.5 s to 0.75 s
OTHER = CLEAR | {f"{W}.initial.y": 0.002}


def drive(instance):
    """Inputs with a memory: a torque that goes on rising, a lateral force, less friction."""
    instance.set({TORQUE: 200.0, INPUTS[1]: 500.0, INPUTS[4]: 0.8})
    instance.set_derivatives(TORQUE, 3e3, 1e3)


def begin(fmu, values=None):
    """An instance at the time SAVE, with a non-zero history."""
    instance = fmu.instance(values)
    instance.run(grid(0.3, STEP), [])
    drive(instance)
    instance.run(grid(SAVE, STEP, 0.3), [])
    return instance


def save_and_restore(report, fmu):
    report.section("save and restore")
    on, odd = grid(STOP, STEP, SAVE), grid(STOP, 0.0041, SAVE)
    with begin(fmu) as plain, begin(fmu) as instance:
        expected = plain.run(on)
        state = instance.slave.getFMUState()
        report.same_bits(instance.run(on), expected, "saving changes nothing")
        for i in (1, 2):
            instance.slave.setFMUState(state)
            instance.time = SAVE
            report.same_bits(instance.run(on), expected, f"restored, time {i}")
        instance.slave.setFMUState(state)
        instance.time = SAVE
        other = instance.run(odd)
        index = [fmu.outputs.index(f"{W}.{name}") for name in ("y", "yaw")]
        report.below(np.max(np.abs(other[-1] - expected[-1])[index]), 1e-9, "restored, other steps: y, yaw")

        late = instance.slave.getFMUState()
        after = instance.outputs()
        instance.slave.setFMUState(state)
        report.check(not np.array_equal(instance.outputs(), after), "outputs follow the restored state without a step")
        instance.slave.setFMUState(late)
        report.same_bits(instance.outputs(), after, "outputs of a later state")
        reused = instance.slave.getFMUState()
        status = instance.slave.fmi2GetFMUstate(instance.slave.component, ctypes.byref(reused))
        report.check(status == 0, "a state can be written over", f"status {status}")
        for each in (state, late, reused):
            instance.slave.freeFMUState(each)
        report.check(not state.value, "a freed state is NULL", str(state.value))
        empty = ctypes.c_void_p()
        status = instance.slave.fmi2FreeFMUstate(instance.slave.component, ctypes.byref(empty))
        report.check(status == 0, "freeing NULL", f"status {status}")

        report.section("each step taken back once and made again")
        instance.free()
    with begin(fmu) as instance:
        rows = []
        for time in on:
            state = instance.slave.getFMUState()
            back = instance.time
            instance.step_to(time)
            instance.slave.setFMUState(state)
            instance.time = back
            instance.step_to(time)
            rows.append(instance.outputs())
            instance.slave.freeFMUState(state)
        report.same_bits(np.array(rows), expected, f"{len(on)} steps, each made twice")
    return expected


def as_bytes(report, fmu, expected):
    report.section("bytes")
    on = grid(STOP, STEP, SAVE)
    with begin(fmu) as instance:
        state = instance.slave.getFMUState()
        data = instance.slave.serializeFMUState(state)
        report.check(len(data) > 0, "size", f"{len(data)} bytes")
        report.check(instance.slave.serializeFMUState(state) == data, "written twice, the same bytes")
        instance.slave.freeFMUState(state)
        back = instance.slave.deserializeFMUState(data)
        report.check(instance.slave.serializeFMUState(back) == data, "read and written, the same bytes")
        instance.run(on, [])
        instance.slave.setFMUState(back)
        instance.slave.freeFMUState(back)
        instance.time = SAVE
        report.same_bits(instance.run(on), expected, "into the same instance")

    with fmu.instance(OTHER) as instance:
        instance.run(grid(0.2, STEP), [])
        state = instance.slave.deserializeFMUState(data)
        instance.slave.setFMUState(state)
        instance.slave.freeFMUState(state)
        instance.time = SAVE
        report.same_bits(instance.run(on), expected, "into an instance with another history and other parameters")

    result = fmpy.simulate_fmu(fmu.directory, fmu_state=data, start_time=SAVE, stop_time=STOP, output_interval=STEP,
                               output=fmu.outputs, logger=lambda *_: None)
    rows = np.array([[row[name] for name in fmu.outputs] for row in result[1:]])
    limit = 1e-9 * (1.0 + np.max(np.abs(expected), axis=0))
    index = [fmu.outputs.index(f"{W}.{name}") for name in ("distance", "y", "z", "yaw")]
    report.check(rows.shape == expected.shape and np.all((np.max(np.abs(rows - expected), axis=0) <= limit)[index]),
                 "simulate_fmu from the bytes, without initialisation", f"{len(rows)} rows")
    return data


def reset(report, fmu):
    report.section("reset")
    times = grid(0.8, STEP)
    with fmu.instance() as fresh:
        expected = fresh.run(times)
    with begin(fmu, OTHER) as instance:
        instance.slave.reset()
        report.same_bits(instance.start().run(times), expected, "reset after a run: parameters and inputs as new")
        instance.slave.terminate()
        instance.slave.reset()
        report.same_bits(instance.start().run(times), expected, "reset after terminate")
        instance.slave.reset()
        instance.slave.setupExperiment(startTime=0.0)
        instance.slave.enterInitializationMode()
        instance.slave.reset()
        report.same_bits(instance.start().run(times), expected, "reset in initialisation mode")
    with fmu.instance(OTHER) as instance:
        other = instance.run(times)
    report.check(not np.array_equal(other, expected), "the parameters make a difference")


def side_by_side(report, fmu):
    report.section("two instances")
    times = grid(0.8, STEP)
    expected = []
    for values in (None, OTHER):
        with fmu.instance(values) as alone:
            drive(alone)
            expected.append(alone.run(times))
    with fmu.instance() as first, fmu.instance(OTHER) as second:
        for each in (first, second):
            drive(each)
        rows = [], []
        for time in times:
            for each, to in zip((first, second), rows):
                each.step_to(time)
                to.append(each.outputs())
        report.same_bits(np.array(rows[0]), expected[0], "first, interleaved")
        report.same_bits(np.array(rows[1]), expected[1], "second, interleaved")
        state = first.slave.getFMUState()
        second.slave.setFMUState(state)
        first.slave.freeFMUState(state)
        second.time = first.time
        on = grid(STOP, STEP, first.time)
        report.same_bits(second.run(on), first.run(on), "the second takes over the first's state")


def resident():
    """Memory of this process in bytes; nothing where the system does not say."""
    try:
        with open("/proc/self/status") as file:
            return next(int(line.split()[1]) * 1024 for line in file if line.startswith("VmRSS:"))
    except OSError:
        return None


def left_behind(report, fmu):
    report.section("states that are left to the instance")

    def leave(count):
        with fmu.instance() as instance:
            for _ in range(count):
                instance.slave.getFMUState()

    leave(2000)
    before = resident()
    if before is None:
        report.note("the system does not tell a process's memory")
        return
    for _ in range(5):
        leave(2000)
    report.below(resident() - before, 2e7, "memory after 10 000 states (about 10 kB each) that the host did not free", "bytes")
    with fmu.instance() as first, fmu.instance() as second:
        state = first.slave.getFMUState()
        try:
            second.slave.freeFMUState(state)
            report.check(False, "another instance's state is not freed")
        except FMICallException:
            report.check("the one that made a state frees it" in second.log[-1][1], "another instance's state is not freed", second.log[-1][1])
        first.slave.setFMUState(state)
        first.slave.freeFMUState(state)


def script(report, path):
    with Fmu(path) as fmu:
        expected = save_and_restore(report, fmu)
        as_bytes(report, fmu, expected)
        reset(report, fmu)
        side_by_side(report, fmu)
        left_behind(report, fmu)


if __name__ == "__main__":
    main(script)
