"""input_table.py FMU DRIVEN TABLE.csv NATIVE.csv

A native run with a table of inputs beside the FMU DRIVEN whose master sets value and slope at each row of the same table.
"""

import csv

import numpy as np

from common import Fmu, main


def rows_of(path):
    with open(path, newline="") as file:
        head, *rows = [row for row in csv.reader(file) if row and not row[0].startswith("#")]
    return head, [[float(cell) for cell in row] for row in rows]


def script(report, _, driven, table, native):
    with Fmu(driven) as fmu:
        beside(report, fmu, table, native)


def beside(report, fmu, table, native):
    names, rows = rows_of(table)
    head, told = rows_of(native)
    outputs = [title.split(" [")[0] for title in head[1:]]
    times = [row[0] for row in rows]

    def set_at(instance, now):
        at = max((index for index, time in enumerate(times) if time <= now), default=None)
        for column, name in enumerate(names[1:], start=1):
            value, slope = (rows[0] if at is None else rows[at])[column], 0.0
            if at is not None and at + 1 < len(rows):
                slope = (rows[at + 1][column] - value) / (times[at + 1] - times[at])
            instance.set({name: value + slope * (now - times[at] if at is not None else 0.0)})
            instance.set_derivatives(name, slope)

    # The speed that the run begins with is set before initialization ends.
    first = {name: rows[0][column] for column, name in enumerate(names[1:], start=1)}
    with fmu.instance(first) as instance:
        set_at(instance, 0.0)
        stops = sorted({row[0] for row in told} | {time for time in times if time < told[-1][0]})
        found = []
        for stop in stops:
            if stop > 0.0:
                instance.step_to(stop)
            if stop in times:
                set_at(instance, stop)
            if any(row[0] == stop for row in told):
                found.append(list(instance.get(*outputs)))
        found, told = np.array(found), np.array(told)[:, 1:]
        report.check(found.shape == told.shape, "rows", f"{found.shape}")
        for column, name in enumerate(outputs):
            size = max(1.0, np.max(np.abs(told[:, column])))
            limit = 1e-4 if "orce" in name or "orque" in name else 1e-9
            report.below(np.max(np.abs(found[:, column] - told[:, column])) / size, limit, name)
        speed = told[:, outputs.index("wheelset.vx")]
        report.between(21.0, np.max(speed), 24.1, "the table drives the speed", "m/s")


main(script, "DRIVEN", "TABLE.csv", "NATIVE.csv")
