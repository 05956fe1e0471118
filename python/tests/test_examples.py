"""The examples in the documentation of functions, of the README, and of the guide."""

import doctest
import re
from pathlib import Path

import pytest
import tumble
from tumble import _devices, _fit

HERE = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize("module", [tumble, _fit, _devices], ids=lambda own: str(own.__name__))
def test_examples(module: object) -> None:
    found = doctest.testmod(module)  # type: ignore[arg-type]
    assert found.attempted > 0 and found.failed == 0


def test_the_readme(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    readme = (HERE / "README.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    assert len(blocks) == 3
    text = "\n".join(blocks).replace('"../examples', f'"{HERE.parent / "examples"}').replace('"table1.html"', repr(str(tmp_path / "t.html")))
    names: dict[str, object] = {}
    exec(compile(text, "README.md", "exec"), names)  # noqa: S102
    fit = names["fit"]
    assert isinstance(fit, tumble.Fit)
    assert str(fit["dtheta_y2"]) == re.search(r"# (dtheta_y2 = .*)", readme).group(1)  # type: ignore[union-attr]


def test_the_guide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(HERE.parent)
    blocks = re.findall(r"```python\n(.*?)```", Path("docs/guide/python.md").read_text(), re.DOTALL)
    names: dict[str, object] = {}
    exec(compile("\n".join(blocks), "python.md", "exec"), names)  # noqa: S102
    assert isinstance(names["fit"], tumble.Fit)
