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
                if seed is not None:
                    row[key] = float(f"{value + sd[key] * random.standard_normal():.10g}")
                if stated:
                    row[key + "_u"] = sd[key]
        rows.append(row)
    return rows


def noiseless(name, note, system, truth, estimate, known, readings, sd, starts=None):
    """sd is stated with the readings, so that sensors are weighed as they would be, though there is no noise."""
    starts = starts or {}
    readings = noisy(readings, sd, None, True)
    write(f"simulated/{name}.campaign.json", {
        "bench": system, "known": known, "estimate": {n: ({"start": starts[n]} if n in starts else {}) for n in estimate},
        "readings": readings})
    write(f"simulated/{name}.truth.json", {"note": note, "truth": truth, "estimated": estimate})


# --- accelerometer on a dividing head -------------------------------------------------------------------------------------------

HEAD_NOISE = {"A": 5e-6}
HEAD_TRUTH = {"K0": 1.234e-3, "K1": 1.2992, "K2": 4.2e-5, "K3": -2.7e-5, "KIP": 1.9e-5, "KP": -8.1e-4}


def dividing_head():
    system, name = bench("accelerometer-dividing-head"), "accelerometer-dividing-head"
    asked = {4: ["K0", "K1", "K2", "KP"], 8: list(HEAD_TRUTH), 12: list(HEAD_TRUTH), 24: list(HEAD_TRUTH)}
    for count, names in asked.items():
        schedule = [{"position": str(k + 1), "theta_deg": 360.0 * k / count} for k in range(count)]
        exact = simulate(system, schedule, HEAD_TRUTH)
        example(f"13-accelerometer-dividing-head/head-{count}.campaign.json", {
            "bench": name, "estimate": {n: {} for n in names}, "readings": noisy(exact, HEAD_NOISE, 2300 + count)})
        if count == 24:
            noiseless("dividing-head", "24 equidistant positions, all tilts zero", name, HEAD_TRUTH, names, {}, exact, HEAD_NOISE)
    tilted = {**HEAD_TRUTH, "head_level": 4e-4, "head_zero": -3e-4, "mount_z": 7e-4, "KIO": 3e-5, "KO": 1.1e-3}
    schedule = [{"position": str(k + 1), "theta_deg": 15.0 * k} for k in range(24)]
    noiseless("dividing-head-tilted", "head axis off level, head zero and mounting tilt known, unlike the Fourier sums assume", name,
              tilted, list(HEAD_TRUTH), {n: {"value": tilted[n]} for n in ("head_level", "head_zero", "mount_z", "KIO", "KO")},
              simulate(system, schedule, tilted), HEAD_NOISE)


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
    return static + [{**row, "read": ["Gx", "Gy", "Gz"]} for row in rate]


def without(key, rows):
    return [{k: v for k, v in row.items() if k != key} for row in rows]


def imu_truth():
    random = np.random.Generator(np.random.PCG64(20))
    near = lambda value, spread: float(f"{value + spread * random.uniform(-1, 1):.7g}")
    truth = {}
    # names as in the source: Egxz is what w_y does to Gx, whose input axis is turned about z
    for a, (b, c) in {"x": "yz", "y": "zx", "z": "xy"}.items():
        truth |= {f"Kg{a}": near(7200, 7), f"Eg{a}{c}": near(0, 1e-3), f"Eg{a}{b}": near(0, 1e-3), f"D{a}0": near(0, 5)}
    for a, (b, c) in {"x": "yz", "y": "zx", "z": "xy"}.items():
        truth |= {f"Ka{a}": near(20000, 40), f"Ea{a}{c}": near(0, 1e-3), f"Ea{a}{b}": near(0, 1e-3), f"A{a}0": near(0, 60),
                  f"K{a}{a}": near(0, 0.6)}
    return truth


IMU_NOISE = {"Gx": 0.02, "Gy": 0.02, "Gz": 0.02, "Ax": 0.1, "Ay": 0.1, "Az": 0.1}
IMU_STARTS = {**{f"Kg{a}": 7200.0 for a in "xyz"}, **{f"Ka{a}": 20000.0 for a in "xyz"}}
TABLE = ["level_x", "level_y", "square_om", "middle_zero", "middle_linear", "inner_linear"]


def imu():
    system, name, truth = bench("imu-three-axis-table"), "imu-three-axis-table", imu_truth()
    sensor_names = list(truth)
    estimate = lambda names: {n: ({"start": IMU_STARTS[n]} if n in IMU_STARTS else {}) for n in names}
    exact = simulate(system, imu_schedule(), truth)
    noiseless("imu-table", "24 positions and 36 rate runs on a perfect table", name, truth, sensor_names, {}, exact, IMU_NOISE, IMU_STARTS)
    example("10-imu-three-axis-table/perfect-table.campaign.json", {
        "bench": name, "estimate": estimate(sensor_names), "readings": noisy(exact, IMU_NOISE, 2001)})
    arcsec = np.pi / 648000
    tilts = {n: float(f"{v * arcsec:.6g}") for n, v in zip(TABLE, [22, -31, 27, -18, -4, 5])}
    shaken = simulate(system, imu_schedule(), {**truth, **tilts})
    noiseless("imu-table-tilted", "the same on a table with errors, estimated jointly", name, {**truth, **tilts},
              sensor_names + TABLE, {}, shaken, IMU_NOISE, IMU_STARTS)
    example("10-imu-three-axis-table/table-errors.campaign.json", {
        "bench": name, "estimate": estimate(sensor_names + TABLE), "readings": noisy(shaken, IMU_NOISE, 2002)})
    every = ["level_x", "level_y", "outer_zero", "outer_linear", "square_om", "middle_zero", "middle_linear", "square_mi",
             "inner_zero", "inner_linear", "mount_x", "mount_y", "mount_z"]
    example("10-imu-three-axis-table/everything.campaign.json", {
        "bench": name, "estimate": estimate(sensor_names + every), "readings": noisy(shaken, IMU_NOISE, 2002)})
    example("10-imu-three-axis-table/schedule.campaign.json", {
        "bench": name, "estimate": estimate(sensor_names), "readings": without("read", imu_schedule())})


# --- skew-mounted gyro triad ----------------------------------------------------------------------------------------------------

SKEW_STATIC, SKEW_RATE = 0.003, 0.1  # pulse/s, 0.0015 and 0.05 deg/h: minutes at rest, whole turns while turning
SKEW_SCALE = {1: 2.0, 2: 1.95, 3: 2.05}  # pulse/arcsec
SKEW_TABLE = ["level_x", "level_y", "square_om", "middle_zero", "middle_linear", "inner_linear"]


def skew_truth():
    random = np.random.Generator(np.random.PCG64(21))
    near = lambda value, spread: float(f"{value + spread * random.uniform(-1, 1):.9g}")
    axes = {1: (3**-0.5, -(6**-0.5), 2**-0.5), 2: (3**-0.5, -(6**-0.5), -(2**-0.5)), 3: (3**-0.5, 2 / 6**0.5, 0.0)}
    truth, starts = {}, {}
    for k, axis in axes.items():
        scale = SKEW_SCALE[k]
        truth[f"D{k}"] = near(0, 2 * scale)
        for name, c in zip("xyz", axis):
            truth[f"E{k}{name}"] = near(scale * c, scale * 1e-3)
            starts[f"E{k}{name}"] = float(f"{scale * c:.9g}")
        truth |= {f"P{k}y": near(0, 0.05 * scale), f"P{k}z": near(0, 0.05 * scale), f"DI{k}": near(0, 1.5), f"DS{k}": near(0, 1.5)}
    return truth, starts


def stated(readings, sensors, static, turning, seed):
    """Noise whose u is stated with each reading: more where a joint turns."""
    random = np.random.Generator(np.random.PCG64(seed)) if seed is not None else None
    rows = []
    for reading in readings:
        u = turning if any(key.endswith("_deg_s") for key in reading) else static
        row = dict(reading)
        for s in sensors:
            if random:
                row[s] = float(f"{row[s] + u * random.standard_normal():.10g}")
            row[s + "_u"] = u
        rows.append(row)
    return rows


def skew():
    system, name = bench("gyro-skew-triad"), "gyro-skew-triad"
    truth, starts = skew_truth()
    forms = json.loads((ROOT / f"data/closed_forms/{name}.json").read_text())["formulas"]
    exact = simulate(system, without("read", imu_schedule()), truth)
    sensors = ["N1", "N2", "N3"]
    stage = lambda own: [n for k in (1, 2, 3) for n in [f"D{k}", *(f"E{k}{a}" for a in "xyz"), *own(k), f"P{k}y", f"P{k}z"]]
    first = stage(lambda k: [f"G{k}{a}" for a in "xyz"])
    direct = stage(lambda k: [f"DI{k}", f"DS{k}"])
    asked = lambda names: {n: ({"start": starts[n]} if n in starts else {}) for n in names}
    derived = {d: forms[d] for k in (1, 2, 3) for d in (f"D_I{k}", f"D_S{k}")}
    write("simulated/skew-triad.campaign.json", {
        "bench": name, "estimate": asked(direct), "readings": stated(exact, sensors, SKEW_STATIC, SKEW_RATE, None)})
    write("simulated/skew-triad.truth.json", {
        "note": "drift coefficients along the gyros' own axes, E 1e-3 from nominal", "truth": truth, "estimated": direct})
    readings = stated(exact, sensors, SKEW_STATIC, SKEW_RATE, 2101)
    folder = "11-gyro-skew-triad"
    example(f"{folder}/first-stage.campaign.json", {
        "bench": name, "estimate": asked(first), "derived": derived, "readings": readings})
    example(f"{folder}/direct.campaign.json", {"bench": name, "estimate": asked(direct), "readings": readings})
    # the same triad on a table with errors, estimated with the drift coefficients
    arcsec = np.pi / 648000
    tilts = {n: float(f"{v * arcsec:.6g}") for n, v in zip(SKEW_TABLE, [22, -31, 27, -18, -4, 5])}
    shaken = simulate(system, without("read", imu_schedule()), {**truth, **tilts})
    write("simulated/skew-triad-tilted.campaign.json", {
        "bench": name, "estimate": asked(direct + SKEW_TABLE), "readings": stated(shaken, sensors, SKEW_STATIC, SKEW_RATE, None)})
    write("simulated/skew-triad-tilted.truth.json", {
        "note": "the same on a table with errors, estimated jointly", "truth": {**truth, **tilts}, "estimated": direct + SKEW_TABLE})
    everything = stage(lambda k: [f"G{k}{a}" for a in "xyz"] + [f"P{k}x"])
    example(f"{folder}/everything.campaign.json", {"bench": name, "estimate": asked(everything), "readings": readings})


# --- cube mirror and theodolites --------------------------------------------------------------------------------------------------

DEG = 3600.0
CUBE_TRUTH = {"mark": 10 * DEG + 12.3, "heading": -60 * DEG + 1234.5, "pitch": 1.2 * DEG + 7.7, "roll": -0.8 * DEG + 3.1, "cube": 4.2,
              "base": -20 * DEG + 77.0, "oA": 30 * DEG + 5.5, "oB": 10 * DEG - 8.8, "colA": 2.1, "colB": -1.7, "iA": 3.3, "iB": -2.4,
              "d_heading": 6.5, "d_pitch": -2.2, "d_roll": 3.9}
CUBE_STARTS = {"heading": -60 * DEG, "pitch": 1.2 * DEG, "roll": -0.8 * DEG, "base": -20 * DEG, "oA": 30 * DEG, "oB": 10 * DEG}
CIRCLES = ["cHA_mark", "cHA_B", "cHA_M", "cVA_M", "cHB_A", "cHB_N", "cVB_N"]
RECTANGULAR = float(f"{0.5 / np.sqrt(3):.6g}")


def cube():
    system, name = bench("cube-mirror"), "cube-mirror"
    circle = ["HA_mark", "HA_B", "HA_M", "VA_M", "HB_A", "HB_N", "VB_N"]
    outputs = ["out_heading", "out_pitch", "out_roll"]
    schedule = [{"position": f"repeat {k + 1}, face {'right' if face else 'left'}", "face": face, "read": circle}
                for k in range(6) for face in (0, 1)]
    schedule += [{"position": f"repeat {k + 1}, device", "face": 0, "read": outputs} for k in range(6)]
    exact = simulate(system, schedule, CUBE_TRUTH)
    names = [n for n in CUBE_TRUTH if n != "mark"]
    sd = {**{s: 0.7 for s in circle}, **{s: 0.9 for s in outputs}}
    known = {"mark": {"value": CUBE_TRUTH["mark"], "unit": "arcsec", "u": 0.5},
             **{c: {"value": 0, "unit": "arcsec", "u": RECTANGULAR, "distribution": "rectangular"} for c in CIRCLES},
             **{c: {"value": 0, "unit": "arcsec", "u": 0.1} for c in ("compA", "compB")}}
    right = bench("cube-mirror-right")
    noiseless("cube-mirror-right", "the same with face N on the right, circles from 0 to 360 deg", "cube-mirror-right", CUBE_TRUTH, names,
              {"mark": {"value": CUBE_TRUTH["mark"]}},
              [{k: (v % 1296000 if k in circle else v) for k, v in row.items()} for row in simulate(right, schedule, CUBE_TRUTH)], sd,
              CUBE_STARTS)
    noiseless("cube-mirror", "two faces, six repeats", name, CUBE_TRUTH, names, {"mark": {"value": CUBE_TRUTH["mark"]}}, exact, sd,
              CUBE_STARTS)
    example("12-cube-mirror/attitude.campaign.json", {
        "bench": name, "known": known, "estimate": {n: ({"start": CUBE_STARTS[n]} if n in CUBE_STARTS else {}) for n in names},
        "readings": noisy(exact, sd, 2201)})
    # the paper's repeatabilities: six values with exactly this sample standard deviation
    pattern = np.array([-1.2, 0.7, 0.1, -0.4, 1.5, -0.7])
    pattern = (pattern - pattern.mean()) / pattern.std(ddof=1)
    for s in (0.69, 0.76):
        example(f"12-cube-mirror/roll-{int(100 * s):03d}.campaign.json", {
            "bench": {"id": "roll-repeats", "title": f"six roll values with repeatability {s} arcsec and a circle error of 0.5 arcsec",
                      "sensors": {"T": {"unit": "arcsec", "model": "roll + circle"}}},
            "known": {"circle": {"value": 0, "unit": "arcsec", "u": RECTANGULAR, "distribution": "rectangular"}},
            "estimate": {"roll": {}},
            "readings": [{"position": str(k + 1), "T": float(f"{s * v:.12g}")} for k, v in enumerate(pattern)]})


    # both faces, combined with c = 0.5 each (eq. 22)
    example("12-cube-mirror/both-faces.campaign.json", {
        "bench": {"id": "roll-repeats", "title": "roll by face left and face right, six values each, each circle with an error of 0.5 arcsec",
                  "sensors": {"L": {"unit": "arcsec", "model": "left + circle_left"}, "R": {"unit": "arcsec", "model": "right + circle_right"}}},
        "known": {c: {"value": 0, "unit": "arcsec", "u": RECTANGULAR, "distribution": "rectangular"} for c in ("circle_left", "circle_right")},
        "estimate": {"left": {}, "right": {}}, "derived": {"roll": "0.5*left + 0.5*right"},
        "readings": [{"position": str(k + 1), "L": float(f"{0.69 * v:.12g}"), "R": float(f"{0.76 * v:.12g}")} for k, v in enumerate(pattern)]})


SYSTEMS = {"dividing_head": dividing_head, "imu": imu, "skew": skew, "cube": cube}

if __name__ == "__main__":
    for chosen in sys.argv[1:] or SYSTEMS:
        SYSTEMS[chosen]()
