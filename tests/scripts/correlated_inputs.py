"""GUM H.2 by equation (13) from the means of V, I and phi with their correlations: tests/data/gum/h2-correlated.json.

Method: means, standard uncertainties of the means and correlation coefficients of the five sets by numpy; for R, X and Z the partial derivatives
by central differences in complex steps, u^2 = c' U r U c written out as the double sum of equation (13).
Run: python3 tests/scripts/correlated_inputs.py
"""
import numpy as np

from common import write

V = np.array([5.007, 4.994, 5.005, 4.990, 4.999])
I = np.array([19.663e-3, 19.639e-3, 19.640e-3, 19.685e-3, 19.678e-3])
PHI = np.array([1.0456, 1.0438, 1.0468, 1.0428, 1.0433])
data = np.array([V, I, PHI])
x = data.mean(axis=1)
u = data.std(axis=1, ddof=1) / np.sqrt(5)
r = np.corrcoef(data)
lines = {
    "R": lambda v, i, p: v / i * np.cos(p),
    "X": lambda v, i, p: v / i * np.sin(p),
    "Z": lambda v, i, p: v / i,
}
expected = {}
for name, line in lines.items():
    c = []
    for k in range(3):
        step = x.astype(complex)
        step[k] += 1e-30j
        c.append(line(*step).imag / 1e-30)
    variance = sum(c[i] ** 2 * u[i] ** 2 for i in range(3))
    variance += 2 * sum(c[i] * c[j] * u[i] * u[j] * r[i, j] for i in range(3) for j in range(i + 1, 3))
    expected[name] = {"value": float(line(*x)), "u": float(np.sqrt(variance)),
                      "pairs": {f"{i}{j}": float(2 * c[i] * c[j] * u[i] * u[j] * r[i, j]) for i in range(3) for j in range(i + 1, 3)}}
write("gum/h2-correlated.json", {
    "known": {name: {"value": float(x[k]), "u": float(u[k])} for k, name in enumerate(["V", "I", "phi"])},
    "correlations": [["V", "I", float(r[0, 1])], ["V", "phi", float(r[0, 2])], ["I", "phi", float(r[1, 2])]],
    "expected": expected})
