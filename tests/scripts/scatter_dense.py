"""What scatters, with whole matrices: generalised least squares, restricted likelihood and the Kenward-Roger covariance in numpy, and item 11's
shared offset up to 1e12 times the noise in exact fractions.

Writes tests/data/scatter/dense.json; nothing is shared with the program but the numbers. Run: python3 tests/scripts/scatter_dense.py
"""
import json
from fractions import Fraction
import numpy as np

rng = np.random.default_rng(20261121)


def gls(a, y, v):
    w = np.linalg.inv(v)
    c = np.linalg.inv(a.T @ w @ a)
    x = c @ a.T @ w @ y
    return x, c


def markov(t, tau):
    return np.exp(-np.abs(t[:, None] - t[None, :]) / tau)


def members(levels):
    return (np.asarray(levels)[:, None] == np.asarray(levels)[None, :]).astype(float)


cases = []


def case(name, a, y, u, lines):
    """lines: dicts with level, by, variance and for a chain time and tau."""
    v = np.diag(u**2)
    for line in lines:
        by = np.asarray(line["by"])
        k = members(line["level"]) if "tau" not in line else members(line["run"]) * markov(np.asarray(line["time"]), line["tau"])
        v = v + line["variance"] * by[:, None] * by[None, :] * k
    x, c = gls(a, y, v)
    r = y - a @ x
    w = np.linalg.inv(v)
    p_ = w - w @ a @ c @ a.T @ w
    studentized = (w @ r) / np.sqrt(np.diag(p_))
    case_ = dict(name=name, a=a.tolist(), y=y.tolist(), u=u.tolist(), lines=lines, solution=x.tolist(), covariance=c.tolist(),
                 chi_square=float(r @ np.linalg.solve(v, r)), log_determinant=float(np.linalg.slogdet(v)[1]),
                 studentized=studentized.tolist(), redundancy=(u**2 * np.diag(p_)).tolist())
    cases.append(case_)


m = 60
t = np.sort(rng.uniform(0, 100, m))
a = np.column_stack([np.ones(m), np.sin(t / 7), t / 50])
u = rng.uniform(0.5, 2, m)
y = rng.normal(size=m) * 2
z = rng.normal(size=m)
position, day, operator = (np.arange(m) // 3).tolist(), (np.arange(m) // 15).tolist(), (np.arange(m) % 4).tolist()
ones = np.ones(m).tolist()
p = dict(level=position, by=z.tolist(), variance=1.7)
d = dict(level=day, by=ones, variance=0.4)
o = dict(level=operator, by=(z**2).tolist(), variance=2.5)
chain = dict(level=list(range(m)), run=[0] * m, time=t.tolist(), tau=9.0, by=ones, variance=3.0)
runs = dict(level=list(range(m)), run=day, time=t.tolist(), tau=20.0, by=z.tolist(), variance=0.8)
case("positions", a, y, u, [p])
case("positions within days", a, y, u, [p, d])
case("positions crossed with operators", a, y, u, [p, o])
case("three lines", a, y, u, [p, d, o])
case("a chain in time", a, y, u, [chain])
case("a chain for each day, felt differently", a, y, u, [runs])
case("a chain, positions and operators", a, y, u, [chain, p, o])
case("two chains", a, y, u, [chain, runs])
big = 400
pos = (np.arange(big) // 4).tolist()
dy = (np.arange(big) // 200).tolist()
zb = rng.normal(size=big)
case("a hundred positions in two days", np.column_stack([np.ones(big), zb]), rng.normal(size=big), np.ones(big),
     [dict(level=pos, by=(zb + 0.5).tolist(), variance=2.0), dict(level=dy, by=[1.0] * big, variance=0.7)])

# REML and Kenward-Roger: unbalanced, two lines with different derivatives, noise of two groups
m = 40
lev = np.array([0, 0, 0, 1, 1, 2, 2, 2, 2, 3, 4, 4, 5, 5, 5, 6, 6, 7, 7, 7] * 2)
lev[20:] += 4
group = np.array([0, 1] * 20)
a = np.column_stack([np.ones(m), np.linspace(-1, 1, m), np.cos(np.arange(m))])
by = 1 + 0.5 * np.sin(np.arange(m))
other = np.arange(m) % 6
y = a @ [1, 2, 3] + 1.5 * by * rng.normal(size=12)[lev] + 0.8 * rng.normal(size=6)[other] + np.where(group == 0, 0.3, 0.6) * rng.normal(size=m)
parts = [np.diag((group == 0) * 1.0), np.diag((group == 1) * 1.0), by[:, None] * by[None, :] * members(lev), members(other)]


def reml(theta):
    v = sum(s * k for s, k in zip(theta, parts))
    w = np.linalg.inv(v)
    c = np.linalg.inv(a.T @ w @ a)
    pm = w - w @ a @ c @ a.T @ w
    return v, w, c, pm


theta = np.array([0.1, 0.4, 2.0, 0.5])
for _ in range(300):
    v, w, c, pm = reml(theta)
    s = np.array([[np.trace(pm @ g @ pm @ h) for h in parts] for g in parts])
    q = np.array([y @ pm @ g @ pm @ y for g in parts])
    new = np.linalg.solve(s, q)
    step = np.clip(new / theta, 0.2, 5)
    theta = theta * step
assert np.max(np.abs(step - 1)) < 1e-12, step
assert theta.min() > 0.01
v, w, c, pm = reml(theta)
s = np.array([[np.trace(pm @ g @ pm @ h) for h in parts] for g in parts])
spread = 2 * np.linalg.inv(s)
px = [-a.T @ w @ g @ w @ a for g in parts]
mid = sum(spread[g, h] * (a.T @ w @ parts[g] @ w @ parts[h] @ w @ a - px[g] @ c @ px[h]) for g in range(4) for h in range(4))
correction = 2 * c @ mid @ c
x = c @ a.T @ w @ y
dof = []
for j in range(3):
    gradient = np.array([-(c @ px_ @ c)[j, j] * -1 for px_ in px]) * -1
    dof.append(2 * c[j, j] ** 2 / (gradient @ spread @ gradient))
estimated = dict(a=a.tolist(), y=y.tolist(), group=group.tolist(), level=lev.tolist(), by=by.tolist(), other=other.tolist(),
                 theta=theta.tolist(), spread=spread.tolist(), solution=x.tolist(), covariance=c.tolist(), correction=correction.tolist(),
                 dof=dof)

# item 11: offsets of five positions, exact
exact = []
for scale in ["1", "1e3", "1e7", "1e9", "1e12"]:
    sd = Fraction(scale)
    x_ = [Fraction(k % 7) + Fraction(k, 16) for k in range(15)]
    yv = [2 + Fraction(3, 2) * x_[k] + Fraction((k * 37) % 11 - 5, 8) + (k // 3) ** 2 for k in range(15)]
    # V^-1 of a block of three: I - s^2/(1 + 3 s^2) 11'
    def winner(p_, q_):
        total = Fraction(0)
        for b in range(5):
            rows = range(3 * b, 3 * b + 3)
            total += sum(p_[i] * q_[i] for i in rows) - sd**2 / (1 + 3 * sd**2) * sum(p_[i] for i in rows) * sum(q_[i] for i in rows)
        return total
    one = [Fraction(1)] * 15
    n11, n12, n22 = winner(one, one), winner(one, x_), winner(x_, x_)
    b1, b2 = winner(one, yv), winner(x_, yv)
    det = n11 * n22 - n12 * n12
    s0, s1 = (n22 * b1 - n12 * b2) / det, (n11 * b2 - n12 * b1) / det
    rest = [yv[k] - s0 - s1 * x_[k] for k in range(15)]
    exact.append(dict(sd=scale, x=[float(v_) for v_ in x_], y=[float(v_) for v_ in yv], b0=float(s0), b1=float(s1),
                      u0=float(n22 / det) ** 0.5, u1=float(n11 / det) ** 0.5, chi_square=float(winner(rest, rest))))

json.dump(dict(cases=cases, estimated=estimated, exact=exact), open("tests/data/scatter/dense.json", "w"))
print(theta, dof, [e["chi_square"] for e in exact])
