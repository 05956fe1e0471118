"""From a sample to the view: six channels of 1 kHz in real time through `tumble guide --samples -`.

    python3 tests/scripts/guide_latency.py target/release/tumble [--page] [--seconds 12] [--positions 6]

A writer stamps each row as it goes into the pipe; a reader stamps each line of JSON (or each event of the page, --page) as it comes out. The latency of
a sample is the time from its stamp to that of the first line whose `until_s` is not before it, while a position is held (what moves, or is read, is
said once). Of a change of state, it is the time from the last row that it was found in to its line. Prints quantiles, and processor time a row. Measures this
machine, and so asserts nothing.
"""

import argparse
import http.client
import json
import os
import random
import subprocess
import tempfile
import threading
import time
from pathlib import Path

RATE = 1000
SD, WANTED = 2e-4, 2e-6
SENSORS = "XYZPQR"
MODELS = [("X", "x", "a"), ("Y", "y", "a"), ("Z", "z", "a"), ("P", "x", "w"), ("Q", "y", "w"), ("R", "z", "w")]
SETTINGS = {"up": (0, 0), "down": (180, 0), "left": (90, 0), "right": (270, 0), "nose": (0, 90), "tail": (0, 270)}
# specific force in g, by hand; the Earth's rate is taken as none
FORCE = {"up": (0, 0, 1), "down": (0, 0, -1), "left": (0, 1, 0), "right": (0, -1, 0), "nose": (-1, 0, 0), "tail": (1, 0, 0)}


def schedule():
    sensors = {
        id: {"unit": "V", "axes": {"I": axis}, "model": f"b{id} + k{id}*a_I" if kind == "a" else f"b{id} + 0.01*w_I"} for id, axis, kind in MODELS
    }
    estimate = {f"b{id}": {} for id in SENSORS} | {f"k{id}": {"start": 1} for id in "XYZ"}
    readings = [{"position": name, "roll_deg": roll, "pitch_deg": pitch} for name, (roll, pitch) in SETTINGS.items()]
    chain = [{"joint": "roll", "about": "x"}, {"joint": "pitch", "about": "y"}]
    bench = {"id": "six", "site": {"latitude_deg": 48}, "units": {"rate": "deg/s", "force": "g"}, "chain": chain, "sensors": sensors}
    return {"bench": bench, "estimate": estimate, "readings": readings}


def quantiles(values):
    values = sorted(values)
    at = lambda q: 1e3 * values[min(len(values) - 1, int(q * len(values)))]
    return f"n {len(values)}: median {at(0.5):.1f} ms, 95 % {at(0.95):.1f}, 99 % {at(0.99):.1f}, 99.9 % {at(0.999):.1f}, most {at(1):.1f}"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--page", action="store_true")
    parser.add_argument("--seconds", type=float, default=14)
    parser.add_argument("--positions", type=int, default=6)
    own = parser.parse_args()
    folder = Path(tempfile.mkdtemp())
    (folder / "six.campaign.json").write_text(json.dumps(schedule()))
    command = [os.path.abspath(own.program), "guide", "six.campaign.json", "--samples", "-", "--rate", str(RATE), "--json", "-", "--most", "1000", "--cost", "mounting=0"]
    command += [text for id in SENSORS for text in ("--noise", f"{id}={WANTED}")] + (["--serve"] if own.page else [])
    child = subprocess.Popen(command, cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    asked, seen = {"now": None, "readings": 0}, []

    def lines():
        for line in child.stdout:
            now = time.monotonic()
            text = json.loads(line)
            if text.get("held"):
                if not own.page:
                    seen.append((now, text["held"].get("until_s", 0.0), text["held"]["state"]))
            elif text.get("next"):
                asked["now"], asked["readings"] = text["next"]["position"], text["readings"]

    def page(address):
        host, path = address.removeprefix("http://").split("/", 1)
        connection = http.client.HTTPConnection(host)
        connection.request("GET", f"/{path}events")
        answer = connection.getresponse()
        kind = None
        while line := answer.readline():
            now, line = time.monotonic(), line.decode().strip()
            if line.startswith("event: "):
                kind = line[7:]
            elif line.startswith("data: ") and kind == "held":
                held = json.loads(line[6:])
                seen.append((now, held["until_s"], held["state"]))

    def errors():
        for line in child.stderr:
            if b"the page: " in line and own.page:
                threading.Thread(target=page, args=(line.decode().split("the page: ")[1].strip(),), daemon=True).start()

    for work in (lines, errors):
        threading.Thread(target=work, daemon=True).start()
    while asked["now"] is None:
        time.sleep(0.01)
    chance = random.Random(1)
    stamps = []
    pipe = child.stdin
    pipe.write((",".join(SENSORS) + "\n").encode())
    begin = time.monotonic()
    values = FORCE[asked["now"]] + (0, 0, 0)

    def row(sd, values):
        due = begin + len(stamps) / RATE
        wait = due - time.monotonic()
        if wait > 0:
            time.sleep(wait)
        text = ",".join(f"{value + chance.gauss(0, sd):.7f}" for value in values) + "\n"
        stamps.append(time.monotonic())
        pipe.write(text.encode())
        pipe.flush()

    for _ in range(own.positions):
        label, taken = asked["now"], asked["readings"]
        target = FORCE[label] + (0, 0, 0)
        for k in range(2 * RATE):
            share = k / (2 * RATE)
            row(0.02, [a + share * (b - a) for a, b in zip(values, target)])
        values = target
        for k in range(int(own.seconds * RATE)):
            row(SD, values)
            if asked["readings"] > taken and k % RATE == 0:
                break
    ticks = sum(int(text) for text in Path(f"/proc/{child.pid}/stat").read_text().split()[13:15]) / os.sysconf("SC_CLK_TCK")
    time.sleep(0.3)
    pipe.close()
    child.wait()
    # the time of a row is its number over the rate, from the first one
    stamp = lambda until: stamps[min(len(stamps) - 1, round(until * RATE))]
    held, changes = [], []
    for (_, before, was), (now, until, state) in zip(seen, seen[1:]):
        if was == state == "held":
            held += [now - stamps[k] for k in range(round(before * RATE) + 1, min(round(until * RATE) + 1, len(stamps)))]
        elif was != state:
            changes.append(now - stamp(until))
    late = [max(0.0, s - (begin + k / RATE)) for k, s in enumerate(stamps)]
    print(f"{len(stamps)} rows in {stamps[-1] - begin:.1f} s, {asked['readings']} readings; the writer was late by {quantiles(late)}")
    print(f"a sample, while a position is held: {quantiles(held)}")
    print(f"a change of state: {quantiles(changes)}")
    print(f"processor time: {1e6 * ticks / len(stamps):.1f} us a row")


if __name__ == "__main__":
    main()
