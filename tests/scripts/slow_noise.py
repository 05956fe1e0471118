"""Means of `tumble reduce` and fits of them, where the noise is slower than a segment: the table of docs/theory/noise.md. python slow_noise.py TUMBLE [CAMPAIGNS]

24 segments of 600 samples, white noise of 1e-3 V and a Markov process; six times four positions of an accelerometer, in turn or each six times before the next. Truth is zero for
the level V0 and both tilts; counted are intervals of 95 % that hold it. Needs numpy; prints a row for each process and order, seeded."""

import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

TUMBLE, CAMPAIGNS = str(pathlib.Path(sys.argv[1]).resolve()), int(sys.argv[2]) if len(sys.argv) > 2 else 100
SEGMENTS, SAMPLES, DT, SD = 24, 600, 0.01, 1e-3
SCATTER = {
    "none": None,
    "per reading": [{"of": "V", "per": "reading", "u": "estimate"}],
    "over time": [{"of": "V", "over": "time_s", "tau": "estimate", "u": "estimate"}],
}


def report(folder, *arguments):
    run = subprocess.run([TUMBLE, *arguments, "--json", "-"], cwd=folder, capture_output=True, text=True, check=False)
    return json.loads(run.stdout)


def campaign(folder, random, tau, share, order):
    """Which means hold, and for each kind of scatter which parameters."""
    count, step = SEGMENTS * SAMPLES, np.exp(-1 / (tau * SAMPLES))
    drive = random.standard_normal(count) * np.sqrt(1 - step * step)
    slow = np.empty(count)
    state = random.standard_normal()
    for k in range(count):
        state = step * state + drive[k]
        slow[k] = state
    values = SD * (random.standard_normal(count) + share * slow)
    labels = np.repeat(np.arange(SEGMENTS), SAMPLES)
    table = np.column_stack([np.arange(count) * DT, labels, values])
    np.savetxt(folder / "log.csv", table, fmt=["%.2f", "%d", "%.9f"], delimiter=",", header="time_s,position,V", comments="")
    means = [part["means"][0] for part in report(folder, "reduce", "log.csv", "--by", "position", "--columns", "V")["segments"]]
    length = SAMPLES * DT
    readings = [
        {"position": str(angle), "run": k // 4, "time_s": length * k, "beta_deg": angle, "V": m["mean"], "V_u": m["u"]}
        for k, (angle, m) in enumerate(zip(order, means))
    ]
    held = {}
    for name, scatter in SCATTER.items():
        whole = {
            "bench": "accelerometer-plumb-plane",
            "known": {"kI": {"value": 1.0, "unit": "V/g", "u": 0}},
            "estimate": {"V0": {}, "dtheta_y2": {}, "dtheta_z2": {}},
            "readings": readings,
        }
        if scatter:
            whole["scatter"] = scatter
        (folder / "c.campaign.json").write_text(json.dumps(whole))
        parameters = report(folder, "fit", "c.campaign.json")["parameters"]
        held[name] = [p["interval"][0] <= 0 <= p["interval"][1] for p in parameters]
    return [abs(m["mean"]) < 1.96 * m["u"] for m in means], held


angles = [0, 180, 90, 270]
orders = {"in turn": [angles[k % 4] for k in range(SEGMENTS)], "each six times": [angles[k // 6] for k in range(SEGMENTS)]}
print("| order | correlation time, segments | its sd, in that of the white noise | means | " + " | ".join(SCATTER) + " |\n|---|---|---|---|---|---|---|")
for name, order in orders.items():
    for row, (tau, share) in enumerate([(1, 0.3), (3, 0.3), (3, 1.0), (10, 1.0)]):
        random = np.random.default_rng([20261127, row, len(name)])
        with tempfile.TemporaryDirectory() as folder:
            runs = [campaign(pathlib.Path(folder), random, tau, share, order) for _ in range(CAMPAIGNS)]
        cells = []
        for kind in SCATTER:
            shares = np.mean([held[kind] for _, held in runs], axis=0)
            cells.append(f"V0 {shares[0]:.2f}, tilts {min(shares[1:]):.2f} to {max(shares[1:]):.2f}")
        print(f"| {name} | {tau} | {share:g} | {np.mean([means for means, _ in runs]):.2f} | {' | '.join(cells)} |", flush=True)
