"""Example 09's table of headings and amplitudes: swing against rest for the source's values (1 per mille on all axes).

Runs `tumble navigate` (after `cargo build --release`) on variants of examples/09-navigator/findings.mission.json, at a step of 0.05 s, and
prints the rows of the README's table. Run: python3 tests/scripts/navigator_headings.py   (needs nothing but Python; a minute)
"""
import json
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
BASE = json.loads((ROOT / "examples/09-navigator/findings.mission.json").read_text())
AMPLITUDES = {"7, 10, 5": (7, 10, 5), "10, 10, 10": (10, 10, 10)}


def cell(value):
    return "-" if value is None else f"{value:.3g}"


for heading in (0, 45, 60, 90):
    for name, (pitch, roll, azimuth) in AMPLITUDES.items():
        mission = json.loads(json.dumps(BASE))
        swing = mission["beside"][0]
        mission |= {"step_s": 0.05, "motion": {"static": {"heading_deg": heading}}, "beside": [swing]}
        own = swing["swing"]
        own["pitch"]["amplitude_deg"], own["roll"]["amplitude_deg"] = pitch, roll
        own["heading"] |= {"amplitude_deg": azimuth, "mean_deg": heading}
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "m.mission.json"
            path.write_text(json.dumps(mission))
            out = subprocess.run([ROOT / "target/release/tumble", "navigate", path, "--json", "-"], capture_output=True, text=True, check=True)
        ratios = {r["scenario"]: r for r in json.loads(out.stdout)["ratios"]}
        cells = [cell(ratios[s][q]) for s in ("gyro_scale_factor", "gyro_installation") for q in ("tilt", "azimuth", "velocity", "position")]
        print(f"| {heading} | {name} | " + " | ".join(cells) + " |")
