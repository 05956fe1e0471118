"""Reports: the JSON of the program, with a table to print."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterator, Mapping
from typing import Any


class RejectedWarning(UserWarning):
    """The question was answered, and the answer is "rejected": an unknown is not estimable, a test failed, an effect is missing."""


class Report(Mapping[str, Any]):
    """A report of the program; its keys are those of `tumble ... --json`, described by `tumble.schema(...)`.

    `rejected` is exit code 2 of the program. `print(report)` shows the program's table, a notebook as well.
    """

    def __init__(self, data: dict[str, Any], rejected: bool, table: Callable[[], str], page: Callable[[], str]) -> None:
        self.data = data
        self.rejected = rejected
        self._table = table
        self._page = page

    def __getitem__(self, key: str) -> Any:
        return self.data[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.data)

    def __len__(self) -> int:
        return len(self.data)

    def __str__(self) -> str:
        return self._table()

    def __repr__(self) -> str:
        verdict = self.data.get("verdict")
        return f"<{type(self).__name__} of tumble {self.data.get('tumble', '')}{': ' + verdict if isinstance(verdict, str) else ''}>"

    def page(self) -> str:
        """The HTML page, as `--html` writes it."""
        return self._page()

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"
