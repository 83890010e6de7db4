"""Independent reference: suspended wheelset, ECF-A.  All scalar code, numba-compiled."""
import csv, math, numpy as np
import os
TABLE=os.path.join(os.path.dirname(os.path.abspath(__file__)),'../../src/contact/creep/kalker_coefficients.csv')
from numba import njit
from fractions import Fraction
L=0.716; R0=0.457; CON=0.025; RR=0.3; BETA=math.atan(0.025); SB=math.sin(BETA); CB=math.cos(BETA)
E_Y=2.07e11; NU=0.28; G=E_Y/(2*(1+NU)); CD=2e9; MU=0.5
M=1568.0; I=656.0; IY=168.0; GR=9.81; W=98000.0
H2=0.45
AMP=0.010
# ---- Kalker splines (natural cubic in ln(a/b); parabola in nu of c)
from scipy.interpolate import CubicSpline
def kalker_nodes():
    t={}
    for r in csv.reader(l for l in open(TABLE) if l[0]!='#'):
        if r[0]=='nu' or r[2]=='': continue
        t.setdefault(float(r[0]),[]).append([float(Fraction(v)) for v in r[1:6]])
    T=[np.array(t[k]) for k in (0.0,0.25,0.5)]
    x=T[0][:,0].copy(); assert len(x)==19 and all(np.array_equal(x,q[:,0]) for q in T)
    n=NU
    w=[(n-.25)*(n-.5)/(.25*.5), n*(n-.5)/(.25*(-.25)), n*(n-.25)/(.5*.25)]
    C=sum(wi*q[:,1:] for wi,q in zip(w,T))
    return np.log(x),C
def make_spline():
    lx,C=kalker_nodes()
    cs=CubicSpline(lx,C,bc_type='natural')
    return lx,np.ascontiguousarray(cs.c)   # c[k,interval,comp]
LX,SPC=make_spline()

@njit(cache=True)
def kal(LX,SPC,r):
    x=math.log(r); i=0
    while i<len(LX)-2 and x>LX[i+1]: i+=1
    d=x-LX[i]
    o=np.empty(4)
    for j in range(4):
        o[j]=((SPC[0,i,j]*d+SPC[1,i,j])*d+SPC[2,i,j])*d+SPC[3,i,j]
    return o

@njit(cache=True)
def KE(k2):
    a=1.0; b=math.sqrt(1-k2); c2=k2; s=0.5*k2; p=1.0
    for _ in range(12):
        c=0.5*(a-b); t=0.5*(a+b); b=math.sqrt(a*b); a=t
        s+=p*c*c; p*=2
        if abs(c)<1e-17: break
    K=math.pi/(2*a)
    return K,K*(1-s)

@njit(cache=True)
def hertz(A,B):
    """A = half relative curvature along e1, B along e2. returns m_x (along e1), m_y, xi"""
    lo=min(A,B); hi=max(A,B); rho=hi/lo
    if rho<1+1e-9:
        return 1.0,1.0,1.0
    g=(1/rho)**0.63
    for it in range(50):
        k2=1-g*g; K,E=KE(k2)
        F=(E/(g*g)-K)-rho*(K-E)
        dE=-g/k2*(E-K); dK=-g/k2*(E/(g*g)-K)
        dF=dE/(g*g)-2*E/g**3-dK-rho*(dK-dE)
        d=F/dF; g-=d
        if abs(d)<1e-15: break
        if abs(d)<1e-11 and it>0: 
            # one more polishing step then leave
            k2=1-g*g; K,E=KE(k2)
            F=(E/(g*g)-K)-rho*(K-E); g-=F/dF
            break
    k2=1-g*g; K,E=KE(k2)
    m=(2*E/(math.pi*g*g))**(1.0/3); n=m*g; xi=2*K/(math.pi*m)
    if A<=B: return m,n,xi
    return n,m,xi

@njit(cache=True)
def dev(s,on):
    """right rail Y deviation and 2 derivatives. on: 0 straight, 1 cosine formula, 2 decide by s"""
    if on==0 or (on==2 and (s<=20.0 or s>=30.0)): return 0.0,0.0,0.0
    k=2*math.pi/10.0; a=k*(s-20.0)
    return 0.5*AMP*(1-math.cos(a)),0.5*AMP*k*math.sin(a),0.5*AMP*k*k*math.cos(a)

@njit(cache=True)
def gauss4(a,b):
    n=4
    for i in range(n):
        p=i
        for j in range(i+1,n):
            if abs(a[j,i])>abs(a[p,i]): p=j
        if p!=i:
            for k in range(n):
                t=a[i,k]; a[i,k]=a[p,k]; a[p,k]=t
            t=b[i]; b[i]=b[p]; b[p]=t
        for j in range(i+1,n):
            f=a[j,i]/a[i,i]
            for k in range(i,n): a[j,k]-=f*a[i,k]
            b[j]-=f*b[i]
    for i in range(n-1,-1,-1):
        for k in range(i+1,n): b[i]-=a[i,k]*b[k]
        b[i]/=a[i,i]

@njit(cache=True)
def dot(a,b): return a[0]*b[0]+a[1]*b[1]+a[2]*b[2]
@njit(cache=True)
def cross(a,b): return np.array([a[1]*b[2]-a[2]*b[1],a[2]*b[0]-a[0]*b[2],a[0]*b[1]-a[1]*b[0]])

@njit(cache=True)
def search(sg,x,y,zr,Bm,on):
    """sg=+1 left,-1 right. zr = z-R0.  unknowns u,alpha,s-x,eta.  returns params,rho,n,e1,delta"""
    u=0.0; al=0.0; ds=0.0; et=0.0
    c=np.array([0.0,y,zr+R0])
    J=np.zeros((4,4)); F=np.zeros(4)
    last=0
    for it in range(60):
        R=R0-CON*u; Rp=-CON; Rpp=0.0
        sa=math.sin(al); ca=math.cos(al)
        w=Bm@np.array([R*sa,sg*(L+u),-R*ca])
        t1=Bm@np.array([Rp*sa,sg,-Rp*ca]); t2=Bm@np.array([R*ca,0.0,R*sa])
        w11=Bm@np.array([Rpp*sa,0.0,-Rpp*ca]); w12=Bm@np.array([Rp*ca,0.0,Rp*sa]); w22=Bm@np.array([-R*sa,0.0,R*ca])
        q=math.sqrt(RR*RR-et*et); f=-et*et/(q+RR); fp=-et/q; fpp=-RR*RR/q**3
        d=0.0; dp=0.0; dpp=0.0
        if sg<0: d,dp,dpp=dev(x+ds,on)
        rr=np.array([ds,sg*(L+et*CB-f*SB)+d,et*SB+f*CB])
        a1=np.array([1.0,dp,0.0]); a2=np.array([0.0,sg*(CB-fp*SB),SB+fp*CB])
        a11=np.array([0.0,dpp,0.0]); a22=np.array([0.0,-sg*fpp*SB,fpp*CB])
        n=cross(a1,a2)*sg; n1=cross(a11,a2)*sg; n2=cross(a1,a22)*sg
        r=c+w-rr
        if last==1: break
        F[0]=dot(a1,r); F[1]=dot(a2,r); F[2]=dot(t1,n); F[3]=dot(t2,n)
        J[0,0]=dot(a1,t1); J[0,1]=dot(a1,t2); J[0,2]=dot(a11,r)-dot(a1,a1); J[0,3]=-dot(a1,a2)
        J[1,0]=dot(a2,t1); J[1,1]=dot(a2,t2); J[1,2]=-dot(a2,a1); J[1,3]=dot(a22,r)-dot(a2,a2)
        J[2,0]=dot(w11,n); J[2,1]=dot(w12,n); J[2,2]=dot(t1,n1); J[2,3]=dot(t1,n2)
        J[3,0]=dot(w12,n); J[3,1]=dot(w22,n); J[3,2]=dot(t2,n1); J[3,3]=dot(t2,n2)
        gauss4(J,F)
        u-=F[0]; al-=F[1]; ds-=F[2]; et-=F[3]
        e=max(max(abs(F[0]),abs(F[1])),max(abs(F[2]),abs(F[3])))
        if e<1e-9: last=1   # quadratic: next error ~1e-18; residual pass
    nn=n/math.sqrt(dot(n,n)); e1=a1/math.sqrt(dot(a1,a1))
    delta=-dot(r,nn)
    p=np.array([u,al,ds,et])
    kr=-fpp/(1+fp*fp)**1.5
    kw1=1/(R*math.sqrt(1+Rp*Rp)); kw2=-Rpp/(1+Rp*Rp)**1.5
    return p,w,nn,e1,delta,0.5*kw1,0.5*(kr+kw2),it

# contact record layout
CN=['u','alpha','s_minus_x','eta','penetration','penetrationRate','A','B','m','n','xiHertz','Kh','a','b','c11','c22','c23','c33',
    'N','xi_x','xi_y','phi','creepFx','creepFy','creepMz','FX','FY','FZ','MX','MY','MZ','saturation','rho_x','rho_y','rho_z','n_x','n_y','n_z','e1_x','e1_y','e1_z','LinFx','LinFy','LinMz']
NC=len(CN)

@njit(cache=True)
def contact(sg,x,y,zr,Bm,vc,om,V,on,LX,SPC,creep_on,cd):
    o=np.zeros(NC)
    p,rho,n,e1,de,A,B,it=search(sg,x,y,zr,Bm,on)
    e2=cross(n,e1)
    v=vc+cross(om,rho)
    dd=-dot(v,n)
    mx,my,xi=hertz(A,B)
    Kh=(2*E_Y*(A+B)/(3*(1-NU*NU)))/(xi*(A+B))**1.5
    N=0.0;a=0.0;b=0.0
    Fx=0.0;Fy=0.0;Mz=0.0;ep=0.0
    lx=0.0;ly=0.0;lm=0.0
    cx=dot(v,e1)/V; cy=dot(v,e2)/V; ph=dot(om,n)/V
    k=kal(LX,SPC,mx/my)
    if de>0:
        N=max(0.0,Kh*de*math.sqrt(de)+cd*de*dd)
        c0=math.sqrt(de/(xi*(A+B))); a=mx*c0; b=my*c0
        ab=a*b
        lx=-G*ab*k[0]*cx
        ly=-G*(ab*k[1]*cy+ab*math.sqrt(ab)*k[2]*ph)
        lm=-G*(-ab*math.sqrt(ab)*k[2]*cy+ab*ab*k[3]*ph)
        if N>0 and creep_on:
            t=math.sqrt(lx*lx+ly*ly)/(MU*N)
            if t<=3: ep=1-t/3+t*t/27
            else: ep=1/t
            Fx=ep*lx; Fy=ep*ly; Mz=ep*lm
    F=N*n+Fx*e1+Fy*e2
    Mo=cross(rho,F)+Mz*n
    vals=(p[0],p[1],p[2],p[3],de,dd,A,B,mx,my,xi,Kh,a,b,k[0],k[1],k[2],k[3],N,cx,cy,ph,Fx,Fy,Mz,F[0],F[1],F[2],Mo[0],Mo[1],Mo[2],ep,
          rho[0],rho[1],rho[2],n[0],n[1],n[2],e1[0],e1[1],e1[2],lx,ly,lm)
    for i in range(NC): o[i]=vals[i]
    return o

@njit(cache=True)
def axle(yaw,roll):
    c=math.cos(yaw);s=math.sin(yaw);cr=math.cos(roll);sr=math.sin(roll)
    return np.array([[c,-s*cr,s*sr],[s,c*cr,-c*sr],[0.0,sr,cr]])

# state q = y, z-R0, yaw, roll, vy, vz, yawRate, rollRate, pitchRate - V/R0
@njit(cache=True)
def full(x,q,V,on,sus,LX,SPC,creep_on,cd):
    y=q[0];zr=q[1];ps=q[2];ro=q[3];vy=q[4];vz=q[5];pd=q[6];rd=q[7];td=q[8]+V/R0
    Bm=axle(ps,ro)
    sr=math.sin(ro);cr=math.cos(ro);sp=math.sin(ps);cp=math.cos(ps)
    w1=rd;w2=td+pd*sr;w3=pd*cr
    om=Bm@np.array([w1,w2,w3])
    vc=np.array([V,vy,vz])
    cl=contact(1.0,x,y,zr,Bm,vc,om,V,on,LX,SPC,creep_on,cd)
    cr_=contact(-1.0,x,y,zr,Bm,vc,om,V,on,LX,SPC,creep_on,cd)
    F=cl[25:28]+cr_[25:28]
    T=cl[28:31]+cr_[28:31]
    F[2]-=M*GR+W
    # suspension
    KX=1.35e5*sus;CX=1.0e5*sus;KY=2.5e5*sus;CY=0.0*sus
    fs=np.zeros(6)
    for i in range(2):
        h=H2 if i==0 else -H2
        ry=np.array([h*Bm[0,1],h*Bm[1,1],h*Bm[2,1]])
        # velocity of axle-fixed point relative to centre: Omega x r (axis motion)
        dvx=h*(-cp*cr*pd+sp*sr*rd); dvy=h*(-sp*cr*pd-cp*sr*rd)
        dx=ry[0]; dy=y+ry[1]-h
        f=np.array([-KX*dx-CX*dvx,-KY*dy-CY*(vy+dvy),0.0])
        F+=f; T+=cross(ry,f)
        fs[3*i]=f[0];fs[3*i+1]=f[1]
    TB=Bm.T@T
    O2=pd*sr
    rdd=(TB[0]-O2*I*w3+w3*IY*w2)/I
    w2d=TB[1]/IY
    w3d=(TB[2]-rd*IY*w2+O2*I*rd)/I
    pdd=(w3d+pd*rd*sr)/cr
    tdd=w2d-pdd*sr-pd*rd*cr
    acc=np.array([F[1]/M,F[2]/M,pdd,rdd,tdd])
    return acc,-F[0],cl,cr_,TB,fs,T,F

@njit(cache=True)
def rhs_(x,q,V,on,sus,LX,SPC):
    acc=full(x,q,V,on,sus,LX,SPC,True,CD)[0]
    o=np.empty(9)
    o[0]=q[4];o[1]=q[5];o[2]=q[6];o[3]=q[7]
    o[4]=acc[0];o[5]=acc[1];o[6]=acc[2];o[7]=acc[3];o[8]=acc[4]
    return o

def equilibrium(V,sp=None):
    LXs,S=sp or (LX,SPC)
    q=np.zeros(9); q[1]=-1e-4
    def g(v):
        q[1],q[8]=v
        acc,_,_,_,TB,*_=full(0.0,q,V,0,1.0,LXs,S,True,CD)
        return np.array([acc[1],TB[1]])
    v=np.array([-7e-5,0.0])
    for it in range(40):
        f=g(v); J=np.empty((2,2))
        for j,h in enumerate((1e-8,1e-5)):
            e=np.zeros(2);e[j]=h
            J[:,j]=(g(v+e)-g(v-e))/(2*h)
        d=np.linalg.solve(J,f); v=v-d
        if abs(d[0])<1e-18 and abs(d[1])<1e-15: break
    g(v)
    return q.copy()
