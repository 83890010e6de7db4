"""fmi3.py FMU FOLDER

FMI 3.0 beside FMI 2.0: description, archive, results and states. FMU is the shipped scene for FMI 2.0; FOLDER holds three.fmu, the same
scene for FMI 3.0, bogie.fmu, a bogie, and rails.fmu, a braked coach on rails that move, for FMI 3.0.
"""

import ctypes
import os
import re
import threading
import zipfile

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from lxml import etree

from common import CLEAR, INPUTS, TORQUE, W, Fmu, grid, main
from common3 import Fmu3
from terminals import connections

FMPY = os.path.dirname(fmpy.__file__)
STEP, SAVE, STOP = 0.01, 0.6, 1.0  # s; the disturbance is at 0.5 s to 0.75 s


def description(report, path):
    report.section(f"description of {os.path.basename(path)}")
    problems = validate_fmu(path)
    report.check(not problems, "fmpy.validation.validate_fmu", "; ".join(problems) or "no problem")
    schema = etree.XMLSchema(file=os.path.join(FMPY, "schema", "fmi3", "fmi3ModelDescription.xsd"))
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        root = etree.fromstring(archive.read("modelDescription.xml"))
        html = archive.read("documentation/index.html").decode()
        terminals = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    schema.validate(root)
    errors = [f"line {e.line}: {e.message}" for e in schema.error_log]
    report.check(not errors, "schema fmi3ModelDescription.xsd", "; ".join(errors) or "valid")
    report.check("FMI 3.0" in html and "fmi2" not in html and "{{" not in html, "the page speaks of FMI 3.0")
    report.check(names[0] == "modelDescription.xml" and any(n.startswith(f"binaries/{fmpy.platform_tuple}/") for n in names), "archive",
                 ", ".join(names[:4]))
    report.check(root.get("fmiVersion") == "3.0" and root.get("guid") is None and len(root.get("instantiationToken")) > 20, "version, token")
    flags = dict(root.find("CoSimulation").attrib)
    wanted = {"canHandleVariableCommunicationStepSize": "true", "canGetAndSetFMUState": "true", "canSerializeFMUState": "true",
              "hasEventMode": "true", "providesIntermediateUpdate": "true", "canReturnEarlyAfterIntermediateUpdate": "true",
              "mightReturnEarlyFromDoStep": "true", "providesDirectionalDerivatives": "true", "providesAdjointDerivatives": "true", "maxOutputDerivativeOrder": "2", "providesPerElementDependencies": "true"}
    report.check(wanted.items() <= flags.items() and "fixedInternalStepSize" not in flags, "capabilities", str(flags))
    variables = {v.get("valueReference"): v for v in root.find("ModelVariables")}
    report.check(len(variables) == len(root.find("ModelVariables")), "unique references", str(len(variables)))
    outputs = [v.get("valueReference") for v in root.find("ModelVariables") if v.get("causality") == "output"]
    for section in ("Output", "InitialUnknown"):
        found = [u.get("valueReference") for u in root.iterfind(f"ModelStructure/{section}")]
        report.check(found == outputs, section, f"{len(found)} entries")
    inputs = {r for r, v in variables.items() if v.get("causality") == "input"}
    connections(report, terminals, names, {v.get("name"): v.get("causality") for v in variables.values()})
    bad = []
    for unknown in root.iterfind("ModelStructure/Output"):
        own = variables[unknown.get("valueReference")]
        if unknown.get("dependencies") is None:
            bad += [] if own.get("variability") == "discrete" else [own.get("name")]
        elif not set(unknown.get("dependencies").split()) <= inputs or \
                len(unknown.get("dependenciesKind").split()) != len(unknown.get("dependencies").split()):
            bad.append(own.get("name"))
    report.check(not bad, "dependencies on inputs alone, a kind each", ", ".join(bad[:5]) or "all")
    bad = [v.get("name") for v in variables.values()
           if (v.get("intermediateUpdate") == "true") != (v.get("causality") in ("input", "output") and v.get("variability") == "continuous")]
    report.check(not bad, "inputs and continuous outputs are open to intermediate updates", ", ".join(bad[:5]) or "all")


def beside_two(report, two, three):
    report.section("beside FMI 2.0")
    mine = {v.name: v for v in three.description.modelVariables}
    kinds = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean", "String": "String"}
    # Counters change in steps, which discrete variables may not here.
    def told(v):
        return ("continuous", "1", "Float64") if v.type == "Integer" else (v.variability, v.unit, kinds[v.type])

    bad = [v.name for v in two.description.modelVariables if v.name not in mine or (
        mine[v.name].valueReference, mine[v.name].causality, mine[v.name].start, mine[v.name].min, mine[v.name].description,
        (mine[v.name].variability, mine[v.name].unit, mine[v.name].type)) != (
        v.valueReference, v.causality, v.start, v.min, v.description, told(v))]
    report.check(any(v.type == "Integer" for v in two.description.modelVariables), "there are counters")
    report.check(not bad, "the same variables, references, units, bounds and start values", ", ".join(bad[:4]) or f"{len(two.variables)} variables")
    added = [v.name for v in three.description.modelVariables if v.name not in two.variables and not v.dimensions]
    report.check(added == ["time", f"{W}.left.contacts", f"{W}.right.contacts"], "and beyond them", ", ".join(added))


def symbols(report, fmu):
    """Every function of the official header is there."""
    header = open(os.path.join(FMPY, "c-code", "fmi3FunctionTypes.h"), encoding="utf-8").read()
    functions = re.findall(r"\b(fmi3[A-Z]\w*)TYPE\s*\(", header)
    library = os.path.join(fmu.directory, "binaries", fmpy.platform_tuple,
                           fmu.description.coSimulation.modelIdentifier + fmpy.sharedLibraryExtension)
    shared = ctypes.CDLL(library)
    missing = [f for f in functions if not hasattr(shared, f)]
    report.check(len(functions) > 70 and not missing, "functions of fmi3FunctionTypes.h", ", ".join(missing) or f"{len(functions)}")
    shared.fmi3GetVersion.restype = ctypes.c_char_p
    report.check(shared.fmi3GetVersion() == b"3.0", "fmi3GetVersion")


def simulated(report, two, three):
    report.section("simulate_fmu")
    time = np.linspace(0.0, STOP, 41)
    rows = np.zeros(len(time), dtype=[("time", float)] + [(name, float) for name in INPUTS])
    rows["time"], rows[INPUTS[0]], rows[INPUTS[1]] = time, 800.0 * np.sin(6 * time), 3e3 * (time > 0.4)
    rows[INPUTS[3]] = rows[INPUTS[4]] = 1.0 - 0.3 * time
    values = {f"{W}.initial.y": 0.001, f"{W}.mass": 1700.0}
    run = lambda fmu, **options: fmpy.simulate_fmu(fmu.directory, stop_time=STOP, output_interval=STEP, input=rows, start_values=values,
                                                   output=two.outputs, **options)
    expected, found = run(two), run(three)
    report.same_bits(found.tolist(), expected.tolist(), "inputs, parameters: FMI 3.0 as FMI 2.0")
    found = run(three, early_return_allowed=True, use_event_mode=True)
    report.below(np.max(np.abs(found[f"{W}.y"][-1] - expected[f"{W}.y"][-1])), 1e-6, "with event mode: y at the end", "m")
    whole = fmpy.simulate_fmu(three.path, stop_time=0.1)
    report.check(len(whole) > 10 and set(two.outputs) <= set(whole.dtype.names), "by default", f"{len(whole.dtype.names)} columns")


def drive(instance):
    instance.set({TORQUE: 200.0, INPUTS[1]: 500.0, INPUTS[4]: 0.8})


def begin(fmu, values=None, **options):
    instance = fmu.instance(values, **options)
    instance.run(grid(0.3, STEP), [])
    drive(instance)
    instance.run(grid(SAVE, STEP, 0.3), [])
    return instance


def states(report, two, three):
    report.section("states")
    on = grid(STOP, STEP, SAVE)
    with begin(two) as other, begin(three) as plain, begin(three) as instance, begin(three, events=True, early=True) as handled:
        expected = plain.run(on)
        report.same_bits(other.run(on), expected, "as FMI 2.0, with inputs")
        report.same_bits(handled.run(on), expected, "with events and early returns, at the same times")
        report.same_bits(other.get(*three.outputs), plain.get(*three.outputs), "outputs")
        for order in (1, 2):
            found = [instance.derivatives(*two.outputs, order=order) for instance in (other, plain)]
            report.same_bits(*found, f"derivatives of outputs, order {order}")
        report.same_bits([plain.get("time")], [STOP], "time")
        state = instance.slave.getFMUState()
        for i in (1, 2):
            instance.slave.setFMUState(state)
            instance.time = SAVE
            report.same_bits(instance.run(on), expected, f"restored, time {i}")
        data = instance.slave.serializeFMUState(state)
        report.check(instance.slave.serializeFMUState(state) == data, "written twice, the same bytes", f"{len(data)}")
        instance.slave.freeFMUState(state)
        with three.instance(CLEAR | {f"{W}.initial.y": 0.002}) as second:
            second.run(grid(0.2, STEP), [])
            state = second.slave.deserializeFMUState(data)
            second.slave.setFMUState(state)
            second.slave.freeFMUState(state)
            second.time = SAVE
            report.same_bits(second.run(on), expected, "into an instance with another history and other parameters")
            second.slave.reset()
            report.same_bits(second.start().run(grid(0.2, STEP)), three.instance().run(grid(0.2, STEP)), "reset")
            second.slave.terminate()
        for saved in (True, False):
            # A state of event mode brings its phase along.
            with begin(three, events=True) as events:
                if saved:
                    events.slave.enterEventMode()
                state = events.slave.getFMUState()
                if saved:
                    events.settle()
                events.run(on[:5], [])
                events.slave.setFMUState(state)
                events.slave.freeFMUState(state)
                events.time = SAVE
                if saved:
                    try:
                        events.step(on[0])
                        report.check(False, "a state of event mode")
                    except FMICallException:
                        report.check("event mode" in events.log[-1][1], "a state of event mode", events.log[-1][1])
                    events.settle()
                report.same_bits(events.run(on), expected, f"saved in {'event' if saved else 'step'} mode")


def derivatives(report, two, three):
    report.section("directional and adjoint derivatives")
    outputs, known = three.references(two.outputs), three.references(INPUTS)
    with begin(two) as other, begin(three) as instance:
        columns = [np.array(instance.slave.getDirectionalDerivative(outputs, [one], [1.0])) for one in known]
        expected = [np.array(other.slave.getDirectionalDerivative(two.references(two.outputs), [one], [1.0])) for one in two.references(INPUTS)]
        report.same_bits(np.concatenate(columns), np.concatenate(expected), "as FMI 2.0")
        matrix = np.array(columns).T
        report.check(np.count_nonzero(matrix) > 20, "something reacts", f"{np.count_nonzero(matrix)} pairs")
        seeds = np.cos(np.arange(len(outputs)))
        adjoint = np.array(instance.slave.getAdjointDerivative(outputs, known, list(seeds), len(known)))
        size = np.abs(matrix).T @ np.abs(seeds)
        report.below(np.max(np.abs(adjoint - matrix.T @ seeds) / size), 1e-13, "the adjoint is the transpose")


def side_by_side(report, three):
    report.section("two threads")
    cases = {"first": None, "second": {f"{W}.initial.y": 0.002}}
    alone, found = {}, {}

    def run(name, into):
        with three.instance(cases[name], events=True, early=True) as instance:
            drive(instance)
            into[name] = instance.run(grid(0.8, 0.002))

    for name in cases:
        run(name, alone)
    threads = [threading.Thread(target=run, args=(name, found)) for name in cases]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for name in cases:
        report.same_bits(found[name], alone[name], name)


def arrays(report, path):
    with Fmu3(path) as fmu, fmu.instance() as instance:
        report.section("arrays over wheelsets and wheels")
        instance.run(grid(0.1, STEP), [])
        wheelsets = sorted({v.split(".left.")[0] for v in fmu.variables if v.endswith(".left.verticalForce")})
        shapes = {v.name: tuple(v.shape) for v in fmu.arrays}
        report.check(len(wheelsets) > 1 and shapes.get("wheels.verticalForce") == (len(wheelsets), 2)
                     and shapes.get("wheelsets.y") == (len(wheelsets),), "shapes", f"{len(shapes)} arrays of {wheelsets}")
        count = 0
        for name, shape in shapes.items():
            kind, rest = name.split(".", 1)
            names = [f"{w}.{side}.{rest}" for w in wheelsets for side in ("left", "right")] if kind == "wheels" \
                else [f"{w}.{rest}" for w in wheelsets]
            if instance.array(name).tobytes() != instance.get(*names).tobytes():
                report.check(False, name, f"{instance.array(name)} {instance.get(*names)}")
            count += len(names)
        report.check(count > 60, "each element is its scalar, bit for bit", f"{count} elements")
        name = "wheels.verticalForce"
        variable = fmu.variables[name]
        slave = instance.slave
        both = [variable.valueReference] + fmu.references([f"{wheelsets[0]}.y"])
        values = slave.getFloat64(both, nValues=int(np.prod(variable.shape)) + 1)
        report.same_bits(values, [*instance.array(name).ravel(), instance.get(f"{wheelsets[0]}.y")], "an array and a scalar in one call")
        size = int(np.prod(variable.shape))
        derivatives = (ctypes.c_double * size)()
        slave.fmi3GetOutputDerivatives(slave.component, (ctypes.c_uint * 1)(variable.valueReference), 1, (ctypes.c_int32 * 1)(1), derivatives, size)
        report.same_bits(list(derivatives), instance.derivatives(*[f"{w}.{s}.verticalForce" for w in wheelsets for s in ("left", "right")]),
                         "derivatives of an array")
        declared = {u.variable.name: {d.name for d in u.dependencies} for u in fmu.description.outputs if u.dependencies is not None}
        names = {v.valueReference: v.name for v in fmu.description.modelVariables}
        of_array = instance.dependencies(variable.valueReference)
        scalar = instance.dependencies(fmu.references([f"{wheelsets[1]}.left.verticalForce"])[0])
        own = {names[r] for e, r in zip(of_array[0], of_array[1]) if e == 3}
        report.check(own == declared[f"{wheelsets[1]}.left.verticalForce"] == {names[r] for r in scalar[1]} and set(scalar[0]) == {0},
                     "dependencies of an element are the scalar's", ", ".join(sorted(own)))
        report.check({names[r] for r in of_array[1]} == declared[name], "together they are the array's")


def script(report, path, folder):
    for name in ("three", "bogie", "rails"):
        description(report, os.path.join(folder, f"{name}.fmu"))
    with Fmu(path) as two, Fmu3(os.path.join(folder, "three.fmu")) as three:
        beside_two(report, two, three)
        symbols(report, three)
        simulated(report, two, three)
        states(report, two, three)
        derivatives(report, two, three)
        side_by_side(report, three)
    arrays(report, os.path.join(folder, "bogie.fmu"))


if __name__ == "__main__":
    main(script, "FOLDER")
