"""The commands of the program, with keyword arguments for their options: `max_rate=40` is `--max-rate 40`."""

from __future__ import annotations

import json
import os
import tempfile
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Optional

from . import _tumble
from ._question import Question, text_of
from ._report import RejectedWarning, Report


def run(*arguments: Any) -> tuple[int, str, str]:
    """A command of the program as in a shell: `run("bench", "list")`. Returns exit code, stdout and stderr."""
    code, out, err = _tumble.run([os.fspath(a) if isinstance(a, os.PathLike) else str(a) for a in arguments])
    return code, out.decode("utf-8"), err


def _flags(options: Mapping[str, Any]) -> list[str]:
    flags: list[str] = []
    for name, value in options.items():
        flag = "--" + name.strip("_").replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            flags.append(flag)
        else:
            for one in value if isinstance(value, (list, tuple)) else [value]:
                # with '=', so that a negative number is no flag
                flags.append(f"{flag}={os.fspath(one) if isinstance(one, os.PathLike) else one}")
    return flags


def _ask(arguments: list[str]) -> tuple[bool, str]:
    code, out, err = run(*arguments)
    if code == 1:
        raise _tumble.MalformedError(err.strip())
    if err.strip():
        warnings.warn(err.strip(), stacklevel=4)
    return code == 2, out


class _Files:
    """Questions as files: dicts get a temporary one in the working folder's stead."""

    def __init__(self) -> None:
        self.folder = tempfile.TemporaryDirectory(prefix="tumble-")

    def path(self, question: Question, kind: str = "campaign", readings: Any = None) -> str:
        if not isinstance(question, Mapping) and readings is None:
            return os.fspath(question)
        name, text, folder = text_of(question, readings, kind)
        content = json.loads(text)
        # what the question names stands beside the original
        for key in ("bench", "readings"):
            named = content.get(key)
            if isinstance(named, str) and (Path(folder) / named).is_file():
                content[key] = str((Path(folder) / named).resolve())
        path = Path(self.folder.name) / f"{Path(name).stem.split('.')[0]}.{kind}.json"
        path.write_text(json.dumps(content), encoding="utf-8")
        return str(path)


def _report(command: list[str], options: Mapping[str, Any], files: _Files) -> Report:
    flags = _flags(options)
    rejected, text = _ask([*command, *flags, "--json", "-"])

    def table() -> str:
        return _ask([*command, *flags])[1]

    def page() -> str:
        target = Path(files.folder.name) / "page.html"
        _ask([*command, *flags, "--html", str(target)])
        return target.read_text(encoding="utf-8")

    return Report(json.loads(text), rejected, table, page)


def diagnose(campaign: Question, readings: Any = None, **options: Any) -> Report:
    """Find where model and readings disagree, name the missing effect, add it, show the gap shrink (`tumble diagnose --help`).

    For a mission: `diagnose("sea.mission.json", measured="errors.csv")`.
    """
    files = _Files()
    kind = "mission" if "measured" in options else "campaign"
    return _report(["diagnose", files.path(campaign, kind, readings)], options, files)


def plan(schedule: Question, readings: Any = None, **options: Any) -> Report:
    """How well a schedule will do before anyone measures, and better positions: `plan(s, noise="V=9e-4", choose=12)`."""
    files = _Files()
    return _report(["plan", files.path(schedule, "campaign", readings)], options, files)


def compare(*questions: Question, **options: Any) -> Report:
    """Published closed forms beside least squares (one campaign); two calibrations of one unit, or the history of many (reports of fits)."""
    files = _Files()
    return _report(["compare", *(files.path(one) for one in questions)], options, files)


def navigate(mission: Question, **options: Any) -> Report:
    """What calibration errors do to a strapdown navigator over hours."""
    files = _Files()
    return _report(["navigate", files.path(mission, "mission")], options, files)


def noise(log: Any, **options: Any) -> Report:
    """Allan deviations of a record at rest, and its noise coefficients (IEEE Std 952)."""
    return _report(["noise", os.fspath(log)], options, _Files())


def reduce(log: Any, **options: Any) -> Report:
    """From a logger's samples to readings: `reduce("log.csv", to="readings.csv", still=True)` (`tumble reduce --help`)."""
    return _report(["reduce", os.fspath(log)], options, _Files())


def simulate(schedule: Question, truth: Question, seed: int = 1) -> dict[str, Any]:
    """Readings of a schedule from a truth, with seeded noise and hidden effects, as a campaign."""
    name, text, folder = text_of(schedule)
    _, true, _ = text_of(truth, kind="truth")
    return json.loads(_tumble.simulate(name, text, folder, true, seed))


def apply(calibration: Question, log: Any, **options: Any) -> str:
    """A record corrected with a calibration (the report of a fit, its file or `fit.data`), as the text of a CSV."""
    files = _Files()
    return _ask(["apply", _calibration(files, calibration), os.fspath(log), *_flags(options)])[1]


def export(calibration: Question, to: str, **options: Any) -> str:
    """A calibration as source code, or for another program: `to` is c, python, matlab, kalibr, ros or json."""
    files = _Files()
    return _ask(["export", _calibration(files, calibration), *_flags({"to": to, **options})])[1]


def _calibration(files: _Files, calibration: Any) -> str:
    data = calibration.data if isinstance(calibration, Report) else calibration
    if not isinstance(data, Mapping):
        return os.fspath(data)
    path = Path(files.folder.name) / "calibration.fit.json"
    path.write_text(json.dumps(data), encoding="utf-8")
    return str(path)


def check(*files: Any) -> str:
    """Check bench and campaign files without fitting anything; raises `MalformedError`."""
    return _ask(["check", *(os.fspath(file) for file in files)])[1]


def bench(id: Optional[str] = None) -> Any:
    """A built-in bench as a dict; without an id the list of them, as text."""
    if id is None:
        return _ask(["bench", "list"])[1]
    return json.loads(_ask(["bench", "show", id])[1])


def schema(kind: str) -> dict[str, Any]:
    """The JSON Schema of a kind of file: `campaign`, `bench`, `fit-report`, ..."""
    return json.loads(_ask(["schema", kind])[1])
