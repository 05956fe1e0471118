"""Paths, and JSON that a person can read (one reading per line), for the scripts beside this file."""
import json
from pathlib import Path

DATA = Path(__file__).resolve().parent.parent / "data"


def read(path):
    return json.loads((DATA / path).read_text())


def campaign_text(value):
    """JSON with one line per reading (or per row of a table), floats in shortest round-trip form (up to 17 digits)."""
    return _lay_out(value, 0) + "\n"


def _lay_out(value, depth):
    pad, end = " " * (depth + 1), " " * depth
    flat = json.dumps(value, ensure_ascii=False)
    if len(flat) <= 130 - depth or not value or (isinstance(value, dict) and not any(
            isinstance(v, (dict, list)) for v in value.values()) and "position" in value):
        return flat
    if isinstance(value, dict):
        body = [pad + json.dumps(k, ensure_ascii=False) + ": " + _lay_out(v, depth + 1) for k, v in value.items()]
        return "{\n" + ",\n".join(body) + "\n" + end + "}"
    if isinstance(value, list):
        if not any(isinstance(v, (dict, list)) for v in value) and all(not isinstance(v, str) for v in value):
            return flat
        keep = all(isinstance(v, dict) and not any(isinstance(w, (dict, list)) for w in v.values()) for v in value)
        body = [pad + (json.dumps(v, ensure_ascii=False) if keep else _lay_out(v, depth + 1)) for v in value]
        return "[\n" + ",\n".join(body) + "\n" + end + "]"
    return flat


def write(path, value):
    target = DATA / path
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(campaign_text(value), encoding="utf-8")
    print("wrote", target.resolve().relative_to(DATA.parent.parent))
