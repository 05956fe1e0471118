#!/usr/bin/env python3
"""Independent check of the interval of an azimuth `atan2(y, x)` near the origin (tests/fitting/azimuth.rs).

Part 1, tests/data/azimuth/sectors.csv: sectors by brute force. A direction t is kept where the line through the origin along it meets the
ellipse of coverage of the point, |n . m| <= k sqrt(n' S n), n = (-sin t, cos t), looked for on a grid about the point's direction and
bisected; the whole circle where m' S^-1 m <= 2 F(level; 2, nu), with S inverted. Student's quantile by numerical integration.

Part 2, tests/data/azimuth/coverage.csv: Monte Carlo. True points at a distance of r standard uncertainties, 200,000 draws of their
estimate and, for finite degrees of freedom, of its variance: how often the sector holds the true direction, how often it is the circle.

Needs numpy; takes about a minute. Seeded: run anew it writes the same files.
"""

import csv
import math
import pathlib

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent.parent / "data" / "azimuth"


def student(level, nu):
    """Two-sided quantile of Student's t, by bisection on the integral of its density."""
    if math.isinf(nu):
        density = lambda t: np.exp(-0.5 * t * t) / math.sqrt(2 * math.pi)
    else:
        log = math.lgamma((nu + 1) / 2) - math.lgamma(nu / 2) - 0.5 * math.log(nu * math.pi)
        density = lambda t: np.exp(log - (nu + 1) / 2 * np.log1p(t * t / nu))

    nodes, weights = np.polynomial.legendre.leggauss(200)

    def inside(k):
        half = 0.5 * k
        return 2 * half * float(weights @ density(half * (nodes + 1)))

    low, high = 0.0, 100.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if inside(middle) < level else (low, middle)
    return 0.5 * (low + high)


def joint(level, nu):
    """2 F(level; 2, nu), in closed form."""
    return -2 * math.log1p(-level) if math.isinf(nu) else nu * ((1 - level) ** (-2 / nu) - 1)


def sector(x, y, xx, xy, yy, nu, level):
    covariance = np.array([[xx, xy], [xy, yy]])
    m = np.array([x, y])
    if m @ np.linalg.inv(covariance) @ m <= joint(level, nu):
        return None
    k = student(level, nu)

    def kept(t):
        n = np.array([-math.sin(t), math.cos(t)])
        return abs(n @ m) <= k * math.sqrt(n @ covariance @ n)

    value = math.atan2(y, x)

    def end(sign):
        inside, step = value, math.pi / 20000
        while kept(inside + sign * step):
            inside += sign * step
        outside = inside + sign * step
        for _ in range(80):
            middle = 0.5 * (inside + outside)
            inside, outside = (middle, outside) if kept(middle) else (inside, middle)
        return inside

    return end(-1), end(+1)


def sectors():
    rows = []
    for level in (0.95, 0.683, 0.99):
        for nu in (math.inf, 24.0, 5.0):
            for x, y in ((3, 4), (-3, 4), (-3, -0.2), (0.4, -2.9), (0, 5), (-6, 0), (0.3, 0.2)):
                for xx, xy, yy in ((1, 0, 1), (0.25, 0.3, 1), (0.04, -0.09, 0.25)):
                    found = sector(x, y, xx, xy, yy, nu, level)
                    low, high = found if found else ("", "")
                    rows.append([x, y, xx, xy, yy, "inf" if math.isinf(nu) else nu, level, low, high])
    return rows


def coverage(draws, random):
    """Vectorised; round covariance of unit variance, so that a sector is asin(k s/r) about the direction found."""
    rows = []
    for nu in (math.inf, 8.0):
        k, square = student(0.95, nu), joint(0.95, nu)
        for r in (0, 0.5, 1, 1.5, 2, 2.5, 3, 4, 6, 10):
            m = random.standard_normal((draws, 2)) + [r, 0]
            s = np.ones(draws) if math.isinf(nu) else np.sqrt(random.chisquare(nu, draws) / nu)
            distance = np.hypot(m[:, 0], m[:, 1])
            circle = distance**2 <= square * s**2
            off = np.abs(np.arctan2(m[:, 1], m[:, 0]))
            half = np.arcsin(np.minimum(k * s / np.maximum(distance, 1e-300), 1))
            rows.append([r, "inf" if math.isinf(nu) else nu, float(np.mean(circle | (off <= half))), float(np.mean(circle))])
    return rows


def write(name, header, rows):
    HERE.mkdir(exist_ok=True)
    with open(HERE / name, "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(header)
        out.writerows(rows)


write("sectors.csv", ["x", "y", "xx", "xy", "yy", "nu", "level", "low", "high"], sectors())
write("coverage.csv", ["r", "nu", "coverage", "circle"], coverage(200_000, np.random.default_rng(20120)))
