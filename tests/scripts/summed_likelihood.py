"""Intervals over the whole restricted likelihood of the variances, by dense quadrature in numpy and scipy.

Mountings with unequal numbers of readings, a mean or a line, the scatter of the mountings estimated, drawn so that it is small beside the noise:
`V = s2 (I + psi Z Z')`, psi down to where V is no covariance any more, Jeffreys' prior, s2 integrated out. The centre is the top of the
likelihood; where that rises to the edge of what is a covariance, the estimate with psi = 0. Half widths of the intervals about it. The seeds are such
that the program sums (the top has less than one degree of freedom, or there is none).

Writes tests/data/scatter/summed.json; nothing is shared with the program but the numbers. Run: python3 tests/scripts/summed_likelihood.py
"""
import json
import numpy as np
from scipy import optimize, stats

LEVEL = 0.95


def case(repeats, x, seed):
    rng = np.random.default_rng(seed)
    count = len(repeats)
    z = np.repeat(np.eye(count), repeats, axis=0)
    a = np.ones((sum(repeats), 1)) if x is None else np.c_[np.ones(sum(repeats)), z @ np.asarray(x, float)]
    y = np.round(1.0 + z @ (0.1 * rng.standard_normal(count)) + rng.standard_normal(len(a)), 4)
    m, n = a.shape
    dof, k = m - n, z @ z.T
    edge = -1.0 / max(repeats)

    def at(psi):
        v = np.eye(m) + psi * k
        vi = np.linalg.inv(v)
        phi = np.linalg.inv(a.T @ vi @ a)
        h = phi @ a.T @ vi
        p = vi - vi @ a @ h
        q = y @ p @ y
        pk = p @ k
        log_det = np.linalg.slogdet(v)[1] - np.linalg.slogdet(phi)[1]
        log_l = -0.5 * log_det - 0.5 * dof * np.log(q)
        jeffreys = 0.5 * np.log(np.trace(pk @ pk) - np.trace(pk) ** 2 / dof)
        return log_l, jeffreys, h @ y, np.sqrt(np.diag(phi) * q / dof)

    u = np.linspace(np.log(1e-5 * -edge), np.log(1e9 * -edge), 6001)
    nodes = [at(np.exp(u_) + edge) for u_ in u]
    log_l = np.array([own[0] for own in nodes])
    top = int(np.argmax(log_l))
    if top == 0:
        centre = at(0.0)[2]
    else:
        found = optimize.minimize_scalar(lambda s: -at(np.exp(s) + edge)[0], bounds=(u[top - 1], u[min(top + 1, 6000)]), method="bounded", options={"xatol": 1e-12})
        centre = at(np.exp(found.x) + edge)[2]
    weight = log_l + np.array([own[1] for own in nodes]) + u
    weight = np.exp(weight - weight.max())
    weight /= weight.sum()
    half = []
    for j in range(n):
        shift = np.array([own[2][j] for own in nodes]) - centre[j]
        scale = np.array([own[3][j] for own in nodes])
        outside = lambda b: weight @ (stats.t.sf((b - shift) / scale, dof) + stats.t.sf((b + shift) / scale, dof)) - (1 - LEVEL)
        half.append(optimize.brentq(outside, 0.0, 1e6, xtol=1e-13))
    position = np.repeat(np.arange(count), repeats)
    readings = [{"position": f"p{i}", **({} if x is None else {"x": x[i]}), "V": v} for i, v in zip(position, y.tolist())]
    return {"repeats": repeats, "open": top == 0, "estimate": centre.tolist(), "U": half, "readings": readings}


LINE = [0, 1, 2, 4]
cases = [
    *(case([8, 2, 2, 1], None, seed) for seed in (3, 4)),
    *(case([12, 1, 1], None, seed) for seed in (1, 6)),
    *(case([6, 1, 1, 1, 1], None, seed) for seed in (5, 13)),
    *(case([1, 2, 3, 4, 10], None, seed) for seed in (1, 11)),
    *(case([10, 1, 2, 8], LINE, seed) for seed in (1, 5)),
    case([4, 4, 1, 3, 1, 2, 12], [0, 3, 1, 4, 2, 0, 1], 13),
]
with open("tests/data/scatter/summed.json", "w") as file:
    file.write("[\n" + ",\n".join(json.dumps(own) for own in cases) + "\n]\n")
