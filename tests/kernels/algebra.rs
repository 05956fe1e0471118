//! Tapes of model lines: what they keep, and many places at a time.

#[path = "../../src/algebra/mod.rs"]
pub(crate) mod whole;

use whole::{Expression, Scratch, Tape};

#[test]
fn numbers_are_worked_out_once_and_only_used_inputs_are_kept() {
    let line = Expression::parse("x*(2*pi/180)^2 + -1").unwrap();
    let tape = Tape::compile(&line, &["unused", "x"]).unwrap();
    assert_eq!(tape.reads(), [1]);
    // the factor and -1 are the constants, a product and a sum the steps
    let shown = format!("{tape:?}");
    let (_, constants) = shown.split_once("constants: [").unwrap();
    let (constants, steps) = constants.split_once("], steps: ").unwrap();
    let factor = (2.0 * std::f64::consts::PI / 180.0).powi(2);
    assert_eq!(constants, format!("{factor:?}, -1.0"));
    assert_eq!((steps.matches("Binary").count(), steps.matches(['N', 'C', 'P']).count()), (2, 0), "{steps}");
}

/// Every operation, at places where some of its branches differ: the same numbers as one place at a time, to the last bit.
#[test]
fn four_places_are_each_by_itself() {
    let lines = [
        "-x + y*x - x/y + x^2*y^3 - x^-2",
        "sin(x)*cos(y) + tan(x) + asin(x/9) - acos(y/9) + atan(x) + sqrt(abs(x)) + sign(y) + exp(x) + step(y)",
        "atan2(x, y) + abs(x)^y + 2^x + x^0",
        "3",
    ];
    let places = [(0.3, -0.2), (2.0, 1.5), (-1.25, 0.5), (0.7, 3.0)];
    for line in lines {
        let tape = Tape::compile(&Expression::parse(line).unwrap(), &["x", "unused", "y"]).unwrap();
        let mut scratch = Scratch::default();
        let inputs = [places.map(|p| p.0), [0.0; 4], places.map(|p| p.1)];
        // names that do not occur get zero
        let mut gradients = [[0.0; 4]; 3];
        let reads = tape.reads();
        let values = tape.gradient_of(|k| inputs[reads[k]], &mut scratch, |k, own| gradients[reads[k]] = *own);
        for (l, (x, y)) in places.into_iter().enumerate() {
            let mut gradient = [f64::NAN; 3];
            let value = tape.gradient(&[x, 0.0, y], &mut scratch, &mut gradient);
            assert_eq!(value, values[l], "{line}");
            assert_eq!(gradient, gradients.map(|g| g[l]), "{line}");
        }
    }
}

/// The same of lists of places.
#[test]
fn many_places_are_each_by_itself() {
    let lines = [
        "-x + y*x - x/y + x^2*y^3 - x^-2 + x*x - x^0",
        "sin(x)*cos(y) + tan(x) + asin(x/9) - acos(y/9) + atan(x) + sqrt(abs(x)) + sign(y) + exp(x) + step(y)",
        "atan2(x, y) + abs(x)^y + 2^x + x^0 + x^0.5 + 0*x/(y - 1.5)",
        "3",
        "y",
    ];
    const PLACES: usize = 45;
    let x: [f64; PLACES] = std::array::from_fn(|k| 0.3 * k as f64 - 1.25);
    let y: [f64; PLACES] = std::array::from_fn(|k| 1.5 - 0.4 * k as f64);
    for line in lines {
        let tape = Tape::compile(&Expression::parse(line).unwrap(), &["x", "unused", "y"]).unwrap();
        let mut gradients = vec![[f64::NAN; PLACES]; tape.reads().len()];
        let input = |k: usize| if tape.reads()[k] == 0 { x } else { y };
        let values = tape.gradient_of(input, &mut Scratch::default(), |k, bar| gradients[k] = *bar);
        let same = |a: f64, b: f64| a == b || (a.is_nan() && b.is_nan());
        for l in 0..PLACES {
            let mut gradient = [f64::NAN; 3];
            let value = tape.gradient(&[x[l], 0.0, y[l]], &mut Scratch::default(), &mut gradient);
            assert!(same(value, values[l]), "{line}");
            for (slot, own) in tape.reads().iter().zip(&gradients) {
                assert!(same(gradient[*slot], own[l]), "{line} at {}, {}", x[l], y[l]);
            }
        }
    }
}
