"""The types: written from the schemas, strict, and true of the compiled part."""

import importlib.util
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType

HERE = Path(__file__).resolve().parents[1]


def run(cwd: Path, *arguments: str) -> None:
    done = subprocess.run([sys.executable, "-m", *arguments], cwd=cwd, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def script(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, HERE / f"scripts/{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_reports_are_written_from_the_schemas() -> None:
    module = script("reports")
    assert module.TARGET.read_text() == module.written(), "run scripts/reports.py"


def test_strict() -> None:
    run(HERE, "mypy")


def test_stubs_are_true(tmp_path: Path) -> None:
    run(tmp_path, "mypy.stubtest", "tumble._tumble", "--mypy-config-file", str(HERE / "pyproject.toml"))


def test_a_release_says_where_the_project_is() -> None:
    source = (HERE / "pyproject.toml").read_text(encoding="utf-8")
    written = script("addresses").with_addresses(source, "https://example.org/lab/tumble/", "v1.2.3")
    before, after = tomllib.loads(source), tomllib.loads(written)
    urls = after["project"].pop("urls")
    assert after == before
    assert urls["Homepage"] == "https://example.org/lab/tumble"
    assert urls["Changelog"] == "https://example.org/lab/tumble/blob/v1.2.3/CHANGELOG.md"
    assert set(urls) == {"Homepage", "Documentation", "Changelog", "Issues"}
