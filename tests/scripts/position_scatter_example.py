"""Readings of examples/20-position-scatter: three accelerometers at 24 positions of a three-axis table whose joints are set to 5 arcsec.

Exact rotations in plain Python; nothing is shared with the program. Run: python3 tests/scripts/position_scatter_example.py
"""
import json
import math
import random

rng = random.Random(2026)
folder = "examples/20-position-scatter/"
arcsec = math.pi / 648000
schedule = json.load(open("examples/10-imu-three-axis-table/schedule.campaign.json"))
positions = schedule["readings"][:24]
truth = {"Kax": 20003.1, "Eaxz": -8.5e-4, "Eaxy": 4.2e-4, "Ax0": 18.9, "Kxx": 0.38,
         "Kay": 19984.6, "Eayx": 2.6e-4, "Eayz": 9.1e-4, "Ay0": -10.5, "Kyy": -0.25,
         "Kaz": 20011.7, "Eazy": -3.3e-4, "Eazx": 6.4e-4, "Az0": 5.2, "Kzz": 0.61}


def turn(axis, angle, v):
    """Rot(axis, angle)' v."""
    c, s = math.cos(angle), math.sin(angle)
    x, y, z = v
    if axis == "x":
        return (x, c * y + s * z, c * z - s * y)
    if axis == "y":
        return (c * x - s * z, y, c * z + s * x)
    return (c * x + s * y, c * y - s * x, z)


readings = []
for position in positions:
    f = (0.0, 0.0, 1.0)
    for joint, axis in (("outer", "z"), ("middle", "x"), ("inner", "y")):
        f = turn(axis, math.radians(position[joint + "_deg"]) + 5 * arcsec * rng.gauss(0, 1), f)
    x, y, z = f
    t = truth
    values = {"Ax": t["Kax"] * (x + t["Eaxz"] * y + t["Eaxy"] * z) + t["Ax0"] + t["Kxx"] * x * x,
              "Ay": t["Kay"] * (y + t["Eayx"] * z + t["Eayz"] * x) + t["Ay0"] + t["Kyy"] * y * y,
              "Az": t["Kaz"] * (z + t["Eazy"] * x + t["Eazx"] * y) + t["Az0"] + t["Kzz"] * z * z}
    reading = dict(position)
    for sensor, value in values.items():
        reading[sensor] = round(value + 0.04 * rng.gauss(0, 1), 3)
        reading[sensor + "_u"] = 0.04
    readings.append(reading)

estimate = {k: ({"start": 20000.0} if k.startswith("Ka") else {}) for k in truth}
scatter = [{"of": ["outer", "middle", "inner"], "per": "position", "u": 5, "unit": "arcsec"}]
for name, lines in (("without", None), ("with", scatter), ("estimated", [dict(scatter[0], u="estimate")])):
    head = {"bench": "imu-three-axis-table", "estimate": estimate}
    if lines:
        head["scatter"] = lines
    text = json.dumps(head, indent=1)[:-2] + ',\n "readings": [\n  ' + ",\n  ".join(json.dumps(r) for r in readings) + "\n ]\n}\n"
    open(f"{folder}{name}.campaign.json", "w").write(text)
json.dump(truth, open(folder + "truth.json", "w"), indent=1)
