"""Schedules and simulated campaigns of the systems of the source papers: examples/2*/ and tests/data/simulated/.

Readings come from exact_simulator.py (no small angles, 80-bit floats). Each system is written twice: noiseless, for the tests
(tests/data/simulated/NAME.campaign.json and .truth.json), and with seeded Gaussian noise, for its example folder.
Run: python3 tests/scripts/system_campaigns.py [name ...]     (deterministic; under a minute)
"""
import json
import sys
from pathlib import Path

import numpy as np

import exact_simulator
from common import campaign_text, write
from exact_simulator import simulate

ROOT = Path(__file__).resolve().parent.parent.parent
exact_simulator.TURN_STEPS = 64  # exact for trigonometric polynomials up to degree 63; none here is above 3


def bench(name):
    return json.loads((ROOT / f"data/benches/{name}.bench.json").read_text())


def example(path, value):
    target = ROOT / "examples" / path
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(campaign_text(value), encoding="utf-8")
    print("wrote", target.relative_to(ROOT))


def noisy(readings, sd, seed, stated=False):
    """Gaussian noise; sd = {sensor: standard deviation}, in the order of the readings."""
    random = np.random.Generator(np.random.PCG64(seed))
    rows = []
    for reading in readings:
        row = {}
        for key, value in reading.items():
            row[key] = value
            if key in sd:
                row[key] = float(f"{value + sd[key] * random.standard_normal():.10g}")
                if stated:
                    row[key + "_u"] = sd[key]
        rows.append(row)
    return rows


def noiseless(name, note, system, truth, estimate, known, readings, starts=None):
    starts = starts or {}
    write(f"simulated/{name}.campaign.json", {
        "bench": system, "known": known, "estimate": {n: ({"start": starts[n]} if n in starts else {}) for n in estimate},
        "readings": readings})
    write(f"simulated/{name}.truth.json", {"note": note, "truth": truth, "estimated": estimate})


# --- accelerometer on a dividing head -------------------------------------------------------------------------------------------

HEAD_TRUTH = {"K0": 1.234e-3, "K1": 1.2992, "K2": 4.2e-5, "K3": -2.7e-5, "KIP": 1.9e-5, "KP": -8.1e-4}


def dividing_head():
    system, name = bench("accelerometer-dividing-head"), "accelerometer-dividing-head"
    asked = {4: ["K0", "K1", "K2", "KP"], 8: list(HEAD_TRUTH), 12: list(HEAD_TRUTH), 24: list(HEAD_TRUTH)}
    for count, names in asked.items():
        schedule = [{"position": str(k + 1), "theta_deg": 360.0 * k / count} for k in range(count)]
        exact = simulate(system, schedule, HEAD_TRUTH)
        example(f"23-accelerometer-dividing-head/head-{count}.campaign.json", {
            "bench": name, "estimate": {n: {} for n in names}, "readings": noisy(exact, {"A": 5e-6}, 2300 + count)})
        if count == 24:
            noiseless("dividing-head", "24 equidistant positions, all tilts zero", name, HEAD_TRUTH, names, {}, exact)
    tilted = {**HEAD_TRUTH, "head_level": 4e-4, "head_zero": -3e-4, "mount_z": 7e-4, "KIO": 3e-5, "KO": 1.1e-3}
    schedule = [{"position": str(k + 1), "theta_deg": 15.0 * k} for k in range(24)]
    noiseless("dividing-head-tilted", "head axis off level, head zero and mounting tilt known, unlike the Fourier sums assume", name,
              tilted, list(HEAD_TRUTH), {n: {"value": tilted[n]} for n in ("head_level", "head_zero", "mount_z", "KIO", "KO")},
              simulate(system, schedule, tilted))


# --- IMU on a three-axis table --------------------------------------------------------------------------------------------------

UP = {"z up": (0, 0), "z down": (180, 0), "y up": (90, 0), "y down": (270, 0), "x up": (0, 270), "x down": (0, 90)}
RATES = [10.0, 20.0, 40.0]


def imu_schedule():
    """24 static positions (each axis up and down in four azimuths), then 36 rate runs (both senses of three rates about each
    table axis, in two attitudes between which Earth rate along the axis cancels)."""
    static = [{"position": f"{name}, azimuth {azimuth}", "outer_deg": azimuth, "middle_deg": m, "inner_deg": i}
              for name, (m, i) in UP.items() for azimuth in (0, 90, 180, 270)]
    rate = []
    for turned in (0, 180):
        for q in [sign * r for r in RATES for sign in (1, -1)]:
            rate.append({"position": f"outer turns, middle {turned}", "outer_deg_s": q, "middle_deg": turned, "inner_deg": 0})
        for q in [sign * r for r in RATES for sign in (1, -1)]:
            rate.append({"position": f"middle turns, outer {turned}", "outer_deg": turned, "middle_deg_s": q, "inner_deg": 0})
        for q in [sign * r for r in RATES for sign in (1, -1)]:
            rate.append({"position": f"inner turns, outer {turned + 90}", "outer_deg": turned + 90, "middle_deg": 0, "inner_deg_s": q})
    return static + rate


def imu_truth():
    random = np.random.Generator(np.random.PCG64(20))
    near = lambda value, spread: float(f"{value + spread * random.uniform(-1, 1):.7g}")
    truth = {}
    for a, (b, c) in {"x": "yz", "y": "zx", "z": "xy"}.items():
        truth |= {f"Kg{a}": near(7200, 7), f"Eg{a}{b}": near(0, 1e-3), f"Eg{a}{c}": near(0, 1e-3), f"D{a}0": near(0, 5)}
    for a, (b, c) in {"x": "yz", "y": "zx", "z": "xy"}.items():
        truth |= {f"Ka{a}": near(20000, 40), f"Ea{a}{b}": near(0, 1e-3), f"Ea{a}{c}": near(0, 1e-3), f"A{a}0": near(0, 60),
                  f"K{a}{a}": near(0, 0.6)}
    return truth


IMU_NOISE = {"Gx": 0.02, "Gy": 0.02, "Gz": 0.02, "Ax": 0.1, "Ay": 0.1, "Az": 0.1}
IMU_STARTS = {**{f"Kg{a}": 7200.0 for a in "xyz"}, **{f"Ka{a}": 20000.0 for a in "xyz"}}
TABLE = ["level_x", "level_y", "square_om", "middle_zero"]


def imu():
    system, name, truth = bench("imu-three-axis-table"), "imu-three-axis-table", imu_truth()
    sensor_names = list(truth)
    estimate = lambda names: {n: ({"start": IMU_STARTS[n]} if n in IMU_STARTS else {}) for n in names}
    exact = simulate(system, imu_schedule(), truth)
    noiseless("imu-table", "24 positions and 36 rate runs on a perfect table", name, truth, sensor_names, {}, exact, IMU_STARTS)
    example("20-imu-three-axis-table/perfect-table.campaign.json", {
        "bench": name, "estimate": estimate(sensor_names), "readings": noisy(exact, IMU_NOISE, 2001)})
    arcsec = np.pi / 648000
    tilts = {n: float(f"{v * arcsec:.6g}") for n, v in zip(
        ["level_x", "level_y", "square_om", "middle_zero", "outer_linear", "middle_linear", "inner_linear"],
        [22, -31, 27, -18, 3, -4, 5])}
    table = {n: tilts[n] for n in TABLE}
    shaken = simulate(system, imu_schedule(), {**truth, **table})
    noiseless("imu-table-tilted", "the same on a table with errors, estimated jointly", name, {**truth, **table},
              sensor_names + TABLE, {}, shaken, IMU_STARTS)
    example("20-imu-three-axis-table/table-errors.campaign.json", {
        "bench": name, "estimate": estimate(sensor_names + TABLE), "readings": noisy(shaken, IMU_NOISE, 2002)})
    every = ["level_x", "level_y", "outer_zero", "outer_linear", "square_om", "middle_zero", "middle_linear", "square_mi",
             "inner_zero", "inner_linear", "mount_x", "mount_y", "mount_z"]
    example("20-imu-three-axis-table/everything.campaign.json", {
        "bench": name, "estimate": estimate(sensor_names + every), "readings": noisy(shaken, IMU_NOISE, 2002)})
    example("20-imu-three-axis-table/schedule.campaign.json", {
        "bench": name, "estimate": estimate(sensor_names), "readings": imu_schedule()})


SYSTEMS = {"dividing_head": dividing_head, "imu": imu}

if __name__ == "__main__":
    for chosen in sys.argv[1:] or SYSTEMS:
        SYSTEMS[chosen]()
