"""The open program CONTACT's creep coefficients, reproduced: what its grid does to them.

Full adhesion with tractions constant in rectangles (Cerruti's integrals), steady rolling by the difference of the displacement
one cell ahead, `(u(x) - u(x + dx)) / dx`, as in `exact`. CONTACT's runs had 66 x 66 and 33 x 33 cells over 1.1 times the
patch (60 and 30 across it) and the extrapolation 2 f66 - f33. Two things differ from `exact`:

- Its cells in contact are those with positive pressure in the discrete normal problem for the Hertz load. Their area A
  exceeds pi a b by 0.59 to 0.73 % (66) and 2.00 to 2.57 % (33): not proportional to dx, so the extrapolation keeps
  -0.5 to -1.4 % times the power of the area (1: c11, c22; 3/2: c23; 2: c33).
- The rigid slip of spin is taken dq / 6 ahead of the cell's middle (`facphi`): c23 gets c22 dx/6, c33 gets c32 dx/6.

    python contact_grid.py CSV     CSV: columns nu, a_over_b, cNN_raw66, cNN_contact; prints the largest difference
"""

import csv
import sys

import numpy as np

COEFFICIENTS = ("c11", "c22", "c23", "c32", "c33")


def rectangle(x, y, dx, dy, nu):
    """Displacements xx, yy, xy, zz at (x, y) from the middle of a rectangle under unit traction, G = 1."""

    def corner(x, y):
        term = lambda p, q: p * np.arcsinh(q / np.where(p == 0, 1, abs(p)))
        j1, j2 = term(x, y), term(y, x)
        return np.array([(1 - nu) * j1 + j2, j1 + (1 - nu) * j2, -nu * np.hypot(x, y), (1 - nu) * (j1 + j2)]) / np.pi

    hx, hy = dx / 2, dy / 2
    return corner(x + hx, y + hy) - corner(x - hx, y + hy) - corner(x + hx, y - hy) + corner(x - hx, y - hy)


def cells_by_pressure(a_over_b, n, scale=1.1):
    """Cells (column, row) of an n x n grid with positive pressure, Hertz load and curvatures given (active set)."""
    a, b = a_over_b**0.5, a_over_b**-0.5
    dx, dy = 2 * scale * a / n, 2 * scale * b / n
    i, j = (index.ravel() for index in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    x, y = (i + 0.5 - n / 2) * dx, (j + 0.5 - n / 2) * dy
    # Undeformed distance A x^2 + B y^2 that gives this ellipse with p0 = 1, nu = 0 (nu only scales).
    t = (np.arange(4000) + 0.5) * np.pi / 8000
    w, dw = np.tan(t) ** 2, 2 * np.tan(t) / np.cos(t) ** 2 * np.pi / 8000
    weight = dw / np.sqrt((a * a + w) * (b * b + w) * w) / 2
    height = np.sum(weight / (a * a + w)) * x * x + np.sum(weight / (b * b + w)) * y * y
    k = np.arange(2 * n - 1) - n + 1
    table = rectangle(k[:, None] * dx, k[None, :] * dy, dx, dy, 0.0)[3]
    load = 2 * np.pi / 3 / (dx * dy)
    touching = (x / a) ** 2 + (y / b) ** 2 < 1
    for _ in range(60):
        inside, outside = np.nonzero(touching)[0], np.nonzero(~touching)[0]
        to = lambda rows: table[i[rows][:, None] - i[inside] + n - 1, j[rows][:, None] - j[inside] + n - 1]
        flat, bowl = np.linalg.solve(to(inside), np.stack([np.ones(len(inside)), height[inside]], 1)).T
        approach = (load + bowl.sum()) / flat.sum()
        pressure = approach * flat - bowl
        new = touching.copy()
        new[inside[pressure <= 0]] = False
        if (pressure > 0).all():
            new[outside[height[outside] - approach + to(outside) @ pressure < 0]] = True
        if (new == touching).all():
            return i[inside], j[inside], x[inside], y[inside]
        touching = new
    raise RuntimeError("the contact area does not settle")


def adhesion(i, j, x, y, dx, dy, nu, ahead):
    """Coefficients with all cells sticking; spin's rigid slip `ahead` cells in front of the middle. Symmetric in y."""
    n, top = i.max() + 2, j.max() + j.min()
    table = rectangle(np.arange(-n, n + 2)[:, None] * dx, np.arange(-n, n + 1)[None, :] * dy, dx, dy, nu)
    slip = (table[:, :-1] - table[:, 1:]) / dx
    index = {cell: k for k, cell in enumerate(zip(i, j))}
    half = np.nonzero(2 * j >= top)[0]
    mirror = np.array([index[i[k], top - j[k]] for k in half])
    axis = 2 * j[half] == top
    share, weight = np.where(axis, 0.5, 1.0), np.where(axis, 1.0, 2.0) * dx * dy

    def block(component, sign):
        pick = lambda source: slip[component][i[half][:, None] - i[source] + n, j[half][:, None] - j[source] + n]
        return (pick(half) + sign * pick(mirror)) * share

    def solve(x_even, load_x, load_y):
        s = 1 if x_even else -1
        matrix = np.block([[block(0, s), block(2, -s)], [block(2, s), block(1, -s)]])
        zero = np.concatenate([axis & (not x_even), axis & x_even])  # an odd traction vanishes on the axis
        right = -np.concatenate([load_x, load_y])
        matrix[zero], matrix[:, zero], right[zero] = 0, 0, 0
        matrix[zero, zero] = 1
        return np.split(np.linalg.solve(matrix, right), 2)

    xs, ys, one = x[half], y[half], np.ones(len(half))
    px, _ = solve(True, one[:, None], 0 * one[:, None])
    result = {"c11": -(weight @ px)[0], "area": len(i) * dx * dy / np.pi}
    px, py = solve(False, np.stack([0 * one, -ys], 1), np.stack([one, xs + ahead * dx], 1))
    result["c22"], result["c23"] = -(weight @ py)
    result["c32"], result["c33"] = -(weight @ (xs[:, None] * py - ys[:, None] * px))
    return result


def program(a_over_b, nu, n, cells):
    a, b = a_over_b**0.5, a_over_b**-0.5
    return adhesion(*cells, 2.2 * a / n, 2.2 * b / n, nu, ahead=1 / 6)


def main():
    cells, worst = {}, [0.0, 0.0]
    for row in csv.DictReader(line for line in open(sys.argv[1]) if not line.startswith("#")):
        ratio, nu = float(row["a_over_b"]), float(row["nu"])
        ratio = 10 / round(10 / ratio) if ratio > 1 else ratio  # 1.11111 is 1 / 0.9
        for n in (33, 66):
            if (ratio, n) not in cells:
                cells[ratio, n] = cells_by_pressure(ratio, n)
        coarse, fine = (program(ratio, nu, n, cells[ratio, n]) for n in (33, 66))
        off = max(abs(fine[k] - float(row[k + "_raw66"])) for k in ("c11", "c22", "c23", "c33"))
        off_extrapolated = max(abs(2 * fine[k] - coarse[k] - float(row[k + "_contact"])) for k in COEFFICIENTS)
        worst = [max(worst[0], off), max(worst[1], off_extrapolated)]
        print(f"nu {nu:4g} a/b {ratio:8.5f}  A/(pi a b) {fine['area']:.4f} {coarse['area']:.4f}  66 cells off by {off:.6f}, extrapolated by {off_extrapolated:.6f}", flush=True)
    print("largest difference", worst)


if __name__ == "__main__":
    main()
