"""Wheelset on two rails with RIGID contact (ideal constraints); minimal coordinates y, yaw, pitch.  See README.md.

Gap of a wheel: the cone is the zero set of phi(p) = distance(p, axle) - (R0 - k u(p)), u = lateral coordinate along the axle.
G(x, y, z, yaw, roll) = phi at the rail point p(s, eta) where phi is stationary in s and eta.  G = 0: the surfaces touch with a common
tangent plane.  The derivatives of G follow from those of phi (envelope theorem; Schur complement for the second ones), so no
surface rates, no wheel surface parameters and no n.(v + w x rho) occur in the constraint.  |grad_p phi| = sqrt(1 + k^2),
hence N = lambda sqrt(1 + k^2).  z(x,y,yaw), roll(x,y,yaw) solve G_left = G_right = 0; Lagrange's equations are projected on (y, yaw, pitch)."""
import sys; sys.path.insert(0, '..')
import math, numpy as np
from numba import njit
from ref import hertz, kal, LX, SPC              # Hertz's ellipse by AGM, spline of Kalker's coefficients (independent elastic program)
L, R0, K, RR, TILT = 0.716, 0.457, 0.025, 0.3, math.atan(0.025)
ST, CT = math.sin(TILT), math.cos(TILT)
V, M, I, IY, LOAD, MU, NU, AMP = 40.0, 1568.0, 656.0, 168.0, 98000.0 + 1568.0 * 9.81, 0.5, 0.28, 0.010
HS, KX, CX, KY = 0.45, 1.35e5, 1.0e5, 2.5e5
X_, Y_, Z_, PS, RO = 0, 1, 2, 3, 4               # order of q; 5, 6 are s, eta

@njit(cache=True)
def rail(sg, s, e, on):
    """Rail point, its s- and eta-derivatives p_s, p_e, p_ss, p_ee (p_se = 0).  on: 0 straight, 1 cosine continued, 2 as it is"""
    d = d1 = d2 = 0.0
    if sg < 0 and (on == 1 or (on == 2 and 20.0 < s < 30.0)):
        w = 2 * math.pi / 10; a = w * (s - 20)
        d, d1, d2 = AMP / 2 * (1 - math.cos(a)), AMP / 2 * w * math.sin(a), AMP / 2 * w * w * math.cos(a)
    q = math.sqrt(RR * RR - e * e); f, f1, f2 = -e * e / (q + RR), -e / q, -RR * RR / q**3
    return (np.array([s, sg * (L + e * CT - f * ST) + d, e * ST + f * CT]), np.array([1.0, d1, 0.0]),
            np.array([0.0, sg * (CT - f1 * ST), ST + f1 * CT]), np.array([0.0, d2, 0.0]), np.array([0.0, -sg * f2 * ST, f2 * CT]))

@njit(cache=True)
def phi(sg, q, s, e, on):
    """value, gradient and Hessian of phi over (x, y, z, yaw, roll, s, eta)"""
    p, ps, pe, pss, pee = rail(sg, s, e, on)
    S, C, sr, cr = math.sin(q[PS]), math.cos(q[PS]), math.sin(q[RO]), math.cos(q[RO])
    a = np.array([-S * cr, C * cr, sr])
    D = np.zeros((7, 3)); D[0, 0] = D[1, 1] = D[2, 2] = -1.0; D[5] = ps; D[6] = pe                     # d_i of d = p - c
    A = np.zeros((7, 3)); A[3] = np.array([-C * cr, -S * cr, 0.0]); A[4] = np.array([S * sr, -C * sr, cr])   # a_i
    d = p - q[:3]; h = d @ a
    dd = np.zeros((7, 7)); ha = np.zeros((7, 7))                                                   # d . d_ij, (d . a)_ij
    dd[5, 5] = d @ pss; dd[6, 6] = d @ pee; ha[5, 5] = a @ pss; ha[6, 6] = a @ pee
    ha[3, 3] = d @ np.array([S * cr, -C * cr, 0.0]); ha[3, 4] = ha[4, 3] = d @ np.array([C * sr, S * sr, 0.0]); ha[4, 4] = -(d @ a)
    ha += D @ A.T + A @ D.T
    h1 = D @ a + A @ d
    r = math.sqrt(d @ d - h * h)
    Q1 = 2 * (D @ d) - 2 * h * h1
    Q2 = 2 * (D @ D.T + dd) - 2 * np.outer(h1, h1) - 2 * h * ha
    return r - R0 + K * (sg * h - L), Q1 / (2 * r) + K * sg * h1, Q2 / (2 * r) - np.outer(Q1, Q1) / (4 * r**3) + K * sg * ha

@njit(cache=True)
def gap(sg, q, on):
    """G, G_q (5), G_qq (5x5), s, eta"""
    s = q[0]; e = 0.0
    for it in range(40):
        f, g, H = phi(sg, q, s, e, on)
        det = H[5, 5] * H[6, 6] - H[5, 6]**2
        ds = (H[6, 6] * g[5] - H[5, 6] * g[6]) / det; de = (H[5, 5] * g[6] - H[5, 6] * g[5]) / det
        if it > 1 and abs(ds) + abs(de) < 1e-12: break          # quadratic: the remaining error is far below rounding
        s -= ds; e -= de
    Hqp = np.ascontiguousarray(H[:5, 5:]); Hi = np.array([[H[6, 6], -H[5, 6]], [-H[5, 6], H[5, 5]]]) / det
    return f, g[:5].copy(), H[:5, :5] - Hqp @ Hi @ Hqp.T, s, e

@njit(cache=True)
def place(x, y, yaw, on):
    """z and roll that close both gaps; returns q, derivatives of both gaps and the contact's rail coordinates"""
    q = np.array([x, y, R0, yaw, 0.0]); err = 1.0
    for it in range(40):
        f1, g1, H1, s1, e1 = gap(1.0, q, on); f2, g2, H2, s2, e2 = gap(-1.0, q, on)
        if err < 1e-11: break
        step = np.linalg.solve(np.array([[g1[2], g1[4]], [g2[2], g2[4]]]), np.array([f1, f2]))
        q[2] -= step[0]; q[4] -= step[1]; err = abs(step[0]) + abs(step[1])
    return q, g1, g2, H1, H2, np.array([s1, e1]), np.array([s2, e2]), max(abs(f1), abs(f2))

@njit(cache=True)
def creep(sg, q, qd, se, on, E, N):
    """creep force of one wheel for a given N: record, generalized force on (y, z, yaw, roll, pitch)"""
    p, t1, t2, _, _ = rail(sg, se[0], se[1], on)
    n = sg * np.cross(t1, t2); n /= math.sqrt(n @ n); e1 = t1 / math.sqrt(t1 @ t1); e2 = np.cross(n, e1)
    S, C, sr, cr = math.sin(q[PS]), math.cos(q[PS]), math.sin(q[RO]), math.cos(q[RO])
    rho = p - q[:3]; ax = np.array([-S * cr, C * cr, sr])
    W = np.zeros((6, 3)); U = np.zeros((6, 3))        # angular velocity and velocity of the material point per unit of x', y', z', yaw', roll', pitch'
    W[3] = np.array([0.0, 0.0, 1.0]); W[4] = np.array([C, S, 0.0]); W[5] = ax
    for i in range(3): U[i, i] = 1.0; U[3 + i] = np.cross(W[3 + i], rho)
    v = U.T @ qd; w = W.T @ qd
    cx, cy, sp = v @ e1 / V, v @ e2 / V, w @ n / V
    r = R0 - K * (sg * (rho @ ax) - L); A = 0.5 / (r * math.sqrt(1 + K * K)); B = 0.5 / RR
    m, l, xi = hertz(A, B)
    Kh = 2 * E * (A + B) / (3 * (1 - NU * NU)) / (xi * (A + B))**1.5
    d = (N / Kh)**(2 / 3); c0 = math.sqrt(d / (xi * (A + B))); a, b = m * c0, l * c0; ab = a * b; G = E / (2 * (1 + NU))
    k = kal(LX, SPC, m / l)
    lx = -G * ab * k[0] * cx; ly = -G * (ab * k[1] * cy + ab**1.5 * k[2] * sp); lm = -G * (-ab**1.5 * k[2] * cy + ab * ab * k[3] * sp)
    t = math.hypot(lx, ly) / (MU * N); f = 1 - t / 3 + t * t / 27 if t < 3 else 1 / t
    Q = U @ (f * lx * e1 + f * ly * e2) + W @ (f * lm * n)
    return np.array([N, f * lx, f * ly, f * lm, cx, cy, sp, a, b, d, f, se[0] - q[0], se[1], sg * (rho @ ax) - L,
                     n[0], n[1], n[2], A, B, Kh, v @ n]), Q[1:].copy()
REC = ['N', 'Fx', 'Fy', 'Mz', 'xi_x', 'xi_y', 'phi', 'a', 'b', 'approach', 'saturation', 's_minus_x', 'eta', 'u', 'n_x', 'n_y', 'n_z',
       'A', 'B', 'Kh', 'normalVelocity']

@njit(cache=True)
def evaluate(x, st, on, E, sus):
    """st = y, yaw, y', yaw', pitch' - V/R0.  returns q, q', accelerations (y, z, yaw, roll, pitch), records left and right, residuals"""
    q, g1, g2, H1, H2, se1, se2, res = place(x, st[0], st[1], on)
    td = st[4] + V / R0
    Gd = np.array([[g1[2], g1[4]], [g2[2], g2[4]]])
    T = -np.linalg.solve(Gd, np.array([[g1[0], g1[1], g1[3]], [g2[0], g2[1], g2[3]]]))          # d(z, roll)/d(x, y, yaw)
    zr = T @ np.array([V, st[2], st[3]])
    qd = np.array([V, st[2], zr[0], st[3], zr[1], td])
    cv = -np.linalg.solve(Gd, np.array([qd[:5] @ H1 @ qd[:5], qd[:5] @ H2 @ qd[:5]]))            # (z, roll)'' = T (0, y'', yaw'') + cv
    S, C, sr, cr = math.sin(q[PS]), math.cos(q[PS]), math.sin(q[RO]), math.cos(q[RO])
    yd, rd = st[3], zr[1]; w2 = td + yd * sr
    # Lagrange's equations on (y, z, yaw, roll, pitch): Ma acc + hh = Q
    Ma = np.zeros((5, 5)); Ma[0, 0] = Ma[1, 1] = M; Ma[2, 2] = I * cr * cr + IY * sr * sr; Ma[2, 4] = Ma[4, 2] = IY * sr; Ma[3, 3] = I; Ma[4, 4] = IY
    hh = np.array([0.0, LOAD, -2 * I * yd * rd * cr * sr + IY * (yd * rd * cr * sr + w2 * cr * rd), I * yd * yd * cr * sr - IY * w2 * yd * cr, IY * yd * rd * cr])
    for h in (HS, -HS):                               # suspension: potential and dissipation function of the points h a
        fx = -sus * (KX * (-h * S * cr) + CX * h * (-C * cr * yd + S * sr * rd)); fy = -sus * KY * (q[1] + h * C * cr - h)
        hh[0] -= fy; hh[2] -= fx * (-h * C * cr) + fy * (-h * S * cr); hh[3] -= fx * h * S * sr - fy * h * C * sr
    J = np.zeros((5, 3)); J[0, 0] = J[2, 1] = J[4, 2] = 1.0; J[1, 0], J[1, 1], J[3, 0], J[3, 1] = T[0, 1], T[0, 2], T[1, 1], T[1, 2]
    c0 = np.array([0.0, cv[0], 0.0, cv[1], 0.0]); Mr = J.T @ Ma @ J; cn = math.sqrt(1 + K * K)
    Nl = Nr = LOAD / 2; last = 1.0; cl, Ql = creep(1.0, q, qd, se1, on, E, Nl); cr_, Qr = creep(-1.0, q, qd, se2, on, E, Nr)
    acc = c0
    for it in range(300):                             # creep forces <-> normal forces
        rhs = Ql + Qr - hh
        acc = J @ np.linalg.solve(Mr, J.T @ (rhs - Ma @ c0)) + c0
        f = Ma @ acc - rhs                            # = G_q lambda; its z and roll rows give lambda
        lam = np.linalg.solve(Gd.T, np.array([f[1], f[3]])) * cn
        ch = max(abs(lam[0] / Nl - 1), abs(lam[1] / Nr - 1)); Nl, Nr = lam
        if Nl <= 0 or Nr <= 0: break                  # would lift: outside the model
        cl, Ql = creep(1.0, q, qd, se1, on, E, Nl); cr_, Qr = creep(-1.0, q, qd, se2, on, E, Nr)
        if ch < 1e-15 or (ch < 1e-13 and ch >= last): break
        last = ch
    f = Ma @ acc - (Ql + Qr - hh) - (g1[np.array([1, 2, 3, 4, 0])] * (Nl / cn) + g2[np.array([1, 2, 3, 4, 0])] * (Nr / cn)) * np.array([1.0, 1, 1, 1, 0])
    return q, qd, acc, cl, cr_, np.array([res, ch, it, max(abs(f[0]), abs(f[2]), abs(f[4]))])

@njit(cache=True)
def rhs(x, st, on, E, sus):
    acc = evaluate(x, st, on, E, sus)[2]
    return np.array([st[2], st[3], acc[0], acc[2], acc[4]])

def equilibrium(E=2.07e11):
    """centred: only the pitch rate is sought (pitch'' = 0, the axle moment vanishes)"""
    st = np.zeros(5); f = lambda p: evaluate(0.0, np.array([0, 0, 0, 0, p]), 0, E, 1.0)[2][4]
    for it in range(20):
        d = f(st[4]) * 2e-5 / (f(st[4] + 1e-5) - f(st[4] - 1e-5)); st[4] -= d
        if abs(d) < 1e-15: break
    return st
