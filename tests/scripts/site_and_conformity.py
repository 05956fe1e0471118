"""Independent numbers for tests/fitting/site.rs and tests/fitting/conformity.rs; run: python3 tests/scripts/site_and_conformity.py

Normal gravity: not Somigliana's formula with a series in the altitude, but the gradient of the exact potential of the WGS 84 level ellipsoid
(Heiskanen and Moritz 1967, equations 2-62, in ellipsoidal coordinates u, beta), differentiated by mpmath.
Probabilities of conformity: Student's t integrated by mpmath.
"""
from mpmath import mp, mpf, atan, cos, diff, gamma, pi, quad, sin, sqrt

mp.dps = 40
a, f, GM, omega = mpf(6378137), 1 / mpf("298.257223563"), mpf("3.986004418e14"), mpf("7.292115e-5")
b = a * (1 - f)
E = sqrt(a * a - b * b)


def q(u):
    return ((1 + 3 * u * u / E**2) * atan(E / u) - 3 * u / E) / 2


def potential(x, z):
    r2 = x * x + z * z - E * E
    u2 = (r2 + sqrt(r2 * r2 + 4 * E * E * z * z)) / 2
    u = sqrt(u2)
    sin2 = z * z / u2
    return GM / E * atan(E / u) + omega**2 * a * a / 2 * q(u) / q(b) * (sin2 - mpf(1) / 3) + omega**2 * x * x / 2


def gravity(latitude_deg, h):
    phi = mpf(latitude_deg) * pi / 180
    e2 = (a * a - b * b) / (a * a)
    n = a / sqrt(1 - e2 * sin(phi) ** 2)
    x, z = (n + h) * cos(phi), (n * (1 - e2) + h) * sin(phi)
    return sqrt(diff(lambda t: potential(t, z), x) ** 2 + diff(lambda t: potential(x, t), z) ** 2)


for latitude, h in [(0, 0), (45, 0), ("45.75", 0), ("45.75", 150), ("52.3", 75), ("-33.9", 1700), (80, 4000)]:
    print("gravity", latitude, h, mp.nstr(gravity(latitude, h), 14))


def t_cdf(x, nu):
    c = gamma((nu + 1) / mpf(2)) / (sqrt(nu * pi) * gamma(nu / mpf(2)))
    return mpf(1) / 2 + quad(lambda s: c * (1 + s * s / nu) ** (-(nu + 1) / mpf(2)), [0, x])


# the line y = a + b x of tests/fitting/conformity.rs
xs, ys = [mpf(k) for k in range(6)], [mpf(v) for v in ("1.02", "2.99", "5.01", "6.98", "9.03", "10.97")]
n = len(xs)
mx, my = sum(xs) / n, sum(ys) / n
sxx = sum((x - mx) ** 2 for x in xs)
slope = sum((x - mx) * (y - my) for x, y in zip(xs, ys)) / sxx
rss = sum((y - my - slope * (x - mx)) ** 2 for x, y in zip(xs, ys))
u = sqrt(rss / (n - 2) / sxx)
print("slope", mp.nstr(slope, 12), "u", mp.nstr(u, 12))
for lower, upper in [("1.98", "2.01"), ("1.9", "2.1"), ("2.0", "2.1"), ("1.9", "1.95")]:
    p = t_cdf((mpf(upper) - slope) / u, n - 2) - t_cdf((mpf(lower) - slope) / u, n - 2)
    print("probability", lower, upper, mp.nstr(p, 12))
t975 = mp.findroot(lambda t: t_cdf(t, n - 2) - mpf("0.975"), 2.8)
print("U", mp.nstr(t975 * u, 10))
