//! Model lines: what is printed reads back, gradients equal differences, hostile text is an error with its place.

mod support;
use proptest::prelude::*;
use tumble::algebra::{Expression, Scratch, Tape};
use tumble::error::Fault;

const NAMES: [&str; 4] = ["V0", "kI", "w_I", "a_S"];
const FUNCTIONS: [&str; 11] = ["sin", "cos", "tan", "asin", "acos", "atan", "sqrt", "abs", "sign", "exp", "step"];

/// Random lines with needless parentheses and spaces.
fn lines() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        4 => prop::sample::select(&NAMES[..]).prop_map(str::to_string),
        2 => (0.01..9.0_f64).prop_map(|x| x.to_string()),
        1 => (0..5_u32).prop_map(|x| x.to_string()),
        1 => prop::sample::select(&[".5", "2.", "1e-3", "2.5E+2", "pi"][..]).prop_map(str::to_string),
    ];
    leaf.prop_recursive(5, 40, 2, |inner| {
        prop_oneof![
            6 => (inner.clone(), prop::sample::select(&[" + ", "-", " - ", "*", " * ", "/", "^"][..]), inner.clone())
                .prop_map(|(a, operator, b)| format!("{a}{operator}{b}")),
            2 => inner.clone().prop_map(|a| format!("( {a})")),
            1 => inner.clone().prop_map(|a| format!("-{a}")),
            2 => (prop::sample::select(&FUNCTIONS[..]), inner).prop_map(|(f, a)| format!("{f}({a} )")),
        ]
    })
}

fn parse(text: &str) -> Expression {
    Expression::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn value(expression: &Expression, inputs: &[f64]) -> f64 {
    Tape::compile(expression, &NAMES).expect("known names").value(inputs, &mut Scratch::default())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_printed_reads_back(line in lines()) {
        let expression = parse(&line);
        let printed = expression.to_string();
        prop_assert_eq!(&parse(&printed), &expression, "{} printed as {}", line, &printed);
        prop_assert_eq!(parse(&printed).to_string(), printed);
    }

    /// Numbers are multiplied out and terms reordered: the canonical line is the same function.
    #[test]
    fn the_canonical_line_is_the_same_function(line in lines(), at in prop::array::uniform4(0.1..2.0_f64)) {
        let expression = parse(&line);
        let canonical = parse(&expression.canonical());
        let (a, b) = (value(&expression, &at), value(&canonical, &at));
        // sums of terms that cancel lose digits, and functions of them more: far from such points only
        let c = value(&expression, &at.map(|x| x * (1.0 + 1e-12)));
        prop_assume!(a.is_finite() && b.is_finite() && (a - c).abs() <= 1e-9 * a.abs());
        prop_assert!((a - b).abs() <= 1e-7 * a.abs(), "{} = {}, {} = {}", line, a, canonical, b);
    }

    /// One spelling whatever the order of factors and summands.
    #[test]
    fn the_canonical_line_forgets_the_order(a in lines(), b in lines()) {
        // a line that multiplies out of range (1/0) would stay as it is
        let (a, b) = (a.replace(['/', '^'], "*"), b.replace(['/', '^'], "*"));
        for operator in ["*", "+"] {
            let (one, other) = (parse(&format!("({a}){operator}({b})")), parse(&format!("({b}){operator}({a})")));
            prop_assert_eq!(one.canonical(), other.canonical());
        }
    }

    #[test]
    fn substitution_is_composition(line in lines(), inner in lines(), at in prop::array::uniform4(0.1..2.0_f64)) {
        let (outer, inner) = (parse(&line), parse(&inner));
        let mut moved = at;
        moved[1] = value(&inner, &at);
        let (a, b) = (value(&outer, &moved), value(&outer.substitute("kI", &inner), &at));
        prop_assert!(a == b || (a.is_nan() && b.is_nan()), "{a} is not {b}");
    }

    /// Any text at all: an expression or an error with a place inside the text, never a panic.
    #[test]
    fn no_text_panics(text in "\\PC{0,60}", line in "[-+*/^().0-9a-zA-Z_ ]{0,60}") {
        for text in [text, line] {
            if let Err(error) = Expression::parse(&text) {
                let (start, length) = error.place().span.expect("a place");
                prop_assert!(start <= text.len() && length > 0, "{text:?}: {start}, {length}");
                prop_assert!(error.expectation().is_some() && error.finding().is_some(), "{}", error);
            }
        }
    }
}

/// Central differences at two steps; where they agree with each other, the gradient agrees with them.
#[test]
fn gradients_equal_central_differences() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let (mut compared, mut skipped) = (0, 0);
    let strategy = (lines(), prop::array::uniform4(0.2..1.5_f64));
    for _ in 0..4000 {
        let (line, at) = strategy.new_tree(&mut runner).expect("a line").current();
        let tape = Tape::compile(&parse(&line), &NAMES).expect("known names");
        let (mut scratch, mut gradient) = (Scratch::default(), [0.0; 4]);
        let middle = tape.gradient(&at, &mut scratch, &mut gradient);
        assert!(middle.to_bits() == tape.value(&at, &mut scratch).to_bits(), "{line}: one value");
        for (k, found) in gradient.iter().enumerate() {
            let mut difference = |h: f64| {
                let mut shifted = |h: f64| {
                    let mut inputs = at;
                    inputs[k] += h;
                    tape.value(&inputs, &mut scratch)
                };
                (shifted(h) - shifted(-h)) / (2.0 * h)
            };
            let (coarse, fine) = (difference(2e-4), difference(1e-4));
            // the error of the finer difference is a third of how far the two differ; rounding adds 1e-16 |f| / h
            let error = (coarse - fine).abs() + 1e-11 * middle.abs();
            if !(fine.is_finite() && found.is_finite() && error <= 1e-3 * fine.abs().max(1e-3)) {
                skipped += 1; // a kink, a jump or a pole nearby
                continue;
            }
            assert!(
                (found - fine).abs() <= 2.0 * error + 1e-9,
                "{line} at {at:?}, d/d{}: {found} is not {fine}",
                NAMES[k]
            );
            compared += 1;
        }
    }
    println!("{compared} derivatives compared, {skipped} skipped near kinks and poles");
    assert!(compared > 3 * skipped);
}

/// Derivatives at the points where differences say nothing are as documented.
#[test]
fn derivatives_at_kinks() {
    for (line, at, expected) in [
        ("abs(kI)", 0.0, 0.0),
        ("abs(kI)", -2.0, -1.0),
        ("sign(kI)", 3.0, 0.0),
        ("step(kI)", 0.0, 0.0),
        ("kI^2", 0.0, 0.0),
        ("kI^1", 0.0, 1.0),
        ("kI^0", 0.0, 0.0),
        ("kI^-1", 2.0, -0.25),
        ("-kI^2", 3.0, -6.0),
        ("2^kI", 0.0, std::f64::consts::LN_2),
    ] {
        let tape = Tape::compile(&parse(line), &["kI"]).expect("one name");
        let mut gradient = [f64::NAN];
        tape.gradient(&[at], &mut Scratch::default(), &mut gradient);
        assert!((gradient[0] - expected).abs() < 1e-15, "{line} at {at}: {}", gradient[0]);
    }
    assert_eq!(value(&parse("sign(V0)"), &[0.0; 4]), 0.0);
    assert_eq!(value(&parse("step(V0)"), &[0.0; 4]), 1.0);
    assert_eq!(value(&parse("2^3^2 - -2^2"), &[0.0; 4]), 516.0);
}

#[test]
fn hostile_text_is_an_error() {
    let thousand = 100_000;
    for (what, text) in [
        ("100k (", "(".repeat(thousand)),
        ("100k )", ")".repeat(thousand)),
        ("100k -", "-".repeat(thousand)),
        ("100k ^", "x^".repeat(thousand)),
        ("100k sin(", "sin(".repeat(thousand)),
        ("1 MB name", "x".repeat(1_000_000)),
        ("1 MB sum", "x+".repeat(500_000) + "x"),
        ("1 MB spaces", " ".repeat(1_000_000)),
        ("19 k of (", "(".repeat(19_000)),
        ("19 k of -", "-".repeat(19_000) + "x"),
        ("19 k of ^", "x^".repeat(9_000) + "x"),
        ("NUL", "V0 + \0".into()),
        ("right to left mark", "V0 \u{202e}+ kI".into()),
        ("full-width plus", "V0 \u{ff0b} kI".into()),
        ("dotless i", "V0 + kı".into()),
        ("emoji", "🙂".into()),
        ("infinite number", "1e999*kI".into()),
    ] {
        let error = Expression::parse(&text).expect_err(what);
        let (start, _) = error.place().span.expect("a place");
        assert!(text.is_char_boundary(start) && error.to_string().len() < 500, "{what}: {error}");
    }
    // long but flat is fine
    let long = "kI*w_I + ".repeat(2000) + "V0";
    assert_eq!(value(&parse(&long), &[0.5, 1.0, 1.0, 0.0]), 2000.5);
}

#[test]
fn errors_say_where_what_was_expected_and_what_was_found() {
    let operand = "a number, a name, a function or '('";
    for (text, span, expected, found) in [
        ("", (0, 1), operand, "nothing"),
        ("V0 + * w_I", (5, 1), operand, "'*'"),
        ("V0 + kI**a_I", (8, 1), operand, "'*'"),
        ("V0 +", (4, 1), operand, "the end of the line"),
        ("2 a", (2, 1), "an operator", "'a'"),
        ("V0 + (kI*a_I", (12, 1), "an operator or ')'", "the end of the line"),
        ("V0 + kI)", (7, 1), "an operator or the end of the line", "')'"),
        ("V0 + sinh(a_I)", (5, 4), "sqrt", "'sinh'"),
        ("V0 + sin", (5, 3), "sin(...)", "'sin'"),
        ("V0 · kI", (3, 2), "an operator", "'·'"),
        ("V0 = kI", (3, 1), "an operator", "'='"),
        ("f(a)", (0, 1), "a function", "'f'"),
        ("sin(a, b)", (5, 1), "an operator or ')'", "','"),
        ("1.2.3", (3, 2), "an operator", "'.3'"),
    ] {
        let error = Expression::parse(text).expect_err(text);
        assert_eq!(error.place().span, Some(span), "{text}: {error}");
        assert!(error.expectation().is_some_and(|e| e.contains(expected)), "{text}: {error}");
        assert_eq!(error.finding(), Some(found), "{text}: {error}");
    }
    let unknown = Tape::compile(&parse("V0 + kI*w_Q"), &NAMES).expect_err("an unknown name");
    assert_eq!((unknown.fault(), unknown.place().span), (Fault::UnknownName, Some((8, 3))));
}
