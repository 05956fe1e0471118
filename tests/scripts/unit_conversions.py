"""Conversions between units by exact fractions and mpmath: tests/data/unit_conversions.json.

Nothing here is shared with the program: each unit is written out in SI units (with the radian and the count as base units) by hand.
Run: python3 tests/scripts/unit_conversions.py
"""
import json
import random

from mpmath import mp, mpf, pi

from common import DATA

mp.dps = 40
DEG = pi / 180
G = mpf("9.80665")

# symbol -> (size, powers of rad, s, m, kg, A, K, count)
UNITS = {
    "V": (1, (0, -3, 2, 1, -1, 0, 0)), "mV": (mpf("1e-3"), (0, -3, 2, 1, -1, 0, 0)), "uV": (mpf("1e-6"), (0, -3, 2, 1, -1, 0, 0)),
    "nA": (mpf("1e-9"), (0, 0, 0, 0, 1, 0, 0)), "ohm": (1, (0, -3, 2, 1, -2, 0, 0)), "kohm": (1000, (0, -3, 2, 1, -2, 0, 0)),
    "LSB": (1, (0, 0, 0, 0, 0, 0, 1)), "counts": (1, (0, 0, 0, 0, 0, 0, 1)), "pulse": (1, (0, 0, 0, 0, 0, 0, 1)),
    "deg": (DEG, (1, 0, 0, 0, 0, 0, 0)), "rad": (1, (1, 0, 0, 0, 0, 0, 0)), "mrad": (mpf("1e-3"), (1, 0, 0, 0, 0, 0, 0)),
    "urad": (mpf("1e-6"), (1, 0, 0, 0, 0, 0, 0)), "arcmin": (DEG / 60, (1, 0, 0, 0, 0, 0, 0)),
    "arcsec": (DEG / 3600, (1, 0, 0, 0, 0, 0, 0)), "turn": (2 * pi, (1, 0, 0, 0, 0, 0, 0)),
    "s": (1, (0, 1, 0, 0, 0, 0, 0)), "ms": (mpf("1e-3"), (0, 1, 0, 0, 0, 0, 0)), "min": (60, (0, 1, 0, 0, 0, 0, 0)),
    "h": (3600, (0, 1, 0, 0, 0, 0, 0)), "day": (86400, (0, 1, 0, 0, 0, 0, 0)),
    "g": (G, (0, -2, 1, 0, 0, 0, 0)), "mg": (G / 1000, (0, -2, 1, 0, 0, 0, 0)), "ug": (G / 10**6, (0, -2, 1, 0, 0, 0, 0)),
    "m": (1, (0, 0, 1, 0, 0, 0, 0)), "mm": (mpf("1e-3"), (0, 0, 1, 0, 0, 0, 0)), "Gal": (mpf("1e-2"), (0, -2, 1, 0, 0, 0, 0)),
    "mGal": (mpf("1e-5"), (0, -2, 1, 0, 0, 0, 0)), "K": (1, (0, 0, 0, 0, 0, 1, 0)), "degC": (1, (0, 0, 0, 0, 0, 1, 0)),
    "ppm": (mpf("1e-6"), (0, 0, 0, 0, 0, 0, 0)), "%": (mpf("1e-2"), (0, 0, 0, 0, 0, 0, 0)), "1": (1, (0, 0, 0, 0, 0, 0, 0)),
    "Hz": (1, (0, -1, 0, 0, 0, 0, 0)), "kHz": (1000, (0, -1, 0, 0, 0, 0, 0)), "hPa": (100, (0, -2, -1, 1, 0, 0, 0)),
    "mbar": (100, (0, -2, -1, 1, 0, 0, 0)), "uT": (mpf("1e-6"), (0, -2, 0, 1, -1, 0, 0)),
}

# as the field writes them: text, and the same as factors
WRITTEN = {
    "V/(deg/s)": {"V": 1, "deg": -1, "s": 1}, "mV/(rad/s)": {"mV": 1, "rad": -1, "s": 1}, "V/g": {"V": 1, "g": -1},
    "mV/g": {"mV": 1, "g": -1}, "uV/ug": {"uV": 1, "ug": -1}, "V/(m/s^2)": {"V": 1, "m": -1, "s": 2},
    "deg/h": {"deg": 1, "h": -1}, "arcsec/s": {"arcsec": 1, "s": -1}, "rad/s": {"rad": 1, "s": -1}, "turn/min": {"turn": 1, "min": -1},
    "deg/h/g": {"deg": 1, "h": -1, "g": -1}, "arcsec/(s*mg)": {"arcsec": 1, "s": -1, "mg": -1},
    "deg/h/g^2": {"deg": 1, "h": -1, "g": -2}, "ug/g^2": {"ug": 1, "g": -2}, "mg/g^2": {"mg": 1, "g": -2}, "ppm/g": {"ppm": 1, "g": -1},
    "ppm/K": {"ppm": 1, "K": -1}, "%/degC": {"%": 1, "degC": -1}, "1/K": {"K": -1}, "m/s^2": {"m": 1, "s": -2}, "mGal": {"mGal": 1},
    "ug": {"ug": 1}, "g": {"g": 1}, "urad": {"urad": 1}, "arcsec": {"arcsec": 1}, "mrad": {"mrad": 1}, "arcmin": {"arcmin": 1},
    "V/(deg/s)^2": {"V": 1, "deg": -2, "s": 2}, "uV*s^2/arcsec^2": {"uV": 1, "s": 2, "arcsec": -2},
    "deg/sqrt(h)": {"deg": 1, "h": -0.5}, "rad/s/sqrt(Hz)": {"rad": 1, "s": -1, "Hz": -0.5}, "ug/sqrt(Hz)": {"ug": 1, "Hz": -0.5},
    "m/s/h^0.5": {"m": 1, "s": -1, "h": -0.5}, "m/s^2*s^(1/2)": {"m": 1, "s": -1.5}, "LSB/(deg/s)": {"LSB": 1, "deg": -1, "s": 1},
    "counts/(rad/s)": {"counts": 1, "rad": -1, "s": 1}, "pulse/s/g": {"pulse": 1, "s": -1, "g": -1},
    "LSB/(min*mg)": {"LSB": 1, "min": -1, "mg": -1}, "V\u00b7K^-1": {"V": 1, "K": -1}, "mV/\u00b0C": {"mV": 1, "degC": -1},
    "nA/g": {"nA": 1, "g": -1}, "V/ohm/mg": {"V": 1, "ohm": -1, "mg": -1}, "hPa": {"hPa": 1}, "mbar": {"mbar": 1},
    "deg/day": {"deg": 1, "day": -1}, "\u00b5rad/s\u00b2": {"urad": 1, "s": -2}, "deg/min^2": {"deg": 1, "min": -2},
}


def of(factors):
    size, powers = mpf(1), [0.0] * 7
    for name, power in factors.items():
        own, base = UNITS[name]
        size *= mpf(own) ** power
        powers = [a + power * b for a, b in zip(powers, base)]
    return size, powers


random.seed(11)
rows = []
names = list(WRITTEN)
for a in names:
    for b in names:
        (size_a, powers_a), (size_b, powers_b) = of(WRITTEN[a]), of(WRITTEN[b])
        if powers_a == powers_b and a != b:
            rows.append({"from": a, "to": b, "factor": mp.nstr(size_a / size_b, 20)})
        elif powers_a != powers_b and random.random() < 0.1:
            numbers = all(p == 0 for p in powers_a[1:]) and all(p == 0 for p in powers_b[1:])
            if not numbers:
                rows.append({"from": a, "to": b, "factor": None})
(DATA / "unit_conversions.json").write_text("[\n" + ",\n".join(json.dumps(row) for row in rows) + "\n]\n")
print(len(rows), "pairs,", sum(row["factor"] is not None for row in rows), "that convert")
