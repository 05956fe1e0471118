import json, math, random, subprocess, sys, os, time
from concurrent.futures import ThreadPoolExecutor
MAIN='/tmp/tumble_main'
def run(args, **k): return subprocess.run(args, capture_output=True, text=True, **k)
def simulate(d, sched, truth, seed):
    os.makedirs(d, exist_ok=True)
    sp, tp, op = d+'/s.campaign.json', d+'/t.json', d+'/o.campaign.json'
    json.dump(sched, open(sp,'w')); json.dump(truth, open(tp,'w'))
    r = run([MAIN,'simulate',sp,'--truth',tp,'--seed',str(seed),'-o',op,'--force'])
    if r.returncode: raise RuntimeError(r.stderr[:500])
    return json.load(open(op))
def values(c):
    return [r['V'] if not isinstance(r['V'],dict) else r['V']['value'] for r in c['readings']]
def gs(cols):
    Q=[]
    for c in cols:
        v=c[:]
        n0=math.sqrt(sum(x*x for x in v))
        for _ in range(2):
            for q in Q:
                d=sum(a*b for a,b in zip(q,v)); v=[a-d*b for a,b in zip(v,q)]
        n=math.sqrt(sum(x*x for x in v))
        if n>1e-9*max(n0,1e-300): Q.append([x/n for x in v])
    return Q
def proj(Q,c):
    v=c[:]
    for _ in range(2):
        for q in Q:
            d=sum(a*b for a,b in zip(q,v)); v=[a-d*b for a,b in zip(v,q)]
    return v
norm=lambda v: math.sqrt(sum(x*x for x in v))
dot=lambda a,b: sum(x*y for x,y in zip(a,b))
def schedule(rng, drop):
    kind=rng.choice(['gyro','gyro','acc'])
    rd=[]; t=rng.uniform(60,140); temp=22.0
    def push(p,**j):
        nonlocal t,temp
        rd.append(dict(position=str(p),time_s=round(t,1),temperature_c=round(temp,3),**j)); t+=rng.uniform(60,140); temp+=0.12*rng.gauss(0,1)
    if kind=='gyro':
        n=rng.randint(6,24); pos=set()
        step=rng.choice([90,45,30])
        while len(pos)<n: pos.add((step*rng.randrange(360//step), step*rng.randrange(360//step)))
        pos=list(pos); rng.shuffle(pos)
        nr=rng.choice([1,2,2,3]); rates=[x for r in rng.sample([10,15,20,30,40,50,60],nr) for x in (r,-r)]
        for k,(a,b) in enumerate(pos):
            for _ in range(rng.choice([1,1,2])):
                for r in rates: push(k+1,alpha_deg=a,beta_deg=b,gamma_deg_s=r)
        est=['V0','dtheta_x0','dtheta_y0','dtheta_y1','dtheta_y2','dtheta_z2']
        bench,known='gyro-turntable',{'kI':{'value':-2.9222,'u':0}}
        sd=10**rng.uniform(-4.3,-3.7); inputs=['I','S','O']
        terms=['a_S','a_O','a_I','a_S^2','a_O^2','a_I*a_S','a_I*a_O','w_I^2','abs(w_I)','w_I^3','sign(w_I)','gamma_deg_s^2','sin(2*beta)','cos(2*alpha)','gamma_deg_s*cos(2*beta)','time_s','temperature_c','abs(a_S)','a_I^2','gamma_deg_s*sin(3*alpha)','time_s^2']
    else:
        n=rng.randint(10,36); off=rng.choice([0,0,5])
        for rep in range(rng.choice([1,2,3])):
            for k in range(n): push(k+1,beta_deg=round(360/n*k+off,6))
        est=['V0','dtheta_y2','dtheta_z2']; bench,known='accelerometer-plumb-plane',{'kI':{'value':1.299,'u':0}}
        sd=10**rng.uniform(-5.7,-5.0); inputs=['I','P','O']
        terms=['a_I^2','a_I^3','a_P','a_P^2','abs(a_P)','abs(a_I)','sin(2*beta)','cos(2*beta)','sin(3*beta)','cos(4*beta)','time_s','temperature_c','a_I*a_P','a_P^3','sign(a_I)','time_s^2']
    dropped=None
    if drop:
        dropped=rng.choice([e for e in est if e!='V0' and (bench!='accelerometer-plumb-plane' or e=='dtheta_z2')])
        est=[e for e in est if e!=dropped]
    if len(rd)-len(est)<6: return schedule(rng,drop)
    return dict(bench=bench,known=known,estimate={e:{} for e in est},readings=rd),est,sd,terms,dropped
def outside(rng,rd,bench):
    n=len(rd); t=[r['time_s'] for r in rd]; T=t[-1]-t[0]; u=[(x-t[0])/T for x in t]
    k=rng.choice(['course','walk','bump','square','lobes','positions','smooth_angle','harmonic'])
    joints=[j for j in ('alpha_deg','beta_deg') if len({r.get(j) for r in rd})>3] or ['beta_deg']
    j=rng.choice(joints)
    ang=[math.radians(r[j]) for r in rd]
    if k=='course':
        m=rng.randint(3,6); a=[(rng.gauss(0,1),rng.gauss(0,1)) for _ in range(m)]
        v=[sum(p*math.cos(2*math.pi*(i+.5)*x)+q*math.sin(2*math.pi*(i+.5)*x) for i,(p,q) in enumerate(a)) for x in u]
    elif k=='walk':
        s=0; v=[]
        for _ in u: s+=rng.gauss(0,1); v.append(s)
    elif k=='bump':
        c=rng.random(); w=rng.uniform(.04,.15); v=[math.exp(-.5*((x-c)/w)**2) for x in u]
    elif k=='square':
        f=rng.uniform(2.5,7); p=rng.random(); v=[1.0 if (f*x+p)%1<.5 else -1.0 for x in u]
    elif k=='lobes':
        c=rng.uniform(0,6.28); kk=rng.uniform(2,8); v=[math.exp(kk*(math.cos(x-c)-1)) for x in ang]
    elif k=='positions':
        s={}; v=[s.setdefault(r['position'],rng.gauss(0,1)) for r in rd]
    elif k=='smooth_angle':
        a=[(rng.gauss(0,1)/(1+i/2),rng.gauss(0,1)/(1+i/2)) for i in range(9)]
        v=[sum(p*math.cos((i+1)*x)+q*math.sin((i+1)*x) for i,(p,q) in enumerate(a)) for x in ang]
    else:
        f=rng.uniform(1.3,6.7); p=rng.uniform(0,6); v=[1.0 if math.sin(f*x+p)>0 else -1.0 for x in ang]
    if 'gamma_deg_s' in rd[0] and rng.random()<.3:
        v=[a*r['gamma_deg_s']/60 for a,r in zip(v,rd)]; k+='*rate'
    return k,v
def campaign(d,mode,seed):
    rng=random.Random(seed)
    for attempt in range(40):
        sched,est,sd,terms,dropped=schedule(rng,mode=='tilts')
        tv={e:{'value':(2e-3 if e=='V0' else 4e-4)*rng.gauss(0,1)} for e in est}
        if dropped: tv[dropped]={'value':rng.choice([-1,1])*rng.uniform(2e-4,1e-3)}
        stated=rng.random()<.5
        quiet=lambda eff,extra={}: {'values':{**tv,**extra},'noise':{'V':{'sd':sd*1e-9 if True else sd,'stated':False}},'effects':eff}
        base=values(simulate(d,sched,quiet([]),1))
        J=[]
        for e in est:
            h=1e-4
            up=values(simulate(d,sched,quiet([],{e:{'value':tv[e]['value']+h}}),1))
            J.append([(a-b)/h for a,b in zip(up,base)])
        Q=gs(J)
        col={}
        def column(reg):
            if reg not in col:
                try:
                    s=1.0
                    up=values(simulate(d,sched,quiet([{'regressor':reg,'value':1e-3}]),1))
                    col[reg]=[(a-b)/1e-3 for a,b in zip(up,base)]
                except RuntimeError as e: col[reg]=None
            return col[reg]
        n={'none':0,'outside':0,'one':1,'mixed':1,'two':2,'three':3,'tilts':1}[mode]
        chosen=[]; tries=0
        while len(chosen)<n and tries<60:
            tries+=1
            r=rng.choice(terms); c=column(r)
            if c is None or r in [x for x,_ in chosen]: continue
            p=proj(Q,c)
            if norm(p)<.1*norm(c) : continue
            q=proj(gs(J+[x for _,x in chosen]),c)
            if norm(q)<.35*norm(p): continue
            chosen.append((r,c))
        if len(chosen)<n: continue
        if dropped:
            h=1e-4; z={e:dict(v) for e,v in tv.items()}
            up=values(simulate(d,sched,quiet([],{dropped:{'value':tv[dropped]['value']+h}}),1))
            tc=[(a-b)/h for a,b in zip(up,base)]
            if norm(proj(gs(J+[c for _,c in chosen]),tc))*abs(tv[dropped]['value'])/sd<10: continue
            col['tilt:'+dropped]=tc
        eff=[]; stands=True
        for i,(r,c) in enumerate(chosen):
            others=J+[x for k,(_,x) in enumerate(chosen) if k!=i]+([col['tilt:'+dropped]] if dropped else [])
            left=norm(proj(gs(others),c)); t=math.exp(rng.uniform(math.log(10),math.log(40)))
            if left<.2*norm(proj(Q,c)): break
            eff.append({'regressor':r,'value':rng.choice([-1,1])*t*sd/left})
        if len(eff)<n: continue
        truth={'values':tv,'noise':{'V':{'sd':sd,'stated':stated}},'effects':eff}
        c=simulate(d,sched,truth,seed)
        kind=None; pat=None
        if mode in('outside','mixed'):
            kind,v=outside(rng,c['readings'],c['bench'])
            p=proj(Q,v); 
            if norm(p)<.2*norm(v): continue
            rms=rng.uniform(2,5); s=rms*sd*math.sqrt(len(v))/norm(p)
            pat=[s*x for x in v]
            if mode=='mixed':
                pc=proj(Q,chosen[0][1]); cos=dot(pc,p)/norm(pc)/norm(p)
                if abs(cos)>.8: continue
                t=abs(eff[0]['value'])*norm(pc)*math.sqrt(1-cos*cos)/sd
                stands=t/math.sqrt(1+rms*rms)>=8
            for r,x in zip(c['readings'],pat):
                if isinstance(r['V'],dict): r['V']['value']+=x
                else: r['V']+=x
        # stated noise: u keys come from simulate
        path=d+'/c.campaign.json'; json.dump(c,open(path,'w'))
        hidden=[r for r,_ in chosen]+(['tilt:'+dropped] if dropped else [])
        return dict(path=path,mode=mode,seed=seed,hidden=hidden,kind=kind,pat=pat,Q=Q,column=column,col=col,stated=stated,stands=stands,tv={k:v['value'] for k,v in tv.items()},bench=c['bench'],n=len(c['readings']))
    return None
def judge(binary,k,d):
    o=d+'/'+os.path.basename(binary)+'.json'
    if os.path.exists(o): os.remove(o)
    import resource
    t=time.time()
    r=run([binary,'diagnose',k['path'],'--json',o],env=dict(os.environ,RAYON_NUM_THREADS='1'),timeout=300)
    sec=time.time()-t
    if not os.path.exists(o): return dict(right=False,wrong=['FAILED '+r.stderr[:200]],v='fail',held=(0,0),sec=sec,names=[])
    j=json.load(open(o)); effs=[e for e in j['effects']]
    right=0; named=[]; wrong=[]; probs=[]
    for e in effs:
        al=[e['regressor']]+[a['regressor'] for a in e.get('aliases',[])]
        named.append(al)
    hid=set(k['hidden'])
    got=sum(any(h in al for al in named) for h in hid)
    targets=[proj(k['Q'],k['column'](h)) for h in hid if k['column'](h)]
    if k['pat']: targets.append(proj(k['Q'],k['pat']))
    cols=[proj(k['Q'],k['column'](al[0])) for al in named if k['column'](al[0])]
    made=False
    if k['pat'] and cols:
        rest=proj(gs([proj(k['Q'],c) for c in cols]),targets[-1]); made=norm(rest)<=math.sqrt(1-.81)*norm(targets[-1])
    for e,al in zip(effs,named):
        if hid & set(al): ok=True
        else:
            c=k['column'](al[0]); ok=made
            if c and not ok:
                p=proj(k['Q'],c); ok=any(abs(dot(p,t))>=.85*norm(p)*norm(t) for t in targets if norm(t)>0) if norm(p)>0 else False
        if not ok: wrong.append(al[0])
        probs.append((e.get('probability'),ok))
    sus=[s.get('regressor') for s in (j.get('suspected') or [])]
    v=j['verdict']
    if k['mode']=='none': right=v=='nothing-missing'
    elif k['mode']=='outside': right=not wrong and v!='nothing-missing'
    elif k['mode']=='mixed': right=got==1
    else: right=got==len(hid) and not wrong
    h=[0,0]
    for p in j['parameters']:
        b=p.get('after') or {}
        val=b.get('value') if isinstance(b,dict) else None
        i=p['id']; 
        u=(b.get('u_in_all') or b.get('u_total') or b.get('u')) if isinstance(b,dict) else None
        if i in k['tv'] and i!='V0' and val is not None and u:
            h[1]+=1; h[0]+=abs(val-k['tv'][i])<=1.96*u
    return dict(right=right,wrong=wrong,v=v,held=h,sec=sec,names=[a[0] for a in named],sus=sus,probs=probs)
if __name__=='__main__':
    count=int(sys.argv[1]); seed=int(sys.argv[2]); bins=sys.argv[3].split(','); modes=sys.argv[4].split(',') if len(sys.argv)>4 else ['one','two','three','none','tilts','outside','mixed']
    def job(mk):
        m,s=mk; d=f'/tmp/exp/{m}{s}'
        k=campaign(d,m,s)
        return None if k is None else (k,{b:judge(b,k,d) for b in bins})
    jobs=[(m,seed+1000*i+j) for i,m in enumerate(modes) for j in range(count)]
    with ThreadPoolExecutor(2) as ex: res=[r for r in ex.map(job,jobs) if r]
    for b in bins:
        print('==',b)
        pr=[]
        for m in modes:
            own=[(k,r[b]) for k,r in res if k['mode']==m]; st=[(k,r) for k,r in own if k['stands']]
            if not own: continue
            n=len(st); h=[sum(r['held'][i] for _,r in own) for i in (0,1)]
            quiet=sum(r['v']=='nothing-missing' for _,r in own)
            print(f"{m:8} n {len(own):3} stands {n:3} right {sum(r['right'] for _,r in st):3} ({100*sum(r['right'] for _,r in st)/max(n,1):.0f} %) or suspected {sum(r['right'] or any(x in k['hidden'] for x in r.get('sus',[])) for k,r in st):3} wrong {sum(bool(r['wrong']) for _,r in own):3} quiet {quiet} held {100*h[0]/max(h[1],1):.0f} % sec {sum(r['sec'] for _,r in own)/len(own):.2f} max {max(r['sec'] for _,r in own):.2f}")
            for k,r in own:
                pr+=r.get('probs',[])
                if r['wrong'] or (k['stands'] and not r['right']): print('     ',k['seed'],k['bench'],k['n'],'st' if k['stated'] else 'un',k['hidden'],k['kind'],'->',r['v'],r['names'],'sus',r.get('sus'),'WRONG' if r['wrong'] else '',r['wrong'])
