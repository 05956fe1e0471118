"""One device, beside the published figures and closed forms."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tumble
from cases import EXAMPLES, LINE, TABLE_1


def test_published_table() -> None:
    # Li, Ren, Zhao 2012, table 1, mean of three rates; all readings together move it by less than the last printed digit and a half
    fit = tumble.fit(TABLE_1)
    printed = {"dtheta_y0": -7.5, "dtheta_x0": 2.4, "dtheta_y1": -53.8, "dtheta_y2": -162.1, "dtheta_z2": 55.8, "gamma": 171.5}
    for name, value in printed.items():
        assert fit[name].value == pytest.approx(value, abs=0.25), name
        assert fit[name].unit == "arcsec"
    assert not fit.rejected
    assert "dtheta_y2" in str(fit) and "171.5" in str(fit)
    # to two significant digits of U, as the terminal and the printed table give it
    assert str(fit["dtheta_y2"]) == "dtheta_y2 = -162.1 +- 1.2 (k = 2.06) arcsec"
    assert fit.page().startswith("<!")


def test_a_dict_is_a_campaign() -> None:
    # a straight line through (0, 1), (1, 3), (2, 4): slope 3/2, intercept 7/6, s^2 = 1/6
    fit = tumble.fit(LINE)
    b = fit["b"]
    assert b.value == pytest.approx(1.5, abs=1e-14)
    assert fit["a"].value == pytest.approx(7 / 6, abs=1e-14)
    assert b.u == pytest.approx(math.sqrt(1 / 12), rel=1e-12)
    assert b.dof == pytest.approx(1) and b.kind == "coefficient" and b.state == "free"
    # t(0.975, 1) = tan(0.475 pi)
    assert b.k == pytest.approx(math.tan(0.475 * math.pi), rel=1e-9)
    assert list(fit) == ["a", "b"] and fit.report.bench == "line"
    with pytest.raises(KeyError, match="'c'"):
        fit["c"]


def test_covariance() -> None:
    fit = tumble.fit(LINE)
    # s^2 (A'A)^-1 = 1/6 [[5/6, -1/2], [-1/2, 1/2]]
    assert fit.covariance == pytest.approx(np.array([[5 / 36, -1 / 12], [-1 / 12, 1 / 12]]), rel=1e-12)
    assert fit.correlation[0, 1] == pytest.approx(-math.sqrt(0.6), rel=1e-12)
    assert fit.order == ["a", "b"]
    table = tumble.fit(TABLE_1)
    assert np.array(table.report.covariance.matrix) == pytest.approx(table.covariance, rel=1e-12)
    assert table.covariance.shape == (6, 6)


def test_a_dict_that_comes_again() -> None:
    # what is kept of a question must not outlive a change of it
    again = json.loads(json.dumps(LINE))
    assert tumble.fit(again)["b"].value == pytest.approx(1.5, abs=1e-14)
    again["readings"][2]["y"] = 5
    assert tumble.fit(again)["b"].value == pytest.approx(2, abs=1e-14)
    again["bench"]["sensors"]["y"]["model"] = "a + b*x^2"
    # y = 1, 3, 5 at x^2 = 0, 1, 4: 8 / (26/3)
    assert tumble.fit(again)["b"].value == pytest.approx(12 / 13, abs=1e-14)
    again["bench"]["sensors"]["y"]["model"] = "a + b*2*x"
    assert tumble.fit(again)["b"].value == pytest.approx(1, abs=1e-14)
    again["known"] = {"a": {"value": 1, "u": 0}}
    del again["estimate"]["a"]
    assert list(tumble.fit(again)) == ["b"]
    # the same keys in another place are another question
    other = {**LINE, "estimate": {"a": {"prior": 0, "prior_u": 1e-9}, "b": {}}}
    assert tumble.fit(other)["a"].value == pytest.approx(0, abs=1e-6)
    assert tumble.fit(LINE)["a"].value == pytest.approx(7 / 6, abs=1e-14)


@pytest.mark.filterwarnings("ignore::tumble.RejectedWarning")
def test_columns_that_come_and_go() -> None:
    # a kept question serves readings with other columns
    with_t = {**LINE, "readings": [{**row, "t": 1.0} for row in LINE["readings"]]}
    for question in (LINE, with_t, LINE):
        assert tumble.fit(question)["b"].value == pytest.approx(1.5, abs=1e-14)
    with_u = {**LINE, "readings": [{**row, "y_u": 0.1} for row in LINE["readings"]]}
    # u^2 / sum (x - mean)^2 = 0.01 / 2
    assert tumble.fit(with_u)["b"].u == pytest.approx(math.sqrt(0.005), rel=1e-12)
    assert tumble.fit(LINE)["b"].u == pytest.approx(math.sqrt(1 / 12), rel=1e-12)


def test_values_of_numpy_in_a_dict() -> None:
    rows: list[dict[str, Any]] = [{"x": np.float64(x), "y": np.int64(y)} for x, y in [(0, 1), (1, 3), (2, 4)]]
    assert tumble.fit({**LINE, "readings": rows})["b"].value == pytest.approx(1.5, abs=1e-14)
    rows.append({"x": np.float64(7), "y": float("nan")})
    assert tumble.fit({**LINE, "readings": rows})["b"].value == pytest.approx(1.5, abs=1e-14)
    odd = {"x": np.array([0, 1, 2], dtype=np.float16), "y": np.array([1, 3, 4], dtype=object)}
    assert tumble.fit(LINE, odd)["b"].value == pytest.approx(1.5, abs=1e-14)


def test_options() -> None:
    linear = tumble.fit(TABLE_1, linear=True)
    assert linear.report.estimator == "linear"
    wide = tumble.fit(LINE, level=0.99)["b"]
    assert wide.k == pytest.approx(math.tan(0.495 * math.pi), rel=1e-9)
    drawn = tumble.fit(TABLE_1, monte_carlo=20000, seed=3).report.monte_carlo
    assert drawn is not None and drawn.trials == 20000
    with pytest.raises(tumble.MalformedError, match="cannot be drawn"):
        tumble.fit(TABLE_1, monte_carlo=3)


def test_a_rejected_fit_warns() -> None:
    question = {**LINE, "readings": [{"x": 1, "y": 1}, {"x": 1, "y": 3}]}
    with pytest.warns(tumble.RejectedWarning):
        fit = tumble.fit(question)
    assert fit.rejected and fit["a"].value is None and fit["a"].state == "not-estimable"
    assert np.isnan(fit.covariance).all()


def test_the_report_has_the_keys_of_the_program() -> None:
    _, out, _ = tumble.run("fit", TABLE_1, "--json", "-")
    program = json.loads(out)
    own = tumble.fit(TABLE_1).report
    assert {key for key in program if key != "inputs"} == set(own)
    assert program["parameters"] == own["parameters"]
    assert own.parameters[0].id == program["parameters"][0]["id"] and own.parameters[1].arcsec is not None
    assert own.fit.dof == 24 and own.parameters[0].budget[0].type in ("A", "B")
    with pytest.raises(AttributeError, match="expected one of"):
        own.nothing  # type: ignore[attr-defined]


def test_readings_with_residuals() -> None:
    readings = tumble.fit(LINE).readings
    # residuals of the line: -1/6, 1/3, -1/6
    assert readings.residual == pytest.approx([-1 / 6, 1 / 3, -1 / 6], abs=1e-14)
    assert readings.index.tolist() == [1, 2, 3] and readings.sensor == ["y"] * 3
    assert readings.redundancy.sum() == pytest.approx(1)


def test_a_second_language() -> None:
    fit = tumble.fit(TABLE_1)
    assert fit.table(lang="zh") != fit.table() and 'lang="zh' in fit.page(lang="zh")
    with pytest.raises(ValueError, match="'xx'"):
        fit.table(lang="xx")  # type: ignore[arg-type]


def test_a_notebook_shows_the_page() -> None:
    fit = tumble.fit(TABLE_1)
    shown = fit._repr_html_()
    assert shown.startswith("<div") and "dtheta_y2" in shown and "<svg" in shown and "@scope" in shown
    pictures = fit.figures()
    assert len(pictures) > 2 and pictures[0]._repr_svg_().startswith("<svg") and pictures[0].caption


def test_simulated_readings_come_back() -> None:
    truth = {"values": {"a": {"value": 2.0}, "b": {"value": -1.0}}, "noise": {"y": {"sd": 0.0}}}
    fit = tumble.fit(tumble.simulate(LINE, truth, seed=3))
    assert fit["a"].value == pytest.approx(2, abs=1e-12) and fit["b"].value == pytest.approx(-1, abs=1e-12)
    folder = EXAMPLES / "07-hidden-effect"
    made = tumble.simulate(folder / "schedule.campaign.json", folder / "hidden.truth.json", seed=7)
    assert made["readings"] == json.loads((folder / "measured.campaign.json").read_text())["readings"]


def test_samples_as_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # the same line, its readings the rows of a record
    (tmp_path / "log.csv").write_text("x,y\n0,1\n1,3\n2,4\n")
    campaign = {**LINE, "readings": {"samples": "log.csv", "as": "rows"}}
    path = tmp_path / "line.campaign.json"
    path.write_text(json.dumps(campaign))
    fit = tumble.fit(path)
    assert fit["b"].value == pytest.approx(1.5, abs=1e-12)
    assert fit["b"].u == pytest.approx(math.sqrt(1 / 12), rel=1e-9)
    assert fit.report.record is not None
    monkeypatch.chdir(tmp_path)
    assert tumble.fit(campaign)["b"].value == pytest.approx(1.5, abs=1e-12)
    with pytest.raises(tumble.MalformedError, match="other.csv"):
        tumble.fit({**LINE, "readings": {"samples": "other.csv", "as": "rows"}})
