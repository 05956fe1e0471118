"""Many devices beside peers, one thread each, in one run: python benches/peers/devices.py [DEVICES]

Needs numpy, pyarrow and numba (PyPI), target/release/tumble, and the harness `cargo bench --bench batch --no-run` builds (its path as the
environment variable TUMBLE_BENCH; without it the times in process are left out). 30 readings in 6 unknowns. Prints seconds and ratios;
the times of the program hold its start. Each is the best of three.
"""
import json
import os
import subprocess
import sys
import tempfile
import time

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS", "NUMBA_NUM_THREADS", "ARROW_NUM_THREADS"):
    os.environ[name] = "1"
import numpy as np  # noqa: E402
import pyarrow as pa  # noqa: E402
import pyarrow.parquet as pq  # noqa: E402

pa.set_cpu_count(1)
TUMBLE = os.path.join(os.path.dirname(__file__), "../../target/release/tumble")
N = int(float(sys.argv[1])) if len(sys.argv) > 1 else 100_000
rng = np.random.default_rng(3)
w = np.repeat([-100.0, -50, -20, 20, 50, 100], 5)
a = np.tile([0.0, 0.5, 1, -0.5, -1], 6)
t = rng.permutation(np.tile([20.0, 25, 30, 35, 40], 6))
X = np.c_[np.ones(30), w, w**2 / 1e4, a, t, a * a]
Y = (np.array([0.01, -2.9e-3, 1e-3, 2e-3, 1e-5, 1e-4]) * (1 + 0.01 * rng.standard_normal((N, 6)))) @ X.T
Y += 1e-4 * rng.standard_normal((N, 30))


def best(work, times=3):
    found = []
    for _ in range(times):
        start = time.perf_counter()
        work()
        found.append(time.perf_counter() - start)
    return min(found)


P = np.linalg.pinv(X)
bare = best(lambda: Y @ P.T, 5)
print(f"numpy y @ P.T, estimates alone          {bare:8.4f} s")
few = min(N, 20_000)
stack = np.broadcast_to(X, (few, 30, 6)) * (1 + 0.01 * rng.standard_normal((few, 30, 1)))


def stacked():
    q, r = np.linalg.qr(stack)
    return np.linalg.solve(r, np.einsum("dij,di->dj", q, Y[:few])[..., None])


print(f"numpy stacked QR, own designs           {best(stacked) * N / few:8.4f} s")
with tempfile.TemporaryDirectory() as folder:
    path = os.path.join(folder, "r.parquet")
    columns = {
        "serial": np.repeat([f"S{d:06d}" for d in range(N)], 30),
        "rate": np.tile(w, N),
        "acc": np.tile(a, N),
        "temperature_c": np.tile(t, N),
        "V": Y.ravel(),
    }
    pq.write_table(pa.table(columns), path)
    model = "V0 + k1*rate + k2*rate^2/10000 + ka*acc + kt*temperature_c + kaa*acc^2"
    campaign = {
        "bench": {"id": "line", "sensors": {"V": {"unit": "V", "model": model}}},
        "estimate": {k: {} for k in ["V0", "k1", "k2", "ka", "kt", "kaa"]},
        "by": "serial",
        "readings": "r.parquet",
    }
    with open(os.path.join(folder, "c.campaign.json"), "w") as file:
        json.dump(campaign, file)
    read = best(lambda: pq.read_table(path, use_threads=False))
    print(f"pyarrow reads the file                  {read:8.4f} s")

    def program(to):
        subprocess.run([TUMBLE, "fit", "c.campaign.json", "--to", to], cwd=folder, check=True, stdout=subprocess.DEVNULL)

    for to in ("d.parquet", "d.csv"):
        whole = best(lambda: program(to))
        print(f"tumble fit --to {to:<12}            {whole:8.4f} s = {whole / read:.2f} times reading")
    table = pq.read_table(os.path.join(folder, "d.parquet"))
    error = np.abs(table["k1"].to_numpy() - (Y @ P.T)[:, 1]).max() / 2.9e-3
    print(f"largest difference to numpy in k1       {error:8.1e} relative")
if harness := os.environ.get("TUMBLE_BENCH"):
    subprocess.run([harness, "--bench", "devices"], check=True)
