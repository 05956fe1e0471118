//! Units drawn at random (gyros, accelerometers or both; cross terms, quadratic terms, temperature, inputs that must be given), exported to C, Python and
//! MATLAB: every language gives the inputs that the program gives, to 1e-12 of the range.
//!
//! 6 units by default; `TUMBLE_LONG=1` draws 500 and prints the largest difference of each language.

use crate::draws::draws;
use crate::hand_held;
use crate::programs::run;
use crate::support::{exact, parse};
use rand_distr::{Distribution, StandardUniform};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use std::fmt::Write;
use std::path::Path;
use tumble::correction::export::{Origin, Target, export};
use tumble::correction::{Calibration, Corrector, Quantity};

/// Samples of each unit.
const SAMPLES: usize = 5;
/// Units that one program holds.
const TOGETHER: usize = 50;

/// Uniform between -1 and 1.
fn number(rng: &mut Pcg64Mcg) -> f64 {
    let share: f64 = StandardUniform.sample(rng);
    2.0 * share - 1.0
}

/// Sensors along the axes x, y, z in any number and order, each with cross terms and a curvature of up to 0.7 of its slope over the range.
fn drawn(rng: &mut Pcg64Mcg) -> Calibration {
    let mut sensors: Vec<(&str, usize)> = vec![("w", 0), ("w", 1), ("w", 2), ("a", 0), ("a", 1), ("a", 2)];
    for k in (1..sensors.len()).rev() {
        sensors.swap(k, ((number(rng) + 1.0) * 0.5 * (k + 1) as f64) as usize % (k + 1));
    }
    sensors.truncate(1 + ((number(rng) + 1.0) * 3.0) as usize % 6);
    let (mut known, mut lines) = (String::new(), Vec::new());
    for (k, (kind, axis)) in sensors.iter().enumerate() {
        let mut term = |name: &str, value: f64| {
            let _ = write!(known, r#""{name}{k}": {{"value": {value}}}, "#);
            format!("{name}{k}")
        };
        let (range, axes) = (if *kind == "w" { 100.0 } else { 2.0 }, ["x", "y", "z"]);
        let slope = (1.0 + 0.5 * number(rng)) * if number(rng) > 0.0 { 1.0 } else { -1.0 } / range;
        let own = format!("{kind}_{}", axes[*axis]);
        let mut line = format!("{}*{own}", term("k", slope));
        for (j, other) in axes.iter().enumerate().filter(|(j, _)| j != axis) {
            if number(rng) > 0.0 {
                line += &format!(" + {}*{kind}_{other}", term(&format!("c{j}_"), 0.05 * slope * number(rng)));
            }
        }
        if number(rng) > -0.5 {
            line += &format!(" + {}*{own}^2", term("q", 0.35 * slope / range * number(rng)));
        }
        if number(rng) > 0.0 {
            let other = if *kind == "w" { "a" } else { "w" };
            let size = 0.02 / if *kind == "w" { 2.0 } else { 100.0 };
            line += &format!(" + {}*{other}_{}*{own}", term("g", size * slope * number(rng)), axes[(axis + 1) % 3]);
        }
        if number(rng) > 0.0 {
            line += &format!(" + {}*(temperature_c - 20)", term("t", 0.01 * number(rng)));
            line += &format!(" + {}*sin({own}/{range})*exp(-temperature_c/50)", term("s", 0.05 * number(rng)));
        }
        lines.push(format!(r#""s{k}": {{"model": "b{k} + {line}"}}"#));
    }
    let estimate: Vec<String> = (0..lines.len()).map(|k| format!(r#""b{k}": {{}}"#)).collect();
    let readings: Vec<String> = (0..lines.len()).map(|k| format!(r#""s{k}": {}"#, number(rng))).collect();
    exact_calibration(&format!(
        r#"{{"bench": {{"id": "drawn", "units": {{"rate": "deg/s", "force": "g"}}, "chain": [{{"joint": "t", "about": "z"}}],
            "sensors": {{{}}}}}, "known": {{{}}}, "estimate": {{{}}},
            "readings": [{{"t_deg": 0, "temperature_c": 25, {}}}]}}"#,
        lines.join(", "),
        known.trim_end_matches(", "),
        estimate.join(", "),
        readings.join(", ")
    ))
}

fn exact_calibration(text: &str) -> Calibration {
    Calibration::of(&exact(&parse(text)))
}

/// A unit with samples of readings and given values, and what the program makes of them (empty where it finds no inputs).
struct Trial {
    calibration: Calibration,
    samples: Vec<(Vec<f64>, Vec<f64>, Vec<f64>)>,
    ranges: Vec<f64>,
}

impl Trial {
    fn of(calibration: Calibration, rng: &mut Pcg64Mcg) -> Self {
        let range = |quantity: Quantity| match quantity {
            Quantity::Rate => 100.0,
            Quantity::Force => 2.0,
            _ => 20.0,
        };
        let corrector = Corrector::new(&calibration).unwrap();
        let mut values = |solved: bool| -> Vec<f64> {
            let own = calibration.inputs.iter().filter(|input| input.solved == solved);
            own.map(|input| range(input.quantity) * number(rng)).collect()
        };
        let samples = (0..SAMPLES).map(|_| {
            let (inputs, given) = (values(true), values(false));
            let readings = corrector.readings(&inputs, &given);
            let corrected = corrector.correct(&readings, &given);
            (readings, given, if corrected.converged { corrected.inputs } else { Vec::new() })
        });
        let samples = samples.collect();
        let ranges = calibration.inputs.iter().filter(|own| own.solved).map(|own| range(own.quantity)).collect();
        Trial { calibration, samples, ranges }
    }

    /// The largest difference of what another program prints (one line for each sample), over the ranges.
    fn difference<'a>(&self, lines: &mut impl Iterator<Item = &'a str>, what: &str) -> f64 {
        let mut largest = 0.0_f64;
        for (_, _, expected) in &self.samples {
            let line = lines.next().unwrap_or_else(|| panic!("{what}: a line is missing"));
            let found: Vec<f64> = line.split_whitespace().map(|word| word.parse().unwrap()).collect();
            assert_eq!(found.len(), expected.len(), "{what}: {line} for {expected:?}");
            for ((found, expected), range) in found.iter().zip(expected).zip(&self.ranges) {
                largest = largest.max((found - expected).abs() / range);
            }
        }
        largest
    }
}

fn list(values: &[f64]) -> String {
    values.iter().map(|v| format!("{v:?}")).collect::<Vec<_>>().join(", ")
}

/// All units in one program of each language; the largest difference of each.
fn differences(trials: &[Trial], folder: &Path) -> Vec<(&'static str, f64)> {
    let (mut c, mut python, mut octave) = (String::from("#include <stdio.h>\n"), String::new(), String::new());
    let (mut body, mut files) = (String::new(), Vec::new());
    for (u, trial) in trials.iter().enumerate() {
        let origin = Origin { prefix: Some(format!("u{u}")), ..Origin::default() };
        for (target, name) in [
            (Target::C, format!("u{u}.c")),
            (Target::CHeader, format!("u{u}.h")),
            (Target::Python, format!("u{u}.py")),
            (Target::Matlab, format!("u{u}_correct.m")),
        ] {
            let text = export(&trial.calibration, target, &origin).unwrap();
            std::fs::write(folder.join(name), text).unwrap();
        }
        files.push(format!("u{u}.c"));
        let _ = writeln!(c, "#include \"u{u}.h\"");
        let _ = writeln!(python, "import u{u}");
        for (readings, given, _) in &trial.samples {
            let given_or_null = if given.is_empty() { "NULL".into() } else { format!("(double[]){{{}}}", list(given)) };
            let _ = writeln!(
                body,
                "    {{ double q[U{u}_INPUTS]; if (u{u}_correct((double[]){{{}}}, {given_or_null}, q) == U{u}_DONE)\n\
                 for (int i = 0; i < U{u}_INPUTS; i++) printf(\"%.17g \", q[i]);\n printf(\"\\n\"); }}",
                list(readings)
            );
            let (readings, given) = (list(readings), list(given));
            let _ = writeln!(
                python,
                "try: print(*map(repr, u{u}.correct([{readings}], [{given}])))\nexcept ArithmeticError: print()"
            );
            let _ = writeln!(
                octave,
                "[q, settled] = u{u}_correct([{readings}], [{given}]); if settled, printf('%.17g ', q); end; printf('\\n');"
            );
        }
    }
    std::fs::write(folder.join("drive.c"), format!("{c}int main(void)\n{{\n{body}    return 0;\n}}\n")).unwrap();
    std::fs::write(folder.join("drive.py"), python).unwrap();
    std::fs::write(folder.join("drive.m"), octave).unwrap();
    let mut found = Vec::new();
    let mut compare = |language: &'static str, text: Option<String>| {
        let Some(text) = text else { return };
        let mut lines = text.lines();
        let largest = trials.iter().map(|trial| trial.difference(&mut lines, language)).fold(0.0, f64::max);
        assert!(lines.next().is_none(), "{language}: more lines than samples");
        found.push((language, largest));
    };
    let flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-O1", "-ffp-contract=off", "drive.c"];
    let files: Vec<&str> = files.iter().map(String::as_str).collect();
    for compiler in ["gcc", "clang"] {
        let compiled = run(compiler, &[&flags[..], &files, &["-o", compiler, "-lm"]].concat(), folder);
        compare(compiler, compiled.and_then(|_| run(folder.join(compiler).to_str().unwrap(), &[], folder)));
    }
    compare("Python", run("python3", &["drive.py"], folder));
    compare("Octave", run("octave-cli", &["--quiet", "drive.m"], folder));
    found
}

#[test]
fn every_language_gives_what_the_program_gives() {
    let mut rng = Pcg64Mcg::seed_from_u64(2911);
    let mut units: Vec<Calibration> = (0..draws(6, 500)).map(|_| drawn(&mut rng)).collect();
    // those that are held by hand
    units.extend([hand_held::by_its_norm().as_str(), hand_held::TURNED].map(exact_calibration));
    let mut all: Vec<Trial> = units.into_iter().map(|unit| Trial::of(unit, &mut rng)).collect();
    let found = all.iter().flat_map(|trial| &trial.samples).filter(|(_, _, inputs)| !inputs.is_empty()).count();
    println!("{} units, {found} of {} samples have inputs", all.len(), SAMPLES * all.len());
    assert!(found as f64 > 0.99 * (SAMPLES * all.len()) as f64);
    let mut largest: Vec<(&str, f64)> = Vec::new();
    while !all.is_empty() {
        let folder = tempfile::tempdir().unwrap();
        let some = all.split_off(all.len().saturating_sub(TOGETHER));
        for (language, difference) in differences(&some, folder.path()) {
            match largest.iter_mut().find(|(own, _)| *own == language) {
                Some((_, own)) => *own = own.max(difference),
                None => largest.push((language, difference)),
            }
        }
    }
    for (language, difference) in &largest {
        println!("{language}: largest difference {difference:.2e} of the range");
        assert!(*difference <= 1e-12, "{language}: {difference:e}");
    }
}

/// Curvature beyond what `q <- q + M (s - f(q))` bears: Newton's steps are in every language, and the inputs are those that made the readings.
#[test]
fn strong_curvature_is_corrected_in_every_language() {
    for (curvature, cubic) in [(0.3, 0.0), (0.6, 0.35)] {
        let calibration = exact_calibration(&format!(
            r#"{{"bench": {{"id": "nl", "chain": [{{"joint": "t", "about": "x"}}],
                "sensors": {{"A": {{"unit": "V", "axes": {{"I": "y"}}, "model": "K0 + K1*a_I + K2*a_I^2 + K3*a_I^3"}}}}}},
                "known": {{"K1": {{"value": 1}}, "K2": {{"value": {curvature}}}, "K3": {{"value": {cubic}}}}},
                "estimate": {{"K0": {{}}}}, "readings": [{{"t_deg": 0, "A": 0.1}}]}}"#
        ));
        let corrector = Corrector::new(&calibration).unwrap();
        let inputs: Vec<f64> = (-20..=20).map(|k| f64::from(k) / 20.0).collect();
        let reading = |a: f64| 0.1 + a + curvature * a * a + cubic * a * a * a;
        let samples = inputs.iter().map(|a| (vec![reading(*a)], Vec::new(), vec![*a])).collect();
        for a in &inputs {
            let own = corrector.correct(&[reading(*a)], &[]);
            assert!(own.converged && (own.inputs[0] - a).abs() < 1e-14, "{a}: {own:?}");
        }
        let folder = tempfile::tempdir().unwrap();
        for (language, difference) in differences(&[Trial { calibration, samples, ranges: vec![1.0] }], folder.path()) {
            // the slope at -1 is 0.4 at least: a unit in the last place of a reading moves the input by 2.5
            assert!(difference < 1e-14, "{language}: {difference:e} at K2/K1 = {curvature}");
        }
    }
}

/// What a user wrote (a serial number, the name of a report) stays within a comment, whatever it holds.
#[test]
fn no_text_leaves_its_comment() {
    let mut calibration = exact_calibration(
        r#"{"bench": {"id": "b", "chain": [{"joint": "t", "about": "x"}], "sensors": {"V": {"axes": {"I": "z"}, "model": "V0 + k*a_I"}}},
            "known": {"k": {"value": 2}}, "estimate": {"V0": {}}, "readings": [{"t_deg": 0, "V": 2.5}]}"#,
    );
    let bad =
        "T\"\"\"\nprint(\"out\")\r\n\u{2028}*/ #error out\n/* \\\n\u{85}error('out')\n%}\n@prefix@ @bias@\u{202e}";
    calibration.lines[0].unit = bad.into();
    calibration.parameters.order.push(bad.into());
    calibration.parameters.values.push(1.0);
    let origin = Origin { program: bad.into(), report: bad.into(), unit: vec![bad.into()], ..Origin::default() };
    for target in [Target::C, Target::Python, Target::Matlab] {
        let text = export(&calibration, target, &origin).unwrap();
        let plain = export(&calibration, target, &Origin::default()).unwrap();
        // one line more for the line about the unit, no other
        assert_eq!(text.lines().count(), plain.lines().count() + 1, "{text}");
        assert!(!text.contains(['\r', '\u{85}', '\u{2028}', '\u{202e}']) && text.contains("@prefix@ @bias@"), "{text}");
    }
    let folder = tempfile::tempdir().unwrap();
    let write = |target, name: &str| {
        std::fs::write(folder.path().join(name), export(&calibration, target, &origin).unwrap()).unwrap();
    };
    write(Target::C, "unit.c");
    write(Target::Python, "unit.py");
    write(Target::Matlab, "tumble_correct.m");
    for compiler in ["gcc", "clang"] {
        run(compiler, &["-std=c99", "-Wall", "-Wextra", "-Werror", "-c", "unit.c"], folder.path());
    }
    for text in [
        run("python3", &["unit.py"], folder.path()),
        run("octave-cli", &["--quiet", "--eval", "tumble_correct('self-test');"], folder.path()),
    ] {
        assert!(text.is_none_or(|text| !text.contains("out")));
    }
    let refused = export(&calibration, Target::C, &Origin { prefix: Some("a b".into()), ..Origin::default() });
    assert!(refused.unwrap_err().to_string().contains("prefix"));
}

/// In C, values that must be given are asked for: without them there is a code, and no numbers.
#[test]
fn c_says_that_values_are_not_given() {
    let calibration = exact_calibration(
        r#"{"bench": {"id": "b", "chain": [{"joint": "t", "about": "x"}],
            "sensors": {"V": {"axes": {"I": "z"}, "model": "V0 + k*a_I + c*(temperature_c - 20)"}}},
            "known": {"k": {"value": 2}, "c": {"value": 0.5}}, "estimate": {"V0": {}},
            "readings": [{"t_deg": 0, "V": 2.5, "temperature_c": 20}]}"#,
    );
    let folder = tempfile::tempdir().unwrap();
    for (target, name) in [(Target::C, "unit.c"), (Target::CHeader, "unit.h")] {
        let text = export(&calibration, target, &Origin::default()).unwrap();
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let main = r#"#include "unit.h"
#include <stdio.h>
int main(void)
{
    double v[1] = {2.5}, hot[1] = {21}, q[1] = {7};
    int code = tumble_correct(v, 0, q);
    printf("%d %d ", code == TUMBLE_NOT_GIVEN, q[0] != q[0]);
    code = tumble_correct(v, hot, q);
    printf("%d %.15g ", code, q[0]);
    code = tumble_correct(v, tumble_otherwise, q);
    printf("%d %.15g\n", code, q[0]);
    return 0;
}
"#;
    std::fs::write(folder.path().join("main.c"), main).unwrap();
    for compiler in ["gcc", "clang"] {
        let flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "main.c", "unit.c", "-o", "main", "-lm"];
        if run(compiler, &flags, folder.path()).is_some() {
            let text = run(folder.path().join("main").to_str().unwrap(), &[], folder.path());
            assert_eq!(text.unwrap(), "1 1 0 0.75 0 1\n", "{compiler}");
        }
    }
}
