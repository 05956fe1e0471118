"""Questions: files, or dicts of the same form; where what they name is looked for."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
import weakref
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Optional, Union

from . import _tables

Question = Union[str, "os.PathLike[str]", Mapping[str, Any]]
"""The path of a file, or a dict of the same form."""


class Asked:
    """A question as the engine takes it: a dict or a text, its name, the folder of what it names, and a table of readings."""

    __slots__ = ("content", "folder", "name", "table")

    def __init__(self, question: Question, readings: Any = None, kind: str = "campaign") -> None:
        self.table: Any = None
        self.content: Any
        if isinstance(question, Mapping):
            self.name, self.folder = kind, os.getcwd()
            self.content = question if type(question) is dict else dict(question)
        else:
            path = Path(question)
            try:
                self.content = path.read_text(encoding="utf-8-sig")
            except OSError as error:
                raise FileNotFoundError(f"cannot read {path}: {error}") from None
            self.name, self.folder = str(path), str(path.parent)
        if readings is None:
            return
        if isinstance(readings, (str, os.PathLike)):
            self._replace(os.path.abspath(readings))
        elif isinstance(readings, Sequence) and not hasattr(readings, "dtype"):
            # rows, as a file has them
            self._replace(list(readings))
        else:
            self.table = _tables.columns_of(readings)
            if isinstance(self.content, dict) and "readings" not in self.content:
                self.content = {**self.content, "readings": []}
            elif isinstance(self.content, str):
                self._replace([])

    def _replace(self, readings: Any) -> None:
        content = json.loads(self.content) if isinstance(self.content, str) else self.content
        self.content = {**content, "readings": readings}


def dumps(content: Any) -> str:
    """A dict as JSON, line by line, so that an error in it has a place."""
    return json.dumps(_finite(content, ""), default=_plain, allow_nan=False, indent=1, ensure_ascii=False)


def _finite(content: Any, path: str) -> Any:
    """NaN in a reading is nothing (null); anywhere else a number must be finite."""
    if isinstance(content, float) and content != content and path.startswith("readings["):
        return None
    if isinstance(content, float) and content in (float("inf"), float("-inf")):
        raise ValueError(f"a number is infinite (at {path})")
    if isinstance(content, Mapping):
        return {str(key): _finite(value, f"{path}.{key}" if path else str(key)) for key, value in content.items()}
    if isinstance(content, (list, tuple)):
        return [_finite(value, f"{path}[{k}]") for k, value in enumerate(content)]
    return content


def _plain(value: Any) -> Any:
    """A number or array of numpy, a path, a date as JSON has them."""
    if hasattr(value, "tolist"):
        return _finite(value.tolist(), "")
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "isoformat"):
        return value.isoformat()
    raise TypeError(f"{type(value).__name__} has no place in a question: {value!r}")


class Files:
    """Questions as files, for commands that read files: dicts and tables get temporary ones, which go with this object."""

    def __init__(self) -> None:
        self._folder: Optional[str] = None

    @property
    def folder(self) -> str:
        """A folder of its own, made when it is needed."""
        if self._folder is None:
            self._folder = tempfile.mkdtemp(prefix="tumble-")
            weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)
        return self._folder

    def question(self, question: Question, kind: str = "campaign", readings: Any = None) -> str:
        """The path of a question."""
        if not isinstance(question, Mapping) and readings is None:
            return os.fspath(str(question))
        asked = Asked(question, None, kind)
        content = json.loads(asked.content) if isinstance(asked.content, str) else dict(asked.content)
        if readings is not None:
            rows = isinstance(readings, Sequence) and not isinstance(readings, str) and not hasattr(readings, "dtype")
            content["readings"] = list(readings) if rows else self.table(readings, "readings")
        # what the question names stands beside the original
        for key in ("bench", "readings", "calibration"):
            named = content.get(key)
            if isinstance(named, str) and (Path(asked.folder) / named).is_file():
                content[key] = str((Path(asked.folder) / named).resolve())
        samples = content.get("readings")
        if isinstance(samples, Mapping) and isinstance(samples.get("samples"), str):
            content["readings"] = {**samples, "samples": str((Path(asked.folder) / samples["samples"]).resolve())}
        return self.text(f"{Path(asked.name).stem.split('.')[0]}.{kind}.json", dumps(content))

    def text(self, name: str, text: str) -> str:
        """The path of a file with this text."""
        path = Path(self.folder) / name
        path.write_text(text, encoding="utf-8")
        return str(path)

    def table(self, table: Any, name: str) -> str:
        """The path of a table."""
        if not _tables.is_table(table):
            return str(os.path.abspath(table))
        return _tables.write(table, self.folder, name)
