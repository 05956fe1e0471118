"""Tables of readings and samples, whatever holds them; tables of results."""

from __future__ import annotations

import csv
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
numpy array, or a list of dicts. An empty cell (None, NaN, NaT, pandas' NA, a masked one) is a reading that was not made. Times (datetime64, datetime) are
seconds since the first where numbers are wanted, and their ISO 8601 (in UTC) where labels are; durations are seconds."""

Columns = Mapping[str, Any]


def package_of(table: Table) -> str:
    """The package that a table is of."""
    return type(table).__module__.partition(".")[0]


def columns_of(table: Table) -> Any:
    """A table as the engine takes it: an Arrow stream, else a dict of columns (buffers or lists)."""
    package = package_of(table)
    if package == "polars" and hasattr(table, "collect"):
        table = table.collect()
    if package == "polars" and hasattr(table, "columns"):
        # types that others cannot read: polars gives a column of nothing a buffer, and whole numbers of 128 bits a type of its own
        import polars

        own = [getattr(polars, name, polars.Null) for name in ("Null", "Int128", "UInt128")]
        return table.cast(dict.fromkeys(own, polars.String))
    if package not in ("pandas", "polars") and hasattr(table, "__arrow_c_stream__"):
        return table
    if isinstance(table, Mapping) or (package == "pandas" and hasattr(table, "columns")):
        pairs = table.items()
    elif isinstance(table, np.ndarray) and table.dtype.names:
        pairs = ((name, table[name]) for name in table.dtype.names)
    elif is_rows(table):
        keys = dict.fromkeys(key for row in table for key in row)
        pairs = ((key, [row.get(key) for row in table]) for key in keys)
    else:
        raise TypeError(f"{type(table).__name__} is no table: expected a DataFrame, an Arrow table, a dict of columns, a structured array or rows")
    columns: dict[str, Any] = {}
    for name, column in pairs:
        if str(name) in columns:
            raise _tumble.MalformedError(f"the column '{name}' stands twice in the table: expected each column once")
        columns[str(name)] = column_of(column)
    if not columns:
        raise _tumble.MalformedError("the table has no readings: expected columns, and a row for each reading")
    return columns


def is_rows(table: Any) -> bool:
    """Is it a list of dicts?"""
    return isinstance(table, Sequence) and all(isinstance(row, Mapping) for row in table)


def column_of(column: Any) -> Any:
    """A column as a buffer of numbers, or as a list in which None is an empty cell."""
    package = package_of(column)
    if package == "pandas":
        if isinstance(column.dtype, np.dtype) and column.dtype.kind != "O":
            column = column.to_numpy()
        elif column.dtype.kind == "M":
            column = column.to_numpy("datetime64[ns]")
        else:
            return [None if empty else value for value, empty in zip(column.tolist(), column.isna())]
    if package == "polars":
        return column.to_numpy() if column.dtype.is_numeric() and not column.null_count() else column.to_list()
    if package == "pyarrow":
        return column.to_pylist()
    if isinstance(column, np.ma.MaskedArray):
        found = column_of(column.data)
        cells = found.tolist() if isinstance(found, np.ndarray) else found
        return [None if empty else value for value, empty in zip(cells, np.ma.getmaskarray(column))]
    if not isinstance(column, np.ndarray):
        return column
    kind, size = column.dtype.kind, column.dtype.itemsize
    if kind == "m":
        return column / np.timedelta64(1, "s")
    if kind == "M":
        texts = np.datetime_as_string(column).tolist()
        return [None if text == "NaT" else text.rstrip("0").rstrip(".") if "." in text else text for text in texts]
    if kind == "f" and size not in (4, 8):
        return column.astype(np.float64)
    return np.asarray(column, column.dtype.newbyteorder("=")) if kind in "fiu" else column.tolist()


def write(table: Table, folder: str, name: str) -> str:
    """A table as a file that the program reads; its path."""
    path = os.path.join(folder, f"{name}.parquet")
    _tumble.write_table(columns_of(table), Path(path))
    return path


def is_table(value: Any) -> bool:
    """Is this a table, and no path?"""
    return not isinstance(value, (str, os.PathLike))


def read(path: str) -> dict[str, Any]:
    """A table of CSV as numpy arrays."""
    with open(path, encoding="utf-8", newline="") as file:
        names, *rows = csv.reader(file)
    return {name: _cells([row[k] for row in rows]) for k, name in enumerate(names)}


def kept(table: Table) -> Any:
    """A table that can be read again: a stream of Arrow, which may be read once, as a pyarrow Table."""
    if package_of(table) in ("pandas", "polars") or not hasattr(table, "__arrow_c_stream__"):
        return table
    import pyarrow

    return pyarrow.table(table)


def with_columns(table: Table, columns: Columns) -> Any:
    """A table with further columns (arrays), in the place of those that have their names; all else as it is."""
    package = package_of(table)
    if package == "pandas":
        return table.assign(**columns)
    if package == "polars":
        import polars

        return table.with_columns(*(polars.Series(name, column, nan_to_null=True) for name, column in columns.items()))
    if is_rows(table):
        return [{**row, **dict(zip(columns, cells))} for row, *cells in zip(table, *(column.tolist() for column in columns.values()))]
    if isinstance(table, np.ndarray):
        table = {name: table[name] for name in table.dtype.names}
    if isinstance(table, Mapping):
        return {**table, **columns}
    import pyarrow

    for name, column in columns.items():
        if name in table.column_names:
            table = table.drop_columns(name)
        table = table.append_column(name, pyarrow.array(column, from_pandas=True))
    return table


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
