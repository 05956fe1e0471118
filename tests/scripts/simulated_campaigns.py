"""Noiseless campaigns with a known truth: tests/data/simulated/NAME.campaign.json and NAME.truth.json.

Readings come from exact_simulator.py (no small angles, 80-bit floats) and are written with all the digits of a double, so an
fit of the campaign must bring the truth back. That it can is checked here by a Gauss-Newton iteration of
its own (central differences in 80-bit floats, numpy least squares in doubles) which starts where the campaign says: tilts
and coefficients at 0 or at their "start", knowns at their values. The truth file holds
    truth        every value the simulator used, knowns too (tilts in rad, coefficients in the bench's units)
    estimated    the names the campaign asks for, in its order
    rank_at_start, condition_at_start   of the column-scaled rows at the reference point, all readings weighted alike
                                        (condition null where the rank is less than the unknowns)
    gauss_newton { steps, error }       largest |found - truth| / max(|truth|, 1e-3) after those steps
    linear_step  { name: value }        one least-squares step from the reference point: what a fit with --linear gives
                                        (one sensor, full rank; good to 1e-9 of the largest step)
Run: python3 tests/scripts/simulated_campaigns.py   (seeded, deterministic; half a minute)
"""
import copy

import numpy as np

import exact_simulator
from common import read, write
from exact_simulator import L, read_sensor, simulate

GYRO = read("benches/gyro-turntable.bench.json")
ACC = read("benches/accelerometer-plumb-plane.bench.json")
GYRO_TILTS = ["dtheta_x0", "dtheta_y0", "dtheta_y1", "dtheta_y2", "dtheta_z2"]
EXTRAS = [(90, 90), (90, 270), (270, 90), (270, 0), (180, 270)]


def residuals(bench, readings, values):
    return np.array([float(L(r[s]) - read_sensor(bench, s, r, values)) for r in readings for s in bench["sensors"] if s in r])


def jacobian(bench, readings, values, names):
    columns = []
    for name in names:
        h = 1e-5 * max(abs(values.get(name, 0)), 0.1)
        up, down = ({**values, name: L(values.get(name, 0)) + d} for d in (L(h), -L(h)))
        columns.append([float((read_sensor(bench, s, r, up) - read_sensor(bench, s, r, down)) / (2 * L(h)))
                        for r in readings for s in bench["sensors"] if s in r])
    return np.array(columns).T


def scaled_solve(rows, y):
    scale = np.linalg.norm(rows, axis=0)
    scale[scale < 1e-12 * scale.max()] = 1  # a zero column up to the rounding of the differences
    x, _, rank, singular = np.linalg.lstsq(rows / scale, y, rcond=1e-9)
    return x / scale, int(rank), float(f"{singular[0] / singular[-1]:.6g}") if rank == len(x) else None


def gauss_newton(bench, readings, start, truth, names, steps=12):
    values, report = dict(start), {}
    for step in range(1, steps + 1):
        x, rank, condition = scaled_solve(jacobian(bench, readings, values, names), residuals(bench, readings, values))
        if step == 1:
            report = {"rank_at_start": rank, "condition_at_start": condition}
            if rank < len(names):
                return report
            if len(bench["sensors"]) == 1:
                report["linear_step"] = {n: float(f"{start.get(n, 0) + d:.11g}") for n, d in zip(names, x)}
        values.update({n: values.get(n, 0) + float(d) for n, d in zip(names, x)})
        if np.all(np.abs(x) < 1e-14 * np.maximum(1e-3, np.abs([values[n] for n in names]))):
            break
    error = max(abs(values[n] - truth[n]) / max(abs(truth[n]), 1e-3) for n in names)
    report["gauss_newton"] = {"steps": step, "error": float(f"{error:.1e}")}
    return report


def campaign(name, note, bench, schedule, truth, known, starts=None, units=None, inline=False, expected_rank=None):
    """Everything in `truth` that is not in `known` is estimated."""
    starts, units = starts or {}, units or {}
    names = [n for n in truth if n not in known]
    readings = simulate(bench, schedule, truth)
    exact_simulator.TURN_STEPS = 64  # the search for the truth needs no more: every model line here is of degree 3 at most
    report = gauss_newton(bench, readings, {**{k: truth[k] for k in known}, **starts}, truth, names)
    exact_simulator.TURN_STEPS = 4096
    print(name, len(readings), "readings", len(names), "unknowns", {k: v for k, v in report.items() if k != "linear_step"})
    assert report["rank_at_start"] == (expected_rank or len(names))
    assert expected_rank or report["gauss_newton"]["error"] < 1e-7
    with_unit = {k: {"value": truth[k], **({"unit": units[k]} if k in units else {})} for k in known}
    write(f"simulated/{name}.campaign.json", {
        "bench": bench if inline else bench["id"], "known": with_unit,
        "estimate": {n: ({"start": starts[n]} if n in starts else {}) for n in names}, "readings": readings})
    write(f"simulated/{name}.truth.json", {"note": note, "truth": truth, "estimated": names, **report})


def tilts(random, names):
    return {n: float(v) for n, v in zip(names, random.uniform(-2e-3, 2e-3, len(names)))}


def gyro_positions(random, count):
    return [(float(a), float(b)) for a, b in random.uniform(-180, 360, (count, 2)).round(3)] + EXTRAS


def turning(random, positions):
    rates = [float(r) for r in random.uniform(5, 100, 3).round(2)]
    return [{"position": f"{i + 1}", "alpha_deg": a, "beta_deg": b, "gamma_deg_s": sign * rates[i % 3]}
            for i, (a, b) in enumerate(positions) for sign in (1, -1)]


def gyro_campaigns():
    for seed in (1, 2, 3):
        random = np.random.default_rng(seed)
        truth = {"kI": -2.9222, "V0": float(random.normal(0, 2e-3)), **tilts(random, GYRO_TILTS)}
        campaign(f"gyro-{seed}", "random alpha and beta, 90/270 extras, rates of both signs; whole turns",
                 GYRO, turning(random, gyro_positions(random, 9)), truth, ["kI"], units={"kI": "V/(deg/s)"})

    random = np.random.default_rng(4)
    truth = {"kI": -2.9222, "kII": 3.1e-5, "kIO": -2.2e-4, "kIS": 1.7e-4, "kOS": 4.1e-5,
             "V0": 1.3e-3, **tilts(random, GYRO_TILTS)}
    campaign("gyro-second-order", "kII, kIO, kIS, kOS as knowns: the mean of the line is not the line of the means",
             GYRO, turning(random, gyro_positions(random, 12)), truth, ["kI", "kII", "kIO", "kIS", "kOS"])

    random = np.random.default_rng(5)
    truth = {"kI": -2.9222, "kIO": -2.2e-4, "V0": -7e-4, **tilts(random, GYRO_TILTS), "kOS": 4.1e-5}
    campaign("gyro-estimate-kOS", "a second-order coefficient among the unknowns",
             GYRO, turning(random, gyro_positions(random, 12)), truth, ["kI", "kIO"])

    random = np.random.default_rng(6)
    truth = {"kI": -2.9222, "V0": 9e-4, **tilts(random, GYRO_TILTS + ["dtheta_z1"])}
    schedule = turning(random, gyro_positions(random, 6))
    for i, (a, b) in enumerate(gyro_positions(random, 12)):
        rate, at = float(random.choice([-1, 1])) * round(random.uniform(0.01, 5), 4), round(random.uniform(0, 360), 2)
        here = {"position": f"p{i}", "alpha_deg": a, "beta_deg": b, "gamma_deg": at}
        schedule.append({**here, "gamma_deg_s": rate, "gamma_turns": [0.25, 0.5, 1.375, 2, 0.1][i % 5]})
        schedule.append({**here, "gamma_deg_s": -rate})
        schedule.append(here)
    campaign("gyro-part-turns", "whole turns, part turns (gamma_deg, gamma_deg_s, gamma_turns), instants while turning "
             "(gamma_deg, gamma_deg_s) and at rest (gamma_deg); dtheta_z1 is seen only through the Earth's horizontal rate",
             GYRO, schedule, truth, ["kI"])
    campaign("gyro-part-turns-scale-factor", "the same with the scale factor kI estimated, from start -3",
             GYRO, schedule, truth, [], starts={"kI": -3.0})

    random = np.random.default_rng(7)
    bench = copy.deepcopy(GYRO)
    bench.update({"id": "gyro-rad-s", "title": "The gyro table in rad/s and m/s^2, southern site, axes as direction cosines"})
    bench["site"] = {"latitude_deg": -33.9, "earth_rate_deg_h": 15.041067, "gravity_g": 0.9989}
    bench["units"] = {"rate": "rad/s", "force": "m/s^2"}
    bench["sensors"]["V"]["axes"] = {"I": [0.6, 0.8, 0], "S": [-0.8, 0.6, 0], "O": "z"}
    bench["sensors"]["V"]["model"] = "V0 + kI*w_I + D_I*a_I + D_O*a_O + kII*w_I^2 + h*gamma_deg_s*cos(2*beta)"
    truth = {"kII": 2e-3, "V0": 2e-3, "kI": 1.7, **tilts(random, ["dtheta_y0", "dtheta_y1", "dtheta_y2", "dtheta_z2"]),
             "D_I": 4e-4, "D_O": -6e-4, "h": 1.5e-5}
    campaign("gyro-rad-s-gravity", "other units and site; acceleration-sensitive drift; a joint's name and gamma_deg_s as inputs; "
             "input axis between x and y, so that kI is estimable at zero tilts",
             bench, turning(random, gyro_positions(random, 14)), truth, ["kII"], starts={"kI": 1.5}, inline=True)


def accelerometer_campaigns():
    def schedule(random, count):
        betas = [0, 45, 90, 180, 270] + [float(b) for b in random.uniform(-180, 360, count).round(3)]
        return [{"position": str(b), "beta_deg": b} for b in betas]

    for seed, y0 in ((11, 0.0), (12, 1.1e-3)):
        random = np.random.default_rng(seed)
        truth = {"kI": 1.299, "dtheta_y0": y0, "V0": -1.9e-3, **tilts(random, ["dtheta_y2", "dtheta_z2"])}
        campaign(f"accelerometer-{seed - 10}", "random beta; dtheta_y0 known", ACC, schedule(random, 9), truth,
                 ["kI", "dtheta_y0"], units={"kI": "V/g"})
    random = np.random.default_rng(13)
    truth = {"dtheta_y0": 1.1e-3, "dtheta_z2": -1.6e-3, "V0": 2.5e-3, "kI": 1.299, "dtheta_y2": 1.9e-3}
    campaign("accelerometer-scale-factor", "kI from start 1 against a known dtheta_z2, dtheta_y0 known", ACC,
             schedule(random, 9), truth, ["dtheta_y0", "dtheta_z2"], starts={"kI": 1.0})
    random = np.random.default_rng(14)
    truth = {"kI": 1.299, "V0": 2.5e-3, "dtheta_y0": 4e-4, "dtheta_y2": 1.9e-3, "dtheta_z2": -3e-4}
    campaign("accelerometer-rank-defect", "only V0 - kI*dtheta_y0 is estimable: a shift of dtheta_y0 by 1 equals one of V0 by -1.299",
             ACC, schedule(random, 9), truth, ["kI"], expected_rank=3)

    random = np.random.default_rng(15)
    bench = copy.deepcopy(ACC)
    bench.update({"id": "accelerometer-tilting", "title": "The plumb plane on a tilting head, warm-up drift in the model line"})
    bench["chain"].insert(0, {"joint": "theta", "about": "y"})
    bench["sensors"]["V"]["model"] = "V0 + kI*a_I + kII*a_I^2 + D*exp(-time_s/tau)"
    angles = [(float(t), float(b)) for t, b in random.uniform(-180, 180, (24, 2)).round(2)]
    timed = [{"position": str(i), "theta_deg": t, "beta_deg": b, "time_s": 60.0 + 150 * i} for i, (t, b) in enumerate(angles)]
    truth = {"dtheta_y0": 3e-4, "V0": 2.5e-3, "kI": 1.299, "kII": 4e-5, "D": 3.3e-3, "tau": 870.0,
             "dtheta_y2": 1.9e-3, "dtheta_z2": -3e-4}
    campaign("accelerometer-warm-up", "nonlinear in tau through the column time_s, from start; two joints, both at rest", bench,
             timed, truth, ["dtheta_y0"], starts={"kI": 1.25, "D": 1e-3, "tau": 600.0}, inline=True)

    bench = copy.deepcopy(bench)
    bench.update({"id": "accelerometer-temperature", "title": "The tilting head, temperature and time in the model line"})
    bench["sensors"]["V"]["model"] = "V0 + V0T*(temperature_c - 25) + kI*(1 + kT*(temperature_c - 25))*a_I + drift*time_s"
    warm = [{**r, "temperature_c": float(t)} for r, t in zip(timed, random.uniform(10, 50, 24).round(2))]
    truth = {"dtheta_y0": 3e-4, "V0": 2.5e-3, "V0T": 1.1e-5, "kI": 1.299, "kT": -4.5e-5, "drift": 2.2e-8,
             "dtheta_y2": 1.9e-3, "dtheta_z2": -3e-4}
    campaign("accelerometer-temperature", "columns temperature_c and time_s in the model line; kI*kT nonlinear, from start", bench,
             warm, truth, ["dtheta_y0"], starts={"kI": 1.25}, inline=True)


def imu_campaign():
    random = np.random.default_rng(21)
    chain = [{"joint": "outer", "about": "z"}, {"tilt": "nu_y", "about": "y", "is": "middle axis against square to the outer, about y"},
             {"joint": "middle", "about": "x"}, {"tilt": "nu_z", "about": "z", "is": "inner axis against square to the middle, about z"},
             {"joint": "inner", "about": "y"}, {"tilt": "mu_x", "about": "x", "is": "IMU against the inner axis, about x"},
             {"tilt": "mu_y", "about": "y", "is": "IMU against the inner axis, about y"},
             {"tilt": "mu_z", "about": "z", "is": "IMU against the inner axis, about z"}]
    diagonal = float(np.sqrt(0.5))
    axes = {"x": {"I": "x", "P": "y", "Q": "z"}, "y": {"I": "y", "P": "z", "Q": "x"},
            "z": {"I": [0, -diagonal, diagonal], "P": [1, 0, 0], "Q": [0, diagonal, diagonal]}}
    bench = {"id": "imu-three-axis", "title": "A six-sensor IMU on a three-axis table, its third pair of sensors skewed by 45 deg",
             "source": "none: made for the tests", "site": {"latitude_deg": 45.75}, "units": {"rate": "deg/h", "force": "g"},
             "chain": chain, "sensors": {}}
    known = {"nu_y": 4e-4, "mu_x": -7e-4, "mu_y": 1.2e-3, "mu_z": 9e-4}
    truth, starts = dict(known), {}
    truth["nu_z"] = -8e-4
    for kind, offset, input_ in (("G", 5.0, "w"), ("A", 3e-3, "a")):
        for x in "xyz":
            terms = [f"S{kind}{x}*{input_}_I", f"P{kind}{x}*{input_}_P", f"Q{kind}{x}*{input_}_Q"]
            extra = [f"D{x}*a_I"] if kind == "G" else [f"K{x}*a_I^2"]
            bench["sensors"][kind + x] = {"unit": "deg/h" if kind == "G" else "g", "axes": axes[x],
                                         "model": " + ".join([f"B{kind}{x}", *terms, *extra])}
            truth.update({f"B{kind}{x}": float(random.normal(0, offset)), f"S{kind}{x}": 1 + float(random.normal(0, 1e-3)),
                          f"P{kind}{x}": float(random.normal(0, 1e-3)), f"Q{kind}{x}": float(random.normal(0, 1e-3))})
            truth[f"D{x}" if kind == "G" else f"K{x}"] = float(random.normal(0, 0.3 if kind == "G" else 1e-4))
            starts[f"S{kind}{x}"] = 1.0
    still = [{"position": f"s{i}", **dict(zip(("outer_deg", "middle_deg", "inner_deg"), map(float, p))),
              "temperature_c": 25.0} for i, p in enumerate(random.uniform(-180, 180, (18, 3)).round(2))]
    spun = []
    for i in range(9):
        joint = ("outer", "middle", "inner")[i % 3]
        here = dict(zip(("outer_deg", "middle_deg", "inner_deg"), map(float, random.choice([0, 37.5, 90, 180, 270], 3))))
        del here[joint + "_deg"]
        spun += [{"position": f"r{i}", **here, joint + "_deg_s": sign * 10.0 * (1 + i // 3)} for sign in (1, -1)]
    campaign("imu-three-axis", "six sensors with model lines of their own; rates about each of the three axes; whole turns of the "
             "outer, middle or inner joint; table tilts known but nu_z", bench, still + spun, truth, list(known),
             starts=starts, inline=True)


if __name__ == "__main__":
    gyro_campaigns()
    accelerometer_campaigns()
    imu_campaign()
