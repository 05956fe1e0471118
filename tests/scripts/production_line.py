"""Readings of forty gyros from one rate-table schedule, and their fits by numpy: examples/26-production-line.

    python tests/scripts/production_line.py

Writes readings.csv and expected.csv there. The model is linear, so that each device is one numpy.linalg.lstsq; u from the residuals.
What is wrong with which device: G012 has one bad reading, G017 lacks three, G023 was read in the reverse order, G031 stood at one rate only,
G036 has a cell that is no number; lot C has a larger scale factor.
"""
import csv
import os

import numpy as np

FOLDER = os.path.join(os.path.dirname(__file__), "../../examples/26-production-line")
RATES = [20, -20, 50, -50, 100, -100]
WARM = [-15.0, 0.0, 15.0]  # temperature less 25 degC
NAMES = ["V0", "kI", "kII", "cT"]
rng = np.random.default_rng(60)
schedule = [(rate, warm) for warm in WARM for rate in RATES for _ in range(2)]


def row(rate, warm):
    return [1.0, rate, rate * rate, warm]


written, expected = [], []
for number in range(1, 41):
    serial, lot = f"G{number:03d}", "ABCD"[(number - 1) // 10]
    truth = np.array([0.0120, 0.02500, 2.0e-7, 1.5e-4]) + rng.standard_normal(4) * [8e-4, 4e-5, 4e-8, 2e-5]
    truth[1] += 1.5e-4 if lot == "C" else 0.0
    own = schedule
    if serial == "G017":
        own = schedule[:5] + schedule[8:]
    if serial == "G023":
        own = schedule[::-1]
    if serial == "G031":
        own = [(50, warm) for _, warm in schedule]
    values = []
    for place, (rate, warm) in enumerate(own):
        value = float(np.dot(row(rate, warm), truth)) + 6e-4 * rng.standard_normal()
        if serial == "G012" and place == 20:
            value += 0.008
        values.append(round(value, 6))
        text = "overload" if serial == "G036" and place == 7 else f"{values[-1]:.6f}"
        written.append([serial, lot, rate, f"{warm:g}", text])
    a = np.array([row(*state) for state in own])
    scale = np.abs(a).max(axis=0)
    if serial != "G036" and np.linalg.matrix_rank(a / scale) == 4:
        q, r = np.linalg.qr(a / scale)
        y = np.array(values)
        x = np.linalg.solve(r, q.T @ y)
        rest = y - a / scale @ x
        inverse = np.linalg.inv(r)
        u = np.sqrt(rest @ rest / (len(y) - 4) * (inverse**2).sum(axis=1))
        expected.append([serial] + [f"{v:.15e}" for v in np.concatenate([x / scale, u / scale])])

with open(os.path.join(FOLDER, "readings.csv"), "w", newline="") as file:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["serial", "lot", "gamma_deg_s", "warm_c", "V"])
    writer.writerows(written)
with open(os.path.join(FOLDER, "expected.csv"), "w", newline="") as file:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["serial"] + NAMES + [f"{name}_u" for name in NAMES])
    writer.writerows(expected)
