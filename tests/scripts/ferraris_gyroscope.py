"""The gyroscope half of the Ferraris session: examples/17-ferraris-session/gyroscope.campaign.json.

The specific force of the accelerometer's calibration (closed forms, from the six positions at rest) is the mean over each turn; turns of -360
degrees as the session's authors count them. A hand ends a turn, and holds its axis, to about a degree: that is stated as the means' standard
uncertainty, since a hand's rate scatters by its motion and not by noise. Prints the closed forms of mad-lab-fau/imucal beside least squares with numpy, every mean alike.
"""
import csv
import gzip
import json
from pathlib import Path

import numpy as np

RATE_HZ, G = 204.8, 9.81
folder = Path(__file__).parent / "../../examples/17-ferraris-session"
parts = {}
with gzip.open(folder / "whole-session.csv.gz", "rt", encoding="utf-8") as file:
    for row in csv.DictReader(file):
        values = [float(row[f"{kind}_{axis}"]) for kind in ("acc", "gyr") for axis in "xyz"]
        parts.setdefault(row["part"], []).append(values)
means = {part: np.mean(values, axis=0) for part, values in parts.items()}
duration = {part: len(values) / RATE_HZ for part, values in parts.items()}

still = [f"{axis}_{sense}" for axis in "xyz" for sense in "pa"]
force = {part: np.eye(3)["xyz".index(part[0])] * (G if part[2] == "p" else -G) for part in still}
ups, downs = ([means[f"{axis}_{sense}"] for axis in "xyz"] for sense in "pa")
ups, downs = np.transpose(ups), np.transpose(downs)
matrix = (ups - downs) / (2 * G)
offset = np.diag(ups[:3] + downs[:3]) / 2
turns = [f"{axis}_rot" for axis in "xyz"]
for part in turns:
    force[part] = np.linalg.solve(matrix[:3], means[part][:3] - offset)

positions = []
for part in still + turns:
    line = {"position": part, "duration_s": duration[part]}
    for k, axis in enumerate("xyz"):
        line[f"turn_{axis}"] = -360 if part == f"{axis}_rot" else 0
    for k, axis in enumerate("xyz"):
        line[f"f_{axis}"] = round(float(force[part][k]), 12)
    if part in turns:
        rate = abs(float(means[part][3 + turns.index(part)]))
        for axis in "xyz":
            line[f"gyr_{axis}_u"] = float(f"{rate * (1 / 360 if axis == part[0] else np.pi / 180):.2g}")
    positions.append(line)

AXES = "xyz"
model = {
    f"gyr_{a}": {
        "unit": "count",
        "model": f"b_{a} + (" + " + ".join(f"m_{a}{c}*turn_{c}" for c in AXES) + ")/duration_s + "
        + " + ".join(f"k_{a}{c}*f_{c}" for c in AXES),
    }
    for a in AXES
}
campaign = {
    "bench": {
        "id": "ferraris-gyroscope",
        "title": "Triaxial gyroscope held by hand with each axis up and down, then turned once about each",
        "source": "F. Ferraris, U. Grimaldi, M. Parvis, Sensors and Materials 7 (1995) 311-330; data: mad-lab-fau/imucal (MIT licence)",
        "chain": [],
        "sensors": model,
    },
    "estimate": {f"{name}": {} for a in AXES for name in [f"b_{a}"] + [f"m_{a}{c}" for c in AXES] + [f"k_{a}{c}" for c in AXES]},
    "derived": {f"K_{a}": f"sqrt(m_{a}x^2 + m_{a}y^2 + m_{a}z^2)" for a in AXES},
    "scatter": [{"of": f"b_{a}", "per": "position", "u": "estimate"} for a in AXES],
    "readings": {"samples": "whole-session.csv.gz", "by": "part", "rate_hz": RATE_HZ, "positions": positions},
}
(folder / "gyroscope.campaign.json").write_text(json.dumps(campaign, indent=1) + "\n", encoding="utf-8")

rows = np.array([[1, *(p[f"turn_{c}"] / p["duration_s"] for c in AXES), *(p[f"f_{c}"] for c in AXES)] for p in positions])
observed = np.array([means[p["position"]][3:] for p in positions])
solution, *_ = np.linalg.lstsq(rows, observed, rcond=None)
left = observed - rows @ solution
print("offsets by least squares", solution[0].tolist())
print("matrix by least squares", solution[1:4].T.tolist())
print("residual sd", (np.sqrt((left**2).sum(axis=0) / (len(rows) - 7))).tolist())
