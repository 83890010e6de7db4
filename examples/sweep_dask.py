#!/usr/bin/env python3
"""A parameter sweep over an exported FMU on Dask: on this machine, or on any cluster that Dask knows.

    pip install fmpy dask distributed
    wheelrail export suspended_wheelset -o wheelset.fmu
    python examples/sweep_dask.py wheelset.fmu --set contact.friction=0.2..0.5:0.01 --set wheelset.initial.y=0,0.002,0.004 \\
        --scalar "max:*.derailmentQuotient" --scalar rms:wheelset.y --stop 5 --step 0.005 -o runs.csv --workers 4
    python examples/sweep_dask.py ... --scheduler tcp://head:8786        # a cluster that runs already

Names are those of the FMU's parameters, values SI. Ranges, lists, scalars and the table are those of `wheelrail sweep` (docs/sweep.md). The FMU is sent once
to each worker process and unpacked there; a task is one run: start values there, scalars back. Runs of workers that die are given to others; the same command goes on
where an earlier one ended. Workers need fmpy and the platform that the FMU was exported on.
"""

import argparse
import csv
import fnmatch
import hashlib
import io
import itertools
import json
import pathlib
import re
import tempfile
import zipfile

import fmpy
import numpy as np
from dask.distributed import Client, LocalCluster, WorkerPlugin, as_completed, get_worker


def values(text):
    """`KEY=VALUES` as (key, list of numbers or words)."""
    key, _, rest = text.partition("=")
    found = re.fullmatch(r"\s*(\S+?)\.\.(\S+?):(\S+)\s*", rest)
    if not found:
        return key.strip(), [number(word) for word in rest.split(",")]
    start, stop, step = map(float, found.groups())
    if not step > 0 or stop < start:
        raise SystemExit(f"--set {text}: expected FROM..TO:STEP with a step above 0")
    # Without what sums of steps leave behind.
    return key.strip(), [float(f"{start + k * step:.11e}") for k in range(int((stop - start) / step + 1e-9) + 1)]


def number(word):
    try:
        return float(word)
    except ValueError:
        return word.strip()


def matching(pattern, names):
    # Brackets are those of names, not of patterns.
    pattern = re.sub(r"[\[\]]", lambda bracket: f"[{bracket[0]}]", pattern)
    return [name for name in names if name != "time" and fnmatch.fnmatchcase(name, pattern)]


def check(fmu, keys, scalars):
    """Names that the FMU does not have are better known before the work."""
    variables = fmpy.read_model_description(fmu).modelVariables
    parameters = {variable.name for variable in variables if variable.causality == "parameter"}
    outputs = [variable.name for variable in variables if variable.causality == "output"]
    for key in keys:
        if key not in parameters:
            raise SystemExit(f"--set {key}: the FMU has no such parameter")
    for text in scalars:
        kind, _, pattern = text.partition(":")
        if not re.fullmatch(r"min|max|absmax|mean|rms|end|p[0-9.]+", kind) or not matching(pattern, outputs):
            raise SystemExit(f"--scalar {text}: no such output, or no such kind (min, max, absmax, mean, rms, end, p99.85)")


def scalar(text, rows):
    """One number of a run: KIND:PATTERN; `rows` is the result of fmpy."""
    kind, _, pattern = text.partition(":")
    columns = matching(pattern, rows.dtype.names)
    all_values = np.column_stack([rows[name] for name in columns])
    if kind == "end":
        return float(max(all_values[-1], key=abs))
    if kind.startswith("p"):
        return float(np.percentile(all_values, float(kind[1:])))
    of = {
        "min": np.min,
        "max": np.max,
        "mean": np.mean,
        "absmax": lambda x: np.max(np.abs(x)),
        "rms": lambda x: np.sqrt(np.mean(np.square(x))),
    }
    return float(of[kind](all_values))


class Fmu(WorkerPlugin):
    """The FMU on every worker, also on those that come later or again. (Scattered data would not do: Dask keeps one copy of it, which may die.)"""

    def __init__(self, archive):
        self.archive = archive

    def setup(self, worker):
        self.folder = tempfile.TemporaryDirectory(prefix="sweep_fmu_")
        zipfile.ZipFile(io.BytesIO(self.archive)).extractall(self.folder.name)
        self.description = fmpy.read_model_description(self.folder.name)


def run(name, start_values, scalars, stop, step):
    """One run in a worker: how it ended, why, its scalars. Whatever goes wrong is its result."""
    try:
        plugin = get_worker().plugins[name]
        description = plugin.description
        outputs = [variable.name for variable in description.modelVariables if variable.causality == "output"]
        rows = fmpy.simulate_fmu(
            plugin.folder.name,
            model_description=description,
            start_values=start_values,
            stop_time=stop,
            step_size=step,
            output_interval=step,
            output=outputs,
            fmi_call_logger=None,
        )
        # fmpy ends in silence where the FMU discards a step.
        done = float(rows["time"][-1])
        state, reason = ("ok", "") if done > stop - 0.5 * step else ("failed", f"ended at {done} s")
        return state, reason, [scalar(text, rows) for text in scalars]
    except Exception as error:  # a row, not the end of the sweep
        return "failed", " ".join(str(error).split()), [None] * len(scalars)


def sweep(client, fmu, parameters, scalars, stop, step, output, watch=lambda done: None):
    """Makes the runs that `output` has no row of; returns the number of runs made. `watch` is told how many rows there are after each."""
    archive = pathlib.Path(fmu).read_bytes()
    keys = [key for key, _ in parameters]
    check(fmu, keys, scalars)
    points = list(itertools.product(*(own for _, own in parameters)))
    mark = hashlib.sha256(archive + json.dumps([stop, step]).encode()).hexdigest()[:8]
    head = ["run", *keys, "state", *scalars, "reason", "fmu"]
    output, done = pathlib.Path(output), set()
    if output.exists() and output.stat().st_size:
        text = output.read_text()
        whole = text[: text.rfind("\n") + 1]  # without what a killed program left of a last line
        rows = list(csv.reader(io.StringIO(whole)))
        own = [len(row) == len(head) and row[-1] == mark and row[1 : 1 + len(keys)] == [str(v) for v in points[int(row[0])]] for row in rows[1:]]
        if rows[:1] != [head] or not all(own):
            raise SystemExit(f"{output}: the table of another sweep; choose another file, or delete it")
        done = {int(row[0]) for row in rows[1:]}
        output.write_text(whole)
    pending = [index for index in range(len(points)) if index not in done]
    with output.open("a", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        if not output.stat().st_size:
            table.writerow(head)
            file.flush()
        name = f"sweep_fmu_{hashlib.sha256(archive).hexdigest()}"
        client.register_plugin(Fmu(archive), name=name)
        start = {index: dict(zip(keys, points[index])) for index in pending}
        futures = {client.submit(run, name, start[index], scalars, stop, step, pure=False): index for index in pending}
        for future in as_completed(list(futures)):
            index = futures.pop(future)
            # A run that kills worker after worker ends as a row, too.
            gone = ("failed", f"its workers died: {future.exception()}", [None] * len(scalars)) if future.status == "error" else None
            state, reason, found = gone or future.result()
            future.release()
            table.writerow([index, *points[index], state, *("" if x is None else repr(x) for x in found), reason, mark])
            file.flush()
            done.add(index)
            watch(len(done))
        client.unregister_worker_plugin(name)
    rows = list(csv.reader(io.StringIO(output.read_text())))
    ordered = io.StringIO()
    csv.writer(ordered, lineterminator="\n").writerows(rows[:1] + sorted(rows[1:], key=lambda row: int(row[0])))
    beside = output.with_suffix(".part")
    beside.write_text(ordered.getvalue())
    beside.replace(output)
    return len(pending)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fmu")
    parser.add_argument("--set", dest="parameters", action="append", required=True, metavar="NAME=VALUES")
    parser.add_argument("--scalar", dest="scalars", action="append", required=True, metavar="KIND:OUTPUT")
    parser.add_argument("--stop", type=float, required=True, help="s")
    parser.add_argument("--step", type=float, required=True, help="communication step, s")
    parser.add_argument("-o", "--output", required=True, metavar="FILE.csv")
    parser.add_argument("--workers", type=int, default=2, help="processes on this machine")
    parser.add_argument("--scheduler", help="address of a running cluster instead")
    arguments = parser.parse_args()

    client = Client(arguments.scheduler or LocalCluster(n_workers=arguments.workers, threads_per_worker=1, dashboard_address=None))
    parameters = [values(text) for text in arguments.parameters]
    made = sweep(client, arguments.fmu, parameters, arguments.scalars, arguments.stop, arguments.step, arguments.output)
    print(f"{made} runs made; table in {arguments.output}")
    client.shutdown()


if __name__ == "__main__":
    main()
