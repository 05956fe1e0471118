"""A gyro whose first tilt is about the axis of an inner joint: readings respond to it in the second order only. What the other unknowns have of
uncertainty with that tilt held, by rotation matrices and difference quotients: tests/data/simulated/second-order-tilt.json, beside the campaign.

    python3 tests/scripts/second_order_tilt.py
"""

import json
import pathlib

import numpy as np

FOLDER = pathlib.Path(__file__).parents[1] / "data/simulated"
EARTH = 15.041067 / 3600
AXES = {"x": np.eye(3)[0], "y": np.eye(3)[1], "z": np.eye(3)[2]}
STEPS = 24  # a turn in equal parts: exact for the harmonics that the chain has


def rotation(axis, angle):
    k = AXES[axis]
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def predicted(campaign, names, point):
    bench = campaign["bench"]
    latitude = np.radians(bench["site"]["latitude_deg"])
    earth = EARTH * np.array([0, np.cos(latitude), np.sin(latitude)])
    of = dict(zip(names, point))
    out = []
    for row in campaign["readings"]:
        rates = []
        for step in range(STEPS):
            frame, rate = np.eye(3), np.zeros(3)
            for link in bench["chain"]:
                name = link.get("joint") or link["tilt"]
                turning = row.get(f"{name}_deg_s", 0.0) if "joint" in link else 0.0
                angle = of[name] if "tilt" in link else np.radians(row.get(f"{name}_deg", 0.0))
                if turning:
                    angle = 2 * np.pi * (step + 0.5) / STEPS
                own = rotation(link["about"], angle)
                frame, rate = frame @ own, own.T @ (rate + AXES[link["about"]] * turning)
            rates.append((rate + frame.T @ earth)[0])
        out.append(of["V0"] + of["kI"] * np.mean(rates))
    return np.array(out)


def main():
    campaign = json.loads((FOLDER / "second-order-tilt.campaign.json").read_text())
    names = ["sx", "sy", "my", "mz", "V0", "kI"]
    y = np.array([row["V"] for row in campaign["readings"]])
    u = np.array([row["V_u"] for row in campaign["readings"]])
    point = np.array([0, 0, 0, 0, 0, 1.33])

    def slopes():
        columns = []
        for k in range(1, 6):
            h = 1e-5 if k < 4 else 1e-4
            more, less = point.copy(), point.copy()
            more[k] += h
            less[k] -= h
            columns.append((predicted(campaign, names, more) - predicted(campaign, names, less)) / (2 * h))
        return np.array(columns).T / u[:, None]

    for _ in range(6):
        point[1:] += np.linalg.lstsq(slopes(), (y - predicted(campaign, names, point)) / u, rcond=None)[0]
    a = slopes()
    sd = np.sqrt(np.diag(np.linalg.inv(a.T @ a)))
    found = {"value": dict(zip(names[1:], point[1:])), "u": dict(zip(names[1:], sd))}
    (FOLDER / "second-order-tilt.json").write_text(json.dumps(found, indent=1) + "\n")
    print(found)


main()
