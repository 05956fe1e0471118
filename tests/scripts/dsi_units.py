#!/usr/bin/env python3
"""Names of units in D-SI, checked with PTB's package dsiUnits: tests/data/lab/dsi_units.csv.

Every unit of the program's table that D-SI knows, with its prefixes, and the forms in which units of coefficients, corrections and scale factors
come: a, a/b, a/(b/c), (a/b)/c, a/(b/c)^2, 1/a, a*b. Each name must be accepted by the package without a warning.
"""

import itertools
import pathlib
import warnings

from dsi_unit import DsiUnit

WHOLE = {"deg": r"\degree", "arcmin": r"\arcminute", "arcsec": r"\arcsecond", "min": r"\minute", "h": r"\hour", "day": r"\day",
         "degC": r"\degreecelsius", "%": r"\percent", "ppm": r"\ppm", "kg": r"\kilogram", "cm": r"\centi\metre", "hPa": r"\hecto\pascal"}
PREFIXED = {"V": r"\volt", "A": r"\ampere", "ohm": r"\ohm", "Hz": r"\hertz", "rad": r"\radian", "s": r"\second", "K": r"\kelvin",
            "m": r"\metre", "N": r"\newton", "Pa": r"\pascal", "W": r"\watt", "T": r"\tesla"}
PREFIXES = {"n": r"\nano", "u": r"\micro", "m": r"\milli", "k": r"\kilo", "M": r"\mega"}
SYMBOLS = WHOLE | PREFIXED | {p + s: PREFIXES[p] + PREFIXED[s] for p in PREFIXES for s in PREFIXED}


def name(powers):
    """D-SI for [(symbol, power)]; a power is written where it is not 1 (the package calls \\per deprecated)."""
    total = {}
    for symbol, power in powers:
        total[symbol] = total.get(symbol, 0) + power
        if not total[symbol]:
            del total[symbol]
    return "".join(SYMBOLS[s] + ("" if p == 1 else f"\\tothe{{{p}}}") for s, p in total.items()) or r"\one"


units = {symbol: [(symbol, 1)] for symbol in SYMBOLS}
units |= {f"1/{symbol}": [(symbol, -1)] for symbol in SYMBOLS}
outputs, inputs = ["V", "mV", "uV", "mA", "Hz", "deg/s", "deg/h", "rad/s", "m/s^2", "arcsec", "ppm"], ["deg/s", "deg/h", "rad/s", "arcsec/s", "m/s^2", "degC", "s", "rad"]
split = {"deg/s": [("deg", 1), ("s", -1)], "deg/h": [("deg", 1), ("h", -1)], "rad/s": [("rad", 1), ("s", -1)],
         "arcsec/s": [("arcsec", 1), ("s", -1)], "m/s^2": [("m", 1), ("s", -2)]}
of = lambda unit: split.get(unit, [(unit, 1)])
raised = lambda powers, by: [(symbol, power * by) for symbol, power in powers]
units |= {own: of(own) for own in outputs + inputs if own not in units}
# covariances of results
results = {own: of(own) for own in ["V", "rad", "arcsec", "Hz", "m/s^2"]}
rate, warm = raised(of("deg/s"), -1), [("degC", -1)]
results |= {"V/(deg/s)": of("V") + rate, "V/(deg/s)^2": of("V") + raised(rate, 2), "V/(deg/s)/degC": of("V") + rate + warm,
            "V/degC": of("V") + warm, "V/degC^2": of("V") + raised(warm, 2)}
for (a, first), (b, second) in itertools.product(results.items(), repeat=2):
    units[f"({a})*({b})"] = first + second
units |= {"deg/h/K": of("deg/h") + [("K", -1)], "ppm/K": [("ppm", 1), ("K", -1)]}
for a, b in itertools.product(outputs, inputs):
    units[f"({a})/({b})"] = of(a) + raised(of(b), -1)
    units[f"({b})/({a})"] = of(b) + raised(of(a), -1)
    units[f"({a})*({b})"] = of(a) + of(b)
    for power in (2, 3):
        units[f"({a})/({b})^{power}"] = of(a) + raised(of(b), -power)
    for c in inputs:
        units[f"({a})/({b})/({c})"] = of(a) + raised(of(b), -1) + raised(of(c), -1)

warnings.simplefilter("ignore")  # it warns of "\\per" in "\\percent"
lines = ["unit,d_si"]
for unit, powers in units.items():
    text = name(powers)
    parsed = DsiUnit(text)
    assert parsed.valid and not parsed.warnings, (unit, text, parsed.warnings)
    lines.append(f"{unit},{text}")
target = pathlib.Path(__file__).parent.parent / "data" / "lab" / "dsi_units.csv"
target.write_text("\n".join(lines) + "\n")
print(f"{target}: {len(lines) - 1} units")
