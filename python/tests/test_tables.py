"""Readings from every kind of table, and results as tables."""

import array
import json
from datetime import time, timedelta
from decimal import Decimal
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest
import tumble
from cases import EXAMPLES, LINE

QUESTION = {key: value for key, value in LINE.items() if key != "readings"}
X, Y = np.array([0.0, 1.0, 2.0]), np.array([1.0, 3.0, 4.0])
NAMED = {"x": X, "y": Y, "operator": ["a", "b", "c"]}


class Stream:
    """Any other package that speaks Arrow."""

    def __init__(self, table: Any) -> None:
        self.table = table

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        return self.table.__arrow_c_stream__(requested_schema)


TABLES = {
    "dict of arrays": {"x": X, "y": Y},
    "dict of lists": {"x": [0, 1, 2], "y": [1, 3, 4]},
    "array.array": {"x": array.array("d", X), "y": array.array("i", [1, 3, 4])},
    "strided": {"x": np.array([0.0, 9, 1, 9, 2, 9])[::2], "y": Y[::-1][::-1]},
    "float32": {"x": X.astype("f4"), "y": Y.astype("i2")},
    "big-endian": {"x": X.astype(">f8"), "y": Y.astype(">i4")},
    "bool": {"x": np.array([False, True]), "y": np.array([1.0, 2.5])},
    "rows": [{"x": 0, "y": 1}, {"x": 1, "y": 3}, {"x": 2, "y": 4}],
    "structured": np.array(list(zip(X, Y)), dtype=[("x", float), ("y", float)]),
    "pandas": pd.DataFrame(NAMED),
    "pandas, nullable": pd.DataFrame({"x": pd.array([0, 1, 2, 3], dtype="Int64"), "y": pd.array([1, 3, 4, None], dtype="Float64")}),
    "polars": pl.DataFrame(NAMED),
    "polars, lazy": pl.LazyFrame(NAMED),
    "polars, null": pl.DataFrame({"x": [0, 1, 2, 3], "y": [1.0, 3, 4, None]}),
    "masked": {"x": np.ma.array([0, 1, 2, 3]), "y": np.ma.array([1.0, 3, 4, 999], mask=[False, False, False, True])},
    "masked integers": {"x": np.ma.array([0, 1, 2, 3], mask=[False, False, False, True]), "y": [1, 3, 4, None]},
    "NA, NaT": {"x": [0, 1, 2, pd.NA], "y": [1, 3, 4, pd.NaT]},
    "rows, NA": [{"x": 0, "y": 1}, {"x": 1, "y": np.float32("nan")}, {"x": 1, "y": 3}, {"x": 2, "y": "4"}, {"x": 3, "y": pd.NA}],
    "decimals": pl.DataFrame({"x": [0, 1, 2], "y": [Decimal(1), Decimal(3), Decimal(4)]}),
    "durations": pa.table({"x": pa.array([0, 10**9, 2 * 10**9], pa.duration("ns")), "y": Y}),
    "durations, pandas": pd.DataFrame({"x": pd.to_timedelta([0, 1, 2], unit="s"), "y": Y}),
    "durations, rows": [{"x": timedelta(seconds=k), "y": y} for k, y in enumerate(Y)],
    "pyarrow": pa.table({**NAMED, "x": pa.array([0, 1, 2], pa.uint16())}),
    "pyarrow, chunks": pa.concat_tables([pa.table({"x": [0.0], "y": [1.0]}), pa.table({"x": [1.0, 2.0], "y": [3.0, 4.0]})]),
    "pyarrow, dictionary": pa.table({"x": X, "y": Y, "by": pa.array(["a", None, "b"]).dictionary_encode()}),
    "pyarrow, batch": pa.record_batch({"x": X, "y": Y}),
    "Arrow stream": Stream(pa.table({"x": X, "y": Y, "none": pa.nulls(3), "day": pa.array([1, None, 3], pa.date32())})),
    "what no line uses": pl.DataFrame(
        {"x": X, "y": Y, "null": [None] * 3, "list": [[1]] * 3, "bytes": [b"a"] * 3, "time": [time(1)] * 3, "struct": [{"a": 1}] * 3, "inf": [np.inf] * 3}
    ),
    "numbers of 128 bits": pl.DataFrame({"x": pl.Series([0, 1, 2], dtype=pl.Int128), "y": Y, "own": pl.Series([2**70] * 3, dtype=pl.Int128)}),
    "what no line uses, rows": [{"x": x, "y": y, "own": object()} for x, y in zip(X, Y)],
    "series": {"x": pd.Series(X), "y": pl.Series(Y)},
}


@pytest.mark.parametrize("name", TABLES)
def test_readings(name: str) -> None:
    for question in (QUESTION, LINE):
        assert tumble.fit(question, TABLES[name])["b"].value == pytest.approx(1.5, abs=1e-14)


def test_a_file_with_a_table(tmp_path: Any) -> None:
    path = tmp_path / "line.campaign.json"
    path.write_text(json.dumps(LINE))
    assert tumble.fit(path, {"x": X, "y": 2 * Y})["b"].value == pytest.approx(3, abs=1e-14)
    pd.DataFrame({"x": X, "y": 3 * Y}).to_csv(tmp_path / "r.csv", index=False)
    assert tumble.fit(path, tmp_path / "r.csv")["b"].value == pytest.approx(4.5, abs=1e-14)


def test_tables_that_are_none() -> None:
    with pytest.raises(ValueError, match="another length"):
        tumble.fit(QUESTION, {"x": [1, 2], "y": [1]})
    with pytest.raises(TypeError, match="no table"):
        tumble.fit(QUESTION, 3)
    with pytest.raises(ValueError, match="one dimension"):
        tumble.fit(QUESTION, {"x": np.zeros((2, 2)), "y": [1, 2]})
    with pytest.raises(tumble.MalformedError, match="'y'|\"y\"| y"):
        tumble.fit(QUESTION, {"x": [1, 2], "y": ["one", "two"]})
    with pytest.raises(tumble.MalformedError, match="a value of the type List"):
        tumble.fit(QUESTION, pa.table({"x": [[1.0], [2.0]], "y": [1.0, 2.0]}))
    for series in (pd.Series([1, 2]), pl.Series([1, 2])):
        with pytest.raises(TypeError, match="Series is no table"):
            tumble.fit(QUESTION, series)
    for twice in (pd.DataFrame([[0, 1, 1], [1, 2, 2]], columns=["x", "y", "y"]), {1: [1, 2], "1": [1, 2]}):
        with pytest.raises(tumble.MalformedError, match="stands twice"):
            tumble.fit(QUESTION, twice)
    empties: list[Any] = [[], {}, pd.DataFrame()]
    for empty in empties:
        with pytest.raises(tumble.MalformedError, match="no readings"):
            tumble.fit(QUESTION, empty)


def test_results_as_tables() -> None:
    fit = tumble.fit(EXAMPLES / "01-gyro-table/table1.campaign.json")
    frame = fit.to_pandas().set_index("id")
    assert frame.loc["dtheta_y2", "value"] == fit["dtheta_y2"].value and frame.loc["dtheta_y2", "unit"] == "arcsec"
    assert fit.to_polars()["u"].to_list() == [own.u for own in fit.values()]
    assert fit.to_arrow().num_rows == len(fit)
    residuals = fit.readings
    assert len(residuals.to_pandas()) == len(residuals) == 30
    assert residuals.to_polars().columns == residuals.to_arrow().column_names


DATES = pd.date_range("2024-01-01", periods=4, freq="500ms")
TIMES: dict[str, Any] = {
    "pandas": lambda columns: pd.DataFrame(columns),
    "pandas, a zone": lambda columns: pd.DataFrame(columns).assign(x=DATES.tz_localize("UTC").tz_convert("Asia/Tokyo")),
    "polars": lambda columns: pl.DataFrame(columns),
    "pyarrow": lambda columns: pa.table(columns),
    **{f"numpy, {unit}": lambda columns, unit=unit: {**columns, "x": DATES.to_numpy().astype(f"M8[{unit}]")} for unit in ("ms", "us", "ns")},
    "rows": lambda columns: [dict(zip(columns, row)) for row in zip(*columns.values())],
    "texts": lambda columns: {**columns, "x": [str(at) for at in DATES]},
}


@pytest.mark.parametrize("name", TIMES)
def test_times_are_seconds_since_the_first(name: str) -> None:
    table = TIMES[name]({"x": DATES, "y": [1.0, 2.0, 3.0, 4.5], "position": DATES, "s": ["A"] * 4})
    fit = tumble.fit(QUESTION, table)
    # the slope over 0, 0.5, 1, 1.5 s
    assert fit["b"].value == pytest.approx(2.3, abs=1e-6)
    assert tumble.fit_devices(QUESTION, table, by="s")["b"].value == pytest.approx([2.3], abs=1e-6)
    assert fit.readings.position[:2] == ["2024-01-01T00:00:00", "2024-01-01T00:00:00.5"]
