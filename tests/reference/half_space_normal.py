"""Normal force of S1002 on 60E1 from elastic half-space theory, for tests of the law `hertz` with curvature = "patch".

The normal problem of two equal half spaces is solved on a grid of rectangles with constant pressure: pressure >= 0, deformed
gap >= 0, the approach of the bodies given. Conjugate gradients on the loaded rectangles (Polonsky and Keer, Wear 231 (1999) 206),
Boussinesq's influence numbers (Love 1929) by FFT. Check: with a grid of 0.3 mm three Hertzian contacts are met to 0.05 %.
Needs numpy. Usage: half_space_normal.py Y_MM ...   (lateral displacement of the wheel; prints N at 70 um)
Profiles: S1002 (EN 13715) zones B, C, D; 60E1 (EN 13674-1:2017) radii 300, 80, 13 mm, inclined 0.025 rad; tread circles
1500 mm and rail crowns 1507 mm apart. E 207 GPa, nu 0.28. The gap is taken along the normal at the contact.
"""
import numpy as np, sys
B=[0.0,-0.03358537058,0.001565681624,-2.810427944e-05,5.844240864e-08,-1.562379023e-08,5.309217349e-15,-5.957839843e-12,2.646656573e-13]
C=[-4320.221063,-1038.384026,-106.5501873,-6.051367875,-0.2054332446,-0.004169739389,-4.687195829e-05,-2.25275554e-07]
def wheel(y):
    z=np.where(y>32.15796,1.36432364-0.066666667*y,np.where(y>-26,np.polyval(B[::-1],y),np.polyval(C[::-1],y)))
    s=y+26.210665
    z=np.where(y<-35,16.446-np.sqrt(np.maximum(169-s*s,0)),z)
    return z
arcs=[(0,10.228,0,-300,300),(10.228,26.0265,7.500533,-80.127896,80),(26.0265,36.0,23.016030,-14.949147,13)]
def rail(x):
    a=np.abs(x); z=np.full_like(a,-100.)
    for f,t,cx,cz,r in arcs:
        m=(a>=f)&(a<=t); z[m]=cz+np.sqrt(r*r-(a[m]-cx)**2)
    return z
inc=0.025
e=np.linspace(-35.9,35.9,71801)
# rail section rotated towards the track centre: outward axis tilts; eta,h -> Y,Z (outward Y)
re,rh=e,rail(e)
c,s=np.cos(inc),np.sin(inc)
RY=re*c - rh*s; RZ=re*s + rh*c   # outward = (c, s), up=(-s, c)  (up leans inward)
RY=RY+753.5
def gapcurve(y,Y):
    u=Y-750-y
    wz=-(wheel(u))  # + const
    rz=np.interp(Y,RY,RZ)
    return wz-rz
E = 2.07e11
nu = 0.28
def boussinesq(nx,ny,dx,dy):
    x=(np.arange(-nx,nx))*dx; y=(np.arange(-ny,ny))*dy
    X,Y=np.meshgrid(x,y,indexing='ij')
    def f(a,b): return a*np.log(b+np.hypot(a,b))+b*np.log(a+np.hypot(a,b))
    xp,xm=X+dx/2,X-dx/2; yp,ym=Y+dy/2,Y-dy/2
    K=f(xp,yp)-f(xp,ym)-f(xm,yp)+f(xm,ym)
    return K*2*(1-nu**2)/(np.pi*E)   # both bodies
def solve(h,dx,dy,N=None):
    # h: gap minus approach (negative=overlap), find p>=0, u+h>=0
    nx,ny=h.shape
    K=np.fft.fft2(np.fft.ifftshift(boussinesq(nx,ny,dx,dy)))
    def op(p):
        P=np.zeros((2*nx,2*ny));P[:nx,:ny]=p
        return np.fft.ifft2(np.fft.fft2(P)*K).real[:nx,:ny]
    p=np.where(h<0,1e8,0.);t=np.zeros_like(p);Gold=1.;delta=0
    for it in range(600):
        r=op(p)+h   # gap
        act=p>0
        G=(r[act]**2).sum()
        t=np.where(act,r+delta*(G/Gold)*t,0);Gold=G
        q=op(t)
        tau=(r[act]*t[act]).sum()/(q[act]*t[act]).sum()
        pold=p;p=np.maximum(p-tau*t,0)
        ov=(p==0)&(r<0)
        if ov.any(): delta=0;p=np.where(ov,p-tau*r,p)
        else: delta=1
        err=np.abs(p-pold).sum()/np.abs(p).sum()
        if err<1e-6: break
    return p,it
def run(y,delta=70e-6,n=0.3):
    Y=np.arange(725,784,0.001)
    G=gapcurve(y,Y)
    i=np.argmin(G)
    # precise contact angle
    ang=np.arctan(np.gradient(RZ,RY)[np.searchsorted(RY,Y[i])])
    g=(G-G[i])*np.cos(ang)*1e-3
    t=(Y-Y[i])/np.cos(ang)
    R=0.46+wheel(Y[i]-750-y)*1e-3
    A=1/(2*R)*np.cos(ang)
    dy=n;nyh=int(24/dy)
    tt=np.arange(-nyh,nyh+1)*dy
    gl=np.interp(tt,t,g,left=1e-2,right=1e-2)
    xx=np.arange(-int(11/n),int(11/n)+1)*n
    h=A*(xx[:,None]*1e-3)**2+gl[None,:]-delta
    p,it=solve(h,n*1e-3,dy*1e-3)
    N=p.sum()*n*dy*1e-6
    w=tt[(p>0).any(0)]
    return Y[i],A,N,w.min(),w.max(),p.max(),it
if __name__=="__main__":
    for y in [float(v) for v in sys.argv[1:]]:
        Yc,A,N,w0,w1,pm,it=run(y)
        eta=Yc-753.5
        print(f"y {y:5.2f} eta~{eta:7.2f} A {A:.4f} N {N/1e3:7.2f} kN  t {w0:6.1f}..{w1:5.1f} pmax {pm/1e6:.0f} MPa it {it}",flush=True)
