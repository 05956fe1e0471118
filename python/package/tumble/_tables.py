"""Tables of readings and samples, whatever holds them; tables of results."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from . import _tumble

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow

Table = Any
"""A pandas or polars DataFrame, anything with Arrow's `__arrow_c_stream__` (a pyarrow Table, a DuckDB relation), a dict of columns, a structured
numpy array, or a list of dicts. An empty cell (None, NaN) is a reading that was not made."""

Columns = Mapping[str, Any]


def columns_of(table: Table) -> Any:
    """A table as the engine takes it: an Arrow stream as it is (read where it lies), else a dict of columns (buffers or lists)."""
    package = type(table).__module__.partition(".")[0]
    if package == "polars" and hasattr(table, "collect"):
        table = table.collect()
    if package != "pandas" and hasattr(table, "__arrow_c_stream__"):
        return table
    if package == "pandas":
        return {str(name): column_of(table[name]) for name in table.columns}
    if isinstance(table, Mapping):
        return {str(name): column_of(column) for name, column in table.items()}
    if isinstance(table, np.ndarray) and table.dtype.names:
        return {name: column_of(table[name]) for name in table.dtype.names}
    if isinstance(table, Sequence) and not isinstance(table, (str, bytes)):
        keys = list(dict.fromkeys(key for row in table for key in row))
        return {str(key): [row.get(key) for row in table] for key in keys}
    raise TypeError(f"{type(table).__name__} is no table: expected a DataFrame, an Arrow table, a dict of columns, a structured array or rows")


def column_of(column: Any) -> Any:
    """A column as a buffer of numbers, or as a list in which None is an empty cell."""
    package = type(column).__module__.partition(".")[0]
    if package == "pandas":
        if column.dtype.kind in "fiu" and hasattr(column.dtype, "itemsize") and not column.hasnans:
            return np.asarray(column)
        return [None if empty else value for value, empty in zip(column.tolist(), column.isna())]
    if package == "polars":
        return column.to_numpy() if column.dtype.is_numeric() and not column.null_count() else column.to_list()
    if package == "pyarrow":
        return column.to_pylist()
    if isinstance(column, np.ndarray):
        if column.dtype.kind == "f" and column.dtype.itemsize not in (4, 8):
            return column.astype(np.float64)
        return column.tolist() if column.dtype.kind not in "fiu" else np.asarray(column, column.dtype.newbyteorder("="))
    return column


def rows_of(table: Table) -> list[dict[str, Any]]:
    """A table as a list of rows."""
    columns = columns_of(table)
    if not isinstance(columns, Mapping):
        import pyarrow

        columns = pyarrow.table(columns).to_pydict()
    lists = [column.tolist() if hasattr(column, "tolist") else list(column) for column in columns.values()]
    return [dict(zip(columns, row)) for row in zip(*lists, strict=True)]


def write(table: Table, folder: str, name: str) -> str:
    """A table as a file that the program reads; its path."""
    if type(table).__module__.partition(".")[0] == "polars" and hasattr(table, "write_parquet"):
        path = os.path.join(folder, f"{name}.parquet")
        table.write_parquet(path)
        return path
    path = os.path.join(folder, f"{name}.csv")
    _tumble.write_csv(columns_of(table), Path(path))
    return path


def is_table(value: Any) -> bool:
    """Is this a table, and no path?"""
    return not isinstance(value, (str, os.PathLike))


def read_like(table: Table, path: str) -> Any:
    """A table of CSV as the kind of table that the other one is; a dict of numpy arrays where that is none of pandas, polars, pyarrow."""
    package = type(table).__module__.partition(".")[0]
    if package == "pandas":
        import pandas

        if int(pandas.__version__.partition(".")[0]) < 3:
            return pandas.read_csv(path, float_precision="round_trip")
        return pandas.read_csv(path)
    if package == "polars":
        import polars

        return polars.read_csv(path, infer_schema_length=None)
    if package == "pyarrow":
        import pyarrow.csv

        return pyarrow.csv.read_csv(path)
    import csv

    with open(path, encoding="utf-8", newline="") as file:
        lines = list(csv.reader(file))
    names, rows = lines[0], lines[1:]
    return {name: _cells([row[k] for row in rows]) for k, name in enumerate(names)}


def _cells(texts: list[str]) -> Any:
    try:
        return np.array([float(text) if text else float("nan") for text in texts])
    except ValueError:
        return np.array(texts, dtype=object)


class Frames:
    """What has columns, and gives them to the libraries of tables. Numbers that do not exist are NaN (null in polars and pyarrow)."""

    def _columns(self) -> dict[str, Any]:
        raise NotImplementedError

    def to_pandas(self) -> "pandas.DataFrame":
        """As a pandas DataFrame."""
        import pandas

        return pandas.DataFrame(self._columns())

    def to_polars(self) -> "polars.DataFrame":
        """As a polars DataFrame."""
        import polars

        return polars.DataFrame(self._columns(), nan_to_null=True)

    def to_arrow(self) -> "pyarrow.Table":
        """As a pyarrow Table."""
        import pyarrow

        def array(column: Any) -> Any:
            numbers = isinstance(column, np.ndarray) and column.dtype.kind == "f"
            return pyarrow.array(column, from_pandas=True) if numbers else pyarrow.array(column)

        return pyarrow.table({name: array(column) for name, column in self._columns().items()})


Path_ = Union[str, "os.PathLike[str]"]
