"""Fits as their reports keep them, and devices as they were pickled: what `Fit` and `Devices` ask of the engine."""

from __future__ import annotations

import json
from typing import Any, ClassVar, NoReturn

import numpy as np

from . import _tumble


class Kept:
    """In the place of `_tumble.Fit`. Predictions need the model with its bench, which a report does not have; nor does its page show the bench."""

    def __init__(self, text: str, table: str = "") -> None:
        self._text, self._table = text, table
        try:
            self._data: dict[str, Any] = json.loads(text)
        except ValueError:
            self._data = {}
        if self._data.get("report") != "fit":
            raise ValueError("this is not a report of a fit: expected what tumble.Fit.save or tumble fit --json wrote")

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

    summary = report

    def table(self, listed: bool, lang: str) -> str:
        # as the fit itself printed it, with the words and units of its bench
        printed = "" if listed or lang != "en" else self._table
        return printed or _tumble.report_table(self._text, listed, lang)

    def page(self, lang: str) -> str:
        return _tumble.report_page(self._text, lang)

    def predict(self, table: Any, titles: dict[str, str]) -> NoReturn:
        raise RuntimeError("this fit was read from its report, which has no model to predict with: expected a fit by tumble.fit")


class Answers:
    """In the place of `_tumble.Devices`: what it answered before it was pickled."""

    ASKED: ClassVar[list[tuple[Any, ...]]] = [
        ("quantities",), ("verdicts",), ("labels",), ("why",), ("report",), ("table", 0, "en"), ("table", 40, "en"), ("page", "en"),
        *(("matrix", of) for of in ("value", "u", "U", "type_a")),
        *(("column", of) for of in ("residual_sd", "chi_square_p", "lack_of_fit_p", "runs_p", "normality_p", "dof", "rank", "readings")),
    ]

    def __init__(self, answers: dict[tuple[Any, ...], Any]) -> None:
        self._answers = answers

    @classmethod
    def of(cls, core: Any) -> dict[tuple[Any, ...], Any]:
        """What a core answers."""
        return {asked: getattr(core, asked[0])(*asked[1:]) for asked in cls.ASKED}

    def __len__(self) -> int:
        return len(self._answers["labels",])

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)

        def answer(*arguments: Any) -> Any:
            if (name, *arguments) not in self._answers:
                raise RuntimeError(f"these devices were pickled, without {name}{arguments}: expected those of tumble.fit_devices")
            return self._answers[name, *arguments]

        return answer
