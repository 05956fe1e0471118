"""The hot paths beside numpy and numba, one thread each, in one run: python benches/peers/hot.py

Needs numpy and numba (PyPI) and the harness that `cargo bench --bench hot --no-run` builds, its path as the environment variable TUMBLE_BENCH.
Every time is the shortest of many. What the peers do is less: no ranks, no tests, no degrees of freedom; the navigator is given its increments.
"""
import os
import subprocess
import time

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[name] = "1"
import numba as nb  # noqa: E402
import numpy as np  # noqa: E402


def best(work, seconds=1.0):
    work()
    begun, shortest, count = time.perf_counter(), np.inf, 1
    while time.perf_counter() - begun < seconds:
        start = time.perf_counter()
        for _ in range(count):
            work()
        spent = time.perf_counter() - start
        shortest = min(shortest, spent / count)
        count = max(1, min(100_000, int(count * 0.02 / max(spent, 1e-7))))
    return shortest


i = np.arange(30)
A = np.stack([np.ones(30)] + [f((i * 0.7 + 0.1) * k) * 30 for k in (1, 2, 3) for f in (np.sin, np.cos)][:5], axis=1)
y = (i * i * 7919 + 13) * 0.618034 % 2.0 - 1.0


def by_hand():
    q, r = np.linalg.qr(A)
    x = np.linalg.solve(r, q.T @ y)
    v = y - A @ x
    inverse = np.linalg.inv(r)
    return x, inverse @ inverse.T * (v @ v / 24)


def folding(k, n):
    block = np.random.default_rng(1).standard_normal((k, n + 1))
    triangle = np.linalg.qr(block, mode="r")

    def work():
        nonlocal triangle
        triangle = np.linalg.qr(np.concatenate([triangle, block]), mode="r")

    return work


@nb.njit(fastmath=False)
def chunked(block, triangle, reflection):
    """Householder with the triangle above, column by column."""
    k, size = block.shape[1], block.shape[0]
    for j in range(size):
        own = block[j]
        squares = 0.0
        for i in range(k):
            squares += own[i] * own[i]
        if squares == 0.0:
            continue
        alpha = triangle[j, j]
        beta = -np.copysign(np.sqrt(alpha * alpha + squares), alpha)
        first = alpha - beta
        scale = 2.0 / (first * first + squares)
        triangle[j, j] = beta
        for l in range(j + 1, size):
            other = block[l]
            along = first * triangle[j, l]
            for i in range(k):
                along += own[i] * other[i]
            along *= scale
            triangle[j, l] -= along * first
            for i in range(k):
                other[i] -= along * own[i]


def numba_folding(k, n, panel=128):
    rows = np.random.default_rng(1).standard_normal((n + 1, k))
    triangle, work = np.zeros((n + 1, n + 1)), np.empty((n + 1, min(k, panel)))

    @nb.njit
    def run(rows, triangle, work):
        for start in range(0, rows.shape[1], work.shape[1]):
            work[:] = rows[:, start:start + work.shape[1]]
            chunked(work, triangle, 0.0)

    return lambda: run(rows, triangle, work)


N = 10_000
rng = np.random.default_rng(3)
w = np.repeat([-100.0, -50, -20, 20, 50, 100], 5)
a, t = np.tile([0.0, 0.5, 1, -0.5, -1], 6), rng.permutation(np.tile([20.0, 25, 30, 35, 40], 6))
X = np.c_[np.ones(30), w, w**2 / 1e4, a, t, a * a]
Y = (np.array([0.01, -2.9e-3, 1e-3, 2e-3, 1e-5, 1e-4]) * (1 + 0.01 * rng.standard_normal((N, 6)))) @ X.T
Y += 1e-4 * rng.standard_normal((N, 30))
P = np.linalg.pinv(X)
few = np.ascontiguousarray(X * (1 + 0.01 * rng.standard_normal((1000, 30, 1))))


def stacked():
    q, r = np.linalg.qr(few)
    return np.linalg.solve(r, np.einsum("dij,di->dj", q, Y[:1000])[..., None])


@nb.njit(fastmath=False)
def reflected(designs, observed, solution, u):
    """Householder of each design with its observations, estimates and uncertainties from the triangle: one system after the other."""
    count, m, n = designs.shape
    work, inverse = np.empty((n + 1, m)), np.zeros((n, n))
    for d in range(count):
        for i in range(m):
            for j in range(n):
                work[j, i] = designs[d, i, j]
            work[n, i] = observed[d, i]
        for k in range(n):
            own = work[k]
            squares = 0.0
            for i in range(k, m):
                squares += own[i] * own[i]
            beta = -np.copysign(np.sqrt(squares), own[k])
            first = own[k] - beta
            scale = 1.0 / (-beta * first)
            own[k] = first
            for j in range(k + 1, n + 1):
                other = work[j]
                along = 0.0
                for i in range(k, m):
                    along += own[i] * other[i]
                along *= scale
                for i in range(k, m):
                    other[i] -= along * own[i]
            own[k] = beta
        rest = 0.0
        for i in range(n, m):
            rest += work[n, i] * work[n, i]
        for j in range(n):
            inverse[j, j] = 1.0 / work[j, j]
            for i in range(j - 1, -1, -1):
                total = 0.0
                for k in range(i + 1, j + 1):
                    total += work[k, i] * inverse[k, j]
                inverse[i, j] = -total * inverse[i, i]
        for i in range(n):
            x, square = 0.0, 0.0
            for k in range(i, n):
                x += inverse[i, k] * work[n, k]
                square += inverse[i, k] * inverse[i, k]
            solution[d, i] = x
            u[d, i] = np.sqrt(square * rest / (m - n))


into = np.empty((1000, 6)), np.empty((1000, 6))


@nb.njit(fastmath=False)
def mechanise(increments, state, step, altitude):
    """Two samples at a time, local level: the same algorithm, one scenario, increments given; terms of latitude evaluated at each step."""
    a, e2, rate = 6378137.0, 0.00669437999014, 7.292115e-5
    q0, q1, q2, q3, east, north, latitude, longitude = state
    b0 = np.zeros(6)
    h = 2 * step
    for k in range(0, increments.shape[0] - 1, 2):
        b1, b2 = increments[k], increments[k + 1]
        p0, p1, p2 = 0.7 * b1[0] - b0[0] / 30, 0.7 * b1[1] - b0[1] / 30, 0.7 * b1[2] - b0[2] / 30
        s0, s1, s2 = 0.7 * b1[3] - b0[3] / 30, 0.7 * b1[4] - b0[4] / 30, 0.7 * b1[5] - b0[5] / 30
        d0, d1, d2 = b2[0] - b1[0], b2[1] - b1[1], b2[2] - b1[2]
        f0, f1, f2 = b2[3] - b1[3], b2[4] - b1[4], b2[5] - b1[5]
        x = b1[0] + b2[0] + p1 * d2 - p2 * d1
        y = b1[1] + b2[1] + p2 * d0 - p0 * d2
        z = b1[2] + b2[2] + p0 * d1 - p1 * d0
        u0 = b1[3] + b2[3] + p1 * f2 - p2 * f1 + s1 * d2 - s2 * d1
        u1 = b1[4] + b2[4] + p2 * f0 - p0 * f2 + s2 * d0 - s0 * d2
        u2 = b1[5] + b2[5] + p0 * f1 - p1 * f0 + s0 * d1 - s1 * d0
        sq = x * x + y * y + z * z
        c1, c2 = 0.5 - sq / 24, 1 / 6 - sq / 120
        t0, t1, t2 = y * u2 - z * u1, z * u0 - x * u2, x * u1 - y * u0
        v0 = u0 + c1 * t0 + c2 * (y * t2 - z * t1)
        v1 = u1 + c1 * t1 + c2 * (z * t0 - x * t2)
        v2 = u2 + c1 * t2 + c2 * (x * t1 - y * t0)
        m0, m1, m2 = 2 * (q2 * v2 - q3 * v1), 2 * (q3 * v0 - q1 * v2), 2 * (q1 * v1 - q2 * v0)
        dx = v0 + q0 * m0 + q2 * m2 - q3 * m1
        dy = v1 + q0 * m1 + q3 * m0 - q1 * m2
        dz = v2 + q0 * m2 + q1 * m1 - q2 * m0
        sine, cosine = np.sin(latitude), np.cos(latitude)
        root = 1 / np.sqrt(1 - e2 * sine * sine)
        rn = a * root + altitude
        rm = a * (1 - e2) * root * root * root + altitude
        em, nm = east + 0.5 * dx, north + 0.5 * dy
        zx, zy = h * nm / rm, h * (em / rn + rate * cosine)
        zz = h * (em / rn * sine / cosine + rate * sine)
        coriolis = zz + h * rate * sine
        east += dx + coriolis * nm - 0.5 * (zy * dz - zz * dy)
        north += dy - coriolis * em - 0.5 * (zz * dx + zx * dz)
        latitude += zx
        longitude += h * em / (rn * cosine)
        si, co = 0.5 - sq / 48 + sq * sq / 3840, 1 - sq / 8 + sq * sq / 384
        w = q0 * co - si * (q1 * x + q2 * y + q3 * z)
        r1 = q1 * co + si * (q0 * x + q2 * z - q3 * y)
        r2 = q2 * co + si * (q0 * y + q3 * x - q1 * z)
        r3 = q3 * co + si * (q0 * z + q1 * y - q2 * x)
        g0, g1, g2 = 0.5 * zx, -0.5 * zy, -0.5 * zz
        q0 = w - g0 * r1 - g1 * r2 - g2 * r3
        q1 = r1 + g0 * w + g1 * r3 - g2 * r2
        q2 = r2 + g1 * w + g2 * r1 - g0 * r3
        q3 = r3 + g2 * w + g0 * r2 - g1 * r1
        length = 1 / np.sqrt(q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3)
        q0, q1, q2, q3 = q0 * length, q1 * length, q2 * length, q3 * length
        b0 = b2
    return q0, q1, q2, q3, east, north, latitude, longitude


steps = 100_000
at = np.arange(steps)[:, None] * 0.01
increments = 0.01 * np.sin(at * np.array([0.9, 0.7, 0.57, 0.9, 0.7, 0.0])) * np.array([0.05, 0.1, 0.03, 0.5, 1.0, 0.0])
increments[:, 5] += 0.0980665
start = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.8, 0.0)
own = {}
for line in subprocess.run([os.environ["TUMBLE_BENCH"]], check=True, capture_output=True, text=True).stdout.splitlines():
    name, seconds = line.split("\t")
    own[name] = float(seconds)
rows = [
    ("fit Table 1", "numpy: QR, solution and covariance of rows as given", best(by_hand), 1),
    ("adjust 30 x 6", "numpy: QR, solution and covariance", best(by_hand), 1),
    ("fold 64 x 6", "numpy: QR of triangle and block", best(folding(64, 6)), 64),
    ("fold 64 x 6", "numba: reflections of columns", best(numba_folding(64, 6)), 64),
    ("fold 4096 x 10", "numba: reflections of columns", best(numba_folding(4096, 10)), 4096),
    ("10000 devices of one schedule", "numpy: y P', estimates alone", best(lambda: Y @ P.T), N),
    ("1000 devices of own schedules", "numpy: stacked QR, estimates alone", best(stacked), 1000),
    ("1000 devices of own schedules", "numba: Householder, estimates and u", best(lambda: reflected(few, Y[:1000], *into)), 1000),
    ("1000 devices of Table 1's model", "numba: Householder, estimates and u, one linear step", best(lambda: reflected(few, Y[:1000], *into)), 1000),
    ("1000 devices that lack readings", "numba: Householder, estimates and u", best(lambda: reflected(few, Y[:1000], *into)), 1000),
    ("navigator 100000 steps x 1", "numba: one scenario, increments given", best(lambda: mechanise(increments, start, 0.01, 0.0)), steps),
    ("navigator 100000 steps x 8", "the same, for each of eight", best(lambda: mechanise(increments, start, 0.01, 0.0)) * 8, 8 * steps),
]
for name, peer, seconds, count in rows:
    if name in own:
        speed = count / own[name] / 1e6
        print(f"{name:30} {own[name] * 1e6:10.2f} us ({speed:8.2f} million/s)   {peer:50} {seconds * 1e6:10.2f} us   ratio {own[name] / seconds:6.2f}")
