"""The types: written from the schemas, strict, and true of the compiled part."""

import importlib.util
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parents[1]


def run(cwd: Path, *arguments: str) -> None:
    done = subprocess.run([sys.executable, "-m", *arguments], cwd=cwd, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_reports_are_written_from_the_schemas() -> None:
    spec = importlib.util.spec_from_file_location("reports", HERE / "scripts/reports.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.TARGET.read_text() == module.written(), "run scripts/reports.py"


def test_strict() -> None:
    run(HERE, "mypy")


def test_stubs_are_true(tmp_path: Path) -> None:
    run(tmp_path, "mypy.stubtest", "tumble._tumble", "--mypy-config-file", str(HERE / "pyproject.toml"))
