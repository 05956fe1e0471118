//! Python 3, without packages.

use super::{Parts, Slot, component, lines_in, number, shared_name, signed};
use crate::algebra::{Function, Language};
use crate::correction::Quantity;

const LANGUAGE: Language = Language {
    number,
    pi: "math.pi",
    call: |function, x| match function {
        Function::Abs => format!("abs({x})"),
        Function::Sign => format!("_sign({x})"),
        Function::Step => format!("_step({x})"),
        other => format!("math.{}({x})", shared_name(other).unwrap_or(other.name())),
    },
    whole_power: |x, n| format!("_whole_power({x}, {n})"),
    power: |x, y| format!("math.pow({x}, {y})"),
};

pub(super) fn list(values: &[f64]) -> String {
    format!("[{}]", values.iter().map(|v| number(*v)).collect::<Vec<_>>().join(", "))
}

fn rows<'a>(rows: impl Iterator<Item = &'a [f64]>) -> String {
    format!("[{}]", rows.map(list).collect::<Vec<_>>().join(",\n    "))
}

/// The module.
pub(super) fn write(parts: &Parts<'_>) -> String {
    let matrix: Vec<Vec<f64>> = parts.corrector.matrix().row_iter().map(|r| r.iter().copied().collect()).collect();
    let pick = |force: bool| -> String {
        let all: Vec<Vec<f64>> =
            parts.vectors.iter().map(|v| (if force { v.1 } else { v.0 }).iter().copied().collect()).collect();
        rows(all.iter().map(Vec::as_slice))
    };
    let lines = lines_in(parts, &LANGUAGE, &|slot| match slot {
        Slot::Parameter(name) => format!("P_{name}"),
        Slot::Axis(Quantity::Rate, direction) => component("w", &direction, &|k| format!("[{k}]")),
        Slot::Axis(_, direction) => component("a", &direction, &|k| format!("[{k}]")),
        Slot::Given(k) => format!("given[{k}]"),
    });
    let mut text = String::from("\"\"\"");
    for line in &parts.comment {
        text.push_str(&format!("{}\n", line.replace('\\', "\\\\").replace("\"\"\"", "''")));
    }
    text.push_str("\nRun this file to check it against its own test samples.\n\"\"\"\n\nimport math\nimport sys\n\n");
    for (name, value) in parts.calibration.parameters.iter().zip(&parts.calibration.values) {
        text.push_str(&format!("P_{name} = {}\n", signed(*value)));
    }
    text.push_str(&format!(
        "\n# inputs = MATRIX (readings - BIAS), to first order\nBIAS = {}\n",
        list(parts.corrector.bias())
    ));
    text.push_str(&format!("MATRIX = {}\n", rows(matrix.iter().map(Vec::as_slice))));
    text.push_str(&format!(
        "# what stands for the given inputs where none are given\nOTHERWISE = {}\n",
        list(&parts.corrector.fallbacks())
    ));
    text.push_str(&format!("# rate and specific force of one unit of each input (solved ones, then given ones)\nBY_RATE = {}\nBY_FORCE = {}\n", pick(false), pick(true)));
    text.push_str(HELPERS);
    text.push_str(&format!("    return [{}]\n", lines.join(",\n            ")));
    text.push_str(CORRECT);
    text.push_str(&format!("TEST_READINGS = {}\n", rows(parts.samples.iter().map(|s| s.readings.as_slice()))));
    text.push_str(&format!("TEST_GIVEN = {}\n", rows(parts.samples.iter().map(|s| s.given.as_slice()))));
    text.push_str(&format!("TEST_INPUTS = {}\n", rows(parts.samples.iter().map(|s| s.inputs.as_slice()))));
    text.push_str(SELF_TEST);
    text
}

const HELPERS: &str = "

def _sign(x):
    return float((x > 0) - (x < 0))


def _step(x):
    return float(x >= 0)


def _whole_power(x, n):
    power = 1.0
    for _ in range(abs(n)):
        power *= x
    return 1 / power if n < 0 else power


def lines(q, given=OTHERWISE):
    \"\"\"The model lines: readings of all sensors for inputs q.\"\"\"
    w, a = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
    for value, by_rate, by_force in zip(list(q) + list(given), BY_RATE, BY_FORCE):
        for k in range(3):
            w[k] += by_rate[k] * value
            a[k] += by_force[k] * value
";

const CORRECT: &str = "

def correct(readings, given=OTHERWISE):
    \"\"\"Inputs for one sample of readings; ArithmeticError where the iteration does not settle.\"\"\"
    q = [0.0] * len(MATRIX)
    size = [sum(abs(c * s) for c, s in zip(row, readings)) for row in MATRIX]
    last = math.inf
    for step in range(60):
        rest = [s - f for s, f in zip(readings, lines(q, given))]
        change = [sum(c * r for c, r in zip(row, rest)) for row in MATRIX]
        q = [x + dx for x, dx in zip(q, change)]
        if all(abs(dx) <= 4 * sys.float_info.epsilon * max(abs(x), s) for dx, x, s in zip(change, q, size)):
            return q
        length = sum(dx * dx for dx in change)
        if not length < last and step > 1:
            break
        last = length
    raise ArithmeticError(\"the correction does not settle for these readings\")


";

const SELF_TEST: &str = "

def self_test():
    for readings, given, inputs in zip(TEST_READINGS, TEST_GIVEN, TEST_INPUTS):
        q = correct(readings, given)
        print(*(\"%.12g\" % x for x in q))
        for row, x, truth in zip(MATRIX, q, inputs):
            size = max(abs(x), sum(abs(c * s) for c, s in zip(row, readings)))
            if not abs(x - truth) <= 1000 * sys.float_info.epsilon * size:
                raise AssertionError(\"self-test failed\")
    print(\"self-test passed\", file=sys.stderr)


if __name__ == \"__main__\":
    self_test()
";
