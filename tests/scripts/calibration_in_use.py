"""Example 21: an accelerometer triad calibrated twice, and a record to correct; nothing shared with the program but the conventions.

The unit stands on a two-axis head (outer about x, inner about z), readings in LSB of 16384 to 1 g. Between the calibrations the bias of
y moves by 40 LSB and the scale factor of z by 300 ppm; everything else stays. Writes the bench, both campaigns, a record of the unit
tilted by hand, and the specific forces behind it (truth.csv).
"""

import json
import os

import numpy as np

FOLDER = os.path.join(os.path.dirname(__file__), "..", "..", "examples", "21-calibration-in-use")
SENSITIVITY = 16384.0 * np.array([[1.0012, 0.0031, -0.0018], [0.0007, 0.9985, 0.0042], [-0.0026, 0.0011, 1.0004]])
BIAS = np.array([120.0, -85.0, 240.0])
NOISE = 1.5  # LSB, each reading a mean


def rotation(axis, degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    if axis == "x":
        return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def force(outer, inner):
    """Specific force at rest in the sensor frame, g."""
    return (rotation("x", outer) @ rotation("z", inner)).T @ np.array([0.0, 0.0, 1.0])


def write(name, value):
    with open(os.path.join(FOLDER, name), "w", encoding="utf-8") as file:
        if isinstance(value, str):
            file.write(value)
        else:
            json.dump(value, file, indent=1)
            file.write("\n")


def main():
    rng = np.random.default_rng(50)
    sensors = {}
    for i, axis in enumerate("xyz"):
        line = f"b{axis} + " + " + ".join(f"k{axis}{other}*a_{other}" for other in "xyz")
        sensors[f"a{axis}"] = {"unit": "LSB", "model": line}
    bench = {
        "id": "accelerometer-triad",
        "title": "Accelerometer triad on a two-axis head",
        "units": {"rate": "deg/s", "force": "g"},
        "chain": [{"joint": "outer", "about": "x"}, {"joint": "inner", "about": "z"}],
        "sensors": sensors,
    }
    write("triad.bench.json", bench)
    estimate = {name: {} for axis in "xyz" for name in [f"b{axis}"] + [f"k{axis}{o}" for o in "xyz"]}
    after_bias = BIAS + np.array([0.0, 40.0, 0.0])
    after_sensitivity = SENSITIVITY * np.array([[1.0], [1.0], [1.0 + 300e-6]])
    for name, date, bias, sensitivity in [
        ("before", "2025-11-03", BIAS, SENSITIVITY),
        ("after", "2026-11-02", after_bias, after_sensitivity),
    ]:
        readings = []
        for outer in (0, 45, 90, 135, 180, 270):
            for inner in (0, 90, 180, 270):
                values = bias + sensitivity @ force(outer, inner) + NOISE * rng.standard_normal(3)
                row = {"outer_deg": outer, "inner_deg": inner}
                row.update({f"a{axis}": round(float(v), 1) for axis, v in zip("xyz", values)})
                readings.append(row)
        campaign = {
            "bench": "triad.bench.json",
            "unit": {"serial": "T-0417", "type": "triad of accelerometers"},
            "date": date,
            "estimate": estimate,
            "readings": readings,
        }
        write(f"{name}.campaign.json", campaign)
    record, truth = ["time_s,ax,ay,az"], ["time_s,a_x,a_y,a_z"]
    for k in range(8):
        a = force(15.0 * k, 40.0 * k)
        s = BIAS + SENSITIVITY @ a
        record.append(",".join([f"{0.5 * k:.1f}"] + [f"{v:.3f}" for v in s]))
        truth.append(",".join([f"{0.5 * k:.1f}"] + [f"{v:.9f}" for v in a]))
    write("record.csv", "\n".join(record) + "\n")
    write("truth.csv", "\n".join(truth) + "\n")


if __name__ == "__main__":
    main()
