"""README.md and the picture of examples/10 to 24, from what the program prints and reports.

Run after `cargo build --release`: python3 tests/scripts/example_readmes.py   (needs nothing but Python)
Every command is a `sh` block, lines of its output are the `text` block after it; tests/program/examples.rs runs them again and compares.
"""
import json
import math
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
TUMBLE = ROOT / "target/release/tumble"
INK, GRID, BLUE, RED, GREEN = "#333", "#ddd", "#1f6fb4", "#c8442c", "#3a8f4d"


def run(folder, *arguments):
    out = subprocess.run([TUMBLE, *arguments], cwd=ROOT / "examples" / folder, capture_output=True, text=True)
    assert out.returncode in (0, 2), out.stderr
    return out.stdout


def console(folder, arguments, keep):
    """A console block: the command, and the lines of its output that match one of the patterns."""
    lines, kept, skipped = run(folder, *arguments.split()).splitlines(), [], False
    for line in lines:
        if any(re.search(p, line) for p in keep):
            kept.append(line.rstrip())
            skipped = False
        elif not skipped:
            kept.append("...")
            skipped = True
    return f"```sh\ntumble {arguments}\n```\n\n```text\n" + "\n".join(kept) + "\n```\n"


def report(folder, *arguments):
    return json.loads(run(folder, *arguments, "--json", "-"))


class Picture:
    """A chart with two axes, linear or logarithmic, as SVG."""

    def __init__(self, title, x, y, x_label, y_label, log=(False, False), width=720, height=400, right=24):
        self.box, self.log, self.parts = (80, 46, width - right, height - 56), log, []
        self.x, self.y = ([math.log10(v) for v in r] if g else list(r) for r, g in zip((x, y), log))
        self.head = (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
                     f'font-family="sans-serif" font-size="12" fill="{INK}">\n<title>{title}</title>\n'
                     f'<rect width="{width}" height="{height}" fill="white"/>\n<text x="{width / 2}" y="22" '
                     f'text-anchor="middle" font-size="15">{title}</text>\n')
        left, top, right, bottom = self.box
        self.parts.append(f'<text x="{(left + right) / 2}" y="{height - 12}" text-anchor="middle">{x_label}</text>')
        self.parts.append(f'<text transform="translate(18 {(top + bottom) / 2}) rotate(-90)" text-anchor="middle">{y_label}</text>')

    def at(self, x, y):
        left, top, right, bottom = self.box
        x, y = (math.log10(v) if g else v for v, g in zip((x, y), self.log))
        return (round(left + (x - self.x[0]) / (self.x[1] - self.x[0]) * (right - left), 2),
                round(bottom - (y - self.y[0]) / (self.y[1] - self.y[0]) * (bottom - top), 2))

    def ticks(self, x, y, names=None):
        left, top, right, bottom = self.box
        low = lambda r, g: 10 ** r[0] if g else r[0]
        for k, v in enumerate(x):
            px = self.at(v, low(self.y, self.log[1]))[0]
            self.parts.append(f'<line x1="{px}" y1="{top}" x2="{px}" y2="{bottom}" stroke="{GRID}"/><text x="{px}" y="{bottom + 16}" '
                              f'text-anchor="middle">{names[k] if names else f"{v:g}"}</text>')
        for v in y:
            py = self.at(low(self.x, self.log[0]), v)[1]
            self.parts.append(f'<line x1="{left}" y1="{py}" x2="{right}" y2="{py}" stroke="{GRID}"/><text x="{left - 6}" y="{py + 4}" '
                              f'text-anchor="end">{v:g}</text>')

    def line(self, points, colour, dash=""):
        path = " ".join(f"{a},{b}" for a, b in (self.at(*p) for p in points))
        self.parts.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2" stroke-dasharray="{dash}"/>')

    def dots(self, points, colour, hollow=False):
        for p in points:
            a, b = self.at(*p)
            fill = f'fill="white" stroke="{colour}" stroke-width="2"' if hollow else f'fill="{colour}"'
            self.parts.append(f'<circle cx="{a}" cy="{b}" r="4" {fill}/>')

    def bar(self, x, low, high, colour):
        (a, b), (_, d) = self.at(x, low), self.at(x, high)
        self.parts.append(f'<line x1="{a}" y1="{b}" x2="{a}" y2="{d}" stroke="{colour}" stroke-width="2"/>')

    def label(self, x, y, text, colour, anchor="start", down=-6):
        a, b = self.at(x, y)
        self.parts.append(f'<text x="{a + 8}" y="{b + down}" fill="{colour}" text-anchor="{anchor}">{text}</text>')

    def write(self, path):
        (ROOT / "examples" / path).write_text(self.head + "\n".join(self.parts) + "\n</svg>\n")


def bars(path, title, x_label, rows):
    """Horizontal bars, one line for each (name, value, colour, text behind the bar): as high as there are rows, as wide as their names."""
    line, top, bar = 24, 64, 420
    left = 20 + 7 * max(len(name) for name, *_ in rows)
    most = max(value for _, value, *_ in rows)
    step = next(s * 10 ** e for e in range(-12, 12) for s in (1, 2, 5) if most / (s * 10 ** e) <= 5)
    scale = bar / (step * math.ceil(most / step))
    width, height = left + bar + 120, top + line * len(rows) + 16
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
             f'font-family="sans-serif" font-size="12" fill="{INK}">\n<title>{title}</title>\n<rect width="{width}" height="{height}" fill="white"/>',
             f'<text x="{width / 2}" y="20" text-anchor="middle" font-size="15">{title}</text>',
             f'<text x="{left + bar / 2}" y="38" text-anchor="middle">{x_label}</text>']
    for k in range(math.ceil(most / step) + 1):
        x = round(left + k * step * scale, 2)
        parts.append(f'<line x1="{x}" y1="{top - 6}" x2="{x}" y2="{height - 12}" stroke="{GRID}"/>'
                     f'<text x="{x}" y="{top - 10}" text-anchor="middle">{k * step:g}</text>')
    for k, (name, value, colour, text) in enumerate(rows):
        y, length = top + line * k, round(value * scale, 2)
        parts.append(f'<text x="{left - 8}" y="{y + 14}" text-anchor="end">{name}</text>'
                     f'<rect x="{left}" y="{y + 2}" width="{max(length, 1)}" height="16" fill="{colour}"/>'
                     f'<text x="{left + length + 6}" y="{y + 14}">{text}</text>')
    (ROOT / "examples" / path).write_text("\n".join(parts) + "\n</svg>\n")


def readme(folder, text):
    (ROOT / "examples" / folder / "README.md").write_text(text)
    print("wrote", folder)


def imu():
    folder = "10-imu-three-axis-table"
    study = json.loads((ROOT / "examples" / folder / "study.json").read_text())
    gyro, acc = "gyro_installation_arcsec", "accelerometer_installation_arcsec"
    rows = [r for r in study if r["table_error_arcsec"] > 0]
    p = Picture("What table errors do to an IMU calibration", (0.9, 110), (0.1, 400), "standard deviation of each table error, arcsec",
                "rms installation error, arcsec", (True, True), right=170)
    p.ticks([1, 2, 5, 10, 20, 50, 100], [0.1, 1, 10, 100])
    for key, dash, name in ((gyro, "", "gyros"), (acc, "6 4", "accelerometers")):
        for way, colour in (("discrete", RED), ("joint", BLUE)):
            points = [(r["table_error_arcsec"], r[way][key]) for r in rows]
            p.line(points, colour, dash)
            p.dots(points, colour)
            p.label(*points[-1], f"{way}, {name}", colour, down=4)
    p.write(f"{folder}/study.svg")
    table = "| table error | gyro installation, discrete | joint | accelerometer installation, discrete | joint | accelerometer zero, discrete | joint |\n|---:|---:|---:|---:|---:|---:|---:|\n"
    for r in study:
        d, j, z = r["discrete"], r["joint"], "accelerometer_zero_ug"
        table += f'| {r["table_error_arcsec"]:g}" | {d[gyro]:.3f}" | {j[gyro]:.3f}" | {d[acc]:.2f}" | {j[acc]:.2f}" | {d[z]:.2f} ug | {j[z]:.2f} ug |\n'
    readme(folder, f"""# An IMU on a three-axis table

![errors against table error](study.svg)

Three gyros and three accelerometers with pulse outputs, 24 static positions (each axis up and down in four azimuths) and 36 rate
runs (both senses of three rates about each table axis, in two attitudes between which Earth rate along the axis cancels; there the
mean of all gyro readings is also the zero test). The bench is built in: `tumble bench show imu-three-axis-table`. All six sensors
share one chain, so the table's own errors (levelling, zero, linear and squareness errors of the joints) are tilts common to all of them.

## The discrete calibration is least squares, as long as the table is perfect

{console(folder, "compare perfect-table.campaign.json", ["^all +(Kgx|Egxz|Dx0|Kax|Eaxz|Kxx) ", "^closed form", "angle"])}
On this schedule the paper's kind of closed form (slopes over the rates, half differences, means) *is* the square special case.

## Table errors, estimated with the sensors

{console(folder, "fit table-errors.campaign.json", ["^parameter", "^(level|square|middle|inner).*free", "^Egxz", "^Eaxz", "readings, rank"])}
The truth was 22, -31, 27, -18, -4 and 5 arcsec (linear errors: arcsec for each radian).

## Error against table error

Six table errors drawn at random, twelve draws at each size, the noise of a good table; root mean square error of the result:

{table}
The discrete calibration takes every table error into the installation errors; the joint fit does not notice them. Below a few
tenths of an arcsecond of table error the discrete calibration is the better of the two: six unknowns that are not there cost something.

## What hides in what

{console(folder, "fit everything.campaign.json", ["NOT ESTIMABLE: (Egxz - mount_z|inner_zero - mount_y)"])}
* The mounting of the IMU (`mount_x`, `mount_y`, `mount_z`) hides in the installation errors: `mount_z` in Egxz, -Egyz, Eaxz, -Eayz, and
  cyclically. Only the sums are estimable, on any schedule of this bench; they are what an installation error *means*.
* The zero of the inner joint (`inner_zero`) hides in the same four as `mount_y`.
* The zero of the outer joint (`outer_zero`) and the squareness of inner to middle axis (`square_mi`) show only through Earth rate: tens
  of arcseconds of uncertainty here. Without it `square_mi` hides in `mount_z`: where the inner joint is not at zero an axis of
  the IMU is vertical, and the accelerometers do not see a turn about it.
* Levelling, `square_om`, `middle_zero`, `middle_linear`, `inner_linear` are estimable.

Model lines are bilinear (`Kgx*(w_x + Egxz*w_y + ...)`); the fit iterates on them. Away from the reference point the accelerometers'
second-order terms would separate the mounting from the installation errors by a hair (to radians), so Gauss-Newton holds `inner_zero` and
the mounting where they were, and says so. A mounting of 206 arcsec that is held at zero changes the scale factors by the cosine of the
angle: their U holds only for the mounting as held, and the fit says for which by how much.
The study's numbers are in `study.json`; a test computes them again.
""")


def skew():
    folder = "11-gyro-skew-triad"
    truth = json.loads((ROOT / "tests/data/simulated/skew-triad.truth.json").read_text())["truth"]
    first, direct = report(folder, "fit", "first-stage.campaign.json"), report(folder, "fit", "direct.campaign.json")
    names = [f"D{a}{k}" for k in (1, 2, 3) for a in "IS"]
    two = {d["id"].replace("_", ""): d for d in first["derived"]}
    one = {d["id"]: d for d in direct["parameters"]}
    p = Picture("Drift coefficients, estimate minus truth, with U (95 %)", (0.5, 6.5), (-2, 2), "coefficient", "0.001 deg/(h g)")
    p.ticks([1, 2, 3, 4, 5, 6], [-2, -1, 0, 1, 2], names)
    for limit in (-1.3, 1.3):
        p.line([(0.5, limit), (6.5, limit)], RED, "6 4")
    p.label(0.5, -1.75, "dashed: the figure to reach, 1.3e-3", RED)
    for k, n in enumerate(names):
        for shift, source, colour in ((-0.08, two, GREEN), (0.08, one, BLUE)):
            e, u = (1e3 * (source[n]["value"] - truth[n]), 1e3 * source[n]["U"])
            p.bar(k + 1 + shift, e - u, e + u, colour)
            p.dots([(k + 1 + shift, e)], colour)
    p.label(4.4, -1.75, "green: two stages", GREEN)
    p.label(5.5, -1.75, "blue: one fit", BLUE)
    p.write(f"{folder}/drift.svg")
    table = "| | truth | two stages | U | one fit | U |\n|---|---:|---:|---:|---:|---:|\n"
    for n in names:
        table += f'| {n} | {truth[n]:.5f} | {two[n]["value"]:.5f} | {two[n]["U"]:.5f} | {one[n]["value"]:.5f} | {one[n]["U"]:.5f} |\n'
    readme(folder, f"""# A skew-mounted gyro triad

![drift coefficients](drift.svg)

Three floated gyros with input axes on a cone of half angle 54.7356 deg about Xb. The spin axes are not given by the mounting alone;
the choice here: each spin axis is square to its input axis in the plane of Xb and that axis, and follows the input axis (nominal S made
square to the calibrated i). 24 positions and 36 rate runs, 0.0015 deg/h at rest and 0.05 deg/h while turning, both stated with the readings.

Outputs are pulses: E in pulse/arcsec (about 2), G in pulse/(s g). The coefficients to find are D_I and D_S of each gyro: drift proportional to
specific force along its input and its spin axis, **referred to the input**, deg/(h g): G is divided by |E| (1 deg/h is 1 arcsec/s). Two ways:

* **two stages**: each channel at IMU level (D, E, G, P); then nine equations G = |E| (D_I i + D_S s) in six unknowns, i = E/|E|. As derived
  quantities in `first-stage.campaign.json` they take the whole covariance with them; `compare::second_stage` is the same as generalised
  least squares with the first stage's covariance, and its three spare equations test that there is no drift along the output axes.
* **one fit**: the model line along the gyros' own axes, in `direct.campaign.json`.

{table}
Both agree to a few thousandths of their uncertainty, and all six reach the paper's 1.3e-3 deg/(h g) with U (95 %). (With 0.0019 deg/h at
rest U would just be that figure.) No formula is chosen by the signs of the angle errors: a test runs all eight patterns of signs.

{console(folder, "fit first-stage.campaign.json", ["derived", "global test", "readings, rank"])}
## What a tilted mounting face does

Tilt about each of the three axes, no noise; largest error of a coefficient in deg/(h g):

| tilt | D_I, calibrated axes | D_S, calibrated axes | D_I, nominal axes | D_S, nominal axes |
|---:|---:|---:|---:|---:|
| 30" | 0 | 3.1e-8 | 2.3e-4 | 5.7e-5 |
| 100" | 0 | 3.4e-7 | 7.7e-4 | 1.9e-4 |
| 300" | 0 | 3.1e-6 | 2.3e-3 | 5.6e-4 |
| 1000" | 0 | 3.4e-5 | 7.7e-3 | 1.9e-3 |

The tilt turns E and G together, so along calibrated axes only a turn of the spin axis about i is left: second order. With nominal axes
300 arcsec are already more than the figure to reach.

## What is not separable

{console(folder, "fit everything.campaign.json", ["NOT ESTIMABLE: D1"])}
At 1 g the three squares add to a constant: P_x, P_y, P_z and D are one too many. The campaigns above take P_x as zero, which is listed.
""")


def cube():
    folder = "12-cube-mirror"
    rules = [("stated rule, s = 0.69", 0.4033), ("stated rule, s = 0.76", 0.4238), ("stated rule, both runs pooled: s = 0.726", 0.4137),
             ("mean of the two results of the stated rule", 0.4136), ("both runs pooled, twelve values", 0.3567),
             ("circle error of a mean of two faces, s = 0.76", 0.3714), ("two runs as two effects, no circle error", 0.4191),
             ("circle error 0.5 as a standard uncertainty, s = 0.76", 0.5884), ("not divided by sqrt(6), s = 0.69", 0.7480)]
    table = "| reading of the rule | u | U = 2u |\n|---|---:|---:|\n" + "".join(
        f"| {'**' if round(u, 2) == 0.41 else ''}{n}{'**' if round(u, 2) == 0.41 else ''} | {u:.4f} | {2 * u:.2f} |\n" for n, u in rules)
    r = report(folder, "fit", "attitude.campaign.json")
    roll = next(p for p in r["parameters"] if p["id"] == "roll")
    budget = sorted([b for b in roll["budget"] if b["u"] > 1e-3], key=lambda b: -b["u"])
    rows = [(b["source"], b["u"], BLUE if b["type"] == "A" else GREEN, f'{b["u"]:.3f} (Type {b["type"]})') for b in budget]
    bars(f"{folder}/budget.svg", "Uncertainty budget of the roll", "standard uncertainty, arcsec; sources above 0.001", rows)
    readme(folder, f"""# Attitude by a cube mirror and two theodolites

Azimuth is carried from an astronomical mark (u = 0.5 arcsec): theodolite A sights the mark, its neighbour B and, by autocollimation, face M of
the cube; B sights A and face N. Every circle reading is a row, both faces, six repeats; then the device's own outputs. Unknown are
the attitude, the orientation of both circles, their collimation and index errors, the base line's azimuth and the cube's
departure from a right angle. All angles are in arcsec. `tumble bench show cube-mirror` prints the lines.

Signs: azimuth clockwise from north; pitch positive nose up; roll positive right side down, so that face N on the left rises with the
roll: **sin T_N = cos(pitch) sin(roll)**. Face N on the right is the bench `cube-mirror-right`, with a minus there. Readings of a circle that differ
by whole turns are the same (`"turn"` in the bench file), angles come out within 180 deg, and where one sight disagrees with the others by degrees
(the mirror's other side, a start too far away) the report names it. With a cube angle e between N and square to M
it is sin T_N = cos e cos(pitch) sin(roll) + sin e sin(pitch), and that is the line that is fitted.

{console(folder, "fit attitude.campaign.json", ["free$", "^parameter"])}
`d_heading`, `d_pitch`, `d_roll` are the device's errors: device output less attitude. The truth was 6.5, -2.2 and 3.9.

![budget of the roll](budget.svg)

Circle errors of 0.5 arcsec are rectangular, u = 0.29. For the compensator this example takes u = 0.1 arcsec, **not the source's 3 arcsec**:
those, rectangular, have u = 1.73 and would be most of the uncertainty of pitch (1.78) and roll (1.76), which the source's own U = 0.82 does not
contain. The means of both faces, which a surveyor would form by hand, are least squares here:

{console(folder, "compare attitude.campaign.json", ["^all +(pitch|heading|roll|cube|d_roll) ", "^closed form"])}
## The printed 0.41 and 0.82

The source gives repeatabilities of the roll of 0.69 arcsec with face left and 0.76 arcsec with face right (n = 6), a circle error of 0.5 arcsec,
and U = 0.82 arcsec (k = 2, u = 0.41). By its rule u^2 = (s/sqrt(n))^2 + (0.5/sqrt(3))^2 each face has

{console(folder, "fit roll-069.campaign.json", ["^roll"])}
{console(folder, "fit roll-076.campaign.json", ["^roll"])}
and the roll is the mean of both, sensitivity coefficients c = 0.5 (its eq. 22). A coefficient enters a variance by its square:

{console(folder, "fit both-faces.campaign.json", ["^roll"])}
| both faces | u | U = 2u |
|---|---:|---:|
| sqrt(0.5^2 * 0.4033^2 + 0.5^2 * 0.4238^2), eq. 22 | 0.29 | 0.585 |
| sqrt(0.5 * (0.4033^2 + 0.4238^2)), c not squared | 0.41 | 0.83 |

So u = 0.29 and U = 0.585 (k = 2). The printed 0.41 arises where c is not squared, and 0.82 is twice the rounded 0.41.

## What hides in what

Without the mark nothing fixes the azimuths: `heading + d_heading`, `base + d_heading`, `oA - d_heading` and `oB - d_heading` are what is
left, by name; pitch, roll and the cube's angle stay estimable.

## Intervals that hold what they promise

A collimation is a mean of three directions weighted by their own scatter, each scatter from about ten degrees of freedom. With weights
taken as if they were known its 95 % interval would hold the truth in 92 % of simulated campaigns. What estimated weights cost (Kenward and
Roger) is part of the uncertainty, a line of its own in the budget; then it is 95 %, as for all other parameters. A test simulates it.
""")


def head():
    folder = "13-accelerometer-dividing-head"
    truth = json.loads((ROOT / "tests/data/simulated/dividing-head.truth.json").read_text())["truth"]
    p = Picture("K2 and K3 by 4, 8, 12 and 24 positions, with U (95 %)", (0.5, 4.5), (-60, 80), "positions", "1e-6 V/g^2, 1e-6 V/g^3")
    p.ticks([1, 2, 3, 4], [-60, -40, -20, 0, 20, 40, 60, 80], ["4", "8", "12", "24"])
    table = "| positions | degrees of freedom | " + " | ".join(truth) + " |\n|---:|---:|" + "---:|" * len(truth) + "\n"
    for k, n in enumerate((4, 8, 12, 24)):
        r = report(folder, "fit", f"head-{n}.campaign.json")
        by = {q["id"]: q for q in r["parameters"]}
        cells = []
        for name in truth:
            q = by.get(name)
            cells.append("" if q is None else f'{q["value"]:.4g}' + (f' ± {q["U"]:.1g}' if q.get("U") else ""))
            if q and name in ("K2", "K3"):
                v, u, colour = 1e6 * q["value"], 1e6 * (q.get("U") or 0), BLUE if name == "K2" else RED
                p.bar(k + 1, v - u, v + u, colour)
                p.dots([(k + 1, v)], colour, hollow=u == 0)
        table += f'| {n} | {r["fit"]["dof"]} | ' + " | ".join(cells) + " |\n"
    table += "| truth | | " + " | ".join(f"{v:.4g}" for v in truth.values()) + " |\n"
    for name, colour in (("K2", BLUE), ("K3", RED)):
        p.line([(0.5, 1e6 * truth[name]), (4.5, 1e6 * truth[name])], colour, "2 4")
        p.label(0.5, 1e6 * truth[name], f"{name}, truth", colour)
    p.write(f"{folder}/positions.svg")
    readme(folder, f"""# The multi-position gravity test of an accelerometer

A dividing head with a horizontal axis turns the input axis through equidistant angles: a_I = sin(theta), a_P = cos(theta). The line is
`K0 + K1*a_I + K2*a_I^2 + K3*a_I^3 + KIP*a_I*a_P + KP*a_P` (the bench also has cross terms with O and three tilts, zero here and listed as such).

{table}
![K2 and K3](positions.svg)

Values with U (95 %), noise 5e-6 V; a hollow dot has no interval. Four positions solve four coefficients with nothing to spare, so no uncertainty can be given; and they
cannot tell K3 from K1 (asked for it, the program names `K1 + K3` as what is estimable) nor see KIP at all.

## The Fourier sums are least squares

{console(folder, "compare head-12.campaign.json", ["^all", "angle", "^closed form"])}
The classical closed forms (K3 = -4 S3, K2 = -2 C2, K1 = S1 - 3/4 K3, K0 = C0 - K2/2, KIP = 2 S2, KP = C1) equal least squares to
rounding on 4, 8, 12 and 24 positions. They hold for equidistant positions and a level head only; with known tilts of the head
least squares still returns the truth (`tests/systems/dividing_head.rs`).

{console(folder, "fit head-24.campaign.json", ["free$", "^parameter", "readings, rank", "residual sd", "assumed zero"])}
The zero of the head hides: asked for both, the program says that only a combination of `head_zero` and `KP` is estimable.
""")


def xsens():
    folder = "14-xsens-static-positions"
    r = report(folder, "fit", "xsens.campaign.json")
    rows = [(q["index"], 1e3 * q["residual"]) for q in r["readings"]]
    p = Picture("Residuals of the norm of gravity, 38 static positions", (0, 39), (-3, 3), "position", "residual, 1e-3 m/s^2")
    p.ticks([1, 10, 20, 30, 38], [-3, -2, -1, 0, 1, 2, 3])
    p.line([(0, 0), (39, 0)], INK)
    for x, y in rows:
        p.bar(x, 0, y, GRID)
    p.dots(rows, BLUE)
    p.write(f"{folder}/residuals.svg")
    readme(folder, f"""# Real positions without a reference attitude

38 static positions of a real triaxial accelerometer (raw counts), held by hand: nobody knows the attitudes. The equation is the norm:
whatever the attitude, the calibrated specific force is as long as gravity, 9.81744 m/s^2. The bench has no chain; its line is
sqrt(x^2 + y^2 + z^2) with x, y, z from counts, scale factors, zero offsets and three misalignments (Tedaldi, Pretto, Menegatti 2014).
Data: static intervals of the Xsens recording in github.com/Kyle-ak/imu_tk (BSD).

{console(folder, "fit xsens.campaign.json", ["free$", "^parameter", "readings, rank", "residual sd"])}
![residuals](residuals.svg)

A reference of 40 digits (`tests/scripts/xsens_campaign.py`) and scipy agree to a millionth of an uncertainty. What the norm cannot say is how
the triad sits in its box: a rotation of all three axes changes no norm, so the
sensitive axis of z is taken as the frame's z, and that of y as lying in its y-z plane.
""")


if __name__ == "__main__":
    for chapter in (imu, skew, cube, head, xsens):
        chapter()
