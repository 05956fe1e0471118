"""Writes package/tumble/reports.py, the types of the reports, from ../schemas. A test checks that it is written."""

import json
import keyword
import textwrap
from pathlib import Path

HERE = Path(__file__).resolve().parent
SCHEMAS = HERE.parents[1] / "schemas"
TARGET = HERE.parent / "package" / "tumble" / "reports.py"
# names that a mapping or a report has already, and types
TAKEN = {"data", "dict", "float", "get", "int", "items", "keys", "list", "str", "values"}
OF_REPORTS = {"figures", "page", "rejected"}
SIMPLE = {"string": "str", "number": "float", "integer": "int", "boolean": "bool", "null": "None", "object": "dict[str, Any]"}

HEAD = '''"""Types of the reports: their keys as attributes, each with its unit. Written by scripts/reports.py from the JSON Schemas."""

# ruff: noqa: E501
from __future__ import annotations

from typing import Any, Literal, TypeAlias

from ._report import Node, Report
'''


class Writer:
    def __init__(self):
        self.names = {}  # (report, definition) -> class or alias
        self.done = {}  # name -> definition as JSON
        self.lines = []
        self.parts = []
        self.all = []

    def report(self, path):
        schema = json.loads(path.read_text())
        base = "".join(word.capitalize() for word in path.name.removesuffix("-report.schema.json").split("-"))
        self.base, self.defs = base, schema.get("$defs", {})
        self.names = {name: self.own(name) for name in self.defs}
        for name, definition in self.defs.items():
            self.define(name, definition)
        self.class_of(f"{base}Report", schema, "Report")

    def own(self, name):
        """A name that stands for one definition only."""
        text = json.dumps(self.defs[name], sort_keys=True)
        taken = self.done.get(name)
        if taken is not None and taken != text or name in TOPS:
            name = f"{self.base}{name}"
        return name

    def define(self, name, definition):
        own, text = self.names[name], json.dumps(definition, sort_keys=True)
        if own in self.done:
            return
        self.done[own] = text
        words = literal(definition)
        if words is not None:
            self.lines += ["", f"{own}: TypeAlias = Literal[{', '.join(json.dumps(word) for word in words)}]"]
            if definition.get("description"):
                self.lines.append(doc(definition["description"], ""))
            self.all.append(own)
        elif "properties" in definition:
            self.class_of(own, definition, "Node")
        else:
            self.lines += ["", f"{own}: TypeAlias = {quoted(self.type_of(definition))}"]

    def class_of(self, name, schema, parent):
        self.all.append(name)
        properties, required = schema.get("properties", {}), set(schema.get("required", []))
        lines = ["", "", f"class {name}({parent}):", doc(schema.get("description", f"{name}."), "    "), ""]
        keys, parts = [], {}
        taken = TAKEN | OF_REPORTS if parent == "Report" else TAKEN
        for key, value in properties.items():
            attribute = f"{key}_" if keyword.iskeyword(key) or key in taken else key
            kind = self.type_of(value)
            if key not in required and "None" not in kind.split(" | ") and "default" not in value:
                kind += " | None"
            keys.append(key)
            part = self.part_of(value)
            if part:
                parts[key] = part
            if attribute.isidentifier():
                lines.append(f"    {attribute}: {kind}")
                if value.get("description"):
                    lines.append(doc(value["description"], "    "))
        lines += ["", f"    _keys = frozenset({json.dumps(sorted(keys))})"]
        self.lines += lines
        if parts:
            told = ", ".join(f'"{key}": ({kind}, {is_map})' for key, (kind, is_map) in parts.items())
            self.parts.append(f"{name}._parts = {{{told}}}")

    def type_of(self, value):
        if "$ref" in value:
            return self.names[value["$ref"].rsplit("/", 1)[1]]
        words = literal(value)
        if words is not None:
            return f"Literal[{', '.join(json.dumps(word) for word in words)}]"
        for key in ("anyOf", "oneOf"):
            if key in value:
                return union(self.type_of(one) for one in value[key])
        kinds = value.get("type")
        if kinds is None:
            return "Any"
        found = []
        for kind in kinds if isinstance(kinds, list) else [kinds]:
            if kind == "array":
                items = value.get("items")
                several = value.get("prefixItems")
                inner = union(self.type_of(one) for one in several) if several else self.type_of(items) if items else "Any"
                found.append(f"list[{inner}]")
            elif kind == "object" and isinstance(value.get("additionalProperties"), dict):
                found.append(f"dict[str, {self.type_of(value['additionalProperties'])}]")
            else:
                found.append(SIMPLE[kind])
        return union(found)

    def part_of(self, value, is_map=False):
        """The class of what a value holds, and whether it is a map of such."""
        if "$ref" in value:
            name = value["$ref"].rsplit("/", 1)[1]
            return (self.names[name], is_map) if "properties" in self.defs[name] else None
        for key in ("anyOf", "oneOf"):
            for one in value.get(key, []):
                if (found := self.part_of(one, is_map)) is not None:
                    return found
        if isinstance(value.get("items"), dict):
            return self.part_of(value["items"], is_map)
        if isinstance(value.get("additionalProperties"), dict):
            return self.part_of(value["additionalProperties"], True)
        return None


def literal(value):
    if "const" in value:
        return [value["const"]]
    if "enum" in value:
        return value["enum"]
    several = value.get("oneOf", [])
    if several and all("const" in one for one in several):
        return [one["const"] for one in several]
    return None


def union(kinds):
    found = list(dict.fromkeys(part for kind in kinds for part in [kind]))
    return " | ".join(sorted(found, key=lambda kind: kind == "None"))


def quoted(kind):
    return json.dumps(kind)


def doc(text, indent):
    text = " ".join(text.split()).replace("\\", "\\\\").replace('"""', "'''")
    lines = textwrap.wrap(text, 140 - len(indent), break_long_words=False, break_on_hyphens=False)
    end = " " if lines[-1].endswith('"') else ""
    return indent + '"""' + f"\n{indent}".join(lines) + end + '"""'


PATHS = sorted(SCHEMAS.glob("*-report.schema.json"))
TOPS = {"".join(word.capitalize() for word in path.name.removesuffix(".schema.json").split("-")) for path in PATHS}


def written():
    writer = Writer()
    for path in PATHS:
        writer.report(path)
    names = "".join(f"    {json.dumps(name)},\n" for name in sorted(set(writer.all)))
    return HEAD + "\n__all__ = [\n" + names + "]\n" + "\n".join(writer.lines) + "\n\n\n" + "\n".join(writer.parts) + "\n"


if __name__ == "__main__":
    TARGET.write_text(written())
