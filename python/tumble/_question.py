"""Questions as the engine takes them: the text of a JSON file, and the folder that it stands in."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Union

Question = Union[str, "os.PathLike[str]", Mapping[str, Any]]


def text_of(question: Question, readings: Any = None, kind: str = "campaign") -> tuple[str, str, str]:
    """Name, text and folder of a question; `readings` (a table) take the place of those that it has."""
    if isinstance(question, Mapping):
        name, folder, content = kind, os.getcwd(), question
        if readings is None:
            return name, _dumps(content), folder
    else:
        path = Path(question)
        try:
            text = path.read_text(encoding="utf-8-sig")
        except OSError as error:
            raise FileNotFoundError(f"cannot read {path}: {error}") from None
        name, folder = str(path), str(path.parent)
        if readings is None:
            return name, text, folder
        content = json.loads(text)
    return name, _dumps({**content, "readings": rows_of(readings)}), folder


def rows_of(table: Any) -> Any:
    """Readings as a list of dicts: from a DataFrame, a pyarrow table, a dict of columns, a structured array or rows."""
    if isinstance(table, (str, os.PathLike)):
        return str(table)
    if hasattr(table, "to_pylist"):  # pyarrow
        rows = table.to_pylist()
    elif hasattr(table, "to_dicts"):  # polars
        rows = table.to_dicts()
    elif hasattr(table, "to_dict") and hasattr(table, "columns"):  # pandas
        rows = _rows_of_columns({str(name): table[name].tolist() for name in table.columns})
    elif isinstance(table, Mapping):
        rows = _rows_of_columns({name: column.tolist() if hasattr(column, "tolist") else list(column) for name, column in table.items()})
    elif getattr(getattr(table, "dtype", None), "names", None):  # numpy, structured
        rows = _rows_of_columns({name: table[name].tolist() for name in table.dtype.names})
    else:
        rows = list(table)
    # an empty cell is a value that is not there, as in a CSV
    return [{key: value for key, value in row.items() if value is not None and value == value} for row in rows]


def _rows_of_columns(columns: Mapping[str, list[Any]]) -> list[dict[str, Any]]:
    lengths = {name: len(column) for name, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise ValueError(f"columns of readings have different lengths: {lengths}")
    return [dict(zip(columns, row)) for row in zip(*columns.values())]


def _dumps(content: Any) -> str:
    return json.dumps(content, default=_plain, allow_nan=False)


def _plain(value: Any) -> Any:
    """A number or array of numpy, a path, a date as JSON has them."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "isoformat"):
        return value.isoformat()
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{type(value).__name__} has no place in a question: {value!r}")
