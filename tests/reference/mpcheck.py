"""Second derivation in mpmath, 40 digits: surfaces as callables, numerical tangents avoided by using closed forms built differently."""
import mpmath as mp, json, csv
import os
TABLE=os.path.join(os.path.dirname(os.path.abspath(__file__)),'../../src/contact/creep/kalker_coefficients.csv')
mp.mp.dps=40
f=mp.mpf
L=f('0.716');R0=f('0.457');con=f('0.025');Rr=f('0.3');beta=mp.atan(con)
EY=f('2.07e11');nu=f('0.28');G=EY/(2*(1+nu));mu=f('0.5');C=f('2e9')
m,I,Iy,gr,W,h2=f(1568),f(656),f(168),f('9.81'),f(98000),f('0.45')
rows=[r for r in csv.reader(l for l in open(TABLE) if l[0]!='#') if r[0] in('0.0','0.25','0.5')]
def natural(x,y):
    n=len(x);A=mp.matrix(n,n);b=mp.matrix(n,1);A[0,0]=1;A[n-1,n-1]=1
    for i in range(1,n-1):
        h0=x[i]-x[i-1];h1=x[i+1]-x[i]
        A[i,i-1]=h0;A[i,i]=2*(h0+h1);A[i,i+1]=h1;b[i]=6*((y[i+1]-y[i])/h1-(y[i]-y[i-1])/h0)
    return mp.lu_solve(A,b)
xs=[mp.log(f(r[1])) for r in rows if r[0]=='0.0'];SP=[]
for j in range(4):
    ys=[]
    for i in range(19):
        c=[f([r for r in rows if r[0]==k][i][2+j]) for k in('0.0','0.25','0.5')]
        # Newton divided differences in nu
        d1=(c[1]-c[0])/f('.25');d2=(c[2]-c[1])/f('.25');d3=(d2-d1)/f('.5')
        ys.append(c[0]+d1*nu+d3*nu*(nu-f('.25')))
    SP.append((ys,natural(xs,ys)))
def kal(r):
    x=mp.log(r);i=max(k for k in range(18) if xs[k]<=x);h=xs[i+1]-xs[i];a=(xs[i+1]-x)/h;b=(x-xs[i])/h
    return [a*y[i]+b*y[i+1]+((a**3-a)*M[i]+(b**3-b)*M[i+1])*h*h/6 for y,M in SP]
def rotz(a): return mp.matrix([[mp.cos(a),-mp.sin(a),0],[mp.sin(a),mp.cos(a),0],[0,0,1]])
def rotx(a): return mp.matrix([[1,0,0],[0,mp.cos(a),-mp.sin(a)],[0,mp.sin(a),mp.cos(a)]])
def col(*v): return mp.matrix([[f(a)] for a in v])
def dot(a,b): return sum(a[i]*b[i] for i in range(3))
def cr(a,b): return col(a[1]*b[2]-a[2]*b[1],a[2]*b[0]-a[0]*b[2],a[0]*b[1]-a[1]*b[0])
def dev(s):
    if s<=20 or s>=30: return f(0),f(0)
    k=2*mp.pi/10
    return f('.005')*(1-mp.cos(k*(s-20))),f('.005')*k*mp.sin(k*(s-20))
def rhs(x,y,z,roll,yaw,vy,vz,rollR,yawR,pitchR,V,track=True):
    x,y,z,roll,yaw,vy,vz,rollR,yawR,pitchR,V=map(f,(x,y,z,roll,yaw,vy,vz,rollR,yawR,pitchR,V))
    B=rotz(yaw)*rotx(roll);c=col(x,y,z)
    om=col(0,0,yawR)+rotz(yaw)*col(rollR,0,0)+B*col(0,pitchR,0)
    Ftot=col(0,0,-m*gr-W);T=col(0,0,0);out={}
    for sg,name in((1,'left'),(-1,'right')):
        def geo(u,al,s,e):
            R=R0-con*u
            rho=B*col(R*mp.sin(al),sg*(L+u),-R*mp.cos(al))
            t1w=B*col(-con*mp.sin(al),sg,con*mp.cos(al));t2w=B*col(R*mp.cos(al),0,R*mp.sin(al))
            q=mp.sqrt(Rr**2-e*e);d,dp=(dev(s) if sg<0 and track else (f(0),f(0)))
            # rail section: arc centre + polar form
            sec=rotx(sg*beta)*col(0,sg*e,q-Rr)
            tr2=rotx(sg*beta)*col(0,sg,-e/q)
            rr=col(s,sg*L+d,0)+sec;tr1=col(1,dp,0)
            n=cr(tr1,tr2)*sg;n=n/mp.sqrt(dot(n,n))
            return rho,t1w,t2w,rr,tr1,tr2,n,R
        def eqs(u,al,s,e):
            rho,t1w,t2w,rr,a1,a2,n,R=geo(u,al,s,e);r=c+rho-rr
            return [dot(a1,r),dot(a2,r),dot(t1w,n),dot(t2w,n)]
        sol=mp.findroot(eqs,(f(0),f(0),x+f('1e-20'),f(0)),tol=1e-70,maxsteps=50)
        u,al,s,e=sol
        rho,t1w,t2w,rr,a1,a2,n,R=geo(u,al,s,e)
        de=-dot(c+rho-rr,n);v=col(V,vy,vz)+cr(om,rho)
        e1=a1/mp.sqrt(dot(a1,a1));e2=cr(n,e1)
        A=1/(2*R*mp.sqrt(1+con**2));Bc=1/(2*Rr)
        g=mp.findroot(lambda g:(mp.ellipe(1-g*g)/g**2-mp.ellipk(1-g*g))/(mp.ellipk(1-g*g)-mp.ellipe(1-g*g))-Bc/A,(f('.75'),f('.76')))
        mm=mp.cbrt(2*mp.ellipe(1-g*g)/(mp.pi*g*g));nn=mm*g;xi=2*mp.ellipk(1-g*g)/(mp.pi*mm)
        Kh=2*EY*(A+Bc)/(3*(1-nu**2))/(xi*(A+Bc))**f(1.5)
        cc=kal(1/g);o=dict(u=u,alpha=al,s=s,eta=e,penetration=de,A=A,B=Bc,m=mm,n=nn,xiHertz=xi,Kh=Kh,c11=cc[0],c22=cc[1],c23=cc[2],c33=cc[3])
        o.update(xi_x=dot(v,e1)/V,xi_y=dot(v,e2)/V,phi=dot(om,n)/V,penetrationRate=-dot(v,n))
        N=Fx=Fy=Mz=f(0);a=b=f(0);fac=f(0)
        if de>0:
            N=max(f(0),Kh*de**f(1.5)+C*de*o['penetrationRate'])
            c0=mp.sqrt(de/(xi*(A+Bc)));a=mm*c0;b=nn*c0
            Fx=-G*a*b*cc[0]*o['xi_x'];Fy=-G*(a*b*cc[1]*o['xi_y']+(a*b)**f(1.5)*cc[2]*o['phi'])
            Mz=-G*(-(a*b)**f(1.5)*cc[2]*o['xi_y']+(a*b)**2*cc[3]*o['phi'])
            F=mp.hypot(Fx,Fy);
            if N>0:
                t=F/(mu*N);fac=(t-t**2/3+t**3/27)/t if t<3 else 1/t
            Fx*=fac;Fy*=fac;Mz*=fac
        Fv=N*n+Fx*e1+Fy*e2
        Ftot+=Fv;T+=cr(rho,Fv)+Mz*n
        o.update(a=a,b=b,N=N,creepFx=Fx,creepFy=Fy,creepMz=Mz,saturation=fac,FX=Fv[0],FY=Fv[1],FZ=Fv[2]);out[name]=o
    for h in(h2,-h2):
        r=B*col(0,h,0);vel=col(0,vy,vz)+cr(om,r)   # spin about axle gives nothing at a point on the axle
        Fs=col(-f('1.35e5')*r[0]-f('1e5')*vel[0],-f('2.5e5')*(y+r[1]-h),0)
        Ftot+=Fs;T+=cr(r,Fs)
    # Euler in the track frame: d/dt(J w)=T, with J=I*1+(Iy-I) a a^T (a axle axis); unknown alpha=dw/dt
    a=B*col(0,1,0);adot=cr(om,a);J=I*mp.eye(3)+(Iy-I)*(a*a.T)
    Jd=(Iy-I)*(adot*a.T+a*adot.T)
    al=mp.lu_solve(J,T-Jd*om)
    # alpha = yaw'' ez + roll'' X1 + pitch'' a + yawR ez x(rollR X1+pitchR a)+ rollR X1 x pitchR a
    X1=rotz(yaw)*col(1,0,0);ez=col(0,0,1)
    rest=al-cr(ez,X1)*(yawR*rollR)-pitchR*cr(yawR*ez+rollR*X1,a)
    S=mp.matrix(3,3)
    for i in range(3): S[i,0]=ez[i];S[i,1]=X1[i];S[i,2]=a[i]
    dd=mp.lu_solve(S,rest)
    return dict(ay=Ftot[1]/m,az=Ftot[2]/m,yawAcc=dd[0],rollAcc=dd[1],pitchAcc=dd[2],drivingForce=-Ftot[0],axleMoment=dot(a,T),Fz=Ftot[2]),out
def equilibrium(V=40):
    def fn(z,p):
        r,_=rhs(0,0,z,0,0,0,0,0,0,p,V);return [r['Fz'],r['axleMoment']]
    return mp.findroot(fn,(f('0.45692728828'),f('87.52735')),tol=1e-40,maxsteps=30,verify=False)
