"""accuracy (tolerances, integrators) and comparison with the elastic program"""
import numpy as np, csv
def rd(n): return {k: np.array(v, float) for k, v in zip(*(lambda r: (r[0], zip(*r[1:])))(list(csv.reader(l for l in open(n) if l[0] != '#'))))}
a = rd('scratch/a.csv')
for n in ('b', 'r', 'e'):
    o = rd(f'scratch/{n}.csv'); ia = np.searchsorted(np.round(o['t'], 6), np.round(a['t'], 6))
    print(n, {k: '%.1e' % np.abs(a[k] - o[k][ia]).max() for k in a})
def cmp(name, rig, el):
    x, y = rd(rig), rd(el); ix = {round(t, 6): i for i, t in enumerate(x['t'])}
    p = [(ix[round(t, 6)], j) for j, t in enumerate(y['t']) if round(t, 6) in ix]; i, j = map(list, zip(*p)); t = x['t'][i]
    print(name, len(i), 'times')
    pair = dict(y='y', yaw='yaw', z='z', roll='roll', vy='vy', yawRate='yawRate', pitchRate='pitchRate', left_N='N_left', right_N='N_right', left_Fx='creepFx_left', left_Fy='creepFy_left', right_Fy='creepFy_right')
    for k, e in pair.items():
        d = y[e][j] - x[k][i]; m = np.abs(d); far = (t > 0.9)
        print('  %-9s max |elastic - rigid| %.3e at t=%.2f; after 0.9 s %.3e; scale %.3e' % (k, m.max(), t[m.argmax()], m[far].max(), np.abs(x[k][i]).max()))
    return t, y['y'][j] - x['y'][i]
import os
cmp('E: tests/data', 'scratch/e.csv', '../../data/suspended_wheelset_trajectory.csv')
t1, d1 = cmp('E: elastic rerun', 'scratch/e.csv', 'scratch/el/e1.csv')
t2, d2 = cmp('64 E', 'scratch/e64.csv', 'scratch/el/e64.csv')
for t in (0.6, 0.7, 0.8, 1.0, 1.2, 1.5, 2.0, 3.0, 4.0, 5.0):
    i = np.argmin(abs(t1 - t)); print(t, '%.4e %.4e' % (d1[i], d2[i]), 'ratio %.2f' % (d1[i] / d2[i]))
print('rms ratio', np.sqrt((d1**2).mean() / (d2**2).mean()), 'max ratio', abs(d1).max() / abs(d2).max())
def ratio(t1, d1, t2, d2):
    for t in (0.6, 0.7, 0.8, 1.0, 1.2, 1.5, 2.0, 3.0, 4.0, 5.0):
        i = np.argmin(abs(t1 - t)); print(t, '%.4e %.4e' % (d1[i], d2[i]), 'ratio %.2f' % (d1[i] / d2[i]))
    print('rms ratio', np.sqrt((d1**2).mean() / (d2**2).mean()), 'max ratio', abs(d1).max() / abs(d2).max())
t2, d2 = cmp('normal stiffness alone 64, damping 16', 'scratch/e.csv', 'scratch/el/k64.csv'); ratio(t1, d1, t2, d2)
t2, d2 = cmp('64 E, damping 16', 'scratch/e64.csv', 'scratch/el/e64b.csv'); ratio(t1, d1, t2, d2)
