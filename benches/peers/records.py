"""Reading records and Allan deviations beside peers, one thread each, in one run: python benches/peers/records.py [SAMPLES]

Needs numpy, polars and allantools (PyPI) and target/release/tumble. Prints seconds and ratios; times of the program hold its start.
"""
import os
import subprocess
import sys
import tempfile
import time

os.environ["POLARS_MAX_THREADS"] = "1"
os.environ["OMP_NUM_THREADS"] = "1"
import allantools  # noqa: E402
import numpy as np  # noqa: E402
import polars as pl  # noqa: E402

TUMBLE = os.path.join(os.path.dirname(__file__), "../../target/release/tumble")
count = int(float(sys.argv[1])) if len(sys.argv) > 1 else 10_000_000


def best(work, times=3):
    """Shortest of several runs, in processor seconds of this process and its children."""
    def spent():
        t = os.times()
        return t.user + t.system + t.children_user + t.children_system
    found = []
    for _ in range(times):
        start = spent()
        work()
        found.append(spent() - start)
    return min(found)


with tempfile.TemporaryDirectory() as folder:
    rng = np.random.default_rng(1)
    values = np.round(rng.standard_normal((count, 3)), 5)
    labels = np.repeat([f"P{k}" for k in range(20)], -(-count // 20))[:count]
    frame = pl.DataFrame({"time_s": np.arange(count) / 200.0, "position": labels, **{f"g{k}": values[:, k] for k in range(3)}})
    csv, parquet = os.path.join(folder, "log.csv"), os.path.join(folder, "log.parquet")
    frame.write_csv(csv)
    frame.write_parquet(parquet, compression="snappy")

    def tumble(*arguments):
        subprocess.run([TUMBLE, *arguments], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def grouped(table):
        """What a person writes: number, mean and standard deviation of three channels in each group."""
        own = [f(f"g{k}").alias(f"{name}{k}") for k in range(3) for name, f in (("mean", pl.mean), ("sd", pl.std))]
        return table.group_by("position").agg(pl.len(), *own)

    def compared(name, path, read, scan):
        own = best(lambda: tumble("reduce", path, "--by", "position", "--columns", "g0,g1,g2"))
        line = [f"{name} of {os.path.getsize(path) / 1e6:.0f} MB: tumble reduces by a column in {own:.2f} s"]
        for how, work in (("reads", lambda: read(path)), ("reads, then groups", lambda: grouped(read(path))), ("groups lazily", lambda: grouped(scan(path)).collect())):
            peer = best(work)
            line.append(f"polars {how} {peer:.2f} s (ratio {own / peer:.2f})")
        print("; ".join(line))

    compared("CSV", csv, pl.read_csv, pl.scan_csv)
    compared("Parquet", parquet, pl.read_parquet, pl.scan_parquet)
    y = values[:, 0]
    taus = np.unique(np.round(np.geomspace(1, count / 10, 100))) / 200.0
    peer = best(lambda: allantools.oadev(y, rate=200.0, data_type="freq", taus=taus), 1)
    own = best(lambda: tumble("noise", parquet, "--columns", "g0", "--per-octave", "5"))
    print(f"Allan deviation of {count:.0e} samples at {len(taus)} averaging times: allantools {peer:.2f} s; tumble, with Hadamard and modified, reading and fit, {own:.2f} s; ratio {peer / own:.1f}")
