import math,random,sys
random.seed(int(sys.argv[1])); bands=len(sys.argv)>2
n=72; B=[math.radians(15*(k%24)) for k in range(n)]; T=[k/71 for k in range(n)]
y=[random.gauss(0,1) for b in B]
def gs(cols):
    Q=[]
    for c in cols:
        c=c[:]
        for _ in range(2):
            for q in Q:
                d=sum(a*b for a,b in zip(c,q)); c=[a-d*b for a,b in zip(c,q)]
        m=math.sqrt(sum(a*a for a in c)); Q.append([a/m for a in c])
    return Q
Q=gs([[1]*n,[math.cos(b) for b in B],[math.sin(b) for b in B]])
cand={}
L=math.log
for k in range(2,13):
    if True: cand['cos(%d)'%k]=([math.cos(k*b) for b in B],4)
    if k<12: cand['sin(%d)'%k]=([math.sin(k*b) for b in B],4)
cand['abs(a_P)']=([abs(math.cos(b)) for b in B],3); cand['abs(a_O)']=([abs(math.sin(b)) for b in B],3)
cand['a_P^3']=([math.cos(b)**3 for b in B],3); cand['a_O^3']=([math.sin(b)**3 for b in B],3)
cand['sign(a_P)']=([math.copysign(1,math.cos(b)+1e-3) for b in B],4);cand['sign(a_O)']=([math.copysign(1,math.sin(b)+1e-3) for b in B],4)
cand['a_P^2']=([math.cos(b)**2 for b in B],2); cand['aPaO']=([math.cos(b)*math.sin(b) for b in B],2)
cand['t']=(T,2); cand['t2']=([t*t for t in T],3)
pri=[L(.01)-.2*r for c,r in cand.values()]
names=list(cand); cols=[c for c,r in cand.values()]
for k in range(24):
    names.append('pos%d'%k); cols.append([1.0 if i%24==k else 0.0 for i in range(n)]); pri.append(L(.01)-L(24)-.6)
for k in range(72):
    names.append('read%d'%k); cols.append([1.0 if i==k else 0.0 for i in range(n)]); pri.append(L(.01)-L(72)-.6)
    if k: names.append('step%d'%k); cols.append([1.0 if i>=k else 0.0 for i in range(n)]); pri.append(L(.01)-L(71)-.8)
K=[]
def norm(name,F):
    tr=sum(v*v for c in F for v in c); s=math.sqrt(n/tr); K.append((name,[[v*s for v in c] for c in F]))
norm('place',[[1.0 if i%24==k else 0.0 for i in range(n)] for k in range(24)])
def har(w,orders): return [[w(h)*f(h*b) for b in B] for h in orders for f in (math.cos,math.sin)]
norm('smooth',har(lambda h:math.exp(-.25*h*h),range(1,13)))
norm('rough',har(lambda h:1/math.sqrt(1+(.3*h)**2),range(1,13)))
if bands:
    o=1
    for lo,hi in [(1,2),(3,4),(5,6),(7,8),(9,10),(11,12)]: norm('band%d'%lo,har(lambda h:1,range(lo,hi+1)))
for nm,l in [('smooth',.3),('smooth',.1),('rough',1),('rough',.1),('rough',.02)]:
    F=[]
    for h in range(1,65):
        f=math.pi*h*l; w=math.exp(-.25*f*f) if nm=='smooth' else 1/math.sqrt(1+f*f)
        if w>1e-9: F.append([w*math.cos(math.pi*h*t) for t in T])
    norm('%s in time %g'%(nm,l),F)
norm('reading',[[1.0 if i==k else 0.0 for i in range(n)] for k in range(n)])
def mat(cols): print(len(cols[0]),len(cols)); print(' '.join('%.10e'%v for c in cols for v in c))
print(0); mat([y]); mat(Q); mat(cols); mat([pri]); print(' '.join(names)); print(len(K))
for nm,F in K: print(nm); mat(F)
