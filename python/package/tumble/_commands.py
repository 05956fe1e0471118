"""The other commands of the program. Their arguments are its options, `max_rate=40` for `--max-rate 40`; what they answer is typed."""

from __future__ import annotations

import json
import os
import re
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, Optional, TypeVar, Union, overload

import numpy as np

from . import _tumble, reports
from ._fit import Fit, Remount
from ._question import Asked, Files, Question, dumps, flag
from ._report import Lang, NoteWarning, RejectedWarning, Report, residual_plot
from ._tables import Path_, Table, is_table, kept, read, with_columns

R = TypeVar("R", bound=Report)
Calibration = Union[Fit, Question]
"""A fit, the path of its report, or the report as a dict."""
Names = Union[str, Sequence[str]]
"""One name, or several."""


def run(*arguments: Any) -> tuple[int, str, str]:
    """A command of the program as in a shell: `run("bench", "list")`. Gives exit code, stdout and stderr."""
    code, out, err = _tumble.run([_written(argument) for argument in arguments])
    return code, out.decode("utf-8"), err


def _written(value: Any) -> str:
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)


def _flags(options: Mapping[str, Any]) -> list[str]:
    flags: list[str] = []
    for name, value in options.items():
        if value is None or value is False:
            continue
        if value is True:
            flags.append(flag(name))
        elif isinstance(value, Mapping):
            flags += [f"{flag(name)}={key}={one}" for key, one in value.items()]
        else:
            # with '=', so that a negative number is no flag
            flags += [f"{flag(name)}={_written(one)}" for one in (value if isinstance(value, (list, tuple)) else [value])]
    return flags


def _further(command: str, options: Mapping[str, Any]) -> Mapping[str, Any]:
    """Options that only the program's help lists, refused where it does not."""
    if options:
        known = {name.replace("-", "_") for name in re.findall(r"--([a-z][a-z-]*)", run(command, "--help")[1])} - {"help", "html", "json"}
        for name in options:
            if name not in known:
                raise TypeError(f"{command}() has no argument '{name}': expected one of {', '.join(sorted(known))}")
    return options


def _ask(command: list[str], options: Mapping[str, Any] = {}, files: Optional[Files] = None, level: int = 3) -> tuple[bool, str]:
    files = files or Files()
    try:
        code, out, err = _tumble.run([*command, *_flags(options)], True)
    except _tumble.MalformedError as error:
        error.args = (files.told(error.args[0], options),)
        for part in ("what", "expected", "found", "file"):
            setattr(error, part, files.told(getattr(error, part), options))
        raise
    err = files.told(err.strip(), options)
    if code == 1:
        raise _tumble.MalformedError(err)
    if err:
        warnings.warn(err, NoteWarning, stacklevel=level)
    return code == 2, out.decode("utf-8")


def _report(kind: type[R], command: list[str], options: Mapping[str, Any], files: Files, more: Sequence[str] = ()) -> R:
    """The report of a command, its table and its page, all from one run."""
    report, page = (os.path.join(files.folder, name) for name in ("report.json", "page.html"))
    rejected, table = _ask([*command, *more, "--json", report, "--html", page], options, files, level=4)
    table, shown = (files.told(text, {}) for text in (table, Path(page).read_text(encoding="utf-8")))
    found = kind(json.loads(Path(report).read_text(encoding="utf-8")), rejected, table.__str__, shown.__str__)
    if rejected:
        verdict = found.data.get("verdict", "rejected")
        warnings.warn(f"tumble {command[0]}: {verdict}; print the report to see why", RejectedWarning, stacklevel=3)
    return found


class Diagnosis(reports.DiagnoseReport):
    """Where model and readings disagree, and the effect that the model misses."""

    def plot(self, ax: Any = None) -> Any:
        """The gap: residuals over the number of the reading with the model as given (circles) and with what was found (discs), with matplotlib."""
        rows = self.data["residuals"]
        before, after = ([own.get(key) for own in rows] for key in ("before", "after"))
        found = [] if all(own is None for own in after) else [(after, True, ", with what was found")]
        return residual_plot([own["sensor"] for own in rows], [own["index"] for own in rows], [(before, False, ", as given"), *found], ax)


def diagnose(
    campaign: Question,
    readings: Optional[Table] = None,
    *,
    effects: Optional[Question] = None,
    significance: Optional[float] = None,
    remount: Optional[Remount] = None,
    write_model: Optional[Path_] = None,
    force: bool = False,
    lang: Lang = "en",
) -> Diagnosis:
    """Find where model and readings disagree, name the missing effect, add it, show the gap shrink.

    effects: a catalogue of your own beside the built-in one. significance: probability of reporting anything when nothing is missing (0.01).
    remount: remounting scatters each sensor's offset, with this u or one that is estimated. write_model: where the repaired bench goes
    (NAME.bench.json). Warns `RejectedWarning` where effects were found or the gap is unexplained.
    """
    files = Files()
    options = {
        "effects": None if effects is None else files.question(effects, "effects"), "significance": significance, "remount": remount,
        "write_model": write_model, "force": force, "lang": lang,
    }
    return _report(Diagnosis, ["diagnose", files.question(campaign, "campaign", readings)], options, files)


def diagnose_devices(campaign: Question, readings: Optional[Union[Table, Path_]] = None, *, by: Optional[str] = None) -> dict[str, Any]:
    """Which of many devices has which effect that the model misses: columns, a row for each device (`device` or the name of `by` first).

    readings, by: as in `fit_devices`.
    """
    files = Files()
    rows = os.path.join(files.folder, "effects.csv")
    table = [] if readings is None else ["--readings", files.table(readings, "readings")]
    _ask(["diagnose", files.question(campaign), *table, "--to", rows], {"by": by}, files)
    return read(rows)


def diagnose_mission(
    mission: Question, measured: Union[Table, Path_], *, effects: Optional[Question] = None, significance: Optional[float] = None,
    write_model: Optional[Path_] = None, force: bool = False, lang: Lang = "en",
) -> reports.NavigateDiagnoseReport:
    """Which sensor errors explain the measured errors of a navigator.

    measured: a table with the columns of `navigate(...).series` and `_u` beside them: time in s, attitude in arcsec, velocity in m/s, position in m.
    """
    files = Files()
    options = {
        "measured": files.table(measured, "measured"), "effects": None if effects is None else files.question(effects, "effects"),
        "significance": significance, "write_model": write_model, "force": force, "lang": lang,
    }
    return _report(reports.NavigateDiagnoseReport, ["diagnose", files.question(mission, "mission")], options, files)


def plan(
    schedule: Question,
    readings: Optional[Table] = None,
    *,
    noise: Optional[Mapping[str, float]] = None,
    remount: Optional[Mapping[str, float]] = None,
    tilts: Optional[float] = None,
    at: Optional[Mapping[str, float]] = None,
    effects: Optional[Question] = None,
    choose: Optional[int] = None,
    any_cost: bool = False,
    add: Optional[int] = None,
    separate: Optional[tuple[str, str]] = None,
    sensor: Optional[str] = None,
    goal: Optional[Union[float, Mapping[str, float]]] = None,
    find: Optional[Mapping[str, float]] = None,
    power: Optional[float] = None,
    beside: Optional[Names] = None,
    budget: Optional[float] = None,
    keep: bool = False,
    criterion: Optional[str] = None,
    candidates: Optional[Question] = None,
    step: Optional[float] = None,
    lang: Lang = "en",
    **options: Any,
) -> reports.PlanReport:
    """How well a schedule will do before anyone measures; the best positions to choose or add.

    noise: sd of one sample of each sensor, in its unit: `{"V": 9e-4}`. remount: tilts that every remounting scatters, sd in arcsec. tilts: their
    expected size, arcsec. at: values of estimated parameters (arcsec for a tilt). choose: the best schedule of so many readings. add: the best so
    many to add. separate: two effects to tell apart. goal: a standard uncertainty to reach (arcsec), of all angles or by name. find: an effect of
    this size to be found. budget: what it may cost. step: of the sweep of candidates, deg. Further options as in `tumble plan --help`.
    """
    files = Files()
    given = {
        "noise": noise, "remount": remount, "tilts": tilts, "at": at, "effects": None if effects is None else files.question(effects, "effects"),
        "choose": choose, "any_cost": any_cost, "add": add, "sensor": sensor, "goal": goal, "find": find, "power": power, "beside": beside,
        "budget": budget, "keep": keep, "criterion": criterion,
        "candidates": None if candidates is None else files.question(candidates, "candidates"), "step": step,
        "lang": lang,
    }
    command = ["plan", files.question(schedule, "campaign", readings)]
    if separate is not None:
        command += ["--separate", *separate]
    return _report(reports.PlanReport, command, {**given, **_further("plan", options)}, files)


@overload
def compare(campaign: Question, /, *, lang: Lang = "en") -> reports.CompareReport: ...
@overload
def compare(
    before: Calibration, after: Calibration, /, *, level: Optional[float] = None, independent: bool = False, lang: Lang = "en"
) -> reports.CompareCalibrationsReport: ...
@overload
def compare(
    first: Calibration, second: Calibration, third: Calibration, /, *others: Calibration, level: Optional[float] = None, independent: bool = False,
    lang: Lang = "en",
) -> reports.CompareHistoryReport: ...
def compare(*calibrations: Calibration, level: Optional[float] = None, independent: bool = False, lang: Lang = "en") -> Any:
    """One campaign: the published closed forms beside least squares. Two calibrations of one unit: what has changed; more: their history.

    level: coverage probability. independent: inputs that the calibrations share count as independent.
    """
    files = Files()
    options = {"level": level, "independent": independent, "lang": lang}
    if not calibrations:
        raise TypeError("compare() takes a campaign, or two calibrations or more")
    if len(calibrations) == 1 and not isinstance(calibrations[0], Fit):
        return _report(reports.CompareReport, ["compare", files.question(calibrations[0])], {"lang": lang}, files)
    paths = [_calibration(files, one, k) for k, one in enumerate(calibrations)]
    kind: type[Report] = reports.CompareHistoryReport if len(paths) > 2 else reports.CompareCalibrationsReport
    return _report(kind, ["compare", *paths], options, files)


def _calibration(files: Files, calibration: Calibration, k: int = 0) -> str:
    if isinstance(calibration, Fit):
        path = Path(files.folder) / f"calibration_{k}.fit.json"
        calibration.save(path)
        return str(path)
    if isinstance(calibration, Report):
        calibration = calibration.data
    return files.text(f"calibration_{k}.fit.json", dumps(calibration)) if isinstance(calibration, Mapping) else os.fspath(calibration)


class Navigation(reports.NavigateReport):
    """What calibration errors do to a navigator."""

    series: dict[str, Any]
    """The errors over time as columns, numpy arrays: time in s, attitude in arcsec, velocity in m/s, position in m."""


def navigate(mission: Question, lang: Lang = "en") -> Navigation:
    """What calibration errors do to a strapdown navigator over hours."""
    files = Files()
    series = os.path.join(files.folder, "series.csv")
    found = _report(Navigation, ["navigate", files.question(mission, "mission")], {"lang": lang}, files, ["--csv", series])
    found.series = read(series)
    return found


def noise(
    log: Union[Table, Path_], *, columns: Optional[Names] = None, unit: Optional[str] = None, time: Optional[str] = None,
    rate: Optional[float] = None, start: Optional[float] = None, end: Optional[float] = None, per_octave: Optional[int] = None,
    level: Optional[float] = None, lang: Lang = "en",
) -> reports.NoiseReport:
    """Allan deviations of a record at rest, and its noise coefficients (IEEE Std 952) with uncertainties.

    log: a table of samples, or a file of them. unit: of the columns, where their titles have none. time: the column of times; rate: samples a
    second, where there is none. start, end: what is analysed, s. per_octave: averaging times in each octave. level: of the intervals.
    """
    files = Files()
    options = {
        "columns": _joined(columns), "unit": unit, "time": time, "rate": rate, "start": start, "end": end, "per_octave": per_octave, "level": level,
        "lang": lang,
    }
    return _report(reports.NoiseReport, ["noise", files.table(log, "log")], options, files)


def reduce(
    log: Union[Table, Path_], *, schedule: Optional[Question] = None, columns: Optional[Names] = None, time: Optional[str] = None,
    rate: Optional[float] = None, by: Optional[str] = None, to: Optional[Path_] = None, force: bool = False, lang: Lang = "en",
    **options: Any,
) -> reports.ReduceReport:
    """From a logger's samples to readings: segments, means, and an uncertainty that holds for correlated noise.

    log: a table of samples, or a file of them. schedule: the campaign without values that was run. columns: those to reduce. by: the column whose
    runs of equal labels are segments. to: where the readings go, a campaign (with a schedule) or a table (.csv). Further options as in
    `tumble reduce --help`: `window=0.5`, `guard=1`, `encoder="angle"`.
    """
    files = Files()
    given = {
        "for": None if schedule is None else files.question(schedule), "columns": _joined(columns), "time": time, "rate": rate, "by": by, "to": to,
        "force": force, "lang": lang,
    }
    return _report(reports.ReduceReport, ["reduce", files.table(log, "log")], {**given, **_further("reduce", options)}, files)


def _joined(names: Optional[Names]) -> Optional[str]:
    return names if names is None or isinstance(names, str) else ",".join(names)


def simulate(schedule: Question, truth: Question, seed: int = 1) -> dict[str, Any]:
    """Readings of a schedule from a truth, with seeded noise and hidden effects: a campaign, which `fit` takes."""
    asked, true = Asked(schedule), Asked(truth, kind="truth")
    text = _tumble.simulate(asked.content, asked.name, Path(asked.folder), true.content, true.name, seed, dumps)
    found: dict[str, Any] = json.loads(text)
    return found


@overload
def apply(
    calibration: Calibration, log: Path_, *, u: bool = False, frame: Literal["sensor", "mount"] = "sensor", column: Optional[Mapping[str, str]] = None
) -> str: ...
@overload
def apply(
    calibration: Calibration, log: Table, *, u: bool = False, frame: Literal["sensor", "mount"] = "sensor", column: Optional[Mapping[str, str]] = None
) -> Any: ...
def apply(
    calibration: Calibration, log: Any, *, u: bool = False, frame: Literal["sensor", "mount"] = "sensor", column: Optional[Mapping[str, str]] = None
) -> Any:
    """A record corrected with a calibration: inputs (rates, specific forces) beside its columns.

    log: a file (the answer is the text of a CSV, without the sensors' columns) or a table (the answer is one of the same kind, with all of its columns as
    they are and further ones; of a structured array a dict). u: also the standard uncertainty of each input from the calibration, as `<input>_u`. frame:
    `sensor`, or turned to the mounting face. column: a sensor's column, where it has another name.
    """
    files, log = Files(), kept(log)
    path = _calibration(files, calibration)
    command, options = ["apply", path, files.table(log, "log")], {"u": u, "frame": frame, "column": column}
    if not is_table(log):
        return _ask(command, options, files)[1]
    out = os.path.join(files.folder, "corrected.parquet")
    _ask([*command, "--out", out], options, files)
    inputs = [own["id"] for own in json.loads(Path(path).read_text(encoding="utf-8"))["correction"]["inputs"] if own["solved"]]
    titles = inputs + [f"{name}_u" for name in inputs if u]
    columns = (np.frombuffer(own, dtype=np.float64) for own in _tumble.read_numbers(Path(out), titles))
    return with_columns(log, dict(zip(titles, columns)))


def export(calibration: Calibration, to: Literal["c", "python", "matlab", "kalibr", "ros", "json"]) -> str:
    """A calibration's correction as source code, or for another program."""
    files = Files()
    return _ask(["export", _calibration(files, calibration)], {"to": to}, files)[1]


def check(*files: Path_) -> str:
    """Check bench and campaign files without fitting anything; raises `MalformedError`."""
    return _ask(["check", *(os.fspath(file) for file in files)])[1]


@overload
def bench() -> str: ...
@overload
def bench(id: str) -> dict[str, Any]: ...
def bench(id: Optional[str] = None) -> Union[str, dict[str, Any]]:
    """A built-in bench as a dict; without an id the list of them, as text."""
    if id is None:
        return _ask(["bench", "list"])[1]
    found: dict[str, Any] = json.loads(_ask(["bench", "show", id])[1])
    return found


def schema(kind: str) -> dict[str, Any]:
    """The JSON Schema of a kind of file: `campaign`, `bench`, `fit-report`, ..."""
    found: dict[str, Any] = json.loads(_ask(["schema", kind])[1])
    return found
