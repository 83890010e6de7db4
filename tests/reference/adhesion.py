"""Kalker's creep coefficients from a spectral solution of rolling with full adhesion (no grid).

Two like half-spaces touch in the ellipse x^2/a^2 + y^2/b^2 < 1 (x forward), roll along +x and stick everywhere.
With Cerruti's displacement difference u of the tractions p (on the wheel) and G = 1,

    u_i(x) = 1/pi sum_j int [ (1 - nu) delta_ij / R + nu X_i X_j / R^3 ] p_j dA,       X = x - x',  R = |X|,
    du/dx = (xi - phi y, eta + phi x)      =>      u = (xi x - phi x y + f_x(y), eta x + phi x^2 / 2 + f_y(y)).

The two functions f of y are free and are fixed by the leading edge: there no square-root singularity is allowed,
p is finite (zero); at the trailing edge p ~ 1/sqrt(distance). Then with a b = 1

    F_x = -c11 xi,   F_y = -(c22 eta + c23 phi),   M_z = int (x p_y - y p_x) = -(c32 eta + c33 phi),   c32 = -c23.

Method. Put x = a X, y = b Y and (X, Y, sqrt(1 - X^2 - Y^2)) on the unit sphere. Surface harmonics Y_nm even in the
third coordinate give the tractions p = Y_nm / sqrt(1 - X^2 - Y^2), m = -n, -n+2 .. n, whose Fourier transform is
2 pi (-i)^n j_n(k) N_nm exp(i m t), N_nm = Y_nm on the edge. The kernel's transform is g(t) / k with, q^2 = cos^2/a^2 + sin^2/b^2,

    g_xx = 2 (1/q - nu cos^2 / (a^2 q^3)),  g_yy = 2 (1/q - nu sin^2 / (b^2 q^3)),  g_xy = -2 nu cos sin / (a b q^3),

and int j_n j_n' dk = pi / (2 (2 n + 1)) for n = n', 0 for n - n' even. So degrees do not mix (Galin's theorem), and for
P_nm = N_nm p_nm, u = sum u_nm Y_nm and the Fourier coefficients G_k of g each degree is one small Toeplitz system

    2 pi^2 / (2 n + 1) sum_m' G_(m - m') P_nm' = u_nm / N_nm.

A Legendre polynomial P_n(Y) is such a harmonic, of degree n: its right-hand side is (2 / pi) exp(-i m pi / 2) after division
by the factor on the left. X has degree 1, X Y and X^2 - Y^2 degree 2 (Y^2 is part of f). Unknown: f = sum f_n P_n(Y), n <= N.
Edge: E(t) = sum_nm P_nm exp(i m t) = lim p sqrt(1 - X^2 - Y^2) must vanish for |t| < pi/2; it is made orthogonal there to the
Chebyshev polynomials U_k(sin t), k <= N, weight cos^2 t (for the circle with nu = 0, P_n(Y) gives E = U_n(sin t) / pi: nothing is
truncated, and c11 = c22 = 32 / (3 pi), c23 = 4/3, c33 = 512 / (135 pi)). Force: int p = 2 pi P_00, moments from degree 1.

Symmetry in y: for xi p_x is even and p_y odd, for eta and phi the reverse; so sums of cos m t and sin m t do.
c32 = -c23 (reciprocity) is not built in: it measures the error. N = 40 gives five digits for a/b from 0.1 to 10.

    python adhesion.py             convergence in N and the limits
    python adhesion.py --csv       table of coefficients, N = 160
"""

import sys

import numpy as np

RATIOS = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0] + [10 / k for k in (9, 8, 7, 6, 5, 4, 3, 2, 1)]
NAMES = ("c11", "c22", "c23", "c32", "c33")


def symbol(a, b, nu, count):
    """Fourier coefficients: cosine of g_xx, g_yy, sine of g_xy, for 0 <= k < count."""
    points = 1 << int(np.ceil(np.log2(max(64 * count, 4096 * max(a / b, b / a)))))
    t = 2 * np.pi * np.arange(points) / points
    c, s = np.cos(t) / a, np.sin(t) / b
    q = np.hypot(c, s)
    xx, yy, xy = 2 * (1 / q - nu * c * c / q**3), 2 * (1 / q - nu * s * s / q**3), -2 * nu * c * s / q**3
    transform = lambda g: np.fft.fft(g)[:count] / points
    return transform(xx).real, transform(yy).real, -transform(xy).imag


def degree_matrix(even, odd, cross, m, ms):
    """Multiplication by g on (cos m t, sin m t), cut to one degree; `even` belongs to the component with cosines."""
    sine = lambda k: np.sign(k) * cross[abs(k)]
    difference, total = (lambda x, y: x[:, None] - y), (lambda x, y: x[:, None] + y)
    cc = even[abs(difference(m, m))] + even[total(m, m)]
    cs = sine(total(m, ms)) - sine(difference(m, ms))
    cc[m == 0] /= 2
    cs[m == 0] /= 2
    sc = sine(total(ms, m)) + sine(difference(ms, m))
    ss = odd[abs(difference(ms, ms))] - odd[total(ms, ms)]
    return np.block([[cc, cs], [sc, ss]])


def coefficients(a_over_b, nu, degree=80):
    """c11, c22, c23, c32, c33 with harmonics up to `degree`."""
    a, b = a_over_b**0.5, a_over_b**-0.5
    xx, yy, xy = symbol(a, b, nu, 2 * degree + 2)
    result = {}
    # (component with cosines, with sines, loads): xi loads x; eta, phi load y.
    for even, odd, loads in ((xx, yy, 1), (yy, xx, 2)):
        size = degree + 1
        cosines, sines = np.zeros((2, size, size + loads))  # edge coefficients per f_n, then per load
        for n in range(size):
            m = np.arange(n % 2, n + 1, 2)
            ms = m[m > 0]
            right = np.zeros((len(m) + len(ms), 1 + loads))
            if n % 2 == 0:
                right[: len(m), 0] = 2 / np.pi * np.where(m == 0, 1, 2) * np.cos(m * np.pi / 2)
            else:
                right[len(m) :, 0] = 4 / np.pi * np.sin(ms * np.pi / 2)
            if n == 1:
                right[0, 1] = 4 / np.pi * a
            if n == 2 and loads == 2:
                right[1, 2] = 8 / (3 * np.pi) * a * a  # (X^2 - Y^2) a^2 / 2 along y
                right[2, 2] = -8 / (3 * np.pi) * a * b  # -a b X Y along x
            solved = np.linalg.solve(degree_matrix(even, odd, xy, m, ms), right)
            columns = [n] + list(range(size, size + loads))
            cosines[np.ix_(m, columns)] += solved[: len(m)]
            sines[np.ix_(ms, columns)] += solved[len(m) :]
        nodes, weights = np.polynomial.legendre.leggauss(2 * size)
        t = np.pi / 4 * (1 + nodes)
        k = np.arange(size)
        test = np.sin(np.outer(np.pi / 2 - t, k + 1)) * (weights * np.cos(t))[:, None]  # U_k(sin t) cos^2 t dt
        edge = np.vstack([test[:, 0::2].T @ np.cos(np.outer(t, k)) @ cosines, test[:, 1::2].T @ np.sin(np.outer(t, k)) @ sines])
        f = np.linalg.solve(edge[:, :size], -edge[:, size:])
        # Degree n has orders m of its own parity only, up to n: order 0 of degree 0 and order 1 of degree 1 stand alone
        # in the columns of f_0, f_1 and the loads' degree 1.
        force = -2 * np.pi * cosines[0, 0] * f[0]
        if loads == 1:
            result["c11"] = force[0]
        else:
            result["c22"], result["c23"] = force
            direct = np.array([1, 0])  # eta has a part of degree 1, phi of degree 2 (orders 0 and 2)
            along_y = cosines[1, 1] * f[1] + cosines[1, size:] * direct
            along_x = sines[1, 1] * f[1] + sines[1, size:] * direct
            result["c32"], result["c33"] = -2 * np.pi / 3 * (a * along_y - b * along_x)
    return result


def asymptotes(a_over_b, nu):
    """Kalker's limits for slender ellipses; c33 of the long one was found from the numbers (right to 1e-5 at a/b = 1000)."""
    pi, g = np.pi, min(a_over_b, 1 / a_over_b)
    if a_over_b < 1:
        c23 = pi * g**0.5 / (3 * (1 - nu)) * (1 + nu * (np.log(16 / g) - 5))
        return {"c11": pi**2 / 4 / (1 - nu), "c22": pi**2 / 4, "c23": c23, "c33": pi**2 / 16 / (1 - nu) / g}
    length, three = np.log(16 / g**2), 3 - np.log(4)
    x, y, bulk = length - 2 * nu, (1 - nu) * length + 2 * nu, (1 - nu) * length - 2 + 4 * nu
    c11, c22 = 2 * pi / g / x * (1 + three / x), 2 * pi / g / y * (1 + (1 - nu) * three / y)
    c33 = pi / 4 * (((1 - 2 * nu) * length - 2 + 8 * nu) / bulk) ** 2
    return {"c11": c11, "c22": c22, "c23": 2 * pi / 3 / g**1.5 / bulk, "c33": c33}


def main():
    if "--csv" in sys.argv:
        print("nu,a_over_b,c11,c22,c23,c33")
        for nu in (0.0, 0.25, 0.28, 0.3, 0.5):
            for ratio in RATIOS:
                c = coefficients(ratio, nu, 160)
                assert abs(c["c32"] / c["c23"] + 1) < 1e-7
                print(f"{nu:g},{ratio:.6g}," + ",".join(f"{c[name]:.6g}" for name in ("c11", "c22", "c23", "c33")))
        return
    exact = {"c11": 32 / (3 * np.pi), "c22": 32 / (3 * np.pi), "c23": 4 / 3, "c32": -4 / 3, "c33": 512 / (135 * np.pi)}
    found = coefficients(1.0, 0.0, 20)
    print("circle, nu = 0: largest difference from the closed form", max(abs(found[k] - exact[k]) for k in NAMES))
    for ratio, nu in ((0.1, 0.28), (1.0, 0.28), (10.0, 0.28), (0.1, 0.5), (10.0, 0.5)):
        for degree in (10, 20, 40, 80, 160):
            found = coefficients(ratio, nu, degree)
            print(f"a/b {ratio:4g} nu {nu:4g} N {degree:3d}  " + "  ".join(f"{k} {found[k]:.7f}" for k in NAMES))
    for nu in (0.0, 0.28, 0.5):
        for ratio in (0.003, 0.01, 0.1, 10.0, 100.0, 1000.0):
            found, limit = coefficients(ratio, nu, 200), asymptotes(ratio, nu)
            print(f"a/b {ratio:5g} nu {nu:4g}  limits off by " + "  ".join(f"{k} {100 * (limit[k] / found[k] - 1):+.3f} %" for k in limit))


if __name__ == "__main__":
    main()
