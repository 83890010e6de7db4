"""trajectory, states, equilibrium; python run.py [out.csv rtol atol [E factor [integrator [max step]]]] : only a trajectory"""
import json, sys, time
from model import *
from scipy.integrate import solve_ivp
iR = {k: i for i, k in enumerate(REC)}
def run(rtol, atol, E=2.07e11, method='DOP853', hmax=1e-3, grid=np.arange(101) / 20):
    """rows at grid (before the kink where a grid time is one), states on both sides of the kinks"""
    leave = lambda t, q: V * t + evaluate(V * t, q, 1, E, 1.0)[4][iR['s_minus_x']] - 30.0
    leave.terminal = True; leave.direction = 1
    st = equilibrium(E); rows = {}; kinks = []; a = 0.0; n = 0
    for b, on, ev in ((0.5, 0, None), (0.76, 1, leave), (5.0, 0, None)):
        s = solve_ivp(lambda t, q: rhs(V * t, q, on, E, 1.0), (a, b), st, method=method, rtol=rtol, atol=atol, max_step=hmax, events=ev, dense_output=True)
        assert s.status >= 0, s.message
        end = s.t[-1]; n += s.nfev
        for t in grid:
            if (t > a or t == 0) and t <= end and t not in rows:        # the row itself by a step that ends there: no interpolation error
                i = np.searchsorted(s.t, t, 'right') - 1; q = s.y[:, i]
                if t > s.t[i]: q = solve_ivp(lambda t, q: rhs(V * t, q, on, E, 1.0), (s.t[i], t), q, method=method, rtol=rtol, atol=atol, first_step=t - s.t[i]).y[:, -1]
                rows[t] = (q, on)
        if on == 1:                                                     # sharpen the end: Newton in t with the same one-step integration
            i = np.searchsorted(s.t, end) - 1 - (s.t[-1] - s.t[-2] < 1e-7)
            for _ in range(4):
                q = solve_ivp(lambda t, q: rhs(V * t, q, on, E, 1.0), (s.t[i], end), s.y[:, i], method=method, rtol=rtol, atol=atol, first_step=end - s.t[i]).y[:, -1]; end -= leave(end, q) / V
        else: q = s.y[:, -1]
        st = q.copy(); kinks.append((end, q.copy())); a = end
    print('nfev', n, 'leaves the deviation at', repr(kinks[1][0]), flush=True)
    return rows, kinks
ORDER = 't,y,z,yaw,roll,vy,yawRate,pitchRate,left_N,right_N,left_Fx,left_Fy,right_Fx,right_Fy'
def record(t, q, on, E=2.07e11):
    p, qd, acc, l, r, res = evaluate(V * t, q, on, E, 1.0)
    return dict(t=t, y=p[1], z=p[2], yaw=p[3], roll=p[4], vy=q[2], yawRate=q[3], pitchRate=q[4] + V / R0, left_N=l[0], right_N=r[0],
                left_Fx=l[1], left_Fy=l[2], right_Fx=r[1], right_Fy=r[2]), res, (p, qd, acc, l, r)
def table(rows, E=2.07e11): return np.array([[record(t, *rows[t], E)[0][k] for k in ORDER.split(',')] for t in sorted(rows)])
if __name__ == '__main__' and len(sys.argv) > 3:
    a = sys.argv; E = 2.07e11 * (float(a[4]) if len(a) > 4 else 1)
    g = np.unique(np.r_[np.arange(101) / 20, 0.5 + np.arange(26) / 50]) if len(a) > 7 else np.arange(101) / 20
    rows, k = run(float(a[2]), float(a[3]), E, a[5] if len(a) > 5 else 'DOP853', float(a[6]) if len(a) > 6 else 1e-3, g)
    T = table(rows, E); np.savetxt(a[1], T, delimiter=',', header=ORDER, comments='', fmt='%.17g')
    res = np.array([record(t, *rows[t], E)[1] for t in rows]); print('largest gap, loop change, iterations, row residual:', res.max(0), 'min N', T[:, 8:10].min())
    json.dump([dict(t=t, state=list(q)) for t, q in k], open(a[1] + '.kinks.json', 'w'))
