"""The small-angle rows of Li, Ren, Zhao 2012, eqs. (4) and (10)-(13), from the exact chain: tests/data/li2012/rows.json.

Method: sympy multiplies out the exact chain with symbols for every tilt, differentiates it, and sets the tilts to zero:
no truncation, no step size. Earth rate 0 (then nothing depends on gamma, and the mean over a turn is the line itself).
mpmath repeats it with central differences at 50 digits as a check, there with the mean over 8 angles of the turn.

The algebra that must fall out (q the table's rate, kI in V per unit of q, tilts in rad):
  gyro           V = V0 + kI*w_I,  w_I = q * ( -dtheta_y0*cos(beta) + dtheta_x0*sin(beta) - dtheta_y1
                                               - dtheta_y2*cos(alpha) + dtheta_z2*sin(alpha) )
                 and no dtheta_z1 at first order. With the Earth rate on, the mean over a turn is the same with
                 q + W*sin(latitude) for q: the horizontal part averages out.
  accelerometer  V = V0 + kI*a_I,  a_I = -dtheta_y0 - dtheta_y2*cos(beta) + dtheta_z2*sin(beta)
                 so that V0 - kI*dtheta_y0 is all that is seen of V0 and dtheta_y0, and d V / d kI = 0 at zero tilts.
                 (The exact form: a_I = -sin(y0)*cos(y2)*cos(z2) + cos(y0)*(sin(z2)*sin(beta) - sin(y2)*cos(z2)*cos(beta)).)

Run: python3 tests/scripts/li2012_rows.py
"""
import mpmath
import sympy as sp

from common import read, write

GYRO_NAMES = ["V0", "dtheta_y0", "dtheta_x0", "dtheta_y1", "dtheta_z1", "dtheta_y2", "dtheta_z2"]
ACC_NAMES = ["V0", "kI", "dtheta_y0", "dtheta_y2", "dtheta_z2"]


def rotation(axis, t, sin, cos):
    i = "xyz".index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    m = [[0] * 3 for _ in range(3)]
    m[i][i], m[j][j], m[k][k], m[j][k], m[k][j] = 1, cos(t), cos(t), -sin(t), sin(t)
    return m


def input_axis_in(chain, angles, sin, cos):
    """The third component of the sensor's x axis, carried up through `chain` (a list of bench elements)."""
    v = [1, 0, 0]
    for e in reversed(chain):
        m = rotation(e["about"], angles[e.get("joint") or e["tilt"]], sin, cos)
        v = [sum(m[i][j] * v[j] for j in range(3)) for i in range(3)]
    return v[2]


def symbolic_rows(bench, names, positions, gain):
    """Rows d V / d names for V = V0 + kI*(third component of the input axis)*gain(position)."""
    chain = [e for e in bench["chain"] if e.get("joint") != "gamma"]  # gamma turns about the third axis itself
    symbols = {e.get("joint") or e["tilt"]: sp.Symbol(e.get("joint") or e["tilt"]) for e in chain}
    v0, k, g = sp.symbols("V0 kI gain")
    model = v0 + k * g * input_axis_in(chain, symbols, sp.sin, sp.cos)
    of = {"V0": v0, "kI": k, **symbols}
    zero = {s: 0 for name, s in symbols.items() if name.startswith("dtheta")}
    slopes = [sp.diff(model, of[n]).subs(zero) for n in names]
    kI = sp.Rational(-29222, 10000) if "gamma" in str(bench["chain"]) else sp.Rational(1299, 1000)
    rows = []
    for p in positions:
        at = {symbols[j]: sp.pi * p[j + "_deg"] / 180 for j in ("alpha", "beta") if j in symbols}
        rows.append({**p, "row": [float(s.subs({**at, k: kI, g: gain(p)}).evalf(30)) for s in slopes]})
    return rows, [str(sp.simplify(s)) for s in slopes]


def check(bench, names, rows, spin):
    """Central differences of the exact chain at 50 digits."""
    mpmath.mp.dps = 50
    kI = mpmath.mpf("-2.9222") if spin else mpmath.mpf("1.299")
    h = mpmath.mpf("1e-15")

    def model(p, values):
        total = mpmath.mpf(0)
        for gamma in range(8):
            angles = {e.get("joint") or e["tilt"]: values.get(e.get("tilt"), mpmath.mpf(0)) for e in bench["chain"]}
            angles.update({j: mpmath.radians(p[j + "_deg"]) for j in ("alpha", "beta") if j + "_deg" in p})
            if spin:
                angles["gamma"] = mpmath.pi * gamma / 4
            total += input_axis_in(bench["chain"], angles, mpmath.sin, mpmath.cos)
        return values.get("V0", 0) + (kI + values.get("kI", 0)) * (p["gamma_deg_s"] if spin else 1) * total / 8

    worst = max(abs((model(r, {n: h}) - model(r, {n: -h})) / (2 * h) - v) for r in rows for n, v in zip(names, r["row"]))
    assert worst < 1e-14, worst
    return float(worst)


if __name__ == "__main__":
    gyro, acc = read("benches/gyro-turntable.bench.json"), read("benches/accelerometer-plumb-plane.bench.json")
    positions = [{"alpha_deg": a, "beta_deg": b, "gamma_deg_s": q}
                 for a in (0, 90, 180, 270) for b in (0, 90, 180, 270) for q in (20, -20)]
    rows, slopes = symbolic_rows(gyro, GYRO_NAMES, positions, lambda p: p["gamma_deg_s"])
    acc_rows, acc_slopes = symbolic_rows(acc, ACC_NAMES, [{"beta_deg": b} for b in range(0, 360, 45)], lambda p: 1)
    print("differences against symbols:", check(gyro, GYRO_NAMES, rows, True), check(acc, ACC_NAMES, acc_rows, False))
    print(dict(zip(GYRO_NAMES, slopes)), dict(zip(ACC_NAMES, acc_slopes)), sep="\n")
    write("li2012/rows.json", {
        "source": "exact derivatives at zero tilts of Li, Ren, Zhao 2012, eqs. (2)-(4) and (10)-(13); Earth rate 0; whole turns",
        "gyro": {"bench": "gyro-turntable", "kI": -2.9222, "order": GYRO_NAMES, "slopes": dict(zip(GYRO_NAMES, slopes)), "rows": rows},
        "accelerometer": {"bench": "accelerometer-plumb-plane", "kI": 1.299, "order": ACC_NAMES,
                          "slopes": dict(zip(ACC_NAMES, acc_slopes)), "rows": acc_rows}})
