"""Least squares of the linear campaigns in examples/2*/, rows and solution by numpy: tests/data/systems/fits.json.

Where the model line is linear in what is asked, the column of a parameter is the noiseless reading with that parameter 1 and
all others 0 (exact_simulator.py), so nothing of the program under test enters. Run: python3 tests/scripts/system_fits.py
"""
import json

import numpy as np

import exact_simulator
from common import write
from exact_simulator import read_sensor
from system_campaigns import ROOT, bench

exact_simulator.TURN_STEPS = 64
CAMPAIGNS = ["examples/13-accelerometer-dividing-head/head-8.campaign.json",
             "examples/13-accelerometer-dividing-head/head-24.campaign.json",
             "examples/11-gyro-skew-triad/first-stage.campaign.json"]


def fit(path):
    campaign = json.loads((ROOT / path).read_text())
    system = bench(campaign["bench"])
    names = list(campaign["estimate"])
    keep = {n: v.get("start", 1.0) for n, v in campaign["estimate"].items() if n.startswith("E")}  # no term divides by |E| = 0
    sensors = [s for s in system["sensors"]]
    index = [(r, s) for r in campaign["readings"] for s in sensors if s in r]
    base = np.array([float(read_sensor(system, s, r, keep)) for r, s in index])
    columns = []
    for n in names:
        columns.append([float(read_sensor(system, s, r, {**keep, n: keep.get(n, 0) + 1})) for r, s in index] - base)
    a = np.array(columns).T
    base = base - a @ np.array([keep.get(n, 0) for n in names])
    y = np.array([r[s] for r, s in index]) - base
    stated = sensors[0] + "_u" in index[0][0]
    u = np.array([r.get(s + "_u", 1.0) for r, s in index])
    x, _, rank, _ = np.linalg.lstsq(a / u[:, None], y / u, rcond=None)
    v = (y - a @ x) / u
    cofactor = np.linalg.inv((a / u[:, None]).T @ (a / u[:, None]))
    scale = 1.0 if stated else float(np.sqrt(v @ v / (len(y) - rank)))
    return {"dof": int(len(y) - rank), "parameters": {
        n: {"value": float(x[j]), "u": scale * float(np.sqrt(cofactor[j, j]))} for j, n in enumerate(names)}}


write("systems/fits.json", {path: fit(path) for path in CAMPAIGNS})
