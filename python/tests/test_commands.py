"""Every command of the program."""

import json
import xml.etree.ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pytest
import tumble
from cases import EXAMPLES, LINE, TABLE_1

rejected = pytest.mark.filterwarnings("ignore::tumble.RejectedWarning")
notes = pytest.mark.filterwarnings("ignore::tumble.NoteWarning")


@rejected
def test_diagnose() -> None:
    campaign = EXAMPLES / "07-hidden-effect/measured.campaign.json"
    found = tumble.diagnose(campaign)
    code, out, _ = tumble.run("diagnose", campaign, "--json", "-")
    assert found.data == json.loads(out) and found.rejected == (code == 2)
    assert found.verdict == "effects-found" and found.effects[0].regressor == found["effects"][0]["regressor"]
    assert found.effects[0].regressor in str(found) and "<svg" in found._repr_html_() + found.page()
    for picture in found.figures():
        assert xml.etree.ElementTree.fromstring(picture.svg).tag.endswith("svg")
    with pytest.warns(tumble.RejectedWarning, match="effects-found"):
        tumble.diagnose(json.loads(campaign.read_text()))


def test_plan() -> None:
    planned = tumble.plan(TABLE_1, noise={"V": 9e-4})
    assert planned.report == "plan" and "dtheta_y2" in str(planned)
    more = tumble.plan(TABLE_1, noise={"V": 9e-4}, add=4, step=90)
    assert more.improved is not None and more.improved.judgement is not None


@rejected
def test_compare() -> None:
    published = tumble.compare(TABLE_1)
    assert published.report == "compare" and published.groups
    folder = EXAMPLES / "21-calibration-in-use"
    before, after = tumble.fit(folder / "before.campaign.json"), tumble.fit(folder / "after.campaign.json")
    changes = tumble.compare(before, after)
    assert changes.report == "compare-calibrations"
    # the kept reports are of another build, whose last digits may differ
    kept = tumble.compare(folder / "before.fit.json", folder / "after.fit.json")
    for own, other in zip(changes.changes, kept.changes, strict=True):
        assert own.id == other.id and own.difference == pytest.approx(other.difference, rel=1e-9) and own.significant == other.significant


@notes
def test_navigate() -> None:
    found = tumble.navigate(EXAMPLES / "09-navigator/findings.mission.json")
    assert found.report == "navigate" and found.results
    lengths = {len(column) for column in found.series.values()}
    assert len(lengths) == 1 and any(name.startswith("time") for name in found.series)


@notes
def test_noise_of_a_table() -> None:
    # white noise of 1 deg/s at 100 Hz: 0.1 deg/sqrt(s)
    rates = np.random.default_rng(1).normal(0, 1, 60000)
    table = {"time_s": np.arange(60000) / 100, "g (deg/s)": rates}
    reports = [tumble.noise(one) for one in (table, pd.DataFrame(table), pl.DataFrame(table))]
    assert reports[0].data["columns"] == reports[1].data["columns"]
    white = [next(own for own in one.columns[0].coefficients if own.id == "N") for one in reports]
    # 0.1 deg/sqrt(s) = 6 deg/sqrt(h), from 60,000 samples
    assert white[0].unit == "deg/sqrt(h)" and white[0].value == pytest.approx(6, rel=0.02)
    assert [own.value for own in white] == pytest.approx([white[0].value] * 3, rel=1e-12)


@notes
@rejected
def test_reduce(tmp_path: Path) -> None:
    folder = EXAMPLES / "15-xsens-from-the-log"
    target = tmp_path / "xsens.campaign.json"
    found = tumble.reduce(folder / "xsens.csv.gz", schedule=folder / "accelerometer.schedule.json", to=target)
    assert found.report == "reduce" and len(found.segments) > 10
    assert len(tumble.fit(target).order) > 0


@notes
def test_the_correction_in_use() -> None:
    folder = EXAMPLES / "21-calibration-in-use"
    fit = tumble.fit(folder / "before.campaign.json")
    compile(tumble.export(fit, to="python"), "correction.py", "exec")
    text = tumble.apply(fit, folder / "record.csv")
    assert text == tumble.apply(fit.report, folder / "record.csv")
    frame = pd.read_csv(folder / "record.csv")
    corrected = tumble.apply(fit, frame)
    assert isinstance(corrected, pd.DataFrame) and len(corrected) == len(frame)
    as_dict = tumble.apply(fit, {name: frame[name].to_numpy() for name in frame})
    polars = tumble.apply(fit, pl.from_pandas(frame))
    for name in corrected.columns:
        if corrected[name].dtype.kind == "f":
            assert as_dict[name] == pytest.approx(corrected[name].to_numpy(), rel=1e-12)
            assert polars[name].to_numpy() == pytest.approx(corrected[name].to_numpy(), rel=1e-12)


@notes
def test_a_correction_leaves_a_table_as_it_is() -> None:
    folder = EXAMPLES / "21-calibration-in-use"
    frame = pd.read_csv(folder / "record.csv").head(2)
    frame.index = pd.Index(["p", "q"])
    frame.insert(0, "note", ["#cal", " 007"])
    frame["stamp_ns"] = np.array([1767225600000000001, 1767225600000000257])
    frame["when"], frame["ok"], frame["list"] = pd.date_range("2024", periods=2, freq="s"), True, [[1], [2]]

    def apply(table: Any) -> Any:
        return tumble.apply(folder / "after.fit.json", table, u=True)

    corrected = apply(frame)
    added = ["a_x", "a_y", "a_z", "a_x_u", "a_y_u", "a_z_u"]
    assert corrected[frame.columns].equals(frame) and list(corrected.columns[len(frame.columns):]) == added
    rows = apply(frame.to_dict("records"))
    assert [row["note"] for row in rows] == ["#cal", " 007"] and [row["a_x"] for row in rows] == corrected["a_x"].tolist()
    columns = apply({name: frame[name] for name in frame})
    assert columns["when"] is not None and columns["a_x_u"].tolist() == corrected["a_x_u"].tolist()
    table = pl.from_pandas(frame.drop(columns="list"))
    assert apply(table).drop(added).equals(table) and apply(table.to_arrow()).drop_columns(added).equals(table.to_arrow())
    assert apply(table.to_arrow().to_reader()).equals(apply(table.to_arrow()))
    with pytest.raises(tumble.MalformedError, match="a cell of the column 'ax' is not a number"):
        apply(frame.assign(ax="one"))
    assert apply(apply(table)).equals(apply(table)) and apply(table)["a_z"].to_list() == corrected["a_z"].tolist()


@rejected
def test_texts_of_a_table_stay_as_they_are() -> None:
    campaign = json.loads((EXAMPLES / "07-hidden-effect/measured.campaign.json").read_text())
    for mark in ("#", "%", "//", ";", " ", '"', "'", "\n"):
        table = pd.DataFrame(campaign["readings"])
        table = table.assign(position=[mark + str(own) for own in table["position"]])
        assert [own.position for own in tumble.diagnose(campaign, table).residuals] == tumble.fit(campaign, table).readings.position == table["position"].tolist()


def test_the_rest() -> None:
    assert "gyro-turntable" in tumble.bench()
    assert tumble.bench("gyro-turntable")["id"] == "gyro-turntable"
    assert tumble.schema("campaign")["$schema"].startswith("https://json-schema.org")
    assert "table1" in tumble.check(TABLE_1)
    code, _, error = tumble.run("fit", "nothing.campaign.json")
    assert code == 1 and "nothing.campaign.json" in error
    assert tumble.run("--version")[1].split()[-1] == tumble.__version__


@pytest.mark.filterwarnings("ignore::tumble.RejectedWarning")
def test_a_second_language() -> None:
    for own, other in [
        (tumble.plan(LINE, noise={"y": 0.1}), tumble.plan(LINE, noise={"y": 0.1}, lang="zh")),
        (tumble.compare(TABLE_1), tumble.compare(TABLE_1, lang="zh")),
        (tumble.diagnose(LINE), tumble.diagnose(LINE, lang="zh")),
    ]:
        assert {**own.data, "inputs": 0} == {**other.data, "inputs": 0} and str(own) != str(other) and 'lang="zh' in other.page()


def test_dicts_for_every_command() -> None:
    planned = tumble.plan(LINE, noise={"y": 0.1})
    assert planned.report == "plan"
    assert tumble.plan(LINE, {"x": np.arange(5.0)}, noise={"y": 0.1}).report == "plan"
