"""Memory and time of `tumble fit` on samples as rows: records of 1e5, 1e6 and 1e7 rows with white and correlated noise, as CSV.

    python3 tests/scripts/streamed_memory.py target/release/tumble /tmp/streamed

Prints the largest resident memory and the processor time of each fit (Linux). The records take 0.5 GB.
"""

import json
import math
import os
import random
import subprocess
import sys
from pathlib import Path

PROGRAM, FOLDER = sys.argv[1], Path(sys.argv[2])
BENCH = {"id": "sweep", "sensors": {"V": {"unit": "V", "model": "V0 + b*temperature_c + c*temperature_c^2"}}}
SCATTER = {
    "white": [],
    "stated": [{"of": "V", "over": "time_s", "tau": 5, "u": 0.002}],
    "estimated": [{"of": "V", "over": "time_s", "tau": "estimate", "u": "estimate"}],
}

FOLDER.mkdir(exist_ok=True)
for rows in (10**5, 10**6, 10**7):
    random.seed(rows)
    keeps, deviation = math.exp(-0.01 / 5), random.gauss(0, 0.002)
    with open(FOLDER / f"{rows}.csv", "w") as file:
        file.write("time_s,temperature_c,V\n")
        for k in range(rows):
            warm = 20 + 30 * math.sin(12 * k / rows)
            deviation = keeps * deviation + random.gauss(0, 0.002 * math.sqrt(1 - keeps * keeps))
            value = 1.5 - 0.02 * warm + 1e-4 * warm * warm + deviation + random.gauss(0, 0.01)
            file.write(f"{0.01 * k:.2f},{warm:.6f},{value:.6f}\n")
    for name, scatter in SCATTER.items():
        campaign = {"bench": BENCH, "estimate": {"V0": {}, "b": {}, "c": {}}, "scatter": scatter,
                    "readings": {"samples": f"{rows}.csv", "as": "rows"}}
        path = FOLDER / f"{name}.campaign.json"
        path.write_text(json.dumps(campaign))
        fit = subprocess.Popen([PROGRAM, "fit", str(path)], stdout=subprocess.DEVNULL)
        _, _, used = os.wait4(fit.pid, 0)
        print(f"{rows:>9} rows, {name:<9}  {used.ru_maxrss / 1024:6.1f} MiB  {used.ru_utime:7.1f} s", flush=True)
