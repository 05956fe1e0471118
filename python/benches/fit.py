"""What Python adds to the engine: Table 1 from a dict, beside numpy by hand and statsmodels, and many devices as one array.

    python benches/fit.py          (pip install ".[bench]" for statsmodels)

Everything in one run, on one thread unless RAYON_NUM_THREADS says otherwise; the least of several rounds.
"""

from __future__ import annotations

import json
import os
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ.setdefault("RAYON_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import tumble
from tumble import _tumble
from tumble._fit import settings
from tumble._question import dumps

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
DEVICES = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000


def least(work: Callable[[], Any], rounds: int = 30, times: int = 20) -> float:
    """Seconds of one call, the least over rounds of so many."""
    best = float("inf")
    for _ in range(rounds):
        begun = time.perf_counter()
        for _ in range(times):
            work()
        best = min(best, (time.perf_counter() - begun) / times)
    return best


def table_1() -> None:
    campaign = json.loads((EXAMPLES / "01-gyro-table/table1.campaign.json").read_text())
    fit = tumble.fit(campaign)
    n, m = len(fit.order), len(campaign["readings"])
    rng = np.random.default_rng(1)
    design, read = rng.normal(size=(m, n)), rng.normal(size=m)

    def by_hand() -> Any:
        # rows that are there already: QR, estimates, covariance, residual sd
        q, r = np.linalg.qr(design)
        x = np.linalg.solve(r, q.T @ read)
        residuals = read - design @ x
        inverse = np.linalg.inv(r)
        return x, inverse @ inverse.T * (residuals @ residuals / (m - n))

    rounds: list[tuple[float, float, float]] = []
    for _ in range(15):
        # side by side, so that a busy machine is busy for all
        engine = _tumble.engine_seconds(campaign, ".", dumps, 5)
        whole = least(lambda: tumble.fit(campaign), 5, 10)
        rounds.append((whole - engine, engine, whole))
    beyond, engine, whole = sorted(rounds)[len(rounds) // 2]
    print(f"Table 1, {m} readings, {n} unknowns, from a dict")
    print(f"  engine (Rust, a campaign that is there)   {engine * 1e6:8.1f} us")
    print(f"  tumble.fit(dict)                          {whole * 1e6:8.1f} us")
    print(f"  beyond the engine (median of 15)          {beyond * 1e6:8.1f} us   least {min(rounds)[0] * 1e6:.1f}")
    angle = least(lambda: tumble.fit(campaign)["dtheta_y2"].u, 5, 10)
    print(f"  tumble.fit(dict)['dtheta_y2'].u           {angle * 1e6:8.1f} us")
    print(f"  numpy by hand, rows there already         {least(by_hand) * 1e6:8.1f} us")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import statsmodels.api as sm

            print(f"  statsmodels OLS with summary              {least(lambda: sm.OLS(read, design).fit().summary(), 3, 3) * 1e6:8.1f} us")
    except ImportError:
        print("  statsmodels                               is not installed")


def devices() -> None:
    line = "V0 + k1*rate + k2*rate^2/10000 + ka*acc + kt*warm + kaa*acc^2"
    names = ["V0", "k1", "k2", "ka", "kt", "kaa"]
    rows = [
        {"rate": [-100, -50, -20, 20, 50, 100][i // 5], "acc": [0, 0.5, 1, -0.5, -1][i % 5], "warm": (i * 7) % 5 * 5 + 20} for i in range(30)
    ]
    campaign = {
        "bench": {"id": "line", "sensors": {"V": {"unit": "V", "model": line}}}, "estimate": {name: {} for name in names}, "readings": rows,
    }
    rate, acc, warm = (np.array([row[name] for row in rows], dtype=float) for name in ("rate", "acc", "warm"))
    truth = 0.01 - 2.9e-3 * rate + 1e-7 * rate**2 + 2e-3 * acc + 1e-5 * warm
    values = truth + np.random.default_rng(1).normal(0, 3e-4, (DEVICES, 30))
    how = settings(False, False, 0.95, None, None)

    def rust(rounds: int) -> float:
        """Seconds of processor time for so many rounds, with the devices made before."""
        begun = time.process_time()
        _tumble.batch_seconds(campaign, ".", dumps, [("V", values)], how, rounds)
        return time.process_time() - begun

    def python() -> float:
        begun = time.process_time()
        found = tumble.fit_devices(campaign, values=values)
        _ = found.value, found.u, found.U, found.accepted
        return time.process_time() - begun

    # processor time, on one thread: a busy machine is no part of it; two rounds less one leave out the making of the devices
    pairs: list[tuple[float, float, float]] = []
    for _ in range(5):
        own, alone = python(), rust(3) - rust(1)
        pairs.append((2 * own / alone, alone / 2, own))
    ratio, alone, own = sorted(pairs)[len(pairs) // 2]
    print(f"{DEVICES} devices, 30 readings and 6 unknowns each, from one array to arrays (processor time, one thread)")
    print(f"  Rust batch (devices that are there)       {alone * 1e3:8.1f} ms")
    print(f"  tumble.fit_devices(values=array)          {own * 1e3:8.1f} ms   ratio {ratio:.3f} (median of 5; least {min(pairs)[0]:.3f})")
    design = np.column_stack([np.ones(30), rate, rate**2 / 10000, acc, warm, acc**2])

    def by_hand() -> Any:
        q, r = np.linalg.qr(design)
        x = values @ q @ np.linalg.inv(r).T
        residuals = values - x @ design.T
        sd = np.sqrt((residuals**2).sum(1) / 24)
        return x, sd[:, None] * np.sqrt((np.linalg.inv(r) ** 2).sum(1))

    print(f"  numpy by hand: estimates and u, no checks {least(by_hand, 3, 1) * 1e3:8.1f} ms")


if __name__ == "__main__":
    table_1()
    devices()
