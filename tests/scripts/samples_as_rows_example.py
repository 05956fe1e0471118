"""The record of examples/27-samples-as-rows: a gyro on a rate table that swings, in a chamber that warms up; logged at 4 Hz for 33 minutes.

    python3 tests/scripts/samples_as_rows_example.py
"""

import csv
import gzip
import math
import random
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent.parent / "examples" / "27-samples-as-rows"
random.seed(5505)
STEP, ROWS = 0.25, 8000
WHITE, SD, TAU = 40e-6, 25e-6, 60.0  # V, V, s
V0, V1, V2, K, K1 = 2.1e-3, 4.0e-6, 2.0e-8, 0.02004, -0.9e-6
EARTH = 15.041067 / 3600 * math.sin(math.radians(45.75))  # deg/s along the table's axis

keeps = math.exp(-STEP / TAU)
deviation = random.gauss(0, SD)
lines = []
for k in range(ROWS):
    t = k * STEP
    if k:
        deviation = keeps * deviation + random.gauss(0, SD * math.sqrt(1 - keeps * keeps))
    rate = 20 * math.sin(2 * math.pi * t / 300)
    angle = 20 * 300 / (2 * math.pi) * (1 - math.cos(2 * math.pi * t / 300))
    temperature = 25 + 40 * (1 - math.exp(-t / 1500)) - 5
    warm = temperature - 25
    value = V0 + V1 * warm + V2 * warm**2 + (K + K1 * warm) * (rate + EARTH) + deviation + random.gauss(0, WHITE)
    lines.append([f"{1000 * t:.0f}", f"{angle:.4f}", f"{rate:.5f}", f"{temperature:.3f}", f"{1000 * value:.4f}"])
with open(HERE / "swing.csv.gz", "wb") as raw, gzip.GzipFile("", "wb", 9, raw, mtime=0) as packed:
    text = "time_ms,gamma_deg,gamma_deg_s,temperature_c,V (mV)\n" + "\n".join(",".join(line) for line in lines) + "\n"
    packed.write(text.encode())
