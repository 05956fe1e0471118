"""An exact simulator of rate tables, tilting fixtures and the sensors on them, independent of the program under test.

Computes: readings from a bench (JSON), a schedule (list of readings without sensor values) and a truth {name: value}.

Method: no small angle anywhere. All in 80-bit floats (np.longdouble). Each element of the chain is the active rotation
    Rot(x,t) = [[1,0,0],[0,cos t,-sin t],[0,sin t,cos t]]  and cyclically,
and the ground vectors are carried to the sensor one element at a time, v <- R_i^T v; a joint turning at rate q adds q e_axis
right after (R_i leaves its own axis where it is).
    ground (x east, y north, z up):  Earth rate [0, W cos(lat), W sin(lat)],  specific force at rest [0, 0, g].
    Earth rate 15.041067 deg/h unless site.earth_rate_deg_h says otherwise; g = site.gravity_g, 1 by default;
    in m/s^2 one g is 9.80665 m/s^2.
A tilt with "times" rotates by tilt * factor, the factor a line of algebra in the angles that the joints' encoders show (rad, 0 to 2 pi).
The model line is evaluated by Python itself (^ -> **) and then averaged over the turning joint's angle:
    <joint>_deg_s alone                            one whole turn, 4096 equal steps (exact for trigonometric polynomials up to degree 4095)
    with <joint>_deg and <joint>_turns             from that angle, in the sense of the rate, over that many turns:
                                                   Gauss-Legendre, 32 nodes on every eighth of a turn
    with <joint>_deg and without <joint>_turns     one instant
Inputs of a model line: w_<axis>, a_<axis> of the sensor, w_x .. a_z of the chain's last frame, each joint's name (rad),
every numeric column of the reading (also gamma_deg_s and the like).

Run `python3 tests/scripts/exact_simulator.py` for its self-test; `simulated_campaigns.py` uses it.
"""
import re

import numpy as np

L = np.longdouble
PI = L("3.14159265358979323846264338327950288")
DEG = PI / 180
RATE_PER_DEG_S = {"deg/s": L(1), "deg/h": L(3600), "rad/s": DEG, "arcsec/s": L(3600)}
FORCE_PER_G = {"g": L(1), "m/s^2": L("9.80665")}
AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
FUNCTIONS = {"sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
             "sqrt": np.sqrt, "abs": np.abs, "sign": np.sign, "exp": np.exp, "pi": PI,
             "step": lambda x: np.where(np.asarray(x) >= 0, L(1), L(0))}
NOT_INPUTS = {"position", "n"}
TURN_STEPS = 4096  # equal steps over a whole turn


def carried(axis, angle, v):
    """Rot(axis, angle)^T v, v a list of three arrays."""
    i = "xyz".index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    c, s = np.cos(angle), np.sin(angle)
    out = list(v)
    out[j], out[k] = c * v[j] + s * v[k], c * v[k] - s * v[j]
    return out


def nodes(bench, reading):
    """{joint: angles (rad)}, {joint: rate (bench unit)}, weights that sum to one."""
    angles, rates, weights = {}, {}, np.ones(1, dtype=L)
    for joint in (e["joint"] for e in bench["chain"] if "joint" in e):
        at, rate, turns = (reading.get(joint + end) for end in ("_deg", "_deg_s", "_turns"))
        start = L(at or 0) * DEG
        angles[joint] = np.full(1, start, dtype=L)
        rates[joint] = L(rate or 0) * RATE_PER_DEG_S[bench["units"]["rate"]]
        if rate is None or (at is not None and turns is None):
            continue
        if turns is None and any("times" in e for e in bench["chain"]):
            turns = 1  # a tilt that grows with the angle jumps where the turn closes
        if turns is None:
            angles[joint] = start + 2 * PI * np.arange(TURN_STEPS, dtype=L) / TURN_STEPS
            weights = np.full(TURN_STEPS, L(1) / TURN_STEPS, dtype=L)
        else:
            x, w = np.polynomial.legendre.leggauss(32)
            x, w = polished_legendre(x)
            pieces = int(np.ceil(abs(turns) * 8))
            span = np.sign(L(rate)) * L(turns) * 2 * PI
            fraction = ((x[None, :] + 1) / 2 + np.arange(pieces, dtype=L)[:, None]) / pieces
            angles[joint] = start + span * fraction.ravel()
            weights = np.tile(w / 2 / pieces, pieces)
    return angles, rates, weights


def polished_legendre(x):
    """Gauss nodes and weights polished from double to long double by Newton steps on P_32."""
    x, n = x.astype(L), len(x)
    for _ in range(3):
        p0, p1 = np.ones_like(x), x
        for k in range(2, n + 1):
            p0, p1 = p1, ((2 * k - 1) * x * p1 - (k - 1) * p0) / L(k)
        slope = n * (x * p1 - p0) / (x * x - 1)
        x = x - p1 / slope
    return x, 2 / ((1 - x * x) * slope * slope)


def inputs(bench, reading, truth):
    """Rate and specific force in the last frame of the chain at every node, the joint angles, the weights."""
    site = bench.get("site", {})
    rate_unit, force_unit = RATE_PER_DEG_S[bench["units"]["rate"]], FORCE_PER_G[bench["units"]["force"]]
    angles, rates, weights = nodes(bench, reading)
    earth = L(str(site.get("earth_rate_deg_h", 15.041067))) / 3600 * rate_unit
    latitude = L(str(site.get("latitude_deg", 0))) * DEG
    w = [np.zeros(1, dtype=L), earth * np.cos(latitude) * np.ones(1, dtype=L), earth * np.sin(latitude) * np.ones(1, dtype=L)]
    a = [np.zeros(1, dtype=L), np.zeros(1, dtype=L), L(str(site.get("gravity_g", 1))) * force_unit * np.ones(1, dtype=L)]
    for element in bench["chain"]:
        joint = element.get("joint")
        angle = angles[joint] if joint else L(truth.get(element["tilt"], 0))
        if not joint and "times" in element:
            shown = {name: own % (2 * PI) for name, own in angles.items()}
            angle = angle * eval(element["times"].replace("^", "**"), {"__builtins__": {}}, {**FUNCTIONS, **shown})
        w, a = carried(element["about"], angle, w), carried(element["about"], angle, a)
        if joint:
            i = "xyz".index(element["about"])
            w[i] = w[i] + rates[joint]
    return w, a, angles, weights


def read_sensor(bench, name, reading, truth):
    """The mean of the model line: what sensor `name` would show at this reading."""
    sensor = bench["sensors"][name]
    known = dict(FUNCTIONS)
    known.update({n: L(0) for n in re.findall(r"[A-Za-z_]\w*", sensor["model"]) if n not in FUNCTIONS})
    known.update({k: L(v) for k, v in truth.items()})
    known.update({k: L(v) for k, v in reading.items() if isinstance(v, (int, float)) and k not in NOT_INPUTS})
    weights = np.ones(1, dtype=L)
    if bench.get("chain"):
        w, a, angles, weights = inputs(bench, reading, truth)
        known.update(angles)
        frame = {**AXES, **sensor.get("axes", {})}
        for axis, c in frame.items():
            c = AXES.get(c, c) if isinstance(c, str) else c
            known["w_" + axis] = sum(L(c[i]) * w[i] for i in range(3))
            known["a_" + axis] = sum(L(c[i]) * a[i] for i in range(3))
    value = eval(sensor["model"].replace("^", "**"), {"__builtins__": {}}, known)
    return np.sum(weights * value) if np.ndim(value) and len(value) > 1 else L(np.ravel(value)[0])


def simulate(bench, schedule, truth, sensors=None):
    """The schedule with a value for every sensor (or those a reading lists under "read"), as doubles."""
    filled = []
    for reading in schedule:
        names = reading.get("read", sensors or list(bench["sensors"]))
        clean = {k: v for k, v in reading.items() if k != "read"}
        filled.append({**clean, **{s: float(read_sensor(bench, s, clean, truth)) for s in names}})
    return filled


if __name__ == "__main__":
    from common import read
    bench = read("benches/gyro-turntable.bench.json")
    tilt = {"kI": -2.9222, "dtheta_y2": -162.07 / 3600 * float(DEG)}
    at = {"alpha_deg": 30, "beta_deg": 40, "gamma_deg_s": 20}
    turn = read_sensor(bench, "V", at, tilt)
    eight = [read_sensor(bench, "V", {**at, "gamma_deg": g, "gamma_turns": 0.125}, tilt) for g in range(0, 360, 45)]
    instants = [read_sensor(bench, "V", {**at, "gamma_deg": g}, tilt) for g in range(0, 360, 45)]
    assert abs(turn - np.mean(eight)) < 1e-18 and abs(turn - np.mean(instants)) < 1e-18
    spin = 20 + 15.041067 / 3600 * np.sin(45.75 * np.pi / 180)
    exact = -2.9222 * spin * -np.sin(tilt["dtheta_y2"]) * np.cos(np.pi / 6)
    assert abs(turn - exact) < 1e-15, (turn, exact)
    print("one turn = the mean of its eighths = the mean of eight instants =", float(turn))
