"""Second derivation, 60 digits: both wheels' surface equations solved together for z and roll, their time derivatives by finite
differences along the motion (h = 1e-14 s), Newton-Euler in the track frame, one root search for accelerations and both N."""
import sys; sys.path.insert(0, '..')
import mpmath as mp
from mpcheck import f, L, R0, con, Rr, beta, EY, nu, G, mu, m, I, Iy, gr, W, h2, kal, rotz, rotx, col, dot, cr, dev
mp.mp.dps = 60
V = f(40)
def surfaces(x, y, z, yaw, roll, sg, u, al, s, e, track):
    B = rotz(yaw) * rotx(roll); R = R0 - con * u
    rho = B * col(R * mp.sin(al), sg * (L + u), -R * mp.cos(al))
    tw = [B * col(-con * mp.sin(al), sg, con * mp.cos(al)), B * col(R * mp.cos(al), 0, R * mp.sin(al))]
    d, d1 = dev(s) if sg < 0 and track else (f(0), f(0)); q = mp.sqrt(Rr**2 - e * e)
    rr = col(s, sg * L + d, 0) + rotx(sg * beta) * col(0, sg * e, q - Rr)
    t1, t2 = col(1, d1, 0), rotx(sg * beta) * col(0, sg, -e / q); n = sg * cr(t1, t2); n = n / mp.sqrt(dot(n, n))
    return col(x, y, z) + rho - rr, tw, t1, n, rho, R
def place(x, y, yaw, track, guess):
    def eqs(*v):
        z, roll = v[:2]; o = []
        for sg, w in ((1, v[2:6]), (-1, v[6:10])):
            r, tw, t1, n, _, _ = surfaces(x, y, z, yaw, roll, sg, *w, track)
            o += [r[0], r[1], r[2], dot(tw[0], n), dot(tw[1], n)]
        return o
    v = mp.matrix(guess)
    for it in range(9):                                # Newton, Jacobian by differences of 1e-25: error shrinks by 1e-25 per step at the end
        F = mp.matrix(eqs(*v)); J = mp.matrix(10, 10)
        for j in range(10):
            w = v.copy(); w[j] += f('1e-25'); g = mp.matrix(eqs(*w))
            for i in range(10): J[i, j] = (g[i] - F[i]) / f('1e-25')
        d = mp.lu_solve(J, F); v -= d
        if mp.norm(d, mp.inf) < f('1e-35'): return v
    raise ValueError('no convergence')
def wheel(N, v, om, n, t1, R):
    e1 = t1 / mp.sqrt(dot(t1, t1)); e2 = cr(n, e1)
    A = 1 / (2 * R * mp.sqrt(1 + con**2)); B = 1 / (2 * Rr)
    g = mp.findroot(lambda g: (mp.ellipe(1 - g * g) / g**2 - mp.ellipk(1 - g * g)) / (mp.ellipk(1 - g * g) - mp.ellipe(1 - g * g)) - B / A, (f('.75'), f('.76')))
    a1 = mp.cbrt(2 * mp.ellipe(1 - g * g) / (mp.pi * g * g))
    s = mp.cbrt(N * 3 * (1 - nu**2) / (2 * EY * (A + B))); a = a1 * s; b = a * g; c = kal(1 / g)   # Hertz: a = m (3 N (1-nu^2) / (2 E (A+B)))^(1/3)
    cx, cy, sp = dot(v, e1) / V, dot(v, e2) / V, dot(om, n) / V
    Fx = -G * a * b * c[0] * cx; Fy = -G * (a * b * c[1] * cy + (a * b)**f(1.5) * c[2] * sp); Mz = -G * (-(a * b)**f(1.5) * c[2] * cy + (a * b)**2 * c[3] * sp)
    t = mp.hypot(Fx, Fy) / (mu * N); k = 1 - t / 3 + t * t / 27 if t < 3 else 1 / t
    return k * (Fx * e1 + Fy * e2), k * Mz, dict(N=N, Fx=k * Fx, Fy=k * Fy, Mz=k * Mz, xi_x=cx, xi_y=cy, phi=sp, a=a, b=b, saturation=k)
def state(x, y, yaw, vy, yawR, pitchR, track=True):
    x, y, yaw, vy, yawR, pitchR = map(f, (x, y, yaw, vy, yawR, pitchR)); h = f('1e-14')
    p0 = place(x, y, yaw, track, [R0, 0, 0, 0, x + f('1e-20'), 0, 0, 0, x + f('1e-20'), 0])
    at = lambda *d: place(x + d[0], y + d[1], yaw + d[2], track, p0)
    up, dn = at(V * h, vy * h, yawR * h), at(-V * h, -vy * h, -yawR * h)
    rate = (up - dn) / (2 * h); conv = (up - 2 * p0 + dn) / h**2
    py = (at(0, h, 0) - at(0, -h, 0)) / (2 * h); pp = (at(0, 0, h) - at(0, 0, -h)) / (2 * h)
    z, roll, vz, rollR = p0[0], p0[1], rate[0], rate[1]
    B = rotz(yaw) * rotx(roll); X1, ez, a = rotz(yaw) * col(1, 0, 0), col(0, 0, 1), B * col(0, 1, 0)
    om = yawR * ez + rollR * X1 + pitchR * a
    geo = [surfaces(x, y, z, yaw, roll, sg, *p0[i:i + 4], track) for sg, i in ((1, 2), (-1, 6))]
    vel = [col(V, vy, vz) + cr(om, g[4]) for g in geo]
    F0, T0 = col(0, 0, -m * gr - W), col(0, 0, 0)
    for s in (h2, -h2):
        r = s * a; vs = cr(om, r); Fs = col(-f('1.35e5') * r[0] - f('1e5') * vs[0], -f('2.5e5') * (y + r[1] - s), 0); F0 += Fs; T0 += cr(r, Fs)
    Jt = I * mp.eye(3) + (Iy - I) * (a * a.T); ad = cr(om, a); Jd = (Iy - I) * (ad * a.T + a * ad.T)
    out = {}
    def eqs(ay, aps, ath, Nl, Nr):
        az = conv[0] + py[0] * ay + pp[0] * aps; aro = conv[1] + py[1] * ay + pp[1] * aps
        F, T = F0.copy(), T0.copy()
        for N, g, v, name in ((Nl, geo[0], vel[0], 'left'), (Nr, geo[1], vel[1], 'right')):
            Fc, Mz, out[name] = wheel(N, v, om, g[3], g[2], g[5]); Fv = N * g[3] + Fc; F += Fv; T += cr(g[4], Fv) + Mz * g[3]
        al = aps * ez + aro * X1 + ath * a + yawR * rollR * cr(ez, X1) + pitchR * cr(yawR * ez + rollR * X1, a)
        r = T - Jt * al - Jd * om
        out['acc'] = [ay, az, aps, aro, ath]
        return [(F[1] - m * ay) / 1000, (F[2] - m * az) / 1000, r[0] / 1000, r[1] / 1000, r[2] / 1000]
    u = mp.matrix([0, 0, 0, 56680, 56680])
    for it in range(40):                               # Newton, difference Jacobian
        Fv = mp.matrix(eqs(*u)); J = mp.matrix(5, 5)
        for j in range(5):
            w = u.copy(); w[j] += f('1e-20'); g = mp.matrix(eqs(*w))
            for i in range(5): J[i, j] = (g[i] - Fv[i]) / f('1e-20')
        d = mp.lu_solve(J, Fv); u -= d
        if mp.norm(d, mp.inf) < f('1e-22'): break
    else: raise ValueError('loop')
    eqs(*u)
    for i, k in enumerate(('left', 'right')):
        out[k].update(u=p0[2 + 4 * i], s_minus_x=p0[4 + 4 * i] - x, eta=p0[5 + 4 * i], n=list(geo[i][3]), normalVelocity=dot(vel[i], geo[i][3]))
    out.update(z=z, roll=roll, vz=vz, rollRate=rollR)
    return out
def equilibrium():
    return mp.findroot(lambda p: state(0, 0, 0, 0, 0, p)['acc'][4], (f('87.5273'), f('87.5274')), tol=1e-40)
