//! How C, Python and MATLAB write lists, constants and assignments; what surrounds these is in `data/templates/export`.

use super::Target;
use crate::algebra::{self, Function};

pub(super) struct Language {
    pub(super) template: &'static str,
    pub(super) algebra: algebra::Language,
    /// Before every line of a comment, and what must not stand in one.
    pub(super) comment: &'static str,
    pub(super) element: fn(&str, usize) -> String,
    pub(super) element_of_rows: fn(&str, usize, usize) -> String,
    pub(super) parameter: fn(&str) -> String,
    pub(super) constant: fn(&str, &str) -> String,
    pub(super) assignment: fn(&str, &str) -> String,
    pub(super) list: fn(&[f64]) -> String,
    pub(super) rows: fn(&[Vec<f64>]) -> String,
}

impl Language {
    /// The language of a target; `None` for the files of other programs.
    pub(super) fn of(target: Target) -> Option<&'static Language> {
        match target {
            Target::C | Target::CHeader => Some(&C),
            Target::Python => Some(&PYTHON),
            Target::Matlab => Some(&MATLAB),
            Target::Kalibr | Target::Ros => None,
        }
    }
}

/// What every C file begins with after its comment, and the whole of its header.
pub(super) const HEADER: &str = include_str!("../../../data/templates/export/correct.h");

const C: Language = Language {
    template: include_str!("../../../data/templates/export/correct.c"),
    algebra: algebra::Language {
        number: |x| format!("(@prefix@_real){}", number(x)),
        pi: "(@prefix@_real)3.14159265358979323846",
        call: |function, x| match function {
            Function::Sign | Function::Step => format!("@prefix@_{}({x})", function.name()),
            Function::Abs => format!("@PREFIX@_MATH(fabs)({x})"),
            other => format!("@PREFIX@_MATH({})({x})", other.name()),
        },
        ln: |x| format!("@PREFIX@_MATH(log)({x})"),
        atan2: |y, x| format!("@PREFIX@_MATH(atan2)({y}, {x})"),
        whole_power: |x, n| format!("@prefix@_whole_power({x}, {n})"),
        power: |x, y| format!("@PREFIX@_MATH(pow)({x}, {y})"),
    },
    comment: " * ",
    element: |list, k| format!("{list}[{k}]"),
    element_of_rows: |rows, i, j| format!("{rows}[{i}][{j}]"),
    parameter: |name| format!("@prefix@_p_{name}"),
    constant: |name, value| format!("static const @prefix@_real {name} = {value};\n"),
    assignment: |to, value| format!("    {to} = {value};\n"),
    list: |values| enclosed("{", if values.is_empty() { &[0.0] } else { values }, "}"),
    rows: |rows| format!("{{{}}}", rows.iter().map(|row| (C.list)(row)).collect::<Vec<_>>().join(",\n    ")),
};

const PYTHON: Language = Language {
    template: include_str!("../../../data/templates/export/correct.py"),
    algebra: algebra::Language {
        number,
        pi: "math.pi",
        call: |function, x| match function {
            Function::Sign | Function::Step => format!("_{}({x})", function.name()),
            Function::Abs => format!("abs({x})"),
            other => format!("math.{}({x})", other.name()),
        },
        ln: |x| format!("math.log({x})"),
        atan2: |y, x| format!("math.atan2({y}, {x})"),
        whole_power: |x, n| format!("_whole_power({x}, {n})"),
        power: |x, y| format!("math.pow({x}, {y})"),
    },
    comment: "# ",
    element: C.element,
    element_of_rows: C.element_of_rows,
    parameter: |name| format!("P_{name}"),
    constant: |name, value| format!("{name} = {value}\n"),
    assignment: |to, value| format!("    {to} = {value}\n"),
    list: |values| enclosed("[", values, "]"),
    rows: |rows| format!("[{}]", rows.iter().map(|row| (PYTHON.list)(row)).collect::<Vec<_>>().join(",\n    ")),
};

const MATLAB: Language = Language {
    template: include_str!("../../../data/templates/export/correct.m"),
    algebra: algebra::Language {
        number,
        pi: "pi",
        call: |function, x| match function {
            Function::Step => format!("double({x} >= 0)"),
            other => format!("{}({x})", other.name()),
        },
        ln: |x| format!("log({x})"),
        atan2: |y, x| format!("atan2({y}, {x})"),
        whole_power: |x, n| format!("whole_power({x}, {n})"),
        power: |x, y| format!("({x})^({y})"),
    },
    comment: "% ",
    element: |list, k| format!("{list}({})", k + 1),
    element_of_rows: |rows, i, j| format!("{rows}({}, {})", i + 1, j + 1),
    parameter: |name| format!("p_{name}"),
    constant: |name, value| format!("{name} = {value};\n"),
    assignment: |to, value| format!("{to} = {value};\n"),
    list: PYTHON.list,
    rows: |rows| match rows.first() {
        Some(first) if first.is_empty() => format!("zeros({}, 0)", rows.len()),
        _ => {
            let rows: Vec<String> = rows.iter().map(|row| enclosed("", row, "")).collect();
            format!("[{}]", rows.join("; ...\n    "))
        }
    },
};

fn enclosed(open: &str, values: &[f64], close: &str) -> String {
    format!("{open}{}{close}", values.iter().map(|v| number(*v)).collect::<Vec<_>>().join(", "))
}

/// The shortest text that reads back as the same number, with an exponent or a point.
pub(super) fn number(value: f64) -> String {
    format!("{value:?}")
}
