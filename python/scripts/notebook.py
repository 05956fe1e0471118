"""Writes notebooks/calibration.ipynb: the cells below, without outputs. A test runs them."""

from pathlib import Path

import nbformat
import nbformat.v4 as nb

TARGET = Path(__file__).resolve().parents[1] / "notebooks" / "calibration.ipynb"
CELLS = [
    ("markdown", """# A gyro on a rate table

Thirty readings at five positions (Li, Ren, Zhao 2012, table 1): six unknown angles and coefficients, and what the model misses."""),
    ("code", """import json
from pathlib import Path

import numpy as np
import tumble

examples = Path("../../examples")
fit = tumble.fit(examples / "01-gyro-table/table1.campaign.json")
fit"""),
    ("code", """fit["dtheta_y2"]"""),
    ("code", """assert abs(fit["dtheta_y2"].value - -162.1) < 0.25  # the published mean of three rates, arcsec
fit.to_pandas()"""),
    ("markdown", "The covariance is a numpy array, angles in rad; pictures show themselves."),
    ("code", """np.set_printoptions(precision=2)
fit.correlation"""),
    ("code", """fit.figures()[0]"""),
    ("markdown", "Readings may come as a table: one row for each, with the columns of a CSV."),
    ("code", """campaign = json.loads((examples / "01-gyro-table/table1.campaign.json").read_text())
import pandas as pd

readings = pd.DataFrame(campaign.pop("readings"))
again = tumble.fit(campaign, readings)
assert again["dtheta_y2"].value == fit["dtheta_y2"].value
readings.head()"""),
    ("markdown", "What does the model miss?"),
    ("code", """import warnings

with warnings.catch_warnings():
    warnings.simplefilter("ignore", tumble.RejectedWarning)
    found = tumble.diagnose(examples / "07-hidden-effect/measured.campaign.json")
print(found.verdict, [effect.regressor for effect in found.effects])
found"""),
    ("markdown", "A thousand devices through the same schedule: one array, a row for each device."),
    ("code", """sd = fit.report.fit.residual_sd  # V
values = np.random.default_rng(1).normal(fit.readings.fitted, sd, (1000, len(readings)))
devices = tumble.fit_devices({**campaign, "readings": readings.to_dict("records")}, values=values)
angle = devices["dtheta_y2"]
assert abs(angle.value.std() / angle.u.mean() - 1) < 0.1  # the devices scatter as their uncertainties say
angle.value.mean(), angle.value.std(), angle.unit"""),
    ("code", """devices.to_polars().head(3)"""),
]


def written() -> str:
    notebook = nb.new_notebook()
    notebook.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3", "language": "python"}
    for k, (kind, source) in enumerate(CELLS):
        cell = nb.new_markdown_cell(source) if kind == "markdown" else nb.new_code_cell(source)
        cell["id"] = f"cell-{k}"
        notebook.cells.append(cell)
    text: str = nbformat.writes(notebook)
    return text + "\n"


if __name__ == "__main__":
    TARGET.parent.mkdir(exist_ok=True)
    TARGET.write_text(written())
