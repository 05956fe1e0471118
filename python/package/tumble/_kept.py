"""A fit as its report keeps it: what `Fit` asks of the engine, from JSON."""

from __future__ import annotations

import json
from typing import Any, NoReturn

import numpy as np

from . import _tumble


class Kept:
    """In the place of `_tumble.Fit`. The page and predictions need the readings and the model, which a report does not have."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._data: dict[str, Any] = json.loads(text)
        if self._data.get("report") != "fit":
            raise ValueError("this is no report of a fit: expected what tumble.Fit.save or tumble fit --json wrote")

    def rejected(self) -> bool:
        conformity = self._data.get("conformity") or {}
        return bool(self._data["fit"].get("rejected")) or conformity.get("outcome") == "fail"

    def parameters(self) -> list[tuple[Any, ...]]:
        found = []
        for own in [*self._data["parameters"], *self._data["derived"]]:
            said = own.get("arcsec") or own
            unit = "arcsec" if own.get("arcsec") else own["unit"]
            kind, state = own.get("kind", "derived"), own.get("state", "derived")
            found.append((own["id"], kind, unit, said.get("value"), said.get("u"), said.get("U"), own.get("dof"), own.get("k"), state))
        return found

    def order(self) -> list[str]:
        return list(self._data["covariance"]["order"])

    def covariance(self) -> bytes:
        rows = self._data["covariance"]["matrix"]
        return np.array([[np.nan if own is None else own for own in row] for row in rows], dtype=np.float64).tobytes()

    def readings(self) -> tuple[int, bytes, list[str], list[str]]:
        rows = self._data["readings"]
        keys = ("index", "value", "fitted", "residual", "redundancy", "studentized")
        flat = np.array([[np.nan if row.get(key) is None else row[key] for key in keys] for row in rows], dtype=np.float64)
        return len(rows), flat.tobytes(), [row["sensor"] for row in rows], [row["position"] for row in rows]

    def report(self) -> str:
        return self._text

    def table(self, listed: bool, lang: str) -> str:
        return _tumble.report_table(self._text, listed, lang)

    def page(self, lang: str) -> NoReturn:
        raise RuntimeError("this fit was read from its report, which has no page: expected a fit by tumble.fit")

    def predict(self, rows: str) -> NoReturn:
        raise RuntimeError("this fit was read from its report, which has no model to predict with: expected a fit by tumble.fit")
