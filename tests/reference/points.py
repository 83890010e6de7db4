import json
from ref import *
import mpcheck as mc, mpmath as mp
V=40.0
ze=R0+equilibrium(V)[1]
pts=[]
def zfor(x,q,target):
    """z such that the mean of the two elastic contact forces (or the single one) is about target"""
    lo,hi=-3e-3,3e-3
    def s(zr):
        q[1]=zr; _,_,cl,cr,*_=full(x,q,V,2,1.0,LX,SPC,True,CD)
        return sum(c[11]*max(c[4],0)**1.5 for c in (cl,cr))
    for _ in range(60):
        mid=.5*(lo+hi)
        if s(mid)>target: lo=mid
        else: hi=mid
    return round(R0+.5*(lo+hi),7)
spec=[ # x, y, yaw, roll, vy, vz, rollRate, yawRate, pitchRate
 ('both wheels, all states perturbed, straight',0.0, 0.008,0.020,0.00026,0.1,0.02,0.1,0.3,87.5),
 ('both wheels, in the deviation, hard',23.7,-0.003,-0.004,-0.00026,-0.1,-0.02,-0.05,-0.3,87.53),
 ('both wheels, in the deviation, nearly unsaturated',23.7,0.0012,0.0006,-0.00010,0.01,0.002,0.002,0.01,87.527),
 ('right wheel lifted a little, in the deviation',23.7,-0.003,-0.004,-0.00035,-0.1,-0.02,-0.05,-0.3,87.53),
 ('left wheel lifted, in the deviation, nearly unsaturated',23.7,0.0012,0.0006,0.00018,0.01,0.002,0.002,0.01,87.527),
 ('roll 3 mrad: one wheel lifted, in the deviation',23.7,0.008,0.020,0.003,0.1,0.02,0.1,0.3,87.5),
 ('fast separation: damping clips a force, straight',0.0,0.005,0.010,0.00020,0.1,0.02,1.1,-0.3,87.6),
]
out=[]
worst=0
for name,x,y,yaw,roll,vy,vz,rr,yr,pr in spec:
    q=np.array([y,0,yaw,roll,vy,vz,yr,rr,pr-V/R0])
    z=zfor(x,q,2*56680.0)
    q[1]=z-R0
    acc,fd,cl,cr,TB,*_=full(x,q,V,2,1.0,LX,SPC,True,CD)
    # the numbers written are those of the 40-digit run; the double run is compared
    g,o=mc.rhs(x,y,z,roll,yaw,vy,vz,rr,yr,pr,V)
    num=[acc[0],acc[1],acc[2],acc[3],acc[4],fd]
    ex=[g[k] for k in ('ay','az','yawAcc','rollAcc','pitchAcc','drivingForce')]
    rel=[abs(float((mp.mpf(float(a))-b)/b)) if b else abs(a) for a,b in zip(num,ex)]
    print(name,'z',z,'rel diff of accelerations double vs mp',['%.1e'%r for r in rel])
    for s,c in (('left',cl),('right',cr)):
        for i,n in enumerate(CN):
            if n in o[s]:
                b=o[s][n]; d=abs(float(mp.mpf(float(c[i]))-b))
                r=d/max(abs(float(b)),1e-12)
                if r>1e-9: print('   ',s,n,float(c[i]),mp.nstr(b,15),r)
        print('   ',s,'N',mp.nstr(o[s]['N'],12),'pen',mp.nstr(o[s]['penetration'],10),'rate',mp.nstr(o[s]['penetrationRate'],6),'sat',mp.nstr(o[s]['saturation'],6))
    out.append(dict(name=name,input=dict(V=V,distance=x,y=y,z=z,roll=roll,yaw=yaw,vy=vy,vz=vz,rollRate=rr,yawRate=yr,pitchRate=pr),
       accelerations={k:float(v) for k,v in g.items() if k not in('axleMoment','Fz')},
       contact={s:{k:float(v) for k,v in o[s].items()} for s in o}))
json.dump(dict(note='inputs are exactly the decimal-rounded doubles printed; outputs computed with 40 digits (mpmath), rounded to double; wheel coordinate u, rail eta, s = rail coordinate of contact along X (track), alpha = wheel angle ahead of bottom',points=out),open('rhs_points.json','w'),indent=1)
z,p=mc.equilibrium()
g,o=mc.rhs(0,0,z,0,0,0,0,0,0,p,40)
with open('equilibrium.txt','w') as fo:
    fo.write('z %s\npitchRate %s\nV/R0 %s\n'%(mp.nstr(z,18),mp.nstr(p,18),mp.nstr(mp.mpf(40)/mp.mpf('.457'),18)))
    for k in ('drivingForce','Fz','axleMoment'): fo.write('%s %s\n'%(k,mp.nstr(g[k],16)))
    for s in ('left','right'):
        for k,v in o[s].items(): fo.write('%s.%s %s\n'%(s,k.replace('FZ','FZ(Q)').replace('FY','FY(Y)'),mp.nstr(v,16)))
q=equilibrium(V); print('double eq z-mp',q[1]+R0-float(z),q[8]+V/R0-float(p))
