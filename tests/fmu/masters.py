"""masters.py FMU: two instances of one FMU that push each other, under other masters: what they get is what the FMU gives when it is stepped by hand, to the last bit.

libcosim and ecos move outputs to inputs after each step, all at once. Wheelset "one" hands its track-shifting force to "two" as a lateral force, "two" its driving force to "one" as a vertical one: forces of
the size of a disturbance, which come back.
"""

import ctypes
import pathlib
import sys
import zipfile

import numpy as np

from common import Fmu, W, main

# A power of two: seconds and nanoseconds are exact.
STEP, COUNT = 2.0 ** -8, 256
LINKS = {("one", f"{W}.trackShiftingForce"): ("two", f"{W}.lateralForceInput"), ("two", f"{W}.drivingForce"): ("one", f"{W}.verticalForceInput")}
SHOWN = [f"{W}.y", f"{W}.yaw", f"{W}.z", f"{W}.left.verticalForce", f"{W}.right.lateralForce"]


def by_hand(fmu):
    """Outputs become inputs at each communication point, that of the start too."""
    with fmu.instance() as one, fmu.instance() as two:
        instances, rows = {"one": one, "two": two}, []
        for step in range(COUNT):
            moved = {sink: instances[source[0]].get(source[1]) for source, sink in LINKS.items()}
            for (name, variable), value in moved.items():
                instances[name].set({variable: float(value)})
            for instance in instances.values():
                instance.step_to((step + 1) * STEP)
            rows.append([value for instance in instances.values() for value in instance.get(*SHOWN)])
        return np.array(rows)


def package(fmu, file):
    """The same as a package of SSP 1.0. (What `export --ssp` writes has connectors of the whole system and systems within it, which neither of the two knows.)"""
    ssd, ssc = "http://ssp-standard.org/SSP1/SystemStructureDescription", "http://ssp-standard.org/SSP1/SystemStructureCommon"
    kinds = {variable: kind for ends, kind in ((LINKS, "output"), (LINKS.values(), "input")) for _, variable in ends}
    connectors = "".join(f'<ssd:Connector name="{variable}" kind="{kind}"><ssc:Real/></ssd:Connector>' for variable, kind in kinds.items())
    parts = "".join(f'<ssd:Component name="{name}" type="application/x-fmu-sharedlibrary" source="resources/part.fmu"><ssd:Connectors>{connectors}</ssd:Connectors></ssd:Component>'
                    for name in ("one", "two"))
    links = "".join(f'<ssd:Connection startElement="{source}" startConnector="{output}" endElement="{sink}" endConnector="{variable}"/>'
                    for (source, output), (sink, variable) in LINKS.items())
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("SystemStructure.ssd", f'<?xml version="1.0" encoding="UTF-8"?><ssd:SystemStructureDescription xmlns:ssd="{ssd}" xmlns:ssc="{ssc}" version="1.0" name="two">'
                         f'<ssd:System name="root"><ssd:Elements>{parts}</ssd:Elements><ssd:Connections>{links}</ssd:Connections></ssd:System></ssd:SystemStructureDescription>')
        archive.write(fmu.path, "resources/part.fmu")


def libcosim(fmu, ssp=None):
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave
    log_output_level(CosimLogLevel.WARNING)
    if ssp is None:
        execution = CosimExecution.from_step_size(step_size=round(STEP * 1e9))
        slaves = {name: execution.add_local_slave(CosimLocalSlave(fmu_path=fmu.path, instance_name=name)) for name in ("one", "two")}
        for (source, output), (sink, variable) in LINKS.items():
            [out], [into] = fmu.references([output]), fmu.references([variable])
            execution.connect_real_variables(slaves[source], out, slaves[sink], into)
    else:
        execution = CosimExecution.from_ssp_file(str(ssp), round(STEP * 1e9))
        slaves = {name: execution.slave_index_from_instance_name(name) for name in ("one", "two")}
    observer = CosimObserver.create_last_value()
    if not execution.add_observer(observer):
        raise RuntimeError("no observer")
    shown, rows = fmu.references(SHOWN), []
    for _ in range(COUNT):
        if not execution.step():
            raise RuntimeError("a step failed")
        rows.append([value for slave in slaves.values() for value in observer.last_real_values(slave, shown)])
    return np.array(rows)


def ecos(fmu, ssp=None):
    # ecos needs libtbb, which the package of that name puts beside Python.
    found = sorted(pathlib.Path(sys.prefix, "lib").glob("libtbb.so.12"))
    if found:
        ctypes.CDLL(str(found[0]), mode=ctypes.RTLD_GLOBAL)
    from ecospy import EcosSimulation, EcosSimulationStructure
    with EcosSimulationStructure() as structure:
        for name in ("one", "two"):
            structure.add_model(name, fmu.path)
        for (source, output), (sink, variable) in LINKS.items():
            structure.make_real_connection(f"{source}::{output}", f"{sink}::{variable}")
        with EcosSimulation(ssp_path=str(ssp), step_size=STEP) if ssp else EcosSimulation(structure=structure, step_size=STEP) as simulation:
            simulation.init()
            rows = []
            for _ in range(COUNT):
                simulation.step()
                rows.append([simulation.get_real(f"{name}::{variable}") for name in ("one", "two") for variable in SHOWN])
            simulation.terminate()
    return np.array(rows)


def script(report, path):
    with Fmu(path) as fmu:
        expected = by_hand(fmu)
        half = len(SHOWN)
        apart = np.max(np.abs(expected[:, :half] - expected[:, half:]))
        report.check(apart > 100.0, "the two go different ways", f"{apart:.0f} N apart")
        ssp = pathlib.Path(fmu.directory, "two.ssp")
        package(fmu, ssp)
        for name, master in (("libcosim", libcosim), ("ecos", ecos)):
            report.same_bits(master(fmu), expected, f"{name}: {COUNT} steps of {STEP} s")
            report.same_bits(master(fmu, ssp), expected, f"{name}: the same as a package")


main(script)
