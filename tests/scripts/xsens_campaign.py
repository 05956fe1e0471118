"""Xsens static positions (imu_tk's data) as a model line nonlinear in nine coefficients: tests/data/xsens/.

Model of Tedaldi et al. 2014: the norm of the corrected specific force is 9.81744 m/s^2 in all 38 positions,
    d_i = s_i (a_i - b_i),  x = dx - mis_yz*dy + mis_zy*dz,  y = dy - mis_zx*dz,  z = dz,  reading = sqrt(x^2 + y^2 + z^2);
the "reading" is the constant, and ax, ay, az (raw counts, means of the static intervals) are columns.
Method: Gauss-Newton in mpmath with 40 digits, derivatives by central differences with step 1e-13 of each value, from the
starts in the campaign; scipy.optimize.least_squares (Levenberg-Marquardt in doubles) must agree to 1e-6 of each u.
u from s^2 (J'J)^-1, s = sqrt(vv/29). Compared with the fit in tests/data/reference (same model, another program).
"gauss_newton_steps": undamped steps from the starts until every step is below about 5e-6 of its u.
Run: python3 tests/scripts/xsens_campaign.py
"""
import mpmath
import numpy as np
from mpmath import mpf
from scipy.optimize import least_squares

from common import read, write

mpmath.mp.dps = 40
G = 9.81744
NAMES = ["mis_yz", "mis_zy", "mis_zx", "s_x", "s_y", "s_z", "b_x", "b_y", "b_z"]
STARTS = [0, 0, 0, 0.0024, 0.0024, 0.0024, 33000, 33000, 32500]
MODEL = ("sqrt((s_x*(ax - b_x) - mis_yz*s_y*(ay - b_y) + mis_zy*s_z*(az - b_z))^2"
         " + (s_y*(ay - b_y) - mis_zx*s_z*(az - b_z))^2 + (s_z*(az - b_z))^2)")


def predicted(c, a, sqrt=mpmath.sqrt):
    mis_yz, mis_zy, mis_zx, s_x, s_y, s_z, b_x, b_y, b_z = c
    dx, dy, dz = s_x * (a[0] - b_x), s_y * (a[1] - b_y), s_z * (a[2] - b_z)
    return sqrt((dx - mis_yz * dy + mis_zy * dz) ** 2 + (dy - mis_zx * dz) ** 2 + dz**2)


def linearised(c, counts):
    rows = []
    for a in counts:
        row = []
        for j in range(9):
            h = mpf("1e-13") * max(abs(c[j]), mpf("1e-3"))
            row.append((predicted(c[:j] + [c[j] + h] + c[j + 1:], a) - predicted(c[:j] + [c[j] - h] + c[j + 1:], a)) / (2 * h))
        rows.append(row)
    return mpmath.matrix(rows), mpmath.matrix([mpf(G) - predicted(c, a) for a in counts])


if __name__ == "__main__":
    data = read("reference/xsens_static_positions.json")
    counts = [p["acc_mean"] for p in data["positions"]]
    c, steps = [mpf(v) for v in STARTS], 0
    for step in range(1, 30):
        J, v = linearised(c, [[mpf(t) for t in a] for a in counts])
        cofactor = (J.T * J) ** -1
        x = cofactor * (J.T * v)
        sizes = [x[j] / mpmath.sqrt(cofactor[j, j]) for j in range(9)]
        c = [c[j] + x[j] for j in range(9)]
        if not steps and max(abs(t) for t in sizes) < mpf("1e-6") * mpmath.norm(v):
            steps = step
        if max(abs(t) for t in sizes) < mpf("1e-28"):
            break
    J, v = linearised(c, [[mpf(t) for t in a] for a in counts])
    cofactor = (J.T * J) ** -1
    m, dof = len(counts), len(counts) - 9
    s = mpmath.norm(v) / mpmath.sqrt(dof)
    u = [float(s * mpmath.sqrt(cofactor[j, j])) for j in range(9)]
    leverage = [float((J[i, :] * cofactor * J[i, :].T)[0]) for i in range(m)]
    peer = least_squares(lambda t: [G - predicted(t, a, np.sqrt) for a in counts], STARTS, method="lm",
                         x_scale=[1e-3] * 3 + [1e-6] * 3 + [1] * 3, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    apart = max(abs(p - float(t)) / d for p, t, d in zip(peer.x, c, u))
    own = data["own_reference_fit"]
    print("scipy differs by", apart, "u; reference fit by", max(abs(p - float(t)) / d for p, t, d in zip(own["value"], c, u)),
          "u; its u by", max(abs(p / d - 1) for p, d in zip(own["std_error"], u)), "s", float(s), own["s"], "steps", steps)
    assert apart < 1e-6
    bench = {"id": "xsens-static", "title": "Triaxial accelerometer in 38 static positions, norm of the specific force",
             "source": "data: Kyle-ak/imu_tk; model: Tedaldi, Pretto, Menegatti, ICRA 2014", "chain": [],
             "sensors": {"norm": {"unit": "m/s^2", "model": MODEL}}}
    readings = [{"position": str(i + 1), "ax": a[0], "ay": a[1], "az": a[2], "norm": G} for i, a in enumerate(counts)]
    write("xsens/static-positions.campaign.json", {
        "bench": bench, "estimate": {n: {"start": t} for n, t in zip(NAMES, STARTS)}, "readings": readings})
    write("xsens/static-positions.expected.json", {
        "source": data["source"],
        "parameters": {n: {"value": float(t), "exact": mpmath.nstr(t, 25), "u": d} for n, t, d in zip(NAMES, c, u)},
        "variance": "estimated", "residual_sd": float(s), "sum_of_squares": float(s**2 * dof), "dof": dof,
        "covariance": {"order": NAMES, "matrix": [[float(s**2 * cofactor[i, j]) for j in range(9)] for i in range(9)]},
        "residuals": [float(t) for t in v], "leverages": leverage, "redundancy": [1 - h for h in leverage],
        "gauss_newton_steps": steps, "reference_fit": own})
