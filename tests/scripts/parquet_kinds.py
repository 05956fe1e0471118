#!/usr/bin/env python3
"""Parquet files of kinds that other scripts do not write, by pyarrow: tests/data/records/brotli.parquet (compressed by brotli) and list.parquet (a column of
lists beside one of numbers): row k has t = k/100 s and x = 1 + (7 k mod 5)/64; durations.parquet: k durations of each unit of Arrow and in a structure, and k
as a plain number."""

import pathlib

import pyarrow as pa
import pyarrow.parquet as pq

OUT = pathlib.Path(__file__).parent.parent / "data" / "records"
ROWS = range(100)
plain = {"time_s": [k / 100 for k in ROWS], "x": [1 + (7 * k % 5) / 64 for k in ROWS]}
pq.write_table(pa.table(plain), OUT / "brotli.parquet", compression="brotli")
units = {f"t_{unit}": pa.array(ROWS, pa.duration(unit)) for unit in ("s", "ms", "us", "ns")}
inner = pa.array([{"d": k} for k in ROWS], pa.struct([("d", pa.duration("ms"))]))
pq.write_table(pa.table(units | {"plain": pa.array(ROWS, pa.int64()), "in": inner}), OUT / "durations.parquet")
pq.write_table(pa.table(plain | {"v": [[float(k), 2.0] for k in ROWS]}), OUT / "list.parquet")
