"""Readings and processor time to "all goals met" with nothing hidden: `tumble guide` beside NIST's optbayesexpt.

    PYTHONPATH=FOLDER-OF-optbayesexpt python3 tests/scripts/guide_optbayesexpt.py target/release/tumble [--benches 20] [--particles 5000,50000]

optbayesexpt (https://github.com/usnistgov/optbayesexpt, R. D. McMichael, NIST; not on PyPI, and no part of this project) is run as its documentation
shows: `OptBayesExpt` with its defaults (variance utility, 30 draws, optimal setting) and Liu-West resampling without contraction, which it recommends; the standard deviation of the noise known.

One bench: a triad of accelerometers on two joints at right angles, 8 x 8 settings of 45 degrees; two tilts, three biases and three scale factors are
estimated. Truth, noise and goals are drawn: tilts of 1e-4 to 5e-3 rad, biases of 2e-3 V and scale factors of 1 V/g to 1e-3, noise of 2e-5 to 5e-4 V,
goals of two to four times the u that all 64 settings would give. optbayesexpt begins with particles from the very distribution that the truth is
drawn from; tumble supposes tilts of 0.05 rad and nothing of the rest. A reading is all three values at a setting.

Who has reached its goals says so itself: every standard deviation of the particles, or every u, is at most its goal. Held: the true error is within
1.96 of the goal, as it is in 95 % of goals where u is what it is said to be. The forward model here is checked against `tumble simulate` first.
"""

import argparse
import json
import os
import resource
import subprocess
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
from optbayesexpt import OptBayesExpt

NAMES = ["t0", "t1", "b0", "b1", "b2", "k0", "k1", "k2"]
ANGLES = np.arange(8) * 45.0


def turned(axis, angle):
    """Components of a rotation about an axis of the frame, for arrays of angles: rows of R, each entry an array."""
    angle = np.asarray(angle, dtype=float)
    c, s, o, i = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    return {"x": [[i, o, o], [o, c, -s], [o, s, c]], "y": [[c, o, s], [o, i, o], [-s, o, c]], "z": [[c, -s, o], [s, c, o], [o, o, i]]}[axis]


def model(setting, parameters, _):
    """The three values; broadcasts over settings or over particles. Specific force at rest is one g, up."""
    j0, j1 = np.deg2rad(setting[0]), np.deg2rad(setting[1])
    t0, t1, b0, b1, b2, k0, k1, k2 = parameters
    up = [0.0, 0.0, 1.0]
    for axis, angle in (("x", j0), ("y", t0), ("y", j1), ("z", t1)):
        r = turned(axis, angle)
        up = [sum(r[i][j] * up[i] for i in range(3)) for j in range(3)]
    return b0 + k0 * up[0], b1 + k1 * up[1], b2 + k2 * up[2]


def schedule(sd):
    sensors = {f"S{k}": {"unit": "V", "axes": {"I": axis}, "model": f"b{k} + k{k}*a_I"} for k, axis in enumerate("xyz")}
    chain = [{"joint": "j0", "about": "x"}, {"tilt": "t0", "about": "y"}, {"joint": "j1", "about": "y"}, {"tilt": "t1", "about": "z"}]
    bench = {"id": "triad", "site": {"latitude_deg": 48}, "units": {"rate": "deg/s", "force": "g"}, "chain": chain, "sensors": sensors}
    estimate = {name: ({"start": 1} if name[0] == "k" else {}) for name in NAMES}
    rows = [{"position": f"P{k}", "j0_deg": a, "j1_deg": b} | {f"S{s}_u": sd for s in range(3)} for k, (a, b) in enumerate((a, b) for a in ANGLES for b in ANGLES)]
    return {"bench": bench, "estimate": estimate, "readings": rows}


def drawn(rng):
    tilt, sd, factor = 10 ** rng.uniform(-4, -2.3), 10 ** rng.uniform(-4.7, -3.3), rng.uniform(2, 4)
    sizes = np.array([tilt] * 2 + [2e-3] * 3 + [1e-3] * 3)
    centre = np.array([0.0] * 5 + [1.0] * 3)
    truth = centre + sizes * rng.standard_normal(8)
    settings = np.array([s.flatten() for s in np.meshgrid(ANGLES, ANGLES, indexing="ij")])
    rows = []
    for k in range(8):
        step = np.zeros(8)
        step[k] = 1e-6
        up, down = model(settings, centre + step, None), model(settings, centre - step, None)
        rows.append(np.concatenate([(a - b) / 2e-6 for a, b in zip(up, down)]))
    jacobian = np.array(rows).T / sd
    u = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))
    return sd, truth, centre, sizes, factor * u


def by_tumble(program, folder, sd, truth, goals, seed):
    (folder / "own.truth.json").write_text(json.dumps({"values": {n: {"value": v} for n, v in zip(NAMES, truth)}, "noise": {f"S{k}": {"sd": sd} for k in range(3)}}))
    (folder / "own.campaign.json").write_text(json.dumps(schedule(sd)))
    for name in ("guided.campaign.json", "guided.journal.jsonl"):
        (folder / name).unlink(missing_ok=True)
    # goals of angles are arc seconds
    arcsec = np.rad2deg(1) * 3600
    asked = [text for n, g in zip(NAMES, goals) for text in ("--goal", f"{n}={g * (arcsec if n[0] == 't' else 1)}")]
    command = [program, "guide", "own.campaign.json", "--simulate", "own.truth.json", "--seed", str(seed), "--json", "-", "--cost", "mounting=0"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    output = subprocess.run(command + asked, cwd=folder, capture_output=True, text=True).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    steps = [json.loads(line) for line in output.splitlines()]
    met = next((step for step in steps if step["goals"] and all(goal["met"] for goal in step["goals"])), None)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    values = {own["id"]: own["value"] for own in met["goals"]} if met else {}
    held = sum(abs(values.get(n, np.inf) - t) <= 1.96 * g for n, t, g in zip(NAMES, truth, goals))
    return (met["readings"] if met else None), held, seconds, steps[-1]["readings"]


def by_particles(rng, sd, truth, centre, sizes, goals, particles, choke, most):
    begun = time.process_time()
    prior = centre[:, None] + sizes[:, None] * rng.standard_normal((8, particles))
    own = OptBayesExpt(model, (ANGLES, ANGLES), prior, (), default_noise_std=sd, choke=choke, scale=False)
    readings = 0
    try:
        while readings < most and (own.std() > goals).any():
            setting = own.opt_setting()
            values = np.array(model(setting, truth, None)) + sd * rng.standard_normal(3)
            own.pdf_update((setting, values, np.full(3, sd)))
            readings += 1
        own.mean()
    except (ArithmeticError, ValueError, np.linalg.LinAlgError):
        # no particle is near the readings: all weights are zero
        return None, 0, time.process_time() - begun
    reached = bool((own.std() <= goals).all())
    held = int((np.abs(own.mean() - truth) <= 1.96 * goals).sum())
    return (readings if reached else None), held, time.process_time() - begun


def of(count):
    particles, _, choke = count.partition(":")
    return int(particles), float(choke) if choke else None


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--benches", type=int, default=20)
    parser.add_argument("--particles", default="5000,50000,50000:0.1")
    own = parser.parse_args()
    program, folder = os.path.abspath(own.program), Path(tempfile.mkdtemp())
    warnings.simplefilter("ignore")
    # the forward model is the program's
    truth = np.array([0.01, -0.02, 0.1, -0.2, 0.3, 1.1, 0.9, 1.05])
    (folder / "check.campaign.json").write_text(json.dumps(schedule(1e-4)))
    (folder / "check.truth.json").write_text(json.dumps({"values": {n: {"value": v} for n, v in zip(NAMES, truth)}}))
    said = json.loads(subprocess.run([program, "simulate", "check.campaign.json", "--truth", "check.truth.json"], cwd=folder, capture_output=True, text=True, check=True).stdout)
    for row in said["readings"]:
        expected = model((row["j0_deg"], row["j1_deg"]), truth, None)
        assert max(abs(row[f"S{k}"] - expected[k]) for k in range(3)) < 1e-12, row
    # "5000" or, with the likelihood to a power against getting stuck (its argument `choke`), "5000:0.1"
    counts = own.particles.split(",")
    table = {name: [] for name in ["tumble"] + counts}
    for seed in range(own.benches):
        rng = np.random.default_rng(seed)
        sd, truth, centre, sizes, goals = drawn(rng)
        table["tumble"].append(by_tumble(program, folder, sd, truth, goals, seed + 1))
        for count in counts:
            table[count].append(by_particles(rng, sd, truth, centre, sizes, goals, *of(count), 128))
    print(f"{own.benches} benches, {8 * own.benches} goals\n")
    print("| by | goals said to be met | readings, median (quartiles) | goals held by the true errors, of those benches | processor time a bench, median |")
    print("|---|---|---|---|---|")
    for name, rows in table.items():
        reached = [row for row in rows if row[0] is not None]
        q = np.percentile([row[0] for row in reached], [25, 50, 75]) if reached else [np.nan] * 3
        label = name if name == "tumble" else f"optbayesexpt, {name.replace(':', ' particles, choke ')}" + ("" if ":" in name else " particles")
        print(f"| {label} | {len(reached)} | {q[1]:.0f} ({q[0]:.0f} to {q[2]:.0f}) | {sum(row[1] for row in reached)} of {8 * len(reached)} | {np.median([row[2] for row in rows]):.3f} s |")
    print(f"\ntumble's time is of {np.mean([row[3] for row in table['tumble']]):.1f} readings, the start of its process, diagnoses after each reading and the journal on the disk among it")
    pairs = [(a[0], b[0]) for a, b in zip(table["tumble"], table[counts[-1]]) if a[0] and b[0]]
    print(f"both reached: {len(pairs)}; tumble took no more readings in {sum(a <= b for a, b in pairs)}")


if __name__ == "__main__":
    main()
