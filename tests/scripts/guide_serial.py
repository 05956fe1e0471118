"""A serial port as the source of `tumble guide`, over a pair of pseudo-terminals: two positions are read, the cable is unplugged and plugged in again in between.

    python3 tests/scripts/guide_serial.py target/release/tumble

Asserts what is said. By hand: cargo's tests have no pseudo-terminals.
"""

import json
import os
import pty
import queue
import random
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

from guide_latency import FORCE, SENSORS, schedule

chance = random.Random(1)


def plugged_in(path):
    board, port = pty.openpty()
    path.unlink(missing_ok=True)
    path.symlink_to(os.ttyname(port))
    return board, port


def says(board, text):
    rest = text.encode()
    while rest:
        rest = rest[os.write(board, rest[:2000]) :]


def rows(values, count, sd):
    return "".join(",".join(f"{value + chance.gauss(0, sd):.7f}" for value in values) + "\n" for _ in range(count))


program, folder = os.path.abspath(sys.argv[1]), Path(tempfile.mkdtemp())
(folder / "six.campaign.json").write_text(json.dumps(schedule()))
board, port = plugged_in(folder / "port")
command = [program, "guide", "six.campaign.json", "--serial", "port:115200", "--rate", "1000", "--json", "-"]
command += [text for id in SENSORS for text in ("--noise", f"{id}=2e-5")]
guide = subprocess.Popen(command, cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
lines = queue.Queue()
threading.Thread(target=lambda: [lines.put(json.loads(line)) for line in guide.stdout], daemon=True).start()


def advice():
    while True:
        line = lines.get(timeout=300)
        if not line.get("held"):
            return line


first = advice()
# the end of a row, of which the beginning came before the port was opened
says(board, "125,0.2\n" + ",".join(SENSORS) + "\n" + rows(FORCE[first["next"]["position"]] + (0, 0, 0), 8000, 2e-4))
second = advice()
assert second["readings"] == 1 and "error" not in second, second
os.close(board)
os.close(port)
gone = advice()
assert "serial port 'port': it was unplugged" in gone["error"] and gone["readings"] == 1, gone
board, port = plugged_in(folder / "port")
back = advice()
assert "error" not in back and back["readings"] == 1, back
position = back["next"]["position"]
says(board, "0.5,0.2\n" + ",".join(SENSORS) + "\n" + rows((0.3, 0.2, 0.5, 0, 0, 0), 1500, 0.05) + rows(FORCE[position] + (0, 0, 0), 9000, 2e-4))
third = advice()
assert third["readings"] == 2 and third["newest"]["position"] == position, third
guide.stdin.write("quit\n")
guide.stdin.flush()
assert guide.wait(60) == 2
print("as it should be:", gone["error"])
