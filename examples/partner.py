"""What the examples that couple a vehicle share: the FMU made by `wheelrail export`, one instance of it, checks and a picture.

Needs fmpy. The program is WHEELRAIL (an environment variable), else target/release/wheelrail of this checkout, else `wheelrail` on the path.
"""

import argparse
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import fmpy
from fmpy import fmi2

HERE = pathlib.Path(__file__).resolve().parent


def program():
    built = HERE.parent / "target/release/wheelrail"
    return os.environ.get("WHEELRAIL") or (str(built) if built.exists() else "wheelrail")


class Fmu:
    """An FMU, unpacked; gone with the `with` block."""

    def __init__(self, file):
        self.directory = pathlib.Path(tempfile.mkdtemp(prefix="example-"))
        fmpy.extract(str(file), str(self.directory))
        self.description = fmpy.read_model_description(str(self.directory))
        self.variables = {variable.name: variable for variable in self.description.modelVariables}

    @classmethod
    def of_scene(cls, scene, *changes):
        """The FMU of a scene with `--set` changes."""
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "vehicle.fmu"
            command = [program(), "export", str(scene), "--check", "none", "-o", str(file)]
            done = subprocess.run(command + [word for change in changes for word in ("--set", change)], capture_output=True, text=True)
            if done.returncode:
                raise SystemExit(f"{' '.join(command)}: {done.stderr}")
            return cls(file)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        shutil.rmtree(self.directory, ignore_errors=True)

    def names(self, end, causality="output"):
        return [name for name, variable in self.variables.items() if name.endswith(end) and variable.causality == causality]


class Instance:
    """One co-simulation instance, initialised at time 0 with these values."""

    def __init__(self, fmu, values=None):
        self.fmu, self.time, self.log = fmu, 0.0, []
        model = fmu.description.coSimulation.modelIdentifier
        self.slave = fmi2.FMU2Slave(guid=fmu.description.guid, unzipDirectory=str(fmu.directory), modelIdentifier=model, instanceName="example")
        self.slave.instantiate()
        self.slave.setupExperiment(startTime=0.0)
        self.set(values or {})
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.slave.terminate()
        self.slave.freeInstance()

    def references(self, names):
        return [self.fmu.variables[name].valueReference for name in names]

    def set(self, values):
        self.slave.setReal(self.references(values), list(values.values()))

    def derivatives(self, name, *values):
        """Of an input: the first, the second ... from now on."""
        self.slave.setRealInputDerivatives(self.references([name]) * len(values), list(range(1, len(values) + 1)), list(values))

    def get(self, names):
        return self.slave.getReal(self.references(names))

    def step(self, length):
        self.slave.doStep(self.time, length)
        self.time += length


class Report:
    """Lines of a comparison; `finish` ends with an error where one of them failed."""

    def __init__(self):
        self.failed = 0

    def near(self, text, found, expected, share, unit=""):
        """`found` is `expected` within a share of it."""
        off = abs(found - expected) / abs(expected)
        self.line(off <= share, f"{text}: {found:.5g} {unit}, expected {expected:.5g} ({100 * off:.2g} % off, {100 * share:g} % allowed)")

    def below(self, text, found, bound, unit=""):
        self.line(found <= bound, f"{text}: {found:.4g} {unit}, at most {bound:.4g}")

    def above(self, text, found, bound, unit=""):
        self.line(found >= bound, f"{text}: {found:.4g} {unit}, at least {bound:.4g}")

    def line(self, holds, text):
        self.failed += not holds
        print(("ok      " if holds else "FAILED  ") + text)

    def finish(self, at_once=False):
        """Ends the process; `at_once`: without what libraries do while it exits. pythonfmu 0.7.0 lets go of its interpreter a second time then, after its own static pointer is gone,
        and now and then crashes a run that is complete."""
        print(f"{self.failed} failed")
        code = 1 if self.failed else 0
        if at_once:
            sys.stdout.flush()
            os._exit(code)
        raise SystemExit(code)


def arguments(description, **more):
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("--step", type=float, default=more.pop("step"), help="communication step, s (%(default)s)")
    parser.add_argument("--short", action="store_true", help="a shorter run, as in the tests")
    parser.add_argument("-o", "--picture", help="write the picture there (SVG)")
    for name, text in more.items():
        parser.add_argument(f"--{name}", type=float, help=text)
    return parser.parse_args()


COLOURS = ["#1b6ca8", "#d1495b", "#2e933c", "#8d5fd3", "#e08e0b", "#5b6770"]
WIDTH, PANEL, LEFT, RIGHT, TOP, GAP = 760, 190, 80, 20, 40, 52


def ticks(low, high):
    raw = (high - low) / 5
    size = 10.0 ** math.floor(math.log10(raw))
    size *= next(factor for factor in (1, 2, 5, 10) if factor * size >= raw)
    first = math.ceil(low / size - 1e-9)
    return [size * i for i in range(first, math.floor(high / size + 1e-9) + 1)]


def draw(file, title, x_label, panels):
    """Panels below each other over one axis: (label of y, [(name, x, y)], [(name, level)])."""
    height = TOP + len(panels) * (PANEL + GAP)
    xs = [value for _, series, _ in panels for _, x, _ in series for value in (min(x), max(x))]
    from_x, to_x = min(xs), max(xs)
    at_x = lambda x: LEFT + (x - from_x) / (to_x - from_x) * (WIDTH - LEFT - RIGHT)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}" font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{height}" fill="white"/><text x="{LEFT}" y="22" font-size="15">{title}</text>']
    for number, (label, series, levels) in enumerate(panels):
        top = TOP + number * (PANEL + GAP)
        values = [value for _, _, y in series for value in (min(y), max(y))] + [level for _, level in levels]
        low, high = min(values), max(values)
        margin = 0.05 * (high - low) or 1.0
        low, high = low - margin, high + margin
        at_y = lambda y: top + (high - y) / (high - low) * PANEL
        for tick in ticks(low, high):
            out.append(f'<path d="M{LEFT} {at_y(tick):.1f}H{WIDTH - RIGHT}" stroke="#ddd"/><text x="{LEFT - 6}" y="{at_y(tick) + 4:.1f}" text-anchor="end">{tick:.6g}</text>')
        for tick in ticks(from_x, to_x):
            out.append(f'<path d="M{at_x(tick):.1f} {top}v{PANEL}" stroke="#eee"/><text x="{at_x(tick):.1f}" y="{top + PANEL + 16}" text-anchor="middle">{tick:.6g}</text>')
        out.append(f'<rect x="{LEFT}" y="{top}" width="{WIDTH - LEFT - RIGHT}" height="{PANEL}" fill="none" stroke="#888"/>')
        out.append(f'<text transform="translate(16 {top + PANEL / 2}) rotate(-90)" text-anchor="middle">{label}</text>')
        entries = []
        for (name, x, y), colour in zip(series, COLOURS):
            stride = max(1, len(x) // 1500)
            points = " ".join(f"{at_x(a):.1f},{at_y(b):.1f}" for a, b in list(zip(x, y))[::stride])
            out.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.4"/>')
            entries.append((name, colour, ""))
        for name, level in levels:
            out.append(f'<path d="M{LEFT} {at_y(level):.1f}H{WIDTH - RIGHT}" stroke="#333" stroke-dasharray="6 4"/>')
            entries.append((name, "#333", ' stroke-dasharray="6 4"'))
        place = LEFT + 8
        for name, colour, dashed in entries:
            out.append(f'<path d="M{place} {top + 12}h22" stroke="{colour}" stroke-width="2"{dashed}/><text x="{place + 26}" y="{top + 16}">{name}</text>')
            place += 44 + 6.6 * len(name)
    out.append(f'<text x="{WIDTH / 2}" y="{height - 12}" text-anchor="middle">{x_label}</text></svg>')
    pathlib.Path(file).write_text("\n".join(out) + "\n")
