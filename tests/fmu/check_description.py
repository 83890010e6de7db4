"""check_description.py FMU [SECOND_EXPORT]

Validators (FMPy, FMU Manipulation Toolbox, the FMI 2.0 schema) and own checks of modelDescription.xml and of the
archive. With a second export of the same scene: both files must be the same bytes.
"""

import contextlib
import ctypes
import io
import logging
import math
import os
import re
import subprocess
import sys
import tomllib
import warnings
import zipfile

import fmpy
import numpy as np
from fmpy.validation import validate_fmu
from fmu_manipulation_toolbox import checker, operations
from lxml import etree

from common import CONTACTS, INPUTS, SIDES, W, Fmu, main
from terminals import connections

FIXED_TIME = (1980, 1, 1, 0, 0, 0)

REQUIRED_OUTPUTS = [f"{W}.{name}" for name in (
    "distance", "y", "z", "roll", "yaw", "pitchRate", "vy", "vz", "rollRate", "yawRate", "ay", "az",
    "yawAcceleration")]
REQUIRED_OUTPUTS += [f"{W}.{side}.{name}" for side in SIDES for name in (
    "verticalForce", "lateralForce", "longitudinalForce", "normalForce", "derailmentQuotient", "wearNumber",
    "frictionWork")]
REQUIRED_OUTPUTS += [f"{contact}.{name}" for contact in CONTACTS for name in (
    "normalForce", "penetration", "longitudinalCreepage", "lateralCreepage", "spinCreepage", "creepForceX",
    "creepForceY", "spinMoment", "semiAxisA", "semiAxisB", "wheelCoordinate", "railCoordinate", "angle")]

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
UNITS = {name: (1.0, {name: 1}) for name in BASE} | {
    "1": (1.0, {}), "-": (1.0, {}), "%": (0.01, {}), "deg": (math.pi / 180, {"rad": 1}), "mm": (1e-3, {"m": 1}),
    "kN": (1e3, {"kg": 1, "m": 1, "s": -2}), "N": (1.0, {"kg": 1, "m": 1, "s": -2}),
    "J": (1.0, {"kg": 1, "m": 2, "s": -2}), "W": (1.0, {"kg": 1, "m": 2, "s": -3}),
    "Pa": (1.0, {"kg": 1, "m": -1, "s": -2}), "GPa": (1e9, {"kg": 1, "m": -1, "s": -2}), "Hz": (1.0, {"s": -1})}

FUNCTIONS = ["fmi2" + name for name in """
    GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment EnterInitializationMode
    ExitInitializationMode Terminate Reset GetReal GetInteger GetBoolean GetString SetReal SetInteger SetBoolean
    SetString GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate
    GetDirectionalDerivative SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep GetStatus
    GetRealStatus GetIntegerStatus GetBooleanStatus GetStringStatus""".split()]


def validators(report, path):
    report.section("validators")
    problems = validate_fmu(path)
    report.check(not problems, "fmpy.validation.validate_fmu", "; ".join(problems) or "no problem")

    schema = etree.XMLSchema(file=os.path.join(os.path.dirname(fmpy.__file__), "schema", "fmi2",
                                               "fmi2ModelDescription.xsd"))
    with zipfile.ZipFile(path) as archive:
        xml = archive.read("modelDescription.xml")
    schema.validate(etree.fromstring(xml))
    errors = [f"line {e.line}: {e.message}" for e in schema.error_log]
    report.check(not errors, "schema fmi2ModelDescription.xsd", "; ".join(errors) or "valid")


class Records(logging.Handler):
    def __init__(self):
        super().__init__(logging.DEBUG)
        self.records = []

    def emit(self, record):
        self.records.append(record)


def toolbox(report, path):
    """Every checker of FMU Manipulation Toolbox, with everything it says."""
    report.section("FMU Manipulation Toolbox")
    handler, root, own = Records(), logging.getLogger(), logging.getLogger("fmu_manipulation_toolbox")
    root.addHandler(handler)
    own.setLevel(logging.DEBUG)
    printed, names = io.StringIO(), []
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed), \
            warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        with operations.FMU(path) as fmu:
            for kind in checker.get_checkers():
                names.append(kind.__name__)
                fmu.apply_operation(kind())
    root.removeHandler(handler)
    own.setLevel(logging.NOTSET)
    bad = [f"{r.levelname}: {r.getMessage()}" for r in handler.records if r.levelno >= logging.WARNING]
    bad += [str(w.message) for w in warned]
    bad += printed.getvalue().splitlines()
    report.check({"OperationGenericCheck", "OperationSemanticCheck"} <= set(names), "checkers", ", ".join(names))
    report.check(not bad, "no error, warning or other output", " | ".join(bad) or "none")
    for wanted in ("This FMU seems to be compliant with FMI-2.0.", "No semantic error against the FMI-2 standard."):
        report.check(any(wanted in r.getMessage() for r in handler.records), "says", wanted)

    command = [sys.executable, "-m", "fmu_manipulation_toolbox", "-input", path, "-summary", "-check"]
    done = subprocess.run(command, capture_output=True, text=True)
    lines = [line for line in (done.stdout + done.stderr).splitlines()
             if re.search(r"\b(WARNING|ERROR|CRITICAL|FATAL|Traceback)\b", line)]
    report.check(done.returncode == 0 and not lines, "fmutool -summary -check",
                 f"exit code {done.returncode} {' | '.join(lines)}".strip())


def parse_unit(name):
    """Factor and exponents of a unit such as N.m/rad or kg.m2; None if it can't be read."""
    factor, exponents = 1.0, {}
    parts = name.split("/")
    if len(parts) > 2:
        return None
    for sign, part in zip((1, -1), parts):
        for item in part.strip("()").split("."):
            match = re.fullmatch(r"([A-Za-z%]+|1|-)(-?\d+)?", item)
            if not match or match[1] not in UNITS:
                return None
            power = sign * int(match[2] or 1)
            scale, powers = UNITS[match[1]]
            factor *= scale ** power
            for base, exponent in powers.items():
                exponents[base] = exponents.get(base, 0) + power * exponent
    return factor, {base: e for base, e in exponents.items() if e}


def units(report, root, variables):
    report.section("units")
    defined, bad = {}, []
    for unit in root.iterfind("UnitDefinitions/Unit"):
        name, base = unit.get("name"), unit.find("BaseUnit")
        if name in defined:
            bad.append(f"{name} defined twice")
        defined[name] = unit
        if base is None:
            bad.append(f"{name} has no BaseUnit")
            continue
        exponents = {key: int(base.get(key)) for key in BASE if base.get(key) not in (None, "0")}
        factor, offset = float(base.get("factor", 1)), float(base.get("offset", 0))
        expected = parse_unit(name)
        if expected is None:
            report.note(f"unit {name} is not known to this script: {exponents}, factor {factor}")
        elif exponents != expected[1] or not math.isclose(factor, expected[0], rel_tol=1e-9) or offset:
            bad.append(f"{name}: {exponents}, factor {factor}, offset {offset}, expected {expected}")
        for display in unit.iterfind("DisplayUnit"):
            other = parse_unit(display.get("name"))
            if expected and other:
                if other[1] != expected[1]:
                    bad.append(f"display unit {display.get('name')} of {name} has another dimension")
                elif not math.isclose(float(display.get("factor", 1)), expected[0] / other[0], rel_tol=1e-9):
                    bad.append(f"display unit {display.get('name')} of {name}: factor {display.get('factor')}")
    report.check(not bad, "units defined once, with the right base unit", "; ".join(bad) or ", ".join(defined))

    types = {t.get("name"): t[0] for t in root.iterfind("TypeDefinitions/SimpleType")}
    bad, used = [], set()
    for variable in variables:
        value = variable[0]
        if value.tag != "Real":
            continue
        unit = value.get("unit") or getattr(types.get(value.get("declaredType")), "attrib", {}).get("unit")
        used.add(unit)
        if unit not in defined:
            bad.append(f"{variable.get('name')} ({unit})")
        display = value.get("displayUnit")
        if display and unit in defined and display not in [d.get("name") for d in defined[unit].iter("DisplayUnit")]:
            bad.append(f"{variable.get('name')} (display unit {display})")
    report.check(not bad, "every Real has a defined unit", "; ".join(bad) or f"{len(used)} units in use")
    if set(defined) - used:
        report.note(f"units not used: {', '.join(sorted(set(defined) - used))}")


def single_wheelset(report, variables, kinds):
    """What the FMU of one wheelset must have."""
    missing = [name for name in REQUIRED_OUTPUTS if kinds.get(name) != "output"]
    report.check(not missing, "outputs", f"missing {missing}" if missing else f"{len(REQUIRED_OUTPUTS)} wanted ones")
    along = {kinds.get(f"{W}.drivingForce"), kinds.get(f"{W}.longitudinalForceInput")} - {None}
    report.check(along in ({"output"}, {"input"}), "an imposed speed needs a driving force, a free wheelset has an input for it", str(along))
    missing = [name for name in INPUTS if kinds.get(name) != "input"]
    report.check(not missing, "inputs", f"missing {missing}" if missing else ", ".join(INPUTS))
    by_name = {v.get("name"): v[0] for v in variables}
    for name in INPUTS[3:]:
        value = by_name.get(name, {})
        found = float(value.get("start", "nan")), float(value.get("min", "nan"))
        report.check(found == (1.0, 0.0), name, f"start and min {found}")
    for name, start in [(f"{W}.initial.y", 0.0), (f"{W}.initial.distance", 0.0)]:
        value = by_name.get(name)
        report.check(value is not None and kinds[name] == "parameter" and float(value.get("start")) == start, name,
                     "no such variable" if value is None else f"{kinds[name]}, start {value.get('start')}")
    name = f"{W}.initial.fromEquilibrium"
    value = by_name.get(name)
    report.check(value is not None and kinds[name] == "parameter" and value.tag == "Boolean"
                 and value.get("start") in ("true", "1"), name,
                 "no such variable" if value is None else f"{value.tag}, start {value.get('start')}")


def vehicle(report, kinds):
    """What the FMU of a vehicle must have, for each wheelset that it shows."""
    wheelsets = sorted({name.removesuffix(".driveTorque") for name in kinds if name.endswith(".driveTorque")})
    report.check(wheelsets, "wheelsets", ", ".join(wheelsets))
    wanted = {"y": "output", "left.verticalForce": "output", "right.lateralForce": "output", "trackShiftingForce": "output",
              "lateralForceInput": "input", "left.frictionFactor": "input", "initial.y": "parameter", "mass": "parameter"}
    missing = [f"{w}.{name}" for w in wheelsets for name, kind in wanted.items() if kinds.get(f"{w}.{name}") != kind]
    report.check(not missing, "variables of each wheelset", f"missing {missing}" if missing else ", ".join(wanted))


def model_variables(report, variables):
    report.section("variables")
    names, references = [v.get("name") for v in variables], [v.get("valueReference") for v in variables]
    report.check(len(set(names)) == len(names), "unique names", f"{len(set(names))} of {len(names)}")
    report.check(len(set(references)) == len(references), "unique value references",
                 f"{len(set(references))} of {len(references)}")
    bad = [v.get("name") for v in variables if not (v.get("description") or "").strip()]
    report.check(not bad, "descriptions", ", ".join(bad) or "all present")

    bad, bounded = [], 0
    for variable in variables:
        value = variable[0]
        if value.tag not in ("Real", "Integer"):
            continue
        numbers = {key: float(value.get(key)) for key in ("start", "min", "max", "nominal") if value.get(key)}
        low, high = numbers.get("min", -math.inf), numbers.get("max", math.inf)
        bounded += "min" in numbers or "max" in numbers
        if (not all(map(math.isfinite, numbers.values())) or low > high or numbers.get("nominal", 1.0) <= 0
                or not low <= numbers.get("start", max(low, min(0.0, high))) <= high):
            bad.append(f"{variable.get('name')} {numbers}")
    report.check(not bad, "start within min and max, nominal > 0", "; ".join(bad) or f"{bounded} with a bound")

    kinds = {v.get("name"): v.get("causality", "local") for v in variables}
    if f"{W}.y" in kinds:
        single_wheelset(report, variables, kinds)
    else:
        vehicle(report, kinds)
    for word in ("mass", "speed", "tolerance"):
        found = [n for n in names if kinds[n] == "parameter" and word in n.lower()]
        report.check(found, f"a parameter for {word}", ", ".join(found))


def initial_of(variable):
    """The attribute `initial` with the standard's default."""
    if variable.get("initial"):
        return variable.get("initial")
    causality, variability = variable.get("causality", "local"), variable.get("variability", "continuous")
    if causality == "parameter" or variability == "constant":
        return "exact"
    return None if causality in ("input", "independent") else "calculated"


def model_structure(report, root, variables):
    report.section("model structure")
    name = [None] + [v.get("name") for v in variables]
    outputs = {i for i, v in enumerate(variables, 1) if v.get("causality") == "output"}
    inputs = {i for i, v in enumerate(variables, 1) if v.get("causality") == "input"}
    independent = {i for i, v in enumerate(variables, 1) if v.get("causality") == "independent"}
    states = {int(v[0].get("derivative")) for v in variables if v[0].get("derivative")}
    exact = {i for i, v in enumerate(variables, 1) if initial_of(v) == "exact"}
    known = {"Outputs": inputs | states | independent, "Derivatives": inputs | states | independent,
             "InitialUnknowns": inputs | exact | independent}
    lists, bad = {}, []
    for section in known:
        entries = root.findall(f"ModelStructure/{section}/Unknown")
        lists[section] = [int(e.get("index")) for e in entries]
        for entry in entries:
            index, raw = int(entry.get("index")), entry.get("dependencies")
            what = f"{section}: {name[index] if index < len(name) else index}"
            if raw is None:
                if entry.get("dependenciesKind") is not None:
                    bad.append(f"{what} has dependenciesKind without dependencies")
                continue
            found = [int(d) for d in raw.split()]
            if found != sorted(set(found)):
                bad.append(f"{what}: dependencies not in ascending order")
            strangers = [name[d] if 0 < d < len(name) else d for d in found if d not in known[section]]
            if strangers:
                bad.append(f"{what} depends on {strangers}, which are not knowns")
            kind = entry.get("dependenciesKind")
            if kind is not None:
                allowed = {"dependent", "constant"} if section == "InitialUnknowns" else \
                    {"dependent", "constant", "fixed", "tunable", "discrete"}
                if len(kind.split()) != len(found) or not set(kind.split()) <= allowed:
                    bad.append(f"{what}: dependenciesKind {kind}")
    report.check(not bad, "dependencies", "; ".join(bad) or "each on a known, in order")
    report.check(sorted(lists["Outputs"]) == sorted(outputs), "Outputs",
                 f"{len(lists['Outputs'])} entries for {len(outputs)} outputs")

    expected = {i for i, v in enumerate(variables, 1) if v.get("causality") == "calculatedParameter"
                or v.get("causality") == "output" and initial_of(v) in ("approx", "calculated")}
    for index in lists["Derivatives"]:
        for i in (index, int(variables[index - 1][0].get("derivative", 0))):
            if i and initial_of(variables[i - 1]) in ("approx", "calculated"):
                expected.add(i)
    found = lists["InitialUnknowns"]
    detail = [f"missing {name[i]}" for i in sorted(expected - set(found))]
    detail += [f"not wanted {name[i]}" for i in sorted(set(found) - expected)]
    detail += ["not in ascending order"] if found != sorted(set(found)) else []
    report.check(not detail, "InitialUnknowns", "; ".join(detail) or f"{len(found)} entries, complete and in order")


def header(report, root):
    report.section("header")
    for key in ("modelName", "description", "author", "version", "license", "copyright", "generationTool"):
        report.check((root.get(key) or "").strip(), key, root.get(key) or "missing")
    report.check(re.search(r"[0-9a-fA-F]{8}", root.get("guid") or ""), "guid", root.get("guid") or "missing")
    report.check(root.get("generationDateAndTime") is None, "no generation date",
                 root.get("generationDateAndTime") or "none")
    report.check(root.get("variableNamingConvention") == "structured", "variableNamingConvention",
                 str(root.get("variableNamingConvention")))
    slave = root.find("CoSimulation")
    report.check(slave is not None and root.find("ModelExchange") is None, "co-simulation only")
    for key in ("canGetAndSetFMUstate", "canSerializeFMUstate", "canHandleVariableCommunicationStepSize",
                "canInterpolateInputs"):
        report.check(slave.get(key) in ("true", "1"), key, str(slave.get(key)))
    for key in ("needsExecutionTool", "canRunAsynchronuously", "canBeInstantiatedOnlyOncePerProcess"):
        report.check(slave.get(key, "false") in ("false", "0"), f"not {key}", str(slave.get(key)))
    report.check(slave.get("maxOutputDerivativeOrder") == "2", "maxOutputDerivativeOrder",
                 str(slave.get("maxOutputDerivativeOrder")))
    experiment = root.find("DefaultExperiment")
    experiment = {} if experiment is None else experiment.attrib
    found = [float(experiment.get(key, "nan")) for key in ("startTime", "stopTime", "stepSize")]
    vehicle = all(v.get("name") != f"{W}.y" for v in root.iterfind("ModelVariables/ScalarVariable"))
    good = found[0] == 0.0 and 0.0 < found[2] <= found[1] if vehicle else found == [0.0, 5.0, 0.0025]
    report.check(good, "default experiment", f"start, stop, step {found}")


def archive(report, path, identifier, fmu):
    report.section("archive")
    with zipfile.ZipFile(path) as zf:
        entries = zf.infolist()
        names = [e.filename for e in entries]
        report.check(zf.testzip() is None, "checksums", f"{len(names)} entries, {os.path.getsize(path)} bytes")
        wanted = ["modelDescription.xml", "resources/scene.toml", "documentation/index.html", "model.png"]
        library = f"binaries/{fmpy.platform}/{identifier}{fmpy.sharedLibraryExtension}"
        for name in wanted + [library]:
            report.check(name in names, name, f"{zf.getinfo(name).file_size} bytes" if name in names else "missing")
        bad = [n for n in names if "\\" in n or n.startswith("/") or ".." in n.split("/") or ":" in n]
        report.check(not bad and len(set(names)) == len(names), "paths", ", ".join(bad) or "relative, unique")
        bad = [f"{e.filename} {e.date_time}" for e in entries if e.date_time != FIXED_TIME]
        report.check(not bad, "time stamps", "; ".join(bad) or f"all {FIXED_TIME}")
        bad = [e.filename for e in entries if b"UT" == e.extra[:2]]  # extended time stamp
        report.check(not bad, "no second time stamp", "; ".join(bad) or "none")
        if "resources/scene.toml" in names:
            scene = tomllib.loads(zf.read("resources/scene.toml").decode())
            report.check(scene, "scene.toml can be read", ", ".join(scene))
        if "model.png" in names:
            report.check(zf.read("model.png")[:8] == b"\x89PNG\r\n\x1a\n", "model.png is a PNG image")
        if "documentation/index.html" in names:
            html = zf.read("documentation/index.html").decode()
            links = [link for link in re.findall(r"""(?:src|href)=["']([^"'#]+)""", html)
                     if not re.match(r"[a-z]+:", link) and os.path.normpath("documentation/" + link) not in names]
            report.check("<html" in html.lower() and not links, "documentation",
                         f"broken links {links}" if links else f"{len(html)} characters, no broken link")
            pictures = [etree.fromstring(svg) for svg in re.findall(r"<svg.*?</svg>", html, re.DOTALL)]
            wheels = pictures[0].findall("{*}circle")
            numbers = [float(value) for shape in pictures[0] for name, value in shape.attrib.items() if name in ("x", "y", "cx", "cy", "r", "width", "height")]
            report.check(len(pictures) == 2 and all(0.2 < float(wheel.get("r")) < 0.7 for wheel in wheels) and wheels and np.isfinite(numbers).all(),
                         "drawings of vehicle and axes", f"{len(wheels)} wheelsets, {len(pictures[0].findall('{*}rect'))} bodies")
        causalities = {v.name: v.causality for v in fmu.description.modelVariables}
        connections(report, etree.fromstring(zf.read("terminalsAndIcons/terminalsAndIcons.xml")), names, causalities)
    if library in names:
        shared = ctypes.CDLL(os.path.join(fmu.directory, *library.split("/")))
        missing = [f for f in FUNCTIONS if not hasattr(shared, f)]
        report.check(not missing, "exported functions", ", ".join(missing) or f"{len(FUNCTIONS)} functions")
        if not missing:
            shared.fmi2GetVersion.restype = shared.fmi2GetTypesPlatform.restype = ctypes.c_char_p
            found = shared.fmi2GetVersion(), shared.fmi2GetTypesPlatform()
            report.check(found == (b"2.0", b"default"), "version and types platform", str(found))


def script(report, path, second=None):
    validators(report, path)
    toolbox(report, path)
    with zipfile.ZipFile(path) as zf:
        root = etree.fromstring(zf.read("modelDescription.xml"), etree.XMLParser(remove_comments=True))
    variables = root.findall("ModelVariables/ScalarVariable")
    header(report, root)
    units(report, root, variables)
    model_variables(report, variables)
    model_structure(report, root, variables)
    with Fmu(path) as fmu:
        archive(report, path, root.find("CoSimulation").get("modelIdentifier"), fmu)
    if second is not None:
        report.section("second export")
        with open(path, "rb") as a, open(second, "rb") as b:
            report.check(a.read() == b.read(), "same bytes")


if __name__ == "__main__":
    main(script, "SECOND_EXPORT")
