"""Reports: what the program writes as JSON, with its keys as attributes, a table to print, a page and pictures."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike


class RejectedWarning(UserWarning):
    """The question was answered, and the answer is "rejected": an unknown is not estimable, a test failed, an effect is missing."""


class NoteWarning(UserWarning):
    """What the program remarks about a question on the way to the answer."""


class Figure(NamedTuple):
    """A picture; a notebook shows it."""

    svg: str
    """The picture as SVG."""
    caption: str
    """What it shows."""

    def _repr_svg_(self) -> str:
        return self.svg


class Node(Mapping[str, Any]):
    """A part of a report: its keys are attributes as well. A key that stands in no report of this kind is an `AttributeError`."""

    _parts: ClassVar[dict[str, tuple[type[Node], bool]]] = {}
    _keys: ClassVar[frozenset[str]] = frozenset()

    def __init__(self, data: Mapping[str, Any]) -> None:
        self.data = data
        """As in the JSON."""

    # a checker of types sees the keys of each report alone
    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            key = name if name in self._keys else name.removesuffix("_")
            if name.startswith("_") or key not in self._keys:
                raise AttributeError(f"{type(self).__name__} has no '{name}': expected one of {', '.join(sorted(self._keys))}")
            return _wrapped(self.data.get(key), *self._parts.get(key, (None, False)))

    def __getitem__(self, key: str) -> Any:
        return self.data[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.data)

    def __len__(self) -> int:
        return len(self.data)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self._keys})

    def __repr__(self) -> str:
        shown = ", ".join(f"{key}={value!r}" for key, value in self.data.items() if not isinstance(value, (list, dict)))
        return f"{type(self).__name__}({shown})"


def _wrapped(value: Any, part: Any, is_map: bool) -> Any:
    """A value with the type of its part; a map has parts as values."""
    if part is None:
        return value
    if isinstance(value, list):
        return [_wrapped(one, part, is_map) for one in value]
    if isinstance(value, dict):
        return {key: _wrapped(one, part, False) for key, one in value.items()} if is_map else part(value)
    return value


class Report(Node):
    """A report. Its keys are those of `tumble ... --json`; `print(report)` shows the program's table."""

    def __init__(
        self, data: Mapping[str, Any], rejected: bool = False, table: Callable[[], str] = str, page: Callable[[], str] = str
    ) -> None:
        super().__init__(data)
        self.rejected = rejected
        """Exit code 2 of the program."""
        self._table = table
        self._page = page

    def __str__(self) -> str:
        return self._table()

    def __repr__(self) -> str:
        verdict = self.data.get("verdict")
        return f"<{type(self).__name__}{': ' + verdict if isinstance(verdict, str) else ''}>"

    def page(self) -> str:
        """The HTML page, as `--html` writes it: one file that stands alone."""
        return self._page()

    def figures(self) -> list[Figure]:
        """The pictures of the page."""
        return figures(self.page())

    def _repr_html_(self) -> str:
        page = self.page()
        return excerpt(page) if page else f"<pre>{html.escape(str(self))}</pre>"


def figures(page: str) -> list[Figure]:
    """The pictures of a page, with their captions."""
    found = []
    for figure in re.findall(r"<figure.*?</figure>", page, re.DOTALL):
        svg = re.search(r"<svg.*</svg>", figure, re.DOTALL)
        caption = re.search(r"<figcaption>(.*?)</figcaption>", figure, re.DOTALL)
        if svg:
            text = html.unescape(re.sub(r"<[^>]*>", "", caption.group(1))) if caption else ""
            found.append(Figure(svg.group(0), text.strip()))
    return found


def excerpt(page: str, sections: int = 2) -> str:
    """The first sections of a page, answer and estimates, for a notebook; its style keeps to itself."""
    style = re.search(r"<style>(.*?)</style>", page, re.DOTALL)
    parts = re.findall(r"<section\b.*?</section>", page, re.DOTALL)
    if not style or not parts:
        return page
    # anchors belong to the page
    body = re.sub(r'<section id="[^"]*"', "<section", "\n".join(parts[:sections]))
    rules = style.group(1).replace(":root", ":scope").replace("\nbody {", "\n:scope {").replace("  body {", "  :scope {")
    own = ":scope { padding: 0 !important; margin: 0; } h2 { margin-top: 1rem; }"
    return f'<div class="tumble-report"><style>@scope (.tumble-report) {{{rules}\n{own}}}</style>\n{body}</div>'


State = Literal["free", "at-bound", "fixed", "not-estimable", "derived"]
Lang = Literal["en", "zh"]
"""The language of tables and pages; reports are the same in both."""


def residual_plot(sensor: Sequence[str], index: ArrayLike, series: Sequence[tuple[ArrayLike, bool, str]], ax: Any) -> Any:
    """Residuals over the number of the reading, a colour for each sensor; a series is of discs or circles, and adds something to the sensor's name."""
    import matplotlib.pyplot

    ax = matplotlib.pyplot.subplots()[1] if ax is None else ax
    for k, name in enumerate(dict.fromkeys(sensor)):
        of = np.array([own == name for own in sensor])
        for residual, is_filled, suffix in series:
            filled = f"C{k}" if is_filled else "none"
            ax.plot(np.asarray(index)[of], np.asarray(residual, dtype=float)[of], "o", color=f"C{k}", mfc=filled, label=name + suffix)
    ax.axhline(0, color="0.7", zorder=0)
    ax.set(xlabel="reading", ylabel="residual, in the sensor's unit")
    ax.legend()
    return ax
