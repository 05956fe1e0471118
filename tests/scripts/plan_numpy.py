"""Fedorov exchange in vectorised numpy: 12 of 1,000 candidates in 8 unknowns, the yardstick of benches/plan.rs.

Same candidates as the bench, same order of trials (best partner of one chosen row at a time), determinants by rank-one updates, every inner
loop over candidates a matrix product. Prints the best time of one start, and log det M of the best of 100 starts.
"""

import time

import numpy as np


def candidates():
    j = np.arange(1000.0)
    a = (j * 0.618034) % 1.0 * 2 * np.pi
    b = (j * 0.754877666) % 1.0 * 2 * np.pi
    one = np.ones_like(a)
    return np.stack(
        [one, np.cos(a), np.sin(a), np.cos(b), np.sin(b), np.cos(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(2 * a)], 1
    )


def start(x, count, rng):
    chosen = list(rng.integers(0, len(x), count))
    while np.linalg.cond(x[chosen]) > 1e8:
        chosen = list(rng.integers(0, len(x), count))
    inverse = np.linalg.inv(x[chosen].T @ x[chosen])
    d = np.einsum("ij,ij->i", x @ inverse, x)
    improved = True
    while improved:
        improved = False
        for at in range(count):
            i = chosen[at]
            w = inverse @ x[i]
            v = x @ w
            ratio = (1 + d) * (1 - d[i]) + v * v
            j = int(np.argmax(ratio))
            if ratio[j] > 1 + 8e-9:
                for row, sign in ((j, 1.0), (i, -1.0)):
                    w = inverse @ x[row]
                    s = sign / (1 + sign * (x[row] @ w))
                    inverse = inverse - s * np.outer(w, w)
                    t = x @ w
                    d = d - s * t * t
                chosen[at] = j
                improved = True
    return sorted(chosen), np.linalg.slogdet(x[chosen].T @ x[chosen])[1]


if __name__ == "__main__":
    x = candidates()
    times, values = [], []
    for seed in range(100):
        rng = np.random.default_rng(seed)
        begin = time.perf_counter()
        chosen, value = start(x, 12, rng)
        times.append(time.perf_counter() - begin)
        values.append(value)
    times.sort()
    print(f"one start: median {1e3 * times[50]:.3f} ms, best {1e3 * times[0]:.3f} ms; best log det M {max(values):.9f}")
