#!/usr/bin/env python3
"""1e5 devices x 30 readings x 6 unknowns: `tumble_fit()` beside 28 sums in DuckDB and a batched solution of the normal equations.

    pip install duckdb numpy pyarrow
    cargo build --release && python3 benches/against_duckdb.py target/release/tumble-sql

One thread each, in turns, the best of three. DuckDB's side computes estimates and their u from stated u, and neither rank nor tests; the
program's time is that of the whole process, with reading and writing Parquet. The estimates of both are compared.
"""
import json
import os
import subprocess
import sys
import tempfile
import time

import duckdb
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

DEVICES, READINGS, UNKNOWNS = int(os.environ.get("DEVICES", 100_000)), 30, 6
PROGRAM = sys.argv[1]


def table(path):
    rng = np.random.default_rng(1)
    angle = np.deg2rad(np.arange(READINGS) * 360.0 / READINGS * 7)
    x = np.column_stack([np.cos(angle), np.sin(angle), np.cos(2 * angle), np.sin(2 * angle), np.cos(3 * angle)])
    truth = rng.normal(size=(DEVICES, UNKNOWNS))
    u = np.full((DEVICES, READINGS), 1e-3) * rng.uniform(1, 3, size=(1, READINGS))
    y = truth[:, :1] + truth[:, 1:] @ x.T + u * rng.normal(size=u.shape)
    columns = {"serial": np.repeat(np.arange(DEVICES), READINGS)}
    columns |= {f"x{k + 1}": np.tile(x[:, k], DEVICES) for k in range(5)}
    columns |= {"y": y.ravel(), "y_u": u.ravel()}
    pq.write_table(pa.table(columns), path)


def best(of, times=3):
    found = []
    for _ in range(times):
        begun = time.perf_counter()
        result = of()
        found.append(time.perf_counter() - begun)
    return min(found), result


def main():
    with tempfile.TemporaryDirectory() as folder:
        path, out, campaign = (os.path.join(folder, name) for name in ("runs.parquet", "fits.parquet", "line.campaign.json"))
        table(path)
        names = [f"c{k}" for k in range(UNKNOWNS)]
        model = " + ".join(["c0"] + [f"c{k}*x{k}" for k in range(1, UNKNOWNS)])
        with open(campaign, "w") as file:
            json.dump({"bench": {"id": "six", "sensors": {"y": {"model": model}}}, "estimate": {name: {} for name in names}, "readings": []}, file)

        def program():
            sql = f"SELECT serial, tumble_fit() FROM '{path}' GROUP BY serial"
            subprocess.run([PROGRAM, "--campaign", campaign, "--threads", "1", "--to", out, sql], check=True)
            return None

        def sums():
            con = duckdb.connect()
            con.execute("SET threads TO 1")
            column = lambda k: "1.0" if k == 0 else f"x{k}"
            terms = [f"sum({column(i)}*{column(j)}*w) AS a{i}{j}" for i in range(UNKNOWNS) for j in range(i, UNKNOWNS)]
            terms += [f"sum({column(i)}*y*w) AS b{i}" for i in range(UNKNOWNS)] + ["sum(y*y*w) AS yy"]
            assert len(terms) == 28
            query = f"SELECT serial, {', '.join(terms)} FROM (SELECT *, 1/(y_u*y_u) AS w FROM '{path}') GROUP BY serial"
            found = con.execute(query).fetchnumpy()
            normal = np.empty((DEVICES, UNKNOWNS, UNKNOWNS))
            for i in range(UNKNOWNS):
                for j in range(i, UNKNOWNS):
                    normal[:, i, j] = normal[:, j, i] = found[f"a{i}{j}"]
            right = np.column_stack([found[f"b{i}"] for i in range(UNKNOWNS)])
            inverse = np.linalg.inv(normal)
            return found["serial"], np.einsum("kij,kj->ki", inverse, right), np.sqrt(np.einsum("kii->ki", inverse))

        ours, _ = best(program)
        theirs, (serial, estimate, u) = best(sums)
        rows = pq.read_table(out).to_pydict()
        order, other = np.argsort(rows["serial"]), np.argsort(serial)
        worst = max(np.abs(np.asarray(rows[name])[order] - estimate[other, k]).max() for k, name in enumerate(names))
        of_u = max(np.abs(np.asarray(rows[f"{name}_u"])[order] / u[other, k] - 1).max() for k, name in enumerate(names))
        print(f"{DEVICES} devices x {READINGS} readings x {UNKNOWNS} unknowns, one thread, best of 3")
        print(f"tumble-sql, whole program      {ours:6.2f} s")
        print(f"DuckDB, 28 sums, numpy solves  {theirs:6.2f} s")
        print(f"ratio {ours / theirs:.2f}; estimates differ by {worst:.1e} at most, u by {of_u:.1e} relative")


main()
