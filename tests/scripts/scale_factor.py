"""Errors of a scale factor by rate steps: the loops of example 23 (simulated), and tests/data/scale_factor, the numbers expected
of them and of the IMU of example 10.

Method: straight lines by numpy.polyfit through the means at each rate; approaches and runs by the order of the readings, written out by hand for
these orders. u of the loops by 100,000 draws of all readings about those read with their stated u (of the repeatability: of normal slopes with the
standard deviation found); u of the IMU, per unit of the readings' standard deviation, by central differences.
Run: python3 tests/scripts/scale_factor.py
"""
import json
from pathlib import Path

import numpy as np

from common import write

ROOT = Path(__file__).resolve().parent.parent.parent
RNG = np.random.default_rng(528)
RATES = [-200, -150, -100, -50, -20, 20, 50, 100, 150, 200]
U = 2e-6
# up and down, the ends read on both ways; each way is a run
WAYS = [RATES, RATES[::-1]] * 3


def line(x, y):
    return np.polyfit(np.asarray(x), np.asarray(y), 1)


def means(x, y):
    rates = np.unique(x)
    return rates, np.array([y[..., x == rate].mean(axis=-1) for rate in rates]).T


def errors(x, y, below=None, above=None):
    """Nonlinearity, asymmetry, hysteresis in ppm; y may have more readings of the same schedule before its last axis."""
    rates, mean = means(x, y)
    slope, offset = line(rates, mean.T)
    full = np.abs(slope) * np.abs(rates).max()
    left = mean - np.multiply.outer(slope, rates) - np.asarray(offset)[..., None]
    found = [np.abs(left).max(axis=-1) / full * 1e6]
    up, down = (line(rates[own], mean[..., own].T)[0] for own in (rates > 0, rates < 0))
    found.append(2 * (up - down) / (up + down) * 1e6)
    if below is not None:
        both = [rate for rate in rates if (below & (x == rate)).any() and (above & (x == rate)).any()]
        gap = np.array([y[..., below & (x == rate)].mean(axis=-1) - y[..., above & (x == rate)].mean(axis=-1) for rate in both])
        found.append(np.abs(gap).max(axis=0) / full * 1e6)
    return found


def loops():
    x = np.array([rate for way in WAYS for rate in way], float)
    rising = np.array([k % 2 == 0 for k, way in enumerate(WAYS) for _ in way])
    run = np.repeat(np.arange(len(WAYS)), len(RATES))
    slopes = 0.02 * (1 + 4e-6 * RNG.standard_normal(len(WAYS)))
    z = x / 200
    y = 0.002 + slopes[run] * x + 1.2e-6 * np.abs(x) + 4e-4 * (z**3 - z) + 1.5e-4 * np.where(rising, 1, -1) * (1 - z**2) * (1 + z)
    y = np.round(y + U * RNG.standard_normal(len(x)), 8)
    # a way begins at the rate at which the one before ended: that reading has the sense of the one before, the very first has none
    below = rising.copy()
    below[:: len(RATES)] = ~rising[:: len(RATES)]
    above = ~below
    below[0] = above[0] = False
    values = errors(x, y, below, above)
    own = np.array([line(x[run == k], y[run == k])[0] for k in range(len(WAYS))])
    values.append(own.std(ddof=1) / own.mean() * 1e6)
    drawn = errors(x, y + U * RNG.standard_normal((100_000, len(x))), below, above)
    slopes = own.mean() + own.std(ddof=1) * RNG.standard_normal((100_000, len(WAYS)))
    drawn.append(slopes.std(axis=1, ddof=1) / own.mean() * 1e6)
    names = ["nonlinearity", "asymmetry", "hysteresis", "repeatability"]
    readings = [{"gamma_deg_s": float(rate), "V": float(value), "V_u": U} for rate, value in zip(x, y)]
    write("../../examples/23-rate-steps/loops.campaign.json", {
        "bench": "gyro-rate-steps",
        "unit": {"serial": "G-2204", "type": "rate gyro"},
        "estimate": {"V0": {}, "K": {"start": 0.02, "unit": "V/(deg/s)"}, "A": {}, "K2": {}},
        "readings": readings,
    })
    return {f"V_{name}_gamma_deg_s": [float(value), float(own.std())] for name, value, own in zip(names, values, drawn)}


def imu():
    readings = json.loads((ROOT / "examples/10-imu-three-axis-table/everything.campaign.json").read_text())["readings"]
    found = {}
    for sensor, joint, position in (("Gx", "middle", "middle turns, outer 0"), ("Gy", "inner", "inner turns, outer 90"), ("Gz", "outer", "outer turns, middle 0")):
        own = [r for r in readings if r["position"] == position]
        x, y = np.array([r[f"{joint}_deg_s"] for r in own]), np.array([r[sensor] for r in own])
        step = 1e-3 * np.eye(len(y))
        up, down = errors(x, y + step), errors(x, y - step)
        for name, value, above, below in zip(("nonlinearity", "asymmetry"), errors(x, y), up, down):
            found[f"{sensor}_{name}_{joint}_deg_s"] = [float(value), float(np.linalg.norm((above - below) / 2e-3))]
    return found


write("scale_factor/expected.json", {"loops": loops(), "imu": imu()})
