"""tumble calibrates inertial sensors from multi-position tests.

    >>> import tumble
    >>> fit = tumble.fit({"bench": {"id": "line", "sensors": {"y": {"model": "a + b*x"}}}, "estimate": {"a": {}, "b": {}},
    ...                   "readings": [{"x": 0, "y": 1}, {"x": 1, "y": 3}, {"x": 2, "y": 4}]})
    >>> round(fit["b"].value, 12), round(fit["b"].u, 4)
    (1.5, 0.2887)

Questions are files, as for the program, or dicts of the same form; readings may be a pandas or polars DataFrame, a pyarrow table or a dict of
numpy arrays. What a person wrote wrongly raises `MalformedError`, with the place, what was expected and what was found. What the
readings say (a rank defect, a failed test) is a result, with `rejected` set and a `RejectedWarning`.
"""

from . import reports
from ._commands import (
    Diagnosis, Navigation, apply, bench, check, compare, diagnose, diagnose_devices, diagnose_mission, export, navigate, noise, plan, reduce, run, schema,
    simulate,
)
from ._devices import Devices, Quantity, fit_devices
from ._fit import Fit, Parameter, Readings, fit
from ._guide import Guide, Step, guide
from ._question import Question
from ._report import Figure, Node, NoteWarning, RejectedWarning, Report
from ._tables import Table
from ._tumble import MalformedError, __version__

__all__ = [
    "Devices", "Diagnosis", "Figure", "Fit", "Guide", "MalformedError", "Navigation", "Node", "NoteWarning", "Parameter", "Quantity", "Question", "Readings",
    "RejectedWarning", "Report", "Step", "Table", "__version__", "apply", "bench", "check", "compare", "diagnose", "diagnose_devices", "diagnose_mission", "export", "fit",
    "fit_devices", "guide", "navigate", "noise", "plan", "reduce", "reports", "run", "schema", "simulate",
]
