"""writes the delivered CSV and JSON: states from the 60-digit program, compared with the double one; needs scratch/a.csv (run.py)"""
from run import *
import mp_check as mc, mpmath as mp
QN = ('ddy', 'ddz', 'ddyaw', 'ddroll', 'ddpitch')
def double(x, st, on=2):
    q, qd, acc, l, r, res = evaluate(x, np.array(st, float), on, 2.07e11, 1.0)
    d = dict(z=q[2], roll=q[4], vz=qd[2], rollRate=qd[4], **dict(zip(QN, acc)))
    return d, dict(left=dict(zip(REC, l)), right=dict(zip(REC, r))), res
def both(x, y, yaw, vy, yr, pr, track=True):
    o = mc.state(x, y, yaw, vy, yr, pr, track)
    dep = dict(z=o['z'], roll=o['roll'], vz=o['vz'], rollRate=o['rollRate'], **dict(zip(QN, o['acc'])))
    dd, dc, res = double(x, [y, yaw, vy, yr, pr - V / R0], 2 if track else 0)
    con = {}; err = {k: abs(float(dd[k] - dep[k])) for k in dep}
    for s in ('left', 'right'):
        n = o[s].pop('n'); o[s].update(n_x=n[0], n_y=n[1], n_z=n[2]); con[s] = {k: float(v) for k, v in o[s].items() if k != 'normalVelocity'}
        for k in o[s]: err[s + ' ' + k] = abs(float(dc[s][k] - o[s][k]))
        con[s]['approach'] = dc[s]['approach']; con[s]['A'] = dc[s]['A']; con[s]['B'] = dc[s]['B']
    top = lambda *e: '%.0e' % max(v for k, v in err.items() if k.endswith(e))
    print('double - 60 digits: z, roll', '%.0e' % max(err['z'], err['roll']), 'their rates', top('vz', 'rollRate'), 'accelerations', top(*QN), 'N Fx Fy', top(' N', ' Fx', ' Fy'), 'creepages', top('xi_x', 'xi_y', 'phi'),
          's eta u n', top('s_minus_x', 'eta', ' u', 'n_x', 'n_y', 'n_z'), '| normal velocity', '%.0e' % dc['left']['normalVelocity'], 'loop', res, 'factors %.3f %.3f' % (con['left']['saturation'], con['right']['saturation']))
    return {k: float(v) for k, v in dep.items()}, con
spec = [('straight, far off', 12.0, 0.006, 0.005, 0.1, 0.1, 87.5), ('in the deviation', 23.7, -0.003, -0.004, -0.05, -0.1, 87.53),
        ('in the deviation, nearly unsaturated', 23.7, 0.0012, 0.0006, 0.01, 0.01, 87.527), ('in the deviation, full slip', 27.3, 0.005, 0.003, 0.05, 0.2, 88.5),
        ('start of the deviation, far off', 21.1, -0.006, -0.005, 0.08, 0.3, 87.4)]
states = []
for name, x, *v in spec:
    dep, con = both(x, *v); ind = dict(zip(('y', 'yaw', 'vy', 'yawRate', 'pitchRate'), v))
    states.append(dict(name=name, input=dict(V=V, distance=x, **ind), dependent={k: dep[k] for k in ('z', 'roll', 'vz', 'rollRate')},
                       accelerations={k: dep[k] for k in QN}, contact=con))
p = mc.equilibrium(); st = equilibrium(); print('equilibrium pitch rate, double - mp', st[4] + V / R0 - float(p)); o = mc.state(0, 0, 0, 0, 0, p, False)
n = {s: o[s].pop('n') for s in ('left', 'right')}
eq = dict(z=float(o['z']), pitchRate=float(p), left={k: float(v) for k, v in o['left'].items()}, right={k: float(v) for k, v in o['right'].items()})
kinks = []
for d, (a, b) in zip(json.load(open('scratch/a.csv.kinks.json'))[:2], ((0, 1), (1, 0))):
    side = {}
    for nm, on in (('before', a), ('after', b)):
        dd, dc, _ = double(V * d['t'], d['state'], on); side[nm] = dict(accelerations={k: dd[k] for k in QN}, left_N=dc['left']['N'], right_N=dc['right']['N'])
    s = d['state']; kinks.append(dict(t=d['t'], y=s[0], yaw=s[1], vy=s[2], yawRate=s[3], pitchRate=s[4] + V / R0, **side))
json.dump(dict(note='Suspended wheelset, rigid (constraint) contact, SI units. states: inputs are the printed doubles; z, roll, vz, rollRate follow from the constraints; outputs '
  'computed with 60 digits (mpmath) and rounded. n: unit normal out of the rail; s_minus_x, eta: rail contact coordinates; u: wheel lateral coordinate, + outward; Fx, Fy, Mz, xi_x, xi_y, phi: along '
  'e1 (rail tangent), e2 = n x e1 (+ left), n; forces on the wheel. a, b: semi-axes along e1, e2. kinks: the right contact at the ends of the deviation, both sides.',
  equilibrium=eq, kinks=kinks, states=states), open('suspended_wheelset_constraint_states.json', 'w'), indent=1)
T = np.loadtxt('scratch/a.csv', delimiter=',', skiprows=1)
for t in (0.6, 0.7, 1.0, 3.0):                       # rows against 60 digits
    r = T[np.argmin(abs(T[:, 0] - t))]; i = ORDER.split(','); g = lambda k: float(r[i.index(k)])
    dep, con = both(V * g('t'), g('y'), g('yaw'), g('vy'), g('yawRate'), g('pitchRate'))
    print('row', t, 'z', g('z') - dep['z'], 'roll', g('roll') - dep['roll'], [con[s][k] - g(s + '_' + k) for s in ('left', 'right') for k in ('N', 'Fx', 'Fy')])
with open('suspended_wheelset_constraint_trajectory.csv', 'w') as f:
    f.write('''# Scene suspended_wheelset with RIGID contact (one ideal constraint per wheel, normal force = multiplier, Hertz patch from it, no contact
# damping), computed by an independent program written from the equations alone (Python; minimal coordinates y, yaw, pitch; z and roll
# from the two gap equations; scipy DOP853, rtol 1e-13, atol 1e-14, steps ending at both ends of the deviation). SI units.
# y, z, yaw, roll within 1e-13, their rates within 2e-12, N and creep forces within 5e-7 N: differences from runs with Radau (rtol 1e-11)
# and DOP853 (1e-11, 1e-12). Evaluations against a second derivation with 60 digits: z, roll 2e-16, N and creep forces 2e-8 N.
# Fx, Fy: creep forces on the wheel along e1 (rail tangent, about track X) and e2 = n x e1 (+ left); N along the rail's normal n.
# t = 0.5 is the state before the deviation begins (the right N and all accelerations jump there); the right contact leaves the deviation at
# t = %.16g, so row 0.75 is after it.
''' % kinks[1]['t'])
    f.write(ORDER + '\n')
    np.savetxt(f, T, delimiter=',', fmt='%.17g')
