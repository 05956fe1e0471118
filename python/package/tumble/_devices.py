"""`tumble.fit_devices`: many devices, arrays in and arrays out."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _tumble, reports
from ._fit import Remount, Robust, settings
from ._kept import Answers
from ._question import Asked, Question, dumps
from ._report import Figure, Lang, RejectedWarning, excerpt, figures
from ._tables import Frames, Path_, Table

VERDICTS = np.array(["accepted", "rejected", "malformed"])
OUTCOMES = np.array(["pass", "undecided", "fail", ""])


@dataclass(frozen=True)
class Quantity:
    """A parameter or derived quantity of every device, in `unit` (angles in arcsec); arrays of shape (devices,), NaN where there is none."""

    id: str
    unit: str
    value: NDArray[np.float64]
    """Estimates."""
    u: NDArray[np.float64]
    """Combined standard uncertainties."""
    U: NDArray[np.float64]
    """Expanded uncertainties at the level of the fit."""


class Devices(Mapping[str, Quantity], Frames):
    """The fits of many devices. `devices["dtheta_y2"].value` is an array, `devices.report` what they come to together."""

    def __init__(self, core: Union[_tumble.Devices, Answers]) -> None:
        self._core = core
        self._quantities = core.quantities()
        verdicts, outcomes = core.verdicts()
        self._verdict = np.frombuffer(verdicts, dtype=np.uint8)
        self._outcome = np.minimum(np.frombuffer(outcomes, dtype=np.uint8), 3)

    def __reduce__(self) -> tuple[Any, ...]:
        # another process gets the arrays, the report, the page and the table as it prints them
        return _answered, (Answers.of(self._core),)

    @property
    def rejected(self) -> bool:
        """Exit code 2 of the program: some device is rejected, malformed or outside its limits."""
        return bool((self._verdict > 0).any() or (self._outcome == 2).any())

    @property
    def count(self) -> int:
        """How many devices."""
        return len(self._core)

    @property
    def ids(self) -> list[str]:
        """Names of the quantities: the columns of `value`, `u` and `U`."""
        return [own for own, _ in self._quantities]

    @property
    def units(self) -> list[str]:
        """Unit of each quantity; angles in arcsec."""
        return [unit for _, unit in self._quantities]

    @cached_property
    def labels(self) -> list[str]:
        """The devices."""
        return list(self._core.labels())

    @cached_property
    def value(self) -> NDArray[np.float64]:
        """Estimates, shape (devices, quantities); NaN where there is none."""
        return self._matrix("value")

    @cached_property
    def u(self) -> NDArray[np.float64]:
        """Combined standard uncertainties, shape (devices, quantities)."""
        return self._matrix("u")

    @cached_property
    def U(self) -> NDArray[np.float64]:
        """Expanded uncertainties, shape (devices, quantities)."""
        return self._matrix("U")

    @cached_property
    def type_a(self) -> NDArray[np.float64]:
        """The part of `u` that comes from the device's own readings (Type A), shape (devices, quantities)."""
        return self._matrix("type_a")

    def _matrix(self, of: str) -> NDArray[np.float64]:
        return np.frombuffer(self._core.matrix(of), dtype=np.float64).reshape(len(self._core), len(self._quantities))

    def column(self, of: str) -> NDArray[np.float64]:
        """A number for each device, shape (devices,): `residual_sd` (1, or the sensor's unit where no u is stated), `chi_square_p`,
        `lack_of_fit_p`, `runs_p`, `normality_p`, `dof`, `rank`, `readings`; NaN where there is none."""
        return np.frombuffer(self._core.column(of), dtype=np.float64)

    @property
    def accepted(self) -> NDArray[np.bool_]:
        """Whose answer is usable, shape (devices,)."""
        return np.asarray(self._verdict == 0)

    @property
    def verdict(self) -> NDArray[np.str_]:
        """`accepted`, `rejected` or `malformed`, shape (devices,)."""
        return np.asarray(VERDICTS[self._verdict])

    @property
    def conformity(self) -> NDArray[np.str_]:
        """Worst outcome of the limits: `pass`, `undecided` or `fail`; empty without limits."""
        return np.asarray(OUTCOMES[self._outcome])

    @cached_property
    def why(self) -> dict[str, str]:
        """What is wrong or suspicious, by device; only devices of which there is something to say."""
        return {self.labels[k]: text for k, text in self._core.why()}

    def __getitem__(self, key: str) -> Quantity:
        if key not in self.ids:
            raise KeyError(f"no quantity is called '{key}': expected one of {', '.join(self.ids)}")
        k = self.ids.index(key)
        return Quantity(key, self.units[k], self.value[:, k], self.u[:, k], self.U[:, k])

    def __iter__(self) -> Any:
        return iter(self.ids)

    def __len__(self) -> int:
        return len(self._quantities)

    @cached_property
    def report(self) -> reports.BatchReport:
        """What the devices come to together: distributions, outlying devices, lots."""
        return reports.BatchReport(json.loads(self._core.report()), self.rejected, partial(self.table, 0), self.page)

    def table(self, devices: int = 40, lang: Lang = "en") -> str:
        """The table of the terminal, with so many devices; `lang`: `en` or `zh`."""
        return self._core.table(devices, lang)

    def page(self, lang: Lang = "en") -> str:
        """The HTML page."""
        return self._core.page(lang)

    def figures(self) -> list[Figure]:
        """The pictures of the page, as SVG."""
        return figures(self.page())

    def _columns(self) -> dict[str, Any]:
        found: dict[str, Any] = {"device": self.labels, "verdict": self.verdict.tolist()}
        for k, (name, unit) in enumerate(self._quantities):
            title = f"{name} ({unit})" if unit else name
            found |= {title: self.value[:, k], f"u_{title}": self.u[:, k], f"U_{title}": self.U[:, k]}
        found |= {name: self.column(name) for name in ("readings", "dof", "residual_sd", "chi_square_p")}
        why = dict(self._core.why())
        return found | {"why": [why.get(k, "") for k in range(self.count)]}

    def __str__(self) -> str:
        return self.table()

    def __repr__(self) -> str:
        return f"<Devices: {self.count}, {int(self.accepted.sum())} accepted>"

    def _repr_html_(self) -> str:
        return excerpt(self.page())


def _answered(answers: dict[tuple[Any, ...], Any]) -> Devices:
    return Devices(Answers(answers))


Values = Union[NDArray[Any], Mapping[str, NDArray[Any]]]


def fit_devices(
    campaign: Question,
    readings: Optional[Union[Table, Path_, Sequence[Path_]]] = None,
    *,
    values: Optional[Values] = None,
    labels: Optional[Sequence[str]] = None,
    by: Optional[str] = None,
    linear: bool = False,
    relative: bool = False,
    level: float = 0.95,
    robust: Optional[Robust] = None,
    remount: Optional[Remount] = None,
) -> Devices:
    """One fit for each of many devices; what they share is done once.

    Either `readings`: a table, a file or files (patterns are not expanded) with the rows of all devices, told apart by the column `by` (or the
    campaign's "by"; several files without it are a device each). Or `values`: the campaign is the schedule of all, and an array of shape
    (devices, readings) holds what a sensor read, in the sensor's unit, NaN where nothing was read; for several sensors a dict of such arrays.
    `labels` name the devices. The other arguments are those of `fit`.

    Raises `MalformedError`. A device that cannot be fitted is a row that says why; warns `RejectedWarning` where there are such.

        >>> import numpy as np
        >>> line = {"bench": {"id": "line", "sensors": {"y": {"model": "a + b*x"}}}, "estimate": {"a": {}, "b": {}},
        ...         "readings": [{"x": 0}, {"x": 1}, {"x": 2}]}
        >>> fit_devices(line, values=np.array([[1.0, 3, 4], [0, 2, 4]]))["b"].value.round(12).tolist()
        [1.5, 2.0]
    """
    how = settings(linear, relative, level, robust, remount)
    if values is not None:
        if readings is not None or by is not None:
            raise TypeError("values= has the readings of all devices: neither a table of readings nor by= goes with it")
        asked = Asked(campaign)
        pairs = list(values.items()) if isinstance(values, Mapping) else [(_only_sensor(asked), values)]
        arrays = [(sensor, np.ma.filled(np.ma.asanyarray(own).astype(float, copy=False), np.nan)) for sensor, own in pairs]
        own = None if labels is None else [str(label) for label in labels]
        if own is not None and len(set(own)) < len(own):
            twice = next(label for k, label in enumerate(own) if label in own[:k])
            raise ValueError(f"the label '{twice}' stands twice: expected another one for each device")
        core = _tumble.fit_array(asked.content, asked.name, asked.folder, dumps, arrays, own, how)
    else:
        files: list[Path] = []
        if isinstance(readings, (str, os.PathLike)):
            files = [Path(readings)]
        elif isinstance(readings, Sequence) and readings and isinstance(readings[0], (str, os.PathLike)):
            files = [Path(file) for file in readings]
        asked = Asked(campaign, None if files else readings)
        core = _tumble.fit_table(asked.content, asked.name, asked.folder, dumps, asked.table, files, by, how)
    found = Devices(core)
    if found.rejected:
        bad = found.count - int((found.accepted & (found.conformity != "fail")).sum())
        warnings.warn(f"{bad} of {found.count} devices are rejected, malformed or outside limits; see .why", RejectedWarning, stacklevel=2)
    return found


def _only_sensor(asked: Asked) -> str:
    sensors = _tumble.sensors(asked.content, asked.name, asked.folder, dumps)
    if len(sensors) != 1:
        raise ValueError(f"the bench has the sensors {', '.join(sensors)}: expected values= as a dict with an array for each sensor that is read")
    return sensors[0]
