"""What the compiled part is given."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, Optional, TypedDict, Union


class How(TypedDict):
    """How to fit."""

    linear: bool
    relative: bool
    level: float
    robust: Optional[str]
    remount: Optional[str]


Dumps = Callable[[Any], str]
"""Makes the text of a dict."""
Folder = Union[str, "os.PathLike[str]"]
