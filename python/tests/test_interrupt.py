"""Ctrl-C ends long work, and the work does end."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from cases import EXAMPLES, TABLE_1

GUIDED = EXAMPLES / "28-guided-calibration"
PLAN = EXAMPLES / "18-plan-five-positions/published.campaign.json"
LONG = {
    "monte carlo": f"tumble.fit({str(TABLE_1)!r}, monte_carlo=20_000_000)",
    "plan": f"tumble.plan({str(PLAN)!r}, noise={{'V': 9e-4}}, choose=60, step=10, starts=100000)",
    "guide": f"list(tumble.guide({str(GUIDED / 'schedule.campaign.json')!r}, noise={{'V': 1e-4}}, goal=1e-3, most=300,"
    f" simulate={str(GUIDED / 'hidden.truth.json')!r}, output=os.path.join(tempfile.mkdtemp(), 'own.campaign.json')))",
    "devices": "tumble.fit_devices(LINE, values=np.random.default_rng(1).normal(size=(3_000_000, 3)))",
}
SCRIPT = """
import os, sys, tempfile, threading, time
import numpy as np
import tumble
sys.path.insert(0, {tests!r})
from cases import LINE
print("begun", flush=True)
try:
    {work}
except KeyboardInterrupt:
    print("interrupted", time.time(), flush=True)
    # what was begun is soon over: this process needs no more time
    time.sleep(1.0)
    before = time.process_time()
    time.sleep(1.0)
    print("busy", time.process_time() - before, flush=True)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("name", LONG)
def test_ctrl_c(name: str) -> None:
    script = SCRIPT.format(tests=str(Path(__file__).parent), work=LONG[name])
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "begun\n"
        time.sleep(1.5)
        sent = time.time()
        process.send_signal(signal.SIGINT)
        said, error = process.communicate(timeout=120)
    lines = dict(line.split() for line in said.splitlines())
    assert "interrupted" in lines, f"{said}{error}"
    print(f"{name}: answered after {float(lines['interrupted']) - sent:.3f} s, {float(lines['busy']):.2f} s of work in the second after the next")
    # no time is asserted, but that the work was not done in the background
    assert float(lines["busy"]) < 0.5
