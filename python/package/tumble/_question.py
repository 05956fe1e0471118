"""Questions: files, or dicts of the same form; where what they name is looked for."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import tempfile
import weakref
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np

from . import _tables, _tumble

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
                raise type(error)(f"cannot read {path}: {error}") from None
            self.name, self.folder = str(path), str(path.parent)
        if readings is None:
            return
        if isinstance(readings, (str, os.PathLike)):
            self._replace(os.path.abspath(readings))
        elif _has_lists(readings):
            self._replace(list(readings))
        else:
            self.table = _tables.columns_of(readings)
            if isinstance(self.content, dict) and "readings" not in self.content:
                self.content = {**self.content, "readings": []}
            elif isinstance(self.content, str):
                self._replace([])

    @property
    def titles(self) -> dict[str, str]:
        """The campaign's map of columns: under which titles a table has what the model reads."""
        text = self.content if isinstance(self.content, str) else ""
        content = json.loads(text) if '"columns"' in text else self.content if not text else {}
        return dict(content.get("columns", {}))

    def _replace(self, readings: Any) -> None:
        content = json.loads(self.content) if isinstance(self.content, str) else self.content
        self.content = {**content, "readings": readings}


def _has_lists(table: Any) -> bool:
    """Is it rows as only a file of a schedule has them, with lists in their cells?"""
    return _tables.is_rows(table) and any(isinstance(cell, (list, tuple, np.ndarray)) for row in table for cell in row.values())


def dumps(content: Any) -> str:
    """A dict as JSON, line by line, so that an error in it has a place."""
    return json.dumps(_plain(content, ""), allow_nan=False, indent=1, ensure_ascii=False)


def _plain(content: Any, path: str) -> Any:
    """Numbers and arrays of numpy, paths and dates as JSON has them. NaN in a reading is nothing (null); anywhere else a number must be finite."""
    if content is None or isinstance(content, (str, bool, int)):
        return content
    if isinstance(content, Mapping):
        return {str(key): _plain(value, f"{path}.{key}" if path else str(key)) for key, value in content.items()}
    if isinstance(content, (list, tuple)):
        return [_plain(value, f"{path}[{k}]") for k, value in enumerate(content)]
    if hasattr(content, "tolist"):
        return _plain(content.tolist(), path)
    if isinstance(content, float) and math.isfinite(content):
        return content
    is_infinite = isinstance(content, float) and math.isinf(content)
    if isinstance(content, float) or type(content).__name__ in ("NAType", "NaTType"):
        if path.startswith("readings[") and not is_infinite:
            return None
        raise _tumble.MalformedError(f"{path} is {'infinite' if is_infinite else 'not a number (NaN)'}: expected a finite number")
    if isinstance(content, os.PathLike):
        return os.fspath(content)
    if hasattr(content, "isoformat"):
        return content.isoformat()
    hint = "; a table is given as readings=table beside the campaign" if path == "readings" else ""
    raise TypeError(f"a value of type {type(content).__name__} cannot be in a campaign (at {path}){hint}")


def flag(name: str) -> str:
    """The program's option of a keyword; `from` is a word of the language."""
    return "--" + {"start": "from", "end": "to"}.get(name, name.strip("_").replace("_", "-"))


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
            content["readings"] = list(readings) if _has_lists(readings) else self.table(readings, "readings")
        # what the question names stands beside the original
        for key in ("bench", "readings", "calibration"):
            named = content.get(key)
            if isinstance(named, str) and (Path(asked.folder) / named).is_file():
                content[key] = str((Path(asked.folder) / named).resolve())
        samples = content.get("readings")
        if isinstance(samples, Mapping) and isinstance(samples.get("samples"), str):
            content["readings"] = {**samples, "samples": str((Path(asked.folder) / samples["samples"]).resolve())}
        return self.text(f"{Path(asked.name).stem.split('.')[0]}.{kind}.json", dumps(content))

    def told(self, text: Any, options: Mapping[str, Any]) -> Any:
        """What a command says, with the names of questions and tables for those of temporary files, and keywords for its options."""
        if not isinstance(text, str):
            return text
        text = re.sub(r"\n+(Usage: |For more information, try).*", "", text, flags=re.DOTALL)
        if self._folder is not None:
            text = re.sub(re.escape(self._folder + os.sep) + r"(\w+)\.[.\w]+", r"\1", text)
        for name in options:
            text = re.sub(rf"{flag(name)}\b(?:[ =]<?[A-Z_=]+>?)?", f"{name}=", text)
        return text

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
