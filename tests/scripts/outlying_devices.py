"""How often a family of normal devices has one that is said to be an outlier, and how often one at five standard deviations is found (numpy, scipy).

Rosner's procedure with Grubbs' limits, as in src/batch/summary.rs, beside normal limits of robust deviates, `|x - median| / 1.4826 MAD`, which are often exceeded by
chance where devices are few. Prints the table of docs/guide/devices.md.

    python3 tests/scripts/outlying_devices.py
"""

import numpy as np
from scipy.stats import norm, t

QUANTITIES, LEVEL = 6, 0.01


def limits(n):
    m = np.arange(3, n + 1)
    q = t.ppf(1 - 0.5 * LEVEL / QUANTITIES / m, m - 2)
    return dict(zip(m, (m - 1) * q / np.sqrt(m * (m - 2 + q * q))))


def rosner(x, limit):
    x = x[np.argsort(np.abs(x - np.median(x)))]
    for m in range(max(len(x) // 2 + 1, 3), len(x) + 1):
        own = x[:m]
        if abs(own[-1] - own.mean()) / own.std(ddof=1) > limit[m]:
            return x[m - 1 :]
    return x[:0]


def robust(x):
    far = np.abs(x - np.median(x))
    return x[far / (1.4826 * np.median(far)) > norm.ppf(1 - 0.5 * LEVEL / (len(x) * QUANTITIES))]


def table(families=1000):
    rng = np.random.default_rng(20261130)
    print("| devices | false, robust | false, Rosner | found, Rosner |\n|---|---|---|---|")
    for n in (6, 10, 20, 40, 100):
        limit = limits(n)
        false, found = np.zeros(2), 0
        for _ in range(families):
            x = rng.standard_normal((QUANTITIES, n))
            false += [any(len(robust(own)) for own in x), any(len(rosner(own, limit)) for own in x)]
            x[0, 0] = 5.0
            found += 5.0 in rosner(x[0], limit)
        print(f"| {n} | {100 * false[0] / families:.1f} % | {100 * false[1] / families:.1f} % | {100 * found / families:.0f} % |")


table()
