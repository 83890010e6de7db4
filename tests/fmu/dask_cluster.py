"""dask_cluster.py FMU NATIVE.csv EXAMPLE

examples/sweep_dask.py on a local cluster of two workers, one of which is killed on the way, against `wheelrail sweep` of the same runs.
"""

import csv
import logging
import os
import pathlib
import signal
import sys
import tempfile

from common import main

PARAMETERS = ["contact.friction=0.2..0.5:0.02", "wheelset.initial.y=0,0.001,0.002"]
SCALARS = ["max:*.derailmentQuotient", "rms:wheelset.y", "min:*.verticalForce", "p99.85:wheelset.*.lateralForce"]
STOP, STEP = 0.5, 0.005


def table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def check(report, fmu, native, path):
    # Workers import the example, too.
    folder = str(pathlib.Path(path).parent)
    sys.path.insert(0, folder)
    os.environ["PYTHONPATH"] = folder
    import sweep_dask as module
    from dask.distributed import Client, LocalCluster

    parameters = [module.values(text) for text in PARAMETERS]
    runs = len(parameters[0][1]) * len(parameters[1][1])
    report.check(runs == 48, "a grid of 16 x 3 runs", str(runs))
    output = pathlib.Path(tempfile.mkdtemp()) / "runs.csv"
    quiet = {"dashboard_address": None, "silence_logs": logging.CRITICAL}
    with LocalCluster(n_workers=2, threads_per_worker=1, **quiet) as cluster, Client(cluster) as client:
        workers = client.run(os.getpid)
        killed = []

        def watch(done):
            if done == 10 and not killed:
                killed.append(list(workers.values())[0])
                os.kill(killed[0], signal.SIGTERM if os.name == "nt" else signal.SIGKILL)

        report.section("48 runs on two workers, one killed after ten")
        made = module.sweep(client, fmu, parameters, SCALARS, STOP, STEP, output, watch)
        report.check(made == runs and len(killed) == 1, "all runs were made, one worker was killed", f"{made} runs, process {killed}")
        rows = table(output)
        report.check([int(row["run"]) for row in rows] == list(range(runs)), "each run has one row, in order")
        report.check(all(row["state"] == "ok" for row in rows), "all of them are ok", str({row["reason"] for row in rows}))

        report.section("going on in a table")
        text = output.read_text()
        lines = text.splitlines(keepends=True)
        output.write_text("".join(lines[:30] + lines[31:40]) + lines[40][:20])  # a row less, and a last line cut off
        made = module.sweep(client, fmu, parameters, SCALARS, STOP, STEP, output)
        report.check(made == 1 + len(lines) - 40, "what is missing is run again, nothing else", str(made))
        report.check(output.read_text() == text, "the table is the same to the byte")

    report.section("against wheelrail sweep")
    native = table(native)
    report.check(len(native) == runs, "the same number of runs")
    worst = 0.0
    for ours, theirs in zip(native, rows):
        for name in SCALARS:
            (column,) = [head for head in ours if head.startswith(name + " [")]
            a, b = float(ours[column]), float(theirs[name])
            worst = max(worst, abs(a - b) / max(abs(a), 1e-12))
    report.below(worst, 1e-9, "largest relative difference of a scalar")


if __name__ == "__main__":
    main(check, "NATIVE.csv", "EXAMPLE")
