"""Examples 22 to 25 and the numbers that the tests expect of them, by rows written out by hand and numpy alone.

Writes readings (CSV) into the examples and tests/data/ready/expected.json. Noise is seeded; the truth stands in this file.
"""
import csv
import json
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
RNG = np.random.default_rng(17)
EARTH = 15.041067 / 3600.0  # deg/s
UP = EARTH * np.sin(np.radians(45.75))
ARCSEC = 648000 / np.pi


def least_squares(a, y):
    x, *_ = np.linalg.lstsq(a, y, rcond=None)
    v = y - a @ x
    s2 = v @ v / (len(y) - a.shape[1])
    return x, s2 * np.linalg.inv(a.T @ a)


def write(folder, header, rows):
    with open(ROOT / "examples" / folder / "readings.csv", "w", newline="") as f:
        out = csv.writer(f, lineterminator="\n")
        out.writerow(header)
        out.writerows(rows)


def quotient(x, c, i, j, factor):
    """Value and u of factor x_i/x_j."""
    g = np.zeros(len(x))
    g[i], g[j] = factor / x[j], -factor * x[i] / x[j] ** 2
    return [factor * x[i] / x[j], float(np.sqrt(g @ c @ g))]


def six_positions():
    # pitch about y, then roll about x: a = (-sin p, cos p sin r, cos p cos r)
    positions = [("z up", 0, 0), ("z down", 0, 180), ("y up", 0, 90), ("y down", 0, 270), ("x up", 270, 0), ("x down", 90, 0)]
    truth = {"ax": [41.0, 16384 * 1.0021, 16384 * 0.0031, -16384 * 0.0012], "ay": [-27.5, 16384 * 0.9987, -16384 * 0.0022, 16384 * 0.0008],
             "az": [63.2, 16384 * 1.0040, 16384 * 0.0015, 16384 * 0.0027]}
    others = {"ax": [0, 1, 2], "ay": [1, 0, 2], "az": [2, 0, 1]}
    rows, force = [], []
    for _ in range(3):
        for name, p, r in positions:
            pr, rr = np.radians(p), np.radians(r)
            a = np.round([-np.sin(pr), np.cos(pr) * np.sin(rr), np.cos(pr) * np.cos(rr)])
            force.append(a)
            values = [round(float(t[0] + np.dot(t[1:], a[others[s]]) + 0.6 * RNG.standard_normal()), 2) for s, t in truth.items()]
            rows.append([name, p, r, *values])
    write("22-six-positions", ["position", "pitch_deg", "roll_deg", "ax", "ay", "az"], rows)
    force = np.array(force)
    expected = {}
    names = {"ax": ["bx", "Kx", "Kxy", "Kxz"], "ay": ["by", "Ky", "Kyx", "Kyz"], "az": ["bz", "Kz", "Kzx", "Kzy"]}
    solved = {}
    for k, sensor in enumerate(truth):
        a = np.column_stack([np.ones(len(rows)), force[:, others[sensor]]])
        x, c = least_squares(a, np.array([row[3 + k] for row in rows]))
        for i, name in enumerate(names[sensor]):
            expected[name] = [x[i], float(np.sqrt(c[i, i]))]
        axis = sensor[1]
        expected[f"bias_{axis}"] = quotient(x, c, 0, 1, 1e6)
        for i in (2, 3):
            expected[f"misalignment_{names[sensor][i][1:]}"] = quotient(x, c, i, 1, ARCSEC)
        # the two components in the order of a right-handed turn about the axis, from the next axis towards the one after it
        first, second = {"x": (2, 3), "y": (3, 2), "z": (2, 3)}[axis]
        g, h = x[first] / x[1], x[second] / x[1]
        size = np.hypot(g, h)
        d = np.zeros((2, len(x)))  # of g and h by the parameters
        d[0, first], d[0, 1], d[1, second], d[1, 1] = 1 / x[1], -g / x[1], 1 / x[1], -h / x[1]
        along, across = np.array([g, h]) / size @ d, np.array([-h, g]) / size**2 @ d
        expected[f"misalignment_{axis}"] = [float(size * 1e6), float(np.sqrt(along @ c @ along) * 1e6)]
        expected[f"azimuth_{axis}"] = [float(np.degrees(np.arctan2(h, g))), float(np.degrees(np.sqrt(across @ c @ across)))]
        direction = np.zeros(3)
        direction[others[sensor]] = x[1:]
        solved[axis] = direction / np.linalg.norm(direction)
    for i, j in ("xy", "xz", "yz"):
        expected[f"nonorthogonality_{i}{j}"] = [float(np.arcsin(solved[i] @ solved[j]) * ARCSEC), None]
    return expected


def rate_steps():
    rates = [1, 2, 5, 10, 20, 50, 100, 150, 200]
    rows = []
    for rate in rates:
        for sense in (1, -1):
            w = sense * rate + UP
            v = 0.00213 + 0.0200412 * w + 3.1e-7 * abs(w) + 1.4e-9 * w**2
            rows.append([sense * rate, round(float(v + 2e-6 * RNG.standard_normal()), 7)])
    write("23-rate-steps", ["gamma_deg_s", "V"], rows)
    w = np.array([row[0] for row in rows]) + UP
    x, c = least_squares(np.column_stack([np.ones_like(w), w, abs(w), w**2]), np.array([row[1] for row in rows]))
    expected = {name: [x[i], float(np.sqrt(c[i, i]))] for i, name in enumerate(["V0", "K", "A", "K2"])}
    expected["bias"] = quotient(x, c, 0, 1, 3600.0)
    expected["asymmetry"] = quotient(x, c, 2, 1, 2e6)
    expected["scale_factor_error"] = [(x[1] / 0.02 - 1) * 1e6, float(np.sqrt(c[1, 1])) / 0.02 * 1e6]
    return expected


def temperature():
    rows = []
    for t in (-40, -20, 0, 25, 40, 60, 80):
        for rate in (0, 50, -50, 100, -100):
            actual = round(t + 0.1 * float(RNG.standard_normal()), 2)
            w, d = rate + UP, actual - 25
            v = 0.0021 + 4.0e-6 * d + 2.0e-8 * d**2 + (0.0200412 - 9.0e-7 * d) * w
            rows.append([actual, rate, "" if rate else 0, round(float(v + 5e-6 * RNG.standard_normal()), 7)])
    write("24-temperature", ["temperature_c", "gamma_deg_s", "gamma_deg", "V"], rows)
    d = np.array([row[0] for row in rows]) - 25
    w = np.array([row[1] for row in rows]) + UP
    x, c = least_squares(np.column_stack([np.ones_like(w), d, d**2, w, d * w]), np.array([row[3] for row in rows]))
    expected = {name: [x[i], float(np.sqrt(c[i, i]))] for i, name in enumerate(["V0", "V1", "V2", "K", "K1"])}
    expected["bias"] = quotient(x, c, 0, 3, 3600.0)
    expected["bias_temperature"] = quotient(x, c, 1, 3, 3600.0)
    expected["scale_factor_temperature"] = quotient(x, c, 4, 3, 1e6)
    return expected


def turn_on():
    k = 0.0200412 / 3600.0  # V/(deg/h)
    rows = []
    for turn in range(1, 11):
        bias = 12.0 + 0.8 * RNG.standard_normal()
        for minute in range(4):
            v = k * (UP * 3600.0 + bias + 0.15 * RNG.standard_normal())
            rows.append([turn, minute, 0, round(float(v), 9)])
    write("25-turn-on", ["turn_on", "minute", "gamma_deg", "V"], rows)
    y = np.array([row[3] for row in rows]).reshape(10, 4) / k - UP * 3600.0  # deg/h
    means = y.mean(axis=1)
    within = ((y - means[:, None]) ** 2).sum() / 30
    between = 4 * means.var(ddof=1)
    # balanced: the analysis of variance is REML; the mean has nine degrees of freedom
    return {"B": [float(means.mean()), float(np.sqrt(between / 40))], "repeatability": [float(np.sqrt((between - within) / 4)), None],
            "dof": [9.0, None]}


def triad_norm():
    """A triad at rest in 40 attitudes: raw means, and the fit of the norm of gravity by Gauss-Newton with numerical derivatives."""
    rng = np.random.default_rng(26)
    g = 9.80665
    truth = {"s_x": 2.41e-4, "s_y": 2.39e-4, "s_z": 2.43e-4, "b_x": 32900.0, "b_y": 33100.0, "b_z": 32650.0, "mis_yz": 2.1e-3, "mis_zy": -3.4e-3, "mis_zx": 1.3e-3}
    names = list(truth)

    def turned(p):  # raw to the orthogonal frame, equation (5) of the source
        return np.array([[1, -p[6], p[7]], [0, 1, -p[8]], [0, 0, 1]]) * p[:3]

    p = np.array([truth[name] for name in names])
    forces = rng.standard_normal((40, 3))
    forces *= g / np.linalg.norm(forces, axis=1)[:, None]
    raw = np.round(forces @ np.linalg.inv(turned(p)).T + p[3:6] + 1.5 * rng.standard_normal((40, 3)), 2)

    def norm(p):
        return np.linalg.norm((raw - p[3:6]) @ turned(p).T, axis=1)

    def jacobian(f, p):
        steps = np.array([1e-9, 1e-9, 1e-9, 1e-2, 1e-2, 1e-2, 1e-5, 1e-5, 1e-5])
        columns = []
        for k, h in enumerate(steps):
            e = np.zeros(9)
            e[k] = h
            columns.append((8 * (np.asarray(f(p + e)) - f(p - e)) - (np.asarray(f(p + 2 * e)) - f(p - 2 * e))) / (12 * h))
        return np.array(columns).T

    for _ in range(20):
        a = jacobian(norm, p)
        p = p + np.linalg.lstsq(a / np.linalg.norm(a, axis=0), g - norm(p), rcond=None)[0] / np.linalg.norm(a, axis=0)
    v = g - norm(p)
    scale = np.linalg.norm(jacobian(norm, p), axis=0)
    a = jacobian(norm, p) / scale
    c = v @ v / (len(v) - 9) * np.linalg.inv(a.T @ a) / np.outer(scale, scale)

    def axes(p):  # input axes: rows of the inverse of the matrix that turns what they read into the frame
        t = turned(p) / p[:3]
        return np.linalg.inv(t)

    def lines(p):
        rows = axes(p)
        rows = rows / np.linalg.norm(rows, axis=1)[:, None]
        x = axes(p)[0]
        return np.array([np.hypot(x[1], x[2]) * 1e6, np.degrees(np.arctan2(x[2], x[1])), *(np.arcsin(rows[i] @ rows[j]) * ARCSEC for i, j in ((0, 1), (0, 2), (1, 2)))])

    d = jacobian(lines, p)
    u = np.sqrt(np.diag(d @ c @ d.T))
    expected = {name: [float(p[k]), float(np.sqrt(c[k, k]))] for k, name in enumerate(names[:6])}
    expected |= {name: [float(value), float(own)] for name, value, own in zip(["misalignment_x", "azimuth_x", "nonorthogonality_xy", "nonorthogonality_xz", "nonorthogonality_yz"], lines(p), u)}
    start = {"s_x": 2.4e-4, "s_y": 2.4e-4, "s_z": 2.4e-4, "b_x": 32768, "b_y": 32768, "b_z": 32768, "mis_yz": 0, "mis_zy": 0, "mis_zx": 0}
    campaign = {"bench": "accelerometer-triad-norm", "estimate": {name: {"start": value} for name, value in start.items()},
                "readings": [{"ax": float(r[0]), "ay": float(r[1]), "az": float(r[2]), "norm": g} for r in raw]}
    (ROOT / "tests/data/ready/triad-norm.campaign.json").write_text(json.dumps(campaign, indent=1) + "\n")
    return expected


found = {"triad-norm": triad_norm(), "22-six-positions": six_positions(), "23-rate-steps": rate_steps(), "24-temperature": temperature(), "25-turn-on": turn_on()}
(ROOT / "tests/data/ready").mkdir(exist_ok=True)
(ROOT / "tests/data/ready/expected.json").write_text(json.dumps(found, indent=1) + "\n")
