"""Records of samples with correlated noise, solved with the whole covariance matrix at hand (numpy, scipy).

Writes tests/data/streamed/: three records, their campaigns, and what dense generalised least squares and restricted maximum likelihood say.

    python3 tests/scripts/streamed_dense.py
"""

import json
from pathlib import Path

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

HERE = Path(__file__).resolve().parent.parent / "data" / "streamed"
HERE.mkdir(parents=True, exist_ok=True)


def ou(rng, t, sd, tau):
    d = np.empty(len(t))
    d[0] = sd * rng.standard_normal()
    for i in range(1, len(t)):
        f = np.exp(-(t[i] - t[i - 1]) / tau)
        d[i] = f * d[i - 1] + sd * np.sqrt(1 - f * f) * rng.standard_normal()
    return d


def covariance(t, white, sd, tau):
    return np.diag(white**2) + sd**2 * np.exp(-np.abs(t[:, None] - t[None, :]) / tau)


def gls(a, y, v):
    c = cho_factor(v)
    q = np.linalg.inv(a.T @ cho_solve(c, a))
    x = q @ (a.T @ cho_solve(c, y))
    r = y - a @ x
    logdet = 2 * np.log(np.diag(c[0])).sum() + np.linalg.slogdet(a.T @ cho_solve(c, a))[1]
    return x, q, r @ cho_solve(c, r), logdet


def table(name, columns):
    keys = list(columns)
    lines = [",".join(keys)]
    for row in zip(*columns.values()):
        lines.append(",".join(repr(float(x)) for x in row))
    (HERE / name).write_text("\n".join(lines) + "\n")


def write(name, value):
    (HERE / name).write_text(json.dumps(value, indent=1) + "\n")


def sweep(rng, n):
    t = np.cumsum(rng.uniform(0.05, 1.5, n))
    temperature = 20 + 30 * np.sin(t / 40) + 0.05 * t
    return t, temperature


BENCH = {"id": "sweep", "sensors": {"V": {"unit": "V", "model": "V0 + b*temperature_c + c*temperature_c^2"}}}


def stated():
    """Everything stated, the white noise another in each row."""
    rng = np.random.default_rng(20261122)
    t, temperature = sweep(rng, 700)
    u = rng.uniform(0.01, 0.04, len(t))
    sd, tau = 0.03, 7.0
    y = 1.5 - 0.02 * temperature + 1e-4 * temperature**2 + ou(rng, t, sd, tau) + u * rng.standard_normal(len(t))
    table("stated.csv", {"time_s": t, "temperature_c": temperature, "V": y, "V_u": u})
    a = np.column_stack([np.ones_like(t), temperature, temperature**2])
    x, q, chi, _ = gls(a, y, covariance(t, u, sd, tau))
    campaign = {
        "bench": BENCH,
        "estimate": {"V0": {}, "b": {}, "c": {}},
        "scatter": [{"of": "V", "over": "time_s", "tau": tau, "u": sd}],
        "readings": {"samples": "stated.csv", "as": "rows"},
    }
    write("stated.campaign.json", campaign)
    return {"x": x.tolist(), "covariance": q.tolist(), "chi_square": chi}


def estimated():
    """White noise, deviation and correlation time by restricted maximum likelihood."""
    rng = np.random.default_rng(7)
    t, temperature = sweep(rng, 900)
    y = 1.5 - 0.02 * temperature + 1e-4 * temperature**2 + ou(rng, t, 0.03, 7.0) + 0.02 * rng.standard_normal(len(t))
    table("estimated.csv", {"time_s": t, "temperature_c": temperature, "V": y})
    a = np.column_stack([np.ones_like(t), temperature, temperature**2])

    def deviance(p):
        _, _, chi, logdet = gls(a, y, covariance(t, np.full_like(t, np.exp(p[0])), np.exp(p[1]), np.exp(p[2])))
        return chi + logdet

    best = minimize(deviance, np.log([0.02, 0.03, 7.0]), method="Nelder-Mead",
                    options={"xatol": 1e-9, "fatol": 1e-11, "maxiter": 4000})
    p = best.x
    # second derivatives of the deviance, for the standard uncertainties of the logarithms
    h = 0.01
    e = np.eye(3) * h
    second = np.array([[(deviance(p + e[i] + e[j]) - deviance(p + e[i] - e[j]) - deviance(p - e[i] + e[j])
                         + deviance(p - e[i] - e[j])) / (4 * h * h) for j in range(3)] for i in range(3)])
    logarithms = 2 * np.linalg.inv(second)
    x, q, chi, _ = gls(a, y, covariance(t, np.full_like(t, np.exp(p[0])), np.exp(p[1]), np.exp(p[2])))
    # Satterthwaite: variance of each parameter's variance through the noise
    slope = []
    for k in range(3):
        more, less = p + e[k] * 0.1, p - e[k] * 0.1
        of = lambda p: np.diag(gls(a, y, covariance(t, np.full_like(t, np.exp(p[0])), np.exp(p[1]), np.exp(p[2])))[1])
        slope.append((of(more) - of(less)) / (0.2 * h))
    slope = np.array(slope)
    dof = [2 * q[j, j] ** 2 / (slope[:, j] @ logarithms @ slope[:, j]) for j in range(3)]
    # Kenward and Roger's addition (1997) in its form sum W_kh (Phi R_kh Phi / 2 - Phi_kh), by white variance, variance of the deviation and correlation
    # time; the term of R is left out for the correlation time twice, in which the slow part of V is linear
    w, d, tau = np.exp(2 * p[0]), np.exp(2 * p[1]), np.exp(p[2])
    gap = np.abs(t[:, None] - t[None, :])
    shape = np.exp(-gap / tau)
    slopes = [np.eye(len(t)), shape, d * shape * gap / tau**2]
    jacobian = np.diag([2 * w, 2 * d, tau])
    weight = jacobian @ logarithms @ jacobian
    inverse = np.linalg.inv(w * np.eye(len(t)) + d * shape)
    m = inverse @ a
    both = m.T @ (shape * gap / tau**2) @ m
    twice = m.T @ (d * shape * (gap**2 / tau**4 - 2 * gap / tau**3)) @ m
    middle = np.zeros((3, 3))
    for k in range(3):
        for l in range(3):
            own = m.T @ slopes[k] @ inverse @ slopes[l] @ m - (m.T @ slopes[k] @ m) @ q @ (m.T @ slopes[l] @ m)
            if {k, l} == {1, 2}:
                own = own - both / 4
            if k == l == 2:
                own = own - twice / 2
            middle += weight[k, l] * own
    # what would make u smaller is not taken
    added = np.maximum(np.diag(2 * q @ middle @ q), 0)
    campaign = {
        "bench": BENCH,
        "estimate": {"V0": {}, "b": {}, "c": {}},
        "scatter": [{"of": "V", "over": "time_s", "tau": "estimate", "u": "estimate"}],
        "readings": {"samples": "estimated.csv", "as": "rows"},
    }
    write("estimated.campaign.json", campaign)
    return {"x": x.tolist(), "u": np.sqrt(np.diag(q) + added).tolist(), "white": np.exp(p[0]), "deviation": np.exp(p[1]),
            "tau": np.exp(p[2]), "u_tau": np.exp(p[2]) * np.sqrt(logarithms[2, 2]), "dof": dof,
            "deviance": deviance(p)}


def rotating():
    """Two sensors on a turning table, nonlinear, with a known input that is uncertain and a prior; sensors of different noise."""
    rng = np.random.default_rng(31)
    n = 600
    t = np.arange(n) * 0.1
    angle = 360 * np.cumsum(0.02 + 0.015 * np.sin(t / 9)) * 0.1
    theta = np.radians(angle)
    k, phi, offset, g = 2.0, 0.2, 0.05, 1.0
    model = lambda p: np.concatenate([p[0] * g * np.cos(theta + p[1]) + p[2], p[0] * g * np.sin(theta + p[1])])
    noise = [(0.004, 0.006, 3.0), (0.010, 0.0, 1.0)]
    y = model([k, phi, offset])
    y[:n] += ou(rng, t, noise[0][1], noise[0][2]) + noise[0][0] * rng.standard_normal(n)
    y[n:] += noise[1][0] * rng.standard_normal(n)
    table("rotating.csv", {"time_s": t, "alpha_deg": angle, "X": y[:n], "Y": y[n:]})
    v = np.zeros((2 * n + 1, 2 * n + 1))
    v[:n, :n] = covariance(t, np.full(n, noise[0][0]), *noise[0][1:])
    v[n:-1, n:-1] = covariance(t, np.full(n, noise[1][0]), 0.0, 1.0)
    prior, prior_u = 0.0, 0.02
    v[-1, -1] = prior_u**2
    p = np.array([1.5, 0.0, 0.0])
    for _ in range(30):
        c, s = np.cos(theta + p[1]), np.sin(theta + p[1])
        a = np.zeros((2 * n + 1, 3))
        a[:n] = np.column_stack([g * c, -p[0] * g * s, np.ones(n)])
        a[n:-1] = np.column_stack([g * s, p[0] * g * c, np.zeros(n)])
        a[-1, 2] = 1.0
        rest = np.append(y - model(p), prior - p[2])
        x, q, chi, _ = gls(a, rest, v)
        p = p + x
    by_g = np.append(np.concatenate([p[0] * c, p[0] * s]), 0.0)
    u_g = 1e-3
    follow = -q @ (a.T @ cho_solve(cho_factor(v), by_g))
    campaign = {
        "bench": {"id": "table", "chain": [{"joint": "alpha", "about": "z"}],
                  "sensors": {"X": {"unit": "V", "model": "k*g*cos(alpha + phi) + offset"},
                              "Y": {"unit": "V", "model": "k*g*sin(alpha + phi)"}}},
        "known": {"g": {"value": g, "u": u_g}},
        "estimate": {"k": {"start": 1.5}, "phi": {"start": 0}, "offset": {"prior": prior, "prior_u": prior_u}},
        "scatter": [{"of": "X", "over": "time_s", "tau": noise[0][2], "u": noise[0][1]}],
        "readings": {"samples": "rotating.csv", "as": "rows", "positions": [{"X_u": noise[0][0], "Y_u": noise[1][0]}]},
    }
    write("rotating.campaign.json", campaign)
    return {"x": p.tolist(), "covariance": (q + np.outer(follow, follow) * u_g**2).tolist(), "chi_square": chi}


write("dense.json", {"stated": stated(), "estimated": estimated(), "rotating": rotating()})
