"""Lack of fit by position of table 1 of Li, Ren, Zhao 2012: tests/data/li2012/lack_of_fit.json.

Method: numpy's least squares of the small-angle rows (li2012_fits.py's docstring), once as they are and once with a column for each position;
F of the extra sum of squares (Draper, Smith 1998, 6.1), its probability from scipy.
Run: python3 tests/scripts/lack_of_fit.py
"""
import json
from pathlib import Path

import numpy as np
from scipy import stats

from common import write

ROOT = Path(__file__).parents[2]
READINGS = json.loads((ROOT / "data/campaigns/li2012-table1.campaign.json").read_text())["readings"]
EARTH = 15.041067 / 3600 * np.sin(np.radians(45.75))
rows, y, positions = [], [], []
for r in READINGS:
    a, b, q = np.radians(r["alpha_deg"]), np.radians(r["beta_deg"]), -2.9222 * (r["gamma_deg_s"] + EARTH)
    rows.append([1, -q * np.cos(b), q * np.sin(b), -q, -q * np.cos(a), q * np.sin(a)])
    y.append(r["V"])
    positions.append(r["position"])
A, y = np.array(rows), np.array(y)


def left(design):
    u, s, _ = np.linalg.svd(design / np.linalg.norm(design, axis=0), full_matrices=False)
    rank = int((s > 1e-10 * s[0]).sum())
    rest = y - u[:, :rank] @ (u[:, :rank].T @ y)
    return float(rest @ rest), rank


labels = sorted(set(positions))
offsets = np.array([[float(p == label) for label in labels] for p in positions])
(all_of_it, rank), (within, larger) = left(A), left(np.hstack([A, offsets]))
between_dof, within_dof = larger - rank, len(y) - larger
f = (all_of_it - within) / between_dof / (within / within_dof)
write("li2012/lack_of_fit.json", {
    "between_dof": between_dof, "within_dof": within_dof, "f": f, "p": float(stats.f.sf(f, between_dof, within_dof))})
