"""Writes where the project is into pyproject.toml, for the index that a wheel goes to: a release knows its address, a source folder does not.

    python scripts/addresses.py https://HOST/OWNER/NAME v0.2.0 [pyproject.toml]
"""

import sys
import tomllib
from pathlib import Path


def with_addresses(pyproject: str, address: str, tag: str) -> str:
    """The text with `[project.urls]`; a text that has one already is refused."""
    if "urls" in tomllib.loads(pyproject)["project"]:
        raise SystemExit("addresses.py: pyproject.toml has [project.urls] already")
    address = address.rstrip("/")
    at_tag = f"{address}/blob/{tag}"
    urls = {
        "Homepage": address,
        "Documentation": f"{at_tag}/docs/README.md",
        "Changelog": f"{at_tag}/CHANGELOG.md",
        "Issues": f"{address}/issues",
    }
    lines = [f'{name} = "{url}"' for name, url in urls.items()]
    return "\n".join([pyproject.rstrip("\n"), "", "[project.urls]", *lines, ""])


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        raise SystemExit(__doc__)
    file = Path(sys.argv[3] if len(sys.argv) == 4 else Path(__file__).parents[1] / "pyproject.toml")
    file.write_text(with_addresses(file.read_text(encoding="utf-8"), sys.argv[1], sys.argv[2]), encoding="utf-8")
