"""Jobs whose model lines multiply unknowns, with nothing stated to start from: tests/data/bilinear/NAME.campaign.json and NAME.truth.json.

Readings come from exact_simulator.py (80-bit floats, no small angles) plus seeded normal noise. The truth file holds
    truth      every value the simulator used
    estimated  the names the campaign asks for, in its order
    fitted     values, standard uncertainties and residual standard deviation of an independent fit: scipy's Levenberg-Marquardt
               (MINPACK) on the simulator itself, started at the truth, derivatives by central differences in 80-bit floats
Run: python3 tests/scripts/bilinear_campaigns.py   (deterministic)
"""
import numpy as np
from scipy.optimize import least_squares

import exact_simulator
from common import read, write
from exact_simulator import L, read_sensor, simulate

exact_simulator.TURN_STEPS = 64  # every line here is of degree 3 at most in the turning angle
ARCSEC = float(np.pi / 648000)

# input axis x; the fixture brings it along the spin axis (phi = 90, 270) and across it (phi = 0, 180)
FIXTURE = {
    "id": "gyro-on-a-fixture", "title": "Gyro on a rate table, brought along and across the spin axis by a fixture",
    "site": {"latitude_deg": 45.75}, "units": {"rate": "deg/s", "force": "g"},
    "chain": [{"joint": "gamma", "about": "z"}, {"joint": "phi", "about": "y"}, {"joint": "alpha", "about": "x"},
              {"tilt": "mount_x", "about": "x", "is": "gyro case on the fixture, about x"},
              {"tilt": "mount_y", "about": "y", "is": "gyro case on the fixture, about y"},
              {"tilt": "mount_z", "about": "z", "is": "gyro case on the fixture, about z"}],
    "sensors": {"V": {"unit": "V", "axes": {"I": "x", "S": "y", "O": "z"}, "model": "V0 + kI*w_I"}}}

# the same with a cross-coupling that makes the turn about the input axis matter
CROSS = {**FIXTURE, "id": "gyro-with-cross-coupling",
         "sensors": {"V": {"unit": "V", "axes": {"I": "x", "S": "y", "O": "z"}, "model": "V0 + kI*(w_I + c*w_S)"}}}

TRIAD = {
    "id": "three-gyros", "title": "Three gyros on one block", "site": {"latitude_deg": 45.75},
    "units": {"rate": "deg/s", "force": "g"},
    "chain": [{"joint": "gamma", "about": "z"}, {"joint": "phi", "about": "y"}, {"joint": "alpha", "about": "x"}],
    "sensors": {f"G{a}": {"unit": "pulse/s", "model": f"K{a}*(w_{a} + E{a}{b}*w_{b} + E{a}{c}*w_{c}) + D{a}"}
                for a, b, c in ("xyz", "yzx", "zxy")}}


def schedule(rates, positions):
    return [{"position": f"phi {p}, alpha {a}", "phi_deg": p, "alpha_deg": a, "gamma_deg_s": r}
            for p, a in positions for r in rates]


def job(name, note, bench, positions, truth, noise, seed, derived=None, not_estimable=(), known=()):
    random = np.random.default_rng(seed)
    readings = simulate(bench, positions, truth)
    for reading in readings:
        for sensor in bench["sensors"]:
            reading[sensor] = float(f"{reading[sensor] + noise * random.standard_normal():.9g}")
    names = [n for n in truth if n not in not_estimable and n not in known]
    pairs = [(r, s) for r in readings for s in bench["sensors"]]

    def predict(x):
        values = {**truth, **dict(zip(names, x))}
        return np.array([float(read_sensor(bench, s, r, values)) for r, s in pairs])

    def jacobian(x):
        columns = []
        for k in range(len(x)):
            h = 1e-6 * max(abs(x[k]), 1e-3)
            up, down = ({**truth, **dict(zip(names, x)), names[k]: L(x[k]) + L(d)} for d in (h, -h))
            columns.append([float((read_sensor(bench, s, r, up) - read_sensor(bench, s, r, down)) / (2 * L(h))) for r, s in pairs])
        return np.array(columns).T

    observed = np.array([r[s] for r, s in pairs])
    found = least_squares(lambda x: predict(x) - observed, [float(truth[n]) for n in names], jacobian, method="lm",
                          x_scale="jac", xtol=1e-15, ftol=1e-15, gtol=1e-15)
    rows = jacobian(found.x)
    dof = len(observed) - len(names)
    sd = float(np.sqrt(np.sum(found.fun ** 2) / dof))
    scale = np.linalg.norm(rows, axis=0)
    _, r = np.linalg.qr(rows / scale)
    u = sd * np.linalg.norm(np.linalg.inv(r), axis=1) / scale
    print(name, len(observed), "readings", len(names), "unknowns, residual sd", sd,
          {n: f"{(v - truth[n]) / s:+.2f} u" for n, v, s in zip(names, found.x, u)})
    estimate = {n: {} for n in truth if n not in known}
    write(f"bilinear/{name}.campaign.json", {"bench": bench if isinstance(bench, dict) and bench["id"] != "gyro-turntable" else "gyro-turntable",
          "estimate": estimate, **({"known": {n: {"value": truth[n]} for n in known}} if known else {}), **({"derived": derived} if derived else {}), "readings": readings})
    write(f"bilinear/{name}.truth.json", {"note": note, "truth": truth, "estimated": list(estimate), "fitted": {
        "residual_sd": sd, "values": {n: {"value": float(v), "u": float(s)} for n, v, s in zip(names, found.x, u)}}})


# at a scale factor of zero the readings respond to the tilts through the small known terms alone
SMALL_TERMS = {
    "id": "accelerometer-with-small-terms", "title": "Accelerometer on a two-axis head, small cross terms known",
    "units": {"rate": "deg/s", "force": "g"},
    "chain": [{"tilt": "base", "about": "y"}, {"joint": "phi", "about": "y"}, {"joint": "alpha", "about": "x"}, {"tilt": "mount", "about": "y"}],
    "sensors": {"V": {"unit": "mV", "axes": {"I": "x", "S": "z", "O": "y"}, "model": "b + k*a_I + kx*a_I*a_S + ky*a_O"}}}


ALL_ROUND = [(0, 0), (0, 90), (0, 180), (0, 270), (90, 0), (90, 90), (90, 180), (90, 270), (180, 0), (180, 90), (270, 0), (270, 180)]
if __name__ == "__main__":
    tilts = {"mount_y": 120 * ARCSEC, "mount_z": -340 * ARCSEC}
    job("gyro-scale-and-mounting", "scale factor, zero offset and mounting tilts of one gyro, nothing to start from",
        FIXTURE, schedule((20, -20, 50, -50), ALL_ROUND), {"kI": -2.9222, "V0": 1.3e-3, **tilts}, 2e-3, 11)
    job("gyro-tilts-first", "the same, the tilts asked for first and twenty times as large",
        FIXTURE, schedule((20, -20, 50, -50), ALL_ROUND),
        {"mount_z": -0.075, "mount_y": 0.11, "V0": -0.4, "kI": 0.0375}, 4e-5, 12)
    job("gyro-cross-coupling", "a product of three unknowns: mount_x shows only through a cross-coupling that the start does not know",
        CROSS, schedule((20, -20, 50, -50), ALL_ROUND), {"mount_x": 0.02, "c": 0.08, "kI": 12.5, "V0": 0.02}, 1e-3, 13)
    random = np.random.default_rng(14)
    triad = {}
    for a, b, c in ("xyz", "yzx", "zxy"):
        triad.update({f"K{a}": 7200 + float(random.normal(0, 5)), f"E{a}{b}": float(random.normal(0, 1e-3)),
                      f"E{a}{c}": float(random.normal(0, 1e-3)), f"D{a}": float(random.normal(0, 3))})
    job("three-gyros", "scale factors, installation errors and zero offsets of a triad, nothing to start from",
        TRIAD, schedule((10, -10, 60, -60), ALL_ROUND), triad, 0.5, 14)
    # the input axis never leaves the plane across the spin axis: only products of kI with tilts show
    tilts = {"dtheta_y0": -7.5 * ARCSEC, "dtheta_x0": 200 * ARCSEC, "dtheta_y1": -54 * ARCSEC, "dtheta_y2": -162 * ARCSEC, "dtheta_z2": 56 * ARCSEC}
    names = list(tilts)
    job("gyro-turntable-scale-unknown", "every reading is a product of kI with a tilt: only the products are determined",
        read("benches/gyro-turntable.bench.json"),
        [{"alpha_deg": a, "beta_deg": b, "gamma_deg_s": r} for a, b in
         [(0, 0), (0, 90), (0, 180), (0, 270), (90, 0), (90, 90), (180, 90), (180, 180), (270, 270), (90, 180)] for r in (20, -20, 50, -50)],
        {"kI": -2.9222, "V0": 1.6e-3, **tilts}, 2e-4, 15, derived={f"p_{n}": f"kI*{n}" for n in names}, not_estimable=("kI",))
    # few settings: the first step, by the small terms alone, would go to tilts of many degrees
    for name, seed in (("accelerometer-small-terms", 42), ("accelerometer-few-positions", 112)):
        random = np.random.default_rng(seed)
        settings = [(float(random.integers(0, 4) * 90), float(random.integers(0, 12) * 30)) for _ in range(6)]
        job(name, "nothing known of the scale factor, small cross terms known", SMALL_TERMS,
            [{"phi_deg": p, "alpha_deg": a} for p, a in settings for _ in range(3)],
            {"base": -18 * ARCSEC, "mount": 200 * ARCSEC, "b": 5.3e-4, "k": -0.0861, "kx": 2.5e-5, "ky": -4e-5}, 5e-7, seed,
            known=("kx", "ky"))
