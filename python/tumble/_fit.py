"""`tumble.fit`."""

from __future__ import annotations

import html
import json
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal, Optional, Union

from . import _tumble
from ._question import Question, text_of
from ._report import RejectedWarning, Report


@dataclass(frozen=True)
class Parameter:
    """An estimated parameter or a derived quantity, in `unit`; tilts are in arcsec here and in rad in the report's `value`."""

    id: str
    value: Optional[float]
    u: Optional[float]
    """Combined standard uncertainty."""
    U: Optional[float]
    """Expanded uncertainty, `k u`, at the level of the fit."""
    dof: Optional[float]
    """Effective degrees of freedom; None where they are infinite."""
    k: Optional[float]
    unit: str
    state: str
    """`free`, `at-bound`, `not-estimable`, `derived`."""

    def __str__(self) -> str:
        if self.value is None:
            return f"{self.id}: {self.state}"
        spread = "" if self.U is None else f" +- {self.U:.3g} (k = {self.k:.2f})"
        return f"{self.id} = {self.value:.6g}{spread} {self.unit}".rstrip()


class Fit(Report):
    """A fit. `fit["dtheta_y2"]` is a `Parameter`; the whole report is `fit.data`."""

    def __init__(self, data: dict[str, Any], rejected: bool, table: Any, page: Any) -> None:
        super().__init__(data, rejected, table, page)
        found = [_parameter(own) for own in data["parameters"]] + [_parameter(own, "derived") for own in data.get("derived", [])]
        self.parameters: dict[str, Parameter] = {own.id: own for own in found}

    def __getitem__(self, key: str) -> Any:
        return self.parameters[key] if key in self.parameters else super().__getitem__(key)

    def __iter__(self) -> Iterator[str]:
        yield from self.parameters
        yield from (key for key in self.data if key not in self.parameters)

    def __len__(self) -> int:
        return sum(1 for _ in self)

    @property
    def order(self) -> list[str]:
        """Parameters in the order of the covariance's rows."""
        return list(self.data["covariance"]["order"])

    @property
    def covariance(self) -> Any:
        """Covariance of the estimated parameters as a numpy array; tilts in rad, NaN where not estimable."""
        return self._matrix("covariance")

    @property
    def correlation(self) -> Any:
        """Correlation of the estimated parameters as a numpy array."""
        return self._matrix("correlation")

    def _matrix(self, key: str) -> Any:
        import numpy as np

        return np.array(self.data[key]["matrix"], dtype=float)

    def to_pandas(self) -> Any:
        """Parameters as a DataFrame, one row each."""
        import pandas as pd

        rows = [[p.value, p.u, p.U, p.dof, p.k, p.unit, p.state] for p in self.parameters.values()]
        return pd.DataFrame(rows, index=list(self.parameters), columns=["value", "u", "U", "dof", "k", "unit", "state"])

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{name}</th>" for name in ("parameter", "estimate", "u", "U", "k", "unit", "state"))
        number = lambda value, form: "-" if value is None else format(value, form)  # noqa: E731
        rows = "".join(
            f"<tr><td>{html.escape(p.id)}</td><td>{number(p.value, '.7g')}</td><td>{number(p.u, '.2g')}</td>"
            f"<td>{number(p.U, '.2g')}</td><td>{number(p.k, '.2f')}</td><td>{html.escape(p.unit)}</td><td>{p.state}</td></tr>"
            for p in self.parameters.values()
        )
        verdict = "<p><b>rejected</b>: see <code>print(fit)</code></p>" if self.rejected else ""
        return f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>{verdict}"


def _parameter(own: Mapping[str, Any], state: Optional[str] = None) -> Parameter:
    shown = own.get("arcsec") or own
    number = lambda key: shown.get(key)  # noqa: E731
    return Parameter(
        id=own["id"], value=number("value"), u=number("u"), U=number("U"), dof=own.get("dof"), k=own.get("k"),
        unit="arcsec" if own.get("arcsec") else own.get("unit", ""), state=state or own.get("state", ""),
    )


def fit(
    campaign: Question,
    readings: Any = None,
    *,
    linear: bool = False,
    relative: bool = False,
    level: float = 0.95,
    robust: Optional[Literal["huber", "tukey", "l1"]] = None,
    remount: Union[Literal["estimate"], float, None] = None,
) -> Fit:
    """Estimate every angle and coefficient of a campaign, each with its uncertainty.

    `campaign` is a file or a dict of the same form, `readings` a table that takes the place of its readings. `linear` is one least-squares
    step (the papers' estimator), `relative` takes stated uncertainties as weights only, `level` is the coverage probability of `U`.
    """
    name, text, folder = text_of(campaign, readings)
    word = None if remount is None else str(remount)

    def made(form: str) -> tuple[str, bool]:
        return _tumble.fit(name, text, folder, linear, relative, level, robust, word, form)

    report, rejected = made("report")
    if rejected:
        warnings.warn("the fit is rejected; print it to see why", RejectedWarning, stacklevel=2)
    return Fit(json.loads(report), rejected, lambda: made("table")[0], lambda: made("page")[0])
