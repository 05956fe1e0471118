"""Memory and time of `tumble fit` and `tumble plan` on 1e4, 1e5 and 1e6 readings of a gyro at 38 positions, as CSV.

    python3 tests/scripts/long_campaigns.py target/release/tumble /tmp/long

Prints the largest resident memory and the processor time (user and system) of each run (Linux). The files take 80 MB.
"""

import json
import math
import os
import random
import subprocess
import sys
from pathlib import Path

PROGRAM, FOLDER = sys.argv[1], Path(sys.argv[2])
CAMPAIGN = {
    "bench": "gyro-turntable",
    "known": {"kI": {"value": -2.9222, "unit": "V/(deg/s)", "u": 0}},
    "estimate": {"V0": {}, "dtheta_x0": {}, "dtheta_y0": {}, "dtheta_y1": {}, "dtheta_y2": {}, "dtheta_z2": {}},
}
LINE = [{"of": "V", "per": "position", "u": "estimate"}]
POSITIONS = [(90 * (k % 4), 45 * (k % 8) + 90 * (k // 16) + (22.5 if k >= 32 else 0)) for k in range(38)]

FOLDER.mkdir(exist_ok=True)
for rows in (10**4, 10**5, 10**6):
    random.seed(rows)
    offsets = [random.gauss(0, 2e-3) for _ in POSITIONS]
    with open(FOLDER / f"{rows}.csv", "w") as file, open(FOLDER / f"{rows}.schedule.csv", "w") as schedule:
        file.write("position,alpha_deg,beta_deg,gamma_deg_s,V\n")
        schedule.write("position,alpha_deg,beta_deg,gamma_deg_s\n")
        for k in range(rows):
            p = k * len(POSITIONS) // rows
            (alpha, beta), rate = POSITIONS[p], 20 if k % 2 == 0 else -20
            tilt = 1e-3 * math.cos(math.radians(beta)) + 5e-4 * math.cos(math.radians(alpha))
            value = 3e-3 - 2.9222 * rate * tilt + offsets[p] + random.gauss(0, 5e-4)
            place = f"p{p + 1},{alpha},{beta},{rate}"
            file.write(f"{place},{value:.7f}\n")
            schedule.write(f"{place}\n")
    runs = {
        "fit": ("fit", {**CAMPAIGN, "readings": f"{rows}.csv"}, []),
        "fit, scatter": ("fit", {**CAMPAIGN, "scatter": LINE, "readings": f"{rows}.csv"}, []),
        "plan": ("plan", {**CAMPAIGN, "readings": f"{rows}.schedule.csv"}, ["--noise", "V=5e-4"]),
    }
    for name, (command, campaign, options) in runs.items():
        path = FOLDER / "campaign.json"
        path.write_text(json.dumps(campaign))
        run = subprocess.Popen([PROGRAM, command, str(path), *options], stdout=subprocess.DEVNULL)
        _, _, used = os.wait4(run.pid, 0)
        seconds = used.ru_utime + used.ru_stime
        print(f"{rows:>8} readings, {name:<13} {used.ru_maxrss / 1000:7.0f} MB  {seconds:6.2f} s", flush=True)
