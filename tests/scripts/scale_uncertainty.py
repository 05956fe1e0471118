"""A line through readings of three instruments of unknown scatter and two readings of known u: REML, Kenward and Roger, in numpy.

Whole matrices and formulas of the paper (Biometrics 53 (1997), equations 2 to 5, V linear in its variances); nothing is shared with the
program's way by thin Q and gram matrices. Writes tests/data/systems/scale_uncertainty.json. Run: python3 tests/scripts/scale_uncertainty.py
"""
import numpy as np

from common import write

random = np.random.default_rng(1997)
group = np.array([0] * 5 + [1] * 6 + [2] * 4 + [3] * 2)  # 3: u is known
x = np.round(random.uniform(-2, 3, len(group)), 3)
u = np.where(group == 3, 0.4, np.round(random.uniform(0.5, 2, len(group)), 2))
sd = np.array([0.3, 1.0, 0.5, 1.0])[group] * u
y = np.round(1.2 + 0.7 * x + sd * random.standard_normal(len(x)), 4)
a = np.column_stack([np.ones_like(x), x])
parts = [np.diag(np.where(group == g, u ** 2, 0.0)) for g in range(4)]


def reml(theta):
    v = sum(t * p for t, p in zip([*theta, 1.0], parts))
    w = np.linalg.inv(v)
    phi = np.linalg.inv(a.T @ w @ a)
    p = w - w @ a @ phi @ a.T @ w
    score = np.array([0.5 * (y @ p @ parts[g] @ p @ y - np.trace(p @ parts[g])) for g in range(3)])
    information = np.array([[0.5 * np.trace(p @ parts[g] @ p @ parts[h]) for h in range(3)] for g in range(3)])
    return w, phi, score, information


theta = np.array([0.1, 1.0, 0.3])
for _ in range(500):
    w, phi, score, information = reml(theta)
    step = np.linalg.solve(information, score)
    while np.any(theta + step <= 0):
        step /= 2
    theta = theta + step
w, phi, score, information = reml(theta)
assert np.max(np.abs(score) * theta) < 1e-10
spread = np.linalg.inv(information)
first = [-a.T @ w @ parts[g] @ w @ a for g in range(3)]
inner = sum(spread[g, h] * (a.T @ w @ parts[g] @ w @ parts[h] @ w @ a - first[g] @ phi @ first[h]) for g in range(3) for h in range(3))
correction = 2 * phi @ inner @ phi
write("systems/scale_uncertainty.json", {
    "x": x.tolist(), "y": y.tolist(), "u": u.tolist(), "group": group.tolist(),
    "solution": (phi @ a.T @ w @ y).tolist(), "scale": np.sqrt(theta).tolist(), "covariance": phi.tolist(),
    "relative_spread": (spread / np.outer(theta, theta)).tolist(), "correction": correction.tolist()})
