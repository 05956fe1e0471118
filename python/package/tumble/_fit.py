"""`tumble.fit`: one device."""

from __future__ import annotations

import json
import math
import os
import warnings
from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _tumble, reports
from ._kept import Kept
from ._question import Asked, Question, dumps
from ._report import Figure, Lang, RejectedWarning, State, excerpt, figures, residual_plot
from ._tables import Frames, Table, columns_of
from ._types import How

Robust = Literal["huber", "tukey", "l1"]
Remount = Union[Literal["estimate"], float]


@dataclass(frozen=True)
class Parameter:
    """An estimated parameter or a derived quantity, in `unit`: angles are in arcsec here, and in rad in `fit.report` and `fit.covariance`."""

    id: str
    """Its name in the bench, or in the campaign's `derived`."""
    kind: str
    """`tilt`, `coefficient` or `derived`."""
    unit: str
    """Unit of `value`, `u` and `U`."""
    value: Optional[float]
    """Estimate; None where it is not estimable."""
    u: Optional[float]
    """Combined standard uncertainty; None where it cannot be known."""
    U: Optional[float]
    """Expanded uncertainty, `k u`, at the level of the fit."""
    dof: Optional[float]
    """Effective degrees of freedom; None where they are infinite."""
    k: Optional[float]
    """Coverage factor."""
    state: State
    """`free`, `at-bound`, `fixed` or `not-estimable`; `derived` for a derived quantity."""

    def __str__(self) -> str:
        if self.value is None:
            return f"{self.id}: {self.state}"
        if not self.U or self.k is None or not math.isfinite(self.U):
            return f"{self.id} = {self.value:.6g} {self.unit}".rstrip()
        # GUM 7.2.6: U to two significant digits, the value to the same place
        places = max(1 - int(f"{self.U:.1e}".partition("e")[2]), 0)
        return f"{self.id} = {self.value:.{places}f} +- {self.U:.{places}f} (k = {self.k:.2f}) {self.unit}".rstrip()


class Readings(Frames):
    """The readings of a fit, a value each, as columns of one length."""

    def __init__(self, numbers: NDArray[np.float64], sensor: list[str], position: list[str]) -> None:
        self.index: NDArray[np.int64] = numbers[:, 0].astype(np.int64)
        """Number of the reading, from 1."""
        self.sensor: list[str] = sensor
        """Sensor that was read."""
        self.position: list[str] = position
        """Label of the position."""
        self.value: NDArray[np.float64] = numbers[:, 1]
        """What was read, in the sensor's unit."""
        self.fitted: NDArray[np.float64] = numbers[:, 2]
        """What the model says, in the sensor's unit."""
        self.residual: NDArray[np.float64] = numbers[:, 3]
        """Value minus fitted, in the sensor's unit."""
        self.redundancy: NDArray[np.float64] = numbers[:, 4]
        """Redundancy number, 0 to 1."""
        self.studentized: NDArray[np.float64] = numbers[:, 5]
        """Studentized residual; NaN where there is none."""

    def __len__(self) -> int:
        return len(self.sensor)

    def _columns(self) -> dict[str, Any]:
        names = ("index", "position", "sensor", "value", "fitted", "residual", "redundancy", "studentized")
        return {name: getattr(self, name) for name in names}


class Fit(Mapping[str, Parameter], Frames):
    """A fit. `fit["dtheta_y2"]` is a `Parameter`, the whole report is `fit.report`; `print(fit)` shows the program's table."""

    def __init__(self, core: Union[_tumble.Fit, Kept], titles: dict[str, str] = {}) -> None:
        self._core, self._titles = core, titles
        self.rejected: bool = core.rejected()
        """Exit code 2 of the program: a rank defect, a failed global test, outside the limits."""

    @cached_property
    def parameters(self) -> dict[str, Parameter]:
        """Estimated parameters and derived quantities by name, in the campaign's order."""
        return {own[0]: Parameter(*own) for own in self._core.parameters()}

    def __getitem__(self, key: str) -> Parameter:
        try:
            return self.parameters[key]
        except KeyError:
            raise KeyError(f"no estimated or derived quantity is called '{key}': expected one of {', '.join(self.parameters)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.parameters)

    def __len__(self) -> int:
        return len(self.parameters)

    @cached_property
    def order(self) -> list[str]:
        """Estimated parameters in the order of the covariance's rows."""
        return list(self._core.order())

    @cached_property
    def covariance(self) -> NDArray[np.float64]:
        """Covariance of the estimated parameters, shape (n, n) in the order of `order`; angles in rad, NaN where not estimable."""
        flat = np.frombuffer(self._core.covariance(), dtype=np.float64)
        n = math.isqrt(flat.size)
        return flat.reshape(n, n)

    @cached_property
    def correlation(self) -> NDArray[np.float64]:
        """Correlation of the estimated parameters, shape (n, n)."""
        sd = np.sqrt(np.diag(self.covariance))
        with np.errstate(divide="ignore", invalid="ignore"):
            found: NDArray[np.float64] = self.covariance / np.outer(sd, sd)
        return found

    @cached_property
    def report(self) -> reports.FitReport:
        """The report of `tumble fit --json`, with its keys as attributes."""
        return reports.FitReport(json.loads(self._core.report()), self.rejected, self.__str__, self.page)

    @cached_property
    def _summary(self) -> dict[str, Any]:
        """The report without its readings, which are most of it."""
        found: dict[str, Any] = json.loads(self._core.summary())
        return found

    @cached_property
    def readings(self) -> Readings:
        """The readings with residuals, as columns."""
        count, flat, sensor, position = self._core.readings()
        return Readings(np.frombuffer(flat, dtype=np.float64).reshape(count, 6), sensor, position)

    def table(self, readings: bool = False, lang: Lang = "en") -> str:
        """The table of the terminal, with every reading if asked for; `lang`: `en` or `zh`."""
        return self._core.table(readings, lang)

    def page(self, lang: Lang = "en") -> str:
        """The HTML page, as `--html` writes it: one file that stands alone."""
        return self._core.page(lang)

    def figures(self) -> list[Figure]:
        """The pictures of the page, as SVG; a notebook shows each."""
        return figures(self.page())

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Write the report as JSON: a calibration, as `compare`, `apply` and `export` read it."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self._core.report() + "\n")

    @classmethod
    def load(cls, path: Union[str, "os.PathLike[str]"]) -> Fit:
        """A fit from the JSON that `save` or `tumble fit --json` wrote. It has everything but `predict` of other readings and what only the bench says: its
        title, its picture on the page, the unit of the residual standard deviation."""
        with open(path, encoding="utf-8") as file:
            return cls(Kept(file.read()))

    def __reduce__(self) -> tuple[Any, ...]:
        # another process gets the report, and what was printed of it
        return _kept, (self._core.report(), str(self))

    def __copy__(self) -> Fit:
        return Fit(self._core, self._titles)

    def __deepcopy__(self, memo: dict[int, Any]) -> Fit:
        # what the engine found never changes
        return copy(self)

    def _of(self, key: str) -> list[float]:
        return [math.nan if own.get(key) is None else own[key] for own in self._summary["parameters"]]

    def _series(self, values: Sequence[float], name: str) -> Any:
        try:
            import pandas
        except ImportError:
            return dict(zip(self.order, values))
        return pandas.Series(values, index=self.order, name=name)

    @property
    def params(self) -> Any:
        """Estimates in the units of `covariance`, tilts in rad (`fit[name]` has them in arcsec): a pandas Series where pandas is installed, else a dict.
        As everything in these units, without derived quantities, which have no row in the covariance."""
        return self._series(self._of("value"), "value")

    @property
    def bse(self) -> Any:
        """Standard uncertainties in the units of `covariance`, as `params`."""
        return self._series(self._of("u"), "u")

    @property
    def tvalues(self) -> Any:
        """Estimates over their standard uncertainties, as `params`."""
        return self._series([value / u if u else math.nan for value, u in zip(self._of("value"), self._of("u"))], "t")

    @property
    def nobs(self) -> int:
        """Values that were read."""
        return int(self._summary["fit"]["readings"])

    @property
    def df_resid(self) -> int:
        """Degrees of freedom of the residuals."""
        return int(self._summary["fit"]["dof"])

    @property
    def fittedvalues(self) -> dict[str, NDArray[np.float64]]:
        """What the model says of every reading, by sensor: `predict()`."""
        return self.predict()

    def summary(self) -> str:
        """The table of the terminal: `str(fit)`."""
        return str(self)

    def cov_params(self) -> Any:
        """`cov`, as statsmodels calls it."""
        return self.cov

    @property
    def cov(self) -> Any:
        """The covariance with names: a pandas DataFrame where pandas is installed, else the array."""
        try:
            import pandas
        except ImportError:
            return self.covariance
        return pandas.DataFrame(self.covariance, index=self.order, columns=self.order)

    def conf_int(self, *, level: Optional[float] = None, alpha: Optional[float] = None) -> Any:
        """`value -+ U` in the units of `covariance`: a DataFrame (lower, upper), else a dict of pairs. level: coverage probability (that of the fit); or
        alpha, one minus it."""
        if level is not None and alpha is not None:
            raise TypeError("conf_int() takes level= or alpha=, not both")
        level = 1 - alpha if alpha is not None else level
        half = self._of("U") if level is None else self._expanded(level)
        pairs = [(value - own, value + own) for value, own in zip(self._of("value"), half)]
        try:
            import pandas
        except ImportError:
            return dict(zip(self.order, pairs))
        return pandas.DataFrame(pairs, index=self.order, columns=["lower", "upper"])

    def _expanded(self, level: float) -> list[float]:
        if not 0 < level < 1:
            raise _tumble.MalformedError(f"the level is not a probability: expected a number between 0 and 1, for example 0.95; found {level}")
        # no degrees of freedom in the report: infinitely many
        dof = (math.inf if math.isnan(own) else own for own in self._of("dof"))
        return [u * (_tumble.coverage_factor(level, own) or math.nan) for u, own in zip(self._of("u"), dof)]

    def predict(self, readings: Optional[Table] = None) -> dict[str, NDArray[np.float64]]:
        """What the fitted model says of further readings (a table as `fit` takes it; the sensors' columns may be left out), by sensor, NaN where a cell that
        it needs is empty; of its own readings without an argument. Written times count from the first of the table."""
        if readings is None:
            own = self.readings
            return {name: own.fitted[[sensor == name for sensor in own.sensor]] for name in dict.fromkeys(own.sensor)}
        values = self._core.predict(columns_of(readings), self._titles)
        return {sensor: np.frombuffer(flat, dtype=np.float64) for sensor, flat in values}

    @property
    def resid(self) -> dict[str, NDArray[np.float64]]:
        """Value minus fitted of every reading, by sensor, as `predict()` has the fitted ones."""
        own = self.readings
        return {name: own.residual[[sensor == name for sensor in own.sensor]] for name in dict.fromkeys(own.sensor)}

    def _determined(self) -> tuple[list[str], list[float], NDArray[np.float64]]:
        """Names, estimates and covariance of the parameters that the readings determine."""
        values = self._of("value")
        at = [k for k, value in enumerate(values) if math.isfinite(value) and math.isfinite(self.covariance[k, k])]
        return [self.order[k] for k in at], [values[k] for k in at], self.covariance[np.ix_(at, at)]

    def to_ufloats(self) -> dict[str, Any]:
        """The estimates as numbers of the package `uncertainties`, correlated as they are, in the units of `covariance`, without derived quantities."""
        import uncertainties

        names, values, covariance = self._determined()
        if not names:
            return {}
        return dict(zip(names, uncertainties.correlated_values(values, covariance.tolist(), tags=names)))

    def to_gtc(self) -> dict[str, Any]:
        """The estimates as uncertain numbers of the GUM Tree Calculator (`GTC`), correlated as they are, in the units of `covariance`, without derived
        quantities.

        GTC gives numbers that are estimated together the same degrees of freedom: the fewest among theirs.
        """
        import GTC

        names, values, covariance = self._determined()
        u = np.sqrt(np.diag(covariance))
        dof = min((own["dof"] for own in self._summary["parameters"] if own["id"] in names and own.get("dof") is not None), default=math.inf)
        found = dict(zip(names, GTC.multiple_ureal(values, u.tolist(), dof, label_seq=names)))
        for i, first in enumerate(names):
            for j, second in enumerate(names[:i]):
                if u[i] > 0 and u[j] > 0:
                    GTC.set_correlation(float(covariance[i, j] / (u[i] * u[j])), found[first], found[second])
        return found

    def plot(self, ax: Any = None) -> Any:
        """Residuals over the number of the reading, a colour for each sensor, with matplotlib; the axes."""
        own = self.readings
        return residual_plot(own.sensor, own.index, [(own.residual, True, "")], ax)

    def _columns(self) -> dict[str, Any]:
        rows = list(self.parameters.values())
        texts = {name: [getattr(p, name) for p in rows] for name in ("id", "unit", "state")}
        numbers = {name: np.array([getattr(p, name) for p in rows], dtype=float) for name in ("value", "u", "U", "dof", "k")}
        return {"id": texts["id"], **numbers, "unit": texts["unit"], "state": texts["state"]}

    def __str__(self) -> str:
        return self.table()

    def __repr__(self) -> str:
        return f"<Fit of {len(self.order)} parameters{', rejected' if self.rejected else ''}>"

    def _repr_html_(self) -> str:
        return excerpt(self.page())


def _kept(report: str, table: str) -> Fit:
    return Fit(Kept(report, table))


def why(report: Mapping[str, Any]) -> str:
    """What of a report makes the fit rejected, in words."""
    found = [f"{own['text']} is not estimable" for own in report["not_estimable"]]
    if report["fit"].get("global_test_rejected"):
        found.append(f"the global test has p = {report['fit']['p']:.3g}")
    if not (report.get("convergence") or {}).get("converged", True):
        found.append("no convergence")
    limited = (report.get("conformity") or {}).get("quantities", [])
    found += [f"{own['id']} lies outside its limits" for own in limited if own["outcome"] == "fail"]
    return "; ".join(found) or "print it to see why"


def settings(linear: bool, relative: bool, level: float, robust: Optional[str], remount: Optional[Remount]) -> How:
    """How to fit, as the engine takes it."""
    word = None if remount is None else str(remount)
    return {"linear": linear, "relative": relative, "level": level, "robust": robust, "remount": word}


def fit(
    campaign: Question,
    readings: Optional[Table] = None,
    *,
    linear: bool = False,
    relative: bool = False,
    level: float = 0.95,
    robust: Optional[Robust] = None,
    remount: Optional[Remount] = None,
    monte_carlo: Optional[int] = None,
    seed: int = 1,
) -> Fit:
    """Estimate every angle and coefficient of a campaign, each with its uncertainty.

    `x = argmin sum ((reading - f(x)) / u)^2` on the exact model, to convergence.

    campaign: a file, or a dict of the same form. readings: a table (see `Table`) or the path of one, in place of the campaign's.
    linear: one least-squares step from the reference point, the papers' estimator. relative: stated uncertainties are weights only.
    level: coverage probability of `U`. robust: bear bad readings. remount: readings that share a position share an offset, with this standard
    uncertainty (in the sensor's unit), or one that is estimated. monte_carlo: so many trials beside the first order (GUM Supplements 1 and 2),
    in `fit.report.monte_carlo`.

    Raises `MalformedError`. Warns `RejectedWarning` where the answer is rejected.

        >>> line = {"bench": {"id": "line", "sensors": {"y": {"model": "a + b*x"}}}, "estimate": {"a": {}, "b": {}}}
        >>> found = fit(line, {"x": [0, 1, 2], "y": [1, 3, 4]})
        >>> round(found["b"].value, 12), round(found["b"].u, 4)
        (1.5, 0.2887)
    """
    asked = Asked(campaign, readings)
    trials = None if monte_carlo is None else (monte_carlo, seed)
    how = settings(linear, relative, level, robust, remount)
    found = Fit(_tumble.fit(asked.content, asked.name, asked.folder, dumps, asked.table, how, trials), asked.titles)
    if found.rejected:
        warnings.warn(f"the fit is rejected: {why(found._summary)}", RejectedWarning, stacklevel=2)
    return found
