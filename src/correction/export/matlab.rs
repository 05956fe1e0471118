//! MATLAB and GNU Octave: one function file.

use super::{Parts, Slot, component, lines_in, number, shared_name, signed};
use crate::algebra::{Function, Language};
use crate::correction::Quantity;

const LANGUAGE: Language = Language {
    number,
    pi: "pi",
    call: |function, x| match function {
        Function::Step => format!("double({x} >= 0)"),
        other => format!("{}({x})", shared_name(other).unwrap_or(other.name())),
    },
    whole_power: |x, n| format!("whole_power({x}, {n})"),
    power: |x, y| format!("({x})^({y})"),
};

fn list(values: &[f64]) -> String {
    values.iter().map(|v| number(*v)).collect::<Vec<_>>().join(", ")
}

fn rows<'a>(rows: impl Iterator<Item = &'a [f64]>) -> String {
    format!("[{}]", rows.map(list).collect::<Vec<_>>().join("; ...\n    "))
}

/// The function file; its function is `tumble_correct`, and so must the file be called.
pub(super) fn write(parts: &Parts<'_>) -> String {
    let matrix: Vec<Vec<f64>> = parts.corrector.matrix().row_iter().map(|r| r.iter().copied().collect()).collect();
    let pick = |force: bool| -> String {
        let all: Vec<Vec<f64>> =
            parts.vectors.iter().map(|v| (if force { v.1 } else { v.0 }).iter().copied().collect()).collect();
        rows(all.iter().map(Vec::as_slice))
    };
    let lines = lines_in(parts, &LANGUAGE, &|slot| match slot {
        Slot::Parameter(name) => format!("p_{name}"),
        Slot::Axis(Quantity::Rate, direction) => component("w", &direction, &|k| format!("({})", k + 1)),
        Slot::Axis(_, direction) => component("a", &direction, &|k| format!("({})", k + 1)),
        Slot::Given(k) => format!("given({})", k + 1),
    });
    let mut text = String::from("function [q, settled] = tumble_correct(readings, given)\n");
    for line in &parts.comment {
        text.push_str(&format!("% {line}\n"));
    }
    text.push_str(
        "%\n% Keep this file as tumble_correct.m. tumble_correct('self-test') checks it against its own samples.\n",
    );
    text.push_str(&format!("otherwise_given = [{}];\n", list(&parts.corrector.fallbacks())));
    text.push_str(&format!(
        "% inputs = matrix * (readings - bias), to first order\nmatrix = {};\n",
        rows(matrix.iter().map(Vec::as_slice))
    ));
    text.push_str("if ischar(readings)\n    self_test(matrix);\n    q = []; settled = true;\n    return\nend\n");
    text.push_str("if nargin < 2\n    given = otherwise_given;\nend\nreadings = readings(:);\n");
    text.push_str(CORRECT);
    text.push_str("function s = lines(q, given)\n% The model lines: readings of all sensors for inputs q.\n");
    for (name, value) in parts.calibration.parameters.iter().zip(&parts.calibration.values) {
        text.push_str(&format!("p_{name} = {};\n", signed(*value)));
    }
    text.push_str(&format!("by_rate = {};\nby_force = {};\n", pick(false), pick(true)));
    text.push_str("values = [q(:); given(:)]';\nw = values * by_rate;\na = values * by_force;\n");
    text.push_str(&format!("s = [{}];\nend\n\n", lines.join("; ...\n     ")));
    text.push_str(HELPERS);
    text.push_str("function self_test(matrix)\n");
    text.push_str(&format!("readings = {};\n", rows(parts.samples.iter().map(|s| s.readings.as_slice()))));
    if parts.given() == 0 {
        text.push_str(&format!("given = zeros({}, 0);\n", parts.samples.len()));
    } else {
        text.push_str(&format!("given = {};\n", rows(parts.samples.iter().map(|s| s.given.as_slice()))));
    }
    text.push_str(&format!("inputs = {};\n", rows(parts.samples.iter().map(|s| s.inputs.as_slice()))));
    text.push_str(SELF_TEST);
    text
}

const CORRECT: &str = "q = zeros(size(matrix, 1), 1);
scale = abs(matrix) * abs(readings);
last = Inf;
settled = false;
for round = 1:60
    change = matrix * (readings - lines(q, given));
    q = q + change;
    if all(abs(change) <= 4 * eps * max(abs(q), scale))
        settled = true;
        break
    end
    if ~(norm(change) < last) && round > 2
        break
    end
    last = norm(change);
end
end

";

const HELPERS: &str = "function p = whole_power(x, n)
p = 1;
for k = 1:abs(n)
    p = p * x;
end
if n < 0
    p = 1 / p;
end
end

";

const SELF_TEST: &str = "for k = 1:size(readings, 1)
    [q, settled] = tumble_correct(readings(k, :), given(k, :));
    fprintf('%.12g ', q(1:end-1));
    fprintf('%.12g\\n', q(end));
    limit = 1000 * eps * max(abs(q), abs(matrix) * abs(readings(k, :)'));
    if ~settled || any(abs(q - inputs(k, :)') > limit)
        error('self-test failed');
    end
end
end
";
