"""system.py FMU WHEELSET.ssp COACH.ssp: systems around an FMU are valid SSP 1.0, and run under FMPy as the FMU does alone."""

import pathlib
import tempfile
import zipfile

import numpy as np
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd

from common import Fmu, main

STEP, STOP = 0.01, 0.2


def structure(report, path):
    """The system, read and held against the schema of SSP 1.0; every input of the vehicle has one source, and placeholders see what they need."""
    ssd = read_ssd(path, validate=True)
    report.check(ssd.version == "1.0", f"{pathlib.Path(path).name}: valid by the schema of SSP 1.0")
    vehicle, *placeholders = ssd.system.elements
    inputs = [c.name for c in vehicle.connectors if c.kind == "input"]
    driven = [c.endConnector for c in ssd.system.connections if c.endElement == vehicle.name]
    report.check(sorted(driven) == sorted(inputs) and len(set(driven)) == len(driven), "each input of the vehicle is driven once",
                 f"{len(inputs)} inputs, placeholders {', '.join(p.name for p in placeholders)}")
    names = [c.name for p in placeholders for c in p.connectors] + [c.name for c in ssd.system.connectors] + [p.name for p in placeholders]
    report.check(all(name.isidentifier() for name in names), "own names are letters, digits and underscores")
    known = {(e.name, c.name) for e in ssd.system.elements for c in e.connectors} | {(None, c.name) for c in ssd.system.connectors}
    ends = {(c.startElement, c.startConnector) for c in ssd.system.connections} | {(c.endElement, c.endConnector) for c in ssd.system.connections}
    report.check(ends <= known, "every connection has both ends")
    return ssd, inputs


def runs(report, path, ssd, inputs):
    """FMPy's master moves values along connections after each step, and begins with zeros: the same calls without the system give the same bits."""
    with tempfile.TemporaryDirectory() as folder:
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder)
        with Fmu(pathlib.Path(folder) / ssd.system.elements[0].source) as fmu:
            start = {name: float(fmu.variables[name].start) for name in inputs}
            demands = {c.endConnector: c.startConnector for c in ssd.system.connections if c.startElement is None}
            report.check(sorted(demands) == sorted(inputs), "each input comes from one of the whole system")
            torque = next(name for name in inputs if name.endswith(("driveTorque", "largestTorque")))
            values = start | {torque: start[torque] + 700.0}
            by_name = {demand: values[name] for name, demand in demands.items()}
            rows = simulate_ssp(path, stop_time=STOP, step_size=STEP, input={name: lambda _, value=value: value for name, value in by_name.items()})
            with fmu.instance() as alone:
                time, found = 0.0, []
                while time < STOP:
                    alone.set(values if found else dict.fromkeys(inputs, 0.0))
                    alone.step_to(time + STEP)
                    found.append(alone.outputs())
                    time += STEP
            theirs = np.array([rows[f"vehicle.{name}"] for name in fmu.outputs]).T
            report.same_bits(theirs, np.array(found), f"{pathlib.Path(path).name} under FMPy is the FMU alone, {len(found)} steps")
            shown = [name for name in rows.dtype.names if name.split(".")[0] in {p.name for p in ssd.system.elements[1:]}]
            report.check(shown, "placeholders see what the vehicle shows", f"{len(shown)} connectors")


def script(report, _fmu, *paths):
    for path in paths:
        report.section(pathlib.Path(path).name)
        runs(report, path, *structure(report, path))


main(script, "WHEELSET", "COACH")
