"""Published data sets as campaigns without a chain, each with NAME.expected.json beside it.

Method: weighted least squares in exact rational arithmetic (python's Fraction, normal equations, Gauss elimination) from the
decimal figures of tests/data/reference/*.json, square roots by mpmath with 40 digits. What is published stands beside as
quoted there. Keys of an expected file:
    parameters { name: { value, exact (30 digits), u, certified? } },  covariance { order, matrix },
    residual_sd (sqrt(vv/dof), weighted where u is stated),  sum_of_squares (weighted likewise),  dof,
    variance  "estimated": u and covariance carry residual_sd^2;  "stated": they come from the readings' u alone,
    residuals (reading minus fitted), leverages, redundancy (readings in file order),  published (as quoted)
    NIST only: required_digits (what the program must reach), numpy_digits (pivoted QR of unit-norm columns, in doubles),
    rounded_rows_digits (an exact solution, but of rows rounded to doubles: no solver can promise more); digits = the least over the parameters of -log10 |found - exact| / |exact|.
The reference figures come from open repositories named in the "source" of tests/data/reference/*.json.
Run: python3 tests/scripts/reference_campaigns.py
"""
from fractions import Fraction

import mpmath
import numpy as np
import scipy.linalg

from common import read, write

mpmath.mp.dps = 40
REQUIRED = {"longley": 10, "wampler1": 8.5, "wampler2": 11, "wampler3": 8.5, "wampler4": 7.5, "wampler5": 5.5, "filip": 7.5,
            "pontius": 11, "norris": 11, "noint1": 13, "noint2": 13}


def real(q):
    return mpmath.mpf(q.numerator) / q.denominator


def inverse(matrix):
    n = len(matrix)
    work = [row[:] + [Fraction(int(i == j)) for j in range(n)] for i, row in enumerate(matrix)]
    for k in range(n):
        pivot = next(i for i in range(k, n) if work[i][k] != 0)
        work[k], work[pivot] = work[pivot], work[k]
        work[k] = [v / work[k][k] for v in work[k]]
        for i in range(n):
            if i != k and work[i][k] != 0:
                factor = work[i][k]
                work[i] = [v - factor * w for v, w in zip(work[i], work[k])]
    return [row[n:] for row in work]


def solve(names, rows, y, variances=None):
    """Exact weighted least squares; `variances` are u^2 as Fractions, or None."""
    weights = [1 / v for v in variances] if variances else [Fraction(1)] * len(y)
    n, m = len(names), len(y)
    normal = [[sum(w * r[i] * r[j] for w, r in zip(weights, rows)) for j in range(n)] for i in range(n)]
    cofactor = inverse(normal)
    right = [sum(w * r[i] * v for w, r, v in zip(weights, rows, y)) for i in range(n)]
    x = [sum(c * b for c, b in zip(row, right)) for row in cofactor]
    residuals = [v - sum(a * b for a, b in zip(r, x)) for r, v in zip(rows, y)]
    ssq = sum(w * v * v for w, v in zip(weights, residuals))
    leverage = [w * sum(r[i] * cofactor[i][j] * r[j] for i in range(n) for j in range(n)) for w, r in zip(weights, rows)]
    scale = Fraction(1) if variances else ssq / (m - n)
    return {"parameters": {name: {"value": float(v), "exact": mpmath.nstr(real(v), 30), "u": float(mpmath.sqrt(real(scale * cofactor[j][j])))}
                           for j, (name, v) in enumerate(zip(names, x))},
            "variance": "stated" if variances else "estimated",
            "residual_sd": float(mpmath.sqrt(real(ssq / (m - n)))), "sum_of_squares": float(ssq), "dof": m - n,
            "covariance": {"order": names, "matrix": [[float(scale * c) for c in row] for row in cofactor]},
            "residuals": [float(v) for v in residuals], "leverages": [float(h) for h in leverage],
            "redundancy": [float(1 - h) for h in leverage]}


def number(text):
    """A JSON number from a decimal figure: an int where it is one, else the nearest double."""
    q = Fraction(text)
    return int(q) if q.denominator == 1 else float(text)


def bench(name, title, source, sensor, unit, model):
    return {"id": name, "title": title, "source": source, "chain": [], "sensors": {sensor: {"unit": unit, "model": model}}}


def write_pair(path, a_bench, estimate, readings, expected, known=None, derived=None):
    campaign = {"bench": a_bench, **({"known": known} if known else {}), "estimate": {n: {} for n in estimate},
                **({"derived": derived} if derived else {}), "readings": readings}
    write(path + ".campaign.json", campaign)
    write(path + ".expected.json", expected)


def digits(found, exact):
    apart = (abs(mpmath.mpf(f) / mpmath.mpf(e) - 1) for f, e in zip(found, exact))
    return round(float(min(-mpmath.log10(max(d, mpmath.mpf(10) ** -17)) for d in apart)), 1)


def digits_in_doubles(x, powers, y, exact):
    """Digits by column-pivoted QR of the unit-norm columns; digits of the exact solution of the rounded rows.
    Powers of x by repeated multiplication."""
    columns = [[float(v) for v in c] for c in zip(*x)]
    if powers:
        columns = [np.cumprod(np.vstack([np.ones(len(x))] + [columns[0]] * p), axis=0)[-1] for p in range(powers)]
    A, b = np.array(columns).T, np.array([float(v) for v in y])
    scale = np.linalg.norm(A, axis=0)
    Q, R, order = scipy.linalg.qr(A / scale, mode="economic", pivoting=True)
    found = np.empty(A.shape[1])
    found[order] = scipy.linalg.solve_triangular(R, Q.T @ b)
    rounded = solve([str(j) for j in range(A.shape[1])], [[Fraction(v) for v in r] for r in A.tolist()], [Fraction(v) for v in b.tolist()])
    return digits(found / scale, exact), digits([p["exact"] for p in rounded["parameters"].values()], exact)


def nist():
    data = read("reference/nist_strd.json")
    for name, s in data["sets"].items():
        x = [[Fraction(v) for v in row] for row in s["x"]]
        y = [Fraction(v) for v in s["y"]]
        powers = 0
        columns = [f"x{i + 1}" for i in range(len(x[0]))] if len(x[0]) > 1 else ["x"]
        if s["model"].startswith("y = sum"):
            degree = len(s["exact_rational_solution"]["beta"]) - 1
            powers = degree + 1
            rows, names = [[r[0] ** k for k in range(degree + 1)] for r in x], [f"b{k}" for k in range(degree + 1)]
            model = " + ".join(["b0", "b1*x"] + [f"b{k}*x^{k}" for k in range(2, degree + 1)])
        elif "no intercept" in s["model"]:
            rows, names, model = x, ["b1"], "b1*x"
        else:
            rows, names = [[Fraction(1)] + r for r in x], ["b0"] + [f"b{k + 1}" for k in range(len(columns))]
            model = " + ".join(["b0"] + [f"b{k + 1}*{c}" for k, c in enumerate(columns)])
        expected = {"source": "NIST StRD " + name + "; " + data["source"], **solve(names, rows, y)}
        certified = s["certified_as_quoted"] or {}
        for j, n in enumerate(names):
            for theirs, ours in (("beta", "certified"), ("se", "certified_u")):
                if certified.get(theirs):
                    expected["parameters"][n][ours] = certified[theirs][j]
        expected["published"] = {k: v for k, v in certified.items() if k in ("r2", "sse", "residual_sd")}
        exact = [expected["parameters"][n]["exact"] for n in names]
        theirs = s["exact_rational_solution"]["beta"]
        worst = max(abs(mpmath.mpf(a) / mpmath.mpf(b) - 1) for a, b in zip(exact, theirs))
        in_doubles = digits_in_doubles(x if powers else rows, powers, y, exact)
        expected.update({"required_digits": REQUIRED[name], "numpy_digits": in_doubles[0], "rounded_rows_digits": in_doubles[1]})
        print(f"{name}: {in_doubles} digits by numpy and by exact solution of the rounded rows, {REQUIRED[name]} asked; reference file differs {float(worst):.1e}")
        readings = [{**{c: number(v) for c, v in zip(columns, row)}, "y": number(v)} for row, v in zip(s["x"], s["y"])]
        write_pair("nist/" + name, bench("nist-" + name, "NIST StRD " + name, "NIST Statistical Reference Datasets", "y", "1", model),
                   names, readings, expected)


def gum():
    data = read("reference/gum.json")
    t, b = data["H3"]["t"], data["H3"]["b"]
    rows = [[Fraction(1), Fraction(v) - 20] for v in t]
    expected = {"source": "GUM (JCGM 100:2008) H.3, thermometer calibration", **solve(["y1", "y2"], rows, [Fraction(v) for v in b])}
    c = expected["covariance"]["matrix"]
    expected["derived"] = {"b30": {"value": data["H3"]["recomputed"]["b30"], "u": float(np.sqrt(c[0][0] + 20 * c[0][1] + 100 * c[1][1]))}}
    p = expected["parameters"]
    assert abs(p["y1"]["value"] + 10 * p["y2"]["value"] - expected["derived"]["b30"]["value"]) < 1e-15
    assert abs(expected["derived"]["b30"]["u"] - data["H3"]["recomputed"]["u_b30"]) < 1e-15
    expected["correlation_y1_y2"] = c[0][1] / float(np.sqrt(c[0][0] * c[1][1]))
    expected["published"] = data["H3"]["published"]
    write_pair("gum/h3", bench("gum-h3", "Calibration of a thermometer", "GUM (JCGM 100:2008) H.3", "b", "degC", "y1 + y2*(t - 20)"),
               ["y1", "y2"], [{"t": number(v), "b": number(w)} for v, w in zip(t, b)], expected, derived={"b30": "y1 + y2*(30 - 20)"})

    s = data["natrella_5_4_1"]
    expected = {"source": "Natrella, Experimental Statistics (NBS Handbook 91), 5-4.1",
                **solve(["intercept", "slope"], [[Fraction(1), Fraction(v)] for v in s["x"]], [Fraction(v) for v in s["y"]]),
                "published": s["published"]}
    write_pair("gum/natrella-5-4-1", bench("natrella-5-4-1", "A straight line", "Natrella, NBS Handbook 91, 5-4.1", "y", "1", "intercept + slope*x"),
               ["intercept", "slope"], [{"x": v, "y": w} for v, w in zip(s["x"], s["y"])], expected)


def iso():
    data = read("reference/iso_ts_28037.json")
    york = next(s for s in data["errors_in_both"] if s["id"].startswith("Pearson-York"))
    sets = [("p13-equal-weights", s["id"], s["x"], s["y"], s["u_y"], s["expected_in_peer"])
            for s in data["sets"][:1]] + [("p14-unequal-weights", s["id"], s["x"], s["y"], s["u_y"], s["expected_in_peer"]) for s in data["sets"][1:]]
    for name, title, x, y, u, published in sets:
        expected = {"source": title, **solve(["a", "b"], [[Fraction(1), Fraction(v)] for v in x], [Fraction(v) for v in y],
                                             [Fraction(v) ** 2 for v in u]), "published": published}
        write_pair("iso28037/" + name, bench("iso28037-" + name, "Straight-line calibration", title, "y", "1", "a + b*x"), ["a", "b"],
                   [{"x": number(v), "y": number(w), "y_u": number(s)} for v, w, s in zip(x, y, u)], expected)
    # Pearson's data with York's weights, the abscissa as the reading: u = 1/sqrt(weight), irrational, so given as a double
    u = [float(1 / np.sqrt(w)) for w in york["wx"]]
    expected = {"source": "Pearson's data, York's weights, x against y, errors in x only; GTC test_fitting.py, after R lm",
                **solve(["a", "b"], [[Fraction(1), Fraction(str(v))] for v in york["y"]], [Fraction(str(v)) for v in york["x"]],
                        [1 / Fraction(str(w)) for w in york["wx"]]), "published": data["pearson_york_y_only"]["expected"]}
    write_pair("iso28037/pearson-york-x-only", bench("pearson-york", "Pearson's data with York's weights", york["id"], "x", "1", "a + b*y"),
               ["a", "b"], [{"y": v, "x": w, "x_u": s} for v, w, s in zip(york["y"], york["x"], u)], expected)


def levelling():
    data = read("reference/levelling_networks.json")
    for net in data["networks"]:
        stations = list(net["approx_heights"])
        free = [s for s in stations if s not in net["fixed"]]
        names = ["H" + s for s in free]
        rows, y, variances, readings = [], [], [], []
        for o in net["observations"]:
            sign = {s: (s == o["to"]) - (s == o["from"]) for s in stations}
            rows.append([Fraction(sign[s]) for s in free])
            y.append(Fraction(o["dh"]) - sum(sign[s] * Fraction(h) for s, h in net["fixed"].items()))
            variances.append(Fraction(o["sigma_1km"]) ** 2 * Fraction(o["length_m"]) / 1000)
            readings.append({"position": f"{o['from']}-{o['to']}", **{"c" + s: sign[s] for s in stations}, "dh": number(o["dh"]),
                             "dh_u": float(o["sigma_1km"]) * float(np.sqrt(float(o["length_m"]) / 1000))})
        expected = {"source": "F. Krumm, Geodetic Network Adjustment Examples; " + net["name"], **solve(names, rows, y, variances)}
        given = net["exact_recomputed"]
        expected["u_a_posteriori"] = {n: expected["residual_sd"] * expected["parameters"][n]["u"] for n in names}
        for s, n in zip(free, names):
            assert abs(expected["parameters"][n]["value"] - given["heights"][s]) < 1e-12
            assert abs(1e3 * expected["parameters"][n]["u"] - given["sigma_apriori_mm"][s]) < 1e-12
        assert abs(expected["residual_sd"] - given["s0"]) < 1e-13
        expected["published"] = {"adjusted height m, correction mm, sd mm (a posteriori)": net["published_adj_file_lines"]}
        model = " + ".join(f"H{s}*c{s}" for s in stations)
        short = net["name"].split("_Height")[0].lower().replace("_", "-")
        write_pair("levelling/" + short, bench("levelling-" + short, "Levelling net " + net["name"], "F. Krumm, Geodetic Network Adjustment Examples",
                                               "dh", "m", model), names, readings, expected,
                   known={"H" + s: {"value": float(h), "unit": "m"} for s, h in net["fixed"].items()})


if __name__ == "__main__":
    nist()
    gum()
    iso()
    levelling()
