"""Least squares of the published tables of Li, Ren, Zhao 2012: tests/data/li2012/fits.json.

Method: the algebraic rows of li2012_rows.py's docstring (not its code), unknowns V0 and the tilts at reference zero, all
readings weighted alike, standard deviation estimated from the residuals. Solved twice: numpy (Householder QR in doubles,
columns scaled) and mpmath (normal equations with 40 digits from the decimal figures as printed); the written numbers are mpmath's, and
the script fails if numpy differs by more than 1e-12 relative. Covariance s^2 (A'A)^-1, leverages diag A (A'A)^-1 A',
studentized residual v / (s*sqrt(1 - leverage)). condition: 2-norm condition of the unit-norm columns, from numpy.
gamma = sqrt(dtheta_y2^2 + dtheta_z2^2), u by linear propagation of the whole covariance.

  table1          all 30 readings at once and each rate alone, with the Earth rate (rows times q + W sin(latitude)) and without
  table2          all 12 readings at once and each run alone (the Earth rate does not enter)
  closed_forms    the paper's formulas per rate and run, Earth rate 0, exact decimal arithmetic; with least_squares_difference,
                  the largest |closed form - least squares without Earth rate| / |closed form| over the angles
Angles in rad and arcsec; everything in volts.
Run: python3 tests/scripts/li2012_fits.py
"""
import json
from decimal import Decimal

import mpmath
import numpy as np
from mpmath import mpf

from common import DATA, read, write

mpmath.mp.dps = 40
ARCSEC = 180 * 3600 / mpmath.pi
GYRO = ["V0", "dtheta_y0", "dtheta_x0", "dtheta_y1", "dtheta_y2", "dtheta_z2"]
ACC = ["V0", "dtheta_y2", "dtheta_z2"]
SPIN_EARTH = mpf("15.041067") / 3600 * mpmath.sin(mpmath.radians(mpf("45.75")))
K_GYRO, K_ACC = mpf("-2.9222"), mpf("1.299")
COS, SIN = {0: 1, 90: 0, 180: -1, 270: 0}, {0: 0, 90: 1, 180: 0, 270: -1}


def exact(path):
    """The readings as printed: decimal figures, no doubles in between."""
    return json.loads((DATA / path).read_text(), parse_float=lambda t: mpf(t), parse_int=int)["readings"]


def gyro_row(r, earth):
    a, b, q = r["alpha_deg"], r["beta_deg"], K_GYRO * (r["gamma_deg_s"] + (SPIN_EARTH if earth else 0))
    return [mpf(1), -q * COS[b], q * SIN[b], -q, -q * COS[a], q * SIN[a]]


def acc_row(r):
    return [mpf(1), -K_ACC * COS[r["beta_deg"]], K_ACC * SIN[r["beta_deg"]]]


def fit(names, rows, y):
    m, n = len(rows), len(names)
    A, b = mpmath.matrix(rows), mpmath.matrix(y)
    cofactor = (A.T * A) ** -1
    x = cofactor * (A.T * b)
    v = b - A * x
    ssq = mpmath.fsum(v[i] ** 2 for i in range(m))
    dof = m - n
    s = mpmath.sqrt(ssq / dof)
    leverage = [(A[i, :] * cofactor * A[i, :].T)[0] for i in range(m)]
    u = [s * mpmath.sqrt(cofactor[j, j]) for j in range(n)]
    doubles = np.array([[float(c) for c in r] for r in rows])
    scale = np.linalg.norm(doubles, axis=0)
    Q, R = np.linalg.qr(doubles / scale)
    solved = np.linalg.solve(R, Q.T @ np.array([float(t) for t in y])) / scale
    assert max(abs(solved[j] - x[j]) / abs(x[j]) for j in range(n)) < 1e-12
    assert max(abs(np.sum(Q**2, axis=1)[i] - leverage[i]) for i in range(m)) < 1e-14
    parameters = {name: {"value": float(x[j]), "u": float(u[j]), "value_40": mpmath.nstr(x[j], 30)} for j, name in enumerate(names)}
    for j, name in enumerate(names[1:], 1):
        parameters[name].update({"arcsec": float(x[j] * ARCSEC), "u_arcsec": float(u[j] * ARCSEC)})
    j, k = names.index("dtheta_y2"), names.index("dtheta_z2")
    gamma = mpmath.hypot(x[j], x[k])
    c = [x[i] / gamma if i in (j, k) else mpf(0) for i in range(n)]
    u_gamma = s * mpmath.sqrt(mpmath.fsum(c[i] * c[l] * cofactor[i, l] for i in (j, k) for l in (j, k)))
    return {"readings": m, "rank": n, "dof": dof, "residual_sd": float(s), "sum_of_squares": float(ssq),
            "condition": float(f"{np.linalg.cond(doubles / scale):.8g}"), "parameters": parameters,
            "gamma": {"value": float(gamma), "u": float(u_gamma), "arcsec": float(gamma * ARCSEC), "u_arcsec": float(u_gamma * ARCSEC)},
            "covariance": {"order": names, "matrix": [[float(s**2 * cofactor[i, l]) for l in range(n)] for i in range(n)]},
            "residuals": [float(t) for t in v], "leverages": [float(t) for t in leverage],
            "studentized": [float(t / (s * mpmath.sqrt(1 - h))) for t, h in zip(v, leverage)]}


def gyro_closed_form(readings, rate):
    dv = {p: sum((1 if r["gamma_deg_s"] > 0 else -1) * r["V"] for r in readings if r["position"] == p) for p in "12345"}
    k = 4 * K_GYRO * rate
    angles = {"dtheta_y0": (dv["2"] - dv["1"]) / k, "dtheta_x0": (2 * dv["5"] - dv["2"] - dv["1"]) / k,
              "dtheta_y1": (-dv["1"] - dv["3"]) / k, "dtheta_y2": (dv["3"] - dv["2"]) / k,
              "dtheta_z2": (2 * dv["4"] - dv["3"] - dv["2"]) / k}
    return {**angles, "gamma": mpmath.hypot(angles["dtheta_y2"], angles["dtheta_z2"])}


def acc_closed_form(readings):
    v = {r["position"]: r["V"] for r in readings}
    angles = {"dtheta_y2": (v["180"] - v["0"]) / (2 * K_ACC), "dtheta_z2": (v["90"] - v["270"]) / (2 * K_ACC)}
    return {**angles, "gamma": mpmath.hypot(angles["dtheta_y2"], angles["dtheta_z2"])}


def closed(angles, least_squares):
    worst = max(abs(mpf(least_squares["parameters"][n]["value_40"]) / a - 1) for n, a in angles.items() if n != "gamma")
    assert worst < 1e-25, worst
    return {"rad": {n: float(a) for n, a in angles.items()}, "arcsec": {n: float(a * ARCSEC) for n, a in angles.items()},
            "least_squares_difference": float(f"{float(worst):.1e}")}


def misprints(table, forms, printed):
    """Printed per-rate or per-run figures that are not the closed form rounded to their one decimal."""
    out = []
    for key, angles in forms.items():
        for name, shown in printed[table]["per_" + ("rate" if table == "table1" else "run")][key].items():
            if Decimal(f"{angles['arcsec'][name]:.1f}") != Decimal(str(shown)):
                out.append({"table": table, "row": key, "name": name, "printed": shown, "closed_form": angles["arcsec"][name]})
    return out


def means(forms):
    return {n: float(np.mean([f["arcsec"][n] for f in forms.values()])) for n in next(iter(forms.values()))["arcsec"]}


if __name__ == "__main__":
    one, two = exact("li2012/li2012-table1.campaign.json"), exact("li2012/li2012-table2.campaign.json")
    printed = read("li2012/li2012-published.json")
    result = {"source": "Li, Ren, Zhao 2012, Tables 1 and 2; least squares by numpy QR and mpmath, see tests/scripts/li2012_fits.py"}
    for label, earth in (("with_earth_rate", True), ("without_earth_rate", False)):
        of = lambda readings: fit(GYRO, [gyro_row(r, earth) for r in readings], [r["V"] for r in readings])
        result.setdefault("table1", {})[label] = {"all": of(one), "per_rate": {
            str(q): of([r for r in one if abs(r["gamma_deg_s"]) == q]) for q in (20, 30, 40)}}
    of = lambda readings: fit(ACC, [acc_row(r) for r in readings], [r["V"] for r in readings])
    result["table2"] = {"all": of(two), "per_run": {str(k): of([r for r in two if r["run"] == k]) for k in (1, 2, 3)}}
    forms1 = {str(q): closed(gyro_closed_form([r for r in one if abs(r["gamma_deg_s"]) == q], q),
                             result["table1"]["without_earth_rate"]["per_rate"][str(q)]) for q in (20, 30, 40)}
    forms2 = {str(k): closed(acc_closed_form([r for r in two if r["run"] == k]), result["table2"]["per_run"][str(k)]) for k in (1, 2, 3)}
    result["closed_forms"] = {"table1": {"per_rate": forms1, "mean_arcsec": means(forms1)},
                              "table2": {"per_run": forms2, "mean_arcsec": means(forms2)},
                              "differs_from_print": misprints("table1", forms1, printed) + misprints("table2", forms2, printed)}
    write("li2012/fits.json", result)
    for name, f in (("with Earth", result["table1"]["with_earth_rate"]["all"]), ("without", result["table1"]["without_earth_rate"]["all"]),
                    ("table 2", result["table2"]["all"])):
        print(name, f["dof"], "dof, sd", f["residual_sd"], {n: (round(p["arcsec"], 4), round(p["u_arcsec"], 4))
              for n, p in f["parameters"].items() if n != "V0"}, "gamma", f["gamma"]["arcsec"], f["gamma"]["u_arcsec"])
    for d in result["closed_forms"]["differs_from_print"]:
        print("print:", d)
    print("means", means(forms1), means(forms2))
