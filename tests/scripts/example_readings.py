"""Readings of examples/03-your-own-positions: the exact simulator, noise of 0.9 mV, rounded to 0.1 mV as a voltmeter shows them.

The truth is in the example's README and in tests/examples.rs.  Run: python3 tests/scripts/example_readings.py   (seeded)
"""
import csv
import json
from pathlib import Path

import numpy as np

from exact_simulator import simulate

FOLDER = Path(__file__).resolve().parents[2] / "examples" / "03-your-own-positions"
ARCSEC = np.pi / 180 / 3600
TRUTH = {"V0": 0.0021, "kI": -2.9222, "surface_x": 12 * ARCSEC, "surface_y": -25 * ARCSEC, "fixture_y": 48 * ARCSEC,
         "gyro_y": -95 * ARCSEC, "gyro_z": 130 * ARCSEC}
# (alpha, beta) in degrees: four quarters of each joint, and mixed ones
POSITIONS = [(0, 0), (0, 90), (0, 180), (0, 270), (90, 0), (180, 0), (270, 0), (90, 90), (270, 180), (180, 270)]

if __name__ == "__main__":
    bench = json.loads((FOLDER / "my-table.bench.json").read_text())
    schedule = [{"position": str(k + 1), "alpha_deg": alpha, "beta_deg": beta, "gamma_deg_s": rate}
                for k, (alpha, beta) in enumerate(POSITIONS) for rate in (25, -25)]
    readings = simulate(bench, schedule, TRUTH)
    noise = np.random.default_rng(20121).normal(0, 0.9e-3, len(readings))
    with open(FOLDER / "my-readings.csv", "w", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(list(schedule[0]) + ["V"])
        for reading, error in zip(readings, noise):
            rows.writerow([reading[key] for key in schedule[0]] + [f"{reading['V'] + error:.4f}"])
