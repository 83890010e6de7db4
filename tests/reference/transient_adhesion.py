"""Transient rolling of an elastic half-space pair with full adhesion (no slip) after a step of creepage from rest:
F(s)/F(infinity), compared with the exponential of the relaxation length. Shift per step = one element."""
import numpy as np
from scipy.linalg import lu_factor, lu_solve
nu=0.28
def J(x,y,hx,hy):
    a=b=c=0.0
    for sx in(1,-1):
        for sy in(1,-1):
            X=x+sx*hx;Y=y+sy*hy;r=np.hypot(X,Y);s=sx*sy
            ly=np.log(Y+r);lx=np.log(X+r)
            a=a+s*((1-nu)*(X*ly+Y*lx)+nu*Y*lx)
            b=b+s*((1-nu)*(X*ly+Y*lx)+nu*X*ly)
            c=c+s*nu*(-r)
    return a/np.pi,b/np.pi,c/np.pi   # G = 1
def agm(a,b):
    for _ in range(6): a,b=(a+b)/2,np.sqrt(a*b)
    return a
def run(a,b,n,dirn):
    hx=a/n;hy=b/n
    xs=(np.arange(n)-(n-1)/2)*2*hx;ys=(np.arange(n)-(n-1)/2)*2*hy
    X,Y=np.meshgrid(xs,ys,indexing='ij');m=(X/a)**2+(Y/b)**2<1
    x=X[m];y=Y[m];N=len(x)
    def mat(sh):
        dx=x[:,None]+sh-x[None,:];dy=y[:,None]-y[None,:]
        # log(X+r) with X<0,Y~0 : use stable shift
        A,B,C=J(dx,dy,hx,hy);return np.block([[A,C],[C,B]])
    A0=mat(0.0);A1=mat(2*hx);lu=lu_factor(A0)
    rhs=np.zeros(2*N);rhs[dirn*N:(dirn+1)*N]=2*hx
    p=np.zeros(2*N);F=[0.0]
    for k in range(5*n):
        p=lu_solve(lu,A1@p+rhs);F.append(p[dirn*N:(dirn+1)*N].sum()*4*hx*hy)
    return np.array(F),2*hx,m.sum()*4*hx*hy/(np.pi*a*b)
K={ # Kalker nu=0.28 c11,c22 exact program values
0.5:(3.7158,3.0042),1.0:(4.1624,3.6493),2.0:(5.1833,4.9571),0.3:(3.551,2.743),5.0:(7.877,8.2804)}
for r in (0.3,0.5,1.0,2.0,5.0):
    a,b=np.sqrt(r),1/np.sqrt(r)
    for d in(0,1):
        F,ds,ar=run(a,b,30,d)
        Fi=F[-1];c=Fi/(a*b)/ar
        s=np.arange(len(F))*ds
        y=F/Fi
        k0=F[1]/ds
        kM=4*agm(a,b)/(2-nu)
        L=K[r][d]*(2-nu)*a*b/(4*agm(a,b))
        err=np.abs(y-(1-np.exp(-s/L))).max()
        at=s[np.argmax(np.abs(y-(1-np.exp(-s/L))))]
        # best fit L
        best=min(((np.abs(y-(1-np.exp(-s/q))).max(),q) for q in np.linspace(.3,3,271)*a))
        s63=np.interp(1-np.exp(-1),y,s)
        area=np.trapezoid(1-y,s)
        print(f"a/b {r} dir {d}: c {c:.4f} (exact {K[r][d]}), k0/kMindlin_mean {k0/kM:.3f}, L/a {L/a:.3f}, s63/a {s63/a:.3f}, int/a {area/a:.3f}, max err {err:.3f} at {at/a:.2f}a, best L/a {best[1]/a:.2f} err {best[0]:.3f}")
        if r==1.0: print(' s/a',[round(q,2) for q in s[::5]/a],'y',[round(q,4) for q in y[::5]])
