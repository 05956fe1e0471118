"""Errors say where, with a caret; remarks are warnings."""

import gc
import json
import pickle
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import tumble
from cases import EXAMPLES, LINE


def test_errors_say_where() -> None:
    with pytest.raises(tumble.MalformedError) as caught:
        tumble.fit({"bench": "gyro-turntable", "estimate": {"dtheta_y9": {}}, "readings": [{"V": 1, "alpha_deg": 0, "beta_deg": 0, "gamma_deg_s": 5}]})
    error = caught.value
    assert error.path is not None and "dtheta_y9" in error.path and error.expected
    assert error.line is not None and error.line > 1
    # the line of the dict's text, and a mark below it
    quoted = str(error).split("\n")
    at = next(k for k, line in enumerate(quoted) if '"dtheta_y9": {}' in line)
    assert "─" in quoted[at + 1] and error.found == "'dtheta_y9'" and error.file == "campaign"
    assert issubclass(tumble.MalformedError, ValueError)


def test_a_model_line_has_a_caret() -> None:
    with pytest.raises(tumble.MalformedError) as caught:
        tumble.fit({**LINE, "bench": {"id": "line", "sensors": {"y": {"model": "a + * b*x"}}}})
    assert "a + * b*x" in str(caught.value)


def test_files(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="nothing.campaign.json"):
        tumble.fit("nothing.campaign.json")
    typo = EXAMPLES / "03-your-own-positions/typo.campaign.json"
    with pytest.raises(tumble.MalformedError) as caught:
        tumble.fit(typo)
    code, _, told = tumble.run("fit", typo)
    assert code == 1 and str(caught.value).split("\n")[0] == told.split("\n")[0]
    assert caught.value.file is not None and caught.value.file.endswith("typo.campaign.json")
    broken = tmp_path / "broken.campaign.json"
    broken.write_text(json.dumps(LINE)[:-4])
    with pytest.raises(tumble.MalformedError):
        tumble.diagnose(broken)


def test_values_and_options() -> None:
    with pytest.raises(tumble.MalformedError, match="huber"):
        tumble.fit(LINE, robust="hubert")  # type: ignore[arg-type]
    with pytest.raises(tumble.MalformedError, match="level"):
        tumble.fit(LINE, level=1.5)
    with pytest.raises(ValueError, match="infinite"):
        tumble.fit({**LINE, "readings": [{"x": 1, "y": float("inf")}]})
    with pytest.raises(TypeError, match=r"type object cannot be in a campaign \(at readings\[0\]"):
        tumble.fit({**LINE, "readings": [{"x": 1, "y": object()}]})
    # a table in the campaign's place for rows
    with pytest.raises(TypeError, match=r"readings=table"):
        tumble.fit({**LINE, "readings": object()})
    for wrong in (tumble.plan, tumble.guide):
        with pytest.raises(TypeError, match=r"has no argument 'nothing': expected one of .*noise"):
            wrong(LINE, nothing=1)
    with pytest.raises(tumble.MalformedError, match=r"readings\[1\]"):
        tumble.fit({**LINE, "readings": [{"x": 1, "y": 1}, {"x": 2, "y": True}]})


def test_a_wrong_option_has_no_place() -> None:
    with pytest.raises(tumble.MalformedError) as caught:
        tumble.plan(LINE, noise={"y": 0.1}, choose="many")  # type: ignore[arg-type]
    assert caught.value.path is None and caught.value.line is None
    assert "choose=" in str(caught.value) and "--" not in str(caught.value) and "Usage" not in str(caught.value)


def test_a_table_is_called_by_its_name() -> None:
    with pytest.raises(tumble.MalformedError, match=r"(?s)in log\n.*rate=.*time=") as caught:
        tumble.noise({"g (deg/h)": np.zeros(100)})
    assert caught.value.file == "log" and "--" not in str(caught.value)
    with pytest.raises(tumble.MalformedError, match="start= before end=, in seconds"):
        tumble.noise({"time_s": np.arange(100.0), "g (deg/h)": np.zeros(100)}, start=50, end=10)
    with pytest.raises(tumble.MalformedError, match=r"(?s)in readings\n.*row 2, column 'y'"):
        tumble.diagnose(LINE, {"x": [0, 1, 2], "y": ["1", "two", "3"]})


def test_what_is_not_a_number_has_its_place() -> None:
    for content in (float("nan"), np.float32("nan"), pd.NA):
        with pytest.raises(tumble.MalformedError, match=r"known\.b\.value is not a number"):
            tumble.fit({**LINE, "estimate": {"a": {}}, "known": {"b": {"value": content}}})
        rows = [*LINE["readings"], {"x": 3, "y": content}]
        assert tumble.fit({**LINE, "readings": rows})["b"].value == pytest.approx(1.5, abs=1e-14)


def test_errors_reach_other_processes() -> None:
    with pytest.raises(tumble.MalformedError) as caught:
        tumble.fit({**LINE, "estimate": {"c": {}}})
    other = pickle.loads(pickle.dumps(caught.value))
    assert type(other) is tumble.MalformedError and str(other) == str(caught.value) and other.path == caught.value.path
    assert tumble.MalformedError.__module__ == "tumble"


def test_warnings_are_about_the_line_that_asked() -> None:
    with pytest.warns(tumble.RejectedWarning) as fitted:
        tumble.fit({**LINE, "readings": [{"x": 1, "y": 1}, {"x": 1, "y": 3}]})
    with pytest.warns(tumble.RejectedWarning) as diagnosed:
        tumble.diagnose(EXAMPLES / "07-hidden-effect/measured.campaign.json")
    folder = EXAMPLES / "15-xsens-from-the-log"
    with pytest.warns(tumble.NoteWarning) as noted:
        # samples in a campaign: how many readings they gave is a remark
        tumble.diagnose(folder / "accelerometer.campaign.json")
    for found in (fitted, diagnosed, noted):
        own = [warning for warning in found if issubclass(warning.category, (tumble.RejectedWarning, tumble.NoteWarning))]
        assert own and all(warning.filename == __file__ for warning in own)
    assert not [warning for found in (fitted, diagnosed, noted) for warning in found if issubclass(warning.category, ResourceWarning)]


def test_nothing_is_left_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    tumble.plan(LINE, noise={"y": 0.1})
    gc.collect()
    assert list(tmp_path.iterdir()) == []
