//! C99.

use super::{Parts, Slot, component, lines_in, number, shared_name};
use crate::algebra::{Function, Language};
use crate::correction::Quantity;

const LANGUAGE: Language = Language {
    number: |x| format!("(real){}", number(x)),
    pi: "(real)3.14159265358979323846",
    call: |function, x| match function {
        Function::Abs => format!("FABS({x})"),
        Function::Sign => format!("sign({x})"),
        Function::Step => format!("step({x})"),
        other => format!("{}({x})", shared_name(other).unwrap_or(other.name()).to_uppercase()),
    },
    whole_power: |x, n| format!("whole_power({x}, {n})"),
    power: |x, y| format!("POW({x}, {y})"),
};

fn list(values: &[f64]) -> String {
    format!("{{{}}}", values.iter().map(|v| number(*v)).collect::<Vec<_>>().join(", "))
}

fn rows<'a>(rows: impl Iterator<Item = &'a [f64]>) -> String {
    format!("{{{}}}", rows.map(list).collect::<Vec<_>>().join(",\n    "))
}

/// The file.
pub(super) fn write(parts: &Parts<'_>) -> String {
    let (m, n, g) = (parts.calibration.lines.len(), parts.corrector.solved(), parts.given());
    let matrix: Vec<Vec<f64>> = parts.corrector.matrix().row_iter().map(|r| r.iter().copied().collect()).collect();
    let vector = |pick: fn(&(nalgebra::Vector3<f64>, nalgebra::Vector3<f64>)) -> &nalgebra::Vector3<f64>| {
        let all: Vec<Vec<f64>> = parts.vectors.iter().map(|v| pick(v).iter().copied().collect()).collect();
        rows(all.iter().map(Vec::as_slice))
    };
    let lines = lines_in(parts, &LANGUAGE, &|slot| match slot {
        Slot::Parameter(name) => format!("p_{name}"),
        Slot::Axis(Quantity::Rate, direction) => component("w", &direction, &|k| format!("[{k}]")),
        Slot::Axis(_, direction) => component("a", &direction, &|k| format!("[{k}]")),
        Slot::Given(k) => format!("given[{k}]"),
    });
    let mut text = String::from("/*\n");
    for line in &parts.comment {
        text.push_str(&format!(" * {}\n", line.replace("*/", "* /")));
    }
    text.push_str(" *\n * Compile with -DTUMBLE_FLOAT for single precision, with -DTUMBLE_SELF_TEST for a program that checks itself (link with -lm).\n */\n");
    text.push_str("#include <float.h>\n#include <math.h>\n#include <stdio.h>\n\n");
    text.push_str("#ifdef TUMBLE_FLOAT\ntypedef float real;\n#define EPSILON FLT_EPSILON\n");
    let functions = ["fabs", "pow", "sin", "cos", "tan", "asin", "acos", "atan", "sqrt", "exp"];
    for f in functions {
        text.push_str(&format!("#define {} {f}f\n", f.to_uppercase()));
    }
    text.push_str("#else\ntypedef double real;\n#define EPSILON DBL_EPSILON\n");
    for f in functions {
        text.push_str(&format!("#define {} {f}\n", f.to_uppercase()));
    }
    text.push_str("#endif\n\n");
    text.push_str(&format!("enum {{ SENSORS = {m}, INPUTS = {n}, GIVEN = {g} }};\n\n"));
    for (name, value) in parts.calibration.parameters.iter().zip(&parts.calibration.values) {
        text.push_str(&format!("static const real p_{name} = (real){};\n", super::signed(*value)));
    }
    text.push_str(&format!(
        "\n/* inputs = matrix * (readings - bias), to first order */\nstatic const real bias[SENSORS] = {};\n",
        list(parts.corrector.bias())
    ));
    text.push_str(&format!(
        "static const real matrix[INPUTS][SENSORS] = {};\n",
        rows(matrix.iter().map(Vec::as_slice))
    ));
    text.push_str("\n/* Rate and specific force of one unit of each input (solved ones, then given ones). */\n");
    text.push_str(&format!("static const real by_rate[INPUTS + GIVEN][3] = {};\n", vector(|v| &v.0)));
    text.push_str(&format!("static const real by_force[INPUTS + GIVEN][3] = {};\n\n", vector(|v| &v.1)));
    text.push_str(HELPERS);
    text.push_str("/* The model lines: readings s of all sensors for inputs q. */\nstatic void lines(const real q[], const real given[], real s[])\n{\n");
    text.push_str("    real w[3] = {0, 0, 0}, a[3] = {0, 0, 0};\n    int i, k;\n    for (i = 0; i < INPUTS + GIVEN; i++)\n        for (k = 0; k < 3; k++) {\n");
    text.push_str("            const real value = i < INPUTS ? q[i] : given[i - INPUTS];\n            w[k] += by_rate[i][k] * value;\n            a[k] += by_force[i][k] * value;\n        }\n    (void)w; (void)a; (void)given;\n");
    for (k, line) in lines.iter().enumerate() {
        text.push_str(&format!("    s[{k}] = {line};\n"));
    }
    text.push_str("}\n\n");
    text.push_str(CORRECT);
    text.push_str("#ifdef TUMBLE_SELF_TEST\n");
    let count = parts.samples.len();
    text.push_str(&format!("enum {{ SAMPLES = {count} }};\n"));
    text.push_str(&format!(
        "static const real test_readings[SAMPLES][SENSORS] = {};\n",
        rows(parts.samples.iter().map(|s| s.readings.as_slice()))
    ));
    let given: Vec<Vec<f64>> = parts.samples.iter().map(|s| if g == 0 { vec![0.0] } else { s.given.clone() }).collect();
    text.push_str(&format!(
        "static const real test_given[SAMPLES][GIVEN + 1] = {};\n",
        rows(given.iter().map(Vec::as_slice))
    ));
    text.push_str(&format!(
        "static const real test_inputs[SAMPLES][INPUTS] = {};\n",
        rows(parts.samples.iter().map(|s| s.inputs.as_slice()))
    ));
    text.push_str(SELF_TEST);
    text
}

const HELPERS: &str = "static inline real sign(real x) { return (real)((x > 0) - (x < 0)); }
static inline real step(real x) { return (real)(x >= 0); }
static inline real whole_power(real x, int n)
{
    real power = 1;
    int k;
    for (k = 0; k < (n < 0 ? -n : n); k++)
        power *= x;
    return n < 0 ? 1 / power : power;
}

";

const CORRECT: &str = "/* Inputs q for the readings s; returns 0, or -1 where the iteration does not settle. */
int tumble_correct(const real s[], const real given[], real q[])
{
    real at[SENSORS], size[INPUTS], last = (real)INFINITY;
    int round, i, j;
    (void)bias; (void)sign; (void)step; (void)whole_power;
    for (i = 0; i < INPUTS; i++) {
        q[i] = 0;
        size[i] = 0;
        for (j = 0; j < SENSORS; j++)
            size[i] += FABS(matrix[i][j] * s[j]);
    }
    for (round = 0; round < 60; round++) {
        real length = 0;
        int settled = 1;
        lines(q, given, at);
        for (i = 0; i < INPUTS; i++) {
            real change = 0;
            for (j = 0; j < SENSORS; j++)
                change += matrix[i][j] * (s[j] - at[j]);
            q[i] += change;
            length += change * change;
            if (!(FABS(change) <= 4 * EPSILON * (FABS(q[i]) > size[i] ? FABS(q[i]) : size[i])))
                settled = 0;
        }
        if (settled)
            return 0;
        if (!(length < last) && round > 1)
            return -1;
        last = length;
    }
    return -1;
}

";

const SELF_TEST: &str = "
int main(void)
{
    int k, i, failed = 0;
    for (k = 0; k < SAMPLES; k++) {
        real q[INPUTS];
        if (tumble_correct(test_readings[k], test_given[k], q))
            failed = 1;
        for (i = 0; i < INPUTS; i++) {
            real size = 0, error = FABS(q[i] - test_inputs[k][i]);
            int j;
            for (j = 0; j < SENSORS; j++)
                size += FABS(matrix[i][j] * test_readings[k][j]);
            printf(i + 1 < INPUTS ? \"%.12g \" : \"%.12g\\n\", (double)q[i]);
            if (!(error <= 1000 * EPSILON * (size > FABS(q[i]) ? size : FABS(q[i]))))
                failed = 1;
        }
    }
    fprintf(stderr, failed ? \"self-test failed\\n\" : \"self-test passed\\n\");
    return failed;
}
#endif
";
