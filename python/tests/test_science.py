"""A fit as data scientists use one: copied, pickled, loaded, predicted with, as pandas, as a picture."""

import copy
import pickle
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import tumble
from cases import EXAMPLES

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
    with pytest.raises(RuntimeError, match="no page"):
        others[2].page()
    (tmp_path / "other.json").write_text("{}")
    with pytest.raises(ValueError, match="no report of a fit"):
        tumble.Fit.load(tmp_path / "other.json")


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


def test_predictions(fit: tumble.Fit) -> None:
    a, b = fit.params
    for table in ({"x": [5.0, 6.0]}, pd.DataFrame({"x": [5.0, 6.0]}), [{"x": 5.0}, {"x": 6.0}]):
        assert np.allclose(fit.predict(table)["y"], [a + 5 * b, a + 6 * b], rtol=1e-14)
    assert np.allclose(fit.predict()["y"], a + b * X, rtol=1e-14)


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
