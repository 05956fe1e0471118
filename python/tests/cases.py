"""Questions that several tests ask."""

from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
TABLE_1 = EXAMPLES / "01-gyro-table/table1.campaign.json"
LINE_BENCH: dict[str, Any] = {"id": "line", "sensors": {"y": {"model": "a + b*x"}}}
LINE: dict[str, Any] = {
    "bench": LINE_BENCH,
    "estimate": {"a": {}, "b": {}},
    "readings": [{"x": 0, "y": 1}, {"x": 1, "y": 3}, {"x": 2, "y": 4}],
}
