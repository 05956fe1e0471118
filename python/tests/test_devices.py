"""Many devices: each answer is what its own fit says."""

import csv
import json
import pickle

import numpy as np
import pandas as pd
import polars as pl
import pytest
import tumble
from cases import EXAMPLES, LINE, TABLE_1

FOLDER = EXAMPLES / "26-production-line"
rejected = pytest.mark.filterwarnings("ignore::tumble.RejectedWarning")


@rejected
def test_a_production_line() -> None:
    # beside numpy.linalg, by tests/scripts/production_line.py
    line = tumble.fit_devices(FOLDER / "line.campaign.json")
    assert line.count == 40 and int(line.accepted.sum()) == 38
    with open(FOLDER / "expected.csv", newline="") as file:
        expected = {row["serial"]: row for row in csv.DictReader(file)}
    for k, label in enumerate(line.labels):
        if label in expected and line.accepted[k] and expected[label].get("V0"):
            assert line["V0"].value[k] == pytest.approx(float(expected[label]["V0"]), rel=1e-9)
    assert line.verdict[line.labels.index("G031")] == "rejected" and "G036" in line.why
    assert line.report.devices.all == 40 and line.report.quantities[0].id == "V0"
    assert "2 of 40 devices are not accepted" in str(line) and "<svg" in line.page()


@rejected
def test_tables_of_devices() -> None:
    expected = tumble.fit_devices(FOLDER / "line.campaign.json")
    frame = pd.read_csv(FOLDER / "readings.csv", dtype={"V": str})
    frame = frame[frame["serial"] != "G036"].assign(V=lambda own: own["V"].astype(float))
    for table in (frame, pl.from_pandas(frame), frame.sample(frac=1, random_state=1)):
        found = tumble.fit_devices(FOLDER / "line.campaign.json", table, by="serial")
        assert sorted(found.labels) == sorted(own for own in expected.labels if own != "G036")
        order = [expected.labels.index(own) for own in found.labels]
        assert found.value == pytest.approx(expected.value[order], rel=1e-9, nan_ok=True)
        assert found.u == pytest.approx(expected.u[order], rel=1e-6, nan_ok=True)


def test_an_array_of_devices() -> None:
    rng = np.random.default_rng(1)
    values = 1 + 2 * np.arange(3) + rng.normal(0, 0.1, (50, 3))
    found = tumble.fit_devices(LINE, values=values, labels=[f"S{k}" for k in range(50)])
    assert found.ids == ["a", "b"] and found.value.shape == (50, 2)
    design = np.column_stack([np.ones(3), np.arange(3)])
    expected = np.linalg.lstsq(design, values.T, rcond=None)[0].T
    assert found.value == pytest.approx(expected, rel=1e-10)
    residuals = values - expected @ design.T
    # one degree of freedom; sum (x - 1)^2 = 2
    assert found["b"].u == pytest.approx(np.sqrt((residuals**2).sum(1) / 2), rel=1e-6)
    assert found.labels[7] == "S7" and found.column("dof").tolist() == [1.0] * 50
    assert found.to_pandas()["b"].tolist() == found["b"].value.tolist()
    assert found.to_polars().height == found.to_arrow().num_rows == 50


def test_an_array_on_an_exact_bench() -> None:
    # tilts: in arcsec, and each device as its own fit says
    question = json.loads(TABLE_1.read_text())
    read = np.array([row["V"] for row in question["readings"]])
    values = read + np.random.default_rng(2).normal(0, 1e-4, (3, len(read)))
    found = tumble.fit_devices(question, values=values)
    assert found.units[found.ids.index("dtheta_y2")] == "arcsec"
    for k in range(3):
        rows = [{**row, "V": float(value)} for row, value in zip(question["readings"], values[k])]
        alone = tumble.fit({**question, "readings": rows})
        for name in found.ids:
            assert found[name].value[k] == pytest.approx(alone[name].value, rel=1e-7, abs=1e-7), name
            assert found[name].u[k] == pytest.approx(alone[name].u, rel=1e-5), name


def test_what_was_not_read() -> None:
    values = np.array([[1.0, 3, 4], [1, np.nan, 4]])
    for own in (values, np.ma.masked_invalid(values), np.ma.array([[1, 3, 4], [1, 999, 4]], mask=[[False] * 3, [False, True, False]])):
        found = tumble.fit_devices(LINE, values=own)
        assert found["b"].value == pytest.approx([1.5, 1.5], abs=1e-14)
        assert found.column("readings").tolist() == [3, 2] and np.isnan(found["b"].u[1])


def test_serials_that_no_double_keeps() -> None:
    serials = [2**53, 2**53 + 1, 2**64 - 1, 2**64 - 2]
    frame = pd.DataFrame({"s": np.repeat(np.array(serials, dtype=np.uint64), 3), "x": [0, 1, 2] * 4, "y": [1.0, 3, 4, 0, 5, 10, 0, 1, 2, 4, 4, 4]})
    rows = [{**row, "s": int(row["s"])} for row in frame.to_dict("records")]
    question = {key: own for key, own in LINE.items() if key != "readings"}
    for table in (frame, pl.from_pandas(frame), pl.from_pandas(frame).to_arrow(), rows):
        found = tumble.fit_devices(question, table, by="s")
        assert found.labels == [str(own) for own in serials] and found["b"].value == pytest.approx([1.5, 5, 1, 0], abs=1e-12)


def test_pickled_devices_say_the_same() -> None:
    found = tumble.fit_devices(LINE, values=np.random.default_rng(1).normal(size=(5, 3)))
    other = pickle.loads(pickle.dumps(found))
    assert np.array_equal(other.value, found.value) and other.labels == found.labels and str(other) == str(found)
    assert other.page() == found.page() and other.report.data == found.report.data and other.to_pandas().equals(found.to_pandas())
    with pytest.raises(RuntimeError, match="were pickled"):
        other.table(3)


def test_several_sensors() -> None:
    bench = {"id": "two", "sensors": {"p": {"model": "a + b*x"}, "q": {"model": "c*x"}}}
    question = {"bench": bench, "estimate": {"a": {}, "b": {}, "c": {}}, "readings": [{"x": 1}, {"x": 2}, {"x": 3}]}
    p, q = np.array([[1.0, 3, 5], [2, 2, 2]]), np.array([[1.0, 2, 3], [3, 6, 9]])
    found = tumble.fit_devices(question, values={"q": q, "p": p})
    assert found["c"].value == pytest.approx([1, 3], abs=1e-12) and found["b"].value == pytest.approx([2, 0], abs=1e-12)
    with pytest.raises(ValueError, match="p, q"):
        tumble.fit_devices(question, values=p)
    with pytest.raises(ValueError, match="no sensor 'r'"):
        tumble.fit_devices(question, values={"r": p})


def test_questions_that_are_none() -> None:
    with pytest.raises(ValueError, match=r"\(devices, 3\)"):
        tumble.fit_devices(LINE, values=np.zeros((2, 4)))
    with pytest.raises(ValueError, match="'one' stands twice"):
        tumble.fit_devices(LINE, values=np.zeros((2, 3)), labels=["one", "one"])
    with pytest.raises(ValueError, match="a label for each"):
        tumble.fit_devices(LINE, values=np.zeros((2, 3)), labels=["one"])
    with pytest.raises(tumble.MalformedError, match="tells the devices apart"):
        tumble.fit_devices(LINE)
    with pytest.raises(tumble.MalformedError, match="level"):
        tumble.fit_devices(LINE, values=np.zeros((2, 3)), level=2)
    with pytest.raises(tumble.MalformedError, match="fit_devices"):
        tumble.fit(FOLDER / "line.campaign.json")


@rejected
def test_effects_of_devices() -> None:
    found = tumble.diagnose_devices(FOLDER / "line.campaign.json")
    assert len(found["serial"]) == 40 and list(found["verdict"]).count("effects-found") == 1
