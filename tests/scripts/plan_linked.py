"""Optimal choices among positions that share deviations, by full enumeration in numpy: the yardstick of tests/planning/linked.rs.

Readings y = a + b x + c x^2 at five values of x on three days; a day has an offset of its own (sd 0.3), or the whole campaign has one (sd 0.2), beside
noise of 0.1. The covariance of (a, b, c) is that of generalised least squares with the dense V = R + s^2 Z Z' of every design. Writes
tests/data/plan-linked.json: for each problem the candidates, what is kept, and the least of log det (D), the trace (A), var b (c), the largest variance
of a predicted a + b x + c x^2 over the candidates (G) and the largest eigenvalue (E) over all designs. A and E are of parameters in units of what all
candidates together give.
"""

import itertools
import json
import pathlib

import numpy as np

NOISE = 0.1


def covariances(x, day, line, sd, designs):
    """Covariance of the parameters for each design (rows of indices), singular ones as nan."""
    rows = np.stack([np.ones_like(x), x, x * x], 1)
    out = np.full((len(designs), 3, 3), np.nan)
    for part in np.array_split(np.arange(len(designs)), max(1, len(designs) // 20000)):
        own = designs[part]
        a = rows[own]
        same = np.ones((len(part), own.shape[1], own.shape[1])) if line == "campaign" else day[own][:, :, None] == day[own][:, None, :]
        v = NOISE**2 * np.eye(own.shape[1]) + sd**2 * same
        m = np.einsum("kir,kij,kjs->krs", a, np.linalg.inv(v), a)
        regular = np.linalg.eigvalsh(m)[:, 0] > 1e-6 * np.linalg.eigvalsh(m)[:, -1]
        out[part[regular]] = np.linalg.inv(m[regular])
    return out


if __name__ == "__main__":
    problems = []
    grid = [(x, d) for d in (1.0, 2.0, 3.0) for x in (-1.0, -0.5, 0.0, 0.5, 1.0)]
    x, day = (np.array(column) for column in zip(*grid))
    for line, sd, candidates, kept, choose, repeats in [
        ("day", 0.3, range(15), [], 8, 99),
        ("day", 0.3, range(15), [0, 1, 2, 2], 5, 99),
        ("day", 0.05, range(15), [], 9, 1),
        ("day", 0.3, [0, 1, 2, 3, 4, 5, 7, 9], [10, 14], 9, 99),
        ("campaign", 0.2, range(15), [], 6, 2),
    ]:
        candidates = list(candidates)
        choices = itertools.combinations if repeats == 1 else itertools.combinations_with_replacement
        designs = np.array(list(choices(candidates, choose)))
        if 1 < repeats < choose:
            most = np.array([np.unique(d, return_counts=True)[1].max() for d in designs])
            designs = designs[most <= repeats]
        designs = np.concatenate([np.tile(np.array(kept, dtype=int), (len(designs), 1)), designs], 1)
        c = covariances(x, day, line, sd, designs)
        c = c[~np.isnan(c[:, 0, 0])]
        # in units of what all candidates, and what is kept, give
        scale = 1 / np.sqrt(np.diag(covariances(x, day, line, sd, np.array([kept + candidates]))[0]))
        rows = np.stack([np.ones(len(candidates)), x[candidates], x[candidates] ** 2], 1)
        problems.append(
            {
                "line": line,
                "sd": sd,
                "candidates": [[x[k], day[k]] for k in candidates],
                "kept": [[x[k], day[k]] for k in kept],
                "choose": choose,
                "repeats": repeats,
                "designs": len(designs),
                "scale": scale.tolist(),
                "least": {
                    "D": np.linalg.slogdet(c)[1].min(),
                    "A": np.einsum("kii,i->k", c, scale**2).min(),
                    "c": c[:, 1, 1].min(),
                    "G": np.einsum("ai,kij,aj->ka", rows, c, rows).max(1).min(),
                    "E": np.linalg.eigvalsh(c * scale[:, None] * scale)[:, -1].min(),
                },
            }
        )
        print(line, choose, len(designs), {k: float(v) for k, v in problems[-1]["least"].items()})
    # the fewest readings, on any days, for u(b) within limits: var b least for each number
    fewest = []
    for choose in range(3, 8):
        designs = np.array(list(itertools.combinations_with_replacement(range(15), choose)))
        c = covariances(x, day, "day", 0.3, designs)
        fewest.append({"readings": choose, "u": float(np.sqrt(np.nanmin(c[:, 1, 1])))})
        print(fewest[-1])
    out = pathlib.Path(__file__).parents[1] / "data" / "plan-linked.json"
    out.write_text(json.dumps({"problems": problems, "fewest": fewest}, indent=1) + "\n")
