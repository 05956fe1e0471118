"""Reference values of distributions, independent of the crate: mpmath at 60 digits, checked against scipy.

    python3 tests/scripts/quantiles.py > tests/data/quantiles.csv

Every line: function, argument, parameters, value. Arguments are doubles, written so that they come back exactly.
Quantiles are not inverted here: the test asks that the quantile of the exact probability be the argument.
"""

import mpmath as mp
import scipy.stats as st

mp.mp.dps = 60


def normal(z):
    return mp.erfc(mp.mpf(z) / mp.sqrt(2)) / 2


def student(t, nu):
    t, nu = mp.mpf(t), mp.mpf(nu)
    tail = mp.betainc(nu / 2, mp.mpf(1) / 2, 0, nu / (nu + t * t), regularized=True) / 2
    return tail if t >= 0 else 1 - tail


def chi_square(x, nu):
    return mp.gammainc(mp.mpf(nu) / 2, mp.mpf(x) / 2, mp.inf, regularized=True)


def fisher(f, d1, d2):
    f, d1, d2 = mp.mpf(f), mp.mpf(d1), mp.mpf(d2)
    return mp.betainc(d2 / 2, d1 / 2, 0, d2 / (d2 + d1 * f), regularized=True)


def line(name, argument, parameters, value, peer):
    assert abs(value - peer) <= 1e-8 * value or value < mp.mpf("1e-290"), (name, argument, parameters, value, peer)
    parameters = [repr(float(p)) for p in parameters] + [""] * (2 - len(parameters))
    print(",".join([name, repr(float(argument)), *parameters, mp.nstr(value, 17, strip_zeros=False), mp.nstr(1 - value, 17)]))


print("distribution,argument,nu1,nu2,survival,cdf")
for z in [-3.0, -0.1, 0.001, 0.5, 1.0, 1.96, 3.0, 6.0, 10.0, 20.0, 37.0]:
    line("normal", z, [], normal(z), st.norm.sf(z))
for nu in [1, 2, 3.7, 10, 24, 100, 1000, 2999, 3001, 1e4, 1e5, 9e5, 1.1e6, 1e7, 1e8, 1e12]:
    for t in [-2.0, 0.01, 0.7, 1.96, 2.5, 6.0, 13.0, 37.0]:
        if nu > 1e9:
            # The first terms about the normal distribution are exact to 1e-20 there.
            x = mp.mpf(t)
            value = normal(x) + mp.npdf(x) * (x**3 + x) / (4 * mp.mpf(nu))
        else:
            value = student(t, nu)
        line("student_t", t, [nu], value, st.t.sf(t, nu))
for nu in [0.5, 1, 2, 5, 24, 71, 300, 3000, 1e5, 1e6]:
    for ratio in [1e-3, 0.1, 0.5, 0.9, 1.0, 1.1, 2.0, 5.0, 20.0]:
        x = nu * ratio
        value = chi_square(x, nu)
        if value > 1e-300 and 1 - value > 1e-300:
            line("chi_square", x, [nu], value, st.chi2.sf(x, nu))
for d1 in [1, 2, 5, 24, 300]:
    for d2 in [1, 3, 24, 500, 3001, 1e5, 1e7]:
        for f in [0.01, 0.5, 1.0, 1.1, 2.0, 4.0, 30.0, 400.0]:
            value = fisher(f, d1, d2)
            if value > 1e-300 and 1 - value > 1e-300:
                line("fisher_f", f, [d1, d2], value, st.f.sf(f, d1, d2))
