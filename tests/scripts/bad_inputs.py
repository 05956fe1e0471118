"""Malformed questions, one fault each: tests/data/bad/*, and INDEX.json which says what an error must say.

INDEX.json: file (what `tumble fit` or `tumble check` is given) -> {
    fault         what is wrong, in words
    must_mention  words that must all be in the message (a key, a name, a file)
    line          line of the fault, counted from 1, where that has a meaning; in the file `line_in` if that is there
    model, caret, column   a model line, its offending character counted from 0, and that character's column in the file, from 1
    reads         the second file that is read, if any (a missing one is not written)
    exit          1 malformed; 2 done and rejected; 0 fine (beside the malformed ones, for contrast)
    issue         true for the faults that the program's own list names, false for further ones }
Run: python3 tests/scripts/bad_inputs.py   (rewrites the folder)
"""
import copy
import json

from common import DATA, campaign_text

BAD = DATA / "bad"
INDEX = {}
READINGS = [{"position": str(b), "beta_deg": b, "V": v} for b, v in
            ((0, -0.001845), (90, -0.001912), (180, -0.001911), (270, -0.002175), (45, -0.001801))]
GOOD = {"bench": "accelerometer-plumb-plane", "known": {"kI": {"value": 1.299, "unit": "V/g", "u": 0}},
        "estimate": {"V0": {}, "dtheta_y2": {}, "dtheta_z2": {}}, "readings": READINGS}
BENCH = json.loads((DATA / "benches/accelerometer-plumb-plane.bench.json").read_text())
CSV = "position,beta_deg,V\n" + "".join(f"{r['position']},{r['beta_deg']},{r['V']}\n" for r in READINGS)


def entry(name, fault, mention, line=None, exit=1, issue=True, **more):
    INDEX[name] = {"fault": fault, "must_mention": mention, **({"line": line} if line else {}), **more, "exit": exit, "issue": issue}


def put(name, text, fault, mention, at=None, **more):
    """Write one campaign; `at` is a piece of the offending line, for its number."""
    (BAD / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    line = 1 + text[:text.index(at)].count("\n") if at else None
    entry(name, fault, mention, line, **more)


def campaign(name, fault, mention, change, at=None, replace=(), **more):
    """GOOD, changed by `change`, then by textual replacements (for what JSON writers refuse to write)."""
    question = copy.deepcopy(GOOD)
    question = change(question) or question
    text = campaign_text(question)
    for old, new in replace:
        assert old in text, old
        text = text.replace(old, new, 1)
    put(name + ".campaign.json", text, fault, mention, at, **more)


def bench(name, fault, mention, change, at=None, **more):
    """GOOD with the bench inline, changed by `change`."""
    def both(question):
        question["bench"] = copy.deepcopy(BENCH)
        change(question["bench"])
    campaign(name, fault, mention, both, at, **more)


def model(name, fault, line_text, mention, caret=None):
    """GOOD with a model line; `caret` is the offending character, counted from 0 in the line."""
    bench("model-" + name, fault, mention, lambda b: b["sensors"]["V"].update(model=line_text), '"model"')
    if caret is not None:
        file = "model-" + name + ".campaign.json"
        text = (BAD / file).read_text().splitlines()[INDEX[file]["line"] - 1]
        INDEX[file].update(model=line_text, caret=caret, column=text.index('"model": "') + len('"model": "') + caret + 1)


def csv(name, fault, mention, content, line=None, **more):
    (BAD / (name + ".csv")).write_bytes(content if isinstance(content, bytes) else content.encode())
    campaign(name, fault, mention, lambda q: q.update(readings=name + ".csv"), reads=name + ".csv", **more)
    if line:
        INDEX[name + ".campaign.json"].update(line=line, line_in=name + ".csv")


def reading(index, **changes):
    return lambda q: q["readings"][index].update(changes)


def keys_and_names():
    campaign("unknown-key", "a key the campaign does not have", ["estimates"], lambda q: q.update(estimates=q.pop("estimate")), '"estimates"')
    campaign("unknown-key-known", "a key a known value does not have", ["valeu"], lambda q: q["known"].update(kI={"valeu": 1.299}), '"valeu"')
    campaign("unknown-key-estimate", "a key an estimate does not have", ["priro"], lambda q: q["estimate"].update(V0={"priro": 0}), '"priro"')
    bench("unknown-key-bench", "a key the bench does not have", ["chian"], lambda b: b.update(chian=b.pop("chain")), '"chian"')
    bench("unknown-key-chain", "a key a joint does not have", ["abuot"], lambda b: b["chain"].__setitem__(1, {"joint": "beta", "abuot": "x"}), '"abuot"')
    bench("unknown-key-site", "a key the site does not have", ["lattitude_deg"], lambda b: b.update(site={"lattitude_deg": 45.75}), '"lattitude_deg"')
    bench("unknown-key-sensor", "a key a sensor does not have", ["modle"], lambda b: b["sensors"]["V"].update(modle=b["sensors"]["V"].pop("model")), '"modle"')
    campaign("missing-joint", "a reading that does not say where joint beta stands", ["beta"], lambda q: q["readings"][2].pop("beta_deg") and None, '"180"')
    campaign("missing-bench", "a campaign without a bench", ["bench"], lambda q: q.pop("bench") and None)
    campaign("missing-readings", "a campaign without readings", ["readings"], lambda q: q.pop("readings") and None)
    campaign("unknown-parameter", "a parameter that the bench does not have is to be estimated", ["dtheta_y9"],
             lambda q: q["estimate"].update(dtheta_y9={}), '"dtheta_y9"')
    campaign("unknown-known", "a parameter that the bench does not have is known", ["kQ"], lambda q: q["known"].update(kQ={"value": 1}), '"kQ"')
    campaign("clash-known-and-estimated", "one parameter both known and estimated", ["kI"], lambda q: q["estimate"].update(kI={}))
    campaign("clash-column-parameter", "a column of the readings has the name of a parameter", ["V0"], lambda q: [r.update(V0=1.5) for r in q["readings"]] and None)
    campaign("clash-column-input", "a column of the readings has the name of an input of the model line", ["a_I"],
             lambda q: [r.update(a_I=0.1) for r in q["readings"]] and None)
    bench("clash-tilt-joint", "a tilt has the name of a joint", ["beta"], lambda b: b["chain"][0].update(tilt="beta"), '"tilt": "beta"')
    bench("clash-tilt-sensor", "a tilt has the name of a sensor", ["V"], lambda b: b["chain"][0].update(tilt="V"), '"tilt": "V"')
    sine = copy.deepcopy(BENCH)
    sine["chain"][1]["joint"] = "sin"
    campaign("clash-joint-function", "a joint has the name of a function", ["sin"], lambda q: q.update(
        bench=sine, readings=[{**{k: v for k, v in r.items() if k != "beta_deg"}, "sin_deg": r["beta_deg"]} for r in READINGS]), '"sin"')
    bench("chain-repeats-tilt", "the chain has one tilt twice", ["dtheta_y2"], lambda b: b["chain"][0].update(tilt="dtheta_y2"),
          '"tilt": "dtheta_y2", "about": "y", "is": "input')
    bench("chain-repeats-joint", "the chain has one joint twice", ["beta"], lambda b: b["chain"].append({"joint": "beta", "about": "y"}),
          '"joint": "beta", "about": "y"')


def values():
    campaign("infinity", "a reading beyond the range of numbers", [], lambda q: None, "1e999", [("-0.001911", "1e999")])
    campaign("infinity-known", "a known value beyond the range of numbers", [], lambda q: None, "1e999", [("1.299", "1e999")])
    campaign("infinity-angle", "a joint angle beyond the range of numbers", [], lambda q: None, "-1e999", [('"beta_deg": 90', '"beta_deg": -1e999')])
    campaign("nan", "NaN, which JSON does not have", [], lambda q: None, "NaN", [("-0.001911", "NaN")])
    campaign("empty-readings", "no reading at all", ["readings"], lambda q: q.update(readings=[]))
    campaign("zero-u", "a standard uncertainty of zero", ["V_u"], reading(1, V_u=0), '"V_u"')
    campaign("negative-u", "a negative standard uncertainty", ["V_u"], reading(1, V_u=-1e-6), '"V_u"')
    campaign("negative-u-known", "a negative uncertainty of a known value", ["kI"], lambda q: q["known"]["kI"].update(u=-0.1))
    campaign("zero-prior-u", "a prior without uncertainty", ["prior_u"], lambda q: q["estimate"].update(V0={"prior": 0, "prior_u": 0}), '"prior_u"')
    campaign("zero-n", "a mean of no samples", ["n"], reading(1, n=0), '"n": 0')
    campaign("text-for-number", "a text where a number belongs", ["V"], reading(2, V="high"), '"high"')
    campaign("array-for-number", "an array among readings with values, of another length", ["V"], reading(2, V=[1, 2, 3]), "[1, 2, 3]", issue=False)
    campaign("schedule-not-campaign", "nothing was measured: no sensor has a value", ["V"], lambda q: [r.pop("V") for r in q["readings"]] and None, issue=False)
    campaign("nothing-to-estimate", "no unknown is named", ["estimate"], lambda q: q.update(estimate={}), issue=False)
    campaign("unknown-unit", "a tilt in a unit that is none", ["furlong"], lambda q: q["known"].update(dtheta_y0={"value": 1, "unit": "furlong"}),
             '"furlong"', issue=False)
    bench("latitude-out-of-range", "a latitude beyond the pole", ["latitude"], lambda b: b.update(site={"latitude_deg": 95}), '"latitude_deg"', issue=False)
    bench("unknown-axis", "a rotation about an axis that is none", ["w"], lambda b: b["chain"][1].update(about="w"), '"about": "w"', issue=False)
    bench("cosines-not-unit", "direction cosines whose squares do not sum to one", ["I"],
          lambda b: b["sensors"]["V"]["axes"].update(I=[1, 1, 0]), '"I": [1, 1, 0]', issue=False)
    bench("unknown-rate-unit", "a rate unit that is none", ["rpm"], lambda b: b["units"].update(rate="rpm"), '"rpm"', issue=False)
    two = {"bench": "gyro-turntable", "known": {"kI": {"value": -2.9222}}, "estimate": {"V0": {}},
           "readings": [{"position": "1", "alpha_deg": 0, "beta_deg": 0, "gamma_deg_s": 20, "V": -0.06},
                        {"position": "2", "alpha_deg": 0, "beta_deg_s": 5, "gamma_deg_s": 20, "V": 0.06}]}
    campaign("two-turning-joints", "two joints turn in one reading", ["beta", "gamma"], lambda q: two, '"beta_deg_s"')

    def turned(**keys):
        return lambda q: {**copy.deepcopy(two), "readings": [two["readings"][0], {"position": "2", "alpha_deg": 0, "beta_deg": 0, "V": 0.06, **keys}]}
    campaign("turns-without-rate", "turns of a joint that does not turn", ["gamma_turns"], turned(gamma_deg=0, gamma_turns=1), '"gamma_turns"', issue=False)
    campaign("zero-turns", "a mean over no turn", ["gamma_turns"], turned(gamma_deg=0, gamma_deg_s=20, gamma_turns=0), '"gamma_turns"', issue=False)


def model_lines():
    model("double-star", "two operators in a row", "V0 + kI**a_I", ["*"], caret=8)
    model("open-parenthesis", "a parenthesis that is not closed", "V0 + (kI*a_I", [")"], caret=12)
    model("stray-parenthesis", "a parenthesis that was not opened", "V0 + kI*a_I)", [")"], caret=11)
    model("unknown-function", "a function that is none", "V0 + kI*sinh(a_I)", ["sinh"], caret=8)
    model("no-operator", "two names without an operator", "V0 + kI a_I", ["a_I"], caret=8)
    model("ends-early", "the line ends where a term belongs", "V0 + kI*", [], caret=8)
    model("stray-character", "a character that is no operator", "V0 + kI\u00b7a_I", ["\u00b7"], caret=7)
    model("empty", "an empty model line", "", ["model"], caret=0)
    model("bad-number", "a number with two points", "V0 + 1.2.3*a_I", [], caret=8)
    model("deep", "10000 nested parentheses", "(" * 10000 + "V0 + kI*a_I" + ")" * 10000, [])
    model("many-signs", "100000 signs in a row", "V0 + " + "-" * 100000 + "kI*a_I", [])


def csv_files():
    lines = CSV.splitlines(keepends=True)
    csv("csv-ragged-short", "a row with too few cells", ["csv-ragged-short.csv"], "".join(lines[:3] + ["180,180\n"] + lines[4:]), 4)
    csv("csv-ragged-long", "a row with too many cells", ["csv-ragged-long.csv"], "".join(lines[:3] + ["180,180,-0.001911,7\n"] + lines[4:]), 4)
    csv("csv-utf-16", "fine: a CSV in UTF-16", [], b"\xff\xfe" + CSV.encode("utf-16-le"), exit=0)
    csv("csv-latin-1", "fine: a CSV in Latin-1", [], CSV.replace("\n90,", "\nS\u00fcd,").encode("latin-1"), exit=0)
    csv("csv-decimal-comma", "fine: decimal commas, cells parted by semicolons, blank rows below as a spreadsheet writes them", [],
        CSV.replace(",", ";").replace(".", ",") + ";;\n;;\n", exit=0)
    csv("csv-both-marks", "numbers with a decimal comma and with a decimal point", ["csv-both-marks.csv", "decimal", "line 4"],
        CSV.replace(",", ";").replace("-0.001911", "-0,001911"), 4)
    csv("csv-comma-among-commas", "a quoted number with a decimal comma where commas part the cells", ["decimal point"],
        CSV.replace("-0.001911", '"-0,001911"'), 4)
    csv("csv-nan", "NaN in a CSV", ["V"], CSV.replace("-0.001911", "NaN"), 4)
    csv("csv-infinity", "an infinity in a CSV", ["V"], CSV.replace("-0.001911", "-inf"), 4)
    csv("csv-overflow", "a CSV number beyond the range of numbers", ["V"], CSV.replace("-0.001911", "1e999"), 4)
    csv("csv-text", "a text in a CSV where a number belongs", ["V"], CSV.replace("-0.001911", "high"), 4)
    csv("csv-empty", "a CSV of no bytes", ["csv-empty.csv"], "")
    csv("csv-header-only", "a CSV without a row", ["csv-header-only.csv"], lines[0])
    csv("csv-missing-joint", "a CSV without the joint's column", ["beta", "position, time_s, V"], CSV.replace("beta_deg", "time_s"))
    csv("csv-duplicate-column", "a CSV with one column twice", ["V"], CSV.replace("position,beta_deg,V", "V,beta_deg,V"), 1, issue=False)
    csv("csv-zero-u", "a zero standard uncertainty in a CSV", ["V_u"], "".join(s.strip() + (",V_u\n" if i == 0 else ",0\n" if i == 2 else ",1e-5\n")
        for i, s in enumerate(lines)), 3)
    csv("csv-binary", "bytes that are no text", ["csv-binary.csv"], bytes(range(256)) * 4, issue=False)
    csv("csv-byte-order-mark", "fine: UTF-8 with a byte order mark, as spreadsheets write it", [], b"\xef\xbb\xbf" + CSV.encode(), exit=0, issue=False)
    csv("csv-crlf", "fine: lines that end in CR LF", [], CSV.replace("\n", "\r\n"), exit=0, issue=False)
    campaign("csv-not-there", "a readings file that is not there", ["no-such-readings.csv"], lambda q: q.update(readings="no-such-readings.csv"))


def files():
    campaign("bench-not-there", "a bench file that is not there", ["no-such.bench.json"], lambda q: q.update(bench="no-such.bench.json"))
    campaign("bench-unknown-id", "a built-in bench that is none", ["gyro-turntabel"], lambda q: q.update(bench="gyro-turntabel"))
    campaign("bench-broken", "the bench file is not JSON", ["broken.bench.json"], lambda q: q.update(bench="broken.bench.json"), reads="broken.bench.json")
    (BAD / "broken.bench.json").write_text('{ "id": "broken",\n  "chain": [ { "joint": "beta" "about": "x" } ]\n}\n')
    INDEX["bench-broken.campaign.json"].update(line=2, line_in="broken.bench.json")
    put("deep-nesting.campaign.json", "[" * 10000 + "]" * 10000, "10000 nested arrays", [])
    put("deep-nesting-inside.campaign.json", '{"bench": ' + '{"bench": ' * 10000 + "1" + "}" * 10001, "10000 nested objects inside a campaign", [])
    good = campaign_text(GOOD)
    put("truncated.campaign.json", good[:200], "a file that ends in the middle", [])
    put("not-json.campaign.json", "beta_deg = 0\nV = 1\n", "no JSON at all", [], "beta_deg")
    put("empty.campaign.json", "", "a file of no bytes", [])
    put("array.campaign.json", "[1, 2, 3]\n", "an array where a campaign belongs", [], "[")
    put("trailing-comma.campaign.json", good.replace('"dtheta_z2": {}}', '"dtheta_z2": {},}'), "a comma before a closing brace", [], "{},}")
    put("utf-16.campaign.json", b"\xff\xfe" + good.encode("utf-16-le"), "a campaign in UTF-16", ["UTF-8"], issue=False)
    put("duplicate-key.campaign.json", good.replace('"V0": {}', '"V0": {}, "V0": {"start": 1}'), "one name twice in an object",
        ["V0"], '"V0": {}', issue=False)


def outcomes():
    campaign("fewer-readings", "not malformed: two readings, three unknowns, a rank defect", ["estimable"],
             lambda q: q.update(readings=q["readings"][:2]), exit=2)
    campaign("rank-defect", "not malformed: only V0 - 1.299*dtheta_y0 is estimable", ["V0", "dtheta_y0"],
             lambda q: q["estimate"].update(dtheta_y0={}), exit=2)
    campaign("no-redundancy", "fine: as many readings as unknowns, no residual to estimate a standard deviation from", [],
             lambda q: q.update(readings=q["readings"][:3]), exit=0, issue=False)
    campaign("good", "fine: the campaign that all others here were made from", [], lambda q: None, exit=0, issue=False)


if __name__ == "__main__":
    BAD.mkdir(parents=True, exist_ok=True)
    for old in BAD.iterdir():
        old.unlink()
    for make in (keys_and_names, values, model_lines, csv_files, files, outcomes):
        make()
    (BAD / "INDEX.json").write_text("{\n" + ",\n".join(f" {json.dumps(k)}: {json.dumps(v, ensure_ascii=False)}" for k, v in INDEX.items()) + "\n}\n")
    print(len(INDEX), "questions")
