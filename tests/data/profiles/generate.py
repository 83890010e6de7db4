"""Writes the measured-looking sample files of this folder: published profiles with deterministic noise.

S1002 and 60E1 are computed here from their definitions, independently of the program (../../../src/geometry/profile/data).
Noise: equally distributed within +-0.004 mm in each coordinate, from a linear congruential generator.
"""
import csv
import math
import pathlib

HERE = pathlib.Path(__file__).parent
DATA = HERE.parents[2] / "src/geometry/profile/data"


def rows(name):
    with open(DATA / name) as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


class Noise:
    def __init__(self, seed, size):
        self.state, self.size = seed, size

    def __call__(self):
        self.state = (self.state * 6364136223846793005 + 1442695040888963407) % 2**64
        return self.size * (2 * (self.state >> 11) / 2**53 - 1)


ZONES = rows("s1002.csv")


def s1002(y):
    for zone in ZONES:
        if float(zone["from"]) <= y <= float(zone["to"]):
            n = [float(word) for word in zone["numbers"].split()]
            if zone["shape"] == "polynomial":
                return sum(c * y**i for i, c in enumerate(n))
            root = math.sqrt(n[1] ** 2 - (y + n[2]) ** 2)
            return n[0] + root if zone["shape"] == "crest" else n[0] - root


def rail_60e1(x):
    x, centre, radius, start = abs(x), (0.0, 0.0), None, 0.0
    for row in (row for row in rows("rails.csv") if row["rail"] == "60E1"):
        r = float(row["radius"])
        if radius is None:
            centre = (0.0, -r)
        else:
            s = (start - centre[0]) / radius
            centre = (centre[0] + (radius - r) * s, centre[1] + (radius - r) * math.sqrt(1 - s * s))
        radius = r
        start = float(row["limit"]) if row["limit"] else centre[0] + r * 20 / math.sqrt(401)
        if x <= start:
            return centre[1] + math.sqrt(r * r - (x - centre[0]) ** 2)


def spaced(f, first, last, step):
    """Points about `step` apart along the curve."""
    points, x, n = [], first, 200000
    h, run = (last - first) / n, 0.0
    previous = (first, f(first))
    points.append(previous)
    for i in range(1, n + 1):
        x = min(first + i * h, last)
        run += math.hypot(h, f(x) - previous[1])
        previous = (x, f(x))
        if run >= step:
            points.append(previous)
            run = 0.0
    return points


def write(name, lines):
    (HERE / name).write_text("\n".join(lines) + "\n")


def main():
    # MiniProf rail: X toward the gauge face, Y upward, flank and a little of the overhanging underside on the gauge side.
    noise = Noise(1, 0.004)
    head = spaced(rail_60e1, -35.99, 35.9, 0.5)
    flank = [(-36.0 - 0.05 * i, -14.3 - i) for i in range(1, 9)]
    under = [(-36.3 + 0.5 * i, -22.5 - 0.05 * i) for i in range(1, 6)]
    rail = [(-x + noise(), z + noise()) for x, z in list(reversed(under)) + list(reversed(flank)) + head]
    write(
        "rail_60e1.ban",
        ["ProgramName=sample", "Rail=left", f"XYPoints={len(rail)}", "XOffset=0.0000", "YOffset=0.0000", "ColumnDef=X,Y,A", ""]
        + [f"{x:9.4f} {z:9.4f} 0.0" for x, z in rail],
    )
    # MiniProf wheel: X from the flange back, Y toward the flange tip; the flange back itself, vertical.
    noise = Noise(2, 0.004)
    wheel = [(0.0, 9.5 - 0.5 * i) for i in range(30, 0, -1)] + [(y + 70, z) for y, z in spaced(s1002, -69.99, 60, 0.4)]
    wheel = [(x + noise(), z + noise()) for x, z in wheel]
    write(
        "wheel_s1002.whl",
        ["ProgramName=sample", f"XYPoints={len(wheel)}", "XOffset=0.0000", "YOffset=0.0000", "ColumnDef=X,Y", ""]
        + [f"{x:9.4f}\t{z:9.4f}" for x, z in wheel],
    )
    # SIMPACK: z downward for the rail, toward the flange tip for the wheel; no noise.
    def simpack(kind, points):
        return (
            ["! sample", "header.begin", "  version = 1", f"  type = {kind}   ! 0=rail, 1=wheel", "header.end", "spline.begin"]
            + ["  approx.smooth = 0.0", "  comment = 'sample'", "  shift.y = 0.0", "  mirror.y = 0", "  units.len.f = 1000.0"]
            + ["  bound.y.min = 1.0", "  bound.y.max = 0.0", "  point.begin"]
            + [f"    {y:.7f} {z:.7f} 1.0" for y, z in points]
            + ["  point.end", "spline.end"]
        )

    write("wheel_s1002.prw", simpack(1, list(reversed(spaced(s1002, -69.9, 60, 0.5)))))
    write("rail_60e1.prr", simpack(0, [(x, -z) for x, z in spaced(rail_60e1, -35.95, 35.95, 0.5)]))
    # CSV: heights of a wheel in mm, in no order.
    noise = Noise(3, 0.004)
    points = spaced(s1002, -69.5, 60, 0.5)
    points = [points[(37 * i) % len(points)] for i in range(len(points))]
    write("wheel_s1002.csv", ["# sample", "u [mm],height [mm]"] + [f"{y:.4f},{z + noise():.4f}" for y, z in points])


main()
