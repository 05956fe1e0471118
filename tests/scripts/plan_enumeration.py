"""Optimal choices among random rows by full enumeration in numpy: the yardstick of tests/planning/optima.rs.

Problems have between 1e5 and 4e5 designs, more than the program tries one by one, so that its exchanges are what is measured. Rows are those
of benches: products of sines and cosines of two angles on a coarse grid, with two gains, and plain random rows. Writes tests/data/plan-optima.json:
rows, number to choose, limit on repeats, and the least of -log det M (D), tr M^-1 (A), c' M^-1 c (c), the largest eigenvalue of M^-1 (E) and
max x' M^-1 x (G). For A and E, which are sums over unknowns of no common unit, each is in units of its uncertainty from all rows together.
"""

import itertools
import json
import pathlib

import numpy as np

rng = np.random.default_rng(20261121)


def bench(count, n):
    """Rows of a gyro on two axes at random angles of a grid, with one of two rates."""
    a = rng.integers(0, 8, count) * np.pi / 4
    b = rng.integers(0, 12, count) * np.pi / 6
    gain = rng.choice([1.0, -1.0, 1.7], count)
    columns = [np.ones(count), gain * np.cos(b), gain * np.sin(b), gain, gain * np.cos(a), gain * np.sin(a)]
    return np.stack(columns[:n], 1)


def multisets(count, choose, repeats):
    if repeats == 1:
        return np.array(list(itertools.combinations(range(count), choose)))
    return np.array(list(itertools.combinations_with_replacement(range(count), choose)))


def least(rows, choose, repeats, c):
    n = rows.shape[1]
    best = {"D": np.inf, "A": np.inf, "c": np.inf, "G": np.inf, "E": np.inf}
    designs = multisets(len(rows), choose, repeats)
    outer = rows[:, :, None] * rows[:, None, :]
    unit = np.sqrt(np.linalg.inv(outer.sum(0)).diagonal())
    for part in np.array_split(designs, max(1, len(designs) // 20000)):
        m = outer[part].sum(1)
        # in units of each unknown's own information, singular ones left out
        d = np.sqrt(np.einsum("kii->ki", m))
        regular = (d > 0).all(1)
        m, d = m[regular], d[regular]
        scaled = m / d[:, :, None] / d[:, None, :]
        regular = np.linalg.eigvalsh(scaled)[:, 0] > 1e-9
        m = m[regular]
        if len(m) == 0:
            continue
        inverse = np.linalg.inv(m)
        best["D"] = min(best["D"], -np.linalg.slogdet(m)[1].max())
        shares = inverse / unit[:, None] / unit
        best["A"] = min(best["A"], np.einsum("kii->k", shares).min())
        best["c"] = min(best["c"], np.einsum("i,kij,j->k", c, inverse, c).min())
        best["E"] = min(best["E"], np.linalg.eigvalsh(shares)[:, -1].min())
        best["G"] = min(best["G"], np.einsum("ai,kij,aj->ka", rows, inverse, rows).max(1).min())
    return len(designs), best


if __name__ == "__main__":
    problems = []
    for kind, count, n, choose, repeats in [
        ("bench", 24, 4, 5, 0),
        ("bench", 24, 5, 5, 0),
        ("bench", 17, 5, 6, 0),
        ("bench", 26, 6, 6, 1),
        ("bench", 18, 6, 6, 0),
        ("bench", 21, 4, 7, 1),
        ("random", 28, 3, 5, 0),
        ("random", 23, 4, 5, 0),
        ("random", 16, 4, 6, 0),
        ("random", 25, 5, 6, 1),
        ("random", 12, 5, 8, 0),
        ("ternary", 24, 4, 5, 0),
        ("ternary", 18, 5, 6, 0),
        ("ternary", 24, 4, 6, 1),
    ]:
        if kind == "bench":
            rows = bench(count, n)
        elif kind == "random":
            rows = rng.uniform(-1, 1, (count, n))
        else:
            rows = rng.integers(-1, 2, (count, n)).astype(float)
        c = np.round(rng.uniform(-1, 1, n), 3)
        designs, best = least(rows, choose, repeats, c)
        print(f"{kind:>8} {count:>3} {n} {choose} {repeats} {designs:>7} " + " ".join(f"{k} {v:.6f}" for k, v in best.items()))
        problems.append(
            {"kind": kind, "rows": rows.tolist(), "choose": choose, "repeats": repeats, "c": c.tolist(), "designs": designs, "least": best}
        )
    path = pathlib.Path(__file__).resolve().parent.parent / "data" / "plan-optima.json"
    path.write_text(json.dumps(problems) + "\n")
