"""A fit as data scientists use one: copied, pickled, loaded, predicted with, as pandas, as a picture."""

import copy
import json
import pickle
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import tumble
from cases import EXAMPLES, TABLE_1

X = np.array([0.0, 1.0, 2.0, 3.0])
LINE = {"bench": {"id": "line", "sensors": {"y": {"model": "a + b*x"}}}, "estimate": {"a": {}, "b": {}}}


@pytest.fixture
def fit() -> tumble.Fit:
    return tumble.fit(LINE, {"x": X, "y": np.array([1.0, 3.0, 4.0, 6.5])})


def test_copies_and_pickles_say_the_same(fit: tumble.Fit, tmp_path: Path) -> None:
    fit.save(tmp_path / "fit.json")
    others = (copy.copy(fit), copy.deepcopy(fit), pickle.loads(pickle.dumps(fit)), tumble.Fit.load(tmp_path / "fit.json"))
    for other in others:
        assert dict(other) == dict(fit) and other.rejected == fit.rejected and str(other) == str(fit)
        assert np.array_equal(other.covariance, fit.covariance) and np.array_equal(other.readings.residual, fit.readings.residual)
        assert "<svg" in other.page() and other._repr_html_().startswith("<div") and other.figures()
    with pytest.raises(RuntimeError, match="no model"):
        others[2].predict({"x": [1.0]})
    for text in ("{}", "words"):
        (tmp_path / "other.json").write_text(text)
        with pytest.raises(ValueError, match="not a report of a fit"):
            tumble.Fit.load(tmp_path / "other.json")


def test_pickles_print_the_words_of_the_bench() -> None:
    table = tumble.fit(TABLE_1)
    other = pickle.loads(pickle.dumps(table))
    assert str(other) == str(table) and str(pickle.loads(pickle.dumps(other))) == str(table)
    report = pickle.loads(pickle.dumps(table.report))
    assert report.data == table.report.data and str(report) == str(table)
    with pytest.warns(tumble.RejectedWarning):
        found = tumble.diagnose(EXAMPLES / "07-hidden-effect/measured.campaign.json")
    again = pickle.loads(pickle.dumps(found))
    assert again.data == found.data and str(again) == str(found) and again.page() == found.page()


def test_pandas(fit: tumble.Fit) -> None:
    # the normal equations of four points, by hand
    design = np.column_stack([np.ones(4), X])
    y = np.array([1.0, 3.0, 4.0, 6.5])
    best, rest, *_ = np.linalg.lstsq(design, y, rcond=None)
    cov = np.linalg.inv(design.T @ design) * rest[0] / 2
    assert list(fit.params.index) == ["a", "b"] and np.allclose(fit.params, best, rtol=1e-12)
    assert np.allclose(fit.bse, np.sqrt(np.diag(cov)), rtol=1e-12) and np.allclose(fit.cov.to_numpy(), cov, rtol=1e-12)
    # Student's t with two degrees of freedom, 97.5 %: sqrt(2) * 0.95 / sqrt(1 - 0.95^2)
    k = 2**0.5 * 0.95 / (1 - 0.95**2) ** 0.5
    assert np.allclose(fit.conf_int()["upper"] - fit.params, k * fit.bse, rtol=1e-9)
    # the same with 99.5 %
    k = 2**0.5 * 0.99 / (1 - 0.99**2) ** 0.5
    for wide in (fit.conf_int(level=0.99), fit.conf_int(alpha=0.01)):
        assert np.allclose(fit.params - wide["lower"], k * fit.bse, rtol=1e-9)
    for wrong, error in (({"level": 2}, tumble.MalformedError), ({"level": 0.9, "alpha": 0.1}, TypeError)):
        with pytest.raises(error):
            fit.conf_int(**wrong)
    assert fit.nobs == 4 and fit.df_resid == 2 and fit.cov_params().equals(fit.cov) and fit.summary() == str(fit)
    assert np.allclose(fit.tvalues, best / np.sqrt(np.diag(cov)), rtol=1e-12) and np.allclose(fit.fittedvalues["y"], design @ best, rtol=1e-12)
    assert tumble.fit(LINE, {"x": [0, 1], "y": [1, 2]}).to_ufloats() == {}


def test_estimates_without_the_report(fit: tumble.Fit, monkeypatch: pytest.MonkeyPatch) -> None:
    # which takes a kilobyte for each reading
    monkeypatch.delattr(tumble.Fit, "report")
    assert len(fit.params) == len(fit.bse) == len(fit.conf_int()) == 2 and fit.nobs == 4


def test_predictions(fit: tumble.Fit) -> None:
    a, b = fit.params
    for table in ({"x": [5.0, 6.0]}, pd.DataFrame({"x": [5.0, 6.0]}), [{"x": 5.0}, {"x": 6.0}]):
        assert np.allclose(fit.predict(table)["y"], [a + 5 * b, a + 6 * b], rtol=1e-14)
    assert np.allclose(fit.predict()["y"], a + b * X, rtol=1e-14)
    # gaps in what the model reads are gaps; in what it does not read they are nothing
    table = pd.DataFrame({"x": [np.nan, "5", 6, None], "y": [1.0, np.nan, np.nan, 2.0], "y_u": 0.1, "note": [[1], None, "a", b"b"]})
    assert np.allclose(fit.predict(table)["y"], [np.nan, a + 5 * b, a + 6 * b, np.nan], rtol=1e-14, equal_nan=True)
    assert np.isnan(fit.predict({"x": [None, np.nan]})["y"]).all()


def test_predictions_for_the_table_itself() -> None:
    table = pd.DataFrame({"Pos (m)": pd.date_range("2024-01-01", periods=4, freq="s"), "Read": [1.0, 3.0, 4.0, 6.5], "z": [1.0, np.nan, 1.0, 1.0]})
    named = tumble.fit({**LINE, "columns": {"x": "Pos (m)", "y": "Read"}}, table)
    for own in (table, table[["Pos (m)"]], {"x": X}):
        assert np.allclose(named.predict(own)["y"], named.predict()["y"], rtol=1e-14)
    gyro = tumble.fit(TABLE_1)
    rows = pd.DataFrame(json.loads(TABLE_1.read_text())["readings"])
    assert np.allclose(gyro.predict(rows)["V"], gyro.predict()["V"], rtol=1e-12)
    rows.loc[0, "alpha_deg"] = np.nan
    gap = gyro.predict(rows)["V"]
    assert np.isnan(gap[0]) and np.allclose(gap[1:], gyro.predict()["V"][1:], rtol=1e-12)


def test_residuals_by_name(fit: tumble.Fit) -> None:
    a, b = fit.params
    assert list(fit.resid) == ["y"] and np.allclose(fit.resid["y"], np.array([1.0, 3.0, 4.0, 6.5]) - (a + b * X), atol=1e-14)


def test_numbers_with_their_correlations(fit: tumble.Fit) -> None:
    # u of the line at x = 5, (1, 5) C (1, 5)': without the correlation it would be 1.45 times as much
    cov = fit.cov.to_numpy()
    u = float(np.sqrt(cov[0, 0] + 10 * cov[0, 1] + 25 * cov[1, 1]))
    pytest.importorskip("uncertainties")
    own = fit.to_ufloats()
    there = own["a"] + 5 * own["b"]
    assert np.isclose(there.s, u, rtol=1e-12) and np.isclose(there.n, fit.params["a"] + 5 * fit.params["b"])
    pytest.importorskip("GTC")
    gtc = fit.to_gtc()
    there = gtc["a"] + 5 * gtc["b"]
    assert np.isclose(there.u, u, rtol=1e-12) and np.isclose(there.df, 2.0)


def test_the_plot_of_the_gap() -> None:
    pytest.importorskip("matplotlib").use("agg")
    with pytest.warns(tumble.RejectedWarning):
        found = tumble.diagnose(EXAMPLES / "05-table-1-diagnosed/table1.campaign.json")
    before, after = found.plot().get_lines()[:2]
    rows = found.data["residuals"]
    assert np.allclose(before.get_ydata(), [own["before"] for own in rows])
    assert np.allclose(after.get_ydata(), [own["after"] for own in rows])
    # the effect explains 90 % of the sum of squares (example 05)
    assert np.sum(np.square(after.get_ydata())) < 0.2 * np.sum(np.square(before.get_ydata()))


def test_the_plot(fit: tumble.Fit) -> None:
    pytest.importorskip("matplotlib").use("agg")
    line = fit.plot().get_lines()[0]
    assert np.allclose(line.get_ydata(), fit.readings.residual)


def test_the_warning_says_why() -> None:
    with pytest.warns(tumble.RejectedWarning, match="a .* is not estimable"):
        tumble.fit({**LINE, "bench": {"id": "sum", "sensors": {"y": {"model": "a + b + 0*x"}}}}, {"x": X, "y": X})
    with pytest.warns(tumble.RejectedWarning, match="global test has p = "):
        tumble.fit(LINE, {"x": X, "y": [1.0, 3.0, 4.0, 6.5], "y_u": [0.01] * 4})
