"""formulations.py FMU FOLDER

Every formulation through the FMU's interface. FMU is the shipped scene; FOLDER holds exports of it with another
`contact.formulation`, NAME.fmu, and for ACCF and ECCF exports with a dip of the right rail that the wheel can't follow,
NAME-stop.fmu and NAME-elastic.fmu (`contact.on_lift`).
"""

import contextlib
import pathlib
import re

import numpy as np
from fmpy.fmi2 import fmi2Discard, fmi2OK, fmi2Warning
from fmpy.validation import validate_fmu
from lxml import etree

from common import CLEAR, CONTACTS, INPUTS, LAST_SUCCESSFUL_TIME, SIDES, TORQUE, W, Fmu, columns, grid, main

CONSTRAINED, ELASTIC = ("ACCF", "ECCF"), ("ECF-A", "ECF-N")
FORMULATIONS = CONSTRAINED + ELASTIC
PRESSING = tuple(f"{W}.{side}.normalForce" for side in SIDES)
ACCELERATIONS = tuple(f"{W}.{name}" for name in ("ay", "az", "rollAcceleration", "yawAcceleration", "pitchAcceleration"))
SECOND = ".contact[2]."
DIP = 0.5  # s, where the dip begins at 20 m; the disturbance of the shipped scene is at 0.5 s to 0.75 s
LANDING = DIP + 0.155  # s, the fifth try (after 5, 10, 20, 40 and 80 ms)
DO_STEP_STATUS = 0
# Another value of each input.
CHANGES = dict(zip(INPUTS, (500.0, 3e3, -5e3, 0.8, 0.7)))


@contextlib.contextmanager
def kept(instance):
    """Puts the instance's state back at the end."""
    state, time = instance.slave.getFMUState(), instance.time
    yield
    instance.slave.setFMUState(state)
    instance.slave.freeFMUState(state)
    instance.time = time


def descriptions(report, fmus, shipped):
    report.section("descriptions")
    kinds, references = {}, {}
    for name, fmu in fmus.items():
        problems = validate_fmu(fmu.path)
        report.check(not problems, f"{name}, fmpy.validation.validate_fmu", "; ".join(problems) or "no problem")
        count = {kind: sum(v.causality == kind for v in fmu.variables.values())
                 for kind in ("input", "output", "parameter", "local")}
        kinds[name] = count
        expected = {"input": 5, "output": 67 + 30 * (name == "ECF-N"), "parameter": 26, "local": 6 + 4 * (name in ("ACCF", "ECCF"))}
        report.check(count == expected, f"{name}, variables", str(count))
        second = [v for v in fmu.variables if SECOND in v]
        first = {v.replace(SECOND, ".contact[1].") for v in second}
        whole = first == {v for v in fmu.outputs if ".contact[1]." in v}
        report.check(whole if name == "ECF-N" else not second, f"{name}, second contacts", f"{len(second)} variables")
        references[name] = {v.name: (v.valueReference, v.causality, v.variability, v.initial, v.start, v.declaredType.name
                                     if v.declaredType else v.type) for v in fmu.variables.values()}
        report.check(fmu.description.numberOfContinuousStates == 0, f"{name}, no continuous states are declared")
    common = set.intersection(*(set(r) for r in references.values()))
    differing = [v for v in common if len({r[v] for r in references.values()}) > 1]
    report.check(not differing and common == set(references["ECF-A"]), "the same variables mean the same everywhere",
                 ", ".join(differing) or f"{len(common)} variables, reference, kind, start and type")
    report.check(len({fmu.description.guid for fmu in fmus.values()}) == len(fmus), "each has its own GUID")
    report.check(shipped.outputs == fmus["ECF-A"].outputs, "the shipped scene has the outputs of ECF-A")


def dependencies(fmu):
    """The names of the inputs that each output is declared to depend on."""
    root = etree.parse(f"{fmu.directory}/modelDescription.xml").getroot()
    names = [None] + [v.get("name") for v in root.findall("ModelVariables/ScalarVariable")]
    return {names[int(u.get("index"))]: {names[int(d)] for d in u.get("dependencies").split()}
            for u in root.findall("ModelStructure/Outputs/Unknown")}


def declared(report, name, fmu):
    report.section(f"{name}: declared dependencies")
    told = dependencies(fmu)
    report.check(sorted(told) == sorted(fmu.outputs), "every output is listed", f"{len(told)} outputs")
    everything = set(INPUTS)
    if name in CONSTRAINED:
        wanted = PRESSING + ACCELERATIONS + tuple(f"{c}.{v}" for c in CONTACTS for v in ("normalForce", "semiAxisA"))
        few = [v for v in wanted if told[v] != everything]
        report.check(not few, "forces and accelerations depend on every input", ", ".join(few) or f"{len(wanted)} outputs")
    else:
        wanted = [v for v in fmu.outputs if v.endswith((".normalForce", ".semiAxisA", ".semiAxisB"))]
        many = [v for v in wanted if told[v]]
        report.check(not many, "normal forces depend on no input", ", ".join(many) or f"{len(wanted)} outputs")
    place = [f"{W}.{v}" for v in ("distance", "y", "z", "yaw", "roll", "vx", "vy", "vz", "rollRate", "yawRate", "pitchRate")]
    report.check(not any(told[v] for v in place), "coordinates and velocities depend on no input")
    return told


def feedthrough(report, what, instance, told, expect_all=True):
    """Changes each input at the present communication point and reads all outputs."""
    fmu = instance.fmu
    before = instance.outputs()
    second = {v for v in fmu.outputs if SECOND in v}
    changed = {v: set() for v in fmu.outputs}
    for name, value in CHANGES.items():
        with kept(instance):
            instance.set({name: value})
            after = instance.outputs()
        for v, a, b in zip(fmu.outputs, after, before):
            if a.tobytes() != b.tobytes():
                changed[v].add(name)
        with kept(instance):
            instance.set_derivatives(name, 1e3, -1e4)
            report.same_bits(instance.outputs(), before, f"{what}: derivatives of {name} alone change nothing now")
    report.same_bits(instance.outputs(), before, f"{what}: inputs taken back")
    wrong = [f"{v} <- {', '.join(sorted(c - told[v]))}" for v, c in changed.items() if c - told[v]]
    independent = sum(len(INPUTS) - len(t) for t in told.values())
    report.check(not wrong, f"{what}: no output changes with an input that it is declared independent of",
                 "; ".join(wrong) or f"{independent} pairs equal bit for bit")
    if expect_all:
        dull = [v for v, t in told.items() if t and not changed[v] and v not in second]
        pairs = sum(len(t) for v, t in told.items() if v not in second)
        met = sum(len(c) for c in changed.values())
        report.check(not dull, f"{what}: every output that is declared dependent changes with an input",
                     ", ".join(dull) or f"{met} of {pairs} declared pairs seen")
        for v in second:
            if told[v]:
                report.check(before[fmu.outputs.index(v)] == 0.0, f"{what}: {v} is 0 without a second contact")
    return changed


def dependent(report, name, fmu):
    told = declared(report, name, fmu)
    report.section(f"{name}: dependencies tried")
    with fmu.instance() as instance:
        first = instance.outputs()
        with kept(instance):
            pass
        report.same_bits(instance.outputs(), first, "start: the first outputs are those of the state")
        # Steady rolling has no lateral force: its friction is tried below.
        feedthrough(report, "start", instance, told, expect_all=False)
        instance.run(grid(0.6, 0.01), [])
        changed = feedthrough(report, "0.6 s", instance, told)
        some = [v for v in PRESSING if changed[v]]
        report.check(len(some) == (2 if name in CONSTRAINED else 0), "normal forces that change with an input", str(some))


def agreement(report, fmus, shipped):
    report.section("formulations agree: y over 2 s every 10 ms")
    times, runs = grid(2.0, 0.01), {}
    for name, fmu in (*fmus.items(), ("shipped", shipped)):
        with fmu.instance() as instance:
            rows = instance.run(times)
        runs[name] = columns(fmu, rows)
        report.check(np.all(np.isfinite(rows)), f"{name}, finite", f"{rows.size} values")
    report.same_bits([runs["shipped"][v] for v in shipped.outputs], [runs["ECF-A"][v] for v in shipped.outputs],
                     "the shipped scene is ECF-A")
    y = {name: run[f"{W}.y"] for name, run in runs.items()}
    report.between(3e-3, np.max(np.abs(y["ECF-A"])), 10e-3, "largest |y|", "m")
    for a, b, low, limit in (("ACCF", "ECCF", 0.0, 1e-6), ("ECF-A", "ECCF", 1e-7, 5e-6), ("ECF-N", "ECF-A", 0.0, 1e-7)):
        found = np.max(np.abs(y[a] - y[b]))
        report.between(low, found, limit, f"{a} and {b}", "m")
        report.check(found > 0.0, f"{a} and {b} are two computations")
    for name in CONSTRAINED:
        gap = np.max(np.abs([runs[name][f"{c}.penetration"] for c in CONTACTS]))
        report.below(gap, 1e-12, f"{name}: penetration at communication points", "m")
    for name in ELASTIC:
        deep = [runs[name][f"{c}.penetration"] for c in CONTACTS]
        report.between(5e-5, np.max(deep), 1e-4, f"{name}: penetration", "m")


def step_sizes(report, name, fmu, stop, marks):
    """Communication steps of 1 ms and 10 ms; statuses are compared over the longer steps."""
    long, short = grid(stop, 0.01), grid(stop, 0.001)
    rows = {}
    for what, times in (("10 ms", long), ("1 ms", short)):
        with fmu.instance() as instance:
            found = []
            for time in times:
                status, messages = instance.try_step(time)
                found.append((status, [m for _, m in messages], instance.outputs()))
            rows[what] = found
    report.same_bits([r[2] for r in rows["1 ms"][9::10]], [r[2] for r in rows["10 ms"]],
                     f"{name}: all outputs, {len(short)} or {len(long)} steps")
    events = {what: [m for _, messages, _ in found for m in messages] for what, found in rows.items()}
    report.check(events["1 ms"] == events["10 ms"] and len(events["1 ms"]) == marks, f"{name}: the same messages",
                 f"{len(events['1 ms'])} and {len(events['10 ms'])}")


def drive(instance):
    instance.set({TORQUE: 200.0, INPUTS[1]: 500.0, INPUTS[4]: 0.8})
    instance.set_derivatives(TORQUE, 3e3, 1e3)


def states(report, name, fmu, save, stop, prepare=drive):
    """Saves a state at `save`, goes on to `stop` and again from the state by several ways."""
    on = grid(stop, 0.004, save)
    other = CLEAR | {f"{W}.initial.y": 0.002}

    def begin(values=None):
        instance = fmu.instance(values)
        for time in grid(0.3, 0.01):
            instance.step_to(time)
        prepare(instance)
        instance.run(grid(save, 0.01, 0.3), [])
        return instance

    def go_on(instance):
        instance.time = save
        found = []
        for time in on:
            status, messages = instance.try_step(time)
            found.append((status, messages, instance.outputs()))
        return [f[:2] for f in found], np.array([f[2] for f in found])

    with begin() as plain, begin() as instance:
        told, expected = go_on(plain)
        state = instance.slave.getFMUState()

        def same(found, what):
            report.same_bits(found[1], expected, f"{name}: {what}")
            report.check(found[0] == told, f"{name}: {what}, statuses and messages", f"{sum(s[0] for s in told)} warnings")

        same(go_on(instance), "saving changes nothing")
        for i in (1, 2):
            instance.slave.setFMUState(state)
            same(go_on(instance), f"restored, time {i}")
        data = instance.slave.serializeFMUState(state)
        back = instance.slave.deserializeFMUState(data)
        report.check(instance.slave.serializeFMUState(back) == data, f"{name}: bytes read and written", f"{len(data)} bytes")
        instance.slave.setFMUState(back)
        same(go_on(instance), "from bytes")
        for each in (state, back):
            instance.slave.freeFMUState(each)
    with fmu.instance(other) as instance:
        instance.run(grid(0.2, 0.01), [])
        state = instance.slave.deserializeFMUState(data)
        instance.slave.setFMUState(state)
        instance.slave.freeFMUState(state)
        same(go_on(instance), "from bytes in an instance with another past and other parameters")
    with begin() as instance:
        found = []
        for time in on:
            with kept(instance):
                instance.try_step(time)
                instance.outputs()
            found.append((*instance.try_step(time), instance.outputs()))
        same(([f[:2] for f in found], np.array([f[2] for f in found])), "each step made twice")
        instance.slave.reset()
        fresh = instance.start().run(grid(0.6, 0.01))
    with fmu.instance() as instance, fmu.instance(other) as second:
        rows, others = [], []
        for time in grid(0.6, 0.01):
            for each, to in ((instance, rows), (second, others)):
                each.step_to(time)
                to.append(each.outputs())
        report.same_bits(fresh, rows, f"{name}: reset is a new instance")
    with fmu.instance(other) as alone:
        report.same_bits(others, alone.run(grid(0.6, 0.01)), f"{name}: side by side with another instance")


def all_side_by_side(report, fmus):
    report.section("all formulations in one process, interleaved")
    times = grid(0.7, 0.01)
    with contextlib.ExitStack() as stack:
        instances = {name: stack.enter_context(fmu.instance()) for name, fmu in fmus.items()}
        rows = {name: [] for name in fmus}
        for time in times:
            for name, instance in instances.items():
                instance.step_to(time)
                rows[name].append(instance.outputs())
    for name, fmu in fmus.items():
        with fmu.instance() as alone:
            report.same_bits(rows[name], alone.run(times), name)


def rates(report, name, fmu):
    """Output derivatives where outputs are derivatives themselves."""
    pairs = {"y": "vy", "z": "vz", "yaw": "yawRate", "vy": "ay", "yawRate": "yawAcceleration"}
    with fmu.instance() as instance:
        instance.run(grid(0.6, 0.01), [])
        before = instance.outputs()
        told = instance.derivatives(*(f"{W}.{v}" for v in pairs))
        exact = instance.get(*(f"{W}.{v}" for v in pairs.values()))
        # Of positions it is the slope of the values that are handed out, which is their speed to what the continuous output is good for.
        report.below(np.max(np.abs(told - exact) / np.maximum(np.abs(exact), 1e-3)), 1e-4, f"{name}: output derivatives")
        report.check(np.all(np.isfinite(instance.derivatives(*fmu.outputs))), f"{name}: all output derivatives are finite")
        report.same_bits(instance.outputs(), before, f"{name}: asking for them changes nothing")


def projected(report, fmus):
    report.section("initial positions are projected onto the constraints")
    for values in ({f"{W}.initial.y": 0.002}, {f"{W}.initial.y": 0.002, f"{W}.initial.z": 1e-4, f"{W}.initial.yaw": 2e-3},
                   {f"{W}.initial.roll": -1e-3, f"{W}.initial.vz": 0.01}):
        what = ", ".join(f"{k.removeprefix(W + '.initial.')} = {v:g}" for k, v in values.items())
        first = {}
        for name in CONSTRAINED:
            with fmus[name].instance(values) as instance:
                gap = np.max(np.abs(instance.get(*(f"{c}.penetration" for c in CONTACTS))))
                report.below(gap, 1e-12, f"{name}, {what}: penetration at the start", "m")
                first[name] = instance.get(f"{W}.y", f"{W}.z", f"{W}.roll", f"{W}.yaw", f"{W}.vz")
                wanted = values.get(f"{W}.initial.y", 0.0)
                report.near(first[name][0], wanted, 2e-5, f"{name}, {what}: y", "m")
                report.check(np.min(instance.get(*PRESSING)) > 0.0, f"{name}, {what}: both wheels press",
                             str(instance.get(*PRESSING)))
                instance.try_step(0.01)
                gap = np.max(np.abs(instance.get(*(f"{c}.penetration" for c in CONTACTS))))
                report.below(gap, 1e-12, f"{name}, {what}: penetration after 10 ms", "m")
        report.below(np.max(np.abs(first["ACCF"] - first["ECCF"])), 1e-12, f"{what}: ACCF and ECCF start alike")
    with fmus["ECF-A"].instance({f"{W}.initial.z": 1e-4}) as instance:
        report.check(np.max(instance.get(*(f"{c}.penetration" for c in CONTACTS))) < 0.0, "ECF-A, z = 1e-4: stands as told")


def event_time(message):
    return float(re.match(r"t = ([0-9.]+) s, wheelset, (?:left|right) wheel: ", message)[1])


def stops(report, name, fmu):
    report.section(f"{name}: a lift-off that ends the run")
    for h in (0.01, 0.0037):
        with fmu.instance() as instance:
            last, smallest = 0.0, np.inf
            for time in (h * (i + 1) for i in range(1000)):
                last = instance.time
                status, messages = instance.try_step(time)
                if status != fmi2OK:
                    break
                smallest = min(smallest, *instance.get(*PRESSING))
            what = f"steps of {1e3 * h:g} ms"
            report.check(status == fmi2Discard, f"{what}: fmi2Discard", f"status {status} in the step to {time:.4f} s")
            report.check(instance.slave.getStatus(DO_STEP_STATUS) == fmi2Discard, f"{what}: fmi2GetStatus says so too")
            report.check(smallest > 0.0, f"{what}: no pulling force before", f"smallest {smallest:.6g} N")
            reached = instance.slave.getRealStatus(LAST_SUCCESSFUL_TIME)
            report.near(reached, DIP, 1e-9, f"{what}: last successful time", "s")
            report.check(last <= reached <= time, f"{what}: it lies in the step", f"{last:.4f} <= {reached!r} <= {time:.4f}")
            report.check([s for s, _ in messages] == [fmi2Discard], f"{what}: one message", str(messages))
            text = messages[-1][1] if messages else ""
            for word in ("would have to pull", "right wheel", "t = 0.5", "on_lift", f"{W},"):
                report.check(word in text, f"{what}: the message says", word)
            outputs = instance.outputs()
            report.check(np.all(np.isfinite(outputs)), f"{what}: outputs can be read", f"{outputs.size} finite values")
            report.near(instance.get(f"{W}.distance"), 20.0, 1e-9, f"{what}: they belong to that time, distance", "m")
            gap = np.max(np.abs(instance.get(*(f"{c}.penetration" for c in CONTACTS))))
            report.below(gap, 1e-12, f"{what}: penetration", "m")
            status, messages = instance.try_step(reached + h)
            report.check(status == fmi2Discard and "would have to pull" in messages[-1][1], f"{what}: tried again, the same")
            report.same_bits(instance.outputs(), outputs, f"{what}: nothing has moved")
            instance.slave.terminate()


def lifts(report, name, fmu):
    report.section(f"{name}: lift-off and landing")
    found, times = [], grid(1.0, 0.002)
    with fmu.instance() as instance:
        rows = []
        for time in times:
            begin = instance.time
            status, messages = instance.try_step(time)
            rows.append(instance.outputs())
            if status != fmi2OK or messages:
                found.append((status, begin, time, messages))
    run = columns(fmu, np.array(rows))
    report.check(len(found) == 2 and all(f[0] == fmi2Warning and len(f[3]) == 1 for f in found),
                 "fmi2Warning with one message in two steps, fmi2OK in all others", str([(f[0], f[2]) for f in found]))
    for (_, begin, end, messages), expected, tolerance, word in zip(
            found, (DIP, LANDING), (1e-8, 1e-3), ("normal force fell to zero", "has settled and is a constraint again")):
        for status, text in messages:
            report.check(word in text and "right wheel" in text and W in text and status == fmi2Warning, "message", text)
            time = event_time(text)
            report.near(time, expected, tolerance, "time in the message", "s")
            # The message gives nine digits.
            report.check(begin - 1e-9 < time <= end + 1e-9, "it lies in the step that warns", f"{begin:.4f} to {end:.4f} s")
    smallest = min(np.min(run[v]) for v in PRESSING)
    report.check(smallest >= 0.0, "no wheel pulls at a communication point", f"smallest {smallest:.6g} N")
    gap = run[f"{CONTACTS[1]}.penetration"]
    report.between(3e-4, -np.min(gap), 6e-4, "the wheel leaves the rail by", "m")
    lifted = (np.array(times) > DIP + 1e-6) & (np.array(times) < LANDING + 1e-3)
    report.below(np.max(np.abs(gap[~lifted])), 1e-12, "penetration before and after", "m")
    report.below(np.max(np.abs(run[f"{CONTACTS[0]}.penetration"])), 1e-12, "penetration of the left wheel", "m")
    apart = gap < -1e-9
    report.check(np.any(apart) and np.all(run[PRESSING[1]][apart] == 0.0), "no normal force while apart",
                 f"{np.sum(apart)} communication points")


def lifts_one_by_one(report, name, fmu):
    """Both wheels lift off within one step of the integrator, but not at once: a force to the side loads one of them more."""
    report.section(f"{name}: two wheels lift off one after the other")
    with fmu.instance(CLEAR) as instance:
        instance.set({INPUTS[1]: 3e4})
        instance.run(grid(0.3, 0.01), [])
        instance.set({INPUTS[2]: 0.0})
        instance.set_derivatives(INPUTS[2], 1e7)
        last, messages, fell, smallest = instance.get(*PRESSING), [], 0.0, np.inf
        for time in grid(0.315, 2e-5, 0.3):
            status, told = instance.try_step(time)
            now = instance.get(*PRESSING)
            messages += [m for _, m in told]
            fell, smallest = max(fell, np.max(last - now)), min(smallest, np.min(now))
            last = now
        report.check(smallest >= 0.0, "no wheel pulls", f"smallest {smallest:.6g} N")
        report.check(len(messages) == 2 and {w for m in messages for w in SIDES if f"{w} wheel" in m} == set(SIDES),
                     "one message per wheel", str(messages))
        # The load is taken away at 1e7 N/s, half of it from each wheel: 100 N per step; a wheel that takes over changes more.
        report.below(fell, 300.0, "a normal force falls at no point by more than the lifting force takes away", "N in 20 us")
        times = [event_time(m) for m in messages]
        report.between(1e-5, times[-1] - times[0], 1e-3, "time from one to the other", "s")


def start_lifted(report, name, fmu):
    report.section(f"{name}: lifted in the initial state")
    with fmu.instance({f"{W}.initial.distance": 20.05}) as instance:
        warnings = [m for s, m in instance.log if s == fmi2Warning]
        report.check(len(warnings) == 1 and "right wheel" in warnings[0] and event_time(warnings[0]) == 0.0,
                     "fmi2ExitInitializationMode tells it", str(warnings))
        report.check(np.min(instance.get(*PRESSING)) >= 0.0, "no wheel pulls", str(instance.get(*PRESSING)))
        status, messages = instance.try_step(0.01)
        report.check(status == fmi2OK and not messages, "the first step does not tell it again", f"{status} {messages}")
        data = instance.slave.serializeFMUState(instance.slave.getFMUState())
        after = instance.try_step(0.02)[0], instance.outputs()
    with fmu.instance(CLEAR) as other:
        other.slave.setFMUState(other.slave.deserializeFMUState(data))
        other.time = 0.01
        status, messages = other.try_step(0.02)
        report.check(status == after[0] == fmi2OK and not messages, "nor a step from the restored state", f"{status} {messages}")
        report.same_bits(other.outputs(), after[1], "which goes on")


def told_once(report, name, fmu):
    report.section(f"{name}: a step that lifts off and then fails")
    with fmu.instance() as instance:
        instance.run(grid(0.48, 0.01), [])
        state = instance.slave.getFMUState()
        instance.set({INPUTS[1]: 2e5})
        status, messages = instance.try_step(0.6)
        report.check(status == fmi2Discard and [s for s, _ in messages] == [fmi2Warning, fmi2Discard],
                     "fmi2Discard; the lift-off is told before", str(messages))
        report.check(np.all(np.isfinite(instance.outputs())), "outputs can be read")
        instance.slave.setFMUState(state)
        instance.time = 0.48
        status, messages = instance.try_step(0.485)
        report.check(status == fmi2OK and not messages, "taken back, it has not happened yet", f"{status} {messages}")


def script(report, path, folder):
    folder = pathlib.Path(folder)
    with contextlib.ExitStack() as stack:
        def open_fmu(name):
            return stack.enter_context(Fmu(folder / f"{name}.fmu"))

        shipped = stack.enter_context(Fmu(path))
        fmus = {name: open_fmu(name) for name in FORMULATIONS}
        descriptions(report, fmus, shipped)
        for name, fmu in fmus.items():
            dependent(report, name, fmu)
        agreement(report, fmus, shipped)
        report.section("communication steps of 1 ms and 10 ms")
        for name, fmu in fmus.items():
            step_sizes(report, name, fmu, 1.0, 0)
        report.section("states")
        for name, fmu in fmus.items():
            states(report, name, fmu, 0.6, 0.8)
        all_side_by_side(report, fmus)
        report.section("output derivatives")
        for name, fmu in fmus.items():
            rates(report, name, fmu)
        projected(report, fmus)
        for name in CONSTRAINED:
            stops(report, name, open_fmu(f"{name}-stop"))
            fmu = open_fmu(f"{name}-elastic")
            lifts(report, name, fmu)
            report.section(f"{name}: lift-off and landing, steps and states")
            step_sizes(report, name, fmu, 1.0, 2)
            for save in (0.45, 0.55, 0.62):
                states(report, f"{name}, saved at {save} s", fmu, save, 0.7, prepare=lambda instance: None)
            states(report, f"{name}, saved at 0.55 s, driven", fmu, 0.55, 0.7)
            with fmu.instance() as instance:
                instance.run(grid(0.55, 0.01), [])
                feedthrough(report, f"{name}, lifted", instance, dependencies(fmu), expect_all=False)
            lifts_one_by_one(report, name, fmu)
            start_lifted(report, name, fmu)
            told_once(report, name, fmu)


if __name__ == "__main__":
    main(script, "FOLDER")
