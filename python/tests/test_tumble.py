"""The package beside the published figures and the program."""

import json
import math
import signal
import threading
import time
from pathlib import Path

import pytest
import tumble

ROOT = Path(__file__).resolve().parents[2]
TABLE_1 = ROOT / "examples/01-gyro-table/table1.campaign.json"
LINE = {
    "bench": {"id": "line", "sensors": {"y": {"model": "a + b*x"}}},
    "estimate": {"a": {}, "b": {}},
    "readings": [{"x": 0, "y": 1}, {"x": 1, "y": 3}, {"x": 2, "y": 4}],
}


def test_published_table():
    # Li, Ren, Zhao 2012, table 1, mean of three rates; all readings together move it by less than the last printed digit and a half
    fit = tumble.fit(TABLE_1)
    for name, printed in {"dtheta_y0": -7.5, "dtheta_x0": 2.4, "dtheta_y1": -53.8, "dtheta_y2": -162.1, "dtheta_z2": 55.8, "gamma": 171.5}.items():
        assert fit[name].value == pytest.approx(printed, abs=0.25), name
        assert fit[name].unit == "arcsec"
    assert not fit.rejected
    assert "dtheta_y2" in str(fit) and "171.48" in str(fit)
    assert fit.page().startswith("<!")


def test_a_dict_is_a_campaign():
    # a straight line through (0, 1), (1, 3), (2, 4): slope 3/2, intercept 7/6, s^2 = 1/6
    fit = tumble.fit(LINE)
    assert fit["b"].value == pytest.approx(1.5, abs=1e-14)
    assert fit["a"].value == pytest.approx(7 / 6, abs=1e-14)
    assert fit["b"].u == pytest.approx(math.sqrt(1 / 12), rel=1e-12)
    assert fit["b"].dof == pytest.approx(1)
    assert list(fit)[:2] == ["a", "b"] and fit["bench"] == "line"


def test_tables_as_readings():
    np = pytest.importorskip("numpy")
    x = np.array([0.0, 1.0, 2.0])
    y = np.array([1.0, 3.0, 4.0])
    tables = [{"x": x, "y": y}, [{"x": 0, "y": 1}, {"x": 1, "y": 3}, {"x": 2, "y": 4}]]
    tables.append(np.array(list(zip(x, y)), dtype=[("x", float), ("y", float)]))
    try:
        import pandas as pd

        tables.append(pd.DataFrame({"x": x, "y": y}))
    except ImportError:
        pass
    question = {key: value for key, value in LINE.items() if key != "readings"}
    for table in tables:
        assert tumble.fit(question, table)["b"].value == pytest.approx(1.5, abs=1e-14)
    covariance = tumble.fit(question, tables[0]).covariance
    assert covariance.shape == (2, 2)
    # s^2 (A'A)^-1 = 1/6 [[5/6, -1/2], [-1/2, 1/2]]
    assert covariance == pytest.approx(np.array([[5 / 36, -1 / 12], [-1 / 12, 1 / 12]]), rel=1e-12)


def test_columns_of_different_lengths():
    with pytest.raises(ValueError, match="different lengths"):
        tumble.fit(LINE, {"x": [1, 2], "y": [1]})


def test_errors_say_where():
    with pytest.raises(tumble.MalformedError, match=r"(?s)estimate.*dtheta_y9|dtheta_y9.*estimate"):
        tumble.fit({"bench": "gyro-turntable", "estimate": {"dtheta_y9": {}}, "readings": []})
    with pytest.raises(FileNotFoundError):
        tumble.fit("nothing.campaign.json")
    with pytest.raises(tumble.MalformedError, match="huber"):
        tumble.fit(LINE, robust="hubert")
    assert issubclass(tumble.MalformedError, ValueError)


def test_a_rejected_fit_warns():
    question = {**LINE, "readings": [{"x": 1, "y": 1}, {"x": 1, "y": 3}]}
    with pytest.warns(tumble.RejectedWarning):
        fit = tumble.fit(question)
    assert fit.rejected and fit["a"].value is None and fit["a"].state == "not-estimable"


def test_commands():
    found = tumble.diagnose(ROOT / "examples/05-table-1-diagnosed/table1.campaign.json")
    code, out, _ = tumble.run("diagnose", ROOT / "examples/05-table-1-diagnosed/table1.campaign.json", "--json", "-")
    assert found.data == json.loads(out) and found.rejected == (code == 2)
    assert "gyro-turntable" in tumble.bench()
    assert tumble.bench("gyro-turntable")["id"] == "gyro-turntable"
    assert tumble.schema("campaign")["$schema"].startswith("https://json-schema.org")
    planned = tumble.plan(TABLE_1, noise="V=9e-4")
    assert planned["report"] == "plan" and "dtheta_y2" in str(planned)


def test_simulated_readings_come_back():
    truth = {"values": {"a": {"value": 2.0}, "b": {"value": -1.0}}, "noise": {"y": {"sd": 0.0}}}
    campaign = tumble.simulate(LINE, truth, seed=3)
    fit = tumble.fit(campaign)
    assert fit["a"].value == pytest.approx(2, abs=1e-12) and fit["b"].value == pytest.approx(-1, abs=1e-12)


def test_the_correction_in_use():
    folder = ROOT / "examples/50-calibration-in-use"
    fit = tumble.fit(folder / "before.campaign.json")
    compile(tumble.export(fit, to="python"), "correction.py", "exec")
    corrected = tumble.apply(fit, folder / "record.csv")
    assert corrected == tumble.apply(fit.data, folder / "record.csv")
    assert len(corrected.splitlines()) == len((folder / "record.csv").read_text().splitlines())


def test_ctrl_c_is_answered():
    threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT)).start()
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        # some ten seconds of work
        tumble.run("fit", TABLE_1, "--monte-carlo", 3000000)
    assert time.monotonic() - begun < 5


def test_the_notebook_shows_a_table():
    shown = tumble.fit(LINE)._repr_html_()
    assert shown.startswith("<table>") and "<td>b</td>" in shown
