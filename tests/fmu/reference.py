"""reference.py FMU CURVE THREE: the results that an FMU carries are those that it gives, and variables that say they are derivatives are.

FMU and CURVE are of FMI 2.0, THREE is of FMI 3.0 and the same scene as FMU.
"""

import csv
import io
import posixpath
import zipfile

import fmpy
import numpy as np
from lxml import etree

from common import Fmu, main
from common3 import Fmu3

FOLDER = "extra/org.fmi-standard.fmi-ls-ref/"
LAYERED = "{http://fmi-standard.org/fmi-ls-manifest}"


def carried(report, path):
    """Names and rows of the reference results, found as the layered standard says."""
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        root = etree.fromstring(archive.read(FOLDER + "fmi-ls-manifest.xml"))
        report.check(root.tag == "fmiReferences" and root.get(LAYERED + "fmi-ls-name") == "org.fmi-standard.fmi-ls-ref"
                     and root.get(LAYERED + "fmi-ls-version"), "manifest of FMI-LS-REF", root.get(LAYERED + "fmi-ls-version"))
        related = {entry.get("role"): posixpath.normpath(FOLDER + entry.get("source")) for entry in root}
        report.check(set(related) == {"result", "model", "document"} and set(related.values()) <= set(names), "related files are there",
                     ", ".join(sorted(related.values())))
        table = list(csv.reader(io.StringIO(archive.read(related["result"]).decode())))
    return table[0], np.array(table[1:], dtype=float)


def results(report, fmu, what):
    names, rows = carried(report, fmu.path)
    report.check(names[0] == "time" and names[1:] == fmu.outputs, f"{what}: every output has its column", f"{len(names)} columns")
    report.check(len(rows) > 10 and rows[0, 0] == 0 and np.all(np.diff(rows[:, 0]) > 0), f"{what}: rows", f"{len(rows)} to {rows[-1, 0]} s")
    with fmu.instance() as instance:
        found = np.vstack([instance.outputs(), instance.run(rows[1:, 0])])
    report.same_bits(found, rows[:, 1:], f"{what}: a run gives the results that are carried")
    return rows


def derivatives(report, fmu, what, least):
    """Each variable with the attribute `derivative` against central differences of the output that it names, and against what the FMU says its derivative is."""
    pairs = [(v.derivative, v) for v in fmu.description.modelVariables if v.derivative is not None]
    pairs = [(i.name if hasattr(i, "name") else fmu.description.modelVariables[int(i) - 1].name, v.name) for i, v in pairs]
    report.check(len(pairs) >= least, f"{what}: derivatives", f"{len(pairs)} such as {pairs[0][1]} of {pairs[0][0]}")
    worst, where, h = 0.0, "", 5e-5
    with fmu.instance({"wheelset.lateralForceInput": 2e3} if "wheelset.lateralForceInput" in fmu.variables else {}) as instance:
        for time in np.arange(1, 24) * 0.02:
            def integrals():
                return np.atleast_1d(instance.get(*(integral for integral, _ in pairs)))

            instance.step_to(time - h)
            before = integrals()
            instance.step_to(time)
            told = instance.derivatives(*(integral for integral, _ in pairs))
            values = np.atleast_1d(instance.get(*(name for _, name in pairs)))
            report.same_bits(told, values, f"{what}: the FMU's derivatives at {time:.2f} s")
            instance.step_to(time + h)
            error = np.abs((integrals() - before) / (2 * h) - values) / np.maximum(np.abs(values), 1.0)
            if error.max() > worst:
                worst, where = error.max(), pairs[error.argmax()][1]
    report.below(worst, 1e-4, f"{what}: d/dt of the variable that is named, worst {where}", "relative, from 1 SI unit on")


def distances(report, fmu):
    """In a curve a distance along the centre line grows by more than the centre travels on its inner side: no output is its derivative, but the FMU tells it."""
    names, h = [name for name in fmu.outputs if name.endswith(".distance") and "wheelset" in name], 5e-5
    report.check(not any(v.derivative is not None and v.name.endswith(".vx") for v in fmu.description.modelVariables), "no speed is named")
    with fmu.instance() as instance:
        instance.step_to(4.0 - h)
        before = instance.get(*names)
        instance.step_to(4.0)
        told, speeds = instance.derivatives(*names), instance.get(*(name.replace(".distance", ".vx") for name in names))
        instance.step_to(4.0 + h)
        slopes = (np.array(instance.get(*names)) - np.array(before)) / (2 * h)
    report.below(np.abs(slopes - told).max(), 1e-6, "derivatives of distances", "m/s")
    report.check(np.abs(slopes - speeds).max() > 1e-5, "which speeds are not", f"up to {np.abs(slopes - speeds).max():.1e} m/s")


def script(report, path, curve, three):
    report.section("reference results")
    with Fmu(path) as fmu, Fmu(curve) as coach, Fmu3(three) as other:
        rows = results(report, fmu, "wheelset")
        results(report, coach, "coach in a curve")
        fewer = results(report, other, "FMI 3.0")
        # The second one is stepped through half a second only, the first one through all of its run.
        common = [time for time in fewer[:, 0] if time in rows[:, 0]]
        at = [np.flatnonzero(table[:, 0] == time)[0] for table in (rows, fewer) for time in common]
        report.same_bits(rows[at[:len(common)]], fewer[at[len(common):]], f"both versions at {len(common)} common times")

        report.section("derivatives")
        derivatives(report, fmu, "wheelset", 8)
        derivatives(report, coach, "coach in a curve", 28)
        distances(report, coach)
        named = [v for v in other.description.modelVariables if v.derivative is not None]
        report.check(len(named) >= 8, "FMI 3.0 names them by reference", f"{len(named)}; {fmpy.__version__} reads them")


main(script, "CURVE", "THREE")
